"""A rotor in motion, on fixed axes: its rates of change in each mode of its contacts.

With the direction ``e`` of its displacement from the stator's centre, a contact that is not loose
exerts ``-(N + i T) e`` on the rotor:

``d = |z| - delta``, ``N = k d**n (1 + c d')``, ``T = mu N sign(v_s)`` while the surfaces slide,
``v_s = v_t + R theta' - R_b Omega_b``; while they roll, T keeps v_s at 0. The unbalance adds
``(theta'**2 - i theta'') exp(i theta)``, and a torque tau changes the angular momentum about the
axis of rotation, on which friction acts with ``-R T``.

Unknown are the forces T of all contacts that roll and, under a torque, theta''. They enter the
accelerations linearly, and are found together. A stator without mass but with damping C moves as
it is pushed: with w, the velocity that all else leaves, ``d' = w.e - N/C``,
``v_s = w.t + ... - T/C``.

Each mode continues smoothly past its end, as a step may overshoot it: a contact that flies has no
force beyond the clearance, one may pull after its release, and friction keeps its sense
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
from rotor_ida.schema.flags import FLIES, IS_LOOSE, ROLLS, SLIDES_BACKWARDS, SLIDES_FORWARDS
from rotor_ida.simulation.spin import Driven, Spin
from rotor_ida.simulation.witness.bodies import GAINED, HIDDEN, Coordinates, Touch, Touches

# Largest number of contacts that stick at once for which all combinations are tried.
MOST_STUCK = 8
SLIDES = (SLIDES_FORWARDS, SLIDES_BACKWARDS)
# Accelerations of all coordinates: a complex number, or an array. Displacement and velocity.
Vector = Any
Moving = tuple[Any, Any]


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


class Stuck(NamedTuple):
    """Equations for contacts that roll, forces below which rounding hides theirs, and contacts."""

    unknowns: Unknowns
    hidden: list[float]
    touches: Touches


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

    def seen(self, number: int, _time: float, state: Values) -> tuple[complex, complex]:
        """Return displacement from the centre and velocity of a contact, by nothing pushed."""
        z, v = self.body.seen(number, *self.body.read(state))
        return complex(z), complex(v)

    def touch(self, number: int, time: float, state: Values) -> Touch:
        """Return how a contact is at a state; the force of one that rolls is left out."""
        return self._touch(number, self.spin.at(time, state)[1], state, self.body.read(state))

    def _touch(self, number: int, speed: float, state: Values, moving: Moving) -> Touch:
        law, mode = self.body.laws[number], self.modes[number]
        radius, normal, w, slip = self._sliding(number, speed, state, moving)
        approach, depth, spring = w.real, radius - law.clearance, 0.0
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

    def _sliding(
        self, number: int, speed: float, state: Values, moving: Moving
    ) -> tuple[float, complex, complex, float]:
        """Return radius, direction, velocity along and across it, and slip, by nothing pushed."""
        law = self.body.laws[number]
        z, v = self.body.seen(number, *moving)
        radius = abs(z)
        normal = z / radius if radius > 0.0 else 1.0 + 0.0j
        w = v * normal.conjugate()
        slip = w.imag + law.radius * speed
        if law.race_radius:
            slip -= law.race_radius * self._race(number, state)
        return radius, normal, w, slip

    def _race(self, number: int, state: Values) -> float:
        """Return the speed of the race of a contact."""
        return float(state[2 * self.body.size + number])

    def forces(self, time: float, state: Values) -> Forces:
        """Return the accelerations, and the forces of all contacts; those that roll do not slip."""
        angle, speed = self.spin.at(time, state)
        moving = self._without_slip(speed, state)
        return self._forces(cmath.rect(1.0, angle), speed, state, moving)

    def _forces(self, turn: complex, speed: float, state: Values, moving: Moving) -> Forces:
        a, touches = self._known(turn, speed, state, moving)
        faster = self.rate
        if self.is_driven or ROLLS in self.modes:
            rolling = self.rolling()
            columns, matrix, right = self.unknowns(rolling, turn, speed, state, moving, a, touches)
            found = _solved(matrix, right)
            for column, unknown in zip(columns, found, strict=True):
                a = a + unknown * column
            for i, drag in zip(rolling, found, strict=False):
                touches[i].drag = drag  # type: ignore[union-attr]
            faster = found[-1] if self.is_driven else faster
        return Forces(a, touches, faster)

    def _known(
        self, turn: complex, speed: float, state: Values, moving: Moving
    ) -> tuple[Vector, Touches]:
        """Return the known part of the accelerations, and the contacts."""
        body = self.body
        a: Vector = body.free(turn, speed, *moving)
        touches: Touches = []
        for i, mode in enumerate(self.modes):
            touch = self._touch(i, speed, state, moving) if mode != FLIES else None
            touches.append(touch)
            if touch is not None and mode != IS_LOOSE:
                a = a - body.along(i, touch.force)
        if self.rate:
            a = a - self.rate * (body.ahead(turn) + body.bent(state))
        return a, touches

    def rolling(self) -> list[int]:
        """Return the contacts that roll on stators with mass."""
        laws = self.body.laws
        return [i for i, mode in enumerate(self.modes) if mode == ROLLS and not laws[i].mobility]

    def _on_race(self, number: int) -> list[int]:
        """Return the contacts whose friction turns the race of a contact."""
        laws = self.body.laws
        return [
            i for i, mode in enumerate(self.modes)
            if mode not in {FLIES, IS_LOOSE} and laws[i].race == laws[number].race
        ]  # fmt: skip

    def unknowns(
        self, rolling: list[int], turn: complex, speed: float, state: Values, moving: Moving,
        a: Vector, touches: list[Any],
    ) -> Unknowns:  # fmt: skip
        """Return the equations for what is unknown.

        The slips of contacts that roll do not change, and the torque changes angular momentum.
        """
        body, spin = self.body, self.spin
        laws = [body.laws[i] for i in rolling]
        columns = [-body.along(i, 1j * touches[i].normal) for i in rolling]
        if self.is_driven:
            columns.append(-(body.ahead(turn) + body.bent(state)))
        matrix, right = [], []
        for k, i in enumerate(rolling):
            law, touch, mine = laws[k], touches[i], columns[k]
            row = [body.dot(mine, column) for column in columns]
            left = -body.dot(mine, a) - touch.approach * touch.across / touch.radius
            if law.race_radius:
                own = law.race_radius * law.race_mobility
                for place, other in enumerate(laws):
                    row[place] += law.race_radius * own * (other.race == law.race)
                known = sum(touches[j].drag for j in self._on_race(i) if j not in rolling)
                left -= own * (law.race_radius * known - law.race_drag * self._race(i, state))
            if self.is_driven:
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
            right.append(drive - self._resisting(turn, speed, moving, touches))
        return Unknowns(columns, matrix, right)

    def _resisting(self, turn: complex, speed: float, moving: Moving, touches: Touches) -> float:
        """Return the moment against the spin; that of unknown forces and theta'' is left out."""
        body = self.body
        a: Vector = body.reacting(turn, speed, *moving)
        moment = -body.weight(turn)
        for i, touch in enumerate(touches):
            if touch is not None:
                a = a - body.along(i, touch.force)
                moment += body.laws[i].radius * touch.drag
        return float(moment + body.dot(body.ahead(turn), a))

    def rates(self, time: float, state: Values, out: Values) -> None:
        """Write the rate of change of a state."""
        body, n = self.body, 2 * self.body.size
        angle, speed = self.spin.at(time, state)
        turn, moving = cmath.rect(1.0, angle), self._without_slip(speed, state)
        a, touches, faster = self._forces(turn, speed, state, moving)
        body.write(out, moving, a, touches)
        if body.has_races:
            for i, law in enumerate(body.laws):
                drag = sum(each.drag for j in self._on_race(i) if (each := touches[j]))
                torque = law.race_radius * drag - law.race_drag * self._race(i, state)
                out[n + i] = law.race_mobility * torque
        else:
            given = 0.0
            if state.size > GAINED:
                torque = body.inertia_of(turn, 0.0j) * faster
                given = speed * (torque + self._resisting(turn, speed, moving, touches))
            body.book(out, moving, touches[0], self.modes[0], given)
        if self.is_driven:
            out[-2], out[-1] = speed, faster

    def reported(self, time: float, state: Values) -> Values:
        """Return a state with what follows from the modes.

        Contacts that roll do not slip, and stators without mass move as they are pushed.
        """
        state, body = self.at_rest(time, state), self.body
        if isinstance(body, Coordinates) and body.massless:
            touches, state = self.forces(time, state).touches, state.copy()
            body.put_velocity(state, body.velocities(body.read(state)[1], touches))
        return state

    def hidden_slip(self, number: int, time: float, state: Values) -> float:
        """Return the slip of a contact below which its surfaces do not slide."""
        law, speed = self.body.laws[number], abs(self.spin.at(time, state)[1])
        size = abs(self.seen(number, time, state)[1]) + law.radius * speed
        if law.race_radius:
            size += law.race_radius * abs(self._race(number, state))
        return float(max(HIDDEN * size, self.body.still))

    def _stuck(self, time: float, state: Values) -> Stuck:
        """Return the equations for the contacts that roll, and what is hidden of their forces."""
        rolling, hidden, body = self.rolling(), [], self.body
        angle, speed = self.spin.at(time, state)
        turn, moving = cmath.rect(1.0, angle), self._without_slip(speed, state)
        a, touches = self._known(turn, speed, state, moving)
        unknowns = self.unknowns(rolling, turn, speed, state, moving, a, touches)
        pulled = body.length(a)
        for i, each in enumerate(touches):
            pulled += body.length(body.along(i, each.force)) if each else 0.0
        for row, i in enumerate(rolling):
            touch: Any = touches[i]
            size = body.length(unknowns.columns[row]) * pulled
            size += abs(touch.approach * touch.across) / touch.radius
            hidden.append(HIDDEN * size / unknowns.matrix[row][row])
        return Stuck(unknowns, hidden, touches)

    def grip_of(self, number: int, time: float, state: Values) -> tuple[float, float, float]:
        """Return the force that a contact needs to roll, what friction holds, and the rounding."""
        (_, matrix, right), hidden, touches = self._stuck(time, state)
        touch: Any = touches[number]
        grip = self.body.laws[number].friction * touch.push
        if self.body.laws[number].mobility:
            return touch.drag, grip, 0.0
        row = self.rolling().index(number)
        return _solved(matrix, right)[row], grip, hidden[row]

    def _without_slip(self, speed: float, state: Values) -> Moving:
        """Return how the body moves without slip of contacts that roll.

        As little velocity as possible is added.
        """
        body, rolling = self.body, self.rolling() if ROLLS in self.modes else []
        place, velocity = body.read(state)
        for i in rolling if len(rolling) == 1 else 2 * rolling:  # again, for what others leave
            _, normal, _, slip = self._sliding(i, speed, state, (place, velocity))
            column = body.along(i, 1j * normal)
            velocity = velocity - slip / body.dot(column, column) * column
        return place, velocity

    def at_rest(self, time: float, state: Values) -> Values:
        """Return a state without slip of contacts that roll."""
        if ROLLS not in self.modes:
            return state
        state, speed = state.copy(), self.spin.at(time, state)[1]
        for _ in range(2):  # again, for what rounding leaves
            self.body.put_velocity(state, self._without_slip(speed, state)[1])
        return state

    def rub(self, number: int, time: float, state: Values) -> None:
        """Set the mode of a contact that is not loose: its surfaces slide, or `settle` says."""
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
        (_, rows, sums), hidden, touches = self._stuck(time, state)
        matrix, right = np.array(rows), np.array(sums)
        laws = self.body.laws
        grips = [laws[i].friction * each.push for i in stuck if (each := touches[i])]
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
                self.rub(i, time, state)
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
