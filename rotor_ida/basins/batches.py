"""Results of the starts that were followed, batch by batch, in memory and as bytes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.features import COLUMNS
from rotor_ida.storage.studies.arrays import packed, unpacked

Values = npt.NDArray[np.float64]
Features = npt.NDArray[np.float32]


@dataclass(slots=True)
class Undecided:
    """Orbits that no trapping region holds: features over two windows, and states at the end.

    Parameters
    ----------
    numbers : ndarray of int64, shape (n,)
        Numbers of their starts.
    earlier, later : ndarray of float32, shape (n, 5)
        Features over the two windows: the columns of `rotor_ida.basins.features` [1].
    states : ndarray, shape (4, n)
        States at the end, on the rotating axes [1].
    """

    numbers: npt.NDArray[np.int64]
    earlier: Features
    later: Features
    states: Values

    def every(self, first: int, step: int) -> Undecided:
        """Return one orbit in `step`, from number `first` on."""
        return Undecided(
            self.numbers[first::step],
            self.earlier[first::step],
            self.later[first::step],
            self.states[:, first::step],
        )


@dataclass(slots=True)
class BatchResult:
    """Results of a batch of starts.

    Parameters
    ----------
    first : int
        Number of its first start.
    labels : ndarray of int16, shape (n,)
        Number of the trapping region, UNDECIDED or NOT_COMPUTED.
    times : ndarray of float32, shape (n,)
        Time at which the start was decided, or given up [1]; NaN where not computed.
    undecided : Undecided
        More about those that no trapping region holds.
    """

    first: int
    labels: npt.NDArray[np.int16]
    times: npt.NDArray[np.float32]
    undecided: Undecided


def joined(parts: Iterable[Undecided]) -> Undecided:
    """Join parts of the undecided orbits."""
    listed = list(parts)
    empty = np.empty((0, COLUMNS), dtype=np.float32)
    return Undecided(
        np.concatenate([np.empty(0, dtype=np.int64), *(part.numbers for part in listed)]),
        np.concatenate([empty, *(part.earlier for part in listed)]),
        np.concatenate([empty, *(part.later for part in listed)]),
        np.concatenate([np.empty((4, 0)), *(part.states for part in listed)], axis=1),
    )


def thinned(parts: Iterable[Undecided], step: int) -> Iterator[Undecided]:
    """Yield one orbit in `step` of all parts, as if these were one."""
    passed = 0
    for part in parts:
        yield part.every(-passed % step, step)
        passed += part.numbers.size


def batch_as_bytes(batch: BatchResult) -> bytes:
    """Return a batch as bytes that `batch_from_bytes` reads."""
    undecided = batch.undecided
    arrays = {
        "first": np.array(batch.first),
        "labels": batch.labels,
        "times": batch.times,
        "numbers": undecided.numbers,
        "earlier": undecided.earlier,
        "later": undecided.later,
        "states": undecided.states,
    }
    return packed(arrays)


def batch_from_bytes(content: bytes) -> BatchResult:
    """Return the batch that `batch_as_bytes` was given.

    Raises
    ------
    ValueError
        If it cannot have written it.
    """
    arrays = unpacked(content)
    try:
        undecided = Undecided(*(arrays[name] for name in ("numbers", "earlier", "later", "states")))
        return BatchResult(int(arrays["first"]), arrays["labels"], arrays["times"], undecided)
    except (KeyError, TypeError) as error:
        raise ValueError(f"it holds no batch of starts: {error}") from error
