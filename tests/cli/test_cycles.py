"""Limit cycles on the command line: cycle, continue and curve; their archives and studies."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rotor_ida
from rotor_ida.results.studies.store import FILE, PIECES
from tests.cli.conftest import Program

ROTOR = ("--omega", 2, "--zeta", 0.07, "--delta0", 2)
NEAR = ("--start", 2.6, 0.75, 0.66, -1.65, "--period", 4.5)


def test_cycle_answers_as_the_library_does(program: Program, archives: Path):
    answer = program("cycle", *ROTOR, *NEAR, "--out", "cycle.nc", "--json")
    assert (answer.status, answer.err) == (0, "")
    record, expected = json.loads(answer.out), rotor_ida.load(archives / "cycle.nc")
    for name in ("period", "radius_min", "radius_max", "largest_force", "period_error"):
        assert record[name] == expected[name].item()
    assert (record["response"], record["stability"]) == ("bouncing", "stable")
    assert record["parameters"]["omega"] == 2.0
    found = [row["multiplier_real"] for row in record["multipliers"]]
    assert found == expected["multiplier_real"].values.tolist()
    assert {row["line_kind"] for row in record["lines"]} == {"backward", "spin", "forward"}
    np.testing.assert_array_equal(rotor_ida.load("cycle.nc")["x"], expected["x"])


def test_cycles_at_points_are_counted_by_kind_and_verified(program: Program):
    rotor = rotor_ida.Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    found = rotor_ida.limit_cycle(rotor, omega=[1.9, 2.0, 2.5], workers=1)
    rotor_ida.save(found, "cycles.nc")
    record = json.loads(program("show", "cycles.nc", "--json").out)
    assert [row["omega"] for row in record["cycles"]] == [1.9, 2.0, 2.5]
    assert [row["period"] for row in record["cycles"][:2]] == found["period"].values[:2].tolist()
    text = program("show", "cycles.nc").out
    assert "4.56392 to 4.80056" in text
    assert program("verify", "cycles.nc").status == 0
    system = rotor_ida.limit_cycle(rotor.system(), speed=[1.9, 2.0], workers=1)
    rotor_ida.save(system, "system.nc")
    record = json.loads(program("show", "system.nc", "--json").out)
    largest = system["radius_max"].isel(contact=0).values.tolist()
    assert [row["radius_max"] for row in record["cycles"]] == largest


def test_a_cycle_is_found_from_rest_and_told_in_tables(program: Program):
    answer = program("cycle", *ROTOR)
    assert (answer.status, answer.err) == (0, "")
    assert "4.5639167" in answer.out
    assert "Multipliers: 4" in answer.out
    rows = [line.split() for line in answer.out.partition("Strongest lines")[2].splitlines()]
    heights = [float(row[1]) for row in rows if row[-1:] in (["forward"], ["backward"], ["spin"])]
    assert len(heights) == 10
    assert heights == sorted(heights, reverse=True)


def test_a_response_that_is_no_cycle_is_an_answer_too(program: Program):
    words = ("cycle", "--omega", 1.2, "--zeta", 0.07, "--delta0", 2, "--figure", "cycle")
    answer = program(*words, "--out", "none.nc")
    assert (answer.status, answer.err) == (0, "")
    assert "No limit cycle" in answer.out
    assert "contact_free" in answer.out
    assert "drew no figure: there is no limit cycle" in answer.out
    assert os.listdir() == ["none.nc"]
    assert program("show", "none.nc").status == 0
    refused = program("continue", "--from", "none.nc", "--limits", 1, 2)
    assert refused.status == 2
    assert "from must contain a limit cycle, got 'none.nc' without one" in refused.err


def test_continue_begins_at_a_start_or_at_an_archived_cycle(program: Program, archives: Path):
    limits = ("--limits", 1.5, 2.5, "--json")
    by_start = json.loads(program("continue", *ROTOR, *NEAR, *limits).out)
    by_file = json.loads(program("continue", "--from", archives / "cycle.nc", *limits).out)
    branch = rotor_ida.load(archives / "branch.nc")
    for record in (by_start, by_file):
        values = [row["special_value"] for row in record["special_points"]]
        np.testing.assert_allclose(values, branch["special_value"], rtol=1e-9)
    assert [row["special_kind"] for row in by_file["special_points"]] == [
        "graze", "period_doubling"
    ]  # fmt: skip
    assert by_file["points"][0]["omega"] == branch["omega"].values[0]
    np.testing.assert_allclose(by_file["stable_ranges"][0]["to"], 2.5)
    assert (by_file["first_end"], by_file["closed"]) == ("limits", False)


def test_continue_from_a_point_over_another_parameter(program: Program, archives: Path):
    words = ("--from", archives / "branch.nc", "--point", 12, "--parameter", "delta0")
    answer = program("continue", *words, "--limits", 1.9, 2.1, "--json")
    assert (answer.status, answer.err) == (0, "")
    record = json.loads(answer.out)
    branch = rotor_ida.load(archives / "branch.nc")
    assert record["parameters"]["omega"] == branch["omega"].values[12]
    assert (record["points"][0]["delta0"], record["points"][-1]["delta0"]) == (1.9, 2.1)


def test_the_doubled_branch_leaves_at_a_doubling(program: Program, archives: Path):
    words = ("--from", archives / "branch.nc", "--special", 1, "--limits", 1.75, 2.5)
    record = json.loads(program("continue", *words, "--json").out)
    simple = rotor_ida.load(archives / "branch.nc")["special_period"].values[1]
    assert all(row["period"] > 1.9 * simple for row in record["points"])
    assert record["last_end"] == "limits"


def test_curve_begins_at_a_special_point_a_cycle_or_a_curve(program: Program, archives: Path):
    limits = ("--kind", "period_doubling", "--limits", 1.7, 1.9, 1.9, 2.1, "--json")
    expected = rotor_ida.load(archives / "curve.nc")
    for source in (
        ("branch.nc", "--special", 1), ("curve.nc", "--point", 3),
    ):  # fmt: skip
        answer = program("curve", "--from", archives / source[0], *source[1:], *limits)
        assert (answer.status, answer.err) == (0, ""), source
        record = json.loads(answer.out)
        ends = sorted(record["points"][place]["omega"] for place in (0, -1))
        np.testing.assert_allclose(ends, np.sort(expected["omega"].values[[0, -1]]), rtol=1e-9)
        assert (record["kind"], record["of"]) == ("curve", "period_doubling")


@pytest.mark.parametrize("name", ["cycle", "branch", "curve"])
def test_archives_are_shown_drawn_and_verified(program: Program, archives: Path, name: str):
    shown = program("show", archives / f"{name}.nc", "--figure", name)
    assert (shown.status, shown.err) == (0, "")
    assert Path(f"{name}.png").exists()
    record = json.loads(program("show", archives / f"{name}.nc", "--json").out)
    assert record["kind"] == name
    verified = program("verify", archives / f"{name}.nc", "--json")
    assert (verified.status, verified.err) == (0, "")
    told = json.loads(verified.out)
    assert told["agrees"] is True
    assert told["compared"] > 10
    assert told["largest_difference"] < 1e-8


def test_a_study_of_a_branch_goes_on(
    program: Program, archives: Path, monkeypatch: pytest.MonkeyPatch
):
    words = ("continue", "--from", archives / "cycle.nc", "--limits", 0.3, 3, "--study", "study")
    whole = json.loads(program(*words[:-2], "--json").out)
    real = rotor_ida.continue_cycle

    def breaks_off(*given: Any, **more: Any) -> Any:
        told: list[int] = []

        def stop(done: int, _points: int) -> None:
            told.append(done)
            if len(told) == 2:
                raise KeyboardInterrupt

        return real(*given, **{**more, "progress": stop})

    with monkeypatch.context() as patch:
        patch.setattr(rotor_ida, "continue_cycle", breaks_off)
        answer = program(*words)
    assert answer.status == 130
    assert "points are saved in study; continue with rotor-ida resume study" in answer.err
    assert sorted(os.listdir("study")) == [PIECES, FILE]
    found = json.loads(program("status", "study", "--json").out)
    assert found["kind"] == "continue_cycle"
    assert 0 < found["done"] < found["points"]
    resumed = program("resume", "study", "--json", "--figure", "branch")
    assert (resumed.status, resumed.err) == (0, "")
    record = json.loads(resumed.out)
    assert record["points"] == whole["points"]
    assert record["special_points"] == whole["special_points"]
    assert Path("study", "result.nc").exists()
    assert Path("branch.png").exists()


def test_a_machine_under_a_load_goes_from_cycle_to_branch_to_curve(program: Program):
    machine = ("--omega", 1.6, "--zeta", 0.05, "--delta0", 0.75, "--load", 1.6,
               "--shaft-stiffness", 1, "--contact-exponent", 1)  # fmt: skip
    damped = (*machine, "--contact-damping", 0.5)
    assert program("cycle", *damped, "--start", 0, -1, 0, 0, "--out", "cycle.nc").status == 0
    answer = program("continue", "--from", "cycle.nc", "--parameter", "contact_damping",
                     "--limits", 0.4, 0.7, "--out", "branch.nc", "--json")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    (special,) = json.loads(answer.out)["special_points"]
    assert special["special_kind"] == "torus"
    answer = program("curve", "--from", "branch.nc", "--special", 0, "--kind", "torus",
                     "--parameters", "contact_damping", "omega", "--limits", 0.4, 0.7, 1.58, 1.62,
                     "--out", "curve.nc")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    answer = program("continue", "--from", "curve.nc", "--point", 0, "--limits", 1.5, 1.7,
                     "--points", 4, "--json")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    given = json.loads(answer.out)["parameters"]
    assert (given["load"], given["shaft_stiffness"], given["contact_exponent"]) == (1.6, 1.0, 1.0)
    answer = program("continue", "--from", "cycle.nc", "--load", 1, "--limits", 1, 2)
    assert (answer.status, answer.err) == (2, "rotor-ida: load must be left out with --from\n")
