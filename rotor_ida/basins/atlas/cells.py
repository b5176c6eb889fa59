"""One rotor of an atlas: its attractors, and the number of starts that end on each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from operator import attrgetter
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Arrays, Stop, Values, Watch
from rotor_ida.basins.atlas.resilience import Fill, Resilience, Search, Subject, resilience_of
from rotor_ida.basins.atlas.rubbing import needs_run, settled_state
from rotor_ida.basins.attractors import (
    CONTACT_FREE_FAMILY,
    NUMBERS,
    Attractor,
    attractors_of,
    family_of,
)
from rotor_ida.basins.dataset import sample_entropy
from rotor_ida.basins.fates import APERIODIC
from rotor_ida.basins.following import FollowedStarts, follow_here
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED
from rotor_ida.basins.known import known_from_closed_forms, same_cycle, with_cycle
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.model.parameters import ALL_PARAMETERS, FRICTIONLESS, PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.results.studies.results import Form
from rotor_ida.schema import RESPONSE, TRAPPING, by_number

# Most starts of one rotor, so that its labels fit into memory many times.
MOST_STARTS = 1_000_000
# Parameters of the rotor in an archived cell: the paper's, the general ones, and the disc radius.
OF_MACHINES = (*PARAMETERS, *FRICTIONLESS)
# Quantiles of the times after which starts are decided: the median, and 95 %.
QUANTILES = (0.5, 0.95)
# Their values without any start.
NEVER = np.full(2, np.nan)
RESILIENCE = tuple(each.name for each in fields(Resilience))
_KIND = by_number(RESPONSE)
_TRAPPING = by_number(TRAPPING)


class Described(Protocol):
    """An attractor with what is reported of it."""

    @property
    def kind(self) -> str:
        """One of the kinds of `rotor_ida.steady.response`."""

    @property
    def numbers(self) -> Mapping[str, Any]:
        """Numbers by name; of a rotor system also arrays over its contacts, nodes and state."""


Found = TypeVar("Found", bound=Described)
Turned = TypeVar("Turned")


@dataclass(slots=True)
class Member(Generic[Found]):
    """An attractor of one rotor, with the starts that end on it."""

    attractor: Found
    count: int  # number of these starts
    settling: Values  # median and 95 % of the times after which they are decided [1]; NaN if none
    # on the rotating axes, of a limit cycle or of a torus, or of rolling without a period [1];
    state: Values  # else NaN
    # how far it is from being left, to the other attractors in their order; None if not requested
    resilience: Resilience | None = None
    identity: int = -1  # number of the attractor along the atlas; -1 until it is known


@dataclass(slots=True)
class Cell(Generic[Turned, Found]):
    """One rotor, or a rotor system at a speed, with its attractors."""

    rotor: Turned
    members: list[Member[Found]] = field(default_factory=list)
    undecided: int = 0  # number of starts, as the next one
    not_computed: int = 0
    entropies: tuple[float, float] = (math.nan, math.nan)  # of the basins and of their boundary
    # number of starts labelled again with a smaller error, and of those with the same label
    rechecked: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(2, dtype=np.int64))
    # the largest change of velocity and of position that was tried [1]
    largest_shocks: tuple[float, float] = (math.nan, math.nan)


DiscCell = Cell[Rotor, Attractor]


@dataclass(frozen=True, slots=True)
class CellJob:
    """A rotor with its starts, (4, n), the error per step, and the number of shocks to try."""

    rotor: Rotor
    states: Values
    tolerance: float
    shocks: int = 0


def fill_cell(job: CellJob, stop: Stop) -> DiscCell:
    """Follow all starts of a rotor, count them by attractor, and try shocks."""
    cell, search = counted_cell(job, stop)
    if search is not None:
        for fill in fills_of(cell, search):
            fill(stop)
    return cell


def counted_cell(
    job: CellJob, stop: Stop, watch: Watch | None = None
) -> tuple[DiscCell, Search | None]:
    """Follow all starts of a rotor, and count them by attractor; return the search for shocks.

    `watch` is as for `follow_here`.
    """
    known = known_from_closed_forms(job.rotor, stop)
    followed = follow_here(known, job.states, job.tolerance, stop, watch)
    attractors = attractors_of(followed)
    cell = cell_of(job.rotor, attractors, job.states, followed)
    for number, member in enumerate(cell.members):
        member.state = _state_on(job, followed, number, member.attractor)
    if not job.shocks or stop[0]:
        return cell, None
    search = _search_among(job, followed, attractors, stop)
    cell.largest_shocks = search.largest()
    return cell, search


class Followed(Protocol):
    """Starts that were followed."""

    @property
    def labels(self) -> npt.NDArray[np.int16]:
        """Number of the attractor of each, or a fate."""

    @property
    def times(self) -> npt.NDArray[np.float32]:
        """When each was decided."""

    @property
    def rechecked(self) -> npt.NDArray[np.int64]:
        """How many were labelled again, and how many of them alike."""


def cell_of(
    rotor: Turned, attractors: Sequence[Found], states: Values, followed: Followed
) -> Cell[Turned, Found]:
    """Return a cell with the starts, shape (4, n), counted by attractor."""
    labels, cell = followed.labels, Cell[Turned, Found](rotor)
    cell.undecided = int((labels == UNDECIDED).sum())
    cell.not_computed = int((labels == NOT_COMPUTED).sum())
    cell.rechecked = followed.rechecked
    cell.entropies = sample_entropy(states, labels, family_of([each.kind for each in attractors]))
    for number, attractor in enumerate(attractors):
        times = followed.times[labels == number]
        settling = np.quantile(times, QUANTILES) if times.size else NEVER
        cell.members.append(Member(attractor, times.size, settling, np.full(4, np.nan)))
    return cell


def fills_of(cell: DiscCell, search: Search) -> list[Fill]:
    """Return independent jobs that find how far each attractor of a cell is from being left."""
    resilience, fills = resilience_of(search)
    for member, each in zip(cell.members, resilience, strict=True):
        member.resilience = each
    return fills


def _state_on(job: CellJob, followed: FollowedStarts, number: int, attractor: Attractor) -> Values:
    """Return a state on an attractor, if its numbers do not determine one."""
    own, cycle = np.flatnonzero(followed.labels == number), _cycle_of(followed, attractor)
    if cycle is not None:
        return cycle.start
    if needs_run(attractor) and own.size:
        return settled_state(job.rotor, job.states[:, own[0]])
    return np.full(4, np.nan)


def _search_among(
    job: CellJob, followed: FollowedStarts, attractors: list[Attractor], stop: Stop
) -> Search:
    """Return the attractors of a rotor with all that the search for shocks needs."""
    known, subjects = followed.known, []
    for cycle in sorted(followed.cycles, key=attrgetter("radius_max")):
        if known.label_of_cycle(cycle) is None:
            known = with_cycle(known, cycle, stop)
    for number, attractor in enumerate(attractors):
        own = np.flatnonzero(followed.labels == number)
        start = job.states[:, own[0]] if own.size else np.full(4, np.nan)
        own_cycle, label = _cycle_of(followed, attractor), number  # the whirls come first
        if own_cycle is not None:
            same = [same_cycle(each.cycle, own_cycle) for each in known.cycles]
            label = known.first_cycle + same.index(True)
        elif attractor.kind in CONTACT_FREE_FAMILY:
            label = known.free_label
        elif attractor.kind in APERIODIC:
            label = APERIODIC[attractor.kind]
        subjects.append(Subject(attractor, label, own_cycle, start))
    return Search(known, subjects, job.shocks, job.tolerance, stop)


def _cycle_of(followed: FollowedStarts, attractor: Attractor) -> Orbit | None:
    """Return the limit cycle that an attractor is."""
    known = attractor.period, attractor.radius_max  # under a load several may have one period
    cycles = followed.cycles
    return next((each for each in cycles if (each.duration, each.radius_max) == known), None)


def arrays_of(cell: Cell[Any, Any]) -> Arrays:
    """Return what is stored of a cell besides its rotor and its attractors."""
    members = cell.members
    arrays = {
        "left": np.array([cell.undecided, cell.not_computed]),
        "count": np.array([each.count for each in members], dtype=np.int64),
        "settling": np.array([each.settling for each in members]),
        "state": np.array([each.state for each in members]),
        "entropies": np.array(cell.entropies),
        "rechecked": cell.rechecked,
        "largest_shocks": np.array(cell.largest_shocks),
    }
    shocked = [each.resilience for each in members if each.resilience is not None]
    if shocked:
        arrays |= {name: np.array([getattr(each, name) for each in shocked]) for name in RESILIENCE}
    return arrays


def cell_from(rotor: Turned, attractors: Sequence[Found], arrays: Arrays) -> Cell[Turned, Found]:
    """Return a stored cell: the inverse of `arrays_of`."""
    cell = Cell[Turned, Found](rotor)
    cell.undecided, cell.not_computed = arrays["left"].tolist()
    cell.entropies = tuple(arrays["entropies"].tolist())
    cell.rechecked = arrays.get("rechecked", cell.rechecked)  # absent in old files
    cell.largest_shocks = tuple(arrays["largest_shocks"].tolist())
    for place, (attractor, count) in enumerate(
        zip(attractors, arrays["count"].tolist(), strict=True)
    ):
        member = Member(attractor, count, arrays["settling"][place], arrays["state"][place])
        if "sizes" in arrays:
            kept = {name: arrays[name][place] for name in RESILIENCE if name in arrays}
            kept.setdefault("scatter", np.full_like(kept["sizes"], np.nan))  # likewise
            member.resilience = Resilience(**kept)
        cell.members.append(member)
    return cell


def _as_arrays(cell: DiscCell) -> Arrays:
    names = OF_MACHINES if cell.rotor.beyond else PARAMETERS
    names = names if cell.rotor.disc_radius is None else ALL_PARAMETERS
    attractors = [each.attractor for each in cell.members]
    return arrays_of(cell) | {
        "rotor": np.array([getattr(cell.rotor, name) for name in names]),
        "kind": np.array([RESPONSE[each.kind] for each in attractors], dtype=np.int8),
        "trapping": np.array([TRAPPING[each.trapping] for each in attractors], dtype=np.int8),
        "numbers": np.array([[getattr(each, name) for name in NUMBERS] for each in attractors]),
    }


def _from_arrays(arrays: Arrays) -> DiscCell:
    # parameters after the paper's are absent where they are the default
    given = zip(ALL_PARAMETERS, arrays["rotor"].tolist(), strict=False)
    attractors = [
        Attractor(_KIND[kind], trapping=_TRAPPING[trapping],
                  **dict(zip(NUMBERS, numbers, strict=True)))
        for kind, trapping, numbers in zip(
            *(arrays[name].tolist() for name in ("kind", "trapping", "numbers")), strict=True
        )
    ]  # fmt: skip
    return cell_from(Rotor(**dict(given)), attractors, arrays)


FORM = Form("cell of an atlas", _as_arrays, _from_arrays)
