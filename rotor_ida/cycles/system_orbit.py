"""An orbit of a rotor system, with the derivatives of its end.

The state of an axisymmetric system is on turning axes, where it may begin at any time and its
period is unknown. That of any other system begins with the unbalance at angle 0 and lasts whole
revolutions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.core.systems import SystemResult
from rotor_ida.schema import MODE, OF_FRICTION_EVENT_KIND
from rotor_ida.simulation.orbit import ENTRY, EXIT
from rotor_ida.steady.response import BOUNCING, FULL_CONTACT, ROLLING
from rotor_ida.steady.system_flow import SystemFlow

# Central differences of the speed are this long, in parts of it; those of time in revolutions.
OF_SPEED, OF_TIME = 1e-6, 1e-5
# Samples of an orbit in a revolution, and at least; steps that refine extreme distances.
SAMPLES_A_REVOLUTION, FEWEST_SAMPLES, REFINEMENTS = 64, 192, 2


@dataclass(frozen=True)
class SystemOrbit:
    """An orbit of a rotor system at one speed.

    Parameters
    ----------
    flow : SystemFlow
        The motion at this speed. Its scales are the same at all speeds of a branch.
    start : ndarray, shape (n,)
        The state at the start, in scaled coordinates as in `SystemFlow`.
    duration : float
        Its duration.
    """

    flow: SystemFlow
    start: Values
    duration: float

    # ---- What a branch asks of an orbit: see `rotor_ida.cycles.special_points.Orbit` ----

    @cached_property
    def end(self) -> Values:
        """The state at the end, with the axes turned back."""
        return self.flow.end_of(self.run)

    @cached_property
    def monodromy(self) -> Values:
        """Derivative of the end by the start."""
        return self.flow.monodromy(self.start, self.duration)

    @cached_property
    def start_rate(self) -> Values:
        """Rate of change of the state on turning axes at the start."""
        return _rate(self.flow, self.start)

    @cached_property
    def end_rate(self) -> Values:
        """Rate of change of the state on turning axes at the end."""
        return _rate(self.flow, self.end)

    @property
    def is_autonomous(self) -> bool:
        """Whether the system is axisymmetric."""
        return self.flow.problem.forward is not None

    @property
    def pair_product(self) -> None:
        """Multipliers of a system do not form pairs."""

    @property
    def rolls(self) -> bool:
        """Whether a contact ever begins to roll; a difference along it is then lost."""
        begins = (self.run.event_kinds == OF_FRICTION_EVENT_KIND["roll"]).any()
        return bool(begins or (self.run.touches["way"] == MODE["rolling"]).any())

    @cached_property
    def sizes(self) -> Values:
        """Smallest and largest distances of the contacts from the centres of their stators."""
        radii = self._extreme_radii
        return np.array([bound(each) for bound in (min, max) for each in radii])

    def halves_agree(self, part: float) -> bool:
        """Return whether it is back at its start after half its duration."""
        half = self.flow.after(self.start, 0.5 * self.duration)
        return bool(np.abs(half - self.start).max() <= part * np.abs(self.start).max())

    # ---- Derivative by the speed, and what a cycle is described by ----

    @cached_property
    def by_speed(self) -> Values:
        """Derivative of the end by the speed."""
        step = OF_SPEED * abs(self.flow.speed)
        ends = [
            at_speed(self.flow, self.flow.speed + each).after(self.start, self.duration)
            for each in (-step, step)
        ]
        return (ends[1] - ends[0]) / (2.0 * step)

    @cached_property
    def run(self) -> SystemResult:
        """The run over the orbit, with its events."""
        return self.flow.run(self.start, np.array([self.duration]), only_events=True)

    @property
    def size(self) -> float:
        """Largest part of its start."""
        return float(np.abs(self.start).max())

    @property
    def missed(self) -> float:
        """Distance of its end from its start, relative to its size."""
        return float(np.linalg.norm(self.end - self.start) / (np.linalg.norm(self.start) or 1.0))

    @property
    def contact_counts(self) -> list[int]:
        """Number of times that each contact closes on a closed orbit.

        At an entry or an exit at the start, rounding may omit one of these.
        """
        numbers, kinds = self.run.event_contacts, self.run.event_kinds
        return [
            max(int(((numbers == number) & (kinds == kind)).sum()) for kind in (ENTRY, EXIT))
            for number in range(len(self.flow.request.laws))
        ]

    @property
    def sliding_changes(self) -> int:
        """Number of times that a contact begins to roll, or slides the other way."""
        kinds = [OF_FRICTION_EVENT_KIND[name] for name in ("roll", "reverse")]
        return int(np.isin(self.run.event_kinds, kinds).sum())

    @property
    def touches(self) -> bool:
        """Whether a contact is ever closed."""
        return any(self.contact_counts) or self.stays_closed

    @property
    def stays_closed(self) -> bool:
        """Whether a contact is closed at the end."""
        return bool((self.run.touches["way"] != MODE["flight"]).any())

    @property
    def response(self) -> str:
        """Kind of response: ``bouncing``, ``full_contact``, or ``rolling`` where it is dry whip."""
        if any(self.contact_counts):
            return BOUNCING
        return ROLLING if self.rolls and self._is_backward else FULL_CONTACT

    @property
    def _is_backward(self) -> bool:
        """Whether a contact that rolls whirls backwards all the time."""
        place, velocity = self.displacements(self.sampled)
        backward = (place.conj() * velocity).imag * math.copysign(1.0, self.flow.speed)
        rolls = (self.sampled.forces[:, :, 3] == MODE["rolling"]).any(axis=0)
        return bool((backward[:, rolls].max(axis=0) < 0.0).any())

    @property
    def nearest_gap(self) -> float:
        """The extreme distance nearest to a stator, less the clearance, in scaled coordinates."""
        gaps = [
            each - contact.clearance
            for radii, contact in zip(
                self._extreme_radii, self.flow.problem.assembly.contacts, strict=True
            )
            for each in radii
        ]
        return min(gaps, key=abs, default=math.inf) / float(self.flow.scales[0])

    @cached_property
    def sample_times(self) -> Values:
        """Times of samples, both ends included."""
        count = math.ceil(SAMPLES_A_REVOLUTION * self.duration / self.flow.revolution)
        return np.linspace(0.0, self.duration, max(count, FEWEST_SAMPLES) + 1)

    @cached_property
    def sampled(self) -> SystemResult:
        """The run with samples, forces and episodes."""
        return self.flow.run(self.start, self.sample_times)

    @cached_property
    def _extreme_radii(self) -> list[Values]:
        """The extreme distances of each contact from the centre of its stator, at least two."""
        times, run = self.sample_times, self.sampled
        squares, rates = self._squares(run)
        found = []
        for number, (square, rate) in enumerate(zip(squares.T, rates.T, strict=True)):
            turns = np.flatnonzero((rate[:-1] > 0.0) != (rate[1:] > 0.0))
            bends = np.diff(rate)[turns] / np.diff(times)[turns]
            at, slopes, values = times[turns], rate[turns], np.array([square.min(), square.max()])
            for _ in range(REFINEMENTS if turns.size else 0):
                # within its interval, also where a minimum and a maximum merge
                at = np.clip(at - slopes / bends, times[turns], times[turns + 1])
                again = self._squares(self.flow.run(self.start, np.append(at, times[-1])))
                values, slopes = (each[:-1, number] for each in again)
            found.append(np.sqrt(values))
        return found

    def _squares(self, run: SystemResult) -> tuple[Values, Values]:
        """Return squares of the distances, and their rates, shape (sample, contact)."""
        place, velocity = self.displacements(run)
        return np.abs(place) ** 2, 2.0 * (place.conj() * velocity).real

    def displacements(self, run: SystemResult) -> ComplexValues:
        """Return displacements of contacts and velocities, shape (2, sample, contact)."""
        rows = self.flow.problem.found.rows
        whole = rows[:, 0] + 1j * rows[:, 1]
        centres = [complex(*each.centre) for each in self.flow.problem.assembly.contacts]
        return np.stack([run.samples[:, 0] @ whole.T - centres, run.samples[:, 1] @ whole.T])


def at_speed(flow: SystemFlow, speed: float) -> SystemFlow:
    """Return the motion at another speed, with states in the same scales."""
    return replace(SystemFlow.at(flow.problem, speed, flow.stop), scales=flow.scales)


def with_tolerance(flow: SystemFlow, rtol: float) -> SystemFlow:
    """Return a motion with another tolerance, and states in the same scales."""
    problem = replace(flow.problem, rtol=rtol)
    return replace(
        SystemFlow.at(problem, flow.speed, flow.stop), scales=flow.scales, watch=flow.watch
    )


def _rate(flow: SystemFlow, state: Values) -> Values:
    """Return the rate of a state on turning axes: of second order in the time."""
    time = OF_TIME * flow.revolution
    near, far = (flow.after(state, each) - state for each in (0.5 * time, time))
    return (4.0 * near - far) / time
