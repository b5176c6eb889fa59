"""How the speed of a rotor system changes: checks of what is given, and the course it describes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import check_array, check_increasing, check_positive, check_real, shown
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Canonical
from rotor_ida.simulation.spin import Ramp, SpeedProfile, driven, through

# Radians of the fastest motion of a system, and of its spin, in a run: a step covers about five.
MOST_RADIANS = 1e9
MOST_GROWTH = 500.0
# Relative difference of two times that are the same but for rounding.
SAME_TIME = 1e-9


def rate_of(speed: object, to: object, rate: object, ramp_time: object) -> float:
    """Return the rate of a ramp of a given duration."""
    if rate is not None:
        raise InputError(f"rate must be left out with ramp_time, got {shown(rate)}")
    if to is None:
        raise InputError("to must be given with ramp_time, got None")
    span = check_positive("ramp_time", ramp_time)
    return (check_real("to", to) - check_real("speed", speed)) / span


def profile_of(
    speed: float | None,
    to: float | None,
    rate: float | None,
    speeds: Sequence[tuple[float, float]] | npt.ArrayLike | None,
    torque: tuple[float, float] | None,
    inertia: float | None,
    duration: float | None,
) -> tuple[SpeedProfile, float, dict[str, object]]:
    """Return how the speed changes, its first value, and the attributes that say so."""
    ways = {"rate": rate, "speeds": speeds, "torque": torque}
    given = [name for name, each in ways.items() if each is not None]
    if len(given) != 1:
        raise InputError(
            f"a run-up must have one of rate, speeds and torque, got {' and '.join(given) or None}"
        )
    if inertia is not None and torque is None:
        raise InputError(f"inertia must be left out without torque, got {shown(inertia)}")
    end = None if duration is None else check_positive("duration", duration)
    if speeds is not None:
        return _piece_by_piece(speeds, end)
    first = check_real("speed", speed)
    if torque is not None:
        return _by_torque(first, torque, inertia, end)
    slope = check_real("rate", rate)
    if to is None:
        if end is None:
            raise InputError("to or duration must be given with rate, got neither")
        profile = SpeedProfile((end,), (Ramp(0.0, 0.0, first, slope),))
        return profile, first, {"start_speed": first, "rate": slope}
    last = check_real("to", to)
    if slope == 0.0 or (last - first) * slope <= 0.0:
        raise InputError(
            "{name} must lead from {speed=} to {to}, got {value}",
            name="rate", speed=first, to=last, value=slope,
        )  # fmt: skip
    span = check_positive("the time of the ramp", (last - first) / slope)
    points = [(0.0, first), (span, last)]
    told: dict[str, object] = {"start_speed": first, "to": last, "rate": slope}
    return through(points, _end_after(span, end)), first, told


def _piece_by_piece(
    speeds: object, end: float | None
) -> tuple[SpeedProfile, float, dict[str, object]]:
    """Return a piecewise linear course of the speed."""
    table = check_array("speeds", speeds)
    if table.ndim != 2 or table.shape[1] != 2 or len(table) < 2:
        given = shown(table.tolist())
        raise InputError(f"speeds must be two or more pairs of time and speed, got {given}")
    check_increasing("times of speeds", table[:, 0])
    if table[0, 0] != 0.0:
        raise InputError(
            "{name} must be 0, got {value}", name="the first time of speeds",
            value=float(table[0, 0]),
        )  # fmt: skip
    points = [(float(time), float(speed)) for time, speed in table]
    with np.errstate(over="ignore"):
        slopes = np.diff(table[:, 1]) / np.diff(table[:, 0])
    check_array("the rate of speeds", slopes)
    profile = through(points, _end_after(points[-1][0], end))
    return profile, points[0][1], {"speeds": table.ravel()}


def _end_after(least: float, end: float | None) -> float:
    """Return the end of a run, no earlier than that of the change of speed."""
    if end is not None and end < least * (1.0 - SAME_TIME):
        raise InputError(
            "{name} must be at least {least}, the time of the speed change, got {value}",
            name="duration", least=least, value=end,
        )  # fmt: skip
    return max(end or least, least)


def _by_torque(
    speed: float, torque: object, inertia: object, end: float | None
) -> tuple[SpeedProfile, float, dict[str, object]]:
    """Return the course of a driven speed, if it does not run away."""
    pair = check_array("torque", torque)
    if pair.shape != (2,):
        raise InputError(f"torque must be two numbers (tau0, slope), got {shown(torque)}")
    moment = check_positive("inertia", inertia)
    if end is None:
        raise InputError("duration must be given with torque, got None")
    tau0, slope = pair.tolist()
    growth = max(-slope * end / moment, 0.0)
    reached = (abs(speed) + abs(tau0) * end / moment) * math.exp(min(growth, MOST_GROWTH))
    if not reached * end <= MOST_RADIANS:
        raise InputError(
            f"torque, inertia and duration must keep the turns below {MOST_RADIANS:g} radians, got "
            "{torque=}, {inertia=} and {duration=}, which lead to a speed of up to {speed:.3g}",
            torque=(tau0, slope), inertia=moment, duration=end, speed=reached,
        )  # fmt: skip
    profile = driven((tau0, slope), moment, end)
    return profile, speed, {"start_speed": speed, "torque": pair, "inertia": moment}


def fastest_of(profile: SpeedProfile, speed: float) -> float:
    """Return the largest size of a prescribed speed; of a driven one that at time 0."""
    speeds = [speed]
    for end, spin in zip(profile.ends, profile.spins, strict=True):
        if isinstance(spin, Ramp):
            speeds += [spin.speed, spin.speed + spin.rate * (end - spin.begin)]
    return max(map(abs, speeds))


def inertia_of(found: Canonical, profile: SpeedProfile) -> float:
    """Return the moment of inertia about the axis of rotation, 0 if the speed is prescribed.

    It is that about the centres of mass, and what the unbalance adds.
    """
    if not profile.is_driven:
        return 0.0
    (spin,) = profile.spins
    own = 1.0 / spin.piece()[3]
    return own + 0.5 * float((found.unbalance**2).sum())
