"""What is handed on: tables, units and words of answers, as their readers expect them."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from rotor_ida.parallel import progress
from tests.cli.conftest import Program

SYSTEM = """
speed = "3000 rpm"
[system]
mass = [12, 12]
stiffness = [4e6, 4e6]
damping = [400, 400]
nodes = { disc = [0, 1] }
[[contacts]]
node = "disc"
clearance = "150 um"
stiffness = "1e8 N/m"
[[unbalance]]
node = "disc"
moment = "200 g mm"
"""
MACHINE = """
mass = "12 kg"
shaft_stiffness = "4e6 N/m"
damping = 400
clearance = "150 um"
unbalance = "200 g mm"
speed = "3000 rpm"
contact_stiffness = "1e8 N/m"
"""
RUN = ("--duration", "1ms")


def test_tables_of_machines_have_their_parameters_in_si_units(program: Program):
    machine = ("--mass", "4kg", "--contact-stiffness", "1e9", "--damping", "280", "--eccentricity",
               "1um", "--clearance", "1.5um", "2um", "--speed", "800")  # fmt: skip
    assert program("sweep", *machine, "--workers", 1, "--csv", "s.csv").status == 0
    head, *rows = [line.split(",") for line in Path("s.csv").read_text().splitlines()]
    table = dict(zip(head, zip(*rows, strict=True), strict=True))
    for name, values in (("speed [rad s-1]", [800.0] * 2), ("clearance [m]", [1.5e-6, 2e-6]),
                         ("damping [N s m-1]", [280.0] * 2)):  # fmt: skip
        assert [float(each) for each in table[name]] == pytest.approx(values, rel=1e-12)


def test_a_system_writes_no_tables_of_its_matrices(program: Program):
    Path("rotor.toml").write_text(SYSTEM)
    assert program("simulate", "rotor.toml", *RUN, "--csv", "run.csv").status == 0
    assert {each.name for each in Path().glob("*.csv")} == {
        f"run.{name}.csv" for name in ("numbers", "t", "event", "episode", "contact")
    }


def test_a_stiffness_is_read_in_meganewtons_and_a_defect_that_does_not_exist_is_left_out(
    program: Program,
):
    Path("pump.toml").write_text(MACHINE)
    assert "shaft stiffness 4 MN/m" in " ".join(
        program("simulate", "--machine", "pump.toml", *RUN).out.split()
    )
    cycle = ("limit-cycle", "--omega", "1.2", "--zeta", "0.07", "--delta0", "0.5", "--start",
             "1", "0", "0", "0")  # fmt: skip
    rubbing = program(*cycle, "--friction", "0.1", "--disc-radius", "30").out
    assert "trivial defect" in rubbing
    assert "symplectic defect" not in rubbing


def test_progress_is_told_in_lines_without_a_terminal(monkeypatch, capfd):
    """Every half a minute, also while nothing is reported."""
    monkeypatch.setattr(progress, "TOLD_EVERY", 0.01)
    said = ""

    def waited(words: str) -> str:
        nonlocal said
        ends = time.monotonic() + 60.0
        while words not in said and time.monotonic() < ends:
            said += capfd.readouterr().err
        return said

    with progress.progress_lines("touchdown") as tell:
        assert "touchdown: nothing done so far\n" in waited("so far")
        tell(0, 50)
        assert "touchdown: 0 of 50\n" in waited("0 of 50\n")
        tell(25, 50)
        assert "touchdown: 25 of 50, about 0 s left\n" in waited("left\n")
