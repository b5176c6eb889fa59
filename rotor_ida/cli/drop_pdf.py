"""Pages of A4 as PDF: headings, paragraphs, tables, text of files, and pictures."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import accumulate
from pathlib import Path
from typing import Literal

from matplotlib import image
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.textpath import TextToPath

from rotor_ida.cli.drop_tables import Listed
from rotor_ida.texts import printable

# Size of a page, its margins, and the space between columns [point].
WIDTH, HEIGHT, MARGIN, BETWEEN = 595.0, 842.0, 42.0, 9.0
ROOM = WIDTH - 2.0 * MARGIN
# Size of letters, and of a line over it.
TEXT, HEAD, TITLE, FILE, SPACING = 8.5, 11.5, 17.0, 6.3, 1.5
CELL, SMALLEST_CELL = 7.0, 5.6
# Part of its size to which a picture may shrink, and most letters of the text of a file in a line.
SMALLEST, COLUMNS = 0.7, 128
Family = Literal["sans-serif", "monospace"]


@dataclass
class Sheets:
    """Pages that fill from the top.

    Parameters
    ----------
    foot : str
        The words at the bottom of each page.
    pages : list of Figure
        The pages so far.
    """

    foot: str
    pages: list[Figure] = field(default_factory=list)
    _top: float = HEIGHT

    def heading(self, words: str, size: float = HEAD, *, room: float = 60.0) -> None:
        """Add a heading, which stays with what follows for as long as `room`."""
        self._need(size * SPACING + room)
        self._top += 0.8 * size if self._top > MARGIN else 0.0
        self._line(words, size, bold=True)
        self._top += 0.3 * size

    def paragraph(self, words: str, *, bullet: bool = False) -> None:
        """Add a paragraph."""
        aside = 10.0 if bullet else 0.0
        for number, line in enumerate(_wrapped(words, TEXT, ROOM - aside)):
            self._need(TEXT * SPACING)
            if bullet and not number:
                self._text(MARGIN, "•", TEXT)
            self._line(line, TEXT, aside=aside)
        self._top += 0.3 * TEXT

    def file(self, text: str) -> None:
        """Add the text of a file or a command, as it is."""
        for line in text.splitlines() or [""]:
            for part in textwrap.wrap(line, COLUMNS, drop_whitespace=False) or [""]:
                self._need(FILE * SPACING)
                self._line(part, FILE, family="monospace")
        self._top += TEXT

    def table(self, table: Listed) -> None:
        """Add a table, on one page if it fits there, and in blocks of the columns that fit."""
        rows = [table.heads, *table.rows]
        size, blocks = _fitting(rows)
        height = len(blocks) * size * SPACING * (len(rows) + 1)
        height += TEXT * SPACING * (1 + len(_wrapped(table.note, TEXT, ROOM)))
        self.heading(table.title, room=height if height < HEIGHT - 4.0 * MARGIN else 100.0)
        if table.note:
            self.paragraph(table.note)
        for columns in blocks:
            self._block(rows, columns, size)

    def picture(self, title: str, png: bytes) -> None:
        """Add a picture as wide as the text."""
        pixels = image.imread(io.BytesIO(png))
        height = min(ROOM * pixels.shape[0] / pixels.shape[1], HEIGHT - 4.0 * MARGIN)
        left = HEIGHT - MARGIN - self._top - 3.0 * HEAD * SPACING
        height = left if SMALLEST * height < left < height else height
        self.heading(title, room=height + 10.0)
        width = height * pixels.shape[1] / pixels.shape[0]
        left, bottom = 0.5 * (WIDTH - width), HEIGHT - self._top - height
        ax = self.pages[-1].add_axes(
            (left / WIDTH, bottom / HEIGHT, width / WIDTH, height / HEIGHT), frameon=False
        )
        ax.imshow(pixels, aspect="auto")
        ax.set_axis_off()
        self._top += height + 10.0

    def write(self, path: Path) -> None:
        """Write the pages, with their numbers."""
        with PdfPages(path) as pages:
            for number, page in enumerate(self.pages, 1):
                words = f"{self.foot}, page {number} of {len(self.pages)}"
                page.text(MARGIN / WIDTH, 0.5 * MARGIN / HEIGHT, words, fontsize=FILE,
                          parse_math=False)  # fmt: skip
                pages.savefig(page)

    def _need(self, height: float) -> None:
        """Begin a page if what comes next does not fit."""
        if not self.pages or self._top + height > HEIGHT - MARGIN:
            self.pages.append(Figure(figsize=(WIDTH / 72.0, HEIGHT / 72.0)))
            self._top = MARGIN

    def _line(
        self, words: str, size: float, *, aside: float = 0.0, bold: bool = False,
        family: Family = "sans-serif",
    ) -> None:  # fmt: skip
        self._text(MARGIN + aside, words, size, bold=bold, family=family)
        self._top += size * SPACING

    def _text(
        self, left: float, words: str, size: float, *, bold: bool = False, right: bool = False,
        family: Family = "sans-serif",
    ) -> None:  # fmt: skip
        height = HEIGHT - self._top - size
        self.pages[-1].text(
            left / WIDTH, height / HEIGHT, printable(words), fontsize=size, family=family,
            parse_math=False, weight="bold" if bold else "normal",
            ha="right" if right else "left",
        )  # fmt: skip

    def _block(self, rows: Sequence[Sequence[str]], columns: Sequence[int], size: float) -> None:
        """Add some columns of a table, with its head again on each page."""
        widths = [BETWEEN + _widest(rows, each, size) for each in columns]
        ends = [MARGIN - BETWEEN + each for each in accumulate(widths)]
        for number, row in enumerate(rows):
            if self._top + 2.0 * size * SPACING > HEIGHT - MARGIN:
                self._need(HEIGHT)
                if number:
                    self._row(rows[0], columns, ends, size, bold=True)
            self._row(row, columns, ends, size, bold=not number)
        self._top += size

    def _row(
        self, row: Sequence[str], columns: Sequence[int], ends: Sequence[float], size: float, *,
        bold: bool,
    ) -> None:  # fmt: skip
        """Add a row, and a line under it."""
        for place, (column, end) in enumerate(zip(columns, ends, strict=True)):
            left = MARGIN if place == 0 else end
            self._text(left, row[column], size, bold=bold, right=place > 0)
        self._top += size * SPACING
        low = 1.0 - (self._top - 1.0) / HEIGHT
        rule = Line2D([MARGIN / WIDTH, ends[-1] / WIDTH], [low, low], lw=0.3, color="#b0b0b0")
        self.pages[-1].add_artist(rule)


@cache
def _width(words: str, size: float, *, bold: bool = False) -> float:
    """Return the width of words [point]."""
    letters = FontProperties(size=size, weight="bold" if bold else "normal")
    return float(
        TextToPath().get_text_width_height_descent(printable(words), letters, ismath=False)[0]
    )


def _widest(rows: Sequence[Sequence[str]], column: int, size: float) -> float:
    """Return the width of a column, whose head is bold."""
    return max(_width(row[column], size, bold=not number) for number, row in enumerate(rows))


def _fitting(rows: Sequence[Sequence[str]]) -> tuple[float, list[list[int]]]:
    """Return the size of letters in a table, and its columns in blocks that fit beside each other.

    Each block begins with the first column.

    Examples
    --------
    >>> rows = [["", *(f"bearing {number}" for number in range(20))], ["force", *["1 kN"] * 20]]
    >>> size, blocks = _fitting(rows)
    >>> size, [each[0] for each in blocks], sum(len(each) - 1 for each in blocks)
    (7.0, [0, 0, 0], 20)
    """
    between = BETWEEN * (len(rows[0]) - 1)
    whole = sum(_widest(rows, column, CELL) for column in range(len(rows[0])))
    size = min(CELL, CELL * (ROOM - between) / whole)
    if size >= SMALLEST_CELL:
        return size, [list(range(len(rows[0])))]
    first = _widest(rows, 0, CELL)
    blocks, used = [[0]], first
    for column in range(1, len(rows[0])):
        wide = BETWEEN + _widest(rows, column, CELL)
        if len(blocks[-1]) > 1 and used + wide > ROOM:
            blocks.append([0])
            used = first
        blocks[-1].append(column)
        used += wide
    return CELL, blocks


def _wrapped(words: str, size: float, room: float) -> list[str]:
    """Return words in lines that fit."""
    lines = [""]
    for word in words.split():
        longer = f"{lines[-1]} {word}".strip()
        if _width(longer, size) <= room or not lines[-1]:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines
