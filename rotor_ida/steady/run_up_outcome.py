"""One of many run-ups: its events on the ramp, and its final response.

run the rotor along the ramp;
summarise it: the largest radius and force, touches and exits, and their speeds;
keep the last speed and follow the rotor to its steady state, as a sweep does;
classify its ending: contact-free, in a rub, or in dry whip.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import COMPONENTS, State
from rotor_ida.model.disc_starts import begun
from rotor_ida.model.equations import rotated
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.results.contact_facts import run_up_facts
from rotor_ida.schema import ENDING, RESPONSE
from rotor_ida.simulation.course import ramp_of
from rotor_ida.simulation.dataset import arrays_of
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import ENTRY, Orbit
from rotor_ida.simulation.run import run
from rotor_ida.simulation.spin import Ramp, SpeedProfile
from rotor_ida.steady.follow import FAILED, durations, follow_to_steady_state
from rotor_ida.steady.grid import EXPECTED, Rows, reason_of
from rotor_ida.steady.members import Member, row_of
from rotor_ida.steady.response import CONTACT_FREE, TOUCHING, UNRESOLVED, Features

RUB, WHIP = "rub", "whip"
# What requires friction, or contact damping.
ONLY_WITH = {
    "friction": ("first_roll_speed", "total_heat"),
    "contact_damping": ("total_contact_loss",),
}
SUMMARY = (
    "largest_radius", "largest_radius_speed", "largest_force", "largest_force_speed",
    "first_touch_speed", "last_exit_speed", "first_roll_speed", "contact_count", "contact_time",
    "total_heat", "total_contact_loss", "end_angle", *(f"end_{name}" for name in COMPONENTS),
)  # fmt: skip

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


@dataclass(frozen=True, slots=True)
class Outcome:
    """The ending of a run-up.

    Parameters
    ----------
    ending : str
        ``"contact_free"``, ``"rub"``, ``"whip"``, ``"unresolved"`` or ``"failed"``.
    response : str
        The kind of the settled response at the last speed, or ``"failed"``.
    features : Features
        The features of the settled motion.
    message : str
        The reason of a failure, or what an unresolved ending was tried with; else empty.
    """

    ending: str
    response: str
    features: Features = field(default_factory=Features)
    message: str = ""


def follow_run_up(job: Member, stop: Stop) -> Rows:
    """Follow a rotor along its ramp, and on at the last speed until it has settled."""
    at, case = job.varied, job.case
    summary: dict[str, float] = {}
    rotor = Rotor(**{name: at[name] for name in ALL_PARAMETERS if name in at})
    run_up = RunUp(
        rotor=rotor, to=case["to"], rate=at["rate"], phase=at["phase"],
        start=begun(case["start"], rotor, at["phase"]), options=case["options"],
    )  # fmt: skip
    try:
        course = run_up.course
        orbit = run(
            rotor, run_up.start, course.ends[-1], np.array([0.0, course.ends[-1]]),
            run_up.options, extrema=True, stop=stop, profile=course,
        )  # fmt: skip
        summary = summary_of(orbit, run_up)
        last = replace(rotor, omega=run_up.to)
        ended = ending_at(last, orbit.end, run_up.end_angle, run_up.options, stop)
    except EXPECTED as error:  # it must not end the others
        ended = failed(reason_of(error))
    numbers = {"ending": ENDING[ended.ending], "response": RESPONSE[ended.response]}
    return row_of(
        job, summary | asdict(ended.features) | numbers, ended.message,
        failed=ended.response == FAILED,
    )  # fmt: skip


def failed(reason: str) -> Outcome:
    """Return the ending of a run-up that failed."""
    return Outcome(FAILED, FAILED, message=reason)


def summary_of(orbit: Orbit, run_up: RunUp) -> dict[str, float]:
    """Return what happens on a ramp: `SUMMARY`; the speed of what does not occur is NaN."""
    columns = arrays_of(orbit)
    if orbit.extrema is not None:
        columns |= {f"extremum_{name}": orbit.extrema[name] for name in ("time", "radius")}
    facts = run_up_facts(columns, orbit.rotor.delta0) | {"end_angle": run_up.end_angle}
    return facts | {f"end_{name}": each for name, each in zip(COMPONENTS, orbit.end, strict=True)}


def ending_at(
    rotor: Rotor,
    end: Values,
    angle: float,
    options: Options,
    stop: Stop,
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
    """
    state = on_rotating_axes(rotor, end, angle, options, stop)
    settled = follow_to_steady_state(rotor, state, options, stop=stop)
    if settled.response == FAILED:
        return failed(settled.message)
    if settled.response in {CONTACT_FREE, TOUCHING}:
        ending = CONTACT_FREE
    elif whips(rotor, settled.end, options, stop):
        ending = WHIP
    else:
        ending = UNRESOLVED if settled.response == UNRESOLVED else RUB
    message = settled.message if ending == UNRESOLVED else ""
    return Outcome(ending, settled.response, settled.features, message)


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
