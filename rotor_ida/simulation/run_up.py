"""Run a rotor up or down: along a ramp of its speed, piece by piece, or as a torque drives it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Watch
from rotor_ida.checks import (
    AT_REST,
    check_array,
    check_between,
    check_duration,
    check_increasing,
    check_instance,
    check_nonnegative,
    check_positive,
    check_progress,
    check_real,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress, Stop, interruptible, percentage, shows_progress
from rotor_ida.results.in_si import takes_si
from rotor_ida.simulation.dataset import run_dataset
from rotor_ida.simulation.event_errors import EventErrors, estimate_event_errors
from rotor_ida.simulation.options import (
    LARGEST,
    Backend,
    Method,
    Options,
    check_can_be_followed,
)
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.run import run
from rotor_ida.simulation.sampling import FEWEST, sample_times
from rotor_ida.simulation.simulate import END_SLACK, MOST_SLACK
from rotor_ida.simulation.spin import SpeedProfile, driven, through
from rotor_ida.simulation.starts import Start, state_of

# The disc is often 10^5 eccentricities wide, and its inertia grows with the square of that.
SMALLEST_DRIVE, LARGEST_DRIVE = 1e-12, 1e15
# Powers of e above this leave the range of doubles.
LARGEST_EXPONENT = 700.0
# Below this the difference quotient of the growth is rounding.
SMALLEST_GROWTH = 1e-6
# More radians of spin, or of motion at the reference frequency, take an hour or more.
MOST_RADIANS = {"python": 1e7, "compiled": 1e8}
WAYS = "by to and rate or ramp_time, by speeds, or by torque and inertia"


@dataclass(frozen=True, slots=True)
class _SpeedChange:
    """A requested change of speed: the rotor at time 0, the profile, and the attributes."""

    rotor: Rotor
    profile: SpeedProfile
    changes: dict[str, object]

    @property
    def largest_speed(self) -> float:
        """The largest prescribed speed; with a torque, the speed at time 0."""
        if self.profile.is_driven:
            return self.rotor.omega
        ends = np.array(self.profile.ends)
        speeds = self.profile.spins_at(ends, np.empty((ends.size, 0)))["speed"]
        return max(self.rotor.omega, float(speeds.max()))


@takes_si
@shows_progress
def run_up(
    rotor: Rotor,
    *,
    start: Start = AT_REST,
    to: float | None = None,
    rate: float | None = None,
    ramp_time: float | None = None,
    speeds: Sequence[tuple[float, float]] | npt.ArrayLike | None = None,
    torque: tuple[float, float] | npt.ArrayLike | None = None,
    inertia: float | None = None,
    duration: float | None = None,
    samples: int | npt.ArrayLike | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method = "adams",
    backend: Backend = "auto",
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Simulate a rotor whose speed changes, and locate every event by root finding.

    Specify the change of speed in one of three ways: a ramp `to` another speed, at a constant
    `rate` or within a `ramp_time`; `speeds` at given times, linear in between; or a `torque` that
    accelerates the `inertia` of the rotor against damping, shaft and stator.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor
        The rotor. Its ``omega`` or ``speed`` is that at time 0, when the unbalance points along x.
        For a `DimensionalRotor` numbers with a unit are in SI units, as for `simulate`: speeds in
        rad/s, the torque in N m and N m s, the inertia in kg m^2.
    start : array_like, shape (4,), "settled", "rest" or Dataset
        ``(x, y, vx, vy)`` at time 0 [1]; default: at rest on the axis, from which a load drops it.
        ``"rest"`` is where a load holds the rotor, ``"settled"`` the steady whirl without contact,
        around the place where the shaft holds the load. A result that ends in a state
        is continued, with the unbalance along x again: a run, a limit cycle, or one point of a
        sweep or of many run-ups.
    to : float
        Speed at the end of a ramp [1].
    rate : float
        Change of speed per unit time [1], negative in a run-down.
    ramp_time : float
        Duration of the ramp [1], instead of the rate.
    speeds : sequence of (float, float)
        Pairs of time and speed [1], with times that increase from 0. The first speed replaces the
        rotor's ``omega``.
    torque : tuple of float
        ``(tau0, slope)``: the drive's torque is ``tau0 - slope speed`` [1].
    inertia : float
        Moment of inertia about the centre of mass, over mass times eccentricity squared [1].
    duration : float, optional
        Time to simulate [1]; required with a torque. Default: the time that the change of speed
        takes. After that the last speed is kept.
    samples : int or array_like, shape (n,), optional
        Increasing times at which the motion is reported [1], or the number of equally spaced times,
        both ends included. Default: as many as `simulate` takes at the largest speed of the run;
        with a torque a first run finds that speed.
    rtol, atol : float
        Relative and absolute tolerance [1], as in `simulate`.
    method : {"adams", "bdf", "ida", "taylor"}
        Solver of the contacts, as in `simulate`: CVODE with Adams or BDF, IDA, or Taylor series.
        Flight has no closed form at a changing speed: the compiled core integrates it by Taylor
        series, the reference by the method itself.
    backend : {"auto", "python", "compiled"}
        As in `simulate`.
    progress : callable or bool, optional
        As for `simulate`.

    Returns
    -------
    Dataset
        As from `simulate`, with ``speed`` and ``angle`` on ``t``, ``event_speed`` and
        ``event_angle`` on ``event``, and ``revolutions``, their number in the run. ``omega`` is the
        speed at time 0. Attributes record how the speed changed: ``to`` and ``rate``, ``speeds``
        (alternating time and speed), or ``torque`` and ``inertia``.

    Raises
    ------
    InputError
        If an argument cannot be used, or the speed would pass through zero.
    SimulationError
        If the solver gives up, or the torque lets the speed fall through zero; reports time and
        state.
    InvariantError
        If the result contradicts the mechanics; reports time and state.

    Notes
    -----
    With the angle theta of the unbalance,
    ``z'' + 2 zeta z' + kappa z + (N + i T) z/|z| = (theta'**2 - i theta'') exp(i theta)
    - i gamma``. The rim moves at ``rho theta'``. With a torque
    ``j theta'' = tau0 - slope theta' - T (rho - cos(theta - phi))
    + Im(exp(-i theta) (2 zeta z' + kappa z + N z/|z|))``. The reaction acts about the centre of
    mass; the load acts there and does not contribute. See ``docs/run_up.md``.
    ``event_time_error`` comes from a second run, as in `simulate`.

    References
    ----------
    A. Sommerfeld, "Beiträge zum dynamischen Ausbau der Festigkeitslehre", Zeitschrift des Vereines
    deutscher Ingenieure 46, 1902; F. M. Lewis, "Vibration during acceleration through a critical
    speed", Transactions of the ASME 54, 1932.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> rotor = Rotor(omega=0.2, zeta=0.07, delta0=0.8)
    >>> run = run_up(rotor, start=(0, 0, 0, 0), to=2.0, rate=0.05, samples=5)
    >>> run.t.values, run.speed.values.round(12)
    (array([ 0.,  9., 18., 27., 36.]), array([0.2 , 0.65, 1.1 , 1.55, 2.  ]))
    >>> run.event_kind.values, run.event_speed.values.round(6)
    (array([1], dtype=int8), array([0.440496]))
    >>> run = run_up(rotor, start=(0, 0, 0, 0), torque=(1, 0), inertia=20, duration=40, samples=5)
    >>> run.speed.values.round(6)
    array([0.2     , 0.622213, 0.626802, 0.790485, 0.867413])
    """
    check_instance("rotor", rotor, Rotor)
    progress = check_progress(progress)
    options = Options(rtol=rtol, atol=atol, method=method, backend=backend)
    if ramp_time is not None:
        rate = _rate_of(rotor, to, rate, ramp_time)
    given = {"to": to, "rate": rate, "speeds": speeds, "torque": torque, "inertia": inertia}
    change = _speed_change_of(
        rotor, {name: each for name, each in given.items() if each is not None}, duration, options
    )
    first = state_of("start", start, change.rotor)
    check_can_be_followed(change.rotor, first)
    end = change.profile.ends[-1]
    slack = min(END_SLACK * options.rtol, MOST_SLACK) * end

    watch: Watch = []

    def sampled(samples: object, fastest: float, stop: Stop | None) -> Orbit:
        return run(
            change.rotor, first, end, sample_times(samples, end, change.rotor, fastest), options,
            slack=slack, stop=stop, profile=change.profile, watch=watch,
        )  # fmt: skip

    def run_twice(stop: Stop | None = None) -> tuple[Orbit, EventErrors]:
        fastest = change.largest_speed
        if samples is None and change.profile.is_driven:  # the largest speed is not known before
            fastest = max(fastest, float(np.max(sampled(FEWEST, fastest, stop).speeds)))
            watch.clear()
        orbit = sampled(samples, fastest, stop)
        return orbit, estimate_event_errors(orbit, first, slack=slack, stop=stop, watch=watch)

    orbit, errors = interruptible(run_twice, told=percentage(progress, watch, 2.0 * end))
    if progress is not None:
        progress(100, 100)
    return run_dataset(orbit, first, errors, change.changes)


# ---- The requested change of speed ----


def _rate_of(rotor: Rotor, to: object, rate: object, ramp_time: object) -> float:
    """Return the rate of a ramp of a given duration, or raise `InputError`."""
    if rate is not None:
        raise InputError(f"rate must be left out with ramp_time, got {shown(rate)}")
    if to is None:
        raise InputError("to must be given with ramp_time, got None")
    return (_checked_speed("to", to) - rotor.omega) / check_positive("ramp_time", ramp_time)


def _speed_change_of(
    rotor: Rotor, given: dict[str, object], duration: float | None, options: Options
) -> _SpeedChange:
    """Return the requested change of speed, or raise `InputError`."""
    names = ", ".join(given) or "none of them"
    ways = [name for name, sign in (("to", "rate"), ("speeds", "speeds"), ("torque", "inertia"))
            if name in given or sign in given]  # fmt: skip
    if len(ways) != 1:
        raise InputError(f"the speed must change in one way, {WAYS}, got {names}")
    for pair in (("to", "rate"), ("torque", "inertia")):
        for name, other in (pair, pair[::-1]):
            if name in given and other not in given:
                or_time = " or ramp_time" if other == "rate" else ""
                raise InputError(f"{other}{or_time} must be given with {name}, got None")
    if "torque" in given:
        most = MOST_RADIANS[options.backend]
        change = _by_torque(rotor, given["torque"], given["inertia"], duration, most)
    elif "speeds" in given:
        change = _piece_by_piece(rotor, given["speeds"], duration)
    else:
        change = _by_ramp(rotor, given["to"], given["rate"], duration)
    _check_can_wait(change, options.backend)
    return change


def _check_can_wait(change: _SpeedChange, backend: str) -> None:
    """Raise `InputError` for a run-up that would take about an hour or more."""
    end = change.profile.ends[-1]
    longest = MOST_RADIANS[backend] / max(change.largest_speed, 1.0)
    if end > longest:
        raise InputError(
            "the {name} of a run-up must be at most {most:g} with backend {backend!r}, which would "
            "take an hour or more, got {value}",
            name="duration", most=longest, backend=backend, value=end,
        )  # fmt: skip


def ramp_of(rotor: Rotor, to: float, rate: float, backend: Backend = "compiled") -> SpeedProfile:
    """Return the profile of a ramp from the rotor's speed, or raise `InputError`."""
    change = _by_ramp(rotor, to, rate, None)
    _check_can_wait(change, backend)
    return change.profile


def _by_ramp(rotor: Rotor, to: object, rate: object, duration: float | None) -> _SpeedChange:
    """Return a ramp from the rotor's speed to another."""
    target, slope, omega = _checked_speed("to", to), check_real("rate", rate), rotor.omega
    if target == omega:
        raise InputError(
            "{name} must differ from the rotor's {omega=}, got {value}",
            name="to", omega=omega, value=target,
        )  # fmt: skip
    way = "positive" if target > omega else "negative"
    if slope == 0.0 or (slope > 0.0) != (target > omega):
        raise InputError(
            "{name} must be {way} to change the speed from {omega} to {to}, got {value}",
            name="rate", way=way, omega=omega, to=target, value=slope,
        )  # fmt: skip
    check_between("the size of rate", abs(slope), SMALLEST_DRIVE, LARGEST)
    ramp = check_duration("the time of the ramp", (target - omega) / slope, max(omega, target))
    end = _checked_end(duration, ramp, max(omega, target))
    profile = through([(0.0, omega), (ramp, target)], end)
    return _SpeedChange(rotor, profile, {"to": target, "rate": slope})


def _piece_by_piece(rotor: Rotor, speeds: object, duration: float | None) -> _SpeedChange:
    """Return a piecewise linear profile of the speed."""
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
        _checked_speed("a speed of speeds", value)
    with np.errstate(over="ignore"):
        slopes = np.diff(table[:, 1]) / np.diff(table[:, 0])
    for place in np.flatnonzero(np.abs(slopes) > LARGEST)[:1].tolist():
        raise InputError(
            "the {name} of speeds must lie within {most:g} of zero, got {value} from {time=} to "
            "{end_time}",
            name="rate", most=LARGEST, value=float(slopes[place]), time=times[place],
            end_time=times[place + 1],
        )  # fmt: skip
    last = check_duration("the last time of speeds", times[-1], max(values))
    end = _checked_end(duration, last, max(values))
    profile = through(list(zip(times, values, strict=True)), end)
    return _SpeedChange(replace(rotor, omega=values[0]), profile, {"speeds": table.ravel()})


def _by_torque(
    rotor: Rotor, torque: object, inertia: object, duration: float | None, most: float
) -> _SpeedChange:
    """Return a profile that a torque drives."""
    pair = check_array("torque", torque, largest=LARGEST_DRIVE)
    if pair.shape != (2,):
        raise InputError(f"torque must be two numbers (tau0, slope), got {shown(torque)}")
    tau0, slope = pair.tolist()
    moment = check_between("inertia", inertia, SMALLEST_DRIVE, LARGEST_DRIVE)
    if rotor.omega == 0.0 and tau0 <= 0.0:
        raise InputError(
            "{name} must be positive to turn a rotor that is at rest, got {value}",
            name="tau0 of torque", value=tau0,
        )  # fmt: skip
    if duration is None:
        raise InputError("duration must be given with torque, got None")
    end = check_duration("duration", duration, rotor.omega)
    _check_runaway(rotor, (tau0, slope), moment, end, most)
    return _SpeedChange(
        rotor, driven((tau0, slope), moment, end), {"torque": pair, "inertia": moment}
    )


def _check_runaway(
    rotor: Rotor, torque: tuple[float, float], inertia: float, duration: float, most: float
) -> None:
    """Raise `InputError` if a torque lets the speed run away, beyond `LARGEST` or `most` radians.

    Far above resonance the unbalance whirls at radius 1, and damping resists by ``2 zeta theta'``.
    The turns count only where nothing resists there: elsewhere resonance may hold the speed.
    """
    tau0, slope = torque
    resisted = slope + 2.0 * rotor.zeta
    if resisted * duration / inertia > most:
        raise InputError(
            "{name} must be at least {least:.3g} with {torque=} and {duration=}, or the run would "
            "take an hour or more, got {value}",
            name="inertia", least=resisted * duration / most, torque=torque, duration=duration,
            value=inertia,
        )  # fmt: skip
    growth = min(-resisted * duration / inertia, LARGEST_EXPONENT)
    faster = tau0 * duration / inertia
    mean = math.expm1(growth) / growth if growth else 1.0
    rise = (mean - 1.0) / growth if abs(growth) > SMALLEST_GROWTH else 0.5
    speed = rotor.omega * math.exp(growth) + faster * mean
    radians = (rotor.omega * mean + faster * rise) * duration if growth >= 0.0 else 0.0
    if speed > LARGEST or radians > most:
        raise InputError(
            "torque, inertia and duration must keep the speed below {most:g} and a speed that "
            "grows without bound within {radians} radians, got {torque=}, {inertia=} and "
            "{duration=}, which lead to a speed of about {omega:.3g}",
            name="omega", most=LARGEST, radians=f"{most:g}", torque=torque, inertia=inertia,
            duration=duration, omega=speed,
        )  # fmt: skip


def _checked_speed(name: str, value: object) -> float:
    """Return a speed that can be simulated, or raise `InputError`."""
    number = check_real(name, value)
    if number < 0.0:
        raise InputError(
            "{name} must be zero or positive: a run through zero is not supported, got {value}",
            name=name, value=number,
        )  # fmt: skip
    return check_nonnegative(name, number, LARGEST)


def _checked_end(duration: float | None, least: float, fastest: float) -> float:
    """Return the end of a run, no earlier than the end of the speed change."""
    if duration is None:
        return least
    end = check_duration("duration", duration, fastest)
    if end < least and not math.isclose(end, least, rel_tol=1e-12):
        raise InputError(
            "{name} must be at least {least}, the time of the speed change, got {value}",
            name="duration", least=least, value=end,
        )  # fmt: skip
    return max(end, least)
