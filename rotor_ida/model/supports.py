"""A rotor that magnetic bearings levitate.

Each support holds its node at the centre and carries its static load, whatever that is, as the
integral part of a controller does; about the centre it is a spring and a damper.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Support

# Forces that the supports must balance do so to this part of the largest.
BALANCED = 1e-9


def with_supports(system: RotorSystem, supports: Sequence[Support]) -> RotorSystem:
    """Return a system with the springs and dampers of supports in its matrices, and none left."""
    stiffness = system.stiffness.copy()
    damping = np.zeros_like(stiffness) if system.damping is None else system.damping.copy()
    for each in supports:
        rows = system.rows(each.node)
        stiffness += rows.T @ np.diag(np.asarray(each.stiffness)) @ rows
        damping += rows.T @ np.diag(np.asarray(each.damping)) @ rows
    damped = damping if damping.any() else None
    return replace(system, stiffness=stiffness, damping=damped, supports=())


def levitated_system(system: RotorSystem, speed: float | None = None) -> RotorSystem:
    """Return a system whose supports are in its matrices, with the static loads that they carry.

    Its static force leaves the weight out, which gravity adds in a run. Constant bearings are in
    its matrices too; those that are left depend on the speed, and help the supports to carry the
    loads with their coefficients at a `speed`, if one is given.
    """
    varying = tuple(each for each in system.bearings if each.varies)
    if len(varying) < len(system.bearings):
        constant = [each for each in system.bearings if not each.varies]
        system = replace(replace(system, bearings=constant).at(0.0), bearings=varying)
    if not system.supports:
        return system
    held = with_supports(system, system.supports)
    own = np.zeros(system.size) if system.static_force is None else system.static_force
    force = own[: system.size]
    if system.gravity is not None:
        force = force + system.weight(system.gravity)
    if not force.any():
        return held
    rows = np.concatenate([system.rows(each.node) for each in system.supports])
    carried = own.copy()
    stiffness = held.stiffness if speed is None else held.at(speed).stiffness
    carried[: system.size] += rows.T @ held_at_centre(stiffness, force, rows)[1]
    return replace(held, static_force=carried)


def held_at_centre(stiffness: Values, force: Values, rows: Values) -> tuple[Values, Values]:
    """Return the displacement at rest with some rows of it held at zero, and their loads.

    Notes
    -----
    ``K q = f + B' p`` and ``B q = 0``, with the rows B and their loads p.
    """
    size = len(stiffness)
    if not len(rows):  # held by nothing but its own stiffness, if it has any
        found = np.linalg.lstsq(stiffness, force)[0]
        left = stiffness @ found - force
        held = np.abs(left).max(initial=0.0) <= BALANCED * np.abs(force).max(initial=0.0)
        return np.asarray(found if held else np.zeros(size)), np.zeros(0)
    scale = float(np.abs(stiffness).max()) or 1.0
    both = np.block([[stiffness, -scale * rows.T], [scale * rows, np.zeros((len(rows),) * 2)]])
    right = np.concatenate([force, np.zeros(len(rows))])
    found = np.linalg.lstsq(both, right)[0]
    if not np.abs(both @ found - right).max() <= BALANCED * np.abs(right).max(initial=0.0):
        raise InputError("supports must hold the rotor against its static forces, got too few")
    return found[:size], scale * found[size:]
