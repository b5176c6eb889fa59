"""A PDF of text, sheets and figures."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from rich.console import Console

from rotor_ida.results.sheets import Sheet
from rotor_ida.texts import printable
from rotor_ida.units import UnitSystem

# Size of a page and its margin [point]; letters in a line, lines on a page, size of letters.
WIDTH, HEIGHT, MARGIN = 595.0, 842.0, 42.0
COLUMNS, LINES, SIZE = 146, 98, 5.8


def write_pdf(
    path: Path, foot: str, parts: Sequence[str | Sheet], figures: Sequence[Figure],
    system: UnitSystem = "metric",
) -> None:  # fmt: skip
    """Write pages of A4 with text and sheets, and then the figures, each on a page of its size."""
    lines = [line for part in parts for line in [*_lines(part, system), ""]]
    texts = [lines[first : first + LINES] for first in range(0, len(lines), LINES)]
    with PdfPages(path) as pages:
        for number, text in enumerate(texts, 1):
            pages.savefig(page_of(text, f"{foot}, page {number} of {len(texts)}"))
        for figure in figures:
            pages.savefig(figure)


def page_of(lines: Sequence[str], foot: str) -> Figure:
    """Return a page of lines with letters of one width."""
    page = Figure(figsize=(WIDTH / 72.0, HEIGHT / 72.0))
    step = (HEIGHT - 2.0 * MARGIN) / (LINES + 1) / HEIGHT
    for number, line in enumerate([*lines, *[""] * (LINES - len(lines)), foot], 1):
        page.text(MARGIN / WIDTH, 1.0 - MARGIN / HEIGHT - number * step, line, fontsize=SIZE,
                  family="monospace", parse_math=False)  # fmt: skip
    return page


def _lines(part: str | Sheet, system: UnitSystem) -> list[str]:
    """Return text or a sheet as lines that fit."""
    if isinstance(part, str):
        wrapped = [textwrap.wrap(line, COLUMNS, drop_whitespace=False) or [""]
                   for line in printable(part).splitlines()]  # fmt: skip
        return [line for lines in wrapped for line in lines]
    console = Console(width=COLUMNS, color_system=None, markup=False, emoji=False)
    with console.capture() as shown:
        console.print(part.text(COLUMNS, system))
    return [line.rstrip() for line in shown.get().splitlines()]
