"""Sommerfeld's curve: the torque of a synchronous whirl at each speed, and its driven stability.

Damping and friction brake the spin of a rotor in synchronous whirl by

    torque = 2 zeta omega A**2 + mu f(A) (A + rho).

A drive whose torque falls with the speed, ``tau0 - slope speed``, balances this where both are
equal. Amplitude and speed are then free to change together. On the axes that rotate with the
unbalance, whirl and speed are an equilibrium of five equations, four of the motion and one of the
spin [1]_. It is stable if all five eigenvalues decay. One of them passes through 0 where the slope
of the curve is minus that of the drive, and there the speed jumps: Sommerfeld's effect [2]_.

References
----------
.. [1] V. O. Kononenko, "Vibrating Systems with a Limited Power Supply", Iliffe, 1969.
.. [2] A. Sommerfeld, "Beiträge zum dynamischen Ausbau der Festigkeitslehre", Zeitschrift des
   Vereines deutscher Ingenieure 46, 1902.
"""

from __future__ import annotations

from typing import NamedTuple, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    LARGEST_NUMBER,
    check_between,
    check_nonnegative,
)
from rotor_ida.closed_forms.folds import RANGES
from rotor_ida.closed_forms.response_curve import BETWEEN_LIMITS, curve_over_speed
from rotor_ida.closed_forms.restoring_law import stiffnesses
from rotor_ida.closed_forms.rotor_columns import RotorColumns, whirls_asked
from rotor_ida.closed_forms.stability import checked_whirls
from rotor_ida.errors import InputError
from rotor_ida.model.contact import contact_force
from rotor_ida.model.parameters import ALL_PARAMETERS, Parameters
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import STABILITY, labelled, spread

SMALLEST_INERTIA, LARGEST_INERTIA = 1e-12, 1e15
# Below this fraction of the largest eigenvalue a growth rate is rounding.
ROUNDED = 1e-12


def whirl_torque(
    amplitude: npt.ArrayLike,
    *,
    omega: npt.ArrayLike,
    zeta: npt.ArrayLike,
    delta0: npt.ArrayLike,
    contact_exponent: float = 1.5,
    friction: npt.ArrayLike = 0.0,
    disc_radius: npt.ArrayLike | None = None,
) -> Values:
    """Compute the torque that maintains the speed of a rotor on a synchronous whirl.

    Parameters
    ----------
    amplitude : array_like
        Amplitude A of the whirl [dimensionless].
    omega, zeta, delta0, contact_exponent, friction : array_like
        As for `Rotor` [dimensionless]; they broadcast.
    disc_radius : array_like, optional
        Radius rho of the disc [dimensionless], required with friction.

    Returns
    -------
    ndarray
        Torque [dimensionless], in units of mass times eccentricity squared times reference
        frequency squared.

    Raises
    ------
    InputError
        If a value is not a finite real number, or is negative, the exponent is neither 1.5 nor 1,
        or there is friction without a disc radius or clearance.

    Notes
    -----
    ``torque = 2 zeta omega A**2 + mu f(A) (A + rho)``: friction acts at the rim of the disc.
    Neither shaft nor contact damping needs any torque.

    References
    ----------
    A. Sommerfeld, "Beiträge zum dynamischen Ausbau der Festigkeitslehre", Zeitschrift des Vereines
    deutscher Ingenieure 46, 1902.

    Examples
    --------
    >>> whirl_torque(2.0, omega=1.5, zeta=0.1, delta0=1.0)
    array(1.2)
    >>> whirl_torque(2.0, omega=1.5, zeta=0.1, delta0=1.0, friction=0.1, disc_radius=8.0)
    array(2.2)
    """
    every, rotors = checked_whirls(
        amplitude=amplitude, omega=omega, zeta=zeta, delta0=delta0, friction=friction,
        contact_exponent=contact_exponent, disc_radius=0.0 if disc_radius is None else disc_radius,
    )  # fmt: skip
    _check_radius(disc_radius, rotors)
    return _torque(every["amplitude"], rotors, every["disc_radius"])


def _check_radius(disc_radius: object, rotors: RotorColumns) -> None:
    """Refuse friction without a radius."""
    if disc_radius is None and rotors.friction.any():
        raise InputError(
            f"disc_radius must be given with friction {rotors.friction.max().item()!r}, got None"
        )


def _torque(A: Values, rotors: RotorColumns, disc_radius: Values | float) -> Values:
    rubbing = rotors.friction * contact_force(A, rotors.delta0, rotors.contact_exponent)
    return np.asarray(2.0 * rotors.zeta * rotors.omega * A**2 + rubbing * (A + disc_radius))


def sommerfeld_curve(
    rotor: Rotor | None = None,
    *,
    limits: tuple[float, float],
    inertia: float,
    slope: float = 0.0,
    points: int = 200,
    **varied: Unpack[Parameters],
) -> xr.Dataset:
    """Compute the torque of all synchronous whirls over the speed, and their driven stability.

    Parameters
    ----------
    rotor, limits, points, **varied
        As for `response_curve`. The radius of the disc, one number, is required with friction.
    inertia : float
        Moment of inertia about the centre of mass, over mass times eccentricity squared
        [dimensionless], as for `rotor_ida.run_up`.
    slope : float
        Decrease of the drive's torque per unit of speed [dimensionless].

    Returns
    -------
    Dataset
        The variables of `response_curve`, the ``torque`` of the whirl [dimensionless], and
        ``driven_stability`` (a flag), the stability with a free speed; ``stability`` is that at a
        fixed speed. ``inertia`` and ``slope`` are attributes.

    Raises
    ------
    InputError
        As `response_curve`; or if the inertia is not positive, or there is friction without a disc
        radius.

    Notes
    -----
    A motor ``tau0 - slope speed`` can run at the speeds at which its line crosses the curve. Where
    the curve falls more steeply than the line, these are unstable, and the speed jumps. The
    stability depends on all five eigenvalues, so it also shows where whirl and speed begin to
    oscillate together. The contact-free whirl without a shaft, whose centre may lie anywhere, is
    neutral where the speed is stable.

    References
    ----------
    A. Sommerfeld, "Beiträge zum dynamischen Ausbau der Festigkeitslehre", Zeitschrift des Vereines
    deutscher Ingenieure 46, 1902; V. O. Kononenko, "Vibrating Systems with a Limited Power Supply",
    Iliffe, 1969.

    Examples
    --------
    >>> from rotor_ida import decode_flags
    >>> curve = sommerfeld_curve(zeta=0.07, delta0=0.8, limits=(0.2, 3.0), inertia=20.0, slope=0.3)
    >>> drive = curve.torque + 0.3 * curve.omega
    >>> stable = decode_flags(curve.driven_stability) == "stable"
    >>> round(float(drive.where(stable).max()), 1)
    42.8
    """
    moment = check_between("inertia", inertia, SMALLEST_INERTIA, LARGEST_INERTIA)
    falling = check_nonnegative("slope", slope, LARGEST_NUMBER)
    asked = whirls_asked(sommerfeld_curve, rotor, varied, RANGES, BETWEEN_LIMITS)
    disc_radius = varied.get("disc_radius", None if rotor is None else rotor.disc_radius)
    rho = 0.0
    if disc_radius is not None:
        rho = check_nonnegative("disc_radius", disc_radius, LARGEST_NUMBER)
    curve = curve_over_speed(asked, limits, points)
    dims = curve["amplitude"].dims
    rotors = RotorColumns.of(spread(curve, ALL_PARAMETERS, curve["amplitude"]))
    _check_radius(disc_radius, rotors)
    A, lag = curve["amplitude"].values, curve["phase_lag"].values
    torque = _torque(A, rotors, rho)
    exists, free = curve["piece"].values >= 0, curve["in_contact"].values == 0
    drive = _Drive(rho, falling, moment)
    jacobian = _jacobian(A[exists], lag[exists], free[exists], rotors[exists], drive)
    stability = np.full(A.shape, STABILITY["absent"], dtype=np.int8)
    stability[exists] = _stability(jacobian)
    return curve.assign(
        torque=labelled("torque", dims, torque),
        driven_stability=labelled("driven_stability", dims, stability),
    ).assign_attrs(
        title="Torque of the synchronous whirls of a rotor with contact and clearance",
        result_kind="torque_curve",
        source="rotor_ida closed forms: the power dissipated by damping and friction on each whirl",
        references="A. Sommerfeld, Zeitschrift des Vereines deutscher Ingenieure 46, 1902",
        inertia=moment, slope=falling,
    )  # fmt: skip


def _stability(jacobian: Values) -> npt.NDArray[np.int8]:
    """Return flags of the stability, from Jacobians of shape (n, 5, 5)."""
    roots = np.linalg.eigvals(jacobian) if len(jacobian) else np.zeros((0, 5))
    growth, size = roots.real.max(axis=-1), np.abs(roots).max(axis=-1)
    words = np.where(growth > ROUNDED * size, STABILITY["unstable"], STABILITY["neutral"])
    return np.where(growth < -ROUNDED * size, STABILITY["stable"], words).astype(np.int8)


class _Drive(NamedTuple):
    """Radius of the disc, decrease of the drive's torque with the speed, and inertia [1]."""

    disc_radius: float
    slope: float
    inertia: float


def _jacobian(
    A: Values, lag: Values, free: npt.NDArray[np.bool_], rotors: RotorColumns, drive: _Drive
) -> Values:
    """Return the derivatives of the rates of radius, displacement across, velocities and speed.

    Displacement and velocity are resolved along the radius of the whirl and across it, on axes that
    rotate with the unbalance. The velocity is relative to the fixed axes.
    """
    rho, slope, inertia = drive
    omega, zeta, delta0, kappa = rotors.omega, rotors.zeta, rotors.delta0, rotors.shaft_stiffness
    exponent, damping, mu = rotors.contact_exponent, rotors.contact_damping, rotors.friction
    steep, secant = stiffnesses(A, delta0, exponent)
    f = np.where(free, 0.0, contact_force(A, delta0, exponent))
    steep, secant = np.where(free, 0.0, steep), np.where(free, 0.0, secant)
    cos, sin, none = np.cos(lag), np.sin(lag), np.zeros_like(A)
    # of N, which also depends on the radial velocity, p + omega t
    normal = np.stack([steep, damping * f * omega, damping * f, none, none])
    along = np.stack([kappa + none, -mu * secant, 2.0 * zeta, none, none]) + normal
    across = np.stack([none, kappa + secant, none, 2.0 * zeta, none]) + mu * normal
    # the moment of damping, shaft and N, and that of T
    at_centre = across - mu * normal, along + np.stack([none, mu * secant, *3 * (none,)])
    moment = sin * at_centre[1] - cos * at_centre[0] + mu * (rho - cos) * normal
    moment[1] -= mu * secant * sin
    moment[4] += slope
    faster = -moment / inertia
    rates = np.empty((5, 5, A.size))
    rates[0] = [none, omega, none + 1.0, none, none]
    rates[1] = [-omega, none, none, none + 1.0, -A]
    rates[2] = -along + sin * faster
    rates[2][3] += omega
    rates[2][4] += omega * (A + 2.0 * cos)
    rates[3] = -across - cos * faster
    rates[3][2] -= omega
    rates[3][4] += 2.0 * omega * sin
    rates[4] = faster
    return np.moveaxis(rates, -1, 0)
