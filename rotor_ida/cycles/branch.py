"""A branch of limit cycles, followed both ways until it closes or ends.

What can happen on the way is told by test functions of the multipliers (fold, period doubling,
torus), and by the number of contacts (graze). A branch of doubled cycles may come back to the
one that it left, where its cycles become two equal halves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.core.runs import COLUMNS
from rotor_ida.cycles.birth import birth_between, turns_round
from rotor_ida.cycles.continuation import (
    EARLIER,
    FIRST_STEP,
    Curve,
    Point,
    Problem,
    Step,
    shooting_equations,
)
from rotor_ida.cycles.guess import Guess
from rotor_ida.cycles.multipliers import (
    doubling_test,
    fold_test,
    has_trace,
    on_unit_circle,
    torus_test,
)
from rotor_ida.cycles.shooting import (
    LEFT_THE_RING,
    Cycle,
    checked_cycle,
    contacts_of,
    period_of,
    revolutions_of,
)
from rotor_ida.cycles.special_points import Count, Special
from rotor_ida.errors import SimulationError
from rotor_ida.model.parameters import Rotor
from rotor_ida.model.table import PARAMETERS
from rotor_ida.parallel.jobs import Stop
from rotor_ida.simulation.neighbours import Shot, shoot
from rotor_ida.simulation.orbit import REVERSE, ROLL

# Why a branch ends.
LIMITS, CLOSED, CONTACT_FREE, HALVED, BORN, STUCK, UNSTABLE, ENOUGH = (
    "limits", "closed", "contact_free", "halved", "hopf", "step_too_small", "too_unstable",
    "points",
)  # fmt: skip
FOLD, DOUBLING, GRAZE, TORUS, SLIDING, HOPF = (
    "fold", "period_doubling", "graze", "torus", "sliding", "hopf",
)  # fmt: skip
# Where the (first) parameter stands among the unknowns, behind the state and the period.
PLACE = 5
# A rotor that does not turn, or is not damped, has no cycles; one without a load has others.
NEVER_ZERO = ("omega", "zeta", "load")
# What unknowns are multiplied by for half a period.
HALF = np.array([1.0, 1.0, 1.0, 1.0, 0.5, 1.0])
# A cycle is twice one of half its period when the extreme radii of both halves agree to this part;
# beside a doubling they differ by the root of the distance from it.
EQUAL_HALVES = 1e-6
# Two curves cross there, and beside that rounding may let no step be taken: a doubling this near
# the last point, in parts of the scales, is the end.
NEAR_A_DOUBLING = 1e-3
# A step to such a cycle is taken again, this much shorter each time,
SHORTENED = 0.25
# until it is so short, a fortieth of the longest, that no special point is overlooked on the way.
LAST_STEP = 1e-3
# No branch comes back within so many points: the first steps are short.
FEWEST_POINTS_ROUND = 8
# Its step back to the first point passes that within this part of its own length,
PASSES_WITHIN = 0.25
# and the cycle there is the same to this part, far above rounding.
SAME_CYCLE = 1e-6
# Rounding at the start is carried along by M, and changes M itself by 1e-16 times its square: where
# M is larger than this, multipliers that hang on more than its trace tell nothing.
LARGEST_M = 1e7
# Where a curve of bifurcations ends this near a graze, in parts of the clearance, that is why.
NEAR_A_GRAZE = 1e-4
# What rounding may do to a period that stands still, in parts of it.
ROUNDING_OF_PERIOD = 1e-14
# Where the period doubles, doubled cycles are sought aside at these parts of the size of the state,
# in turn: close to where they leave, and if Newton's method falls back there, farther and nearer.
ASIDE = (1e-3, 3e-3, 1e-2, 3e-4, 1e-4, 3e-5)
# What was found there is doubled if after half its period it misses its start by this part of that.
STILL_ASIDE = 0.1


@dataclass(frozen=True, slots=True)
class Course:
    """A branch that is to be followed.

    Parameters
    ----------
    line : Curve
        What takes the steps.
    name : str
        The (first) parameter.
    first : Point
        Its first point, led forward.
    limits : dict of int to tuple of float
        The least and the largest value [1] of each parameter, by its place among the unknowns.
    most : int
        The largest number of points.
    both : bool
        Whether it goes on from there both ways; from where a period doubles there is but one.
    half : Problem, optional
        The cycles of half the period, to which those of the branch may come.
    """

    line: Curve[Shot]
    name: str
    first: Point[Shot]
    limits: dict[int, tuple[float, float]]
    most: int
    both: bool = True
    half: Problem[Shot] | None = None


@dataclass(slots=True)
class Side:
    """What has been followed one way from the first point.

    Parameters
    ----------
    points : list of Point
        The first point, and those after it.
    specials : list of tuple
        The special points, each with the number of the point before it.
    length : float
        Length of the next step.
    end : str
        Why it ended; empty while it goes on.
    reason : str
        What stood in the way where no step led on; else empty.
    """

    points: list[Point[Shot]]
    specials: list[tuple[int, Special[Shot]]] = field(default_factory=list)
    length: float = FIRST_STEP
    end: str = ""
    reason: str = ""


def course_from(
    guess: Guess, parameter: str, limits: tuple[float, float], most: int, stop: Stop
) -> Course:
    """Return the branch through a cycle, or the doubled one that leaves it at a doubling.

    The guess has a period. SimulationError if there is no branch.
    """
    rotor, period = guess.rotor, guess.period or math.nan
    value = getattr(rotor, parameter)
    doubles = guess.special == DOUBLING
    scale = np.empty(6)
    scale[:4], scale[4] = np.linalg.norm(guess.state), period * (2.0 if doubles else 1.0)
    scale[5] = value or limits[1] - limits[0]
    times = revolutions_of(rotor, scale[4])
    line = Curve(cycles_over(rotor, parameter, stop, times), scale)
    half = None if times % 2 else cycles_over(rotor, parameter, stop, times // 2)
    if doubles:
        first = _doubled(line, guess, value)
        return Course(line, parameter, first, {PLACE: limits}, most, both=False, half=half)
    first = line.first(np.append(guess.state, (period, value)))
    first = first.reversed() if guess.slope < 0.0 else first
    return Course(line, parameter, first, {PLACE: limits}, most, half=half)


def nearest_gap(shot: Shot) -> float:
    """Return the extremum of the radius that is nearest to the ring, from there: 0 at a graze."""
    gaps: list[float] = (shot.extrema["radius"] - shot.rotor.delta0).tolist()
    return min(gaps, key=abs)


def changes_of(shot: Shot) -> int:
    """Return how often on an orbit the disc begins to roll, or slides the other way."""
    return int(np.isin(shot.event_kinds, (ROLL, REVERSE)).sum())


# What is counted on an orbit; of the second no function of the orbit is 0 where it changes.
COUNTS = {
    GRAZE: Count(contacts_of, nearest_gap),
    SLIDING: Count(changes_of, lambda _shot: math.inf),
}


def cycles_over(rotor: Rotor, parameter: str, stop: Stop, revolutions: int) -> Problem[Shot]:
    """Return the cycles of a rotor over one of its parameters.

    Under a load they are those of so many revolutions.
    """
    tests: dict[str, Callable[[Point[Shot], Point[Shot]], float]] = {
        FOLD: lambda point, _last: fold_test(point.stretch),
        DOUBLING: lambda point, _last: doubling_test(point.stretch),
    }
    if may_have_tori(rotor, parameter):
        tests[TORUS] = lambda point, _last: torus_test(point.stretch)
    return Problem(
        lambda unknowns: shot_of(rotor, unknowns, (parameter,), stop),
        lambda _unknowns, shot, direction: closing_equations(
            shot, direction, (parameter,), revolutions
        ),
        checked_cycle,
        tests,
        COUNTS,
        autonomous=rotor.load == 0.0,
    )


def may_have_tori(rotor: Rotor, *varied: str) -> bool:
    """Return whether a torus may be born from cycles of a rotor, some parameters of it varied."""
    where = ("contact_damping", "friction", "load")
    return any(name in varied or getattr(rotor, name) > 0.0 for name in where)


def closing_equations(
    shot: Shot, direction: Values, parameters: Sequence[str], revolutions: int
) -> tuple[Values, Values]:
    """Return what the equations of a cycle miss, and their derivatives by all unknowns.

    They are those of `shooting_equations`; under a load the last is ``T = k 2 pi/omega`` instead.
    """
    columns = [COLUMNS.index(name) for name in parameters]
    miss, matrix = shooting_equations(shot, direction, *shot.by_parameter[:, columns].T)
    if shot.rotor.load > 0.0:
        period = period_of(shot.rotor, revolutions)
        miss[4], matrix[4] = period - shot.duration, 0.0
        matrix[4, 4] = 1.0
        for place, name in enumerate(parameters, start=PLACE):
            if name == "omega":
                matrix[4, place] = period / shot.rotor.omega
    return miss, matrix


def shot_of(rotor: Rotor, unknowns: Values, parameters: Sequence[str], stop: Stop) -> Shot:
    """Return the orbit that state, period and some parameters mean.

    Below 0, where no machine is, the orbit is led on along its derivative at 0: so a step may pass
    a limit there. SimulationError if a parameter cannot be, or the orbit cannot be followed.
    """
    values, below = dict[str, float](), dict[str, float]()
    for name, value in zip(parameters, unknowns[5:].tolist(), strict=True):
        if value < 0.0 and name not in PARAMETERS:
            below[name] = value
        elif value < 0.0 or (value == 0.0 and name in NEVER_ZERO):
            raise SimulationError(f"{name} falls to {value:.3g}")
        values[name] = max(value, 0.0)
    here, whole = replace(rotor, **values), any(name not in PARAMETERS for name in parameters)
    shot = shoot(here, unknowns[:4], float(unknowns[4]), stop, whole=whole)
    for name, value in below.items():
        shot = replace(shot, end=shot.end + value * shot.by_parameter[:, COLUMNS.index(name)])
    return shot


def _doubled(line: Curve[Shot], guess: Guess, value: float) -> Point[Shot]:
    """Return a point of the doubled branch near a period doubling, led away from it.

    Its cycles leave along the eigenvector of the multiplier -1, twice round.
    """
    period = guess.period or math.nan
    once = line.problem.shoot(np.append(guess.state, (period, value)))
    multipliers, vectors = np.linalg.eig(once.monodromy)
    aside = np.real(vectors[:, np.argmin(np.abs(multipliers + 1.0))])
    if line.problem.autonomous:
        aside -= (aside @ once.start_rate) / (once.start_rate @ once.start_rate) * once.start_rate
    away = np.zeros(6)
    away[:4] = aside / np.linalg.norm(aside)
    for part in ASIDE:
        unknowns = np.append(guess.state, (2.0 * period, value)) + part * away * line.scale
        try:
            point = line.near(unknowns, away)
        except SimulationError:
            continue
        if _half_misses(line, point) > STILL_ASIDE * part:
            return point
    x, y, vx, vy = guess.state.tolist()
    message = f"no doubled cycle was found beside the one of period {period:.9g}"
    raise SimulationError(message, time=0.0, state=(x, y, vx, vy))


def _half_misses(line: Curve[Shot], point: Point[Shot]) -> float:
    """Return by how much half a period misses its start, relative to the size of the state."""
    start = point.stretch.start
    half = line.problem.shoot(point.unknowns * HALF)
    return float(np.linalg.norm(half.end - start) / np.linalg.norm(start))


def advance(course: Course, side: Side) -> None:
    """Take one step along a branch."""
    line, last, length, halved = course.line, side.points[-1], side.length, None
    earlier = side.points[-2 : -2 - EARLIER : -1]
    while True:
        try:
            step = line.step(last, length, earlier)
        except SimulationError as error:
            _end_where_stuck(course, side, error.reason)
            return
        if len(course.limits) == 1:
            halved = _halved(course, last, step)
        if halved is None or step.taken <= LAST_STEP:
            break
        length = SHORTENED * step.taken
    point = step.point
    # two real multipliers of product 1 make no torus
    met = [each for each in step.met if each.name != TORUS or on_unit_circle(each.point.stretch)]
    if (passed := _passed(course, point)) is not None:
        side.end = LIMITS
        if last.unknowns[passed[0]] == passed[1]:
            return
        try:
            point = line.crossing(last, point, *passed)
        except SimulationError as error:  # the last point is the one before
            side.end, side.reason = STUCK, error.reason
            return
        met = [each for each in met if _passed(course, each.point) is None]
    elif len(side.points) > FEWEST_POINTS_ROUND and _comes_back(course, last, point):
        point, side.end = course.first, CLOSED
        # behind its first point the branch goes on as it began
        met = [each for each in met if not any(_same(each, known) for _, known in side.specials)]
    if halved is not None:
        met, point, side.end = [*met, Special(DOUBLING, halved)], halved, HALVED
    elif (born := _birth(course, last, step.point)) is not None:
        # what follows on the step is what came before, half a period later
        met = [each for each in met if not turns_round(last, each.point)]
        met, point, side.end = [*met, Special(HOPF, born)], born, BORN
    side.specials += [(len(side.points) - 1, each) for each in met]
    side.points.append(point)
    side.length = step.length
    if not side.end and _is_too_unstable(point.stretch):
        side.end, side.reason = UNSTABLE, _how_unstable(point.stretch)
    if len(side.points) >= course.most and not side.end:
        side.end = ENOUGH


def _end_where_stuck(course: Course, side: Side, reason: str) -> None:
    """End a side from which no step leads on; at the doubling close by, if there is one."""
    last = side.points[-1]
    if len(course.limits) == 1 and _halves_agree(last.stretch, NEAR_A_DOUBLING):
        halved = _cycle_of_half(course, last)
        if halved is not None and _is_close_by(course, last, halved):
            side.specials.append((len(side.points) - 1, Special(DOUBLING, halved)))
            side.points.append(halved)
            side.end = HALVED
            return
    side.end = CONTACT_FREE if LEFT_THE_RING in reason else STUCK
    side.reason = reason
    gap = nearest_gap(last.stretch)
    linear, delta0 = last.stretch.rotor.contact_exponent == 1.0, last.stretch.rotor.delta0
    if len(course.limits) > 1 and linear and abs(gap) <= NEAR_A_GRAZE * delta0:
        side.reason += (
            f"; the radius comes within {abs(gap):.2g} of the ring, and at a graze of a linear "
            "contact the curve has a corner"
        )


def _is_close_by(course: Course, last: Point[Shot], halved: Point[Shot]) -> bool:
    """Return whether a cycle of half the period is as near to a point as its halves agree."""
    apart = (halved.unknowns - last.unknowns * HALF) / course.line.scale
    return bool((np.abs(apart[PLACE - 1 :]) <= NEAR_A_DOUBLING).all())


def _is_too_unstable(shot: Shot) -> bool:
    """Return whether rounding hides multipliers that hang on more than the trace of M."""
    return not has_trace(shot) and bool(np.abs(shot.monodromy).max() > LARGEST_M)


def _birth(course: Course, last: Point[Shot], point: Point[Shot]) -> Point[Shot] | None:
    """Return the cycle at which a branch over one parameter is born on a step, if there is one."""
    problem = course.line.problem
    if len(course.limits) > 1 or not problem.autonomous or not turns_round(last, point):
        return None
    return birth_between(last, point, course.name, problem)


def _how_unstable(shot: Shot) -> str:
    return (
        f"neighbours part by a factor of {np.abs(shot.monodromy).max():.2g} in a period of "
        f"{shot.duration:.6g}: rounding hides the multipliers, "
        "as where a period grows without bound"
    )


def _halved(course: Course, last: Point[Shot], step: Step[Shot]) -> Point[Shot] | None:
    """Return the cycle that doubles its period on a step along a branch, if there is one.

    There the branch of doubled cycles ends, as a cycle twice round. A step either comes to such a
    cycle itself, or passes to the same branch half a period later: the parameter turns back, and
    there is no fold.
    """
    point = step.point
    twice = _is_twice_round(point.stretch)
    turns = last.tangent[PLACE] * point.tangent[PLACE] < 0.0
    if not twice and (not turns or any(each.name == FOLD for each in step.met)):
        return None
    near = point if twice or abs(point.tangent[PLACE]) < abs(last.tangent[PLACE]) else last
    return _cycle_of_half(course, near)


def _cycle_of_half(course: Course, near: Point[Shot]) -> Point[Shot] | None:
    """Return the cycle of half the period, near a point, that doubles its period, if there is one.

    Under a load it takes whole revolutions.
    """
    if course.half is None and near.stretch.rotor.load > 0.0:
        return None
    half = Curve(course.half or course.line.problem, course.line.scale * HALF)
    try:
        return half.root(half.first(near.unknowns * HALF), doubling_test)
    except SimulationError:
        return None


def _is_twice_round(shot: Shot) -> bool:
    """Return whether a cycle is one of half its period, followed twice."""
    return _halves_agree(shot, EQUAL_HALVES)


def _halves_agree(shot: Shot, part: float) -> bool:
    """Return whether the extreme radii of both halves of a cycle agree to a part of the largest."""
    radii = shot.extrema["radius"].tolist()
    half, odd = divmod(len(radii), 2)
    if odd or not half:
        return False
    pairs, allowed = zip(radii[:half], radii[half:], strict=True), part * max(radii)
    return all(abs(one - other) <= allowed for one, other in pairs)


def _passed(course: Course, point: Point[Shot]) -> tuple[int, float] | None:
    """Return the place and the value of a limit that a point has passed, or None."""
    for place, (low, high) in course.limits.items():
        here = float(point.unknowns[place])
        if not low <= here <= high:
            return place, low if here < low else high
    return None


def _comes_back(course: Course, last: Point[Shot], point: Point[Shot]) -> bool:
    """Return whether a step passes the first point of its branch, led as there.

    A branch comes back at any phase: the cycles are compared by what does not hang on it.
    """
    between = (course.first.unknowns - last.unknowns) * (course.first.unknowns - point.unknowns)
    # under a load the period may stand still, but for rounding
    apart = (point.unknowns - last.unknowns) ** 2 + (ROUNDING_OF_PERIOD * course.line.scale) ** 2
    if (between[PLACE - 1 :] > apart[PLACE - 1 :]).any():
        return False
    goal, here, there = (_signature(each) for each in (course.first, last, point))
    along = there - here
    part = float((goal - here) @ along) / float(along @ along)
    miss = np.linalg.norm(goal - here - part * along)
    if not (0.0 <= part <= 1.0 and miss <= PASSES_WITHIN * np.linalg.norm(along)):
        return False
    # the parameter that changes most there tells the place
    place = PLACE + int(np.argmax(np.abs(course.first.tangent[PLACE:])))
    try:
        again = course.line.crossing(last, point, place, float(course.first.unknowns[place]))
    except SimulationError:
        return False
    same = np.linalg.norm(_signature(again) - goal) <= SAME_CYCLE * np.linalg.norm(goal)
    return bool(same and again.tangent[place] * course.first.tangent[place] > 0.0)


def _same(special: Special[Shot], known: Special[Shot]) -> bool:
    """Return whether two special points are one, at whatever phase."""
    one, other = _signature(special.point), _signature(known.point)
    near = np.linalg.norm(one - other) <= SAME_CYCLE * np.linalg.norm(other)
    return special.name == known.name and bool(near)


def _signature(point: Point[Shot]) -> Values:
    """Return numbers of a cycle that do not hang on its phase."""
    cycle = Cycle(point.stretch, 0.0)
    return np.array([*point.unknowns[4:], cycle.radius_min, cycle.radius_max])
