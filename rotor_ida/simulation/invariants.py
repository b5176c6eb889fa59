"""What a run must not contradict, the laws of contact and its energy: else it raises an error."""

from __future__ import annotations

import math

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.core.faults import FAULTS, FIRST_OF_SAMPLES, OF_CONTACTS, fault_of
from rotor_ida.core.library import why_missing
from rotor_ida.core.system_requests import SystemRequest, SystemResult
from rotor_ida.errors import InvariantError
from rotor_ida.model.assembly import Assembly, Canonical
from rotor_ida.schema.flags import ENTRY, OF_FRICTION, ROLLS, SLIDES_BACKWARDS, SLIDES_FORWARDS
from rotor_ida.simulation.orbit import Orbit, SpeedRecord

# Allowed imbalance of energy of a run whose speed changes, in tolerances per radian.
UNBALANCED_BY = 1e2
# Allowed distance of a sample on the wrong side of the stator, in tolerances.
WRONG_SIDE = 1e3
# Forces beyond their limits, in parts of their size: rounding, and what the tolerance allows.
ROUNDED, OF_TOLERANCE = 1e-9, 30.0


# ---- Of one disc ----


def check_orbit(orbit: Orbit) -> None:
    """Raise `InvariantError` at the first contradiction of an orbit to the mechanics.

    The core finds it: without one, an orbit by the reference is not checked.
    """
    if why_missing():
        return
    options = orbit.options
    allowed = WRONG_SIDE * (options.rtol * orbit.rotor.delta0 + options.atol)
    kept = slice(None) if orbit.speed_record is None else ~np.isin(orbit.event_kinds, OF_FRICTION)
    event_times, event_states = orbit.event_times[kept], orbit.event_states[kept]
    fault, row = fault_of(
        orbit.rotor,
        (orbit.times, orbit.states),
        (event_times, orbit.event_kinds[kept], event_states),
        orbit.contacts,
        began=orbit.starts_in_contact,
        allowed=allowed,
        modes=orbit.modes if orbit.speed_record is None else None,
    )
    if fault:
        time, state = event_times, event_states
        if fault == OF_CONTACTS:
            time, state = orbit.contacts["peak_time"], np.tile(orbit.end, (len(orbit.contacts), 1))
        elif fault >= FIRST_OF_SAMPLES:
            time, state = orbit.times, orbit.states
        x, y, vx, vy = state[row].tolist()
        raise InvariantError(FAULTS[fault], time=float(time[row]), state=(x, y, vx, vy))
    if orbit.speed_record is not None:
        _check_speed_record(orbit, orbit.speed_record, allowed)


def _check_speed_record(orbit: Orbit, record: SpeedRecord, allowed: float) -> None:
    """Raise `InvariantError` where energy does not balance, or the sense of sliding is wrong."""
    if record.energies is not None:
        _check_energies(orbit, record, record.energies)
    if orbit.modes is None:
        return
    speed = np.hypot(orbit.states[:, 2], orbit.states[:, 3])
    rim = (orbit.rotor.disc_radius or 0.0) * record.samples["speed"]
    more = allowed * (1.0 + (speed + rim) / orbit.rotor.delta0)
    radius = np.maximum(np.hypot(orbit.states[:, 0], orbit.states[:, 1]), np.finfo(float).tiny)
    across = orbit.states[:, 0] * orbit.states[:, 3] - orbit.states[:, 1] * orbit.states[:, 2]
    slip = across / radius + rim
    modes = orbit.modes[np.searchsorted(orbit.event_times, orbit.times, side="right")]
    slides = np.isin(modes, (SLIDES_FORWARDS, SLIDES_BACKWARDS))
    astray = slides & (modes * slip < -more)
    for wrong, fault in ((astray, 8), ((modes == ROLLS) & (np.abs(slip) > more), 9)):
        if wrong.any():
            row = int(np.argmax(wrong))
            x, y, vx, vy = orbit.states[row].tolist()
            raise InvariantError(FAULTS[fault], time=float(orbit.times[row]), state=(x, y, vx, vy))


def _check_energies(
    orbit: Orbit, record: SpeedRecord, energies: tuple[float, float, float]
) -> None:
    """Raise `InvariantError` where energy does not balance."""
    x, y, vx, vy = orbit.end.tolist()
    begun, ended, gained = energies
    size = 1.0 + max(abs(begun), abs(ended), abs(gained))
    revolved = 1.0 + float(record.end["angle"])
    most = UNBALANCED_BY * (orbit.options.rtol + orbit.options.atol) * size * revolved
    if not abs(ended - begun - gained) <= most:
        raise InvariantError(
            f"the energy does not balance: it changed by {ended - begun:.9g}, and "
            f"{gained:.9g} was given",
            time=orbit.duration,
            state=(x, y, vx, vy),
        )


# ---- Of a rotor system ----


def check_system_orbit(
    assembly: Assembly, found: Canonical, request: SystemRequest, result: SystemResult, rtol: float
) -> None:
    """Raise an error where a run contradicts the mechanics.

    The tolerance `rtol` is that of the run, the tolerance of the request that of each step.
    """
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
    if not math.isnan(result.ledger["unbalance"]):  # the plain-Python reference keeps none
        _check_energy(found, request, result)


def _check_energy(found: Canonical, request: SystemRequest, result: SystemResult) -> None:
    """Compare the energy at both ends with what was gained and lost in between.

    Each step may be wrong by its tolerance, in parts of the state or of the clearance: the energy,
    by this part of all that was turned over, or of the velocity times that of the scale. The errors
    of all steps add up at most. In 2,400 runs of random systems by CVODE they came to 0.41 of
    that, in 1,200 by Taylor series to 0.02.
    """
    start = request.start
    spent = result.ledger
    kept = energy_of(found, result.state) - energy_of(found, start)
    lost = sum(each for name, each in spent.items() if name != "unbalance")
    size = size_of_energy(found, np.concatenate([start[np.newaxis], result.samples]))
    turnover = size + sum(map(abs, spent.values()))
    slight = math.sqrt(turnover) * request.velocity
    allowed = ROUNDED + result.steps * request.rtol
    if not abs(kept - spent["unbalance"] + lost) <= allowed * max(turnover, slight):
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
