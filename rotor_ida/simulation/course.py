"""The course of the speed in a run: held, on a ramp, piece by piece, or as a torque drives it."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rotor_ida.checks import (
    check_array,
    check_between,
    check_duration,
    check_increasing,
    check_nonnegative,
    check_positive,
    check_real,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.options import LARGEST, Backend
from rotor_ida.simulation.spin import Driven, Ramp, SpeedProfile, driven, steady, through

# Powers of e above this leave the range of doubles.
LARGEST_EXPONENT = 700.0
# Below this the difference quotient of the growth is rounding.
SMALLEST_GROWTH = 1e-6
# More radians of spin, or of motion at the reference frequency, take an hour or more; of a rotor
# system those of its fastest motion and of its spin, of which a step covers about five.
MOST_RADIANS = {"python": 1e7, "compiled": 1e8, "system": 1e9}
# Relative difference of two times that are the same but for rounding.
SAME_TIME = 1e-9
NO_STATE = np.empty(0)
WAYS = "by to and rate or ramp_time, by speeds, or by torque and inertia"


@dataclass(frozen=True, slots=True)
class Limits:
    """Which speeds and drives a kind of rotor may have.

    Parameters
    ----------
    first : str
        The name of the speed at time 0.
    backwards : bool
        Whether the speed may be negative, and a ramp may go on to the end of a run.
    largest : float
        The largest size of a speed, and of its rate.
    drive : tuple of float
        The smallest and the largest inertia.
    """

    first: str
    backwards: bool
    largest: float
    drive: tuple[float, float]

    def check_speed(self, name: str, value: object) -> float:
        """Return a speed that can be simulated, or raise `InputError`."""
        number = check_real(name, value)
        if self.backwards:
            return number
        if number < 0.0:
            raise InputError(
                "{name} must be zero or positive: a run through zero is not supported, got {value}",
                name=name, value=number,
            )  # fmt: skip
        return check_nonnegative(name, number, self.largest)

    def check_time(self, name: str, value: object, fastest: float) -> float:
        """Return a positive time; of one disc doubles must resolve a revolution at its end."""
        if self.backwards:
            return check_positive(name, value)
        return check_duration(name, value, fastest)

    def check_end(self, duration: object, least: float, fastest: float) -> float:
        """Return the end of a run, no earlier than that of the change of speed."""
        if duration is None:
            return least
        end = self.check_time("duration", duration, fastest)
        if end < least * (1.0 - SAME_TIME):
            raise InputError(
                "{name} must be at least {least}, the time of the speed change, got {value}",
                name="duration", least=least, value=end,
            )  # fmt: skip
        return max(end, least)


# A disc is often 10^5 eccentricities wide, and its inertia grows with the square of that.
DISC_LIMITS = Limits("omega", False, LARGEST, (1e-12, 1e15))
SYSTEM_LIMITS = Limits("speed", True, sys.float_info.max, (0.0, sys.float_info.max))


@dataclass(frozen=True, slots=True)
class Course:
    """How the speed of a rotor changes in a run.

    Parameters
    ----------
    profile : SpeedProfile
        The profile of the speed.
    speed : float
        The speed at time 0.
    told : dict
        What was requested, as attributes of the run.
    """

    profile: SpeedProfile
    speed: float
    told: dict[str, object]

    @property
    def end(self) -> float:
        """The end of the run."""
        return self.profile.ends[-1]

    @property
    def drive(self) -> Driven:
        """The torque and the inertia of a driven speed."""
        (spin,) = self.profile.spins
        assert isinstance(spin, Driven)
        return spin

    @property
    def largest_speed(self) -> float:
        """The largest size of a prescribed speed; of a driven one that at time 0."""
        if self.profile.is_driven:
            return abs(self.speed)
        last = zip(self.profile.ends, self.profile.spins, strict=True)
        return max(abs(self.speed), *(abs(float(spin.at(end, NO_STATE)[1])) for end, spin in last))


def held(speed: float, duration: float) -> Course:
    """Return the course of a constant speed."""
    return Course(steady(speed, duration), speed, {"speed": speed})


def course_of(
    first: object, given: Mapping[str, object], duration: object, limits: Limits
) -> Course:
    """Return a changing speed, or raise `InputError`.

    Parameters
    ----------
    first : float
        The speed at time 0; that of pieces replaces it.
    given : mapping
        The arguments ``to rate ramp_time speeds torque inertia`` of a run-up, or None.
    duration : float, optional
        The end of the run.
    limits : Limits
        Those of the kind of rotor.

    Examples
    --------
    >>> course = course_of(0.5, {"to": 2.0, "ramp_time": 10.0}, None, DISC_LIMITS)
    >>> course.end, course.largest_speed, course.told
    (10.0, 2.0, {'to': 2.0, 'rate': 0.15})
    """
    given = {name: each for name, each in given.items() if each is not None}
    if "ramp_time" in given:
        given = _with_rate(first, given, limits)
    ways = [name for name, beside in (("to", "rate"), ("speeds", "speeds"), ("torque", "inertia"))
            if name in given or beside in given]  # fmt: skip
    if len(ways) != 1:
        names = ", ".join(given) or "none of them"
        raise InputError(f"the speed must change in one way, {WAYS}, got {names}")
    for name, other in (("to", "rate"), ("torque", "inertia"), ("inertia", "torque")):
        if name in given and other not in given:
            or_time = " or ramp_time" if other == "rate" else ""
            raise InputError(f"{other}{or_time} must be given with {name}, got None")
    if "speeds" in given:
        return _piece_by_piece(given["speeds"], duration, limits)
    speed = check_real(limits.first, first)
    course = (_by_torque if "torque" in given else _by_ramp)(speed, given, duration, limits)
    if limits.backwards:
        course.told["start_speed"] = speed
    return course


def ramp_of(rotor: Rotor, to: float, rate: float, backend: Backend = "compiled") -> SpeedProfile:
    """Return the profile of a ramp from the speed of a disc, or raise `InputError`."""
    course = course_of(rotor.omega, {"to": to, "rate": rate}, None, DISC_LIMITS)
    check_can_wait(course, rotor, backend)
    return course.profile


def _with_rate(first: object, given: Mapping[str, object], limits: Limits) -> dict[str, object]:
    """Return what is given of a ramp with its rate instead of its duration."""
    given = dict(given)
    if "rate" in given:
        raise InputError(f"rate must be left out with ramp_time, got {shown(given['rate'])}")
    if "to" not in given:
        raise InputError("to must be given with ramp_time, got None")
    span = check_positive("ramp_time", given.pop("ramp_time"))
    change = limits.check_speed("to", given["to"]) - check_real(limits.first, first)
    return {"to": given.pop("to"), "rate": change / span, **given}


def _by_ramp(first: float, given: Mapping[str, object], duration: object, limits: Limits) -> Course:
    """Return a ramp from a speed to another, or of a rotor system to the end of the run."""
    slope = check_real("rate", given["rate"])
    if "to" not in given:
        if not limits.backwards:
            raise InputError("to must be given with rate, got None")
        if duration is None:
            raise InputError("to or duration must be given with rate, got neither")
        end = limits.check_time("duration", duration, abs(first))
        return Course(SpeedProfile((end,), (Ramp(0.0, 0.0, first, slope),)), first, {"rate": slope})
    target, begins = limits.check_speed("to", given["to"]), {limits.first: first}
    if target == first:
        raise InputError(
            f"{{name}} must differ from the rotor's {{{limits.first}=}}, got {{value}}",
            name="to", value=target, **begins,
        )  # fmt: skip
    way = "positive" if target > first else "negative"
    if slope == 0.0 or (slope > 0.0) != (target > first):
        raise InputError(
            f"{{name}} must be {way} to change the speed from {{{limits.first}}} to {{to}}, got "
            "{value}",
            name="rate", to=target, value=slope, **begins,
        )  # fmt: skip
    check_between("the size of rate", abs(slope), limits.drive[0], limits.largest)
    fastest = max(abs(first), abs(target))
    ramp = limits.check_time("the time of the ramp", (target - first) / slope, fastest)
    end = limits.check_end(duration, ramp, fastest)
    profile = through([(0.0, first), (ramp, target)], end)
    return Course(profile, first, {"to": target, "rate": slope})


def _piece_by_piece(speeds: object, duration: object, limits: Limits) -> Course:
    """Return a piecewise linear course of the speed."""
    table = check_array("speeds", speeds)
    if table.ndim != 2 or table.shape[1] != 2 or len(table) < 2:
        raise InputError(
            "{name} must be two or more pairs of time and speed, got {value}",
            name="speeds", value=table.tolist(),
        )  # fmt: skip
    times, values = table.T.tolist()
    if times[0] != 0.0:
        raise InputError(
            "the first {name} of speeds must be 0, got {value}", name="time", value=times[0]
        )
    check_increasing("times of speeds", table[:, 0])
    for value in values:
        limits.check_speed("a speed of speeds", value)
    with np.errstate(over="ignore"):
        slopes = np.diff(table[:, 1]) / np.diff(table[:, 0])
    for place in np.flatnonzero(np.abs(slopes) > limits.largest)[:1].tolist():
        raise InputError(
            "the {name} of speeds must lie within {most:g} of zero, got {value} from {time=} to "
            "{end_time}",
            name="rate", most=limits.largest, value=float(slopes[place]), time=times[place],
            end_time=times[place + 1],
        )  # fmt: skip
    last = limits.check_time("the last time of speeds", times[-1], max(values))
    end = limits.check_end(duration, last, max(values))
    profile = through(list(zip(times, values, strict=True)), end)
    return Course(profile, values[0], {"speeds": table.ravel()})


def _by_torque(
    first: float, given: Mapping[str, object], duration: object, limits: Limits
) -> Course:
    """Return a course that a torque drives."""
    pair = check_array("torque", given["torque"], largest=limits.drive[1])
    if pair.shape != (2,):
        raise InputError(f"torque must be two numbers (tau0, slope), got {shown(given['torque'])}")
    tau0, slope = pair.tolist()
    moment = check_between("inertia", given["inertia"], *limits.drive)
    if first == 0.0 and tau0 <= 0.0 and not limits.backwards:
        raise InputError(
            "{name} must be positive to turn a rotor that is at rest, got {value}",
            name="tau0 of torque", value=tau0,
        )  # fmt: skip
    if duration is None:
        raise InputError("duration must be given with torque, got None")
    end = limits.check_time("duration", duration, first)
    told = {"torque": pair, "inertia": moment}
    course = Course(driven((tau0, slope), moment, end), first, told)
    if limits.backwards:
        _check_turns(course)
    return course


# ---- Courses that would take too long ----


def check_can_wait(course: Course, rotor: Rotor, backend: str) -> None:
    """Raise `InputError` for a run-up of one disc that could take about an hour or more."""
    if course.profile.is_driven:
        _check_runaway(course, rotor.zeta, MOST_RADIANS[backend])
    check_length(course.end, course.largest_speed, backend)


def check_length(end: float, fastest: float, backend: str) -> None:
    """Raise `InputError` for a run of one disc with too many revolutions."""
    longest = MOST_RADIANS[backend] / max(fastest, 1.0)
    if end > longest:
        raise InputError(
            "the {name} of a run must be at most {most:g} with backend {backend!r}: a longer one "
            "may take an hour or more, got {value}",
            name="duration", most=longest, backend=backend, value=end,
        )  # fmt: skip


def _check_runaway(course: Course, zeta: float, most: float) -> None:
    """Raise `InputError` if a torque lets the speed run away, beyond `LARGEST` or `most` radians.

    Far above resonance the unbalance whirls at radius 1, and damping resists by ``2 zeta theta'``.
    The turns count only where nothing resists there: elsewhere resonance may hold the speed.
    """
    drive, omega, duration = course.drive, course.speed, course.end
    torque, inertia = (drive.torque, drive.slope), drive.inertia
    resisted = drive.slope + 2.0 * zeta
    if resisted * duration / inertia > most:
        raise InputError(
            "{name} must be at least {least:.3g} with {torque=} and {duration=}, or the run would "
            "take an hour or more, got {value}",
            name="inertia", least=resisted * duration / most, torque=torque, duration=duration,
            value=inertia,
        )  # fmt: skip
    growth = min(-resisted * duration / inertia, LARGEST_EXPONENT)
    faster = drive.torque * duration / inertia
    mean = math.expm1(growth) / growth if growth else 1.0
    rise = (mean - 1.0) / growth if abs(growth) > SMALLEST_GROWTH else 0.5
    speed = omega * math.exp(growth) + faster * mean
    radians = (omega * mean + faster * rise) * duration if growth >= 0.0 else 0.0
    if speed > LARGEST or radians > most:
        raise InputError(
            "torque, inertia and duration must keep the speed below {most:g} and a speed that "
            "grows without bound within {radians} radians, got {torque=}, {inertia=} and "
            "{duration=}, which lead to a speed of about {omega:.3g}",
            name="omega", most=LARGEST, radians=f"{most:g}", torque=torque, inertia=inertia,
            duration=duration, omega=speed,
        )  # fmt: skip


def _check_turns(course: Course) -> None:
    """Raise `InputError` if a torque may turn a rotor system too often, whatever resists."""
    drive, duration, most = course.drive, course.end, MOST_RADIANS["system"]
    growth = max(-drive.slope * duration / drive.inertia, 0.0)
    gained = abs(drive.torque) * duration / drive.inertia
    reached = (abs(course.speed) + gained) * math.exp(min(growth, LARGEST_EXPONENT))
    if not reached * duration <= most:
        raise InputError(
            f"torque, inertia and duration must keep the turns below {most:g} radians, got "
            "{torque=}, {inertia=} and {duration=}, which lead to a speed of up to {speed:.3g}",
            torque=(drive.torque, drive.slope), inertia=drive.inertia, duration=duration,
            speed=reached,
        )  # fmt: skip
