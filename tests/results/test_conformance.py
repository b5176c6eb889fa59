"""Every kind of archive that is written: sound to CF's checker and to readers other than ours."""

from __future__ import annotations

import functools
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import pytest
import xarray as xr

import rotor_ida
from tests.example_datasets import KINDS, a_dataset, a_run, a_system_run

ASKED = [
    *("get_time_variable", "guess_feature_type"),
    *(
        f"get_{name}_variables"
        for name in (
            *("auxiliary_coordinate", "geophysical", "forecast_metadata"),
            *("cell_boundary", "bounds", "instrument", "platform"),
            *("axis", "time", "latitude", "longitude", "z"),
        )
    ),
]


@pytest.fixture(scope="module", params=KINDS)
def archive(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("kinds")
    return rotor_ida.save(KINDS[request.param](), folder / f"{request.param}.nc")


@functools.cache
def table_of_names() -> Any:
    return resolve_name("compliance_checker.cf.util.StandardNameTable")()


@functools.cache
def suite_of_checkers() -> Any:
    suite = pytest.importorskip("compliance_checker.runner").CheckSuite
    suite.load_all_available_checkers()
    return suite


def what_the_checker_says(path: Path) -> tuple[bool, str]:
    """Return whether CF's checker is content, as its exit status would say, and its report."""
    runner = pytest.importorskip("compliance_checker.runner")
    suite_of_checkers()
    report = path.with_suffix(".txt")
    with pytest.MonkeyPatch.context() as patch:
        table = table_of_names()
        patch.setattr("compliance_checker.cf.util.StandardNameTable", lambda: table)
        # the checker asks these of one file thousands of times
        for name in ASKED:
            asked = f"compliance_checker.cf.util.{name}"
            patch.setattr(asked, functools.cache(resolve_name(asked)))
        passed, errors = runner.ComplianceChecker.run_checker(
            str(path), ["cf:1.11"], 0, "normal", output_filename=str(report)
        )
    return passed and not errors, report.read_text()


@pytest.mark.filterwarnings("default")
def test_checker_of_cf_is_content(archive: Path) -> None:
    passed, report = what_the_checker_says(archive)
    assert passed, report


@pytest.mark.parametrize("build", [a_dataset, a_run, a_system_run])
def test_h5netcdf_reads_the_same(build: Callable[[], xr.Dataset], tmp_path: Path) -> None:
    pytest.importorskip("h5netcdf")
    pytest.importorskip("h5py")
    archive = rotor_ida.save(build(), tmp_path / "archive.nc")
    loaded = rotor_ida.load(archive)
    with xr.open_dataset(archive, engine="h5netcdf") as seen:
        for name, variable in loaded.variables.items():
            if name in loaded.dims and variable.dtype.kind == "U":
                same = seen.variables[f"{name}_label"]
                assert same.values.tolist() == variable.values.tolist()
            else:
                assert variable.identical(seen.variables[name].load()), name


def test_ncdump_shows_the_headers(archive: Path) -> None:
    if shutil.which("ncdump") is None:
        pytest.skip("ncdump is not installed (netcdf-bin of Debian and Ubuntu has it)")
    shown = subprocess.run(["ncdump", "-h", archive], capture_output=True, text=True, check=True)
    assert ':Conventions = "CF-1.11"' in shown.stdout
    assert not shown.stderr


# Messages, and names that a user gives.
FREE_WORDS = {
    *("message", "machine", "probe", "peak_node", "bearing_node", "bearing_stator"),
    "bearing_name",
    *("node", "contact_node", "contact_stator", "unbalance_node"),
    "support_node",
}  # fmt: skip


def test_no_attribute_holds_what_flags_should(archive: Path) -> None:
    for name, variable in rotor_ida.load(archive).variables.items():
        assert variable.dtype.kind in "iuf" or name in FREE_WORDS


def test_plain_xarray_shows_the_motion_as_data(tmp_path: Path) -> None:
    with xr.open_dataset(rotor_ida.save(a_run(), tmp_path / "run.nc")) as seen:
        assert {"x", "y", "vx", "vy"} <= set(seen.data_vars)
        assert "t" in seen.coords


@pytest.mark.filterwarnings("default")
def test_checker_finds_what_is_wrong(tmp_path: Path) -> None:
    path = tmp_path / "calendar.nc"
    run = a_run().rename(t="time").assign_attrs(history="2026-11-21T15:00:00Z made")
    run.to_netcdf(path, encoding={name: {"_FillValue": None} for name in run.variables})
    passed, report = what_the_checker_says(path)
    assert not passed
    assert "'time' should have standard_name='time'" in report
