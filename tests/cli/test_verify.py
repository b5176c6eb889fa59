"""verify: an archive that holds agrees with itself made again; one that was forged does not."""

from __future__ import annotations

import json
from pathlib import Path

import rotor_ida
from tests.cli.conftest import Program


def test_an_archived_run_verifies(program: Program, archives: Path):
    answer = program("verify", archives / "run.nc", "--json")
    assert (answer.status, answer.err) == (0, "")
    record = json.loads(answer.out)
    assert record["agrees"] is True
    assert record["events"] == record["archived_events"] > 3
    assert record["largest_difference"] == 0.0
    assert "agrees" in program("verify", archives / "run.nc").out


def test_another_method_is_a_witness_of_a_run(program: Program, archives: Path):
    answer = program("verify", archives / "run.nc", "--method", "taylor", "--json")
    assert (answer.status, answer.err) == (0, "")
    record = json.loads(answer.out)
    assert record["agrees"] is True
    assert 0.0 < record["largest_difference"] < 1e-8


def test_a_forged_run_does_not(program: Program, archives: Path):
    run = rotor_ida.load(archives / "run.nc")
    rotor_ida.save(run.assign(event_time=run.event_time + 1e-3), "forged.nc")
    answer = program("verify", "forged.nc")
    assert answer.status == 1
    assert answer.err.startswith("rotor-ida: forged.nc does not verify: event_time differs in ")
    assert answer.err.count("\n") == 1
