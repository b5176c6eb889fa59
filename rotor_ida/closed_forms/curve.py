"""The response curve from the other side: the speeds that give a wanted amplitude."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_nonnegative, check_positive
from rotor_ida.equations.contact import secant_stiffness

Values = npt.NDArray[np.float64]

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


def curve(amplitude: object, *, zeta: float, delta0: float) -> Values:
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
    >>> curve([0.5, 2.0], zeta=0.0, delta0=0.0)
    array([[0.48549177,        nan],
           [0.97098354, 1.68179283]])
    """
    m = 4.0 * check_nonnegative("zeta", zeta, LARGEST_NUMBER) ** 2
    A = check_axis("amplitude", amplitude, largest=LARGEST_NUMBER)
    s = secant_stiffness(A, check_nonnegative("delta0", delta0, LARGEST_NUMBER))
    middle = 2.0 * s - m
    # the discriminant over 4 A**4, as a product: near the tip the sum would cancel
    rest = np.sqrt(np.maximum((A - 1.0) * (A + 1.0), 0.0))
    lean = np.divide(2.0 * s, A, out=np.zeros_like(A), where=A > 0.0) - m * A
    product = (lean - m * rest) * (lean + m * rest)
    inside = np.where(A >= 1.0, product, lean**2 + m**2 * (1.0 - A) * (1.0 + A))
    exists = (s > 0.0) & (inside >= 0.0) & ((A < 1.0) | (middle > 0.0))
    root = np.sqrt(np.where(exists, inside, 0.0))
    # the slower speed is 2 s**2/(middle + root); written so that nothing cancels
    denominator = middle + root
    conjugate = np.divide(
        A * A * (root - middle), 2.0 * (1.0 - A) * (1.0 + A), out=np.zeros_like(A), where=A < 1.0
    )
    direct = np.divide(2.0 * s * s, denominator, out=np.zeros_like(A), where=denominator > 0.0)
    slower = np.where(middle > 0.0, direct, conjugate)
    faster = np.divide(
        A * A * denominator,
        2.0 * (A - 1.0) * (A + 1.0),
        out=np.full_like(A, np.nan),
        where=exists & (A > 1.0),
    )
    return np.asarray(np.sqrt(np.stack([np.where(exists, slower, np.nan), faster], axis=1)))


def peak_amplitude(*, zeta: float, delta0: float) -> float:
    """Return the largest amplitude on the response curve of contacting whirls.

    Parameters
    ----------
    zeta : float
        Damping ratio [1], above zero: without damping the curve has no tip.
    delta0 : float
        Clearance [1].

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
    At the tip the two speeds of `curve` are one, which is where
    ``h(A) = (A - delta0)**1.5 / (A**2 (A + sqrt(A**2 - 1))) = 2 zeta**2``. Beyond the last
    maximum of h, a root of ``3 A**4 - (12 delta0**2 - 1) A**2 - 8 delta0 A + 16 delta0**2``,
    h falls for ever.

    References
    ----------
    Eqs (21)-(23) of the paper, Mechanika 25(6), 2019, with the force corrected.

    Examples
    --------
    >>> tip = peak_amplitude(zeta=0.07, delta0=0.0)
    >>> round(tip, 6), curve(tip - 1e-9, zeta=0.07, delta0=0.0).round(3).tolist()
    (13.7..., [[1.9..., 1.9...]])
    """
    damping = check_axis(
        "zeta", check_positive("zeta", zeta), smallest=SMALLEST_DAMPING, largest=LARGEST_NUMBER
    )
    m = 4.0 * float(damping[0]) ** 2
    clearance = check_nonnegative("delta0", delta0, LARGEST_NUMBER)

    def excess(A: float) -> float:
        decay = float(A * A * (A + np.sqrt((A - 1.0) * (A + 1.0))))
        return float((A - clearance) ** 1.5) / decay - 0.5 * m

    lowest = max(1.0, clearance)
    highest = max(lowest, (0.5 * m) ** (-2.0 / 3.0)) * 1.000001 + 1e-6
    quartic = [3.0, 0.0, 1.0 - 12.0 * clearance**2, -8.0 * clearance, 16.0 * clearance**2]
    turns = np.roots(quartic)
    turns = np.sort(turns.real[np.abs(turns.imag) < 1e-9 * (1.0 + clearance)])
    turns = turns[(turns > lowest) & (turns < highest)]
    edges = [lowest, *(float(turn) for turn in turns), highest]
    for low, high in zip(edges[-2::-1], edges[:0:-1], strict=True):
        if excess(low) >= 0.0 > excess(high):
            return float(brentq(excess, low, high, xtol=1e-300, rtol=4.0 * np.finfo(float).eps))
    return float("nan")
