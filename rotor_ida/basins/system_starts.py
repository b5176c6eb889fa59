"""How the whole of a rotor system starts where one of its nodes is knocked to a place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import xarray as xr
from scipy.linalg import null_space

from rotor_ida.arrays import Values
from rotor_ida.checks import check_real
from rotor_ida.errors import InputError
from rotor_ida.model.varied import Varied
from rotor_ida.simulation.starts import Start
from rotor_ida.simulation.systems.flow import SettlingProblem, SystemFlow
from rotor_ida.steady.system_sweep import (
    Turnings,
    VariedSystem,
    state_of_start,
    turning_speeds,
)

# Tolerance of the runs by default.
RTOL = 1e-10

# Below this part of the stiffest motion a motion is held by nothing but rounding.
HELD = 1e-13


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
        system, found = problem.assembly.system, problem.found
        system.rows(node)  # refuses an unknown one
        rows = found.rows_in_y(problem.assembly.node_rows()[list(system.nodes).index(node)])
        if np.linalg.matrix_rank(rows) < 2:
            raise InputError(f"node must move along x and along y, but {node!r} does not")
        begun, size = state_of_start(problem, start, speed), problem.assembly.size
        shapes = np.zeros((begun.size, 4))
        shapes[:size, :2] = pulled_shapes(found.stiffness, rows)
        shapes[size : 2 * size, 2:] = np.linalg.pinv(rows)
        own = np.concatenate([rows @ begun[:size], rows @ begun[size : 2 * size]])
        return cls(problem, speed, begun - shapes @ own, shapes)

    def states(self, flow: SystemFlow, starts: Values) -> Values:
        """Return the states of a flow for starts of the node, shapes (4, m) and (m, n)."""
        return (self.base + starts.T @ self.shapes.T) / flow.scales


def knocked_systems(
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


def one_speed(speed: object) -> Values:
    """Return a spin speed at which a system can be followed, shape (1,)."""
    return turning_speeds(check_real("speed", speed), "for a basin of a rotor system")


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
