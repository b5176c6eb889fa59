"""One rotor of an atlas: its attractors, and the number of starts that end on each."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from functools import partial

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Arrays, Stop, Values
from rotor_ida.basins.atlas.resilience import Fill, Resilience, resilience_of, search_of
from rotor_ida.basins.attractors import Followed, family_of, kind_of
from rotor_ida.basins.dataset import sample_entropy
from rotor_ida.basins.disc import SCOUTS, SMALLEST_BATCH, Disc, labeller_of
from rotor_ida.basins.following import Labeller, follow_here
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED
from rotor_ida.basins.subjects import KnockedSystem
from rotor_ida.model.rotor import Rotor
from rotor_ida.results.studies.results import Form

# Most starts of one rotor, so that its labels fit into memory many times.
MOST_STARTS = 1_000_000
# Quantiles of the times after which starts are decided: the median, and 95 %.
QUANTILES = (0.5, 0.95)
# Their values without any start.
NEVER = np.full(2, np.nan)
RESILIENCE = tuple(each.name for each in fields(Resilience))


@dataclass(slots=True)
class Member:
    """An attractor of one rotor, with the starts that end on it."""

    row: np.void  # as in `rotor_ida.basins.attractors`
    count: int = 0  # number of these starts
    # median and 95 % of the times after which they are decided [1]; NaN if none
    settling: Values = field(default_factory=lambda: NEVER)
    # how far it is from being left, to the other attractors in their order; None if not requested
    resilience: Resilience | None = None
    identity: int = -1  # number of the attractor along the atlas; -1 until it is known

    @property
    def kind(self) -> str:
        """One of the kinds of `rotor_ida.steady.response`."""
        return kind_of(self.row)


@dataclass(slots=True)
class Cell:
    """One rotor, or a rotor system at a speed, with its attractors."""

    rotor: Rotor | KnockedSystem
    members: list[Member] = field(default_factory=list)
    undecided: int = 0  # number of starts, as the next one
    not_computed: int = 0
    entropies: tuple[float, float] = (math.nan, math.nan)  # of the basins and of their boundary
    # number of starts labelled again with a smaller error, and of those with the same label
    rechecked: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(2, dtype=np.int64))
    # the largest change of velocity and of position that was tried [1]
    largest_shocks: tuple[float, float] = (math.nan, math.nan)


@dataclass(frozen=True, slots=True)
class CellJob:
    """A rotor with its starts, (4, n), the number of shocks to try, and the error per step."""

    rotor: Rotor | KnockedSystem
    states: Values
    shocks: int = 0
    rtol: float | None = None  # that of a system is its own


def fill_cell(job: CellJob, stop: Stop) -> Cell:
    """Follow all starts of a rotor, count them by attractor, and try shocks."""
    labeller = scouted_of(job, stop)
    cell = cell_of(job, follow_here(labeller, job.states, stop))
    for fill in fills_of(cell, labeller, job.shocks, stop):
        fill.work(stop)
    return cell


def scouted_of(job: CellJob, stop: Stop) -> Labeller:
    """Return who labels the starts of a rotor; of one disc, with the cycles that some show."""
    labeller = labeller_of(job.rotor, job.rtol, stop)
    # with friction or under a load cycles are met soon enough
    if not isinstance(labeller, Disc) or labeller.smallest < SMALLEST_BATCH:
        return labeller
    return labeller.with_cycles(job.states[:, :SCOUTS], stop)


def cell_of(job: CellJob, followed: Followed) -> Cell:
    """Return a cell with its starts counted by attractor."""
    labels, cell = followed.labels, Cell(job.rotor)
    cell.undecided = int((labels == UNDECIDED).sum())
    cell.not_computed = int((labels == NOT_COMPUTED).sum())
    cell.rechecked = followed.rechecked
    cell.entropies = sample_entropy(job.states, labels, family_of(followed.kinds))
    for number, row in enumerate(followed.rows):
        times = followed.times[labels == number]
        settling = np.quantile(times, QUANTILES) if times.size else NEVER
        cell.members.append(Member(row, times.size, settling))
    return cell


def fills_of(cell: Cell, labeller: Labeller, shocks: int, stop: Stop) -> list[Fill]:
    """Return independent jobs that find how far each attractor of a cell is from being left."""
    if not shocks or stop[0] or not cell.members:
        return []
    rows = np.array([each.row for each in cell.members], labeller.columns)
    search = search_of(labeller, rows, shocks, stop)
    cell.largest_shocks = search.largest()
    resilience, fills = resilience_of(search)
    for member, each in zip(cell.members, resilience, strict=True):
        member.resilience = each
    return fills


def form_of(rotor: Rotor | KnockedSystem) -> Form[Cell]:
    """Return how cells are stored; the rotor is that of the first point until it is replaced."""
    return Form("attractors of a rotor", _as_arrays, partial(_from_arrays, rotor))


def _as_arrays(cell: Cell) -> Arrays:
    members = cell.members
    arrays = {
        "left": np.array([cell.undecided, cell.not_computed]),
        "count": np.array([each.count for each in members], dtype=np.int64),
        "settling": np.array([each.settling for each in members]),
        "rows": np.array([each.row for each in members]),
        "entropies": np.array(cell.entropies),
        "rechecked": cell.rechecked,
        "largest_shocks": np.array(cell.largest_shocks),
    }
    shocked = [each.resilience for each in members if each.resilience is not None]
    if shocked:
        arrays |= {name: np.array([getattr(each, name) for each in shocked]) for name in RESILIENCE}
    return arrays


def _from_arrays(rotor: Rotor | KnockedSystem, arrays: Arrays) -> Cell:
    undecided, not_computed = arrays["left"].tolist()
    members = [
        Member(
            row, int(count), settling,
            Resilience(**{name: arrays[name][place] for name in RESILIENCE})
            if "sizes" in arrays else None,
        )
        for place, (row, count, settling) in enumerate(
            zip(arrays["rows"], arrays["count"], arrays["settling"], strict=True)
        )
    ]  # fmt: skip
    return Cell(
        rotor, members, undecided, not_computed, tuple(arrays["entropies"].tolist()),
        arrays["rechecked"], tuple(arrays["largest_shocks"].tolist()),
    )  # fmt: skip
