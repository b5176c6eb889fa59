"""How a settled motion moves: the part at the spin speed, extreme distances, forces."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import ComplexValues, Flags, Values
from rotor_ida.simulation.flow import Window
from rotor_ida.simulation.systems.flow import SystemFlow
from rotor_ida.steady.decision import Decision
from rotor_ida.steady.response import (
    BOUNCING,
    CONTACT_FREE,
    FULL_CONTACT,
    ROLLING,
    Features,
    phase_lag_of,
    stays_backward,
)

# Turning points closer in time are the same: rounding shifts them less, and two lie farther apart.
SAME_TURN = 1e-6
# Samples of a period of one disc over which the part at the spin speed is the mean.
SAMPLES = 1024
CYCLES = (BOUNCING, FULL_CONTACT, ROLLING)


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemFeatures:
    """How a rotor system moves in a window.

    Parameters
    ----------
    contact_whirl, node_whirl : ndarray of complex, shapes (contact,), (node,)
        Complex amplitudes of the displacements at the spin speed.
    contact_low, contact_high, node_low, node_high : ndarray
        Smallest and largest distances, of the contacts from the centres of their stators.
    largest_force : ndarray, shape (contact,)
        Largest normal forces.
    touches : ndarray of bool, shape (contact,)
        Which contacts touch.
    backward : ndarray of bool, shape (contact,)
        Which contacts stay closed and whirl backwards.
    """

    contact_whirl: ComplexValues
    node_whirl: ComplexValues
    contact_low: Values
    contact_high: Values
    node_low: Values
    node_high: Values
    largest_force: Values
    touches: Flags
    backward: Flags


def features_of_system(window: Window) -> SystemFeatures:
    """Return how a rotor system moves in a window."""
    flow = window.flow
    assert isinstance(flow, SystemFlow)
    places = flow.places(window.states, nodes=True)[0]
    turn = np.exp(-1j * flow.speed * window.times) if flow.problem.forward is None else np.ones(1)
    whirl = (places * turn[:, np.newaxis])[:-1].mean(axis=0)
    whirl = whirl if flow.speed else np.zeros_like(whirl)  # a place of rest is no whirl
    low, high = extremes(np.abs(places), flow.radii(window, nodes=True))
    count, table = flow.clearances.size, window.contacts
    largest, numbers = window.forces.max(axis=0, initial=0.0), table["contact"].astype(int)
    np.maximum.at(largest, numbers, np.nan_to_num(table["largest_force"]))
    return SystemFeatures(
        contact_whirl=whirl[:count], node_whirl=whirl[count:],
        contact_low=low[:count], contact_high=high[:count],
        node_low=low[count:], node_high=high[count:],
        largest_force=largest, touches=largest > 0.0,
        backward=np.array([stays_backward(window, each) for each in range(count)], bool),
    )  # fmt: skip


def features_of_disc(window: Window, decision: Decision) -> Features:
    """Return how one disc moves in a window; of a cycle in its last period."""
    period, since = decision.period, -math.inf
    if period is not None:
        since = float(window.times[-1]) - period - SAME_TURN
    place, extrema, last = window.places[0], window.extrema, window.times >= since
    turning = place if period is None or window.flow.period is None else place[last]
    if period is not None and decision.kind in CYCLES and window.flow.period is None:
        # its period is not one of revolutions, over which alone the other parts vanish
        times = np.linspace(0.0, period, SAMPLES + 1)
        turning = window.flow.places(window.flow.states(window.end, times))[0]
    whirl = complex(turning[:-1].mean()) if window.flow.speed else 0j  # rest is no whirl
    low, high = extremes(np.abs(place[last]), [extrema["radius"][extrema["time"] >= since]])
    return Features(
        abs(whirl), phase_lag_of(whirl), float(low[0]), float(high[0]),
        math.nan if period is None or decision.kind == CONTACT_FREE else period,
        decision.exponent, decision.error,
    )  # fmt: skip


def extremes(distances: Values, radii: list[Values]) -> tuple[Values, Values]:
    """Return the smallest and largest of distances, shape (time, place), and extreme distances."""
    both = [np.append(own, more) for own, more in zip(distances.T, radii, strict=True)]
    return np.array([each.min() for each in both]), np.array([each.max() for each in both])
