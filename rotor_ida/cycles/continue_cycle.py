"""Continue a limit cycle over speed, damping or clearance: the branch as a labelled dataset."""

from __future__ import annotations

import os
from typing import Literal, get_args

import numpy as np
import xarray as xr

from rotor_ida.arrays import Arrays, Values
from rotor_ida.checks import (
    AT_REST,
    MOST_NUMBERS,
    check_choice,
    check_count,
    check_instance,
    check_progress,
    check_vector,
)
from rotor_ida.cycles.branch import (
    CLOSED,
    Side,
    SpecialBehind,
    advance,
)
from rotor_ida.cycles.continuation import Point
from rotor_ida.cycles.dataset import branch_dataset, start_attributes
from rotor_ida.cycles.guess import Guess, as_start
from rotor_ida.cycles.limit_cycle import checked_guess, with_period
from rotor_ida.cycles.problems import NEVER_ZERO, Continuation, branch_through
from rotor_ida.cycles.special_points import O, Special
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import OF_ROTOR
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.in_si import takes_si
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


@takes_si
@shows_progress
def continue_cycle(
    rotor: Rotor,
    *,
    start: Start = AT_REST,
    parameter: Parameter = "omega",
    limits: tuple[float, float],
    direction: Direction = "both",
    points: int = 2000,
    study: str | os.PathLike[str] | None = None,
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Follow a limit cycle over a parameter, around folds and through grazes.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor
        The rotor. For a `DimensionalRotor` numbers with a unit are in SI units, as for
        `rotor_ida.simulate`; a dataset has its own.
    start : array_like, shape (4,), "settled", "rest" or Dataset
        A start ``(x, y, vx, vy)`` that leads to the cycle [1], by default at rest on the axis, or a
        word as for `rotor_ida.simulate`; or the result of `limit_cycle`; or one point of a branch,
        ``branch.isel(point=...)``; or one of its special points, ``branch.isel(special=...)``. From
        a period doubling the branch of doubled cycles is followed.
    parameter : {"omega", "zeta", "delta0", "shaft_stiffness", "contact_damping", "load", \
            "friction", "disc_radius"}
        The parameter to vary; the others are constant. A load cannot reach 0, where cycles have
        other periods. Of a `DimensionalRotor` also by the names ``speed``, ``damping`` and
        ``clearance``.
    limits : tuple of float
        Its smallest and largest value, [1] or in its SI unit.
    direction : {"both", "forward", "backward"}
        Direction from the start. Forward is towards larger values of the parameter, or from a point
        of a branch onwards along that branch. From a period doubling there is only one direction.
    points : int
        The largest number of points each way.
    study : path-like, optional
        Folder in which points are stored as they are found. Points that it contains already are not
        computed again; the result is identical bit for bit. It must be new, empty, or of a study of
        the same branch.
    progress : callable or bool, optional
        Called with the number of points found and the largest possible number; True shows a bar on
        standard error.

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
        step was possible, or what hides the multipliers.

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

    With contact damping, friction or a load the multipliers do not form such pairs. Then the test
    functions are the products of ``1 - mu`` and of ``1 + mu`` over the nontrivial multipliers. A
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
    check_instance("rotor", rotor, Rotor)
    check_choice("parameter", parameter, CONTINUED)
    check_choice("direction", direction, tuple(WAYS))
    count = check_count("points", points, minimum=2, maximum=MOST_NUMBERS)
    progress = check_progress(progress)
    guess = checked_guess(rotor, start)
    bounds = check_limits(parameter, limits, guess.rotor)
    return branch_from(with_period(guess), parameter, bounds, direction, count, study, progress)


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
) -> xr.Dataset:
    """Return the branch through a guess of a cycle with its period, as `continue_cycle` does."""
    branch = branch_through(guess, parameter, limits, points, np.zeros(1, np.uint8))
    told = {"parameter": parameter, "limits": limits, "direction": direction, "points": points}
    start = as_start(guess, (parameter,))
    question = Question("continue_cycle", {"rotor": guess.rotor, "start": start, **told})
    ways = WAYS[direction] if branch.both else WAYS["forward"]
    with open_results(study, question.design(), len(ways) * (points - 1), FORM) as kept:
        sides = follow_sides(branch, ways, kept, progress)
    first = branch.first.stretch
    attributes = provenance({"method": "taylor", "flight": "exact"}) | {
        **told,
        "limits": np.array(limits),
        "start_special": guess.special,
        "start_slope": guess.slope,
        **start_attributes(guess),
    }
    dataset = branch_dataset(
        sides, (parameter,), first.rotor, "Branch of limit cycles", kind="branch"
    )
    return dataset.assign_attrs(attributes)


def follow_sides(
    branch: Continuation[O], ways: tuple[int, ...], kept: Results[Arrays], progress: Progress | None
) -> tuple[Side[O], Side[O]]:
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


def _counted(branch: Continuation[O], side: Side[O], added: int, left: int) -> int:
    """Return the number of points that a piece counts as: the last one includes unused points."""
    if side.end == CLOSED:
        return left
    return added + branch.most - len(side.points) if side.end else added


def _piece(side: Side[O], begun: int, known: int) -> Arrays:
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


def _restore(branch: Continuation[O], side: Side[O], piece: Arrays) -> None:
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


def _point(
    branch: Continuation[O], unknowns: Values, tangent: Values, before: Point[O]
) -> Point[O]:
    shot = branch.line.problem.shoot(unknowns)
    direction = branch.line.direction_at(shot, before.direction)
    return Point(unknowns, shot, tangent, direction)
