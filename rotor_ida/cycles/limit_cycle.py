"""Find the limit cycle to which a start leads, or which lies near a guess."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values, Watch
from rotor_ida.checks import AT_REST, check_instance, check_progress
from rotor_ida.cycles.dataset import cycle_dataset
from rotor_ida.cycles.guess import Guess, guess_of
from rotor_ida.cycles.multipliers import is_stable
from rotor_ida.cycles.shooting import (
    Cycle,
    close_orbit,
    once_round,
    period_of,
    revolutions_of,
    sampled_orbit,
)
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress, Stop, interruptible, percentage, shows_progress
from rotor_ida.results.in_si import takes_si
from rotor_ida.simulation.options import Options, check_can_be_followed
from rotor_ida.simulation.starts import Start
from rotor_ida.steady.follow import FAILED, follow_to_steady_state, longest_time
from rotor_ida.steady.response import UNRESOLVED

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


@takes_si
@shows_progress
def limit_cycle(
    rotor: Rotor,
    *,
    start: Start = AT_REST,
    period: float | None = None,
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Compute the limit cycle to which a start leads, or which lies near a guess.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor
        The rotor. It must turn and be damped. For a `DimensionalRotor` numbers with a unit are in
        SI units, as for `rotor_ida.simulate`; a dataset has its own.
    start : array_like, shape (4,), "settled", "rest" or Dataset
        ``(x, y, vx, vy)`` at time 0 [1], by default at rest on the axis; or a word as for
        `rotor_ida.simulate`. A start that returns to itself to a relative 1e-3 is taken as a guess
        of a cycle, stable or not. From any other start the rotor is followed to its attractor.
        Another limit cycle, or one point of a branch, serves as a guess; the end of a run, or of
        one point of a sweep, as a start.
    period : float, optional
        Approximate period of the cycle, or a multiple of it, from 1e-6 to 1e4 [1]: Newton's method
        then begins at the start itself. Under a load it must be a whole number of revolutions to
        within a tenth.
    progress : callable or bool, optional
        Called from time to time with the percentage of the longest time for which the rotor is
        followed, and 100; True shows a bar on standard error.

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
    matrix is multiplied by a saltation matrix; if a cycle rolls, one multiplier is 0.

    Under a load, which rotates on the rotating axes, a motion can repeat itself only after whole
    revolutions: ``T = k 2 pi/omega``. The state is that at time 0, when the load points down on
    these axes, a fixed point of the k-th stroboscopic map. No multiplier is trivial, and the
    stability depends on all four. The number k is found from the simulated motion, up to 128.

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
    """
    check_turns_and_settles(check_instance("rotor", rotor, Rotor))
    progress = check_progress(progress)
    guess = guess_of(rotor, start, period)
    check_revolutions(guess)
    if isinstance(start, xr.Dataset) and guess.rotor != rotor:
        guess = Guess(rotor, guess.state, guess.period)
    check_can_be_followed(rotor, _state_of(guess.state), settling=True)
    watch: Watch = []
    told = percentage(progress, watch, longest_time(rotor))
    cycle, response = interruptible(lambda stop: found_cycle(guess, stop, watch), told=told)
    if progress is not None:
        progress(100, 100)
    return cycle_dataset(rotor, guess, cycle, response)


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
    if guess.period is None or guess.rotor.load == 0.0:
        return
    revolution = period_of(guess.rotor, 1)
    apart = abs(guess.period - period_of(guess.rotor, revolutions_of(guess.rotor, guess.period)))
    if apart > WITHIN_A_REVOLUTION * revolution:
        raise InputError(
            "{name} must be a whole number of revolutions under a load, each of {revolution:.9g}, "
            "got {value}",
            name="period", revolution=revolution, value=guess.period,
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
    cycle = cycle_from(guess.rotor, guess.state)
    return Guess(guess.rotor, cycle.state, cycle.period)


def cycle_from(rotor: Rotor, state: Values) -> Cycle:
    """Return the limit cycle to which a start leads; InputError if there is none."""
    check_can_be_followed(rotor, _state_of(state), settling=True)
    cycle, response = interruptible(lambda stop: found_cycle(Guess(rotor, state), stop))
    if cycle is None:
        raise InputError(
            f"start must lead to a limit cycle, got one from which the response is {response}"
        )
    return cycle


def found_cycle(guess: Guess, stop: Stop, watch: Watch | None = None) -> tuple[Cycle | None, str]:
    """Return the limit cycle to which a guess leads, or None, and the kind of response.

    SimulationError if Newton's method does not converge from a cycle that was simulated or given.
    """
    rotor, state = guess.rotor, guess.state
    if guess.period is not None:
        cycle = once_round(close_orbit(rotor, state, guess.period, stop), stop)
        return cycle, cycle.response
    if rotor.load > 0.0:
        time = _time_of_return_under_load(rotor, state, NEAR_ITSELF, stop)
    else:
        time = _time_of_return(rotor, state, stop)
    near = _near(rotor, state, time, stop)
    if near is not None:
        return near, near.response
    options = Options(method="taylor", rtol=STEADY_STATE_RTOL)
    settled = follow_to_steady_state(rotor, _state_of(state), options, stop=stop, watch=watch)
    if settled.response == FAILED:
        raise SimulationError(settled.message)
    if settled.response == UNRESOLVED and rotor.load > 0.0:
        near = _of_many_revolutions(rotor, np.array(settled.end), stop)
        return near, NOT_FOUND if near is None else near.response
    if math.isnan(settled.features.period):
        unknown = settled.response == UNRESOLVED
        return None, NOT_FOUND if unknown else settled.response
    cycle = close_orbit(rotor, np.array(settled.end), settled.features.period, stop)
    return cycle, cycle.response


def _near(rotor: Rotor, state: Values, time: float | None, stop: Stop) -> Cycle | None:
    """Return the cycle near a start that returns closely to itself; None if it does not."""
    if time is None:
        return None
    try:
        cycle = close_orbit(rotor, state, time, stop)
    except SimulationError:
        return None
    moved = np.linalg.norm(cycle.state - state)
    return cycle if moved <= FARTHER * NEAR_ITSELF * np.linalg.norm(state) else None


def _time_of_return_under_load(
    rotor: Rotor, state: Values, part: float, stop: Stop
) -> float | None:
    """Return the time after which an orbit first returns, to a fraction of its size.

    It is sampled once a revolution, when the load points down on the rotating axes.
    """
    revolution = period_of(rotor, 1)
    ahead = sampled_orbit(rotor, state, revolution, REVOLUTIONS + 1, stop)
    misses = np.linalg.norm(ahead[1:] - state, axis=1)
    back = np.flatnonzero(misses <= part * float(np.linalg.norm(state)))
    return period_of(rotor, int(back[0]) + 1) if back.size else None


def _of_many_revolutions(rotor: Rotor, state: Values, stop: Stop) -> Cycle | None:
    """Return the stable cycle that a motion under a load has reached, if longer than windows."""
    time = _time_of_return_under_load(rotor, state, COME_BACK, stop)
    cycle = _near(rotor, state, time, stop)
    return cycle if cycle is not None and is_stable(cycle.shot) else None


def _time_of_return(rotor: Rotor, state: Values, stop: Stop) -> float | None:
    """Return the time at which an orbit first returns to its start; None if it does not in time."""
    times, misses = returns(rotor, state, RETURN_TIME, FARTHER * NEAR_ITSELF, stop)
    back = np.flatnonzero(misses <= NEAR_ITSELF * float(np.linalg.norm(state)))
    return float(times[back[0]]) if back.size else None


def returns(
    rotor: Rotor, state: Values, duration: float, away: float, stop: Stop
) -> tuple[Values, Values]:
    """Return the times at which an orbit passes its start, and the distances across the motion.

    A passage counts once the orbit has been `away`, relative to the size of the state. One passage
    may give several times close to each other.
    """
    a_revolution = math.ceil(SAMPLES_A_REVOLUTION * rotor.omega / (2.0 * math.pi))
    samples_a_time = max(SAMPLES_A_TIME, a_revolution)
    span, size = 1.0 / samples_a_time, float(np.linalg.norm(state))
    states = sampled_orbit(rotor, state, span, math.ceil(duration * samples_a_time) + 1, stop)
    apart = states - state
    rates = np.gradient(states, span, axis=0)
    ahead = np.einsum("ni,ni->n", apart, rates) / np.einsum("ni,ni->n", rates, rates).clip(1e-300)
    across = np.linalg.norm(apart - ahead[:, None] * rates, axis=1)
    left = np.flatnonzero(np.linalg.norm(apart, axis=1) > away * size)
    passed = np.flatnonzero(np.abs(ahead) <= span)
    passed = passed[passed > left[0]] if left.size else passed[:0]
    return span * passed - ahead[passed], across[passed]


def _state_of(state: Values) -> tuple[float, float, float, float]:
    x, y, vx, vy = state.tolist()
    return x, y, vx, vy
