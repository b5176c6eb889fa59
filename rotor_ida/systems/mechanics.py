"""A rotor system in plain Python: its rates of change, and what ends a mode of its contacts.

Forces are computed from positions, and contacts have no variables of their own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.core.systems import SystemRequest
from rotor_ida.errors import SimulationError
from rotor_ida.simulation.mechanics import Function
from rotor_ida.simulation.orbit import FLIES, IS_LOOSE, ROLLS
from rotor_ida.simulation.spin import SpeedProfile

# Slower, in parts of the scale of velocity, surfaces do not slide.
STILL = 1e-9
# Largest number of contacts that stick at once for which all combinations are tried.
MOST_STUCK = 8


@dataclass(slots=True)
class Touch:
    """How a contact is at a state: indentation, directions, velocities and normal force.

    `held` is the tangential force that a stator without mass follows, where the surfaces roll.
    """

    depth: float
    normal: Values
    tangent: Values
    approach: float
    slip: float
    turning: float
    factor: float
    spring: float
    held: float = 0.0

    def push(self, way: int) -> float:
        """Return the normal force in a mode of motion."""
        return 0.0 if way in {FLIES, IS_LOOSE} else self.spring * self.factor


class Implicit(NamedTuple):
    """Accelerations, and the linear equations for the unknowns that they depend on.

    The unknowns are the forces of contacts that roll and, under a torque, the rate of the spin. The
    accelerations are ``explicit + unknowns @ columns``.
    """

    explicit: Values
    columns: Values
    matrix: Values
    right: Values
    rolling: list[int]

    def solve(self) -> Values:
        """Return the unknowns."""
        return np.asarray(np.linalg.solve(self.matrix, self.right))


@dataclass(slots=True)
class SystemInMotion:
    """A rotor system in the modes of its contacts; states are ``(y, v, races, angle, speed)``."""

    request: SystemRequest
    profile: SpeedProfile
    ways: list[int]
    piece: int = 0

    @property
    def size(self) -> int:
        """How many coordinates there are."""
        return len(self.request.force)

    @property
    def inert(self) -> int:
        """How many coordinates have mass."""
        return self.size - self.request.massless

    def spin(self, time: float, state: Values) -> tuple[float, float]:
        """Return angle and speed."""
        if self.profile.is_driven:
            return float(state[-2]), float(state[-1])
        angle, speed = self.profile.spins[self.piece].at(time, state)
        return float(angle), float(speed)

    def touch(self, number: int, time: float, state: Values) -> Touch:
        """Return how a contact is at a state."""
        request, n = self.request, self.size
        law, rows = request.laws[number], request.rows[number]
        v = np.concatenate([state[n : n + self.inert], self.drift(state)])
        place, velocity = rows @ state[:n] - law["offset"], rows @ v
        radius = float(np.hypot(*place))
        normal = place / radius if radius > 0.0 else np.array([1.0, 0.0])
        tangent = np.array([-normal[1], normal[0]])
        approach, across = float(normal @ velocity), float(tangent @ velocity)
        rim = law["radius"] * self.spin(time, state)[1]
        slip = across + rim - law["race_radius"] * state[2 * n + number]
        depth = radius - float(law["clearance"])
        root = np.sqrt(max(depth, 0.0))
        touch = Touch(
            depth, normal, tangent, approach, float(slip),
            approach * across / radius if radius > 0.0 else 0.0,
            1.0 + float(law["contact_damping"]) * approach,
            float(root**2 * (law["hertz"] * root + law["linear"])),
        )  # fmt: skip
        return self.yielded(number, touch) if self.mobility(number) else touch

    def mobility(self, number: int) -> float:
        """Return 1/C of the stator of a contact if it has no mass, else 0."""
        rows = self.request.rows[number][0, self.inert :]
        return float(rows @ rows)

    def yielded(self, number: int, touch: Touch) -> Touch:
        """Return how a contact is whose stator has no mass: its velocity follows the forces."""
        law, way, mobility = self.request.laws[number], self.ways[number], self.mobility(number)
        damping = float(law["contact_damping"])
        push = touch.push(way) / (1.0 + mobility * damping * touch.spring)
        approach = touch.approach - mobility * push
        held = touch.slip / mobility if way == ROLLS else 0.0
        drag = held if abs(way) != 1 else float(law["friction"]) * way * push
        slip, factor = touch.slip - mobility * drag, 1.0 + damping * approach
        return replace(touch, approach=approach, slip=slip, factor=factor, held=held)

    def drift(self, state: Values) -> Values:
        """Return the velocities of stators without mass, but for what contacts do to them."""
        n, inert, request = self.size, self.inert, self.request
        return np.asarray((request.force - request.stiffness @ state[:n])[inert:])

    def filled(self, time: float, state: Values) -> Values:
        """Return a state with the velocities of stators without mass."""
        n, inert, full = self.size, self.inert, state.copy()
        full[n + inert : 2 * n] = self.drift(state)
        for i, way in enumerate(self.ways):
            if self.mobility(i) and way != FLIES:
                touch = self.touch(i, time, state)
                rubs = float(self.request.laws[i]["friction"]) * way * touch.push(way)
                drag = touch.held if way in {ROLLS, IS_LOOSE} else rubs
                force = touch.push(way) * touch.normal + drag * touch.tangent
                full[n + inert : 2 * n] -= self.request.rows[i][:, inert:].T @ force
        return full

    def implicit(self, time: float, state: Values) -> Implicit:
        """Return the accelerations, and the equations for what is implicit in them."""
        request, n, rolling = self.request, self.size, self.rolling()
        touches = [self.touch(i, time, state) for i in range(len(self.ways))]
        a, torque = self.with_known_contacts(self.without_contacts(time, state), touches)
        across = [request.rows[i].T @ touches[i].tangent for i in rolling]
        columns = [-each for each in across]
        pull, driven, rate = self.pull(time, state), self.profile.is_driven, self.rate
        if driven:
            columns.append(-pull - self.bent(state))
        count = len(columns)
        matrix, right = np.zeros((count, count)), np.zeros(count)
        for row, i in enumerate(rolling):
            law = request.laws[i]
            own = law["race_radius"] * law["inverse_race_inertia"]
            matrix[row] = [-across[row] @ column for column in columns]
            for other, j in enumerate(rolling):
                matrix[row, other] += law["race_radius"] * own * self.shares_race(i, j)
            right[row] = across[row] @ a - touches[i].turning
            right[row] -= (
                law["race_radius"]
                * own
                * sum(self.known_drag(j, touches[j]) for j in self.turning(i) if j not in rolling)
            )
            right[row] += own * law["race_drag"] * state[2 * n + i]
            if driven:
                matrix[row, -1] -= law["radius"]
            else:
                right[row] += law["radius"] * rate
        if driven:
            _, given, slope, *_ = self.profile.spins[self.piece].piece()
            matrix[-1] = [pull @ column for column in columns]
            matrix[-1, -1] += request.inertia
            matrix[-1, : len(rolling)] += [request.laws[i]["radius"] for i in rolling]
            right[-1] = given - slope * self.spin(time, state)[1] - torque - pull @ a
            right[-1] += self.torque_of_weight(time, state)
        return Implicit(a, np.array(columns).reshape(count, n), matrix, right, rolling)

    @property
    def rate(self) -> float:
        """The angular acceleration if it is prescribed, else 0."""
        if self.profile.is_driven:
            return 0.0
        return float(self.profile.spins[self.piece].acceleration(0.0, 0.0))

    def pull(self, time: float, state: Values) -> Values:
        """Return the unbalance along the direction a quarter turn ahead of it."""
        angle, _ = self.spin(time, state)
        by_cosine, by_sine = self.request.unbalance
        return np.asarray(np.cos(angle) * by_sine - np.sin(angle) * by_cosine)

    def torque_of_weight(self, time: float, state: Values) -> float:
        """Return the moment of the unbalance's weight about the axis."""
        angle, _ = self.spin(time, state)
        across, along = self.request.weight
        return float(np.cos(angle) * across - np.sin(angle) * along)

    def bent(self, state: Values) -> Values:
        """Return the forces for each unit of angular acceleration, but for the unbalance."""
        matrix = self.request.stiffness_rate
        return np.zeros(self.size) if matrix is None else np.asarray(matrix @ state[: self.size])

    def without_contacts(self, time: float, state: Values) -> Values:
        """Return the accelerations without contacts, and without those of a driven spin."""
        request, n, rate = self.request, self.size, self.rate
        angle, speed = self.spin(time, state)
        y, v = state[:n], state[n : 2 * n]
        cosine, sine = np.cos(angle), np.sin(angle)
        by_cosine, by_sine = request.unbalance
        a = request.force - request.stiffness @ y
        a = a + by_cosine * (speed**2 * cosine + rate * sine)
        a = a + by_sine * (speed**2 * sine - rate * cosine)
        if request.damping is not None:
            a = a - request.damping @ v
        if request.gyroscopic is not None:
            a = a - speed * (request.gyroscopic @ v)
        a = a - rate * self.bent(state)
        a[self.inert :] = 0.0
        return np.asarray(a)

    def with_known_contacts(self, a: Values, touches: list[Touch]) -> tuple[Values, float]:
        """Add the forces of contacts that are known; return their braking torque too."""
        request, torque = self.request, 0.0
        for i, (way, touch) in enumerate(zip(self.ways, touches, strict=True)):
            if way in {FLIES, IS_LOOSE}:
                continue
            push, drag = touch.push(way), self.known_drag(i, touch)
            a = a - request.rows[i].T @ (push * touch.normal + drag * touch.tangent)
            a[self.inert :] = 0.0
            torque += request.laws[i]["radius"] * drag
        return a, torque

    def known_drag(self, number: int, touch: Touch) -> float:
        """Return the tangential force of a contact that is pressed, unless it has to be solved."""
        way = self.ways[number]
        if way == ROLLS:
            return touch.held
        return float(self.request.laws[number]["friction"]) * way * touch.push(way)

    def shares_race(self, number: int, other: int) -> bool:
        """Return whether two contacts have one race, or are the same."""
        races = self.request.laws["race"]
        return bool(races[number] == races[other])

    def turning(self, number: int) -> list[int]:
        """Return the pressed contacts whose friction turns the race of a contact."""
        return [j for j, way in enumerate(self.ways)
                if way not in {FLIES, IS_LOOSE} and self.shares_race(number, j)]  # fmt: skip

    def rolling(self) -> list[int]:
        """Return the contacts that roll on stators with mass."""
        return [i for i, way in enumerate(self.ways) if way == ROLLS and not self.mobility(i)]

    def rates(self, time: float, state: Values, out: Values) -> None:
        """Write the rate of change of a state."""
        n, request = self.size, self.request
        implicit = self.implicit(time, state)
        found = implicit.solve()
        out[:n] = self.filled(time, state)[n : 2 * n]
        out[n : 2 * n] = implicit.explicit + found @ implicit.columns
        held = dict(zip(implicit.rolling, found, strict=False))
        for i, law in enumerate(request.laws):
            drag = sum(
                held[j] if j in held else self.known_drag(j, self.touch(j, time, state))
                for j in self.turning(i)
            )
            torque = law["race_radius"] * drag - law["race_drag"] * state[2 * n + i]
            out[2 * n + i] = law["inverse_race_inertia"] * torque
        angle_rate = self.spin(time, state)[1]
        out[-2], out[-1] = angle_rate, found[-1] if self.profile.is_driven else 0.0

    def holds(self, time: float, state: Values) -> dict[int, float]:
        """Return the tangential forces of the contacts that roll."""
        implicit = self.implicit(time, state)
        held = {
            i: self.touch(i, time, state).held
            for i, way in enumerate(self.ways)
            if way == ROLLS and i not in implicit.rolling
        }
        if not implicit.rolling:
            return held
        return held | dict(zip(implicit.rolling, implicit.solve().tolist(), strict=False))

    def guards(self, time: float, state: Values) -> Values:
        """Return what must not fall below 0: three numbers a contact, infinite where none is."""
        guards = np.full((len(self.ways), 3), np.inf)
        holds = self.holds(time, state)
        for i, way in enumerate(self.ways):
            law, touch = self.request.laws[i], self.touch(i, time, state)
            guards[i, 0] = -touch.depth if way == FLIES else touch.depth
            if way == FLIES:
                continue
            if law["contact_damping"] > 0.0:
                guards[i, 1] = -touch.factor if way == IS_LOOSE else touch.factor
            if law["friction"] > 0.0 and way in {1, -1}:
                guards[i, 2] = way * touch.slip
            elif way == ROLLS:
                guards[i, 2] = law["friction"] * touch.push(way) - abs(holds[i])
        return guards

    def guard_of(self, number: int, guard: int) -> Function:
        """Return one guard of a contact, as a function of time and state."""
        return lambda time, state: float(self.guards(time, state)[number, guard])


def settle(run: SystemInMotion, time: float, state: Values) -> None:
    """Decide how contacts whose surfaces do not slide go on: each holds, or is at its limit.

    All combinations are tried; by the convexity of the problem one of them fits.
    """
    stuck = run.rolling()
    if not stuck:
        return
    if len(stuck) > MOST_STUCK:
        raise SimulationError("too many contacts stick at once for the witness", time=time)
    implicit = run.implicit(time, state)
    matrix, right = implicit.matrix, implicit.right
    grips = [
        float(run.request.laws[i]["friction"]) * run.touch(i, time, state).push(ROLLS)
        for i in stuck
    ]
    best, least = (0,) * len(stuck), np.inf
    for choice in product((0, 1, -1), repeat=len(stuck)):
        fixed = np.array([sense * grip for sense, grip in zip(choice, grips, strict=True)])
        free = [k for k, sense in enumerate(choice) if sense == 0]
        free += list(range(len(stuck), len(right)))
        forces = np.zeros(len(right))
        forces[: len(stuck)] = fixed
        rest = right - matrix @ forces
        if free:
            forces[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest[free])
        left = right - matrix @ forces
        excess = [
            max(abs(forces[k]) - grips[k], 0.0) if sense == 0 else max(-sense * left[k], 0.0)
            for k, sense in enumerate(choice)
        ]
        if max(excess) < least:
            best, least = choice, max(excess)
    for i, sense in zip(stuck, best, strict=True):
        if sense:
            run.ways[i] = sense


def pressed_way(run: SystemInMotion, number: int, touch: Touch) -> int:
    """Return how a contact goes on where it is pressed: surfaces slide or, if they can, hold."""
    friction, mobility = float(run.request.laws[number]["friction"]), run.mobility(number)
    slip = touch.slip + mobility * touch.held
    followed = mobility * friction * touch.push(run.ways[number])
    if abs(slip) <= max(STILL * run.request.velocity, followed) and friction > 0.0:
        return ROLLS
    return -1 if slip < 0.0 else 1
