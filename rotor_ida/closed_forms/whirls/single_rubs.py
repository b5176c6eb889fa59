"""All synchronous rubs of an axisymmetric rotor system at one contact, with none lost.

Let the contact whirl without contact with the complex amplitude U, and a unit force there displace
it by H. In a rub of radius ``A = delta + d`` and normal force ``N = k d**n``, with the complex
direction E, ``|E| = 1``, from the unbalance's,

    A E = U - H N (1 + i mu sigma) E,

where sigma is the sign of the speed, as the surfaces slide forwards. Lengths are over the
clearance. With the exponent 3/2, ``v = sqrt(d)`` and ``g = k H (1 + i mu sigma)`` the size of E is
1 where ``|1 + v**2 + g v**3|**2 = |U|**2``. It is the polynomial of one disc (`contacting_whirls`)
with ``m = |g|**2``, ``p = -Re g``, ``damping = (Im g)**2`` and ``q = |U|``. With the exponent 1 it
is a quadratic: ``|1 + g|**2 d**2 + 2 (1 + Re g) d + 1 - |U|**2 = 0``.
"""

from __future__ import annotations

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.closed_forms.contacting_whirls import Rows, RubEquation, rub_roots
from rotor_ida.closed_forms.double_double import DoubleDouble

# A contact with less effect than this on its own displacement has none.
SMALLEST_EFFECT = 1e-60


def single_rubs(free: Values, effect: ComplexValues, *, hertz: bool) -> tuple[Rows, Values]:
    """Return all rubs of many contacts.

    Parameters
    ----------
    free : ndarray, shape (n,)
        Radii ``|U|`` without contact, over the clearance.
    effect : ndarray of complex, shape (n,)
        The numbers g: those of the contact's force at an indentation of a clearance.
    hertz : bool
        Whether the exponent is 3/2, else 1.

    Returns
    -------
    rows, depths : ndarray, shape (k,)
        Which contact each rub is of, and its indentation over the clearance, in ascending order.
        Two that differ by less than rounding may both be missing.

    Examples
    --------
    >>> rows, depths = single_rubs(np.array([2.0]), np.array([3.0 + 0j]), hertz=False)
    >>> rows, depths  # 1 + 4 d = 2
    (array([0]), array([0.25]))
    """
    return _hertz(free, effect) if hertz else _linear(free, effect)


def _hertz(free: Values, effect: ComplexValues) -> tuple[Rows, Values]:
    """Return the squares of the roots of the polynomial of degree six."""
    g = np.where(np.abs(effect) > SMALLEST_EFFECT, effect, SMALLEST_EFFECT)
    real, imaginary = DoubleDouble.of(g.real), DoubleDouble.of(g.imag)
    one = DoubleDouble.of(np.ones_like(free))
    lead = real * real + imaginary * imaginary
    equation = RubEquation(DoubleDouble.of(free), -real, imaginary * imaginary, one, lead)
    size = np.sqrt(lead.high)
    p, q = -g.real / lead.high, free / size
    limit = np.maximum(p, 0.0) + np.cbrt(q + np.maximum(p, 0.0))
    found = rub_roots(equation, (p, 1.0 / lead.high), limit, free <= 1.0)
    return found.rows, (found.u * found.u).high


def _linear(free: Values, effect: ComplexValues) -> tuple[Rows, Values]:
    """Return the positive roots of the quadratic."""
    stiffened = 1.0 + effect
    size, half = np.abs(stiffened), stiffened.real
    across = np.abs(effect.imag)
    inside = (size * free - across) * (size * free + across)
    root = np.sqrt(np.maximum(inside, 0.0))
    rest = (1.0 - free) * (1.0 + free)
    touches = free > 1.0
    pair = ~touches & (inside > 0.0) & (half < 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        larger = np.where(half > 0.0, -rest / (half + root), (root - half) / size**2)
        smaller = rest / (root - half)
    depths = np.column_stack([np.where(pair, smaller, np.nan), larger])
    exists = np.column_stack([pair, pair | touches]) & np.isfinite(depths) & (depths > 0.0)
    return np.nonzero(exists)[0], depths[exists]
