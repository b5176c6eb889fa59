"""A keyphasor: its pulses in a sampled signal, those that are lost, and the angle between them."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError

FEWEST_PULSES = 3
# An interval that is so much longer, or shorter, than those round it has lost or gained a pulse.
LONGER = 1.5
SHORTER = 0.6
# At the ends, where a machine may start from rest, only if those beyond are so nearly alike.
ALIKE = 1.15
# Of the height of the pulses: a crossing counts when the signal has been below and gets above.
LOW, HIGH = 0.4, 0.6


def angles_by_pulses(
    pulses: Values, times: Values, per_revolution: int
) -> tuple[npt.NDArray[np.bool_], Values]:
    """Return which samples lie between pulses, and the angle of the rotor at each of them [rad].

    A cubic spline through the pulses, which is exact while the speed changes evenly.
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 - takes long to import

    check_pulses(pulses)
    # a sample at a pulse is between pulses, whatever rounding did to its time
    slack = 1e-9 * float(np.diff(pulses).min())
    within = (times >= pulses[0] - slack) & (times <= pulses[-1] + slack)
    angles = 2.0 * math.pi / per_revolution * np.arange(pulses.size)
    return within, np.asarray(CubicSpline(pulses, angles)(times[within]), dtype=np.float64)


def check_pulses(pulses: Values) -> None:
    """Raise `InputError` for pulses that are too few, out of order, lost or one too many."""
    if pulses.size < FEWEST_PULSES:
        raise InputError(f"keyphasor must have at least {FEWEST_PULSES} pulses, got {pulses.size}")
    intervals = np.diff(pulses)
    if not (intervals > 0.0).all():
        at = pulses[:-1][~(intervals > 0.0)][0]
        raise InputError(f"keyphasor must have times that increase, but not after {at:.6g}")
    usual = usual_intervals(intervals)
    lost = np.flatnonzero(intervals > LONGER * usual)
    if lost.size:
        where = ", ".join(f"{pulses[each]:.6g}" for each in lost[:3])
        more = f" and {lost.size - 3} more places" if lost.size > 3 else ""
        count = round(float(intervals[lost[0]] / usual[lost[0]]), 2)
        raise InputError(
            f"keyphasor must not lose pulses, but does after t {where}{more}: the interval there "
            f"is {count:g} times those beside it"
        )
    extra = np.flatnonzero(intervals < SHORTER * usual)
    if extra.size:
        raise InputError(
            "keyphasor must not have pulses too many, but two follow each other too soon after t "
            f"{pulses[extra[0]]:.6g}"
        )


def with_lost_pulses(pulses: Values) -> Values:
    """Return pulses with those that were lost set evenly into their intervals.

    Examples
    --------
    >>> with_lost_pulses(np.array([0.0, 1.0, 2.0, 4.0, 5.0, 6.0]))
    array([0., 1., 2., 3., 4., 5., 6.])
    """
    if pulses.size < FEWEST_PULSES:
        return pulses
    intervals = np.diff(pulses)
    usual = usual_intervals(intervals)
    parts = np.where(intervals > LONGER * usual, np.round(intervals / usual), 1.0).astype(int)
    pieces = [
        start + interval / count * np.arange(count)
        for start, interval, count in zip(pulses[:-1], intervals, parts, strict=True)
    ]
    return np.concatenate([*pieces, pulses[-1:]])


def usual_intervals(intervals: Values) -> Values:
    """Return how long each interval would be, judged by the ones round it."""
    from scipy.ndimage import median_filter  # noqa: PLC0415 - takes long to import

    usual = np.asarray(median_filter(intervals, size=5, mode="nearest"), dtype=np.float64)
    if intervals.size >= FEWEST_PULSES:
        for end, next_, beyond in ((0, 1, 2), (-1, -2, -3)):
            pair = sorted((intervals[next_], intervals[beyond]))
            usual[end] = intervals[next_] if pair[1] < ALIKE * pair[0] else intervals[end]
    return usual


def pulses_in(times: Values, signal: Values) -> Values:
    """Return the times at which a sampled signal rises into a pulse.

    Half-way up, found by a straight line between two samples. Pulses that point downwards are
    found likewise: what is there for the shorter part of the time is the pulse.
    """
    low, high = float(signal.min()), float(signal.max())
    if low == high:
        raise InputError(f"keyphasor must have pulses, got the constant {low!r}")
    height = (signal - low) / (high - low)
    if np.median(height) > 0.5:
        height = 1.0 - height
    # 1 above, -1 below; between the two it is what it was
    state = np.where(height >= HIGH, 1, np.where(height <= LOW, -1, 0))
    known = np.flatnonzero(state)
    rises = np.flatnonzero((state[known[1:]] == 1) & (state[known[:-1]] == -1))
    found = [_half_way(times, height, int(known[each]), int(known[each + 1])) for each in rises]
    return np.array(found)


def _half_way(times: Values, height: Values, before: int, after: int) -> float:
    """Return when a signal that is low at one sample, and high at another, passes one half."""
    index = before + int(np.flatnonzero(height[before : after + 1] < 0.5)[-1])
    part = (0.5 - height[index]) / (height[index + 1] - height[index])
    return float(times[index] + part * (times[index + 1] - times[index]))
