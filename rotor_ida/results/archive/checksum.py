"""Two checksums: of the content of an archive, and of the bytes of its file, which is its seal.

A damaged file can make the HDF5 library crash or loop forever, so the bytes are checked before the
library reads them. The seal follows the data of HDF5 and netCDF, which do not read it. Numbers that
are not in memory are hashed block by block, so they may be larger than memory.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from types import EllipsisType
from typing import BinaryIO, Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.results.archive.content import NOT_IN_CHECKSUM, NUMERIC

CHUNK = 2**20  # bytes that HDF5 compresses together
BLOCK = 32 * 2**20  # bytes read or computed at a time; with its copies some 64 to 100 MiB

Array = npt.NDArray[np.generic]
Index = tuple[slice | EllipsisType, ...]
Look = Callable[[str, Index, Array], None]

_SEAL = re.compile(rb"\nrotor_ida seal 1: sha256 of the bytes before is ([0-9a-f]{64})\n")
_SEAL_LENGTH = len("\nrotor_ida seal 1: sha256 of the bytes before is \n") + 64


def content_sha256(dataset: xr.Dataset, look: Look | None = None) -> str:
    r"""Return the SHA-256 of the content of `dataset`, however it is stored.

    Parameters
    ----------
    dataset : xr.Dataset
        The dataset, in the form of `rotor_ida.results.archive.content.archived_form`.
    look : callable, optional
        Called with name, index and values of each block as it is hashed, so that slow blocks can be
        written at the same time.

    Notes
    -----
    The hashed bytes are lines of JSON, each ended by ``\n``: first the attributes of the dataset,
    then the variables, both in the order of their names. An attribute is
    ``["attribute", name, dtype, value]``, where dtype is ``"str"`` or as in ``"<f8"``, and a
    number's value is the hexadecimal of its little-endian bytes. A variable is ``["variable",
    name, whether it is a coordinate, dims, shape, dtype]``, its data, then its attributes: the data
    are the little-endian bytes in C order, or for strings one line of JSON, a list. The attributes
    of `NOT_IN_CHECKSUM` are left out.
    Compression and the order of variables do not matter.

    Examples
    --------
    >>> near, far = (xr.Dataset({"x": ("t", [value])}) for value in (1.0, 1.0 + 2**-52))
    >>> content_sha256(near) == content_sha256(near.copy(deep=True))
    True
    >>> content_sha256(near) == content_sha256(far)
    False
    """
    digest = hashlib.sha256()
    told = {name: value for name, value in dataset.attrs.items() if name not in NOT_IN_CHECKSUM}
    _add_attributes(digest, told)
    for name in sorted(str(name) for name in dataset.variables):
        variable = dataset.variables[name]
        numeric = variable.dtype in NUMERIC
        kind = variable.dtype.newbyteorder("<").str if numeric else "str"
        is_coordinate = name in dataset.coords
        _add_line(digest, "variable", name, is_coordinate, variable.dims, variable.shape, kind)
        for index, values in _blocks(variable) if numeric else [((...,), variable.values)]:
            if numeric:
                digest.update(np.ascontiguousarray(values, dtype=kind).reshape(-1).view("u1").data)
            else:
                _add_line(digest, values.ravel().tolist())
            if look is not None:
                look(name, index, values)
            del values  # before the next are read
        _add_attributes(digest, variable.attrs)
    return digest.hexdigest()


def append_seal(path: Path) -> None:
    """Append a seal to a finished file."""
    with path.open("rb+") as file:
        digest = _sha256(file, os.fstat(file.fileno()).st_size)
        file.seek(0, os.SEEK_END)
        file.write(f"\nrotor_ida seal 1: sha256 of the bytes before is {digest}\n".encode())


def seal_of(path: Path, *, check: bool = True) -> Literal["good", "broken", "none"]:
    """Return whether the bytes of a file are those that were sealed.

    Without the check, an existing seal counts as good.
    """
    with path.open("rb") as file:
        length = os.fstat(file.fileno()).st_size - _SEAL_LENGTH
        file.seek(max(length, 0))
        found = _SEAL.fullmatch(file.read(_SEAL_LENGTH))
        if found is None:
            return "none"
        file.seek(0)
        return "good" if not check or _sha256(file, length) == found[1].decode() else "broken"


def largest_block(shape: Sequence[int], itemsize: int, limit: int) -> tuple[int, ...]:
    """Return the shape of the largest block of at most `limit` bytes that is contiguous in C order.

    Examples
    --------
    >>> largest_block((1000, 50, 40), 8, 100_000), largest_block((1000, 50, 40), 8, 3200)
    ((6, 50, 40), (1, 10, 40))
    """
    for axis, length in enumerate(shape):
        rest = itemsize * math.prod(shape[axis + 1 :])
        if rest <= limit:
            return (*(1,) * axis, min(length, limit // max(rest, 1)), *shape[axis + 1 :])
    return (1,) * len(shape)


def block_indices(shape: Sequence[int], itemsize: int) -> Iterator[tuple[slice, ...]]:
    """Yield the indices of the blocks of an array, in C order.

    Each block consists of whole chunks, so that none is compressed twice.

    Examples
    --------
    >>> list(block_indices((2, 2**23), 4))
    [(slice(0, 1, None), slice(0, 8388608, None)), (slice(1, 2, None), slice(0, 8388608, None))]
    """
    if 0 in shape:
        return
    chunk, block = largest_block(shape, itemsize, CHUNK), largest_block(shape, itemsize, BLOCK)
    steps = [
        long if long == length else max(long - long % short, 1)
        for short, long, length in zip(chunk, block, shape, strict=True)
    ]
    starts = (range(0, length, step) for length, step in zip(shape, steps, strict=True))
    for corner in product(*starts):
        yield tuple(
            slice(first, min(first + step, length))
            for first, step, length in zip(corner, steps, shape, strict=True)
        )


def _blocks(variable: xr.Variable) -> Iterator[tuple[Index, Array]]:
    for index in block_indices(variable.shape, variable.dtype.itemsize):
        yield index, np.asarray(variable[index].values)


def _add_attributes(digest: hashlib._Hash, attributes: Mapping[str, object]) -> None:
    for name in sorted(attributes):
        value = attributes[name]
        if isinstance(value, str):
            _add_line(digest, "attribute", name, "str", value)
        else:
            array = np.asarray(value)
            kind = array.dtype.newbyteorder("<").str
            _add_line(digest, "attribute", name, kind, array.astype(kind).tobytes().hex())


def _add_line(digest: hashlib._Hash, *parts: object) -> None:
    digest.update(json.dumps(parts).encode() + b"\n")


def _sha256(file: BinaryIO, length: int) -> str:
    """Return the checksum of the next bytes of a file."""
    digest = hashlib.sha256()
    while length > 0 and (block := file.read(min(CHUNK, length))):
        digest.update(block)
        length -= len(block)
    return digest.hexdigest()
