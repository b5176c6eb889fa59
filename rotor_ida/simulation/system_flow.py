"""A rotor system at a constant speed as a map from state to state, after whole revolutions or less.

A state ``u`` has the displacements and velocities in coordinates with a unit mass matrix, over the
scales by which the core measures errors, and then the speeds of the races that spin. At the start
of each run the unbalance is at angle 0. So the state after a whole revolution begins the next one.
In an axisymmetric system a state can be turned back by any angle: on rotating axes the motion does
not depend on the angle, and a run begins anywhere.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.linalg import null_space

from rotor_ida.arrays import ComplexValues, Flags, Stop, Values, Watch
from rotor_ida.checks import shown
from rotor_ida.core.runs import NO_EXTREMA, Rows
from rotor_ida.core.system_requests import (
    LAW_CHANGE,
    ByParameter,
    Places,
    SystemRequest,
    SystemResult,
    law_changes,
)
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.assembly import Assembly, Canonical, assemble, canonical
from rotor_ida.model.axisymmetric import check_axisymmetric_parts, forward_motions
from rotor_ida.model.bearing import Films
from rotor_ida.model.growth import rates_of
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import SPEED, parameter_of, with_parameters
from rotor_ida.schema import MODE
from rotor_ida.schema.flags import ROLL
from rotor_ida.simulation.flow import STEADY, STEADY_TOLERANCES, Piece, Window
from rotor_ida.simulation.spin import steady
from rotor_ida.simulation.system_run import ORDERS, request_of, run_to_end

# Runs whose differences stand for derivatives are this far apart, in scaled coordinates: errors of
# the runs stay far below, and so does the curvature.
APART = 1e-6
# A decay slower than this part of its eigenvalue is rounding.
UNDAMPED = 1e-9
# Resistances to free motions that differ by more than this factor: one of them has none.
MOST_UNEQUAL = 1e12
# A change that shrinks below this in a revolution is lost in rounding.
LOST = 1e-12
# Differences of a parameter are this long, in parts of it or, of one that may be 0, of 1: short
# enough for a branch to pass a corner, where rolling begins. Those of time are in revolutions.
OF_PARAMETER, OF_TIME = 1e-7, 1e-5
# A friction of 0 shows no sense of sliding, by which alone one can differentiate; this one does.
LEAST_FRICTION = 1e-30
# Samples of an orbit in a revolution, and at least.
SAMPLES_A_REVOLUTION, FEWEST_SAMPLES = 64, 192


@dataclass(frozen=True, slots=True)
class SettlingProblem:
    """What is the same at all speeds.

    Parameters
    ----------
    assembly : Assembly
        The system with its stators, contacts and forces.
    found : Canonical
        The same in coordinates with a unit mass matrix. No parameter changes the coordinates.
    forward : ndarray of complex, shape (N, n), or None
        The forward motions of an axisymmetric system.
    rtol : float
        Tolerance of a run.
    films : Films
        The bearings whose coefficients depend on the speed, in the same coordinates, which are in
        the matrices once a speed is held.
    """

    assembly: Assembly
    found: Canonical
    forward: ComplexValues | None
    rtol: float
    films: Films

    @classmethod
    def of(cls, assembly: Assembly, rtol: float) -> SettlingProblem:
        """Return the problem of a system, axisymmetric or not."""
        try:
            check_axisymmetric_parts(assembly)
            forward = forward_motions(assembly).basis
        except InputError:
            forward = None
        found = canonical(assembly)
        return cls(assembly, found, forward, rtol, found.films)

    def at(self, speed: float) -> SettlingProblem:
        """Return the problem at a speed, with its films in the matrices."""
        if not self.assembly.films:
            return self
        assembly = self.assembly.at(speed)
        return replace(self, assembly=assembly, found=canonical(assembly))

    def of_parameters(self, base: RotorSystem, given: Mapping[str, float]) -> SettlingProblem:
        """Return the problem of a system with these parameters, on the same axes."""
        try:
            assembly = assemble(with_parameters(base, given))
        except InputError as error:
            raise SimulationError(str(error)) from error
        found = canonical(assembly)
        return replace(self, assembly=assembly, found=found, films=found.films)

    @property
    def with_race(self) -> Flags:
        """Which contacts have a race that spins; of those that share one the first."""
        races, numbers = self.assembly.races, self.assembly.race_numbers
        return np.array(
            [race is not None and numbers[i] == i for i, race in enumerate(races)], bool
        )

    @property
    def race_speeds(self) -> Values:
        """The speeds of those races at time 0."""
        speeds = [0.0 if race is None else race.speed for race in self.assembly.races]
        return np.array(speeds)[self.with_race]

    @property
    def has_damping(self) -> bool:
        """Whether anything but friction takes energy from the motion."""
        damping = self.found.damping
        damped = [bool(np.any(each.damping)) for each in self.films.bearings]
        damped += [each.damping > 0.0 for each in self.assembly.contacts]
        return (damping is not None and bool(damping.any())) or any(damped)

    def slowest_decay(self, speed: float) -> float:
        """Return the slowest rate at which a free motion decays; 0 if none does."""
        rates = rates_of(self.found, speed)
        decays = np.abs(rates.real[np.abs(rates.real) > UNDAMPED * np.abs(rates).max()])
        return float(decays.min(initial=math.inf)) if decays.size else 0.0


@dataclass(frozen=True, slots=True)
class SystemFlow:
    """The motion of a rotor system at one speed.

    Parameters
    ----------
    problem : SettlingProblem
        The system.
    speed : float
        Spin speed.
    request : SystemRequest
        A run of it, whose start and times are replaced.
    scales : ndarray, shape (n,)
        Scales of a state.
    stop : ndarray, shape (1,)
        Ends a run as soon as it is not 0.
    base : RotorSystem
        The system whose parameters are its own.
    given : mapping of str to float
        The parameters of the problem that are not.
    watch : list of callable, optional
        Receives functions that return the times reached by runs.
    """

    problem: SettlingProblem
    speed: float
    request: SystemRequest
    scales: Values
    stop: Stop
    base: RotorSystem
    given: Mapping[str, float] = field(default_factory=dict)
    watch: Watch | None = None

    @classmethod
    def at(cls, problem: SettlingProblem, speed: float, stop: Stop) -> SystemFlow:
        """Return the motion of a system at a speed."""
        base, problem = problem.assembly.system, problem.at(speed)
        size = problem.assembly.size
        still = np.zeros((2, size))
        revolution = 2.0 * math.pi / abs(speed)
        request = request_of(
            problem.assembly, problem.found, steady(speed, revolution), still,
            np.array([revolution]), revolution, rtol=problem.rtol, speed=speed,
            fastest_speed=abs(speed), inertia=0.0,
        )  # fmt: skip
        races = int(problem.with_race.sum())
        scales = np.repeat(
            [request.displacement, request.velocity, abs(speed)], [size, size, races]
        )
        return cls(problem, speed, request, scales, stop, base)

    @property
    def assembly(self) -> Assembly:
        """The system at any speed."""
        if not self.problem.films:
            return self.problem.assembly
        return assemble(with_parameters(self.base, self.given))

    @property
    def revolution(self) -> float:
        """Duration of a revolution."""
        return 2.0 * math.pi / abs(self.speed)

    def state_of(self, motion: Values, races: Values) -> Values:
        """Return the state of displacements and velocities, shape (2, n), and speeds of races."""
        return np.concatenate([motion.ravel(), races]) / self.scales

    def given_state(self, values: Values) -> Values:
        """Return the state of q, velocity and speeds of races, as a result has them."""
        size = self.problem.assembly.size
        if values.shape != self.scales.shape or not np.isfinite(values).all():
            raise InputError(
                f"start must have {self.scales.size} finite numbers in its state, as the system "
                f"has, got {shown(values.shape)}"
            )
        moved = [self.problem.found.to_y(each) for each in values[: 2 * size].reshape(2, size)]
        return self.state_of(np.array(moved), values[2 * size :])

    def in_q(self, state: Values) -> Values:
        """Return q, velocity and speeds of races of a state: the inverse of `given_state`."""
        moved = self.problem.found.to_q(self.motion_of(state))
        return np.concatenate([moved.ravel(), (state * self.scales)[moved.size :]])

    def motion_of(self, states: Values) -> Values:
        """Return displacements and velocities of states, shape (..., 2, n)."""
        size = self.problem.assembly.size
        own = states[..., : 2 * size] * self.scales[: 2 * size]
        return np.asarray(own.reshape(*states.shape[:-1], 2, size))

    @property
    def period(self) -> float | None:
        """None for an axisymmetric system, else a revolution."""
        return None if self.problem.forward is not None else self.revolution

    @property
    def clearances(self) -> Values:
        """Clearances of the contacts, shape (contact,)."""
        return np.array([each.clearance for each in self.problem.assembly.contacts])

    @property
    def exponents(self) -> Values:
        """Exponents of the laws of the contacts, shape (contact,)."""
        return np.array([each.exponent for each in self.problem.assembly.contacts])

    @property
    def length(self) -> float:
        """The displacement by which errors are measured."""
        return float(self.scales[0])

    def run(
        self, state: Values, until: float, *, tangents: Values | None = None,
        by: Sequence[str] = (),
    ) -> Piece:  # fmt: skip
        """Return the motion from a state: see `rotor_ida.simulation.flow.Flow`."""
        changes = np.eye(state.size) if tangents is None else tangents
        run, moved, ends = self._changed(state, changes, until, by)
        end = self.end_of(run)
        rolls = run.touches["mode"] == MODE["rolling"]
        rolls[run.event_contacts[run.event_kinds == ROLL]] = True
        return Piece(
            state, end, until, moved.T, list(ends),
            self.rate(state), self.rate(end), run.event_kinds, run.event_contacts, rolls,
            run.episodes, NO_EXTREMA,
        )  # fmt: skip

    def _by(self, name: str) -> ByParameter:
        """Return the derivatives of the system by a parameter, of which it is a linear function."""
        if name == SPEED:
            of_films = {}
            if films := self.problem.films:
                of_films = {each: films.matrix(each, self.speed, 1)
                            for each in ("stiffness", "damping")}  # fmt: skip
            laws = np.zeros(len(self.request.laws), LAW_CHANGE)
            return ByParameter(speed=1.0, laws=laws, **of_films)
        value = self.value_of(name)
        changed: dict[str, Any] = {name: 2.0 * value if value else 1.0}
        step, here = changed[name] - value, self.request
        other = self.but(**changed).request

        def change_of(number: str) -> Values | None:
            before, after = getattr(here, number), getattr(other, number)
            return None if before is None or after is before else (after - before) / step

        return ByParameter(
            stiffness=change_of("stiffness") if name == "stiffness" else None,
            damping=change_of("damping") if name == "damping" else None,
            unbalance=change_of("unbalance") if name == "unbalance" else None,
            laws=law_changes(here.laws, here.laws, other.laws, step),
        )  # fmt: skip

    def _by_difference(self, name: str, state: Values, until: float, end: Values) -> Values:
        """Return the derivative of the state after a time, `end`, by a parameter that may be 0.

        It is a difference of second order towards larger values.
        """
        value = self.value_of(name)
        step = OF_PARAMETER * (abs(value) or 1.0)
        both: list[dict[str, Any]] = [{name: value + step}, {name: value + 2.0 * step}]
        near, far = (self.but(**changed).after(state, until) for changed in both)
        return (4.0 * near - 3.0 * end - far) / (2.0 * step)

    def value_of(self, name: str) -> float:
        """Return the speed, or a parameter of the system."""
        if name == SPEED:
            return self.speed
        return self.given[name] if name in self.given else parameter_of(self.base, name)

    def but(
        self, *, rtol: float | None = None, stop: Stop | None = None, watch: Watch | None = None,
        **parameters: float,
    ) -> SystemFlow:  # fmt: skip
        """Return a flow with other parameters, or another tolerance, stop or watch: see `Flow`."""
        speed = parameters.pop(SPEED, self.speed)
        if not speed * self.speed > 0.0:
            raise SimulationError(f"speed falls to {speed:.3g}")
        problem, given = self.problem, {**self.given, **parameters}
        if parameters or problem.films:
            problem = problem.of_parameters(self.base, given)
        if rtol is not None:
            problem = replace(problem, rtol=rtol)
        try:
            own = SystemFlow.at(problem, speed, self.stop if stop is None else stop)
        except InputError as error:  # outside the table of a bearing
            raise SimulationError(str(error)) from error
        return replace(
            own, scales=self.scales, base=self.base, given=given,
            watch=self.watch if watch is None else watch,
        )  # fmt: skip

    @property
    def has_damping(self) -> bool:
        """Whether anything but friction takes energy from the motion."""
        return self.problem.has_damping

    @property
    def steady(self) -> float:
        """Largest deviation of a motion that counts as steady, relative to its size."""
        return max(STEADY, STEADY_TOLERANCES * self.problem.rtol)

    def observed(self, state: Values, times: Values) -> Window:
        """Return a motion with samples: see `rotor_ida.simulation.flow.Flow`."""
        run = self.sampled(state, times)
        modes = run.forces[0, :, 3]
        rolling = []
        for number, mode in enumerate(modes):
            own = run.event_contacts == number
            rolls = np.append(mode == MODE["rolling"], run.event_kinds[own] == ROLL)
            edges = np.concatenate([[0.0], run.event_times[own], times[-1:]])
            rolling.append(np.column_stack([edges[:-1][rolls], edges[1:][rolls]]))
        return Window(
            self, state, self.end_of(run), times, self.samples_of(run, times),
            modes != MODE["flight"], run.touches["mode"] != MODE["flight"],
            run.event_times, run.event_kinds, run.event_contacts, rolling, run.episodes,
            forces=run.forces[:, :, 0],
        )  # fmt: skip

    def states(self, state: Values, times: Values) -> Values:
        """Return the states at times; those of races are not sampled."""
        return self.samples_of(self.sampled(state, times), times)

    def observable(self, *, nodes: bool = False) -> Places:
        """Return the contacts, and then the nodes, if wanted, as places of the motion."""
        assembly, found = self.problem.assembly, self.problem.found
        rows = [found.rows, found.rows_in_y(assembly.node_rows())] if nodes else [found.rows]
        centres = np.zeros((sum(map(len, rows)), 2))
        for centre, contact in zip(centres, assembly.contacts, strict=False):
            centre[:] = contact.centre
        return Places(np.concatenate(rows), centres)

    def places(self, states: Values, *, nodes: bool = False) -> ComplexValues:
        """Return displacement and velocity of the contacts, and then the nodes, if wanted.

        Their shape is (2, time, contact).
        """
        rows, centres = self.observable(nodes=nodes)
        whole = rows[:, 0] + 1j * rows[:, 1]
        places = (self.motion_of(states) @ whole.T).transpose(1, 0, 2)
        places[0] -= centres[:, 0] + 1j * centres[:, 1]
        return np.asarray(places, complex)

    def sample_times(self, duration: float) -> Values:
        """Return times of samples, both ends included, on which extrema can be seen."""
        count = math.ceil(SAMPLES_A_REVOLUTION * duration / self.revolution)
        return np.linspace(0.0, duration, max(count, FEWEST_SAMPLES) + 1)

    def extrema(self, state: Values, duration: float, places: Places) -> Rows:
        """Return the extrema of the distances of places over a motion, as the core has them."""
        times = np.array([duration])
        return self.sampled(state, times, only_events=True, places=places).extrema

    def radii(self, piece: Piece | Window, *, nodes: bool = False) -> list[Values]:
        """Return the extreme distances of each contact, and of each node: at least two of each.

        They are those at both ends where there are none between them.
        """
        duration = float(piece.times[-1]) if isinstance(piece, Window) else piece.duration
        places = self.observable(nodes=nodes)
        table = self.extrema(piece.start, duration, places)
        both = [table[table["place"] == number] for number in range(len(places.rows))]
        between = [each["distance"][each["kind"] != 0] for each in both]
        return [
            inner if inner.size else each["distance"]
            for inner, each in zip(between, both, strict=True)
        ]

    def pair_product(self, _duration: float) -> float | None:
        """Return None: multipliers of a system do not form pairs."""
        return None

    def sampled(
        self,
        state: Values,
        times: Values,
        *,
        only_events: bool = False,
        columns: Values | None = None,
        parameters: Sequence[ByParameter] = (),
        places: Places | None = None,
    ) -> SystemResult:
        """Return a run from a state to the last of some times, with small changes of its start."""
        races = np.zeros(len(self.request.laws))
        motion, end = self.motion_of(state), float(times[-1])
        races[self.problem.with_race] = (state * self.scales)[motion.size :]
        # of small changes some are as fast as the system itself, and take fewer steps by more terms
        order = max(ORDERS) if columns is not None else self.request.order
        request = replace(
            self.request, start=motion, races=races[self.request.laws["race"]], times=times,
            duration=end, pieces=steady(self.speed, end).pieces(), only_events=only_events,
            columns=columns, parameters=parameters, places=places, order=order,
        )  # fmt: skip
        return run_to_end(request, self.stop, self.watch)

    def end_of(self, run: SystemResult) -> Values:
        """Return the state at the end of a run, with the axes turned back."""
        races = run.touches["race"][self.problem.with_race]
        return self.turned_back(self.state_of(run.state, races), run.time)

    def after(self, state: Values, duration: float) -> Values:
        """Return the state after a time, with the axes turned back."""
        return self.end_of(self.sampled(state, np.array([duration]), only_events=True))

    def samples_of(self, run: SystemResult, times: Values) -> Values:
        """Return displacements and velocities at samples as states on rotating axes.

        The speeds of races are not sampled.
        """
        flat = run.samples.reshape(len(times), -1) / self.scales[: 2 * self.problem.assembly.size]
        return self.turned_back(flat, times)

    def turned_back(self, states: Values, times: Values | float) -> Values:
        """Return states, shape (..., n), turned back by the angle of the unbalance at times."""
        turn = np.exp(-1j * self.speed * np.asarray(times)) - 1.0
        return states + self._forward_part(states, turn[..., np.newaxis])

    def _forward_part(self, states: Values, factor: Any) -> Values:
        """Return the forward motions in states, shape (..., n), by a complex factor; 0 without."""
        basis, found, size = self.problem.forward, np.zeros_like(states), self.problem.assembly.size
        if basis is not None:
            for part in (slice(size), slice(size, 2 * size)):
                along = factor * (states[..., part] @ basis.conj())
                found[..., part] = 2.0 * (along @ basis.T).real
        return found

    def rate(self, state: Values) -> Values:
        """Return the rate of a state on rotating axes, by differences of second order in time."""
        time = OF_TIME * self.revolution
        near, far = (self.after(state, each) - state for each in (0.5 * time, time))
        return (4.0 * near - far) / time

    def _changed(
        self, state: Values, changes: Values, duration: float, by: Sequence[str] = ()
    ) -> tuple[SystemResult, Values, Values]:
        """Return a run, and what small changes of its start and parameters have become, in rows.

        The core follows the changes, by the linearised motion and its jumps at events. Differences
        of runs stand for them in a system that has stators without mass.
        """
        if "friction" in by and not (self.request.massless or self.request.laws["friction"].any()):
            return self.but(friction=LEAST_FRICTION)._changed(state, changes, duration, by)
        size, races = 2 * self.problem.assembly.size, self.problem.with_race
        if self.request.massless:
            run = self.sampled(state, np.array([duration]), only_events=True)
            image = self.end_of(run)
            ends = [self.after(state + APART * change, duration) for change in changes]
            ends_by = [self._by_difference(each, state, duration, image) for each in by]
            return run, (np.array(ends) - image) / APART, np.array(ends_by)
        columns = np.zeros((len(changes) + len(by), size + races.size))
        known = np.concatenate([np.ones(size, bool), races])
        columns[: len(changes), known] = changes * self.scales
        columns[:, size:] = columns[:, size + self.request.laws["race"]]
        run = self.sampled(
            state, np.array([duration]), only_events=True, columns=columns,
            parameters=[self._by(each) for each in by],
        )  # fmt: skip
        moved = self.turned_back(run.columns[:, known] / self.scales, run.time)
        if SPEED in by:  # by which the axes turn, too
            place = len(changes) + list(by).index(SPEED)
            moved[place] += self._forward_part(self.end_of(run), -1j) * run.time
        return run, moved[: len(changes)], moved[len(changes) :]

    def touch_fading(self, number: int, amplitude: float) -> float:
        """Return by how much 1/h grows from one ever slighter touch of a contact to the next.

        As `rotor_ida.closed_forms.touch_fading` of one disc: ``h**(1/2 - n)`` grows by
        ``(n - 1/2) k g sqrt(2/kappa)`` times the integral of ``(1 - s**2)**n`` from -1 to 1, where
        an impulse of 1 moves the contact by g for ever. NaN where nothing returns without a force
        or the amplitude of the whirl does not fit.
        """
        found, contact = self.problem.found, self.problem.assembly.contacts[number]
        room = contact.clearance - amplitude
        free, across = null_space(found.stiffness), null_space(found.stiffness.T)
        if not free.size or not 0.0 < room < contact.clearance or self.period is not None:
            return math.nan
        resisted = found.damping_at(self.speed)
        if found.gyroscopic is not None:
            resisted = resisted + self.speed * found.gyroscopic
        rows, slowed = found.rows[number], across.T @ resisted @ free
        if np.linalg.cond(slowed) > MOST_UNEQUAL:
            return math.nan
        moved = rows @ free @ np.linalg.solve(slowed, across.T @ rows.T)
        curvature = self.speed**2 * amplitude * room / contact.clearance
        n, g = contact.exponent, float(moved.trace()) / 2.0
        shape = math.sqrt(math.pi) * math.gamma(n + 1.0) / math.gamma(n + 1.5)
        return (n - 0.5) * contact.stiffness * g * math.sqrt(2.0 / curvature) * shape

    def monodromy(self, state: Values, period: float) -> Values:
        """Return the derivative of the state after a period by that before."""
        return self._changed(state, np.eye(state.size), period)[1].T

    def growth(
        self, state: Values, count: int, revolutions: int, done: list[int] | None = None
    ) -> Values:
        """Return the rates at which some small changes grow in each revolution.

        They are made orthonormal after each (Benettin et al. 1980). A rate is minus infinity where
        a change is lost: a contact that rolls leaves none of its slip. Numbers of revolutions are
        added to `done` as they pass.
        """
        bundle = np.linalg.qr(np.vander(np.linspace(-0.9, 1.0, state.size), count))[0]
        factors = np.empty((revolutions, count))
        for number, row in enumerate(factors):
            if done is not None:
                done.append(number)
            run, changes, _ = self._changed(state, bundle.T, self.revolution)
            state = self.end_of(run)
            bundle, grown = np.linalg.qr(changes.T)
            row[:] = np.abs(grown.diagonal())
        with np.errstate(divide="ignore"):
            return np.log(np.where(factors > LOST, factors, 0.0)) / self.revolution
