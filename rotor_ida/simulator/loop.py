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

Values = npt.NDArray[np.float64]

ROUNDING = 2.0**-52


def run(
    rotor: Rotor, start: State, duration: float, sample_times: Values, options: Options
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

    Raises
    ------
    SimulationError
        If the solver gives up.
    InvariantError
        If the result contradicts the mechanics.
    """
    x, y, vx, vy = start
    record = Record(rotor, options, duration, sample_times, complex(x, y), complex(vx, vy))
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


def starts_in_contact(rotor: Rotor, position: complex, velocity: complex) -> bool:
    """Decide the mode at a start.

    On the ring the radial velocity decides, and where that is zero the radial acceleration:
    outwards means contact; inwards, or none at all, means flight.
    """
    if rotor.delta0 == 0.0:
        return True
    radius = abs(position)
    if abs(radius - rotor.delta0) > 4.0 * ROUNDING * radius:
        return radius > rotor.delta0
    along = (position.conjugate() * velocity).real / radius
    if abs(along) > 4.0 * ROUNDING * abs(velocity):
        return along > 0.0
    return _radial_acceleration(rotor, position, velocity) > 0.0


def _radial_acceleration(rotor: Rotor, position: complex, velocity: complex) -> float:
    """Return r'' of a rotor at rest radially on the ring; 0 where rounding hides its sign."""
    direction = position / abs(position)
    centrifugal = (direction.conjugate() * velocity).imag ** 2 / abs(position)
    unbalance = rotor.omega**2
    total = centrifugal + unbalance * direction.real
    return total if abs(total) > 16.0 * ROUNDING * (centrifugal + unbalance) else 0.0


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
    span = min(touch, record.left)
    times = record.waiting(span)
    record.take(flight.fly_over(record.position, record.velocity, times, omega, zeta))
    record.move(span, *flight.fly(record.position, record.velocity, span, omega, zeta))
    return touch <= limit


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
    start = _contact_start(record)
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
        began + until_peak,
        root**2,
        float(contact.end[contact_phase.J]) if whole else math.nan,
        moment,
    )


def _move_to(record: Record, state: Values) -> None:
    """Go on to a regularised state, which lies on the ring to the last digit where q is 0."""
    x, y, vx, vy = contact_phase.cartesian(state, record.rotor.delta0).tolist()
    record.move(float(state[contact_phase.T]), complex(x, y), complex(vx, vy))


def _contact_start(record: Record) -> Values:
    """Return the regularised state at the start of a contact."""
    delta0 = record.rotor.delta0
    position, velocity = record.position, record.velocity
    depth = abs(position) - delta0
    root = math.sqrt(depth) if depth > 4.0 * ROUNDING * delta0 else 0.0
    state = contact_phase.regularised(position, velocity, root)
    if root == 0.0 and state[contact_phase.P] <= 4.0 * ROUNDING * abs(velocity):
        return _pushed_off(record, state)
    return state


def _pushed_off(record: Record, state: Values) -> Values:
    """Return the state a moment after a start at radial rest that is drawn outwards.

    q = p = 0 is an equilibrium of the regularised equations. The motion leaves it along
    ``q = sqrt(r''/2) t``, unhindered so far by a force that is of order t**3.
    """
    rotor = record.rotor
    outwards = _radial_acceleration(rotor, record.position, record.velocity)
    if outwards <= 0.0:
        return state
    moment = min(1e-8 * math.sqrt(rotor.delta0 / outwards), 1e-3 * record.left)
    position, velocity = flight.fly(
        record.position, record.velocity, moment, rotor.omega, rotor.zeta
    )
    pushed = contact_phase.regularised(position, velocity, math.sqrt(0.5 * outwards) * moment)
    pushed[contact_phase.P] = outwards * moment
    pushed[contact_phase.T] = moment
    return pushed
