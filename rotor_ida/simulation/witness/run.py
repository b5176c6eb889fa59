"""The event loop of the witness: any rotor, restarted at each event, as its force has a kink there.

    decide the mode of each contact at the start: flight, or contact, which damping may make loose;
    with friction a contact with a force slides forwards, slides backwards, or rolls;
    integrate inside the modes, step by step;
    look for what ends one, at the end of a step and at an extremum of the radius inside it;
    find it as a root, record it, and restart in the mode that follows.

A `Watcher` sees each step and each event.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from rotor_ida.arrays import Stop, Values
from rotor_ida.schema.flags import (
    ENTRY,
    EXIT,
    FLIES,
    IS_LOOSE,
    OF_FRICTION,
    PRESS,
    RELEASE,
    REVERSE,
    ROLL,
    ROLLS,
    SLIDES_BACKWARDS,
    SLIDES_FORWARDS,
    SLIP,
)
from rotor_ida.simulation.spin import SpeedProfile
from rotor_ida.simulation.witness.bodies import HIDDEN, Coordinates, Disc
from rotor_ida.simulation.witness.events import Ends, first_end, next_time, turns_in
from rotor_ida.simulation.witness.integration import Integration
from rotor_ida.simulation.witness.mechanics import Machine


@dataclass(slots=True)
class Event:
    """An event of a contact, and its modes before and after it.

    Its state has the velocities of stators without mass.
    """

    time: float
    number: int
    kind: int
    state: Values
    before: int
    after: int


class Watcher(Protocol):
    """What sees the steps and events of a run."""

    def step(self, motion: Integration, turns: list[list[float]], end: float, /) -> None:
        """See the last step up to a time, given the extrema of all radii."""

    def event(self, number: int, kind: int, time: float, state: Values, /) -> None:
        """See an event, in the mode that it begins."""


@dataclass(slots=True, kw_only=True)
class Run:
    """A run in progress: its request, and its records.

    An event may lie a `slack` after the end. `began` are the modes at the start.
    """

    body_at: Callable[[int], Disc | Coordinates]
    profile: SpeedProfile
    state: Values
    duration: float
    method: str
    tolerances: tuple[float, float | Values]
    slack: float = 0.0
    stop: Stop | None = None
    machine: Machine = field(init=False)
    events: list[Event] = field(default_factory=list)
    began: list[int] = field(default_factory=list)
    evaluations: int = 0
    time: float = 0.0

    def __post_init__(self) -> None:
        body = self.body_at(0)
        self.machine = Machine(body, self.profile.spins[0], [FLIES] * len(body.laws))
        self.machine.begin(0.0, self.state)
        self.began[:] = self.machine.modes

    def follow(self, watcher: Watcher) -> None:
        """Follow the rotor to the end.

        The integration restarts where a piece of the speed ends: its rate may jump, and with it
        what rolls.
        """
        last = len(self.profile.ends) - 1
        while self.time < self.duration:
            piece = self.profile.piece_from(self.time)
            if self.profile.spins[piece] is not self.machine.spin:
                spin, modes = self.profile.spins[piece], self.machine.modes
                self.machine = Machine(self.body_at(piece), spin, modes)
                self._settle(self.time, self.state, besides=-1)
            end = self.duration if piece == last else self.profile.ends[piece]
            found = self._follow_modes(watcher, end, self.slack if piece == last else 0.0)
            if found is not None:
                self._change(found)
                watcher.event(found.number, found.event, self.time, self.state)

    def _follow_modes(self, watcher: Watcher, until: float, slack: float) -> Ends | None:
        """Follow the modes until one ends, or to a time; an event may lie a slack after that."""
        machine = self.machine
        motion = Integration(
            self.method, machine.rates, self.tolerances, self.time, self.state,
            goal=self.time + self.duration,
        )  # fmt: skip
        found, end = None, self.time
        while found is None and end < until:
            if self.stop is not None and self.stop[0]:
                raise motion.failure("interrupted")
            motion.advance()
            turns = [turns_in(motion, machine, i) for i in range(len(machine.modes))]
            first = first_end(motion, machine, turns)
            found = first if first.time <= until + slack else None
            end = found.time if found else min(motion.high, until)
            watcher.step(motion, turns, end)
            self.time = end
        self.evaluations += motion.evaluations
        self.state = machine.at_rest(end, motion.at(end).copy())
        return found

    def _change(self, found: Ends) -> None:
        """Set the mode that follows an event, and record it."""
        (time, number, kind), machine = found, self.machine
        before, state = machine.modes[number], self.state
        if kind in {ENTRY, EXIT}:
            machine.body.put_on_stator(number, state)
        if kind in {EXIT, RELEASE}:
            machine.modes[number] = FLIES if kind == EXIT else IS_LOOSE
        elif kind == SLIP:
            hold, *_ = machine.grip_of(number, time, state)
            machine.modes[number] = SLIDES_FORWARDS if hold > 0.0 else SLIDES_BACKWARDS
        elif kind == ROLL:
            machine.modes[number] = ROLLS
            self.state = state = machine.at_rest(time, state)
        else:
            machine.rub(number, time, state)
        self._settle(time, state, besides=number)
        self._record(time, number, kind, before)

    def _settle(self, time: float, state: Values, *, besides: int) -> None:
        """Decide which contacts go on rolling; record those that slip, besides one."""
        modes = list(self.machine.modes)
        self.machine.settle(time, state)
        for number, before in enumerate(modes):
            if number != besides and before == ROLLS and self.machine.modes[number] != ROLLS:
                self._record(time, number, SLIP, before)

    def _record(self, time: float, number: int, kind: int, before: int) -> None:
        """Record an event.

        One of friction at the time of the previous event of the contact, but for rounding, is
        merged with it; so is one at the start.
        """
        after, state = self.machine.modes[number], self.state
        if kind == ROLL and after != ROLLS:
            if after == before:
                return  # it only touched
            kind = REVERSE
        last = next((each for each in reversed(self.events) if each.number == number), None)
        if kind in OF_FRICTION and last is None and time <= next_time(0.0):
            self.began[number] = after
            return
        if kind in OF_FRICTION and last is not None and time - last.time <= HIDDEN * time:
            if last.kind in {ENTRY, PRESS}:
                last.after = after
                return
            if last.kind in OF_FRICTION:
                self.events.remove(last)
                before = last.before
                if after == before:
                    return
                kind = ROLL if after == ROLLS else REVERSE
        self.events.append(
            Event(time, number, kind, self.machine.reported(time, state).copy(), before, after)
        )
