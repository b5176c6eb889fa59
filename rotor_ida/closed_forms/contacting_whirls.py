"""All synchronous whirls in contact, with none lost and none invented.

With ``u = sqrt(A - delta0)`` and ``q = omega**2`` a contacting whirl is a root u > 0 of

    P(u) = F**2 - q**2 + 4 zeta**2 q A**2,    A = delta0 + u**2,    F = u**3 - p A,

where ``p = q - kappa`` with a shaft of stiffness kappa, and q without. It is a polynomial because
the Hertz exponent is 3/2, which makes the force u**3. Between two neighbouring extrema of P there
is at most one root, so the extrema are found first, from those of the derivative, and so on down
to a quadratic. A root exists depending on the sign of P at an extremum, which is computed with 32
digits. As ``dP/du = 4 u A D``, where D is the determinant that decides stability, a whirl is stable
exactly where P rises through zero.

Friction rotates the contact force by the angle ``arctan(mu)``. With ``h = 2 zeta omega`` and
``m = 1 + mu**2``, the equation of a whirl that slips forwards, times ``1 - i mu``, is

    m u**3 + (mu h - p) A + i (h + mu p) A = (1 - i mu) q exp(i theta),

so that m P is the same polynomial with ``F = m u**3 - (p - mu h) A``, ``(h + mu p)**2`` in place of
``4 zeta**2 q`` and ``m q**2`` in place of ``q**2``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ROUNDING, Values
from rotor_ida.closed_forms.double_double import DoubleDouble
from rotor_ida.closed_forms.rotor_columns import RotorColumns

Rows = npt.NDArray[np.int_]
Evaluate = Callable[[Values, Rows], tuple[Values, Values]]

# Brent's method may need three times as many as bisection: a root may be 1e-300 of its bracket.
_MOST_STEPS_OF_BRENT = 4000
_MOST_ITERATIONS = 300  # bisection alone needs about 60 in u, and 1100 only from subnormals
# Relative change with which a root is found; and a step so short that where it leads is one.
_ENOUGH, _LAST = 2.0**-52, 2.0**-50


@dataclass(frozen=True, slots=True)
class ContactingWhirls:
    """The contacting whirls of many rotors, in order of amplitude.

    Parameters
    ----------
    amplitude, phase_lag, determinant : ndarray, shape (n, 5)
        Amplitudes [dimensionless], phase lags [rad] and stability determinants D [dimensionless],
        positive if the whirl does not diverge; NaN where a rotor has fewer whirls.
    contact_free : ndarray of bool, shape (n,)
        Whether the contact-free whirl exists.
    """

    amplitude: Values
    phase_lag: Values
    determinant: Values
    contact_free: npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class RubEquation:
    """The polynomial ``(m u**3 - p A)**2 - m q**2 + damping A**2``, ``A = delta0 + u**2``, of many.

    Its parameters are known to 32 digits.
    """

    q: DoubleDouble
    p: DoubleDouble  # q, less the stiffness of the shaft
    damping: DoubleDouble  # 4 zeta**2 q
    delta0: DoubleDouble
    lead: DoubleDouble  # m

    def precise(self, u: DoubleDouble, rows: Rows) -> tuple[Values, Values]:
        """Return P, from 32-digit arithmetic, and its slope at `u`."""
        q, p, damping = self.q[rows], self.p[rows], self.damping[rows]
        square = u * u
        amplitude = self.delta0[rows] + square
        lead = self.lead[rows]
        force_excess = lead * (square * u) - p * amplitude
        drive = lead * (q * q)
        value = (force_excess * force_excess - drive) + damping * (amplitude * amplitude)
        slope = 2.0 * force_excess.high * (3.0 * lead.high * u.high - 2.0 * p.high) * u.high
        slope += 4.0 * damping.high * amplitude.high * u.high
        return value.high, slope

    def plain(self, u: Values, rows: Rows) -> tuple[Values, Values]:
        """Return P and its slope in plain doubles."""
        q, p, damping = self.q.high[rows], self.p.high[rows], self.damping.high[rows]
        amplitude = self.delta0.high[rows] + u * u
        lead = self.lead.high[rows]
        force_excess = lead * (u * u * u) - p * amplitude
        value = force_excess * force_excess - lead * q * q + damping * amplitude * amplitude
        slope = 2.0 * force_excess * (3.0 * lead * u - 2.0 * p) * u
        return value, slope + 4.0 * damping * amplitude * u


def contacting_whirls(rotors: RotorColumns) -> ContactingWhirls:
    """Compute all whirls in contact of rotors with ``omega > 0`` and the Hertz exponent.

    Parameters
    ----------
    rotors : RotorColumns, shape (n,)
        Their parameters; the exponent and the contact damping are not used.

    Returns
    -------
    ContactingWhirls
        Up to five for each rotor.

    Notes
    -----
    ``P(0) = q**2 ((delta0/A_f)**2 - 1)``, also with a shaft: its sign shows whether the
    contact-free whirl of amplitude A_f fits into the clearance. At a change of sign exactly one
    whirl of each kind appears or vanishes.

    References
    ----------
    Eqs (21)-(23) of the paper, Mechanika 25(6), 2019, with the Hertz force in its right form.

    Examples
    --------
    >>> rotors = RotorColumns.of({"omega": [1.7], "zeta": 0.07, "delta0": 0.0})
    >>> at = contacting_whirls(rotors)
    >>> at.amplitude[0, :3].round(6)
    array([1.879631, 6.193211, 9.487207])
    """
    omega, clearance = DoubleDouble.of(rotors.omega), DoubleDouble.of(rotors.delta0)
    q, two_zeta = omega * omega, DoubleDouble.of(2.0 * rotors.zeta)
    p = q - DoubleDouble.of(rotors.shaft_stiffness)
    impedance = p * p + two_zeta * two_zeta * q
    contact_free = (clearance * clearance * impedance - q * q).high >= 0.0
    turned = turned_by_friction(p, rotors)
    equation = RubEquation(q, turned.p, turned.damping, clearance, turned.lead)
    lead = turned.lead.high
    reduced = q.high / np.sqrt(lead), turned.p.high / lead, impedance.high / lead
    limit = np.maximum(reduced[1], 0.0) + np.cbrt(reduced[0] * (rotors.delta0 + 1.0))
    found = rub_roots(equation, reduced[1:], limit, contact_free)
    u, rows = found.u, found.rows
    _, slope = equation.precise(u, rows)
    radius, cube, whirling = clearance[rows] + u * u, u * u * u, rotors[rows]
    amplitude = radius.high
    loss = 2.0 * whirling.zeta * whirling.omega * amplitude + whirling.friction * cube.high
    lag = np.arctan2(loss, (cube - p[rows] * radius).high)
    scale = 4.0 * u.high * amplitude * lead[rows]
    # The direction in which P crosses zero is certain; the sign of a rounded D near 0 is not.
    size = np.maximum(np.abs(slope) / scale, np.finfo(np.float64).tiny)
    determinant = np.where(found.rising, size, -size)
    shape = found.shape
    return ContactingWhirls(
        amplitude=packed(amplitude, rows, shape),
        phase_lag=packed(lag, rows, shape),
        determinant=packed(determinant, rows, shape),
        contact_free=contact_free,
    )


@dataclass(frozen=True, slots=True)
class RubRoots:
    """The positive roots of the polynomials of many rotors, one after the other.

    Parameters
    ----------
    u : DoubleDouble, shape (k,)
        The roots, in order of rotor and size.
    rows : ndarray of int, shape (k,)
        Which rotor each belongs to.
    rising : ndarray of bool, shape (k,)
        Whether the polynomial rises through zero there.
    shape : (int, int)
        Number of rotors, and the largest number of roots of any.
    """

    u: DoubleDouble
    rows: Rows
    rising: npt.NDArray[np.bool_]
    shape: tuple[int, ...]


def rub_roots(
    equation: RubEquation,
    reduced: tuple[Values, Values],
    limit: Values,
    contact_free: npt.NDArray[np.bool_],
) -> RubRoots:
    """Return all positive roots of polynomials, none lost and none invented.

    `reduced` are ``p/m`` and ``(p**2 + damping)/m**2``, `limit` bounds the roots from above, and
    the polynomial is negative at 0 except where `contact_free` is set.
    """
    breakpoints = _extrema(*reduced, limit, equation.delta0.high)
    signs = _signs(equation, breakpoints, contact_free)
    estimate, rising = _roots_between(equation.plain, breakpoints, signs)
    u = _polished(equation, breakpoints, estimate, rising)
    rows, columns = np.nonzero(np.isfinite(estimate))
    return RubRoots(u, rows, rising[rows, columns], estimate.shape)


@dataclass(frozen=True, slots=True)
class Turned:
    """The terms of the whirl's equation, rotated so that the contact force is real."""

    lead: DoubleDouble  # m = 1 + mu**2
    p: DoubleDouble  # p - mu h
    damping: DoubleDouble  # (h + mu p)**2


def turned_by_friction(p: DoubleDouble, rotors: RotorColumns) -> Turned:
    """Return the terms with ``h = 2 zeta omega``: see the head of this module."""
    mu = DoubleDouble.of(rotors.friction)
    h = DoubleDouble.of(2.0 * rotors.zeta) * DoubleDouble.of(rotors.omega)
    across = h + mu * p
    one = DoubleDouble.of(np.ones_like(rotors.omega))
    return Turned(one + mu * mu, p - mu * h, across * across)


def _extrema(p: Values, stiffness: Values, limit: Values, delta0: Values) -> Values:
    """Return 0, the extrema of P in ascending order and a bound on its roots, shape (n, 6).

    ``stiffness`` is ``p**2 + damping``, all with m = 1. Missing extrema repeat the bound. For
    ``p <= 0`` there are none, as no term of the slope of P is negative.
    """
    softens = p > 0.0
    bound = 1.000001 * limit
    p = np.where(softens, p, 1.0)
    quartic = (
        2.0 * delta0 * stiffness,
        -3.0 * p * delta0,
        2.0 * stiffness,
        -5.0 * p,
        3.0 + 0.0 * p,
    )
    cubic = _derivative(quartic)
    quadratic = _derivative(cubic)
    root = np.sqrt(np.maximum(quadratic[1] ** 2 - 4.0 * quadratic[2] * quadratic[0], 0.0))
    larger = -quadratic[1] + root
    smaller = 2.0 * quadratic[0] / larger
    points = np.stack([smaller, larger / (2.0 * quadratic[2])], axis=1)
    for polynomial in (cubic, quartic):
        points = _roots_of(polynomial, _bounded(points, bound))
    return _bounded(np.where(softens[:, None], points, np.nan), bound)


def _bounded(points: Values, bound: Values) -> Values:
    """Return 0, `points` and `bound` in order; missing points repeat the bound."""
    inside = np.where(np.isnan(points), bound[:, None], np.minimum(points, bound[:, None]))
    edges = (np.zeros_like(bound)[:, None], np.sort(inside, axis=1), bound[:, None])
    return np.concatenate(edges, axis=1)


def _derivative(coefficients: tuple[Values, ...]) -> tuple[Values, ...]:
    return tuple(order * c for order, c in enumerate(coefficients))[1:]


def _roots_of(coefficients: tuple[Values, ...], breakpoints: Values) -> Values:
    """Return the roots of a polynomial between the extrema `breakpoints`."""

    def evaluate(u: Values, rows: Rows) -> tuple[Values, Values]:
        value = coefficients[-1][rows]
        slope = np.zeros_like(value)
        for coefficient in reversed(coefficients[:-1]):
            slope = slope * u + value
            value = value * u + coefficient[rows]
        return value, slope

    every = np.arange(len(breakpoints))
    at_breakpoints = [evaluate(column, every)[0] for column in breakpoints.T]
    roots, _ = _roots_between(evaluate, breakpoints, np.stack(at_breakpoints, axis=1))
    return roots


def _signs(
    equation: RubEquation, breakpoints: Values, contact_free: npt.NDArray[np.bool_]
) -> Values:
    """Return the sign of P at 0, at its extrema and at the bound (where it is positive)."""
    signs = np.ones_like(breakpoints)
    signs[:, 0] = np.where(contact_free, 1.0, -1.0)
    rows, columns = np.nonzero(breakpoints[:, 1:-1] < breakpoints[:, -1:])
    points = DoubleDouble.of(breakpoints[rows, columns + 1])
    signs[rows, columns + 1] = np.sign(equation.precise(points, rows)[0])
    return signs


def _polished(
    equation: RubEquation,
    breakpoints: Values,
    estimate: Values,
    rising: npt.NDArray[np.bool_],
) -> DoubleDouble:
    """Return the roots with 32-digit residuals, keeping the last Newton step as the low part."""
    rows, columns = np.nonzero(np.isfinite(estimate))

    def evaluate(u: Values, chosen: Rows) -> tuple[Values, Values]:
        return equation.precise(DoubleDouble.of(u), rows[chosen])

    u = bracketed_newton(
        evaluate,
        breakpoints[rows, columns],
        breakpoints[rows, columns + 1],
        rising[rows, columns],
        estimate[rows, columns],
    )
    value, slope = evaluate(u, np.arange(u.size))
    correction = np.divide(-value, slope, out=np.zeros_like(u), where=slope != 0.0)
    return DoubleDouble.of(u) + DoubleDouble.of(correction)


def packed(values: Values, rows: Rows, shape: tuple[int, ...]) -> Values:
    """Return the `values` of each row moved to the front, followed by NaN."""
    packed = np.full(shape, np.nan)
    first = np.searchsorted(rows, rows)  # rows are sorted: how many came before this row
    packed[rows, np.arange(rows.size) - first] = values
    return packed


def bracketed_newton(
    evaluate: Evaluate,
    low: Values,
    high: Values,
    rising: npt.NDArray[np.bool_],
    start: Values | None = None,
) -> Values:
    """Return the root of each function between `low` and `high`, where it changes sign.

    ``evaluate(points, rows)`` gives values and slopes of the functions number `rows`; `rising`
    marks those that are negative at `low`. Newton's method is used, with bisection if a step would
    leave the bracket or fails to halve the last one (Press et al., "Numerical Recipes").
    """
    low, high = low.copy(), high.copy()
    root = 0.5 * (low + high) if start is None else np.clip(start, low, high)
    step_before = high - low
    active = np.arange(root.size)
    for _ in range(_MOST_ITERATIONS):
        if not active.size:
            break
        point = root[active]
        value, slope = evaluate(point, active)
        above = (value > 0.0) == rising[active]
        high[active] = np.where(above, point, high[active])
        low[active] = np.where(above, low[active], point)
        step = np.divide(value, slope, out=np.full_like(value, np.inf), where=slope != 0.0)
        target = point - step
        bisect = (
            (target <= low[active])
            | (target >= high[active])
            | (2.0 * np.abs(step) > np.abs(step_before[active]))
        )
        # a last step: then rounding leads on and on, or back to the far end of the bracket
        is_last = np.abs(step) <= _LAST * np.abs(point)
        bisect &= ~is_last
        middle = 0.5 * (low[active] + high[active])
        target = np.where(value == 0.0, point, np.where(bisect, middle, target))
        root[active] = target
        step_before[active] = target - point
        active = active[~is_last & (np.abs(target - point) > _ENOUGH * np.abs(target))]
    return root


def root_between(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the root of a function between `low` and `high`, where it changes sign, to rounding.

    It may be smaller than the bracket by many powers of ten.
    """
    from scipy.optimize import brentq  # noqa: PLC0415 - takes long to import

    return float(
        brentq(function, low, high, xtol=1e-300, rtol=4.0 * ROUNDING, maxiter=_MOST_STEPS_OF_BRENT)
    )


def _roots_between(
    evaluate: Evaluate, breakpoints: Values, at_breakpoints: Values
) -> tuple[Values, npt.NDArray[np.bool_]]:
    """Return the one root in each interval where a monotone function changes sign, NaN elsewhere.

    `breakpoints` are ascending ends of the intervals, shape (n, k + 1), and `at_breakpoints` the
    values there or their signs. Also return, shape (n, k), whether the function rises there.
    """
    left, right = np.sign(at_breakpoints[:, :-1]), np.sign(at_breakpoints[:, 1:])
    rows, columns = np.nonzero(left * right < 0.0)
    rising = (left < 0.0) & (right > 0.0)
    roots = np.full(left.shape, np.nan)
    roots[rows, columns] = bracketed_newton(
        lambda points, chosen: evaluate(points, rows[chosen]),
        breakpoints[rows, columns],
        breakpoints[rows, columns + 1],
        rising[rows, columns],
    )
    return roots, rising
