"""Columns of numbers in a file, and the known units."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida import units
from rotor_ida.arrays import Values
from rotor_ida.checks import shown
from rotor_ida.errors import InputError

# Endings by which formats are recognised; any other file is text.
ENDINGS = {
    "wav": (".wav",),
    "matlab": (".mat",),
    "hdf5": (".h5", ".hdf5", ".hdf"),
    "npz": (".npz",),
    "uff": (".uff", ".unv", ".uf"),
    "tdms": (".tdms",),
    "labview": (".lvm",),
    "comtrade": (".cfg", ".dat", ".cff"),
}
# Largest number of numbers read from one file: 2 GiB.
MOST_NUMBERS = 2**28
# Part by which two sampling rates may differ and still be one.
DIFFERENT_RATE = 0.01
# Largest compression ratio of deflate, and numbers always allowed in a small file.
LARGEST_COMPRESSION, SMALLEST_ALLOWANCE = 1032, 2**20


class Column(NamedTuple):
    """Numbers, NaN where a cell has none, and the unit given by the file, if any.

    ``times`` are those of its samples, in the unit of the column ``t``, where the file gives each
    channel its own; of ``t`` they are then its numbers.
    """

    values: Values
    unit: str = ""
    times: Values | None = None

    @property
    def step(self) -> float:
        """The usual step of its own times, 0 if it has none."""
        if self.times is None or self.times.size < 2:
            return 0.0
        return float(np.median(np.diff(self.times)))


@dataclass(frozen=True)
class Table:
    """Columns of a file.

    Parameters
    ----------
    columns : mapping of str to Column
        Columns by name.
    cell : callable
        Takes a column's name and a row, from 0, and returns its content and place in words.
    rest : str
        Other content of the file, for a message about a missing column.
    scalars : mapping of str to float
        Single numbers by name, such as the sampling rate.
    file : str
        Name of the file.
    """

    columns: Mapping[str, Column]
    cell: Callable[[str, int], str]
    rest: str = ""
    scalars: Mapping[str, float] = field(default_factory=dict)
    file: str = ""

    def listed(self) -> str:
        """Return the names of the columns, and other content."""
        return ", ".join(self.columns) + (f"; and {self.rest}" if self.rest else "")


class Unit(NamedTuple):
    """Quantity of a unit, the unit to which its numbers are converted, and the factor."""

    kind: str
    plain: str
    factor: float


def _of(kind: str, plain: str, symbols: Mapping[str, str]) -> dict[str, Unit]:
    """Return units of a quantity: each symbol with that of the unit to which it is converted."""
    found = {}
    for symbol, other in symbols.items():
        one, two = units.UNITS[symbol], units.UNITS[other]
        factor = one._replace(power=one.power - two.power).in_si("1")
        found[symbol] = Unit(kind, plain or other, factor)
    return found


# Lengths keep their unit, or are converted to a standard one.
_LENGTHS = {"m": "m", "mm": "mm", "um": "um", "nm": "nm", "in": "mm", "mil": "um"}
_UNITS: dict[str, Unit] = {
    **_of("length", "", _LENGTHS),
    **{volts: Unit("length", volts, 1.0) for volts in ("V", "mV")},
    **_of("time", "s", dict.fromkeys(("s", "ms", "us", "min"), "s")),
    **_of("angle", "radian", dict.fromkeys(("rad", "deg", "rev"), "rad")),
    **{str(name): Unit("speed", "s-1", size) for name, size in units.SPEED_UNITS.items()},
}
_NONE, _MEGAVOLTS = ("1", "-", ""), ("MV", "Mv")
# Names besides those in `rotor_ida.units`.
_NAMES = {
    **dict.fromkeys(("v", "volt", "volts"), "V"),
    **dict.fromkeys(("mv", "millivolts"), "mV"),
    **dict.fromkeys(("rad/s", "rad s-1", "s-1", "1/s"), "rad/s"),
    **dict.fromkeys(("rev/min", "u/min"), "rpm"),
    **dict.fromkeys(("rps", "rev/s"), "Hz"),
}


def unit_called(name: str) -> Unit | None:
    """Return a unit by name, ignoring case if that is unambiguous; None if not known.

    Examples
    --------
    >>> unit_called("Mils"), unit_called("furlong")
    (Unit(kind='length', plain='um', factor=25.4), None)
    """
    if name in _NONE:
        return Unit("any", "1", 1.0)
    if name in _MEGAVOLTS:
        return None
    return _UNITS.get(_NAMES.get(name.lower()) or units.symbol_of(name))


def known_units(kind: str) -> str:
    """Return the units of a kind, one name each, for a message."""
    return ", ".join(symbol for symbol, unit in _UNITS.items() if unit.kind == kind)


def name_and_unit(name: str) -> tuple[str, str]:
    """Split a name and the unit in it: ``x [um]``, ``x (um)`` or ``x/um``.

    Examples
    --------
    >>> name_and_unit("Speed [rpm]"), name_and_unit("probe (left)")
    (('Speed', 'rpm'), ('probe (left)', ''))
    """
    if "/" in name:
        last = re.split(r"[\s_]+", name)[-1]
        if unit_called(last) is not None:  # the unit of omega rad/s is not s
            return name[: -len(last)].rstrip(" _") or name, last
    bare = name.rstrip()
    for opening, closing in ("[]", "()"):
        before, start, unit = bare[:-1].rpartition(opening)
        if start and bare.endswith(closing) and (start == "[" or unit_called(unit.strip())):
            return before.rstrip(), unit.strip()
    for slashes in (2, 1):  # rad/s before s
        before, *parts = name.rsplit("/", slashes)
        unit = "/".join(parts).strip()
        divided = len(parts) == 1 and "/" in before and len(before.rpartition("/")[2].split()) < 2
        if before.strip() and unit and not divided and unit_called(unit) is not None:
            return before.rstrip(), unit  # divided: the unit of v/m/s is not s
    return name, ""


def numbers_or_times(values: npt.ArrayLike) -> Values | None:
    """Return numbers as floats, dates and durations in seconds, and None for anything else.

    Dates count from the first one.

    Examples
    --------
    >>> numbers_or_times(np.array(["2024-01-02T12:00", "2024-01-03T12:00"], dtype="M8[s]"))
    array([    0., 86400.])
    """
    held = np.asarray(values)
    if held.dtype.kind == "M":
        held = held - held.ravel()[:1]
    if held.dtype.kind == "m":
        return np.asarray(held / np.timedelta64(1, "ns") * 1e-9, dtype=np.float64)
    return held.astype(np.float64, copy=False) if held.dtype.kind in "biuf" else None


def with_clock(
    columns: Mapping[str, Column], unit: str = "s", name: str = "t"
) -> dict[str, Column]:
    """Return columns after one of the times that most of them have; all have times on entry.

    They keep their own times only if there are several.
    """
    clocks: list[Values] = []
    counts: list[int] = []
    found: dict[str, Column] = {}
    for each, column in columns.items():
        times = column.times
        assert times is not None
        same = (n for n, clock in enumerate(clocks) if np.array_equal(clock, times, equal_nan=True))
        place = next(same, -1)
        if place < 0:
            clocks.append(times)
            counts.append(0)
        counts[place] += 1
        found[each] = column._replace(times=clocks[place])
    most = clocks[counts.index(max(counts))]
    if len(clocks) == 1:
        return {name: Column(most, unit)} | {
            each: column._replace(times=None) for each, column in found.items()
        }
    return {name: Column(most, unit, most), **found}


def possible_in(path: Path) -> float:
    """Return the largest number of numbers in a compressed file."""
    return LARGEST_COMPRESSION * path.stat().st_size + SMALLEST_ALLOWANCE


def check_size(path: Path, numbers: float, *, possible: float = MOST_NUMBERS) -> None:
    """Raise `InputError` if a file declares more numbers than are read, or than it can contain."""
    most = min(possible, MOST_NUMBERS)
    if not numbers <= most:
        raise InputError(
            f"{shown(path)} must declare at most {most:.6g} numbers for a file of "
            f"{path.stat().st_size} bytes, got {numbers:.6g}"
        )


@contextmanager
def understood(path: Path, kind: str) -> Iterator[None]:
    """Turn any exception of a reader about a damaged file into one line."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except (InputError, OSError):
        raise
    except Exception as error:
        raise InputError(f"{shown(path)} must be {kind}: {one_line(error)}") from error


def one_line(error: Exception) -> str:
    """Return the message of a library's error in one line of moderate length."""
    said = " ".join(str(error).split()) or type(error).__name__
    return said if len(said) <= 200 else f"{said[:200]} ..."
