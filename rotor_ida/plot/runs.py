"""One run: its motion, its contacts, its orbit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from rotor_ida.parameters import PARAMETERS
from rotor_ida.plot.appearance import (
    BLUE,
    INK,
    RED,
    SHADE,
    axes_or_new,
    check_dataset,
    legend_below,
    one_value,
    shared_legend,
    style,
)
from rotor_ida.plot.labels import parameter_text
from rotor_ida.plot.paths import Path, path_of
from rotor_ida.plot.units import label_of, scale_of, suited, unit_of
from rotor_ida.schema import flags_of

Values = npt.NDArray[np.float64]

NEEDED = (*PARAMETERS, "t", "x", "y", "vx", "vy", "starts_in_contact", "event_time",
          "event_kind", "event_x", "event_y", "event_vx", "event_vy", "entry_time",
          "exit_time")  # fmt: skip
# Above these numbers of events their marks get smaller, and then are left out: they would hide
# the motion, and the colours of contact and flight say the same.
FEW_EVENTS, MANY_EVENTS = 40, 120
DASHES = (0, (4, 2))
# What decides the SI prefixes of a run.
SIZED_BY = ("t", "x", "y", "peak_force")


def plot_run(run: xr.Dataset, *, units: Mapping[str, str] | None = None) -> Figure:
    """Draw one run: displacements, radius, contact forces and orbit.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.simulate` returned.
    units : mapping of str to str, optional
        Units for a dataset of `rotor_ida.dimensional`, such as ``{"length": "mm"}``; by default
        those with the SI prefix that suits.

    Returns
    -------
    Figure
        The figure. Its axes are x, y, radius and peak force over time, and the orbit. Contact
        is shaded; entries and exits are marked while they are few enough to tell apart.

    Raises
    ------
    InputError
        If the dataset is no run.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> figure = plot_run(simulate(rotor, start=(0, 0, 0, 0), duration=20, samples=401))
    >>> [ax.get_ylabel() for ax in figure.axes][:2]
    ['displacement $x$', 'displacement $y$']
    """
    run = check_dataset("run", run, (*NEEDED, "peak_time", "peak_force"))
    run = suited(run, SIZED_BY, units=units)
    clearance = clearance_of(run)
    path = path_of(run)
    with style():
        layout = ConstrainedLayoutEngine(h_pad=0.03, hspace=0.0)
        figure = Figure(figsize=(7.2, 4.8), layout=layout)
        grid = figure.add_gridspec(4, 2, width_ratios=(1.0, 1.0))
        first = figure.add_subplot(grid[0, 0])
        history = [first] + [figure.add_subplot(grid[row, 0], sharex=first) for row in (1, 2, 3)]
        for ax, name, values in zip(
            history, ("x", "y", "radius"), (path.x, path.y, path.radius), strict=False
        ):
            _shade_contacts(ax, run)
            ax.plot(path.time, values, color=INK, lw=_line_width(run))
            ax.set_ylabel(_row_label(name, run["x"]))
            ax.tick_params(labelbottom=False)
        _mark_events_on_radius(history[2], run, clearance)
        _draw_forces(history[3], run)
        first.set_xlim(float(path.time[0]), float(path.time[-1]))
        history[3].set_xlabel(label_of("t", run["t"]))
        figure.align_ylabels(history)
        orbit = figure.add_subplot(grid[:, 1])
        _draw_orbit(orbit, run, path)
        shared_legend(figure, [history[2], orbit], columns=7, outer=False)
        figure.suptitle(_title(run), fontsize=10.0)
    return figure


def plot_orbit(
    run: xr.Dataset, *, units: Mapping[str, str] | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the orbit in the plane, with the ring of the clearance.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.simulate` returned.
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
    >>> ax = plot_orbit(simulate(rotor, start=(0, 0, 0, 0), duration=20, samples=401))
    >>> ax.get_xlabel()
    'displacement $x$'
    """
    run = suited(check_dataset("run", run, NEEDED), SIZED_BY, units=units, ax=ax)
    with style():
        ax = axes_or_new(ax, width=4.0, height=4.9)
        _draw_orbit(ax, run, path_of(run))
        legend_below(ax)
        ax.set_title(_title(run))
    return ax


def plot_rotating_orbit(
    run: xr.Dataset, *, units: Mapping[str, str] | None = None, ax: Axes | None = None
) -> Axes:
    r"""Draw the orbit as seen on axes that turn with the unbalance, with the ring.

    A synchronous whirl is a point there; what is left moving is what the response curve of one
    harmonic cannot show.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.simulate` or `rotor_ida.rotating` returned.
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
    >>> ax = plot_rotating_orbit(simulate(rotor, start=(0, 0, 0, 0), duration=20, samples=401))
    >>> ax.get_ylabel()
    'across it $\\operatorname{Im}\\,z\\,e^{-i\\omega t}$'
    """
    run = suited(check_dataset("run", run, NEEDED), SIZED_BY, units=units, ax=ax)
    omega = one_value("run", run, "omega") / scale_of(run, "time")
    path = path_of(run)
    x, y = _turned_back(path.x, path.y, omega * path.time)
    angle = omega * run["event_time"].values
    event_x, event_y = _turned_back(run["event_x"].values, run["event_y"].values, angle)
    seen = run.assign(event_x=("event", event_x), event_y=("event", event_y))
    with style():
        ax = axes_or_new(ax, width=4.0, height=4.9)
        _draw_orbit(ax, seen, replace(path, x=x, y=y))
        ax.set_xlabel(label_of("rotating_x", run["x"]))
        ax.set_ylabel(label_of("rotating_y", run["y"]))
        legend_below(ax)
        ax.set_title(_title(run))
    return ax


def _turned_back(x: Values, y: Values, angle: Values) -> tuple[Values, Values]:
    turned = (x + 1j * y) * np.exp(-1j * angle)
    return turned.real, turned.imag


def clearance_of(run: xr.Dataset) -> float:
    """Return the clearance in the units of the lengths of a run."""
    return one_value("run", run, "delta0") * scale_of(run, "length")


def _contacts(run: xr.Dataset) -> list[tuple[float, float]]:
    """Return begin and length of each contact, as far as the run shows it."""
    first, last = float(run["t"].values[0]), float(run["t"].values[-1])
    entries = np.nan_to_num(run["entry_time"].values, nan=first)
    exits = np.nan_to_num(run["exit_time"].values, nan=last)
    return [(float(a), float(b - a)) for a, b in zip(entries, exits, strict=True)]


def _shade_contacts(ax: Axes, run: xr.Dataset) -> None:
    ax.grid(visible=False, axis="x")
    spans = _contacts(run)
    if spans:
        ax.broken_barh(
            spans, (0.0, 1.0), transform=ax.get_xaxis_transform(), facecolor=SHADE,
            linewidth=0.0, zorder=0.5, label="in contact",
        )  # fmt: skip


def _mark_events_on_radius(ax: Axes, run: xr.Dataset, clearance: float) -> None:
    ax.axhline(clearance, color=INK, lw=0.7, ls=DASHES, zorder=2.6)
    ax.set_ylim(bottom=0.0)
    if run.sizes["event"] > MANY_EVENTS:
        return
    for times, marker, face, label in _events(run):
        if not times.size:
            continue
        ax.plot(
            times, np.full(times.shape, clearance), ls="", marker=marker, ms=_mark_size(run),
            mec=RED, mfc=face, mew=0.7, label=label, zorder=3.0,
        )  # fmt: skip


def _events(run: xr.Dataset) -> list[tuple[Values, str, str, str]]:
    """Return times, mark, filling and name of the entries and of the exits."""
    flags, kinds = flags_of(run["event_kind"]), run["event_kind"].values
    times = run["event_time"].values
    looks = (("entry", "^", RED), ("exit", "v", "white"))
    return [(times[kinds == flags[name]], marker, face, name) for name, marker, face in looks]


def _row_label(name: str, variable: xr.DataArray) -> str:
    """Return the label of a low panel: with a unit, name and symbol do not fit both."""
    label = label_of(name, variable)
    return label.partition(" ")[2] if unit_of(variable) else label


def _draw_forces(ax: Axes, run: xr.Dataset) -> None:
    _shade_contacts(ax, run)
    # where the run ends inside a contact while the force grows, its peak has not been seen
    seen = run["peak_time"].values < float(run["t"].values[-1])
    times, forces = run["peak_time"].values[seen], run["peak_force"].values[seen]
    ax.vlines(times, 0.0, forces, color=RED, lw=0.8)
    ax.plot(times, forces, ls="", marker="o", ms=max(2.0, 0.7 * _mark_size(run)), color=RED)
    ax.set_ylim(0.0, 1.12 * float(forces.max(initial=0.0)) or 1.0)
    ax.set_ylabel(_row_label("peak_force", run["peak_force"]))
    if not times.size:
        ax.text(0.5, 0.5, "no contact", transform=ax.transAxes, ha="center", va="center")


def _draw_orbit(ax: Axes, run: xr.Dataset, path: Path) -> None:
    clearance = clearance_of(run)
    if clearance > 0.0:
        turn = np.linspace(0.0, 2.0 * math.pi, 361)
        ax.plot(clearance * np.cos(turn), clearance * np.sin(turn), color=INK, lw=0.9, ls=DASHES,
                label="clearance", zorder=2.6)  # fmt: skip
    width = _line_width(run)
    flight = ~path.in_contact
    if flight.any():
        ax.plot(*path.stretches(flight), color=BLUE, lw=width, label="flight", zorder=2.0)
    if path.in_contact.any():
        ax.plot(*path.stretches(path.in_contact), color=RED, lw=1.2 * width, label="contact",
                zorder=2.1)  # fmt: skip
    kinds, flags = run["event_kind"].values, flags_of(run["event_kind"])
    if kinds.size <= MANY_EVENTS:
        for name, marker, face in (("entry", "^", RED), ("exit", "v", "white")):
            of_kind = kinds == flags[name]
            if of_kind.any():
                ax.plot(
                    run["event_x"].values[of_kind], run["event_y"].values[of_kind], ls="",
                    marker=marker, ms=_mark_size(run), mec=RED, mfc=face, mew=0.7, label=name,
                    zorder=3.0,
                )  # fmt: skip
    ax.plot(path.x[0], path.y[0], ls="", marker="s", ms=4.5, color=INK, label="start", zorder=3.1)
    ax.set_xlabel(label_of("x", run["x"]))
    ax.set_ylabel(label_of("y", run["y"]))
    ax.set_aspect("equal", adjustable="datalim")
    ax.autoscale_view()


def _line_width(run: xr.Dataset) -> float:
    revolutions = _duration(run) * max(1.0, one_value("run", run, "omega")) / (2.0 * math.pi)
    return 1.1 if revolutions < 15 else 0.7 if revolutions < 60 else 0.45


def _mark_size(run: xr.Dataset) -> float:
    return 4.0 if run.sizes["event"] <= FEW_EVENTS else 2.2


def _duration(run: xr.Dataset) -> float:
    return float(run["t"].values[-1] - run["t"].values[0]) / scale_of(run, "time")


def _title(run: xr.Dataset) -> str:
    return parameter_text(**{name: one_value("run", run, name) for name in PARAMETERS})
