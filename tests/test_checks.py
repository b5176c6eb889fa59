"""What users pass in: clean values come out, anything else gets one clear line."""

import math

import numpy as np
import pytest

from rotor_ida.checks import (
    check_array,
    check_axis,
    check_choice,
    check_count,
    check_duration,
    check_nonnegative,
    check_positive,
    check_real,
    check_state,
    check_states,
    check_vector,
    shown,
)
from rotor_ida.errors import InputError


@pytest.mark.parametrize("value", [1, 1.0, np.float32(1.0), np.int8(1), np.array(1.0)])
def test_real_numbers_of_every_type_become_floats(value):
    assert check_real("omega", value) == 1.0
    assert type(check_real("omega", value)) is float


@pytest.mark.parametrize(
    "value", [math.nan, math.inf, True, "1", None, 1j, [1.0], np.array([1.0]), 10**400]
)
def test_anything_else_is_refused_and_shown(value):
    with pytest.raises(InputError) as caught:
        check_real("omega", value)
    message = str(caught.value)
    assert message == f"omega must be a finite real number, got {value!r}"
    assert "\n" not in message


def test_signs():
    assert math.copysign(1.0, check_nonnegative("zeta", -0.0)) == 1.0
    with pytest.raises(InputError, match=r"zeta must be zero or positive, got -1.0"):
        check_nonnegative("zeta", -1)
    with pytest.raises(InputError, match=r"mass must be positive, got 0.0"):
        check_positive("mass", 0)


@pytest.mark.parametrize("value", [2.0, True, "2", None])
def test_counts_are_whole_numbers(value):
    assert check_count("samples", np.int64(2), 2) == 2
    with pytest.raises(InputError, match=r"samples must be a whole number, got"):
        check_count("samples", value)
    with pytest.raises(InputError, match=r"samples must be at least 2, got 1"):
        check_count("samples", 1, 2)


def test_choices_are_listed():
    with pytest.raises(InputError, match=r"method must be one of 'a', 'b', got 3"):
        check_choice("method", 3, ("a", "b"))


@pytest.mark.parametrize("value", [(1, 2, 3), (1, 2, 3, 4, 5), "1234", 5, None, {1: 2}])
def test_a_state_has_four_numbers(value):
    assert check_state("start", np.arange(4)) == (0.0, 1.0, 2.0, 3.0)
    with pytest.raises(InputError, match=r"start must be four numbers \(x, y, vx, vy\), got"):
        check_state("start", value)


def test_an_axis_is_a_number_or_a_sequence():
    assert check_axis("omega", 2).tolist() == [2.0]
    assert check_axis("omega", np.array([1.0, 2.0])).tolist() == [1.0, 2.0]
    assert check_axis("omega", range(3)).tolist() == [0.0, 1.0, 2.0]
    with pytest.raises(InputError, match=r"omega must be zero or positive, got -1.0"):
        check_axis("omega", [1.0, -1.0])
    with pytest.raises(InputError, match=r"omega must be a finite real number, got"):
        check_axis("omega", np.ones((2, 2)))
