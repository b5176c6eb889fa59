"""Plots of a run of a rotor system: orbits of all nodes, forces, one node, the deflected shape."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import MaxNLocator

from rotor_ida.arrays import Values
from rotor_ida.checks import check_count, check_real, shown
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    BLUE,
    DASHES,
    GREY,
    INK,
    ORANGE,
    RED,
    circle,
    draw_marks,
    new_figure,
    say_in_middle,
    shared_legend,
    style,
)
from rotor_ida.plot.decimation import kept_in_columns
from rotor_ida.plot.forces import PEAK, peaks_on_curve, shade_contacts
from rotor_ida.plot.labels import (
    SEPARATOR,
    label_axis,
    title_of_node,
    title_of_system,
    unit_of,
)
from rotor_ida.plot.runs import draw_motion, mark_events
from rotor_ida.results.run import check_system_run, nodes_in
from rotor_ida.results.si_units import in_suitable_units
from rotor_ida.schema import MODE
from rotor_ida.signals.nodes import Ring, check_node, path_in, rings_of
from rotor_ida.texts import in_figure

# Panels in a row, nodes of the figure of a run that shows all of them, and panels of one figure.
COLUMNS, FEW_NODES, MOST_ORBITS = 4, 12, 100
# Along an axis: the most names of nodes, and the most characters that are not turned.
MOST_NAMES, MOST_CHARACTERS = 40, 60
# Between two clearances at one node, of the length of the axis.
BESIDE = 0.01
# Entries of a legend in one line.
MOST_IN_A_LINE = 6
# Size of a panel of an orbit, at most, and height of one of forces or displacements [inch].
WIDTH, SIDE, ROW = 7.2, 3.0, 1.5


def system_figure(run: xr.Dataset) -> Figure:
    """Draw a run of a rotor system: the orbits of its nodes, and the forces of its contacts.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.simulate` or `rotor_ida.run_up` for a `rotor_ida.RotorSystem`.

    Returns
    -------
    Figure
        The figure. Of more than 12 nodes it shows those with contacts and close clearances.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> system = Rotor(omega=1.7, zeta=0.07, delta0=0.5).system()
    >>> run = simulate(system, speed=1.7, duration=20)
    >>> [ax.get_title() for ax in system_figure(run).axes]
    ['disc', 'contact 0 at disc']
    """
    run = _checked(run)
    names = nodes_in(run)
    if len(names) > FEW_NODES:
        touched = set(run["contact_node"].values.tolist())
        if "node_clearance" in run.variables:
            touched |= set(run["node"].values[np.isfinite(run["node_clearance"].values)].tolist())
        names = [name for name in names if name in touched] or names[:FEW_NODES]
    rings = rings_of(run, names)
    contacts = list(range(run.sizes["contact"]))
    heights = _height_of_orbits(rings), 0.7 + 0.8 * ROW * max(len(contacts), 1)
    with style():
        figure = new_figure(WIDTH, sum(heights))
        above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=heights)[:, 0]
        _draw_orbits(above, run, rings)
        _draw_forces(below, run, contacts)
        above.suptitle(title_of_system(run), fontsize=10.0)
    return figure


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
        The figure. In a stator that moves the orbit is that relative to the stator. Where friction
        acts, colours show slip and rolling.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> system = Rotor(omega=1.7, zeta=0.07, delta0=0.5).system()
    >>> run = simulate(system, speed=1.7, duration=20)
    >>> [ax.get_title() for ax in plot_node_orbits(run).axes]
    ['disc']
    """
    run = _checked(run)
    if isinstance(nodes, str) or not isinstance(nodes, Sequence | None):
        raise InputError(f"nodes must be a list of names of nodes, got {shown(nodes)}")
    names = nodes_in(run) if nodes is None else [check_node(run, node) for node in nodes]
    rings = rings_of(run, names)
    if not 0 < len(rings) <= MOST_ORBITS:
        raise InputError(f"nodes must have 1 to {MOST_ORBITS} orbits, got {len(rings)}")
    with style():
        figure = new_figure(WIDTH, _height_of_orbits(rings))
        _draw_orbits(figure, run, rings)
        figure.suptitle(title_of_system(run), fontsize=10.0)
    return figure


def plot_contact_forces(run: xr.Dataset, *, contact: int | None = None) -> Figure:
    """Draw the forces of each contact over time, with their peaks and the time in contact.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.simulate` or `rotor_ida.run_up` for a `rotor_ida.RotorSystem`.
    contact : int, optional
        Number of the contact to draw; default: all.

    Returns
    -------
    Figure
        The figure: a panel for each contact, with the normal force, and with the tangential force
        where friction acts.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> system = Rotor(omega=1.7, zeta=0.07, delta0=0.5).system()
    >>> run = simulate(system, speed=1.7, duration=20)
    >>> plot_contact_forces(run, contact=0).axes[0].get_ylabel()
    'normal force $N$'
    """
    run = _checked(run)
    numbers = list(range(run.sizes["contact"]))
    if contact is not None:
        if not numbers:
            raise InputError(f"contact must be left out for a run without, got {shown(contact)}")
        numbers = [check_count("contact", contact, 0, len(numbers) - 1)]
    with style():
        figure = new_figure(WIDTH, 0.9 + ROW * max(len(numbers), 1))
        _draw_forces(figure, run, numbers)
        figure.suptitle(title_of_system(run), fontsize=10.0)
    return figure


def plot_node_history(run: xr.Dataset, *, node: str) -> Figure:
    """Draw the motion of a node over time, and its distance from the centre of each stator there.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.simulate` or `rotor_ida.run_up` for a `rotor_ida.RotorSystem`.
    node : str
        The node.

    Returns
    -------
    Figure
        The figure: displacements, and for each contact at the node the radius with the clearance
        and the events.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> system = Rotor(omega=1.7, zeta=0.07, delta0=0.5).system()
    >>> run = simulate(system, speed=1.7, duration=20)
    >>> [ax.get_ylabel() for ax in plot_node_history(run, node="disc").axes]
    ['displacement $z$', 'radius $|z|$']
    """
    run = _checked(run)
    name = check_node(run, node)
    rings = [
        Ring(name, ring.stator, [number])
        for ring in rings_of(run, [name])
        for number in ring.contacts
    ]
    alone = Ring(name, "", [])
    with style():
        figure = new_figure(WIDTH, 0.9 + ROW * (1 + max(len(rings), 1)))
        axes = figure.subplots(1 + max(len(rings), 1), 1, sharex=True)
        _draw_displacements(axes[0], run, alone)
        for ax, ring in zip(axes[1:], rings or [alone], strict=True):
            _draw_radius(ax, run, ring)
        _finish_rows(figure, run, axes)
        figure.suptitle(title_of_node(run.sel(node=name)), fontsize=10.0)
    return figure


def plot_shape(run: xr.Dataset, *, t: float | None = None) -> Figure:
    """Draw the deflected shape at an instant, with the clearances.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.simulate` or `rotor_ida.run_up` for a `rotor_ida.RotorSystem`.
    t : float, optional
        The instant, in the unit of the run: the sample nearest to it is drawn. Default: where a
        node is farthest from its place of rest.

    Returns
    -------
    Figure
        The figure: x and y over the nodes, in their order or at their axial positions, if the
        system has these. Bars show where each stator leaves room, nodes in contact are marked.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> system = Rotor(omega=1.7, zeta=0.07, delta0=0.5).system()
    >>> run = simulate(system, speed=1.7, duration=20)
    >>> [ax.get_ylabel() for ax in plot_shape(run, t=10.0).axes]
    ['displacement $x$', 'displacement $y$']
    """
    run = _checked(run)
    now = run.isel(t=_sample_at(run, t))
    has_positions = "axial_position" in run.variables
    across = np.arange(float(run.sizes["node"]))
    if has_positions:
        across = run["axial_position"].values
    with style():
        figure = new_figure(WIDTH, 4.4)
        axes = figure.subplots(2, 1, sharex=True)
        for ax, name in zip(axes, ("x", "y"), strict=True):
            _draw_shape(ax, now, name, across)
        if has_positions:
            label_axis(axes[1].xaxis, "axial_position", run["axial_position"])
        else:
            name_nodes(axes[1], nodes_in(run))
        figure.align_ylabels(axes)
        shared_legend(figure, axes, outer=False)
        unit = unit_of(run["t"])
        words = [title_of_system(run), f"$t = {float(now['t']):.6g}$ {unit}".strip()]
        figure.suptitle(SEPARATOR.join(filter(None, words)), fontsize=10.0)
    return figure


def _checked(run: xr.Dataset) -> xr.Dataset:
    """Return a run of a system in suitable units, with the events between its samples."""
    found = in_suitable_units(check_system_run(run))
    times, events = found["t"].values, found["event_time"].values
    return found.isel(event=(events >= times[0]) & (events <= times[-1]))


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
            x, y = circle(float(part["clearance"]))
            x, y = x + float(part["centre_x"]), y + float(part["centre_y"])
            ax.plot(x, y, color=INK, lw=0.9, ls=DASHES, label="clearance", zorder=2.6)
        if not ring.stator and "node_clearance" in run.variables:  # NaN where none is given
            other = float(run["node_clearance"].sel(node=ring.node))
            ax.plot(*circle(other), color=RED, lw=0.9, ls=":", label="close clearance", zorder=2.6)
        draw_motion(ax, path, path.x, path.y, width=_line_width(run))
        ax.set_title(ring.title)
        ax.set_aspect("equal", adjustable="datalim")
        ax.set_box_aspect(1.0)
        ax.tick_params(labelsize=8.0)
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_locator(MaxNLocator(nbins=4, steps=[1, 2, 5, 10]))
        if place // columns == rows - 1:
            label_axis(ax.xaxis, "x_alone", run["x"])
        if place % columns == 0:
            label_axis(ax.yaxis, "y_alone", run["y"])
    for ax in axes[len(rings) :]:
        ax.remove()
    shared_legend(figure, axes[: len(rings)], columns=6, outer=False)


def _draw_forces(figure: Figure | SubFigure, run: xr.Dataset, contacts: Sequence[int]) -> None:
    """Draw the forces of each contact in a panel of a figure."""
    axes = figure.subplots(max(len(contacts), 1), 1, sharex=True, squeeze=False)[:, 0].tolist()
    time = run["t"].values
    for ax, number in zip(axes, contacts, strict=False):
        part = _of_contacts(run, [number]).isel(contact=number)
        normal, tangential = (part[f"{each}_force"].values for each in ("normal", "tangential"))
        rubs = bool(tangential.any())
        shade_contacts(ax, part)
        for name, values, colour in (
            ("normal force", normal, BLUE), *([("tangential force", tangential, ORANGE)] * rubs),
        ):  # fmt: skip
            kept = kept_in_columns(time, values)
            ax.plot(time[kept], values[kept], color=colour, lw=0.9, label=name)
        peaks = peaks_on_curve(part, time, normal)
        if peaks[0].size:
            draw_marks(ax, *peaks, "o", RED, size=2.8, face="white", edge=0.8, label=PEAK)
        if not normal.any() and not part.sizes["episode"]:
            say_in_middle(ax, "no contact")
            ax.set_yticks([])
        elif not tangential.min(initial=0.0) < 0.0:
            ax.set_ylim(bottom=0.0)
        words = "force" if rubs else None
        label_axis(ax.yaxis, "normal_force", part["normal_force"], words=words)
        node, stator = (str(part[f"contact_{each}"].values) for each in ("node", "stator"))
        place = Ring(node, stator, [number])
        ax.set_title(f"contact {number} at {place.title}")
    if not contacts:
        say_in_middle(axes[0], "no contacts")
        axes[0].set_yticks([])
    _finish_rows(figure, run, axes)


def _draw_displacements(ax: Axes, run: xr.Dataset, ring: Ring) -> None:
    """Draw the displacements of a node in space over time."""
    time = run["t"].values
    here = np.flatnonzero(run["contact_node"].values == ring.node).tolist()
    shade_contacts(ax, _of_contacts(run, here))
    for name, colour in (("x", INK), ("y", ORANGE)):
        values = run[name].sel(node=ring.node).values
        kept = kept_in_columns(time, values)
        ax.plot(time[kept], values[kept], color=colour, lw=0.8, label=f"${name}$")
    label_axis(ax.yaxis, "displacement", run["x"])


def _draw_radius(ax: Axes, run: xr.Dataset, ring: Ring) -> None:
    """Draw the distance of a node from the centre of a contact over time, with its events."""
    path = path_in(run, ring)
    centre = 0.0j
    for number in ring.contacts:
        part = run.isel(contact=number, event=run["event_contact"].values == number)
        centre = complex(part["centre_x"], part["centre_y"])
        clearance = float(part["clearance"])
        ax.axhline(clearance, color=INK, lw=0.7, ls=DASHES, zorder=2.6, label="clearance")
        shade_contacts(ax, _of_contacts(run, [number]))
        up = np.hypot(part["event_contact_x"].values, part["event_contact_y"].values)
        mark_events(ax, part, part["event_time"].values, up)
        if len(run["contact_node"]) > 1:
            ax.set_title(f"contact {number} at {ring.title}")
    radius = np.abs(path.x + 1j * path.y - centre)
    draw_motion(ax, path, path.time, radius, width=0.9)
    ax.set_ylim(bottom=0.0)
    label_axis(ax.yaxis, "radius", run["x"])


def _draw_shape(ax: Axes, now: xr.Dataset, name: str, across: Values) -> None:
    """Draw one displacement of all nodes at an instant, with the room in the stators."""
    up, nodes = now[name].values, nodes_in(now)
    now = now.isel(contact=np.isin(now["contact_node"].values, nodes))
    order = np.argsort(across, kind="stable")
    ax.axhline(0.0, color=GREY, lw=0.7)
    ax.plot(across[order], up[order], color=BLUE, marker="o", ms=3.2, label="shaft", zorder=2.8)
    places = np.array([nodes.index(each) for each in now["contact_node"].values], dtype=int)
    if places.size:
        centres = up[places] - now[f"contact_{name}"].values
        # those of one node side by side
        shared = np.array([(places[:k] == place).sum() for k, place in enumerate(places)])
        aside = BESIDE * float(np.ptp(across)) * shared
        ax.errorbar(across[places] + aside, centres, now["clearance"].values, fmt="none",
                    ecolor=INK, elinewidth=0.8, capsize=3.5, label="clearance")  # fmt: skip
    touching = places[now["mode"].values != MODE["flight"]]
    if touching.size:
        draw_marks(ax, across[touching], up[touching], "o", RED, size=5.5, label="in contact",
                   level=3.0)  # fmt: skip
    label_axis(ax.yaxis, name, now[name])


def name_nodes(ax: Axes, names: Sequence[str]) -> None:
    """Write the names of nodes along an axis, turned or not all of them if there are many."""
    step = math.ceil(len(names) / MOST_NAMES)
    drawn = list(map(in_figure, names[::step]))
    turned = sum(map(len, drawn)) + 2 * len(drawn) > MOST_CHARACTERS
    ax.set_xticks(range(0, len(names), step), drawn, rotation=90 if turned else 0)
    ax.set_xlim(-0.5, len(names) - 0.5)
    ax.set_xlabel("node")


def _sample_at(run: xr.Dataset, t: object) -> int:
    """Return the number of the sample nearest to a time; default: of the largest deflection."""
    times = run["t"].values
    if t is None:
        return int(np.argmax(np.hypot(run["x"].values, run["y"].values).max(axis=1, initial=0.0)))
    time = check_real("t", t)
    if not times[0] <= time <= times[-1]:
        raise InputError(f"t must lie from {times[0]:g} to {times[-1]:g}, got {time!r}")
    return int(np.argmin(np.abs(times - time)))


def _of_contacts(run: xr.Dataset, contacts: Sequence[int]) -> xr.Dataset:
    """Return a run with the episodes of some contacts only."""
    return run.isel(episode=np.isin(run["episode_contact"].values, contacts))


def _finish_rows(figure: Figure | SubFigure, run: xr.Dataset, axes: Sequence[Axes]) -> None:
    """Label the time below rows of panels that share it, and put the legend under them."""
    for ax in axes:
        ax.grid(visible=False, axis="x")
    axes[0].set_xlim(*run["t"].values[[0, -1]])
    label_axis(axes[-1].xaxis, "t", run["t"])
    figure.align_ylabels(axes)
    count = len({label for ax in axes for label in ax.get_legend_handles_labels()[1]})
    if count:
        columns = count if count <= MOST_IN_A_LINE else math.ceil(count / 2)
        shared_legend(figure, axes, columns=columns, outer=False)


def _line_width(run: xr.Dataset) -> float:
    """Return the width of an orbit: thin if it has many turns."""
    time = run["t"].values
    speeds = run["speed"].values if "speed" in run.variables else run.attrs.get("speed", 0.0)
    turns = float(np.abs(speeds).max() * (time[-1] - time[0])) / (2.0 * math.pi)
    return 1.0 if turns < 15 else 0.7 if turns < 60 else 0.45
