"""The event loop: from the start through flight and contact, event by event, to the end.

Between events the rotor's displacement and velocity are kept on the rotating axes, where the
motion does not depend on the time at which a phase begins.
"""

from __future__ import annotations

import math

from rotor_ida.core.interface import DONE, STOPPED
from rotor_ida.simulation.orbit import ENTRY, EXIT
from rotor_ida.simulation.reference import flight
from rotor_ida.simulation.reference.cartesian_phase import follow
from rotor_ida.simulation.reference.contact_phase import H, J, Q, T, cartesian, follow_contact
from rotor_ida.simulation.reference.motion import Motion
from rotor_ida.simulation.reference.record import (
    Record,
    add_contact,
    advance,
    next_sample,
    record_event,
    record_sample,
    time_left,
)
from rotor_ida.simulation.reference.start import contact_start, starts_in_contact


def run_events(record: Record, contact: Motion, free: Motion) -> int:
    """Follow a run from its start to its end, and record its samples, events and contacts.

    Parameters
    ----------
    record : Record
        The run, at its start.
    contact, free : Motion
        Integrations of a contact in its regularised variables, and of any motion in displacement
        and velocity.

    Returns
    -------
    int
        0, or why the run ended early.
    """
    if record.next_time == 0.0:
        here, moving = record.position, record.velocity
        record_sample(record, here.real, here.imag, moving.real, moving.imag)
    if record.delta0 == 0.0:
        return _stay_in_contact(record, free)
    omega, zeta, delta0 = record.omega, record.zeta, record.delta0
    status = DONE
    if starts_in_contact(record.position, record.velocity, omega, zeta, delta0):
        status = _contact(record, contact, math.nan)
    while status == DONE and time_left(record) > 0.0:
        if record.exact:
            status, touched = _exact_flight(record)
        else:
            status, touched = _integrated_flight(record, free)
        if touched:
            record.position *= delta0 / abs(record.position)
            record_event(record, ENTRY)
            status = _contact(record, contact, record.time)
    return status


def _exact_flight(record: Record) -> tuple[int, bool]:
    """Fly to the next touch, or to the end, in closed form; return whether it is a touch."""
    omega, zeta, left = record.omega, record.zeta, time_left(record)
    here, moving, limit = record.position, record.velocity, left + record.slack
    touch = flight.first_touch(here, moving, omega, zeta, record.delta0, limit, record.stop)
    if record.stop[0]:
        return STOPPED, False
    touched = touch <= limit
    span = touch if touched else left
    while next_sample(record, span) <= span:
        there, then = flight.fly(here, moving, next_sample(record, span), omega, zeta)
        record_sample(record, there.real, there.imag, then.real, then.imag)
    there, then = flight.fly(here, moving, span, omega, zeta)
    advance(record, span, there, then)
    return DONE, touched


def _integrated_flight(record: Record, free: Motion) -> tuple[int, bool]:
    """Fly to the next touch, or to the end, with the solver; return whether it is a touch."""
    status, touched, time, end, _, _ = follow(record, free)
    advance(record, time, complex(end[0], end[1]), complex(end[2], end[3]))
    return status, touched and status == DONE


def _stay_in_contact(record: Record, free: Motion) -> int:
    """Follow a rotor without clearance, which has no events, to the end."""
    status, _, time, end, peak_time, peak = follow(record, free)
    advance(record, time, complex(end[0], end[1]), complex(end[2], end[3]))
    moment = float(peak[0] * peak[3] - peak[1] * peak[2])
    highest = math.hypot(peak[0], peak[1])
    add_contact(record, math.nan, math.nan, peak_time, highest, math.nan, moment)
    return status


def _contact(record: Record, contact: Motion, entry: float) -> int:
    """Follow one contact, record its exit if it has one, and add its row."""
    began, left = record.time, time_left(record)
    if left <= 0.0:
        moment = (record.position.conjugate() * record.velocity).imag
        add_contact(record, entry, math.nan, began, 0.0, math.nan, moment)
        return DONE
    omega, zeta, delta0 = record.omega, record.zeta, record.delta0
    start = contact_start(record.position, record.velocity, left, omega, zeta, delta0)
    status, leaves, end, peak = follow_contact(record, contact, start)
    there, moving = cartesian(end, delta0)
    advance(record, float(end[T]), there, moving)
    if status != DONE:
        return status
    if leaves:
        record_event(record, EXIT)
    whole = leaves and not math.isnan(entry)
    add_contact(
        record,
        entry,
        record.time if leaves else math.nan,
        min(began + float(peak[T]), record.time),
        float(peak[Q]) ** 2,
        float(end[J]) if whole else math.nan,
        float(peak[H]),
    )
    return DONE
