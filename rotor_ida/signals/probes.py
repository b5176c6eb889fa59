"""Convert the readings of two probes to displacements, and subtract runout."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    LARGEST_NUMBER,
    check_array,
    check_count,
    check_increasing,
    check_vector,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.signals.files.columns import Unit, unit_called
from rotor_ida.signals.files.text import number_in
from rotor_ida.signals.guessing import angles_in
from rotor_ida.signals.orders import fit
from rotor_ida.signals.record import MEAN, Record, record_of
from rotor_ida.signals.windows import EDGE, Complex, fit_orders, windows_of
from rotor_ida.units import UNITS

# Sine of the smallest angle between two probes.
NEARLY_ALONG = 1e-3
MOST_HARMONICS = 50
# A rotor turns slowly below this part of the largest speed of a record. A slow roll may end this
# part of the record after it.
HOW_SLOW, ROOM = 0.5, 1e-3
# Speeds of a slow roll that are kept.
MOST_SPEEDS = 64
# Volts or millivolts over a unit of length.
SENSITIVITIES = (1e-12, 1e12)
# Units of length in which displacements can be shown, in metres.
LENGTHS = {name: UNITS[name].in_si("1") for name in ("um", "mm", "m", "nm", "mil", "in")}
# A backward 1X this many times as large as the forward one in all windows is asked about.
CLEARLY = 2.0
Rotation = Literal["counterclockwise", "clockwise"]
# Samples at the largest or smallest reading by which a probe counts as clipped.
CLIPPED = 4
# A clipped reading jumps to its limit by more than this many of its smallest steps.
LEAP = 1.5
_NUMBER = r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*"
_SENSITIVITY = re.compile(_NUMBER + r"(m?V)\s*/\s*(\S+)\s*")
_QUANTITY = re.compile(_NUMBER + r"(\S*)\s*")
_VOLTS = {"V": 1.0, "mV": 1e-3}


def correct_probes(
    signals: xr.Dataset,
    *,
    angles: npt.ArrayLike = (0.0, 90.0),
    gains: npt.ArrayLike = (1.0, 1.0),
) -> xr.Dataset:
    """Convert the readings of two probes to horizontal and vertical displacements.

    Parameters
    ----------
    signals : Dataset
        Signals of which ``x`` and ``y`` are the readings of the first and of the second probe.
    angles : array_like, shape (2,)
        Angles of the probes from the x axis in the direction of rotation [degree]: (45, 135) for
        the usual pair.
    gains : array_like, shape (2,)
        Reading over displacement of each.

    Returns
    -------
    Dataset
        Signals with displacements ``x y``.

    Raises
    ------
    InputError
        If a gain is zero, or the probes look along nearly the same line.

    Notes
    -----
    A probe at the angle a reads ``gain (x cos a + y sin a)``; two of them are solved for x and y.

    Examples
    --------
    >>> from rotor_ida import Rotor, signals_of, simulate
    >>> run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0), duration=60.0)
    >>> seen = signals_of(run)
    >>> turned = correct_probes(seen, angles=(90, 180))
    >>> abs(turned.y - seen.x).max().item() < 1e-12
    True
    """
    record = record_of(signals)
    mean = displacements(np.array([record.mean]), angles, gains)[0]
    found = with_displacements(signals, record, displacements(record.z, angles, gains))
    found.attrs["probe_angles"] = check_array("angles", angles)
    return found.assign_coords(
        {
            name: found[name].copy(data=value)
            for name, value in zip(MEAN, (mean.real, mean.imag), strict=True)
            if name in found.coords
        }
    )


def subtract_runout(
    signals: xr.Dataset, slow_roll: xr.Dataset, *, harmonics: int = 1
) -> xr.Dataset:
    """Subtract runout, as from a bent shaft or a scratch, measured at low speed.

    Parameters
    ----------
    signals : Dataset
        Signals of `signals_of` or `read_signals`.
    slow_roll : Dataset
        Signals of the same probes and keyphasor at low speed, without whirl: often a part of the
        signals, ``signals.sel(t=slice(0, 10))``.
    harmonics : int
        Highest multiple of the speed up to which runout is subtracted [dimensionless]: 1 for a bent
        shaft, more for scratches and flats.

    Returns
    -------
    Dataset
        Signals without runout. The mean position is unchanged.

    Raises
    ------
    InputError
        If an angle is not known, the slow roll has no whole revolution, or too few samples.

    Notes
    -----
    In the slow roll ``sum(c_n exp(i n theta))`` is fitted to ``z`` over whole revolutions. Its
    terms from -harmonics to harmonics except 0 are subtracted at each angle. The actual whirl at
    low speed is subtracted too: in a rigid bearing about ``(omega/omega_n)**2`` of the
    eccentricity. The attributes ``slow_roll_speeds`` and ``slow_roll_error`` keep the speeds and
    the standard error of an amplitude, by which `fit` allows for both.

    References
    ----------
    API Standard 670: runout, and its compensation by a slow-roll vector.

    Examples
    --------
    >>> from rotor_ida import Rotor, signals_of, simulate
    >>> run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0), duration=60.0)
    >>> seen = signals_of(run)
    >>> bent = seen.assign(x=seen.x + 0.2 * np.cos(seen.angle), y=seen.y + 0.2 * np.sin(seen.angle))
    >>> slow = bent - seen
    >>> slow["angle"] = seen.angle
    >>> abs(subtract_runout(bent, slow).x - seen.x).max().item() < 1e-12
    True
    """
    most = check_count("harmonics", harmonics, 1, MOST_HARMONICS)
    record, slow = record_of(signals), record_of(slow_roll, "slow_roll")
    if record.length != slow.length:
        raise InputError(f"slow_roll must be in {record.length} as signals, got {slow.length}")
    angles = slow.known_angles()
    turns = (angles[-1] - angles[0] + (angles[-1] - angles[-2])) / (2.0 * math.pi)
    whole = math.floor(turns + 1e-9)
    if whole < 1:
        raise InputError(f"slow_roll must have at least one revolution, got {turns:.3g}")
    window = windows_of(slow, whole)
    if window.edges[1] <= (2 * most + 1) * whole:
        raise InputError(
            f"slow_roll must have more than {2 * most + 1} samples a revolution, got "
            f"{window.edges[1] / whole:.3g}"
        )
    orders = np.arange(-most, most + 1.0)
    fitted = fit_orders(slow, window, orders)
    amplitudes = fitted.amplitudes[0]
    z = record.z.copy()
    for order, amplitude in zip(orders, amplitudes, strict=True):
        if order != 0.0:
            z -= amplitude * np.exp(1j * order * record.known_angles())
    found = with_displacements(signals, record, z)
    up_to = "order 1" if most == 1 else f"orders up to {most}"
    told = f"the runout of {up_to} in {whole} revolutions of a slow roll is subtracted"
    notes = "; ".join(filter(None, [str(found.attrs.get("notes", "")), told]))
    speeds = windows_of(slow, 1).speeds
    chosen = np.linspace(0.0, speeds.size - 1.0, min(speeds.size, MOST_SPEEDS)).astype(int)
    return found.assign_attrs(
        notes=notes, slow_roll_speeds=speeds[chosen], slow_roll_error=fitted.errors[0].mean()
    )


def slow_part(signals: xr.Dataset, times: npt.ArrayLike | Sequence[str]) -> xr.Dataset:
    """Return the part of signals between two times, in which the rotor turns slowly.

    They are in the unit of the times of the signals, or in words such as ``"34.5 s"``.
    """
    if isinstance(times, list | tuple) and all(isinstance(each, str) for each in times):
        found = _quantities(times)
        if {each.unit.kind for each in found} != {"time"}:
            raise InputError(f"slow_roll must be two times such as '34.5 s', got {shown(times)}")
        times = [each.number * each.unit.factor for each in found]
    ends = check_increasing("slow_roll", check_vector("slow_roll", times))
    if ends.size != 2:
        raise InputError(f"slow_roll must be two times or a file, got {shown(ends.tolist())}")
    low, high = ends.tolist()
    whole = signals["t"].values
    room = ROOM * np.ptp(whole)  # a record of 10 s ends one step before
    if low < whole[0] - room or high > whole[-1] + room:
        raise InputError(
            f"slow_roll must lie within {whole[0]:g} to {whole[-1]:g}, got {low:g} {high:g}"
        )
    part = signals.sel(t=slice(low, high))
    record, slow = record_of(signals), record_of(part, "slow_roll")
    angles, turned = record.known_angles(), slow.known_angles()
    fastest = float(np.abs(np.diff(angles) / np.diff(record.times)).max())
    part_of_it = abs(float((turned[-1] - turned[0]) / np.ptp(slow.times))) / fastest
    if part_of_it > HOW_SLOW:
        raise InputError(
            "slow_roll must be a part in which the rotor turns slowly, but there it turns at "
            f"{part_of_it:.0%} of its largest speed on average"
        )
    return part


def displacements(z: Complex, angles: npt.ArrayLike, gains: npt.ArrayLike) -> Complex:
    """Return ``x + i y`` from the readings of two probes, given as real and imaginary part."""
    (first, second), scale = np.radians(_pair("angles", angles)), _pair("gains", gains)
    if (np.abs(scale) < 1.0 / LARGEST_NUMBER).any():
        raise InputError(
            f"gains must be at least {1.0 / LARGEST_NUMBER:g} in size, got {scale.tolist()}"
        )
    if (first, second) == (0.0, math.pi / 2.0):
        return np.asarray(z.real / scale[0] + 1j * (z.imag / scale[1]), dtype=np.complex128)
    between = math.sin(second - first)
    if abs(between) < NEARLY_ALONG:
        raise InputError(
            "angles must be of two probes that do not point along one line, got "
            f"{np.degrees([first, second]).round(6).tolist()}"
        )
    a, b = z.real / scale[0], z.imag / scale[1]
    x = (a * math.sin(second) - b * math.sin(first)) / between
    y = (b * math.cos(first) - a * math.cos(second)) / between
    return np.asarray(x + 1j * y, dtype=np.complex128)


def angles_of_probes(
    given: npt.ArrayLike | None, names: Mapping[str, str], rotation: Rotation
) -> tuple[Values, list[str]]:
    """Return the angles of two probes where the rotor turns counterclockwise, and notes."""
    notes = []
    if given is None:
        named = angles_in(names["x"], names["y"])
        given = named or (0.0, 90.0)
        why = "by their names" if named else "as no probe_angles are given"
        first, second = (f"{each:g}" for each in given)
        notes.append(f"probes are taken to be at {first} and {second} degrees, {why}")
    angles = check_array("probe_angles", given)
    if rotation == "clockwise":
        angles = 180.0 - angles
        notes.append("the rotor turns clockwise: it is shown from its other end")
    return angles, notes


def question_of_swapped(signals: xr.Dataset) -> list[str]:
    """Return a question where 1X whirls backward in all windows: unbalance drives it forward."""
    try:
        record = record_of(signals)
        windows = windows_of(record, 1)
        amplitudes = np.abs(fit(record, windows, np.array([1.0])).amplitudes)
    except InputError:  # no angle, or too few samples
        return []
    if (amplitudes[:, 1] < CLEARLY * amplitudes[:, 0]).any():
        return []
    return [
        f"1X whirls backward in all of {windows.times.size} windows: are the probes swapped, or "
        "does the rotor turn the other way (rotation)?"
    ]


def mean_position(z: Complex, times: Values, rotation: Mapping[str, xr.Variable]) -> complex:
    """Return the mean of whole revolutions, or of all samples without one."""
    within = np.ones(times.size, dtype=bool)
    if "keyphasor" in rotation:
        pulses = rotation["keyphasor"].values
        within = (times >= pulses[0]) & (times < pulses[-1])
    elif "angle" in rotation:
        turns = (rotation["angle"].values - rotation["angle"].values[0]) / (2.0 * math.pi)
        within = turns < math.floor(turns[-1]) - EDGE
    return complex(z[within].mean() if within.any() else z.mean())


def with_displacements(signals: xr.Dataset, record: Record, z: Complex) -> xr.Dataset:
    """Return signals with new displacements; keyphasor and angle are unchanged."""
    columns = {"x": ("t", z.real), "y": ("t", z.imag)}
    found = record.dataset(
        "Signals of two probes", columns, {"t": ("t", record.times)}, kind="signals"
    )
    if "keyphasor" in signals.variables:
        return found.assign(keyphasor=signals["keyphasor"].variable)
    if record.angles is None:
        return found
    return found.assign(angle=record.variable("angle", "t", record.angles))


def _pair(name: str, values: npt.ArrayLike) -> Values:
    """Return two numbers."""
    pair = check_array(name, values, largest=LARGEST_NUMBER)
    if pair.shape != (2,):
        raise InputError(
            f"{name} must be two numbers, one for each probe, got {shown(pair.tolist())}"
        )
    return pair


def displaced(name: str, values: Values, unit: str, sensitivity: str) -> tuple[Values, str]:
    """Return displacements of readings in V or mV."""
    if unit not in ("V", "mV"):
        raise InputError(f"sensitivity must be of readings in V or mV, got {name} in {unit}")
    found = _SENSITIVITY.fullmatch(sensitivity) if isinstance(sensitivity, str) else None
    length = unit_called(found[3]) if found else None
    height = number_in(found[1]) if found else math.nan
    low, high = SENSITIVITIES
    if not (found and length and length.kind == "length" and low <= height <= high):
        raise InputError(
            f"sensitivity must be such as '200 mV/mil' or '7.87 V/mm', got {shown(sensitivity)}"
        )
    per_length = height * _VOLTS[found[2]] / length.factor
    return values * _VOLTS[unit] / per_length, length.plain


def scaled(
    name: str, values: Values, unit: str, sensitivity: str | None, length: str | None
) -> tuple[Values, str]:
    """Return readings as displacements, in a chosen unit of length; None leaves them as they are.

    The gap may be given in a unit of length beside a sensitivity.
    """
    if sensitivity is not None and (name != "gap" or unit in _VOLTS):
        values, unit = displaced(name, values, unit, sensitivity)
    if length is None or unit == length:
        return values, unit
    sizes = _VOLTS if unit in _VOLTS and length in _VOLTS else LENGTHS
    if unit not in sizes or length not in sizes:
        raise InputError(
            f"{name} must be in a unit of length to be shown in {length}, got "
            f"{'no unit' if unit == '1' else unit}; give units, or the sensitivity of probes in V"
        )
    return values * (sizes[unit] / sizes[length]), length


def displacements_at(
    sensitivity: str | None, length: str, angles: Values, gains: npt.ArrayLike, seen: Values,
    readings: Values, unit: str,
) -> Complex:  # fmt: skip
    """Return ``x + i y`` in a unit of length where two probes have these readings, one number.

    Readings of the other sign than all of those `seen`, shape (2, n), are refused.
    """
    (x, y), _ = scaled("gap", readings, unit, sensitivity, length)
    for probe, each, own in zip("xy", (x, y), seen, strict=True):
        if (own * each < 0.0).all():
            raise InputError(
                f"gap must have the sign of the readings, which are all "
                f"{'negative' if each > 0.0 else 'positive'} at {probe}, got "
                f"{readings['xy'.index(probe)]:g} {unit}"
            )
    return displacements(np.array([x + 1j * y]), angles, gains)


class Quantity(NamedTuple):
    """A number with its unit, and both in words."""

    number: float
    unit: Unit
    words: str


def _quantities(given: object) -> list[Quantity]:
    """Return a quantity, or several, that are given in words; none if one is something else."""
    words = given if isinstance(given, list | tuple) else [given]
    found = []
    for each in words:
        match = _QUANTITY.fullmatch(each) if isinstance(each, str) else None
        unit = unit_called(match[2]) if match else None
        if match is None or unit is None:
            return []
        told = f"{match[1]} {match[2]}".rstrip()
        found.append(Quantity(number_in(match[1]), unit, told))
    return found


def gap_position(
    gap: str | Sequence[str],
    z: Complex,
    times: Values,
    of_readings: Callable[[Values, str], Complex],
) -> tuple[complex, str]:
    """Return the position of the shaft at the gap, of two readings or a stretch, and its words.

    Parameters
    ----------
    gap : str or sequence of str
        As for `rotor_ida.read_signals`.
    z : ndarray of complex, shape (n,)
        Displacements.
    times : ndarray, shape (n,)
        Their times.
    of_readings : callable
        Takes the readings of both probes and their unit, and returns displacements.
    """
    found = _quantities(gap)
    kinds, told = {each.unit.kind for each in found}, [each.words for each in found]
    if len(found) == 2 and kinds == {"time"}:
        begin, end = (each.number * each.unit.factor for each in found)
        within = (times >= begin) & (times <= end)
        if within.any():
            return complex(z[within].mean()), f"the mean from {' to '.join(told)}"
        raise InputError(
            f"gap must be a stretch within {times[0]:g} to {times[-1]:g}, got {begin:g} to {end:g}"
        )
    is_zero = kinds == {"any"} and not any(each.number for each in found)
    if len(found) <= 2 and len({each.unit for each in found}) == 1 and (
        kinds == {"length"} or is_zero
    ):  # fmt: skip
        both, unit = np.resize([each.number for each in found], 2), found[0].unit
        position = of_readings(both * unit.factor, unit.plain)[0] if both.any() else 0.0
        return complex(position), " and ".join(told)
    raise InputError(
        "gap must be the reading of both probes or of each, such as '-10 V', two times such as "
        f"'0 s' and '2 s', or '0', got {shown(gap)}"
    )


def check_columns(
    found: Mapping[str, tuple[Values, str]], times: Mapping[str, Values], accept_clipped: bool
) -> str:
    """Return the unit of both probes; raise `InputError` if they differ or one is clipped.

    Likewise if a column that is sampled over its `times` has another length.
    """
    (x, length), (y, other) = found["x"], found["y"]
    if length != other:
        raise InputError(f"x and y must be in one unit, got {length} and {other}")
    for name in [each for each in ("x", "y", "angle", "speed") if each in found]:
        if (size := found[name][0].size) != times[name].size:
            raise InputError(
                f"{name} must have one number for each t, got {size} for {times[name].size}"
            )
    for name, values in () if accept_clipped else (("x", x), ("y", y)):
        where = _clipped_at(values)
        if where is not None:
            raise InputError(
                f"{name} must not be clipped, but stays at {values[where]:.6g} from t "
                f"{times[name][where]:.6g} on; accept_clipped=True accepts it"
            )
    return length


def _clipped_at(values: Values) -> int | None:
    """Return where a reading first stays at its largest or smallest value, after a jump to it."""
    leaps = np.abs(np.diff(values))
    moving = leaps[leaps > 0.0]
    if not moving.size:
        return None
    # a smooth peak is reached in steps of one digit, a clipped one in a step of many
    finest = float(moving.min())
    for extreme in (values.max(), values.min()):
        at = np.concatenate([[0], (values == extreme).astype(np.int8), [0]])
        starts, ends = np.flatnonzero(np.diff(at) == 1), np.flatnonzero(np.diff(at) == -1)
        for start in starts[ends - starts >= CLIPPED]:
            if start > 0 and leaps[start - 1] > LEAP * finest:
                return int(start)
    return None
