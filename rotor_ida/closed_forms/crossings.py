"""Speeds at which an eigenvalue of a rotor turns with it.

1. *Branches*: over a cell of speeds the eigenvalues at both ends are matched where each meets the
   other, by value and slope. Each branch is then a cubic, with an error measured in the middle.
2. *Cells*: a cell is halved until no cubic leaves doubt, by more than its error, whether its
   imaginary part is the spin speed never or once.
3. *Crossings*: on each branch, by Brent's method.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.linalg import eig
from scipy.optimize import brentq, linear_sum_assignment

from rotor_ida.arrays import ComplexValues, Flags, Values
from rotor_ida.model.assembly import Assembly

# Eigenvalues, and their derivatives by the speed.
Motion: TypeAlias = tuple[ComplexValues, ComplexValues]

# Least number of cells at first, and how often one may be halved.
CELLS, HALVINGS = 16, 16
# Relative error of the change of an eigenvalue over a cell that is accepted, and the number of
# such errors within which two eigenvalues may be confused.
KNOWN, ERRORS = 0.02, 4.0
# A gap below this part of the speed, where it is smallest, is one speed.
TOUCH = 1e-9
# Eigenvalues meet where the product of their left and right vectors, of size 1, is below this.
MEET = 1e-7
# Condition of the right side of a pencil up to which it is inverted.
INVERTIBLE = 1e8
# How far beside a cell, in widths of it, such a place is still sought: that of a neighbour too.
BESIDE = 0.01
# Powers of a cubic, the highest first, by its Bezier points.
POWERS = np.array([[-1, 3, -3, 1], [3, -6, 3, 0], [-3, 3, 0, 0], [1, 0, 0, 0]])


def film_pencil(assembly: Assembly, speed: float) -> tuple[Values, Values]:
    """Return the matrices whose eigenvalues are those of the motions at a spin speed."""
    one, zero = np.eye(assembly.size), np.zeros_like(assembly.mass)
    resisted = assembly.damping_at(speed)
    if assembly.gyroscopic is not None:
        resisted = resisted + speed * assembly.gyroscopic
    left = np.block([[zero, one], [-assembly.stiffness_at(speed), -resisted]])
    return left, np.block([[one, zero], [zero, assembly.mass]])


def pencil_motions(
    left: npt.NDArray[Any], right: npt.NDArray[Any]
) -> tuple[ComplexValues, ComplexValues]:
    """Return the eigenvalues of a pencil and its right vectors, as accurate as their sizes allow.

    The QZ algorithm is accurate to rounding of the largest one. Finite elements have some 1e4 times
    as large as those that count, and balancing respects these; it takes the inverse of the right
    side where that can be formed.
    """
    sizes = np.sqrt(np.abs(np.diag(right)))
    sizes[sizes == 0.0] = 1.0
    if np.linalg.cond(right / np.outer(sizes, sizes)) > INVERTIBLE:
        values, vectors = eig(left, right)
    else:
        values, vectors = np.linalg.eig(np.linalg.solve(right, left))
    return values.astype(complex), vectors.astype(complex)


def film_speeds(assembly: Assembly, low: float, high: float) -> list[float]:
    """Return where the imaginary part of an eigenvalue is the spin speed, in ascending order."""
    size, films = assembly.size, assembly.films

    def at(speed: float) -> Motion:
        left, right = film_pencil(assembly, speed)
        slope = np.zeros_like(left)
        slope[size:, :size] = -films.matrix("stiffness", speed, 1)
        slope[size:, size:] = -films.matrix("damping", speed, 1)
        if assembly.gyroscopic is not None:
            slope[size:, size:] -= assembly.gyroscopic
        try:  # three times as fast
            left, slope = (np.asarray(np.linalg.solve(right, each), float)
                           for each in (left, slope))  # fmt: skip
        except np.linalg.LinAlgError:
            return eigenvalues_and_slopes(left, slope, right)
        return eigenvalues_and_slopes(left, slope)

    return crossing_speeds(at, films.knots, low, high)


def crossing_speeds(
    motion: Callable[[float], Motion], knots: Values, low: float, high: float
) -> list[float]:
    """Return where the imaginary part of an eigenvalue is the speed, in ascending order.

    Parameters
    ----------
    motion : callable
        The eigenvalues at a speed, and their derivatives by it.
    knots : ndarray, shape (n,)
        Speeds at which they may have a kink, in ascending order.
    low, high : float
        The lowest and the highest speed.
    """
    edges = [low, *knots[(knots > low) & (knots < high)].tolist(), high]
    count = -(-CELLS // (len(edges) - 1))
    ends = [np.linspace(*each, count, endpoint=False) for each in pairwise(edges)]
    at = cache(motion)
    found: list[float] = []
    cells = [(*each, HALVINGS) for each in pairwise([*np.concatenate(ends).tolist(), high])][::-1]
    while cells:
        first, last, halvings = cells.pop()
        middle = 0.5 * (first + last)
        branches = _branches(*at(first), *at(last), last - first)
        doubtful, crossing = _judged(branches, at(middle)[0], first, last)
        if doubtful.any() and halvings:
            cells += [(middle, last, halvings - 1), (first, middle, halvings - 1)]
            continue
        found += [_crossing(at, each, first, last) for each in branches[:, crossing].T]
        found += _touches(branches[:, doubtful & ~crossing], first, last)
    return sorted(found)


def eigenvalues_and_slopes(
    left: npt.NDArray[Any], slope: npt.NDArray[Any], right: Values | None = None
) -> Motion:
    """Return the finite eigenvalues of a pencil, and their derivatives by those of its left side.

    The derivative is taken as 0 where two eigenvalues meet.
    """
    values, lefts, rights = eig(left, right, left=True)
    whole = rights if right is None else right @ rights
    with np.errstate(invalid="ignore"):
        change = np.einsum("js,js->s", lefts.conj(), slope @ rights)
        product = np.einsum("js,js->s", lefts.conj(), whole)
        apart = np.abs(product) > MEET * np.linalg.norm(whole, axis=0)
    slopes = np.divide(change, product, out=np.zeros_like(change), where=apart)
    finite = np.isfinite(values)
    return values[finite], slopes[finite]


def _branches(
    before: ComplexValues,
    rises: ComplexValues,
    behind: ComplexValues,
    falls: ComplexValues,
    width: float,
) -> ComplexValues:
    """Return the cubics of all branches by their Bezier points, shape (4, branch)."""
    ahead, back = before + rises * width / 2.0, behind - falls * width / 2.0
    distances = np.abs(ahead[:, np.newaxis] - back)
    rows, columns = linear_sum_assignment(distances)
    before, rises, behind, falls = before[rows], rises[rows], behind[columns], falls[columns]
    third = width / 3.0
    return np.array([before, before + rises * third, behind - falls * third, behind])


def _judged(
    branches: ComplexValues, middles: ComplexValues, first: float, last: float
) -> tuple[Flags, Flags]:
    """Return which branches need smaller cells, and which cross the spin speed."""
    gaps = branches.imag - np.linspace(first, last, 4)[:, np.newaxis]
    expected = _value(branches, 0.5)
    errors = np.abs(expected[:, np.newaxis] - middles).min(axis=1)
    margin = ERRORS * errors
    apart = (gaps > margin).all(axis=0) | (gaps < -margin).all(axis=0)
    steps = np.diff(gaps, axis=0)
    monotone = (steps > 0.0).all(axis=0) | (steps < 0.0).all(axis=0)
    once = monotone & (errors < KNOWN * np.abs(gaps[3] - gaps[0]))
    return ~(apart | once), (gaps[0] > 0.0) != (gaps[3] > 0.0)


def _value(branch: ComplexValues, part: float) -> ComplexValues:
    """Return the cubics of branches at a part of their cell."""
    rest = 1.0 - part
    weights = np.array([rest**3, 3 * rest**2 * part, 3 * rest * part**2, part**3])
    return np.asarray(weights @ branch)


def _crossing(
    at: Callable[[float], Motion],
    branch: ComplexValues,
    first: float,
    last: float,
) -> float:
    """Return where the imaginary part of a branch is the spin speed."""

    def gap(speed: float) -> float:
        expected = _value(branch, (speed - first) / (last - first))
        values = at(speed)[0]
        return float(values[np.argmin(np.abs(values - expected))].imag - speed)

    return float(brentq(gap, first, last, xtol=1e-12 * last))


def _touches(branches: ComplexValues, first: float, last: float) -> Iterator[float]:
    """Yield where branches in the smallest cells touch the spin speed without crossing it."""
    gaps = branches.imag - np.linspace(first, last, 4)[:, np.newaxis]
    for gap in (POWERS @ gaps).T:
        for part in np.roots(np.polyder(gap)).tolist():
            inside = abs(part.imag) < BESIDE and -BESIDE <= part.real <= 1.0 + BESIDE
            if inside and abs(np.polyval(gap, part.real)) < TOUCH * last:
                yield float(first + part.real * (last - first))
