"""Write figures atomically and reproducibly, byte for byte."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from matplotlib.backend_bases import FigureCanvasBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from rotor_ida.checks import check_choice
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import places_of, put_axes, style
from rotor_ida.results.files import check_path, check_target, file_to_write

# Metadata that depend on the date or the version are left out.
_METADATA: dict[str, dict[str, None]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
_CANVASES: dict[str, Callable[[Figure], FigureCanvasBase]] = {
    "png": FigureCanvasAgg,
    "svg": FigureCanvasSVG,
    "pdf": FigureCanvasPdf,
}
_DOTS_PER_INCH = 200


def save_figure(
    figure: Figure, stem: str | os.PathLike[str], *, overwrite: bool = False,
    formats: str | Sequence[str] = ("png", "svg"),
) -> list[Path]:  # fmt: skip
    """Write a figure as PNG (200 dots per inch), SVG or PDF.

    Parameters
    ----------
    figure : Figure
        The figure.
    stem : path-like
        Path without an ending such as ``.png``. The folder must exist.
    overwrite : bool
        Whether existing files may be replaced.
    formats : {"png", "svg", "pdf"} or sequence of these
        Formats to write; default: PNG and SVG.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to, a file exists and `overwrite` is
        false, or a format is none of these.
    ArchiveError
        If the system refuses to write the files, for example on a full disk.

    Examples
    --------
    >>> import tempfile
    >>> from rotor_ida.plot import panels
    >>> figure, _ = panels(1, 1, width=1.0, height=1.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in save_figure(figure, folder + "/empty")]
    ['empty.png', 'empty.svg']
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in save_figure(figure, folder + "/empty", formats="pdf")]
    ['empty.pdf']
    """
    if not isinstance(figure, Figure):
        raise InputError(f"figure must be a matplotlib Figure, got {type(figure).__name__}")
    start = check_path("stem", stem)
    endings = [
        check_choice("formats", each, tuple(_METADATA))
        for each in ([formats] if isinstance(formats, str) else formats)
    ]
    paths = [
        check_target("stem", start.parent / f"{start.name}.{ending}", overwrite=overwrite)
        for ending in endings
    ]
    with style(), _settled_layout(figure):
        for path in paths:
            with file_to_write(path, overwrite=overwrite) as part:
                _draw(figure, part)
    return paths


@contextmanager
def _settled_layout(figure: Figure) -> Iterator[None]:
    """Fix the layout, so that no file depends on what was drawn before."""
    engine = figure.get_layout_engine()
    if engine is not None:
        for _ in range(2):
            engine.execute(figure)
        # the last digits change with each pass, and clip names in an SVG are hashes of them
        put_axes(figure, places_of(figure).round(9))
    figure.set_layout_engine("none")
    try:
        yield
    finally:
        figure.set_layout_engine(engine)


def _draw(figure: Figure, path: Path) -> None:
    """Write a figure whose layout is settled, so without the draw by which others solve it."""
    ending = path.suffix[1:]
    canvas, dots = figure.canvas, figure.dpi
    try:
        # by the method of the format itself, as `print_figure` draws every figure twice
        write = getattr(_CANVASES[ending](figure), f"print_{ending}")
        figure.dpi = _DOTS_PER_INCH
        write(path, metadata=_METADATA[ending])
    finally:
        figure.dpi = dots
        figure.set_canvas(canvas)
