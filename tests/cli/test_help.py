"""Help is quick, and every example in it runs."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import rotor_ida
from rotor_ida.cli.program import COMMANDS as BY_GROUP
from rotor_ida.cli.program import SHORT as NAMES
from rotor_ida.cli.program import name_of
from rotor_ida.results import system_file
from tests.cli.conftest import Program

# Each finds the files of those before it; from-ross needs ROSS, and drop another system.
COMMANDS = [name_of(each) for group in BY_GROUP.values() for each in group
            if each.verb not in {"from_ross", "drop"}]  # fmt: skip
SHORT = {short: name for name, short in NAMES.items()}
HELP: dict[str, str] = {}


@pytest.fixture
def help_of(program: Program) -> Callable[[str], str]:
    """Return the help of a command, which is asked for once."""

    def ask(command: str) -> str:
        if command not in HELP:
            HELP[command] = program(command, "--help").out
        return HELP[command]

    return ask


def examples(text: str) -> list[list[str]]:
    """Return the words of each example in a help text."""
    lines = text.replace("\\\n", " ").splitlines()
    return [shlex.split(line)[1:] for line in lines if line.startswith("    rotor-ida ")]


def test_help_names_every_command(program: Program):
    answer = program("--help")
    assert (answer.status, answer.err) == (0, "")
    assert all(f" {command} " in answer.out for command in COMMANDS)
    assert all(f"({short})" in answer.out for short in SHORT)
    assert program().out == answer.out


def test_commands_are_in_groups_in_the_order_of_work(program: Program):
    listed = program("--help").out
    places = [listed.index(f"\u2500 {group} \u2500") for group in BY_GROUP]
    assert places == sorted(places)
    assert "\u2500 Commands \u2500" not in listed


def test_a_short_name_is_the_same_command(help_of: Program):
    for short, name in SHORT.items():
        by_either = help_of(short), help_of(name)
        assert by_either[0].replace(f"rotor-ida {short} ", f"rotor-ida {name} ").split() == (
            by_either[1].split()
        )


def test_commands_that_compute_have_the_names_of_functions():
    others = {"machine", "plot", "explore", "show", "verify", "reproduce", "doctor"}
    names = {command.replace("-", "_") for command in COMMANDS if command not in others}
    assert names <= {*rotor_ida.__all__}


# Words of no English help, each with what it stood in.
FORBIDDEN = r"\bSay\b|\btold\b|\bholds\b|hangs on|one that suits\.|without it|\bHold\b|throws it"


@pytest.mark.parametrize("command", COMMANDS)
def test_help_is_in_groups_and_in_plain_english(help_of: Program, command: str):
    """Words are free only where anything may stand: the name of a scenario."""
    listed = help_of(command)
    options = re.findall(r"--([a-z0-9-]+) \S*STR", listed)
    assert options == (["only"] if command == "reproduce" else [])
    assert not re.search(FORBIDDEN, listed)
    verbs = "Simulate List Compute Estimate Continue Report Reproduce Describe Open Fit Plot Show"
    others = "Compare Recompute Check"
    assert listed.split("\n\n")[1].split()[0] in f"{verbs} {others}".split()
    assert "\u2500 Parameters \u2500" not in listed
    groups = {"--omega": "Rotor", "--rtol": "Solver", "--out": "Output", "--json": "Output"}
    for option, group in groups.items():
        if line := re.search(rf"\u2502[ *]+{option} ", listed):
            heads = re.findall(r"\u2500 ([\w ]+) \u2500", listed[: line.start()])
            assert heads[-1] == group, option


def example_of_system() -> str:
    """Return the system file that its module documents."""
    lines = (system_file.__doc__ or "").splitlines()
    return "\n".join(line[4:] for line in lines if line.startswith("    "))


def write_probes(path: Path) -> None:
    """Write what two probes measure of a whirl at 50 revolutions a second."""
    times = np.arange(2000) / 1000.0
    turn = 100.0 * np.pi * times
    columns = [times, 5.0 * np.cos(turn), 5.0 * np.sin(turn), np.cos(turn) > 0.9]
    np.savetxt(path, np.stack(columns, axis=1), delimiter=",", header="t [s],A,B,keyphasor",
               comments="")  # fmt: skip


def write_run_of_system(path: Path) -> None:
    """Write a run of a rotor with two discs that touches nothing."""
    chain = np.kron(np.array([[8e6, -4e6], [-4e6, 6e6]]), np.eye(2))
    system = rotor_ida.RotorSystem(
        mass=10.0 * np.eye(4), stiffness=chain, nodes={"disc": (0, 1), "seal": (2, 3)}
    )
    far = rotor_ida.Contact(node="seal", clearance=1e-3, stiffness=1e7)
    unbalance = [rotor_ida.Unbalance(node="disc", moment=1e-4)]
    run = rotor_ida.simulate(system, contacts=[far], unbalance=unbalance, speed=300.0, duration=0.2)
    rotor_ida.save(run, path)


@pytest.mark.usefixtures("drawn")
def test_the_examples_run_one_after_the_other(
    program: Program, help_of: Program, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("rotor_ida.paper.reproduction.reproduce", lambda *_, **__: 0)
    monkeypatch.setattr("rotor_ida.explorer.explore.explore", lambda *_, **__: None)
    write_probes(Path("probes.csv"))
    write_run_of_system(Path("system.nc"))
    Path("rotor.toml").write_text(example_of_system())
    for command in COMMANDS:
        for words in examples(help_of(command)):
            answer = program(*words)
            told = "wrote page.html\n" if "--export" in words else ""
            assert (answer.status, answer.err) == (0, told), words
    written = {path.name for path in Path().iterdir()}
    assert {
        "run.nc", "rub.nc", "run.png", "motion.svg", "whirls.nc", "sweep.nc", "folds.nc",
        "hopf_points.svg", "diagram.png", "diagram.extremum.csv", "run_ups.nc", "run_ups.png",
        "basin.nc", "atlas.nc", "atlas.png", "compared.nc", "cycle.nc", "branch.nc", "curve.nc",
        "page.html", "bode.svg", "cascade.png", "orbit.svg", "run.event.csv", "run_up.png",
    } <= written  # fmt: skip


def test_the_example_of_reproduce_names_a_scenario(help_of: Program):
    from rotor_ida.paper.reproduction import scenario_scripts

    (words,) = examples(help_of("reproduce"))
    assert words[words.index("--only") + 1] in scenario_scripts()


def test_help_loads_nothing_heavy():
    code = """
import sys
from rotor_ida.cli import main
main(["simulate", "--help"])
heavy = {"xarray", "sksundae", "matplotlib", "scipy", "pandas"} & set(sys.modules)
sys.exit(f"loaded {heavy}" if heavy else 0)
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, b"")
