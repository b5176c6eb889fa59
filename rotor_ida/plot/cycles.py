"""Limit cycles of any rotor: their orbit, multipliers and spectrum."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.plot.appearance import (
    BLUE,
    DASHES,
    GREY,
    INK,
    ORANGE,
    RED,
    circle,
    draw_marks,
    draw_ring,
    drawing,
    legend_below,
    new_figure,
    style,
)
from rotor_ida.plot.datasets import (
    at_node,
    check_dataset,
    is_of_disc,
    one_value,
    rings_about,
    touching_nodes,
)
from rotor_ida.plot.labels import LABELS, SEPARATOR, label_axis, speed_text, title_of
from rotor_ida.plot.motion import WAYS, draw_motion
from rotor_ida.results.run import rotor_of
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import MODE, flags_of, words_of
from rotor_ida.signals.path import Path

CYCLE = ("t", *COMPONENTS, "period", "response", "stability")
OF_SYSTEM = ("speed", "node", "contact_node", "contact_stator", "clearance", "centre_x", "centre_y")
MULTIPLIERS = ("period", "multiplier_real", "multiplier_imag")
MOST_NODES = 3
LINES = ("omega", "period", "frequency", "whirl_amplitude", "line_kind")
# Lines of a spectrum are shown down to this fraction of the strongest.
FLOOR = 1e-5
# While the disc rolls, its slip over the speed of the rim is below this.
ROLLS = 1e-9
# How the kinds of lines are drawn.
LINE_LOOKS = {
    "backward": ("backward whirl", ORANGE, "v"),
    "forward": ("forward whirl", BLUE, "^"),
    "spin": ("spin speed", INK, "o"),
    "static": ("static", GREY, "s"),
}


def cycle_figure(cycle: xr.Dataset, *, node: str | None = None) -> Figure:
    r"""Draw a limit cycle: its orbit, its multipliers and, of one disc, its spectrum.

    Parameters
    ----------
    cycle : Dataset
        Result of `rotor_ida.limit_cycle`, of any rotor.
    node : str, optional
        Name of a node of a rotor system; by default all that have contacts, at most three.

    Returns
    -------
    Figure
        The figure. Its axes are those of `plot_cycle`, `plot_multipliers` and `plot_lines`.

    Raises
    ------
    InputError
        If it contains no limit cycle, or there is no such node.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> figure = cycle_figure(limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5))
    >>> [ax.get_ylabel() for ax in figure.axes][1:]
    ['$\\operatorname{Im}\\,\\mu$', 'whirl amplitude $|c|$']
    """
    cycle = _checked(cycle)
    nodes = [node] if node or is_of_disc(cycle) else touching_nodes(cycle)[:MOST_NODES]
    rows = 1 + ("frequency" in cycle.variables)
    with style():
        figure = new_figure(3.9 + 3.3 * len(nodes), 5.4 if rows > 1 else 4.2)
        grid = figure.add_gridspec(rows, len(nodes) + 1, width_ratios=(*[1.15] * len(nodes), 1.0))
        orbits = [
            plot_cycle(cycle, node=each, ax=figure.add_subplot(grid[:, column]))
            for column, each in enumerate(nodes)
        ]
        plot_multipliers(cycle, ax=figure.add_subplot(grid[0, -1]))
        if rows > 1:
            plot_lines(cycle, ax=figure.add_subplot(grid[1, -1]))
        if is_of_disc(cycle):
            figure.suptitle(orbits[0].get_title(), fontsize=10.0)
            orbits[0].set_title("")
    return figure


def plot_cycle(cycle: xr.Dataset, *, node: str | None = None, ax: Axes | None = None) -> Axes:
    r"""Draw one period of a limit cycle, with the stator, on the axes on which it closes.

    These rotate with the unbalance, but for a rotor system that is not axisymmetric. An arrow shows
    the direction of motion. With friction, slip and rolling are distinguished as in `plot_run`. In
    a stator that moves or stands aside, or in several of one node, contact is not shown.

    Parameters
    ----------
    cycle : Dataset
        Result of `rotor_ida.limit_cycle`.
    node : str, optional
        Name of a node of a rotor system; by default that of the first contact.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If it contains no limit cycle, or there is no such node.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> ax = plot_cycle(limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5))
    >>> ax.get_xlabel()
    'along the unbalance $\\operatorname{Re}\\,z\\,e^{-i\\omega t}$'

    Of a rotor system at a node:

    >>> plot_cycle(limit_cycle(rotor.system(), speed=2.0), node="disc").get_title()
    'node disc,  speed 2'
    """
    own = at_node(_checked(cycle), node)
    rings = rings_about("cycle", own)
    alone = is_of_disc(own) or np.sum(own["contact_node"].values == own["node"].values) == 1
    path, crossings = _path_of(own, rings[0] if alone and rings else math.inf)
    turns = "rotating_" if own.attrs.get("axes", "turning") == "turning" else ""
    with drawing(ax, width=4.0, height=4.9) as ax:
        label_axis(ax.xaxis, f"{turns}x", own["x"])
        label_axis(ax.yaxis, f"{turns}y", own["y"])
        for ring in rings:
            draw_ring(ax, ring)
        if alone and rings:
            draw_motion(ax, path, path.x, path.y, width=1.2, heavier=1.3)
        else:
            ax.plot(path.x, path.y, color=BLUE, lw=1.2, label="orbit")
        for name, marker, face, entry in (("entry", "^", RED, True), ("exit", "v", "white", False)):
            here = crossings[path.in_contact[crossings] == entry]
            if here.size:
                draw_marks(ax, path.x[here], path.y[here], marker, RED, size=4.5, face=face,
                           edge=0.8, label=name, level=3.0)  # fmt: skip
        _draw_arrow(ax, path)
        ax.set_aspect("equal", adjustable="datalim")
        ax.autoscale_view()
        stable = words_of(own["stability"])[0] == "stable"
        ax.set_title(SEPARATOR.join([_title(own), *["unstable"] * (not stable)]))
        legend_below(ax, columns=3 if path.mode is None else 2)
    return ax


def _checked(cycle: object) -> xr.Dataset:
    """Return a limit cycle of any rotor in suitable units."""
    is_system = isinstance(cycle, xr.Dataset) and not is_of_disc(cycle)
    return check_dataset("cycle", cycle, (*(OF_SYSTEM if is_system else PARAMETERS), *CYCLE))


def _title(cycle: xr.Dataset) -> str:
    """Return the parameters of a disc, or node and speed of a system."""
    if is_of_disc(cycle):
        return title_of("cycle", cycle)
    return f"{title_of('cycle', cycle)}{SEPARATOR}{speed_text(cycle['speed'])}"


def plot_multipliers(cycle: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    r"""Draw the multipliers of a limit cycle, with the unit circle.

    Of one disc a shift along the cycle has the multiplier 1, with the partner ``q = exp(-2 zeta
    T)``. The other two have the product q: a pair on the dashed circle of radius ``sqrt(q)``, or
    real numbers. With contact damping or friction, and of a rotor system, only the 1 of a shift is
    known. Under a load none is known; without contact damping and friction there are then two pairs
    of product q. Nor is one of a system whose cycle closes on fixed axes.

    Parameters
    ----------
    cycle : Dataset
        Result of `rotor_ida.limit_cycle`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If it contains no limit cycle.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> ax = plot_multipliers(limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5))
    >>> ax.get_legend_handles_labels()[1][0]
    '$\\sqrt{q} = 0.7265$'
    """
    cycle = check_dataset("cycle", cycle, MULTIPLIERS)
    multipliers = cycle["multiplier_real"].values + 1j * cycle["multiplier_imag"].values
    q, known, words, rest = _known_of(cycle)
    others, along = _parted(multipliers, known)
    circles = [(1.0, "-", "_")]
    if q is not None:
        circles.append((math.sqrt(q), DASHES, rf"$\sqrt{{q}} = {math.sqrt(q):.4g}$"))
    with drawing(ax, width=4.0, height=3.6) as ax:
        for radius, dashes, label in circles:
            ax.plot(*circle(radius), color=GREY, lw=0.9, ls=dashes, label=label, zorder=2.0)
        for points, face, label in ((along, "white", words), (others, BLUE, rest)):
            if points.size:
                draw_marks(ax, points.real, points.imag, "o", BLUE, size=5.0, face=face, edge=1.1,
                           label=label, level=3.0)  # fmt: skip
        ax.set_xlabel(LABELS["multiplier_real"])
        ax.set_ylabel(LABELS["multiplier_imag"])
        ax.margins(0.08)
        ax.set_aspect("equal", adjustable="datalim")
        ax.autoscale_view()
        legend_below(ax)
    return ax


def _known_of(cycle: xr.Dataset) -> tuple[float | None, list[float], str, str]:
    """Return q, if there are pairs of that product, the multipliers known, and words for both."""
    shift, none = (None, [1.0], "1, of a shift", "others"), (None, [], "", "others")
    if not is_of_disc(cycle):
        return shift if cycle.attrs.get("axes") == "turning" else none
    damped, rubs, loaded = (
        name in cycle.coords and one_value("cycle", cycle, name) > 0.0
        for name in ("contact_damping", "friction", "load")
    )
    if damped or rubs:
        return none if loaded else shift
    period = one_value("cycle", cycle, "period") / scale_of(cycle, "time")
    q = math.exp(-2.0 * one_value("cycle", cycle, "zeta") * period)
    pair = r"$\mu$ and $q/\mu$"
    return (q, [], "", pair) if loaded else (q, [1.0, q], "1 and $q$", pair)


def plot_lines(cycle: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    r"""Draw the spectrum of a limit cycle on fixed axes: lines at the spin speed and about it.

    They lie ``2 pi/T`` apart, and are shown down to 1e-5 of the strongest, on a logarithmic scale.

    Parameters
    ----------
    cycle : Dataset
        Result of `rotor_ida.limit_cycle`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If it contains no limit cycle.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> ax = plot_lines(limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5))
    >>> ax.get_xlabel()
    'frequency over spin speed $\\Omega/\\omega$'
    """
    cycle = check_dataset("cycle", cycle, LINES)
    height, kinds = cycle["whirl_amplitude"].values, cycle["line_kind"].values
    flags = flags_of(cycle["line_kind"])
    highest = float(height.max())
    omega = one_value("cycle", cycle, "omega") * scale_of(cycle, "rate")
    ratio, shown = cycle["frequency"].values / omega, height >= FLOOR * highest
    with drawing(ax) as ax:
        ax.set_yscale("log")
        ax.set_xlabel(LABELS["frequency_over_omega"])
        label_axis(ax.yaxis, "whirl_amplitude", cycle["whirl_amplitude"])
        for kind, (words, colour, marker) in LINE_LOOKS.items():
            here = shown & (kinds == flags.get(kind))  # older archives have fewer
            if here.any():
                ax.vlines(ratio[here], 0.3 * FLOOR * highest, height[here], color=colour, lw=0.9)
                draw_marks(ax, ratio[here], height[here], marker, colour, size=3.4, label=words)
        ax.set_ylim(0.3 * FLOOR * highest, 3.0 * highest)
        legend_below(ax)
    return ax


def _path_of(cycle: xr.Dataset, ring: float) -> tuple[Path, npt.NDArray[np.intp]]:
    """Return one period as a path with its stator crossings, and their indices."""
    time, x, y = (cycle[name].values for name in ("t", "x", "y"))
    gap = np.hypot(x, y) - ring
    crosses = (gap[:-1] >= 0.0) != (gap[1:] >= 0.0)
    before = np.flatnonzero(crosses & (ring > 0.0))
    part = gap[before] / (gap[before] - gap[before + 1])
    after = before + 1

    def with_crossings(column: Values) -> Values:
        return np.insert(column, after, column[before] + part * (column[after] - column[before]))

    # a segment that begins on the stator belongs to the side that it enters
    inside = np.insert(gap >= 0.0, after, gap[after] >= 0.0)
    crossings = after + np.arange(after.size)
    slip = _slip_of(cycle) if ring < math.inf else None
    mode = None if slip is None else _modes(with_crossings(slip), inside)
    return Path(*map(with_crossings, (time, x, y)), inside, mode=mode), crossings


def _slip_of(cycle: xr.Dataset) -> Values | None:
    """Return the slip speed along a cycle over that of the rim; None without friction or a race."""
    if is_of_disc(cycle):
        rotor = rotor_of(cycle)
        friction, radius = rotor.friction, rotor.disc_radius or 0.0
        rim = radius * rotor.omega * scale_of(cycle, "velocity")
    else:
        touch = cycle.isel(contact=cycle["contact_node"].values == str(cycle["node"].values))
        friction, radius, race = (
            float(touch[name].values[0]) if name in touch else 0.0
            for name in ("law_friction", "law_radius", "race_radius")
        )
        friction = 0.0 if race > 0.0 else friction
        rim = radius * float(cycle["speed"])
    if not friction > 0.0 or not abs(rim) > 0.0:
        return None
    x, y, vx, vy = (cycle[name].values for name in COMPONENTS)
    return np.asarray(((x * vy - y * vx) / np.hypot(x, y) + rim) / abs(rim))


def _modes(slip: Values, inside: npt.NDArray[np.bool_]) -> npt.NDArray[np.int8]:
    """Return the mode of the stretch that begins at each point: a number of `MODE`."""
    end = np.append(slip[1:], slip[-1])
    modes = np.where(slip + end < 0.0, MODE["slipping_backward"], MODE["slipping_forward"])
    modes[np.maximum(abs(slip), abs(end)) < ROLLS] = MODE["rolling"]
    modes[~inside] = MODE["flight"]
    return modes.astype(np.int8)


def _draw_arrow(ax: Axes, path: Path) -> None:
    """Show the direction of motion, at the largest radius."""
    place = min(int(np.argmax(path.radius)), path.time.size - 2)
    colour = RED if path.in_contact[place] else BLUE
    if path.mode is not None:
        colour = next(
            shade for modes, _, shade, *_ in WAYS if path.mode[place] in {*map(MODE.get, modes)}
        )
    ax.annotate(
        "", (path.x[place + 1], path.y[place + 1]), (path.x[place], path.y[place]), zorder=3.0,
        arrowprops={"arrowstyle": "-|>", "color": colour, "shrinkA": 0.0, "shrinkB": 0.0},
    )  # fmt: skip


def _parted(
    multipliers: ComplexValues, known: Sequence[float]
) -> tuple[ComplexValues, ComplexValues]:
    """Return the two multipliers that decide stability, and those of a shift along the cycle."""
    rest = list(multipliers)
    along = [rest.pop(int(np.argmin(np.abs(np.array(rest) - value)))) for value in known]
    return np.array(rest), np.array(along)
