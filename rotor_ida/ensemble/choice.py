"""Where jobs run: the words a user may say, and what each of them means here."""

from __future__ import annotations

import importlib.util
import os
import re

from rotor_ida.checks import check_count
from rotor_ida.errors import InputError

POOLS = ("threads", "processes")
EXECUTORS = ("auto", "serial", *POOLS, "dask")
_ADDRESS = re.compile(r"(tcp|tls|ws|wss)://[^\s/]+:\d+")


def count_workers(workers: int | None) -> int:
    """Return the number of workers: `workers`, or one for each core that may be used."""
    if workers is not None:
        return check_count("workers", workers)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def choose(executor: object, workers: int | None, *, compiled: bool) -> tuple[str, int | None]:
    """Return which executor to use, and how many workers.

    Parameters
    ----------
    executor : str
        One of `EXECUTORS`, or the address of a scheduler of dask. With ``"auto"`` compiled work is
        done by threads, other work in this very process, or by processes where more workers than
        one are wanted.
    workers : int or None
        Number of workers; None for one on each core, one where ``"auto"`` finds no compiled
        work, or as many as the scheduler at an address has.
    compiled : bool
        Whether the work is compiled, and so leaves the interpreter's lock to others.

    Examples
    --------
    >>> choose("auto", 2, compiled=True), choose("auto", 2, compiled=False)
    (('threads', 2), ('processes', 2))
    >>> choose("serial", None, compiled=True)
    ('serial', 1)
    """
    chosen = _check_executor(executor)
    if chosen == "auto":
        if not compiled:
            workers = count_workers(1 if workers is None else workers)
        chosen = "threads" if compiled else "serial" if workers == 1 else "processes"
    if chosen not in EXECUTORS:
        if workers is not None:
            raise InputError(f"workers must be left to the scheduler {chosen}, got {workers!r}")
        return chosen, None
    if chosen != "serial":
        return chosen, count_workers(workers)
    if workers is not None and check_count("workers", workers) > 1:
        raise InputError(f"workers must be 1 with executor 'serial', got {workers!r}")
    return chosen, 1


def _check_executor(executor: object) -> str:
    """Return an executor that can be had here."""
    if not isinstance(executor, str) or not (executor in EXECUTORS or _ADDRESS.fullmatch(executor)):
        words = ", ".join(repr(word) for word in EXECUTORS)
        raise InputError(
            f"executor must be one of {words}, or an address such as 'tcp://host:8786', "
            f"got {executor!r}"
        )
    reason = why_not(executor)
    if reason:
        raise InputError(f"executor {executor!r} {reason}")
    return executor


def why_not(executor: str) -> str:
    """Return why an executor, or an address, cannot be had here; empty if it can."""
    if executor in EXECUTORS and executor != "dask":
        return ""
    there = importlib.util.find_spec("distributed") is not None
    return "" if there else "needs dask: pip install 'rotor-ida[cluster]'"
