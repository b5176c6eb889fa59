"""The extrema of the radius on a run-up or run-down, speed by speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import State
from rotor_ida.core.interface import DONE, message_of
from rotor_ida.core.runs import RunRequest, follow_run
from rotor_ida.errors import SimulationError
from rotor_ida.model.parameters import Rotor
from rotor_ida.parallel import FailedJob, Stop, choose, run_all
from rotor_ida.schema import RESPONSE, STATUS, labelled
from rotor_ida.simulation.extrema import CONSTANT
from rotor_ida.simulation.neighbours import ATOL
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.spin import through

# Of a whirl that a run-up follows the radius drifts, and trembles by less than this part of it.
TREMBLES_WITHIN = 1e-6


@dataclass(frozen=True, slots=True)
class Passage:
    """What a run-up does near one speed.

    Parameters
    ----------
    speed : float
        The speed [1].
    speeds, radii : ndarray, shape (n,)
        Speeds and distances from the bearing axis at the extrema [1], in order of time; where the
        radius has none, the speed itself and the radius there.
    kinds : ndarray of int8, shape (n,)
        -1 minimum, 1 maximum, 0 where the radius has no extremum.
    smallest, largest : float
        Range of the radius [1].
    response : int
        What the rotor does, a flag of `schema.RESPONSE`: whether it touches, and whether its radius
        swings.
    """

    speed: float
    speeds: Values
    radii: Values
    kinds: npt.NDArray[np.int8]
    smallest: float
    largest: float
    response: int


# A sweep of the first speed, and what the run from each of its ends does near each speed.
Runs = tuple[xr.Dataset, list[list[Passage]]]


def ramp_extrema(
    rotor: Rotor, start: State, speeds: Values, rate: float, rtol: float, stop: Stop
) -> list[Passage]:
    """Return what a run from the first of some speeds to the last does near each of them.

    Near a speed means up to the middles between it and its neighbours. The speeds rise or fall, and
    `rotor` has the first of them. SimulationError if the integration was stuck, or asked to stop.
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
    at_marks = np.hypot(seen.samples[:, 0], seen.samples[:, 1])
    met = speeds[0] + way * rate * seen.extrema["time"]
    radii, kinds = seen.extrema["radius"], seen.extrema["kind"].astype(np.int8)
    passages = []
    for speed, ends in zip(speeds, np.stack([edges[:-1], edges[1:]], axis=1), strict=True):
        low, high = np.sort(ends)
        here = (met >= low) & (met <= high)
        beside = at_marks[(marks >= low) & (marks <= high)]
        own = float(at_marks[np.argmin(np.abs(marks - speed))])
        turning = met[here], radii[here], kinds[here]
        passages.append(_passage(float(speed), own, beside, turning, rotor.delta0))
    return passages


def _passage(
    speed: float,
    radius: float,
    beside: Values,
    turning: tuple[Values, Values, npt.NDArray[np.int8]],
    delta0: float,
) -> Passage:
    """Return what happens near a speed, from the radii at marks beside and at the extrema."""
    met, radii, kinds = turning
    everywhere = np.concatenate([beside, radii])
    smallest, largest = float(everywhere.min()), float(everywhere.max())
    around = np.concatenate([radii[:1], radii, radii[-1:]])
    swings = np.maximum(np.abs(radii - around[:-2]), np.abs(radii - around[2:]))
    wide = swings > TREMBLES_WITHIN * largest
    if largest < delta0:
        word = "contact_free"
    elif not wide.any():
        word = "synchronous"
    else:
        word = "bouncing" if smallest < delta0 else "full_contact"
    if not wide.any():
        met, radii = np.array([speed]), np.array([radius])
        kinds, wide = np.array([CONSTANT], dtype=np.int8), np.array([True])
    return Passage(speed, met[wide], radii[wide], kinds[wide], smallest, largest, RESPONSE[word])


# ---- Many of them ----


def run_through(
    settled: xr.Dataset,
    jobs: Iterator[tuple[Rotor, State]],
    due: npt.NDArray[np.intp],
    course: tuple[Values, float],
    how: tuple[Options, int | None, str],
) -> Runs:
    """Return what runs do near each speed, from where a sweep has settled at the first of them.

    `jobs` are the rotors and starts of the points of the sweep with the numbers `due`; `course`
    are the speeds in the order in which they are passed, and the rate; `how` are the options, the
    number of workers and what does the work.
    """
    (speeds, rate), (options, workers, executor) = course, how
    status, message = settled["status"].values.ravel(), settled["message"].values.ravel().tolist()
    passages: list[list[Passage]] = [[] for _ in range(status.size)]
    place, count = choose(executor, workers, compiled=options.backend != "python")
    work = partial(_passages, speeds=speeds, rate=rate, rtol=options.step_rtol)
    with closing(run_all(work, jobs, workers=count, executor=place)) as ended:
        for number, found in ended:
            if isinstance(found, FailedJob):
                status[due[number]], message[due[number]] = STATUS["failed"], found.reason
            else:
                passages[int(due[number])] = sorted(found, key=lambda each: each.speed)
    shape, dims = settled["status"].shape, settled["status"].dims
    told = settled.assign(
        status=labelled("status", dims, status.reshape(shape)),
        message=labelled("message", dims, np.array(message).reshape(shape)),
    )
    return told, passages


def _passages(
    job: tuple[Rotor, State], stop: Stop, *, speeds: Values, rate: float, rtol: float
) -> list[Passage] | FailedJob:
    """Return what one run does near each speed, or why it cannot be followed."""
    rotor, start = job
    if stop[0]:
        return FailedJob("given up")
    try:
        return ramp_extrema(rotor, start, speeds, rate, rtol, stop)
    except SimulationError as error:
        return FailedJob(str(error))


def joined(parts: Sequence[Runs], speeds: Values, turns: Sequence[int]) -> xr.Dataset:
    """Return the diagram of runs in each direction, speeds first and directions last."""
    first = parts[0][0]
    dims, shape = first["status"].dims, first["status"].shape  # of one speed
    rows = [
        passages[number][place] if passages[number] else None
        for place in range(speeds.size)
        for number in range(int(np.prod(shape)))
        for _, passages in parts
    ]
    failed = RESPONSE["failed"]
    full = (speeds.size, *shape[1:], len(turns))
    empty = np.empty(0), np.empty(0), np.empty(0, np.int8)
    tables = [(row.speeds, row.radii, row.kinds) if row else empty for row in rows]
    points = {
        "response": np.array([row.response if row else failed for row in rows], np.int8),
        "radius_min": np.array([row.smallest if row else np.nan for row in rows]),
        "radius_max": np.array([row.largest if row else np.nan for row in rows]),
        "extremum_count": np.array([met.size for met, _, _ in tables]),
    }
    columns = {
        name: labelled(name, "extremum", np.concatenate([table[place] for table in tables]))
        for place, name in enumerate(("extremum_speed", "extremum_radius", "extremum_kind"))
    }
    per_run = {
        name: np.broadcast_to(np.stack([part[name].values for part, _ in parts], axis=-1), full)
        for name in ("status", "message")
    }
    dims = (*dims, "direction")
    found = first.drop_vars([*first.data_vars, "omega"]).assign_coords(
        omega=labelled("omega", "omega", speeds),
        direction=labelled("direction", "direction", np.array(turns, np.int8)),
    )
    found = found.assign(
        {name: labelled(name, dims, each.reshape(full)) for name, each in points.items()}
        | {name: labelled(name, dims, each.copy()) for name, each in per_run.items()}
        | columns
    )
    found["extremum_count"].attrs["sample_dimension"] = "extremum"
    return found
