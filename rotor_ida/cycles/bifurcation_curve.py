"""Folds, period doublings and torus points of limit cycles over two parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, Unpack

import numpy as np
import xarray as xr

from rotor_ida.checks import (
    AT_REST,
    MOST_NUMBERS,
    Names,
    check_choice,
    check_count,
    check_progress,
    shown,
)
from rotor_ida.cycles.branch import Side, advance
from rotor_ida.cycles.continue_cycle import parameters_of
from rotor_ida.cycles.followed_curves import WAYS, check_limits, followed_dataset, guess_for
from rotor_ida.cycles.guess import Guess
from rotor_ida.cycles.limit_cycle import with_period
from rotor_ida.cycles.problems import (
    TESTS,
    TORUS,
    bifurcations_through,
    branch_through,
    may_have_tori,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.studies.results import Folder
from rotor_ida.simulation.flow import Flow
from rotor_ida.simulation.starts import Start
from rotor_ida.simulation.systems.flow import SystemFlow

Kind = Literal["fold", "period_doubling", "torus"]

# Points of a branch, each way, on which a first bifurcation is sought: the default of a branch.
MOST_POINTS_OF_BRANCH = 2000


@shows_progress
@takes_rotors(
    system=("modes",), needed=(),
    defaults={
        "start": (AT_REST, None), "parameters": (("omega", "delta0"), ("speed", "clearance")),
    },
)  # fmt: skip
def bifurcation_curve(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    start: Start = AT_REST,
    kind: Kind,
    parameters: tuple[str, str] = ("omega", "delta0"),
    limits: Mapping[str, tuple[float, float]] | Sequence[tuple[float, float]],
    points: int = 2000,
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    speed: float | None = None,
    modes: int | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Follow a fold, a period doubling or a torus point of limit cycles over two parameters.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. For a `DimensionalRotor` numbers with a unit are in SI units, as for
        `continue_cycle`. A system may not have stators without mass.
    start : array_like, shape (4,), (q, velocity), "settled", "rest" or Dataset
        A special point of this kind of a branch, ``branch.isel(special=...)``. Or a limit cycle, a
        point of a branch, or a start ``(x, y, vx, vy)`` or word, as for `simulate`, that leads to a
        cycle [1], by default at rest on the axis; then the branch over the first parameter is
        followed to the nearest one.
    kind : {"fold", "period_doubling", "torus"}
        The bifurcation to follow. A torus is born only with contact damping, friction or a load.
    parameters : tuple of str
        The two parameters to vary, as for `continue_cycle`.
    limits : mapping of str to tuple, or two tuples
        The smallest and the largest value of each, [1] or in its SI unit.
    points : int
        The largest number of points each way.
    study : path-like, optional
        Folder in which points are stored as they are found, as for `continue_cycle`.
    progress : callable or bool, optional
        Called with the number of points found and the largest possible number; True shows a bar on
        standard error.
    speed, modes, contacts, unbalance, supports, gravity, static_force
        Of a `RotorSystem`, as for `continue_cycle`.

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
    check_choice("kind", kind, tuple(TESTS))
    count = check_count("points", points, minimum=2, maximum=MOST_NUMBERS)
    reports = check_progress(progress)
    guess, given = guess_for(bifurcation_curve, rotor, start, speed, modes, changed)
    names = _checked_parameters(parameters, guess.flow)
    _check_can_have(kind, guess.flow)
    bounds = _checked_limits(names, limits, guess.flow)
    if isinstance(start, xr.Dataset) and start.attrs.get("kind") == kind:  # a point of such a curve
        guess = replace(guess, special=kind)
    if guess.special != kind:
        guess = _nearest(guess, kind, names[0], bounds[0])
    told: dict[str, Any] = {"kind": kind, "points": count, "limits": bounds}
    return followed_dataset(
        guess, bifurcations_through(guess, kind, names, bounds, count), "bifurcation_curve", given,
        told, names, WAYS["both"], study, reports,
    )  # fmt: skip


def _check_can_have(kind: str, flow: Flow) -> None:
    """Raise InputError for a bifurcation that cycles cannot have, or that cannot be followed."""
    if kind == TORUS and not may_have_tori(flow):
        raise InputError(
            "contact_damping, friction or load must be above 0 for a torus to be born, got a rotor "
            "with none"
        )
    if isinstance(flow, SystemFlow) and flow.request.massless:
        raise InputError(
            "stators must have a mass for their bifurcations to be followed, got one without: its "
            "multipliers are differences of runs, too inexact for that"
        )


def _checked_parameters(parameters: object, flow: Flow) -> tuple[str, str]:
    known = parameters_of(flow)
    names = list(parameters) if isinstance(parameters, (tuple, list)) else []
    if len(names) != 2 or not all(isinstance(name, str) for name in names):
        names = []
    if len(set(names) & set(known)) != 2:
        raise InputError(
            "parameters must be two of {allowed}, got {given}", allowed=Names(known),
            given=Names(tuple(names)) if names else shown(parameters),
        )  # fmt: skip
    first, second = names
    return first, second


def _checked_limits(
    names: tuple[str, str], limits: object, flow: Flow
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
    first, second = (check_limits(name, each, flow) for name, each in zip(names, pair, strict=True))
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
