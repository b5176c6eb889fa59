"""Machines on the command line: their files, and results in SI units."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rotor_ida
from rotor_ida import DimensionalRotor
from rotor_ida.results.si_units import dimensionless
from tests.cli.conftest import Program

# The pump of the tutorial: 12 kg, 4e6 N/m, 150 um, G6.3 at 3,600 rpm, a linear ring of 1e8 N/m.
SHEET = [
    *("--mass", "12kg", "--shaft-stiffness", "4e6N/m", "--damping-ratio", "3%"),
    *("--clearance", "150um", "--balance-grade", "G6.3", "--balance-speed", "3600rpm"),
    *("--speed", "3600rpm", "--friction", "0.12", "--disc-radius", "60mm"),
    *("--contact-stiffness", "1e8N/m"),
]
# A rotor of the paper's numbers, as a machine: omega 2, zeta 0.07, delta0 2.
SMALL = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6,
                         clearance=2e-6, speed=1000.0)  # fmt: skip


@pytest.fixture
def pump(program: Program) -> str:
    assert program("machine", *SHEET, "--out", "pump.toml").status == 0
    return "pump.toml"


@pytest.fixture
def small() -> str:
    rotor_ida.save_machine(SMALL, "small.toml")
    return "small.toml"


def test_a_data_sheet_becomes_a_file(program: Program):
    """By hand: 60/(2 pi) sqrt(4e6/12) rpm, 2 0.03 sqrt(4e6 12) N s/m, and 6.3 mm/s at 3600 rpm."""
    answer = program("machine", *SHEET, "--out", "pump.toml", "--json")
    assert (answer.status, answer.err) == (0, "")
    told = json.loads(answer.out)
    assert told["warnings"] == []
    facts = told["facts"]
    assert facts["critical speed [rpm]"] == pytest.approx(
        30.0 / math.pi * math.sqrt(4e6 / 12.0), rel=1e-5
    )
    assert facts["damping ratio at the critical speed"] == 0.03
    eccentricity = 6.3e-3 / (3600.0 * math.pi / 30.0)
    assert facts["eccentricity [um]"] == pytest.approx(1e6 * eccentricity, rel=1e-5)
    assert facts["delta0"] == pytest.approx(1.5e-4 / eccentricity, rel=1e-5)
    machine = rotor_ida.load_machine("pump.toml")
    assert machine.damping == pytest.approx(0.06 * math.sqrt(4e6 * 12.0), rel=1e-14)
    assert (machine.clearance, machine.contact_exponent) == (1.5e-4, 1.0)
    rotor = machine.rotor()
    assert facts["zeta"] == pytest.approx(rotor.zeta, rel=1e-5)
    printed = program("machine", *SHEET).out
    assert " ".join(Path("pump.toml").read_text().split()) in " ".join(printed.split())


@pytest.mark.parametrize("clearance", ["60um", "20um"], ids=["hangs", "lies on the stator"])
def test_a_machine_with_a_weight_starts_at_rest_where_it_is_held(program: Program, clearance: str):
    """Sag of the frictionless pump: 29.42 um on its shaft, or with the ring's stiffness beside."""
    sheet = [word for word in SHEET if word not in {"--friction", "0.12", "--disc-radius", "60mm"}]
    sheet = [clearance if word == "150um" else word for word in sheet]
    assert program("machine", *sheet, "--load", "weight", "--out", "heavy.toml").status == 0
    weight = 12.0 * 9.80665
    sag = weight / 4e6
    if clearance == "20um":
        sag = 20e-6 + (weight - 4e6 * 20e-6) / (4e6 + 1e8)
    of_run = ("--machine", "heavy.toml", "--out", "run.nc", "--force")
    for words in (("simulate", "--duration", "10ms"), ("run-up", "--to", "600rpm", "--in", "1s")):
        answer = program(*words, *of_run)
        assert (answer.status, answer.err) == (0, "")
        run = rotor_ida.load("run.nc")
        assert (run.x[0], run.vx[0], run.vy[0]) == (0.0, 0.0, 0.0)
        assert run.y[0].item() == pytest.approx(-sag, rel=1e-12)
    # below a seventh of the critical speed it hardly leaves that place
    assert np.hypot(run.x, run.y + sag).max() < 1e-6
    answer = program("run-ups", "--machine", "heavy.toml", "--speed", 1, "--to", 60, "--rate", 60,
                     "--workers", 1, "--out", "many.nc")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    assert rotor_ida.load("many.nc").attrs["start_words"] == "rest"


def test_an_exported_page_takes_speeds_in_rpm(
    program: Program, small: str, monkeypatch: pytest.MonkeyPatch
):
    asked: list[Any] = []
    monkeypatch.setattr(
        "rotor_ida.explorer.files.recording", lambda *_, **given: asked.append(given)
    )
    monkeypatch.setattr("rotor_ida.explorer.files.finished", lambda *_: "page")
    for words in (("--machine", small), (small,)):
        answer = program("explore", *words, "--export", "page.html", "--force",
                         "--speeds", "9000rpm:9600rpm:2")  # fmt: skip
        assert answer.status == 0
    assert [each["speeds"] for each in asked] == [pytest.approx([300 * math.pi, 320 * math.pi])] * 2


def test_a_phase_is_read_in_degrees_without_dimensions_too(program: Program):
    given = ("run-ups", "--omega", 0.1, "--zeta", 0.1, "--delta0", 1, "--to", 0.5, "--rate", 0.1)
    for name, words in (("deg", ("90deg", "180deg")), ("rad", (math.pi / 2, math.pi))):
        answer = program(*given, "--phase", *words, "--out", f"{name}.nc")
        assert (answer.status, answer.err) == (0, "")
    both = [rotor_ida.load(f"{name}.nc") for name in ("deg", "rad")]
    np.testing.assert_array_equal(both[0]["phase"], both[1]["phase"])


def test_run_ups_of_a_machine_begin_at_standstill_as_a_run_up_does(program: Program):
    given = ("--machine", "pump.toml", "--to", "300rpm", "--rate", "1200rpm/s")
    assert program("machine", *SHEET, "--out", "pump.toml").status == 0
    for command in ("run-up", "run-ups"):
        assert program(command, *given, "--out", f"{command}.nc").status == 0
    up, ups = (rotor_ida.load(f"{each}.nc") for each in ("run-up", "run-ups"))
    assert float(up["speed"][0]) == 0.0
    assert ups["omega"].item() == 0.0
    assert program("run-ups", *given, "--from", "10rpm", "--out", "on.nc").status == 0
    assert rotor_ida.load("on.nc")["omega"].item() > 0.0
    told = program("run-ups", "--help").out
    assert "0 with --machine" in " ".join(told.replace("│", " ").split())


def test_a_data_sheet_that_is_implausible_is_warned_of(program: Program):
    answer = program("machine", *SHEET, "--clearance", "10um")
    assert (answer.status, answer.out) == (2, "")  # once is enough
    sheet = ["10um" if word == "150um" else word for word in SHEET]
    answer = program("machine", *sheet, "--load", "weight")
    assert answer.status == 0
    assert "warning: clearance 10 um is below the eccentricity 16.7 um" in answer.out
    assert "warning: load bends the shaft by 29.4 um, more than the clearance" in answer.out


def test_a_data_sheet_in_inches_is_told_in_inches(program: Program):
    """25.4 um are 1 mil, 0.45359237 kg a lb; a balance grade is in mm/s by its definition."""
    sheet = ("--mass", "2lb", "--shaft-stiffness", "2e4lbf/in", "--damping-ratio", "3%",
             "--clearance", "6mil", "--eccentricity", "1mil", "--speed", "100rad/s",
             "--contact-stiffness", "5e5lbf/in", "--inch")  # fmt: skip
    answer = program("machine", *sheet)
    rows = {name.strip(): told.split() for name, _, told in
            (line.partition("  ") for line in answer.out.splitlines())}  # fmt: skip
    assert rows["clearance"] == ["6", "mil"]
    assert rows["eccentricity"] == ["1", "mil"]
    assert rows["unbalance"] == ["0.032", "oz", "in"]  # 2 lb by a thousandth of an inch
    assert rows["balance grade at the running speed"] == ["2.54", "mm/s"]


def test_a_short_data_sheet_names_the_options_that_it_lacks(program: Program):
    answer = program("machine", "--mass", "12kg")
    assert answer.err.strip() == (
        "rotor-ida: machine must also give --contact-stiffness, --clearance, --speed, --damping or "
        "--damping-ratio, --eccentricity or --unbalance or --balance-grade"
    )


def test_options_override_the_file(program: Program, pump: str):
    line = ("simulate", "--machine", pump, "--duration", "10ms", "--json")
    told = json.loads(program(*line).out)
    other = json.loads(program(*line, "--damping", "100Ns/m", "--speed", "3000rpm").out)
    assert told["machine_damping"] == pytest.approx(415.692, rel=1e-5)
    assert other["machine_damping"] == 100.0
    assert other["parameters"]["omega"] / told["parameters"]["omega"] == pytest.approx(3000 / 3600)
    refused = program(*line, "--omega", "1")
    assert refused.err == (
        "rotor-ida: omega must be left out with a machine: it has no dimension\n"
    )


def test_a_run_up_of_a_file_begins_at_rest_and_tells_its_sentence_first(
    program: Program, pump: str
):
    answer = program("run-up", "--machine", pump, "--to", "6000rpm", "--in", "20s",
                     "--rtol", "1e-8", "--out", "pump.nc")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    found = rotor_ida.summary(rotor_ida.load("pump.nc"), running_speed=3600.0 * math.pi / 30.0)
    sentence, printed = found.attrs["sentence"], " ".join(answer.out.split())
    assert printed.startswith(sentence)
    first = float(rotor_ida.load("pump.nc").entry_time[0])
    margin = f"5,287 rpm, 47 % above the running speed, after {first:.3g} s, and presses up"
    assert sentence.startswith(f"Rub: it first touches the stator at {margin}")
    assert "speed 0 to 6000 rpm " in printed
    (start,) = (line for line in answer.out.splitlines() if line.startswith("start "))
    assert start.endswith("m, m/s")
    assert found.largest_force.attrs["units"] == "N"
    at_speed = program("run-up", "--machine", pump, "--from", "3000rpm", "--to", "3600rpm",
                       "--ramp-time", "1s", "--json")  # fmt: skip
    told = json.loads(at_speed.out)
    assert told["summary"]["sentence"].startswith("No rub: closest to the stator at 3,")
    assert told["rate"] == pytest.approx(600.0 * math.pi / 30.0, rel=1e-12)


COMMANDS = {
    "run": "simulate --duration 40ms --start 3um 0 0 0",
    "whirls": "response --speed 500:1500:3",
    "folds": "folds",
    "hopf points": "hopf-points --friction 0.1 --disc-radius 60mm",
    "diagram": "bifurcation-diagram --speed 800 1200 --starts 2 --x=-5um:5um --extrema-time 20ms "
    "--workers 1",
    "sweep": "sweep --speed 400rad/s 1000rad/s --clearance 1.5um 2um --workers 1",
    "run_ups": "run-ups --speed 150 --to 800 --rate 2e4rad/s2 --shaft-stiffness 1e6N/m --workers 1",
    "basin": "basin --x=-3um:3um:4 --y=-3um:3um:4 --workers 1",
    "fractions": "fractions --x=-3um:3um --y 0 --starts 30 --workers 1",
    "atlas": "atlas --x=-3um:3um --starts 20 --workers 1",
    "touchdown": "touchdown --x=-3um:3um --starts 40 --shocks 0",
    "cycle": "cycle",
}


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_takes_a_machine_and_its_archive_is_of_use(
    program: Program, small: str, name: str
):
    """What it computes is what the dimensionless rotor does, and stays so in the archive."""
    line = (*COMMANDS[name].split(), "--machine", small, "--out", "si.nc")
    answer = program(
        *line, *([] if name in {"fractions", "touchdown", "atlas"} else ["--figure", "si"])
    )
    assert (answer.status, answer.err) == (0, "")
    archived = rotor_ida.load("si.nc")
    assert archived.attrs["machine_mass"] == 4.0
    assert archived.attrs["length_scale"] == SMALL.length_scale
    shown = program("show", "si.nc")
    assert (shown.status, shown.err) == (0, "")
    told = {" ".join(line.split()) for line in shown.out.splitlines()}
    assert {"length scale 1 um", "machine mass 4 kg"} <= told
    assert any(re.fullmatch(r"machine contact stiffness \S+ N/m\^1.5", each) for each in told)
    assert " units " not in shown.out
    if name == "run":
        assert json.loads(program("verify", "si.nc", "--json").out)["agrees"] is True


def test_the_same_of_options_as_of_the_file(program: Program, small: str):
    given = [
        *("--mass", "4000g", "--contact-stiffness", "1e9N/m^1.5", "--damping", "280"),
        *("--eccentricity", "1um", "--clearance", "2um", "--speed", "1000rad/s"),
    ]
    line = ("simulate", "--duration", "20ms", "--json")
    assert program(*line, *given).out == program(*line, "--machine", small).out


def test_a_sweep_in_si_units_is_compared(program: Program, small: str):
    sweep = ("sweep", "--machine", small, "--speed", "600", "1000", "--workers", "1")
    assert program(*sweep, "--out", "sweep.nc").status == 0
    answer = program("compare", "sweep.nc", "--out", "compared.nc")
    assert (answer.status, answer.err) == (0, "")
    compared, swept = rotor_ida.load("compared.nc"), rotor_ida.load("sweep.nc")
    again = rotor_ida.compare(dimensionless(swept))
    assert compared.attrs["machine_mass"] == 4.0
    assert compared.exact_amplitude.attrs["units"] == "m"
    assert compared.exact_amplitude.values == pytest.approx(
        1e-6 * again.exact_amplitude.values, nan_ok=True
    )


def test_a_study_of_a_machine_goes_on_in_si_units(program: Program, small: str):
    line = ("basin", "--machine", small, "--x=-3um:3um:3", "--y=-3um:3um:3", "--study", "study")
    assert program(*line, "--workers", "1").status == 0
    first = rotor_ida.load("study/result.nc")
    Path("study/result.nc").unlink()
    assert program("resume", "study", "--workers", "1").status == 0
    assert rotor_ida.load("study/result.nc").x.identical(first.x)
    assert first.x.attrs["units"] == "m"
    refused = program(*line, "--mass", "5")
    assert refused.err == "rotor-ida: study must be of this machine, got 'study' of another\n"


def test_a_branch_is_followed_over_the_speed_of_a_machine(program: Program, small: str):
    assert program("cycle", "--machine", small, "--out", "cycle.nc").status == 0
    answer = program("continue", "--from", "cycle.nc", "--parameter", "speed", "--limits",
                     "950rad/s", "10000rpm", "--out", "branch.nc", "--figure", "b")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    branch = rotor_ida.load("branch.nc")
    speeds = branch.omega.values * SMALL.reference_frequency
    assert (speeds.min(), speeds.max()) == pytest.approx((950.0, 1e4 * math.pi / 30.0), rel=1e-9)
    assert branch.radius_max.attrs["units"] == "m"
    wrong = program("continue", "--from", "cycle.nc", "--parameter", "speed", "--limits", "950um",
                    "1mm")  # fmt: skip
    assert wrong.err == "rotor-ida: the unit of speed must be rad/s, rpm or Hz, got '950um'\n"


def test_the_explorer_opens_an_archive_in_si_units_as_its_machine(
    program: Program, small: str, monkeypatch: pytest.MonkeyPatch
):
    opened: list[dict[str, Any]] = []
    monkeypatch.setattr(
        "rotor_ida.explorer.explore.explore", lambda state, **_: opened.append(state)
    )
    run = ("simulate", "--machine", small, "--duration", "20ms", "--start", "3um", "0", "0", "0")
    assert program(*run, "--out", "run.nc").status == 0
    assert program("explore", "--file", "run.nc").status == 0
    assert program("explore", "--machine", small).status == 0
    for state in opened:
        assert state["mass"] == 4.0
        assert state["clearance"] == 2e-6
    assert opened[0]["x"] == pytest.approx(3.0)


@pytest.mark.usefixtures("drawn")
def test_sentences_and_figures_are_in_inches_too(program: Program, pump: str, tmp_path: Path):
    """A clearance of 150 um is 5.906 mil, and no length or force stays metric."""
    line = ("run-up", "--machine", pump, "--to", "6000rpm", "--rate", "3000rpm/s")
    figure = tmp_path / "run_up.svg"
    more = ("--inch", "--figure", str(figure))
    metric, inch = (" ".join(program(*line, *each).out.split()) for each in ((), more))
    words = set(re.findall(r"<!-- (.*?) -->", figure.read_text()))
    assert {"radius $|Z|$ [mil]", "normal force $N$ [lbf]"} <= words
    assert any("clearance $5.906$ mil" in each for each in words)
    assert not [each for each in words if re.search(r"\b(µm|mm|kN|N)\b", each.replace("$N$", ""))]
    assert "clearance 150 um" in metric
    assert "clearance 5.906 mil" in inch
    whirls = ("response", "--machine", pump, "--speed", "4000rpm", "--json")
    assert program(*whirls).out == program(*whirls, "--inch").out
    # a balance grade is in mm/s by its definition
    assert not re.search(r"\d (um|mm(?!/s)|kg|k?N|N/m|N s/m)\b", inch)


def test_a_speed_of_a_data_sheet_without_a_unit_is_asked_about(program: Program):
    sheet = ["30000" if word == "3600rpm" else word for word in SHEET]
    said = program("machine", *sheet).out
    for name in ("--speed", "--balance-speed"):
        assert f"warning: {name} is 286,479 rpm, " in said
        assert "write 30000rpm if you meant that" in said
    assert "if you meant that" not in program("machine", *SHEET).out
