"""Results of the starts that were followed, batch by batch."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.results.studies.arrays import Arrays
from rotor_ida.results.studies.results import Form

# What is kept of a limit cycle: state, period, and 1 where a section of it holds starts.
CYCLE = 6
# And of a chaotic or quasi-periodic motion: amplitude, phase lag, smallest and largest radius.
MOTION = 4


@dataclass(slots=True)
class BatchResult:
    """Results of a batch of starts.

    Parameters
    ----------
    first : int
        Number of its first start.
    labels : ndarray of int16, shape (n,)
        Label of the attractor, ROLLING, CHAOTIC, QUASI_PERIODIC, UNDECIDED or NOT_COMPUTED; those
        of limit cycles number the rows of `cycles`.
    times : ndarray of float32, shape (n,)
        Time at which the start was decided, or given up [1]; NaN where not computed.
    cycles : ndarray, shape (m, 6)
        State, period, and whether a section holds starts, of each limit cycle that was known [1].
    chaos : ndarray, shape (k, 4)
        Amplitude, phase lag and extreme radii of a chaotic motion, if it met any [1].
    watched : ndarray, shape (2,)
        Number of orbits that left a chaotic motion while this was watched, and for how long all of
        them together were watched [1].
    tolerance : ndarray, shape ()
        Error allowed in a step [1].
    rechecked : ndarray of int64, shape (2,)
        Number of starts labelled again with a smaller error, and of those with the same label.
    torus : ndarray, shape (k, 4)
        As `chaos`, of a quasi-periodic motion [1].
    rolling : ndarray, shape (k, 4)
        As `chaos`, of a motion that rolls without a period [1].
    """

    first: int
    labels: npt.NDArray[np.int16]
    times: npt.NDArray[np.float32]
    cycles: Values
    chaos: Values
    watched: Values
    tolerance: Values
    rechecked: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(2, dtype=np.int64))
    torus: Values = field(default_factory=lambda: np.empty((0, MOTION)))
    rolling: Values = field(default_factory=lambda: np.empty((0, MOTION)))


def _as_arrays(batch: BatchResult) -> Arrays:
    return {each.name: np.asarray(getattr(batch, each.name)) for each in fields(batch)}


def _from_arrays(arrays: Arrays) -> BatchResult:
    return BatchResult(int(arrays.pop("first")), **arrays)


FORM = Form("batch of starts", _as_arrays, _from_arrays)
