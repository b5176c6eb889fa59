"""The motion of a machine along a measured speed, with its derivatives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ComplexValues, Stop, Values
from rotor_ida.errors import BudgetError, InputError
from rotor_ida.fitting.variation import (
    LONGEST,
    Moments,
    between,
    grown,
    nodes_of,
    panel_count,
    panels_of,
    slopes_of,
)
from rotor_ida.model.parameters import OF_ROTOR
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.schema.flags import ENTRY, EXIT, OF_FRICTION, PRESS, ROLLS
from rotor_ida.simulation.options import Options, check_can_be_followed
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.run import run
from rotor_ida.simulation.spin import Ramp, SpeedProfile

OPTIONS = Options(rtol=1e-11, atol=1e-13, method="taylor")
# Above this growth a motion is chaotic for a fit: rounding has replaced its start.
LARGEST_GROWTH = 1e6


@dataclass(frozen=True)
class Work:
    """What a motion takes, or may take.

    Parameters
    ----------
    steps : int
        Steps of the simulation.
    panels : int
        Panels of the equations of its derivatives.
    """

    steps: int
    panels: int


# What any motion may take: some seconds.
ANY_WORK = Work(steps=10_000_000, panels=1_000_000)


@dataclass(frozen=True)
class Turning:
    """The measured angle of the rotor: piecewise quadratic in time.

    Parameters
    ----------
    ends : ndarray, shape (n + 1,)
        Ends of the pieces, from 0 [s].
    angles, speeds, rates : ndarray, shape (n,)
        Angle, speed and angular acceleration at the beginning of each [rad, rad/s, rad/s^2].
    """

    ends: Values
    angles: Values
    speeds: Values
    rates: Values

    def at(self, times: Values, side: str = "right") -> tuple[Values, Values, Values]:
        """Return angle, speed and angular acceleration at times."""
        number = np.searchsorted(self.ends[1:-1], times, side=side)  # type: ignore[call-overload]
        since = times - self.ends[number]
        rate, speed = self.rates[number], self.speeds[number]
        return (
            self.angles[number] + (speed + 0.5 * rate * since) * since,
            speed + rate * since,
            rate,
        )

    def course(self, frequency: float, ahead: float) -> SpeedProfile:
        """Return the dimensionless speed, for an unbalance this far ahead of the mark."""
        spins = tuple(
            Ramp(begin * frequency, angle + ahead, speed / frequency, rate / frequency**2)
            for begin, angle, speed, rate in zip(
                self.ends.tolist(), self.angles.tolist(), self.speeds.tolist(),
                self.rates.tolist(), strict=False,
            )
        )  # fmt: skip
        return SpeedProfile(tuple((self.ends[1:] * frequency).tolist()), spins)


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of a motion by its initial state and by each unknown.

    Parameters
    ----------
    slopes : ndarray of complex, shape (n, 4 + k)
        Those of the displacement at the samples.
    entry_slopes, exit_slopes : ndarray, shape (m, 4 + k)
        Those of the times at which contacts begin and end.
    growth : float
        Largest factor by which a small change of the initial state has grown.
    lost : float
        Time at which that first exceeds a million, or infinity [s].
    panels : int
        Panels in which they were computed.
    """

    slopes: ComplexValues
    entry_slopes: Values
    exit_slopes: Values
    growth: float
    lost: float
    panels: int


@dataclass(frozen=True)
class Motion:
    """A motion at the times of a record.

    Parameters
    ----------
    request : MotionRequest
        What was simulated.
    times : ndarray, shape (n,)
        Times of the samples [s].
    orbit : Orbit
        The dimensionless orbit.
    names : sequence of str
        Parameters by which it is differentiated.
    """

    request: MotionRequest
    times: Values
    orbit: Orbit
    names: Sequence[str]

    @cached_property
    def z(self) -> ComplexValues:
        """Displacement ``x + i y`` at the samples [m], shape (n,)."""
        return _displacements(self.orbit, self.request.machine)[0]

    def touches(self, kind: int) -> tuple[Values, Values]:
        """Return when contacts begin (1) or end (-1), and the radial velocities [s, m/s]."""
        # the end of a loose contact is an exit too
        chosen = self.orbit.event_kinds == kind
        machine = self.request.machine
        x, y, vx, vy = self.orbit.event_states[chosen].T
        rise = (x * vx + y * vy) / np.hypot(x, y) * machine.velocity_scale
        return self.orbit.event_times[chosen] / machine.reference_frequency, rise

    @cached_property
    def derivatives(self) -> Derivatives:
        """The derivatives, computed when they are first used.

        Raises
        ------
        InputError
            If the disc rolls or slips the other way on the stator.
        BudgetError
            If they take more than the budget.
        """
        return _derivatives_of(self)


@dataclass(frozen=True)
class MotionRequest:
    """A motion to simulate.

    Parameters
    ----------
    machine : DimensionalRotor
        The machine; its speed is ignored.
    turning : Turning
        The measured angle.
    start : ndarray, shape (4,)
        ``(x, y, vx, vy)`` at time 0 [m, m/s].
    ahead : float
        Angle of the unbalance ahead of the mark [rad].
    budget : Work
        What it may take.
    stop : ndarray, shape (1,), optional
        Stops the simulation as soon as it is not 0.
    """

    machine: DimensionalRotor
    turning: Turning
    start: Values
    ahead: float = 0.0
    budget: Work = ANY_WORK
    stop: Stop | None = None

    def motion(self, times: Values, names: Sequence[str]) -> Motion:
        """Simulate the motion at times from 0 to the end of the measured angle [s].

        Raises
        ------
        InputError
            If the machine cannot be simulated.
        SimulationError
            If the simulation failed.
        BudgetError
            If it takes more than its budget.
        """
        return Motion(self, times, self.orbit(times), names)

    def orbit(self, times: Values) -> Orbit:
        """Return the dimensionless orbit."""
        machine = self.machine
        rotor, frequency = _simulated(machine.rotor()), machine.reference_frequency
        scale = np.repeat([machine.length_scale, machine.velocity_scale], 2)
        x, y, vx, vy = (self.start / scale).tolist()
        check_can_be_followed(rotor, (x, y, vx, vy))
        profile = self.turning.course(frequency, self.ahead)
        sampled = np.minimum(times * frequency, profile.ends[-1])
        return run(
            rotor, (x, y, vx, vy), profile.ends[-1], sampled, OPTIONS,
            profile=profile, most_steps=self.budget.steps, stop=self.stop,
        )  # fmt: skip


def _derivatives_of(motion: Motion) -> Derivatives:
    """Return the derivatives of a motion."""
    request, machine, turning = motion.request, motion.request.machine, motion.request.turning
    stretches = _stretches_of(motion.orbit, machine, turning)
    ends, stretch = _panels_of(motion, stretches)
    nodes = nodes_of(ends)
    seen = np.sort(np.concatenate([nodes.ravel(), ends]))
    z, v = _displacements(request.orbit(seen), machine)

    def moments(at: Values, stretch: npt.NDArray[np.intp], side: str = "right") -> Moments:
        place = np.searchsorted(seen, at)
        angle, speed, rate = turning.at(at, side)
        pull = (speed**2 - 1j * rate) * np.exp(1j * (angle + request.ahead))
        return Moments(
            z[place], v[place], pull, stretches.pushes[stretch], stretches.slides[stretch]
        )

    inside = slopes_of(machine, moments(nodes.ravel(), np.repeat(stretch, 3)), motion.names)
    shape = (*nodes.shape, 2)
    grown_to = grown(ends, *(each.reshape(*shape, -1) for each in inside))
    first = _rates_at(slopes_of(machine, moments(ends[:-1], stretch), motion.names), grown_to[:-1])
    # rates go on from panel to panel, but not where a stretch ends
    last = np.roll(first, -1, axis=0)
    end = np.flatnonzero(np.diff(stretch, append=-1))
    last[end] = _rates_at(
        slopes_of(machine, moments(ends[end + 1], stretch[end], "left"), motion.names),
        grown_to[end + 1],
    )
    growth = np.linalg.norm(_scaled(grown_to[:, :, :4], turning), axis=(1, 2))
    lost = ~(growth <= LARGEST_GROWTH)
    entry_slopes, exit_slopes = (
        _slopes_of_times(kind, motion, ends, grown_to) for kind in (ENTRY, EXIT)
    )
    return Derivatives(
        slopes=between(ends, grown_to, (first, last), motion.times),
        entry_slopes=entry_slopes,
        exit_slopes=exit_slopes,
        growth=float(growth.max()),
        lost=float(ends[lost.argmax()]) if lost.any() else math.inf,
        panels=stretch.size,
    )


def _scaled(grown_to: Values, turning: Turning) -> Values:
    """Return derivatives by the initial state, with velocities relative to the speed."""
    scale = np.array([1.0, 1.0, *2 * [float(turning.speeds.max())]])
    return np.asarray(grown_to / scale[:, None] * scale)


def _simulated(rotor: Rotor) -> Rotor:
    """Return the rotor with values near 0 raised to the smallest that can be simulated."""
    least = {name: OF_ROTOR[name].smallest for name in rotor.beyond}
    tiny = {name: each for name, each in least.items() if 0.0 < rotor.beyond[name] < each}
    return replace(rotor, **tiny) if tiny else rotor


def _displacements(orbit: Orbit, machine: DimensionalRotor) -> tuple[ComplexValues, ComplexValues]:
    """Return displacements and velocities of an orbit."""
    x, y, vx, vy = orbit.states.T
    return machine.length_scale * (x + 1j * y), machine.velocity_scale * (vx + 1j * vy)


@dataclass(frozen=True)
class _Stretches:
    """Stretches between events or changes of the speed: whether surfaces press, and slide."""

    ends: Values
    pushes: Values
    slides: Values


def _stretches_of(orbit: Orbit, machine: DimensionalRotor, turning: Turning) -> _Stretches:
    """Return the stretches of an orbit."""
    kinds, times = orbit.event_kinds, orbit.event_times / machine.reference_frequency
    rolls = orbit.modes is not None and bool((orbit.modes == ROLLS).any())
    if rolls or np.isin(kinds, OF_FRICTION).any():
        raise InputError(
            "machine must slide one way on the stator in the fitted motion, but the disc rolls or "
            "slips back: fit without friction, or fit another part"
        )
    presses = np.array([orbit.starts_in_contact, *np.isin(kinds, (ENTRY, PRESS))], dtype=float)
    slides = np.zeros(presses.size) if orbit.modes is None else orbit.modes.astype(float)
    whole = np.unique(np.concatenate([turning.ends, times]))
    whole = whole[np.append(np.diff(whole) > np.spacing(whole[-1]), True)]
    number = np.searchsorted(times, 0.5 * (whole[1:] + whole[:-1]))
    return _Stretches(whole, presses[number], slides[number] * presses[number])


def _panels_of(motion: Motion, stretches: _Stretches) -> tuple[Values, npt.NDArray[np.intp]]:
    """Return the ends of panels, and the stretch in which each lies."""
    request = motion.request
    hertz = request.machine.contact_exponent > 1.0
    longest = _longest_panels(motion.orbit, request.machine, request.turning)
    count = panel_count(stretches.ends, stretches.pushes, longest, hertz=hertz)
    if count > request.budget.panels:
        raise BudgetError(
            f"{count:.3g} steps of the variational equations are more than {request.budget.panels}"
        )
    return panels_of(stretches.ends, stretches.pushes, longest, hertz=hertz)


def _longest_panels(
    orbit: Orbit, machine: DimensionalRotor, turning: Turning
) -> tuple[float, float]:
    """Return the longest panels allowed in flight and in contact [s]."""
    speeds = np.abs(turning.at(turning.ends[1:], "left")[1])
    fastest = max(float(speeds.max()), float(turning.speeds.max()), machine.damping / machine.mass)
    flight = fastest + math.sqrt(machine.shaft_stiffness / machine.mass)
    found = orbit.contacts["peak_root"] ** 2
    depth = float(np.nanmax(found)) if np.isfinite(found).any() else 0.0
    deepest = depth * machine.length_scale
    exponent = machine.contact_exponent
    stiff = machine.contact_stiffness * exponent * deepest ** (exponent - 1.0)
    contact = flight + math.sqrt(stiff / machine.mass)
    return LONGEST / flight, LONGEST / contact


def _rates_at(slopes: tuple[Values, Values], grown_to: Values) -> Values:
    """Return the time derivatives of velocity differences, shape (p, 2, 4 + k)."""
    rates = slopes[0] @ grown_to
    rates[:, :, 4:] += slopes[1]
    return np.asarray(rates)


def _slopes_of_times(kind: int, motion: Motion, ends: Values, grown_to: Values) -> Values:
    """Return the derivatives of the times at which contacts begin, or end.

    From ``|z(t)| = d``: ``r' dt = d(clearance) - (z/|z|) . dz``.
    """
    times, rise = motion.touches(kind)
    # events are ends of panels, but for rounding
    place = np.searchsorted(0.5 * (ends[1:] + ends[:-1]), times)
    x, y = motion.orbit.event_states[motion.orbit.event_kinds == kind].T[:2]
    here, names = grown_to[place], list(motion.names)
    outwards = -(x[:, None] * here[:, 0] + y[:, None] * here[:, 1]) / np.hypot(x, y)[:, None]
    if "clearance" in names:
        outwards[:, 4 + names.index("clearance")] += 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(outwards / rise[:, None])
