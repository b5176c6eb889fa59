"""Continue a limit cycle of a rotor system over the speed: the branch as a labelled dataset."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    MOST_NUMBERS,
    check_choice,
    check_count,
    check_progress,
    check_vector,
    shown,
)
from rotor_ida.cycles.continue_cycle import FORM, WAYS, Direction, follow_sides
from rotor_ida.cycles.system_cycle import found_cycle
from rotor_ida.cycles.system_dataset import system_branch_dataset
from rotor_ida.cycles.system_guess import CLOSING_RTOL, CycleProblem, guess_of_system
from rotor_ida.cycles.system_problem import SystemGuess, branch_over_speed
from rotor_ida.errors import InputError
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, interruptible, shows_progress
from rotor_ida.results.provenance import computing, provenance
from rotor_ida.results.studies.results import Folder, open_results
from rotor_ida.systems.archived import design_of_problem
from rotor_ida.systems.starts import Start


@shows_progress
def continue_cycle_system(
    system: RotorSystem,
    *,
    limits: tuple[float, float],
    speed: float | None = None,
    start: Start | xr.Dataset = None,
    modes: int | None = None,
    direction: Direction = "both",
    points: int = 2000,
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Follow a limit cycle of a rotor system over the speed, around folds and through grazes.

    Parameters
    ----------
    system, modes
        As in `limit_cycle`.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of the system, as in `simulate`.
    limits : tuple of float
        Smallest and largest speed, both of the same sign.
    speed : float
        Speed at the start; by default that of the start.
    start : (q, velocity), "settled", "rest", None or Dataset
        A start that leads to the cycle; or the result of `limit_cycle`; or one point of a
        branch or of a `sweep`; or one special point of a branch, where the branch of doubled cycles
        is followed from a period doubling; or a Hopf point of `special_speeds`, where the cycles
        born from that rub are followed.
    direction : {"both", "forward", "backward"}
        Forward is towards larger speeds, or from a point of a branch onwards along that branch, or
        from a Hopf point towards larger cycles.
    points : int
        The largest number of points each way.
    study, progress
        As in `continue_cycle` of one disc.

    Returns
    -------
    Dataset
        On ``point``: ``speed`` and, as in `limit_cycle`, the numbers of the cycles. On
        ``special``, in order along the branch: ``special_kind`` (fold, period doubling, torus,
        graze, sliding, hopf, discontinuous), ``special_speed``, ``special_period``,
        ``special_radius_max`` and ``special_state``; ``special_point`` is the point before it.
        Attributes ``closed``, ``first_end``, ``last_end``, ``first_reason`` and ``last_reason`` as
        in `continue_cycle` of one disc.

    Raises
    ------
    InputError
        If an argument cannot be used, or there is no limit cycle to start from.
    SimulationError
        If Newton's method does not converge to a first point.

    Notes
    -----
    The method is that of `continue_cycle` of one disc. No multipliers form pairs: test functions
    are the products of ``1 - mu`` (fold), ``1 + mu`` (period doubling) and ``1 - mu_i mu_j``
    (torus) over the nontrivial multipliers. A branch ends at ``hopf`` where its cycles shrink to
    the synchronous rub from which they are born, located by the eigenvalues of that rub.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> system = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
    >>> branch = continue_cycle_system(system, speed=2.0, limits=(1.7, 2.1))
    >>> branch.special_speed.values.round(6), branch.special_kind.values
    (array([1.803392]), array([2], dtype=int8))
    """
    system = changed_system(continue_cycle_system, system, changed)
    check_choice("direction", direction, tuple(WAYS))
    count = check_count("points", points, minimum=2, maximum=MOST_NUMBERS)
    progress = check_progress(progress)
    problem, begun = CycleProblem.of(system, modes, start)
    guess = guess_of_system(problem, begun, speed)
    bounds = _limits(limits, guess.flow.speed)
    return branch_from(problem, _with_period(guess), bounds, direction, count, study, progress)


def _limits(limits: object, speed: float) -> tuple[float, float]:
    """Return the limits of the speed if they are valid and contain that of the start."""
    values = check_vector("limits", limits)
    if values.size != 2 or not values[0] < values[1] or not values[0] * values[1] > 0.0:
        raise InputError(
            f"limits must be two increasing speeds of the same sign, got {shown(limits)}"
        )
    low, high = values.tolist()
    if not low <= speed <= high:
        raise InputError(
            "{name} must contain the speed of the start, {speed}, got {value}",
            name="limits", speed=speed, value=(low, high),
        )  # fmt: skip
    return low, high


def _with_period(guess: SystemGuess) -> SystemGuess:
    """Return a guess with its period; without one, the cycle to which it leads."""
    if guess.period is not None:
        return guess
    cycle, response = interruptible(lambda stop: found_cycle(guess, stop))
    if cycle is None:
        raise InputError(
            f"start must lead to a limit cycle, got one from which the response is {response}"
        )
    return SystemGuess(guess.flow, cycle.start, cycle.duration)


def branch_from(
    problem: CycleProblem,
    guess: SystemGuess,
    limits: tuple[float, float],
    direction: str,
    points: int,
    study: Folder | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the branch through a guess with its period, as `continue_cycle_system` does."""
    branch = branch_over_speed(guess, limits, points)
    begun: dict[str, object] = {
        "start": problem.state_in_q(guess.flow, guess.state).tolist(),
        "start_speed": guess.flow.speed,
        "start_period": guess.period or math.nan,
        "start_special": guess.special,
        "start_slope": guess.slope,
        "limits": list(limits),
        "direction": direction,
        "points": points,
    }
    held = problem.described()
    design = {
        "kind": "branch_of_system", **begun,
        "problem": design_of_problem(held, problem.assembly.system), **computing(),
    }  # fmt: skip
    ways = WAYS[direction] if branch.both else WAYS["forward"]
    with open_results(study, design, len(ways) * (points - 1), FORM) as kept:
        sides = follow_sides(branch, ways, kept, progress)
    attributes = provenance({"method": "taylor", "rtol": CLOSING_RTOL}) | begun
    attributes |= {name: np.array(begun[name]) for name in ("start", "limits")}
    return system_branch_dataset(problem, sides).assign_attrs(attributes)


def guess_in(problem: CycleProblem, begun: Mapping[str, Any], state: Values) -> SystemGuess:
    """Return the guess from which a branch was followed, from its attributes or its design."""
    flow = problem.at(float(begun["start_speed"]))
    return SystemGuess(
        flow, problem.given_state(flow, state), float(begun["start_period"]),
        str(begun["start_special"]), float(begun["start_slope"]),
    )  # fmt: skip
