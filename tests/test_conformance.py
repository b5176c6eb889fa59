"""Every kind of archive that is written: sound to CF's checker and to readers other than ours."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida import DimensionalRotor, Rotor

CENTRED = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
REST = (0.0, 0.0, 0.0, 0.0)
MACHINE = DimensionalRotor(
    mass=4.0,
    contact_stiffness=1e9,
    damping=280.0,
    eccentricity=1e-6,
    clearance=2e-6,
    speed=600.0,
)


def a_run(delta0: float = 2.0) -> xr.Dataset:
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=delta0)
    return rotor_ida.simulate(rotor, start=REST, duration=20.0, samples=41)


def a_sweep(direction: str = "up") -> xr.Dataset:
    return rotor_ida.sweep(omega=[1.2, 1.3], zeta=0.07, delta0=[0.0, 0.5], direction=direction)


KINDS: dict[str, Callable[[], xr.Dataset]] = {
    "run": a_run,
    "run_without_contact": lambda: a_run(delta0=9.0),
    "run_in_si_units": lambda: rotor_ida.dimensional(a_run(), MACHINE),
    "sweep": a_sweep,
    "sweep_both_ways": lambda: a_sweep("both"),
    "comparison": lambda: rotor_ida.compare(a_sweep()),
    "whirls": lambda: rotor_ida.synchronous_response(omega=[1.2, 1.7], zeta=0.07, delta0=0.5),
    "folds": lambda: rotor_ida.folds(zeta=[0.07, 0.1], delta0=0.0),
    "basin": lambda: rotor_ida.basin(CENTRED, x=np.linspace(-5, 5, 4), y=[0.0, 1.0], workers=1),
    "shares": lambda: rotor_ida.shares(CENTRED, x=(-5, 5), y=(-5, 5), starts=20, workers=1),
    "contact_summary": lambda: rotor_ida.contact_summary(a_run()),
    "rotating": lambda: rotor_ida.rotating(a_run()),
    "spectrum": lambda: rotor_ida.spectrum(a_run()),
    "contact_forces": lambda: rotor_ida.contact_forces(a_run()),
    "poincare_section": lambda: rotor_ida.poincare_section(CENTRED, start=REST, revolutions=5),
    "lyapunov_exponent": lambda: rotor_ida.lyapunov_exponent(
        CENTRED, start=REST, transient=5.0, duration=40.0, batches=4
    ),
    "bifurcation": lambda: rotor_ida.bifurcation(
        omega=[1.2], zeta=0.2, delta0=0.0, starts=1, extrema_time=20.0
    ),
}


@pytest.fixture(scope="module", params=KINDS)
def archive(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("kinds")
    return rotor_ida.save(KINDS[request.param](), folder / f"{request.param}.nc")


def what_the_checker_says(path: Path) -> tuple[bool, str]:
    """Return whether CF's checker is content, as its exit status would say, and its report."""
    runner = pytest.importorskip("compliance_checker.runner")
    suite = runner.CheckSuite
    suite.load_all_available_checkers()
    report = path.with_suffix(".txt")
    passed, errors = runner.ComplianceChecker.run_checker(
        str(path), ["cf:1.11"], 0, "normal", output_filename=str(report)
    )
    return passed and not errors, report.read_text()


@pytest.mark.filterwarnings("default")
def test_checker_of_cf_is_content(archive: Path) -> None:
    passed, report = what_the_checker_says(archive)
    assert passed, report


def test_h5netcdf_reads_the_same(archive: Path) -> None:
    pytest.importorskip("h5netcdf")
    pytest.importorskip("h5py")
    loaded = rotor_ida.load(archive)
    with xr.open_dataset(archive, engine="h5netcdf") as seen:
        for name, variable in loaded.variables.items():
            assert variable.identical(seen.variables[name].load()), name


@pytest.mark.skipif(shutil.which("ncdump") is None, reason="ncdump is not installed")
def test_ncdump_shows_the_header(archive: Path) -> None:
    shown = subprocess.run(["ncdump", "-h", archive], capture_output=True, text=True, check=True)
    assert ':Conventions = "CF-1.11"' in shown.stdout
    assert not shown.stderr


def test_no_attribute_holds_what_flags_should(archive: Path) -> None:
    for name, variable in rotor_ida.load(archive).variables.items():
        assert variable.dtype.kind in "iuf" or name == "message"


@pytest.mark.filterwarnings("default")
def test_checker_finds_what_the_domain_variable_cures(tmp_path: Path) -> None:
    path = tmp_path / "plain.nc"
    plain = a_run().assign_attrs(history="2026-11-21T15:00:00Z made")
    plain.to_netcdf(path, encoding={name: {"_FillValue": None} for name in plain.variables})
    passed, report = what_the_checker_says(path)
    assert not passed
    assert "'time' should have standard_name='time'" in report
