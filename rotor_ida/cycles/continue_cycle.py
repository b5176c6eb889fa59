"""Follow branches of limit cycles over a parameter, and their bifurcations over two."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, Unpack, get_args

import numpy as np
import xarray as xr

from rotor_ida.arrays import Arrays, Values
from rotor_ida.checks import (
    MOST_NUMBERS,
    Names,
    check_choice,
    check_count,
    check_instance,
    check_progress,
    check_vector,
    shown,
)
from rotor_ida.cycles.branch import CLOSED, Side, SpecialBehind, advance
from rotor_ida.cycles.continuation import Point
from rotor_ida.cycles.dataset import branch_dataset, start_attributes
from rotor_ida.cycles.guess import Guess, as_start, guess_of_system
from rotor_ida.cycles.limit_cycle import checked_guess, with_period
from rotor_ida.cycles.problems import (
    NEVER_ZERO,
    TESTS,
    TORUS,
    Continuation,
    bifurcations_through,
    branch_through,
    may_have_tori,
)
from rotor_ida.cycles.special_points import Special
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.parameters import OF_ROTOR
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder, Form, Results, open_results
from rotor_ida.schema import SPECIAL, by_number
from rotor_ida.simulation.flow import DiscFlow, Flow
from rotor_ida.simulation.starts import Start
from rotor_ida.simulation.system_flow import SystemFlow

Continued = Literal[
    "omega", "zeta", "delta0", "shaft_stiffness", "contact_damping", "load", "friction",
    "disc_radius", "speed", "damping", "clearance", "stiffness", "unbalance",
]  # fmt: skip
Direction = Literal["both", "forward", "backward"]
OF_DISC = tuple(each for each in get_args(Continued) if each in OF_ROTOR)
OF_SYSTEM = (SPEED, *PARAMETERS_OF_SYSTEM)
WAYS: dict[str, tuple[int, ...]] = {"both": (0, 1), "forward": (0,), "backward": (1,)}
# Number of points in each piece that a study stores.
PIECE = 50
# What is stored of these points, as arrays.
KEPT = (
    *("unknowns", "tangents", "special_place", "special_kind", "special_unknowns"),
    *("special_tangents", "length", "end", "reason"),
)
FORM: Form[Arrays] = Form(
    "stretch of a branch", dict, lambda arrays: {name: arrays[name] for name in KEPT}
)
Kind = Literal["fold", "period_doubling", "torus"]

# Points of a branch, each way, on which a first bifurcation is sought: the default of a branch.
MOST_POINTS_OF_BRANCH = 2000


def parameters_of(flow: Flow) -> tuple[str, ...]:
    """Return the parameters over which cycles of a flow can be followed."""
    return OF_DISC if isinstance(flow, DiscFlow) else OF_SYSTEM


@shows_progress
@takes_rotors(
    system=("modes",), needed=(),
    defaults={"parameter": ("omega", "speed")},
)  # fmt: skip
def continue_cycle(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    start: Start = None,
    parameter: Continued = "omega",
    limits: tuple[float, float],
    direction: Direction = "both",
    points: int = 2000,
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    speed: float | None = None,
    modes: int | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Follow a limit cycle over a parameter, around folds and through grazes.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. For a `DimensionalRotor` numbers with a unit are in SI units, as for
        `rotor_ida.simulate`; a dataset has its own.
    start : array_like, shape (4,), (q, velocity), "settled", "rest" or Dataset
        A start that leads to the cycle, as in `limit_cycle`; or the result of `limit_cycle`; or one
        point of a branch or curve, ``branch.isel(point=...)``; or one of its special points,
        ``branch.isel(special=...)``. From a period doubling the branch of doubled cycles is
        followed, from a Hopf point that of the cycles born there. Of a `RotorSystem` also one point
        of a `sweep`, or a Hopf point of `special_speeds`.
    parameter : {"omega", "zeta", "delta0", "shaft_stiffness", "contact_damping", "load", \
            "friction", "disc_radius"}
        The parameter to vary; the others are constant. A load cannot reach 0, where cycles have
        other periods. Of a `DimensionalRotor` also by the names ``speed``, ``damping`` and
        ``clearance``. Of a `RotorSystem` ``speed`` (the default) or a parameter of a `sweep`:
        ``clearance``, ``friction``, ``unbalance``, ``damping`` or ``stiffness``.
    limits : tuple of float
        Its smallest and largest value, [dimensionless] or in its SI unit; speeds of the same sign.
    direction : {"both", "forward", "backward"}
        Direction from the start. Forward is towards larger values of the parameter, or from a point
        of a branch onwards along that branch, or from a Hopf point towards larger cycles. From a
        period doubling there is only one direction.
    points : int
        The largest number of points each way.
    study : path-like, optional
        Folder in which points are stored as they are found. Points that it contains already are not
        computed again; the result is identical bit for bit. It must be new, empty, or of a study of
        the same branch.
    progress : callable or bool, optional
        Called with the number of points found and the largest possible number; True shows a bar on
        standard error.
    speed : float, optional
        Speed of a `RotorSystem` at the start; by default that of the start.
    modes : int, optional
        Of a `RotorSystem`, as in `simulate`.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        On ``point`` the continued parameter, ``period``, ``radius_min``, ``radius_max``,
        ``stability``, ``response``, ``contact_count``, ``largest_force``, ``impulse_per_period``,
        ``trace``, the multipliers, ``residual``, and a state ``x y vx vy`` on the rotating axes
        [dimensionless]. On ``special``, in order along the branch, ``special_kind`` (fold, period
        doubling, graze, torus, sliding, hopf, discontinuous), ``special_value`` of the parameter,
        ``special_period`` and the state there; ``special_point`` is the point before it. The
        attribute ``closed`` is 1 if the branch returns to its beginning. ``first_end`` and
        ``last_end`` are the kinds of its ends, ``first_reason`` and ``last_reason`` explain why no
        step was possible, or what hides the multipliers. Of a `RotorSystem` the numbers on
        ``point`` are those of `limit_cycle`, on ``special`` there are radii at each contact and
        ``special_state``, and over the clearance ``contact_clearance`` is that of each contact.

    Raises
    ------
    InputError
        If an argument cannot be used, or there is no limit cycle to start from.
    SimulationError
        If Newton's method does not converge to a first point.

    Notes
    -----
    Keller's pseudo-arclength continuation of ``(s, T, p)``, a state, the period and the parameter,
    by single shooting with Taylor series of order 19; see docs/cycles.md. Let M be the monodromy
    matrix and ``q = exp(-2 zeta T)``. A fold is a zero of ``2 (1 + q) - tr M``, a period doubling
    one of ``tr M``. At a graze the number of contacts changes: an extremum of the radius touches
    the stator. At a ``sliding`` point the number of roll or reverse events per
    period changes: the slip speed just reaches 0, multipliers jump, and the branch has a corner,
    around which it is followed. At ``discontinuous`` multipliers jump over the unit circle, at such
    a corner or at a graze of a linear or damped contact.

    Derivatives by the state and the parameter are integrated beside the orbit; with stators without
    mass they are differences of runs, known to about 1e-7.

    With contact damping, friction or a load, and of a `RotorSystem`, the multipliers do not form
    such pairs. Then the test functions are the products of ``1 - mu`` and of ``1 + mu`` over the
    nontrivial multipliers, each factor over its size where that is not small. A
    complex pair may cross the unit circle, where the product of ``1 - mu_i mu_j`` is 0: a torus is
    born, on which the motion never repeats. Under a load the period is that of k revolutions,
    ``k 2 pi/omega``, along the whole branch. Special points are located to about 1e-13.

    A branch ends at the limits, closed, at ``halved`` (a doubled cycle has become one of half its
    period), at ``hopf`` (its cycles shrink to the whirl from which they are born, located by the
    closed form), at ``contact_free`` (its last contact vanishes), where no step can be taken, or
    after `points`. With other multipliers than pairs it may end at ``too_unstable``: neighbouring
    orbits separate so far in a period that rounding hides the multipliers, as where the period
    grows without bound.

    References
    ----------
    H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", 1977.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
    >>> branch = continue_cycle(rotor, start=(3, 1, 0, 0), limits=(2.5, 3.2))
    >>> branch.special_value.values.round(6), branch.attrs["first_end"]
    (array([2.530419, 2.681874]), 'limits')

    The same disc as a system, over its friction:

    >>> system = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=10.0).system()
    >>> branch = continue_cycle(system, speed=1.2, start=([3, 1], [0, 0]), parameter="friction",
    ...                         limits=(0.099, 0.101))
    >>> branch.friction.values[[0, -1]], branch.speed.item()
    (array([0.099, 0.101]), 1.2)
    """
    check_choice("direction", direction, tuple(WAYS))
    count = check_count("points", points, minimum=2, maximum=MOST_NUMBERS)
    reports = check_progress(progress)
    guess, given = guess_for(continue_cycle, rotor, start, speed, modes, changed)
    check_choice("parameter", parameter, parameters_of(guess.flow))
    bounds = check_limits(parameter, limits, guess.flow)
    return branch_from(
        with_period(guess), parameter, bounds, count, given, direction, study, reports
    )


def branch_from(
    guess: Guess,
    parameter: str,
    limits: tuple[float, float],
    points: int,
    system: dict[str, Any],
    direction: str = "both",
    study: Folder | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the branch through a guess of a cycle with its period, as `continue_cycle` does."""
    told: dict[str, Any] = {"limits": limits, "direction": direction, "points": points}
    return followed_dataset(
        guess, branch_through(guess, parameter, limits, points), "continue_cycle", system, told,
        (parameter,), WAYS[direction], study, progress,
    )  # fmt: skip


def guess_for(
    verb: Callable[..., Any],
    rotor: Rotor | DimensionalRotor | RotorSystem,
    start: Any,
    speed: float | None,
    modes: int | None,
    changed: SystemParameters,
) -> tuple[Guess, dict[str, Any]]:
    """Return the guess of a cycle to follow, and a rotor system as a question has it."""
    if isinstance(rotor, RotorSystem):
        system = changed_system(verb, rotor, changed)
        guess = guess_of_system(system, start, speed, modes=modes, follows=True)
        return guess, {"rotor": system, "modes": modes}
    return checked_guess(check_instance("rotor", rotor, Rotor), start), {}


def check_limits(parameter: str, limits: object, flow: Flow) -> tuple[float, float]:
    """Return the limits of a parameter if they are valid and contain its value in a flow."""
    values = check_vector("limits", limits)
    low, high = values.tolist() if values.size == 2 else (math.nan, math.nan)
    if not (low < high and (low * high > 0.0 if parameter == SPEED else low >= 0.0)):
        allowed = "speeds of the same sign" if parameter == SPEED else "numbers from 0 on"
        raise InputError(
            f"limits of {{name}} must be two increasing {allowed}, got {{value}}",
            name=parameter, value=tuple(values.tolist()),
        )  # fmt: skip
    if low == 0.0 and parameter in NEVER_ZERO:
        raise InputError(
            "limits of {name} must be above 0, got {value}", name=parameter, value=(low, high)
        )
    if isinstance(flow, DiscFlow):
        _check_can_vary(parameter, flow.rotor)
    here = flow.value_of(parameter)
    if not low <= here <= high:
        raise InputError(
            "limits of {name} must contain that of the start, {here}, got {value}",
            name=parameter, here=here, value=(low, high),
        )  # fmt: skip
    try:
        flow.but(**{parameter: high})
    except SimulationError as error:  # a contact without a radius has no friction
        raise InputError(str(error)) from error
    return low, high


def _check_can_vary(parameter: str, rotor: Rotor) -> None:
    """Raise InputError for a parameter without an effect, or at which cycles differ in kind."""
    if parameter in {"friction", "disc_radius"} and rotor.disc_radius is None:
        raise InputError(f"disc_radius must be given for {parameter} to be continued, got None")
    if parameter == "disc_radius" and rotor.friction == 0.0:
        raise InputError(
            "friction must be above 0 for disc_radius to be continued, got 0.0: without it the "
            "disc has no effect"
        )
    if parameter in {"load", "delta0"} and getattr(rotor, parameter) == 0.0:
        why = ": without a load cycles have other periods" if parameter == "load" else ""
        raise InputError(
            f"{{name}} must be above 0 to be continued, got {{value}}{why}",
            name=parameter, value=0.0,
        )  # fmt: skip


def followed_dataset(
    guess: Guess,
    curve: Continuation,
    verb: str,
    system: dict[str, Any],
    told: dict[str, Any],
    parameters: tuple[str, ...],
    ways: tuple[int, ...],
    study: Folder | None,
    progress: Progress | None,
) -> xr.Dataset:
    """Return a curve that is followed from a guess, which answers a question.

    `system` is a rotor system as the question has it, empty for one disc, and `told` are the
    arguments but the rotor, the start and the names of the parameters.
    """
    rotor = system or {"rotor": guess.rotor}
    names = {"parameter": parameters[0]} if len(parameters) == 1 else {"parameters": parameters}
    question = Question(verb, {**rotor, "start": as_start(guess, parameters), **told, **names})
    ways = ways if curve.both else WAYS["forward"]
    with open_results(study, question.design, len(ways) * (curve.most - 1), FORM) as kept:
        sides = follow_sides(curve, ways, kept, progress)
    attributes = {name: " ".join(np.atleast_1d(each)) for name, each in names.items()}
    dataset = branch_dataset(sides, parameters)
    dataset.attrs |= {
        **provenance({"method": "taylor"}), **told, **attributes,
        "limits": np.ravel(told["limits"]), **start_attributes(guess), **question.attribute(),
    }  # fmt: skip
    return dataset


def follow_sides(
    branch: Continuation, ways: tuple[int, ...], kept: Results[Arrays], progress: Progress | None
) -> tuple[Side, Side]:
    """Follow a curve of cycles forward, 0, and backward, 1; an unused side keeps one point."""
    sides = (Side([branch.first]), Side([branch.first.reversed()]))
    pieces, total = dict(kept.results()), len(ways) * (branch.most - 1)
    for way in ways:
        side = sides[way]
        for number in range(way, 2 * branch.most, 2):
            if side.end:
                break
            if number in pieces:
                _restore(branch, side, pieces[number])
                continue
            begun, specials = len(side.points), len(side.specials)
            while not side.end and len(side.points) < begun + PIECE:
                advance(branch, side)
            added = len(side.points) - begun
            counted = _counted(branch, side, added, total - kept.points_done)
            kept.keep(number, _piece(side, begun, specials), counted)
            if progress is not None:
                progress(kept.points_done, total)
        if side.end == CLOSED:
            break
    return sides


def _counted(branch: Continuation, side: Side, added: int, left: int) -> int:
    """Return the number of points that a piece counts as: the last one includes unused points."""
    if side.end == CLOSED:
        return left
    return added + branch.most - len(side.points) if side.end else added


def _piece(side: Side, begun: int, known: int) -> Arrays:
    """Return the points from `begun` on, and the special points from `known` on, as arrays."""
    points, specials = side.points[begun:], side.specials[known:]
    size = side.points[0].unknowns.size
    return {
        "unknowns": _stacked([point.unknowns for point in points], size),
        "tangents": _stacked([point.tangent for point in points], size),
        "special_place": np.array([place for place, _ in specials], dtype=np.int64),
        "special_kind": np.array([SPECIAL[each.name] for _, each in specials], dtype=np.int64),
        "special_unknowns": _stacked([each.point.unknowns for _, each in specials], size),
        "special_tangents": _stacked([each.point.tangent for _, each in specials], size),
        "length": np.array(side.length),
        "end": np.array(side.end),
        "reason": np.array(side.reason),
    }


def _stacked(rows: list[Values], size: int) -> Values:
    return np.array(rows).reshape(-1, size)


def _restore(branch: Continuation, side: Side, piece: Arrays) -> None:
    """Append the points of a stored piece to a side: the inverse of `_piece`."""
    kinds = by_number(SPECIAL)
    for unknowns, tangent in zip(piece["unknowns"], piece["tangents"], strict=True):
        side.points.append(_point(branch, unknowns, tangent, side.points[-1]))
    for place, kind, unknowns, tangent in zip(
        piece["special_place"].tolist(), piece["special_kind"].tolist(),
        piece["special_unknowns"], piece["special_tangents"], strict=True,
    ):  # fmt: skip
        point = _point(branch, unknowns, tangent, side.points[place])
        side.specials.append(SpecialBehind(place, Special(kinds[kind], point)))
    side.length, side.end = float(piece["length"]), str(piece["end"])
    side.reason = str(piece["reason"])


def _point(branch: Continuation, unknowns: Values, tangent: Values, before: Point) -> Point:
    shot = branch.line.problem.shoot(unknowns)
    direction = branch.line.direction_at(shot, before.direction)
    return Point(unknowns, shot, tangent, direction)


@shows_progress
@takes_rotors(
    system=("modes",), needed=(),
    defaults={
        "parameters": (("omega", "delta0"), ("speed", "clearance")),
    },
)  # fmt: skip
def bifurcation_curve(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    start: Start = None,
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
        cycle [dimensionless], by default at rest; then the branch over the first parameter is
        followed to the nearest one.
    kind : {"fold", "period_doubling", "torus"}
        The bifurcation to follow. A torus is born only with contact damping, friction or a load.
    parameters : tuple of str
        The two parameters to vary, as for `continue_cycle`.
    limits : mapping of str to tuple, or two tuples
        The smallest and the largest value of each, [dimensionless] or in its SI unit.
    points : int
        The largest number of points each way.
    study : path-like, optional
        Folder in which points are stored as they are found, as for `continue_cycle`.
    progress : callable or bool, optional
        Called with the number of points found and the largest possible number; True shows a bar on
        standard error.
    speed, modes, contacts, unbalance, supports, bearings, gravity, static_force
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
