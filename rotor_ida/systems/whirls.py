"""Synchronous whirls of an axisymmetric rotor system at many speeds: contact-free, and all rubs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.closed_forms.contacting_whirls import Rows
from rotor_ida.model.contact import HERTZ_EXPONENT
from rotor_ida.model.system_parts import Contact
from rotor_ida.systems.assembly import Assembly
from rotor_ida.systems.double_rubs import Pairs, double_rubs
from rotor_ida.systems.receptances import Receptances
from rotor_ida.systems.single_rubs import single_rubs
from rotor_ida.systems.turning_axes import Whirls, normal_forces

MOST_TOUCHING = 2
_PAIRS_AT_A_TIME = 2000


def whirls_of(assembly: Assembly, response: Receptances, speeds: Values) -> Whirls:
    """Return all whirls at speeds, in order of speed and of amplitude over clearance."""
    clearances = np.array([each.clearance for each in assembly.contacts])
    nothing = np.zeros((speeds.size, clearances.size))
    found = [Whirls(np.arange(speeds.size), nothing, response.free)]
    found += [
        rubbing_whirls(assembly, response, speeds, rows, depths)
        for rows, depths in rubs(assembly, response, speeds)
    ]
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


def rubs(
    assembly: Assembly, response: Receptances, speeds: Values
) -> Iterator[tuple[Rows, dict[int, Values]]]:
    """Yield all rubs: numbers of speeds, and indentations by contact."""
    contacts = assembly.contacts
    hertz = [each.exponent == HERTZ_EXPONENT for each in contacts]
    free, effect = effects(contacts, response, speeds)
    for number, each in enumerate(contacts):
        rows, depths = single_rubs(
            np.abs(free[:, number]), effect[:, number, number], hertz=hertz[number]
        )
        yield rows, {number: each.clearance * depths}
    turning = np.nonzero(speeds)[0]
    for one, other in combinations(range(len(contacts)), 2):
        chosen = np.array([one, other])
        for part in np.array_split(turning, max(turning.size // _PAIRS_AT_A_TIME, 1)):
            pairs = Pairs(
                free[part][:, chosen], effect[part][:, chosen][:, :, chosen],
                (hertz[one], hertz[other]),
            )  # fmt: skip
            rows, both, _ = double_rubs(pairs)
            both = both * np.array([contacts[one].clearance, contacts[other].clearance])
            yield part[rows], {one: both[:, 0], other: both[:, 1]}


def rubbing_whirls(
    assembly: Assembly,
    response: Receptances,
    speeds: Values,
    rows: Rows,
    depths: dict[int, Values],
) -> Whirls:
    """Return rubs with given indentations of some contacts, and the displacements of all."""
    contacts, touching = assembly.contacts, np.array(list(depths))
    every = np.zeros((rows.size, len(contacts)))
    for number, each in depths.items():
        every[:, number] = each
    force = normal_forces(contacts, every) * sliding(contacts, speeds[rows])
    free, pushed = response.free[rows], response.flexibility[rows] * force[:, np.newaxis]
    radii = every + np.array([each.clearance for each in contacts])
    matrix = pushed[:, touching][:, :, touching] + np.eye(touching.size) * radii[:, touching, None]
    directions = np.linalg.solve(matrix, free[:, touching, np.newaxis])
    directions /= np.abs(directions)
    displacement = free - (pushed[:, :, touching] @ directions)[:, :, 0]
    displacement[:, touching] = radii[:, touching] * directions[:, :, 0]
    return Whirls(rows, every, displacement)
