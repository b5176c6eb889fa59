"""One run of a rotor system by the core: the structures of ``system.h``, and its call."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import Structure, byref, c_double, c_int, c_int32, c_int64, c_void_p
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.core import library as found
from rotor_ida.core.interface import DONE, FULL, pointer
from rotor_ida.core.runs import NO_STOP, PIECE, Rows

FIRST_ROOM = 256
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
    ]
)  # fmt: skip
TOUCH = np.dtype(
    [
        *((name, np.float64) for name in ("root", "race", "sense")),
        ("way", np.int32),
        ("zeros", np.int32, 3),
    ]
)
EPISODE = np.dtype(
    [
        (name, np.float64)
        for name in (
            "contact", "entry", "exit", "peak_root", "peak_time", "largest_force", "force_time",
            "impulse", "work", "heat", "slip_distance", "rolling_time",
        )
    ]
)  # fmt: skip
# The extreme speeds of a race, and their times.
RACE = np.dtype(
    [(name, np.float64) for name in ("largest", "largest_time", "smallest", "smallest_time")]
)
LEDGER = ("unbalance", "damping", "stiffness_rate", "normal", "tangential")


class SystemRunStruct(Structure):
    """``struct system_run``."""

    _fields_ = [
        *((name, c_int64) for name in ("size", "stride", "contact_count", "massless")),
        *((name, c_void_p) for name in (
            "stiffness", "damping", "gyroscopic", "stiffness_rate", "circulation", "unbalance",
            "force", "rows", "laws", "touches", "pieces",
        )),
        *((name, c_int64) for name in ("piece_count", "piece")),
        *((name, c_double) for name in ("inertia", "rtol", "displacement", "velocity", "fastest")),
        *((name, c_int64) for name in ("order", "only_events")),
        ("duration", c_double),
        ("stop", c_void_p),
        *((name, c_double) for name in ("time", "speed", "angle", "piece_time", "piece_angle")),
        ("state", c_void_p),
        ("ledger", len(LEDGER) * c_double),
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
        *((name, c_void_p) for name in ("columns", "column_room")),
    ]  # fmt: skip


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
        of races. At a constant speed, and without stators without mass.
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
    columns : ndarray, shape (column, 2 n + contact)
        What the changes of the start have become.
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
    races: Rows
    episodes: Rows
    ledger: dict[str, float]
    steps: int
    turn: tuple[float, float]
    columns: Values = field(default_factory=lambda: np.empty((0, 0)))


class SystemEvents(NamedTuple):
    """The events of a run up to a time; the fields of `SystemResult`."""

    time: float
    event_times: Values
    event_kinds: npt.NDArray[np.int32]
    event_contacts: npt.NDArray[np.int32]


@cache
def _library() -> ctypes.CDLL:
    core = found.library("whole")
    core.core_system_room.restype = c_int64
    core.core_system_room.argtypes = [c_int64, c_int64]
    core.core_system_column_room.restype = c_int64
    core.core_system_column_room.argtypes = [c_int64, c_int64, c_int64]
    core.core_system_run.restype = c_int
    core.core_system_run.argtypes = [ctypes.POINTER(SystemRunStruct)]
    return core


@dataclass(slots=True)
class _Tables:
    """The tables of events and episodes, which grow."""

    width: int
    first: int
    room: int = 0
    arrays: dict[str, npt.NDArray[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.room = self.first
        self.arrays = {
            "event_times": np.empty(self.room),
            "event_states": np.empty((self.room, self.width)),
            "event_turns": np.empty((self.room, 2)),
            "event_kinds": np.empty(self.room, np.int32),
            "event_contacts": np.empty(self.room, np.int32),
            "episodes": np.empty(self.room, EPISODE),
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


def _skew_part(stiffness: Values) -> Values | None:
    """Return the part of a stiffness that has no potential; None where there is none."""
    skew = 0.5 * (stiffness - stiffness.T)
    rounded = SYMMETRIC * float(np.abs(stiffness).max(initial=0.0))
    return skew if np.abs(skew).max(initial=0.0) > rounded else None


def follow_system(
    request: SystemRequest,
    stop: Stop = NO_STOP,
    watch: Watch | None = None,
    is_enough: Callable[[SystemEvents], bool] | None = None,
) -> SystemResult:
    """Return the run of a rotor system; `watch` gets a function that returns how far it is.

    A run ends early where `is_enough` says so, which is asked after each few hundred events.
    """
    core, size = _library(), len(request.force)
    stride, count = -(-size // 4) * 4, len(request.laws)
    keep: list[npt.NDArray[Any]] = []

    def given(values: npt.NDArray[Any] | None, *, writeable: bool = False) -> c_void_p | None:
        if values is None:
            return None
        keep.append(values)
        return pointer(values, values.dtype, writeable=writeable)

    def padded(values: Values | None, shape: tuple[int, ...] = ()) -> Values | None:
        if values is None:
            return None
        wide = np.zeros((*(shape or values.shape[:-1]), stride))
        wide[..., :size] = values
        return wide

    def by_columns(matrix: Values | None) -> Values | None:
        return None if matrix is None else padded(np.ascontiguousarray(matrix.T))

    touches, opened = np.zeros(count, TOUCH), np.zeros(count, EPISODE)
    races = np.zeros(count, RACE)
    touches["race"] = request.races
    state = padded(request.start)
    assert state is not None
    samples = np.zeros((request.times.size, 2, stride))
    forces, turns = np.zeros((request.times.size, count, FORCES)), np.zeros((request.times.size, 2))
    tables = _Tables(2 * stride + count, max(FIRST_ROOM, 4 * count + 4))
    run = SystemRunStruct(
        size=size, stride=stride, contact_count=count, massless=request.massless,
        stiffness=given(by_columns(request.stiffness)), damping=given(by_columns(request.damping)),
        gyroscopic=given(by_columns(request.gyroscopic)),
        stiffness_rate=given(by_columns(request.stiffness_rate)),
        circulation=given(by_columns(_skew_part(request.stiffness))),
        unbalance=given(padded(request.unbalance)), force=given(padded(request.force)),
        rows=given(padded(request.rows)), laws=given(request.laws),
        touches=given(touches, writeable=True),
        pieces=given(np.ascontiguousarray(request.pieces, PIECE)), piece_count=len(request.pieces),
        inertia=request.inertia, rtol=request.rtol, displacement=request.displacement,
        velocity=request.velocity, fastest=request.fastest, order=request.order,
        only_events=request.only_events,
        duration=request.duration, stop=given(stop), speed=request.speed,
        state=given(state, writeable=True),
        sample_times=given(np.ascontiguousarray(request.times)),
        samples=given(samples, writeable=True), sample_forces=given(forces, writeable=True),
        sample_turns=given(turns, writeable=True), sample_count=request.times.size,
        open=given(opened, writeable=True), races=given(races, writeable=True),
        room=given(np.zeros(core.core_system_room(size, count)), writeable=True),
    )  # fmt: skip
    changes = np.empty((0, 2 * size + count)) if request.columns is None else request.columns
    beside = np.zeros((2 * size + count, -(-len(changes) // 4) * 4))
    beside[:, : len(changes)] = changes.T
    if len(changes):
        run.column_count, run.columns = beside.shape[1], given(beside, writeable=True)
        wanted = core.core_system_column_room(size, count, beside.shape[1])
        run.column_room = given(np.zeros(wanted), writeable=True)
    tables.put(run)
    if watch is not None:
        watch.append(lambda: run.time)  # which the core updates
    while (status := core.core_system_run(byref(run))) == FULL:
        if is_enough is not None and is_enough(tables.events(run)):
            status = DONE
            break
        tables.grow(run)
    events, held = run.events, tables.arrays
    lasting = opened[touches["way"] != 0] if status == DONE else opened[:0]
    states = held["event_states"][:events]
    return SystemResult(
        status=status, time=run.time, state=state[:, :size], touches=touches,
        samples=samples[:, :, :size], forces=forces, turns=turns,
        event_times=held["event_times"][:events].copy(), event_kinds=held["event_kinds"][:events],
        event_contacts=held["event_contacts"][:events], event_turns=held["event_turns"][:events],
        event_states=states[:, : 2 * stride].reshape(events, 2, stride)[:, :, :size],
        event_races=states[:, 2 * stride :], races=races,
        episodes=np.concatenate([held["episodes"][: run.episode_count], lasting]),
        ledger=dict(zip(LEDGER, run.ledger, strict=True)), steps=run.steps,
        turn=(run.angle, run.speed), columns=beside[:, : len(changes)].T,
    )  # fmt: skip
