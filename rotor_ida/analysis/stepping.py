"""One Runge-Kutta step of the state and its four tangent vectors, with an estimate of its error.

A bundle, shape (5, 4), is the state ``(x, y, vx, vy)`` on the rotating axes and, row by row, four
tangent vectors.

References
----------
.. [1] E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd ed.,
   Springer, 1993, section II.10: DOP853 and its error estimates.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy.integrate import DOP853

from rotor_ida.compiling import compiled
from rotor_ida.model import rotating_field_into, rotating_jacobian_into

Values = npt.NDArray[np.float64]

STAGES = 12
# The estimate falls like the sixth power of the step.
ERROR_POWER = -1.0 / 6.0
_A = np.ascontiguousarray(DOP853.A)
_B = np.ascontiguousarray(DOP853.B)
_E5 = np.ascontiguousarray(DOP853.E5)


@compiled
def write_rate(
    bundle: Values, rate: Values, matrix: Values, rotor: tuple[float, float, float]
) -> None:
    """Write the rate of change of the state and of its tangent vectors."""
    omega, zeta, delta0 = rotor
    rotating_field_into(bundle[0], rate[0], omega, zeta, delta0)
    rotating_jacobian_into(bundle[0], matrix, omega, zeta, delta0)
    for i in range(1, 5):
        for j in range(4):
            total = 0.0
            for k in range(4):
                total += matrix[j, k] * bundle[i, k]
            rate[i, j] = total


@compiled
def step(
    bundle: Values,
    size: float,
    rates: Values,
    trial: Values,
    matrix: Values,
    rotor: tuple[float, float, float],
    rtol: float,
) -> float:
    """Write the bundle after one step into `trial`; return its error in tolerances.

    ``rates[0]`` holds the rate at the beginning of the step. The error is the estimate of order
    five alone: the smaller one that [1]_ makes of it trusts in derivatives that the force of a
    rotor without clearance lacks at the centre, where it let through errors of 1e4 tolerances.
    """
    for stage in range(1, STAGES + 1):
        for i in range(5):
            for j in range(4):
                total = 0.0
                for k in range(stage):
                    weight = _A[stage, k] if stage < STAGES else _B[k]
                    total += weight * rates[k, i, j]
                trial[i, j] = bundle[i, j] + size * total
        write_rate(trial, rates[stage], matrix, rotor)
    worst = 0.0
    for i in range(5):
        scale = 0.0
        square = 0.0
        for j in range(4):
            scale = max(scale, abs(bundle[i, j]), abs(trial[i, j]))
            error = 0.0
            for k in range(STAGES + 1):
                error += _E5[k] * rates[k, i, j]
            square += error**2
        if square > 0.0:
            worst = max(worst, 0.5 * size * math.sqrt(square) / (rtol * scale))
    return worst
