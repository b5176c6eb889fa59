"""The whirl of a rotor system without contact.

Without contact the motion is linear: the static deflection and an ellipse at each contact. Where it
would exceed a clearance, no motion without contact exists.
"""

from __future__ import annotations

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.clearances.critical_speeds import orbit_axes
from rotor_ida.closed_forms.receptances import solved_motions
from rotor_ida.model.assembly import Assembly
from rotor_ida.simulation.starts import settled

# Points of a revolution among which the largest distance from a stator is found, to 4e-5 of it.
POINTS = 360


def beyond(assembly: Assembly, speeds: Values) -> Values:
    """Return how far the motion without contact exceeds each clearance, shape (speed, contact)."""
    sag = assembly.rows @ settled(assembly, 0.0)[0] - [each.centre for each in assembly.contacts]
    force = assembly.unbalance[0] - 1j * assembly.unbalance[1]
    motions = solved_motions(assembly, speeds, force[:, np.newaxis])[:, :, 0]
    whirl = np.einsum("pjk,sk->spj", assembly.rows, motions * speeds[:, np.newaxis] ** 2)
    turns = np.exp(2j * np.pi * np.arange(POINTS) / POINTS)
    places = sag[..., np.newaxis] + (whirl[..., np.newaxis] * turns).real
    clearances = np.array([each.clearance for each in assembly.contacts])
    return np.asarray(np.hypot(places[:, :, 0], places[:, :, 1]).max(axis=-1) - clearances)


def clear_whirl(assembly: Assembly, node: int, speeds: Values) -> Values:
    """Return the largest radius of a node about its mean place; NaN where a contact is reached."""
    force = assembly.unbalance[0] - 1j * assembly.unbalance[1]
    rows = assembly.node_rows()[node : node + 1]
    axes = orbit_axes(assembly, rows, force[:, np.newaxis], speeds)[0, :, 0]
    touches = (beyond(assembly, speeds) > 0.0).any(axis=1)
    return np.where(touches, np.nan, 0.5 * axes)
