"""A package without its compiled core: runs by the reference, and one line for all else."""

import io
import json
import os
import shutil
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np
import pytest

import rotor_ida
from rotor_ida import Contact, Rotor, RotorSystem, Unbalance, run_up, simulate
from rotor_ida.cli import main

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
COMMANDS = [
    "run-up --omega 0.2 --zeta 0.07 --delta0 0.8 --to 0.6 --rate 0.05",
    "sweep --omega 1.7 --zeta 0.07 --delta0 0.1",
    "simulate --omega 2 --zeta 0.07 --delta0 2 --duration 5 --backend compiled",
    "show run.nc",
    "doctor --json",
]
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


def described(run):
    told = {name: run[name].values.tolist() for name in OF_EVENTS}
    return told | {"horizon": float(run["horizon"]), "backend": run.attrs["backend"]}


def answered(command):
    """Return what the program returns and prints."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = main(command.split())
    return code, out.getvalue(), err.getvalue()


@pytest.fixture(scope="module")
def found(folder):
    """Runs and answers of a process that imports this package alone, and its warnings."""
    ended = subprocess.run(
        [sys.executable, "-W", "always", __file__], cwd=folder, check=True, capture_output=True,
        text=True, env=os.environ | {"PYTHONPATH": str(folder)},
    )  # fmt: skip
    return json.loads(ended.stdout), ended.stderr


@pytest.mark.parametrize("name", RUNS)
def test_without_a_core_the_reference_finds_the_events_within_the_stated_errors(found, name):
    slow, wanted = found[0]["runs"][name], described(RUNS[name]())
    assert (slow["backend"], wanted["backend"]) == ("python", "compiled")
    assert slow["event_kind"] == wanted["event_kind"] != []
    assert slow["horizon"] == wanted["horizon"]
    errors = [np.array(each["event_time_error"]) for each in (slow, wanted)]
    late = np.abs(np.array(slow["event_time"]) - wanted["event_time"])
    assert (late <= errors[0] + errors[1]).all()
    assert 0.0 < errors[0].max() < 1e-5


def test_without_a_core_each_run_warns_once_how_slow_it_is(found, missing):
    assert found[1].count(f"UserWarning: {INSTEAD.format(missing)}\n") == len(RUNS)


def test_without_a_core_the_program_answers_what_it_can_in_words(found, missing):
    """A run by the reference, an archive, and what is left; all else is refused in a line."""
    warned = INSTEAD.format(missing)
    ran, swept, compiled, shown, doctor = found[0]["answers"]
    assert "first touches" in ran[1]
    assert ran[2] == f"rotor-ida: note: {warned}\n"
    refused, _, _ = warned.partition(". This")
    assert swept == compiled == [2, "", f"rotor-ida: {refused}\n"]
    assert (shown[0], shown[2]) == (0, "")
    assert shown[1]
    told = json.loads(doctor[1])
    assert (doctor[0], told["backends"]) == (1, ["python"])
    assert {each["check"]: each["result"] for each in told["checks"]}["core: loaded"] == "failed"
    assert str(missing) in doctor[1]


if __name__ == "__main__":
    runs = {name: described(run()) for name, run in RUNS.items()}
    print(json.dumps({"runs": runs, "answers": [*map(answered, COMMANDS)]}))
