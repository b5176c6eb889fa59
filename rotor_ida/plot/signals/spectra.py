"""Full spectra of a record, and of its segments over speed or time: cascades and spectrograms."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm

from rotor_ida.arrays import Values
from rotor_ida.checks import check_array, check_choice, check_positive, check_real, shown
from rotor_ida.errors import InputError
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import draw_marks, drawing
from rotor_ida.plot.datasets import check_dataset
from rotor_ida.plot.decimation import kept_in_columns
from rotor_ida.plot.labels import label_axis, label_of, number_text, unit_of
from rotor_ida.plot.legends import legend_below
from rotor_ida.plot.signals.beneath import Beneath, Line, lines_of
from rotor_ida.plot.signals.exact_motion import speeds_along
from rotor_ida.plot.signals.orders import order_words
from rotor_ida.plot.signals.speeds import title_of_signals
from rotor_ida.plot.signals.units import Units, is_one_speed, units_of
from rotor_ida.signals.record import record_of
from rotor_ida.signals.spectra import STEADY, full_spectrum, segment_for, spectrogram

# Includes a line at the edge of a plot despite rounding.
SLACK = 1e-9
# Styles of further frequencies.
DASHES_OF_FREQUENCIES = ((0, (7, 1.6, 1.2, 1.6)), (0, (3, 1.2)), (0, (1, 1)))
OVER = ("speed", "t")
ORDERS = (-1.0, 0.5, 1.0, 2.0)
# Rows of a cascade, and rows and columns of a spectrogram.
ROWS, DOTS_UP, DOTS_ACROSS = 60, 500, 900
# Points of one line of a cascade.
POINTS = 1000
# Height of the tallest line of a cascade, as a fraction of the range of speeds.
TALLEST = 0.25
COLOURS = "YlGnBu"
FLOOR = 1e-3
# Overlap of segments.
OVERLAP = 0.75


def plot_full_spectrum(
    signals: xr.Dataset, *, span: float = 4.0, segment: int | None = None, beneath: Beneath = (),
    frequencies: Mapping[str, float] | None = None, ax: Axes | None = None,
) -> Axes:  # fmt: skip
    """Draw forward and backward lines over the frequency, with bandwidth and noise floor.

    Parameters
    ----------
    signals : Dataset
        Signals, a run, or the result of `rotor_ida.full_spectrum`.
    span : float
        Largest frequency shown, over the largest speed if known, otherwise over half the sampling
        rate [dimensionless].
    segment : int, optional
        As in `rotor_ida.full_spectrum`, if that is still to be computed.
    beneath : Dataset or sequence of Dataset
        Exact results whose lines are marked: of `rotor_ida.limit_cycle`,
        `rotor_ida.backward_whirl` and `rotor_ida.synchronous_response`.
    frequencies : mapping of str to float, optional
        Further frequencies to mark, by label: natural frequencies, for instance. In Hz if times
        have a unit; negative for backward whirl.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

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
    ready = "noise_floor" in given.variables
    spectrum = given if ready else full_spectrum(given, segment=segment)
    units = units_of(spectrum, "whirl_amplitude", "frequency")
    exact = lines_of(beneath, spectrum, units)
    frequency = units.frequencies(spectrum["frequency"].values)
    turning, spin = (
        np.empty(0) if ready else units.frequencies(speeds_along(given)).values,
        math.nan,
    )
    if "frequency_over_omega" in spectrum.variables:
        spin = float(frequency[-1] / spectrum["frequency_over_omega"].values[-1])
        turning = np.array([spin])
    limit = limit_of(frequency.values, span, turning)
    speeds = units.speeds(turning / float(units.frequencies(1.0)))
    height = spectrum["whirl_amplitude"].values
    highest, noise = float(height.max(initial=0.0)) or 1.0, float(spectrum["noise_floor"])
    with drawing(ax, width=6.0, height=3.8) as ax:
        label_axis(ax.xaxis, "frequency", frequency)
        label_axis(ax.yaxis, "whirl_amplitude", units.lengths(height))
        for words, colour, chosen in (
            ("backward", palette.ORANGE, frequency.values <= 0.0),
            ("forward", palette.BLUE, frequency.values >= 0.0),
        ):
            ax.semilogy(*_peaks_kept(frequency.values[chosen], height[chosen], limit), color=colour,
                        lw=0.9, label=words, zorder=2.4)  # fmt: skip
        if not math.isnan(spin):
            ax.axvline(
                spin, color=palette.INK, lw=0.6, ls=palette.DASHES, zorder=1.6, label="spin speed"
            )
        words = f"noise floor ${number_text(noise)}$ {unit_of(units.lengths(noise))}".rstrip()
        ax.axhline(noise, color=palette.INK, lw=0.8, ls=(0, (1, 1.4)), zorder=2.6, label=words)
        _draw_bandwidth(ax, spectrum, units, limit)
        for line in lines_within(exact, limit):
            draw_marks(ax, line.frequency, line.amplitude, line.marker, line.colour, size=5.0,
                       face="none", edge=1.1, label=line.words, level=3.2, clip=False)  # fmt: skip
        mark_frequencies(ax, frequencies)
        ax.set_xlim(-limit, limit)
        tallest = max([highest, *(line.amplitude for line in lines_within(exact, limit))])
        ax.set_ylim(max(0.2 * noise, 1e-12 * highest), 4.0 * tallest)
        _name_orders(ax, spin, limit)
        ax.set_title(title_of_signals(spectrum, speeds), pad=16.0)
        legend_below(ax, columns=4)
    return ax


def limit_of(frequency: Values, span: float, fastest: Values) -> float:
    """Return the largest frequency shown: `span` times the largest speed, or of all frequencies."""
    all_of_it = float(np.abs(frequency).max())
    highest = float(fastest.max(initial=0.0)) or all_of_it
    return min(check_positive("span", span) * highest, all_of_it)


def _peaks_kept(frequency: Values, height: Values, limit: float) -> tuple[Values, Values]:
    """Return a spectrum with the smallest and largest of each column of dots."""
    chosen = np.abs(frequency) <= limit * 1.001
    frequency, height = frequency[chosen], height[chosen]
    kept = kept_in_columns(frequency, height)
    return frequency[kept], height[kept]


def _name_orders(ax: Axes, spin: float, limit: float) -> None:
    """Name whole orders along the upper edge."""
    if math.isnan(spin) or spin <= 0.0:
        return
    most = math.floor(limit / spin + 1e-9)
    step = max(1, math.ceil(most / 6))
    for order in range(-most // step * step, most + 1, step):
        if order and abs(order) <= most:
            name_order(ax, float(order), order * spin, palette.INK)


def name_order(ax: Axes, order: float, frequency: float, colour: str) -> None:
    """Name an order above the upper edge, at its frequency."""
    ax.annotate(
        order_words(order), (frequency, 1.0), xycoords=("data", "axes fraction"), xytext=(0, 2),
        textcoords="offset points", ha="center", va="bottom", fontsize=8.0, color=colour,
        annotation_clip=False,
    )  # fmt: skip


def _draw_bandwidth(ax: Axes, spectrum: xr.Dataset, units: Units, limit: float) -> None:
    """Draw a bar as wide as the noise bandwidth of one line."""
    width = units.frequencies(float(spectrum["bandwidth"]))
    unit = f" {width.attrs['units']}" if units.rate is not None else ""
    left = -0.97 * limit
    ax.plot([left, left + float(width)], [0.95, 0.95], transform=ax.get_xaxis_transform(),
            color=palette.GREEN, lw=2.5, solid_capstyle="butt",
            label=f"bandwidth ${number_text(float(width))}${unit}")  # fmt: skip


def lines_within(exact: Sequence[Line], limit: float) -> list[Line]:
    """Return the lines within a picture."""
    return [line for line in exact if abs(line.frequency) <= limit * (1.0 + SLACK)]


def mark_frequencies(ax: Axes, frequencies: Mapping[str, float] | None) -> None:
    """Mark further frequencies with their labels."""
    if not isinstance(frequencies, Mapping | None):
        raise InputError(
            f"frequencies must be a mapping such as {{'bending': 18.0}}, got {shown(frequencies)}"
        )
    for number, (words, given) in enumerate((frequencies or {}).items()):
        place = check_real("a frequency", given)
        dashes = DASHES_OF_FREQUENCIES[number % len(DASHES_OF_FREQUENCIES)]
        ax.axvline(place, color=palette.GREEN, lw=0.9, ls=dashes, zorder=2.7, label=str(words))


class Segments(NamedTuple):
    """Spectra of segments within the frequencies shown, with exact results."""

    dataset: xr.Dataset
    units: Units
    exact: list[Line]
    # frequencies, the vertical quantity and its name
    across: xr.DataArray
    up: xr.DataArray
    name: str
    limit: float
    heights: Values


def plot_cascade(
    signals: xr.Dataset, *, over: str | None = None, orders: npt.ArrayLike = ORDERS,
    span: float = 3.0, segment: int | None = None, beneath: Beneath = (),
    frequencies: Mapping[str, float] | None = None, ax: Axes | None = None,
) -> Axes:  # fmt: skip
    r"""Draw full spectra over the speed as a waterfall, with lines of orders.

    Parameters
    ----------
    signals : Dataset
        Signals, a run or run-up, or the result of `rotor_ida.spectrogram`.
    over : {"speed", "t"}, optional
        Vertical quantity; default: the speed if it changes and never reverses.
    orders : array_like
        Multiples of the speed along which a line is drawn, negative for backward whirl
        [dimensionless].
    span : float
        Largest frequency shown, over the largest speed [dimensionless].
    segment : int, optional
        Samples in a segment, as in `rotor_ida.spectrogram`, if that is still to be computed.
        Default: the speed changes within a segment by the width of a line; at constant speed an
        eighth of the record.
    beneath, frequencies
        As in `plot_full_spectrum`; a result at one speed is marked at that speed.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Notes
    -----
    If there are more than 60 segments, each spectrum is the maximum over several segments.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> up = run_up(Rotor(omega=0.3, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), to=2.5,
    ...             rate=0.005, samples=20_001)
    >>> plot_cascade(up).get_ylabel()
    'spin speed $\\omega$'
    """
    segments = _segments(signals, over, span, segment, beneath)
    places, heights = _in_rows(segments.up.values, segments.heights, ROWS)
    frequency, heights = _in_columns(segments.across.values, heights, POINTS)
    extent = float(np.ptp(places)) or 1.0
    highest = float(heights.max(initial=0.0)) or 1.0
    scale = TALLEST * extent / highest
    with drawing(ax, width=6.0, height=5.6) as ax:
        # the farthest first, so that each hides those behind it, down to the edge of the plot
        lines = [
            np.column_stack([frequency, place + scale * height])
            for place, height in zip(places[::-1], heights[::-1], strict=True)
        ]
        below = np.column_stack([frequency[[-1, 0]], np.full(2, places[0] - extent)])
        under = [np.vstack([line, below]) for line in lines]
        ax.add_collection(
            PolyCollection(
                under, facecolors="white", edgecolors=palette.INK, linewidths=0.45, zorder=2.2
            )
        )
        top = float((places[:, None] + scale * heights).max())
        ax.set_ylim(places[0] - 0.01 * extent, top + 0.03 * extent)
        _finish(ax, segments, orders, frequencies)
        _draw_scale(ax, segments.units, highest, scale)
    return ax


def plot_spectrogram(
    signals: xr.Dataset, *, over: str | None = None, orders: npt.ArrayLike = ORDERS,
    span: float = 3.0, segment: int | None = None, beneath: Beneath = (),
    frequencies: Mapping[str, float] | None = None, ax: Axes | None = None,
) -> Axes:  # fmt: skip
    """Draw the amplitudes of forward and backward whirl as colours over frequency and speed.

    Parameters
    ----------
    signals, over, orders, span, segment, beneath, frequencies
        As in `plot_cascade`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Notes
    -----
    The colours darken with the logarithm of the amplitude, from a thousandth of the largest, also
    in grey. If there are more
    segments or frequencies than dots, each dot shows the largest of its amplitudes.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> up = run_up(Rotor(omega=0.3, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), to=2.5,
    ...             rate=0.005, samples=20_001)
    >>> plot_spectrogram(up, over="t").get_ylabel()
    'time $t$'
    """
    segments = _segments(signals, over, span, segment, beneath)
    places, heights = _in_rows(segments.up.values, segments.heights, DOTS_UP)
    frequency, heights = _in_columns(segments.across.values, heights, DOTS_ACROSS)
    highest = float(heights.max(initial=0.0)) or 1.0
    with drawing(ax, width=6.0, height=4.6) as ax:
        mesh = ax.pcolormesh(
            _edges(frequency), _edges(places), heights, rasterized=True,
            cmap=colormaps[COLOURS].with_extremes(under="white"),
            norm=LogNorm(FLOOR * highest, highest), zorder=1.5,
        )  # fmt: skip
        _finish(ax, segments, orders, frequencies)
        bar = ax.figure.colorbar(mesh, ax=ax, extend="min", pad=0.02, aspect=30.0)
        bar.set_label(label_of("whirl_amplitude", segments.units.lengths(heights)))
    return ax


def _segments(
    signals: xr.Dataset, over: str | None, span: float, segment: int | None, beneath: Beneath
) -> Segments:
    """Return the spectra of segments, computed if necessary."""
    given = check_dataset("signals", signals, ())
    spectra = given
    if not {"whirl_amplitude", "window", "frequency"} <= set(given.variables):
        size = segment_for(record_of(given)) if segment is None else segment
        spectra = spectrogram(given, segment=size, overlap=OVERLAP)
    units = units_of(spectra, "whirl_amplitude", "frequency")
    exact = lines_of(beneath, spectra, units, over_speed=not _one_speed(spectra))
    across, name = units.frequencies(spectra["frequency"].values), _upwards(spectra, over)
    up = units.speeds(spectra["speed"].values) if name == "speed" else spectra["t"]
    fastest = units.frequencies(spectra.get("speed", np.empty(0))).values
    limit = limit_of(across.values, span, fastest)
    shown = np.abs(across.values) <= limit * 1.001
    heights = spectra["whirl_amplitude"].values[:, shown]
    return Segments(spectra, units, exact, across[shown], up, name, limit, heights)


def _one_speed(spectra: xr.Dataset) -> bool:
    return "speed" not in spectra.variables or is_one_speed(spectra["speed"].values)


def _upwards(spectra: xr.Dataset, over: str | None) -> str:
    """Return the name of the vertical quantity: the speed if it changes and never reverses."""
    if over is None:
        known = "speed" in spectra.variables and not _one_speed(spectra)
        steps = np.diff(spectra["speed"].values) if known else np.zeros(1)
        slack = 0.02 * float(np.abs(steps).sum())
        one_way = min(-steps[steps < 0.0].sum(), steps[steps > 0.0].sum()) <= slack
        over = "speed" if known and one_way else "t"
    check_choice("over", over, OVER)
    if over not in spectra.variables:
        raise InputError("over must be 't' where no angle of the rotor is known, got 'speed'")
    return over


def _in_rows(up: Values, heights: Values, rows: int) -> tuple[Values, Values]:
    """Return rising positions, and for each the largest amplitudes of the nearest segments."""
    order = np.argsort(up, kind="stable")
    up, heights = up[order], heights[order]
    low, high = float(up[0]), float(up[-1])
    if up.size <= rows or high == low:
        return up, heights
    return _binned(up, heights, np.minimum((up - low) / (high - low) * rows, rows - 1), axis=0)


def _in_columns(frequency: Values, heights: Values, columns: int) -> tuple[Values, Values]:
    """Return frequencies, and for each the largest amplitude of the nearest ones."""
    if frequency.size <= columns:
        return frequency, heights
    return _binned(frequency, heights, np.arange(frequency.size) * columns // frequency.size, 1)


def _binned(
    places: Values, heights: Values, bins: npt.NDArray[np.number], axis: int
) -> tuple[Values, Values]:
    """Return the mean place and the largest heights in each bin, by numbers that only rise."""
    starts = np.flatnonzero(np.diff(bins.astype(np.intp), prepend=-1))
    middles = np.add.reduceat(places, starts) / np.diff(starts, append=places.size)
    return middles, np.maximum.reduceat(heights, starts, axis=axis)


def _edges(middles: Values) -> Values:
    """Return the edges between positions, and one past each end."""
    if middles.size == 1:
        return np.array([middles[0] - 0.5, middles[0] + 0.5])
    between = 0.5 * (middles[1:] + middles[:-1])
    first, last = 2.0 * middles[0] - between[0], 2.0 * middles[-1] - between[-1]
    return np.concatenate([[first], between, [last]])


def _finish(
    ax: Axes, segments: Segments, orders: npt.ArrayLike, frequencies: Mapping[str, float] | None
) -> None:
    """Label the axes of segments, and mark orders, exact lines and further frequencies."""
    label_axis(ax.xaxis, "frequency", segments.across)
    label_axis(ax.yaxis, segments.name, segments.up)
    ax.set_xlim(-segments.limit, segments.limit)
    _draw_orders(ax, segments, check_array("orders", orders).ravel().tolist())
    _mark_lines(ax, segments)
    mark_frequencies(ax, frequencies)
    ax.grid(visible=False)
    speeds = segments.units.speeds(segments.dataset.get("speed", np.empty(0)))
    ax.set_title(title_of_signals(segments.dataset, speeds), pad=16.0)
    if segments.exact or frequencies:
        legend_below(ax, columns=3)


def _draw_orders(ax: Axes, segments: Segments, orders: Sequence[float]) -> None:
    """Draw a line along each order of the speed, with its name at the upper end."""
    if "speed" not in segments.dataset.variables:
        return
    spin = segments.units.frequencies(segments.dataset["speed"].values).values
    up = segments.up.values
    last = int(np.argmax(up))
    for order in orders:
        ax.plot(order * spin, up, color=palette.RED, lw=0.7, ls=(0, (5, 2)), zorder=2.8)
        end = order * spin[last]
        if abs(end) <= segments.limit:
            name_order(ax, order, end, palette.RED)


def _mark_lines(ax: Axes, segments: Segments) -> None:
    """Mark the frequencies of exact lines at their speeds.

    Over time the marks span the full height, unless the speed changes.
    """
    spectra, up = segments.dataset, segments.up.values
    everywhere = segments.name == "t" and _one_speed(spectra)
    speeds = np.empty(0)
    if "speed" in spectra.variables:
        speeds = segments.units.speeds(spectra["speed"].values).values
    for line in lines_within(segments.exact, segments.limit):
        if everywhere:
            ax.axvline(line.frequency, color=line.colour, lw=0.8, ls=(0, (1, 1.2)),
                       label=line.words, zorder=2.7)  # fmt: skip
            continue
        places = _crossed(speeds, line.speed, up, segments.name)
        if places.size:
            draw_marks(ax, np.full(places.size, line.frequency), places, line.marker, line.colour,
                       size=5.0, face="white", edge=1.1, label=line.words, level=3.2,
                       clip=False)  # fmt: skip


def _crossed(speeds: Values, wanted: float, up: Values, name: str) -> Values:
    """Return the vertical positions at which the speed has a given value."""
    if name == "speed":
        within = speeds.min() * (1.0 - STEADY) <= wanted <= speeds.max() * (1.0 + STEADY)
        return np.array([wanted] if within else [])
    steps = np.diff(speeds)
    before = np.flatnonzero((speeds[:-1] - wanted) * (speeds[1:] - wanted) <= 0.0)
    before = before[steps[before] != 0.0]
    part = (wanted - speeds[before]) / steps[before]
    return np.unique(up[before] + part * (up[before + 1] - up[before]))


def _draw_scale(ax: Axes, units: Units, highest: float, scale: float) -> None:
    """Draw a scale bar of a round amplitude beside the spectra."""
    power = 10.0 ** math.floor(math.log10(highest))
    size = next(each * power for each in (5.0, 2.0, 1.0) if each * power <= highest)
    unit = f" {unit_of(units.lengths(size))}".rstrip()
    top = ax.get_ylim()[1]
    bottom = top - 0.03 * (top - ax.get_ylim()[0]) - size * scale
    left = ax.get_xlim()[0] * 0.96
    ax.plot([left, left], [bottom, bottom + size * scale], color=palette.INK, lw=2.0,
            solid_capstyle="butt", zorder=3.0)  # fmt: skip
    ax.annotate(f"{size:g}{unit} zero to peak", (left, bottom + 0.5 * size * scale), xytext=(4, 0),
                textcoords="offset points", va="center", fontsize=8.0, zorder=3.0,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0})  # fmt: skip
