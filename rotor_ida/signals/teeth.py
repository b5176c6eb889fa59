"""Pulses of a keyphasor from readings or times: without glitches, and with the mark of a wheel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.signals.keyphasor import (
    FEWEST_PULSES,
    Counts,
    Rises,
    along_smooth_course,
    check_pulses,
    counts_between,
    extra_pulses,
    rises_in,
    usual_intervals,
    with_lost_pulses,
)
from rotor_ida.signals.record import ONE_OF_SEVERAL

# Part of the pulses that may be glitches; one is always allowed.
GLITCHES = 0.1
# A reading this far outside the levels of a signal, in its heights, belongs to a glitch, and the
# smallest height of a signal over that of its glitches.
OUTSIDE, LOWEST = 0.25, 0.02
# Part of the samples near half height above which a signal is a hum rather than pulses.
SLOW = 0.05
# Pulses below this number may all be glitches.
FEW = 10
# A tooth is longer than the others by at least this factor.
LONG_TOOTH = 1.3
EXTRA, MISSING, LONG = (
    "the first pulse after the extra one", "the first pulse after the missing tooth",
    "the longer tooth",
)  # fmt: skip


@dataclass(frozen=True)
class Teeth:
    """Pulses of a keyphasor, evenly spaced on the shaft.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Times of the pulses; the first is that of the mark, if there is one.
    mark : str
        What is taken as the mark among several pulses a revolution, empty if nothing is.
    ignored : int
        Number of pulses that were ignored, as they did not fit the others.
    """

    times: Values
    mark: str = ""
    ignored: int = 0

    def notes(self, per_revolution: int) -> list[str]:
        """Return what is to be known about the pulses."""
        notes = []
        if self.ignored:
            notes.append(
                f"pulses of the keyphasor that do not fit the others: {self.ignored} ignored"
            )
        if self.mark:
            notes.append(f"{self.mark} of the keyphasor is the mark, at the angle 0")
        elif per_revolution > 1:
            notes.append(
                f"none of the {per_revolution} pulses a revolution is the mark: phase lags are "
                f"known but for a multiple of {360.0 / per_revolution:.6g} degrees"
            )
        return notes

    def attributes(self, per_revolution: int) -> dict[str, object]:
        """Return the attributes of signals with these pulses."""
        found: dict[str, object] = {"pulses_per_revolution": per_revolution}
        if per_revolution > 1 and not self.mark:
            found["angle_origin"] = ONE_OF_SEVERAL
        return found


def teeth_in(times: Values, signal: Values, per_revolution: int, *, fill: bool) -> Teeth:
    """Return the pulses of a sampled keyphasor.

    Levels are first those of all readings. If the pulses so found are refused, or few, some
    glitches may be higher or lower than the pulses: levels without the most extreme readings are
    tried.
    """
    rises = rises_in(times, signal, float(signal.min()), float(signal.max()))
    refusal = None
    try:
        found = teeth_of(rises, per_revolution, fill=fill)
        if found.times.size >= FEW:
            return found
    except InputError as error:
        refusal = error
    for low, high, glitches in _levels_without_extremes(signal):
        rises = rises_in(times, signal, low, high)
        if glitches > _most_glitches(rises.times.size):
            continue
        try:
            other = teeth_of(rises, per_revolution, fill=fill)
        except InputError:
            continue
        return Teeth(other.times, other.mark, max(other.ignored, glitches))
    if refusal is not None:
        raise refusal
    return found


def _levels_without_extremes(signal: Values) -> Iterator[tuple[float, float, int]]:
    """Yield lower and upper levels, and the number of glitches beyond them."""
    ordered = np.sort(signal)
    count, whole = 1, float(ordered[-1] - ordered[0])
    while count <= GLITCHES * signal.size:
        low, high = float(ordered[count]), float(ordered[-1 - count])
        if high - low < LOWEST * whole:
            return
        between = np.abs(signal - 0.5 * (low + high)) < 0.1 * (high - low)
        margin = OUTSIDE * (high - low)
        outside = (signal > high + margin) | (signal < low - margin)
        glitches = int(np.count_nonzero(np.diff(outside.astype(np.int8), prepend=0) == 1))
        if glitches and between.mean() < SLOW:
            yield low, high, glitches
        count *= 2


def teeth_of(rises: Rises, per_revolution: int, *, fill: bool) -> Teeth:
    """Return pulses from the mark on, of which none is extra or lost; else raise `InputError`."""
    if rises.times.size < FEWEST_PULSES or not (np.diff(rises.times) > 0.0).all():
        check_pulses(rises.times)
    nothing = np.empty(0)
    for kept, extra in ((rises, nothing), _without_extra(rises)):
        counts = counts_between(_smooth(kept))
        numbers = np.concatenate([[0], np.cumsum(counts)])  # with those that are lost
        first, mark = _mark(kept, numbers, numbers[1:][counts > 1], extra, per_revolution)
        if mark in (MISSING, EXTRA):
            break
    ignored = 0 if mark == EXTRA else int(extra.size)
    if ignored > _most_glitches(numbers.size):
        check_pulses(rises.times)
    pulses = _smooth(_filled(kept, numbers) if fill or mark == MISSING else kept)
    check_pulses(pulses)
    if pulses.size - first < FEWEST_PULSES:
        first, mark = 0, ""
    return Teeth(pulses[first:], mark, ignored)


def _mark(
    kept: Rises, numbers: Counts, after_gaps: Counts, extra: Values, per_revolution: int
) -> tuple[int, str]:
    """Return the number of the first pulse that is the mark, and what it is; empty if none is."""
    if per_revolution == 1:
        return 0, ""
    after_extra = numbers[np.searchsorted(kept.times[:-1], extra)]
    for each, words in ((after_extra, EXTRA), (after_gaps, MISSING)):
        if _once_a_turn(each, per_revolution, int(numbers[-1])):
            return int(each[0]), words
    return _longer_tooth(kept, numbers, per_revolution)


def _smooth(rises: Rises) -> Values:
    """Return the times of pulses on a smooth course within their errors."""
    return along_smooth_course(rises.times, rises.errors) if rises.errors.any() else rises.times


def _filled(rises: Rises, numbers: Counts) -> Rises:
    """Return pulses with those that are lost; `numbers` count them with these."""
    times = with_lost_pulses(_smooth(rises))
    errors = np.full(times.size, rises.errors.max())
    times[numbers], errors[numbers] = rises.times, rises.errors
    return Rises(times, errors, np.full(times.size, np.nan))


def _without_extra(rises: Rises) -> tuple[Rises, Values]:
    """Return pulses without those that follow others too soon, and the times of these."""
    kept = np.arange(rises.times.size)
    while kept.size > FEWEST_PULSES:
        intervals = np.diff(rises.times[kept])
        short = extra_pulses(intervals)
        if not short.size:
            break
        usual = usual_intervals(intervals)
        # without the first or the second of its pulses the interval is joined with a neighbour; at
        # an end the neighbour alone is left
        pairs = intervals[1:] + intervals[:-1]
        before = np.abs(np.append(intervals[1], pairs) - usual)[short]
        after = np.abs(np.append(pairs, intervals[-2]) - usual)[short]
        kept = np.delete(kept, np.unique(short + (after <= before)))
    lost = np.setdiff1d(np.arange(rises.times.size), kept)
    return Rises(*(each[kept] for each in rises)), rises.times[lost]


def _most_glitches(pulses: int) -> int:
    """Return the largest number of pulses that may be glitches."""
    return max(1, int(GLITCHES * pulses))


def _once_a_turn(numbers: Counts, per_revolution: int, last: int) -> bool:
    """Return whether numbers of pulses lie one revolution apart, from the first to the last."""
    return bool(
        numbers.size > 1
        and (np.diff(numbers) == per_revolution).all()
        and numbers[0] <= per_revolution
        and numbers[-1] + per_revolution > last
    )


def _longer_tooth(rises: Rises, numbers: Counts, per_revolution: int) -> tuple[int, str]:
    """Return the number of the first pulse that is longer than the others, and what it is."""
    parts = rises.widths[:-1] * np.diff(numbers) / np.diff(rises.times)
    known = np.isfinite(parts)
    tooth = numbers[:-1][known] % per_revolution
    seen = np.bincount(tooth, minlength=per_revolution)
    if seen.min() < 2:
        return 0, ""
    means = np.bincount(tooth, parts[known], per_revolution) / seen
    second, most = np.sort(means)[-2:]
    return (int(means.argmax()), LONG) if most > LONG_TOOTH * second else (0, "")
