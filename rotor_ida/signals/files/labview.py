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
from rotor_ida.signals.files.clock import is_clock, seconds_of
from rotor_ida.signals.files.columns import Column, Table, with_clock
from rotor_ida.signals.files.text import lines_of, number_in, read_text, told_apart

FIRST_LINE = "LabVIEW Measurement"
END_OF_HEAD = "***End_of_Header***"
ABSCISSA = "X_Value"
BEGIN_SPECIAL, END_SPECIAL = "***Start_Special***", "***End_Special***"
# What is no time but what spectra are over.
OTHER_DIMENSIONS = {"Frequency"}
# Words that are numbers, or none.
NO_TAGS = {"nan", "inf", "infinity"}
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
    rows : list of int
        Numbers of the lines with numbers, from 0.
    values : ndarray, shape (rows, columns)
        The numbers, NaN where a cell has none.
    """

    head: Mapping[str, Sequence[str]]
    names: Sequence[str]
    rows: Sequence[int]
    values: Values

    def cell(self, tag: str, channel: int) -> str:
        """Return the cell of a channel in a header line, empty if there is none."""
        cells = self.head.get(tag, ())
        return cells[channel].strip() if channel < len(cells) else ""

    def places(self) -> list[int]:
        """Return the columns of the channels."""
        return [place for place, name in enumerate(self.names) if name != ABSCISSA]


def read_labview(path: Path) -> Table:
    """Return the columns of a LabVIEW measurement file, segments one after another."""
    lines = lines_of(path)
    if not lines[0].startswith(FIRST_LINE):
        return read_text(path)  # LabVIEW also writes files without a header
    head, first = _head(lines, path)
    separator = SEPARATORS.get(head.get("Separator", ["Tab"])[0].lower(), "\t")
    comma = head.get("Decimal_Separator", ["."])[0] == ","
    segments = _segments(lines, first, separator, comma, path)
    if not segments:
        raise InputError(f"{shown(path)} must contain a segment with the line {ABSCISSA}, got none")
    for segment in segments[1:]:
        if segment.names != segments[0].names:
            raise InputError(
                f"the segments of {shown(path)} must have the same columns, got "
                f"{shown(', '.join(segments[0].names))} and {shown(', '.join(segment.names))}"
            )
    return _table(segments, head.get("X_Columns", ["One"])[0], comma, path)


def _head(lines: Sequence[str], path: Path) -> tuple[dict[str, list[str]], int]:
    """Return the cells of the header by the first cell of each line, and the line after it."""
    ends = [row for row, line in enumerate(lines[:200]) if line.startswith(END_OF_HEAD)]
    if not ends:
        raise InputError(f"{shown(path)} must have a header that ends in {END_OF_HEAD}, got no end")
    found = {}
    for line in lines[: ends[0]]:
        cells = line.split("\t") if "\t" in line else line.split(",")
        # a decimal comma between commas leaves two empty cells
        found[cells[0]] = [","] if cells[0] == "Decimal_Separator" and not cells[1] else cells[1:]
    return found, ends[0] + 1


def _segments(
    lines: Sequence[str], row: int, separator: str, comma: bool, path: Path
) -> list[Segment]:
    """Return the segments: each has header lines, a line of names, and numbers."""
    segments: list[Segment] = []
    head: dict[str, list[str]] = {}
    tagged = -1  # the last line that is neither blank nor in a segment
    while row < len(lines):
        cells = [cell.strip() for cell in lines[row].split(separator)]
        row += 1
        if cells[0] == BEGIN_SPECIAL:
            while row < len(lines) and not lines[row - 1].startswith(END_SPECIAL):
                row += 1
        elif cells[0] != ABSCISSA:
            head[cells[0]] = cells[1:]
            tagged = row - 1 if lines[row - 1].strip() else tagged
        else:
            names = cells[:-1] if cells[-1] in ("Comment", "") else cells
            rows = []
            while row < len(lines) and not _is_tag(lines[row].split(separator)[0]):
                rows += [row] if lines[row].strip() else []
                row += 1
            body = [lines[each].split(separator)[: len(names)] for each in rows]
            segments.append(Segment(head, names, rows, _numbers(body, len(names), comma)))
            head, tagged = {}, -1
    if segments and tagged >= 0:
        raise InputError(
            f"line {tagged + 1} of {shown(path)} must contain numbers, or belong to the header of "
            f"a segment, got {shown(lines[tagged])}"
        )
    return segments


def _is_tag(cell: str) -> bool:
    """Return whether a cell begins a line of a header: a word and no number."""
    word = cell.strip()
    return bool(word) and (word[0].isalpha() or word[0] == "*") and word.lower() not in NO_TAGS


def _numbers(body: Sequence[Sequence[str]], width: int, comma: bool) -> Values:
    """Return the numbers in cells, NaN where there is none."""
    rows = [[*cells, *[""] * (width - len(cells))] for cells in body]
    return np.array([[_number(cell, comma) for cell in cells] for cells in rows]).reshape(-1, width)


def _number(cell: str, comma: bool) -> float:
    """Return the number in a cell, NaN if there is none."""
    return number_in(cell.replace(",", ".") if comma else cell)


def _table(segments: Sequence[Segment], abscissae: str, comma: bool, path: Path) -> Table:
    """Return the channels of all segments, each with its times."""
    first = segments[0]
    names = told_apart([ABSCISSA, *(first.names[place] for place in first.places())])
    columns: dict[str, Column] = {}
    lines: dict[str, Sequence[int]] = {}
    rest = []
    for channel, name in enumerate(names[1:]):
        over = first.cell("X_Dimension", channel) or "Time"
        if over in OTHER_DIMENSIONS:
            rest.append(f"{name} (over {over})")
            continue
        parts = [_part(each, channel, abscissae, comma, path) for each in segments]
        values, times = (np.concatenate(each) for each in zip(*parts, strict=True))
        columns[name] = Column(values, first.cell("Y_Unit_Label", channel), times)
        lines[name] = [row for each, part in zip(segments, parts, strict=True)
                       for row in each.rows[: part[0].size]]  # fmt: skip
    if not columns:
        raise InputError(f"{shown(path)} must contain channels over time, got {rest or 'none'}")
    is_time = first.cell("X_Dimension", 0) in ("Time", "")
    found = with_clock(columns, "s" if is_time else "", ABSCISSA)
    longest = max(lines.values(), key=len)

    def cell(name: str, row: int) -> str:
        return f"{found[name].values[row]} in line {lines.get(name, longest)[row] + 1}"

    return Table(found, cell, ", ".join(rest))


def _part(
    segment: Segment, channel: int, abscissae: str, comma: bool, path: Path
) -> tuple[Values, Values]:
    """Return the numbers of a channel in a segment, and their times."""
    places, rows = segment.places(), len(segment.rows)
    declared = [_number(segment.cell("Samples", each), comma) for each in range(len(places))]
    most = max((each for each in declared if each > 0.0), default=float(rows))
    first = next((n for n, each in enumerate(declared) if each == most), 0)
    clocks = [
        [_number(segment.cell(tag, each), comma) for tag in ("X0", "Delta_X")]
        for each in (first, channel)
    ]
    late = _start(segment, channel) - _start(segment, first)
    has_times = abscissae == "Multi" or (
        abscissae == "One" and not late and np.array_equal(clocks[0], clocks[1], equal_nan=True)
    )
    if rows < most or (rows > most and not has_times):
        raise InputError(
            f"{shown(path)} must contain the {most:.6g} samples that the segment at line "
            f"{segment.rows[0] + 1 if rows else 1} declares, got {rows}"
        )
    size = rows if not declared[channel] < most else int(declared[channel])
    if not has_times:
        start, step = clocks[1]
        times = late + start + step * np.arange(size)
    else:
        before = places[channel] - 1 if abscissae == "Multi" else segment.names.index(ABSCISSA)
        times = segment.values[:size, before] + (late if abscissae == "Multi" else 0.0)
    return segment.values[:size, places[channel]], np.asarray(times, dtype=np.float64)


def _start(segment: Segment, channel: int) -> float:
    """Return the time at which a channel starts after the first of its segment [s]."""
    stamps = [
        " ".join(filter(None, (segment.cell(tag, each) for tag in ("Date", "Time"))))
        for each in (0, channel)
    ]
    late = float(seconds_of(stamps)[1]) if all(map(is_clock, stamps)) else 0.0
    return 0.0 if math.isnan(late) else late
