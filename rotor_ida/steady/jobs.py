"""The jobs of a sweep, or of many run-ups: done by whatever executor, each kept as it ends."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from rotor_ida.parallel import FailedJob, Progress, run_all
from rotor_ida.parallel.jobs import Job, Result, Work
from rotor_ida.results.studies.results import Results
from rotor_ida.schema import STATUS
from rotor_ida.steady.ramps import Places
from rotor_ida.steady.sweep_dataset import Rows

Job_co = TypeVar("Job_co", covariant=True)

# A failure of the surroundings, not of the point: another attempt may succeed.
PASSING = "MemoryError"


class Plan(Protocol[Job_co]):
    """All jobs, by number, each of `length` points."""

    @property
    def points(self) -> int:
        """Number of points of all jobs."""

    @property
    def length(self) -> int:
        """Number of points of each job."""

    def job(self, number: int) -> Job_co:
        """Return what a worker needs to do a job."""

    def slowest_first(self) -> Places:
        """Return the numbers of the jobs in an order that leaves no long one to the end."""


@dataclass(frozen=True, slots=True)
class Task(Generic[Job, Result]):
    """What is done of each job.

    Parameters
    ----------
    work : callable
        Does a job; a function of a module, as processes need.
    lost : callable
        Returns what stands for a job whose workers died, and why they did.
    rows : callable
        Returns a result as rows.
    """

    work: Work[Job, Result]
    lost: Callable[[Job, str], Result]
    rows: Callable[[Result], Rows]


def do_all(
    plan: Plan[Job],
    task: Task[Job, Result],
    kept: Results[Rows],
    executor: str,
    workers: int | None,
    progress: Progress | None,
) -> None:
    """Do the jobs that are not kept yet, and keep each as it ends."""
    if progress is not None and kept.points_done:
        progress(kept.points_done, plan.points)
    numbers = plan.slowest_first()
    due = numbers[[number not in kept.done for number in numbers.tolist()]].tolist()
    if not due:
        return
    jobs = (plan.job(number) for number in due)
    held = 0
    count = workers and min(workers, len(due))  # the cluster at an address has its own
    with closing(run_all(task.work, jobs, workers=count, executor=executor)) as ended:
        for turn, found in ended:
            number = due[turn]
            died = isinstance(found, FailedJob)
            rows = task.rows(
                task.lost(plan.job(number), found.reason) if isinstance(found, FailedJob) else found
            )
            failures = rows.columns["status"] == STATUS["failed"]
            reasons = [rows.messages[place] for place in failures.nonzero()[0].tolist()]
            if died or any(reason.startswith(PASSING) for reason in reasons):
                kept.hold(number, rows)  # another time it may be done
                held += plan.length
            else:
                first = reasons[0] if reasons else ""
                kept.keep(number, rows, len(rows.messages), failed=len(reasons), reason=first)
            if progress is not None:
                progress(kept.points_done + held, plan.points)
