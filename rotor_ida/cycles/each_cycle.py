"""Limit cycles at each point of a `Varied`: of one disc, and of rotor systems."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Column, Stop
from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.dataset import AXES, OF_ERRORS, OF_WHIRL, cycle_dataset, dims_of, in_words
from rotor_ida.cycles.guess import (
    CLOSING_RTOL,
    Guess,
    checked,
    guess_in,
    guess_of_system,
    has_period,
)
from rotor_ida.cycles.search import (
    check_no_hopf,
    check_revolutions,
    check_turns_and_settles,
    found_cycle,
    numbers_in,
)
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.assembly import assemble
from rotor_ida.model.few_modes import in_modes
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.model.varied import Varied
from rotor_ida.parallel import Progress, Workers
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import RESULT_KIND, labelled_dataset
from rotor_ida.simulation.flow import RTOL, DiscFlow, Flow
from rotor_ida.simulation.options import check_can_be_followed
from rotor_ida.simulation.starts import RUNS, GivenStart, Start, given_start, start_of, state_at_end
from rotor_ida.simulation.systems.flow import SystemFlow
from rotor_ida.steady.follow import FAILED
from rotor_ida.steady.grid import answers_at_each
from rotor_ida.steady.system_sweep import (
    Turning,
    Turnings,
    clearances_of,
    started,
    with_meanings,
)

OF_PLACES = ("node", "contact_node", "axial_position")


@dataclass(frozen=True, slots=True)
class Jobs:
    """How the points are worked on, and where they are kept."""

    workers: Workers
    study: Folder | None
    progress: Progress | None


# ---- Of one disc ----


def cycles_of_disc(varied: Varied, start: object, period: object, jobs: Jobs) -> xr.Dataset:
    """Return the cycles of one disc to which a start leads, or which lie near a guess."""
    lowest = {name: float(varied.values(name).min()) for name in ("omega", "zeta")}
    check_turns_and_settles(Rotor(**lowest, delta0=1.0))
    first: GivenStart
    if has_period(start, period):
        known = guess_in(start)
        check_no_hopf(known)
        first, period = numbers_in(known.state), known.period
    else:
        first = given_start("start", start, loaded=bool(varied.values("load").any()))
    near = checked(period)
    for each in varied.extremes():
        check_can_be_followed(each, start_of(each, first), settling=True)
    one = varied.rotor((0,) * len(varied.dims))
    axes = {name: each.tolist() for name, each in varied.axes.items()}
    told = {} if near is None else {"period": near}
    return _at_each(
        varied, varied.rotor, partial(_of_disc, first, near), DiscFlow(one),
        Question("limit_cycle", {"rotor": one, **axes, "start": first, **told}),
        provenance({"method": "taylor", "flight": "exact", "rtol": RTOL})
        | {"start": first if isinstance(first, str) else np.array(first)},
        varied.coordinates, "", jobs,
    )  # fmt: skip


def _of_disc(
    first: GivenStart, period: float | None, rotor: Rotor, stop: Stop
) -> Mapping[str, Any]:
    """Return the numbers of the cycle of a rotor."""
    try:
        guess = Guess(DiscFlow(rotor), np.array(start_of(rotor, first)), period)
        check_revolutions(guess)
    except InputError as error:  # a resonance has no settled whirl
        raise SimulationError(str(error)) from error
    return _numbers(guess, stop)


# ---- Of a rotor system ----


def cycles_of_system(
    asked: Varied, start: Any, speed: object, period: object, modes: int | None, jobs: Jobs
) -> xr.Dataset:
    """Return the cycles of a rotor system to which a start leads, or which lie near a guess.

    Without an axis of speeds, `speed` is a number, or None for that of the start.
    """
    speeds = asked.given[SPEED]
    ends = [abs(speeds).max(), abs(speeds).min()] if speeds.ndim else [speed]
    guess, *_ = [guess_of_system(asked.base, start, each, period, modes) for each in ends]
    check_no_hopf(guess)
    flow = guess.flow
    assert isinstance(flow, SystemFlow)
    if not speeds.ndim:
        asked = asked.over(speed=np.asarray(flow.speed))
    varied, first, kept = _begun(asked, start, guess, modes)
    turnings = Turnings(varied, CLOSING_RTOL)
    turnings.checked()
    lowest = [int(np.argmin(axis)) for axis in varied.axes.values()]
    if not turnings.at(lowest).problem.has_damping:
        raise InputError("damping must be above 0 for a limit cycle: nothing settles")
    given = {"start": kept, "modes": modes, "period": None if first.cycle else guess.period}
    told = {name: each for name, each in given.items() if each is not None}
    found = _at_each(
        varied, turnings.at, partial(_of_system, first), flow,
        Question("limit_cycle", {"rotor": asked.base, **varied.design, **told}),
        provenance({"method": "taylor", "rtol": CLOSING_RTOL})
        | {"axes": AXES[flow.period is None]},
        varied.coordinates | clearances_of(varied), " of a rotor system", jobs,
    )  # fmt: skip
    return with_meanings(in_words(found, asked.base), varied)


@dataclass(frozen=True, slots=True)
class SystemStart:
    """Where a rotor system begins at each point: a start, or the state of a cycle in q."""

    start: Start
    cycle: tuple[float, ...]
    period: float | None


def _begun(
    asked: Varied, start: Any, guess: Guess, modes: int | None
) -> tuple[Varied, SystemStart, Any]:
    """Return what varies in its modes, where it begins, and the start as a question keeps it."""
    taken, reduced = in_modes(asked.base, modes, start)
    varied, flow = replace(asked, system=taken), guess.flow
    assert isinstance(flow, SystemFlow)
    if not isinstance(start, xr.Dataset):
        return varied, SystemStart(reduced, (), guess.period), start
    if start.attrs.get(RESULT_KIND) not in RUNS:
        state = flow.in_q(guess.state)
        kept = {"speed": flow.speed, "period": guess.period, "final_state": ("component", state)}
        return varied, SystemStart(None, tuple(state.tolist()), guess.period), xr.Dataset(kept)
    if modes is not None:
        raise InputError(f"start must be (q, velocity) with modes, got a result and {modes!r}")
    ended = state_at_end(assemble(taken), start)
    return varied, SystemStart(ended, (), guess.period), ended


def _of_system(first: SystemStart, point: Turning, stop: Stop) -> Mapping[str, Any]:
    """Return the numbers of the cycle of a rotor system."""
    flow = SystemFlow.at(*point, stop)
    if first.cycle:
        return _numbers(Guess(flow, flow.given_state(np.array(first.cycle)), first.period), stop)
    return _numbers(Guess(flow, started(point, first.start) / flow.scales, first.period), stop)


# ---- Of both ----


def _numbers(guess: Guess, stop: Stop) -> dict[str, Any]:
    """Return the numbers of the cycle to which a guess leads, as columns."""
    found = cycle_dataset(guess, *found_cycle(guess, stop))
    numbers: dict[str, Any] = {name: found[name].values for name in _names(guess.flow)}
    if isinstance(guess.flow, DiscFlow):
        is_cycle = found.sizes["t"] > 0
        numbers |= {name: found[name].values[0] if is_cycle else math.nan for name in COMPONENTS}
    return numbers


def _names(flow: Flow) -> list[str]:
    """Return the names of the numbers of a cycle that are not over its own time or spectrum."""
    of_disc = (*OF_WHIRL, "whirl_sense") if isinstance(flow, DiscFlow) else ()
    return [*dims_of(flow), *OF_ERRORS, *of_disc]


def _at_each(
    varied: Varied,
    point_at: Callable[[Sequence[int]], Any],
    work: Callable[[Any, Stop], Mapping[str, Any]],
    flow: Flow,
    question: Question,
    attributes: Mapping[str, Any],
    coordinates: Mapping[str, Column],
    whose: str,
    jobs: Jobs,
) -> xr.Dataset:
    """Return the cycle at each point, with the labels of a result without one."""
    lost = cycle_dataset(Guess(flow, np.zeros(0)), None, FAILED)
    names = _names(flow)
    columns = {name: (str(lost[name].dims[0]), lost[name].size) if lost[name].ndim else None
               for name in names}  # fmt: skip
    whole = {name: lost[name].values for name in names if lost[name].dtype.kind != "f"}
    if isinstance(flow, DiscFlow):
        columns |= dict.fromkeys(COMPONENTS)
    found = answers_at_each(
        varied, point_at, work, columns, question, whole=whole,
        workers=jobs.workers, study=jobs.study, progress=jobs.progress,
    )  # fmt: skip
    for name in columns:
        found[name].attrs = lost[name].attrs
    places = {name: lost[name].variable for name in (*OF_PLACES, "multiplier") if name in lost}
    return labelled_dataset(
        f"Limit cycles over a range of parameters{whose}", found, {**coordinates, **places},
        {**attributes, **question.attribute()}, kind="cycles",
    )  # fmt: skip
