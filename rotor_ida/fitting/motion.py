"""The motion of a rotor along a measured speed.

One disc is a rotor system of one node here, so that all rotors are followed by one kernel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ComplexValues, Stop, Values
from rotor_ida.core.runs import NO_STOP
from rotor_ida.core.systems import SystemRequest, SystemResult
from rotor_ida.errors import BudgetError
from rotor_ida.model.assembly import Assembly, Canonical, assemble, canonical
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.simulation.spin import Ramp, SpeedProfile
from rotor_ida.simulation.starts import start_of
from rotor_ida.simulation.system_run import request_of, run_to_end

Word = Literal["settled", "rest"]
RTOL = 1e-11
# Radians of the fastest motion that any run may take: some seconds.
ANY_WORK = 2e6


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

    def course(self) -> SpeedProfile:
        """Return the course of the speed, with the angle counted from 0."""
        spins = tuple(
            Ramp(begin, angle - self.angles[0], speed, rate)
            for begin, angle, speed, rate in zip(
                self.ends.tolist(), self.angles.tolist(), self.speeds.tolist(),
                self.rates.tolist(), strict=False,
            )
        )  # fmt: skip
        return SpeedProfile(tuple(self.ends[1:].tolist()), spins)


@dataclass(frozen=True)
class Motion:
    """A motion at the times of a record.

    Parameters
    ----------
    states : ndarray, shape (n, 2, freedom)
        Displacements and velocities in coordinates with a unit mass matrix.
    z : ndarray of complex, shape (n, node)
        Displacements ``x + i y`` of the nodes at which probes look.
    event_times, event_kinds : ndarray, shape (event,)
        The events of all contacts.
    touches_stator : bool
        Whether a contact is ever closed.
    reach : float
        The largest clearance of the contacts with which this motion would just not touch, if all
        keep their ratios to it.
    work : float
        Radians of the fastest motion.
    """

    states: Values
    z: ComplexValues
    event_times: Values
    event_kinds: npt.NDArray[np.int32]
    touches_stator: bool
    reach: float
    work: float

    def touches(self, kind: int) -> Values:
        """Return when contacts begin (1) or end (-1)."""
        return np.asarray(self.event_times[self.event_kinds == kind])


@dataclass(frozen=True)
class Body:
    """A rotor system in the forms in which its motion is followed.

    Parameters
    ----------
    assembly : Assembly
        The system with its stators, contacts and forces.
    found : Canonical
        The same in coordinates with a unit mass matrix.
    """

    assembly: Assembly
    found: Canonical

    @classmethod
    def of(cls, system: RotorSystem) -> Body:
        """Return the body of a system."""
        assembly = assemble(system)
        return cls(assembly, canonical(assembly))

    def turned(self, angle: float) -> Body:
        """Return the same with all unbalance further forward by an angle [rad]."""
        cosine, sine = np.cos(angle), np.sin(angle)
        turn = np.array([[cosine, sine], [-sine, cosine]])
        assembly = replace(self.assembly, unbalance=turn @ self.assembly.unbalance)
        return Body(assembly, replace(self.found, unbalance=turn @ self.found.unbalance))

    def rows(self, nodes: Sequence[str]) -> Values:
        """Return the displacements of nodes by q, shape (node, 2, n)."""
        places = list(self.assembly.system.nodes)
        return self.assembly.node_rows()[[places.index(each) for each in nodes]]

    def motion(
        self, turning: Turning, start: Values | Word, times: Values, nodes: Sequence[str], *,
        budget: float = ANY_WORK, stop: Stop | None = None,
    ) -> Motion:  # fmt: skip
        """Follow the motion along a measured angle, from which the unbalance is counted.

        Parameters
        ----------
        turning : Turning
            The measured angle.
        start : ndarray, shape (2, n), or Word
            Displacement and velocity at time 0; or the word for it.
        times : ndarray
            Times of samples, from 0 to the end of the measured angle [s].
        nodes : sequence of str
            Nodes at which probes look.
        budget : float
            Radians of the fastest motion that it may take.
        stop : ndarray, shape (1,), optional
            Ends the run as soon as it is not 0.

        Raises
        ------
        InputError
            If the rotor cannot be simulated, or has no such start.
        SimulationError
            If the simulation failed.
        BudgetError
            If it takes more than its budget.
        """
        body, speed = self.turned(float(turning.angles[0])), float(turning.speeds[0])
        profile, found = turning.course(), body.found
        fastest = float(max(turning.speeds.max(), turning.at(turning.ends[1:], "left")[1].max()))
        begun = start_of(body.assembly, start, speed) if isinstance(start, str) else start
        request = request_of(
            body.assembly, found, profile, np.array([found.to_y(each) for each in begun]), times,
            profile.ends[-1], rtol=RTOL, speed=speed, fastest_speed=fastest, inertia=0.0,
        )  # fmt: skip
        work = (request.fastest + fastest + _contact_rate(request)) * request.duration
        if work > budget:
            raise BudgetError(
                f"{work:.3g} radians of its fastest motion are more than {budget:.3g}"
            )
        run = run_to_end(replace(request, only_events=True), NO_STOP if stop is None else stop)
        rows = found.rows_in_y(body.rows(nodes))
        return Motion(
            run.samples, _places(rows, run.samples), run.event_times, run.event_kinds,
            bool(run.event_times.size or (run.touches["mode"] != 0).any()),
            _reach(request, run), work,
        )  # fmt: skip


def _places(rows: Values, samples: Values) -> ComplexValues:
    """Return displacements ``x + i y`` at samples, shape (n, row)."""
    # a product of few columns by threads takes many times as long
    x, y = (np.einsum("tn,rn->tr", samples[:, 0], rows[:, axis]) for axis in (0, 1))
    return np.asarray(x + 1j * y)


def _reach(request: SystemRequest, run: SystemResult) -> float:
    """Return the largest clearance with which no contact would touch; 0 without contacts."""
    laws = request.laws
    if not laws.size:
        return 0.0
    centres = laws["offset"] @ [1.0, 1j]
    farthest = np.abs(_places(request.rows, run.samples) - centres).max(axis=0)
    clearances = laws["clearance"]
    return float((farthest / clearances).max() * clearances.max())


def _contact_rate(request: SystemRequest) -> float:
    """Return the rate of the stiffest contact, indented by its clearance."""
    laws = request.laws
    mobilities = (request.rows**2).sum(axis=2).max(axis=1, initial=0.0)
    stiffness = laws["linear"] + laws["hertz"] * np.sqrt(laws["clearance"])
    return float(np.sqrt((stiffness * mobilities).max(initial=0.0)))
