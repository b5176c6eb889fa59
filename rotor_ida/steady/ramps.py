"""Ramps: the points of a study that are followed one after the other, each in exactly one.

Where no point begins at the end of another, as those of many run-ups, each is a ramp of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, Literal

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import check_direction
from rotor_ida.model.varied import Varied
from rotor_ida.steady.grid import Answers, Point, Start

Places = npt.NDArray[np.int64]
Direction = Literal["up", "down", "both"]
DIRECTIONS: dict[str | None, tuple[int, ...]] = {
    None: (0,),
    "up": (1,),
    "down": (-1,),
    "both": (1, -1),
}


@dataclass(frozen=True, slots=True)
class RampJob(Generic[Point, Start]):
    """A ramp with all that a worker needs to follow it."""

    points: list[Point]
    start: Start
    answers: Answers[Point, Start]


@dataclass(frozen=True)
class Ramps(Generic[Point, Start]):
    """All ramps of a sweep, by number.

    Parameters
    ----------
    varied : Varied
        The points. Behind the parameters are the axes ``start`` and ``direction``: 1 up, -1 down; 0
        where each point is a ramp of its own.
    starts : sequence
        The starts.
    answers : Answers
        How the rotor at each point is followed.
    point_at : callable
        Returns the point at a place.
    axis : int, optional
        The dimension along which a ramp leads.
    """

    varied: Varied
    starts: Sequence[Start]
    answers: Answers[Point, Start]
    point_at: Callable[[Sequence[int]], Point]
    axis: int | None = None

    @cached_property
    def directions(self) -> npt.NDArray[np.int8]:
        """The directions: 1 up, -1 down; 0 where each point is a ramp of its own."""
        return self.varied.axes.get("direction", np.zeros(1, np.int8))

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each dimension, directions last."""
        shape = self.varied.shape
        return shape if "direction" in self.varied.axes else (*shape, 1)

    @property
    def along(self) -> int:
        """The dimension along which a ramp leads, the last where none does."""
        return len(self.shape) - 2 if self.axis is None else self.axis

    @property
    def length(self) -> int:
        """Number of points of each ramp."""
        return self.shape[self.along] if self.directions[0] else 1

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
        values = others.pop(self.along)
        counted = (directions, *others, values // self.length)
        direction, *at, first = (np.asarray(each) for each in np.unravel_index(numbers, counted))
        at.insert(self.along, np.where(self.directions[direction] < 0, values - 1, first))
        return (*at, direction)

    def places(self, number: int) -> Places:
        """Return the positions of a ramp's points among all, in the order of the dimensions."""
        first = self.firsts(number)
        step = int(self.directions[first[-1]]) * math.prod(self.shape[self.along + 1 :])
        return np.ravel_multi_index(first, self.shape) + step * np.arange(self.length)

    def job(self, number: int) -> RampJob[Point, Start]:
        """Return what a worker needs to follow a ramp."""
        places = np.transpose(np.unravel_index(self.places(number), self.varied.shape)).tolist()
        dims = self.varied.dims
        start = self.starts[places[0][dims.index("start")] if "start" in dims else 0]
        return RampJob([self.point_at(place) for place in places], start, self.answers)

    def slowest_first(self) -> Places:
        """Return the numbers of the ramps, the longest ones first.

        Slow run-ups take longest, and one disc with a large clearance, as it bounces there.
        """
        numbers, dims = np.arange(len(self)), self.varied.dims
        firsts = self.firsts(numbers)
        for name, sign in (("rate", 1.0), ("delta0", -1.0)):
            if name in dims:
                values = self.varied.axes[name][firsts[dims.index(name)]]
                return np.argsort(sign * np.abs(values), kind="stable")
        return numbers


def in_order(
    varied: Varied, starts: int, direction: Direction | None, along: str | None, first: str
) -> tuple[Varied, str]:
    """Return the points with their starts and directions, and the axis along which a ramp leads.

    Without a direction that is empty; `first` is the axis that is chosen if it varies.
    """
    way = check_direction(direction, along, varied.axes, first)
    directions = np.array(DIRECTIONS[direction], dtype=np.int8)
    return varied.over(start=np.arange(starts), direction=directions), way
