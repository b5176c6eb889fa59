"""Receptances of an axisymmetric rotor system: forward displacements by forward forces at a speed.

With ``z = x + i y`` a forward motion is ``z = Z exp(i Omega t)``, and so is a forward force. With
the rows w of a node, ``z = w q``, unit forces at one contact displace another by
``H = w (K - Omega**2 M + i Omega (C + Omega G))**-1 w' / 2``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.checks import LARGEST_NUMBER, check_vector
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly

# Numbers in the matrices of as many speeds as are solved at a time.
_AT_A_TIME = 4_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Receptances:
    """What unbalance and unit forces at contacts displace, at each speed.

    Parameters
    ----------
    free : ndarray of complex, shape (speed, contact)
        Displacements of the contacts by the unbalance.
    flexibility : ndarray of complex, shape (speed, contact, contact)
        Displacements of the contacts (rows) by unit forces at the contacts (columns).
    node_free, node_flexibility : ndarray of complex, shapes (speed, node), (speed, node, contact)
        The same for all nodes.
    """

    free: ComplexValues
    flexibility: ComplexValues
    node_free: ComplexValues
    node_flexibility: ComplexValues


def checked_speeds(speed: object) -> Values:
    """Return spin speeds, one or several, as an array."""
    speeds = check_vector("speed", speed) + 0.0
    if (outside := np.abs(speeds) > LARGEST_NUMBER).any():
        raise InputError(
            "{name} must be at most {most:g}, got {value}",
            name="speed", most=LARGEST_NUMBER, value=float(speeds[outside][0]),
        )  # fmt: skip
    return speeds


def receptances(assembly: Assembly, speeds: Values) -> Receptances:
    """Return the receptances of an axisymmetric system at speeds, all 0 at rest.

    Raises
    ------
    InputError
        If a speed is a resonance without damping.
    """
    contacts, nodes = (_forward(rows) for rows in (assembly.rows, assembly.node_rows()))
    unbalance = assembly.unbalance[0] - 1j * assembly.unbalance[1]
    forces = np.column_stack([unbalance, contacts.conj().T])
    rows = 0.5 * np.concatenate([contacts, nodes])
    found = np.zeros((speeds.size, len(rows), forces.shape[1]), complex)
    turning = np.nonzero(speeds)[0]
    found[turning] = rows @ solved_motions(assembly, speeds[turning], forces)
    found[:, :, 0] *= speeds[:, np.newaxis] ** 2
    count = len(contacts)
    return Receptances(
        free=found[:, :count, 0], flexibility=found[:, :count, 1:],
        node_free=found[:, count:, 0], node_flexibility=found[:, count:, 1:],
    )  # fmt: skip


def _forward(rows: Values) -> ComplexValues:
    """Return the rows ``w = b_x + i b_y`` of nodes, shape (node, n)."""
    return np.asarray(rows[:, 0] + 1j * rows[:, 1])


def solved_motions(assembly: Assembly, speeds: Values, forces: ComplexValues) -> ComplexValues:
    """Return the motions by forces at speeds, shape (speed, n, force)."""
    step = max(_AT_A_TIME // assembly.size**2, 1)
    parts = [_motions(assembly, speeds[first : first + step], forces)
             for first in range(0, speeds.size, step)]  # fmt: skip
    return np.concatenate([np.zeros((0, *forces.shape), complex), *parts])


def _motions(assembly: Assembly, speeds: Values, forces: ComplexValues) -> ComplexValues:
    omega = speeds[:, np.newaxis, np.newaxis]
    dynamic = (assembly.stiffness_at(speeds) - omega**2 * assembly.mass).astype(complex)
    dynamic += 1j * omega * assembly.damping_at(speeds)
    if assembly.gyroscopic is not None:
        dynamic += 1j * omega**2 * assembly.gyroscopic
    try:
        motions = np.linalg.solve(dynamic, forces)
    except np.linalg.LinAlgError:
        motions = np.array([_or_infinite(each, forces) for each in dynamic])
    resonant = ~np.isfinite(motions).all(axis=(1, 2))
    if resonant.any():
        raise InputError(
            "{name} must not be a resonance without damping, got {value}",
            name="speed", value=float(speeds[np.argmax(resonant)]),
        )  # fmt: skip
    return np.asarray(motions)


def _or_infinite(dynamic: ComplexValues, forces: ComplexValues) -> ComplexValues:
    try:
        return np.asarray(np.linalg.solve(dynamic, forces))
    except np.linalg.LinAlgError:
        return np.full(forces.shape, np.inf, np.complex128)
