"""What rubs in each contact: how far the surfaces slide, and for how long the disc rolls."""

from __future__ import annotations

import math

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import State
from rotor_ida.core.interface import ENTRY_TIME, EXIT_TIME
from rotor_ida.model.contact import contact_force, damping_factor
from rotor_ida.simulation.orbit import (
    SLIDES_BACKWARDS,
    SLIDES_FORWARDS,
    Orbit,
    stretches_of_rolling,
)

# Where trapezoids differ by more than this part of it from what is of higher order, the samples are
# too far apart for a slip distance.
NEAR_ENOUGH = 0.01


def rolling_times(orbit: Orbit) -> Values:
    """Return for how long the disc rolls in each contact [1]."""
    began, ended = _limits(orbit)
    rolled = np.zeros(began.size)
    for start, end in stretches_of_rolling(orbit).tolist():
        rolled += np.maximum(np.minimum(end, ended) - np.maximum(start, began), 0.0)
    return rolled


def slip_distances(orbit: Orbit, start: State) -> Values:
    """Return how far the surfaces slide over each other in each contact, always counted up [1].

    That is the integral of ``|v_s|``, from events and samples: trapezoids, and what the rates at
    their ends add. NaN where these are too far apart.
    """
    assert orbit.ways is not None
    times = np.concatenate([[0.0], orbit.event_times, orbit.times, [orbit.duration]])
    states = np.vstack([np.array(start), orbit.event_states, orbit.states, orbit.end])
    order = np.argsort(times, kind="stable")
    turned = turned_at(orbit, times)
    times, states, turned = times[order], states[order], turned[order]
    span = np.diff(times)
    ways = orbit.ways[
        np.searchsorted(orbit.event_times, 0.5 * (times[1:] + times[:-1]), side="right")
    ]
    # before, and behind: at an event the rate jumps
    first, rate = _slip(orbit, times[:-1], states[:-1], turned[:-1], ways)
    last, rate_there = _slip(orbit, times[1:], states[1:], turned[1:], ways)
    sense = np.sign(first + last)
    flat = 0.5 * span * sense * (first + last)
    bent = flat + span**2 / 12.0 * sense * (rate - rate_there)
    slides = (span > 0.0) & np.isin(ways, (SLIDES_FORWARDS, SLIDES_BACKWARDS))
    began, ended = _limits(orbit)
    middle = 0.5 * (times[1:] + times[:-1])
    distances = np.zeros(began.size)
    for number, (since, until) in enumerate(zip(began.tolist(), ended.tolist(), strict=True)):
        within = slides & (middle >= since) & (middle <= until)
        distance, plain = float(bent[within].sum()), float(flat[within].sum())
        close = abs(distance - plain) <= NEAR_ENOUGH * abs(distance)
        distances[number] = distance if close else math.nan
    return distances


def _limits(orbit: Orbit) -> tuple[Values, Values]:
    """Return when each contact began and ended, within the run."""
    began = np.nan_to_num(orbit.contacts[:, ENTRY_TIME], nan=0.0)
    ended = np.nan_to_num(orbit.contacts[:, EXIT_TIME], nan=orbit.duration)
    return began, ended


def turned_at(orbit: Orbit, times: Values) -> Values:
    """Return angle and speed at the start, the events, the samples and the end, shape (n, 2)."""
    omega = orbit.rotor.omega
    if orbit.turning is None:
        return np.column_stack([omega * times, np.full(times.size, omega)])
    turning = orbit.turning
    return np.vstack([[0.0, omega], turning.events, turning.samples, turning.end])


def _slip(
    orbit: Orbit, times: Values, states: Values, turned: Values, ways: Values
) -> tuple[Values, Values]:
    """Return the slip speed, and its rate while the surfaces slide as told."""
    rotor, (x, y, vx, vy), (angle, speed) = orbit.rotor, states.T, turned.T
    rho = rotor.disc_radius or 0.0
    radius = np.maximum(np.hypot(x, y), np.finfo(float).tiny)
    outwards, across = (x * vx + y * vy) / radius, (x * vy - y * vx) / radius
    normal = contact_force(radius, rotor.delta0, rotor.contact_exponent)
    normal = normal * np.maximum(damping_factor(outwards, rotor.contact_damping), 0.0)
    ahead = angle - np.arctan2(y, x)
    rate = speed * speed * np.sin(ahead) - 2.0 * rotor.zeta * across - rotor.load * x / radius
    rate -= rotor.friction * ways * normal + outwards * across / radius
    if orbit.turning is not None:
        lever, cos, sin = rho - np.cos(ahead), np.cos(angle), np.sin(angle)
        stiffness = rotor.shaft_stiffness + normal / radius
        resisted = -2.0 * rotor.zeta * (cos * vy - sin * vx) - stiffness * (cos * y - sin * x)
        resisted += rotor.friction * ways * normal * lever
        rate += lever * orbit.turning.course.accelerations(times, speed, resisted)
    return across + rho * speed, rate
