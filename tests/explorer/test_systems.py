"""The page of a rotor system: its questions, and answers that are those of the library."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rotor_ida import load_system, save, simulate
from rotor_ida.errors import InputError
from rotor_ida.explorer import systems
from rotor_ida.explorer.messages import Answer, read_question
from rotor_ida.explorer.system_questions import SystemQuestion

DISC = """
speed = "2000 rpm"
system = { mass = [4, 4], stiffness = [1e5, 1e5], damping = [80, 80], nodes = { disc = [0, 1] } }
contacts = [ { node = "disc", clearance = "60 um", stiffness = "1e7 N/m" } ]
unbalance = [ { node = "disc", moment = "100 g mm" } ]
"""
ASKED = {
    "about": "system_run", "number": 1, "node": "", "contact": 0, "speed": None, "revolutions": 10,
    "changes": {},
}  # fmt: skip


@pytest.fixture
def path(tmp_path: Path) -> Path:
    place = tmp_path / "disc.toml"
    place.write_text(DISC)
    return place


def question(path: Path, **changes: object) -> SystemQuestion:
    found = read_question(json.dumps(ASKED | changes))
    assert isinstance(found, SystemQuestion)
    return replace(found, path=path)


def run_of(asked: SystemQuestion) -> Answer:
    return list(systems.show_system_run(asked))[-1]


def test_a_run_is_that_of_its_python_lines(path: Path) -> None:
    answer = run_of(question(path, changes={"clearance": 5e-5}))
    lines = str(answer.facts["python"]).replace("disc.toml", str(path))
    there: dict[str, object] = {}
    exec(lines, there)
    np.testing.assert_array_equal(answer.arrays["x"], there["run"]["x"].values.ravel())  # type: ignore[index]
    assert answer.facts["command"] == ""


def test_an_archive_is_played_as_it_is(path: Path, tmp_path: Path) -> None:
    case = load_system(path)
    run = simulate(case.system, **case.around, speed=case.speed, duration=0.05)
    archive = tmp_path / "run.nc"
    save(run, archive)
    np.testing.assert_array_equal(
        run_of(question(archive)).arrays["normal_force"], run["normal_force"].values.ravel()
    )


def test_the_map_and_the_campbell_diagram_are_sent(path: Path) -> None:
    parts = {
        each.part: each for each in systems.show_system_map(question(path, about="system_map"))
    }
    assert set(parts) == {"map", "campbell"}
    assert np.isfinite(parts["map"].arrays["amplitude"]).any()


@pytest.mark.parametrize(
    ("changes", "words"),
    [({"node": "seal"}, "node must be one of disc, got 'seal'"),
     ({"contact": 3, "changes": {"clearance": 1e-4}}, "contact must be below 1, got 3"),
     ({"speed": 0.0}, "speed must be positive, got 0.0")],
)  # fmt: skip
def test_what_a_system_does_not_have_is_refused(
    path: Path, changes: dict[str, object], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        run_of(question(path, **changes))


def test_a_bad_file_is_told_by_its_name_alone(path: Path) -> None:
    path.write_text("speed = 3")
    with pytest.raises(InputError, match=r"^disc\.toml: system must be given"):
        run_of(question(path))


def test_a_file_of_another_kind_is_refused() -> None:
    asked = {"about": "system_file", "number": 1, "name": "rotor.csv", "size": 3}
    with pytest.raises(InputError, match="ending of the file must be"):
        read_question(json.dumps(asked))
