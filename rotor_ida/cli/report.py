"""Reports of commands: a record for programs, lines and tables for people."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TextIO

from rich import box
from rich.console import Console, RenderableType
from rich.table import Column, Table

from rotor_ida.texts import printable

FAILED, INTERRUPTED = 1, 130
# Wide enough to avoid line breaks when the output is a file or a pipe, unless COLUMNS is set.
NO_TERMINAL_WIDTH = 10_000
# Blanks between the columns of a table.
BETWEEN = 2
# Rows of a table of a whole run or archive; all are printed with --json.
FIRST_ROWS = 10

Record = Mapping[str, object]


@dataclass(frozen=True, kw_only=True)
class Report:
    """The answer of a command.

    The record is for programs (what JSON can hold, and NaN), the parts are for people. Trouble, if
    the run or the check failed, is one line for standard error, with its exit status.
    """

    record: Record
    parts: Sequence[RenderableType]
    as_json: bool = False
    trouble: str = ""
    status: int = FAILED


def console_on(stream: TextIO) -> Console:
    """Return a console without markup or highlighting."""
    return Console(file=stream, highlight=False, markup=False, emoji=False)


def text_of(report: Report, console: Console) -> str:
    """Return the text of a report.

    rich does not write it: it would end the program when the reader of a pipe closes.
    """
    if report.as_json:
        return json.dumps(plain(report.record), allow_nan=False, indent=2) + "\n"
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = NO_TERMINAL_WIDTH
    with console.capture() as shown:
        for part in report.parts:
            words = printable(part) if isinstance(part, str) else part
            console.print(_fitting(words, console))
    return shown.get()


def plain(value: object) -> object:
    """Return a value for JSON; a non-finite number becomes null.

    Examples
    --------
    >>> plain({"exit_time": float("nan"), "start": (1, 0.5)})
    {'exit_time': None, 'start': [1, 0.5]}
    """
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def table(
    title: str, rows: Sequence[Record], columns: Sequence[str], *, prefix: str = "",
    digits: int = 8, are_words: bool = True,
) -> Table:  # fmt: skip
    """Return the named columns of `rows`, numbers to the right, headed without the prefix.

    Underscores of heads become blanks if they are words, not names of a user.
    """
    drawn = _empty(title)
    for name in columns:
        numeric = all(_is_number(row[name]) for row in rows)
        head = name.removeprefix(prefix)
        drawn.add_column(
            printable(head.replace("_", " ") if are_words else head),
            justify="right" if numeric else "left",
            overflow="fold",
            no_wrap=name != "message",
        )
    for row in rows:
        drawn.add_row(*(shown(row[name], digits) for name in columns))
    return drawn


def pairs(title: str, entries: Record) -> Table:
    """Return names and values, one pair a line."""
    drawn = _empty(title, header=False)
    drawn.add_column()
    drawn.add_column(overflow="fold")
    for name, value in entries.items():
        drawn.add_row(printable(name.replace("_", " ")), shown(value))
    return drawn


def shown(value: object, digits: int = 8) -> str:
    """Return a value for people: some digits, and a dash for a missing value.

    Examples
    --------
    >>> shown(0.1 + 0.2), shown(float("nan")), shown(True), shown((10, 0.5))
    ('0.3', '-', 'yes', '10 0.5')
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return "-" if math.isnan(value) else f"{value:.{digits}g}"
    if isinstance(value, (list, tuple)):
        return " ".join(shown(entry, digits) for entry in value)
    return "-" if value is None or value == "" else printable(str(value))


def _fitting(part: RenderableType, console: Console) -> RenderableType:
    """Return a table that is too wide as names and values of each row, else unchanged."""
    if not isinstance(part, Table) or not part.show_header:
        return part
    needed = sum(map(_least_width, part.columns)) + BETWEEN * (len(part.columns) - 1)
    if needed <= console.width:
        return part
    names = [column.header for column in part.columns]
    drawn = _empty(str(part.title), header=False)
    drawn.add_column(overflow="fold")
    drawn.add_column(overflow="fold")
    for number, row in enumerate(zip(*(column.cells for column in part.columns), strict=True)):
        if number:
            drawn.add_row()
        for name, cell in zip(names, row, strict=True):
            drawn.add_row(name, cell)
    return drawn


def _least_width(column: Column) -> int:
    """Return the least width of a column: of its longest line, or word if it may wrap."""
    texts = [str(column.header), *map(str, column.cells)]
    if not column.no_wrap:
        texts = [word for text in texts for word in text.split()]
    return max(map(len, texts), default=0)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _empty(title: str, *, header: bool = True) -> Table:
    return Table(
        title=printable(title),
        title_justify="left",
        title_style="bold",
        show_header=header,
        box=box.SIMPLE_HEAD if header else None,
        show_edge=False,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
