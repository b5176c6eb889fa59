"""The points of a sweep in ramps (quasi-static run-up and run-down).

Each point of a ramp begins where the one before has ended.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.checks import State
from rotor_ida.errors import SimulationError
from rotor_ida.model.parameters import Rotor
from rotor_ida.model.table import PARAMETERS
from rotor_ida.parallel import Stop
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import FAILED, SettledResponse, failed, follow_to_steady_state

# What solver, physics and memory raise of a point; anything else is a fault of the program's own.
EXPECTED = (SimulationError, ArithmeticError, MemoryError)

Places = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Job:
    """A ramp with all that a worker needs to follow it."""

    rotors: list[Rotor]
    start: State
    options: Options


@dataclass(frozen=True)
class Ramps:
    """All ramps of a sweep, by number.

    Parameters
    ----------
    axes : mapping of str to ndarray
        The values of ``omega``, ``zeta``, ``delta0``, and of what else is not the default [1].
    starts : sequence of tuple of float
        The starts ``(x, y, vx, vy)`` [1].
    directions : sequence of int
        1 up, -1 down; 0 where each speed begins anew, in a ramp of one point.
    options : Options
        How to simulate.
    numbers : frozenset of str
        Parameters beyond the paper's that were given as a number: they are no dimension.
    """

    axes: Mapping[str, Values]
    starts: Sequence[State]
    directions: Sequence[int]
    options: Options
    numbers: frozenset[str] = frozenset()

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values of each parameter, of starts and of directions."""
        sizes = (axis.size for axis in self.axes.values())
        return (*sizes, len(self.starts), len(self.directions))

    @property
    def points(self) -> int:
        """Number of points of all ramps."""
        return int(np.prod(self.shape))

    @property
    def length(self) -> int:
        """Number of points of each ramp."""
        return self.shape[0] if self.directions[0] else 1

    def __len__(self) -> int:
        return self.points // self.length

    def places(self, number: int) -> Places:
        """Return where the points of a ramp stand among all, in the order of the dimensions."""
        omega, others_at = self._indices(number)
        others = np.ravel_multi_index(others_at, self.shape[1:])
        return np.asarray(omega * (self.points // self.shape[0]) + others, dtype=np.int64)

    def job(self, number: int) -> Job:
        """Return what a worker needs to follow a ramp."""
        omegas, (*places, start, _) = self._indices(number)
        names = zip([*self.axes][1:], places, strict=True)
        others = {name: float(self.axes[name][place]) for name, place in names}
        rotors = [
            Rotor(omega=float(self.axes["omega"][omega]), **others) for omega in omegas.tolist()
        ]
        return Job(rotors, self.starts[start], self.options)

    def slowest_first(self) -> Places:
        """Return the numbers of the ramps in an order that leaves no long one to the end.

        Those with much clearance take longest: there the rotor bounces.
        """
        within = np.unravel_index(np.arange(len(self)), self._order)
        clearances = self.axes["delta0"][within[PARAMETERS.index("delta0")]]
        return np.argsort(-clearances, kind="stable")

    @property
    def _order(self) -> tuple[int, ...]:
        """The order in which ramps are counted: directions, other parameters, starts, speeds."""
        return (self.shape[-1], *self.shape[1:-1], self.shape[0] // self.length)

    def _indices(self, number: int) -> tuple[Places, tuple[int, ...]]:
        """Return the speeds of a ramp, by number, and its other indices."""
        direction, *others, first = (int(each) for each in np.unravel_index(number, self._order))
        turn = self.directions[direction]
        omega = np.arange(self.shape[0])[::turn] if turn else np.array([first])
        return omega, (*others, direction)


def follow(job: Job, stop: Stop) -> list[SettledResponse]:
    """Follow one ramp: each point begins where the last one that did not fail has ended."""
    state, settled = job.start, []
    for rotor in job.rotors:
        if stop[0]:
            break
        try:
            point = follow_to_steady_state(rotor, state, job.options, stop=stop)
        except EXPECTED as error:  # it must not end the other points
            reason = f"{type(error).__name__}: {error}".rstrip(": ")
            point = failed(rotor, state, job.options, reason)
        if point.response != FAILED:
            state = point.end
        settled.append(point)
    return settled


def lost(job: Job, reason: str) -> list[SettledResponse]:
    """Return the points of a ramp whose workers died."""
    return [failed(rotor, job.start, job.options, reason) for rotor in job.rotors]
