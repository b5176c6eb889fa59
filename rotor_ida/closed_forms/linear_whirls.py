"""All synchronous whirls in a linear contact.

With the exponent 1, ``q = omega**2``, a shaft of stiffness kappa, ``k = 1 + kappa - q`` and
``G = k**2 + 4 zeta**2 q`` a contacting whirl is a root A > delta0 of the quadratic

    P(A) = F**2 - q**2 + 4 zeta**2 q A**2 = G A**2 - 2 k delta0 A + delta0**2 - q**2,
    F = k A - delta0,    dP/dA = 2 A D,

where D is the determinant that decides stability. The roots are
``(k delta0 +- sqrt(S))/G`` with ``S = q**2 G - 4 zeta**2 q delta0**2``.

With friction, rotated as in `contacting_whirls`, and ``m = 1 + mu**2``, replace delta0 by
``m delta0``, q**2 by ``m q**2`` and ``4 zeta**2 q`` by ``(2 zeta omega + mu (q - kappa))**2``, with
``k = m - (q - kappa) + 2 mu zeta omega`` and ``dP/dA = 2 m A D``.
"""

from __future__ import annotations

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.contacting_whirls import ContactingWhirls, packed, turned_by_friction
from rotor_ida.closed_forms.double_double import DoubleDouble
from rotor_ida.closed_forms.rotor_columns import RotorColumns

_COLUMNS = 5  # as many as with a Hertz contact, to share its tables
_LARGEST = 1e100  # squares of larger amplitudes leave the range of doubles


def linear_whirls(rotors: RotorColumns) -> ContactingWhirls:
    """Compute all whirls in contact of rotors with ``omega > 0`` and the exponent 1.

    Parameters
    ----------
    rotors : RotorColumns, shape (n,)
        Their parameters; the exponent and the contact damping are not used.

    Returns
    -------
    ContactingWhirls
        Up to two for each rotor.

    Notes
    -----
    There is one if the contact-free whirl does not fit into the clearance, ``P(delta0) < 0``.
    Otherwise there are two if ``S > 0`` and ``k > G``, else none. In resonance without damping
    (G = 0) there is none, and near it none with an amplitude above 1e100.

    Examples
    --------
    >>> at = linear_whirls(RotorColumns.of({"omega": [0.5], "zeta": 0.5, "delta0": 0.25}))
    >>> at.amplitude[0, :1].round(6), at.contact_free
    (array([0.461538]), array([False]))
    """
    one, omega = DoubleDouble.of(np.ones_like(rotors.omega)), DoubleDouble.of(rotors.omega)
    q, two_zeta = omega * omega, DoubleDouble.of(2.0 * rotors.zeta)
    clearance, delta0 = DoubleDouble.of(rotors.delta0), rotors.delta0[:, None]
    p = q - DoubleDouble.of(rotors.shaft_stiffness)
    impedance = p * p + two_zeta * two_zeta * q
    contact_free = (clearance * clearance * impedance - q * q).high >= 0.0
    turned = turned_by_friction(p, rotors)
    start, resistance = turned.lead, turned.damping
    k, d, drive = start - turned.p, start * clearance, start * (q * q)
    G = k * k + resistance
    inside = drive * G - resistance * d * d
    pair = contact_free & (inside.high > 0.0) & ((k * start - G).high > 0.0)
    exists = np.stack([pair, (pair | ~contact_free) & (G.high > 0.0)], axis=1)

    root = np.sqrt(np.maximum(inside.high, 0.0))
    product = (d * d - drive).high
    with_root = np.abs(k.high) * d.high + root
    outer = np.where(k.high >= 0.0, with_root, -product), np.where(k.high >= 0.0, G.high, with_root)
    estimate = np.stack([_ratio(product, with_root), _ratio(*outer)], axis=1)
    exists &= estimate < _LARGEST
    estimate = np.where(exists, estimate, 1.0)
    A = _polished(estimate, (k, G, d, drive), root)
    amplitude, force_excess = A.high, (_column(one - p) * A - _column(clearance)).high
    loss = (2.0 * rotors.zeta * rotors.omega)[:, None] * amplitude
    loss = loss + rotors.friction[:, None] * np.maximum(amplitude - delta0, 0.0)
    scale = estimate * start.high[:, None]
    size = np.maximum(root[:, None] / scale, np.finfo(np.float64).tiny)
    columns = {
        "amplitude": np.maximum(amplitude, delta0),
        "phase_lag": np.arctan2(loss, force_excess),
        "determinant": size * np.array([-1.0, 1.0]),
    }
    rows, shape = np.nonzero(exists)[0], (len(exists), _COLUMNS)
    placed = {name: packed(column[exists], rows, shape) for name, column in columns.items()}
    return ContactingWhirls(**placed, contact_free=contact_free)


def _ratio(above: Values, below: Values) -> Values:
    with np.errstate(over="ignore"):
        return np.divide(above, below, out=np.full_like(above, np.nan), where=below > 0.0)


def _polished(estimate: Values, terms: tuple[DoubleDouble, ...], root: Values) -> DoubleDouble:
    """Return the amplitude after one Newton step with a 32-digit residual, shape (n, 2)."""
    k, G, d, drive = map(_column, terms)
    A = DoubleDouble.of(estimate)
    residual = (G * (A * A) - k * d * (A + A) + (d * d - drive)).high
    slope = 2.0 * root[:, None] * np.array([-1.0, 1.0])
    step = np.divide(-residual, slope, out=np.zeros_like(residual), where=slope != 0.0)
    return A + DoubleDouble.of(np.where(np.abs(step) < 1e-6 * estimate, step, 0.0))


def _column(value: DoubleDouble) -> DoubleDouble:
    return DoubleDouble(value.high[:, None], value.low[:, None])
