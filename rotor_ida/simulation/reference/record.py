"""A run in the making: its present state, and its samples, events and contacts so far.

`Record` is filled by the event loop.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.model import rotated
from rotor_ida.parallel.jobs import Stop

Values = npt.NDArray[np.float64]
Kinds = npt.NDArray[np.int8]

# Time, state, samples, events' times, kinds and states, contacts, evaluations.
RunResult = tuple[float, Values, Values, Values, Kinds, Values, Values, int]

FIRST_ROOM = 64


@dataclass(slots=True)
class Record:
    """The present state of a run, and what has been recorded of it.

    Position, velocity, samples and event states are read on the rotating axes. The tables grow
    as they fill; only their first `sampled`, `events` and `contacts` rows are part of the run.

    Parameters
    ----------
    omega, zeta, delta0 : float
        The rotor [1].
    rtol, atol : float
        Tolerances of one step of the solver [1].
    exact : bool
        Whether flight is solved in closed form.
    duration, slack : float
        Time to simulate, and how far behind it an event may lie [1].
    position, velocity : complex
        Present displacement and velocity [1].
    time : float
        Present time [1].
    sample_times : ndarray, shape (n,)
        Times to report [1].
    states : ndarray, shape (n, 4)
        ``(x, y, vx, vy)`` at those times [1].
    event_times, event_kinds, event_states : ndarray
        The events [1].
    contact_rows : ndarray, shape (k, 6)
        Entry, exit and peak time, peak indentation, impulse, angular momentum at the peak [1].
    next_time : float
        First sample time that has not been reported; infinite if none is left [1].
    sampled, events, contacts, evaluations : int
        Their numbers so far.
    stop : ndarray, shape (1,)
        Anything but 0 asks the run to stop.
    """

    omega: float
    zeta: float
    delta0: float
    rtol: float
    atol: float
    exact: bool
    duration: float
    slack: float
    position: complex
    velocity: complex
    time: float
    sample_times: Values
    states: Values
    event_times: Values
    event_kinds: Kinds
    event_states: Values
    contact_rows: Values
    next_time: float
    sampled: int
    events: int
    contacts: int
    evaluations: int
    stop: Stop


def new_record(
    omega: float,
    zeta: float,
    delta0: float,
    rtol: float,
    atol: float,
    exact: bool,
    start: Values,
    duration: float,
    slack: float,
    sample_times: Values,
    stop: Stop,
) -> Record:
    """Return the record of a run that is about to begin."""
    states = np.empty((sample_times.size, 4))
    return Record(
        omega,
        zeta,
        delta0,
        rtol,
        atol,
        exact,
        duration,
        slack,
        complex(start[0], start[1]),
        complex(start[2], start[3]),
        0.0,
        sample_times,
        states,
        np.empty(FIRST_ROOM),
        np.empty(FIRST_ROOM, np.int8),
        np.empty((FIRST_ROOM, 4)),
        np.empty((FIRST_ROOM, 6)),
        sample_times[0] if sample_times.size else math.inf,
        0,
        0,
        0,
        0,
        stop,
    )


def time_left(record: Record) -> float:
    """Return the time from now to the end of the run."""
    return record.duration - record.time


def next_sample(record: Record, span: float) -> float:
    """Return the next sample time, counted from now and clipped to the next `span`.

    It is infinite where none is left, or none lies within `span`.
    """
    # time + left may fall short of the duration by rounding; its sample must not be lost.
    until = record.duration if span >= time_left(record) else record.time + span
    if record.next_time > until:
        return math.inf
    return min(max(record.next_time - record.time, 0.0), span)


def record_sample(record: Record, x: float, y: float, vx: float, vy: float) -> None:
    """Add the next sample."""
    row = record.states[record.sampled]
    row[0], row[1], row[2], row[3] = x, y, vx, vy
    samples_done(record, record.sampled + 1)


def samples_done(record: Record, number: int) -> None:
    """Say that so many samples have been taken."""
    record.sampled = number
    more = number < record.sample_times.size
    record.next_time = record.sample_times[number] if more else math.inf


def advance(record: Record, span: float, position: complex, velocity: complex) -> None:
    """Advance the time by `span`, to a new position and velocity."""
    record.time = record.duration if span == time_left(record) else record.time + span
    record.position = position
    record.velocity = velocity


def record_event(record: Record, kind: int) -> None:
    """Add an event at the present time and state."""
    here = record.events
    if here == record.event_times.size:
        record.event_times = np.concatenate((record.event_times, np.empty_like(record.event_times)))
        record.event_kinds = np.concatenate((record.event_kinds, np.empty_like(record.event_kinds)))
        record.event_states = np.concatenate(
            (record.event_states, np.empty_like(record.event_states))
        )
    record.event_times[here] = record.time
    record.event_kinds[here] = kind
    row = record.event_states[here]
    row[0], row[1] = record.position.real, record.position.imag
    row[2], row[3] = record.velocity.real, record.velocity.imag
    record.events = here + 1


def add_contact(
    record: Record,
    entry: float,
    leaving: float,
    peak_time: float,
    indentation: float,
    impulse: float,
    moment: float,
) -> None:
    """Add a contact that is over, or in which the run begins or ends."""
    here = record.contacts
    if here == record.contact_rows.shape[0]:
        record.contact_rows = np.concatenate(
            (record.contact_rows, np.empty_like(record.contact_rows))
        )
    row = record.contact_rows[here]
    row[0], row[1], row[2] = entry, leaving, peak_time
    row[3], row[4], row[5] = indentation, impulse, moment
    record.contacts = here + 1


def result(record: Record) -> RunResult:
    """Return the result of a run, every state in the fixed frame."""
    omega, events = record.omega, record.events
    here, moving = record.position, record.velocity
    end = np.array([[here.real, here.imag, moving.real, moving.imag]])
    event_times, event_states = record.event_times[:events], record.event_states[:events]
    end = rotated(end, omega * record.time)
    states = rotated(record.states, omega * record.sample_times)
    event_states = rotated(event_states, omega * event_times)
    return (
        record.time,
        end[0],
        states,
        event_times.copy(),
        record.event_kinds[:events].copy(),
        event_states.copy(),
        record.contact_rows[: record.contacts].copy(),
        record.evaluations,
    )
