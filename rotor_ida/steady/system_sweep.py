"""The settled response of a rotor system over a range of speeds, and of other parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Stop, Values
from rotor_ida.checks import check_between, check_distinct, check_progress, shown
from rotor_ida.closed_forms.receptances import checked_speeds
from rotor_ida.core.runs import NO_STOP
from rotor_ida.errors import InputError, SimulationError, warn
from rotor_ida.model.assembly import assemble
from rotor_ida.model.few_modes import in_modes
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import (
    PARAMETERS_OF_SYSTEM,
    SPEED,
    SystemAxes,
    with_parameters,
)
from rotor_ida.model.varied import Varied, varied_system_of
from rotor_ida.parallel import Progress, choose, shows_progress
from rotor_ida.results.archived_system import OF_CONTACTS
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import DESIGN, Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.results.system_units import with_system_units
from rotor_ida.schema import RESPONSE, STATUS, labelled_dataset
from rotor_ida.simulation.systems.flow import SettlingProblem, SystemFlow
from rotor_ida.simulation.systems.simulate import LOOSEST_RTOL, TIGHTEST_RTOL
from rotor_ida.simulation.systems.starts import Start, start_of, state_at_end
from rotor_ida.steady.follow import FAILED
from rotor_ida.steady.grid import Rows, Task, check_size, form_of, labelled_points, run_study
from rotor_ida.steady.ramps import Direction, RampJob, Ramps, in_order, lost, settle_along
from rotor_ida.steady.response import CONTACT_FREE, SYNCHRONOUS
from rotor_ida.steady.system_motion import SettledSystem, settle

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


@shows_progress
def sweep_system(
    system: RotorSystem,
    *,
    speed: npt.ArrayLike,
    starts: Sequence[Start | xr.Dataset] | xr.Dataset = (None,),
    direction: Direction | None = None,
    along: str | None = None,
    modes: int | None = None,
    rtol: float = 1e-10,
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemAxes],
) -> xr.Dataset:
    """Compute the settled response of a rotor system at every speed.

    Parameters
    ----------
    system : RotorSystem
        The rotor.
    modes : int, optional
        As in `simulate`.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of the system, as in `simulate`.
    speed : float or sequence of float, shape (n,)
        Spin speeds, not 0.
    clearance, friction, unbalance : float or array_like, shape (n,), optional
        The largest clearance and friction coefficient of the contacts, and the largest moment of
        the unbalance, in the units of the system. The other contacts or unbalances keep their
        ratios to it; where all are 0, each gets it. All values are combined. An array becomes a
        dimension of the result, with each value once, and a number a scalar coordinate.
    damping, stiffness : float or array_like, shape (n,), optional
        Factors of the damping and stiffness matrices, with supports; 1 leaves them as they are.
    starts : sequence of (q, velocity), "settled", "rest", None or Dataset; or Dataset
        Starts at time 0, as in `simulate`; default: one, at rest at 0.
    direction : {"up", "down", "both"}, optional
        Quasi-static run-up or run-down: only the first speed (the last, going down) begins from
        the starts, and each other from the end of the one before, so that jumps and their
        hysteresis appear. By default each speed begins from the starts.
    along : str, optional
        Name of the parameter that rises or falls with a direction, in increasing order. Default:
        ``"speed"`` if it varies, else the only parameter that does.
    rtol : float
        Relative tolerance, from 1e-14 to 1e-4.
    workers, executor, study, progress
        As in `sweep` of one disc.

    Returns
    -------
    Dataset
        On ``(speed, start, direction)``, with any other axes before ``start``: ``response`` (its
        kind, as a flag: the words and numbers of `sweep` of one disc), ``period`` of a motion that
        is not synchronous,
        ``cycle_distance`` (the estimated distance from the settled motion at the end, relative to
        its size), ``lyapunov_exponent`` and ``lyapunov_error`` where needed, ``revolutions`` for
        which it was followed, ``status`` and ``message``. On ``contact`` too: ``amplitude`` and
        ``phase_lag`` of the displacement at the spin speed, ``radius_min``, ``radius_max``,
        ``largest_force`` and ``touched``. On ``node``: ``node_amplitude``, ``node_phase_lag``,
        ``node_radius_min``, ``node_radius_max``. On ``component``: ``final_state``, with the
        unbalance at angle 0. The attribute ``design`` is the system and its starts as JSON; with
        ``clearance``, that of each contact is ``contact_clearance``.

    Raises
    ------
    InputError
        If an argument cannot be used. A point that fails does not raise: its ``status`` and
        ``message`` give the reason.
    SimulationError
        If one of the ``"processes"``, or the scheduler, died.

    Warns
    -----
    UserWarning
        Before it starts, if it takes minutes: where the cube of the degrees of freedom times the
        largest rate of vibration over the speed, added over all points, exceeds 1e8. The warning
        names a number of `modes` that is enough.

    Notes
    -----
    An axisymmetric system is autonomous on axes that turn with the unbalance: there a synchronous
    whirl stands still, and other periodic motions are cycles of any period. Of any other system the
    states once a revolution are compared, and periods are whole revolutions.

    The motion is followed until it shows to which stable cycle it leads; Newton's method then finds
    that cycle, from where the simulation goes on (`rotor_ida.steady.landing`). Only a motion that
    misses itself by less than 1e-9 of its size over a window is periodic. So slight damping costs
    no thousands of revolutions. A motion that shows no cycle is followed for 60 times the
    slowest decay time of a free motion, at least 1,500 and at most 4,000 revolutions. After 450
    revolutions and 20 decay times, or 1,500 revolutions, its largest Lyapunov exponents decide
    whether it is ``chaotic`` or ``quasi_periodic``: by neighbours over 2,000 revolutions, or 8,000
    in doubt. Chaos that lasts longer may still be a transient.

    A motion that sits on an unstable equilibrium, whirl or cycle is moved off: by 0.001 clearances
    at a contact, along the motions that grow, and followed anew. Without contact nothing is
    chaotic: what grows there stays ``unresolved``, or fails.

    It is ``rolling`` (dry whip) if a contact stays closed, whirls backwards, and rolls in every
    period or revolution. The kind ``touching`` of one disc is not told from ``unresolved`` ones.

    Examples
    --------
    >>> import numpy as np
    >>> from rotor_ida import Contact, RotorSystem, Unbalance, decode_flags
    >>> system = RotorSystem(
    ...     mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
    ...     contacts=[Contact(node="disc", clearance=1.5, stiffness=4.0, exponent=1.0)],
    ...     unbalance=[Unbalance(node="disc", moment=1.0)], units="1")
    >>> responses = sweep_system(system, speed=[0.5, 0.9], direction="up")
    >>> decode_flags(responses.response).values.ravel().tolist()
    ['contact_free', 'synchronous']
    >>> responses[["response", "amplitude"]].to_dataframe().amplitude.round(6).tolist()
    [0.332595, 1.622132]
    """
    speeds = turning_speeds(speed, "in a sweep of a rotor system")
    asked = varied_system_of(sweep_system, system, changed, speeds)
    tolerance = check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL)
    progress = check_progress(progress)
    chosen = choose(executor, workers, compiled=True)
    given = checked_starts(starts)
    varied, way = in_order(asked, len(given), direction, along, SPEED)
    taken = [in_modes(asked.base, modes, each) for each in given]
    varied = replace(varied, system=taken[0][0])
    first = [state_at_end(assemble(of), start) for of, start in taken]
    if modes is not None and any(isinstance(each, xr.Dataset) for each in given):
        raise InputError(f"starts must be (q, velocity) with modes, got a result and {modes!r}")
    turnings = Turnings(varied, tolerance)
    stiffest = turnings.checked()
    check_size(varied, study)
    warn_if_long(stiffest, varied.axes[SPEED], varied.points // varied.axes[SPEED].size)
    told = {"along": way} if way not in {"", SPEED} else {}
    begun = [end if isinstance(each, xr.Dataset) else each
             for each, end in zip(given, first, strict=True)]  # fmt: skip
    question = Question("sweep", {
        "rotor": asked.base, "starts": begun, "modes": modes, **varied.design,
        "direction": direction, **told, "rtol": tolerance,
    })  # fmt: skip
    point = point_of(stiffest)
    settling, axis = SystemSettling(point), varied.dims.index(way or SPEED)
    ramps: Ramps[Turning, Start | Values, SettledPoint] = Ramps(
        varied, first, settling, turnings.at, axis
    )
    form = form_of("points of a sweep", "points", point)
    task: Task[SystemJob, list[SettledPoint]] = Task(settle_along, lost, rows_of, form, point)
    columns = run_study(
        ramps, task, question, study=study, workers=chosen, progress=progress
    ).points
    attributes = provenance({"method": "taylor", "rtol": tolerance}) | told
    return _dataset(varied, columns, stiffest, first, attributes)


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

    def checked(self) -> SettlingProblem:
        """Check the speeds at both ends of each parameter; return the problem with the largest."""
        axes = self.varied.axes
        largest = {name: int(np.argmax(axis)) for name, axis in axes.items()}
        smallest = {name: int(np.argmin(axis)) for name, axis in axes.items()}
        found = []
        for ends in (largest, *(largest | {name: at} for name, at in smallest.items())):
            found.append(self.at(list(ends.values())).problem)
            check_slowest(found[-1], np.atleast_1d(self.varied.given[SPEED]))
        return found[0]


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


def checked_starts(starts: object) -> list[Start | xr.Dataset]:
    """Return the starts, one or more; a result alone is one start."""
    if isinstance(starts, xr.Dataset):
        return [starts]
    if not isinstance(starts, list | tuple) or not starts:
        raise InputError(
            f'starts must be a list of (q, velocity), "settled", "rest", None or a result, got '
            f"{shown(starts)}"
        )
    return list(starts)


def _initial_state(problem: SettlingProblem, start: Start, speed: float) -> Values:
    """Return q, velocity and speeds of races at a start; NaN where they depend on the speed."""
    state = np.append(start_of(problem.assembly, start, speed), problem.race_speeds)
    return np.full_like(state, math.nan) if isinstance(start, str) and start == SETTLED else state


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


class SettledPoint(NamedTuple):
    """A point of a sweep as a row, and the state at its end; None if it failed."""

    row: npt.NDArray[np.void]
    message: str
    end: Values | None


SystemJob = RampJob[Turning, Start | Values, SettledPoint]


@dataclass(frozen=True, slots=True)
class SystemSettling:
    """How a rotor system is followed: see `rotor_ida.steady.ramps.Settling`."""

    columns: np.dtype[np.void]

    def settle(self, point: Turning, start: Start | Values, stop: Stop) -> SettledPoint:
        """Return what a system settles on, from a start or from where another point ends."""
        flow = SystemFlow.at(*point, stop)
        begun = start if isinstance(start, np.ndarray) else started(point, start)
        settled = settle(flow, begun / flow.scales)
        row, last = np.zeros(1, self.columns), settled.state * flow.scales
        fill(row[0], settled, flow, last)
        return SettledPoint(row, settled.decision.message, last)

    def failed(self, _point: Turning, _start: Start | Values, reason: str) -> SettledPoint:
        """Return the row of a point that failed."""
        row = np.zeros(1, self.columns)
        _fail(row[0])
        return SettledPoint(row, reason, None)

    def end(self, settled: SettledPoint) -> Start | Values | None:
        """Return the state at the end."""
        return settled.end


def first_state(problem: SettlingProblem, start: Start | xr.Dataset, speed: float) -> Values:
    """Return the state at a start, which may be the end of a result."""
    return state_of_start(problem, state_at_end(problem.assembly, start), speed)


def state_of_start(problem: SettlingProblem, start: Start, speed: float) -> Values:
    """Return displacements, velocities and speeds of races at a start."""
    begun = start_of(problem.assembly, start, speed)
    moved = np.array([problem.found.to_y(each) for each in begun])
    return np.concatenate([moved.ravel(), problem.race_speeds])


def started(point: Turning, start: Start) -> Values:
    """Return the state at a start of one of several points."""
    try:
        return state_of_start(point.problem, start, point.speed)
    except InputError as error:  # a resonance has no settled whirl
        raise SimulationError(str(error)) from error


def rows_of(points: Sequence[SettledPoint]) -> Rows:
    """Return points as rows."""
    rows = np.concatenate([point.row for point in points])
    return Rows(rows, [point.message for point in points])


def _fail(row: np.void) -> None:
    """Mark a point as failed."""
    for name in (*OF_POINT, *OF_CONTACT, *OF_NODE, "final_state"):
        row[name] = math.nan
    row["response"], row["status"], row["touched"] = RESPONSE[FAILED], STATUS["failed"], 0


def fill(row: np.void, settled: SettledSystem, flow: SystemFlow, last: Values) -> None:
    """Write a settled response into a row."""
    problem = flow.problem
    decision, features, size = settled.decision, settled.features, problem.assembly.size
    row["response"], row["status"] = RESPONSE[decision.kind], STATUS["done"]
    has_period = decision.period is not None and decision.kind not in (CONTACT_FREE, SYNCHRONOUS)
    row["period"] = decision.period if has_period else math.nan  # type: ignore[assignment]
    row["cycle_distance"] = decision.distance if math.isfinite(decision.distance) else math.nan
    row["lyapunov_exponent"], row["lyapunov_error"] = decision.exponent, decision.error
    row["revolutions"] = settled.revolutions
    row["amplitude"], row["node_amplitude"] = map(
        np.abs, (features.contact_whirl, features.node_whirl)
    )
    row["phase_lag"], row["node_phase_lag"] = (
        -math.copysign(1.0, flow.speed) * np.angle(whirl)  # in the sense of the spin
        for whirl in (features.contact_whirl, features.node_whirl)
    )
    row["radius_min"], row["radius_max"] = features.contact_low, features.contact_high
    row["node_radius_min"], row["node_radius_max"] = features.node_low, features.node_high
    row["largest_force"], row["touched"] = features.largest_force, features.touches
    moved = problem.found.to_q(last[: 2 * size].reshape(2, size))
    row["final_state"] = np.concatenate([moved.ravel(), last[2 * size :]])


def _dataset(
    varied: Varied,
    columns: Mapping[str, npt.NDArray[Any]],
    problem: SettlingProblem,
    starts: Sequence[Start],
    attributes: dict[str, Any],
) -> xr.Dataset:
    """Return the points of a sweep as a labelled dataset."""
    system = varied.base
    behind = dict.fromkeys((*OF_CONTACT, "touched"), ("contact",))
    behind |= dict.fromkeys(OF_NODE, ("node",)) | {"final_state": ("component",)}
    speed = float(varied.axes[SPEED][0])
    states = np.array([_initial_state(problem, each, speed) for each in starts])
    coordinates: dict[str, Column] = varied.coordinates | {
        "node": ("node", np.array(list(system.nodes), str)),
        "contact_node": ("contact", np.array([each.node for each in system.contacts], str)),
        **clearances_of(varied),
        "initial_state": (("start", "component"), states),
    }
    if system.positions is not None:
        coordinates["axial_position"] = ("node", np.array(list(system.positions.values())))
    dataset = labelled_dataset(
        "Rotor system: responses over a range of speeds",
        labelled_points(varied, columns, behind), coordinates,
        # as variables they would be columns of its table
        attributes | {DESIGN: Question("sweep", {"rotor": system, "starts": starts}).text()},
        kind="system_sweep",
    )  # fmt: skip
    for name, word in (("radius_min", "smallest"), ("radius_max", "largest")):
        dataset[name].attrs["long_name"] = (
            f"{word} distance of the contact from the centre of its stator over the final window"
        )
    return with_meanings(with_system_units(dataset, system), varied, attributes)


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
    """Return a result of a system whose parameters, and the direction over them, say what they are.

    One disc has parameters of the same names.
    """
    for name in varied.parameters:
        if name in PARAMETERS_OF_SYSTEM:
            dataset[name].attrs["long_name"] = PARAMETERS_OF_SYSTEM[name].meaning
    if way := attributes.get("along"):
        words = f"direction in which the {PARAMETERS_OF_SYSTEM[way].label} is swept"
        dataset["direction"].attrs["long_name"] = words
    return dataset
