"""Arrays of a study: as bytes in its store, or in files of its folder if larger than memory."""

from __future__ import annotations

import io
import math
import os
import tempfile
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Arrays
from rotor_ida.errors import ArchiveError

# The fastest level: numbers of an orbit hardly compress; labels and headers do at any level.
_LEVEL = 1
# Smaller arrays stay in memory.
LARGE = 64 * 2**20  # bytes


def packed(arrays: Mapping[str, npt.NDArray[Any]]) -> bytes:
    """Return arrays as bytes: NumPy's npz without pickles, compressed whole by zlib.

    `numpy.savez_compressed` does not compress the headers, which are most of a small piece.

    Examples
    --------
    >>> unpacked(packed({"x": np.array([1.0, 2.0]), "message": np.array(["failed"])}))
    {'x': array([1., 2.]), 'message': array(['failed'], dtype='<U6')}
    """
    written = io.BytesIO()
    np.savez(written, **arrays)  # type: ignore[arg-type]
    return zlib.compress(written.getbuffer(), _LEVEL)


def unpacked(content: bytes) -> Arrays:
    """Return the arrays packed by `packed`. Nothing in them can run code.

    Raises
    ------
    ValueError
        If the bytes were not written by `packed`.
    """
    try:
        with np.load(io.BytesIO(zlib.decompress(content)), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except (zlib.error, zipfile.BadZipFile, ValueError, EOFError, OSError, AttributeError) as error:
        raise ValueError(f"it contains no packed arrays: {error}") from error


def scratch(
    shape: tuple[int, ...], dtype: npt.DTypeLike, folder: Path | None
) -> npt.NDArray[np.generic]:
    """Return an array of unset values, on the disk of `folder` if it is large.

    Its file has no name and disappears with the array, even if the process is killed. Without a
    folder the array is in memory, whatever its size.

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
    shape, kind = (*shape, *kind.shape), kind.base  # of columns with several numbers a row
    size = math.prod(shape) * kind.itemsize
    if folder is None or size < LARGE:
        return np.empty(shape, dtype=kind)
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            # Without real allocation the process would crash when the disk is full.
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, size)
            else:
                file.truncate(size)
            return np.memmap(file, dtype=kind, mode="r+", shape=shape)
    except OSError as error:
        raise ArchiveError(
            f"cannot make room for {size / 2**20:.0f} MiB in {str(folder)!r}: {error.strerror}"
        ) from error
