"""Columns of numbers that were found in a file, and the units that are understood."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from rotor_ida import units
from rotor_ida.arrays import Values


class Column(NamedTuple):
    """Numbers, NaN where a cell held none, and the unit that the file tells, if any."""

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
        Says of a column's name and a row, from 0, what stands there and where.
    rest : str
        What else the file holds, for who misses a column.
    """

    columns: Mapping[str, Column]
    cell: Callable[[str, int], str]
    rest: str = ""

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
# Those that a message offers, by what they are of.
_OFFERED = {
    "time": ("s", "ms", "us", "min"),
    "angle": ("rad", "deg", "rev"),
    "length": (*_LENGTHS, "V", "mV"),
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
    symbol = units.symbol_of(name)
    if symbol in _LENGTHS:
        plain = _LENGTHS[symbol]
        return Unit("length", plain, _ratio(symbol, plain))
    if symbol in _OFFERED["time"]:
        return Unit("time", "s", _ratio(symbol, "s"))
    if symbol in _OFFERED["angle"]:
        return Unit("angle", "radian", _ratio(symbol, "rad"))
    return None


def known_units(kind: str) -> str:
    """Return the units of a kind, one name each, for a message."""
    return ", ".join(_OFFERED[kind])


def _ratio(symbol: str, plain: str) -> float:
    """Return how many of one unit another makes."""
    unit, other = units.UNITS[symbol], units.UNITS[plain]
    return unit._replace(power=unit.power - other.power).in_si("1")
