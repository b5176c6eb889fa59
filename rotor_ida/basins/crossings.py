"""Orbits side by side that pass a section of a limit cycle, and where on it.

A section is the plane across the field at one state of a cycle. An orbit that passes it within the
set ``|L (s - c)| <= 1`` comes back into it, if the set was chosen so (`cycle_sections`).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.lanes import (
    BUFFER,
    LANES,
    STEP,
    TIME,
    TIME_WAS,
    U_WAS,
    V_WAS,
    X_WAS,
    Y_WAS,
    State,
    U,
    V,
    X,
    Y,
    moved,
    rate,
    remember_step,
    step_lanes,
)
from rotor_ida.equations.compiling import compiled_for_lanes, inlined_for_lanes

Values = npt.NDArray[np.float64]

# Numbers of a section: its state c, the unit normal, the three rows of L, and the squared distance
# from c within which the set lies.
SECTION = 21
FIRST_STEP = 0.02
# Weights of the classic Runge-Kutta method of order 4, six times, and its steps to a section.
CLASSIC = (1.0, 2.0, 2.0, 1.0)
PARTS = 4
# The place of a crossing on a step is found by so many halvings of a cubic.
HALVINGS = 12
# By the cubic alone an orbit may be this far outside, in parts of the set, to be looked at closely.
ROUGHLY = 3.0


@inlined_for_lanes
def crosses(lanes: Values, i: int, section: Values) -> bool:
    """Return whether the last step in a lane passed a section, the way its cycle does, close by."""
    cx, cy, cu, cv = section[0], section[1], section[2], section[3]
    nx, ny, nu, nv = section[4], section[5], section[6], section[7]
    x, y, u, v = lanes[X + i] - cx, lanes[Y + i] - cy, lanes[U + i] - cu, lanes[V + i] - cv
    a, b = lanes[X + i] - lanes[X_WAS + i], lanes[Y + i] - lanes[Y_WAS + i]
    c, d = lanes[U + i] - lanes[U_WAS + i], lanes[V + i] - lanes[V_WAS + i]
    after = nx * x + ny * y + nu * u + nv * v
    before = after - (nx * a + ny * b + nu * c + nv * d)
    far = x * x + y * y + u * u + v * v > 2.0 * (section[20] + a * a + b * b + c * c + d * d)
    passed: bool = (before < 0.0) & (after >= 0.0) & (not far)
    return passed


@inlined_for_lanes
def section_value(
    lanes: Values, i: int, section: Values, omega: float, zeta: float, delta0: float | None
) -> float:
    """Return ``|L (s - c)|**2`` where the last step in a lane passed the section."""
    was = (lanes[X_WAS + i], lanes[Y_WAS + i], lanes[U_WAS + i], lanes[V_WAS + i])
    now = (lanes[X + i], lanes[Y + i], lanes[U + i], lanes[V + i])
    h = lanes[TIME + i] - lanes[TIME_WAS + i]
    first, last = rate(was, omega, zeta, delta0), rate(now, omega, zeta, delta0)
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if height(between(was, now, first, last, h, middle), section) < 0.0:
            low = middle
        else:
            high = middle
    rough = between(was, now, first, last, h, high)
    value = size_on_section(rough, rate(rough, omega, zeta, delta0), section)
    if value > ROUGHLY:
        return value
    state, part = was, h * high / PARTS
    for _ in range(PARTS):
        state = classic_step(state, part, omega, zeta, delta0)
    return size_on_section(state, rate(state, omega, zeta, delta0), section)


@inlined_for_lanes
def between(was: State, now: State, first: State, last: State, h: float, part: float) -> State:
    """Return the state at a part of a step, by the cubic through both ends with their rates."""
    rest = 1.0 - part
    a, b = rest * rest * (1.0 + 2.0 * part), part * part * (1.0 + 2.0 * rest)
    c, d = h * part * rest * rest, -h * part * part * rest
    return (
        a * was[0] + b * now[0] + c * first[0] + d * last[0],
        a * was[1] + b * now[1] + c * first[1] + d * last[1],
        a * was[2] + b * now[2] + c * first[2] + d * last[2],
        a * was[3] + b * now[3] + c * first[3] + d * last[3],
    )


@inlined_for_lanes
def height(z: State, section: Values) -> float:
    """Return how far a state is beyond a section."""
    beyond: float = (
        section[4] * (z[0] - section[0])
        + section[5] * (z[1] - section[1])
        + section[6] * (z[2] - section[2])
        + section[7] * (z[3] - section[3])
    )
    return beyond


@inlined_for_lanes
def size_on_section(z: State, k: State, section: Values) -> float:
    """Return ``|L (s - c)|**2`` of the state on the section that a state close to it flows to."""
    along = section[4] * k[0] + section[5] * k[1] + section[6] * k[2] + section[7] * k[3]
    shift = height(z, section) / along
    a, b = z[0] - section[0] - shift * k[0], z[1] - section[1] - shift * k[1]
    c, d = z[2] - section[2] - shift * k[2], z[3] - section[3] - shift * k[3]
    total = 0.0
    for row in range(3):
        place = 8 + 4 * row
        part = (
            section[place] * a
            + section[place + 1] * b
            + section[place + 2] * c
            + section[place + 3] * d
        )
        total += part * part
    return total


@inlined_for_lanes
def shifted(z: State, h: float, k: State) -> State:
    """Return ``z + h k``."""
    return (z[0] + h * k[0], z[1] + h * k[1], z[2] + h * k[2], z[3] + h * k[3])


@inlined_for_lanes
def classic_step(z: State, h: float, omega: float, zeta: float, delta0: float | None) -> State:
    """Return the state a time h later, by the classic Runge-Kutta method."""
    k1 = rate(z, omega, zeta, delta0)
    k2 = rate(shifted(z, 0.5 * h, k1), omega, zeta, delta0)
    k3 = rate(shifted(z, 0.5 * h, k2), omega, zeta, delta0)
    k4 = rate(shifted(z, h, k3), omega, zeta, delta0)
    return moved(z, h / 6.0, CLASSIC, (k1, k2, k3, k4))


@compiled_for_lanes
def measure_returns(
    states: Values,
    rotor: tuple[float, float, float | None],
    section: Values,
    times: tuple[float, float],
    tolerance: float,
    values: Values,
    stop: npt.NDArray[np.uint8],
) -> None:
    """Write the least ``|L (s - c)|**2`` with which states pass a section between two times.

    Parameters
    ----------
    states : ndarray, shape (4, n)
        States on the rotating axes [1].
    rotor : tuple of float
        omega, zeta and delta0, None for no clearance [1].
    section : ndarray, shape (SECTION,)
        The section.
    times : tuple of float
        Earliest and latest time [1].
    tolerance : float
        Of a step [1].
    values : ndarray, shape (n,)
        Becomes the values; infinite where a state does not pass it [1].
    stop : ndarray of uint8, shape (1,)
        Set to 1 by another thread to end early.
    """
    omega, zeta, delta0 = rotor
    earliest, latest = times
    lanes = np.zeros(BUFFER)
    values[:] = np.inf
    for first in range(0, states.shape[1], LANES):
        used = min(LANES, states.shape[1] - first)
        for i in range(LANES):
            number = first + min(i, used - 1)
            lanes[X + i], lanes[Y + i] = states[0, number], states[1, number]
            lanes[U + i], lanes[V + i] = states[2, number], states[3, number]
            lanes[TIME + i], lanes[STEP + i] = 0.0, FIRST_STEP
        slowest = 0.0
        while slowest < latest and stop[0] == 0:
            remember_step(lanes)
            step_lanes(lanes, omega, zeta, delta0, tolerance)
            slowest = latest
            for i in range(used):
                slowest = min(slowest, lanes[TIME + i])
                if earliest <= lanes[TIME + i] <= latest and crosses(lanes, i, section):
                    value = section_value(lanes, i, section, omega, zeta, delta0)
                    values[first + i] = min(values[first + i], value)
