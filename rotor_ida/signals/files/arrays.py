"""Read files of named arrays, nested or not: MATLAB (.mat), HDF5 (.h5, .hdf5), NumPy (.npz)."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.formats.matlab import DEEPEST, HEAD, arrays_of, is_hdf5
from rotor_ida.formats.npz import member_of
from rotor_ida.signals.files.columns import (
    MOST_NUMBERS,
    Column,
    Table,
    check_size,
    numbers_or_times,
    possible_in,
    understood,
)
from rotor_ida.signals.files.hdf5 import content_of

MOST_COLUMNS = 1000
_NO_NUMBERS = {"c": "complex numbers", "U": "text", "S": "text", "V": "a table or an object"}


def read_matlab(path: Path) -> Table:
    """Return the columns of a MATLAB file: ``t``, ``data(:,2)``, ``rec.x``."""
    with path.open("rb") as file:
        head = file.read(HEAD)
    if is_hdf5(head):
        return _table(path, content_of(path, "a MATLAB file that can be read, save it with -v7"))
    with understood(path, "a MATLAB file"):
        check_size(path, path.stat().st_size / 8)
        held = arrays_of(path.read_bytes(), 8 * MOST_NUMBERS)
    return _table(path, held)


def read_hdf5(path: Path) -> Table:
    """Return the columns of an HDF5 file: datasets by their names, ``group.x`` in groups."""
    return _table(path, content_of(path, "an HDF5 file that can be read"))


def read_npz(path: Path) -> Table:
    """Return the columns of a file of `numpy.savez`; no code in it is run."""
    held: dict[str, object] = {}
    with understood(path, "an .npz file"), zipfile.ZipFile(path) as archive:
        members = [each for each in archive.infolist() if each.filename.endswith(".npy")]
        check_size(path, sum(each.file_size for each in members) / 8, possible=possible_in(path))
        for member in members:
            held[member.filename.removesuffix(".npy")] = member_of(archive, member)
    return _table(path, held)


def _table(path: Path, held: Mapping[str, object]) -> Table:
    """Return vectors and matrices of numbers as columns, and single numbers separately."""
    columns: dict[str, Column] = {}
    rest: list[str] = []
    scalars: dict[str, float] = {}
    for name, value in held.items():
        for each, found in _within(name, value):
            if isinstance(found, Column):
                columns[each] = found
            elif isinstance(found, float):
                scalars[each] = found
                rest.append(f"{each} (a number)")
            else:
                rest.append(f"{each} ({found})")
    if not columns:
        raise InputError(
            f"{shown(path)} must contain vectors or matrices of numbers, got "
            + (shown(", ".join(rest)) if rest else "nothing")
        )
    matrices = {name.split("(")[0] for name in columns}
    if len(matrices) == 1 and len(columns) > 1:  # one matrix, whose columns have no names
        columns = {str(number): column for number, column in enumerate(columns.values(), 1)}
    return Table(
        columns,
        lambda name, row: f"{columns[name].values[row]} in row {row + 1}",
        ", ".join(rest),
        scalars,
    )


def _within(
    name: str, value: object, unit: str = "", depth: int = 0
) -> Iterator[tuple[str, Column | float | str]]:
    """Yield vectors of numbers by the names that MATLAB would give them, and other content."""
    if depth > DEEPEST:
        raise InputError(f"structures must be nested at most {DEEPEST} deep, got {shown(name)}")
    if isinstance(value, Column):
        yield from _within(name, value.values, value.unit, depth)
    elif isinstance(value, Mapping):
        for field, held in value.items():
            yield from _within(f"{name}.{field}", held, unit, depth + 1)
    elif isinstance(value, str):
        yield name, value
    elif not isinstance(value, np.ndarray):
        yield name, "a sparse matrix" if hasattr(value, "toarray") else f"a {type(value).__name__}"
    elif (numbers := numbers_or_times(value)) is not None:
        yield from _vectors(name, numbers, "s" if value.dtype.kind in "mM" else unit)
    elif value.dtype == object and value.size == 1:
        yield from _within(name, value.ravel()[0], unit, depth + 1)
    elif value.dtype == object and value.size <= MOST_COLUMNS:
        for number, held in enumerate(value.ravel(order="F"), 1):
            yield from _within(f"{name}({number})", held, unit, depth + 1)
    else:
        yield name, _NO_NUMBERS.get(value.dtype.kind, f"of type {value.dtype}")


def _vectors(name: str, value: np.ndarray, unit: str) -> Iterator[tuple[str, Column | float | str]]:
    """Yield a number, a vector, or the vectors of a matrix along its longer side."""
    held = np.squeeze(value)
    if held.ndim == 0 and held.size:
        yield name, float(held)
    elif not held.size:
        yield name, "empty"
    elif held.ndim == 1:
        yield name, Column(np.ascontiguousarray(held), unit)
    elif held.ndim == 2 and min(held.shape) <= MOST_COLUMNS:
        tall = held.shape[0] >= held.shape[1]
        for number, vector in enumerate(held.T if tall else held, 1):
            each = f"{name}(:,{number})" if tall else f"{name}({number},:)"
            yield each, Column(np.ascontiguousarray(vector), unit)
    else:
        yield name, f"an array of {' x '.join(map(str, held.shape))}"
