"""Jobs on clusters of dask: the same results, and a worker that dies costs its own jobs a retry."""

import asyncio
import importlib.util
import logging
import multiprocessing
import os
import signal
import threading
import time
from contextlib import closing

import numpy as np
import pytest
from distributed import Client, LocalCluster

from rotor_ida import InputError, Rotor, SimulationError, basin, sweep
from rotor_ida.parallel import FailedJob, cluster, run_all

SPEEDS = {"omega": np.linspace(1.0, 2.4, 5), "zeta": 0.07, "delta0": [0.5, 2.0]}
# Many starts of this one are captured by no set, so that all that a batch brings back counts.
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


def square(job, _stop):
    return job**2


def fail_at_three(job, _stop):
    if job == 3:
        raise ValueError("three")
    return job


def die_at_three(job, _stop):
    if job == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.02)
    return job


def local_cluster(workers, **scheduler):
    return LocalCluster(
        n_workers=workers, threads_per_worker=1, memory_limit=0, silence_logs=logging.CRITICAL,
        dashboard_address=None, scheduler_kwargs={"dashboard_address": "127.0.0.1:0", **scheduler},
    )  # fmt: skip


@pytest.fixture(scope="module")
def workplace():
    """Return a cluster that is not ours, and suspects a job at the first death of its worker."""
    with local_cluster(workers=2, allowed_failures=0) as started:
        yield started


@pytest.fixture
def address(workplace):
    """Return its address, and see that it is left as it was."""
    yield workplace.scheduler_address
    scheduler, late = workplace.scheduler, time.monotonic() + 60.0
    while (
        scheduler.tasks
        or set(scheduler.clients) != {"fire-and-forget"}
        or len(scheduler.workers) < 2
    ):
        assert time.monotonic() < late
        time.sleep(0.01)


def test_a_sweep_finds_the_same_bits(address):
    calls = []
    how = {**SPEEDS, "events": True}
    there = sweep(**how, executor=address, progress=lambda *call: calls.append(call))
    assert sweep(**how, executor="serial").identical(there)
    assert there.sizes["event"] > 0
    assert calls == [(number, 10) for number in range(1, 11)]


@pytest.mark.parametrize("number", [1, 6, 50])
def test_every_job_is_done_once_and_keeps_its_number(address, number):
    ended = list(run_all(square, range(number), workers=None, executor=address))
    assert sorted(ended) == [(job, job**2) for job in range(number)]


def test_only_the_job_that_kills_its_workers_is_lost(address):
    """Those that waited at the same worker are suspected with it, and done."""
    ended = dict(run_all(die_at_three, range(20), workers=None, executor=address))
    assert ended.pop(3) == FailedJob("every worker that tried it died, 1 in all")
    assert ended == {job: job for job in range(20) if job != 3}


def test_an_error_is_raised_and_one_who_stops_asking_leaves_nothing_behind(address):
    with pytest.raises(ValueError, match="three"):
        list(run_all(fail_at_three, range(20), workers=None, executor=address))
    with closing(run_all(square, range(1000), workers=None, executor=address)) as ended:
        next(ended)


def test_workers_of_another_version_are_refused(address, monkeypatch):
    monkeypatch.setattr(cluster, "PACKAGES", ("numpy", "rotor-other"))
    true_run = Client.run

    def run_elsewhere(client, function, **options):
        there = true_run(client, function, **options)
        return {place: found | {"numpy": "1.0"} for place, found in there.items()}

    monkeypatch.setattr(Client, "run", run_elsewhere)
    message = f"executor must have numpy {np.__version__}, got numpy 1.0 at tcp://[^ ]*"
    with pytest.raises(InputError, match=f"^{message}$"):
        sweep(**SPEEDS, executor=address)


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_worker_that_is_killed_costs_nothing_but_time():
    others, killed = set(multiprocessing.active_children()), []

    def kill_one(_done, _total):
        if not killed:
            killed.extend(set(multiprocessing.active_children()) - others)
            killed[0].kill()

    found = sweep(**SPEEDS, executor="dask", workers=1, progress=kill_one)
    assert len(killed) == 1
    assert found.identical(sweep(**SPEEDS, executor="serial"))
    assert set(multiprocessing.active_children()) == others


def test_workers_may_join_late_and_a_scheduler_that_goes_away_is_told_in_one_line(monkeypatch):
    with local_cluster(workers=0) as short:
        ended = run_all(square, range(30), workers=None, executor=short.scheduler_address)
        later = threading.Timer(0.5, short.scale, [1])
        later.start()
        assert dict(ended) == {number: number**2 for number in range(30)}
        later.join()
        monkeypatch.setattr(cluster, "PATIENCE", 0.5)
        ended = run_all(square, range(1000), workers=None, executor=short.scheduler_address)
        next(ended)
        short.close()
        with pytest.raises(SimulationError, match=r"^the scheduler tcp://[^ ]* is gone$"):
            list(ended)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"executor": "tcp://127.0.0.1:9"}, "executor 'tcp://127.0.0.1:9' does not answer: "),
        ({"executor": "tcp://nowhere"}, "executor must be one of .* or an address such as "),
        ({"executor": "tcp://a:1", "workers": 2}, "workers must be left to the scheduler tcp://a"),
    ],
)
def test_addresses_that_cannot_be_used(monkeypatch, changes, message):
    monkeypatch.setattr(cluster, "PATIENCE", 0.2)
    with pytest.raises(InputError, match=f"^{message}") as told:
        sweep(**SPEEDS, **changes)
    assert "\n" not in str(told.value)


def test_without_dask_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _name: None)
    with pytest.raises(InputError, match=r"needs dask: pip install 'rotor-ida\[cluster\]'$"):
        basin(BOUNCING, x=[0.0], y=[0.0], executor="dask")


def test_a_cluster_that_does_not_close_is_not_waited_for(monkeypatch):
    stuck = []

    async def never_close(local):
        stuck.append(local)
        await asyncio.sleep(600.0)

    monkeypatch.setattr(cluster, "TIME_TO_CLOSE", 0.5)
    monkeypatch.setattr(LocalCluster, "_close", never_close)
    jobs = run_all(square, range(3), workers=1, executor="dask")
    assert sorted(jobs) == [(0, 0), (1, 1), (2, 4)]
    monkeypatch.undo()
    stuck[0].close()
