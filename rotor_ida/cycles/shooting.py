"""Close an orbit by Newton's method: single shooting across all entries and exits.

The unknowns are a state s and the period T. With the flow phi,

    phi(s, T) = s,    f(s0) . (s - s0) = 0,

The second is needed because any shift along the cycle solves the first: the state may not move
along the field at the present one. Without contact there is no cycle: a motion inside the clearance
closes too, on a circle about the centre of its whirl, but belongs to a neutral family.

Under a load, or in unequal bearings, the motion is not autonomous on the rotating axes: it repeats
itself after whole revolutions, and begins with the unbalance at angle 0. Then the period is known,
no shift along the cycle solves the equations, and only the state is unknown.
"""

from __future__ import annotations

import math

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.cycles.continuation import shooting_equations
from rotor_ida.cycles.orbit import Orbit, followed
from rotor_ida.errors import SimulationError
from rotor_ida.simulation.flow import DiscFlow, Flow

# Largest number of Newton steps; a distant guess needs some of them to come near.
MOST_STEPS = 25
# Largest relative change of state or period in a step: beyond it the linear equations fail.
LONGEST_STEP = 0.25
# A step this small, relative to state and period, leaves an error of its square, below rounding.
CONVERGED = 1e-9
# A step this small and no smaller than the one before is the last too: rounding limits it.
STALLED = 1e3 * CONVERGED
# Largest relative gap of a closed orbit, times the size of M, which amplifies rounding at the
# start: a few thousand roundings.
LARGEST_MISS = 1e-12
# On the rotating axes a synchronous whirl is stationary: an orbit that moves by less than this
# fraction of its size in its duration is one, and its period is only rounding. So is one whose
# radii vary by at most this fraction.
STANDSTILL = 1e-7
FOUND_A_WHIRL = "Newton's method came to a whirl of constant radius"
LEFT_THE_RING = "Newton's method came to a whirl inside the clearance"
# An orbit that returns to its start to this fraction before its end repeats a shorter cycle; the
# gap of a closed orbit is far smaller.
BACK_AT_START = 1e-8


def close_orbit(flow: Flow, state: Values, period: float) -> Orbit:
    """Return the limit cycle near a state and a period, which is rounded to those of the flow.

    Raises
    ------
    SimulationError
        If Newton's method does not converge, or to no limit cycle.
    """
    if flow.period is not None:
        period = periods_of(flow, period) * flow.period
    orbit, last = followed(flow, state, period), math.inf
    for _ in range(MOST_STEPS):
        step = _newton_step(orbit)
        scale = float(np.linalg.norm(orbit.start)) or 1.0
        size = max(float(np.linalg.norm(step[:-1])) / scale, abs(float(step[-1])) / orbit.duration)
        if size > STALLED and closes(orbit):  # at a fold: rounding, divided by nothing
            return checked_cycle(orbit)
        if size > LONGEST_STEP:
            step *= LONGEST_STEP / size
        before = orbit
        orbit = followed(flow, orbit.start + step[:-1], orbit.duration + step[-1])
        if size <= CONVERGED or (size < STALLED and size >= last):
            # near a fold or a corner the last step may lead away again
            return checked_cycle(orbit if closes(orbit) else before)
        last = size
    raise failure(orbit, f"Newton's method found no limit cycle in {MOST_STEPS} steps")


def periods_of(flow: Flow, duration: float) -> int:
    """Return the number of revolutions, at least one, nearest to a duration."""
    return max(1, round(duration / flow.revolution))


def once_round(cycle: Orbit) -> Orbit:
    """Return a limit cycle over its smallest period, if it was followed over several."""
    flow, most = cycle.flow, periods_of(cycle.flow, cycle.duration)
    if cycle.is_autonomous:  # as often as its radii turn
        most = 1 + max(len(each) // 2 for each in cycle.radii)
    for times in range(most, 1, -1):
        if not cycle.is_autonomous and most % times:
            continue
        part = followed(flow, cycle.start, cycle.duration / times)
        if part.residual <= BACK_AT_START:
            return close_orbit(flow, cycle.start, part.duration)
    return cycle


def checked_cycle(orbit: Orbit) -> Orbit:
    """Return an orbit that is a limit cycle.

    Raises
    ------
    SimulationError
        If it does not close, is a whirl of constant radius, or never touches the stator.
    """
    if not closes(orbit):
        raise failure(orbit, f"the orbit misses its start by {orbit.residual:.3g} of its size")
    low, high = orbit.sizes.reshape(2, -1) if all(map(len, orbit.radii)) else np.zeros((2, 1))
    if not (high - low > STANDSTILL * high).any():
        raise failure(orbit, FOUND_A_WHIRL)
    if not orbit.touches:
        raise failure(orbit, LEFT_THE_RING)
    return orbit


def closes(orbit: Orbit) -> bool:
    """Return whether an orbit returns to its start, up to rounding."""
    return orbit.residual <= LARGEST_MISS * max(math.hypot(*orbit.monodromy.flat), 1.0)


def failure(orbit: Orbit, reason: str) -> SimulationError:
    """Return the error of a Newton iteration that ended at an orbit."""
    if not isinstance(orbit.flow, DiscFlow):
        told = f"period {orbit.duration:.9g}, speed {orbit.flow.speed:.9g}"
        return SimulationError(f"{reason}: {told}")
    rotor, (x, y, vx, vy) = orbit.rotor, orbit.start.tolist()
    return SimulationError(
        f"{reason}: period {orbit.duration:.9g}, omega {rotor.omega:.9g}, "
        f"zeta {rotor.zeta:.9g}, delta0 {rotor.delta0:.9g}",
        time=0.0, state=(x, y, vx, vy),
    )  # fmt: skip


def _newton_step(orbit: Orbit) -> Values:
    """Return the step of state and period, shape (n + 1,); that of a known period is 0."""
    rate, n = orbit.start_rate, orbit.start.size
    moved = float(np.linalg.norm(rate)) * orbit.duration
    if orbit.is_autonomous and moved <= STANDSTILL * float(np.linalg.norm(orbit.start)):
        raise failure(orbit, FOUND_A_WHIRL)
    miss, matrix = shooting_equations(orbit, rate)
    if not orbit.is_autonomous:
        matrix[n], matrix[n, n] = 0.0, 1.0
    try:
        step = np.asarray(np.linalg.solve(matrix, miss), dtype=np.float64)
    except np.linalg.LinAlgError:
        step = np.asarray(np.linalg.lstsq(matrix, miss)[0], dtype=np.float64)
    if not np.isfinite(step).all():
        raise failure(orbit, "Newton's method reached an orbit whose neighbours close as well")
    return step
