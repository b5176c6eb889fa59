"""Follow many starts of one rotor on all cores, and store only the result of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, field, fields
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Arrays, Values, Watch
from rotor_ida.basins.fates import ALONE, Batch, decide
from rotor_ida.basins.kernel import (
    CHAOTIC,
    LANES,
    NOT_COMPUTED,
    QUASI_PERIODIC,
    ROLLING,
    UNDECIDED,
    Labels,
    Times,
)
from rotor_ida.basins.known import (
    Known,
    followed_alone,
    known_from_closed_forms,
    may_roll,
    same_cycle,
)
from rotor_ida.basins.starts import Starts
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.cycles.shooting import close_orbit
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import FailedJob, Progress, Stop, interruptible, run_all
from rotor_ida.parallel.jobs import Job, Result, Work
from rotor_ida.results.studies.arrays import scratch
from rotor_ida.results.studies.results import Form, Results
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.steady.follow import SettledResponse

# A smaller batch would leave many lanes of the kernel idle at its end.
SMALLEST_BATCH = 512
# A larger one would seldom report progress.
LARGEST_BATCH = 8192
# Smaller batches for starts under a load, which are followed one by one,
SMALLEST_ALONE = 4
# and for starts with friction, some of which are.
SMALLEST_RUBBING = LANES
# Between these, this number of batches. It does not depend on the workers, so that the result does
# not either.
FEWEST_BATCHES = 64
# Number of starts followed first, to find limit cycles.
SCOUTS = 128
# The error of a step [1],
RTOL = 1e-6
# but this one if it changes the attractor of any of this number of starts.
SMALL_RTOL = 1e-11
CHECKED = 512
# A first look shows only what is soon trapped by whirls.
RTOL_OF_FIRST_LOOK = 1e-4


class Ended(NamedTuple):
    """How a computation of many starts ended.

    Parameters
    ----------
    interrupted : bool
        Whether the user interrupted it.
    reason : str
        Why starts were not computed, other than by an interrupt; else empty.
    """

    interrupted: bool = False
    reason: str = ""


WHOLE = Ended()


@dataclass(slots=True)
class FollowedStarts:
    """Results of many starts, n of them."""

    known: Known  # the rotor, and its whirls
    labels: Labels  # number of the attractor, by `first_cycle` from `known` and `cycles`, or a fate
    times: Times  # when each was decided, or given up [1]; NaN where not computed
    # those that starts end on, in the order in which batches found them
    cycles: list[Orbit] = field(default_factory=list)
    has_section: list[bool] = field(default_factory=list)  # whether each has a trapping section
    # amplitude, phase lag and extreme radii of motions without a period, by label, shape (k, 4) [1]
    aperiodic: dict[int, Values] = field(default_factory=dict)
    left: float = 0.0  # number of observed orbits that left a chaotic motion
    watched: float = 0.0  # total time for which chaotic orbits were observed [1]
    ended: Ended = WHOLE
    tolerance: float = RTOL  # error allowed in a step [1]
    # number of starts labelled again with a smaller error, and of those with the same label
    rechecked: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(2, dtype=np.int64))


@dataclass(frozen=True, slots=True)
class _Job:
    """A batch of starts, (4, n), from number `first` on, with all that a process needs.

    Some of them are labelled again, with a smaller error.
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
    """Follow starts until the attractor of each is decided, or for the time allowed.

    Batches that are stored already are not followed again. A tolerance of None is replaced by one
    chosen from a few starts: if they are `drawn` the first ones, which do not depend on the number.
    """
    alone = followed_alone(known.rotor)
    smallest = SMALLEST_RUBBING if may_roll(known.rotor) else SMALLEST_BATCH
    size = size_of_batch(count, SMALLEST_ALONE if alone else smallest)

    def job_by_number(due: Sequence[int]) -> Callable[[int, int, int], _Job]:
        # whichever are left: the same cycles are known to all
        seen, allowed = known, tolerance
        if alone:
            allowed = allowed or ALONE.rtol
        elif due and (count > size or allowed is None):
            scout = partial(_scouted, known, starts, count, allowed, drawn)
            seen, allowed = interruptible(scout)
        rtol = allowed or RTOL  # of the last batch, if there is one

        def job(number: int, first: int, last: int) -> _Job:
            again = rechecked_of_batch(number, last - first)
            return _Job(seen, first, starts(first, last), rtol, again)

        return job

    ended = follow_in_batches(
        _follow, job_by_number, count, size, kept,
        workers=workers, executor=executor, progress=progress,
    )  # fmt: skip
    followed = _gathered(known, count, kept)
    followed.ended = ended
    return followed


def size_of_batch(count: int, smallest: int) -> int:
    """Return the number of starts of a batch: it does not depend on the workers."""
    return min(max(math.ceil(count / FEWEST_BATCHES), smallest), LARGEST_BATCH)


def follow_in_batches(
    work: Work[Job, Result],
    job_by_number: Callable[[Sequence[int]], Callable[[int, int, int], Job]],
    count: int,
    size: int,
    kept: Results[Result],
    *,
    workers: int | None,
    executor: str,
    progress: Progress | None,
) -> Ended:
    """Follow starts in batches of a size; those that are stored already are not followed again.

    `job_by_number` takes the numbers of the batches that are left, and returns the function that
    makes the job of a batch from its number, its first start, and the one behind its last.
    """
    due = [number for number in range(math.ceil(count / size)) if number not in kept.done]
    reason = ""

    def ends(number: int) -> tuple[int, int]:
        return number * size, min((number + 1) * size, count)

    if progress is not None and kept.points_done:
        progress(kept.points_done, count)
    try:
        job = job_by_number(due)
        jobs = (job(each, *ends(each)) for each in due)
        if due:  # else no cluster need be started
            with closing(run_all(work, jobs, workers=workers, executor=executor)) as batches:
                for turn, batch in batches:
                    if isinstance(batch, FailedJob):
                        reason = batch.reason
                    else:
                        first, last = ends(due[turn])
                        kept.keep(due[turn], batch, last - first)
                    if progress is not None:
                        progress(kept.points_done, count)
    except KeyboardInterrupt:
        if kept.folder is not None:  # a study can be resumed later from what it has stored
            raise
        return Ended(interrupted=True, reason=reason)
    return Ended(reason=reason)


def unlabelled(count: int, folder: Path | None) -> tuple[Labels, Times]:
    """Return labels and times of starts, none of which is computed."""
    labels = np.asarray(scratch((count,), np.int16, folder))
    times = np.asarray(scratch((count,), np.float32, folder))
    labels[:], times[:] = NOT_COMPUTED, np.nan
    return labels, times


def follow_here(
    known: Known, states: Values, tolerance: float, stop: Stop, watch: Watch | None = None
) -> FollowedStarts:
    """Follow starts of shape (4, n) in this process, the first of them before the others.

    `watch` receives a function that returns the number of starts decided.
    """
    if not may_roll(known.rotor):  # else in a batch alone cycles are met soon enough
        known = _with_cycles(known, states[:, :SCOUTS], tolerance, stop)
    kept: Results[BatchResult] = Results()
    job = _Job(known, 0, states, tolerance, rechecked_of_rotor(states.shape[1]))
    kept.keep(0, _follow(job, stop, watch), states.shape[1])
    return _gathered(known, states.shape[1], kept)


def first_look(rotor: Rotor, states: Values, duration: float, stop: Stop) -> FollowedStarts:
    """Follow starts of shape (4, n) briefly: those not yet trapped by a whirl stay undecided.

    This takes a small part of the time needed to decide all of them. No limit cycle is sought.
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
    """Return what is known once scouts have been followed, with the limit cycles they reveal."""
    if followed_alone(known.rotor):
        return known
    return decide(Batch(known, scouts, tolerance, stop)).known


def _few(starts: Starts, count: int, most: int, drawn: bool) -> Values:
    """Return a few starts, shape (4, n): spread over all, or the first ones if they are drawn.

    What is chosen from these then does not depend on the number drawn, even if that is smaller.
    """
    if drawn:
        return starts(0, most)
    numbers = np.unique(np.linspace(0, count - 1, min(most, count)).astype(np.int64))
    return np.concatenate([starts(number, number + 1) for number in numbers.tolist()], axis=1)


def _follow(job: _Job, stop: Stop, watch: Watch | None = None) -> BatchResult:
    """Follow a batch of starts until the attractor of each is decided."""
    batch = Batch(job.known, job.states, job.tolerance, stop)
    if watch is not None:
        watch.append(lambda: float(np.isin(batch.labels, OPEN, invert=True).sum()))
    batch = decide(batch)
    rechecked = count_agreeing(
        batch.known, job.states, batch.labels, batch.times, job.tolerance,
        0 if followed_alone(batch.known.rotor) else job.rechecked, stop,
    )  # fmt: skip
    batch.times[batch.labels == NOT_COMPUTED] = np.nan
    cycles = [[*each.cycle.start, each.cycle.duration, each.exists] for each in batch.known.cycles]
    return BatchResult(
        job.first, batch.labels, batch.times, np.array(cycles).reshape(-1, CYCLE),
        np.array([batch.left, batch.watched]), np.array(job.tolerance), rechecked,
        {label: _motion_row(motion) for label, motion in batch.aperiodic.items()},
    )  # fmt: skip


def _motion_row(motion: SettledResponse) -> Values:
    """Return the stored numbers of a motion without a period, shape (1, 4)."""
    features = motion.features
    return np.array(
        [[features.amplitude, features.phase_lag, features.radius_min, features.radius_max]]
    )


def _gathered(known: Known, count: int, kept: Results[BatchResult]) -> FollowedStarts:
    """Return the results of all starts, gathered from the batches."""
    followed = FollowedStarts(known, *unlabelled(count, kept.folder))
    numbers: dict[tuple[float, ...], int] = {}
    for _, batch in kept.results():
        stretch = slice(batch.first, batch.first + batch.labels.size)
        followed.labels[stretch] = _renumbered(batch, followed, numbers)
        followed.times[stretch] = batch.times
        for label, motion in batch.aperiodic.items():
            before = followed.aperiodic.get(label, NO_MOTION)
            followed.aperiodic[label] = np.concatenate([before, motion])
        followed.left += float(batch.watched[0])
        followed.watched += float(batch.watched[1])
        followed.tolerance = float(batch.tolerance)
        followed.rechecked = followed.rechecked + batch.rechecked
    return followed


def _renumbered(
    batch: BatchResult, followed: FollowedStarts, numbers: dict[tuple[float, ...], int]
) -> Labels:
    """Return the labels of a batch with its limit cycles numbered as those of all batches."""
    first, stop = followed.known.first_cycle, np.zeros(1, np.uint8)
    labels = batch.labels.copy()
    for number, row in enumerate(batch.cycles):
        key = tuple(row.tolist())
        if key not in numbers:
            cycle = close_orbit(DiscFlow(followed.known.rotor, stop), row[:4], float(row[4]))
            same = [place for place, each in enumerate(followed.cycles) if same_cycle(each, cycle)]
            numbers[key] = same[0] if same else len(followed.cycles)
            if not same:
                followed.cycles.append(cycle)
                followed.has_section.append(bool(row[5]))
        labels[batch.labels == first + number] = first + numbers[key]
    return labels


# Labels of starts that are not decided.
OPEN = (UNDECIDED, NOT_COMPUTED)
# What is stored of a limit cycle: state, period, and 1 if it has a trapping section.
CYCLE = 6
# Of a motion without a period: amplitude, phase lag, smallest and largest radius.
NO_MOTION = np.empty((0, 4))


@dataclass(slots=True)
class BatchResult:
    """Results of a batch of starts.

    Parameters
    ----------
    first : int
        Number of its first start.
    labels : ndarray of int16, shape (n,)
        Label of the attractor, ROLLING, CHAOTIC, QUASI_PERIODIC, UNDECIDED or NOT_COMPUTED; those
        of limit cycles number the rows of `cycles`.
    times : ndarray of float32, shape (n,)
        Time at which the start was decided, or given up [1]; NaN where not computed.
    cycles : ndarray, shape (m, 6)
        State, period, and whether there is a trapping section, of each known limit cycle [1].
    watched : ndarray, shape (2,)
        Number of observed orbits that left a chaotic motion, and the total time for which chaotic
        orbits were observed [1].
    tolerance : ndarray, shape ()
        Error allowed in a step [1].
    rechecked : ndarray of int64, shape (2,)
        Number of starts labelled again with a smaller error, and of those with the same label.
    aperiodic : dict of int to ndarray, shape (k, 4)
        Amplitude, phase lag and extreme radii of one motion of each kind without a period, by its
        label [1].
    """

    first: int
    labels: npt.NDArray[np.int16]
    times: npt.NDArray[np.float32]
    cycles: Values
    watched: Values
    tolerance: Values
    rechecked: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(2, dtype=np.int64))
    aperiodic: dict[int, Values] = field(default_factory=dict)


# Names of the motions without a period in a study.
_KEPT_AS = {CHAOTIC: "chaos", QUASI_PERIODIC: "torus", ROLLING: "rolling"}


def _as_arrays(batch: BatchResult) -> Arrays:
    own = [each.name for each in fields(batch) if each.name != "aperiodic"]
    motions = {word: batch.aperiodic.get(label, NO_MOTION) for label, word in _KEPT_AS.items()}
    return {name: np.asarray(getattr(batch, name)) for name in own} | motions


def _from_arrays(arrays: Arrays) -> BatchResult:
    motions = {label: arrays.pop(word, NO_MOTION) for label, word in _KEPT_AS.items()}
    return BatchResult(int(arrays.pop("first")), aperiodic=motions, **arrays)


FORM = Form("batch of starts", _as_arrays, _from_arrays)


# Labels are recomputed in one of this number of batches,
ONE_BATCH_OF = 8
# for one of this number of its starts. This takes less than a twentieth of the time; fewer starts
# at a time would leave lanes of the kernel idle.
ONE_START_OF = 12
# In an atlas they are recomputed for one of this number of a rotor's starts,
ONE_OF_ROTOR = 32
# up to this number of them.
MOST_OF_ROTOR = 32
# They are followed with this fraction of the error per step,
TIGHTER = 1e-4
# but never with less than double precision allows.
TIGHTEST = 1e-13
# Longest time for which a start is followed again [1].
LONGEST = 4000.0
# Multiples of it modulo 1 are spread evenly and match no grid.
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def tighter_than(tolerance: float) -> float:
    """Return the error per step with which starts are followed again.

    Examples
    --------
    >>> tighter_than(1e-6), tighter_than(1e-11)
    (1e-10, 1e-13)
    """
    return float(max(TIGHTER * tolerance, TIGHTEST))


def rechecked_of_batch(number: int, size: int) -> int:
    """Return how many starts of a batch with this number and size are followed again."""
    return 0 if number % ONE_BATCH_OF else math.ceil(size / ONE_START_OF)


def rechecked_of_rotor(starts: int) -> int:
    """Return how many of all starts of a rotor are followed again, where they are one batch."""
    return min(math.ceil(starts / ONE_OF_ROTOR), MOST_OF_ROTOR)


def count_agreeing(
    known: Known, states: Values, labels: Labels, times: Times, tolerance: float, rechecked: int,
    stop: Stop,
) -> npt.NDArray[np.int64]:  # fmt: skip
    """Return how many starts were labelled again, and how many of them got the same label.

    They are chosen evenly from the n starts, shape (4, n), without those that have no attractor.
    None is followed for longer than the longest of them was before.
    """
    chosen = spread_evenly(labels.size, rechecked)
    chosen = chosen[labels[chosen] >= 0]
    if not chosen.size or stop[0]:
        return np.zeros(2, dtype=np.int64)
    duration = min(max(float(times[chosen].max()), known.first_wait), LONGEST)
    again, _ = known.follow(
        np.ascontiguousarray(states[:, chosen]), duration, tighter_than(tolerance), stop
    )
    held = again >= 0
    return np.array([held.sum(), (again == labels[chosen])[held].sum()])


def spread_evenly(count: int, few: int) -> npt.NDArray[np.int64]:
    """Return `few` numbers below `count`, spread evenly without matching a grid."""
    places = np.arange(1, few + 1) * GOLDEN % 1.0
    return np.unique((count * places).astype(np.int64))
