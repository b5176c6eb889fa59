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
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize_scalar

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import State
from rotor_ida.core.runs import EXTREMUM
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.integration import Integration
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
    VX,
    VY,
    SpinningRotor,
    X,
    Y,
    energy_of,
    first_state,
    force_of,
    hold_of_rolling,
    mode_of_start,
    pressed_mode,
    radial_rate_of,
    radius_of,
    rates_of,
    rolled,
)
from rotor_ida.simulation.options import Options
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
from rotor_ida.simulation.reference_events import (
    LOOKS,
    change_in,
    check_speed,
    crossing_in,
    next_time,
    turns_in,
)
from rotor_ida.simulation.spin import GAINED, SPEED, SpeedProfile, steady


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
        turns = turns_in(motion, LOOKS if mode == FLIGHT else 1)
        crossing = crossing_in(motion, turns, run.rotor.delta0, in_contact=mode != FLIGHT)
        change, kind = change_in(motion, spinning, mode)
        first = min(crossing, change)
        if first <= until + slack:
            ends = EXIT if mode != FLIGHT else ENTRY
            event = ends if crossing <= change else kind
        end = first if event else min(motion.high, until)
        if state.size > SPEED:
            check_speed(motion, rates, end)
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
    elif event in {ROLL, SLIP, REVERSE} and not last and time <= next_time(0.0):
        event, run.ways[-1] = 0, mode  # so it began
    if event:
        run.events.append((time, event, state))
        run.ways.append(mode)
    return mode


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
    """Record a contact; without clearance its impulse is not known."""
    peak = contact.state
    moment = float(peak[X] * peak[VY] - peak[Y] * peak[VX])
    depth = max(radius_of(peak) - run.rotor.delta0, 0.0)
    impulse = float(end[IMPULSE]) if run.rotor.delta0 > 0.0 else math.nan
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
