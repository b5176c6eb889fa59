"""Fewer coordinates for a rotor system: its slow modes, and the static flexibility of some nodes.

Modes alone make a node too stiff for a contact, whose force bends the rotor locally: the events of
a contact converge slowly with their number. With the static deflections by unit forces at the
node, its static flexibility is exact, and few modes suffice [1]_.

References
----------
.. [1] R. R. Craig and C.-J. Chang, "On the use of attachment modes in substructure coupling for
   dynamic analysis", AIAA paper 77-405, 1977.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.linalg import eigh, lu_factor, lu_solve

from rotor_ida.arrays import Flags, Values
from rotor_ida.checks import check_array, check_count, shown
from rotor_ida.errors import InputError
from rotor_ida.model.bearing import Bearing
from rotor_ida.model.rotor_system import RotorSystem, levitated_system
from rotor_ida.model.system_parts import Contact

# A stiffness whose smallest eigenvalue is below this part of the largest has free motions.
FREE = 1e-12
# A mode whose displacements at the nodes are below this part of the largest moves none.
STILL = 1e-9
# Directions that add less than this part to the others are left out.
DEPENDENT = 1e-8
# A product of modes by the stiffness below this part of the largest, of sizes of its terms, is
# rounding.
ROUNDED = 1e-14


def reduced_system(
    system: RotorSystem, *, modes: int, keep: Sequence[str] | None = None
) -> RotorSystem:
    """Return a rotor system in fewer coordinates.

    Parameters
    ----------
    system : RotorSystem
        The system.
    modes : int
        Number of modes without damping and rotation, the slowest first. Modes that move no node,
        such as those of torsion and along the axis, do not count.
    keep : sequence of str, optional
        Nodes whose static flexibility is kept: two coordinates more for each. Default: those of the
        contacts, and of bearings whose coefficients depend on the speed, for which the modes are
        those in the middle of the tables.

    Returns
    -------
    RotorSystem
        With a unit mass matrix, and nodes by rows; with the same contacts, unbalance, supports,
        bearings and gravity.

    Raises
    ------
    InputError
        If there are fewer modes, or a node is unknown.

    Examples
    --------
    >>> chain = np.diag([2.0, 2.0, 2.0, 1.0]) - np.eye(4, k=1) - np.eye(4, k=-1)
    >>> stiffness = np.kron(chain, np.eye(2))
    >>> beam = RotorSystem(mass=np.eye(8), stiffness=stiffness, nodes={"end": (6, 7)})
    >>> small = reduced_system(beam, modes=2, keep=["end"])
    >>> small
    RotorSystem(4 degrees of freedom, node end)
    >>> row = small.rows("end")[0]
    >>> round(float(row @ np.linalg.solve(small.stiffness, row)), 9)  # flexibility of the end
    4.0
    """
    return in_basis(system, reduced_basis(system, modes=modes, keep=keep))


def reduced_basis(system: RotorSystem, *, modes: int, keep: Sequence[str] | None = None) -> Values:
    """Return the directions that `reduced_system` keeps, shape (n, k), orthonormal by the mass."""
    films = [each for each in system.bearings if each.varies]
    if keep is None:
        joints: list[Contact | Bearing] = [*system.contacts, *films]
        touched = [each.node for each in joints]
        touched += [each.stator for each in joints if isinstance(each.stator, str)]
        keep = list(dict.fromkeys(touched))
    if isinstance(keep, str) or not all(isinstance(each, str) for each in keep):
        raise InputError(f"keep must be a list of names of nodes, got {shown(keep)}")
    count = check_count("modes", modes, minimum=0, maximum=system.size)
    stiffness = system.stiffness
    if films:
        tables = [each.knots for each in films]
        middle = 0.5 * (max(each[0] for each in tables) + min(each[-1] for each in tables))
        stiffness = system.at(middle).stiffness
    symmetric = 0.5 * (stiffness + stiffness.T)
    if count + 2 * len(keep) == 0:
        raise InputError("modes must be at least 1 where no node is kept, got 0")
    squares, shapes = eigh(symmetric, system.mass)
    basis = shapes[:, _moving(system, shapes)][:, :count]
    if keep:
        shift = 0.0
        if squares[0] < FREE * squares[-1]:  # free motions: about the slowest that is none
            bending = squares[squares > FREE * squares[-1]]
            shift = float(bending[0]) if bending.size else 1.0
        rows = np.concatenate([system.rows(name) for name in keep])
        factors = lu_factor(stiffness + shift * system.mass)
        own = basis.shape[1]
        basis = _joined(basis, lu_solve(factors, rows.T), system.mass)
        more = basis[:, own:]  # the stiffness of these too is a diagonal
        basis[:, own:] = more @ eigh(more.T @ symmetric @ more)[1]
    return np.asarray(basis)


def _moving(system: RotorSystem, shapes: Values) -> Flags:
    """Return which modes move a node."""
    if not system.nodes:
        return np.ones(shapes.shape[1], bool)
    rows = np.concatenate([system.rows(name) for name in system.nodes])
    moved = np.abs(rows @ shapes).max(axis=0)
    return np.asarray(moved > STILL * moved.max())


def in_basis(system: RotorSystem, basis: Values) -> RotorSystem:
    """Return a system in the coordinates of a basis, shape (n, k), with a unit mass matrix."""

    def small(matrix: Values | None) -> Values | None:
        return None if matrix is None else basis.T @ matrix @ basis

    try:
        translations = basis.T @ (system.mass @ system.unit_translations())
    except InputError:  # gravity is asked for later, or never
        translations = None
    force, size = system.static_force, system.size
    if force is not None:  # stators keep theirs
        force = np.concatenate([basis.T @ force[:size], force[size:]])
    stiffness = small(system.stiffness)
    assert stiffness is not None
    # what is left is the diagonal where modes alone are kept, and the core makes use of that
    summed = np.abs(basis).T @ np.abs(system.stiffness) @ np.abs(basis)
    hidden = np.abs(stiffness) <= ROUNDED * summed.max(initial=0.0)
    stiffness[hidden & ~np.eye(len(stiffness), dtype=bool)] = 0.0
    gyroscopic = small(system.gyroscopic)
    if gyroscopic is not None:
        gyroscopic = 0.5 * (gyroscopic - gyroscopic.T)
    return RotorSystem(
        mass=np.eye(basis.shape[1]), stiffness=stiffness, damping=small(system.damping),
        gyroscopic=gyroscopic, stiffness_rate=small(system.stiffness_rate),
        nodes={name: system.rows(name) @ basis for name in system.nodes},
        translations=translations, contacts=system.contacts, unbalance=system.unbalance,
        supports=system.supports, bearings=system.bearings,
        gravity=system.gravity, static_force=force,
        gravity_in_static_force=system.gravity_in_static_force, positions=system.positions,
        units=system.units, added_mass=small(system.added_mass), note=system.note,
    )  # fmt: skip


def _joined(basis: Values, more: Values, mass: Values) -> Values:
    """Return a basis with more directions, orthonormal by the mass; twice, against rounding."""
    for column in more.T:
        own = column / np.sqrt(column @ mass @ column)
        for _ in range(2):
            own = own - basis @ (basis.T @ (mass @ own))
        size = float(np.sqrt(own @ mass @ own))
        if size > DEPENDENT:
            basis = np.column_stack([basis, own / size])
    return basis


# ---- With a number of modes as an argument ----


def check_modes(modes: int | None, more_modes: int | None) -> None:
    """Refuse a second number of modes that is no larger than the first."""
    if more_modes is None:
        return
    if modes is None:
        raise InputError("modes must be given with more_modes, got None")
    few, more = check_count("modes", modes, minimum=0), check_count("more_modes", more_modes)
    if more <= few:
        raise InputError(f"more_modes must be more than modes, {few}, got {more}")


def in_modes(system: RotorSystem, modes: int | None, start: Any) -> tuple[RotorSystem, Any]:
    """Return a system and its start, reduced with its supports if a number of modes is given.

    The static flexibility of the nodes of all contacts is kept.
    """
    if modes is None:
        return system, start
    system = levitated_system(system)
    basis = reduced_basis(system, modes=modes)
    if isinstance(start, tuple | list) and len(start) == 2:
        names = ("displacement", "velocity")
        start = tuple(
            _state_in(f"{name} of the start", each, basis, system.mass)
            for name, each in zip(names, start, strict=True)
        )
    return in_basis(system, basis), start


def _state_in(name: str, given: object, basis: Values, mass: Values) -> Values:
    """Return the nearest state, by the mass, in the coordinates of a basis; stators stay."""
    values, size = check_array(name, given), len(basis)
    if values.ndim != 1 or values.size < size:
        raise InputError(f"{name} must have the shape {(size,)}, got {values.shape}")
    return np.concatenate([basis.T @ (mass @ values[:size]), values[size:]])
