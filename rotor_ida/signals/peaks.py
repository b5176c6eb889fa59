"""Peaks of one order over the speed: measured critical speeds and amplification factors."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import check_instance
from rotor_ida.schema import labelled, labelled_dataset, origin_of
from rotor_ida.signals.orders import one_order, orders
from rotor_ida.signals.windows import STEADY

# Amplitude, over that of the peak, at which the power is half of it.
HALF_POWER = math.sqrt(0.5)
# The fall of a peak to half its power must exceed this many standard errors of its amplitude.
SURE = 2.0
# A step of the speed shorter than this part of the next one is noise.
CLOSE = 0.05


def bode_peaks(signals: xr.Dataset, *, order: float = 1.0, sense: str = "forward") -> xr.Dataset:
    """Find the peaks of one order over the speed: critical speeds and amplification factors.

    Parameters
    ----------
    signals : Dataset
        The result of `orders`, or signals or a run-up, which are tracked revolution by revolution.
    order : float
        Multiple of the speed [dimensionless].
    sense : {"forward", "backward", "x", "y"}
        The whirl, or the probe, whose amplitude is used.

    Returns
    -------
    Dataset
        On ``critical``, by rising speed: ``critical_speed``, ``amplification_factor``,
        ``half_power_low`` and ``half_power_high``, the speeds at which the amplitude is 0.707 of
        the peak, and ``bode_amplitude``, zero to peak of a whirl and peak to peak of a probe.

    Raises
    ------
    InputError
        If the angle is not known, or the record does not contain the order.

    Notes
    -----
    A maximum is a peak if the amplitude falls to ``1/sqrt(2)`` of it on both sides before it
    exceeds it, and that fall is more than two of its standard errors. Its place is that of the
    parabola through three windows, and the factor ``N_c/(N_2 - N_1)`` with the speeds of half power
    by linear interpolation between windows. A side that ends before is as wide as the other, and
    its speed is NaN; a peak has one side at least. In a run-up the peak lies above the
    critical speed, the more the higher the rate. Runout should be subtracted first.

    References
    ----------
    API Standard 684: amplification factor by the half-power method.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> up = run_up(Rotor(omega=0.7, zeta=0.05, delta0=30.0, shaft_stiffness=1.0), start="settled",
    ...             to=1.4, rate=0.0001, samples=40_001)
    >>> peaks = bode_peaks(up)
    >>> peaks.critical_speed.round(1).item(), peaks.amplification_factor.round().item()
    (1.0, 10.0)
    """
    given = check_instance("signals", signals, xr.Dataset)
    tracks = given if "forward_whirl_amplitude" in given.variables else orders(given, order)
    rising = np.argsort(tracks["speed"].values, kind="stable")
    speeds = tracks["speed"].values[rising]
    one = one_order(tracks, order, sense)
    found = peaks_of(speeds, one.amplitude[rising], one.error[rising])
    names = ("critical_speed", "amplification_factor", "half_power_low", "half_power_high",
             "bode_amplitude")  # fmt: skip
    columns = np.array(found).reshape(-1, len(names)).T
    made = {
        name: labelled(name, "critical", each) for name, each in zip(names, columns, strict=True)
    }
    for name, like in (*((each, "speed") for each in (names[0], *names[2:4])),
                       ("bode_amplitude", "forward_whirl_amplitude")):  # fmt: skip
        made[name].attrs["units"] = tracks[like].attrs["units"]
    told = {**origin_of(tracks), "order": order, "sense": sense}
    return labelled_dataset("Peaks of a Bode plot", made, {}, told, kind="bode_peaks")


class Peak(NamedTuple):
    """A peak over the speed: its place, factor, speeds of half power and height."""

    speed: float
    amplification: float
    low: float
    high: float
    amplitude: float


def peaks_of(speeds: Values, amplitude: Values, error: Values) -> list[Peak]:
    """Return the peaks of amplitudes over rising speeds that stand out of their standard errors."""
    found: list[Peak] = []
    if amplitude.size < 3 or np.ptp(speeds) <= STEADY * np.abs(speeds).max():
        return found
    inner = np.arange(1, amplitude.size - 1)
    tops = inner[(amplitude[1:-1] > amplitude[:-2]) & (amplitude[1:-1] >= amplitude[2:])]
    for top in tops.tolist():
        if not (1.0 - HALF_POWER) * amplitude[top] > SURE * error[top]:
            continue
        place, height = _vertex(speeds[top - 1 : top + 2], amplitude[top - 1 : top + 2])
        feet = [_foot(speeds, amplitude, top, side, height) for side in (-1, 1)]
        if None in feet or all(foot is None or math.isnan(foot) for foot in feet):
            continue
        halves = [abs(foot - place) for foot in feet if foot is not None]
        low, high = (math.nan if foot is None else foot for foot in feet)
        found.append(Peak(place, place / (2.0 * float(np.nanmean(halves))), low, high, height))
    return found


def _vertex(speeds: Values, amplitude: Values) -> tuple[float, float]:
    """Return the vertex of the parabola through three points, the middle one the highest."""
    (before, after), (left, right) = np.diff(speeds), np.diff(amplitude)
    if not min(before, after) > CLOSE * max(before, after):  # noise of the speed
        return float(speeds[1]), float(amplitude[1])
    slopes = left / before, right / after
    bend = (slopes[1] - slopes[0]) / (before + after)
    slope = (slopes[0] * after + slopes[1] * before) / (before + after)
    return float(speeds[1] - 0.5 * slope / bend), float(amplitude[1] - 0.25 * slope**2 / bend)


def _foot(speeds: Values, amplitude: Values, top: int, side: int, height: float) -> float | None:
    """Return the speed of half power on a side of a peak; NaN beyond the record, None if higher."""
    beside = np.arange(top, amplitude.size if side > 0 else -1, side)
    low = np.flatnonzero(amplitude[beside] <= HALF_POWER * height)
    reach = beside[: low[0] + 1] if low.size else beside
    if reach.size == 1 or (amplitude[reach] > amplitude[top]).any():
        return None
    if not low.size:
        return math.nan
    ends = reach[[-1, -2]]
    return float(np.interp(HALF_POWER * height, amplitude[ends], speeds[ends]))
