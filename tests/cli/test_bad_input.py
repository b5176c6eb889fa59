"""Every mistake gets exactly one line on standard error, status 2, and leaves nothing behind."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any, get_args

import pytest
from cyclopts import Token

from rotor_ida.cli.program import application
from rotor_ida.errors import InputError
from tests.cli.conftest import Program, is_refused
from tests.cli.test_help import COMMANDS

# Lines that are right, by command; a test changes their options.
RIGHT = {
    "simulate": {"omega": "1.2", "zeta": "0.07", "delta0": "0.5", "start": "0 0 0 0",
                 "duration": "1"},
    "run-ups": {"omega": "0.5", "to": "2", "rate": "0.1", "zeta": "0.1", "delta0": "2"},
    "sweep": {"omega": "1", "zeta": "0.5", "delta0": "0"},
    "cycle": {"omega": "2", "zeta": "0.07", "delta0": "2"},
    "continue": {"from": "{cycle}", "limits": "1 3"},
    "curve": {"from": "{cycle}", "kind": "period_doubling", "limits": "1.9 2.1 1.9 2.1"},
}  # fmt: skip


def line_of(command: str, **changes: str) -> str:
    """Return a line that is right but for the changes."""
    return " ".join([command, *(f"--{name} {each}" for name, each in
                                (RIGHT[command] | changes).items())])  # fmt: skip


simulate, run_ups, sweep, cycle, follow, turn = (partial(line_of, command) for command in RIGHT)


def run_up(given: str, omega: str = "0.5") -> str:
    return f"run-up --omega {omega} --zeta 0.07 --delta0 0.5 {given}"


DIAGRAM = "bifurcation-diagram --omega 1 --zeta 0.1 --delta0 1"
FINITE = "must be a finite real number, got"
MISTAKES = [
    # values
    (simulate(omega="nan"), f"omega {FINITE} nan"),
    (simulate(omega="1,2"), "omega must have no comma, got '1,2': write '1.2' with a point"),
    (simulate(samples="\u0661\u0662"), "samples must be a whole number, got '\u0661\u0662'"),
    (f"show {'a' * 100_000}", "path must be a shorter path, got 'aaa"),
    (simulate(out="a" * 5000 + ".nc"), "out must be a shorter path, got 'aaa"),
    (simulate(delta0="1e-100"), "delta0 must be 0 or at least 1e-12 to be simulated, got 1e-100"),
    ("reproduce --out taken.nc", "out must be a folder, got 'taken.nc'"),
    ("reproduce --out taken.nc/deeper", "out must be a folder, got 'taken.nc/deeper'"),
    (follow(**{"from": "{run}"}), "run.nc', of the kind run"),
    (simulate(omega="1 2"), "unexpected argument '2'"),
    (simulate(start="1 2 3"), "start must be four numbers X Y VX VY, settled or rest, got 3"),
    (simulate(start="1 2 3 4 5"), "unexpected argument '5'"),
    (simulate(start=""), "--start must be given a value"),
    (
        simulate(start="setled"),
        "start must be four numbers X Y VX VY, settled or rest, got 'setled'; "
        "did you mean 'settled'?",
    ),
    (simulate(start="0 0 0 0 --start 1 0 0 0"), "--start specified multiple times"),
    (simulate(samples="1000000000000"), "samples must be at most 10000000"),
    (simulate(rtol="0.5"), "rtol must lie from"),
    (
        simulate(method="taylor", flight="cvode"),
        "flight must be 'exact' with taylor, got 'cvode'",
    ),
    # ranges and grids
    ("response --omega 1:2 --zeta 0 --delta0 0", "omega must be numbers or START:STOP:COUNT"),
    ("response --omega 0:1:9999 --zeta 0:1:9999 --delta0 0", "the grid must have at most"),
    ("response --zeta 0 --delta0 0", "--omega must be given with --zeta and --delta0"),
    ("folds --zeta 0.1 --delta0 0 --omega 1", "omega must be left out: all speeds are searched"),
    ("hopf-points", "--zeta and --delta0 must be given, or a machine in SI units"),
    ("folds --zeta 0.1 --delta0 1 --load 1", "--load must be 0 for folds"),
    (f"{DIAGRAM} --start 0 0 0 0 --starts 3", "starts must be left out with --start, got 3"),
    (f"{DIAGRAM} --rate 1", "--direction must be given with --rate"),
    (f"{DIAGRAM} --x 3um:5um", "x must have no unit for a dimensionless rotor, got '3um'"),
    ("response --omega --zeta 0 --delta0 0", "omega must"),
    # a unit at some numbers only
    (
        "campbell rotor.toml --speed 4500rpm:9000:3",
        "speed must have a unit at each number or at none, got '4500rpm:9000:3'",
    ),
    (
        "special-speeds rotor.toml --limits 3000rpm 900",
        "limits must have a unit at each number or at none, got '3000rpm 900'",
    ),
    (
        "continue rotor.toml --parameter clearance --limits 120um 200",
        "limits must have a unit at each number or at none, got '120um 200'",
    ),
    (
        simulate(start="10um 5 0 0"),
        "start must have a unit at each number or at none, got '10um 5 0 0'",
    ),
    (
        "run-up --machine pump.toml --speeds 0:300rpm 1:400",
        "speeds must have a unit at each number or at none, got '0:300rpm 1:400'",
    ),
    (
        "basin-fractions --machine pump.toml --starts 9 --x=-15um:15 --y 0",
        "x must have a unit at each number or at none, got '-15um:15'",
    ),
    (
        "explore --omega 2 --zeta 0.07 --delta0 2 --export page.html --speeds 3000rpm",
        "speeds must have no unit for a dimensionless rotor, got '3000rpm'",
    ),
    ("basin --omega 1 --zeta 1 --delta0 1 --x 0:1 --y 0:1:5", "x must be numbers or START:STOP"),
    # sweeps
    (
        "sweep --mass 4 5 --contact-stiffness 1e9 --damping 280 --eccentricity 1um "
        "--clearance 2um --speed 800",
        "mass must be one number, as it sets the scales of all machines, got 2",
    ),
    (sweep(omega="2 1", direction="up"), "omega must increase"),
    (sweep(executor="serial", workers="2"), "workers must be 1 with executor 'serial', got 2"),
    # run-ups
    (run_ups(to="0.5"), "to must differ from the rotor's omega 0.5, got 0.5"),
    (
        run_ups(rate="0.1:0.3:4", delta0="1:2:13", figure="many"),
        "figure can show at most 12 combinations of zeta, delta0 and other parameters, got 13",
    ),
    # limit cycles
    (cycle(period="1"), "start and period must be near a limit cycle: Newton's method came to a"),
    (
        follow(limits="3 1"),
        "limits of omega must be two increasing numbers from 0 on, got (3.0, 1.0)",
    ),
    (follow(limits="2.5 3"), "limits of omega must contain that of the start, 2.0, got (2.5, 3.0)"),
    (follow(parameter="mass"), "'stiffness', 'unbalance', got 'mass'"),
    (follow(point="3"), "point and special must be left out with a cycle"),
    (follow(**{"from": "{branch}"}), "--point or --special must be given with a branch"),
    (follow(**{"from": "{branch}"}, point="999"), "point must be from 0 to"),
    (follow(**{"from": "{branch}"}, special="2"), "special must be from 0 to 1, got 2"),
    (follow(**{"from": "{branch}"}, special="1", point="1"), "special must be left out with"),
    (follow(**{"from": "missing.nc"}), "must be a file that exists, got 'missing.nc'"),
    (follow(omega="2"), "omega must be left out with --from"),
    ("continue --limits 1 3", "a rotor must be given, or a file with --from"),
    ("continue --omega 2 --zeta 0.07 --delta0 2 --point 1 --limits 1 3", "point must be left out"),
    ("continue --from {cycle}", "--limits must be given"),
    (
        "continue --omega 1.2 --zeta 0.07 --delta0 2 --limits 1 3",
        "start must lead to a limit cycle, got one from which the response is contact_free",
    ),
    (
        "continue --omega 2 --zeta 0.07 --delta0 2 --period 1 --limits 1 3",
        "start and period must be near a limit cycle",
    ),
    (turn(kind="fold"), "limits must contain a fold of the branch through the start, got none"),
    # speeds that change
    (
        run_up(""),
        "the speed must change in one way, by to and rate or --ramp-time, by speeds, or by",
    ),
    (run_up("--to 2 --rate 0.1 --in 5"), "rate must be left out with --ramp-time, got 0.1"),
    (run_up("--in 5"), "--to must be given with --ramp-time"),
    (run_up("--from 1 --to 2 --in 5"), "omega must be left out with --from, got both"),
    (run_up("--to 2"), "--rate or --ramp-time must be given with --to"),
    (run_up("--torque 1 0 --inertia 2"), "--duration must be given with --torque"),
    (run_up("--speeds 0:1 2:2 1:3"), "times of speeds must increase, got 1.0 after 2.0"),
    (run_up("--speeds 1 2"), "speeds must be pairs TIME:SPEED, got '1'"),
    ("run-up --omega 1 --zeta 1 --delta0 1 --torque 1 0", "--inertia must be given with --torque"),
    (
        run_up("--to 300rpm --rate 1"),
        "to must have no unit for a dimensionless rotor, got '300rpm'",
    ),
    (simulate(load="weight"), "load must have no unit for a dimensionless rotor"),
    (simulate(load="heavy"), "load must be a finite real number, got 'heavy'"),
    ("hopf-points --zeta 0.1 --delta0 1 --load 1", "--load must be 0 for hopf-points"),
    (
        "touchdown --omega 2 --zeta 0.05 --delta0 1 --shaft-stiffness 0.25 --load 0.6 --x=-1:1 "
        "--shocks 64",
        "--shocks must be 0 under a load, got 64",
    ),
    # words
    ("fly", "unknown command 'fly'; see rotor-ida --help"),
    ("cycel", "unknown command 'cycel'; did you mean 'cycle'?"),
    ("simulate", "--omega, --zeta, --delta0 and --duration must be given"),
    ("simulate --zeta=1 --duration 1", "--omega and --delta0 must be given with --zeta"),
    ("simulate --clearance=1", "--mass, --contact-stiffness, --damping, --eccentricity, --speed"),
    ("simulate --duration 1", "--omega, --zeta and --delta0 must be given, or a machine"),
    ("sweep --omega 1 --mass 3", "must be given without dimensions or in SI units, got omega and"),
    (simulate(method="adam"), "got 'adam'; did you mean 'adams'?"),
    ("simulate --omega", "--omega must be given a value"),
    ("simulate --omga 1", "unknown option '--omga'; did you mean '--omega'?"),
    (simulate() + " --smaples 3", "unknown option '--smaples'; did you mean '--samples'?"),
    (simulate() + " --omega 2", "--omega specified multiple times"),
    ("compare", "FILE must be given"),
    ("fit --omega 1 --zeta 0.1 --delta0 1 --unknown zeta", "FILE must be given"),
    ("curve --from {cycle}", "--kind and --limits must be given"),
    # files to write
    (simulate(out="taken.nc"), "'taken.nc' already exists; pass --force to replace it"),
    (simulate(out="nowhere/run.nc"), "out must be in a folder that exists, got 'nowhere/run.nc'"),
    (simulate(out="folder.nc"), "out must be a file, got the folder 'folder.nc'"),
    (simulate(out="run.png"), "out must end in .nc, got 'run.png'"),
    (simulate(out=""), "--out must be given a value"),
    (simulate(figure="taken"), "already exists; pass --force to replace it"),
    (simulate(figure=".."), "figure must be NAME, NAME.png, NAME.svg or NAME.pdf, got '..'"),
    (
        simulate(figure="run.gif"),
        "figure must be NAME, NAME.png, NAME.svg or NAME.pdf, got 'run.gif'",
    ),
    (
        "response --omega 1 --zeta 0:1:4 --delta0 0:1:4 --figure a.png",
        "at most 12 combinations of zeta, delta0 and other parameters, got 16",
    ),
    (simulate(csv="taken.csv"), "'taken.csv' already exists; pass --force to replace it"),
    (
        simulate(csv="parts.csv"),
        "'parts.event.csv' already exists; pass --force to replace it",
    ),
    (simulate(csv="a.txt"), "csv must end in .csv, got 'a.txt'"),
    # files to read
    ("show nothing.nc", "must be a file that exists, got 'nothing.nc'"),
    ("from-ross none.toml --out rotor.toml", "file must be a file that exists, got 'none.toml'"),
    ("show .", "must be a file, got the folder '.'"),
    ("show {text}", "is not an archive of rotor_ida"),
    ("show {empty}", "is not an archive of rotor_ida: it is not netCDF-4"),
    ("show {cut}", "is damaged, was altered or is not an archive"),
    (
        "show {report} --figure a.png",
        "figure must be of one of the kinds drop, drop_ensemble",
    ),
    ("compare {run}", "compare needs a sweep"),
    ("compare {text}", "is not an archive of rotor_ida"),
    ("compare {sweep} --out {sweep} --force", "out must not be the file that is compared"),
    # plots
    ("plot {run} --order 2", "--kind must be given with --order"),
    ("plot {run} --exact", "--kind must be given with --exact"),
    ("plot {run} --kind cascde --figure a", "got 'cascde'; did you mean 'cascade'?"),
    ("plot {run} --kind trace --figure a --times 1s 2s", "times must have no unit, got '1s'"),
    (
        "plot {run} --kind orbit --figure a --clearance 1um",
        "clearance must have no unit, got '1um': the data have none; a measured file is given its ",
    ),
    ("plot {run} --kind orbit --figure a --order 2", "order must be left out with --kind orbit"),
    ("plot {run} --kind bode --figure a --span 2", "span must be left out with --kind bode"),
    ("plot {run} --kind trace --figure a --rate 5", "rate must be left out with an archive, got"),
    ("plot {sweep} --kind trace --figure a", "file must contain a run, a run-up or signals"),
    ("plot nothing.csv --kind trace --figure a", "must be a file that exists, got 'nothing.csv'"),
    ("plot taken.png --kind trace --figure a", "must have lines of two numbers or more, got none"),
    (
        "plot {run} --kind trace --figure a --columns x",
        "columns must be pairs such as x=..., got 'x'",
    ),
    (
        "plot nothing.csv --kind trace --figure a --columns x=A x=B",
        "columns must give x once, got it twice",
    ),
    # reproduce
    ("reproduce --only fig06_jump fig6_jumps", "got 'fig6_jumps'; did you mean 'fig06_jumps'?"),
]


def kinds_in(hint: object) -> set[object]:
    """Return the plain types in a type."""
    parts = [each for each in get_args(hint) if each not in {type(None), ...}]
    return set().union(*map(kinds_in, parts)) if parts else {hint}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_for_numbers_refuses_what_is_no_number(command: str):
    """Not a number, digits of another script, Python's underscores, a comma and a word."""
    found = [each for each in application(command)[command].assemble_argument_collection()
             if kinds_in(each.hint) <= {int, float} and each.parameter.converter]  # fmt: skip
    for option in found:
        read: Any = option.parameter.converter
        for word in ("nan", "1_7", "\u0661", "1,2", "fast", "-inf"):
            tokens = [Token(keyword=option.name, value=word)] * max(1, option.token_count()[0])
            name = option.name.removeprefix("--")
            with pytest.raises(InputError, match=f"{name}.* must (be|have)"):
                read(option.hint, tokens)


@pytest.mark.parametrize(("line", "message"), MISTAKES, ids=[line for line, _ in MISTAKES])
def test_a_mistake_gets_one_line(program: Program, archives: Path, line: str, message: str):
    Path("taken.nc").write_text("mine")
    Path("taken.png").write_text("mine")
    Path("taken.csv").touch()
    Path("parts.event.csv").touch()
    Path("folder.nc").mkdir()
    before = sorted(Path().rglob("*"))
    names = ("run", "sweep", "report", "text", "empty", "cut", "cycle", "branch")
    is_refused(program, line.format(**{name: archives / f"{name}.nc" for name in names}), message)
    assert sorted(Path().rglob("*")) == before
    assert Path("taken.nc").read_text() == Path("taken.png").read_text() == "mine"


ROTOR = "--omega 1.2 --zeta 0.07 --delta0 {delta0}"
MACHINE = (
    "--mass 4 --contact-stiffness 1e9 --damping 280 --eccentricity 1e-6 --clearance {delta0} "
    "--speed 1000"
)
WITH_FRICTION = {
    "simulate": f"simulate {ROTOR} --duration 5",
    "folds": "folds --zeta 0.07 --delta0 {delta0}",
    "sweep": f"sweep {ROTOR}",
    "touchdown of a machine": f"touchdown {MACHINE}",
    "explore": f"explore {ROTOR} --export page.html --speeds 1:1.2:2",
}
FRICTION = [
    ("0.5", "--friction 0.1", "--disc-radius must be given with --friction"),
    ("0.5", "--friction nan --disc-radius 10", "friction must be a finite real number, got nan"),
    ("0.5", "--friction 0.1 --disc-radius -1", "--disc-radius must be zero or positive, got -1"),
    ("0", "--friction 0.1 --disc-radius 10", "friction must be 0 without clearance, where the "),
]  # fmt: skip


@pytest.mark.parametrize("command", WITH_FRICTION)
def test_what_is_wrong_with_friction_gets_one_line_from_every_command(
    program: Program, command: str
):
    for delta0, given, message in FRICTION:
        if command == "folds" and "--disc-radius" not in given:  # whirls slip, whatever the disc
            continue
        line = f"{WITH_FRICTION[command].format(delta0=delta0)} {given}"
        is_refused(program, line, message)
    assert not list(Path().iterdir())


def test_an_empty_word_is_no_number_and_no_path(program: Program):
    assert "got ''" in program("response", "--omega", "", "--zeta", 0, "--delta0", 0).err
    assert "out must be a path, got ''" in (
        program("response", "--omega", 1, "--zeta", 0, "--delta0", 0, "--out", "").err
    )


def test_what_can_be_written_is_asked_before_anything_is_computed(
    program: Program, monkeypatch: pytest.MonkeyPatch
):
    def never(*_args: object, **_options: object) -> None:
        raise AssertionError("it was computed")

    monkeypatch.setattr("rotor_ida.simulate", never)
    monkeypatch.setattr("rotor_ida.sweep", never)
    for command in (simulate(out="nowhere/a.nc"), sweep(figure="nowhere/a.png")):
        assert program(*command.split()).status == 2


def test_a_backend_that_matplotlib_does_not_know_is_refused():
    ended = subprocess.run(
        [sys.executable, "-c", "import rotor_ida.plot"], capture_output=True, text=True,
        check=False, env=os.environ | {"MPLBACKEND": "nonsense"},
    )  # fmt: skip
    said = "MPLBACKEND must name a backend of matplotlib, such as agg, got 'nonsense'"
    assert ended.stderr.splitlines()[-1] == f"rotor_ida.errors.InputError: {said}"
