"""Follow a branch or a curve of limit cycles of any rotor both ways, and keep its points."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Arrays, Values
from rotor_ida.checks import check_instance, check_vector
from rotor_ida.cycles.branch import CLOSED, Side, SpecialBehind, advance
from rotor_ida.cycles.continuation import Point
from rotor_ida.cycles.dataset import branch_dataset, start_attributes
from rotor_ida.cycles.guess import Guess, as_start, guess_of_system
from rotor_ida.cycles.limit_cycle import checked_guess
from rotor_ida.cycles.problems import NEVER_ZERO, Continuation
from rotor_ida.cycles.special_points import Special
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.parallel import Progress
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder, Form, Results, open_results
from rotor_ida.schema import SPECIAL, by_number
from rotor_ida.simulation.flow import DiscFlow, Flow

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
    with open_results(study, question.design(), len(ways) * (curve.most - 1), FORM) as kept:
        sides = follow_sides(curve, ways, kept, progress)
    attributes = {name: " ".join(np.atleast_1d(each)) for name, each in names.items()}
    return branch_dataset(sides, parameters).assign_attrs(
        provenance({"method": "taylor"}),
        **told | attributes | {"limits": np.ravel(told["limits"])},
        **start_attributes(guess),
        **question.attribute(),
    )


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
