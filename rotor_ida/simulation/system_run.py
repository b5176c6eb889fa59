"""Follow a rotor system by Taylor series, twice: the second run measures the errors of the first.

The second run has tighter tolerances and another order, so that nothing of the first is repeated to
the bit: see `rotor_ida.simulation.event_errors`. Only the first may end in an error: see
`check_status`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import shown
from rotor_ida.core.interface import DONE, OUT_OF_TABLE, message_of
from rotor_ida.core.runs import NO_STOP, Rows
from rotor_ida.core.system_requests import LAW, SystemEvents, SystemRequest, SystemResult
from rotor_ida.core.systems import follow_system
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.assembly import Assembly, Canonical
from rotor_ida.model.contact import HERTZ_EXPONENT
from rotor_ida.model.growth import FREE, rates_of
from rotor_ida.model.parameters import OF_ROTOR
from rotor_ida.simulation.event_errors import (
    APART,
    WIDENING,
    EventErrors,
    errors_of_system,
    horizon_of,
    times_of_second,
)
from rotor_ida.simulation.spin import SpeedProfile

# The tolerance of a step over that of a run.
STEP_SAFETY = 1e-3
TIGHTEST = 1e-16
STEP_SAFETY_OF_CVODE = 0.03
# Orders of the first and the second run.
ORDERS = (20, 24)
# The second run goes on for this many times the horizon, so that each event before it is in it.
ENOUGH = 2.0
# Part of the first speed below which a driven rotor stands. Speeds below this part of that have no
# sign but by rounding.
STANDING, SIGNLESS = 0.01, 1e-6


@dataclass(frozen=True, slots=True)
class Followed:
    """A run of a rotor system, with the estimated errors of its events.

    Parameters
    ----------
    result : SystemResult
        The run, in coordinates with a unit mass matrix.
    errors : EventErrors
        The errors of its events, and the horizon.
    standstill, standstill_error : float
        Since when a driven rotor has stood at the end, NaN if it does not; and the error.
    """

    result: SystemResult
    errors: EventErrors
    standstill: float
    standstill_error: float


def request_of(
    assembly: Assembly, found: Canonical, profile: SpeedProfile, start: Values, times: Values,
    duration: float, *, rtol: float, speed: float, fastest_speed: float, inertia: float,
) -> SystemRequest:  # fmt: skip
    """Return the request of a run to the core."""
    speeds = [0.0 if race is None else race.speed for race in assembly.races]
    assembly.system.check_speeds(np.append(profile.speeds, speed))
    displacement, velocity, fastest = scales_of(assembly, found.at(speed), fastest_speed, start)
    for extreme in _extreme_speeds(found, profile):
        rates = rates_of(found.at(extreme), fastest_speed)
        fastest = max(fastest, float(np.abs(rates).max()))
    _check_contact_damping(assembly, assembly.smallest_clearance * velocity / displacement)
    return SystemRequest(
        stiffness=found.stiffness, damping=found.damping, gyroscopic=found.gyroscopic,
        stiffness_rate=found.stiffness_rate, rows=found.rows, unbalance=found.unbalance,
        force=found.force, laws=laws_of(assembly), races=np.array(speeds), pieces=profile.pieces(),
        speed=speed, inertia=inertia, weight=assembly.weight,
        standing=STANDING * abs(speed) if profile.is_driven else 0.0,
        rtol=max(STEP_SAFETY * rtol, TIGHTEST), order=ORDERS[0],
        displacement=displacement, velocity=velocity, fastest=fastest, start=start, times=times,
        duration=duration, massless=found.massless, films=found.films,
    )  # fmt: skip


def _extreme_speeds(found: Canonical, profile: SpeedProfile) -> list[float]:
    """Return the speeds of a run at which films are stiffest, and at which they damp most.

    A torque may lead to any speed of their tables. Between their rows coefficients are monotone.
    """
    if not found.films:
        return []
    speeds = profile.speeds
    low, high = found.films.reach if profile.is_driven else (speeds.min(), speeds.max())
    knots = found.films.knots
    places = np.array([low, *knots[(knots > low) & (knots < high)], high])
    sizes = [
        sum(
            (each.coefficients(name, places) ** 2).sum(axis=(1, 2)) for each in found.films.bearings
        )
        for name in ("stiffness", "damping")
    ]
    return [float(places[np.argmax(each)]) for each in sizes]


def laws_of(assembly: Assembly) -> Rows:
    """Return the laws of the contacts as the core takes them."""
    laws = np.zeros(len(assembly.contacts), LAW)
    for law, each, shared in zip(laws, assembly.contacts, assembly.race_numbers, strict=True):
        is_hertz, race = each.exponent == HERTZ_EXPONENT, each.spinning_race
        law["offset"], law["clearance"] = each.centre, each.clearance
        law["hertz" if is_hertz else "linear"] = each.stiffness
        law["contact_damping"], law["friction"] = each.damping, each.friction
        law["radius"], law["race"] = each.radius or 0.0, shared
        if race is not None:
            law["race_radius"], law["inverse_race_inertia"] = race.radius, 1.0 / race.inertia
            law["race_drag"] = race.drag
    return laws


def by_method(request: SystemRequest, method: str, rtol: float) -> SystemRequest:
    """Return the request of a run at a tolerance by Taylor series or by CVODE."""
    if method == "taylor":
        return request
    return replace(request, method=method, rtol=max(STEP_SAFETY_OF_CVODE * rtol, 3e-15))


def inertia_of(found: Canonical, profile: SpeedProfile) -> float:
    """Return the moment of inertia about the axis of rotation, 0 if the speed is prescribed.

    It is that about the centres of mass, and what the unbalance adds.
    """
    if not profile.is_driven:
        return 0.0
    (spin,) = profile.spins
    own = 1.0 / spin.piece()[3]
    return own + 0.5 * float((found.unbalance**2).sum())


def _check_contact_damping(assembly: Assembly, velocity: float) -> None:
    """Refuse contacts so stiff by their damping that a touch takes minutes, as of one disc."""
    most = OF_ROTOR["contact_damping"].largest / velocity
    for each in assembly.contacts:
        if not each.damping <= most:
            raise InputError(
                "{name} must be at most {most:.3g} to be simulated, got {value}",
                name=f"damping of the contact at {shown(each.node)}", most=most, value=each.damping,
            )  # fmt: skip


def scales_of(
    assembly: Assembly, found: Canonical, fastest_speed: float, start: Values
) -> tuple[float, float, float]:
    """Return the displacement and velocity by which errors are measured, and the largest rate.

    The displacement is the smallest clearance in the coordinates y, or where there is none the size
    of the motion. The velocity belongs to it at
    the largest speed, or at the slowest vibration if that is faster.
    """
    inert = assembly.size - found.massless
    stiffness = found.stiffness[:inert, :inert]
    fastest = float(np.abs(rates_of(found, fastest_speed)).max())
    squares = np.abs(np.linalg.eigvals(stiffness))
    slow = [float(each) for each in squares if each > FREE * squares.max(initial=0.0)]
    mobilities = (found.rows[:, :, :inert] ** 2).sum(axis=2).max(axis=1, initial=0.0)
    displacement = assembly.smallest_clearance / np.sqrt(mobilities.max(initial=1.0))
    is_held = any(each.clearance for each in assembly.contacts)
    if assembly.contacts and not is_held:
        displacement = _size_of_centred(assembly, found, mobilities, start) or displacement
    for each, mobility in zip(assembly.contacts, mobilities, strict=True):
        hertz = each.exponent == HERTZ_EXPONENT
        reach = each.clearance or displacement * mobility**0.5
        slow.append(each.stiffness * mobility * (reach**0.5 if hertz else 1.0))
    rate = max(abs(fastest_speed), float(np.sqrt(min(slow, default=1.0))))
    if not is_held:
        force = np.abs(found.force) + fastest_speed**2 * np.abs(found.unbalance).sum(axis=0)
        deflection = np.linalg.lstsq(found.stiffness, force)[0]
        sizes = [np.abs(each).max() for each in (start[0], start[1] / rate, deflection)]
        displacement = max(sizes) or displacement
    return float(displacement), float(displacement * rate), max(fastest, rate)


def _size_of_centred(
    assembly: Assembly, found: Canonical, mobilities: Values, start: Values
) -> float:
    """Return the size of a motion in contacts without clearance, but for that by its velocity.

    It is that of the start, that of the unbalance of a free rotor, or how far a constant force
    presses into a contact.
    """
    sizes = [np.abs(start[0]).max(), np.abs(found.unbalance).max(initial=0.0)]
    for each, rows, mobility in zip(assembly.contacts, found.rows, mobilities, strict=True):
        depth = (np.hypot(*(rows @ found.force)) / mobility / each.stiffness) ** (1 / each.exponent)
        sizes.append(depth / np.sqrt(mobility))
    return float(max(sizes))


def with_errors(
    result: SystemResult, request: SystemRequest, by_series: bool, stop: Stop, watch: Watch,
    looser: Callable[[SystemRequest], SystemResult] | None = None,
) -> Followed:  # fmt: skip
    """Return a run with the errors of its events by a second one, by Taylor series.

    It is of another order, also than the flights of a run by CVODE, and tighter if the first is by
    Taylor series throughout. Where there is no core, `looser` makes the second run. If the second
    run fails, the errors are infinite, and the horizon is where it failed; so it is with one disc.
    """
    times = times_of_second(request, result)
    again = replace(bare(request), times=times, order=ORDERS[1])
    if by_series:
        again = replace(again, rtol=max(request.rtol / APART, TIGHTEST / APART))

    def has_parted(events: SystemEvents) -> bool:
        return events.time >= ENOUGH * horizon_of(request, result, events)

    since, error = standstill_of(result), math.inf
    try:
        other = follow_system(again, stop, watch, has_parted) if looser is None else looser(again)
        check_status(other)
    except SimulationError as failure:  # the first run is sound, but nothing bounds its errors
        if stop[0]:
            raise
        ends = 0.0 if math.isnan(failure.time) else failure.time
        unknown = EventErrors(np.full(result.event_times.size, math.inf), ends)
        return Followed(result, unknown, since, math.nan if math.isnan(since) else error)
    errors = errors_of_system(request, result, other, times)
    if since <= errors.horizon and not math.isnan(other.standstill.since):
        error = WIDENING * abs(since - other.standstill.since) + 4.0 * float(np.spacing(since))
    return Followed(result, errors, since, math.nan if math.isnan(since) else error)


def bare(request: SystemRequest) -> SystemRequest:
    """Return a run of which only the events are wanted."""
    return replace(request, times=request.times[[-1]], only_events=True, places=None)


def standstill_of(result: SystemResult) -> float:
    """Return since when a driven rotor has stood at the end of a run; NaN if it does not stand.

    One that rocks passes below the limit again and again. It stands as soon as it has been there
    for longer than ever before and, if its speed has changed its sign, than to pass at a constant
    rate would take.
    """
    limit, since, rate, longest = result.standstill
    lasts, speed = result.time - since, result.turn[1]
    reverses = speed * rate > 0.0 and abs(speed) > SIGNLESS * limit
    passing = 2.0 * limit / abs(rate) if reverses else 0.0
    return since if lasts > max(longest, passing) else math.nan


def run_to_end(
    request: SystemRequest, stop: Stop = NO_STOP, watch: Watch | None = None
) -> SystemResult:
    """Return a run by Taylor series that has reached its end."""
    result = follow_system(request, stop, watch)
    check_status(result)
    return result


def check_status(result: SystemResult) -> None:
    """Raise an error where a run has not reached its end."""
    if result.status != DONE:
        ends = f", which ends at {result.turn[1]:.6g}" if result.status == OUT_OF_TABLE else ""
        raise SimulationError(f"{message_of(result.status)}{ends}", time=result.time)
