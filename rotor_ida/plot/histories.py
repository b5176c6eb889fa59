"""One run over time: a displacement, or the orbit drawn out in three dimensions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.checks import check_choice
from rotor_ida.plot.appearance import BLUE, RED, axes_or_new, check_dataset, style
from rotor_ida.plot.fields import axes_of, finish_solid, solid_axes
from rotor_ida.plot.paths import path_of
from rotor_ida.plot.runs import NEEDED, SIZED_BY
from rotor_ida.plot.units import label_of, suited

VALUES = ("x", "y", "radius")


def plot_history(
    run: xr.Dataset,
    name: str,
    *,
    units: Mapping[str, str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw a displacement or the radius over time, contact and flight in their colours.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.simulate` returned.
    name : {"x", "y", "radius"}
        What to draw.
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
        If the dataset is no run.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> plot_history(simulate(rotor, start=(0, 0, 0, 0), duration=20), "x").get_ylabel()
    'displacement $x$'
    """
    run = check_dataset("run", run, NEEDED)
    check_choice("name", name, VALUES)
    run = suited(run, SIZED_BY, units=units, ax=ax)
    with style():
        ax = axes_or_new(ax, width=7.0, height=2.4)
        path = path_of(run)
        values = {"x": path.x, "y": path.y, "radius": path.radius}[name]
        for chosen, colour, label in ((~path.in_contact, BLUE, "flight"),
                                      (path.in_contact, RED, "contact")):  # fmt: skip
            shown = chosen.copy()
            shown[1:] |= chosen[:-1]
            if chosen[:-1].any():
                ax.plot(path.time, np.where(shown, values, np.nan), color=colour, lw=0.9,
                        label=label)  # fmt: skip
        ax.set_xlim(float(path.time[0]), float(path.time[-1]))
        ax.set_xlabel(label_of("t", run["t"]))
        ax.set_ylabel(label_of(name, run["x"]))
    return ax


def plot_drawn_out(
    run: xr.Dataset, *, units: Mapping[str, str] | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the orbit over time in three dimensions, contact and flight in their colours.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.simulate` returned.
    units : mapping of str to str, optional
        Units for a dataset of `rotor_ida.dimensional`, such as ``{"length": "mm"}``; by default
        those with the SI prefix that suits.
    ax : Axes, optional
        Three-dimensional axes to draw on; by default those of a new figure.

    Returns
    -------
    Axes
        Where it was drawn.

    Raises
    ------
    InputError
        If the dataset is no run, or `ax` is flat.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> plot_drawn_out(simulate(rotor, start=(0, 0, 0, 0), duration=20)).get_xlabel()
    'time $t$'
    """
    run = suited(check_dataset("run", run, NEEDED), SIZED_BY, units=units, ax=ax)
    with style():
        solid = solid_axes(ax)
        path = path_of(run)
        for chosen, colour, label in ((~path.in_contact, BLUE, "flight"),
                                      (path.in_contact, RED, "contact")):  # fmt: skip
            shown = chosen.copy()
            shown[1:] |= chosen[:-1]
            if chosen[:-1].any():
                x, y = (np.where(shown, values, np.nan) for values in (path.x, path.y))
                solid.plot(path.time, x, y, color=colour, lw=0.7, label=label)
        solid.set_xlabel(label_of("t", run["t"]), labelpad=-4)
        solid.set_ylabel(label_of("x_alone", run["x"]), labelpad=-6)
        solid.set_zlabel(label_of("y_alone", run["y"]), labelpad=-6)
        solid.view_init(elev=22, azim=-58)
        finish_solid(solid, zoom=1.12)
    return axes_of(solid)
