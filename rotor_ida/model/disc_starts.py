"""Starts of one disc: at rest under its load, or settled on the whirl without contact.

`rotor_ida.simulation.starts` asks it, and finds the same of rotor systems.
"""

from __future__ import annotations

import cmath
import math
from fractions import Fraction
from typing import TYPE_CHECKING

from rotor_ida.checks import State
from rotor_ida.errors import InputError
from rotor_ida.model.contact import HERTZ_EXPONENT, force_at_depth

if TYPE_CHECKING:
    from rotor_ida.model.rotor import Rotor


def settled(rotor: Rotor, phase: float = 0.0) -> State:
    """Return the steady state without contact at time 0: static deflection and whirl [1].

    A motion that nothing holds and nothing drives stays at 0.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> settled(Rotor(omega=1.0, zeta=0.0, delta0=1.0, shaft_stiffness=5.0, load=0.5))
    (0.25, -0.1, 0.0, 0.25)
    """
    omega, kappa = rotor.omega, rotor.shaft_stiffness
    if rotor.load > 0.0 == kappa:
        raise InputError(
            "start cannot be settled without shaft_stiffness, which holds the rotor against its "
            "load"
        )
    if kappa == 0.0:  # both divided by the speed, whose square may vanish
        force, dynamic = complex(omega), complex(-omega, 2.0 * rotor.zeta)
    else:
        force, dynamic = complex(omega**2), complex(kappa - omega**2, 2.0 * rotor.zeta * omega)
    if dynamic == 0.0 and omega > 0.0:
        raise InputError(
            "start cannot be settled, as the stiffness is singular at this speed, {speed}",
            name="start", speed=omega,
        )  # fmt: skip
    whirl = force / dynamic * cmath.exp(1j * phase) if omega > 0.0 else 0j
    sag = rotor.load / kappa if kappa > 0.0 else 0.0
    return (whirl.real, whirl.imag - sag, 0.0 - omega * whirl.imag, omega * whirl.real)


def radius_at_rest(rotor: Rotor) -> float:
    """Return the distance from the bearing axis at which a rotor rests under its load [1]."""
    depth = depth_at_rest(rotor)
    if depth > 0.0:
        return rotor.delta0 + depth
    return rotor.load / rotor.shaft_stiffness if rotor.load > 0.0 else 0.0


def hanging(rotor: Rotor) -> State:
    """Return the state at rest in which a rotor hangs under its load, or lies on the stator [1].

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> hanging(Rotor(omega=0.5, zeta=0.1, delta0=1.0, load=0.5, shaft_stiffness=2.0))
    (0.0, -0.25, 0.0, 0.0)

    Notes
    -----
    A spinning rotor with friction climbs the stator: with ``z = -i r exp(-i beta)`` and the normal
    force N, ``(kappa r + N + i mu N) exp(-i beta) = gamma``. Without spin it does not slide and
    lies at the bottom. The unbalance does not act yet.
    """
    kappa, depth = rotor.shaft_stiffness, depth_at_rest(rotor)
    sliding = rotor.friction if rotor.omega > 0.0 else 0.0
    if depth == 0.0 or sliding == 0.0:
        return (0.0, 0.0 - radius_at_rest(rotor), 0.0, 0.0)

    def forces(depth: float) -> complex:
        normal = force_at_depth(depth, rotor.contact_exponent)[0]
        return complex(kappa * (rotor.delta0 + depth) + normal, sliding * normal)

    from scipy.optimize import brentq  # noqa: PLC0415 - takes long to import

    if abs(forces(depth)) > rotor.load:  # the depth without friction is an upper bound
        depth = brentq(lambda h: abs(forces(h)) - rotor.load, 0.0, depth, xtol=1e-15 * depth)
    place = complex(0.0, -rotor.delta0 - depth) * forces(depth).conjugate() / abs(forces(depth))
    return (place.real, place.imag, 0.0, 0.0)


def depth_at_rest(rotor: Rotor) -> float:
    """Return the indentation h at rest [1]: ``kappa h + h**n = gamma - kappa delta0``."""
    kappa = rotor.shaft_stiffness
    # exactly, as the two may nearly cancel
    load = float(Fraction(rotor.load) - Fraction(kappa) * Fraction(rotor.delta0))
    if load <= 0.0:
        return 0.0
    if rotor.contact_exponent != HERTZ_EXPONENT:
        return load / (1.0 + kappa)
    # u**3 + kappa u**2 is convex: Newton's method comes down to the root from above
    u = math.cbrt(load)
    if kappa * u * u > load:
        u = math.sqrt(load / kappa)
    for _ in range(60):
        lower = u - (u * u * (u + kappa) - load) / (u * (3.0 * u + 2.0 * kappa))
        if lower >= u:
            break
        u = lower
    return u * u
