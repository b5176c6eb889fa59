"""Folds, period doublings and torus points of limit cycles over two parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
import xarray as xr

from rotor_ida.checks import (
    AT_REST,
    MOST_NUMBERS,
    Names,
    check_choice,
    check_count,
    check_instance,
    check_progress,
    shown,
)
from rotor_ida.cycles.branch import Side, advance
from rotor_ida.cycles.continue_cycle import CONTINUED, FORM, WAYS, check_limits, follow_sides
from rotor_ida.cycles.dataset import branch_dataset, start_attributes
from rotor_ida.cycles.guess import Guess, as_start
from rotor_ida.cycles.limit_cycle import checked_guess, with_period
from rotor_ida.cycles.problems import (
    TESTS,
    TORUS,
    bifurcations_through,
    branch_through,
    may_have_tori,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.in_si import takes_si
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder, open_results
from rotor_ida.simulation.starts import Start

Kind = Literal["fold", "period_doubling", "torus"]

# Points of a branch, each way, on which a first bifurcation is sought: the default of a branch.
MOST_POINTS_OF_BRANCH = 2000


@takes_si
@shows_progress
def bifurcation_curve(
    rotor: Rotor,
    *,
    start: Start = AT_REST,
    kind: Kind,
    parameters: tuple[str, str] = ("omega", "delta0"),
    limits: Mapping[str, tuple[float, float]] | Sequence[tuple[float, float]],
    points: int = 2000,
    study: Folder | None = None,
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Follow a fold, a period doubling or a torus point of limit cycles over two parameters.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor
        The rotor. For a `DimensionalRotor` numbers with a unit are in SI units, as for
        `continue_cycle`.
    start : array_like, shape (4,), "settled", "rest" or Dataset
        A special point of this kind of a branch, ``branch.isel(special=...)``. Or a limit cycle, a
        point of a branch, or a start ``(x, y, vx, vy)`` or word, as for `simulate`, that leads to a
        cycle [1], by default at rest on the axis; then the branch over the first parameter is
        followed to the nearest one.
    kind : {"fold", "period_doubling", "torus"}
        The bifurcation to follow. A torus is born only with contact damping, friction or a load.
    parameters : tuple of str
        The two parameters to vary, as for `continue_cycle`.
    limits : mapping of str to tuple, or two tuples
        The smallest and the largest value of each [1].
    points : int
        The largest number of points each way.
    study : path-like, optional
        Folder in which points are stored as they are found, as for `continue_cycle`.
    progress : callable or bool, optional
        Called with the number of points found and the largest possible number; True shows a bar on
        standard error.

    Returns
    -------
    Dataset
        On ``point`` both parameters and the variables of a branch, see `continue_cycle`. On
        ``special`` the cusps and grazes, with ``special_value`` of the first parameter and
        ``special_second_value`` of the second.

    Raises
    ------
    InputError
        If an argument cannot be used, or no such bifurcation was found within the limits.
    SimulationError
        If Newton's method does not converge to a first point.

    Notes
    -----
    The test function is differentiated by finite differences of the integrated matrix M. The points
    are as exact as those of a branch, as they depend on the equations alone.

    References
    ----------
    Y. A. Kuznetsov, "Elements of Applied Bifurcation Theory", Springer, 2004, chapter 10.

    Examples
    --------
    >>> rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
    >>> curve = bifurcation_curve(rotor, start=(3, 1, 0, 0), kind="fold",
    ...                           limits={"omega": (2.4, 3.2), "delta0": (0.4, 0.6)})
    >>> curve.omega.values[curve.delta0 == 0.5].round(8).item()
    2.53041892
    """
    check_instance("rotor", rotor, Rotor)
    check_choice("kind", kind, tuple(TESTS))
    first, second = _checked_parameters(parameters)
    count = check_count("points", points, minimum=2, maximum=MOST_NUMBERS)
    progress = check_progress(progress)
    guess = checked_guess(rotor, start)
    if kind == TORUS and not may_have_tori(guess.flow):
        raise InputError(
            "contact_damping, friction or load must be above 0 for a torus to be born, got a rotor "
            "with none"
        )
    bounds = _checked_limits((first, second), limits, guess.rotor)
    if guess.special != kind:
        guess = _nearest(guess, kind, first, bounds[0])
    curve = bifurcations_through(guess, kind, (first, second), bounds, count)
    told = {"kind": kind, "points": count}
    question = Question("bifurcation_curve", {
        "rotor": guess.rotor, "start": as_start(guess, (first, second)), **told,
        "parameters": (first, second), "limits": bounds,
    })  # fmt: skip
    ways = WAYS["both"]
    with open_results(study, question.design(), len(ways) * (count - 1), FORM) as kept:
        sides = follow_sides(curve, ways, kept, progress)
    attributes = provenance({"method": "taylor", "flight": "exact"}) | {
        **told,
        "parameters": f"{first} {second}",
        "limits": np.array(bounds).ravel(),
        **start_attributes(guess),
        **question.attribute(),
    }
    dataset = branch_dataset(sides, (first, second), "Bifurcation of limit cycles", kind="curve")
    return dataset.assign_attrs(attributes)


def _checked_parameters(parameters: object) -> tuple[str, str]:
    names = list(parameters) if isinstance(parameters, (tuple, list)) else []
    if len(names) != 2 or not all(isinstance(name, str) for name in names):
        names = []
    if len(set(names) & set(CONTINUED)) != 2:
        raise InputError(
            "parameters must be two of {allowed}, got {given}", allowed=Names(tuple(CONTINUED)),
            given=Names(tuple(names)) if names else shown(parameters),
        )  # fmt: skip
    first, second = names
    return first, second


def _checked_limits(
    names: tuple[str, str], limits: object, rotor: Rotor
) -> tuple[tuple[float, float], tuple[float, float]]:
    pair = limits.tolist() if isinstance(limits, np.ndarray) and limits.shape == (2, 2) else limits
    if isinstance(limits, Mapping):
        if set(limits) != set(names):
            given = Names(tuple(map(str, limits)), "and") if limits else "none"
            raise InputError(
                "limits must be of {names}, got those of {given}", names=Names(names, "and"),
                given=given,
            )  # fmt: skip
        pair = [limits[name] for name in names]
    if not isinstance(pair, (tuple, list)) or len(pair) != 2:
        raise InputError(f"limits must be two pairs of numbers, got {shown(limits)}")
    first, second = (
        check_limits(name, each, rotor) for name, each in zip(names, pair, strict=True)
    )
    return first, second


def _nearest(guess: Guess, kind: str, parameter: str, limits: tuple[float, float]) -> Guess:
    """Return the bifurcation of a kind that is nearest along the branch through a cycle."""
    branch = branch_through(with_period(guess), parameter, limits, MOST_POINTS_OF_BRANCH)
    sides = [Side([branch.first]), Side([branch.first.reversed()])][: 2 if branch.both else 1]
    while not all(side.end for side in sides):
        for side in sides:
            if not side.end:
                advance(branch, side)
            for _, special in side.specials:
                if special.name == kind:
                    orbit = special.point.orbit
                    return Guess(orbit.flow, orbit.start, orbit.duration, kind)
    raise InputError(f"limits must contain a {kind} of the branch through the start, got none")
