"""Synchronous whirls of an axisymmetric rotor system at many speeds: contact-free, and all rubs."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.closed_forms.contacting_whirls import Rows
from rotor_ida.closed_forms.receptances import Receptances
from rotor_ida.closed_forms.whirls.double_rubs import Pairs, double_rubs
from rotor_ida.closed_forms.whirls.single_rubs import single_rubs
from rotor_ida.closed_forms.whirls.turning_axes import Whirls, normal_forces
from rotor_ida.model.assembly import Assembly
from rotor_ida.model.contact import HERTZ_EXPONENT
from rotor_ida.model.system_parts import Contact

MOST_TOUCHING = 2
_PAIRS_AT_A_TIME = 2000


def whirls_of(assembly: Assembly, response: Receptances, speeds: Values) -> Whirls:
    """Return all whirls at speeds, in order of speed and of amplitude over clearance."""
    clearances = np.array([each.clearance for each in assembly.contacts])
    nothing = np.zeros((speeds.size, clearances.size))
    found = [Whirls(np.arange(speeds.size), nothing, response.free)]
    for touching in touching_sets(assembly.contacts):
        rows, depths = rubs(assembly.contacts, response, speeds, touching)
        found.append(rubbing_whirls(assembly, response, speeds, rows, touching, depths))
    whirls = _joined(found)
    fits = np.abs(whirls.displacement) <= clearances
    whirls = whirls[np.asarray((fits | whirls.touches).all(axis=1))]
    largest = (np.abs(whirls.displacement) / clearances).max(axis=1, initial=0.0)
    return whirls[np.lexsort((largest, whirls.row))]


def _joined(parts: Sequence[Whirls]) -> Whirls:
    return Whirls(
        np.concatenate([each.row for each in parts]),
        np.concatenate([each.depth for each in parts]),
        np.concatenate([each.displacement for each in parts]),
    )


def sliding(contacts: Sequence[Contact], speeds: Values) -> ComplexValues:
    """Return ``1 + i mu sigma`` of contacts at speeds, shape (speed, contact)."""
    friction = np.array([each.friction for each in contacts])
    return np.asarray(1.0 + 1j * np.sign(speeds)[:, np.newaxis] * friction)


def effects(
    contacts: Sequence[Contact], response: Receptances, speeds: Values
) -> tuple[ComplexValues, ComplexValues]:
    """Return displacements of contacts, over their clearances: by unbalance, and by their forces.

    The forces are those at an indentation of one clearance.
    """
    clearance = np.array([each.clearance for each in contacts])
    forces = np.array([each.stiffness * each.clearance**each.exponent for each in contacts])
    pushed = forces * sliding(contacts, speeds)
    effect = response.flexibility * pushed[:, np.newaxis] / clearance[:, np.newaxis]
    return response.free / clearance, effect


def touching_sets(contacts: Sequence[Contact]) -> list[tuple[int, ...]]:
    """Return the numbers of contacts that may touch together: each alone, and each two."""
    every = range(len(contacts))
    return [*((each,) for each in every), *combinations(every, MOST_TOUCHING)]


def rubs(
    contacts: Sequence[Contact],
    response: Receptances,
    speeds: Values,
    touching: tuple[int, ...],
) -> tuple[Rows, Values]:
    """Return all rubs of a set of contacts, whether or not the others are free.

    Returns
    -------
    rows, depths : ndarray, shapes (k,) and (k, contacts that touch)
        Number of the speed of each rub, and its indentations.
    """
    chosen = np.array(touching)
    hertz = [contacts[j].exponent == HERTZ_EXPONENT for j in touching]
    clearances = np.array([contacts[j].clearance for j in touching])
    free, effect = effects(contacts, response, speeds)
    free, effect = free[:, chosen], effect[:, chosen][:, :, chosen]
    if len(touching) == 1:
        rows, depths = single_rubs(np.abs(free[:, 0]), effect[:, 0, 0], hertz=hertz[0])
        return rows, clearances * depths[:, np.newaxis]
    turning = np.nonzero(speeds)[0]
    parts = []
    for part in np.array_split(turning, max(turning.size // _PAIRS_AT_A_TIME, 1)):
        rows, depths, _ = double_rubs(Pairs(free[part], effect[part], (hertz[0], hertz[1])))
        parts.append((part[rows], clearances * depths))
    rows = np.concatenate([rows for rows, _ in parts])
    return rows, np.concatenate([depths for _, depths in parts])


def rubbing_whirls(
    assembly: Assembly,
    response: Receptances,
    speeds: Values,
    rows: Rows,
    touching: tuple[int, ...],
    depths: Values,
) -> Whirls:
    """Return rubs with given indentations of some contacts, and the displacements of all."""
    contacts, chosen = assembly.contacts, np.array(touching)
    every = np.zeros((rows.size, len(contacts)))
    every[:, chosen] = depths
    force = normal_forces(contacts, every) * sliding(contacts, speeds[rows])
    free, pushed = response.free[rows], response.flexibility[rows] * force[:, np.newaxis]
    radii = every + np.array([each.clearance for each in contacts])
    matrix = pushed[:, chosen][:, :, chosen] + np.eye(chosen.size) * radii[:, chosen, np.newaxis]
    directions = np.linalg.solve(matrix, free[:, chosen, np.newaxis])
    directions /= np.abs(directions)
    displacement = free - (pushed[:, :, chosen] @ directions)[:, :, 0]
    displacement[:, chosen] = radii[:, chosen] * directions[:, :, 0]
    return Whirls(rows, every, displacement)
