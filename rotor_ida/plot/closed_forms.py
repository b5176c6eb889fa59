"""Plots of closed forms: force and potential, free vibration, claimed solutions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import cast

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.checks import check_choice, check_vector
from rotor_ida.plot.appearance import (
    BLUE,
    INK,
    ORANGE,
    draw_marks,
    drawing,
    finish_solid,
    look,
    own_legend,
    solid_drawing,
)
from rotor_ida.plot.datasets import check_dataset, check_same_units, hold_units, table_of
from rotor_ida.plot.labels import LABELS, label_axis, label_of, number_text, title_of, unit_of
from rotor_ida.texts import in_figure

MOTIONS = {
    "circular_period": ("circle", BLUE, "-", "o"),
    "planar_period": ("line", ORANGE, (0, (5, 1.8)), "s"),
}
CLAIMED = ("t", "solution", "x", "y", "solution_x", "solution_y")


def plot_surface(field: xr.Dataset, name: str, *, ax: Axes | None = None) -> Axes:
    """Draw a component of the force, or the potential, as a surface over the plane.

    Parameters
    ----------
    field : Dataset
        Result of `rotor_ida.closed_forms.restoring_field`, for one ``delta0``.
    name : {"restoring_x", "restoring_y", "potential"}
        Quantity to draw.
    ax : Axes, optional
        Three-dimensional axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida.closed_forms import restoring_field
    >>> ax = plot_surface(restoring_field(x=[0, 1], y=[0, 1], delta0=0.5), "restoring_x")
    >>> ax.get_title()[:11]
    'force $f_x$'
    """
    field = check_dataset("field", field, ("x", "y", "delta0", name))
    title = title_of("field", field, ["delta0"])
    table = table_of("field", field, name, ("y", "x"))
    with solid_drawing(ax) as solid:
        across, up = np.meshgrid(field["x"].values, field["y"].values)
        solid.plot_surface(
            across, up, table.values, cmap="cividis", rcount=31, ccount=31,
            linewidth=0.15, edgecolor="#3a3a3a", antialiased=True,
        )  # fmt: skip
        label_axis(solid.xaxis, "x_alone", field["x"])
        label_axis(solid.yaxis, "y_alone", field["y"])
        hold_units(solid.zaxis, field[name])
        solid.xaxis.labelpad = solid.yaxis.labelpad = -6
        # view in which the surface rises
        solid.view_init(elev=26, azim=-148 if name == "restoring_x" else -58)
        finish_solid(solid)
        solid.set_title(f"{label_of(name, field[name])},  {title}", y=0.98)
    return cast(Axes, solid)


def plot_cuts(field: xr.Dataset, name: str, *, at: Sequence[float], ax: Axes | None = None) -> Axes:
    """Draw cuts along x, at a few y, through a component of the force or the potential.

    Parameters
    ----------
    field : Dataset
        Result of `rotor_ida.closed_forms.restoring_field`, for one ``delta0``.
    name : {"restoring_x", "restoring_y", "potential"}
        Quantity to draw.
    at : sequence of float
        Values of y in the units of the field; the nearest ones are drawn.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida.closed_forms import restoring_field
    >>> field = restoring_field(x=[-1, 0, 1], y=[0, 2], delta0=0.5)
    >>> plot_cuts(field, "restoring_x", at=[0, 2]).get_ylabel()
    'force $f_x$'
    """
    field = check_dataset("field", field, ("x", "y", "delta0", name))
    title = title_of("field", field, ["delta0"])
    table = table_of("field", field, name, ("y", "x"))
    places = check_vector("at", at)
    with drawing(ax) as ax:
        label_axis(ax.xaxis, "x", field["x"])
        label_axis(ax.yaxis, name, field[name])
        for number, place in enumerate(places):
            section = table[int(np.abs(table["y"].values - place).argmin())]
            y = number_text(section["y"].item(), "g")
            colour, line = look(number)
            ax.plot(
                field["x"].values, section.values, color=colour, ls=line,
                label=f"$y = {y}$ {unit_of(field['y'])}".rstrip(),
            )  # fmt: skip
        ax.set_title(title)
        own_legend(ax)
    return ax


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
        Result of `rotor_ida.closed_forms.free_periods`, for one ``delta0``.
    simulated : Dataset, optional
        Simulated periods in the same variables, at any amplitudes.
    over : {"period", "natural"}
        Whether the horizontal axis is the period or the natural frequency ``2 pi/T``.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida.closed_forms import free_periods
    >>> plot_periods(free_periods(amplitude=[1.0, 2.0], delta0=0.0)).get_xlabel()
    'period $T$'
    """
    check_choice("over", over, ("period", "natural"))
    exact = check_dataset("exact", exact, ("amplitude", "delta0", *MOTIONS))
    if simulated is not None:
        simulated = check_dataset("simulated", simulated, ("amplitude", *MOTIONS))
        check_same_units("simulated", simulated, exact)
    period = exact["circular_period"]
    with drawing(ax) as ax:
        label_axis(ax.yaxis, "amplitude", exact["amplitude"])
        if over == "period":
            label_axis(ax.xaxis, "period", period)
        else:
            unit = unit_of(period)
            ax.set_xlabel(f"{LABELS['natural']} [rad/{unit}]" if unit else LABELS["natural"])
        for name, (words, colour, line, marker) in MOTIONS.items():
            ax.plot(
                _across(exact[name], over), exact["amplitude"].values, color=colour, ls=line,
                label=f"on a {words}, exact",
            )  # fmt: skip
            if simulated is not None:
                draw_marks(
                    ax, _across(simulated[name], over), simulated["amplitude"].values, marker,
                    colour, size=4.2, face="white", label=f"on a {words}, simulated",
                )  # fmt: skip
        ax.set_ylim(bottom=0.0)
        ax.set_title(title_of("exact", exact, ["delta0"]))
        own_legend(ax)
    return ax


def plot_portrait(runs: xr.Dataset, *, along: str = "x", ax: Axes | None = None) -> Axes:
    """Draw velocity over displacement along one axis, for several starts, with their periods.

    Parameters
    ----------
    runs : Dataset
        ``x vx y vy`` on ``start`` and ``t``, with the ``amplitude`` and the ``period`` of
        each start, and perhaps one ``delta0`` for the title.
    along : {"x", "y"}
        Which axis.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> table = xr.Dataset({name: (("start", "t"), [[0.0, 1.0]]) for name in ("x", "vx")})
    >>> table = table.assign(amplitude=("start", [1.0]), period=("start", [6.58]))
    >>> plot_portrait(table).get_ylabel()
    'velocity $x$′'
    """
    check_choice("along", along, ("x", "y"))
    runs = check_dataset("runs", runs, (along, f"v{along}", "amplitude", "period"))
    for name, axes in ((along, ("start", "t")), (f"v{along}", ("start", "t")),
                       ("amplitude", ("start",)), ("period", ("start",))):  # fmt: skip
        table_of("runs", runs, name, axes)
    unit = unit_of(runs["period"])
    with drawing(ax) as ax:
        label_axis(ax.xaxis, along, runs[along])
        label_axis(ax.yaxis, f"v{along}", runs[f"v{along}"])
        for number in range(runs.sizes["start"]):
            run = runs.isel(start=number)
            colour, line = look(number)
            if float(run["amplitude"]) <= 0.0:
                draw_marks(ax, 0.0, 0.0, "o", colour, size=3.0)
                continue
            ax.plot(run[along].values, run[f"v{along}"].values, color=colour, ls=line)
            lowest = -float(abs(run[f"v{along}"]).max())
            period = float(run["period"])
            digits = number_text(period, ".2f" if period >= 1.0 else "#.3g")
            ax.annotate(
                f"$T = {digits}$ {unit}".rstrip(), (0.0, lowest),
                xytext=(0.0, -2.5), textcoords="offset points", ha="center", va="top",
                fontsize=8.0,
            )  # fmt: skip
        ax.margins(y=0.11)
        if "delta0" in runs.coords:
            ax.set_title(title_of("runs", runs, ["delta0"]))
    return ax


def plot_solutions(compared: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw x over time, simulated and from each solution.

    Parameters
    ----------
    compared : Dataset
        ``x`` and ``y`` on ``t``, and ``solution_x`` and ``solution_y`` on ``solution`` and
        ``t``; the coordinate ``solution`` names them.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> line = ("t", [0.0, 1.0])
    >>> table = ("solution", "t"), [[0.0, 2.0]]
    >>> data = {"x": line, "y": line, "solution_x": table, "solution_y": table}
    >>> coordinates = {"t": [0.0, 1.0], "solution": ["as printed"]}
    >>> plot_solutions(xr.Dataset(data, coordinates)).get_xlabel()
    'time $t$'
    """
    compared = check_dataset("compared", compared, CLAIMED)
    with drawing(ax, width=7.0, height=2.6) as ax:
        label_axis(ax.xaxis, "t", compared["t"])
        label_axis(ax.yaxis, "x", compared["x"])
        ax.plot(compared["t"].values, compared["x"].values, color=INK, lw=1.4,
                label="simulated")  # fmt: skip
        for number, name in enumerate(compared["solution"].values.tolist(), start=1):
            colour, line = look(number)
            here = compared.sel(solution=name)
            ax.plot(here["t"].values, here["solution_x"].values, color=colour, ls=line,
                    lw=1.0, label=in_figure(str(name)))  # fmt: skip
        ax.set_xlim(float(compared["t"][0]), float(compared["t"][-1]))
        own_legend(ax)
    return ax


def plot_deviation(compared: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the distance of each solution from the simulated motion over time.

    Parameters
    ----------
    compared : Dataset
        As for `plot_solutions`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> line = ("t", [0.0, 1.0])
    >>> table = ("solution", "t"), [[0.0, 2.0]]
    >>> data = {"x": line, "y": line, "solution_x": table, "solution_y": table}
    >>> coordinates = {"t": [0.0, 1.0], "solution": ["as printed"]}
    >>> plot_deviation(xr.Dataset(data, coordinates)).get_xlabel()
    'time $t$'
    """
    compared = check_dataset("compared", compared, CLAIMED)
    across = compared["solution_x"] - compared["x"]
    up = compared["solution_y"] - compared["y"]
    error = (across**2 + up**2) ** 0.5
    with drawing(ax, width=7.0, height=2.6) as ax:
        label_axis(ax.xaxis, "t", compared["t"])
        label_axis(ax.yaxis, "deviation", compared["x"])
        for number, name in enumerate(compared["solution"].values.tolist(), start=1):
            colour, line = look(number)
            values = error.sel(solution=name).values
            shown = np.where(values > 0.0, values, np.nan)
            ax.semilogy(compared["t"].values, shown, color=colour, ls=line, lw=1.1,
                        label=in_figure(str(name)))  # fmt: skip
        ax.set_xlim(float(compared["t"][0]), float(compared["t"][-1]))
        own_legend(ax)
    return ax


def _across(period: xr.DataArray, over: str) -> Values:
    values = np.asarray(period.squeeze().values, dtype=np.float64)
    return values if over == "period" else 2.0 * math.pi / values
