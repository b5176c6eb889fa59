"""What some points of a sweep add to its dataset, in memory and as bytes."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.schema import RESPONSE, STATUS
from rotor_ida.settling import FAILED, Settled
from rotor_ida.studies.packing import packed, unpacked

Column = npt.NDArray[np.generic]

WINDOW_QUANTITIES = ("amplitude", "phase_lag", "radius_min", "radius_max")
ENDS = ("end_x", "end_y", "end_vx", "end_vy")
EVENT_STATES = ("event_x", "event_y", "event_vx", "event_vy")

# The columns of a sweep with a number for each point, and those with one for each event.
POINT_COLUMNS: dict[str, type[np.generic]] = {
    "response": np.int8,
    **dict.fromkeys(WINDOW_QUANTITIES, np.float64),
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


@dataclass(frozen=True, slots=True)
class Rows:
    """Some points of a sweep.

    Parameters
    ----------
    columns : dict of str to ndarray
        `POINT_COLUMNS` of shape (points,), and `EVENT_COLUMNS` of shape (events,), the events of
        one point after those of the other.
    messages : list of str
        Why each point failed; empty if it did not.
    """

    columns: dict[str, Column]
    messages: list[str]


def rows_of(points: Sequence[Settled]) -> Rows:
    """Return points as rows."""
    columns: dict[str, list[object]] = {
        "response": [RESPONSE[point.response] for point in points],
        **{name: [_of_window(point, name) for point in points] for name in WINDOW_QUANTITIES},
        "window_start": [point.window_start for point in points],
        "window_end": [point.window_end for point in points],
        "status": [STATUS["failed" if point.response == FAILED else "done"] for point in points],
        "event_count": [point.event_times.size for point in points],
    }
    for number, name in enumerate(ENDS):
        columns[name] = [point.end[number] for point in points]
    arrays: dict[str, Column] = {
        name: np.array(column, dtype=POINT_COLUMNS[name]) for name, column in columns.items()
    }
    arrays["event_time"] = np.concatenate([point.event_times for point in points])
    arrays["event_kind"] = np.concatenate([point.event_kinds for point in points])
    states = np.concatenate([point.event_states for point in points])
    arrays |= dict(zip(EVENT_STATES, states.T, strict=True))
    return Rows(arrays, [point.message for point in points])


def rows_as_bytes(rows: Rows) -> bytes:
    """Return rows as bytes that `rows_from_bytes` reads."""
    return packed(rows.columns, {"messages": json.dumps(rows.messages)})


def rows_from_bytes(content: bytes) -> Rows:
    """Return the rows that `rows_as_bytes` was given.

    Raises
    ------
    ValueError
        If it cannot have written them.
    """
    columns, texts = unpacked(content)
    absent = {*POINT_COLUMNS, *EVENT_COLUMNS} - set(columns)
    if absent or "messages" not in texts:
        raise ValueError(f"it holds no points of a sweep: it lacks {sorted(absent) or 'messages'}")
    return Rows(columns, [str(message) for message in json.loads(texts["messages"])])


def _of_window(point: Settled, name: str) -> float:
    return math.nan if point.window is None else float(getattr(point.window, name))
