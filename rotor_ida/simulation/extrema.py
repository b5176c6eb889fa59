"""Local maxima and minima of the distance from the bearing axis, found by the core."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import MOST_NUMBERS, State
from rotor_ida.core.interface import DONE, message_of
from rotor_ida.core.runs import RunRequest, follow_run
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.flow import ATOL

# Kinds of an extremum.
MINIMUM, CONSTANT, MAXIMUM = -1, 0, 1
# Knots are samples that show whether the radius is constant; extrema lie anywhere between them.
KNOTS_A_REVOLUTION = 64
KNOTS_A_TIME = 16
# A radius that varies by less than this fraction is constant. A sweep accepts deviations of 1e-9
# from the mean of a steady whirl, which is below this.
CONSTANT_WITHIN = 1e-8


@dataclass(frozen=True, slots=True)
class Extrema:
    """The extrema of the radius of one motion, in order of time.

    Parameters
    ----------
    times, radii : ndarray, shape (n,)
        Times from the start and distances from the bearing axis [dimensionless].
    kinds : ndarray of int8, shape (n,)
        -1 minimum, 1 maximum, 0 constant radius.
    states : ndarray, shape (n, 4)
        ``(x, y, vx, vy)`` there, on the rotating axes [dimensionless].
    """

    times: Values
    radii: Values
    kinds: npt.NDArray[np.int8]
    states: Values


def radius_extrema(
    rotor: Rotor, start: State, duration: float, rtol: float, stop: Stop, watch: Watch | None = None
) -> Extrema:
    """Return the extrema of the radius from `start`, given on the rotating axes.

    If the radius is constant, return one row with its mean. Raise `SimulationError` if the
    integration is stuck, or stopped.
    """
    times = np.linspace(0.0, duration, math.ceil(duration * _knots_a_time(rotor)) + 1)
    result = follow_run(
        RunRequest(
            rotor=rotor, start=start, duration=duration, rtol=rtol, atol=ATOL * rtol,
            sample_times=times, extrema=True, stop=stop, watch=watch,
        )
    )  # fmt: skip
    if result.status != DONE:
        state = rotated(result.state, rotor.omega * result.time).tolist()
        raise SimulationError(
            f"the motion could not be followed to its extrema: {message_of(result.status)}",
            time=result.time, state=tuple(state),
        )  # fmt: skip
    radius = np.hypot(result.samples[:, 0], result.samples[:, 1])
    if np.ptp(radius) <= CONSTANT_WITHIN * radius.max():
        kinds = np.array([CONSTANT], dtype=np.int8)
        return Extrema(times[:1], radius.mean(keepdims=True), kinds, result.samples[:1])
    rows = result.extrema
    return Extrema(rows["time"], rows["radius"], rows["kind"].astype(np.int8), rows["state"])


def check_knots(name: str, rotor: Rotor, duration: float) -> None:
    """Raise `InputError` for a time with more knots than fit into memory."""
    longest = MOST_NUMBERS / _knots_a_time(rotor)
    if duration > longest:
        raise InputError(
            "{name} must be at most {most:.6g}, got {value}",
            name=name, most=longest, value=duration,
        )  # fmt: skip


def _knots_a_time(rotor: Rotor) -> float:
    return max(KNOTS_A_REVOLUTION * rotor.omega / (2.0 * math.pi), KNOTS_A_TIME)
