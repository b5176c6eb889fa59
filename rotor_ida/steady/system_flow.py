"""A rotor system at a constant speed as a map from state to state, after whole revolutions or less.

A state ``u`` has the displacements and velocities in coordinates with a unit mass matrix, over the
scales by which the core measures errors, and then the speeds of the races that spin. At the start
of each run the unbalance is at angle 0. So the state after a whole revolution begins the next one.
In an axisymmetric system a state can be turned back by any angle: on turning axes the motion does
not depend on the angle, and a run begins anywhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from rotor_ida.arrays import ComplexValues, Flags, Stop, Values, Watch
from rotor_ida.core.systems import SystemRequest, SystemResult
from rotor_ida.errors import InputError
from rotor_ida.simulation.lyapunov import means_of_rates
from rotor_ida.simulation.spin import steady
from rotor_ida.steady.decision import Exponents
from rotor_ida.systems.assembly import Assembly, Canonical, canonical
from rotor_ida.systems.axisymmetric import check_axisymmetric_parts, forward_motions
from rotor_ida.systems.following import follow_system_again, request_of

# Runs whose differences stand for derivatives are this far apart, in scaled coordinates: errors of
# the runs stay far below, and so does the curvature.
APART = 1e-6
# A decay slower than this part of its eigenvalue is rounding.
UNDAMPED = 1e-9
# Where contacts are linear, what neighbours do jumps at grazes, and the means of their stretching
# over a torus converge slowly.
NO_STRETCH = 0.1
# A change that shrinks below this in a revolution is lost in rounding.
LOST = 1e-12
# Revolutions in which small changes align before their growth is averaged; batches of the mean.
ALIGNING, BATCHES = 100, 20


@dataclass(frozen=True, slots=True)
class SettlingProblem:
    """What is the same at all speeds.

    Parameters
    ----------
    assembly : Assembly
        The system with its stators, contacts and forces.
    found : Canonical
        The same in coordinates with a unit mass matrix.
    forward : ndarray of complex, shape (N, n), or None
        The forward motions of an axisymmetric system.
    rtol : float
        Tolerance of a run.
    """

    assembly: Assembly
    found: Canonical
    forward: ComplexValues | None
    rtol: float

    @classmethod
    def of(cls, assembly: Assembly, rtol: float) -> SettlingProblem:
        """Return the problem of a system, axisymmetric or not."""
        try:
            check_axisymmetric_parts(assembly)
            forward = forward_motions(assembly).basis
        except InputError:
            forward = None
        return cls(assembly, canonical(assembly), forward, rtol)

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
        return (damping is not None and bool(damping.any())) or any(
            each.damping > 0.0 for each in self.assembly.contacts
        )

    def slowest_decay(self, speed: float) -> float:
        """Return the slowest rate at which a free motion decays; 0 if none does."""
        size, found = self.assembly.size, self.found
        resisted = np.zeros((size, size)) if found.damping is None else found.damping.copy()
        if found.gyroscopic is not None:
            resisted += speed * found.gyroscopic
        rates = np.linalg.eigvals(
            np.block([[np.zeros((size, size)), np.eye(size)], [-found.stiffness, -resisted]])
        )
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
    watch : list of callable, optional
        Receives functions that return the times reached by runs.
    """

    problem: SettlingProblem
    speed: float
    request: SystemRequest
    scales: Values
    stop: Stop
    watch: Watch | None = None

    @classmethod
    def at(cls, problem: SettlingProblem, speed: float, stop: Stop) -> SystemFlow:
        """Return the motion of a system at a speed."""
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
        return cls(problem, speed, request, scales, stop)

    @property
    def revolution(self) -> float:
        """Duration of a revolution."""
        return 2.0 * math.pi / abs(self.speed)

    def state_of(self, motion: Values, races: Values) -> Values:
        """Return the state of displacements and velocities, shape (2, n), and speeds of races."""
        return np.concatenate([motion.ravel(), races]) / self.scales

    def motion_of(self, states: Values) -> Values:
        """Return displacements and velocities of states, shape (..., 2, n)."""
        size = self.problem.assembly.size
        own = (states * self.scales)[..., : 2 * size]
        return np.asarray(own.reshape(*states.shape[:-1], 2, size))

    def run(
        self,
        state: Values,
        times: Values,
        *,
        only_events: bool = False,
        columns: Values | None = None,
    ) -> SystemResult:
        """Return a run from a state to the last of some times, with small changes of its start."""
        races = np.zeros(len(self.request.laws))
        motion, end = self.motion_of(state), float(times[-1])
        races[self.problem.with_race] = (state * self.scales)[motion.size :]
        request = replace(
            self.request, start=motion, races=races[self.request.laws["race"]], times=times,
            duration=end, pieces=steady(self.speed, end).pieces(), only_events=only_events,
            columns=columns,
        )  # fmt: skip
        return follow_system_again(request, self.stop, self.watch)

    def end_of(self, run: SystemResult) -> Values:
        """Return the state at the end of a run, with the axes turned back."""
        races = run.touches["race"][self.problem.with_race]
        return self.turned_back(self.state_of(run.state, races), run.time)

    def after(self, state: Values, duration: float) -> Values:
        """Return the state after a time, with the axes turned back."""
        return self.end_of(self.run(state, np.array([duration]), only_events=True))

    def samples_of(self, run: SystemResult, times: Values) -> Values:
        """Return displacements and velocities at samples as states on turning axes.

        The speeds of races are not sampled.
        """
        flat = run.samples.reshape(len(times), -1) / self.scales[: 2 * self.problem.assembly.size]
        return self.turned_back(flat, times)

    def turned_back(self, states: Values, times: Values | float) -> Values:
        """Return states, shape (..., n), turned back by the angle of the unbalance at times."""
        forward = self.problem.forward
        if forward is None:
            return states
        turn = np.exp(-1j * self.speed * np.asarray(times)) - 1.0
        turned, size = states.copy(), self.problem.assembly.size
        for part in (slice(size), slice(size, 2 * size)):
            along = states[..., part] @ forward.conj()
            turned[..., part] += 2.0 * ((turn[..., np.newaxis] * along) @ forward.T).real
        return turned

    def rate(self, state: Values) -> Values:
        """Return the rate of a state on turning axes, by a difference that is short enough."""
        short = APART * self.revolution
        return (self.after(state, short) - state) / short

    def changes(self, state: Values, changes: Values, duration: float) -> tuple[Values, Values]:
        """Return the state after a time, and what small changes of it become, a row each.

        The core follows the changes, by the linearised motion and its jumps at events; those of a
        system that has stators without mass are differences of runs.
        """
        if self.request.massless:
            image = self.after(state, duration)
            ends = [self.after(state + APART * change, duration) for change in changes]
            return image, (np.array(ends) - image) / APART
        size, races = 2 * self.problem.assembly.size, self.problem.with_race
        columns = np.zeros((len(changes), size + races.size))
        columns[:, np.concatenate([np.ones(size, bool), races])] = changes * self.scales
        columns[:, size:] = columns[:, size + self.request.laws["race"]]
        run = self.run(state, np.array([duration]), only_events=True, columns=columns)
        moved = run.columns[:, np.concatenate([np.ones(size, bool), races])] / self.scales
        return self.end_of(run), self.turned_back(moved, run.time)

    def monodromy(self, state: Values, period: float) -> Values:
        """Return the derivative of the state after a period by that before."""
        return self.changes(state, np.eye(state.size), period)[1].T

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
            state, changes = self.changes(state, bundle.T, self.revolution)
            bundle, grown = np.linalg.qr(changes.T)
            row[:] = np.abs(grown.diagonal())
        with np.errstate(divide="ignore"):
            return np.log(np.where(factors > LOST, factors, 0.0)) / self.revolution

    def exponents(self, state: Values, revolutions: int) -> Exponents:
        """Return the largest Lyapunov exponents, and their errors.

        Notes
        -----
        In an axisymmetric system one exponent is 0, that of a
        shift in time, and on a torus one more.
        """
        count = 2 if self.problem.forward is not None else 1
        revolutions = BATCHES * -(-revolutions // BATCHES)
        rates = self.growth(state, count, ALIGNING + revolutions)
        values, errors = means_of_rates(rates[ALIGNING:], BATCHES)
        return Exponents(
            values, errors, revolutions * self.revolution, count, has_tori=True,
            no_stretch=NO_STRETCH,
        )  # fmt: skip
