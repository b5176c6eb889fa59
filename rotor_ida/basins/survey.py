"""Follow many starts of one rotor on all cores, and keep of each only what became of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.capture import CaptureSet, capture_sets
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED, follow
from rotor_ida.basins.windows import COLUMNS, watch
from rotor_ida.ensemble import Lost, Progress, Stop, run_all
from rotor_ida.parameters import Rotor
from rotor_ida.response import PATIENCE
from rotor_ida.settling import DECAY_TIMES, durations

Values = npt.NDArray[np.float64]
Starts = Callable[[int, int], Values]

# Large enough that few lanes idle at the end of a batch, small enough to share the work evenly
# and to report progress. Who does the work has no say: it leaves no trace in the result.
LARGEST_BATCH, SMALLEST_BATCH = 8192, 512
FEWEST_BATCHES = 64


@dataclass(frozen=True, slots=True)
class Ends:
    """What is certain about the ends of a rotor's orbits before any is followed.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    sets : list of CaptureSet
        Of each stable whirl in contact; their numbers are labels.
    free : ndarray, shape (3,)
        Contact-free whirl on the rotating axes [1] and the squared radius within which its centre
        stays; negative if there is none. Its label is ``len(sets)``.
    """

    rotor: Rotor
    sets: list[CaptureSet]
    free: Values

    @property
    def has_free(self) -> bool:
        """Whether there is a contact-free whirl."""
        return bool(self.free[2] >= 0.0)

    @property
    def clearance(self) -> float | None:
        """Clearance as the kernel wants it: None for 0, where it needs less arithmetic."""
        return self.rotor.delta0 if self.rotor.delta0 > 0.0 else None


def ends_of(rotor: Rotor) -> Ends:
    """Return the capture sets of a damped rotor."""
    if rotor.omega == 0.0 and rotor.delta0 == 0.0:
        # The energy only falls, and all comes to rest; as slowly as 1/t**2, so that nearby is near.
        near = CaptureSet(0.0, 0.0, np.zeros(4), 1e4 * np.eye(4))
        return Ends(rotor, [near], np.array([0.0, 0.0, -1.0]))
    nothing = np.array([0.0, 0.0, -1.0])
    sets = capture_sets(rotor) if rotor.omega > 0.0 else []
    resistance = complex(rotor.omega, -2.0 * rotor.zeta)
    whirl = -rotor.omega / resistance
    room = rotor.delta0 - abs(whirl)
    return Ends(rotor, sets, np.array([whirl.real, whirl.imag, room**2]) if room > 0.0 else nothing)


@dataclass(slots=True)
class Undecided:
    """The orbits that no set has captured: what they do over two windows, and where they end.

    Parameters
    ----------
    numbers : ndarray of int64, shape (n,)
        Which starts.
    earlier, later : ndarray of float32, shape (n, 5)
        The columns of `rotor_ida.basins.windows` [1].
    states : ndarray, shape (4, n)
        States at the end, on the rotating axes [1].
    """

    numbers: npt.NDArray[np.int64]
    earlier: npt.NDArray[np.float32]
    later: npt.NDArray[np.float32]
    states: Values


@dataclass(slots=True)
class Survey:
    """What became of many starts.

    Parameters
    ----------
    ends : Ends
        The rotor and its capture sets.
    labels : ndarray of int16, shape (n,)
        Number of the capture set, UNDECIDED or NOT_COMPUTED.
    times : ndarray of float32, shape (n,)
        Time that it took to decide, or at which following ended [1]; NaN where not computed.
    undecided : Undecided
        More about those that no set has captured.
    interrupted : bool
        Whether the user stopped it.
    lost : str
        Why starts were not computed although nobody stopped it; empty if all were.
    """

    ends: Ends
    labels: npt.NDArray[np.int16]
    times: npt.NDArray[np.float32]
    undecided: Undecided
    interrupted: bool = False
    lost: str = ""


@dataclass(frozen=True, slots=True)
class _Batch:
    """A stretch of the starts, (4, n) from number `first` on, with all that a process needs."""

    ends: Ends
    first: int
    states: Values
    tolerance: float


@dataclass(slots=True)
class _Followed:
    """What became of a batch."""

    labels: npt.NDArray[np.int16]
    times: npt.NDArray[np.float32]
    undecided: Undecided = field(repr=False)


def survey(
    rotor: Rotor,
    starts: Starts,
    count: int,
    *,
    tolerance: float,
    workers: int | None,
    executor: str,
    progress: Progress | None,
) -> Survey:
    """Follow every start until its end is certain, or its patience is at an end.

    Parameters
    ----------
    rotor : Rotor
        A damped rotor.
    starts : callable
        Gives the starts from one number up to another as an array of shape (4, n) [1].
    count : int
        Number of starts.
    tolerance : float
        Error allowed in a step [1].
    workers, executor
        As for `rotor_ida.ensemble.run_all`.
    progress : callable or None
        Called with the number of starts done and their total.
    """
    ends = ends_of(rotor)
    labels = np.full(count, NOT_COMPUTED, dtype=np.int16)
    times = np.full(count, np.nan, dtype=np.float32)
    parts: list[Undecided] = []
    size = min(max(math.ceil(count / FEWEST_BATCHES), SMALLEST_BATCH), LARGEST_BATCH)
    edges = [(first, min(first + size, count)) for first in range(0, count, size)]
    batches = (_Batch(ends, first, starts(first, last), tolerance) for first, last in edges)
    done, interrupted, lost = 0, False, ""
    try:
        with closing(run_all(_follow, batches, workers=workers, executor=executor)) as followed:
            for number, batch in followed:
                first, last = edges[number]
                if isinstance(batch, Lost):
                    lost = batch.reason
                else:
                    labels[first:last], times[first:last] = batch.labels, batch.times
                    parts.append(batch.undecided)
                done += last - first
                if progress is not None:
                    progress(done, count)
    except KeyboardInterrupt:
        interrupted = True
    return Survey(ends, labels, times, _together(parts), interrupted, lost)


def _follow(batch: _Batch, stop: Stop) -> _Followed:
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
    return _Followed(labels, times, Undecided(batch.first + numbers, narrow[0], narrow[1], states))


def _table(sets: list[CaptureSet]) -> Values:
    return np.array([each.numbers for each in sets]).reshape(-1, 14)


def _together(parts: list[Undecided]) -> Undecided:
    """Join what the batches left undecided, in the order of the starts."""
    parts = sorted(parts, key=lambda part: int(part.numbers[0]) if part.numbers.size else -1)
    empty = np.empty((0, COLUMNS), dtype=np.float32)
    return Undecided(
        np.concatenate([np.empty(0, dtype=np.int64), *(part.numbers for part in parts)]),
        np.concatenate([empty, *(part.earlier for part in parts)]),
        np.concatenate([empty, *(part.later for part in parts)]),
        np.concatenate([np.empty((4, 0)), *(part.states for part in parts)], axis=1),
    )
