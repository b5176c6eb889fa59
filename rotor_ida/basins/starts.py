"""The starts of which basins are computed: on a plane of states, or at random in a box.

A start has the components ``x y vx vy`` at time 0, with the unbalance along x: of one disc, or of
a node of a rotor system.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    COMPONENTS,
    MOST_POINTS_OF_STUDY,
    check_count,
    check_increasing,
    check_seed,
    check_vector,
    is_scalar,
)
from rotor_ida.errors import InputError
from rotor_ida.simulation.options import LARGEST
from rotor_ida.simulation.starts import box_of, drawn_from

# Returns the starts from one number up to another, shape (4, n).
Starts = Callable[[int, int], Values]
# Without a study all labels are kept in memory.
MOST_STARTS = 100_000_000
# Number of labels processed at a time: all of them may not fit into memory.
STRETCH = 2**20


@dataclass(frozen=True, slots=True)
class Plane:
    """Starts on a grid over two components: all of the first value, then all of the next.

    Parameters
    ----------
    axes : dict of str to ndarray
        The increasing values of the two components that vary, in the order of the components.
    fixed : dict of str to float
        The other two components.
    """

    verb: ClassVar[str] = "basin"

    axes: dict[str, Values]
    fixed: dict[str, float]

    @classmethod
    def of(cls, **given: npt.ArrayLike) -> Self:
        """Return the plane of four components, two of them arrays."""
        varying = [name for name, value in given.items() if not is_scalar(name, value)]
        if len(varying) != 2:
            raise InputError(
                "exactly two of x, y, vx, vy must be arrays and two numbers, got "
                f"{len(varying)} array{'' if len(varying) == 1 else 's'}"
                f"{': ' if varying else ''}{', '.join(varying)}"
            )
        checked = {
            name: check_vector(name, value, largest=LARGEST) for name, value in given.items()
        }
        axes = {name: check_increasing(name, checked[name]) for name in varying}
        return cls(axes, {name: each.item() for name, each in checked.items() if name not in axes})

    @property
    def given(self) -> dict[str, Any]:
        """The components, as arguments."""
        return {**self.axes, **self.fixed}

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of values along each axis."""
        return tuple(values.size for values in self.axes.values())

    @property
    def count(self) -> int:
        """The number of starts."""
        return math.prod(self.shape)

    def starts(self, first: int, last: int) -> Values:
        """Return the starts from one number up to another, shape (4, n)."""
        places = np.unravel_index(np.arange(first, last), self.shape)
        states = np.empty((len(COMPONENTS), last - first))
        for name, value in self.fixed.items():
            states[COMPONENTS.index(name)] = value
        for (name, values), place in zip(self.axes.items(), places, strict=True):
            states[COMPONENTS.index(name)] = values[place]
        return states


@dataclass(frozen=True, slots=True)
class Box:
    """Starts drawn independently and uniformly from a range of each component.

    Parameters
    ----------
    limits : ndarray, shape (4, 2)
        The ends of the ranges.
    count : int
        The number of starts.
    seed : int
        Seed of the random numbers.
    """

    verb: ClassVar[str] = "basin_fractions"

    limits: Values
    count: int
    seed: int

    @classmethod
    def of(
        cls, starts: object, seed: object, most: int = MOST_POINTS_OF_STUDY, **given: npt.ArrayLike
    ) -> Self:
        """Return the box of ranges or numbers, one for each component; refuse too many starts."""
        count = check_count("starts", starts, maximum=most)
        return cls(box_of(given, count), count, check_seed(seed))

    @property
    def given(self) -> dict[str, Any]:
        """The number of starts, the seed and the ranges, as arguments."""
        ranges = {name: each.tolist() for name, each in zip(COMPONENTS, self.limits, strict=True)}
        return {"starts": self.count, "seed": self.seed, **ranges}

    @property
    def attributes(self) -> dict[str, object]:
        """The same as attributes of a result."""
        ranges = zip(COMPONENTS, self.limits, strict=True)
        drawn: dict[str, object] = {"starts": self.count, "seed": self.seed}
        return drawn | {f"range_{name}": each for name, each in ranges}

    def starts(self, first: int, last: int) -> Values:
        """Return the starts from one number up to another, shape (4, n)."""
        return drawn_from(self.limits, self.seed, first, last)


def check_number_of_starts(count: int, study: object) -> None:
    """Refuse more starts than can be kept in memory, or in a study."""
    most = MOST_STARTS if study is None else MOST_POINTS_OF_STUDY
    if count > most:
        raise InputError(f"starts must be at most {most}, got {count}; a study can store more")


def stretches(size: int) -> Iterator[slice]:
    """Yield the slices in which a flat array of labels is processed.

    Examples
    --------
    >>> list(stretches(5))
    [slice(0, 5, None)]
    """
    for first in range(0, size, STRETCH):
        yield slice(first, min(first + STRETCH, size))
