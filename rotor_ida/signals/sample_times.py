"""Times of the samples in a measured file: by a rate, a column of few digits, or channel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import listed, shown
from rotor_ida.errors import InputError
from rotor_ida.signals.files.columns import DIFFERENT_RATE, Column, Table
from rotor_ida.signals.record import FEWEST_SAMPLES

# A step this much longer than the usual one is a gap.
GAP = 1.5
# Times count as evenly spaced within this much of their last written digit, or within this part of
# a step.
ROUNDED, EVEN = 0.6, 1e-3
# The step of a shorter record, in last digits, is wrong by more than half a percent.
FEWEST_DIGITS = 100
MOST_DECIMALS = 12


def times_of(
    found: Mapping[str, tuple[Values, str]],
    rate: float | None,
    table: Table,
    names: Mapping[str, str],
) -> tuple[Values, str]:
    """Return the times of the samples, and their unit; raise `InputError` for a gap."""
    size = found["x"][0].size
    if size < FEWEST_SAMPLES:
        raise InputError(f"the file must have at least {FEWEST_SAMPLES} samples, got {size}")
    if rate is not None:
        return np.arange(size) / rate, "s"
    if "t" not in found:
        raise InputError("the file must have a column for t, or rate must be given, got neither")
    times, unit = found["t"]
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


def with_times_of_x(
    table: Table, names: Mapping[str, str], rate: float | None
) -> tuple[Table, dict[str, Values]]:
    """Return a table whose ``t`` are the times of x, and the own times of signals with others.

    Raises
    ------
    InputError
        If they have several clocks beside a rate, or a column of times, that is for all.
    """
    of_x = table.columns[names["x"]].times
    t = table.columns.get(names.get("t", ""))
    own = {
        signal: times
        for signal, column in names.items()
        if signal not in ("t", "x") and (times := table.columns[column].times) is not None
        and times is not of_x
    }  # fmt: skip
    if of_x is None or (t is not None and t.times is None):
        if len({id(each) for each in (of_x, *own.values()) if each is not None}) > 1:
            raise InputError(
                f"t must not be one column for all, as the file has other times for "
                f"{listed(sorted(own))} than for x, got {shown(names['t'])}"
            )
        return table, {}
    if own and rate is not None:
        raise InputError(
            "rate must be left out: the file has other times for "
            f"{listed(sorted(own))} than for x, got {rate!r}"
        )
    clock = {names.get("t", "t"): Column(of_x, t.unit if t else "s", of_x)}
    return replace(table, columns={**table.columns, **clock}), own


def at_times_of_x(
    found: Mapping[str, tuple[Values, str]], times: Values, own: Mapping[str, Values]
) -> tuple[dict[str, tuple[Values, str]], Values]:
    """Return signals at those times of x at which all of them are known, and these times.

    A probe is interpolated by a cubic spline, an angle and a speed linearly.
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 - takes long to import

    step = float(np.median(np.diff(times)))
    if "y" in own and not abs(np.median(np.diff(own["y"])) / step - 1.0) <= DIFFERENT_RATE:
        raise InputError(
            f"x and y must have one sampling rate, got {1.0 / step:.6g} and "
            f"{1.0 / np.median(np.diff(own['y'])):.6g} samples a second"
        )
    begin, end = max(each[0] for each in own.values()), min(each[-1] for each in own.values())
    slack = 1e-6 * step
    within = (times >= begin - slack) & (times <= end + slack)
    if within.sum() < FEWEST_SAMPLES:
        spans = ", ".join(
            f"{name} from {each[0]:.6g} to {each[-1]:.6g}"
            for name, each in {"x": times, **own}.items()
        )
        raise InputError(f"x and the other signals must overlap in time, got {spans}")
    at, cut = times[within], dict(found)
    for name, (values, unit) in found.items():
        if name == "y" and name in own:
            cut[name] = np.asarray(CubicSpline(own[name], values)(at), dtype=np.float64), unit
        elif name in own:
            cut[name] = np.interp(at, own[name], values), unit
        elif name != "keyphasor" and values.size == times.size:
            cut[name] = values[within], unit
    return cut, at


def _evenly_spaced(times: Values, digit: float) -> Values:
    """Return times evenly spaced, if they are so to within their last written digit."""
    number = np.arange(times.size) - 0.5 * (times.size - 1)
    mean = float(times.mean())
    step = float(number @ (times - mean) / (number @ number))
    off = float(np.abs(times - mean - step * number).max())
    is_long = float(np.ptp(times)) >= FEWEST_DIGITS * digit
    if step > 0.0 and is_long and EVEN * step < off <= ROUNDED * digit:
        return np.asarray(mean + step * number, dtype=np.float64)
    return times


def _last_digit(values: Values) -> float:
    """Return the value of the last decimal place of numbers with few digits, otherwise 0.

    For numbers of single precision, return the value of their last bit.
    """
    size = float(np.abs(values).max())
    for decimals in range(MOST_DECIMALS + 1):
        scaled = values * 10.0**decimals
        if np.abs(scaled - np.rint(scaled)).max() <= 4.0 * np.spacing(size * 10.0**decimals):
            return 10.0**-decimals
    if (values.astype(np.float32) == values).all():
        return float(np.spacing(np.float32(size)))
    return 0.0
