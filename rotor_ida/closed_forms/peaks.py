"""The response curve at given amplitude: the backbone, the two flanks, and the peak."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.optimize import brentq

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    LARGEST_NUMBER,
    check_axis,
    check_nonnegative,
    check_points,
    check_positive,
)
from rotor_ida.equations.contact import contact_force, secant_stiffness
from rotor_ida.schema import labelled_dataset

# With less damping the tip lies beyond the range of doubles.
SMALLEST_DAMPING = 1e-20


def backbone(amplitude: object, delta0: float = 0.0) -> Values:
    """Return the speed on the backbone: that of a free circular whirl.

    Parameters
    ----------
    amplitude : float or sequence of float, shape (n,)
        Amplitudes A [1].
    delta0 : float
        Clearance [1].

    Returns
    -------
    ndarray, shape (n,)
        ``omega = sqrt(f(A)/A)`` [1]; zero inside the clearance.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive.

    References
    ----------
    Eq. (17) of the paper, Mechanika 25(6), 2019, as a speed.

    Examples
    --------
    >>> backbone([1.0, 16.0])
    array([1., 2.])
    """
    clearance = check_nonnegative("delta0", delta0, LARGEST_NUMBER)
    A = check_axis("amplitude", amplitude, largest=LARGEST_NUMBER)
    return np.sqrt(secant_stiffness(A, clearance))


def speeds_at_amplitude(amplitude: object, *, zeta: float, delta0: float) -> Values:
    """Return the two speeds at which a contacting whirl has a given amplitude.

    Parameters
    ----------
    amplitude : float or sequence of float, shape (n,)
        Amplitudes A [1].
    zeta, delta0 : float
        Damping ratio and clearance [1].

    Returns
    -------
    ndarray, shape (n, 2)
        The slower and the faster speed [1]: the flank below resonance and the one above; NaN
        where the curve has no such point, and inside the clearance.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive.

    Notes
    -----
    With ``q = omega**2`` and ``s = f(A)/A`` the curve is the quadratic
    ``(A**2 - 1) q**2 + A**2 (4 zeta**2 - 2 s) q + A**2 s**2 = 0``. Unlike the curve at given
    speeds it needs no search, and it has full resolution near the tip, whose amplitude is
    `peak_amplitude`. Below A = 1 only the flank below resonance is left.

    References
    ----------
    Eqs (21)-(23) of the paper, Mechanika 25(6), 2019, with the force corrected.

    Examples
    --------
    >>> speeds_at_amplitude([0.5, 2.0], zeta=0.0, delta0=0.0)
    array([[0.48549177,        nan],
           [0.97098354, 1.68179283]])
    """
    m = 4.0 * check_nonnegative("zeta", zeta, LARGEST_NUMBER) ** 2
    A = check_axis("amplitude", amplitude, largest=LARGEST_NUMBER)
    clearance = check_nonnegative("delta0", delta0, LARGEST_NUMBER)
    s = secant_stiffness(A, clearance)
    inside = _discriminant(A, s, m)
    exists = (s > 0.0) & (inside >= 0.0) & ((A < 1.0) | (2.0 * s > m))
    slower, faster = flank_speeds(A, m, clearance)
    faster = np.where(A > 1.0, faster, np.nan)
    return np.where(exists[:, None], np.stack([slower, faster], axis=1), np.nan)


def _discriminant(A: Values, s: Values, m: float) -> Values:
    """Return the discriminant of the quadratic in q over ``4 A**4``."""
    # as a product: near the tip the sum would cancel
    rest = np.sqrt(np.maximum((A - 1.0) * (A + 1.0), 0.0))
    lean = np.divide(2.0 * s, A, out=np.zeros_like(A), where=A > 0.0) - m * A
    product = (lean - m * rest) * (lean + m * rest)
    return np.where(A >= 1.0, product, lean**2 + m**2 * (1.0 - A) * (1.0 + A))


def flank_speeds(A: Values, m: float, delta0: float) -> tuple[Values, Values]:
    """Return the slower and the faster speed at amplitudes that the curve has."""
    return speeds_of_stiffness(A, m, secant_stiffness(A, delta0))


def speeds_of_stiffness(A: Values, m: float, s: Values) -> tuple[Values, Values]:
    """Return the same where force over radius is `s`, of ring and shaft together."""
    middle = 2.0 * s - m
    root = np.sqrt(np.maximum(_discriminant(A, s, m), 0.0))
    # the slower speed is 2 s**2/(middle + root); written so that nothing cancels
    total = middle + root
    below_one = 2.0 * (1.0 - A) * (1.0 + A)
    conjugate = np.divide(A * A * (root - middle), below_one, out=np.zeros_like(A), where=A < 1.0)
    direct = np.divide(2.0 * s * s, total, out=np.zeros_like(A), where=total > 0.0)
    slower = np.where(middle > 0.0, direct, conjugate)
    faster = np.divide(A * A * total, -below_one, out=np.full_like(A, np.inf), where=A > 1.0)
    return np.sqrt(slower), np.sqrt(np.maximum(faster, 0.0))


def peak_amplitude(*, zeta: float, delta0: float) -> float:
    """Return the largest amplitude on the response curve of contacting whirls.

    Parameters
    ----------
    zeta, delta0 : float
        Damping ratio, above zero, since without damping the curve has no tip, and clearance [1].

    Returns
    -------
    float
        Amplitude of the tip [1]; NaN where the damping is so strong that the amplitude stays
        below 1 and only approaches it at high speed.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, or `zeta` is zero.

    Notes
    -----
    At the tip the two speeds of `speeds_at_amplitude` are one, which is where
    ``h(A) = (A - delta0)**1.5 / (A**2 (A + sqrt(A**2 - 1))) = 2 zeta**2``. Beyond the last
    maximum of h, a root of ``3 A**4 - (12 delta0**2 - 1) A**2 - 8 delta0 A + 16 delta0**2``,
    h falls for ever.

    References
    ----------
    Eqs (21)-(23) of the paper, Mechanika 25(6), 2019, with the force corrected.

    Examples
    --------
    >>> tip = peak_amplitude(zeta=0.07, delta0=0.0)
    >>> round(tip, 6), speeds_at_amplitude(tip - 1e-9, zeta=0.07, delta0=0.0).round(3).tolist()
    (13.7..., [[1.9..., 1.9...]])
    """
    damping = check_axis(
        "zeta", check_positive("zeta", zeta), smallest=SMALLEST_DAMPING, largest=LARGEST_NUMBER
    )
    found = tips(float(damping[0]), check_nonnegative("delta0", delta0, LARGEST_NUMBER))
    return found[-1] if found else math.nan


def tips(zeta: float, delta0: float) -> list[float]:
    """Return the amplitudes above 1 at which the flanks meet, ascending; none without damping."""
    if zeta == 0.0:
        return []

    def excess(A: float) -> float:
        decay = float(A * A * (A + np.sqrt((A - 1.0) * (A + 1.0))))
        return float((A - delta0) ** 1.5) / decay - 2.0 * zeta * zeta

    lowest = max(1.0, delta0)
    highest = max(lowest, (2.0 * zeta * zeta) ** (-2.0 / 3.0)) * 1.000001 + 1e-6
    turns = np.roots([3.0, 0.0, 1.0 - 12.0 * delta0**2, -8.0 * delta0, 16.0 * delta0**2])
    turns = np.sort(turns.real[np.abs(turns.imag) < 1e-9 * (1.0 + delta0)])
    turns = turns[(turns > lowest) & (turns < highest)]
    edges = [lowest, *(float(turn) for turn in turns), highest]
    return [
        float(brentq(excess, low, high, xtol=1e-300, rtol=4.0 * np.finfo(float).eps))
        for low, high in pairwise(edges)
        if (excess(low) >= 0.0) != (excess(high) >= 0.0)
    ]


def tip_speed(A: float, zeta: float, delta0: float) -> float:
    """Return the one speed at a tip, ``omega**2 = A**2 (s - 2 zeta**2)/(A**2 - 1)``."""
    s = float(secant_stiffness(A, delta0))
    return math.sqrt(A * A * (s - 2.0 * zeta * zeta) / ((A - 1.0) * (A + 1.0)))


def peaks(*, zeta: npt.ArrayLike, delta0: npt.ArrayLike) -> xr.Dataset:
    """Return the largest contacting whirl for each damping and clearance.

    Parameters
    ----------
    zeta, delta0 : float or sequence of float, shapes (m,) and (k,)
        Damping ratios, above zero, and clearances [1].

    Returns
    -------
    Dataset
        On (zeta, delta0): ``peak_amplitude``, ``peak_omega`` and ``peak_contact_force`` [1];
        NaN where the damping leaves no peak.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, or a damping is zero.

    Notes
    -----
    At the tip the quadratic of `speeds_at_amplitude` has one root,
    ``omega**2 = A**2 (s - 2 zeta**2)/(A**2 - 1)`` with ``s = f(A)/A``.

    References
    ----------
    Section 4.2.1 and Fig. 10 of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> found = peaks(zeta=0.07, delta0=[0.0, 2.0])
    >>> found.peak_amplitude.values.round(3), found.peak_contact_force.values.round(2)
    (array([[13.768, 11.346]]), array([[51.09, 28.57]]))
    """
    dampings = check_axis("zeta", zeta, smallest=SMALLEST_DAMPING, largest=LARGEST_NUMBER)
    clearances = check_axis("delta0", delta0, largest=LARGEST_NUMBER)
    check_points(dampings, clearances)
    table = np.array([[_peak(float(z), float(d)) for d in clearances] for z in dampings])
    names = ("peak_amplitude", "peak_omega", "peak_contact_force")
    return labelled_dataset(
        "Largest contacting whirls of a rotor with Hertz contact and clearance",
        {name: (("zeta", "delta0"), table[..., k]) for k, name in enumerate(names)},
        {"zeta": ("zeta", dampings), "delta0": ("delta0", clearances)},
    )


def _peak(zeta: float, delta0: float) -> tuple[float, float, float]:
    A = peak_amplitude(zeta=zeta, delta0=delta0)
    if math.isnan(A):
        return math.nan, math.nan, math.nan
    return A, tip_speed(A, zeta, delta0), float(contact_force(A, delta0))
