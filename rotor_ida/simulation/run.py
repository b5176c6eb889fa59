"""Run a rotor from a start: make ready, let the event loop go, and check what came of it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import State
from rotor_ida.equations.compiling import compiled, release, shared
from rotor_ida.equations.model import rotating_field_into, rotating_jacobian_into
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
from rotor_ida.simulation.taylor.motion import open_taylor

Values = npt.NDArray[np.float64]

# The arguments of `new_record`.
Given = tuple[float, float, float, float, float, bool, Values, float, float, Values, Stop]


def run(
    rotor: Rotor,
    start: State,
    duration: float,
    sample_times: Values,
    options: Options,
    *,
    slack: float = 0.0,
    scale: float = 1.0,
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
    scale : float
        Factor on both tolerances.
    stop : ndarray, shape (1,), optional
        Asks a run in compiled code to stop as soon as it holds anything but 0.

    Raises
    ------
    SimulationError
        If the solver gives up, or the run was asked to stop.
    InvariantError
        If the result contradicts the mechanics.
    """
    asked = np.zeros(1, np.uint8) if stop is None else stop
    parameters = (rotor.omega, rotor.zeta, rotor.delta0)
    how = (scale * options.step_rtol, scale * options.step_atol, options.flight == "exact")
    given = (*parameters, *how, np.array(start), duration, slack, sample_times, asked)
    if options.method == "taylor":
        follow = _by_taylor_series_compiled if options.backend == "compiled" else _by_taylor_series
        status, seen = follow(given)
        message = message_of(status)
    elif options.backend == "compiled":
        fields = np.array([field.address for field in callbacks()])
        status, seen = _in_compiled_code(
            given, np.array(parameters), METHODS[options.method], fields
        )
        message = message_of(status)
    else:
        status, message, seen = _in_python(given, options)
    if status != GOES_ON:
        x, y, vx, vy = seen[1].tolist()
        raise SimulationError(message, time=seen[0], state=(x, y, vx, vy))
    _time, end, states, event_times, event_kinds, event_states, contacts, evaluations = seen
    here, moving = complex(start[0], start[1]), complex(start[2], start[3])
    orbit = Orbit(
        rotor=rotor,
        options=options,
        duration=duration,
        times=sample_times,
        states=states,
        starts_in_contact=starts_in_contact(here, moving, rotor.omega, rotor.zeta, rotor.delta0),
        event_times=event_times,
        event_kinds=event_kinds,
        event_states=event_states,
        contacts=contacts,
        end=end,
        evaluations=evaluations,
    )
    check_orbit(orbit)
    return orbit


def _in_python(given: Given, options: Options) -> tuple[int, str, RunResult]:
    """Run the event loop in Python, over scikit-sundae's public interface."""
    omega, zeta, delta0 = given[:3]

    def in_contact(state: Values, rate: Values) -> None:
        contact_field(state, rate, omega, zeta, delta0)

    def anywhere(state: Values, rate: Values) -> None:
        rotating_field_into(state, rate, omega, zeta, delta0)

    def derivative(state: Values, matrix: Values) -> None:
        rotating_jacobian_into(state, matrix, omega, zeta, delta0)

    record = new_record(*given)
    contact = Integration(options.method, given[3], in_contact)
    free = Integration(options.method, given[3], anywhere, derivative)
    status = run_events(record, contact, free)
    return status, contact.message or free.message or message_of(status), result(record)


@compiled
def _in_compiled_code(
    given: Given, parameters: Values, method: int, fields: npt.NDArray[np.int64]
) -> tuple[int, RunResult]:
    """Run the event loop in compiled code, over the SUNDIALS libraries themselves."""
    record, rtol = new_record(*given), given[3]
    contact = open_direct(contact_phase.SIZE, method, rtol, parameters, fields[0], 0)
    free = open_direct(cartesian_phase.SIZE, method, rtol, parameters, fields[1], fields[2])
    status = run_events(record, contact, free)
    found = result(record)
    close_direct(contact)
    close_direct(free)
    release(record)
    return status, found


@shared
def _by_taylor_series(given: Given) -> tuple[int, RunResult]:
    """Run the event loop over Taylor series."""
    record, (omega, zeta, delta0, rtol) = new_record(*given), given[:4]
    contact = open_taylor(omega, zeta, delta0, True, rtol, False)
    free = open_taylor(omega, zeta, delta0, False, rtol, False)
    status = run_events(record, contact, free)
    found = result(record)
    release(contact)
    release(free)
    release(record)
    return status, found


_by_taylor_series_compiled = compiled(_by_taylor_series)
