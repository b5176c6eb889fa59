"""Pieces of a run-up or run-down: motion, folds on the way, and the track of all of it.

Each piece continues a record of equally spaced samples, from which order 1 and the cascade are
those of the whole run-up since it last turned back.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import State
from rotor_ida.closed_forms.folds import folds
from rotor_ida.closed_forms.synchronous import synchronous_response
from rotor_ida.errors import InputError
from rotor_ida.explorer.cases import METHOD, Node
from rotor_ida.explorer.measured import track_of
from rotor_ida.explorer.messages import Answer, Question
from rotor_ida.explorer.responses import MOST_KEPT, at_rest
from rotor_ida.explorer.system_verdicts import touched_on_the_way
from rotor_ida.explorer.words import words_of_run_up
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import interruptible
from rotor_ida.results.contact_facts import run_up_facts
from rotor_ida.schema import MODE, STABILITY
from rotor_ida.simulation.dataset import arrays_of
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.run import run
from rotor_ida.steady.run_up_outcome import RunUp, on_rotating_axes

# As for the drawn run.
RTOL = 1e-10
# Samples per revolution, or in a time of 2 pi if that is shorter.
SAMPLES, MOST_SAMPLES = 48, 4096
# Whirls are counted at this distance on either side of a fold, as a fraction of its speed.
BESIDE = 1e-4
# A jump to a whirl within this fraction of the radius is not visible, as at folds near the first
# touch.
LEAST_JUMP = 0.2

# Equally spaced samples: number per revolution at the highest speed shown.
PER_REVOLUTION = 32
# The state at the end of a piece is judged over this last part of it.
LAST = 0.75
# Number of record ends kept, and samples of one.
MOST_ENDS, MOST_SAMPLES_KEPT = 32, 2**20


def show_run_up(question: Question) -> Iterator[Answer]:
    """Yield the radius on one piece of a ramp, and the state from which the next one continues.

    States are on axes along the unbalance, whose angle each piece continues: a load is fixed in
    space. ``held`` is the state from which the last speed is held, with the unbalance along x.
    """
    rotor, to, rate = question.rotor, question.to, question.rate
    assert to is not None
    assert rate is not None
    duration = (to - rotor.omega) / rate
    turns = max(0.5 * (rotor.omega + to), 1.0) * duration / (2.0 * math.pi)
    drawn = np.linspace(0.0, duration, min(max(math.ceil(SAMPLES * turns), 2), MOST_SAMPLES) + 1)
    record = _record_of(question)
    sampled = record.times_until(duration)
    times = np.union1d(drawn, sampled)
    orbit, held = interruptible(lambda stop: _piece(question, times, stop))
    run = arrays_of(orbit)
    angle = run["angle"] - question.angle
    end = rotated(orbit.end, -run["angle"][-1])
    seen = np.searchsorted(times, sampled)
    record = replace(
        record, time=record.time + duration, angle=record.angle + float(angle[-1]),
        speed=float(run["speed"][-1]), way=rate, passed=followed(record.passed, run, rotor),
        angles=np.concatenate([record.angles, record.angle + angle[seen]]),
        z=np.concatenate([record.z, run["x"][seen] + 1j * run["y"][seen]]),
    )  # fmt: skip
    _keep(question, tuple(end.tolist()), record)
    facts: dict[str, object] = {
        **Node(question).facts,
        "end": end.tolist(),
        "held": held,
        "angle": float(run["angle"][-1]) % math.tau,
        "speed": float(run["speed"][-1]),
        "largest_force": record.passed.largest_force,
        "now": record.passed.now,
        "words": words_of_run_up(question.disc, asdict(record.passed)),
        "folds": list(_folds_of(at_rest(rotor))),
    }
    here = np.searchsorted(times, drawn)
    arrays = {
        "speed": run["speed"][here], "angle": angle[here],
        "radius": np.hypot(run["x"], run["y"])[here],
    }  # fmt: skip
    yield Answer("run_up", facts, arrays)


def _piece(question: Question, times: Values, stop: Stop) -> tuple[Orbit, State]:
    """Return the orbit of a piece, and the state from which its last speed is held."""
    assert question.to is not None
    assert question.rate is not None
    options = Options(rtol=RTOL, atol=RTOL, method=METHOD, backend="compiled")
    x, y, vx, vy = rotated(question.start, question.angle).tolist()
    rotor = question.rotor
    run_up = RunUp(rotor, rotor.omega, question.to, question.rate, question.angle)
    course = run_up.course
    orbit = run(rotor, (x, y, vx, vy), course.ends[-1], times, options, stop=stop, profile=course)
    last = replace(rotor, omega=question.to)
    return orbit, on_rotating_axes(last, orbit.end, run_up.end_angle, options, stop)


@dataclass(frozen=True, slots=True, kw_only=True)
class Passed:
    """Summary of a run-up since the speed began to change.

    Parameters
    ----------
    begin, end : float
        Speeds at its beginning and end [dimensionless].
    first_touch_speed : float
        Speed of the first contact [dimensionless]; NaN without one.
    smallest_gap, largest_radius_speed : float
        Clearance less the largest radius, and the speed at which that occurred [dimensionless].
    largest_force, largest_force_speed : float
        Largest contact force, and the speed at which it occurred [dimensionless].
    now : {"clear", "rub", "whip"}
        State at the end.
    """

    begin: float
    end: float
    first_touch_speed: float = math.nan
    smallest_gap: float = math.inf
    largest_radius_speed: float = math.nan
    largest_force: float = 0.0
    largest_force_speed: float = math.nan
    now: str = "clear"


def followed(passed: Passed, run: dict[str, npt.NDArray[Any]], rotor: Rotor) -> Passed:
    """Return the summary with one more piece."""
    facts = run_up_facts(run, rotor.delta0)
    found: dict[str, Any] = {"end": float(run["speed"][-1]), "now": _now(run, rotor)}
    names = ["first_touch_speed"] if math.isnan(passed.first_touch_speed) else []
    if facts["smallest_gap"] < passed.smallest_gap:
        names += ["smallest_gap", "largest_radius_speed"]
    if facts["largest_force"] > passed.largest_force:
        names += ["largest_force", "largest_force_speed"]
    return replace(passed, **found | {name: facts[name] for name in names})


def _now(run: dict[str, npt.NDArray[Any]], rotor: Rotor) -> str:
    """Return the state of the rotor over the last part of a piece."""
    radius = np.hypot(run["x"], run["y"])
    late = run["t"] >= LAST * run["t"][-1]
    backward = np.mean((run["x"] * run["vy"] - run["y"] * run["vx"])[late]) < 0.0
    if backward and "mode" in run and np.any(run["mode"][late] == MODE["rolling"]):
        return "whip"
    leaves = np.nan_to_num(run["exit_time"], nan=math.inf)
    touches = np.any(radius[late] > rotor.delta0) or np.any(leaves >= LAST * run["t"][-1])
    return "rub" if touches else "clear"


@lru_cache(maxsize=MOST_KEPT)
def _folds_of(rotor: Rotor) -> tuple[dict[str, float], ...]:
    """Return the folds at which a whirl ends, up (1) or down (-1): speed, radius and next radius.

    The next radius is that of the nearest remaining whirl.
    """
    if rotor.load > 0.0:
        return ()
    try:
        table = folds(rotor)
    except InputError:
        return ()
    found = []
    omegas, amplitudes = (table[f"fold_{name}"].values.ravel() for name in ("omega", "amplitude"))
    for omega, amplitude in zip(omegas.tolist(), amplitudes.tolist(), strict=True):
        if math.isnan(omega):
            continue
        (many_below, below), (many_above, above) = (
            _whirls_at(rotor, omega * (1.0 + sign * BESIDE)) for sign in (-1.0, 1.0)
        )
        left = above if many_below > many_above else below
        if many_below == many_above or not left:
            continue
        other = min(left, key=lambda each: abs(each - amplitude))
        if abs(amplitude - other) > LEAST_JUMP * amplitude:
            found.append({
                "omega": omega, "radius": amplitude, "other": other,
                "way": 1.0 if many_below > many_above else -1.0,
            })  # fmt: skip
    return tuple(found)


def _whirls_at(rotor: Rotor, omega: float) -> tuple[int, list[float]]:
    """Return the number of whirls at a speed, and the radii of those that are not unstable."""
    found = synchronous_response(rotor, omega=omega)
    radii, stability = found["amplitude"].values.ravel(), found["stability"].values.ravel()
    held = np.isfinite(radii) & (stability != STABILITY["unstable"])
    return int(np.isfinite(radii).sum()), radii[held].tolist()


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """Samples of a run-up since it last turned back.

    Parameters
    ----------
    step : float
        Step of the samples [dimensionless].
    time, angle, speed : float
        Time and angle since the beginning of the record, and the speed, at its end.
    way : float
        Positive for a run-up, negative for a run-down.
    passed : Passed
        Summary since the speed began to change.
    angles, z : ndarray
        Samples: angles of the unbalance, displacements on fixed axes.
    """

    step: float
    time: float = 0.0
    angle: float
    speed: float
    way: float
    passed: Passed
    angles: Values
    z: npt.NDArray[np.complex128]

    def times_until(self, duration: float) -> Values:
        """Return the times of the samples that a piece adds, from the beginning of the piece."""
        end = math.floor((self.time + duration) / self.step)
        times = np.arange(self.z.size, end + 1) * self.step - self.time
        return np.asarray(np.clip(times, 0.0, duration), dtype=np.float64)


_records: OrderedDict[tuple[Rotor, State], Record] = OrderedDict()


def _record_of(question: Question) -> Record:
    """Return the record that ends at the beginning of a piece, or a new one."""
    rotor, rate = question.rotor, question.rate
    assert rate is not None
    found = _records.get((at_rest(rotor), question.start))
    passed = Passed(begin=rotor.omega, end=rotor.omega)
    if found is not None and math.isclose(found.speed, rotor.omega, rel_tol=1e-9, abs_tol=1e-12):
        if found.way * rate > 0.0:
            return found
        passed = found.passed
    return Record(
        step=math.tau / (PER_REVOLUTION * question.speeds[1]), angle=question.angle,
        speed=rotor.omega, way=rate, passed=passed,
        angles=np.empty(0), z=np.empty(0, np.complex128),
    )  # fmt: skip


def _keep(question: Question, end: State, record: Record) -> None:
    """Keep a record for the piece that continues from the state at its end."""
    if record.z.size > MOST_SAMPLES_KEPT:
        return
    _records[at_rest(question.rotor), end] = record
    while len(_records) > MOST_ENDS:
        _records.popitem(last=False)


def show_track(question: Question) -> Iterator[Answer]:
    """Yield order 1 and the cascade of a run-up: of one disc, of that which ended in its start."""
    shown, notes, words = Node(question), list[str](), ""
    if shown.machine is None:
        run, system = shown.run_up(), shown.case.system
        signals, notes = shown.probed(run), [system.note] if system.note else []
        words = touched_on_the_way(run) if system.contacts else ""
    else:
        record = _records.get((at_rest(question.rotor), question.start))
        if record is None:
            raise InputError("a run-up must be given from its beginning")
        signals = xr.Dataset(
            {"x": ("t", record.z.real), "y": ("t", record.z.imag), "angle": ("t", record.angles)},
            {"t": np.arange(record.z.size) * record.step},
        )
    arrays = track_of(signals, notes)
    yield Answer("track", shown.facts | {"words": " ".join([words, *notes])}, arrays)
