"""Local maxima and minima of the distance from the bearing axis, as roots of r r'.

The motion is followed by Taylor series, from knot to knot. Between two knots
``g = r r' = x vx + y vy`` is approximated by the cubic with its exact slopes; each root of the
cubic is then polished by following the motion from the knot to it, and by Newton's method.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import MOST_NUMBERS, State
from rotor_ida.equations.model import rotated
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.parallel.jobs import Stop
from rotor_ida.parameters import Rotor
from rotor_ida.simulation.start import starts_in_contact
from rotor_ida.stability.tangent_flow import DONE, follow_from, follow_on
from rotor_ida.sweeps.turning_points import radial_motion, roots_of_cubics

Values = npt.NDArray[np.float64]

MINIMUM, CONSTANT, MAXIMUM = -1, 0, 1
KNOTS_A_REVOLUTION = 64
KNOTS_A_TIME = 16
# A radius that varies by less than this part of it is constant, to what tolerances can tell.
STEADY = 1e-8
# A step of Newton's method shorter than this leaves an error of its square.
CLOSE = 1e-7
ATTEMPTS = 12


@dataclass(frozen=True, slots=True)
class Extrema:
    """The extrema of the radius of one motion, in order of time.

    Parameters
    ----------
    times, radii : ndarray, shape (n,)
        Times from the start and distances from the bearing axis [1].
    kinds : ndarray of int8, shape (n,)
        -1 minimum, 1 maximum, 0 constant radius.
    states : ndarray, shape (n, 4)
        ``(x, y, vx, vy)`` there, on the rotating axes [1].
    """

    times: Values
    radii: Values
    kinds: npt.NDArray[np.int8]
    states: Values


def radius_extrema(rotor: Rotor, start: State, duration: float, rtol: float, stop: Stop) -> Extrema:
    """Return the extrema of the radius from `start` on.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : tuple of float
        ``(x, y, vx, vy)`` on the rotating axes [1].
    duration : float
        Time to follow the motion for [1].
    rtol : float
        Tolerance of one step, relative to the size of the state [1].
    stop : ndarray, shape (1,)
        Anything but 0 asks the search to stop.

    Returns
    -------
    Extrema
        All extrema; if the radius is constant to 1e-8, one row with its mean.

    Raises
    ------
    SimulationError
        If the integration was stuck, or asked to stop.
    """
    times = np.linspace(0.0, duration, math.ceil(duration * _knots_a_time(rotor)) + 1)
    step = float(times[1])
    states, in_contact = _knots(rotor, start, step, times.size, rtol, stop)
    radius = np.hypot(states[:, 0], states[:, 1])
    if np.ptp(radius) <= STEADY * radius.max():
        kinds = np.array([CONSTANT], dtype=np.int8)
        return Extrema(times[:1], radius.mean(keepdims=True), kinds, states[:1])
    knots, offsets = _guesses(rotor, times, states)
    reached, offsets, good = _polished(
        rotor, times[knots], states[knots], in_contact[knots], offsets, step, rtol, stop
    )
    g, slope = radial_motion(rotor, reached)
    keep = np.flatnonzero(good)
    found = times[knots] + offsets
    keep = keep[np.argsort(found[keep], kind="stable")]
    once = np.diff(found[keep], prepend=-np.inf) > 10.0 * CLOSE
    keep = keep[once]
    kinds = np.where(slope[keep] < 0.0, MAXIMUM, MINIMUM).astype(np.int8)
    # so close to an extremum the square of the radius is a parabola
    squares = (reached[keep, :2] ** 2).sum(axis=1) - g[keep] ** 2 / slope[keep]
    return Extrema(found[keep], np.sqrt(np.maximum(squares, 0.0)), kinds, reached[keep])


def check_knots(name: str, rotor: Rotor, duration: float) -> None:
    """Refuse a time in which there are more knots than memory holds."""
    longest = MOST_NUMBERS / _knots_a_time(rotor)
    if duration > longest:
        raise InputError(f"{name} must be at most {longest:.6g}, got {duration!r}")


def _knots_a_time(rotor: Rotor) -> float:
    return max(KNOTS_A_REVOLUTION * rotor.omega / (2.0 * math.pi), KNOTS_A_TIME)


def _knots(
    rotor: Rotor, start: State, step: float, count: int, rtol: float, stop: Stop
) -> tuple[Values, npt.NDArray[np.bool_]]:
    """Return states at equally spaced times, and whether each is in contact."""
    x, y, vx, vy = start
    states, in_contact = np.full((count, 4), np.nan), np.empty(count, dtype=np.bool_)
    states[0] = start
    parameters = (rotor.omega, rotor.zeta, rotor.delta0)
    in_contact[0] = starts_in_contact(complex(x, y), complex(vx, vy), *parameters)
    done = follow_on(states, in_contact, step, parameters, rtol, stop)
    if done != DONE:
        last = int(np.isfinite(states).all(axis=1).sum()) - 1
        raise _failure(rotor, last * step, states[last])
    return states, in_contact


def _guesses(rotor: Rotor, times: Values, states: Values) -> tuple[npt.NDArray[np.intp], Values]:
    """Return the knot before each root of the cubics, and the time from there to it."""
    roots = roots_of_cubics(rotor, times, states)
    knots = np.clip(np.searchsorted(times, roots, side="right") - 1, 0, times.size - 2)
    return knots, roots - times[knots]


def _polished(
    rotor: Rotor,
    times: Values,
    states: Values,
    in_contact: npt.NDArray[np.bool_],
    offsets: Values,
    step: float,
    rtol: float,
    stop: Stop,
) -> tuple[Values, Values, npt.NDArray[np.bool_]]:
    """Return states near the extrema, the times from their knots to them, and which are found."""
    reached = np.full_like(states, np.nan)
    change = np.zeros_like(offsets)
    parameters = (rotor.omega, rotor.zeta, rotor.delta0)
    for _ in range(ATTEMPTS):
        done = follow_from(states, in_contact, offsets, reached, parameters, rtol, stop)
        if done != DONE:
            row = int(np.argmin(np.isfinite(reached).all(axis=1)))
            raise _failure(rotor, float(times[row]), states[row])
        g, slope = radial_motion(rotor, reached)
        change = -np.divide(g, slope, out=np.full_like(g, np.inf), where=slope != 0.0)
        if (np.abs(change) <= CLOSE).all():
            break
        # where the cubic had a root and the motion has none, this wanders off
        offsets = np.clip(offsets + np.clip(change, -step, step), 0.0, step)
    found = np.abs(change) <= CLOSE
    return reached, offsets + np.where(found, change, 0.0), found


def _failure(rotor: Rotor, time: float, state: Values) -> SimulationError:
    x, y, vx, vy = rotated(state, rotor.omega * time).tolist()
    message = "the motion could not be followed to its extrema"
    return SimulationError(message, time=time, state=(x, y, vx, vy))
