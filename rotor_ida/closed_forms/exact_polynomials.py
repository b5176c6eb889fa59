"""Polynomials with rational coefficients, and their positive roots in exact arithmetic.

Parameters are doubles, so all sums and products of them are fractions. The roots of a polynomial
are isolated by Descartes' rule of signs: none is lost or invented [1]_. The rule separates roots
however near they are, but not those that coincide, so multiple roots are made simple first.

References
----------
.. [1] G. E. Collins, A. G. Akritas, "Polynomial real root isolation using Descartes' rule of
   signs", SYMSAC 1976.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate, pairwise

# Two roots closer than this power of two, relative to the largest possible root, probably coincide:
# then the polynomial is divided by its multiple factors, which would take long for every one.
_DEEPEST = 400
# Roots are narrowed to these relative powers of two, one after the other, until the result is the
# same at both ends: a whirl near amplitude 1 may have nearly any speed.
FINER = (70, 140, 280, 560, 1120)
# Relative tolerance for that.
SAME = Fraction(1, 10**17)


@dataclass(frozen=True, slots=True)
class Polynomial:
    """A polynomial by its coefficients, the lowest first."""

    coefficients: tuple[Fraction | int, ...]

    def __add__(self, other: Polynomial) -> Polynomial:
        """Return the sum."""
        return self._joined(other, 1)

    def __sub__(self, other: Polynomial) -> Polynomial:
        """Return the difference."""
        return self._joined(other, -1)

    def __mul__(self, other: Polynomial) -> Polynomial:
        """Return the product."""
        one, two = self.coefficients, other.coefficients
        found: list[Fraction | int] = [0] * (len(one) + len(two) - 1)
        for i, a in enumerate(one):
            if a:
                for j, b in enumerate(two):
                    found[i + j] += a * b
        return Polynomial(tuple(found))

    def __floordiv__(self, other: Polynomial) -> Polynomial:
        """Return the quotient where nothing is left."""
        rest, divisor = list(self.coefficients), other.coefficients
        found = [Fraction(0)] * (len(rest) - len(divisor) + 1)
        for shift in range(len(found) - 1, -1, -1):
            found[shift] = Fraction(rest[shift + len(divisor) - 1]) / divisor[-1]
            for place, each in enumerate(divisor):
                rest[shift + place] -= found[shift] * each
        return Polynomial(tuple(found))

    def __call__(self, place: Fraction) -> Fraction:
        """Return the value at a place."""
        value: Fraction | int = 0
        power = 1
        for each in self.coefficients[::-1]:
            value = value * place.numerator + each * power
            power *= place.denominator
        return Fraction(value, power // place.denominator)

    def _joined(self, other: Polynomial, sign: int) -> Polynomial:
        one, two = self.coefficients, other.coefficients
        size = max(len(one), len(two))
        one += (0,) * (size - len(one))
        two += (0,) * (size - len(two))
        return Polynomial(tuple(a + sign * b for a, b in zip(one, two, strict=True)))


def constant(value: Fraction | int) -> Polynomial:
    """Return a polynomial of degree 0."""
    return Polynomial((Fraction(value),))


@dataclass(frozen=True, slots=True)
class Root:
    """A root of a polynomial with integer coefficients, alone between two places."""

    whole: tuple[int, ...]
    low: Fraction
    high: Fraction

    def narrowed(self, power: int) -> tuple[Fraction, Fraction]:
        """Return places around the root that are 2**-power apart, relative to the root.

        Examples
        --------
        >>> low, high = Root((-2, 0, 1), Fraction(1), Fraction(2)).narrowed(40)
        >>> round(float(low), 9), high - low < 1e-11
        (1.414213562, True)
        """
        low, high, here = self.low, self.high, Polynomial(self.whole)
        below, above = here(low), here(high)
        rising, parts = above > 0 or below < 0, 2
        if below == above == 0:  # both are other roots
            slope = Polynomial(tuple(n * each for n, each in enumerate(self.whole))[1:])
            rising = slope(low) < 0
        while high - low > high / 2**power:
            # the part in which the chord crosses 0; the parts are squared where the root is there
            share = below / (below - above) if below * above < 0 else Fraction(1, 2)
            number, step = min(int(parts * share), parts - 1), (high - low) / parts
            left, right = low + number * step, low + (number + 1) * step
            at_left = here(left) if number else below
            at_right = here(right) if number < parts - 1 else above
            for place, value in ((left, at_left), (right, at_right)):
                if value == 0 and low < place < high:
                    return place, place
            if number and (at_left < 0) != rising:
                high, above, parts = left, at_left, max(2, math.isqrt(parts))
            elif number < parts - 1 and (at_right < 0) == rising:
                low, below, parts = right, at_right, max(2, math.isqrt(parts))
            else:
                low, high, below, above = left, right, at_left, at_right
                parts *= parts
        return low, high


def isolated_roots(polynomial: Polynomial) -> list[Root]:
    """Return the positive roots, each isolated, and once if it is multiple.

    Examples
    --------
    >>> found = isolated_roots(Polynomial((Fraction(6), Fraction(-5), Fraction(1))))
    >>> [float(root.narrowed(60)[0]) for root in found]
    [2.0, 3.0]
    """
    below = math.lcm(*(each.denominator for each in polynomial.coefficients))
    whole = [int(each * below) for each in polynomial.coefficients]
    while whole and whole[-1] == 0:
        whole.pop()
    while whole and whole[0] == 0:
        whole.pop(0)
    if len(whole) < 2:
        return []
    if (intervals := _isolated(whole, _DEEPEST)) is None:
        whole = _with_simple_roots(whole)
        intervals = _isolated(whole, None) or []
    return [Root(tuple(whole), low, high) for low, high in intervals]


def _with_simple_roots(whole: list[int]) -> list[int]:
    """Return a polynomial with the same roots, none multiple: it over its divisor with its slope.

    The divisor is found by Euclid's algorithm with whole numbers.
    """
    one, two = whole, [place * each for place, each in enumerate(whole)][1:]
    while len(two) > 1:
        one, two = two, _divided(one, two)[1]
    if two:
        return whole
    quotient = _divided(whole, one)[0]
    common = math.gcd(*quotient)
    return [each // common for each in quotient]


def _divided(one: list[int], two: list[int]) -> tuple[list[int], list[int]]:
    """Return quotient and remainder up to a factor each, the remainder without common divisors."""
    rest, quotient = list(one), [0] * (len(one) - len(two) + 1)
    for shift in range(len(quotient) - 1, -1, -1):
        part = rest[shift + len(two) - 1]
        quotient = [each * two[-1] for each in quotient]
        quotient[shift] = part
        rest = [each * two[-1] for each in rest]
        for place, each in enumerate(two):
            rest[shift + place] -= part * each
    while rest and rest[-1] == 0:
        rest.pop()
    common = math.gcd(*rest) or 1
    return quotient, [each // common for each in rest]


def _bound(whole: list[int]) -> int:
    """Return an upper bound of the roots, a power of two: twice the largest root of a quotient."""
    degree, highest = len(whole) - 1, abs(whole[-1]).bit_length() - 1
    powers = [
        math.ceil((abs(each).bit_length() - highest) / (degree - place))
        for place, each in enumerate(whole[:-1])
        if each
    ]
    return 1 + max(powers)


def _isolated(whole: list[int], deepest: int | None) -> list[tuple[Fraction, Fraction]] | None:
    """Return intervals of positive numbers that contain one root each, by Descartes' rule.

    A root on the boundary of two of them is a separate interval of zero width. The answer is None
    if roots are not apart after `deepest` halvings.
    """
    degree, width = len(whole) - 1, Fraction(2) ** _bound(whole)
    scaled = [each * width**place for place, each in enumerate(whole)]
    below = math.lcm(*(each.denominator for each in scaled))
    found = []
    # polynomials on [0, 1], with the interval represented: its number among 2**depth
    todo = [([int(each * below) for each in scaled], 0, 0)]
    while todo:
        here, number, depth = todo.pop()
        count = _sign_changes(_shifted(here[::-1]))
        low = width * number / 2**depth
        if count == 1:
            found.append((low, low + width / 2**depth))
        if count < 2:
            continue
        if depth == deepest:
            return None
        left = [each << (degree - place) for place, each in enumerate(here)]
        right = _shifted(left)
        if right[0] == 0:
            middle = low + width / 2 ** (depth + 1)
            found.append((middle, middle))
        todo += [(left, 2 * number, depth + 1), (right, 2 * number + 1, depth + 1)]
    return sorted(found)


def _shifted(whole: list[int]) -> list[int]:
    """Return the coefficients of ``p(x + 1)``: the remainders of divisions by ``x - 1``."""
    found, quotient = [], whole[::-1]
    while quotient:
        quotient = list(accumulate(quotient))
        found.append(quotient.pop())
    return found


def _sign_changes(whole: list[int]) -> int:
    signs = [each > 0 for each in whole if each]
    return sum(one != other for one, other in pairwise(signs))
