"""The panels of one run: orbit, radius and force over time, section, and its lines."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from operator import itemgetter
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Arrays
from rotor_ida.checks import COMPONENTS
from rotor_ida.explorer.messages import Answer, Question
from rotor_ida.explorer.words import Scales, sheet_of, words_of_run
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.results.sheets import Line, sheets_shown
from rotor_ida.results.sheets import facts as facts_in
from rotor_ida.schema import DAMPED_EVENT_KIND, EVENT_KIND, MODE, OF_FRICTION_EVENT_KIND
from rotor_ida.signals.forces import power_in_contact
from rotor_ida.signals.spectra import full_spectrum
from rotor_ida.simulation.options import Method
from rotor_ida.simulation.simulate import simulate

Values = dict[str, npt.NDArray[Any]]
FloatArray = npt.NDArray[np.float64]

SAMPLES_PER_REVOLUTION = 48
# A longer run is drawn with fewer samples per revolution, but enough for the spectrum.
MOST_SAMPLES, FEWEST_PER_REVOLUTION = 16_384, 8
# A disc that rolls on the stator may whirl many times in a revolution: samples per whirl for a
# smooth curve, and the largest number of samples in all.
PER_WHIRL, MOST_SAMPLES_OF_WHIRLS = 32, 65_536
# The end of a run is its last half.
LAST = 0.5
# Highest frequency of lines over the spin speed, forward and backward.
FASTEST_LINE = 5.0
METHOD: Method = "taylor"
OF_ENDING = ("t", "x", "y", "vx", "vy", "mode", "slip_speed")
DRAWN = (
    *("t", "x", "y", "rotating_x", "rotating_y", "radius", "force"),
    *("event_time", "event_time_error", "event_x", "event_y", "event_radius"),
    *("event_rotating_x", "event_rotating_y", "entry_time", "exit_time", "peak_time", "peak_force"),
)
# Samples of one period of a cycle, and its smallest line over the largest.
SAMPLES = 512
LEAST = 1e-9


def show_motion(question: Question) -> Iterator[Answer]:
    """Yield the panels of one run."""
    rotor = question.rotor
    run = forced(run_of(question), rotor)
    summary = ending(run, rotor)
    end = rotated(states_of(run)[-1], -rotor.omega * run["t"][-1])
    facts: dict[str, object] = {
        **facts_of(question), "end": end.tolist(), **told_of_run(run, summary, scales_of(question)),
    }  # fmt: skip
    each = (run["t"].size - 1) // question.revolutions
    angles = (rotor.omega * run["t"], rotor.omega * run["event_time"])
    yield drawn(run, facts, angles, each)


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
        "ending": summary, "words": words_of_run(summary), "horizon": float(run["horizon"]),
        "sheets": [*sheet_of("The last half of the drawn run", scales, summary),
                   *sheets_shown([facts_in("Its events", lines)] if lines else [])],
    }  # fmt: skip


def drawn(
    run: Values, facts: dict[str, object], angles: tuple[FloatArray, FloatArray], each: float
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


def _orders_shown(run: Values, omega: float) -> float:
    """Return the highest frequency of lines over the spin speed, including the fastest whirl."""
    return max(FASTEST_LINE, math.ceil(1.25 * whirls_per_revolution(run, omega)))


def run_of(question: Question) -> xr.Dataset:
    """Return the run that is drawn and saved."""
    run = _sampled(question, each := samples_per_revolution(question.revolutions))
    finer = min(
        math.ceil(PER_WHIRL * whirls_per_revolution(values_of(run), question.rotor.omega)),
        MOST_SAMPLES_OF_WHIRLS // question.revolutions,
    )
    return run if finer <= each else _sampled(question, finer)


def _sampled(question: Question, each: int) -> xr.Dataset:
    """Return the run with this many samples per revolution, and the first sample."""
    return simulate(
        question.rotor,
        start=question.start,
        duration=duration_of(question),
        samples=each * question.revolutions + 1,
        method=METHOD,
    )


def whirls_per_revolution(run: Values, omega: float) -> float:
    """Return the largest number of backward whirls in a revolution.

    For a disc with friction only, which may roll; over the last half of the run.
    """
    late = run["t"] >= LAST * run["t"][-1]
    if "mode" not in run or omega == 0.0:
        return 0.0
    held = late & (run["mode"] != MODE["flight"])
    x, y, vx, vy = (run[name][held] for name in COMPONENTS)
    rate = np.abs(x * vy - y * vx) / (x**2 + y**2)
    return float(rate.max(initial=0.0)) / omega


def duration_of(question: Question) -> float:
    """Return the length of the run [1]."""
    return question.revolutions * 2.0 * math.pi / (question.rotor.omega or 1.0)


def samples_per_revolution(revolutions: int) -> int:
    """Return the number of samples per revolution of a run of a number of revolutions."""
    return max(min(SAMPLES_PER_REVOLUTION, MOST_SAMPLES // revolutions), FEWEST_PER_REVOLUTION)


def facts_of(question: Question) -> dict[str, object]:
    """Return the facts about the rotor in an answer."""
    return {
        "rotor": question.rotor.given, "scales": scales_of(question), "start": question.start
    }  # fmt: skip


def scales_of(question: Question) -> dict[str, float]:
    """Return the scales of a machine; none of a rotor without dimensions."""
    machine = question.machine
    if isinstance(machine, Rotor):
        return {}
    return {
        "length": machine.length_scale, "time": machine.time_scale,
        "velocity": machine.velocity_scale, "force": machine.force_scale,
        "energy": machine.force_scale * machine.length_scale, "rate": machine.reference_frequency,
    }  # fmt: skip


def values_of(run: xr.Dataset) -> Values:
    """Return the values of a run by name, without labels: a slider needs a fast answer."""
    return {str(name): variable.values for name, variable in run.variables.items()}


def forced(run: xr.Dataset, rotor: Rotor) -> Values:
    """Return the values of a run of one disc, with the contact force."""
    values = values_of(run)
    return values | {"force": power_in_contact(values, rotor).normal_force}


def ending(run: Values, rotor: Rotor) -> dict[str, float]:
    """Summarize the last half of a run of one disc: see `ending_of`.

    With contact damping, add the mean energy loss of contacts that end there, the loss per
    revolution, and how often the force falls to zero before the rotor leaves the stator; with
    friction the heat.
    """
    found = ending_of(run, rotor.omega)
    begin = LAST * float(run["t"][-1])
    late = {name: run[name][run["t"] >= begin] for name in OF_ENDING if name in run}
    power = power_in_contact(late, rotor)
    revolutions = _revolutions(run, rotor.omega)

    def per_revolution(rate: FloatArray) -> float:
        # over whole periods of a periodic motion it is as exact as the samples
        return float(np.trapezoid(rate, late["t"])) / revolutions if revolutions else math.nan

    if rotor.contact_damping > 0.0:
        losses = run["contact_loss"][run["exit_time"] >= begin]
        found["loss_per_contact"] = float(losses.mean()) if losses.size else math.nan
        found["releases"] = _events(run, DAMPED_EVENT_KIND["release"])
        found["loss_per_revolution"] = per_revolution(power.damping)
    if rotor.friction > 0.0:
        found["heat_per_revolution"] = per_revolution(power.friction)
    return found


def ending_of(run: Values, omega: float) -> dict[str, float]:
    """Summarize the last half of a run: contacts, their peak force, extreme radii.

    With friction, add the fractions of contact time with slip and rolling.
    """
    end = float(run["t"][-1])
    begin = LAST * end
    late = run["t"] >= begin
    radius = np.hypot(run["x"], run["y"])[late]
    peaks = run["peak_force"][run["peak_time"] >= begin]
    revolutions = _revolutions(run, omega)
    entry = np.maximum(np.nan_to_num(run["entry_time"], nan=0.0), begin)
    leaving = np.nan_to_num(run["exit_time"], nan=end)
    found = {
        "contacts_per_revolution": (
            _events(run, EVENT_KIND["entry"]) / revolutions if revolutions else math.nan
        ),
        "contact_fraction": float(np.maximum(leaving - entry, 0.0).sum()) / (end - begin),
        "largest_force": max(float(run["force"][late].max()), float(peaks.max(initial=0.0))),
        "radius_min": float(radius.min()),
        "radius_max": float(radius.max()),
        "contacts_in_all": float(run["peak_time"].size),
    }
    if "mode" in run:
        mode = run["mode"][late]
        touching = max(int(np.count_nonzero(mode != MODE["flight"])), 1)
        for name in ("slipping_forward", "slipping_backward", "rolling"):
            found[f"{name}_fraction"] = int(np.count_nonzero(mode == MODE[name])) / touching
    return found


def _revolutions(run: Values, omega: float) -> float:
    """Return the number of revolutions in the last half of a run."""
    return (1.0 - LAST) * float(run["t"][-1]) * omega / (2.0 * math.pi)


def _events(run: Values, kind: int) -> float:
    """Return the number of events of a kind in the last half of a run."""
    late = run["event_time"] >= LAST * run["t"][-1]
    return float(((run["event_kind"] == kind) & late).sum())


def states_of(run: Values) -> FloatArray:
    """Return the states of a run."""
    return np.stack([run[name] for name in COMPONENTS], axis=-1)


def show_lines(question: Question) -> Iterator[Answer]:
    """Yield the full spectrum of the last half of a run, over the spin speed."""
    yield lines_answer(run_of(question), question.rotor.omega or 1.0, facts_of(question))


def lines_answer(run: xr.Dataset, omega: float, facts: dict[str, object]) -> Answer:
    """Return the full spectrum of the last half of a run, over the spin speed."""
    lines = full_spectrum(run.isel(t=slice((run.sizes["t"] - 1) // 2, -1)))
    over = lines["frequency"].values / omega
    orders = _orders_shown(values_of(run), omega)
    shown = np.abs(over) <= orders
    arrays: Arrays = {
        "line_over_omega": over[shown], "line_amplitude": lines["whirl_amplitude"].values[shown]
    }  # fmt: skip
    bandwidth = float(lines["bandwidth"]) / omega
    return Answer("lines", facts | {"bandwidth_over_omega": bandwidth, "orders": orders}, arrays)


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
