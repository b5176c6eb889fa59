"""Eqs (18), (20)-(23), (29) and (31) as printed: amplitudes and phases of the whirls."""

from __future__ import annotations

import cmath
import math

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from rotor_ida.checks import check_nonnegative, check_positive
from rotor_ida.equations.contact import contact_force

Values = npt.NDArray[np.float64]

_POINTS = 4001
_LARGEST = 1e3


def amplitudes_18(*, omega: float, zeta: float) -> Values:
    """Return the amplitudes of all whirls of eq. (18) as printed.

    Parameters
    ----------
    omega, zeta : float
        Spin speed, above zero, and damping ratio [1].

    Returns
    -------
    ndarray, shape (n,)
        Amplitudes up to 1000, increasing [1].

    Raises
    ------
    InputError
        If a value is not a finite real number, negative, or `omega` is zero.

    Notes
    -----
    Wrong: the force ``z |z|**1.5`` has a factor |z| too much. Right is ``z |z|**0.5``, which
    eqs (14) and (21)-(23) have; `rotor_ida.synchronous_response` gives its three whirls.

    References
    ----------
    Eq. (18) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> amplitudes_18(omega=1.7, zeta=0.07).round(5)
    array([2.52403])
    """
    return amplitudes_29(omega=omega, zeta=zeta, delta0=0.0)


def amplitudes_29(*, omega: float, zeta: float, delta0: float) -> Values:
    """Return the amplitudes of all contacting whirls of eq. (29) as printed.

    Parameters
    ----------
    omega, zeta, delta0 : float
        Spin speed, above zero, damping ratio and clearance [1].

    Returns
    -------
    ndarray, shape (n,)
        Amplitudes above `delta0` and up to 1000, increasing [1]; two whose indentations lie
        within a hundredth of each other may be missed.

    Raises
    ------
    InputError
        If a value is not a finite real number, negative, or `omega` is zero.

    Notes
    -----
    Wrong: the force ``z H (|z| - delta0)**1.5`` lacks the ``1/|z|`` of eqs (7), (10) and (30).

    References
    ----------
    Eq. (29) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> amplitudes_29(omega=1.2, zeta=0.07, delta0=0.5).round(5)
    array([2.13615])
    """
    q = check_positive("omega", omega) ** 2
    loss = 4.0 * check_nonnegative("zeta", zeta) ** 2 * q
    clearance = check_nonnegative("delta0", delta0)

    def excess(A: float) -> float:
        stiffness = float(contact_force(A, clearance))
        return A * A * ((stiffness - q) ** 2 + loss) - q * q

    depths = np.concatenate([[0.0], np.geomspace(1e-9, _LARGEST, _POINTS)])
    grid = [clearance + float(depth) for depth in depths]
    values = [excess(A) for A in grid]
    found = [
        brentq(excess, low, high, xtol=1e-14, rtol=1e-14)
        for low, high, a, b in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True)
        if a * b < 0.0
    ]
    return np.array(found)


def phase_23(amplitude: float, *, omega: float, zeta: float) -> float:
    """Return the phase of eq. (23) as printed, ``arctan(2 zeta omega/(A**0.5 - omega**2))``.

    Parameters
    ----------
    amplitude : float
        Amplitude A [1], above zero.
    omega, zeta : float
        Spin speed and damping ratio [1].

    Returns
    -------
    float
        What is printed [rad].

    Raises
    ------
    InputError
        If a value is not a finite real number, negative, or `amplitude` is zero.

    Notes
    -----
    Wrong above resonance: the one-argument arctangent loses the quadrant. Right is
    ``atan2(2 zeta omega, A**0.5 - omega**2)``, between 0 and pi.

    References
    ----------
    Eq. (23) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> round(phase_23(1.8796312367, omega=1.7, zeta=0.07), 5)
    -0.15542
    """
    A = check_positive("amplitude", amplitude)
    speed, damping = check_nonnegative("omega", omega), check_nonnegative("zeta", zeta)
    rest = math.sqrt(A) - speed**2
    return math.atan(2.0 * damping * speed / rest) if rest else 0.5 * math.pi


def transfer_21(amplitude: float, *, omega: float, zeta: float) -> complex:
    """Return H of eqs (20)-(22) as printed, ``omega**2/(A**0.5 - omega**2 + 2 i zeta omega)``.

    Parameters
    ----------
    amplitude : float
        Amplitude A [1], above zero.
    omega, zeta : float
        Spin speed and damping ratio [1].

    Returns
    -------
    complex
        H [1]. Its modulus is beta of eq. (22); on a whirl that is A again, so that (22) does not
        give the amplitude but is an equation for it.

    Raises
    ------
    InputError
        If a value is not a finite real number, negative, or `amplitude` is zero.

    Notes
    -----
    Wrong: it is printed as ``beta exp(i theta)``, whose argument is minus the phase lag theta of
    eq. (19). Right is ``beta exp(-i theta)``.

    References
    ----------
    Eqs (20)-(22) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> H = transfer_21(1.8796312367, omega=1.7, zeta=0.07)
    >>> round(abs(H), 6), round(cmath.phase(H), 5)
    (1.879631, -2.98617)
    """
    A = check_positive("amplitude", amplitude)
    speed, damping = check_positive("omega", omega), check_nonnegative("zeta", zeta)
    return speed**2 / complex(math.sqrt(A) - speed**2, 2.0 * damping * speed)


def phase_31(amplitude: float, *, omega: float, zeta: float, delta0: float) -> float:
    """Return the phase of eq. (31) as printed, with ``f(A)/A**2`` for the stiffness.

    Parameters
    ----------
    amplitude : float
        Amplitude A [1], above zero.
    omega, zeta, delta0 : float
        Spin speed, damping ratio and clearance [1].

    Returns
    -------
    float
        Phase in (0, pi) [rad]: the quadrant, which eq. (31) loses too, is put right here, so
        that the factor alone is seen.

    Raises
    ------
    InputError
        If a value is not a finite real number, negative, or `amplitude` is zero.

    Notes
    -----
    Wrong: right is ``f(A)/A``, as eq. (30) has it.

    References
    ----------
    Eq. (31) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> round(phase_31(4.3190034, omega=1.2, zeta=0.07, delta0=0.5), 5)
    2.98142
    """
    A = check_positive("amplitude", amplitude)
    speed, damping = check_nonnegative("omega", omega), check_nonnegative("zeta", zeta)
    stiffness = float(contact_force(A, check_nonnegative("delta0", delta0))) / A**2
    return cmath.phase(complex(stiffness - speed**2, 2.0 * damping * speed))
