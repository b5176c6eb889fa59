"""Classify a batch of starts: follow all of them until the attractor of each is decided.

*Match* all orbits against the trapping regions. *Seed* a limit cycle where a remaining orbit
returns to itself: Newton's method finds the cycle, which is then known and has a region. *Label* an
orbit that does not return by following it alone to its attractor, as in a sweep. After each step,
match the others again. If that orbit does not settle, all that last as long are examined one by
one: chaos is identified by the exponent of each orbit; the others are followed further.

The label of a start depends on the rotor and on the start alone. The rest of the batch, and what is
known already, only affects when the label is found and at what cost.

Under a load, which rotates on these axes, all cycles are of whole revolutions, and an orbit is
matched at the ends of these. There, and with friction, starts that enter no region or do not slide
forwards throughout are followed separately. If one reaches a limit cycle on which the disc slides
forwards, this cycle can trap others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ROUNDING, Stop, Values
from rotor_ida.basins.attractors import Indices
from rotor_ida.basins.kernel import (
    CHAOTIC,
    NOT_COMPUTED,
    NOT_FORWARDS,
    QUASI_PERIODIC,
    ROLLING,
    UNDECIDED,
    Labels,
    Times,
)
from rotor_ida.basins.known import Known, may_remain, with_cycle
from rotor_ida.cycles.limit_cycle import returns
from rotor_ida.cycles.multipliers import doubling_test, is_stable
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.cycles.shooting import close_orbit, once_round
from rotor_ida.errors import SimulationError
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.options import Options
from rotor_ida.steady import response
from rotor_ida.steady.decision import CLEAR_ERRORS, CLEAR_STRETCH
from rotor_ida.steady.follow import LATE, PATIENCE, Features, Settled, longest_time, settle_disc

# A remaining fraction no larger than this is followed for longer before one orbit is examined: it
# may only be slow.
FEW = 0.05
# Orbits that need longer are followed side by side until this time, then one by one.
LONGEST_TOGETHER = 4000.0

# A limit cycle is sought where an orbit returns within this number of revolutions: one at omega 1.7
# and delta0 2 takes 17.4.
RETURN_REVOLUTIONS = 20.0
# And within this time: revolutions of a slow rotor are long.
RETURN_TIME = 500.0
# Number of closest returns tried, as the closest may be to another part of the cycle.
MOST_RETURNS = 6
# Returns closer in time than this fraction count as one.
ONE_RETURN = 2e-3
# Largest distance of a return, and of the cycle from the orbit, relative to the size of the state.
BESIDE = 0.1
# An orbit with an indentation below this fraction of the clearance may be a whirl of the
# contact-free family, which is no limit cycle.
SLIGHT = 1e-3

# Relative tolerance for a doubled period: exact where the cycles branch off, then drifting.
TWICE = 0.2

# How an orbit is followed alone: as in a sweep.
ALONE = Options(method="taylor", rtol=1e-10)
# Relative tolerance for identifying a settled whirl with a known one by amplitude.
SAME_AMPLITUDE = 1e-5
# The exponent of an orbit is measured with a neighbour at this relative distance,
NEIGHBOUR = 1e-7
# reset after each span, short enough even for strong chaos, and evaluated after this number of
# spans,
SPAN, SPANS = 120.0, 20
# without the first ones, in which it aligns with the fastest-growing direction.
FIRST_SPANS = 10
# Not chaotic if it does not exceed this number of standard errors after some spans; if it does but
# is not clearly above 0, it is followed further, up to a total number of spans.
MAYBE_ERRORS, SOME_SPANS, MOST_SPANS = 2.0, 60, 200
# Tolerance for both: step errors must not be taken for growth.
CLOSELY = 1e-11
# Labels of motions that have no period and are distinguished by kind alone.
APERIODIC = {
    response.ROLLING: ROLLING,
    response.QUASI_PERIODIC: QUASI_PERIODIC,
    response.CHAOTIC: CHAOTIC,
}
# Relative displacements at which a doubled cycle is sought near an unstable one whose period has
# just doubled.
ASIDE = (1e-3, 3e-3, 1e-2, 3e-2, 1e-1)


@dataclass(slots=True)
class Batch:
    """A batch of n starts being followed, with what is decided about each."""

    known: Known  # the rotor and its attractors; those that are found are added
    states: Values  # on the rotating axes, shape (4, n): of a copy, overwritten as they move [1]
    tolerance: float  # of a step [1]
    stop: Stop
    labels: Labels = field(init=False)
    times: Times = field(init=False)  # for how long each was followed [1]
    left: int = 0  # number of observed orbits that left a chaotic motion
    watched: float = 0.0  # total time for which chaotic orbits were observed [1]
    # the first motion without a period of each kind, by its label
    aperiodic: dict[int, Settled[Features]] = field(default_factory=dict)
    matched: Known | None = None  # what was known when orbits were last followed together

    def __post_init__(self) -> None:
        self.states = np.array(self.states, order="C")
        self.labels = np.full(self.states.shape[1], NOT_COMPUTED, dtype=np.int16)
        self.times = np.zeros(self.labels.size, dtype=np.float32)

    @property
    def cycle_found(self) -> bool:
        """Whether a limit cycle has been found since orbits were last followed together."""
        return self.known is not self.matched

    def passed(self, numbers: Indices) -> float:
        """Return the longest time for which any of the orbits was followed [dimensionless]."""
        return float(self.times[numbers].max(initial=0.0))

    def follow(self, numbers: Indices, duration: float) -> Indices:
        """Follow orbits until they enter a region, or for a time; return the remaining ones."""
        if not numbers.size or duration <= 0.0:
            return numbers
        self.matched = self.known
        states = np.ascontiguousarray(self.states[:, numbers])
        labels, times = self.known.follow(states, duration, self.tolerance, self.stop)
        self.states[:, numbers] = states
        self.labels[numbers] = labels
        self.times[numbers] += times
        left: Indices = numbers[labels == UNDECIDED]
        return left

    def settled(
        self, number: int, options: Options, longest: float | None = None
    ) -> Settled[Features] | None:
        """Return what an orbit settles on, followed alone as in a sweep; None if that fails."""
        rotor, state = self.known.rotor, self.states[:, number]
        try:
            return settle_disc(rotor, state, options, longest=longest, stop=self.stop)
        except SimulationError:
            return None

    def label_of(self, cycle: Orbit) -> int:
        """Return the label of a limit cycle, adding it to the known ones."""
        label = self.known.label_of_cycle(cycle)
        if label is None:
            label = self.known.first_cycle + len(self.known.cycles)
            self.known = with_cycle(self.known, cycle, self.stop)
        return label


def decide(batch: Batch) -> Batch:
    """Follow all starts of a batch until the attractor of each is decided; return the batch."""
    rotor, every = batch.known.rotor, np.arange(batch.labels.size)
    waiting = every[:0]
    if batch.known.is_followed_alone:
        label_one_by_one(batch, every, Options(method="taylor", rtol=batch.tolerance))
    elif may_remain(rotor):
        label_remaining(batch)
    else:
        waiting = match_all(batch)
    while waiting.size and not batch.stop[0]:
        if seed(batch, waiting):
            waiting = match(batch, waiting, longest_time(rotor))
        else:
            waiting = label(batch, waiting)
    if batch.stop[0]:
        batch.labels[batch.labels == UNDECIDED] = NOT_COMPUTED
    return batch


def label_remaining(batch: Batch) -> None:
    """Label starts with friction or under a load.

    Those that enter no region are followed separately, from their beginning.

    As long as further orbits enter regions, the others may only be slow.
    """
    starts, every = batch.states.copy(), np.arange(batch.labels.size)
    waiting, before = batch.follow(every, batch.known.first_wait), every.size
    while 0 < waiting.size < before and not batch.stop[0]:
        before = waiting.size
        waiting = match(batch, waiting, min(LONGEST_TOGETHER, _late(batch)))
    while waiting.size and not batch.stop[0]:
        _label_from(batch, starts, waiting[:1])
        waiting = waiting[1:]
        if batch.cycle_found:
            waiting = batch.follow(waiting, batch.known.first_wait)
    _label_from(batch, starts, np.concatenate([waiting, every[batch.labels == NOT_FORWARDS]]))


def _label_from(batch: Batch, starts: Values, numbers: Indices) -> None:
    """Label some starts by following each separately from its beginning to its attractor."""
    batch.labels[numbers], batch.times[numbers] = NOT_COMPUTED, 0.0
    batch.states[:, numbers] = starts[:, numbers]
    label_one_by_one(batch, numbers, ALONE)


def label_one_by_one(batch: Batch, numbers: Indices, options: Options) -> None:
    """Label some starts by following each separately to its attractor, as in a sweep."""
    for number in numbers.tolist():
        if batch.stop[0]:
            return
        settled = batch.settled(number, options)
        batch.labels[number] = _label_of(batch, settled)
        batch.times[number] = np.nan if settled is None else settled.motion.time


def match_all(batch: Batch) -> Indices:
    """Follow all orbits until they enter a region, the last few longer; return the remaining."""
    count, longest = batch.labels.size, min(LONGEST_TOGETHER, _late(batch))
    waiting = batch.follow(np.arange(count), batch.known.first_wait)
    if batch.known.rotor.omega == 0.0:  # energy only falls: all comes to rest
        batch.labels[waiting] = 0
        return waiting[:0]
    while 0 < waiting.size <= FEW * count and batch.passed(waiting) < longest and not batch.stop[0]:
        waiting = match(batch, waiting, longest)
    return waiting


def match(batch: Batch, waiting: Indices, longest: float, until: float = 0.0) -> Indices:
    """Follow orbits further until they enter a region; return the remaining ones.

    If a cycle has been found since, they are followed for the time in which damping settles most.
    Otherwise the time followed is doubled, and is at least `until`, up to the longest time.
    """
    if batch.cycle_found:
        return batch.follow(waiting, batch.known.first_wait)
    passed = batch.passed(waiting)
    return batch.follow(waiting, max(2.0 * passed, until) - passed) if passed < longest else waiting


def seed(batch: Batch, waiting: Indices) -> bool:
    """Return whether the first orbit is near a stable limit cycle that may still trap it."""
    in_time = batch.passed(waiting) < longest_time(batch.known.rotor)
    return beside_cycle(batch, int(waiting[0])) and (batch.cycle_found or in_time)


def label(batch: Batch, waiting: Indices) -> Indices:
    """Label the first orbit by following it alone; return the others that then remain.

    If it does not settle, all that last as long are labelled one by one.
    """
    first, others = int(waiting[0]), waiting[1:]
    fate = fate_of(batch, first)
    if fate in (CHAOTIC, UNDECIDED):
        label_lasting(batch, waiting)
        return waiting[:0]
    batch.labels[first] = fate
    # touches take long to fade, and to follow one by one: others may do so together
    took = float(batch.times[first]) if fate == batch.known.fading_label else 0.0
    return match(batch, others, LONGEST_TOGETHER, until=min(took, LONGEST_TOGETHER))


def beside_cycle(batch: Batch, number: int) -> bool:
    """Return whether an orbit is near a stable limit cycle, and add that to the known ones."""
    rotor, state = batch.known.rotor, batch.states[:, number].copy()
    duration = min(RETURN_REVOLUTIONS * 2.0 * math.pi / rotor.omega, RETURN_TIME)
    try:
        times, misses = returns(DiscFlow(rotor, batch.stop), state, duration, 2.0 * BESIDE)
    except SimulationError:
        return False
    near = BESIDE * float(np.linalg.norm(state))
    for time in _closest(times[misses <= near], misses[misses <= near], ONE_RETURN * duration):
        cycle = _stable_cycle(batch, state, time)
        if (
            cycle is not None
            and cycle.radius_max - rotor.delta0 > SLIGHT * rotor.delta0
            and float(np.linalg.norm(cycle.start - state)) <= near
        ):
            batch.label_of(cycle)
            return True
    return False


def _closest(times: Values, misses: Values, apart: float) -> list[float]:
    """Return the times of the closest separate returns, in order of time."""
    chosen: list[float] = []
    for place in np.argsort(misses, kind="stable").tolist():
        time = float(times[place])
        if len(chosen) < MOST_RETURNS and all(abs(time - other) > apart for other in chosen):
            chosen.append(time)
    return sorted(chosen)


def _stable_cycle(batch: Batch, state: Values, period: float) -> Orbit | None:
    """Return the stable limit cycle near a state and a period, followed once round."""
    rotor, stop = batch.known.rotor, batch.stop
    try:
        cycle = once_round(close_orbit(DiscFlow(rotor, stop), state, period))
    except SimulationError:
        return None
    if is_stable(cycle):
        return cycle
    return _doubled(cycle, stop) if doubling_test(cycle) < 0.0 else None


def _doubled(cycle: Orbit, stop: Stop) -> Orbit | None:
    """Return the stable cycle of twice the period near one whose period has just doubled."""
    multipliers, vectors = np.linalg.eig(cycle.monodromy)
    aside = np.real(vectors[:, np.argmin(multipliers.real)])
    aside *= np.linalg.norm(cycle.start) / np.linalg.norm(aside)
    for part in ASIDE:
        try:
            twice = cycle.start + part * aside, 2.0 * cycle.duration
            found = once_round(close_orbit(DiscFlow(cycle.rotor, stop), *twice))
        except SimulationError:
            continue
        if is_stable(found) and abs(found.duration / cycle.duration - 2.0) < TWICE:
            return found
    return None


def fate_of(batch: Batch, number: int, longest: float | None = None) -> int:
    """Return the label of one orbit, followed alone to its attractor; add a new limit cycle.

    UNDECIDED if it reaches none within the time limit of a sweep; otherwise the time that it took
    is added.
    """
    settled = batch.settled(number, ALONE, longest)
    fate = _label_of(batch, settled)
    if settled is not None and fate not in (CHAOTIC, UNDECIDED):
        batch.times[number] += np.float32(settled.motion.time)
    return fate


def _label_of(batch: Batch, settled: Settled[Features] | None) -> int:
    if settled is None:
        return UNDECIDED
    known, period = batch.known, settled.features.period
    if period > 0.0:
        cycle = _stable_cycle(batch, settled.motion.state, period)
        return UNDECIDED if cycle is None else batch.label_of(cycle)
    if settled.kind == response.SYNCHRONOUS:
        return _whirl_of(known, settled.features.radius_max)  # of a rotor at rest its sag
    label = APERIODIC.get(settled.kind, UNDECIDED)
    if label != UNDECIDED:
        batch.aperiodic.setdefault(label, settled)
    elif known.free is not None:
        free = {response.CONTACT_FREE: known.free_label, response.TOUCHING: known.fading_label}
        label = free.get(settled.kind, UNDECIDED)
    return label


def _whirl_of(known: Known, amplitude: float) -> int:
    """Return the label of the whirl with an amplitude."""
    apart = [abs(each.amplitude / amplitude - 1.0) for each in known.whirls]
    nearest = min(range(len(apart)), key=apart.__getitem__, default=UNDECIDED)
    return nearest if apart and apart[nearest] <= SAME_AMPLITUDE else UNDECIDED


def label_lasting(batch: Batch, waiting: Indices) -> None:
    """Label orbits that have not settled after a long time, each by its own motion.

    The chaotic ones are observed for as long again, and those that leave are counted. The others
    are followed for as long as a sweep follows a motion, and then one by one.
    """
    late = _late(batch)
    waiting = batch.follow(waiting, late - batch.passed(waiting))
    chaotic = are_chaotic(batch, waiting)
    before, watched = float(batch.times[waiting[chaotic]].sum()), waiting[chaotic]
    last = batch.follow(watched, late)
    batch.left += watched.size - last.size
    batch.watched += float(batch.times[watched].sum()) - before
    if last.size and CHAOTIC not in batch.aperiodic:
        settled = batch.settled(int(last[0]), ALONE, 0.0)
        if settled is not None:
            batch.aperiodic[CHAOTIC] = settled
    if CHAOTIC in batch.aperiodic:
        batch.labels[last] = CHAOTIC
    rest = waiting[~chaotic]
    longest = longest_time(batch.known.rotor)
    least = float(batch.times[rest].min(initial=longest))
    for number in batch.follow(rest, longest - least).tolist():
        if batch.stop[0]:
            return
        batch.labels[number] = fate_of(batch, number, longest=batch.known.first_wait)


def are_chaotic(batch: Batch, numbers: Indices) -> npt.NDArray[np.bool_]:
    """Follow orbits further; return which of them diverge from a neighbour at a rate above 0.

    Undecided ones are followed for longer.
    """
    states = np.ascontiguousarray(batch.states[:, numbers])
    beside = states.copy()
    beside[0] += NEIGHBOUR * np.linalg.norm(states, axis=0)
    clear, unclear = np.zeros(numbers.size, dtype=np.bool_), np.arange(numbers.size)
    rates = np.empty((0, numbers.size))
    while unclear.size and len(rates) < MOST_SPANS and not batch.stop[0]:
        states, beside, more = _parting(batch, states, beside, SPANS)
        batch.states[:, numbers[unclear]] = states
        batch.times[numbers[unclear]] += np.float32(SPANS * SPAN)
        rates = np.concatenate([rates, more])
        settled = rates[FIRST_SPANS:]
        mean = settled.mean(axis=0)
        error = settled.std(axis=0, ddof=1) / math.sqrt(len(settled))
        sure = (mean > CLEAR_ERRORS * error) & (mean * SPAN * len(settled) > CLEAR_STRETCH)
        clear[unclear[sure]] = True
        kept = ~sure & ((mean > MAYBE_ERRORS * error) | (len(rates) < SOME_SPANS))
        unclear, rates = unclear[kept], rates[:, kept]
        states, beside = (np.ascontiguousarray(each[:, kept]) for each in (states, beside))
    return clear


def _parting(
    batch: Batch, states: Values, beside: Values, spans: int
) -> tuple[Values, Values, Values]:
    """Follow orbits and their neighbours; return both at the end, and their rates of divergence.

    The rates have one row for each span.
    """
    bare, rates = Known(batch.known.rotor, [], None), np.zeros((spans, states.shape[1]))
    for span in range(spans):
        for each in (states, beside):
            bare.follow(each, SPAN, CLOSELY, batch.stop)
        size = np.linalg.norm(states, axis=0)
        distance = np.maximum(np.linalg.norm(beside - states, axis=0), ROUNDING * size)
        stretch = distance / (NEIGHBOUR * size)
        rates[span] = np.log(stretch) / SPAN
        beside = np.ascontiguousarray(states + (beside - states) / stretch)
    return states, beside, rates


def _late(batch: Batch) -> float:
    """Return the time after which a motion that has not settled may be chaos [dimensionless]."""
    rotor = batch.known.rotor
    return max(LATE, PATIENCE / rotor.zeta) if rotor.zeta > 0.0 else longest_time(rotor)
