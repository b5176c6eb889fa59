"""Where a motion of a rotor system crosses a section, and the extrema of distances in it.

States are asked of a `SystemFlow`, whose run begins with the unbalance at angle 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.simulation.extrema import CONSTANT, CONSTANT_WITHIN, MAXIMUM, MINIMUM
from rotor_ida.simulation.systems.flow import SystemFlow

# Steps that locate an extremum, at most; each simulates the motion again.
MOST_STEPS = 20


class Crossings(NamedTuple):
    """Where a motion crosses a section.

    Parameters
    ----------
    times : ndarray, shape (crossing,)
        Times from the start.
    motions : ndarray, shape (crossing, 2, n)
        Displacements and velocities, as the core has them, on fixed axes.
    end : ndarray, shape (state,)
        The state at the end of the motion.
    """

    times: Values
    motions: Values
    end: Values


class Extrema(NamedTuple):
    """The extrema of the distances of places from their centres, place by place, by time.

    Parameters
    ----------
    times, distances : ndarray, shape (extremum,)
        When they are, and how large; a constant distance is listed once.
    kinds : ndarray of int8, shape (extremum,)
        -1 minimum, 1 maximum, 0 constant.
    counts : ndarray of int, shape (place,)
        How many each place has.
    """

    times: Values
    distances: Values
    kinds: npt.NDArray[np.int8]
    counts: npt.NDArray[np.int64]


def times_of_revolutions(count: int, speed: float, phase: float) -> Values:
    """Return when the unbalance points at an angle, in a number of revolutions from angle 0 on.

    Examples
    --------
    >>> times_of_revolutions(2, -math.pi, 0.5 * math.pi).tolist()
    [1.5, 3.5]
    """
    revolution = 2.0 * math.pi / abs(speed)
    first = (phase if speed > 0.0 else (2.0 * math.pi - phase) % (2.0 * math.pi)) / abs(speed)
    passed = np.arange(count if phase else count + 1)
    return np.asarray(np.minimum(revolution * passed + first, count * revolution))


def once_a_revolution(flow: SystemFlow, state: Values, count: int, phase: float) -> Crossings:
    """Return the motion wherever the unbalance points at an angle."""
    times, duration = times_of_revolutions(count, flow.speed, phase), count * flow.revolution
    run = flow.sampled(state, times if times[-1] == duration else np.append(times, duration))
    return Crossings(times, run.samples[: times.size], flow.end_of(run))


def at_events(
    flow: SystemFlow, state: Values, duration: float, kind: int, contact: int
) -> Crossings:
    """Return the motion at the events of one kind of a contact."""
    run = flow.sampled(state, np.array([duration]), only_events=True)
    chosen = (run.event_kinds == kind) & (run.event_contacts == contact)
    return Crossings(run.event_times[chosen], run.event_states[chosen], flow.end_of(run))


def at_peaks(flow: SystemFlow, state: Values, duration: float, contact: int) -> Crossings:
    """Return the motion wherever a contact is farthest from the centre of its stator."""
    x, y = flow.problem.found.rows[contact]
    centre = complex(*flow.problem.assembly.contacts[contact].centre)
    found = distance_extrema(flow, state, duration, (x + 1j * y)[None], np.array([centre]), 1e-13)
    times = found.times[found.kinds == MAXIMUM]
    run = flow.sampled(state, np.append(times, duration))
    return Crossings(times, run.samples[: times.size], flow.end_of(run))


def on_turning_axes(flow: SystemFlow, motions: Values, angles: Values | float) -> ComplexValues:
    """Return displacements and velocities of the nodes on axes turned by angles.

    `motions` has the shape (crossing, 2, n), and the result (crossing, 2, node).
    """
    rows = flow.problem.found.rows_in_y(flow.problem.assembly.node_rows())
    turn = np.exp(-1j * np.broadcast_to(angles, len(motions)))
    return np.asarray((motions @ (rows[:, 0] + 1j * rows[:, 1]).T) * turn[:, None, None])


def distance_extrema(
    flow: SystemFlow, state: Values, duration: float, rows: ComplexValues, centres: ComplexValues,
    within: float,
) -> Extrema:  # fmt: skip
    """Return the extrema of the distances of places over a motion.

    Parameters
    ----------
    flow : SystemFlow
        The motion.
    state : ndarray, shape (state,)
        Where it begins.
    duration : float
        How long it lasts.
    rows : ndarray of complex, shape (place, n)
        Displacements of the places.
    centres : ndarray of complex, shape (place,)
        From where their distances count.
    within : float
        Error of the times, in revolutions.

    Notes
    -----
    An extremum lies between two samples whose rates have different signs. Samples are 64 in a
    revolution, the events, and the peaks of contacts, so that no contact falls between two of them.
    The root of the rate is then located by the rule of Anderson and Björck, for all places at once.
    """
    known = flow.sampled(state, np.array([duration]))
    inner = np.concatenate([known.event_times, known.episodes["peak_time"]])
    inner = inner[(inner > 0.0) & (inner < duration)]
    times = np.union1d(flow.sample_times(duration), inner)

    def squared(at: Values) -> tuple[Values, Values]:
        """Return the squares of the distances at increasing times, and their rates."""
        place, velocity = np.moveaxis(flow.sampled(state, at).samples @ rows.T, 1, 0)
        place = place - centres
        return np.abs(place) ** 2, 2.0 * (place.conj() * velocity).real

    squares, rates = squared(times)
    distances = np.sqrt(squares)
    steady = np.ptp(distances, axis=0) <= CONSTANT_WITHIN * distances.max(initial=0.0)
    turns = ((rates[:-1] > 0.0) != (rates[1:] > 0.0)) & ~steady
    places, before = np.nonzero(turns.T)
    kinds = np.where(rates[before, places] > 0.0, MAXIMUM, MINIMUM).astype(np.int8)

    def at_places(at: Values) -> tuple[Values, Values]:
        """Return the squares and rates of the places, each at its own time."""
        each, number = np.unique(np.append(at, duration), return_inverse=True)
        return tuple(values[number[:-1], places] for values in squared(each))  # type: ignore[return-value]

    ends = (times[before], times[before + 1], rates[before, places], rates[before + 1, places])
    at, extreme = _located(at_places, *ends, within * flow.revolution)
    counts = np.where(steady, 1, turns.sum(axis=0))
    constant = np.flatnonzero(steady)
    order = np.argsort(np.concatenate([places, constant]), kind="stable")
    return Extrema(
        np.concatenate([at, np.zeros(constant.size)])[order],
        np.concatenate([np.sqrt(extreme), distances[:, constant].mean(axis=0)])[order],
        np.concatenate([kinds, np.full(constant.size, CONSTANT, np.int8)])[order], counts,
    )  # fmt: skip


def _located(
    squared_at: Callable[[Values], tuple[Values, Values]], low: Values, high: Values,
    at_low: Values, at_high: Values, within: float,
) -> tuple[Values, Values]:  # fmt: skip
    """Return the roots of rates between pairs of times, and the squares of the distances there."""
    point, squares = np.full_like(low, np.nan), np.empty_like(low)
    done = np.zeros(low.shape, bool)
    for _ in range(MOST_STEPS if low.size else 0):
        apart = np.where(at_high == at_low, 1.0, at_high - at_low)  # equal in what is done
        secant = high - at_high * (high - low) / apart
        secant = np.clip(secant, np.minimum(low, high), np.maximum(low, high))
        moved = np.abs(secant - point)
        point = np.where(done, point, secant)
        squares, rates = squared_at(point)
        done |= (moved <= within) | (rates == 0.0)
        if done.all():
            break
        # the end that stays counts less, so that it moves next time
        stays, weight = rates * at_high > 0.0, 1.0 - rates / np.where(at_high == 0.0, 1.0, at_high)
        at_low = np.where(stays, at_low * np.where(weight > 0.0, weight, 0.5), at_high)
        low = np.where(stays, low, high)
        high, at_high = np.where(done, high, point), np.where(done, at_high, rates)
    return point, squares
