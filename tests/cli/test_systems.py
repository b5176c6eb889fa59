"""Rotor systems on the command line: their files, the answer, archives that verify."""

from __future__ import annotations

import json
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida import Contact, Race, RotorSystem, Stator, Unbalance
from rotor_ida.cli.describe_whirls import show_campbell
from rotor_ida.results.sheets import Sheet
from tests.cli.conftest import Program, is_refused

RPM = np.pi / 30.0

# Two discs on a shaft: the seal touches a stator on a mount, the journal rolls in a bearing.
SYSTEM = """
speed = "4300 rpm"
gravity = [0, "-9.81 m/s2"]

[system]
file = "rotor.npz"
nodes = { disc = [0, 1], seal = [2, 3] }

[[contacts]]
node = "seal"
clearance = "150 um"
stiffness = "5e7 N/m"
friction = 0.1
radius = "50 mm"
stator = { mass = "20 kg", stiffness = "1e7 N/m", damping = "2000 N s/m" }

[[contacts]]
node = "disc"
clearance = "140 um"
stiffness = "4e9 N/m^1.5"
damping = "2 s/m"
friction = 0.2
radius = "40 mm"
centre = ["10 um", 0]
race = { radius = "42 mm", inertia = "1e-4 kg m2", drag = 1e-5 }

[[unbalance]]
node = "disc"
moment = "1200 g mm"
phase = "90 deg"

[run_up]
from = "3900 rpm"
to = "4300 rpm"
ramp_time = "100 ms"
"""
CHAIN = np.array([[8e6, -4e6], [-4e6, 6e6]])
MATRICES = {"mass": np.diag([12.0, 12.0, 8.0, 8.0]), "stiffness": np.kron(CHAIN, np.eye(2)),
            "damping": np.kron(2e-4 * CHAIN, np.eye(2))}  # fmt: skip
SYSTEM_OF_PYTHON = RotorSystem(**MATRICES, nodes={"disc": (0, 1), "seal": (2, 3)})
AROUND: dict[str, Any] = {
    "contacts": [
        Contact(node="seal", clearance=150e-6, stiffness=5e7, exponent=1.0, friction=0.1,
                radius=0.05, stator=Stator(mass=20.0, stiffness=1e7, damping=2000.0)),
        Contact(node="disc", clearance=140e-6, stiffness=4e9, damping=2.0, friction=0.2,
                radius=0.04, centre=(1e-5, 0.0), race=Race(radius=0.042, inertia=1e-4, drag=1e-5)),
    ],
    "unbalance": [Unbalance(node="disc", moment=1.2e-3, phase=np.pi / 2)],
    "gravity": (0.0, -9.81),
    "start": "rest",  # the default of a file with a weight
}  # fmt: skip


@pytest.fixture
def rotor(program: Program) -> str:
    """Return a system file in the folder of the program."""
    np.savez("rotor.npz", **MATRICES)
    Path("rotor.toml").write_text(SYSTEM)
    return "rotor.toml"


def test_a_file_runs_as_python_does_to_the_bit(program: Program, rotor: str):
    answer = program("simulate", rotor, "--duration", "100ms", "--out", "run.nc")
    assert (answer.status, answer.err) == (0, "")
    run = rotor_ida.load("run.nc")
    expected = rotor_ida.simulate(SYSTEM_OF_PYTHON, **AROUND, speed=4300 * RPM, duration=0.1)
    assert set(run.event_contact.values.tolist()) == {0, 1}
    assert run.equals(expected)


def test_a_run_up_of_a_file_is_that_of_python(program: Program, rotor: str):
    assert program("run-up", rotor, "--out", "run.nc").status == 0
    rate = (4300 * RPM - 3900 * RPM) / 0.1
    ramp = {"speed": 3900 * RPM, "to": 4300 * RPM, "rate": rate}
    expected = rotor_ida.run_up(SYSTEM_OF_PYTHON, **AROUND, **ramp)
    assert rotor_ida.load("run.nc").equals(expected)


def test_options_replace_what_the_file_says(program: Program, rotor: str):
    answer = program(
        *("simulate", rotor, "--speed", "3000rpm", "--duration", 0.01, "--samples", 5),
        *("--rtol", 1e-9, "--method", "bdf", "--out", "run.nc"),
    )
    assert (answer.status, answer.err) == (0, "")
    run = rotor_ida.load("run.nc")
    assert (run.attrs["method"], run.attrs["rtol"], run.sizes["t"]) == ("bdf", 1e-9, 5)
    assert run.attrs["speed"] == 3000 * RPM
    change = ("--speeds", "0:100", "20ms:110", "--samples", 2)
    assert program("run-up", rotor, *change, "--out", "up.nc").status == 0
    assert rotor_ida.load("up.nc").speed.values.tolist() == [100.0, 110.0]
    drive = ("--from", 100, "--torque", 2, 0, "--inertia", 0.1, "--duration", 0.02)
    assert program("run-up", rotor, *drive, "--out", "up.nc", "--force").status == 0
    assert rotor_ida.load("up.nc").attrs["start_speed"] == 100.0


def test_the_answer_begins_with_the_first_touch(program: Program, rotor: str):
    answer = program("simulate", rotor, "--duration", 0.1)
    run = rotor_ida.simulate(SYSTEM_OF_PYTHON, **AROUND, speed=4300 * RPM, duration=0.1)
    first = float(run.event_time[0])
    number = int(run.event_contact[0])
    node = ("seal", "disc")[number]
    told = f"{run.sizes['episode']} contacts, with up to {float(run.peak_force.max()):.3g} N"
    when = f"{1e3 * first:.3g} ms"
    sentence = f"First touch at {when} of contact {number} at {node!r}; {told}."
    assert answer.out.splitlines()[0] == sentence
    told = json.loads(program("simulate", rotor, "--duration", 0.1, "--json").out)
    assert told["first_touch"]["contact"] == number
    for contact in told["contacts"]:
        own = run.isel(episode=run.episode_contact.values == contact["contact"])
        entries = (run.event_kind == 1) & (run.event_contact == contact["contact"])
        assert contact["entries"] == int(entries.sum()) > 0
        assert contact["first_touch"] == float(own.entry_time.min())
        assert contact["largest_force"] == float(own.peak_force.max())
        assert contact["rolling_time"] == float(own.rolling_time.sum())
        deepest = float(own.peak_indentation.max()) / contact["clearance"]
        assert contact["largest_r_over_clearance"] == pytest.approx(1.0 + deepest, rel=1e-12)
    assert len(told["events"]) == run.sizes["event"]
    still = program("simulate", rotor, "--duration", 0.001)
    assert still.out.startswith("The stator is not touched.")


def test_run_ups_of_a_file_are_those_of_python_and_verify(program: Program, rotor: str):
    answer = program("run-ups", rotor, "--to", "4300rpm", "--rate", "2e4rpm/s", "--out", "many.nc")
    assert (answer.status, answer.err) == (0, "")
    assert "How run-ups to 4,300 rpm end" in answer.out
    around = {name: each for name, each in AROUND.items() if name != "start"}
    ramp = {"speed": 3900 * RPM, "to": 4300 * RPM, "rate": 2e4 * RPM}
    expected = rotor_ida.run_ups(SYSTEM_OF_PYTHON, **around, **ramp, starts=["rest"])
    assert rotor_ida.load("many.nc").equals(expected)
    assert program("verify", "many.nc").status == 0
    record = json.loads(program("show", "many.nc", "--json").out)
    assert record["run_ups"][0]["excursion"] == float(expected.excursion.max())
    assert record["run_ups"][0]["first_touch_speed"] == float(expected.first_touch_speed.min())
    assert [row["contact_node"] for row in record["contacts"]] == ["seal", "disc"]
    answer = program("run-ups", rotor, "--from", "4000rpm", "--to", "4300rpm", "--rate",
                     "2e4rpm/s", "--damping", 2, "--friction", 0, 0.2, "--out", "over.nc",
                     "--figure", "over")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    over = {"friction": [0.0, 0.2], "damping": 2.0, "speed": 4000 * RPM}
    expected = rotor_ida.run_ups(SYSTEM_OF_PYTHON, **around, **ramp | over, starts=["rest"])
    assert rotor_ida.load("over.nc").equals(expected)


def test_a_sweep_of_a_file_is_that_of_python_and_verifies(program: Program, rotor: str):
    """Under gravity, in three modes; started where the file says."""
    text = Path(rotor).read_text().replace("gravity", "modes = 3\nstart = 'rest'\ngravity")
    Path(rotor).write_text(text)
    answer = program("sweep", rotor, "--speed", "3000rpm", "3600rpm", "--out", "map.nc")
    assert (answer.status, answer.err) == (0, "")
    assert answer.out.startswith("Responses by kind")
    found = rotor_ida.load("map.nc")
    speeds = [3000 * RPM, 3600 * RPM]
    around = {name: each for name, each in AROUND.items() if name != "start"}
    expected = rotor_ida.sweep(SYSTEM_OF_PYTHON, **around, speed=speeds, starts=["rest"], modes=3)
    assert found.equals(expected)
    shown = json.loads(program("show", "map.nc", "--json").out)
    assert [row["response"] for row in shown["responses"]] == rotor_ida.decode_flags(
        found.response
    ).values.ravel().tolist()
    np.testing.assert_allclose(
        [row["excursion"] for row in shown["responses"]],
        (found.radius_max / found.clearance).max("contact").values.ravel(),
    )
    record = json.loads(program("verify", "map.nc", "--json").out)
    assert (record["agrees"], record["largest_difference"]) == (True, 0.0)
    forged = found.assign(response=0 * found.response)
    rotor_ida.save(forged, "forged.nc")
    assert program("verify", "forged.nc").status == 1
    assert program("plot", "map.nc", "--figure", "map.png").status == 0


@pytest.mark.parametrize("command", ["simulate", "run-up"])
def test_an_archived_run_verifies_to_the_bit(program: Program, rotor: str, command: str):
    """Stators, races, gravity, unbalance and matrices are all in the archive."""
    options = ("--duration", 0.1) if command == "simulate" else ()
    assert program(command, rotor, *options, "--out", "run.nc").status == 0
    for name in ("rotor.npz", "rotor.toml"):
        Path(name).unlink()
    record = json.loads(program("verify", "run.nc", "--json").out)
    assert (record["agrees"], record["largest_difference"]) == (True, 0.0)
    assert record["events"] == record["archived_events"] > 3
    assert program("show", "run.nc").out.count("First touch at ") == 1


STILL = "--without-gravity"
PLAIN = (
    SYSTEM.partition('[[contacts]]\nnode = "disc"')[0]
    + """
[[unbalance]]
node = "disc"
moment = "1200 g mm"
"""
)


@pytest.fixture
def plain(program: Program) -> str:
    """Return the file of an axisymmetric system with one contact."""
    np.savez("rotor.npz", **MATRICES)
    Path("plain.toml").write_text(PLAIN)
    return "plain.toml"


OVER_SPEED = {
    "synchronous-response": (
        ("--speed", "3000rpm", "6000rpm", STILL),
        lambda system: rotor_ida.synchronous_response(
            system, speed=[3000 * RPM, 6000 * RPM]
        ),
    ),
    "special-speeds": (
        ("--limits", "3000rpm", "6000rpm", "--points", 20, STILL),
        lambda system: rotor_ida.special_speeds(
            system, limits=(3000 * RPM, 6000 * RPM), points=20
        ),
    ),
    "campbell": (
        ("--speed", 0, 500, "--contact-stiffness", 0, "1e7", "--modes", 4),
        lambda system: rotor_ida.campbell(
            system, speed=[0.0, 500.0], modes=4,
            contact_stiffness=[0.0, 1e7],
        ),
    ),
    "clearance-report": (
        ("--speed", "680", "840", "--probes", "disc", "--points", 40, "--multiple", 4, STILL),
        lambda system: rotor_ida.clearance_report(
            system, unbalance=[], speed=(680.0, 840.0), probes=["disc"], points=40, multiple=4.0
        ),
    ),
}  # fmt: skip


@pytest.mark.parametrize("command", OVER_SPEED)
def test_results_over_the_speed_are_those_of_python(program: Program, plain: str, command: str):
    """Archived, drawn, shown, verified; without the file."""
    options, expected = OVER_SPEED[command]
    answer = program(command, plain, *options, "--out", "found.nc", "--figure", "found.png")
    assert (answer.status, answer.err) == (0, "")
    system = replace(rotor_ida.load_system(plain), gravity=None)
    found = rotor_ida.load("found.nc")
    for name, variable in expected(system).variables.items():
        np.testing.assert_array_equal(found[name], variable, err_msg=name)
    Path(plain).unlink()
    assert json.loads(program("verify", "found.nc", "--json").out)["agrees"]
    assert program("plot", "found.nc", "--figure", "again.png").status == 0
    shown = program("show", "found.nc")
    assert (shown.status, "freedom too" in shown.out.partition("dimensions")[0]) == (0, False)


def test_a_critical_speed_without_a_resonance_is_told_apart_from_others():
    """The whirl of damping 2.6 turns with the rotor at ``sqrt(4 - 1.3**2)``, with a ratio 0.65."""
    damped, sharp = np.sqrt(4.0 - 1.3**2), 3.0
    system = rotor_ida.RotorSystem(
        mass=np.eye(4), stiffness=np.diag([4.0, 4.0, 9.0, 9.0]),
        damping=np.diag([2.6, 2.6, 0.01, 0.01]), units="1",
        nodes={"disc": [[1, 0, 0.2, 0], [0, 1, 0, 0.2]]},
    )  # fmt: skip
    record, parts = show_campbell(rotor_ida.campbell(system, speed=[1.0, 4.0]), None)
    assert {round(each["critical_speed"], 4) for each in record["critical_speeds"]} == {
        round(damped, 4), round(sharp, 4)
    }  # fmt: skip
    (sentence,) = (each for each in parts if isinstance(each, str))
    assert sentence.startswith(f"At {damped:.4g}")
    assert "no resonance shows" in sentence
    (table,) = (each for each in parts if isinstance(each, Sheet) and "Critical" in each.title)
    assert table.title == "Critical speeds: 2"  # forward and backward


def test_a_report_begins_with_its_words_and_weight_has_no_whirl(program: Program, plain: str):
    given = ("--speed", "680", "840", "--probes", "disc", "--points", 40)
    answer = program("clearance-report", plain, *given, STILL)
    assert answer.out.startswith("Contact 0 at 'seal' ")
    heavy = program("clearance-report", plain, *given)
    assert "no closed form: gravity or a static force acts on the rotor" in " ".join(
        heavy.out.split()
    )
    own = program("clearance-report", plain, *given, "--own-unbalance", STILL, "--json")
    applied = json.loads(own.out)["unbalance"]
    assert [row["applied_unbalance"] for row in applied] == [pytest.approx(2.4e-3), 0.0]
    answer = program("synchronous-response", plain)
    assert answer.status == 0
    assert "no closed form: gravity or a static force acts on the rotor" in " ".join(
        answer.out.split()
    )
    found = json.loads(program("synchronous-response", plain, STILL, "--json").out)
    assert {row["speed"] for row in found["whirls"]} == {4300 * RPM}


MISTAKES = [
    ("synchronous-response rotor.toml --zeta 1", "zeta must be left out with a rotor system"),
    ("synchronous-response rotor.toml --folds", "folds must be left out with a rotor system"),
    ("synchronous-response --omega 1 --zeta 1 --delta0 1 --without-gravity",
     "--without-gravity must be left out without a rotor system"),
    ("synchronous-response slow.toml", "speed must be given with --speed or in slow.toml"),
    ("special-speeds --limits 1 2", "a rotor must be given: a system file, or a machine with"),
    ("campbell rotor.npz --speed 1", "unexpected argument 'rotor.npz'; a rotor system must be"),
    ("campbell rotor.toml --speed 1 --contact-stiffness 3kg", "the unit of contact-stiffness"),
    ("clearance-report bare.toml --speed 1 2 --probes disc", "contacts must be at least one"),
    ("simulate gone.toml --duration 1", "cannot read 'gone.toml': No such file or directory"),
    ("simulate rotor.toml --duration 1 --omega 2", "omega must be left out with a rotor system"),
    ("simulate rotor.toml --duration 1 --machine a.toml", "machine must be left out with a rotor"),
    ("simulate rotor.toml --duration 1 --start 0 0 0 0", "start must be settled or rest with"),
    ("simulate rotor.toml --duration 1 --atol 1e-9", "atol must be left out with a rotor system"),
    ("simulate wrong.toml --duration 1", "wrong.toml: contacts[0]: node must be one of 'disc', "
     "'seal', got 'sael'; did you mean 'seal'?"),
    ("simulate slow.toml --duration 1", "speed must be given with --speed or in slow.toml"),
    ("simulate bare.toml --duration 20ms --speed 2", "duration must have no unit for a dimension"),
    ("run-up bare.toml --to 60rpm --rate 1", "to must have no unit for a dimensionless rotor"),
    ("run-up bare.toml", "the speed must change in one way, by to and rate or --ramp-time, by"),
    ("run-up rotor.toml --from 2 --speed 3", "speed must be left out with --from, got both"),
    ("run-up rotor.toml --from 2 --speeds 0:1 1:2", "from must be left out with speeds, got 2.0"),
    ("run-ups rotor.toml --to 1 --rate 1 --method bdf", "method must be left out with a rotor"),
    ("run-ups rotor.toml --to 1 --rate 1 --damping 3N*s/m", "damping must be a factor without"),
    ("run-ups rotor.toml --to 0 --rate 1", "to must not be 0 in run-ups of a rotor system, got"),
    ("poincare-section rotor.toml --revolutions 3 --at entry", "contact must be given for a"),
    ("poincare-section --omega 2 --zeta 0.1 --delta0 1 --revolutions 3 --contact 0",
     "contact must be left out with one disc, got 0"),
    ("poincare-section rotor.toml --revolutions 3 --node six", "node must be one of 'disc', 'se"),
    ("poincare-section --omega 2 --zeta 0.1 --delta0 1 --revolutions 3 --node one",
     "node must be left out with one disc, got 'one'"),
    ("bifurcation-diagram rotor.toml --speed 1 --starts 4", "starts must be left out with a"),
    ("bifurcation-diagram rotor.toml --speed 1 --seed 1", "seed must be left out with a rotor"),
    ("bifurcation-diagram --omega 1 --zeta 0.1 --delta0 1 --unbalance 2",
     "unbalance must be left out with one disc, got [2.0]"),
    ("cycle --omega 2 --zeta 0.07 --delta0 2 --without-gravity", "--without-gravity must be left"),
    ("cycle rotor.toml --start 1 0 0 0", "start must be settled or rest with a rotor"),
    ("continue rotor.toml --limits 1 3 --period 4.5", "period must be left out"),
    ("continue rotor.toml --limits 1 3 --special 0", "special must be left out without --from"),
    ("continue rotor.toml --limits 1 3 --parameter zeta", "parameter must be one of 'speed'"),
    ("continue rotor.toml --limits 1 3 --from rotor.toml", "rotor.toml is not an archive"),
    ("basin rotor.toml --x=-1um:1um:2 --y=-3:3:3", "node must be given with --node for a rotor "),
    ("basin rotor.toml --x=-1um:1um:2 --y=-3:3:3 --node seals", "node must be one of 'disc', 'se"),
    ("sweep rotor.toml --speed 0", "speed must not be 0 in a sweep of a rotor system, got 0.0"),
]  # fmt: skip


@pytest.mark.parametrize("word", ["settled", "rest"])
def test_a_word_replaces_the_start_of_the_file(program: Program, rotor: str, word: str):
    around = {name: each for name, each in AROUND.items() if name != "start"}
    words = ("--speed", 400, "--duration", 0.001, "--start", word, rotor, "--out", "run.nc")
    answer = program("simulate", *words)
    assert (answer.status, answer.err) == (0, "")
    run = rotor_ida.load("run.nc")
    expected = rotor_ida.simulate(SYSTEM_OF_PYTHON, **around, start=word, speed=400, duration=0.001)
    xr.testing.assert_equal(run.x, expected.x)
    answer = program("sweep", rotor, "--speed", 400, "--start", word, "--out", "map.nc")
    assert (answer.status, answer.err) == (0, "")
    told = json.loads(rotor_ida.load("map.nc").attrs["question"])
    assert told["starts"] == [word]


@pytest.mark.parametrize(("line", "message"), MISTAKES)
def test_a_mistake_gets_one_line(program: Program, rotor: str, line: str, message: str):
    bare = 'units = "1"\nsystem = { mass = [1, 1], stiffness = [1, 1], nodes = { disc = [0, 1] } }'
    Path("bare.toml").write_text(bare)
    Path("wrong.toml").write_text(SYSTEM.replace('node = "seal"', 'node = "sael"'))
    Path("slow.toml").write_text(SYSTEM.replace('speed = "4300 rpm"', "", 1))
    is_refused(program, line, message)


# ---- Warnings ----


def test_a_system_that_grows_is_told_once(program: Program) -> None:
    crossed = np.array([[1e6, 134_400.0], [-134_400.0, 1e6]])
    np.savez("seal.npz", mass=10.0 * np.eye(2), stiffness=crossed, damping=400.0 * np.eye(2))
    Path("seal.toml").write_text(
        'speed = "700 rad/s"\n[system]\nfile = "seal.npz"\nnodes = { disc = [0, 1] }\n',
        encoding="utf-8",
    )
    run = program("simulate", "seal.toml", "--duration", "0.1")
    words = "grows at a rate of 1.245 per second, as a whirl at 3,021 rpm"
    assert " ".join(run.out.split()).count(words) == 1
    assert words not in run.err


def test_a_warning_is_one_line_before_the_answer(
    rotor: str, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    def sweep(*_: object, **__: object) -> None:
        warnings.simplefilter("default")  # as outside of tests
        warnings.warn("it takes\nlong", stacklevel=1)
        raise rotor_ida.InputError("speed must not be 0")

    monkeypatch.setattr(rotor_ida, "sweep", sweep)
    run = program("sweep", rotor, "--speed", "4000rpm")
    assert run.err.splitlines()[0] == "rotor-ida: note: it takes long"
