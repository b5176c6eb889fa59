"""The executors on which jobs run, and the one function that runs jobs on them."""

from __future__ import annotations

import importlib.util
import os
import re
from collections.abc import Generator, Iterable
from functools import partial
from typing import NamedTuple

from rotor_ida.checks import MOST_WORKERS, check_count, did_you_mean, shown
from rotor_ida.errors import InputError
from rotor_ida.parallel.interruptible import interruptible
from rotor_ida.parallel.jobs import FailedJob, Job, Result, Work
from rotor_ida.parallel.pools import run_in_pool

POOLS = ("threads", "processes")
EXECUTORS = ("auto", "serial", *POOLS, "dask")
_ADDRESS = re.compile(r"(tcp|tls|ws|wss)://[^\s/]+:\d+")


class Workers(NamedTuple):
    """The executor and its number of workers; None if the executor has its own workers."""

    executor: str
    number: int | None


def count_workers(workers: int | None) -> int:
    """Return the number of workers: `workers`, or one for each available core."""
    if workers is not None:
        return check_count("workers", workers, maximum=MOST_WORKERS)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def choose(executor: object, workers: int | None, *, compiled: bool) -> Workers:
    """Choose the executor and the number of workers.

    Parameters
    ----------
    executor : str
        One of `EXECUTORS`, or the address of a dask scheduler. With ``"auto"`` compiled work runs
        in threads. Other work runs in this process, or in processes if more than one worker is
        requested.
    workers : int or None
        Number of workers. None means one per core; one if ``"auto"`` finds no compiled work; or
        those of the scheduler at an address.
    compiled : bool
        Whether the work is compiled, and so releases the interpreter's lock.

    Examples
    --------
    >>> choose("auto", 2, compiled=True)
    Workers(executor='threads', number=2)
    >>> choose("auto", 2, compiled=False)
    Workers(executor='processes', number=2)
    >>> choose("serial", None, compiled=True)
    Workers(executor='serial', number=1)
    """
    chosen = _check_executor(executor)
    if chosen == "auto":
        if not compiled:
            workers = count_workers(1 if workers is None else workers)
        chosen = "threads" if compiled else "serial" if workers == 1 else "processes"
    if chosen not in EXECUTORS:
        if workers is not None:
            raise InputError(
                f"workers must be left to the scheduler {chosen}, got {shown(workers)}"
            )
        return Workers(chosen, None)
    if chosen != "serial":
        return Workers(chosen, count_workers(workers))
    if workers is not None and count_workers(workers) > 1:
        raise InputError(f"workers must be 1 with executor 'serial', got {shown(workers)}")
    return Workers(chosen, 1)


def _check_executor(executor: object) -> str:
    """Return an executor that is available here."""
    if not isinstance(executor, str) or not (executor in EXECUTORS or _ADDRESS.fullmatch(executor)):
        words = ", ".join(repr(word) for word in EXECUTORS)
        raise InputError(
            f"executor must be one of {words}, or an address such as 'tcp://host:8786', "
            f"got {shown(executor)}{did_you_mean(executor, EXECUTORS)}"
        )
    reason = why_not(executor)
    if reason:
        raise InputError(f"executor {executor!r} {reason}")
    return executor


def why_not(executor: str) -> str:
    """Return why an executor or an address is not available here; empty if it is."""
    if executor in EXECUTORS and executor != "dask":
        return ""
    there = importlib.util.find_spec("distributed") is not None
    return "" if there else "needs dask: pip install 'rotor-ida[cluster]'"


def run_all(
    work: Work[Job, Result], jobs: Iterable[Job], *, workers: int | None, executor: str
) -> Generator[tuple[int, Result | FailedJob], None, None]:
    """Run all jobs; yield the number and the result of each as it ends.

    Parameters
    ----------
    work : callable
        Takes a job and an array with one number, which becomes 1 when jobs are cancelled; a long
        job checks it now and then and returns early. Except for threads it must be a function of a
        module. In processes the number stays 0, as processes are terminated.
    jobs : iterable
        The jobs; taken one by one as workers become free.
    workers, executor
        Number of jobs that run at the same time, and executor, from `choose`.

    Yields
    ------
    number : int
        Position of the job in `jobs`, from 0.
    result : object
        The result of `work`; `FailedJob` if the job's workers died.

    Raises
    ------
    InputError
        If a scheduler does not answer, or its workers have other versions.
    SimulationError
        If the scheduler died, or a process of a pool, as the jobs of the others are then lost too.

    Notes
    -----
    An exception of `work` is raised here. On an exception, a keyboard interrupt, or when the
    caller stops iterating, waiting jobs are dropped, threads are asked to stop and processes are
    terminated. All have ended before control returns. An existing cluster stays; its workers
    finish the jobs that they have started.

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
    from rotor_ida.parallel.cluster import run_on_cluster  # noqa: PLC0415 - not always there

    address = None if executor == "dask" else executor
    return run_on_cluster(work, jobs, workers=workers, address=address)


def _one_by_one(
    work: Work[Job, Result], jobs: Iterable[Job]
) -> Generator[tuple[int, Result | FailedJob], None, None]:
    """Run the jobs in this process."""
    for number, job in enumerate(jobs):
        yield number, interruptible(partial(work, job))
