"""Plots of a fit: measured over fitted signals, and residuals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, cast

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.arrays import Values
from rotor_ida.checks import listed
from rotor_ida.errors import InputError
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import drawing, new_figure, style
from rotor_ida.plot.datasets import check_dataset
from rotor_ida.plot.labels import LABELS, label_axis, label_of, typeset
from rotor_ida.plot.legends import own_legend
from rotor_ida.plot.signals.units import Units, is_one_speed, units_of
from rotor_ida.texts import in_figure
from rotor_ida.units import quantity

NEEDED = (
    *("estimate", "standard_error", "forward_whirl_amplitude", "forward_phase_lag"),
    *("fitted_forward_whirl_amplitude", "fitted_forward_phase_lag", "forward_amplitude_error"),
    *("record", "speed", "t"),
)
RESIDUALS = ("forward_residual_real", "forward_residual_imag")
# A residual above this many standard errors is rare.
RARE = 2.0
# A phase is shown if the amplitude exceeds this many times its error.
CLEAR = 3.0
# More windows than these are drawn with small marks.
MANY = 300
# Measured values are points with error bars.
MEASURED: Any = {"fmt": ".", "ms": 3.5, "lw": 0.0, "elinewidth": 0.8, "color": palette.INK}


def fit_figure(dataset: xr.Dataset, *, order: float = 1.0) -> Figure:
    r"""Return a figure of a fit: measured over fitted amplitude and phase, and residuals.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.fit`.
    order : float
        Multiple of the speed that is shown, one of those that were compared [dimensionless].

    Returns
    -------
    Figure
        Amplitude, phase lag and residuals of forward whirl over the speed, or over time if the
        speed is constant, in a column for each node of a rotor system; a fourth row shows contact
        times, if these were compared.

    Raises
    ------
    InputError
        If the dataset is not a fit, or does not contain the order.

    Examples
    --------
    >>> from rotor_ida import Rotor, fit, run_up, signals_of
    >>> rotor = Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
    >>> seen = signals_of(run_up(rotor, start=(0, 0, 0, 0), to=2.0, rate=0.01, samples=4001))
    >>> figure = fit_figure(fit(seen, rotor, ["zeta"]))
    >>> [ax.get_ylabel() for ax in figure.axes][1:]
    ['phase lag $\\theta$ [°]', 'residual over its error']
    """
    dataset = check_dataset("dataset", dataset, NEEDED)
    rows = 4 if "measured_time" in dataset.variables else 3
    nodes = _nodes_of(dataset)
    with style():
        figure = new_figure(max(6.0, 3.6 * len(nodes)), 1.8 + 1.7 * rows)
        grid = figure.add_gridspec(rows, len(nodes), height_ratios=[1.6, 1.2, 1.0, 1.0][:rows])
        for column, node in enumerate(nodes):
            axes = [figure.add_subplot(grid[0, column])]
            axes += [figure.add_subplot(grid[row, column], sharex=axes[0]) for row in (1, 2)]
            plot_fit(dataset, order=order, node=node, axes=axes[:2])
            plot_fit_residuals(dataset, order=order, node=node, ax=axes[2])
            for ax in axes[:2]:
                ax.tick_params(labelbottom=False)
                ax.set_xlabel("")
            for ax in axes:
                # in two lines, as the panels are low
                ax.set_ylabel("" if column else ax.get_ylabel().replace(", ", ",\n"))
            if len(nodes) > 1:
                axes[0].set_title(in_figure(str(node)), fontsize=9.0)
        if rows > 3:
            _plot_touches(dataset, figure.add_subplot(grid[3, :]))
        figure.suptitle(_estimates_in_words(dataset), fontsize=9.0)
        figure.align_ylabels()
    return figure


def plot_fit(
    dataset: xr.Dataset, *, order: float = 1.0, node: str | None = None,
    axes: Sequence[Axes] | None = None,
) -> Figure:  # fmt: skip
    """Draw measured amplitude and phase lag of an order, with errors, over the fitted ones.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.fit`.
    order : float
        Multiple of the speed that is shown [dimensionless].
    node : str, optional
        Node of a rotor system whose probes are shown; by default the first.
    axes : sequence of two Axes, optional
        Where to draw amplitude and phase lag; by default the axes of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, fit, run_up, signals_of
    >>> rotor = Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
    >>> seen = signals_of(run_up(rotor, start=(0, 0, 0, 0), to=2.0, rate=0.01, samples=4001))
    >>> plot_fit(fit(seen, rotor, ["zeta"])).axes[0].get_legend().get_texts()[0].get_text()
    'fitted'
    """
    dataset = check_dataset("dataset", dataset, NEEDED)
    one, units, over = _order_of(dataset, order, node)
    with style():
        if axes is None:
            axes = new_figure(5.0, 4.4).subplots(2, 1, sharex=True)
        for number in np.unique(one["record"].values):
            windows = one["record"].values == number
            part = one.isel(window=windows)
            places = over.values[windows]
            axes[0].plot(places, part["fitted_forward_whirl_amplitude"], color=palette.ORANGE,
                         lw=1.3, label="fitted", zorder=3.0)  # fmt: skip
            axes[0].errorbar(places, part["forward_whirl_amplitude"],
                             part["forward_amplitude_error"], **MEASURED,
                             label="measured")  # fmt: skip
            _draw_phase(axes[1], places, part)
        axes[0].set_ylim(bottom=0.0)
        label_axis(axes[0].yaxis, "whirl_amplitude", units.lengths(0.0))
        axes[1].set_ylabel(f"{LABELS['phase_lag']} [°]")
        for ax in axes:
            ax.set_xlabel(str(over.attrs["label"]))
        own_legend(axes[0], inside=True)
    return cast(Figure, axes[0].figure)


def plot_fit_residuals(
    dataset: xr.Dataset, *, order: float = 1.0, node: str | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the residuals of an order over their standard errors, in both components.

    They are those that the sum of squares judges, without what the errors that they share explain:
    of the measured angle, and of a subtracted slow roll.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.fit`.
    order : float
        Multiple of the speed that is shown [dimensionless].
    node : str, optional
        Node of a rotor system whose probes are shown; by default the first.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.
    """
    dataset = check_dataset("dataset", dataset, (*NEEDED, *RESIDUALS))
    one, _, over = _order_of(dataset, order, node)
    along, across = (one[name].values for name in RESIDUALS)
    with drawing(ax) as ax:
        ax.axhspan(-RARE, RARE, color=palette.INK, alpha=0.08, lw=0.0)
        ax.axhline(0.0, color=palette.INK, lw=0.7)
        small = 0.5 if along.size > MANY else 1.0
        ax.plot(over.values, along, ".", ms=4.0 * small, color=palette.BLUE,
                label="along the mark")  # fmt: skip
        ax.plot(over.values, across, "x", ms=3.5 * small, color=palette.ORANGE,
                label="across it")  # fmt: skip
        most = 1.5 * max(float(np.abs([along, across]).max()), 1.5 * RARE)
        ax.set_ylim(-most, most)
        ax.set_xlabel(str(over.attrs["label"]))
        ax.set_ylabel("residual over its error")
        ax.legend(
            loc="upper left", ncols=2, handlelength=1.2, fontsize=8.0, markerscale=1.0 / small
        )
    return ax


def _nodes_of(dataset: xr.Dataset) -> list[str | None]:
    """Return the nodes at which probes look; None for one disc."""
    return list(dict.fromkeys(dataset["node"].values.tolist())) if "node" in dataset else [None]


def _order_of(
    dataset: xr.Dataset, order: float, node: str | None
) -> tuple[xr.Dataset, Units, xr.DataArray]:
    """Return one order of a fit at a node, the units, and the abscissa with its label."""
    known = _nodes_of(dataset)
    if node is not None and node not in known:
        allowed = listed([repr(each) for each in known if each] or ["left out"], "or")
        raise InputError(f"node must be {allowed}, got {node!r}")
    if known[0] is not None:
        dataset = dataset.isel(window=dataset["node"].values == (node or known[0]))
    compared = dataset["order"].values
    if order not in compared:
        allowed = ", ".join(f"{each:g}" for each in compared)
        raise InputError(f"order must be one of those compared, {allowed}, got {order!r}")
    one = dataset.sel(order=order)
    units = units_of(one, "forward_whirl_amplitude", "speed")
    if is_one_speed(one["speed"].values):
        over = one["t"].copy()
        over.attrs["label"] = label_of("t", one["t"])
    else:
        over = units.speeds(one["speed"].values)
        over.attrs["label"] = label_of("speed", over)
    return one, units, over


def _draw_phase(ax: Axes, places: Values, one: xr.Dataset) -> None:
    """Draw measured over fitted phase lag of one record, where it is significant."""
    lag = np.unwrap(one["fitted_forward_phase_lag"].values)
    lag = lag - 2.0 * math.pi * round(float(np.median(lag)) / (2.0 * math.pi) - 0.25)
    apart = one["forward_phase_lag"].values - lag
    near = lag + np.angle(np.exp(1j * apart))
    error = one["forward_amplitude_error"].values / one["forward_whirl_amplitude"].values
    clear = error < 1.0 / CLEAR
    ax.plot(places, np.degrees(lag), color=palette.ORANGE, lw=1.3, zorder=3.0)
    ax.errorbar(places[clear], np.degrees(near[clear]), np.degrees(error[clear]), **MEASURED)


def _plot_touches(dataset: xr.Dataset, ax: Axes) -> None:
    """Draw the differences of computed and measured contact times."""
    times = dataset["measured_time"]
    apart = dataset["fitted_time"].values - times.values
    compared, error = dataset["compared"].values, float(dataset["time_error"])
    ax.axhline(0.0, color=palette.INK, lw=0.7)
    for kind, words, mark, colour in (
        (1, "entries", "^", palette.BLUE),
        (-1, "exits", "v", palette.ORANGE),
    ):
        for used, face, addition in ((1, colour, ""), (0, "white", ", not compared")):
            here = (dataset["event_kind"].values == kind) & (compared == used)
            here &= np.isfinite(apart)
            if here.any():
                ax.errorbar(times.values[here], apart[here], error, fmt=mark, ms=4.0, lw=0.0,
                            elinewidth=0.8, color=colour, mfc=face,
                            label=words + addition)  # fmt: skip
    most = 1.2 * (float(np.nanmax(np.abs(apart), initial=0.0)) + error)
    ax.set_ylim(-most, most)
    ax.set_xlabel(label_of("t", times))
    ax.set_ylabel(label_of("t", times, words="fitted less measured"))
    alone = int(np.isnan(apart).sum())
    if alone:
        ax.plot([], [], ls="", label=f"{alone} of {apart.size} without a computed contact")
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5, fontsize=8.0,
              handlelength=1.0, columnspacing=1.2, borderaxespad=0.2)  # fmt: skip


def _estimates_in_words(dataset: xr.Dataset) -> str:
    """Return the estimates, a line for two unknowns, and whether errors are lacking."""
    words = []
    for name, value, error, unit in zip(
        dataset["unknown"].values, dataset["estimate"].values, dataset["standard_error"].values,
        dataset["unit"].values, strict=True,
    ):  # fmt: skip
        said = typeset(quantity(float(value), str(unit), error=float(error)))
        is_factor = unit == "1" and dataset.attrs.get("machine") == "RotorSystem"
        called = (
            PARAMETERS_OF_SYSTEM[name].label if is_factor and name in PARAMETERS_OF_SYSTEM else name
        )
        words.append(f"{str(called).replace('_', ' ')} {said}")
    lines = [";  ".join(words[n : n + 2]) for n in range(0, len(words), 2)]
    if np.isnan(dataset["standard_error"].values).all():
        lines.append("no errors: the search has not converged")
    return "\n".join(lines)
