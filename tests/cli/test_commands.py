"""Each command answers what the library answers, in words and in full precision."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida.errors import InstallationError
from tests.cli.conftest import Program

RUN = ("--omega", 1.2, "--zeta", 0.07, "--delta0", 2, "--start", 0, 0, 0, 0, "--duration", 60)
SWEEP = ("--omega", 1.2, 2, "--zeta", 0.5, "--delta0", 0, 0.5)


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    rotor = rotor_ida.Rotor(omega=1.2, zeta=0.07, delta0=2.0)
    return rotor_ida.simulate(rotor, start=(0, 0, 0, 0), duration=60.0)


def column(rows: list[dict[str, float]], name: str) -> list[float]:
    return [np.nan if row[name] is None else row[name] for row in rows]


def test_simulate_prints_json_in_full_precision(program: Program, run: xr.Dataset):
    answer = program("simulate", *RUN, "--json")
    assert (answer.status, answer.err) == (0, "")
    record = json.loads(answer.out)
    assert record["parameters"] == {
        "omega": 1.2, "zeta": 0.07, "delta0": 2.0, "start": [0, 0, 0, 0], "duration": 60.0
    }  # fmt: skip
    assert run.sizes["event"] > 3
    assert column(record["events"], "event_time") == run["event_time"].values.tolist()
    assert record["events"][0]["event_kind"] == "entry"
    assert record["starts_in_contact"] is False
    for name in ("entry_time", "exit_time", "peak_time", "peak_indentation", "peak_force"):
        np.testing.assert_array_equal(column(record["contacts"], name), run[name].values)
    assert record["method"]["rtol"] == 1e-10


def test_the_csv_of_a_run_has_its_numbers_to_the_last_bit(program: Program, run: xr.Dataset):
    answer = program("simulate", *RUN, "--csv", "run.csv")
    assert (answer.status, answer.err) == (0, "")
    assert "wrote run.event.csv" in answer.out
    with Path("run.event.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["event_time"]) for row in rows] == run["event_time"].values.tolist()
    again = program("simulate", *RUN, "--csv", "run.csv")
    assert (again.status, again.out) == (2, "")
    assert program("simulate", *RUN, "--csv", "run.csv", "--force").status == 0


def test_backward_whirls_are_those_of_the_library(program: Program):
    rotor = rotor_ida.Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    words = ("--omega", 0.63, "--zeta", 0.1, "--delta0", 1, "--friction", 0.2, "--disc-radius", 10)
    answer = program("whirl", *words, "--json")
    assert (answer.status, answer.err) == (0, "")
    record, found = json.loads(answer.out), rotor_ida.backward_whirl(rotor)
    assert record["birth_omega"] == found["birth_omega"].item()
    (rows,) = (each for each in record.values() if isinstance(each, list) and "kind" in each[0])
    assert column(rows, "amplitude") == found["amplitude"].values.tolist()
    assert [row["kind"] for row in rows] == ["slipping", "rolling"]
    assert program("whirl", *words[:-2]).status == 2


def test_simulate_prints_a_summary(program: Program, run: xr.Dataset):
    answer = program("simulate", *RUN)
    assert (answer.status, answer.err) == (0, "")
    assert f"Events: first 10 of {run.sizes['event']} (all with --json)" in answer.out
    assert f"{float(run['peak_force'].max()):.8g}" in answer.out
    assert f"{float(run['event_time'][0]):.8g}" in answer.out


def test_simulate_passes_every_option_on(program: Program):
    options = (
        *("--samples", 11, "--rtol", 1e-7, "--atol", 1e-9, "--method", "bdf"),
        *("--flight", "cvode", "--backend", "python", "--out", "run.nc"),
    )
    answer = program("simulate", *RUN, *options)
    assert answer.status == 0
    assert "wrote run.nc" in answer.out
    kept = rotor_ida.load("run.nc")
    assert kept.sizes["t"] == 11
    assert [kept.attrs[name] for name in ("rtol", "atol", "method", "flight", "backend")] == [
        1e-7, 1e-9, "bdf", "cvode", "python"
    ]  # fmt: skip


@pytest.mark.parametrize("name", ["motion", "motion.svg"])
def test_a_figure_is_named_by_either_file_or_without_ending(program: Program, name: str):
    assert program("simulate", *RUN, "--figure", name).status == 0
    assert {path.name for path in Path().iterdir()} == {"motion.png", "motion.svg"}


@pytest.mark.usefixtures("drawn")
def test_a_figure_is_a_pdf_where_its_name_is_one(program: Program):
    answer = program("simulate", *RUN, "--figure", "motion.pdf")
    assert "wrote motion.pdf" in answer.out
    assert [path.name for path in Path().iterdir()] == ["motion.pdf"]
    assert Path("motion.pdf").read_bytes().startswith(b"%PDF")


def test_commands_leave_no_figure_open(program: Program):
    from matplotlib import pyplot

    assert program("simulate", *RUN, "--figure", "motion.png", "--out", "run.nc").status == 0
    assert program("plot", "run.nc", "--kind", "orbit", "--figure", "orbit.pdf").status == 0
    assert pyplot.get_fignums() == []


def test_a_file_is_replaced_only_by_force(program: Program):
    Path("run.nc").write_text("mine")
    refused = program("simulate", *RUN, "--out", "run.nc")
    assert refused.status == 2
    assert Path("run.nc").read_text() == "mine"
    assert program("simulate", *RUN, "--out", "run.nc", "--force").status == 0
    assert "event_time" in rotor_ida.load("run.nc")


def test_response_lists_the_known_whirls(program: Program):
    words = ("response", "--omega", 1.7, "--zeta", 0.07, "--delta0", 0)
    record = json.loads(program(*words, "--json").out)
    exact = rotor_ida.synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).squeeze()
    for name in ("amplitude", "phase_lag", "growth_rate"):
        assert column(record["whirls"], name) == exact[name].values.tolist()
    assert [whirl["stability"] for whirl in record["whirls"]] == ["stable", "unstable", "stable"]
    assert [whirl["in_contact"] for whirl in record["whirls"]] == [True, True, True]
    answer = program(*words)
    assert "6.193211" in answer.out
    assert "unstable" in answer.out


def test_response_lists_folds_beside_the_whirls(program: Program):
    words = ("--zeta", 0.07, "--delta0", 0)
    alone = json.loads(program("folds", *words, "--json").out)
    beside = program("response", *words, "--folds", "--omega", 1.7, "--out", "both.nc", "--json")
    assert json.loads(beside.out)["folds"] == alone["folds"]
    assert {"amplitude", "fold_omega"} <= set(rotor_ida.load("both.nc").data_vars)


BOUNCING = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0}
DIAGRAM = {"omega": [1.2, 1.7], "zeta": 0.5, "delta0": 0.5, "workers": 1}
SMALL = {"mass": 4.0, "contact_stiffness": 1e9, "damping": 280.0, "eccentricity": 1e-6,
         "clearance": 2e-6, "speed": 1000.0}  # fmt: skip
# Lines, and the functions by whose names they are with the same arguments.
SAME: dict[str, tuple[Any, dict[str, Any]]] = {
    "folds --zeta 0.07 0.1 --delta0 0 0.5": (None, {"zeta": [0.07, 0.1], "delta0": [0.0, 0.5]}),
    "hopf-points --zeta 0.07 --delta0 0.5 --contact-damping 0.2 --friction 0 0.1": (
        None, {"zeta": [0.07], "delta0": [0.5], "contact_damping": 0.2, "friction": [0.0, 0.1]},
    ),
    "bifurcation-diagram --omega 1.2 1.7 --zeta 0.5 --delta0 0.5 --workers 1 --starts 2 --seed 3 "
    "--x=-2:2 --vy 1 --extrema-time 20 --rtol 1e-9": (None, DIAGRAM | {
        "starts": 2, "seed": 3, "x": (-2.0, 2.0), "vy": 1.0, "extrema_time": 20.0, "rtol": 1e-9,
    }),
    "bifurcation-diagram --omega 1.2 1.7 --zeta 0.5 --delta0 0.5 --workers 1 --start 0 0 0 0 "
    "--start 1 0 0 0 --direction up --rate 0.01 --method taylor": (None, DIAGRAM | {
        "starts": [(0, 0, 0, 0), (1, 0, 0, 0)], "direction": "up", "rate": 0.01, "method": "taylor",
    }),
    "bifurcation-diagram --omega 1.2 2 --zeta 0.07 --delta0 2 --start 0 0 0 0 --at revolution "
    "--revolutions 5 --phase 0.5": (None, BOUNCING | {
        "omega": [1.2, 2.0], "starts": [(0, 0, 0, 0)], "at": "revolution", "revolutions": 5,
        "phase": 0.5,
    }),
    "poincare-section --omega 2 --zeta 0.07 --delta0 2 --revolutions 6 --skip 3 --at entry "
    "--method taylor": (rotor_ida.Rotor(**BOUNCING), {
        "start": "rest", "revolutions": 6, "skip": 3, "at": "entry", "method": "taylor",
    }),
    "poincare-section --mass 4kg --contact-stiffness 1e9 --damping 280 --eccentricity 1um "
    "--clearance 2um --speed 1000 --revolutions 4 --at peak": (
        rotor_ida.DimensionalRotor(**SMALL), {"start": "rest", "revolutions": 4, "at": "peak"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("line", SAME)
def test_the_archive_is_what_the_library_returns_and_can_be_drawn_and_verified(
    program: Program, line: str
):
    answer = program(*line.split(), "--out", "found.nc", "--figure", "found", "--csv", "t.csv")
    assert (answer.status, answer.err) == (0, "")
    (rotor, given), name = SAME[line], line.split(maxsplit=1)[0].replace("-", "_")
    expected = getattr(rotor_ida, name)(*([] if rotor is None else [rotor]), **given)
    xr.testing.assert_equal(rotor_ida.load("found.nc"), expected)
    assert Path("found.png").exists()
    told, shown = (json.loads(program(*words, "--json").out)
                   for words in (line.split(), ("show", "found.nc")))  # fmt: skip
    rows = next(name for name in ("folds", "hopf_points", "responses", "crossings") if name in told)
    assert len(told[rows]) > 1
    assert shown[rows] == told[rows]
    if name in {"bifurcation_diagram", "poincare_section"}:
        assert program("verify", "found.nc").status == 0


def test_no_fold_is_said_in_words(program: Program):
    answer = program("folds", "--zeta", 0.5, "--delta0", 0)
    assert (answer.status, answer.out) == (0, "Folds: none\n")


def test_folds_of_a_machine_are_in_si_units(program: Program):
    """Those without dimensions, times the reference frequency sqrt(k sqrt(D)/m) of the machine."""
    machine = ("--mass", "4kg", "--contact-stiffness", "1e9", "--damping", "280",
               "--eccentricity", "1um", "--clearance", "0.5um")  # fmt: skip
    answer = program("folds", *machine, "--out", "si.nc", "--csv", "folds.csv")
    assert (answer.status, answer.err) == (0, "")
    exact = rotor_ida.folds(zeta=0.07, delta0=0.5)
    found = rotor_ida.load("si.nc")
    assert found.fold_omega.values == pytest.approx(exact.fold_omega.values, rel=1e-12)
    assert found.fold_amplitude.values == pytest.approx(1e-6 * exact.fold_amplitude.values)
    fastest = 30.0 / np.pi * 500.0 * exact.fold_omega.values.max()
    assert "fold speed [rpm]" in answer.out
    assert f"{fastest:.6g}" in answer.out
    assert len(Path("folds.csv").read_text().splitlines()) > exact.fold.size


@pytest.mark.parametrize("workers", [1, 2])
def test_sweep_answers_as_the_library_does(program: Program, archives: Path, workers: int):
    answer = program("sweep", *SWEEP, "--workers", workers, "--out", "sweep.nc", "--json")
    assert (answer.status, answer.err) == (0, "")
    record, expected = json.loads(answer.out), rotor_ida.load(archives / "sweep.nc")
    for name in ("amplitude", "phase_lag", "radius_min", "event_count"):
        np.testing.assert_array_equal(
            column(record["responses"], name), expected[name].values.ravel()
        )
    np.testing.assert_array_equal(rotor_ida.load("sweep.nc")["amplitude"], expected["amplitude"])


def test_sweep_takes_several_starts_and_a_direction(program: Program):
    words = (
        *("sweep", "--omega", "1.2:1.4:2", "--zeta", 0.5, "--delta0", 0, "--workers", 1),
        *("--start", 1, 0, 0, 0, "--start", -1, 0, 0, -2, "--direction", "both"),
    )
    record = json.loads(program(*words, "--json").out)
    assert [start["start_x"] for start in record["starts"]] == [1.0, -1.0]
    assert [start["start_vy"] for start in record["starts"]] == [0.0, -2.0]
    assert {point["direction"] for point in record["responses"]} == {"up", "down"}
    assert len(record["responses"]) == 8
    for given, kept in (((), False), (("--events",), True)):
        assert program(*words, *given, "--out", "events.nc", "--force").status == 0
        assert ("event_time" in rotor_ida.load("events.nc")) is kept


def test_a_sweep_with_failed_points_keeps_them_and_says_so(
    program: Program, archives: Path, monkeypatch: pytest.MonkeyPatch
):
    swept = rotor_ida.load(archives / "sweep.nc").copy(deep=True)
    swept["status"][1] = 1
    swept["message"] = swept["message"].astype("<U20")
    swept["message"][1] = "the solver gave up"
    monkeypatch.setattr("rotor_ida.sweep", lambda *_, **__: swept)
    answer = program("sweep", *SWEEP, "--out", "sweep.nc")
    assert answer.status == 1
    assert answer.err == "rotor-ida: 2 of 4 points failed; the first: the solver gave up\n"
    assert Path("sweep.nc").exists()


def test_compare_counts_by_clearance(program: Program, archives: Path):
    answer = program("compare", archives / "sweep.nc", "--out", "compared.nc", "--json")
    assert (answer.status, answer.err) == (0, "")
    record = json.loads(answer.out)
    assert [row["on_whirl"] for row in record["summary"]] == [2, 2]
    expected = rotor_ida.load(archives / "compared.nc")
    assert column(record["points"], "digits") == expected["digits"].values.ravel().tolist()
    np.testing.assert_array_equal(rotor_ida.load("compared.nc")["digits"], expected["digits"])


@pytest.mark.parametrize("kind", ["sweep", "basin", "compared"])
def test_show_tells_every_kind(program: Program, archives: Path, kind: str):
    path = archives / f"{kind}.nc"
    record = json.loads(program("show", path, "--json").out)
    assert record["kind"] == {"compared": "comparison"}.get(kind, kind)
    assert record["dimensions"] == dict(rotor_ida.load(path).sizes)
    answer = program("show", path)
    assert (answer.status, answer.err) == (0, "")
    assert record["kind"] in answer.out


def test_show_repeats_what_simulate_said(program: Program):
    said = json.loads(program("simulate", *RUN, "--out", "run.nc", "--json").out)
    shown = json.loads(program("show", "run.nc", "--json").out)
    assert {name: shown[name] for name in ("events", "contacts", "parameters")} == {
        name: said[name] for name in ("events", "contacts", "parameters")
    }
    assert shown["versions"]["sundials"]


def test_doctor_finds_this_installation_well(program: Program):
    answer = program("doctor", "--json")
    assert (answer.status, answer.err) == (0, "")
    record = json.loads(answer.out)
    assert record["backends"] == ["python", "compiled"]
    assert record["executors"] == ["serial", "threads", "processes", "dask"]
    assert all(record["versions"].values())
    assert {check["result"] for check in record["checks"]} == {"ok"}
    core = record["core"]
    assert core["level"] in {"baseline", "v3", "v4"}
    assert "-ffp-contract=off" in core["flags"]


def test_doctor_says_what_mends_the_core(program: Program, monkeypatch: pytest.MonkeyPatch):
    def broken() -> None:
        raise InstallationError("the compiled core is missing; run: pip install -e .")

    monkeypatch.setattr("rotor_ida.core.library.build_info", broken)
    answer = program("doctor")
    assert answer.status == 1
    assert "run: pip install -e ." in answer.out


def test_doctor_finds_a_solver_that_is_wrong(program: Program, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("rotor_ida.closed_forms.planar_period", lambda _depth: 6.0)
    answer = program("doctor")
    assert answer.status == 1
    assert "event times are wrong by" in answer.out
    assert "Usable backends: none" in answer.out
    assert answer.err == "rotor-ida: 5 of 7 checks failed\n"


def test_doctor_passes_without_scikit_sundae(program: Program, monkeypatch: pytest.MonkeyPatch):
    """As on Linux on ARM, for which it has no wheel: Taylor series need none."""
    reason = "scikit-sundae is not installed"
    monkeypatch.setattr("rotor_ida.core.sundials.why_not", lambda: reason)
    answer = program("doctor", "--json")
    assert (answer.status, answer.err) == (0, "")
    checks = json.loads(answer.out)["checks"]
    absent = [check for check in checks if check["result"] == "absent"]
    assert [check["seen"] for check in absent] == [reason, reason]
    assert "compiled: free vibration, Taylor series" in [
        check["check"] for check in checks if check["result"] == "ok"
    ]


def test_doctor_does_without_dask(program: Program, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("rotor_ida.parallel.executors.importlib.util.find_spec", lambda _name: None)
    answer = program("doctor")
    assert (answer.status, answer.err) == (0, "")
    assert "Usable executors: serial, threads, processes\n" in answer.out


def test_reproduce_passes_its_options_on(program: Program, monkeypatch: pytest.MonkeyPatch):
    calls: list[object] = []

    def reproduce(folder: object, **options: object) -> int:
        calls.append((folder, options))
        print("going on")
        return 1

    monkeypatch.setattr("rotor_ida.paper.reproduction.reproduce", reproduce)
    answer = program("reproduce", "--out", "x", "--quick", "--only", "a", "b", "--workers", 3)
    assert (answer.status, answer.out, answer.err) == (1, "", "going on\n")
    options = {"quick": True, "studies": False, "only": ["a", "b"], "workers": 3, "force": False}
    assert calls == [(Path("x"), options)]


def test_a_long_table_is_cut_and_says_so(program: Program):
    words = ("response", "--omega", "0.5:1:1001", "--zeta", 0.5, "--delta0", 3)
    told = " ".join(program(*words).out.split())  # the title is as wide as the table
    assert "first 1000 of 1001 (all with --json)" in told
    assert len(json.loads(program(*words, "--json").out)["whirls"]) == 1001


MACHINE = ("--mass", 4, "--contact-stiffness", 1e9, "--damping", 280, "--eccentricity", 1e-6,
           "--clearance", 2e-6, "--speed", 1000)  # fmt: skip
NEAR = ("--x=-15e-6:15e-6", "--y=-15e-6:15e-6", "--starts", 100)


def test_touchdown_prints_json_in_full_precision(program: Program):
    answer = program("touchdown", *MACHINE, *NEAR, "--shocks", 256, "--json")
    assert (answer.status, answer.err) == (0, "")
    record = json.loads(answer.out)
    machine = rotor_ida.DimensionalRotor(
        mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6,
        speed=1000.0,
    )  # fmt: skip
    ranges = {"x": (-15e-6, 15e-6), "y": (-15e-6, 15e-6)}
    report = rotor_ida.touchdown_report(machine, **ranges, starts=100, shocks=256)
    assert column(record["attractors"], "largest_force") == report.largest_force.values.tolist()
    assert record["shocks"] == 256
    for each in record["smallest_shocks"]:
        size = float(report.velocity_shock[each["from"], each["to"]])
        assert each["velocity_shock"] == size
    assert record["omega"] == machine.rotor().omega


def test_touchdown_is_a_table_with_units(program: Program):
    answer = program("touchdown", *MACHINE, *NEAR, "--shocks", 256)
    assert (answer.status, answer.err) == (0, "")
    for words in ("largest force [N]", "velocity shock [mm/s]", "speed from [rpm]",
                  "damping to [N s/m]", "clearance to [um]", "basin entropy"):  # fmt: skip
        assert words in answer.out
    touches = 2.0 / np.hypot(2.0, 2.0 * 0.07)  # of an eccentricity of 1 um
    assert re.search(rf"clearance from \[um\]\s+0 contact_free +{touches:.5g} touch", answer.out)
    assert re.search(r"agreement +1\b", answer.out)


def test_an_unresolved_response_is_printed_with_its_reason(program: Program):
    """Without damping nothing settles."""
    start = ("--start", 3, 0, 0, 0)
    answer = program("sweep", "--omega", 2, "--zeta", 0, "--delta0", 0.5, *start)
    assert answer.status == 0
    said = r"^Unresolved: followed for \d+ revolutions: without damping nothing settles\.$"
    assert re.search(said, answer.out, re.MULTILINE)
