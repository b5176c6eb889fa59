"""Legends of the plots, their words and order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure, SubFigure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.transforms import ScaledTranslation

from rotor_ida.plot.appearance import style
from rotor_ida.plot.labels import KIND_WORDS

# Where a legend under the axes begins, clear of ticks and label [point].
BELOW = 36.0
# Part of a figure that a legend below one picture may take.
CENTRED = 0.85
# Longest legend inside the axes, and size of the least mark in one [point].
MOST_INSIDE, LEGIBLE = 4, 3.0
# Legends use this order, whatever was drawn first.
_ORDER = (
    STABLE := "stable whirl",
    UNSTABLE := "unstable whirl",
    NEUTRAL := "neutral whirl",
    CONTACT_FREE := "contact-free whirl",
    FOLD := "fold",
    HOPF := "Hopf point",
    THRESHOLD := "threshold of instability",
    BEYOND_TOUCH := "beyond a touch, as without contact",
    *KIND_WORDS.values(),
    FROM_REST := "each speed from rest",
    FROM_WHIRL := "each speed from its contact-free whirl",
    FROM_START := "each speed from its start",
    GOING_UP := "speed going up",
    GOING_DOWN := "speed going down",
    BOUNCING_CYCLE := "bouncing cycle",
    FULL_CONTACT_CYCLE := "full-contact cycle",
    ROLLING_CYCLE := "dry whip",
    STABLE_CYCLE := "stable cycle",
    UNSTABLE_CYCLE := "unstable cycle",
    FOLD_OF_CYCLES := "fold of cycles",
    DOUBLING := "period doubling",
    GRAZE := "graze",
    SLIDING := "slip falls to 0",
    DISCONTINUOUS := "multipliers jump",
)


def shared_legend(
    figure: Figure | SubFigure, axes: Sequence[Axes], *, columns: int = 4, outer: bool = True
) -> Legend:
    """Put one legend, without duplicates, under the panels.

    Parameters
    ----------
    figure : Figure
        The figure.
    axes : sequence of Axes
        Its panels; their separate legends are removed.
    columns : int
        Number of columns of the legend; fewer if the figure is too narrow.
    outer : bool
        Whether to label the axes of the outer panels only.

    Examples
    --------
    >>> from rotor_ida.plot import panels
    >>> figure, axes = panels(1, 2)
    >>> lines = [ax.plot([0, 1], label="same") for ax in axes]
    >>> [text.get_text() for text in shared_legend(figure, axes).get_texts()]
    ['same']
    """
    with style():
        legend = _fitting(
            partial(figure.legend, *_entries(axes), loc="outside lower center", handlelength=2.4),
            columns, figure.bbox.width,
        )  # fmt: skip
        for ax in axes:
            own = ax.get_legend()
            if own is not None:
                own.remove()
            if outer:
                ax.label_outer()
    return legend


def own_legend(ax: Axes, *, inside: bool | None = None) -> Legend:
    """Replace the legend of `ax` by one without duplicates.

    By default a long one, which would hide curves, has its place below the label, a short one
    inside the axes.
    """
    handles, labels = _entries([ax])
    if len(handles) <= MOST_INSIDE if inside is None else inside:
        return _legible(ax.legend(handles, labels, handlelength=2.4))
    return legend_below(ax)


def legend_below(ax: Axes, *, columns: int = 3, handles: Sequence[Artist] | None = None) -> Legend:
    """Give `ax` a legend below its label, where it hides nothing, with as many columns as fit."""
    shown, labels = _entries([ax])
    if handles is not None:
        shown, labels = list(handles), [str(handle.get_label()) for handle in handles]
    below = ScaledTranslation(0.0, -BELOW / 72.0, ax.figure.dpi_scale_trans)
    place = ax.get_subplotspec()
    # it is centred below axes that have a label on their left
    room = CENTRED * ax.figure.bbox.width / (place.get_gridspec().ncols if place else 1)
    return _fitting(
        partial(ax.legend, shown, labels, loc="upper center", bbox_to_anchor=(0.5, 0.0),
                bbox_transform=ax.transAxes + below, handlelength=2.0, borderaxespad=0.0),
        columns, room,
    )  # fmt: skip


def _fitting(make: Callable[..., Legend], columns: int, room: float) -> Legend:
    """Return a legend with as many columns as there is room for."""
    for number in range(columns, 0, -1):
        legend = make(ncols=number)
        if number == 1 or legend.get_window_extent().width <= room:
            break
        legend.remove()
    return _legible(legend)


def _legible(legend: Legend) -> Legend:
    """Show dots that are read as lines larger in a legend."""
    for handle in legend.legend_handles:
        if isinstance(handle, Line2D) and handle.get_markersize() < LEGIBLE:
            handle.set_markersize(LEGIBLE)
    return legend


def _entries(axes: Sequence[Axes]) -> tuple[list[Artist], list[str]]:
    handles: dict[str, Artist] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, _as_patch(handle))
    labels = sorted(handles, key=_place)
    return [handles[label] for label in labels], labels


def _as_patch(handle: Artist) -> Artist:
    """Return a band as a patch: Matplotlib 3.10 refuses a band of another part of the figure."""
    if not isinstance(handle, PolyCollection):
        return handle
    edge = np.asarray(handle.get_edgecolor())
    return Patch(
        facecolor=np.asarray(handle.get_facecolor())[0], hatch=handle.get_hatch(),
        edgecolor=edge[0] if len(edge) else "none",
        linewidth=np.asarray(handle.get_linewidth())[0],
    )  # fmt: skip


def _place(label: str) -> int:
    """Return the position of a label in a legend, from its text before a colon."""
    word = label.partition(":")[0]
    return _ORDER.index(word) if word in _ORDER else len(_ORDER)
