"""Results of a batch of starts: as bytes and back, and an even sample of many."""

import numpy as np
import pytest

from rotor_ida.basins.batches import (
    BatchResult,
    Undecided,
    batch_as_bytes,
    batch_from_bytes,
    joined,
    thinned,
)


def undecided(numbers):
    count = len(numbers)
    features = np.arange(5.0 * count, dtype=np.float32).reshape(count, 5)
    return Undecided(np.array(numbers, dtype=np.int64), features, -features, np.ones((4, count)))


@pytest.mark.parametrize("step", [1, 2, 3, 7])
def test_parts_are_thinned_as_if_they_were_one(step):
    whole = list(range(100, 123))
    parts = [undecided(whole[:5]), undecided([]), undecided(whole[5:6]), undecided(whole[6:])]
    assert joined(thinned(parts, step)).numbers.tolist() == whole[::step]


def test_every_bit_of_a_batch_comes_back():
    labels = np.array([0, -1, 2], dtype=np.int16)
    times = np.array([0.5, np.nan, 2.0], dtype=np.float32)
    batch = BatchResult(8192, labels, times, undecided([8193]))
    back = batch_from_bytes(batch_as_bytes(batch))
    assert back.first == 8192
    for one, other in [
        (back.labels, labels),
        (back.times, times),
        (back.undecided.numbers, batch.undecided.numbers),
        (back.undecided.later, batch.undecided.later),
        (back.undecided.states, batch.undecided.states),
    ]:
        assert (one.dtype, one.shape, one.tobytes()) == (other.dtype, other.shape, other.tobytes())
