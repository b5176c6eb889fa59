"""Follow a curve of closed orbits of any flow: pseudo-arclength continuation.

A point of the curve is ``u = (s, T, p...)``: a state, the period, and one parameter, or two with a
further condition. It solves the shooting equations at a given distance along the tangent of the
previous point, so that folds are passed like other points [1]_. The flow has to supply an `Orbit`:
the end of an orbit, and its derivatives. Lengths are measured with each unknown relative to its
scale. A step:

1. *predict* by a polynomial through the last three points, with the tangents there,
2. *correct* by Newton's method in the plane across it,
3. retry with a shorter step if that fails or the curve bends too much; lengthen the next step after
   an easy one,
4. *locate* special points on the way: where a test function changes sign, or a count its value.

References
----------
.. [1] H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", in
   P. H. Rabinowitz (ed.), Applications of Bifurcation Theory, 1977.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.linalg.lapack import dgesv
from scipy.optimize import brentq

from rotor_ida.arrays import Values
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.cycles.special_points import (
    DISCONTINUOUS,
    FINEST,
    Count,
    Special,
    Way,
    specials_on,
)
from rotor_ida.errors import SimulationError

# Lengths are relative to the scales.

# Largest number of Newton steps: a good prediction takes one or two, a first guess some more.
MOST_NEWTON_STEPS = 10
# The first ones may grow; after that each must be smaller.
FREE_STEPS = 3
# A step this small leaves an error of its square, or near a graze of its power 1.5: after it the
# error is rounding.
CONVERGED = 1e-9
# A step this small, some hundred roundings, is not taken at all.
ROUNDING_STEP = 2e-14
# At a step this large, the size of the state itself, the method has left the curve.
LEAVES = 1.0

# Steps along the curve. The first is short, as only its tangent is known there.
FIRST_STEP = 5e-3
LONGEST_STEP = 4e-2
# If even this one fails, no step can be taken.
SHORTEST_STEP = 1e-10
# A step that fails is tried again, shorter by this factor.
CUT = 0.5
# A step fails if the curve bends by more than 23 degrees,
LEAST_COSINE = 0.92
# or if Newton's method corrects it by more than this fraction of its length.
MOST_CORRECTION = 0.25
# Where a count changes the curve may have a corner. It is passed with a step no longer than this,
# with a turn of up to 84 degrees.
CORNER, SHARPEST = 1e-7, 10.0
# After an easy one, with at most this number of Newton steps and a turn below 10 degrees,
EASY_STEPS = 4
GOOD_COSINE = 0.985
# the next is longer by this factor.
GROWTH = 1.5
# The direction along which states do not move is kept, so that points lie in one plane, until the
# field has turned from it by 18 degrees.
KEPT_COSINE = 0.95
# Number of points before the last one from which, with their tangents, the next is predicted.
EARLIER = 2
# Largest number of secant steps; none is longer than the longest along the curve.
MOST_SECANTS = 30


@dataclass(frozen=True, slots=True)
class Point:
    """A point of a curve.

    Parameters
    ----------
    unknowns : ndarray, shape (m,)
        State, period and parameters.
    orbit : Orbit
        The orbit, followed for one period.
    tangent : ndarray, shape (m,)
        Direction of the curve relative to the scales, of length 1.
    direction : ndarray, shape (n,)
        The direction along which the state may not move from there on: the field there, or at an
        earlier point.
    """

    unknowns: Values
    orbit: Orbit
    tangent: Values
    direction: Values

    def reversed(self) -> Point:
        """Return the point with the direction of the curve reversed."""
        return replace(self, tangent=-self.tangent)


@dataclass(frozen=True, slots=True)
class Problem:
    """A curve of closed orbits, by its equations.

    Parameters
    ----------
    shoot : callable
        Returns the orbit for given unknowns; SimulationError if there is none.
    equations : callable
        Returns the residuals of the equations, shape (m - 1,), and their derivatives, shape
        (m - 1, m), from the unknowns, their orbit, and a direction along which the state may not
        move.
    check : callable
        Raises SimulationError if a closed orbit is not a solution of the kind sought.
    tests : mapping of str to callable
        Functions of a point and the previous one, each 0 at a special point of that name.
    counts : mapping of str to Count
        Integers of an orbit, each of which changes at a special point of that name.
    autonomous : bool
        Whether an orbit may begin anywhere on a cycle. If not, no direction is fixed.
    closes : callable
        Whether an orbit closes. If not, Newton's method goes on after a small step: near a graze
        derivatives by differences are inaccurate.
    """

    shoot: Callable[[Values], Orbit]
    equations: Callable[[Values, Orbit, Values], tuple[Values, Values]]
    check: Callable[[Orbit], object]
    tests: Mapping[str, Callable[[Point, Point], float]] = field(default_factory=dict)
    counts: Mapping[str, Count] = field(default_factory=dict)
    autonomous: bool = True
    closes: Callable[[Orbit], bool] = lambda _: True


@dataclass(frozen=True, slots=True)
class Step:
    """One step along a curve.

    Parameters
    ----------
    point : Point
        The point reached.
    specials : list of Special
        The special points on the way, in order.
    taken, length : float
        Its length, and that of the next one, relative to the scales.
    """

    point: Point
    specials: list[Special]
    taken: float
    length: float


def shooting_equations(orbit: Orbit, direction: Values, *columns: Values) -> tuple[Values, Values]:
    """Return the residuals of the shooting equations, and their derivatives.

    The state may not move along `direction`, the field at a nearby point; `columns` are the
    derivatives of the end by the parameters.

    Returns
    -------
    miss : ndarray, shape (n + 1,)
        Start less end, and 0.
    matrix : ndarray, shape (n + 1, n + 1 + parameters)
        Derivatives of end less start, and of the state along the direction.
    """
    n = orbit.start.size
    miss, matrix = np.zeros(n + 1), np.zeros((n + 1, n + 1 + len(columns)))
    np.subtract(orbit.start, orbit.end, out=miss[:n])
    matrix[:n, :n] = orbit.monodromy
    matrix.ravel()[: n * matrix.shape[1] : matrix.shape[1] + 1] -= 1.0  # the diagonal
    matrix[:n, n] = orbit.end_rate
    for number, column in enumerate(columns, start=n + 1):
        matrix[:n, number] = column
    matrix[n, :n] = direction / math.sqrt(direction @ direction)
    return miss, matrix


@dataclass(frozen=True, slots=True)
class Curve:
    """A curve of closed orbits that is followed step by step.

    Parameters
    ----------
    problem : Problem
        Its equations.
    scale : ndarray, shape (m,)
        Sizes of the unknowns, relative to which lengths are measured.
    """

    problem: Problem
    scale: Values

    def first(self, guess: Values) -> Point:
        """Return the point near a guess with the same last parameter, directed to larger ones."""
        try:
            return self.near(guess, _unit(guess.size, -1))
        except SimulationError:  # the curve turns back there
            return self.near(guess, self._across(guess))

    def _across(self, guess: Values) -> Values:
        """Return the normal of a plane across a curve whose last parameter turns back.

        It points along the period or, if the parameters determine the period, along the curve.
        """
        if self.problem.autonomous:
            return _unit(guess.size, -2)
        orbit = self.problem.shoot(guess)
        _, matrix = self.problem.equations(guess, orbit, orbit.start_rate)
        return np.asarray(np.linalg.svd(matrix * self.scale)[2][-1])

    def near(self, guess: Values, plane: Values) -> Point:
        """Return the point in the plane through `guess` with normal `plane`."""
        return self._corrected(guess, plane)[0]

    def step(self, last: Point, length: float, earlier: Sequence[Point] = ()) -> Step:
        """Take a step of this length, or a shorter one if necessary.

        `earlier` are points before the last, the nearest first. SimulationError if even the
        shortest step fails, with the reason of the last attempt.
        """
        while True:
            try:
                guess = self._guess(last, earlier, length)
                point, newton_steps = self._corrected(guess, last.tangent, last.direction)
                cosine = float(point.tangent @ last.tangent)
                moved = _size((point.unknowns - guess) / self.scale)
                if cosine >= LEAST_COSINE and moved <= MOST_CORRECTION * length:
                    specials = self._specials(last, (point, *earlier), length)
                    break
                if length <= CORNER and moved <= SHARPEST * length and self._changes(last, point):
                    # multipliers jump there
                    kept = {*self.problem.counts, DISCONTINUOUS}
                    specials = self._specials(last, (point,), length)
                    specials = [each for each in specials if each.name in kept]
                    break
                reason = "the curve bends too much"
            except SimulationError as error:
                reason = error.reason
            # behind a kink, earlier points are no guide
            length, earlier = length * CUT, ()
            if length < SHORTEST_STEP:
                raise SimulationError(f"no step can be taken: {reason}")
        easy = newton_steps <= EASY_STEPS and cosine >= GOOD_COSINE
        longer = min(length * GROWTH, LONGEST_STEP) if easy else length
        return Step(self._led_on(point), specials, length, longer)

    def _changes(self, last: Point, point: Point) -> bool:
        """Return whether a count differs between two points."""
        return any(
            count.number(last.orbit) != count.number(point.orbit)
            for count in self.problem.counts.values()
        )

    def crossing(self, last: Point, point: Point, place: int, value: float) -> Point:
        """Return the point at which an unknown has a value that it passes in a step."""
        length = float((point.unknowns - last.unknowns) / self.scale @ last.tangent)

        def beyond(part: float) -> float:
            return float(self._guess(last, (point,), part)[place]) - value

        if beyond(0.0) * beyond(length) > 0.0:
            raise SimulationError("the step does not pass the value")
        guess = self._guess(last, (point,), float(brentq(beyond, 0.0, length)))
        guess[place] = value
        found = self.near(guess, _unit(guess.size, place))
        return found if float(found.tangent @ last.tangent) > 0.0 else found.reversed()

    def root(self, near: Point, test: Callable[[Orbit], float]) -> Point:
        """Return the nearby point at which a test function is 0, by the secant method.

        SimulationError if it finds none.
        """
        before, value, place = 0.0, test(near.orbit), FIRST_STEP
        for _ in range(MOST_SECANTS):
            point = self._at(near, (), place)
            here = test(point.orbit)
            change = -here * (place - before) / (here - value) if here != value else 0.0
            if abs(change) <= FINEST:
                return point
            before, value = place, here
            place += min(max(change, -LONGEST_STEP), LONGEST_STEP)
        raise SimulationError("no special point was found close by")

    def direction_at(self, orbit: Orbit, before: Values) -> Values:
        """Return the direction along which the state may not move from a point on.

        It is that of the previous point while possible, so that points lie in one plane.
        """
        if not self.problem.autonomous:
            return before
        rate = orbit.start_rate
        kept = before @ rate >= KEPT_COSINE * _size(before) * _size(rate)
        return before if kept else rate

    def _led_on(self, point: Point) -> Point:
        """Return a point with the direction from there on, and the tangent normal to it."""
        direction = self.direction_at(point.orbit, point.direction)
        if direction is point.direction:
            return point
        turned = replace(point, direction=direction)
        _, tangent = self._beside(turned, point)
        return replace(turned, tangent=tangent / _size(tangent))

    def _at(self, last: Point, others: Sequence[Point], length: float) -> Point:
        """Return the point a length along the tangent."""
        guess = self._guess(last, others, length)
        return self._corrected(guess, last.tangent, last.direction)[0]

    def _guess(self, last: Point, others: Sequence[Point], length: float) -> Values:
        """Return an approximation of the point a length along the tangent.

        It lies on the tangent, or on the Hermite polynomial, in the length along the tangent,
        through the last point and others before or after it.
        """
        lengths, chords, slopes = [0.0], [np.zeros(self.scale.size)], [last.tangent]
        for other in others:
            chord, tangent = self._beside(last, other)
            lengths.append(float(chord @ last.tangent))
            chords.append(chord)
            slopes.append(tangent / (tangent @ last.tangent))
        along = np.zeros(self.scale.size)
        for here, chord, slope in zip(lengths, chords, slopes, strict=True):
            basis, bend, beyond = 1.0, 0.0, length - here
            for there in lengths:
                if there != here:
                    basis *= (length - there) / (here - there)
                    bend += 1.0 / (here - there)
            along += basis**2 * ((1.0 - 2.0 * bend * beyond) * chord + beyond * slope)
        move, direction = along * self.scale, last.direction
        if self.problem.autonomous:
            # rounding along the direction would grow from step to step
            n = direction.size
            move[:n] -= (direction @ move[:n]) / (direction @ direction) * direction
        return last.unknowns + move

    def _beside(self, last: Point, other: Point) -> tuple[Values, Values]:
        """Return the offset of another point from the last one, and its tangent, at equal phase.

        Its state is shifted along its orbit into the plane across the direction at the last one.
        """
        chord, tangent = (other.unknowns - last.unknowns) / self.scale, other.tangent
        if other.direction is last.direction or not self.problem.autonomous:
            return chord, tangent
        rate, n = other.orbit.start_rate, last.direction.size
        across = np.zeros(self.scale.size)
        across[:n] = last.direction * self.scale[:n]
        shift = np.zeros(self.scale.size)
        shift[:n] = rate / self.scale[:n] / (last.direction @ rate)
        return chord - (across @ chord) * shift, tangent - (across @ tangent) * shift

    def _corrected(
        self, guess: Values, plane: Values, direction: Values | None = None
    ) -> tuple[Point, int]:
        """Return the point in the plane through `guess` with normal `plane`, and the steps.

        The state does not move along `direction`, by default the field at the guess.
        """
        unknowns, size = guess, math.inf
        for steps in range(MOST_NEWTON_STEPS + 1):
            orbit = self.problem.shoot(unknowns)
            direction = orbit.start_rate if direction is None else direction
            if size <= CONVERGED and self.problem.closes(orbit):
                return self._point(unknowns, orbit, plane, direction), steps
            miss, matrix = self._bordered(unknowns, orbit, direction, plane)
            step = _solved(matrix, miss)
            before, size = size, _size(step)
            if size <= ROUNDING_STEP:
                return self._point(unknowns, orbit, plane, direction), steps
            if steps >= FREE_STEPS and size > before:
                break
            if not size < LEAVES:
                raise SimulationError("Newton's method leaves the curve")
            unknowns = unknowns + step * self.scale
            if unknowns[orbit.start.size] <= 0.0:
                raise SimulationError("the period shrinks to nothing")
        raise SimulationError("Newton's method does not converge to the curve")

    def _point(self, unknowns: Values, orbit: Orbit, plane: Values, direction: Values) -> Point:
        """Return a closed orbit as a point of the curve, directed like `plane`."""
        self.problem.check(orbit)
        _, matrix = self._bordered(unknowns, orbit, direction, plane)
        tangent = _solved(matrix, _unit(plane.size, -1))
        return Point(unknowns, orbit, tangent / _size(tangent), direction)

    def _bordered(
        self, unknowns: Values, orbit: Orbit, direction: Values, plane: Values
    ) -> tuple[Values, Values]:
        """Return the residuals of the equations, and their derivatives, relative to the scales."""
        miss, matrix = self.problem.equations(unknowns, orbit, direction)
        bordered, right = np.empty((plane.size, plane.size)), np.zeros(plane.size)
        np.multiply(matrix, self.scale, out=bordered[:-1])
        bordered[-1], right[:-1] = plane, miss
        return right, bordered

    def _specials(self, last: Point, others: tuple[Point, ...], length: float) -> list[Special]:
        """Return the special points of a step, in order."""
        behind = [float(self._beside(last, each)[0] @ last.tangent) for each in others[1:]]
        known = [(0.0, last), (length, others[0]), *zip(behind, others[1:], strict=True)]
        way = Way(
            dict(known),
            length,
            lambda part, near: self._at(last, (near,), part),
            lambda part: self.problem.shoot(self._guess(last, others, part)),
        )
        tests = {name: partial(_by, test, last) for name, test in self.problem.tests.items()}
        return specials_on(way, tests, self.problem.counts)


def _by(test: Callable[[Point, Point], float], last: Point, point: Point) -> float:
    return test(point, last)


def _solved(matrix: Values, right: Values) -> Values:
    _, _, solution, flag = dgesv(matrix, right)
    if flag != 0:
        raise SimulationError("the equations of the curve are singular")
    return np.asarray(solution)


def _size(vector: Values) -> float:
    """Return the length of a vector."""
    return math.sqrt(vector @ vector)


def _unit(size: int, place: int) -> Values:
    """Return the unit vector along one unknown."""
    unit = np.zeros(size)
    unit[place] = 1.0
    return unit
