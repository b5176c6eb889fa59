"""Backward whirl by friction alone: the slipping dry whirl, and dry whip, which rolls.

Without unbalance a whirl ``z = r exp(i Omega t)`` that slips forwards on the stator obeys

    kappa + f(r)/r - Omega**2 = 0,    2 zeta Omega + mu f(r)/r = 0,

whose one solution with a repulsive force is ``Omega = -(zeta + sqrt(zeta**2 + mu**2 kappa))/mu``,
for any contact law, clearance and speed. It is a saddle: with ``a = kappa + f'(r) - Omega**2`` and
``m = 2 zeta + c f(r)`` its eigenvalues, besides the 0 of its phase, are the roots of

    L**3 + (m + 2 zeta) L**2 + (2 zeta m + a + 2 Omega (2 Omega + mu c f)) L
        + 2 zeta a + 2 Omega (2 zeta Omega + mu f'),

whose last term is ``2 zeta (f' - f/r) (1 - 2 Omega**2 r/f)``, always negative.

A disc that rolls backwards on the stator has ``r phi' = -V`` with ``V = rho omega``. Its radius
obeys ``r'' + 2 zeta r' + kappa r + N = V**2/r`` and settles where ``r f + kappa r**2 = V**2``.
Rolling needs the force ``2 zeta V``, which friction can supply while it is at most ``mu f(r)``.
At the limit both whirls coincide, at the speed ``r |Omega|/rho`` of their birth.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import xarray as xr

from rotor_ida.checks import LARGEST_NUMBER, check_instance, check_nonnegative
from rotor_ida.closed_forms.contacting_whirls import root_between
from rotor_ida.closed_forms.stability import slowest_rate
from rotor_ida.errors import InputError
from rotor_ida.model.contact import HERTZ_EXPONENT, force_at_depth
from rotor_ida.model.rotor import DimensionalRotor, Rotor, check_no_load
from rotor_ida.results.in_si import takes_si
from rotor_ida.schema import STABILITY, WHIRL_KIND, labelled, labelled_dataset

# With less friction the whirl speed leaves the range of doubles.
_SMALLEST_FRICTION = 1e-20
# A bound of a root times this is above it, whatever the rounding.
_ABOVE = 1.0 + 1e-9


@takes_si
def backward_whirl(rotor: Rotor | DimensionalRotor) -> xr.Dataset:
    """Compute the backward whirls sustained by friction alone: dry whirl (slipping) and dry whip.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor
        A rotor with friction; its unbalance is ignored. For a `DimensionalRotor` results are in SI
        units.

    Returns
    -------
    Dataset
        On ``whirl``, the slipping one and the rolling one (``kind``, flags): ``amplitude`` and
        ``whirl_speed``, negative for backward whirl [dimensionless], ``stability`` (flags) and
        ``growth_rate`` [dimensionless], and the ``normal_force`` and ``tangential_force`` of the
        contact [dimensionless]; NaN and the flag ``absent`` if the rotor is too slow for them.
        ``birth_omega`` is the speed at which both are born [dimensionless]; NaN if friction is too
        weak at any speed. The parameters are scalar coordinates.

    Raises
    ------
    InputError
        If `rotor` is not a `Rotor`, has friction below 1e-20 or a load, or a parameter is above
        1e15.

    Notes
    -----
    The slipping whirl has the speed ``Omega = -(zeta + sqrt(zeta**2 + mu**2 kappa))/mu`` and the
    radius at which ``f(r)/r = Omega**2 - kappa``; in a linear contact there is none if this is 1 or
    more. It is a saddle: a smaller whirl dies out, a larger one grows until the disc rolls. Dry
    whip rolls at ``-rho omega/r`` with ``r f + kappa r**2 = (rho omega)**2``. Damping makes its
    radius stable, and from the birth on friction can sustain it (``tangential_force`` is at most mu
    times ``normal_force``). Without damping any touch is driven, and there is no slipping whirl.

    With unbalance, whip at these speeds may alternate between rolling and slipping.

    References
    ----------
    H. F. Black, "Interaction of a whirling rotor with a vibrating stator across a clearance
    annulus", Journal of Mechanical Engineering Science 10, 1968, for dry friction whirl and whip;
    here the stator does not move.

    Examples
    --------
    >>> rotor = Rotor(
    ...     omega=0.629579808, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0
    ... )
    >>> found = backward_whirl(rotor)
    >>> found.amplitude.values.round(6), found.whirl_speed.values.round(6)
    (array([3.147899, 4.984178]), array([-1.      , -1.263157]))
    >>> round(found.birth_omega.item(), 9)
    0.314789904
    """
    rotor = check_instance("rotor", rotor, Rotor)
    rho = _checked(rotor)
    zeta, mu, c = rotor.zeta, rotor.friction, rotor.contact_damping
    kappa, surface = rotor.shaft_stiffness, rho * rotor.omega
    speed = -(zeta + math.sqrt(zeta * zeta + mu * mu * kappa)) / mu
    # Omega**2 - kappa, with nothing that cancels
    depth = _slipping_depth(-2.0 * zeta * speed / mu, rotor)
    radius = rotor.delta0 + depth
    birth = radius * -speed / rho if rho > 0.0 and math.isfinite(radius) else math.nan

    rows = {"slipping": (math.nan,) * 5, "rolling": (math.nan,) * 5}
    stability = {"slipping": "absent", "rolling": "absent"}
    if rotor.omega >= birth and surface > 0.0:
        force, slope = force_at_depth(depth, rotor.contact_exponent)
        if depth > 0.0:
            growth = _saddle_rate(rotor, radius, speed, force, slope)
            rows["slipping"] = radius, speed, growth, force, mu * force
            stability["slipping"] = "unstable"
        settled = _rolling_depth(rotor)
        radius = rotor.delta0 + settled
        force, slope = force_at_depth(settled, rotor.contact_exponent)
        stiffness = kappa + slope + (surface / radius) ** 2
        growth = float(slowest_rate(zeta + 0.5 * c * force, stiffness))
        rows["rolling"] = radius, -surface / radius, growth, force, 2.0 * zeta * surface
        stability["rolling"] = "stable" if growth < 0.0 else "neutral"

    dims, table = ("whirl",), np.array(list(rows.values()))
    flags = np.array([STABILITY[stability[kind]] for kind in rows], dtype=np.int8)
    kinds = np.array([WHIRL_KIND[kind] for kind in rows], dtype=np.int8)
    return labelled_dataset(
        "Backward whirls of a rotor by friction, without unbalance",
        {
            "amplitude": labelled("backward_amplitude", dims, table[:, 0]),
            "whirl_speed": (dims, table[:, 1]),
            "kind": labelled("backward_kind", dims, kinds),
            "stability": labelled("backward_stability", dims, flags),
            "growth_rate": (dims, table[:, 2]),
            "normal_force": labelled("backward_normal_force", dims, table[:, 3]),
            "tangential_force": labelled("backward_tangential_force", dims, table[:, 4]),
            "birth_omega": ((), birth),
        },
        {
            **{name: ((), value) for name, value in rotor.given.items()},
            "whirl": ("whirl", np.arange(len(rows))),
        },
        {"source": "rotor_ida closed forms: whirls sustained by friction"},
        kind="backward_whirl",
    )


def _checked(rotor: Rotor) -> float:
    """Return the radius of the disc of a rotor that has friction."""
    if rotor.friction == 0.0:
        raise InputError("friction must be above 0 for a backward whirl, got 0.0")
    check_no_load(rotor.load, "a backward whirl")
    for name in ("omega", "zeta", "delta0", "shaft_stiffness", "contact_damping", "friction"):
        check_nonnegative(name, getattr(rotor, name), LARGEST_NUMBER)
    if rotor.friction < _SMALLEST_FRICTION:
        raise InputError(
            f"friction must be at least {_SMALLEST_FRICTION:g} for a backward whirl, "
            f"got {rotor.friction!r}"
        )
    return check_nonnegative("disc_radius", rotor.disc_radius, LARGEST_NUMBER)


def _slipping_depth(secant: float, rotor: Rotor) -> float:
    """Return the indentation at which ``f(r)/r`` is `secant`; NaN if there is none."""
    delta0 = rotor.delta0
    if rotor.contact_exponent != HERTZ_EXPONENT:
        return secant * delta0 / (1.0 - secant) if secant < 1.0 else math.nan
    highest = _ABOVE * (secant + math.cbrt(secant * delta0))
    return root_between(lambda u: u * u * (u - secant) - secant * delta0, secant, highest) ** 2


def _rolling_depth(rotor: Rotor) -> float:
    """Return the indentation at which ``r f + kappa r**2`` is the square of the surface's speed."""
    delta0, kappa = rotor.delta0, rotor.shaft_stiffness
    surface = (rotor.disc_radius or 0.0) * rotor.omega
    # exactly, as the two may nearly cancel
    excess = float(Fraction(surface) ** 2 - Fraction(kappa) * Fraction(delta0) ** 2)
    if excess <= 0.0:
        return 0.0
    if rotor.contact_exponent != HERTZ_EXPONENT:
        first = delta0 * (1.0 + 2.0 * kappa)
        return 2.0 * excess / (first + math.sqrt(first * first + 4.0 * (1.0 + kappa) * excess))
    # none of the terms alone exceeds the excess at the root
    u = min(math.pow(excess, 0.2), math.cbrt(excess / delta0))
    if kappa > 0.0:
        u = min(u, math.sqrt(excess / (2.0 * kappa * delta0)))

    def missing(u: float) -> float:
        return u * u * (u * (u * (u + kappa) + delta0) + 2.0 * kappa * delta0) - excess

    return root_between(missing, 0.0, _ABOVE * u) ** 2


def _saddle_rate(rotor: Rotor, radius: float, speed: float, force: float, slope: float) -> float:
    """Return the largest real part of the eigenvalues of the slipping whirl."""
    zeta, mu, drag = rotor.zeta, rotor.friction, rotor.contact_damping * force
    m, a = 2.0 * zeta + drag, slope - force / radius
    terms = (
        1.0,
        m + 2.0 * zeta,
        2.0 * zeta * m + a + 2.0 * speed * (2.0 * speed + mu * drag),
        2.0 * zeta * a + 2.0 * speed * (2.0 * zeta * speed + mu * slope),
    )
    return float(np.roots(terms).real.max())
