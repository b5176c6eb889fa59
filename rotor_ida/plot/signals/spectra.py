"""Full spectra: of a record, and of one segment after the other over the speed or time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    check_array,
    check_choice,
    check_count,
    check_flag,
    check_positive,
    check_real,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    BLUE,
    DASHES,
    GREEN,
    INK,
    ORANGE,
    RED,
    axes_or_new,
    check_dataset,
    legend_below,
    style,
)
from rotor_ida.plot.decimation import highest_in_bins, kept_in_columns
from rotor_ida.plot.labels import LABELS, label_axis, label_of, number_text
from rotor_ida.plot.signals.beneath import Line, lines_of
from rotor_ida.plot.signals.tracks import Beneath, order_words
from rotor_ida.plot.signals.units import STEADY, Units, is_one_speed, title_of, units_of
from rotor_ida.signals.record import Record, record_of
from rotor_ida.signals.spectra import full_spectrum, spectrogram

OVER = ("speed", "t")
# The words for frequencies without and with a unit.
FREQUENCY = (LABELS["frequency"], "frequency")
ORDERS = (-1.0, 0.5, 1.0, 2.0)
# Rows of a cascade, and rows and columns of a spectrogram.
ROWS, DOTS_UP, DOTS_ACROSS = 60, 500, 900
# Points of one line of a cascade.
POINTS = 1000
# Height of the tallest line of a cascade, of the range of its speeds.
TALLEST = 0.25
# A line at the edge of a picture is in it, whatever rounding did.
SLACK = 1e-9
COLOURS = "YlGnBu"
FLOOR = 1e-3
# Segments of which a picture is made overlap by this part.
OVERLAP = 0.75
LEAST_SEGMENT = 64


def plot_full_spectrum(
    signals: xr.Dataset,
    *,
    span: float = 4.0,
    segment: int | None = None,
    beneath: Beneath = (),
    frequencies: Mapping[str, float] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw forward and backward lines over the frequency, with bandwidth and noise floor.

    Parameters
    ----------
    signals : Dataset
        Signals, a run, or what `rotor_ida.full_spectrum` made of one.
    span : float
        Largest frequency shown, over the speed if there is one, over half of the sampling rate
        otherwise [1].
    segment : int, optional
        As of `rotor_ida.full_spectrum`, where that is still to be computed.
    beneath : Dataset or sequence of Dataset
        Exact results whose lines are marked: of `rotor_ida.limit_cycle`,
        `rotor_ida.backward_whirl` and `rotor_ida.synchronous_response`.
    frequencies : mapping of str to float, optional
        Further frequencies to mark, by the words for them: natural ones, for instance. In Hz if
        times have a unit; negative for backward whirl.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=1.7, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), duration=600,
    ...                samples=6001)
    >>> ax = plot_full_spectrum(run.sel(t=slice(300, None)))
    >>> [text.get_text().partition(" $")[0] for text in ax.get_legend().get_texts()]
    ['backward', 'forward', 'spin speed', 'noise floor', 'bandwidth']
    """
    given = check_dataset("signals", signals, ())
    held = given if "noise_floor" in given.variables else full_spectrum(given, segment=segment)
    units = units_of(held, "whirl_amplitude", "frequency")
    exact = lines_of(beneath, held, units)
    frequency = units.frequencies(held["frequency"].values)
    limit, spin = _limit_of(held, frequency.values, check_positive("span", span))
    height = held["whirl_amplitude"].values
    highest, noise = float(height.max(initial=0.0)) or 1.0, float(held["noise_floor"])
    with style():
        ax = axes_or_new(ax, width=6.0, height=3.8)
        label_axis(ax.xaxis, "frequency", frequency, words=FREQUENCY[units.rate is not None])
        label_axis(ax.yaxis, "whirl_amplitude", units.lengths(height))
        for words, colour, chosen in (
            ("backward", ORANGE, frequency.values <= 0.0),
            ("forward", BLUE, frequency.values >= 0.0),
        ):
            ax.semilogy(*_peaks_kept(frequency.values[chosen], height[chosen], limit), color=colour,
                        lw=0.9, label=words, zorder=2.4)  # fmt: skip
        if not math.isnan(spin):
            ax.axvline(spin, color=INK, lw=0.6, ls=DASHES, zorder=1.6, label="spin speed")
        ax.axhline(noise, color=INK, lw=0.8, ls=(0, (1, 1.4)), zorder=2.6,
                   label=f"noise floor ${number_text(noise)}$")  # fmt: skip
        _draw_bandwidth(ax, held, units, limit)
        _draw_lines(ax, exact, limit)
        _draw_frequencies(ax, frequencies)
        ax.set_xlim(-limit, limit)
        tallest = max(
            [highest, *(line.amplitude for line in exact if abs(line.frequency) <= limit)]
        )
        ax.set_ylim(max(0.2 * noise, 1e-12 * highest), 4.0 * tallest)
        _name_orders(ax, spin, limit)
        ax.set_title(title_of(held, one_speed=not math.isnan(spin)), pad=16.0)
        legend_below(ax, columns=4)
    return ax


def plot_cascade(
    signals: xr.Dataset,
    *,
    over: str | None = None,
    orders: npt.ArrayLike = ORDERS,
    span: float = 3.0,
    rows: int = ROWS,
    segment: int | None = None,
    beneath: Beneath = (),
    frequencies: Mapping[str, float] | None = None,
    ax: Axes | None = None,
) -> Axes:
    r"""Draw full spectra one behind the other over the speed: a waterfall, with lines of orders.

    Parameters
    ----------
    signals : Dataset
        Signals, a run or run-up, or what `rotor_ida.spectrogram` made of one.
    over : {"speed", "t"}, optional
        What the spectra are ordered by; by default the speed if it changes and never turns back.
    orders : array_like
        Multiples of the speed along which a line is drawn, negative for backward whirl [1].
    span : float
        Largest frequency shown, over the largest speed [1].
    rows : int
        Number of spectra. Where there are more segments, each shows the largest of its segments
        at every frequency.
    segment : int, optional
        Samples in a segment, as of `rotor_ida.spectrogram`, where that is still to be computed. By
        default so many that the speed changes in a segment by as much as a line is wide; at one
        speed an eighth of the record.
    beneath, frequencies
        As of `plot_full_spectrum`; what is told for one speed is marked there.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> up = run_up(Rotor(omega=0.3, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), to=2.5,
    ...             rate=0.005, samples=20_001)
    >>> plot_cascade(up).get_ylabel()
    'spin speed $\\omega$'
    """
    held, units, exact = _prepared(signals, segment, beneath)
    across, up, name = _axes_of(held, units, over)
    limit = _span_of(held, units, across.values, span)
    chosen = np.abs(across.values) <= limit * 1.001
    frequency, heights = across.values[chosen], held["whirl_amplitude"].values[:, chosen]
    places, heights = _in_rows(up.values, heights, check_count("rows", rows))
    frequency, heights = _in_columns(frequency, heights, POINTS)
    extent = float(np.ptp(places)) or 1.0
    highest = float(heights.max(initial=0.0)) or 1.0
    scale = TALLEST * extent / highest
    with style():
        ax = axes_or_new(ax, width=6.0, height=5.6)
        label_axis(ax.xaxis, "frequency", across, words=FREQUENCY[units.rate is not None])
        label_axis(ax.yaxis, name, up)
        # the farthest first, so that each hides what is behind it, down to the edge of the picture
        lines = [
            np.column_stack([frequency, place + scale * height])
            for place, height in zip(places[::-1], heights[::-1], strict=True)
        ]
        below = np.column_stack([frequency[[-1, 0]], np.full(2, places[0] - extent)])
        under = [np.vstack([line, below]) for line in lines]
        ax.add_collection(
            PolyCollection(under, facecolors="white", edgecolors=INK, linewidths=0.45, zorder=2.2)
        )
        ax.set_xlim(-limit, limit)
        top = float((places[:, None] + scale * heights).max())
        ax.set_ylim(places[0] - 0.01 * extent, top + 0.03 * extent)
        _draw_orders(ax, held, units, up.values, orders, limit)
        _mark_lines(ax, exact, held, units, name, limit)
        _draw_frequencies(ax, frequencies)
        _draw_scale(ax, units, highest, scale)
        ax.grid(visible=False)
        ax.set_title(title_of(held, one_speed=_one_speed(held)), pad=16.0)
        if exact or frequencies:
            legend_below(ax, columns=3)
    return ax


def plot_spectrogram(
    signals: xr.Dataset,
    *,
    over: str | None = None,
    orders: npt.ArrayLike = ORDERS,
    span: float = 3.0,
    floor: float = FLOOR,
    segment: int | None = None,
    beneath: Beneath = (),
    frequencies: Mapping[str, float] | None = None,
    colour_bar: bool = True,
    ax: Axes | None = None,
) -> Axes:
    """Draw the amplitudes of forward and backward whirl as colours over frequency and speed.

    Parameters
    ----------
    signals, over, orders, span, segment, beneath, frequencies
        As of `plot_cascade`.
    floor : float
        Least amplitude that has a colour of its own, over the largest [1].
    colour_bar : bool
        Whether the colours are explained by a bar.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Notes
    -----
    The colours darken with the logarithm of the amplitude, also in grey. Where there are more
    segments or frequencies than dots, a dot has the largest of its amplitudes.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> up = run_up(Rotor(omega=0.3, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), to=2.5,
    ...             rate=0.005, samples=20_001)
    >>> plot_spectrogram(up, over="t").get_ylabel()
    'time $t$'
    """
    check_flag("colour_bar", colour_bar)
    least = check_positive("floor", floor, 0.9)
    held, units, exact = _prepared(signals, segment, beneath)
    across, up, name = _axes_of(held, units, over)
    limit = _span_of(held, units, across.values, span)
    chosen = np.abs(across.values) <= limit * 1.001
    frequency, heights = across.values[chosen], held["whirl_amplitude"].values[:, chosen]
    places, heights = _in_rows(up.values, heights, DOTS_UP)
    frequency, heights = _in_columns(frequency, heights, DOTS_ACROSS)
    highest = float(heights.max(initial=0.0)) or 1.0
    with style():
        ax = axes_or_new(ax, width=6.0, height=4.6)
        label_axis(ax.xaxis, "frequency", across, words=FREQUENCY[units.rate is not None])
        label_axis(ax.yaxis, name, up)
        mesh = ax.pcolormesh(
            _edges(frequency), _edges(places), heights, rasterized=True,
            cmap=colormaps[COLOURS].with_extremes(under="white"),
            norm=LogNorm(least * highest, highest), zorder=1.5,
        )  # fmt: skip
        ax.set_xlim(-limit, limit)
        _draw_orders(ax, held, units, up.values, orders, limit)
        _mark_lines(ax, exact, held, units, name, limit)
        _draw_frequencies(ax, frequencies)
        ax.grid(visible=False)
        ax.set_title(title_of(held, one_speed=_one_speed(held)), pad=16.0)
        if colour_bar:
            bar = ax.figure.colorbar(mesh, ax=ax, extend="min", pad=0.02, aspect=30.0)
            bar.set_label(label_of("whirl_amplitude", units.lengths(heights)))
        if exact or frequencies:
            legend_below(ax, columns=3)
    return ax


def _prepared(
    signals: xr.Dataset, segment: int | None, beneath: Beneath
) -> tuple[xr.Dataset, Units, list[Line]]:
    """Return the spectra of segments, computed if they are not yet, their units, and lines."""
    given = check_dataset("signals", signals, ())
    ready = {"whirl_amplitude", "window", "frequency"} <= set(given.variables)
    if ready:
        held = given
    else:
        record = record_of(given)
        size = _segment_for(record) if segment is None else segment
        held = spectrogram(given, segment=size, overlap=OVERLAP)
    units = units_of(held, "whirl_amplitude", "frequency")
    return held, units, lines_of(beneath, held, units, over_speed=not _one_speed(held))


def _segment_for(record: Record) -> int:
    """Return how many samples make a segment whose lines are as narrow as the speed allows."""
    size, step = record.times.size, record.equal_step()
    length = size * step / 8.0
    if record.angles is not None:
        speeds = np.gradient(record.angles, step)
        change = float(np.ptp(speeds[:: max(1, size // 1000)])) / (size * step)
        if change * length * size * step > STEADY * float(np.abs(speeds).max()) * length:
            # a line of a Hann window is 1.5 over the length wide
            length = min(length, math.sqrt(3.0 * math.pi / change))
    return int(np.clip(length / step, LEAST_SEGMENT, size))


def _one_speed(held: xr.Dataset) -> bool:
    return "speed" not in held.variables or is_one_speed(held["speed"].values)


def _axes_of(
    held: xr.Dataset, units: Units, over: str | None
) -> tuple[xr.DataArray, xr.DataArray, str]:
    """Return frequencies, what is upwards, and its name."""
    if over is None:
        known = "speed" in held.variables and not _one_speed(held)
        steps = np.diff(held["speed"].values) if known else np.zeros(1)
        slack = 0.02 * float(np.abs(steps).sum())
        one_way = min(-steps[steps < 0.0].sum(), steps[steps > 0.0].sum()) <= slack
        over = "speed" if known and one_way else "t"
    check_choice("over", over, OVER)
    if over not in held.variables:
        raise InputError("over must be 't' where no angle of the rotor is known, got 'speed'")
    up = units.speeds(held["speed"].values) if over == "speed" else held["t"]
    return units.frequencies(held["frequency"].values), up, over


def _span_of(held: xr.Dataset, units: Units, across: Values, span: float) -> float:
    """Return the largest frequency shown."""
    wanted, all_of_it = check_positive("span", span), float(np.abs(across).max())
    if "speed" not in held.variables:
        return min(1.0, wanted) * all_of_it
    fastest = float(units.frequencies(held["speed"].values).max())
    return min(wanted * fastest, all_of_it) or all_of_it


def _limit_of(held: xr.Dataset, frequency: Values, span: float) -> tuple[float, float]:
    """Return the largest frequency shown, and that of the spin; NaN where it is not one."""
    all_of_it = float(np.abs(frequency).max())
    if "frequency_over_omega" not in held.variables:
        return min(1.0, span) * all_of_it, math.nan
    spin = float(frequency[-1] / held["frequency_over_omega"].values[-1])
    return min(span * spin, all_of_it), spin


def _in_rows(up: Values, heights: Values, rows: int) -> tuple[Values, Values]:
    """Return places that rise, and for each the largest amplitudes of what is nearest to it."""
    order = np.argsort(up, kind="stable")
    up, heights = up[order], heights[order]
    low, high = float(up[0]), float(up[-1])
    if up.size <= rows or high == low:
        return up, heights
    bins = np.minimum(((up - low) / (high - low) * rows).astype(np.intp), rows - 1)
    starts = np.flatnonzero(np.diff(bins, prepend=-1))
    middles = np.add.reduceat(up, starts) / np.diff(starts, append=up.size)
    return middles, highest_in_bins(heights, bins, 0)


def _in_columns(frequency: Values, heights: Values, columns: int) -> tuple[Values, Values]:
    """Return frequencies, and the largest amplitudes of what is nearest to each."""
    if frequency.size <= columns:
        return frequency, heights
    bins = np.arange(frequency.size) * columns // frequency.size
    starts = np.flatnonzero(np.diff(bins, prepend=-1))
    middles = np.add.reduceat(frequency, starts) / np.diff(starts, append=frequency.size)
    return middles, highest_in_bins(heights, bins, 1)


def _peaks_kept(frequency: Values, height: Values, limit: float) -> tuple[Values, Values]:
    """Return a spectrum with the smallest and largest of each column of dots."""
    chosen = np.abs(frequency) <= limit * 1.001
    frequency, height = frequency[chosen], height[chosen]
    kept = kept_in_columns(frequency, height)
    return frequency[kept], height[kept]


def _edges(middles: Values) -> Values:
    """Return the edges between places, and one beyond each end."""
    if middles.size == 1:
        return np.array([middles[0] - 0.5, middles[0] + 0.5])
    between = 0.5 * (middles[1:] + middles[:-1])
    first, last = 2.0 * middles[0] - between[0], 2.0 * middles[-1] - between[-1]
    return np.concatenate([[first], between, [last]])


def _draw_orders(
    ax: Axes, held: xr.Dataset, units: Units, up: Values, orders: npt.ArrayLike, limit: float
) -> None:
    """Draw a line along each order of the speed, with its name at the upper end."""
    if "speed" not in held.variables:
        return
    spin = units.frequencies(held["speed"].values).values
    last = int(np.argmax(up))
    for order in check_array("orders", orders).ravel().tolist():
        ax.plot(order * spin, up, color=RED, lw=0.7, ls=(0, (5, 2)), zorder=2.8)
        end = order * spin[last]
        if abs(end) <= limit:
            ax.annotate(
                order_words(order), (end, 1.0), xycoords=("data", "axes fraction"), xytext=(0, 2),
                textcoords="offset points", ha="center", va="bottom", fontsize=8.0, color=RED,
                annotation_clip=False,
            )  # fmt: skip


def _name_orders(ax: Axes, spin: float, limit: float) -> None:
    """Name whole orders along the upper edge."""
    if math.isnan(spin) or spin <= 0.0:
        return
    most = math.floor(limit / spin + 1e-9)
    step = max(1, math.ceil(most / 6))
    for order in range(-most // step * step, most + 1, step):
        if order and abs(order) <= most:
            ax.annotate(
                order_words(float(order)), (order * spin, 1.0),
                xycoords=("data", "axes fraction"), xytext=(0, 2), textcoords="offset points",
                ha="center", va="bottom", fontsize=8.0, annotation_clip=False,
            )  # fmt: skip


def _draw_bandwidth(ax: Axes, held: xr.Dataset, units: Units, limit: float) -> None:
    """Draw a bar as wide as the band from which one line gathers noise."""
    width = units.frequencies(float(held["bandwidth"]))
    unit = f" {width.attrs['units']}" if units.rate is not None else ""
    left = -0.97 * limit
    ax.plot([left, left + float(width)], [0.95, 0.95], transform=ax.get_xaxis_transform(),
            color=GREEN, lw=2.5, solid_capstyle="butt",
            label=f"bandwidth ${number_text(float(width))}${unit}")  # fmt: skip


def _draw_lines(ax: Axes, exact: Sequence[Line], limit: float) -> None:
    """Mark exact lines by their amplitudes, those at the edges of the picture as a whole."""
    told: set[str] = set()
    for line in exact:
        if abs(line.frequency) <= limit * (1.0 + SLACK):
            words = "_" if line.words in told else line.words
            told.add(line.words)
            ax.plot(line.frequency, line.amplitude, ls="", marker=line.marker, ms=5.0, mfc="none",
                    mec=line.colour, mew=1.1, label=words, zorder=3.2, clip_on=False)  # fmt: skip


def _mark_lines(
    ax: Axes, exact: Sequence[Line], held: xr.Dataset, units: Units, name: str, limit: float
) -> None:
    """Mark the frequencies of exact lines where the speed is theirs.

    Over the time that is all the way up, unless the speed changes.
    """
    told: set[str] = set()
    known = "speed" in held.variables
    speeds = units.speeds(held["speed"].values).values if known else np.empty(0)
    for line in exact:
        if abs(line.frequency) > limit * (1.0 + SLACK):
            continue
        words = "_" if line.words in told else line.words
        if name == "t" and _one_speed(held):
            told.add(line.words)
            ax.axvline(line.frequency, color=line.colour, lw=0.8, ls=(0, (1, 1.2)), label=words,
                       zorder=2.7)  # fmt: skip
            continue
        places = _crossed(speeds, line.speed, speeds if name == "speed" else held["t"].values)
        if places.size:
            told.add(line.words)
            ax.plot(np.full(places.size, line.frequency), places, ls="", marker=line.marker, ms=5.0,
                    mfc="white", mec=line.colour, mew=1.1, label=words, zorder=3.2,
                    clip_on=False)  # fmt: skip


def _crossed(speeds: Values, wanted: float, up: Values) -> Values:
    """Return what is upwards wherever the speed is one that is wanted."""
    if up is speeds:
        within = speeds.min() * (1.0 - STEADY) <= wanted <= speeds.max() * (1.0 + STEADY)
        return np.array([wanted] if within else [])
    steps = np.diff(speeds)
    before = np.flatnonzero((speeds[:-1] - wanted) * (speeds[1:] - wanted) <= 0.0)
    before = before[steps[before] != 0.0]
    part = (wanted - speeds[before]) / steps[before]
    return np.unique(up[before] + part * (up[before + 1] - up[before]))


def _draw_frequencies(ax: Axes, frequencies: Mapping[str, float] | None) -> None:
    """Mark further frequencies by their words."""
    if not isinstance(frequencies, Mapping | None):
        raise InputError(
            f"frequencies must be a mapping such as {{'bending': 18.0}}, got {shown(frequencies)}"
        )
    for number, (words, given) in enumerate((frequencies or {}).items()):
        place = check_real("a frequency", given)
        dashes = ((0, (7, 1.6, 1.2, 1.6)), (0, (3, 1.2)), (0, (1, 1)))[number % 3]
        ax.axvline(place, color=GREEN, lw=0.9, ls=dashes, zorder=2.7, label=str(words))


def _draw_scale(ax: Axes, units: Units, highest: float, scale: float) -> None:
    """Draw a bar beside the spectra that tells how high a round amplitude is."""
    power = 10.0 ** math.floor(math.log10(highest))
    size = next(each * power for each in (5.0, 2.0, 1.0) if each * power <= highest)
    unit = "" if units.length == "1" else f" {units.length.replace('u', 'µ')}"
    top = ax.get_ylim()[1]
    bottom = top - 0.03 * (top - ax.get_ylim()[0]) - size * scale
    left = ax.get_xlim()[0] * 0.96
    ax.plot([left, left], [bottom, bottom + size * scale], color=INK, lw=2.0,
            solid_capstyle="butt", zorder=3.0)  # fmt: skip
    ax.annotate(f"{size:g}{unit}", (left, bottom + 0.5 * size * scale), xytext=(4, 0),
                textcoords="offset points", va="center", fontsize=8.0, zorder=3.0,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0})  # fmt: skip
