"""Rotors on the command line: without dimensions or in SI units, one or several."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import rotor_ida
from rotor_ida.cli.rotor_options import RotorOptions, RotorsOptions
from rotor_ida.model.parameters import FRICTIONLESS
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from tests.cli.conftest import Program, is_refused

ROTOR = {"omega": 1.2, "zeta": 0.07, "delta0": 0.5}
BEYOND = {
    "shaft_stiffness": 0.25, "contact_exponent": 1.0, "contact_damping": 0.5, "load": 0.125,
}  # fmt: skip
IN_SI_UNITS = {
    "mass": 4.0, "contact_stiffness": 1e6, "damping": 280.0, "eccentricity": 1e-6,
    "clearance": 2e-6, "speed": 600.0,
}  # fmt: skip
BEYOND_IN_SI = {
    "shaft_stiffness": 2.5e5, "contact_exponent": 1.0, "contact_damping": 1e3, "load": 39.2266,
}  # fmt: skip


def words(**given: float) -> list[str]:
    """Return parameters as the options of their names."""
    pairs = ((f"--{name.replace('_', '-')}", repr(value)) for name, value in given.items())
    return [word for pair in pairs for word in pair]


SIMULATE = ["simulate", *words(**ROTOR), "--duration", "10"]


def test_simulate_takes_the_whole_rotor_and_says_so(program: Program):
    answer = program(*SIMULATE, *words(**BEYOND), "--out", "run.nc", "--json")
    assert (answer.status, answer.err) == (0, "")
    told = json.loads(answer.out)["parameters"]
    sag = BEYOND["load"] / BEYOND["shaft_stiffness"]
    assert told == {**ROTOR, **BEYOND, "start": [0, -sag, 0, 0], "duration": 10.0}
    run = rotor_ida.load("run.nc")
    assert {name: run[name].item() for name in FRICTIONLESS} == BEYOND


def test_an_archive_of_the_whole_rotor_is_shown_and_verifies(program: Program):
    made = program(*SIMULATE, *words(**BEYOND), "--out", "run.nc", "--figure", "run")
    answer = program("show", "run.nc")
    for each in (made, answer):
        assert (each.status, each.err) == (0, "")
        for name, value in BEYOND.items():
            assert re.search(rf"{name.replace('_', '.')} +{value:g}\b", each.out), name
    assert json.loads(program("show", "run.nc", "--json").out)["parameters"]["load"] == 0.125
    answer = program("verify", "run.nc", "--json")
    assert (answer.status, answer.err) == (0, "")
    assert json.loads(answer.out)["agrees"] is True


def test_the_defaults_are_not_told(program: Program):
    plain = program(*SIMULATE, "--json")
    assert program(*SIMULATE, *words(**FRICTIONLESS), "--json").out == plain.out
    assert not set(FRICTIONLESS) & set(json.loads(plain.out)["parameters"])


def test_a_rotor_is_given_in_full_in_one_of_two_ways():
    assert RotorOptions(**ROTOR).chosen() == Rotor(**ROTOR)
    assert RotorOptions(**IN_SI_UNITS).chosen() == DimensionalRotor(**IN_SI_UNITS)
    assert RotorOptions(**ROTOR, **BEYOND).chosen() == Rotor(**ROTOR, **BEYOND)
    rubbing = {"friction": 0.2, "disc_radius": 1e-5}
    assert RotorOptions(**ROTOR, **rubbing).chosen() == Rotor(**ROTOR, **rubbing)
    assert RotorOptions(**IN_SI_UNITS, **rubbing).chosen() == DimensionalRotor(
        **IN_SI_UNITS, **rubbing
    )
    whole = IN_SI_UNITS | BEYOND_IN_SI
    assert RotorOptions(**whole).chosen() == DimensionalRotor(**whole)


MISTAKES = [
    ({**ROTOR, "mass": 4.0, "load": 1.0}, "without dimensions or in SI units, got omega and mass"),
    (BEYOND, "--omega, --zeta and --delta0 must be given, or a machine in SI units"),
    (
        {**IN_SI_UNITS, **BEYOND_IN_SI, "delta0": 0.5},
        "without dimensions or in SI units, got delta0 and mass",
    ),
    ({**IN_SI_UNITS, "contact_exponent": 2.0}, "--contact-exponent must be 1.5 or 1, got 2.0"),
    ({**IN_SI_UNITS, "load": -1.0}, "load must be zero or positive, got -1 N"),
    ({**ROTOR, "delta0": 0.0, "contact_damping": 1.0}, "--contact-damping must be 0 without"),
    ({**ROTOR, "friction": 0.1}, "--disc-radius must be given with --friction"),
]
MISTAKES_OF_ONE = [
    ({"contact_exponent": 2.0}, "--contact-exponent must be 1.5 or 1, got 2.0"),
    ({"load": -1.0}, "load must be zero or positive, got -1.0"),
    ({"shaft_stiffness": float("nan")}, "shaft-stiffness must be a finite real number, got"),
    ({"contact_damping": 0.5, "delta0": 0.0}, "--contact-damping must be 0 without clearance"),
]


@pytest.mark.parametrize(
    ("command", "given", "message"),
    [("touchdown", *mistake) for mistake in MISTAKES]
    + [("simulate --duration 10", ROTOR | given, message) for given, message in MISTAKES_OF_ONE],
    ids=lambda value: str(value)[:40],
)
def test_parts_of_one_and_mixtures_of_both_get_one_line(
    program: Program, command: str, given: dict[str, float], message: str
):
    is_refused(program, f"{command} {' '.join(words(**given))}", message)


IN_SI = " ".join(words(**IN_SI_UNITS))
RUN_UP = [*IN_SI.partition(" --speed")[0].split(), "--rtol", "1e-6", "--samples", "2", "--json"]


@pytest.mark.parametrize(
    ("given", "first", "last", "time"),
    [("--speed 6000rpm --to 9000rpm --rate 300000rpm/s", 200.0, 300.0, 0.01),
     ("--speed 200Hz --to 9000rpm --rate -2000Hz/s", 400.0, 300.0, 0.025),
     ("--speed 600 --speeds 0:100Hz 0.01:9000rpm --duration 0.02", 200.0, 300.0, 0.02)],
)  # fmt: skip
def test_a_run_up_takes_and_tells_speeds_as_engineers_do(
    program: Program, given: str, first: float, last: float, time: float
):
    """Speeds in units of pi rad/s by hand: 30 rpm, or half a Hz, are 1."""
    answer = program("run-up", *RUN_UP, *given.split())
    told = json.loads(answer.out)
    assert told["parameters"]["duration"] == pytest.approx(time, rel=1e-9)
    printed = program("run-up", *RUN_UP[:-1], *given.split()).out
    assert f"speed {first * 30:.6g} to {last * 30:.6g} rpm" in " ".join(printed.split())


def test_a_sweep_takes_numbers_and_axes_of_it(program: Program):
    line = (
        "sweep --omega 0.5 2.5 --zeta 0.2 --delta0 1 --direction both --method taylor "
        "--shaft-stiffness 0.25 --contact-exponent 1 --load 0 0.3 --out sweep.nc --figure sweep"
    )
    answer = program(*line.split(), "--json")
    assert (answer.status, answer.err) == (0, "")
    told = json.loads(answer.out)["responses"]
    assert [row["load"] for row in told] == [0.0, 0.0, 0.3, 0.3] * 2
    assert {row["shaft_stiffness"] for row in told} == {0.25}
    found = rotor_ida.load("sweep.nc")
    assert found.amplitude.dims == ("omega", "zeta", "delta0", "load", "start", "direction")
    assert (found.contact_exponent.item(), found.shaft_stiffness.item()) == (1.0, 0.25)
    assert "contact_damping" not in found.variables


def test_whirls_and_folds_of_machines_are_listed(program: Program):
    line = "response --omega 1.7 --zeta 0.07 --delta0 0.5 --shaft-stiffness 0 0.25 --folds --json"
    answer = program(*line.split())
    assert (answer.status, answer.err) == (0, "")
    exact = rotor_ida.synchronous_response(
        omega=1.7, zeta=0.07, delta0=0.5, shaft_stiffness=[0.0, 0.25]
    )
    told = [row["amplitude"] for row in json.loads(answer.out)["whirls"]]
    there = exact.amplitude.values[exact.amplitude.notnull().values]
    assert sorted(told) == sorted(there.tolist())
    loaded = program(*line.replace("--folds --json", "--load 0.1").split())
    assert loaded.status == 0
    said = " ".join(loaded.out.split())
    assert said.startswith(
        "Whirls in contact have no closed form: under a load no whirl in contact is synchronous"
    )
    assert "and limit_cycle computes the exact cycles beyond it" in said


def test_under_a_load_a_cycle_with_a_period_of_its_own_is_not_followed(
    program: Program, archives: Path
):
    cycle = rotor_ida.load(archives / "cycle.nc").assign_coords(load=0.125)
    rotor_ida.save(cycle, "cycle.nc")
    answer = program("continue", "--from", "cycle.nc", "--limits", "1.5", "2.5")
    assert (answer.status, answer.out) == (2, "")
    assert answer.err.startswith("rotor-ida: period must be a whole number of revolutions under")


def test_a_sweep_that_is_given_nothing_of_it_is_of_the_papers_rotor():
    papers = {"omega": [1.2, 1.3], "zeta": [0.07], "delta0": [0.5]}
    assert RotorsOptions(**papers).asked() == (None, papers)
    _, given = RotorsOptions(**papers, load=[0.1], shaft_stiffness=[0.0, 0.5]).asked()
    assert given == {**papers, "load": 0.1, "shaft_stiffness": [0.0, 0.5]}


def test_what_starts_end_on_with_friction(program: Program):
    """A knock backwards, at the speed of the rim, rolls on in dry whip; an atlas verifies."""
    rubbing = "--omega 0.63 --zeta 0.1 --delta0 1 --friction 0.2 --disc-radius 10 "
    over = "--x 0:5:2 --y 0 --vx 0 --vy=-6.3:0:2 --json"
    answer = program(*("basin " + rubbing + over).split())
    assert (answer.status, answer.err) == (0, "")
    assert "rolling" in {each["kind"] for each in json.loads(answer.out)["attractors"]}
    box = "--x=-6:6 --y=-6:6 --vx=-6:6 --vy=-6:6 --starts 24 --json "
    answer = program(*("touchdown " + rubbing + box + "--shocks 0").split())
    assert (answer.status, answer.err) == (0, "")
    rows = {each["kind"]: each for each in json.loads(answer.out)["attractors"]}
    assert rows["synchronous"]["rolling_fraction"] == 0.0 < rows["rolling"]["rolling_fraction"]
    several = rubbing.replace("--friction 0.2", "--friction 0.1 0.2")
    answer = program(*("atlas " + several + box + "--figure atlas --out atlas.nc").split())
    assert (answer.status, answer.err) == (0, "")
    told = json.loads(answer.out)
    assert told["parameters"]["friction"] == [0.1, 0.2]
    (whip,) = (row for row in told["attractors"] if row["kind"] == "rolling")
    assert whip["friction"] == "0.2 to 0.2"
    assert program("verify", "atlas.nc").status == 0
