"""One passage through a range of speeds: what a rotor meets on a ramp, and what it ends on.

run the rotor along the ramp;
measure what it met: the largest radius and force, touches and exits, and at which speeds;
hold the last speed and follow it to its steady state, as a sweep does;
say how it has ended: off the ring, in a rub, or in dry whip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import State
from rotor_ida.errors import SimulationError
from rotor_ida.model.equations import rotated
from rotor_ida.model.parameters import Rotor
from rotor_ida.parallel import Stop
from rotor_ida.simulation.contact_table import peak_forces
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import ENTRY, EXIT, ROLL, ROLLS, Orbit
from rotor_ida.simulation.run import run
from rotor_ida.simulation.run_up import ramp_of
from rotor_ida.simulation.spin import Ramp, SpeedProfile
from rotor_ida.steady.follow import FAILED, durations, follow_to_steady_state
from rotor_ida.steady.ramps import EXPECTED
from rotor_ida.steady.response import CONTACT_FREE, TOUCHING, UNRESOLVED, Features

RUB, WHIP = "rub", "whip"
TURN = 2.0 * math.pi

_NO_TIMES = np.empty(0)


@dataclass(frozen=True, slots=True)
class Passage:
    """A ramp of the speed, with all that a worker needs to follow a rotor along it.

    Parameters
    ----------
    rotor : Rotor
        The rotor: its ``omega`` is the speed at time 0.
    to, rate : float
        The speed at the end of the ramp, and its change in a unit of time [1].
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


@dataclass(frozen=True, slots=True)
class Met:
    """What a rotor meets on a ramp; speeds are NaN where there is nothing to tell one of.

    Parameters
    ----------
    largest_radius, largest_radius_speed : float
        Largest distance from the bearing axis, and the speed there [1].
    largest_force, largest_force_speed : float
        Largest normal force, and the speed at the largest indentation of that contact [1].
    first_touch_speed, last_exit_speed, first_roll_speed : float
        Speeds at the first entry, that at the start for one who starts in contact; at the last
        exit; and where the disc first rolls on the ring [1].
    contact_count, contact_time : float
        Number of contacts and time spent in them [1].
    total_heat, total_contact_loss : float
        What sliding has turned into heat, and what contact damping has taken [1].
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
class Passed:
    """How a rotor has passed through its speeds.

    Parameters
    ----------
    ending : str
        ``"contact_free"``, ``"rub"``, ``"whip"``, ``"unresolved"`` or ``"failed"``.
    response : str
        The kind of response that it settles on at the last speed, or ``"failed"``.
    met : Met
        What it met on the way.
    features : Features
        The motion that it settles on.
    message : str
        Why it failed; empty if it did not.
    """

    ending: str
    response: str
    met: Met = field(default_factory=Met)
    features: Features = field(default_factory=Features)
    message: str = ""


def pass_through(passage: Passage, stop: Stop) -> Passed:
    """Follow a rotor along its ramp, and on at the last speed until it has settled."""
    met = Met()
    try:
        course = course_of(passage)
        orbit = run(
            passage.rotor, passage.start, course.ends[-1], _NO_TIMES, passage.options,
            extrema=True, stop=stop, profile=course,
        )  # fmt: skip
        met = met_on(orbit, passage)
        return _settled(passage, orbit, met, stop)
    except EXPECTED as error:  # it must not end the others
        if isinstance(error, SimulationError):
            return failed(str(error), met)
        return failed(f"{type(error).__name__}: {error}".rstrip(": "), met)


def course_of(passage: Passage) -> SpeedProfile:
    """Return how the speed changes, from the phase of the unbalance on."""
    course = ramp_of(passage.rotor, passage.to, passage.rate)
    (ramp,) = course.spins
    assert isinstance(ramp, Ramp)
    return replace(course, spins=(replace(ramp, angle=passage.phase),))


def failed(reason: str, met: Met | None = None) -> Passed:
    """Return a passage that failed, with what was met until then."""
    return Passed(FAILED, FAILED, met or Met(), message=reason)


def lost(_: Passage, reason: str) -> Passed:
    """Return the passage of a rotor whose workers died."""
    return failed(reason)


def met_on(orbit: Orbit, passage: Passage) -> Met:
    """Return what a rotor met on its way along a ramp."""
    omega, rotor = passage.rotor.omega, passage.rotor

    def speed_at(time: float) -> float:
        return omega + passage.rate * time

    def speed_of(event: int, which: int) -> float:
        times = orbit.event_times[orbit.event_kinds == event]
        return speed_at(float(times[which])) if times.size else math.nan

    contacts, forces = orbit.contacts, peak_forces(orbit)
    hardest = int(forces.argmax()) if forces.size else -1
    entry = np.nan_to_num(contacts["entry"], nan=0.0)
    leaving = np.nan_to_num(contacts["exit"], nan=orbit.duration)
    peak_time = float(contacts["peak_time"][hardest]) if forces.size else math.nan
    farthest, radius = _farthest(orbit, passage.start)
    rolls_at_once = orbit.ways is not None and orbit.ways[0] == ROLLS
    x, y, vx, vy = orbit.end.tolist()
    return Met(
        largest_radius=radius,
        largest_radius_speed=speed_at(farthest),
        largest_force=float(forces[hardest]) if forces.size else 0.0,
        largest_force_speed=speed_at(peak_time),
        first_touch_speed=omega if orbit.starts_in_contact else speed_of(ENTRY, 0),
        last_exit_speed=speed_of(EXIT, -1),
        first_roll_speed=omega if rolls_at_once else speed_of(ROLL, 0),
        contact_count=len(contacts),
        contact_time=float((leaving - entry).sum()),
        total_heat=float(contacts["heat"].sum()) if rotor.friction > 0.0 else 0.0,
        total_contact_loss=float(contacts["lost"].sum()) if rotor.contact_damping > 0.0 else 0.0,
        end_angle=end_angle(passage),
        end_x=x,
        end_y=y,
        end_vx=vx,
        end_vy=vy,
    )


def end_angle(passage: Passage) -> float:
    """Return the angle of the unbalance at the end of a ramp [rad]."""
    mean = 0.5 * (passage.rotor.omega + passage.to)
    return passage.phase + mean * (passage.to - passage.rotor.omega) / passage.rate


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


def _settled(passage: Passage, orbit: Orbit, met: Met, stop: Stop) -> Passed:
    """Return what a rotor settles on at the last speed."""
    rotor, options = replace(passage.rotor, omega=passage.to), passage.options
    state = _on_rotating_axes(passage, orbit.end, stop)
    found = follow_to_steady_state(rotor, state, options, stop=stop)
    if found.response == FAILED:
        return failed(found.message, met)
    free = found.response in {CONTACT_FREE, TOUCHING}
    if free:
        ending = CONTACT_FREE
    elif whips(rotor, found.end, options, stop):
        ending = WHIP
    else:
        ending = UNRESOLVED if found.response == UNRESOLVED else RUB
    return Passed(ending, found.response, met, found.features)


def _on_rotating_axes(passage: Passage, end: Values, stop: Stop) -> State:
    """Return the state at the end of a ramp, or soon after, on axes along the unbalance.

    Under a load these must point along the fixed ones: the speed is held until they do.
    """
    angle = end_angle(passage)
    if passage.to == 0.0:  # what does not turn pulls nowhere
        angle = 0.0
    elif passage.rotor.load > 0.0:
        left = (-angle) % TURN / passage.to
        held = replace(passage.rotor, omega=passage.to)
        x, y, vx, vy = end.tolist()
        if left > 0.0:
            course = SpeedProfile((left,), (Ramp(0.0, angle, passage.to, 0.0),))
            end = run(
                held, (x, y, vx, vy), left, _NO_TIMES, passage.options, stop=stop, profile=course
            ).end
        angle = 0.0
    x, y, vx, vy = rotated(end, np.float64(-angle)).tolist()
    return (x, y, vx, vy)


def whips(rotor: Rotor, state: State, options: Options, stop: Stop) -> bool:
    """Return whether a motion is dry whip: it whirls backwards, and stays in contact.

    The disc rolls or, where the unbalance is too strong for that, slides both ways by turns.
    """
    if rotor.friction == 0.0 or rotor.omega == 0.0:
        return False
    _, length, samples = durations(rotor)
    times = np.linspace(0.0, length, samples)
    orbit = run(rotor, state, length, times, options, stop=stop)
    x, y, vx, vy = orbit.states.T
    leaves = bool((np.abs(orbit.event_kinds) == ENTRY).any())
    return orbit.starts_in_contact and not leaves and bool((x * vy - y * vx).max() < 0.0)
