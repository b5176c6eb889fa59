"""Work in compiled code that Ctrl-C can stop."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future, wait

import numpy as np

from rotor_ida.arrays import Stop, Watch
from rotor_ida.parallel.jobs import Progress, Result

# Interval between progress reports [s].
TOLD_EVERY = 0.2


def percentage(progress: Progress | None, watch: Watch, whole: float) -> Callable[[], None] | None:
    """Return what reports the percentage of a time that runs have reached, if that is asked for.

    Examples
    --------
    >>> percentage(lambda done, total: print(done, "of", total), [lambda: 2.0, lambda: 1.0], 4.0)()
    75 of 100
    """
    if progress is None:
        return None
    return lambda: progress(min(int(100.0 * sum(done() for done in watch) / whole), 100), 100)


def run_with_progress(
    work: Callable[[Stop, Watch], Result],
    whole: float,
    progress: Progress | None,
    *,
    at_once: bool = False,
) -> Result:
    """Return the result of `interruptible` work, and report the percentage of its whole time.

    Examples
    --------
    >>> run_with_progress(lambda stop, watch: len(watch), 1.0, lambda *told: print(*told))
    100 100
    0
    """
    watch: Watch = []
    told = percentage(progress, watch, whole)
    found = interruptible(lambda stop: work(stop, watch), told=told, at_once=at_once)
    if progress is not None:
        progress(100, 100)
    return found


def interruptible(
    work: Callable[[Stop], Result],
    *,
    told: Callable[[], None] | None = None,
    at_once: bool = False,
) -> Result:
    """Return the result of `work`; stop it if an exception arrives meanwhile.

    Python runs signal handlers in its main thread only, and not while that runs compiled code. So
    the work runs in a separate thread, while the main thread waits for it, for Ctrl-C, for a time
    limit or for any other exception.

    Parameters
    ----------
    work : callable
        Called with an array whose one value is 0 until the work should stop.
    told : callable, optional
        Called regularly until the work is done, to report progress.
    at_once : bool
        Whether the work ends so soon that an exception may wait for that. A thread takes 0.1 to
        0.4 ms, as long as a short run.

    Examples
    --------
    >>> interruptible(lambda stop: "stopped" if stop[0] else "done")
    'done'
    """
    stop = np.zeros(1, np.uint8)
    if at_once or threading.current_thread() is not threading.main_thread():
        return work(stop)
    future: Future[Result] = Future()

    def fulfil() -> None:
        try:
            future.set_result(work(stop))
        except BaseException as error:
            future.set_exception(error)

    thread = threading.Thread(target=fulfil)
    try:
        thread.start()
        # a wait without end cannot be interrupted on Windows
        while not wait([future], TOLD_EVERY).done:
            if told is not None:
                told()
        return future.result()
    finally:
        stop[0] = 1
        # an exception may come before the thread is alive: then it sees the flag and ends
        if thread.is_alive():
            thread.join()
