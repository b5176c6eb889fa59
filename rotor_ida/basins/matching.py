"""Sort undecided orbits: on their way to a whirl, or like others whose attractor is known."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from rotor_ida.basins.batches import Undecided
from rotor_ida.basins.clustering import (
    Numbers,
    also_in,
    extremes,
    lasting,
    limits_of,
    reach_of,
    slighter_and_slighter,
)
from rotor_ida.basins.features import MEAN_X, MEAN_Y, WANDER
from rotor_ida.basins.kernel import UNDECIDED
from rotor_ida.basins.known_attractors import KnownAttractors
from rotor_ida.sweeps.response import LASTING

Labels = npt.NDArray[np.int16]

# An orbit this close to a whirl, as a part of its amplitude, and closer than before, is on its way
# there even if no trapping region holds it yet.
NEAR = 0.02


def on_their_way(ends: KnownAttractors, left: Undecided) -> npt.NDArray[np.int16]:
    """Return the labels of orbits that creep towards a stable whirl, UNDECIDED for the others."""
    if ends.rotor.omega == 0.0:  # energy only falls: everything comes to rest
        return np.zeros(left.numbers.size, dtype=np.int16)
    labels = np.full(left.numbers.size, UNDECIDED, dtype=np.int16)
    for number, each in enumerate(ends.sets):
        distance = [
            np.hypot(look[:, MEAN_X] - each.centre[0], look[:, MEAN_Y] - each.centre[1])
            + look[:, WANDER]
            for look in (left.earlier, left.later)
        ]
        near = (distance[1] <= NEAR * each.amplitude) & (distance[1] <= LASTING * distance[0])
        still = distance[1] <= 1e-5 * each.amplitude
        labels[near | still] = number
    return labels


class Examples:
    """Orbits that were sorted into attractors, by which many more are sorted one part at a time.

    Parameters
    ----------
    ends : KnownAttractors
        The rotor and its trapping regions.
    sorted_ : Undecided
        The orbits.
    labels : ndarray of int16, shape (n,)
        Their labels.
    """

    def __init__(self, ends: KnownAttractors, sorted_: Undecided, labels: Labels) -> None:
        self._ends = ends
        first = len(ends.sets) + ends.has_free
        in_groups = labels >= first
        self._kinds = {}
        self._limits = {}
        for kind, members in lasting(ends.rotor, sorted_, in_groups).items():
            if members.size:
                tree = KDTree(extremes(sorted_.later[members]))
                self._kinds[kind] = (tree, reach_of(sorted_, members), labels[members])
            for number in np.unique(labels[members]).tolist():
                self._limits[number] = limits_of(sorted_, members[labels[members] == number])

    def labels_of(self, left: Undecided) -> Labels:
        """Return the labels of other orbits: each that of the orbit most like it."""
        mine = on_their_way(self._ends, left)
        open_ = (mine == UNDECIDED) & ~slighter_and_slighter(self._ends, left)
        for kind, candidates in lasting(self._ends.rotor, left, open_).items():
            mine[candidates] = self._nearest(kind, left, candidates)
        for number, limits in self._limits.items():
            mine[also_in(left, limits, open_ & (mine == UNDECIDED))] = number
        return mine

    def _nearest(self, kind: str, left: Undecided, candidates: Numbers) -> Labels:
        if kind not in self._kinds or not candidates.size:
            return np.full(candidates.size, UNDECIDED, dtype=np.int16)
        tree, reach, labels = self._kinds[kind]
        distance, place = tree.query(extremes(left.later[candidates]), p=np.inf)
        near = distance <= np.maximum(reach_of(left, candidates), reach[place])
        return np.where(near, labels[place], np.int16(UNDECIDED))
