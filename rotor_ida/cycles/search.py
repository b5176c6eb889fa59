"""Search for a limit cycle: from a start along its motion, or near a guess by Newton's method."""

from __future__ import annotations

import math

import numpy as np

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import State
from rotor_ida.cycles.guess import HOPF, Guess
from rotor_ida.cycles.multipliers import is_stable
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.cycles.shooting import close_orbit, once_round, periods_of
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.flow import DiscFlow, Flow
from rotor_ida.steady.decision import decide
from rotor_ida.steady.follow import limits_of
from rotor_ida.steady.motion import Motion
from rotor_ida.steady.response import BOUNCING, FULL_CONTACT, ROLLING, UNRESOLVED

NOT_FOUND = "not_found"
# The rotor is followed to its cycle with the default tolerance of a sweep; Newton's method then
# refines the cycle.
STEADY_STATE_RTOL = 1e-10
# A start that returns to itself to this fraction of its size is a guess of a nearby cycle, which
# need not attract it.
NEAR_ITSELF = 1e-3
# Time limit for the return: cycles in the sweeps of Fig. 11 have periods up to 44.
RETURN_TIME = 100.0
# The cycle may be farther from the start than the return is, by this factor: an orbit misses itself
# only by its distance from the cycle times 1 - mu. It must also have been away by that distance.
FARTHER = 10.0
# Samples in which a return is sought; between them the motion is interpolated linearly.
SAMPLES_A_TIME = 50
SAMPLES_A_REVOLUTION = 200
# Tolerance of a given period under a load, as a fraction of a revolution.
WITHIN_A_REVOLUTION = 0.1
# Under a load the rotor is sampled once a revolution, over this number of revolutions.
REVOLUTIONS = 128
# A motion that has not settled in shorter windows has reached a cycle if it then misses itself by
# at most this fraction of its size.
COME_BACK = 1e-6


def check_turns_and_settles(rotor: Rotor) -> None:
    """Raise InputError for a rotor that has no limit cycles."""
    for name in ("omega", "zeta"):
        if getattr(rotor, name) == 0.0:
            raise InputError(
                "{name} must be above 0 for a limit cycle, got {value}: nothing settles",
                name=name, value=0.0,
            )  # fmt: skip


def check_revolutions(guess: Guess) -> None:
    """Raise InputError if a period under a load is not a whole number of revolutions."""
    flow, period = guess.flow, guess.period
    if period is None or flow.period is None:
        return
    if abs(period / flow.period - periods_of(flow, period)) > WITHIN_A_REVOLUTION:
        raise InputError(
            "{name} must be a whole number of revolutions under a load, each of {revolution:.9g}, "
            "got {value}",
            name="period", revolution=flow.period, value=period,
        )  # fmt: skip


def check_no_hopf(guess: Guess) -> None:
    """Raise InputError for a Hopf point, which is no limit cycle."""
    if guess.special == HOPF:
        raise InputError(
            f"start must be a limit cycle, got a point of kind {HOPF}: continue_cycle follows what "
            "begins there"
        )


def found_cycle(guess: Guess, stop: Stop, watch: Watch | None = None) -> tuple[Orbit | None, str]:
    """Return the limit cycle to which a guess leads, or None, and the kind of response.

    SimulationError if Newton's method does not converge from a cycle that was simulated or given.
    """
    flow, state, period = guess.flow.but(stop=stop), guess.state, guess.period
    if period is None:
        # that of a system would have to be followed for too long
        is_disc = isinstance(flow, DiscFlow)
        near = _near(flow, state, _time_of_return(flow, state)) if is_disc else None
        if near is not None:
            return near, near.response
        kind, state, period = _settled(flow, state, watch)
        if kind == UNRESOLVED and is_disc and flow.period is not None:
            near = _of_many_revolutions(flow, state)
            return near, NOT_FOUND if near is None else near.response
        if period is None:
            return None, NOT_FOUND if kind == UNRESOLVED else kind
    cycle = once_round(close_orbit(flow, state, period))
    return cycle, cycle.response


def _settled(flow: Flow, state: Values, watch: Watch | None) -> tuple[str, Values, float | None]:
    """Return the response to which a state leads, the state there, and the period of a cycle."""
    flow = flow.but(rtol=STEADY_STATE_RTOL, watch=watch)
    motion = Motion(flow, limits_of(flow), state)
    decision = decide(motion)
    is_cycle = decision.kind in (BOUNCING, FULL_CONTACT, ROLLING)
    return decision.kind, motion.state, decision.period if is_cycle else None


def _near(flow: Flow, state: Values, time: float | None) -> Orbit | None:
    """Return the cycle near a start that returns closely to itself; None if it does not."""
    if time is None:
        return None
    try:
        cycle = close_orbit(flow, state, time)
    except SimulationError:
        return None
    moved = np.linalg.norm(cycle.start - state)
    return once_round(cycle) if moved <= FARTHER * NEAR_ITSELF * np.linalg.norm(state) else None


def _time_under_load(flow: Flow, state: Values, part: float) -> float | None:
    """Return the time after which an orbit first returns, to a fraction of its size.

    It is sampled once a revolution, when the load points down on the rotating axes.
    """
    times = flow.revolution * np.arange(REVOLUTIONS + 1.0)
    misses = np.linalg.norm(flow.states(state, times)[1:] - state, axis=1)
    back = np.flatnonzero(misses <= part * float(np.linalg.norm(state)))
    return float(times[back[0] + 1]) if back.size else None


def _of_many_revolutions(flow: Flow, state: Values) -> Orbit | None:
    """Return the stable cycle that a motion under a load has reached, if longer than windows."""
    cycle = _near(flow, state, _time_under_load(flow, state, COME_BACK))
    return cycle if cycle is not None and is_stable(cycle) else None


def _time_of_return(flow: Flow, state: Values) -> float | None:
    """Return the time at which an orbit first returns to its start; None if it does not in time."""
    if flow.period is not None:
        return _time_under_load(flow, state, NEAR_ITSELF)
    times, misses = returns(flow, state, RETURN_TIME, FARTHER * NEAR_ITSELF)
    back = np.flatnonzero(misses <= NEAR_ITSELF * float(np.linalg.norm(state)))
    return float(times[back[0]]) if back.size else None


def returns(flow: Flow, state: Values, duration: float, away: float) -> tuple[Values, Values]:
    """Return the times at which an orbit passes its start, and the distances across the motion.

    A passage counts once the orbit has been `away`, relative to the size of the state. One passage
    may give several times close to each other.
    """
    a_revolution = math.ceil(SAMPLES_A_REVOLUTION / flow.revolution)
    samples_a_time = max(SAMPLES_A_TIME, a_revolution)
    span, size = 1.0 / samples_a_time, float(np.linalg.norm(state))
    states = flow.states(state, span * np.arange(math.ceil(duration * samples_a_time) + 1.0))
    apart = states - state
    rates = np.gradient(states, span, axis=0)
    ahead = np.einsum("ni,ni->n", apart, rates) / np.einsum("ni,ni->n", rates, rates).clip(1e-300)
    across = np.linalg.norm(apart - ahead[:, None] * rates, axis=1)
    left = np.flatnonzero(np.linalg.norm(apart, axis=1) > away * size)
    passed = np.flatnonzero(np.abs(ahead) <= span)
    passed = passed[passed > left[0]] if left.size else passed[:0]
    return span * passed - ahead[passed], across[passed]


def numbers_in(state: Values) -> State:
    """Return the state of one disc as numbers."""
    x, y, vx, vy = state.tolist()
    return x, y, vx, vy
