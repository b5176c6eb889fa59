"""Figures of several panels that differ, and the looks that tell several curves apart."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.checks import check_count
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import BLUE, INK, ORANGE, PURPLE, RED, style

# Colour and dashes, so that the curves stay apart without colour too.
LOOKS: tuple[tuple[str, object], ...] = (
    (INK, "-"),
    (BLUE, (0, (6, 1.8))),
    (ORANGE, (0, (1.2, 1.4))),
    (PURPLE, (0, (6, 1.6, 1.2, 1.6))),
    (RED, (0, (3, 1.2))),
)


def mixed_panels(
    rows: int,
    columns: int,
    *,
    width: float = 7.2,
    height: float = 5.6,
    solid: Sequence[int] = (),
) -> tuple[Figure, list[Axes]]:
    """Return a figure with lettered panels, each with axes of its own.

    Parameters
    ----------
    rows, columns : int
        Number of panels down and across.
    width, height : float
        Size of the figure [inch].
    solid : sequence of int
        Numbers of the panels, row by row from 0, that are three-dimensional.

    Returns
    -------
    figure : Figure
        The figure.
    axes : list of Axes
        Its panels, row by row.

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
            raise InputError(f"solid must hold numbers of panels below {number}, got {place!r}")
    with style():
        figure = Figure(figsize=(width, height), layout="constrained")
        axes = [
            figure.add_subplot(
                rows, columns, place + 1, projection="3d" if place in solid else None
            )
            for place in range(number)
        ]
        for place, ax in enumerate(axes):
            if number > 1:
                ax.set_title(chr(ord("a") + place), loc="left", fontweight="bold")
    return figure, axes


def look(number: int) -> tuple[str, object]:
    """Return colour and line of the curve with this number; they come round again after five."""
    return LOOKS[number % len(LOOKS)]
