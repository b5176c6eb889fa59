"""Simulate a rotor system at a constant or a changing speed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import (
    SAMPLES_A_REVOLUTION,
    check_array,
    check_axis,
    check_between,
    check_choice,
    check_count,
    check_increasing,
    check_positive,
    check_progress,
    check_real,
    is_scalar,
    shown,
)
from rotor_ida.core.systems import SystemRequest, SystemResult
from rotor_ida.errors import InputError, InvariantError
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact, Unbalance
from rotor_ida.parallel import Progress, interruptible
from rotor_ida.simulation.orbit import ENTRY
from rotor_ida.simulation.spin import Ramp, SpeedProfile, driven, steady, through
from rotor_ida.systems.archived import problem_variables
from rotor_ida.systems.assembly import Assembly, Canonical, assemble, canonical
from rotor_ida.systems.dataset import system_dataset
from rotor_ida.systems.following import (
    Followed,
    energy_of,
    follow_twice,
    growth_of,
    request_of,
    shifts_of,
    size_of_energy,
)
from rotor_ida.systems.modes import check_modes, in_modes
from rotor_ida.systems.starts import Start, start_of
from rotor_ida.systems.witness import follow_by_cvode

SystemMethod = Literal["taylor", "adams", "bdf"]
METHODS = ("taylor", "adams", "bdf")
TIGHTEST_RTOL, LOOSEST_RTOL = 1e-14, 1e-4
FEWEST_SAMPLES = 1001
# Radians of the fastest motion of a system, and of its spin, in a run: a step covers about five.
MOST_RADIANS = 1e9
MOST_GROWTH = 500.0
MOST_SAMPLES = 200_000
# Forces beyond their limits, and energy that is missing, in parts of their size: rounding, and what
# the tolerance allows. The energy of 300 random systems was missing by at most 4.2e-11 at rtol
# 1e-10, and 1.4e-6 at 1e-6.
ROUNDED, OF_TOLERANCE = 1e-9, 30.0


def simulate_system(
    system: RotorSystem,
    *,
    contacts: Sequence[Contact] = (),
    speed: float,
    unbalance: Sequence[Unbalance] = (),
    gravity: tuple[float, float] | None = None,
    static_force: npt.ArrayLike | None = None,
    start: Start = None,
    duration: float,
    samples: int | npt.ArrayLike | None = None,
    modes: int | None = None,
    more_modes: int | None = None,
    rtol: float = 1e-10,
    method: SystemMethod = "taylor",
    progress: Progress | None = None,
) -> xr.Dataset:
    """Simulate a rotor system and locate every event of every contact by root finding.

    Parameters
    ----------
    system : RotorSystem
        The rotor.
    contacts : sequence of Contact
        Its contacts, at most 16.
    speed : float
        Spin speed.
    unbalance : sequence of Unbalance
        Its unbalance; at time 0 an unbalance of phase 0 points along x.
    gravity : (float, float), optional
        Acceleration of gravity along x and y.
    static_force : array_like, shape (n,), optional
        A constant force.
    start : (q, velocity), "settled" or "rest", optional
        State at time 0, of the rotor or of rotor and stators; or the steady whirl without contact;
        or at rest in its supports and contacts under the constant forces. Default: at rest at 0.
    duration : float
        Time to simulate.
    samples : int or array_like, optional
        Increasing times of samples, or their number. Default: 32 per revolution, at least 1,001
        and at most 200,000.
    modes : int, optional
        Number of modes to which the system is reduced first; the static flexibility of the contacts
        is kept (see `RotorSystem.reduced`).
    more_modes : int, optional
        Larger number of modes of a second run, which shows how far the events move with more modes.
    rtol : float
        Relative tolerance, from 1e-14 to 1e-4.
    method : {"taylor", "adams", "bdf"}
        Taylor series by the compiled core, or CVODE in plain Python, an independent and much
        slower check.
    progress : callable, optional
        Called from time to time with the percentage completed, and 100.

    Returns
    -------
    Dataset
        ``x y vx vy`` on ``(t, node)``; ``event_time event_kind event_contact event_time_error`` on
        ``event`` and ``event_state`` (q, velocity); ``normal_force tangential_force slip_speed
        mode`` on ``(t, contact)``; on ``episode`` the table of contacts; ``final_state``.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If the integration fails.
    InvariantError
        If the result contradicts the mechanics.

    Notes
    -----
    ``M q'' + (C + Omega G) q' + K q = unbalance + static force + contacts``. Each contact has the
    displacement ``u = B q - c``; where ``d = |u| - delta > 0`` its force on the rotor is
    ``-(N + i T) u/|u|``, ``N = k d**n max(0, 1 + lambda d')``, ``T = mu N sign(v_s)``.

    Examples
    --------
    >>> system = RotorSystem(mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2),
    ...                      nodes={"disc": (0, 1)}, units="1")
    >>> run = simulate_system(
    ...     system, contacts=[Contact(node="disc", clearance=1.5, stiffness=4.0, exponent=1.0)],
    ...     unbalance=[Unbalance(node="disc", moment=1.0)], speed=0.9, duration=20.0, samples=3)
    >>> run.event_time.values.round(6)[:2], run.event_kind.values[:2]
    (array([ 4.350352, 11.973831]), array([ 1, -1], dtype=int8))
    """
    omega = check_real("speed", speed)
    end = check_positive("duration", duration)
    return _simulate(
        system, steady(omega, end), contacts=contacts, unbalance=unbalance, gravity=gravity,
        static_force=static_force, start=start, samples=samples, modes=modes,
        more_modes=more_modes, rtol=rtol, method=method, progress=progress, speed=omega,
        change={"speed": omega},
    )  # fmt: skip


def run_up_system(
    system: RotorSystem,
    *,
    contacts: Sequence[Contact] = (),
    speed: float | None = None,
    to: float | None = None,
    rate: float | None = None,
    ramp_time: float | None = None,
    speeds: Sequence[tuple[float, float]] | npt.ArrayLike | None = None,
    torque: tuple[float, float] | None = None,
    inertia: float | None = None,
    duration: float | None = None,
    unbalance: Sequence[Unbalance] = (),
    gravity: tuple[float, float] | None = None,
    static_force: npt.ArrayLike | None = None,
    start: Start = None,
    samples: int | npt.ArrayLike | None = None,
    modes: int | None = None,
    more_modes: int | None = None,
    rtol: float = 1e-10,
    method: SystemMethod = "taylor",
    progress: Progress | None = None,
) -> xr.Dataset:
    """Simulate a rotor system whose speed changes.

    Parameters
    ----------
    system : RotorSystem
        The rotor.
    contacts, unbalance, gravity, static_force, start : optional
        As in `simulate_system`.
    samples, modes, more_modes, rtol, method, progress : optional
        As in `simulate_system`.
    speed : float
        Speed at time 0.
    to, rate : float
        A ramp from `speed` to another speed at a constant rate; without `to`, for all of the
        `duration`.
    ramp_time : float
        Duration of a ramp, instead of its rate.
    speeds : sequence of (float, float)
        Pairs of time and speed, linear in between; instead of `speed`.
    torque : (float, float)
        ``(tau0, slope)``: the drive's torque is ``tau0 - slope Omega``.
    inertia : float
        Moment of inertia about the centres of mass, with a torque.
    duration : float, optional
        Time to simulate; required with a torque. After the change the last speed is kept.

    Returns
    -------
    Dataset
        As from `simulate_system`, with ``speed`` and ``angle`` on ``t``.

    Raises
    ------
    InputError, SimulationError, InvariantError
        As in `simulate_system`.

    Notes
    -----
    With a torque ``J Omega' = tau0 - slope Omega - sum R_j T_j - (reaction of the unbalance)``.

    Examples
    --------
    >>> system = RotorSystem(mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2),
    ...                      nodes={"disc": (0, 1)}, units="1")
    >>> run = run_up_system(
    ...     system, contacts=[Contact(node="disc", clearance=1.5, stiffness=4.0)],
    ...     unbalance=[Unbalance(node="disc", moment=1.0)], speed=0.2, to=1.5, rate=0.02, samples=3)
    >>> run.speed.values.round(3)
    array([0.2 , 0.85, 1.5 ])
    """
    if ramp_time is not None:
        rate = _rate_of(speed, to, rate, ramp_time)
    profile, first, change = profile_of(speed, to, rate, speeds, torque, inertia, duration)
    return _simulate(
        system, profile, contacts=contacts, unbalance=unbalance, gravity=gravity,
        static_force=static_force, start=start, samples=samples, modes=modes,
        more_modes=more_modes, rtol=rtol, method=method, progress=progress, speed=first,
        change=change,
    )  # fmt: skip


def _rate_of(speed: object, to: object, rate: object, ramp_time: object) -> float:
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
        raise InputError(f"rate must lead from speed {first!r} to {last!r}, got {slope!r}")
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
        raise InputError(f"the first time of speeds must be 0, got {float(table[0, 0])!r}")
    points = [(float(time), float(speed)) for time, speed in table]
    with np.errstate(over="ignore"):
        slopes = np.diff(table[:, 1]) / np.diff(table[:, 0])
    check_array("the rate of speeds", slopes)
    profile = through(points, _end_after(points[-1][0], end))
    return profile, points[0][1], {"speeds": table.ravel()}


def _end_after(least: float, end: float | None) -> float:
    """Return the end of a run, no earlier than that of the change of speed."""
    if end is not None and end < least * (1.0 - ROUNDED):
        raise InputError(
            f"duration must be at least {least!r}, the time of the speed change, got {end!r}"
        )
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
            f"torque {(tau0, slope)!r}, inertia {moment!r} and duration {end!r}, which lead to a "
            f"speed of up to {reached:.3g}"
        )
    profile = driven((tau0, slope), moment, end)
    return profile, speed, {"start_speed": speed, "torque": pair, "inertia": moment}


@dataclass(frozen=True, slots=True)
class _Prepared:
    """A system with its surroundings, in coordinates with a unit mass matrix, and its start."""

    assembly: Assembly
    found: Canonical
    begun: Values
    request: SystemRequest


def _prepared(
    system: RotorSystem, profile: SpeedProfile, times: Values, speed: float, fastest: float,
    rtol: float, start: Start, **around: Any,
) -> _Prepared:  # fmt: skip
    """Return what is to be followed, if that does not take too long."""
    assembly = assemble(system, **around)
    found, end = canonical(assembly), profile.ends[-1]
    begun = start_of(assembly, start, speed)
    request = request_of(
        assembly, found, profile, np.array([found.to_y(each) for each in begun]), times, end,
        rtol=rtol, speed=speed, fastest_speed=fastest, inertia=_inertia(found, profile),
    )  # fmt: skip
    longest = MOST_RADIANS / (request.fastest + fastest)
    if not end <= longest:
        raise InputError(
            f"duration must be at most {longest:.4g}, as the system moves at up to "
            f"{request.fastest:.4g} rad per unit of time, got {end!r}; fewer modes lower that"
        )
    return _Prepared(assembly, found, begun, request)


def _simulate(
    system: RotorSystem,
    profile: SpeedProfile,
    *,
    contacts: Sequence[Contact],
    unbalance: Sequence[Unbalance],
    gravity: tuple[float, float] | None,
    static_force: npt.ArrayLike | None,
    start: Start,
    samples: int | npt.ArrayLike | None,
    modes: int | None,
    more_modes: int | None,
    rtol: float,
    method: SystemMethod,
    progress: Progress | None,
    speed: float,
    change: dict[str, object],
) -> xr.Dataset:
    """Return the run of a system along a course of its speed."""
    around: dict[str, Any] = {"contacts": contacts, "unbalance": unbalance, "gravity": gravity,
                              "static_force": static_force, "start": start}  # fmt: skip
    check_modes(modes, more_modes)
    numbers = {"modes": modes, "more_modes": more_modes}
    change = change | {name: number for name, number in numbers.items() if number is not None}
    cases = [in_modes(system, number, around)
             for number in ([modes] if more_modes is None else [modes, more_modes])]  # fmt: skip
    return run_of_cases(
        cases, profile, samples=samples, rtol=rtol, method=method, progress=progress, speed=speed,
        change=change,
    )  # fmt: skip


def run_of_cases(
    cases: Sequence[Mapping[str, Any]],
    profile: SpeedProfile,
    *,
    samples: int | npt.ArrayLike | None,
    rtol: float,
    method: SystemMethod,
    progress: Progress | None,
    speed: float,
    change: dict[str, object],
) -> xr.Dataset:
    """Return the run of a system in its surroundings, and the shifts of its events in a second.

    Parameters
    ----------
    cases : sequence of mapping
        The system and its surroundings as keywords; those with more modes come second.
    profile : SpeedProfile
        The course of the speed.
    samples, rtol, method, progress : optional
        As for `simulate_system`.
    speed : float
        Speed at time 0.
    change : dict
        Attributes of the run: its speed or what changes it.
    """
    check_choice("method", method, METHODS)
    check_progress(progress)
    tolerance = check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL)
    end, fastest = profile.ends[-1], _fastest(profile, speed)
    times = _times(samples, end, fastest)
    told = {"method": method, "rtol": tolerance, "duration": end, **change}
    first, *second = [
        _prepared(
            **each,
            profile=profile,
            times=times,
            speed=speed,
            fastest=fastest,
            rtol=tolerance,
        )
        for each in cases
    ]
    watch: Watch = []

    def follow(stop: Stop) -> tuple[Followed, Values | None]:
        if method == "taylor":
            followed = follow_twice(first.request, stop, watch)
        else:
            followed = follow_by_cvode(first.request, profile, tolerance, method, stop, watch)
        moved = [shifts_of(followed.result, each.request, stop, watch) for each in second]
        return followed, moved[0] if moved else None

    runs = 2 + len(second)

    def tell(progress: Progress) -> None:
        progress(int(100.0 / runs * sum(done() for done in watch) / end), 100)

    followed, moved = interruptible(
        follow, told=None if progress is None else partial(tell, progress)
    )
    if progress is not None:
        progress(100, 100)
    allowed = ROUNDED + OF_TOLERANCE * tolerance
    _check(first.assembly, first.found, first.request.start, followed, allowed)
    more = problem_variables(first.assembly, cases[0]["unbalance"], first.begun)
    if growth := growth_of(first.found, fastest):
        told["growth_rate_without_contact"] = growth
    if moved is not None:
        more["event_time_shift"] = ("event", moved)
    return system_dataset(
        first.assembly, first.found, followed, times, more, told,
        change_speed="speed" not in change,
    )  # fmt: skip


def _fastest(profile: SpeedProfile, speed: float) -> float:
    """Return the largest size of a prescribed speed; of a driven one that at time 0."""
    speeds = [speed]
    for end, spin in zip(profile.ends, profile.spins, strict=True):
        if isinstance(spin, Ramp):
            speeds += [spin.speed, spin.speed + spin.rate * (end - spin.begin)]
    return max(map(abs, speeds))


def _inertia(found: Canonical, profile: SpeedProfile) -> float:
    """Return the moment of inertia about the axis of rotation, 0 if the speed is prescribed.

    It is that about the centres of mass, and what the unbalance adds.
    """
    if not profile.is_driven:
        return 0.0
    (spin,) = profile.spins
    own = 1.0 / spin.piece()[3]
    return own + 0.5 * float((found.unbalance**2).sum())


def _times(samples: object, end: float, fastest: float) -> Values:
    """Return the times of samples."""
    if samples is None:
        count = SAMPLES_A_REVOLUTION * fastest * end / (2.0 * math.pi)
        return np.linspace(0.0, end, int(min(max(count, FEWEST_SAMPLES), MOST_SAMPLES)))
    if is_scalar("samples", samples):
        return np.linspace(0.0, end, check_count("samples", samples, minimum=2))
    times = check_increasing("samples", check_axis("samples", samples))
    if times[-1] > end:
        raise InputError(
            f"samples must lie from 0 to the duration {end!r}, got {float(times[-1])!r}"
        )
    return times


def _check(
    assembly: Assembly, found: Canonical, start: Values, followed: Followed, allowed: float
) -> None:
    """Raise an error where a run contradicts the mechanics."""
    result = followed.result
    for number, contact in enumerate(assembly.contacts):
        kinds = result.event_kinds[result.event_contacts == number]
        edges = kinds[np.abs(kinds) == ENTRY]
        if (edges[1:] == edges[:-1]).any():
            raise InvariantError(f"entry and exit of contact {number} do not alternate")
        normal, tangential = result.forces[:, number, 0], result.forces[:, number, 1]
        rounded = allowed * float(normal.max(initial=0.0))
        if normal.min(initial=0.0) < -rounded:
            raise InvariantError(f"the normal force of contact {number} is tensile")
        if (np.abs(tangential) > contact.friction * normal + rounded).any():
            raise InvariantError(f"contact {number} holds more than its friction can")
    if not math.isnan(result.ledger["unbalance"]):  # CVODE keeps none
        _check_energy(found, start, result, allowed)


def _check_energy(found: Canonical, start: Values, result: SystemResult, allowed: float) -> None:
    """Compare the energy at both ends with what was gained and lost in between."""
    spent = result.ledger
    kept = energy_of(found, result.state) - energy_of(found, start)
    lost = sum(spent[name] for name in ("damping", "stiffness_rate", "normal", "tangential"))
    size = size_of_energy(found, np.concatenate([start[np.newaxis], result.samples]))
    turnover = size + sum(map(abs, spent.values()))
    if abs(kept - spent["unbalance"] + lost) > allowed * turnover:
        raise InvariantError(
            f"the energy does not balance: {kept:.9g} kept, {spent['unbalance'] - lost:.9g} gained"
        )
