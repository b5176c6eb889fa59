"""Columns of numbers that were found in a file, and the units that are understood."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

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


UNITS = {
    name: Unit(kind, plain, factor)
    for kind, plain, factor, names in (
        ("time", "s", 1.0, ("s", "sec", "secs", "second", "seconds")),
        ("time", "s", 1e-3, ("ms", "msec", "milliseconds")),
        ("time", "s", 1e-6, ("us", "µs", "μs", "usec", "microseconds")),
        ("time", "s", 60.0, ("min", "minutes")),
        ("angle", "radian", 1.0, ("rad", "radian", "radians")),
        ("angle", "radian", math.pi / 180.0, ("deg", "°", "degree", "degrees")),
        ("angle", "radian", 2.0 * math.pi, ("rev", "revolutions", "turns")),
        ("length", "m", 1.0, ("m", "metre", "metres", "meter", "meters")),
        ("length", "mm", 1.0, ("mm", "millimetre", "millimetres", "millimeters")),
        ("length", "um", 1.0, ("um", "µm", "μm", "micron", "microns")),
        ("length", "nm", 1.0, ("nm",)),
        ("length", "mm", 25.4, ("in", "inch", "inches")),
        ("length", "um", 25.4, ("mil", "mils")),
        ("length", "V", 1.0, ("V", "volt", "volts")),
        ("length", "mV", 1.0, ("mV", "millivolts")),
        ("any", "1", 1.0, ("1", "-", "")),
    )
    for name in names
}
_BY_LOWER_CASE = {name.lower(): unit for name, unit in UNITS.items()}


def unit_called(name: str) -> Unit | None:
    """Return a unit by its name, in whichever case if that is the only one; None if not known.

    Examples
    --------
    >>> unit_called("Mils"), unit_called("furlong")
    (Unit(kind='length', plain='um', factor=25.4), None)
    """
    return UNITS.get(name) or _BY_LOWER_CASE.get(name.lower())


def known_units(kind: str) -> str:
    """Return the units of a kind, one name each, for a message."""
    first = {(unit.kind, unit.plain, unit.factor): name for name, unit in reversed(UNITS.items())}
    return ", ".join(name for (each, *_), name in reversed(first.items()) if each == kind)
