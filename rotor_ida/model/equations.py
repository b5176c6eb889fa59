"""The rotor as a first-order system, in the rotating frame.

The state is ``(x, y, vx, vy)``: displacement and velocity. In the rotating frame the two vectors
are given on axes that rotate with the unbalance,
``Z = z exp(-i omega t)`` and ``W = z' exp(-i omega t)``; there the system is autonomous and
a synchronous whirl is an equilibrium.

References
----------
.. [1] "Analytical Nonlinear Response for a Rotor with the Hertz Contact and Clearance",
   Mechanika 25(6), 2019, eqs (10), (12) and (13).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.model.contact import (
    HERTZ_EXPONENT,
    contact_potential,
    damping_factor,
    force_over_radius,
    stiffness,
)
from rotor_ida.model.forces import Moment, accelerations, turned_rates
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.symbols import Dual, variables


def push_over_radius(state: Sequence[float], rotor: Rotor) -> float:
    """Return the normal force over the radius, ``N/|z|`` [1], in either frame; never tensile.

    Examples
    --------
    >>> machine = Rotor(omega=2.0, zeta=0.1, delta0=0.5, contact_damping=0.5)
    >>> push_over_radius((1.5, 0.0, 1.0, 0.0), machine), push_over_radius((1.5, 0, -3, 0), machine)
    (1.0, 0.0)
    """
    x, y, vx, vy = state
    radius = math.hypot(x, y)
    secant = force_over_radius(radius, rotor.delta0, rotor.contact_exponent)
    if rotor.contact_damping == 0.0 or secant == 0.0:
        return secant
    approach = (x * vx + y * vy) / radius
    return secant * max(0.0, float(damping_factor(approach, rotor.contact_damping)))


def rotating_field(state: npt.ArrayLike, rotor: Rotor, time: float = 0.0) -> Values:
    """Return the rate of change of the state in the rotating frame, shape (4,) [dimensionless].

    A load rotates in this frame; `time` gives its direction.

    Notes
    -----
    ``Z' = W - i omega Z`` and ``W' = omega**2 - (2 zeta + i omega) W - f(|Z|) Z/|Z|``,
    which is eq. (10) of the paper times ``exp(-i omega t)``.

    Examples
    --------
    A contact-free whirl without damping is an equilibrium of amplitude one:

    >>> rotating_field((-1.0, 0.0, 0.0, -2.0), Rotor(omega=2.0, zeta=0.0, delta0=1.5)) + 0.0
    array([0., 0., 0., 0.])
    """
    x, y, vx, vy = np.asarray(state, dtype=np.float64).tolist()
    secant = push_over_radius((x, y, vx, vy), rotor)
    rates = np.array(_rates((x, y, vx, vy), secant, rotor))
    if rotor.load > 0.0 and time != 0.0:
        angle = rotor.omega * time
        rates[2:] += rotor.load * np.array([-math.sin(angle), 1.0 - math.cos(angle)])
    return rates


def rotating_jacobian(state: npt.ArrayLike, rotor: Rotor) -> Values:
    """Return the derivative of `rotating_field` by the state, shape (4, 4) [dimensionless].

    Its eigenvalues at a synchronous whirl are those of the whirl.

    Examples
    --------
    >>> rotating_jacobian((0.0, 0.0, 0.0, 0.0), Rotor(omega=2.0, zeta=0.5, delta0=1.0))[2] + 0.0
    array([ 0.,  0., -1.,  2.])
    """
    values = np.asarray(state, dtype=np.float64).tolist()
    radius, exponent = math.hypot(values[0], values[1]), rotor.contact_exponent
    secant, slope = force_over_radius(radius, rotor.delta0, exponent), (0.0, 0.0)
    if radius > 0.0:
        # not over radius**2, which may be 0
        more = (stiffness(radius, rotor.delta0, exponent) - secant) / radius
        slope = more * (values[0] / radius), more * (values[1] / radius)
    restoring = Dual(secant, (*slope, 0.0, 0.0))
    given = variables(values)
    if rotor.contact_damping > 0.0 and secant > 0.0:
        x, y, vx, vy = given
        approach = (x * vx + y * vy) / (x * x + y * y) ** 0.5
        factor = damping_factor(approach, rotor.contact_damping)
        restoring = restoring * factor if factor.value > 0.0 else restoring * 0.0
    return np.array([rate.parts for rate in _rates(given, restoring, rotor)])


def _rates(state: Sequence[Any], secant: Any, rotor: Rotor) -> list[Any]:
    """Return the rates of a state on rotating axes; `secant` is f/|z|."""
    x, y, vx, vy = state
    at = Moment((x, y), (vx, vy), (x, y), (1.0, 0.0), (0.0, -1.0))
    return turned_rates((x, y), (vx, vy), accelerations(at, secant, rotor), rotor.omega)


def rotated(states: npt.ArrayLike, angle: npt.ArrayLike) -> Values:
    """Rotate displacement and velocity of each state by `angle`.

    With ``angle = -omega t`` states go from the fixed to the rotating frame, and with
    ``+omega t`` back.

    Parameters
    ----------
    states : array_like, shape (..., 4)
        States ``(x, y, vx, vy)`` [dimensionless].
    angle : array_like, shape (...)
        Angle [rad].

    Returns
    -------
    ndarray, shape (..., 4)
        The rotated states [dimensionless].

    Examples
    --------
    >>> rotated((1.0, 0.0, 0.0, 2.0), 0.0)
    array([1., 0., 0., 2.])
    """
    given = np.asarray(states, dtype=np.float64)
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y, vx, vy = given[..., 0], given[..., 1], given[..., 2], given[..., 3]
    shape = np.broadcast_shapes(given.shape[:-1], np.shape(angle))
    rows = np.empty((*shape, 4))
    rows[..., 0], rows[..., 1] = cosine * x - sine * y, sine * x + cosine * y
    rows[..., 2], rows[..., 3] = cosine * vx - sine * vy, sine * vx + cosine * vy
    return rows


def energy(
    states: npt.ArrayLike,
    delta0: float,
    *,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
    load: float = 0.0,
) -> Values:
    """Return the energy, ``|z'|**2/2 + kappa |z|**2/2 + V(|z|) + gamma y`` [dimensionless].

    Parameters
    ----------
    states : array_like, shape (..., 4)
        States ``(x, y, vx, vy)`` [dimensionless], in either frame, or under a load in the fixed
        frame.
    delta0 : float
        Radial clearance [dimensionless].
    shaft_stiffness, contact_exponent, load : float
        As in `Rotor` [dimensionless]; default: the paper's rotor, with energy ``|z'|**2/2 +
        V(|z|)``.

    Returns
    -------
    ndarray, shape (...)
        The energy [dimensionless]. It is conserved at ``omega = zeta = 0`` without contact damping.

    References
    ----------
    Eq. (13) of the paper, Mechanika 25(6), 2019, which prints |z| for |z'|.

    Examples
    --------
    >>> float(energy((1.5, 0.0, 0.0, 2.0), 0.5))
    2.4
    >>> float(energy((1.5, 0.0, 0.0, 2.0), 0.5, shaft_stiffness=2.0))
    4.65
    """
    x, y, vx, vy = np.moveaxis(np.asarray(states, dtype=np.float64), -1, 0)
    kinetic: Values = 0.5 * (vx**2 + vy**2)
    whole: Values = kinetic + contact_potential(np.hypot(x, y), delta0, contact_exponent)
    if shaft_stiffness > 0.0:
        whole = np.asarray(whole + 0.5 * shaft_stiffness * (x**2 + y**2))
    if load > 0.0:
        whole = np.asarray(whole + load * y)
    return whole
