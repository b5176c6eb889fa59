"""Read Matrix Market files: matrices of real numbers as text.

References
----------
Boisvert, Pozo and Remington, The Matrix Market Exchange Formats, NISTIR 5935, 1996.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array

FORMATS, FIELDS = ("array", "coordinate"), ("real", "double", "integer", "pattern")
# The part above the diagonal, from that below.
SYMMETRIES = {"general": 0.0, "symmetric": 1.0, "skew-symmetric": -1.0}


def matrix_of(path: Path, largest: int) -> Any:
    """Return the matrix in a file: an array, or a sparse matrix in coordinates.

    ValueError is raised for a file that is none, or a matrix with more rows or columns than
    `largest`.
    """
    with path.open(encoding="ascii") as file:
        words = file.readline(200).lower().split()
        if len(words) != 5 or words[:2] != ["%%matrixmarket", "matrix"]:
            raise ValueError("its first line is not that of a Matrix Market file")
        kind, field, symmetry = words[2:]
        if kind not in FORMATS or field not in FIELDS or symmetry not in SYMMETRIES:
            raise ValueError(f"a matrix of the kind {' '.join(words[2:])} is declared")
        line = next((each for each in file if each.strip() and not each.startswith("%")), "")
        sizes = [int(word) for word in line.split()]
        if len(sizes) != (2 if kind == "array" else 3) or min(sizes) < 0:
            raise ValueError("the sizes of the matrix are not declared")
        if max(sizes[:2]) > largest:
            raise ValueError(
                f"{sizes[0]} by {sizes[1]} numbers are declared, more than {largest} a side"
            )
        body = file.read()
    if kind == "array":
        return _dense(np.array(body.split(), float), (sizes[0], sizes[1]), symmetry)
    return _sparse(body, (sizes[0], sizes[1]), sizes[2], symmetry)


def _dense(numbers: Any, shape: tuple[int, int], symmetry: str) -> Any:
    """Return a matrix by its numbers along columns, of which a symmetric one has the lower part."""
    below = {"general": None, "symmetric": 0, "skew-symmetric": -1}[symmetry]
    places = np.ones(shape, bool) if below is None else np.tri(*shape, below, bool)
    if numbers.size != places.sum() or (symmetry != "general" and shape[0] != shape[1]):
        raise ValueError(f"a {symmetry} matrix of {shape} is declared for {numbers.size} numbers")
    found = np.zeros(shape)
    found.T[places.T] = numbers
    if below is None:
        return found
    return found + SYMMETRIES[symmetry] * np.tril(found, -1).T


def _sparse(body: str, shape: tuple[int, int], count: int, symmetry: str) -> Any:
    """Return a matrix by row, column and number of each entry; without numbers they are 1."""
    entries = np.loadtxt(io.StringIO(body), ndmin=2) if body.strip() else np.zeros((0, 3))
    if len(entries) != count or entries.shape[1] not in {2, 3}:
        raise ValueError(f"{count} entries are declared, and {len(entries)} follow")
    numbers = entries[:, 2] if entries.shape[1] == 3 else np.ones(count)
    rows, columns = (
        _indices(given, length) for given, length in zip(entries.T[:2], shape, strict=True)
    )
    found = coo_array((numbers, (rows, columns)), shape=shape)
    if symmetry == "general":
        return found
    if shape[0] != shape[1]:
        raise ValueError(f"a {symmetry} matrix of {shape} is declared")
    off = rows != columns
    other = coo_array((numbers[off], (columns[off], rows[off])), shape=shape)
    return found + SYMMETRIES[symmetry] * other


def _indices(given: Any, length: int) -> Any:
    """Return indices from 0 of those from 1."""
    if not np.isin(given, np.arange(1, length + 1)).all():
        raise ValueError(f"an entry has an index that is not from 1 to {length}")
    return given.astype(int) - 1
