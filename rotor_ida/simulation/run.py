"""Run a rotor from a start: make ready, let the event loop go, and check what came of it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import State
from rotor_ida.equations.compiling import compiled
from rotor_ida.equations.model import rotated, rotating_field_into, rotating_jacobian_into
from rotor_ida.errors import SimulationError
from rotor_ida.parallel.jobs import Stop
from rotor_ida.parameters import Rotor
from rotor_ida.simulation import cartesian_phase, contact_phase
from rotor_ida.simulation.contact_phase import contact_field
from rotor_ida.simulation.cvode.compiled import METHODS, close_direct, open_direct
from rotor_ida.simulation.cvode.interface import callbacks
from rotor_ida.simulation.cvode.python import Integration
from rotor_ida.simulation.loop import run_events
from rotor_ida.simulation.motion import GOES_ON, message_of
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import Orbit, check_orbit
from rotor_ida.simulation.record import RunResult, new_record, result
from rotor_ida.simulation.start import starts_in_contact

Values = npt.NDArray[np.float64]


def run(
    rotor: Rotor,
    start: State,
    duration: float,
    sample_times: Values,
    options: Options,
    *,
    slack: float = 0.0,
    stop: Stop | None = None,
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
        Method, tolerances, treatment of flight, and backend.
    slack : float
        How far behind `duration` an event may lie and still belong to the run [1]. It keeps
        its own time.
    stop : ndarray, shape (1,), optional
        Asks a run in compiled code to stop as soon as it holds anything but 0.

    Raises
    ------
    SimulationError
        If the solver gives up, or the run was asked to stop.
    InvariantError
        If the result contradicts the mechanics.
    """
    way = _in_compiled_code if options.backend == "compiled" else _in_python
    status, message, seen = way(
        rotor,
        np.array(start),
        duration,
        sample_times,
        options,
        slack,
        np.zeros(1, np.uint8) if stop is None else stop,
    )
    omega = rotor.omega
    if status != GOES_ON:
        x, y, vx, vy = rotated(seen[1], omega * seen[0]).tolist()
        raise SimulationError(message, time=seen[0], state=(x, y, vx, vy))
    time, end, states, event_times, event_kinds, event_states, contacts, evaluations = seen
    here, moving = complex(start[0], start[1]), complex(start[2], start[3])
    orbit = Orbit(
        rotor=rotor,
        options=options,
        duration=duration,
        times=sample_times,
        states=rotated(states, omega * sample_times),
        starts_in_contact=starts_in_contact(here, moving, omega, rotor.zeta, rotor.delta0),
        event_times=event_times,
        event_kinds=event_kinds,
        event_states=rotated(event_states, omega * event_times),
        contacts=contacts,
        end=rotated(end, omega * time),
        evaluations=evaluations,
    )
    check_orbit(orbit)
    return orbit


def _in_python(
    rotor: Rotor,
    start: Values,
    duration: float,
    sample_times: Values,
    options: Options,
    slack: float,
    stop: Stop,
) -> tuple[int, str, RunResult]:
    """Run the event loop in Python, over scikit-sundae's public interface."""
    omega, zeta, delta0 = rotor.omega, rotor.zeta, rotor.delta0

    def in_contact(state: Values, rate: Values) -> None:
        contact_field(state, rate, omega, zeta, delta0)

    def anywhere(state: Values, rate: Values) -> None:
        rotating_field_into(state, rate, omega, zeta, delta0)

    def derivative(state: Values, matrix: Values) -> None:
        rotating_jacobian_into(state, matrix, omega, zeta, delta0)

    record = new_record(
        omega,
        zeta,
        delta0,
        options.step_rtol,
        options.step_atol,
        options.flight == "exact",
        start,
        duration,
        slack,
        sample_times,
        stop,
    )
    contact, free = Integration(options, in_contact), Integration(options, anywhere, derivative)
    status = run_events(record, contact, free)
    return status, contact.message or free.message or message_of(status), result(record)


def _in_compiled_code(
    rotor: Rotor,
    start: Values,
    duration: float,
    sample_times: Values,
    options: Options,
    slack: float,
    stop: Stop,
) -> tuple[int, str, RunResult]:
    """Run the event loop in compiled code, over the SUNDIALS libraries themselves."""
    status, seen = _run_compiled(
        np.array([rotor.omega, rotor.zeta, rotor.delta0]),
        options.step_rtol,
        options.step_atol,
        options.flight == "exact",
        METHODS[options.method],
        start,
        duration,
        slack,
        sample_times,
        stop,
        np.array([field.address for field in callbacks()]),
    )
    return status, message_of(status), seen


@compiled
def _run_compiled(
    parameters: Values,
    rtol: float,
    atol: float,
    exact: bool,
    method: int,
    start: Values,
    duration: float,
    slack: float,
    sample_times: Values,
    stop: Stop,
    fields: npt.NDArray[np.int64],
) -> tuple[int, RunResult]:
    omega, zeta, delta0 = parameters
    record = new_record(
        omega, zeta, delta0, rtol, atol, exact, start, duration, slack, sample_times, stop
    )
    contact = open_direct(contact_phase.SIZE, method, rtol, parameters, fields[0], 0)
    free = open_direct(cartesian_phase.SIZE, method, rtol, parameters, fields[1], fields[2])
    status = run_events(record, contact, free)
    close_direct(contact)
    close_direct(free)
    return status, result(record)
