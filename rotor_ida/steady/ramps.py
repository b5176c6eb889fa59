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
