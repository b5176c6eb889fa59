"""Continue a limit cycle of a rotor system over the speed: the branch as a labelled dataset."""

from __future__ import annotations

from typing import Unpack

import numpy as np
import xarray as xr

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
from rotor_ida.cycles.system_guess import (
    CLOSING_RTOL,
    CycleProblem,
    as_start_of_system,
    guess_of_system,
)
from rotor_ida.cycles.system_problem import SystemGuess, branch_over_speed
from rotor_ida.errors import InputError
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, interruptible, shows_progress
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder, open_results
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
    guess = _with_period(guess)
    how = {"limits": bounds, "direction": direction, "points": count}
    told: dict[str, object] = how | {
        "start": problem.state_in_q(guess.flow, guess.state),
        "start_speed": guess.flow.speed,
        "start_period": guess.period,
        "start_special": guess.special,
        "start_slope": guess.slope,
    }
    question = Question("continue_cycle", {
        "rotor": system, **how, "modes": modes, "start": as_start_of_system(told),
    })  # fmt: skip
    branch = branch_over_speed(guess, bounds, count)
    ways = WAYS[direction] if branch.both else WAYS["forward"]
    with open_results(study, question.design(), len(ways) * (count - 1), FORM) as kept:
        sides = follow_sides(branch, ways, kept, progress)
    attributes = provenance({"method": "taylor", "rtol": CLOSING_RTOL}) | told
    attributes["limits"] = np.array(bounds)
    return system_branch_dataset(problem, sides).assign_attrs(attributes)


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
