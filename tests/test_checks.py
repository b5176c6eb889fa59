"""What users pass in: clean values come out, anything else gets one clear line."""

import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from rotor_ida.checks import (
    check_array,
    check_axis,
    check_count,
    check_duration,
    check_flag,
    check_nonnegative,
    check_positive,
    check_real,
    check_state,
    check_states,
    check_vector,
    shown,
)
from rotor_ida.errors import InputError


@pytest.mark.parametrize(
    "value",
    [
        1, 1.0, Fraction(1), np.float32(1.0), np.int8(1), np.array(1.0), xr.DataArray(1.0),
        xr.DataArray(1), pd.Series([1.0])[0],
    ],
)  # fmt: skip
def test_real_numbers_of_every_type_become_floats(value):
    assert check_real("omega", value) == 1.0
    assert type(check_real("omega", value)) is float


@pytest.mark.parametrize(
    "value",
    [
        math.nan,
        math.inf,
        True,
        "1",
        None,
        1j,
        [1.0],
        np.array([1.0]),
        10**400,
        np.timedelta64(1, "s"),
        np.datetime64("2019-06-01", "ns"),
        xr.DataArray([1.0]),
        xr.DataArray(True),
    ],
)
def test_anything_else_is_refused_and_shown(value):
    with pytest.raises(InputError) as caught:
        check_real("omega", value)
    message = str(caught.value)
    assert message == f"omega must be a finite real number, got {shown(value)}"
    assert "\n" not in message


@pytest.mark.parametrize(
    "values", [bytearray(b"ab"), memoryview(b"ab"), [bytearray(b"ab")], (b"a", b"b")]
)
def test_bytes_are_no_numbers(values):
    for check in (check_vector, check_array, check_states):
        with pytest.raises(InputError, match="must be numbers, got bytes, "):
            check("omega", values)


@pytest.mark.parametrize("value", [[], 1, 0, None, "yes", np.True_])
def test_a_flag_is_true_or_false(value):
    assert check_flag("check", True) is True
    with pytest.raises(InputError, match="check must be true or false, got "):
        check_flag("check", value)


def test_the_name_of_a_file_keeps_its_blanks_and_is_shortened_in_the_middle():
    assert shown(Path("a  b.nc")) == "'a  b.nc'"
    assert len(shown(Path("a" * 5000))) <= 160
    assert shown("b" * 5000 + ".nc").endswith("b.nc'")


def test_any_value_is_shown_in_one_short_line():
    many = np.arange(1000.0)
    for value in (
        "a\nb" * 1000, 10**400, 10**5000, [10**5000], list(range(1000)), many, 1j, [[0] * 99] * 99,
        xr.DataArray(many, name="omega"), pd.Series(many),
    ):  # fmt: skip
        assert 0 < len(shown(value)) <= 160
        assert "\n" not in shown(value)


def test_signs():
    assert math.copysign(1.0, check_nonnegative("zeta", -0.0)) == 1.0
    with pytest.raises(InputError, match=r"zeta must be zero or positive, got -1.0"):
        check_nonnegative("zeta", -1)
    with pytest.raises(InputError, match=r"mass must be positive, got 0.0"):
        check_positive("mass", 0)
    with pytest.raises(InputError, match=r"mass must be at most 5, got 6.0"):
        check_positive("mass", 6, 5.0)
    with pytest.raises(InputError, match=r"zeta must be at most 5, got 6.0"):
        check_nonnegative("zeta", 6, 5.0)


@pytest.mark.parametrize("value", [2.0, True, "2", None])
def test_counts_are_whole_numbers(value):
    for two in (np.int64(2), np.array(2), xr.DataArray(2)):
        assert type(check_count("samples", two, 2)) is int
    with pytest.raises(InputError, match=r"samples must be a whole number, got"):
        check_count("samples", value)
    with pytest.raises(InputError, match=r"samples must be at least 2, got 1"):
        check_count("samples", 1, 2)
    with pytest.raises(InputError, match=r"samples must be at most 10000000, got 10000001"):
        check_count("samples", 10_000_001)


@pytest.mark.parametrize(
    "value", [(1, 2, 3), (1, 2, 3, 4, 5), "1234", 5, None, {1: 2}, {1, 2, 3, 4}]
)
def test_a_state_has_four_numbers(value):
    for given in (np.arange(4), xr.DataArray(np.arange(4.0)), pd.Series(range(4)), range(4)):
        state = check_state("start", given)
        assert state == (0.0, 1.0, 2.0, 3.0)
        assert {type(number) for number in state} == {float}
    with pytest.raises(InputError, match=r"start must be four numbers \(x, y, vx, vy\), got"):
        check_state("start", value)


def test_an_axis_is_a_number_or_a_sequence():
    assert check_axis("omega", 2).tolist() == [2.0]
    assert check_axis("omega", np.array([1.0, 2.0])).tolist() == [1.0, 2.0]
    assert check_axis("omega", range(3)).tolist() == [0.0, 1.0, 2.0]
    with pytest.raises(InputError, match=r"omega must be zero or positive, got -1.0"):
        check_axis("omega", [1.0, -1.0])
    assert check_axis("omega", xr.DataArray([1, 2])).tolist() == [1.0, 2.0]
    assert check_axis("omega", pd.Series([1.0, 2.0])).tolist() == [1.0, 2.0]
    assert check_axis("omega", (xr.DataArray(1.0), Fraction(1, 2))).tolist() == [1.0, 0.5]
    with pytest.raises(InputError, match=r"omega must be a finite real number, got True"):
        check_axis("omega", [1.0, True])
    with pytest.raises(InputError, match=r"omega must be at most 5, got 6.0"):
        check_axis("omega", [1, 6], largest=5.0)
    with pytest.raises(InputError, match=r"omega must be 0 or between 1 and 5, got 0.5"):
        check_axis("omega", [0, 0.5], smallest=1.0, largest=5.0)


@pytest.mark.parametrize("values", [np.ones((2, 2)), [[1, 1], [1, 1]], xr.DataArray(np.eye(2))])
def test_more_than_one_dimension_is_refused_with_its_shape(values):
    message = r"^omega must be a number or a vector of numbers, got an array of shape \(2, 2\)$"
    with pytest.raises(InputError, match=message):
        check_vector("omega", values)
    assert check_array("omega", values).shape == (2, 2)


def test_starts_are_rows_of_any_kind():
    rows = [(0.0, 1.0, 2.0, 3.0), (4.0, 5.0, 6.0, 7.0)]
    for given in (
        rows,
        np.array(rows),
        xr.DataArray(rows),
        [xr.DataArray(list(row)) for row in rows],
    ):
        assert check_states("starts", given) == rows
    with pytest.raises(InputError, match=r"starts must be a sequence of starts, got 5"):
        check_states("starts", 5)
    with pytest.raises(InputError, match=r"starts must contain at least one start, got none"):
        check_states("starts", [])
    with pytest.raises(
        InputError, match=r"start must be four numbers \(x, y, vx, vy\), got \(1, 2\)"
    ):
        check_states("starts", [(0, 0, 0, 0), (1, 2)])


@pytest.mark.parametrize("omega", [0.0, 1.7, 1e3])
def test_a_duration_is_refused_where_doubles_no_longer_tell_phases_apart(omega):
    """The bound in the message is the first time that is refused."""
    with pytest.raises(InputError, match=r"^duration must be below .* got 1e\+100$") as caught:
        check_duration("duration", 1e100, omega)
    bound = 2.0 ** round(math.log2(float(str(caught.value).split()[4])))
    assert np.spacing(bound) > 1e-6 / max(omega, 1.0)
    assert check_duration("duration", np.nextafter(bound, 0.0), omega) < bound
    with pytest.raises(InputError):
        check_duration("duration", bound, omega)


def test_numbers_are_counted_along_every_axis_before_they_are_read():
    wide = np.broadcast_to(0.5, (2, 1_000_000_000))
    with pytest.raises(InputError, match="speeds must contain at most 10000000 numbers, got"):
        check_array("speeds", wide)


def test_longer_floats_beyond_doubles_are_refused_without_a_warning():
    if np.finfo(np.longdouble).max > np.finfo(float).max:
        values = np.array([1.0, np.finfo(np.longdouble).max], dtype=np.longdouble)
        with pytest.raises(InputError, match="omega must be a finite real number, got"):
            check_array("omega", values)
    exact = check_array("omega", np.array([2.0], dtype=np.longdouble))
    assert (exact.dtype, exact.tolist()) == (np.dtype(np.float64), [2.0])
