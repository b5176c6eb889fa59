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

from rotor_ida.equations.compiling import asked_to_stop, compiled, inlined, shared
from rotor_ida.equations.contact import force_of_root
from rotor_ida.simulation.motion import GOES_ON, NO_ROOT, STOPPED, STUCK, Motion, root
from rotor_ida.simulation.options import TIGHTEST_ATOL
from rotor_ida.simulation.record import Record, next_sample, record_sample, time_left

Values = npt.NDArray[np.float64]

Q, P, H, C, S, T, J = range(7)
SIZE = 7
# Internal steps without progress in time after which a contact counts as stuck.
PATIENCE = 10_000
# On a steady whirl rounding alone moves q and p by so much: no step can be asked for less.
BELOW_ROUNDING = 1e-16
# A rise of q by less than this part of it is rounding.
NOISE = 1e-13


@compiled
def contact_field(state: Values, rate: Values, omega: float, zeta: float, delta0: float) -> None:
    """Write the rate of change by u of the regularised state into `rate`."""
    q, p, h, c, s = state[0], state[1], state[2], state[3], state[4]
    radius = delta0 + q * q
    spin = h / (radius * radius)
    unbalance = omega * omega
    rate[0] = 0.5 * p
    rate[1] = q * (h * spin / radius - 2.0 * zeta * p - force_of_root(q) + unbalance * c)
    rate[2] = -q * (2.0 * zeta * h + unbalance * radius * s)
    rate[3] = -q * s * (spin - omega)
    rate[4] = q * c * (spin - omega)
    rate[5] = q
    rate[6] = q * force_of_root(q)


@shared
def regularised(position: complex, velocity: complex, contact_root: float) -> Values:
    """Return the regularised state, time 0, of a rotor with contact root `contact_root`."""
    direction = position / abs(position)
    along = velocity * direction.conjugate()
    moment = (position.conjugate() * velocity).imag
    return np.array([contact_root, along.real, moment, direction.real, direction.imag, 0.0, 0.0])


@shared
def cartesian(state: Values, delta0: float) -> tuple[complex, complex]:
    """Return displacement and velocity on the rotating axes of a regularised state."""
    length = math.sqrt(state[C] * state[C] + state[S] * state[S])
    c, s = state[C] / length, state[S] / length
    radius = delta0 + state[Q] * state[Q]
    along, around = state[P], state[H] / radius
    return complex(radius * c, radius * s), complex(along * c - around * s, along * s + around * c)


@shared
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
        The integration of `contact_field`.
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
    peak, reached, left, idle = start.copy(), start, False, 0
    due = next_sample(record, duration)
    status = motion.restart(start, tolerances(start, record.rtol, record.atol))
    while status == GOES_ON:
        status = STOPPED if asked_to_stop(stop) else motion.advance()
        if status != GOES_ON:
            break
        end, reached, left = end_of_step(motion, duration, slack)
        if math.isnan(end):
            status, reached = NO_ROOT, motion.before
            break
        _raise_peak(motion, end, reached, peak)
        while due <= reached[T]:
            _record_sample_at(record, motion, end, due)
            due = next_sample(record, duration)
        if left or reached[T] >= duration:
            break
        idle = idle + 1 if reached[T] <= motion.before[T] else 0
        if idle > PATIENCE:
            status = STUCK
    record.evaluations += motion.evaluations()
    return status, left, reached.copy(), peak


@shared
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


@shared
def _least_duration(start: Values) -> float:
    """Return a time below which a contact from `start` cannot end: that of a straight way out."""
    if start[P] < 0.0 < start[Q]:
        return float(start[Q] ** 2 / -start[P])
    return float(max(start[Q], abs(start[P])))


@inlined
def end_of_step(motion: Motion, duration: float, slack: float) -> tuple[float, Values, bool]:
    """Return where the motion stands after a step: at its end, at an exit, or at the end time."""
    end, reached, left = motion.point, motion.values, False
    if reached[Q] <= 0.0:
        end, left = root(motion, contact_root_of, 0.0, _inside(motion), end), True
        reached = motion.at(end).copy()
        reached[Q] = 0.0
    if reached[T] > duration + (slack if left else 0.0):
        end = root(motion, time_of, duration, motion.low, end)
        reached, left = motion.at(end).copy(), False
        reached[T] = duration
    elif left:
        reached[T] = max(reached[T], motion.before[T])
    return end, reached, left


@shared
def contact_root_of(state: Values) -> float:
    """Return q."""
    return float(state[Q])


@shared
def radial_velocity_of(state: Values) -> float:
    """Return p."""
    return float(state[P])


@shared
def time_of(state: Values) -> float:
    """Return t."""
    return float(state[T])


@shared
def _inside(motion: Motion) -> float:
    """Return a point of the last step at which the rotor is in contact."""
    point = motion.low
    length = motion.point - motion.low
    while motion.at(point)[Q] <= 0.0 and length > 1e-14 * motion.point:
        length *= 0.125
        point = motion.low + length
    return point


@inlined
def _raise_peak(motion: Motion, end: float, reached: Values, peak: Values) -> None:
    """Write the state of largest q in a step into `peak`, if it is higher.

    It lies at the end of the step, or where p vanishes inside it. On a whirl of constant radius
    p is rounding noise; there is nothing to look for.
    """
    before = motion.before
    could_reach = before[Q] + before[P] * (end - motion.low)
    if before[P] > 0.0 > reached[P] and could_reach > peak[Q] * (1.0 + NOISE):
        summit = root(motion, radial_velocity_of, 0.0, motion.low, end)
        if not math.isnan(summit):
            reached = motion.at(summit)
    if reached[Q] > peak[Q]:
        peak[:] = reached


@shared
def _record_sample_at(record: Record, motion: Motion, end: float, time: float) -> None:
    """Take the sample at a time inside the last step: Halley's method, kept in a bracket."""
    low, high = motion.low, end
    point = _guess_of_time(motion, low, high, time)
    state = motion.glance_at(point)
    for _ in range(60):
        late = state[T] - time
        if abs(late) <= 4e-16 * max(1.0, time) or high - low <= 4e-16 * high:
            break
        if late > 0.0:
            high = point
        else:
            low = point
        new = low
        if state[Q] > 0.0:  # Halley's step: t' = q, t'' = p/2
            step = late / state[Q]
            new = point - step / (1.0 - 0.25 * step * state[P] / state[Q])
        point = new if low < new < high else 0.5 * (low + high)
        state = motion.glance_at(point)
    position, velocity = cartesian(state, record.delta0)
    record_sample(record, position.real, position.imag, velocity.real, velocity.imag)


@shared
def _guess_of_time(motion: Motion, low: float, high: float, time: float) -> float:
    """Return about where a time lies in the last step: u as a cubic of t, du = dt/q."""
    before, after, length = motion.before, motion.values, motion.point - motion.low
    span = float(after[T] - before[T])
    if span <= 0.0:
        return 0.5 * (low + high)
    part = (time - before[T]) / span
    point = low + length * part
    if before[Q] > 0.0 < after[Q]:
        start, end = span / before[Q] - length, length - span / after[Q]
        point += part * (1.0 - part) * (start * (1.0 - part) + end * part)
    return float(min(max(point, low), high))
