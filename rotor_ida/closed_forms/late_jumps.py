"""Late jumps: how far a run-up or run-down passes a fold before the rotor leaves the whirl.

Near a fold all motion on the rotating axes decays fast, except in one direction. Along it the
amplitude ``A = A_fold + x`` obeys [1]_

    x' = alpha (omega - omega_fold) + b x**2 + e (omega - omega_fold) x + c x**3 + ...

whose coefficients are known exactly. The slope of the right-hand side is the small eigenvalue of
the whirl, ``-D/a1 - a2 D**2/a1**3 - ...``, where D is the determinant and
``L**4 + a3 L**3 + a2 L**2 + a1 L + D`` is the characteristic polynomial. The right-hand side
vanishes on the response curve ``P(A, omega) = 0``, which has ``dP/dA = 2 A D``. So

    b = -(dD/dA)/(2 a1),    alpha = -(dP/domega)/(2 A a1),

and with ``lambda_2 x**2`` of the eigenvalue and ``d_3 x**3`` of the speed along the curve
``c = (lambda_2 + alpha d_3)/2``.

References
----------
.. [1] N. Berglund, B. Gentz, "Noise-Induced Phenomena in Slow-Fast Dynamical Systems", Springer,
   2006, section 2.2.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import ROUNDING, Values
from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_distinct, is_scalar
from rotor_ida.closed_forms.folds import ALL_SPEEDS, RANGES, folds_of
from rotor_ida.closed_forms.restoring_law import stiffnesses
from rotor_ida.closed_forms.rotor_columns import RotorColumns, whirls_asked
from rotor_ida.closed_forms.stability import eigenvalues_of
from rotor_ida.errors import InputError
from rotor_ida.model.contact import HERTZ_EXPONENT, contact_force
from rotor_ida.model.parameters import ALL_PARAMETERS, Parameters
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import labelled, spread

# The solution of ``x' = t + x**2`` that begins on the whirl is at infinity at this time.
AIRY = 2.338107410459767  # the first zero of Ai(-t)
# Largest relative change of a coefficient when amplitude or speed is rounded otherwise.
UNSURE = 0.01


def late_jumps(
    rotor: Rotor | None = None,
    *,
    rate: npt.ArrayLike,
    **varied: Unpack[Parameters],
) -> xr.Dataset:
    """Compute the speed at which a slow run-up or run-down jumps, beyond each fold.

    Parameters
    ----------
    rotor, **varied
        As for `folds`.
    rate : float or sequence of float
        Absolute rate of change of the speed [dimensionless]; the direction follows from the fold.

    Returns
    -------
    Dataset
        The variables of `folds`, and on the same dimensions ``fold_drift``, ``fold_curvature`` and
        ``fold_remainder``, the coefficients alpha, b and K of the Notes [dimensionless], and
        ``fold_passage``, the direction of speed that passes the fold (a flag: up, down, or none if
        no stable whirl leads to it). Also ``jump_omega``, the predicted speed of the jump
        [dimensionless], on ``rate`` too if that is a sequence; NaN if it is not above zero.
        Coefficients are NaN, without a direction, if rounding of amplitude and speed alone changes
        them by over 1 %, as with damping of 1e-9. Without damping they are not finite.

    Raises
    ------
    InputError
        As `folds`, or if a rate is not positive.

    Notes
    -----
    With ``A' = alpha (omega - omega_fold) + b (A - A_fold)**2`` the speed of the jump lies beyond
    that of the fold by ``2.33811 rate**(2/3)/|alpha b|**(1/3)``, where -2.33811 is the first root
    of Airy's function. This is the limit of a slow rate. The remainder is
    ``rate (K ln(1/rate) + C)``, where ``K = -c/(3 b**2)`` and C depends on the definition of a
    jump.

    References
    ----------
    R. Haberman, "Slowly varying jump and transition phenomena associated with algebraic bifurcation
    problems", SIAM Journal on Applied Mathematics 37, 1979.

    Examples
    --------
    >>> found = late_jumps(rate=[1e-4, 1e-5], zeta=0.07, delta0=0.0)
    >>> found.fold_omega.values.ravel().round(4), found.fold_passage.values.ravel()
    (array([1.5978, 1.9328]), array([-1,  1], dtype=int8))
    >>> found.jump_omega.sel(rate=1e-4).values.ravel().round(4)
    array([1.5915, 1.9482])
    """
    rates = check_distinct("rate", check_axis("rate", rate, largest=LARGEST_NUMBER))
    if not (rates > 0.0).all():
        raise InputError(
            "{name} must be positive, got {value}", name="rate", value=float(rates.min())
        )
    found = folds_of(whirls_asked(late_jumps, rotor, varied, RANGES, ALL_SPEEDS))
    speeds = found["fold_omega"]
    dims, exists = speeds.dims, np.isfinite(speeds.values)
    given = {"omega": speeds.values, **spread(found, ALL_PARAMETERS, speeds)}
    rotors = RotorColumns.of(given)[exists]
    amplitude = found["fold_amplitude"].values[exists]
    none = (np.empty(0),) * 3, np.empty(0, np.bool_)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        terms, leads = _resolved_coefficients(amplitude, rotors) if amplitude.size else none
    drift, curvature, _ = terms
    passage = np.where(leads, np.sign(drift * curvature), 0.0)
    names = ("fold_drift", "fold_curvature", "fold_remainder")
    columns = {
        name: _placed(values, exists, np.nan) for name, values in zip(names, terms, strict=True)
    }
    columns["fold_passage"] = _placed(passage, exists, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = AIRY / np.cbrt(columns["fold_drift"] * columns["fold_curvature"])
    scale = np.where(columns["fold_passage"] != 0.0, scale, np.nan)
    delay = rates.reshape(-1, *(1,) * scale.ndim) ** (2.0 / 3.0) * scale
    jumped = speeds.values + delay
    jumped[jumped <= 0.0] = np.nan
    columns["fold_passage"] = columns["fold_passage"].astype(np.int8)
    by_rate = () if is_scalar("rate", rate) else ("rate",)
    if not by_rate:
        rates, jumped = rates[0], jumped[0]
    found = found.assign({name: labelled(name, dims, each) for name, each in columns.items()})
    found["jump_omega"] = labelled("jump_omega", (*by_rate, *dims), jumped)
    return found.assign_coords(rate=labelled("rate", by_rate, rates)).assign_attrs(
        title="Late jumps at the folds of the synchronous whirls of a rotor with contact",
        result_kind="late_jumps",
        source="rotor_ida closed forms: the motion along the centre manifold of each fold",
        references="R. Haberman, SIAM Journal on Applied Mathematics 37, 1979",
    )


def _resolved_coefficients(
    A: Values, rotors: RotorColumns
) -> tuple[tuple[Values, Values, Values], npt.NDArray[np.bool_]]:
    """Return what `_coefficients` does, with NaN for what doubles do not resolve."""
    terms, leads = _coefficients(A, rotors)
    for sign in (-1.0, 1.0):
        faster = replace(rotors, omega=rotors.omega * (1.0 + sign * ROUNDING))
        for each in (
            _coefficients(A * (1.0 + sign * ROUNDING), rotors),
            _coefficients(A, faster),
        ):
            for values, others in zip(terms, each[0], strict=True):
                values[np.abs(others - values) > UNSURE * np.abs(values)] = np.nan
    alpha, curved, _ = terms
    return terms, leads & ~np.isnan(alpha * curved)


def _coefficients(
    A: Values, rotors: RotorColumns
) -> tuple[tuple[Values, Values, Values], npt.NDArray[np.bool_]]:
    """Return alpha, b and K of each fold, and whether a stable whirl leads to it."""
    omega, zeta, delta0, kappa = rotors.omega, rotors.zeta, rotors.delta0, rotors.shaft_stiffness
    exponent, damping, mu = rotors.contact_exponent, rotors.contact_damping, rotors.friction
    f, q = contact_force(A, delta0, exponent), omega * omega
    slope, s = stiffnesses(A, delta0, exponent)
    hertz = exponent == HERTZ_EXPONENT
    bend = np.where(hertz, 1.125 / slope, 0.0)  # second and third derivative of f
    third = np.where(hertz, -0.5 * bend / (A - delta0), 0.0)
    s_A = (slope - s) / A
    s_AA = (bend - 2.0 * s_A) / A
    a, b = kappa + slope - q, kappa + s - q
    c_u, c_v = 2.0 * zeta * omega + mu * slope, 2.0 * zeta * omega + mu * s
    # derivatives of D, of P and of a1 by the amplitude and by the speed
    D_A = bend * b + a * s_A + mu * (bend * c_v + c_u * s_A)
    D_AA = third * (b + mu * c_v) + 2.0 * (1.0 + mu * mu) * bend * s_A + s_AA * (a + mu * c_u)
    D_w = 2.0 * zeta * (c_u + c_v) - 2.0 * omega * (a + b)
    P_w = 4.0 * (zeta * A**2 * c_v - omega * A**2 * b - q * omega)
    drag, push = damping * f, b + mu * c_v
    a1 = 2.0 * zeta * (a + b) + 2.0 * omega * (c_u + c_v) + drag * push
    a1_A = 2.0 * (zeta + omega * mu) * (bend + s_A)
    a1_A = a1_A + damping * slope * push + drag * (1.0 + mu * mu) * s_A
    a2 = a + b + 2.0 * zeta * (2.0 * zeta + drag) + 2.0 * omega * (2.0 * omega + mu * drag)
    alpha, curved = -P_w / (2.0 * A * a1), -D_A / (2.0 * a1)
    d_2 = -A * D_A / P_w
    d_3 = -(2.0 * A * D_w * d_2 + (2.0 * D_A + A * D_AA) / 3.0) / P_w
    lambda_2 = (D_A * a1_A - a2 * D_A**2 / a1) / a1**2 - (0.5 * D_AA + D_w * d_2) / a1
    remainder = -(lambda_2 + alpha * d_3) / (6.0 * curved**2)
    growth = eigenvalues_of(A, rotors)
    size = np.abs(growth)
    others = np.where(size > size.min(axis=-1, keepdims=True), growth.real, -np.inf)
    leads = (others.max(axis=-1) < 0.0) & (a1 > 0.0) & np.isfinite(alpha * curved)
    return (alpha, curved, remainder), leads


def _placed(values: Values, exists: npt.NDArray[np.bool_], filler: float) -> Values:
    """Return a table in which the folds that exist have these values."""
    table = np.full(exists.shape, filler)
    table[exists] = values
    return table
