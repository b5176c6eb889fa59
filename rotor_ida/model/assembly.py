"""A rotor system with its stators and contacts as one linear system with a unit mass matrix.

Coordinates are ``y = L' q`` with the mass matrix ``M = L L'``. Then all coordinates have one unit,
so that one tolerance serves for all, and energies are sums of squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag, cholesky
from scipy.linalg.blas import dtrsm

from rotor_ida.arrays import Values
from rotor_ida.model.bearing import Bearing, Films
from rotor_ida.model.rotor_system import (
    RotorSystem,
    force_of,
    levitated_system,
    unbalance_of,
)
from rotor_ida.model.system_parts import Contact, Race, Stator, stators_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Assembly:
    """A rotor system joined with its stators and contacts.

    Parameters
    ----------
    system : RotorSystem
        The rotor, with its supports in its matrices.
    films : Films
        The bearings whose coefficients depend on the speed; none at a held speed.
    stators : tuple of Stator
        The stators that move, each with two degrees of freedom behind those of the rotor; those
        without mass come last.
    mass, damping, gyroscopic, stiffness, stiffness_rate : ndarray, shape (n, n)
        Matrices of rotor and stators without the films; None where there are none.
    rows : ndarray, shape (contact, 2, n)
        Displacements of the contacts by q.
    unbalance : ndarray, shape (2, n)
        Force over the square of the speed, by the cosine and the sine of the angle.
    force : ndarray, shape (n,)
        The constant force.
    gravity : ndarray, shape (2,)
        The acceleration of gravity whose weight it contains.
    weight : tuple of float
        Moment of the unbalance's weight about the axis, by the cosine of the angle and by minus
        its sine.
    """

    system: RotorSystem
    stators: tuple[Stator, ...]
    mass: Values
    damping: Values | None
    gyroscopic: Values | None
    stiffness: Values
    stiffness_rate: Values | None
    rows: Values
    unbalance: Values
    force: Values
    gravity: Values
    weight: tuple[float, float]
    films: Films

    def at(self, speed: float) -> Assembly:
        """Return the assembly at a speed, with its films in the matrices; InputError outside."""
        if not self.films:
            return self
        system = self.system.at(speed)
        return replace(
            self, system=system, stiffness=self.stiffness_at(speed),
            damping=self.damping_at(speed), films=Films((), self.films.rows[:0]),
        )  # fmt: skip

    def stiffness_at(self, speeds: Values | float) -> Values:
        """Return the stiffness at speeds, shape (..., n, n), or at all, shape (n, n)."""
        return self.films.joined(self.stiffness, "stiffness", speeds)

    def damping_at(self, speeds: Values | float) -> Values:
        """Return the damping at speeds, shape (..., n, n), or at all, shape (n, n)."""
        own = np.zeros_like(self.mass) if self.damping is None else self.damping
        return self.films.joined(own, "damping", speeds)

    @property
    def contacts(self) -> Sequence[Contact]:
        """The contacts."""
        return self.system.contacts

    @property
    def size(self) -> int:
        """The number n of degrees of freedom."""
        return len(self.mass)

    @property
    def massless(self) -> int:
        """How many of the degrees of freedom, the last, are of stators without mass."""
        return 2 * sum(each.mass == 0.0 for each in self.stators)

    @property
    def races(self) -> list[Race | None]:
        """The race of each contact."""
        return [each.spinning_race for each in self.contacts]

    @property
    def race_numbers(self) -> list[int]:
        """The number of the first contact with the same race; without a race its own.

        Contacts share the race of a `Stator` that they are given.
        """
        held = [
            id(each.stator) if each.race is None and isinstance(each.stator, Stator) else (number,)
            for number, each in enumerate(self.contacts)
        ]
        return [held.index(each) for each in held]

    @property
    def smallest_clearance(self) -> float:
        """The smallest clearance of all contacts that have one; 1 where there are none."""
        return min((each.clearance for each in self.contacts if each.clearance), default=1.0)

    def node_rows(self) -> Values:
        """Return the displacements of all nodes by q, shape (node, 2, n)."""
        rows = [self.system.rows(name) for name in self.system.nodes]
        extra = np.zeros((2, self.size - self.system.size))
        return np.array([np.hstack([each, extra]) for each in rows]).reshape(-1, 2, self.size)


@dataclass(frozen=True, slots=True, kw_only=True)
class Canonical:
    """The matrices of an assembly in coordinates with a unit mass matrix.

    Where there is no mass, the damping is a unit matrix instead.

    Parameters
    ----------
    factor, inverse : ndarray, shape (n, n)
        Cholesky's factor L of the mass matrix, with the damping of stators without mass; and its
        inverse: to solve for many rows would wake the threads of BLAS, which takes a thousand
        times as long as a product of such small matrices.
    massless : int
        How many of the coordinates, the last, are of stators without mass.
    stiffness, damping, gyroscopic, stiffness_rate, rows, unbalance, force, films
        As in `Assembly`.
    """

    factor: Values
    inverse: Values
    massless: int
    stiffness: Values
    damping: Values | None
    gyroscopic: Values | None
    stiffness_rate: Values | None
    rows: Values
    unbalance: Values
    force: Values
    films: Films

    def stiffness_at(self, speed: float) -> Values:
        """Return the stiffness at a speed."""
        return self.films.joined(self.stiffness, "stiffness", speed)

    def damping_at(self, speed: float) -> Values:
        """Return the damping at a speed."""
        own = np.zeros_like(self.stiffness) if self.damping is None else self.damping
        return self.films.joined(own, "damping", speed)

    def to_q(self, values: Values) -> Values:
        """Return q for rows of y, or its velocity."""
        return np.asarray(values @ self.inverse)

    def rows_in_y(self, rows: Values) -> Values:
        """Return rows that apply to y for rows that apply to q, shape (..., n)."""
        return np.asarray(rows @ self.inverse.T)

    def to_y(self, values: Values) -> Values:
        """Return y for q, or its velocity."""
        return np.asarray(self.factor.T @ values)

    def matrix_in_y(self, matrix: Values) -> Values:
        """Return a matrix that applies to y for one that applies to q."""
        return np.asarray(self.inverse @ matrix @ self.inverse.T)

    def at(self, speed: float) -> Canonical:
        """Return the same at a speed, with the coefficients of its films in its matrices."""
        if not self.films:
            return self
        return replace(
            self, stiffness=self.stiffness_at(speed), damping=self.damping_at(speed),
            films=Films((), self.films.rows[:0]),
        )  # fmt: skip


def assemble(system: RotorSystem, *, speeds: Values | None = None) -> Assembly:
    """Return a rotor system joined with its supports, bearings, stators, contacts and forces.

    Bearings whose coefficients depend on the speed are its films. The speeds, if given, must lie
    within their tables.
    """
    stators = stators_of(system.contacts)
    if speeds is not None:
        system.check_speeds(speeds)
    system = levitated_system(system, None if speeds is None else float(speeds[0]))
    size = system.size + 2 * len(stators)
    joints: list[Contact | Bearing] = [*system.contacts, *system.bearings]
    rows, count = np.zeros((len(joints), 2, size)), len(system.contacts)
    for own, joint in zip(rows, joints, strict=True):
        own[:, : system.size] = system.rows_between(joint)
        if isinstance(joint.stator, Stator):
            place = system.size + 2 * stators.index(joint.stator)
            own[:, place : place + 2] = -np.eye(2)
    unbalance, force = unbalance_of(system, size), force_of(system)
    mass, stiffness = (_joined(system, stators, name) for name in ("mass", "stiffness"))
    pull = np.zeros(2) if system.gravity is None else np.array(system.gravity)
    if system.static_force is not None and system.gravity_in_static_force is not None:
        pull = pull + system.gravity_in_static_force
    moment = sum(each.moment * np.exp(1j * each.phase) for each in system.unbalance)
    turned = np.conj(moment) * complex(*pull)
    assert mass is not None
    assert stiffness is not None
    return Assembly(
        system=system,
        stators=stators,
        rows=rows[:count],
        unbalance=unbalance,
        force=_force(system, stators, force),
        gravity=pull,
        weight=(float(turned.imag), float(turned.real)),
        mass=mass,
        stiffness=stiffness,
        damping=_joined(system, stators, "damping"),
        gyroscopic=_joined(system, stators, "gyroscopic"),
        stiffness_rate=_joined(system, stators, "stiffness_rate"),
        films=Films(tuple(system.bearings), rows[count:]),
    )


def canonical(assembly: Assembly) -> Canonical:
    """Return an assembly in coordinates with a unit mass matrix."""
    inert = assembly.mass
    if held := assembly.massless:
        assert assembly.damping is not None
        inert = inert.copy()
        inert[-held:, -held:] = assembly.damping[-held:, -held:]
    factor = cholesky(inert, lower=True)
    inverse = np.asarray(dtrsm(1.0, factor, np.eye(assembly.size), lower=1))

    def of_matrix(matrix: Values | None) -> Values | None:
        return None if matrix is None else inverse @ matrix @ inverse.T

    stiffness = of_matrix(assembly.stiffness)
    assert stiffness is not None
    return Canonical(
        factor=factor,
        inverse=inverse,
        massless=held,
        stiffness=stiffness,
        damping=of_matrix(assembly.damping),
        gyroscopic=of_matrix(assembly.gyroscopic),
        stiffness_rate=of_matrix(assembly.stiffness_rate),
        rows=assembly.rows @ inverse.T,
        films=Films(assembly.films.bearings, assembly.films.rows @ inverse.T),
        unbalance=assembly.unbalance @ inverse.T,
        force=inverse @ assembly.force,
    )


def _joined(system: RotorSystem, stators: Sequence[Stator], name: str) -> Values | None:
    """Return a matrix of rotor and stators; None where it is of neither."""
    own = getattr(system, name)
    if not stators:
        return None if own is None else np.asarray(own, float)
    mounts = [np.zeros((2, 2)) for _ in stators]
    if name in {"mass", "stiffness", "damping"}:
        mounts = [np.diag(np.broadcast_to(getattr(each, name), 2)) for each in stators]
    if own is None and not any(each.any() for each in mounts):
        return None
    return np.asarray(block_diag(np.zeros_like(system.mass) if own is None else own, *mounts))


def _force(system: RotorSystem, stators: Sequence[Stator], given: Values) -> Values:
    """Return the constant force of rotor and stators, from that given and the rotor's weight."""
    force = np.zeros(system.size + 2 * len(stators))
    force[: given.size] = given
    if system.gravity is not None:
        for number, each in enumerate(stators):
            place = system.size + 2 * number
            force[place : place + 2] += each.mass * np.array(system.gravity) * each.weight
    return force
