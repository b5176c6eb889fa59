"""Find the limit cycle to which a start leads, or which lies near a guess."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import AT_REST, check_instance, check_progress, is_scalar, shown
from rotor_ida.cycles.dataset import cycle_dataset
from rotor_ida.cycles.each_cycle import Jobs, cycles_of_disc, cycles_of_system
from rotor_ida.cycles.guess import Guess, guess_of, guess_of_system
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.cycles.search import (
    check_no_hopf,
    check_revolutions,
    check_turns_and_settles,
    found_cycle,
    numbers_in,
)
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import Parameters
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import (
    RotorSystem,
)
from rotor_ida.model.system_parameters import AnyAxes
from rotor_ida.model.varied import varied_of, varied_system_of
from rotor_ida.parallel import Progress, choose, interruptible, percentage, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.studies.results import Folder
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.options import check_can_be_followed
from rotor_ida.simulation.starts import Start
from rotor_ida.steady.follow import limits_of
from rotor_ida.steady.system_sweep import turning_speeds


@shows_progress
@takes_rotors(system=("modes",), needed=(), defaults={"start": (AT_REST, None)}, varies=True)
def limit_cycle(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    start: Start = AT_REST,
    period: float | None = None,
    speed: npt.ArrayLike | None = None,
    modes: int | None = None,
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[AnyAxes],
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
    speed : float or array_like, shape (n,), optional
        Spin speed of a `RotorSystem`, not 0; by default that of the start. That of a
        `DimensionalRotor` is a parameter of it.
    modes : int, optional
        Of a `RotorSystem`, as in `simulate`.
    progress : callable or bool, optional
        Called from time to time with the percentage of the longest time for which the rotor is
        followed, and 100, or with the numbers of points done and of all; True shows a bar on
        standard error.
    workers, executor, study
        As in `sweep`, for the points.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [1], or of a `DimensionalRotor` by its own, in place of those
        of `rotor`. Each array becomes a dimension of the result, with each value once; all are
        combined, and there is a cycle at each point.
    clearance, friction, unbalance, damping, stiffness : float or array_like, shape (n,), optional
        Parameters of a `RotorSystem`, as in `sweep`; each array becomes a dimension too.
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

        Where a parameter is an array, the numbers of the cycle at each point, with ``status`` and
        ``message``. What lies on ``t`` and ``line`` is left out; of one disc ``x y vx vy`` are the
        state at the start of the period. One point serves as a start.

    Raises
    ------
    InputError
        If an argument cannot be used, or ``omega`` or ``zeta`` is 0: then there are no attractors.
    SimulationError
        If Newton's method does not converge from a cycle that was simulated or given. One of
        several points does not raise: its ``message`` gives the reason.

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

    At each of several speeds:

    >>> cycles = limit_cycle(Rotor(omega=2.0, zeta=0.07, delta0=2.0), omega=[1.9, 2.0])
    >>> cycles.period.dims, cycles.period.values.round(6)
    (('omega',), array([4.800561, 4.563917]))
    """
    jobs: dict[str, Any] = {
        "workers": workers, "executor": executor, "study": study, "progress": progress
    }  # fmt: skip
    if isinstance(rotor, RotorSystem):
        return _cycle_of_system(
            rotor, varied, start=start, speed=speed, period=period, modes=modes, **jobs
        )
    return _cycle_of_disc(
        check_instance("rotor", rotor, Rotor), varied, start=start, period=period, **jobs
    )


def _cycle_of_system(
    system: RotorSystem, changed: AnyAxes, *, start: Any, speed: Any, period: float | None,
    modes: int | None, workers: int | None, executor: str, study: Folder | None,
    progress: Progress | bool | None,
) -> xr.Dataset:  # fmt: skip
    """Compute the limit cycle of a rotor system: see `limit_cycle`."""
    has_axis = hasattr(speed, "__len__") and not isinstance(speed, str)
    has_axis = has_axis and not is_scalar("speed", speed)
    speeds = turning_speeds(speed, "for a limit cycle") if has_axis else np.asarray(np.nan)
    asked = varied_system_of(limit_cycle, system, changed, speeds)
    chosen = choose(executor, workers, compiled=True)
    if asked.dims:
        jobs = Jobs(chosen, study, check_progress(progress))
        return cycles_of_system(asked, start, speed, period, modes, jobs)
    check_no_study(study)
    return _near_guess(guess_of_system(asked.system_at(()), start, speed, period, modes), progress)


def _cycle_of_disc(
    rotor: Rotor, varied: Parameters, *, start: object, period: float | None, workers: int | None,
    executor: str, study: Folder | None, progress: Progress | bool | None,
) -> xr.Dataset:  # fmt: skip
    """Compute the limit cycle of one disc: see `limit_cycle`."""
    asked = varied_of(limit_cycle, rotor, varied, always=())
    chosen = choose(executor, workers, compiled=True)
    if asked.dims:
        return cycles_of_disc(asked, start, period, Jobs(chosen, study, check_progress(progress)))
    check_no_study(study)
    rotor = asked.rotor(())
    check_turns_and_settles(rotor)
    guess = guess_of(rotor, start, period)
    check_revolutions(guess)
    check_can_be_followed(rotor, numbers_in(guess.state), settling=True)
    if guess.rotor != rotor:
        guess = Guess(DiscFlow(rotor), guess.state, guess.period)
    return _near_guess(guess, progress)


def check_no_study(study: object) -> None:
    """Raise InputError for the study of one cycle."""
    if study is not None:
        raise InputError(f"study must be left out of one cycle, got {shown(study)}")


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
        check_can_be_followed(guess.rotor, numbers_in(guess.state), settling=True)
    cycle, response = interruptible(lambda stop: found_cycle(guess, stop))
    if cycle is None:
        raise InputError(
            f"start must lead to a limit cycle, got one from which the response is {response}"
        )
    return cycle


def _near_guess(guess: Guess, progress: Progress | bool | None) -> xr.Dataset:
    """Return the cycle to which a guess leads, or the response found instead, as a dataset."""
    check_no_hopf(guess)
    reports, watch = check_progress(progress), list[Callable[[], float]]()
    told = percentage(reports, watch, limits_of(guess.flow).longest)
    found = interruptible(
        lambda stop: cycle_dataset(guess, *found_cycle(guess, stop, watch)), told=told
    )
    if reports is not None:
        reports(100, 100)
    return found
