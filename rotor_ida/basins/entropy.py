"""Basin entropy: how uncertain the end of a start is that is known to a small box only.

The starts are split into boxes. In a box whose starts end on attractor j with the frequency p_j the
entropy is ``-sum p_j log p_j``; its mean over all boxes is the basin entropy, over those that hold
more than one end the boundary entropy. Where the boxes are so small that few of them hold three
ends or more, a boundary entropy above log 2 says that the boundary is fractal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.basins.kernel import NOT_COMPUTED, Labels

# A box of a grid is so many starts wide.
WIDTH = 5
# A box of a random sample holds about as many starts as that.
IN_BOX = WIDTH * WIDTH


def grid_entropy(labels: Labels, alike: Sequence[int] = ()) -> tuple[float, float]:
    """Return basin and boundary entropy of a grid of starts, in whole boxes of 5 by 5.

    The labels `alike` count as one.

    References
    ----------
    A. Daza et al., "Basin entropy: a new tool to analyze uncertainty in dynamical systems",
    Scientific Reports 6, 2016, 31416.

    Examples
    --------
    >>> halves = np.zeros((10, 20), dtype=np.int16)
    >>> halves[:, 8:] = 1
    >>> [round(value, 4) for value in grid_entropy(halves)]
    [0.1683, 0.673]
    """
    rows, columns = (size // WIDTH for size in labels.shape)
    if not rows or not columns:
        return math.nan, math.nan
    # one row of boxes at a time: a grid may be larger than memory
    total, mixed, boxes = 0.0, 0, 0
    for row in range(rows):
        strip = labels[row * WIDTH : (row + 1) * WIDTH, : columns * WIDTH]
        own = np.asarray(strip).reshape(WIDTH, columns, WIDTH).swapaxes(0, 1)
        entropies = _entropies(own.reshape(columns, IN_BOX), alike)
        total += float(np.nansum(entropies))
        mixed += int((entropies > 0.0).sum())
        boxes += int(np.isfinite(entropies).sum())
    return _means(total, mixed, boxes)


def sample_entropy(
    states: Values, labels: Labels, alike: Sequence[int] = ()
) -> tuple[float, float]:
    """Return basin and boundary entropy of random starts, in boxes of about 25 of them.

    The boxes come from halving the sample at the median of one component after the other: each
    holds as much of the distribution as any other, whatever it is. States have the shape (4, n),
    and the labels `alike` count as one.
    """
    varied = states[np.ptp(states, axis=1) > 0.0]
    if labels.size < IN_BOX or not varied.size:
        return math.nan, math.nan
    boxes = [np.arange(labels.size)]
    for turn in range(round(math.log2(labels.size / IN_BOX))):
        component = varied[turn % len(varied)]
        boxes = [
            half for box in boxes
            for half in np.array_split(box[np.argsort(component[box], kind="stable")], 2)
        ]  # fmt: skip
    widest = max(box.size for box in boxes)
    table = np.full((len(boxes), widest), NOT_COMPUTED, dtype=np.int16)
    for row, box in zip(table, boxes, strict=True):
        row[: box.size] = labels[box]
    entropies = _entropies(table, alike)
    own = entropies[np.isfinite(entropies)]
    return _means(float(own.sum()), int((own > 0.0).sum()), own.size)


def _entropies(boxes: Labels, alike: Sequence[int]) -> Values:
    """Return the entropy of each row of labels; NaN where one has none that was computed."""
    if len(alike) > 1:
        boxes = np.where(np.isin(boxes, alike), alike[0], boxes)
    known = boxes != NOT_COMPUTED
    total = known.sum(axis=1)
    entropies = np.where(total > 0, 0.0, np.nan)
    for label in np.unique(boxes[known]).tolist():
        part = (boxes == label).sum(axis=1) / np.maximum(total, 1)
        entropies -= part * np.log(np.where(part > 0.0, part, 1.0))
    return entropies


def _means(total: float, mixed: int, boxes: int) -> tuple[float, float]:
    """Return the mean over all boxes, and over those with more than one end."""
    if not boxes:
        return math.nan, math.nan
    return total / boxes, total / mixed if mixed else 0.0
