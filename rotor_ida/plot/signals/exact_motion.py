"""Exact motion beneath orbits, centre lines and traces, in the units of the signals."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.errors import InputError
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import circle
from rotor_ida.plot.signals.beneath import BACKWARD, CYCLE, KINDS, Beneath, made_beneath
from rotor_ida.plot.signals.units import Scales, Units, is_one_speed
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import flags_of, words_of
from rotor_ida.signals.orders import centre_line
from rotor_ida.signals.record import Record, mean_of, record_of

Indices = npt.NDArray[np.intp]

# Speeds along signals that are compared.
FEW_SPEEDS = 200
# A cycle that is periodic on fixed axes closes within this many periods; others are drawn so long.
MOST_PERIODS, CLOSED = 40, 1e-6
# The best of this many shifts aligns a cycle with a trace.
SHIFTS = 2000
# Samples at the end of a trace used for that.
SAMPLES = 400


class Orbit(NamedTuple):
    """An exact orbit in the plane, its label and style."""

    x: Values
    y: Values
    words: str
    colour: str
    dashes: object


class Centre(NamedTuple):
    """An exact mean position, its label and marker."""

    place: complex
    words: str
    marker: str


class Trace(NamedTuple):
    """Exact motion over time: times and displacements in the units of a trace, and its label."""

    times: Values
    z: ComplexValues
    words: str


def orbits_of(beneath: Beneath, given: xr.Dataset, units: Units) -> list[Orbit]:
    """Return exact orbits under the orbit of a run or signals."""
    one_speed = is_of_one_speed(given)
    makers = {
        "cycle": _orbit_of_cycle,
        "backward_whirl": _backward_orbits,
        "whirls": lambda each, scales: _circles(
            _at_speed_of(given, each) if one_speed else each, given, scales.length
        ),
    }
    allowed = "a limit cycle, backward whirls or synchronous whirls"
    of_any_speed = () if one_speed else KINDS
    orbits = made_beneath(beneath, given, units, makers, allowed, of_any_speed=of_any_speed)
    return [each for each in orbits if np.isfinite(each.x).all()]


def is_of_one_speed(given: xr.Dataset) -> bool:
    """Return whether the speed of a run or of signals is constant or unknown."""
    speeds = speeds_along(given)
    return not speeds.size or is_one_speed(speeds)


def speeds_along(given: xr.Dataset) -> Values:
    """Return mean speeds between a few times of a run or of signals; none if unknown."""
    record = record_of(given)
    if record.angles is None:
        return np.empty(0)
    places = np.unique(np.linspace(0, record.times.size - 1, FEW_SPEEDS).astype(int))
    return np.asarray(np.diff(record.angles[places]) / np.diff(record.times[places]))


def _orbit_of_cycle(cycle: xr.Dataset, scales: Scales) -> list[Orbit]:
    """Return a limit cycle on fixed axes, until it closes or fills its annulus."""
    omega, times = _speed_of(cycle), cycle["t"].values
    once = _rotating(cycle) * np.exp(1j * omega * times) * scales.length
    turns = omega * float(times[-1]) / (2.0 * math.pi) * np.arange(1, MOST_PERIODS + 1)
    closed = np.flatnonzero(np.abs(turns - np.round(turns)) < CLOSED)
    count = int(closed[0]) + 1 if closed.size else MOST_PERIODS
    z = np.concatenate([once * np.exp(1j * omega * times[-1] * each) for each in range(count)])
    return [Orbit(z.real, z.imag, CYCLE, palette.PURPLE, "-")]


def _backward_orbits(whirls: xr.Dataset, scales: Scales) -> list[Orbit]:
    """Return the circles of backward whirls."""
    radii = whirls["amplitude"].values * scales.length
    return [
        Orbit(*circle(radius), *BACKWARD[kind], "-")
        for radius, kind in zip(radii.tolist(), words_of(whirls["kind"]), strict=True)
    ]


def _at_speed_of(given: xr.Dataset, whirls: xr.Dataset) -> xr.Dataset:
    """Return the whirls at the speed of the run, if known."""
    if whirls.sizes.get("omega", 0) > 1 and "omega" in given.variables and not given["omega"].ndim:
        return whirls.sel(omega=float(given["omega"]))
    return whirls


def _circles(whirls: xr.Dataset, given: xr.Dataset, length: float) -> list[Orbit]:
    """Return the circles of synchronous whirls."""
    # without a shaft the centre of a whirl that never touches may be anywhere
    free = (whirls["in_contact"].values.ravel() == 0) & ("shaft_stiffness" not in whirls.variables)
    middle = centre_line(given).isel(window=-1) if free.any() else None
    centre = 0j
    if middle is not None:
        centre = complex(middle["offset_x"], middle["offset_y"]) - mean_of(middle.coords)
    orbits = []
    for radius, loose, stability in zip(
        whirls["amplitude"].values.ravel() * length, free, words_of(whirls["stability"]),
        strict=True,
    ):  # fmt: skip
        x, y = circle(radius)
        orbit = Orbit(x, y, "exact whirl", palette.PURPLE, "-")
        if stability == "unstable":
            orbit = Orbit(x, y, "unstable whirl", palette.GREY, palette.DASHES)
        if loose:
            orbit = orbit._replace(x=x + centre.real, y=y + centre.imag)
        orbits.append(orbit)
    return orbits


def centres_of(beneath: Beneath, means: xr.Dataset, units: Units) -> list[Centre]:
    """Return exact mean positions under a centre line."""
    makers = {
        "rest": lambda each, scales: [
            Centre(complex(each["x"], each["y"]) * scales.length, "place of rest", "s")
        ],
        "cycle": lambda each, scales: [
            Centre(_mean_of(each) * scales.length, f"mean of {CYCLE}", "D")
        ],
        "whirls": lambda _each, _scales: [Centre(0j, "centre of whirls in contact", "o")],
    }
    allowed = "a place of rest, a limit cycle or synchronous whirls"
    return made_beneath(beneath, means, units, makers, allowed)


def _mean_of(cycle: xr.Dataset) -> complex:
    """Return the mean of a limit cycle on fixed axes: its static line, if it has one.

    Only a load makes that line; the cycle then begins where the unbalance points along x.
    """
    if flags_of(cycle["line_kind"])["static"] not in cycle["line_kind"].values:
        return 0j
    z = _rotating(cycle) * np.exp(1j * _speed_of(cycle) * cycle["t"].values)
    return complex(z[:-1].mean())


def _speed_of(cycle: xr.Dataset) -> float:
    """Return the spin speed of a limit cycle in its unit of time."""
    return float(cycle["omega"]) / scale_of(cycle, "time")


def _rotating(cycle: xr.Dataset) -> ComplexValues:
    """Return one period of a limit cycle on the rotating axes."""
    return np.asarray(cycle["x"].values + 1j * cycle["y"].values)


def traces_of(beneath: Beneath, given: xr.Dataset, units: Units) -> list[Trace]:
    """Return exact motion under a trace."""
    makers = {
        "cycle": lambda each, scales: [_trace_of_cycle(each, record_of(given), scales)],
        "whirls": lambda each, scales: _nearest_whirl(each, given, scales),
        "motion": _trace_of_motion,
    }
    allowed = "a limit cycle, synchronous whirls or a motion over time"
    return made_beneath(beneath, given, units, makers, allowed, of_any_speed=("motion",))


def _trace_of_motion(motion: xr.Dataset, scales: Scales) -> list[Trace]:
    z = (motion["x"].values + 1j * motion["y"].values) * scales.length
    return [Trace(motion["t"].values / scales.rate, z, "exact flight")]


def _trace_of_cycle(cycle: xr.Dataset, record: Record, scales: Scales) -> Trace:
    """Return a cycle shifted in time to match the end of a record.

    On rotating axes any shift is allowed. Under a load only whole revolutions are, because the
    cycle begins where the unbalance points along x.
    """
    omega, times, turned = _speed_of(cycle), cycle["t"].values, _rotating(cycle)
    period = float(times[-1])
    angles = record.known_angles()

    def shifted(shift: float, part: slice | Indices = slice(None)) -> ComplexValues:
        phase = angles[part] / omega + shift
        z = np.interp(phase, times[:-1], turned[:-1], period=period) * np.exp(1j * angles[part])
        return np.asarray(z * scales.length, dtype=np.complex128)

    part, count = _end_of(record, period / scales.rate), SHIFTS
    if "load" in cycle.variables:
        count = max(round(period * omega / (2.0 * math.pi)), 1)
    shifts = period / count * np.arange(count)
    misses = [np.square(np.abs(shifted(each, part) - record.z[part])).sum() for each in shifts]
    return Trace(record.times, shifted(shifts[int(np.argmin(misses))]), CYCLE)


def _end_of(record: Record, duration: float) -> Indices:
    """Return samples from the end of a record, of some duration."""
    last = record.times.size - 1
    first = int(np.searchsorted(record.times, record.times[-1] - duration))
    return np.unique(np.linspace(first, last, SAMPLES).astype(np.intp))


def _nearest_whirl(whirls: xr.Dataset, given: xr.Dataset, scales: Scales) -> list[Trace]:
    """Return the whirl nearest to the end of a record, of those at one speed."""
    record = record_of(given)
    angles = record.known_angles()
    amplitude, lag, touches = (
        whirls[name].values.ravel() for name in ("amplitude", "phase_lag", "in_contact")
    )
    if "omega" in whirls.dims and whirls.sizes["omega"] > 1:
        raise InputError("beneath must be the whirls at one speed under a trace, got several")
    part = _end_of(record, 2.0 * math.pi / float(np.gradient(angles, record.times)[-1]))
    loose = "shaft_stiffness" not in whirls.variables
    whirling = []
    for height, behind, in_contact in zip(amplitude, lag, touches, strict=True):
        if not math.isfinite(height):
            continue
        z = height * scales.length * np.exp(1j * (angles - behind))
        if loose and not in_contact:  # without a shaft its centre may be anywhere
            z = z + (record.z[part] - z[part]).mean()
        miss = float(np.square(np.abs(z[part] - record.z[part])).mean())
        whirling.append((miss, Trace(record.times, z, "exact whirl")))
    return [min(whirling, key=lambda each: each[0])[1]] if whirling else []
