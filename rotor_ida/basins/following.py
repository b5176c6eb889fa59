"""Follow many starts of a rotor on all cores, batch by batch, and store only the result of each."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import partial
from typing import Protocol, Self

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values
from rotor_ida.basins.attractors import (
    Attractors,
    Ended,
    Followed,
    Found,
    Indices,
    kind_of,
    renumbered,
)
from rotor_ida.basins.fates import ALONE
from rotor_ida.basins.kernel import NOT_COMPUTED, Labels, Times
from rotor_ida.basins.known import followed_alone
from rotor_ida.basins.starts import Starts, stretches
from rotor_ida.core.runs import NO_STOP
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress, Workers
from rotor_ida.results.studies.arrays import scratch
from rotor_ida.results.studies.results import Form, Results
from rotor_ida.simulation.flow import Flow
from rotor_ida.simulation.options import Options
from rotor_ida.steady import response
from rotor_ida.steady.grid import Table, keep_whole, run_due

# Batches are no larger, or progress would seldom be reported.
LARGEST_BATCH = 8192
# There are this many, or fewer where they would be too small. It does not depend on the workers, so
# that the result does not either.
FEWEST_BATCHES = 64
# The method that follows starts side by side, in the core.
LABELLING_METHOD = "dop853"
# Confidence level of the lower bound on the lifetime of chaos.
CERTAINTY = 0.95

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
# Multiples of it modulo 1 are spread evenly and match no grid.
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


class Labeller(Protocol):
    """A rotor whose starts are labelled: `disc.Disc` or `subjects.KnockedSystem`."""

    @property
    def rtol(self) -> float | None:
        """Error allowed in a step, or tolerance of a run; None if it is to be chosen."""

    @property
    def smallest(self) -> int:
        """Fewest starts that are worth a batch."""

    @property
    def columns(self) -> np.dtype[np.void]:
        """The columns of the rows of its attractors."""

    def flow(self, stop: Stop) -> Flow:
        """Return how the rotor moves."""

    def listed(self) -> list[np.void]:
        """Return the attractors that a result has even if no start ends on them."""

    def scouted(self, starts: Starts, count: int, *, drawn: bool, stop: Stop) -> Self:
        """Return the same with what a few of many starts show, and a tolerance.

        If they are `drawn`, the starts do not depend on their number.
        """

    def label(self, states: Values, stop: Stop) -> Found:
        """Follow starts, shape (4, n), each until its attractor is decided."""


@dataclass(slots=True)
class BatchResult:
    """Results of a batch of starts.

    Parameters
    ----------
    first : int
        Number of its first start.
    labels : ndarray of int16, shape (n,)
        Number of the row of the attractor, UNDECIDED or NOT_COMPUTED.
    times : ndarray of float32, shape (n,)
        Time at which each start was decided, or given up; NaN where not computed.
    rows : structured array, shape (m,)
        The attractors.
    watched : ndarray, shape (2,)
        Number of observed orbits that left a chaotic motion, and the total time for which chaotic
        orbits were observed.
    rtol : float
        Error allowed in a step.
    rechecked : ndarray of int64, shape (2,)
        Number of starts labelled again with a smaller error, and of those with the same label.
    reason : str
        Why starts were not computed; else empty.
    """

    first: int
    labels: Labels
    times: Times
    rows: Table
    watched: Values
    rtol: float
    rechecked: npt.NDArray[np.int64]
    reason: str = ""


FORM: Form[BatchResult] = Form(
    "labelled batch of starts",
    lambda batch: {each.name: np.asarray(getattr(batch, each.name)) for each in fields(batch)},
    lambda arrays: BatchResult(
        int(arrays.pop("first")), rtol=float(arrays.pop("rtol")),
        reason=str(arrays.pop("reason")), **arrays,
    ),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Job:
    """A batch of starts, (4, n), from number `first` on, with all that a process needs.

    Some of them are labelled again, with a smaller error.
    """

    labeller: Labeller
    first: int
    states: Values
    rechecked: int


def follow_starts(
    labeller: Labeller, starts: Starts, count: int, kept: Results[BatchResult], *,
    workers: Workers, progress: Progress | None,
) -> Followed:  # fmt: skip
    """Follow starts until the attractor of each is decided, or for the time allowed.

    Batches that are stored already are not followed again.
    """
    size = min(max(math.ceil(count / FEWEST_BATCHES), labeller.smallest), LARGEST_BATCH)

    def job(number: int) -> _Job:
        first, last = number * size, min((number + 1) * size, count)
        again = 0 if number % ONE_BATCH_OF else math.ceil((last - first) / ONE_START_OF)
        return _Job(labeller, first, starts(first, last), again)

    keep = partial(keep_whole, kept, lambda batch: batch.labels.size)
    interrupted = False
    try:
        run_due(
            _follow, job, range(math.ceil(count / size)), kept, keep, workers=workers,
            progress=progress, total=count,
        )  # fmt: skip
    except KeyboardInterrupt:
        if kept.folder is not None:  # a study can be resumed later from what it has stored
            raise
        interrupted = True
    return _gathered(labeller, count, kept, Ended(interrupted, kept.lost))


def follow_here(labeller: Labeller, states: Values, stop: Stop) -> Followed:
    """Follow starts of shape (4, n) in this process."""
    kept: Results[BatchResult] = Results()
    count = states.shape[1]
    again = min(math.ceil(count / ONE_OF_ROTOR), MOST_OF_ROTOR)
    kept.keep(0, _follow(_Job(labeller, 0, states, again), stop), count)
    return _gathered(labeller, count, kept, Ended())


def _follow(job: _Job, stop: Stop) -> BatchResult:
    """Follow a batch of starts, and some of them again."""
    found = job.labeller.label(job.states, stop)
    chosen = spread_evenly(found.labels.size, job.rechecked)
    chosen = chosen[found.labels[chosen] >= 0]
    rechecked = np.zeros(2, dtype=np.int64)
    if chosen.size and not stop[0]:
        again = found.again(chosen)
        rechecked[:] = (again >= 0).sum(), (again == found.labels[chosen]).sum()
    found.times[found.labels == NOT_COMPUTED] = np.nan
    return BatchResult(
        job.first, found.labels, found.times, np.array(found.rows, job.labeller.columns),
        np.array(found.watched), job.labeller.rtol or math.nan, rechecked, found.reason,
    )  # fmt: skip


def _gathered(labeller: Labeller, count: int, kept: Results[BatchResult], ended: Ended) -> Followed:
    """Return the results of all starts, gathered from the batches."""
    labels, times = (np.asarray(scratch((count,), kind, kept.folder))
                     for kind in (np.int16, np.float32))  # fmt: skip
    labels[:], times[:] = NOT_COMPUTED, np.nan
    met = Attractors(labeller.flow(NO_STOP), labeller.listed())
    rechecked, watched, rtol = np.zeros(2, dtype=np.int64), np.zeros(2), labeller.rtol
    for _, batch in kept.results():
        part = slice(batch.first, batch.first + batch.labels.size)
        labels[part] = renumbered(batch.labels, met.numbers_of(batch.rows))
        times[part] = batch.times
        rechecked, watched, rtol = rechecked + batch.rechecked, watched + batch.watched, batch.rtol
        ended = ended if ended.reason else ended._replace(reason=batch.reason)
    order = met.order()
    ranks = np.argsort(order).tolist()
    for part in stretches(labels.size):
        labels[part] = renumbered(labels[part], ranks)
    rows = np.array([met.rows[each] for each in order], labeller.columns)
    return Followed(labels, times, _with_lifetimes(rows, *watched), rtol or math.nan,
                    rechecked, ended)  # fmt: skip


def _with_lifetimes(rows: Table, left: float, watched: float) -> Table:
    """Return attractors with the lifetime of chaos of one disc.

    The rate of leaving is taken as constant: n orbits left during a total observed time t.
    """
    chaotic = np.array([kind_of(row) == response.CHAOTIC for row in rows], bool)
    if chaotic.any() and "lifetime" in (rows.dtype.names or ()):
        from scipy.special import gammaincinv  # noqa: PLC0415 - takes long to import

        rows["lifetime"][chaotic] = watched / left if left else math.inf
        rows["lifetime_low"][chaotic] = watched / gammaincinv(left + 1.0, CERTAINTY)
    return rows


def tighter_than(tolerance: float) -> float:
    """Return the error per step with which starts are followed again.

    Examples
    --------
    >>> tighter_than(1e-6), tighter_than(1e-11)
    (1e-10, 1e-13)
    """
    return float(max(TIGHTER * tolerance, TIGHTEST))


def labelled_how(rtol: float, rotor: Rotor | None = None) -> dict[str, object]:
    """Return, as attributes, the method that labelled starts of a disc, or without of a system."""
    agreement: dict[str, object] = {"agreement_rtol": tighter_than(rtol)}
    if rotor is None or followed_alone(rotor):
        how: dict[str, object] = {"labelling_method": ALONE.method, "labelling_rtol": rtol}
        return how | (agreement if rotor is None else {})
    return {
        "labelling_method": LABELLING_METHOD, "labelling_rtol": rtol,
        "left_over_method": ALONE.method, "left_over_rtol": ALONE.rtol, **agreement,
    }  # fmt: skip


def followed_by(purpose: str, options: Options) -> dict[str, object]:
    """Return, as attributes, the method and tolerances with which orbits were followed."""
    return {f"{purpose}_{name}": value for name, value in options.attributes().items()}


def spread_evenly(count: int, few: int) -> Indices:
    """Return `few` numbers below `count`, spread evenly without matching a grid."""
    places = np.arange(1, few + 1) * GOLDEN % 1.0
    return np.unique((count * places).astype(np.int64))
