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


@pytest.mark.parametrize("value", [1, Fraction(1), np.float32(1.0), np.int8(1), xr.DataArray(1)])
def test_numbers_of_every_type_become_floats(value):
    assert check_real("omega", value) == 1.0
    assert type(check_real("omega", value)) is float
    assert math.copysign(1.0, check_nonnegative("zeta", -0.0)) == 1.0
    for two in (np.int64(2), np.array(2), xr.DataArray(2)):
        assert type(check_count("samples", two, 2)) is int


def test_vectors_of_every_type_become_floats():
    rows = [(0.0, 1.0, 2.0, 3.0), (4.0, 5.0, 6.0, 7.0)]
    for row in (np.arange(4), xr.DataArray(np.arange(4.0)), pd.Series(range(4)), range(4)):
        assert check_state("start", row) == rows[0]
        assert {type(number) for number in check_state("start", row)} == {float}
    for given in (rows, np.array(rows), xr.DataArray(rows), [xr.DataArray(list(each))
                                                             for each in rows]):  # fmt: skip
        assert check_states("starts", given) == rows
    for axis in (np.array([1.0, 2.0]), xr.DataArray([1, 2]), pd.Series([1.0, 2.0]), range(1, 3),
                 (xr.DataArray(1.0), Fraction(2))):  # fmt: skip
        assert check_axis("omega", axis).tolist() == [1.0, 2.0]
    assert check_axis("omega", 2).tolist() == [2.0]


STATE = r"must be four numbers \(x, y, vx, vy\), got"


@pytest.mark.parametrize(
    ("check", "value", "message"),
    [
        *((check_real, value, "must be a finite real number, got") for value in
          (math.nan, True, "1", None, 1j, [1.0], 10**400, np.timedelta64(1, "s"),
           xr.DataArray([1.0]), xr.DataArray(True))),
        *((check, value, "must be numbers, got bytes, ") for check in
          (check_vector, check_array, check_states) for value in
          (bytearray(b"ab"), memoryview(b"ab"), (b"a", b"b"))),
        *((check_flag, value, "must be true or false, got ") for value in (1, None, np.True_)),
        *((check_count, value, "must be a whole number, got") for value in (2.0, True, "2", None)),
        (check_count, 10_000_001, "must be at most 10000000, got 10000001"),
        *((check_state, value, STATE) for value in ((1, 2, 3), "1234", 5, {1: 2}, {1, 2, 3, 4})),
        (check_states, [(0, 0, 0, 0), (1, 2)], ""),
        (check_states, 5, "must be a sequence of starts, got 5"),
        (lambda *given: check_positive(*given, 5.0), 6, "must be at most 5, got 6.0"),
        (lambda *given: check_nonnegative(*given, 5.0), 6, "must be at most 5, got 6.0"),
        (lambda *given: check_axis(*given, smallest=1.0, largest=5.0), [0, 0.5],
         "must be 0 or between 1 and 5, got 0.5"),
        (check_axis, [1.0, True], "must be a finite real number, got True"),
        (check_vector, xr.DataArray(np.eye(2)),
         r"must be a number or a vector of numbers, got an array of shape \(2, 2\)$"),
        (check_array, np.broadcast_to(0.5, (2, 1_000_000_000)), "must contain at most 10000000 nu"),
    ],
)  # fmt: skip
def test_anything_else_is_refused_in_one_line(check, value, message):
    with pytest.raises(InputError, match=f"^(given|start) {message}") as caught:
        check("given", value)
    assert "\n" not in str(caught.value)


def test_any_value_is_shown_in_one_short_line():
    many = np.arange(1000.0)
    for value in (
        "a\nb" * 1000, 10**400, 10**5000, [10**5000], list(range(1000)), many, 1j, [[0] * 99] * 99,
        xr.DataArray(many, name="omega"), pd.Series(many), Path("a" * 5000),
    ):  # fmt: skip
        assert 0 < len(shown(value)) <= 160
        assert "\n" not in shown(value)
    assert shown(Path("a  b.nc")) == "'a  b.nc'"
    assert shown("b" * 5000 + ".nc").endswith("b.nc'")


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


def test_longer_floats_beyond_doubles_are_refused_without_a_warning():
    if np.finfo(np.longdouble).max > np.finfo(float).max:
        values = np.array([1.0, np.finfo(np.longdouble).max], dtype=np.longdouble)
        with pytest.raises(InputError, match="omega must be a finite real number, got"):
            check_array("omega", values)
    exact = check_array("omega", np.array([2.0], dtype=np.longdouble))
    assert (exact.dtype, exact.tolist()) == (np.dtype(np.float64), [2.0])
