"""Exact motion over the time of a trace: cycles and whirls in step with it, and flights."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.plot.labels import scale_of
from rotor_ida.plot.signals.beneath import CYCLE
from rotor_ida.plot.signals.tracks import Beneath
from rotor_ida.plot.signals.units import Scales, Units, check_parameters, list_of, scales_of
from rotor_ida.signals.record import Record, record_of

ComplexValues = npt.NDArray[np.complex128]
Indices = npt.NDArray[np.intp]

# A cycle is brought in step with a trace by the best of so many shifts, and of as many beside that.
SHIFTS = 400
# Samples of the end of a trace by which that is done.
SAMPLES = 400


@dataclass(frozen=True, slots=True)
class Path:
    """Exact motion over time: times and displacements in the units of a trace, and its words."""

    times: Values
    z: ComplexValues
    words: str


def paths_over_time(beneath: Beneath, given: xr.Dataset, units: Units) -> list[Path]:
    """Return exact motion in the units of a trace; refuse what is none."""
    found = []
    for dataset in list_of(beneath):
        names = set(dataset.variables)
        flies = {"t", "x", "y"} <= names and "line_kind" not in names
        check_parameters(dataset, given, skipped=("omega",) if flies else ())
        scales = scales_of(dataset, given, units)
        if flies:
            z = (dataset["x"].values + 1j * dataset["y"].values) * scales.length
            found.append(Path(dataset["t"].values / scales.rate, z, "exact flight"))
        elif "line_kind" in names:
            found.append(_cycle(dataset, record_of(given), scales))
        elif {"amplitude", "branch"} <= names:
            found += _nearest_whirl(dataset, given, scales)
        else:
            raise InputError(
                "beneath must be a limit cycle, synchronous whirls or a motion over time, got "
                f"{dataset.attrs.get('title', 'another dataset')!r}"
            )
    return found


def _cycle(cycle: xr.Dataset, record: Record, scales: Scales) -> Path:
    """Return a cycle shifted along time to where the end of a record lies on it.

    On the turning axes it may be shifted by any time; under a load by whole revolutions alone, as
    it begins where the unbalance points along x.
    """
    omega = float(cycle["omega"]) / scale_of(cycle, "time")
    times = cycle["t"].values
    period, turned = float(times[-1]), cycle["x"].values + 1j * cycle["y"].values
    angles = record.known_angles()

    def shifted(shift: float, part: slice | Indices = slice(None)) -> ComplexValues:
        phase = angles[part] / omega + shift
        z = np.interp(phase, times[:-1], turned[:-1], period=period) * np.exp(1j * angles[part])
        return np.asarray(z * scales.length, dtype=np.complex128)

    part = _end_of(record, period / scales.rate)

    def best(shifts: npt.NDArray[np.floating]) -> float:
        misses = [float(np.square(np.abs(shifted(s, part) - record.z[part])).sum()) for s in shifts]
        return float(shifts[int(np.argmin(misses))])

    if "load" in cycle.variables:
        turns = max(round(period * omega / (2.0 * math.pi)), 1)
        shift = best(period / turns * np.arange(turns))
    else:
        step = period / SHIFTS
        shift = best(step * np.arange(SHIFTS))
        shift = best(shift + step * np.linspace(-1.0, 1.0, SHIFTS))
    return Path(record.times, shifted(shift), CYCLE)


def _end_of(record: Record, duration: float) -> Indices:
    """Return samples of the last part of a record, of some duration."""
    last = record.times.size - 1
    first = int(np.searchsorted(record.times, record.times[-1] - duration))
    return np.unique(np.linspace(first, last, SAMPLES).astype(np.intp))


def _nearest_whirl(whirls: xr.Dataset, given: xr.Dataset, scales: Scales) -> list[Path]:
    """Return the whirl, of those at one speed, that the end of a record is nearest to."""
    record = record_of(given)
    angles = record.known_angles()
    amplitude, lag, touches = (
        whirls[name].values.ravel() for name in ("amplitude", "phase_lag", "in_contact")
    )
    if "omega" in whirls.dims and whirls.sizes["omega"] > 1:
        raise InputError("beneath must be the whirls at one speed under a trace, got several")
    part = _end_of(record, 2.0 * math.pi / float(np.gradient(angles, record.times)[-1]))
    loose = "shaft_stiffness" not in whirls.variables
    found = []
    for height, behind, in_contact in zip(amplitude, lag, touches, strict=True):
        if not math.isfinite(height):
            continue
        z = height * scales.length * np.exp(1j * (angles - behind))
        if loose and not in_contact:  # without a shaft its centre may be anywhere
            z = z + (record.z[part] - z[part]).mean()
        miss = float(np.square(np.abs(z[part] - record.z[part])).mean())
        found.append((miss, Path(record.times, z, "exact whirl")))
    return [min(found, key=lambda each: each[0])[1]] if found else []
