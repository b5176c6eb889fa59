"""A question of one motion, asked at each point of a `Varied`: its answers on labelled dimensions.

The rotor at each point is a job of a study, as ramps are in a sweep.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
import xarray as xr

from rotor_ida.arrays import Stop
from rotor_ida.model.varied import Varied
from rotor_ida.parallel import Progress, Workers
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import STATUS
from rotor_ida.steady.grid import (
    EXPECTED,
    Places,
    Rows,
    Table,
    Task,
    check_size,
    form_of,
    labelled_points,
    reason_of,
    run_study,
)

Point = TypeVar("Point")
Work = Callable[[Point, Stop], Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class PointJob(Generic[Point]):
    """A rotor, and what is asked of it: `work` returns the numbers of the columns.

    `lost` is the row of a point without an answer.
    """

    point: Point
    work: Work[Point]
    lost: Table


@dataclass(frozen=True)
class Points(Generic[Point]):
    """All points, by number; see `rotor_ida.steady.grid.Plan`."""

    varied: Varied
    point_at: Callable[[Sequence[int]], Point]
    work: Work[Point]
    lost: Table
    length: int = 1

    @property
    def points(self) -> int:
        """Number of points."""
        return self.varied.points

    def job(self, number: int) -> PointJob[Point]:
        """Return what a worker needs to answer at a point."""
        place = [int(at) for at in np.unravel_index(number, self.varied.shape)]
        return PointJob(self.point_at(place), self.work, self.lost)

    def places(self, number: int) -> Places:
        """Return the position of a point among all."""
        return np.array([number])

    def slowest_first(self) -> Places:
        """Return the numbers of the points, in any order."""
        return np.arange(self.points)


def answers_at_each(
    varied: Varied,
    point_at: Callable[[Sequence[int]], Point],
    work: Work[Point],
    columns: Mapping[str, tuple[str, int] | None],
    question: Question,
    *,
    whole: Mapping[str, Any] = {},
    workers: Workers,
    study: Folder | None = None,
    progress: Progress | None = None,
) -> dict[str, xr.Variable]:
    """Return the answers of a function of one rotor at each point, as variables.

    Parameters
    ----------
    varied : Varied
        The points.
    point_at : callable
        Returns the rotor at a place.
    work : callable
        Returns the numbers of a rotor by the names of the columns; a function of a module, or one
        with some arguments given, as processes require. It is given an array whose one value is 0
        until it should stop.
    columns : mapping of str to (str, int) or None
        For each column the dimension behind those of the points, and its size; None where there
        is one number at each point.
    question : Question
        What determines the bits: the key of a study.
    whole : mapping of str to ndarray
        Of columns of whole numbers, those of a point that fails, of the type of all.
    workers, study, progress
        As in `rotor_ida.steady.grid.run_study`.

    Returns
    -------
    dict of str to Variable
        The columns, and ``status`` and ``message``: a point that fails does not raise, and its
        numbers are NaN, or those of `whole`.
    """
    check_size(varied, study)
    kind = np.dtype(
        [
            ("status", np.int8),
            *((name, np.asarray(whole.get(name, math.nan)).dtype, () if each is None else each[1:])
              for name, each in columns.items()),
        ]
    )  # fmt: skip
    lost = np.zeros(1, kind)
    lost["status"] = STATUS["failed"]
    for name in columns:
        lost[name] = whole.get(name, math.nan)
    plan = Points(varied, point_at, work, lost)
    form = form_of("answers at points", "points", kind)
    task: Task[PointJob[Point], Rows] = Task(_answer, _lost, _as_rows, form, kind)
    found = run_study(plan, task, question, study=study, workers=workers, progress=progress).points
    behind = {name: each[:1] for name, each in columns.items() if each is not None}
    return labelled_points(varied, found, behind)


def _answer(job: PointJob[Any], stop: Stop) -> Rows:
    """Return the answer at a point as a row."""
    row = np.zeros_like(job.lost)
    try:
        for name, value in job.work(job.point, stop).items():
            row[name] = value
    except EXPECTED as error:  # it must not end the other points
        return _lost(job, reason_of(error))
    row["status"] = STATUS["done"]
    return Rows(row, [""])


def _lost(job: PointJob[Any], reason: str) -> Rows:
    """Return the row of a point without an answer."""
    return Rows(job.lost, [reason])


def _as_rows(rows: Rows) -> Rows:
    return rows
