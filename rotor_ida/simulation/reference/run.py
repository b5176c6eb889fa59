"""Run a rotor from a start in plain Python, over scikit-sundae's public interface."""

from __future__ import annotations

import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import State
from rotor_ida.core.interface import DONE, message_of
from rotor_ida.core.runs import NO_STOP, Stop
from rotor_ida.equations.model import rotating_jacobian
from rotor_ida.equations.modes import cartesian_rates, contact_rates
from rotor_ida.equations.symbols import variables
from rotor_ida.errors import SimulationError
from rotor_ida.parameters import PARAMETERS, Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.reference.integration import Integration
from rotor_ida.simulation.reference.loop import run_events
from rotor_ida.simulation.reference.record import new_record, result
from rotor_ida.simulation.reference.start import starts_in_contact

Values = npt.NDArray[np.float64]


def run_reference(
    rotor: Rotor,
    start: State,
    duration: float,
    sample_times: Values,
    options: Options,
    *,
    tolerances: tuple[float, float],
    slack: float,
    stop: Stop | None,
) -> Orbit:
    """Do as `rotor_ida.simulation.run.run` does, tolerances of a step given."""
    rtol, atol = tolerances
    felt = 1.0 if rotor.delta0 == 0.0 else 0.0
    flying = replace(rotor, delta0=sys.float_info.max)  # the ring is out of reach
    seen = SimpleNamespace(**{name: getattr(rotor, name) for name in PARAMETERS}, felt=felt)

    def in_contact(state: Values, rate: Values) -> None:
        rate[:] = contact_rates(state.tolist(), seen)

    def slopes_in_contact(state: Values, matrix: Values) -> None:
        matrix[:] = [rate.parts for rate in contact_rates(variables(state.tolist()), seen)]

    def anywhere(state: Values, rate: Values) -> None:
        rate[:] = cartesian_rates(state.tolist(), seen)

    def slopes_anywhere(state: Values, matrix: Values) -> None:
        matrix[:] = rotating_jacobian(state, rotor if felt else flying)

    record = new_record(
        rotor.omega, rotor.zeta, rotor.delta0, rtol, atol, options.flight == "exact",
        np.array(start), duration, slack, sample_times, NO_STOP if stop is None else stop,
    )  # fmt: skip
    contact = Integration(options.method, rtol, in_contact, slopes_in_contact)
    free = Integration(options.method, rtol, anywhere, slopes_anywhere)
    status = run_events(record, contact, free)
    time, end, states, event_times, event_kinds, event_states, contacts, count = result(record)
    if status != DONE:
        message = contact.message or free.message or message_of(status)
        x, y, vx, vy = end.tolist()
        raise SimulationError(message, time=time, state=(x, y, vx, vy))
    here, moving = complex(start[0], start[1]), complex(start[2], start[3])
    return Orbit(
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
        evaluations=count,
    )
