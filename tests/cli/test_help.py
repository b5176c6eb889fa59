"""Help is quick, and every example in it runs."""

from __future__ import annotations

import inspect
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rotor_ida
from rotor_ida.cli.commands.basins import basin
from rotor_ida.cli.commands.simulated import simulate
from rotor_ida.cli.commands.swept import sweep

Program = Callable[..., Any]

COMMANDS = [
    *("reproduce", "simulate", "response", "sweep", "basin", "fractions", "status", "resume"),
    *("compare", "verify", "show", "doctor"),
]


def examples(text: str) -> list[list[str]]:
    """Return the words of each example in a help text."""
    lines = text.replace("\\\n", " ").splitlines()
    return [shlex.split(line)[1:] for line in lines if line.startswith("    rotor-ida ")]


def test_help_names_every_command(program: Program):
    answer = program("--help")
    assert (answer.status, answer.err) == (0, "")
    assert all(f" {command} " in answer.out for command in COMMANDS)
    assert program().out == answer.out


def test_the_version_is_told(program: Program):
    assert program("--version").out.strip() == "0.1.0"


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_an_example(program: Program, command: str):
    answer = program(command, "--help")
    assert (answer.status, answer.err) == (0, "")
    assert all(words[0] == command for words in examples(answer.out))
    assert examples(answer.out)


def test_the_examples_run_one_after_the_other(program: Program, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("rotor_ida.paper.reproduction.reproduce", lambda *_, **__: 0)
    for command in COMMANDS:
        for words in examples(program(command, "--help").out):
            answer = program(*words)
            assert (answer.status, answer.err) == (0, ""), words
    written = {path.name for path in Path().iterdir()}
    assert {"run.nc", "run.png", "whirls.nc", "sweep.nc", "basin.nc", "compared.nc"} <= written


def test_the_example_of_reproduce_names_a_scenario(program: Program):
    from rotor_ida.paper.reproduction import scenario_scripts

    (words,) = examples(program("reproduce", "--help").out)
    assert words[words.index("--only") + 1] in scenario_scripts()


def _as_number(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


@pytest.mark.parametrize(
    ("command", "library"), [(simulate, "simulate"), (sweep, "sweep"), (basin, "basin")]
)
def test_defaults_are_those_of_the_library(command: object, library: str):
    ours = inspect.signature(command).parameters  # type: ignore[arg-type]
    for name, parameter in inspect.signature(getattr(rotor_ida, library)).parameters.items():
        if name in ours and parameter.default is not inspect.Parameter.empty and name != "workers":
            assert str(ours[name].default) in {
                str(parameter.default),
                _as_number(parameter.default),
            }


def test_help_loads_nothing_heavy():
    code = """
import sys
from rotor_ida.cli import main
main(["simulate", "--help"])
heavy = {"xarray", "numba", "sksundae", "matplotlib", "scipy", "pandas"} & set(sys.modules)
sys.exit(f"loaded {heavy}" if heavy else 0)
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, b"")
