"""Free vibration: natural frequency and period over amplitude, and phase portraits."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.checks import check_choice
from rotor_ida.plot.appearance import (
    BLUE,
    LABELS,
    ORANGE,
    axes_or_new,
    check_dataset,
    one_value,
    own_legend,
    parameter_text,
    style,
)
from rotor_ida.plot.layout import look

MOTIONS = {
    "circular_period": ("circle", BLUE, "-", "o"),
    "planar_period": ("line", ORANGE, (0, (5, 1.8)), "s"),
}


def plot_periods(
    exact: xr.Dataset,
    *,
    simulated: xr.Dataset | None = None,
    over: str = "period",
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
    with style():
        ax = axes_or_new(ax)
        for name, (words, colour, line, marker) in MOTIONS.items():
            ax.plot(
                _across(exact[name], over), exact["amplitude"].values, color=colour, ls=line,
                label=f"on a {words}, exact",
            )  # fmt: skip
            if simulated is not None:
                check_dataset("simulated", simulated, ("amplitude", name))
                ax.plot(
                    _across(simulated[name], over), simulated["amplitude"].values, ls="",
                    marker=marker, ms=4.2, mec=colour, mfc="white", mew=1.0,
                    label=f"on a {words}, simulated",
                )  # fmt: skip
        ax.set_xlabel(LABELS[over])
        ax.set_ylabel(LABELS["amplitude"])
        ax.set_ylim(bottom=0.0)
        ax.set_title(parameter_text(delta0=one_value("exact", exact, "delta0")))
        own_legend(ax)
    return ax


def _across(period: xr.DataArray, over: str) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    values = np.asarray(period.squeeze().values, dtype=np.float64)
    return values if over == "period" else 2.0 * math.pi / values


def plot_portrait(runs: xr.Dataset, *, along: str = "x", ax: Axes | None = None) -> Axes:
    """Draw velocity over displacement along one axis, for several starts, with their periods.

    Parameters
    ----------
    runs : Dataset
        ``x vx y vy`` on ``start`` and ``time``, with the ``amplitude`` and the ``period`` of
        each start, and perhaps one ``delta0`` for the title.
    along : {"x", "y"}
        Which axis.
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
    >>> table = xr.Dataset({name: (("start", "time"), [[0.0, 1.0]]) for name in ("x", "vx")})
    >>> table = table.assign(amplitude=("start", [1.0]), period=("start", [6.58]))
    >>> plot_portrait(table).get_ylabel()
    "velocity $x'$"
    """
    check_choice("along", along, ("x", "y"))
    runs = check_dataset("runs", runs, (along, f"v{along}", "amplitude", "period"))
    with style():
        ax = axes_or_new(ax)
        for number in range(runs.sizes["start"]):
            run = runs.isel(start=number)
            colour, line = look(number)
            if float(run["amplitude"]) <= 0.0:
                ax.plot(0.0, 0.0, ls="", marker="o", ms=3.0, color=colour)
                continue
            ax.plot(run[along].values, run[f"v{along}"].values, color=colour, ls=line)
            ax.annotate(
                f"$T = {float(run['period']):.2f}$", (0.0, -float(abs(run[f"v{along}"]).max())),
                xytext=(0.0, -2.5), textcoords="offset points", ha="center", va="top",
                fontsize=8.0,
            )  # fmt: skip
        ax.margins(y=0.11)
        if "delta0" in runs.coords:
            ax.set_title(parameter_text(delta0=one_value("runs", runs, "delta0")))
        ax.set_xlabel(LABELS[along])
        ax.set_ylabel(LABELS[f"v{along}"])
    return ax
