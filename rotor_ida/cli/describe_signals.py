"""Describe signals, their orders, spectra and whirl in a few lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.cli.variables import (
    Description,
    Layout,
    Record,
    Rows,
    line_of,
    lines_of,
    parameters_in,
    scalars_of,
    span,
    tabled,
)
from rotor_ida.results.sheets import Line, Range, Sheet, facts
from rotor_ida.signals.peaks import bode_peaks
from rotor_ida.signals.record import record_of
from rotor_ida.signals.signs import signs_in

# Peaks below this multiple of the floor may be noise.
CLEAR = 4.0
MOST_PEAKS = 50
PLACE = ("t", "speed")
PEAKS = Rows(
    title=f"Peaks above {CLEAR:g} times the noise floor", key="peaks", lead="whirl_amplitude",
    digits=6, falling=True, names=("frequency", "frequency_over_omega", "whirl_amplitude"),
)  # fmt: skip
SPECTRAL_LINES = Layout("Lines by least squares", (Rows(
    title="Lines", key="lines", lead="whirl_amplitude", gaps=True, falling=True,
    names=("frequency", "frequency_over_omega", "whirl_amplitude", "whirl_phase"),
),))  # fmt: skip
SIGNS = {
    "forward_whirl_amplitude": "1X forward", "backward_whirl_amplitude": "1X backward",
    "twice_amplitude": "2X, both ways", "line_order": "order of the strongest other line",
    "line_amplitude": "its amplitude", "line_opposite_amplitude": "same order the other way",
    "whirl_over_spin": "whirl over spin", "least_crest": "least crest over that of a sine",
    "noise_floor": "noise floor", "floor_ratio": "floor below 1X over the highest line",
}  # fmt: skip
# For programs only; people read a summary of them.
ORDERS = Rows(title="Orders", key="orders", lead="forward_whirl_amplitude", names=PLACE)
MEAN_POSITION = Layout("Mean position of the shaft", (Rows(
    title="Windows", key="windows", lead="offset_x", digits=6,
    names=(*PLACE, "offset_x", "offset_y"),
),))  # fmt: skip
WHIRL_OVER_SPIN = Layout("Whirl against spin", (Rows(
    title="Windows", key="windows", lead="whirl_over_spin", digits=6,
    names=(*PLACE, "whirl_sense", "whirl_over_spin"),
),))  # fmt: skip
SPECTROGRAM = Layout("Spectrogram", (Rows(
    title="Highest line of each segment", key="highest", lead="frequency", digits=6,
    names=(*PLACE, "frequency", "whirl_amplitude"),
),))  # fmt: skip


def show_signals(dataset: xr.Dataset, most: int | None) -> Description:
    """Return duration, sampling, speed and displacements of a record.

    The samples stay in the archive.
    """
    record_of(dataset)
    times = dataset["t"].values
    rate = (times.size - 1) / float(times[-1] - times[0])
    rows = [_displacement(dataset, name) for name in ("x", "y")]
    own: Record = {
        "samples": times.size,
        "first_time": float(times[0]),
        "last_time": float(times[-1]),
        "sampling_rate": rate,
        "displacements": rows,
    }
    told = [
        *lines_of(dataset, parameters_in(dataset) | {"samples": times.size, "t": span(times)}),
        Line("sampling rate", [rate], {"s": "Hz"}.get(str(dataset["t"].attrs.get("units")), "1")),
        *_turning(dataset),
        *lines_of(dataset, _named(dict(dataset.attrs), ("columns", "notes"))),
    ]
    lines = [Line("probe", ["x", "y"]),
             *(replace(line_of(dataset, "x", [row[name] for row in rows], 6),
                       name=name.replace("_", " "))
               for name in ("mean", "smallest", "largest", "peak_to_peak"))]  # fmt: skip
    summary = facts(str(dataset.attrs.get("title", "Signals")), told)
    turning = {line.name: line.values[0] for line in _turning(dataset)}
    signs = signs_in(dataset)
    record, parts = ({}, []) if signs is None else show_rub_signs(signs, most)
    of_signs = {"signs": record} if record else {}
    found = tabled(dataset, most)[0] | own | turning | of_signs
    return found, [summary, Sheet("Displacements", lines), *parts]


def show_rub_signs(dataset: xr.Dataset, _most: int | None) -> Description:
    """Return the signs of a rub, and what they mean."""
    lines = [replace(line_of(dataset, name, [float(dataset[name])], 4), name=words)
             for name, words in SIGNS.items()]  # fmt: skip
    sentence = str(dataset.attrs["sentence"])
    record = {str(name): float(each) for name, each in dataset.data_vars.items()}
    return record | {"sentence": sentence}, [facts("Signs of rub", lines), sentence]


def _displacement(dataset: xr.Dataset, name: str) -> Record:
    values = dataset[name].values
    return {
        "probe": name,
        "mean": float(values.mean()),
        "smallest": float(values.min()),
        "largest": float(values.max()),
        "peak_to_peak": float(np.ptp(values)),
    }


def _turning(dataset: xr.Dataset) -> list[Line]:
    """Return the revolutions of a record and the speeds at its ends, if the angle is known."""
    if "keyphasor" in dataset:
        pulses = dataset["keyphasor"].values
        step = 2.0 * math.pi / int(dataset.attrs.get("pulses_per_revolution", 1))
        angles, times = step * np.arange(pulses.size), pulses
    elif "angle" in dataset:
        angles, times = dataset["angle"].values, dataset["t"].values
    else:
        return []
    told = [Line("pulses", [times.size])] if "keyphasor" in dataset else []
    told.append(Line("revolutions", [float(angles[-1] - angles[0]) / (2.0 * math.pi)]))
    # over a revolution, since a single step is sensitive to rounding
    first = min(int(np.searchsorted(angles, angles[0] + 2.0 * math.pi)), angles.size - 1)
    last = min(int(np.searchsorted(angles, angles[-1] - 2.0 * math.pi)), angles.size - 2)
    ends = Range(
        float((angles[end] - angles[begin]) / (times[end] - times[begin]))
        for begin, end in ((0, first), (last, -1))
    )
    is_si = str(dataset["t"].attrs.get("units", "1")) == "s"
    return [*told, Line("speed", [ends], "rad/s" if is_si else "1")]


def show_orders(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the largest amplitude of each order, forward and backward, and its place."""
    senses = list(product(dataset["order"].values.tolist(), ("forward", "backward")))
    places = [
        (here := dataset.sel(order=order)).isel(
            window=int(here[f"{sense}_whirl_amplitude"].values.argmax())
        )
        for order, sense in senses
    ]

    def column(name: str, words: str, unit: str) -> Line:
        values = [float(here[name.format(sense)])
                  for (_, sense), here in zip(senses, places, strict=True)]  # fmt: skip
        return Line(words, values, unit, 6)

    unit = str(dataset["forward_whirl_amplitude"].attrs.get("units", "1"))
    lines = [
        Line("order", [order for order, _ in senses]),
        Line("sense", [sense for _, sense in senses]),
        column("{}_whirl_amplitude", "whirl amplitude, zero to peak", unit),
        column("{}_amplitude_error", "standard error", unit),
        column("{}_phase_lag", "phase lag", "radian"),
        *_places(places),
    ]
    # means of all windows, beside the largest
    residual = line_of(dataset, "window_residual", [float(dataset["window_residual"].mean())])
    record, _ = tabled(dataset, most, ORDERS)
    parts: list[Sheet | str] = [
        facts("Orders of the speed", [*_windows(dataset), residual]),
        Sheet("Largest amplitudes", lines),
    ]
    if "probe_angle" in dataset.dims:
        parts.append(_probes(dataset, record))
    if 1.0 in dataset["order"]:
        parts += _critical_speeds(dataset, record)
    return record, parts


def _critical_speeds(dataset: xr.Dataset, record: Record) -> list[Sheet]:
    """Return the peaks of 1X, forward and of each probe, and add them to the record."""
    senses = ("forward", *(("x", "y") if "probe_angle" in dataset.dims else ()))
    peaks = {sense: bode_peaks(dataset, sense=sense) for sense in senses}
    names = ("critical_speed", "amplification_factor", "half_power_low", "half_power_high")
    rows: list[dict[str, Any]] = [
        {"sense": sense, **{name: float(each[name][place]) for name in names}}
        for sense, each in peaks.items() for place in range(each.sizes["critical"])
    ]  # fmt: skip
    record["critical_speeds"] = rows
    if not rows:
        return []
    columns = [line_of(peaks["forward"], name, [row[name] for row in rows], 6) for name in names]
    title = "Critical speeds of 1X, by half power"
    return [Sheet(title, [Line("1X of", [row["sense"] for row in rows]), *columns])]


def _probes(dataset: xr.Dataset, record: Record) -> Sheet:
    """Return the largest reading of each order at each probe, and add them to the record."""
    places = []
    for order, probe in product(range(dataset.sizes["order"]), range(dataset.sizes["probe_angle"])):
        here = dataset.isel(order=order, probe_angle=probe)
        places.append(here.isel(window=int(here["probe_peak_to_peak"].values.argmax())))
    names = {
        "order": "order", "probe_angle": "probe at", "probe_peak_to_peak":
        "vibration, peak to peak", "probe_error": "standard error", "probe_phase_lag": "phase lag",
        "direct_peak_to_peak": "direct, peak to peak",
    }  # fmt: skip
    record["probes"] = [
        {name: float(each[name]) for name in (*names, *PLACE) if name in each.variables}
        for each in places
    ]
    columns = [
        replace(line_of(dataset, name, [float(each[name]) for each in places], 6), name=words)
        for name, words in names.items()
    ]
    return Sheet("Largest readings of the probes", [*columns, *_places(places)])


def show_full_spectrum(dataset: xr.Dataset, most: int | None) -> Description:
    """Return bandwidth, noise floor, and the highest peaks above it."""
    record, parts = tabled(dataset.isel(frequency=_peaks(dataset)), most, PEAKS)
    told = {
        **parameters_in(dataset),
        "frequency": span(dataset["frequency"].values),
        **scalars_of(dataset),
        **_named(record, ("window", "segment", "segment_count", "notes")),
    }
    return record, [facts("Full spectrum", lines_of(dataset, told)), *parts]


def _peaks(dataset: xr.Dataset) -> np.ndarray[Any, Any]:
    """Return the indices of the highest peaks, further apart than the window width."""
    from scipy.signal import find_peaks  # noqa: PLC0415 - takes long to import

    heights, frequency = dataset["whirl_amplitude"].values, dataset["frequency"].values
    apart = 2.0 * float(dataset["bandwidth"]) / float(frequency[1] - frequency[0])
    # the spectrum is periodic, so a peak may lie at an edge
    ringed = np.concatenate([heights[-1:], heights, heights[:1]])
    least = CLEAR * float(dataset["noise_floor"])
    found = find_peaks(ringed, height=max(least, 1e-300), distance=max(apart, 1.0))[0] - 1
    highest: np.ndarray[Any, Any] = found[np.argsort(-heights[found])][:MOST_PEAKS]
    return highest


def show_spectrogram(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the highest line of each segment."""
    highest = dataset["whirl_amplitude"].argmax("frequency")
    return SPECTROGRAM(dataset.isel(frequency=highest), most)


def _windows(dataset: xr.Dataset) -> list[Line]:
    """Return the number and length of windows, and the times and speeds they cover."""
    told: Record = {**parameters_in(dataset), "windows": dataset.sizes["window"]}
    told |= _named(dict(dataset.attrs), ("window_revolutions", "window_overlap", "notes"))
    told |= {name: _ends(dataset, name) for name in PLACE if name in dataset.variables}
    return lines_of(dataset, told)


def _places(windows: Sequence[xr.Dataset]) -> list[Line]:
    """Return the times and speeds of windows."""
    return [line_of(windows[0], name, [float(each[name]) for each in windows], 6)
            for name in PLACE if name in windows[0].variables]  # fmt: skip


def _ends(dataset: xr.Dataset, name: str) -> Range:
    """Return the first and the last value of a variable."""
    return Range(float(dataset[name][place]) for place in (0, -1))


def _named(attributes: Record, names: Sequence[str]) -> Record:
    return {name: attributes[name] for name in names if name in attributes}
