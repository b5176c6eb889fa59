"""The settled response at each point of a study over the speed and the parameters of a rotor."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import lru_cache, partial
from typing import Any, ClassVar, NamedTuple

import numpy as np
import xarray as xr

from rotor_ida.arrays import Column, Stop, Values
from rotor_ida.checks import AT_REST, COMPONENTS, check_between, check_distinct, shown
from rotor_ida.closed_forms.receptances import checked_speeds
from rotor_ida.core.runs import NO_STOP
from rotor_ida.errors import InputError, SimulationError, warn
from rotor_ida.model.assembly import assemble
from rotor_ida.model.equations import rotated
from rotor_ida.model.parameters import OF_ROTOR
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED, with_parameters
from rotor_ida.model.varied import Varied
from rotor_ida.results.archived_system import OF_CONTACTS
from rotor_ida.results.provenance import provenance
from rotor_ida.results.si_units import with_system_units
from rotor_ida.schema import RESPONSE
from rotor_ida.simulation.flow import DiscFlow, Flow
from rotor_ida.simulation.options import Options, check_can_be_followed, options_of_study
from rotor_ida.simulation.runs import LOOSEST_RTOL, TIGHTEST_RTOL
from rotor_ida.simulation.starts import (
    GivenStart,
    Start,
    begun_in_modes,
    start_of,
    start_of_system,
    states_of,
)
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow
from rotor_ida.steady.follow import (
    Features,
    Settled,
    SystemFeatures,
    settle_disc,
    settle_system,
)
from rotor_ida.steady.grid import Answer, Answers, Ramps
from rotor_ida.steady.response import CONTACT_FREE, SYNCHRONOUS

FEATURES = tuple(each.name for each in fields(Features))
# The columns of a sweep with a number for each point, and those with one for each event.
POINT = np.dtype(
    [
        ("response", np.int8),
        *((name, np.float64) for name in (*FEATURES, "window_start", "window_end")),
        ("status", np.int8),
        ("event_count", np.int64),
        *((name, np.float64) for name in ("end_x", "end_y", "end_vx", "end_vy")),
    ]
)
EVENT_STATES = ("event_x", "event_y", "event_vx", "event_vy")
EVENT = np.dtype(
    [
        ("event_time", np.float64),
        ("event_kind", np.int8),
        *((name, np.float64) for name in EVENT_STATES),
    ]
)
SETTLED = "settled"
# Largest rate of the system over the speed: a revolution takes a step for some five radians of it.
MOST_RATIO = 1e6
# Cost of a sweep: the cube of the degrees of freedom times the largest rate over the speed, of all
# points. What a core does of it in a minute, roughly, and from where on it is long.
WORK_A_MINUTE, LONG = 1.5e8, 1e8
# Modes that make it shorter: natural frequencies up to this multiple of the speed, and at least 16.
KEPT, FEWEST_MODES = 10.0, 16
# Problems that are held while ramps are laid out.
MOST_HELD = 8
OF_POINT = ("period", "cycle_distance", "lyapunov_exponent", "lyapunov_error", "revolutions")
OF_CONTACT = ("amplitude", "phase_lag", "radius_min", "radius_max", "largest_force")
OF_NODE = ("node_amplitude", "node_phase_lag", "node_radius_min", "node_radius_max")


class Turning(NamedTuple):
    """A rotor system at a speed."""

    problem: SettlingProblem
    speed: float


def turning_speeds(speed: object, where: str) -> Values:
    """Return spin speeds at which a system can be followed, each once."""
    speeds = checked_speeds(speed)
    if not speeds.all():
        raise InputError(f"speed must not be 0 {where}, got 0.0")
    return check_distinct(SPEED, speeds)


class Turnings:
    """The system and its speed at each place of a `Varied`; the last problems are held."""

    def __init__(self, varied: Varied, rtol: float) -> None:
        self.varied = varied

        @lru_cache(maxsize=MOST_HELD)
        def problem(*place: int) -> SettlingProblem:
            return SettlingProblem.of(assemble(varied.system_at(place)), rtol)

        self._problem = problem

    def at(self, place: Sequence[int]) -> Turning:
        """Return the system at a place, and its speed there."""
        index = zip(self.varied.dims, place, strict=True)
        same = (at if name in PARAMETERS_OF_SYSTEM else 0 for name, at in index)
        return Turning(self._problem(*same), float(self.varied.at(place)[SPEED]))

    def checked(self, speeds: Values | None = None) -> SettlingProblem:
        """Check the speeds at both ends of each parameter; return the problem with the largest.

        Without speeds they are those that vary.
        """
        speeds = np.atleast_1d(self.varied.given[SPEED]) if speeds is None else speeds
        self.varied.base.check_speeds(speeds)
        axes = self.varied.axes
        largest = {name: int(np.argmax(axis)) for name, axis in axes.items()}
        smallest = {name: int(np.argmin(axis)) for name, axis in axes.items()}
        found = []
        for ends in (largest, *(largest | {name: at} for name, at in smallest.items())):
            found.append(self.at(list(ends.values())).problem)
            check_slowest(found[-1], speeds)
        return found[0]


@dataclass(frozen=True, slots=True)
class VariedSystem:
    """A rotor system whose speed and parameters vary, in its modes, and its starts.

    Parameters
    ----------
    varied : Varied
        The points.
    starts, kept : list
        Starts in the coordinates of the modes, and as a question keeps them.
    rtol : float
        Tolerance of a run.
    arguments : mapping
        The arguments of a question besides points and starts.
    """

    speed: ClassVar[str] = SPEED
    title: ClassVar[str] = "Rotor system"
    behind: ClassVar[dict[str, tuple[str, ...]]] = {
        **dict.fromkeys((*OF_CONTACT, "touched"), ("contact",)),
        **dict.fromkeys(OF_NODE, ("node",)), "final_state": ("component",),
    }  # fmt: skip
    kept_columns: ClassVar[tuple[str, ...]] = (
        "response", "period", "status", "radius_min", "radius_max", "largest_force", "touched",
    )  # fmt: skip
    is_compiled: ClassVar[bool] = True

    varied: Varied
    starts: list[Start]
    kept: list[Start]
    rtol: float
    arguments: Mapping[str, Any]

    @classmethod
    def of(
        cls, asked: Varied, starts: object, modes: int | None, rtol: float, word: str = "starts",
    ) -> VariedSystem:  # fmt: skip
        """Return a system in a number of modes; InputError for starts that it does not have."""
        tolerance = check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL)
        given = _checked_starts(starts)
        taken = [begun_in_modes(asked.base, modes, each, word) for each in given]
        for assembly, start in taken:  # before a study keeps it
            if not isinstance(start, str):
                start_of_system(assembly, start, 1.0)
        first = [start for _, start in taken]
        kept = [end if isinstance(each, xr.Dataset) else each
                for each, end in zip(given, first, strict=True)]  # fmt: skip
        arguments = {"rotor": asked.base, "modes": modes, "rtol": tolerance}
        return cls(replace(asked, system=taken[0][0].system), first, kept, tolerance, arguments)

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of a result that say how it was computed."""
        return provenance({"method": "taylor", "rtol": self.rtol})

    def coordinates(self, points: Varied) -> dict[str, Column]:
        """Return the coordinates of a result besides its axes: its nodes and contacts."""
        return places_of(points)

    def initial_states(self, points: Varied) -> Values:
        """Return q, velocity and speeds of races at each start; NaN where the speed sets them."""
        problem, speed = Turnings(points, self.rtol).checked(), float(points.axes[SPEED][0])
        states = []
        for start in self.starts:
            varies = isinstance(start, str) and start == SETTLED
            state = start_of_system(problem.assembly, None if varies else start, speed)
            states.append(np.append(state, problem.race_speeds))
            if varies:
                states[-1][:] = math.nan
        return np.array(states)

    def ramps(self, points: Varied, along: str) -> Ramps[Turning, Start | Values]:
        """Return the ramps of all points, checked; warn where they take long."""
        turnings = Turnings(points, self.rtol)
        problem, speeds = turnings.checked(), points.axes[SPEED]
        warn_if_long(problem, speeds, points.points // speeds.size)
        answers: Answers[Turning, Start | Values] = Answers(answer_of_system, point_of(problem))
        return Ramps(points, self.starts, answers, turnings.at, points.dims.index(along or SPEED))

    @staticmethod
    def motion(point: Turning, end: Values, stop: Stop) -> tuple[Flow, Values]:
        """Return how the system at a point goes on from where a sweep has left it."""
        flow = SystemFlow.at(*point, stop)
        return flow, end / flow.scales

    def labelled(self, dataset: xr.Dataset) -> xr.Dataset:
        """Return a result with the units of its system."""
        where = "distance of the contact from the centre of its stator over the final window"
        for name, word in (("radius_min", "smallest"), ("radius_max", "largest")):
            dataset[name].attrs["long_name"] = f"{word} {where}"
        if "to" in dataset.coords:
            dataset["to"].attrs["long_name"] = "spin speed at the end of the ramp"
        return with_system_units(dataset, self.varied.base)


def check_slowest(problem: SettlingProblem, speeds: Values) -> None:
    """Refuse a speed at which a revolution would take too many steps."""
    slowest = float(np.abs(speeds).min())
    with np.errstate(over="ignore"):
        fastest = SystemFlow.at(problem, slowest, NO_STOP).request.fastest
    if not fastest <= MOST_RATIO * slowest:
        raise InputError(
            "{name} must be at least {least:.4g}, as the system moves at up to {fastest:.4g}, got "
            "{value}; fewer modes lower that",
            name="speed", least=fastest / MOST_RATIO, fastest=fastest, value=slowest,
        )  # fmt: skip


def warn_if_long(problem: SettlingProblem, speeds: Values, times: int) -> None:
    """Warn where a sweep takes minutes that fewer modes would save, before it starts."""
    found, size = problem.found, problem.assembly.size
    fastest = SystemFlow.at(problem, float(np.abs(speeds).max()), NO_STOP).request.fastest
    work = times * size**3 * fastest * float((1.0 / np.abs(speeds)).sum())
    inert = size - found.massless
    rates = np.sqrt(np.abs(np.linalg.eigvals(found.stiffness[:inert, :inert])))
    modes = max(int((rates <= KEPT * np.abs(speeds).max()).sum()), FEWEST_MODES)
    if work <= LONG or 2 * modes > size:
        return
    unit = " rad/s" if problem.assembly.system.units == "SI" else ""
    warn(
        f"the sweep takes some {math.ceil(work / WORK_A_MINUTE)} minutes on one core, as {size} "
        f"degrees of freedom move at up to {fastest:.3g}{unit}: modes={modes} takes less, and "
        f"keeps natural frequencies up to {KEPT:g} times the largest speed",
    )


def _checked_starts(starts: object) -> list[Start | xr.Dataset]:
    """Return the starts, one or more; a result alone is one start."""
    if isinstance(starts, xr.Dataset):
        return [starts]
    if not isinstance(starts, list | tuple) or not starts:
        raise InputError(
            f'starts must be a list of (q, velocity), "settled", "rest", None or a result, got '
            f"{shown(starts)}"
        )
    return list(starts)


def point_of(problem: SettlingProblem) -> np.dtype[np.void]:
    """Return the columns of a settled response."""
    assembly = problem.assembly
    contacts, nodes = len(assembly.contacts), len(assembly.system.nodes)
    races = int(problem.with_race.sum())
    return np.dtype(
        [
            ("response", np.int8),
            *((name, np.float64) for name in OF_POINT),
            ("status", np.int8),
            *((name, np.float64, (contacts,)) for name in OF_CONTACT),
            ("touched", np.int8, (contacts,)),
            *((name, np.float64, (nodes,)) for name in OF_NODE),
            ("final_state", np.float64, (2 * assembly.size + races,)),
        ]
    )


def answer_of_system(point: Turning, start: Start | Values, stop: Stop) -> Answer:
    """Return what a system settles on, from a start or from where another point ends."""
    flow = SystemFlow.at(*point, stop)
    begun = start if isinstance(start, np.ndarray) else started(point, start)
    settled = settle_system(flow, begun / flow.scales)
    end = settled.motion.state * flow.scales
    return Answer(figures_of(settled, flow), settled.decision.message, end=end)


def state_of_start(problem: SettlingProblem, start: Start | xr.Dataset, speed: float) -> Values:
    """Return displacements, velocities and speeds of races at a start, or where a result ends."""
    begun = start_of_system(problem.assembly, start, speed)
    moved = np.array([problem.found.to_y(each) for each in begun])
    return np.concatenate([moved.ravel(), problem.race_speeds])


def started(point: Turning, start: Start) -> Values:
    """Return the state at a start of one of several points."""
    try:
        return state_of_start(point.problem, start, point.speed)
    except InputError as error:  # a resonance has no settled whirl
        raise SimulationError(str(error)) from error


def figures_of(settled: Settled[SystemFeatures], flow: SystemFlow) -> dict[str, Any]:
    """Return a settled response by the names of its columns."""
    decision, features = settled.decision, settled.features
    has_period = decision.period is not None and decision.kind not in (CONTACT_FREE, SYNCHRONOUS)
    way = -math.copysign(1.0, flow.speed)  # lags are in the sense of the spin
    return {
        "response": RESPONSE[decision.kind],
        "period": decision.period if has_period else math.nan,
        "cycle_distance": decision.distance if math.isfinite(decision.distance) else math.nan,
        "lyapunov_exponent": decision.exponent, "lyapunov_error": decision.error,
        "revolutions": settled.motion.time / flow.revolution,
        "amplitude": np.abs(features.contact_whirl),
        "phase_lag": way * np.angle(features.contact_whirl),
        "radius_min": features.contact_low, "radius_max": features.contact_high,
        "largest_force": features.largest_force, "touched": features.touches,
        "node_amplitude": np.abs(features.node_whirl),
        "node_phase_lag": way * np.angle(features.node_whirl),
        "node_radius_min": features.node_low, "node_radius_max": features.node_high,
        "final_state": flow.in_q(settled.motion.state),
    }  # fmt: skip


def places_of(varied: Varied) -> dict[str, Column]:
    """Return the nodes and contacts of a system as columns of a result."""
    system = varied.base
    found: dict[str, Column] = {
        "node": ("node", np.array(list(system.nodes), str)),
        "contact_node": ("contact", np.array([each.node for each in system.contacts], str)),
        **clearances_of(varied),
    }
    if system.positions is not None:
        found["axial_position"] = ("node", np.array(list(system.positions.values())))
    return found


def clearances_of(varied: Varied) -> dict[str, Column]:
    """Return the clearance of each contact; where it varies, beside that axis."""
    axis = varied.given.get("clearance")
    if axis is None:
        return {"clearance": ("contact", np.array([c.clearance for c in varied.base.contacts]))}
    each = [with_parameters(varied.base, {"clearance": value}).contacts
            for value in np.atleast_1d(axis).tolist()]  # fmt: skip
    values = np.array([[contact.clearance for contact in contacts] for contacts in each])
    if axis.ndim:
        return {OF_CONTACTS: (("clearance", "contact"), values)}
    return {OF_CONTACTS: ("contact", values[0])}


def with_meanings(
    dataset: xr.Dataset, varied: Varied, attributes: Mapping[str, Any] = {}
) -> xr.Dataset:
    """Return a result whose parameters, and the direction over them, say what they are.

    One disc and a system have parameters of the same names.
    """
    own: Mapping[str, Any] = OF_ROTOR if varied.system is None else PARAMETERS_OF_SYSTEM
    for name in varied.parameters if varied.system is not None else ():
        if name in PARAMETERS_OF_SYSTEM:
            dataset[name].attrs["long_name"] = PARAMETERS_OF_SYSTEM[name].meaning
    if (way := attributes.get("along", "omega")) != "omega":
        words = f"direction in which the {own[way].label} is swept"
        dataset["direction"].attrs["long_name"] = words
    return dataset


# ---- Of one disc ----


@dataclass(frozen=True, slots=True)
class VariedDisc:
    """One disc whose parameters vary, and its starts; `VariedSystem` is that of a rotor system.

    Parameters
    ----------
    varied : Varied
        The points.
    starts : list
        Starts, as a question keeps them too.
    options : Options
        How to simulate.
    """

    speed: ClassVar[str] = "omega"
    title: ClassVar[str] = "Rotor in a clearance"
    # the dimensions of columns of several numbers, and the columns that a diagram keeps
    behind: ClassVar[dict[str, tuple[str, ...]]] = {}
    kept_columns: ClassVar[tuple[str, ...]] = ("response", "radius_min", "radius_max", "status")

    varied: Varied
    starts: list[GivenStart]
    options: Options

    @classmethod
    def of(cls, asked: Varied, starts: object, **options: Any) -> VariedDisc:
        """Return the points with checked starts and options."""
        checked = options_of_study(**options)
        loaded = bool(asked.values("load").any())
        return cls(asked, states_of("starts", starts, loaded=loaded), checked)

    @property
    def kept(self) -> list[GivenStart]:
        """The starts, as a question keeps them."""
        return self.starts

    @property
    def is_compiled(self) -> bool:
        """Whether the work is compiled, and so done in threads."""
        return self.options.backend != "python"

    @property
    def arguments(self) -> dict[str, Any]:
        """The arguments of a question besides points and starts."""
        return {name: getattr(self.options, name) for name in ("rtol", "atol", "method")}

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of a result that say how it was computed."""
        return provenance(self.options.attributes()) | start_words(self.starts)

    def coordinates(self, _points: Varied) -> dict[str, Column]:
        """Return the coordinates of a result besides its axes."""
        return start_coordinates(self.starts)

    def ramps(self, points: Varied, along: str) -> Ramps[Rotor, GivenStart]:
        """Return the ramps of all points, checked."""
        check_varied_can_be_followed(points, self.starts)
        answers: Answers[Rotor, GivenStart] = Answers(partial(answer_of_disc, self.options), POINT)
        axis = points.dims.index(along or self.speed)
        return Ramps(points, self.starts, answers, points.rotor, axis)

    @property
    def motion(self) -> Callable[..., tuple[Flow, Values]]:
        """How the rotor at a point goes on from where a sweep has left it; for workers."""
        return partial(motion_of_disc, self.options)

    def labelled(self, dataset: xr.Dataset) -> xr.Dataset:
        """Return a result as it is: its units are those of the schema."""
        return dataset


def motion_of_disc(options: Options, rotor: Rotor, end: Values, stop: Stop) -> tuple[Flow, Values]:
    """Return the motion of one disc, and its state at the end of a settled one."""
    return DiscFlow(rotor, stop, options=options), end


def answer_of_disc(
    options: Options, rotor: Rotor, start: GivenStart, stop: Stop, *, events: bool = False
) -> Answer:
    """Return what one disc settles on, from a start, with the events on the way if wanted."""
    first = start_of(rotor, start) if isinstance(start, str) else start
    settled = settle_disc(rotor, first, options, stop=stop)
    motion = settled.motion
    table = np.empty(sum(each.times.size for each in motion.events), EVENT)
    if events and table.size:
        table["event_time"] = np.concatenate([each.began + each.times for each in motion.events])
        table["event_kind"] = np.concatenate([each.kinds for each in motion.events])
        states = [rotated(each.states, rotor.omega * each.began) for each in motion.events]
        for name, column in zip(EVENT_STATES, np.concatenate(states).T, strict=True):
            table[name] = column
    figures = {
        "response": RESPONSE[settled.kind], **asdict(settled.features),
        "window_start": motion.window_start, "window_end": motion.time,
        "event_count": table.size,
        **{f"end_{name}": each for name, each in zip(COMPONENTS, motion.state, strict=True)},
    }  # fmt: skip
    message = settled.decision.message
    return Answer(figures, message, end=motion.state, events=table if events else None)


def start_coordinates(starts: Sequence[GivenStart]) -> dict[str, Column]:
    """Return the starts ``(x, y, vx, vy)`` as coordinates of a result; NaN where it is a word."""
    states = [(math.nan,) * len(COMPONENTS) if isinstance(each, str) else each for each in starts]
    columns = zip(COMPONENTS, np.array(states).T, strict=True)
    return {f"start_{name}": ("start", column.copy()) for name, column in columns}


def start_words(starts: Sequence[GivenStart]) -> dict[str, str]:
    """Return the attribute with the word of each start, if there is any; "state" where it is one.

    Examples
    --------
    >>> start_words(["settled", (1.0, 0.0, 0.0, 0.0)]), start_words([(1.0, 0.0, 0.0, 0.0)])
    ({'start_words': 'settled state'}, {})
    """
    if not any(isinstance(each, str) for each in starts):
        return {}
    words = [each if isinstance(each, str) else "state" for each in starts]
    return {"start_words": " ".join(words)}


def check_varied_can_be_followed(
    varied: Varied, starts: Sequence[GivenStart], *, settling: bool = True
) -> None:
    """Check each speed, each clearance and each start once, and the largest damping."""
    rotors = varied.extremes()
    # rest on the axis stands for words
    first, *others = [AT_REST if isinstance(each, str) else each for each in starts]
    for rotor in rotors:
        check_can_be_followed(rotor, first, settling=settling)
    for start in others:
        check_can_be_followed(rotors[0], start, settling=settling)
