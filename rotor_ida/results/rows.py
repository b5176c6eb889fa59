"""Tables that many runs share, such as the events of a sweep: which rows are those of a run.

A variable such as ``event_count`` gives how many rows a run has, and names the dimension of the
rows in its attribute ``sample_dimension`` (CF: contiguous ragged array). One such as ``event_row``
gives its first row, also in a selection of the runs.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.errors import InputError
from rotor_ida.schema import QUANTITIES, labelled

COUNTS = "sample_dimension"


def counted(name: str, counts: xr.Variable, table: str) -> dict[str, xr.Variable]:
    """Return the counts of a table whose rows follow each other, and the first row of each run."""
    sizes = counts.values.ravel()
    first = np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)[:-1]]) if sizes.size else sizes
    counts.attrs[COUNTS] = table
    row = name_of_row(name)
    return {name: counts, row: labelled(row, counts.dims, first.reshape(counts.shape))}


def name_of_row(counts: str) -> str:
    """Return the name of the variable with the first rows: that of the counts with ``row``."""
    return f"{counts.removesuffix('_count')}_row"


def counts_in(dataset: xr.Dataset) -> Mapping[str, str]:
    """Return the names of the variables that count rows, each with the dimension of its rows."""
    return {
        str(name): variable.attrs[COUNTS]
        for name, variable in dataset.data_vars.items()
        if isinstance(variable.attrs.get(COUNTS), str)
        and variable.attrs[COUNTS] in dataset.dims
        and name_of_row(str(name)) in QUANTITIES
        and variable.dtype.kind in "iu"
    }


def own_rows(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset whose tables have the rows of its runs alone, in the order of the runs.

    Raises
    ------
    InputError
        If the dataset does not say which rows are its own.
    """
    for name, table in counts_in(dataset).items():
        rows, size = _rows(dataset, name, table), dataset.sizes[table]
        if rows.size != size or (rows != np.arange(size)).any():
            dataset = dataset.isel({table: rows})
            dataset = dataset.assign(counted(name, dataset[name].variable.copy(), table))
    return dataset


def _rows(dataset: xr.Dataset, name: str, table: str) -> npt.NDArray[np.int64]:
    """Return the rows of all runs of a dataset."""
    counts, size = dataset[name].values.ravel().astype(np.int64), dataset.sizes[table]
    row = name_of_row(name)
    if row not in dataset.variables:
        raise InputError(
            f"{table} must have {row}: without it is unknown which rows belong to these runs"
        )
    first = dataset[row].transpose(*dataset[name].dims).values.ravel().astype(np.int64)
    ends = first + counts
    if counts.min(initial=0) < 0 or first.min(initial=0) < 0 or ends.max(initial=0) > size:
        raise InputError(
            f"{table} must have the rows of all runs, got {size}, of which {row} and {name} "
            f"need {ends.max(initial=0)}: select runs, not rows"
        )
    start = np.repeat(first - (np.cumsum(counts) - counts), counts)
    return start + np.arange(counts.sum(), dtype=np.int64)
