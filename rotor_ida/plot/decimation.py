"""Reduce points without changing the picture."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from rotor_ida.arrays import Values

# A figure across a page has about 1400 dots at 200 to the inch.
COLUMNS = 2000
CELLS = 3000
# Up to this many points are drawn unchanged.
FEW = 20_000
# A thinned path of more points than this is written as dots.
MANY = 60_000


def kept_in_columns(times: Values, values: Values, columns: int = COLUMNS) -> npt.NDArray[np.intp]:
    """Return the samples that draw the same line as all of them.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Times, which increase.
    values : ndarray, shape (n,)
        Values without NaN.
    columns : int
        Number of columns of dots that the line is drawn on.

    Returns
    -------
    ndarray of int
        The first, the last, the smallest and the largest sample of each column.

    References
    ----------
    U. Jugel, Z. Jerzak, G. Hackenbroich, V. Markl, "M4: a visualization-oriented time series data
    aggregation", Proceedings of the VLDB Endowment 7, 2014.

    Examples
    --------
    >>> times = np.arange(100_000.0)
    >>> spiked = np.where(times == 31_415.0, 1.0, 0.0)
    >>> kept = kept_in_columns(times, spiked)
    >>> kept.size <= 4 * COLUMNS, spiked[kept].max().item()
    (True, 1.0)
    """
    if times.size <= FEW:
        return np.arange(times.size)
    part = (times - times[0]) / (times[-1] - times[0])
    column = np.minimum((part * columns).astype(np.intp), columns - 1)
    starts = np.flatnonzero(np.diff(column, prepend=-1))
    counts = np.diff(starts, append=times.size)
    kept = [starts, starts + counts - 1]
    for extreme in (np.minimum, np.maximum):
        reached = np.flatnonzero(values == np.repeat(extreme.reduceat(values, starts), counts))
        kept.append(reached[np.unique(column[reached], return_index=True)[1]])
    return np.unique(np.concatenate(kept))


def draw_over_time(ax: Axes, times: Values, values: Values, **line: Any) -> None:
    """Draw a line over time, of many samples those that make a difference in print."""
    kept = kept_in_columns(times, values)
    ax.plot(times[kept], values[kept], **line)


def thinned(x: Values, y: Values, cells: int = CELLS) -> tuple[Values, Values]:
    """Return a path that passes through the same cells of a fine grid, each step once.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Points of the path; NaN breaks it.
    cells : int
        Cells of the grid across the path, smaller than the dots of a figure.

    Returns
    -------
    x, y : ndarray
        Points of the path, NaN where steps are left out. A point that enters a cell stays, so no
        excursion wider than a cell is lost. A repeated step between two cells is left out, because
        it would be drawn over itself.

    Examples
    --------
    >>> turn = np.linspace(0.0, 200.0 * np.pi, 100_001)
    >>> x, y = thinned(np.cos(turn), np.sin(turn))
    >>> x.size < 2000, np.nanmax(np.hypot(x, y)).round(9).item()
    (True, 1.0)
    """
    if x.size <= FEW:
        return x, y
    low = np.array([np.nanmin(x), np.nanmin(y)])
    width = max(float(np.nanmax(x)) - low[0], float(np.nanmax(y)) - low[1]) or 1.0
    gone = ~np.isfinite(x + y)
    cell_x, cell_y = (
        np.where(gone, -1.0, np.floor((values - start) / width * cells))
        for values, start in ((x, low[0]), (y, low[1]))
    )
    cell = (cell_x * (cells + 2) + cell_y).astype(np.int64)
    kept = np.flatnonzero(np.diff(cell, prepend=-10))
    cell, x, y = cell[kept], x[kept], y[kept]
    ends = np.sort(np.stack([cell[:-1], cell[1:]]), axis=0)
    _, first = np.unique(ends[0] * (cells + 2) ** 2 + ends[1], return_index=True)
    drawn = np.zeros(cell.size, dtype=bool)
    drawn[first] = True
    drawn[:-1] &= (cell[:-1] >= 0) & (cell[1:] >= 0)
    shown = drawn | np.append(False, drawn[:-1])
    # a point that ends one step without beginning the next is followed by a gap
    last = np.flatnonzero(shown & ~drawn) + 1
    places = np.insert(np.arange(x.size), last, -1)
    stays = np.insert(shown, last, True)
    places = places[stays]
    return tuple(np.where(places < 0, np.nan, each[places]) for each in (x, y))  # type: ignore[return-value]


def draw_path(ax: Axes, x: Values, y: Values, **line: Any) -> None:
    """Draw a path as a line, of dots if it has very many points."""
    x, y = thinned(x, y)
    ax.plot(x, y, rasterized=x.size > MANY, **line)
