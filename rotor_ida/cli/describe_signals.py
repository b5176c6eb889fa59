"""Describe signals, their orders, spectra and whirl in a few lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise, product
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.cli.report import pairs, table
from rotor_ida.cli.variables import (
    Description,
    Record,
    Rows,
    Sheet,
    parameters_in,
    rows_of,
    rows_table,
    scalars_of,
    span,
    tabled,
    value_of,
    with_unit,
    with_units,
)
from rotor_ida.results.si_units import in_rpm
from rotor_ida.signals.record import record_of
from rotor_ida.units import SPEED_UNITS

# Peaks below this multiple of the floor may be noise.
CLEAR = 4.0
MOST_PEAKS = 50
PLACE = ("t", "speed")
PEAKS = Rows(
    title=f"Peaks above {CLEAR:g} times the noise floor", key="peaks", lead="whirl_amplitude",
    digits=6, falling=True, names=("frequency", "frequency_over_omega", "whirl_amplitude"),
)  # fmt: skip
SPECTRAL_LINES = Sheet("Lines by least squares", (Rows(
    title="Lines", key="lines", lead="whirl_amplitude", gaps=True, falling=True,
    names=("frequency", "frequency_over_omega", "whirl_amplitude", "whirl_phase"),
),))  # fmt: skip
# For programs only; people read a summary of them.
ORDERS = Rows(title="Orders", key="orders", lead="forward_whirl_amplitude", names=PLACE)
MEAN_POSITIONS = Rows(title="Windows", key="windows", lead="offset_x", names=PLACE)
RATIOS = Rows(title="Windows", key="windows", lead="whirl_over_spin", names=PLACE)


def show_signals(dataset: xr.Dataset, most: int | None) -> Description:
    """Return duration, sampling, speed and displacements of a record.

    The samples stay in the archive.
    """
    record_of(dataset)
    times = dataset["t"].values
    rate = (times.size - 1) / float(times[-1] - times[0])
    rows = [_displacement(dataset, name) for name in ("x", "y")]
    turning = _turning(dataset)
    own: Record = {
        "samples": times.size,
        "first_time": float(times[0]),
        "last_time": float(times[-1]),
        "sampling_rate": rate,
        "displacements": rows,
    }
    told: Record = {
        **parameters_in(dataset),
        "samples": times.size,
        with_unit(dataset, "t"): span(times, 6),
        "sampling rate" + _inverse_of(dataset["t"]): rate,
        **turning,
        **{
            name: str(dataset.attrs[name]) for name in ("columns", "notes") if name in dataset.attrs
        },
    }
    unit = str(dataset["x"].attrs.get("units", "1"))
    title = "Displacements" if unit == "1" else f"Displacements [{unit}]"
    shown = table(title, rows, list(rows[0]), digits=6)
    summary = pairs(str(dataset.attrs.get("title", "Signals")), told)
    return tabled(dataset, most)[0] | own | turning, [summary, shown]


def _displacement(dataset: xr.Dataset, name: str) -> Record:
    values = dataset[name].values
    return {
        "probe": name,
        "mean": float(values.mean()),
        "smallest": float(values.min()),
        "largest": float(values.max()),
        "peak_to_peak": float(np.ptp(values)),
    }


def _turning(dataset: xr.Dataset) -> Record:
    """Return the revolutions of a record and the speeds at its ends, if the angle is known."""
    if "keyphasor" in dataset:
        pulses = dataset["keyphasor"].values
        step = 2.0 * math.pi / int(dataset.attrs.get("pulses_per_revolution", 1))
        angles, times = step * np.arange(pulses.size), pulses
    elif "angle" in dataset:
        angles, times = dataset["angle"].values, dataset["t"].values
    else:
        return {}
    told: Record = {"pulses": times.size} if "keyphasor" in dataset else {}
    told["revolutions"] = float(angles[-1] - angles[0]) / (2.0 * math.pi)
    # over a revolution, since a single step is sensitive to rounding
    first = min(int(np.searchsorted(angles, angles[0] + 2.0 * math.pi)), angles.size - 1)
    last = min(int(np.searchsorted(angles, angles[-1] - 2.0 * math.pi)), angles.size - 2)
    ends = [
        float((angles[end] - angles[begin]) / (times[end] - times[begin]))
        for begin, end in ((0, first), (last, -1))
    ]
    if str(dataset["t"].attrs.get("units", "1")) == "s":
        told["speed [rpm]"] = _from_to(*(each / SPEED_UNITS["rpm"] for each in ends))
    else:
        told["speed"] = _from_to(*ends)
    return told


def _inverse_of(times: xr.DataArray) -> str:
    """Return the unit of a rate."""
    unit = str(times.attrs.get("units", "1"))
    return {"1": "", "s": " [Hz]"}.get(unit, f" [1/{unit}]")


def show_orders(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the largest amplitude of each order, forward and backward, and its place."""
    largest: list[Record] = []
    for order, sense in product(dataset["order"].values.tolist(), ("forward", "backward")):
        own, amplitude = dataset.sel(order=order), f"{sense}_whirl_amplitude"
        here = own.isel(window=int(own[amplitude].values.argmax()))
        head = with_unit(dataset, amplitude).removeprefix(f"{sense} ")
        largest.append(
            {
                "order": order,
                "sense": sense,
                head: float(here[amplitude]),
                "standard error": float(here[f"{sense}_amplitude_error"]),
                "phase lag [degree]": math.degrees(float(here[f"{sense}_phase_lag"])),
                **_place(here),
            }
        )
    # means of all windows, beside the largest
    residual = {with_unit(dataset, "window_residual"): float(dataset["window_residual"].mean())}
    columns = list(largest[0]) if largest else []
    shown = table("Largest amplitudes", largest, columns, digits=6)
    record, _ = tabled(dataset, most, ORDERS)
    return record, [pairs("Orders of the speed", _windows(dataset) | residual), shown]


def show_centre_line(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the first, last and most distant mean position."""
    distance = np.hypot(dataset["offset_x"].values, dataset["offset_y"].values)
    places = {"first": 0, "last": -1, "furthest out": int(distance.argmax()),
              "furthest in": int(distance.argmin())}  # fmt: skip
    rows: list[Record] = []
    for words, place in places.items():
        here = dataset.isel(window=place)
        offsets: Record = {name: float(here[name]) for name in ("offset_x", "offset_y")}
        rows.append({"": words, **_place(here), **with_units(dataset, offsets)})
    shown = table("Positions", rows, list(rows[0]), digits=6)
    record, _ = tabled(dataset, most, MEAN_POSITIONS)
    return record, [pairs("Mean position of the shaft", _windows(dataset)), shown]


def show_whirl_over_spin(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the intervals over which the whirl keeps its direction."""
    sense = dataset["whirl_sense"].values
    edges = [0, *(np.flatnonzero(np.diff(sense)) + 1).tolist(), sense.size]
    rows: list[Record] = []
    for begin, end in pairwise(edges):
        part = dataset.isel(window=slice(begin, end))
        first, last = (_place(part.isel(window=place)) for place in (0, -1))
        ranges = {name: _from_to(first[name], last[name]) for name in first}
        ratio = part["whirl_over_spin"].values
        word = value_of(part.isel(window=0), "whirl_sense")
        rows.append({"sense": word, "windows": end - begin, **ranges,
                     "mean whirl over spin": float(ratio.mean()),
                     "whirl over spin": span(ratio, 6)})  # fmt: skip
    shown = rows_table("Senses", rows, list(rows[0]), most, digits=6)
    record, _ = tabled(dataset, most, RATIOS)
    return record, [pairs("Whirl against spin", _windows(dataset)), *shown]


def show_full_spectrum(dataset: xr.Dataset, most: int | None) -> Description:
    """Return bandwidth, noise floor, and the highest peaks above it."""
    record, parts = tabled(dataset.isel(frequency=_peaks(dataset)), most, PEAKS)
    told = {
        **parameters_in(dataset),
        with_unit(dataset, "frequency"): span(dataset["frequency"].values, 6),
        **with_units(dataset, scalars_of(dataset)),
        **_named(record, ("window", "segment", "segment_count", "notes")),
    }
    return record, [pairs("Full spectrum", told), *parts]


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
    """Return the range covered, and the highest line of some segments from first to last."""
    record, _ = tabled(dataset, most)
    lines = dataset[["whirl_amplitude"]]
    highest = lines.isel(frequency=lines["whirl_amplitude"].argmax("frequency"))
    names = ["frequency", "whirl_amplitude"]
    places = [name for name in PLACE if name in dataset.coords]
    record["highest"] = every = rows_of(highest.transpose("window"), [*places, *names])
    told = {
        **_windows(dataset),
        with_unit(dataset, "frequency"): span(dataset["frequency"].values, 6),
        with_unit(dataset, "bandwidth"): float(dataset["bandwidth"]),
        **_named(record, ("window", "segment", "overlap")),
    }
    count = len(every) if most is None else min(most, len(every))
    rows: list[Record] = []
    for number in np.linspace(0, len(every) - 1, count).round().astype(int).tolist():
        line = {name: every[number][name] for name in names}
        rows.append({**_place(dataset.isel(window=number)), **with_units(dataset, line)})
    title = f"Highest line of {'each segment' if count == len(every) else 'some segments'}"
    return record, [pairs("Spectrogram", told), table(title, rows, list(rows[0]), digits=6)]


def _windows(dataset: xr.Dataset) -> Record:
    """Return the number and length of windows, and the times and speeds they cover."""
    told: Record = {**parameters_in(dataset), "windows": dataset.sizes["window"]}
    told |= _named(dict(dataset.attrs), ("window_revolutions", "window_overlap", "notes"))
    first, last = (_place(dataset.isel(window=place)) for place in (0, -1))
    return told | {name: _from_to(first[name], last[name]) for name in first}


def _place(window: xr.Dataset) -> dict[str, float]:
    """Return time and speed of a window by names with units, the speed of a machine in rpm."""
    told = {with_unit(window, "t"): float(window["t"])}
    if "speed" in window.variables:
        turns = in_rpm(window["speed"])
        told |= (
            {with_unit(window, "speed"): float(window["speed"])}
            if turns is None
            else {"speed [rpm]": float(turns)}
        )
    return told


def _from_to(first: float, last: float) -> str:
    ends = f"{first:.6g}", f"{last:.6g}"
    return ends[0] if ends[0] == ends[1] else " to ".join(ends)


def _named(attributes: Record, names: Sequence[str]) -> Record:
    return {name: attributes[name] for name in names if name in attributes}
