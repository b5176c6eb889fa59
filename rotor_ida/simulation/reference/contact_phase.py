"""One contact from entry to exit, in variables that are smooth through both.

The Hertz force has a kink of order 1.5 at |z| = delta0, which costs an integrator its order.
With ``q = sqrt(|z| - delta0)`` and a fictitious time u, ``dt = q du``, the motion in contact is
analytic through entry and exit, and the exit is a simple root of q. This rests on the exponent
3/2, which makes the force q**3:

    q' = p/2                                                     p     radial velocity
    p' = q (h**2/r**3 - 2 zeta p - q**3 + omega**2 c)            h     angular momentum
    h' = -q (2 zeta h + omega**2 r s)                            r     delta0 + q**2
    c' = -q s (h/r**2 - omega),  s' = q c (h/r**2 - omega)       c, s  direction on rotating axes
    t' = q                                                       t     time since the start
    j' = q**4                                                    j     impulse of the force

A graze is half a swing of a harmonic oscillator in these variables, however slight it is, and
a departure is a passage of q from + to - that does not come back: no step can hide one.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.core.interface import DONE, NO_ROOT, STOPPED, STUCK
from rotor_ida.simulation.options import TIGHTEST_ATOL
from rotor_ida.simulation.reference.motion import Motion, root
from rotor_ida.simulation.reference.record import Record, samples_done, time_left

Values = npt.NDArray[np.float64]

Q, P, H, C, S, T, J = range(7)
SIZE = 7
# Internal steps without progress in time after which a contact counts as stuck.
PATIENCE = 10_000
# On a steady whirl rounding alone moves q and p by so much: no step can be asked for less.
BELOW_ROUNDING = 1e-16
# A rise of q by less than this part of it is rounding.
NOISE = 1e-13


def regularised(position: complex, velocity: complex, contact_root: float) -> Values:
    """Return the regularised state, time 0, of a rotor with contact root `contact_root`."""
    direction = position / abs(position)
    along = velocity * direction.conjugate()
    moment = (position.conjugate() * velocity).imag
    return np.array([contact_root, along.real, moment, direction.real, direction.imag, 0.0, 0.0])


def cartesian(state: Values, delta0: float) -> tuple[complex, complex]:
    """Return displacement and velocity on the rotating axes of a regularised state."""
    length = math.sqrt(state[C] * state[C] + state[S] * state[S])
    c, s = state[C] / length, state[S] / length
    radius = delta0 + state[Q] * state[Q]
    along, around = state[P], state[H] / radius
    return complex(radius * c, radius * s), complex(along * c - around * s, along * s + around * c)


def follow_contact(
    record: Record, motion: Motion, start: Values
) -> tuple[int, bool, Values, Values]:
    """Integrate one contact until q falls through 0 or the run is at its end.

    Samples inside the contact are taken on the way.

    Parameters
    ----------
    record : Record
        The run, with ``delta0 > 0``.
    motion : Motion
        The integration of a contact.
    start : ndarray, shape (7,)
        Regularised state at time 0, with ``q > 0``, or ``q = 0`` and ``p > 0``.

    Returns
    -------
    status : int
        0, or why the contact could not be followed.
    left : bool
        Whether it ended with an exit.
    end, peak : ndarray, shape (7,)
        Regularised state at the exit, where q is 0, or at the end of the run; and at the largest
        indentation.
    """
    duration, slack, stop = time_left(record), record.slack, record.stop
    peak, reached, left, idle = start.copy(), start.copy(), False, 0
    status = motion.restart(start, tolerances(start, record.rtol, record.atol))
    while status == DONE:
        status = STOPPED if stop[0] else motion.advance()
        if status != DONE:
            break
        end, left = end_of_step(motion, duration, slack, reached)
        if math.isnan(end):
            status = NO_ROOT
            _copy(motion.before, reached)
            break
        _raise_peak(motion, end, reached, peak)
        _record_samples(record, motion, end, reached[T])
        if left or reached[T] >= duration:
            break
        idle = idle + 1 if reached[T] <= motion.before[T] else 0
        if idle > PATIENCE:
            status = STUCK
    record.evaluations += motion.evaluations()
    return status, left, reached, peak


def tolerances(start: Values, rtol: float, absolute: float) -> Values:
    """Return absolute tolerances: the relative one, of the size that each variable comes to.

    So a very slight touch is still resolved, and a hard one is not asked for digits at entry and
    exit, where q is 0, that are lost in its course.
    """
    slight = rtol * max(start[Q], abs(start[P]))
    brief = rtol * _least_duration(start)
    atol = np.full(SIZE, absolute)
    atol[Q] = atol[P] = max(slight, BELOW_ROUNDING)
    atol[T] = atol[J] = max(brief, TIGHTEST_ATOL)
    return atol


def _least_duration(start: Values) -> float:
    """Return a time below which a contact from `start` cannot end: that of a straight way out."""
    if start[P] < 0.0 < start[Q]:
        return float(start[Q] ** 2 / -start[P])
    return float(max(start[Q], abs(start[P])))


def end_of_step(
    motion: Motion, duration: float, slack: float, reached: Values
) -> tuple[float, bool]:
    """Write where the motion stands after a step into `reached`; return the point, and if it left.

    That is at the end of the step, at an exit, or at the end time.
    """
    end, left = motion.point, False
    _copy(motion.values, reached)
    if reached[Q] <= 0.0:
        end, left = root(motion, contact_root_of, 0.0, _inside(motion), end), True
        _copy(motion.at(end), reached)
        reached[Q] = 0.0
    if reached[T] > duration + (slack if left else 0.0):
        end, left = root(motion, time_of, duration, motion.low, end), False
        _copy(motion.at(end), reached)
        reached[T] = duration
    elif left:
        reached[T] = max(reached[T], motion.before[T])
    return end, left


def _copy(values: Values, into: Values) -> None:
    """Copy values: of a few numbers, faster than by a slice."""
    for i in range(into.size):
        into[i] = values[i]


def contact_root_of(state: Values) -> float:
    """Return q."""
    return float(state[Q])


def radial_velocity_of(state: Values) -> float:
    """Return p."""
    return float(state[P])


def time_of(state: Values) -> float:
    """Return t."""
    return float(state[T])


def _inside(motion: Motion) -> float:
    """Return a point of the last step at which the rotor is in contact."""
    point = motion.low
    length = motion.point - motion.low
    while motion.at(point)[Q] <= 0.0 and length > 1e-14 * motion.point:
        length *= 0.125
        point = motion.low + length
    return point


def _raise_peak(motion: Motion, end: float, reached: Values, peak: Values) -> None:
    """Write the state of largest q in a step into `peak`, if it is higher.

    It lies at the end of the step, or where p vanishes inside it. On a whirl of constant radius
    p is rounding noise; there is nothing to look for.
    """
    low, q, p = motion.low, motion.before[Q], motion.before[P]
    if p > 0.0 > reached[P] and q + p * (end - low) > peak[Q] * (1.0 + NOISE):
        summit = root(motion, radial_velocity_of, 0.0, low, end)
        if not math.isnan(summit) and motion.at(summit)[Q] > peak[Q]:
            _copy(motion.at(summit), peak)
    if reached[Q] > peak[Q]:
        _copy(reached, peak)


def _record_samples(record: Record, motion: Motion, end: float, until: float) -> None:
    """Take the samples that fall due in the last step, which ends at the time `until`."""
    times, states, delta0 = record.sample_times, record.states, record.delta0
    low, length, number = motion.low, motion.point - motion.low, record.sampled
    before, after, begun, duration = motion.before, motion.values, record.time, time_left(record)
    while number < times.size and times[number] <= record.duration:
        due = min(max(times[number] - begun, 0.0), duration)
        if due > until:
            break
        guess = min(low + length * _guess_of_part(before, after, length, due), end)
        position, velocity = cartesian(_state_at(motion, low, end, guess, due), delta0)
        states[number, 0], states[number, 1] = position.real, position.imag
        states[number, 2], states[number, 3] = velocity.real, velocity.imag
        number += 1
    samples_done(record, number)


def _state_at(motion: Motion, low: float, high: float, point: float, time: float) -> Values:
    """Return the state at a time inside the last step: Halley's method, kept in a bracket."""
    state, finest = motion.glance_at(point), 4e-16 * max(1.0, time)
    for _ in range(60):
        late = state[T] - time
        if abs(late) <= finest or high - low <= 4e-16 * high:
            break
        if late > 0.0:
            high = point
        else:
            low = point
        new = low
        if state[Q] > 0.0:  # t' = q, t'' = p/2
            step = late / state[Q]
            new = point - step / (1.0 - 0.25 * step * state[P] / state[Q])
        point = new if low < new < high else 0.5 * (low + high)
        state = motion.glance_at(point)
    return state


def _guess_of_part(before: Values, after: Values, length: float, time: float) -> float:
    """Return about in which part of the last step a time lies: u as a cubic of t, du = dt/q."""
    span = float(after[T] - before[T])
    if span <= 0.0:
        return 0.5
    part = (time - before[T]) / span
    if before[Q] > 0.0 < after[Q]:
        start, end = span / (before[Q] * length) - 1.0, 1.0 - span / (after[Q] * length)
        part += part * (1.0 - part) * (start * (1.0 - part) + end * part)
    return float(min(max(part, 0.0), 1.0))
