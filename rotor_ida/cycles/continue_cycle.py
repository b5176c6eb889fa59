"""Continue a limit cycle over a parameter: the branch as a labelled dataset."""

from __future__ import annotations

import os
from typing import Any, Literal, Unpack, get_args

import numpy as np
import xarray as xr

from rotor_ida.arrays import Arrays, Values
from rotor_ida.checks import (
    AT_REST,
    MOST_NUMBERS,
    check_choice,
    check_count,
    check_progress,
    check_vector,
    shown,
)
from rotor_ida.cycles.branch import (
    CLOSED,
    Side,
    SpecialBehind,
    advance,
)
from rotor_ida.cycles.continuation import Point
from rotor_ida.cycles.dataset import branch_dataset, start_attributes
from rotor_ida.cycles.guess import (
    CLOSING_RTOL,
    Guess,
    as_start,
    as_start_of_system,
    guess_of_system,
)
from rotor_ida.cycles.limit_cycle import checked_guess, with_period
from rotor_ida.cycles.problems import NEVER_ZERO, Continuation, branch_through
from rotor_ida.cycles.special_points import Special
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import OF_ROTOR
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Form, Results, open_results
from rotor_ida.schema import SPECIAL, by_number
from rotor_ida.simulation.starts import Start

Parameter = Literal[
    "omega", "zeta", "delta0", "shaft_stiffness", "contact_damping", "load", "friction",
    "disc_radius", "speed", "damping", "clearance",
]  # fmt: skip
CONTINUED: tuple[Parameter, ...] = tuple(each for each in get_args(Parameter) if each in OF_ROTOR)
Direction = Literal["both", "forward", "backward"]

WAYS: dict[str, tuple[int, ...]] = {"both": (0, 1), "forward": (0,), "backward": (1,)}
# Number of points in each piece that a study stores.
PIECE = 50
# What is stored of these points, as arrays.
KEPT = (
    *("unknowns", "tangents", "special_place", "special_kind", "special_unknowns"),
    *("special_tangents", "length", "end"),
)
NO_REASON = {"reason": np.array("")}  # for old files without reasons
FORM: Form[Arrays] = Form(
    "stretch of a branch",
    dict,
    lambda arrays: {name: arrays[name] for name in KEPT} | NO_REASON | arrays,
)


@shows_progress
@takes_rotors(system=("modes",), needed=(), defaults={"start": (AT_REST, None)})
def continue_cycle(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    start: Start = AT_REST,
    parameter: Parameter = "omega",
    limits: tuple[float, float],
    direction: Direction = "both",
    points: int = 2000,
    study: str | os.PathLike[str] | None = None,
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
        point of a branch, ``branch.isel(point=...)``; or one of its special points,
        ``branch.isel(special=...)``. From a period doubling the branch of doubled cycles is
        followed, from a Hopf point that of the cycles born there. Of a `RotorSystem` also one point
        of a `sweep`, or a Hopf point of `special_speeds`.
    parameter : {"omega", "zeta", "delta0", "shaft_stiffness", "contact_damping", "load", \
            "friction", "disc_radius"}
        The parameter to vary; the others are constant. A load cannot reach 0, where cycles have
        other periods. Of a `DimensionalRotor` also by the names ``speed``, ``damping`` and
        ``clearance``. Of a `RotorSystem` the speed alone.
    limits : tuple of float
        Its smallest and largest value, [1] or in its SI unit; speeds of the same sign.
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
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        On ``point`` the continued parameter, ``period``, ``radius_min``, ``radius_max``,
        ``stability``, ``response``, ``contact_count``, ``largest_force``, ``impulse_per_period``,
        ``trace``, the multipliers, ``residual``, and a state ``x y vx vy`` on the rotating axes
        [1]. On ``special``, in order along the branch, ``special_kind`` (fold, period doubling,
        graze, torus, sliding, hopf, discontinuous), ``special_value`` of the parameter,
        ``special_period`` and the state there; ``special_point`` is the point before it. The
        attribute ``closed`` is 1 if the branch returns to its beginning. ``first_end`` and
        ``last_end`` are the kinds of its ends, ``first_reason`` and ``last_reason`` explain why no
        step was possible, or what hides the multipliers. Of a `RotorSystem` the numbers on
        ``point`` are those of `limit_cycle`, and on ``special`` there are ``special_speed``,
        ``special_radius_max`` and ``special_state``.

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
    the stator. At ``sliding`` the number of times changes that the disc begins to roll or slides
    the other way: the slip speed just reaches 0, multipliers jump, and the branch has a corner,
    around which it is followed. At ``discontinuous`` multipliers jump over the unit circle, at such
    a corner or at a graze of a linear or damped contact.

    With contact damping, friction or a load, and of a `RotorSystem`, the multipliers do not form
    such pairs. Then the test functions are the products of ``1 - mu`` and of ``1 + mu`` over the
    nontrivial multipliers, each factor over its size where that is not small. A
    complex pair may cross the unit circle, where the product of ``1 - mu_i mu_j`` is 0: a torus is
    born, on which the motion never repeats. Under a load the period is that of k revolutions,
    ``k 2 pi/omega``, along the whole branch. Special points are located to rounding.

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
    """
    how: dict[str, Any] = {
        "limits": limits, "direction": direction, "points": points, "study": study,
        "progress": progress,
    }  # fmt: skip
    if isinstance(rotor, RotorSystem):
        check_choice("parameter", parameter, ("omega", "speed"))
        system = changed_system(continue_cycle, rotor, changed)
        return _branch_of_system(system, start=start, speed=speed, modes=modes, **how)
    assert isinstance(rotor, Rotor)
    return _branch_of_disc(rotor, start=start, parameter=parameter, **how)


def _branch_of_system(
    system: RotorSystem, *, start: Any, speed: float | None, modes: int | None,
    limits: tuple[float, float], direction: Direction, points: int,
    study: str | os.PathLike[str] | None, progress: Progress | bool | None,
) -> xr.Dataset:  # fmt: skip
    """Follow limit cycles of a rotor system: see `continue_cycle`."""
    count, told = _checked_way(direction, points, progress)
    guess = guess_of_system(system, start, speed, modes=modes)
    bounds = _speeds("limits", limits, guess.flow.speed)
    given: dict[str, object] = {"rotor": system, "modes": modes}
    return branch_from(with_period(guess), "speed", bounds, direction, count, study, told, given)


def _branch_of_disc(
    rotor: Rotor, *, start: Any, parameter: Parameter = "omega", limits: tuple[float, float],
    direction: Direction, points: int, study: str | os.PathLike[str] | None,
    progress: Progress | bool | None,
) -> xr.Dataset:  # fmt: skip
    """Follow limit cycles of one disc: see `continue_cycle`."""
    check_choice("parameter", parameter, CONTINUED)
    count, progress = _checked_way(direction, points, progress)
    guess = checked_guess(rotor, start)
    bounds = check_limits(parameter, limits, guess.rotor)
    return branch_from(with_period(guess), parameter, bounds, direction, count, study, progress)


def _checked_way(
    direction: str, points: int, progress: Progress | bool | None
) -> tuple[int, Progress | None]:
    """Return the number of points and the progress if they and the direction are valid."""
    check_choice("direction", direction, tuple(WAYS))
    count = check_count("points", points, minimum=2, maximum=MOST_NUMBERS)
    return count, check_progress(progress)


def _speeds(name: str, limits: object, speed: float) -> tuple[float, float]:
    """Return limits of the speed of a rotor system if they are valid and contain its own."""
    values = check_vector(name, limits)
    if values.size != 2 or not values[0] < values[1] or not values[0] * values[1] > 0.0:
        raise InputError(
            f"{name} must be two increasing speeds of the same sign, got {shown(limits)}"
        )
    low, high = values.tolist()
    if not low <= speed <= high:
        raise InputError(
            "{name} must contain the speed of the start, {speed}, got {value}",
            name=name, speed=speed, value=(low, high),
        )  # fmt: skip
    return low, high


def check_limits(parameter: str, limits: object, rotor: Rotor) -> tuple[float, float]:
    """Return the limits of a parameter if they are valid and contain that of the rotor."""
    values = check_vector("limits", limits)
    if values.size != 2 or not 0.0 <= values[0] < values[1]:
        raise InputError(
            "{name} must be two increasing numbers from 0 on, got {value}",
            name=f"limits of {parameter}", value=tuple(values.tolist()),
        )  # fmt: skip
    low, high = values.tolist()
    if low == 0.0 and parameter in NEVER_ZERO:
        raise InputError(
            "{name} must be above 0, got {value}", name=f"limits of {parameter}", value=(low, high)
        )
    if parameter in {"friction", "disc_radius"} and rotor.disc_radius is None:
        raise InputError(f"disc_radius must be given for {parameter} to be continued, got None")
    here = getattr(rotor, parameter)
    if parameter == "disc_radius" and rotor.friction == 0.0:
        raise InputError(
            "friction must be above 0 for disc_radius to be continued, got 0.0: without it the "
            "disc has no effect"
        )
    if parameter == "load" and here == 0.0:
        raise InputError(
            "{name} must be above 0 to be continued, got {value}: without a load cycles have other "
            "periods",
            name="load", value=here,
        )  # fmt: skip
    if parameter == "delta0" and here == 0.0:
        raise InputError(
            "{name} must be above 0 to be continued, got {value}", name=parameter, value=here
        )
    if not low <= here <= high:
        raise InputError(
            "{name} must contain that of the start, {here}, got {value}",
            name=f"limits of {parameter}", here=here, value=(low, high),
        )  # fmt: skip
    return low, high


def branch_from(
    guess: Guess,
    parameter: str,
    limits: tuple[float, float],
    direction: str,
    points: int,
    study: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    given: dict[str, object] | None = None,
) -> xr.Dataset:
    """Return the branch through a guess of a cycle with its period, as `continue_cycle` does.

    `given` is the rotor system, and its number of modes, where it is one.
    """
    branch = branch_through(guess, parameter, limits, points)
    told: dict[str, Any] = {"limits": limits, "direction": direction, "points": points}
    attributes = start_attributes(guess)
    attributes |= {"start_special": guess.special, "start_slope": guess.slope}
    is_system = given is not None
    if given is None:
        told["parameter"] = parameter
        start, attributes["flight"] = as_start(guess, (parameter,)), "exact"
        given = {"rotor": guess.rotor}
    else:
        start, attributes["rtol"] = as_start_of_system(attributes), CLOSING_RTOL
    question = Question("continue_cycle", {**given, "start": start, **told})
    ways = WAYS[direction] if branch.both else WAYS["forward"]
    with open_results(study, question.design(), len(ways) * (points - 1), FORM) as kept:
        sides = follow_sides(branch, ways, kept, progress)
    title = "Branch of limit cycles"
    if is_system:
        title = f"{title} of a rotor system"
        dataset = branch_dataset(sides, (parameter,), title, kind="system_branch")
    else:
        dataset = branch_dataset(sides, (parameter,), title, kind="branch")
    more = {**told, "limits": np.array(limits), **attributes, **question.attribute()}
    return dataset.assign_attrs(provenance({"method": "taylor"}) | more)


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
