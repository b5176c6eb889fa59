"""All synchronous rubs of an axisymmetric rotor system at two contacts at once, with none lost.

With lengths over the clearances, ``A = 1 + a(v)`` and the normal force ``b(v)`` of each contact,
``a = v**2, b = v**3`` with the exponent 3/2 and ``a = b = v`` with 1, and g the displacements by
contact forces at an indentation of one clearance, the directions E of both contacts obey

    (A_1 + g_11 b_1) E_1 + g_12 b_2 E_2 = U_1,    g_21 b_1 E_1 + (A_2 + g_22 b_2) E_2 = U_2.

Their sizes are 1 where, with the determinant D of these equations,

    |D|**2 = |(A_2 + g_22 b_2) U_1 - g_12 b_2 U_2|**2 = |(A_1 + g_11 b_1) U_2 - g_21 b_1 U_1|**2,

two polynomials in v_1 and v_2 of degree 6 (or 2) in each. Their common roots lie in a box that is
known beforehand. Boxes are halved until a polynomial has no root in them, as all its coefficients
in Bernstein's basis have one sign, or both have at most one common root there, as their slopes are
those of nearly independent functions; Newton's method then finds it [1]_.

References
----------
.. [1] T. W. Sederberg, "Algorithm for algebraic curve intersection", Computer-Aided Design 21,
   1989; B. Mourrain and J.-P. Pavone, "Subdivision methods for solving polynomial equations",
   Journal of Symbolic Computation 44, 2009.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb

import numpy as np

from rotor_ida.arrays import ROUNDING, ComplexValues, Flags, Values
from rotor_ida.closed_forms.contacting_whirls import Rows

# Rounding of a coefficient in Bernstein's basis, in parts of the sum of sizes of its terms.
_ROUNDED = 64.0 * ROUNDING
# Values in parts of their rounding that cannot be told from 0.
_NOTHING = 8.0
_MOST_STEPS = 30
# A determinant this small beside its two products has no digits.
_REGULAR = 64.0 * ROUNDING
# A bound of v beyond this is not used, and contacts with a smaller determinant move together.
_FARTHEST, _TOGETHER = 1e12, 1e-9
# Newton's steps on the equations of the directions, which are rounded less than the polynomials.
_POLISHING, _NEAR = 3, 1e-6
# Distance of a converged root from its box, in parts of its width; relative distance of two roots
# that are one, and of the parts of a double root.
_OUTSIDE, _SAME, _CLUSTER = 1e-6, 1e-9, 1e-4


@dataclass(frozen=True, slots=True)
class Pairs:
    """Many pairs of contacts of the same two exponents.

    Parameters
    ----------
    free : ndarray of complex, shape (n, 2)
        Displacements U without contact, over the clearances.
    effect : ndarray of complex, shape (n, 2, 2)
        The numbers g: displacements (rows) by contact forces at an indentation of a clearance.
    hertz : (bool, bool)
        Whether the exponents are 3/2, else 1.
    """

    free: ComplexValues
    effect: ComplexValues
    hertz: tuple[bool, bool]


@dataclass(frozen=True, slots=True)
class _Boxes:
    """Boxes of v, each of one pair: its lower corner and its widths, shape (box, 2)."""

    pair: Rows
    low: Values
    width: Values

    def __getitem__(self, chosen: Flags) -> _Boxes:
        return _Boxes(self.pair[chosen], self.low[chosen], self.width[chosen])


def double_rubs(pairs: Pairs) -> tuple[Rows, Values, int]:
    """Return all rubs at both contacts of many pairs.

    Returns
    -------
    rows, depths : ndarray, shapes (k,) and (k, 2)
        Which pair each rub is of, and its indentations over the clearances.
    boxes : int
        How many boxes were examined.

    Examples
    --------
    >>> free, effect = np.array([[2.0, 3.0]]), np.array([[[3.0, 0.0], [0.0, 1.0]]])
    >>> rows, depths, _ = double_rubs(Pairs(free + 0j, effect + 0j, (False, False)))
    >>> rows, depths  # 1 + 4 d = 2 and 1 + 2 d = 3
    (array([0]), array([[0.25, 1.  ]]))
    """
    polynomials = _polynomials(pairs)
    todo = _first_boxes(pairs)
    roots, examined = [], 0
    while todo.pair.size:
        examined += todo.pair.size
        bernstein, rounding = _in_boxes(polynomials, todo)
        possible = _may_vanish(bernstein, rounding)
        todo, bernstein, rounding = todo[possible], bernstein[possible], rounding[possible]
        at_most_one, possible = _preconditioned(bernstein, rounding)
        found, inside = _newton(polynomials, todo, at_most_one & possible)
        # a box in which all is rounding is a part of a double root
        nothing = (np.abs(bernstein).max(axis=(2, 3)) <= _NOTHING * rounding).all(axis=1)
        nothing &= possible & ~inside
        roots.append((todo.pair[inside], found[inside]))
        roots.append(_clusters(todo[nothing]))
        left = possible & ~inside & ~nothing
        todo = _halved(todo[left], bernstein[left])
    rows = np.concatenate([np.zeros(0, int), *(row for row, _ in roots)])
    v = np.concatenate([np.zeros((0, 2)), *(each for _, each in roots)])
    rows, v = _distinct(rows, _polished(pairs, rows, v))
    return rows, np.where(pairs.hertz, v * v, v), examined


def _polished(pairs: Pairs, rows: Rows, v: Values) -> Values:
    """Return roots after steps of Newton's method on ``|E|**2 = 1``."""
    for _ in range(_POLISHING):
        left, slope = balance(pairs.free[rows], pairs.effect[rows], pairs.hertz, v)
        try:
            step = np.linalg.solve(slope, left[:, :, np.newaxis])[:, :, 0]
        except np.linalg.LinAlgError:  # at a double root
            step = (np.linalg.pinv(slope) @ left[:, :, np.newaxis])[:, :, 0]
        # near a double root a step would lead far away
        near = (np.abs(step) < _NEAR * v).all(axis=1, keepdims=True)
        v = np.where(near, v - step, v)
    return v


def balance(
    free: ComplexValues, effect: ComplexValues, hertz: Sequence[bool], v: Values
) -> tuple[Values, Values]:
    """Return ``|E|**2 - 1`` of any number of contacts, and its slopes by v.

    Parameters
    ----------
    free, effect, hertz
        As in `Pairs`, of k contacts.
    v : ndarray, shape (n, k)
        The unknowns.

    Returns
    -------
    left, slope : ndarray, shapes (n, k) and (n, k, k)
        What is 0 in a rub, and its derivatives.
    """
    one = np.eye(v.shape[1])
    amplitude, force = 1.0 + np.where(hertz, v * v, v), np.where(hertz, v**3, v)
    rise, push = np.where(hertz, 2.0 * v, 1.0), np.where(hertz, 3.0 * v * v, 1.0)
    matrix = one * amplitude[:, np.newaxis] + effect * force[:, np.newaxis]
    turned = np.linalg.solve(matrix, free[:, :, np.newaxis])[:, :, 0]
    change = (one * rise[:, np.newaxis] + effect * push[:, np.newaxis]) * turned[:, np.newaxis]
    change = -np.linalg.solve(matrix, change)
    slope = 2.0 * (turned.conj()[:, :, np.newaxis] * change).real
    return (np.abs(turned) - 1.0) * (np.abs(turned) + 1.0), slope


def _factors(pairs: Pairs) -> list[tuple[ComplexValues, Values]]:
    """Return ``A + g b`` and b of each contact by powers of v, shapes (n, degree + 1)."""
    found = []
    for j, hertz in enumerate(pairs.hertz):
        own = pairs.effect[:, j, j]
        one, none = np.ones_like(own), np.zeros_like(own)
        if hertz:
            found.append((np.stack([one, none, one, own], 1), np.array([0.0, 0.0, 0.0, 1.0])))
        else:
            found.append((np.stack([one, 1.0 + own], 1), np.array([0.0, 1.0])))
    return found


def _polynomials(pairs: Pairs) -> Values:
    """Return both polynomials by powers of v_1 and v_2, shape (n, 2, degree + 1, degree + 1)."""
    (first, b_1), (second, b_2) = _factors(pairs)
    g, free = pairs.effect, pairs.free
    cross = (g[:, 0, 1] * g[:, 1, 0])[:, np.newaxis, np.newaxis]
    determinant = first[:, :, np.newaxis] * second[:, np.newaxis] - cross * np.outer(b_1, b_2)
    above_1 = second * free[:, :1] - (g[:, 0, 1] * free[:, 1])[:, np.newaxis] * b_2
    above_2 = first * free[:, 1:] - (g[:, 1, 0] * free[:, 0])[:, np.newaxis] * b_1
    square = _square(determinant)
    both = np.stack([square, square], axis=1)
    both[:, 0, 0] -= _square(above_1[:, np.newaxis])[:, 0]
    both[:, 1, :, 0] -= _square(above_2[:, np.newaxis])[:, 0]
    return both


def _square(factor: ComplexValues) -> Values:
    """Return ``|p|**2`` of polynomials in two variables, shape (n, i, j)."""
    count, rows, columns = factor.shape
    found = np.zeros((count, 2 * rows - 1, 2 * columns - 1))
    for i in range(rows):
        for j in range(columns):
            term = factor[:, i : i + 1, j : j + 1]
            found[:, i : i + rows, j : j + columns] += (term.conj() * factor).real
    return found


def _first_boxes(pairs: Pairs) -> _Boxes:
    """Return boxes that hold all roots.

    With ``x = b(v) E`` both equations are ``(g + [linear]) x = U - (1 + [Hertz] v**2) E``, so that
    ``b(v) <= sum |(g + [linear])**-1| (|U| + 1 + [Hertz] v**2)``.
    """
    hertz = np.array(pairs.hertz)
    flexible = pairs.effect + np.diag(np.where(hertz, 0.0, 1.0))
    with np.errstate(all="ignore"):
        determinant = flexible[:, 0, 0] * flexible[:, 1, 1] - flexible[:, 0, 1] * flexible[:, 1, 0]
        adjugate = np.abs(flexible[:, ::-1, ::-1].transpose(0, 2, 1))
        adjugate[:, 0, 1], adjugate[:, 1, 0] = np.abs(flexible[:, 0, 1]), np.abs(flexible[:, 1, 0])
        stiff = adjugate / np.abs(determinant)[:, np.newaxis, np.newaxis]
        constant = np.einsum("njk,nk->nj", stiff, np.abs(pairs.free) + 1.0)
        bound = constant
        if hertz.any():
            most = constant[:, hertz].max(axis=1)
            slope = stiff[:, hertz][:, :, hertz].sum(axis=2).max(axis=1)
            largest = slope + np.cbrt(most)
            bound = np.where(hertz, largest[:, np.newaxis], constant)
            for _ in range(40):
                force = constant + np.einsum("njk,nk->nj", stiff, np.where(hertz, bound**2, 0.0))
                bound = np.where(hertz, np.minimum(bound, np.cbrt(force)), force)
            alone = 1.0 / np.abs(pairs.effect[:, [0, 1], [0, 1]])
            if hertz.all():  # of two contacts that move together, each bounds itself
                size = np.abs(pairs.effect[:, 0, 0] * pairs.effect[:, 1, 1])
                together = np.abs(determinant) < _TOGETHER * size
                own = alone + np.cbrt(alone * (np.abs(pairs.free) + 1.0))
                bound = np.where(together[:, np.newaxis], own, bound)
    width = np.where(bound < _FARTHEST, 1.000001 * bound, _FARTHEST)
    return _Boxes(np.arange(len(width)), np.zeros_like(width), width)


def _in_boxes(polynomials: Values, boxes: _Boxes) -> tuple[Values, Values]:
    """Return the coefficients in Bernstein's basis on boxes, and how far they are rounded."""
    chosen = polynomials[boxes.pair]
    left, right = (
        _change_of_basis(chosen.shape[axis + 2] - 1, boxes.low[:, axis], boxes.width[:, axis])
        for axis in (0, 1)
    )
    bernstein = left[:, np.newaxis] @ chosen @ right[:, np.newaxis].transpose(0, 1, 3, 2)
    corner = boxes.low + boxes.width
    powers = [corner[:, axis, np.newaxis] ** np.arange(chosen.shape[axis + 2]) for axis in (0, 1)]
    sizes = np.einsum("bfij,bi,bj->bf", np.abs(chosen), *powers)
    return bernstein, _ROUNDED * sizes


def _change_of_basis(degree: int, low: Values, width: Values) -> Values:
    """Return the matrices from powers of ``low + width t`` to Bernstein's basis in t."""
    found = np.zeros((low.size, degree + 1, degree + 1))
    for power in range(degree + 1):
        for place in range(power + 1):  # t**place of (low + width t)**power
            term = comb(power, place) * low ** (power - place) * width**place
            for row in range(place, degree + 1):
                found[:, row, power] += comb(row, place) / comb(degree, place) * term
    return found


def _may_vanish(bernstein: Values, rounding: Values) -> Flags:
    """Return in which boxes both functions may vanish."""
    low, high = bernstein.min(axis=(2, 3)), bernstein.max(axis=(2, 3))
    return np.asarray(((low <= rounding) & (high >= -rounding)).all(axis=1))


def _preconditioned(bernstein: Values, rounding: Values) -> tuple[Flags, Flags]:
    """Return which boxes hold at most one root, and which may hold any.

    The functions are combined so that in the middle their slopes are those of t_1 and t_2. Where
    each keeps its own slope larger than the other, both vanish at most once.
    """
    middle = np.stack([_slope(bernstein, axis).mean(axis=(2, 3)) for axis in (0, 1)], axis=2)
    straight, across = middle[:, 0, 0] * middle[:, 1, 1], middle[:, 0, 1] * middle[:, 1, 0]
    determinant = straight - across
    regular = np.abs(determinant) > _REGULAR * (np.abs(straight) + np.abs(across))
    inverse = np.zeros_like(middle)
    adjugate = middle[regular][:, ::-1, ::-1].transpose(0, 2, 1) * [[1.0, -1.0], [-1.0, 1.0]]
    inverse[regular] = adjugate / determinant[regular, np.newaxis, np.newaxis]
    combined = np.einsum("bgf,bfij->bgij", inverse, bernstein)
    spread = np.einsum("bgf,bf->bg", np.abs(inverse), rounding)
    possible = _may_vanish(combined, spread) | ~regular
    slopes = [_slope(combined, axis) for axis in (0, 1)]
    margin = 2.0 * bernstein.shape[2] * spread
    sure = regular
    for own in (0, 1):
        least = slopes[own][:, own].min(axis=(1, 2)) - margin[:, own]
        other = np.abs(slopes[1 - own][:, own]).max(axis=(1, 2)) + margin[:, own]
        sure = sure & (least > other)
    return sure, possible


def _slope(bernstein: Values, axis: int) -> Values:
    """Return the slopes along t_1 or t_2 in Bernstein's basis."""
    return np.asarray((bernstein.shape[axis + 2] - 1) * np.diff(bernstein, axis=axis + 2))


def _newton(polynomials: Values, boxes: _Boxes, chosen: Flags) -> tuple[Values, Flags]:
    """Return the roots that Newton's method finds in chosen boxes, and which lie in them."""
    v = boxes.low + 0.5 * boxes.width
    active = np.nonzero(chosen)[0]
    converged = np.zeros(chosen.size, bool)
    for _ in range(_MOST_STEPS):
        if not active.size:
            break
        value, slope, rounding = _values(polynomials[boxes.pair[active]], v[active])
        determinant = np.abs(np.linalg.det(slope))
        regular = np.isfinite(determinant) & (determinant > 0.0)
        active, value, slope = active[regular], value[regular], slope[regular]
        step = np.linalg.solve(slope, value[:, :, np.newaxis])[:, :, 0]
        v[active] -= step
        width = boxes.width[active]
        near = (np.abs(v[active] - boxes.low[active] - 0.5 * width) < width).all(axis=1)
        done = (np.abs(step) <= 8.0 * ROUNDING * np.abs(v[active])).all(axis=1)
        done |= (np.abs(value) <= rounding[regular]).all(axis=1)
        converged[active[near & done]] = True
        active = active[near & ~done]
    inside = (v >= boxes.low - _OUTSIDE * boxes.width).all(axis=1)
    inside &= (v <= boxes.low + (1.0 + _OUTSIDE) * boxes.width).all(axis=1)
    return v, converged & inside


def _values(polynomials: Values, v: Values) -> tuple[Values, Values, Values]:
    """Return values of both polynomials, slopes, shape (n, 2, 2), and rounding of the values."""
    powers, slopes = [], []
    for axis in (0, 1):
        exponents = np.arange(polynomials.shape[axis + 2])
        powers.append(v[:, axis, np.newaxis] ** exponents)
        slopes.append(exponents * v[:, axis, np.newaxis] ** np.maximum(exponents - 1, 0))
    value = np.einsum("nfij,ni,nj->nf", polynomials, *powers)
    slope_1 = np.einsum("nfij,ni,nj->nf", polynomials, slopes[0], powers[1])
    slope_2 = np.einsum("nfij,ni,nj->nf", polynomials, powers[0], slopes[1])
    sizes = np.einsum("nfij,ni,nj->nf", np.abs(polynomials), *(np.abs(each) for each in powers))
    return value, np.stack([slope_1, slope_2], axis=2), _ROUNDED * sizes


def _halved(boxes: _Boxes, bernstein: Values) -> _Boxes:
    """Return the halves of boxes, across the direction in which the functions vary the most."""
    size = np.abs(bernstein).max(axis=(2, 3), initial=np.finfo(float).tiny)
    variation = [np.abs(_slope(bernstein, axis)).max(axis=(2, 3)) / size for axis in (0, 1)]
    axis = np.argmax([each.max(axis=1, initial=0.0) for each in variation], axis=0)
    width = boxes.width.copy()
    every = np.arange(axis.size)
    width[every, axis] *= 0.5
    upper = boxes.low.copy()
    upper[every, axis] += width[every, axis]
    return _Boxes(
        np.concatenate([boxes.pair, boxes.pair]),
        np.concatenate([boxes.low, upper]),
        np.concatenate([width, width]),
    )


def _clusters(boxes: _Boxes) -> tuple[Rows, Values]:
    """Return one point for each cluster of small boxes."""
    return _distinct(boxes.pair, boxes.low + 0.5 * boxes.width, _CLUSTER)


def _distinct(rows: Rows, v: Values, same: float = _SAME) -> tuple[Rows, Values]:
    """Return roots in contact, each once: those on the edge of two boxes are found twice."""
    order = np.lexsort((v[:, 1], v[:, 0], rows))
    rows, v = rows[order], v[order]
    keep: Flags = np.asarray((v > 0.0).all(axis=1))
    for this in range(1, rows.size):
        before = np.nonzero(keep[:this] & (rows[:this] == rows[this]))[0]
        apart = np.abs(v[before] - v[this])
        keep[this] &= not (apart <= same * np.abs(v[this])).all(axis=1).any()
    return rows[keep], v[keep]
