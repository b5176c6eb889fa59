"""One run of the core: what is asked of it, and what came of it, in arrays that NumPy owns."""

from __future__ import annotations

import ctypes
import math
from ctypes import byref, c_int64, c_void_p
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.core import sundials
from rotor_ida.core.interface import (
    CONTACT_COLUMNS,
    EXTREMUM_COLUMNS,
    FULL,
    FULL_INSIDE,
    METHODS,
    PIECE_COLUMNS,
    STRETCH_COLUMNS,
    UNDECIDED,
    RotorStruct,
    RunStruct,
    address,
    library,
    library_of,
    pointer,
)
from rotor_ida.model.modes import WHOLE
from rotor_ida.model.parameters import Rotor
from rotor_ida.model.table import PARAMETERS

Stop = npt.NDArray[np.uint8]

FIRST_ROOM = 64
# Rows of a bundle of differences: of the state, and with those that the parameters add.
DIFFERENCES = 4
# By which parameters the core differentiates: in the paper's model by the first three.
COLUMNS = WHOLE.columns
NO_STOP: Stop = np.zeros(1, np.uint8)


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """What is asked of a run.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : sequence of float
        ``(x, y, vx, vy)`` at time 0 [1].
    duration : float
        Time to follow it for [1].
    rtol, atol : float
        Tolerances of one step [1].
    method : {"taylor", "adams", "bdf"}
        What leads it in contact, and in flight where that is not exact.
    exact_flight : bool
        Whether flight is in closed form.
    slack : float
        How far behind the end an event may lie and still be found [1].
    sample_times : ndarray, shape (n,), optional
        Times to report, increasing [1].
    fixed_axes : bool
        Whether samples, events and the last state are to be read on axes that stand still.
    events, extrema : bool
        Whether events and contacts, and the extrema of the radius, are recorded.
    bundle : ndarray, shape (4, 4) or (4 + n, 4), optional
        Differences from the motion, carried along in place; by Taylor series the last n rows become
        what the parameters add, by `COLUMNS`: three in the paper's model, eight in the whole [1].
    whole : bool
        Whether the core of the whole model follows it, even if the paper's would do.
    pieces : ndarray, shape (n, 6), optional
        How the speed changes, piece by piece: when it ends, its rate, or torque, slope and 1/j, and
        the speed with which a prescribed one begins [1]. Flight is led by Taylor series then.
    angle : float
        Where the unbalance is at time 0, if the speed changes [1].
    stop : ndarray of uint8, shape (1,)
        Anything but 0 asks the run to stop.
    """

    rotor: Rotor
    start: npt.ArrayLike
    duration: float
    rtol: float
    atol: float
    method: str = "taylor"
    exact_flight: bool = True
    slack: float = 0.0
    sample_times: Values | None = None
    fixed_axes: bool = False
    events: bool = False
    extrema: bool = False
    bundle: Values | None = None
    whole: bool = False
    pieces: Values | None = None
    angle: float = 0.0
    stop: Stop | None = None

    @property
    def columns(self) -> int:
        """How many parameters the core differentiates by."""
        return len(COLUMNS) if self.whole or self.rotor.beyond else len(PARAMETERS)


@dataclass(frozen=True, slots=True)
class Seen:
    """What came of a run. States are read on rotating axes, but for what was asked otherwise [1].

    Parameters
    ----------
    status : int
        0, or why it ended early.
    time : float
        When it ended [1].
    state : tuple of float
        The state there.
    began, where : int
        Whether it began, and ended, in contact or in flight.
    samples : ndarray, shape (n, 4)
        States at the sample times, as far as it came.
    event_times, event_kinds, event_states : ndarray
        The events.
    ways : ndarray, shape (m + 1,), optional
        With friction how the rotor moves from each event on, and first from its start, as
        `enum way` has it; None without.
    contacts : ndarray, shape (k, 9)
        Entry, exit and time of the peak, root of the largest indentation, impulse, angular momentum
        at the peak, energy lost by contact damping, with that the largest force, and the heat of
        sliding, of each contact; NaN where it has none within the run [1].
    extrema : ndarray, shape (m, 7)
        Time, radius, kind (-1 or 1) and state of each extremum of the radius.
    evaluations : int
        Evaluations of the right-hand side, or orders expanded.
    turn : tuple of float
        Angle and speed at the end, if the speed changes [1].
    sample_turns, event_turns : ndarray, shape (n, 2)
        The same at the samples and at the events.
    """

    status: int
    time: float
    state: tuple[float, float, float, float]
    began: int
    where: int
    samples: Values
    event_times: Values
    event_kinds: npt.NDArray[np.int8]
    event_states: Values
    ways: npt.NDArray[np.int8] | None
    contacts: Values
    extrema: Values
    evaluations: int
    turn: tuple[float, float]
    sample_turns: Values
    event_turns: Values


_NO_TIMES, _NO_STATES, _NO_TURNS = np.empty(0), np.empty((0, 4)), np.empty((0, 2))
_NO_CONTACTS, _NO_EXTREMA = np.empty((0, CONTACT_COLUMNS)), np.empty((0, EXTREMUM_COLUMNS))
_NO_KINDS = np.empty(0, np.int8)


class _Tables:
    """The tables of a run, and the structure that points at them."""

    def __init__(self, asked: Asked, room: int) -> None:
        self.run = run = _struct_of(asked)
        self.samples = self.event_states = _NO_STATES
        self.event_times, self.event_kinds = _NO_TIMES, _NO_KINDS
        self.event_ways = _NO_KINDS
        varied = asked.bundle is not None and len(asked.bundle) > DIFFERENCES
        self.slides = asked.rotor.friction > 0.0 or (varied and bool(asked.rotor.disc_radius))
        self.contacts, self.extrema = _NO_CONTACTS, _NO_EXTREMA
        self.sample_turns = self.event_turns = _NO_TURNS
        self.turns = asked.pieces is not None
        if asked.pieces is not None:
            self.pieces = np.ascontiguousarray(asked.pieces, np.float64)
            run.pieces, run.piece_count = address(self.pieces), len(self.pieces)
            run.angle = asked.angle
        if asked.sample_times is not None:
            # kept as long as the run
            self.sample_times = times = np.ascontiguousarray(asked.sample_times, np.float64)
            self.samples = np.empty((times.size, 4))
            run.sample_count = times.size
            run.sample_times, run.samples = address(times), address(self.samples)
            if self.turns:
                self.sample_turns = np.empty((times.size, 2))
                run.sample_turns = address(self.sample_turns)
        if asked.extrema:
            self.extrema = np.empty((2 * room, EXTREMUM_COLUMNS))
            run.extremum_room, run.extrema = 2 * room, address(self.extrema)
        if asked.events:
            self.widen(room)

    def widen(self, room: int) -> None:
        """Make room for so many events and half as many contacts."""
        run = self.run
        self.event_times = _longer(self.event_times, room)
        self.event_kinds = _longer(self.event_kinds, room)
        self.event_states = _longer(self.event_states, room)
        self.contacts = _longer(self.contacts, room // 2 + 1)
        run.event_room, run.contact_room = room, len(self.contacts)
        if self.slides:
            self.event_ways = _longer(self.event_ways, room)
            run.event_ways = address(self.event_ways)
        if self.turns:
            self.event_turns = _longer(self.event_turns, room)
            run.event_turns = address(self.event_turns)
        run.event_times, run.event_kinds = (
            address(self.event_times),
            address(self.event_kinds),
        )
        run.event_states, run.contacts = address(self.event_states), address(self.contacts)

    def seen(self, status: int) -> Seen:
        """Return what came of the run."""
        run = self.run
        x, y, vx, vy = run.state
        return Seen(
            status,
            run.time,
            (x, y, vx, vy),
            run.began,
            run.where,
            self.samples[: run.sampled],
            self.event_times[: run.events],
            self.event_kinds[: run.events],
            self.event_states[: run.events],
            self._ways(),
            self.contacts[: run.contact_count],
            self.extrema[: run.extremum_count],
            run.evaluations,
            (run.angle, run.rotor.omega),
            self.sample_turns[: run.sampled],
            self.event_turns[: run.events],
        )

    def _ways(self) -> npt.NDArray[np.int8] | None:
        """Return how the rotor moves from its start, and from each event on."""
        if not self.event_ways.size:
            return None
        began = np.array([self.run.way_began], np.int8)
        return np.concatenate([began, self.event_ways[: self.run.events]])


def follow(asked: Asked) -> Seen:
    """Follow a run from its start to its end; the status says if it could be followed."""
    core, room = library_of(asked.rotor, whole=asked.whole), FIRST_ROOM
    if asked.pieces is not None:
        core = library("run_up")
    tables, before = _Tables(asked, room), None if asked.bundle is None else asked.bundle.copy()
    status = core.core_run(byref(tables.run))
    while status in {FULL, FULL_INSIDE}:
        room *= 4
        full = tables.run.extremum_count == tables.run.extremum_room > 0
        if full or status == FULL_INSIDE:
            if asked.bundle is not None and before is not None:
                asked.bundle[:] = before
            tables = _Tables(asked, room)
        else:
            tables.widen(room)
        status = core.core_run(byref(tables.run))
    return tables.seen(status)


def stretch(asked: Asked, spans: int) -> tuple[Values, Seen]:
    """Follow a run over many spans of its duration, its bundle made orthonormal after each.

    Returns
    -------
    stretches : ndarray, shape (n, 5)
        Logarithms of the factors by which each span stretched the four differences, as far as it
        came, and of that by which reversals of sliding have changed their volume in it. Where the
        disc rolled the fourth is minus infinity: a direction is lost.
    seen : Seen
        What came of the last span.
    """
    if asked.bundle is None:
        raise ValueError("a stretching must have a bundle, got none")
    run, stretches, done = _struct_of(asked), np.empty((spans, STRETCH_COLUMNS)), c_int64(0)
    written = pointer(stretches, np.float64, writeable=True)
    status = library_of(asked.rotor).core_stretch(byref(run), spans, written, byref(done))
    x, y, vx, vy = run.state
    seen = Seen(
        status, run.time, (x, y, vx, vy), run.began, run.where, _NO_STATES, _NO_TIMES, _NO_KINDS,
        _NO_STATES, None, _NO_CONTACTS, _NO_EXTREMA, run.evaluations, (0.0, 0.0),
        _NO_TURNS, _NO_TURNS,
    )  # fmt: skip
    return stretches[: done.value], seen


def _struct_of(asked: Asked) -> RunStruct:
    """Return what is asked as the core takes it, with no tables."""
    x, y, vx, vy = _check(asked)
    run = RunStruct(
        rotor=RotorStruct.of(asked.rotor),
        rtol=asked.rtol,
        atol=asked.atol,
        duration=asked.duration,
        slack=asked.slack,
        method=METHODS[asked.method],
        fixed_axes=asked.fixed_axes,
        exact_flight=asked.exact_flight,
        stop=pointer(NO_STOP if asked.stop is None else asked.stop, np.uint8),
        where=UNDECIDED,
    )
    try:
        run.state = (x, y, vx, vy)
    except RuntimeError as error:  # by which ctypes tells of a type that is none of a number's
        raise TypeError(f"start must be four real numbers, got {asked.start!r}") from error
    if asked.method != "taylor":
        run.sundials = ctypes.cast(ctypes.pointer(sundials.functions()), c_void_p)
    if asked.bundle is not None:
        more = DIFFERENCES + asked.columns
        if asked.bundle.shape not in {(DIFFERENCES, 4), (more, 4)}:
            raise ValueError(f"a bundle must have 4 or {more} rows of 4, got {asked.bundle.shape}")
        if len(asked.bundle) > DIFFERENCES and asked.method != "taylor":
            raise ValueError(
                f"a bundle of {more} rows must be carried by taylor, got {asked.method!r}"
            )
        run.differences = len(asked.bundle)
        run.bundle = pointer(asked.bundle, np.float64, writeable=True)
    return run


def _check(asked: Asked) -> tuple[float, float, float, float]:
    """Return the start, or raise `ValueError` where the core would not know what to do."""
    start = asked.start if isinstance(asked.start, tuple) else np.asarray(asked.start).tolist()
    if not isinstance(start, tuple | list) or len(start) != 4:
        raise ValueError(f"start must be four numbers, got {asked.start!r}")
    x, y, vx, vy = start
    if not math.isfinite(asked.duration + asked.rtol + asked.atol + asked.slack):
        raise ValueError(f"durations and tolerances must be finite numbers, got {asked!r}")
    if not (asked.rtol > 0.0 and asked.atol > 0.0):
        raise ValueError(f"rtol and atol must be positive, got {asked.rtol} and {asked.atol}")
    if asked.method not in METHODS:
        raise ValueError(f"method must be one of {', '.join(METHODS)}, got {asked.method!r}")
    if asked.stop is not None and asked.stop.shape != (1,):
        raise ValueError(f"stop must be one number, got {asked.stop!r}")
    if asked.pieces is not None and asked.pieces.shape[1:] != (PIECE_COLUMNS,):
        raise ValueError(f"pieces must be rows of {PIECE_COLUMNS}, got {asked.pieces.shape}")
    if asked.pieces is not None and asked.bundle is not None:
        raise ValueError("a bundle must not be given with pieces")
    times = asked.sample_times
    if times is not None and times.ndim != 1:
        raise ValueError(f"sample times must be one row of numbers, got {times!r}")
    if times is not None and times.size and not times[-1] <= asked.duration:
        raise ValueError(f"sample times must lie within {asked.duration}, got {times[-1]}")
    return x, y, vx, vy


def _longer(table: npt.NDArray[np.generic], room: int) -> npt.NDArray:  # type: ignore[type-arg]
    """Return a table with more room, and what it held."""
    wide = np.empty((room, *table.shape[1:]), table.dtype)
    if len(table):
        wide[: len(table)] = table
    return wide


def fault_of(
    rotor: Rotor,
    began: int,
    samples: tuple[Values, Values],
    events: tuple[Values, npt.NDArray[np.int8], Values],
    contacts: Values,
    allowed: float,
    ways: npt.NDArray[np.int8] | None = None,
) -> tuple[int, int]:
    """Return the first fault of a run against the mechanics, by `FAULTS`, and its row.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    began : int
        Whether it began in contact.
    samples : tuple of ndarray
        Times and states of the samples, in either frame [1].
    events : tuple of ndarray
        Times, kinds and states of the events [1].
    contacts : ndarray, shape (k, 9)
        Entry, exit and time of the peak of each contact, and what follows these [1].
    allowed : float
        How far a sample may lie on the wrong side of the ring [1].
    ways : ndarray, shape (m + 1,), optional
        With friction how the rotor moves from its start, and from each event on.
    """
    run, row = RunStruct(rotor=RotorStruct.of(rotor), began=began), c_int64(0)
    kinds = [*2 * [np.float64], np.float64, np.int8, np.float64, np.float64]
    tables = [
        np.ascontiguousarray(table, dtype)
        for table, dtype in zip((*samples, *events, contacts), kinds, strict=True)
    ]
    rows = [*2 * [len(samples[0])], *3 * [len(events[0])], len(contacts)]
    wide = (1, 4, 1, 1, 4, CONTACT_COLUMNS)
    if any(table.size != n * m for table, n, m in zip(tables, rows, wide, strict=True)):
        raise ValueError(f"tables must fit together, got {[table.shape for table in tables]}")
    (
        run.sample_times,
        run.samples,
        run.event_times,
        run.event_kinds,
        run.event_states,
        run.contacts,
    ) = (address(table) for table in tables)
    if ways is not None:
        if ways.shape != (len(events[0]) + 1,):
            raise ValueError(f"tables must fit together, got {ways.shape} ways")
        later = np.ascontiguousarray(np.append(ways[1:], [0]), np.int8)
        run.way_began, run.event_ways = int(ways[0]), address(later)
    run.sampled, run.events, run.contact_count = len(samples[0]), len(events[0]), len(contacts)
    return int(library_of(rotor).core_fault(byref(run), allowed, byref(row))), row.value


def starts_in_contact(rotor: Rotor, state: npt.ArrayLike) -> bool:
    """Return whether a rotor at a state on the rotating axes begins in contact.

    On the ring the first of radial velocity, acceleration and jerk that is not zero decides.
    """
    given, held = _four_numbers(state), RotorStruct.of(rotor)
    return bool(library_of(rotor).core_starts_in_contact(byref(held), pointer(given, np.float64)))


def _four_numbers(state: npt.ArrayLike) -> Values:
    given = np.ascontiguousarray(state, dtype=np.float64)
    if given.shape != (4,):
        raise ValueError(f"a state must be four numbers, got {state!r}")
    return given


def fly(rotor: Rotor, states: npt.ArrayLike, spans: npt.ArrayLike) -> Values:
    """Return the states that follow on some after flights without contact, shape (n, 4) [1].

    They are read on the rotating axes of their times.
    """
    times = np.atleast_1d(np.asarray(spans, dtype=np.float64))
    begun = np.empty((times.size, 4))
    begun[:] = states
    times, reached = np.ascontiguousarray(times), np.empty((times.size, 4))
    held = RotorStruct.of(rotor)
    library_of(rotor).core_fly(
        byref(held),
        pointer(begun, np.float64),
        pointer(times, np.float64),
        pointer(reached, np.float64, writeable=True),
        times.size,
    )
    return reached


def first_touch(
    rotor: Rotor, state: npt.ArrayLike, limit: float, stop: Stop | None = None
) -> float:
    """Return the time to the first touch of the ring from a state in flight, or infinity [1].

    It is NaN where the search gets nowhere.
    """
    given, held = _four_numbers(state), RotorStruct.of(rotor)
    asked = pointer(NO_STOP if stop is None else stop, np.uint8)
    core = library_of(rotor)
    return float(core.core_first_touch(byref(held), pointer(given, np.float64), limit, asked))


def rotate(states: Values, times: Values, omega: float) -> None:
    """Turn each row of ``(x, y, vx, vy)`` by the angle omega t, in its place."""
    if states.shape != (times.size, 4):
        raise ValueError(f"a time must come with each state, got {states.shape} and {times.shape}")
    given = np.ascontiguousarray(times)
    into = pointer(states, np.float64, writeable=True)
    library().core_rotate(into, pointer(given, np.float64), omega, given.size)
