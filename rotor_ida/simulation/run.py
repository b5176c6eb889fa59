"""Run a rotor from a start: prepare the run, call the event loop, and check the result.

The loop is in ``core/events.c``; ``enum status`` of ``core/core.h`` lists how it may end, and
`rotor_ida.core.interface` says that in words. Afterwards `rotor_ida.simulation.invariants` may
still refuse the result.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import State
from rotor_ida.core.interface import DONE, IN_CONTACT, OUT_OF_STEPS, UNBALANCED, message_of
from rotor_ida.core.runs import RunRequest, RunResult, follow_run
from rotor_ida.errors import BudgetError, InstallationError, InvariantError, SimulationError
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.invariants import check_orbit
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import Orbit, SpeedRecord
from rotor_ida.simulation.spin import SpeedProfile

# Errors for the ends of a run in the core that are more than a failure of its solver.
OF_STATUS = {UNBALANCED: InvariantError, OUT_OF_STEPS: BudgetError}


def run(
    rotor: Rotor,
    start: State,
    duration: float,
    sample_times: Values,
    options: Options,
    *,
    slack: float = 0.0,
    scale: float = 1.0,
    extrema: bool = False,
    most_steps: int = 0,
    stop: Stop | None = None,
    profile: SpeedProfile | None = None,
    watch: Watch | None = None,
) -> Orbit:
    """Simulate a rotor from `start` at time 0 over `duration`.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : tuple of float
        ``(x, y, vx, vy)`` at time 0, fixed frame [dimensionless].
    duration : float
        Time to simulate [dimensionless], positive.
    sample_times : ndarray, shape (n,)
        Times to report [dimensionless], increasing, from 0 to `duration`.
    options : Options
        Method, tolerances, treatment of flight, and backend.
    slack : float
        How far after `duration` an event may lie and still belong to the run [dimensionless]. Its
        time is reported as it is.
    scale : float
        Factor on both tolerances.
    extrema : bool
        Whether the extrema of the radius are recorded; the reference records none.
    most_steps : int
        Number of steps that a run in compiled code may take, where a flight in closed form is one;
        0 for any number.
    stop : ndarray, shape (1,), optional
        Stops a run in compiled code as soon as it is not 0.
    profile : SpeedProfile, optional
        How the speed changes, if it does.
    watch : list of callable, optional
        Receives a function that returns the time reached by a run in compiled code [dimensionless].

    Raises
    ------
    SimulationError
        If the solver gives up, or the run was stopped.
    BudgetError
        If it needs more than `most_steps`.
    InvariantError
        If the result contradicts the mechanics.
    """
    tolerances = scale * options.step_rtol, scale * options.step_atol
    if options.backend == "python":
        orbit: Orbit = witness("disc")(
            rotor, start, duration, sample_times, options,
            tolerances=tolerances, slack=slack, stop=stop, profile=profile,
        )  # fmt: skip
        check_orbit(orbit)
        return orbit
    request = RunRequest(
        rotor=rotor,
        start=start if profile is None else _on_axes(start, profile.angle),
        duration=duration,
        rtol=tolerances[0],
        atol=tolerances[1],
        method=options.method,
        exact_flight=options.flight == "exact",
        slack=slack,
        sample_times=sample_times,
        fixed_axes=profile is None,
        pieces=None if profile is None else profile.pieces(),
        angle=0.0 if profile is None else profile.angle,
        events=True,
        extrema=extrema,
        most_steps=most_steps,
        stop=stop,
        watch=watch,
    )
    orbit = _compiled(request, sample_times, options, profile)
    check_orbit(orbit)
    return orbit


def witness(rotor: Literal["disc", "system"]) -> Callable[..., Any]:
    """Return the reference simulator of a rotor, or raise `InstallationError` without sundae."""
    try:
        from rotor_ida.simulation.witness.disc import run_reference  # noqa: PLC0415
        from rotor_ida.simulation.witness.system import run_system  # noqa: PLC0415
    except ImportError as error:
        raise InstallationError(
            "backend 'python' needs scikit-sundae: pip install scikit-sundae, or leave it out by "
            f"method='taylor' ({error})"
        ) from error
    return run_reference if rotor == "disc" else run_system


def _on_axes(state: State, angle: float) -> State:
    """Return a state read on axes that have turned by an angle."""
    if angle == 0.0:
        return state
    x, y, vx, vy = rotated(state, -angle).tolist()
    return x, y, vx, vy


def _compiled(
    request: RunRequest, sample_times: Values, options: Options, profile: SpeedProfile | None
) -> Orbit:
    """Return the orbit computed by the compiled core."""
    result = follow_run(request)
    if result.status != DONE:
        kind = OF_STATUS.get(result.status, SimulationError)
        state = (
            result.state
            if profile is None
            else _on_axes(result.state, -float(result.end_spin["angle"]))
        )
        raise kind(message_of(result.status), time=result.time, state=state)
    record = None if profile is None else _speed_record_of(result, request, profile)
    if record is not None:
        result = replace(
            result,
            samples=rotated(result.samples, record.samples["angle"]),
            event_states=rotated(result.event_states, record.events["angle"]),
            state=_on_axes(result.state, -float(record.end["angle"])),
        )
    return Orbit(
        rotor=request.rotor,
        options=options,
        duration=request.duration,
        times=sample_times,
        states=result.samples,
        starts_in_contact=result.began == IN_CONTACT,
        event_times=result.event_times,
        event_kinds=result.event_kinds,
        event_states=result.event_states,
        contacts=result.contacts,
        end=np.array(result.state),
        evaluations=result.evaluations,
        steps=result.steps,
        modes=result.modes,
        extrema=result.extrema if request.extrema else None,
        speed_record=record,
    )


def _speed_record_of(result: RunResult, request: RunRequest, profile: SpeedProfile) -> SpeedRecord:
    """Return how the speed changed: as prescribed, or as integrated by the core."""
    samples, events, end = result.sample_spins, result.event_spins, result.end_spin
    if not profile.is_driven:
        sampled = np.asarray(request.sample_times)[: len(samples)]
        ended = np.array([result.time])
        samples, events, end = (
            profile.spins_at(times, np.empty((times.size, 0)))
            for times in (sampled, result.event_times, ended)
        )
        end = end[0]
    return SpeedRecord(profile=profile, samples=samples, events=events, end=end, energies=None)
