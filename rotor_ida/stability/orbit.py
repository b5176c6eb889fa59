"""A stretch of an orbit with all that Newton's method asks of it, and all that happens on it.

State, four differences from it, and the differences that small changes of omega, zeta and delta0
make are followed together, by one Taylor series in contact and in closed form in flight. Field
and Jacobian are continuous where contact begins and ends, so nothing is added there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.compiling import asked_to_stop, compiled, release
from rotor_ida.equations.model import rotating_field
from rotor_ida.errors import SimulationError
from rotor_ida.parallel.jobs import Stop
from rotor_ida.parameters import Rotor
from rotor_ida.simulation.contact_phase import J, P, Q, T, end_of_step, radial_velocity_of
from rotor_ida.simulation.flight import first_touch, fly, fly_by_parameters
from rotor_ida.simulation.motion import GOES_ON, root
from rotor_ida.simulation.start import starts_in_contact
from rotor_ida.simulation.tangents import COUNT
from rotor_ida.simulation.taylor.differences import Differences, new_differences
from rotor_ida.simulation.taylor.motion import Taylor, expand_by_parameters, open_taylor
from rotor_ida.simulation.taylor.rows import LANES, evaluate_row
from rotor_ida.stability.tangent_flow import (
    begin_contact,
    fly_bundle,
    put_on_the_ring,
    write_bundle,
)

Values = npt.NDArray[np.float64]
Parameters = tuple[float, float, float]

DONE, STUCK, FULL = 0, 1, 2
MINIMUM, MAXIMUM = -1.0, 1.0
RTOL = 1e-15

# Rows of a bundle: the state, four differences of it, and one made by each parameter.
BY_PARAMETER = 1 + COUNT
ROWS = BY_PARAMETER + 3
# Columns of the table of contacts, and of that of the extrema of the radius.
ENTRY, EXIT, PEAK_TIME, PEAK_ROOT, IMPULSE = range(5)
TIME, RADIUS, KIND = range(3)

_ROUNDING = 2.0**-52
_PATIENCE = 1_000_000
_FIRST_ROOM = 64
_LOOKS_A_REVOLUTION = 32
_FEWEST_LOOKS = 8
_LOOKS_A_STEP = 4
_HALVINGS = 45


@dataclass(frozen=True, slots=True)
class Shot:
    """A stretch of an orbit, from a start to its end.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start, end : ndarray, shape (4,)
        States ``(x, y, vx, vy)`` on the rotating axes [1].
    duration : float
        Time between them [1].
    monodromy : ndarray, shape (4, 4)
        Derivative of the end by the start [1].
    by_parameter : ndarray, shape (4, 3)
        Derivatives of the end by omega, zeta and delta0 [1]; that by delta0 is 0 without clearance.
    contacts : ndarray, shape (n, 5)
        Entry, exit and peak time, root of the largest indentation, and impulse of each contact
        [1]; NaN where it begins before the start, or ends after the end.
    extrema : ndarray, shape (m, 3)
        Time, radius and kind, -1 or 1, of each minimum and maximum of the radius between them [1].
    """

    rotor: Rotor
    start: Values
    end: Values
    duration: float
    monodromy: Values
    by_parameter: Values
    contacts: Values
    extrema: Values

    @property
    def start_rate(self) -> Values:
        """Rate of change of the state at the start [1]."""
        return rotating_field(self.start, self.rotor)

    @property
    def end_rate(self) -> Values:
        """Rate of change of the state at the end [1]."""
        return rotating_field(self.end, self.rotor)


def shoot(
    rotor: Rotor,
    start: Values,
    duration: float,
    stop: Stop,
    rtol: float = RTOL,
    known: Shot | None = None,
) -> Shot:
    """Follow a state for a time, with the derivatives of where it ends.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : ndarray, shape (4,)
        ``(x, y, vx, vy)`` on the rotating axes [1].
    duration : float
        Time to follow it for [1].
    stop : ndarray, shape (1,)
        Anything but 0 asks to stop.
    rtol : float
        Tolerance of one step, relative to the size of the state [1].
    known : Shot, optional
        A stretch close by, whose derivatives by the parameters serve: they take half of the time.

    Raises
    ------
    SimulationError
        If it could not be followed.
    """
    parameters = (rotor.omega, rotor.zeta, rotor.delta0)
    x, y, vx, vy = start.tolist()
    in_contact = starts_in_contact(complex(x, y), complex(vx, vy), *parameters)
    bundle = np.empty((ROWS, 4))
    status, room = FULL, _FIRST_ROOM
    while status == FULL:
        bundle[0], bundle[1:BY_PARAMETER], bundle[BY_PARAMETER:] = start, np.eye(4), 0.0
        contacts, extrema = np.full((room, 5), np.nan), np.empty((4 * room, 3))
        status, touched, turned = follow_orbit(
            bundle, in_contact, duration, parameters, rtol, stop, contacts, extrema, known is None
        )
        room *= 4
    if status != DONE or not np.isfinite(bundle).all():
        raise SimulationError(
            "an orbit could not be followed round", time=0.0, state=(x, y, vx, vy)
        )
    return Shot(
        rotor, start, bundle[0].copy(), duration, bundle[1:BY_PARAMETER].T.copy(),
        known.by_parameter if known else bundle[BY_PARAMETER:].T.copy(), contacts[:touched],
        extrema[:turned],
    )  # fmt: skip


@compiled
def follow_orbit(
    bundle: Values, in_contact: bool, duration: float, rotor: Parameters, rtol: float, stop: Stop,
    contacts: Values, extrema: Values, by_parameters: bool,
) -> tuple[int, int, int]:  # fmt: skip
    """Follow a bundle for a time, and write its contacts and the extrema of its radius.

    The differences that the parameters make are followed only where they are asked for.

    Returns
    -------
    status : int
        0; 1 if the orbit could not be followed, or was asked to stop; 2 if a table is full.
    touched, turned : int
        Number of contacts and of extrema written.
    """
    omega, zeta, delta0 = rotor
    motion = open_taylor(omega, zeta, delta0, delta0 > 0.0, rtol, True)
    made = new_differences(motion.order + 1)
    touched, turned, now, status = 0, 0, 0.0, DONE
    for _ in range(_PATIENCE):
        if touched >= contacts.shape[0] or turned >= extrema.shape[0]:
            status = FULL
            break
        left = duration - now
        if in_contact:
            passed, in_contact, turned = _contact(
                bundle, left, now, rotor, rtol, motion, made, stop, contacts[touched], extrema,
                turned, by_parameters,
            )  # fmt: skip
            touched += 1
            if passed < 0.0:
                status = STUCK
                break
            if not in_contact and delta0 > 0.0:
                put_on_the_ring(bundle, delta0)
        else:
            z, w = complex(bundle[0, 0], bundle[0, 1]), complex(bundle[0, 2], bundle[0, 3])
            touch = first_touch(z, w, omega, zeta, delta0, left, stop)
            if asked_to_stop(stop):
                status = STUCK
                break
            passed, in_contact = min(touch, left), touch <= left
            turned = _turns_of_flight(z, w, passed, now, omega, zeta, extrema, turned)
            _fly(bundle, passed, omega, zeta, by_parameters)
            if in_contact:
                put_on_the_ring(bundle, delta0)
                contacts[min(touched, contacts.shape[0] - 1), ENTRY] = now + passed
        now += passed
        if duration - now <= _ROUNDING * duration:
            break
    release(motion)
    return status, touched, turned


@compiled
def _fly(bundle: Values, tau: float, omega: float, zeta: float, by_parameters: bool) -> None:
    """Move a bundle by `tau` of free flight, in closed form."""
    z, w = complex(bundle[0, 0], bundle[0, 1]), complex(bundle[0, 2], bundle[0, 3])
    fly_bundle(bundle, tau, omega, zeta)
    if by_parameters:
        by_omega_z, by_omega_w, by_zeta_z, by_zeta_w = fly_by_parameters(z, w, tau, omega, zeta)
        _add(bundle[BY_PARAMETER], by_omega_z, by_omega_w)
        _add(bundle[BY_PARAMETER + 1], by_zeta_z, by_zeta_w)


@compiled
def _add(row: Values, position: complex, velocity: complex) -> None:
    row[0] += position.real
    row[1] += position.imag
    row[2] += velocity.real
    row[3] += velocity.imag


@compiled
def _turns_of_flight(
    z: complex, w: complex, duration: float, now: float, omega: float, zeta: float, extrema: Values,
    turned: int,
) -> int:  # fmt: skip
    """Write the extrema of the radius in a flight; return how many there are now."""
    looks = max(_FEWEST_LOOKS, math.ceil(duration * omega * _LOOKS_A_REVOLUTION / (2.0 * math.pi)))
    low, rising = 0.0, (z.conjugate() * w).real
    for look in range(1, looks + 1):
        high = duration * look / looks
        there, moving = fly(z, w, high, omega, zeta)
        after = (there.conjugate() * moving).real
        if rising * after < 0.0 and turned < extrema.shape[0]:
            a, b = low, high
            for _ in range(_HALVINGS):
                middle = 0.5 * (a + b)
                there, moving = fly(z, w, middle, omega, zeta)
                if (there.conjugate() * moving).real * rising > 0.0:
                    a = middle
                else:
                    b = middle
            extrema[turned, TIME] = now + b
            extrema[turned, RADIUS] = abs(there)
            extrema[turned, KIND] = MAXIMUM if rising > 0.0 else MINIMUM
            turned += 1
        low, rising = high, after
    return turned


@compiled
def _contact(
    bundle: Values, left: float, now: float, rotor: Parameters, rtol: float, motion: Taylor,
    made: Differences, stop: Stop, contact: Values, extrema: Values, turned: int,
    by_parameters: bool,
) -> tuple[float, bool, int]:  # fmt: skip
    """Follow a contact until its exit or for `left`; return the time passed, negative if stuck.

    Also returns whether it is still in contact, and how many extrema there are now.
    """
    columns = np.zeros(LANES)
    passed = begin_contact(bundle, left, rotor, rtol, motion)
    _spread(bundle, columns)
    regularised, leaves, reached = rotor[2] > 0.0, False, motion.values.copy()
    contact[PEAK_ROOT] = 0.0
    if regularised:
        contact[PEAK_ROOT], contact[PEAK_TIME] = reached[Q], now
    while passed < left:
        if asked_to_stop(stop) or motion.advance() != GOES_ON:
            return -1.0, True, turned
        if by_parameters:
            made.terms[0] = columns
            expand_by_parameters(motion, made)
        if regularised:
            end, leaves = end_of_step(motion, left, 0.0, reached)
            passed = reached[T]
        else:
            end = passed = min(motion.point, left)
            reached[:] = motion.at(end)
        if math.isnan(end):
            return -1.0, True, turned
        if by_parameters:
            evaluate_row(made.terms, motion.order, end - motion.low, columns)
        if regularised:
            turned = _turn_of_contact(motion, end, reached, now, contact, extrema, turned)
        else:
            turned = _turns_without_clearance(motion, end, now, contact, extrema, turned)
        if leaves:
            contact[EXIT], contact[IMPULSE] = now + passed, reached[J]
            break
    if regularised and not leaves:
        contact[IMPULSE] = reached[J]
    write_bundle(bundle, reached, rotor[2])
    _gather(columns, bundle)
    return passed, not leaves, turned


@compiled
def _spread(bundle: Values, columns: Values) -> None:
    """Write the differences made by the parameters as a row of series wants them."""
    for i in range(3):
        for j in range(4):
            columns[COUNT * j + i] = bundle[BY_PARAMETER + i, j]


@compiled
def _gather(columns: Values, bundle: Values) -> None:
    """Do the reverse of `_spread`."""
    for i in range(3):
        for j in range(4):
            bundle[BY_PARAMETER + i, j] = columns[COUNT * j + i]


@compiled
def _turn_of_contact(
    motion: Taylor, end: float, reached: Values, now: float, contact: Values, extrema: Values,
    turned: int,
) -> int:  # fmt: skip
    """Write the extremum of the radius in the last step, which has one at most, and the peak."""
    rising = motion.before[P]
    if rising * reached[P] < 0.0 and turned < extrema.shape[0]:
        point = root(motion, radial_velocity_of, 0.0, motion.low, end)
        if not math.isnan(point):
            state = motion.at(point)
            extrema[turned, TIME] = now + state[T]
            extrema[turned, RADIUS] = motion.delta0 + state[Q] ** 2
            extrema[turned, KIND] = MAXIMUM if rising > 0.0 else MINIMUM
            turned += 1
            if state[Q] > contact[PEAK_ROOT]:
                contact[PEAK_ROOT], contact[PEAK_TIME] = state[Q], now + state[T]
    if reached[Q] > contact[PEAK_ROOT]:
        contact[PEAK_ROOT], contact[PEAK_TIME] = reached[Q], now + reached[T]
    return turned


@compiled
def _turns_without_clearance(
    motion: Taylor, end: float, now: float, contact: Values, extrema: Values, turned: int
) -> int:
    """Write the extrema of the radius in the last step of a rotor that is always in contact."""
    low, state = motion.low, motion.at(motion.low)
    rising = state[0] * state[2] + state[1] * state[3]
    for look in range(1, _LOOKS_A_STEP + 1):
        high = motion.low + (end - motion.low) * look / _LOOKS_A_STEP
        state = motion.at(high)
        after = state[0] * state[2] + state[1] * state[3]
        if rising * after < 0.0 and turned < extrema.shape[0]:
            a, b = low, high
            for _ in range(_HALVINGS):
                middle = 0.5 * (a + b)
                state = motion.at(middle)
                if (state[0] * state[2] + state[1] * state[3]) * rising > 0.0:
                    a = middle
                else:
                    b = middle
            size = math.hypot(state[0], state[1])
            extrema[turned, TIME], extrema[turned, RADIUS] = now + b, size
            extrema[turned, KIND] = MAXIMUM if rising > 0.0 else MINIMUM
            turned += 1
            if math.sqrt(size) > contact[PEAK_ROOT]:
                contact[PEAK_ROOT], contact[PEAK_TIME] = math.sqrt(size), now + b
        low, rising = high, after
    return turned
