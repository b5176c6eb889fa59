"""Sections and bifurcation diagrams on the command line: of one disc, a machine, and a file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import rotor_ida
from rotor_ida import Rotor
from rotor_ida.cli.describe import places_of_section
from tests.cli.conftest import Program

FILE = """
speed = 1.1
units = "1"
[system]
mass = [1, 1, 2, 2]
stiffness = [[2, 0, -1, 0], [0, 2, 0, -1], [-1, 0, 2, 0], [0, -1, 0, 2]]
damping = [[0.2, 0, -0.1, 0], [0, 0.2, 0, -0.1], [-0.1, 0, 0.2, 0], [0, -0.1, 0, 0.2]]
nodes = { one = [0, 1], two = [2, 3] }
[[contacts]]
node = "one"
clearance = 3.0
stiffness = 3.0
[[contacts]]
node = "two"
clearance = 0.4
stiffness = 3.0
[[unbalance]]
node = "one"
moment = 0.4
"""


@pytest.fixture
def rotor(program: Program) -> str:
    """Return a system file in the folder of the program."""
    Path("rotor.toml").write_text(FILE)
    return "rotor.toml"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("--omega 1.2 --zeta 0.5 --delta0 0.5 --revolutions 4 --skip 60",
         "5 points in one place, to 0.1 %: the motion repeats at every revolution."),
        ("--omega 2 --zeta 0.07 --delta0 2 --revolutions 60 --skip 300",
         "61 points that do not repeat after up to 30 revolutions"),
        ("--omega 2 --zeta 0.07 --delta0 2 --revolutions 40 --skip 300 --at entry",
         "points in one place, to 0.1 %: the motion repeats at every entry."),
        ("--omega 1.2 --zeta 0.5 --delta0 0.5 --revolutions 4 --at entry",
         "One point: too few to tell whether the motion repeats."),
        ("--omega 1.2 --zeta 0.5 --delta0 2 --revolutions 4 --at entry",
         "No points: too few to tell whether the motion repeats."),
    ],
)  # fmt: skip
def test_the_answer_begins_with_whether_the_points_repeat(program: Program, line: str, said: str):
    """A synchronous whirl stands still on turning axes; a bouncing cycle has its own period."""
    answer = program("poincare-section", *line.split())
    assert (answer.status, answer.err) == (0, "")
    assert said in answer.out.splitlines()[0]


@pytest.mark.parametrize("places", [1, 3])
def test_a_motion_of_several_revolutions_is_in_as_many_places(places: int):
    """Of a section made of a closed form: a sum of the whirl and a subharmonic of it."""
    section = rotor_ida.poincare_section(
        Rotor(omega=1.2, zeta=0.5, delta0=0.5), revolutions=23, skip=60
    )
    turn = np.exp(2j * np.pi * np.arange(24) / places)
    moved = section.copy(deep=True)
    for name, part in (("rotating_x", turn.real), ("rotating_y", turn.imag)):
        moved[name] = section[name] + 0.1 * part
    assert places_of_section(moved) == places
    jitter = 1.0 + 2e-2 * np.random.default_rng(1).random(24)
    assert places_of_section(moved.assign(rotating_x=moved.rotating_x * jitter)) == 0


def test_a_figure_is_drawn_at_a_node(program: Program, rotor: str):
    words = ("poincare-section", rotor, "--revolutions", 5, "--figure", "at")
    assert program(*words, "--node", "two").status == 0
    whole = program(*words, "--force")
    assert whole.status == 0
    diagram = ("diagram", rotor, "--speed", 1.0, 1.1, "--node", "two", "--figure", "diagram")
    assert program(*diagram).status == 0
    assert Path("diagram.png").exists()


@pytest.mark.parametrize(("contact", "number"), [("two", 1), ("0", 0)])
def test_a_section_of_a_file_is_that_of_python_at_a_contact(
    program: Program, rotor: str, contact: str, number: int
):
    words = ("--revolutions", 10, "--at", "peak", "--contact", contact, "--out", "section.nc")
    answer = program("poincare-section", rotor, *words)
    assert (answer.status, answer.err) == (0, "")
    system = rotor_ida.load_system(rotor)
    same = rotor_ida.poincare_section(system, speed=1.1, revolutions=10, at="peak", contact=number)
    found = rotor_ida.load("section.nc")
    assert found.equals(same)
    assert found.sizes["crossing"] > 3
    assert json.loads(program("verify", "section.nc", "--json").out)["agrees"]
    shown = json.loads(program("show", "section.nc", "--json").out)
    assert {row["node"] for row in shown["crossings"]} == {"one", "two"}
    assert program("plot", "section.nc", "--node", "one", "--figure", "one").status == 0
    assert program("plot", "section.nc", "--kind", "section", "--figure", "both").status == 0
    assert program("show", "section.nc", "--figure", "all").status == 0
    wrong = program("plot", "section.nc", "--kind", "section", "--times", 0, 1, "--figure", "none")
    assert "times must be left out with --kind section" in wrong.err
    assert not Path("none.png").exists()


def test_a_figure_over_two_parameters_is_refused_before_anything_is_computed(
    program: Program, rotor: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("rotor_ida.bifurcation_diagram", lambda *_, **__: pytest.fail("it ran"))
    two = ("--speed", 1.0, 1.1, "--friction", 0.1, 0.2, "--figure", "diagram")
    answer = program("diagram", rotor, *two)
    said = "rotor-ida: figure needs one parameter that varies, got speed and friction\n"
    assert (answer.status, answer.err) == (2, said)


@pytest.mark.parametrize("at", ["extrema", "revolution"])
def test_a_diagram_of_a_file_is_that_of_python_and_a_study(program: Program, rotor: str, at: str):
    words = ("--speed", 1.0, 1.1, "--friction", 0.0, "--at", at, "--revolutions", 4)
    more = ("--direction", "up", "--workers", 1, "--study", "study", "--out", "diagram.nc")
    answer = program("bifurcation-diagram", rotor, *words, *more, "--figure", "fig")
    assert (answer.status, answer.err) == (0, "")
    assert answer.out.startswith("Responses by kind")
    same = rotor_ida.bifurcation_diagram(
        rotor_ida.load_system(rotor), speed=[1.0, 1.1], friction=0.0, at=at, revolutions=4,
        direction="up",
    )  # fmt: skip
    assert rotor_ida.load("diagram.nc").equals(same)
    assert program("resume", "study", "--out", "again.nc").status == 0
    assert rotor_ida.load("again.nc").equals(same)
    assert json.loads(program("verify", "diagram.nc", "--json").out)["agrees"]
    for options in (["--node", "two"], ["--kind", "diagram"]):
        assert program("plot", "diagram.nc", *options, "--figure", "at", "--force").status == 0
