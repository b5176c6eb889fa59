"""Compiled code takes the same steps as Python: the same events, samples and errors."""

import os
import subprocess
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, SimulationError, simulate
from rotor_ida.simulation.cvode import libraries
from rotor_ida.simulation.cvode.python import Integration
from rotor_ida.simulation.motion import STUCK
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run
from tests.test_reference_events import CASES

ROUNDING = 2.0**-52
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
REST = (0.0, 0.0, 0.0, 0.0)


def both(case, method, flight):
    rotor = Rotor(**{name: case[name] for name in ("omega", "zeta", "delta0")})
    times = np.linspace(0.0, case["duration"], 201)
    return [
        run(rotor, tuple(case["start"]), case["duration"], times, options)
        for options in (
            Options(rtol=1e-9, atol=1e-11, method=method, flight=flight, backend=backend)
            for backend in ("python", "compiled")
        )
    ]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
@pytest.mark.parametrize(("method", "flight"), [("adams", "exact"), ("bdf", "cvode")])
def test_events_and_samples_are_those_of_the_python_backend(case, method, flight):
    """Only the reading inside a step differs, by rounding, which the orbit may amplify."""
    python, compiled = both(case, method, flight)
    assert compiled.event_kinds.tolist() == python.event_kinds.tolist()
    amplified = 1e3 * ROUNDING * max(case["duration"], 1.0)
    assert compiled.event_times == pytest.approx(python.event_times, rel=0, abs=amplified)
    size = max(1.0, np.abs(python.states).max())
    assert np.abs(compiled.states - python.states).max() < amplified * size
    assert compiled.contacts == pytest.approx(python.contacts, rel=1e-6, abs=1e-9, nan_ok=True)


def test_the_whole_dataset_agrees_with_errors_and_horizon():
    python, compiled = (
        simulate(BOUNCING, start=REST, duration=100.0, backend=backend)
        for backend in ("python", "compiled")
    )
    assert compiled.attrs["backend"] == "compiled"
    for name in python.variables:
        assert compiled[name].values == pytest.approx(
            python[name].values, rel=1e-9, abs=1e-12, nan_ok=True
        ), name


def test_auto_is_compiled_where_it_can_be_had(monkeypatch):
    assert Options().backend == "compiled"
    assert Options(method="ida").backend == "python"
    with pytest.raises(InputError, match=r"'compiled' cannot be used: it knows .* got 'ida'"):
        Options(method="ida", backend="compiled")
    monkeypatch.setattr(libraries, "why_not", lambda: "the libraries were not found")
    assert Options().backend == "python"
    with pytest.raises(InputError, match="'compiled' cannot be used: the libraries were not"):
        Options(backend="compiled")
    assert Options(method="taylor").backend == "compiled"


@pytest.mark.parametrize(
    ("probe", "version", "reason"),
    [
        ((7, 1.25), (7, 9, 0), "index"),
        ((3, 1.25), (7, 9, 0), "double precision"),
        ((3, libraries.PROBE), (6, 7, 0), "must be version 7, found 6.7.0"),
        ((3, libraries.PROBE), (7, 0, 0), "was built with SUNDIALS .*, found 7.0.0"),
    ],
)
def test_libraries_that_do_not_fit_are_not_called(monkeypatch, probe, version, reason):
    monkeypatch.setattr(libraries, "_probe", lambda *_: probe)
    monkeypatch.setattr(libraries, "_version", lambda _: version)
    with pytest.raises(libraries.Unfit, match=reason):
        libraries._check(None, None)


def test_missing_libraries_are_named(monkeypatch, tmp_path):
    with pytest.raises(libraries.Unfit, match="sundials_cvode is missing"):
        libraries._library(tmp_path, "cvode")
    monkeypatch.setattr(libraries.sksundae, "__file__", str(tmp_path / "sksundae" / "__init__.py"))
    monkeypatch.setattr(libraries.sys, "prefix", str(tmp_path))
    with pytest.raises(libraries.Unfit, match="were not found beside"):
        libraries._folder()


@pytest.mark.parametrize("name", ["libsundials_core.7.9.0.dylib", "sundials_core-db7c109a.dll"])
def test_the_layouts_of_other_systems_are_known(tmp_path, name):
    (tmp_path / name).touch()
    assert libraries._library(tmp_path, "core").name == name


def test_threads_give_what_one_gives():
    """Eight at once, each with its own solver, and the interpreter left free meanwhile."""
    times = np.linspace(0.0, 100.0, 11)
    alone = run(BOUNCING, REST, 100.0, times, Options())
    found, threads = [], []
    for _ in range(8):
        job = lambda: found.append(run(BOUNCING, REST, 100.0, times, Options()))  # noqa: E731
        threads.append(threading.Thread(target=job))
        threads[-1].start()
    for thread in threads:
        thread.join()
    assert len(found) == 8
    for orbit in found:
        assert (orbit.event_times == alone.event_times).all()
        assert (orbit.states == alone.states).all()


def test_a_run_can_be_asked_to_stop():
    stop = np.zeros(1, np.uint8)
    threading.Timer(0.2, lambda: stop.__setitem__(0, 1)).start()
    with pytest.raises(SimulationError, match="interrupted") as stopped:
        run(BOUNCING, REST, 1e7, np.array([1e7]), Options(), stop=stop)
    assert stopped.value.time < 1e7


def test_an_integration_that_stands_still_is_given_up():
    """At a time whose spacing of doubles is longer than the step."""

    class Standing:
        def step(self, goal, how):
            return SimpleNamespace(success=True, t=0.0, y=np.zeros(1), nfev=1)

    integration = Integration("adams", 1e-10, lambda values, rate: None)
    integration._solver = Standing()
    assert integration.advance() == STUCK
    assert integration.message == "time no longer advances"


def test_runs_one_after_the_other_leave_nothing_behind():
    resource = pytest.importorskip("resource")
    times = np.array([3.0])

    def largest_after(runs):
        for _ in range(runs):
            run(BOUNCING, REST, 3.0, times, Options())
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    settled = largest_after(300)
    assert largest_after(3000) - settled < 2048  # KiB; one solver left behind each time is 20 MiB


ALLOCATED = """
import gc
import numpy as np
from numba.core.runtime import rtsys
from rotor_ida import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run
from rotor_ida.stability.lyapunov import follow_stretches
from rotor_ida.stability.tangent_flow import follow_from, follow_on

rotor, go_on = Rotor(omega=2.0, zeta=0.07, delta0=2.0), np.zeros(1, np.uint8)
where = ((2.0, 0.07, 2.0), 1e-9, go_on)


def work():
    for method in ("adams", "taylor"):
        run(rotor, (0.0, 0.0, 0.0, 0.0), 10.0, np.linspace(0.0, 10.0, 5), Options(method=method))
        bundle = np.vstack([np.zeros(4), np.eye(4)])
        follow_stretches(bundle, False, 2.0, np.empty((5, 4)), *where, method)
    follow_on(np.zeros((5, 4)), np.zeros(5, np.bool_), 2.0, *where)
    follow_from(np.zeros((2, 4)), np.zeros(2, np.bool_), np.full(2, 9.0), np.zeros((2, 4)), *where)


def held():
    gc.collect()
    found = rtsys.get_allocation_stats()
    return found.alloc - found.free


work()
before = held()
for _ in range(3):
    work()
print(rtsys.get_allocation_stats().alloc > 0, held() - before)
"""


def test_what_compiled_code_allocates_is_freed():
    """Its structures are not counted: whoever makes one releases it."""
    answer = subprocess.run(
        [sys.executable, "-c", ALLOCATED], env=os.environ | {"NUMBA_NRT_STATS": "1"},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (answer.stdout, answer.stderr) == ("True 0\n", "")
