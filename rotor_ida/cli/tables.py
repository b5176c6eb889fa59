"""Tables for people, from the same rows that go into JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from rich import box
from rich.table import Table

Row = Mapping[str, object]


def table(
    title: str, rows: Sequence[Row], columns: Sequence[str], *, prefix: str = "", digits: int = 8
) -> Table:
    """Return the named columns of `rows`, numbers to the right, headed without the prefix."""
    drawn = _empty(title)
    for name in columns:
        numeric = all(_is_number(row[name]) for row in rows)
        drawn.add_column(
            name.removeprefix(prefix).replace("_", " "),
            justify="right" if numeric else "left",
            overflow="fold",
            no_wrap=not numeric and name != "message",
        )
    for row in rows:
        drawn.add_row(*(shown(row[name], digits) for name in columns))
    return drawn


def pairs(title: str, entries: Row) -> Table:
    """Return names and values, one pair a line."""
    drawn = _empty(title, header=False)
    drawn.add_column()
    drawn.add_column(overflow="fold")
    for name, value in entries.items():
        drawn.add_row(name.replace("_", " "), shown(value))
    return drawn


def shown(value: object, digits: int = 8) -> str:
    """Return a value as a person reads it: some digits, and a dash for what there is not.

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
    return "-" if value is None or value == "" else str(value)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _empty(title: str, *, header: bool = True) -> Table:
    return Table(
        title=title,
        title_justify="left",
        title_style="bold",
        show_header=header,
        box=box.SIMPLE_HEAD if header else None,
        show_edge=False,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
