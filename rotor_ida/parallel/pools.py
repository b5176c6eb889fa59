"""Run jobs in threads of this process, or in processes on this machine."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import islice
from multiprocessing import active_children, get_context, parent_process

import numpy as np

from rotor_ida.arrays import Stop
from rotor_ida.blas import one_thread
from rotor_ida.errors import SimulationError
from rotor_ida.parallel.jobs import IN_FLIGHT, FailedJob, Job, Result, Work

CAUSES = (
    "killed, out of memory, or started by a script that does not guard its main part with "
    'if __name__ == "__main__":'
)
# Seconds after which a wait for workers notices Ctrl-C on Windows.
NOTICED = 0.5


def run_in_pool(
    work: Work[Job, Result], jobs: Iterable[Job], *, workers: int, threads: bool
) -> Generator[tuple[int, Result | FailedJob], None, None]:
    """Run the jobs as in `run_all`, in threads or processes."""
    stop = np.zeros(1, dtype=np.uint8)
    others = set(active_children())
    pool: Executor = (
        ThreadPoolExecutor(workers)
        if threads
        else ProcessPoolExecutor(
            workers, mp_context=get_context("spawn"), initializer=_end_with_parent
        )
    )
    finished = False
    try:
        with one_thread():  # each process, which a pool starts only when there is a job for it
            yield from _as_they_end(pool, work, jobs, stop, workers)
        finished = True
    except BrokenProcessPool:
        raise SimulationError(f"a worker process died: {CAUSES}") from None
    finally:
        stop[0] = 1
        if not finished and not threads:
            for process in set(active_children()) - others:
                process.terminate()
        pool.shutdown(wait=True, cancel_futures=True)


def _end_with_parent() -> None:
    """End this worker when its parent process ends, even if that is killed; ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _as_they_end(
    pool: Executor, work: Work[Job, Result], jobs: Iterable[Job], stop: Stop, workers: int
) -> Iterator[tuple[int, Result]]:
    """Keep a few jobs in progress, and yield results as they end."""
    waiting = enumerate(jobs)
    running: dict[Future[Result], int] = {}
    while True:
        with deaf_to_interrupts():
            for number, job in islice(waiting, IN_FLIGHT * workers - len(running)):
                running[pool.submit(work, job, stop)] = number
        if not running:
            return
        for future in wait(running, NOTICED, return_when=FIRST_COMPLETED).done:
            yield running.pop(future), future.result()


@contextmanager
def deaf_to_interrupts() -> Iterator[None]:
    """Start workers that ignore keyboard interrupts, which the waiting process handles after that.

    They inherit the mask of this thread, where a platform has masks. Another thread may take the
    interrupt meanwhile, and this one must not break off between the start of a worker and the note
    that it has begun.
    """
    came: list[int] = []
    before: set[signal.Signals | int] = set()
    if sys.platform != "win32":
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    handler = signal.getsignal(signal.SIGINT)
    defers = callable(handler) and threading.current_thread() is threading.main_thread()
    if defers:
        signal.signal(signal.SIGINT, lambda number, _: came.append(number))
    try:
        yield
    finally:
        if defers:
            signal.signal(signal.SIGINT, handler)
        if sys.platform != "win32":
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if came:
            signal.raise_signal(signal.SIGINT)
