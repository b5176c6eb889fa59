"""Where a branch of cycles is born: the Hopf point of a synchronous whirl.

The whirl that begins to oscillate there is known in closed form, and so is the point. One disc is
taken as a system of one node.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.receptances import solved_motions
from rotor_ida.closed_forms.whirls.at_speeds import sliding
from rotor_ida.closed_forms.whirls.branches import RubProblem, Touching
from rotor_ida.closed_forms.whirls.turning_axes import normal_forces
from rotor_ida.cycles.continuation import Point, Problem
from rotor_ida.cycles.orbit import Orbit, disc_of
from rotor_ida.errors import SimulationError
from rotor_ida.model.assembly import Assembly, assemble
from rotor_ida.model.axisymmetric import forward_motions
from rotor_ida.simulation.flow import Flow
from rotor_ida.simulation.system_flow import SystemFlow

# Factor on the range, estimated from two nearby points, in which the bifurcation is sought.
FARTHER = 4.0
# Relative agreement of the whirl's frequency with that of a nearby cycle.
SAME_FREQUENCY = 0.1
# Relative oscillation of the radius of a cycle there: its square is below rounding.
SWING = 3e-7
# Digits to which the parameter is determined.
FINEST = 1e-15


def birth_between(last: Point, point: Point, name: str, problem: Problem) -> Point | None:
    """Return the cycle at which a branch is born between two of its points, if there is one.

    Its parameter is that of the Hopf point, to rounding. The cycle oscillates too little about the
    whirl to change period or parameter.
    """
    nearer = min(last, point, key=_swing)
    whirl = RubNear.of(nearer.orbit, name)
    place = _crossing(whirl.growth, last, point)
    if place is None:
        return None
    state, rate = whirl.at(place)
    period = 2.0 * math.pi / abs(rate.imag)
    if abs(period / nearer.orbit.duration - 1.0) > SAME_FREQUENCY:
        return None
    start = state + SWING * np.linalg.norm(state) * oscillation(problem, state, period, place)
    unknowns = np.array([*start, period, place])
    return replace(nearer, unknowns=unknowns, orbit=problem.shoot(unknowns))


def oscillation(problem: Problem, whirl: Values, period: float, place: float) -> Values:
    """Return the direction, of length 1, in which a whirl oscillates at its Hopf point."""
    quarter = problem.shoot(np.array([*whirl, 0.25 * period, place])).monodromy
    multipliers, vectors = np.linalg.eig(quarter)
    aside = np.real(vectors[:, np.argmin(np.abs(multipliers - 1j))])
    return np.asarray(aside / np.linalg.norm(aside))


def _swing(point: Point) -> float:
    """Return the largest change of a radius along a cycle."""
    low, high = point.orbit.sizes.reshape(2, -1)
    return float((high - low).max())


def _crossing(growth: Callable[[float], float], last: Point, point: Point) -> float | None:
    """Return where a pair of eigenvalues crosses the imaginary axis near two points of a branch.

    The parameter changes with the square of the oscillation.
    """
    (one, p), (two, q) = ((_swing(each) ** 2, float(each.unknowns[-1])) for each in (last, point))
    apart = FARTHER * abs(p - q) if one == two else 0.0
    guess = p if one == two else p - one * (q - p) / (two - one)
    apart = max(apart, FARTHER * abs(p - guess), FARTHER * abs(q - guess))
    ends = max(guess - apart, 0.0), guess + apart
    try:
        return float(brentq(growth, *ends, xtol=FINEST * guess, rtol=4.0 * FINEST))
    except (ValueError, RuntimeError, SimulationError):  # it does not cross there
        return None


@dataclass(frozen=True, slots=True)
class RubNear:
    """The rub nearest to given radii, over a parameter of a rotor that has no direction of its own.

    Parameters
    ----------
    flow : Flow
        The motion for one value of the parameter.
    name : str
        The parameter.
    touching : tuple of int
        The contacts that stay closed.
    radii : ndarray, shape (contact,)
        Distances of the contacts.
    frequency : float
        Frequency of its oscillation.
    """

    flow: Flow
    name: str
    touching: Touching
    radii: Values
    frequency: float

    @classmethod
    def of(cls, orbit: Orbit, name: str) -> RubNear:
        """Return the rub near a cycle with a small oscillation, of the contacts that it keeps."""
        low, high = orbit.sizes.reshape(2, -1)
        touching = tuple(np.flatnonzero(low > orbit.flow.clearances).tolist())
        return cls(orbit.flow, name, touching, 0.5 * (low + high), 2.0 * math.pi / orbit.duration)

    def growth(self, place: float) -> float:
        """Return the growth rate of the rub's oscillation for a value of the parameter."""
        return self.at(place)[1].real

    def at(self, place: float) -> tuple[Values, complex]:
        """Return state, on rotating axes, and eigenvalue of the rub for a parameter value."""
        if not self.touching:
            raise ValueError("no contact stays closed")
        flow = self.flow.but(**{self.name: place})
        assembly, speeds = assembly_of(flow), np.array([flow.speed])
        rubs = RubProblem(assembly, forward_motions(assembly))
        (roots,) = rubs.roots(self.touching, speeds)
        if not len(roots):
            raise ValueError("there is no rub of these contacts")
        found = [rubs.whirls(self.touching, root[np.newaxis], speeds) for root in roots]
        apart = [np.abs(np.abs(each.displacement[0]) - self.radii).max() for each in found]
        nearest = int(np.argmin(apart))
        rates = rubs.eigenvalues(self.touching, roots[nearest][np.newaxis], speeds)[0]
        rate = complex(rates[np.argmin(np.abs(rates - 1j * self.frequency))])
        whirl = found[nearest]
        along = whirl.displacement[0] / np.abs(whirl.displacement[0])
        pressing = normal_forces(assembly.contacts, whirl.depth)
        force = (pressing * sliding(assembly.contacts, speeds))[0] * along
        rows = assembly.rows[:, 0] + 1j * assembly.rows[:, 1]
        unbalance = assembly.unbalance[0] - 1j * assembly.unbalance[1]
        pushed = flow.speed**2 * unbalance - rows.conj().T @ force
        motion = solved_motions(assembly, speeds, pushed[:, np.newaxis])[0, :, 0]
        moved = np.concatenate([motion.real, (1j * flow.speed * motion).real])
        if isinstance(flow, SystemFlow):
            moved = flow.given_state(np.append(moved, flow.problem.race_speeds))
        return moved, rate


def assembly_of(flow: Flow) -> Assembly:
    """Return the rotor of a flow as a system."""
    if isinstance(flow, SystemFlow):
        return flow.problem.assembly
    return assemble(disc_of(flow).system())
