"""The witness of the compiled core: a rotor system by CVODE, in plain Python.

The equations of `rotor_ida.systems.mechanics` as a first-order system, restarted at every root of a
guard. Nothing is shared with the Taylor series but the statement of the model.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.core.interface import DONE, STOPPED
from rotor_ida.core.runs import Rows
from rotor_ida.core.systems import (
    EPISODE,
    FORCES,
    LEDGER,
    RACE,
    TOUCH,
    Standstill,
    SystemRequest,
    SystemResult,
)
from rotor_ida.simulation.integration import Integration
from rotor_ida.simulation.orbit import (
    ENTRY,
    EXIT,
    FLIES,
    IS_LOOSE,
    PRESS,
    RELEASE,
    REVERSE,
    ROLL,
    ROLLS,
    SLIP,
)
from rotor_ida.simulation.spin import SpeedProfile
from rotor_ida.systems.following import Followed, check_status, compared, follow_system_again
from rotor_ida.systems.mechanics import SystemInMotion, pressed_way, settle

# Points of a step at which guards are looked at.
LOOKS = 8
# Tolerances of CVODE over those of the run.
SAFETY = 0.1


@dataclass(slots=True)
class _Records:
    """What is recorded of a run: events, samples, and contacts."""

    times: list[float] = field(default_factory=list)
    kinds: list[int] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    states: list[Values] = field(default_factory=list)
    samples: list[Values] = field(default_factory=list)
    forces: list[Values] = field(default_factory=list)
    episodes: list[tuple[float, float, float]] = field(default_factory=list)
    entries: dict[int, float] = field(default_factory=dict)
    standstill: Standstill = field(default_factory=lambda: Standstill(0.0))
    reached: float = 0.0


def _begin(run: SystemInMotion, records: _Records, state: Values) -> None:
    """Decide the modes at the start."""
    for i in range(len(run.ways)):
        run.ways[i] = ROLLS if run.mobility(i) else 1
        touch = run.touch(i, 0.0, state)
        pushed = touch.depth > 0.0 or (touch.depth == 0.0 and touch.approach > 0.0)
        if not pushed:
            run.ways[i] = FLIES
            continue
        run.ways[i] = pressed_way(run, i, touch)
        if touch.factor < 0.0:
            run.ways[i] = IS_LOOSE
        records.entries[i] = np.nan
    settle(run, 0.0, state)


def _record(
    run: SystemInMotion, records: _Records, time: float, kind: int, number: int, state: Values
) -> None:
    records.times.append(time)
    records.kinds.append(kind)
    records.numbers.append(number)
    records.states.append(run.filled(time, state))


def _settle(
    run: SystemInMotion, records: _Records, time: float, state: Values, besides: int = -1
) -> None:
    """Decide which contacts go on rolling; record those that slip, besides one."""
    before = list(run.ways)
    settle(run, time, state)
    for number, was in enumerate(before):
        if number != besides and was == ROLLS and run.ways[number] != ROLLS:
            _record(run, records, time, SLIP, number, state)


def _change(
    run: SystemInMotion, records: _Records, time: float, number: int, guard: int, state: Values
) -> None:
    """Do what follows from a guard that has fallen to 0, and record it."""
    way, touch = run.ways[number], run.touch(number, time, state)
    kind = 0
    if guard == 0 and way == FLIES:
        run.ways[number], kind = pressed_way(run, number, touch), ENTRY
        records.entries[number] = time
    elif guard == 0:
        run.ways[number], kind = FLIES, EXIT
        records.episodes.append((number, records.entries.pop(number), time))
    elif guard == 1 and way == IS_LOOSE:
        run.ways[number], kind = pressed_way(run, number, touch), PRESS
    elif guard == 1:
        run.ways[number], kind = IS_LOOSE, RELEASE
    elif way == ROLLS:
        run.ways[number], kind = (1 if run.holds(time, state)[number] > 0.0 else -1), SLIP
        _record(run, records, time, kind, number, state)
        return
    else:
        run.ways[number] = ROLLS
    _settle(run, records, time, state, besides=number)
    if kind == 0 and run.ways[number] != way:
        kind = ROLL if run.ways[number] == ROLLS else REVERSE
    if kind:
        _record(run, records, time, kind, number, state)


def _first_crossing(
    run: SystemInMotion, motion: Integration, limit: float
) -> tuple[float, int, int] | None:
    """Return time, contact and guard of the first fall through 0 in the last step."""
    high = min(motion.high, limit)
    points = np.linspace(motion.low, high, LOOKS + 1)
    before = run.guards(motion.low, motion.at(motion.low))
    for low, point in pairwise(points.tolist()):
        after = run.guards(point, motion.at(point))
        falls = np.argwhere((before > 0.0) & (after <= 0.0))
        found = [
            (motion.root(run.guard_of(int(i), int(g)), low, point), int(i), int(g))
            for i, g in falls
        ]
        if found:
            return min(found)
        before = after
    return None


def _sample(run: SystemInMotion, records: _Records, motion: Integration, until: float) -> None:
    """Report the samples of a step up to a time."""
    times = run.request.times
    while len(records.samples) < times.size:
        time = float(times[len(records.samples)])
        if time > until:
            break
        state = motion.at(time)
        records.samples.append(run.filled(time, state))
        holds = run.holds(time, state)
        rows = np.zeros((len(run.ways), FORCES))
        for i, way in enumerate(run.ways):
            touch = run.touch(i, time, state)
            push = touch.push(way)
            slides = run.request.laws[i]["friction"] * way * push if abs(way) == 1 else 0.0
            drag = holds.get(i, slides)
            rows[i] = push, drag, np.nan if way == FLIES else touch.slip, way
        records.forces.append(rows)


def _look_for_standstill(
    run: SystemInMotion, records: _Records, motion: Integration, until: float
) -> None:
    """Keep since when the speed has stayed below its limit, up to a time of a step."""
    limit = run.request.standing
    if limit == 0.0:
        return

    def beyond(time: float, state: Values) -> float:
        return abs(run.spin(time, state)[1]) - limit

    for low, high in pairwise(np.linspace(motion.low, until, LOOKS + 1).tolist()):
        is_below = beyond(high, motion.at(high)) <= 0.0
        if is_below == (beyond(low, motion.at(low)) <= 0.0):
            continue
        time, found = motion.root(beyond, low, high), records.standstill
        rates = np.empty_like(state := motion.at(time))
        run.rates(time, state, rates)
        longest = found.longest if is_below else max(found.longest, time - found.since)
        since = time if is_below else math.nan
        records.standstill = Standstill(limit, since, float(rates[-1]), longest)


def run_by_cvode(
    request: SystemRequest, profile: SpeedProfile, rtol: float, method: str, stop: Stop,
    watch: Watch,
) -> SystemResult:  # fmt: skip
    """Return the run of a rotor system by CVODE."""
    n, contacts = len(request.force), len(request.laws)
    run = SystemInMotion(request, profile, [FLIES] * contacts)
    records = _Records(standstill=Standstill(request.standing))
    scale = np.concatenate([
        np.full(n, request.displacement), np.full(n, request.velocity),
        np.full(contacts, request.velocity / request.displacement), [1.0, 1.0],
    ])  # fmt: skip
    state = np.concatenate([request.start.ravel(), request.races, [profile.angle, request.speed]])
    _begin(run, records, state)
    watch.append(lambda: records.reached)
    time, last = 0.0, len(profile.ends) - 1

    def scaled(at: float, values: Values, out: Values) -> None:
        run.rates(at, values * scale, out)
        out /= scale

    while time < request.duration:
        if stop[0]:
            return _result(run, records, STOPPED, time, state)
        limit = min(profile.ends[run.piece], request.duration)
        motion = _Scaled(
            method, scaled, (SAFETY * rtol, SAFETY * rtol), time, state / scale, goal=limit,
            scale=scale,
        )  # fmt: skip
        while True:
            motion.advance()
            found = _first_crossing(run, motion, limit)
            until = found[0] if found else min(motion.high, limit)
            _sample(run, records, motion, until)
            _look_for_standstill(run, records, motion, until)
            records.reached = until
            if found or motion.high >= limit or stop[0]:
                break
        time, state = until, motion.at(until)
        if found:
            _change(run, records, time, found[1], found[2], state)
        elif run.piece < last:
            run.piece += 1
            _settle(run, records, time, state)
    return _result(run, records, DONE, time, state)


class _Scaled(Integration):
    """An integration whose states are read in their own units."""

    def __init__(self, *arguments: object, scale: Values, **keywords: object) -> None:
        super().__init__(*arguments, **keywords)  # type: ignore[arg-type]
        self._scale = scale

    def at(self, time: float) -> Values:
        """Return the state at a time of the last step."""
        return np.asarray(super().at(time) * self._scale)


def _extremes(speeds: Values, times: Values) -> Rows:
    """Return the extreme speeds of races, a column each, among those at some times."""
    races = np.zeros(speeds.shape[1], RACE)
    for name, places in (("largest", speeds.argmax(axis=0)), ("smallest", speeds.argmin(axis=0))):
        races[name], races[f"{name}_time"] = speeds[places, np.arange(places.size)], times[places]
    return races


def _result(
    run: SystemInMotion, records: _Records, status: int, time: float, state: Values
) -> SystemResult:
    """Return a run in the form of the core's."""
    n, count = run.size, len(run.ways)
    state = run.filled(time, state)
    events = np.array(records.states).reshape(-1, len(state))
    samples = np.array(records.samples).reshape(-1, len(state))
    touches = np.zeros(count, TOUCH)
    touches["way"], touches["race"] = run.ways, state[2 * n : 2 * n + count]
    episodes = [*records.episodes, *((i, entry, np.nan) for i, entry in records.entries.items())]
    table = np.full(len(episodes), np.nan, EPISODE)
    for row, each in zip(table, episodes, strict=True):
        row["contact"], row["entry"], row["exit"] = each
    of_races = slice(2 * n, 2 * n + count)
    speeds = np.vstack([run.request.races, samples[:, of_races], events[:, of_races],
                        state[of_races]])  # fmt: skip
    seen = np.concatenate([[0.0], run.request.times[: len(samples)], records.times, [time]])
    turns = [run.spin(t, s) for t, s in zip(run.request.times, samples, strict=False)]
    of_events = [run.spin(t, s) for t, s in zip(records.times, events, strict=True)]
    return SystemResult(
        status=status, time=time, state=state[: 2 * n].reshape(2, n), touches=touches,
        samples=samples[:, : 2 * n].reshape(-1, 2, n), forces=np.array(records.forces),
        turns=np.array(turns).reshape(-1, 2), event_times=np.array(records.times),
        event_kinds=np.array(records.kinds, np.int32),
        event_contacts=np.array(records.numbers, np.int32),
        event_turns=np.array(of_events).reshape(-1, 2),
        event_states=events[:, : 2 * n].reshape(-1, 2, n),
        event_races=events[:, of_races], races=_extremes(speeds, seen), episodes=table,
        ledger=dict.fromkeys(LEDGER, np.nan), steps=0, turn=run.spin(time, state),
        standstill=records.standstill,
    )  # fmt: skip


def follow_by_cvode(
    request: SystemRequest, profile: SpeedProfile, rtol: float, method: str, stop: Stop,
    watch: Watch,
) -> Followed:  # fmt: skip
    """Return a run by CVODE; its errors are its differences from a run by Taylor series."""
    result = run_by_cvode(request, profile, rtol, method, stop, watch)
    check_status(result)
    bare = replace(request, times=request.times[[-1]], only_events=True)
    other = follow_system_again(bare, stop, watch)
    return compared(result, other, request)
