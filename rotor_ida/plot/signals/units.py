"""Convert speeds to rpm, frequencies to Hz, and exact results to the units of the signals."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.plot.datasets import units_in
from rotor_ida.plot.labels import metres_in
from rotor_ida.signals.spectra import STEADY
from rotor_ida.units import PREFIXES, SPEED_UNITS

RATE = re.compile(r"^([pnumkM]?)s-1$")


@dataclass(frozen=True, slots=True)
class Units:
    """Units of a plot of signals.

    Parameters
    ----------
    length : str
        Unit of displacements, as in the dataset.
    rate : float or None
        Radians per second in one unit of rate of the dataset; None if dimensionless.
    """

    length: str
    rate: float | None

    def lengths(self, values: npt.ArrayLike) -> xr.DataArray:
        """Return displacements with their unit."""
        return xr.DataArray(np.asarray(values), attrs={"units": self.length})

    def speeds(self, values: npt.ArrayLike) -> xr.DataArray:
        """Return speeds of the dataset in rpm, or unchanged if dimensionless."""
        return self._turns(values, 1.0 / SPEED_UNITS["rpm"], "rpm")

    def frequencies(self, values: npt.ArrayLike) -> xr.DataArray:
        """Return circular frequencies of the dataset in Hz, or unchanged if dimensionless."""
        return self._turns(values, 0.5 / math.pi, "Hz")

    def _turns(self, values: npt.ArrayLike, factor: float, unit: str) -> xr.DataArray:
        scale = 1.0 if self.rate is None else self.rate * factor
        shown = "1" if self.rate is None else unit
        return xr.DataArray(scale * np.asarray(values), attrs={"units": shown})


@dataclass(frozen=True, slots=True)
class Scales:
    """Factors from lengths, speeds and frequencies of exact results to those of the signals."""

    length: float
    omega: float
    rate: float


def units_of(dataset: xr.Dataset, length: str, rate: str) -> Units:
    """Return the units of a dataset: those of its variables of a length, and of a rate or time."""
    unit = units_in(dataset[rate])
    radians = 1.0 if unit == "rpm" else radians_in(unit if "-1" in unit else f"{unit}-1")
    return Units(units_in(dataset[length]), radians)


def radians_in(unit: str) -> float | None:
    """Return the radians per second in a unit of rate; None if it is dimensionless.

    Examples
    --------
    >>> radians_in("ms-1"), radians_in("1")
    (1000.0, None)
    """
    parts = RATE.match(unit)
    return PREFIXES[parts[1]] if parts else None


def scales_of(exact: xr.Dataset, shown: xr.Dataset, units: Units) -> Scales:
    """Return the factors from an exact result to the units of the signals.

    A dimensionless result gets the scales of the machine, if the signals contain them.
    """
    here, there = exact.attrs, shown.attrs
    in_si = units.length != "1" or units.rate is not None
    if "length_scale" not in here and not in_si:
        return Scales(1.0, 1.0, 1.0)
    if "length_scale" not in here:
        if "length_scale" not in there or units.rate is None:
            raise InputError(
                f"beneath must be in units as the signals, which are in {units.length}: "
                "rotor_ida.dimensional(beneath, machine) makes it so"
            )
        rate = float(there["rate_scale"]) / units.rate
        return Scales(float(there["length_scale"]), rate, rate)
    if not in_si:
        raise InputError("beneath must be dimensionless as the signals, got a result in SI units")
    here_in = metres_in(units.length)
    if units.rate is None or here_in is None:
        raise InputError(f"beneath needs signals in units of length and time, got {units.length!r}")
    sizes = (metres_in(units_in(each)) for each in exact.variables.values())
    length = next(size for size in sizes if size is not None)
    return Scales(length / here_in, float(here["rate_scale"]) / units.rate, 1.0 / units.rate)


def is_one_speed(speeds: Values) -> bool:
    """Return whether speeds are equal except for noise."""
    return bool(np.ptp(speeds) <= STEADY * np.abs(speeds).max(initial=0.0))
