"""The extrema of the radius near each speed of a run-up or run-down at a rate."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import State
from rotor_ida.core.interface import DONE, message_of
from rotor_ida.core.runs import RunRequest, follow_run
from rotor_ida.errors import SimulationError
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import RESPONSE
from rotor_ida.simulation.crossings import CONSTANT
from rotor_ida.simulation.flow import ATOL
from rotor_ida.simulation.spin import through
from rotor_ida.steady.grid import Answer, Table

# On a run-up the radius of a whirl drifts; oscillations below this fraction of it are ignored.
TREMBLES_WITHIN = 1e-6


# The columns with a number for each extremum: kinds are -1 minimum, 1 maximum, 0 no extremum.
EXTREMUM = np.dtype([("extremum_radius", np.float64), ("extremum_kind", np.int8)])
EXTREMUM_AT_A_RATE = np.dtype([*EXTREMUM.descr, ("extremum_speed", np.float64)])


def table_of(kind: np.dtype[np.void], *columns: npt.NDArray[Any]) -> Table:
    """Return columns as a table."""
    found = np.empty(columns[0].size, kind)
    for name, column in zip(kind.names or (), columns, strict=True):
        found[name] = column
    return found


def ramp_extrema(
    rotor: Rotor, start: State | Values, speeds: Values, rate: float, rtol: float, stop: Stop
) -> list[Answer]:
    """Return the motion near each speed of a run from the first to the last: up to halfway.

    The speeds increase or decrease, and `rotor` has the first. The answers have the range of the
    radius, a response that tells whether the rotor touches and whether its radius oscillates, and
    the extrema in order of time; without any, the speed itself and the radius there. Raise
    `SimulationError` if the integration is stuck, or stopped.
    """
    way = 1.0 if speeds[-1] > speeds[0] else -1.0
    middles = 0.5 * (speeds[1:] + speeds[:-1])
    edges = np.concatenate([speeds[:1], middles, speeds[-1:]])
    marks = np.unique(np.concatenate([edges, speeds]))[:: int(way)]
    times = np.abs(marks - speeds[0]) / rate
    course = through([(0.0, float(speeds[0])), (float(times[-1]), float(speeds[-1]))], times[-1])
    seen = follow_run(
        RunRequest(
            rotor=rotor, start=start, duration=float(times[-1]), rtol=rtol, atol=ATOL * rtol,
            sample_times=times, extrema=True, pieces=course.pieces(), stop=stop,
        )
    )  # fmt: skip
    if seen.status != DONE:
        raise SimulationError(
            f"the run-up could not be followed: {message_of(seen.status)}",
            time=seen.time, state=seen.state,
        )  # fmt: skip
    radii_at_marks = np.hypot(seen.samples[:, 0], seen.samples[:, 1])
    speeds_at_extrema = speeds[0] + way * rate * seen.extrema["time"]
    radii, kinds = seen.extrema["radius"], seen.extrema["kind"].astype(np.int8)
    bands = []
    for speed, ends in zip(speeds, np.stack([edges[:-1], edges[1:]], axis=1), strict=True):
        low, high = np.sort(ends)
        here = (speeds_at_extrema >= low) & (speeds_at_extrema <= high)
        rows = (speeds_at_extrema[here], radii[here], kinds[here])
        beside = radii_at_marks[(marks >= low) & (marks <= high)]
        radius = float(radii_at_marks[np.argmin(np.abs(marks - speed))])
        bands.append(_classified(float(speed), radius, rows, beside, rotor.delta0))
    return bands


def _classified(
    speed: float, radius: float, rows: tuple[Values, Values, npt.NDArray[np.int8]], beside: Values,
    delta0: float,
) -> Answer:  # fmt: skip
    """Return a band of speeds by the rows of its extrema, without those of negligible oscillations.

    `radius` is that at its speed, and `beside` are those at its ends too.
    """
    speeds, radii, kinds = rows
    everywhere = np.concatenate([beside, radii])
    smallest, largest = float(everywhere.min()), float(everywhere.max())
    around = np.concatenate([radii[:1], radii, radii[-1:]])
    swings = np.maximum(np.abs(radii - around[:-2]), np.abs(radii - around[2:]))
    wide = swings > TREMBLES_WITHIN * largest
    oscillates = bool(wide.any())
    if largest < delta0:
        word = "contact_free"
    elif oscillates:
        word = "bouncing" if smallest < delta0 else "full_contact"
    else:
        word = "synchronous"
    speeds, radii, kinds = speeds[wide], radii[wide], kinds[wide]
    if not oscillates:
        speeds, radii = np.array([speed]), np.array([radius])
        kinds = np.array([CONSTANT], dtype=np.int8)
    figures = {
        "response": RESPONSE[word], "radius_min": smallest, "radius_max": largest,
        "event_count": radii.size, "extremum_count": radii.size,
    }  # fmt: skip
    return Answer(figures, events=table_of(EXTREMUM_AT_A_RATE, radii, kinds, speeds))
