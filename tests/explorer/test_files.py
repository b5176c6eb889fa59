"""What one keeps of a run: each file whole, and of the very run that was shown."""

from __future__ import annotations

import json
import re
import runpy
import shlex
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib import pyplot

import rotor_ida
from rotor_ida.cli import main
from rotor_ida.explorer import files
from rotor_ida.results import si_units
from tests.explorer.asking import BEYOND, BEYOND_IN_SI, MACHINE, ROTOR, answer_to, question

START = [2.6, 0.75, 0.66, -1.65]
WHOLE = ROTOR | BEYOND
WHOLE_IN_SI = MACHINE | BEYOND_IN_SI
SHOWN = ("t", "x", "y", "event_time", "event_x", "event_y")


@pytest.fixture(autouse=True)
def nothing_left_behind(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> Iterator[None]:
    folder = tmp_path_factory.mktemp("temporary")
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    yield
    assert not list(folder.iterdir())


def contents_of(about: str, **changes: object) -> bytes:
    (message,) = answer_to(question(about, start=START, **changes))
    assert message.facts["name"] == f"run.{about}"
    return message.arrays["contents"].tobytes()


def shown_run(**changes: object) -> dict[str, np.ndarray]:
    (message,) = answer_to(question(start=START, **changes))
    return dict(message.arrays)


@pytest.mark.parametrize("machine", [MACHINE, WHOLE, WHOLE_IN_SI, ROTOR | {"omega": 0.0}])
def test_the_archive_is_of_the_run_that_was_shown_and_verified(
    machine: dict[str, float], tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    place = tmp_path / "run.nc"
    place.write_bytes(contents_of("nc", machine=machine, revolutions=20))
    run = rotor_ida.load(place)
    assert si_units.is_in_si(run) == ("mass" in machine)
    run = si_units.dimensionless(run)
    for name, values in shown_run(machine=machine, revolutions=20).items():
        if name in SHOWN:
            np.testing.assert_allclose(run[name].values, values, rtol=1e-14, err_msg=name)
    assert main(["verify", str(place)]) == 0
    capsys.readouterr()


@pytest.mark.parametrize("machine", [WHOLE_IN_SI, ROTOR | {"omega": 0.0}])
def test_the_command_makes_the_run_and_its_figure_again(
    machine: dict[str, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
):  # fmt: skip
    program, *words = shlex.split(contents_of("sh", machine=machine, revolutions=20).decode())
    assert program == "rotor-ida"
    monkeypatch.chdir(tmp_path)
    assert main(words) == 0
    capsys.readouterr()
    run = si_units.dimensionless(rotor_ida.load("run.nc"))
    shown = shown_run(machine=machine, revolutions=20)
    for name in SHOWN:  # in SI units the start is rounded
        np.testing.assert_allclose(run[name].values, shown[name], rtol=1e-9, err_msg=name)
    assert Path("run.png").exists()


def test_the_page_is_recorded_step_by_step_and_has_the_speed_that_is_shown(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(files, "SPEEDS", np.array([1.9, 2.1]) / 4.0)
    asked = question("html", machine=MACHINE, revolutions=5)
    *steps, file = answer_to(asked)
    assert [each.facts for each in steps] == [{"done": n, "total": 9} for n in range(1, 10)]
    page = file.arrays["contents"].tobytes().decode()
    told = json.loads(re.search(r'id="recorded">(.*?)</script>', page)[1])
    part = asked.disc.reference_frequency * files.speeds_shown(asked.disc)[1] / 4.0
    own = MACHINE["speed"]
    assert told["places"] == pytest.approx(sorted([1.9 * part, 2.1 * part, own]))
    assert told["place"] == own


@pytest.mark.parametrize("machine", [ROTOR, WHOLE_IN_SI])
def test_the_lines_make_the_run_and_its_figure_again(
    machine: dict[str, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    lines = tmp_path / "run.py"
    lines.write_bytes(contents_of("py", machine=machine, revolutions=20))
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(lines))
    run = si_units.dimensionless(rotor_ida.load("run.nc"))
    shown = shown_run(machine=machine, revolutions=20)
    # the script has the start in SI units, which rounds it once more; the rub makes this grow
    rounded = 0.0 if machine is ROTOR else 1e-12
    for name in SHOWN:
        np.testing.assert_allclose(run[name].values, shown[name], rtol=1e-14, atol=rounded,
                                   err_msg=name)  # fmt: skip
    assert sorted(each.name for each in tmp_path.iterdir()) == [
        "run.nc", "run.png", "run.py", "run.svg",
    ]  # fmt: skip
    if machine is ROTOR:
        runpy.run_path(str(lines))  # once more, over what is there


def test_the_figures_are_pictures():
    png, svg = (contents_of(each, revolutions=20) for each in ("png", "svg"))
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    assert ElementTree.fromstring(svg).tag == "{http://www.w3.org/2000/svg}svg"
    # pyplot knows nothing of them
    assert pyplot.get_fignums() == []


def test_a_run_that_cannot_be_followed_gets_one_reason_and_no_file():
    machine = ROTOR | {"omega": 1e-6}
    (message,) = answer_to(question("nc", machine=machine, revolutions=2000))
    assert message.part == "trouble"
    assert "duration must be below" in message.facts["message"]
