"""Columns of numbers that were found in a file, and the units that are understood."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from rotor_ida import units
from rotor_ida.arrays import Values
from rotor_ida.checks import shown
from rotor_ida.errors import InputError

# Endings by which a file is read as what it is; any other file is text.
ENDINGS = {
    "wav": (".wav",),
    "matlab": (".mat",),
    "hdf5": (".h5", ".hdf5", ".hdf"),
    "npz": (".npz",),
    "uff": (".uff", ".unv", ".uf"),
    "tdms": (".tdms",),
    "labview": (".lvm",),
    "comtrade": (".cfg", ".dat"),
}
# Numbers that are read from one file: 2 GiB of them.
MOST_NUMBERS = 2**28
_BRACKETS = re.compile(
    r"^(.*?)\s*(?:\[\s*(?P<square>[^\]]*?)\s*\]|\(\s*(?P<round>[^)]*?)\s*\))\s*$"
)
_SLASH = re.compile(r"^(.+?)\s*/\s*(\S+)$")


class Column(NamedTuple):
    """Numbers, NaN where a cell held none, and the unit that the file gives, if any."""

    values: Values
    unit: str = ""


@dataclass(frozen=True)
class Table:
    """Columns of a file.

    Parameters
    ----------
    columns : mapping of str to Column
        By their names.
    cell : callable
        Takes a column's name and a row, from 0, and returns in words what is there and where.
    rest : str
        What else the file holds, for a message about a missing column.
    scalars : mapping of str to float
        Single numbers by name, such as the sampling rate.
    """

    columns: Mapping[str, Column]
    cell: Callable[[str, int], str]
    rest: str = ""
    scalars: Mapping[str, float] = field(default_factory=dict)

    def listed(self) -> str:
        """Return the names of the columns, and what else there is."""
        return ", ".join(self.columns) + (f"; and {self.rest}" if self.rest else "")


class Unit(NamedTuple):
    """What a unit is of, the one that its numbers are turned into, and how many of those it is."""

    kind: str
    plain: str
    factor: float


# Lengths stay in their unit, or are turned into the one that stands for them.
_LENGTHS = {"m": "m", "mm": "mm", "um": "um", "nm": "nm", "in": "mm", "mil": "um"}
_VOLTS = {"v": "V", "volt": "V", "volts": "V", "mv": "mV", "millivolts": "mV"}
_NONE = ("1", "-", "")
# Other names of units of speed than those that `rotor_ida.units` knows.
_SPEEDS = {
    **dict.fromkeys(("rad/s", "rad s-1", "s-1", "1/s"), "rad/s"),
    **dict.fromkeys(("rev/min", "u/min"), "rpm"),
    **dict.fromkeys(("rps", "rev/s"), "Hz"),
}
# Those that a message offers, by what they are of.
_OFFERED = {
    "time": ("s", "ms", "us", "min"),
    "angle": ("rad", "deg", "rev"),
    "length": (*_LENGTHS, "V", "mV"),
    "speed": tuple(units.SPEED_UNITS),
}


def unit_called(name: str) -> Unit | None:
    """Return a unit by its name, in whichever case if that is the only one; None if not known.

    Examples
    --------
    >>> unit_called("Mils"), unit_called("furlong")
    (Unit(kind='length', plain='um', factor=25.4), None)
    """
    if name in _NONE:
        return Unit("any", "1", 1.0)
    if volts := _VOLTS.get(name.lower()):
        return Unit("length", volts, 1.0)
    symbol = _SPEEDS.get(name.lower()) or units.symbol_of(name)
    if symbol in units.SPEED_UNITS:
        return Unit("speed", "s-1", units.SPEED_UNITS[symbol])
    for kind, called, plain in (
        ("length", _LENGTHS.get(symbol, ""), _LENGTHS.get(symbol, "")),
        ("time", "s", "s"),
        ("angle", "radian", "rad"),
    ):
        if symbol in _OFFERED[kind]:
            return Unit(kind, called, _ratio(symbol, plain))
    return None


def known_units(kind: str) -> str:
    """Return the units of a kind, one name each, for a message."""
    return ", ".join(_OFFERED[kind])


def _ratio(symbol: str, plain: str) -> float:
    """Return how many of one unit another makes."""
    unit, other = units.UNITS[symbol], units.UNITS[plain]
    return unit._replace(power=unit.power - other.power).in_si("1")


def name_and_unit(name: str) -> tuple[str, str]:
    """Return a name less the unit in it: ``x [um]``, ``x (um)`` or ``x/um``.

    Examples
    --------
    >>> name_and_unit("Speed [rpm]"), name_and_unit("probe (left)")
    (('Speed', 'rpm'), ('probe (left)', ''))
    """
    if "/" in name:
        last = re.split(r"[\s_]+", name)[-1]
        if unit_called(last) is not None:  # omega rad/s is no number of radians in seconds
            return name[: -len(last)].rstrip(" _") or name, last
    if found := _BRACKETS.match(name):
        square, round_ = found["square"], found["round"]
        if square is not None or unit_called(round_) is not None:
            return found[1], square if square is not None else round_
    if (found := _SLASH.match(name)) and unit_called(found[2]) is not None:
        return found[1], found[2]
    return name, ""


def check_size(path: Path, numbers: float, *, possible: float = MOST_NUMBERS) -> None:
    """Raise `InputError` if a file declares more numbers than are read, or than it can hold."""
    most = min(possible, MOST_NUMBERS)
    if not numbers <= most:
        raise InputError(
            f"{shown(path)} must declare at most {most:.6g} numbers for a file of "
            f"{path.stat().st_size} bytes, got {numbers:.6g}"
        )


def one_line(error: Exception) -> str:
    """Return what an error of a library says, in one line of moderate length."""
    said = " ".join(str(error).split()) or type(error).__name__
    return said if len(said) <= 200 else f"{said[:200]} ..."
