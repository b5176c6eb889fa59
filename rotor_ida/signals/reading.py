"""Read measured signals from a file: identify columns and units, and check the data."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.checks import (
    LARGEST_SAMPLE,
    check_array,
    check_between,
    check_choice,
    check_flag,
    check_instance,
    listed,
    shown,
)
from rotor_ida.errors import InputError, MissingFileError
from rotor_ida.results.files import check_path
from rotor_ida.schema import labelled, labelled_dataset
from rotor_ida.signals.files.arrays import read_hdf5, read_matlab, read_npz
from rotor_ida.signals.files.columns import (
    DIFFERENT_RATE,
    ENDINGS,
    Table,
    Unit,
    known_units,
    unit_called,
)
from rotor_ida.signals.files.labview import read_labview
from rotor_ida.signals.files.recorders import read_comtrade, read_tdms, read_uff, read_wav
from rotor_ida.signals.files.text import read_text
from rotor_ida.signals.guessing import (
    KIND,
    columns_of,
    count_left_out,
    counts_samples,
    increases,
    rate_in,
    unit_of,
)
from rotor_ida.signals.keyphasor import Rises, check_per_revolution
from rotor_ida.signals.probes import (
    LENGTHS,
    Rotation,
    angles_of_probes,
    check_columns,
    displacements,
    displacements_at,
    gap_position,
    mean_position,
    question_of_swapped,
    scaled,
    slow_part,
    subtract_runout,
)
from rotor_ida.signals.record import MEAN, UNKNOWN, position_text
from rotor_ida.signals.sample_times import at_times_of_x, times_of, with_times_of_x
from rotor_ida.signals.teeth import Teeth, teeth_in, teeth_of

NO_UNIT = "times have no unit: give it in units (t=s)"
Keyphasor = Literal["auto", "signal", "times"]

# Arguments of one file alone, while another is read alike.
OWN = ("path", "slow_roll", "runout_orders")
# Samples per second.
RATES = (1e-9, 1e12)
INTEGRATED = (
    "the angle is integrated from the speed: phase lags have no known origin, and drift with the "
    "error of the speed"
)
# Range of an angle that is counted from 0 to one revolution, with some margin.
TURN = 6.5
READERS: Mapping[str, Callable[[Path], Table]] = {
    "wav": read_wav,
    "matlab": read_matlab,
    "hdf5": read_hdf5,
    "npz": read_npz,
    "uff": read_uff,
    "tdms": read_tdms,
    "labview": read_labview,
    "comtrade": read_comtrade,
}


def read_signals(
    path: str | os.PathLike[str] | Table,
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    rate: float | None = None,
    probe_angles: npt.ArrayLike | None = None,
    gains: npt.ArrayLike = (1.0, 1.0),
    sensitivity: str | None = None,
    keyphasor: Keyphasor = "auto",
    pulses_per_revolution: int = 1,
    accept_clipped: bool = False,
    fill_pulses: bool = False,
    gap: str | Sequence[str] | None = None,
    length: str | None = None,
    rotation: Rotation = "counterclockwise",
    caption: str | None = None,
    slow_roll: tuple[float, float] | tuple[str, str] | str | os.PathLike[str] | None = None,
    runout_orders: int = 1,
) -> xr.Dataset:
    """Read the signals of two probes and a keyphasor, or a speed, from a measured file.

    Parameters
    ----------
    path : path
        A table in text, or a file of a recorder, read by its ending: WAV, MATLAB, HDF5, NumPy
        (.npz), UFF 58 and 58b, TDMS, LabVIEW (.lvm), COMTRADE (.cfg and .dat, or .cff).
    columns : mapping of str to str, optional
        The columns of ``t``, ``x``, ``y`` and of ``keyphasor``, ``angle`` or ``speed``. For
        instance ``{"x": "Probe A"}``; columns without names, and channels, are numbered from "1".
        By default guessed from their names. The attribute ``columns`` lists all.
    units : mapping of str to str, optional
        Units by the same names: s, ms, us, min; m, mm, um, nm, in, mil, V, mV; rad, deg, rev;
        rad/s, rpm, Hz. By default those in the file, or at the end of a name as in ``probe_A_um``;
        otherwise numbers are not converted.
    rate : float, optional
        Samples per second, for a file without times. Times that count samples or do not increase
        are not used then; others must agree with the rate.
    probe_angles : array_like, shape (2,), optional
        Angles of the probes from the x axis, to the right, counterclockwise [degree]. By default
        those in the names of the columns, as in ``45R`` and ``45L`` (right and left of vertical),
        otherwise 0 and 90.
    gains : array_like, shape (2,)
        Reading over displacement of each probe.
    sensitivity : str, optional
        Reading in volts over displacement of both probes, such as ``"200 mV/mil"`` or
        ``"7.87 V/mm"``. Displacements then have the unit of length in it; mil become um.
    keyphasor : {"auto", "signal", "times"}
        Whether the keyphasor was sampled with the probes or is a list of pulse times. By default
        times if there are fewer of them than samples.
    pulses_per_revolution : int
        Pulses of the keyphasor in one revolution [dimensionless].
    accept_clipped : bool
        Accept clipped probe signals, which are refused otherwise.
    fill_pulses : bool
        Replace lost pulses by evenly spaced ones. They are refused otherwise.
    gap : str or sequence of str, optional
        Position from which ``x``, ``y`` and the centre line are counted: the reading of both probes
        there, such as ``"-10 V"``, or of each, in volts or a unit of length; or the mean of a
        stretch, such as ``"0 s"`` to ``"2 s"``; or ``"0"`` for data that are counted from the
        centre of the stator. Two words are a sequence. By default the mean position of the record.
    length : {"um", "mm", "m", "nm", "mil", "in"}, optional
        Unit of displacements, whatever that of the file or the sensitivity.
    rotation : {"counterclockwise", "clockwise"}
        How the rotor turns, seen from where the angles of the probes are counted; clockwise shows
        it from its other end, from which it turns counterclockwise. Probes at 45 and 135 degrees
        are then at 135 and 45.
    caption : str, optional
        What figures say of the record, such as machine and date, beside the name of the file.
    slow_roll : tuple of float or of str, or path, optional
        Subtract the runout between these times, such as ``("34.5 s", "40 s")``, in which the rotor
        turns slowly. Or a path: that in another file of the same probes, read alike. See
        `rotor_ida.subtract_runout`.
    runout_orders : int
        Highest multiple of the speed of that runout [dimensionless].

    Returns
    -------
    Dataset
        ``x y`` on ``t``, in s and um, mm or another unit given, and ``angle`` on ``t`` [rad] or
        pulse times, ``keyphasor`` on ``pulse``. Without a gap ``mean_x`` and ``mean_y`` are the
        mean position that was subtracted; `rotor_ida.centre_line` and `rotor_ida.orders` add it
        again. It can be saved and loaded like any result. The attribute ``notes`` lists the
        assumptions, and asks whether the probes are swapped where 1X whirls backward throughout.

    Raises
    ------
    InputError
        If the file is damaged, a column is missing or ambiguous, a number is missing, times have a
        gap, a probe is clipped, or the keyphasor loses pulses. The message states where.

    Notes
    -----
    A pulse of a sampled keyphasor is where the signal passes half its height, interpolated between
    two samples. A speed instead of a keyphasor is integrated to the angle by the trapezoidal rule:
    amplitudes of orders are correct, but phase lags count from the first sample and drift with
    the error of the speed. The mean position is that of the whole revolutions of the record, or of
    all samples if no angle is known. One mean is subtracted from the whole record, so in a run-up
    ``x`` and ``y`` still show how the centre line moves.

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
    alike = {name: value for name, value in locals().items() if name not in OWN}
    per_revolution = _check_choices(
        keyphasor, rotation, length, pulses_per_revolution, accept_clipped, fill_pulses
    )
    told, given = _words("columns", columns), _words("units", units)
    if rate is not None:
        rate = check_between("rate", rate, *RATES)
    table = path if isinstance(path, Table) else read_table(check_path("path", path))
    table, names, rate, own, notes = _columns_in(table, told, given, rate)
    found = {each: _converted(each, names, table, given) for each in names}
    found |= {each: scaled(each, *found[each], sensitivity, length) for each in ("x", "y")}
    times, time = times_of(found, rate, table, names)
    notes += [NO_UNIT] if time == "1" else []
    own = {each: _unit_of("t", names, table, given).factor * at for each, at in own.items()}
    unit = check_columns(found, {name: own.get(name, times) for name in found}, accept_clipped)
    if "angle" in own:  # before it is interpolated
        found["angle"] = _angle(found["angle"], own["angle"], names["angle"]), "rad"
    clock = own.pop("keyphasor", times)
    teeth = _teeth(found.get("keyphasor"), clock, keyphasor, per_revolution, fill_pulses)
    if own:
        found, times = at_times_of_x(found, times, own)
    turning, origin, more = _rotation(
        found, teeth, (times, time), names.get("angle", ""), per_revolution
    )
    notes += more
    if own:
        notes.append(f"the times of {listed(list(own))} are not those of x: interpolated at those")
    angles, more = angles_of_probes(probe_angles, names, rotation)
    notes += more
    attributes = _attributes(table, _listed(names, told), angles, gains, caption) | origin
    if rate is None and not np.array_equal(times, found["t"][0]):
        attributes["times"] = "evenly spaced, to the digits that the file has of them"
    readings = np.stack([found[each][0] for each in ("x", "y")])
    probes = partial(displacements_at, sensitivity, unit, angles, gains, readings)
    z = displacements(readings[0] + 1j * readings[1], angles, gains)
    signals, more = _counted_from(gap, z, probes, (times, time), unit, turning, attributes)
    notes += more
    if said := "; ".join(notes):
        signals.attrs["notes"] = said
    return _without_runout(signals, slow_roll, runout_orders, alike)


def _check_choices(
    keyphasor: str, rotation: str, length: str | None, pulses: int, clipped: bool, fill: bool
) -> int:
    """Refuse wrong words, flags and numbers of pulses; return the pulses in a revolution."""
    for name, (word, words) in {
        "keyphasor": (keyphasor, ("auto", "signal", "times")),
        "rotation": (rotation, ("counterclockwise", "clockwise")),
        "length": ("um" if length is None else length, tuple(LENGTHS)),
    }.items():
        check_choice(name, word, words)
    for name, flag in (("accept_clipped", clipped), ("fill_pulses", fill)):
        check_flag(name, flag)
    return check_per_revolution(pulses)


def _attributes(
    table: Table, columns: str, angles: Values, gains: npt.ArrayLike, caption: str | None
) -> dict[str, object]:
    """Return what is known of the file, its columns and its probes."""
    return {
        "source": "measured signals",
        "file": table.file,
        "columns": columns,
        "probe_angles": angles,
        "gains": check_array("gains", gains),
        **({} if caption is None else {"caption": check_instance("caption", caption, str)}),
    }


def _counted_from(
    gap: str | Sequence[str] | None,
    z: ComplexValues,
    probes: Callable[[Values, str], ComplexValues],
    clock: tuple[Values, str],
    unit: str,
    turning: dict[str, xr.Variable],
    attributes: dict[str, object],
) -> tuple[xr.Dataset, list[str]]:
    """Return signals counted from their gap or their mean position, and notes on that."""
    coordinates = {"t": _labelled("t", "t", *clock)}
    if gap is None:
        zero, said = mean_position(z, clock[0], turning), "the mean position is subtracted"
        means = zip(MEAN, (zero.real, zero.imag), strict=True)
        coordinates |= {axis: _labelled(axis, (), value, unit) for axis, value in means}
    else:
        zero, attributes["gap"] = gap_position(gap, z, clock[0], probes)
        said = "displacements are counted from the gap"
    parts = (("x", z.real - zero.real), ("y", z.imag - zero.imag))
    both = {name: _labelled(name, "t", part, unit) for name, part in parts}
    signals = labelled_dataset(
        "Signals of two probes", both | turning, coordinates, attributes, kind="signals"
    )
    notes = [f"{said}: {position_text(zero, unit)}"] if gap is None or zero else []
    return signals, [*notes, *question_of_swapped(signals)]


def _without_runout(
    signals: xr.Dataset,
    slow_roll: tuple[float, float] | tuple[str, str] | str | os.PathLike[str] | None,
    orders: int,
    alike: dict[str, Any],
) -> xr.Dataset:
    """Return signals less the runout in a part of them, or in another file that is read alike."""
    if slow_roll is None:
        return signals
    if isinstance(slow_roll, str | os.PathLike):
        slow = read_signals(slow_roll, **alike)
    else:
        slow = slow_part(signals, slow_roll)
    return subtract_runout(signals, slow, harmonics=orders)


def _columns_in(
    table: Table, told: Mapping[str, str], units: Mapping[str, str], rate: float | None
) -> tuple[Table, dict[str, str], float | None, dict[str, Values], list[str]]:
    """Return the columns, which signal each is, the rate where times are not used, and notes.

    With them the own times of signals that were not sampled with x.
    """
    own_rate = rate_in(table)
    names = columns_of(table, told, timed=rate is not None or own_rate is not None)
    table, own = with_times_of_x(table, names, rate)
    notes = []
    if rate is not None and "t" in names:
        notes.append(_not_used(names.pop("t"), rate, table, units))
    if rate is None and "t" not in names and own_rate is not None:
        rate = check_between(own_rate[0], own_rate[1], *RATES)
        notes.append(f"times follow from the {rate:g} samples a second in {own_rate[0]}")
    if count := count_left_out(table, names):
        notes.append(f"column {count} counts samples and is left out")
    return table, names, rate, own, notes


def _not_used(column: str, rate: float, table: Table, units: Mapping[str, str]) -> str:
    """Return a note that a column of times is not used; raise `InputError` if it contradicts."""
    values = table.columns[column].values
    if values.size > 1 and increases(values) and not counts_samples(values):
        step = float(np.median(np.diff(values))) * _unit_of("t", {"t": column}, table, units).factor
        if not abs(step * rate - 1.0) <= DIFFERENT_RATE:
            raise InputError(
                f"rate must agree with the times in the column {shown(column)}, which are "
                f"{1.0 / step:.6g} samples a second, got {rate!r}; leave rate out, or give the "
                "unit of t in units"
            )
    return f"the column {column} is not used, as rate is given"


def _rotation(
    found: Mapping[str, tuple[Values, str]],
    teeth: Teeth | None,
    clock: tuple[Values, str],
    column: str,
    per_revolution: int,
) -> tuple[dict[str, xr.Variable], dict[str, object], list[str]]:
    """Return the angle of the rotor or the pulses of its keyphasor, whichever the file has.

    With them attributes and notes about where the angle is counted from.
    """
    if "angle" in found:
        return {"angle": labelled("angle", "t", _angle(found["angle"], clock[0], column))}, {}, []
    if teeth is not None:
        pulses = _labelled("keyphasor", "pulse", teeth.times, clock[1])
        told = teeth.attributes(per_revolution), teeth.notes(per_revolution)
        return {"keyphasor": pulses}, *told
    if "speed" in found:
        angle = labelled("angle", "t", _integrated(found["speed"][0], *clock))
        return {"angle": angle}, {"angle_origin": UNKNOWN}, [INTEGRATED]
    return {}, {}, []


def _listed(names: Mapping[str, str], told: Mapping[str, str]) -> str:
    """Return in words the column of each signal, and which of them were guessed."""
    guessed = [name for name in names if name not in told]
    pairs = " ".join(f"{name}={column}" for name, column in names.items())
    return pairs + (f" (guessed: {' '.join(guessed)})" if guessed else "")


def read_table(path: Path) -> Table:
    """Return the columns of a file by name, each with its unit, empty if not given."""
    if not path.is_file():
        raise MissingFileError(f"path must be a file that exists, got {shown(path)}")
    ending = path.suffix.lower()
    reader = next((READERS[kind] for kind, each in ENDINGS.items() if ending in each), read_text)
    try:
        return replace(reader(path), file=path.name)
    except OSError as error:
        raise InputError(f"{shown(path)} cannot be read: {error.strerror or error}") from error


def _words(name: str, given: object) -> dict[str, str]:
    """Return a mapping of words by signal name, checked."""
    if given is None:
        return {}
    if not isinstance(given, Mapping) or not all(
        isinstance(key, str) and isinstance(word, str) for key, word in given.items()
    ):
        raise InputError(f"{name} must be a mapping such as {{'x': '...'}}, got {shown(given)}")
    for key in given:
        check_choice(f"a name in {name}", key, tuple(KIND))
    return dict(given)


def _converted(
    name: str, columns: Mapping[str, str], table: Table, units: Mapping[str, str]
) -> tuple[Values, str]:
    """Return a column in s, radians, radians per second or a unit of length, and its unit."""
    column = columns[name]
    values = table.columns[column].values
    if name == "keyphasor":  # without the empty cells after its pulses
        values = values[: np.flatnonzero(~np.isnan(values)).max(initial=-1) + 1]
    wrong = np.flatnonzero(~(np.abs(values) <= LARGEST_SAMPLE))
    if wrong.size:
        allowed = f"numbers within {LARGEST_SAMPLE:g} of zero"
        if not np.isfinite(values[wrong[0]]):
            allowed = "finite numbers"
        more = f" and {wrong.size - 1} more" if wrong.size > 1 else ""
        raise InputError(
            f"column {shown(column)} must contain {allowed}, got "
            f"{table.cell(column, int(wrong[0]))}{more}"
        )
    unit = _unit_of(name, columns, table, units)
    return values * unit.factor if unit.factor != 1.0 else values, unit.plain


def _unit_of(name: str, columns: Mapping[str, str], table: Table, units: Mapping[str, str]) -> Unit:
    """Return the unit of a column, as given by the user or by the file."""
    written = unit_of(name, columns, table)
    unit = unit_called(units.get(name, written))
    if name == "keyphasor" and name not in units and (unit is None or unit.kind != "time"):
        unit = unit_called("")  # the height of its pulses does not count
    allowed = (KIND[name],) if name == "speed" else (KIND[name], "any")
    if unit is None or unit.kind not in allowed:
        place = "" if name in units else f" in the column {shown(columns[name])}; give it in units"
        raise InputError(
            f"the unit of {name} must be one of {known_units(KIND[name])}, got "
            f"{shown(units.get(name, written))}{place}"
        )
    return unit


def _angle(measured: tuple[Values, str], times: Values, column: str) -> Values:
    """Return a measured angle as a growing one, even if it was counted from 0 to one revolution."""
    angles, unit = measured
    if not (np.diff(angles) >= 0.0).all():
        turn = float(np.ptp(angles))
        if unit == "1" and turn > TURN:
            raise InputError(
                f"the unit of angle must be given in units, as it spans {turn:.6g} and falls: one "
                f"of {known_units('angle')}, got none"
            )
        angles = np.unwrap(angles)
    falls = np.flatnonzero(np.diff(angles) < 0.0)
    if falls.size:
        raise InputError(
            f"angle must never fall, but does after t {times[falls[0]]:.6g}; if column "
            f"{shown(column)} holds pulses, name it in columns: keyphasor={column}"
        )
    return angles


def _integrated(speeds: Values, times: Values, time: str) -> Values:
    """Return the angle of the rotor, 0 at the first sample, by the trapezoidal rule."""
    if time != "s":
        raise InputError("t must have a unit beside a speed; give it in units, got none")
    if not (speeds >= 0.0).all() or not speeds.any():
        at = int(speeds.argmin())
        raise InputError(
            f"speed must be 0 or positive, not always 0, got {speeds[at]:.6g} rad/s at t "
            f"{times[at]:.6g}"
        )
    steps = 0.5 * (speeds[1:] + speeds[:-1]) * np.diff(times)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _teeth(
    column: tuple[Values, str] | None, times: Values, kind: str, per_revolution: int, fill: bool
) -> Teeth | None:
    """Return the pulses of a keyphasor; None without one."""
    if column is None:
        return None
    values, _ = column
    if kind == "signal" and values.size != times.size:
        raise InputError(f"keyphasor must have one reading for each t, got {values.size}")
    if kind == "signal" or (kind == "auto" and values.size == times.size):
        return teeth_in(times, values, per_revolution, fill=fill)
    nothing = np.zeros(values.size)
    return teeth_of(Rises(values, nothing, nothing + np.nan), per_revolution, fill=fill)


def _labelled(name: str, dim: str | tuple[()], values: npt.ArrayLike, unit: str) -> xr.Variable:
    """Return values labelled by name, in the given unit."""
    variable = labelled(name, dim, values)
    variable.attrs["units"] = unit
    return variable
