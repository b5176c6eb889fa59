"""One run of a rotor system by the core: the structures of ``system.h``, and its call."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from ctypes import Structure, byref, c_double, c_int, c_int32, c_int64, c_void_p
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.core import library as found
from rotor_ida.core import sundials
from rotor_ida.core.interface import DONE, FULL, METHODS, pointer
from rotor_ida.core.runs import NO_STOP, PIECE, Rows, rows_of_numbers
from rotor_ida.model.bearing import Bearing, Films

FIRST_ROOM = 256
EIGHT = 8  # columns of a vector
# A skew part of a stiffness below this part of it is rounding.
SYMMETRIC = 1e-12
# Numbers of a contact at a sample: normal and tangential force, slip speed, mode.
FORCES = 4
LAW = np.dtype(
    [
        ("offset", np.float64, 2),
        *(
            (name, np.float64)
            for name in (
                "clearance", "hertz", "linear", "contact_damping", "friction", "radius",
                "race_radius", "inverse_race_inertia", "race_drag",
            )
        ),
        ("race", np.int64),
    ]
)  # fmt: skip
LAW_CHANGE = rows_of_numbers("clearance", "stiffness", "contact_damping", "friction")
TOUCH = np.dtype(
    [
        *((name, np.float64) for name in ("root", "race", "sense")),
        ("mode", np.int32),
        ("zeros", np.int32, 3),
    ]
)
EPISODE = rows_of_numbers(
    "contact", "entry", "exit", "peak_root", "peak_time", "largest_force", "force_time",
    "impulse", "work", "heat", "slip_distance", "rolling_time",
)  # fmt: skip
# The extreme speeds of a race, and their times.
RACE = rows_of_numbers("largest", "largest_time", "smallest", "smallest_time")
# An extremum of the distance of a place, of the kinds -1 minimum and 1 maximum; at the ends of a
# run 0.
EXTREMUM_OF_PLACE = np.dtype(
    [("time", np.float64), ("distance", np.float64), ("place", np.int32), ("kind", np.int32)]
)
PLACE = np.dtype([("centre", np.float64, 2), ("sign", np.float64), ("last", EXTREMUM_OF_PLACE)])
LEDGER = ("unbalance", "damping", "stiffness_rate", "normal", "tangential", "bearings")
NO_FILMS = Films((), np.zeros((0, 2, 0)))


class Standstill(NamedTuple):
    """Whether a driven rotor stands: since when its speed has stayed below a limit in size.

    Parameters
    ----------
    limit : float
        The limit; 0 where it was not asked for.
    since, rate : float
        When the speed last fell below it, NaN while it is above; and its rate then.
    longest : float
        The longest time below that has ended.
    """

    limit: float
    since: float = math.nan
    rate: float = 0.0
    longest: float = 0.0


class SystemRunStruct(Structure):
    """``struct system_run``."""

    _fields_ = [
        *((name, c_int64) for name in ("size", "stride", "contact_count", "massless")),
        *((name, c_void_p) for name in (
            "stiffness", "damping", "gyroscopic", "stiffness_rate", "circulation", "unbalance",
            "force", "rows", "laws", "touches", "pieces",
        )),
        *((name, c_int64) for name in ("piece_count", "piece")),
        ("inertia", c_double),
        ("weight", 2 * c_double),
        *((name, c_double) for name in ("rtol", "displacement", "velocity", "fastest")),
        *((name, c_int64) for name in ("order", "only_events")),
        ("duration", c_double),
        ("stop", c_void_p),
        *((name, c_double) for name in ("time", "speed", "angle", "piece_time", "piece_angle")),
        ("state", c_void_p),
        ("ledger", len(LEDGER) * c_double),
        ("standstill", len(Standstill._fields) * c_double),
        ("began", c_int32),
        *((name, c_void_p) for name in (
            "sample_times", "samples", "sample_forces", "sample_turns",
        )),
        *((name, c_int64) for name in ("sample_count", "sampled")),
        *((name, c_void_p) for name in (
            "event_times", "event_states", "event_turns", "event_kinds", "event_contacts",
        )),
        *((name, c_int64) for name in ("event_room", "events")),
        *((name, c_void_p) for name in ("episodes", "open", "races")),
        *((name, c_int64) for name in ("episode_room", "episode_count", "steps")),
        ("room", c_void_p),
        ("column_count", c_int64),
        *((name, c_void_p) for name in ("columns", "column_room", "parameters")),
        *((name, c_int64) for name in ("parameter_count", "first_of_parameters")),
        ("method", c_int64),
        *((name, c_void_p) for name in ("sundials", "cvode_room", "watched")),
        ("watched_count", c_int64),
        *((name, c_void_p) for name in (
            "sample_columns", "event_columns", "event_rates", "place_rows", "places",
        )),
        ("place_count", c_int64),
        ("extrema", c_void_p),
        *((name, c_int64) for name in ("extremum_room", "extremum_count")),
        ("bearings", c_void_p),
        ("bearing_count", c_int64),
        ("bearing_room", c_void_p),
    ]  # fmt: skip


class _BearingStruct(Structure):
    """``struct system_bearing``."""

    _fields_ = [
        *((name, c_void_p) for name in ("rows", "knots", "cubics")),
        *((name, c_int64) for name in ("knot_count", "interval")),
    ]


class _ParameterStruct(Structure):
    """``struct parameter``."""

    _fields_ = [
        ("speed", c_double),
        *((name, c_void_p) for name in (
            "stiffness", "damping", "unbalance", "laws", "mass", "force",
        )),
    ]  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class ByParameter:
    """The derivatives of a system by one parameter, in coordinates with a unit mass matrix.

    Parameters
    ----------
    speed : float
        Of the speed, the same at all times.
    mass, stiffness, damping : ndarray, shape (n, n)
        Of the matrices; None where they stay as they are.
    unbalance : ndarray, shape (2, n), or None
        Of the unbalance.
    force : ndarray, shape (n,), or None
        Of the constant force.
    laws : ndarray of LAW_CHANGE, shape (contact,)
        Of the contacts; that of a stiffness in parts of it.
    """

    speed: float = 0.0
    mass: Values | None = None
    stiffness: Values | None = None
    damping: Values | None = None
    unbalance: Values | None = None
    force: Values | None = None
    laws: Rows


def law_changes(own: Rows, before: Rows, after: Rows, step: float) -> Rows:
    """Return the derivatives of the laws of contacts, of which two differ by a step."""
    laws = np.zeros(len(own), LAW_CHANGE)
    for each in ("clearance", "contact_damping", "friction"):
        laws[each] = (after[each] - before[each]) / step
    here, less, more = (each["hertz"] + each["linear"] for each in (own, before, after))
    laws["stiffness"] = (more - less) / here / step
    return laws


class Places(NamedTuple):
    """Places of a system whose distances from centres are observed.

    Parameters
    ----------
    rows : ndarray, shape (place, 2, n)
        Their displacements, in coordinates with a unit mass matrix.
    centres : ndarray, shape (place, 2)
        From where the distances count.
    """

    rows: Values
    centres: Values


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemRequest:
    """A run of a rotor system, in coordinates with a unit mass matrix.

    Parameters
    ----------
    stiffness, damping, gyroscopic, stiffness_rate : ndarray, shape (n, n)
        Matrices; None where there are none.
    rows : ndarray, shape (contact, 2, n)
        Displacements of the contacts.
    unbalance : ndarray, shape (2, n)
        Unbalance, by the cosine and the sine of the angle.
    force : ndarray, shape (n,)
        Constant force.
    laws : ndarray of LAW
        The law of each contact.
    races : ndarray, shape (contact,)
        Speed of each race at time 0.
    pieces : ndarray of PIECE
        How the speed changes.
    speed : float
        Speed at time 0, if a torque drives it.
    inertia : float
        Moment of inertia about the axis of rotation, if a torque drives the rotor.
    weight : tuple of float
        Moment of the unbalance's weight about that axis, by the cosine of the angle and by minus
        its sine.
    standing : float
        Speed below which a rotor that a torque drives stands; 0 if that is not asked.
    rtol : float
        Tolerance of one step.
    order : int
        Order of the Taylor series.
    only_events : bool
        Whether energies, episodes and peaks are left out.
    displacement, velocity, fastest : float
        By which errors are measured; and the largest rate of the system without contacts.
    start : ndarray, shape (2, n)
        Displacement and velocity at time 0.
    times : ndarray
        Times of samples; the last is the end.
    duration : float
        The end.
    massless : int
        How many of the coordinates, the last, are of stators without mass.
    columns : ndarray, shape (column, 2 n + contact), optional
        Small changes of the start, whose course is wanted: of displacements, velocities and speeds
        of races. At a prescribed speed, and without stators without mass; by Taylor series.
    parameters : sequence of ByParameter
        Parameters that change beside, each alone with one of the last columns.
    watched : ndarray, shape (row, n), optional
        Rows by which samples see the columns.
    method : {"taylor", "adams", "bdf"}
        Solver while a contact touches. Flight, a linear motion, is always by Taylor series.
    places : Places, optional
        Of which the extrema of the distances are wanted.
    films : Films, optional
        Bearings whose coefficients depend on the speed.
    """

    stiffness: Values
    damping: Values | None
    gyroscopic: Values | None
    stiffness_rate: Values | None
    rows: Values
    unbalance: Values
    force: Values
    laws: Rows
    races: Values
    pieces: Rows
    speed: float
    inertia: float
    weight: tuple[float, float]
    standing: float
    rtol: float
    order: int
    only_events: bool = False
    displacement: float
    velocity: float
    fastest: float
    start: Values
    times: Values
    duration: float
    massless: int = 0
    columns: Values | None = None
    parameters: Sequence[ByParameter] = ()
    watched: Values | None = None
    method: str = "taylor"
    places: Places | None = None
    films: Films = NO_FILMS


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemResult:
    """What the core reports of a run.

    Parameters
    ----------
    status : int
        How it ended.
    time : float
        Where it ended.
    state : ndarray, shape (2, n)
        The state there.
    touches : ndarray of TOUCH
        How each contact was then.
    samples : ndarray, shape (sample, 2, n)
        Displacement and velocity.
    forces : ndarray, shape (sample, contact, 4)
        Normal and tangential force, slip speed, mode.
    turns : ndarray, shape (sample, 2)
        Angle and speed.
    event_times, event_kinds, event_contacts, event_turns : ndarray
        The events.
    event_states : ndarray, shape (event, 2, n)
        Displacement and velocity at events.
    event_races : ndarray, shape (event, contact)
        Speeds of races.
    event_rates : ndarray, shape (event,)
        How fast the guard of each event changes: the radius at an entry or exit, the radial
        velocity at a press or release, the slip, or the tangential force that is left at a slip.
        Infinite where another event or a jump of the acceleration brings it about; NaN by the
        plain-Python witness.
    races : ndarray of RACE, shape (contact,)
        The extreme speeds of races.
    episodes : ndarray of EPISODE
        Contacts that ended, in the order of their ends; then those that last.
    ledger : dict
        Energies gained and lost.
    steps : int
        Steps taken.
    turn : tuple of float
        Angle and speed at the end.
    standstill : Standstill
        Whether a driven rotor stands at the end.
    columns : ndarray, shape (column, 2 n + contact)
        What the changes of the start have become.
    sample_columns : ndarray, shape (sample, row, column)
        What was watched of them at samples.
    event_columns : ndarray, shape (event, 2, column)
        Displacements of the contacts at their events.
    extrema : ndarray of EXTREMUM_OF_PLACE
        The extrema of the distances of places, and these at both ends; place by place, by time.
    """

    status: int
    time: float
    state: Values
    touches: Rows
    samples: Values
    forces: Values
    turns: Values
    event_times: Values
    event_kinds: npt.NDArray[np.int32]
    event_contacts: npt.NDArray[np.int32]
    event_turns: Values
    event_states: Values
    event_races: Values
    event_rates: Values
    races: Rows
    episodes: Rows
    ledger: dict[str, float]
    steps: int
    turn: tuple[float, float]
    standstill: Standstill
    columns: Values = field(default_factory=lambda: np.empty((0, 0)))
    sample_columns: Values = field(default_factory=lambda: np.empty((0, 0, 0)))
    event_columns: Values = field(default_factory=lambda: np.empty((0, 2, 0)))
    extrema: Rows = field(default_factory=lambda: np.empty(0, EXTREMUM_OF_PLACE))


class SystemEvents(NamedTuple):
    """The events of a run up to a time; the fields of `SystemResult`."""

    time: float
    event_times: Values
    event_kinds: npt.NDArray[np.int32]
    event_contacts: npt.NDArray[np.int32]


@cache
def _library() -> ctypes.CDLL:
    core = found.library("whole")
    counts = {"stride": 1, "room": 2, "cvode_room": 2, "column_room": 3, "bearing_room": 2}
    for name, count in counts.items():
        function = getattr(core, f"core_system_{name}")
        function.restype, function.argtypes = c_int64, count * [c_int64]
    core.core_system_run.restype = c_int
    core.core_system_run.argtypes = [ctypes.POINTER(SystemRunStruct)]
    return core


@dataclass(slots=True)
class _Tables:
    """The tables of events, episodes and extrema, which grow."""

    width: int
    columns: int
    first: int
    places: int
    room: int = 0
    arrays: dict[str, npt.NDArray[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.room = self.first
        self.arrays = {
            "event_times": np.empty(self.room),
            "event_states": np.empty((self.room, self.width)),
            "event_turns": np.empty((self.room, 2)),
            "event_columns": np.empty((self.room, 2, self.columns)),
            "event_rates": np.empty(self.room),
            "event_kinds": np.empty(self.room, np.int32),
            "event_contacts": np.empty(self.room, np.int32),
            "episodes": np.empty(self.room, EPISODE),
            "extrema": np.empty((self.room, self.places), EXTREMUM_OF_PLACE),
        }

    def grow(self, run: SystemRunStruct) -> None:
        """Give a run room for as many events again as it began with; double the tables for it."""
        self.room += self.first
        for name, array in self.arrays.items():
            if self.room > len(array):
                larger = np.empty((2 * len(array), *array.shape[1:]), array.dtype)
                larger[: len(array)] = array
                self.arrays[name] = larger
        self.put(run)

    def events(self, run: SystemRunStruct) -> SystemEvents:
        """Return the events of a run so far."""
        columns = [self.arrays[name][: run.events] for name in SystemEvents._fields[1:]]
        return SystemEvents(run.time, *columns)

    def put(self, run: SystemRunStruct) -> None:
        """Give the tables to a run."""
        for name, array in self.arrays.items():
            setattr(run, name, pointer(array, array.dtype, writeable=True))
        run.event_room = run.episode_room = self.room
        run.extremum_room = self.room * self.places


def _stacked(*tables: Rows) -> Rows:
    """Return tables of the same type, one below the other.

    Without a place for the result, `numpy.concatenate` compares their types field by field.
    """
    stacked = np.empty(sum(map(len, tables)), tables[0].dtype)
    return np.concatenate(tables, out=stacked)


def _skew_part(stiffness: Values) -> Values | None:
    """Return the part of a stiffness that has no potential; None where there is none."""
    skew = 0.5 * (stiffness - stiffness.T)
    rounded = SYMMETRIC * float(np.abs(stiffness).max(initial=0.0))
    return skew if np.abs(skew).max(initial=0.0) > rounded else None


class _Run:
    """A run in the form that the core expects, with the arrays that it reads and fills.

    Those of coordinates are padded to a whole number of vectors.
    """

    def __init__(self, core: ctypes.CDLL, request: SystemRequest, stop: Stop) -> None:
        self.size, count = len(request.force), len(request.laws)
        self.laws = request.laws
        self.stride = core.core_system_stride(self.size)
        self.kept: list[npt.NDArray[Any]] = []  # must live as long as the run
        sampled, room = request.times.size, core.core_system_room(self.size, count)
        self.touches, self.opened = np.zeros(count, TOUCH), np.zeros(count, EPISODE)
        self.touches["race"] = request.races
        self.races = np.zeros(count, RACE)
        self.state = self.wide(request.start)
        self.samples = np.zeros((sampled, 2, self.stride))
        self.forces, self.turns = np.zeros((sampled, count, FORCES)), np.zeros((sampled, 2))
        self.column_count = 0 if request.columns is None else len(request.columns)
        beside = -(-self.column_count // EIGHT) * EIGHT
        watched = np.empty((0, self.size)) if request.watched is None else request.watched
        self.sample_columns = np.zeros((sampled, len(watched), beside))
        rows, centres = request.places or (np.empty((0, 2, self.size)), np.empty((0, 2)))
        self.places, self.place_rows = np.zeros(len(rows), PLACE), self.wide(rows)
        self.places["centre"] = centres
        first = max(FIRST_ROOM, 4 * count + 4)
        self.tables = _Tables(2 * self.stride + count, beside, first, len(rows))
        of_same_name = (
            "massless", "inertia", "rtol", "displacement", "velocity", "fastest", "order",
            "only_events", "duration", "speed",
        )  # fmt: skip
        self.begun = self.distances()
        self.struct = SystemRunStruct(
            **{name: getattr(request, name) for name in of_same_name},
            weight=(2 * c_double)(*request.weight),
            standstill=(len(Standstill._fields) * c_double)(*Standstill(request.standing)),
            size=self.size, stride=self.stride, contact_count=count, **self.matrices(request),
            unbalance=self.read(self.wide(request.unbalance)),
            force=self.read(self.wide(request.force)), rows=self.read(self.wide(request.rows)),
            laws=self.read(request.laws), touches=self.filled(self.touches),
            pieces=self.read(np.ascontiguousarray(request.pieces, PIECE)),
            piece_count=len(request.pieces), stop=self.read(stop), state=self.filled(self.state),
            sample_times=self.read(np.ascontiguousarray(request.times)), sample_count=sampled,
            samples=self.filled(self.samples), sample_forces=self.filled(self.forces),
            sample_turns=self.filled(self.turns), open=self.filled(self.opened),
            races=self.filled(self.races), room=self.filled(np.zeros(room)),
            watched=self.read(self.wide(watched)), watched_count=len(watched),
            sample_columns=self.filled(self.sample_columns),
            place_rows=self.read(self.place_rows), places=self.filled(self.places),
            place_count=len(rows),
        )  # fmt: skip
        if request.method != "taylor":
            self.struct.method = METHODS[request.method]
            self.struct.sundials = ctypes.cast(ctypes.pointer(sundials.functions()), c_void_p)
            room = core.core_system_cvode_room(self.size, count)
            self.struct.cvode_room = self.filled(np.zeros(room))
        self.columns = self.changes(core, request)
        self.tables.put(self.struct)
        if request.films:
            each = zip(request.films.bearings, request.films.rows, strict=True)
            found = [self.bearing(bearing, rows, request) for bearing, rows in each]
            self.kept_bearings = (_BearingStruct * len(found))(*found)
            self.struct.bearings = ctypes.cast(self.kept_bearings, c_void_p)
            self.struct.bearing_count = len(found)
            room = core.core_system_bearing_room(len(found), beside)
            self.struct.bearing_room = self.filled(np.zeros(room))

    def read(self, values: npt.NDArray[Any]) -> c_void_p:
        """Keep an array that the core reads, and return its address."""
        self.kept.append(values)
        return pointer(values, values.dtype)

    def filled(self, values: npt.NDArray[Any]) -> c_void_p:
        """Keep an array that the core fills, and return its address."""
        self.kept.append(values)
        return pointer(values, values.dtype, writeable=True)

    def wide(self, values: Values) -> Values:
        """Return rows of coordinates, padded."""
        wide = np.zeros((*values.shape[:-1], self.stride))
        wide[..., : self.size] = values
        return wide

    def matrices(self, request: SystemRequest) -> dict[str, c_void_p | None]:
        """Return the addresses of the matrices, column by column."""
        matrices = {
            "stiffness": request.stiffness,
            "damping": request.damping,
            "gyroscopic": request.gyroscopic,
            "stiffness_rate": request.stiffness_rate,
            "circulation": _skew_part(request.stiffness),
        }
        return {
            name: None if matrix is None else self.read(self.wide(matrix.T))
            for name, matrix in matrices.items()
        }

    def changes(self, core: ctypes.CDLL, request: SystemRequest) -> Values:
        """Give small changes of the start to the run; return what they become, column by column."""
        long, count = 2 * self.size + len(request.laws), len(request.laws)
        changes = np.empty((0, long)) if request.columns is None else request.columns
        beside = np.zeros((long, self.tables.columns))
        beside[:, : len(changes)] = changes.T
        if len(changes):
            if request.massless or request.pieces["inverse_inertia"].any():
                raise ValueError("columns need a prescribed speed, and stators with mass")
            wanted = core.core_system_column_room(self.size, count, beside.shape[1])
            self.struct.column_count, self.struct.columns = beside.shape[1], self.filled(beside)
            self.struct.column_room = self.filled(np.zeros(wanted))
            self.struct.parameter_count = len(request.parameters)
            self.struct.first_of_parameters = len(changes) - len(request.parameters)
            self.kept_structs = (_ParameterStruct * len(request.parameters))(
                *map(self.parameter, request.parameters)
            )
            self.struct.parameters = ctypes.cast(self.kept_structs, c_void_p)
        return beside[:, : len(changes)]

    def bearing(self, bearing: Bearing, rows: Values, request: SystemRequest) -> _BearingStruct:
        """Return a bearing in the form that the core expects, at the first speed."""
        knots, first = bearing.knots, request.pieces[0]
        speed = request.speed if first["inverse_inertia"] else first["speed"]
        interval = int(np.searchsorted(knots, speed, side="right")) - 1
        # powers from the highest, interval, row, column: from 0, by interval, row by row
        both = (bearing.stiffness_cubics, bearing.damping_cubics)
        cubics = np.concatenate(both, axis=3)[::-1].transpose(1, 0, 2, 3)
        return _BearingStruct(
            self.read(self.wide(rows)), self.read(np.ascontiguousarray(knots)),
            self.read(np.ascontiguousarray(cubics)), knots.size,
            min(max(interval, 0), knots.size - 2),
        )  # fmt: skip

    def parameter(self, by: ByParameter) -> _ParameterStruct:
        """Return what a parameter changes, in the form that the core expects."""
        rows = {name: getattr(by, name) for name in ("unbalance", "force")} | {
            name: None if getattr(by, name) is None else getattr(by, name).T
            for name in ("mass", "stiffness", "damping")
        }
        return _ParameterStruct(
            speed=by.speed, laws=self.read(by.laws),
            **{name: None if each is None else self.read(self.wide(each))
               for name, each in rows.items()},
        )  # fmt: skip

    def distances(self) -> Values:
        """Return the distances of the places now."""
        return np.asarray(np.hypot(*(self.place_rows @ self.state[0] - self.places["centre"]).T))

    def extrema(self) -> Rows:
        """Return the extrema of the distances of places, with both ends."""
        if not len(self.places):
            return self.places["last"]
        ends = np.zeros((2, len(self.places)), EXTREMUM_OF_PLACE)
        ends["place"], ends["distance"] = (
            np.arange(len(self.places)),
            (self.begun, self.distances()),
        )
        ends["time"][1] = self.struct.time
        table = self.tables.arrays["extrema"].reshape(-1)[: self.struct.extremum_count]
        last = self.places["last"][self.places["last"]["kind"] != 0]
        rows = _stacked(ends[0], table, last, ends[1])
        return rows[np.argsort(rows["place"], kind="stable")]

    def episodes(self, found: Rows) -> Rows:
        """Return episodes by roots of indentations, where the core has these of linear springs."""
        springs = (self.laws["hertz"] == 0.0) & (self.laws["clearance"] > 0.0)
        linear = springs[found["contact"].astype(int)]
        found["peak_root"][linear] = np.sqrt(found["peak_root"][linear])
        return found

    def result(self, status: int) -> SystemResult:
        """Return the result of the run."""
        run, held, size = self.struct, self.tables.arrays, self.size
        events, ledger = run.events, dict(zip(LEDGER, run.ledger, strict=True))
        lasting = self.opened[self.touches["mode"] != 0] if status == DONE else self.opened[:0]
        states, races = np.split(held["event_states"][:events], [2 * self.stride], axis=1)
        return SystemResult(
            status=status, time=run.time, state=self.state[:, :size], touches=self.touches,
            samples=self.samples[:, :, :size], forces=self.forces, turns=self.turns,
            event_times=held["event_times"][:events].copy(),
            event_kinds=held["event_kinds"][:events],
            event_contacts=held["event_contacts"][:events],
            event_turns=held["event_turns"][:events],
            event_rates=held["event_rates"][:events],
            event_states=states.reshape(events, 2, self.stride)[:, :, :size], event_races=races,
            races=self.races,
            episodes=self.episodes(_stacked(held["episodes"][: run.episode_count], lasting)),
            ledger=ledger, steps=run.steps, turn=(run.angle, run.speed),
            standstill=Standstill(*run.standstill), columns=self.columns.T,
            sample_columns=self.sample_columns[:, :, : self.column_count],
            event_columns=held["event_columns"][:events, :, : self.column_count],
            extrema=self.extrema(),
        )  # fmt: skip


def follow_system(
    request: SystemRequest,
    stop: Stop = NO_STOP,
    watch: Watch | None = None,
    is_enough: Callable[[SystemEvents], bool] | None = None,
) -> SystemResult:
    """Return the run of a rotor system; `watch` gets a function that returns how far it is.

    A run ends early where `is_enough` says so, which is asked after each few hundred events.
    """
    core = _library()
    run = _Run(core, request, stop)
    if watch is not None:
        watch.append(lambda: run.struct.time)  # which the core updates
    while (status := core.core_system_run(byref(run.struct))) == FULL:
        if is_enough is not None and is_enough(run.tables.events(run.struct)):
            status = DONE
            break
        run.tables.grow(run.struct)
    return run.result(status)
