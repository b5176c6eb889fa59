"""Plots of many run-ups: largest force and outcome over the rate or another parameter."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import drawing, mixed_panels, style
from rotor_ida.plot.datasets import (
    check_dataset,
    contact_text,
    parameters_in,
    units_in,
    varied_in,
)
from rotor_ida.plot.labels import label_axis, label_parameter, text_of
from rotor_ida.plot.legends import legend_below, own_legend, shared_legend
from rotor_ida.results.si_units import si_of
from rotor_ida.schema import ENDS_IN_WORDS
from rotor_ida.units import SPEED_UNITS, number

ENDING_COLOURS = {
    "contact_free": palette.KIND_SHADES["contact_free"][0],
    "rub": palette.KIND_SHADES["full_contact"][1],
    "whip": palette.KIND_SHADES["rolling"][0],
    "unresolved": palette.GREY,
}
ENDING_WORDS = {
    "contact_free": "ends contact-free", "rub": "ends in a rub", "whip": "ends in dry whip",
    "unresolved": "undecided",
}  # fmt: skip
OF_SYSTEM = ("speed", "clearance")
NEEDED = ("rate", "to", "largest_force", *(f"{word}_fraction" for word in ENDS_IN_WORDS))
RATE, FORCE = "rate", "largest normal force"
# If there are more rates, only this many are labelled under the bars.
MOST_TICKS = 7
# Fewer bars are not wider.
FEWEST_BARS = 3


def plot_run_ups(dataset: xr.Dataset) -> Figure:
    """Draw run-ups: the largest forces over the rate, and outcomes in a panel for each rotor.

    With one rate, both are over the parameter that varies.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.run_ups`.

    Examples
    --------
    >>> from rotor_ida import run_ups
    >>> found = run_ups(omega=0.3, to=1.6, rate=[0.01, 0.3], zeta=0.1, delta0=[1.0, 2.0],
    ...                 shaft_stiffness=1.0)
    >>> [ax.get_ylabel() for ax in plot_run_ups(found).axes]
    ['largest normal force', 'fraction of run-ups', 'fraction of run-ups']
    """
    dataset = check_dataset("dataset", dataset, NEEDED, OF_SYSTEM)
    rotors = _parts(dataset)
    columns = math.ceil(math.sqrt(1 + len(rotors)))
    rows = math.ceil((1 + len(rotors)) / columns)
    figure, axes = mixed_panels(rows, columns, width=1.0 + 3.2 * columns, height=0.6 + 2.7 * rows)
    plot_largest_force(dataset, ax=axes[0])
    for ax, (words, one) in zip(axes[1:], rotors, strict=False):
        plot_endings(one, ax=ax)
        if words:
            with style():
                ax.set_title(words)
    for ax in axes[1 + len(rotors) :]:
        ax.remove()
    shared_legend(figure, axes[: 1 + len(rotors)], outer=False)
    return figure


def plot_largest_force(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the largest normal force of run-ups over the rate, a curve for each rotor and contact.

    The curve is the largest over phases and starts; bars reach down to the smallest. With one rate
    it is over the parameter that varies.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.run_ups`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import run_ups
    >>> found = run_ups(omega=0.3, to=1.6, rate=[0.03, 0.3], zeta=0.1, delta0=1.0)
    >>> plot_largest_force(found).get_xlabel()
    'rate $a$'
    """
    dataset = check_dataset("dataset", dataset, NEEDED, OF_SYSTEM)
    over, highest = _over(dataset), 0.0
    with drawing(ax) as ax:
        for count, (words, one) in enumerate(_parts(dataset, "contact")):
            colour, dashes = palette.look(count)
            across, order = _along(ax, one, over)
            force = one["largest_force"].transpose(over, ...).values
            force = force.reshape(order.size, -1)[order]
            top = np.fmax.reduce(force, axis=1)
            down = np.stack([top - np.fmin.reduce(force, axis=1), np.zeros_like(top)])
            highest = max(highest, float(np.nan_to_num(top).max()))
            ax.errorbar(
                across, top, down if force.shape[1] > 1 else None, color=colour, ls=dashes,
                marker=".", ms=4.0, elinewidth=0.8, capsize=2.0,
                label=words or None,
            )  # fmt: skip
        if over == RATE:
            falls = bool((dataset[RATE] < 0.0).any())
            ax.set_xscale("log")
            _label_ticks(ax, across, across)
            ax.minorticks_off()
            label_axis(ax.xaxis, RATE, _rates_of(dataset),
                       words=r"rate of the run-down $|a|$" if falls else None)  # fmt: skip
        ax.set_ylim(0.0, 1.08 * highest or 1.0)
        label_axis(ax.yaxis, "normal_force", dataset["largest_force"], words=FORCE)
        if ax.get_legend_handles_labels()[1]:
            own_legend(ax)
    return ax


def plot_endings(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the fractions of outcomes of one rotor's run-ups, stacked, for each rate.

    With one rate they are over the parameter that varies.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.run_ups`, for one value of each parameter.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import run_ups
    >>> found = run_ups(omega=0.3, to=1.6, rate=[0.01, 0.3], zeta=0.1, delta0=2.0,
    ...                 shaft_stiffness=1.0)
    >>> [text.get_text() for text in plot_endings(found).get_legend().get_texts()]
    ['ends contact-free', 'ends in a rub']
    """
    dataset = check_dataset("dataset", dataset, NEEDED, OF_SYSTEM)
    over, alone = _over(dataset), ax is None
    _, one = _parts(dataset)[0]
    with drawing(ax) as ax:
        across, order = _along(ax, one, over)
        places, base = np.arange(float(across.size)), np.zeros(across.size)
        for word, colour in ENDING_COLOURS.items():
            share = np.nan_to_num(one[f"{word}_fraction"].values.ravel()[order])
            if share.any():
                ax.bar(places, share, bottom=base, width=0.9, color=colour, lw=0.0,
                       label=ENDING_WORDS[word])  # fmt: skip
            base = base + share
        if over == RATE:
            across = _rates_of(one).values[order]
            label_axis(ax.xaxis, RATE, _rates_of(one))
        _label_ticks(ax, places, across)
        margin = max(0.1, 0.5 * (FEWEST_BARS - across.size))
        ax.set_xlim(-0.5 - margin, across.size - 0.5 + margin)
        ax.set_ylim(0.0, 1.0)
        ax.grid(visible=False)
        ax.set_ylabel("fraction of run-ups")
        if alone:
            legend_below(ax)
    return ax


def _over(dataset: xr.Dataset) -> str:
    """Return what run-ups are drawn over: the rate, or the one parameter that varies."""
    varied = varied_in(dataset)
    return varied[0] if len(varied) == 1 and dataset.sizes[RATE] == 1 else RATE


def _along(ax: Axes, one: xr.Dataset, over: str) -> tuple[Values, npt.NDArray[np.intp]]:
    """Return rising values along the axis, and the order that makes them rise."""
    values = np.abs(_rates_of(one).values) if over == RATE else label_parameter(ax.xaxis, over, one)
    order = np.argsort(values)
    return values[order], order


def _parts(dataset: xr.Dataset, *others: str) -> list[tuple[str, xr.Dataset]]:
    """Return the run-ups of each rotor, and by `others`, with words for each."""
    over = _over(dataset)
    own = [name for name in parameters_in(dataset) if name in dataset.dims and name != over]
    names = [*own, *(name for name in others if name in dataset.dims)]
    found = []
    for places in np.ndindex(*(dataset.sizes[name] for name in names)):
        part = dataset.isel({name: [at] for name, at in zip(names, places, strict=True)})
        varied = {name: part[name].item() for name in own if dataset.sizes[name] > 1}
        told = [f"{'from ' if SPEED in varied else ''}{text_of(part, varied)}"] if varied else []
        if "contact" in names and dataset.sizes["contact"] > 1:
            told.append(contact_text(part, places[-1]))
        found.append((", ".join(told), part))
    if not found:
        raise InputError("dataset must have a contact, got run-ups of a rotor system without")
    return found


def _rates_of(dataset: xr.Dataset) -> xr.DataArray:
    """Return the rates of run-ups, in rpm/s where speeds have a unit."""
    rates, known = dataset[RATE], si_of(dataset, RATE)
    if known is None and units_in(rates) != "s-2":
        return rates
    scale = known[1] if known else 1.0 / SPEED_UNITS["rpm"]
    return rates.copy(data=scale * rates.values).assign_attrs(units="rpm/s")


def _label_ticks(ax: Axes, places: Values, values: Values) -> None:
    """Write some of the values at their places, in the unit of their axis."""
    step, shown = math.ceil(values.size / MOST_TICKS), ax.xaxis.get_major_formatter()
    in_unit = shown if isinstance(shown, FuncFormatter) else float
    ax.set_xticks(places[::step], [number(float(in_unit(each)), 3) for each in values[::step]])
