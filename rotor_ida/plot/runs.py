"""Plots of one run of any rotor over time: its motion, its forces, its orbits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import (
    SettledLayout,
    circle,
    draw_level,
    draw_ring,
    new_figure,
    say_in_middle,
    style,
)
from rotor_ida.plot.datasets import contact_text
from rotor_ida.plot.decimation import draw_over_time
from rotor_ida.plot.labels import label_axis, label_of, title_of
from rotor_ida.plot.legends import shared_legend
from rotor_ida.plot.motion import (
    Place,
    checked_run,
    draw_forces,
    draw_motion,
    draw_orbit,
    forces_in,
    in_contact,
    line_width,
    mark_events,
    place_of_disc,
    places_in,
    shade_contacts,
    square,
)
from rotor_ida.results.checked_run import check_system_run, is_of_system, nodes_in
from rotor_ida.schema import MODE
from rotor_ida.signals.nodes import Ring, check_node, path_in, rings_of

# Panels in a row, nodes of the figure of a run that shows all of them, and panels of one figure.
COLUMNS, FEW_NODES, MOST_ORBITS = 4, 12, 100
# Width of a figure, size of a panel of an orbit, at most, and height of one over time [inch].
WIDTH, SIDE, ROW = 7.2, 3.0, 1.55
# Columns of the legend under all panels.
ENTRIES = 6
# Height of a panel of forces [inch].
TALL = 1.65


def plot_run(run: xr.Dataset, *, node: str | None = None) -> Figure:
    """Draw one run: displacements, radius, contact force and orbit; of a system all its nodes.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.simulate` or `rotor_ida.run_up`, of any rotor.
    node : str, optional
        Name of a node of a rotor system.

    Returns
    -------
    Figure
        The figure. Of one disc, or at a node, its axes are the displacements over time; at each
        contact the radius with the clearance and the events, and the force with its peaks; with
        friction the slip speed; and the orbits. Contact is shaded, paler where contacts are too
        close to tell apart. Of a system with several nodes the axes are the orbits of its nodes
        and the forces of its contacts; of more than 12 nodes those with contacts and close
        clearances are shown.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> figure = plot_run(simulate(rotor, start=(0, 0, 0, 0), duration=20, samples=401))
    >>> [ax.get_ylabel() for ax in figure.axes][:2]
    ['displacement $z$', 'radius $|z|$']
    """
    run = checked_run(run)
    if not is_of_system(run):
        if node is not None:
            raise InputError(f"node must be left out for a run of one disc, got {shown(node)}")
        return _history(run, [place_of_disc(run)], title_of("run", run))
    names = nodes_in(run)
    if node is None and len(names) != 1:
        return _overview(run)
    name = names[0] if node is None else check_node(run, node)
    here = run.sel(node=name)
    return _history(here, places_in(run, [name]), title_of("run", here))


def _history(run: xr.Dataset, places: Sequence[Place], title: str) -> Figure:
    """Draw the motion of a disc or node over time, in each of its contacts, beside its orbits."""
    rows: list[tuple[Callable[[Axes, Place], None], Place]] = [(_draw_displacements, places[0])]
    rows += [(_draw_radius, place) for place in places]
    rows += [(_draw_force, place) for place in places]
    rows += [(_draw_slip, place) for place in places if place.rubs]
    with style():
        layout = SettledLayout(h_pad=0.03, hspace=0.0)
        figure = new_figure(WIDTH, 0.6 + ROW * len(rows), layout=layout)
        grid = figure.add_gridspec(len(rows), 2)
        first = figure.add_subplot(grid[0, 0])
        history = [first]
        history += [figure.add_subplot(grid[row, 0], sharex=first) for row in range(1, len(rows))]
        for ax, (draw, place) in zip(history, rows, strict=True):
            draw(ax, place)
            shade_contacts(ax, place.run)
            if len(places) > 1 and ax is not first:
                ax.set_title(place.title, fontsize=9.0)
        _finish_rows(figure, run, history)
        orbits = []
        for part, place in zip(_cut(len(rows), len(places)), places, strict=True):
            orbits.append(figure.add_subplot(grid[part, 1]))
            draw_orbit(orbits[-1], place)
            _draw_close_clearance(orbits[-1], run)
            orbits[-1].set_box_aspect(1.0)
            orbits[-1].set(xlabel=label_of("x", run["x"]), ylabel=label_of("y", run["y"]))
        shared_legend(figure, [*history, *orbits], columns=ENTRIES, outer=False)
        figure.suptitle(title, fontsize=10.0)
    return figure


def _cut(rows: int, parts: int) -> list[slice]:
    """Return rows of a grid cut into equal parts."""
    ends = np.linspace(0, rows, parts + 1).round().astype(int).tolist()
    return [slice(begin, end) for begin, end in pairwise(ends)]


def _overview(run: xr.Dataset) -> Figure:
    """Draw the orbits of the nodes of a system, and the forces of its contacts."""
    names = nodes_in(run)
    if len(names) > FEW_NODES:
        touched = set(run["contact_node"].values.tolist())
        if "node_clearance" in run.variables:
            touched |= set(run["node"].values[np.isfinite(run["node_clearance"].values)].tolist())
        names = [name for name in names if name in touched] or names[:FEW_NODES]
    rings = rings_of(run, names)
    contacts = run.sizes["contact"]
    heights = _height_of_orbits(rings), 0.7 + TALL * max(contacts, 1)
    with style():
        figure = new_figure(WIDTH, sum(heights))
        above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=heights)[:, 0]
        _draw_orbits(above, run, rings)
        axes = below.subplots(max(contacts, 1), 1, sharex=True, squeeze=False)[:, 0].tolist()
        for number, ax in enumerate(axes[:contacts]):
            own = in_contact(run, number)
            draw_forces(ax, forces_in(own))
            shade_contacts(ax, own)
            ax.set_title(contact_text(run, number))
        if not contacts:
            say_in_middle(axes[0], "no contacts")
        _finish_rows(below, run, axes)
        if any(ax.get_legend_handles_labels()[1] for ax in axes):
            shared_legend(below, axes, columns=ENTRIES, outer=False)
        above.suptitle(title_of("run", run), fontsize=10.0)
    return figure


def _finish_rows(figure: Figure | SubFigure, run: xr.Dataset, axes: Sequence[Axes]) -> None:
    """Label the time below rows of panels that share it."""
    for ax in axes:
        ax.grid(visible=False, axis="x")
    for ax in axes[:-1]:
        ax.tick_params(labelbottom=False)
    axes[0].set_xlim(*run["t"].values[[0, -1]])
    label_axis(axes[-1].xaxis, "t", run["t"])
    figure.align_ylabels(axes)


def _draw_displacements(ax: Axes, place: Place) -> None:
    """Draw the displacements over time."""
    path = place.path
    for name, values, colour in (("x", path.x, palette.INK), ("y", path.y, palette.ORANGE)):
        draw_over_time(ax, path.time, values, color=colour, lw=0.8, label=f"${name}$")
    label_axis(ax.yaxis, "displacement", place.run["x"])


def _draw_radius(ax: Axes, place: Place) -> None:
    """Draw the radius over time, with flight and contact in colour, the stator and the events."""
    width = line_width(place.run)
    draw_motion(ax, place.path, place.path.time, place.radius, width=width)
    draw_level(ax, place.clearance)
    if place.has_stator:
        mark_events(ax, place.run, place.run["event_time"].values, place.event_radius)
    ax.set_ylim(bottom=0.0)
    label_axis(ax.yaxis, "radius", place.run["x"])


def _draw_force(ax: Axes, place: Place) -> None:
    """Draw the forces of a contact over time."""
    if place.has_stator:
        draw_forces(ax, forces_in(place.run, place.path))
    else:
        say_in_middle(ax, "no contacts")


def _draw_slip(ax: Axes, place: Place) -> None:
    """Draw the slip speed over time, in contact."""
    run = place.run
    slip = np.where(run["mode"].values == MODE["flight"], np.nan, run["slip_speed"].values)
    ax.axhline(0.0, color=palette.INK, lw=0.7, ls=palette.DASHES)
    # a short contact is less than a dot of a line
    ax.plot(run["t"].values, slip, color=palette.INK, lw=line_width(run), marker=".", ms=2.0)
    ax.margins(y=0.15)
    label_axis(ax.yaxis, "slip_speed", run["slip_speed"])


def plot_node_orbits(run: xr.Dataset, *, nodes: Sequence[str] | None = None) -> Figure:
    """Draw the orbit of each node in a panel, with the clearance circles of its contacts.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.simulate` or `rotor_ida.run_up` for a `rotor_ida.RotorSystem`.
    nodes : sequence of str, optional
        Nodes to draw; default: all.

    Returns
    -------
    Figure
        The figure. If a stator moves, the orbit is drawn relative to it. Where friction
        acts, colours show slip and rolling.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> system = Rotor(omega=1.7, zeta=0.07, delta0=0.5).system()
    >>> run = simulate(system, speed=1.7, duration=20)
    >>> [ax.get_title() for ax in plot_node_orbits(run).axes]
    ['disc']
    """
    run = checked_run(check_system_run(run))
    if isinstance(nodes, str) or not isinstance(nodes, Sequence | None):
        raise InputError(f"nodes must be a list of names of nodes, got {shown(nodes)}")
    names = nodes_in(run) if nodes is None else [check_node(run, node) for node in nodes]
    rings = rings_of(run, names)
    if not 0 < len(rings) <= MOST_ORBITS:
        raise InputError(f"nodes must have 1 to {MOST_ORBITS} orbits, got {len(rings)}")
    with style():
        figure = new_figure(WIDTH, _height_of_orbits(rings))
        _draw_orbits(figure, run, rings)
        figure.suptitle(title_of("run", run), fontsize=10.0)
    return figure


def _height_of_orbits(rings: Sequence[Ring]) -> float:
    """Return the height of the panels of orbits, with title and legend [inch]."""
    columns = min(len(rings), COLUMNS) or 1
    return 0.9 + math.ceil(len(rings) / columns) * min(WIDTH / columns, SIDE)


def _draw_orbits(figure: Figure | SubFigure, run: xr.Dataset, rings: Sequence[Ring]) -> None:
    """Draw an orbit in each panel of a figure."""
    columns = min(len(rings), COLUMNS) or 1
    rows = math.ceil(len(rings) / columns) or 1
    axes = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
    for place, (ax, ring) in enumerate(zip(axes, rings, strict=False)):
        path = path_in(run, ring)
        for number in ring.contacts:
            part = run.isel(contact=number)
            draw_ring(ax, float(part["clearance"]), complex(part["centre_x"], part["centre_y"]))
        if not ring.stator:
            _draw_close_clearance(ax, run.sel(node=ring.node))
        draw_motion(ax, path, path.x, path.y, width=line_width(run))
        ax.set_title(ring.title)
        square(ax)
        if place // columns == rows - 1:
            label_axis(ax.xaxis, "x_alone", run["x"])
        if place % columns == 0:
            label_axis(ax.yaxis, "y_alone", run["y"])
    for ax in axes[len(rings) :]:
        ax.remove()
    shared_legend(figure, axes[: len(rings)], columns=ENTRIES, outer=False)


def _draw_close_clearance(ax: Axes, run: xr.Dataset) -> None:
    """Draw the clearance of a node that has no contact, if it has one."""
    clearance = float(run.get("node_clearance", np.nan))
    if np.isfinite(clearance):
        ax.plot(
            *circle(clearance), color=palette.RED, lw=0.9, ls=":", label="close clearance",
            zorder=2.6,
        )  # fmt: skip
