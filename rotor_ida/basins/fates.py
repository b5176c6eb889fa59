"""What becomes of orbits that no trapping region holds: each is followed until that is decided.

Where an orbit comes back to where it is, Newton's method finds the limit cycle beside it; that is
then known, with a region of its own, and all are tried again. An orbit that does not is followed to
its attractor as in a sweep. Chaos is told by the largest exponent of some orbits; those that last
as long are taken to be on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.basins.kernel import CHAOTIC, NOT_COMPUTED, UNDECIDED, follow
from rotor_ida.basins.known import Known, with_cycle
from rotor_ida.cycles.limit_cycle import returns
from rotor_ida.cycles.multipliers import is_stable
from rotor_ida.cycles.shooting import close_orbit, once_round
from rotor_ida.errors import SimulationError
from rotor_ida.parallel import Stop
from rotor_ida.simulation.options import Options
from rotor_ida.steady_state import response
from rotor_ida.steady_state.follow import (
    LATE,
    PATIENCE,
    SettledResponse,
    durations,
    follow_to_steady_state,
)

Numbers = npt.NDArray[np.int64]

HOW = Options(method="taylor", rtol=1e-10)
# A whirl on which an orbit has settled has the amplitude of a known one, to this part of it.
AMPLITUDE = 1e-5
# Orbits that need longer are followed until this time by the kernel, then one by one.
LONGEST = 4000.0
# Where no more than this part is left over, it is followed for longer before one is looked at: it
# may only be slow.
FEW = 0.05
# A limit cycle is sought where an orbit comes back within so many revolutions and so long, at so
# many of its closest returns, and is beside the orbit up to this part of the size of its state.
REVOLUTIONS, RETURNS, APART, BESIDE = 20.0, 6, 2e-3, 0.1
SLIGHT, LOOKED_FOR = 1e-3, 500.0
# Beside a cycle that attracts it slowly an orbit is followed for so long.
SLOWLY = 40_000.0
# Where so many in turn do not settle, the others that are left are taken not to either.
MOST_UNDECIDED = 3
# Of orbits that last as long as chaos, so many are looked at.
CHECKED = 2


@dataclass(slots=True)
class Batch:
    """Starts under way, with what is decided of them.

    Parameters
    ----------
    known : Known
        The attractors; those that are found are added.
    states : ndarray, shape (4, n)
        States on the rotating axes; overwritten as they are followed [1].
    labels : ndarray of int16, shape (n,)
        Label of the attractor, CHAOTIC, UNDECIDED or NOT_COMPUTED.
    times : ndarray of float32, shape (n,)
        For how long each was followed [1].
    tolerance : float
        Of a step [1].
    stop : ndarray of uint8, shape (1,)
        Set to 1 to end early.
    left : int
        Number of orbits that left a chaotic motion while this was watched.
    watched : float
        For how long all of them together were watched [1].
    chaotic : SettledResponse or None
        A chaotic motion.
    """

    known: Known
    states: Values
    labels: npt.NDArray[np.int16]
    times: npt.NDArray[np.float32]
    tolerance: float
    stop: Stop
    left: int = 0
    watched: float = 0.0
    chaotic: SettledResponse | None = None

    def follow(self, numbers: Numbers, duration: float) -> Numbers:
        """Follow some orbits until a region holds them, or for a time; return those left over."""
        if not numbers.size or duration <= 0.0:
            return numbers
        states = np.ascontiguousarray(self.states[:, numbers])
        labels = np.full(numbers.size, NOT_COMPUTED, dtype=np.int16)
        times = np.zeros(numbers.size, dtype=np.float32)
        follow(
            states, labels, times, self.known.rotor, *self.known.tables(), duration,
            self.tolerance, self.stop,
        )  # fmt: skip
        self.states[:, numbers] = states
        self.labels[numbers] = labels
        self.times[numbers] += times
        left: Numbers = numbers[labels == UNDECIDED]
        return left


def decide(batch: Batch) -> None:
    """Follow all starts of a batch until what becomes of them is decided."""
    waiting = batch.follow(np.arange(batch.labels.size), durations(batch.known.rotor)[0])
    if batch.known.rotor.omega == 0.0:  # energy only falls: all comes to rest
        batch.labels[waiting] = 0
        return
    while 0 < waiting.size <= FEW * batch.labels.size:
        passed = float(batch.times[waiting].max())
        if not 0.0 < passed < LONGEST or batch.stop[0]:
            break
        waiting = batch.follow(waiting, passed)
    in_turn = 0
    while waiting.size and in_turn < MOST_UNDECIDED and not batch.stop[0]:
        known, passed = batch.known, float(batch.times[waiting].max())
        if beside_cycle(batch, int(waiting[0])):
            if batch.known is not known:
                waiting = batch.follow(waiting, durations(known.rotor)[0])
                continue
            if 0.0 < passed < SLOWLY:
                waiting = batch.follow(waiting, passed)
                continue
        first, waiting = int(waiting[0]), waiting[1:]
        batch.labels[first] = fate = fate_of(batch, first)
        in_turn = in_turn + 1 if fate == UNDECIDED else 0
        passed = float(batch.times[waiting].max(initial=0.0))
        if fate == CHAOTIC:
            waiting = _outlasting(batch, waiting)
        elif batch.known is not known:
            waiting = batch.follow(waiting, durations(known.rotor)[0])
        elif passed < LONGEST:
            # touches take long to fade, and to follow one by one: others may do so together
            took = float(batch.times[first]) if fate == known.fading_label else 0.0
            waiting = batch.follow(waiting, max(passed, min(took, LONGEST) - passed))
    if batch.stop[0]:
        batch.labels[batch.labels == UNDECIDED] = NOT_COMPUTED


def beside_cycle(batch: Batch, number: int) -> bool:
    """Return whether an orbit is beside a stable limit cycle, which is known then."""
    rotor, state = batch.known.rotor, batch.states[:, number].copy()
    duration = min(REVOLUTIONS * 2.0 * math.pi / rotor.omega, LOOKED_FOR)
    try:
        times, misses = returns(rotor, state, duration, 2.0 * BESIDE, batch.stop)
    except SimulationError:
        return False
    near = BESIDE * float(np.linalg.norm(state))
    for time in _closest(times[misses <= near], misses[misses <= near], APART * duration):
        try:
            cycle = once_round(close_orbit(rotor, state, time, batch.stop), batch.stop)
        except SimulationError:
            continue
        moved = float(np.linalg.norm(cycle.state - state))
        # a whirl of the contact-free family that just reaches the ring is no limit cycle
        slight = cycle.radius_max - rotor.delta0 <= SLIGHT * rotor.delta0
        if moved <= near and not slight and is_stable(cycle.shot):
            if batch.known.label_of_cycle(cycle) is None:
                batch.known = with_cycle(batch.known, cycle, batch.stop)
            return True
    return False


def _closest(times: Values, misses: Values, apart: float) -> list[float]:
    """Return the times of the closest returns, each apart from the others, as they come."""
    chosen: list[float] = []
    for place in np.argsort(misses, kind="stable").tolist():
        time = float(times[place])
        if len(chosen) < RETURNS and all(abs(time - other) > apart for other in chosen):
            chosen.append(time)
    return sorted(chosen)


def fate_of(batch: Batch, number: int) -> int:
    """Return the label of one orbit, followed to its attractor; a new limit cycle is added.

    UNDECIDED where it has none after the time that a sweep gives it.
    """
    known = batch.known
    x, y, vx, vy = batch.states[:, number].tolist()
    settled = follow_to_steady_state(known.rotor, (x, y, vx, vy), HOW, stop=batch.stop)
    batch.times[number] += np.float32(settled.window_end)
    if settled.response == response.CHAOTIC:
        batch.chaotic = settled
        return CHAOTIC
    if settled.response == response.CONTACT_FREE and known.has_free:
        return known.free_label
    if settled.response == response.TOUCHING and known.has_free:
        return known.fading_label
    if settled.response == response.SYNCHRONOUS:
        return _whirl_of(known, settled.features.amplitude)
    return _cycle_of(batch, settled) if settled.features.period > 0.0 else UNDECIDED


def _whirl_of(known: Known, amplitude: float) -> int:
    """Return the label of the whirl with an amplitude."""
    apart = [abs(each.amplitude / amplitude - 1.0) for each in known.whirls]
    nearest = min(range(len(apart)), key=apart.__getitem__, default=UNDECIDED)
    return nearest if apart and apart[nearest] <= AMPLITUDE else UNDECIDED


def _cycle_of(batch: Batch, settled: SettledResponse) -> int:
    """Return the label of the limit cycle on which an orbit has settled, found if it is new."""
    known = batch.known
    try:
        cycle = close_orbit(known.rotor, np.array(settled.end), settled.features.period, batch.stop)
        cycle = once_round(cycle, batch.stop)
    except SimulationError:
        return UNDECIDED
    if not is_stable(cycle.shot):
        return UNDECIDED
    label = known.label_of_cycle(cycle)
    if label is None:
        label = known.first_cycle + len(known.cycles)
        batch.known = with_cycle(known, cycle, batch.stop)
    return label


def _outlasting(batch: Batch, waiting: Numbers) -> Numbers:
    """Label the orbits that last as long as chaos, beside one that is chaotic; return the others.

    They are followed until they would have settled, and as long again, in which those that leave
    are counted.
    """
    late = max(LATE, PATIENCE / batch.known.rotor.zeta)
    passed = float(batch.times[waiting].max(initial=0.0))
    waiting = batch.follow(waiting, late - passed)
    before = float(batch.times[waiting].sum())
    last = batch.follow(waiting, late)
    batch.left += waiting.size - last.size
    batch.watched += float(batch.times[waiting].sum()) - before
    looked_at, known = last[:: max(1, last.size // CHECKED)][:CHECKED], batch.known
    for number in looked_at.tolist():
        batch.labels[number] = fate_of(batch, number)
    rest = np.setdiff1d(last, looked_at)
    if (batch.labels[looked_at] == CHAOTIC).all():
        batch.labels[rest] = CHAOTIC
        return rest[:0]
    return batch.follow(rest, durations(known.rotor)[0]) if batch.known is not known else rest
