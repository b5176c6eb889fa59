"""Free, undamped vibration, the nonlinearity seen on its own: periods, speeds, amplitudes.

The powers 2/5, 1/4, 3/4, 4/5 and 5/4 and the Beta function follow from the Hertz exponent 3/2.
"""

from __future__ import annotations

import math

import numpy.typing as npt
import xarray as xr
from scipy.special import beta

from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_nonnegative, check_points, check_real
from rotor_ida.errors import InputError
from rotor_ida.schema import labelled, labelled_dataset

SMALLEST_DEPTH = 1e-200
# Time in which a rotor released at indentation 1 leaves the contact: (1/sqrt 5) B(2/5, 1/2).
_LEAVING_TIME = float(beta(0.4, 0.5)) / math.sqrt(5.0)


def circular_period(amplitude: float, delta0: float = 0.0) -> float:
    """Return the period of a free whirl on a circle round the bearing axis.

    Parameters
    ----------
    amplitude, delta0 : float
        Radius A of the circle, and clearance, which is less [1].

    Returns
    -------
    float
        Period [1].

    Raises
    ------
    InputError
        If `amplitude` is not finite and above `delta0`, or `delta0` is negative.

    Notes
    -----
    ``T = 2 pi sqrt(A/f(A))``, which is ``2 pi A**(-1/4)`` without clearance: the larger the
    circle, the shorter the period.

    References
    ----------
    Eq. (17) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> round(circular_period(2.0), 5), round(circular_period(8.0), 5)
    (5.28351, 3.736)
    """
    depth, clearance = _depth_and_clearance(amplitude, delta0)
    return 2.0 * math.pi * math.sqrt(clearance + depth) / math.pow(depth, 0.75)


def planar_period(amplitude: float, delta0: float = 0.0) -> float:
    """Return the period of free vibration on a straight line through the bearing axis.

    Parameters
    ----------
    amplitude, delta0 : float
        Largest distance A from the axis, and clearance, which is less [1].

    Returns
    -------
    float
        Period [1].

    Raises
    ------
    InputError
        As by `circular_period`.

    Notes
    -----
    A quarter of it is the time to leave the contact,
    ``(1/sqrt 5) B(2/5, 1/2) (A - delta0)**(-1/4)``, and the flight across `delta0` at the
    speed ``sqrt(4/5) (A - delta0)**(5/4)`` of `centre_speed`.

    References
    ----------
    Energy, eq. (13) of the paper, Mechanika 25(6), 2019, with ``|z'|**2/2``.

    Examples
    --------
    >>> round(planar_period(1.0), 12)
    6.581363388638
    """
    depth, clearance = _depth_and_clearance(amplitude, delta0)
    return 4.0 * (_LEAVING_TIME * math.pow(depth, -0.25) + clearance / _speed(depth))


def centre_speed(amplitude: float, delta0: float = 0.0) -> float:
    """Return the speed with which a planar vibration crosses the bearing axis.

    Parameters
    ----------
    amplitude, delta0 : float
        Largest distance A from the axis, and clearance, which is less [1].

    Returns
    -------
    float
        Speed ``sqrt(4/5) (A - delta0)**(5/4)`` [1].

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
    return _speed(_depth_and_clearance(amplitude, delta0)[0])


def amplitude_from_speed(speed: float, delta0: float = 0.0) -> float:
    """Return how far a rotor comes that leaves the bearing axis with some speed.

    Parameters
    ----------
    speed, delta0 : float
        Speed at the axis and clearance [1].

    Returns
    -------
    float
        Amplitude ``delta0 + (1.25 speed**2)**0.4`` [1].

    Raises
    ------
    InputError
        If a value is not finite or `delta0` is negative, or `speed` is zero and so the
        rotor never reaches the ring.

    References
    ----------
    Energy, eq. (13) of the paper, Mechanika 25(6), 2019, with ``|z'|**2/2``.

    Examples
    --------
    >>> round(amplitude_from_speed(2.0), 12)
    1.903653938716
    """
    leaving = check_nonnegative("speed", abs(check_real("speed", speed)), LARGEST_NUMBER)
    clearance = check_nonnegative("delta0", delta0, LARGEST_NUMBER)
    if leaving == 0.0:
        raise InputError("speed must not be zero, got 0.0: the rotor would stay where it is")
    return clearance + math.pow(math.sqrt(1.25) * leaving, 0.8)


def free_periods(*, amplitude: npt.ArrayLike, delta0: npt.ArrayLike) -> xr.Dataset:
    """Return the periods of free whirl on a circle and of free vibration on a line.

    Parameters
    ----------
    amplitude, delta0 : float or sequence of float, shapes (n,) and (k,)
        Amplitudes A and clearances [1].

    Returns
    -------
    Dataset
        ``circular_period`` and ``planar_period`` [1] on (delta0, amplitude); NaN where the
        rotor does not reach the ring.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive.

    Notes
    -----
    Without clearance both fall like ``A**(-1/4)``: the ring hardens. With clearance the flight
    takes ever longer as the amplitude comes down to it, and the periods grow without bound.

    References
    ----------
    Eq. (17) and Fig. 4 of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> periods = free_periods(amplitude=[2.0, 8.0], delta0=0.0)
    >>> periods.circular_period.values.round(5)
    array([[5.28351, 3.736  ]])
    """
    sizes = check_axis("amplitude", amplitude, largest=LARGEST_NUMBER)
    clearances = check_axis("delta0", delta0, largest=LARGEST_NUMBER)
    check_points(clearances, sizes)
    laws = {"circular_period": circular_period, "planar_period": planar_period}
    variables = {
        name: (("delta0", "amplitude"), [
            [law(size, clearance) if size > clearance else math.nan for size in sizes]
            for clearance in clearances
        ])
        for name, law in laws.items()
    }  # fmt: skip
    largest = labelled("amplitude", "amplitude", sizes)
    largest.attrs["long_name"] = "largest distance from the bearing axis"
    return labelled_dataset(
        "Periods of free vibration of a rotor with Hertz contact and clearance",
        variables,
        {"delta0": ("delta0", clearances), "amplitude": largest},
    )


def _depth_and_clearance(amplitude: float, delta0: float) -> tuple[float, float]:
    """Return the largest indentation, which must be positive, and the clearance."""
    clearance = check_nonnegative("delta0", delta0, LARGEST_NUMBER)
    size = check_real("amplitude", amplitude)
    depth = size - clearance
    if depth <= 0.0:
        raise InputError(
            f"amplitude must be above delta0 = {clearance!r} for the rotor to touch, got {size!r}"
        )
    if not SMALLEST_DEPTH <= depth <= LARGEST_NUMBER:
        allowed = f"from {SMALLEST_DEPTH:g} to {LARGEST_NUMBER:g}"
        raise InputError(f"amplitude must be {allowed} above delta0, got {size!r}")
    return depth, clearance


def _speed(depth: float) -> float:
    return math.sqrt(0.8) * math.pow(depth, 1.25)
