"""The dataset of a sweep: one response for each speed, damping, clearance, start and direction.

The points come in pieces, as rows, from memory or a study.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import COMPONENTS
from rotor_ida.results.provenance import provenance
from rotor_ida.results.studies.arrays import Arrays, scratch
from rotor_ida.results.studies.results import Form
from rotor_ida.schema import RESPONSE, STATUS, Column, labelled, labelled_dataset
from rotor_ida.steady.follow import FAILED, SettledResponse
from rotor_ida.steady.ramps import Ramps
from rotor_ida.steady.response import Features

Array = npt.NDArray[np.generic]

FEATURES = tuple(each.name for each in fields(Features))
ENDS = ("end_x", "end_y", "end_vx", "end_vy")
EVENT_STATES = ("event_x", "event_y", "event_vx", "event_vy")

# The columns of a sweep with a number for each point, and those with one for each event.
POINT_COLUMNS: dict[str, type[np.generic]] = {
    "response": np.int8,
    **dict.fromkeys(FEATURES, np.float64),
    "window_start": np.float64,
    "window_end": np.float64,
    "status": np.int8,
    "event_count": np.int64,
    **dict.fromkeys(ENDS, np.float64),
}
EVENT_COLUMNS: dict[str, type[np.generic]] = {
    "event_time": np.float64,
    "event_kind": np.int8,
    **dict.fromkeys(EVENT_STATES, np.float64),
}
_TABLES = {"points": POINT_COLUMNS, "events": EVENT_COLUMNS}


@dataclass(frozen=True, slots=True)
class Rows:
    """Some points of a sweep.

    `POINT_COLUMNS` have shape (points,), and `EVENT_COLUMNS` shape (events,), the events of one
    point after those of the other.
    """

    columns: dict[str, Array]
    messages: list[str]  # why each point failed; empty if it did not


Pieces = Callable[[], Iterator[tuple[npt.NDArray[np.int64], Rows]]]


def sweep_dataset(ramps: Ramps, pieces: Pieces, folder: Path | None = None) -> xr.Dataset:
    """Return the points of a sweep as a labelled dataset.

    `pieces` yields, each time it is called, all points in pieces: their places, counted along
    their dimensions, and their rows. Columns that may be larger than memory go to `folder`.
    """
    starts = ramps.starts
    numbers = {name: ramps.axes[name][0] for name in ramps.numbers}
    every = (*ramps.axes, "start", "direction")
    dims = [name for name in every if name not in numbers]
    shape = [size for name, size in zip(every, ramps.shape, strict=True) if name not in numbers]
    coordinates: dict[str, Column] = {
        name: ((), axis[0]) if name in numbers else (name, axis)
        for name, axis in ramps.axes.items()
    }
    coordinates["start"] = ("start", np.arange(len(starts)))
    coordinates["direction"] = ("direction", np.array(ramps.directions, dtype=np.int8))
    for name, column in zip(COMPONENTS, np.array(starts).T, strict=True):
        coordinates[f"start_{name}"] = ("start", column.copy())
    points = columns_of(POINT_COLUMNS, pieces, ramps.points, folder)
    events = _event_columns(pieces, points["event_count"], folder)
    variables = {
        name: labelled(name, dims, column.reshape(shape)) for name, column in points.items()
    }
    variables["event_count"].attrs["sample_dimension"] = "event"
    variables |= {name: labelled(name, "event", column) for name, column in events.items()}
    title = "Rotor in a clearance: responses over a range of speeds"
    return labelled_dataset(
        title, variables, coordinates, provenance(ramps.options.attributes()), kind="sweep"
    )


def columns_of(
    kinds: Mapping[str, type[np.generic]], pieces: Pieces, total: int, folder: Path | None
) -> dict[str, Array]:
    """Return the columns with a number, or a message, for each point."""
    columns = {name: scratch((total,), kind, folder) for name, kind in kinds.items()}
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


def _event_columns(pieces: Pieces, counts: Array, folder: Path | None) -> dict[str, Array]:
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


def rows_of(points: Sequence[SettledResponse]) -> Rows:
    """Return points as rows."""
    columns: dict[str, list[object]] = {
        "response": [RESPONSE[point.response] for point in points],
        **{name: [getattr(point.features, name) for point in points] for name in FEATURES},
        "window_start": [point.window_start for point in points],
        "window_end": [point.window_end for point in points],
        "status": [STATUS["failed" if point.response == FAILED else "done"] for point in points],
        "event_count": [point.event_times.size for point in points],
    }
    for number, name in enumerate(ENDS):
        columns[name] = [point.end[number] for point in points]
    arrays: dict[str, Array] = {
        name: np.array(column, dtype=POINT_COLUMNS[name]) for name, column in columns.items()
    }
    arrays["event_time"] = np.concatenate([point.event_times for point in points])
    arrays["event_kind"] = np.concatenate([point.event_kinds for point in points])
    states = np.concatenate([point.event_states for point in points])
    arrays |= dict(zip(EVENT_STATES, states.T, strict=True))
    return Rows(arrays, [point.message for point in points])


def _as_arrays(rows: Rows) -> Arrays:
    # each array has a header, which a table of columns has only once
    tables: Arrays = {"messages": np.array(rows.messages, dtype=str)}
    for name, columns in _TABLES.items():
        tables[name] = np.empty(rows.columns[next(iter(columns))].size, dtype=list(columns.items()))
        for column in columns:
            tables[name][column] = rows.columns[column]
    return tables


def _from_arrays(tables: Arrays) -> Rows:
    columns = {column: tables[name][column] for name, names in _TABLES.items() for column in names}
    return Rows(columns, tables["messages"].tolist())


FORM = Form("points of a sweep", _as_arrays, _from_arrays)
