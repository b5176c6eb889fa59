"""Fit a machine to signals: least squares on order tracks and contact times."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import check_between, check_positive, check_progress
from rotor_ida.errors import RotorError
from rotor_ida.fitting.arguments import Signals, problem_of
from rotor_ida.fitting.problem import FitProblem
from rotor_ida.fitting.records import noise_of
from rotor_ida.fitting.result import CONVERGED, dataset_of
from rotor_ida.fitting.trials import MOST_TRIALS, SearchEnded
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.scales import errors_in_units
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.parallel.interruptible import interruptible

MOST_EVALUATIONS = 100
# A search may end far from its minimum, as its solution is refined to the second of these.
SEARCH_TOLERANCE, TOLERANCE = 1e-6, 1e-10
# Noise that is estimated from residuals is estimated again until it changes by less than this.
SETTLED, MOST_ROUNDS = 1e-3, 5
# Parts of the windows that are fitted in turn when a fit of all of them goes astray.
GROWING = (0.25, 0.5, 0.75, 1.0)
# The search ends when the mean squared residual, over the variance of the noise, is at most this.
NEAR = 2.0
# Initial clearances are these parts of the largest displacement, and the first guess. Damping
# decides whether a rotor reaches the stator, so less damping is tried last.
PARTS = {"clearance": (0.2, 0.35, 0.5, 0.7, 0.85, 0.95), "damping": (0.4, 0.16)}
MOST_BEGINNINGS = 4
# The number of contacts changes with their stiffness, so there may be a minimum at each: a solution
# within the noise is sought again from these multiples of its contact stiffness.
STIFFER = (1.5, 1.0 / 1.5)
# A machine that never touches the stator fits as well if its sum of squares, over the mean square,
# is larger by less than this: two standard errors. It is not tried where a linear estimate of that
# is more than the second.
SAME, MUCH_MORE = 4.0, 100.0


@shows_progress
def fit(
    signals: Signals | Sequence[Signals],
    machine: Rotor | DimensionalRotor | RotorSystem,
    unknown: Sequence[str],
    *,
    orders: npt.ArrayLike = (1,),
    revolutions: int | None = None,
    start: Any = None,
    entries: Any = None,
    exits: Any = None,
    time_error: float | None = None,
    noise: float | None = None,
    confidence: float = 0.95,
    limit: float | None = None,
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Fit parameters of a machine to its signals, with their errors.

    Parameters
    ----------
    signals : Dataset, mapping of str to Dataset, or sequence of them
        Signals of `rotor_ida.read_signals` or `rotor_ida.signals_of`, or runs of one disc: one
        record or several of the same machine, of a run-up, a run-down or one speed. A record of a
        rotor system may have probes at several nodes, with the same times: a mapping by the names
        of the nodes.
    machine : Rotor, DimensionalRotor or RotorSystem
        The known parameters, and first guesses of the unknown ones. The speed of one disc is
        ignored. Use a `Rotor` for dimensionless signals and a `DimensionalRotor` for signals in SI
        units, or a `RotorSystem` in the same units.
    unknown : sequence of str
        Parameters to fit. For a `DimensionalRotor`: ``mass``, ``damping``, ``eccentricity``,
        ``clearance``, ``shaft_stiffness``, ``contact_stiffness``, ``contact_damping``, ``load`` or
        ``friction``. For a `Rotor`: ``zeta``, ``delta0``, ``shaft_stiffness``,
        ``contact_damping``, ``load`` or ``friction``. For a `RotorSystem`: ``damping`` and
        ``stiffness``, factors of the matrices; ``clearance``, ``friction``, ``contact_stiffness``
        and ``contact_damping``, the largest of the contacts, and ``unbalance``, the largest: all
        others keep their ratios to it. For all: ``unbalance_angle``, the angle by
        which the unbalance leads the keyphasor mark [rad]; 0 if it is not fitted. Its first guess
        comes from the phase of the whirl before contact, or is 0 without such a whirl.
    orders : array_like, shape (k,)
        Multiples of the speed whose amplitudes and phases are compared, forward and backward
        [dimensionless]; 0 is the mean position.
    revolutions : int, optional
        Length of the windows, as in `rotor_ida.orders`.
    start : array_like, "settled", "rest", or a sequence of them, optional
        ``(x, y, vx, vy)`` at the beginning of each record, if known, or of a rotor system
        ``(q, velocity)`` or a result that ends there. ``"settled"`` is the steady whirl without
        contact, which follows from the unknowns. By default the first state is fitted too.
    entries, exits : array_like, shape (m,), or a sequence of them, optional
        Measured times at which contacts begin and end, in the time of the signals: for one record,
        or for each.
    time_error : float, optional
        Standard error of these times, in their unit.
    noise : float, optional
        Standard deviation of the noise in x and y, in the unit of the signals. By default it is
        estimated from the residual of the windows after all orders.
    confidence : float
        Probability that an interval contains the true value [dimensionless].
    limit : float, optional
        Longest time to search [s]. A trial that has begun is ended, and the best one is returned.
    progress : callable or bool, optional
        Called with the number of trials simulated and the largest possible number; True shows a bar
        on standard error.

    Returns
    -------
    Dataset
        On ``unknown``: ``estimate``, ``standard_error``, ``lower`` and ``upper`` of the interval,
        ``first_guess``, ``told`` (whether the search converged and the standard error is at most
        half of the value) and ``unit``; on (``unknown``, ``unknown_too``) ``covariance``. Errors,
        intervals and covariance are NaN if the search has not converged. On
        ``window``, over all records, the compared tracks: measured ``forward_whirl_amplitude``,
        ``forward_phase_lag`` and so on, as in `rotor_ida.orders`, and fitted
        ``fitted_forward_whirl_amplitude`` and so on; ``forward_residual_real`` and so on, the
        residuals over their standard errors, without what residuals share (errors of the angle and
        of a slow roll); ``record``, ``t``, ``speed``, and of a rotor system ``node``. On ``touch``,
        where contact times are compared, ``measured_time``, ``fitted_time``, ``event_kind``,
        ``compared``. ``chi_square``, ``degrees_of_freedom`` and ``noise``. The attributes
        ``search``, ``identifiability``, ``remainder`` and ``contact_times`` state in words how the
        search ended (``converged``, or why not, with the best trial as the estimate), how well each
        unknown is identified, whether the residuals are noise, and which contact times are left
        out.

    Raises
    ------
    InputError
        If an argument is invalid, the units do not match, the signals contain no angle, there are
        more unknowns than numbers to compare, or the motion is chaotic.
    SimulationError
        If the first guess cannot be simulated.

    Notes
    -----
    A trial that fails, or takes more than 20 times the work of the first guess, is a poor one. The
    search ends after 200 trials at the latest, or when the derivatives of all have taken 100 times
    the work of those of the first guess.

    If the residuals exceed the noise, all errors are scaled by
    ``sqrt(chi_square/degrees_of_freedom)``. The motion is integrated along the measured speed, so
    run-ups need not be slow. Measured and computed motion pass through the same least squares of
    `rotor_ida.orders`. The residuals of a window are decorrelated and divided by their standard
    errors. One run follows a motion and its derivatives by all unknowns; those by a friction of 0,
    and all with stators without mass, are differences of motions. Those of contact times are
    unbounded at a graze: so contact times count only if the events before and after are more than
    10 of their errors away. The
    covariance is that of least squares, with the initial states fitted too. The angle by a
    keyphasor is a smooth curve through its pulses; the errors of that curve, from pulses with a
    standard error of ``step/sqrt(12)`` and a common one of ``step/10``, are part of the covariance
    of the residuals. An angle that is given at each sample counts as exact. Where a slow roll was
    subtracted (`rotor_ida.subtract_runout`), so is the whirl without contact that the trial has at
    the speeds of the slow roll, and the error of the slow roll is part of the covariance too. The
    covariance holds for white noise that is equal in all directions and small enough for the
    motion to change linearly.

    References
    ----------
    G. A. F. Seber and C. J. Wild, "Nonlinear Regression", Wiley, 1989.

    Examples
    --------
    >>> from rotor_ida import run_up, signals_of
    >>> rotor = Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
    >>> seen = signals_of(run_up(rotor, start=(0, 0, 0, 0), to=2.0, rate=0.01, samples=4001))
    >>> guess = Rotor(omega=0.3, zeta=0.08, delta0=1.8, shaft_stiffness=0.9)
    >>> found = fit(seen, guess, ["zeta", "delta0", "shaft_stiffness"])
    >>> found.estimate.values.round(6)
    array([0.1, 1.5, 1. ])
    """
    level = check_between("confidence", confidence, 0.5, 1.0 - 1e-9)
    progress = check_progress(progress)
    end = math.inf if limit is None else time.monotonic() + check_positive("limit", limit)
    with errors_in_units(getattr(machine, "units", "")):
        problem = problem_of(
            signals, machine, unknown,
            orders=orders, revolutions=revolutions, start=start, entries=entries,
            exits=exits, time_error=time_error, noise=noise,
        )  # fmt: skip
        problem.trials.deadline = end

        def work(stop: Stop) -> tuple[Values, str]:
            problem.trials.stop = stop
            return _solved(problem, noise)

        def told() -> None:
            if progress is not None:
                progress(problem.trials.evaluations, MOST_TRIALS)

        solution, how = interruptible(work, told=told)
        problem.trials.stop = None
        return dataset_of(problem, machine, solution, how, level)


def _solved(problem: FitProblem, noise: float | None) -> tuple[Values, str]:
    """Return the solution, or the best trial, and in words how the search ended."""
    time_error = problem.time_error
    problem.time_error = math.inf
    first = problem.begin()
    try:
        solution, converged = _refined(problem, _searched(problem, first), noise, time_error)
        how = CONVERGED if converged else f"not converged in {problem.trials.evaluations} trials"
        solution = _without_contact(problem, solution)
    except SearchEnded as ended:
        how, converged = str(ended), False
        problem.renew(part=1.0, time_error=time_error)
        solution = problem.best
        _weigh(problem, solution, noise)
    if not converged:
        same = np.array_equal(solution, first)
        found = "no trial is better than the first guess" if same else "this is the best trial"
        how = f"{how}: {found}, and no errors are stated, which hold only near a minimum"
    return solution, how


def _refined(
    problem: FitProblem, solution: Values, noise: float | None, time_error: float
) -> tuple[Values, bool]:
    """Return the solution with contact times, and with the noise if that is not given."""
    problem.renew(time_error=time_error)
    for _ in range(MOST_ROUNDS):
        before, clear = problem.noise, problem.clear
        _weigh(problem, solution, noise)
        problem.renew(shared_errors=problem.errors_in_common(solution))
        solution, converged = _least(problem, solution, TOLERANCE)
        same = all(np.array_equal(each, clear.get(key, [])) for key, each in problem.clear.items())
        if same and abs(problem.noise - before) <= SETTLED * before:
            break
    return solution, converged


def _without_contact(problem: FitProblem, solution: Values) -> Values:
    """Return the solution, or one that never touches the stator if that fits as well.

    Slight touches may be fitted to noise, and then seem to determine the clearance.
    """
    names = [each.role for each in problem.trials.unknown]
    best, _, motions = problem.at(solution)
    if "clearance" not in names or not any(each.touches_stator for each in motions):
        return solution
    place = names.index("clearance")
    free = solution.copy()
    free[place] = 2.0 * max(each.reach for each in motions)

    def more(left: Values) -> float:
        return float((left @ left / (best @ best) - 1.0) * left.size)

    try:
        left, slopes, _ = problem.at(free)
        sizes = np.linalg.norm(slopes, axis=0)
        slopes = slopes / np.where(sizes > 0.0, sizes, 1.0)
        nearest = left - slopes @ np.linalg.lstsq(slopes, left)[0]
        if more(nearest) > MUCH_MORE:
            return solution
        wide = free[place]
        free, _ = _least(problem, free, SEARCH_TOLERANCE)
        free[place] = wide  # where it changes nothing
        return free if more(problem.at(free)[0]) < SAME else solution
    except (RotorError, SearchEnded):
        return solution


def _weigh(problem: FitProblem, solution: Values, noise: float | None) -> None:
    """Estimate the noise from the residuals if none is given; leave out times near a graze."""
    motions = problem.trials.trial(solution).motions
    if noise is None:
        problem.renew(noise=noise_of(problem.trials.records, [each.z for each in motions]))
    problem.renew(clear=problem.clear_in(motions), shared_errors=None)


def _with_clearance(problem: FitProblem, sought: Values) -> Values:
    """Return the guess, with the best of several clearances if that is unknown.

    A motion that never touches the stator does not change with the clearance.
    """
    guesses = [sought, *_scaled(problem, sought, "clearance")]
    return guesses[0] if len(guesses) == 1 else _best_first(problem, guesses)[0]


def _scaled(problem: FitProblem, sought: Values, role: str) -> list[Values]:
    """Return the guess with several clearances or dampings, if these are unknown.

    Clearances are parts of the largest displacement, dampings parts of the guessed damping.
    """
    roles = [each.role for each in problem.trials.unknown]
    if role not in roles:
        return []
    place = roles.index(role)
    size = float(sought[place])
    if role == "clearance":
        size = problem.reach
    guesses = np.tile(sought, (len(PARTS[role]), 1))
    guesses[:, place] = np.array(PARTS[role]) * size
    return list(guesses)


def _best_first(problem: FitProblem, guesses: list[Values]) -> list[Values]:
    """Return the guesses by rising sum of squares."""
    left = [float((problem.left(each) ** 2).sum()) for each in guesses]
    return [guesses[place] for place in np.argsort(left, kind="stable").tolist()]


def _searched(problem: FitProblem, first: Values) -> Values:
    """Return the least-squares solution from a guess that may be far off.

    Poor values of the other unknowns mislead about the clearance. So if the residuals are large,
    it is chosen again with the other unknowns as found. If the motion departs early, as by a jump
    at another speed, its later part has little information: then the first windows are fitted
    first. Last, the search begins at the best of several clearances and dampings. A solution within
    the noise is sought again at other contact stiffnesses.
    """
    guess = _with_clearance(problem, first)
    found: list[tuple[float, Values]] = []
    for begin, parts in _ways(problem, first, guess, found):
        solution, converged = begin, True
        try:
            for part in parts:
                problem.renew(part=part)
                solution, converged = _least(problem, solution, SEARCH_TOLERANCE)
                if not converged:
                    break
        except RotorError:  # this beginning cannot be followed
            converged = False
        problem.renew(part=1.0)
        if not converged:
            continue
        left = problem.at(solution)[0]
        found.append((float((left**2).sum()), solution))
        if found[-1][0] <= NEAR * left.size:
            return _with_stiffness(problem, *found[-1])
    return min(found, key=lambda each: each[0])[1] if found else problem.best


def _with_stiffness(problem: FitProblem, least: float, solution: Values) -> Values:
    """Return the solution, or a better one near another contact stiffness if that is unknown."""
    names = [each.role for each in problem.trials.unknown]
    if "contact_stiffness" not in names:
        return solution
    place = names.index("contact_stiffness")
    begins = np.tile(solution, (len(STIFFER), 1))
    begins[:, place] *= STIFFER
    kept = 0.5 * problem.trials.left_work  # for what refines the solution
    problem.trials.left_work -= kept
    for begin in begins:
        try:
            other, converged = _least(problem, begin, SEARCH_TOLERANCE)
            left = float((problem.at(other)[0] ** 2).sum())
        except RotorError:  # this beginning cannot be followed
            continue
        except SearchEnded:  # what follows ends too, if it is not only the work
            break
        if converged and left < least:
            least, solution = left, other
    problem.trials.left_work = kept + max(problem.trials.left_work, 0.0)
    return solution


def _ways(
    problem: FitProblem, first: Values, guess: Values, found: list[tuple[float, Values]]
) -> Iterator[tuple[Values, tuple[float, ...]]]:
    """Yield the initial guess of each search, and the parts of the windows that it fits in turn."""
    whole = (1.0,)
    yield guess, whole
    if found:
        yield _with_clearance(problem, found[-1][1]), whole
    yield guess, GROWING
    less_damped = [first, *_scaled(problem, first, "damping")]
    guesses = [each for guess in less_damped for each in _scaled(problem, guess, "clearance")]
    others = [each for each in guesses if not np.array_equal(each, guess)]
    for each in _best_first(problem, others)[:MOST_BEGINNINGS]:
        yield each, whole


def _least(problem: FitProblem, first: Values, tolerance: float) -> tuple[Values, bool]:
    """Return the least-squares solution near a guess, and whether it has converged."""
    from scipy.optimize import least_squares  # noqa: PLC0415 - takes long to import

    problem.at(first)
    found = least_squares(
        problem.left, first, problem.slopes, problem.trials.bounds(), method="trf", x_scale="jac",
        ftol=tolerance, xtol=tolerance, gtol=tolerance, max_nfev=MOST_EVALUATIONS,
    )  # fmt: skip
    solution: Values = found.x
    return solution, bool(found.success)
