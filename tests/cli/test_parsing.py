"""The words of a command line become the numbers that were meant, or one clear refusal."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from rotor_ida.cli import parsing
from rotor_ida.errors import InputError


@pytest.mark.parametrize(
    ("word", "start", "stop", "count"),
    [("0.1:3:30", 0.1, 3.0, 30), ("3:0.1:7", 3.0, 0.1, 7), ("1:1:2", 1.0, 1.0, 2)],
)
def test_a_range_is_numpys_to_the_last_bit(word: str, start: float, stop: float, count: int):
    assert parsing.numbers("omega", [word]) == np.linspace(start, stop, count).tolist()


def test_numbers_and_ranges_mix_in_the_order_given():
    assert parsing.numbers("omega", ["5", "1:2:2", "0.1"]) == [5.0, 1.0, 2.0, 0.1]


@pytest.mark.parametrize("word", ["1e-3", "1E-3", ".001", "+0.001"])
def test_a_number_may_be_written_in_any_usual_way(word: str):
    assert parsing.number("zeta", [word]) == 0.001


@pytest.mark.parametrize("word", ["1_7", "", "0x10", "one", "1.2.3", "1j", "--"])
def test_what_is_no_number_is_shown_as_it_was_given(word: str):
    with pytest.raises(InputError, match=f"^zeta must be a finite real number, got '{word}'$"):
        parsing.number("zeta", [word])


@pytest.mark.parametrize("word", ["1:2", "1:2:3:4", ":", "1:2:"])
def test_a_malformed_range_is_refused(word: str):
    with pytest.raises(InputError, match="omega"):
        parsing.numbers("omega", [word])


@pytest.mark.parametrize(
    ("word", "unit", "value"),
    [
        ("12kg", "kg", 12.0), ("12 kg", "kg", 12.0), ("60um", "m", 60e-6), ("150 um", "m", 150e-6),
        ("60mm", "m", 60e-3), ("1e8N/m", "N m-1", 1e8), ("4e6 N/m", "N m-1", 4e6),
        ("415Ns/m", "N s m-1", 415.0), ("20s", "s", 20.0), ("50Hz", "rad s-1", 100.0 * math.pi),
        ("3600rpm", "rad s-1", 120.0 * math.pi), ("-1.5E-1mm", "m", -150e-6), ("1e-3", "m", 1e-3),
    ],
)  # fmt: skip
def test_a_value_with_its_unit_is_in_si_units(word: str, unit: str, value: float):
    assert parsing.quantity("it", [word], unit) == pytest.approx(value, rel=4e-16)


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("12mm", "the unit of mass must be kg, g or lb, got '12mm'"),
        ("12 furlongs", "the unit of mass must be kg, g or lb, got '12 furlongs'"),
        ("heavy", "mass must be a finite real number, got 'heavy'"),
        ("1e999kg", "mass must be a finite real number, got inf"),
        ("1.2.3kg", "mass must be a finite real number, got '1.2.3kg'"),
        ("1,2kg", "mass must have no comma, got '1,2kg': write '1.2kg' with a point"),
    ],
)
def test_a_value_of_another_dimension_or_none_gets_one_line(word: str, message: str):
    with pytest.raises(InputError, match=f"^{re.escape(message)}$"):
        parsing.quantity("mass", [word], "kg")


def test_a_number_that_has_no_unit_takes_none():
    with pytest.raises(InputError, match=r"^omega must be a number without a unit, got '50Hz'$"):
        parsing.number("omega", ["50Hz"])


def test_a_unit_apart_from_its_number_is_joined_to_it_and_nothing_else_is():
    line = "touchdown --mass 12 kg --damping 4 N s/m --x -1 um --samples 3 probes.csv --only 2 m3"
    joined = [parsing.as_given(word) for word in parsing.readable(line.split())]
    assert joined == ["touchdown", "--mass", "12 kg", "--damping", "4 N s/m", "--x", "-1 um",
                      "--samples", "3", "probes.csv", "--only", "2 m3"]  # fmt: skip
