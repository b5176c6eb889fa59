"""Arrays as bytes: every bit comes back, and what was not written so is refused."""

import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from rotor_ida.storage.studies.packing import packed, unpacked

KINDS = st.sampled_from(["i1", "i2", "i8", "f4", "f8", "u1"])


@given(
    arrays.arrays(KINDS, arrays.array_shapes(min_dims=0, max_dims=3, min_side=0)),
    st.text(max_size=20),
)
def test_every_bit_comes_back(array, text):
    back, texts = unpacked(packed({"a": array, "b": array[()]}, {"text": text}))
    assert texts == {"text": text}
    for each in back.values():
        assert (each.dtype, each.shape) == (array.dtype, array.shape)
        assert each.tobytes() == array.tobytes()
    assert back["a"].flags.writeable


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"not compressed",
        zlib.compress(b"no line"),
        zlib.compress(b"{}\n"),
        zlib.compress(b'{"arrays": {"a": ["O", [1]]}, "texts": {}}\n12345678'),
        zlib.compress(b'{"arrays": {"a": ["<f8", [2]]}, "texts": {}}\n12345678'),
        zlib.compress(b'{"arrays": {"a": ["<f8", [-1]]}, "texts": {}}\n12345678'),
    ],
)
def test_other_bytes_are_refused(content):
    with pytest.raises(ValueError, match="it holds no packed arrays"):
        unpacked(content)
