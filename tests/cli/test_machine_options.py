"""A rotor without dimensions or a machine in SI units: whole, in one of the two ways."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from typing import Any

import pytest

from rotor_ida.cli.options import AnyRotorOptions
from rotor_ida.model.parameters import DimensionalRotor, Rotor

Program = Callable[..., Any]

ROTOR = {"omega": 1.2, "zeta": 0.07, "delta0": 0.5}
BEYOND = {
    "shaft_stiffness": 0.25, "contact_exponent": 1.0, "contact_damping": 0.5, "load": 0.125,
}  # fmt: skip
MACHINE = {
    "mass": 4.0, "contact_stiffness": 1e6, "damping": 280.0, "eccentricity": 1e-6,
    "clearance": 2e-6, "speed": 600.0,
}  # fmt: skip
BEYOND_IN_SI = {
    "shaft_stiffness": 2.5e5, "contact_exponent": 1.0, "contact_damping": 1e3, "load": 39.2266,
}  # fmt: skip


def test_what_a_machine_has_beside_is_in_the_units_of_the_rest():
    assert AnyRotorOptions(**ROTOR, **BEYOND).chosen() == Rotor(**ROTOR, **BEYOND)
    rubbing = {"friction": 0.2, "disc_radius": 1e-5}
    assert AnyRotorOptions(**ROTOR, **rubbing).chosen() == Rotor(**ROTOR, **rubbing)
    assert AnyRotorOptions(**MACHINE, **rubbing).chosen() == DimensionalRotor(**MACHINE, **rubbing)
    whole = MACHINE | BEYOND_IN_SI
    assert AnyRotorOptions(**whole).chosen() == DimensionalRotor(**whole)


MISTAKES = [
    ({"omega": 1.2, "shaft_stiffness": 0.25}, "got omega, shaft_stiffness"),
    ({**ROTOR, "mass": 4.0, "load": 1.0}, "got omega, zeta, delta0, mass, load"),
    (BEYOND, "got shaft_stiffness, contact_exponent, contact_damping, load"),
    ({**MACHINE, **BEYOND_IN_SI, "delta0": 0.5}, "got delta0, mass, "),
    ({**MACHINE, "contact_exponent": 2.0}, "contact_exponent must be 1.5 or 1, got 2.0"),
    ({**MACHINE, "load": -1.0}, "load must be zero or positive, got -1.0"),
    ({**ROTOR, "delta0": 0.0, "contact_damping": 1.0}, "contact_damping must be 0 without"),
    ({**ROTOR, "friction": 0.1}, "disc_radius must be given with friction, got None"),
]


@pytest.mark.parametrize(("given", "message"), MISTAKES, ids=lambda value: str(value)[:40])
@pytest.mark.parametrize("command", ["touchdown", "explore"])
def test_parts_of_one_and_mixtures_of_both_get_one_line(
    program: Program, command: str, given: dict[str, float], message: str
):
    pairs = ((f"--{name.replace('_', '-')}", repr(value)) for name, value in given.items())
    answer = program(command, *(word for pair in pairs for word in pair))
    assert (answer.status, answer.out) == (2, "")
    assert re.fullmatch(rf"rotor-ida: [^\n]*{re.escape(message)}[^\n]*\n", answer.err)


IN_SI = " ".join(f"--{name.replace('_', '-')} {value!r}" for name, value in MACHINE.items())
WORDS = [*IN_SI.partition(" --speed")[0].split(), "--rtol", "1e-6", "--samples", "2", "--json"]


@pytest.mark.parametrize(
    ("given", "first", "last", "time"),
    [("--speed 6000rpm --to 9000rpm --rate 300000rpm/s", 200.0, 300.0, 0.01),
     ("--speed 200Hz --to 9000rpm --rate -2000Hz/s", 400.0, 300.0, 0.025),
     ("--speed 600 --speeds 0:100Hz 0.01:9000rpm --duration 0.02", 200.0, 300.0, 0.02)],
)  # fmt: skip
def test_a_run_up_takes_and_tells_speeds_as_engineers_do(
    program: Program, given: str, first: float, last: float, time: float
):
    """Speeds in units of pi rad/s by hand: 30 rpm, or half a Hz, are 1."""
    answer = program("run-up", *WORDS, *given.split())
    told = json.loads(answer.out)
    assert told["parameters"]["duration"] == pytest.approx(time, rel=1e-9)
    printed = program("run-up", *WORDS[:-1], *given.split()).out
    assert f"speed [rad/s]        {first * math.pi:.8g} to {last * math.pi:.8g}" in printed
    assert f"speed [rpm]          {first * 30:.8g} to {last * 30:.8g}" in printed


def test_a_speed_has_its_unit_wherever_a_machine_is_given(program: Program):
    for command in ("touchdown", "explore", "run-up"):
        answer = program(command, *IN_SI.partition(" --speed")[0].split(), "--speed", "300rps")
        message = "rotor-ida: the unit of speed must be rad/s, rpm or Hz, got '300rps'\n"
        assert (answer.status, answer.out, answer.err) == (2, "", message)


@pytest.mark.parametrize(
    ("given", "message"),
    [("--omega 1 --zeta 0.07 --delta0 2 --to 300rpm --rate 1",
      "to must have no unit for a rotor without dimensions, got 300 rpm"),
     ("--omega 1 --zeta 0.07 --delta0 2 --speeds 0:1 2:50Hz",
      "speeds must have no unit for a rotor without dimensions, got 50 Hz"),
     (f"{IN_SI} --to 300rps --rate 1", "the unit of to must be rad/s, rpm or Hz, got '300rps'"),
     (f"{IN_SI} --to 900 --rate 1rpm", "the unit of rate must be rad/s2, rpm/s or Hz/s, got"),
     (f"{IN_SI} --to 100rpm --rate 1", "rate must be negative to change the speed from 600 to"),
     (f"{IN_SI} --torque 1 0 --inertia 0 --duration 1", "inertia must be positive, got 0.0")],
)  # fmt: skip
def test_a_change_of_speed_in_units_that_cannot_be_gets_one_line(
    program: Program, given: str, message: str
):
    answer = program("run-up", *given.split())
    assert (answer.status, answer.out) == (2, "")
    assert re.fullmatch(rf"rotor-ida: [^\n]*{re.escape(message)}[^\n]*\n", answer.err)
