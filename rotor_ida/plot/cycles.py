"""Limit cycles: their orbit, multipliers and spectrum."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

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
from rotor_ida.plot.datasets import check_dataset, clearance_of, one_value
from rotor_ida.plot.labels import LABELS, label_axis, title_of
from rotor_ida.plot.motion import WAYS, draw_motion
from rotor_ida.results.run import rotor_of
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import MODE, flags_of
from rotor_ida.signals.path import Path

CYCLE = (*PARAMETERS, "t", *COMPONENTS, "period", "response")
MULTIPLIERS = (*PARAMETERS, "period", "multiplier_real", "multiplier_imag")
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


def cycle_figure(cycle: xr.Dataset) -> Figure:
    r"""Draw a limit cycle: its orbit, its multipliers and its spectrum.

    Parameters
    ----------
    cycle : Dataset
        Result of `rotor_ida.limit_cycle`.

    Returns
    -------
    Figure
        The figure. Its axes are those of `plot_cycle`, `plot_multipliers` and `plot_lines`.

    Raises
    ------
    InputError
        If it contains no limit cycle.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> figure = cycle_figure(limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5))
    >>> [ax.get_ylabel() for ax in figure.axes][1:]
    ['$\\operatorname{Im}\\,\\mu$', 'whirl amplitude, zero to peak $|c|$']
    """
    cycle = check_dataset("cycle", cycle, CYCLE)
    with style():
        figure = new_figure(7.2, 5.4)
        grid = figure.add_gridspec(2, 2, width_ratios=(1.15, 1.0))
        orbit = plot_cycle(cycle, ax=figure.add_subplot(grid[:, 0]))
        plot_multipliers(cycle, ax=figure.add_subplot(grid[0, 1]))
        plot_lines(cycle, ax=figure.add_subplot(grid[1, 1]))
        figure.suptitle(orbit.get_title(), fontsize=10.0)
        orbit.set_title("")
    return figure


def plot_cycle(cycle: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    r"""Draw one period of a limit cycle on axes that rotate with the unbalance, with the stator.

    An arrow shows the direction of motion. With friction, slip and rolling are distinguished as in
    `plot_run`.

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
    >>> ax = plot_cycle(limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5))
    >>> ax.get_xlabel()
    'along the unbalance $\\operatorname{Re}\\,z\\,e^{-i\\omega t}$'
    """
    cycle = check_dataset("cycle", cycle, CYCLE)
    ring = clearance_of(cycle, "cycle")
    path, crossings = _path_of(cycle, ring)
    with drawing(ax, width=4.0, height=4.9) as ax:
        label_axis(ax.xaxis, "rotating_x", cycle["x"])
        label_axis(ax.yaxis, "rotating_y", cycle["y"])
        draw_ring(ax, ring)
        draw_motion(ax, path, path.x, path.y, width=1.2, heavier=1.3)
        for name, marker, face, entry in (("entry", "^", RED, True), ("exit", "v", "white", False)):
            here = crossings[path.in_contact[crossings] == entry]
            if here.size:
                draw_marks(ax, path.x[here], path.y[here], marker, RED, size=4.5, face=face,
                           edge=0.8, label=name, level=3.0)  # fmt: skip
        _draw_arrow(ax, path)
        ax.set_aspect("equal", adjustable="datalim")
        ax.autoscale_view()
        ax.set_title(title_of("cycle", cycle))
        legend_below(ax, columns=3 if path.mode is None else 2)
    return ax


def plot_multipliers(cycle: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    r"""Draw the multipliers of a limit cycle, with the unit circle.

    A shift along the cycle has the multiplier 1, with the partner ``q = exp(-2 zeta T)``. The other
    two have the product q: a pair on the dashed circle of radius ``sqrt(q)``, or real numbers. With
    contact damping or friction, only the 1 of a shift is known. Under a load none is known;
    without contact damping and friction there are then two pairs of product q.

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
    period = one_value("cycle", cycle, "period") / scale_of(cycle, "time")
    q = math.exp(-2.0 * one_value("cycle", cycle, "zeta") * period)
    multipliers = cycle["multiplier_real"].values + 1j * cycle["multiplier_imag"].values
    damped, rubs, loaded = (
        name in cycle.coords and one_value("cycle", cycle, name) > 0.0
        for name in ("contact_damping", "friction", "load")
    )
    known = _Known([1.0, q], "1 and $q$", r"$\mu$ and $q/\mu$")
    if damped or rubs:
        known = _Known([1.0], "1, of a shift", "others")
    others, along = _parted(multipliers, [] if loaded else known.values)
    with drawing(ax, width=4.0, height=3.6) as ax:
        circles = (
            (1.0, "-", "_"),
            (math.sqrt(q), DASHES, rf"$\sqrt{{q}} = {math.sqrt(q):.4g}$"),
        )
        for radius, dashes, words in circles[: len(known.values)]:
            ax.plot(*circle(radius), color=GREY, lw=0.9, ls=dashes, label=words, zorder=2.0)
        for points, face, words in ((along, "white", known.words), (others, BLUE, known.others)):
            if points.size:  # under a load there are no known ones
                draw_marks(ax, points.real, points.imag, "o", BLUE, size=5.0, face=face, edge=1.1,
                           label=words, level=3.0)  # fmt: skip
        ax.set_xlabel(LABELS["multiplier_real"])
        ax.set_ylabel(LABELS["multiplier_imag"])
        ax.margins(0.08)
        ax.set_aspect("equal", adjustable="datalim")
        ax.autoscale_view()
        legend_below(ax)
    return ax


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


class _Known(NamedTuple):
    """The multipliers known in advance, in words, and the words for the others."""

    values: list[float]
    words: str
    others: str


def _path_of(cycle: xr.Dataset, ring: float) -> tuple[Path, npt.NDArray[np.intp]]:
    """Return one period as a path with its stator crossings, and their indices."""
    time, x, y = (cycle[name].values for name in ("t", "x", "y"))
    gap = np.hypot(x, y) - ring
    before = (
        np.flatnonzero((gap[:-1] >= 0.0) != (gap[1:] >= 0.0)) if ring > 0.0 else np.empty(0, int)
    )
    part = gap[before] / (gap[before] - gap[before + 1])
    after = before + 1
    times, across, up = (
        np.insert(column, after, column[before] + part * (column[after] - column[before]))
        for column in (time, x, y)
    )
    # a segment that begins on the stator belongs to the side that it enters
    inside = np.insert(gap >= 0.0, after, gap[after] >= 0.0)
    crossings = after + np.arange(after.size)
    slip = _slip_of(cycle)
    if slip is None:
        return Path(times, across, up, inside), crossings
    slip = np.insert(slip, after, slip[before] + part * (slip[after] - slip[before]))
    return Path(times, across, up, inside, mode=_modes(slip, inside)), crossings


def _slip_of(cycle: xr.Dataset) -> Values | None:
    """Return the slip speed along a cycle over the speed of the rim; None without friction."""
    rotor = rotor_of(cycle)
    if rotor.friction == 0.0 or rotor.disc_radius is None:
        return None
    x, y, vx, vy = (cycle[name].values for name in COMPONENTS)
    rim = rotor.disc_radius * rotor.omega * scale_of(cycle, "velocity")
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
