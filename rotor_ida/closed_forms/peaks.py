"""The response curve at given amplitude: the backbone, the two flanks, and the peak."""

from __future__ import annotations

import math
from typing import Unpack

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_nonnegative, check_positive
from rotor_ida.closed_forms.curve_polynomials import CurveEquations, Tip, exact_tips, flanks
from rotor_ida.closed_forms.restoring_law import RestoringLaw, checked_law
from rotor_ida.closed_forms.rotor_columns import RotorColumns, whirls_asked
from rotor_ida.model.contact import HERTZ_EXPONENT, contact_force
from rotor_ida.model.parameters import Parameters
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import labelled_dataset

# With less damping the tip lies beyond the range of doubles.
SMALLEST_DAMPING = 1e-20
_RANGES = dict.fromkeys(("zeta", "friction"), (SMALLEST_DAMPING, LARGEST_NUMBER))


def backbone(
    amplitude: object,
    delta0: float = 0.0,
    *,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
) -> Values:
    """Compute the backbone: the speed of a free circular whirl at each amplitude.

    Parameters
    ----------
    amplitude : float or sequence of float, shape (n,)
        Amplitudes A [dimensionless].
    delta0 : float
        Clearance [dimensionless].
    shaft_stiffness, contact_exponent : float
        As of `Rotor` [dimensionless].

    Returns
    -------
    ndarray, shape (n,)
        ``omega = sqrt(kappa + f(A)/A)`` [dimensionless]; inside the clearance ``sqrt(kappa)``, zero
        without a shaft.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive; if the exponent is
        neither 1.5 nor 1.

    References
    ----------
    Eq. (17) of the paper, Mechanika 25(6), 2019, as a speed.

    Examples
    --------
    >>> backbone([1.0, 16.0])
    array([1., 2.])
    >>> backbone([1.0, 16.0], shaft_stiffness=8.0, contact_exponent=1.0)
    array([3., 3.])
    """
    law = checked_law(delta0, shaft_stiffness, contact_exponent)
    A = check_axis("amplitude", amplitude, largest=LARGEST_NUMBER)
    return np.asarray(np.sqrt(law.stiffness(A)))


def speeds_at_amplitude(
    amplitude: object,
    *,
    zeta: float,
    delta0: float,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
    friction: float = 0.0,
) -> Values:
    """Compute the two speeds at which a contacting whirl has a given amplitude.

    Parameters
    ----------
    amplitude : float or sequence of float, shape (n,)
        Amplitudes A [dimensionless].
    zeta, delta0 : float
        Damping ratio and clearance [dimensionless].
    shaft_stiffness, contact_exponent, friction : float
        As of `Rotor` [dimensionless]; contact damping does not change whirls.

    Returns
    -------
    ndarray, shape (n, 2)
        The slower and the faster speed [dimensionless], on the flanks below and above resonance;
        NaN where the curve has no such point, and inside the clearance.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive; if the exponent is
        neither 1.5 nor 1; if there is friction without clearance, or above zero and below 1e-20.

    Notes
    -----
    With ``q = omega**2`` and ``s = kappa + f(A)/A`` the curve is the quadratic
    ``(A**2 - 1) q**2 + A**2 (4 zeta**2 - 2 s) q + A**2 s**2 = 0``. Unlike the curve at given
    speeds it needs no search, and it has full resolution near the tip, whose amplitude is
    `peak_amplitude`. Below A = 1 there is only the flank below resonance. With friction mu it is a
    quartic in omega, with ``4 mu zeta A f(A) omega + (mu f(A))**2`` added: see `curve_polynomials`.

    References
    ----------
    Eqs (21)-(23) of the paper, Mechanika 25(6), 2019, with the force corrected.

    Examples
    --------
    >>> speeds_at_amplitude([0.5, 2.0], zeta=0.0, delta0=0.0)
    array([[0.48549177,        nan],
           [0.97098354, 1.68179283]])
    """
    damping = check_nonnegative("zeta", zeta, LARGEST_NUMBER)
    A = check_axis("amplitude", amplitude, largest=LARGEST_NUMBER)
    law = checked_law(delta0, shaft_stiffness, contact_exponent, friction, _RANGES)
    slower, faster = np.full((2, A.size), np.nan)
    touching = np.nonzero(law.delta0 < A)[0]
    radii = A[touching]
    if law.friction > 0.0:
        slow, fast, exists = flanks(radii, CurveEquations(damping, law))
    else:
        s, m = law.stiffness(radii), 4.0 * damping**2
        slow, fast = speeds_of_stiffness(radii, m, s)
        exists = (_discriminant(radii, s, m) >= 0.0) & ((radii < 1.0) | (2.0 * s > m))
    slower[touching] = np.where(exists, slow, np.nan)
    faster[touching] = np.where(exists & (radii > 1.0), fast, np.nan)
    return np.stack([slower, faster], axis=1)


def _discriminant(A: Values, s: Values, m: float) -> Values:
    """Return the discriminant of the quadratic in q over ``4 A**4``."""
    # as a product: near the tip the sum would cancel
    rest = np.sqrt(np.maximum((A - 1.0) * (A + 1.0), 0.0))
    lean = np.divide(2.0 * s, A, out=np.zeros_like(A), where=A > 0.0) - m * A
    product = (lean - m * rest) * (lean + m * rest)
    return np.where(A >= 1.0, product, lean**2 + m**2 * (1.0 - A) * (1.0 + A))


def speeds_of_stiffness(A: Values, m: float, s: Values) -> tuple[Values, Values]:
    """Return the slower and the faster speed at amplitudes that the curve without friction has.

    ``m`` is ``4 zeta**2`` and ``s`` the force over radius, of contact and shaft together.
    """
    middle = 2.0 * s - m
    root = np.sqrt(np.maximum(_discriminant(A, s, m), 0.0))
    # the slower speed is 2 s**2/(middle + root); written so that nothing cancels
    total = middle + root
    below_one = 2.0 * (1.0 - A) * (1.0 + A)
    conjugate = np.divide(A * A * (root - middle), below_one, out=np.zeros_like(A), where=A < 1.0)
    direct = np.divide(2.0 * s * s, total, out=np.zeros_like(A), where=total > 0.0)
    slower = np.where(middle > 0.0, direct, conjugate)
    faster = np.divide(A * A * total, -below_one, out=np.full_like(A, np.inf), where=A > 1.0)
    return np.sqrt(slower), np.sqrt(np.maximum(faster, 0.0))


def peak_amplitude(
    *,
    zeta: float,
    delta0: float,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
    friction: float = 0.0,
) -> float:
    """Compute the largest amplitude on the response curve of contacting whirls.

    Parameters
    ----------
    zeta, delta0 : float
        Damping ratio and clearance [dimensionless]. Without friction zeta must be above zero, as
        the undamped curve has no tip.
    shaft_stiffness, contact_exponent, friction : float
        As of `Rotor` [dimensionless].

    Returns
    -------
    float
        Amplitude of the tip [dimensionless]; NaN if the damping is so strong that the amplitude
        stays below 1 and only approaches it at high speed.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, or `zeta` is zero and
        there is no friction, or there is friction without clearance, or below 1e-20.

    Notes
    -----
    At the tip the two speeds of `speeds_at_amplitude` coincide:
    ``h(A) = (A - delta0)**1.5 / (A**2 (A + sqrt(A**2 - 1))) = 2 zeta**2``. With friction the
    discriminant of a quartic vanishes. Both are polynomials, whose roots are isolated in exact
    arithmetic: see `curve_polynomials`. Friction bounds the amplitude even without damping; without
    a shaft the bound is ``sqrt(1 + 1/mu**2)``.

    References
    ----------
    Eqs (21)-(23) of the paper, Mechanika 25(6), 2019, with the force corrected.

    Examples
    --------
    >>> tip = peak_amplitude(zeta=0.07, delta0=0.0)
    >>> round(tip, 6), speeds_at_amplitude(tip - 1e-9, zeta=0.07, delta0=0.0).round(3).tolist()
    (13.7..., [[1.9..., 1.9...]])
    """
    law = checked_law(delta0, shaft_stiffness, contact_exponent, friction, _RANGES)
    check = check_nonnegative if law.friction > 0.0 else check_positive
    damping = check_axis(
        "zeta", check("zeta", zeta), smallest=SMALLEST_DAMPING, largest=LARGEST_NUMBER
    )
    return _peak(damping.item(), law).amplitude


def peaks(rotor: Rotor | None = None, **varied: Unpack[Parameters]) -> xr.Dataset:
    """Compute the largest contacting whirl for each damping and clearance.

    Parameters
    ----------
    rotor : Rotor, optional
        The rotor. Without it, ``zeta`` and ``delta0`` must be given.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [dimensionless], in place of those of `rotor`, as for `folds`.
        The damping ratio must be above 0 without friction.

    Returns
    -------
    Dataset
        On (zeta, delta0) and any others that are arrays: ``peak_amplitude``, ``peak_omega`` and
        ``peak_contact_force`` [dimensionless]; NaN if the damping allows no peak.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, or a damping is zero
        without friction; if an exponent is neither 1.5 nor 1; if there is friction without
        clearance, or above zero and below 1e-20.

    Notes
    -----
    At the tip the quadratic of `speeds_at_amplitude` has one root,
    ``omega**2 = A**2 (s - 2 zeta**2)/(A**2 - 1)`` with ``s = kappa + f(A)/A``. Contact damping
    does not change it; for friction see `peak_amplitude`.

    References
    ----------
    Section 4.2.1 and Fig. 10 of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> found = peaks(zeta=0.07, delta0=[0.0, 2.0])
    >>> found.peak_amplitude.values.round(3), found.peak_contact_force.values.round(2)
    (array([[13.768, 11.346]]), array([[51.09, 28.57]]))
    """
    asked = whirls_asked(peaks, rotor, varied, _RANGES, {"omega": "all speeds are searched"})
    grid = RotorColumns.of(asked.columns)
    for damping, mu in zip(grid.zeta.tolist(), grid.friction.tolist(), strict=True):
        if mu == 0.0:
            check_positive("zeta", damping)
    found = [_peak(*row) for row in zip(grid.zeta.tolist(), grid.laws, strict=True)]
    amplitude, omega = np.transpose(found)
    columns = {
        "peak_amplitude": amplitude,
        "peak_omega": omega,
        "peak_contact_force": contact_force(amplitude, grid.delta0, grid.contact_exponent),
    }
    contact = "contact" if asked.optional else "Hertz contact"
    return labelled_dataset(
        f"Largest contacting whirls of a rotor with {contact} and clearance",
        {name: (asked.dims, each.reshape(asked.shape)) for name, each in columns.items()},
        asked.coordinates,
        kind="peaks",
    )


def _peak(zeta: float, law: RestoringLaw) -> Tip:
    """Return the highest tip; NaN where there is none."""
    return max(exact_tips(CurveEquations(zeta, law)), default=Tip(math.nan, math.nan))
