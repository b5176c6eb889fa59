"""How many labels a tighter tolerance gives too: measured on a few starts of each batch.

No region proves where a start ends that had to be integrated to reach it: near the boundary of a
basin an error of a step decides. So a few of the starts that have a label are followed again from
their beginning, with a smaller error, against the same regions. Which they are depends only on how
many there are, so the result is the same, bit for bit, whoever follows them.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.basins.kernel import Labels, Times
from rotor_ida.basins.known import Known
from rotor_ida.parallel import Stop

# One of so many batches is looked at,
ONE_BATCH_OF = 8
# and one of so many of its starts is followed again: less than a twentieth of the time; fewer at a
# time would leave lanes of the kernel idle.
ONE_START_OF = 12
# Of a rotor of an atlas one start of so many is,
ONE_OF_ROTOR = 32
# but no more than so many.
MOST_OF_ROTOR = 32
# They are followed with this part of the error that was allowed in a step,
TIGHTER = 1e-4
# but never with less than doubles hold.
TIGHTEST = 1e-13
# Not for longer [1]: who is held later is told by neither.
LONGEST = 4000.0
# Parts of it lie evenly, and in step with no grid.
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def tighter_than(tolerance: float) -> float:
    """Return the error in a step with which starts are followed again.

    Examples
    --------
    >>> tighter_than(1e-6), tighter_than(1e-11)
    (1e-10, 1e-13)
    """
    return float(max(TIGHTER * tolerance, TIGHTEST))


def rechecked_of_batch(number: int, size: int) -> int:
    """Return how many starts of a batch with this number and size are followed again."""
    return 0 if number % ONE_BATCH_OF else math.ceil(size / ONE_START_OF)


def rechecked_of_rotor(starts: int) -> int:
    """Return how many of all starts of a rotor are followed again, where they are one batch."""
    return min(math.ceil(starts / ONE_OF_ROTOR), MOST_OF_ROTOR)


def count_agreeing(
    known: Known, states: Values, labels: Labels, times: Times, tolerance: float, rechecked: int,
    stop: Stop,
) -> npt.NDArray[np.int64]:  # fmt: skip
    """Return how many starts were labelled again, and how many of them got the same label.

    So many are chosen of the n starts, shape (4, n), but those without an attractor are left out.
    None is followed for longer again than the longest of them was.
    """
    chosen = _spread(labels.size, rechecked)
    chosen = chosen[labels[chosen] >= 0]
    if not chosen.size or stop[0]:
        return np.zeros(2, dtype=np.int64)
    duration = min(max(float(times[chosen].max()), known.first_wait), LONGEST)
    again, _ = known.follow(
        np.ascontiguousarray(states[:, chosen]), duration, tighter_than(tolerance), stop
    )
    held = again >= 0
    return np.array([held.sum(), (again == labels[chosen])[held].sum()])


def _spread(count: int, few: int) -> npt.NDArray[np.int64]:
    """Return the numbers of a few of so many starts, spread evenly and in step with no grid."""
    places = np.arange(1, few + 1) * GOLDEN % 1.0
    return np.unique((count * places).astype(np.int64))
