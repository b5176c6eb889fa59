"""A rotor without dimensions or a machine in SI units: whole, in one of the two ways."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest

from rotor_ida.cli.options import MachineOptions
from rotor_ida.parameters import DimensionalRotor, Rotor

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
    assert MachineOptions(**ROTOR, **BEYOND).machine() == Rotor(**ROTOR, **BEYOND)
    rubbing = {"friction": 0.2, "disc_radius": 1e-5}
    assert MachineOptions(**ROTOR, **rubbing).machine() == Rotor(**ROTOR, **rubbing)
    assert MachineOptions(**MACHINE, **rubbing).machine() == DimensionalRotor(**MACHINE, **rubbing)
    whole = MACHINE | BEYOND_IN_SI
    assert MachineOptions(**whole).machine() == DimensionalRotor(**whole)


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
