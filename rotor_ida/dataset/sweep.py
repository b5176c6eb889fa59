"""The dataset of a sweep: one response for each speed, damping, clearance, start and direction."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import State
from rotor_ida.dataset.provenance import provenance
from rotor_ida.dataset.rows import EVENT_COLUMNS, POINT_COLUMNS, Column, Rows
from rotor_ida.schema import labelled
from rotor_ida.simulator.options import Options
from rotor_ida.studies.scratch import scratch

Values = npt.NDArray[np.float64]
Pieces = Callable[[], Iterator[tuple[npt.NDArray[np.int64], Rows]]]

DIMS = ("omega", "zeta", "delta0", "start", "direction")


def sweep_dataset(
    axes: Mapping[str, Values],
    starts: Sequence[State],
    directions: Sequence[int],
    pieces: Pieces,
    options: Options,
    folder: Path | None = None,
) -> xr.Dataset:
    """Return the points of a sweep as a labelled dataset.

    Parameters
    ----------
    axes : mapping of str to ndarray
        The values of ``omega``, ``zeta`` and ``delta0`` [1].
    starts : sequence of tuple of float
        The starts ``(x, y, vx, vy)`` [1].
    directions : sequence of int
        1 up, -1 down, 0 each speed from its start.
    pieces : callable
        Yields, each time it is called, all points in pieces: their places, counted along `DIMS`,
        and their rows.
    options : Options
        How it was simulated.
    folder : Path, optional
        Where columns go that may be larger than memory.
    """
    shape = (*(axes[name].size for name in DIMS[:3]), len(starts), len(directions))
    coordinates = {name: labelled(name, name, axes[name]) for name in DIMS[:3]}
    coordinates["start"] = labelled("start", "start", np.arange(len(starts)))
    coordinates["direction"] = labelled(
        "direction", "direction", np.array(directions, dtype=np.int8)
    )
    for name, column in zip(("x", "y", "vx", "vy"), np.array(starts).T, strict=True):
        coordinates[f"start_{name}"] = labelled(f"start_{name}", "start", column.copy())
    points = _point_columns(pieces, math.prod(shape), folder)
    events = _event_columns(pieces, points["event_count"], folder)
    variables = {
        name: labelled(name, DIMS, column.reshape(shape)) for name, column in points.items()
    }
    variables["event_count"].attrs["sample_dimension"] = "event"
    variables |= {name: labelled(name, "event", column) for name, column in events.items()}
    attributes = provenance("Rotor in a clearance: responses over a range of speeds", options)
    return xr.Dataset(variables, coordinates, attributes)


def _point_columns(pieces: Pieces, total: int, folder: Path | None) -> dict[str, Column]:
    """Return the columns with a number, or a message, for each point."""
    columns = {name: scratch((total,), kind, folder) for name, kind in POINT_COLUMNS.items()}
    messages: dict[int, str] = {}
    for places, rows in pieces():
        for name, column in columns.items():
            column[places] = rows.columns[name]
        told = zip(places.tolist(), rows.messages, strict=True)
        messages |= {place: message for place, message in told if message}
    width = max(map(len, messages.values()), default=1)
    texts = scratch((total,), f"<U{width}", folder)
    texts[:] = ""
    for place, message in messages.items():
        texts[place] = message
    return columns | {"message": texts}


def _event_columns(pieces: Pieces, counts: Column, folder: Path | None) -> dict[str, Column]:
    """Return the columns with a number for each event, in the order of the points."""
    ends = np.cumsum(counts, dtype=np.int64)
    total = int(ends[-1])
    columns = {name: scratch((total,), kind, folder) for name, kind in EVENT_COLUMNS.items()}
    for places, rows in pieces():
        first = 0
        for place, count in zip(places.tolist(), rows.columns["event_count"].tolist(), strict=True):
            end = int(ends[place])
            for name, column in columns.items():
                column[end - count : end] = rows.columns[name][first : first + count]
            first += count
    return columns


def events_of(dataset: xr.Dataset, index: Mapping[str, int]) -> xr.Dataset:
    """Return the events of one point of a sweep.

    Parameters
    ----------
    dataset : Dataset
        A sweep.
    index : mapping of str to int
        Position of the point along each dimension of ``event_count``; 0 where left out.

    Returns
    -------
    Dataset
        The variables on ``event`` of that point alone.
    """
    counts = dataset["event_count"]
    place = tuple(int(index.get(str(dim), 0)) for dim in counts.dims)
    flat = int(np.ravel_multi_index(place, counts.shape))
    ends = np.cumsum(counts.values.ravel())
    first = int(ends[flat - 1]) if flat else 0
    names = [name for name, variable in dataset.data_vars.items() if variable.dims == ("event",)]
    return dataset[names].isel(event=slice(first, int(ends[flat])))
