"""Orbits side by side: one adaptive step in every lane at once, on the rotating axes.

Every quantity is a row of `LANES` numbers in one flat array, one orbit in each lane. With constant
distances between the rows the compiler sees that they do not overlap, and turns the loop over the
lanes, which has no branches, into vector instructions. The sums over the stages
of the method have constant numbers of terms, so that they are unrolled.

References
----------
.. [1] Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed., 1993,
   section II.5 and the program DOP853: the method of Dormand and Prince of order 8, and how its
   error is estimated. SciPy holds its coefficients.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.integrate import DOP853

from rotor_ida.equations.compiling import inlined_for_lanes, widest_vectors

Values = npt.NDArray[np.float64]
State = tuple[float, float, float, float]

# So many keep the vector units busy while the buffer stays in the innermost cache.
LANES = 64
X, Y, U, V, TIME, STEP, INSIDE = (LANES * row for row in range(7))
# State and time before the last step.
X_WAS, Y_WAS, U_WAS, V_WAS, TIME_WAS = (LANES * row for row in range(7, 12))
BUFFER = 12 * LANES


def _weights(row: Values) -> tuple[float, ...]:
    """Return the weights that are not zero: each stage uses only some of the rates."""
    return tuple(float(weight) for weight in row if weight != 0.0)


(
    STAGE_2, STAGE_3, STAGE_4, STAGE_5, STAGE_6, STAGE_7, STAGE_8, STAGE_9, STAGE_10, STAGE_11,
    STAGE_12,
) = (_weights(row) for row in DOP853.A[1:12])  # fmt: skip
ADVANCE, ERROR_3, ERROR_5 = _weights(DOP853.B), _weights(DOP853.E3), _weights(DOP853.E5)

SHRINK, GROW, CAUTION = 0.2, 5.0, 0.9
# An error below this is not seen of a step over the ring. In the time h after the ring is crossed
# at a speed v the force puts the velocity off by about v**1.5 h**2.5: the shortest step.
SEEN, KINK, SHORTEST = 1e-8, 2.5, 0.25
# Below this a radius or a depth counts as this; its force is nothing.
_TINY = 1e-30
_HOPELESS = 1e30


@inlined_for_lanes
def weighted(weights: tuple[float, ...], rates: tuple[State, ...], part: int) -> float:
    """Return the weighted sum of one component of the rates."""
    total = 0.0
    for j in range(len(weights)):
        total += weights[j] * rates[j][part]
    return total


@inlined_for_lanes
def moved(z: State, h: float, weights: tuple[float, ...], rates: tuple[State, ...]) -> State:
    """Return ``z + h * sum(weights * rates)``."""
    return (
        z[0] + h * weighted(weights, rates, 0),
        z[1] + h * weighted(weights, rates, 1),
        z[2] + h * weighted(weights, rates, 2),
        z[3] + h * weighted(weights, rates, 3),
    )


@inlined_for_lanes
def size(weights: tuple[float, ...], rates: tuple[State, ...]) -> float:
    """Return the squared length of the weighted sum of the rates."""
    a, b = weighted(weights, rates, 0), weighted(weights, rates, 1)
    c, d = weighted(weights, rates, 2), weighted(weights, rates, 3)
    return a * a + b * b + c * c + d * d


@inlined_for_lanes
def secant(square: float, delta0: float | None) -> float:
    """Return ``s(r) = f(r)/r`` from ``r**2``; a clearance of None stands for 0.

    Roots are taken in single precision and polished by one step of Newton's method to a relative
    error of about 1e-13, in a third of the time of the processor's own double roots.
    """
    bounded = max(square, _TINY)
    if delta0 is None:  # s = sqrt(r), from the inverse fourth root of r**2
        y: float = np.float64(np.float32(1.0) / np.sqrt(np.sqrt(np.float32(bounded))))
        y = y * (1.25 - 0.25 * (bounded * (y * y) * (y * y)))
        return bounded * y * y * y
    y = inverse_root(bounded)
    depth = max(bounded * y - delta0, _TINY)
    return depth * depth * inverse_root(depth) * y


@inlined_for_lanes
def inverse_root(value: float) -> float:
    """Return ``1/sqrt(value)``."""
    y = np.float64(np.float32(1.0) / np.sqrt(np.float32(value)))
    return y * (1.5 - 0.5 * (value * y * y))


@inlined_for_lanes
def rate(z: State, omega: float, zeta: float, delta0: float | None) -> State:
    """Return the rate of a state on the rotating axes, as `equations.model.rotating_field`."""
    x, y, u, v = z
    restoring = secant(x * x + y * y, delta0)
    damping = 2.0 * zeta
    return (
        u + omega * y,
        v - omega * x,
        omega * omega - damping * u + omega * v - restoring * x,
        -damping * v - omega * u - restoring * y,
    )


@inlined_for_lanes
def remember_step(lanes: Values) -> None:
    """Write the present states and times into the rows of those before the next step."""
    for i in range(5 * LANES):
        lanes[X_WAS + i] = lanes[X + i]


@inlined_for_lanes
def step_lanes(
    lanes: Values, omega: float, zeta: float, delta0: float | None, tolerance: float
) -> None:
    """Try one step in every lane; a step whose error is too large is taken back and made smaller.

    The error is measured against ``tolerance * sqrt(1 + x**2 + y**2 + vx**2 + vy**2)``. It is not
    seen of a step over the ring, where the force begins as ``depth**1.5``: such a step is taken
    back until it is so short that the force in it is below the tolerance.
    """
    widest_vectors()
    ring = 0.0 if delta0 is None else delta0 * delta0
    shortest = SHORTEST if tolerance < SEEN else np.inf
    over = shortest * tolerance ** (1.0 / KINK)
    for i in range(LANES):
        x, y, u, v = lanes[X + i], lanes[Y + i], lanes[U + i], lanes[V + i]
        h = lanes[STEP + i]
        z = (x, y, u, v)
        k1 = rate(z, omega, zeta, delta0)
        k2 = rate(moved(z, h, STAGE_2, (k1,)), omega, zeta, delta0)
        k3 = rate(moved(z, h, STAGE_3, (k1, k2)), omega, zeta, delta0)
        k4 = rate(moved(z, h, STAGE_4, (k1, k3)), omega, zeta, delta0)
        k5 = rate(moved(z, h, STAGE_5, (k1, k3, k4)), omega, zeta, delta0)
        k6 = rate(moved(z, h, STAGE_6, (k1, k4, k5)), omega, zeta, delta0)
        k7 = rate(moved(z, h, STAGE_7, (k1, k4, k5, k6)), omega, zeta, delta0)
        k8 = rate(moved(z, h, STAGE_8, (k1, k4, k5, k6, k7)), omega, zeta, delta0)
        k9 = rate(moved(z, h, STAGE_9, (k1, k4, k5, k6, k7, k8)), omega, zeta, delta0)
        k10 = rate(moved(z, h, STAGE_10, (k1, k4, k5, k6, k7, k8, k9)), omega, zeta, delta0)
        k11 = rate(moved(z, h, STAGE_11, (k1, k4, k5, k6, k7, k8, k9, k10)), omega, zeta, delta0)
        k12 = rate(
            moved(z, h, STAGE_12, (k1, k4, k5, k6, k7, k8, k9, k10, k11)), omega, zeta, delta0
        )
        late = (k1, k6, k7, k8, k9, k10, k11, k12)
        nx, ny, nu, nv = moved(z, h, ADVANCE, late)
        fifth, third = size(ERROR_5, late), size(ERROR_3, late)
        error = h * h * fifth * fifth / (fifth + 0.01 * third + 1e-300)
        error = error / ((1.0 + x * x + y * y + u * u + v * v) * (tolerance * tolerance))
        error = error if error < _HOPELESS else _HOPELESS  # also where a long step overflowed
        good = error <= 1.0
        before, after = x * x + y * y - ring, nx * nx + ny * ny - ring
        far = (delta0 is not None) & good & (before * after < 0.0) & (h > over)
        good = good & (not far)
        # the eighth root of the error itself, in single precision: it only chooses the step
        root = np.sqrt(np.sqrt(np.sqrt(np.sqrt(np.float32(error + 1e-30)))))
        factor = np.float64(np.float32(CAUTION) / root)
        # to just short of the ring, where it is crossed by the shortest step
        part = h * before / (before - after) - 0.5 * over if far else 0.0
        lanes[STEP + i] = max(part, 0.9 * over) if far else h * max(min(factor, GROW), SHRINK)
        lanes[TIME + i] += h if good else 0.0
        lanes[X + i] = nx if good else x
        lanes[Y + i] = ny if good else y
        lanes[U + i] = nu if good else u
        lanes[V + i] = nv if good else v
