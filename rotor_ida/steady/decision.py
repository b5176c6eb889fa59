"""Decide on which response a motion settles: observe it window after window, and name its kind.

`decide` is the loop. After each window `_decision` asks, and the first answer decides:

1. Of one disc: do closed forms show where it stays (at rest, just reaching the stator, whirling
   steadily, free of the stator for good)?
2. Has it reached a stable cycle? It repeats itself, and the multiplier by which neighbours return
   most slowly says how far away the cycle still is (`_Approach.measure`). Which kind of cycle it is
   follows from the window (`_kind_of_cycle`): rolling, bouncing, free, synchronous, full contact.
3. Do its touches fade?
4. Late, if nothing shows that it settles: does it roll backwards? If not, its Lyapunov exponents
   say whether it is chaotic or on a torus (`_kind_by_exponent`).
5. Else it is unresolved, and the next window follows, as long as there is time.

`rotor_ida.steady.response` answers what one window shows, `rotor_ida.steady.motion` follows the
motion and answers what needs further runs, and `limits_of` in `rotor_ida.steady.follow` gives the
times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from rotor_ida.arrays import ROUNDING
from rotor_ida.steady.motion import Exponents, Motion
from rotor_ida.steady.response import (
    BOUNCING,
    CHAOTIC,
    CONTACT_FREE,
    FULL_CONTACT,
    QUASI_PERIODIC,
    ROLLING,
    SYNCHRONOUS,
    TOUCHING,
    UNRESOLVED,
    kind_by_closed_forms,
    rolls_backwards,
    touches_fade,
    touches_grow_slighter,
)

# Windows double up to this multiple of the first, for periods of many revolutions.
LONGEST_WINDOW = 8
# An exponent is nonzero when it exceeds this many errors,
CLEAR_ERRORS = 5.0
# and when neighbours diverge by exp(20), 5e8, in the averaging time.
CLEAR_STRETCH = 20.0
# A motion that sits on an unstable motion is disturbed at most this often.
MOST_DISTURBED = 4
# One that approaches its cycle at a known rate is followed on at the end, at most this often, until
# it has come closer by this exponent, unless that takes more than a multiple of the longest time.
MOST_EXTENSIONS, COMES_CLOSER, MOST_LONGEST = 2, 25.0, 10.0
# The window is then this multiple of the first: under a load a period may have many revolutions.
EXTENDED_WINDOW = 32


@dataclass(frozen=True, slots=True)
class Decision:
    """The kind of a motion, and what it was decided by.

    Parameters
    ----------
    kind : str
        One of the kinds of `rotor_ida.steady.response`.
    period : float or None
        The period of a motion that has reached a cycle.
    exponent, error : float
        The largest Lyapunov exponent and its standard error, where computed.
    distance : float
        Distance from the cycle, relative to the size of the motion; infinite if not estimated.
    message : str
        For how long an unresolved motion was followed, and what still moved; else empty.
    """

    kind: str
    period: float | None = None
    exponent: float = math.nan
    error: float = math.nan
    distance: float = math.inf
    message: str = ""


@dataclass(slots=True)
class _Approach:
    """The distance of a motion from its cycle, from window to window.

    Parameters
    ----------
    recurs : bool
        Whether the motion repeated itself in the last window.
    distance : float
        Its distance from its cycle at the end of that window, relative to its size [dimensionless].
    time : float
        The time of that end [dimensionless].
    since : float
        The time of the start, or of the last disturbance [dimensionless].
    rate : float
        The rate at which it approaches a stable cycle, or 0 where it is not known [dimensionless].
    """

    recurs: bool = False
    distance: float = math.inf
    time: float = 0.0
    since: float = 0.0
    rate: float = 0.0

    def measure(self, motion: Motion) -> float | None:
        """Measure the last window; return the period of a stable cycle it has reached, or None."""
        repeats = motion.recurrence()
        self.recurs, self.rate = repeats is not None, 0.0
        if repeats is None:
            self.distance = math.inf
            return None
        multiplier = motion.slowest_multiplier(repeats.period)
        if not abs(multiplier) < 1.0:
            self.distance = math.inf
            return None
        self.rate = -math.log(max(abs(multiplier), ROUNDING)) / repeats.period
        decay = abs(multiplier) ** ((motion.time - self.time) / repeats.period)
        distance = repeats.missed_by / max(motion.held_back(multiplier), ROUNDING)
        if math.isfinite(self.distance):
            # because of rounding no motion misses itself by less, however near it is
            distance = min(distance, decay * self.distance)
        self.distance, self.time = distance, motion.time
        return repeats.period if distance <= motion.flow.steady else None


def decide(motion: Motion) -> Decision:
    """Observe a motion, window after window, until its kind is decided.

    Without damping one window decides, as nothing settles: most such motions are unresolved.

    The first window begins after a first wait, each other when the time has doubled, and none after
    the longest time: see `rotor_ida.steady.motion.Limits`. One disc that approaches a stable cycle
    by then is followed on, twice at most, until it is there: for up to `MOST_LONGEST` times the
    longest time.

    A motion may sit on an unstable whirl or cycle: it whirls steadily, or repeats itself, and
    still has come to no stable cycle. If small changes of it grow (`Motion.leave_unstable`), it is
    disturbed, and all times are counted anew; if none do, the decision stands.
    """
    approach, times, wait, disturbed = _Approach(), 1, motion.limits.wait, 0
    extended = 0
    while True:
        motion.wait(wait)
        motion.observe(times)
        decision = _decision(motion, approach)
        sits = (decision.kind == SYNCHRONOUS or approach.recurs) and decision.period is None
        if sits and disturbed < MOST_DISTURBED and motion.leave_unstable():
            disturbed += 1
            approach = _Approach(time=motion.time, since=motion.time)
            wait, times = motion.limits.wait, 1
            continue
        wait, times = motion.time - approach.since, min(2 * times, LONGEST_WINDOW)
        late = motion.time + wait > approach.since + motion.limits.longest
        if decision.kind != UNRESOLVED or not motion.flow.has_damping:
            return _with_disturbances(decision, disturbed)
        if late:
            longest = MOST_LONGEST * motion.limits.longest
            comes_closer = approach.rate * longest > COMES_CLOSER and motion.system is None
            if not comes_closer or extended == MOST_EXTENSIONS:
                return _with_disturbances(decision, disturbed)
            # as many times as long as so far, as a load turns once a revolution
            wait *= math.ceil(COMES_CLOSER / approach.rate / wait)
            times = EXTENDED_WINDOW
            extended += 1


def _with_disturbances(decision: Decision, count: int) -> Decision:
    """Return a decision that tells how often an unresolved motion was disturbed."""
    if decision.kind != UNRESOLVED or not count:
        return decision
    times = "once" if count == 1 else f"{count} times"
    told = f"; {times} it sat on an unstable whirl or cycle and was disturbed"
    return replace(decision, message=decision.message + told)


def _decision(motion: Motion, approach: _Approach, *, again: bool = False) -> Decision:
    """Return the kind of a motion, as its last window shows it: see the order above.

    A run that fails has no kind: `rotor_ida.steady.follow` reports that.
    """
    kind = kind_by_closed_forms(motion.window)
    if kind is not None:
        tried = _what_was_tried(motion, approach, math.nan) if kind == UNRESOLVED else ""
        return Decision(kind, message=tried)
    period = approach.measure(motion)
    if period is not None:
        return Decision(_kind_of_cycle(motion, period), period, distance=approach.distance)
    fades = touches_fade(motion.window)
    kind, exponent, error = TOUCHING if fades else UNRESOLVED, math.nan, math.nan
    unsettled = not (approach.recurs or fades or touches_grow_slighter(motion.window))
    if unsettled and motion.may_be_chaotic(motion.time - approach.since):
        if rolls_backwards(motion.window):
            return Decision(ROLLING)
        found = motion.exponents()
        kind, exponent, error = _kind_by_exponent(found)
        # no motion in which time can be shifted has a largest exponent below 0
        approach.rate = -exponent if exponent < -CLEAR_ERRORS * error else 0.0
        if kind == QUASI_PERIODIC and not again and not motion.lasts(found.duration):
            motion.observe(1)  # it was on the way to another motion, whose exponents these are
            return _decision(motion, approach, again=True)
    message = ""
    if kind == UNRESOLVED:
        message = _what_was_tried(motion, approach, exponent)
    return Decision(kind, None, exponent, error, message=message)


def _kind_of_cycle(motion: Motion, period: float) -> str:
    """Return the kind of a motion that has reached a cycle."""
    if rolls_backwards(motion.window, period):
        return ROLLING
    if motion.window.touches:
        return BOUNCING
    # a contact-free one may pass so near the stator that bounds of its future exceed it
    if not motion.window.ends_in_contact:
        return CONTACT_FREE
    return SYNCHRONOUS if motion.stands_still() else FULL_CONTACT


def _kind_by_exponent(found: Exponents) -> tuple[str, float, float]:
    """Return the kind of a motion that never repeats, its largest exponent, and its error."""
    exponent, error = float(found.values[0]), float(found.errors[0])
    if exponent > CLEAR_ERRORS * error and exponent * found.duration > CLEAR_STRETCH:
        return CHAOTIC, exponent, error
    zeros = slice(0, found.zeros)
    are_zero = (np.abs(found.values[zeros]) * found.duration <= found.no_stretch) & (
        found.errors[zeros] * found.duration <= CLEAR_STRETCH
    )
    return QUASI_PERIODIC if are_zero.all() and found.has_tori else UNRESOLVED, exponent, error


def _what_was_tried(motion: Motion, approach: _Approach, exponent: float) -> str:
    """Return for how long an unresolved motion was followed, and what still moved at the end."""
    followed = motion.followed()
    if not motion.flow.has_damping:
        return f"{followed}: without damping nothing settles"
    return f"{followed}: {_still_moving(motion, approach, exponent)}"


def _still_moving(motion: Motion, approach: _Approach, exponent: float) -> str:
    """Return what keeps a motion with damping from being decided, in words."""
    if math.isfinite(exponent):
        return (
            "it approaches a motion that repeats itself only after many revolutions"
            if approach.rate > 0.0
            else "it does not repeat itself, and its Lyapunov exponent does not decide whether it "
            "is chaotic"
        )
    if approach.recurs:
        return (
            "it repeats itself, but neighbouring motions do not approach it"
            if math.isinf(approach.distance)
            else "it approaches a motion that repeats itself, and has nearly settled: the motions "
            f"still differ by {approach.distance:.2g} of their size, where "
            f"{motion.flow.steady:.2g} is allowed"
        )
    if touches_grow_slighter(motion.window):
        return "its touches grow slighter, but not yet as fading touches do"
    if touches := motion.window.touches:
        return f"it does not repeat itself, with {touches} entries and exits in the window"
    if not motion.window.ends_in_contact:
        return "out of contact, but it may still reach the stator"
    return motion.still_moves()
