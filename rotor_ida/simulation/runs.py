"""One run of any rotor: followed, measured by a second run, checked, and labelled."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import (
    SAMPLES_A_REVOLUTION,
    State,
    check_axis,
    check_between,
    check_choice,
    check_count,
    check_increasing,
    check_progress,
    is_scalar,
)
from rotor_ida.core.library import why_missing
from rotor_ida.core.system_requests import Places, SystemRequest, SystemResult
from rotor_ida.errors import InputError, warn
from rotor_ida.model.assembly import Assembly, Canonical, assemble, canonical
from rotor_ida.model.growth import growth_begins, growth_of, nothing_holds
from rotor_ida.model.reduction import check_modes, in_modes
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.parallel import Progress, interruptible, run_with_progress
from rotor_ida.results.growth_words import BEGINS, NOT_HELD, RATE, WHIRL_SPEED, stability_words
from rotor_ida.simulation.course import MOST_RADIANS, Course
from rotor_ida.simulation.dataset import fastest_whirl, run_dataset, system_dataset
from rotor_ida.simulation.event_errors import APART, EventErrors, estimate_event_errors, shifts_of
from rotor_ida.simulation.invariants import check_system_orbit
from rotor_ida.simulation.options import Backend, Options, backend_of, passes_soon
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.run import run, witness
from rotor_ida.simulation.starts import Start, start_of_system
from rotor_ida.simulation.system_run import (
    Followed,
    bare,
    by_method,
    inertia_of,
    request_of,
    run_to_end,
    with_errors,
)

# An event this many tolerances after the end of a run counts as part of the run.
END_SLACK = 100.0
MOST_SLACK = 1e-8

SystemMethod = Literal["taylor", "adams", "bdf"]
METHODS = ("taylor", "adams", "bdf")
TIGHTEST_RTOL, LOOSEST_RTOL = 1e-14, 1e-4
MOST_SAMPLES = 200_000
# Radians by which a whirl in a contact turns from a sample to the next, in a drop: its sense shows.
MOST_TURNED = 0.8
# A drop is sampled this many times more finely than its speed asks for, as the whirl to come is not
# known yet; then as few of the samples are kept as resolve it.
FINER = 12
# In a period of the contact, which is the shortest period of dry whip.
SAMPLES_A_CONTACT = 8
# Smallest number of samples, for a smooth plot of a short run.
FEWEST = 1001
# Limit on memory: about 160 MB in a run, and twice as much during the run.
MOST_CHOSEN = 2_000_000


# ---- Of one disc ----


def run_of_disc(
    rotor: Rotor, start: State, course: Course, samples: object, options: Options,
    progress: Progress | None,
) -> xr.Dataset:  # fmt: skip
    """Return the run of one disc along a course of its speed."""
    end, fastest = course.end, course.largest_speed
    slack = min(END_SLACK * options.rtol, MOST_SLACK) * end
    profile = None if course.profile.is_held else course.profile
    times = sample_times(samples, end, rotor, fastest)
    # with a torque a first run finds the largest speed
    is_unknown = samples is None and profile is not None and profile.is_driven

    def follow(times: Values, stop: Stop, watch: Watch) -> Orbit:
        return run(
            rotor, start, end, times, options, slack=slack, stop=stop, profile=profile, watch=watch
        )

    def run_twice(stop: Stop, watch: Watch) -> tuple[Orbit, EventErrors]:
        at = times
        if is_unknown:
            seen = follow(sample_times(FEWEST, end, rotor, fastest), stop, watch)
            at = sample_times(None, end, rotor, max(fastest, float(np.max(seen.speeds))))
            watch.clear()
        orbit = follow(at, stop, watch)
        return orbit, estimate_event_errors(orbit, start, slack=slack, stop=stop, watch=watch)

    is_compiled = options.backend == "compiled" and profile is None
    orbit, errors = run_with_progress(
        run_twice, 2.0 * end, progress,
        at_once=is_compiled and passes_soon(rotor, start, end, options.method, times.size),
    )  # fmt: skip
    return run_dataset(orbit, start, errors, course.told if profile else {})


# ---- Of a rotor system ----


class _Prepared(NamedTuple):
    """A system in coordinates with a unit mass matrix, and its start."""

    assembly: Assembly
    found: Canonical
    begun: Values
    request: SystemRequest


def run_of_system(
    system: RotorSystem, course: Course, *, start: Any, modes: int | None, more_modes: int | None,
    **how: Any,
) -> xr.Dataset:  # fmt: skip
    """Return the run of a system along a course of its speed, with a warning if it is unstable."""
    check_modes(modes, more_modes)
    films = system
    if course.profile.is_held:
        system = system.at(course.speed)
    cases = [in_modes(system, number, start)
             for number in ([modes] if more_modes is None else [modes, more_modes])]  # fmt: skip
    run = run_of_cases(cases, course, modes={"modes": modes, "more_modes": more_modes}, **how)
    if RATE in run.attrs and not (course.profile.is_held and films is system):
        begins = growth_begins(canonical(assemble(films)), course.largest_speed)
        if begins is not None:
            run.attrs[BEGINS] = begins
    for words in stability_words(run.attrs, system.units):
        warn(words)
    return run


def run_of_cases(
    cases: Sequence[tuple[RotorSystem, Start]],
    course: Course,
    *,
    samples: object,
    rtol: float,
    method: SystemMethod,
    progress: Progress | bool | None,
    backend: Backend = "auto",
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
    samples, rtol, method, progress, backend : optional
        As for `rotor_ida.simulate`.
    modes : mapping
        Numbers of modes, as attributes of the run.
    whirls : bool
        Whether samples by default must resolve whirls in the contacts too, however fast.
    """
    backend = _checked_backend(method, backend, [system for system, _ in cases])
    progress = check_progress(progress)
    tolerance = check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL)
    fastest = course.largest_speed
    count = SAMPLES_A_REVOLUTION * fastest * course.end / (2.0 * math.pi)
    chosen = int(min(max(count, FEWEST), MOST_SAMPLES))
    resolves = whirls and samples is None
    finer = min(FINER, MOST_SAMPLES // chosen) if resolves and backend == "compiled" else 1
    times = times_of(samples, course.end, (chosen - 1) * finer + 1)
    first, *second = [_prepared(*each, course, times, tolerance) for each in cases]

    def by_witness(request: SystemRequest, rtol: float, stop: Stop, watch: Watch) -> SystemResult:
        found: SystemResult = witness("system")(request, course.profile, rtol, method, stop, watch)
        return found

    def followed_by(request: SystemRequest, stop: Stop, watch: Watch) -> SystemResult:
        if backend == "python":
            return by_witness(request, tolerance, stop, watch)
        return run_to_end(by_method(request, method, tolerance), stop, watch)

    def follow(stop: Stop, watch: Watch) -> tuple[Followed, list[Values]]:
        result = followed_by(first.request, stop, watch)
        followed = with_errors(
            result, first.request, method == "taylor", stop, watch,
            (lambda request: by_witness(request, APART * tolerance, stop, watch))
            if why_missing() else None,
        )  # fmt: skip
        moved = (run_to_end(bare(each.request), stop, watch) for each in second)
        return followed, [shifts_of(result, each, len(first.request.laws)) for each in moved]

    followed, shifts = run_with_progress(follow, (2 + len(second)) * course.end, progress)
    if resolves:
        times, result = _resolved(
            first, followed.result, times, finer,
            lambda request: interruptible(lambda stop: followed_by(request, stop, [])),
        )  # fmt: skip
        followed = replace(followed, result=result)
    asked = by_method(first.request, method, tolerance)
    check_system_orbit(first.assembly, first.found, asked, followed.result, tolerance)
    told = {"method": method, "backend": backend, "rtol": tolerance, "duration": course.end,
            **course.told, **{name: each for name, each in modes.items() if each is not None},
            **_stability_of(first.found, course)}  # fmt: skip
    shift = shifts[0] if shifts else None
    return system_dataset(first.assembly, first.found, followed, first.begun, times, told, shift)


def _checked_backend(
    method: SystemMethod, backend: Backend, systems: Sequence[RotorSystem]
) -> Backend:
    """Return the backend that follows systems by a method, or raise `InputError`."""
    check_choice("method", method, METHODS)
    backend = backend_of(method, backend)
    gaps = [each.clearance for system in systems for each in system.contacts]
    if 0.0 in gaps and method != "taylor" and backend == "compiled":
        raise InputError(
            "method must be 'taylor' with a contact without clearance, or backend 'python', got "
            f"{method!r}"
        )
    return backend


def _stability_of(found: Canonical, course: Course) -> dict[str, float]:
    """Return how fast a motion without contact grows, and whether nothing holds the system."""
    growth = growth_of(found, course.largest_speed)
    told: dict[str, float] = {RATE: growth.rate, WHIRL_SPEED: growth.whirl_speed} if growth else {}
    return told | ({NOT_HELD: 1} if nothing_holds(found.at(course.speed)) else {})


def _prepared(
    system: RotorSystem, start: Start | xr.Dataset, course: Course, times: Values, rtol: float
) -> _Prepared:  # fmt: skip
    """Return what is to be followed, if that does not take too long."""
    assembly = assemble(system, speeds=np.array([course.speed]))
    found, fastest = canonical(assembly), course.largest_speed
    begun = start_of_system(assembly, start, course.speed)
    request = request_of(
        assembly, found, course.profile, np.array([found.to_y(each) for each in begun]), times,
        course.end, rtol=rtol, speed=course.speed, fastest_speed=fastest,
        inertia=inertia_of(found, course.profile),
    )  # fmt: skip
    centres = np.array([each.centre for each in assembly.contacts]).reshape(-1, 2)
    request = replace(request, places=Places(found.rows, centres))
    longest = MOST_RADIANS["system"] / (request.fastest + fastest)
    if not course.end <= longest:
        raise InputError(
            "{name} must be at most {most:.4g}, as the system moves at up to {fastest:.4g}, got "
            "{value}; fewer modes lower that",
            name="duration", most=longest, fastest=request.fastest, value=course.end,
        )  # fmt: skip
    return _Prepared(assembly, found, begun, request)


def _resolved(
    prepared: _Prepared, result: SystemResult, times: Values, finer: int,
    follow: Callable[[SystemRequest], SystemResult],
) -> tuple[Values, SystemResult]:  # fmt: skip
    """Return the times that resolve the whirls in the contacts, and the run there.

    They are as few of those of the run, which are `finer` than the speed asks for, as do, or more
    where all are too few.
    """
    rate = fastest_whirl(prepared.assembly, prepared.found.rows, result.samples)
    steps, needed = times.size - 1, min(math.ceil(rate * times[-1] / MOST_TURNED), MOST_SAMPLES - 1)
    if needed > steps:
        times = np.linspace(0.0, times[-1], needed + 1)
        return times, follow(replace(prepared.request, times=times))
    every = max(
        each for each in range(1, finer + 1) if finer % each == 0 and steps // each >= needed
    )
    return times[::every], result.at_every(every)


# ---- The times at which a run is reported ----


def sample_times(samples: object, duration: float, rotor: Rotor, fastest: float) -> Values:
    """Return the times to report: as given, equally spaced, or chosen per revolution.

    Parameters
    ----------
    samples : int, array_like or None
        The times, their number, or None.
    duration : float
        The end of the run [dimensionless].
    rotor : Rotor
        The rotor.
    fastest : float
        The largest speed of the run [dimensionless].

    Examples
    --------
    >>> rotor = Rotor(omega=2.0, zeta=0.1, delta0=1.0)
    >>> sample_times(None, 1000.0, rotor, 2.0).size  # 318.3 revolutions
    10187
    >>> sample_times(None, 10.0, rotor, 2.0).size, sample_times(3, 10.0, rotor, 2.0).size
    (1001, 3)
    """
    return times_of(samples, duration, _chosen(duration, rotor, fastest))


def times_of(samples: object, duration: float, chosen: int) -> Values:
    """Return the times to report: as given, or equally spaced, by default as many as `chosen`."""
    if samples is None:
        return np.linspace(0.0, duration, chosen)
    if is_scalar("samples", samples):
        return np.linspace(0.0, duration, check_count("samples", samples, minimum=2))
    times = check_increasing("samples", check_axis("samples", samples))
    if times[-1] > duration:
        raise InputError(
            "{name} must lie from 0 to the {duration=}, got {value}",
            name="samples", duration=duration, value=float(times[-1]),
        )  # fmt: skip
    return times


def _chosen(duration: float, rotor: Rotor, fastest: float) -> int:
    """Return how many samples resolve revolutions, shaft and contact, as far as memory allows."""
    shaft = math.sqrt(rotor.shaft_stiffness)
    on_the_ring = math.sqrt(1.0 + rotor.shaft_stiffness)
    rate = max(
        SAMPLES_A_REVOLUTION * max(fastest, shaft), SAMPLES_A_CONTACT * on_the_ring
    ) / (2.0 * math.pi)  # fmt: skip
    return math.ceil(min(max(rate * duration + 1.0, FEWEST), MOST_CHOSEN))
