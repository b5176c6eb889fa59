"""A curve of limit cycles, followed both ways until it closes or ends.

Special points on the way are detected by test functions of the multipliers (fold, period doubling,
torus) and by the number of contacts (graze). A branch of doubled cycles may return to the branch
that it left, where its cycles become two equal halves.

A branch may be born from a synchronous whirl, at a Hopf point. Followed through that point it
retraces itself, half a period later: the field at the start, which vanishes with the oscillation of
the radius, reverses. The whirl that begins to oscillate there is known in closed form, and so is
the point.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.cycles.continuation import EARLIER, FIRST_STEP, Curve, Point, Step
from rotor_ida.cycles.guess import DOUBLING, HOPF
from rotor_ida.cycles.multipliers import doubling_test, on_unit_circle
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.cycles.problems import FOLD, TORUS, Continuation, halved
from rotor_ida.cycles.shooting import LEFT_THE_RING
from rotor_ida.cycles.special_points import DISCONTINUOUS, Special
from rotor_ida.errors import SimulationError

# Why a branch ends.
LIMITS, CLOSED, CONTACT_FREE, HALVED, BORN, STUCK, UNSTABLE, ENOUGH = (
    "limits", "closed", "contact_free", "halved", "hopf", "step_too_small", "too_unstable",
    "points",
)  # fmt: skip
# A cycle repeats one of half its period if the extreme radii of both halves agree to this fraction;
# near a doubling they differ by the root of the distance from it.
EQUAL_HALVES = 1e-6
# Two curves cross there, and nearby rounding may prevent any step: a doubling this near the last
# point, relative to the scales, is the end.
NEAR_A_DOUBLING = 1e-3
# A step to such a cycle is repeated, shorter by this factor each time,
SHORTENED = 0.25
# until it is so short, a fortieth of the longest, that no special point is overlooked on the way.
LAST_STEP = 1e-3
# No branch returns within this number of points: the first steps are short.
FEWEST_POINTS_ROUND = 8
# The step back to the first point passes it within this fraction of its length,
PASSES_WITHIN = 0.25
# and the cycle there is the same to this fraction, far above rounding.
SAME_CYCLE = 1e-6
# Rounding at the start grows with M, and changes M itself by 1e-16 times its square: where M is
# larger than this, multipliers that depend on more than its trace are meaningless.
LARGEST_M = 1e7
# Relative rounding of a constant period.
ROUNDING_OF_PERIOD = 1e-14


class SpecialBehind(NamedTuple):
    """A special point, and the number of the point of its side that precedes it."""

    place: int
    special: Special


@dataclass(slots=True)
class Side:
    """The part of a curve followed one way from the first point.

    Parameters
    ----------
    points : list of Point
        The first point, and those after it.
    specials : list of SpecialBehind
        The special points.
    length : float
        Length of the next step.
    end : str
        Why it ended; empty while it continues.
    reason : str
        Why no further step was possible; else empty.
    """

    points: list[Point]
    specials: list[SpecialBehind] = field(default_factory=list)
    length: float = FIRST_STEP
    end: str = ""
    reason: str = ""


def advance(branch: Continuation, side: Side) -> None:
    """Take one step along a branch."""
    last = side.points[-1]
    try:
        step, cycle = _step_from(branch, side)
    except SimulationError as error:
        _end_where_stuck(branch, side, error.reason)
        return
    point = step.point
    # two real multipliers of product 1 are no torus
    specials = [
        each for each in step.specials if each.name != TORUS or on_unit_circle(each.point.orbit)
    ]
    if (passed := _passed(branch, point)) is not None:
        side.end = LIMITS
        if last.unknowns[passed[0]] == passed[1]:
            return
        try:
            point = branch.line.crossing(last, point, *passed)
        except SimulationError as error:  # the last point is the one before
            side.end, side.reason = STUCK, error.reason
            return
        specials = [each for each in specials if _passed(branch, each.point) is None]
    elif len(side.points) > FEWEST_POINTS_ROUND and _comes_back(branch, last, point):
        point, side.end = branch.first, CLOSED
        # behind its first point the branch continues as it began
        specials = [
            each for each in specials if not any(_same(each, known) for _, known in side.specials)
        ]
    if cycle is not None:
        specials, point, side.end = [*specials, Special(DOUBLING, cycle)], cycle, HALVED
    elif (
        branch.birth is not None
        and turns_round(last, step.point)
        and (born := branch.birth(last, step.point)) is not None
    ):
        # the rest of the step repeats what came before, half a period later
        specials = [each for each in specials if not turns_round(last, each.point)]
        specials, point, side.end = [*specials, Special(HOPF, born)], born, BORN
    side.specials += [SpecialBehind(len(side.points) - 1, each) for each in specials]
    side.points.append(point)
    side.length = step.length
    if side.end:
        return
    # rounding hides multipliers that depend on more than the trace of M
    if point.orbit.pair_product is None and np.abs(point.orbit.monodromy).max() > LARGEST_M:
        side.end, side.reason = UNSTABLE, _how_unstable(point.orbit)
    elif len(side.points) >= branch.most:
        side.end = ENOUGH


def _step_from(branch: Continuation, side: Side) -> tuple[Step, Point | None]:
    """Return the next step of a side, and the cycle on it that doubles its period, if any.

    A step to such a cycle is short.
    """
    last, length = side.points[-1], side.length
    earlier = side.points[-2 : -2 - EARLIER : -1]
    while True:
        step = branch.line.step(last, length, earlier)
        cycle = _halved(branch, last, step) if len(branch.limits) == 1 else None
        if cycle is None or step.taken <= LAST_STEP:
            return step, cycle
        length = SHORTENED * step.taken


def _end_where_stuck(branch: Continuation, side: Side, reason: str) -> None:
    """End a side that allows no further step; at the doubling close by, if there is one."""
    last = side.points[-1]
    if len(branch.limits) == 1 and last.orbit.halves_agree(NEAR_A_DOUBLING):
        cycle = _cycle_of_half(branch, last)
        if cycle is not None and _is_close_by(branch, last, cycle):
            side.specials.append(SpecialBehind(len(side.points) - 1, Special(DOUBLING, cycle)))
            side.points.append(cycle)
            side.end = HALVED
            return
    side.end = CONTACT_FREE if LEFT_THE_RING in reason else STUCK
    side.reason = reason + branch.hint(last.orbit)


def _is_close_by(branch: Continuation, last: Point, cycle: Point) -> bool:
    """Return whether a cycle of half the period is as near to a point as its halves agree."""
    apart = (cycle.unknowns - halved(last.unknowns, branch.place)) / branch.line.scale
    return bool((np.abs(apart[branch.place - 1 :]) <= NEAR_A_DOUBLING).all())


def _how_unstable(orbit: Orbit) -> str:
    return (
        f"neighbouring orbits separate by a factor of {np.abs(orbit.monodromy).max():.2g} in a "
        f"period of {orbit.duration:.6g}, so rounding hides the multipliers, "
        "as where a period grows without bound"
    )


def _halved(branch: Continuation, last: Point, step: Step) -> Point | None:
    """Return the cycle that doubles its period on a step along a branch, if there is one.

    There the branch of doubled cycles ends, as a cycle followed twice. A step either reaches such a
    cycle, or passes to the same branch half a period later: the parameter turns back without a
    fold.
    """
    point, folds = step.point, {FOLD, DISCONTINUOUS}
    twice = point.orbit.halves_agree(EQUAL_HALVES)
    turns = last.tangent[branch.place] * point.tangent[branch.place] < 0.0
    if not twice and (not turns or any(each.name in folds for each in step.specials)):
        return None
    near = (
        point
        if twice or abs(point.tangent[branch.place]) < abs(last.tangent[branch.place])
        else last
    )
    return _cycle_of_half(branch, near)


def _cycle_of_half(branch: Continuation, near: Point) -> Point | None:
    """Return the cycle of half the period, near a point, that doubles its period, if there is one.

    If it is not autonomous it takes a whole number of revolutions.
    """
    if branch.half is None and not near.orbit.is_autonomous:
        return None
    half = Curve(branch.half or branch.line.problem, halved(branch.line.scale, branch.place))
    try:
        return half.root(half.first(halved(near.unknowns, branch.place)), doubling_test)
    except SimulationError:
        return None


def _passed(branch: Continuation, point: Point) -> tuple[int, float] | None:
    """Return the index and the value of a limit that a point has passed, or None."""
    for place, (low, high) in branch.limits.items():
        here = float(point.unknowns[place])
        if not low <= here <= high:
            return place, low if here < low else high
    return None


def _comes_back(branch: Continuation, last: Point, point: Point) -> bool:
    """Return whether a step passes the first point of its branch in the same direction.

    A branch may return at any phase: the cycles are compared by quantities independent of it.
    """
    between = (branch.first.unknowns - last.unknowns) * (branch.first.unknowns - point.unknowns)
    # under a load the period may be constant, except for rounding
    apart = (point.unknowns - last.unknowns) ** 2 + (ROUNDING_OF_PERIOD * branch.line.scale) ** 2
    if (between[branch.place - 1 :] > apart[branch.place - 1 :]).any():
        return False
    goal, here, there = (_signature(each) for each in (branch.first, last, point))
    along = there - here
    part = float((goal - here) @ along) / float(along @ along)
    miss = np.linalg.norm(goal - here - part * along)
    if not (0.0 <= part <= 1.0 and miss <= PASSES_WITHIN * np.linalg.norm(along)):
        return False
    # the parameter that changes most there gives the place
    place = branch.place + int(np.argmax(np.abs(branch.first.tangent[branch.place :])))
    try:
        again = branch.line.crossing(last, point, place, float(branch.first.unknowns[place]))
    except SimulationError:
        return False
    same = np.linalg.norm(_signature(again) - goal) <= SAME_CYCLE * np.linalg.norm(goal)
    return bool(same and again.tangent[place] * branch.first.tangent[place] > 0.0)


def _same(special: Special, known: Special) -> bool:
    """Return whether two special points are the same, at any phase."""
    one, other = _signature(special.point), _signature(known.point)
    near = np.linalg.norm(one - other) <= SAME_CYCLE * np.linalg.norm(other)
    return special.name == known.name and bool(near)


def _signature(point: Point) -> Values:
    """Return numbers of a cycle that do not depend on its phase."""
    return np.concatenate([point.unknowns[point.orbit.start.size :], point.orbit.sizes])


def turns_round(last: Point, point: Point) -> bool:
    """Return whether a step has passed a whirl, where the oscillation of the radius vanishes."""
    return float(last.orbit.start_rate @ point.orbit.start_rate) < 0.0
