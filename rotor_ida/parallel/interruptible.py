"""Work in compiled code that Ctrl-C can stop."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future, wait

import numpy as np

from rotor_ida.arrays import Stop
from rotor_ida.parallel.jobs import Result

# How often the one who waits is told, in seconds.
TOLD_EVERY = 0.2


def interruptible(
    work: Callable[[Stop], Result], *, told: Callable[[], None] | None = None
) -> Result:
    """Return the result of `work`; stop it if an exception arrives meanwhile.

    Python runs the handlers of signals in its main thread only, and not while that runs compiled
    code. So the work is done in a thread of its own while the main one waits for it, and for
    Ctrl-C, a time limit, or whatever else raises.

    Parameters
    ----------
    work : callable
        Called with an array that holds 0 until it should stop.
    told : callable, optional
        Called every now and then until the work is done, to tell how far it is.

    Examples
    --------
    >>> interruptible(lambda stop: "stopped" if stop[0] else "done")
    'done'
    """
    stop = np.zeros(1, np.uint8)
    if threading.current_thread() is not threading.main_thread():
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
        while told is not None and not wait([future], TOLD_EVERY).done:
            told()
        return future.result()
    finally:
        stop[0] = 1
        # an exception may come before it counts as alive: then it finds the flag set, and ends
        if thread.is_alive():
            thread.join()
