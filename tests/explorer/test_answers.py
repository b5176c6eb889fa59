"""A message is read again as what was packed into it."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rotor_ida.explorer.answers import Answer, packed
from tests.explorer.asking import HEADER, unpacked

KINDS = st.sampled_from([np.float64, np.float32, np.int8])
ARRAYS = KINDS.flatmap(lambda kind: arrays(kind, st.integers(0, 20)))


@given(st.dictionaries(st.text(), ARRAYS, max_size=5), st.text())
def test_arrays_come_back_bit_for_bit(given_arrays: dict[str, np.ndarray], note: str):
    message = unpacked(packed(Answer("motion", {"note": note}, given_arrays)))
    assert message.header["part"] == "motion"
    assert message.facts == {"note": note}
    assert list(message.arrays) == list(given_arrays)
    for name, values in given_arrays.items():
        assert message.arrays[name].dtype == values.dtype
        assert message.arrays[name].tobytes() == values.tobytes()


@given(st.integers(0, 30), st.integers(0, 9))
def test_every_array_begins_at_a_multiple_of_eight_bytes(length: int, size: int):
    given_arrays = {"a": np.zeros(size, np.int8), "b": np.zeros(3), "c": np.zeros(1, np.float32)}
    message = packed(Answer("x" * length, {}, given_arrays))
    behind = HEADER + int.from_bytes(message[:HEADER], "little")
    places = json.loads(message[HEADER:behind])["arrays"]
    assert [(behind + offset) % 8 for _, offset, _ in places.values()] == [0, 0, 0]


def test_what_is_not_finite_is_null_in_the_header_and_itself_in_an_array():
    facts = {"period": math.nan, "list": [math.inf, 1.0], "deep": {"a": (-math.inf,)}}
    message = unpacked(packed(Answer("settled", facts, {"a": np.array([math.nan, -math.inf])})))
    assert message.facts == {"period": None, "list": [None, 1.0], "deep": {"a": [None]}}
    assert np.isnan(message.arrays["a"][0])
    assert message.arrays["a"][1] == -math.inf


def test_numbers_of_numpy_are_numbers_of_json():
    facts = {
        "a": np.float64(0.1),
        "b": np.int8(3),
        "c": np.bool_(True),
        "d": np.array([1.0, np.nan]),
    }
    assert unpacked(packed(Answer("p", facts))).facts == {
        "a": 0.1, "b": 3, "c": True, "d": [1.0, None],
    }  # fmt: skip


def test_arrays_need_not_be_contiguous_nor_of_one_dimension():
    values = np.arange(12.0).reshape(3, 4)
    message = unpacked(packed(Answer("p", {}, {"a": values.T, "b": values[:, ::2]})))
    assert message.arrays["a"].tolist() == values.T.ravel().tolist()
    assert message.arrays["b"].tolist() == values[:, ::2].ravel().tolist()


def test_the_header_bears_the_ticket_of_the_question():
    ticket = {"about": "motion", "number": 7, "side": 1}
    assert unpacked(packed(Answer("motion"), ticket)).header == {
        "part": "motion", **ticket, "facts": {},
    }  # fmt: skip


@pytest.mark.parametrize("dtype", [np.int64, np.complex128, np.bool_])
def test_other_kinds_are_not_packed_as_something_else(dtype: type):
    with pytest.raises(KeyError):
        packed(Answer("p", {}, {"a": np.zeros(2, dtype)}))
