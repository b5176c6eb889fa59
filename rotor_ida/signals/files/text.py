"""Read text tables: numbers with commas, semicolons, tabs or blanks, and perhaps a header."""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.signals.files.clock import is_clock, is_date, seconds_of
from rotor_ida.signals.files.columns import Column, Table, name_and_unit, unit_called

# Lines before the numbers in which instruments describe themselves.
MOST_HEAD = 200
COMMENTS = ("#", "%", "//")
# Markers of a missing number.
MISSING = {"", "-", "--", "---", "na", "n/a", "#n/a", "null", "none"}
# What may be a decimal comma or one between thousands: 1,234 but not 0,234 nor 1,23.
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")
# A sign before a blank and a number.
_LONE_PLUS = re.compile(r"(?<![^\s;,\"])\+ +(?=\.?\d)")
_LONE_SIGN = re.compile(r"(?<![^\s;,\"])([+-]) +(?=\.?\d)")
# What a column beside a clock holds, as a part of a second.
PARTS = {
    **dict.fromkeys(("ms", "msec", "millis", "millisecond", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "µs", "μs", "usec", "micros", "microsecond", "microseconds"), 1e-6),
    **dict.fromkeys(("ns", "nsec", "nanos", "nanosecond", "nanoseconds"), 1e-9),
}
# Digits that follow a decimal comma rather than stand alone: 05 but not 0 nor 5.
_FRACTION = re.compile(r"0\d+")


@dataclass(frozen=True)
class Layout:
    """Format of the lines with numbers, and the position of the first."""

    separator: str | None
    first: int
    width: int
    decimal_comma: bool

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line, without an empty one after a final separator."""
        found = _cells(line, self.separator)
        return found[:-1] if len(found) == self.width + 1 and not found[-1] else found

    def number(self, cell: str) -> float:
        """Return the number in a cell, NaN if there is none."""
        return number_in(cell.replace(",", ".") if self.decimal_comma else cell)


def read_text(path: Path) -> Table:
    """Return the columns of a text."""
    lines = _with_signs_joined(lines_of(path))
    layout = _layout(lines, path)
    names, units = _names(lines[: layout.first], layout, path)
    rows = [
        row
        for row in range(layout.first, len(lines))
        if (line := lines[row].lstrip()) and not line.startswith(COMMENTS)
    ]
    _check_commas(lines, rows, layout, path)
    numbers = _numbers([lines[row] for row in rows], rows, layout, path)
    used = _read_clocks(numbers, [lines[row] for row in rows], layout, names, units)

    def cell(name: str, row: int) -> str:
        held = layout.cells(lines[rows[row]])[names.index(name)]
        return f"{shown(held)} in line {rows[row] + 1}"

    return Table(
        {
            name: Column(np.ascontiguousarray(column), unit)
            for place, (name, column, unit) in enumerate(zip(names, numbers.T, units, strict=True))
            if place not in used
        },
        cell,
    )


def _read_clocks(
    numbers: Values, body: Sequence[str], layout: Layout, names: Sequence[str], units: list[str]
) -> set[int]:
    """Fill in the columns of clock times in seconds; return those of their dates and fractions."""
    first = layout.cells(body[0])
    used: set[int] = set()
    for place in [place for place, cell in enumerate(first) if is_clock(cell)]:
        texts = [layout.cells(line)[place] for line in body]
        are_whole = not any("." in text or "," in text for text in texts)
        beside = [each for each in (place - 1, place + 1) if 0 <= each < len(first)]
        date = next((each for each in beside if is_date(first[each])), None)
        if date is not None:
            texts = [
                f"{layout.cells(line)[date]} {text}" for line, text in zip(body, texts, strict=True)
            ]
            used.add(date)
        numbers[:, place] = seconds_of(texts)
        units[place] = "s"
        after = next((each for each in range(place + 1, len(first)) if each not in used), None)
        part = PARTS.get(re.split(r"[^a-zµμ]+", names[after].lower())[-1]) if after else None
        part = part or PARTS.get(units[after].lower()) if after else None
        if after is None or part is None or not are_whole:
            continue
        fractions = numbers[:, after]
        if (np.isfinite(fractions) & (fractions >= 0.0) & (fractions * part < 1.0)).all():
            numbers[:, place] += (fractions - fractions[0]) * part
            used.add(after)
    return used


def _with_signs_joined(lines: list[str]) -> list[str]:
    """Return lines in which no sign stands apart from its number.

    A lone minus may be a missing number, so only if a lone plus stands before some number.
    """
    if not any("+ " in line and _LONE_PLUS.search(line) for line in lines):
        return lines
    return [_LONE_SIGN.sub(r"\1", line) for line in lines]


def lines_of(path: Path) -> list[str]:
    """Return the lines of a text in UTF-8, UTF-16 with its mark, or Latin-1; at least one."""
    held = path.read_bytes()
    if held.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = held.decode("utf-16", errors="replace")
    elif b"\0" in held[:4096]:
        raise InputError(
            f"{shown(path)} must be text, got other bytes; files of recorders are recognised by "
            "their endings"
        )
    else:
        text = decoded(held)
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def decoded(held: bytes) -> str:
    """Return a text in UTF-8 or Latin-1."""
    try:
        return held.decode("utf-8-sig")
    except UnicodeDecodeError:
        return held.decode("latin-1")


def _layout(lines: Sequence[str], path: Path) -> Layout:
    """Return the format of the numbers: that of lines with numbers only, if there are any."""
    begin = [
        (number, line)
        for number, line in enumerate(lines)
        if line.strip() and not line.lstrip().startswith(COMMENTS)
    ][: MOST_HEAD + 1]
    if not begin:
        raise InputError(f"{shown(path)} must have lines of two numbers or more, got an empty file")
    for alone in (True, False):
        for (number, line), (_, next_line) in zip(begin, [*begin[1:], (0, "")], strict=True):
            for separator in (";", "\t", ",", None):
                cells = _cells(line, separator)
                after = cells if alone else _cells(next_line, separator)
                if _holds_numbers(cells, after, alone):
                    return _layout_from(lines, number, separator, cells)
    raise InputError(
        f"{shown(path)} must have lines of two numbers or more, got none, but {shown(begin[0][1])}"
    )


def _holds_numbers(cells: Sequence[str], after: Sequence[str], alone: bool) -> bool:
    """Return whether cells are numbers, alone or with words in the same places as the next line."""
    kinds = [_kind(cell) for cell in cells]
    if kinds.count("number") < 2:
        return False
    if alone:
        return "word" not in kinds
    return [kind == "word" for kind in kinds] == [_kind(cell) == "word" for cell in after]


def _layout_from(
    lines: Sequence[str], first: int, separator: str | None, cells: Sequence[str]
) -> Layout:
    """Return the format of the lines from the first with numbers on."""
    head = [_cells(_bare(line), separator) for line in lines[:first] if line.strip()]
    ended = not cells[-1] and any(
        len(each) == len(cells) - 1 or (len(each) == len(cells) and not each[-1]) for each in head
    )
    plain = [cell for line in lines[first : first + MOST_HEAD] for cell in _cells(line, separator)]
    point = any("." in cell and not math.isnan(number_in(cell)) for cell in plain)
    comma = any(
        "," in line and (separator != "," or '"' in line) for line in lines[first:]
    ) and not point  # fmt: skip
    return Layout(separator, first, len(cells) - ended, comma)


def _check_commas(lines: Sequence[str], rows: Sequence[int], layout: Layout, path: Path) -> None:
    """Raise `InputError` if commas are ambiguous: decimal or other."""
    if layout.decimal_comma:
        found = (
            (cell, row)
            for row in rows if "," in lines[row]
            for cell in layout.cells(lines[row]) if "," in cell
        )  # fmt: skip
        first = next(found, ("", 0))
        if all(_GROUPED.fullmatch(cell) for cell, _ in (first, *found)):
            raise InputError(
                f"{shown(path)} must show whether its commas are decimal or between thousands, got "
                f"{shown(first[0])} in line {first[1] + 1} and no other kind of number; write "
                "decimal points"
            )
    elif layout.separator == "," and not layout.width % 2:
        begin = {row: layout.cells(lines[row]) for row in rows[:MOST_HEAD]}
        padded = [(row, place) for row, cells in begin.items()
                  for place, cell in enumerate(cells) if _FRACTION.fullmatch(cell)]  # fmt: skip
        has_points = any("." in cell for cells in begin.values() for cell in cells)
        if padded and all(place % 2 for _, place in padded) and not has_points:
            row, place = padded[0]
            raise InputError(
                f"{shown(path)} must not have decimal commas in columns that are separated by "
                f"commas, got {shown(','.join(begin[row][place - 1 : place + 1]))} in line "
                f"{row + 1}; write decimal points, or separate columns by semicolons"
            )


def _numbers(body: Sequence[str], rows: Sequence[int], layout: Layout, path: Path) -> Values:
    """Return a table of the numbers, with NaN in cells without one."""
    plain = [line.replace(",", ".") for line in body] if layout.decimal_comma else body
    if layout.separator != "," or not layout.decimal_comma:
        try:
            found = np.loadtxt(plain, delimiter=layout.separator, ndmin=2, comments=None)
        except ValueError:
            pass  # some cells are not numbers
        else:
            if found.shape[1] == layout.width:
                return np.asarray(found, dtype=np.float64)
    table = np.empty((len(body), layout.width))
    for row, line in enumerate(body):
        cells = layout.cells(line)
        if len(cells) != layout.width:
            raise InputError(
                f"line {rows[row] + 1} of {shown(path)} must contain {layout.width} cells as the "
                f"first with numbers, got {len(cells)} in {shown(line)}"
            )
        table[row] = [layout.number(cell) for cell in cells]
    return table


def _names(head: Sequence[str], layout: Layout, path: Path) -> tuple[list[str], list[str]]:
    """Return names and units of the columns, which are numbered from 1 if they have no names."""
    told = [line for line in head if line.strip()]
    plain = [line for line in told if not line.lstrip().startswith(COMMENTS)]
    fitting: list[list[str]] = []
    for lines in (plain, told):
        cells = [layout.cells(_bare(line)) for line in lines]
        fitting = [each for each in cells if len(each) == layout.width and any(each)]
        if fitting:
            break
    if not fitting and plain and layout.separator and len(_cells(plain[-1], layout.separator)) > 1:
        raise InputError(
            f"line {head.index(plain[-1]) + 1} of {shown(path)} must name the {layout.width} "
            f"columns of the numbers after it, got {shown(plain[-1])}"
        )
    units = [""] * layout.width
    if len(fitting) > 1 and _are_units(fitting[-1]):
        units = [cell.strip("[]() ") for cell in fitting.pop()]
    names = list(fitting[-1]) if fitting else [""] * layout.width
    for place, name in enumerate(names):
        names[place], unit = name_and_unit(name)
        names[place] = names[place] or str(place + 1)
        units[place] = unit or units[place]
    return told_apart(names), units


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether a line contains units: known ones for the first column or for most."""
    bare = [cell.strip("[]() ") for cell in cells]
    known = [cell for cell in bare if cell and unit_called(cell) is not None]
    first = unit_called(bare[0]) if bare[0] else None
    return (first is not None and first.kind == "time") or 2 * len(known) > sum(map(bool, bare))


def told_apart(names: Sequence[str]) -> list[str]:
    """Return names with equal ones numbered: ``x (1)`` and ``x (2)``."""
    count, seen = Counter(names), Counter[str]()
    apart = []
    for name in names:
        seen[name] += 1
        apart.append(f"{name} ({seen[name]})" if count[name] > 1 else name)
    return apart


def _bare(line: str) -> str:
    """Return a line without its comment sign."""
    return line.strip().lstrip("#%/").strip()


def _cells(line: str, separator: str | None) -> list[str]:
    """Return the cells between separators."""
    if '"' in line and separator is not None:
        try:
            cells = next(csv.reader([line.strip("\n")], delimiter=separator))
        except csv.Error as error:
            raise InputError(f"a cell in quotes must be shorter, got {error}") from error
        return [cell.strip() for cell in cells]
    return [cell.strip().strip('"') for cell in line.strip(" ").split(separator)]


def _kind(cell: str) -> str:
    """Return whether a cell is a number, with point or comma, empty, or a word."""
    if cell.lower() in MISSING:
        return "none"
    return "word" if math.isnan(number_in(cell.replace(",", "."))) and cell.lower() != "nan" else (
        "number")  # fmt: skip


def number_in(cell: str) -> float:
    """Return the number in a cell, NaN if there is none.

    Examples
    --------
    >>> number_in("1.5e3"), number_in("1_0"), number_in("\uff11")  # as Python writes it, full width
    (1500.0, nan, nan)
    """
    if cell[:1] in ("+", "-"):  # some write a blank after the sign
        cell = cell[0] + cell[1:].lstrip(" ")
    try:
        return float(cell) if cell.isascii() and "_" not in cell else math.nan
    except ValueError:
        return math.nan
