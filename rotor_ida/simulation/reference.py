"""The reference simulator of ``backend="python"``: the paper's equations in plain Python.

It shares only the stated model with the compiled core. CVODE or IDA integrates a first-order
system in displacement and velocity, through the public interface of scikit-sundae. Entry and exit
are found as roots of |z| = delta0, and the integration is restarted there, as the force has a
kink. Flight is integrated like a contact, without a closed form.

    decide the mode at the start: flight, pressed contact, or contact loosened by damping;
    with friction a pressed contact slides forwards, slides backwards, or rolls;
    integrate inside the mode, step by step;
    look for a crossing at the end of a step, and at an extremum of the radius inside it;
    find it as a root, record it, and restart in the mode that follows.

The solver's own root functions are not used: events would depend on the sample times, and a root
function for extrema of the radius would respond to rounding on a steady whirl.
A crossing and its opposite are missed where no step ends between them and the radius has two
extrema in one step, or where the touch is too slight for the tolerance.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from sksundae.cvode import CVODE
from sksundae.ida import IDA

from rotor_ida.arrays import ROUNDING, Stop, Values
from rotor_ida.checks import State
from rotor_ida.core.interface import MESSAGES, RUNAWAY, STALLED
from rotor_ida.core.runs import EXTREMUM
from rotor_ida.errors import SimulationError
from rotor_ida.model.contact import force_over_radius
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.mechanics import (
    BACKWARDS,
    FLIGHT,
    FORWARDS,
    HEAT,
    HIDDEN,
    IMPULSE,
    LOOSE,
    LOST,
    ROLLING,
    SLID,
    SLIDING,
    VX,
    VY,
    Rates,
    SpinningRotor,
    X,
    Y,
    energy_of,
    first_state,
    force_of,
    hidden_hold,
    hidden_slip,
    hold_of,
    hold_of_rolling,
    mode_of_start,
    pressed_mode,
    radial_rate_of,
    radius_of,
    rates_of,
    rolled,
    slip_of,
)
from rotor_ida.simulation.options import LARGEST, Options
from rotor_ida.simulation.orbit import (
    ENTRY,
    EXIT,
    ORBIT_CONTACT,
    PRESS,
    RELEASE,
    REVERSE,
    ROLL,
    SLIP,
    Orbit,
    SpeedRecord,
)
from rotor_ida.simulation.spin import GAINED, SPEED, SpeedProfile, steady

Function = Callable[[float, Values], float]

# Fractions of a step checked for a release, a press, the largest force, and a speed below 0.
LOOKS = 4
# SUNDIALS may need a few calls for a step: after a reading the first one only returns to its end.
MOST_IDLE_STEPS = 100


# ---- The solver ----


class Integration:
    """A solver of scikit-sundae: one internal step at a time, and any time inside the last.

    Its `step` takes one internal step with ``"onestep"``, and reads the solver's own interpolant
    with ``"normal"`` at a time inside that step. After such a reading the next ``"onestep"``
    returns the end of the step once more, which `advance` passes over.

    Parameters
    ----------
    method : {"adams", "bdf", "ida"}
        CVODE with Adams or BDF, or IDA.
    rates : callable
        ``rates(time, state, rate)`` writes the rate of change.
    tolerances : tuple of float
        Relative and absolute tolerance of one step.
    time, state : float and ndarray
        Where it begins.
    goal : float
        A time to step towards, which limits only the first step.

    Attributes
    ----------
    low, high : float
        The times at both ends of the last step.
    before, after : ndarray
        The states there.
    """

    def __init__(
        self,
        method: str,
        rates: Rates,
        tolerances: tuple[float, float],
        time: float,
        state: Values,
        *,
        goal: float,
    ) -> None:
        # SUNDIALS would write its warnings to standard output.
        os.environ.setdefault("SUNLOGGER_WARNING_FILENAME", os.devnull)
        settings = {"rtol": tolerances[0], "atol": tolerances[1]}
        rate = np.empty_like(state)
        self._solver: Any
        if method == "ida":

            def residual(time: float, state: Values, slope: Values, out: Values) -> None:
                rates(time, state, rate)
                np.subtract(slope, rate, out=out)

            self._solver = IDA(residual, **settings)
            rates(time, state, rate)
            self._solver.init_step(time, state, rate.copy())
        else:
            name = {"adams": "Adams", "bdf": "BDF"}[method]
            self._solver = CVODE(rates, method=name, **settings)
            self._solver.init_step(time, state)
        self._goal = goal
        self.low = self.high = time
        self.before = self.after = state
        self.evaluations = 0

    def advance(self) -> None:
        """Take one internal step, or raise `SimulationError`."""
        self.low, self.before = self.high, self.after
        for _ in range(MOST_IDLE_STEPS):
            found = self._solver.step(self._goal, "onestep")
            if not found.success:
                raise self.failure(str(found.message).strip())
            if not np.isfinite(found.y).all():
                raise self.failure("the state is no longer finite")
            self.high, self.after, self.evaluations = float(found.t), found.y, int(found.nfev)
            if self.high > self.low:
                return
        raise self.failure("time no longer advances")

    def at(self, time: float) -> Values:
        """Return the state at a time of the last step."""
        if time <= self.low or time >= self.high:
            return self.before if time <= self.low else self.after
        found = self._solver.step(time, "normal")
        if not found.success:
            raise self.failure(str(found.message).strip())
        state: Values = found.y
        return state

    def root(self, function: Function, low: float, high: float) -> float:
        """Return the zero, in the last step, of a function of time and state that changes sign."""
        spacing = 4.0 * ROUNDING
        return float(
            brentq(
                lambda time: function(time, self.at(time)), low, high, xtol=spacing, rtol=spacing
            )
        )

    def failure(self, message: str, time: float | None = None) -> SimulationError:
        """Return the error that ends the run, at a time of the last step or at its beginning."""
        ended = self.low if time is None else time
        x, y, vx, vy = self.at(ended)[:IMPULSE].tolist()
        return SimulationError(message, time=ended, state=(x, y, vx, vy))


# ---- The run ----


@dataclass(slots=True)
class _Run:
    """A run in progress: its request, and its records.

    Samples and events are rows of time and state, contacts those of `Orbit`, and `turns` rows of
    time, kind (-1 or 1) and state of the extrema of the radius.
    """

    rotor: Rotor
    profile: SpeedProfile
    options: Options
    tolerances: tuple[float, float]
    duration: float
    sample_times: list[float]
    stop: Stop | None
    samples: list[Values] = field(default_factory=list)
    events: list[tuple[float, int, Values]] = field(default_factory=list)
    contacts: list[tuple[float, ...]] = field(default_factory=list)
    turns: list[tuple[float, float, Values]] = field(default_factory=list)
    ways: list[int] = field(default_factory=list)
    evaluations: int = 0
    ended: float = 0.0

    def spinning_rotor_at(self, time: float) -> SpinningRotor:
        """Return the rotor with its spin from a time on."""
        return SpinningRotor(self.rotor, self.profile.spins[self.profile.piece_from(time)])


@dataclass(slots=True)
class _Contact:
    """A contact in progress: its entry, its largest indentation, its largest force."""

    entry: float
    time: float  # of the peak
    state: Values  # there
    force: float = 0.0

    def pass_by(self, time: float, state: Values) -> None:
        """Record a point if it is the peak so far."""
        if radius_of(state) > radius_of(self.state):
            self.time, self.state = time, state

    def feel(self, rotor: Rotor, motion: Integration, end: float) -> None:
        """Look for the largest force in a step of a damped contact."""
        apart = (end - motion.low) / LOOKS
        forces = [force_of(rotor, motion.at(motion.low + apart * k)) for k in range(LOOKS + 1)]
        best = max(range(LOOKS + 1), key=forces.__getitem__)
        if forces[best] > 0.5 * self.force:
            low, high = (motion.low + apart * min(max(k, 0), LOOKS) for k in (best - 1, best + 1))
            found = minimize_scalar(
                lambda time: -force_of(rotor, motion.at(time)),
                bounds=(low, high), method="bounded", options={"xatol": 1e-9 * (high - low)},
            )  # fmt: skip
            self.force = max(self.force, forces[best], -float(found.fun))


def run_reference(
    rotor: Rotor,
    start: State,
    duration: float,
    sample_times: Values,
    options: Options,
    *,
    tolerances: tuple[float, float],
    slack: float,
    stop: Stop | None,
    profile: SpeedProfile | None = None,
) -> Orbit:
    """Simulate as `rotor_ida.simulation.run.run`, with the tolerances of a step.

    With a `profile` the speed changes accordingly.
    """
    profile = profile or steady(rotor.omega, duration)
    run = _Run(rotor, profile, options, tolerances, duration, sample_times.tolist(), stop)
    spinning = run.spinning_rotor_at(0.0)
    mode = began = mode_of_start(spinning, start)
    run.ways.append(began)
    contact = _Contact(math.nan, 0.0, first_state(spinning, start))
    time, state, event = 0.0, contact.state, ENTRY
    while event and time < duration:
        if event == ENTRY:
            contact = _Contact(contact.entry, time, state)
        time, state, event = _follow_mode(run, time, state, contact, slack, mode)
        if event:
            mode = _record_event(run, time, event, state)
        if event == EXIT or (not event and mode != FLIGHT):
            _record_contact(run, contact, time if event else math.nan, state)
        if event in {ENTRY, EXIT}:
            state[IMPULSE:GAINED] = 0.0
            contact.entry = time if event == ENTRY else math.nan
    if event and mode != FLIGHT:  # it touches, or changes its mode, as the run ends
        ending = _Contact(contact.entry, time, state) if event == ENTRY else contact
        _record_contact(run, ending, math.nan, state)
    run.ended = time
    return _orbit_of(run, start, state, began=began != FLIGHT)


def _follow_mode(
    run: _Run, time: float, state: Values, contact: _Contact, slack: float, mode: int
) -> tuple[float, Values, int]:
    """Follow one mode until it ends or the run does; return time, state and event.

    The integration restarts where a piece of the profile ends: the angular acceleration may jump.
    """
    event = 0
    while not event and time < run.duration:
        piece = run.profile.piece_from(time)
        last = piece == len(run.profile.ends) - 1
        end = run.duration if last else run.profile.ends[piece]
        reach = (end, slack if last else 0.0)
        time, state, event = _follow_piece(run, time, state, contact, reach, mode)
    return time, state, event


def _follow_piece(
    run: _Run,
    time: float,
    state: Values,
    contact: _Contact,
    reach: tuple[float, float],
    mode: int,
) -> tuple[float, Values, int]:
    """Follow one mode to the end of a piece; an event may lie a slack after that."""
    spinning, (until, slack) = run.spinning_rotor_at(time), reach
    rates = rates_of(spinning, mode)
    motion = Integration(
        run.options.method, rates, run.tolerances, time, state, goal=time + run.duration
    )
    end, event = time, 0
    while not event and end < until:
        if run.stop is not None and run.stop[0]:
            raise motion.failure("interrupted")
        motion.advance()
        turns = _turns_in(motion, LOOKS if mode == FLIGHT else 1)
        crossing = _crossing_in(motion, turns, run.rotor.delta0, in_contact=mode != FLIGHT)
        change, kind = _change_in(motion, spinning, mode)
        first = min(crossing, change)
        if first <= until + slack:
            ends = EXIT if mode != FLIGHT else ENTRY
            event = ends if crossing <= change else kind
        end = first if event else min(motion.high, until)
        if state.size > SPEED:
            _check_speed(motion, rates, end)
        for candidate in (*turns, end):
            if candidate <= end:
                contact.pass_by(candidate, motion.at(candidate))
        if mode not in {FLIGHT, LOOSE} and run.rotor.contact_damping > 0.0:
            contact.feel(run.rotor, motion, end)
        _record_step(run, spinning, motion, turns, end, mode)
    run.evaluations += motion.evaluations
    state = motion.at(end).copy()
    if mode == ROLLING or event == ROLL:
        state = rolled(spinning, end, state)
    if event in {ENTRY, EXIT}:
        state[:VX] *= run.rotor.delta0 / radius_of(state)
    return end, state, event


def _record_event(run: _Run, time: float, event: int, state: Values) -> int:
    """Record an event, and return the mode that follows.

    A friction event at the time of the previous event, but for rounding, is merged with it.
    """
    spinning = run.spinning_rotor_at(time)
    mode = {EXIT: FLIGHT, RELEASE: LOOSE}.get(event, ROLLING)
    if event in {ENTRY, PRESS, ROLL}:
        mode = pressed_mode(spinning, time, state, 0.0 if event == ROLL else None)
    elif event == SLIP:
        mode = FORWARDS if hold_of_rolling(spinning, time, state) > 0.0 else BACKWARDS
    if event == ROLL and mode != ROLLING:
        event = REVERSE if mode == -run.ways[-1] else 0  # or only touched
    last = run.events[-1][1] if run.events else 0
    if event in {ROLL, SLIP, REVERSE} and last and time - run.events[-1][0] <= HIDDEN * time:
        if last in {ENTRY, PRESS}:
            event = 0
        elif last in {ROLL, SLIP, REVERSE}:
            run.events.pop()
            run.ways.pop()
            turned = mode != run.ways[-1] and mode != ROLLING
            event = 0 if mode == run.ways[-1] else REVERSE if turned else ROLL
        if not event:
            run.ways[-1] = mode
    elif event in {ROLL, SLIP, REVERSE} and not last and time <= _next(0.0):
        event, run.ways[-1] = 0, mode  # so it began
    if event:
        run.events.append((time, event, state))
        run.ways.append(mode)
    return mode


def _change_in(motion: Integration, spinning: SpinningRotor, mode: int) -> tuple[float, int]:
    """Return when in the last step the contact changes its mode, or infinity; and its event.

    It comes loose, or presses again; surfaces stop sliding; or the disc begins to slip.
    """
    first = (math.inf, 0)
    for within, event, hidden in _guards(motion, spinning, mode):
        time = _first_below(motion, within, hidden)
        if event == ROLL and time == _next(motion.low) and _drives_on(motion, spinning, mode):
            continue
        if time < first[0]:
            first = (time, event)
    return first


def _drives_on(motion: Integration, spinning: SpinningRotor, mode: int) -> bool:
    """Return whether surfaces without slip at the start of a step continue to slide as before.

    After a slip their speed grows like the square of time: the error of a step may exceed it.
    """
    return pressed_mode(spinning, motion.low, motion.before, 0.0) == mode


def _next(time: float) -> float:
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
            return _next(low)
    return math.inf


def _check_speed(motion: Integration, rates: Rates, end: float) -> None:
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


def _turns_in(motion: Integration, looks: int) -> list[float]:
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


def _crossing_in(
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
            return _next(low)  # it left as soon as it entered
    return math.inf


def _record_step(
    run: _Run,
    spinning: SpinningRotor,
    motion: Integration,
    turns: list[float],
    end: float,
    mode: int,
) -> None:
    """Record the samples of the last step up to its end, and the extrema of the radius."""

    def read(time: float) -> Values:
        state = motion.at(time)
        return rolled(spinning, time, state) if mode == ROLLING else state

    while len(run.samples) < len(run.sample_times) and run.sample_times[len(run.samples)] <= end:
        run.samples.append(read(run.sample_times[len(run.samples)]))
    rising = radial_rate_of(motion.before) > 0.0
    for turn in turns:
        if turn <= end:
            run.turns.append((turn, 1.0 if rising else -1.0, read(turn)))
        rising = not rising


def _record_contact(run: _Run, contact: _Contact, leaving: float, end: Values) -> None:
    """Record a contact; only a whole one has an impulse."""
    peak = contact.state
    moment = float(peak[X] * peak[VY] - peak[Y] * peak[VX])
    depth = max(radius_of(peak) - run.rotor.delta0, 0.0)
    impulse = float(end[IMPULSE]) if math.isfinite(contact.entry + leaving) else math.nan
    lost, heat, slid = (float(end[each]) if end.size > each else 0.0 for each in (LOST, HEAT, SLID))
    peak_force = contact.force
    run.contacts.append(
        (contact.entry, leaving, contact.time, depth, impulse, moment, lost, peak_force, heat, slid)
    )


def _orbit_of(run: _Run, start: State, end: Values, *, began: bool) -> Orbit:
    """Return the recorded orbit."""
    width = end.size
    times = np.array(run.sample_times)
    samples = np.array(run.samples).reshape(-1, width)
    event_times = np.array([time for time, _, _ in run.events])
    events = np.array([state for _, _, state in run.events]).reshape(-1, width)
    turns = np.array([state for _, _, state in run.turns]).reshape(-1, width)
    extrema = np.empty(len(run.turns), EXTREMUM)
    extrema["time"] = [time for time, _, _ in run.turns]
    extrema["radius"] = [radius_of(state) for _, _, state in run.turns]
    extrema["kind"] = [kind for _, kind, _ in run.turns]
    angles = run.rotor.omega * extrema["time"]
    record = None
    if width > GAINED:
        angles = run.profile.spins_at(extrema["time"], turns)["angle"]
        record = _speed_record_of(run, start, end, (times, samples), (event_times, events))
    extrema["state"] = rotated(turns[:, :IMPULSE], -angles)
    return Orbit(
        rotor=run.rotor,
        options=run.options,
        duration=run.duration,
        times=times,
        states=np.ascontiguousarray(samples[:, :IMPULSE]),
        starts_in_contact=began,
        event_times=event_times,
        event_kinds=np.array([kind for _, kind, _ in run.events], dtype=np.int8),
        event_states=np.ascontiguousarray(events[:, :IMPULSE]),
        contacts=np.array(run.contacts, ORBIT_CONTACT),
        end=end[:IMPULSE],
        evaluations=run.evaluations,
        steps=0,
        ways=np.array(run.ways, np.int8) if run.rotor.friction > 0.0 else None,
        extrema=extrema,
        speed_record=record,
    )


def _speed_record_of(
    run: _Run,
    start: State,
    end: Values,
    samples: tuple[Values, Values],
    events: tuple[Values, Values],
) -> SpeedRecord:
    """Return how the speed changed, and how well the energy balances."""
    first = run.spinning_rotor_at(0.0)
    last = SpinningRotor(run.rotor, run.profile.spins[-1])
    begun = energy_of(first, 0.0, first_state(first, start))
    ended = energy_of(last, run.ended, end)
    return SpeedRecord(
        profile=run.profile,
        samples=run.profile.spins_at(*samples),
        events=run.profile.spins_at(*events),
        end=run.profile.spins_at(np.array([run.ended]), end[np.newaxis])[0],
        energies=(begun, ended, float(end[GAINED])),
    )
