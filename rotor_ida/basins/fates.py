"""What becomes of a batch of starts: all are followed until that is decided.

*Match* all against the regions that hold starts. *Seed* a limit cycle where one that is left over
comes back to where it is: Newton's method finds it, it is known then, with a region of its own.
*Label* one that does not come back by following it alone to its attractor, as in a sweep. After
each, match the others again. Chaos is told by the largest exponent of some orbits; those that last
as long are taken to be on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.basins.kernel import CHAOTIC, NOT_COMPUTED, UNDECIDED, Labels, Times
from rotor_ida.basins.known import Known, with_cycle
from rotor_ida.cycles.limit_cycle import returns
from rotor_ida.cycles.multipliers import is_stable
from rotor_ida.cycles.shooting import Cycle, close_orbit, once_round
from rotor_ida.errors import SimulationError
from rotor_ida.parallel import Stop
from rotor_ida.simulation.options import Options
from rotor_ida.steady_state import response
from rotor_ida.steady_state.follow import (
    LATE,
    PATIENCE,
    SettledResponse,
    follow_to_steady_state,
)

Numbers = npt.NDArray[np.int64]

# Where no more than this part is left over, it is followed for longer before one is looked at: it
# may only be slow.
FEW = 0.05
# Orbits that need longer are followed side by side until this time, then one by one.
LONGEST_TOGETHER = 4000.0
# Beside a cycle that attracts them slowly they are, for as long as a sweep follows a motion.
LONGEST_BESIDE_CYCLE = 40_000.0
# Where so many in turn do not settle, the others that are left are taken not to either.
MOST_UNDECIDED = 3

# A limit cycle is sought where an orbit comes back within so many revolutions: where omega is 1.7
# and delta0 2, one takes 17.4.
RETURN_REVOLUTIONS = 20.0
# And within so long: revolutions of a slow rotor take time.
RETURN_TIME = 500.0
# It is sought at so many of the closest returns, for the closest may be to a part of the cycle.
MOST_RETURNS = 6
# Returns are one where they come within this part of the time of each other.
ONE_RETURN = 2e-3
# The cycle is beside the orbit, and a return is one, up to this part of the size of the state.
BESIDE = 0.1
# An orbit that reaches into the ring by less than this part of the clearance may be a whirl of the
# contact-free family, which is no limit cycle.
SLIGHT = 1e-3

# How an orbit is followed alone: as in a sweep.
ALONE = Options(method="taylor", rtol=1e-10)
# A whirl on which an orbit has settled has the amplitude of a known one, to this part of it.
SAME_AMPLITUDE = 1e-5
# Of orbits that last as long as chaos, so many are followed alone before the others count as it.
CHECKED = 2


@dataclass(slots=True)
class Batch:
    """Starts under way, n of them, with what is decided of each."""

    known: Known  # the rotor and its attractors; those that are found are added
    states: Values  # on the rotating axes, shape (4, n): of a copy, overwritten as they move [1]
    tolerance: float  # of a step [1]
    stop: Stop
    labels: Labels = field(init=False)
    times: Times = field(init=False)  # for how long each was followed [1]
    left: int = 0  # number of orbits that left a chaotic motion while this was watched,
    watched: float = 0.0  # and for how long all of them together were watched [1]
    chaotic: SettledResponse | None = None  # a chaotic motion, if one was met
    undecided_in_turn: int = 0  # number of the last orbits followed alone that have not settled
    matched: Known | None = None  # what was known when orbits were last followed together

    def __post_init__(self) -> None:
        self.states = np.array(self.states, order="C")
        self.labels = np.full(self.states.shape[1], NOT_COMPUTED, dtype=np.int16)
        self.times = np.zeros(self.labels.size, dtype=np.float32)

    @property
    def cycle_found(self) -> bool:
        """Whether a limit cycle has been found since orbits were last followed together."""
        return self.known is not self.matched

    def passed(self, numbers: Numbers) -> float:
        """Return for how long at most orbits were followed [1]."""
        return float(self.times[numbers].max(initial=0.0))

    def follow(self, numbers: Numbers, duration: float) -> Numbers:
        """Follow some orbits until a region holds them, or for a time; return those left over."""
        if not numbers.size or duration <= 0.0:
            return numbers
        self.matched = self.known
        states = np.ascontiguousarray(self.states[:, numbers])
        labels, times = self.known.follow(states, duration, self.tolerance, self.stop)
        self.states[:, numbers] = states
        self.labels[numbers] = labels
        self.times[numbers] += times
        left: Numbers = numbers[labels == UNDECIDED]
        return left

    def label_of(self, cycle: Cycle) -> int:
        """Return the label of a limit cycle, which is known from now on."""
        label = self.known.label_of_cycle(cycle)
        if label is None:
            label = self.known.first_cycle + len(self.known.cycles)
            self.known = with_cycle(self.known, cycle, self.stop)
        return label


def decide(batch: Batch) -> Batch:
    """Follow all starts of a batch until what becomes of them is decided; return it."""
    waiting = match_all(batch)
    while waiting.size and batch.undecided_in_turn < MOST_UNDECIDED and not batch.stop[0]:
        if seed(batch, waiting):
            waiting = match(batch, waiting, LONGEST_BESIDE_CYCLE)
        else:
            waiting = label(batch, waiting)
    if batch.stop[0]:
        batch.labels[batch.labels == UNDECIDED] = NOT_COMPUTED
    return batch


def match_all(batch: Batch) -> Numbers:
    """Follow all orbits until a region holds them, the last few for longer; return those left."""
    count = batch.labels.size
    waiting = batch.follow(np.arange(count), batch.known.first_wait)
    if batch.known.rotor.omega == 0.0:  # energy only falls: all comes to rest
        batch.labels[waiting] = 0
        return waiting[:0]
    while (
        0 < waiting.size <= FEW * count
        and batch.passed(waiting) < LONGEST_TOGETHER
        and not batch.stop[0]
    ):
        waiting = match(batch, waiting, LONGEST_TOGETHER)
    return waiting


def match(batch: Batch, waiting: Numbers, longest: float, until: float = 0.0) -> Numbers:
    """Follow orbits on until a region holds them; return those left over.

    Where a cycle has been found since, for the time in which damping settles most. Or else for as
    long again as they were followed, and at least `until`, unless that was for the longest time.
    """
    if batch.cycle_found:
        return batch.follow(waiting, batch.known.first_wait)
    passed = batch.passed(waiting)
    return batch.follow(waiting, max(2.0 * passed, until) - passed) if passed < longest else waiting


def seed(batch: Batch, waiting: Numbers) -> bool:
    """Return whether the first orbit is beside a stable limit cycle that may yet hold it."""
    in_time = batch.passed(waiting) < LONGEST_BESIDE_CYCLE
    return beside_cycle(batch, int(waiting[0])) and (batch.cycle_found or in_time)


def label(batch: Batch, waiting: Numbers) -> Numbers:
    """Label the first orbit by following it alone; return the others that are left over then."""
    first, others = int(waiting[0]), waiting[1:]
    batch.labels[first] = fate = fate_of(batch, first)
    batch.undecided_in_turn = batch.undecided_in_turn + 1 if fate == UNDECIDED else 0
    if fate == CHAOTIC:
        return label_chaos(batch, others)
    # touches take long to fade, and to follow one by one: others may do so together
    took = float(batch.times[first]) if fate == batch.known.fading_label else 0.0
    return match(batch, others, LONGEST_TOGETHER, until=min(took, LONGEST_TOGETHER))


def beside_cycle(batch: Batch, number: int) -> bool:
    """Return whether an orbit is beside a stable limit cycle, which is known then."""
    rotor, state = batch.known.rotor, batch.states[:, number].copy()
    duration = min(RETURN_REVOLUTIONS * 2.0 * math.pi / rotor.omega, RETURN_TIME)
    try:
        times, misses = returns(rotor, state, duration, 2.0 * BESIDE, batch.stop)
    except SimulationError:
        return False
    near = BESIDE * float(np.linalg.norm(state))
    for time in _closest(times[misses <= near], misses[misses <= near], ONE_RETURN * duration):
        cycle = _stable_cycle(batch, state, time)
        if (
            cycle is not None
            and cycle.radius_max - rotor.delta0 > SLIGHT * rotor.delta0
            and float(np.linalg.norm(cycle.state - state)) <= near
        ):
            batch.label_of(cycle)
            return True
    return False


def _closest(times: Values, misses: Values, apart: float) -> list[float]:
    """Return the times of the closest returns, each apart from the others, as they come."""
    chosen: list[float] = []
    for place in np.argsort(misses, kind="stable").tolist():
        time = float(times[place])
        if len(chosen) < MOST_RETURNS and all(abs(time - other) > apart for other in chosen):
            chosen.append(time)
    return sorted(chosen)


def _stable_cycle(batch: Batch, state: Values, period: float) -> Cycle | None:
    """Return the stable limit cycle near a state and a period, followed once round."""
    try:
        cycle = close_orbit(batch.known.rotor, state, period, batch.stop)
        cycle = once_round(cycle, batch.stop)
    except SimulationError:
        return None
    return cycle if is_stable(cycle.shot) else None


def fate_of(batch: Batch, number: int) -> int:
    """Return the label of one orbit, followed alone to its attractor; a new limit cycle is added.

    UNDECIDED where it has none after the time that a sweep gives it.
    """
    known = batch.known
    x, y, vx, vy = batch.states[:, number].tolist()
    settled = follow_to_steady_state(known.rotor, (x, y, vx, vy), ALONE, stop=batch.stop)
    batch.times[number] += np.float32(settled.window_end)
    match settled.response:
        case response.CHAOTIC:
            batch.chaotic = settled
            return CHAOTIC
        case response.CONTACT_FREE if known.free is not None:
            return known.free_label
        case response.TOUCHING if known.free is not None:
            return known.fading_label
        case response.SYNCHRONOUS:
            return _whirl_of(known, settled.features.amplitude)
        case response.BOUNCING | response.FULL_CONTACT:
            cycle = _stable_cycle(batch, np.array(settled.end), settled.features.period)
            return UNDECIDED if cycle is None else batch.label_of(cycle)
        case _:
            return UNDECIDED


def _whirl_of(known: Known, amplitude: float) -> int:
    """Return the label of the whirl with an amplitude."""
    apart = [abs(each.amplitude / amplitude - 1.0) for each in known.whirls]
    nearest = min(range(len(apart)), key=apart.__getitem__, default=UNDECIDED)
    return nearest if apart and apart[nearest] <= SAME_AMPLITUDE else UNDECIDED


def label_chaos(batch: Batch, waiting: Numbers) -> Numbers:
    """Label the orbits that last as long as chaos, beside one that is chaotic; return the others.

    They are followed until they would have settled, and as long again, in which those that leave
    are counted.
    """
    late = max(LATE, PATIENCE / batch.known.rotor.zeta)
    waiting = batch.follow(waiting, late - batch.passed(waiting))
    before = float(batch.times[waiting].sum())
    last = batch.follow(waiting, late)
    batch.left += waiting.size - last.size
    batch.watched += float(batch.times[waiting].sum()) - before
    looked_at = last[:: max(1, last.size // CHECKED)][:CHECKED]
    for number in looked_at.tolist():
        batch.labels[number] = fate_of(batch, number)
    rest = np.setdiff1d(last, looked_at)
    if (batch.labels[looked_at] == CHAOTIC).all():
        batch.labels[rest] = CHAOTIC
        return rest[:0]
    return batch.follow(rest, batch.known.first_wait) if batch.cycle_found else rest
