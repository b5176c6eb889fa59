"""Plots of many run-ups: largest force and outcome over the rate."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM
from rotor_ida.plot.appearance import (
    GREY,
    KIND_SHADES,
    drawing,
    legend_below,
    look,
    mixed_panels,
    own_legend,
    shared_legend,
    style,
)
from rotor_ida.plot.datasets import check_dataset, rotors_in
from rotor_ida.plot.labels import LABELS, label_of, parameter_text
from rotor_ida.plot.system_whirls import speeds_in
from rotor_ida.results.si_units import in_rpm, scale_of
from rotor_ida.schema import ENDS_IN_WORDS
from rotor_ida.texts import in_figure
from rotor_ida.units import SPEED_UNITS, number

ENDING_COLOURS = {
    "contact_free": KIND_SHADES["contact_free"][0],
    "rub": KIND_SHADES["full_contact"][1],
    "whip": KIND_SHADES["rolling"][0],
    "unresolved": GREY,
}
ENDING_WORDS = {
    "contact_free": "ends contact-free", "rub": "ends in a rub", "whip": "ends in dry whip",
    "unresolved": "undecided",
}  # fmt: skip
NEEDED = ("rate", "to", "largest_force", *(f"{word}_fraction" for word in ENDS_IN_WORDS))
FORCE = "largest normal force"
# If there are more rates, only this many are labelled under the bars.
MOST_TICKS = 7
# Fewer bars are not wider.
FEWEST_BARS = 3


def run_ups_figure(dataset: xr.Dataset) -> Figure:
    """Draw run-ups: the largest forces over the rate, and outcomes in a panel for each rotor.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.run_ups`.

    Examples
    --------
    >>> from rotor_ida import run_ups
    >>> found = run_ups(omega=0.3, to=1.6, rate=[0.01, 0.3], zeta=0.1, delta0=[1.0, 2.0],
    ...                 shaft_stiffness=1.0)
    >>> [ax.get_ylabel() for ax in run_ups_figure(found).axes]
    ['largest normal force', 'fraction of run-ups', 'fraction of run-ups']
    """
    dataset = _checked(dataset)
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
    shared_legend(figure, axes[1 : 1 + len(rotors)], outer=False)
    return figure


def plot_largest_force(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the largest normal force of run-ups over the rate, a curve for each rotor.

    The curve is the largest over phases and starts; bars reach down to the smallest.

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
    dataset = _checked(dataset)
    size = np.abs(_rates_of(dataset))
    order = np.argsort(size)
    highest = 0.0
    with drawing(ax) as ax:
        for number, (words, one) in enumerate(_parts(dataset, "contact")):
            colour, dashes = look(number)
            force = one["largest_force"].transpose("rate", ...).values
            force = force.reshape(size.size, -1)[order]
            top = np.fmax.reduce(force, axis=1)
            down = np.stack([top - np.fmin.reduce(force, axis=1), np.zeros_like(top)])
            highest = max(highest, float(np.nan_to_num(top).max()))
            ax.errorbar(
                size[order], top, down if force.shape[1] > 1 else None, color=colour, ls=dashes,
                marker=".", ms=4.0, elinewidth=0.8, capsize=2.0,
                label=words or None,
            )  # fmt: skip
        ax.set_xscale("log")
        ax.set_ylim(0.0, 1.08 * highest or 1.0)
        ax.set_xlabel(_rate_label(dataset))
        ax.set_ylabel(label_of("normal_force", dataset["largest_force"], words=FORCE))
        if ax.get_legend_handles_labels()[1]:
            own_legend(ax)
    return ax


def plot_endings(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the fractions of outcomes of one rotor's run-ups, stacked, for each rate.

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
    dataset = _checked(dataset)
    _, one = _parts(dataset)[0]
    rates = _rates_of(one)
    order = np.argsort(np.abs(rates))
    places, alone = np.arange(rates.size), ax is None
    with drawing(ax) as ax:
        base = np.zeros(rates.size)
        for word, colour in ENDING_COLOURS.items():
            share = np.nan_to_num(one[f"{word}_fraction"].values.ravel()[order])
            if share.any():
                ax.bar(places, share, bottom=base, width=0.9, color=colour, lw=0.0,
                       label=ENDING_WORDS[word])  # fmt: skip
            base = base + share
        step = math.ceil(rates.size / MOST_TICKS)
        ax.set_xticks(places[::step], [number(rate, 3) for rate in rates[order][::step].tolist()])
        margin = max(0.1, 0.5 * (FEWEST_BARS - rates.size))
        ax.set_xlim(-0.5 - margin, rates.size - 0.5 + margin)
        ax.set_ylim(0.0, 1.0)
        ax.grid(visible=False)
        ax.set_xlabel(LABELS["rate"] + _unit_of_rate(dataset))
        ax.set_ylabel("fraction of run-ups")
        if alone:
            legend_below(ax)
    return ax


def _checked(dataset: object) -> xr.Dataset:
    """Return run-ups of one disc or of a rotor system, in suitable units."""
    is_of_system = isinstance(dataset, xr.Dataset) and "contact_node" in dataset.variables
    own = ("speed", "clearance") if is_of_system else PARAMETERS
    return check_dataset("dataset", dataset, (*own, *NEEDED))


def _parts(dataset: xr.Dataset, *others: str) -> list[tuple[str, xr.Dataset]]:
    """Return the run-ups of each rotor, or by first speed and `others`, with words for each."""
    if "contact_node" not in dataset.variables:
        return [(parameter_text(values) if values else "", one)
                for values, one in rotors_in(dataset)]  # fmt: skip
    names = [name for name in ("speed", *PARAMETERS_OF_SYSTEM, *others) if name in dataset.dims]
    found = []
    for places in np.ndindex(*(dataset.sizes[name] for name in names)):
        part = dataset.isel({name: [at] for name, at in zip(names, places, strict=True)})
        told = []
        if "speed" in names and dataset.sizes["speed"] > 1:
            unit = "" if in_rpm(part["speed"]) is None else " rpm"
            told.append(f"from {speeds_in(part['speed'])[0]:.5g}{unit}")
        told += [f"{PARAMETERS_OF_SYSTEM[name].label} {part[name].item():.5g}" for name in names
                 if name in PARAMETERS_OF_SYSTEM and dataset.sizes[name] > 1]  # fmt: skip
        if "contact" in names and dataset.sizes["contact"] > 1:
            node = in_figure(part["contact_node"].values[0])
            told.append(f"contact {places[-1]} at {node}")
        found.append((", ".join(told), part))
    if not found:
        raise InputError("dataset must have a contact, got run-ups of a rotor system without")
    return found


def _rates_of(dataset: xr.Dataset) -> Values:
    """Return the rates of run-ups, in rpm/s for a machine."""
    rates = np.asarray(dataset["rate"].values)
    if dataset["rate"].attrs.get("units") == "s-2":
        return rates / SPEED_UNITS["rpm"]
    if "rate_scale" not in dataset.attrs:
        return rates
    return rates * scale_of(dataset, "rate") ** 2 / SPEED_UNITS["rpm"]


def _unit_of_rate(dataset: xr.Dataset) -> str:
    in_si = "rate_scale" in dataset.attrs or dataset["rate"].attrs.get("units") == "s-2"
    return " [rpm/s]" if in_si else ""


def _rate_label(dataset: xr.Dataset) -> str:
    falls = bool((dataset["rate"] < 0.0).any())
    words = r"rate of the run-down $|a|$" if falls else LABELS["rate"]
    return words + _unit_of_rate(dataset)
