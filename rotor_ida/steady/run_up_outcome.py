"""One of many run-ups: its events on the ramp, and its final response.

run the rotor along the ramp;
summarise it: the largest radius and force, touches and exits, and their speeds;
keep the last speed and follow the rotor to its steady state, as a sweep does;
classify its ending: contact-free, in a rub, or in dry whip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import State
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.contact_table import peak_forces
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import ENTRY, EXIT, ROLL, ROLLS, Orbit
from rotor_ida.simulation.run import run
from rotor_ida.simulation.run_up import ramp_of
from rotor_ida.simulation.spin import Ramp, SpeedProfile
from rotor_ida.steady.follow import FAILED, durations, follow_to_steady_state
from rotor_ida.steady.grid import EXPECTED, reason_of
from rotor_ida.steady.response import CONTACT_FREE, TOUCHING, UNRESOLVED, Features

RUB, WHIP = "rub", "whip"

_NO_TIMES = np.empty(0)


@dataclass(frozen=True, slots=True)
class RunUp:
    """A ramp of the speed, with everything a worker needs to simulate it.

    Parameters
    ----------
    rotor : Rotor
        The rotor: its ``omega`` is the speed at time 0.
    to, rate : float
        The speed at the end of the ramp, and its change per unit time [1].
    phase : float
        Angle of the unbalance at time 0 [rad].
    start : tuple of float
        ``(x, y, vx, vy)`` at time 0, fixed frame [1].
    options : Options
        How to simulate.
    """

    rotor: Rotor
    to: float
    rate: float
    phase: float
    start: State
    options: Options

    @property
    def course(self) -> SpeedProfile:
        """The profile of the speed, beginning at the phase of the unbalance."""
        course = ramp_of(self.rotor, self.to, self.rate)
        (ramp,) = course.spins
        assert isinstance(ramp, Ramp)
        return replace(course, spins=(replace(ramp, angle=self.phase),))

    @property
    def end_angle(self) -> float:
        """Angle of the unbalance at the end of the ramp [rad]."""
        mean = 0.5 * (self.rotor.omega + self.to)
        return self.phase + mean * (self.to - self.rotor.omega) / self.rate

    def speed_at(self, time: float) -> float:
        """Return the speed at a time on the ramp [1]."""
        return self.rotor.omega + self.rate * time


@dataclass(frozen=True, slots=True)
class RampSummary:
    """The events of a ramp; the speed of an event that did not occur is NaN.

    Parameters
    ----------
    largest_radius, largest_radius_speed : float
        Largest distance from the bearing axis, and the speed there [1].
    largest_force, largest_force_speed : float
        Largest normal force, and the speed at the largest indentation of that contact [1].
    first_touch_speed, last_exit_speed, first_roll_speed : float
        Speeds at the first entry (the first speed if the start is in contact), at the last exit,
        and where the disc first rolls on the stator [1].
    contact_count, contact_time : float
        Number of contacts and time spent in them [1].
    total_heat, total_contact_loss : float
        The heat of sliding, and the energy lost to contact damping [1].
    end_angle : float
        Angle of the unbalance at the end of the ramp [rad].
    end_x, end_y, end_vx, end_vy : float
        State there, fixed frame [1].
    """

    largest_radius: float = math.nan
    largest_radius_speed: float = math.nan
    largest_force: float = math.nan
    largest_force_speed: float = math.nan
    first_touch_speed: float = math.nan
    last_exit_speed: float = math.nan
    first_roll_speed: float = math.nan
    contact_count: int = 0
    contact_time: float = math.nan
    total_heat: float = math.nan
    total_contact_loss: float = math.nan
    end_angle: float = math.nan
    end_x: float = math.nan
    end_y: float = math.nan
    end_vx: float = math.nan
    end_vy: float = math.nan


@dataclass(frozen=True, slots=True)
class Outcome:
    """The ending of a run-up.

    Parameters
    ----------
    ending : str
        ``"contact_free"``, ``"rub"``, ``"whip"``, ``"unresolved"`` or ``"failed"``.
    response : str
        The kind of the settled response at the last speed, or ``"failed"``.
    summary : RampSummary
        The events of the ramp.
    features : Features
        The features of the settled motion.
    message : str
        The reason of a failure, or what an unresolved ending was tried with; else empty.
    """

    ending: str
    response: str
    summary: RampSummary = field(default_factory=RampSummary)
    features: Features = field(default_factory=Features)
    message: str = ""


def follow_run_up(run_up: RunUp, stop: Stop) -> Outcome:
    """Follow a rotor along its ramp, and on at the last speed until it has settled."""
    summary = RampSummary()
    try:
        course = run_up.course
        orbit = run(
            run_up.rotor, run_up.start, course.ends[-1], _NO_TIMES, run_up.options,
            extrema=True, stop=stop, profile=course,
        )  # fmt: skip
        summary = summary_of(orbit, run_up)
        return _settled(run_up, orbit, summary, stop)
    except EXPECTED as error:  # it must not end the others
        return failed(reason_of(error), summary)


def failed(reason: str, summary: RampSummary | None = None) -> Outcome:
    """Return a run-up that failed, with its summary until then."""
    return Outcome(FAILED, FAILED, summary or RampSummary(), message=reason)


def lost(_: RunUp, reason: str) -> Outcome:
    """Return a run-up whose workers died."""
    return failed(reason)


def summary_of(orbit: Orbit, run_up: RunUp) -> RampSummary:
    """Return the summary of a ramp."""
    omega, rotor = run_up.rotor.omega, run_up.rotor

    def speed_of(event: int, which: int) -> float:
        times = orbit.event_times[orbit.event_kinds == event]
        return run_up.speed_at(float(times[which])) if times.size else math.nan

    contacts, forces = orbit.contacts, peak_forces(orbit)
    hardest = int(forces.argmax()) if forces.size else -1
    entry = np.nan_to_num(contacts["entry"], nan=0.0)
    leaving = np.nan_to_num(contacts["exit"], nan=orbit.duration)
    peak_time = float(contacts["peak_time"][hardest]) if forces.size else math.nan
    farthest, radius = _farthest(orbit, run_up.start)
    rolls_at_once = orbit.ways is not None and orbit.ways[0] == ROLLS
    x, y, vx, vy = orbit.end.tolist()
    return RampSummary(
        largest_radius=radius,
        largest_radius_speed=run_up.speed_at(farthest),
        largest_force=float(forces[hardest]) if forces.size else 0.0,
        largest_force_speed=run_up.speed_at(peak_time),
        first_touch_speed=omega if orbit.starts_in_contact else speed_of(ENTRY, 0),
        last_exit_speed=speed_of(EXIT, -1),
        first_roll_speed=omega if rolls_at_once else speed_of(ROLL, 0),
        contact_count=len(contacts),
        contact_time=float((leaving - entry).sum()),
        total_heat=float(contacts["heat"].sum()) if rotor.friction > 0.0 else 0.0,
        total_contact_loss=float(contacts["lost"].sum()) if rotor.contact_damping > 0.0 else 0.0,
        end_angle=run_up.end_angle,
        end_x=x,
        end_y=y,
        end_vx=vx,
        end_vy=vy,
    )


def _farthest(orbit: Orbit, start: State) -> tuple[float, float]:
    """Return when the rotor is farthest from the axis, and how far."""
    x, y = orbit.end[:2].tolist()
    places = [(0.0, math.hypot(*start[:2])), (orbit.duration, math.hypot(x, y))]
    if len(orbit.contacts):
        deepest = orbit.contacts[orbit.contacts["peak_indentation"].argmax()]
        places.append((deepest["peak_time"], orbit.rotor.delta0 + deepest["peak_indentation"]))
    elif orbit.extrema is not None and len(orbit.extrema):
        farthest = orbit.extrema[orbit.extrema["radius"].argmax()]
        places.append((farthest["time"], farthest["radius"]))
    time, radius = max(places, key=lambda place: place[1])
    return float(time), float(radius)


def _settled(run_up: RunUp, orbit: Orbit, summary: RampSummary, stop: Stop) -> Outcome:
    """Return the settled outcome at the last speed."""
    rotor = replace(run_up.rotor, omega=run_up.to)
    return ending_at(rotor, orbit.end, run_up.end_angle, run_up.options, stop, summary)


def ending_at(
    rotor: Rotor,
    end: Values,
    angle: float,
    options: Options,
    stop: Stop,
    summary: RampSummary | None = None,
) -> Outcome:
    """Return how a run-up ends: the settled response at the constant last speed.

    Parameters
    ----------
    rotor : Rotor
        The rotor at its last speed.
    end : ndarray, shape (4,)
        Its state at the end of the run-up, fixed frame [1].
    angle : float
        Angle of the unbalance there [rad].
    options, stop
        How to simulate.
    summary : RampSummary, optional
        The summary of the ramp, for the outcome.
    """
    summary = summary or RampSummary()
    state = on_rotating_axes(rotor, end, angle, options, stop)
    settled = follow_to_steady_state(rotor, state, options, stop=stop)
    if settled.response == FAILED:
        return failed(settled.message, summary)
    if settled.response in {CONTACT_FREE, TOUCHING}:
        ending = CONTACT_FREE
    elif whips(rotor, settled.end, options, stop):
        ending = WHIP
    else:
        ending = UNRESOLVED if settled.response == UNRESOLVED else RUB
    message = settled.message if ending == UNRESOLVED else ""
    return Outcome(ending, settled.response, summary, settled.features, message)


def on_rotating_axes(
    rotor: Rotor, end: Values, angle: float, options: Options, stop: Stop
) -> State:
    """Return the state at the end of a ramp, or soon after, on axes along the unbalance.

    Under a load these must point along the fixed axes: the last speed is kept until they do.
    """
    if rotor.omega == 0.0:  # at rest the unbalance has no force
        angle = 0.0
    elif rotor.load > 0.0:
        time = (-angle) % math.tau / rotor.omega
        x, y, vx, vy = end.tolist()
        if time > 0.0:
            course = SpeedProfile((time,), (Ramp(0.0, angle, rotor.omega, 0.0),))
            end = run(
                rotor, (x, y, vx, vy), time, _NO_TIMES, options, stop=stop, profile=course
            ).end
        angle = 0.0
    x, y, vx, vy = rotated(end, np.float64(-angle)).tolist()
    return (x, y, vx, vy)


def whips(rotor: Rotor, state: State, options: Options, stop: Stop) -> bool:
    """Return whether a motion is dry whip: it whirls backwards, and stays in contact.

    The disc rolls or, if the unbalance is too strong, alternately slides both ways.
    """
    if rotor.friction == 0.0 or rotor.omega == 0.0:
        return False
    _, length, samples = durations(rotor)
    times = np.linspace(0.0, length, samples)
    orbit = run(rotor, state, length, times, options, stop=stop)
    x, y, vx, vy = orbit.states.T
    leaves = bool((np.abs(orbit.event_kinds) == ENTRY).any())
    return orbit.starts_in_contact and not leaves and bool((x * vy - y * vx).max() < 0.0)
