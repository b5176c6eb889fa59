"""Speeds along a picture of signals: marks of round ones, parts that rise and fall, titles."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.ticker import MaxNLocator

from rotor_ida.arrays import Values
from rotor_ida.plot import legends, palette
from rotor_ida.plot.appearance import draw_marks
from rotor_ida.plot.datasets import parameters_in
from rotor_ida.plot.labels import SEPARATOR, lengths_text, text_of, title_of
from rotor_ida.plot.signals.units import is_one_speed
from rotor_ida.signals.record import MEAN
from rotor_ida.texts import brief
from rotor_ida.units import SPEED_UNITS, quantity

# A reversal of the speed is noise if it is smaller than this fraction of the largest, or than this
# multiple of the noise of the speed.
WOBBLE, NOISE = 0.02, 5.0
MOST_MARKS = 8
# Characters of a file's name or a caption in a title, and of a line of it in a narrow figure.
LONGEST = 48


class Leg(NamedTuple):
    """A part in which the speed rises or falls: its windows, words and style."""

    part: slice
    words: str
    colour: str
    dashes: object


def title_of_signals(dataset: xr.Dataset, speeds: xr.DataArray, *, zero: bool = False) -> str:
    """Return the title of signals: of a run its rotor, of a measured file what it is.

    Parameters
    ----------
    dataset : Dataset
        Signals, or what was computed of them.
    speeds : DataArray, shape (n,)
        Speeds over which they are drawn, in rpm if they have a unit; none if they are not known.
    zero : bool
        Whether the position from which displacements are counted is named.
    """
    lines = [_rotor_in(dataset, speeds)]
    if "file" in dataset.attrs:
        parts = [str(dataset.attrs[name]) for name in ("file", "caption") if name in dataset.attrs]
        if speeds.size and speeds.attrs["units"] == "rpm":
            parts.append(_range_in_rpm(speeds.values))
        parts = [brief(each, LONGEST).replace("$", r"\$") for each in parts]
        told = SEPARATOR.join(parts)
        lines += [told] if len(told) <= LONGEST else [SEPARATOR.join(parts[:-1]), parts[-1]]
    if zero and set(MEAN) <= set(dataset.variables):
        unit = str(dataset[MEAN[0]].attrs.get("units", "1"))
        (x, y), shown = lengths_text(unit, *(float(dataset[name]) for name in MEAN))
        lines.append(f"mean position subtracted: $x = {x}$, $y = {y}$ {shown}".rstrip())
    elif zero and dataset.attrs.get("gap", "0") != "0":
        gap = str(dataset.attrs["gap"]).replace("-", "\N{MINUS SIGN}")
        lines.append(f"displacements from the gap of {gap}")
    return "\n".join(filter(None, lines))


def _rotor_in(dataset: xr.Dataset, speeds: xr.DataArray) -> str:
    """Return the parameters in a dataset, without a speed that changes; of a system its node."""
    if "node" in dataset.coords:
        return title_of("signals", dataset)
    one_speed = not speeds.size or is_one_speed(speeds.values)
    known = {
        name: float(dataset[name])
        for name in parameters_in(dataset)
        if not dataset[name].ndim and (name != "omega" or one_speed)
    }
    return text_of(dataset, known)


def _range_in_rpm(speeds: Values) -> str:
    """Return the speeds of a record in words.

    Examples
    --------
    >>> _range_in_rpm(np.array([512.34, 5000.0])), _range_in_rpm(np.array([600.0, 600.01]))
    ('512 to 5,000 rpm', '600 rpm')
    """
    if is_one_speed(speeds):
        return quantity(float(speeds.mean()) * SPEED_UNITS["rpm"], "rad/s")
    return f"{speeds.min():,.0f} to {speeds.max():,.0f} rpm"


def legs_of(speeds: Values, words: str) -> list[Leg]:
    """Return the parts in which the speed rises and falls, with their words and styles."""
    turns = _turning_points(speeds)
    if len(turns) == 2:
        return [Leg(slice(None), words, palette.BLUE, "-")]
    legs: list[Leg] = []
    for begin, end in pairwise(turns):
        part = slice(begin, end + 1)
        if speeds[end] > speeds[begin]:
            legs.append(Leg(part, f"{words}: {legends.GOING_UP}", palette.BLUE, "-"))
        else:
            legs.append(Leg(part, f"{words}: {legends.GOING_DOWN}", palette.ORANGE, (0, (6, 1.2))))
    return legs


def _turning_points(speeds: Values) -> list[int]:
    """Return the indices of first and last speed, and of its reversals."""
    from scipy.signal import find_peaks  # noqa: PLC0415 - takes long to import

    # the second differences of a steady ramp are noise alone
    noise = float(np.median(np.abs(np.diff(speeds, 2)))) if speeds.size > 2 else 0.0
    least = max(WOBBLE * float(np.abs(speeds).max(initial=0.0)), NOISE * noise)
    turns = [find_peaks(sign * speeds, prominence=least)[0] for sign in (1.0, -1.0)]
    return [0, *np.sort(np.concatenate(turns)).tolist(), speeds.size - 1]


def mark_speeds(
    ax: Any, z: npt.NDArray[np.complex128], speeds: xr.DataArray, colour: str, *, apart: float,
    label: str = "_",
) -> None:  # fmt: skip
    """Mark round speeds along a vector's path, with numbers unless these would overlap."""
    low, high = float(speeds.min()), float(speeds.max())
    if is_one_speed(speeds.values):
        return
    polar = ax.name == "polar"
    rising = bool(speeds[-1] >= speeds[0])
    order = np.argsort(speeds.values, kind="stable")
    ticks = MaxNLocator(nbins=2 * MOST_MARKS, steps=[1, 2, 5, 10]).tick_values(low, high)
    ticks = [tick for tick in ticks if low <= tick <= high]
    along = speeds.values[order]
    places = np.interp(ticks, along, z[order].real) + 1j * np.interp(ticks, along, z[order].imag)
    across, up = (np.angle(places), np.abs(places)) if polar else (places.real, places.imag)
    draw_marks(ax, across, up, "o", palette.INK, size=3.2, face=colour, edge=0.5, label=label,
               level=3.4)  # fmt: skip
    named: list[complex] = []
    for tick, place, *point in zip(ticks, places.tolist(), across, up, strict=True):
        if any(abs(place - other) <= apart for other in named):
            continue
        # outside of a run-up's way, and inside of a run-down's
        right = (place.real >= 0.0) == rising
        named.append(place)
        ax.annotate(
            f"{tick:.6g}", point, xytext=(5 if right else -5, 0), textcoords="offset points",
            fontsize=7.0, ha="left" if right else "right", va="center_baseline", zorder=3.5,
        )  # fmt: skip
