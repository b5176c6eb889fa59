"""What is wrong with friction gets one line and status 2 from every command that takes it."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Program = Callable[..., Any]

ROTOR = "--omega 1.2 --zeta 0.07 --delta0 {delta0}"
PLANE = "--x=-1:1:3 --y=-1:1:3"
BOX = "--x=-1:1 --y=-1:1 --starts 5"
MACHINE = (
    "--mass 4 --contact-stiffness 1e9 --damping 280 --eccentricity 1e-6 --clearance {delta0} "
    "--speed 1000"
)
COMMANDS = {
    "simulate": f"simulate {ROTOR} --duration 5",
    "response": f"response {ROTOR}",
    "folds": "response --zeta 0.07 --delta0 {delta0} --folds",
    "sweep": f"sweep {ROTOR}",
    "basin": f"basin {ROTOR} {PLANE}",
    "fractions": f"fractions {ROTOR} {BOX}",
    "atlas": f"atlas --omega 1.2 1.3 --zeta 0.07 --delta0 {{delta0}} {BOX}",
    "touchdown": f"touchdown {ROTOR}",
    "touchdown of a machine": f"touchdown {MACHINE}",
    "explore": f"explore {ROTOR} --export page.html --speeds 1:1.2:2",
    "explore a machine": f"explore {MACHINE} --export page.html --speeds 1000:1100:2",
    "cycle": f"cycle {ROTOR}",
    "continue": f"continue {ROTOR} --limits 1 3",
}
# Exact whirls slip, whatever the disc: they need no radius.
WITHOUT_DISC = {"response", "folds"}
MISTAKES = [
    ("0.5", "--friction 0.1", "disc_radius must be given with friction, got None with friction"),
    ("0.5", "--friction -0.1 --disc-radius 10", "friction must be zero or positive, got -0.1"),
    ("0.5", "--friction nan --disc-radius 10", "friction must be a finite real number, got nan"),
    ("0.5", "--friction 0.1 --disc-radius -1", "disc_radius must be zero or positive, got -1.0"),
    ("0.5", "--friction 0.1 --disc-radius nan", "radius must be a finite real number, got nan"),
    ("0.5", "--friction 0.1 --disc-radius wide", "radius must be a finite real number, got 'wide'"),
    ("0", "--friction 0.1 --disc-radius 10", "friction must be 0 without clearance, where the "),
]  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS)
def test_each_mistake_gets_one_line(
    program: Program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
):
    monkeypatch.chdir(tmp_path)
    for delta0, given, message in MISTAKES:
        if command in WITHOUT_DISC and "--disc-radius" not in given:
            continue
        line = f"{COMMANDS[command].format(delta0=delta0)} {given}"
        answer = program(*line.split())
        assert (answer.status, answer.out) == (2, ""), line
        assert re.fullmatch(rf"rotor-ida: [^\n]*{re.escape(message)}[^\n]*\n", answer.err), line
    assert not list(tmp_path.iterdir())
