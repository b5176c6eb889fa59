"""A study on a grid: run its jobs with any executor, store results as they end, collect columns.

Sweeps and run-ups are studies. Each job is a ramp: one point of the grid, or several that are
followed one after the other. Its result becomes rows of tables: one for each point, and one for
each event on the way to it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Generic, Literal, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Stop
from rotor_ida.checks import MOST_NUMBERS, MOST_POINTS_OF_STUDY, check_direction
from rotor_ida.errors import RotorError, SimulationError
from rotor_ida.model.varied import Varied
from rotor_ida.parallel import FailedJob, Progress, Workers, run_all
from rotor_ida.parallel.jobs import Job, Result, Work
from rotor_ida.results.question import Question
from rotor_ida.results.studies.arrays import scratch
from rotor_ida.results.studies.results import Folder, Form, Results, open_results
from rotor_ida.schema import ENDING, RESPONSE, STATUS, labelled

Array = npt.NDArray[np.generic]
Table = npt.NDArray[np.void]
Places = npt.NDArray[np.int64]
Direction = Literal["up", "down", "both"]
DIRECTIONS: dict[str | None, tuple[int, ...]] = {
    None: (0,),
    "up": (1,),
    "down": (-1,),
    "both": (1, -1),
}
Point = TypeVar("Point")
Start = TypeVar("Start")

# Errors of solver, physics and memory at a point; any other error is a fault of the program.
EXPECTED = (SimulationError, ArithmeticError, MemoryError)
# A failure of the surroundings, not of the point: another attempt may succeed.
PASSING = "MemoryError"
NO_COLUMNS = np.dtype([])
# Whole numbers of a point that failed; those of other names are 0.
NONE = {"ending": ENDING["failed"], "response": RESPONSE["failed"]}


def reason_of(error: Exception) -> str:
    """Return the message for an error that was `EXPECTED`."""
    if isinstance(error, RotorError):
        return str(error)
    return f"{type(error).__name__}: {error}".rstrip(": ")


def check_size(varied: Varied, study: object) -> None:
    """Raise `InputError` for more points than fit into memory, or into a study folder."""
    varied.check_size(MOST_NUMBERS if study is None else MOST_POINTS_OF_STUDY)


def labelled_points(
    varied: Varied, columns: Mapping[str, Array], behind: Mapping[str, tuple[str, ...]] = {}
) -> dict[str, xr.Variable]:
    """Return columns with a number for each point as variables.

    Those with several numbers for each point have the dimensions named in `behind`.
    """
    return {
        name: labelled(
            name, (*varied.dims, *behind.get(name, ())),
            column.reshape(*varied.shape, *column.shape[1:]),
        )
        for name, column in columns.items()
    }  # fmt: skip


class Answer(NamedTuple):
    """What is found at a point, by the names of columns, and the start of the next of its ramp."""

    figures: Mapping[str, Any]
    message: str = ""
    failed: bool = False
    end: Any = None
    events: Table | None = None


class Rows(NamedTuple):
    """Some points of a study.

    Parameters
    ----------
    points : structured array, shape (n,)
        The result of each point, including ``status`` and, with events, ``event_count``.
    messages : list of str
        The reason why each failed; empty if it did not.
    events : structured array, shape (m,), optional
        The events, point after point.
    """

    points: Table
    messages: list[str]
    events: Table | None = None


@dataclass(frozen=True)
class Answers(Generic[Point, Start]):
    """How points are answered, and the rows that the answers become.

    Parameters
    ----------
    work : callable
        Returns the answer at a point, from a start; a function of a module, or one with some
        arguments given, as processes require. It is given an array whose one value is 0 until it
        should stop.
    kind, event : dtype
        The columns of a point, and of an event.
    whole : mapping
        Whole numbers of a point without figures: all other columns are then NaN, or 0.
    """

    work: Callable[[Point, Start, Stop], Answer]
    kind: np.dtype[np.void]
    event: np.dtype[np.void] = NO_COLUMNS
    whole: Mapping[str, Any] = field(default_factory=lambda: NONE)

    @cached_property
    def blank(self) -> dict[str, Any]:
        """What stands in each column of a point without figures."""
        row = np.zeros((), self.kind)
        return {
            name: np.full_like(row[name], math.nan)[()] if row[name].dtype.kind == "f"
            else self.whole.get(name, row[name][()])
            for name in self.kind.names or ()
        }  # fmt: skip

    def settle(self, point: Point, start: Start, stop: Stop) -> Answer:
        """Return the answer at a point, from a start or from where another point ends."""
        try:
            return self.work(point, start, stop)
        except EXPECTED as error:  # it must not end the other points
            return failed(reason_of(error))

    def rows(self, found: Sequence[Answer]) -> Rows:
        """Return answers as rows of a study."""
        values = []
        for each in found:
            figures = {**each.figures, "status": STATUS["failed" if each.failed else "done"]}
            values.append(tuple([figures.get(name, blank) for name, blank in self.blank.items()]))
        events = [each.events for each in found if each.events is not None]
        return Rows(
            np.array(values, self.kind), [each.message for each in found],
            np.concatenate([np.empty(0, self.event), *events]) if self.event.names else None,
        )  # fmt: skip


def failed(reason: str) -> Answer:
    """Return the answer at a point that could not be followed."""
    return Answer({}, reason, failed=True)


# ---- Ramps: points that are followed one after the other, each in exactly one ----


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
    axis : int
        The dimension along which a ramp leads in a direction.
    """

    varied: Varied
    starts: Sequence[Start]
    answers: Answers[Point, Start]
    point_at: Callable[[Sequence[int]], Point]
    axis: int = 0

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
    def points(self) -> int:
        """Number of points of all ramps."""
        return math.prod(self.shape)

    def __len__(self) -> int:
        return len(self.places)

    @cached_property
    def places(self) -> Places:
        """The points of each ramp, a row each, by their positions in the order of the dimensions.

        Ramps are counted by directions, then by the other dimensions.
        """
        numbers = np.arange(self.points).reshape(self.shape)
        if not self.directions[0]:
            return numbers.reshape(-1, 1)
        rows = np.moveaxis(numbers, (-1, self.axis), (0, -1))
        rows = np.array([row[..., ::way] for row, way in zip(rows, self.directions, strict=True)])
        return rows.reshape(-1, self.shape[self.axis])

    def job(self, number: int) -> RampJob[Point, Start]:
        """Return what a worker needs to follow a ramp."""
        places = np.transpose(np.unravel_index(self.places[number], self.varied.shape)).tolist()
        dims = self.varied.dims
        start = self.starts[places[0][dims.index("start")] if "start" in dims else 0]
        return RampJob([self.point_at(place) for place in places], start, self.answers)

    def slowest_first(self) -> Places:
        """Return the numbers of the ramps, the longest ones first.

        Slow run-ups take longest, and one disc with a large clearance, as it bounces there.
        """
        numbers, dims = np.arange(len(self)), self.varied.dims
        firsts = np.unravel_index(self.places[:, 0], self.shape)
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


# ---- A study: its jobs, and the columns of all points ----


class Columns(NamedTuple):
    """The results of a study: columns with a number for each point, and for each event."""

    points: dict[str, Array]
    events: dict[str, Array]


def form_of(
    word: str, point: np.dtype[np.void], event: np.dtype[np.void] = NO_COLUMNS
) -> Form[Rows]:
    """Return how rows are stored: one table of points, and one of events if there are any columns.

    A table has one header; separate arrays would have one each.
    """
    names, of_events = list(point.names or ()), list(event.names or ())
    return Form(
        word,
        lambda rows: (
            {"messages": np.array(rows.messages, dtype=str), "points": rows.points}
            | ({} if rows.events is None else {"events": rows.events})
        ),
        lambda arrays: Rows(
            arrays["points"][names],
            arrays["messages"].tolist(),
            arrays["events"][of_events] if of_events else None,
        ),
    )


def run_study(
    plan: Ramps[Any, Any],
    question: Question,
    *,
    word: str,
    follow: Work[Any, list[Answer]] | None = None,
    study: Folder | None,
    workers: Workers,
    progress: Progress | None,
) -> Columns:
    """Do the jobs of a study that are not stored yet, and return the columns of all.

    `question` is what determines the bits: the study of another question is refused. `word`
    names the rows in a study. `follow` does a job that is more than to follow one
    point after the other.
    """
    answers = plan.answers
    form = form_of(word, answers.kind, answers.event)
    with open_results(study, question.design, plan.points, form) as kept:
        run_due(
            follow or follow_along, plan.job, plan.slowest_first().tolist(), kept,
            partial(_keep, plan, kept), workers=workers, progress=progress, total=plan.points,
        )  # fmt: skip
        points = _point_columns(plan, kept)
        events = _event_columns(plan, kept, points) if answers.event.names else {}
    return Columns(points, events)


def follow_along(ramp: RampJob[Any, Any], stop: Stop) -> list[Answer]:
    """Follow one ramp: each point begins where the last one that did not fail has ended."""
    start, rows = ramp.start, list[Answer]()
    for point in ramp.points:
        if stop[0]:
            break
        rows.append(ramp.answers.settle(point, start, stop))
        start = start if rows[-1].end is None else rows[-1].end
    return rows


def _keep(
    plan: Ramps[Any, Any], kept: Results[Rows], number: int, result: list[Answer] | FailedJob
) -> None:
    """Store the result of a job."""
    died = isinstance(result, FailedJob)
    answers = (
        [failed(result.reason)] * plan.places.shape[1] if isinstance(result, FailedJob) else result
    )
    rows = plan.answers.rows(answers)
    reasons = [each.message for each in answers if each.failed]
    if died or any(reason.startswith(PASSING) for reason in reasons):
        kept.hold(number, rows, len(rows.messages))  # a later run may succeed
    else:
        first = reasons[0] if reasons else ""
        kept.keep(number, rows, len(rows.messages), failed=len(reasons), reason=first)


def keep_whole(
    kept: Results[Result], points: Callable[[Result], int], number: int, result: Result | FailedJob
) -> None:
    """Store the result of a job by its number of points, or why there is none."""
    if isinstance(result, FailedJob):
        kept.lost = result.reason
    else:
        kept.keep(number, result, points(result))


def run_due(
    work: Work[Job, Result],
    job: Callable[[int], Job],
    numbers: Iterable[int],
    kept: Results[Any],
    keep: Callable[[int, Result | FailedJob], object],
    *,
    workers: Workers,
    progress: Progress | None,
    total: int,
) -> None:
    """Run those of some jobs that are not stored yet, and keep each as it ends, of `total` points.

    `keep` gets its number and its result.
    """
    if progress is not None and kept.points_done:
        progress(kept.points_done, total)
    due = [number for number in numbers if number not in kept.done]
    if not due:  # no cluster need be started
        return
    # the cluster at an address has its own workers
    count = workers.number and min(workers.number, len(due))
    jobs = (job(number) for number in due)
    with closing(run_all(work, jobs, workers=count, executor=workers.executor)) as ended:
        for turn, result in ended:
            keep(due[turn], result)
            if progress is not None:
                progress(kept.points_done, total)


def _point_columns(plan: Ramps[Any, Any], kept: Results[Rows]) -> dict[str, Array]:
    """Return the columns with a number, or a message, for each point."""
    columns = _scratch(plan.answers.kind, plan.points, kept.folder)
    messages: dict[int, str] = {}
    for number, rows in kept.results():
        places = plan.places[number]
        for name, column in columns.items():
            column[places] = rows.points[name]
        both = zip(places.tolist(), rows.messages, strict=True)
        messages |= {place: message for place, message in both if message}
    width = max(map(len, messages.values()), default=1)
    texts = scratch((plan.points,), f"<U{width}", kept.folder)
    texts[:] = ""
    for place, message in messages.items():
        texts[place] = message
    return columns | {"message": texts}


def _event_columns(
    plan: Ramps[Any, Any], kept: Results[Rows], points: Mapping[str, Array]
) -> dict[str, Array]:
    """Return the columns with a number for each event, in the order of the points."""
    ends = np.cumsum(points["event_count"], dtype=np.int64)
    columns = _scratch(plan.answers.event, int(ends[-1]), kept.folder)
    for number, rows in kept.results():
        assert rows.events is not None
        first = 0
        counts = rows.points["event_count"].tolist()
        for place, count in zip(plan.places[number].tolist(), counts, strict=True):
            end = int(ends[place])
            for name, column in columns.items():
                column[end - count : end] = rows.events[name][first : first + count]
            first += count
    return columns


def _scratch(kind: np.dtype[np.void], size: int, folder: Path | None) -> dict[str, Array]:
    """Return unset columns, in memory, or in `folder` if they may be larger than that."""
    return {name: scratch((size,), kind[name], folder) for name in kind.names or ()}


# ---- A question of one motion at each point ----


def answers_at_each(
    varied: Varied,
    point_at: Callable[[Sequence[int]], Point],
    work: Callable[[Point, Stop], Mapping[str, Any]],
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
        Returns the numbers of a rotor by the names of the columns; see `Answers`.
    columns : mapping of str to (str, int) or None
        For each column the dimension behind those of the points, and its size; None where there
        is one number at each point.
    question : Question
        What determines the bits: the key of a study.
    whole : mapping of str to ndarray
        Of columns of whole numbers, those of a point that fails, of the type of all.
    workers, study, progress
        As in `run_study`.

    Returns
    -------
    dict of str to Variable
        The columns, and ``status`` and ``message``: a point that fails does not raise, and its
        numbers are NaN, or those of `whole`.
    """
    check_size(varied, study)
    kind = np.dtype([
        ("status", np.int8),
        *((name, np.asarray(whole.get(name, math.nan)).dtype, () if each is None else each[1:])
          for name, each in columns.items()),
    ])  # fmt: skip
    answers: Answers[Point, None] = Answers(partial(_answer, work), kind, whole=whole)
    found = run_study(
        Ramps(varied, (None,), answers, point_at), question, word="answers at points",
        study=study, workers=workers, progress=progress,
    ).points  # fmt: skip
    behind = {name: each[:1] for name, each in columns.items() if each is not None}
    return labelled_points(varied, found, behind)


def _answer(
    work: Callable[[Point, Stop], Mapping[str, Any]], point: Point, _start: None, stop: Stop
) -> Answer:
    return Answer(work(point, stop))
