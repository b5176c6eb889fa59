"""Run jobs with dask: on a temporary cluster on this machine, or on an existing one.

dask gives a job whose worker dies to another worker. After several deaths it suspects all jobs of
those workers. Each of these is then run alone, and given up only if its workers die again.
"""

from __future__ import annotations

import asyncio
import logging
import tempfile
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from itertools import islice
from typing import Any

import numpy as np
from distributed import Client, KilledWorker, LocalCluster, wait
from distributed.comm.core import CommClosedError

from rotor_ida.errors import InputError, SimulationError
from rotor_ida.parallel.jobs import IN_FLIGHT, FailedJob, Job, Result, Work
from rotor_ida.parallel.pools import CAUSES, deaf_to_interrupts

# Time for a scheduler to answer [s].
PATIENCE = 5.0
# Time between two counts of its workers [s].
RECOUNT = 2.0
# A task costs dask some ten milliseconds, so short jobs are bundled into tasks of about this
# duration [s], with a limit on the number of jobs in each.
BUNDLE_TIME, MOST_TOGETHER = 0.25, 64
# Grace period for a worker to exit [s].
GRACE = 0.25
# Time for a cluster to close [s].
TIME_TO_CLOSE = 20.0

# Packages whose versions must be equal on all workers for results that are equal bit for bit.
PACKAGES = ("rotor-ida", "numpy", "scipy", "scikit-sundae")


def run_on_cluster(
    work: Work[Job, Result], jobs: Iterable[Job], *, workers: int | None, address: str | None
) -> Generator[tuple[int, Result | FailedJob], None, None]:
    """Run the jobs as in `run_all`, on a cluster of `workers` processes or on that at `address`.

    Raises
    ------
    InputError
        If no scheduler answers, or a worker has other versions than this process.
    SimulationError
        If the scheduler disappears before all jobs are done.
    """
    with ExitStack() as stack:
        stack.enter_context(_quiet())
        client = stack.enter_context(_connected(workers) if address is None else _joined(address))
        try:
            yield from _as_they_end(client, work, jobs)
        except (CancelledError, OSError) as error:
            of_dask = isinstance(error, (CancelledError, CommClosedError))
            if client.status == "running" and not of_dask:
                raise  # it came from a job
            raise SimulationError(f"the scheduler {address or 'of dask'} is gone") from error


def _as_they_end(
    client: Client, work: Work[Job, Result], jobs: Iterable[Job]
) -> Iterator[tuple[int, Result | FailedJob]]:
    """Keep a few jobs in progress for each thread of the cluster; yield results as they end."""
    waiting = enumerate(jobs)
    running: dict[Any, list[tuple[int, Job]]] = {}
    suspects: list[tuple[int, Job]] = []
    known: set[str] = set()
    room, counted, together = 0, -RECOUNT, 1
    while True:
        if time.monotonic() - counted >= RECOUNT:
            room, counted = IN_FLIGHT * max(1, _count_threads(client, known)), time.monotonic()
        while len(running) < room and (bundle := list(islice(waiting, together))):
            running[_submit(client, work, [job for _, job in bundle])] = bundle
        if not running:
            break
        try:
            with client.as_current():
                ended = wait(list(running), timeout=RECOUNT, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            continue
        for future in ended:
            bundle = running.pop(future)
            try:
                results, took = future.result()
            except KilledWorker:
                suspects += bundle
                continue
            yield from zip((number for number, _ in bundle), results, strict=True)
            together = min(MOST_TOGETHER, max(1, int(BUNDLE_TIME * len(bundle) / max(took, 1e-9))))
    for number, job in suspects:
        yield number, _alone(client, work, job)
    _count_threads(client, known)


def _alone(client: Client, work: Work[Job, Result], job: Job) -> Result | FailedJob:
    """Run a job alone."""
    try:
        results: list[Result] = _submit(client, work, [job]).result()[0]
    except KilledWorker as error:
        tried = error.allowed_failures + 1
        return FailedJob(f"every worker that tried it died, {tried} in all")
    return results[0]


def _submit(client: Client, work: Work[Job, Result], bundle: list[Job]) -> Any:
    return client.submit(_do, work, bundle, pure=False)


def _do(work: Work[Job, Result], bundle: list[Job]) -> tuple[list[Result], float]:
    """Run jobs one after another; return their results and the time they took [s]."""
    began = time.perf_counter()
    stop = np.zeros(1, dtype=np.uint8)
    return [work(job, stop) for job in bundle], time.perf_counter() - began


def _count_threads(client: Client, known: set[str]) -> int:
    """Return the number of threads of the cluster, after checking new workers."""
    threads, tell = client.nthreads(), versions_teller(PACKAGES)
    new = [address for address in threads if address not in known]
    # a worker that has left in the meantime does not answer
    there = client.run(tell, workers=new, on_error="ignore") if new else {}
    if not known:
        there["the scheduler"] = client.run_on_scheduler(tell)  # it unpacks what passes through it
    here = tell()
    for place, versions in there.items():
        for name, wanted in here.items():
            if versions[name] != wanted:
                found = f"{name} {versions[name]}"
                raise InputError(f"executor must have {name} {wanted}, got {found} at {place}")
    known.update(there)
    return sum(threads.values())


def versions_teller(names: tuple[str, ...]) -> Callable[[], dict[str, str]]:
    """Return a function that returns the versions of packages on the worker that calls it.

    dask sends a nested function by value, so that a worker without this package can answer.
    """

    def tell() -> dict[str, str]:
        from importlib import metadata  # noqa: PLC0415 - on the worker

        versions = dict.fromkeys((*names, "sources"), "missing")
        with suppress(ImportError):
            from rotor_ida.results.provenance import sources_digest  # noqa: PLC0415 - on the worker

            versions["sources"] = sources_digest()
        for name in names:
            with suppress(metadata.PackageNotFoundError):
                versions[name] = metadata.version(name)
        return versions

    return tell


@contextmanager
def _connected(workers: int | None) -> Iterator[Client]:
    """Start a cluster of processes on this machine; end it, at once if the jobs are not done."""
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="rotor-ida-"))
        with deaf_to_interrupts():
            cluster = _local_cluster(workers, folder)
            stack.callback(_close, cluster)
            client = stack.enter_context(Client(cluster, set_as_default=False))
        finished = False
        try:
            yield client
            finished = True
        finally:
            if not finished:
                cluster.sync(_end_workers, cluster)


def _local_cluster(workers: int | None, folder: str) -> LocalCluster:
    try:
        return LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            memory_limit=0,
            dashboard_address=None,
            scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
            local_directory=folder,
            silence_logs=logging.CRITICAL,
        )
    except (RuntimeError, OSError) as error:
        raise SimulationError(f"no worker could be started: {CAUSES}") from error


def _close(cluster: LocalCluster) -> None:
    """Close a cluster, with a time limit: dask can wait forever after an interrupt.

    A thread may then remain, and processes if none was ended before; both end with this program.
    """
    with suppress(asyncio.TimeoutError):
        cluster.close(timeout=TIME_TO_CLOSE)


async def _end_workers(cluster: LocalCluster) -> None:
    """End the workers at once; with dask's own grace period they would finish their jobs first."""
    closing = [nanny.close(timeout=GRACE) for nanny in cluster.workers.values()]
    await asyncio.gather(*closing, return_exceptions=True)


@contextmanager
def _joined(address: str) -> Iterator[Client]:
    """Connect to a running scheduler, and leave it running."""
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(f"executor {address!r} does not answer: {error}") from error
    with client:
        yield client


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep dask's log messages from standard error."""
    names = [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]
    handlers = {handler for name in names for handler in logging.getLogger(name).handlers}
    before = {handler: handler.level for handler in handlers}
    for handler in before:
        handler.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for handler, level in before.items():
            handler.setLevel(level)
