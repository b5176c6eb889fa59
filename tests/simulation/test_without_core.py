"""A package without its compiled core: runs by the reference, and one line for all else."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rotor_ida
from rotor_ida import Contact, Rotor, RotorSystem, Unbalance, run_up, simulate

SYSTEM = RotorSystem(
    mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
    contacts=[Contact(node="disc", clearance=1.5, stiffness=4.0)],
    unbalance=[Unbalance(node="disc", moment=1.0)], units="1",
)  # fmt: skip
RUBBING = Rotor(omega=1.2, zeta=0.07, delta0=0.5, shaft_stiffness=0.2, friction=0.1, disc_radius=2)
RUNS = {
    "disc": lambda: simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), duration=20.0),
    "friction": lambda: simulate(RUBBING, duration=20.0),
    "system": lambda: simulate(SYSTEM, speed=0.9, duration=30.0),
    "ramp": lambda: run_up(Rotor(omega=0.2, zeta=0.07, delta0=0.8), to=2.0, rate=0.05),
    "torque": lambda: run_up(
        Rotor(omega=0.2, zeta=0.07, delta0=0.8), torque=(1, 0), inertia=20, duration=40
    ),
    "ramp of a system": lambda: run_up(SYSTEM, speed=0.2, to=1.5, rate=0.05),
}
OF_EVENTS = ("event_time", "event_time_error", "event_kind")
INSTEAD = (
    "the compiled core {} is missing; run: pip install --force-reinstall, from where rotor-ida "
    "came. This needs a C compiler or the package ziglang. Until then the plain-Python reference "
    "computes runs by CVODE, 10 to 100 times more slowly"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the package, but for its libraries, and an archive."""
    there = tmp_path_factory.mktemp("package")
    shutil.copytree(
        Path(rotor_ida.__file__).parent, there / "rotor_ida",
        ignore=shutil.ignore_patterns("librotor_*", "__pycache__"),
    )  # fmt: skip
    rotor_ida.save(RUNS["disc"](), there / "run.nc")
    return there


@pytest.fixture(scope="module")
def missing(folder):
    return next(
        folder / "rotor_ida" / "core" / path.name
        for path in (Path(rotor_ida.__file__).parent / "core").glob("librotor_baseline.*")
    )


def python(folder, *words, code=0):
    """Return what Python prints that imports this package alone."""
    ended = subprocess.run(
        [sys.executable, *words], cwd=folder, check=False, capture_output=True, text=True,
        env=os.environ | {"PYTHONPATH": str(folder)},
    )  # fmt: skip
    assert ended.returncode == code, ended.stderr
    return ended


def described(run):
    told = {name: run[name].values.tolist() for name in OF_EVENTS}
    return told | {"horizon": float(run["horizon"]), "backend": run.attrs["backend"]}


@pytest.fixture(scope="module")
def runs(folder):
    """The runs of a process without a core, and its warnings."""
    ended = python(folder, "-W", "always", __file__)
    return json.loads(ended.stdout), ended.stderr


@pytest.mark.parametrize("name", RUNS)
def test_without_a_core_the_reference_finds_the_events_within_the_stated_errors(runs, name):
    found, wanted = runs[0][name], described(RUNS[name]())
    assert (found["backend"], wanted["backend"]) == ("python", "compiled")
    assert found["event_kind"] == wanted["event_kind"] != []
    assert found["horizon"] == wanted["horizon"]
    errors = [np.array(each["event_time_error"]) for each in (found, wanted)]
    late = np.abs(np.array(found["event_time"]) - wanted["event_time"])
    assert (late <= errors[0] + errors[1]).all()
    assert 0.0 < errors[0].max() < 1e-5


def test_without_a_core_each_run_warns_once_how_slow_it_is(runs, missing):
    assert runs[1].count(f"UserWarning: {INSTEAD.format(missing)}\n") == len(RUNS)


def test_without_a_core_the_command_line_runs(folder, missing):
    command = "run-up --omega 0.2 --zeta 0.07 --delta0 0.8 --to 0.6 --rate 0.05"
    ended = python(folder, "-m", "rotor_ida", *command.split())
    assert "first touches" in ended.stdout
    assert ended.stderr == f"rotor-ida: note: {INSTEAD.format(missing)}\n"


@pytest.mark.parametrize("command", [
    "sweep --omega 1.7 --zeta 0.07 --delta0 0.1",
    "simulate --omega 2 --zeta 0.07 --delta0 2 --duration 5 --backend compiled",
])  # fmt: skip
def test_without_a_core_all_else_is_refused_in_a_line(folder, missing, command):
    ended = python(folder, "-m", "rotor_ida", *command.split(), code=2)
    said, _, _ = INSTEAD.format(missing).partition(". This")
    assert (ended.stdout, ended.stderr) == ("", f"rotor-ida: {said}\n")


def test_without_a_core_archives_are_drawn(folder):
    ended = python(folder, "-m", "rotor_ida", *["plot", "run.nc", "--figure", "run.png"])
    assert ended.stdout
    assert ended.stderr == ""


def test_without_a_core_doctor_says_what_is_left(folder, missing):
    ended = python(folder, "-m", "rotor_ida", "doctor", "--json", code=1)
    told = json.loads(ended.stdout)
    assert told["backends"] == ["python"]
    assert {each["check"]: each["result"] for each in told["checks"]}["core: loaded"] == "failed"
    assert str(missing) in ended.stdout


if __name__ == "__main__":
    print(json.dumps({name: described(run()) for name, run in RUNS.items()}))
