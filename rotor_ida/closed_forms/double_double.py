"""Numbers kept as an unevaluated sum of two doubles: about 32 digits, in plain numpy.

Near a fold two whirls almost coincide, and a residual rounded to 16 digits cannot separate them.
The error-free transformations below can, on every platform (``longdouble`` is a plain double on
some).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values

_SPLITTER = 134217729.0  # 2**27 + 1 cuts a double into two halves whose products are exact


@dataclass(frozen=True, slots=True)
class DoubleDouble:
    """An array of numbers ``high + low`` with ``|low| <= ulp(high)/2``.

    Parameters
    ----------
    high, low : ndarray
        Leading part and remainder.

    References
    ----------
    Dekker, "A floating-point technique for extending the available precision", Numerische
    Mathematik 18, 1971; Shewchuk, "Adaptive precision floating-point arithmetic", 1997.

    Examples
    --------
    >>> third = DoubleDouble.of(1.0) + DoubleDouble.of(1e-20)
    >>> float((third - DoubleDouble.of(1.0)).high)
    1e-20
    """

    high: Values
    low: Values

    @classmethod
    def of(cls, value: npt.ArrayLike) -> DoubleDouble:
        """Return plain doubles as exact pairs."""
        high = np.asarray(value, dtype=np.float64)
        return cls(high, np.zeros_like(high))

    def __add__(self, other: DoubleDouble) -> DoubleDouble:
        high, error = _two_sum(self.high, other.high)
        low, tail = _two_sum(self.low, other.low)
        high, error = _quick_two_sum(high, error + low)
        return DoubleDouble(*_quick_two_sum(high, error + tail))

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.high, -self.low)

    def __sub__(self, other: DoubleDouble) -> DoubleDouble:
        return self + (-other)

    def __mul__(self, other: DoubleDouble) -> DoubleDouble:
        high, error = _two_product(self.high, other.high)
        error = error + (self.high * other.low + self.low * other.high)
        return DoubleDouble(*_quick_two_sum(high, error))

    def __getitem__(self, chosen: npt.NDArray[np.int_]) -> DoubleDouble:
        return DoubleDouble(self.high[chosen], self.low[chosen])


def _two_sum(a: Values, b: Values) -> tuple[Values, Values]:
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def _quick_two_sum(large: Values, small: Values) -> tuple[Values, Values]:
    total = large + small
    return total, small - (total - large)


def _two_product(a: Values, b: Values) -> tuple[Values, Values]:
    product = a * b
    a_high, a_low = _split(a)
    b_high, b_low = _split(b)
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, error


def _split(a: Values) -> tuple[Values, Values]:
    scaled = _SPLITTER * a
    high = scaled - (scaled - a)
    return high, a - high
