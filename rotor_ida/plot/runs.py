"""Plots of one run: its motion over time, its orbit and its events."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import Stroke

from rotor_ida.arrays import Values
from rotor_ida.checks import check_choice
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.plot.appearance import (
    BLUE,
    DARK_BROWN,
    DASHES,
    INK,
    PURPLE,
    RED,
    SettledLayout,
    draw_marks,
    draw_ring,
    drawing,
    finish_solid,
    legend_below,
    new_figure,
    say_in_middle,
    shared_legend,
    solid_drawing,
    style,
)
from rotor_ida.plot.datasets import check_dataset, clearance_of, one_value
from rotor_ida.plot.decimation import draw_path
from rotor_ida.plot.forces import PEAK, peaks_of, peaks_on, shade_contacts
from rotor_ida.plot.labels import label_axis, label_of, title_of, unit_of
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import MODE, flags_of
from rotor_ida.signals.path import Path, force_along, largest_speed, path_of, rotated_back

NEEDED = (*PARAMETERS, "t", "x", "y", "vx", "vy", "starts_in_contact", "event_time",
          "event_kind", "event_x", "event_y", "event_vx", "event_vy", "entry_time",
          "exit_time")  # fmt: skip
WITH_PEAKS = (*NEEDED, "peak_time", "peak_force")
HISTORIES = ("x", "y", "radius")
# Above these numbers of events their marks get smaller, and then are left out: they would hide
# the motion, and the colours of contact and flight show the same.
FEW_EVENTS, MANY_EVENTS = 40, 120
# An orbit of more points is thinned.
DENSE = 200_000
# Events: the mark of each, its colour, and whether it is filled.
MARKS = {
    "entry": ("^", RED, True),
    "exit": ("v", RED, False),
    "roll": ("o", DARK_BROWN, True),
    "slip": ("o", DARK_BROWN, False),
    "reverse": ("x", PURPLE, True),
    "press": ("s", INK, True),
    "release": ("s", INK, False),
}
# With friction each kind of motion has a colour, a line and a width. Flight counts as slip, at no
# normal force.
WAYS: tuple[tuple[tuple[str, ...], str, str, object, float], ...] = (
    (("flight",), "flight", BLUE, "-", 1.0),
    (("slipping_forward", "loose"), "slips forwards", RED, "-", 1.2),
    (("slipping_backward",), "slips backwards", PURPLE, (0, (1.2, 0.7)), 1.7),
    (("rolling",), "rolls", DARK_BROWN, "-", 3.0),
)
# Rolling is a double line, so that it differs from the others without colour too.
CORE = "#f3e9e4"


def plot_run(run: xr.Dataset) -> Figure:
    """Draw one run: displacements, radius, contact forces and orbit.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.simulate`.

    Returns
    -------
    Figure
        The figure. Its axes are x, y, radius and peak force over time, and the orbit. Contact
        is shaded, paler where contacts are too close to tell apart. Events are marked unless they
        are too many. With friction the figure adds the slip speed, shows the normal force over
        time, and colours orbit and radius by forward slip, backward slip and rolling.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> figure = plot_run(simulate(rotor, start=(0, 0, 0, 0), duration=20, samples=401))
    >>> [ax.get_ylabel() for ax in figure.axes][:2]
    ['displacement $x$', 'displacement $y$']
    """
    run = check_dataset("run", run, WITH_PEAKS)
    path, rubs = path_of(run), "mode" in run.variables
    rows = 5 if rubs else 4
    with style():
        layout = SettledLayout(h_pad=0.03, hspace=0.0)
        figure = new_figure(7.2, 1.2 * rows, layout=layout)
        grid = figure.add_gridspec(rows, 2, width_ratios=(1.0, 1.0))
        first = figure.add_subplot(grid[0, 0])
        history = [first]
        history += [figure.add_subplot(grid[row, 0], sharex=first) for row in range(1, rows)]
        for ax in history:
            ax.grid(visible=False, axis="x")
            shade_contacts(ax, run)
        _draw_histories(history, run, path)
        _draw_forces(history[3], run)
        if rubs:
            _draw_slip(history[4], run)
        first.set_xlim(float(path.time[0]), float(path.time[-1]))
        for ax in history[:-1]:
            ax.tick_params(labelbottom=False)
        history[-1].set_xlabel(label_of("t", run["t"]))
        figure.align_ylabels(history)
        orbit = figure.add_subplot(grid[:, 1])
        orbit.set(xlabel=label_of("x", run["x"]), ylabel=label_of("y", run["y"]))
        draw_orbit(orbit, run, path)
        shared_legend(figure, [history[2], orbit], columns=7, outer=False)
        figure.suptitle(title_of("run", run), fontsize=10.0)
    return figure


def plot_rotating_orbit(run: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    r"""Draw the orbit on axes that rotate with the unbalance, with the stator.

    A synchronous whirl is a point there. Any remaining motion is what a one-harmonic response curve
    cannot show.

    Parameters
    ----------
    run, ax
        As for `plot_orbit`; a result of `rotor_ida.rotating` also works.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> ax = plot_rotating_orbit(simulate(rotor, start=(0, 0, 0, 0), duration=20, samples=401))
    >>> ax.get_ylabel()
    'across it $\\operatorname{Im}\\,z\\,e^{-i\\omega t}$'
    """
    run = check_dataset("run", run, NEEDED)
    if "speed" in run.variables:
        raise InputError("run must be at one speed for axes that turn, got a run of run_up")
    omega = one_value("run", run, "omega") / scale_of(run, "time")
    path = path_of(run)
    x, y = rotated_back(path.x, path.y, omega * path.time)
    angle = omega * run["event_time"].values
    event_x, event_y = rotated_back(run["event_x"].values, run["event_y"].values, angle)
    turned = run.assign(event_x=("event", event_x), event_y=("event", event_y))
    with drawing(ax, width=4.0, height=4.9) as ax:
        label_axis(ax.xaxis, "rotating_x", run["x"])
        label_axis(ax.yaxis, "rotating_y", run["y"])
        draw_orbit(ax, turned, replace(path, x=x, y=y))
        legend_below(ax)
        ax.set_title(title_of("run", run))
    return ax


def plot_history(run: xr.Dataset, name: str, *, ax: Axes | None = None) -> Axes:
    """Draw a displacement or the radius over time, with contact and flight in colour.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.simulate`.
    name : {"x", "y", "radius"}
        Quantity to draw.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> plot_history(simulate(rotor, start=(0, 0, 0, 0), duration=20), "x").get_ylabel()
    'displacement $x$'
    """
    run = check_dataset("run", run, NEEDED)
    check_choice("name", name, HISTORIES)
    path = path_of(run)
    with drawing(ax, width=7.0, height=2.4) as ax:
        label_axis(ax.xaxis, "t", run["t"])
        label_axis(ax.yaxis, name, run["x"])
        draw_motion(ax, path, path.time, getattr(path, name), width=0.9)
        ax.set_xlim(float(path.time[0]), float(path.time[-1]))
    return ax


def plot_drawn_out(run: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the orbit over time in three dimensions, with contact and flight in colour.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.simulate`.
    ax : Axes, optional
        Three-dimensional axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> plot_drawn_out(simulate(rotor, start=(0, 0, 0, 0), duration=20)).get_xlabel()
    'time $t$'
    """
    run = check_dataset("run", run, NEEDED)
    path, alone = path_of(run), ax is None
    with solid_drawing(ax) as solid:
        draw_motion(solid, path, path.time, path.x, path.y, width=0.7)
        label_axis(solid.xaxis, "t", run["t"])
        label_axis(solid.yaxis, "x_alone", run["x"])
        label_axis(solid.zaxis, "y_alone", run["y"])
        solid.xaxis.labelpad, solid.yaxis.labelpad, solid.zaxis.labelpad = -4, -6, -6
        solid.view_init(elev=22, azim=-58)
        finish_solid(solid, zoom=1.0 if alone else 1.12)
    return cast(Axes, solid)


def plot_machine(run: xr.Dataset) -> Figure:
    """Draw a run in SI units: orbit, distance from the bearing axis, and contact force.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.dimensional` for a run.

    Returns
    -------
    Figure
        The figure: the orbit, the radius over time with the stator, and the contact force with
        the peak of each contact.

    Examples
    --------
    >>> from rotor_ida import DimensionalRotor, dimensional, simulate
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> run = dimensional(simulate(machine.rotor(), start=(0, 0, 0, 0), duration=40.0), machine)
    >>> [ax.get_ylabel() for ax in plot_machine(run).axes][2]
    'contact force $F$ [N]'
    """
    run = check_dataset("run", run, WITH_PEAKS)
    if "length_scale" not in run.attrs:
        raise InputError("run must be in SI units: rotor_ida.dimensional makes it so")
    ring, path = clearance_of(run), path_of(run)
    with style():
        figure = new_figure(7.2, 3.9)
        grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.25))
        orbit, history = figure.add_subplot(grid[:, 0]), figure.add_subplot(grid[0, 1])
        force = figure.add_subplot(grid[1, 1], sharex=history)
        draw_motion(orbit, path, path.x, path.y, width=0.8)
        draw_ring(orbit, ring)
        orbit.set_aspect("equal", adjustable="datalim")
        orbit.set(xlabel=label_of("x", run["x"]), ylabel=label_of("y", run["y"]))
        above = 1.12 if path.mode is None else 1.18
        orbit.legend(loc="upper center", bbox_to_anchor=(0.5, above), ncols=3, handlelength=1.6,
                     columnspacing=1.0)  # fmt: skip
        _draw_radius(history, path, ring, 0.8)
        history.tick_params(labelbottom=False)
        history.set(ylabel=label_of("radius", run["x"]))
        history.set_title(title_of("run", run))
        forces = force_along(run, path)
        force.plot(path.time, forces, color=RED, lw=0.8)
        draw_marks(force, *peaks_on(run, path.time, forces), "o", INK, size=2.4, label=PEAK)
        words = "contact_force" if path.mode is None else "normal_force"
        # room for the legend
        force.set(xlabel=label_of("t", run["t"]), ylim=(0.0, 1.25 * float(forces.max()) or 1.0),
                  ylabel=label_of(words, run["peak_force"]))  # fmt: skip
        force.set_xlim(float(path.time[0]), float(path.time[-1]))
        force.legend(loc="upper right")
    return figure


def draw_orbit(ax: Axes, run: xr.Dataset, path: Path) -> None:
    """Draw the orbit of a run along a path, with the stator, the events and the start."""
    draw_ring(ax, clearance_of(run))
    draw_motion(ax, path, path.x, path.y, width=_line_width(run), heavier=1.2)
    mark_events(ax, run, run["event_x"].values, run["event_y"].values)
    draw_marks(ax, path.x[0], path.y[0], "s", INK, size=4.5, label="start", level=3.1)
    ax.set_aspect("equal", adjustable="datalim")
    ax.autoscale_view()


def draw_motion(ax: Any, path: Path, *columns: Values, width: float, heavier: float = 1.0) -> None:
    """Draw flight and contact in colour, contact wider by a factor.

    With friction, forward slip, backward slip and rolling have separate styles.
    """
    if path.mode is not None:
        _draw_ways(ax, path, path.mode, columns, width)
        return
    for chosen, colour, lw, label in (
        (~path.in_contact, BLUE, width, "flight"),
        (path.in_contact, RED, heavier * width, "contact"),
    ):
        if not chosen[:-1].any():
            continue
        if path.time.size > DENSE and len(columns) == 2 and columns[0] is path.x:
            draw_path(ax, *path.stretches(chosen, *columns), colour=colour, width=lw, words=label)
            continue
        ax.plot(*path.stretches(chosen, *columns), color=colour, lw=lw, label=label)


def _draw_ways(
    ax: Any, path: Path, ways: npt.NDArray[np.int8], columns: Sequence[Values], width: float
) -> None:
    """Draw flight, slip and rolling."""
    for modes, label, colour, dashes, heavier in WAYS:
        chosen = np.isin(ways, [MODE[mode] for mode in modes])
        if not chosen[:-1].any():
            continue
        line: Any = {"color": colour, "lw": heavier * width, "ls": dashes, "label": label}
        if label == "rolls":
            line["solid_capstyle"] = "butt"
            line["path_effects"] = [Stroke(), Stroke(linewidth=width, foreground=CORE)]
        ax.plot(*path.stretches(chosen, *columns), **line)


def _draw_histories(history: Sequence[Axes], run: xr.Dataset, path: Path) -> None:
    """Draw displacements and radius over time, the latter with the events."""
    clearance, width = clearance_of(run), _line_width(run)
    history[0].plot(path.time, path.x, color=INK, lw=width)
    history[1].plot(path.time, path.y, color=INK, lw=width)
    _draw_radius(history[2], path, clearance, width)
    for ax, name in zip(history, HISTORIES, strict=False):
        ax.set_ylabel(_row_label(name, run["x"]))
    radius = np.hypot(run["event_x"].values, run["event_y"].values)
    on_ring = np.isin(run["event_kind"].values, (1, -1))
    mark_events(history[2], run, run["event_time"].values, np.where(on_ring, clearance, radius))


def _draw_radius(ax: Axes, path: Path, clearance: float, width: float) -> None:
    """Draw the radius over time, with friction in the colours of the motion, and the stator."""
    if path.mode is None:
        ax.plot(path.time, path.radius, color=INK, lw=width)
    else:
        draw_motion(ax, path, path.time, path.radius, width=width)
    ax.axhline(clearance, color=INK, lw=0.7, ls=DASHES, zorder=2.6)
    ax.set_ylim(bottom=0.0)


def mark_events(ax: Axes, run: xr.Dataset, across: Values, up: Values) -> None:
    """Mark events on the orbit, unless they are too many."""
    kinds, flags = run["event_kind"].values, flags_of(run["event_kind"])
    if kinds.size > MANY_EVENTS:
        return
    for name, (marker, colour, filled) in MARKS.items():
        of_kind = kinds == flags.get(name)
        if of_kind.any():
            draw_marks(
                ax, across[of_kind], up[of_kind], marker, colour, size=_mark_size(run),
                face="" if filled else "white", edge=0.7, label=name, level=3.0,
            )  # fmt: skip


def _row_label(name: str, variable: xr.DataArray) -> str:
    """Return the label of a low panel, where name, symbol and unit do not all fit."""
    label = label_of(name, variable)
    return label.partition(" ")[2] if unit_of(variable) else label


def _draw_forces(ax: Axes, run: xr.Dataset) -> None:
    """Draw the peaks of the contacts; with friction on the normal force over time."""
    times, forces = peaks_of(run)
    highest, name = float(forces.max(initial=0.0)), "peak_force"
    if "normal_force" in run.variables:
        normal, name = run["normal_force"].values, "normal_force"
        ax.plot(run["t"].values, normal, color=RED, lw=0.8)
        highest = max(highest, float(normal.max(initial=0.0)))
    else:
        ax.vlines(times, 0.0, forces, color=RED, lw=0.8)
    draw_marks(ax, times, forces, "o", RED, size=max(2.0, 0.7 * _mark_size(run)))
    ax.set_ylim(0.0, 1.12 * highest or 1.0)
    ax.set_ylabel(_row_label(name, run["peak_force"]))
    if not run.sizes["contact"]:
        say_in_middle(ax, "no contact")


def _draw_slip(ax: Axes, run: xr.Dataset) -> None:
    """Draw the slip speed over time, in contact."""
    slip = np.where(run["mode"].values == MODE["flight"], np.nan, run["slip_speed"].values)
    ax.axhline(0.0, color=INK, lw=0.7, ls=DASHES)
    ax.plot(run["t"].values, slip, color=INK, lw=_line_width(run))
    ax.set_ylabel(_row_label("slip_speed", run["slip_speed"]))


def _line_width(run: xr.Dataset) -> float:
    duration = float(run["t"].values[-1] - run["t"].values[0]) / scale_of(run, "time")
    revolutions = duration * max(1.0, largest_speed(run)) / (2.0 * math.pi)
    return 1.1 if revolutions < 15 else 0.7 if revolutions < 60 else 0.45


def _mark_size(run: xr.Dataset) -> float:
    return 4.0 if run.sizes["event"] <= FEW_EVENTS else 2.2
