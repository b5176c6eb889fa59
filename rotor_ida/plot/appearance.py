"""Appearance of the plots: style, layout, panels, and what is drawn in many of them."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.transforms import Bbox

from rotor_ida.arrays import Values
from rotor_ida.checks import check_count
from rotor_ida.errors import InputError
from rotor_ida.plot import palette

_SETTINGS: Any = {
    # the second for what the first lacks, as in names of nodes
    "font.family": ["STIXGeneral", "DejaVu Sans"],
    "mathtext.fontset": "stix",
    "font.size": 9.5,
    "axes.labelsize": 10.0,
    "axes.titlesize": 10.0,
    "axes.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.5,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "lines.solid_capstyle": "round",
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "agg.path.chunksize": 100_000,
    "svg.hashsalt": "rotor_ida",
    "svg.fonttype": "path",
    # journals refuse the default, type 3
    "pdf.fonttype": 42,
}
# A layout is settled when no edge moves by more than this part of the figure in a pass.
UNMOVED, MOST_PASSES = 2e-4, 20
# Values that differ by less than this part of their size are the same to the errors of a result; an
# axis on which all are has a span of at least this part of it.
RESOLVED, LEAST_SPAN = 1e-6, 0.2
# Heights that are all above this part of the largest are drawn on an axis that does not begin at 0.
FLAT = 0.8
# Whether pyplot registers new figures; set for each thread or worker.
_KNOWN_TO_PYPLOT: ContextVar[bool] = ContextVar("known_to_pyplot", default=True)


@contextmanager
def style() -> Iterator[None]:
    """Draw in the style of this package while the context lasts.

    Examples
    --------
    >>> with style():
    ...     mpl.rcParams["font.family"]
    ['STIXGeneral', 'DejaVu Sans']
    """
    with mpl.rc_context(), boxes_for_letters():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)
        yield


@contextmanager
def boxes_for_letters() -> Iterator[None]:
    """Draw letters that no font has, as in names of nodes, as boxes without a warning."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


@contextmanager
def without_pyplot() -> Iterator[None]:
    """Make figures without registering them in pyplot while the context lasts.

    Code that writes figures to files draws within it: it needs no display and leaves none open.
    """
    token = _KNOWN_TO_PYPLOT.set(False)
    try:
        yield
    finally:
        _KNOWN_TO_PYPLOT.reset(token)


class SettledLayout(ConstrainedLayoutEngine):
    """Constrained layout, repeated until the axes stay where they are.

    A pass measures the labels where they were before it. One pass alone would cut off texts in the
    first drawing of axes of a fixed aspect, and each drawing would differ from the one before.
    """

    def execute(self, fig: Figure) -> None:
        """Move and resize the axes of a figure."""
        before = places_of(fig)
        for _ in range(MOST_PASSES):
            super().execute(fig)
            after = places_of(fig)
            if np.abs(after - before).max(initial=0.0) < UNMOVED:
                break
            before = after
        put_axes(fig, before)


def places_of(figure: Figure) -> Values:
    """Return the corners of all axes of a figure."""
    return np.array([ax.get_position(original=True).get_points() for ax in figure.axes])


def put_axes(figure: Figure, places: Values) -> None:
    """Move the axes that the layout places to corners, and leave them to the layout."""
    for ax, place in zip(figure.axes, places, strict=True):
        if ax.get_in_layout():
            ax.set_position(Bbox(place), which="original")
            ax.set_in_layout(True)


def new_figure(width: float, height: float, *, layout: SettledLayout | None = None) -> Figure:
    """Return an empty figure of a size [inch], registered in pyplot."""
    layout = layout or SettledLayout()
    if not _KNOWN_TO_PYPLOT.get():
        return Figure(figsize=(width, height), layout=layout)
    from matplotlib import pyplot  # noqa: PLC0415 - chooses a backend, which is for who draws

    return pyplot.figure(figsize=(width, height), layout=layout)


def panels(
    rows: int, columns: int, *, width: float = 7.2, height: float = 5.6, shared: bool = True
) -> tuple[Figure, list[Axes]]:
    """Return a figure with lettered panels.

    Parameters
    ----------
    rows, columns : int
        Number of panels down and across.
    width, height : float
        Size of the figure [inch].
    shared : bool
        Whether all panels have the same axes.

    Returns
    -------
    figure : Figure
        The figure.
    axes : list of Axes
        Its panels, row by row.

    Examples
    --------
    >>> figure, axes = panels(2, 2)
    >>> len(axes)
    4
    """
    check_count("rows", rows)
    check_count("columns", columns)
    with style():
        figure = new_figure(width, height)
        grid = figure.subplots(rows, columns, sharex=shared, sharey=shared, squeeze=False)
        axes = list(grid.ravel())
        _letter(axes)
    return figure, axes


def mixed_panels(
    rows: int, columns: int, *, width: float = 7.2, height: float = 5.6, solid: Sequence[int] = ()
) -> tuple[Figure, list[Axes]]:
    """Return a figure with lettered panels, each with separate axes.

    Parameters
    ----------
    rows, columns, width, height
        As for `panels`.
    solid : sequence of int
        Numbers of the panels, row by row from 0, that are three-dimensional.

    Returns
    -------
    figure, axes
        As for `panels`.

    Raises
    ------
    InputError
        If there is no such panel.

    Examples
    --------
    >>> figure, axes = mixed_panels(1, 2, solid=[0])
    >>> [ax.name for ax in axes]
    ['3d', 'rectilinear']
    """
    number = check_count("rows", rows) * check_count("columns", columns)
    for place in solid:
        if not 0 <= place < number:
            raise InputError(f"solid must contain numbers of panels below {number}, got {place!r}")
    with style():
        figure = new_figure(width, height)
        kinds = ["3d" if place in solid else None for place in range(number)]
        axes = [
            figure.add_subplot(rows, columns, place, projection=kind)
            for place, kind in enumerate(kinds, start=1)
        ]
        _letter(axes)
    return figure, axes


def _letter(axes: Sequence[Axes]) -> None:
    for number, ax in enumerate(axes if len(axes) > 1 else ()):
        ax.set_title(chr(ord("a") + number), loc="left", fontweight="bold")


@contextmanager
def drawing(ax: Axes | None, *, width: float = 5.0, height: float = 3.6) -> Iterator[Axes]:
    """Draw in the style of this package on `ax`, or on the axes of a new figure."""
    with style():
        if ax is None:
            ax = new_figure(width, height).subplots()
        if not isinstance(ax, Axes):
            raise InputError(f"ax must be matplotlib Axes, got {type(ax).__name__}")
        yield ax
        keep_resolved(ax)


def finish_solid(ax: Any, *, zoom: float = 0.95) -> None:
    """Give three-dimensional axes small labels, white walls and all available room."""
    ax.tick_params(labelsize=7.5, pad=-2.5)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.pane.set_facecolor("white")
        # the walls may extend past the square of the axes
        axis.pane.set_clip_on(False)
        axis.gridlines.set_clip_on(False)
    ax.set_box_aspect(None, zoom=zoom)


def circle(radius: float) -> tuple[Values, Values]:
    """Return the points of a circle about the bearing axis."""
    turn = np.linspace(0.0, 2.0 * math.pi, 361)
    return radius * np.cos(turn), radius * np.sin(turn)


def draw_ring(ax: Axes, clearance: float, centre: complex = 0j) -> None:
    """Draw the clearance circle, unless the clearance is 0."""
    if clearance > 0.0:
        x, y = circle(clearance)
        ax.plot(x + centre.real, y + centre.imag, color=palette.INK, lw=0.9, ls=palette.DASHES,
                label="clearance", zorder=2.6)  # fmt: skip


def draw_marks(
    ax: Any, x: npt.ArrayLike, y: npt.ArrayLike, marker: str, colour: str, *, size: float,
    face: str = "", edge: float = 1.0, label: str = "_", level: float = 2.0, clip: bool = True,
) -> None:  # fmt: skip
    """Draw marks without a line: of one colour, or with a face of another."""
    ax.plot(x, y, ls="", marker=marker, ms=size, mec=colour, mfc=face or colour, mew=edge,
            label=label, zorder=level, clip_on=clip)  # fmt: skip


def say_in_middle(ax: Axes, words: str) -> None:
    """Write in the middle of empty axes why they are empty."""
    ax.text(0.5, 0.5, words, transform=ax.transAxes, ha="center", va="center")
    if not ax.lines:
        ax.set_yticks([])


def draw_level(ax: Axes, clearance: float, *, label: str = "clearance") -> None:
    """Draw a clearance as a level of the radius over time or speed, unless it is 0."""
    if clearance != 0.0:
        ax.axhline(clearance, color=palette.INK, lw=0.7, ls=palette.DASHES, zorder=2.6, label=label)


def raise_limit(ax: Axes, lowest: float, highest: float) -> None:
    """Extend a vertical axis from 0 to a height, or about values that are nearly the same.

    A shared one is never shortened.
    """
    low, room = 0.0, 0.06 * highest
    if lowest > FLAT * highest:
        span = highest - lowest
        room = 0.06 * span if span > RESOLVED * highest else 0.5 * LEAST_SPAN * highest
        low = lowest - room
    before = (low, 0.0) if ax.get_autoscaley_on() else ax.get_ylim()
    ax.set_ylim(min(before[0], low), max(before[1], highest + room))


def widen(ax: Axes, across: float, up: float) -> None:
    """Extend both axes to spans of at least these lengths."""
    corners = []
    for (low, high), least in ((ax.get_xlim(), across), (ax.get_ylim(), up)):
        middle, reach = 0.5 * (low + high), 0.5 * least if high - low < least else 0.0
        corners.append((middle - reach, middle + reach))
    ax.update_datalim(np.transpose(corners))  # limits that are set would forbid an equal aspect
    ax.autoscale_view()


def keep_resolved(ax: Axes) -> None:
    """Extend an axis on which all values are the same to rounding: it would magnify that alone."""
    ends = ax.dataLim.get_points()
    sizes, spans = np.abs(ends).max(axis=0), np.ptp(ends, axis=0)
    is_plain = np.array([ax.get_xscale(), ax.get_yscale()]) == "linear"
    if ax.name == "rectilinear" and np.isfinite(ends).all():
        widen(ax, *np.where(is_plain & (spans < RESOLVED * sizes), LEAST_SPAN * sizes, 0.0))
