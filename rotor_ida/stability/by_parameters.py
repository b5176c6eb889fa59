"""What small changes of omega, zeta and delta0 add to a motion in contact, over a step of it.

With P(t) the derivative of the state at a time t of the step by that at its beginning, and b what a
parameter adds to the rate of change, it adds by the end

    P integral of P**-1 b dt.

The flow is conformally symplectic (`rotor_ida.cycles.multipliers`): ``P^T S P = exp(-2 zeta t) S``,
so that ``P**-1 = exp(2 zeta t) S**-1 P^T S``. The integrand is known wherever the series of a step
are read, and they converge so far that a quadrature by Gauss of few points is exact to rounding.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.compiling import shared
from rotor_ida.simulation.contact_phase import Q, T, cartesian
from rotor_ida.simulation.tangents import COUNT
from rotor_ida.simulation.taylor.motion import Taylor

Values = npt.NDArray[np.float64]

# The last terms of a series over its step are a part exp(-2 order) of the first: the error of so
# many points is below 1e-16.
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_PARTS, _SHARES = 0.5 * (1.0 + _PLACES), 0.5 * _WEIGHTS


@shared
def added_by_parameters(motion: Taylor, end: float, matrix: Values, added: Values) -> None:
    """Write what omega, zeta and delta0 add to the state over a step, up to the point `end`.

    Parameters
    ----------
    motion : Taylor
        A motion whose tangents began the step as the unit matrix.
    end : float
        A point of its last step.
    matrix : ndarray, shape (4, 4)
        Derivative of the state there by that at the beginning of the step [1].
    added : ndarray, shape (3, 4)
        Overwritten; without clearance the last row is 0: the force does not change smoothly there.
    """
    length, drawn, pulled = end - motion.low, np.zeros((3, 4)), np.empty((3, 4))
    for part, share in zip(_PARTS, _SHARES):  # noqa: B905 - numba knows no strict
        read = motion.glance_at(motion.low + part * length)
        passed, pace = part * length, 1.0
        if motion.regularised:
            passed, pace = read[T] - motion.before[T], read[Q]
        weight = share * length * pace * math.exp(2.0 * motion.zeta * passed)
        _turned_rates(motion, read, pulled)
        there = read[motion.size :]
        for row in range(3):
            for i in range(4):
                along = 0.0
                for j in range(4):
                    along += there[COUNT * j + i] * pulled[row, j]
                drawn[row, i] += weight * along
    for row in range(3):
        x, y, vx, vy = -drawn[row, 2], -drawn[row, 3], drawn[row, 0], drawn[row, 1]
        for j in range(4):
            added[row, j] = (
                matrix[j, 0] * x + matrix[j, 1] * y + matrix[j, 2] * vx + matrix[j, 3] * vy
            )


@shared
def _turned_rates(motion: Taylor, read: Values, turned: Values) -> None:
    """Write S b for each parameter: b = (b1, b2, b3, b4) becomes (b3, b4, -b1, -b2).

    By omega b is ``(y, -x, 2 omega + vy, -vx)``, by zeta ``(0, 0, -2 vx, -2 vy)``, and by delta0
    ``f' (0, 0, c, s)``, with c and s the direction of the rotor.
    """
    bend = 0.0
    z, w = complex(read[0], read[1]), complex(read[2], read[3])
    if motion.regularised:
        z, w = cartesian(read, motion.delta0)
        bend = 1.5 * read[Q] / (motion.delta0 + read[Q] ** 2)
    turned[0, 0], turned[0, 1] = 2.0 * motion.omega + w.imag, -w.real
    turned[0, 2], turned[0, 3] = -z.imag, z.real
    turned[1, 0], turned[1, 1] = -2.0 * w.real, -2.0 * w.imag
    turned[2, 0], turned[2, 1] = bend * z.real, bend * z.imag
    turned[1:, 2:] = 0.0
