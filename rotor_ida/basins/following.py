"""Follow many starts of one rotor on all cores, and keep of each only its result."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.basins.agreement import count_agreeing, rechecked_of_batch, rechecked_of_rotor
from rotor_ida.basins.batches import CYCLE, MOTION, BatchResult
from rotor_ida.basins.fates import ALONE, Batch, decide
from rotor_ida.basins.kernel import LANES, NOT_COMPUTED, Labels, Times
from rotor_ida.basins.known import (
    Known,
    followed_alone,
    known_from_closed_forms,
    may_roll,
    same_cycle,
)
from rotor_ida.cycles.shooting import Cycle, close_orbit
from rotor_ida.model.parameters import Rotor
from rotor_ida.parallel import FailedJob, Progress, Stop, interruptible, run_all
from rotor_ida.results.studies.arrays import scratch
from rotor_ida.results.studies.results import Results
from rotor_ida.steady.follow import SettledResponse

Starts = Callable[[int, int], Values]

# A smaller batch would leave many lanes of the kernel idle at its end.
SMALLEST_BATCH = 512
# A larger one would seldom report progress.
LARGEST_BATCH = 8192
# Starts under a load, which are followed one by one, come in smaller ones,
SMALLEST_ALONE = 4
# and so do those with friction, of which some are.
SMALLEST_RUBBING = LANES
# Between these, so many share the work evenly. Who does it has no say in that: it leaves no trace
# in the result.
FEWEST_BATCHES = 64
# Before all others so many starts are followed, from which limit cycles become known.
SCOUTS = 128
# The error of a step [1],
RTOL = 1e-6
# but this one where with it one of so many starts ends elsewhere.
SMALL_RTOL = 1e-11
CHECKED = 512
# A first look shows only what whirls hold soon.
RTOL_OF_FIRST_LOOK = 1e-4


@dataclass(slots=True)
class FollowedStarts:
    """Results of many starts, n of them."""

    known: Known  # the rotor, and its whirls
    labels: Labels  # number of the attractor, by `first_cycle` from `known` and `cycles`, or a fate
    times: Times  # when each was decided, or given up [1]; NaN where not computed
    # those that starts end on, in the order in which batches met them
    cycles: list[Cycle] = field(default_factory=list)
    held: list[bool] = field(default_factory=list)  # whether a section of each holds starts
    # amplitude, phase lag and extreme radii of chaotic motions, shape (k, 4) [1]
    chaos: Values = field(default_factory=lambda: np.empty((0, MOTION)))
    left: float = 0.0  # number of orbits that left a chaotic motion while this was watched,
    watched: float = 0.0  # and for how long all of them together were watched [1]
    interrupted: bool = False  # by the user
    not_computed_reason: str = ""  # why starts were not computed, other than by an interrupt
    tolerance: float = RTOL  # error allowed in a step [1]
    # number of starts labelled again with a smaller error, and of those with the same label
    rechecked: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(2, dtype=np.int64))
    # as `chaos`, of quasi-periodic motions
    torus: Values = field(default_factory=lambda: np.empty((0, MOTION)))
    # and of motions that roll without a period
    rolling: Values = field(default_factory=lambda: np.empty((0, MOTION)))


@dataclass(frozen=True, slots=True)
class _Job:
    """A stretch of the starts, (4, n) from number `first` on, with all that a process needs.

    So many of them are labelled again, with a smaller error.
    """

    known: Known
    first: int
    states: Values
    tolerance: float
    rechecked: int


def follow_starts(
    known: Known,
    starts: Starts,
    count: int,
    kept: Results[BatchResult],
    *,
    tolerance: float | None,
    workers: int | None,
    executor: str,
    progress: Progress | None,
    drawn: bool = False,
) -> FollowedStarts:
    """Follow so many starts until the attractor of each is decided, or for the time allowed.

    Batches that are kept already are not followed again; a tolerance of None is chosen, by the
    first starts where they are `drawn`, which are the same however many follow.
    """
    alone = followed_alone(known.rotor)
    smallest = SMALLEST_RUBBING if may_roll(known.rotor) else SMALLEST_BATCH
    smallest = SMALLEST_ALONE if alone else smallest
    size = min(max(math.ceil(count / FEWEST_BATCHES), smallest), LARGEST_BATCH)
    due = [number for number in range(math.ceil(count / size)) if number not in kept.done]
    interrupted, reason = False, ""
    if progress is not None and kept.points_done:
        progress(kept.points_done, count)
    try:
        # whichever are left: the same cycles are known to all
        if alone:
            tolerance = tolerance or ALONE.rtol
        elif due and (count > size or tolerance is None):
            scout = partial(_scouted, known, starts, count, tolerance, drawn)
            known, tolerance = interruptible(scout)
        edges = ((each, each * size, min((each + 1) * size, count)) for each in due)
        allowed = tolerance or RTOL  # of the last batch, if there is one
        jobs = (
            _Job(known, first, starts(first, last), allowed, rechecked_of_batch(each, last - first))
            for each, first, last in edges
        )
        if due:  # else no cluster need be started
            with closing(run_all(_follow, jobs, workers=workers, executor=executor)) as followed:
                for turn, batch in followed:
                    if isinstance(batch, FailedJob):
                        reason = batch.reason
                    else:
                        kept.keep(due[turn], batch, batch.labels.size)
                    if progress is not None:
                        progress(kept.points_done, count)
    except KeyboardInterrupt:
        if kept.folder is not None:  # a study goes on another time, from what it has kept
            raise
        interrupted = True
    found = _gathered(known, count, kept)
    found.interrupted, found.not_computed_reason = interrupted, reason
    return found


def follow_here(known: Known, states: Values, tolerance: float, stop: Stop) -> FollowedStarts:
    """Follow starts of shape (4, n) in this process, the first of them before the others."""
    if not may_roll(known.rotor):  # else in a batch alone cycles are met soon enough
        known = _with_cycles(known, states[:, :SCOUTS], tolerance, stop)
    kept: Results[BatchResult] = Results()
    job = _Job(known, 0, states, tolerance, rechecked_of_rotor(states.shape[1]))
    kept.keep(0, _follow(job, stop), states.shape[1])
    return _gathered(known, states.shape[1], kept)


def first_look(rotor: Rotor, states: Values, duration: float, stop: Stop) -> FollowedStarts:
    """Follow starts of shape (4, n) for a short time: those that no whirl holds yet are undecided.

    It takes a small part of the time in which all of them are decided, and no limit cycle is
    sought.
    """
    known = known_from_closed_forms(rotor, stop, fading=False)
    batch = Batch(known, states, RTOL_OF_FIRST_LOOK, stop)
    batch.follow(np.arange(states.shape[1]), min(duration, known.first_wait))
    return FollowedStarts(known, batch.labels, batch.times, tolerance=RTOL_OF_FIRST_LOOK)


def _scouted(
    known: Known, starts: Starts, count: int, tolerance: float | None, drawn: bool, stop: Stop
) -> tuple[Known, float]:
    """Return what is known once a few starts have been followed, and the error to allow."""
    scouts = _few(starts, count, SCOUTS, drawn)
    known = _with_cycles(known, scouts, tolerance or RTOL, stop)
    if tolerance is not None:
        return known, tolerance
    sample = _few(starts, count, CHECKED, drawn)
    roughly, closely = (
        known.follow(sample.copy(), known.first_wait, rtol, stop)[0] for rtol in (RTOL, SMALL_RTOL)
    )
    decided = (roughly >= 0) & (closely >= 0)
    alike = bool((roughly == closely)[decided].all())
    return known, RTOL if alike else SMALL_RTOL


def _with_cycles(known: Known, scouts: Values, tolerance: float, stop: Stop) -> Known:
    """Return what is known once scouts have been followed, where these tell limit cycles."""
    if followed_alone(known.rotor):
        return known
    return decide(Batch(known, scouts, tolerance, stop)).known


def _few(starts: Starts, count: int, most: int, drawn: bool) -> Values:
    """Return a few starts, shape (4, n): spread over all, or where they are drawn the first.

    So what is chosen by these does not hang on how many are drawn, even where that is fewer.
    """
    if drawn:
        return starts(0, most)
    numbers = np.unique(np.linspace(0, count - 1, min(most, count)).astype(np.int64))
    return np.concatenate([starts(number, number + 1) for number in numbers.tolist()], axis=1)


def _follow(job: _Job, stop: Stop) -> BatchResult:
    """Follow a batch of starts until what becomes of them is decided."""
    batch = decide(Batch(job.known, job.states, job.tolerance, stop))
    rechecked = count_agreeing(
        batch.known, job.states, batch.labels, batch.times, job.tolerance,
        0 if followed_alone(batch.known.rotor) else job.rechecked, stop,
    )  # fmt: skip
    batch.times[batch.labels == NOT_COMPUTED] = np.nan
    cycles = [[*each.cycle.state, each.cycle.period, each.exists] for each in batch.known.cycles]
    return BatchResult(
        job.first, batch.labels, batch.times, np.array(cycles).reshape(-1, CYCLE),
        _motion_row(batch.chaotic), np.array([batch.left, batch.watched]), np.array(job.tolerance),
        rechecked, _motion_row(batch.torus), _motion_row(batch.rolling),
    )  # fmt: skip


def _motion_row(motion: SettledResponse | None) -> Values:
    """Return what is kept of a motion that is no cycle, if one was met, shape (k, 4)."""
    if motion is None:
        return np.empty((0, MOTION))
    seen = motion.features
    return np.array([[seen.amplitude, seen.phase_lag, seen.radius_min, seen.radius_max]])


def _gathered(known: Known, count: int, kept: Results[BatchResult]) -> FollowedStarts:
    """Return the results of all starts, gathered from the batches."""
    found = FollowedStarts(
        known,
        np.asarray(scratch((count,), np.int16, kept.folder)),
        np.asarray(scratch((count,), np.float32, kept.folder)),
    )
    found.labels[:], found.times[:] = NOT_COMPUTED, np.nan
    numbers: dict[tuple[float, ...], int] = {}
    for _, batch in kept.results():
        stretch = slice(batch.first, batch.first + batch.labels.size)
        found.labels[stretch] = _renumbered(batch, found, numbers)
        found.times[stretch] = batch.times
        found.chaos = np.concatenate([found.chaos, batch.chaos])
        found.torus = np.concatenate([found.torus, batch.torus])
        found.rolling = np.concatenate([found.rolling, batch.rolling])
        found.left += float(batch.watched[0])
        found.watched += float(batch.watched[1])
        found.tolerance = float(batch.tolerance)
        found.rechecked = found.rechecked + batch.rechecked
    return found


def _renumbered(
    batch: BatchResult, found: FollowedStarts, numbers: dict[tuple[float, ...], int]
) -> Labels:
    """Return the labels of a batch with its limit cycles numbered as those of all batches."""
    first, stop = found.known.first_cycle, np.zeros(1, np.uint8)
    labels = batch.labels.copy()
    for number, row in enumerate(batch.cycles):
        key = tuple(row.tolist())
        if key not in numbers:
            cycle = close_orbit(found.known.rotor, row[:4], float(row[4]), stop)
            same = [place for place, each in enumerate(found.cycles) if same_cycle(each, cycle)]
            numbers[key] = same[0] if same else len(found.cycles)
            if not same:
                found.cycles.append(cycle)
                found.held.append(bool(row[5]))
        labels[batch.labels == first + number] = first + numbers[key]
    return labels
