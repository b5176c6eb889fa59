"""Branches of the rubs of a rotor system over the speed, followed through their folds.

1. *Grid*: all rubs of a set of contacts at many speeds, isolated without losses.
2. *Links*: between neighbouring speeds two rubs are one branch where the slope of each leads to the
   other, and no third rub is near.
3. *Ends*: from each rub without a link, and from where a contact is just touched, the branch is
   followed in short steps along its arc, the speed being an unknown, until it reaches the end of
   another rub, or a contact opens. No step of the grid decides what is seen there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from rotor_ida.arrays import ROUNDING, ComplexValues, Flags, Values
from rotor_ida.closed_forms.receptances import Receptances, receptances
from rotor_ida.closed_forms.whirls.at_speeds import effects, rubbing_whirls, rubs
from rotor_ida.closed_forms.whirls.double_rubs import balance
from rotor_ida.closed_forms.whirls.turning_axes import (
    Whirls,
    eigenvalues_in_contact,
    eigenvalues_without_contact,
)
from rotor_ida.model.assembly import Assembly
from rotor_ida.model.axisymmetric import ForwardMotions
from rotor_ida.model.contact import HERTZ_EXPONENT

# Relative step of differences over the speed. Largest number of Newton steps, the relative size of
# the last, and the size from which rounding may be what is left.
_DIFFERENCE, _STEPS, _SOLVED, _ROUNDED = 1e-7, 12, 1e-13, 1e-9
# Two rubs are linked where slopes predict each from the other to these parts of their distance and
# of themselves, and to this part of the distance of any third.
_OF_DISTANCE, _OF_SIZE = 0.2, 0.01
# Steps along a branch: the first, the longest and the shortest, in parts of the range of speeds and
# of the largest unknowns; the least cosine of the angle between tangents, the farthest from the
# tangent, and the most of an unknown, or of the largest one, that a step may change.
_FIRST, _LONGEST, _SHORTEST, _MOST = 0.01, 0.1, 1e-11, 20_000
_GROWTH, _TURN, _ASIDE, _CHANGE, _OF_LARGEST = 1.7, 0.95, 0.3, 0.2, 1e-3
# Unknown of a contact that is just touched. Part of a step beside a fold. Distance of points that
# are one. Largest number of halvings of a piece.
TOUCHED, _BESIDE, _SAME, _HALVINGS = 1e-10, 1e-5, 1e-5, 12

Touching = tuple[int, ...]
# The unknowns of each rub at each speed: shapes (rub, contacts that touch).
Roots = list[Values]


@dataclass(frozen=True, slots=True)
class RubProblem:
    """A system whose whirls are followed over the speed."""

    assembly: Assembly
    motions: ForwardMotions

    @property
    def clearances(self) -> Values:
        """The clearances of the contacts."""
        return np.array([each.clearance for each in self.assembly.contacts])

    def hertz(self, touching: Touching) -> list[bool]:
        """Return which of some contacts are Hertz contacts."""
        return [self.assembly.contacts[j].exponent == HERTZ_EXPONENT for j in touching]

    def response(self, speeds: Sequence[float] | Values) -> Receptances:
        """Return the receptances at speeds."""
        return receptances(self.assembly, np.asarray(speeds, float))

    def roots(self, touching: Touching, speeds: Values) -> Roots:
        """Return all rubs of a set of contacts, whether or not the others are free."""
        if not touching:
            return [np.zeros((1, 0))] * speeds.size
        contacts = self.assembly.contacts
        rows, depths = rubs(contacts, self.response(speeds), speeds, touching)
        v = depths / self.clearances[list(touching)]
        v = np.where(self.hertz(touching), np.sqrt(v), v)
        order = np.lexsort((*v.T[::-1], rows))
        return np.split(v[order], np.searchsorted(rows[order], np.arange(1, speeds.size)))

    def balance(self, touching: Touching, v: Values, speeds: Values) -> tuple[Values, Values]:
        """Return what vanishes in rubs, one for each speed, and its slopes."""
        chosen = list(touching)
        free, effect = effects(self.assembly.contacts, self.response(speeds), speeds)
        own = effect[:, chosen][:, :, chosen]
        return balance(free[:, chosen], own, self.hertz(touching), v)

    def whirls(self, touching: Touching, v: Values, speeds: Values) -> Whirls:
        """Return rubs as whirls, one for each speed."""
        response, rows = self.response(speeds), np.arange(speeds.size)
        depths = np.where(self.hertz(touching), v * v, v) * self.clearances[list(touching)]
        if not touching:
            return Whirls(rows, np.zeros((speeds.size, len(self.clearances))), response.free)
        return rubbing_whirls(self.assembly, response, speeds, rows, touching, depths)

    def eigenvalues(self, touching: Touching, v: Values, speeds: Values) -> ComplexValues:
        """Return the eigenvalues of rubs on rotating axes, one row for each speed."""
        if not touching:
            found = eigenvalues_without_contact(self.motions, speeds)
            return np.asarray(found - 1j * speeds[:, np.newaxis])
        whirls = self.whirls(touching, v, speeds)
        return eigenvalues_in_contact(self.motions, self.assembly.contacts, speeds, whirls)


@dataclass(frozen=True, slots=True)
class Curve:
    """The branches of a set of contacts in coordinates of one size: unknowns and, last, the speed.

    Parameters
    ----------
    problem : RubProblem
        The system.
    touching : tuple of int
        The contacts that touch.
    scale : ndarray, shape (k + 1,)
        What the coordinates are divided by.
    """

    problem: RubProblem
    touching: Touching
    scale: Values

    def equations(self, points: Values) -> tuple[Values, Values]:
        """Return what vanishes on a branch, and its slopes, shapes (n, k) and (n, k, k + 1)."""
        count, at = len(points), points * self.scale
        if not self.touching:
            return np.zeros((count, 0)), np.zeros((count, 0, 1))
        v, speeds = at[:, :-1], at[:, -1]
        step = _DIFFERENCE * speeds
        left, slope = self.problem.balance(
            self.touching, np.tile(v, (2, 1)), np.concatenate([speeds, speeds + step])
        )
        over = (left[count:] - left[:count]) / step[:, np.newaxis]
        slopes = np.concatenate([slope[:count], over[:, :, np.newaxis]], axis=2)
        return left[:count], slopes * self.scale

    def tangents(self, points: Values) -> Values:
        """Return unit vectors along branches, with a determinant of one sign."""
        slopes = self.equations(points)[1]
        along = np.linalg.svd(slopes)[2][:, -1]
        both = np.concatenate([slopes, along[:, np.newaxis]], axis=1)
        return np.asarray(along * np.sign(np.linalg.det(both))[:, np.newaxis])

    def corrected(self, guess: Values, along: Values) -> Values:
        """Return the points of branches across directions from guesses; NaN without one."""
        point, found = guess.copy(), np.full_like(guess, np.nan)
        before = np.full(len(guess), np.inf)
        active = np.arange(len(guess))
        for _ in range(_STEPS):
            active = active[point[active, -1] > 0.0]
            if not active.size:
                break
            left, slopes = self.equations(point[active])
            matrix = np.concatenate([slopes, along[active, np.newaxis]], axis=1)
            aside = (along[active] * (point[active] - guess[active])).sum(axis=1)
            regular = np.abs(np.linalg.det(matrix)) > 0.0
            active, rest = active[regular], np.column_stack([left, aside])[regular]
            step = np.linalg.solve(matrix[regular], rest[:, :, np.newaxis])[:, :, 0]
            point[active] -= step
            size = np.abs(step).max(axis=1)
            solved = (size <= _SOLVED) | (
                (before[active] <= _ROUNDED) & (size > 0.5 * before[active])
            )
            found[active[solved]] = point[active[solved]]
            before[active] = size
            active = active[~solved]
        return found

    def between(self, first: Values, last: Values, part: float) -> Values:
        """Return points at a part of the way between two points each of a branch, where found."""
        guess, along = (1.0 - part) * first + part * last, last - first
        found = self.corrected(guess, along / np.linalg.norm(along, axis=1, keepdims=True))
        return np.where(np.isnan(found), guess, found)


@dataclass(frozen=True, slots=True)
class Piece:
    """A short part of a branch, between two of its points."""

    curve: Curve
    ends: tuple[Values, Values]

    def at(self, part: float) -> Values:
        """Return the point at a part of the way: across the line between the ends."""
        first, last = self.ends
        return np.asarray(self.curve.between(first[np.newaxis], last[np.newaxis], part)[0])

    def where(self, function: Callable[[Values], float]) -> float:
        """Return the part of the way at which a function of the point vanishes."""

        def along(part: float) -> float:
            return function(self.at(part))

        ends = along(0.0), along(1.0)
        if ends[0] * ends[1] > 0.0:  # it vanishes at an end, but for rounding
            return float(abs(ends[1]) < abs(ends[0]))
        return float(brentq(along, 0.0, 1.0, xtol=ROUNDING, rtol=4.0 * ROUNDING, maxiter=200))


def plain_pieces(
    curve: Curve, pieces: Sequence[Piece], functions: Callable[[Values], Values]
) -> tuple[list[Piece], Values]:
    """Return pieces at whose ends the signs of functions show how often they vanish: 0 or 1 times.

    `functions` gives values at points, shape (point, function). Pieces are halved where the value
    in the middle, compared with the mean of those at the ends, shows that one may vanish twice.

    Returns
    -------
    pieces : list of Piece
        The pieces, or halves of them.
    values : ndarray, shape (piece, 2, function)
        Values at their ends.
    """
    ends = np.array([each.ends for each in pieces])
    places, back = np.unique(ends.reshape(-1, ends.shape[2]), axis=0, return_inverse=True)
    values = functions(places)[back.ravel()].reshape(*ends.shape[:2], -1)
    plain: list[tuple[Values, Values]] = []
    for _ in range(_HALVINGS):
        middles = curve.between(ends[:, 0], ends[:, 1], 0.5)
        here = functions(middles)
        first, last = values[:, 0], values[:, 1]
        bend = np.abs(here - 0.5 * (first + last))
        least = np.minimum(np.abs(first), np.abs(last))
        twice = np.where(first * last > 0.0, least <= 2.0 * bend, 4.0 * bend > np.abs(last - first))
        split = twice.any(axis=1)
        plain.append((ends[~split], values[~split]))
        halves = [(ends[split, 0], middles[split]), (middles[split], ends[split, 1])]
        of_halves = [(first[split], here[split]), (here[split], last[split])]
        ends = np.concatenate([np.stack(each, axis=1) for each in halves])
        values = np.concatenate([np.stack(each, axis=1) for each in of_halves])
        if not len(ends):
            break
    ends = np.concatenate([*(each for each, _ in plain), ends])
    values = np.concatenate([*(each for _, each in plain), values])
    return [Piece(curve, (first, last)) for first, last in ends], values


class Branches:
    """All branches of a set of contacts between the first and the last of some speeds.

    Ends of rubs are (number of the speed, number of the rub, direction); `open` are those that lead
    nowhere yet. `pieces` do not overlap and have no fold inside. At `folds` the speed turns, and at
    `edges` a contact opens.
    """

    def __init__(self, problem: RubProblem, touching: Touching, speeds: Values) -> None:
        roots = problem.roots(touching, speeds)
        largest = np.concatenate(roots).max(axis=0, initial=0.0)
        largest[largest == 0.0] = 1.0
        self.curve = Curve(problem, touching, np.append(largest, speeds[-1] - speeds[0]))
        self.speeds = speeds / self.curve.scale[-1]
        self.points = [
            np.column_stack([each, np.full(len(each), speed)]) / self.curve.scale
            for each, speed in zip(roots, speeds.tolist(), strict=True)
        ]
        last = speeds.size - 1
        self.open = dict.fromkeys(
            (i, a, side) for i in range(speeds.size) for a in range(len(roots[i]))
            for side in (1, -1) if 0 <= i + side <= last
        )  # fmt: skip
        self.pieces: list[Piece] = []
        self.folds: list[Values] = []
        self.edges: list[Values] = []
        self._link()
        while self.open:
            (number, root, side), _ = self.open.popitem()
            self._follow(self.points[number][root], -1, float(side))

    def add_from(self, touched: Values) -> None:
        """Add the branch from where one of the contacts is just touched, its unknown 0."""
        start = touched / self.curve.scale
        opened = int(np.argmin(start[:-1]))
        start[opened] = TOUCHED
        (point,) = self.curve.corrected(start[np.newaxis], np.eye(start.size)[[opened]])
        if np.isnan(point).any() or any(np.abs(point - each).max() < _SAME for each in self.edges):
            return
        self.edges.append(point)
        self._follow(point, opened, 1.0)

    def _link(self) -> None:
        """Link rubs at neighbouring speeds."""
        places = np.cumsum([len(each) for each in self.points])[:-1]
        along = np.split(self.curve.tangents(np.concatenate(self.points)), places)
        for i, (both, tangents) in enumerate(zip(pairwise(self.points), pairwise(along),
                                                 strict=True)):  # fmt: skip
            for a, b in np.argwhere(_linked(both, tangents)).tolist():
                self.pieces.append(Piece(self.curve, (both[0][a], both[1][b])))
                del self.open[i, a, 1], self.open[i + 1, b, -1]

    def _follow(self, point: Values, coordinate: int, side: float) -> None:
        """Follow a branch, along which a coordinate first grows or falls, as far as it is new."""
        along = self._tangent(point)
        sense = float(np.copysign(1.0, side * along[coordinate]))
        along, step = sense * along, _FIRST
        for _ in range(_MOST):
            new = self._next(point, along, step)
            turned = along if new is None else sense * self._tangent(new)
            if new is None or turned @ along < _TURN:
                step *= 0.5
                if step < _SHORTEST:
                    return
                continue
            step = min(_GROWTH * step, _LONGEST)
            piece = self._in_contact(Piece(self.curve, (point, new)))
            opens, fold = piece.ends[1] is not new, None
            if opens:
                turned = sense * self._tangent(piece.ends[1])
            if along[-1] * turned[-1] < 0.0:
                piece, fold, new = self._to_fold(piece)
            number, piece = self._to_grid(piece)
            self.pieces.append(piece)
            if number is not None:
                new = piece.ends[1]
            elif fold is not None:
                self.folds.append(fold)
            elif opens:
                self.edges.append(piece.ends[1])
                return
            if number is not None or fold is not None:
                turned = sense * self._tangent(new)
            if number is not None and not self._leaves(number, new, int(np.sign(turned[-1]))):
                return
            point, along = new, turned

    def _tangent(self, point: Values) -> Values:
        """Return the unit vector along a branch at one point."""
        return np.asarray(self.curve.tangents(point[np.newaxis])[0])

    def _next(self, point: Values, along: Values, step: float) -> Values | None:
        """Return the next point of a branch; None where the step is too long."""
        guess = point + step * along
        (new,) = self.curve.corrected(guess[np.newaxis], along[np.newaxis])
        size = np.maximum(np.abs(point[:-1]), _OF_LARGEST)
        near = np.abs(new - guess).max() <= _ASIDE * step
        return new if near and (np.abs(new - point)[:-1] <= _CHANGE * size).all() else None

    def _in_contact(self, piece: Piece) -> Piece:
        """Return a piece as far as all contacts touch."""
        opened = np.flatnonzero(piece.ends[1][:-1] < TOUCHED)
        if not opened.size:
            return piece

        def deeper(number: int) -> Callable[[Values], float]:
            return lambda point: float(point[number]) - TOUCHED

        part = min(piece.where(deeper(number)) for number in opened.tolist())
        return Piece(self.curve, (piece.ends[0], piece.at(part)))

    def _to_fold(self, piece: Piece) -> tuple[Piece, Values, Values]:
        """Return a piece as far as just before its fold, the fold, and the point just behind it."""
        part = piece.where(lambda point: float(self._tangent(point)[-1]))
        beside = float(np.clip(part, 2.0 * _BESIDE, 1.0 - 2.0 * _BESIDE))
        before = Piece(self.curve, (piece.ends[0], piece.at(beside - _BESIDE)))
        return before, piece.at(part), piece.at(beside + _BESIDE)

    def _to_grid(self, piece: Piece) -> tuple[int | None, Piece]:
        """Return the number of the first speed of the grid on a piece, and it as far as there."""
        first, last = piece.ends
        side = np.sign(last[-1] - first[-1])
        ahead = side * (self.speeds - first[-1])
        rounded = _SOLVED * self.speeds[-1]
        met = np.flatnonzero((ahead > rounded) & (ahead <= side * (last - first)[-1] + rounded))
        if not met.size:
            return None, piece
        number = int(met[np.argmin(ahead[met])])
        part = piece.where(lambda point: float(point[-1] - self.speeds[number]))
        return number, Piece(self.curve, (first, piece.at(part)))

    def _leaves(self, number: int, point: Values, side: int) -> bool:
        """Return whether a branch that meets a speed of the grid leads on to what is not known."""
        apart = np.abs(self.points[number] - point).max(axis=1)
        if not apart.size or apart.min() > _SAME:  # a rub that the grid has lost
            return bool(0 < number < self.speeds.size - 1)
        root = int(np.argmin(apart))
        self.open.pop((number, root, -side), None)
        if (number, root, side) in self.open:
            del self.open[number, root, side]
            return True
        return False


def _linked(points: tuple[Values, Values], along: tuple[Values, Values]) -> Flags:
    """Return which rubs at two neighbouring speeds are surely one branch, shape (rub, rub)."""
    (before, behind), (first, last) = points, along
    width = behind[0, -1] - before[0, -1] if len(before) and len(behind) else 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead = before + width * first / first[:, -1:]
        back = behind - width * last / last[:, -1:]
    v, w = before[:, np.newaxis], behind[np.newaxis]
    errors = np.maximum(np.abs(ahead[:, np.newaxis] - w), np.abs(back[np.newaxis] - v))
    near = errors <= _OF_DISTANCE * np.abs(w - v) + _OF_SIZE * np.minimum(v, w)
    error = errors.max(axis=2, initial=0.0)
    alone = np.minimum(_nearest(before)[:, np.newaxis], _nearest(behind)[np.newaxis])
    linked = near.all(axis=2) & (error <= _OF_DISTANCE * alone)
    linked &= first[:, np.newaxis, -1] * last[np.newaxis, :, -1] > 0.0
    once = (linked.sum(axis=0, keepdims=True) == 1) & (linked.sum(axis=1, keepdims=True) == 1)
    return np.asarray(linked & once)


def _nearest(points: Values) -> Values:
    """Return the distance of each point from the nearest other one."""
    apart = np.abs(points[:, np.newaxis] - points).max(axis=2, initial=0.0)
    return np.asarray((apart + np.diag(np.full(len(points), np.inf))).min(axis=1, initial=np.inf))
