"""Limit cycles of rotor systems: the orbits of nodes."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    BLUE,
    draw_ring,
    drawing,
)
from rotor_ida.plot.branches import EDGES
from rotor_ida.plot.datasets import at_node, check_dataset
from rotor_ida.plot.labels import label_axis
from rotor_ida.schema import words_of
from rotor_ida.texts import in_figure

CYCLE = ("x", "y", "node", "clearance", "contact_node", "centre_x", "centre_y", "stability")


def plot_system_cycle(
    cycle: xr.Dataset, *, node: str | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the orbit of a node on a limit cycle of a rotor system.

    It is drawn on the axes on which it closes: those that turn with the unbalance for an
    axisymmetric system. Contacts with the ground at the node are rings.

    Parameters
    ----------
    cycle : Dataset
        Result of `rotor_ida.limit_cycle` for a rotor system.
    node : str, optional
        Name of the node; by default that of the first contact.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is of another kind, without a cycle, or has no such node.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> system = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
    >>> cycle = limit_cycle(system, speed=2.0)
    >>> plot_system_cycle(cycle).get_title()
    'disc'
    """
    cycle = check_dataset("cycle", cycle, CYCLE)
    if not cycle.sizes["t"]:
        raise InputError("cycle must contain a limit cycle, got a result without one")
    own = at_node(cycle, node)
    chosen = str(own["node"].values)
    stable = words_of(cycle["stability"])[0] == "stable"
    with drawing(ax, width=4.0, height=4.0) as ax:
        label, dashes, width = EDGES["stable" if stable else "unstable"]
        ax.plot(own["x"].values, own["y"].values, color=BLUE, ls=dashes, lw=width, label=label)
        for number in np.flatnonzero(cycle["contact_node"].values == chosen).tolist():
            contact = cycle.isel(contact=number)
            if contact["centre_x"].item() == contact["centre_y"].item() == 0.0:
                draw_ring(ax, contact["clearance"].item())
        turns = "rotating_" if cycle.attrs.get("axes", "turning") == "turning" else ""
        label_axis(ax.xaxis, f"{turns}x", cycle["x"])
        label_axis(ax.yaxis, f"{turns}y", cycle["y"])
        ax.set_aspect("equal", adjustable="datalim")
        ax.set_title(in_figure(chosen))
    return ax
