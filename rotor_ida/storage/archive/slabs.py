"""Variables taken slab by slab, so that one larger than memory can be written and checked."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import numpy.typing as npt
import xarray as xr

CHUNK = 2**20  # bytes that HDF5 compresses together
SLAB = 32 * 2**20  # bytes read or computed at a time; with its copies some 64 to 100 MiB

Index = tuple[slice, ...]


def is_in_memory(variable: xr.Variable) -> bool:
    """Say whether the values of `variable` are there, and not still in a file or to be computed."""
    return variable._in_memory


def block_shape(shape: Sequence[int], itemsize: int, limit: int) -> tuple[int, ...]:
    """Return the shape of the largest block of at most `limit` bytes that is contiguous in C order.

    Examples
    --------
    >>> block_shape((1000, 50, 40), 8, 100_000), block_shape((1000, 50, 40), 8, 3200)
    ((6, 50, 40), (1, 10, 40))
    """
    for axis, length in enumerate(shape):
        rest = itemsize * math.prod(shape[axis + 1 :])
        if rest <= limit:
            return (*(1,) * axis, min(length, limit // max(rest, 1)), *shape[axis + 1 :])
    return (1,) * len(shape)


def slab_indices(shape: Sequence[int], itemsize: int) -> Iterator[Index]:
    """Yield the indices of the slabs of an array, in C order.

    Each slab holds whole chunks, so that none is compressed twice.

    Examples
    --------
    >>> list(slab_indices((2, 2**23), 4))
    [(slice(0, 1, None), slice(0, 8388608, None)), (slice(1, 2, None), slice(0, 8388608, None))]
    """
    if 0 in shape:
        return
    chunk, slab = block_shape(shape, itemsize, CHUNK), block_shape(shape, itemsize, SLAB)
    steps = [
        long if long == length else max(long - long % short, 1)
        for short, long, length in zip(chunk, slab, shape, strict=True)
    ]
    starts = (range(0, length, step) for length, step in zip(shape, steps, strict=True))
    for corner in product(*starts):
        yield tuple(
            slice(first, min(first + step, length))
            for first, step, length in zip(corner, steps, shape, strict=True)
        )


def slabs(variable: xr.Variable) -> Iterator[tuple[Index, npt.NDArray[np.generic]]]:
    """Yield index and values of each slab of `variable`, in C order."""
    for index in slab_indices(variable.shape, variable.dtype.itemsize):
        yield index, np.asarray(variable[index].values)
