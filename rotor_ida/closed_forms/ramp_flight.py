"""Motion inside the clearance while the speed changes at a constant rate, by error functions.

With ``E = exp(i theta)`` and ``theta = omega t + rate t**2/2`` the centre of mass ``w = z + E``
obeys ``w'' + 2 zeta w' + kappa w = 2 zeta E' + kappa E``. For both roots L of
``L**2 + 2 zeta L + kappa`` the unbalance enters by

    I = integral of exp(L (t - s) + i theta(s)) over s from 0 to t,

an integral of the exponential of a quadratic, hence an error function of complex argument.
Faddeeva's function ``w(x) = exp(-x**2) erfc(-i x)`` avoids cancellation and overflow.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.checks import (
    AT_REST,
    LARGEST_NUMBER,
    check_array,
    check_between,
    check_instance,
    check_real,
    check_state,
)
from rotor_ida.closed_forms.exponentials import roots
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import Rotor, check_no_load

_LARGEST_PHASE = 1e12
SMALLEST_RATE = 1e-12
# Nearer to critical damping the two roots coincide to rounding.
_APART = 1e-3


def ramp_flight(
    time: npt.ArrayLike, *, rotor: Rotor, start: object = AT_REST, rate: float
) -> Values:
    """Compute the motion inside the clearance on a ramp of the speed, ignoring the stator.

    Parameters
    ----------
    time : array_like, shape (...)
        Times [dimensionless], none below 0.
    rotor : Rotor
        The rotor, without a load. Its ``omega`` is the speed at time 0, when the unbalance points
        along x. The clearance is not used.
    start : tuple of four floats
        ``(x, y, vx, vy)`` at time 0 [dimensionless]; by default at rest on the axis.
    rate : float
        Rate of change of the speed [dimensionless], negative in a run-down.

    Returns
    -------
    ndarray, shape (4, ...)
        ``x, y, vx, vy`` at `time` [dimensionless].

    Raises
    ------
    InputError
        If a number is not finite, a time is negative, the rate is below 1e-12 in size, the rotor
        has a load or is within 1e-3 of critical damping, ``zeta**2 = shaft_stiffness``, or an angle
        exceeds 1e12.

    Notes
    -----
    With a and b the roots of ``L**2 + 2 zeta L + kappa`` and ``S = (exp(a t) - exp(b t))/(a - b)``,
    ``C = (a exp(b t) - b exp(a t))/(a - b)``::

        z + exp(i theta) = C (z0 + 1) + S (v0 + i omega - 2 zeta) - (a**2 I_a - b**2 I_b)/(a - b)

    References
    ----------
    F. M. Lewis, "Vibration during acceleration through a critical speed", Transactions of the ASME
    54, 1932.

    Examples
    --------
    >>> rotor = Rotor(omega=0.5, zeta=0.05, delta0=20.0, shaft_stiffness=1.0)
    >>> x, y, vx, vy = ramp_flight(50.0, rotor=rotor, start=(0, 0, 0, 0), rate=0.02)
    >>> round(float(x), 6), round(float(y), 6)
    (-0.180066, -1.616426)
    """
    check_instance("rotor", rotor, Rotor)
    slope = check_real("rate", rate)
    check_between("the size of rate", abs(slope), SMALLEST_RATE, LARGEST_NUMBER)
    x, y, vx, vy = check_state("start", start)
    times = check_array("time", time)
    if (times < 0.0).any():
        raise InputError(f"time must not be negative, got {float(times.min())!r}")
    check_no_load(rotor.load, "a flight on a ramp", "which leaves it out")
    longest = float(np.max(times, initial=0.0))
    if (rotor.omega + abs(slope) * longest) * longest > _LARGEST_PHASE:
        raise InputError(f"the angle must be at most {_LARGEST_PHASE:g}, got time {longest!r}")
    zeta, kappa = rotor.zeta, rotor.shaft_stiffness
    if max(zeta, kappa) > 0.0 and abs(zeta * zeta - kappa) < _APART * max(zeta * zeta, kappa):
        raise InputError(
            f"zeta**2 must differ from shaft_stiffness by a thousandth or more for a flight on a "
            f"ramp, got zeta {zeta!r} and shaft_stiffness {kappa!r}"
        )
    a, b = (each.value for each in roots(zeta, kappa))
    theta = (rotor.omega + 0.5 * slope * times) * times
    speed, turned = rotor.omega + slope * times, np.exp(1j * theta)
    begin, moving = complex(x, y) + 1.0, complex(vx, vy) + 1j * rotor.omega
    if a == b:  # neither damping nor shaft: the centre of mass moves on a straight line
        centre, rising = begin + moving * times, moving + 0.0 * times
    else:
        drawn_a, drawn_b = (_drawn_in(each, times, theta, rotor.omega, slope) for each in (a, b))
        ea, eb, kick = np.exp(a * times), np.exp(b * times), moving - 2.0 * rotor.zeta
        centre = begin * (a * eb - b * ea) + kick * (ea - eb) - a * a * drawn_a + b * b * drawn_b
        rising = begin * a * b * (eb - ea) + kick * (a * ea - b * eb)
        rising -= a * a * (a * drawn_a + turned) - b * b * (b * drawn_b + turned)
        centre, rising = centre / (a - b), rising / (a - b)
    z, v = centre - turned, rising - 1j * speed * turned
    return np.stack([z.real, z.imag, v.real, v.imag])


def _drawn_in(
    root: complex, times: Values, theta: Values, omega: float, rate: float
) -> ComplexValues:
    """Return I of a root at times.

    With ``p = i rate/2``, ``q = i omega - L``, ``k = sqrt(-p)`` and ``c = q/(2 p)`` it is
    ``sqrt(pi)/(2 k) (exp(L t) w(i k c) - exp(i theta) w(i k (t + c)))`` for either sign of k. The
    sign is chosen so that w does not overflow at t. If it would at 0, on the other side of the
    resonance, ``w(x) = 2 exp(-x**2) - w(-x)`` is used.
    """
    from scipy.special import wofz  # noqa: PLC0415 - takes long to import

    p, q = 0.5j * rate, 1j * omega - root
    k, c = np.sqrt(-p), 0.5 * q / p
    k = np.where((k * (times + c)).real < 0.0, -k, k)
    at_start = 1j * k * c
    passed = at_start.imag < 0.0
    first = np.exp(root * times) * wofz(np.where(passed, -at_start, at_start))
    beyond = np.exp(np.where(passed, root * times - at_start**2, -np.inf + 0j))
    first = np.where(passed, 2.0 * beyond - first, first)
    last = np.exp(1j * theta) * wofz(1j * k * (times + c))
    return np.asarray(math.sqrt(math.pi) / (2.0 * k) * (first - last))
