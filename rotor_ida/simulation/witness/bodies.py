"""What moves, without its contacts: the disc of a `Rotor`, or a rotor system's coordinates.

Both answer the same questions of `rotor_ida.simulation.witness.mechanics`. Displacements,
velocities and forces of a contact are complex numbers; so are those of a disc as a whole, which has
no arrays of two. The coordinates of a rotor system are arrays.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

from rotor_ida.arrays import ROUNDING, Values
from rotor_ida.checks import State
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.spin import Driven, Spin, Steady

# Parts of a sum of sizes below which it is lost in rounding.
HIDDEN = 16.0 * ROUNDING
# Where the state of a disc has the impulse of the force and, with contact damping, the energy lost
# since a contact began; with friction heat and distance of sliding; if the speed changes, all of
# these, and the energy given by the drive less all losses.
IMPULSE, LOST, HEAT, SLID, GAINED = range(4, 9)


class Film(NamedTuple):
    """A bearing by its table over the speed: coefficients at its speeds, and its rows."""

    rows: Values
    stiffness: PchipInterpolator
    damping: PchipInterpolator


class Law(NamedTuple):
    """The numbers of a contact; `race_mobility` is 1/J, `mobility` 1/C of a massless stator."""

    clearance: float
    stiffness: float
    exponent: float
    damping: float
    friction: float
    radius: float
    race_radius: float = 0.0
    race_mobility: float = 0.0
    race_drag: float = 0.0
    race: int = 0
    mobility: float = 0.0


@dataclass(slots=True)
class Touch:
    """A contact at a state: indentation, direction, velocities and forces."""

    depth: float
    radius: float
    normal: complex
    approach: float
    across: float
    slip: float
    spring: float
    damping_factor: float
    push: float
    drag: float

    @property
    def force(self) -> complex:
        """The force on the stator."""
        return complex(self.push, self.drag) * self.normal


Touches = list[Touch | None]


class Disc:
    """The disc of a rotor, whose one contact is that with the stator."""

    size = 2
    has_races = False
    still = 0.0

    def __init__(self, rotor: Rotor, spin: Spin) -> None:
        self.rotor, self.spin = rotor, spin
        self.laws = [
            Law(
                rotor.delta0, 1.0, rotor.contact_exponent, rotor.contact_damping, rotor.friction,
                rotor.disc_radius or 0.0,
            )
        ]  # fmt: skip
        self._resistance, self._shaft = 2.0 * rotor.zeta, rotor.shaft_stiffness
        self._weight = complex(0.0, rotor.load)

    def first_state(self, start: State) -> Values:
        """Return the state with which a run begins."""
        if isinstance(self.spin, Driven):
            return np.array([*start, *6 * (0.0,), self.rotor.omega])
        if not isinstance(self.spin, Steady):
            return np.array([*start, *5 * (0.0,)])
        more = 4 if self.rotor.friction > 0.0 else 2 if self.rotor.contact_damping > 0.0 else 1
        return np.array([*start, *more * (0.0,)])

    def read(self, state: Values) -> tuple[complex, complex]:
        """Return displacement and velocity."""
        x, y, vx, vy = state[:IMPULSE].tolist()
        return complex(x, y), complex(vx, vy)

    def seen(self, _number: int, place: complex, velocity: complex) -> tuple[complex, complex]:
        """Return displacement from the centre and velocity of the contact."""
        return place, velocity

    def free(self, turn: complex, speed: float, place: complex, velocity: complex) -> complex:
        """Return the acceleration without contact, at a constant speed."""
        drawn = self._resistance * velocity + self._shaft * place
        return speed * speed * turn - drawn - self._weight

    def reacting(self, _turn: complex, _speed: float, place: complex, velocity: complex) -> complex:
        """Return the part of it that has a moment about the centre of mass."""
        return -self._resistance * velocity - self._shaft * place

    def along(self, _number: int, force: complex) -> complex:
        """Return the acceleration by a force on the contact."""
        return force

    def ahead(self, turn: complex) -> complex:
        """Return the unbalance along the direction a quarter turn ahead of it."""
        return 1j * turn

    def bent(self, _state: Values) -> complex:
        """Return the further forces for each unit of angular acceleration."""
        return 0.0j

    def weight(self, _turn: complex) -> float:
        """Return no moment: the weight has none about the centre of mass."""
        return 0.0

    def inertia_of(self, _turn: complex, _column: complex) -> float:
        """Return the moment of inertia about the centre of mass; 0 for a prescribed speed."""
        return self.spin.inertia if isinstance(self.spin, Driven) else 0.0

    def dot(self, one: complex, other: complex) -> float:
        """Return the sum of the products of coordinates."""
        return one.real * other.real + one.imag * other.imag

    def length(self, one: complex) -> float:
        """Return the root of the sum of squares."""
        return abs(one)

    def write(
        self, out: Values, moving: tuple[complex, complex], acceleration: complex, _: Touches
    ) -> None:
        """Write velocity and acceleration."""
        velocity = moving[1]
        out[0], out[1] = velocity.real, velocity.imag
        out[2], out[3] = acceleration.real, acceleration.imag

    def book(
        self, out: Values, moving: tuple[complex, complex], touch: Touch | None, mode: int,
        given: float,
    ) -> None:  # fmt: skip
        """Write the rates of impulse and energies, given the power of the drive."""
        lost = heat = 0.0
        out[IMPULSE] = touch.push if touch else 0.0
        if out.size > LOST:
            out[LOST] = lost = (touch.push - touch.spring) * touch.approach if touch else 0.0
        if out.size > HEAT:
            slip = touch.slip if touch and mode * mode == 1 else 0.0
            out[HEAT] = heat = touch.drag * slip if touch else 0.0
            out[SLID] = abs(slip)
        if out.size > GAINED:
            resisted = self._resistance * self.dot(moving[1], moving[1])
            out[GAINED] = given - resisted - lost - heat

    def put_velocity(self, state: Values, velocity: complex) -> None:
        """Put a velocity into a state."""
        state[2], state[3] = velocity.real, velocity.imag

    def put_on_stator(self, _number: int, state: Values) -> None:
        """Remove the rounding by which a state is not on the stator."""
        state[:2] *= self.rotor.delta0 / abs(complex(*state[:2]))

    def begins_in_contact(self, _number: int, start: Values) -> bool:
        """Decide whether a start at time 0 is in contact.

        On the stator the first nonzero one of radial velocity, acceleration and jerk decides,
        without the force: outwards means contact. Where all vanish the rotor whirls along the
        stator, which counts as flight.
        """
        rotor, spin, jolt = self.rotor, self.spin, 0.0
        z, v = self.read(start)
        if rotor.delta0 == 0.0 or abs(abs(z) - rotor.delta0) > 4.0 * ROUNDING * abs(z):
            return abs(z) >= rotor.delta0
        zeta, kappa, speed = rotor.zeta, rotor.shaft_stiffness, rotor.omega
        faster = float(spin.acceleration(speed, -2.0 * zeta * v.imag - kappa * z.imag))
        a = complex(speed**2, -faster) - 2.0 * zeta * v - kappa * z - 1j * rotor.load
        if isinstance(spin, Driven):
            of_reaction = -2.0 * zeta * (a - 1j * speed * v) - kappa * (v - 1j * speed * z)
            jolt = -(spin.slope * faster + of_reaction.imag) / spin.inertia
        drive = complex(3.0 * speed * faster, speed**3 - jolt)
        b = drive - 2.0 * zeta * a - kappa * v
        derivatives = [  # of |z|**2/2, each a sum of products
            [(z, v)],
            [(v, v), (z, a)],
            [(v, a), (v, a), (v, a), (z, b)],
        ]
        for products in derivatives:
            total = sum((one.conjugate() * other).real for one, other in products)
            if abs(total) > HIDDEN * sum(abs(one * other) for one, other in products):
                return total > 0.0
        return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Coordinates:
    """A rotor system in coordinates with a unit mass matrix; see `rotor_ida.core.system_requests`.

    The last of them, as many as `massless`, are of stators without mass. `still` is a slip below
    which surfaces do not slide.
    """

    stiffness: Values
    damping: Values | None
    gyroscopic: Values | None
    stiffness_rate: Values | None
    rows: Values
    offsets: Values
    unbalance: Values
    force: Values
    moment: tuple[float, float]
    inertia: float
    massless: int
    laws: list[Law]
    still: float
    films: list[Film]
    has_races: bool = True

    @property
    def size(self) -> int:
        """How many coordinates there are."""
        return len(self.force)

    @property
    def inert(self) -> int:
        """How many of them have mass."""
        return self.size - self.massless

    def read(self, state: Values) -> tuple[Values, Values]:
        """Return displacements and velocities; of stators without mass those by nothing pushed."""
        n, inert = self.size, self.inert
        y, v = state[:n], state[n : 2 * n]
        if self.massless:
            v = np.concatenate([v[:inert], self.force[inert:] - self.stiffness[inert:] @ y])
        return y, v

    def seen(self, number: int, y: Values, v: Values) -> tuple[complex, complex]:
        """Return displacement from the centre and velocity of a contact."""
        rows = self.rows[number]
        place, velocity = (rows @ y - self.offsets[number]).tolist(), (rows @ v).tolist()
        return complex(*place), complex(*velocity)

    def free(self, turn: complex, speed: float, y: Values, v: Values) -> Values:
        """Return the accelerations without contacts, at a constant speed."""
        by_cosine, by_sine = self.unbalance
        a = self.force - self.stiffness @ y
        a = a + speed**2 * (turn.real * by_cosine + turn.imag * by_sine)
        if self.damping is not None:
            a = a - self.damping @ v
        if self.gyroscopic is not None:
            a = a - speed * (self.gyroscopic @ v)
        for rows, stiffness, damping in self.films:
            a = a - rows.T @ (stiffness(speed) @ (rows @ y) + damping(speed) @ (rows @ v))
        a[self.inert :] = 0.0
        return np.asarray(a)

    reacting = free

    def inertia_of(self, turn: complex, column: Values) -> float:
        """Return the moment of inertia, given the accelerations for each unit of theta''."""
        return self.inertia + self.dot(self.ahead(turn), column)

    def along(self, number: int, force: complex) -> Values:
        """Return the accelerations by a force on a contact."""
        x, y = self.rows[number]
        return np.asarray(force.real * x + force.imag * y)

    def ahead(self, turn: complex) -> Values:
        """Return the unbalance along the direction a quarter turn ahead of it."""
        by_cosine, by_sine = self.unbalance
        return np.asarray(turn.real * by_sine - turn.imag * by_cosine)

    def bent(self, state: Values) -> Values | float:
        """Return the further forces for each unit of angular acceleration."""
        matrix = self.stiffness_rate
        return 0.0 if matrix is None else np.asarray(matrix @ state[: self.size])

    def weight(self, turn: complex) -> float:
        """Return the moment of the unbalance's weight about the axis."""
        across, along = self.moment
        return turn.real * across - turn.imag * along

    def dot(self, one: Values, other: Values) -> float:
        """Return the sum of the products of coordinates."""
        return float(one @ other)

    def length(self, one: Values) -> float:
        """Return the root of the sum of squares."""
        return math.sqrt(one @ one)

    def velocities(self, v: Values, touches: Touches) -> Values:
        """Return the velocities, with those of stators without mass by the forces of contacts."""
        if self.massless:
            v = v.copy()
            for i, (law, touch) in enumerate(zip(self.laws, touches, strict=True)):
                if law.mobility and touch is not None:
                    v[self.inert :] -= self.along(i, touch.force)[self.inert :]
        return v

    def write(
        self, out: Values, moving: tuple[Values, Values], acceleration: Values, touches: Touches
    ) -> None:
        """Write velocities and accelerations."""
        n = self.size
        out[:n], out[n : 2 * n] = self.velocities(moving[1], touches), acceleration
        out[n + self.inert : 2 * n] = 0.0

    def put_velocity(self, state: Values, velocity: Values) -> None:
        """Put velocities into a state."""
        state[self.size : 2 * self.size] = velocity

    def put_on_stator(self, number: int, state: Values) -> None:
        """Leave the state as it is."""

    def begins_in_contact(self, number: int, start: Values) -> bool:
        """Return whether a start is in contact, or about to be."""
        z, v = self.seen(number, *self.read(start))
        clearance = self.laws[number].clearance
        depth = abs(z) - clearance
        is_leaving = depth == 0.0 and (z.conjugate() * v).real > 0.0
        return depth > 0.0 or is_leaving or clearance == 0.0
