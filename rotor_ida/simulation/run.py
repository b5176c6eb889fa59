"""Run a rotor from a start: make ready, let the event loop go, and check what came of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import State
from rotor_ida.core.interface import (
    DONE,
    ENTRY_TIME,
    EXIT_TIME,
    IMPULSE,
    IN_CONTACT,
    PEAK_ROOT,
    UNBALANCED,
    message_of,
)
from rotor_ida.core.runs import Asked, Seen, follow
from rotor_ida.errors import InstallationError, InvariantError, SimulationError
from rotor_ida.model.equations import rotated
from rotor_ida.model.parameters import Rotor
from rotor_ida.parallel.jobs import Stop
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import Orbit, Turning, check_orbit
from rotor_ida.simulation.spin import Course


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
    stop: Stop | None = None,
    course: Course | None = None,
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
    extrema : bool
        Whether the extrema of the radius are recorded; the reference records none.
    stop : ndarray, shape (1,), optional
        Asks a run in compiled code to stop as soon as it holds anything but 0.
    course : Course, optional
        How the speed changes, if it does.

    Raises
    ------
    SimulationError
        If the solver gives up, or the run was asked to stop.
    InvariantError
        If the result contradicts the mechanics.
    """
    tolerances = scale * options.step_rtol, scale * options.step_atol
    if options.backend == "python":
        orbit = reference()(
            rotor, start, duration, sample_times, options,
            tolerances=tolerances, slack=slack, stop=stop, course=course,
        )  # fmt: skip
        check_orbit(orbit)
        return orbit
    asked = Asked(
        rotor=rotor,
        start=start if course is None else _on_axes(start, course.angle),
        duration=duration,
        rtol=tolerances[0],
        atol=tolerances[1],
        method=options.method,
        exact_flight=options.flight == "exact",
        slack=slack,
        sample_times=sample_times,
        fixed_axes=course is None,
        pieces=None if course is None else course.pieces(),
        angle=0.0 if course is None else course.angle,
        events=True,
        extrema=extrema,
        stop=stop,
    )
    orbit = _compiled(asked, sample_times, options, course)
    check_orbit(orbit)
    return orbit


def reference() -> Callable[..., Orbit]:
    """Return the reference, which needs its solver."""
    try:
        from rotor_ida.simulation.reference import run_reference  # noqa: PLC0415
    except ImportError as error:
        raise InstallationError(
            f"backend 'python' needs scikit-sundae: pip install scikit-sundae ({error})"
        ) from error
    return run_reference


def _on_axes(state: State, angle: float) -> State:
    """Return a state read on axes that have turned by an angle."""
    if angle == 0.0:
        return state
    x, y, vx, vy = rotated(state, -angle).tolist()
    return x, y, vx, vy


def _compiled(asked: Asked, sample_times: Values, options: Options, course: Course | None) -> Orbit:
    """Return an orbit of the compiled core."""
    seen = follow(asked)
    if seen.status != DONE:
        kind = InvariantError if seen.status == UNBALANCED else SimulationError
        state = seen.state if course is None else _on_axes(seen.state, -seen.turn[0])
        raise kind(message_of(seen.status), time=seen.time, state=state)
    turning = None if course is None else _turning_of(seen, asked, course)
    if turning is not None:
        seen = replace(
            seen,
            samples=rotated(seen.samples, turning.samples[:, 0]),
            event_states=rotated(seen.event_states, turning.events[:, 0]),
            state=_on_axes(seen.state, -float(turning.end[0])),
        )
    return Orbit(
        rotor=asked.rotor,
        options=options,
        duration=asked.duration,
        times=sample_times,
        states=seen.samples,
        starts_in_contact=seen.began == IN_CONTACT,
        event_times=seen.event_times,
        event_kinds=seen.event_kinds,
        event_states=seen.event_states,
        contacts=_contacts_of(seen.contacts, asked.rotor),
        end=np.array(seen.state),
        evaluations=seen.evaluations,
        ways=seen.ways,
        extrema=seen.extrema if asked.extrema else None,
        turning=turning,
    )


def _turning_of(seen: Seen, asked: Asked, course: Course) -> Turning:
    """Return how the speed changed: as prescribed, or as the core has integrated it."""
    samples, events, end = seen.sample_turns, seen.event_turns, np.array(seen.turn)
    if not course.is_driven:
        sampled = np.asarray(asked.sample_times)[: len(samples)]
        ended = np.array([seen.time])
        samples, events, end = (
            course.tell(times, np.empty((times.size, 0)))
            for times in (sampled, seen.event_times, ended)
        )
        end = end[0]
    return Turning(course=course, samples=samples, events=events, end=end, energies=None)


def _contacts_of(rows: Values, rotor: Rotor) -> Values:
    """Return contacts by their largest indentation; the impulse of whole ones alone is known."""
    contacts = rows.copy()
    contacts[:, PEAK_ROOT] = rows[:, PEAK_ROOT] ** 2
    if rotor.delta0 > 0.0:
        whole = np.isfinite(rows[:, ENTRY_TIME] + rows[:, EXIT_TIME])
        contacts[~whole, IMPULSE] = np.nan
    return contacts
