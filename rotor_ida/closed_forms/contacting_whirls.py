"""Every synchronous whirl that touches the ring, with none lost and none invented.

With ``u = sqrt(A - delta0)`` and ``q = omega**2`` a contacting whirl is a root u > 0 of

    P(u) = F**2 - q**2 + 4 zeta**2 q A**2,    A = delta0 + u**2,    F = u**3 - q A.

It is a polynomial because the Hertz exponent is 3/2, which makes the force u**3.
Between two neighbouring extrema of P there is at most one root, so the extrema are found
first, from those of the derivative, and so on down to a quadratic. What decides whether a
root exists is the sign of P at an extremum, and that is computed with 32 digits. As
``dP/du = 4 u A D``, where D is the determinant that decides stability, a whirl is stable
exactly where P rises through zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.closed_forms.bracketing import bracketed_newton, roots_between
from rotor_ida.closed_forms.double_double import DoubleDouble

Values = npt.NDArray[np.float64]
Rows = npt.NDArray[np.int_]


@dataclass(frozen=True, slots=True)
class ContactingWhirls:
    """The contacting whirls of many rotors, in order of amplitude.

    Parameters
    ----------
    amplitude : ndarray, shape (n, 5)
        Amplitudes [1]; NaN where a rotor has fewer.
    phase_lag : ndarray, shape (n, 5)
        Phase lags [rad].
    determinant : ndarray, shape (n, 5)
        Stability determinant D [1]: positive where the whirl does not run away.
    contact_free : ndarray of bool, shape (n,)
        Whether the whirl that does not reach into the ring exists.
    """

    amplitude: Values
    phase_lag: Values
    determinant: Values
    contact_free: npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class _Equation:
    """The polynomial P of many rotors, with its parameters to 32 digits."""

    q: DoubleDouble
    damping: DoubleDouble  # 4 zeta**2 q
    delta0: DoubleDouble

    def precise(self, u: DoubleDouble, rows: Rows) -> tuple[Values, Values, Values]:
        """Return P, its slope and F at `u`; P and F come from 32-digit arithmetic."""
        q, damping = self.q[rows], self.damping[rows]
        square = u * u
        amplitude = self.delta0[rows] + square
        force_excess = square * u - q * amplitude
        value = (force_excess * force_excess - q * q) + damping * (amplitude * amplitude)
        slope = 2.0 * force_excess.high * (3.0 * u.high - 2.0 * q.high) * u.high
        slope += 4.0 * damping.high * amplitude.high * u.high
        return value.high, slope, force_excess.high

    def plain(self, u: Values, rows: Rows) -> tuple[Values, Values]:
        """Return P and its slope in plain doubles."""
        q, damping = self.q.high[rows], self.damping.high[rows]
        amplitude = self.delta0.high[rows] + u * u
        force_excess = u * u * u - q * amplitude
        value = force_excess * force_excess - q * q + damping * amplitude * amplitude
        slope = 2.0 * force_excess * (3.0 * u - 2.0 * q) * u + 4.0 * damping * amplitude * u
        return value, slope


def contacting_whirls(omega: Values, zeta: Values, delta0: Values) -> ContactingWhirls:
    """Return all whirls in contact of rotors with ``omega > 0``.

    Parameters
    ----------
    omega, zeta, delta0 : ndarray, shape (n,)
        Spin speed, damping ratio and clearance [1].

    Returns
    -------
    ContactingWhirls
        Amplitudes, phase lags and determinants, shape (n, 5).

    Notes
    -----
    ``P(0) = q**2 ((delta0/A_f)**2 - 1)``: its sign says whether the contact-free whirl of
    amplitude A_f fits into the clearance, so that exactly one of the two kinds appears or
    vanishes there.

    References
    ----------
    Eqs (21)-(23) of the paper, Mechanika 25(6), 2019, with the Hertz force in its right form.

    Examples
    --------
    >>> import numpy as np
    >>> at = contacting_whirls(np.array([1.7]), np.array([0.07]), np.array([0.0]))
    >>> at.amplitude[0, :3].round(6)
    array([1.879631, 6.193211, 9.487207])
    """
    q = DoubleDouble.of(omega) * DoubleDouble.of(omega)
    four_zeta_squared = DoubleDouble.of(2.0 * zeta) * DoubleDouble.of(2.0 * zeta)
    clearance = DoubleDouble.of(delta0)
    equation = _Equation(q, four_zeta_squared * q, clearance)
    contact_free = (clearance * clearance * (q + four_zeta_squared) - q).high >= 0.0

    breakpoints = _extrema(q.high, q.high * (q.high + four_zeta_squared.high), delta0)
    signs = _signs(equation, breakpoints, contact_free)
    estimate, rising = roots_between(equation.plain, breakpoints, signs)
    u = _polished(equation, breakpoints, estimate, rising)

    rows, columns = np.nonzero(np.isfinite(estimate))
    _, slope, force_excess = equation.precise(u, rows)
    amplitude = (clearance[rows] + u * u).high
    lag = np.arctan2(2.0 * zeta[rows] * omega[rows] * amplitude, force_excess)
    # The direction in which P crosses zero is certain; the sign of a rounded D near 0 is not.
    size = np.maximum(np.abs(slope) / (4.0 * u.high * amplitude), np.finfo(np.float64).tiny)
    determinant = np.where(rising[rows, columns], size, -size)
    shape = estimate.shape
    return ContactingWhirls(
        amplitude=_packed(amplitude, rows, shape),
        phase_lag=_packed(lag, rows, shape),
        determinant=_packed(determinant, rows, shape),
        contact_free=contact_free,
    )


def _extrema(q: Values, stiffness: Values, delta0: Values) -> Values:
    """Return 0, the extrema of P in ascending order and a bound on its roots, shape (n, 6).

    ``stiffness`` is ``q (q + 4 zeta**2)``. Extrema that do not exist repeat the bound.
    """
    bound = 1.000001 * (q + np.cbrt(q * (delta0 + 1.0)))
    quartic = (
        2.0 * delta0 * stiffness,
        -3.0 * q * delta0,
        2.0 * stiffness,
        -5.0 * q,
        3.0 + 0.0 * q,
    )
    cubic = _derivative(quartic)
    quadratic = _derivative(cubic)
    root = np.sqrt(np.maximum(quadratic[1] ** 2 - 4.0 * quadratic[2] * quadratic[0], 0.0))
    larger = -quadratic[1] + root
    smaller = 2.0 * quadratic[0] / larger
    points = np.stack([smaller, larger / (2.0 * quadratic[2])], axis=1)
    for polynomial in (cubic, quartic):
        points = _roots_of(polynomial, _bounded(points, bound))
    return _bounded(points, bound)


def _bounded(points: Values, bound: Values) -> Values:
    """Return 0, `points` and `bound` in order; points that are missing repeat the bound."""
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
    roots, _ = roots_between(evaluate, breakpoints, np.stack(at_breakpoints, axis=1))
    return roots


def _signs(equation: _Equation, breakpoints: Values, contact_free: npt.NDArray[np.bool_]) -> Values:
    """Return the sign of P at 0, at its extrema and at the bound (where it is positive)."""
    signs = np.ones_like(breakpoints)
    signs[:, 0] = np.where(contact_free, 1.0, -1.0)
    rows, columns = np.nonzero(breakpoints[:, 1:-1] < breakpoints[:, -1:])
    points = DoubleDouble.of(breakpoints[rows, columns + 1])
    signs[rows, columns + 1] = np.sign(equation.precise(points, rows)[0])
    return signs


def _polished(
    equation: _Equation,
    breakpoints: Values,
    estimate: Values,
    rising: npt.NDArray[np.bool_],
) -> DoubleDouble:
    """Return the roots to 32-digit residuals, the last Newton step kept as the low part."""
    rows, columns = np.nonzero(np.isfinite(estimate))

    def evaluate(u: Values, chosen: Rows) -> tuple[Values, Values]:
        value, slope, _ = equation.precise(DoubleDouble.of(u), rows[chosen])
        return value, slope

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


def _packed(values: Values, rows: Rows, shape: tuple[int, ...]) -> Values:
    """Return the `values` of each row moved to its front, NaN behind them."""
    packed = np.full(shape, np.nan)
    first = np.searchsorted(rows, rows)  # rows are sorted: how many came before this row
    packed[rows, np.arange(rows.size) - first] = values
    return packed
