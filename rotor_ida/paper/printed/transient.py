"""Eqs (24)-(28) as printed: the "general solution" of the forced rotor without clearance."""

from __future__ import annotations

import cmath
import math
from typing import Literal

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import State, check_choice, check_nonnegative, check_positive, check_state
from rotor_ida.errors import InputError
from rotor_ida.paper.printed.whirls import phase_23

ComplexValues = npt.NDArray[np.complex128]

RATES = ("28", "24", "stiffness")


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
        Times [1].
    start : tuple of float
        ``(x, y, vx, vy)`` at time 0 [1].
    omega, zeta : float
        Spin speed and damping ratio [1].
    amplitude : float
        Amplitude A of the whirl that the last term is to be [1]; the equation printed for it is
        implicit and has up to three solutions.
    mended : bool
        Whether to mend the signs: phase ``omega t - theta`` for ``omega t + theta``, and theta
        in its quadrant.
    rates : {"28", "24", "stiffness"}
        Which lambda: below eq. (28), ``-zeta +- sqrt(zeta**2 - 1)``; below eq. (24),
        ``+-omega_0``, which is +-1 here; or ``-zeta +- sqrt(zeta**2 - A**0.5)``, which at least
        belongs to a linear equation that the last term solves too.

    Returns
    -------
    ndarray of complex, shape (n,)
        z = x + i y [1].

    Raises
    ------
    InputError
        If an argument cannot be used, or the two lambdas are one.

    Notes
    -----
    Wrong in kind: the equation is nonlinear, and solutions do not add up. None of the three
    lambdas makes it one; epsilon in the phase is undefined and taken as 1. There is no general
    solution in closed form; `rotor_ida.simulate` integrates instead.

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
