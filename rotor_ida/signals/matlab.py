"""Vectors, matrices and structures of MATLAB files, as columns."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.signals.columns import Column, Table

MOST_COLUMNS = 1000


def read_matlab(path: Path) -> Table:
    """Return the columns of a MATLAB file: ``t``, ``data(:,2)``, ``rec.x``."""
    from scipy.io import loadmat  # noqa: PLC0415 - takes long to import

    try:
        held: Mapping[str, object] = loadmat(path, struct_as_record=False)
    except NotImplementedError:
        held = _read_hdf5(path)
    except (ValueError, TypeError, EOFError, IndexError, KeyError) as error:
        raise InputError(f"{shown(path)} must be a MATLAB file: {error}") from error
    columns: dict[str, Column] = {}
    rest: list[str] = []
    for name, value in held.items():
        if not name.startswith(("__", "#")):
            for each, found in _within(name, value):
                if isinstance(found, str):
                    rest.append(f"{each} ({found})")
                else:
                    columns[each] = Column(np.asarray(found, dtype=np.float64))
    if not columns:
        raise InputError(
            f"{shown(path)} must hold vectors or matrices of numbers, got "
            + (shown(", ".join(rest)) if rest else "nothing")
        )
    matrices = {name.split("(")[0] for name in columns}
    if len(matrices) == 1 and len(columns) > 1:  # one matrix, whose columns have no names
        columns = {str(number): column for number, column in enumerate(columns.values(), 1)}
    return Table(
        columns, lambda name, row: f"{columns[name].values[row]} in row {row + 1}", ", ".join(rest)
    )


def _within(name: str, value: object) -> Iterator[tuple[str, np.ndarray | str]]:
    """Yield vectors of numbers by the names that MATLAB would give them, and what else there is."""
    if isinstance(value, Mapping):
        for field, held in value.items():
            yield from _within(f"{name}.{field}", held)
    elif hasattr(value, "_fieldnames"):
        yield from _within(name, {each: getattr(value, each) for each in value._fieldnames})
    elif not isinstance(value, np.ndarray):
        yield name, f"a {type(value).__name__}"
    elif value.dtype.kind in "biuf":
        yield from _vectors(name, value)
    elif value.dtype == object and value.size == 1:
        yield from _within(name, value.ravel()[0])
    elif value.dtype == object and value.size <= MOST_COLUMNS:
        for number, held in enumerate(value.ravel(order="F"), 1):
            yield from _within(f"{name}({number})", held)
    else:
        kinds = {"c": "complex numbers", "U": "text", "S": "text", "V": "a table or an object"}
        yield name, kinds.get(value.dtype.kind, f"of type {value.dtype}")


def _vectors(name: str, value: np.ndarray) -> Iterator[tuple[str, np.ndarray | str]]:
    """Yield a vector, or those of a matrix along its longer side."""
    held = np.squeeze(value)
    if held.ndim == 0 or not held.size:
        yield name, "a number" if held.size else "empty"
    elif held.ndim == 1:
        yield name, held
    elif held.ndim == 2 and min(held.shape) <= MOST_COLUMNS:
        tall = held.shape[0] >= held.shape[1]
        for number, vector in enumerate(held.T if tall else held, 1):
            yield f"{name}(:,{number})" if tall else f"{name}({number},:)", vector
    else:
        yield name, f"an array of {' x '.join(map(str, held.shape))}"


def _read_hdf5(path: Path) -> dict[str, object]:
    """Return what a MATLAB file of version 7.3 holds, which is HDF5."""
    from netCDF4 import Dataset  # noqa: PLC0415 - takes long to import

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of types that are not understood, and left out
        try:
            with Dataset(path) as file:
                file.set_auto_maskandscale(False)
                return _group(file)
        except (OSError, RuntimeError) as error:
            raise InputError(
                f"{shown(path)} must be a MATLAB file that can be read, save it with -v7: {error}"
            ) from error


def _group(group: Any) -> dict[str, object]:
    """Return the variables of a group, with those of structures within."""
    held: dict[str, object] = {}
    for name, variable in group.variables.items():
        kind = getattr(variable, "MATLAB_class", "double")
        numbers = kind not in ("char", "cell", "struct", "function_handle")
        # MATLAB counts dimensions from the other end
        held[name] = np.asarray(variable[:]).T if numbers else np.array(kind)
    for name, within in group.groups.items():
        if not name.startswith("#"):
            held[name] = _group(within)
    return held
