"""One contact from entry to exit, in variables that are smooth through both.

The Hertz force has a kink of order 1.5 at |z| = delta0, which costs an integrator its order.
With ``q = sqrt(|z| - delta0)`` and a fictitious time u, ``dt = q du``, the motion in contact is
analytic through entry and exit, and the exit is a simple root of q:

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

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.compiling import compiled
from rotor_ida.contact import force_of_root
from rotor_ida.parameters import Rotor
from rotor_ida.simulator.options import TIGHTEST_ATOL, Options
from rotor_ida.simulator.solver import Integration, SolverFailure, integrate

Values = npt.NDArray[np.float64]

Q, P, H, C, S, T, J = range(7)
SIZE = 7
# Internal steps without progress in time after which a contact counts as stuck.
PATIENCE = 10_000
# On a steady whirl rounding alone moves q and p by so much: no step can be asked for less.
BELOW_ROUNDING = 1e-16
# A rise of q by less than this part of it is rounding.
NOISE = 1e-13


@dataclass(frozen=True, slots=True)
class Contact:
    """One contact, or the part of it that lies inside the run.

    Parameters
    ----------
    end : ndarray, shape (7,)
        Regularised state at the exit, where q is 0, or at the end of the run.
    left : bool
        Whether it ended with an exit.
    peak : ndarray, shape (7,)
        Regularised state at the largest indentation inside the run.
    samples : ndarray, shape (n, 7)
        Regularised states at the sample times inside the contact.
    evaluations : int
        Evaluations of the right-hand side.
    """

    end: Values
    left: bool
    peak: Values
    samples: Values
    evaluations: int


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


def regularised(position: complex, velocity: complex, root: float) -> Values:
    """Return the regularised state, time 0, of a rotor with contact root `root`."""
    direction = position / abs(position)
    along = velocity * direction.conjugate()
    moment = (position.conjugate() * velocity).imag
    return np.array([root, along.real, moment, direction.real, direction.imag, 0.0, 0.0])


def cartesian(states: Values, delta0: float) -> Values:
    """Return ``(x, y, vx, vy)`` on the rotating axes of regularised states, shape (..., 7)."""
    q, p, h, c, s, _, _ = np.moveaxis(states, -1, 0)
    length = np.hypot(c, s)
    c, s = c / length, s / length
    radius = delta0 + q * q
    around = h / radius
    return np.stack([radius * c, radius * s, p * c - around * s, p * s + around * c], axis=-1)


def follow_contact(
    rotor: Rotor,
    start: Values,
    duration: float,
    slack: float,
    samples: Values,
    options: Options,
) -> Contact:
    """Integrate one contact until q falls through 0 or `duration` has passed.

    Parameters
    ----------
    rotor : Rotor
        The rotor, with ``delta0 > 0``.
    start : ndarray, shape (7,)
        Regularised state at time 0, with ``q > 0``, or ``q = 0`` and ``p > 0``.
    duration : float
        Longest time to follow it [1].
    slack : float
        How far behind `duration` an exit may lie and still count as being at it [1].
    samples : ndarray, shape (n,)
        Times to report [1], increasing.
    options : Options
        Method and tolerances.

    Raises
    ------
    SolverFailure
        If the solver gives up.
    """
    motion = _set_on_its_way(rotor, start, options)
    peak, rows, idle = start, list[Values](), 0
    while True:
        motion.advance()
        end, reached, left = _end_of_step(motion, duration, slack)
        peak = _highest(peak, _peak_of_step(motion, end, reached, peak))
        for time in samples[len(rows) :]:
            if time > reached[T]:
                break
            rows.append(_at_time(motion, end, float(time)))
        if left or reached[T] >= duration:
            taken = np.array(rows) if rows else np.empty((0, SIZE))
            return Contact(reached, left, peak, taken, motion.evaluations)
        idle = idle + 1 if reached[T] <= motion.before[T] else 0
        if idle > PATIENCE:
            raise SolverFailure("time no longer advances in contact", end, reached)


def _set_on_its_way(rotor: Rotor, start: Values, options: Options) -> Integration:
    """Start the integration, with tolerances that still resolve a very slight touch."""
    omega, zeta, delta0 = rotor.omega, rotor.zeta, rotor.delta0

    def field(state: Values, rate: Values) -> None:
        contact_field(state, rate, omega, zeta, delta0)

    slight = options.step_rtol * max(start[Q], abs(start[P]))
    brief = options.step_rtol * _least_duration(start)
    atol = np.full(SIZE, options.step_atol)
    atol[[Q, P]] = max(min(options.step_atol, slight), BELOW_ROUNDING)
    atol[[T, J]] = max(min(options.step_atol, brief), TIGHTEST_ATOL)
    return integrate(field, start, options, atol=atol)


def _least_duration(start: Values) -> float:
    """Return a time below which a contact from `start` cannot end: that of a straight way out."""
    if start[Q] > 0.0 > start[P]:
        return float(start[Q] ** 2 / -start[P])
    return float(max(start[Q], abs(start[P])))


def _end_of_step(motion: Integration, duration: float, slack: float) -> tuple[float, Values, bool]:
    """Return where the motion stands after a step: at its end, at an exit, or at the end time."""
    end, reached, left = motion.point, motion.values, False
    if reached[Q] <= 0.0:
        end, left = motion.root(_contact_root, _inside(motion), end), True
        reached = motion.at(end).copy()
        reached[Q] = 0.0
    if reached[T] > duration + (slack if left else 0.0):
        end = motion.root(lambda state: float(state[T] - duration), motion.low, end)
        reached, left = motion.at(end).copy(), False
        reached[T] = duration
    elif left:
        reached[T] = max(reached[T], motion.before[T])
    return end, reached, left


def _contact_root(state: Values) -> float:
    return float(state[Q])


def _inside(motion: Integration) -> float:
    """Return a point of the last step at which the rotor is in contact."""
    point = motion.low
    length = motion.point - motion.low
    while motion.at(point)[Q] <= 0.0 and length > 1e-14 * motion.point:
        length *= 0.125
        point = motion.low + length
    return point


def _highest(one: Values, other: Values) -> Values:
    return other if other[Q] > one[Q] else one


def _peak_of_step(motion: Integration, end: float, reached: Values, peak: Values) -> Values:
    """Return the state of largest q in a step: at its end, or where p vanishes inside it.

    On a whirl of constant radius p is rounding noise; there is nothing to look for.
    """
    before = motion.before
    could_reach = before[Q] + before[P] * (end - motion.low)
    if before[P] > 0.0 > reached[P] and could_reach > peak[Q] * (1.0 + NOISE):
        return motion.at(motion.root(lambda state: float(state[P]), motion.low, end))
    return reached


def _at_time(motion: Integration, end: float, time: float) -> Values:
    """Return the state at a time inside the last step: Newton's method, kept in a bracket."""
    low, high = motion.low, end
    span = float(motion.values[T] - motion.before[T]) or 1.0
    point = low + (high - low) * min(1.0, max(0.0, (time - motion.before[T]) / span))
    state = motion.at(point)
    for _ in range(60):
        late = state[T] - time
        if abs(late) <= 4e-16 * max(1.0, time) or high - low <= 4e-16 * high:
            break
        low, high = (low, point) if late > 0.0 else (point, high)
        new = point - late / state[Q] if state[Q] > 0.0 else low
        point = new if low < new < high else 0.5 * (low + high)
        state = motion.at(point)
    return state
