"""Polynomials with exact coefficients, and their positive roots.

Parameters are doubles, so all sums and products of them are fractions, here whole numbers over one
denominator for all coefficients: that takes a third of the time of fractions in lowest terms. The
roots of a polynomial are isolated by Descartes' rule of signs: none is lost or invented [1]_. The
rule separates roots however near they are, but not those that coincide, so multiple roots are made
simple first. A root is narrowed by quadratic refinement of its interval [2]_.

References
----------
.. [1] G. E. Collins, A. G. Akritas, "Polynomial real root isolation using Descartes' rule of
   signs", SYMSAC 1976.
.. [2] J. Abbott, "Quadratic interval refinement for real roots", ACM Communications in Computer
   Algebra 48(1), 2014.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate, pairwise

# Two roots closer than this power of two, relative to the largest possible root, probably coincide:
# then the polynomial is divided by its multiple factors, which would take long for every one.
_DEEPEST = 400
# Roots are narrowed to these relative powers of two, one after the other, until the result is the
# same at both ends: a whirl near amplitude 1 may have nearly any speed.
FINER = (70, 140, 280, 560, 1120)


@dataclass(frozen=True, slots=True)
class Polynomial:
    """A polynomial by its coefficients, the lowest first, all times one denominator."""

    whole: tuple[int, ...]
    below: int = 1

    def __add__(self, other: Polynomial) -> Polynomial:
        """Return the sum."""
        return self._joined(other, 1)

    def __sub__(self, other: Polynomial) -> Polynomial:
        """Return the difference."""
        return self._joined(other, -1)

    def __mul__(self, other: Polynomial) -> Polynomial:
        """Return the product."""
        one, two = self.whole, other.whole
        found = [0] * (len(one) + len(two) - 1)
        for i, a in enumerate(one):
            if a:
                for j, b in enumerate(two):
                    found[i + j] += a * b
        return Polynomial(tuple(found), self.below * other.below)

    def __floordiv__(self, other: Polynomial) -> Polynomial:
        """Return the quotient, up to a factor."""
        return Polynomial(tuple(divided(self.whole, other.whole)[0]))

    def __call__(self, place: Fraction) -> Fraction:
        """Return the value at a place."""
        degree = len(self.whole) - 1
        return Fraction(_value(self.whole, place), place.denominator**degree * self.below)

    def _joined(self, other: Polynomial, sign: int) -> Polynomial:
        below, one, two = math.lcm(self.below, other.below), self.whole, other.whole
        if self.below != below:
            one = tuple(each * (below // self.below) for each in one)
        if other.below != below:
            two = tuple(each * (below // other.below) for each in two)
        size = max(len(one), len(two))
        one += (0,) * (size - len(one))
        two += (0,) * (size - len(two))
        return Polynomial(tuple(a + sign * b for a, b in zip(one, two, strict=True)), below)


def constant(value: Fraction | float) -> Polynomial:
    """Return a polynomial of degree 0."""
    above, below = value.as_integer_ratio()
    return Polynomial((above,), below)


def values_at(place: Fraction, polynomials: tuple[Polynomial, ...]) -> list[int]:
    """Return the values of polynomials at a place, all times one factor that makes them whole.

    Examples
    --------
    >>> values_at(Fraction(1, 2), (Polynomial((0, 1)), Polynomial((0, 0, 3)), constant(0.25)))
    [8, 12, 4]
    """
    degree = max(len(each.whole) for each in polynomials)
    below = math.lcm(*(each.below for each in polynomials))
    return [
        _value(each.whole, place)
        * place.denominator ** (degree - len(each.whole))
        * (below // each.below)
        for each in polynomials
    ]


def _value(whole: tuple[int, ...], place: Fraction) -> int:
    """Return the value at a place, times its denominator to the degree."""
    above, below = place.numerator, place.denominator
    value, power = 0, 1
    for each in reversed(whole):
        value = value * above + each * power
        power *= below
    return value


@dataclass(frozen=True, slots=True)
class Root:
    """A root of a polynomial with integer coefficients, alone between two places over 2**shift."""

    whole: tuple[int, ...]
    low: int
    high: int
    shift: int

    def narrowed(self, power: int) -> tuple[Fraction, Fraction]:
        """Return places around the root that are 2**-power apart, relative to the root.

        Examples
        --------
        >>> low, high = Root((-2, 0, 1), 1, 2, 0).narrowed(40)
        >>> round(float(low), 9), high - low < 1e-11
        (1.414213562, True)
        """
        low, width, shift, degree = self.low, self.high - self.low, self.shift, len(self.whole) - 1
        below, above = self._value(low, shift), self._value(low + width, shift)
        rising, bits = above > 0 or below < 0, 1
        if below == above == 0:  # both are other roots
            slope = Polynomial(tuple(n * each for n, each in enumerate(self.whole))[1:])
            rising = slope(Fraction(low, 1 << shift)) < 0
        while width << power > low + width:
            if (finer := bits + 1 - (width & -width).bit_length()) > 0:
                low, width, shift = low << finer, width << finer, shift + finer
                below, above = below << finer * degree, above << finer * degree
            # the part in which the chord crosses 0; the parts are squared where the root is there
            last, step, number = (1 << bits) - 1, width >> bits, 1 << bits - 1
            if below < 0 < above or above < 0 < below:
                number = min((below << bits) // (below - above), last)
            left, right = low + number * step, low + (number + 1) * step
            at_left = self._value(left, shift) if number else below
            at_right = self._value(right, shift) if number < last else above
            for place, value in ((left, at_left), (right, at_right)):
                if value == 0 and low < place < low + width:
                    return Fraction(place, 1 << shift), Fraction(place, 1 << shift)
            if number and (at_left < 0) != rising:
                width, above, bits = left - low, at_left, max(1, bits // 2)
            elif number < last and (at_right < 0) == rising:
                low, width, below, bits = right, low + width - right, at_right, max(1, bits // 2)
            else:
                low, width, below, above, bits = left, step, at_left, at_right, 2 * bits
        return Fraction(low, 1 << shift), Fraction(low + width, 1 << shift)

    def _value(self, place: int, shift: int) -> int:
        """Return the value at a place over 2**shift, times 2**shift to the degree."""
        value, more = 0, 0
        for each in reversed(self.whole):
            value = value * place + (each << more)
            more += shift
        return value


def isolated_roots(coefficients: Sequence[int]) -> list[Root]:
    """Return the positive roots of a polynomial, each isolated, and once if it is multiple.

    Examples
    --------
    >>> [float(root.narrowed(60)[0]) for root in isolated_roots((6, -5, 1))]
    [2.0, 3.0]
    """
    whole = list(coefficients)
    while whole and whole[-1] == 0:
        whole.pop()
    while whole and whole[0] == 0:
        whole.pop(0)
    if len(whole) < 2:
        return []
    common = math.gcd(*whole)
    whole = [each // common for each in whole]
    if (roots := _isolated(whole, _DEEPEST)) is None:
        roots = _isolated(_with_simple_roots(whole), None) or []
    return roots


def _with_simple_roots(whole: list[int]) -> list[int]:
    """Return a polynomial with the same roots, none multiple: it over its divisor with its slope.

    The divisor is found by Euclid's algorithm with whole numbers.
    """
    one, two = whole, [place * each for place, each in enumerate(whole)][1:]
    while len(two) > 1:
        one, two = two, divided(one, two)[1]
    if two:
        return whole
    quotient = divided(whole, one)[0]
    common = math.gcd(*quotient)
    return [each // common for each in quotient]


def divided(one: Sequence[int], two: Sequence[int]) -> tuple[list[int], list[int]]:
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


def _isolated(whole: list[int], deepest: int | None) -> list[Root] | None:
    """Return intervals of positive numbers that contain one root each, by Descartes' rule.

    A root on the boundary of two of them is a separate interval of zero width. The answer is None
    if roots are not apart after `deepest` halvings.
    """
    degree, bound = len(whole) - 1, _bound(whole)
    found = []

    def root(low: int, high: int, depth: int) -> Root:
        whole_bits = max(bound - depth, 0)
        return Root(tuple(whole), low << whole_bits, high << whole_bits, max(depth - bound, 0))

    # polynomials on [0, 1], with the interval represented: its number among 2**depth
    powers = [place if bound > 0 else place - degree for place in range(degree + 1)]
    todo = [([each << bound * power for each, power in zip(whole, powers, strict=True)], 0, 0)]
    while todo:
        here, number, depth = todo.pop()
        count = _sign_changes(_shifted(here[::-1]))
        if count == 1:
            found.append(root(number, number + 1, depth))
        if count < 2:
            continue
        if depth == deepest:
            return None
        left = [each << (degree - place) for place, each in enumerate(here)]
        right = _shifted(left)
        if right[0] == 0:
            found.append(root(2 * number + 1, 2 * number + 1, depth + 1))
        todo += [(left, 2 * number, depth + 1), (right, 2 * number + 1, depth + 1)]
    return sorted(found, key=lambda each: Fraction(each.low, 1 << each.shift))


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
