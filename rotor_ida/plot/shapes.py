"""Deflected shapes of rotor systems: at an instant of a run, and of synchronous whirls."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.arrays import Values
from rotor_ida.checks import check_real
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    BLUE,
    GREY,
    INK,
    RED,
    draw_marks,
    drawing,
    legend_below,
    new_figure,
    shared_legend,
    style,
)
from rotor_ida.plot.datasets import check_dataset
from rotor_ida.plot.labels import SEPARATOR, label_axis, speed_text, title_of, unit_of
from rotor_ida.plot.motion import checked_run
from rotor_ida.plot.responses import LINES
from rotor_ida.results.run import check_system_run, nodes_in
from rotor_ida.schema import MODE, flags_of
from rotor_ida.texts import in_figure
from rotor_ida.units import number

WHIRLS = ("speed", "amplitude", "node_amplitude", "stability", "in_contact", "clearance", "node",
          "node_phase_lag", "contact_stator")  # fmt: skip
# Along an axis: the most names of nodes, and the most characters that are not turned.
MOST_NAMES, MOST_CHARACTERS = 40, 60
# Between two clearances at one node, of the length of the axis.
BESIDE = 0.01
WIDTH = 7.2
Indices = npt.NDArray[np.intp]


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
    run = checked_run(check_system_run(run))
    now = run.isel(t=_sample_at(run, t))
    with style():
        figure = new_figure(WIDTH, 4.4)
        axes = figure.subplots(2, 1, sharex=True)
        across = _label_nodes(axes[1], run)
        for ax, name in zip(axes, ("x", "y"), strict=True):
            _draw_shape(ax, now, name, across)
        figure.align_ylabels(axes)
        shared_legend(figure, axes, outer=False)
        at = f"$t$ {number(float(now['t']), 6)} {unit_of(run['t'])}".rstrip()
        figure.suptitle(SEPARATOR.join([title_of("run", run), at]), fontsize=10.0)
    return figure


def plot_whirl_shapes(
    whirls: xr.Dataset, *, speed: float | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the deflected shape of every synchronous whirl at a speed.

    Parameters
    ----------
    whirls : Dataset
        Result of `rotor_ida.synchronous_response` for a rotor system.
    speed : float, optional
        The speed, in the unit of the dataset; the nearest one is drawn. Default: where a node is
        farthest from its place of rest.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is of another kind, or the speed is outside its speeds.

    Notes
    -----
    The displacement of each node is that along the direction of the node that moves most. Bars are
    the clearances of stators that stand still.

    Examples
    --------
    >>> from rotor_ida import Rotor, synchronous_response
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> whirls = synchronous_response(system, speed=[0.5, 1.0, 1.5])
    >>> plot_whirl_shapes(whirls, speed=1.5).get_title()
    'speed 1.5'
    """
    whirls = check_dataset("whirls", whirls, WHIRLS)
    here = whirls.isel(speed=_row_at(whirls, speed))
    flags = flags_of(whirls["stability"])
    with drawing(ax) as ax:
        places = _label_nodes(ax, here)
        order = np.argsort(places, kind="stable")
        label_axis(ax.yaxis, "displacement", here["node_amplitude"])
        ax.axhline(0.0, color=GREY, lw=0.7)
        fixed = here.isel(contact=here["contact_stator"].values == "")
        _draw_rooms(ax, fixed, places, np.zeros(fixed.sizes["contact"]))
        for word, (label, dashes, _, colour) in LINES.items():
            for branch in np.flatnonzero(here["stability"].values == flags[word]):
                own = here.isel(branch=branch)
                moved = own["node_amplitude"].values * np.exp(-1j * own["node_phase_lag"].values)
                turn = moved[np.argmax(np.abs(moved))]
                up = (moved * turn.conjugate()).real / max(abs(turn), 1e-300)
                ax.plot(places[order], up[order], color=colour, ls=dashes, marker="o", ms=2.6,
                        label=label, zorder=3.0)  # fmt: skip
        ax.set_title(speed_text(here["speed"]))
        legend_below(ax, columns=4)
    return ax


def _row_at(whirls: xr.Dataset, speed: object) -> int:
    """Return the number of the speed nearest to one; default: of the largest amplitude."""
    speeds = whirls["speed"].values
    if speed is None:
        sizes = np.nan_to_num(whirls["node_amplitude"].values, nan=-1.0)
        return int(np.argmax(sizes.max(axis=(1, 2), initial=-1.0)))
    wanted = check_real("speed", speed)
    if not speeds.min() <= wanted <= speeds.max():
        ends = f"{speeds.min():g} to {speeds.max():g}"
        raise InputError(f"speed must lie from {ends}, got {wanted!r}")
    return int(np.argmin(np.abs(speeds - wanted)))


def _draw_shape(ax: Axes, now: xr.Dataset, name: str, across: Values) -> None:
    """Draw one displacement of all nodes at an instant, with the room in the stators."""
    up, nodes = now[name].values, nodes_in(now)
    now = now.isel(contact=np.isin(now["contact_node"].values, nodes))
    order = np.argsort(across, kind="stable")
    ax.axhline(0.0, color=GREY, lw=0.7)
    ax.plot(across[order], up[order], color=BLUE, marker="o", ms=3.2, label="shaft", zorder=2.8)
    places = _places_of_contacts(now)
    if places.size:
        _draw_rooms(ax, now, across, up[places] - now[f"contact_{name}"].values)
    touching = places[now["mode"].values != MODE["flight"]]
    if touching.size:
        draw_marks(ax, across[touching], up[touching], "o", RED, size=5.5, label="in contact",
                   level=3.0)  # fmt: skip
    label_axis(ax.yaxis, name, now[name])


def _draw_rooms(ax: Axes, now: xr.Dataset, across: Values, centres: Values) -> None:
    """Draw the clearances of contacts about their centres, those of one node side by side."""
    places = _places_of_contacts(now)
    if places.size:
        shared = np.array([(places[:k] == place).sum() for k, place in enumerate(places)])
        aside = BESIDE * float(np.ptp(across)) * shared
        ax.errorbar(across[places] + aside, centres, now["clearance"].values, fmt="none",
                    ecolor=INK, elinewidth=0.8, capsize=3.5, label="clearance")  # fmt: skip


def _places_of_contacts(now: xr.Dataset) -> Indices:
    """Return the number of the node of each contact."""
    nodes = nodes_in(now)
    return np.array([nodes.index(str(each)) for each in now["contact_node"].values], dtype=np.intp)


def _label_nodes(ax: Axes, dataset: xr.Dataset) -> Values:
    """Label an axis along the shaft, and return the positions of the nodes on it.

    Without positions these are the numbers of the nodes, whose names are turned or not all written
    if there are many.
    """
    if "axial_position" in dataset.variables:
        label_axis(ax.xaxis, "axial_position", dataset["axial_position"])
        return np.asarray(dataset["axial_position"].values)
    names = nodes_in(dataset)
    step = math.ceil(len(names) / MOST_NAMES)
    drawn = list(map(in_figure, names[::step]))
    turned = sum(map(len, drawn)) + 2 * len(drawn) > MOST_CHARACTERS
    ax.set_xticks(range(0, len(names), step), drawn, rotation=90 if turned else 0)
    ax.set_xlim(-0.5, len(names) - 0.5)
    ax.set_xlabel("node")
    return np.arange(float(len(names)))


def _sample_at(run: xr.Dataset, t: object) -> int:
    """Return the number of the sample nearest to a time; default: of the largest deflection."""
    times = run["t"].values
    if t is None:
        return int(np.argmax(np.hypot(run["x"].values, run["y"].values).max(axis=1, initial=0.0)))
    time = check_real("t", t)
    if not times[0] <= time <= times[-1]:
        raise InputError(f"t must lie from {times[0]:g} to {times[-1]:g}, got {time!r}")
    return int(np.argmin(np.abs(times - time)))
