"""The witness of the compiled core: a rotor system by CVODE, in plain Python.

The same equations as a first-order system, restarted at every root of a guard. Nothing is shared
with the Taylor series but the statement of the model: forces are computed from positions, and
contacts have no variables of their own.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise, product

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
    SystemRequest,
    SystemResult,
)
from rotor_ida.errors import SimulationError
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
from rotor_ida.simulation.reference import Function, Integration
from rotor_ida.simulation.spin import SpeedProfile
from rotor_ida.systems.following import Followed, check_status, errors_of, follow_system_again

# Points of a step at which guards are looked at.
LOOKS = 8
# Tolerances of CVODE over those of the run.
SAFETY = 0.1
# Slower, in parts of the scale of velocity, surfaces do not slide.
STILL = 1e-9
# Largest number of contacts that stick at once for which all combinations are tried.
MOST_STUCK = 8


@dataclass(slots=True)
class Touch:
    """How a contact is at a state: indentation, directions, velocities and normal force.

    `held` is the tangential force that a stator without mass follows, where the surfaces roll.
    """

    depth: float
    normal: Values
    tangent: Values
    approach: float
    slip: float
    turning: float
    factor: float
    spring: float
    held: float = 0.0

    def push(self, way: int) -> float:
        """Return the normal force in a mode of motion."""
        return 0.0 if way in {FLIES, IS_LOOSE} else self.spring * self.factor


@dataclass(slots=True)
class _Run:
    """A run in progress; states are ``(y, v, races, angle, speed)``."""

    request: SystemRequest
    profile: SpeedProfile
    ways: list[int]
    piece: int = 0
    reached: float = 0.0
    times: list[float] = field(default_factory=list)
    kinds: list[int] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    states: list[Values] = field(default_factory=list)
    samples: list[Values] = field(default_factory=list)
    forces: list[Values] = field(default_factory=list)
    episodes: list[tuple[float, float, float]] = field(default_factory=list)
    entries: dict[int, float] = field(default_factory=dict)

    @property
    def size(self) -> int:
        return len(self.request.force)

    @property
    def inert(self) -> int:
        """How many coordinates have mass."""
        return self.size - self.request.massless

    def spin(self, time: float, state: Values) -> tuple[float, float]:
        """Return angle and speed."""
        if self.profile.is_driven:
            return float(state[-2]), float(state[-1])
        angle, speed = self.profile.spins[self.piece].at(time, state)
        return float(angle), float(speed)

    def touch(self, number: int, time: float, state: Values) -> Touch:
        """Return how a contact is at a state."""
        request, n = self.request, self.size
        law, rows = request.laws[number], request.rows[number]
        v = np.concatenate([state[n : n + self.inert], self.drift(state)])
        place, velocity = rows @ state[:n] - law["offset"], rows @ v
        radius = float(np.hypot(*place))
        normal = place / radius if radius > 0.0 else np.array([1.0, 0.0])
        tangent = np.array([-normal[1], normal[0]])
        approach, across = float(normal @ velocity), float(tangent @ velocity)
        rim = law["radius"] * self.spin(time, state)[1]
        slip = across + rim - law["race_radius"] * state[2 * n + number]
        depth = radius - float(law["clearance"])
        root = np.sqrt(max(depth, 0.0))
        touch = Touch(
            depth, normal, tangent, approach, float(slip),
            approach * across / radius if radius > 0.0 else 0.0,
            1.0 + float(law["contact_damping"]) * approach,
            float(root**2 * (law["hertz"] * root + law["linear"])),
        )  # fmt: skip
        return self.yielded(number, touch) if self.mobility(number) else touch

    def mobility(self, number: int) -> float:
        """Return 1/C of the stator of a contact if it has no mass, else 0."""
        rows = self.request.rows[number][0, self.inert :]
        return float(rows @ rows)

    def yielded(self, number: int, touch: Touch) -> Touch:
        """Return how a contact is whose stator has no mass: its velocity follows the forces."""
        law, way, mobility = self.request.laws[number], self.ways[number], self.mobility(number)
        damping = float(law["contact_damping"])
        push = touch.push(way) / (1.0 + mobility * damping * touch.spring)
        approach = touch.approach - mobility * push
        held = touch.slip / mobility if way == ROLLS else 0.0
        drag = held if abs(way) != 1 else float(law["friction"]) * way * push
        slip, factor = touch.slip - mobility * drag, 1.0 + damping * approach
        return replace(touch, approach=approach, slip=slip, factor=factor, held=held)

    def drift(self, state: Values) -> Values:
        """Return the velocities of stators without mass, but for what contacts do to them."""
        n, inert, request = self.size, self.inert, self.request
        return np.asarray((request.force - request.stiffness @ state[:n])[inert:])

    def filled(self, time: float, state: Values) -> Values:
        """Return a state with the velocities of stators without mass."""
        n, inert, full = self.size, self.inert, state.copy()
        full[n + inert : 2 * n] = self.drift(state)
        for i, way in enumerate(self.ways):
            if self.mobility(i) and way != FLIES:
                touch = self.touch(i, time, state)
                rubs = float(self.request.laws[i]["friction"]) * way * touch.push(way)
                drag = touch.held if way in {ROLLS, IS_LOOSE} else rubs
                force = touch.push(way) * touch.normal + drag * touch.tangent
                full[n + inert : 2 * n] -= self.request.rows[i][:, inert:].T @ force
        return full

    def implicit(self, time: float, state: Values) -> tuple[Values, Values, Values, list[int]]:
        """Return accelerations without what is implicit, its columns, and matrix and right side.

        The unknowns are the forces of contacts that roll and, under a torque, the rate of the spin.
        """
        request, n, driven = self.request, self.size, self.profile.is_driven
        angle, speed = self.spin(time, state)
        y, v = state[:n], state[n : 2 * n]
        rate = 0.0 if driven else self.profile.spins[self.piece].acceleration(0.0, 0.0)
        cosine, sine = np.cos(angle), np.sin(angle)
        by_cosine, by_sine = request.unbalance
        a = request.force - request.stiffness @ y
        a = a + by_cosine * (speed**2 * cosine + rate * sine)
        a = a + by_sine * (speed**2 * sine - rate * cosine)
        if request.damping is not None:
            a = a - request.damping @ v
        if request.gyroscopic is not None:
            a = a - speed * (request.gyroscopic @ v)
        bent = np.zeros(n) if request.stiffness_rate is None else request.stiffness_rate @ y
        a = a - rate * bent
        a[self.inert :] = 0.0
        rolling = self.rolling()
        torque_on_rotor = 0.0
        touches = [self.touch(i, time, state) for i in range(len(self.ways))]
        for i, (way, touch) in enumerate(zip(self.ways, touches, strict=True)):
            if way in {FLIES, IS_LOOSE}:
                continue
            push = touch.push(way)
            drag = touch.held if way == ROLLS else request.laws[i]["friction"] * way * push
            a = a - request.rows[i].T @ (push * touch.normal + drag * touch.tangent)
            a[self.inert :] = 0.0
            torque_on_rotor += request.laws[i]["radius"] * drag
        columns = [-request.rows[i].T @ touches[i].tangent for i in rolling]
        if driven:
            columns.append(sine * by_cosine - cosine * by_sine - bent)
        count = len(columns)
        matrix, right = np.zeros((count, count)), np.zeros(count)
        held = [request.rows[i].T @ touches[i].tangent for i in rolling]
        for row, i in enumerate(rolling):
            law = request.laws[i]
            matrix[row] = [-held[row] @ column for column in columns]
            own = law["race_radius"] * law["inverse_race_inertia"]
            matrix[row, row] += law["race_radius"] * own
            right[row] = held[row] @ a - touches[i].turning
            right[row] += own * law["race_drag"] * state[2 * n + i]
            if driven:
                matrix[row, -1] -= law["radius"]
            else:
                right[row] += law["radius"] * rate
        if driven:
            spin = self.profile.spins[self.piece].piece()
            pull = cosine * by_sine - sine * by_cosine
            matrix[-1] = [pull @ column for column in columns]
            matrix[-1, -1] += request.inertia
            matrix[-1, : len(rolling)] += [request.laws[i]["radius"] for i in rolling]
            right[-1] = spin[1] - spin[2] * speed - torque_on_rotor - pull @ a
        return a, np.array(columns).reshape(count, n), np.column_stack([matrix, right]), rolling

    def rolling(self) -> list[int]:
        """Return the contacts that roll on stators with mass."""
        return [i for i, way in enumerate(self.ways) if way == ROLLS and not self.mobility(i)]

    def rates(self, time: float, state: Values, out: Values) -> None:
        """Write the rate of change of a state."""
        n, request = self.size, self.request
        a, columns, system, rolling = self.implicit(time, state)
        found = np.linalg.solve(system[:, :-1], system[:, -1]) if len(system) else np.empty(0)
        out[:n], out[n : 2 * n] = self.filled(time, state)[n : 2 * n], a + found @ columns
        held = dict(zip(rolling, found, strict=False))
        for i, way in enumerate(self.ways):
            law = request.laws[i]
            touch = self.touch(i, time, state)
            drag = held.get(i, touch.held)
            if way in {1, -1}:
                drag = law["friction"] * way * touch.push(way)
            torque = law["race_radius"] * drag - law["race_drag"] * state[2 * n + i]
            out[2 * n + i] = law["inverse_race_inertia"] * torque
        angle_rate = self.spin(time, state)[1]
        out[-2], out[-1] = angle_rate, found[-1] if self.profile.is_driven else 0.0

    def holds(self, time: float, state: Values) -> dict[int, float]:
        """Return the tangential forces of the contacts that roll."""
        _, _, system, rolling = self.implicit(time, state)
        held = {
            i: self.touch(i, time, state).held
            for i, way in enumerate(self.ways)
            if way == ROLLS and i not in rolling
        }
        if not rolling:
            return held
        found = np.linalg.solve(system[:, :-1], system[:, -1])
        return held | dict(zip(rolling, found.tolist(), strict=False))

    def guards(self, time: float, state: Values) -> Values:
        """Return what must not fall below 0: three numbers a contact, infinite where none is."""
        guards = np.full((len(self.ways), 3), np.inf)
        holds = self.holds(time, state)
        for i, way in enumerate(self.ways):
            law, touch = self.request.laws[i], self.touch(i, time, state)
            guards[i, 0] = -touch.depth if way == FLIES else touch.depth
            if way == FLIES:
                continue
            if law["contact_damping"] > 0.0:
                guards[i, 1] = -touch.factor if way == IS_LOOSE else touch.factor
            if law["friction"] > 0.0 and way in {1, -1}:
                guards[i, 2] = way * touch.slip
            elif way == ROLLS:
                guards[i, 2] = law["friction"] * touch.push(way) - abs(holds[i])
        return guards

    def guard_of(self, number: int, guard: int) -> Function:
        """Return one guard of a contact, as a function of time and state."""
        return lambda time, state: float(self.guards(time, state)[number, guard])


def settle(run: _Run, time: float, state: Values) -> None:
    """Decide how contacts whose surfaces do not slide go on: each holds, or is at its limit.

    All combinations are tried; by the convexity of the problem one of them fits.
    """
    stuck = run.rolling()
    if not stuck:
        return
    if len(stuck) > MOST_STUCK:
        raise SimulationError("too many contacts stick at once for the witness", time=time)
    _, _, system, _ = run.implicit(time, state)
    matrix, right = system[:, :-1], system[:, -1]
    grips = [
        float(run.request.laws[i]["friction"]) * run.touch(i, time, state).push(ROLLS)
        for i in stuck
    ]
    best, least = (0,) * len(stuck), np.inf
    for choice in product((0, 1, -1), repeat=len(stuck)):
        fixed = np.array([sense * grip for sense, grip in zip(choice, grips, strict=True)])
        free = [k for k, sense in enumerate(choice) if sense == 0]
        free += list(range(len(stuck), len(right)))
        forces = np.zeros(len(right))
        forces[: len(stuck)] = fixed
        rest = right - matrix @ forces
        if free:
            forces[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest[free])
        left = right - matrix @ forces
        excess = [
            max(abs(forces[k]) - grips[k], 0.0) if sense == 0 else max(-sense * left[k], 0.0)
            for k, sense in enumerate(choice)
        ]
        if max(excess) < least:
            best, least = choice, max(excess)
    for i, sense in zip(stuck, best, strict=True):
        if sense:
            run.ways[i] = sense


def _begin(run: _Run, state: Values) -> None:
    """Decide the modes at the start."""
    velocity = run.request.velocity
    for i in range(len(run.ways)):
        run.ways[i] = ROLLS if run.mobility(i) else 1
        touch = run.touch(i, 0.0, state)
        pushed = touch.depth > 0.0 or (touch.depth == 0.0 and touch.approach > 0.0)
        if not pushed:
            run.ways[i] = FLIES
            continue
        run.ways[i] = _sliding(run, i, touch, velocity)
        if touch.factor < 0.0:
            run.ways[i] = IS_LOOSE
        run.entries[i] = np.nan
    settle(run, 0.0, state)


def _sliding(run: _Run, number: int, touch: Touch, velocity: float) -> int:
    friction, mobility = float(run.request.laws[number]["friction"]), run.mobility(number)
    slip = touch.slip + mobility * touch.held
    followed = mobility * friction * touch.push(run.ways[number])
    if abs(slip) <= max(STILL * velocity, followed) and friction > 0.0:
        return ROLLS
    return -1 if slip < 0.0 else 1


def _record(run: _Run, time: float, kind: int, number: int, state: Values) -> None:
    run.times.append(time)
    run.kinds.append(kind)
    run.numbers.append(number)
    run.states.append(run.filled(time, state))


def _change(run: _Run, time: float, number: int, guard: int, state: Values) -> None:
    """Do what follows from a guard that has fallen to 0, and record it."""
    way, touch = run.ways[number], run.touch(number, time, state)
    before = list(run.ways)
    kind = 0
    if guard == 0 and way == FLIES:
        run.ways[number], kind = _sliding(run, number, touch, run.request.velocity), ENTRY
        run.entries[number] = time
    elif guard == 0:
        run.ways[number], kind = FLIES, EXIT
        run.episodes.append((number, run.entries.pop(number), time))
    elif guard == 1 and way == IS_LOOSE:
        run.ways[number], kind = _sliding(run, number, touch, run.request.velocity), PRESS
    elif guard == 1:
        run.ways[number], kind = IS_LOOSE, RELEASE
    elif way == ROLLS:
        run.ways[number], kind = (1 if run.holds(time, state)[number] > 0.0 else -1), SLIP
        _record(run, time, kind, number, state)
        return
    else:
        run.ways[number] = ROLLS
    settle(run, time, state)
    for other, was in enumerate(before):
        if other != number and was == ROLLS and run.ways[other] != ROLLS:
            _record(run, time, SLIP, other, state)
    if kind == 0 and run.ways[number] != way:
        kind = ROLL if run.ways[number] == ROLLS else REVERSE
    if kind:
        _record(run, time, kind, number, state)


def _first_crossing(run: _Run, motion: Integration, limit: float) -> tuple[float, int, int] | None:
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


def _sample(run: _Run, motion: Integration, until: float) -> None:
    """Report the samples of a step up to a time."""
    times = run.request.times
    while len(run.samples) < times.size:
        time = float(times[len(run.samples)])
        if time > until:
            break
        state = motion.at(time)
        run.samples.append(run.filled(time, state))
        holds = run.holds(time, state)
        rows = np.zeros((len(run.ways), FORCES))
        for i, way in enumerate(run.ways):
            touch = run.touch(i, time, state)
            push = touch.push(way)
            slides = run.request.laws[i]["friction"] * way * push if abs(way) == 1 else 0.0
            drag = holds.get(i, slides)
            rows[i] = push, drag, np.nan if way == FLIES else touch.slip, way
        run.forces.append(rows)


def run_by_cvode(
    request: SystemRequest, profile: SpeedProfile, rtol: float, method: str, stop: Stop,
    watch: Watch,
) -> SystemResult:  # fmt: skip
    """Return the run of a rotor system by CVODE."""
    n, contacts = len(request.force), len(request.laws)
    run = _Run(request, profile, [FLIES] * contacts)
    scale = np.concatenate([
        np.full(n, request.displacement), np.full(n, request.velocity),
        np.full(contacts, request.velocity / request.displacement), [1.0, 1.0],
    ])  # fmt: skip
    state = np.concatenate([request.start.ravel(), request.races, [profile.angle, request.speed]])
    _begin(run, state)
    watch.append(lambda: run.reached)
    time, last = 0.0, len(profile.ends) - 1

    def scaled(at: float, values: Values, out: Values) -> None:
        run.rates(at, values * scale, out)
        out /= scale

    while time < request.duration:
        if stop[0]:
            return _result(run, STOPPED, time, state)
        limit = min(profile.ends[run.piece], request.duration)
        motion = _Scaled(
            method, scaled, (SAFETY * rtol, SAFETY * rtol), time, state / scale, goal=limit,
            scale=scale,
        )  # fmt: skip
        while True:
            motion.advance()
            found = _first_crossing(run, motion, limit)
            until = found[0] if found else min(motion.high, limit)
            _sample(run, motion, until)
            run.reached = until
            if found or motion.high >= limit or stop[0]:
                break
        time, state = until, motion.at(until)
        if found:
            _change(run, time, found[1], found[2], state)
        elif run.piece < last:
            run.piece += 1
            rolled = list(run.ways)
            settle(run, time, state)
            for i, was in enumerate(rolled):
                if was == ROLLS and run.ways[i] != ROLLS:
                    _record(run, time, SLIP, i, state)
    return _result(run, DONE, time, state)


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


def _result(run: _Run, status: int, time: float, state: Values) -> SystemResult:
    """Return a run in the form of the core's."""
    n, count = run.size, len(run.ways)
    state = run.filled(time, state)
    events = np.array(run.states).reshape(-1, len(state))
    samples = np.array(run.samples).reshape(-1, len(state))
    touches = np.zeros(count, TOUCH)
    touches["way"], touches["race"] = run.ways, state[2 * n : 2 * n + count]
    episodes = [*run.episodes, *((i, entry, np.nan) for i, entry in run.entries.items())]
    table = np.full(len(episodes), np.nan, EPISODE)
    for row, each in zip(table, episodes, strict=True):
        row["contact"], row["entry"], row["exit"] = each
    of_races = slice(2 * n, 2 * n + count)
    speeds = np.vstack([run.request.races, samples[:, of_races], events[:, of_races],
                        state[of_races]])  # fmt: skip
    seen = np.concatenate([[0.0], run.request.times[: len(samples)], run.times, [time]])
    turns = [run.spin(t, s) for t, s in zip(run.request.times, samples, strict=False)]
    of_events = [run.spin(t, s) for t, s in zip(run.times, events, strict=True)]
    return SystemResult(
        status=status, time=time, state=state[: 2 * n].reshape(2, n), touches=touches,
        samples=samples[:, : 2 * n].reshape(-1, 2, n), forces=np.array(run.forces),
        turns=np.array(turns).reshape(-1, 2), event_times=np.array(run.times),
        event_kinds=np.array(run.kinds, np.int32), event_contacts=np.array(run.numbers, np.int32),
        event_turns=np.array(of_events).reshape(-1, 2),
        event_states=events[:, : 2 * n].reshape(-1, 2, n),
        event_races=events[:, of_races], races=_extremes(speeds, seen), episodes=table,
        ledger=dict.fromkeys(LEDGER, np.nan), steps=0, turn=run.spin(time, state),
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
    return Followed(result, *errors_of(result, other, len(request.laws), request.duration))
