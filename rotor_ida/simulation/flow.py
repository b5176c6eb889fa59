"""How a rotor at a constant speed moves: a map from state to state, on axes that rotate with it.

A state is read on axes that rotate with the unbalance, which is at angle 0 when a run begins. There
a rotor without a fixed direction (a load, unequal bearings) moves by the same law at any time.
Any other rotor does so after whole revolutions only, and its cycles close after these: the
``period`` of a flow. One protocol serves both kernels, that of one disc here and that of rotor
systems in `rotor_ida.simulation.system_flow`.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple, Protocol, Self

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ComplexValues, Flags, Stop, Values, Watch
from rotor_ida.core.interface import DONE, STUCK, message_of
from rotor_ida.core.runs import (
    COLUMNS,
    DIFFERENCES,
    NO_EXTREMA,
    NO_STOP,
    Rows,
    RunRequest,
    RunResult,
    follow_run,
)
from rotor_ida.errors import SimulationError
from rotor_ida.model.equations import push_over_radius, rotated, rotating_field
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema.flags import ENTRY, ROLLS, SLIDES_BACKWARDS, SLIDES_FORWARDS
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import Orbit, stretches_of_rolling
from rotor_ida.simulation.run import run

MAXIMUM = 1.0  # the kind of an extremum
RTOL = 1e-15
# Absolute tolerance of one step, as a fraction of the relative one.
ATOL = 1e-2
OF_PAPER = frozenset(PARAMETERS)
# A slip smaller than this fraction of the speeds that it is the difference of is solver error.
HIDDEN_SLIP = 1e-12
# A motion is steady if it varies, or is off its whirl or its cycle, by less than this fraction of
# its size: ten times the default tolerance. With a looser one, by this many tolerances.
STEADY, STEADY_TOLERANCES = 1e-9, 10.0
# How the motion of one disc is observed where nothing else is said.
OPTIONS = Options(method="taylor")
# Errors of single contacts add up round a cycle, and the smallest radius may be a small fraction of
# the motion. So a motion is observed with this fraction of the given tolerances.
TIGHTER = 0.1
# A tighter tolerance is used as it is: a tenth of it would be near the limit of the solvers.
TIGHTENED_FROM = 1e-11


class Piece(NamedTuple):
    """A motion from a state to another, with the derivatives of its end.

    Parameters
    ----------
    start, end : ndarray, shape (n,)
        States.
    duration : float
        Time between them.
    tangents : ndarray, shape (n, k)
        What changes of the start have become; by default those of each number of the state, so that
        this is the derivative of the end by the start.
    by : list of ndarray, shape (n,)
        Derivatives of the end by some parameters.
    start_rate, end_rate : ndarray, shape (n,)
        Rates of change of the state.
    event_kinds, event_contacts : ndarray, shape (event,)
        The events.
    rolls : ndarray of bool, shape (contact,)
        Which contacts ever roll.
    contacts, extrema : structured ndarray
        The contacts, an entry before the start or an exit after the end NaN; and of one disc the
        minima and maxima of the radius. Rows as in `rotor_ida.core`.
    """

    start: Values
    end: Values
    duration: float
    tangents: Values
    by: list[Values]
    start_rate: Values
    end_rate: Values
    event_kinds: npt.NDArray[np.integer[Any]]
    event_contacts: npt.NDArray[np.integer[Any]]
    rolls: Flags
    contacts: Rows
    extrema: Rows


@dataclass(frozen=True, eq=False)
class Window:
    """A motion over some time, with samples and events.

    Parameters
    ----------
    flow : Flow
        How the rotor moves.
    start, end : ndarray, shape (n,)
        States at time 0 and at the end.
    times : ndarray, shape (time,)
        Times of the samples, equally spaced. The last is the end.
    states : ndarray, shape (time, m)
        The states at these times, without the speeds of races.
    closed_first, closed_last : ndarray of bool, shape (contact,)
        Which contacts are closed at the first sample and at the end.
    event_times, event_kinds, event_contacts : ndarray, shape (event,)
        The events.
    event_states : ndarray, shape (event, 4)
        States of one disc at the events, on fixed axes.
    rolling : list of ndarray, shape (stretch, 2)
        When each contact begins and ceases to roll.
    contacts, extrema : structured ndarray
        As in `Piece`.
    forces : ndarray, shape (time, contact)
        Normal forces of a rotor system at the samples.
    """

    flow: Flow
    start: Values
    end: Values
    times: Values
    states: Values
    closed_first: Flags
    closed_last: Flags
    event_times: Values
    event_kinds: npt.NDArray[np.integer[Any]]
    event_contacts: npt.NDArray[np.integer[Any]]
    rolling: list[Values]
    contacts: Rows
    extrema: Rows = field(default_factory=lambda: NO_EXTREMA)
    event_states: Values = field(default_factory=lambda: np.empty((0, 4)))
    forces: Values = field(default_factory=lambda: np.empty((0, 0)))

    @cached_property
    def touches(self) -> int:
        """Number of entries and exits."""
        return int((np.abs(self.event_kinds) == ENTRY).sum())

    @property
    def ends_in_contact(self) -> bool:
        """Whether a contact is closed at the end."""
        return bool(self.closed_last.any())

    @property
    def is_in_flight(self) -> bool:
        """Whether no contact ever touches."""
        return not (self.closed_first.any() or self.event_times.size)

    @cached_property
    def places(self) -> ComplexValues:
        """Displacement and velocity of the contacts at the samples, shape (2, time, contact)."""
        return self.flow.places(self.states)

    def once_in(self, period: float) -> Values:
        """Return the states once in a period, from the first sample on."""
        return self.states[:: round(period / float(self.times[1] - self.times[0]))]


class Flow(Protocol):
    """How the state of a rotor moves at a constant speed."""

    @property
    def speed(self) -> float:
        """Spin speed."""

    @property
    def revolution(self) -> float:
        """Duration of a revolution."""

    @property
    def period(self) -> float | None:
        """Time whose multiples alone a motion may close after; None for any time."""

    @property
    def clearances(self) -> Values:
        """Clearances of the contacts, shape (contact,)."""

    @property
    def exponents(self) -> Values:
        """Exponents of the laws of the contacts, shape (contact,)."""

    @property
    def length(self) -> float:
        """Distance by which displacements in a state are measured."""

    @property
    def steady(self) -> float:
        """Largest deviation of a motion that counts as steady, relative to its size."""

    @property
    def has_damping(self) -> bool:
        """Whether anything but friction takes energy from the motion."""

    def observed(self, state: Values, times: Values) -> Window:
        """Return the motion from a state to the last of some times, with samples at all of them.

        A sample at the end alone is quicker: extrema are then left out. SimulationError if it
        fails.
        """

    def run(
        self, state: Values, until: float, *, tangents: Values | None = None,
        by: Sequence[str] = (),
    ) -> Piece:  # fmt: skip
        """Return the motion from a state, with what changes of it become, a row each.

        `by` names parameters by which the end is differentiated. SimulationError if it fails.
        """

    def after(self, state: Values, duration: float) -> Values:
        """Return the state after a time."""

    def states(self, state: Values, times: Values) -> Values:
        """Return the states at increasing times from 0 on, shape (time, n)."""

    def places(self, states: Values) -> ComplexValues:
        """Return displacement and velocity of the contacts, shape (2, time, contact)."""

    def radii(self, piece: Piece | Window) -> list[Values]:
        """Return the extreme distances of each contact from its centre, in order of time."""

    def pair_product(self, duration: float) -> float | None:
        """Return the product of pairs of multipliers over a time; None if they form no pairs."""

    def value_of(self, name: str) -> float:
        """Return a parameter."""

    def but(self, **changed: Any) -> Self:
        """Return a flow in equal scales with other parameters, ``rtol``, ``stop`` or ``watch``."""


@dataclass(frozen=True, slots=True, eq=False)
class DiscFlow:
    """The motion of one disc: states are ``(x, y, vx, vy)`` on the rotating axes [dimensionless].

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    stop : ndarray, shape (1,)
        Ends a run as soon as it is not 0.
    rtol : float
        Tolerance of one step, relative to the size of the state [dimensionless].
    options : Options
        How a motion is observed. All else is by Taylor series.
    watch : list of callable, optional
        Receives functions that return the times reached by a motion that is observed.

    Notes
    -----
    The core integrates the state and four differences from it together, by one Taylor series in
    contact and in closed form in flight; derivatives by the parameters follow. The field is
    continuous where contact begins and ends, so nothing is added there. Where friction jumps, as
    the disc begins to roll or reverses its sliding, differences jump with it.
    """

    rotor: Rotor
    stop: Stop = field(default_factory=lambda: NO_STOP)
    rtol: float = RTOL
    options: Options = OPTIONS
    watch: Watch | None = None

    @property
    def speed(self) -> float:
        """Spin speed [dimensionless]."""
        return self.rotor.omega

    @property
    def revolution(self) -> float:
        """Duration of a revolution [dimensionless]; infinite at speed 0."""
        return 2.0 * math.pi / self.rotor.omega if self.rotor.omega else math.inf

    @property
    def period(self) -> float | None:
        """A revolution under a load, which rotates on these axes; else None."""
        return self.revolution if self.rotor.load > 0.0 else None

    @property
    def clearances(self) -> Values:
        """The clearance, shape (1,) [dimensionless]."""
        return np.array([self.rotor.delta0])

    @property
    def exponents(self) -> Values:
        """The exponent of its contact law, shape (1,) [dimensionless]."""
        return np.array([self.rotor.contact_exponent])

    @property
    def length(self) -> float:
        """The eccentricity [dimensionless]."""
        return 1.0

    @property
    def has_damping(self) -> bool:
        """Whether damping takes energy from the motion."""
        return self.rotor.zeta > 0.0

    @property
    def steady(self) -> float:
        """Largest deviation of a motion that counts as steady, relative to its size [1]."""
        return max(STEADY, STEADY_TOLERANCES * self.options.rtol)

    def observed(self, state: Values, times: Values) -> Window:
        """Return a motion with samples: see `Flow`; as `options` say, a little tighter [1]."""
        scale = TIGHTER if self.options.rtol >= TIGHTENED_FROM else 1.0
        orbit = self.orbit(state, float(times[-1]), times, scale=scale, extrema=times.size > 1)
        states = rotated(orbit.states, -self.rotor.omega * times)
        touches = int((np.abs(orbit.event_kinds) == ENTRY).sum())
        began = np.array([orbit.starts_in_contact])
        return Window(
            self, state, states[-1], times, states, began, began ^ bool(touches % 2),
            orbit.event_times, orbit.event_kinds, np.zeros(orbit.event_kinds.size, np.int8),
            [stretches_of_rolling(orbit)], orbit.contacts,
            NO_EXTREMA if orbit.extrema is None else orbit.extrema, orbit.event_states,
        )  # fmt: skip

    def orbit(
        self, state: Values, duration: float, times: Values, *, scale: float = 1.0,
        extrema: bool = False,
    ) -> Orbit:  # fmt: skip
        """Return a motion as `options` say, on fixed axes; `scale` multiplies tolerances [1]."""
        x, y, vx, vy = state.tolist()
        return run(
            self.rotor, (x, y, vx, vy), duration, times, self.options, scale=scale,
            extrema=extrema, stop=self.stop, watch=self.watch,
        )  # fmt: skip

    def run(
        self, state: Values, until: float, *, tangents: Values | None = None,
        by: Sequence[str] = (),
    ) -> Piece:  # fmt: skip
        """Return the motion from a state: see `Flow`; at most four changes of it are followed."""
        rotor = self.rotor
        start = put_on_rolling(rotor, state) if rotor.friction > 0.0 else state
        whole = not OF_PAPER.issuperset(by)
        columns = (len(COLUMNS) if whole or rotor.beyond else len(PARAMETERS)) if by else 0
        bundle = np.eye(DIFFERENCES + columns, 4)
        if tangents is not None:
            bundle[:DIFFERENCES] = 0.0
            bundle[: len(tangents)] = tangents
        result = self.followed(start, until, events=True, extrema=True, bundle=bundle, whole=whole)
        end, modes = np.array(result.state), result.modes
        if not math.isfinite(sum(bundle.ravel().tolist()) + sum(result.state)):
            raise _failed(STUCK, 0.0, start)
        first, last = (0, 0) if modes is None else (int(modes[0]), int(modes[-1]))
        count = DIFFERENCES if tangents is None else len(tangents)
        return Piece(
            start, end, until, bundle[:count].T,
            [bundle[DIFFERENCES + COLUMNS.index(name)] for name in by],
            self.rate(start, 0.0, first), self.rate(end, until, last),
            result.event_kinds, np.zeros(result.event_kinds.size, np.int8),
            np.array([modes is not None and bool((modes == ROLLS).any())]),
            result.contacts, result.extrema,
        )  # fmt: skip

    def rate(self, state: Values, time: float = 0.0, mode: int = 0) -> Values:
        """Return the rate of a state; `mode` is that of its contact, as the core has it [1]."""
        return rotating_field(state, self.rotor, time) + _friction_at(state, self.rotor, time, mode)

    def after(self, state: Values, duration: float) -> Values:
        """Return the state after a time [dimensionless]."""
        return np.array(self.followed(state, duration).state)

    def states(self, state: Values, times: Values) -> Values:
        """Return the states at increasing times from 0 on, shape (time, 4) [dimensionless]."""
        return self.followed(state, float(times[-1]), sample_times=times).samples

    def places(self, states: Values) -> ComplexValues:
        """Return displacement and velocity of the disc, shape (2, time, 1) [dimensionless]."""
        places = np.ascontiguousarray(states).view(np.complex128)  # (time, 2)
        return np.asarray(places.T[:, :, np.newaxis])

    def radii(self, piece: Piece | Window) -> list[Values]:
        """Return the extreme radii, as the core has found them [dimensionless]."""
        return [piece.extrema["radius"]]

    def pair_product(self, duration: float) -> float | None:
        """Return ``exp(-2 zeta T)`` where damping is uniform and there is no load; else None."""
        has_pairs = self.rotor.damps_uniformly and self.rotor.load == 0.0
        return math.exp(-2.0 * self.rotor.zeta * duration) if has_pairs else None

    def value_of(self, name: str) -> float:
        """Return a parameter of the rotor [dimensionless]."""
        return float(getattr(self.rotor, name))

    def but(
        self, *, rtol: float | None = None, stop: Stop | None = None, watch: Watch | None = None,
        **parameters: float,
    ) -> DiscFlow:  # fmt: skip
        """Return a flow with other parameters of the rotor, tolerance, stop or watch."""
        return DiscFlow(
            replace(self.rotor, **parameters) if parameters else self.rotor,
            self.stop if stop is None else stop, self.rtol if rtol is None else rtol,
            self.options, self.watch if watch is None else watch,
        )  # fmt: skip

    def followed(self, state: Values, duration: float, **asked: Any) -> RunResult:
        """Return a run of the core that has reached its end."""
        result = follow_run(
            RunRequest(
                rotor=self.rotor, start=state, duration=duration, rtol=self.rtol,
                atol=ATOL * self.rtol, stop=self.stop, **asked,
            )
        )  # fmt: skip
        if result.status != DONE:
            here = rotated(result.state, self.rotor.omega * result.time)
            raise _failed(result.status, result.time, here)
        return result


def nontrivial(flow: Flow, piece: Piece) -> ComplexValues:
    """Return the multipliers of a closed orbit but that of a shift in time, which is 1.

    With pairs of a known product ``q`` the trace of the derivative gives them:
    ``mu + q/mu = tr M - 1 - q``, and the fourth is q. Otherwise they are those of M across the
    field at the start; all of M where a motion may begin at some times only.
    """
    matrix, q = piece.tangents, flow.pair_product(piece.duration)
    if q is not None:
        half = 0.5 * (float(matrix.trace()) - 1.0 - q)
        root = cmath.sqrt(half * half - q)
        if root.imag:
            return np.array([q, half + root, half - root])
        # the smaller one from the product: a difference would cancel
        larger = half + math.copysign(root.real, half)
        return np.array([q, larger, q / larger if larger else 0.0], np.complex128)
    if flow.period is None:
        along = piece.start_rate / np.linalg.norm(piece.start_rate)
        across = np.linalg.svd(along[np.newaxis])[2][1:]
        matrix = across @ matrix @ across.T
    return np.asarray(np.linalg.eigvals(matrix), np.complex128)


def _failed(status: int, time: float, state: Values) -> SimulationError:
    x, y, vx, vy = state.tolist()
    reason = f"an orbit could not be followed: {message_of(status)}"
    return SimulationError(reason, time=time, state=(x, y, vx, vy))


def put_on_rolling(rotor: Rotor, state: Values) -> Values:
    """Return a state with a slip of exactly 0 if it was only rounding: there the disc may roll."""
    x, y, vx, vy = state.tolist()
    radius, speed = math.hypot(x, y), math.hypot(vx, vy)
    rim = (rotor.disc_radius or 0.0) * rotor.omega
    if not radius > rotor.delta0:
        return state
    slip = (x * vy - y * vx) / radius + rim
    if abs(slip) > HIDDEN_SLIP * (speed + rim):
        return state
    return np.array([x, y, vx + slip * y / radius, vy - slip * x / radius])


def _friction_at(state: Values, rotor: Rotor, time: float, mode: int) -> Values:
    """Return the contribution of the tangential force to the rates on the rotating axes."""
    if mode not in {SLIDES_FORWARDS, SLIDES_BACKWARDS, ROLLS}:
        return np.zeros(4)
    x, y, vx, vy = state.tolist()
    radius = math.hypot(x, y)
    if mode == ROLLS:
        turned = rotor.omega * time
        down = -rotor.load * (x * math.cos(turned) - y * math.sin(turned)) / radius
        force = -(rotor.omega**2) * y / radius + down
        rise = (x * vx + y * vy) / radius
        force += (rotor.disc_radius or 0.0) * rotor.omega * (2.0 * rotor.zeta + rise / radius)
    else:
        force = mode * rotor.friction * radius * push_over_radius((x, y, vx, vy), rotor)
    return np.array([0.0, 0.0, force * y / radius, -force * x / radius])
