"""Points of the response curve by polynomials: folds, Hopf points, tips, speeds at an amplitude.

A whirl that slips forwards obeys, with ``f = f(A)`` and ``g = kappa A + f``,

    P = (A**2 - 1) w**4 + A (4 zeta**2 A - 2 g) w**2 + 4 mu zeta A f w + g**2 + mu**2 f**2 = 0

at the speed w. Without friction it is a quadratic in w**2; friction adds an odd power, and speeds
are roots of a quartic. By Descartes' rule of signs there is one speed for ``A < 1``, and two or
none for ``A > 1``: the two flanks. A special point of the curve is also a root of a second
polynomial in w:

- a fold, of the determinant D of `stability_determinant`, times A;
- a Hopf point, of Hurwitz' determinant ``a3 a2 a1 - a1**2 - a3**2 a0`` of the eigenvalues, where
  two of them are ``+- i Omega`` if ``Omega**2 = a1/a3`` is positive [2]_;
- a tip, where the flanks meet, of ``dP/dw``.

With ``K = kappa + f'(A)``, ``S = kappa + f(A)/A``, ``m = 2 zeta + c f(A)`` and ``q = w**2`` the
eigenvalues of a whirl without friction are the roots of ``L**4 + a3 L**3 + a2 L**2 + a1 L + a0``,

    a3 = m + 2 zeta,                a1 = m S + 2 zeta K + (6 zeta - m) q,
    a2 = K + S + 2 zeta m + 2 q,    a0 = (K - q)(S - q) + 4 zeta**2 q = D.

All coefficients are polynomials in ``u = sqrt(A - delta0)``, or in ``A - delta0`` in a linear
contact. They have a common root where their resultant, Bezout's determinant [1]_, vanishes. Its
roots are isolated in exact arithmetic: see `exact_polynomials`.

References
----------
.. [1] D. A. Cox, J. Little, D. O'Shea, "Using Algebraic Geometry", Springer, 2005, section 3.1.
.. [2] Y. A. Kuznetsov, "Elements of Applied Bifurcation Theory", Springer, 2004, section 5.4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import combinations, pairwise, takewhile
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.contacting_whirls import Rows, bracketed_newton
from rotor_ida.closed_forms.double_double import DoubleDouble
from rotor_ida.closed_forms.exact_polynomials import (
    FINER,
    Polynomial,
    Root,
    constant,
    divided,
    isolated_roots,
    values_at,
)
from rotor_ida.closed_forms.restoring_law import RestoringLaw
from rotor_ida.closed_forms.rotor_columns import RotorColumns

# Coefficients by powers of the speed, the lowest first.
Equation = tuple[Polynomial, ...]
# Relative tolerance of a speed, and of one of which a small frequency follows as a difference.
_SAME, _SAME_FREQUENCY = Fraction(1, 10**17), Fraction(1, 10**80)
# At a root of an equation its terms cancel to less than one part in this many.
_SOLVES = 10**15
# Part of the clearance from which on a fold is no first touch in a linear contact.
AT_TOUCH = 1e-13


class Fold(NamedTuple):
    """Speed and amplitude of a fold [dimensionless]."""

    omega: float
    amplitude: float


class HopfPoint(NamedTuple):
    """Speed and amplitude of a Hopf point, and the frequency of its oscillation [dimensionless]."""

    omega: float
    amplitude: float
    frequency: float


class Tip(NamedTuple):
    """Amplitude and speed at which the two flanks of the resonance meet [dimensionless]."""

    amplitude: float
    omega: float


@dataclass(frozen=True)
class CurveEquations:
    """The polynomials of the whirls of a rotor at all its speeds."""

    zeta: float
    law: RestoringLaw
    contact_damping: float = 0.0

    @cached_property
    def terms(self) -> _Terms:
        """Amplitude and forces as polynomials."""
        u = Polynomial((0, 1))
        one, kappa = constant(1), constant(self.law.shaft_stiffness)
        depth = u * u if self.law.hertz else u
        f = depth * u if self.law.hertz else u
        slope = constant(1.5) * u if self.law.hertz else one
        A = constant(self.law.delta0) + depth
        return _Terms(A, f, slope, f + kappa * A, slope + kappa)

    @property
    def curve(self) -> Equation:
        """P, by powers of the speed."""
        A, f, _, g, _ = self.terms
        zeta, mu = Fraction(self.zeta), Fraction(self.law.friction)
        return (
            g * g + constant(mu * mu) * f * f,
            constant(4 * mu * zeta) * A * f,
            A * (constant(4 * zeta * zeta) * A - g - g),
            constant(0),
            A * A - constant(1),
        )

    @property
    def fold(self) -> Equation:
        """``A D``, by powers of the speed."""
        A, f, slope, g, K = self.terms
        zeta, mu = Fraction(self.zeta), Fraction(self.law.friction)
        return (
            g * K + constant(mu * mu) * f * slope,
            constant(2 * zeta * mu) * (f + A * slope),
            constant(4 * zeta * zeta) * A - A * K - g,
            constant(0),
            A,
        )

    @property
    def hopf(self) -> Equation:
        """Hurwitz' determinant times ``A**2``, by powers of the speed."""
        A, f, _, g, K = self.terms
        c, mu = constant(self.contact_damping), constant(self.law.friction)
        two, two_zeta = constant(2), constant(2 * self.zeta)
        m = two_zeta + c * f
        a3 = m + two_zeta
        a2 = (A * K + g + two_zeta * m * A, two * mu * c * f * A, two * A)
        a1 = self.a1
        first = _times((a3,), _times(a2, a1))
        rest = _times((a3 * a3 * A,), self.fold)
        return _less(_less(first, _times(a1, a1)), rest)

    @property
    def a1(self) -> Equation:
        """The coefficient of the eigenvalue's first power, times A, by powers of the speed."""
        A, f, slope, g, K = self.terms
        c, mu = constant(self.contact_damping), constant(self.law.friction)
        two, two_zeta = constant(2), constant(2 * self.zeta)
        m = two_zeta + c * f
        return (
            m * g + two_zeta * A * K + mu * mu * c * f * f,
            mu * (two * (A * slope + f) + two_zeta * c * f * A),
            A * (two_zeta + two_zeta + two_zeta - m),
        )

    @property
    def a3(self) -> Polynomial:
        """The coefficient of the eigenvalue's third power."""
        return constant(4 * self.zeta) + constant(self.contact_damping) * self.terms.f

    def amplitude(self, root: Fraction) -> float:
        """Return the amplitude at a root."""
        return float(Fraction(self.law.delta0) + (root * root if self.law.hertz else root))


class _Terms(NamedTuple):
    A: Polynomial
    f: Polynomial
    slope: Polynomial  # of f by A
    g: Polynomial  # with the shaft
    K: Polynomial  # slope of g by A


def equations_of(rotors: RotorColumns) -> list[CurveEquations]:
    """Return the equations of each of many rotors."""
    rows = zip(rotors.zeta.tolist(), rotors.laws, rotors.contact_damping.tolist(), strict=True)
    return [CurveEquations(*row) for row in rows]


def exact_folds(equations: CurveEquations) -> tuple[Fold, ...]:
    """Return speed and amplitude of every fold, in order of speed; contact damping moves none.

    Examples
    --------
    >>> found = exact_folds(CurveEquations(0.07, RestoringLaw(0.5, friction=0.02)))
    >>> [round(omega, 6) for omega, _ in found]
    [0.073354, 0.080852, 1.337605, 1.712264]
    """
    return _folds_of(replace(equations, contact_damping=0.0))


@lru_cache(maxsize=4096)
def _folds_of(equations: CurveEquations) -> tuple[Fold, ...]:
    found, law = _crossings(equations.curve, equations.fold), equations.law
    least = Fraction(AT_TOUCH) * Fraction(law.delta0)
    if not law.hertz and any(root < least for root, _ in found):
        # with 4 zeta**2 = 1 - delta0**2, but for rounding, it is the first touch
        for to in (0.0, math.inf):
            moved = replace(law, delta0=math.nextafter(law.delta0, to))
            other = replace(equations, zeta=math.nextafter(equations.zeta, to), law=moved)
            if len(_crossings(other.curve, other.fold)) < len(found):
                found = [each for each in found if each[0] > least]
    return tuple(sorted(Fold(float(w), equations.amplitude(root)) for root, w in found))


@lru_cache(maxsize=1024)
def exact_hopf_points(equations: CurveEquations) -> tuple[HopfPoint, ...]:
    """Return speed, amplitude and frequency of every Hopf point, in order of speed."""
    damped, lossy = equations.zeta > 0.0, equations.contact_damping > 0.0
    if not (damped and lossy) and not (equations.law.friction > 0.0 and (damped or lossy)):
        return ()
    found = []
    for root, w in _crossings(equations.curve, equations.hopf, _SAME_FREQUENCY):
        a1 = sum(each(root) * w**power for power, each in enumerate(equations.a1))
        squared = a1 / (equations.a3(root) * equations.terms.A(root))
        if squared > 0:
            found.append(HopfPoint(float(w), equations.amplitude(root), math.sqrt(squared)))
    return tuple(sorted(found))


def exact_tips(equations: CurveEquations) -> list[Tip]:
    """Return amplitude, above 1, and speed where the flanks meet, in order of amplitude.

    There P has a double root: its discriminant in the speed, without the factor ``A**2 - 1``,
    vanishes. On one side of a tip there are two speeds, on the other none. Without damping and
    friction the flanks never meet.
    """
    law = equations.law
    if equations.zeta == 0.0 and law.friction == 0.0:
        return []
    c0, c1, c2, _, c4 = equations.curve
    if _vanishes(c1):
        discriminant = c2 * c2 - constant(4) * c4 * c0
    else:
        odd, high = c1 * c1, c4 * c0
        discriminant = (
            c0 * (constant(256) * high * high - constant(128) * high * c2 * c2)
            + c4 * odd * (constant(144) * c2 * c0 - constant(27) * odd)
            + c2 * c2 * c2 * (constant(16) * c2 * c0 - constant(4) * odd)
        )
    begin = max(1 - Fraction(law.delta0), Fraction(0))
    begin = _square_root(begin) if law.hertz else begin
    roots = [root.narrowed(FINER[0])[0] for root in isolated_roots(discriminant.whole)]
    roots = [root for root in roots if root > begin]
    if not roots:
        return []
    exists = []
    for below, above in pairwise([begin, *roots, 2 * roots[-1]]):
        exists.append(bool(isolated_roots(values_at((below + above) / 2, equations.curve))))
    found = []
    for root, (before, after) in zip(roots, pairwise(exists), strict=True):
        if before != after:
            terms = (np.array([float(each(root))]) for each in (c0, c1, c4))
            found.append(Tip(equations.amplitude(root), float(_lowest_speed(*terms)[0])))
    return found


def flanks(A: Values, equations: CurveEquations) -> tuple[Values, Values, npt.NDArray[np.bool_]]:
    """Return the slower and the faster speed at amplitudes above delta0, and whether they exist.

    Up to A = 1 there is one flank, and the faster speed is infinite. Beyond a tip both speeds are
    the one of the minimum of P. ``P/w**2`` is convex in w for ``A > 1``.

    Examples
    --------
    >>> equations = CurveEquations(0.07, RestoringLaw(0.5, friction=0.1))
    >>> slower, faster, exists = flanks(np.array([3.9010286365]), equations)
    >>> round(float(slower[0]), 9), bool(exists[0])
    (1.2, True)
    """
    coefficients = _coefficients(A, equations)
    c0, c1, c2, c4 = (each.high for each in coefficients)
    above = A > 1.0
    lowest = np.where(above, _lowest_speed(c0, c1, np.where(above, c4, 1.0)), 0.0)
    square = c4 == 0.0  # at A = 1 the term with w**4 is missing
    size = np.where(square, np.maximum(-c2, 0.0), np.abs(c4))
    with np.errstate(divide="ignore", invalid="ignore"):
        second, third, fourth = np.abs(c2) / size, c1 / size, np.sqrt(c0 / size)
    roots = np.sqrt(second), np.cbrt(third), np.sqrt(fourth)
    far = 2.0 * np.max(np.where(square, (np.zeros_like(A), third, fourth), roots), axis=0)
    held = above & (_value(lowest, coefficients)[0] <= 0.0)
    exists = held | (~above & np.isfinite(far))

    def between(low: Values, high: Values, rising: bool) -> Values:
        rows = np.nonzero(exists & np.isfinite(low) & np.isfinite(high) & (low < high))[0]
        chosen = tuple(each[rows] for each in coefficients)

        def evaluate(w: Values, picked: Rows) -> tuple[Values, Values]:
            return _value(w, tuple(each[picked] for each in chosen))

        found = np.array(high if not rising else low)
        direction = np.full(rows.size, rising)
        found[rows] = bracketed_newton(evaluate, low[rows], high[rows], direction)
        return found

    slower = between(np.zeros_like(A), np.where(above, lowest, far), rising=False)
    faster = between(lowest, np.where(above, far, np.inf), rising=True)
    return slower, np.where(above, faster, np.inf), exists


def _coefficients(A: Values, equations: CurveEquations) -> tuple[DoubleDouble, ...]:
    """Return the coefficients of P at amplitudes, of powers 0, 1, 2 and 4, with 32 digits."""
    law = equations.law
    zeta, kappa, mu, d, one, four = (
        DoubleDouble.of(0.0 * A + each)
        for each in (equations.zeta, law.shaft_stiffness, law.friction, law.delta0, 1.0, 4.0)
    )
    amplitude = DoubleDouble.of(A)
    f = depth = amplitude - d
    if law.hertz:
        root = np.sqrt(np.maximum(depth.high, 0.0))
        rest = (depth - DoubleDouble.of(root) * DoubleDouble.of(root)).high
        correction = np.divide(rest, 2.0 * root, out=np.zeros_like(A), where=root > 0.0)
        f = depth * (DoubleDouble.of(root) + DoubleDouble.of(correction))
    g = f + kappa * amplitude
    return (
        g * g + mu * mu * f * f,
        four * mu * zeta * amplitude * f,
        amplitude * (four * zeta * zeta * amplitude - g - g),
        amplitude * amplitude - one,
    )


def _value(w: Values, coefficients: tuple[DoubleDouble, ...]) -> tuple[Values, Values]:
    """Return P with 32 digits and its slope by the speed; NaN beyond the range of doubles."""
    c0, c1, c2, c4 = coefficients
    with np.errstate(over="ignore", invalid="ignore"):
        speed = DoubleDouble.of(w)
        square = speed * speed
        value = (c4 * square + c2) * square + (c1 * speed + c0)
        slope = (4.0 * c4.high * w * w + 2.0 * c2.high) * w + c1.high
    return value.high, slope


def _lowest_speed(c0: Values, c1: Values, c4: Values) -> Values:
    """Return the speed at which ``P/w**2`` is least, ``2 c4 w**4 = c1 w + 2 c0``, for ``A > 1``."""
    w = np.maximum(np.cbrt(c1 / c4), np.sqrt(np.sqrt(2.0 * c0 / c4)))
    for _ in range(60):  # down from above on a convex function
        slope = 8.0 * c4 * w**3 - c1
        step = np.divide(2.0 * c4 * w**4 - c1 * w - 2.0 * c0, slope, out=0.0 * w, where=slope > 0.0)
        w = w - step
        if (step <= 2.0**-52 * w).all():
            break
    return w


def _times(one: Equation, two: Equation) -> Equation:
    found = [constant(0)] * (len(one) + len(two) - 1)
    for i, a in enumerate(one):
        for j, b in enumerate(two):
            found[i + j] = found[i + j] + a * b
    return tuple(found)


def _less(one: Equation, two: Equation) -> Equation:
    size = max(len(one), len(two))
    one += (constant(0),) * (size - len(one))
    two += (constant(0),) * (size - len(two))
    return tuple(a - b for a, b in zip(one, two, strict=True))


def _crossings(
    first: Equation, second: Equation, same: Fraction = _SAME
) -> list[tuple[Fraction, Fraction]]:
    """Return root and speed, both positive, at which both equations hold."""
    even = all(_vanishes(each) for equation in (first, second) for each in equation[1::2])
    if even:  # in the square of the speed: otherwise every root would be double
        first, second = first[::2], second[::2]
    eliminant = _resultant(first, second)
    for _ in takewhile(_vanishes, reversed(second)):  # there both are 0 at infinite speed
        eliminant = eliminant // first[-1]
    found = []
    for root in isolated_roots(eliminant.whole):
        place, speeds = _speeds_at(root, first, second, same)
        found += [(place, _square_root(w) if even else w) for w in speeds if w > 0]
    return found


def _square_root(value: Fraction) -> Fraction:
    """Return a square root to about 300 bits."""
    above, below = value.numerator, value.denominator
    places = 300 - (above.bit_length() - below.bit_length()) // 2
    wide = (above << 2 * places) // below if places > 0 else (above >> -2 * places) // below
    return Fraction(math.isqrt(wide)) / Fraction(2) ** places


def _speeds_at(
    root: Root, first: Equation, second: Equation, same: Fraction
) -> tuple[Fraction, list[Fraction]]:
    """Return a sufficiently narrowed root, and the roots that both equations have there.

    Nearly always it is one, the limit of Euclid's algorithm from both sides. Several have no such
    limit, or a false one: then the roots of the first that also solve the second are taken.
    """
    for power in FINER:
        low, high = root.narrowed(power)
        one, two = values_at(low, first), values_at(low, second)
        w, other = _common(one, two), _common(values_at(high, first), values_at(high, second))
        if (w is not None and other is not None and abs(w - other) <= same * abs(other)
                and _solves(w, one) and _solves(w, two)):  # fmt: skip
            return low, [w]
    speeds = [each.narrowed(FINER[2])[0] for each in isolated_roots(one)]
    return low, [w for w in speeds if _solves(w, two)]


def _solves(w: Fraction, coefficients: list[int]) -> bool:
    degree, above, below = len(coefficients) - 1, w.numerator, w.denominator
    terms: list[int] = [
        each * above**power * below ** (degree - power) for power, each in enumerate(coefficients)
    ]
    return abs(sum(terms)) * _SOLVES <= sum(map(abs, terms))


def _vanishes(polynomial: Polynomial) -> bool:
    return not any(polynomial.whole)


def _resultant(first: Equation, second: Equation) -> Polynomial:
    """Return the determinant of Bezout's matrix of two equations of the same degree."""
    size = len(first) - 1

    def pair(i: int, j: int) -> Polynomial:
        return first[i] * second[j] - first[j] * second[i]

    pairs = {(i, j): pair(i, j) for i in range(size + 1) for j in range(i)}
    rows = [[constant(0)] * size for _ in range(size)]
    for i in range(size):
        for j in range(i, size):
            total = constant(0)
            for k in range(i + 1):
                total = total + pairs[j + k + 1, i - k] if j + k < size else total
            rows[i][j] = rows[j][i] = total
    return _determinant(rows)


def _determinant(rows: list[list[Polynomial]]) -> Polynomial:
    """Return the determinant of a matrix of size 2 or 4, by its minors of size 2."""
    if len(rows) == 2:
        (a, b), (c, d) = rows
        return a * d - b * c
    total = constant(0)
    for i, j in combinations(range(4), 2):
        upper = rows[0][i] * rows[1][j] - rows[0][j] * rows[1][i]
        k, m = (each for each in range(4) if each not in (i, j))
        lower = rows[2][k] * rows[3][m] - rows[2][m] * rows[3][k]
        product = upper * lower
        total = total - product if (i + j) % 2 == 0 else total + product
    return total


def _common(one: list[int], two: list[int]) -> Fraction | None:
    """Return the root that two polynomials have in common, by Euclid's algorithm."""
    one, two = _trimmed(one), _trimmed(two)
    if len(one) < len(two):
        one, two = two, one
    while len(two) > 2:
        one, two = two, divided(one, two)[1]
    return Fraction(-two[0], two[1]) if len(two) == 2 else None


def _trimmed(coefficients: list[int]) -> list[int]:
    found = list(coefficients)
    while found and found[-1] == 0:
        found.pop()
    return found
