"""Limit cycles: their orbit, multipliers and spectrum, their branches and bifurcation curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.arrays import Values
from rotor_ida.cycles.branch_course import Course, course_of, parameters_of, runs_of
from rotor_ida.errors import InputError
from rotor_ida.model.table import ALL_PARAMETERS, PARAMETERS
from rotor_ida.plot.appearance import (
    BIRTH,
    BLUE,
    BOUNCING_CYCLE,
    BROWN,
    DASHES,
    DOUBLING,
    FOLD_OF_CYCLES,
    FULL_CONTACT_CYCLE,
    GRAZE,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    RED,
    ROLLING_CYCLE,
    SLIDING,
    STABLE_CYCLE,
    TORUS,
    UNSTABLE_CYCLE,
    axes_or_new,
    check_dataset,
    draw_ring,
    legend_below,
    one_value,
    own_legend,
    style,
    title_of,
)
from rotor_ida.plot.labels import LABELS, hold_units, label_axis, parameter_text, scale_of
from rotor_ida.plot.runs import Path, clearance_of, draw_motion
from rotor_ida.schema import flags_of

Whole = npt.NDArray[np.int64]

CYCLE = (*PARAMETERS, "t", "x", "y", "period", "response")
MULTIPLIERS = (*PARAMETERS, "period", "multiplier_real", "multiplier_imag")
LINES = ("omega", "period", "frequency", "whirl_amplitude", "line_kind")
SPECIALS = ("special_kind", "special_value", "special_point")
EXTENT = ("special_radius_min", "special_radius_max")
BRANCH = (*PARAMETERS, "radius_min", "radius_max", "stability", "response", *SPECIALS, *EXTENT)
# Lines of a spectrum are shown down to this part of the strongest.
FLOOR = 1e-5
# How far a band covers what is under it, and how its edges are drawn, by its stability.
COVER = {"stable": 0.28, "unstable": 0.09}
EDGES = {"stable": (STABLE_CYCLE, "-", 1.1), "unstable": (UNSTABLE_CYCLE, (0, (3.2, 1.8)), 0.9)}
BANDS = {
    "bouncing": (BOUNCING_CYCLE, ORANGE),
    "full_contact": (FULL_CONTACT_CYCLE, PURPLE),
    "rolling": (ROLLING_CYCLE, BROWN),
}


@dataclass(frozen=True, slots=True)
class _Mark:
    """How one kind of special point is drawn."""

    words: str
    marker: str
    size: float
    face: str


MARKS = {
    "fold": _Mark(FOLD_OF_CYCLES, "s", 4.0, "white"),
    "period_doubling": _Mark(DOUBLING, "P", 5.4, BROWN),
    "graze": _Mark(GRAZE, "x", 3.8, BROWN),
    "cusp": _Mark("cusp", "*", 7.5, "white"),
    "torus": _Mark(TORUS, "D", 3.8, "white"),
    "sliding": _Mark(SLIDING, "1", 5.4, BROWN),
    "hopf": _Mark(BIRTH, "o", 4.2, "white"),
}
# Bifurcation curves: one look for each kind, as long as they are of one rotor.
CURVES = {
    "fold": (FOLD_OF_CYCLES, "-"),
    "period_doubling": (DOUBLING, (0, (6, 1.8))),
    "torus": (TORUS, (0, (1.2, 1.2))),
}
COLOURS = (BLUE, ORANGE, PURPLE, RED, BROWN)


def cycle_figure(cycle: xr.Dataset) -> Figure:
    r"""Draw a limit cycle: its orbit, its multipliers and its spectrum.

    Parameters
    ----------
    cycle : Dataset
        What `rotor_ida.limit_cycle` returned.

    Returns
    -------
    Figure
        The figure. Its axes are those of `plot_cycle`, `plot_multipliers` and `plot_lines`.

    Raises
    ------
    InputError
        If there is no limit cycle in it.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> figure = cycle_figure(limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5))
    >>> [ax.get_ylabel() for ax in figure.axes][1:]
    ['$\\operatorname{Im}\\,\\mu$', 'whirl amplitude $|c|$']
    """
    cycle = _checked_cycle(cycle, CYCLE)
    with style():
        figure = Figure(figsize=(7.2, 5.4), layout="constrained")
        grid = figure.add_gridspec(2, 2, width_ratios=(1.15, 1.0))
        orbit = plot_cycle(cycle, ax=figure.add_subplot(grid[:, 0]))
        plot_multipliers(cycle, ax=figure.add_subplot(grid[0, 1]))
        plot_lines(cycle, ax=figure.add_subplot(grid[1, 1]))
        figure.suptitle(orbit.get_title(), fontsize=10.0)
        orbit.set_title("")
    return figure


def plot_cycle(cycle: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    r"""Draw one period of a limit cycle on axes that turn with the unbalance, with the ring.

    An arrow shows which way it is passed.

    Parameters
    ----------
    cycle : Dataset
        What `rotor_ida.limit_cycle` returned.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Raises
    ------
    InputError
        If there is no limit cycle in it.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> ax = plot_cycle(limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5))
    >>> ax.get_xlabel()
    'along the unbalance $\\operatorname{Re}\\,z\\,e^{-i\\omega t}$'
    """
    cycle = _checked_cycle(cycle, CYCLE)
    ring = clearance_of(cycle)
    path, crossings = _path_of(cycle, ring)
    with style():
        ax = axes_or_new(ax, width=4.0, height=4.9)
        label_axis(ax.xaxis, "rotating_x", cycle["x"])
        label_axis(ax.yaxis, "rotating_y", cycle["y"])
        draw_ring(ax, ring)
        draw_motion(ax, path, path.x, path.y, width=1.2, heavier=1.3)
        for name, marker, face, entry in (("entry", "^", RED, True), ("exit", "v", "white", False)):
            here = crossings[path.in_contact[crossings] == entry]
            if here.size:
                ax.plot(path.x[here], path.y[here], ls="", marker=marker, ms=4.5, mec=RED,
                        mfc=face, mew=0.8, label=name, zorder=3.0)  # fmt: skip
        _draw_arrow(ax, path)
        ax.set_aspect("equal", adjustable="datalim")
        ax.autoscale_view()
        ax.set_title(title_of("cycle", cycle))
        legend_below(ax)
    return ax


def plot_multipliers(cycle: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    r"""Draw the multipliers of a limit cycle, with the unit circle.

    A shift along the cycle has the multiplier 1, with the partner ``q = exp(-2 zeta T)``. The other
    two have the product q: a pair on the dashed circle of radius ``sqrt(q)``, or real numbers. With
    contact damping or friction there is only the 1 of a shift. Under a load there is none, and
    without these two pairs of product q.

    Parameters
    ----------
    cycle : Dataset
        What `rotor_ida.limit_cycle` returned.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Raises
    ------
    InputError
        If there is no limit cycle in it.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> ax = plot_multipliers(limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5))
    >>> ax.get_legend_handles_labels()[1][0]
    '$\\sqrt{q} = 0.7265$'
    """
    cycle = _checked_cycle(cycle, MULTIPLIERS)
    period = one_value("cycle", cycle, "period") / scale_of(cycle, "time")
    q = math.exp(-2.0 * one_value("cycle", cycle, "zeta") * period)
    found = cycle["multiplier_real"].values + 1j * cycle["multiplier_imag"].values
    damped, rubs, loaded = (
        name in cycle.coords and one_value("cycle", cycle, name) > 0.0
        for name in ("contact_damping", "friction", "load")
    )
    damped = damped or rubs
    known = [] if loaded else [1.0] if damped else [1.0, q]
    others, along = _parted(found, known)
    shift, rest = ("1, of a shift", "others") if damped else ("1 and $q$", r"$\mu$ and $q/\mu$")
    turn = np.linspace(0.0, 2.0 * math.pi, 361)
    with style():
        ax = axes_or_new(ax, width=4.0, height=3.6)
        circles = (
            (1.0, "-", None),
            (math.sqrt(q), DASHES, rf"$\sqrt{{q}} = {math.sqrt(q):.4g}$"),
        )
        for radius, dashes, words in circles[: 1 if damped else 2]:
            ax.plot(radius * np.cos(turn), radius * np.sin(turn), color=GREY, lw=0.9, ls=dashes,
                    label=words, zorder=2.0)  # fmt: skip
        for points, marker, face, words in (
            (along, "o", "white", shift),
            (others, "o", BLUE, rest),
        ):
            if not points.size:  # under a load
                continue
            ax.plot(points.real, points.imag, ls="", marker=marker, ms=5.0, mec=BLUE, mfc=face,
                    mew=1.1, label=words, zorder=3.0)  # fmt: skip
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
        What `rotor_ida.limit_cycle` returned.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Raises
    ------
    InputError
        If there is no limit cycle in it.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> ax = plot_lines(limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5))
    >>> ax.get_xlabel()
    'frequency over spin speed $\\Omega/\\omega$'
    """
    cycle = _checked_cycle(cycle, LINES)
    height, kinds = cycle["whirl_amplitude"].values, cycle["line_kind"].values
    flags = flags_of(cycle["line_kind"])
    highest = float(height.max())
    omega = one_value("cycle", cycle, "omega") * scale_of(cycle, "rate")
    ratio, seen = cycle["frequency"].values / omega, height >= FLOOR * highest
    with style():
        ax = axes_or_new(ax)
        ax.set_yscale("log")
        ax.set_xlabel(LABELS["frequency_over_omega"])
        label_axis(ax.yaxis, "whirl_amplitude", cycle["whirl_amplitude"])
        for kind, words, colour, marker in (
            ("backward", "backward whirl", ORANGE, "v"),
            ("forward", "forward whirl", BLUE, "^"),
            ("spin", "spin speed", INK, "o"),
            ("static", "static", GREY, "s"),
        ):
            here = seen & (kinds == flags.get(kind))  # older archives know fewer
            if not here.any():
                continue
            ax.vlines(ratio[here], 0.3 * FLOOR * highest, height[here], color=colour, lw=0.9)
            ax.plot(ratio[here], height[here], ls="", marker=marker, ms=3.4, color=colour,
                    label=words)  # fmt: skip
        ax.set_ylim(0.3 * FLOOR * highest, 3.0 * highest)
        legend_below(ax)
    return ax


def plot_branch(branch: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw a branch of limit cycles: the range of the radius over the continued parameter.

    The edges of the band are the smallest and the largest radius of the cycles, solid where these
    are stable, dashed where not; its colour tells bouncing from full contact. Folds, period
    doublings, torus points and grazes are marked on the upper edge. Several branches, and what
    `plot_amplitude` has drawn before, can be on the same axes, which then keep their labels and
    title.

    Parameters
    ----------
    branch : Dataset
        What `rotor_ida.continue_cycle` returned.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, continue_cycle, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> cycle = limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5)
    >>> plot_branch(continue_cycle(rotor, start=cycle, limits=(1.9, 2.1))).get_ylabel()
    'radius $|z|$'
    """
    branch = check_dataset("branch", branch, BRANCH)
    parameter = parameters_of("branch", branch, "parameter", 1)[0]
    course = course_of(branch)
    with style():
        fresh = ax is None or not ax.has_data()
        ax = axes_or_new(ax)
        hold_units(ax.yaxis, branch["radius_max"])
        if fresh:
            held = [name for name in PARAMETERS if name != parameter]
            ax.set(xlabel=LABELS[parameter], title=title_of("branch", branch, held))
            label_axis(ax.yaxis, "radius", branch["radius_max"])
        _draw_bands(ax, course)
        _draw_edges(ax, course)
        _draw_specials(ax, branch, branch["special_value"].values, branch["special_radius_max"])
        _raise_limit(ax, float(branch["radius_max"].max()))
        own_legend(ax)
    return ax


def plot_curves(
    curves: xr.Dataset | Sequence[xr.Dataset],
    *,
    fold_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    r"""Draw bifurcation curves of limit cycles in the plane of their two parameters.

    Parameters
    ----------
    curves : Dataset or sequence of Dataset
        What `rotor_ida.bifurcation_curve` returned, all over the same two parameters.
    fold_points : Dataset, optional
        What `rotor_ida.folds` returned for many clearances and one ``zeta``: the folds of the
        synchronous whirl, beside curves over ``omega`` and ``delta0``.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Raises
    ------
    InputError
        If there is no curve, or one is over other parameters, or has another ``zeta`` than the
        folds of the whirl.

    Examples
    --------
    >>> from rotor_ida import Rotor, bifurcation_curve, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> cycle = limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5)
    >>> curve = bifurcation_curve(rotor, start=cycle, kind="period_doubling",
    ...                           limits=[(1.5, 2.5), (1.9, 2.1)])
    >>> plot_curves(curve).get_ylabel()
    'clearance $\\delta_0$'
    """
    datasets = [curves] if isinstance(curves, xr.Dataset) else list(curves)
    if not datasets:
        raise InputError("curves must hold at least one bifurcation curve, got none")
    for curve in datasets:
        check_dataset("curves", curve, (*PARAMETERS, *SPECIALS, "special_second_value"))
    across, up = parameters_of("curves", datasets[0], "parameters", 2)
    for curve in datasets[1:]:
        names = parameters_of("curves", curve, "parameters", 2)
        if set(names) != {across, up}:
            raise InputError(
                f"curves must all be over {across} and {up}, got {' and '.join(names)}"
            )
    held = [name for name in ALL_PARAMETERS if name not in {across, up}]
    values = [
        {name: one_value("curves", curve, name) for name in held if name in curve.coords}
        for curve in datasets
    ]
    if fold_points is not None:
        if not {across, up} <= set(PARAMETERS) or any(len(each) > 1 for each in values):
            raise InputError("fold_points must be left out beside curves of a machine, got some")
        _check_folds(
            fold_points, {across, up}, [value for each in values for value in each.values()]
        )
    with style():
        ax = axes_or_new(ax)
        ax.set(xlabel=LABELS[across], ylabel=LABELS[up])
        if fold_points is not None:
            _draw_folds(ax, fold_points, across)
        several = any(each != values[0] for each in values)
        for curve, value in zip(datasets, values, strict=True):
            words, dashes = CURVES[_kind_of_curve(curve)]
            told = f"{words}, {parameter_text(value)}" if several else words
            colour = _colour_of(ax, told)
            ax.plot(curve[across].values, curve[up].values, color=colour, ls=dashes, lw=1.2,
                    label=told, zorder=2.5)  # fmt: skip
            names = parameters_of("curves", curve, "parameters", 2)
            first, second = curve["special_value"].values, curve["special_second_value"]
            if names[0] == across:
                _draw_specials(ax, curve, first, second, ("cusp",))
            else:
                _draw_specials(ax, curve, second.values, curve["special_value"], ("cusp",))
        if not several:
            ax.set_title(parameter_text(values[0]))
        own_legend(ax)
    return ax


def _checked_cycle(cycle: object, needed: Sequence[str]) -> xr.Dataset:
    """Return a dataset if it holds a limit cycle."""
    found = check_dataset("cycle", cycle, needed)
    if math.isnan(one_value("cycle", found, "period")):
        raise InputError("cycle must hold a limit cycle, got a result without one")
    return found


def _path_of(cycle: xr.Dataset, ring: float) -> tuple[Path, Whole]:
    """Return one period as a path, with its points on the ring, and the numbers of these."""
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
    # a stretch that begins on the ring goes where it comes to
    inside = np.insert(gap >= 0.0, after, gap[after] >= 0.0)
    crossings = after + np.arange(after.size)
    return Path(times, across, up, inside), crossings


def _draw_arrow(ax: Axes, path: Path) -> None:
    """Show the direction of motion, at the largest radius."""
    place = min(int(np.argmax(path.radius)), path.time.size - 2)
    colour = RED if path.in_contact[place] else BLUE
    ax.annotate(
        "", (path.x[place + 1], path.y[place + 1]), (path.x[place], path.y[place]), zorder=3.0,
        arrowprops={"arrowstyle": "-|>", "color": colour, "shrinkA": 0.0, "shrinkB": 0.0},
    )  # fmt: skip


def _parted(
    multipliers: npt.NDArray[np.complex128], known: Sequence[float]
) -> tuple[npt.NDArray[np.complex128], npt.NDArray[np.complex128]]:
    """Return the two multipliers that tell the stability, and those of a shift along the cycle."""
    rest = list(multipliers)
    along = [rest.pop(int(np.argmin(np.abs(np.array(rest) - value)))) for value in known]
    return np.array(rest), np.array(along)


def _kind_of_curve(curve: xr.Dataset) -> str:
    kind = str(curve.attrs.get("kind", ""))
    if kind not in CURVES:
        raise InputError(f"curves must be of {' or '.join(CURVES)}, got the kind {kind!r}")
    return kind


def _draw_bands(ax: Axes, course: Course) -> None:
    """Fill between smallest and largest radius, piece by piece: a branch folds over itself."""
    rising = (np.diff(course.value) > 0.0).tolist()
    kinds = list(zip(course.response, course.stability, rising, strict=True))
    for first, last in runs_of(kinds):
        response, stability, _ = kinds[first]
        piece = slice(first, last + 1)
        ax.fill_between(
            course.value[piece], course.low[piece], course.high[piece], color=BANDS[response][1],
            alpha=COVER[stability], lw=0.0, zorder=1.6,
        )  # fmt: skip
    for response in dict.fromkeys(course.response):
        words, colour = BANDS[response]
        ax.fill_between([], [], color=colour, alpha=COVER["stable"], lw=0.0,
                        label=f"{words}: range of $|z|$")  # fmt: skip


def _draw_edges(ax: Axes, course: Course) -> None:
    for kind, (words, dashes, width) in EDGES.items():
        lines: list[Values] = []
        for first, last in runs_of(course.stability):
            if course.stability[first] == kind:
                piece = slice(first, last + 1)
                for edge in (course.low, course.high):
                    lines += [np.stack([course.value[piece], edge[piece]]), np.full((2, 1), np.nan)]
        if lines:
            ax.plot(*np.concatenate(lines, axis=1), color=BROWN, ls=dashes, lw=width, label=words,
                    zorder=2.4)  # fmt: skip


def _draw_specials(
    ax: Axes,
    branch: xr.Dataset,
    across: Values,
    up: xr.DataArray,
    kinds: Sequence[str] = tuple(MARKS),
) -> None:
    """Mark the special points of some kinds."""
    flags = flags_of(branch["special_kind"])
    for kind in kinds:
        mark = MARKS[kind]
        here = branch["special_kind"].values == flags.get(kind)  # older archives know fewer
        if here.any():
            ax.plot(
                across[here], up.values[here], ls="", marker=mark.marker, ms=mark.size, mec=BROWN,
                mfc=mark.face, mew=1.0, label=mark.words, zorder=2.8,
            )  # fmt: skip


def _raise_limit(ax: Axes, highest: float) -> None:
    """Let an axis of radii begin at 0 and reach this high; panels may share it with taller ones."""
    before = 0.0 if ax.get_autoscaley_on() else ax.get_ylim()[1]
    ax.set_ylim(0.0, max(before, 1.06 * highest))


def _check_folds(fold_points: object, names: set[str], values: Sequence[float]) -> None:
    """Refuse folds of the whirl that do not belong beside curves over these parameters."""
    found = check_dataset("fold_points", fold_points, ("zeta", "delta0", "fold_omega"))
    if names != {"omega", "delta0"}:
        raise InputError(
            f"fold_points must be left out beside curves over {' and '.join(sorted(names))}"
        )
    zeta = one_value("fold_points", found, "zeta")
    if any(value != zeta for value in values):
        raise InputError(
            f"fold_points must have the zeta of the curves, {values[0]!r}, got {zeta!r}"
        )


def _draw_folds(ax: Axes, fold_points: xr.Dataset, across: str) -> None:
    """Draw the folds of the synchronous whirl in points, since they come and go."""
    places = xr.broadcast(fold_points["fold_omega"], fold_points["delta0"])
    omega, delta0 = (place.values.ravel() for place in places)
    x, y = (omega, delta0) if across == "omega" else (delta0, omega)
    ax.plot(x, y, ls="", marker=".", ms=2.8, mew=0.0, color=INK, label="fold of the whirl",
            zorder=2.3)  # fmt: skip


def _colour_of(ax: Axes, words: str) -> str:
    """Return the colour of what has this name on the axes, or one that nothing there has."""
    drawn = {str(line.get_label()): str(line.get_color()) for line in ax.lines}
    if words in drawn:
        return drawn[words]
    return next((colour for colour in COLOURS if colour not in drawn.values()), INK)
