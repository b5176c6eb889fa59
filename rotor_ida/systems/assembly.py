"""A rotor system with its stators and contacts as one linear system with a unit mass matrix.

Coordinates are ``y = L' q`` with the mass matrix ``M = L L'``. Then all coordinates have one unit,
so that one tolerance serves for all, and energies are sums of squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag, cholesky, solve_triangular

from rotor_ida.arrays import Values
from rotor_ida.checks import check_array, check_instance, shown
from rotor_ida.errors import InputError
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact, Race, Stator, Unbalance, check_contacts


@dataclass(frozen=True, slots=True, kw_only=True)
class Assembly:
    """A rotor system with all that stands around it.

    Parameters
    ----------
    system : RotorSystem
        The rotor.
    contacts : tuple of Contact
        Its contacts.
    stators : tuple of Stator
        The stators that move, each with two degrees of freedom behind those of the rotor; those
        without mass come last.
    mass, damping, gyroscopic, stiffness, stiffness_rate : ndarray, shape (n, n)
        Matrices of rotor and stators; None where there are none.
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
    contacts: tuple[Contact, ...]
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
        """The smallest clearance of all contacts; 1 where there are none."""
        return min((each.clearance for each in self.contacts), default=1.0)

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
    factor : ndarray, shape (n, n)
        Cholesky's factor L of the mass matrix, with the damping of stators without mass.
    massless : int
        How many of the coordinates, the last, are of stators without mass.
    stiffness, damping, gyroscopic, stiffness_rate, rows, unbalance, force
        As in `Assembly`.
    """

    factor: Values
    massless: int
    stiffness: Values
    damping: Values | None
    gyroscopic: Values | None
    stiffness_rate: Values | None
    rows: Values
    unbalance: Values
    force: Values

    def to_q(self, values: Values) -> Values:
        """Return q for rows of y, or its velocity."""
        return np.asarray(
            solve_triangular(
                self.factor, values.reshape(-1, values.shape[-1]).T, lower=True, trans=1
            ).T.reshape(values.shape)
        )

    def rows_in_y(self, rows: Values) -> Values:
        """Return rows that apply to y for rows that apply to q, shape (..., n)."""
        flat = rows.reshape(-1, rows.shape[-1]).T
        return np.asarray(solve_triangular(self.factor, flat, lower=True).T.reshape(rows.shape))

    def to_y(self, values: Values) -> Values:
        """Return y for q, or its velocity."""
        return np.asarray(self.factor.T @ values)


def assemble(
    system: RotorSystem,
    contacts: Sequence[Contact],
    unbalance: Sequence[Unbalance],
    gravity: tuple[float, float] | None,
    static_force: npt.ArrayLike | None,
) -> Assembly:
    """Return a rotor system joined with its stators, contacts and forces."""
    check_parts(system, contacts, unbalance)
    stators = _stators(contacts)
    size = system.size + 2 * len(stators)
    rows = np.zeros((len(contacts), 2, size))
    for number, each in enumerate(contacts):
        rows[number, :, : system.size] = system.rows(each.node)
        if isinstance(each.stator, str):
            rows[number, :, : system.size] -= system.rows(each.stator)
            if not rows[number].any():
                raise InputError(
                    f"stator of the contact at {shown(each.node)} must be another node, "
                    f"got {shown(each.stator)}"
                )
        elif each.stator is not None:
            place = system.size + 2 * stators.index(each.stator)
            rows[number, :, place : place + 2] = -np.eye(2)
    mass, stiffness = (_joined(system, stators, name) for name in ("mass", "stiffness"))
    pull = _gravity(gravity)
    if system.static_force is not None or static_force is not None:
        pull = pull + _gravity(system.gravity_in_static_force)
    moment = sum(each.moment * np.exp(1j * each.phase) for each in unbalance)
    turned = np.conj(moment) * complex(*pull)
    assert mass is not None
    assert stiffness is not None
    return Assembly(
        system=system,
        contacts=tuple(contacts),
        stators=stators,
        rows=rows,
        unbalance=_unbalance(system, unbalance, size),
        force=_force(system, stators, mass, gravity, static_force),
        gravity=pull,
        weight=(float(turned.imag), float(turned.real)),
        mass=mass,
        stiffness=stiffness,
        damping=_joined(system, stators, "damping"),
        gyroscopic=_joined(system, stators, "gyroscopic"),
        stiffness_rate=_joined(system, stators, "stiffness_rate"),
    )


def _stators(contacts: Sequence[Contact]) -> tuple[Stator, ...]:
    """Return the stators of contacts, those without mass behind; refuse one that two push."""
    given = [each.stator for each in contacts if isinstance(each.stator, Stator)]
    for number, contact in enumerate(contacts):
        stator = contact.stator
        if isinstance(stator, Stator) and stator.mass == 0.0:
            shared = sum(each is stator for each in given)
            if shared > 1:
                raise InputError(
                    f"a stator without mass must have one contact, got {shared} of that of contact "
                    f"{number} at {shown(contact.node)}"
                )
    return tuple(sorted({id(each): each for each in given}.values(), key=lambda s: s.mass == 0.0))


def check_parts(system: object, contacts: object, unbalance: object) -> None:
    """Refuse a system, contacts and unbalance of other types, and contacts that overlap."""
    check_instance("system", system, RotorSystem)
    for name, given, kind in (
        ("contacts", contacts, Contact),
        ("unbalance", unbalance, Unbalance),
    ):
        if isinstance(given, kind) or not isinstance(given, Sequence):
            raise InputError(f"{name} must be a list of {kind.__name__}, got {shown(given)}")
        for each in given:
            check_instance(name, each, kind)
    check_contacts(cast("Sequence[Contact]", contacts))


def canonical(assembly: Assembly) -> Canonical:
    """Return an assembly in coordinates with a unit mass matrix."""
    inert = assembly.mass
    if held := assembly.massless:
        assert assembly.damping is not None
        inert = inert.copy()
        inert[-held:, -held:] = assembly.damping[-held:, -held:]
    factor = cholesky(inert, lower=True)

    def forwards(values: Values) -> Values:
        return np.asarray(solve_triangular(factor, values, lower=True))

    def of_matrix(matrix: Values | None) -> Values | None:
        return None if matrix is None else forwards(forwards(matrix).T).T

    stiffness = of_matrix(assembly.stiffness)
    assert stiffness is not None
    size = assembly.size
    return Canonical(
        factor=factor,
        massless=held,
        stiffness=stiffness,
        damping=of_matrix(assembly.damping),
        gyroscopic=of_matrix(assembly.gyroscopic),
        stiffness_rate=of_matrix(assembly.stiffness_rate),
        rows=forwards(assembly.rows.reshape(-1, size).T).T.reshape(assembly.rows.shape),
        unbalance=forwards(assembly.unbalance.T).T,
        force=forwards(assembly.force),
    )


def _joined(system: RotorSystem, stators: Sequence[Stator], name: str) -> Values | None:
    """Return a matrix of rotor and stators; None where it is of neither."""
    own = getattr(system, name)
    mounts = [np.zeros((2, 2)) for _ in stators]
    if name in {"mass", "stiffness", "damping"}:
        mounts = [np.diag(np.broadcast_to(getattr(each, name), 2)) for each in stators]
    if own is None and not any(each.any() for each in mounts):
        return None
    return np.asarray(block_diag(np.zeros_like(system.mass) if own is None else own, *mounts))


def _unbalance(system: RotorSystem, unbalance: Sequence[Unbalance], size: int) -> Values:
    """Return the force of all unbalance over the square of the speed."""
    both = np.zeros((2, size))
    for each in unbalance:
        x, y = system.rows(each.node)
        cosine, sine = np.cos(each.phase), np.sin(each.phase)
        both[0, : system.size] += each.moment * (cosine * x + sine * y)
        both[1, : system.size] += each.moment * (cosine * y - sine * x)
    return both


def _gravity(given: tuple[float, float] | None) -> Values:
    """Return the acceleration of gravity along x and y."""
    if given is None:
        return np.zeros(2)
    g = check_array("gravity", given)
    if g.shape != (2,):
        raise InputError(f"gravity must be two numbers, along x and y, got {shown(given)}")
    return g


def _force(
    system: RotorSystem,
    stators: Sequence[Stator],
    mass: Values,
    gravity: tuple[float, float] | None,
    static_force: npt.ArrayLike | None,
) -> Values:
    """Return the constant force: gravity, the system's own, and another."""
    force = np.zeros(len(mass))
    if system.static_force is not None:
        force[: system.size] += system.static_force
    if static_force is not None:
        given = check_array("static_force", static_force)
        if given.shape not in {(system.size,), (len(mass),)}:
            raise InputError(
                f"static_force must have the shape {(system.size,)}, got {given.shape}"
            )
        force[: given.size] += given
    if gravity is not None:
        g = _gravity(gravity)
        force[: system.size] += system.weight(g)
        for number, each in enumerate(stators):
            place = system.size + 2 * number
            force[place : place + 2] += each.mass * g * each.weight
    return force
