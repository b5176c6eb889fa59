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

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.stability import eigenvalues
from rotor_ida.closed_forms.synchronous import synchronous_response
from rotor_ida.cycles.continuation import EARLIER, FIRST_STEP, Curve, Point, Problem, Step
from rotor_ida.cycles.guess import DOUBLING
from rotor_ida.cycles.multipliers import doubling_test, has_trace, on_unit_circle
from rotor_ida.cycles.problems import FOLD, HALF, PLACE, TORUS, Continuation, nearest_gap
from rotor_ida.cycles.shooting import LEFT_THE_RING, Cycle
from rotor_ida.cycles.special_points import DISCONTINUOUS, Special
from rotor_ida.errors import SimulationError
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.neighbours import Shot

HOPF = "hopf"
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
# If a curve of bifurcations ends this near a graze, relative to the clearance, that is the reason.
NEAR_A_GRAZE = 1e-4
# Relative rounding of a constant period.
ROUNDING_OF_PERIOD = 1e-14
# Factor on the range, estimated from two nearby points, in which the bifurcation is sought.
FARTHER = 4.0
# Relative agreement of the whirl's frequency with that of a nearby cycle.
SAME_FREQUENCY = 0.1
# Relative oscillation of the radius of a cycle there: its square is below rounding.
SWING = 3e-7
# Digits to which the parameter is determined.
FINEST = 1e-15


class SpecialBehind(NamedTuple):
    """A special point, and the number of the point of its side that precedes it."""

    place: int
    special: Special[Shot]


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

    points: list[Point[Shot]]
    specials: list[SpecialBehind] = field(default_factory=list)
    length: float = FIRST_STEP
    end: str = ""
    reason: str = ""


def advance(branch: Continuation, side: Side) -> None:
    """Take one step along a branch."""
    last = side.points[-1]
    try:
        step, halved = _step_from(branch, side)
    except SimulationError as error:
        _end_where_stuck(branch, side, error.reason)
        return
    point = step.point
    # two real multipliers of product 1 are no torus
    specials = [
        each for each in step.specials if each.name != TORUS or on_unit_circle(each.point.stretch)
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
    if halved is not None:
        specials, point, side.end = [*specials, Special(DOUBLING, halved)], halved, HALVED
    elif (born := _birth(branch, last, step.point)) is not None:
        # the rest of the step repeats what came before, half a period later
        specials = [each for each in specials if not turns_round(last, each.point)]
        specials, point, side.end = [*specials, Special(HOPF, born)], born, BORN
    side.specials += [SpecialBehind(len(side.points) - 1, each) for each in specials]
    side.points.append(point)
    side.length = step.length
    if side.end:
        return
    if _is_too_unstable(point.stretch):
        side.end, side.reason = UNSTABLE, _how_unstable(point.stretch)
    elif len(side.points) >= branch.most:
        side.end = ENOUGH


def _step_from(branch: Continuation, side: Side) -> tuple[Step[Shot], Point[Shot] | None]:
    """Return the next step of a side, and the cycle on it that doubles its period, if any.

    A step to such a cycle is short.
    """
    last, length = side.points[-1], side.length
    earlier = side.points[-2 : -2 - EARLIER : -1]
    while True:
        step = branch.line.step(last, length, earlier)
        halved = _halved(branch, last, step) if len(branch.limits) == 1 else None
        if halved is None or step.taken <= LAST_STEP:
            return step, halved
        length = SHORTENED * step.taken


def _end_where_stuck(branch: Continuation, side: Side, reason: str) -> None:
    """End a side that allows no further step; at the doubling close by, if there is one."""
    last = side.points[-1]
    if len(branch.limits) == 1 and _halves_agree(last.stretch, NEAR_A_DOUBLING):
        halved = _cycle_of_half(branch, last)
        if halved is not None and _is_close_by(branch, last, halved):
            side.specials.append(SpecialBehind(len(side.points) - 1, Special(DOUBLING, halved)))
            side.points.append(halved)
            side.end = HALVED
            return
    side.end = CONTACT_FREE if LEFT_THE_RING in reason else STUCK
    side.reason = reason
    gap = nearest_gap(last.stretch)
    linear, delta0 = last.stretch.rotor.contact_exponent == 1.0, last.stretch.rotor.delta0
    if len(branch.limits) > 1 and linear and abs(gap) <= NEAR_A_GRAZE * delta0:
        side.reason += (
            f"; the radius comes within {abs(gap):.2g} of the stator, and at a graze of a linear "
            "contact the curve has a corner"
        )


def _is_close_by(branch: Continuation, last: Point[Shot], halved: Point[Shot]) -> bool:
    """Return whether a cycle of half the period is as near to a point as its halves agree."""
    apart = (halved.unknowns - last.unknowns * HALF) / branch.line.scale
    return bool((np.abs(apart[PLACE - 1 :]) <= NEAR_A_DOUBLING).all())


def _is_too_unstable(shot: Shot) -> bool:
    """Return whether rounding hides multipliers that depend on more than the trace of M."""
    return not has_trace(shot) and bool(np.abs(shot.monodromy).max() > LARGEST_M)


def _birth(branch: Continuation, last: Point[Shot], point: Point[Shot]) -> Point[Shot] | None:
    """Return the cycle at which a branch over one parameter is born on a step, if there is one."""
    problem = branch.line.problem
    if len(branch.limits) > 1 or not problem.autonomous or not turns_round(last, point):
        return None
    return birth_between(last, point, branch.name, problem)


def _how_unstable(shot: Shot) -> str:
    return (
        f"neighbouring orbits separate by a factor of {np.abs(shot.monodromy).max():.2g} in a "
        f"period of {shot.duration:.6g}, so rounding hides the multipliers, "
        "as where a period grows without bound"
    )


def _halved(branch: Continuation, last: Point[Shot], step: Step[Shot]) -> Point[Shot] | None:
    """Return the cycle that doubles its period on a step along a branch, if there is one.

    There the branch of doubled cycles ends, as a cycle followed twice. A step either reaches such a
    cycle, or passes to the same branch half a period later: the parameter turns back without a
    fold.
    """
    point, folds = step.point, {FOLD, DISCONTINUOUS}
    twice = _is_twice_round(point.stretch)
    turns = last.tangent[PLACE] * point.tangent[PLACE] < 0.0
    if not twice and (not turns or any(each.name in folds for each in step.specials)):
        return None
    near = point if twice or abs(point.tangent[PLACE]) < abs(last.tangent[PLACE]) else last
    return _cycle_of_half(branch, near)


def _cycle_of_half(branch: Continuation, near: Point[Shot]) -> Point[Shot] | None:
    """Return the cycle of half the period, near a point, that doubles its period, if there is one.

    Under a load it takes a whole number of revolutions.
    """
    if branch.half is None and near.stretch.rotor.load > 0.0:
        return None
    half = Curve(branch.half or branch.line.problem, branch.line.scale * HALF)
    try:
        return half.root(half.first(near.unknowns * HALF), doubling_test)
    except SimulationError:
        return None


def _is_twice_round(shot: Shot) -> bool:
    """Return whether a cycle is one of half its period, followed twice."""
    return _halves_agree(shot, EQUAL_HALVES)


def _halves_agree(shot: Shot, part: float) -> bool:
    """Return whether the extreme radii of both halves agree to a fraction of the largest."""
    radii = shot.extrema["radius"].tolist()
    half, odd = divmod(len(radii), 2)
    if odd or not half:
        return False
    pairs, allowed = zip(radii[:half], radii[half:], strict=True), part * max(radii)
    return all(abs(one - other) <= allowed for one, other in pairs)


def _passed(branch: Continuation, point: Point[Shot]) -> tuple[int, float] | None:
    """Return the index and the value of a limit that a point has passed, or None."""
    for place, (low, high) in branch.limits.items():
        here = float(point.unknowns[place])
        if not low <= here <= high:
            return place, low if here < low else high
    return None


def _comes_back(branch: Continuation, last: Point[Shot], point: Point[Shot]) -> bool:
    """Return whether a step passes the first point of its branch in the same direction.

    A branch may return at any phase: the cycles are compared by quantities independent of it.
    """
    between = (branch.first.unknowns - last.unknowns) * (branch.first.unknowns - point.unknowns)
    # under a load the period may be constant, except for rounding
    apart = (point.unknowns - last.unknowns) ** 2 + (ROUNDING_OF_PERIOD * branch.line.scale) ** 2
    if (between[PLACE - 1 :] > apart[PLACE - 1 :]).any():
        return False
    goal, here, there = (_signature(each) for each in (branch.first, last, point))
    along = there - here
    part = float((goal - here) @ along) / float(along @ along)
    miss = np.linalg.norm(goal - here - part * along)
    if not (0.0 <= part <= 1.0 and miss <= PASSES_WITHIN * np.linalg.norm(along)):
        return False
    # the parameter that changes most there gives the place
    place = PLACE + int(np.argmax(np.abs(branch.first.tangent[PLACE:])))
    try:
        again = branch.line.crossing(last, point, place, float(branch.first.unknowns[place]))
    except SimulationError:
        return False
    same = np.linalg.norm(_signature(again) - goal) <= SAME_CYCLE * np.linalg.norm(goal)
    return bool(same and again.tangent[place] * branch.first.tangent[place] > 0.0)


def _same(special: Special[Shot], known: Special[Shot]) -> bool:
    """Return whether two special points are the same, at any phase."""
    one, other = _signature(special.point), _signature(known.point)
    near = np.linalg.norm(one - other) <= SAME_CYCLE * np.linalg.norm(other)
    return special.name == known.name and bool(near)


def _signature(point: Point[Shot]) -> Values:
    """Return numbers of a cycle that do not depend on its phase."""
    cycle = Cycle(point.stretch, 0.0)
    return np.array([*point.unknowns[4:], cycle.radius_min, cycle.radius_max])


# ---- Where a branch is born ----


def turns_round(last: Point[Shot], point: Point[Shot]) -> bool:
    """Return whether a step has passed a whirl, where the oscillation of the radius vanishes."""
    return float(last.stretch.start_rate @ point.stretch.start_rate) < 0.0


def birth_between(
    last: Point[Shot], point: Point[Shot], name: str, problem: Problem[Shot]
) -> Point[Shot] | None:
    """Return the cycle at which a branch is born between two of its points, if there is one.

    The parameter `name` is that of the Hopf point, to rounding. The cycle oscillates too little
    about the whirl to change period or parameter.
    """
    nearer = min(last, point, key=_swing)
    whirl = _WhirlNear(nearer.stretch, name)
    place = _crossing(whirl.growth, last, point)
    if place is None:
        return None
    state, rate = whirl.at(place)
    period = 2.0 * math.pi / abs(rate.imag)
    if abs(period / nearer.stretch.duration - 1.0) > SAME_FREQUENCY:
        return None
    quarter = problem.shoot(np.array([*state, 0.25 * period, place])).monodromy
    multipliers, vectors = np.linalg.eig(quarter)
    aside = np.real(vectors[:, np.argmin(np.abs(multipliers - 1j))])
    start = state + SWING * np.linalg.norm(state) / np.linalg.norm(aside) * aside
    unknowns = np.array([*start, period, place])
    return replace(nearer, unknowns=unknowns, stretch=problem.shoot(unknowns))


def _swing(point: Point[Shot]) -> float:
    cycle = Cycle(point.stretch, 0.0)
    return cycle.radius_max - cycle.radius_min


def _crossing(
    growth: Callable[[float], float], last: Point[Shot], point: Point[Shot]
) -> float | None:
    """Return where a pair of eigenvalues crosses the imaginary axis near two points of a branch.

    The parameter changes with the square of the oscillation.
    """
    (one, p), (two, q) = ((_swing(each) ** 2, float(each.unknowns[-1])) for each in (last, point))
    apart = FARTHER * abs(p - q) if one == two else 0.0
    guess = p if one == two else p - one * (q - p) / (two - one)
    apart = max(apart, FARTHER * abs(p - guess), FARTHER * abs(q - guess))
    ends = max(guess - apart, 0.0), guess + apart
    try:
        return float(brentq(growth, *ends, xtol=FINEST * guess, rtol=4.0 * FINEST))
    except (ValueError, RuntimeError):  # it does not cross there
        return None


class _WhirlNear:
    """The whirl nearest to a cycle with a small oscillation, over a parameter."""

    def __init__(self, shot: Shot, name: str) -> None:
        cycle = Cycle(shot, 0.0)
        self._rotor, self._name = shot.rotor, name
        self._amplitude = 0.5 * (cycle.radius_min + cycle.radius_max)
        self._frequency = 2.0 * math.pi / shot.duration

    def rotor_at(self, place: float) -> Rotor:
        """Return the rotor for a value of the parameter."""
        return replace(self._rotor, **{self._name: place})

    def growth(self, place: float) -> float:
        """Return the growth rate of the whirl's oscillation at the frequency of the cycle."""
        return self.at(place)[1].real

    def at(self, place: float) -> tuple[Values, complex]:
        """Return state and eigenvalue of the whirl for a value of the parameter."""
        given = self.rotor_at(place).given
        given.pop("load", None)
        given.pop("disc_radius", None)
        whirls = synchronous_response(**given)
        touching = whirls["in_contact"].values.ravel() == 1
        amplitudes = whirls["amplitude"].values.ravel()[touching]
        if not amplitudes.size:
            raise ValueError("there is no whirl in contact")
        nearest = int(np.argmin(np.abs(amplitudes - self._amplitude)))
        amplitude = float(amplitudes[nearest])
        lag = float(whirls["phase_lag"].values.ravel()[touching][nearest])
        rates = eigenvalues(amplitude, **given)
        rate = complex(rates[np.argmin(np.abs(rates - 1j * self._frequency))])
        position = amplitude * complex(math.cos(lag), -math.sin(lag))
        velocity = 1j * given["omega"] * position
        state = np.array([position.real, position.imag, velocity.real, velocity.imag])
        return state, rate
