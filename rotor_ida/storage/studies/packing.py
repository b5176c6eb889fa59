"""Arrays as bytes and back, without anything that could run code when it is read."""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

Arrays = dict[str, npt.NDArray[Any]]

# The fastest: the numbers of an orbit hardly shrink, labels and zeros do at any level.
_LEVEL = 1
_KINDS = "iuf"


def packed(arrays: Mapping[str, npt.NDArray[Any]], texts: Mapping[str, str]) -> bytes:
    """Return numeric arrays and texts as bytes.

    Notes
    -----
    Compressed by zlib: one line of JSON with names, dtypes and shapes, then the arrays' bytes,
    little-endian and in C order.

    Examples
    --------
    >>> content = packed({"x": np.array([1.0, 2.0])}, {"message": "failed"})
    >>> unpacked(content)
    ({'x': array([1., 2.])}, {'message': 'failed'})
    """
    stored = {name: _little_endian(array) for name, array in arrays.items()}
    forms = {name: [array.dtype.str, array.shape] for name, array in stored.items()}
    head = json.dumps({"arrays": forms, "texts": dict(texts)}).encode() + b"\n"
    return zlib.compress(head + b"".join(array.tobytes() for array in stored.values()), _LEVEL)


def unpacked(content: bytes) -> tuple[Arrays, dict[str, str]]:
    """Return what `packed` was given.

    Raises
    ------
    ValueError
        If `packed` cannot have written it.
    """
    try:
        head, body = zlib.decompress(content).split(b"\n", 1)
        told = json.loads(head)
        arrays: Arrays = {}
        place = 0
        for name, (kind, shape) in told["arrays"].items():
            dtype = np.dtype(kind)
            if dtype.kind not in _KINDS or min(shape, default=0) < 0:
                raise ValueError(f"{name} has dtype {kind} and shape {shape}")
            array = np.frombuffer(body, dtype, math.prod(shape), place).reshape(shape)
            arrays[name] = array.astype(dtype.newbyteorder("="))
            place += array.nbytes
        return arrays, {str(name): str(text) for name, text in told["texts"].items()}
    except (zlib.error, ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"it holds no packed arrays: {error}") from error


def _little_endian(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).reshape(array.shape)
