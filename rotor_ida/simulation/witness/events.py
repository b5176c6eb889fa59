"""What ends a mode of a contact: crossings of the stator, and guards, found as roots in a step.

A guard is positive in its mode. The solver's own root functions are not used: events would depend
on the sample times, and a root function for extrema of the radius would respond to rounding on a
steady whirl. A crossing and its opposite are missed where no step ends between them and the radius
has two extrema in one step, or where the touch is too slight for the tolerance.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

from rotor_ida.schema.flags import ENTRY, EXIT, FLIES, IS_LOOSE, PRESS, RELEASE, ROLL, ROLLS, SLIP
from rotor_ida.simulation.witness.bodies import HIDDEN
from rotor_ida.simulation.witness.integration import Function, Integration
from rotor_ida.simulation.witness.mechanics import SLIDES, Machine

# Fractions of a step checked in flight, and for guards.
LOOKS = 4


class Ends(NamedTuple):
    """When a contact first leaves its mode, infinity if never; which one, and by which event."""

    time: float
    number: int
    event: int


def first_end(motion: Integration, machine: Machine, turns: list[list[float]]) -> Ends:
    """Return what first ends a mode in the last step, given the extrema of all radii."""
    first = Ends(math.inf, -1, 0)
    for number, mode in enumerate(machine.modes):
        time = _crossing_in(motion, machine, turns[number], number)
        if time < first.time:
            first = Ends(time, number, ENTRY if mode == FLIES else EXIT)
        for within, event, hidden in _guards(motion, machine, number):
            time = first_below(motion, within, hidden)
            if time < first.time and not (
                event == ROLL
                and time == next_time(motion.low)
                and _drives_on(motion, machine, number)
            ):
                first = Ends(time, number, event)
    return first


def next_time(time: float) -> float:
    """Return the next time: that of an event where a mode ends as soon as it begins."""
    return math.nextafter(time, math.inf)


def _drives_on(motion: Integration, machine: Machine, number: int) -> bool:
    """Return whether surfaces without slip at the start of a step continue to slide as before.

    After a slip their speed grows like the square of time: the error of a step may exceed it.
    """
    before = list(machine.modes)
    machine.modes[number] = ROLLS
    machine.settle(motion.low, motion.before)
    after, machine.modes[:] = machine.modes[number], before
    return after == before[number]


def _guards(
    motion: Integration, machine: Machine, number: int
) -> list[tuple[Function, int, float]]:
    """Return the guards of a mode, their events and rounding levels."""
    mode, law = machine.modes[number], machine.body.laws[number]
    guards: list[tuple[Function, int, float]] = []
    if mode == FLIES:
        return guards
    if law.damping > 0.0:
        side, event = (-1.0, PRESS) if mode == IS_LOOSE else (1.0, RELEASE)

        def pushes(time: float) -> float:
            return side * float(motion.once(machine.touch, number, time).damping_factor)

        guards.append((pushes, event, 0.0))
    if mode in SLIDES and law.friction > 0.0:

        def slides(time: float) -> float:
            return mode * float(motion.once(machine.touch, number, time).slip)

        guards.append((slides, ROLL, machine.hidden_slip(number, motion.low, motion.before)))
    if mode == ROLLS:
        begun, _, hidden = motion.once(machine.grip_of, number, motion.low)
        ended, *_ = motion.once(machine.grip_of, number, motion.high)
        if max(abs(begun), abs(ended)) > hidden:
            guards += [(_grip(motion, machine, number, sense), SLIP, hidden) for sense in SLIDES]
    return guards


def _grip(motion: Integration, machine: Machine, number: int, sense: int) -> Function:
    """Return the grip remaining against sliding in a sense, as a function."""

    def left(time: float) -> float:
        hold, grip, _ = motion.once(machine.grip_of, number, time)
        return float(grip - sense * hold)

    return left


def first_below(motion: Integration, within: Function, hidden: float) -> float:
    """Return when in the last step a function first falls below 0; infinity if never."""
    for low, high in pairwise(motion.looks(LOOKS)):
        if within(high) < -hidden:
            point, reach = low, high - low
            while within(point) <= 0.0 and reach > HIDDEN * high:
                reach *= 0.125
                point = low + reach
            return motion.root(within, point, high) if within(point) > 0.0 else next_time(low)
    return math.inf


def turns_in(motion: Integration, machine: Machine, number: int) -> list[float]:
    """Return when in the last step the radius of a contact has extrema.

    One is found at most between two looks. A step of a drop through the centre may be as long as
    the drop.
    """

    def rises(time: float) -> float:
        z, v = motion.once(machine.seen, number, time)
        return float(z.real * v.real + z.imag * v.imag)

    places = motion.looks(LOOKS if machine.modes[number] == FLIES else 1)
    rates = [rises(place) for place in places]
    if min(rates) > 0.0 or max(rates) < 0.0:
        return []
    return [
        motion.root(rises, low, high)
        for (low, high), (rate, next_rate) in zip(pairwise(places), pairwise(rates), strict=True)
        if rate * next_rate < 0.0
    ]


def _crossing_in(motion: Integration, machine: Machine, turns: list[float], number: int) -> float:
    """Return when in the last step a contact first leaves its mode; infinity if never.

    A mode begins on the stator, up to rounding on either side: only a passage out of it counts.
    """
    clearance: float = machine.body.laws[number].clearance
    if clearance == 0.0:
        return math.inf
    side = -1.0 if machine.modes[number] == FLIES else 1.0

    def within(time: float) -> float:
        return side * float(abs(motion.once(machine.seen, number, time)[0]) - clearance)

    hidden = HIDDEN * clearance  # below this it is rounding, as for a rotor at rest on the stator
    for low, high in pairwise((motion.low, *turns, motion.high)):
        if within(high) < -hidden:
            # or it left as soon as it entered
            return motion.root(within, low, high) if within(low) > 0.0 else next_time(low)
    return math.inf
