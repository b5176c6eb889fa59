"""Limit cycles of a rotor system on the command line: from a file, and from archives."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import rotor_ida
from tests.cli.conftest import Program

FILE = """
units = "1"
speed = 2.0

[system]
mass = [1.0, 1.0]
damping = [0.14, 0.14]
stiffness = [0.02, 0.02]

[system.nodes]
disc = [0, 1]

[[contacts]]
node = "disc"
clearance = 2.0
stiffness = 1.0

[[unbalance]]
node = "disc"
moment = 1.0
"""


@pytest.fixture
def disc(program: Program) -> str:
    """Return a system file in the folder in which the program runs."""
    Path("disc.toml").write_text(FILE)
    return "disc.toml"


def test_a_cycle_and_its_branch_are_those_of_the_library(program: Program, disc: str):
    answer = program("cycle", disc, "--out", "cycle.nc", "--figure", "cycle", "--json")
    assert (answer.status, answer.err) == (0, "")
    system = rotor_ida.load_system(disc)
    exact = rotor_ida.limit_cycle(system, speed=2.0)
    assert json.loads(answer.out)["period"] == exact.period.item()
    limits = ("--limits", 1.77, 2.01)
    answer = program(
        "continue", disc, "--from", "cycle.nc", *limits, "--out", "branch.nc", "--study", "kept"
    )
    assert (answer.status, answer.err) == (0, "")
    branch = rotor_ida.continue_cycle(system, start=exact, limits=(1.77, 2.01))
    archived = rotor_ida.load("branch.nc")
    np.testing.assert_array_equal(archived.special_value, branch.special_value)
    assert "period_doubling" in answer.out
    answer = program(
        "continue", disc, "--from", "branch.nc", "--special", 0, *limits, "--points", 3, "--json"
    )
    assert answer.status == 0
    found = [row["period"] for row in json.loads(answer.out)["points"]]
    np.testing.assert_allclose(found, 2.0 * branch.special_period.item(), rtol=1e-2)
    assert program("resume", "kept").status == 0
    for archive in ("cycle.nc", "branch.nc"):
        assert program("verify", archive).status == 0


def test_a_response_that_is_no_cycle_is_an_answer_too(program: Program, disc: str):
    answer = program("cycle", disc, "--speed", 0.2, "--figure", "cycle")
    assert (answer.status, answer.err) == (0, "")
    assert answer.out == (
        "No limit cycle: the response is contact_free.\ndrew no figure: there is no limit cycle\n"
    )


def test_a_branch_over_another_parameter_and_a_curve_are_archived(program: Program, disc: str):
    assert program("cycle", disc, "--out", "cycle.nc").status == 0
    over = ("--parameter", "clearance", "--limits", 1.9, 2.1)
    answer = program("continue", disc, "--from", "cycle.nc", *over, "--out", "branch.nc",
                     "--figure", "branch", "--json")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    record = json.loads(answer.out)
    assert [record["points"][place]["clearance"] for place in (0, -1)] == [1.9, 2.1]
    assert record["parameters"] == {"speed": 2.0}
    largest = rotor_ida.load("branch.nc").radius_max.max().item()
    assert record["contacts"][0]["radius_max"] == largest
    answer = program("curve", disc, "--from", "branch.nc", "--point", 0, "--kind",
                     "period_doubling", "--limits", 1.7, 2.1, 1.85, 1.95, "--points", 4,
                     "--out", "curve.nc", "--figure", "curve", "--study", "kept")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    curve = rotor_ida.load("curve.nc")
    half = program("continue", disc, "--from", "curve.nc", "--point", 0, "--limits", 1.77, 1.81,
                   "--points", 3, "--json")  # fmt: skip
    np.testing.assert_allclose(
        json.loads(half.out)["special_points"][0]["special_value"], curve.speed[0], rtol=1e-8
    )
    assert program("resume", "kept").status == 0
    for archive in ("branch.nc", "curve.nc"):
        assert program("verify", archive).status == 0
        assert program("show", archive).status == 0


def test_a_table_of_a_cycle_is_one_row_by_contact_and_node():
    system = rotor_ida.Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
    cycle = rotor_ida.limit_cycle(system, speed=2.0)
    table = rotor_ida.to_dataframe(cycle)
    assert len(table) == 1
    row = table.iloc[0]
    assert row["radius_max[disc]"] == row["node_radius_max[disc]"] == cycle.radius_max.item()
    assert (row["response"], row["multiplier_real[0]"], row["speed"]) == ("bouncing", 1.0, 2.0)
