"""Ramps: the points of a sweep that are followed one after the other, each in exactly one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Literal, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop
from rotor_ida.checks import check_direction
from rotor_ida.model.varied import Varied
from rotor_ida.steady.grid import EXPECTED, Places, reason_of

Direction = Literal["up", "down", "both"]
DIRECTIONS: dict[str | None, tuple[int, ...]] = {
    None: (0,),
    "up": (1,),
    "down": (-1,),
    "both": (1, -1),
}
Point = TypeVar("Point")
Start = TypeVar("Start")
Settled = TypeVar("Settled")
Point_contra = TypeVar("Point_contra", contravariant=True)


@dataclass(frozen=True)
class RampOrder:
    """How the points of a sweep form ramps, by number.

    Parameters
    ----------
    shape : tuple of int
        Number of values along each dimension, directions last.
    directions : ndarray of int
        1 up, -1 down; 0 where each point is a ramp of its own.
    axis : int
        The dimension along which a ramp leads.
    """

    shape: tuple[int, ...]
    directions: npt.NDArray[np.int8]
    axis: int = 0

    @property
    def length(self) -> int:
        """Number of points of each ramp."""
        return self.shape[self.axis] if self.directions[0] else 1

    @property
    def points(self) -> int:
        """Number of points of all ramps."""
        return math.prod(self.shape)

    def __len__(self) -> int:
        return self.points // self.length

    def firsts(self, numbers: int | Places) -> tuple[Places, ...]:
        """Return the indices of the first points of ramps along each dimension.

        Ramps are counted by directions, then by the other dimensions, then along the axis.
        """
        *others, directions = self.shape
        values = others.pop(self.axis)
        counted = (directions, *others, values // self.length)
        direction, *at, first = (np.asarray(each) for each in np.unravel_index(numbers, counted))
        at.insert(self.axis, np.where(self.directions[direction] < 0, values - 1, first))
        return (*at, direction)

    def places(self, number: int) -> Places:
        """Return the positions of a ramp's points among all, in the order of the dimensions."""
        first = self.firsts(number)
        step = int(self.directions[first[-1]]) * math.prod(self.shape[self.axis + 1 :])
        return np.ravel_multi_index(first, self.shape) + step * np.arange(self.length)


class Settling(Protocol[Point_contra, Start, Settled]):
    """How the rotor at a point is followed until it has settled."""

    def settle(self, point: Point_contra, start: Start, stop: Stop, /) -> Settled:
        """Return what it settles on from a start."""

    def failed(self, point: Point_contra, start: Start, reason: str, /) -> Settled:
        """Return the result of a point that could not be followed."""

    def end(self, settled: Settled, /) -> Start | None:
        """Return the start of the next point; None if this one failed."""


@dataclass(frozen=True, slots=True)
class RampJob(Generic[Point, Start, Settled]):
    """A ramp with all that a worker needs to follow it."""

    points: list[Point]
    start: Start
    settling: Settling[Point, Start, Settled]


@dataclass(frozen=True)
class Ramps(Generic[Point, Start, Settled]):
    """All ramps of a sweep, by number.

    Parameters
    ----------
    varied : Varied
        The points. Behind the parameters are the axes ``start`` and ``direction``: 1 up, -1 down; 0
        where each point is a ramp of its own.
    starts : sequence
        The starts.
    settling : Settling
        How the rotor at each point is followed.
    point_at : callable
        Returns the point at a place.
    axis : int
        The dimension along which a ramp leads.
    """

    varied: Varied
    starts: Sequence[Start]
    settling: Settling[Point, Start, Settled]
    point_at: Callable[[Sequence[int]], Point]
    axis: int

    @property
    def order(self) -> RampOrder:
        """How the points form ramps."""
        return RampOrder(self.varied.shape, self.varied.axes["direction"], self.axis)

    @property
    def length(self) -> int:
        """Number of points of each ramp."""
        return self.order.length

    @property
    def points(self) -> int:
        """Number of points of all ramps."""
        return self.order.points

    def __len__(self) -> int:
        return len(self.order)

    def places(self, number: int) -> Places:
        """Return the positions of a ramp's points among all, in the order of the dimensions."""
        return self.order.places(number)

    def job(self, number: int) -> RampJob[Point, Start, Settled]:
        """Return what a worker needs to follow a ramp."""
        places = np.transpose(np.unravel_index(self.places(number), self.varied.shape)).tolist()
        start = self.starts[places[0][-2]]
        return RampJob([self.point_at(place) for place in places], start, self.settling)

    def slowest_first(self) -> Places:
        """Return the numbers of the ramps, the longest ones first.

        Ramps of one disc with a large clearance take longest, as it bounces there.
        """
        numbers = np.arange(len(self))
        if "delta0" not in self.varied.axes:
            return numbers
        firsts = self.order.firsts(numbers)
        clearances = self.varied.axes["delta0"][firsts[self.varied.dims.index("delta0")]]
        return np.argsort(-clearances, kind="stable")


def in_order(
    varied: Varied, starts: int, direction: Direction | None, along: str | None, first: str
) -> tuple[Varied, str]:
    """Return the points with their starts and directions, and the axis along which a ramp leads.

    Without a direction that is empty; `first` is the axis that is chosen if it varies.
    """
    way = check_direction(direction, along, varied.axes, first)
    directions = np.array(DIRECTIONS[direction], dtype=np.int8)
    return varied.over(start=np.arange(starts), direction=directions), way


def settle_along(ramp: RampJob[Point, Start, Settled], stop: Stop) -> list[Settled]:
    """Follow one ramp: each point begins where the last one that did not fail has ended."""
    state, settling, found = ramp.start, ramp.settling, list[Settled]()
    for point in ramp.points:
        if stop[0]:
            break
        try:
            settled = settling.settle(point, state, stop)
        except EXPECTED as error:  # it must not end the other points
            settled = settling.failed(point, state, reason_of(error))
        end = settling.end(settled)
        state = state if end is None else end
        found.append(settled)
    return found


def lost(ramp: RampJob[Point, Start, Settled], reason: str) -> list[Settled]:
    """Return the points of a ramp whose workers died."""
    return [ramp.settling.failed(point, ramp.start, reason) for point in ramp.points]
