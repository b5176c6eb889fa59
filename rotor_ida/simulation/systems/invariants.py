"""What a run of a rotor system must not contradict: the laws of contact, and its energy."""

from __future__ import annotations

import math

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.core.systems import SystemRequest, SystemResult
from rotor_ida.errors import InvariantError
from rotor_ida.model.assembly import Assembly, Canonical
from rotor_ida.schema.flags import ENTRY

# Forces beyond their limits, and energy that is missing, in parts of their size: rounding, and what
# the tolerance allows. The energy of 300 random systems was missing by at most 4.2e-11 at rtol
# 1e-10, and 1.4e-6 at 1e-6.
ROUNDED, OF_TOLERANCE = 1e-9, 30.0


def check_run(
    assembly: Assembly, found: Canonical, request: SystemRequest, result: SystemResult, rtol: float
) -> None:
    """Raise an error where a run contradicts the mechanics."""
    allowed = ROUNDED + OF_TOLERANCE * rtol
    for number, contact in enumerate(assembly.contacts):
        kinds = result.event_kinds[result.event_contacts == number]
        edges = kinds[np.abs(kinds) == ENTRY]
        if (edges[1:] == edges[:-1]).any():
            raise InvariantError(f"entry and exit of contact {number} do not alternate")
        normal, tangential = result.forces[:, number, 0], result.forces[:, number, 1]
        rounded = allowed * float(normal.max(initial=0.0))
        if normal.min(initial=0.0) < -rounded:
            raise InvariantError(f"the normal force of contact {number} is tensile")
        if (np.abs(tangential) > contact.friction * normal + rounded).any():
            raise InvariantError(f"contact {number} holds more than its friction can")
    if not math.isnan(result.ledger["unbalance"]):  # CVODE keeps none
        _check_energy(found, request, result, allowed)


def _check_energy(
    found: Canonical, request: SystemRequest, result: SystemResult, allowed: float
) -> None:
    """Compare the energy at both ends with what was gained and lost in between.

    The errors of a run are in parts of the clearance: of a motion that is far smaller, the energy
    is off by its velocity times that of the scale.
    """
    start = request.start
    spent = result.ledger
    kept = energy_of(found, result.state) - energy_of(found, start)
    lost = sum(spent[name] for name in ("damping", "stiffness_rate", "normal", "tangential"))
    size = size_of_energy(found, np.concatenate([start[np.newaxis], result.samples]))
    turnover = size + sum(map(abs, spent.values()))
    slight = math.sqrt(turnover) * request.velocity
    if abs(kept - spent["unbalance"] + lost) > allowed * max(turnover, slight):
        raise InvariantError(
            f"the energy does not balance: {kept:.9g} kept, {spent['unbalance'] - lost:.9g} gained"
        )


def energy_of(found: Canonical, state: Values) -> float:
    """Return the energy of a state: kinetic, elastic and of the constant force."""
    y, v = state
    moving = v[: len(v) - found.massless]
    return float(0.5 * (moving @ moving) + 0.5 * (y @ (found.stiffness @ y)) - found.force @ y)


def size_of_energy(found: Canonical, states: Values) -> float:
    """Return the largest sum of the sizes of all parts of the energy over some states."""
    y, v = states[:, 0], states[:, 1]
    bent = np.abs(np.einsum("ij,ij->i", y, y @ found.stiffness.T))
    sizes = 0.5 * (v**2).sum(axis=1) + 0.5 * bent + np.abs(y @ found.force)
    return float(sizes.max(initial=0.0))
