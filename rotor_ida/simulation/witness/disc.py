"""One disc by the witness, ``backend="python"``: its orbit."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize_scalar

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import State
from rotor_ida.core.interface import MESSAGES, RUNAWAY, STALLED
from rotor_ida.core.runs import CONTACT, EXTREMUM
from rotor_ida.model.contact import contact_potential
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema.flags import ENTRY, EXIT, FLIES, IS_LOOSE
from rotor_ida.simulation.options import LARGEST, Options
from rotor_ida.simulation.orbit import Orbit, SpeedRecord
from rotor_ida.simulation.spin import Driven, SpeedProfile, Spin, steady
from rotor_ida.simulation.witness.bodies import GAINED, HEAT, IMPULSE, LOST, SLID, Disc
from rotor_ida.simulation.witness.events import LOOKS
from rotor_ida.simulation.witness.integration import Integration
from rotor_ida.simulation.witness.run import Run


@dataclass(slots=True)
class _Contact:
    """A contact in progress: its entry, its largest indentation, its largest force."""

    entry: float
    time: float  # of the peak
    state: Values  # there
    radius: float = 0.0
    force: float = 0.0


@dataclass(slots=True)
class _Records:
    """The records of an orbit.

    Samples are states, contacts the rows of `Orbit`, and `turns` rows of time, kind (-1 or 1) and
    state of the extrema of the radius.
    """

    run: Run
    rotor: Rotor
    sample_times: list[float]
    contact: _Contact
    samples: list[Values] = field(default_factory=list)
    contacts: list[tuple[float, ...]] = field(default_factory=list)
    turns: list[tuple[float, float, Values]] = field(default_factory=list)

    def step(self, motion: Integration, turns: list[list[float]], end: float) -> None:
        """Record the samples of the last step up to a time, and the extrema of the radius."""
        contact, (mode,), read = self.contact, self.run.machine.modes, self.run.machine.reported
        if isinstance(self.run.machine.spin, Driven):
            _check_speed(motion, self.run, end)
        for place in (*turns[0], end):
            if place <= end:
                state = motion.at(place)
                radius = _radius_of(state)
                if radius > contact.radius:
                    contact.time, contact.state, contact.radius = place, state, radius
        if turns[0]:
            x, y, vx, vy, *_ = motion.before.tolist()
            kind = math.copysign(1.0, x * vx + y * vy)
            for turn in turns[0]:
                if turn <= end:
                    self.turns.append((turn, kind, read(turn, motion.at(turn))))
                kind = -kind
        if mode not in {FLIES, IS_LOOSE} and self.rotor.contact_damping > 0.0:
            self._look_for_force(motion, end)
        while len(self.samples) < len(self.sample_times):
            time = self.sample_times[len(self.samples)]
            if time > end:
                break
            self.samples.append(read(time, motion.at(time)))

    def event(self, _number: int, kind: int, time: float, state: Values) -> None:
        """Begin a contact, or record it."""
        if kind == EXIT:
            self.record_contact(time, state)
        if kind in {ENTRY, EXIT}:
            state[IMPULSE:GAINED] = 0.0
            entry = time if kind == ENTRY else math.nan
            self.contact = _Contact(entry, time, state.copy(), _radius_of(state))

    def _look_for_force(self, motion: Integration, end: float) -> None:
        """Look for the largest force in a step of a damped contact."""
        contact, machine = self.contact, self.run.machine

        def force(time: float) -> float:
            return max(float(motion.once(machine.touch, 0, time).push), 0.0)

        places = motion.looks(LOOKS, end)
        forces = [force(place) for place in places]
        best = max(range(LOOKS + 1), key=forces.__getitem__)
        most = max(abs(one - other) for one, other in pairwise(forces))  # by which it may rise
        if forces[best] + most > contact.force:
            low, high = (places[min(max(k, 0), LOOKS)] for k in (best - 1, best + 1))
            found = minimize_scalar(
                lambda time: -force(time),
                bounds=(low, high), method="bounded", options={"xatol": 1e-9 * (high - low)},
            )  # fmt: skip
            contact.force = max(contact.force, forces[best], -float(found.fun))

    def record_contact(self, leaving: float, end: Values) -> None:
        """Record a contact; without clearance its impulse is not known."""
        contact, peak = self.contact, self.contact.state
        moment = float(peak[0] * peak[3] - peak[1] * peak[2])
        root = math.sqrt(max(contact.radius - self.rotor.delta0, 0.0))
        impulse = float(end[IMPULSE]) if self.rotor.delta0 > 0.0 else math.nan
        lost, heat, slid = (
            float(end[each]) if end.size > each else 0.0 for each in (LOST, HEAT, SLID)
        )
        self.contacts.append(
            (contact.entry, leaving, contact.time, root, impulse, moment, lost, contact.force,
             heat, slid)
        )  # fmt: skip


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
    state = Disc(rotor, profile.spins[0]).first_state(start)
    run = Run(
        body_at=lambda piece: Disc(rotor, profile.spins[piece]), profile=profile, state=state,
        duration=duration, method=options.method, tolerances=tolerances, slack=slack, stop=stop,
    )  # fmt: skip
    first = _Contact(math.nan, 0.0, state, _radius_of(state))
    records = _Records(run, rotor, sample_times.tolist(), first)
    run.follow(records)
    if run.machine.modes[0] != FLIES:
        records.record_contact(math.nan, run.state)
    return _orbit_of(records, start, options)


def _radius_of(state: Values) -> float:
    return math.hypot(state[0], state[1])


def _check_speed(motion: Integration, run: Run, end: float) -> None:
    """Raise `SimulationError` where a driven speed leaves 0 to `LARGEST` in the last step."""
    rate = np.empty_like(motion.before)

    def growth(time: float) -> float:
        run.machine.rates(time, motion.at(time), rate)
        return float(rate[-1])

    def speed(time: float) -> float:
        return float(motion.at(time)[-1])

    low, apart = motion.low, (end - motion.low) / LOOKS
    for k in range(LOOKS):
        to = end if k == LOOKS - 1 else motion.low + apart * (k + 1)
        turns = growth(low) * growth(to) < 0.0
        for point in (motion.root(growth, low, to), to) if turns else (to,):
            if speed(point) < 0.0:
                stall = low if speed(low) <= 0.0 else motion.root(speed, low, point)
                raise motion.failure(MESSAGES[STALLED], stall)
            low = point
    if speed(end) > LARGEST:
        raise motion.failure(MESSAGES[RUNAWAY], end)


def _orbit_of(records: _Records, start: State, options: Options) -> Orbit:
    """Return the recorded orbit."""
    run, rotor = records.run, records.rotor
    width = run.state.size
    times, samples = np.array(records.sample_times), np.array(records.samples).reshape(-1, width)
    event_times = np.array([each.time for each in run.events])
    events = np.array([each.state for each in run.events]).reshape(-1, width)
    turns = np.array([state for _, _, state in records.turns]).reshape(-1, width)
    extrema = np.empty(len(turns), EXTREMUM)
    extrema["time"] = [time for time, _, _ in records.turns]
    extrema["radius"] = np.hypot(turns[:, 0], turns[:, 1])
    extrema["kind"] = [kind for _, kind, _ in records.turns]
    angles, record = rotor.omega * extrema["time"], None
    if width > GAINED:
        at = run.profile.spins_at
        angles = at(extrema["time"], turns)["angle"]
        first, last = (run.profile.spins[place] for place in (0, -1))
        begun = _energy_of(rotor, first, 0.0, Disc(rotor, first).first_state(start))
        ended = _energy_of(rotor, last, run.time, run.state)
        record = SpeedRecord(
            profile=run.profile, samples=at(times, samples), events=at(event_times, events),
            end=at(np.array([run.time]), run.state[np.newaxis])[0],
            energies=(begun, ended, float(run.state[GAINED])),
        )  # fmt: skip
    extrema["state"] = rotated(turns[:, :IMPULSE], -angles)
    modes = [*run.began, *(each.after for each in run.events)]
    return Orbit(
        rotor=rotor,
        options=options,
        duration=run.duration,
        times=times,
        states=np.ascontiguousarray(samples[:, :IMPULSE]),
        starts_in_contact=run.began[0] != FLIES,
        event_times=event_times,
        event_kinds=np.array([each.kind for each in run.events], dtype=np.int8),
        event_states=np.ascontiguousarray(events[:, :IMPULSE]),
        contacts=np.array(records.contacts, CONTACT),
        end=run.state[:IMPULSE],
        evaluations=run.evaluations,
        steps=0,
        modes=np.array(modes, np.int8) if rotor.friction > 0.0 else None,
        extrema=extrema,
        speed_record=record,
    )


def _energy_of(rotor: Rotor, spin: Spin, time: float, state: Values) -> float:
    """Return the energy of the motion of the centre of mass, the spin, the springs and the load."""
    x, y, vx, vy = state[:IMPULSE].tolist()
    angle, speed = spin.at(time, state)
    cos, sin = math.cos(angle), math.sin(angle)
    inertia = spin.inertia if isinstance(spin, Driven) else 0.0
    motion = (vx - speed * sin) ** 2 + (vy + speed * cos) ** 2 + inertia * speed**2
    springs = 0.5 * rotor.shaft_stiffness * (x * x + y * y)
    springs += float(contact_potential(math.hypot(x, y), rotor.delta0, rotor.contact_exponent))
    return float(0.5 * motion + springs + rotor.load * (y + sin))
