"""LabVIEW measurement files (.lvm): a header, then segments of columns with tabs or commas."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.signals.files.columns import Column, Table
from rotor_ida.signals.files.text import lines_of, number_in, read_text, told_apart

FIRST_LINE = "LabVIEW Measurement"
END_OF_HEAD = "***End_of_Header***"
ABSCISSA = "X_Value"
SEPARATORS = {"tab": "\t", "comma": ","}


@dataclass(frozen=True)
class Segment:
    """Columns of one segment.

    Parameters
    ----------
    head : mapping of str to list of str
        Header lines before the columns, such as ``Delta_X``, one cell for each channel.
    names : list of str
        Names of the columns.
    first : int
        Number of the first line of numbers, from 0.
    values : ndarray, shape (rows, columns)
        The numbers, NaN where a cell has none.
    """

    head: Mapping[str, Sequence[str]]
    names: Sequence[str]
    first: int
    values: Values


def read_labview(path: Path) -> Table:
    """Return the columns of a LabVIEW measurement file, segments one after another."""
    lines = lines_of(path)
    if not lines[0].startswith(FIRST_LINE):
        return read_text(path)  # LabVIEW also writes files without a header
    head = _head(lines, path)
    separator = SEPARATORS.get(head.get("Separator", ["Tab"])[0].lower(), "\t")
    comma = head.get("Decimal_Separator", ["."])[0] == ","
    segments = _segments(lines, separator, comma)
    if not segments:
        raise InputError(f"{shown(path)} must contain a segment with the line {ABSCISSA}, got none")
    first = segments[0]
    for segment in segments[1:]:
        if segment.names != first.names:
            raise InputError(
                f"the segments of {shown(path)} must have the same columns, got "
                f"{shown(', '.join(first.names))} and {shown(', '.join(segment.names))}"
            )
    return _table(segments, head.get("X_Columns", ["One"])[0], comma)


def _head(lines: Sequence[str], path: Path) -> dict[str, list[str]]:
    """Return the cells of the header by the first cell of each line."""
    ends = [row for row, line in enumerate(lines[:200]) if line.startswith(END_OF_HEAD)]
    if not ends:
        raise InputError(f"{shown(path)} must have a header that ends in {END_OF_HEAD}, got no end")
    found = {}
    for line in lines[: ends[0]]:
        cells = line.split("\t") if "\t" in line else line.split(",")
        # a decimal comma between commas leaves two empty cells
        found[cells[0]] = [","] if cells[0] == "Decimal_Separator" and not cells[1] else cells[1:]
    return found


def _segments(lines: Sequence[str], separator: str, comma: bool) -> list[Segment]:
    """Return the segments: each has header lines, a line of names, and numbers."""
    segments: list[Segment] = []
    head: dict[str, list[str]] = {}
    row = 0
    while row < len(lines):
        cells = [cell.strip() for cell in lines[row].split(separator)]
        row += 1
        if cells[0] != ABSCISSA:
            head[cells[0]] = cells[1:]
            continue
        end = row
        while end < len(lines) and lines[end].strip():
            end += 1
        names = cells[:-1] if cells[-1] in ("Comment", "") else cells
        body = [line.split(separator)[: len(names)] for line in lines[row:end]]
        segments.append(Segment(head, names, row, _numbers(body, len(names), comma)))
        head, row = {}, end
    return segments


def _numbers(body: Sequence[Sequence[str]], width: int, comma: bool) -> Values:
    """Return the numbers in cells, NaN where there is none."""
    table = np.full((len(body), width), math.nan)
    for row, cells in enumerate(body):
        for place, cell in enumerate(cells):
            table[row, place] = number_in(cell.replace(",", ".") if comma else cell)
    return table


def _table(segments: Sequence[Segment], abscissae: str, comma: bool) -> Table:
    """Return the columns of all segments; the times are one of them."""
    first = segments[0]
    values = np.concatenate([each.values for each in segments])
    rows = np.concatenate([each.first + np.arange(len(each.values)) for each in segments])
    is_time = [name == ABSCISSA for name in first.names]
    if abscissae == "No":
        values[:, 0] = np.concatenate([_times(each, comma) for each in segments])
    kept = list(range(len(first.names)))
    times = [place for place, each in enumerate(is_time) if each]
    if all(np.array_equal(values[:, place], values[:, 0], equal_nan=True) for place in times):
        kept = [place for place in kept if place == 0 or not is_time[place]]
    unit_of_times = "s" if first.head.get("X_Dimension", ["Time"])[0] in ("Time", "") else ""
    units = iter(first.head.get("Y_Unit_Label", []))
    units_of = [unit_of_times if each else next(units, "") for each in is_time]
    names = told_apart([first.names[place] for place in kept])
    columns = {
        name: Column(np.ascontiguousarray(values[:, place]), units_of[place])
        for name, place in zip(names, kept, strict=True)
    }
    return Table(columns, lambda name, row: f"{columns[name].values[row]} in line {rows[row] + 1}")


def _times(segment: Segment, comma: bool) -> Values:
    """Return the times of a segment that gives only its first time and its step."""
    start, step = (
        number_in(cell.replace(",", ".") if comma else cell)
        for cell in (segment.head.get(name, [""])[0] for name in ("X0", "Delta_X"))
    )
    return np.asarray(start + step * np.arange(len(segment.values)), dtype=np.float64)
