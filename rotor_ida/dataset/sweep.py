"""The dataset of a sweep: one response for each speed, damping, clearance, start and direction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import State
from rotor_ida.dataset.provenance import provenance
from rotor_ida.dataset.run import event_variables
from rotor_ida.schema import RESPONSE, STATUS, labelled
from rotor_ida.settling import FAILED, Settled
from rotor_ida.simulator.options import Options

Values = npt.NDArray[np.float64]

DIMS = ("omega", "zeta", "delta0", "start", "direction")
WINDOW_QUANTITIES = ("amplitude", "phase_lag", "radius_min", "radius_max")


def sweep_dataset(
    axes: Mapping[str, Values],
    starts: Sequence[State],
    directions: Sequence[int],
    points: Mapping[tuple[int, ...], Settled],
    options: Options,
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
    points : mapping of tuple of int to Settled
        What became of the point with these indices along `DIMS`.
    options : Options
        How it was simulated.
    """
    shape = (*(axes[name].size for name in DIMS[:3]), len(starts), len(directions))
    ordered = [points[index] for index in np.ndindex(shape)]
    coordinates = {name: labelled(name, name, axes[name]) for name in DIMS[:3]}
    coordinates["start"] = labelled("start", "start", np.arange(len(starts)))
    coordinates["direction"] = labelled(
        "direction", "direction", np.array(directions, dtype=np.int8)
    )
    for name, column in zip(("x", "y", "vx", "vy"), np.array(starts).T, strict=True):
        coordinates[f"start_{name}"] = labelled(f"start_{name}", "start", column.copy())
    variables = {
        name: labelled(name, DIMS, np.array(column).reshape(shape))
        for name, column in _columns(ordered).items()
    }
    variables["event_count"].attrs["sample_dimension"] = "event"
    variables |= event_variables(
        np.concatenate([point.event_times for point in ordered]),
        np.concatenate([point.event_kinds for point in ordered]),
        np.concatenate([point.event_states for point in ordered]),
    )
    attributes = provenance("Rotor in a clearance: responses over a range of speeds", options)
    return xr.Dataset(variables, coordinates, attributes)


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


def _columns(points: Sequence[Settled]) -> dict[str, list[object]]:
    columns: dict[str, list[object]] = {
        "response": [np.int8(RESPONSE[point.response]) for point in points],
        **{name: [_of_window(point, name) for point in points] for name in WINDOW_QUANTITIES},
        "window_start": [point.window_start for point in points],
        "window_end": [point.window_end for point in points],
        "status": [
            np.int8(STATUS["failed" if point.response == FAILED else "done"]) for point in points
        ],
        "message": [point.message for point in points],
        "event_count": [np.int64(point.event_times.size) for point in points],
    }
    for number, name in enumerate(("end_x", "end_y", "end_vx", "end_vy")):
        columns[name] = [point.end[number] for point in points]
    return columns


def _of_window(point: Settled, name: str) -> float:
    return float("nan") if point.window is None else float(getattr(point.window, name))
