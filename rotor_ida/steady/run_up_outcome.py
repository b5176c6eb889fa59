"""One of many run-ups, of one disc or of a rotor system: the ramp, and the final response.

run the rotor along the ramp;
summarise it: the largest radius and force, touches and exits, and their speeds;
keep the last speed and follow the rotor to its steady state, as a sweep does;
classify its ending: contact-free, in a rub, or in dry whip.
"""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import COMPONENTS, State
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import assemble
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.results.contact_facts import columns_of_contact, run_up_facts
from rotor_ida.schema import ENDING, RESPONSE
from rotor_ida.simulation.course import SYSTEM_LIMITS, course_of, ramp_of
from rotor_ida.simulation.dataset import arrays_of
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.run import run
from rotor_ida.simulation.runs import run_of_cases
from rotor_ida.simulation.spin import Ramp, SpeedProfile
from rotor_ida.simulation.starts import GivenStart, Start, start_of
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow
from rotor_ida.steady.decision import Decision
from rotor_ida.steady.drop import with_unbalance_at
from rotor_ida.steady.follow import settle_disc, settle_system
from rotor_ida.steady.grid import EXPECTED, Answer, reason_of
from rotor_ida.steady.points import figures_of, point_of
from rotor_ida.steady.response import CONTACT_FREE, TOUCHING, UNRESOLVED, stays_backward

RUB, WHIP = "rub", "whip"
# What requires friction, or contact damping.
ONLY_WITH = {
    "friction": ("first_roll_speed", "total_heat"),
    "contact_damping": ("total_contact_loss",),
}
# What is known of the ramp: of a rotor system by contact, and of one disc.
OF_RAMP = (
    "largest_radius", "largest_radius_speed", "largest_force", "largest_force_speed",
    "first_touch_speed", "last_exit_speed", "first_roll_speed", "contact_time", "total_heat",
    "total_contact_loss",
)  # fmt: skip
SUMMARY = (*OF_RAMP, "contact_count", "end_angle", *(f"end_{name}" for name in COMPONENTS))

_NO_TIMES = np.empty(0)


class RunUp(NamedTuple):
    """A ramp of the speed of a rotor.

    Parameters
    ----------
    rotor : Rotor or RotorSystem
        The rotor.
    speed, to, rate : float
        The speed at time 0 and at the end of the ramp, and its change per unit time
        [dimensionless].
    phase : float
        Angle of the unbalance at time 0 [rad].
    """

    rotor: Rotor | RotorSystem
    speed: float
    to: float
    rate: float
    phase: float

    @property
    def course(self) -> SpeedProfile:
        """The profile of the speed, beginning at the phase of the unbalance."""
        assert isinstance(self.rotor, Rotor)
        course = ramp_of(self.rotor, self.to, self.rate)
        (ramp,) = course.spins
        assert isinstance(ramp, Ramp)
        return replace(course, spins=(replace(ramp, angle=self.phase),))

    @property
    def end_angle(self) -> float:
        """Angle of the unbalance at the end of the ramp [rad]."""
        mean = 0.5 * (self.speed + self.to)
        return self.phase + mean * (self.to - self.speed) / self.rate


def ending_with(decision: Decision, *, whips: bool) -> tuple[dict[str, int], str]:
    """Return ending and response by what the last speed settles on, and why it is unresolved.

    In whip a contact with friction whirls backwards and stays closed: it rolls or, if the unbalance
    is too strong, alternately slides both ways.
    """
    kind = decision.kind
    if kind in {CONTACT_FREE, TOUCHING}:
        ending = CONTACT_FREE
    elif whips:
        ending = WHIP
    else:
        ending = UNRESOLVED if kind == UNRESOLVED else RUB
    message = decision.message if ending == UNRESOLVED else ""
    return {"ending": ENDING[ending], "response": RESPONSE[kind]}, message


# ---- Of one disc ----


def follow_run_up(options: Options, run_up: RunUp, start: GivenStart, stop: Stop) -> Answer:
    """Follow one disc along its ramp, and on at the last speed until it has settled."""
    rotor, course, facts = run_up.rotor, run_up.course, dict[str, float]()
    assert isinstance(rotor, Rotor)
    state = start_of(rotor, start, phase=run_up.phase)
    try:
        orbit = run(
            rotor, state, course.ends[-1], np.array([0.0, course.ends[-1]]), options,
            extrema=True, stop=stop, profile=course,
        )  # fmt: skip
        facts = summary_of(orbit, run_up)
        last = replace(rotor, omega=run_up.to)
        figures, message = ending_at(last, orbit.end, run_up.end_angle, options, stop)
    except EXPECTED as error:  # it must not end the others
        return Answer(facts, reason_of(error), failed=True)
    return Answer(facts | figures, message)


def summary_of(orbit: Orbit, run_up: RunUp) -> dict[str, float]:
    """Return what happens on a ramp: `SUMMARY`; the speed of what does not occur is NaN."""
    columns = arrays_of(orbit)
    if orbit.extrema is not None:
        columns |= {f"extremum_{name}": orbit.extrema[name] for name in ("time", "radius")}
    facts = run_up_facts(columns, orbit.rotor.delta0) | {"end_angle": run_up.end_angle}
    return facts | {f"end_{name}": each for name, each in zip(COMPONENTS, orbit.end, strict=True)}


def ending_at(
    rotor: Rotor, end: Values, angle: float, options: Options, stop: Stop
) -> tuple[dict[str, Any], str]:
    """Return the settled response at the constant last speed and the ending, with a message.

    Parameters
    ----------
    rotor : Rotor
        The rotor at its last speed.
    end : ndarray, shape (4,)
        Its state at the end of the run-up, fixed frame [dimensionless].
    angle : float
        Angle of the unbalance there [rad].
    options, stop
        How to simulate.
    """
    state = on_rotating_axes(rotor, end, angle, options, stop)
    settled = settle_disc(rotor, state, options, stop=stop)
    whips = rotor.friction > 0.0 < rotor.omega and stays_backward(settled.motion.window, 0)
    ending, message = ending_with(settled.decision, whips=whips)
    return asdict(settled.features) | ending, message


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


# ---- Of a rotor system ----


def columns_of(problem: SettlingProblem) -> np.dtype[np.void]:
    """Return the columns of a system's run-up: those of the settled response, and of the ramp."""
    contacts, nodes = len(problem.assembly.contacts), len(problem.assembly.system.nodes)
    settled = [each for each in point_of(problem).descr if each[0] not in ("touched", *OF_RAMP)]
    return np.dtype([
        *settled, ("ending", np.int8), ("end_angle", np.float64), ("horizon", np.float64),
        *((name, np.float64, (contacts,)) for name in OF_RAMP),
        ("contact_count", np.int64, (contacts,)), ("node_largest_radius", np.float64, (nodes,)),
    ])  # fmt: skip


def follow_system_run_up(rtol: float, run_up: RunUp, start: Start, stop: Stop) -> Answer:
    """Follow a rotor system along its ramp, and on at the last speed until it has settled."""
    assert isinstance(run_up.rotor, RotorSystem)
    ramp = {"to": run_up.to, "rate": run_up.rate}
    course = course_of(run_up.speed, ramp, None, SYSTEM_LIMITS)
    facts: dict[str, Any] = {}
    try:
        system = with_unbalance_at(run_up.rotor, run_up.phase)
        run = run_of_cases(
            [(system, start)], course, samples=None, rtol=rtol, method="taylor", progress=None,
            modes={},
        )  # fmt: skip
        facts = _facts(run, run_up.phase)
        figures, message = settled_system(system, run, run_up.to, run_up.phase, rtol, stop)
    except (*EXPECTED, InputError) as error:  # it must not end the others
        return Answer(facts, reason_of(error), failed=True)
    return Answer(figures | facts, message)


def facts_of_contacts(run: xr.Dataset) -> list[dict[str, float]]:
    """Return what happens on a ramp at each contact."""
    return [
        run_up_facts(columns_of_contact(run, number), float(clearance))
        for number, clearance in enumerate(run["clearance"].values)
    ]


def _facts(run: xr.Dataset, phase: float) -> dict[str, Any]:
    """Return what happens on a ramp."""
    contacts = facts_of_contacts(run)
    return {
        **{name: [each[name] for each in contacts] for name in (*OF_RAMP, "contact_count")},
        "node_largest_radius": np.hypot(run["x"].values, run["y"].values).max(axis=0),
        "end_angle": float(run["angle"][-1]) + phase,
        "horizon": float(run["horizon"]),
        "final_state": run["final_state"].values,
    }


def settled_system(
    system: RotorSystem, run: xr.Dataset, to: float, phase: float, rtol: float, stop: Stop
) -> tuple[dict[str, Any], str]:
    """Return the settled response at the last speed and the ending, with a message.

    The motion goes on with the unbalance ahead by the angle to which the ramp has brought it.
    """
    if to == 0.0:
        raise InputError("no settled response of a rotor system is computed at standstill")
    angle = math.remainder(float(run["angle"][-1]), math.tau)
    problem = SettlingProblem.of(assemble(with_unbalance_at(system, angle)), rtol)
    flow = SystemFlow.at(problem, to, stop)
    settled = settle_system(flow, flow.given_state(run["final_state"].values))
    features, turn = settled.features, np.exp(-1j * (angle + phase))
    whirls = {name: turn * getattr(features, name) for name in ("contact_whirl", "node_whirl")}
    turned = replace(settled, features=replace(features, **whirls))
    rubs = np.array([each.friction > 0.0 for each in problem.assembly.contacts], bool)
    ending, message = ending_with(settled.decision, whips=bool((rubs & features.backward).any()))
    return figures_of(turned, flow) | ending, message
