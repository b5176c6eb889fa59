"""Ramps: the points of a study that are followed one after the other, each in exactly one.

Where no point begins at the end of another, as those of many run-ups, each is a ramp of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, Literal, NamedTuple, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop
from rotor_ida.checks import check_direction
from rotor_ida.model.varied import Varied
from rotor_ida.parallel import Progress, Workers
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import ENDING, RESPONSE, STATUS
from rotor_ida.steady.grid import (
    EXPECTED,
    Array,
    Places,
    Rows,
    Table,
    Task,
    form_of,
    reason_of,
    run_study,
)

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
    axis: int = 0

    @property
    def order(self) -> RampOrder:
        """How the points form ramps."""
        if "direction" in self.varied.axes:
            return RampOrder(self.varied.shape, self.varied.axes["direction"], self.axis)
        return RampOrder((*self.varied.shape, 1), np.zeros(1, np.int8), len(self.varied.dims) - 1)

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
        dims = self.varied.dims
        start = self.starts[places[0][dims.index("start")] if "start" in dims else 0]
        return RampJob([self.point_at(place) for place in places], start, self.settling)

    def slowest_first(self) -> Places:
        """Return the numbers of the ramps, the longest ones first.

        Slow run-ups take longest, and one disc with a large clearance, as it bounces there.
        """
        numbers, dims = np.arange(len(self)), self.varied.dims
        firsts = self.order.firsts(numbers)
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


# ---- Points that are answered by figures ----

# Whole numbers of a point that failed; those of other names are 0.
NONE = {"ending": ENDING["failed"], "response": RESPONSE["failed"]}


class Answer(NamedTuple):
    """The figures of a point by the names of columns, and the start of the next one of its ramp."""

    figures: Mapping[str, Any]
    message: str = ""
    failed: bool = False
    end: Any = None


class Row(NamedTuple):
    """A point as a row of a table."""

    values: Table
    message: str
    end: Any


@dataclass(frozen=True, slots=True)
class Answers(Generic[Point, Start]):
    """How points are answered: see `Settling`.

    Parameters
    ----------
    work : callable
        Returns the answer at a point, from a start; a function of a module, or one with some
        arguments given, as processes require. It is given an array whose one value is 0 until it
        should stop.
    kind : dtype
        The columns. Figures that are missing are NaN, or one of `blank`.
    """

    work: Callable[[Point, Start, Stop], Answer]
    kind: np.dtype[np.void]
    blank: Mapping[str, Any] = field(default_factory=lambda: NONE)

    def settle(self, point: Point, start: Start, stop: Stop) -> Row:
        """Return the row of a point, from a start or from where another point ends."""
        return self._row(self.work(point, start, stop))

    def failed(self, _point: Point, _start: Start, reason: str) -> Row:
        """Return the row of a point that failed."""
        return self._row(Answer({}, reason, failed=True))

    def end(self, row: Row) -> Any:
        """Return the start of the next point."""
        return row.end

    def _row(self, answer: Answer) -> Row:
        row = np.zeros(1, self.kind)
        for name in self.kind.names or ():
            blank = math.nan if row[name].dtype.kind == "f" else self.blank.get(name, 0)
            row[name] = answer.figures.get(name, blank)
        row["status"] = STATUS["failed" if answer.failed else "done"]
        return Row(row, answer.message, answer.end)


def answered(
    plan: Ramps[Point, Start, Row],
    question: Question,
    *,
    word: str,
    table: str = "points",
    study: Folder | None,
    workers: Workers,
    progress: Progress | None,
) -> dict[str, Array]:
    """Return the columns of points that are answered by figures: see `run_study`.

    `word` and `table` are names of the rows in a study.
    """
    assert isinstance(plan.settling, Answers)
    kind = plan.settling.kind
    task: Task[RampJob[Point, Start, Row], list[Row]] = Task(
        settle_along, lost, rows_of, form_of(word, table, kind), kind
    )
    return run_study(plan, task, question, study=study, workers=workers, progress=progress).points


def rows_of(rows: Sequence[Row]) -> Rows:
    """Return the rows of points as those of a study."""
    return Rows(np.concatenate([row.values for row in rows]), [row.message for row in rows])
