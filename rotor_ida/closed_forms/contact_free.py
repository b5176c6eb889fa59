"""Exact motion inside the clearance, which is linear."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.checks import (
    AT_REST,
    LARGEST_NUMBER,
    check_array,
    check_instance,
    check_nonnegative,
    check_real,
    check_state,
)
from rotor_ida.closed_forms.double_double import DoubleDouble
from rotor_ida.closed_forms.exponentials import (
    exponent,
    of_one,
    of_three,
    of_two,
    roots,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import Rotor

_LARGEST_PHASE = 1e15  # doubles then still resolve single revolutions


@dataclass(frozen=True, kw_only=True, slots=True)
class ContactFreeWhirl:
    """The family of whirls that stay inside the clearance.

    Parameters
    ----------
    amplitude : float
        Radius A_f of the whirl about its own centre [dimensionless].
    phase_lag : float
        Phase by which it lags the unbalance [rad].
    largest_centre_offset : float
        Largest distance of the centre from the bearing axis, ``delta0 - A_f`` [dimensionless]; NaN
        if the clearance is too small for the whirl.

    Examples
    --------
    >>> contact_free_whirl(Rotor(omega=3.0, zeta=2.0, delta0=1.0)).exists
    True
    """

    amplitude: float
    phase_lag: float
    largest_centre_offset: float

    @property
    def exists(self) -> bool:
        """Whether the whirl fits into the clearance."""
        return not math.isnan(self.largest_centre_offset)


def complex_amplitude(
    omega: npt.ArrayLike, zeta: npt.ArrayLike, shaft_stiffness: npt.ArrayLike = 0.0
) -> ComplexValues:
    """Return ``a = -omega/(omega - 2 i zeta)`` of the contact-free whirl ``c + a exp(i omega t)``.

    Its modulus is A_f, its angle minus the phase lag; 0 at rest. See `contact_free_whirl`. With a
    shaft of stiffness kappa it is ``omega**2/(kappa - omega**2 + 2 i zeta omega)``, and the
    centre c is 0.

    Examples
    --------
    >>> round(abs(complex(complex_amplitude(3.0, 2.0))), 12)
    0.6
    >>> complex(complex_amplitude(1.0, 0.0, 3.0))
    (0.5+0j)
    """
    given = (np.asarray(each, dtype=np.float64) for each in (omega, zeta, shaft_stiffness))
    speed, damping, kappa = np.broadcast_arrays(*given)
    free = _free_amplitude(speed, 2.0 * damping)
    if not kappa.any():
        return free
    return np.where(kappa > 0.0, _held_amplitude(speed, damping, kappa), free)


def _free_amplitude(speed: Values, resistance: Values) -> ComplexValues:
    """Return the complex amplitude without a shaft."""
    size, turning = np.hypot(speed, resistance), speed > 0.0
    # a quotient of complex numbers would overflow at the smallest speeds
    cosine = np.divide(speed, size, out=np.zeros_like(size), where=turning)
    sine = np.divide(resistance, size, out=np.zeros_like(size), where=turning)
    return np.asarray(0.0 - cosine * (cosine + 1j * sine))


def _held_amplitude(omega: Values, zeta: Values, kappa: Values) -> ComplexValues:
    """Return the complex amplitude with a shaft; the largest double where it would be infinite."""
    q = DoubleDouble.of(omega) * DoubleDouble.of(omega)
    restoring = (DoubleDouble.of(kappa) - q).high + 0.0
    resistance = 2.0 * zeta * omega
    size = np.hypot(restoring, resistance)
    moving = size > 0.0
    cosine = np.divide(restoring, size, out=np.ones_like(size), where=moving)
    sine = np.divide(resistance, size, out=np.zeros_like(size), where=moving)
    largest = np.finfo(np.float64).max
    still = np.where(q.high > 0.0, largest, 0.0)
    with np.errstate(over="ignore"):
        amplitude = np.minimum(np.divide(q.high, size, out=still, where=moving), largest)
    return np.asarray(amplitude * cosine - 1j * (amplitude * sine) + 0.0)


def static_sag(load: npt.ArrayLike, shaft_stiffness: npt.ArrayLike) -> Values:
    """Return by how much a load moves the centre of a contact-free whirl below the axis.

    It is ``gamma/kappa``, and infinite where no shaft carries the load.

    Examples
    --------
    >>> static_sag([0.0, 0.3, 0.3], [0.0, 0.5, 0.0])
    array([0. , 0.6, inf])
    """
    weight, kappa = np.broadcast_arrays(*(np.asarray(x, float) for x in (load, shaft_stiffness)))
    falls = np.where(weight > 0.0, np.inf, 0.0)
    with np.errstate(over="ignore"):
        return np.asarray(np.divide(weight, kappa, out=falls, where=kappa > 0.0))


def contact_free_whirl(rotor: Rotor) -> ContactFreeWhirl:
    """Return the neutral family of contact-free whirls, or the single one with a shaft.

    Parameters
    ----------
    rotor : Rotor
        Parameters of the rotor.

    Returns
    -------
    ContactFreeWhirl
        Its amplitude, phase lag and the largest offset of its centre.

    Notes
    -----
    ``z = c + A_f exp(i (omega t - theta))`` for every ``|c| + A_f <= delta0``, with
    ``A_f = omega/sqrt(omega**2 + 4 zeta**2)`` and ``theta = atan2(2 zeta, -omega)``. At
    omega = 0 the rotor rests: amplitude and phase lag are 0.

    With a shaft of stiffness kappa there is one whirl, ``z = A_f exp(i (omega t - theta))`` with
    ``A_f = omega**2/sqrt((kappa - omega**2)**2 + 4 zeta**2 omega**2)`` and
    ``theta = atan2(2 zeta omega, kappa - omega**2)``. With damping it attracts all motion that
    stays free of contact. `touch_speeds` gives the speeds at which it fits into the clearance.
    Under a load its centre is ``gamma/kappa`` below the axis, and its amplitude is the same.

    References
    ----------
    Eq. (10) of the paper, Mechanika 25(6), 2019, with f = 0.

    Examples
    --------
    >>> whirl = contact_free_whirl(Rotor(omega=3.0, zeta=2.0, delta0=1.0))
    >>> round(whirl.amplitude, 12), round(whirl.largest_centre_offset, 12)
    (0.6, 0.4)
    """
    check_instance("rotor", rotor, Rotor)
    kappa = rotor.shaft_stiffness
    whirl = complex(complex_amplitude(rotor.omega, rotor.zeta, kappa))
    sag = float(static_sag(rotor.load, kappa))
    room = rotor.delta0 - abs(whirl) - sag
    offset = room if kappa == 0.0 else sag
    return ContactFreeWhirl(
        amplitude=abs(whirl),
        phase_lag=abs(cmath.phase(whirl)),
        largest_centre_offset=offset if room >= 0.0 else math.nan,
    )


def touch_speeds(*, zeta: float, delta0: float, shaft_stiffness: float = 0.0) -> Values:
    """Compute the speeds at which the contact-free whirl just reaches the stator.

    Parameters
    ----------
    zeta, delta0, shaft_stiffness : float
        Damping ratio, clearance and stiffness of the shaft [dimensionless].

    Returns
    -------
    ndarray, shape (2,)
        Speeds [dimensionless]: above the first the whirl is too large for the clearance, above the
        second it fits again; NaN if there is none. Without a second one it does not fit again.

    Raises
    ------
    InputError
        If a value is not a finite real number from 0 to 1e15.

    Notes
    -----
    ``omega**4 = delta0**2 ((kappa - q)**2 + 4 zeta**2 q)`` is a quadratic in ``q = omega**2``,
    ``(1 - delta0**2) q**2 + 2 delta0**2 (kappa - 2 zeta**2) q - delta0**2 kappa**2 = 0``, with
    the discriminant ``4 delta0**2 (kappa**2 - 4 zeta**2 delta0**2 (kappa - zeta**2))``. At high
    speed the amplitude approaches 1. For a clearance below 1 there is one speed; above it there are
    two, or none if the largest whirl fits too.

    References
    ----------
    Eq. (10) of the paper, Mechanika 25(6), 2019, with f = 0 and a shaft.

    Examples
    --------
    >>> touch_speeds(zeta=0.1, delta0=2.0, shaft_stiffness=1.0).round(6)
    array([0.833712, 1.385012])
    >>> touch_speeds(zeta=0.6, delta0=0.6).round(6)
    array([0.9, nan])
    """
    z = check_nonnegative("zeta", zeta, LARGEST_NUMBER)
    d = check_nonnegative("delta0", delta0, LARGEST_NUMBER)
    kappa = check_nonnegative("shaft_stiffness", shaft_stiffness, LARGEST_NUMBER)
    # exactly, as two speeds may nearly coincide
    z2, d2, k = (Fraction(z) ** 2, Fraction(d) ** 2, Fraction(kappa))
    inside = k * k - 4 * z2 * d2 * (k - z2)
    sum_, lead = d2 * (2 * z2 - k), 1 - d2
    if inside < 0 or (lead <= 0 and sum_ >= 0):
        return np.array([math.nan, math.nan])
    root = Fraction(d * math.sqrt(inside))
    larger = abs(sum_) + root
    first = Fraction(0)
    if larger > 0:  # the smaller q, or the only positive one
        first = larger / lead if sum_ > 0 else d2 * k * k / larger
    second = math.sqrt(larger / -lead) if lead < 0 else math.nan
    return np.array([math.sqrt(first), second])


def touch_fading(rotor: Rotor) -> float:
    """Return the growth of 1/h from one touch to the next, for touches that fade for ever.

    Parameters
    ----------
    rotor : Rotor
        Parameters of the rotor.

    Returns
    -------
    float
        The constant C [dimensionless]; NaN if there is no such motion: without damping, at rest, or
        if the contact-free whirl does not fit into the clearance with room to spare.

    Notes
    -----
    A contact-free whirl whose centre lies slightly too far out touches the stator once a
    revolution, at a depth h. There the radius is ``delta0 + h - kappa t**2/2`` with
    ``kappa = omega**2 A_f (1 - A_f/delta0)``. The Hertz force gives the impulse
    ``(3 pi/8) h**2 sqrt(2/kappa)`` towards the bearing axis, which under damping moves the
    centre inwards by ``1/(2 zeta)`` times that. The next touch is shallower::

        h - h' = C h**2,   C = (3 pi/(16 zeta)) sqrt(2/kappa)

    so 1/h grows by C from touch to touch, and the n-th has ``h = 1/(C n)`` to leading order in
    h. The touches never end, and the limit is the whirl that just reaches the stator. A linear
    contact gives the impulse ``(4/3) h**1.5 sqrt(2/kappa)``; there ``1/sqrt(h)`` grows by
    ``C = sqrt(2/kappa)/(3 zeta)``. To leading order contact damping has no effect; nor has
    friction, which moves the centre along the stator.

    Examples
    --------
    >>> round(touch_fading(Rotor(omega=0.5, zeta=0.07, delta0=2.0)), 2)
    33.68
    """
    check_instance("rotor", rotor, Rotor)
    if rotor.shaft_stiffness > 0.0 or rotor.load > 0.0:  # there is one whirl, or none
        return math.nan
    amplitude = abs(complex(complex_amplitude(rotor.omega, rotor.zeta)))
    room = rotor.delta0 - amplitude
    if rotor.zeta == 0.0 or amplitude == 0.0 or room <= 0.0:
        return math.nan
    # a product of these would underflow at the smallest speeds
    width = math.sqrt(2.0 / amplitude) * math.sqrt(rotor.delta0 / room) / rotor.omega
    if rotor.contact_exponent == 1.0:
        return width / (3.0 * rotor.zeta)
    return 3.0 * math.pi / (16.0 * rotor.zeta) * width


def flight(
    time: npt.ArrayLike, *, rotor: Rotor, start: object = AT_REST, start_time: float = 0.0
) -> Values:
    """Compute the motion inside the clearance, ignoring the stator.

    Parameters
    ----------
    time : array_like, shape (...)
        Times [dimensionless], none before `start_time`.
    rotor : Rotor
        Parameters of the rotor; the clearance is not used.
    start : tuple of four floats
        ``(x, y, vx, vy)`` at `start_time` [dimensionless]; by default at rest on the axis.
    start_time : float
        Time of the start [dimensionless], which sets the direction of the unbalance.

    Returns
    -------
    ndarray, shape (4, ...)
        ``x, y, vx, vy`` at `time` [dimensionless].

    Raises
    ------
    InputError
        If a number is not finite, a time lies before `start_time`, `start` is not four numbers, or
        ``omega t``, ``sqrt(kappa) t`` or a parameter exceeds 1e15.

    Notes
    -----
    With tau = t - t0, z0 and v0 the start, and the roots a and b of ``L**2 + 2 zeta L + kappa``::

        z = C z0 + S v0 + omega**2 exp(i omega t0) exp[i omega, a, b] - i gamma exp[0, a, b]
        S = exp[a, b],   C = exp(a tau) - a S

    where ``exp[...]`` are divided differences of ``exp(x tau)`` by x: S is the response to a unit
    impulse, and the two others are those to ``exp(i omega tau)`` and to a unit step. They are
    computed without cancellation near critical damping, ``kappa = zeta**2``, in resonance, and as
    kappa or zeta tends to 0. Phases ``omega t`` are formed with 32 digits, so late times are as
    accurate.

    References
    ----------
    Eq. (10) of the paper, Mechanika 25(6), 2019, with f = 0.

    Examples
    --------
    >>> still = Rotor(omega=0.0, zeta=0.0, delta0=1.0)
    >>> flight([0.0, 2.0], rotor=still, start=(0.0, 0.0, 0.25, 0.0))
    array([[0.  , 0.5 ],
           [0.  , 0.  ],
           [0.25, 0.25],
           [0.  , 0.  ]])
    """
    check_instance("rotor", rotor, Rotor)
    began = check_real("start_time", start_time)
    x, y, vx, vy = check_state("start", start)
    times = check_array("time", time)
    early = times[times < began]
    if early.size:
        raise InputError(
            f"time must be finite and not before start_time = {began!r}, got {float(early[0])!r}"
        )
    omega = rotor.omega
    if omega * max(abs(began), np.max(np.abs(times), initial=0.0)) > _LARGEST_PHASE:
        raise InputError(f"omega * time must be at most {_LARGEST_PHASE:g}, got omega = {omega!r}")

    elapsed = DoubleDouble.of(times) - DoubleDouble.of(began)
    z, v = _flight(rotor, complex(x, y), complex(vx, vy), began, elapsed)
    return np.stack([z.real, z.imag, v.real, v.imag])


def _flight(
    rotor: Rotor, position: complex, velocity: complex, began: float, elapsed: DoubleDouble
) -> tuple[ComplexValues, ComplexValues]:
    """Return position and velocity, from those at the start."""
    omega, kappa = rotor.omega, rotor.shaft_stiffness
    for name in ("omega", "zeta", "shaft_stiffness", "load"):
        check_nonnegative(name, getattr(rotor, name), LARGEST_NUMBER)
    if math.sqrt(kappa) * np.max(elapsed.high, initial=0.0) > _LARGEST_PHASE:
        raise InputError(
            f"sqrt(shaft_stiffness) * time must be at most {_LARGEST_PHASE:g}, got "
            f"shaft_stiffness = {kappa!r}"
        )
    pair = roots(rotor.zeta, kappa)
    near, far = pair  # of real ones the first is nearer 0
    impulse = of_two(*pair, elapsed)
    place = of_one(near, elapsed) - near.value * impulse
    impulse_rate = of_one(far, elapsed) + near.value * impulse
    position_then = place.real * position + impulse.real * velocity
    velocity_then = impulse_rate.real * velocity - kappa * impulse.real * position
    if rotor.load > 0.0:
        step = of_three((exponent(0.0), *pair), elapsed)
        position_then = position_then - 1j * rotor.load * step.real
        velocity_then = velocity_then - 1j * rotor.load * impulse.real
    if omega > 0.0:
        rates = (exponent(0.0, omega), *pair)
        driven = of_three(rates, elapsed)
        # the rate of change is a driven + exp[b, c], which cancels least with the slowest as a
        slowest = min(range(3), key=lambda place: abs(rates[place].value))
        one, other = (rate for place, rate in enumerate(rates) if place != slowest)
        driven_rate = rates[slowest].value * driven + of_two(one, other, elapsed)
        push = omega * omega * of_one(rates[0], DoubleDouble.of(began))
        position_then = position_then + push * driven
        velocity_then = velocity_then + push * driven_rate
    return position_then, velocity_then
