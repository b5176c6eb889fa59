"""Many jobs: all done once, few at a time, given up at once when one fails or the user wants."""

import signal
import subprocess
import sys
import threading
import time
from contextlib import closing

import pytest

from rotor_ida import InputError
from rotor_ida.ensemble import IN_FLIGHT, count_workers, run_all


def square(job, _stop):
    return job**2


def fail_at_three(job, stop):
    if job == 3:
        raise ValueError("three")
    for _ in range(1000):
        if stop[0]:
            return "stopped"
        time.sleep(0.01)
    return "not stopped"


@pytest.mark.parametrize(("workers", "threads"), [(1, False), (1, True), (3, True), (2, False)])
def test_every_job_is_done_once_and_keeps_its_number(workers, threads):
    ended = dict(run_all(square, iter(range(20)), workers=workers, threads=threads))
    assert ended == {number: number**2 for number in range(20)}


def test_only_a_few_jobs_are_in_flight():
    taken, ended = [], []

    def jobs():
        for number in range(200):
            taken.append(number)
            yield number

    for number, _ in run_all(square, jobs(), workers=2, threads=True):
        ended.append(number)
        assert len(taken) - len(ended) < 2 * IN_FLIGHT
    assert len(ended) == 200


def test_jobs_by_threads_run_at_the_same_time():
    both = threading.Barrier(2, timeout=10.0)
    assert len(list(run_all(lambda _j, _s: both.wait(), [0, 1], workers=2, threads=True))) == 2


def test_a_failure_is_raised_and_stops_the_rest():
    began = time.perf_counter()
    with pytest.raises(ValueError, match="three"):
        list(run_all(fail_at_three, range(1, 50), workers=3, threads=True))
    assert time.perf_counter() - began < 5.0
    assert threading.active_count() == 1


def test_who_stops_asking_leaves_nothing_behind():
    with closing(run_all(square, range(100), workers=2, threads=True)) as ended:
        next(ended)
    assert threading.active_count() == 1


INTERRUPTED = """
import sys, time, threading, multiprocessing
sys.path.insert(0, {folder!r})
from rotor_ida.ensemble import run_all

def work(job, stop):
    if job == 0:
        return
    while not stop[0]:
        time.sleep(0.01)

if __name__ == "__main__":
    try:
        for _ in run_all(work, range(10), workers=2, threads={threads}):
            print("started", flush=True)
    except KeyboardInterrupt:
        left = threading.active_count() - 1 + len(multiprocessing.active_children())
        print("left", left, flush=True)
"""


@pytest.mark.parametrize("threads", [True, False])
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_an_interrupt_ends_it_at_once(tmp_path, threads):
    script = tmp_path / "script.py"
    script.write_text(INTERRUPTED.format(folder=str(tmp_path), threads=threads))
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout.readline() == "started\n"
        began = time.perf_counter()
        program.send_signal(signal.SIGINT)
        assert program.stdout.readline() == "left 0\n"
        assert time.perf_counter() - began < 2.0
        assert program.wait(5.0) == 0


def test_workers_are_counted():
    assert count_workers(3) == 3
    assert count_workers(None) >= 1
    with pytest.raises(InputError, match="workers must be at least 1, got 0"):
        count_workers(0)
