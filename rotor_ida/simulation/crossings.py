"""Where a motion crosses a section, and the extrema of distances in it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import MOST_NUMBERS
from rotor_ida.core.runs import EXTREMUM, Rows
from rotor_ida.core.system_requests import Places
from rotor_ida.errors import InputError
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema.flags import ENTRY, EXIT, REVERSE, ROLL, SLIP
from rotor_ida.simulation.flow import DiscFlow, Flow
from rotor_ida.simulation.system_flow import SystemFlow

# Events of a run by name; the last ones need friction.
RUBS = {"roll": ROLL, "slip": SLIP, "reverse": REVERSE}
EVENTS = {"entry": ENTRY, "exit": EXIT, **RUBS}
# Kinds of an extremum.
MINIMUM, CONSTANT, MAXIMUM = -1, 0, 1
# Of one disc knots are samples that show whether the radius is constant; extrema lie anywhere
# between them.
KNOTS_A_REVOLUTION = 64
KNOTS_A_TIME = 16
# A distance that varies by less than this fraction is constant. A sweep accepts deviations of 1e-9
# from the mean of a steady whirl, which is below this.
CONSTANT_WITHIN = 1e-8


class Crossings(NamedTuple):
    """Where a motion crosses a section.

    Parameters
    ----------
    times : ndarray, shape (crossing,)
        Times from the start.
    states : ndarray, shape (4, crossing) or (4, crossing, node)
        Displacements and velocities of one disc or of the nodes of a system, on axes that rotate
        with the unbalance.
    motions : ndarray, shape (crossing, 2, n), optional
        Displacements and velocities of a system, as the core has them, on fixed axes.
    end : ndarray, shape (state,), optional
        The state of a system at the end of the motion.
    """

    times: Values
    states: Values
    motions: Values = np.empty((0, 2, 0))
    end: Values = np.empty(0)


def crossings_of(
    flow: Flow, state: Values, count: int, at: str, phase: float = 0.0, contact: int = 0
) -> Crossings:
    """Return where a motion crosses a section, in a number of revolutions.

    Parameters
    ----------
    flow : Flow
        The motion.
    state : ndarray, shape (state,)
        Where it begins.
    count : int
        The number of revolutions.
    at : str
        ``"revolution"``, ``"peak"``, or an event by its name in `EVENTS`.
    phase : float
        Angle of the unbalance in a section by revolutions.
    contact : int
        The contact of a system whose events or peaks are meant.
    """
    if isinstance(flow, DiscFlow):
        return _of_disc(flow, state, count, at, phase)
    assert isinstance(flow, SystemFlow)
    duration = count * flow.revolution
    if at in EVENTS:
        run = flow.sampled(state, np.array([duration]), only_events=True)
        chosen = (run.event_kinds == EVENTS[at]) & (run.event_contacts == contact)
        times, motions = run.event_times[chosen], run.event_states[chosen]
    else:
        times = times_of_revolutions(count, flow.speed, phase)
        if at == "peak":
            rows, centres = flow.observable()
            own = Places(rows[contact : contact + 1], centres[contact : contact + 1])
            found = distance_extrema(flow, state, duration, own)
            times = found["time"][found["kind"] == MAXIMUM]
        closes = times.size and times[-1] == duration
        run = flow.sampled(state, times if closes else np.append(times, duration))
        motions = run.samples[: times.size]
    angles = flow.speed * times if at != "revolution" else np.full(times.size, phase)
    rows = flow.problem.found.rows_in_y(flow.problem.assembly.node_rows())
    turned = (motions @ (rows[:, 0] + 1j * rows[:, 1]).T) * np.exp(-1j * angles)[:, None, None]
    place, velocity = np.moveaxis(turned, 1, 0)
    states = np.stack([place.real, place.imag, velocity.real, velocity.imag])
    return Crossings(times, states, motions, flow.end_of(run))


def _of_disc(flow: DiscFlow, state: Values, count: int, at: str, phase: float) -> Crossings:
    """Return where a motion of one disc crosses a section: see `crossings_of`."""
    duration = count * flow.revolution
    if at == "peak":
        extrema = radius_extrema(flow.but(rtol=flow.options.step_rtol), state, duration)
        chosen = extrema[extrema["kind"] == MAXIMUM]
        return Crossings(chosen["time"], chosen["state"].T)
    if at == "revolution":
        times = times_of_revolutions(count, flow.speed, phase)
        states = flow.orbit(state, duration, times).states
        # turning by whole revolutions would only add rounding
        return Crossings(times, (rotated(states, np.float64(-phase)) if phase else states).T)
    orbit = flow.orbit(state, duration, np.empty(0))
    own = orbit.event_kinds == EVENTS[at]
    times = orbit.event_times[own]
    return Crossings(times, rotated(orbit.event_states[own], -flow.speed * times).T)


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


# ---- Extrema ----


def radius_extrema(flow: DiscFlow, state: Values, duration: float) -> Rows:
    """Return the extrema of the radius of one disc, by time, as rows of `EXTREMUM`.

    If the radius is constant, return one row of the kind 0 with its mean. Raise `SimulationError`
    if the integration is stuck, or stopped.
    """
    times = np.linspace(0.0, duration, math.ceil(duration * _knots_a_time(flow.rotor)) + 1)
    result = flow.followed(state, duration, sample_times=times, extrema=True, watch=flow.watch)
    radius = np.hypot(result.samples[:, 0], result.samples[:, 1])
    if np.ptp(radius) <= CONSTANT_WITHIN * radius.max():
        return np.array([(0.0, radius.mean(), CONSTANT, result.samples[0])], EXTREMUM)
    return result.extrema


def check_knots(name: str, rotor: Rotor, duration: float) -> None:
    """Raise `InputError` for a time with more knots than fit into memory."""
    longest = MOST_NUMBERS / _knots_a_time(rotor)
    if duration > longest:
        raise InputError(
            "{name} must be at most {most:.6g}, got {value}",
            name=name, most=longest, value=duration,
        )  # fmt: skip


def _knots_a_time(rotor: Rotor) -> float:
    return max(KNOTS_A_REVOLUTION * rotor.omega / (2.0 * math.pi), KNOTS_A_TIME)


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
