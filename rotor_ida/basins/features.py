"""Features of a motion over whole revolutions: extreme radii, mean whirl, stray from the mean."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.lanes import LANES, State, U, V, X, Y, moved, rate
from rotor_ida.equations.compiling import compiled_for_lanes, inlined_for_lanes, widest_vectors

Values = npt.NDArray[np.float64]

# Rows beyond those of the state: sums, extremes, and the two squared radii before the present one.
SUM_X, SUM_Y, LOW_X, HIGH_X, LOW_Y, HIGH_Y, LOW, HIGH, LAST, BEFORE = (
    LANES * row for row in range(4, 14)
)
ROWS = 14

# Weights of the classic Runge-Kutta method of order 4, six times.
CLASSIC = (1.0, 2.0, 2.0, 1.0)

# Columns of the result.
RADIUS_MIN, RADIUS_MAX, MEAN_X, MEAN_Y, WANDER = range(5)
COLUMNS = 5


@inlined_for_lanes
def shifted(z: State, h: float, k: State) -> State:
    """Return ``z + h k``."""
    return (z[0] + h * k[0], z[1] + h * k[1], z[2] + h * k[2], z[3] + h * k[3])


@inlined_for_lanes
def measure_step(lanes: Values, h: float, omega: float, zeta: float, delta0: float | None) -> None:
    """Advance every lane by a classic Runge-Kutta step and update its features."""
    widest_vectors()
    for i in range(LANES):
        z = (lanes[X + i], lanes[Y + i], lanes[U + i], lanes[V + i])
        k1 = rate(z, omega, zeta, delta0)
        k2 = rate(shifted(z, 0.5 * h, k1), omega, zeta, delta0)
        k3 = rate(shifted(z, 0.5 * h, k2), omega, zeta, delta0)
        k4 = rate(shifted(z, h, k3), omega, zeta, delta0)
        x, y, u, v = moved(z, h / 6.0, CLASSIC, (k1, k2, k3, k4))
        lanes[X + i], lanes[Y + i], lanes[U + i], lanes[V + i] = x, y, u, v
        lanes[SUM_X + i] += x
        lanes[SUM_Y + i] += y
        lanes[LOW_X + i] = min(lanes[LOW_X + i], x)
        lanes[HIGH_X + i] = max(lanes[HIGH_X + i], x)
        lanes[LOW_Y + i] = min(lanes[LOW_Y + i], y)
        lanes[HIGH_Y + i] = max(lanes[HIGH_Y + i], y)
        square, last, before = x * x + y * y, lanes[LAST + i], lanes[BEFORE + i]
        # the vertex of the parabola through three squared radii, where the middle one is extreme
        bend = before - 2.0 * last + square
        tilt = 0.125 * (before - square) * (before - square)
        vertex = last - tilt / (bend if bend != 0.0 else 1.0)
        top = (last >= before) & (last >= square)
        bottom = (last <= before) & (last <= square)
        lanes[HIGH + i] = max(lanes[HIGH + i], vertex if top else square)
        lanes[LOW + i] = min(lanes[LOW + i], vertex if bottom else square)
        lanes[BEFORE + i] = last
        lanes[LAST + i] = square


@compiled_for_lanes
def measure(
    states: Values,
    rotor: tuple[float, float, float | None],
    step: float,
    count: int,
    features: Values,
    stop: npt.NDArray[np.uint8],
) -> None:
    """Follow each state for `count` steps and describe its motion by features.

    Parameters
    ----------
    states : ndarray, shape (4, n)
        States on the rotating axes [1]; overwritten by those at the end.
    rotor : tuple of float
        omega, zeta and delta0, None for no clearance [1].
    step : float
        Step of time [1].
    count : int
        Number of steps.
    features : ndarray, shape (n, 5)
        Becomes smallest and largest radius, mean position on the rotating axes, and the largest
        distance from there to a corner of the box in which the motion stays [1].
    stop : ndarray of uint8, shape (1,)
        Set to 1 by another thread to end early.
    """
    omega, zeta, delta0 = rotor
    lanes = np.zeros(ROWS * LANES)
    for first in range(0, states.shape[1], LANES):
        used = min(LANES, states.shape[1] - first)
        for i in range(used):
            x, y = states[0, first + i], states[1, first + i]
            lanes[X + i], lanes[Y + i] = x, y
            lanes[U + i], lanes[V + i] = states[2, first + i], states[3, first + i]
            lanes[SUM_X + i] = lanes[SUM_Y + i] = 0.0
            lanes[LOW_X + i], lanes[HIGH_X + i] = x, x
            lanes[LOW_Y + i], lanes[HIGH_Y + i] = y, y
            square = x * x + y * y
            lanes[LOW + i] = lanes[HIGH + i] = lanes[LAST + i] = lanes[BEFORE + i] = square
        for _ in range(count):
            if stop[0] != 0:
                return
            measure_step(lanes, step, omega, zeta, delta0)
        for i in range(used):
            j = first + i
            states[0, j], states[1, j] = lanes[X + i], lanes[Y + i]
            states[2, j], states[3, j] = lanes[U + i], lanes[V + i]
            x, y = lanes[SUM_X + i] / count, lanes[SUM_Y + i] / count
            features[j, RADIUS_MIN] = math.sqrt(max(lanes[LOW + i], 0.0))
            features[j, RADIUS_MAX] = math.sqrt(lanes[HIGH + i])
            features[j, MEAN_X], features[j, MEAN_Y] = x, y
            features[j, WANDER] = math.hypot(
                max(lanes[HIGH_X + i] - x, x - lanes[LOW_X + i]),
                max(lanes[HIGH_Y + i] - y, y - lanes[LOW_Y + i]),
            )
