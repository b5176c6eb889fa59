"""At which speeds a rotor system would touch its stators, and why whirls are not drawn, in words.

Without contact the motion is linear: the static deflection and an ellipse at each contact. Where it
would exceed a clearance, no motion without contact exists.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.clearances.critical_speeds import orbit_axes
from rotor_ida.closed_forms.receptances import solved_motions
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly
from rotor_ida.model.axisymmetric import forward_motions
from rotor_ida.model.system_parts import Contact, Stator
from rotor_ida.simulation.starts import settled
from rotor_ida.units import quantity

# Points of a revolution among which the largest distance from a stator is found, to 4e-5 of it.
POINTS = 360
Band = tuple[float, float]


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


def touching_bands(assembly: Assembly, speeds: Values) -> list[list[Band]]:
    """Return for each contact the bands of speeds in which the rotor cannot be clear of it."""
    gaps = beyond(assembly, speeds)

    def bands_of(number: int) -> list[Band]:
        def excess(speed: float) -> float:
            return float(beyond(assembly, np.array([speed]))[0, number])

        points = dict(zip(speeds.tolist(), gaps[:, number].tolist(), strict=True))
        own = gaps[:, number]
        inner = (own[1:-1] <= 0.0) & (own[1:-1] >= own[:-2]) & (own[1:-1] >= own[2:])
        for place in (np.flatnonzero(inner) + 1).tolist():
            peak = minimize_scalar(
                lambda speed: -excess(speed), method="bounded",
                bounds=(speeds[place - 1], speeds[place + 1]),
            )  # fmt: skip
            points[float(peak.x)] = -float(peak.fun)
        found: list[Band] = []
        places = sorted(points)
        begin = places[0] if points[places[0]] > 0.0 else None
        for low, high in pairwise(places):
            if (points[low] > 0.0) == (points[high] > 0.0):
                continue
            edge = float(brentq(excess, low, high))
            if begin is None:
                begin = edge
            else:
                found.append((begin, edge))
                begin = None
        return found if begin is None else [*found, (begin, places[-1])]

    return [bands_of(number) for number in range(len(assembly.contacts))]


def clear_whirl(assembly: Assembly, node: int, speeds: Values) -> Values:
    """Return the largest radius of a node about its mean place; NaN where a contact is reached."""
    force = assembly.unbalance[0] - 1j * assembly.unbalance[1]
    rows = assembly.node_rows()[node : node + 1]
    axes = orbit_axes(assembly, rows, force[:, np.newaxis], speeds)[0, :, 0]
    touches = (beyond(assembly, speeds) > 0.0).any(axis=1)
    return np.where(touches, np.nan, 0.5 * axes)


def bands_in_words(assembly: Assembly, speeds: Values) -> str:
    """Return in a sentence at which speeds the rotor, held there, cannot be clear of contacts."""
    si = assembly.system.units == "SI"
    top = quantity(float(speeds[-1]), "rad/s" if si else "1")
    parts = []
    for number, bands in enumerate(touching_bands(assembly, speeds)):
        ranges = [_range(band, speeds, si=si) for band in bands]
        if ranges:
            parts.append(f"{titled(number, assembly.contacts[number].node)} {' and '.join(ranges)}")
    if not parts:
        return f"At every speed up to {top} it can whirl without contact."
    return f"Held elsewhere it touches {', '.join(parts)}; a rub that began there may go on beyond."


def _range(band: Band, speeds: Values, *, si: bool) -> str:
    """Return a band in words; its ends may be those of the speeds considered."""
    low, high = (quantity(each, "rad/s" if si else "1") for each in band)
    if band[1] >= speeds[-1]:
        return f"at all speeds up to {high}" if band[0] <= speeds[0] else f"from {low} on"
    return f"up to {high}" if band[0] <= speeds[0] else f"from {low.removesuffix(' rpm')} to {high}"


def titled(number: int, node: str) -> str:
    """Return the name of a contact."""
    return f"contact {number} ({'node ' * node.isdecimal()}{node})"


def why_without_whirls(assembly: Assembly, error: InputError) -> str:
    """Return in words of the page why the exact whirls of a system are refused."""
    for number, each in enumerate(assembly.contacts):
        reason = _reason(titled(number, each.node), each)
        if reason:
            return reason
    try:
        forward_motions(assembly)
    except InputError:
        return "the rotor or its supports are not the same in all directions"
    return str(error)


def _reason(name: str, contact: Contact) -> str:
    """Return what a contact has that the exact whirls do not know; empty if nothing."""
    if contact.centre != (0.0, 0.0):
        return f"the stator of {name} is off the axis"
    if contact.spinning_race is not None and contact.friction > 0.0:
        return f"the race of {name} is spun by friction"
    stator = contact.stator
    if not isinstance(stator, Stator):
        return ""
    if stator.mass == 0.0:
        return f"the stator of {name} has no mass"
    if any(np.ptp(each) > 0.0 for each in (stator.stiffness, stator.damping)):
        return f"the stator of {name} is not held alike along x and y"
    return ""
