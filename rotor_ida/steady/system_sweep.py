"""The settled response of a rotor system over a range of speeds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Stop, Values
from rotor_ida.checks import (
    MOST_NUMBERS,
    MOST_POINTS_OF_STUDY,
    check_between,
    check_direction,
    check_distinct,
    check_points,
    check_progress,
    shown,
)
from rotor_ida.core.runs import NO_STOP
from rotor_ida.errors import InputError, warn
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, choose, shows_progress
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import RESPONSE, STATUS, labelled_dataset
from rotor_ida.steady.follow import FAILED
from rotor_ida.steady.grid import EXPECTED, Places, Rows, Task, form_of, reason_of, run_study
from rotor_ida.steady.ramps import RampOrder
from rotor_ida.steady.response import CONTACT_FREE, SYNCHRONOUS
from rotor_ida.steady.sweep import DIRECTIONS, Direction
from rotor_ida.steady.system_flow import SettlingProblem, SystemFlow
from rotor_ida.steady.system_motion import SettledSystem, settle
from rotor_ida.systems.archived import problem_variables
from rotor_ida.systems.assembly import assemble
from rotor_ida.systems.ends import state_at_end
from rotor_ida.systems.modes import in_modes
from rotor_ida.systems.receptances import checked_speeds
from rotor_ida.systems.simulate import LOOSEST_RTOL, TIGHTEST_RTOL
from rotor_ida.systems.starts import Start, start_of
from rotor_ida.systems.units import with_system_units

SETTLED = "settled"
# Largest rate of the system over the speed: a revolution takes a step for some five radians of it.
MOST_RATIO = 1e6
# Cost of a sweep: the cube of the degrees of freedom times the largest rate over the speed, of all
# points. What a core does of it in a minute, roughly, and from where on it is long.
WORK_A_MINUTE, LONG = 1.5e8, 1e8
# Modes that make it shorter: natural frequencies up to this multiple of the speed, and at least 16.
KEPT, FEWEST_MODES = 10.0, 16
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
    modes: int | None = None,
    rtol: float = 1e-10,
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
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
    starts : sequence of (q, velocity), "settled", "rest", None or Dataset; or Dataset
        Starts at time 0, as in `simulate`; default: one, at rest at 0.
    direction : {"up", "down", "both"}, optional
        Quasi-static run-up or run-down: only the first speed (the last, going down) begins from
        the starts, and each other from the end of the one before, so that jumps and their
        hysteresis appear. By default each speed begins from the starts.
    rtol : float
        Relative tolerance, from 1e-14 to 1e-4.
    workers, executor, study, progress
        As in `sweep` of one disc.

    Returns
    -------
    Dataset
        On ``(speed, start, direction)``: ``response`` (its kind, as a flag: the words and numbers
        of `sweep` of one disc), ``period`` of a motion that is not synchronous,
        ``cycle_distance`` (the estimated distance from the settled motion at the end, relative to
        its size), ``lyapunov_exponent`` and ``lyapunov_error`` where needed, ``revolutions`` for
        which it was followed, ``status`` and ``message``. On ``contact`` too: ``amplitude`` and
        ``phase_lag`` of the displacement at the spin speed, ``radius_min``, ``radius_max``,
        ``largest_force`` and ``touched``. On ``node``: ``node_amplitude``, ``node_phase_lag``,
        ``node_radius_min``, ``node_radius_max``. On ``component``: ``final_state``, with the
        unbalance at angle 0.

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
    system = changed_system(sweep_system, system, changed)
    speeds = _checked_speeds(speed, direction)
    tolerance = check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL)
    progress = check_progress(progress)
    chosen = choose(executor, workers, compiled=True)
    begun = checked_starts(starts)
    taken = [in_modes(system, modes, start) for start in begun]
    assembly = assemble(taken[0][0])
    first = [state_at_end(assembly, start) for _, start in taken]
    asked = [end if isinstance(given, xr.Dataset) else given
             for given, end in zip(begun, first, strict=True)]  # fmt: skip
    if modes is not None and any(isinstance(each, xr.Dataset) for each in begun):
        raise InputError(f"starts must be (q, velocity) with modes, got a result and {modes!r}")
    problem = SettlingProblem.of(assembly, tolerance)
    check_slowest(problem, speeds)
    directions = np.array(DIRECTIONS[direction], dtype=np.int8)
    sizes = (speeds.size, len(first), directions.size)
    check_points(*(range(size) for size in sizes),
                 most=MOST_NUMBERS if study is None else MOST_POINTS_OF_STUDY)  # fmt: skip
    warn_if_long(problem, speeds, math.prod(sizes[1:]))
    ramps = SystemRamps(problem, speeds, first, RampOrder(sizes, directions))
    states = np.array([_start_state(problem, each, speeds) for each in first])
    held = problem_variables(assembly, states)
    held["node"] = ("node", np.array(list(assembly.system.nodes), str))
    question = Question("sweep", {
        "rotor": system, "starts": asked, "modes": modes, "speed": speeds, "direction": direction,
        "rtol": tolerance,
    })  # fmt: skip
    task = Task(settle_along, lost, rows_of, ramps.form, ramps.point)
    columns = run_study(
        ramps, task, question, study=study, workers=chosen, progress=progress
    ).points
    return _dataset(ramps, columns, held)


def _checked_speeds(speed: object, direction: Direction | None) -> Values:
    """Return spin speeds that a sweep can follow."""
    speeds = checked_speeds(speed)
    if not speeds.all():
        raise InputError("speed must not be 0 in a sweep of a rotor system, got 0.0")
    check_distinct("speed", speeds)
    check_direction(direction, None, {"speed": speeds}, "speed")
    return speeds


def check_slowest(problem: SettlingProblem, speeds: Values) -> None:
    """Refuse a speed at which a revolution would take too many steps."""
    slowest = float(np.abs(speeds).min())
    with np.errstate(over="ignore"):
        fastest = SystemFlow.at(problem, slowest, NO_STOP).request.fastest
    if not fastest <= MOST_RATIO * slowest:
        raise InputError(
            f"speed must be at least {fastest / MOST_RATIO:.4g}, as the system moves at up to "
            f"{fastest:.4g} rad per unit of time, got {slowest!r}; fewer modes lower that"
        )


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


def _start_state(problem: SettlingProblem, start: Start, speeds: Values) -> Values:
    """Return displacement and velocity of a start; NaN where they depend on the speed."""
    state = start_of(problem.assembly, start, float(speeds[0])).ravel()
    return np.full_like(state, math.nan) if isinstance(start, str) and start == SETTLED else state


@dataclass(frozen=True, slots=True)
class SystemRampJob:
    """A ramp with all that a worker needs to follow it."""

    problem: SettlingProblem
    speeds: list[float]
    start: Start
    point: np.dtype[np.void]


@dataclass(frozen=True)
class SystemRamps:
    """All ramps of a sweep of a rotor system, by number.

    Parameters
    ----------
    problem : SettlingProblem
        The system.
    speeds : ndarray
        The speeds.
    starts : sequence
        The starts.
    order : RampOrder
        How the points form ramps.
    """

    problem: SettlingProblem
    speeds: Values
    starts: Sequence[Start]
    order: RampOrder

    @property
    def length(self) -> int:
        """Number of points of each ramp."""
        return self.order.length

    @property
    def points(self) -> int:
        """Number of points of all ramps."""
        return self.order.points

    @property
    def point(self) -> np.dtype[np.void]:
        """The columns of a point."""
        return point_of(self.problem)

    @property
    def form(self) -> Any:
        """How rows are stored."""
        return form_of("points of a sweep", "points", self.point)

    def places(self, number: int) -> Places:
        """Return the positions of a ramp's points among all, in the order of the dimensions."""
        return self.order.places(number)

    def job(self, number: int) -> SystemRampJob:
        """Return what a worker needs to follow a ramp."""
        speeds, (start, *_), _ = np.unravel_index(self.places(number), self.order.shape)
        return SystemRampJob(
            self.problem, self.speeds[speeds].tolist(), self.starts[start], self.point
        )

    def slowest_first(self) -> Places:
        """Return the numbers of the ramps, in any order."""
        return np.arange(len(self.order))


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


def settle_along(ramp: SystemRampJob, stop: Stop) -> Rows:
    """Follow one ramp: each point begins where the last one that did not fail has ended."""
    points, messages = np.zeros(len(ramp.speeds), ramp.point), []
    problem, last = ramp.problem, None
    for row, speed in zip(points, ramp.speeds, strict=True):
        if stop[0]:
            break
        flow = SystemFlow.at(problem, speed, stop)
        try:
            begun = first_state(problem, ramp.start, speed) if last is None else last
            settled = settle(flow, begun / flow.scales)
        except (*EXPECTED, InputError) as error:  # it must not end the other points
            _fail(row)
            messages.append(reason_of(error))
            continue
        last = settled.state * flow.scales
        fill(row, settled, flow, last)
        messages.append(settled.decision.message)
    return Rows(points[: len(messages)], messages)


def first_state(problem: SettlingProblem, start: Start | xr.Dataset, speed: float) -> Values:
    """Return the state at a start: displacements, velocities and speeds of races."""
    begun = start_of(
        problem.assembly, state_at_end(problem.assembly, start), speed
    )  # a resonance has no settled whirl
    moved = np.array([problem.found.to_y(each) for each in begun])
    return np.concatenate([moved.ravel(), problem.race_speeds])


def lost(ramp: SystemRampJob, reason: str) -> Rows:
    """Return the points of a ramp whose workers died."""
    points = np.zeros(len(ramp.speeds), ramp.point)
    for row in points:
        _fail(row)
    return Rows(points, [reason] * len(points))


def rows_of(rows: Rows) -> Rows:
    """Return the rows of a ramp, which they are already."""
    return rows


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
    ramps: SystemRamps,
    columns: Mapping[str, npt.NDArray[Any]],
    held: Mapping[str, Column],
) -> xr.Dataset:
    """Return the points of a sweep as a labelled dataset."""
    order, system = ramps.order, ramps.problem.assembly.system
    dims = ("speed", "start", "direction")
    behind = dict.fromkeys((*OF_CONTACT, "touched"), ("contact",))
    behind |= dict.fromkeys(OF_NODE, ("node",)) | {"final_state": ("component",)}
    variables: dict[str, Column] = {
        name: ((*dims, *behind.get(name, ())), column.reshape(*order.shape, *column.shape[1:]))
        for name, column in columns.items()
    }
    coordinates: dict[str, Column] = {
        "speed": ("speed", ramps.speeds),
        "start": ("start", np.arange(len(ramps.starts))),
        "direction": ("direction", order.directions),
        "node": held["node"],
    }
    if system.positions is not None:
        coordinates["axial_position"] = ("node", np.array(list(system.positions.values())))
    variables |= {name: column for name, column in held.items() if name != "node"}
    dataset = labelled_dataset(
        "Rotor system: responses over a range of speeds", variables, coordinates,
        provenance({"method": "taylor", "rtol": ramps.problem.rtol}), kind="system_sweep",
    )  # fmt: skip
    for name, word in (("radius_min", "smallest"), ("radius_max", "largest")):
        dataset[name].attrs["long_name"] = (
            f"{word} distance of the contact from the centre of its stator over the final window"
        )
    return with_system_units(dataset, system)
