"""One run of the core: its request, and its result, in arrays that NumPy owns."""

from __future__ import annotations

import ctypes
import math
from ctypes import byref, c_int64, c_void_p
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.core import sundials
from rotor_ida.core.interface import (
    FULL,
    FULL_INSIDE,
    METHODS,
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
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.model.rotor import Rotor

Rows = npt.NDArray[np.void]

FIRST_ROOM = 64
# Rows of a bundle of differences: of the state, and with those by the parameters.
DIFFERENCES = 4
# Parameters by which the core differentiates: in the paper's model the first three.
COLUMNS = WHOLE.columns
NO_STOP: Stop = np.zeros(1, np.uint8)


def rows_of_numbers(*names: str) -> np.dtype[np.void]:
    """Return the type of rows of numbers by these names."""
    return np.dtype([(name, np.float64) for name in names])


# Rows as the core writes and reads them: `struct contact`, with the root of the largest
# indentation, and entry or exit NaN if outside the run; `struct extremum` of the radius,
# a maximum (1) or a minimum (-1); `struct piece`, a piece of a speed profile up to its end; and
# angle and speed of a rotor whose speed changes.
CONTACT = rows_of_numbers(
    "entry", "exit", "peak_time", "peak_root", "impulse", "momentum", "lost", "largest_force",
    "heat", "slip_distance",
)  # fmt: skip
EXTREMUM = np.dtype(
    [
        ("time", np.float64),
        ("radius", np.float64),
        ("kind", np.float64),
        ("state", np.float64, 4),
    ]
)
PIECE = rows_of_numbers("end", "rate", "torque", "slope", "inverse_inertia", "speed")
SPIN = rows_of_numbers("angle", "speed")


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRequest:
    """A run for the core to simulate.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : sequence of float
        ``(x, y, vx, vy)`` at time 0 [dimensionless].
    duration : float
        Time to simulate [dimensionless].
    rtol, atol : float
        Tolerances of one step [dimensionless].
    method : {"taylor", "adams", "bdf"}
        Solver in contact, and in flight if that is not exact.
    exact_flight : bool
        Whether flight is in closed form.
    slack : float
        How far after the end an event may lie and still be found [dimensionless].
    sample_times : ndarray, shape (n,), optional
        Times to report, increasing [dimensionless].
    fixed_axes : bool
        Whether samples, events and the last state are given on fixed axes.
    events, extrema : bool
        Whether events and contacts, and the extrema of the radius, are recorded.
    bundle : ndarray, shape (4, 4) or (4 + n, 4), optional
        Differences from the motion, integrated in place; with Taylor series the last n rows become
        the derivatives by `COLUMNS`: three in the paper's model, eight in the whole one
        [dimensionless].
    whole : bool
        Whether to use the core of the whole model even if the paper's would do.
    pieces : ndarray of `PIECE`, optional
        Pieces of the speed profile [dimensionless]: each has a prescribed initial speed and rate,
        or a torque. Flight is then integrated by Taylor series.
    angle : float
        Angle of the unbalance at time 0, if the speed changes [dimensionless].
    most_steps : int
        The run may take no more steps than this, where a flight in closed form is one; 0 for any
        number.
    stop : ndarray of uint8, shape (1,)
        Stops the run as soon as it is not 0.
    watch : list of callable, optional
        Receives a function that returns the time that the run has reached [dimensionless].
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
    pieces: Rows | None = None
    angle: float = 0.0
    most_steps: int = 0
    stop: Stop | None = None
    watch: Watch | None = None

    @property
    def columns(self) -> int:
        """Number of parameters by which the core differentiates."""
        return len(COLUMNS) if self.whole or self.rotor.beyond else len(PARAMETERS)


@dataclass(frozen=True, slots=True)
class RunResult:
    """The result of a run. States are on rotating axes, unless fixed axes were requested [1].

    Parameters
    ----------
    status : int
        0, or the code of an early end.
    time : float
        Time of the end [dimensionless].
    state : tuple of float
        The state there.
    began, where : int
        Whether it began, and ended, in contact or in flight.
    samples : ndarray, shape (n, 4)
        States at the sample times up to the end.
    event_times, event_kinds, event_states : ndarray
        The events.
    modes : ndarray, shape (m + 1,), optional
        Mode from the start, and from each event on, as in `enum contact_mode`; None without
        friction.
    contacts : ndarray of `CONTACT`
        The contacts [dimensionless].
    extrema : ndarray of `EXTREMUM`
        The extrema of the radius [dimensionless].
    evaluations : int
        Evaluations of the right-hand side, or orders expanded.
    steps : int
        Steps taken.
    end_spin : ndarray of `SPIN`, shape ()
        Angle and speed at the end, if the speed changes [dimensionless].
    sample_spins, event_spins : ndarray of `SPIN`
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
    modes: npt.NDArray[np.int8] | None
    contacts: Rows
    extrema: Rows
    evaluations: int
    steps: int
    end_spin: Rows
    sample_spins: Rows
    event_spins: Rows


NO_EXTREMA = np.empty(0, EXTREMUM)


class _Tables:
    """The tables of a run, and the structure that points to them."""

    def __init__(self, request: RunRequest, room: int) -> None:
        self.run = run = _struct_of(request)
        self.samples = self.event_states = np.empty((0, 4))
        self.event_times, self.event_kinds = np.empty(0), np.empty(0, np.int8)
        self.event_modes = self.event_kinds
        varied = request.bundle is not None and len(request.bundle) > DIFFERENCES
        self.slides = request.rotor.friction > 0.0 or (varied and bool(request.rotor.disc_radius))
        self.contacts, self.extrema = np.empty(0, CONTACT), NO_EXTREMA
        self.sample_spins = self.event_spins = np.empty(0, SPIN)
        self.turns = request.pieces is not None
        if request.pieces is not None:
            self.pieces = np.ascontiguousarray(request.pieces)
            run.pieces, run.piece_count = address(self.pieces), len(self.pieces)
            run.angle = request.angle
        if request.sample_times is not None:
            # must live as long as the run
            self.sample_times = times = np.ascontiguousarray(request.sample_times, np.float64)
            self.samples = np.empty((times.size, 4))
            run.sample_count = times.size
            run.sample_times, run.samples = address(times), address(self.samples)
            if self.turns:
                self.sample_spins = np.empty(times.size, SPIN)
                run.sample_turns = address(self.sample_spins)
        if request.extrema:
            self.extrema = np.empty(2 * room, EXTREMUM)
            run.extremum_room, run.extrema = 2 * room, address(self.extrema)
        if request.events:
            self.widen(room)

    def widen(self, room: int) -> None:
        """Make room for `room` events and half as many contacts."""
        run = self.run
        self.event_times = _longer(self.event_times, room)
        self.event_kinds = _longer(self.event_kinds, room)
        self.event_states = _longer(self.event_states, room)
        self.contacts = _longer(self.contacts, room // 2 + 1)
        run.event_room, run.contact_room = room, len(self.contacts)
        if self.slides:
            self.event_modes = _longer(self.event_modes, room)
            run.event_modes = address(self.event_modes)
        if self.turns:
            self.event_spins = _longer(self.event_spins, room)
            run.event_turns = address(self.event_spins)
        run.event_times, run.event_kinds = address(self.event_times), address(self.event_kinds)
        run.event_states, run.contacts = address(self.event_states), address(self.contacts)

    def result(self, status: int) -> RunResult:
        """Return the result of the run."""
        run = self.run
        x, y, vx, vy = run.state
        return RunResult(
            status,
            run.time,
            (x, y, vx, vy),
            run.began,
            run.where,
            self.samples[: run.sampled],
            self.event_times[: run.events],
            self.event_kinds[: run.events],
            self.event_states[: run.events],
            self._modes(),
            self.contacts[: run.contact_count],
            self.extrema[: run.extremum_count],
            run.evaluations,
            run.steps,
            np.array((run.angle, run.rotor.omega), SPIN),
            self.sample_spins[: run.sampled],
            self.event_spins[: run.events],
        )

    def _modes(self) -> npt.NDArray[np.int8] | None:
        """Return the mode from the start, and from each event on."""
        if not self.event_modes.size:
            return None
        began = np.array([self.run.mode_began], np.int8)
        return np.concatenate([began, self.event_modes[: self.run.events]])


def follow_run(request: RunRequest) -> RunResult:
    """Simulate a run; the status of the result shows whether it failed."""
    core, room = library_of(request.rotor, whole=request.whole), FIRST_ROOM
    if request.pieces is not None:
        core = library("run_up")
    tables, bundle = _Tables(request, room), request.bundle
    before = None if bundle is None else bundle.copy()
    if request.watch is not None:
        request.watch.append(lambda: tables.run.time)  # which the core updates
    status = core.core_run(byref(tables.run))
    while status in {FULL, FULL_INSIDE}:
        room *= 4
        full = tables.run.extremum_count == tables.run.extremum_room > 0
        if full or status == FULL_INSIDE:
            if bundle is not None:
                bundle[:] = before
            tables = _Tables(request, room)
        else:
            tables.widen(room)
        status = core.core_run(byref(tables.run))
    return tables.result(status)


def stretch(request: RunRequest, spans: int) -> tuple[Values, RunResult]:
    """Simulate a run over many spans of its duration, orthonormalising its bundle after each.

    Returns
    -------
    stretches : ndarray, shape (n, 5)
        Logarithms of the factors by which each completed span stretched the four differences, and
        of the factor by which reversals of sliding changed their volume. Where the disc rolled the
        fourth is minus infinity, as one direction is lost.
    result : RunResult
        The result of the last span.
    """
    if request.bundle is None:
        raise ValueError("a stretching must have a bundle, got none")
    tables, stretches, done = _Tables(request, 0), np.empty((spans, STRETCH_COLUMNS)), c_int64(0)
    written = pointer(stretches, np.float64, writeable=True)
    core = library_of(request.rotor)
    status = core.core_stretch(byref(tables.run), spans, written, byref(done))
    return stretches[: done.value], tables.result(status)


def _struct_of(request: RunRequest) -> RunStruct:
    """Return a request in the form that the core expects, without tables."""
    x, y, vx, vy = _check(request)
    run = RunStruct(
        rotor=RotorStruct.of(request.rotor),
        rtol=request.rtol,
        atol=request.atol,
        duration=request.duration,
        slack=request.slack,
        method=METHODS[request.method],
        fixed_axes=request.fixed_axes,
        exact_flight=request.exact_flight,
        most_steps=request.most_steps,
        stop=pointer(NO_STOP if request.stop is None else request.stop, np.uint8),
        where=UNDECIDED,
    )
    run.state = (x, y, vx, vy)
    if request.method != "taylor":
        run.sundials = ctypes.cast(ctypes.pointer(sundials.functions()), c_void_p)
    if request.bundle is not None:
        more = DIFFERENCES + request.columns
        if request.bundle.shape not in {(DIFFERENCES, 4), (more, 4)}:
            raise ValueError(
                f"a bundle must have 4 or {more} rows of 4, got {request.bundle.shape}"
            )
        if len(request.bundle) > DIFFERENCES and request.method != "taylor":
            raise ValueError(
                f"a bundle of {more} rows must be carried by taylor, got {request.method!r}"
            )
        run.differences = len(request.bundle)
        run.bundle = pointer(request.bundle, np.float64, writeable=True)
    return run


def _check(request: RunRequest) -> tuple[float, float, float, float]:
    """Return the start, or raise `ValueError` for numbers with which a run would not end."""
    x, y, vx, vy = np.asarray(request.start, np.float64).tolist()
    if not math.isfinite(request.duration + request.rtol + request.atol + request.slack):
        raise ValueError(f"durations and tolerances must be finite numbers, got {request!r}")
    if not (request.rtol > 0.0 and request.atol > 0.0):
        raise ValueError(f"rtol and atol must be positive, got {request.rtol} and {request.atol}")
    times = request.sample_times
    if times is not None and times.size and not times[-1] <= request.duration:
        raise ValueError(f"sample times must lie within {request.duration}, got {times[-1]}")
    return x, y, vx, vy


def _longer(table: npt.NDArray[np.generic], room: int) -> npt.NDArray:  # type: ignore[type-arg]
    """Return a table with more room, and its previous contents."""
    wide = np.empty((room, *table.shape[1:]), table.dtype)
    if len(table):
        wide[: len(table)] = table
    return wide
