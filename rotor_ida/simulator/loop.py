"""The event loop: from the start through flight and contact, event by event, to the end.

Between events the rotor's displacement and velocity are kept on the rotating axes, where the
motion does not depend on the time at which a phase begins.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import State
from rotor_ida.errors import SimulationError
from rotor_ida.parameters import Rotor
from rotor_ida.simulator import cartesian_phase, contact_phase, flight
from rotor_ida.simulator.invariants import check_orbit
from rotor_ida.simulator.options import Options
from rotor_ida.simulator.orbit import ENTRY, EXIT, Orbit
from rotor_ida.simulator.record import Record
from rotor_ida.simulator.solver import SolverFailure
from rotor_ida.simulator.start import contact_start, starts_in_contact

Values = npt.NDArray[np.float64]


def run(
    rotor: Rotor,
    start: State,
    duration: float,
    sample_times: Values,
    options: Options,
    *,
    slack: float = 0.0,
) -> Orbit:
    """Simulate a rotor from `start` at time 0 over `duration`.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : tuple of float
        ``(x, y, vx, vy)`` at time 0, fixed frame [1].
    duration : float
        Time to simulate [1], positive.
    sample_times : ndarray, shape (n,)
        Times to report [1], increasing, from 0 to `duration`.
    options : Options
        Method, tolerances and treatment of flight.
    slack : float
        How far behind `duration` an event may lie and still belong to the run [1]. It keeps
        its own time.

    Raises
    ------
    SimulationError
        If the solver gives up.
    InvariantError
        If the result contradicts the mechanics.
    """
    x, y, vx, vy = start
    record = Record(rotor, options, duration, slack, sample_times, complex(x, y), complex(vx, vy))
    in_contact = starts_in_contact(rotor, record.position, record.velocity)
    try:
        if rotor.delta0 == 0.0:
            _stay_in_contact(record)
        else:
            _go_from_event_to_event(record, in_contact)
    except SolverFailure as failure:
        raise SimulationError(
            failure.message, time=record.time, state=record.fixed_state()
        ) from failure
    orbit = record.orbit(starts_in_contact=in_contact)
    check_orbit(orbit)
    return orbit


def _go_from_event_to_event(record: Record, in_contact: bool) -> None:
    """Alternate flight and contact until the time is up."""
    if in_contact:
        _contact(record, entry=math.nan)
    while record.left > 0.0:
        fly = _exact_flight if record.options.flight == "exact" else _integrated_flight
        if fly(record):
            record.position *= record.rotor.delta0 / abs(record.position)
            record.mark(ENTRY)
            _contact(record, entry=record.time)


def _exact_flight(record: Record) -> bool:
    """Fly to the next touch, or to the end, in closed form; return whether it is a touch."""
    omega, zeta, delta0 = record.rotor.omega, record.rotor.zeta, record.rotor.delta0
    limit = record.left + record.slack
    touch = flight.first_touch(record.position, record.velocity, omega, zeta, delta0, limit)
    touched = touch <= limit
    span = touch if touched else record.left
    times = record.waiting(span)
    record.take(flight.fly_over(record.position, record.velocity, times, omega, zeta))
    record.move(span, *flight.fly(record.position, record.velocity, span, omega, zeta))
    return touched


def _integrated_flight(record: Record) -> bool:
    """Fly to the next touch, or to the end, with the solver; return whether it is a touch."""
    passage = _integrate(record)
    return passage.touched


def _stay_in_contact(record: Record) -> None:
    """Follow a rotor without clearance, which has no events, to the end."""
    passage = _integrate(record)
    x, y, vx, vy = passage.peak
    moment = float(x * vy - y * vx)
    record.add_contact(math.nan, math.nan, passage.peak_time, math.hypot(x, y), math.nan, moment)


def _integrate(record: Record) -> cartesian_phase.Passage:
    """Integrate displacement and velocity to a touch of the ring, or to the end."""
    times = record.waiting(record.left)
    try:
        passage = cartesian_phase.follow(
            record.rotor, np.array(record.state), record.left, record.slack, times, record.options
        )
    except SolverFailure as failure:
        x, y, vx, vy = failure.values.tolist()
        record.move(failure.point, complex(x, y), complex(vx, vy))
        raise
    record.evaluations += passage.evaluations
    record.take(passage.samples)
    x, y, vx, vy = passage.end.tolist()
    record.move(passage.time, complex(x, y), complex(vx, vy))
    return passage


def _contact(record: Record, entry: float) -> None:
    """Follow one contact, write its row, and mark its exit if it has one."""
    began = record.time
    if record.left <= 0.0:
        moment = (record.position.conjugate() * record.velocity).imag
        record.add_contact(entry, math.nan, began, 0.0, math.nan, moment)
        return
    times = record.waiting(record.left)
    start = contact_start(record.rotor, record.position, record.velocity, record.left)
    try:
        contact = contact_phase.follow_contact(
            record.rotor, start, record.left, record.slack, times, record.options
        )
    except SolverFailure as failure:
        _move_to(record, failure.values)
        raise
    record.evaluations += contact.evaluations
    record.take(contact_phase.cartesian(contact.samples, record.rotor.delta0))
    _move_to(record, contact.end)
    if contact.left:
        record.mark(EXIT)
    root, _, moment, _, _, until_peak, _ = contact.peak.tolist()
    whole = contact.left and not math.isnan(entry)
    record.add_contact(
        entry,
        record.time if contact.left else math.nan,
        min(began + until_peak, record.time),
        root**2,
        float(contact.end[contact_phase.J]) if whole else math.nan,
        moment,
    )


def _move_to(record: Record, state: Values) -> None:
    """Go on to a regularised state, which lies on the ring to the last digit where q is 0."""
    x, y, vx, vy = contact_phase.cartesian(state, record.rotor.delta0).tolist()
    record.move(float(state[contact_phase.T]), complex(x, y), complex(vx, vy))
