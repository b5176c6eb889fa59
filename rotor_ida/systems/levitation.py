"""A rotor that magnetic bearings levitate, and what is left of it when they fail.

Each support holds its node at the centre and carries its static load, whatever that is, as the
integral part of a controller does; about the centre it is a spring and a damper. When supports
fail, both are gone at once. A support that stays keeps its spring, its damper and the load that it
carried: its integrator is too slow for a drop.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import check_instance, listed, shown
from rotor_ida.errors import InputError
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Support
from rotor_ida.systems.assembly import Assembly

# Forces that the supports must balance do so to this part of the largest.
BALANCED = 1e-9


@dataclass(frozen=True, slots=True)
class Levitated:
    """The state of a levitated rotor, and the loads of its supports.

    Parameters
    ----------
    start : ndarray, shape (2, n)
        Displacement and velocity on the steady whirl.
    loads : ndarray, shape (support, 2)
        Static force of each support on the rotor.
    """

    start: Values
    loads: Values


def check_supports(
    system: RotorSystem, supports: object, failing: object
) -> tuple[list[Support], list[bool]]:
    """Return supports at different nodes of a system, and which of them fail."""
    if isinstance(supports, Support) or not isinstance(supports, Sequence):
        raise InputError(f"supports must be a list of Support, got {shown(supports)}")
    found: list[Support] = []
    for each in supports:
        check_instance("supports", each, Support)
        system.rows(each.node)  # raises if it is unknown
        if any(each.node == other.node for other in found):
            raise InputError(f"supports must be at different nodes, got {each.node!r} twice")
        found.append(each)
    names = [each.node for each in found]
    if failing is None:
        return found, [True] * len(found)
    if isinstance(failing, str) or not isinstance(failing, Sequence) or not failing:
        raise InputError(f"failing must be a list of nodes of supports, got {shown(failing)}")
    for name in failing:
        if name not in names:
            allowed = (
                listed([repr(each) for each in names], "or") or "none, as there are no supports"
            )
            raise InputError(f"failing must be nodes of supports, {allowed}, got {shown(name)}")
    return found, [name in failing for name in names]


def with_supports(system: RotorSystem, supports: Sequence[Support]) -> RotorSystem:
    """Return a system with the springs and dampers of supports."""
    stiffness = system.stiffness.copy()
    damping = np.zeros_like(stiffness) if system.damping is None else system.damping.copy()
    for each in supports:
        rows = system.rows(each.node)
        stiffness += rows.T @ np.diag(np.asarray(each.stiffness)) @ rows
        damping += rows.T @ np.diag(np.asarray(each.damping)) @ rows
    return replace(system, stiffness=stiffness, damping=damping if damping.any() else None)


def levitated(assembly: Assembly, supports: Sequence[Support], speed: float) -> Levitated:
    """Return the steady state of a system whose supports hold their nodes at the centre.

    Parameters
    ----------
    assembly : Assembly
        The system with the springs and dampers of its supports.
    supports : sequence of Support
        Its supports.
    speed : float
        Spin speed.

    Notes
    -----
    At rest ``K q = f + B' p`` and ``B q = 0``, with the rows B of the supports and their loads p.
    The whirl ``Re(z exp(i Omega t))`` about it has
    ``(K - Omega**2 M + i Omega (C + Omega G)) z = Omega**2 (u_c - i u_s)``.
    """
    size, system = assembly.size, assembly.system
    rows = np.zeros((2 * len(supports), size))
    for number, each in enumerate(supports):
        rows[2 * number : 2 * number + 2, : system.size] = system.rows(each.node)
    still, loads = _held(assembly, rows)
    whirl = _whirl(assembly, speed)
    start = np.array([still + whirl.real, (1j * speed * whirl).real])
    return Levitated(start, loads.reshape(-1, 2))


def _held(assembly: Assembly, rows: Values) -> tuple[Values, Values]:
    """Return the displacement at rest with some rows of it held at zero, and their loads."""
    size, stiffness = assembly.size, assembly.stiffness
    if not len(rows):  # held by nothing but its own stiffness, if it has any
        found = np.linalg.lstsq(stiffness, assembly.force)[0]
        left = stiffness @ found - assembly.force
        held = np.abs(left).max(initial=0.0) <= BALANCED * np.abs(assembly.force).max(initial=0.0)
        return np.asarray(found if held else np.zeros(size)), np.zeros(0)
    scale = float(np.abs(stiffness).max()) or 1.0
    both = np.block([[stiffness, -scale * rows.T], [scale * rows, np.zeros((len(rows),) * 2)]])
    right = np.concatenate([assembly.force, np.zeros(len(rows))])
    found = np.linalg.lstsq(both, right)[0]
    if not np.abs(both @ found - right).max() <= BALANCED * np.abs(right).max(initial=0.0):
        raise InputError("supports must hold the rotor against its static forces, got too few")
    return found[:size], scale * found[size:]


def _whirl(assembly: Assembly, speed: float) -> Values:
    """Return the steady whirl by the unbalance, complex; zero without unbalance."""
    size = assembly.size
    force = speed**2 * (assembly.unbalance[0] - 1j * assembly.unbalance[1])
    if not force.any():
        return np.zeros(size, complex)
    resisted = np.zeros((size, size)) if assembly.damping is None else assembly.damping
    if assembly.gyroscopic is not None:
        resisted = resisted + speed * assembly.gyroscopic
    dynamic = assembly.stiffness - speed**2 * assembly.mass + 1j * speed * resisted
    try:
        return np.asarray(np.linalg.solve(dynamic, force))
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"speed must not be that of an undamped resonance, got {speed!r}"
        ) from error
