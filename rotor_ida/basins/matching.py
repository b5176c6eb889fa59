"""Match undecided orbits to attractors: whirls that they approach, or the nearest features."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from rotor_ida.basins.batches import Undecided
from rotor_ida.basins.clustering import (
    LASTING,
    Numbers,
    extreme_radii,
    lasting,
    limits_of,
    matching_distance,
    touching,
    within,
)
from rotor_ida.basins.features import MEAN_X, MEAN_Y, WANDER
from rotor_ida.basins.kernel import UNDECIDED
from rotor_ida.basins.known_attractors import KnownAttractors

Labels = npt.NDArray[np.int16]

# An orbit that is this close to a whirl, relative to its amplitude, and closer than before
# approaches it, even if no trapping region holds it yet.
NEAR = 0.02


def approaching(known: KnownAttractors, orbits: Undecided) -> npt.NDArray[np.int16]:
    """Return the labels of orbits that approach a stable whirl, UNDECIDED for the others."""
    if known.rotor.omega == 0.0:  # energy only falls: everything comes to rest
        return np.zeros(orbits.numbers.size, dtype=np.int16)
    labels = np.full(orbits.numbers.size, UNDECIDED, dtype=np.int16)
    for number, each in enumerate(known.regions):
        distance = [
            np.hypot(window[:, MEAN_X] - each.centre[0], window[:, MEAN_Y] - each.centre[1])
            + window[:, WANDER]
            for window in (orbits.earlier, orbits.later)
        ]
        near = (distance[1] <= NEAR * each.amplitude) & (distance[1] <= LASTING * distance[0])
        still = distance[1] <= 1e-5 * each.amplitude
        labels[near | still] = number
    return labels


class NearestFeatures:
    """Orbits whose attractors are known: others are matched to those with the nearest features.

    Parameters
    ----------
    known : KnownAttractors
        The rotor and the attractors that closed forms give.
    orbits : Undecided
        The orbits whose attractors are known.
    labels : ndarray of int16, shape (n,)
        Their labels.
    """

    def __init__(self, known: KnownAttractors, orbits: Undecided, labels: Labels) -> None:
        self._known = known
        first = len(known.regions) + known.has_free
        in_clusters = labels >= first
        self._kinds = {}
        self._limits = {}
        for kind, members in lasting(known.rotor, orbits, in_clusters).items():
            if members.size:
                tree = KDTree(extreme_radii(orbits.later[members]))
                self._kinds[kind] = (tree, matching_distance(orbits, members), labels[members])
            for number in np.unique(labels[members]).tolist():
                self._limits[number] = limits_of(orbits, members[labels[members] == number])

    def labels_of(self, orbits: Undecided) -> Labels:
        """Return the labels of other orbits: each that of the orbit with the nearest features."""
        labels = approaching(self._known, orbits)
        unmatched = (labels == UNDECIDED) & ~touching(self._known, orbits)
        for kind, candidates in lasting(self._known.rotor, orbits, unmatched).items():
            labels[candidates] = self._nearest(kind, orbits, candidates)
        for number, limits in self._limits.items():
            labels[within(orbits, limits, unmatched & (labels == UNDECIDED))] = number
        return labels

    def _nearest(self, kind: str, orbits: Undecided, candidates: Numbers) -> Labels:
        if kind not in self._kinds or not candidates.size:
            return np.full(candidates.size, UNDECIDED, dtype=np.int16)
        tree, reach, labels = self._kinds[kind]
        distance, place = tree.query(extreme_radii(orbits.later[candidates]), p=np.inf)
        near = distance <= np.maximum(matching_distance(orbits, candidates), reach[place])
        return np.where(near, labels[place], np.int16(UNDECIDED))
