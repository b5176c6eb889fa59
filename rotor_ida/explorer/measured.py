"""Panels of a measured file: order 1, and a cascade or one full spectrum."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import xarray as xr

from rotor_ida.arrays import Arrays, Values
from rotor_ida.errors import InputError
from rotor_ida.explorer.messages import Answer, Upload, named
from rotor_ida.signals.files.columns import Table
from rotor_ida.signals.guessing import columns_of, rate_in
from rotor_ida.signals.orders import SEEN, orders
from rotor_ida.signals.reading import read_signals, read_table
from rotor_ida.signals.record import Record, record_of
from rotor_ida.signals.signs import signs_in
from rotor_ida.signals.spectra import full_spectrum, one_speed, spectrogram

# Samples of a spectrum, chosen for the finest resolution while the speed changes: a longer segment
# would have wider lines again.
FEWEST, MOST = 128, 4096
# The lowest and the highest speed are means over one of this many parts of a record.
PARTS = 256
# Order 1 is known if the rest of the motion is at most this many times as large: not in dry whip.
MOST_BESIDE = 4.0
# Highest frequency of lines, over the speed.
ORDERS = 5.0
# Largest numbers sent to a page for a long file: more are not distinguishable on a screen.
MOST_ROWS, MOST_LINES, MOST_REVOLUTIONS = 240, 2**17, 2**18
NO_ANGLE = "there is no column for keyphasor, angle or speed, so neither speed nor phase is known"


def show_measured(measurement: Upload) -> Iterator[Answer]:
    """Yield the panels of a file; anything that cannot be analysed becomes a note."""
    path = measurement.path
    assert path is not None
    with named(path, measurement.name):
        table = read_table(path)
    facts: dict[str, object] = {
        "name": measurement.name,
        "names": [[name, column.unit] for name, column in table.columns.items()],
        "units": dict(measurement.units),
    }
    try:
        told = measurement.reading.get("columns", {}) | measurement.columns
        timed = rate_in(table) is not None or "rate" in measurement.reading
        columns = columns_of(table, told, timed=timed)
        with named(path, measurement.name):
            signals = _signals(table, measurement)
            record = record_of(signals)
    except InputError as error:  # the user may choose other columns
        facts |= {"columns": dict(measurement.columns), "trouble": str(error)}
        yield Answer("measured", facts, {})
        return
    notes = str(signals.attrs["notes"]).split("; ") if "notes" in signals.attrs else []
    arrays = _panels(signals, record, notes)
    facts |= {
        "columns": columns,
        "samples": signals.sizes["t"],
        "time": record.time,
        "length": record.length,
        "by": next((name for name in ("keyphasor", "angle", "speed") if name in columns), ""),
        "speed": one_speed(record),
        "notes": notes,
    }
    yield Answer("measured", facts, arrays)


def _signals(table: Table, measurement: Upload) -> xr.Dataset:
    """Return the signals in a table, as the user says it is to be read.

    Choices on the page go before those of the command; the page sends all of them, changed or not.
    """
    given = dict(measurement.reading)
    given |= {
        name: given.get(name, {}) | getattr(measurement, name) for name in ("columns", "units")
    }
    for name, unchanged in (("probe_angles", (0.0, 90.0)), ("gains", (1.0, 1.0))):
        if getattr(measurement, name) != unchanged:
            given[name] = getattr(measurement, name)
    return read_signals(table, **given)


def _panels(signals: xr.Dataset, record: Record, notes: list[str]) -> Arrays:
    """Return the numbers of the panels, and add a note for each that is impossible."""
    arrays: Arrays = {}
    if record.angles is None:
        notes.append(NO_ANGLE)
    else:
        arrays |= unless_impossible(partial(order_rows, seen=SEEN), signals, record, notes)
    varies = record.angles is not None and one_speed(record) is None
    if (signs := signs_in(signals)) is not None:
        notes.append(str(signs.attrs["sentence"]).removesuffix("."))
    return arrays | unless_impossible(
        cascade_rows if varies else full_lines, signals, record, notes
    )


def track_of(signals: xr.Dataset, notes: list[str]) -> Arrays:
    """Return order 1 and cascade of a run-up, and add a note for each that is impossible."""
    record = record_of(signals)
    arrays = unless_impossible(order_rows, signals, record, notes)
    return arrays | unless_impossible(cascade_rows, signals, record, notes)


def segment_for(rate: float, step: float) -> int:
    """Return the number of samples of a spectrum while the speed changes at a rate.

    In a time T the speed changes by ``rate T``, and the lines of a spectrum are ``2 pi/T`` apart;
    the two are equal at ``T = sqrt(2 pi/rate)``.
    """
    fine = math.sqrt(2.0 * math.pi / rate) / step if rate > 0.0 else math.inf
    return int(2 ** round(math.log2(min(max(fine, FEWEST), MOST))))


def unless_impossible(
    analyse: Callable[[xr.Dataset, Record], Arrays],
    signals: xr.Dataset,
    record: Record,
    notes: list[str],
) -> Arrays:
    """Return the result of an analysis, or note the reason for none."""
    try:
        return analyse(signals, record)
    except InputError as error:
        notes.append(str(error))
        return {}


def order_rows(signals: xr.Dataset, _record: Record, *, seen: float = 0.0) -> Arrays:
    """Return order 1 in each revolution; NaN where much larger other motion hides it.

    The lag is NaN where the amplitude is below a number of its standard errors.
    """
    tracked = orders(signals).isel(order=0)
    every = slice(None, None, math.ceil(tracked.sizes["window"] / MOST_REVOLUTIONS))
    amplitude = tracked["forward_whirl_amplitude"].values
    is_hidden = tracked["window_residual"].values > MOST_BESIDE * amplitude
    is_noise = amplitude < seen * tracked["forward_amplitude_error"].values
    lag = np.where(is_noise, np.nan, tracked["forward_phase_lag"].values)
    return {
        "order_speed": tracked["speed"].values[every],
        "order_amplitude": np.where(is_hidden, np.nan, amplitude)[every],
        "order_lag": lag[every],
    }


def full_lines(signals: xr.Dataset, record: Record) -> Arrays:
    """Return the full spectrum of all samples."""
    lines, speed = full_spectrum(signals), one_speed(record)
    frequency, height = lines["frequency"].values, lines["whirl_amplitude"].values
    if speed is not None:
        drawn = np.abs(frequency) <= ORDERS * speed
        frequency, height = frequency[drawn], height[drawn]
    frequency, height = _tallest(frequency, height)
    return {"full_frequency": frequency, "full_amplitude": height}


def _tallest(frequency: Values, height: Values) -> tuple[Values, Values]:
    """Return the tallest line of each group, if the lines are too many to draw."""
    few = math.ceil(frequency.size / MOST_LINES)
    if few == 1:
        return frequency, height
    starts = np.arange(0, frequency.size - few + 1, few)
    places = starts + height[: starts.size * few].reshape(-1, few).argmax(axis=1)
    return frequency[places], height[places]


def cascade_rows(signals: xr.Dataset, record: Record) -> Arrays:
    """Return full spectra over the speed, no more than are distinguishable."""
    step, angles, times = record.equal_step(), record.known_angles(), record.times
    parts = slice(None, None, max(angles.size // PARTS, 1))
    speeds = np.diff(angles[parts]) / np.diff(times[parts])
    low, high = float(speeds.min()), float(speeds.max())
    segment = segment_for((high - low) / float(times[-1] - times[0]), step)
    spectra = spectrogram(signals, segment=min(segment, times.size))
    rows, last = [], math.inf
    for row, speed in enumerate(spectra["speed"].values.tolist()):
        if abs(speed - last) >= (high - low) / MOST_ROWS:
            rows.append(row)
            last = speed
    drawn = np.abs(spectra["frequency"].values) <= ORDERS * high
    return {
        "cascade_speed": spectra["speed"].values[rows],
        "cascade_frequency": spectra["frequency"].values[drawn],
        "cascade_amplitude": spectra["whirl_amplitude"].values[rows][:, drawn].ravel(),
    }
