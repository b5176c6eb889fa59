"""One run of a rotor system by the core: the structures of ``system.h``, and its call."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import Structure, byref, c_double, c_int, c_int32, c_int64, c_void_p
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.core import library as found
from rotor_ida.core import sundials
from rotor_ida.core.interface import DONE, FULL, METHODS, pointer
from rotor_ida.core.runs import NO_STOP, PIECE, Rows
from rotor_ida.core.system_requests import (
    EPISODE,
    EXTREMUM_OF_PLACE,
    FORCES,
    LEDGER,
    RACE,
    TOUCH,
    ByParameter,
    Standstill,
    SystemEvents,
    SystemRequest,
    SystemResult,
)
from rotor_ida.model.bearing import Bearing

FIRST_ROOM = 256
EIGHT = 8  # columns of a vector
# A skew part of a stiffness below this part of it is rounding.
SYMMETRIC = 1e-12
PLACE = np.dtype([("centre", np.float64, 2), ("sign", np.float64), ("last", EXTREMUM_OF_PLACE)])


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
