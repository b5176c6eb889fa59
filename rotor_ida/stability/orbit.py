"""A stretch of an orbit with all that Newton's method asks of it, and all that happens on it.

State and four differences from it are followed together, by one Taylor series in contact and in
closed form in flight; what small changes of omega, zeta and delta0 make of it follows from these.
Field and Jacobian are continuous where contact begins and ends, so nothing is added there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.compiling import asked_to_stop, compiled, release, shared
from rotor_ida.equations.model import rotating_field_into
from rotor_ida.errors import SimulationError
from rotor_ida.parallel.jobs import Stop
from rotor_ida.parameters import Rotor
from rotor_ida.simulation.contact_phase import J, P, Q, T, end_of_step, radial_velocity_of
from rotor_ida.simulation.flight import first_touch, fly, fly_by_parameters
from rotor_ida.simulation.motion import GOES_ON, root
from rotor_ida.simulation.start import starts_in_contact
from rotor_ida.simulation.tangents import COUNT
from rotor_ida.simulation.taylor.motion import Taylor, open_taylor
from rotor_ida.stability.by_parameters import added_by_parameters
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
_MOST_HALVINGS = 80


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
    start_rate, end_rate : ndarray, shape (4,)
        Rate of change of the state at the start and at the end [1].
    """

    rotor: Rotor
    start: Values
    end: Values
    duration: float
    monodromy: Values
    by_parameter: Values
    contacts: Values
    extrema: Values
    start_rate: Values
    end_rate: Values


def shoot(rotor: Rotor, start: Values, duration: float, stop: Stop, rtol: float = RTOL) -> Shot:
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

    Raises
    ------
    SimulationError
        If it could not be followed.
    """
    parameters = (rotor.omega, rotor.zeta, rotor.delta0)
    bundle, rates = np.empty((ROWS, 4)), np.empty((2, 4))
    status, room = FULL, _FIRST_ROOM
    while status == FULL:
        contacts, extrema = np.empty((room, 5)), np.empty((4 * room, 3))
        status, touched, turned = follow_orbit(
            start, duration, parameters, rtol, stop, bundle, rates, contacts, extrema
        )
        room *= 4
    if status != DONE:
        x, y, vx, vy = start.tolist()
        raise SimulationError(
            "an orbit could not be followed round", time=0.0, state=(x, y, vx, vy)
        )
    return Shot(
        rotor, start, bundle[0], duration, bundle[1:BY_PARAMETER].T, bundle[BY_PARAMETER:].T,
        contacts[:touched], extrema[:turned], rates[0], rates[1],
    )  # fmt: skip


@compiled
def follow_orbit(
    start: Values, duration: float, rotor: Parameters, rtol: float, stop: Stop, bundle: Values,
    rates: Values, contacts: Values, extrema: Values,
) -> tuple[int, int, int]:  # fmt: skip
    """Follow a state for a time, and write what there is to know of the way.

    Parameters
    ----------
    start, duration, rotor, rtol, stop
        As for `shoot`; the rotor as omega, zeta and delta0.
    bundle : ndarray, shape (8, 4)
        Overwritten with the end, and its derivatives by the start and by the parameters, as rows.
    rates : ndarray, shape (2, 4)
        Overwritten with the rates of change at the start and at the end.
    contacts, extrema : ndarray
        Overwritten, as far as there are any.

    Returns
    -------
    status : int
        0; 1 if the orbit could not be followed, or was asked to stop; 2 if a table is full.
    touched, turned : int
        Number of contacts and of extrema written.
    """
    omega, zeta, delta0 = rotor
    bundle[:] = 0.0
    bundle[0] = start
    for i in range(COUNT):
        bundle[1 + i, i] = 1.0
    rotating_field_into(start, rates[0], omega, zeta, delta0)
    position, velocity = complex(start[0], start[1]), complex(start[2], start[3])
    in_contact = starts_in_contact(position, velocity, omega, zeta, delta0)
    status, touched, turned = _follow(
        bundle, in_contact, duration, rotor, rtol, stop, contacts, extrema
    )
    rotating_field_into(bundle[0], rates[1], omega, zeta, delta0)
    if status == DONE and not math.isfinite(bundle.sum()):
        status = STUCK
    return status, touched, turned


@compiled
def _follow(
    bundle: Values, in_contact: bool, duration: float, rotor: Parameters, rtol: float, stop: Stop,
    contacts: Values, extrema: Values,
) -> tuple[int, int, int]:  # fmt: skip
    """Move a bundle by contacts and flights in turn, with what these write."""
    omega, zeta, delta0 = rotor
    motion = open_taylor(omega, zeta, delta0, delta0 > 0.0, rtol, True)
    touched, turned, now, status, entry = 0, 0, 0.0, DONE, math.nan
    for _ in range(_PATIENCE):
        if touched >= contacts.shape[0] or turned >= extrema.shape[0]:
            status = FULL
            break
        left = duration - now
        if in_contact:
            contact = contacts[touched]
            contact[:] = math.nan
            contact[ENTRY] = entry
            passed, in_contact, turned = _contact(
                bundle, left, now, rotor, rtol, motion, stop, contact, extrema, turned
            )
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
            _fly(bundle, passed, omega, zeta)
            if in_contact:
                put_on_the_ring(bundle, delta0)
                entry = now + passed
        now += passed
        if duration - now <= _ROUNDING * duration:
            break
    release(motion)
    return status, touched, turned


@compiled
def _fly(bundle: Values, tau: float, omega: float, zeta: float) -> None:
    """Move a bundle by `tau` of free flight, in closed form."""
    z, w = complex(bundle[0, 0], bundle[0, 1]), complex(bundle[0, 2], bundle[0, 3])
    fly_bundle(bundle, tau, omega, zeta)
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
            point = _turn_between(z, w, low, high, rising, omega, zeta)
            extrema[turned, TIME] = now + point
            extrema[turned, RADIUS] = abs(fly(z, w, point, omega, zeta)[0])
            extrema[turned, KIND] = MAXIMUM if rising > 0.0 else MINIMUM
            turned += 1
        low, rising = high, after
    return turned


@compiled
def _turn_between(
    z: complex, w: complex, low: float, high: float, rising: float, omega: float, zeta: float
) -> float:
    """Return where the radius turns between two moments of a flight: Newton in a bracket."""
    point = 0.5 * (low + high)
    for _ in range(_MOST_HALVINGS):
        there, moving = fly(z, w, point, omega, zeta)
        slope = (there.conjugate() * moving).real
        drawn = omega * omega - 2.0 * zeta * moving
        bend = abs(moving) ** 2 + (there.conjugate() * drawn).real
        if slope * rising > 0.0:
            low = point
        else:
            high = point
        new = point - slope / bend if bend != 0.0 else low
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - point) <= _ROUNDING * high or high - low <= _ROUNDING * high:
            return new
        point = new
    return point


@compiled
def _contact(
    bundle: Values, left: float, now: float, rotor: Parameters, rtol: float, motion: Taylor,
    stop: Stop, contact: Values, extrema: Values, turned: int,
) -> tuple[float, bool, int]:  # fmt: skip
    """Follow a contact until its exit or for `left`; return the time passed, negative if stuck.

    Also returns whether it is still in contact, and how many extrema there are now.
    """
    added = np.zeros((3, 4))
    passed = begin_contact(bundle, left, rotor, rtol, motion)
    regularised, leaves, reached = rotor[2] > 0.0, False, motion.values.copy()
    matrix = reached[motion.size :].reshape((4, 4))
    contact[PEAK_ROOT] = 0.0
    if regularised:
        contact[PEAK_ROOT], contact[PEAK_TIME] = reached[Q], now
    while passed < left:
        _begin_tangents(motion)
        if asked_to_stop(stop) or motion.advance() != GOES_ON:
            return -1.0, True, turned
        if regularised:
            end, leaves = end_of_step(motion, left, 0.0, reached)
            passed = reached[T]
        else:
            end = passed = min(motion.point, left)
            reached[:] = motion.at(end)
        if math.isnan(end):
            return -1.0, True, turned
        added_by_parameters(motion, end, matrix, added)
        _carry(bundle, matrix, added)
        if regularised:
            turned = _turn_of_contact(motion, end, reached, now, contact, extrema, turned)
        else:
            turned = _turns_without_clearance(motion, end, now, contact, extrema, turned)
        if leaves:
            contact[EXIT], contact[IMPULSE] = now + passed, reached[J]
            break
    if regularised and not leaves:
        contact[IMPULSE] = reached[J]
    write_bundle(bundle[:1], reached, rotor[2])
    return passed, not leaves, turned


@compiled
def _begin_tangents(motion: Taylor) -> None:
    """Let the tangents of a motion begin its next step as the unit matrix."""
    tangents = motion.values[motion.size :]
    tangents[:] = 0.0
    for i in range(COUNT):
        tangents[COUNT * i + i] = 1.0


@compiled
def _carry(bundle: Values, matrix: Values, added: Values) -> None:
    """Move the differences of a bundle over a step, and add what the parameters do."""
    for row in range(1, ROWS):
        x, y, vx, vy = bundle[row, 0], bundle[row, 1], bundle[row, 2], bundle[row, 3]
        for j in range(4):
            bundle[row, j] = (
                matrix[j, 0] * x + matrix[j, 1] * y + matrix[j, 2] * vx + matrix[j, 3] * vy
            )
    for i in range(3):
        for j in range(4):
            bundle[BY_PARAMETER + i, j] += added[i, j]


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
    low, rising = motion.low, _radial_rate_of(motion.at(motion.low))
    for look in range(1, _LOOKS_A_STEP + 1):
        high = motion.low + (end - motion.low) * look / _LOOKS_A_STEP
        after = _radial_rate_of(motion.at(high))
        if rising * after < 0.0 and turned < extrema.shape[0]:
            point = root(motion, _radial_rate_of, 0.0, low, high)
            turn = motion.at(point)
            size = math.hypot(turn[0], turn[1])
            extrema[turned, TIME], extrema[turned, RADIUS] = now + point, size
            extrema[turned, KIND] = MAXIMUM if rising > 0.0 else MINIMUM
            turned += 1
            if math.sqrt(size) > contact[PEAK_ROOT]:
                contact[PEAK_ROOT], contact[PEAK_TIME] = math.sqrt(size), now + point
        low, rising = high, after
    return turned


@shared
def _radial_rate_of(state: Values) -> float:
    """Return half the rate of change of the squared radius."""
    return float(state[0] * state[2] + state[1] * state[3])
