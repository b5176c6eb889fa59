"""Special points in one step along a curve: where a test function is 0, or a count changes.

Two zeros of a test function may lie within one step, if it turns on the way. So a polynomial is
drawn through its values at both ends, at earlier points, and at others on the way. Where this turns
so near 0 that the function might reach it, the curve is followed to that place, which is added to
the polynomial. The error found there decides how near is near enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import brentq

from rotor_ida.cycles.orbit import Orbit
from rotor_ida.errors import SimulationError

if TYPE_CHECKING:
    from rotor_ida.cycles.continuation import Point


# Special points are located to this fraction of the scales: some dozens of roundings.
FINEST = 1e-14
# Where a count changes, number of halvings of a step before the root of the function that is 0
# there is sought: the function need change sign only nearby.
FIRST_HALVINGS = 5
# Number of halvings if the function has no root: to a fraction of 1e-15 of the step.
MOST_HALVINGS = 50
# A count may change twice within a step. If the function comes this near to 0, relative to the
# size of the state, the middle of the step is examined too.
NEAR_A_CHANGE = 2e-2
# A test function is evaluated where it seems to turn, if its value there is within this fraction of
# its change from 0: the possible error of the first polynomial, through few points.
UNSURE = 0.5
# After an evaluation: within this multiple of the error of the polynomial.
CAREFUL = 10.0
# Largest number of points of a polynomial, the nearest ones; through more it oscillates.
MOST_NODES = 6
# Between two nodes, others closer together than this fraction of half the gap are redundant.
APART = 1e-2
# A turn is known to rounding after a few evaluations; two turns near a graze take many.
MOST_LOOKS = 30
# An evaluation this near a known point, relative to the step, adds nothing.
KNOWN = 1e-6
# A test function that passes 0 by no more than this and turns back only touches it: as that of a
# fold does where a branch of doubled cycles returns to the one that it left.
TOUCH = 1e-7
# A test function that changes its sign where it is farther from 0 than this jumps over it, as at a
# corner of the curve, where multipliers jump. That special point has a name of its own.
JUMP, DISCONTINUOUS = 1e-4, "discontinuous"
# Places on a step that are the same but for rounding, in parts of the step.
SAME_PLACE = 1e-6
# Distance outside the step, relative to it, at which the parabola through three points may turn.
OUTSIDE = 0.5


@dataclass(frozen=True, slots=True)
class Count:
    """An integer of an orbit, and a function that changes sign where the integer changes.

    The function need do so only nearby.
    """

    number: Callable[[Orbit], int]
    sign: Callable[[Orbit], float]


@dataclass(frozen=True, slots=True)
class Special:
    """A special point of a curve: its name, and the point."""

    name: str
    point: Point


@dataclass(frozen=True, slots=True)
class Way:
    """A step in which special points are sought.

    Parameters
    ----------
    points : dict of float to Point
        The known points, by their length along the tangent: at 0, where it begins, at its end, and
        at those of earlier points.
    length : float
        Its length.
    close : callable
        Returns the point at a length, predicted from one nearby.
    about : callable
        Returns an orbit close to the point at a length, which need not close, at a third of the
        cost.
    """

    points: dict[float, Point]
    length: float
    close: Callable[[float, Point], Point]
    about: Callable[[float], Orbit]

    def at(self, part: float) -> Point:
        """Return the point a length along the tangent."""
        if part not in self.points:
            # points nearer to the beginning than to the place are no use for it
            near = [each for each in self.points if abs(each - part) <= each]
            nearest = min(near, key=lambda each: abs(each - part))
            self.points[part] = self.close(part, self.points[nearest])
        return self.points[part]


def specials_on(
    way: Way,
    tests: Mapping[str, Callable[[Point], float]],
    counts: Mapping[str, Count],
) -> list[Special]:
    """Return the special points of a step, in order.

    The tests are functions of a point, each 0 at a special point of its name. Where one jumps over
    0 the name is `DISCONTINUOUS`.
    """
    located: list[tuple[float, Special]] = []
    for name, count in counts.items():
        located += _changes(way, name, count)
    kinks = [place for place, _ in located]  # a test function has a corner there
    for name, test in tests.items():
        for between in _sign_changes(way, test, kinks):
            place, special = _zero(way, between, name, test)
            # rounding must not decide whether a jump lies before or behind the kink that it is
            here = [kink for kink in kinks if abs(kink - place) <= SAME_PLACE * way.length]
            located.append((here[0] if special.name == DISCONTINUOUS and here else place, special))
    located.sort(key=lambda each: each[0])
    return [special for _, special in located]


# ---- Zeros of a test function ----


def _sign_changes(
    way: Way, test: Callable[[Point], float], kinks: list[float]
) -> list[tuple[float, float]]:
    """Return pairs of places on a step between which a test function changes its sign once."""
    located: list[tuple[float, float]] = []
    for low, high in pairwise(sorted({0.0, *kinks, way.length})):
        begins = -math.inf if low == 0.0 else low
        nodes = {
            place: test(point) for place, point in way.points.items() if begins <= place <= high
        }
        if len(nodes) == 2 and not _is_clear(nodes):
            nodes[0.5 * (low + high)] = test(way.at(0.5 * (low + high)))
        if _may_turn_near_zero(nodes, low, high):
            _look_at_turns(way, test, nodes, (low, high))
        located += [
            (first, last)
            for first, last in pairwise(sorted(place for place in nodes if place >= low))
            # a 0 counts as positive, so that one at the beginning of a curve is found once
            if (nodes[first] < 0.0) != (nodes[last] < 0.0)
        ]
    return located


def _is_clear(nodes: Mapping[float, float]) -> bool:
    """Return whether the change of a function in a step is small compared with its value."""
    least = min(map(abs, nodes.values()))
    return least > max(nodes.values()) - min(nodes.values())


def _may_turn_near_zero(nodes: Mapping[float, float], low: float, high: float) -> bool:
    """Return whether more zeros are possible than the ends show, by a parabola of three nodes."""
    if any(value * nodes[low] < 0.0 for value in nodes.values()):
        return True
    others = [place for place in nodes if place not in {low, high}]
    if not others:  # at the beginning, and far from 0
        return False
    third = max(others)
    (a, fa), (b, fb), (c, fc) = sorted((place, nodes[place]) for place in (third, low, high))
    first, second = (fb - fa) / (b - a), (fc - fb) / (c - b)
    bend = (second - first) / (c - a)
    if bend == 0.0:
        return False
    turn = 0.5 * (a + b) - 0.5 * first / bend
    value = fa + (turn - a) * (first + (turn - b) * bend)
    near = math.copysign(1.0, fb) * value <= UNSURE * (max(fa, fb, fc) - min(fa, fb, fc))
    outside = OUTSIDE * (high - low)
    return near and low - outside <= turn <= high + outside


def _look_at_turns(
    way: Way,
    test: Callable[[Point], float],
    nodes: dict[float, float],
    between: tuple[float, float],
) -> None:
    """Add the values of a test function where it turns near 0 between two places of a step.

    If the polynomial shows no more such turns, it is checked in the middle of its widest gap: near
    a graze, where M changes like a root, it is inaccurate at first.
    """
    begin, known = between[0], KNOWN * (between[1] - between[0])
    unsure, sure = UNSURE * (max(nodes.values()) - min(nodes.values())), False
    for _ in range(MOST_LOOKS):
        turn = _turn_near_zero(nodes, begin, unsure, known)
        if turn is None and sure:
            return
        place, expected = turn or _middle_of_widest_gap(nodes, begin)
        value = test(way.at(place))
        error = abs(value - expected)
        unsure = CAREFUL * error
        nodes[place] = math.copysign(value, nodes[begin]) if abs(value) <= TOUCH else value
        sure = turn is None and unsure <= max(min(map(abs, nodes.values())), TOUCH)


def _middle_of_widest_gap(nodes: Mapping[float, float], begin: float) -> tuple[float, float]:
    """Return the middle of the widest gap between nodes of a step, and the polynomial there."""
    inside = sorted(place for place in nodes if place >= begin)
    low, high = max(pairwise(inside), key=lambda gap: gap[1] - gap[0])
    return 0.5 * (low + high), float(_polynomial(nodes, low, high)(0.0))


def _turn_near_zero(
    nodes: Mapping[float, float], begin: float, unsure: float, known: float
) -> tuple[float, float] | None:
    """Return where a test function may turn near 0, and its value there; None if nowhere.

    The value is within `unsure` of 0, and the place not within `known` of a known place.
    """
    inside = sorted(place for place in nodes if place >= begin)
    for low, high in pairwise(inside):
        side = math.copysign(1.0, nodes[low])
        turns, crosses = _turns_between(nodes, low, high), nodes[low] * nodes[high] < 0.0
        if crosses and len(turns) < 2:
            continue  # it passes 0 once
        nearer = min(side * nodes[low], side * nodes[high])
        for place, value in turns:
            towards = crosses or side * value < nearer
            new = min(abs(place - each) for each in inside) > known
            if towards and new and side * value <= unsure:
                return place, value
    return None


def _turns_between(
    nodes: Mapping[float, float], low: float, high: float
) -> list[tuple[float, float]]:
    """Return the extrema of the polynomial through the nearest nodes between two of them."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    polynomial = _polynomial(nodes, low, high)
    roots = polynomial.deriv().roots()
    turns = sorted(roots[(np.abs(roots.imag) < 1e-9) & (np.abs(roots.real) < 1.0)].real.tolist())
    return [(middle + half * turn, float(polynomial(turn))) for turn in turns]


def _polynomial(nodes: Mapping[float, float], low: float, high: float) -> Polynomial:
    """Return the polynomial through the nodes nearest to a gap, scaled to -1 to 1."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    nearest = [low, high]
    for place in sorted(nodes, key=lambda place: abs(place - middle)):
        if min(abs(place - each) for each in nearest) >= APART * half:
            nearest.append(place)
    nearest = nearest[:MOST_NODES]
    powers = np.vander((np.array(nearest) - middle) / half, increasing=True)
    return Polynomial(np.linalg.solve(powers, np.array([nodes[each] for each in nearest])))


def _zero(
    way: Way, between: tuple[float, float], name: str, test: Callable[[Point], float]
) -> tuple[float, Special]:
    """Return where a test function is 0 in a step, and the special point there."""
    low, high = between
    try:
        place = float(brentq(lambda part: test(way.at(part)), low, high, xtol=FINEST, rtol=FINEST))
    except (ValueError, RuntimeError):  # no change of sign when followed again
        raise SimulationError(f"a {name} could not be located") from None
    point = way.at(place)
    return place, Special(name if abs(test(point)) <= JUMP else DISCONTINUOUS, point)


# ---- Changes of a count ----


def _changes(way: Way, name: str, count: Count) -> list[tuple[float, Special]]:
    """Return where a count changes in a step, and the special points there."""
    ends = (way.at(0.0).orbit, way.at(way.length).orbit)
    places = [(0.0, ends[0]), (way.length, ends[1])]
    nearest = min(abs(count.sign(each)) for each in ends)
    if nearest < NEAR_A_CHANGE * math.sqrt(ends[0].start @ ends[0].start):
        middle = 0.5 * way.length
        about = count.number(way.about(middle))
        if any(about != count.number(end) for end in ends):
            places.insert(1, (middle, way.at(middle).orbit))
    located: list[tuple[float, Special]] = []
    for below, above in pairwise(places):
        located += _changes_between(way, (below, above), name, count)
    return located


def _changes_between(
    way: Way, between: tuple[tuple[float, Orbit], tuple[float, Orbit]], name: str, count: Count
) -> list[tuple[float, Special]]:
    """Return where a count changes between two places of a step, with their orbits."""
    located: list[tuple[float, Special]] = []
    (low, below), (length, last_orbit) = between
    while count.number(below) != count.number(last_orbit):
        high, above = length, last_orbit
        for halving in range(MOST_HALVINGS):
            if halving >= FIRST_HALVINGS and count.sign(below) * count.sign(above) < 0.0:
                located.append(_zero(way, (low, high), name, lambda point: count.sign(point.orbit)))
                break
            middle = 0.5 * (low + high)
            here = way.at(middle).orbit
            if count.number(here) == count.number(below):
                low, below = middle, here
            else:
                high, above = middle, here
        else:
            located.append((high, Special(name, way.at(high))))
        low, below = high, above
    return located
