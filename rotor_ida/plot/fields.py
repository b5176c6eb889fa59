"""Force and potential over the plane: surfaces and sections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import axes_or_new, check_dataset, one_value, own_legend, style
from rotor_ida.plot.labels import parameter_text
from rotor_ida.plot.layout import look
from rotor_ida.plot.units import alike, label_of, suited, unit_of


def plot_surface(
    field: xr.Dataset,
    name: str,
    *,
    units: Mapping[str, str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw a component of the force, or the potential, as a surface over the plane.

    Parameters
    ----------
    field : Dataset
        What `rotor_ida.closed_forms.restoring_field` returned, for one ``delta0``.
    name : {"restoring_x", "restoring_y", "potential"}
        What to draw.
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
        If the dataset lacks what is to be drawn, or `ax` is flat.

    Examples
    --------
    >>> from rotor_ida.closed_forms import restoring_field
    >>> ax = plot_surface(restoring_field(x=[0, 1], y=[0, 1], delta0=0.5), "restoring_x")
    >>> ax.get_title()[:11]
    'force $f_x$'
    """
    field = check_dataset("field", field, ("x", "y", "delta0", name))
    field = suited(field, ["x", "y", name], units=units, ax=ax)
    delta0 = one_value("field", field, "delta0")
    with style():
        solid = solid_axes(ax)
        table = field[name].squeeze("delta0") if "delta0" in field[name].dims else field[name]
        across, up = np.meshgrid(field["x"].values, field["y"].values)
        solid.plot_surface(
            across, up, table.transpose("y", "x").values, cmap="cividis", rcount=31, ccount=31,
            linewidth=0.15, edgecolor="#3a3a3a", antialiased=True,
        )  # fmt: skip
        solid.set_xlabel(label_of("x_alone", field["x"]), labelpad=-6)
        solid.set_ylabel(label_of("y_alone", field["y"]), labelpad=-6)
        # from where the surface is seen to rise
        solid.view_init(elev=26, azim=-148 if name == "restoring_x" else -58)
        finish_solid(solid)
        solid.set_title(f"{label_of(name, field[name])},  {parameter_text(delta0=delta0)}", y=0.98)
    return axes_of(solid)


def plot_cuts(
    field: xr.Dataset,
    name: str,
    *,
    at: Sequence[float],
    units: Mapping[str, str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw cuts along x, at a few y, through a component of the force or the potential.

    Parameters
    ----------
    field : Dataset
        What `rotor_ida.closed_forms.restoring_field` returned, for one ``delta0``.
    name : {"restoring_x", "restoring_y", "potential"}
        What to draw.
    at : sequence of float
        The values of y, or the nearest that there are, in the units of the field.
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
        If the dataset lacks what is to be drawn.

    Examples
    --------
    >>> from rotor_ida.closed_forms import restoring_field
    >>> field = restoring_field(x=[-1, 0, 1], y=[0, 2], delta0=0.5)
    >>> plot_cuts(field, "restoring_x", at=[0, 2]).get_ylabel()
    'force $f_x$'
    """
    field = check_dataset("field", field, ("x", "y", "delta0", name))
    rows = [field.sel(y=[place], method="nearest") for place in at]
    delta0 = one_value("field", field, "delta0")
    field = suited(field, ["x", "y", name], units=units, ax=ax)
    with style():
        ax = axes_or_new(ax)
        for number, row in enumerate(rows):
            section = alike("field", row, field)[name].squeeze()
            colour, line = look(number)
            ax.plot(
                field["x"].values, section.values, color=colour, ls=line,
                label=f"$y = {float(section['y']):g}$ {unit_of(section['y'])}".rstrip(),
            )  # fmt: skip
        ax.set_xlabel(label_of("x", field["x"]))
        ax.set_ylabel(label_of(name, field[name]))
        ax.set_title(parameter_text(delta0=delta0))
        own_legend(ax)
    return ax


def solid_axes(ax: Axes | None) -> Any:
    """Return `ax` if it is three-dimensional, or the axes of a new figure."""
    if ax is None:
        return Figure(figsize=(4.2, 3.6), layout="constrained").add_subplot(projection="3d")
    if getattr(ax, "name", "") != "3d":
        raise InputError("ax must be three-dimensional: mixed_panels(..., solid=[...]) makes them")
    return ax


def finish_solid(ax: Any, *, zoom: float = 0.95) -> None:
    """Give three-dimensional axes small labels, white walls and as much room as there is."""
    ax.tick_params(labelsize=7.5, pad=-2.5)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.pane.set_facecolor("white")
        # the walls may reach beyond the square that the axes are given
        axis.pane.set_clip_on(False)
        axis.gridlines.set_clip_on(False)
    ax.set_box_aspect(None, zoom=zoom)


def axes_of(ax: Any) -> Axes:
    """Return three-dimensional axes under the type that all plot functions return."""
    drawn: Axes = ax
    return drawn
