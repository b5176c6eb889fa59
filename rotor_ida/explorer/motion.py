"""The panels of one run of any rotor: orbit, radius and force over time, section, and its lines."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from operator import itemgetter

import numpy as np
import xarray as xr

from rotor_ida.arrays import Arrays
from rotor_ida.arrays import Values as FloatArray
from rotor_ida.explorer.archives import PLAYED, archive_of, archived_answers
from rotor_ida.explorer.cases import METHOD, Node
from rotor_ida.explorer.endings import Values, states_of, values_of, whirls_per_revolution
from rotor_ida.explorer.messages import Answer, Question
from rotor_ida.explorer.words import Scales, sheet_of, words_of_run
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.results.dataset_kinds import kind_of
from rotor_ida.results.sheets import Line, sheets_shown
from rotor_ida.results.sheets import facts as facts_in
from rotor_ida.schema import DAMPED_EVENT_KIND, OF_FRICTION_EVENT_KIND
from rotor_ida.signals.nodes import angles_of_system
from rotor_ida.signals.spectra import full_spectrum
from rotor_ida.simulation.simulate import simulate

# Highest frequency of lines over the spin speed, forward and backward.
FASTEST_LINE = 5.0
DRAWN = (
    *("t", "x", "y", "rotating_x", "rotating_y", "radius", "force"),
    *("event_time", "event_time_error", "event_x", "event_y", "event_radius"),
    *("event_rotating_x", "event_rotating_y", "entry_time", "exit_time", "peak_time", "peak_force"),
)
# Samples of one period of a cycle, and its smallest line over the largest.
SAMPLES = 512
LEAST = 1e-9


def show_motion(question: Question) -> Iterator[Answer]:
    """Yield the panels of one run, and what is in an archive of anything."""
    path, archived = question.path, archive_of(question)
    if archived is None or kind_of(archived) in PLAYED:
        shown = Node(question)
        yield from shown.begin()
        run = shown.run()
        yield from shown.beside(run, _motion(shown, run))
    if path is not None and archived is not None:
        yield from archived_answers(path, path.stat().st_mtime_ns)


def _motion(shown: Node, run: xr.Dataset) -> Answer:
    """Return the panels of a run."""
    values = shown.seen(run)
    changes = "speed" in run
    angles = [
        np.interp(values[name], run["t"].values, angles_of_system(run)) if changes
        else shown.speed * values[name] for name in ("t", "event_time")
    ]  # fmt: skip
    facts = {**shown.facts, **shown.told(values)}
    facts |= told_of_run(values, facts["ending"], shown.scales)
    facts["is_whole"] = changes or kind_of(run) == "drop"
    if changes:  # of several speeds
        facts |= {"words": [], "sheets": facts["sheets"][1:]}
    # without spin a time of 2 pi counts as a revolution
    turns = (np.ptp(angles[0]) or values["t"][-1]) / math.tau
    each = float((run.sizes["t"] - 1) / turns)
    is_one = not changes and math.isclose(each, round(each), rel_tol=1e-9)
    answer = drawn(values, facts, angles, round(each) if is_one else each)
    if shown.case.changes_speed:
        answer.arrays.update(_extremes(run["speed"].values, angles[0], values["radius"]))
    return answer


def _extremes(speed: FloatArray, angle: FloatArray, radius: FloatArray) -> Arrays:
    """Return the extremes of the radius in each revolution of a run-up, over the speed."""
    first = np.flatnonzero(np.diff(np.floor(angle / math.tau), prepend=-np.inf))
    return {
        "band_speed": speed[first], "band_low": np.minimum.reduceat(radius, first),
        "band_high": np.maximum.reduceat(radius, first),
    }  # fmt: skip


def told_of_run(run: Values, summary: dict[str, float], scales: Scales) -> dict[str, object]:
    """Return what the page says of a run in words: its end, and its events with their errors."""
    kinds = sorted((DAMPED_EVENT_KIND | OF_FRICTION_EVENT_KIND).items(), key=itemgetter(1))
    count = {name: int(np.count_nonzero(run["event_kind"] == kind))
             for name, kind in reversed(kinds)}  # fmt: skip
    errors = run["event_time_error"]
    known = errors[np.isfinite(errors)]
    time, unit = (scales["time"], "s") if scales else (1.0, "1")
    lines = [Line(name, [each]) for name, each in count.items() if each]
    if known.size:
        lines.append(Line("largest error of their times", [float(known.max()) * time], unit, 2))
    if known.size < errors.size:
        lines.append(Line("determined by the start up to", [float(run["horizon"]) * time], unit, 4))
    return {
        "words": words_of_run(summary), "horizon": float(run["horizon"]),
        "sheets": [*sheet_of("The last half of the drawn run", scales, summary),
                   *sheets_shown([facts_in("Its events", lines)] if lines else [])],
    }  # fmt: skip


def drawn(
    run: Values, facts: dict[str, object], angles: Sequence[FloatArray], each: float
) -> Answer:
    """Return what is drawn of a run, with the given number of samples a revolution.

    `angles` are those of the unbalance at the samples and at the events. There is a section only
    where a revolution has a whole number of samples.
    """
    run["radius"] = np.hypot(run["x"], run["y"])
    run["event_radius"] = np.hypot(run["event_x"], run["event_y"])
    for prefix, angle in zip(("", "event_"), angles, strict=True):
        x, y, cosine, sine = run[f"{prefix}x"], run[f"{prefix}y"], np.cos(-angle), np.sin(-angle)
        run[f"{prefix}rotating_x"] = cosine * x - sine * y
        run[f"{prefix}rotating_y"] = sine * x + cosine * y
    facts["samples_per_revolution"] = each
    arrays: Arrays = {name: run[name] for name in DRAWN}
    arrays["event_kind"] = run["event_kind"].astype(np.int8)
    if "mode" in run:
        arrays |= {"mode": run["mode"].astype(np.int8), "slip_speed": run["slip_speed"]}
    every = slice(None, None, each) if isinstance(each, int) else slice(0)
    arrays |= {f"section_{axis}": run[f"rotating_{axis}"][every] for axis in ("x", "y")}
    return Answer("motion", facts, arrays)


def show_lines(question: Question) -> Iterator[Answer]:
    """Yield the full spectrum of the last half of a run, over the spin speed."""
    shown = Node(question)
    drawn, omega = shown.run(), shown.speed or 1.0
    run = shown.probed(drawn)
    lines = full_spectrum(run.isel(t=slice((run.sizes["t"] - 1) // 2, -1)))
    over = lines["frequency"].values / omega
    fastest = math.ceil(1.25 * whirls_per_revolution(shown.seen(drawn), omega))
    orders = max(FASTEST_LINE, fastest)  # including the fastest whirl
    kept = np.abs(over) <= orders
    arrays: Arrays = {
        "line_over_omega": over[kept], "line_amplitude": lines["whirl_amplitude"].values[kept]
    }  # fmt: skip
    facts = {"bandwidth_over_omega": float(lines["bandwidth"]) / omega, "orders": orders}
    yield Answer("lines", shown.facts | facts, arrays)


def exact_lines(
    rotor: Rotor, lies_on: object, settled: dict[str, object], end: Sequence[float]
) -> Arrays:
    """Return order and amplitude of the lines of the settled whirl or cycle.

    A cycle is sampled over one period, from a state on it. A motion that never repeats has none.
    """
    nothing: Arrays = {"exact_order": np.empty(0), "exact_amplitude": np.empty(0)}
    if lies_on == "whirl":
        height = float(str(settled["exact_amplitude"]))
        return {"exact_order": np.ones(1), "exact_amplitude": np.array([height])}
    if lies_on != "cycle" or rotor.omega == 0.0:
        return nothing
    period = float(str(settled["exact_period"]))
    times = np.linspace(0.0, period, SAMPLES, endpoint=False)
    run = values_of(simulate(rotor, start=end, duration=period, samples=times, method=METHOD))
    rotating = rotated(states_of(run), -rotor.omega * run["t"])
    heights = np.abs(np.fft.fft(rotating[:, 0] + 1j * rotating[:, 1])) / SAMPLES
    orders = 1.0 + np.fft.fftfreq(SAMPLES, 1.0 / SAMPLES) * 2.0 * math.pi / (period * rotor.omega)
    kept = (heights > LEAST * heights.max()) & (np.abs(orders) <= FASTEST_LINE)
    place = np.argsort(orders[kept])
    return {"exact_order": orders[kept][place], "exact_amplitude": heights[kept][place]}
