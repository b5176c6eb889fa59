"""Likely slips of a unit are asked about in a line, of machines and of system files alike."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rotor_ida
from rotor_ida.results.plausible import first_critical
from rotor_ida.units import SPEED_UNITS
from tests.cli.conftest import Program
from tests.cli.test_answers import MACHINE, SYSTEM

pytestmark = pytest.mark.filterwarnings("always::UserWarning")
RUN = ("--duration", "1ms")


def notes(answer: Any) -> list[str]:
    """Return the notes of a run that goes on."""
    assert answer.status == 0
    return [line.removeprefix("rotor-ida: note: ") for line in answer.err.splitlines()]


@pytest.mark.parametrize(
    ("right", "slip", "said"),
    [
        ('"3000 rpm"', "10000", "speed is 95,493 rpm, 17 times the critical or running speed: "
         "write 10000rpm if you meant that"),
        ('"150 um"', "0.06", "contacts[0].clearance is 60 mm; those of rotors are below 10 mm; "
         'without a unit it is in m: write "0.06 mm" if you meant that'),
        ('"1e8 N/m"', "5e7", "contacts[0].stiffness is below that of the rotor at 'disc'; without "
         'a unit it is in N/m^1.5, of a Hertz contact: write "5e+07 N/m" if you meant that'),
        ('"200 g mm"', "4000", "unbalance[0].moment is an eccentricity of 333.3 m of the whole "
         'mass; without a unit it is in kg m: write "4000 g mm" if you meant that'),
    ],
    ids=["speed", "clearance", "stiffness", "moment"],
)  # fmt: skip
def test_a_slip_in_a_system_file_is_asked_about(program: Program, right, slip, said):
    Path("rotor.toml").write_text(SYSTEM)
    assert notes(program("simulate", "rotor.toml", *RUN)) == []
    Path("rotor.toml").write_text(SYSTEM.replace(right, slip))
    assert f"rotor.toml: {said}" in notes(program("simulate", "rotor.toml", *RUN))


def test_a_speed_without_a_unit_is_asked_about_where_it_is_far_beyond_the_machine(program: Program):
    Path("pump.toml").write_text(MACHINE)
    Path("rotor.toml").write_text(SYSTEM)
    for rotor in (("--machine", "pump.toml"), ("rotor.toml",)):
        (said,) = notes(program("run-up", *rotor, "--to", "5500", "--in", "1ms"))
        assert said == ("--to is 52,521 rpm, 18 times the critical or running speed: write 5500rpm "
                        "if you meant that")  # fmt: skip
        for plain in ("5500rpm", "5500rad/s", "600"):
            assert notes(program("run-up", *rotor, "--to", plain, "--in", "1ms")) == []


def test_the_first_critical_speed_is_that_of_the_machine():
    machine = rotor_ida.DimensionalRotor(
        mass=12.0, contact_stiffness=1e8, damping=400.0, eccentricity=1e-5, clearance=1e-4,
        speed=300.0, shaft_stiffness=4e6,
    )  # fmt: skip
    system = rotor_ida.RotorSystem(
        mass=12.0 * np.eye(2), stiffness=4e6 * np.eye(2), nodes={"disc": (0, 1)}
    )
    assert first_critical(system) == pytest.approx(machine.critical_speed, rel=1e-12)


def test_units_of_the_inch_system_and_without_blanks_are_read(program: Program):
    """The same machine in pounds and inches, to the digits in which these are defined."""
    inch = ("--mass", "10lb", "--shaft-stiffness", "2e4lbf/in", "--damping", "1lbf s/in",
            "--unbalance", "0.2oz in", "--clearance", "6mil", "--speed", "3000rpm",
            "--contact-stiffness", "1e6lbf/in", "--json")  # fmt: skip
    stiffness = 4.4482216152605 / 0.0254
    si = ("--mass", 4.5359237, "--shaft-stiffness", 2e4 * stiffness, "--damping", stiffness,
          "--unbalance", 0.2 * 0.028349523125 * 0.0254, "--clearance", 6 * 25.4e-6,
          "--speed", 3000 * SPEED_UNITS["rpm"], "--contact-stiffness", f"{1e6 * stiffness}N/m",
          "--json")  # fmt: skip
    both = [json.loads(program("machine", *words).out)["machine"] for words in (inch, si)]
    assert both[0] == pytest.approx(both[1], rel=1e-12)
    Path("rotor.toml").write_text(SYSTEM)
    torque = ("--torque", "3Nm", "0.03Nms", "--inertia", "0.1kgm2", "--duration", "1ms")
    assert notes(program("run-up", "rotor.toml", *torque)) == []
