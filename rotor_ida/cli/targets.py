"""Where results are written: looked at before anything is computed, so that nothing is lost."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rotor_ida.errors import ArchiveError, InputError

if TYPE_CHECKING:
    import xarray as xr

FIGURE_SUFFIXES = (".png", ".svg", ".pdf")


@dataclass(frozen=True, kw_only=True)
class Targets:
    """The files that a command is to write, each of which can be written.

    Parameters
    ----------
    out : Path or None
        The netCDF archive.
    figure : Path or None
        The figure.
    force : bool
        Whether a file that is there may be replaced.
    """

    out: Path | None = None
    figure: Path | None = None
    force: bool = False

    def write(self, dataset: xr.Dataset) -> list[str]:
        """Write what is wanted; return a line for each file."""
        import rotor_ida  # noqa: PLC0415
        from rotor_ida.cli.figures import draw  # noqa: PLC0415

        written = []
        if self.out is not None:
            rotor_ida.save(dataset, self.out, overwrite=self.force)
            written.append(f"wrote {self.out}")
        if self.figure is not None:
            draw(dataset, self.figure)
            written.append(f"wrote {self.figure}")
        return written


def check_targets(*, out: str | None = None, figure: str | None = None, force: bool) -> Targets:
    """Return the files to be written, refusing what cannot be."""
    return Targets(
        out=None if out is None else _check("out", out, force),
        figure=None if figure is None else _check_figure(figure, force),
        force=force,
    )


def _check_figure(word: str, force: bool) -> Path:
    path = _check("figure", word, force)
    if path.suffix not in FIGURE_SUFFIXES:
        raise InputError(f"figure must end in {', '.join(FIGURE_SUFFIXES)}, got {word!r}")
    return path


def _check(name: str, word: str, force: bool) -> Path:
    path = Path(word)
    if not word or "\0" in word:
        raise InputError(f"{name} must be the path of a file, got {word!r}")
    if os.path.isdir(path):
        raise InputError(f"{name} must be a file, got the folder {word!r}")
    if not os.path.isdir(path.parent):
        raise InputError(f"{name} must be in a folder that exists, got {word!r}")
    if os.path.exists(path) and not os.path.isfile(path):
        raise InputError(f"{name} must be a file, got the device or pipe {word!r}")
    if os.path.exists(path) and not force:
        raise InputError(f"{name} exists already, got {word!r}; --force replaces it")
    if not os.access(path.parent, os.W_OK):
        raise ArchiveError(f"{name} must be in a folder that can be written to, got {word!r}")
    return path
