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
from rotor_ida.closed_forms.receptances import solved_motions
from rotor_ida.core.runs import NO_STOP
from rotor_ida.core.system_requests import ByParameter, SystemRequest, SystemResult, law_changes
from rotor_ida.errors import BudgetError
from rotor_ida.model.assembly import Assembly, Canonical, assemble, canonical
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.schema.flags import ENTRY, EXIT
from rotor_ida.simulation.spin import Ramp, SpeedProfile
from rotor_ida.simulation.starts import start_of_system
from rotor_ida.simulation.system_run import laws_of, request_of, run_to_end

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
class Change:
    """A small change beside a motion, over its size.

    Parameters
    ----------
    start : ndarray, shape (2, n)
        Of displacement and velocity at time 0, in coordinates with a unit mass matrix.
    by : ByParameter, optional
        Of the body.
    """

    start: Values
    by: ByParameter | None = None


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
    z_by : ndarray of complex, shape (n, node, change)
        Derivatives of the displacements by changes of start and body.
    times_by : ndarray, shape (event, change)
        Derivatives of the times of entries and exits; 0 of other events.
    """

    states: Values
    z: ComplexValues
    event_times: Values
    event_kinds: npt.NDArray[np.int32]
    touches_stator: bool
    reach: float
    work: float
    z_by: ComplexValues
    times_by: Values

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

    def free_whirls(self, nodes: Sequence[str], speeds: Values) -> ComplexValues:
        """Return the whirl of nodes by unbalance without contact, over the speed^2.

        The forward and the backward part have the shape (speed, node).
        """
        unbalance = self.assembly.unbalance[0] - 1j * self.assembly.unbalance[1]
        motions = solved_motions(self.assembly, speeds, unbalance[:, None])[:, :, 0]
        rows = self.rows(nodes)
        ahead, back = (motions @ (rows[:, 0] + turn * rows[:, 1]).T for turn in (1j, -1j))
        return np.asarray(0.5 * np.stack([ahead, back.conj()]), complex)

    def begun(self, start: Values | Word, speed: float) -> Values:
        """Return displacement and velocity at time 0, shape (2, n)."""
        return start_of_system(self.assembly, start, speed) if isinstance(start, str) else start

    def change(
        self, before: Body, after: Body, step: float, turning: Turning, start: Values | Word
    ) -> Change:  # fmt: skip
        """Return the change by a number, by a step of which two bodies nearby differ."""
        ahead, speed = float(turning.angles[0]), float(turning.speeds[0])
        both, found = [each.turned(ahead) for each in (before, after)], self.found
        starts = [each.begun(start, speed) for each in both]
        less, more = (laws_of(each.assembly) for each in both)

        def difference(name: str) -> Values:
            numbers = [getattr(each.assembly, name) for each in both]
            one, other = (0.0 if each is None else each for each in numbers)
            return np.asarray((other - one) / step)

        def matrix(name: str) -> Values | None:
            moved = difference(name)
            return found.matrix_in_y(moved) if moved.any() else None

        by = ByParameter(
            mass=matrix("mass"), stiffness=matrix("stiffness"), damping=matrix("damping"),
            unbalance=found.rows_in_y(difference("unbalance")),
            force=found.rows_in_y(difference("force")[np.newaxis])[0],
            laws=law_changes(laws_of(self.assembly), less, more, step),
        )  # fmt: skip
        moved = (starts[1] - starts[0]) / step
        return Change(np.array([found.to_y(each) for each in moved]), by)

    def motion(
        self, turning: Turning, start: Values | Word, times: Values, nodes: Sequence[str], *,
        budget: float = ANY_WORK, stop: Stop | None = None, changes: Sequence[Change] = (),
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
        changes : sequence of Change
            Changes by which derivatives are wanted, those of the start alone first.

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
        begun = body.begun(start, speed)
        request = request_of(
            body.assembly, found, profile, np.array([found.to_y(each) for each in begun]), times,
            profile.ends[-1], rtol=RTOL, speed=speed, fastest_speed=fastest, inertia=0.0,
        )  # fmt: skip
        work = (request.fastest + fastest + _contact_rate(request)) * request.duration
        if work > budget:
            raise BudgetError(
                f"{work:.3g} radians of its fastest motion are more than {budget:.3g}"
            )
        rows = found.rows_in_y(body.rows(nodes))
        asked = replace(_with_changes(request, changes, rows), only_events=True)
        run = run_to_end(asked, NO_STOP if stop is None else stop)
        return Motion(
            run.samples, _places(rows, run.samples), run.event_times, run.event_kinds,
            bool(run.event_times.size or (run.touches["mode"] != 0).any()),
            _reach(request, run), work,
            run.sample_columns[:, ::2] + 1j * run.sample_columns[:, 1::2],
            _times_by(request, run, changes),
        )  # fmt: skip


def _with_changes(
    request: SystemRequest, changes: Sequence[Change], rows: Values
) -> SystemRequest:  # fmt: skip
    """Return a run and its small changes, whose displacements at the nodes are sampled."""
    if not changes:
        return request
    columns = np.zeros((len(changes), 2 * len(request.force) + len(request.laws)))
    columns[:, : 2 * len(request.force)] = [each.start.ravel() for each in changes]
    by = [each.by for each in changes if each.by is not None]
    return replace(
        request, columns=columns, parameters=by, watched=rows.reshape(-1, len(request.force))
    )


def _times_by(request: SystemRequest, run: SystemResult, changes: Sequence[Change]) -> Values:
    """Return the derivatives of the times of entries and exits by changes.

    At these a distance is a clearance: ``dt = (d clearance - e.du)/(e.u')``, with e along u.
    """
    moved = np.zeros((run.event_times.size, len(changes)))
    at = np.isin(run.event_kinds, (ENTRY, EXIT))
    if not changes or not at.any():
        return moved
    contacts, states = run.event_contacts[at], run.event_states[at]
    place, rate = (
        np.einsum("erk,ek->er", request.rows[contacts], states[:, each]) for each in (0, 1)
    )
    place -= request.laws["offset"][contacts]
    along = place / np.linalg.norm(place, axis=1)[:, np.newaxis]
    wider = np.zeros((len(request.laws), len(changes)))
    for column, each in enumerate(changes):
        if each.by is not None:
            wider[:, column] = each.by.laws["clearance"]
    rise = wider[contacts] - np.einsum("er,erc->ec", along, run.event_columns[at])
    moved[at] = rise / (along * rate).sum(axis=1)[:, np.newaxis]
    return moved


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
