"""Which of the orbits that no trapping region holds are on the same attractor."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from rotor_ida.basins.batches import Undecided
from rotor_ida.basins.features import MEAN_X, MEAN_Y, RADIUS_MAX, RADIUS_MIN
from rotor_ida.basins.following import PATIENCE
from rotor_ida.basins.known_attractors import KnownAttractors
from rotor_ida.parameters import Rotor
from rotor_ida.sweeps.response import BOUNCING, FULL_CONTACT
from rotor_ida.sweeps.steady_state import durations

Numbers = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Limits = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]

# A motion counts as lasting when its swing stays within this factor from one window to the next.
LASTING = 0.8
# A motion that indents by less than this, with a mean whirl this near to the contact-free one,
# leaves the ring through ever slighter touches.
SLIGHT = 0.01
# Two orbits are on the same attractor when their extreme radii differ by no more than this many
# times their change from one window to the next, plus the accuracy of a window.
SCATTERS = 3.0
ACCURACY = 1e-3
# So many orbits are compared pair by pair; each of the others joins the nearest of these.
COMPARED = 1500
ROUNDS = 5
# Clusters that become attractors: the largest.
MOST_CLUSTERS = 16


def touching(known: KnownAttractors, orbits: Undecided) -> Mask:
    """Return which orbits approach a contact-free whirl through ever slighter touches.

    Each touch pushes the centre inwards, so that the next is slighter. The change is too slow for
    two windows to tell it from bouncing.
    """
    if not known.has_free:
        return np.zeros(orbits.numbers.size, dtype=np.bool_)
    wx, wy, _ = known.free
    strays = np.hypot(orbits.later[:, MEAN_X] - wx, orbits.later[:, MEAN_Y] - wy)
    depth = orbits.later[:, RADIUS_MAX] - known.rotor.delta0
    return np.asarray((depth <= SLIGHT) & (strays <= SLIGHT))


def clusters(rotor: Rotor, orbits: Undecided, unmatched: Mask) -> tuple[list[str], list[Numbers]]:
    """Return kinds and members of the clusters of lasting motions, largest first."""
    found: list[tuple[str, Numbers]] = []
    for kind, candidates in lasting(rotor, orbits, unmatched).items():
        found += [(kind, candidates[members]) for members in _linked(orbits, candidates)]
    found.sort(key=lambda cluster: -cluster[1].size)
    return [kind for kind, _ in found[:MOST_CLUSTERS]], [each for _, each in found[:MOST_CLUSTERS]]


def lasting(rotor: Rotor, orbits: Undecided, unmatched: Mask) -> dict[str, Numbers]:
    """Return, by kind, the orbits whose swing is the same in both windows."""
    touches, swings = zip(
        *(_swing(rotor, window) for window in (orbits.earlier, orbits.later)), strict=True
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = swings[1] / swings[0]
    lasts = (ratio >= LASTING) & (ratio <= 1.0 / LASTING) & (touches[0] == touches[1])
    lasts &= swings[1] > ACCURACY * orbits.later[:, RADIUS_MAX]
    lasts &= unmatched & (rotor.zeta * durations(rotor)[0] >= PATIENCE)
    lasts &= orbits.later[:, RADIUS_MAX] > rotor.delta0
    return {
        BOUNCING: np.flatnonzero(lasts & touches[1]),
        FULL_CONTACT: np.flatnonzero(lasts & ~touches[1]),
    }


def _swing(rotor: Rotor, window: npt.NDArray[np.float32]) -> tuple[Mask, npt.NDArray[np.float32]]:
    """Return which orbits enter and leave contact, and the swing that decays if the motion does."""
    low, high = window[:, RADIUS_MIN], window[:, RADIUS_MAX]
    touches = (low < rotor.delta0) & (high > rotor.delta0)
    return touches, np.where(touches, high - np.float32(rotor.delta0), high - low)


def _linked(orbits: Undecided, candidates: Numbers) -> list[Numbers]:
    """Return the clusters of candidates, linked by the distance of their extreme radii."""
    later, reach = extreme_radii(orbits.later[candidates]), matching_distance(orbits, candidates)
    cluster = np.full(candidates.size, -1, dtype=np.int64)
    random = np.random.default_rng(0)
    for _ in range(ROUNDS):
        rest = np.flatnonzero(cluster < 0)
        if not rest.size:
            break
        some = random.choice(rest, min(COMPARED, rest.size), replace=False)
        apart = np.abs(later[some, None] - later[None, some]).max(axis=2)
        linked = apart <= np.maximum(reach[some, None], reach[None, some])
        _, members = connected_components(linked, directed=False)
        cluster[some] = cluster.max() + 1 + members
        others = np.flatnonzero(cluster < 0)
        distance, nearest = KDTree(later[some]).query(later[others], p=np.inf)
        joins = distance <= np.maximum(reach[others], reach[some[nearest]])
        cluster[others[joins]] = cluster[some[nearest[joins]]]
    return [np.flatnonzero(cluster == number) for number in range(int(cluster.max(initial=-1)) + 1)]


def extreme_radii(features: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
    """Return smallest and largest radius of each orbit over a window, shape (n, 2) [1]."""
    return features[:, [RADIUS_MIN, RADIUS_MAX]].astype(np.float64)


def matching_distance(orbits: Undecided, candidates: Numbers) -> npt.NDArray[np.float64]:
    """Return how far apart the extreme radii of two orbits on one attractor may be [1]."""
    earlier = extreme_radii(orbits.earlier[candidates])
    later = extreme_radii(orbits.later[candidates])
    return np.asarray(
        SCATTERS * (np.abs(later - earlier).max(axis=1, initial=0.0) + ACCURACY * later[:, 1])
    )


def within(orbits: Undecided, limits: Limits, unmatched: Mask) -> Mask:
    """Return which orbits have both windows within the limits of a cluster.

    Two windows of a chaotic motion can differ so much that it does not seem to last.
    """
    low, high = limits
    windows = [window[:, [RADIUS_MIN, RADIUS_MAX]] for window in (orbits.earlier, orbits.later)]
    inside = [((window >= low) & (window <= high)).all(axis=1) for window in windows]
    return np.asarray(unmatched & inside[0] & inside[1])


def limits_of(orbits: Undecided, members: Numbers) -> Limits:
    """Return the least and the largest extreme radii of a cluster's windows [1]."""
    windows = np.stack([orbits.earlier[members], orbits.later[members]])
    radii = windows[..., [RADIUS_MIN, RADIUS_MAX]]
    return radii.min(axis=(0, 1)), radii.max(axis=(0, 1))
