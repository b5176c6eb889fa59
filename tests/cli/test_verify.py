"""verify: an archive that holds agrees with itself made again; one that was forged does not."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rotor_ida

Program = Callable[..., Any]


def test_an_archived_run_verifies(program: Program, archives: Path):
    answer = program("verify", archives / "run.nc", "--json")
    assert (answer.status, answer.err) == (0, "")
    record = json.loads(answer.out)
    assert record["agrees"] is True
    assert record["events"] == record["archived_events"] > 3
    assert record["largest_difference"] == 0.0
    assert "agrees" in program("verify", archives / "run.nc").out


def test_a_forged_run_does_not(program: Program, archives: Path):
    run = rotor_ida.load(archives / "run.nc")
    rotor_ida.save(run.assign(event_time=run.event_time + 1e-3), "forged.nc")
    answer = program("verify", "forged.nc")
    assert answer.status == 1
    assert answer.err.startswith("rotor-ida: forged.nc does not verify: Mismatched events: ")
    assert answer.err.count("\n") == 1


def test_only_runs_can_be_verified(program: Program, archives: Path):
    answer = program("verify", archives / "sweep.nc")
    assert answer.status == 2
    assert answer.err == (
        "rotor-ida: only a simulated run can be verified; "
        "it lacks omega, zeta, delta0, start, duration, event_time_error, time\n"
    )
    assert program("verify", "missing.nc").status == 2
