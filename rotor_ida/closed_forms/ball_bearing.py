"""Radial stiffness of a ball bearing from its data sheet, by Hertz."""

from __future__ import annotations

import math

from scipy.optimize import brentq
from scipy.special import beta, ellipe, ellipkm1

from rotor_ida.checks import check_between, check_count, check_nonnegative
from rotor_ida.errors import InputError

# The ellipse of contact is at most this many times as long as wide.
LONGEST_ELLIPSE = 1e3
MOST_BALLS = 1000
MODULI, DIAMETERS = (1e3, 1e15), (1e-6, 1e3)  # Pa, m


def ball_bearing_stiffness(
    *,
    ball_diameter: float,
    pitch_diameter: float,
    balls: int,
    inner_osculation: float = 0.52,
    outer_osculation: float = 0.53,
    contact_angle: float = 0.0,
    youngs_modulus: float = 2.08e11,
    poisson_ratio: float = 0.3,
) -> float:
    """Compute the radial stiffness of a ball bearing without clearance, as a contact by Hertz.

    Parameters
    ----------
    ball_diameter, pitch_diameter : float
        Diameter of a ball, and of the circle of the centres of the balls [m].
    balls : int
        Number of balls.
    inner_osculation, outer_osculation : float
        Radius of the groove of the inner and of the outer race over the diameter of a ball, above
        0.5 and up to 1.
    contact_angle : float
        Contact angle, from 0 to below pi/2 [rad].
    youngs_modulus : float
        Of balls and races [Pa].
    poisson_ratio : float
        Of balls and races.

    Returns
    -------
    float
        Stiffness k of ``F = k d**1.5``, the radial force by the radial displacement [N/m^1.5]: the
        `stiffness` of a `Contact`.

    Raises
    ------
    InputError
        If an argument cannot be used.

    Notes
    -----
    One ball between two races has ``Q = K d**1.5`` with ``K**(-2/3) = K_i**(-2/3) + K_o**(-2/3)``,
    each by Hertz with complete elliptic integrals [1]_. Of all balls
    ``F = Z cos(alpha)**2.5 K d**1.5 J``, ``J = B(7/4, 1/2)/(2 pi) = 1/4.37``, the mean over the
    positions of the balls, of which those of one half are loaded (Stribeck). Clearance in the
    bearing, centrifugal forces of the balls and housing are left out: a touchdown bearing is
    softer in its mount.

    References
    ----------
    .. [1] T. A. Harris and M. N. Kotzalas, *Essential Concepts of Bearing Technology*, 5th ed.,
       2007, chapters 6 (Hertz) and 7 (Stribeck).

    Examples
    --------
    A deep-groove bearing 6209: nine balls of 12.7 mm.

    >>> f"{ball_bearing_stiffness(ball_diameter=12.7e-3, pitch_diameter=65e-3, balls=9):.3g}"
    '2.26e+10'
    """
    ball = check_between("ball_diameter", ball_diameter, *DIAMETERS)
    pitch = check_between("pitch_diameter", pitch_diameter, *DIAMETERS)
    angle = check_nonnegative("contact_angle", contact_angle)
    if not angle < math.pi / 2.0:
        raise InputError(f"contact_angle must be below pi/2, got {angle!r}")
    modulus = check_between("youngs_modulus", youngs_modulus, *MODULI)
    poisson = check_between("poisson_ratio", poisson_ratio, 0.0, 0.5)
    count = check_count("balls", balls, maximum=MOST_BALLS)
    over_pitch = ball * math.cos(angle) / pitch
    if not over_pitch < 1.0:
        raise InputError(f"pitch_diameter must exceed that of a ball, {ball!r}, got {pitch!r}")
    effective = modulus / (2.0 * (1.0 - poisson**2))
    softness = 0.0
    for name, given, along in (
        ("inner_osculation", inner_osculation, 2.0 * over_pitch / (1.0 - over_pitch)),
        ("outer_osculation", outer_osculation, -2.0 * over_pitch / (1.0 + over_pitch)),
    ):
        groove = check_between(name, given, 0.5, 1.0)
        if groove == 0.5:
            raise InputError(f"{name} must exceed 0.5, got {given!r}")
        # the two principal curvatures, of ball and race together
        curvatures = ((2.0 + along) / ball, (2.0 - 1.0 / groove) / ball)
        softness += point_contact_stiffness(*curvatures, effective) ** (-2.0 / 3.0)
    mean = float(beta(1.75, 0.5)) / math.tau
    return float(count * math.cos(angle) ** 2.5 * mean * softness**-1.5)


def point_contact_stiffness(one: float, other: float, effective_modulus: float) -> float:
    """Return K of ``Q = K d**1.5`` for two bodies of given relative principal curvatures.

    Parameters
    ----------
    one, other : float
        Principal relative curvatures, sums of those of both bodies [1/m].
    effective_modulus : float
        ``1/((1 - nu_1**2)/E_1 + (1 - nu_2**2)/E_2)`` [Pa].

    Notes
    -----
    With ``m = 1 - 1/kappa**2``, kappa the axis ratio of the ellipse, the curvatures are in the
    ratio ``(E(m) kappa**2 - K(m))/(K(m) - E(m))``, and
    ``Q = 4/3 E* d**1.5 kappa pi/2 sqrt(E(m)/(K(m)**3 (one + other)/2))`` with ``kappa = 1`` for
    spheres.

    Examples
    --------
    Two spheres of 2 m and a modulus of 1: 4/3 of the root of the radius 1.

    >>> round(point_contact_stiffness(1.0, 1.0, 1.0), 12)
    1.333333333333
    """
    high, low = max(one, other), min(one, other)
    ratio = high / low

    def excess(axes: float) -> float:
        if axes == 1.0:
            return 1.0 - ratio
        first, second = float(ellipkm1(axes**-2)), float(ellipe(1.0 - axes**-2))
        return (second * axes**2 - first) / (first - second) - ratio

    axes = 1.0
    if ratio > 1.0 + 1e-9:
        if excess(LONGEST_ELLIPSE) <= 0.0:
            raise InputError(
                f"osculations must not let balls and grooves conform, got curvatures {ratio:.3g}:1"
            )
        axes = float(brentq(excess, 1.0 + 1e-9, LONGEST_ELLIPSE, xtol=1e-13, rtol=1e-13))
    first, second = float(ellipkm1(axes**-2)), float(ellipe(1.0 - axes**-2))
    mean = 0.5 * (high + low)
    shape = axes * math.sqrt(second / (first**3 * mean)) * math.pi / 2.0
    return 4.0 / 3.0 * effective_modulus * shape
