"""Full spectra of a record: forward and backward lines over frequency."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.checks import check_positive, check_real, shown
from rotor_ida.errors import InputError
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import draw_marks, drawing
from rotor_ida.plot.datasets import check_dataset
from rotor_ida.plot.decimation import kept_in_columns
from rotor_ida.plot.labels import label_axis, number_text, unit_of
from rotor_ida.plot.legends import legend_below
from rotor_ida.plot.signals.beneath import Beneath, Line, lines_of
from rotor_ida.plot.signals.exact_motion import speeds_along
from rotor_ida.plot.signals.orders import order_words
from rotor_ida.plot.signals.speeds import title_of_signals
from rotor_ida.plot.signals.units import Units, units_of
from rotor_ida.signals.spectra import full_spectrum

# The side lobes of the flat-top window lie below this fraction of the largest.
FLOOR = 3e-5
# Includes a line at the edge of a plot despite rounding.
SLACK = 1e-9
# Styles of further frequencies.
DASHES_OF_FREQUENCIES = ((0, (7, 1.6, 1.2, 1.6)), (0, (3, 1.2)), (0, (1, 1)))


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
