"""Resilience: how far each attractor of a rotor is from being left, by a shock or by drift.

For each attractor: the smallest shock found to each other one, confirmed by CVODE; the size up to
which no shock leaves it, proven or estimated; and the extents of its parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

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
from rotor_ida.basins.atlas.rubbing import states_of_rub
from rotor_ida.basins.atlas.shocks import (
    CHANGES,
    KINDS,
    Blows,
    Shocks,
    Source,
    bound_of_cycle,
    bound_of_held_whirl,
    bound_of_whirl,
    ends_of,
    try_shocks,
)
from rotor_ida.basins.attractors import CONTACT_FREE_FAMILY, Attractor, leads_to
from rotor_ida.basins.cycle_sections import CycleSection
from rotor_ida.basins.kernel import CHAOTIC, UNDECIDED
from rotor_ida.basins.known import ContactFree, Known, may_roll
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.errors import SimulationError
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import END
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.options import Options
from rotor_ida.steady import response

Flags = npt.NDArray[np.int8]
# A job that fills in a part of what is known of an attractor.
Fill = Callable[[Stop], None]

# Shocks are tried up to this multiple of the largest attractor or the clearance; shocks of
# velocity up to the speed of a whirl of that size.
LARGEST = 4.0
# The search begins with sizes down to this fraction of that.
SMALLEST = 1e-4
# CVODE follows the smallest shock to its attractor. If that is another one, it tries shocks larger
# by these fractions: a basin boundary is known to an error, and may be finely folded.
LARGER = (0.0, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0)
# Number of states of a limit cycle at which it is shocked; and of chaos, a unit of time apart.
SAMPLES = 1024
# States of chaos are taken after this number of time units, a transient.
CHAOS_BEGINS = 2000
# Chaos that is left before this number of them is not shocked.
FEWEST = 128
_NONE = np.empty((4, 0))


@dataclass(frozen=True, slots=True)
class Subject:
    """An attractor as the search for shocks needs it."""

    attractor: Attractor
    label: int  # as in `rotor_ida.basins.kernel`
    cycle: Orbit | None  # where it is one
    start: Values  # one that ends on it, shape (4,) [1]; NaN where there is none

    @property
    def is_whirl(self) -> bool:
        """Whether it is a whirl in contact."""
        return self.attractor.kind == response.SYNCHRONOUS


@dataclass(slots=True)
class Resilience:
    """How far an attractor is from being left; shocks of velocity first, then of displacement."""

    # the smallest shock to each of m attractors that CVODE confirms, or NaN: (2, m) [1]
    sizes: Values
    before: Values  # states on the rotating axes just before it, shape (2, m, 4) [1]
    after: Values  # and just after
    # relative excess of the best over the smallest that another draw led to, before confirmation
    # by CVODE, shape (2, m) [1]
    scatter: Values
    # the lowest and the highest value of each parameter at which the attractor exists [1],
    extents: Values
    # and how it ends there: numbers of `rotor_ida.schema.END`
    ends: Flags
    # the size below which no shock leaves it, proven for whirls, estimated for cycles [1]
    bounds: Values = field(default_factory=lambda: np.zeros(2))

    @classmethod
    def unknown(cls, attractors: int, rotor: Rotor) -> Resilience:
        """Return the resilience of an attractor about which nothing is known."""
        over = len(varied(rotor)), 2
        return cls(
            np.full((2, attractors), np.nan), np.full((2, attractors, 4), np.nan),
            np.full((2, attractors, 4), np.nan), np.full((2, attractors), np.nan),
            np.full(over, np.nan), np.full(over, END["not_found"], dtype=np.int8),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Search:
    """A rotor with all that the search for shocks needs."""

    known: Known
    subjects: list[Subject]  # its attractors, in their order
    shocks: int  # number of each kind tried for each attractor
    tolerance: float  # of a step [1]
    stop: Stop

    def largest(self) -> tuple[float, float]:
        """Return the largest change of velocity and of position that is tried [1]."""
        rotor = self.known.rotor
        radii = [each.attractor.radius_max for each in self.subjects]
        size = LARGEST * max([1.0, rotor.delta0, *(one for one in radii if one > 0.0)])
        return size * max(1.0, rotor.omega), size

    def ends(self, states: Values) -> npt.NDArray[np.int16]:
        """Return the labels of states, shape (4, n).

        If there is chaos, states that enter no region in time count as chaotic, until CVODE checks.
        """
        labels = ends_of(self.known, states, self.tolerance, self.stop)
        if any(each.label == CHAOTIC for each in self.subjects):
            labels[labels == UNDECIDED] = CHAOTIC
        return labels


def witness_options() -> Options:
    """Return the options with which the smallest shocks are confirmed."""
    return Options()


def resilience_of(search: Search) -> tuple[list[Resilience], list[Fill]]:
    """Return how far each attractor of a rotor is from being left, in their order.

    Nothing is known of it until the independent jobs are done that are returned too: for each
    attractor its extents, and its shocks.
    """
    resilience: dict[int, Resilience] = {}
    fills: list[Fill] = []
    for subject in search.subjects:  # fading touches belong to the contact-free family
        if subject.label not in resilience:
            unknown = Resilience.unknown(len(search.subjects), search.known.rotor)
            resilience[subject.label] = unknown
            fills.append(partial(_fill_extents, unknown, search.known.rotor, subject))
            fills.append(partial(_fill_shocks, unknown, search, subject))
    return [resilience[subject.label] for subject in search.subjects], fills


def _fill_shocks(resilience: Resilience, search: Search, subject: Subject, stop: Stop) -> None:
    """Fill in the smallest shocks from an attractor to each other, and their bounds."""
    known, search = search.known, replace(search, stop=stop)
    source = _source_of(search, subject) if known.rotor.omega > 0.0 else None
    if source is None:
        return
    for row, (kind, largest) in enumerate(zip(KINDS, search.largest(), strict=True)):
        bound = _proven_bound(known, subject, kind)
        sizes = max(bound, SMALLEST * largest), largest
        blows = Blows(source, CHANGES[kind], search.ends)
        tried, scatter = try_shocks(blows, subject.label, sizes, search.shocks, seed=row)
        for place, target in enumerate(search.subjects):
            if target.label not in (subject.label, UNDECIDED):
                _keep_smallest(search, resilience, (row, place), tried)
                if math.isfinite(resilience.sizes[row, place]):
                    resilience.scatter[row, place] = scatter[target.label]
        section = _section_of(known, subject)
        if section is not None:
            thrown = tried.sizes[tried.labels != subject.label]
            most = float(thrown.min(initial=largest))
            bound = bound_of_cycle(section, source, kind, most, search.stop)
        resilience.bounds[row] = bound


def _proven_bound(known: Known, subject: Subject, kind: str) -> float:
    """Return the size up to which no shock leaves a whirl; 0 if none is known."""
    if subject.is_whirl:
        return bound_of_whirl(known.whirls[subject.label], kind)
    if subject.label == known.free_label and known.free is not None and known.free.alone:
        return bound_of_held_whirl(known.rotor, known.free.room, kind)
    return 0.0


def _keep_smallest(
    search: Search, resilience: Resilience, place: tuple[int, int], tried: Shocks
) -> None:
    """Keep the smallest shock to an attractor that CVODE follows there."""
    target, options = search.subjects[place[1]], witness_options()
    for number in tried.smallest(target.label, LARGER):
        if search.stop[0]:
            return
        after = tried.after[:, number]
        if leads_to(
            search.known.rotor, target.attractor, after, options, family=True, stop=search.stop
        ):
            resilience.sizes[place] = tried.sizes[number]
            resilience.before[place], resilience.after[place] = tried.before[:, number], after
            return


def _section_of(known: Known, subject: Subject) -> CycleSection | None:
    """Return the section of a limit cycle."""
    place = subject.label - known.first_cycle
    return known.cycles[place] if 0 <= place < len(known.cycles) else None


def _source_of(search: Search, subject: Subject) -> Source | None:
    """Return a source of states of an attractor, or None if they are not known."""
    if subject.attractor.kind in CONTACT_FREE_FAMILY:
        free, omega = search.known.free, search.known.rotor.omega
        return None if free is None else partial(_contact_free_states, free, omega)
    try:
        states = _states_of(search, subject)
    except SimulationError:
        return None
    count = states.shape[1]
    if not count:
        return None
    return lambda places: states[:, np.floor(places[0] * count).astype(np.int64) % count]


def _states_of(search: Search, subject: Subject) -> Values:
    """Return states of an attractor other than the contact-free ones, shape (4, n)."""
    known, stop = search.known, search.stop
    if subject.is_whirl:
        return known.whirls[subject.label].centre[:, None]
    if subject.cycle is not None:
        cycle = subject.cycle
        times = np.linspace(0.0, cycle.duration, SAMPLES, endpoint=False)
        return DiscFlow(known.rotor, stop).states(cycle.start, times).T
    if may_roll(known.rotor):
        start = subject.start
        return states_of_rub(known.rotor, start, SAMPLES) if np.isfinite(start).all() else _NONE
    # chaos, while it lasts: a motion that leaves by itself needs no shock
    times = np.linspace(0.0, CHAOS_BEGINS + SAMPLES - 1.0, CHAOS_BEGINS + SAMPLES)
    states = DiscFlow(known.rotor, stop).states(subject.start, times)[-SAMPLES:].T
    left = np.flatnonzero(ends_of(known, states, search.tolerance, stop) != UNDECIDED)
    lasting = int(left[0]) if left.size else SAMPLES
    return states[:, : lasting if lasting >= FEWEST else 0]


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


def _fill_extents(resilience: Resilience, rotor: Rotor, subject: Subject, stop: Stop) -> None:
    """Fill in the ranges of the parameters in which an attractor exists."""
    for row, name in enumerate(varied(rotor)):
        for column, end in enumerate(_extent(rotor, subject, name, stop)):
            resilience.extents[row, column] = end.value
            resilience.ends[row, column] = END[end.kind]


def _extent(rotor: Rotor, subject: Subject, name: str, stop: Stop) -> tuple[End, End]:
    attractor = subject.attractor
    if rotor.omega == 0.0 or attractor.kind == response.CHAOTIC:
        return UNKNOWN, UNKNOWN
    if attractor.kind in CONTACT_FREE_FAMILY:
        return extent_of_contact_free(rotor, name)
    if attractor.kind == response.SYNCHRONOUS:
        return extent_of_whirl(rotor, attractor.amplitude, name)
    if subject.cycle is None:
        return UNKNOWN, UNKNOWN
    return extent_of_cycle(rotor, subject.cycle.start, subject.cycle.duration, name, stop)
