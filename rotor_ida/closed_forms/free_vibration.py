"""Free, undamped vibration: periods, speeds and amplitudes of the nonlinear oscillator.

The powers 2/5, 1/4, 3/4, 4/5 and 5/4 follow from the Hertz exponent 3/2 of the paper's rotor; the
Beta function applies to any exponent n. With a shaft the periods of a linear contact are still in
closed form, but the planar period of a Hertz contact is an integral.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import (
    LARGEST_NUMBER,
    check_axis,
    check_distinct,
    check_nonnegative,
    check_points,
    check_real,
)
from rotor_ida.closed_forms.contacting_whirls import root_between
from rotor_ida.closed_forms.restoring_law import RestoringLaw, checked_law
from rotor_ida.errors import InputError
from rotor_ida.model.contact import HERTZ_EXPONENT
from rotor_ida.schema import labelled, labelled_dataset

SMALLEST_DEPTH = 1e-200
# Nodes and weights of Gauss quadrature from 0 to 1, for an analytic integrand.
_NODES, _WEIGHTS = (0.5 * each for each in np.polynomial.legendre.leggauss(96))


def circular_period(
    amplitude: float,
    delta0: float = 0.0,
    *,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
) -> float:
    """Compute the period of a free circular whirl about the bearing axis.

    Parameters
    ----------
    amplitude, delta0 : float
        Radius A of the circle, and clearance, which must be smaller [dimensionless].
    shaft_stiffness, contact_exponent : float
        As of `Rotor` [dimensionless].

    Returns
    -------
    float
        Period [dimensionless].

    Raises
    ------
    InputError
        If `amplitude` is not finite and above `delta0`, or `delta0` or the stiffness is negative;
        if the exponent is neither 1.5 nor 1.

    Notes
    -----
    ``T = 2 pi sqrt(A/f(A))``, which is ``2 pi A**(-1/4)`` without clearance: the larger the
    circle, the shorter the period. With a shaft ``T = 2 pi/sqrt(kappa + f(A)/A)``.

    References
    ----------
    Eq. (17) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> round(circular_period(2.0), 5), round(circular_period(8.0), 5)
    (5.28351, 3.736)
    """
    law = checked_law(delta0, shaft_stiffness, contact_exponent)
    depth = _depth(amplitude, law)
    by_ring = math.pow(depth, 0.5 * law.contact_exponent) / math.sqrt(law.delta0 + depth)
    return 2.0 * math.pi / math.hypot(math.sqrt(law.shaft_stiffness), by_ring)


def planar_period(
    amplitude: float,
    delta0: float = 0.0,
    *,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
) -> float:
    """Compute the period of free vibration on a straight line through the bearing axis.

    Parameters
    ----------
    amplitude, delta0 : float
        Largest distance A from the axis, and clearance, which must be smaller [dimensionless].
    shaft_stiffness, contact_exponent : float
        As of `Rotor` [dimensionless].

    Returns
    -------
    float
        Period [dimensionless].

    Raises
    ------
    InputError
        As by `circular_period`.

    Notes
    -----
    A quarter of the period consists of the time to leave the contact,
    ``(1/sqrt 5) B(2/5, 1/2) (A - delta0)**(-1/4)``, and the flight across `delta0` at the
    speed ``sqrt(4/5) (A - delta0)**(5/4)`` of `centre_speed`.

    With another exponent n and h = A - delta0 the time to leave the contact is
    ``B(1/(n + 1), 1/2) h**((1 - n)/2)/sqrt(2 (n + 1))``. With a shaft the flight takes
    ``arctan(sqrt(kappa) delta0/v)/sqrt(kappa)`` with the speed v at the stator. A linear contact is
    left after ``arctan2(v/sqrt(1 + kappa), kappa delta0/(1 + kappa))/sqrt(1 + kappa)``. For a Hertz
    contact this time is an integral over the energy without closed form, computed to rounding.

    References
    ----------
    Energy, eq. (13) of the paper, Mechanika 25(6), 2019, with ``|z'|**2/2``.

    Examples
    --------
    >>> round(planar_period(1.0), 12)
    6.581363388638
    """
    law = checked_law(delta0, shaft_stiffness, contact_exponent)
    depth = _depth(amplitude, law)
    return 4.0 * (_leaving_time(depth, law) + _flight_time(depth, law))


def centre_speed(
    amplitude: float,
    delta0: float = 0.0,
    *,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
) -> float:
    """Compute the speed at which a planar vibration crosses the bearing axis.

    Parameters
    ----------
    amplitude, delta0 : float
        Largest distance A from the axis, and clearance, which must be smaller [dimensionless].
    shaft_stiffness, contact_exponent : float
        As of `Rotor` [dimensionless].

    Returns
    -------
    float
        Speed ``sqrt(4/5) (A - delta0)**(5/4)`` [dimensionless]; with a shaft and the exponent n
        ``sqrt(kappa A**2 + 2 (A - delta0)**(n + 1)/(n + 1))``.

    Raises
    ------
    InputError
        As by `circular_period`.

    References
    ----------
    Energy, eq. (13) of the paper, Mechanika 25(6), 2019, with ``|z'|**2/2``.

    Examples
    --------
    >>> round(centre_speed(1.5, delta0=0.5), 12)
    0.894427191
    """
    law = checked_law(delta0, shaft_stiffness, contact_exponent)
    depth = _depth(amplitude, law)
    by_shaft = math.sqrt(law.shaft_stiffness) * (law.delta0 + depth)
    return math.hypot(by_shaft, _push(depth, law))


def amplitude_from_speed(
    speed: float,
    delta0: float = 0.0,
    *,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
) -> float:
    """Compute the amplitude of a rotor that leaves the bearing axis with a given speed.

    Parameters
    ----------
    speed, delta0 : float
        Speed at the axis and clearance [dimensionless].
    shaft_stiffness, contact_exponent : float
        As of `Rotor` [dimensionless].

    Returns
    -------
    float
        Amplitude ``delta0 + (1.25 speed**2)**0.4`` [dimensionless]; with a shaft or another
        exponent that of `centre_speed`, and ``speed/sqrt(kappa)`` if a shaft keeps the rotor off
        the stator.

    Raises
    ------
    InputError
        If a value is not finite, `delta0` or the stiffness is negative, `speed` is zero, or the
        exponent is neither 1.5 nor 1.

    References
    ----------
    Energy, eq. (13) of the paper, Mechanika 25(6), 2019, with ``|z'|**2/2``.

    Examples
    --------
    >>> round(amplitude_from_speed(2.0), 12)
    1.903653938716
    """
    leaving = check_nonnegative("speed", abs(check_real("speed", speed)), LARGEST_NUMBER)
    if leaving == 0.0:
        raise InputError("speed must not be zero, got 0.0: the rotor would not move")
    law = checked_law(delta0, shaft_stiffness, contact_exponent)
    return _reach(leaving, law)


def free_periods(
    *,
    amplitude: npt.ArrayLike,
    delta0: npt.ArrayLike,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
) -> xr.Dataset:
    """Compute the periods of free circular whirl and of free vibration on a line.

    Parameters
    ----------
    amplitude, delta0 : float or sequence of float, shapes (n,) and (k,)
        Amplitudes A and clearances [dimensionless].
    shaft_stiffness, contact_exponent : float
        As of `Rotor` [dimensionless].

    Returns
    -------
    Dataset
        ``circular_period`` and ``planar_period`` [dimensionless] on (delta0, amplitude); NaN if the
        rotor does not reach the stator.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive; if the exponent is
        neither 1.5 nor 1.

    Notes
    -----
    Without clearance both fall like ``A**(-1/4)``: the contact hardens. With clearance the periods
    grow without bound as the amplitude approaches it, as the flight takes ever longer. A shaft of
    stiffness kappa bounds them by ``2 pi/sqrt(kappa)``.

    References
    ----------
    Eq. (17) and Fig. 4 of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> periods = free_periods(amplitude=[2.0, 8.0], delta0=0.0)
    >>> periods.circular_period.values.round(5)
    array([[5.28351, 3.736  ]])
    """
    sizes, clearances = (
        check_distinct(name, check_axis(name, values, largest=LARGEST_NUMBER))
        for name, values in (("amplitude", amplitude), ("delta0", delta0))
    )
    check_points(clearances, sizes)
    given = {"shaft_stiffness": shaft_stiffness, "contact_exponent": contact_exponent}
    coordinates = checked_law(0.0, shaft_stiffness, contact_exponent).coordinates
    contact = "contact" if coordinates else "Hertz contact"
    periods = {"circular_period": circular_period, "planar_period": planar_period}
    variables = {
        name: (("delta0", "amplitude"), [
            [period(size, clearance, **given) if size > clearance else math.nan for size in sizes]
            for clearance in clearances
        ])
        for name, period in periods.items()
    }  # fmt: skip
    largest = labelled("amplitude", "amplitude", sizes)
    largest.attrs["long_name"] = "largest distance from the bearing axis"
    return labelled_dataset(
        f"Periods of free vibration of a rotor with {contact} and clearance",
        variables,
        {"delta0": ("delta0", clearances), "amplitude": largest, **coordinates},
        kind="free_vibration",
    )


def _depth(amplitude: float, law: RestoringLaw) -> float:
    """Return the largest indentation, which must be positive."""
    size = check_real("amplitude", amplitude)
    depth = size - law.delta0
    if depth <= 0.0:
        raise InputError(
            f"amplitude must be above delta0 = {law.delta0!r} for the rotor to touch, got {size!r}"
        )
    if not SMALLEST_DEPTH <= depth <= LARGEST_NUMBER:
        allowed = f"from {SMALLEST_DEPTH:g} to {LARGEST_NUMBER:g}"
        raise InputError(f"amplitude must be {allowed} above delta0, got {size!r}")
    return depth


def _push(depth: float, law: RestoringLaw) -> float:
    """Return the speed gained from the contact alone, ``sqrt(2 V)``."""
    power = law.contact_exponent + 1.0
    return math.sqrt(2.0 / power) * math.pow(depth, 0.5 * power)


def _flight_time(depth: float, law: RestoringLaw) -> float:
    """Return the time from the stator to the axis."""
    frequency, clearance = math.sqrt(law.shaft_stiffness), law.delta0
    by_shaft = frequency * math.sqrt(depth) * math.sqrt(2.0 * clearance + depth)
    speed = math.hypot(by_shaft, _push(depth, law))
    if frequency * clearance <= 1e-20 * speed:
        return clearance / speed
    return math.atan2(frequency * clearance, speed) / frequency


def _leaving_time(depth: float, law: RestoringLaw) -> float:
    """Return the time from rest at the largest indentation to the end of contact."""
    from scipy.special import beta  # noqa: PLC0415 - takes long to import

    kappa, clearance, power = law.shaft_stiffness, law.delta0, law.contact_exponent + 1.0
    if kappa == 0.0:
        factor = float(beta(1.0 / power, 0.5)) / math.sqrt(2.0 * power)
        return factor * math.pow(depth, 1.0 - 0.5 * power)
    if not law.hertz:
        frequency = math.sqrt(1.0 + kappa)
        speed = math.sqrt(depth) * math.sqrt(kappa * (2.0 * clearance + depth) + depth)
        return math.atan2(speed / frequency, clearance * (kappa / (1.0 + kappa))) / frequency
    # depth sin(angle)**2 is the indentation; then the speed is cos(angle) times the root below
    angle = math.pi * (_NODES + 0.5)
    sine = np.sin(0.5 * angle)
    by_ring = (1.0 + sine + sine**2 + sine**3 + sine**4) / (1.0 + sine)
    by_shaft = kappa * (2.0 * clearance + depth * (1.0 + sine**2))
    slowness = sine / np.sqrt(by_shaft + 0.8 * math.pow(depth, 1.5) * by_ring)
    return math.pi * math.sqrt(depth) * float(_WEIGHTS @ slowness)


def _reach(speed: float, law: RestoringLaw) -> float:
    """Return the amplitude to which a speed at the axis leads."""
    kappa, clearance, power = law.shaft_stiffness, law.delta0, law.contact_exponent + 1.0
    frequency = math.sqrt(kappa)
    if frequency * clearance >= speed:
        return speed / frequency
    # both bound the indentation, the energy in the contact and that in the shaft
    highest = math.pow(math.sqrt(0.5 * power) * speed, 2.0 / power)
    if frequency > 0.0:
        highest = min(highest, speed / frequency - clearance)
    else:
        return clearance + highest

    def left(part: float) -> float:
        depth = part * highest
        held = kappa * (clearance + depth) ** 2 + 2.0 / power * math.pow(depth, power)
        return held / (speed * speed) - 1.0

    if left(1.0) <= 0.0:
        return clearance + highest
    found = root_between(left, 0.0, 1.0)
    return clearance + found * highest
