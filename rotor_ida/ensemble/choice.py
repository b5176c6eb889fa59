"""Where jobs run: the words a user may say, and what each of them means here."""

from __future__ import annotations

import os

from rotor_ida.checks import check_choice, check_count
from rotor_ida.errors import InputError

EXECUTORS = ("auto", "serial", "threads", "processes")


def count_workers(workers: int | None) -> int:
    """Return the number of workers: `workers`, or one for each core that may be used."""
    if workers is not None:
        return check_count("workers", workers)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def choose(executor: object, workers: int | None, *, compiled: bool) -> tuple[str, int]:
    """Return which executor to use, and how many workers.

    Parameters
    ----------
    executor : str
        One of `EXECUTORS`. With ``"auto"`` compiled work is done by threads, other work in this
        very process, or by processes where more workers than one are wanted.
    workers : int or None
        Number of workers; None for one on each core, or one where ``"auto"`` finds no compiled
        work.
    compiled : bool
        Whether the work is compiled, and so leaves the interpreter's lock to others.

    Examples
    --------
    >>> choose("auto", 2, compiled=True), choose("auto", 2, compiled=False)
    (('threads', 2), ('processes', 2))
    >>> choose("serial", None, compiled=True)
    ('serial', 1)
    """
    chosen = check_choice("executor", executor, EXECUTORS)
    if chosen == "auto":
        if not compiled:
            workers = count_workers(1 if workers is None else workers)
        chosen = "threads" if compiled else "serial" if workers == 1 else "processes"
    if chosen != "serial":
        return chosen, count_workers(workers)
    if workers is not None and check_count("workers", workers) > 1:
        raise InputError(f"workers must be 1 with executor 'serial', got {workers!r}")
    return chosen, 1
