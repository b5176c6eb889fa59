"""Follow many starts of one rotor on all cores, and keep of each only its result."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.batches import BatchResult, Undecided, joined, thinned
from rotor_ida.basins.features import COLUMNS, measure
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED, follow
from rotor_ida.basins.known_attractors import KnownAttractors
from rotor_ida.basins.trapping_regions import TrappingRegion
from rotor_ida.parallel import FailedJob, Progress, Stop, run_all
from rotor_ida.storage.studies.arrays import scratch
from rotor_ida.storage.studies.results import Results
from rotor_ida.sweeps.steady_state import DECAY_TIMES, durations

Values = npt.NDArray[np.float64]
Starts = Callable[[int, int], Values]

# Large enough that few lanes idle at the end of a batch, small enough to share the work evenly
# and to report progress. Who does the work has no say: it leaves no trace in the result.
LARGEST_BATCH, SMALLEST_BATCH = 8192, 512
FEWEST_BATCHES = 64
# The earlier of two windows lies so many 1/zeta after the start.
PATIENCE = 10.0
# Of more undecided orbits than this, a sample is clustered and the others are matched to it.
LARGEST_SAMPLE = 1_000_000


@dataclass(slots=True)
class FollowedStarts:
    """Results of many starts.

    Parameters
    ----------
    known : KnownAttractors
        The rotor and the attractors that closed forms give.
    labels : ndarray of int16, shape (n,)
        Number of the trapping region, UNDECIDED or NOT_COMPUTED.
    times : ndarray of float32, shape (n,)
        Time at which the start was decided, or given up [1]; NaN where not computed.
    batches : Results
        The batches, with more about those starts that no trapping region holds.
    undecided_count : int
        Number of these.
    interrupted : bool
        Whether the user stopped it.
    not_computed_reason : str
        Why starts were not computed, other than by an interrupt; empty if there are none.
    """

    known: KnownAttractors
    labels: npt.NDArray[np.int16]
    times: npt.NDArray[np.float32]
    batches: Results[BatchResult]
    undecided_count: int
    interrupted: bool = False
    not_computed_reason: str = ""

    def undecided(self) -> Iterator[Undecided]:
        """Yield the undecided orbits, batch by batch, in the order of the starts."""
        for _, batch in self.batches.results():
            yield batch.undecided

    def sample(self) -> Undecided:
        """Return the undecided orbits; of very many, every so many-th."""
        step = max(1, math.ceil(self.undecided_count / LARGEST_SAMPLE))
        return joined(thinned(self.undecided(), step))


@dataclass(frozen=True, slots=True)
class _Batch:
    """A stretch of the starts, (4, n) from number `first` on, with all that a process needs."""

    known: KnownAttractors
    first: int
    states: Values
    tolerance: float


def follow_starts(
    known: KnownAttractors,
    starts: Starts,
    count: int,
    kept: Results[BatchResult],
    *,
    tolerance: float,
    workers: int | None,
    executor: str,
    progress: Progress | None,
) -> FollowedStarts:
    """Follow every start until its attractor is certain, or for the time allowed.

    Parameters
    ----------
    known : KnownAttractors
        A damped rotor and the attractors that closed forms give.
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
    batches = (_Batch(known, first, starts(first, last), tolerance) for first, last in edges)
    interrupted, reason = False, ""
    if progress is not None and kept.points_done:
        progress(kept.points_done, count)
    if not due:  # then no cluster need be started
        return _gathered(known, count, kept, interrupted, reason)
    try:
        with closing(run_all(_follow, batches, workers=workers, executor=executor)) as followed:
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
    return _gathered(known, count, kept, interrupted, reason)


def _gathered(
    known: KnownAttractors, count: int, kept: Results[BatchResult], interrupted: bool, reason: str
) -> FollowedStarts:
    """Return the results of all starts, gathered from the batches."""
    labels = np.asarray(scratch((count,), np.int16, kept.folder))
    times = np.asarray(scratch((count,), np.float32, kept.folder))
    labels[:], times[:] = NOT_COMPUTED, np.nan
    undecided = 0
    for _, batch in kept.results():
        stretch = slice(batch.first, batch.first + batch.labels.size)
        labels[stretch], times[stretch] = batch.labels, batch.times
        undecided += batch.undecided.numbers.size
    return FollowedStarts(known, labels, times, kept, undecided, interrupted, reason)


def _follow(batch: _Batch, stop: Stop) -> BatchResult:
    """Follow a batch, describe the undecided by features, follow these on, describe them again."""
    known, rotor = batch.known, batch.known.rotor
    # the kernel overwrites them, and they may be a view of the caller's own
    states = np.array(batch.states, order="C")
    size = states.shape[1]
    labels = np.full(size, NOT_COMPUTED, dtype=np.int16)
    times = np.zeros(size, dtype=np.float32)
    wait, length, samples = durations(rotor)
    earlier_wait = wait * PATIENCE / DECAY_TIMES
    numbers = np.arange(size)
    windows: list[Values] = []
    for duration in (earlier_wait, wait - earlier_wait):
        here, took = labels[numbers], times[numbers]
        here[:] = NOT_COMPUTED
        follow(
            states, here, took, (rotor.omega, rotor.zeta, known.clearance), _table(known.regions),
            known.free, duration, batch.tolerance, stop,
        )  # fmt: skip
        labels[numbers], times[numbers] = here, took
        undecided = here == UNDECIDED
        numbers, states = numbers[undecided], np.ascontiguousarray(states[:, undecided])
        windows = [window[undecided] for window in windows]
        features = np.zeros((numbers.size, COLUMNS))
        measure(
            states, (rotor.omega, rotor.zeta, known.clearance), length / (samples - 1), samples - 1,
            features, stop,
        )  # fmt: skip
        windows.append(features)
        times[numbers] += np.float32(length)
    if stop[0]:
        labels[numbers] = NOT_COMPUTED
        numbers = numbers[:0]
        windows, states = [window[:0] for window in windows], states[:, :0]
    times[labels == NOT_COMPUTED] = np.nan
    earlier, later = (window.astype(np.float32) for window in windows)
    orbits = Undecided(batch.first + numbers, earlier, later, states)
    return BatchResult(batch.first, labels, times, orbits)


def _table(regions: list[TrappingRegion]) -> Values:
    return np.array([each.numbers for each in regions]).reshape(-1, 14)
