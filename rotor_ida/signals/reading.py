"""Measured signals from a file: which column is what, in which unit, and whether it can be used."""

from __future__ import annotations

import os
import struct
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    check_array,
    check_between,
    check_choice,
    check_count,
    check_flag,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.results.files import check_path
from rotor_ida.schema import labelled, labelled_dataset
from rotor_ida.signals.columns import Column, Table, Unit, known_units, unit_called
from rotor_ida.signals.keyphasor import check_pulses, pulses_in, with_lost_pulses
from rotor_ida.signals.matlab import read_matlab
from rotor_ida.signals.probes import displacements
from rotor_ida.signals.record import FEWEST_SAMPLES
from rotor_ida.signals.text import read_text

Keyphasor = Literal["auto", "signal", "times"]

# Names by which a column is guessed, in lower case.
GUESSES = {
    "t": ("t", "time", "times", "zeit", "seconds"),
    "x": ("x", "probe x", "x probe", "probe_x", "probe 1", "probe1", "horizontal", "ch1", "1"),
    "y": ("y", "probe y", "y probe", "probe_y", "probe 2", "probe2", "vertical", "ch2", "2"),
    "keyphasor": ("keyphasor", "key", "kph", "kp", "tacho", "tachometer", "trigger", "pulses", "3"),
    "angle": ("angle", "theta", "phase", "shaft angle", "shaft_angle"),
}
KIND = {"t": "time", "x": "length", "y": "length", "keyphasor": "time", "angle": "angle"}
# Samples a second.
RATES = (1e-9, 1e12)
# A step that is so much longer than the usual one is a gap.
GAP = 1.5
# Samples that stay at the largest or smallest reading.
CLIPPED = 4
# Times within so much of the last digit written of an even spacing are evenly spaced, if they are
# not so to this part of a step anyway.
ROUNDED, EVEN = 0.6, 1e-3
MOST_DECIMALS = 12


def read_signals(
    path: str | os.PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    rate: float | None = None,
    probe_angles: npt.ArrayLike = (0.0, 90.0),
    gains: npt.ArrayLike = (1.0, 1.0),
    keyphasor: Keyphasor = "auto",
    pulses_per_revolution: int = 1,
    accept_clipped: bool = False,
    fill_pulses: bool = False,
) -> xr.Dataset:
    """Read the signals of two probes and a keyphasor from a CSV, WAV or MATLAB file.

    Parameters
    ----------
    path : path
        Text with columns of numbers, a sound file (``.wav``) or a MATLAB file (``.mat``).
    columns : mapping of str to str, optional
        The names in the file of ``t``, ``x``, ``y`` and ``keyphasor`` or ``angle``, such as
        ``{"x": "Probe A"}``. Columns without names, and channels, are called by number from "1".
        What is not given is guessed; the attribute ``columns`` says what was taken.
    units : mapping of str to str, optional
        Units by the same names: s, ms, us, min; m, mm, um, nm, in, mil, V, mV; rad, deg, rev. By
        default what the head of the file has in brackets; otherwise numbers stay as they are.
    rate : float, optional
        Samples a second, for a file without times.
    probe_angles : array_like, shape (2,)
        Where the probes are, from the x axis in the sense of the rotation [degree].
    gains : array_like, shape (2,)
        Reading over displacement of each probe.
    keyphasor : {"auto", "signal", "times"}
        Whether the keyphasor was sampled with the probes or is a list of times of its pulses;
        by default times if there are fewer of them than samples.
    pulses_per_revolution : int
        Pulses of the keyphasor in one revolution [1].
    accept_clipped, fill_pulses : bool
        Whether a probe that is clipped is taken as it is, and lost pulses are set evenly into
        their intervals. Otherwise both are refused.

    Returns
    -------
    Dataset
        ``x y`` on ``t``, in s and um, mm or what else was told, and ``angle`` on ``t`` [rad] or
        times of pulses, ``keyphasor`` on ``pulse``; to be saved and loaded as any result.

    Raises
    ------
    InputError
        In one line: if the file or a column is missing, a number is, times have a gap, a probe is
        clipped, or the keyphasor loses pulses, and where.

    Notes
    -----
    A pulse of a sampled keyphasor is where the signal passes half its height, interpolated between
    two samples.

    Examples
    --------
    >>> import tempfile
    >>> t = np.arange(400) / 1000
    >>> table = np.column_stack([t, np.cos(60 * t), np.sin(60 * t), 60 * t])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = f"{folder}/probes.csv"
    ...     np.savetxt(path, table, "%.17g", ",", header="t [s],x [um],y [um],angle [rad]",
    ...                comments="")
    ...     read = read_signals(path)
    >>> read.attrs["columns"], read.x.attrs["units"]
    ('t=t x=x y=y angle=angle (guessed: t x y angle)', 'um')
    """
    file = check_path("path", path)
    check_choice("keyphasor", keyphasor, ("auto", "signal", "times"))
    per_revolution = check_count("pulses_per_revolution", pulses_per_revolution, 1, 10_000)
    check_flag("accept_clipped", accept_clipped)
    check_flag("fill_pulses", fill_pulses)
    told, given = _words("columns", columns), _words("units", units)
    if rate is not None:
        rate = check_between("rate", rate, *RATES)
    table = _read_table(file)
    names = _names(table, told)
    found = {name: _converted(name, column, table, given) for name, column in names.items()}
    times, time = _times(found, rate, table, names)
    length = _check_probes(found, times, accept_clipped)
    z = displacements(found["x"][0] + 1j * found["y"][0], probe_angles, gains)
    guessed = [name for name in names if name not in told]
    attributes: dict[str, object] = {
        "source": "measured signals",
        "file": file.name,
        "columns": " ".join(f"{name}={column}" for name, column in names.items())
        + (f" (guessed: {' '.join(guessed)})" if guessed else ""),
        "probe_angles": check_array("probe_angles", probe_angles),
        "gains": check_array("gains", gains),
    }
    if rate is None and not np.array_equal(times, found["t"][0]):
        attributes["times"] = "evenly spaced, to the digits that the file has of them"
    variables = {"x": _labelled("x", "t", z.real, length), "y": _labelled("y", "t", z.imag, length)}
    if "angle" in found:
        variables["angle"] = labelled("angle", "t", _angle(found["angle"][0], times))
    elif "keyphasor" in found:
        pulses = _pulses(found["keyphasor"], times, keyphasor, fill_pulses)
        variables["keyphasor"] = _labelled("keyphasor", "pulse", pulses, time)
        attributes["pulses_per_revolution"] = per_revolution
    coordinates = {"t": _labelled("t", "t", times, time)}
    return labelled_dataset(
        "Signals of two probes", variables, coordinates, attributes, kind="signals"
    )


def _read_table(path: Path) -> Table:
    """Return the columns of a file by their names, each with its unit, empty where not told."""
    if not path.is_file():
        raise InputError(f"path must be a file that exists, got {shown(path)}")
    readers = {".wav": _read_wav, ".mat": read_matlab}
    try:
        return readers.get(path.suffix.lower(), read_text)(path)
    except OSError as error:
        raise InputError(f"{shown(path)} cannot be read: {error.strerror or error}") from error


def _read_wav(path: Path) -> Table:
    """Return the channels of a sound file, numbered from 1, and ``t``; whole numbers as of 1."""
    from scipy.io import wavfile  # noqa: PLC0415 - takes long to import

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)
            rate, samples = wavfile.read(path)
    except (ValueError, EOFError, struct.error, UnboundLocalError) as error:
        raise InputError(f"{shown(path)} must be a WAV file: {error}") from error
    table = np.asarray(samples, dtype=np.float64).reshape(len(samples), -1)
    if samples.dtype == np.uint8:
        table = (table - 128.0) / 128.0
    elif samples.dtype.kind == "i":
        table = table / 2.0 ** (8 * samples.dtype.itemsize - 1)
    columns = {"t": Column(np.arange(len(table)) / rate, "s")}
    for number, channel in enumerate(table.T, 1):
        columns[str(number)] = Column(np.ascontiguousarray(channel))
    return Table(columns, lambda name, row: f"{columns[name].values[row]} in sample {row + 1}")


def _words(name: str, given: object) -> dict[str, str]:
    """Return a mapping of words by the names of columns."""
    if given is None:
        return {}
    if not isinstance(given, Mapping) or not all(
        isinstance(key, str) and isinstance(word, str) for key, word in given.items()
    ):
        raise InputError(f"{name} must be a mapping such as {{'x': '...'}}, got {shown(given)}")
    for key in given:
        check_choice(f"a name in {name}", key, tuple(GUESSES))
    return dict(given)


def _names(table: Table, told: Mapping[str, str]) -> dict[str, str]:
    """Return the column of each signal, as told or guessed."""
    for name, column in told.items():
        if column not in table.columns:
            raise InputError(
                f"the file must have the column {shown(column)} for {name}, got "
                f"{shown(table.listed())}"
            )
    free = {each.lower().strip(): each for each in table.columns if each not in told.values()}
    names: dict[str, str] = {}
    for name, guesses in _guesses(table).items():
        found = told.get(name) or next((free[each] for each in guesses if each in free), None)
        if found is not None:
            names[name] = found
        elif name in ("x", "y"):
            raise InputError(
                f"the file must have a column for {name}; name it in columns, got "
                f"{shown(table.listed())}"
            )
    if "angle" in names and "keyphasor" in names:
        names.pop("keyphasor" if "angle" in told or "keyphasor" not in told else "angle")
    return names


def _guesses(table: Table) -> dict[str, tuple[str, ...]]:
    """Return names to guess by: in a file without any the columns are t, x, y, keyphasor."""
    if "t" not in table.columns and all(name.isdigit() for name in table.columns):
        return {"t": ("1",), "x": ("2",), "y": ("3",), "keyphasor": ("4",), "angle": ()}
    return GUESSES


def _converted(
    name: str, column: str, table: Table, units: Mapping[str, str]
) -> tuple[Values, str]:
    """Return a column in s, radians or a unit of length, and its unit."""
    values = table.columns[column].values
    if name == "keyphasor":
        values = _without_end(values)
    missing = np.flatnonzero(~np.isfinite(values))
    if missing.size:
        more = f" and {missing.size - 1} more" if missing.size > 1 else ""
        raise InputError(
            f"column {shown(column)} must hold finite numbers, got "
            f"{table.cell(column, int(missing[0]))}{more}"
        )
    unit = _unit_of(name, column, table, units)
    return values * unit.factor if unit.factor != 1.0 else values, unit.plain


def _without_end(values: Values) -> Values:
    """Return times of pulses, which are fewer than samples, without the empty cells after them."""
    known = np.flatnonzero(~np.isnan(values))
    return values[: known[-1] + 1] if known.size else values


def _unit_of(name: str, column: str, table: Table, units: Mapping[str, str]) -> Unit:
    """Return the unit of a column, as told or as the file has it."""
    written = table.columns[column].unit
    unit = unit_called(units.get(name, written))
    if name == "keyphasor" and name not in units and (unit is None or unit.kind != "time"):
        unit = unit_called("")  # the height of its pulses does not count
    if unit is None or unit.kind not in (KIND[name], "any"):
        place = "" if name in units else f" in the column {shown(column)}; say it in units"
        raise InputError(
            f"the unit of {name} must be one of {known_units(KIND[name])}, got "
            f"{shown(units.get(name, written))}{place}"
        )
    return unit


def _times(
    found: Mapping[str, tuple[Values, str]],
    rate: float | None,
    table: Table,
    names: Mapping[str, str],
) -> tuple[Values, str]:
    """Return the times of the samples, and their unit."""
    size = found["x"][0].size
    if size < FEWEST_SAMPLES:
        raise InputError(f"the file must hold at least {FEWEST_SAMPLES} samples, got {size}")
    if rate is not None:
        return np.arange(size) / rate, "s"
    if "t" not in found:
        raise InputError("the file must have a column for t, or rate must be given, got neither")
    times, unit = found["t"]
    if times.size != size or found["y"][0].size != size:
        raise InputError(
            f"t, x and y must be of one length, got {times.size}, {size}, {found['y'][0].size}"
        )
    written = table.columns[names["t"]].values
    largest = int(np.abs(written).argmax())
    scale = times[largest] / written[largest] if written[largest] else 1.0
    times = _evenly_spaced(times, scale * _last_digit(written))
    steps = np.diff(times)
    if not (steps > 0.0).all():
        at = int(np.flatnonzero(~(steps > 0.0))[0])
        raise InputError(
            f"t must increase, got {table.cell(names['t'], at + 1)} after "
            f"{table.cell(names['t'], at)}"
        )
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > GAP * usual)
    if gaps.size:
        more = f" and {gaps.size - 1} more" if gaps.size > 1 else ""
        raise InputError(
            f"t must have no gaps, got one of {steps[gaps[0]]:.6g} after "
            f"{table.cell(names['t'], int(gaps[0]))}{more}; the usual step is {usual:.6g}"
        )
    return times, unit


def _evenly_spaced(times: Values, digit: float) -> Values:
    """Return times that are evenly spaced but for the last digit written of them."""
    number = np.arange(times.size) - 0.5 * (times.size - 1)
    mean = float(times.mean())
    step = float(number @ (times - mean) / (number @ number))
    off = float(np.abs(times - mean - step * number).max())
    if step > 0.0 and EVEN * step < off <= ROUNDED * digit:
        return np.asarray(mean + step * number, dtype=np.float64)
    return times


def _last_digit(values: Values) -> float:
    """Return what one is worth in the last place of numbers with few digits; 0 of those with all.

    Of numbers of single precision, what their last bit is worth.
    """
    size = float(np.abs(values).max())
    for decimals in range(MOST_DECIMALS + 1):
        scaled = values * 10.0**decimals
        if np.abs(scaled - np.rint(scaled)).max() <= 4.0 * np.spacing(size * 10.0**decimals):
            return 10.0**-decimals
    if (values.astype(np.float32) == values).all():
        return float(np.spacing(np.float32(size)))
    return 0.0


def _check_probes(
    found: Mapping[str, tuple[Values, str]], times: Values, accept_clipped: bool
) -> str:
    """Return the unit of both probes; raise `InputError` if they differ, or one is clipped."""
    (x, length), (y, other) = found["x"], found["y"]
    if length != other:
        raise InputError(f"x and y must be in one unit, got {length} and {other}")
    if x.size != y.size:
        raise InputError(f"t, x and y must be of one length, got {times.size}, {x.size}, {y.size}")
    for name, values in () if accept_clipped else (("x", x), ("y", y)):
        where = _clipped_at(values)
        if where is not None:
            raise InputError(
                f"{name} must not be clipped, but stays at {values[where]:.6g} from t "
                f"{times[where]:.6g} on; accept_clipped=True takes it as it is"
            )
    return length


def _clipped_at(values: Values) -> int | None:
    """Return where a reading first stays at its largest or smallest value, after a leap to it."""
    leaps = np.abs(np.diff(values))
    moving = leaps[leaps > 0.0]
    if not moving.size:
        return None
    # a smooth peak is come upon by one step of the digits, a clipped one by many
    finest = float(moving.min())
    for extreme in (values.max(), values.min()):
        at = np.concatenate([[0], (values == extreme).astype(np.int8), [0]])
        starts, ends = np.flatnonzero(np.diff(at) == 1), np.flatnonzero(np.diff(at) == -1)
        for start in starts[ends - starts >= CLIPPED]:
            if start > 0 and leaps[start - 1] > GAP * finest:
                return int(start)
    return None


def _angle(angles: Values, times: Values) -> Values:
    """Return a measured angle that grows, also where it was counted from 0 to one revolution."""
    if angles.size != times.size:
        raise InputError(f"angle must have one number for each t, got {angles.size}")
    if not (np.diff(angles) >= 0.0).all():
        angles = np.unwrap(angles)
    falls = np.flatnonzero(np.diff(angles) < 0.0)
    if falls.size:
        raise InputError(f"angle must never fall, but does after t {times[falls[0]]:.6g}")
    return angles


def _pulses(column: tuple[Values, str], times: Values, kind: str, fill: bool) -> Values:
    """Return the times of the pulses of a keyphasor."""
    values, _ = column
    if kind == "signal" and values.size != times.size:
        raise InputError(f"keyphasor must have one reading for each t, got {values.size}")
    sampled = kind == "signal" or (kind == "auto" and values.size == times.size)
    pulses = pulses_in(times, values) if sampled else values
    if fill:
        pulses = with_lost_pulses(pulses)
    check_pulses(pulses)
    return pulses


def _labelled(name: str, dim: str, values: Values, unit: str) -> xr.Variable:
    """Return values labelled by name, in a unit of their own."""
    variable = labelled(name, dim, values)
    variable.attrs["units"] = unit
    return variable
