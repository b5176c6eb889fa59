"""Where a motion of a rotor system crosses a section, and the extrema of distances in it.

States are asked of a `SystemFlow`, whose run begins with the unbalance at angle 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.core.runs import Rows
from rotor_ida.core.systems import Places
from rotor_ida.simulation.extrema import CONSTANT, CONSTANT_WITHIN, MAXIMUM
from rotor_ida.simulation.systems.flow import SystemFlow


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
    rows, centres = flow.observable()
    own = slice(contact, contact + 1)
    found = distance_extrema(flow, state, duration, Places(rows[own], centres[own]))
    times = found["time"][found["kind"] == MAXIMUM]
    run = flow.sampled(state, np.append(times, duration))
    return Crossings(times, run.samples[: times.size], flow.end_of(run))


def on_turning_axes(flow: SystemFlow, motions: Values, angles: Values | float) -> ComplexValues:
    """Return displacements and velocities of the nodes on axes turned by angles.

    `motions` has the shape (crossing, 2, n), and the result (crossing, 2, node).
    """
    rows = flow.problem.found.rows_in_y(flow.problem.assembly.node_rows())
    turn = np.exp(-1j * np.broadcast_to(angles, len(motions)))
    return np.asarray((motions @ (rows[:, 0] + 1j * rows[:, 1]).T) * turn[:, None, None])


def distance_extrema(flow: SystemFlow, state: Values, duration: float, places: Places) -> Rows:
    """Return the extrema of the distances of places over a motion, place by place, by time.

    Parameters
    ----------
    flow : SystemFlow
        The motion.
    state : ndarray, shape (state,)
        Where it begins.
    duration : float
        How long it lasts.
    places : Places
        The places.

    Returns
    -------
    ndarray of EXTREMUM_OF_PLACE
        The extrema; a constant distance is listed once, of the kind 0.
    """
    table = flow.extrema(state, duration, places)
    firsts = np.searchsorted(table["place"], np.arange(len(places.rows)))
    least, most = (each.reduceat(table["distance"], firsts) for each in (np.minimum, np.maximum))
    steady = most - least <= CONSTANT_WITHIN * most.max()
    kept = (table["kind"] != CONSTANT) & ~steady[table["place"]]
    kept[firsts[steady]] = True  # where the motion begins
    return np.asarray(table[kept])
