"""Many independent jobs on all cores: one way for everything that runs them.

Results come as they end. Only a few jobs are in flight at a time, so memory does not grow with
their number. When a job fails, or the user interrupts, the rest is given up at once.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager
from itertools import islice
from multiprocessing import active_children, get_context
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import check_count

Job = TypeVar("Job")
Result = TypeVar("Result")
Stop = npt.NDArray[np.uint8]
Work = Callable[[Job, Stop], Result]
Progress = Callable[[int, int], None]

# Jobs handed out for each worker: one in hand and one that waits.
IN_FLIGHT = 2


def count_workers(workers: int | None) -> int:
    """Return the number of workers: `workers`, or one for each core that may be used."""
    if workers is not None:
        return check_count("workers", workers)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_all(
    work: Work[Job, Result], jobs: Iterable[Job], *, workers: int, threads: bool
) -> Generator[tuple[int, Result], None, None]:
    """Do every job and yield its number and its result as it ends.

    Parameters
    ----------
    work : callable
        Takes a job and an array of one number that turns to 1 when the rest is given up; a long
        job looks at it now and then and returns early. For processes it must be a function of a
        module; each process has a number of its own, which stays 0: processes are ended.
    jobs : iterable
        The jobs; taken one by one as workers become free.
    workers : int
        How many jobs are done at the same time.
    threads : bool
        Whether by threads, for work that releases the interpreter's lock, or by processes.

    Yields
    ------
    number : int
        Place of the job among `jobs`, from 0.
    result : object
        What `work` returned for it.

    Notes
    -----
    What `work` raises is raised here. On that, on an interrupt from the keyboard, and when the
    caller stops asking, jobs that wait are dropped, threads are told to stop, processes are
    ended, and all of them are gone before control returns. One worker without threads is this
    very process.

    Examples
    --------
    >>> squares = run_all(lambda job, stop: job**2, [1, 2, 3], workers=2, threads=True)
    >>> sorted(squares)
    [(0, 1), (1, 4), (2, 9)]
    """
    stop = np.zeros(1, dtype=np.uint8)
    if workers == 1 and not threads:
        for number, job in enumerate(jobs):
            yield number, work(job, stop)
        return
    others = set(active_children())
    pool: Executor = (
        ThreadPoolExecutor(workers)
        if threads
        else ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
    )
    finished = False
    try:
        yield from _as_they_end(pool, work, jobs, stop, workers)
        finished = True
    finally:
        stop[0] = 1
        if not finished and not threads:
            for process in set(active_children()) - others:
                process.terminate()
        pool.shutdown(wait=True, cancel_futures=True)


def _as_they_end(
    pool: Executor, work: Work[Job, Result], jobs: Iterable[Job], stop: Stop, workers: int
) -> Iterator[tuple[int, Result]]:
    """Keep a few jobs in flight and yield what ends first."""
    waiting = enumerate(jobs)
    running: dict[Future[Result], int] = {}
    while True:
        with _deaf_to_interrupts():
            for number, job in islice(waiting, IN_FLIGHT * workers - len(running)):
                running[pool.submit(work, job, stop)] = number
        if not running:
            return
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            yield running.pop(future), future.result()


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Start workers that leave an interrupt from the keyboard to the one who waits for them."""
    if not hasattr(signal, "pthread_sigmask"):  # not on Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
