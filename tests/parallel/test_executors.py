"""Many jobs: all done once, few at a time, given up at once when one fails or the user wants."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import closing, contextmanager

import pytest

from rotor_ida import InputError, SimulationError
from rotor_ida.parallel import choose, count_workers, run_all
from rotor_ida.parallel.jobs import IN_FLIGHT


def square(job, _stop):
    return job**2


def die_at_three(job, _stop):
    if job == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return job


def fail_at_three(job, stop):
    if job == 3:
        raise ValueError("three")
    while not stop[0]:
        time.sleep(0.01)


@pytest.mark.parametrize(
    ("workers", "executor"), [(1, "serial"), (1, "threads"), (3, "threads"), (2, "processes")]
)
def test_every_job_is_done_once_and_keeps_its_number(workers, executor):
    ended = dict(run_all(square, iter(range(20)), workers=workers, executor=executor))
    assert ended == {number: number**2 for number in range(20)}


def threads_of_blas(_job, _stop):
    return os.environ.get("OPENBLAS_NUM_THREADS")


def test_each_process_has_one_thread_for_linear_algebra(monkeypatch):
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    assert dict(run_all(threads_of_blas, range(2), workers=2, executor="processes")) == {
        0: "1",
        1: "1",
    }
    assert "OPENBLAS_NUM_THREADS" not in os.environ


def test_only_a_few_jobs_are_in_flight():
    taken, ended = [], []

    def jobs():
        for number in range(200):
            taken.append(number)
            yield number

    for number, _ in run_all(square, jobs(), workers=2, executor="threads"):
        ended.append(number)
        assert len(taken) - len(ended) < 2 * IN_FLIGHT
    assert len(ended) == 200


def test_jobs_by_threads_run_at_the_same_time():
    both = threading.Barrier(2, timeout=60.0)
    assert (
        len(list(run_all(lambda _j, _s: both.wait(), [0, 1], workers=2, executor="threads"))) == 2
    )


def test_a_failure_is_raised_and_stops_the_rest():
    """They would run for ever."""
    before = threading.active_count()
    with pytest.raises(ValueError, match="three"):
        list(run_all(fail_at_three, range(1, 50), workers=3, executor="threads"))
    assert threading.active_count() <= before


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_process_that_dies_is_told_in_one_line():
    with pytest.raises(SimulationError, match=r"^a worker process died: [^\n]*$") as told:
        list(run_all(die_at_three, range(50), workers=2, executor="processes"))
    assert told.value.__cause__ is None
    assert multiprocessing.active_children() == []


def test_who_stops_asking_leaves_nothing_behind():
    before = threading.active_count()
    with closing(run_all(square, range(100), workers=2, executor="threads")) as ended:
        next(ended)
    assert threading.active_count() <= before


@contextmanager
def started(command, **options):
    """Start a program, and see that it ends: a test that is out of time must not wait for it."""
    with subprocess.Popen(command, **options) as program:
        try:
            yield program
        finally:
            program.kill()


INTERRUPTED = """
import signal, sys, time, threading, multiprocessing
sys.path.insert(0, {folder!r})
from rotor_ida.parallel import run_all

def work(job, stop):
    if job == 0:
        return
    while not stop[0]:
        time.sleep(0.01)

if __name__ == "__main__":
    try:
        for _ in run_all(work, range(10), workers=2, executor={executor!r}):
            print("started", flush=True)
    except KeyboardInterrupt:
        left = multiprocessing.active_children()
        others = [each for each in threading.enumerate()[1:] if "Offload" not in each.name]
        for each in others:  # dask's profiler ends by itself, a moment later
            each.join(5.0)
        left += [each.name for each in others if each.is_alive()]
        print("left", left, flush=True)
"""


@pytest.mark.parametrize("executor", ["threads", "processes", "dask"])
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_an_interrupt_ends_it_at_once(tmp_path, executor):
    """The jobs in hand would run for ever."""
    script = tmp_path / "script.py"
    script.write_text(INTERRUPTED.format(folder=str(tmp_path), executor=executor))
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with started([sys.executable, script], cwd=tmp_path, **pipes) as program:
        assert program.stdout.readline() == "started\n"
        program.send_signal(signal.SIGINT)
        assert program.stdout.readline() == "left []\n"
        assert program.wait(60.0) == 0
        assert program.stderr.read() == ""
    assert list(tmp_path.iterdir()) == [script]


KILLED = """
import sys, time
sys.path.insert(0, {folder!r})
from rotor_ida.parallel import run_all

def work(job, stop):
    return job

if __name__ == "__main__":
    for _ in run_all(work, range(10), workers=1, executor="processes"):
        print("started", flush=True)
        time.sleep(60.0)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_no_worker_outlives_a_program_that_is_killed(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(KILLED.format(folder=str(tmp_path)))
    with started([sys.executable, script], stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout.readline() == "started\n"
        program.kill()
        # the output ends when nobody is left who could write to it
        assert program.communicate(timeout=50.0)[0] == ""


def test_workers_are_counted():
    assert count_workers(3) == 3
    assert count_workers(None) >= 1
    with pytest.raises(InputError, match="workers must be at least 1, got 0"):
        count_workers(0)


@pytest.mark.parametrize(
    ("executor", "workers", "compiled", "chosen"),
    [
        ("auto", None, False, ("serial", 1)),
        ("threads", 3, False, ("threads", 3)),
        ("processes", None, True, ("processes", count_workers(None))),
    ],
)
def test_what_is_chosen(executor, workers, compiled, chosen):
    assert choose(executor, workers, compiled=compiled) == chosen


@pytest.mark.parametrize(
    ("executor", "workers", "message"),
    [
        ("serial", 2, "workers must be 1 with executor 'serial', got 2"),
        ("gpu", None, "executor must be one of 'auto', 'serial', .*, got 'gpu'"),
        (None, None, "executor must be one of .*, got None"),
    ],
)
def test_what_cannot_be_chosen(executor, workers, message):
    with pytest.raises(InputError, match=f"^{message}$"):
        choose(executor, workers, compiled=True)
