"""The words of a command line become the numbers that were meant, or one clear refusal."""

from __future__ import annotations

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


@pytest.mark.parametrize("word", ["1,7", "1_7", "", "0x10", "one", "1.2.3", "1j", "--"])
def test_what_is_no_number_is_shown_as_it_was_given(word: str):
    with pytest.raises(InputError, match=f"^zeta must be a finite real number, got '{word}'$"):
        parsing.number("zeta", [word])


@pytest.mark.parametrize("word", ["1:2", "1:2:3:4", ":", "1:2:"])
def test_a_malformed_range_is_refused(word: str):
    with pytest.raises(InputError, match="omega"):
        parsing.numbers("omega", [word])
