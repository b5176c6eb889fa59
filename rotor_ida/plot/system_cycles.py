"""Limit cycles of rotor systems: the orbits of nodes, and branches over the speed."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.cycles.branch_course import runs_of
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    BLUE,
    draw_ring,
    drawing,
    own_legend,
    raise_limit,
)
from rotor_ida.plot.branches import EDGES, MARKS, draw_specials
from rotor_ida.plot.datasets import at_contact, at_node, check_dataset
from rotor_ida.plot.labels import label_axis, label_parameter, speeds_in
from rotor_ida.plot.motion import title_of_contact
from rotor_ida.plot.responses import draw_clearance
from rotor_ida.schema import words_of
from rotor_ida.texts import in_figure

CYCLE = ("x", "y", "node", "clearance", "contact_node", "centre_x", "centre_y", "stability")
BRANCH = ("speed", "stability", "radius_max", "clearance", "contact_node", "special_kind",
          "special_speed", "special_radius_max", "special_point")  # fmt: skip


# Axes on which a cycle closes, as they are called in figures.
AXES = {"turning": "rotating", "fixed": "fixed"}


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
    'disc, on rotating axes'
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
        label_axis(ax.xaxis, "x", cycle["x"])
        label_axis(ax.yaxis, "y", cycle["y"])
        ax.set_aspect("equal", adjustable="datalim")
        ax.set_title(
            f"{in_figure(chosen)}, on {AXES[str(cycle.attrs.get('axes', 'turning'))]} axes"
        )
    return ax


def plot_system_branch(
    branch: xr.Dataset, *, contact: int | str = 0, ax: Axes | None = None
) -> Axes:
    """Draw a branch of limit cycles of a rotor system: the largest distance over the speed.

    Solid where the cycles are stable, dashed where not. Special points are marked. Several branches
    can share axes, also with `plot_amplitude`.

    Parameters
    ----------
    branch : Dataset
        Result of `rotor_ida.continue_cycle` for a rotor system.
    contact : int or str
        The contact, by its number or its node. Its clearance is a dashed line.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is of another kind, or has no such contact.

    Examples
    --------
    >>> from rotor_ida import Rotor, continue_cycle
    >>> system = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
    >>> branch = continue_cycle(system, speed=2.0, limits=(1.9, 2.1))
    >>> plot_system_branch(branch).get_title()
    'contact 0 at disc'
    """
    branch = check_dataset("branch", branch, BRANCH)
    part = at_contact(branch, contact)
    with drawing(ax) as ax:
        fresh = not ax.has_data()
        if fresh:
            label_parameter(ax.xaxis, "speed", branch)
            label_axis(ax.yaxis, "radius", branch["radius_max"])
            draw_clearance(ax, part)
            ax.set_title(title_of_contact(branch, part["contact"].item()))
        speeds, radii, words = _course_of(part)
        for first, last in runs_of(words):
            label, dashes, width = EDGES[words[first]]
            known = ax.get_legend_handles_labels()[1]
            ax.plot(speeds[first : last + 1], radii[first : last + 1], color=BLUE, ls=dashes,
                    lw=width, label="_" if label in known else label)  # fmt: skip
        marked = speeds_in(part["special_speed"]).values, part["special_radius_max"].values
        draw_specials(ax, part, *marked, tuple(MARKS))
        raise_limit(ax, float(radii.max()))
        own_legend(ax)
    return ax


def _course_of(part: xr.Dataset) -> tuple[Values, Values, list[str]]:
    """Return speeds and radii with the special points in their places, and stability between.

    Between a point and a special one the stability is that of the point.
    """
    count, stability = part.sizes["point"], words_of(part["stability"])
    behind = part["special_point"].values
    order = np.argsort(np.append(np.arange(count), behind), kind="stable")
    speeds, radii = (
        np.append(values, special)[order]
        for values, special in (
            (speeds_in(part["speed"]).values, speeds_in(part["special_speed"]).values),
            (part["radius_max"].values, part["special_radius_max"].values),
        )
    )
    words = [
        stability[here if here < count else min(int(behind[here - count]) + 1, count - 1)]
        for here in order[:-1].tolist()
    ]
    return speeds, radii, words
