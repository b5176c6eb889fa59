"""Figures written whole or not at all, the same to the byte whenever they are drawn again."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.plot.appearance import style
from rotor_ida.results.files import already_there, check_path, check_target, written_whole

# What would change from day to day or from version to version is left out.
_METADATA: dict[str, dict[str, None]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
}
_DOTS_PER_INCH = 200


def save_figure(
    figure: Figure, stem: str | os.PathLike[str], *, overwrite: bool = False
) -> list[Path]:
    """Write a figure as PNG (200 dots per inch) and SVG.

    Parameters
    ----------
    figure : Figure
        The figure.
    stem : path-like
        Where to write, without the endings ``.png`` and ``.svg``. The folder must exist.
    overwrite : bool
        Whether files that are there may be replaced.

    Returns
    -------
    list of Path
        The two files.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to, or a file is there and `overwrite` is
        false.
    ArchiveError
        If the system does not let the files be written: a full disk, for example.

    Examples
    --------
    >>> import tempfile
    >>> from rotor_ida.plot import panels
    >>> figure, _ = panels(1, 1, width=1.0, height=1.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in save_figure(figure, folder + "/empty")]
    ['empty.png', 'empty.svg']
    """
    if not isinstance(figure, Figure):
        raise InputError(f"figure must be a matplotlib Figure, got {type(figure).__name__}")
    start = check_path("stem", stem)
    paths = [
        check_target("stem", start.parent / f"{start.name}.{ending}", overwrite=overwrite)
        for ending in _METADATA
    ]
    with style(), _settled_layout(figure):
        for path in paths:
            try:
                with written_whole(path, overwrite=overwrite) as part:
                    _draw(figure, part)
            except FileExistsError:
                raise already_there("stem", path) from None
            except OSError as error:
                raise ArchiveError(f"cannot write {path}: {error.strerror or error}") from error
    return paths


@contextmanager
def _settled_layout(figure: Figure) -> Iterator[None]:
    """Lay the figure out and hold that, so that no file depends on what was drawn before it."""
    engine = figure.get_layout_engine()
    if engine is not None:
        for _ in range(2):
            engine.execute(figure)
        _round_positions(figure)
    figure.set_layout_engine("none")
    try:
        yield
    finally:
        figure.set_layout_engine(engine)


def _round_positions(figure: Figure) -> None:
    """Take off the last digits of where the axes stand.

    They change each time that the layout is solved, and a clip's name in an SVG is a hash of all
    of them.
    """
    for ax in figure.axes:
        if ax.get_in_layout():
            place = ax.get_position(original=True)
            ax.set_position(Bbox(place.get_points().round(9)), which="original")
            ax.set_in_layout(True)


def _draw(figure: Figure, path: Path) -> None:
    ending = path.suffix[1:]
    canvas = FigureCanvasAgg if ending == "png" else FigureCanvasSVG
    before = figure.canvas
    try:
        canvas(figure).print_figure(
            path, format=ending, dpi=_DOTS_PER_INCH, metadata=_METADATA[ending]
        )
    finally:
        figure.set_canvas(before)
