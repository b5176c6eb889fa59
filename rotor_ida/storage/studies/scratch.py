"""Arrays that may be larger than memory: on disk, in a file that has no name.

Such a file goes away with the array, even if the process is killed.
"""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from rotor_ida.errors import ArchiveError

# Smaller arrays are kept in memory.
LARGE = 64 * 2**20  # bytes
# So many numbers are worked on at a time.
SLAB = 2**20


def scratch(
    shape: tuple[int, ...], dtype: npt.DTypeLike, folder: Path | None
) -> npt.NDArray[np.generic]:
    """Return an array of unset values, on the disk of `folder` if it is large.

    Parameters
    ----------
    shape : tuple of int
        Shape of the array.
    dtype : dtype
        Its dtype.
    folder : Path or None
        Folder that exists; None for an array in memory, whatever its size.

    Raises
    ------
    ArchiveError
        If the disk has no room for it.

    Examples
    --------
    >>> scratch((2, 3), np.float32, None).shape
    (2, 3)
    """
    kind = np.dtype(dtype)
    size = math.prod(shape) * kind.itemsize
    if folder is None or size < LARGE:
        return np.empty(shape, dtype=kind)
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            # Room that is only promised would end the process when the disk is full.
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, size)
            else:
                file.truncate(size)
            return np.memmap(file, dtype=kind, mode="r+", shape=shape)
    except OSError as error:
        raise ArchiveError(
            f"cannot make room for {size / 2**20:.0f} MiB in {str(folder)!r}: {error.strerror}"
        ) from error


def slabs(size: int) -> Iterator[slice]:
    """Yield the stretches in which a flat array of this size is worked on.

    Examples
    --------
    >>> list(slabs(5))
    [slice(0, 5, None)]
    """
    for first in range(0, size, SLAB):
        yield slice(first, min(first + SLAB, size))
