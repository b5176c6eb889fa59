"""Whatever computes for long ends at Ctrl-C, or at any other exception in the main thread."""

import subprocess
import sys
import threading
import time

import pytest

from rotor_ida.parallel import interruptible

# Each long call would take minutes; the short one before it loads what is needed.
PROGRAM = """
import signal, threading, time
from rotor_ida import (
    Rotor, bifurcation_diagram, lyapunov_exponent, poincare_section, run_up, simulate, sweep
)

class Late(Exception):
    pass

def late(number, frame):
    raise Late

signal.signal(signal.SIGALRM, late)
main = threading.main_thread().ident
rotor, rest = Rotor(omega=2.0, zeta=0.07, delta0=2.0), (0.0, 0.0, 0.0, 0.0)
drifting = Rotor(omega=1.0, zeta=0.0, delta0=1.5)
system = rotor.system()
parts = {"speed": rotor.omega}
point = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0, "starts": [rest]}
calls = {
    "run": (lambda time: simulate(rotor, start=rest, duration=time), 1.0, 1e7),
    "flight": (lambda time: simulate(drifting, start=(-1, 0, 1e-9, -1), duration=time), 1.0, 1e8),
    "exponents": (lambda time: lyapunov_exponent(rotor, start=rest, duration=time), 200.0, 1e6),
    "entries": (lambda n: poincare_section(rotor, start=rest, revolutions=n, at="entry"), 1, 10**6),
    "peaks": (lambda n: poincare_section(rotor, start=rest, revolutions=n, at="peak"), 1, 10**5),
    "diagram": (lambda time: bifurcation_diagram(**point, extrema_time=time), 10.0, 3e5),
    "run-up": (lambda time: run_up(rotor, start=rest, to=3.0, ramp_time=time), 10.0, 1e7),
    "system": (lambda time: simulate(system, **parts, duration=time, samples=9), 10.0, 1e7),
    "sweep": (lambda n: sweep(**point | {"omega": range(2, 2 + n)}, executor="serial"), 1, 900),
}
for name, (call, short, long) in calls.items():
    call(short)
    for number, expected in ((signal.SIGINT, KeyboardInterrupt), (signal.SIGALRM, Late)):
        timer = threading.Timer(0.15, signal.pthread_kill, (main, number))
        timer.start()
        try:
            call(long)
            print(name, "was not stopped")
        except expected:
            # a thread that was only just starting ends by itself, a moment later
            timer.join()
            last = time.monotonic() + 20.0
            while threading.active_count() > 1 and time.monotonic() < last:
                time.sleep(0.001)
            print(name, threading.active_count(), flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_long_work_in_compiled_code_is_stopped_and_its_thread_ends():
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=270, check=False
    )
    names = (
        "run",
        "flight",
        "exponents",
        "entries",
        "peaks",
        "diagram",
        "run-up",
        "system",
        "sweep",
    )
    assert done.stdout.split("\n")[:-1] == [f"{name} 1" for name in names for _ in range(2)], (
        done.stderr
    )


def test_what_the_work_returns_or_raises_is_passed_on():
    assert interruptible(lambda stop: int(stop[0])) == 0

    def fail(stop):
        raise ValueError("three")

    with pytest.raises(ValueError, match="three"):
        interruptible(fail)


def test_an_exception_while_the_thread_starts_stops_the_work(monkeypatch):
    start, stopped = threading.Thread.start, []

    def interrupted(thread):
        start(thread)
        raise KeyboardInterrupt

    def work(stop):
        last = time.monotonic() + 20.0
        while not stop[0] and time.monotonic() < last:
            time.sleep(0.001)
        stopped.append(bool(stop[0]))

    monkeypatch.setattr(threading.Thread, "start", interrupted)
    with pytest.raises(KeyboardInterrupt):
        interruptible(work)
    assert stopped == [True]
