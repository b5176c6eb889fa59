"""The steady state of a rotor that magnetic bearings levitate, and which of them fail.

When a support fails, its spring, its damper and its static load are gone at once. A support that
stays keeps its spring, its damper and the load that it carried: its integrator is too slow for a
drop.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import listed, shown
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly
from rotor_ida.model.supports import held_at_centre
from rotor_ida.model.system_parts import Support


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


def check_failing(supports: Sequence[Support], failing: object) -> list[bool]:
    """Return which supports fail."""
    names = [each.node for each in supports]
    if failing is None:
        return [True] * len(names)
    if isinstance(failing, str) or not isinstance(failing, Sequence) or not failing:
        raise InputError(f"failing must be a list of nodes of supports, got {shown(failing)}")
    for name in failing:
        if name not in names:
            allowed = (
                listed([repr(each) for each in names], "or") or "none, as there are no supports"
            )
            raise InputError(f"failing must be nodes of supports, {allowed}, got {shown(name)}")
    return [name in failing for name in names]


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
    still, loads = held_at_centre(assembly.stiffness, assembly.force, rows)
    whirl = _whirl(assembly, speed)
    start = np.array([still + whirl.real, (1j * speed * whirl).real])
    return Levitated(start, loads.reshape(-1, 2))


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
            "{name} must not be that of an undamped resonance, got {value}",
            name="speed", value=speed,
        ) from error  # fmt: skip
