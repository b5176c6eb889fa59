"""Follow a rotor system at one speed until it has settled, and describe how it moves then."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from rotor_ida.arrays import ComplexValues, Flags, Values
from rotor_ida.core.systems import SystemResult
from rotor_ida.schema import MODE, OF_FRICTION_EVENT_KIND
from rotor_ida.simulation.lyapunov import means_of_rates
from rotor_ida.simulation.orbit import ENTRY
from rotor_ida.simulation.systems.flow import SystemFlow
from rotor_ida.steady.decision import DISTURBANCE, RECURS, Decision, Exponents, decide
from rotor_ida.steady.landing import (
    MOST_REVOLUTIONS,
    SAMPLES_A_REVOLUTION,
    Landing,
    candidates,
    land,
)
from rotor_ida.steady.orbit_extrema import extreme_radii
from rotor_ida.steady.periods import FEWEST_PERIODS, Recurrence
from rotor_ida.steady.response import STEADY, rolls_in_each

# The first wait, in decay times of the slowest free motion, and in revolutions at most.
DECAY_TIMES, LONGEST_FIRST_WAIT = 24.0, 200.0
# No new window begins later than this number of decay times; limits of that in revolutions.
LONGEST_DECAY_TIMES, LONGEST, LONGEST_OF_ALL = 60.0, 1500.0, 4000.0
# A landing is tried after this many revolutions, and whenever this part has been added.
FIRST_TRY, MORE = 6.0, 0.5
# Cost of an attempt: runs over the period for each component of the state. Limits of all attempts:
# attempts over one revolution, and multiples of the time for which the motion has been followed,
# where a cycle is likely and where it is possible.
COST, FREE_TRIES, LIKELY, POSSIBLE = 2.0, 12.0, 6.0, 1.5
# Revolutions at the end of a wait that are examined, and samples of each.
LOOKED_BACK, SAMPLES_OF_WAIT = 2 * MOST_REVOLUTIONS, 32
WINDOW_REVOLUTIONS = 4
# Contacts that move by less than this part of a disturbance move by rounding alone.
UNMOVED = 1e-9
STEADY_TOLERANCES = 10.0
# Exponents are computed only for a motion that has not settled after a number of revolutions, and
# of decay times or of many more revolutions. They are means over this number of revolutions,
LATE, PATIENCE, VERY_LATE = 450.0, 20.0, 1500.0
EXPONENT_REVOLUTIONS = 2000
# or over a multiple of it where neither chaos nor a torus is clear.
LONGER = 4
# Where contacts are linear, what neighbours do jumps at grazes, and the means of their stretching
# over a torus converge slowly.
NO_STRETCH = 0.1
# Revolutions in which small changes align before their growth is averaged; batches of the mean.
ALIGNING, BATCHES = 100, 20


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemFeatures:
    """How a rotor system moves in the last window.

    Parameters
    ----------
    contact_whirl, node_whirl : ndarray of complex, shapes (contact,), (node,)
        Complex amplitudes of the displacements at the spin speed.
    contact_low, contact_high, node_low, node_high : ndarray
        Smallest and largest distances, of the contacts from the centres of their stators.
    largest_force : ndarray, shape (contact,)
        Largest normal forces.
    touches : ndarray of bool, shape (contact,)
        Which contacts touch.
    backward : ndarray of bool, shape (contact,)
        Which contacts stay closed and whirl backwards.
    """

    contact_whirl: ComplexValues
    node_whirl: ComplexValues
    contact_low: Values
    contact_high: Values
    node_low: Values
    node_high: Values
    largest_force: Values
    touches: Values
    backward: Flags


@dataclass(frozen=True, slots=True)
class SettledSystem:
    """The response on which a rotor system has settled.

    Parameters
    ----------
    decision : Decision
        Its kind, and what that was decided by.
    features : SystemFeatures
        The motion over the last window.
    revolutions : float
        For how many revolutions the system was followed.
    state : ndarray, shape (n,)
        The state at the end, as in `SystemFlow`.
    """

    decision: Decision
    features: SystemFeatures
    revolutions: float
    state: Values


def settle(flow: SystemFlow, state: Values) -> SettledSystem:
    """Follow a rotor system from a state until the kind of its response is decided.

    Raises
    ------
    SimulationError
        If the integration fails or is stopped.
    """
    motion = _SystemMotion(flow, state, flow.problem.slowest_decay(flow.speed))
    decision = decide(motion, motion.first_wait, longest_time(flow))
    revolutions = motion.time / flow.revolution
    return SettledSystem(decision, motion.features(), revolutions, motion.state)


def longest_time(flow: SystemFlow) -> float:
    """Return the time after which no new window begins."""
    decay, revolution = flow.problem.slowest_decay(flow.speed), flow.revolution
    decays = LONGEST_DECAY_TIMES / decay if decay > 0.0 else 0.0
    return min(max(decays, LONGEST * revolution), LONGEST_OF_ALL * revolution)


@dataclass(slots=True)
class _SystemMotion:
    """A motion of a rotor system: see `rotor_ida.steady.decision.Motion`."""

    flow: SystemFlow
    state: Values
    decay: float
    time: float = 0.0
    tried: float = 0.0  # revolutions that attempts to land have taken
    landing: Landing | None = None  # where the last wait has led to
    cycle: Landing | None = None  # on which the last window has shown the motion to be
    # the last window
    begin: Values = field(init=False)
    times: Values = field(init=False)
    run: SystemResult = field(init=False)
    strobed: Values = field(init=False)

    # ---- What is asked of a motion ----

    @property
    def steady(self) -> float:
        return max(STEADY, STEADY_TOLERANCES * self.flow.problem.rtol)

    @property
    def touches(self) -> int:
        return int((np.abs(self.run.event_kinds) == ENTRY).sum())

    @property
    def ends_in_contact(self) -> bool:
        return bool((self.run.touches["way"] != MODE["flight"]).any())

    @property
    def never_settles(self) -> bool:
        return not self.flow.problem.has_damping

    def wait(self, duration: float) -> None:
        """Follow the motion for a time in whole revolutions, or until it is on a stable cycle."""
        revolution = self.flow.revolution
        left = max(math.ceil(duration / revolution), 1)
        while left > 0 and self.landing is None:
            part = min(left, max(FIRST_TRY, math.ceil(MORE * self.time / revolution)))
            left -= int(part)
            back = min(int(part), LOOKED_BACK)
            first = (part - back) * SAMPLES_OF_WAIT
            count = np.arange(first, part * SAMPLES_OF_WAIT + 1)
            times = count * (revolution / SAMPLES_OF_WAIT)
            run = self._extend(times)
            if not self.never_settles:
                self._try_to_land(run, times)

    def observe(self, times: int) -> None:
        landing, revolution = self.landing, self.flow.revolution
        period = revolution if landing is None else landing.period
        count = max(FEWEST_PERIODS, math.ceil(WINDOW_REVOLUTIONS * revolution / period))
        if landing is None:
            count *= times
        each = math.ceil(SAMPLES_A_REVOLUTION * max(period / revolution, 1.0))
        self.begin = self.state
        self.times = np.linspace(0.0, count * period, count * each + 1)
        self.run = self._extend(self.times)
        states = self.flow.samples_of(self.run, self.times)[::each]
        races = np.tile(self.state[states.shape[1] :], (len(states), 1))
        self.strobed = np.hstack([states, races])

    def kind_of_state(self) -> str | None:
        return None

    def recurrence(self) -> Recurrence | None:
        landing, self.landing, self.cycle = self.landing, None, None
        if landing is None:
            return None
        if landing.growing is not None:  # rounding may have left it by now
            self.cycle = landing
            return Recurrence(landing.period, 0.0)
        size = float(np.abs(self.strobed).max())
        missed = float(np.abs(np.diff(self.strobed, axis=0)).max()) / (size or 1.0)
        if missed > RECURS * self.steady:
            return None
        self.cycle = landing
        return Recurrence(landing.period, missed)

    def slowest_multiplier(self, period: float) -> complex:
        assert self.cycle is not None
        assert period == self.cycle.period
        return self.cycle.slowest

    def leave_unstable(self) -> bool:
        if self.cycle is None or self.cycle.growing is None:
            return False
        moved = self.cycle.growing
        size, contacts = self.flow.problem.assembly.size, self.flow.problem.assembly.contacts
        places = self.flow.problem.found.rows @ (moved * self.flow.scales)[:size]
        gaps = np.array([each.clearance for each in contacts])
        reach = float((np.hypot(*places.T) / gaps).max(initial=0.0))
        largest = float(np.abs(moved).max())
        # where it does not move the contacts, the state is measured by its own scales
        moved = moved * (DISTURBANCE / (reach if reach > UNMOVED * largest else largest))
        self.state = self.cycle.state + moved
        return True

    def held_back(self, multiplier: complex) -> float:
        return 1.0 - abs(multiplier)

    def stands_still(self) -> bool:
        if self.flow.period is not None or self.cycle is None or self.cycle.is_free:
            return False
        states = self.flow.samples_of(self.run, self.times)
        moved = float(np.abs(states - states[0]).max())
        return moved <= RECURS * self.steady * float(np.abs(states).max())

    def rolls_backwards(self, period: float | None = None) -> bool:
        each = self.flow.revolution if period is None else period
        length = float(self.times[-1])
        return any(
            rolls_in_each(rolling, length, each)
            for number in range(len(self.flow.request.laws))
            if len(rolling := self._rolling(number)) and stays_backward(self.flow, self.run, number)
        )

    def fading(self) -> tuple[bool, bool]:
        return False, False

    def may_be_chaotic(self, duration: float) -> bool:
        if not (self.touches or self.ends_in_contact):
            return False  # a linear motion grows or settles
        revolutions = duration / self.flow.revolution
        patient = self.decay * duration >= PATIENCE or revolutions >= VERY_LATE
        return revolutions >= LATE and patient

    def exponents(self) -> Exponents:
        found = self._exponents(EXPONENT_REVOLUTIONS)
        stretch = abs(float(found.values[0])) * found.duration
        if found.no_stretch < stretch < 1.0:  # on a torus a mean over longer is far better
            return self._exponents(LONGER * EXPONENT_REVOLUTIONS)
        return found

    def _exponents(self, revolutions: int) -> Exponents:
        """Return the largest exponents; in an axisymmetric system one is 0, on a torus one more."""
        count = 2 if self.flow.period is None else 1
        rates = self.flow.growth(self.state, count, ALIGNING + revolutions)
        values, errors = means_of_rates(rates[ALIGNING:], BATCHES)
        return Exponents(
            values, errors, revolutions * self.flow.revolution, count, has_tori=True,
            no_stretch=NO_STRETCH,
        )  # fmt: skip

    def followed(self) -> str:
        told = f"followed for {self.time / self.flow.revolution:,.0f} revolutions"
        if self.decay == 0.0:
            return told
        return f"{told}, {self.decay * self.time:.3g} times the slowest decay time"

    def still_moves(self) -> str:
        moved = np.abs(np.diff(self.strobed, axis=0)).max() / np.abs(self.strobed).max()
        return (
            f"in contact, it still moves by {moved:.2g} of its size from revolution to revolution, "
            f"where {self.steady:.2g} is allowed"
        )

    # ---- Its limits, its runs and its features ----

    @property
    def first_wait(self) -> float:
        """The time before the first window."""
        longest = LONGEST_FIRST_WAIT * self.flow.revolution
        return min(DECAY_TIMES / self.decay, longest) if self.decay > 0.0 else longest

    def _extend(self, times: Values) -> SystemResult:
        run = self.flow.sampled(self.state, times)
        self.state = self.flow.end_of(run)
        self.time += run.time
        return run

    def _try_to_land(self, run: SystemResult, times: Values) -> None:
        """Go to the cycle that the motion leads to, if it shows that it does."""
        late = run.event_times >= times[-1] - 2.0 * self.flow.revolution
        may_stand = not (np.abs(run.event_kinds[late]) == ENTRY).any()
        states = self.flow.samples_of(run, times)
        in_flight = not (run.touches["way"] != MODE["flight"]).any()
        found = candidates(
            self.flow, times, states, may_stand=may_stand, in_flight=may_stand and in_flight
        )
        revolution, each = self.flow.revolution, COST * self.state.size
        for candidate in found:
            cost = each * candidate.period / revolution
            worth = LIKELY if candidate.is_likely else POSSIBLE
            if self.tried + cost > FREE_TRIES * each + worth * self.time / revolution:
                continue
            self.tried += cost
            self.landing = land(self.flow, self.state, candidate)
            if self.landing is not None:
                self.state = self.landing.state
                return

    def _rolling(self, number: int) -> Values:
        """Return when a contact rolls in the window, shape (stretch, 2)."""
        kinds = OF_FRICTION_EVENT_KIND
        own = self.run.event_contacts == number
        edges = [(0.0, bool(self.run.forces[0, number, 3] == MODE["rolling"]))]
        for time, kind in zip(self.run.event_times[own], self.run.event_kinds[own], strict=True):
            edges.append((float(time), bool(kind == kinds["roll"])))
        ends = [time for time, _ in edges[1:]] + [float(self.times[-1])]
        stretches = [(begin, end) for (begin, rolls), end in zip(edges, ends, strict=True) if rolls]
        return np.array(stretches).reshape(-1, 2)

    def features(self) -> SystemFeatures:
        """Return how the system moves in the window."""
        return features_of(self.flow, self.begin, self.times, self.run)


def stays_backward(flow: SystemFlow, run: SystemResult, number: int) -> bool:
    """Return whether a contact stays closed in a run and whirls backwards."""
    own = run.event_kinds[run.event_contacts == number]
    if run.forces[0, number, 3] == MODE["flight"] or (np.abs(own) == ENTRY).any():
        return False
    x, y = flow.problem.found.rows[number]
    z = run.samples @ x + 1j * (run.samples @ y)
    place = z[:, 0] - complex(*flow.problem.assembly.contacts[number].centre)
    backward = (place.conj() * z[:, 1]).imag * math.copysign(1.0, flow.speed)
    return bool(backward.max() < 0.0)


def features_of(
    flow: SystemFlow, begin: Values, times: Values, run: SystemResult
) -> SystemFeatures:
    """Return how a system moves in a run from a state, sampled at equal times from 0 on."""
    found, contacts = flow.problem.found, flow.problem.assembly.contacts
    nodes = found.rows_in_y(flow.problem.assembly.node_rows())
    rows = np.concatenate([found.rows, nodes])
    centres = np.zeros(len(rows), complex)
    centres[: len(contacts)] = [complex(*each.centre) for each in contacts]
    places = np.einsum("kn,tn->tk", rows[:, 0] + 1j * rows[:, 1], run.samples[:, 0]) - centres
    turn = np.exp(-1j * flow.speed * times[:-1, np.newaxis])
    whirl = (places[:-1] * turn).mean(axis=0)
    low, high = extreme_radii(flow, begin, times, run, rows, centres)
    count = len(contacts)
    largest = run.forces[:, :, 0].max(axis=0, initial=0.0)
    table = run.episodes
    numbers = table["contact"].astype(int)
    np.maximum.at(largest, numbers, np.nan_to_num(table["largest_force"]))
    # the peak of an episode is exact
    np.maximum.at(
        high[:count], numbers,
        np.array([contacts[n].clearance for n in numbers], float) + table["peak_root"] ** 2,
    )  # fmt: skip
    return SystemFeatures(
        contact_whirl=whirl[:count], node_whirl=whirl[count:],
        contact_low=low[:count], contact_high=high[:count],
        node_low=low[count:], node_high=high[count:],
        largest_force=largest, touches=largest > 0.0,
        backward=np.array([stays_backward(flow, run, each) for each in range(count)], bool),
    )  # fmt: skip
