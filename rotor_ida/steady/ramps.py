"""Ramps: the points of a sweep that are followed one after the other, each in exactly one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.steady.grid import Places


@dataclass(frozen=True)
class RampOrder:
    """How the points of a sweep form ramps, by number.

    Parameters
    ----------
    shape : tuple of int
        Number of values along each dimension: speeds first, directions last.
    directions : ndarray of int
        1 up, -1 down; 0 where each point is a ramp of its own.
    """

    shape: tuple[int, ...]
    directions: npt.NDArray[np.int8]

    @property
    def length(self) -> int:
        """Number of points of each ramp."""
        return self.shape[0] if self.directions[0] else 1

    @property
    def points(self) -> int:
        """Number of points of all ramps."""
        return math.prod(self.shape)

    def __len__(self) -> int:
        return self.points // self.length

    @property
    def counted(self) -> tuple[int, ...]:
        """The order in which ramps are counted: directions, other dimensions, speeds."""
        speeds, *others, directions = self.shape
        return (directions, *others, speeds // self.length)

    def indices(self, number: int) -> tuple[Places, tuple[int, ...]]:
        """Return the speeds of a ramp, by number, and its other indices."""
        direction, *others, first = (int(each) for each in np.unravel_index(number, self.counted))
        way = int(self.directions[direction])
        speeds = np.arange(self.shape[0])[::way] if way else np.array([first])
        return speeds, (*others, direction)

    def places(self, number: int) -> Places:
        """Return the positions of a ramp's points among all, in the order of the dimensions."""
        speeds, others_at = self.indices(number)
        others = np.ravel_multi_index(others_at, self.shape[1:])
        return np.asarray(speeds * (self.points // self.shape[0]) + others, dtype=np.int64)
