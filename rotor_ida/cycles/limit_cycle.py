"""Find the limit cycle to which a start leads, or which lies near a guess."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Unpack

import numpy as np
import xarray as xr

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import AT_REST, State, check_instance, check_progress, shown
from rotor_ida.cycles.dataset import cycle_dataset
from rotor_ida.cycles.guess import HOPF, Guess, guess_of, guess_of_system
from rotor_ida.cycles.multipliers import is_stable
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.cycles.shooting import close_orbit, once_round, periods_of
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import (
    RotorSystem,
    SystemParameters,
    changed_system,
    refuse_first,
)
from rotor_ida.parallel import Progress, interruptible, percentage, shows_progress
from rotor_ida.results.in_si import takes_si, takes_system
from rotor_ida.simulation.flow import DiscFlow, Flow
from rotor_ida.simulation.options import Options, check_can_be_followed
from rotor_ida.simulation.starts import Start
from rotor_ida.steady.follow import FAILED, follow_to_steady_state
from rotor_ida.steady.follow import longest_time as longest_of_disc
from rotor_ida.steady.response import BOUNCING, FULL_CONTACT, ROLLING, UNRESOLVED
from rotor_ida.steady.system_motion import longest_time, settle
from rotor_ida.systems.flow import SystemFlow
from rotor_ida.systems.joined import KINDS
from rotor_ida.systems.starts import Start as SystemStart

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


@shows_progress
def limit_cycle(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    start: Start | SystemStart = AT_REST,
    period: float | None = None,
    speed: float | None = None,
    modes: int | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Compute the limit cycle to which a start leads, or which lies near a guess.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. It must turn and be damped. For a `DimensionalRotor` numbers with a unit are in
        SI units, as for `rotor_ida.simulate`; a dataset has its own.
    start : array_like, shape (4,), (q, velocity), "settled", "rest" or Dataset
        ``(x, y, vx, vy)`` at time 0 [1], by default at rest on the axis; of a `RotorSystem` as in
        `simulate`. A start of one disc that returns to itself to a relative 1e-3 is taken as a
        guess of a cycle, stable or not. From any other start the rotor is followed to its
        attractor. Another limit cycle, or one point of a branch, serves as a guess, and of a
        `RotorSystem` one point of a `sweep` that has a period; the end of a run, or of one point of
        a sweep, as a start.
    period : float, optional
        Approximate period of the cycle, or a multiple of it, from 1e-6 to 1e4 [1]: Newton's method
        then begins at the start itself. Under a load it must be a whole number of revolutions to
        within a tenth. That of a `RotorSystem` that is not axisymmetric is rounded to one.
    speed : float, optional
        Spin speed of a `RotorSystem`, not 0; by default that of the start.
    modes : int, optional
        Of a `RotorSystem`, as in `simulate`.
    progress : callable or bool, optional
        Called from time to time with the percentage of the longest time for which the rotor is
        followed, and 100; True shows a bar on standard error.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        ``response``: for a limit cycle ``bouncing`` (intermittent rub), ``full_contact`` (full
        annular rub), or with friction ``rolling`` (dry whip). Otherwise the response found instead,
        also ``quasi_periodic`` or ``not_found``; then all other variables are NaN. The ``period``
        on the rotating axes and ``period_error``, ``radius_min``, ``radius_max``,
        ``contact_count`` in a period, ``largest_force``, ``impulse_per_period``, ``stability``,
        ``residual`` [1]. On ``multiplier``, by decreasing modulus, ``multiplier_real``,
        ``multiplier_imag`` and ``multiplier_error``. On ``t`` one period of ``x y vx vy``, resolved
        on the rotating axes. On ``line`` the spectrum on fixed axes: ``frequency``,
        ``whirl_amplitude`` and ``line_kind``. ``side_line_over_spin`` is the frequency of the
        strongest line other than 1X, over the spin speed. ``whirl_over_spin`` and ``whirl_sense``
        are those of the motion, as of `rotor_ida.whirl_ratio`.

        Of a `RotorSystem` ``contact_count``, ``radius_min``, ``radius_max``, ``largest_force`` and
        ``touched`` are on ``contact``, ``node_radius_min`` and ``node_radius_max`` on ``node``, and
        ``x y vx vy`` on ``(t, node)``; there is no spectrum. On ``component``: ``final_state``, the
        state at its start and end, with the unbalance at angle 0. The attribute ``axes`` tells on
        which axes it closes.

    Raises
    ------
    InputError
        If an argument cannot be used, or ``omega`` or ``zeta`` is 0: then there are no attractors.
    SimulationError
        If Newton's method does not converge from a cycle that was simulated or given.

    Notes
    -----
    On the rotating axes the motion is autonomous. A limit cycle repeats itself there:
    ``phi(s, T) = s`` with the flow phi, a state s and the period T. Newton's method solves this for
    both, by Taylor series that follow the orbit and its derivatives through all entries and exits.
    The multipliers are 1, ``q = exp(-2 zeta T)``, mu and ``q/mu``, so the trace of the monodromy
    matrix gives them all: the flow is conformally symplectic. ``trivial_defect`` and
    ``symplectic_defect`` show how well the integrated matrix satisfies this. The errors are five
    times the largest differences from three more solutions, begun elsewhere on the cycle and with
    30 times the tolerance.

    With contact damping or friction there are no such pairs, and the multipliers are eigenvalues of
    the matrix. Where the disc begins to roll or to slide the other way, friction jumps, and the
    matrix is multiplied by a saltation matrix; if a cycle rolls, one multiplier is 0. Nor has a
    `RotorSystem` pairs; where it has stators without mass the matrix comes from differences of
    runs.

    Under a load, which rotates on the rotating axes, a motion can repeat itself only after whole
    revolutions: ``T = k 2 pi/omega``. The state is that at time 0, when the load points down on
    these axes, a fixed point of the k-th stroboscopic map. No multiplier is trivial, and the
    stability depends on all four. The number k is found from the simulated motion, up to 128. In
    the same way a `RotorSystem` that is not axisymmetric has cycles of whole revolutions, on fixed
    axes.

    References
    ----------
    R. Seydel, "Practical Bifurcation and Stability Analysis", Springer, 2010, chapter 7.
    R. I. Leine, H. Nijmeijer, "Dynamics and Bifurcations of Non-Smooth Mechanical Systems",
    Springer, 2004, chapter 7: the jump of M at a discontinuity, which vanishes at entry and exit.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> cycle = limit_cycle(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0))
    >>> cycle.period.round(12).item(), cycle.contact_count.item()
    (4.56391667538, 1)
    >>> cycle.multiplier_real.values.round(8)
    array([ 1.        , -0.51147221, -0.51147221,  0.52784725])

    The same disc as a system:

    >>> same = limit_cycle(Rotor(omega=2.0, zeta=0.07, delta0=2.0).system(), speed=2.0)
    >>> same.period.round(9).item(), same.contact_count.values
    (4.563916675, array([1]))
    """
    if not isinstance(rotor, RotorSystem):
        disc = one_disc(limit_cycle, rotor, {"speed": speed, "modes": modes, **changed})
        return limit_cycle_disc(disc, start=start, period=period, progress=progress)
    return limit_cycle_system(
        rotor, start=begun(start), speed=speed, period=period, modes=modes, progress=progress,
        **changed,
    )  # fmt: skip


@takes_system
def limit_cycle_system(
    system: RotorSystem, *, start: SystemStart, speed: float | None, period: float | None,
    modes: int | None, progress: Progress | bool | None, **changed: Unpack[SystemParameters],
) -> xr.Dataset:  # fmt: skip
    """Compute the limit cycle of a rotor system: see `limit_cycle`."""
    system = changed_system(limit_cycle, system, changed)
    return _near_guess(guess_of_system(system, start, speed, period, modes), progress)


@takes_si
def limit_cycle_disc(
    rotor: Rotor, *, start: object, period: float | None, progress: Progress | bool | None
) -> xr.Dataset:
    """Compute the limit cycle of one disc: see `limit_cycle`."""
    check_turns_and_settles(check_instance("rotor", rotor, Rotor))
    guess = guess_of(rotor, start, period)
    check_revolutions(guess)
    check_can_be_followed(rotor, _numbers(guess.state), settling=True)
    if guess.rotor != rotor:
        guess = Guess(DiscFlow(rotor), guess.state, guess.period)
    return _near_guess(guess, progress)


def one_disc(
    verb: Callable[..., Any], rotor: object, of_system: Mapping[str, object]
) -> Rotor | DimensionalRotor:
    """Return a first argument that is one disc; refuse another, and keywords of rotor systems."""
    if not isinstance(rotor, Rotor | DimensionalRotor):
        refuse_first(verb, KINDS, rotor)
    for name, value in of_system.items():
        if name not in ("speed", "modes", *SystemParameters.__annotations__):
            raise TypeError(f"{verb.__name__}() got an unexpected keyword argument {name!r}")
        if value is not None:
            raise InputError(f"{name} must be left out with one disc, got {shown(value)}")
    return rotor


def begun(start: Any) -> Any:
    """Return the start of a rotor system: by default None."""
    return None if start is AT_REST else start


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


def checked_guess(rotor: Rotor, start: object) -> Guess:
    """Return the guess given by a start, for a rotor that has limit cycles."""
    guess = guess_of(rotor, start)
    check_turns_and_settles(guess.rotor)
    check_revolutions(guess)
    return guess


def with_period(guess: Guess) -> Guess:
    """Return a guess with its period; without one, the cycle to which it leads."""
    if guess.period is not None:
        return guess
    cycle = cycle_from(guess)
    return Guess(guess.flow, cycle.start, cycle.duration)


def cycle_from(guess: Guess) -> Orbit:
    """Return the limit cycle to which a guess leads; InputError if there is none."""
    if isinstance(guess.flow, DiscFlow):
        check_can_be_followed(guess.rotor, _numbers(guess.state), settling=True)
    cycle, response = interruptible(lambda stop: found_cycle(guess, stop))
    if cycle is None:
        raise InputError(
            f"start must lead to a limit cycle, got one from which the response is {response}"
        )
    return cycle


def _near_guess(guess: Guess, progress: Progress | bool | None) -> xr.Dataset:
    """Return the cycle to which a guess leads, or the response found instead, as a dataset."""
    if guess.special == HOPF:
        raise InputError(
            f"start must be a limit cycle, got a point of kind {HOPF}: continue_cycle follows what "
            "begins there"
        )
    reports, watch = check_progress(progress), list[Callable[[], float]]()
    told = percentage(reports, watch, _longest_time(guess.flow))
    found = interruptible(
        lambda stop: cycle_dataset(guess, *found_cycle(guess, stop, watch)), told=told
    )
    if reports is not None:
        reports(100, 100)
    return found


def _longest_time(flow: Flow) -> float:
    """Return the longest time for which a rotor is followed to its cycle."""
    if isinstance(flow, SystemFlow):
        return longest_time(flow)
    assert isinstance(flow, DiscFlow)
    return longest_of_disc(flow.rotor)


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
    if isinstance(flow, SystemFlow):
        settled = settle(replace(flow.but(rtol=STEADY_STATE_RTOL), watch=watch), state)
        decision = settled.decision
        is_cycle = decision.kind in (BOUNCING, FULL_CONTACT, ROLLING)
        return decision.kind, settled.state, decision.period if is_cycle else None
    assert isinstance(flow, DiscFlow)
    options = Options(method="taylor", rtol=STEADY_STATE_RTOL)
    found = follow_to_steady_state(
        flow.rotor, _numbers(state), options, stop=flow.stop, watch=watch
    )
    if found.response == FAILED:
        raise SimulationError(found.message)
    period = found.features.period
    return found.response, np.array(found.end), None if math.isnan(period) else period


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


def _numbers(state: Values) -> State:
    x, y, vx, vy = state.tolist()
    return x, y, vx, vy
