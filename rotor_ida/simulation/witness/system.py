"""A rotor system by the witness, in the form of the core's results."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.core.interface import DONE, MESSAGES, SINGULAR
from rotor_ida.core.runs import Rows
from rotor_ida.core.system_requests import (
    EPISODE,
    FORCES,
    LEDGER,
    RACE,
    TOUCH,
    Standstill,
    SystemRequest,
    SystemResult,
)
from rotor_ida.errors import SimulationError
from rotor_ida.model.contact import HERTZ_EXPONENT
from rotor_ida.schema.flags import ENTRY, EXIT, FLIES
from rotor_ida.simulation.spin import SpeedProfile
from rotor_ida.simulation.witness.bodies import Coordinates, Film, Law
from rotor_ida.simulation.witness.events import LOOKS
from rotor_ida.simulation.witness.integration import Integration
from rotor_ida.simulation.witness.run import Run

# Tolerances of CVODE over those of the run.
SAFETY = 0.1
# Slower, in parts of the scale of velocity, surfaces do not slide.
STILL = 1e-9


@dataclass(slots=True)
class _Records:
    """What is recorded of a run besides its events: samples, and contacts."""

    run: Run
    request: SystemRequest
    standstill: Standstill
    samples: list[Values] = field(default_factory=list)
    forces: list[Values] = field(default_factory=list)
    episodes: list[tuple[float, float, float]] = field(default_factory=list)
    entries: dict[int, float] = field(default_factory=dict)

    def step(self, motion: Integration, _turns: list[list[float]], end: float) -> None:
        """Record the samples of the last step up to a time."""
        run, times = self.run, self.request.times
        while len(self.samples) < times.size:
            time = float(times[len(self.samples)])
            if time > end:
                break
            state = motion.at(time)
            touches = run.machine.forces(time, state).touches
            rows = np.zeros((len(touches), FORCES))
            for i, (mode, touch) in enumerate(zip(run.machine.modes, touches, strict=True)):
                rows[i] = (
                    (touch.push, touch.drag, touch.slip, mode) if touch else (0, 0, np.nan, mode)
                )
            self.forces.append(rows)
            self.samples.append(run.machine.reported(time, state))
        self._look_for_standstill(motion, end)

    def event(self, number: int, kind: int, time: float, _state: Values) -> None:
        """Begin a contact, or record it."""
        if kind == ENTRY:
            self.entries[number] = time
        if kind == EXIT:
            self.episodes.append((number, self.entries.pop(number), time))

    def _look_for_standstill(self, motion: Integration, until: float) -> None:
        """Keep since when the speed has stayed below its limit, up to a time of a step."""
        limit, machine = self.request.standing, self.run.machine
        if limit == 0.0:
            return

        def beyond(time: float) -> float:
            return abs(float(machine.spin.at(time, motion.at(time))[1])) - limit

        for low, high in pairwise(np.linspace(motion.low, until, LOOKS + 1).tolist()):
            is_below = beyond(high) <= 0.0
            if is_below == (beyond(low) <= 0.0):
                continue
            time, found = motion.root(beyond, low, high), self.standstill
            longest = found.longest if is_below else max(found.longest, time - found.since)
            rate = machine.forces(time, motion.at(time)).faster
            since = time if is_below else math.nan
            self.standstill = Standstill(limit, since, rate, longest)


def run_system(
    request: SystemRequest, profile: SpeedProfile, rtol: float, method: str, stop: Stop,
    watch: Watch,
) -> SystemResult:  # fmt: skip
    """Return the run of a rotor system by CVODE."""
    body, count = _body_of(request), len(request.laws)
    spin = [profile.angle, request.speed] if profile.is_driven else []
    state = np.concatenate([request.start.ravel(), request.races, spin])
    sizes = [request.displacement, request.velocity, request.velocity / request.displacement, 1.0]
    scale = np.repeat(sizes, [body.size, body.size, count, len(spin)])
    try:
        run = Run(
            body_at=lambda _: body, profile=profile, state=state, duration=request.duration,
            method=method, tolerances=(SAFETY * rtol, SAFETY * rtol * scale), stop=stop,
        )  # fmt: skip
        records = _Records(run, request, Standstill(request.standing))
        records.entries = {i: np.nan for i, mode in enumerate(run.began) if mode != FLIES}
        watch.append(lambda: run.time)
        run.follow(records)
    except (ZeroDivisionError, np.linalg.LinAlgError) as error:
        raise SimulationError(MESSAGES[SINGULAR]) from error
    return _result_of(records)


def _body_of(request: SystemRequest) -> Coordinates:
    """Return the coordinates of a system, and its contacts in plain numbers."""
    inert, laws = len(request.force) - request.massless, []
    for each, rows in zip(request.laws, request.rows, strict=True):
        is_hertz = each["hertz"] != 0.0
        numbers = {
            "clearance": each["clearance"], "damping": each["contact_damping"],
            "stiffness": each["hertz" if is_hertz else "linear"],
            "exponent": HERTZ_EXPONENT if is_hertz else 1.0, "friction": each["friction"],
            "radius": each["radius"], "race_radius": each["race_radius"],
            "race_mobility": each["inverse_race_inertia"], "race_drag": each["race_drag"],
            "mobility": rows[0, inert:] @ rows[0, inert:],
        }  # fmt: skip
        floats = {name: float(value) for name, value in numbers.items()}
        laws.append(Law(**floats, race=int(each["race"])))
    return Coordinates(
        **{name: getattr(request, name) for name in (
            "stiffness", "damping", "gyroscopic", "stiffness_rate", "rows", "unbalance", "force",
            "inertia", "massless",
        )},
        offsets=request.laws["offset"], moment=request.weight, laws=laws,
        still=STILL * request.velocity,
        films=[
            Film(rows, *(PchipInterpolator(each.speed, getattr(each, name)) for name in
                         ("stiffness", "damping")))
            for each, rows in zip(request.films.bearings, request.films.rows, strict=True)
        ],
    )  # fmt: skip


def _extremes(speeds: Values, times: Values) -> Rows:
    """Return the extreme speeds of races, a column each, among those at some times."""
    races = np.zeros(speeds.shape[1], RACE)
    for name, places in (("largest", speeds.argmax(axis=0)), ("smallest", speeds.argmin(axis=0))):
        races[name], races[f"{name}_time"] = speeds[places, np.arange(places.size)], times[places]
    return races


def _result_of(records: _Records) -> SystemResult:
    """Return a run in the form of the core's."""
    run, request = records.run, records.request
    n, count = len(request.force), len(request.laws)
    of_races, machine = slice(2 * n, 2 * n + count), run.machine
    state = machine.reported(run.time, run.state)
    events = np.array([each.state for each in run.events]).reshape(-1, len(state))
    samples = np.array(records.samples).reshape(-1, len(state))
    event_times = np.array([each.time for each in run.events])
    touches = np.zeros(count, TOUCH)
    touches["mode"], touches["race"] = machine.modes, state[of_races]
    episodes = [*records.episodes, *((i, entry, np.nan) for i, entry in records.entries.items())]
    table = np.full(len(episodes), np.nan, EPISODE)
    for row, each in zip(table, episodes, strict=True):
        row["contact"], row["entry"], row["exit"] = each
    parts = [request.races[np.newaxis], samples[:, of_races], events[:, of_races]]
    speeds = np.vstack([*parts, state[of_races]])
    seen = np.concatenate([[0.0], request.times[: len(samples)], event_times, [run.time]])
    turns = [
        run.profile.spins_at(times, rows)
        for times, rows in ((request.times[: len(samples)], samples), (event_times, events))
    ]
    of_samples, of_events = (np.column_stack([each["angle"], each["speed"]]) for each in turns)
    return SystemResult(
        status=DONE, time=run.time, state=state[: 2 * n].reshape(2, n), touches=touches,
        samples=samples[:, : 2 * n].reshape(-1, 2, n), forces=np.array(records.forces),
        turns=of_samples, event_times=event_times,
        event_kinds=np.array([each.kind for each in run.events], np.int32),
        event_contacts=np.array([each.number for each in run.events], np.int32),
        event_turns=of_events, event_states=events[:, : 2 * n].reshape(-1, 2, n),
        event_races=events[:, of_races], event_rates=np.full(len(events), np.nan),
        races=_extremes(speeds, seen), episodes=table,
        ledger=dict.fromkeys(LEDGER, np.nan), steps=0,
        turn=machine.spin.at(run.time, state), standstill=records.standstill,
    )  # fmt: skip
