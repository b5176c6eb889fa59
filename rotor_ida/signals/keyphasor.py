"""Keyphasor: find pulses in a sampled signal, fill in lost ones, and compute the angle."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.checks import check_count
from rotor_ida.errors import InputError

Counts = npt.NDArray[np.int64]

MOST_PER_REVOLUTION = 10_000
FEWEST_PULSES = 3
FEWEST_JUDGED = 4
# An interval this much longer than a neighbour may have lost a pulse; one this much shorter than
# usual may have an extra pulse.
LONGER = 1.25
SHORTER = 0.6
# At the ends, where a machine may start from rest, only if the next intervals are this similar.
ALIKE = 1.15
# An interval this many times longer than its neighbour, as at a rest, is not used to judge it.
REST = 3.0
# Revolutions in an interval above which they are counted by a parabola.
LONG_GAP = 4.5
MOST_PASSES = 20
# Points per revolution at which the angle is computed to fill in pulses.
FINE = 200
ROUNDING = 1e-9
# A pulse that rises by more than this part of its height in one step has the step as its error.
SUDDEN = 0.5
# Increasing numbers of pulses to which a smooth curve is fitted.
COURSES = (5, 9, 17, 33, 65, 129, 257)
# Parts of the pulse height: a crossing counts if the signal rises from below LOW to above HIGH.
LOW, HIGH = 0.4, 0.6


class Rises(NamedTuple):
    """Times at which a signal rises into pulses, their largest errors, and how long each lasts."""

    times: Values
    errors: Values
    widths: Values


def angles_by_pulses(
    pulses: Values, times: Values, per_revolution: int
) -> tuple[npt.NDArray[np.bool_], Values]:
    """Return the samples between pulses, and the angle of the rotor at each of them [rad].

    The angle is a cubic spline through the pulses, which is exact for a constant acceleration.
    Where that would decrease, as when a machine stops, it is monotonic (Fritsch and Carlson).
    """
    from scipy.interpolate import CubicSpline, PchipInterpolator  # noqa: PLC0415 - slow to import

    check_pulses(pulses)
    # a sample at a pulse counts as between pulses in spite of rounding
    slack = 1e-9 * float(np.diff(pulses).min())
    within = (times >= pulses[0] - slack) & (times <= pulses[-1] + slack)
    turns = np.arange(pulses.size, dtype=np.float64)
    angles = np.asarray(CubicSpline(pulses, turns)(times[within]), dtype=np.float64)
    falls = np.flatnonzero(np.diff(angles) < 0.0)
    if falls.size:
        place = np.searchsorted(pulses, times[within], side="right")
        back = np.isin(place, place[np.concatenate([falls, falls + 1])])
        angles[back] = PchipInterpolator(pulses, turns)(times[within][back])
    return within, 2.0 * math.pi / per_revolution * angles


def check_per_revolution(pulses_per_revolution: object) -> int:
    """Return the number of pulses in one revolution."""
    return check_count("pulses_per_revolution", pulses_per_revolution, 1, MOST_PER_REVOLUTION)


def check_pulses(pulses: Values) -> None:
    """Raise `InputError` for too few pulses, or pulses out of order, lost or in excess."""
    if pulses.size < FEWEST_PULSES:
        raise InputError(f"keyphasor must have at least {FEWEST_PULSES} pulses, got {pulses.size}")
    intervals = np.diff(pulses)
    if not (intervals > 0.0).all():
        at = pulses[:-1][~(intervals > 0.0)][0]
        raise InputError(f"keyphasor must have times that increase, but not after {at:.6g}")
    extra = extra_pulses(intervals)
    if extra.size:
        raise InputError(
            "keyphasor must not have extra pulses, but two follow each other too soon after t "
            f"{pulses[extra[0]]:.6g}{_more(extra.size - 1)}"
        )
    counts = counts_between(pulses)
    lost = np.flatnonzero(counts > 1)
    if lost.size:
        where = ", ".join(f"{pulses[each]:.6g}" for each in lost[:3])
        raise InputError(
            f"keyphasor must not lose pulses, but does after t {where}{_more(lost.size - 3)}: "
            f"{counts[lost[0]] - 1} in the interval there, judged by those beside it; "
            f"fill_pulses=True fills them in{_once_in(np.cumsum(counts)[lost])}"
        )


def _once_in(numbers: Counts) -> str:
    """Return what to do where pulses are lost at equal distances, as at a missing tooth."""
    apart = np.unique(np.diff(numbers))
    if numbers.size < FEWEST_PULSES or apart.size > 1:
        return ""
    return f"; pulses_per_revolution={apart[0]} takes every {apart[0]}th, if a tooth, as the mark"


def _more(count: int) -> str:
    """Return the number of other places, in words."""
    return f" and {count} more place{'s' if count > 1 else ''}" if count > 0 else ""


def with_lost_pulses(pulses: Values) -> Values:
    """Return pulses with lost ones filled in by a spline through the others.

    Examples
    --------
    >>> with_lost_pulses(np.array([0.0, 1.0, 2.0, 4.0, 5.0, 6.0])).round(6)
    array([0., 1., 2., 3., 4., 5., 6.])
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 - takes long to import

    counts = counts_between(pulses)
    turns = np.concatenate([[0.0], np.cumsum(counts)])
    spline = CubicSpline(pulses, turns)
    filled = [pulses]
    for each in np.flatnonzero(counts > 1):
        times = np.linspace(pulses[each], pulses[each + 1], FINE * int(counts[each]) + 1)
        angles = spline(times)
        if not (np.diff(angles) > 0.0).all():
            angles = np.linspace(turns[each], turns[each + 1], times.size)
        filled.append(np.interp(np.arange(turns[each] + 1.0, turns[each + 1]), angles, times))
    return np.sort(np.concatenate(filled))


def counts_between(pulses: Values) -> Counts:
    """Return the number of revolutions between each pulse and the next.

    Only intervals longer than a neighbour are judged, in order of rising excess and only from
    neighbours that are judged already. This is repeated until nothing changes.
    """
    from scipy.ndimage import minimum_filter  # noqa: PLC0415 - takes long to import

    intervals = np.diff(pulses)
    counts = np.ones(intervals.size, dtype=np.int64)
    if pulses.size < FEWEST_JUDGED:
        return counts
    excess = intervals / minimum_filter(intervals, size=5, mode="nearest")
    judged = excess <= LONGER
    suspects = sorted(np.flatnonzero(~judged).tolist(), key=lambda place: float(excess[place]))
    for _ in range(MOST_PASSES):
        before = counts.copy()
        for place in suspects:
            found = _turns_in(pulses, counts, judged, place)
            if found is not None:
                counts[place], judged[place] = max(1, round(found)), True
        if judged.all() and (counts == before).all():
            break
        judged[:] = True
    return counts


def _turns_in(
    pulses: Values, counts: Counts, judged: npt.NDArray[np.bool_], place: int
) -> float | None:
    """Return the revolutions between a pulse and the next, from up to three pulses on each side.

    The angle is a polynomial of time through all of them; the number of revolutions is chosen so
    that its degree is one lower. If the machine stops in between, each side has a separate
    parabola. None if there are too few pulses.
    """
    first, last = _trusted(pulses, counts, judged, place)
    turns = np.concatenate([[0.0], np.cumsum(counts[first:last])])
    after = np.arange(first, last + 1) > place
    turns -= turns[place - first] + counts[place] * after
    t = (pulses[first : last + 1] - pulses[place]) / (pulses[place + 1] - pulses[place])
    ends = [
        _until_rest(t[~after], turns[~after]),
        _until_rest(1.0 - t[after][::-1], -turns[after][::-1]),
    ]
    enough = np.array([3, 3]) <= [after.size - after.sum(), after.sum()]
    stops = [end for end in ends if end is not None]
    if stops and len(stops) == enough.sum() and sum(end[0] for end in stops) <= 1.0 + ROUNDING:
        return sum(end[1] for end in stops)
    if t.size < FEWEST_JUDGED:
        return None
    # the highest divided difference of the angles is 0
    weights = 1.0 / np.prod(t[:, None] - t + np.eye(t.size), axis=1)
    found = -float(weights @ turns / weights[after].sum())
    if found < LONG_GAP:
        return found
    # far from the pulses a polynomial of high degree is noise
    basis = np.stack([np.ones(t.size), t, t**2, -1.0 * after], axis=1)
    return float(np.linalg.lstsq(basis, turns, rcond=None)[0][3])


def _trusted(
    pulses: Values, counts: Counts, judged: npt.NDArray[np.bool_], place: int
) -> tuple[int, int]:
    """Return the first and last pulse from which to judge an interval: none past a rest."""
    longest = REST * (pulses[place + 1] - pulses[place])

    def near(each: int) -> bool:
        length = (pulses[each + 1] - pulses[each]) * counts[place] / counts[each]
        return bool(judged[each] and length < longest)

    first, last = place, place + 1
    while first > max(place - 2, 0) and near(first - 1):
        first -= 1
    while last < min(place + 3, pulses.size - 1) and near(last):
        last += 1
    return first, last


def _until_rest(t: Values, turns: Values) -> tuple[float, float] | None:
    """Return time and turns from 0 to rest, by a parabola through three pulses up to time 0."""
    if t.size < FEWEST_PULSES:
        return None
    half, speed, _ = np.polyfit(t, turns, 2)
    if half >= 0.0:
        return None
    speed = max(speed, 0.0)
    return float(speed / (-2.0 * half)), float(speed**2 / (-4.0 * half))


def usual_intervals(intervals: Values) -> Values:
    """Return the expected length of each interval, from those around it."""
    from scipy.ndimage import median_filter  # noqa: PLC0415 - takes long to import

    usual = np.asarray(median_filter(intervals, size=5, mode="nearest"), dtype=np.float64)
    if intervals.size >= FEWEST_PULSES:
        for end, next_, beyond in ((0, 1, 2), (-1, -2, -3)):
            pair = sorted((intervals[next_], intervals[beyond]))
            usual[end] = intervals[next_] if pair[1] < ALIKE * pair[0] else intervals[end]
    for ends, others in ((slice(2), slice(2, 4)), (slice(-2, None), slice(-4, -2))):
        alike = [*intervals[others].tolist(), float(intervals[ends].sum())]
        if intervals.size > FEWEST_JUDGED and max(alike) < ALIKE * min(alike):
            usual[ends] = intervals[others]  # the first two are one that an extra pulse divides
    return usual


def extra_pulses(intervals: Values) -> npt.NDArray[np.intp]:
    """Return short intervals that, joined with a neighbour, are no longer than usual.

    At an end a short interval has no neighbour on one side and needs none.
    """
    usual = usual_intervals(intervals)
    padded = np.concatenate([[-np.inf], intervals, [-np.inf]])
    joined = intervals + np.minimum(padded[:-2], padded[2:])
    return np.flatnonzero((intervals < SHORTER * usual) & (joined < LONGER * usual))


def rises_in(times: Values, signal: Values, low: float, high: float) -> Rises:
    """Return where a sampled signal rises into a pulse, between its lower and its upper level.

    The time is at half height, by linear interpolation between two samples. The pulse is the level
    with the shorter duration, so pulses may point downwards. A pulse that rises within one step
    may lie anywhere in it: `along_smooth_course` then sets its time.
    """
    if low == high:
        raise InputError(f"keyphasor must have pulses, got the constant {low!r}")
    height = np.clip((signal - low) / (high - low), 0.0, 1.0)
    if np.median(height) > 0.5:
        height = 1.0 - height
    # 1 above, -1 below; between the two it is what it was
    state = np.where(height >= HIGH, 1, np.where(height <= LOW, -1, 0))
    known = np.flatnonzero(state)
    turns = np.flatnonzero(np.diff(state[known]))
    found = np.array(
        [_half_way(times, height, int(known[each]), int(known[each + 1])) for each in turns]
    ).reshape(-1, 2)
    rises = found[state[known[turns]] == -1]
    falls = found[state[known[turns]] == 1, 0]
    after = np.searchsorted(falls, rises[:, 0])
    widths = np.append(falls, np.nan)[after] - rises[:, 0]
    return Rises(rises[:, 0], rises[:, 1], widths)


def _half_way(times: Values, height: Values, before: int, after: int) -> tuple[float, float]:
    """Return the time at which a signal passes one half between two samples, and its error.

    The error is half a step if the whole rise or fall lies within one step.
    """
    first = height[before] < 0.5
    index = before + int(np.flatnonzero((height[before : after + 1] < 0.5) == first)[-1])
    rise, step = height[index + 1] - height[index], times[index + 1] - times[index]
    error = 0.5 * step * abs(rise) if abs(rise) > SUDDEN else 0.0
    return float(times[index] + (0.5 - height[index]) / rise * step), float(error)


def along_smooth_course(pulses: Values, errors: Values) -> Values:
    """Return pulse times on the smoothest curve within their errors.

    Parameters
    ----------
    pulses, errors : ndarray, shape (n,)
        Measured times of the pulses, and the largest error of each.

    Notes
    -----
    Around each pulse a cubic is fitted to the times of its neighbours (Savitzky and Golay): to as
    many as possible, up to 257, provided that no time moves by more than its error and the
    remaining error of the cubic. So resolved changes of speed are kept, and the scatter of times
    that were rounded to samples is averaged out.

    Examples
    --------
    >>> exact = 0.0163 * np.arange(200) - 1e-5 * np.arange(200) ** 2
    >>> seen = np.ceil(exact * 1000.0) / 1000.0 - 0.0005  # in the middle of a step of a millisecond
    >>> smooth = along_smooth_course(seen, np.full(200, 0.0005))
    >>> bool(np.abs(smooth - exact).std() < 0.2 * np.abs(seen - exact).std())
    True
    """
    from scipy.ndimage import maximum_filter1d  # noqa: PLC0415 - takes long to import
    from scipy.signal import savgol_filter  # noqa: PLC0415 - takes long to import

    smooth = pulses.copy()
    loose = errors > 0.0
    for width in COURSES:
        if width > pulses.size:
            break
        course = savgol_filter(pulses, width, 3)
        moved = np.full(pulses.size, np.inf)
        moved[loose] = np.abs(course - pulses)[loose] / errors[loose]
        # what is left of errors that fill their range evenly, three times its standard deviation
        own = 3.0 * math.sqrt(2.25 / (3.0 * width))
        fits = maximum_filter1d(moved, width, mode="nearest") <= 1.0 + own
        smooth[fits] = course[fits]
    return smooth
