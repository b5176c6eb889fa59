"""Work in compiled code that Ctrl-C can stop."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

import numpy as np

from rotor_ida.simulation.record import Stop

Result = TypeVar("Result")


def interruptible(work: Callable[[Stop], Result]) -> Result:
    """Return the result of `work`; where Ctrl-C arrives meanwhile, stop it and raise.

    Python hears of Ctrl-C in its main thread only, and not while that runs compiled code. So
    the work is done in a thread of its own while the main one listens.

    Parameters
    ----------
    work : callable
        Called with an array that holds 0 until it should stop.
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
    thread.start()
    try:
        return future.result()
    except KeyboardInterrupt:
        stop[0] = 1
        raise
    finally:
        thread.join()
