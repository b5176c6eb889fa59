"""The command basin: what the library finds, and an interrupt that loses nothing."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rotor_ida
from rotor_ida.schema import FATE

Program = Callable[..., Any]

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


def test_an_interrupt_saves_what_is_done(program: Program, monkeypatch: pytest.MonkeyPatch):
    done = rotor_ida.basin(
        rotor_ida.Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=[0.0, 9.0], y=[0.0, 5.0]
    )
    done["label"][1, 1] = FATE["not_computed"]
    done["not_computed_count"] = done["not_computed_count"].copy(data=1)
    done.attrs["interrupted"] = 1
    monkeypatch.setattr("rotor_ida.basin", lambda *_, **__: done)
    answer = program(*FIGURE_7, *GRID, "--out", "basin.nc")
    assert answer.status == 130
    assert answer.err == "rotor-ida: interrupted: 3 of 4 starts are done\n"
    assert "wrote basin.nc" in answer.out
    assert rotor_ida.load("basin.nc").attrs["interrupted"] == 1


# Ctrl-C comes as soon as some starts are done, however fast the machine is.
INTERRUPTED = """
import signal, sys, rotor_ida
from rotor_ida.cli import main

def basin(*given, progress=None, **options):
    def told(done, total):
        if done:
            signal.raise_signal(signal.SIGINT)
    return whole(*given, progress=told, **options)

signal.signal(signal.SIGINT, signal.default_int_handler)
whole, rotor_ida.basin = rotor_ida.basin, basin
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_an_interrupt_from_the_keyboard_is_answered_at_once(tmp_path: Path):
    words = [str(word) for word in FIGURE_7] + ["--x=-15:15:2000", "--y=-15:15:2000"]
    line = [sys.executable, "-c", INTERRUPTED, *words, "--out", "basin.nc"]
    folder = os.fspath(Path(rotor_ida.__file__).parents[1])
    environment = {**os.environ, "PYTHONPATH": folder}
    done = subprocess.run(
        line, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 130, done.stderr
    assert "starts are done" in done.stderr
    kept = rotor_ida.load(tmp_path / "basin.nc")
    assert 0 < int(kept["not_computed_count"]) < 4_000_000


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--x", 0, "--y", "0:1:5"), "exactly two of x, y, vx, vy must be arrays"),
        (("--x", "0:1", "--y", "0:1:5"), "x must be numbers or START:STOP:COUNT, got '0:1'"),
        (("--x", "1:0:5", "--y", "0:1:5"), "x must increase, got 0.75 after 1.0"),
        (("--x", "0:1:9999", "--y", "0:1:9999"), "the grid must have at most 5000000 points"),
        (("--x", "0:1:5", "--y", "0:1:5", "--rtol", 1), "rtol must lie from"),
    ],
)
def test_mistakes_get_one_line(program: Program, words: tuple[object, ...], message: str):
    answer = program(*FIGURE_7, *words)
    assert (answer.status, answer.out) == (2, "")
    assert message in answer.err
    assert answer.err.count("\n") == 1
