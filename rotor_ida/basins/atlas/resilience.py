"""Resilience: how far each attractor of a rotor is from being left, by a shock or by drift.

For each attractor the smallest shock found to each other one, followed again to confirm it. Of one
disc a separate run does so; there is also the size up to which no shock leaves the attractor,
proven or estimated, and the extents of its parameters. A rotor system has no trapping regions: each
shock is followed until it has settled, as a start, and the smallest again with a tighter tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import ClassVar, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values
from rotor_ida.basins.atlas.extents import (
    UNKNOWN,
    End,
    extent_of_contact_free,
    extent_of_cycle,
    extent_of_whirl,
    varied,
)
from rotor_ida.basins.atlas.shocks import (
    CHANGES,
    KINDS,
    ONE_BY_ONE,
    SIDE_BY_SIDE,
    Blows,
    Effort,
    Shocks,
    Source,
    bound_of_cycle,
    bound_of_held_whirl,
    bound_of_whirl,
    ends_of_disc,
    try_shocks,
)
from rotor_ida.basins.attractors import (
    AT_THE_SPIN,
    CONTACT_FREE_FAMILY,
    Attractors,
    has_period,
    kind_of,
    leads_to,
    state_on,
    witness_options,
)
from rotor_ida.basins.disc import Disc
from rotor_ida.basins.fates import APERIODIC
from rotor_ida.basins.following import Labeller, tighter_than
from rotor_ida.basins.kernel import CHAOTIC, UNDECIDED, Labels
from rotor_ida.basins.known import ContactFree, Known, may_roll, with_cycle
from rotor_ida.basins.subjects import KnockedSystem, ends_of
from rotor_ida.cycles.shooting import close_orbit
from rotor_ida.errors import SimulationError
from rotor_ida.schema import END
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.system_flow import SystemFlow
from rotor_ida.steady import response
from rotor_ida.steady.grid import Table

Flags = npt.NDArray[np.int8]

# Shocks are tried up to this multiple of the largest attractor or the clearance; shocks of
# velocity up to the speed of a whirl of that size.
LARGEST = 4.0
# The search begins with sizes down to this fraction of that.
SMALLEST = 1e-4
# The smallest shock is followed again to its attractor. If that is another one, shocks larger by
# these fractions are: a basin boundary is known to an error, and may be finely folded.
LARGER = (0.0, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0)
# Number of states of one disc at which a limit cycle is shocked, or a motion without a period over
# this number of revolutions; and of chaos, a unit of time apart.
SAMPLES, REVOLUTIONS = 1024, 64
# Number of states of a rotor system, of which each takes a run for a shock.
PLACES = 64
# Shocks of one disc with friction that are followed side by side.
FEW = 64
# Chaos that is left before this number of them is not shocked.
FEWEST = 128


class Fill(NamedTuple):
    """A job that fills in a part of what is known of an attractor."""

    work: Callable[[Stop], None]
    shocks: int  # that it is to follow, as far as that is known before
    followed: list[int]  # numbers of shocks that it has followed so far


@dataclass(slots=True)
class Resilience:
    """How far an attractor is from being left; shocks of velocity first, then of displacement."""

    # the smallest shock to each of m attractors that was confirmed, or NaN: (2, m) [1]
    sizes: Values
    before: Values  # states just before it, shape (2, m, n) [1]
    after: Values  # and just after
    # relative excess of the best over the smallest that another draw led to, before it was
    # confirmed, shape (2, m) [1]
    scatter: Values
    # the lowest and the highest value of each parameter at which the attractor exists [1],
    extents: Values
    # and how it ends there: numbers of `rotor_ida.schema.END`
    ends: Flags
    # the size below which no shock leaves it, proven for whirls, estimated for cycles [1]
    bounds: Values = field(default_factory=lambda: np.zeros(2))

    @classmethod
    def unknown(cls, attractors: int, size: int, parameters: int) -> Self:
        """Return the resilience of an attractor about which nothing is known."""
        sizes, states = np.full((2, attractors), np.nan), np.full((2, attractors, size), np.nan)
        over = parameters, 2
        return cls(sizes, states, states.copy(), sizes.copy(), np.full(over, np.nan),
                   np.full(over, END["not_found"], dtype=np.int8))  # fmt: skip


@dataclass(frozen=True, slots=True)
class DiscSearch:
    """One disc with all that the search for shocks needs."""

    effort: ClassVar[Effort] = SIDE_BY_SIDE

    known: Known
    rows: Table
    labels: list[int]  # as in `rotor_ida.basins.kernel`
    shocks: int
    rtol: float  # error allowed in a step [1]
    stop: Stop

    @classmethod
    def of(cls, disc: Disc, rows: Table, shocks: int, stop: Stop) -> Self:
        """Return the search with all limit cycles known."""
        known, labels = disc.known, []
        for number, row in enumerate(rows):  # the whirls come first
            kind = kind_of(row)
            if has_period(row):
                flow = DiscFlow(known.rotor, stop)
                cycle = close_orbit(flow, row["final_state"], float(row["period"]))
                label = known.label_of_cycle(cycle)
                if label is None:
                    label = known.first_cycle + len(known.cycles)
                    known = with_cycle(known, cycle, stop)
                labels.append(label)
            elif kind in CONTACT_FREE_FAMILY:
                labels.append(known.free_label)
            else:
                labels.append(APERIODIC.get(kind, number))
        return cls(known, rows, labels, shocks, disc.rtol or math.nan, stop)

    def largest(self) -> tuple[float, float]:
        """Return the largest change of velocity and of position that is tried [dimensionless]."""
        rotor = self.known.rotor
        radii = [radius for radius in self.rows["radius_max"].tolist() if radius > 0.0]
        size = LARGEST * max([1.0, rotor.delta0, *radii])
        return size * max(1.0, rotor.omega), size

    def at(self, stop: Stop) -> Self:
        """Return the same, which ends as soon as `stop` is not 0."""
        return replace(self, stop=stop)

    @property
    def at_a_time(self) -> int:
        """Number of shocks after which progress is reported, since some are slow with friction."""
        return FEW if may_roll(self.known.rotor) else self.shocks

    def source(self, number: int) -> Source | None:
        """Return a source of states of an attractor, or None if they are not known."""
        rotor, free = self.known.rotor, self.known.free
        if rotor.omega == 0.0:
            return None
        if kind_of(self.rows[number]) in CONTACT_FREE_FAMILY:
            return None if free is None else partial(_contact_free_states, free, rotor.omega)
        try:
            states = self._states(number)
        except SimulationError:
            return None
        return _spread_over(states) if states.size else None

    def _states(self, number: int) -> Values:
        """Return states of an attractor other than the contact-free ones, shape (4, n)."""
        row, flow = self.rows[number], DiscFlow(self.known.rotor, self.stop)
        state = row["final_state"]
        if kind_of(row) == response.SYNCHRONOUS:
            return np.asarray(state[:, np.newaxis])
        if not np.isfinite(state).all():
            return np.empty((4, 0))
        chaotic = self.labels[number] == CHAOTIC
        duration = row["period"] if has_period(row) else REVOLUTIONS * flow.revolution
        duration = SAMPLES if chaotic else duration
        states = flow.states(state, np.linspace(0.0, duration, SAMPLES, endpoint=False)).T
        if not chaotic or may_roll(flow.rotor):
            return states
        # chaos, while it lasts: a motion that leaves by itself needs no shock
        left = np.flatnonzero(ends_of_disc(self.known, states, self.rtol, self.stop) != UNDECIDED)
        lasting = int(left[0]) if left.size else SAMPLES
        return states[:, : lasting if lasting >= FEWEST else 0]

    def changes(self, kind: str) -> Values:
        """Return how a state changes by shocks of size 1 along x and along y."""
        return CHANGES[kind]

    def ends(self, states: Values) -> Labels:
        """Return the labels of states, shape (4, n).

        If there is chaos, states that enter no region in time count as chaotic, until checked.
        """
        labels = ends_of_disc(self.known, states, self.rtol, self.stop)
        if CHAOTIC in self.labels:
            labels[labels == UNDECIDED] = CHAOTIC
        return labels

    def holds(self, number: int, state: Values) -> bool:
        """Return whether a separate run leads from a state to an attractor."""
        row, options = self.rows[number], witness_options()
        return not self.stop[0] and leads_to(
            self.known.rotor, row, state, options, family=True, stop=self.stop
        )

    def kept(self, state: Values) -> Values:
        """Return a state as a result has it: on the rotating axes."""
        return state

    def bound(self, number: int, kind: str) -> float:
        """Return the proven size up to which no shock leaves a whirl; 0 if none is known."""
        known, label = self.known, self.labels[number]
        if kind_of(self.rows[number]) == response.SYNCHRONOUS:
            return bound_of_whirl(known.whirls[label], kind)
        if label == known.free_label and known.free is not None and known.free.alone:
            return bound_of_held_whirl(known.rotor, known.free.room, kind)
        return 0.0

    def estimate(self, number: int, kind: str, source: Source, most: float) -> float:
        """Return that size of a limit cycle, by shocks up to the size `most`; else 0."""
        place = self.labels[number] - self.known.first_cycle
        if not 0 <= place < len(self.known.cycles):
            return 0.0
        return bound_of_cycle(self.known.cycles[place], source, kind, most, self.stop)

    def extent(self, number: int, name: str) -> tuple[End, End]:
        """Return the range of a parameter in which an attractor exists."""
        row, rotor = self.rows[number], self.known.rotor
        if rotor.omega == 0.0:
            return UNKNOWN, UNKNOWN
        if kind_of(row) in CONTACT_FREE_FAMILY:
            return extent_of_contact_free(rotor, name)
        if kind_of(row) == response.SYNCHRONOUS:
            return extent_of_whirl(rotor, float(row["amplitude"]), name)
        if not has_period(row):
            return UNKNOWN, UNKNOWN
        return extent_of_cycle(rotor, row["final_state"], float(row["period"]), name, self.stop)


@dataclass(frozen=True, slots=True)
class SystemSearch:
    """A rotor system with all that the search for shocks needs."""

    effort: ClassVar[Effort] = ONE_BY_ONE
    at_a_time: ClassVar[int] = 1  # shocks after which progress is reported

    knocked: KnockedSystem
    rows: Table
    shocks: int
    flow: SystemFlow

    @property
    def labels(self) -> list[int]:
        """The label of each attractor: its number."""
        return list(range(len(self.rows)))

    def largest(self) -> tuple[float, float]:
        """Return the largest change of velocity and of displacement that is tried."""
        radii = [self.rows[name].ravel() for name in ("radius_max", "node_radius_max")]
        size = LARGEST * float(np.nanmax(np.concatenate([self.flow.clearances, *radii])))
        return size * abs(self.flow.speed), size

    def at(self, stop: Stop) -> Self:
        """Return the same, which ends as soon as `stop` is not 0."""
        return replace(self, flow=self.knocked.flow(stop))

    def source(self, number: int) -> Source:
        """Return a source of states of an attractor.

        In a system that is not axisymmetric they are those after whole revolutions, where runs
        begin.
        """
        row, flow, times = self.rows[number], self.flow, np.zeros(1)
        if kind_of(row) not in AT_THE_SPIN:
            turns = row["period"] / flow.revolution if has_period(row) else REVOLUTIONS
            if flow.period is None:
                times = np.linspace(0.0, turns * flow.revolution, PLACES, endpoint=False)
            else:
                times = flow.revolution * np.arange(round(turns))
        states = [state_on(flow, row)]
        for step in np.diff(times).tolist():
            states.append(flow.after(states[-1], step))
        return _spread_over(np.array(states).T)

    def changes(self, kind: str) -> Values:
        """Return how a state changes by shocks of the node of size 1 along x and along y."""
        first = KINDS[kind]
        return self.knocked.shapes[:, first : first + 2] / self.flow.scales[:, np.newaxis]

    def ends(self, states: Values) -> Labels:
        """Return the numbers of the attractors to which states, shape (n, m), lead."""
        return ends_of(Attractors(self.flow, self.rows), self.flow, states.T)

    def holds(self, number: int, state: Values) -> bool:
        """Return whether a state leads to an attractor with a tighter tolerance."""
        closely = self.flow.but(rtol=tighter_than(self.knocked.rtol))
        ends = ends_of(Attractors(self.flow, self.rows), closely, state[np.newaxis])
        return bool(ends[0] == number)

    def kept(self, state: Values) -> Values:
        """Return a state as a result has it."""
        return self.flow.in_q(state)


Search = DiscSearch | SystemSearch


def resilience_of(search: Search) -> tuple[list[Resilience], list[Fill]]:
    """Return how far each attractor of a rotor is from being left, in their order.

    Nothing is known of it until the independent jobs are done that are returned too: for each
    attractor its extents, and its shocks.
    """
    found: dict[int, Resilience] = {}
    fills: list[Fill] = []
    size = search.rows["final_state"].shape[-1]
    for number, label in enumerate(search.labels):  # fading touches may be of another's family
        if label not in found:
            parameters = varied(search.known.rotor) if isinstance(search, DiscSearch) else ()
            found[label] = Resilience.unknown(len(search.rows), size, len(parameters))
            if isinstance(search, DiscSearch):
                extents = partial(_fill_extents, found[label], search, number)
                fills.append(Fill(extents, 0, []))
            followed: list[int] = []
            shocks = partial(_fill_shocks, found[label], search, number, followed)
            fills.append(Fill(shocks, len(KINDS) * search.shocks, followed))
    return [found[label] for label in search.labels], fills


def _fill_extents(resilience: Resilience, search: DiscSearch, number: int, stop: Stop) -> None:
    """Fill in the ranges of the parameters in which an attractor exists."""
    search = search.at(stop)
    for row, name in enumerate(varied(search.known.rotor)):
        for column, end in enumerate(search.extent(number, name)):
            resilience.extents[row, column] = end.value
            resilience.ends[row, column] = END[end.kind]


def _fill_shocks(
    resilience: Resilience, search: Search, number: int, followed: list[int], stop: Stop
) -> None:
    """Fill in the smallest shocks from an attractor to each other, and their bounds."""
    search = search.at(stop)
    own, source = search.labels[number], search.source(number)
    if source is None:
        return

    def ends(states: Values) -> Labels:
        labels = []
        for first in range(0, states.shape[1], search.at_a_time):
            labels.append(search.ends(states[:, first : first + search.at_a_time]))
            followed.append(labels[-1].size)
        return np.concatenate(labels)

    for row, (kind, largest) in enumerate(zip(KINDS, search.largest(), strict=True)):
        bound = search.bound(number, kind) if isinstance(search, DiscSearch) else 0.0
        sizes = max(bound, SMALLEST * largest), largest
        blows = Blows(source, search.changes(kind), ends)
        tried, scatter = try_shocks(
            blows, own, sizes, search.shocks, seed=row, effort=search.effort
        )
        for target, label in enumerate(search.labels):
            is_other = label not in (own, UNDECIDED)
            if is_other and _keep_smallest(resilience, search, tried, (row, target)):
                resilience.scatter[row, target] = scatter[label]
        if isinstance(search, DiscSearch):
            thrown = float(tried.sizes[tried.labels != own].min(initial=largest))
            estimate = search.estimate(number, kind, source, thrown)
            resilience.bounds[row] = max(bound, estimate)


def _keep_smallest(
    resilience: Resilience, search: Search, tried: Shocks, place: tuple[int, int]
) -> bool:
    """Keep the smallest shock to an attractor that is confirmed; return whether there is one."""
    for number in tried.smallest(search.labels[place[1]], LARGER):
        if search.holds(place[1], tried.after[:, number]):
            resilience.sizes[place] = tried.sizes[number]
            resilience.before[place] = search.kept(tried.before[:, number])
            resilience.after[place] = search.kept(tried.after[:, number])
            return True
    return False


def search_of(labeller: Labeller, rows: Table, shocks: int, stop: Stop) -> Search:
    """Return the search for shocks among the attractors of a rotor whose starts were labelled."""
    if isinstance(labeller, Disc):
        return DiscSearch.of(labeller, rows, shocks, stop)
    assert isinstance(labeller, KnockedSystem)
    return SystemSearch(labeller, rows, shocks, labeller.flow(stop))


def _spread_over(states: Values) -> Source:
    """Return a source of these states, shape (m, n), by the first coordinate of a place."""
    count = states.shape[1]
    return lambda places: states[:, np.floor(places[0] * count).astype(np.int64) % count]


def _contact_free_states(free: ContactFree, omega: float, places: Values) -> Values:
    """Return whirls about any centre at which they fit, half of them about the farthest."""
    room = 0.0 if free.alone else free.room
    distance = room * np.sqrt(np.clip(2.0 * np.abs(places[1]), 0.0, 1.0))
    angle = 2.0 * math.pi * places[0]
    velocity = 1j * omega * free.whirl
    return np.stack([
        free.whirl.real + distance * np.cos(angle),
        free.whirl.imag + distance * np.sin(angle),
        np.full(angle.size, velocity.real),
        np.full(angle.size, velocity.imag),
    ])  # fmt: skip
