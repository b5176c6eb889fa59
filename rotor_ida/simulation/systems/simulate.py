"""Simulate a rotor system at a constant or a changing speed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import (
    SAMPLES_A_REVOLUTION,
    check_axis,
    check_between,
    check_choice,
    check_count,
    check_increasing,
    check_positive,
    check_progress,
    check_real,
    is_scalar,
)
from rotor_ida.core.systems import SystemRequest, SystemResult
from rotor_ida.errors import InputError, InstallationError, warn
from rotor_ida.model.assembly import Assembly, Canonical, assemble, canonical
from rotor_ida.model.few_modes import check_modes, in_modes
from rotor_ida.model.growth import growth_of, nothing_holds
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, interruptible, percentage, shows_progress
from rotor_ida.results.archived_system import problem_variables
from rotor_ida.results.growth_words import NOT_HELD, RATE, WHIRL_SPEED, stability_words
from rotor_ida.simulation.course import MOST_RADIANS, SYSTEM_LIMITS, Course, course_of, held
from rotor_ida.simulation.event_errors import shifts_of
from rotor_ida.simulation.spin import SpeedProfile
from rotor_ida.simulation.systems.dataset import fastest_whirl, system_dataset
from rotor_ida.simulation.systems.ends import state_at_end
from rotor_ida.simulation.systems.following import (
    Followed,
    bare,
    compared_with_series,
    follow_system_again,
    follow_twice,
    inertia_of,
    request_of,
)
from rotor_ida.simulation.systems.invariants import check_run
from rotor_ida.simulation.systems.starts import Start, start_of

SystemMethod = Literal["taylor", "adams", "bdf"]
METHODS = ("taylor", "adams", "bdf")
TIGHTEST_RTOL, LOOSEST_RTOL = 1e-14, 1e-4
FEWEST_SAMPLES = 1001
MOST_SAMPLES = 200_000
# Radians by which a whirl in a contact turns from a sample to the next, in a drop: its sense shows.
MOST_TURNED = 0.8


@shows_progress
def simulate_system(
    system: RotorSystem,
    *,
    speed: float,
    start: Start | xr.Dataset = None,
    duration: float,
    samples: int | npt.ArrayLike | None = None,
    modes: int | None = None,
    more_modes: int | None = None,
    rtol: float = 1e-10,
    method: SystemMethod = "taylor",
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Simulate a rotor system and locate every event of every contact by root finding.

    Parameters
    ----------
    system : RotorSystem
        The rotor.
    speed : float
        Spin speed.
    start : (q, velocity), "settled", "rest" or Dataset, optional
        State at time 0, of the rotor or of rotor and stators; or the steady whirl without contact;
        or at rest in its supports and contacts under the constant forces; or a result that ends in
        a state and is continued, with the unbalance at angle 0 again: a run, a limit cycle or one
        point of a sweep. Default: at rest at 0, from which a weight drops the rotor.
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
    progress : callable or bool, optional
        Called from time to time with the percentage completed, and 100; True shows a bar on
        standard error.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of the system: ``simulate(system, contacts=[...], ...)`` is
        ``simulate(replace(system, contacts=[...]), ...)``.

    Returns
    -------
    Dataset
        ``x y vx vy`` on ``(t, node)``; ``event_time event_kind event_contact event_time_error`` on
        ``event`` and ``event_state`` (q, velocity); ``normal_force tangential_force slip_speed
        mode`` on ``(t, contact)``; on ``episode`` the table of contacts; ``final_state``. With
        races ``event_race_speed`` on ``(event, contact)``, and on ``contact`` their largest and
        smallest speeds, also between events, and when: ``race_speed_max race_speed_max_time
        race_speed_min race_speed_min_time``. CVODE knows these only at samples and events.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If the integration fails.
    InvariantError
        If the result contradicts the mechanics.

    Warns
    -----
    UserWarning
        If the motion without contact grows, with the rate and the whirl speed, also in the
        attributes ``growth_rate_without_contact`` and ``whirl_speed_of_growth``; or if neither
        supports nor contacts hold the system against its constant forces (``nothing_holds``).

    Notes
    -----
    ``M q'' + (C + Omega G) q' + K q = unbalance + static force + contacts``. Each contact has the
    displacement ``u = B q - c``; where ``d = |u| - delta > 0`` its force on the rotor is
    ``-(N + i T) u/|u|``, ``N = k d**n max(0, 1 + lambda d')``, ``T = mu N sign(v_s)``.

    Examples
    --------
    >>> import numpy as np
    >>> from rotor_ida import Contact, RotorSystem, Unbalance
    >>> system = RotorSystem(
    ...     mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
    ...     contacts=[Contact(node="disc", clearance=1.5, stiffness=4.0, exponent=1.0)],
    ...     unbalance=[Unbalance(node="disc", moment=1.0)], units="1")
    >>> run = simulate_system(system, speed=0.9, duration=20.0, samples=3)
    >>> run.event_time.values.round(6)[:2], run.event_kind.values[:2]
    (array([ 4.350352, 11.973831]), array([ 1, -1], dtype=int8))
    """
    omega = check_real("speed", speed)
    end = check_positive("duration", duration)
    return _simulate(
        changed_system(simulate_system, system, changed), held(omega, end), start=start,
        samples=samples, modes=modes, more_modes=more_modes, rtol=rtol, method=method,
        progress=progress,
    )  # fmt: skip


@shows_progress
def run_up_system(
    system: RotorSystem,
    *,
    speed: float | None = None,
    to: float | None = None,
    rate: float | None = None,
    ramp_time: float | None = None,
    speeds: Sequence[tuple[float, float]] | npt.ArrayLike | None = None,
    torque: tuple[float, float] | None = None,
    inertia: float | None = None,
    duration: float | None = None,
    start: Start | xr.Dataset = None,
    samples: int | npt.ArrayLike | None = None,
    modes: int | None = None,
    more_modes: int | None = None,
    rtol: float = 1e-10,
    method: SystemMethod = "taylor",
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Simulate a rotor system whose speed changes.

    Parameters
    ----------
    system : RotorSystem
        The rotor.
    start, samples, modes, more_modes, rtol, method, progress : optional
        As in `simulate`.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of the system, as in `simulate`.
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
        As from `simulate`, with ``speed`` and ``angle`` on ``t``. With a torque
        ``standstill_time`` and ``standstill_time_error``: since when the speed has stayed below
        one per cent of the first, NaN if it does not, as of a rotor that rocks.

    Raises
    ------
    InputError, SimulationError, InvariantError
        As in `simulate`.

    Warns
    -----
    UserWarning
        As in `simulate`, at the largest speed.

    Notes
    -----
    With a torque ``J Omega' = tau0 - slope Omega - sum R_j T_j - (reaction of the unbalance)
    + sum m e x g``: the weight of each unbalance has a moment about the axis. A `static_force` has
    none, but for the weight that `RotorSystem.gravity_in_static_force` describes.

    Examples
    --------
    >>> import numpy as np
    >>> from rotor_ida import Contact, RotorSystem, Unbalance
    >>> system = RotorSystem(
    ...     mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
    ...     contacts=[Contact(node="disc", clearance=1.5, stiffness=4.0)],
    ...     unbalance=[Unbalance(node="disc", moment=1.0)], units="1")
    >>> run = run_up_system(system, speed=0.2, to=1.5, rate=0.02, samples=3)
    >>> run.speed.values.round(3)
    array([0.2 , 0.85, 1.5 ])
    """
    given = {"to": to, "rate": rate, "ramp_time": ramp_time, "speeds": speeds, "torque": torque,
             "inertia": inertia}  # fmt: skip
    course = course_of(speed, given, duration, SYSTEM_LIMITS)
    return _simulate(
        changed_system(run_up_system, system, changed), course, start=start, samples=samples,
        modes=modes, more_modes=more_modes, rtol=rtol, method=method, progress=progress,
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Prepared:
    """A system in coordinates with a unit mass matrix, and its start."""

    assembly: Assembly
    found: Canonical
    begun: Values
    request: SystemRequest


def _prepared(
    system: RotorSystem, start: Start | xr.Dataset, course: Course, times: Values, rtol: float
) -> _Prepared:  # fmt: skip
    """Return what is to be followed, if that does not take too long."""
    assembly = assemble(system)
    found, fastest = canonical(assembly), course.largest_speed
    begun = start_of(assembly, state_at_end(assembly, start), course.speed)
    request = request_of(
        assembly, found, course.profile, np.array([found.to_y(each) for each in begun]), times,
        course.end, rtol=rtol, speed=course.speed, fastest_speed=fastest,
        inertia=inertia_of(found, course.profile),
    )  # fmt: skip
    longest = MOST_RADIANS["system"] / (request.fastest + fastest)
    if not course.end <= longest:
        raise InputError(
            "{name} must be at most {most:.4g}, as the system moves at up to {fastest:.4g}, got "
            "{value}; fewer modes lower that",
            name="duration", most=longest, fastest=request.fastest, value=course.end,
        )  # fmt: skip
    return _Prepared(assembly, found, begun, request)


def _simulate(
    system: RotorSystem,
    course: Course,
    *,
    start: Start | xr.Dataset,
    samples: int | npt.ArrayLike | None,
    modes: int | None,
    more_modes: int | None,
    rtol: float,
    method: SystemMethod,
    progress: Progress | bool | None,
) -> xr.Dataset:
    """Return the run of a system along a course of its speed."""
    check_modes(modes, more_modes)
    cases = [in_modes(system, number, start)
             for number in ([modes] if more_modes is None else [modes, more_modes])]  # fmt: skip
    run = run_of_cases(
        cases, course, samples=samples, rtol=rtol, method=method, progress=progress,
        modes={"modes": modes, "more_modes": more_modes},
    )  # fmt: skip
    for words in stability_words(run.attrs, system.units):
        warn(words)
    return run


def run_of_cases(
    cases: Sequence[tuple[RotorSystem, Start]],
    course: Course,
    *,
    samples: int | npt.ArrayLike | None,
    rtol: float,
    method: SystemMethod,
    progress: Progress | bool | None,
    modes: Mapping[str, int | None],
    whirls: bool = False,
) -> xr.Dataset:
    """Return the run of a system, and the shifts of its events in a second.

    Parameters
    ----------
    cases : sequence of (RotorSystem, start)
        The system and its start; those with more modes come second.
    course : Course
        The course of the speed.
    samples, rtol, method, progress : optional
        As for `simulate`.
    modes : mapping
        Numbers of modes, as attributes of the run.
    whirls : bool
        Whether samples by default must resolve whirls in the contacts too, however fast.
    """
    check_choice("method", method, METHODS)
    progress = check_progress(progress)
    tolerance = check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL)
    profile, fastest = course.profile, course.largest_speed
    times = _times(samples, course.end, fastest)
    numbers = {name: number for name, number in modes.items() if number is not None}
    told: dict[str, object] = {
        "method": method, "rtol": tolerance, "duration": course.end, **course.told, **numbers
    }  # fmt: skip
    first, *second = [_prepared(*each, course, times, tolerance) for each in cases]
    followed, moved = _followed(first, second, profile, tolerance, method, progress)
    if whirls and samples is None and (finer := _finer(first, followed.result, times)) is not None:
        times = finer
        followed = _sampled_at(times, first.request, followed, profile, tolerance, method)
    check_run(first.assembly, first.found, first.request, followed.result, tolerance)
    more = problem_variables(first.assembly, first.begun)
    if growth := growth_of(first.found, fastest):
        told |= {RATE: growth.rate, WHIRL_SPEED: growth.whirl_speed}
    if nothing_holds(first.found):
        told[NOT_HELD] = 1
    if moved is not None:
        more["event_time_shift"] = ("event", moved)
    return system_dataset(
        first.assembly, first.found, followed, times, more, told,
        change_speed="speed" not in course.told,
    )  # fmt: skip


def _run_by_cvode(
    request: SystemRequest, profile: SpeedProfile, rtol: float, method: str, stop: Stop,
    watch: Watch,
) -> SystemResult:  # fmt: skip
    """Return a run by CVODE, or raise `InstallationError` without scikit-sundae."""
    try:
        from rotor_ida.simulation.witness.system import run_system  # noqa: PLC0415
    except ImportError as error:
        raise InstallationError(
            f"method {method!r} of a rotor system needs scikit-sundae: "
            f"pip install scikit-sundae ({error})"
        ) from error
    return run_system(request, profile, rtol, method, stop, watch)


def _followed(
    first: _Prepared, second: Sequence[_Prepared], profile: SpeedProfile, rtol: float,
    method: SystemMethod, progress: Progress | None,
) -> tuple[Followed, Values | None]:  # fmt: skip
    """Return a run, and how far its events move in the run of a second case, if there is one."""
    watch: Watch = []

    def follow(stop: Stop) -> tuple[Followed, Values | None]:
        if method == "taylor":
            followed = follow_twice(first.request, stop, watch)
        else:
            result = _run_by_cvode(first.request, profile, rtol, method, stop, watch)
            followed = compared_with_series(result, first.request, stop, watch)
        if not second:
            return followed, None
        other = follow_system_again(bare(second[0].request), stop, watch)
        return followed, shifts_of(followed.result, other, len(first.request.laws))

    whole = (2 + len(second)) * first.request.duration

    found = interruptible(follow, told=percentage(progress, watch, whole))
    if progress is not None:
        progress(100, 100)
    return found


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
            "{name} must lie from 0 to the {duration=}, got {value}",
            name="samples", duration=end, value=float(times[-1]),
        )  # fmt: skip
    return times


def _finer(prepared: _Prepared, result: SystemResult, times: Values) -> Values | None:
    """Return times that resolve the whirls in the contacts; None where the samples do."""
    rate = fastest_whirl(
        prepared.assembly, *map(prepared.found.to_q, np.moveaxis(result.samples, 1, 0))
    )
    count = min(math.ceil(rate * times[-1] / MOST_TURNED) + 1, MOST_SAMPLES)
    return np.linspace(0.0, times[-1], count) if count > times.size else None


def _sampled_at(
    times: Values, request: SystemRequest, followed: Followed, profile: SpeedProfile, rtol: float,
    method: SystemMethod,
) -> Followed:  # fmt: skip
    """Return the same run with its samples at other times."""
    request = replace(request, times=times)

    def follow(stop: Stop) -> SystemResult:
        if method == "taylor":
            return follow_system_again(request, stop)
        return _run_by_cvode(request, profile, rtol, method, stop, [])

    return replace(followed, result=interruptible(follow))
