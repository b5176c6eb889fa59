"""Results of a batch of starts as bytes and back."""

import numpy as np
import pytest

from rotor_ida.basins.batches import BatchResult, batch_as_bytes, batch_from_bytes
from rotor_ida.storage.studies.arrays import packed


def test_every_bit_of_a_batch_comes_back():
    batch = BatchResult(
        8192,
        np.array([0, -3, 2], dtype=np.int16),
        np.array([0.5, np.nan, 2.0], dtype=np.float32),
        np.array([[1.0, 2.0, 3.0, 4.0, 1e-300, 1.0]]),
        np.empty((0, 4)),
        np.array([3.0, 1e5]),
        np.array(1e-6),
    )
    back = batch_from_bytes(batch_as_bytes(batch))
    assert back.first == 8192
    for name in ("labels", "times", "cycles", "chaos", "watched"):
        one, other = getattr(back, name), getattr(batch, name)
        assert (one.dtype, one.shape, one.tobytes()) == (other.dtype, other.shape, other.tobytes())


@pytest.mark.parametrize("arrays", [{}, {"first": np.array(0), "other": np.array(1)}])
def test_other_bytes_are_refused(arrays):
    with pytest.raises(ValueError, match="it holds no batch of starts"):
        batch_from_bytes(packed(arrays))
