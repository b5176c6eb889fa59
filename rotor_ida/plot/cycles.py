"""Limit cycles of any rotor, over a parameter too."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.plot import legends, palette
from rotor_ida.plot.appearance import (
    circle,
    draw_marks,
    draw_ring,
    drawing,
    keep_resolved,
    new_figure,
    say_in_middle,
    style,
)
from rotor_ida.plot.datasets import (
    along_one,
    at_contact,
    at_node,
    check_dataset,
    contact_text,
    is_of_disc,
    one_value,
    rings_about,
    table_of,
    touching_nodes,
)
from rotor_ida.plot.labels import (
    LABELS,
    SEPARATOR,
    label_axis,
    label_parameter,
    title_of,
)
from rotor_ida.plot.legends import legend_below, shared_legend
from rotor_ida.plot.motion import draw_motion
from rotor_ida.results.checked_run import rotor_of
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import LINE_KIND, MODE, words_of
from rotor_ida.signals.path import Path

CYCLE = ("t", *COMPONENTS, "period", "response", "stability")
OF_SYSTEM = ("speed", "node", "contact_node", "contact_stator", "clearance", "centre_x", "centre_y")
MULTIPLIERS = ("period", "multiplier_real", "multiplier_imag")
LINES = ("omega", "period", "frequency", "whirl_amplitude", "line_kind")
# Most nodes of a rotor system in one figure of a cycle, and what its known multiplier is.
MOST_NODES, SHIFT = 3, "1, of a shift"
# Lines of a spectrum are shown down to this fraction of the strongest.
FLOOR = 1e-5
# While the disc rolls, its slip over the speed of the rim is below this.
ROLLS = 1e-9
# How the kinds of lines are drawn.
LINE_LOOKS = {
    "backward": ("backward whirl", palette.ORANGE, "v"),
    "forward": ("forward whirl", palette.BLUE, "^"),
    "spin": ("spin speed", palette.INK, "o"),
    "static": ("static", palette.GREY, "s"),
}
Mask = npt.NDArray[np.bool_]
# Room beside the first and the last point, over the distance between them.
ROOM = 0.04
CYCLES = ("status", "period", "stability", "radius_min", "radius_max")


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
    ['$\\operatorname{Im}\\,\\mu$', 'whirl amplitude, zero to peak $|c|$']
    """
    cycle = check_dataset("cycle", cycle, CYCLE, OF_SYSTEM)
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
    own = at_node(check_dataset("cycle", cycle, CYCLE, OF_SYSTEM), node)
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
            ax.plot(path.x, path.y, color=palette.BLUE, lw=1.2, label="orbit")
        for name, marker, face, entry in (
            ("entry", "^", palette.RED, True),
            ("exit", "v", "white", False),
        ):
            here = crossings[path.in_contact[crossings] == entry]
            if here.size:
                draw_marks(ax, path.x[here], path.y[here], marker, palette.RED, size=4.5, face=face,
                           edge=0.8, label=name, level=3.0)  # fmt: skip
        _draw_arrow(ax, path)
        ax.set_aspect("equal", adjustable="datalim")
        ax.autoscale_view()
        stable = words_of(own["stability"])[0] == "stable"
        ax.set_title(SEPARATOR.join([title_of("cycle", own), *["unstable"] * (not stable)]))
        legend_below(ax, columns=3 if path.mode is None else 2)
    return ax


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
    real, imag = (table_of("cycle", cycle, name, ["multiplier"]).values for name in MULTIPLIERS[1:])
    multipliers = real + 1j * imag
    q, known, words, rest = _known_of(cycle)
    others, along = _parted(multipliers, known)
    circles: list[tuple[float, Any, str]] = [(1.0, "-", "_")]
    if q is not None:
        circles.append((math.sqrt(q), palette.DASHES, rf"$\sqrt{{q}} = {math.sqrt(q):.4g}$"))
    with drawing(ax, width=4.0, height=3.6) as ax:
        for radius, dashes, label in circles:
            ax.plot(*circle(radius), color=palette.GREY, lw=0.9, ls=dashes, label=label, zorder=2.0)
        for points, face, label in ((along, "white", words), (others, palette.BLUE, rest)):
            if points.size:
                draw_marks(ax, points.real, points.imag, "o", palette.BLUE, size=5.0, face=face,
                           edge=1.1, label=label, level=3.0)  # fmt: skip
        ax.set_xlabel(LABELS["multiplier_real"])
        ax.set_ylabel(LABELS["multiplier_imag"])
        ax.margins(0.08)
        ax.set_aspect("equal", adjustable="datalim")
        ax.autoscale_view()
        legend_below(ax)
    return ax


def _known_of(cycle: xr.Dataset) -> tuple[float | None, list[float], str, str]:
    """Return q, if there are pairs of that product, the multipliers known, and words for both."""
    if not is_of_disc(cycle):
        return None, [1.0] if cycle.attrs.get("axes") == "turning" else [], SHIFT, "others"
    damped, rubs, loaded = (
        name in cycle.coords and one_value("cycle", cycle, name) > 0.0
        for name in ("contact_damping", "friction", "load")
    )
    if damped or rubs:
        return None, [] if loaded else [1.0], SHIFT, "others"
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
    highest = float(height.max())
    omega = one_value("cycle", cycle, "omega") * scale_of(cycle, "rate")
    ratio, shown = cycle["frequency"].values / omega, height >= FLOOR * highest
    with drawing(ax) as ax:
        ax.set_yscale("log")
        ax.set_xlabel(LABELS["frequency_over_omega"])
        label_axis(ax.yaxis, "whirl_amplitude", cycle["whirl_amplitude"])
        for kind, (words, colour, marker) in LINE_LOOKS.items():
            here = shown & (kinds == LINE_KIND[kind])
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
    time, x, y = map(with_crossings, (time, x, y))
    return Path(time, x, y, inside, mode=mode), crossings


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
    ax.annotate(
        "", (path.x[place + 1], path.y[place + 1]), (path.x[place], path.y[place]), zorder=3.0,
        arrowprops={"arrowstyle": "-|>", "color": palette.INK, "shrinkA": 0.0, "shrinkB": 0.0},
    )  # fmt: skip


def _parted(
    multipliers: ComplexValues, known: Sequence[float]
) -> tuple[ComplexValues, ComplexValues]:
    """Return the two multipliers that decide stability, and those of a shift along the cycle."""
    rest = list(multipliers)
    along = [rest.pop(int(np.argmin(np.abs(np.array(rest) - value)))) for value in known]
    return np.array(rest), np.array(along)


def cycles_figure(cycles: xr.Dataset) -> Figure:
    r"""Draw the period and the radii of limit cycles over the one parameter that varies.

    Radii lie between two lines, at each contact of a rotor system. A mark is filled where the cycle
    is stable. Where there is no cycle there is a gap.

    Parameters
    ----------
    cycles : Dataset
        Result of `rotor_ida.limit_cycle` in which one parameter varies.

    Raises
    ------
    InputError
        If the dataset is of another kind, or several parameters vary.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> cycles = limit_cycle(Rotor(omega=2.0, zeta=0.07, delta0=2.0), omega=[1.9, 2.0])
    >>> [ax.get_ylabel() for ax in cycles_figure(cycles).axes]
    ['period $T$', 'radius $|z|$']
    """
    cycles = check_dataset("cycles", cycles, CYCLES)
    part, over = along_one("cycles", cycles)
    part = part.sortby(over)
    is_stable = np.array(words_of(part["stability"])) == "stable"
    with style():
        figure = new_figure(5.0, 5.0)
        upper, lower = figure.subplots(2, 1, sharex=True)
        places = label_parameter(lower.xaxis, over, part)
        _draw(upper, places, part["period"].values, is_stable, palette.INK)
        label_axis(upper.yaxis, "period", part["period"])
        for number in range(part.sizes.get("contact", 1)):
            own = at_contact(part, number)
            colour, _ = palette.look(number + 1)
            low, high = own["radius_min"].values, own["radius_max"].values
            words = "_" if is_of_disc(part) else contact_text(own, number)
            lower.fill_between(places, low, high, color=colour, alpha=0.15, lw=0.0,
                               label=words)  # fmt: skip
            for radii in (low, high):
                _draw(lower, places, radii, is_stable, colour)
        label_axis(lower.yaxis, "radius", part["radius_max"])
        keep_resolved(upper)
        first, last = places[[0, -1]].tolist()
        if first < last:  # points without a cycle too
            lower.set_xlim(first - ROOM * (last - first), last + ROOM * (last - first))
        if not np.isfinite(part["period"].values).any():
            say_in_middle(upper, "no limit cycle")
        else:
            shared_legend(figure, [upper, lower], outer=True)
    return figure


def _draw(ax: Axes, across: Values, up: Values, is_stable: Mask, colour: str) -> None:
    """Draw a number of the cycles, with marks that show their stability."""
    ax.plot(across, up, color=colour, lw=0.9)
    for here, face, label in (
        (is_stable, "", legends.STABLE_CYCLE),
        (~is_stable, "white", legends.UNSTABLE_CYCLE),
    ):
        if np.isfinite(up[here]).any():
            draw_marks(ax, across[here], up[here], "o", colour, size=3.6, face=face, label=label)
