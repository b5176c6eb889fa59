"""The rotors whose starts are labelled: one disc or more, or a rotor system and its node.

The state of the node determines that of the rest of a rotor system. Each start is followed
separately until it has settled; those of one disc are followed side by side
(`rotor_ida.basins.fates`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np
import xarray as xr
from scipy.linalg import null_space

from rotor_ida.arrays import Column, Stop, Values
from rotor_ida.basins.attractors import Attractors, Found, kind_of
from rotor_ida.basins.following import tighter_than
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED, Labels
from rotor_ida.basins.starts import Starts
from rotor_ida.checks import check_between, check_name, check_real
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import Rotor, check_no_load
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.model.varied import Varied
from rotor_ida.simulation.options import check_can_be_followed
from rotor_ida.simulation.starts import Start
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow
from rotor_ida.steady import response
from rotor_ida.steady.follow import settle_system
from rotor_ida.steady.grid import EXPECTED, reason_of
from rotor_ida.steady.points import (
    Turnings,
    VariedSystem,
    figures_of,
    places_of,
    point_of,
    state_of_start,
    turning_speeds,
)

# Range of the error per step [1].
TIGHTEST, LOOSEST = 1e-12, 1e-4
# The explicit method needs too many steps for stiffer rotors.
MOST_DAMPING = 20.0
MOST_CONTACT_DAMPING = 50.0
OF_SYSTEM = "for a basin of a rotor system"
# Tolerance of the runs by default.
RTOL = 1e-10
# The smallest batch: every start is followed by itself.
SMALLEST = 4

# Below this part of the stiffest motion a motion is held by nothing but rounding.
HELD = 1e-13


class Subjects(NamedTuple):
    """Rotors whose starts are labelled.

    Parameters
    ----------
    varied : Varied
        The rotors, of a system in its modes.
    points : sequence of Rotor or KnockedSystem
        Each of them.
    rtol : float or None
        Error allowed in a step, or tolerance of a run; None if it is to be chosen.
    given : mapping
        Arguments of a question besides the starts, of a system.
    told : mapping
        Attributes of a result.
    """

    varied: Varied
    points: Sequence[Rotor | KnockedSystem]
    rtol: float | None
    given: Mapping[str, Any]
    told: Mapping[str, object]

    @property
    def coordinates(self) -> dict[str, Column]:
        """The coordinates of a result besides the starts."""
        places = {} if self.varied.system is None else places_of_contacts(self.varied)
        return {**self.varied.coordinates, **places}


def subjects_of(
    asked: Varied, what: str, *, node: object, start: Start | xr.Dataset, modes: int | None,
    rtol: float | None, loaded: bool = False,
) -> Subjects:  # fmt: skip
    """Return the rotors that a function is asked for, checked; `what` is what it computes.

    A load is allowed only if `loaded`.
    """
    if asked.system is None:
        rotors = [check_rotor(each, what, loaded=loaded) for each in asked.rotors()]
        tolerance = None if rtol is None else check_between("rtol", rtol, TIGHTEST, LOOSEST)
        return Subjects(asked, rotors, tolerance, {}, {})
    name = check_name("node", node)
    few, points = _knocked_systems(asked, name, start, modes, rtol)
    given = {"rotor": asked.base, **asked.design, "node": name, "start": few.kept[0],
             "modes": modes}  # fmt: skip
    return Subjects(few.varied, points, few.rtol, given, {"knocked_node": name})


def one_rotor(rotor: object, speed: object) -> Varied:
    """Return one disc, or a rotor system at a speed, in which nothing varies."""
    if isinstance(rotor, RotorSystem):
        (at,) = turning_speeds(check_real("speed", speed), OF_SYSTEM)
        return Varied({SPEED: np.asarray(at)}, rotor)
    assert isinstance(rotor, Rotor)
    return Varied({name: np.asarray(value) for name, value in rotor.given.items()})


def check_rotor(rotor: Rotor, what: str = "a basin", *, loaded: bool = False) -> Rotor:
    """Return a rotor whose starts can be labelled; a load is allowed only if `loaded`."""
    if not loaded:
        check_no_load(
            rotor.load, what, "which begins with whirls that no load allows, where "
            "basin_fractions and touchdown_report label starts",
        )  # fmt: skip
    if rotor.omega == 0.0 < min(rotor.load, rotor.friction):
        raise InputError(
            "{name} must be above 0 for {what} under a load with friction, got {value}: friction "
            "allows many positions of rest",
            name="omega", what=what, value=0.0,
        )  # fmt: skip
    check_can_be_followed(rotor, (0.0, 0.0, 0.0, 0.0), settling=True)
    if not 0.0 < rotor.zeta <= MOST_DAMPING:
        raise InputError(
            "{name} must be above 0 and at most {most:g} for {what}, got {value}",
            name="zeta", most=MOST_DAMPING, what=what, value=rotor.zeta,
        )  # fmt: skip
    if rotor.contact_damping > MOST_CONTACT_DAMPING:
        raise InputError(
            "{name} must be at most {most:g} for {what}, got {value}",
            name="contact_damping", most=MOST_CONTACT_DAMPING, what=what,
            value=rotor.contact_damping,
        )  # fmt: skip
    return rotor


# ---- A rotor system ----


@dataclass(frozen=True, slots=True)
class KnockedSystem:
    """A rotor system at a speed, with a state for each state of one node.

    Parameters
    ----------
    problem : SettlingProblem
        The system.
    speed : float
        Its spin speed.
    base : ndarray, shape (n,)
        The state with the node at rest on the axis: displacements and velocities in coordinates
        with a unit mass matrix, and speeds of races.
    shapes : ndarray, shape (n, 4)
        How that changes with each component of the node's state.
    """

    problem: SettlingProblem
    speed: float
    base: Values
    shapes: Values

    @classmethod
    def at(cls, problem: SettlingProblem, speed: float, node: str, start: Start) -> Self:
        """Return a system whose node is knocked, and which starts as given otherwise."""
        system = problem.assembly.system
        system.rows(node)  # refuses an unknown one
        rows = problem.found.rows_in_y(problem.assembly.node_rows()[list(system.nodes).index(node)])
        if np.linalg.matrix_rank(rows) < 2:
            raise InputError(f"node must move along x and along y, but {node!r} does not")
        begun, size = state_of_start(problem, start, speed), problem.assembly.size
        found = problem.at(speed).found
        shapes = np.zeros((begun.size, 4))
        shapes[:size, :2] = pulled_shapes(found.stiffness, rows)
        shapes[size : 2 * size, 2:] = np.linalg.pinv(rows)
        own = np.concatenate([rows @ begun[:size], rows @ begun[size : 2 * size]])
        return cls(problem, speed, begun - shapes @ own, shapes)

    @property
    def rtol(self) -> float:
        """Tolerance of a run."""
        return self.problem.rtol

    @property
    def smallest(self) -> int:
        """Fewest starts that are worth a batch: each is followed by itself."""
        return SMALLEST

    @property
    def columns(self) -> np.dtype[np.void]:
        """The columns of the rows of its attractors."""
        return point_of(self.problem)

    def flow(self, stop: Stop) -> SystemFlow:
        """Return how the system moves."""
        return SystemFlow.at(self.problem, self.speed, stop)

    def listed(self) -> list[np.void]:
        """Return no attractors: only those that starts end on are known."""
        return []

    def scouted(self, starts: Starts, count: int, *, drawn: bool, stop: Stop) -> Self:  # noqa: ARG002
        """Return the same: a few starts show nothing of the others."""
        return self

    def states(self, flow: SystemFlow, starts: Values) -> Values:
        """Return the states of a flow for starts of the node, shapes (4, m) and (m, n)."""
        return (self.base + starts.T @ self.shapes.T) / flow.scales

    def label(self, states: Values, stop: Stop) -> Found:
        """Follow starts of the node, shape (4, n), each until it has settled."""
        flow, count, reason = self.flow(stop), states.shape[1], ""
        met, begun = Attractors(flow), self.states(flow, states)
        labels, times = np.full(count, NOT_COMPUTED, np.int16), np.full(count, np.nan, np.float32)
        for number, state in enumerate(begun):
            try:
                row = settled_row(flow, state)
            except EXPECTED as error:
                if stop[0]:
                    break
                reason = reason or reason_of(error)
                continue
            is_open = kind_of(row) == response.UNRESOLVED
            labels[number] = UNDECIDED if is_open else met.number_of(row)
            times[number] = row["revolutions"] * flow.revolution
        closely = flow.but(rtol=tighter_than(self.rtol))
        return Found(
            labels, times, met.rows, reason=reason,
            again=lambda chosen: ends_of(met, closely, begun[chosen], len(met.rows)),
        )  # fmt: skip


def settled_row(flow: SystemFlow, state: Values) -> np.void:
    """Return the response on which a flow settles, as a row."""
    settled = settle_system(flow, state)
    row: np.void = np.zeros(1, point_of(flow.problem))[0]
    for name, figure in figures_of(settled, flow).items():
        row[name] = figure
    if kind_of(row) == response.TOUCHING:  # in the limit it just touches
        touched, gaps = row["touched"] == 1, flow.clearances
        row["largest_force"][touched], row["radius_max"][touched] = 0.0, gaps[touched]
        row["radius_min"][touched] = np.abs(gaps - 2.0 * row["amplitude"])[touched]
    return row


def ends_of(met: Attractors, flow: SystemFlow, states: Values, new: int = UNDECIDED) -> Labels:
    """Return the numbers of the attractors to which states, shape (n, m), lead; or UNDECIDED.

    One that was not met has the number `new`.
    """
    labels = np.full(len(states), UNDECIDED, np.int16)
    for number, state in enumerate(states):
        if flow.stop[0]:
            break
        try:
            found = met.find(settled_row(flow, state))
        except EXPECTED:
            continue
        labels[number] = new if found is None else found
    return labels


def _knocked_systems(
    asked: Varied, node: str, start: Start | xr.Dataset, modes: int | None, rtol: float | None
) -> tuple[VariedSystem, list[KnockedSystem]]:
    """Return a system whose speed and parameters vary, and its node knocked at each point."""
    system = VariedSystem.of(asked, [start], modes, RTOL if rtol is None else rtol, "start")
    turnings = Turnings(system.varied, system.rtol)
    problem = turnings.checked()
    if not problem.assembly.contacts:
        raise InputError("contacts must be at least one for a basin of a rotor system, got none")
    if not problem.has_damping:
        raise InputError(
            "damping must be above 0 for a basin: without damping there are no attractors, got none"
        )
    points = [turnings.at(place) for place in np.ndindex(system.varied.shape)]
    return system, [KnockedSystem.at(*each, node, system.starts[0]) for each in points]


def places_of_contacts(varied: Varied) -> dict[str, Column]:
    """Return the nodes, and the contacts with their stators and circles."""
    contacts = varied.base.contacts
    stators = [
        each.stator if isinstance(each.stator, str) else "" if each.stator is None else "stator"
        for each in contacts
    ]
    return {
        **places_of(varied), "contact_stator": ("contact", np.array(stators, str)),
        "centre_x": ("contact", np.array([each.centre[0] for each in contacts])),
        "centre_y": ("contact", np.array([each.centre[1] for each in contacts])),
    }  # fmt: skip


def pulled_shapes(stiffness: Values, rows: Values) -> Values:
    """Return the static deflections under forces at a node that move it by 1, shape (n, 2).

    Parameters
    ----------
    stiffness : ndarray, shape (n, n)
        Stiffness matrix in coordinates with a unit mass matrix.
    rows : ndarray, shape (2, n)
        Displacement of the node.

    Notes
    -----
    Of a symmetric matrix that is the shape with the least elastic energy. Where motions cost none,
    as those of a rotor without supports, it is the one of these that moves the least mass.

    Examples
    --------
    Two equal masses on a spring; the second is free and follows:

    >>> pulled_shapes(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([[1.0, 0.0]])).round(12)
    array([[1.],
           [1.]])
    """
    struck, others = np.linalg.pinv(rows), null_space(rows)
    held = others.T @ stiffness
    return np.asarray(struck - others @ np.linalg.lstsq(held @ others, held @ struck, HELD)[0])
