"""The contact law: the force of the stator on a rotor at distance r from the bearing axis.

With the indentation ``d = r - delta0 > 0``, the radial velocity d' and the slip speed v_s:

- the normal force is ``N = d**n (1 + c d')``, with n = 3/2 by Hertz or 1, and the contact damping c
  (`normal_force`). It is not clipped: where ``1 + c d'`` falls to 0 the contact is released, an
  event, and from there on it is loose, without force (`damped`);
- surfaces that slide pull on each other by ``T = mu N sigma``, where sigma is 1 if the disc slides
  forwards, as the rotor turns it, and -1 if backwards (`drag_of`);
- a disc that rolls (v_s = 0) is held by the force that keeps v_s at 0, as long as that is no larger
  than ``mu N``: `hold_of_rolling` in `rotor_ida.model.forces`, `grip_and_hold` in
  `rotor_ida.model.rates`, and for the contacts of rotor systems `rotor_ida.model.element`.

The first section states the law by ``q = sqrt(d)``, in which it is analytic through q = 0. It is
what the core integrates: `rotor_ida.model.writing` runs these functions over symbols and writes
them to C in three ways: inlined into fields and series of ``core/derived*.c``, through
`rotor_ida.model.modes` for one disc, and of ``core/derived_element.h``, through
`rotor_ida.model.element` for the contacts of rotor systems; inlined into the motion of many starts
side by side (`rotor_ida.model.lanes`); and, all but `drag_of`, as functions of
``core/derived.h``, ``derived_whole.h`` and ``derived_run_up.h`` for C that is written by hand. The
second section gives the same law by r or d for Python; of it only the law without clearance
(`secant_of_square`) reaches C.

The force, its derivative, the potential, the Jacobians, the events and the datasets take the Hertz
exponent from this module. Some code depends on the exponent 3/2 itself, where the force is the cube
of q: the polynomials of the whirls and of their folds, the periods of free vibration, and the
variables of the contact phase. `rotor_ida.closed_forms.restoring_law` applies the law to
arrays.
CONTRIBUTING.md ("A law of contact") says what a new one touches.

References
----------
.. [1] "Analytical Nonlinear Response for a Rotor with the Hertz Contact and Clearance",
   Mechanika 25(6), 2019, eqs (2), (10) and (12).
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values

HERTZ_EXPONENT = 1.5
# An indentation above this fraction of the rotor's radius is not small, as contact laws assume.
SMALL_INDENTATION = 0.1


# ---- The law by ``q = sqrt(d)``, over numbers, arrays or symbols, from which C is derived ----
#
# Of `law`, a rotor or the contact of a rotor system, ``hertz`` and ``linear`` multiply either
# force, ``loose`` is 1 where the contact is loose, else 0, and ``sigma`` is the sense of sliding.


def spring_of_root(q: Any, law: Any, depth: Any = None) -> Any:
    """Return the elastic force ``d**n``; at an indentation of its own where q is not its root.

    By Hertz it is ``q**3``, as products, of which series are made.
    """
    square = q * q if depth is None else depth
    return square * (law.hertz * q + law.linear)


def slope_of_root(q: Any, law: Any) -> Any:
    """Return its slope by the indentation."""
    return HERTZ_EXPONENT * law.hertz * q + law.linear


def energy_of_root(q: Any, law: Any) -> Any:
    """Return the elastic energy."""
    square = q * q
    hertz = 1.0 / (HERTZ_EXPONENT + 1.0)
    return square * square * (hertz * law.hertz * q + 0.5 * law.linear)


def damping_factor(approach: Any, contact_damping: Any) -> Any:
    """Return the factor of contact damping, ``1 + c d'``: numbers, arrays or symbols.

    The contact is released where it falls to 0, and loose below.
    """
    return 1.0 + contact_damping * approach


def release_velocity(law: Any) -> Any:
    """Return the radial velocity at which the contact is released."""
    return -1.0 / law.contact_damping


def damped(spring: Any, approach: Any, law: Any) -> Any:
    """Return the normal force of an elastic one: ``d**n (1 + c d')``, or 0 where it is loose."""
    return (1.0 - law.loose) * spring * damping_factor(approach, law.contact_damping)


def normal_force(q: Any, approach: Any, law: Any) -> Any:
    """Return the normal force N, which is 0 only where ``law.loose`` says so."""
    return damped(spring_of_root(q, law), approach, law)


def drag_of(push: Any, law: Any) -> Any:
    """Return the tangential force ``T = mu N sigma`` of surfaces that slide, from N."""
    return law.friction * law.sigma * push


# ---- The same law by the distance r or the indentation d, for Python ----


def indentation(radius: npt.ArrayLike, delta0: npt.ArrayLike) -> Values:
    """Return the indentation, ``max(r - delta0, 0)`` [dimensionless].

    Examples
    --------
    >>> indentation([0.25, 0.75], 0.5)
    array([0.  , 0.25])
    """
    return np.maximum(np.subtract(radius, delta0, dtype=np.float64), 0.0)


def contact_force(
    radius: npt.ArrayLike, delta0: npt.ArrayLike, exponent: npt.ArrayLike = HERTZ_EXPONENT
) -> Values:
    """Return the undamped contact force towards the centre [dimensionless].

    Parameters
    ----------
    radius, delta0 : array_like
        Distance of the rotor from the bearing axis and radial clearance [dimensionless]; broadcast.
    exponent : float
        3/2 by Hertz, or 1, a linear spring.

    Returns
    -------
    ndarray
        ``f(r) = max(r - delta0, 0)**n`` [dimensionless].

    References
    ----------
    Eq. (10) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> contact_force([0.5, 1.5], 0.5)
    array([0., 1.])
    """
    force: Values = spring_force(indentation(radius, delta0), exponent)  # labels are kept
    return force


_ELASTIC = {
    HERTZ_EXPONENT: SimpleNamespace(hertz=1.0, linear=0.0),
    1.0: SimpleNamespace(hertz=0.0, linear=1.0),
}


def force_at_depth(depth: float, exponent: float) -> tuple[float, float]:
    """Return the force of a contact and its slope at one indentation [dimensionless].

    Examples
    --------
    >>> force_at_depth(4.0, 1.5)
    (8.0, 3.0)
    """
    law, root = _ELASTIC[exponent], math.sqrt(depth)
    return spring_of_root(root, law, depth), slope_of_root(root, law)


def contact_stiffness(radius: npt.ArrayLike, delta0: npt.ArrayLike) -> Values:
    """Return the slope of the Hertz force, ``f'(r) = 1.5 max(r - delta0, 0)**0.5`` [dimensionless].

    Examples
    --------
    >>> contact_stiffness([0.5, 1.5], 0.5)
    array([0. , 1.5])
    """
    slope: Values = spring_slope(indentation(radius, delta0), HERTZ_EXPONENT)
    return slope


def secant_stiffness(
    radius: npt.ArrayLike, delta0: npt.ArrayLike, exponent: npt.ArrayLike = HERTZ_EXPONENT
) -> Values:
    """Return force over radius, ``s(r) = f(r) / r`` [dimensionless]; zero, its limit, at r = 0.

    Examples
    --------
    >>> secant_stiffness([0.0, 4.0], 0.0)
    array([0., 2.])
    """
    radii = np.asarray(radius, dtype=np.float64)
    force = contact_force(radii, delta0, exponent)
    return np.divide(force, radii, out=np.zeros_like(force), where=force > 0.0)


def secant_of_square(square: Any) -> Any:
    """Return ``f(r)/r`` without clearance in terms of ``r**2``: ``(r**2)**0.25``."""
    return square ** (0.5 * (HERTZ_EXPONENT - 1.0))


def spring_force(depth: Any, exponent: Any) -> Any:
    """Return the elastic force at an indentation of at least 0, ``d**n``: numbers or arrays."""
    return depth**exponent


def spring_slope(depth: Any, exponent: Any) -> Any:
    """Return its slope by the indentation, ``n d**(n - 1)``."""
    return exponent * depth ** (exponent - 1.0)


def clipped_factor(radial_speed: npt.ArrayLike, contact_damping: float) -> Values:
    """Return the factor of contact damping, 0 where the contact is loose: never tensile [1].

    Examples
    --------
    >>> clipped_factor([1.0, -1.0, -4.0], 0.5)
    array([1.5, 0.5, 0. ])
    """
    speed = np.asarray(radial_speed, dtype=np.float64)
    return np.asarray(np.maximum(damping_factor(speed, contact_damping), 0.0))


def contact_potential(
    radius: npt.ArrayLike, delta0: npt.ArrayLike, exponent: float = HERTZ_EXPONENT
) -> Values:
    """Return the elastic energy, ``V(r) = max(r - delta0, 0)**(n + 1)/(n + 1)`` [dimensionless].

    References
    ----------
    Eq. (12) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> contact_potential([0.5, 1.5], 0.5)
    array([0. , 0.4])
    """
    power = exponent + 1.0
    return indentation(radius, delta0) ** power / power


def force_over_radius(radius: float, delta0: float, exponent: float = HERTZ_EXPONENT) -> float:
    """Return the scalar ``f(r)/r``; zero at r = 0."""
    depth = radius - delta0
    return float(spring_force(depth, exponent)) / radius if depth > 0.0 else 0.0


def stiffness(radius: float, delta0: float, exponent: float = HERTZ_EXPONENT) -> float:
    """Return the scalar ``f'(r)``; 1 in contact for a linear spring, and 0 elsewhere."""
    if exponent == 1.0:
        return 1.0 if radius > delta0 else 0.0
    return float(spring_slope(max(radius - delta0, 0.0), exponent))


def bounds_exceeded(indentation: float, radius: float | None, clearance: float | None) -> str:
    """Return beyond what an indentation is too large for a contact law, in words; "" if it is not.

    Examples
    --------
    >>> bounds_exceeded(1.1, 10.0, None), bounds_exceeded(1.1, 12.0, 1.2)
    ("a tenth of the rotor's radius", '')
    """
    bounds = []
    if radius is not None and indentation > SMALL_INDENTATION * radius:
        bounds.append("a tenth of the rotor's radius")
    if clearance is not None and indentation > clearance > 0.0:
        bounds.append("the clearance")
    return " and ".join(bounds)
