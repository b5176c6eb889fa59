"""Branches of limit cycles over a parameter, and bifurcation curves over two."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.checks import check_choice, shown
from rotor_ida.cycles.branch_course import VARIED, Course, course_of, parameters_of, runs_of
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.plot import legends, palette
from rotor_ida.plot.appearance import draw_marks, drawing, raise_limit
from rotor_ida.plot.datasets import (
    at_contact,
    check_dataset,
    clearances_in,
    contact_in,
    contact_text,
    hold_units,
    is_of_disc,
    one_value,
)
from rotor_ida.plot.labels import (
    label_axis,
    label_parameter,
    speed_text,
    speeds_in,
    text_of,
    title_of,
)
from rotor_ida.plot.legends import own_legend
from rotor_ida.plot.responses import draw_clearance
from rotor_ida.schema import words_of

SPECIALS = ("special_kind", "special_value", "special_point")
BRANCH = ("radius_min", "radius_max", "stability", "response", *SPECIALS, "special_radius_max")
# Opacity of a band and style of its edges, by stability.
COVER = {"stable": 0.28, "unstable": 0.09}
EDGES = {"stable": (legends.STABLE_CYCLE, "-", 1.1),
         "unstable": (legends.UNSTABLE_CYCLE, (0, (3.2, 1.8)), 0.9)}  # fmt: skip
BANDS = {
    "bouncing": (legends.BOUNCING_CYCLE, palette.ORANGE),
    "full_contact": (legends.FULL_CONTACT_CYCLE, palette.PURPLE),
    "rolling": (legends.ROLLING_CYCLE, palette.BROWN),
}
# Special points: words, mark, its size, and its face.
MARKS = {
    "fold": (legends.FOLD_OF_CYCLES, "s", 4.0, "white"),
    "period_doubling": (legends.DOUBLING, "P", 5.4, palette.BROWN),
    "graze": (legends.GRAZE, "x", 3.8, palette.BROWN),
    "cusp": ("cusp", "*", 7.5, "white"),
    "torus": ("torus", "D", 3.8, "white"),
    "sliding": (legends.SLIDING, "1", 5.4, palette.BROWN),
    "hopf": (legends.HOPF, "o", 4.2, "white"),
    "discontinuous": (legends.DISCONTINUOUS, "v", 4.2, "white"),
}
# Bifurcation curves: one style for each kind, if they are of one rotor.
CURVES = {
    "fold": (legends.FOLD_OF_CYCLES, "-"),
    "period_doubling": (legends.DOUBLING, (0, (6, 1.8))),
    "torus": ("torus", (0, (1.2, 1.2))),
}
COLOURS = (palette.BLUE, palette.ORANGE, palette.PURPLE, palette.RED, palette.BROWN)


def plot_branch(branch: xr.Dataset, *, contact: int | str = 0, ax: Axes | None = None) -> Axes:
    """Draw a branch of limit cycles: the range of the radius over the continued parameter.

    The edges of the band are the smallest and the largest radius of the cycles, solid where these
    are stable, dashed where not; its colour distinguishes bouncing from full
    contact. Special points, such as folds and grazes, are marked on the upper edge. Several
    branches can share axes, also with `plot_amplitude`; the axes then keep
    their labels and title.

    Parameters
    ----------
    branch : Dataset
        Result of `rotor_ida.continue_cycle`.
    contact : int or str
        The contact of a rotor system, by its number or its node. Its clearance is a dashed line.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is of another kind, or has no such contact.

    Examples
    --------
    >>> from rotor_ida import Rotor, continue_cycle, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> cycle = limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5)
    >>> plot_branch(continue_cycle(rotor, start=cycle, limits=(1.9, 2.1))).get_ylabel()
    'radius $|z|$'

    At a contact of a rotor system:

    >>> branch = continue_cycle(rotor.system(), speed=2.0, limits=(1.9, 2.1))
    >>> plot_branch(branch, contact=0).get_title()
    'contact 0 at disc'
    """
    branch = check_dataset("branch", branch, BRANCH)
    parameter = parameters_of("branch", branch, "parameter", 1)[0]
    number, part = contact_in(branch, contact), at_contact(branch, contact)
    course, across = course_of(branch, number), _drawn(branch, parameter)
    course = replace(course, value=across(course.value))
    with drawing(ax, width=5.6, height=4.2) as ax:
        fresh = not ax.has_data()
        hold_units(ax.yaxis, branch["radius_max"])
        if fresh:
            label_parameter(ax.xaxis, parameter, branch)
            label_axis(ax.yaxis, "radius", branch["radius_max"])
            ax.set_title(
                title_of("branch", branch, [each for each in PARAMETERS if each != parameter])
                if is_of_disc(branch) else contact_text(branch, number)
            )  # fmt: skip
        _draw_bands(ax, course)
        _draw_edges(ax, course)
        places = across(part["special_value"].values), part["special_radius_max"].values
        draw_specials(ax, part, *places, tuple(MARKS))
        lowest, highest = float(part["radius_min"].min()), float(part["radius_max"].max())
        if fresh and float(clearances_in(part).max()) >= lowest:
            draw_clearance(ax, part, over=parameter)
        raise_limit(ax, lowest, highest)
        own_legend(ax)
    return ax


def plot_curves(
    curves: xr.Dataset | Sequence[xr.Dataset], *, fold_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:  # fmt: skip
    r"""Draw bifurcation curves of limit cycles in the plane of their two parameters.

    Parameters
    ----------
    curves : Dataset or sequence of Dataset
        Result of `rotor_ida.bifurcation_curve`, all over the same two parameters.
    fold_points : Dataset, optional
        Result of `rotor_ida.folds` for many clearances and one ``zeta``: the folds of the
        synchronous whirl, beside curves over ``omega`` and ``delta0``.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If there is no curve, if the curves have different parameters, or if their ``zeta`` differs
        from that of the folds of the whirl.

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
    if not isinstance(curves, (xr.Dataset, Iterable)):
        raise InputError(f"curves must be Datasets, got {shown(curves)}")
    datasets = [curves] if isinstance(curves, xr.Dataset) else list(curves)
    if not datasets:
        raise InputError("curves must contain at least one bifurcation curve, got none")
    needed = (*SPECIALS, "special_second_value")
    datasets = [check_dataset("curves", each, needed) for each in datasets]
    across, up = _plane_of(datasets)
    others = [name for name in dict.fromkeys(VARIED) if name not in {across, up}]
    values = [
        {name: one_value("curves", curve, name) for name in others if name in curve.coords}
        for curve in datasets
    ]
    if fold_points is not None:
        _check_folds(fold_points, {across, up}, values)
    several = any(each != values[0] for each in values)
    with drawing(ax, width=5.6, height=4.2) as ax:
        for axis, name in ((ax.xaxis, across), (ax.yaxis, up)):
            label_parameter(axis, name, datasets[0])
        if fold_points is not None:
            _draw_folds_of_whirl(ax, fold_points, across)
        colours: dict[str, str] = {}
        for curve, value in zip(datasets, values, strict=True):
            kind = check_choice("the kind of curves", curve.attrs.get("kind"), tuple(CURVES))
            words, dashes = CURVES[kind]
            label = f"{words}, {_held_text(curve, value)}" if several else words
            colour = colours.setdefault(label, COLOURS[len(colours) % len(COLOURS)])
            place = [_drawn(curve, each) for each in (across, up)]
            ax.plot(place[0](curve[across].values), place[1](curve[up].values), color=colour,
                    ls=dashes, lw=1.2, label=label, zorder=2.5)  # fmt: skip
            marks = [curve["special_value"].values, curve["special_second_value"].values]
            if parameters_of("curves", curve, "parameters", 2)[0] != across:
                marks.reverse()
            draw_specials(ax, curve, place[0](marks[0]), place[1](marks[1]), ("cusp",))
        if not several:
            ax.set_title(_held_text(datasets[0], values[0]))
        own_legend(ax)
    return ax


def _plane_of(curves: Sequence[xr.Dataset]) -> tuple[str, str]:
    """Return the two parameters that all curves are over."""
    across, up = parameters_of("curves", curves[0], "parameters", 2)
    for curve in curves[1:]:
        names = parameters_of("curves", curve, "parameters", 2)
        if set(names) != {across, up}:
            raise InputError(
                f"curves must all be over {across} and {up}, got {' and '.join(names)}"
            )
    return across, up


def _drawn(dataset: xr.Dataset, name: str) -> Callable[[Values], Values]:
    """Return how values of a parameter are drawn: spin speeds of a system in SI units in rpm."""
    if name != SPEED:
        return lambda values: values
    return lambda values: np.asarray(
        speeds_in(xr.DataArray(values, attrs=dataset[SPEED].attrs)).values
    )


def _held_text(curve: xr.Dataset, values: Mapping[str, float]) -> str:
    """Return what is the same along a curve: parameters of one disc, or the speed of a system."""
    if "contact" in curve.dims:
        return speed_text(curve[SPEED]) if SPEED in values else ""
    return text_of(curve, values)


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
            ax.plot(*np.concatenate(lines, axis=1), color=palette.BROWN, ls=dashes, lw=width,
                    label=words, zorder=2.4)  # fmt: skip


def draw_specials(
    ax: Axes, branch: xr.Dataset, across: Values, up: Values, kinds: Sequence[str]
) -> None:
    """Mark the special points of some kinds."""
    here = np.array(words_of(branch["special_kind"]))
    for kind in kinds:
        (words, marker, size, face), chosen = MARKS[kind], here == kind
        if chosen.any():
            draw_marks(ax, across[chosen], up[chosen], marker, palette.BROWN, size=size, face=face,
                       label=words, level=2.8)  # fmt: skip


def _check_folds(
    fold_points: object, names: set[str], values: Sequence[Mapping[str, float]]
) -> None:
    """Refuse folds of the whirl that do not match curves over these parameters."""
    folds = check_dataset("fold_points", fold_points, ("zeta", "delta0", "fold_omega"))
    if names != {"omega", "delta0"} or any(len(each) > 1 for each in values):
        raise InputError(
            "fold_points must be left out, except beside curves of the paper's rotor over omega "
            "and delta0"
        )
    zeta = one_value("fold_points", folds, "zeta")
    for each in values:
        if each["zeta"] != zeta:
            raise InputError(
                f"fold_points must have the zeta of the curves, {values[0]['zeta']!r}, got {zeta!r}"
            )


def _draw_folds_of_whirl(ax: Axes, fold_points: xr.Dataset, across: str) -> None:
    """Draw the folds of the synchronous whirl as points: not all exist at each clearance."""
    places = xr.broadcast(fold_points["fold_omega"], fold_points["delta0"])
    omega, delta0 = (place.values.ravel() for place in places)
    x, y = (omega, delta0) if across == "omega" else (delta0, omega)
    ax.plot(x, y, ls="", marker=".", ms=2.8, mew=0.0, color=palette.INK, label="fold of the whirl",
            zorder=2.3)  # fmt: skip
