"""Figures written whole or not at all, the same to the byte whenever they are drawn again."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import style

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
        If the folder does not exist, or a file is there and `overwrite` is false.

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
    start = Path(stem)
    if not start.parent.is_dir():
        raise InputError(f"stem must be in a folder that exists, got {str(start)!r}")
    paths = [start.with_name(f"{start.name}.{ending}") for ending in _METADATA]
    for path in paths:
        if path.exists() and not overwrite:
            raise InputError(f"stem must not exist unless overwrite is true, got {str(path)!r}")
    with style(), _settled_layout(figure):
        for path in paths:
            _write(figure, path)
    return paths


@contextmanager
def _settled_layout(figure: Figure) -> Iterator[None]:
    """Lay the figure out and hold that, so that no file depends on what was drawn before it."""
    engine = figure.get_layout_engine()
    if engine is not None:
        for _ in range(2):
            engine.execute(figure)
    figure.set_layout_engine("none")
    try:
        yield
    finally:
        figure.set_layout_engine(engine)


def _write(figure: Figure, path: Path) -> None:
    ending = path.suffix[1:]
    part = path.with_name(f".{secrets.token_hex(8)}.rotor_ida-part")
    canvas = FigureCanvasAgg if ending == "png" else FigureCanvasSVG
    before = figure.canvas
    try:
        with part.open("wb") as file:
            canvas(figure).print_figure(
                file, format=ending, dpi=_DOTS_PER_INCH, metadata=_METADATA[ending]
            )
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    finally:
        figure.set_canvas(before)
        part.unlink(missing_ok=True)
