"""One call that does many jobs, wherever they run."""

from __future__ import annotations

from collections.abc import Generator, Iterable

import numpy as np

from rotor_ida.ensemble.choice import POOLS, count_workers
from rotor_ida.ensemble.jobs import Job, Lost, Result, Work
from rotor_ida.ensemble.pools import run_in_pool


def run_all(
    work: Work[Job, Result], jobs: Iterable[Job], *, workers: int | None, executor: str
) -> Generator[tuple[int, Result | Lost], None, None]:
    """Do every job and yield its number and its result as it ends.

    Parameters
    ----------
    work : callable
        Takes a job and an array of one number that turns to 1 when the rest is given up; a long
        job looks at it now and then and returns early. For anything but threads it must be a
        function of a module; each process has a number of its own, which stays 0: processes are
        ended.
    jobs : iterable
        The jobs; taken one by one as workers become free.
    workers, executor
        From `choose`: how many jobs are done at the same time, and by what.

    Yields
    ------
    number : int
        Place of the job among `jobs`, from 0.
    result : object
        What `work` returned for it; `Lost` if its workers died of it.

    Raises
    ------
    InputError
        If a scheduler does not answer, or its workers have other versions.
    SimulationError
        If a process of a pool died, what the others had in hand being gone with it, or the
        scheduler.

    Notes
    -----
    What `work` raises is raised here. On that, on an interrupt from the keyboard, and when the
    caller stops asking, jobs that wait are dropped, threads are told to stop, processes are
    ended, and all of them are gone before control returns. A cluster that was there before
    stays; its workers finish the jobs that they have begun.

    Examples
    --------
    >>> squares = run_all(lambda job, stop: job**2, [1, 2, 3], workers=2, executor="threads")
    >>> sorted(squares)
    [(0, 1), (1, 4), (2, 9)]
    """
    if executor == "serial":
        return _one_by_one(work, jobs)
    if executor in POOLS:
        return run_in_pool(
            work, jobs, workers=count_workers(workers), threads=executor == "threads"
        )
    from rotor_ida.ensemble.cluster import run_on_cluster  # noqa: PLC0415 - not always there

    address = None if executor == "dask" else executor
    return run_on_cluster(work, jobs, workers=workers, address=address)


def _one_by_one(
    work: Work[Job, Result], jobs: Iterable[Job]
) -> Generator[tuple[int, Result | Lost], None, None]:
    """Do the jobs in this very process and thread."""
    stop = np.zeros(1, dtype=np.uint8)
    for number, job in enumerate(jobs):
        yield number, work(job, stop)
