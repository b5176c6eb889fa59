"""Where results are written: looked at before anything is computed, so that nothing is lost."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from rotor_ida.errors import InputError

OUT_ENDING = ".nc"
FIGURE_ENDINGS = (".png", ".svg")
MOST_PANELS = 12


@dataclass(frozen=True, kw_only=True)
class Targets:
    """The files that a command is to write, each of which can be written.

    Parameters
    ----------
    out : Path or None
        The netCDF archive.
    study : Path or None
        The folder of the study, whose result goes there if `out` is None.
    figure : Path or None
        The figure, without its ending.
    force : bool
        Whether a file that is there may be replaced.
    """

    out: Path | None = None
    study: Path | None = None
    figure: Path | None = None
    force: bool = False


def check_targets(
    *,
    out: str | None = None,
    study: str | None = None,
    figure: str | None = None,
    panels: int = 1,
    force: bool = False,
) -> Targets:
    """Return the files to be written, refusing what cannot be."""
    if figure is not None:
        check_panels(panels)
    return Targets(
        out=None if out is None else _check_out(out, force),
        study=None if study is None else _check_study(study),
        figure=None if figure is None else _check_figure(figure, force),
        force=force,
    )


def check_panels(panels: int) -> int:
    """Return a number of panels that can still be read."""
    if panels > MOST_PANELS:
        raise InputError(
            f"figure can show at most {MOST_PANELS} pairs of zeta and delta0, got {panels}"
        )
    return panels


def _check_out(word: str, force: bool) -> Path:
    if word and Path(word).suffix != OUT_ENDING:
        raise InputError(f"out must end in {OUT_ENDING}, got {word!r}")
    return _check("out", word, force)


def _check_study(word: str) -> Path:
    if not word or "\0" in word:
        raise InputError(f"study must be the path of a folder, got {word!r}")
    return Path(word)


def _check_figure(word: str, force: bool) -> Path:
    path = Path(word)
    if path.suffix not in FIGURE_ENDINGS:
        raise InputError(f"figure must end in {' or '.join(FIGURE_ENDINGS)}, got {word!r}")
    for ending in FIGURE_ENDINGS:
        _check("figure", str(path.with_suffix(ending)), force)
    return path.with_suffix("")


def _check(name: str, word: str, force: bool) -> Path:
    if not word or "\0" in word:
        raise InputError(f"{name} must be the path of a file, got {word!r}")
    path = Path(word)
    if os.path.isdir(path):
        raise InputError(f"{name} must be a file, got the folder {word!r}")
    if not os.path.isdir(path.parent):
        raise InputError(f"{name} must be in a folder that exists, got {word!r}")
    if os.path.exists(path) and not os.path.isfile(path):
        raise InputError(f"{name} must be a file, got the device or pipe {word!r}")
    if os.path.exists(path) and not force:
        raise InputError(f"{name} must not exist unless --force is given, got {word!r}")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{name} must be in a folder that can be written to, got {word!r}")
    return path
