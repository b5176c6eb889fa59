"""Find the limit cycle of a rotor system to which a start leads, or which lies near a guess."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Unpack

import numpy as np
import xarray as xr

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import check_progress
from rotor_ida.cycles.dataset import ERROR_SAFETY
from rotor_ida.cycles.multipliers import multipliers_near, multipliers_of
from rotor_ida.cycles.system_dataset import system_cycle_dataset
from rotor_ida.cycles.system_guess import (
    CLOSING_RTOL,
    CycleProblem,
    check_is_cycle,
    guess_of_system,
)
from rotor_ida.cycles.system_orbit import SystemOrbit, with_tolerance
from rotor_ida.cycles.system_problem import SystemGuess, closed_orbit
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, interruptible, percentage, shows_progress
from rotor_ida.steady.response import BOUNCING, FULL_CONTACT, ROLLING, UNRESOLVED
from rotor_ida.steady.system_motion import longest_time, settle
from rotor_ida.systems.starts import Start

NOT_FOUND = "not_found"
# Tolerance with which the system is followed to its cycle, as by default in a sweep.
SETTLING_RTOL = 1e-10
# The errors are measured by a solution begun elsewhere, with a tolerance looser by this factor.
LOOSER, ELSEWHERE = 30.0, 0.37


@shows_progress
def limit_cycle_system(
    system: RotorSystem,
    *,
    speed: float | None = None,
    start: Start | xr.Dataset = None,
    period: float | None = None,
    modes: int | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Compute the limit cycle of a rotor system to which a start leads, or near a guess.

    Parameters
    ----------
    system : RotorSystem
        The rotor. There must be contacts and damping.
    modes : int, optional
        As in `simulate`.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of the system, as in `simulate`.
    speed : float
        Spin speed, not 0; by default that of the start.
    start : (q, velocity), "settled", "rest", None or Dataset
        Start at time 0, as in `simulate`, from which the system is followed to its
        attractor. Another limit cycle, or one point of a branch or of a `sweep` that has a period,
        serves as a guess.
    period : float, optional
        Approximate period: Newton's method then begins at the start itself. If the system is not
        axisymmetric, it is rounded to whole revolutions.
    progress : callable or bool, optional
        As of one disc.

    Returns
    -------
    Dataset
        ``response``: for a limit cycle ``bouncing``, ``full_contact`` or ``rolling``; otherwise the
        response found instead, and all numbers are NaN. ``period`` with its ``period_error``,
        ``stability``, ``residual`` (the distance of the end from the start, relative to its size)
        and ``trivial_defect``. On ``multiplier``, by decreasing modulus, ``multiplier_real``,
        ``multiplier_imag`` and ``multiplier_error``. On ``contact``: ``contact_count`` in a period,
        ``radius_min``, ``radius_max``, ``largest_force``, ``touched``. On ``node``:
        ``node_radius_min`` and ``node_radius_max``; on ``(t, node)`` one period of ``x y vx vy``.
        On ``component``: ``final_state``, the state at its start and end, with the unbalance at
        angle 0. The attribute ``axes`` tells on which axes it closes.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If Newton's method does not converge from a cycle that was simulated or given.

    Notes
    -----
    An axisymmetric system is autonomous on axes that turn with the unbalance: a limit cycle closes
    there after a period that is not known, and is quasi-periodic on fixed axes unless this is a
    whole number of revolutions. Any other system has cycles of whole revolutions on fixed axes.
    Newton's method finds a state and the period; the derivative of a state after a period follows
    the linearised motion, and jumps where slip ends or turns. The errors are five times the largest
    differences from a second solution, begun elsewhere with 30 times the tolerance.

    Examples
    --------
    One disc as a system:

    >>> from rotor_ida import Rotor
    >>> cycle = limit_cycle_system(Rotor(omega=2.0, zeta=0.07, delta0=2.0).system(), speed=2.0)
    >>> cycle.period.round(9).item(), cycle.contact_count.values
    (4.563916675, array([1]))
    """
    system = changed_system(limit_cycle_system, system, changed)
    problem, begun = CycleProblem.of(system, modes, start)
    guess = guess_of_system(problem, begun, speed, period)
    check_is_cycle(guess)
    progress = check_progress(progress)
    watch: Watch = []
    watched = replace(guess, flow=replace(guess.flow, watch=watch))
    told = percentage(progress, watch, longest_time(guess.flow))
    found = interruptible(lambda stop: _dataset_from(problem, watched, stop), told=told)
    if progress is not None:
        progress(100, 100)
    return found


def _dataset_from(problem: CycleProblem, guess: SystemGuess, stop: Stop) -> xr.Dataset:
    cycle, response = found_cycle(guess, stop)
    errors = (math.nan, np.zeros(0)) if cycle is None else errors_of(cycle)
    return system_cycle_dataset(problem, guess, cycle, response, errors)


def found_cycle(guess: SystemGuess, stop: Stop) -> tuple[SystemOrbit | None, str]:
    """Return the limit cycle to which a guess leads, or None, and the kind of response."""
    flow, state, period = replace(guess.flow, stop=stop), guess.state, guess.period
    if period is None:
        settled = settle(with_tolerance(flow, SETTLING_RTOL), state)
        decision = settled.decision
        if decision.kind not in (BOUNCING, FULL_CONTACT, ROLLING) or decision.period is None:
            unknown = decision.kind == UNRESOLVED
            return None, NOT_FOUND if unknown else decision.kind
        state, period = settled.state, decision.period
    cycle = closed_orbit(flow, state, period)
    return cycle, cycle.response


def errors_of(cycle: SystemOrbit) -> tuple[float, Values]:
    """Return the estimated errors of the period and of the multipliers."""
    looser = with_tolerance(cycle.flow, LOOSER * CLOSING_RTOL)
    begun = ELSEWHERE * cycle.duration if cycle.is_autonomous else cycle.flow.revolution
    other = closed_orbit(looser, cycle.flow.after(cycle.start, begun), cycle.duration)
    multipliers = multipliers_of(cycle)
    apart = np.abs(multipliers_near(multipliers, other) - multipliers)
    errors = ERROR_SAFETY * (apart + np.spacing(np.abs(multipliers)))
    if cycle.is_autonomous:
        errors[np.argmin(np.abs(multipliers - 1.0))] = 0.0
    period = ERROR_SAFETY * (abs(other.duration - cycle.duration) + np.spacing(cycle.duration))
    return float(period), errors
