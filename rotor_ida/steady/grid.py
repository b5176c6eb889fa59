"""A study on a grid: run its jobs with any executor, store results as they end, collect columns.

Sweeps and run-ups are studies. Each job covers one or more points of the grid, and its result
becomes rows of tables: one for each point, and one for each event on the way to it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column
from rotor_ida.checks import AT_REST, COMPONENTS, MOST_NUMBERS, MOST_POINTS_OF_STUDY, State
from rotor_ida.errors import RotorError, SimulationError
from rotor_ida.model.varied import Varied
from rotor_ida.parallel import FailedJob, Progress, Workers, run_all
from rotor_ida.parallel.jobs import Job, Result, Work
from rotor_ida.results.question import Question
from rotor_ida.results.studies.arrays import scratch
from rotor_ida.results.studies.results import Folder, Form, Results, open_results
from rotor_ida.schema import STATUS, labelled
from rotor_ida.simulation.starts import GivenStart

if TYPE_CHECKING:
    from rotor_ida.steady.ramps import Ramps

Array = npt.NDArray[np.generic]
Table = npt.NDArray[np.void]
Places = npt.NDArray[np.int64]

# Errors of solver, physics and memory at a point; any other error is a fault of the program.
EXPECTED = (SimulationError, ArithmeticError, MemoryError)
# A failure of the surroundings, not of the point: another attempt may succeed.
PASSING = "MemoryError"
NO_COLUMNS = np.dtype([])


def reason_of(error: Exception) -> str:
    """Return the message for an error that was `EXPECTED`."""
    if isinstance(error, RotorError):
        return str(error)
    return f"{type(error).__name__}: {error}".rstrip(": ")


def start_coordinates(starts: Sequence[GivenStart]) -> dict[str, Column]:
    """Return the starts ``(x, y, vx, vy)`` as coordinates of a result; NaN where it is a word."""
    states = [(math.nan,) * len(COMPONENTS) if isinstance(each, str) else each for each in starts]
    columns = zip(COMPONENTS, np.array(states).T, strict=True)
    return {f"start_{name}": ("start", column.copy()) for name, column in columns}


def start_words(starts: Sequence[GivenStart]) -> dict[str, str]:
    """Return the attribute with the word of each start, if there is any; "state" where it is one.

    Examples
    --------
    >>> start_words(["settled", (1.0, 0.0, 0.0, 0.0)]), start_words([(1.0, 0.0, 0.0, 0.0)])
    ({'start_words': 'settled state'}, {})
    """
    if not any(isinstance(each, str) for each in starts):
        return {}
    words = [each if isinstance(each, str) else "state" for each in starts]
    return {"start_words": " ".join(words)}


def representative(starts: Sequence[GivenStart]) -> list[State]:
    """Return starts to be checked once for all rotors: rest on the axis for those of words."""
    return [AT_REST if isinstance(each, str) else each for each in starts]


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


@dataclass(frozen=True, slots=True)
class Rows:
    """Some points of a study.

    Parameters
    ----------
    points : structured array, shape (n,)
        The result of each point, including ``status`` and ``event_count``.
    messages : list of str
        The reason why each failed; empty if it did not.
    events : structured array, shape (m,), optional
        The events, point after point.
    """

    points: Table
    messages: list[str]
    events: Table | None = None


@dataclass(frozen=True, slots=True)
class Task(Generic[Job, Result]):
    """How each job is done, and how its result is stored.

    Parameters
    ----------
    work : callable
        Does a job; a function of a module, as processes require.
    lost : callable
        Returns the result of a job whose workers died, with the reason.
    rows : callable
        Returns a result as rows.
    form : Form
        How rows are converted to arrays of a study and back.
    point, event : dtype
        The columns of a point, and of an event.
    """

    work: Work[Job, Result]
    lost: Callable[[Job, str], Result]
    rows: Callable[[Result], Rows]
    form: Form[Rows]
    point: np.dtype[np.void]
    event: np.dtype[np.void] = NO_COLUMNS


class Columns(NamedTuple):
    """The results of a study: columns with a number for each point, and for each event."""

    points: dict[str, Array]
    events: dict[str, Array]


def form_of(
    word: str, table: str, point: np.dtype[np.void], event: np.dtype[np.void] = NO_COLUMNS
) -> Form[Rows]:
    """Return how rows are stored: one table of points, and one of events if there are any columns.

    A table has one header; separate arrays would have one each.
    """
    names, of_events = list(point.names or ()), list(event.names or ())
    return Form(
        word,
        lambda rows: (
            {"messages": np.array(rows.messages, dtype=str), table: rows.points}
            | ({} if rows.events is None else {"events": rows.events})
        ),
        lambda arrays: Rows(
            arrays[table][names],
            arrays["messages"].tolist(),
            arrays["events"][of_events] if of_events else None,
        ),
    )


def run_study(
    plan: Ramps[Any, Any, Any],
    task: Task[Any, Any],
    question: Question,
    *,
    study: Folder | None,
    workers: Workers,
    progress: Progress | None,
) -> Columns:
    """Do the jobs of a study that are not stored yet, and return the columns of all.

    `question` is what determines the bits: the study of another question is refused.
    """
    with open_results(study, question.design(), plan.points, task.form) as kept:
        _do_jobs(plan, task, kept, workers, progress)
        points = _point_columns(plan, task.point, kept)
        events = _event_columns(plan, task.event, kept, points) if task.event.names else {}
    return Columns(points, events)


def _do_jobs(
    plan: Ramps[Any, Any, Any],
    task: Task[Any, Any],
    kept: Results[Rows],
    workers: Workers,
    progress: Progress | None,
) -> None:
    """Do the jobs that are not stored yet, and store each as it ends."""
    points = plan.points
    if progress is not None and kept.points_done:
        progress(kept.points_done, points)
    due = [number for number in plan.slowest_first().tolist() if number not in kept.done]
    if not due:
        return
    jobs = (plan.job(number) for number in due)
    postponed = 0
    count = workers.number and min(
        workers.number, len(due)
    )  # the cluster at an address has its own workers
    with closing(run_all(task.work, jobs, workers=count, executor=workers.executor)) as ended:
        for turn, result in ended:
            number = due[turn]
            died = isinstance(result, FailedJob)
            rows = task.rows(
                task.lost(plan.job(number), result.reason)
                if isinstance(result, FailedJob)
                else result
            )
            failures = np.flatnonzero(rows.points["status"] == STATUS["failed"]).tolist()
            reasons = [rows.messages[place] for place in failures]
            if died or any(reason.startswith(PASSING) for reason in reasons):
                kept.hold(number, rows)  # a later run may succeed
                postponed += plan.length
            else:
                first = reasons[0] if reasons else ""
                kept.keep(number, rows, len(rows.messages), failed=len(reasons), reason=first)
            if progress is not None:
                progress(kept.points_done + postponed, points)


def _point_columns(
    plan: Ramps[Any, Any, Any], kind: np.dtype[np.void], kept: Results[Rows]
) -> dict[str, Array]:
    """Return the columns with a number, or a message, for each point."""
    columns = _scratch(kind, plan.points, kept.folder)
    messages: dict[int, str] = {}
    for number, rows in kept.results():
        places = plan.places(number)
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
    plan: Ramps[Any, Any, Any],
    kind: np.dtype[np.void],
    kept: Results[Rows],
    points: Mapping[str, Array],
) -> dict[str, Array]:
    """Return the columns with a number for each event, in the order of the points."""
    ends = np.cumsum(points["event_count"], dtype=np.int64)
    columns = _scratch(kind, int(ends[-1]), kept.folder)
    for number, rows in kept.results():
        assert rows.events is not None
        first = 0
        counts = rows.points["event_count"].tolist()
        for place, count in zip(plan.places(number).tolist(), counts, strict=True):
            end = int(ends[place])
            for name, column in columns.items():
                column[end - count : end] = rows.events[name][first : first + count]
            first += count
    return columns


def _scratch(kind: np.dtype[np.void], size: int, folder: Path | None) -> dict[str, Array]:
    """Return unset columns, in memory, or in `folder` if they may be larger than that."""
    return {name: scratch((size,), kind[name], folder) for name in kind.names or ()}
