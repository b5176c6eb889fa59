"""Follow many starts of one rotor on all cores, and keep of each only what became of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.batches import BatchResult, Undecided, spread, together
from rotor_ida.basins.features import COLUMNS, watch
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED, follow
from rotor_ida.basins.known_attractors import KnownAttractors
from rotor_ida.basins.trapping_regions import TrappingRegion
from rotor_ida.parallel import FailedJob, Progress, Stop, run_all
from rotor_ida.storage.studies.arrays import scratch
from rotor_ida.storage.studies.results import Results
from rotor_ida.sweeps.response import PATIENCE
from rotor_ida.sweeps.steady_state import DECAY_TIMES, durations

Values = npt.NDArray[np.float64]
Starts = Callable[[int, int], Values]

# Large enough that few lanes idle at the end of a batch, small enough to share the work evenly
# and to report progress. Who does the work has no say: it leaves no trace in the result.
LARGEST_BATCH, SMALLEST_BATCH = 8192, 512
FEWEST_BATCHES = 64
# So many undecided orbits are compared with each other; of more, these are the examples by which
# the others are sorted.
MOST_EXAMPLES = 1_000_000


@dataclass(slots=True)
class FollowedStarts:
    """What became of many starts.

    Parameters
    ----------
    ends : KnownAttractors
        The rotor and its trapping regions.
    labels : ndarray of int16, shape (n,)
        Number of the trapping region, UNDECIDED or NOT_COMPUTED.
    times : ndarray of float32, shape (n,)
        Time that it took to decide, or at which following ended [1]; NaN where not computed.
    kept : Results
        The batches, with more about those that no set has captured.
    undecided_count : int
        Number of these.
    interrupted : bool
        Whether the user stopped it.
    lost : str
        Why starts were not computed although nobody stopped it; empty if all were.
    """

    ends: KnownAttractors
    labels: npt.NDArray[np.int16]
    times: npt.NDArray[np.float32]
    kept: Results[BatchResult]
    undecided_count: int
    interrupted: bool = False
    lost: str = ""

    def undecided(self) -> Iterator[Undecided]:
        """Yield the undecided orbits, part by part, in the order of the starts."""
        for _, batch in self.kept.results():
            yield batch.undecided

    def examples(self) -> Undecided:
        """Return the undecided orbits; of very many, some that are spread evenly."""
        step = max(1, math.ceil(self.undecided_count / MOST_EXAMPLES))
        return together(spread(self.undecided(), step))


@dataclass(frozen=True, slots=True)
class _Batch:
    """A stretch of the starts, (4, n) from number `first` on, with all that a process needs."""

    ends: KnownAttractors
    first: int
    states: Values
    tolerance: float


def follow_starts(
    ends: KnownAttractors,
    starts: Starts,
    count: int,
    kept: Results[BatchResult],
    *,
    tolerance: float,
    workers: int | None,
    executor: str,
    progress: Progress | None,
) -> FollowedStarts:
    """Follow every start until its end is certain, or its patience is at an end.

    Parameters
    ----------
    ends : KnownAttractors
        A damped rotor and its trapping regions.
    starts : callable
        Gives the starts from one number up to another as an array of shape (4, n) [1].
    count : int
        Number of starts.
    kept : Results
        Where the batches are kept; those that it holds already are not followed again.
    tolerance : float
        Error allowed in a step [1].
    workers, executor
        As for `rotor_ida.parallel.run_all`.
    progress : callable or None
        Called with the number of starts done and their total.
    """
    size = min(max(math.ceil(count / FEWEST_BATCHES), SMALLEST_BATCH), LARGEST_BATCH)
    due = [number for number in range(math.ceil(count / size)) if number not in kept.done]
    edges = ((number * size, min((number + 1) * size, count)) for number in due)
    batches = (_Batch(ends, first, starts(first, last), tolerance) for first, last in edges)
    interrupted, lost = False, ""
    if progress is not None and kept.points_done:
        progress(kept.points_done, count)
    if not due:  # then no cluster need be started
        return _surveyed(ends, count, kept, interrupted, lost)
    try:
        with closing(run_all(_follow, batches, workers=workers, executor=executor)) as followed:
            for turn, batch in followed:
                if isinstance(batch, FailedJob):
                    lost = batch.reason
                else:
                    kept.keep(due[turn], batch, batch.labels.size)
                if progress is not None:
                    progress(kept.points_done, count)
    except KeyboardInterrupt:
        if kept.folder is not None:  # a study goes on another time, from what it has kept
            raise
        interrupted = True
    return _surveyed(ends, count, kept, interrupted, lost)


def _surveyed(
    ends: KnownAttractors, count: int, kept: Results[BatchResult], interrupted: bool, lost: str
) -> FollowedStarts:
    """Return what became of all starts, gathered from the batches."""
    labels = np.asarray(scratch((count,), np.int16, kept.folder))
    times = np.asarray(scratch((count,), np.float32, kept.folder))
    labels[:], times[:] = NOT_COMPUTED, np.nan
    undecided = 0
    for _, batch in kept.results():
        stretch = slice(batch.first, batch.first + batch.labels.size)
        labels[stretch], times[stretch] = batch.labels, batch.times
        undecided += batch.undecided.numbers.size
    return FollowedStarts(ends, labels, times, kept, undecided, interrupted, lost)


def _follow(batch: _Batch, stop: Stop) -> BatchResult:
    """Follow a batch: a run, a look, a longer run, another look at those still on their way."""
    rotor, ends = batch.ends.rotor, batch.ends
    # the kernel overwrites them, and they may be a view of the caller's own
    states = np.array(batch.states, order="C")
    size = states.shape[1]
    labels = np.full(size, NOT_COMPUTED, dtype=np.int16)
    times = np.zeros(size, dtype=np.float32)
    wait, length, samples = durations(rotor)
    earlier_wait = wait * PATIENCE / DECAY_TIMES
    numbers = np.arange(size)
    looks: list[Values] = []
    for duration in (earlier_wait, wait - earlier_wait):
        here, took = labels[numbers], times[numbers]
        here[:] = NOT_COMPUTED
        follow(
            states, here, took, (rotor.omega, rotor.zeta, ends.clearance), _table(ends.sets),
            ends.free, duration, batch.tolerance, stop,
        )  # fmt: skip
        labels[numbers], times[numbers] = here, took
        left = here == UNDECIDED
        numbers, states = numbers[left], np.ascontiguousarray(states[:, left])
        looks = [look[left] for look in looks]
        look = np.zeros((numbers.size, COLUMNS))
        watch(
            states, (rotor.omega, rotor.zeta, ends.clearance), length / (samples - 1), samples - 1,
            look, stop,
        )  # fmt: skip
        looks.append(look)
        times[numbers] += np.float32(length)
    if stop[0]:
        labels[numbers] = NOT_COMPUTED
        numbers = numbers[:0]
        looks, states = [look[:0] for look in looks], states[:, :0]
    times[labels == NOT_COMPUTED] = np.nan
    narrow = [look.astype(np.float32) for look in looks]
    undecided = Undecided(batch.first + numbers, narrow[0], narrow[1], states)
    return BatchResult(batch.first, labels, times, undecided)


def _table(sets: list[TrappingRegion]) -> Values:
    return np.array([each.numbers for each in sets]).reshape(-1, 14)
