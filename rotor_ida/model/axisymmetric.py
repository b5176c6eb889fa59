"""Axisymmetric rotor systems: the coordinates whose rotation is that of all nodes.

In an axisymmetric system a rotation J by a quarter turn commutes with all matrices. Its
eigenvectors of eigenvalue i span the circular motions forwards: half of the coordinates that the
nodes reach, complex, ``z = x + i y``. They are found from the nodes: the force ``(1, -i)`` at a
node is forward, and so is its part in each group of equal frequencies, with springs at the nodes,
and whatever damping and gyroscopic moments make of it. A system in which a backward motion arises
from these is not axisymmetric.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NoReturn

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly, Canonical, canonical
from rotor_ida.model.bearing import Films
from rotor_ida.model.system_parts import Stator

# Two squares of frequencies are one where they differ by less than these parts of themselves and of
# the largest: rounding.
EQUAL, OF_LARGEST = 1e-7, 1e-13
# Stiffness of springs at nodes that tell motions apart, as a part of the largest.
SPRINGS = 0.1
# A part of a motion below this is rounding.
REACHED = 1e-7
# A forward motion is at a right angle to the backward ones. Unequal matrices leave an angle of 0.
ASKEW = 0.1
# Parts of a matrix that turn a forward motion into a backward one, and of the force at a node that
# is one.
ROUNDED = 1e-7
# What takes a system that has no circular whirls.
INSTEAD = "use sweep, or simulate from the start 'settled'"
COMPUTES = "a run at constant speed, a run-up or a sweep computes them"


@dataclass(frozen=True, slots=True, kw_only=True)
class ForwardMotions:
    """The circular motions forwards of an axisymmetric system, with a unit mass matrix.

    ``p'' + (C + Omega G) p' + K p = sum over contacts of b' F``, with the complex forces F on the
    rotor and the displacements ``u = b p``.

    Parameters
    ----------
    stiffness, damping, gyroscopic : ndarray of complex, shape (n, n)
        The matrices.
    rows : ndarray of complex, shape (contact, n)
        The rows b.
    basis : ndarray of complex, shape (N, n)
        The motions in coordinates with a unit mass matrix, orthonormal.
    films : Films
        The bearings whose coefficients depend on the speed, which `stiffness` and `damping` lack.
    """

    stiffness: ComplexValues
    damping: ComplexValues
    gyroscopic: ComplexValues
    rows: ComplexValues
    basis: ComplexValues
    films: Films

    def stiffness_at(self, speeds: Values | float) -> ComplexValues:
        """Return the stiffness at speeds, shape (..., n, n), or at all, shape (n, n)."""
        return self.films.joined(self.stiffness, "stiffness", speeds)

    def damping_at(self, speeds: Values | float) -> ComplexValues:
        """Return the damping at speeds, shape (..., n, n), or at all, shape (n, n)."""
        return self.films.joined(self.damping, "damping", speeds)

    @property
    def size(self) -> int:
        """Their number n."""
        return len(self.stiffness)


def no_circles(error: InputError) -> str:
    """Return why whirls in contact are no circles, and what to ask instead, from a refusal."""
    reason = error.fields.get("reason")
    if reason is None:
        return str(error)
    return f"{reason}, so that rubs are not circular; {COMPUTES}"


def check_no_races(assembly: Assembly) -> None:
    """Refuse races that friction spins: a whirl that slides on them is not sought."""
    for number, each in enumerate(assembly.contacts):
        if each.spinning_race is not None and each.friction > 0.0:
            raise InputError(
                "{name} must be None for a whirl with friction, got a Race: {instead}",
                name=f"race of contact {number} at {shown(each.node)}", instead=INSTEAD,
                reason=f"contact {number} at {shown(each.node)} spins a race by friction",
            )  # fmt: skip


def check_axisymmetric_parts(assembly: Assembly) -> None:
    """Refuse contacts, stators and forces that are not the same in all directions."""
    for number, each in enumerate(assembly.contacts):
        where = f"of contact {number} at {shown(each.node)}"
        if each.centre != (0.0, 0.0):
            raise InputError(
                "{name} must be (0, 0) for a whirl, got {value}: {instead}",
                name=f"centre {where}", value=each.centre, instead=INSTEAD,
                reason=f"the centre {where} is off the axis",
            )  # fmt: skip
        if isinstance(each.stator, Stator):
            for name in ("stiffness", "damping"):
                pair = getattr(each.stator, name)
                if pair[0] != pair[1]:
                    raise InputError(
                        "{name} must be equal along x and y for a whirl, got {value}: {instead}",
                        name=f"{name} of the stator {where}", value=pair, instead=INSTEAD,
                        reason=f"the {name} of the stator {where} is not the same along x and y",
                    )  # fmt: skip
    if assembly.force.any():
        size = float(np.abs(assembly.force).max())
        raise InputError(
            "gravity and static_force must be 0 for a whirl, got up to {size:.6g}: leave them out, "
            "or {instead}",
            size=size, instead=INSTEAD, reason="gravity or a static force acts on the rotor",
        )  # fmt: skip


def check_masses(assembly: Assembly) -> None:
    """Refuse stators without mass, whose motions are of first order."""
    for number, each in enumerate(assembly.contacts):
        if isinstance(each.stator, Stator) and each.stator.mass == 0.0:
            raise InputError(
                f"mass of the stator of contact {number} at {shown(each.node)} must be positive "
                "for the linear motions of a system, got 0.0"
            )


def forward_motions(assembly: Assembly) -> ForwardMotions:
    """Return the forward motions of a system with its stators; refuse one without axial symmetry.

    Examples
    --------
    >>> from rotor_ida import RotorSystem
    >>> from rotor_ida.model.assembly import assemble
    >>> system = RotorSystem(mass=np.eye(2), stiffness=4 * np.eye(2), nodes={"disc": (0, 1)})
    >>> forward_motions(assemble(system)).stiffness.real
    array([[4.]])
    """
    found = canonical(assembly)
    matrices = _matrices(found)
    basis = _basis(matrices, _seeds(assembly, found))
    reduced = {}
    for name, matrix in matrices.items():
        reduced[name] = basis.conj().T @ matrix @ basis
        across = np.abs(basis.T @ matrix @ basis)
        sizes = np.sqrt(np.abs(basis.conj().T @ (matrix @ matrix.T) @ basis).diagonal())
        if (across > ROUNDED * np.sqrt(np.outer(sizes, sizes))).any():
            _refuse(name)
    for each in found.films.bearings:
        if not each.is_isotropic:
            _refuse(f"table of {each.words}")
    rows = found.rows[:, 0] + 1j * found.rows[:, 1]
    films = Films(found.films.bearings, found.films.rows @ basis)
    return ForwardMotions(rows=rows @ basis / np.sqrt(2.0), basis=basis, films=films, **reduced)


def _matrices(found: Canonical) -> dict[str, Values]:
    """Return stiffness, damping and gyroscopic matrix, 0 where there is none."""
    zero = np.zeros_like(found.stiffness)
    return {
        "stiffness": found.stiffness,
        "damping": zero if found.damping is None else found.damping,
        "gyroscopic": zero if found.gyroscopic is None else found.gyroscopic,
    }


def _seeds(assembly: Assembly, found: Canonical) -> list[tuple[str, ComplexValues]]:
    """Return the forward unit forces at all nodes and contacts that move."""
    nodes = found.rows_in_y(assembly.node_rows())
    names = [f"node {shown(name)}" for name in assembly.system.nodes]
    names += [f"contact {number}" for number in range(len(found.rows))]
    seeds = []
    for name, rows in zip(names, [*nodes, *found.rows], strict=True):
        force = rows[0] - 1j * rows[1]
        if (size := np.linalg.norm(force)) > 0.0:
            seeds.append((f"mass at {name}", force / size))
    return seeds


def _basis(matrices: dict[str, Values], seeds: list[tuple[str, ComplexValues]]) -> ComplexValues:
    """Return orthonormal forward motions, shape (N, n): all that the forces reach."""
    symmetric = 0.5 * (matrices["stiffness"] + matrices["stiffness"].T)
    least = REACHED * float(np.linalg.norm(symmetric))  # less of it is rounding
    others = {"stiffness": (matrices["stiffness"] - symmetric, least)}  # as of journal bearings
    others |= {name: (each, 0.0) for name, each in matrices.items() if name != "stiffness"}
    scaled = {
        name: each / max(float(np.linalg.norm(each)), smallest)
        for name, (each, smallest) in others.items() if each.any()
    }  # fmt: skip
    basis = np.zeros((len(symmetric), 0), complex)
    for name, force in seeds:
        if abs(force @ force) > ROUNDED:
            _refuse(name)
    groups = list(_groups(symmetric + _springs(symmetric, [force for _, force in seeds])))
    pending = [("stiffness", force) for _, force in seeds]
    while pending:
        names = [name for name, _ in pending for _ in groups]
        parts = [group @ (group.T @ force) for _, force in pending for group in groups]
        fresh = _independent(basis, names, np.column_stack(parts))
        basis = np.column_stack([basis, fresh])
        pending = [(name, each @ column) for column in fresh.T for name, each in scaled.items()]
    return basis


def _independent(basis: ComplexValues, names: list[str], parts: ComplexValues) -> ComplexValues:
    """Return orthonormal columns for what of the parts is not in a basis.

    The largest part comes first, as rounding disturbs it the least.
    """
    found = basis
    parts = parts - found @ (found.conj().T @ parts)
    while (sizes := np.linalg.norm(parts, axis=0)).max(initial=0.0) > REACHED:
        largest = int(np.argmax(sizes))
        column = parts[:, largest] / sizes[largest]
        column = column - found @ (found.conj().T @ column)
        column = column / np.linalg.norm(column)
        _check_forward(found, column, names[largest])
        found = np.column_stack([found, column])
        parts = parts - np.outer(column, column.conj() @ parts)
    return found[:, basis.shape[1] :]


def _springs(symmetric: Values, forces: list[ComplexValues]) -> Values:
    """Return the stiffness of springs between nodes and ground, the same in all directions.

    What nodes move stays in the motions that forces at them reach. Without springs the motions of a
    shaft that hardly anything holds are nearly of equal frequencies, and rounding mixes them.
    """
    held = np.zeros_like(symmetric)
    sizes = SPRINGS * float(np.linalg.norm(symmetric)) * np.linspace(0.5, 1.0, len(forces))
    for size, force in zip(sizes.tolist(), forces, strict=True):
        held += size * np.outer(force, force.conj()).real
    return held


def _groups(symmetric: Values) -> Iterator[Values]:
    """Yield the motions of each frequency of a symmetric stiffness, as orthonormal columns."""
    squares, shapes = np.linalg.eigh(symmetric)
    apart = np.diff(squares) > EQUAL * np.abs(squares[1:]) + OF_LARGEST * np.abs(squares).max()
    edges = [0, *(np.nonzero(apart)[0] + 1).tolist(), len(squares)]
    for first, last in pairwise(edges):
        yield shapes[:, first:last]


def _check_forward(basis: ComplexValues, vector: ComplexValues, name: str) -> None:
    """Refuse a motion that is not at a right angle to all backward ones."""
    if max(np.abs(basis.T @ vector).max(initial=0.0), abs(vector @ vector)) > ASKEW:
        _refuse(name)


def _refuse(name: str) -> NoReturn:
    """Refuse a system by the name of what is not the same in all directions."""
    raise InputError(
        "system must be axisymmetric for a whirl, got one whose {part} is not the same along x "
        "and y: {instead}",
        part=name,
        instead=INSTEAD,
        reason=f"the {name} is not the same along x and y",
    )
