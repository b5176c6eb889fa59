"""The command fit finds what a simulated measurement was made with, and refuses in one line."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import rotor_ida
from rotor_ida.units import SPEED_UNITS
from tests.cli.conftest import Program, is_refused

GUESS = ("--zeta", "0.08", "--delta0", "1.8", "--shaft-stiffness", "0.9")
SOUGHT = ("--unknown", "zeta", "delta0", "shaft_stiffness")
MACHINE = rotor_ida.DimensionalRotor(
    mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=1e-5, clearance=2.5e-5,
    speed=31.416, shaft_stiffness=5e4,
)  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a run-up, and a table of two probes and the angle of another."""
    found = tmp_path_factory.mktemp("measured")
    rotor = rotor_ida.Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
    run = rotor_ida.run_up(rotor, start=(0, 0, 0, 0), to=2.0, rate=0.02, samples=2501)
    rotor_ida.save(run, found / "run_up.nc")
    rpm = SPEED_UNITS["rpm"]
    up = rotor_ida.run_up(MACHINE, to=1500.0 * rpm, rate=300.0 * rpm, samples=4001)
    seen = rotor_ida.dimensional(up, units={"length": "µm"})
    angle = rotor_ida.signals_of(seen)["angle"].values
    table = np.stack([seen["t"], seen["x"], seen["y"], angle], axis=1)
    np.savetxt(found / "probes.csv", table, delimiter=",", header="t,x,y,angle", comments="")
    return found


def test_a_run_up_gives_its_rotor_back(program: Program, folder: Path):
    answer = program("fit", folder / "run_up.nc", *GUESS, *SOUGHT, "--json")
    assert (answer.status, answer.err) == (0, "")
    told = json.loads(answer.out)
    found = {row["unknown"]: row["estimate"] for row in told["unknown"]}
    assert found == pytest.approx({"zeta": 0.1, "delta0": 1.5, "shaft_stiffness": 1.0}, rel=1e-5)
    assert len(told["identifiability"]) >= 3


def test_a_table_in_micrometres_gives_its_machine_back(program: Program, folder: Path):
    machine = ("--mass", "4", "--contact-stiffness", "3.2e7", "--damping", "70",
               "--eccentricity", "1.2e-5", "--clearance", "3e-5",
               "--shaft-stiffness", "5e4")  # fmt: skip
    answer = program("fit", folder / "probes.csv", "--units", "t=s", "x=um", "y=um", *machine,
                     "--unknown", "damping", "eccentricity", "clearance",
                     "--out", "found.nc", "--figure", "found")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    assert "identifiability" not in answer.out
    assert "damping is known to" in answer.out
    assert {path.name for path in Path().iterdir()} == {"found.nc", "found.png", "found.svg"}
    found = rotor_ida.load("found.nc")
    np.testing.assert_allclose(found.estimate, [89.1, 1e-5, 2.5e-5], rtol=1e-5)
    shown = program("show", "found.nc")
    assert shown.status == 0
    assert {"damping [N s/m]", "eccentricity [um]"} <= {*re.split(r" {2,}|\n", shown.out)}
    drawn = program("show", "found.nc", "--figure", "again.png")
    assert (drawn.status, drawn.err) == (0, "")


def test_contact_times_are_taken(program: Program, folder: Path):
    run = rotor_ida.load(folder / "run_up.nc")
    entry = float(run.event_time[0])
    answer = program("fit", folder / "run_up.nc", *GUESS, *SOUGHT, "--entries", f"{entry:.17g}",
                     "--time-error", "0.01")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    assert "1 of 1 are compared" in answer.out


def test_a_search_that_is_stopped_says_so(program: Program, folder: Path):
    answer = program("fit", folder / "run_up.nc", *GUESS, *SOUGHT, "--limit", "1e-9",
                     "--out", "found.nc")  # fmt: skip
    assert answer.status == 1
    assert answer.err.startswith("rotor-ida: search stopped by its limit: no trial is better")
    assert "the search did not converge" in answer.out
    assert "is known to" not in answer.out
    shown = json.loads(program("show", "found.nc", "--json").out)
    assert all(row["standard_error"] is None for row in shown["unknown"])


def test_times_and_noise_have_units(program: Program, folder: Path):
    """As numbers they are in the units of the signals, s and um."""
    machine = ("--mass", "4", "--contact-stiffness", "3.2e7", "--damping", "89.1",
               "--eccentricity", "1.2e-5", "--clearance", "2.5e-5", "--shaft-stiffness", "5e4",
               "--units", "t=s", "x=um", "y=um", "--unknown", "eccentricity", "--json")  # fmt: skip
    answers = [
        program("fit", folder / "probes.csv", *machine, "--entries", entry, "--time-error", error,
                "--noise", noise)
        for entry, error, noise in (("2.5", "0.01", "0.3"), ("2500ms", "10ms", "300nm"))
    ]  # fmt: skip
    plain, named = (json.loads(answer.out) for answer in answers)
    assert plain["unknown"] == named["unknown"]
    assert plain["noise"] == named["noise"] == 0.3
    assert "compared" in plain["contact_times"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--unknown", "zetaa"), "got 'zetaa'; did you mean 'zeta'?"),
        (("--unknown", "zeta", "--entries", "20"), "--time-error must be given with --entries"),
        (("--unknown", "zeta", "--noise", "2um"), "noise must have no unit"),
        (("--unknown", "zeta", "--node", "disc"), "node must be left out without a rotor system"),
        (("--unknown", "friction"), "machine must have a --disc-radius"),
        (("--unknown", "zeta", "--times", "0", "5"), "signals must"),
        (("--unknown", "zeta", "--entries", "1e6", "--time-error", "1"),
         "entries must lie within the signals"),
    ],
)  # fmt: skip
def test_bad_input_is_told_in_one_line(program: Program, folder: Path, words, told):
    is_refused(program, " ".join(["fit", str(folder / "run_up.nc"), *GUESS, *words]), told)
    assert not list(Path().iterdir())


def test_a_machine_in_si_units_is_refused_for_signals_without(program: Program, folder: Path):
    line = (f"fit {folder / 'run_up.nc'} --mass 4 --contact-stiffness 3.2e7 --damping 70 "
            "--eccentricity 1e-5 --clearance 3e-5 --unknown damping")  # fmt: skip
    is_refused(program, line, "machine must be a Rotor, or a system without units, for signals")


SYSTEM = """
[system]
mass = [8, 8, 3, 3]
damping = [150, 150, 75, 75]
stiffness = [[9e5, 0, -6e5, 0], [0, 9e5, 0, -6e5], [-6e5, 0, 8e5, 0], [0, -6e5, 0, 8e5]]

[system.nodes]
disc = [0, 1]
end = [2, 3]

[[contacts]]
node = "disc"
clearance = "150 um"
stiffness = "5e6 N/m"

[[unbalance]]
node = "disc"
moment = "200 g mm"
"""


@pytest.fixture
def pump() -> None:
    """Write the file of a system, and the probes of one with less clearance and damping."""
    Path("pump.toml").write_text(SYSTEM)
    damped = SYSTEM.replace("150, 150, 75, 75", "120, 120, 60, 60").replace("150 um", "120 um")
    Path("true.toml").write_text(damped)
    true = rotor_ida.load_system("true.toml")
    run = rotor_ida.run_up(true, speed=60.0, to=340.0, rate=180.0, start="settled", samples=3001)
    rotor_ida.save(run, "run.nc")
    seen = [rotor_ida.signals_of(run, node=node) for node in ("disc", "end")]
    columns = [1e6 * each[axis].values for each in seen for axis in "xy"]
    table = np.stack([run["t"].values, *columns, seen[0]["angle"].values], axis=1)
    np.savetxt("four.csv", table, delimiter=",", header="t_s,A,B,C,D,angle_rad", comments="")


def test_probes_at_two_nodes_give_their_system_back(program: Program, pump: None):
    columns = ("disc:x=A", "disc:y=B", "end:x=C", "end:y=D")
    words = ("--start", "settled", "--unknown", "clearance", "damping")
    answer = program("fit", "pump.toml", "four.csv", "--columns", *columns, "--units", "x=um",
                     "y=um", *words, "--out", "found.nc", "--figure", "found")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    found = rotor_ida.load("found.nc")
    np.testing.assert_allclose(found["estimate"], [1.2e-4, 0.8], rtol=1e-5)
    assert set(found["node"].values) == {"disc", "end"}
    assert found["forward_whirl_amplitude"].attrs["units"] == "um"
    assert program("show", "found.nc").status == 0
    again = program("fit", "pump.toml", "run.nc", "--node", "end", *words, "--json")
    (gap, damping) = (row["estimate"] for row in json.loads(again.out)["unknown"])
    assert (gap, damping) == pytest.approx((1.2e-4, 0.8), rel=1e-5)


def test_a_table_of_a_simulated_system_is_fitted_as_its_archive_is(program: Program, pump: None):
    """The mark's angle is a column; that of a slip speed, which is empty in flight, is no speed."""
    run = ("simulate", "true.toml", "--speed", "1500rpm", "--duration", "1s", "--start", "settled")
    assert program(*run, "--csv", "run.csv").status == 0
    words = ("--start", "settled", "--unknown", "damping", "unbalance", "--json")
    table = program("fit", "pump.toml", "run.t.csv", "--columns", "end:x=x[end]", "end:y=y[end]",
                    "--units", "end:x=m", "end:y=m", *words)  # fmt: skip
    assert (table.status, table.err) == (0, "")
    assert program(*run, "--out", "steady.nc").status == 0
    archive = program("fit", "pump.toml", "steady.nc", "--node", "end", *words)
    both = [[row["estimate"] for row in json.loads(each.out)["unknown"]]
            for each in (table, archive)]  # fmt: skip
    assert both == [pytest.approx([0.8, 2e-4], rel=1e-5)] * 2


@pytest.mark.parametrize(("words", "said"), [
    (("run.nc",), "node must be 'disc' or 'end'"),
    (("run.nc", "--node", "disc", "--mass", "4"), "mass must be left out with a rotor system"),
    (("four.csv", "--columns", "x=A", "y=B"), "signals must be given by the node"),
    (("four.csv", "--node", "disc", "--columns", "disc:x=A", "disc:y=B"),
     "node must be left out with columns of nodes"),
    (("four.csv", "--columns", "disc:x=A", "disc:y=B", "--units", "dsc:x=um"),
     "units must be of the given nodes, got 'dsc:x=um'"),
    (("run.nc", "--node", "disc", "--start", "1", "0", "0", "0"),
     "start must be settled or rest with a rotor system"),
    (("pump.toml", "run.nc", "--node", "disc"), "FILE must be given with one rotor system at most"),
])  # fmt: skip
def test_bad_probes_of_a_system_are_told_in_one_line(
    program: Program, pump: None, words: tuple[str, ...], said: str
):
    is_refused(program, " ".join(["fit pump.toml", *words, "--unknown clearance"]), said)
