"""Go from a motion that approaches a cycle to the cycle itself.

A transient of slight damping takes thousands of revolutions to die out. Near its cycle a motion is
linear in its distance from it, so that Newton's method on the state after a period finds the cycle
at once. It is taken for the one that the motion leads to only if the motion shows that it is:

1. its multipliers lie within the unit circle;
2. some periods later the motion has come nearer, about as much as they say;
3. no contact can open or close on the way that does not on the cycle.

Where any of these fails the motion is followed further. An unstable cycle is reported only where
the motion sits on it, as on an equilibrium by symmetry. The cycle is then simulated as any other
motion is, and decided on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.schema.flags import ENTRY
from rotor_ida.simulation.flow import Window
from rotor_ida.simulation.system_flow import SAMPLES_A_REVOLUTION, SystemFlow

# The largest step of Newton's method, in parts of the size of the motion, its most steps, and what
# a step leaves at most of how far a state misses itself.
LONGEST_STEP, MOST_STEPS, CONTRACTS = 0.5, 8, 0.5
# A cycle is found where a state misses itself by this part of its size,
FOUND = 1e-11
# or by no less than this, where rounding lets it come no nearer.
NEARLY = 1e-9
# The derivative is computed again unless it foretells where a step leads to this part of the step.
FORETOLD = 1e-4
# Multipliers that are 1, or above it by so little, are those of a neutral motion.
NEUTRAL = 1e-5
# The motion is followed until its distance should have fallen to this part; the largest number of
# periods for that; and the part of the expected decay that must be seen. The motion may then be
# early or late along its orbit; the number of corrections of that.
FALLEN, MOST_PERIODS, SLOWER, CORRECTIONS = 0.8, 500, 0.5, 2
# The part of the gap between a contact and its stator that the bound of the transient may fill.
WITHIN = 0.5
# A motion that is nearer to its cycle than this part of its size need not show its course.
THERE = 1e-7
# Where a cycle may be: the state misses itself by at most these parts of the range of the motion,
# likely or possibly.
NEARER, NEAR = 1e-3, 0.3
# What moves by less than this part of its size in a period stands still on rotating axes.
MOVES = 1e-5
# No contact opens or closes for this number of revolutions where the motion may stand still.
LAST = 2.0
# Largest number of periods in a candidate.
MOST_PARTS = 8
# Candidates for the period that are tried.
MOST_TRIED = 3
# Most revolutions of a period, where it is likely and where it is possible.
MOST_REVOLUTIONS, MOST_POSSIBLE = 64, 12


@dataclass(frozen=True, slots=True)
class Candidate:
    """A period that a cycle may have.

    Parameters
    ----------
    period : float
        The period.
    is_free : bool
        Whether the period is unknown: that of an orbit on rotating axes.
    is_likely : bool
        Whether the motion has nearly repeated itself after it.
    """

    period: float
    is_free: bool
    is_likely: bool = False


@dataclass(frozen=True, slots=True)
class Landing:
    """A cycle, and the multipliers that show it to be stable.

    Parameters
    ----------
    state : ndarray, shape (n,)
        A state on it.
    period : float
        Its period.
    is_free : bool
        Whether it moves on rotating axes.
    slowest : complex
        The nontrivial multiplier with which neighbours return most slowly.
    growing : ndarray, shape (n,), or None
        How a neighbour differs that leaves it; None where it is stable.
    """

    state: Values
    period: float
    is_free: bool
    slowest: complex
    growing: Values | None = None


def candidates(flow: SystemFlow, seen: Window) -> list[Candidate]:
    """Return the periods that a motion may have, from its last part, the likely ones first.

    There are a whole number of samples each revolution. The motion may stand still on rotating axes
    where no contact opened or closed in the last revolutions. Where all contacts stayed open it is
    linear, and may whirl about any point.
    """
    times, states = seen.times, seen.states
    away = np.abs(states - states[-1]).max(axis=1)
    late = seen.event_times >= times[-1] - LAST * flow.revolution
    may_stand = not (np.abs(seen.event_kinds[late]) == ENTRY).any()
    in_flight = may_stand and not seen.ends_in_contact
    size, revolution = float(np.abs(states).max()), flow.revolution
    each = round(revolution / float(times[-1] - times[-2]))
    whole = Candidate(revolution, is_free=False)
    found: list[tuple[float, Candidate]] = []  # with how far the state misses itself
    if flow.problem.forward is None:
        strobed = away[-1 - each :: -each][: 2 * MOST_REVOLUTIONS]
        spread = float(strobed.max(initial=0.0))
        found = [
            (float(missed), Candidate((number + 1) * revolution, is_free=False))
            for number, missed in enumerate(strobed[:MOST_REVOLUTIONS])
        ]
        first = [whole] if away[-1 - each] <= NEAR * size else []  # a slow spiral
    else:
        spread = float(away.max())
        found = _returns(flow, seen, away)
        may_whirl = may_stand and float(away[-1 - each :].max()) <= NEAR * size
        first = [whole] if in_flight or may_whirl else []
    likely = [replace(each, is_likely=True) for missed, each in found if missed <= NEARER * spread]
    possible = [
        each for missed, each in found
        if NEARER * spread < missed <= NEAR * spread
        and each.period <= (MOST_POSSIBLE + 0.5) * revolution
    ]  # fmt: skip
    return [*first, *likely, *possible][:MOST_TRIED]


def _returns(flow: SystemFlow, seen: Window, away: Values) -> list[tuple[float, Candidate]]:
    """Return after what times a motion comes near its last state, and by how much it misses it."""
    times, states = seen.times, seen.states
    rate = flow.rate(seen.end)[: states.shape[1]]
    if not rate.any():
        return []
    lows = 1 + np.flatnonzero((away[1:-1] < away[:-2]) & (away[1:-1] <= away[2:]))
    found = []
    for low in lows[::-1].tolist():
        apart = states[low] - states[-1]
        late = float(apart @ rate / (rate @ rate))
        period = float(times[-1] - times[low]) + late
        found.append((float(np.abs(apart - late * rate).max()), Candidate(period, is_free=True)))
    return found


def land(flow: SystemFlow, state: Values, candidate: Candidate) -> Landing | None:
    """Return the cycle that a motion leads to, if it shows that it does; else None.

    An unstable one is returned where the motion is on it already.
    """
    found = _newton(flow, state, candidate)
    if found is None:
        return None
    cycle, period, derivative = found
    multipliers, shapes = np.linalg.eig(derivative)
    seen = flow.observed(cycle, np.linspace(0.0, period, SAMPLES_A_REVOLUTION + 1))
    in_flight = seen.is_in_flight
    trivial = np.zeros(multipliers.size, bool)
    if candidate.is_free:
        trivial[np.argmin(np.abs(multipliers - 1.0))] = True
    elif in_flight:  # a rotor without supports stays where it is
        trivial = np.abs(multipliers - 1.0) <= NEUTRAL
    rest = multipliers[~trivial]
    slowest = complex(rest[np.argmax(np.abs(rest))]) if rest.size else 0j
    off = state - cycle
    if not abs(slowest) < 1.0:
        growing = growing_direction(derivative)
        if growing is None or np.abs(off).max() > NEARLY * np.abs(cycle).max():
            return None
        return Landing(cycle, period, candidate.is_free, slowest, growing)
    if trivial.any() and not candidate.is_free:
        # the centre of its whirl stays where the transient leaves it
        parts = np.linalg.lstsq(shapes, off.astype(complex))[0]
        kept = (shapes[:, trivial] @ parts[trivial]).real
        cycle, off = cycle + kept, off - kept
    landing = Landing(cycle, period, candidate.is_free, slowest)
    is_there = np.abs(off).max() <= THERE * np.abs(cycle).max()
    leads_there = is_there or (
        _keeps_contacts(flow, seen, off, shapes)
        and _comes_nearer(flow, cycle, off, landing, shapes[:, ~trivial])
    )
    return landing if leads_there else None


def _newton(
    flow: SystemFlow, state: Values, candidate: Candidate
) -> tuple[Values, float, Values] | None:
    """Return a cycle near a state, its period, and the derivative of the state after it."""
    cycle, period, size = state, candidate.period, float(np.abs(state).max())
    derivative: Values | None = None
    rate, last, step = np.zeros_like(state), np.inf, np.inf
    for number in range(MOST_STEPS):
        image = flow.after(cycle, period)
        missed = float(np.abs(image - cycle).max())
        if derivative is not None and (missed <= FOUND * size or last <= NEARLY * size <= missed):
            break
        if number > 1 and missed > CONTRACTS * last:
            return None
        # after a step that the derivative has foretold it has hardly changed
        if derivative is None or missed > FORETOLD * step:
            derivative = flow.monodromy(cycle, period)
            rate = flow.rate(cycle) if candidate.is_free else rate
        if missed <= FOUND * size:
            break
        last = missed
        change, more = _step(derivative, image - cycle, rate, candidate.is_free)
        step = float(np.abs(change).max())
        if not step <= LONGEST_STEP * size or not abs(more) <= LONGEST_STEP * period:
            return None
        cycle, period = cycle + change, period + more
    if derivative is None or not _closes(flow, cycle, period):
        return None
    if candidate.is_free and not np.abs(flow.rate(cycle)).max() * period > MOVES * size:
        return None  # it stands still
    for count in range(MOST_PARTS, 1, -1):
        part = period / count
        revolutions = part / flow.revolution
        is_whole = abs(revolutions - round(revolutions)) < 1e-9 <= revolutions
        if (candidate.is_free or is_whole) and _closes(flow, cycle, part):
            return cycle, part, flow.monodromy(cycle, part)
    return cycle, period, derivative


def _closes(flow: SystemFlow, cycle: Values, period: float) -> bool:
    """Return whether a state comes back after a period."""
    missed = np.abs(flow.after(cycle, period) - cycle).max()
    return bool(missed <= NEARLY * np.abs(cycle).max())


def _step(derivative: Values, missed: Values, rate: Values, is_free: bool) -> tuple[Values, float]:
    """Return the changes of state and period that close a cycle, to first order."""
    size = missed.size
    matrix = np.eye(size) - derivative
    if is_free:
        # the state moves across the orbit alone
        matrix = np.block([[matrix, -rate[:, np.newaxis]], [rate[np.newaxis], np.zeros((1, 1))]])
        missed = np.append(missed, 0.0)
    solved = np.asarray(np.linalg.lstsq(matrix, missed, rcond=0.1 * NEUTRAL)[0], np.float64)
    return solved[:size], float(solved[size]) if is_free else 0.0


def _comes_nearer(
    flow: SystemFlow, cycle: Values, off: Values, found: Landing, shapes: ComplexValues
) -> bool:
    """Return whether the motion approaches its cycle about as fast as the multipliers say.

    Distances are measured by the parts of each multiplier, `shapes` being their directions: without
    that along the orbit, where the motion may be early or late.
    """
    slowest = abs(found.slowest)
    count = math.ceil(math.log(FALLEN) / math.log(max(slowest, FALLEN)))
    if count > MOST_PERIODS:
        return False
    late = count * found.period
    later = flow.after(cycle + off, late) - cycle
    if found.is_free:  # back to where the orbit is nearest
        rate = flow.rate(cycle)
        for _ in range(CORRECTIONS):
            late -= float(rate @ later / (rate @ rate))
            later = flow.after(cycle + off, late) - cycle
    before, after = (
        float(np.linalg.norm(np.linalg.lstsq(shapes, each.astype(complex))[0]))
        for each in (off, later)
    )
    return after <= before * (1.0 - SLOWER * (1.0 - slowest**count))


def _keeps_contacts(flow: SystemFlow, seen: Window, off: Values, shapes: ComplexValues) -> bool:
    """Return whether no contact can open or close that does not on the cycle.

    The transient of each multiplier is largest at once. Without contact this holds at all times;
    with contacts it may be twice that between whole periods, and only a part of the gap is allowed.
    """
    size, found = flow.problem.assembly.size, flow.problem.found
    parts = shapes * np.linalg.lstsq(shapes, off.astype(complex))[0]
    moved = parts[:size] * flow.scales[:size, np.newaxis]
    reach = np.hypot(*np.abs(found.rows @ moved).transpose(1, 0, 2)).sum(axis=1)
    gaps = np.abs(np.abs(seen.places[0]) - flow.clearances).min(axis=0)
    lasting = ~np.isin(np.arange(gaps.size), seen.event_contacts)
    return bool((reach <= (1.0 if seen.is_in_flight else 0.5 * WITHIN) * gaps)[lasting].all())


def growing_direction(derivative: Values) -> Values | None:
    """Return how a state changes that grows by a derivative of states; None where none grows.

    It is the growing part of a fixed state, so that rounding has no influence on its sense.
    """
    multipliers, shapes = np.linalg.eig(derivative)
    grows = np.abs(multipliers) > 1.0 + NEUTRAL
    if not grows.any():
        return None
    any_state = np.linspace(1.0, 2.0, len(derivative)).astype(complex)
    parts = np.linalg.lstsq(shapes, any_state)[0]
    return np.asarray((shapes[:, grows] @ parts[grows]).real)
