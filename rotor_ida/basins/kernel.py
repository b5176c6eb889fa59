"""Many starts followed side by side, each until its attractor is certain or its time is up.

All orbits of one rotor are integrated on the rotating axes in lockstep: every quantity is a row of
`LANES` numbers in one flat array, one orbit in each lane. A step advances all lanes with one loop
that the compiler turns into vector instructions; each lane keeps its own time and step. A lane
whose orbit is decided takes the next start.

Labels: first come the whirls in contact, by number; then the whirls that never touch the ring again
(`free_label`), those that touch it ever more slightly (`fading_label`), and the limit cycles.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.crossings import FIRST_STEP, crosses, section_value
from rotor_ida.basins.fading import MOST_DRIFT
from rotor_ida.basins.lanes import (
    BUFFER,
    INSIDE,
    LANES,
    STEP,
    TIME,
    U,
    V,
    X,
    Y,
    remember_step,
    step_lanes,
)
from rotor_ida.equations.compiling import compiled_for_lanes, inlined_for_lanes

Values = npt.NDArray[np.float64]
Labels = npt.NDArray[np.int16]
Times = npt.NDArray[np.float32]

CHAOTIC, NOT_COMPUTED, UNDECIDED = -3, -2, -1
NO_START = -1
MOST_STEPS = 200_000


@inlined_for_lanes
def find_trapped(lanes: Values, regions: Values) -> None:
    """Write into the row INSIDE 1 + the number of the trapping region that holds the lane, or 0."""
    for i in range(LANES):
        lanes[INSIDE + i] = 0.0
    for number in range(regions.shape[0]):
        cx, cy, cu, cv, a, b, c, d, e, f, g, k, m, n = regions[number]
        code = number + 1.0
        for i in range(LANES):
            x, y = lanes[X + i] - cx, lanes[Y + i] - cy
            u, v = lanes[U + i] - cu, lanes[V + i] - cv
            first, second = a * x + b * y + c * u + d * v, e * y + f * u + g * v
            third, fourth = k * u + m * v, n * v
            square = first * first + second * second + third * third + fourth * fourth
            lanes[INSIDE + i] = code if square <= 1.0 else lanes[INSIDE + i]


@inlined_for_lanes
def find_contact_free(
    lanes: Values, code: float, omega: float, zeta: float, delta0: float | None, free: Values
) -> None:
    """Write `code` into the row INSIDE where an orbit will never touch the ring again.

    Out of contact the centre of the whirl moves straight from c to c + drift; the orbit stays
    inside the clearance exactly when both ends do with the whirl's own radius to spare. Where it
    comes to rest but a little too far out, its touches fade: `code` + 1.
    """
    wx, wy, room, edge = free[0], free[1], free[2], free[3]
    per = 0.5 / zeta
    ring = 0.0 if delta0 is None else delta0 * delta0
    most_drift = 0.5 * MOST_DRIFT / math.sqrt(room)
    for i in range(LANES):
        # on the rotating axes the whirl stands still at w and its velocity is i omega w
        x, y = lanes[X + i] - wx, lanes[Y + i] - wy
        u = x + per * (lanes[U + i] + omega * wy)
        v = y + per * (lanes[V + i] - omega * wx)
        end = u * u + v * v
        farthest = max(x * x + y * y, end)
        drift = (u - x) * (u - x) + (v - y) * (v - y)
        square = lanes[X + i] * lanes[X + i] + lanes[Y + i] * lanes[Y + i]
        outside = most_drift * max(end - room, 0.0)
        fades = (end <= edge) & (drift < outside * outside) & (square < ring)
        lanes[INSIDE + i] = code + 1.0 if fades else lanes[INSIDE + i]
        lanes[INSIDE + i] = code if farthest <= room else lanes[INSIDE + i]


@inlined_for_lanes
def find_on_cycles(
    lanes: Values, sections: Values, first: float, rotor: tuple[float, float, float | None]
) -> None:
    """Write `first` + the number of a limit cycle into the row INSIDE where it holds the lane."""
    omega, zeta, delta0 = rotor
    for number in range(sections.shape[0]):
        section = sections[number]
        for i in range(LANES):
            if crosses(lanes, i, section):
                value = section_value(lanes, i, section, omega, zeta, delta0)
                lanes[INSIDE + i] = first + number if value <= 1.0 else lanes[INSIDE + i]


@inlined_for_lanes
def next_waiting(labels: Labels, number: int) -> int:
    """Return the first start from `number` on that has no label yet, or their total."""
    while number < labels.shape[0] and labels[number] >= 0:
        number += 1
    return number


@inlined_for_lanes
def load_start(lanes: Values, i: int, states: Values, number: int) -> int:
    """Put a start into a lane and return its number; without one, leave the lane at rest."""
    if number >= states.shape[1]:
        lanes[X + i] = lanes[Y + i] = lanes[U + i] = lanes[V + i] = 0.0
        lanes[TIME + i], lanes[STEP + i] = 0.0, 0.0
        return NO_START
    lanes[X + i], lanes[Y + i] = states[0, number], states[1, number]
    lanes[U + i], lanes[V + i] = states[2, number], states[3, number]
    lanes[TIME + i], lanes[STEP + i] = 0.0, FIRST_STEP
    return number


@inlined_for_lanes
def record_result(
    lanes: Values, i: int, states: Values, labels: Labels, times: Times, number: int
) -> None:
    """Copy the result of a start from its lane."""
    labels[number] = np.int16(lanes[INSIDE + i]) - 1 if lanes[INSIDE + i] > 0.0 else UNDECIDED
    times[number] += np.float32(lanes[TIME + i])
    states[0, number], states[1, number] = lanes[X + i], lanes[Y + i]
    states[2, number], states[3, number] = lanes[U + i], lanes[V + i]


@compiled_for_lanes
def follow(
    states: Values,
    labels: Labels,
    times: Times,
    rotor: tuple[float, float, float | None],
    regions: Values,
    free: Values,
    sections: Values,
    duration: float,
    tolerance: float,
    stop: npt.NDArray[np.uint8],
) -> None:
    """Follow each start until a trapping region holds it or `duration` has passed.

    Parameters
    ----------
    states : ndarray, shape (4, n)
        Starts on the rotating axes [1]; overwritten by the states at the end.
    labels : ndarray of int16, shape (n,)
        Becomes the number of the trapping region, ``len(regions)`` for the contact-free ones, one
        more for fading touches, from two more on that of the limit cycle, or UNDECIDED. What is
        not done when `stop` is set stays NOT_COMPUTED. Starts that have a label of zero or more
        already are left alone.
    times : ndarray of float32, shape (n,)
        The time that each took is added [1].
    rotor : tuple of float
        omega, zeta and delta0, None for no clearance [1].
    regions : ndarray, shape (m, 14)
        Centre and upper triangular factor of each trapping region.
    free : ndarray, shape (4,)
        Contact-free whirl on the rotating axes, and the squared radii within which its centre
        must stay, and from within which touches fade; negative if there is no such whirl.
    sections : ndarray, shape (k, SECTION)
        Of each limit cycle a section with the set on it that returns into itself.
    duration, tolerance : float
        Longest time to follow, and tolerance of a step [1].
    stop : ndarray of uint8, shape (1,)
        Set to 1 by another thread to end early.
    """
    omega, zeta, delta0 = rotor
    lanes, owner = np.zeros(BUFFER), np.full(LANES, NO_START)
    steps = np.zeros(LANES, dtype=np.int64)
    waiting, active = 0, 0
    for i in range(LANES):
        waiting = next_waiting(labels, waiting)
        owner[i] = load_start(lanes, i, states, waiting)
        waiting += 1
        active += owner[i] != NO_START
    remember_step(lanes)
    while active > 0 and stop[0] == 0:
        find_trapped(lanes, regions)
        if free[2] >= 0.0:
            find_contact_free(lanes, regions.shape[0] + 1.0, omega, zeta, delta0, free)
        find_on_cycles(lanes, sections, regions.shape[0] + 3.0, rotor)
        for i in range(LANES):
            steps[i] += 1
            under_way = lanes[TIME + i] < duration and steps[i] < MOST_STEPS
            if owner[i] == NO_START or (under_way and lanes[INSIDE + i] == 0.0):
                continue
            record_result(lanes, i, states, labels, times, owner[i])
            waiting = next_waiting(labels, waiting)
            owner[i] = load_start(lanes, i, states, waiting)
            waiting += 1
            active -= owner[i] == NO_START
            steps[i] = 0
        if sections.shape[0] > 0:
            remember_step(lanes)
        step_lanes(lanes, omega, zeta, delta0, tolerance)
