"""Decide on which response a motion settles: observe it window after window, and name its kind.

The decision is the same for one disc and for a rotor system. Each implements `Motion`, which
measures one window.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from rotor_ida.arrays import ROUNDING, Values
from rotor_ida.steady.periods import Recurrence
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
)

# Windows double up to this multiple of the first, for periods of many revolutions.
LONGEST_WINDOW = 8
# A motion recurs if it misses itself by at most this multiple of the tolerance for steady motion:
# it may be that far on either side of its cycle.
RECURS = 10.0
# An exponent is nonzero when it exceeds this many errors,
CLEAR_ERRORS = 5.0
# and when neighbours diverge by exp(20), 5e8, in the averaging time.
CLEAR_STRETCH = 20.0
# It is zero when neighbours neither diverge nor converge by 1 % in that time, in which clear chaos
# would have shown. The errors are those of the scatter of parts; on a torus the mean over all parts
# is far better.
NO_STRETCH = 0.01
# A motion that sits on an unstable equilibrium, whirl or cycle is displaced by this part of the
# (smallest) clearance and followed on; at most this often.
DISTURBANCE, MOST_DISTURBED = 1e-3, 4
# A multiplier above 1 by no more than this is one of a neutral motion.
NEUTRAL = 1e-5


@dataclass(frozen=True, slots=True)
class Exponents:
    """The largest Lyapunov exponents of a motion, over the unit of time.

    Parameters
    ----------
    values, errors : ndarray, shape (n,)
        The exponents, the largest first, and their standard errors.
    duration : float
        The time over which they are means.
    zeros : int
        How many of them are zero on a torus.
    has_tori : bool
        Whether there can be a torus.
    no_stretch : float
        By how much neighbours diverge or converge at most over the duration where one is zero.
    """

    values: Values
    errors: Values
    duration: float
    zeros: int
    has_tori: bool
    no_stretch: float = NO_STRETCH


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


class Motion(Protocol):
    """A motion that is followed window after window, with what is asked of the last window."""

    @property
    def time(self) -> float:
        """Time since the start."""

    @property
    def steady(self) -> float:
        """Largest deviation of a motion that counts as steady, relative to its size."""

    @property
    def touches(self) -> int:
        """Number of entries and exits in the window."""

    @property
    def ends_in_contact(self) -> bool:
        """Whether the window ends in contact."""

    @property
    def never_settles(self) -> bool:
        """Whether nothing can settle, so that one window is enough."""

    def wait(self, duration: float) -> None:
        """Follow the motion without a window."""

    def observe(self, times: int) -> None:
        """Follow the motion over a window whose length is a multiple of that of the first."""

    def kind_of_state(self) -> str | None:
        """Return the kind where one state decides it, or at rest; None elsewhere."""

    def recurrence(self) -> Recurrence | None:
        """Return how the motion repeats itself throughout the window; None if it does not."""

    def slowest_multiplier(self, period: float) -> complex:
        """Return the nontrivial multiplier with which neighbours return most slowly."""

    def leave_unstable(self) -> bool:
        """Disturb a motion that sits on an unstable whirl or cycle, and return whether it did."""

    def held_back(self, multiplier: complex) -> float:
        """Return the difference of states a period apart over their distance from the cycle."""

    def stands_still(self) -> bool:
        """Return whether a motion that recurs is a synchronous whirl if it is in contact."""

    def rolls_backwards(self, period: float | None = None) -> bool:
        """Return whether it is a dry whip, by every period or by every revolution."""

    def fading(self) -> tuple[bool, bool]:
        """Return whether touches fade by their law, and whether they grow slighter by any law."""

    def may_be_chaotic(self, duration: float) -> bool:
        """Return whether a motion that has not settled in that time may never settle."""

    def exponents(self) -> Exponents:
        """Return the largest Lyapunov exponents of the motion after the window."""

    def followed(self) -> str:
        """Return for how long the motion was followed, in words."""

    def still_moves(self) -> str:
        """Return what keeps a motion without touches from being decided, in words."""


@dataclass(slots=True)
class _Approach:
    """The distance of a motion from its cycle, from window to window.

    Parameters
    ----------
    recurs : bool
        Whether the motion repeated itself in the last window.
    distance : float
        Its distance from its cycle at the end of that window, relative to its size [1].
    time : float
        The time of that end [1].
    since : float
        The time of the start, or of the last disturbance [1].
    """

    recurs: bool = False
    distance: float = math.inf
    time: float = 0.0
    since: float = 0.0

    def period(self, motion: Motion) -> float | None:
        """Return the period of a motion that has reached a stable cycle; None for others."""
        repeats = motion.recurrence()
        self.recurs = repeats is not None
        if repeats is None:
            self.distance = math.inf
            return None
        multiplier = motion.slowest_multiplier(repeats.period)
        if not abs(multiplier) < 1.0:
            self.distance = math.inf
            return None
        decay = abs(multiplier) ** ((motion.time - self.time) / repeats.period)
        distance = repeats.missed_by / max(motion.held_back(multiplier), ROUNDING)
        if math.isfinite(self.distance):
            # because of rounding no motion misses itself by less, however near it is
            distance = min(distance, decay * self.distance)
        self.distance, self.time = distance, motion.time
        return repeats.period if distance <= motion.steady else None


def growing_direction(derivative: Values) -> Values | None:
    """Return how a state changes that grows by a derivative of states; None where none grows.

    It is the growing part of a fixed state, so that rounding has no influence on its sense.
    """
    multipliers, shapes = np.linalg.eig(derivative)
    grows = np.abs(multipliers) > 1.0 + NEUTRAL
    if not grows.any():
        return None
    any_state = np.linspace(1.0, 2.0, len(derivative)).astype(complex)
    parts = np.linalg.lstsq(shapes, any_state)[0]
    return np.asarray((shapes[:, grows] @ parts[grows]).real)


def decide(motion: Motion, wait: float, longest: float) -> Decision:
    """Observe a motion, window after window, until its kind is decided.

    The first window begins after `wait`, each other when the time has doubled, and none after
    `longest`. Times are counted anew when it was disturbed because it sat on an unstable motion.
    """
    approach, times, first, disturbed = _Approach(), 1, wait, 0
    while True:
        motion.wait(wait)
        motion.observe(times)
        decision = _decision(motion, approach)
        sits = (decision.kind == SYNCHRONOUS or approach.recurs) and decision.period is None
        if sits and disturbed < MOST_DISTURBED and motion.leave_unstable():
            disturbed += 1
            approach = _Approach(time=motion.time, since=motion.time)
            wait, times = first, 1
            continue
        wait, times = motion.time - approach.since, min(2 * times, LONGEST_WINDOW)
        late = motion.time + wait > approach.since + longest
        if decision.kind != UNRESOLVED or motion.never_settles or late:
            return _with_disturbances(decision, disturbed)


def _with_disturbances(decision: Decision, count: int) -> Decision:
    """Return a decision that tells how often an unresolved motion was disturbed."""
    if decision.kind != UNRESOLVED or not count:
        return decision
    times = "once" if count == 1 else f"{count} times"
    told = f"; {times} it sat on an unstable whirl or cycle and was disturbed"
    return replace(decision, message=decision.message + told)


def _decision(motion: Motion, approach: _Approach) -> Decision:
    """Return the kind of a motion, as its last window shows it."""
    kind = motion.kind_of_state()
    if kind is not None:
        tried = _what_was_tried(motion, approach, math.nan) if kind == UNRESOLVED else ""
        return Decision(kind, message=tried)
    period = approach.period(motion)
    if period is not None:
        return Decision(_kind_of_cycle(motion, period), period, distance=approach.distance)
    fades, grow_slighter = motion.fading()
    kind, exponent, error = TOUCHING if fades else UNRESOLVED, math.nan, math.nan
    if not (approach.recurs or fades or grow_slighter) and motion.may_be_chaotic(
        motion.time - approach.since
    ):
        if motion.rolls_backwards():
            return Decision(ROLLING)
        kind, exponent, error = _kind_by_exponent(motion.exponents())
    message = ""
    if kind == UNRESOLVED:
        message = _what_was_tried(motion, approach, exponent)
    return Decision(kind, None, exponent, error, message=message)


def _kind_of_cycle(motion: Motion, period: float) -> str:
    """Return the kind of a motion that has reached a cycle."""
    if motion.rolls_backwards(period):
        return ROLLING
    if motion.touches:
        return BOUNCING
    # a contact-free one may pass so near the stator that bounds of its future exceed it
    if not motion.ends_in_contact:
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
    if motion.never_settles:
        return f"{followed}: without damping nothing settles"
    return f"{followed}: {_still_moving(motion, approach, exponent)}"


def _still_moving(motion: Motion, approach: _Approach, exponent: float) -> str:
    """Return what keeps a motion with damping from being decided, in words."""
    if math.isfinite(exponent):
        return "it does not repeat itself, and is neither surely chaotic nor surely quasi-periodic"
    if approach.recurs:
        return "it repeats itself, but " + (
            "its neighbours do not approach its cycle"
            if math.isinf(approach.distance)
            else "its distance from its cycle is estimated as "
            f"{approach.distance:.2g} of its size, where {motion.steady:.2g} is allowed"
        )
    if motion.fading()[1]:
        return "its touches grow slighter, but not yet as fading touches do"
    if motion.touches:
        return f"it does not repeat itself, with {motion.touches} entries and exits in the window"
    if not motion.ends_in_contact:
        return "out of contact, but it may still reach the stator"
    return motion.still_moves()
