"""A motion that is followed window after window, with what is asked of the last window.

It may be that of one disc or of a rotor system. As runs of a system cost much, Newton's method
tries during the transient whether the motion leads to a cycle (`rotor_ida.steady.landing`), from
which it then continues. One disc is simulated throughout, and closed forms decide its kind where
one state is enough.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.core.runs import Rows
from rotor_ida.simulation.flow import STEADY, DiscFlow, Flow, Window, nontrivial
from rotor_ida.simulation.lyapunov import exponents_of, means_of_rates
from rotor_ida.simulation.system_flow import SAMPLES_A_REVOLUTION, SystemFlow
from rotor_ida.steady.landing import (
    MOST_REVOLUTIONS,
    Landing,
    candidates,
    growing_direction,
    land,
)
from rotor_ida.steady.periods import (
    FEWEST_PERIODS,
    Recurrence,
    recurrence,
    recurrence_by_revolutions,
)

# A motion recurs if it misses itself by at most this multiple of the tolerance for steady motion:
# it may be that far on either side of its cycle.
RECURS = 10.0
# A motion that sits on an unstable equilibrium, whirl or cycle is displaced by this part of the
# (smallest) clearance and followed on.
DISTURBANCE = 1e-3
# A motion that has come to a whirl from farther than this part of its size, and is there to
# rounding, does not leave it: what had grown on the way would show.
FAR = 1e-3
# Contacts that move by less than this part of a disturbance move by rounding alone.
UNMOVED = 1e-9
# An exponent of one disc is a mean over at least this time, and at least this multiple of the
# earlier time.
EXPONENT_TIME, EXPONENT_TIMES = 20_000.0, 2.0
# Those of a system are means over this number of revolutions. Where contacts may be linear, of one
# disc too, they are means over a multiple of the usual time if neither chaos nor a torus is clear.
EXPONENT_REVOLUTIONS, LONGER = 2000, 4
# Revolutions in which small changes align before their growth is averaged; batches of the mean.
ALIGNING, BATCHES = 100, 20
# An exponent is zero when neighbours neither diverge nor converge by 1 % in that time, in which
# clear chaos would have shown. The errors are those of the scatter of parts; on a torus the mean
# over all parts is far better. Where contacts are linear, what neighbours do jumps at grazes, and
# the means of their stretching over a torus converge slowly. Of a system any contact may be linear.
NO_STRETCH, NO_STRETCH_OF_LINEAR = 0.01, 0.1
# A landing is tried after this many revolutions, and whenever this part has been added.
FIRST_TRY, MORE = 6.0, 0.5
# Cost of an attempt: runs over the period for each component of the state. Limits of all attempts:
# attempts over one revolution, and multiples of the time for which the motion has been followed,
# where a cycle is likely and where it is possible.
COST, FREE_TRIES, LIKELY, POSSIBLE = 2.0, 12.0, 6.0, 1.5
# Revolutions at the end of a wait that are examined, and samples of each.
LOOKED_BACK, SAMPLES_OF_WAIT = 2 * MOST_REVOLUTIONS, 32
WINDOW_REVOLUTIONS = 4
# Motions whose largest radii differ by this factor are different motions.
LARGER = 2.0


class Limits(NamedTuple):
    """For how long a motion is followed.

    Parameters
    ----------
    wait, longest : float
        The time before the first window, and that after which no new one begins, except of one
        disc that approaches a stable cycle: `rotor_ida.steady.decision.decide`.
    window, samples : float, int
        Length of the first window, in whole revolutions, and its number of steps.
    decay : float
        The slowest rate of decay.
    late : float
        Exponents are computed only for a motion that has not settled by then, as chaos may be a
        transient.
    """

    wait: float
    longest: float
    window: float
    samples: int
    decay: float
    late: float


class Exponents(NamedTuple):
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
        Whether a torus may be born from a cycle.
    no_stretch : float
        By how much neighbours diverge or converge at most over the duration where one is zero.
    """

    values: Values
    errors: Values
    duration: float
    zeros: int
    has_tori: bool = True
    no_stretch: float = NO_STRETCH


class Events(NamedTuple):
    """The events of one disc in a run, and when that began."""

    began: float
    times: Values
    kinds: npt.NDArray[np.integer[Any]]
    states: Values


@dataclass(slots=True)
class Motion:
    """A motion that is followed.

    Parameters
    ----------
    flow : Flow
        How the rotor moves.
    limits : Limits
        For how long it is followed.
    state : ndarray, shape (n,)
        The state now, on axes that rotate with the unbalance.
    """

    flow: Flow
    limits: Limits
    state: Values
    time: float = 0.0  # since the start
    events: list[Events] = field(default_factory=list)
    # the last window, and how the motion repeats itself in it
    window_start: float = math.nan
    window: Window = field(init=False)
    repeats: Recurrence | None = None
    # of a system: revolutions that attempts to land have taken, where the last wait has led to,
    # and the cycle on which the last window has shown the motion to be
    tried: float = 0.0
    landing: Landing | None = None
    cycle: Landing | None = None
    begun: Values = field(init=False)  # the first state, or that after a disturbance

    def __post_init__(self) -> None:
        self.begun = self.state

    @property
    def system(self) -> SystemFlow | None:
        """The flow of a rotor system, whose runs cost so much that a cycle is sought on the way."""
        return self.flow if isinstance(self.flow, SystemFlow) else None

    # ---- How it is followed ----

    def wait(self, duration: float) -> None:
        """Follow the motion; one of a system in whole revolutions, until it is on a cycle."""
        flow, revolution = self.system, self.flow.revolution
        if flow is None:
            self._extend(np.array([duration]))
            return
        left = max(math.ceil(duration / revolution), 1)
        while left > 0 and self.landing is None:
            part = min(left, max(FIRST_TRY, math.ceil(MORE * self.time / revolution)))
            left -= int(part)
            back = min(int(part), LOOKED_BACK)
            count = np.arange((part - back) * SAMPLES_OF_WAIT, part * SAMPLES_OF_WAIT + 1)
            seen = self._extend(count * (revolution / SAMPLES_OF_WAIT))
            if flow.has_damping:
                self._try_to_land(flow, seen)

    def observe(self, times: int) -> None:
        """Follow the motion over a window whose length is a multiple of that of the first."""
        landing, revolution = self.landing, self.flow.revolution
        length, count, each = self.limits.window, times, self.limits.samples
        if landing is not None:
            length = landing.period
            count = max(FEWEST_PERIODS, math.ceil(WINDOW_REVOLUTIONS * revolution / length))
            each = math.ceil(SAMPLES_A_REVOLUTION * max(length / revolution, 1.0))
        self.window_start, self.repeats = self.time, None
        self.window = self._extend(np.linspace(0.0, count * length, count * each + 1))

    def _extend(self, times: Values) -> Window:
        """Follow the motion on, with time and phase starting from 0 again."""
        seen = self.flow.observed(self.state, times)
        self.events.append(Events(self.time, seen.event_times, seen.event_kinds, seen.event_states))
        self.state = seen.end
        self.time += float(times[-1])
        return seen

    def _try_to_land(self, flow: SystemFlow, seen: Window) -> None:
        """Go to the cycle that the motion leads to, if it shows that it does."""
        revolution, each = flow.revolution, COST * self.state.size
        for candidate in candidates(flow, seen):
            cost = each * candidate.period / revolution
            worth = LIKELY if candidate.is_likely else POSSIBLE
            if self.tried + cost > FREE_TRIES * each + worth * self.time / revolution:
                continue
            self.tried += cost
            self.landing = land(flow, self.state, candidate)
            if self.landing is not None:
                self.state = self.landing.state
                return

    def leave_unstable(self) -> bool:
        """Disturb a motion that sits on an unstable whirl or cycle, and return whether it did."""
        flow, state, growing = self.flow, self.state, None
        if self.cycle is not None:
            state, growing = self.cycle.state, self.cycle.growing
        elif self.system is None and flow.speed > 0.0 and flow.has_damping:
            apart = float(np.abs(self.begun - state).max())
            if self.repeats is None and apart > FAR * float(np.abs(state).max()):
                return False  # it came here from afar
            period = flow.revolution if self.repeats is None else self.repeats.period
            growing = growing_direction(flow.run(state, period).tangents)
        if growing is None:
            return False
        here, there = flow.places(np.array([state, state + growing]))[0]
        # without a clearance the motion itself is the measure
        lengths = np.abs(self.window.places[0]).max(axis=0)
        lengths = np.where(flow.clearances > 0.0, flow.clearances, lengths)
        reach = float((np.abs(there - here) / lengths).max(initial=0.0))
        largest = float(np.abs(growing).max())
        # where it does not move the contacts, the state is measured by its own scales
        size = reach if reach > UNMOVED * largest else largest
        self.state = self.begun = state + growing * (DISTURBANCE / size)
        return True

    def lasts(self, duration: float) -> bool:
        """Return whether the motion is as large a time later, back from there; else stay there."""
        if self.flow.period is not None:
            duration = self.flow.period * math.ceil(duration / self.flow.period)
        state, time = self.state, self.time
        self._extend(np.array([duration]))
        later = self.flow.observed(self.state, self.window.times)
        before, after = (np.abs(each.places[0]).max(axis=0) for each in (self.window, later))
        if not ((after <= LARGER * before) & (before <= LARGER * after)).all():
            return False
        self.events.pop()
        self.state, self.time = state, time
        return True

    # ---- What the window shows ----

    def recurrence(self) -> Recurrence | None:
        """Return how the motion repeats itself throughout the window; None if it does not.

        It takes the landing of the last wait, and keeps the answer in `repeats` and `cycle`.
        """
        landing, self.landing = self.landing, None
        window, tolerance = self.window, RECURS * self.flow.steady
        period = self.flow.period if landing is None else landing.period
        if landing is None and self.system is not None:
            self.repeats = None  # a cycle would have been found on the way
        elif landing is not None and landing.growing is not None:
            self.repeats = Recurrence(landing.period, 0.0)  # rounding may have left it by now
        elif period is None:
            self.repeats = recurrence(turning_points(window), tolerance)
        else:
            size = float(np.abs(window.states).max())
            once = window.once_in(period)
            self.repeats = recurrence_by_revolutions(once, period, size, tolerance)
        self.cycle = None if self.repeats is None else landing
        return self.repeats

    def slowest_multiplier(self, period: float) -> complex:
        """Return the nontrivial multiplier with which neighbours return most slowly."""
        if self.cycle is not None:
            return self.cycle.slowest
        multipliers = nontrivial(self.flow, self.flow.run(self.state, period))
        return complex(multipliers[np.argmax(np.abs(multipliers))])

    def held_back(self, multiplier: complex) -> float:
        """Return the difference of states a period apart over their distance from the cycle."""
        # among many multipliers the slowest does not show which of the others is nearest 1
        many = self.flow.period is not None or self.system is not None
        return 1.0 - abs(multiplier) if many else abs(1.0 - multiplier)

    def stands_still(self) -> bool:
        """Return whether a motion that recurs is a synchronous whirl if it is in contact."""
        if self.flow.period is not None or self.cycle is None or self.cycle.is_free:
            return False
        states = self.window.states
        moved = float(np.abs(states - states[0]).max())
        return moved <= RECURS * self.flow.steady * float(np.abs(states).max())

    def may_be_chaotic(self, duration: float) -> bool:
        """Return whether a motion that has not settled in that time may never settle."""
        # a linear motion grows or settles
        is_linear = not (self.window.touches or self.window.ends_in_contact)
        return duration >= self.limits.late and not is_linear

    def exponents(self) -> Exponents:
        """Return the largest Lyapunov exponents of the motion after the window."""
        found = self._exponents(1)
        stretch = abs(float(found.values[0])) * found.duration
        if found.no_stretch == NO_STRETCH_OF_LINEAR and found.no_stretch < stretch < 1.0:
            return self._exponents(LONGER)  # on a torus a mean over longer is far better
        return found

    def _exponents(self, times: int) -> Exponents:
        """Return the largest exponents, over a multiple of the usual duration."""
        flow = self.system
        if flow is None:
            return _exponents_of_disc(self.flow, self.state, self.time, times)
        return _exponents_of_system(flow, self.state, times * EXPONENT_REVOLUTIONS)

    def followed(self) -> str:
        """Return for how long the motion was followed, in words."""
        turns, decays = self.time / self.flow.revolution, self.limits.decay * self.time
        told = f"{turns:,.0f} revolutions" if turns else f"a time of {self.time:.6g}"
        return f"followed for {told}" + (f", {decays:.3g} decay times" if decays else "")

    def still_moves(self) -> str:
        """Return what keeps a motion without touches from being decided, in words."""
        states, period = self.window.states, self.flow.period
        if period is None or math.isinf(period):
            moved, since = states - states.mean(axis=0), "about its mean whirl"
        else:
            moved = np.diff(self.window.once_in(period), axis=0)
            since = "from revolution to revolution"
        part = float(np.abs(moved).max() / np.abs(states).max())
        return (
            f"in contact, it still moves by {part:.2g} of its size {since}, where "
            f"{self.flow.steady:.2g} is allowed"
        )


def turning_points(window: Window) -> Rows:
    """Return the extrema of the radius of one disc; where its samples show none, they are noise."""
    radii = np.abs(window.places[0])
    return window.extrema if np.ptp(radii) > STEADY * radii.max() else window.extrema[:0]


def _exponents_of_disc(flow: Flow, state: Values, time: float, times: int) -> Exponents:
    """Return the largest exponents of one disc, over a multiple of the usual duration."""
    assert isinstance(flow, DiscFlow)
    rotor, duration = flow.rotor, times * max(EXPONENT_TIME, EXPONENT_TIMES * time)
    x, y, vx, vy = state.tolist()
    found = exponents_of(rotor, (x, y, vx, vy), duration, flow.stop)
    # without a load the exponent of a shift in time is zero, and on a torus one more
    zeros = 1 if rotor.load > 0.0 else 2
    # where multipliers pair no torus is born from a cycle (docs/cycles.md)
    has_tori = flow.pair_product(1.0) is None
    no_stretch = NO_STRETCH_OF_LINEAR if rotor.contact_exponent == 1.0 else NO_STRETCH
    return Exponents(*found, duration, zeros, has_tori, no_stretch)


def _exponents_of_system(flow: SystemFlow, state: Values, revolutions: int) -> Exponents:
    """Return the largest exponents; in an axisymmetric system one is 0, on a torus one more."""
    count, duration = 2 if flow.period is None else 1, revolutions * flow.revolution
    rates = flow.growth(state, count, ALIGNING + revolutions)
    values, errors = means_of_rates(rates[ALIGNING:], BATCHES)
    return Exponents(values, errors, duration, count, no_stretch=NO_STRETCH_OF_LINEAR)
