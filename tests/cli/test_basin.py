"""The command basin: what the library finds, and an interrupt that loses nothing."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rotor_ida
from tests.cli.conftest import Program

FIGURE_7 = ("basin", "--omega", 1.7, "--zeta", 0.07, "--delta0", 0)
GRID = ("--x", "-15:15:12", "--y=-15:15:9")


def test_basin_answers_as_the_library_does(program: Program):
    answer = program(*FIGURE_7, *GRID, "--workers", 1, "--out", "basin.nc", "--json")
    assert (answer.status, answer.err) == (0, "")
    expected = rotor_ida.basin(
        rotor_ida.Rotor(omega=1.7, zeta=0.07, delta0=0.0),
        x=np.linspace(-15.0, 15.0, 12),
        y=np.linspace(-15.0, 15.0, 9),
    )
    kept = rotor_ida.load("basin.nc")
    np.testing.assert_array_equal(kept["label"], expected["label"])
    record = json.loads(answer.out)
    assert (record["kind"], record["grid"]) == ("basin", {"x": 12, "y": 9})
    assert [row["count"] for row in record["attractors"]] == expected["count"].values.tolist()
    assert [row["confirmed"] for row in record["attractors"]] == [True, True]
    assert [row["trapping"] for row in record["attractors"]] == ["proven", "proven"]
    assert (record["agreement"], record["agreement_count"]) == (1.0, 9)  # one of 12
    assert (record["labelling_rtol"], record["confirmation_rtol"]) == (1e-6, 1e-10)
    assert "synchronous" in program(*FIGURE_7, *GRID).out


def test_an_interrupt_from_the_keyboard_saves_what_is_done(
    program: Program, monkeypatch: pytest.MonkeyPatch
):
    whole = rotor_ida.basin

    def interrupted(*given: Any, **options: Any) -> Any:
        def told(done: int, _total: int) -> None:
            if done:
                signal.raise_signal(signal.SIGINT)

        return whole(*given, **{**options, "progress": told})

    monkeypatch.setattr("rotor_ida.basin", interrupted)
    answer = program(*FIGURE_7, "--x=-15:15:1000", "--y=-15:15:1000", "--out", "basin.nc")
    assert answer.status == 130
    kept = rotor_ida.load("basin.nc")
    missing = int(kept["not_computed_count"])
    assert 0 < missing < 1_000_000
    said = f"interrupted: {1_000_000 - missing} of 1000000 starts are done"
    assert answer.err == f"rotor-ida: {said}\n"
    assert "wrote basin.nc" in answer.out
    assert kept.attrs["interrupted"] == 1


# Two discs on a shaft that is the same in all directions; the seal is bistable.
SYSTEM = """
speed = "10982 rpm"
start = "settled"
[system]
mass = [10, 10, 10, 10]
damping = [1000, 1000, 1000, 1000]
stiffness = [[2e7, 0, -1e7, 0], [0, 2e7, 0, -1e7], [-1e7, 0, 1.4e7, 0], [0, -1e7, 0, 1.4e7]]
[system.nodes]
disc = [0, 1]
seal = [2, 3]
[[contacts]]
node = "seal"
clearance = "30 um"
stiffness = "5e9 N/m^1.5"
[[unbalance]]
node = "disc"
moment = "200 g mm"
"""
OF_SEAL = ("--node", "seal", "--x=-40um:10um:4")


def test_a_system_file_has_basins_and_fractions(program: Program):
    Path("rotor.toml").write_text(SYSTEM)
    answer = program("basin", "rotor.toml", *OF_SEAL, "--y=-30um:30um:3", "--out", "basin.nc",
                     "--figure", "basin", "--json")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    system = rotor_ida.load_system("rotor.toml")
    given = {"speed": 10982 * np.pi / 30.0, "node": "seal", "start": "settled"}
    expected = rotor_ida.basin(
        system, **given, x=np.linspace(-4e-5, 1e-5, 4), y=np.linspace(-3e-5, 3e-5, 3)
    )
    kept = rotor_ida.load("basin.nc")
    np.testing.assert_array_equal(kept["label"], expected["label"])
    record = json.loads(answer.out)
    assert (record["kind"], record["grid"]) == ("basin", {"x": 4, "y": 3})
    rub, free = record["attractors"]
    assert (rub["kind"], free["kind"]) == ("synchronous", "contact_free")
    assert rub["excursion"] == pytest.approx(float(expected.radius_max[0, 0]) / 3e-5)
    assert rub["count"] + free["count"] == 12
    assert record["contacts"] == [{"clearance": 3e-5, "contact_node": "seal"}]
    assert Path("basin.png").exists()
    assert program("verify", "basin.nc").status == 0
    drawn = program("plot", "basin.nc", "--force")
    assert (drawn.status, drawn.err) == (0, "")
    shares = program("basin-fractions", "rotor.toml", "--node", "seal", "--x=-40um:10um",
                     "--y=-30um:30um", "--starts", 6, "--start", "rest", "--study", "study",
                     "--json")  # fmt: skip
    assert (shares.status, shares.err) == (0, "")
    told = json.loads(shares.out)
    assert told["kind"] == "basin_fractions"
    assert sum(row["count"] for row in told["attractors"]) == 6
    assert program("status", "study").status == 0
