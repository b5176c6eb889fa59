"""Free vibration: natural frequency and period over amplitude, and phase portraits."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.checks import check_choice
from rotor_ida.plot.appearance import (
    BLUE,
    ORANGE,
    axes_or_new,
    check_dataset,
    one_value,
    own_legend,
    style,
)
from rotor_ida.plot.labels import LABELS, parameter_text
from rotor_ida.plot.layout import look
from rotor_ida.plot.units import alike, label_of, suited, unit_of

MOTIONS = {
    "circular_period": ("circle", BLUE, "-", "o"),
    "planar_period": ("line", ORANGE, (0, (5, 1.8)), "s"),
}


def plot_periods(
    exact: xr.Dataset,
    *,
    simulated: xr.Dataset | None = None,
    over: str = "period",
    units: Mapping[str, str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw amplitude over period, or over natural frequency, for free motion.

    Parameters
    ----------
    exact : Dataset
        What `rotor_ida.closed_forms.free_periods` returned, for one ``delta0``.
    simulated : Dataset, optional
        Simulated periods in the same variables, at amplitudes of their own.
    over : {"period", "natural"}
        Whether the horizontal axis is the period or the natural frequency ``2 pi/T``.
    units : mapping of str to str, optional
        Units for a dataset of `rotor_ida.dimensional`, such as ``{"length": "mm"}``; by default
        those with the SI prefix that suits.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Where it was drawn.

    Raises
    ------
    InputError
        If a dataset is of another kind.

    Examples
    --------
    >>> from rotor_ida.closed_forms import free_periods
    >>> plot_periods(free_periods(amplitude=[1.0, 2.0], delta0=0.0)).get_xlabel()
    'period $T$'
    """
    check_choice("over", over, ("period", "natural"))
    exact = check_dataset("exact", exact, ("amplitude", "delta0", *MOTIONS))
    drawn = ("amplitude", *MOTIONS)
    exact = suited(exact, drawn, units=units, ax=ax)
    if simulated is not None:
        simulated = alike("simulated", check_dataset("simulated", simulated, drawn), exact)
    with style():
        ax = axes_or_new(ax)
        for name, (words, colour, line, marker) in MOTIONS.items():
            ax.plot(
                _across(exact[name], over), exact["amplitude"].values, color=colour, ls=line,
                label=f"on a {words}, exact",
            )  # fmt: skip
            if simulated is not None:
                ax.plot(
                    _across(simulated[name], over), simulated["amplitude"].values, ls="",
                    marker=marker, ms=4.2, mec=colour, mfc="white", mew=1.0,
                    label=f"on a {words}, simulated",
                )  # fmt: skip
        label = label_of("period", exact["circular_period"])
        ax.set_xlabel(label if over == "period" else _natural_label(exact["circular_period"]))
        ax.set_ylabel(label_of("amplitude", exact["amplitude"]))
        ax.set_ylim(bottom=0.0)
        ax.set_title(parameter_text(delta0=one_value("exact", exact, "delta0")))
        own_legend(ax)
    return ax


def _natural_label(period: xr.DataArray) -> str:
    unit = unit_of(period)
    return f"{LABELS['natural']} [rad/{unit}]" if unit else LABELS["natural"]


def _across(period: xr.DataArray, over: str) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    values = np.asarray(period.squeeze().values, dtype=np.float64)
    return values if over == "period" else 2.0 * math.pi / values


def plot_portrait(
    runs: xr.Dataset,
    *,
    along: str = "x",
    units: Mapping[str, str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw velocity over displacement along one axis, for several starts, with their periods.

    Parameters
    ----------
    runs : Dataset
        ``x vx y vy`` on ``start`` and ``t``, with the ``amplitude`` and the ``period`` of
        each start, and perhaps one ``delta0`` for the title.
    along : {"x", "y"}
        Which axis.
    units : mapping of str to str, optional
        Units for a dataset of `rotor_ida.dimensional`, such as ``{"length": "mm"}``; by default
        those with the SI prefix that suits.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Where it was drawn.

    Raises
    ------
    InputError
        If the dataset is of another kind.

    Examples
    --------
    >>> table = xr.Dataset({name: (("start", "t"), [[0.0, 1.0]]) for name in ("x", "vx")})
    >>> table = table.assign(amplitude=("start", [1.0]), period=("start", [6.58]))
    >>> plot_portrait(table).get_ylabel()
    'velocity $x$′'
    """
    check_choice("along", along, ("x", "y"))
    drawn = (along, f"v{along}", "amplitude", "period")
    runs = suited(check_dataset("runs", runs, drawn), drawn, units=units, ax=ax)
    unit = unit_of(runs["period"])
    with style():
        ax = axes_or_new(ax)
        for number in range(runs.sizes["start"]):
            run = runs.isel(start=number)
            colour, line = look(number)
            if float(run["amplitude"]) <= 0.0:
                ax.plot(0.0, 0.0, ls="", marker="o", ms=3.0, color=colour)
                continue
            ax.plot(run[along].values, run[f"v{along}"].values, color=colour, ls=line)
            lowest = -float(abs(run[f"v{along}"]).max())
            ax.annotate(
                f"$T = {float(run['period']):.2f}$ {unit}".rstrip(), (0.0, lowest),
                xytext=(0.0, -2.5), textcoords="offset points", ha="center", va="top",
                fontsize=8.0,
            )  # fmt: skip
        ax.margins(y=0.11)
        if "delta0" in runs.coords:
            ax.set_title(parameter_text(delta0=one_value("runs", runs, "delta0")))
        ax.set_xlabel(label_of(along, runs[along]))
        ax.set_ylabel(label_of(f"v{along}", runs[f"v{along}"]))
    return ax
