"""Which backend runs, and what a run leaves behind."""

import importlib.util
import sys
import threading
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    InputError,
    InstallationError,
    Rotor,
    SimulationError,
    basin_fractions,
    poincare_section,
    run_up,
    simulate,
)
from rotor_ida.core import sundials
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
REST = (0.0, 0.0, 0.0, 0.0)
needs_sundials = pytest.mark.skipif(
    importlib.util.find_spec("sksundae") is None, reason="scikit-sundae is not installed"
)


@needs_sundials
def test_auto_is_compiled_where_it_can_be_had(monkeypatch):
    assert Options().backend == "compiled"
    assert Options(method="ida").backend == "python"
    with pytest.raises(InputError, match=r"'compiled' cannot be used: it knows .* got 'ida'"):
        Options(method="ida", backend="compiled")
    monkeypatch.setattr(sundials, "why_not", lambda: "the libraries were not found")
    assert Options().backend == "python"
    with pytest.raises(InputError, match="'compiled' cannot be used: the libraries were not"):
        Options(backend="compiled")
    assert Options(method="taylor").backend == "compiled"


@needs_sundials
def test_the_reference_says_that_it_integrates_flight():
    assert Options(flight="exact", backend="python").flight == "cvode"
    assert Options(method="ida").flight == "cvode"
    assert Options().flight == "exact"


@pytest.mark.parametrize(
    ("probe", "version", "reason"),
    [
        ((7, 1.25), (7, 9, 0), "index"),
        ((3, 1.25), (7, 9, 0), "double precision"),
        ((3, sundials.PROBE), (6, 7, 0), "must be version 7, found 6.7.0"),
    ],
)
def test_libraries_that_do_not_fit_are_not_called(monkeypatch, probe, version, reason):
    monkeypatch.setattr(sundials, "_probe", lambda *_: probe)
    monkeypatch.setattr(sundials, "_version", lambda _: version)
    with pytest.raises(sundials.Unfit, match=reason):
        sundials._check({"core": None, "nvecserial": None})


def test_missing_libraries_are_named(monkeypatch, tmp_path):
    with pytest.raises(sundials.Unfit, match="sundials_cvode is missing"):
        sundials._library(tmp_path, "cvode")
    monkeypatch.setattr(sundials.sys, "prefix", str(tmp_path))
    with pytest.raises(sundials.Unfit, match="were not found beside"):
        sundials._folder(tmp_path / "sksundae")


@pytest.fixture
def asked_anew():
    """The libraries are looked for again, now and afterwards."""
    remembered = (sundials._loaded, sundials.functions, sundials.why_not, sundials.version)
    for function in remembered:
        function.cache_clear()
    yield
    for function in remembered:
        function.cache_clear()


@needs_sundials
def test_a_library_that_lacks_a_function_is_named(monkeypatch, asked_anew):
    lacking = {**sundials.FUNCTIONS, "solve": ("cvode", "CVodeOfTomorrow")}
    monkeypatch.setattr(sundials, "FUNCTIONS", lacking)
    assert "CVodeOfTomorrow" in sundials.why_not()
    assert Options().backend == "python"
    with pytest.raises(InputError, match=r"'compiled' cannot be used: .*CVodeOfTomorrow"):
        Options(backend="compiled")


@pytest.fixture
def without_sundae(monkeypatch, asked_anew):
    """As on Linux on ARM, for which scikit-sundae has no wheel."""
    for name in [name for name in sys.modules if name.startswith("sksundae")]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, "sksundae", None)
    for name in [name for name in sys.modules if name.startswith("rotor_ida.simulation.witness")]:
        monkeypatch.delitem(sys.modules, name)


@pytest.mark.usefixtures("without_sundae")
def test_without_scikit_sundae_runs_are_by_taylor_series_and_say_so():
    assert sundials.why_not() == "scikit-sundae is not installed"
    assert sundials.version() == ""
    found = simulate(BOUNCING, start=REST, duration=20.0)
    xr.testing.assert_identical(
        found, simulate(BOUNCING, start=REST, duration=20.0, method="taylor")
    )
    assert found.attrs["method"] == "taylor"
    assert '"method":"taylor"' in found.attrs["question"]
    ramp = run_up(replace(BOUNCING, omega=0.2), to=1.5, rate=0.02)
    assert ramp.attrs["method"] == "taylor"
    assert poincare_section(BOUNCING, revolutions=3).attrs["method"] == "taylor"
    basins = basin_fractions(replace(BOUNCING, delta0=0.0), x=(-15, 15), y=(-15, 15), starts=20)
    assert basins.attrs["confirmation_method"] == "taylor"
    assert basins.confirmed.all()


@pytest.mark.parametrize(
    "asked",
    [{"backend": "python"}, {"method": "adams"}, {"method": "ida"}, {"flight": "cvode"},
     {"rtol": 1e-3}],
)  # fmt: skip
@pytest.mark.usefixtures("without_sundae")
def test_without_scikit_sundae_what_needs_it_says_so(asked):
    with pytest.raises(InstallationError, match=r"^backend 'python' needs scikit-sundae: pip inst"):
        simulate(BOUNCING, start=REST, duration=1.0, **asked)


@pytest.mark.usefixtures("without_sundae")
def test_without_scikit_sundae_a_system_has_taylor_series_and_cvode_says_so():
    system = BOUNCING.system()
    given = {"speed": BOUNCING.omega}
    assert simulate(system, **given, duration=20.0).sizes["event"] > 2
    message = r"^backend 'python' needs scikit-sundae: pip inst"
    with pytest.raises(InstallationError, match=message):
        simulate(system, **given, duration=1.0, method="adams")


@needs_sundials
def test_with_scikit_sundae_runs_are_by_adams():
    assert simulate(BOUNCING, start=REST, duration=1.0).attrs["method"] == "adams"


@pytest.mark.parametrize("name", ["libsundials_core.7.9.0.dylib", "sundials_core-db7c109a.dll"])
def test_the_layouts_of_other_systems_are_known(tmp_path, name):
    (tmp_path / name).touch()
    assert sundials._library(tmp_path, "core").name == name


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


def test_runs_one_after_the_other_leave_nothing_behind():
    resource = pytest.importorskip("resource")
    times = np.array([3.0])

    def largest_after(runs):
        for _ in range(runs):
            run(BOUNCING, REST, 3.0, times, Options())
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    settled = largest_after(300)
    assert largest_after(3000) - settled < 2048  # KiB; one solver left behind each time is 20 MiB
