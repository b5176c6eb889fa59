"""Cycles of a rotor system over the speed: the curve to follow, and the whirls it is born from."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.cycles.birth import birth_between, oscillation
from rotor_ida.cycles.continuation import Curve, Point, Problem, shooting_equations
from rotor_ida.cycles.guess import DOUBLING
from rotor_ida.cycles.multipliers import nontrivial, torus_factors
from rotor_ida.cycles.problems import (
    FOLD,
    GRAZE,
    SLIDING,
    TORUS,
    Continuation,
    doubled,
)
from rotor_ida.cycles.shooting import FOUND_A_WHIRL, LEFT_THE_RING
from rotor_ida.cycles.special_points import Count
from rotor_ida.cycles.system_orbit import SystemOrbit, at_speed
from rotor_ida.errors import SimulationError
from rotor_ida.steady.system_flow import SystemFlow
from rotor_ida.systems.axisymmetric import forward_motions
from rotor_ida.systems.receptances import solved_motions
from rotor_ida.systems.whirls.at_speeds import sliding
from rotor_ida.systems.whirls.branches import RubProblem, Touching
from rotor_ida.systems.whirls.turning_axes import normal_forces

# Largest relative gap of a closed orbit, times the size of M.
LARGEST_MISS = 1e-11
# An orbit that moves by less than this part of its size in its duration is a whirl.
STANDSTILL = 1e-6
# Largest number of periods in a guess, and the relative gap of an orbit that repeats itself.
MOST_PERIODS, BACK_AT_START = 8, 1e-8
# Size of the oscillation, relative to that of the whirl, with which a branch leaves a Hopf point.
FIRST_SWING = 2e-2

HOPF = "hopf"
# Factors of a test function smaller than this show in it; many larger ones leave its size alone.
NEAR_ZERO = 0.03


def _test(factors: ComplexValues) -> float:
    """Return the product of factors, each over its size where that is not small.

    A system of slight damping has many multipliers near the unit circle, and the product of the
    factors themselves would be small everywhere.
    """
    return float(np.prod(factors / np.sqrt(np.abs(factors) ** 2 + NEAR_ZERO**2)).real)


TESTS: dict[str, Callable[[Point[SystemOrbit], Point[SystemOrbit]], float]] = {
    FOLD: lambda point, _: _test(1.0 - nontrivial(point.stretch)),
    DOUBLING: lambda point, _: _test(1.0 + nontrivial(point.stretch)),
    TORUS: lambda point, _: _test(torus_factors(point.stretch)),
}
COUNTS: dict[str, Count[SystemOrbit]] = {
    GRAZE: Count(lambda orbit: sum(orbit.contact_counts), lambda orbit: orbit.nearest_gap),
    SLIDING: Count(lambda orbit: orbit.sliding_changes, lambda _: math.inf),
}


@dataclass(frozen=True, slots=True)
class SystemGuess:
    """A guess of a limit cycle of a rotor system.

    Parameters
    ----------
    flow : SystemFlow
        The motion at its speed.
    state : ndarray, shape (n,)
        A state, in scaled coordinates.
    period : float or None
        Its approximate period; None if not known.
    special : str
        Kind of special point of a branch; empty if it is none.
    slope : float
        Rate of the speed along its branch; 1 if it is not a point of one.
    """

    flow: SystemFlow
    state: Values
    period: float | None = None
    special: str = ""
    slope: float = 1.0


def closed_orbit(flow: SystemFlow, state: Values, period: float) -> SystemOrbit:
    """Return the limit cycle near a state, followed over its smallest period.

    Raises
    ------
    SimulationError
        If Newton's method does not converge, or to no limit cycle.
    """
    cycle = _closed(flow, state, period)
    for count in range(MOST_PERIODS, 1, -1):
        part = cycle.duration / count
        if not cycle.is_autonomous and _revolutions(flow, cycle.duration) % count:
            continue
        back = flow.after(cycle.start, part) - cycle.start
        if np.abs(back).max() <= BACK_AT_START * cycle.size:
            return _closed(flow, cycle.start, part)
    return cycle


def _closed(flow: SystemFlow, state: Values, period: float) -> SystemOrbit:
    line = curve_of(flow, state, period)
    if not line.problem.autonomous:
        period = _revolutions(flow, period) * flow.revolution
    unknowns = np.array([*state, period, flow.speed])
    plane = np.zeros(unknowns.size)
    plane[-1] = 1.0  # at this speed
    return line.near(unknowns, plane).stretch


def _revolutions(flow: SystemFlow, period: float) -> int:
    """Return the number of revolutions, at least one, nearest to a period."""
    return max(1, round(period / flow.revolution))


def curve_of(flow: SystemFlow, state: Values, period: float) -> Curve[SystemOrbit]:
    """Return the curve of cycles over the speed near a guess."""
    scale = np.array([*[np.linalg.norm(state)] * state.size, period, abs(flow.speed)])
    return Curve(cycles_over_speed(flow, _revolutions(flow, period)), scale)


def cycles_over_speed(flow: SystemFlow, revolutions: int) -> Problem[SystemOrbit]:
    """Return the cycles of a system over its speed; on fixed axes, those of some revolutions."""
    autonomous = flow.problem.forward is not None

    def shoot(unknowns: Values) -> SystemOrbit:
        speed = float(unknowns[-1])
        if not speed * flow.speed > 0.0:
            raise SimulationError(f"speed falls to {speed:.3g}")
        own = at_speed(flow, speed)
        return SystemOrbit(own, np.asarray(unknowns[:-2]), float(unknowns[-2]))

    def equations(unknowns: Values, orbit: SystemOrbit, direction: Values) -> tuple[Values, Values]:
        miss, matrix = shooting_equations(orbit, direction, orbit.by_speed)
        if not autonomous:
            whole = revolutions * orbit.flow.revolution
            miss[-1], matrix[-1] = whole - orbit.duration, 0.0
            matrix[-1, -2:] = 1.0, whole / float(unknowns[-1])
        return miss, matrix

    return Problem(
        shoot, equations, check_closed, TESTS, COUNTS, autonomous=autonomous, closes=_closes
    )


def _closes(orbit: SystemOrbit) -> bool:
    """Return whether an orbit returns to its start, up to rounding."""
    return orbit.missed <= LARGEST_MISS * max(float(np.abs(orbit.monodromy).max()), 1.0)


def check_closed(orbit: SystemOrbit) -> None:
    """Raise SimulationError if an orbit is no limit cycle with contact."""
    if not _closes(orbit):
        raise _failure(orbit, f"the orbit misses its start by {orbit.missed:.3g} of its size")
    if orbit.is_autonomous:
        moved = float(np.abs(orbit.start_rate).max()) * orbit.duration
        if not moved > STANDSTILL * orbit.size:
            raise _failure(orbit, FOUND_A_WHIRL)
    if not orbit.touches:
        raise _failure(orbit, LEFT_THE_RING)


def _failure(orbit: SystemOrbit, reason: str) -> SimulationError:
    return SimulationError(f"{reason}: period {orbit.duration:.9g}, speed {orbit.flow.speed:.9g}")


def branch_over_speed(
    guess: SystemGuess, limits: tuple[float, float], most: int
) -> Continuation[SystemOrbit]:
    """Return the branch through a cycle, from a doubling, or from a Hopf point.

    SimulationError if there is no branch.
    """
    flow, period, n = guess.flow, guess.period or math.nan, guess.state.size
    doubles = guess.special == DOUBLING
    line = curve_of(flow, guess.state, period * (2.0 if doubles else 1.0))
    times = _revolutions(flow, line.scale[n])
    half = None if times % 2 else cycles_over_speed(flow, times // 2)
    unknowns = np.array([*guess.state, period, flow.speed])
    if doubles:
        first = doubled(line, unknowns)
    elif guess.special == HOPF:
        first = _born(line, unknowns)
    else:
        first = line.first(unknowns)
        first = first.reversed() if guess.slope < 0.0 else first
    near = partial(birth_between, whirl_near=RubNear.of, problem=line.problem)
    birth = near if line.problem.autonomous else None
    return Continuation(
        line, "speed", first, {n + 1: limits}, most, both=not doubles, half=half, birth=birth
    )


def _born(line: Curve[SystemOrbit], unknowns: Values) -> Point[SystemOrbit]:
    """Return a small cycle near the Hopf point of a whirl, directed away from it."""
    state, period, speed = unknowns[:-2], float(unknowns[-2]), float(unknowns[-1])
    away = np.zeros(unknowns.size)
    away[: state.size] = oscillation(line.problem, state, period, speed)
    return line.near(unknowns + FIRST_SWING * away * line.scale, away)


# ---- The synchronous rub from which cycles are born ----


class RubNear:
    """The rub of an axisymmetric system nearest to given radii, over the speed."""

    def __init__(
        self, flow: SystemFlow, touching: Touching, radii: Values, frequency: float
    ) -> None:
        assembly = flow.problem.assembly
        self._flow, self._touching, self._radii = flow, touching, radii
        self._frequency = frequency
        self._rubs = RubProblem(assembly, forward_motions(assembly))

    @classmethod
    def of(cls, orbit: SystemOrbit) -> RubNear:
        """Return the rub near a cycle with a small oscillation, of the contacts that it keeps."""
        low, high = orbit.sizes.reshape(2, -1)
        clearances = [each.clearance for each in orbit.flow.problem.assembly.contacts]
        touching = tuple(np.flatnonzero(low > clearances).tolist())
        return cls(orbit.flow, touching, 0.5 * (low + high), 2.0 * math.pi / orbit.duration)

    def growth(self, place: float) -> float:
        """Return the growth rate of the rub's oscillation at the frequency of the cycle."""
        return self.at(place)[1].real

    def at(self, place: float) -> tuple[Values, complex]:
        """Return state, on turning axes, and eigenvalue of the rub at a speed."""
        if not self._touching:
            raise ValueError("no contact stays closed")
        speeds, contacts = np.array([place]), self._rubs.assembly.contacts
        (roots,) = self._rubs.roots(self._touching, speeds)
        if not len(roots):
            raise ValueError("there is no rub of these contacts")
        found = [self._rubs.whirls(self._touching, root[np.newaxis], speeds) for root in roots]
        apart = [np.abs(np.abs(each.displacement[0]) - self._radii).max() for each in found]
        nearest = int(np.argmin(apart))
        rates = self._rubs.eigenvalues(self._touching, roots[nearest][np.newaxis], speeds)[0]
        rate = complex(rates[np.argmin(np.abs(rates - 1j * self._frequency))])
        whirl, assembly = found[nearest], self._rubs.assembly
        along = whirl.displacement[0] / np.abs(whirl.displacement[0])
        force = (normal_forces(contacts, whirl.depth) * sliding(contacts, speeds))[0] * along
        rows = assembly.rows[:, 0] + 1j * assembly.rows[:, 1]
        unbalance = assembly.unbalance[0] - 1j * assembly.unbalance[1]
        pushed = place**2 * unbalance - rows.conj().T @ force
        motion = solved_motions(assembly, speeds, pushed[:, np.newaxis])[0, :, 0]
        moved = np.array([motion.real, (1j * place * motion).real])
        scaled = np.array([self._flow.problem.found.to_y(each) for each in moved])
        races = self._flow.problem.race_speeds
        return self._flow.state_of(scaled, races), rate
