"""An answer to a page: plain facts and arrays, packed into one binary message."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

# Arrays begin at multiples of so many bytes, as a browser wants it.
ALIGNED = 8
KINDS = {np.dtype(kind): kind for kind in ("f8", "f4", "i1")}


@dataclass(frozen=True, slots=True)
class Answer:
    """What a page is told of one part of what it shows.

    Parameters
    ----------
    part : str
        Which part.
    facts : dict
        Numbers, texts, and lists and mappings of them.
    arrays : dict of ndarray
        Arrays by name; their dimensions are told by the facts.
    """

    part: str
    facts: dict[str, object] = field(default_factory=dict)
    arrays: dict[str, npt.NDArray[np.generic]] = field(default_factory=dict)


def packed(answer: Answer, ticket: Mapping[str, object] | None = None) -> bytes:
    """Return an answer as bytes, with the ticket of the question that it answers.

    Notes
    -----
    The number of bytes of the header, little-endian in four bytes; the header as JSON, with the
    place of each array behind the header as kind (f8, f4 or i1), offset in bytes and number of
    values; the arrays, little-endian. What is not finite is null in the header, NaN in an array.

    Examples
    --------
    >>> packed(Answer("curve", {"zeta": 0.07}))[4:]
    b'{"part": "curve", "facts": {"zeta": 0.07}, "arrays": {}}'
    """
    places: dict[str, tuple[str, int, int]] = {}
    blocks: list[bytes] = []
    offset = 0
    for name, values in answer.arrays.items():
        kind = KINDS[values.dtype]
        block = values.astype(values.dtype.newbyteorder("<")).tobytes()
        block += bytes(-len(block) % ALIGNED)
        places[name] = (kind, offset, values.size)
        blocks.append(block)
        offset += len(block)
    told = {"part": answer.part, **(ticket or {}), "facts": _finite(answer.facts), "arrays": places}
    header = json.dumps(told, allow_nan=False).encode()
    if blocks:
        header += b" " * (-(4 + len(header)) % ALIGNED)
    return len(header).to_bytes(4, "little") + header + b"".join(blocks)


def _finite(value: object) -> object:
    """Return a fact as JSON has it: numbers of NumPy as Python's, None for what is not finite."""
    if isinstance(value, dict):
        return {str(name): _finite(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(each) for each in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return _finite(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
