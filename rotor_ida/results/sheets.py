"""Sheets: titled rows of quantity, value, unit and note, for a terminal, a page or a PDF."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any, NamedTuple

from rich import box
from rich.console import Group
from rich.table import Table

from rotor_ida.texts import printable
from rotor_ida.units import UnitSystem, number, read_in

# Digits of a quantity with a unit; times of events are known better, and angles in rad are exact.
OF_FIELD = 6
Record = Mapping[str, object]
# The widest cell of a sheet without heads: longer texts are wrapped, also without a terminal.
WIDEST = 100


class Range(tuple[float, ...]):
    """The smallest and the largest of some values, or the first, turning and last of a course."""

    __slots__ = ()


class Interval(NamedTuple):
    """A value between the ends of an interval, which may be unknown."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Line:
    """A quantity: its name, its values in an SI unit, and how many digits they have.

    Text, words and whole numbers have no unit. A note stands behind the values.
    """

    name: str
    values: Sequence[object]
    unit: str = "1"
    digits: int = 8
    note: str = ""

    def said(self, system: UnitSystem, micro: str = "u") -> tuple[str, list[str]]:
        """Return the unit in which the field reads the quantity, and the values in it."""
        unit, parts = read_in(self.unit, list(_floats(self.values)), system=system)
        unit = re.sub("^u", micro, unit)
        of_field = unit and self.unit not in {"s", "rad"}
        digits = min(self.digits, OF_FIELD) if of_field else self.digits
        return unit, [shown(each, digits, parts) for each in self.values]


@dataclass(frozen=True, slots=True)
class Sheet:
    """A title over quantities.

    Parameters
    ----------
    title : str
        What the quantities are of.
    lines : sequence of Line
        The quantities: rows if `heads` are given, else columns.
    heads : sequence of str, optional
        Heads of the columns of values. A single one that is empty is for rows of quantity, value,
        unit and note.
    note : str
        Remark on the quantities.
    """

    title: str
    lines: Sequence[Line]
    heads: Sequence[str] | None = None
    note: str = ""

    def cells(self, system: UnitSystem = "metric", micro: str = "u") -> list[list[str]]:
        """Return the rows of text; the first has the heads, and is empty where there are none."""
        said = [(each, *each.said(system, micro)) for each in self.lines]
        if self.heads is not None and not any(self.heads):
            notes = any(each.note for each in self.lines)
            return [[], *([printable(line.name), *values,
                           unit if any(map(math.isfinite, _floats(line.values))) else "",
                           *[line.note] * notes] for line, unit, values in said)]  # fmt: skip
        titled = [[f"{line.name} [{unit}]" if unit else printable(line.name), *values]
                  for line, unit, values in said]  # fmt: skip
        if self.heads is None:
            return [list(each) for each in zip(*titled, strict=True)]
        return [["", *map(printable, self.heads)], *titled]

    def _numeric(self) -> list[bool]:
        """Return of each column with a head whether it holds numbers, which are to the right."""
        if self.heads is None:
            return [all(map(_is_number, line.values)) for line in self.lines]
        return [False, *[True] * len(self.heads)]

    def text(self, width: int, system: UnitSystem = "metric") -> Group:
        """Return the sheet for a terminal; if it is too wide, as names and values of each row."""
        heads, *rows = self.cells(system)
        if heads and sum(_widths(heads, rows)) > width:
            apart = [[list(pair) for pair in zip(heads, row, strict=True)] for row in rows]
            heads, rows = [], [pair for each in apart for pair in [*each, ["", ""]]][:-1]
        drawn = Table(
            title=printable(self.title), title_justify="left", title_style="bold",
            show_header=bool(heads), box=box.SIMPLE_HEAD if heads else None,
            show_edge=False, pad_edge=False, padding=(0, 1 if heads else 2, 0, 0),
        )  # fmt: skip
        if heads:
            for head, right in zip(heads, self._numeric(), strict=True):
                drawn.add_column(head, justify="right" if right else "left",
                                 no_wrap=head != "message")  # fmt: skip
        for row in rows:
            drawn.add_row(*row)
        for column in drawn.columns:
            column.overflow = "fold"
            column.max_width = None if heads else WIDEST
        return Group(drawn, *filter(None, [self.note]))

    def html(self, system: UnitSystem = "metric") -> str:
        """Return the sheet for a page."""
        heads, *rows = [[re.sub(r"(\d) u(?=[msNJ]\b)", r"\1 µ", escape(each)) for each in row]
                 for row in self.cells(system, "µ")]  # fmt: skip
        body = ["".join(f"<td>{each}</td>" for each in row) for row in rows]
        first = ["".join(f"<th>{each}</th>" for each in heads)] if heads else []
        note = f"<p>{escape(self.note)}</p>" if self.note else ""
        look = "" if heads else ' class="facts"'
        inside = "\n".join(f"<tr>{each}</tr>" for each in [*first, *body])
        return (
            f"<h2>{escape(printable(self.title))}</h2>\n{note}"
            f'<div class="wide"><table{look}>{inside}</table></div>'
        )


Parts = list[str | Sheet]


def facts(title: str, entries: Record | Sequence[Line], note: str = "") -> Sheet:
    """Return rows of quantity, value, unit and note."""
    if isinstance(entries, Mapping):
        entries = [Line(name.replace("_", " "), [value]) for name, value in entries.items()]
    return Sheet(title, entries, [""], note)


def sheets_shown(parts: Parts) -> list[dict[str, Any]]:
    """Return sheets and sentences as data for a page; a sentence has no rows.

    Examples
    --------
    >>> sheets_shown(["Done.", facts("Run", [Line("speed", [100.0], "rad/s")])])
    [{'title': 'Done.', 'rows': [], 'note': ''}, {'title': 'Run', 'rows': [[], ['speed',
    '954.93', 'rpm']], 'note': ''}]
    """
    return [
        {"title": each, "rows": [], "note": ""} if isinstance(each, str)
        else {"title": each.title, "rows": each.cells(micro="µ"), "note": each.note}
        for each in parts
    ]  # fmt: skip


def table(title: str, rows: Sequence[Record], columns: Sequence[str], digits: int = 8) -> Sheet:
    """Return the named columns of rows without units."""
    return Sheet(title, [Line(name.replace("_", " "), [row[name] for row in rows], digits=digits)
                         for name in columns])  # fmt: skip


def shown(value: object, digits: int = 8, parts: float = 1.0) -> str:
    """Return a value as a reader sees it, in a unit given in SI units; a dash if it is missing.

    Examples
    --------
    >>> inf, nan = float("inf"), float("nan")
    >>> shown(0.1 + 0.2), shown(nan), shown(True), shown((10, 0.5)), shown(Range((1.0, 2.0)))
    ('0.3', '-', 'yes', '10 0.5', '1 to 2')
    >>> shown(Interval(2.0, 1.0, 3.5)), shown(Interval(2.0, -inf, 3.0))
    ('2 (1 to 3.5)', '2 (below 3)')
    >>> shown(Interval(2.0, 1.0, inf)), shown(Interval(2.0, -inf, inf))
    ('2 (above 1)', '2 (unknown)')
    >>> shown(Interval(2.0, nan, nan)), shown(Range((1.0, 1.0)))
    ('2', '1')
    """
    if isinstance(value, Interval):
        return _between(*(number(each / parts, digits) for each in value))
    if isinstance(value, Range):
        return " to ".join(dict.fromkeys(number(each / parts, digits) for each in value))
    if isinstance(value, (list, tuple)):
        return " ".join(shown(entry, digits, parts) for entry in value)
    if isinstance(value, float):
        return number(value / parts, digits)
    if isinstance(value, bool):
        value = "yes" if value else "no"
    return "-" if value is None or value == "" else printable(str(value))


def _between(value: str, low: str, high: str) -> str:
    """Return a value with its interval, if it has one, of which an end may be unknown."""
    if "-" in {value, low}:
        return value
    known = low != "-inf", high != "inf"
    words = {(True, True): f"{low} to {high}", (False, True): f"below {high}",
             (True, False): f"above {low}", (False, False): "unknown"}  # fmt: skip
    return f"{value} ({words[known]})"


def _floats(value: object) -> Iterator[float]:
    if isinstance(value, float):
        yield value
    elif isinstance(value, (list, tuple)):
        for each in value:
            yield from _floats(each)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _widths(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> list[int]:
    """Return the least width of each column and the blanks behind: of words if it may wrap."""
    found = []
    for head, *texts in zip(heads, *rows, strict=True):
        words = [word for each in texts for word in each.split()] if head == "message" else texts
        found.append(2 + max(map(len, [head, *words])))
    return [*found[:-1], found[-1] - 2]
