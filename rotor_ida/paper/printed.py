"""The paper's formulas as printed, where they are wrong, for comparison with the correct ones.

Nothing else in this package uses them. Each docstring states the error and the correction. All
raise `rotor_ida.InputError` for numbers that are not finite, are negative, or are zero where the
docstring says "above zero".
"""

from __future__ import annotations

import cmath
import math
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.checks import State, check_choice, check_nonnegative, check_positive, check_state
from rotor_ida.errors import InputError
from rotor_ida.model.contact import contact_force, contact_potential
from rotor_ida.model.rotor import DimensionalRotor

RATES = ("28", "24", "stiffness")


def reference_frequency(machine: DimensionalRotor) -> float:
    """Return ``sqrt(k/m)``, the number that eqs (8) and (9) call the reference frequency.

    Parameters
    ----------
    machine : DimensionalRotor
        The machine.

    Returns
    -------
    float
        ``sqrt(k/m)`` in SI units, which are not 1/s: k is in N/m^1.5.

    Notes
    -----
    Wrong: a Hertz stiffness over a mass is not a squared frequency. Correct:
    ``omega_0**2 = k sqrt(D)/m``, `DimensionalRotor.reference_frequency`.

    References
    ----------
    Eqs (8) and (9) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> round(reference_frequency(machine)), round(machine.reference_frequency)
    (15811, 500)
    """
    return math.sqrt(machine.contact_stiffness / machine.mass)


def hamiltonian(states: npt.ArrayLike, delta0: float) -> Values:
    """Return eq. (13) as printed, ``|z|**2/2 + (2/5) (|z| - delta0)_+**2.5``.

    Parameters
    ----------
    states : array_like, shape (..., 4)
        States ``(x, y, vx, vy)`` [dimensionless].
    delta0 : float
        Radial clearance [dimensionless].

    Returns
    -------
    ndarray, shape (...)
        Printed value [dimensionless].

    Notes
    -----
    Wrong: it is not conserved. Correct: ``|z'|**2/2`` in the first term,
    `rotor_ida.model.equations.energy`.

    References
    ----------
    Eq. (13) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> float(hamiltonian((1.5, 0.0, 0.0, 2.0), 0.5))
    1.525
    """
    x, y, _, _ = np.moveaxis(np.asarray(states, dtype=np.float64), -1, 0)
    return np.asarray(0.5 * (x**2 + y**2) + contact_potential(np.hypot(x, y), delta0))


def natural_frequency(amplitude: float) -> float:
    """Return ``sqrt(A**0.5)``, eq. (17a).

    Parameters
    ----------
    amplitude : float
        Amplitude A [dimensionless], above zero.

    Returns
    -------
    float
        Frequency [dimensionless].

    Notes
    -----
    Correct for a whirl on a circle without clearance. For motion on a line, which Fig. 5 shows, it
    is wrong: `rotor_ida.closed_forms.planar_period`.

    References
    ----------
    Eq. (17a) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> natural_frequency(16.0)
    2.0
    """
    return math.sqrt(math.sqrt(check_positive("amplitude", amplitude)))


def period(amplitude: float) -> float:
    """Return ``2 pi/sqrt(A**0.5)``, eq. (17b).

    Parameters
    ----------
    amplitude : float
        Amplitude A [dimensionless], above zero.

    Returns
    -------
    float
        Period [dimensionless].

    Notes
    -----
    Correct for a whirl on a circle without clearance; on a line it is 4.746 % too short. It falls
    with the amplitude, though section 3.2 says that it grows.

    References
    ----------
    Eq. (17b) and section 3.2 of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> round(period(2.0), 5), round(period(8.0), 5)
    (5.28351, 3.736)
    """
    return 2.0 * math.pi / natural_frequency(amplitude)


def amplitudes_18(*, omega: float, zeta: float) -> Values:
    """Return the amplitudes of all whirls of eq. (18) as printed.

    Parameters
    ----------
    omega, zeta : float
        Spin speed, above zero, and damping ratio [dimensionless].

    Returns
    -------
    ndarray, shape (n,)
        Amplitudes up to 1000, increasing [dimensionless].

    Notes
    -----
    Wrong: the force ``z |z|**1.5`` has an extra factor ``|z|``. Correct: ``z |z|**0.5``, as in
    eqs (14) and (21)-(23); `rotor_ida.synchronous_response` gives its three whirls.

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
        Spin speed, above zero, damping ratio and clearance [dimensionless].

    Returns
    -------
    ndarray, shape (n,)
        Amplitudes above `delta0` and up to 1000, increasing [dimensionless]; two whose indentations
        lie within a hundredth of each other may be missed.

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

    depths = np.concatenate([[0.0], np.geomspace(1e-9, 1e3, 4001)])
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
        Amplitude A [dimensionless], above zero.
    omega, zeta : float
        Spin speed and damping ratio [dimensionless].

    Returns
    -------
    float
        Printed value [rad].

    Notes
    -----
    Wrong above resonance: the one-argument arctangent loses the quadrant. Correct:
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
        Amplitude A [dimensionless], above zero.
    omega, zeta : float
        Spin speed, above zero, and damping ratio [dimensionless].

    Returns
    -------
    complex
        H [dimensionless]. Its modulus is beta of eq. (22). On a whirl that equals A, so (22) does
        not give the amplitude but is an equation for it.

    Notes
    -----
    Wrong: it is printed as ``beta exp(i theta)``, whose argument is minus the phase lag theta of
    eq. (19). Correct: ``beta exp(-i theta)``.

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
        Amplitude A [dimensionless], above zero.
    omega, zeta, delta0 : float
        Spin speed, damping ratio and clearance [dimensionless].

    Returns
    -------
    float
        Phase in (0, pi) [rad]. The quadrant, which eq. (31) also loses, is corrected here, so that
        only the wrong factor remains.

    Notes
    -----
    Wrong. Correct: ``f(A)/A``, as in eq. (30).

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


def general_solution(
    time: npt.ArrayLike,
    *,
    start: State,
    omega: float,
    zeta: float,
    amplitude: float,
    mended: bool = False,
    rates: Literal["28", "24", "stiffness"] = "28",
) -> ComplexValues:
    """Return z(t) of eq. (28): two exponentials and a whirl.

    Parameters
    ----------
    time : array_like, shape (n,)
        Times [dimensionless].
    start : tuple of float
        ``(x, y, vx, vy)`` at time 0 [dimensionless].
    omega, zeta : float
        Spin speed, above zero, and damping ratio [dimensionless].
    amplitude : float
        Amplitude A, above zero, of the whirl in the last term [dimensionless]; the printed equation
        for it is implicit and has up to three solutions.
    mended : bool
        Whether to correct the signs: phase ``omega t - theta`` for ``omega t + theta``, and theta
        in its quadrant.
    rates : {"28", "24", "stiffness"}
        Which lambda: below eq. (28), ``-zeta +- sqrt(zeta**2 - 1)``; below eq. (24),
        ``+-omega_0``, which is +-1 here; or ``-zeta +- sqrt(zeta**2 - A**0.5)``, which at least
        belong to a linear equation that the last term solves too.

    Returns
    -------
    ndarray of complex, shape (n,)
        z = x + i y [dimensionless].

    Raises
    ------
    InputError
        If an argument cannot be used, or the two lambdas are equal.

    Notes
    -----
    Wrong in principle: the equation is nonlinear, so solutions do not superpose. None of the three
    lambdas makes it a solution. Epsilon in the phase is undefined and taken as 1. There is no
    general solution in closed form; `rotor_ida.simulate` integrates instead.

    References
    ----------
    Eqs (24)-(28) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    At the start it fits, by the choice of its two constants:

    >>> z = general_solution(0.0, start=(10, 0, 0, 0), omega=1.7, zeta=0.07, amplitude=9.4872)
    >>> bool(abs(z - 10.0) < 1e-12)
    True
    """
    x, y, vx, vy = check_state("start", start)
    A = check_positive("amplitude", amplitude)
    speed, damping = check_positive("omega", omega), check_nonnegative("zeta", zeta)
    check_choice("rates", rates, RATES)
    theta = (
        -math.atan2(2.0 * damping * speed, math.sqrt(A) - speed**2)
        if mended
        else phase_23(A, omega=speed, zeta=damping)
    )
    whirl = cmath.rect(A, theta)
    one, two = _rates(rates, damping, A)
    r, rate = complex(x, y), complex(vx, vy)
    C3 = (r * two - rate - whirl * two + 1j * speed * whirl) / (two - one)
    C4 = (r * one - rate - whirl * one + 1j * speed * whirl) / (one - two)
    t = np.asarray(time, dtype=np.float64)
    solution = C3 * np.exp(one * t) + C4 * np.exp(two * t) + whirl * np.exp(1j * speed * t)
    return np.asarray(solution)


def _rates(rates: str, zeta: float, amplitude: float) -> tuple[complex, complex]:
    """Return lambda 1 and 2, the coefficients of t in the two exponentials."""
    if rates == "24":
        return 1.0 + 0j, -1.0 + 0j
    square = 1.0 if rates == "28" else math.sqrt(amplitude)
    root = cmath.sqrt(zeta**2 - square)
    if root == 0.0:
        raise InputError(f"zeta must not make the two exponents one, got {zeta!r}")
    return -zeta + root, -zeta - root
