"""Divided differences of the exponential: the response of a damped oscillator for any roots.

With the roots a and b of ``L**2 + 2 zeta L + kappa`` the response of the oscillator to a unit
impulse is ``exp[a, b] = (exp(a t) - exp(b t))/(a - b)``, and to ``exp(c t)`` it is
``exp[a, b, c]``. The forms here do not cancel, even if two rates are equal or nearly equal. Angles
are formed with 32 digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.closed_forms.double_double import DoubleDouble

# Below this product of rates and time the series about 0 is used, with this number of terms.
NEAR, TERMS = 1.0, 24


@dataclass(frozen=True, slots=True)
class Exponent:
    """A complex rate: growth and rotation."""

    growth: float
    turning: DoubleDouble

    @property
    def value(self) -> complex:
        """The number itself."""
        return complex(self.growth, float(self.turning.high))

    def __sub__(self, other: Exponent) -> Exponent:
        return Exponent(self.growth - other.growth, self.turning - other.turning)


def exponent(growth: float, turning: float = 0.0) -> Exponent:
    """Return a rate of two doubles."""
    return Exponent(growth, DoubleDouble.of(turning))


def roots(zeta: float, kappa: float) -> tuple[Exponent, Exponent]:
    """Return the roots of ``L**2 + 2 zeta L + kappa``; of real ones the one nearer 0 first.

    Examples
    --------
    >>> [each.value for each in roots(1.25, 1.0)], roots(0.0, 4.0)[0].value
    ([(-0.5+0j), (-2+0j)], 2j)
    """
    square = DoubleDouble.of(zeta) * DoubleDouble.of(zeta) - DoubleDouble.of(kappa)
    if square.high < 0.0:
        split = _root(-square)
        return Exponent(0.0 - zeta, split), Exponent(0.0 - zeta, -split)
    fast = zeta + float(_root(square).high)
    return exponent(-kappa / fast if fast > 0.0 else 0.0), exponent(-fast)


def less_one(rate: Exponent, elapsed: DoubleDouble) -> ComplexValues:
    """Return ``exp(rate t) - 1``."""
    shrinking, turn = np.expm1(rate.growth * elapsed.high), turn_less_one(rate.turning, elapsed)
    return np.asarray(shrinking + turn + shrinking * turn)


def of_one(rate: Exponent, elapsed: DoubleDouble) -> ComplexValues:
    """Return ``exp(rate t)``."""
    return np.asarray(
        np.exp(rate.growth * elapsed.high) * (1.0 + turn_less_one(rate.turning, elapsed))
    )


def of_two(one: Exponent, other: Exponent, elapsed: DoubleDouble) -> ComplexValues:
    """Return ``exp[a, b] = (exp(a t) - exp(b t))/(a - b)``, which is ``t exp(a t)`` at ``b = a``.

    Examples
    --------
    >>> one = DoubleDouble.of(1.0)
    >>> complex(of_two(exponent(0.0), exponent(-1.0), one)).real.__round__(12)
    0.632120558829
    """
    slow, fast = (one, other) if one.growth >= other.growth else (other, one)
    gap = fast - slow
    argument = gap.value * elapsed.high
    ratio = np.divide(
        less_one(gap, elapsed), argument, out=np.ones_like(argument), where=abs(argument) > 1e-290
    )
    return np.asarray(elapsed.high * of_one(slow, elapsed) * ratio)


def of_three(rates: tuple[Exponent, Exponent, Exponent], elapsed: DoubleDouble) -> ComplexValues:
    """Return ``exp[a, b, c] = (exp[a, b] - exp[b, c])/(a - c)``, also for equal rates.

    Examples
    --------
    >>> still = exponent(0.0)
    >>> complex(of_three((still, still, still), DoubleDouble.of(3.0)))
    (4.5+0j)
    """
    pairs = list(combinations(range(3), 2))
    one, other = max(pairs, key=lambda pair: abs((rates[pair[0]] - rates[pair[1]]).value))
    between = rates[3 - one - other]
    gap = (rates[one] - rates[other]).value
    near = max(abs(rate.value) for rate in rates) * elapsed.high < NEAR
    found = _series(rates, np.where(near, elapsed.high, 0.0))
    if gap != 0.0:
        apart = of_two(rates[one], between, elapsed) - of_two(between, rates[other], elapsed)
        found = np.where(near, found, apart / gap)
    return found


def turn_less_one(turning: DoubleDouble, elapsed: DoubleDouble) -> ComplexValues:
    """Return ``exp(i turning t) - 1``, including the low part of the angle."""
    angle = turning * elapsed
    most, rest = _circle_less_one(angle.high), _circle_less_one(angle.low)
    return np.asarray(most + rest + most * rest)


def _circle_less_one(angle: Values) -> ComplexValues:
    """Return ``exp(i angle) - 1 = -2 sin(angle/2)**2 + i sin(angle)``."""
    half = np.sin(0.5 * angle)
    return np.asarray(-2.0 * half * half + 1j * np.sin(angle))


def _series(rates: tuple[Exponent, Exponent, Exponent], elapsed: Values) -> ComplexValues:
    """Return ``t**2 (1/2! + h_1/3! + h_2/4! + ...)``, with h_k of the products of rates and time.

    The h_k are the complete homogeneous symmetric polynomials, the coefficients of
    ``1/((1 - a t x) (1 - b t x) ...)`` as a series in x.
    """
    a, b, c = (rate.value * elapsed for rate in rates)
    by_last, by_second, by_third = a + b + c, a * b + b * c + c * a, a * b * c
    nothing = np.zeros_like(a)
    third, second, last = nothing, nothing, nothing + 1.0
    factor = 0.5
    total = factor * last
    for k in range(1, TERMS):
        third, second, last = (
            second, last, by_last * last - by_second * second + by_third * third,
        )  # fmt: skip
        factor /= k + 2.0
        total = total + factor * last
    return np.asarray(elapsed * elapsed * total)


def _root(square: DoubleDouble) -> DoubleDouble:
    """Return the root of a number that is not negative."""
    high = np.sqrt(square.high)
    if high == 0.0:
        return DoubleDouble.of(0.0)
    first = DoubleDouble.of(high)
    return first + DoubleDouble.of(0.5 * (square - first * first).high / high)
