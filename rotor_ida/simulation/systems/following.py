"""Follow a rotor system by Taylor series, twice: the second run measures the errors of the first.

The second run has tighter tolerances and another order, so that nothing of the first is repeated to
the bit. The error of an event is the difference of the two, or the largest of those of the few
events before it at the same contact, as a difference may vanish by chance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import shown
from rotor_ida.core.interface import DONE, message_of
from rotor_ida.core.runs import NO_STOP
from rotor_ida.core.systems import LAW, SystemEvents, SystemRequest, SystemResult, follow_system
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.assembly import Assembly, Canonical
from rotor_ida.model.contact import HERTZ_EXPONENT
from rotor_ida.model.growth import FREE, rates_of
from rotor_ida.model.parameters import OF_ROTOR
from rotor_ida.simulation.spin import SpeedProfile

# The tolerance of a step over that of a run.
STEP_SAFETY = 1e-3
TIGHTEST = 1e-16
# Orders of the first and the second run.
ORDERS = (20, 24)
APART = 30.0
# As in `rotor_ida.simulation.event_errors`: a safety factor, how many events before count, and how
# near two events must be, in parts of the time to the next, to be the same.
WIDENING, MEMORY, SAME_EVENT = 10.0, 4, 0.25
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
    event_time_errors : ndarray, shape (event,)
        Errors; infinite after the horizon.
    horizon : float
        Time up to which the start determines the motion at these tolerances.
    standstill, standstill_error : float
        Since when a driven rotor has stood at the end, NaN if it does not; and the error.
    """

    result: SystemResult
    event_time_errors: Values
    horizon: float
    standstill: float
    standstill_error: float


def request_of(
    assembly: Assembly, found: Canonical, profile: SpeedProfile, start: Values, times: Values,
    duration: float, *, rtol: float, speed: float, fastest_speed: float, inertia: float,
) -> SystemRequest:  # fmt: skip
    """Return the request of a run to the core."""
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
    speeds = [0.0 if race is None else race.speed for race in assembly.races]
    displacement, velocity, fastest = scales_of(assembly, found, fastest_speed, start)
    _check_contact_damping(assembly, assembly.smallest_clearance * velocity / displacement)
    return SystemRequest(
        stiffness=found.stiffness, damping=found.damping, gyroscopic=found.gyroscopic,
        stiffness_rate=found.stiffness_rate, rows=found.rows, unbalance=found.unbalance,
        force=found.force, laws=laws, races=np.array(speeds), pieces=profile.pieces(),
        speed=speed, inertia=inertia, weight=assembly.weight,
        standing=STANDING * abs(speed) if profile.is_driven else 0.0,
        rtol=max(STEP_SAFETY * rtol, TIGHTEST), order=ORDERS[0],
        displacement=displacement, velocity=velocity, fastest=fastest, start=start, times=times,
        duration=duration, massless=found.massless,
    )  # fmt: skip


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

    The displacement is the smallest clearance in the coordinates y, or without contacts the size of
    the motion. The velocity belongs to it at
    the largest speed, or at the slowest vibration if that is faster.
    """
    inert = assembly.size - found.massless
    stiffness = found.stiffness[:inert, :inert]
    fastest = float(np.abs(rates_of(found, fastest_speed)).max())
    squares = np.abs(np.linalg.eigvals(stiffness))
    slow = [float(each) for each in squares if each > FREE * squares.max(initial=0.0)]
    mobilities = (found.rows[:, :, :inert] ** 2).sum(axis=2).max(axis=1, initial=0.0)
    for each, mobility in zip(assembly.contacts, mobilities, strict=True):
        hertz = each.exponent == HERTZ_EXPONENT
        slow.append(each.stiffness * mobility * (each.clearance**0.5 if hertz else 1.0))
    rate = max(abs(fastest_speed), float(np.sqrt(min(slow, default=1.0))))
    displacement = assembly.smallest_clearance / np.sqrt(mobilities.max(initial=1.0))
    if not assembly.contacts:
        force = np.abs(found.force) + fastest_speed**2 * np.abs(found.unbalance).sum(axis=0)
        deflection = np.linalg.lstsq(found.stiffness, force)[0]
        sizes = [np.abs(each).max() for each in (start[0], start[1] / rate, deflection)]
        displacement = max(sizes) or displacement
    return float(displacement), float(displacement * rate), max(fastest, rate)


def follow_twice(
    request: SystemRequest, stop: Stop = NO_STOP, watch: Watch | None = None
) -> Followed:
    """Return a run and the errors of its events."""
    result = follow_system_again(request, stop, watch)
    tighter = replace(
        request, rtol=max(request.rtol / APART, TIGHTEST / APART), order=ORDERS[1],
        times=request.times[[-1]], only_events=True,
    )  # fmt: skip

    def has_parted(events: SystemEvents) -> bool:
        horizon = errors_of(result, events, len(request.laws), request.duration)[1]
        return events.time >= ENOUGH * horizon

    other = follow_system(tighter, stop, watch, has_parted)
    check_status(other)
    return compared(result, other, request)


def compared_with_series(
    result: SystemResult, request: SystemRequest, stop: Stop, watch: Watch
) -> Followed:
    """Return a run with the errors of its events by one by Taylor series."""
    bare = replace(request, times=request.times[[-1]], only_events=True)
    return compared(result, follow_system_again(bare, stop, watch), request)


def compared(result: SystemResult, other: SystemResult, request: SystemRequest) -> Followed:
    """Return a run with the errors of its events by another one."""
    errors, horizon = errors_of(result, other, len(request.laws), request.duration)
    since, error = standstill_of(result), math.inf
    if since <= horizon and not math.isnan(other.standstill.since):
        error = WIDENING * abs(since - other.standstill.since) + 4.0 * float(np.spacing(since))
    return Followed(result, errors, horizon, since, math.nan if math.isnan(since) else error)


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


def follow_system_again(
    request: SystemRequest, stop: Stop = NO_STOP, watch: Watch | None = None
) -> SystemResult:
    """Return a run by Taylor series that has reached its end."""
    result = follow_system(request, stop, watch)
    check_status(result)
    return result


def check_status(result: SystemResult) -> None:
    """Raise an error where a run has not reached its end."""
    if result.status != DONE:
        raise SimulationError(f"{message_of(result.status)} at t = {result.time:.17g}")


def shifts_of(result: SystemResult, request: SystemRequest, stop: Stop, watch: Watch) -> Values:
    """Return how far the events of a run move in another one; infinite from where they differ."""
    other = follow_system_again(
        replace(request, times=request.times[[-1]], only_events=True), stop, watch
    )
    shifts = np.full(result.event_times.size, np.inf)
    for contact in range(len(request.laws)):
        own, _, differences = _matched(result, other, contact)
        shifts[own[: differences.size]] = differences
    return shifts


def _matched(
    result: SystemResult, other: SystemResult | SystemEvents, contact: int
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], Values]:
    """Return the events of a contact in two runs, and the differences of those that are the same.

    They are the same up to the first that differs in kind, or by a quarter of the time to the next.
    """
    own = np.flatnonzero(result.event_contacts == contact)
    others = np.flatnonzero(other.event_contacts == contact)
    count = min(own.size, others.size)
    times, other_times = result.event_times[own], other.event_times[others[:count]]
    gaps = np.diff(times, prepend=-np.inf, append=np.inf)
    reach = SAME_EVENT * np.minimum(gaps[:-1], gaps[1:])[:count]
    differences = np.abs(times[:count] - other_times)
    same = result.event_kinds[own[:count]] == other.event_kinds[others[:count]]
    same &= differences <= reach
    return own, others, differences[: count if same.all() else int(np.argmin(same))]


def errors_of(
    result: SystemResult, other: SystemResult | SystemEvents, contacts: int, duration: float
) -> tuple[Values, float]:
    """Return the errors of the events of a run by another one, and the horizon."""
    errors = np.full(result.event_times.size, np.inf)
    horizon = duration
    for contact in range(contacts):
        own, others, differences = _matched(result, other, contact)
        times, good = result.event_times[own], differences.size
        largest = differences.copy()
        for back in range(1, MEMORY):
            np.maximum(largest[back:], differences[: max(good - back, 0)], out=largest[back:])
        spans = np.sqrt(1.0 + np.arange(good))
        rounding = 4.0 * np.spacing(times[:good]) * spans
        errors[own[:good]] = WIDENING * largest + rounding
        if good < own.size:
            horizon = min(horizon, float(times[good]))
        elif others.size > own.size:
            horizon = min(horizon, float(other.event_times[others[own.size]]))
    errors[result.event_times > horizon] = np.inf
    return errors, horizon
