"""Stability of synchronous whirls of an axisymmetric system: eigenvalues on rotating axes.

On axes that rotate with the unbalance a whirl stands still, and small motions p about it obey

    p'' + (C + Omega G + 2 i Omega) p' + (K - Omega**2 + i Omega (C + Omega G)) p = b' E phi.

At a contact in the direction E, ``b p = E (xi + i eta)``: the radial part xi changes the normal
force, ``N' = n k d**(n-1) xi + lambda N xi'``, and the tangential part eta turns it, so that

    phi = -(1 + i mu sigma) (n k d**(n-1) xi + lambda N xi' + i N eta/A).

Contact damping lambda enters here alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import ComplexValues, Flags, Values
from rotor_ida.closed_forms.contacting_whirls import Rows
from rotor_ida.closed_forms.linear_motions import first_order
from rotor_ida.model.axisymmetric import ForwardMotions
from rotor_ida.model.system_parts import Contact

# Growth rates that are 0 but for rounding, over the largest eigenvalue.
NEUTRAL = 1e-11
# Numbers in the matrices whose eigenvalues are computed at a time.
_AT_A_TIME = 2_000_000


@dataclass(frozen=True, slots=True)
class Whirls:
    """Synchronous whirls of a system, one a row.

    Parameters
    ----------
    row : ndarray of int, shape (whirl,)
        Number of the speed.
    depth : ndarray, shape (whirl, contact)
        Indentation of each contact, 0 where it is free.
    displacement : ndarray of complex, shape (whirl, contact)
        Displacement of each contact, on axes that rotate with the rotor.
    """

    row: Rows
    depth: Values
    displacement: ComplexValues

    @property
    def touches(self) -> Flags:
        """Which contacts touch, shape (whirl, contact)."""
        return np.asarray(self.depth > 0.0)

    def __getitem__(self, chosen: Flags | Rows | slice) -> Whirls:
        return Whirls(self.row[chosen], self.depth[chosen], self.displacement[chosen])


def normal_forces(contacts: Sequence[Contact], depths: Values) -> Values:
    """Return the normal forces at constant indentations, shape (whirl, contact)."""
    forces = [each.stiffness * depths[:, j] ** each.exponent for j, each in enumerate(contacts)]
    return np.stack(forces, axis=1) if forces else np.zeros(depths.shape)


def eigenvalues_without_contact(motions: ForwardMotions, speeds: Values) -> ComplexValues:
    """Return the eigenvalues of free motions at speeds, on fixed axes, shape (speed, 2 n)."""
    resisted = motions.damping_at(speeds) + speeds[:, np.newaxis, np.newaxis] * motions.gyroscopic
    found = np.linalg.eigvals(first_order(motions.stiffness_at(speeds), resisted))
    return found.astype(np.complex128)


def eigenvalues_in_contact(
    motions: ForwardMotions, contacts: Sequence[Contact], speeds: Values, whirls: Whirls
) -> ComplexValues:
    """Return the eigenvalues of whirls on rotating axes, shape (whirl, 4 n).

    `speeds` are those of the whirls.
    """
    size = motions.size
    step = max(_AT_A_TIME // (4 * size) ** 2, 1)
    found = np.zeros((speeds.size, 4 * size), complex)
    for first in range(0, speeds.size, step):
        part = slice(first, first + step)
        found[part] = np.linalg.eigvals(_matrices(motions, contacts, speeds[part], whirls[part]))
    return found


def _matrices(
    motions: ForwardMotions, contacts: Sequence[Contact], speeds: Values, whirls: Whirls
) -> Values:
    """Return the real matrices of ``(Re p, Im p, Re p', Im p')``, shape (whirl, 4 n, 4 n)."""
    omega = speeds[:, np.newaxis, np.newaxis]
    resisted = motions.damping_at(speeds) + omega * motions.gyroscopic
    one = np.eye(motions.size)
    stiffness = as_real(motions.stiffness_at(speeds) - omega**2 * one + 1j * omega * resisted)
    damping = as_real(resisted + 2j * omega * one)
    forces = normal_forces(contacts, whirls.depth)
    for number, contact in enumerate(contacts):
        touching = whirls.touches[:, number]
        if not touching.any():
            continue
        depth, force = whirls.depth[touching, number], forces[touching, number]
        displacement = whirls.displacement[touching, number]
        beta = (displacement / np.abs(displacement)).conj()[:, np.newaxis] * motions.rows[number]
        rows = np.stack(
            [np.hstack([beta.real, -beta.imag]), np.hstack([beta.imag, beta.real])], axis=1
        )
        sliding = contact.friction * np.sign(speeds[touching])
        turned = np.zeros((len(beta), 2, 2))
        turned[:, 0, 0] = turned[:, 1, 1] = 1.0
        turned[:, 0, 1], turned[:, 1, 0] = -sliding, sliding
        pushed = rows.transpose(0, 2, 1) @ turned
        stiff = [contact.exponent * force / depth, force / (contact.clearance + depth)]
        stiffness[touching] += pushed @ (np.stack(stiff, axis=1)[:, :, np.newaxis] * rows)
        drag = (contact.damping * force)[:, np.newaxis, np.newaxis]
        damping[touching] += pushed[:, :, :1] @ (drag * rows[:, :1])
    return first_order(stiffness, damping)


def as_real(matrices: ComplexValues) -> Values:
    """Return complex matrices as real ones of the real and imaginary parts."""
    return np.block([[matrices.real, -matrices.imag], [matrices.imag, matrices.real]])
