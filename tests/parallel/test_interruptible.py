"""Whatever computes for long ends at Ctrl-C, or at any other exception in the main thread."""

import subprocess
import sys

import pytest

from rotor_ida.parallel import interruptible

PROGRAM = """
import signal, sys, threading
import rotor_ida
from rotor_ida import Rotor

class Late(Exception):
    pass

def late(number, frame):
    raise Late

# where a shell starts a job in the background, SIGINT is ignored
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGALRM, late)
rotor, rest = Rotor(omega=2.0, zeta=0.07, delta0=2.0), (0.0, 0.0, 0.0, 0.0)
{first}
number, expected = {signal}
main = threading.main_thread().ident
threading.Timer(0.5, lambda: signal.pthread_kill(main, number)).start()
try:
    {call}
    print("was not stopped")
except expected:
    print("stopped", threading.active_count())
"""
INTERRUPT = "signal.SIGINT, KeyboardInterrupt"
ALARM = "signal.SIGALRM, Late"
SIMULATE = "rotor_ida.simulate(rotor, start=rest, duration={})"
EXPONENTS = "rotor_ida.lyapunov_exponent(rotor, start=rest, duration={})"
SECTION = 'rotor_ida.poincare_section(rotor, start=rest, revolutions={}, at="PLACE")'
DIAGRAM = (
    "rotor_ida.bifurcation_diagram(omega=2.0, zeta=0.07, delta0=2.0, starts=[rest], "
    "extrema_time={})"
)
DRIFT = (
    "rotor_ida.simulate(Rotor(omega=1.0, zeta=0.0, delta0=1.5), "
    "start=(-1.0, 0.0, 1e-9, -1.0), duration={}, samples=2)"
)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize(
    ("call", "short", "long", "signal"),
    [
        (SIMULATE, "1.0", "1e7", INTERRUPT),
        (SIMULATE, "1.0", "1e7", ALARM),
        (DRIFT, "1.0", "1e9", INTERRUPT),
        (EXPONENTS, "200.0", "1e6", INTERRUPT),
        (SECTION.replace("PLACE", "entry"), "2", "10**6", ALARM),
        (SECTION.replace("PLACE", "peak"), "2", "10**5", INTERRUPT),
        (DIAGRAM, "10.0", "3e5", INTERRUPT),
    ],
    ids=["run", "run, alarm", "long flight", "exponents", "entries", "peaks", "diagram"],
)
def test_long_work_in_compiled_code_is_stopped(call, short, long, signal):
    """Each would take minutes; the short call before it compiles what is not cached."""
    program = PROGRAM.format(first=call.format(short), call=call.format(long), signal=signal)
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=240, check=False
    )
    assert done.stdout.split() == ["stopped", "1"], done.stdout + done.stderr


def test_what_the_work_returns_or_raises_is_passed_on():
    assert interruptible(lambda stop: int(stop[0])) == 0

    def fail(stop):
        raise ValueError("three")

    with pytest.raises(ValueError, match="three"):
        interruptible(fail)
