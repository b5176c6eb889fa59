"""What ends a mode of the reference: crossings of the stator, and guards of the contact.

All are looked for in the last step of an integration, and found as roots.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.core.interface import MESSAGES, RUNAWAY, STALLED
from rotor_ida.model.contact import force_over_radius
from rotor_ida.simulation.integration import Integration
from rotor_ida.simulation.mechanics import (
    FLIGHT,
    HIDDEN,
    LOOSE,
    ROLLING,
    SLIDING,
    Function,
    Rates,
    SpinningRotor,
    hidden_hold,
    hidden_slip,
    hold_of,
    hold_of_rolling,
    pressed_mode,
    radial_rate_of,
    radius_of,
    rolled,
    slip_of,
)
from rotor_ida.simulation.options import LARGEST
from rotor_ida.simulation.orbit import PRESS, RELEASE, ROLL, SLIP
from rotor_ida.simulation.spin import SPEED

# Fractions of a step checked for a release, a press, the largest force, and a speed below 0.
LOOKS = 4


def change_in(motion: Integration, spinning: SpinningRotor, mode: int) -> tuple[float, int]:
    """Return when in the last step the contact changes its mode, or infinity; and its event.

    It comes loose, or presses again; surfaces stop sliding; or the disc begins to slip.
    """
    first = (math.inf, 0)
    for within, event, hidden in _guards(motion, spinning, mode):
        time = _first_below(motion, within, hidden)
        if event == ROLL and time == next_time(motion.low) and _drives_on(motion, spinning, mode):
            continue
        if time < first[0]:
            first = (time, event)
    return first


def _drives_on(motion: Integration, spinning: SpinningRotor, mode: int) -> bool:
    """Return whether surfaces without slip at the start of a step continue to slide as before.

    After a slip their speed grows like the square of time: the error of a step may exceed it.
    """
    return pressed_mode(spinning, motion.low, motion.before, 0.0) == mode


def next_time(time: float) -> float:
    """Return the next time: that of an event where a mode ends as soon as it begins."""
    return math.nextafter(time, math.inf)


def _guards(
    motion: Integration, spinning: SpinningRotor, mode: int
) -> list[tuple[Function, int, float]]:
    """Return the guards of a mode, which stay positive in it, their events and rounding levels."""
    rotor = spinning.rotor
    guards: list[tuple[Function, int, float]] = []
    if mode == FLIGHT:
        return guards
    if rotor.contact_damping > 0.0:
        side = -1.0 if mode == LOOSE else 1.0
        event = PRESS if mode == LOOSE else RELEASE
        guards.append((lambda _, state: side * hold_of(rotor, state), event, 0.0))
    if mode in SLIDING:
        hidden = hidden_slip(spinning, motion.low, motion.before)
        guards.append((lambda time, state: mode * slip_of(spinning, time, state), ROLL, hidden))
    if mode == ROLLING:
        hidden = hidden_hold(spinning, motion.low, motion.before)
        ends = ((motion.low, motion.before), (motion.high, motion.after))
        holds = [
            hold_of_rolling(spinning, time, rolled(spinning, time, state)) for time, state in ends
        ]
        if max(map(abs, holds)) > hidden:
            guards += [(_grip(spinning, sense), SLIP, hidden) for sense in SLIDING]
    return guards


def _grip(spinning: SpinningRotor, sense: int) -> Function:
    """Return the grip remaining against sliding in a sense, as a function."""
    rotor = spinning.rotor

    def left(time: float, state: Values) -> float:
        seen = rolled(spinning, time, state)
        push = force_over_radius(radius_of(seen), rotor.delta0, rotor.contact_exponent)
        force = push * radius_of(seen) * hold_of(rotor, seen)
        return rotor.friction * force - sense * hold_of_rolling(spinning, time, seen)

    return left


def _first_below(motion: Integration, within: Function, hidden: float) -> float:
    """Return when in the last step a function first falls below 0; infinity if never."""
    places = np.linspace(motion.low, motion.high, LOOKS + 1).tolist()
    for low, high in pairwise(places):
        if within(high, motion.at(high)) < -hidden:
            point, reach = low, high - low
            while within(point, motion.at(point)) <= 0.0 and reach > HIDDEN * high:
                reach *= 0.125
                point = low + reach
            if within(point, motion.at(point)) > 0.0:
                return motion.root(within, point, high)
            return next_time(low)
    return math.inf


def check_speed(motion: Integration, rates: Rates, end: float) -> None:
    """Raise `SimulationError` where a driven speed leaves 0 to `LARGEST` in the last step."""
    rate = np.empty_like(motion.before)

    def growth(time: float, state: Values) -> float:
        rates(time, state, rate)
        return float(rate[SPEED])

    low = motion.low
    for to in np.linspace(motion.low, end, LOOKS + 1)[1:].tolist():
        turns = growth(low, motion.at(low)) * growth(to, motion.at(to)) < 0.0
        for point in (motion.root(growth, low, to), to) if turns else (to,):
            if motion.at(point)[SPEED] < 0.0:
                still = motion.at(low)[SPEED] <= 0.0
                stall = low if still else motion.root(lambda _, state: state[SPEED], low, point)
                raise motion.failure(MESSAGES[STALLED], stall)
            low = point
    if motion.at(end)[SPEED] > LARGEST:
        raise motion.failure(MESSAGES[RUNAWAY], end)


def turns_in(motion: Integration, looks: int) -> list[float]:
    """Return when in the last step the radius has extrema, one at most between two looks.

    A step of a drop through the centre may be as long as the drop.
    """
    places = np.linspace(motion.low, motion.high, looks + 1).tolist()
    rates = [radial_rate_of(motion.at(place)) for place in places]
    return [
        motion.root(lambda _, state: radial_rate_of(state), low, high)
        for (low, high), (rate, next_rate) in zip(pairwise(places), pairwise(rates), strict=True)
        if rate * next_rate < 0.0
    ]


def crossing_in(
    motion: Integration, turns: list[float], delta0: float, *, in_contact: bool
) -> float:
    """Return when in the last step the rotor first leaves its mode; infinity if never.

    A mode begins on the stator, up to rounding on either side: only a passage out of it counts.
    """
    if delta0 == 0.0:
        return math.inf
    side = 1.0 if in_contact else -1.0

    def within(_: float, state: Values) -> float:
        return side * (radius_of(state) - delta0)

    hidden = HIDDEN * delta0  # below this it is rounding, as for a rotor at rest on the stator
    for low, high in pairwise((motion.low, *turns, motion.high)):
        if within(high, motion.at(high)) < -hidden:
            if within(low, motion.at(low)) > 0.0:
                return motion.root(within, low, high)
            return next_time(low)  # it left as soon as it entered
    return math.inf
