"""A rotor in motion, on fixed axes: its rates of change in each mode of its contacts.

With the direction ``e`` of its displacement from the stator's centre, a pressed contact exerts
``-(N + i T) e`` on the rotor:

``d = |z| - delta``, ``N = k d**n (1 + c d')``, ``T = mu N sign(v_s)`` while the surfaces slide,
``v_s = v_t + R theta' - R_b Omega_b``; while they roll, T keeps v_s at 0. The unbalance adds
``(theta'**2 - i theta'') exp(i theta)``, and a torque tau changes the angular momentum about the
axis of rotation, on which friction acts with ``-R T``.

Unknown are the forces T of all contacts that roll and, under a torque, theta''. They enter the
accelerations linearly, and are found together. A stator without mass but with damping C moves as
it is pushed: with w, the velocity that all else leaves, ``d' = w.e - N/C``,
``v_s = w.t + ... - T/C``.

Each mode continues smoothly past its end, as a step may overshoot it: a contact that flies has no
force beyond the clearance, a pressed one may pull after its release, and friction keeps its sense
after a reversal.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.errors import SimulationError
from rotor_ida.model.contact import damping_factor, spring_force
from rotor_ida.simulation.orbit import (
    FLIES,
    IS_LOOSE,
    ROLLS,
    SLIDES_BACKWARDS,
    SLIDES_FORWARDS,
)
from rotor_ida.simulation.spin import Driven, Spin
from rotor_ida.simulation.witness.bodies import GAINED, HIDDEN, Coordinates, Touch, Touches

# Largest number of contacts that stick at once for which all combinations are tried.
MOST_STUCK = 8
SLIDES = (SLIDES_FORWARDS, SLIDES_BACKWARDS)
# Accelerations of all coordinates: a complex number, or an array.
Vector = Any


class Forces(NamedTuple):
    """The accelerations at a state, how each contact is, None in flight, and theta''."""

    acceleration: Vector
    touches: Touches
    faster: float


class Unknowns(NamedTuple):
    """Equations for the forces of contacts that roll and, under a torque, for theta''.

    Each adds its column to the accelerations.
    """

    columns: list[Vector]
    matrix: list[list[float]]
    right: list[float]


@dataclass(slots=True)
class Machine:
    """A body with its spin, and with its contacts in their modes.

    States are displacements and velocities of the body, the speeds of races, the energies that the
    body books and, if it is driven, angle and speed.
    """

    body: Any  # Disc or Coordinates
    spin: Spin
    modes: list[int]
    # the angular acceleration if it is prescribed, else 0
    rate: float = field(init=False)
    is_driven: bool = field(init=False)

    def __post_init__(self) -> None:
        self.is_driven = isinstance(self.spin, Driven)
        self.rate = 0.0 if self.is_driven else float(self.spin.acceleration(0.0, 0.0))

    def seen(self, number: int, state: Values) -> tuple[complex, complex]:
        """Return displacement from the centre and velocity of a contact, by nothing pushed."""
        z, v = self.body.seen(number, *self.body.read(state))
        return complex(z), complex(v)

    def touch(self, number: int, time: float, state: Values) -> Touch:
        """Return how a contact is at a state; the force of one that rolls is left out."""
        return self._touch(number, self.spin.at(time, state)[1], state, self.body.read(state))

    def _touch(self, number: int, speed: float, state: Values, moving: Any) -> Touch:
        law, mode = self.body.laws[number], self.modes[number]
        z, v = self.body.seen(number, *moving)
        radius = abs(z)
        normal = z / radius if radius > 0.0 else 1.0 + 0.0j
        w = v * normal.conjugate()
        approach, depth = w.real, radius - law.clearance
        slip = w.imag + law.radius * speed
        if law.race_radius:
            slip -= law.race_radius * self._race(number, state)
        spring = 0.0
        if depth > 0.0 and mode != FLIES:
            spring = law.stiffness * spring_force(depth, law.exponent)
        factor = damping_factor(approach, law.damping)
        push = 0.0 if mode == IS_LOOSE else spring * factor
        drag = law.friction * mode * push if mode in SLIDES else 0.0
        if law.mobility:
            push /= 1.0 + law.mobility * law.damping * spring
            approach -= law.mobility * push
            factor = damping_factor(approach, law.damping)
            drag = slip / law.mobility if mode == ROLLS else law.friction * mode * push
            slip -= law.mobility * drag
        return Touch(depth, radius, normal, approach, w.imag, slip, spring, factor, push, drag)

    def _race(self, number: int, state: Values) -> float:
        """Return the speed of the race of a contact."""
        return float(state[2 * self.body.size + number])

    def forces(self, time: float, state: Values) -> Forces:
        """Return the accelerations, and the forces of all contacts; those that roll do not slip."""
        return self._forces(time, self.at_rest(time, state))

    def _forces(self, time: float, state: Values) -> Forces:
        turn, speed, a, touches = self._known(time, state)
        faster = self.rate
        if self.is_driven or ROLLS in self.modes:
            rolling = self.rolling()
            columns, matrix, right = self.unknowns(turn, speed, state, a, touches)
            found = _solved(matrix, right)
            for column, unknown in zip(columns, found, strict=True):
                a = a + unknown * column
            for i, drag in zip(rolling, found, strict=False):
                touches[i].drag = drag  # type: ignore[union-attr]
            faster = found[-1] if self.is_driven else faster
        return Forces(a, touches, faster)

    def _known(self, time: float, state: Values) -> tuple[complex, float, Vector, Touches]:
        """Return direction of the unbalance, speed, known part of accelerations, and contacts."""
        body = self.body
        angle, speed = self.spin.at(time, state)
        turn = cmath.rect(1.0, angle)
        moving = body.read(state)
        a: Vector = body.free(turn, speed, *moving)
        touches: Touches = []
        for i, mode in enumerate(self.modes):
            touch = self._touch(i, speed, state, moving) if mode != FLIES else None
            touches.append(touch)
            if touch is not None and mode != IS_LOOSE:
                a = a - body.along(i, touch.force)
        if self.rate:
            a = a - self.rate * (body.ahead(turn) + body.bent(state))
        return turn, speed, a, touches

    def rolling(self) -> list[int]:
        """Return the contacts that roll on stators with mass."""
        laws = self.body.laws
        return [i for i, mode in enumerate(self.modes) if mode == ROLLS and not laws[i].mobility]

    def _on_race(self, number: int) -> list[int]:
        """Return the pressed contacts whose friction turns the race of a contact."""
        laws = self.body.laws
        return [
            i for i, mode in enumerate(self.modes)
            if mode not in {FLIES, IS_LOOSE} and laws[i].race == laws[number].race
        ]  # fmt: skip

    def unknowns(
        self, turn: complex, speed: float, state: Values, a: Vector, touches: list[Any]
    ) -> Unknowns:
        """Return the equations for what is unknown.

        The slips of contacts that roll do not change, and the torque changes angular momentum.
        """
        body, spin, rolling = self.body, self.spin, self.rolling()
        laws = [body.laws[i] for i in rolling]
        across = [body.along(i, 1j * touches[i].normal) for i in rolling]
        columns = [-each for each in across]
        if isinstance(spin, Driven):
            columns.append(-(body.ahead(turn) + body.bent(state)))
        matrix, right = [], []
        for i, law, mine in zip(rolling, laws, across, strict=True):
            row = [-body.dot(mine, column) for column in columns]
            touch, own = touches[i], law.race_radius * law.race_mobility
            left = body.dot(mine, a) - touch.approach * touch.across / touch.radius
            if own:
                for k, other in enumerate(laws):
                    row[k] += law.race_radius * own * (other.race == law.race)
                known = sum(touches[j].drag for j in self._on_race(i) if j not in rolling)
                left -= own * (law.race_radius * known - law.race_drag * self._race(i, state))
            if isinstance(spin, Driven):
                row[-1] -= law.radius
            matrix.append(row)
            right.append(left + law.radius * self.rate)
        if isinstance(spin, Driven):
            ahead, moved = body.ahead(turn), columns[-1]
            row = [
                body.dot(ahead, column) + law.radius
                for column, law in zip(columns, laws, strict=False)
            ]
            matrix.append([*row, body.inertia_of(turn, moved)])
            drive = spin.torque - spin.slope * speed
            right.append(drive - self._resisting(turn, speed, state, touches))
        return Unknowns(columns, matrix, right)

    def _resisting(self, turn: complex, speed: float, state: Values, touches: Touches) -> float:
        """Return the moment against the spin; that of unknown forces and theta'' is left out."""
        body = self.body
        a: Vector = body.reacting(turn, speed, *body.read(state))
        moment = -body.weight(turn)
        for i, touch in enumerate(touches):
            if touch is not None:
                a = a - body.along(i, touch.force)
                moment += body.laws[i].radius * touch.drag
        return float(moment + body.dot(body.ahead(turn), a))

    def rates(self, time: float, state: Values, out: Values) -> None:
        """Write the rate of change of a state."""
        body, n = self.body, 2 * self.body.size
        state = self.at_rest(time, state)
        a, touches, faster = self._forces(time, state)
        body.write(out, state, a, touches)
        if body.has_races:
            for i, law in enumerate(body.laws):
                drag = sum(each.drag for j in self._on_race(i) if (each := touches[j]))
                torque = law.race_radius * drag - law.race_drag * self._race(i, state)
                out[n + i] = law.race_mobility * torque
        else:
            given = 0.0
            if state.size > GAINED:
                angle, speed = self.spin.at(time, state)
                turn = cmath.rect(1.0, angle)
                torque = body.inertia_of(turn, 0.0j) * faster
                given = speed * (torque + self._resisting(turn, speed, state, touches))
            body.book(out, state, touches[0], self.modes[0], given)
        if isinstance(self.spin, Driven):
            out[-2], out[-1] = self.spin.at(time, state)[1], faster

    def reported(self, time: float, state: Values) -> Values:
        """Return a state with what follows from the modes.

        Contacts that roll do not slip, and stators without mass move as they are pushed.
        """
        state, body = self.at_rest(time, state), self.body
        if isinstance(body, Coordinates) and body.massless:
            touches, state = self.forces(time, state).touches, state.copy()
            state[body.size : 2 * body.size] = body.velocities(state, touches)
        return state

    def hidden_slip(self, number: int, time: float, state: Values) -> float:
        """Return the slip of a contact below which its surfaces do not slide."""
        law, speed = self.body.laws[number], abs(self.spin.at(time, state)[1])
        size = abs(self.seen(number, state)[1]) + law.radius * speed
        if law.race_radius:
            size += law.race_radius * abs(self._race(number, state))
        return float(max(HIDDEN * size, self.body.still))

    def _stuck(self, time: float, state: Values) -> tuple[Unknowns, list[float]]:
        """Return the equations for the contacts that roll, and what is hidden of their forces."""
        turn, speed, a, touches = self._known(time, state)
        unknowns, hidden, body = self.unknowns(turn, speed, state, a, touches), [], self.body
        forces = (body.along(i, touch.force) for i, touch in enumerate(touches) if touch)
        pulled = body.length(a) + sum(map(body.length, forces))
        for row, i in enumerate(self.rolling()):
            touch: Any = touches[i]
            size = body.length(unknowns.columns[row]) * pulled
            size += abs(touch.approach * touch.across) / touch.radius
            hidden.append(HIDDEN * size / unknowns.matrix[row][row])
        return unknowns, hidden

    def hidden_hold(self, number: int, time: float, state: Values) -> float:
        """Return the force below which rounding hides the one that rolling needs."""
        rolling = self.rolling()
        return self._stuck(time, state)[1][rolling.index(number)] if number in rolling else 0.0

    def hold(self, number: int, time: float, state: Values) -> tuple[float, float]:
        """Return the tangential force of a contact that rolls, and what friction can hold."""
        touch: Any = self.forces(time, state).touches[number]
        return touch.drag, self.body.laws[number].friction * touch.push

    def at_rest(self, time: float, state: Values) -> Values:
        """Return a state without slip of contacts that roll, by as little velocity as possible."""
        if ROLLS not in self.modes:
            return state
        body, state = self.body, state.copy()
        for i in 2 * self.rolling():  # again, for what rounding and other contacts leave
            touch = self.touch(i, time, state)
            column = body.along(i, 1j * touch.normal)
            body.add_velocity(state, -touch.slip / body.dot(column, column) * column)
        return state

    def press(self, number: int, time: float, state: Values) -> None:
        """Set the mode of a pressed contact: surfaces slide or, if `settle` finds it so, roll."""
        law = self.body.laws[number]
        self.modes[number] = ROLLS
        touch = self.touch(number, time, state)
        slip, grip = touch.slip + law.mobility * touch.drag, law.friction * touch.push
        still = max(self.hidden_slip(number, time, state), law.mobility * grip)
        if law.friction == 0.0 or abs(slip) > still:
            self.modes[number] = SLIDES_BACKWARDS if slip < 0.0 else SLIDES_FORWARDS

    def settle(self, time: float, state: Values) -> None:
        """Decide how contacts whose surfaces do not slide go on: each holds, or is at its limit.

        All combinations are tried; by the convexity of the problem one of them fits.
        """
        stuck = self.rolling()
        if not stuck:
            return
        if len(stuck) > MOST_STUCK:
            raise SimulationError("too many contacts stick at once for the witness", time=time)
        (_, rows, sums), hidden = self._stuck(time, state)
        matrix, right = np.array(rows), np.array(sums)
        laws = self.body.laws
        grips = [laws[i].friction * self.touch(i, time, state).push for i in stuck]
        best, least = (0,) * len(stuck), np.inf
        for choice in product((0, 1, -1), repeat=len(stuck)):
            forces = np.zeros(len(right))
            forces[: len(stuck)] = np.multiply(choice, grips)
            free = [k for k in range(len(right)) if k >= len(stuck) or choice[k] == 0]
            rest = right - matrix @ forces
            if free:
                forces[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest[free])
            left = right - matrix @ forces
            excess = [
                max(-sense * left[k], 0.0) if sense
                else max(abs(forces[k]) - grips[k] - hidden[k], 0.0)
                for k, sense in enumerate(choice)
            ]  # fmt: skip
            if max(excess) < least:
                best, least = choice, max(excess)
        for i, sense in zip(stuck, best, strict=True):
            self.modes[i] = sense or ROLLS

    def begin(self, time: float, state: Values) -> None:
        """Decide the modes at the start; a contact whose force would pull is loose."""
        for i in range(len(self.modes)):
            if not self.body.begins_in_contact(i, state):
                continue
            self.modes[i] = IS_LOOSE
            touch = self.touch(i, time, state)
            factor = touch.damping_factor
            if factor == 0.0 and touch.depth > 0.0:  # what it is about to become
                rate = np.empty_like(state)
                self.rates(time, state, rate)
                factor = self.touch(i, time, state + math.sqrt(HIDDEN) * rate).damping_factor
            if factor > 0.0:
                self.press(i, time, state)
        self.settle(time, state)


def _solved(matrix: list[list[float]], right: list[float]) -> list[float]:
    """Return the solution of linear equations; for one or two of them, without arrays."""
    if len(right) == 1:
        return [right[0] / matrix[0][0]]
    if len(right) == 2:
        (a, b), (c, d) = matrix
        whole = a * d - b * c
        return [(right[0] * d - b * right[1]) / whole, (a * right[1] - right[0] * c) / whole]
    return list(np.linalg.solve(np.array(matrix), np.array(right)).tolist())
