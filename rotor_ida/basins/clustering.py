"""Which of the orbits that no set has captured are on the same attractor."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from rotor_ida.basins.batches import Undecided
from rotor_ida.basins.features import MEAN_X, MEAN_Y, RADIUS_MAX, RADIUS_MIN
from rotor_ida.basins.known_attractors import KnownAttractors
from rotor_ida.parameters import Rotor
from rotor_ida.sweeps.response import BOUNCING, FULL_CONTACT, LASTING, PATIENCE, SLIGHT
from rotor_ida.sweeps.steady_state import durations

Numbers = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Limits = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]

# Two orbits are on the same attractor when their extreme radii differ by no more than this many
# times what they differ from one window to the next, or than the accuracy of a window.
SCATTERS = 3.0
ACCURACY = 1e-3
# Orbits compared each with each; the others join the nearest of these.
COMPARED = 1500
ROUNDS = 5
# Groups that are looked for.
MOST_GROUPS = 16


def slighter_and_slighter(ends: KnownAttractors, left: Undecided) -> Mask:
    """Return which orbits are contact-free whirls but for the slightest touches.

    Each touch pushes the centre inwards, so the next one is slighter. It goes on for ever, too
    slowly for any window to tell it from bouncing.
    """
    if not ends.has_free:
        return np.zeros(left.numbers.size, dtype=np.bool_)
    wx, wy, _ = ends.free
    strays = np.hypot(left.later[:, MEAN_X] - wx, left.later[:, MEAN_Y] - wy)
    depth = left.later[:, RADIUS_MAX] - ends.rotor.delta0
    return np.asarray((depth <= SLIGHT) & (strays <= SLIGHT))


def groups(rotor: Rotor, left: Undecided, open_: Mask) -> tuple[list[str], list[Numbers]]:
    """Return kinds and members of the groups of lasting motions, largest first."""
    found: list[tuple[str, Numbers]] = []
    for kind, candidates in lasting(rotor, left, open_).items():
        found += [(kind, candidates[members]) for members in _cluster(left, candidates)]
    found.sort(key=lambda group: -group[1].size)
    return [kind for kind, _ in found[:MOST_GROUPS]], [each for _, each in found[:MOST_GROUPS]]


def lasting(rotor: Rotor, left: Undecided, open_: Mask) -> dict[str, Numbers]:
    """Return by kind the orbits whose motion keeps its swing from one window to the next."""
    touches, swings = zip(
        *(_swing(rotor, look) for look in (left.earlier, left.later)), strict=True
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = swings[1] / swings[0]
    lasts = (ratio >= LASTING) & (ratio <= 1.0 / LASTING) & (touches[0] == touches[1])
    lasts &= swings[1] > ACCURACY * left.later[:, RADIUS_MAX]
    lasts &= open_ & (rotor.zeta * durations(rotor)[0] >= PATIENCE)
    lasts &= left.later[:, RADIUS_MAX] > rotor.delta0
    return {
        BOUNCING: np.flatnonzero(lasts & touches[1]),
        FULL_CONTACT: np.flatnonzero(lasts & ~touches[1]),
    }


def _swing(rotor: Rotor, look: npt.NDArray[np.float32]) -> tuple[Mask, npt.NDArray[np.float32]]:
    """Return which orbits touch the ring, and what tells whether their motion dies away."""
    low, high = look[:, RADIUS_MIN], look[:, RADIUS_MAX]
    touches = (low < rotor.delta0) & (high > rotor.delta0)
    return touches, np.where(touches, high - np.float32(rotor.delta0), high - low)


def _cluster(left: Undecided, candidates: Numbers) -> list[Numbers]:
    """Return groups of candidates whose extreme radii hang together."""
    later, reach = extremes(left.later[candidates]), reach_of(left, candidates)
    group = np.full(candidates.size, -1, dtype=np.int64)
    random = np.random.default_rng(0)
    for _ in range(ROUNDS):
        rest = np.flatnonzero(group < 0)
        if not rest.size:
            break
        some = random.choice(rest, min(COMPARED, rest.size), replace=False)
        apart = np.abs(later[some, None] - later[None, some]).max(axis=2)
        linked = apart <= np.maximum(reach[some, None], reach[None, some])
        _, members = connected_components(linked, directed=False)
        group[some] = group.max() + 1 + members
        others = np.flatnonzero(group < 0)
        distance, nearest = KDTree(later[some]).query(later[others], p=np.inf)
        joins = distance <= np.maximum(reach[others], reach[some[nearest]])
        group[others[joins]] = group[some[nearest[joins]]]
    return [np.flatnonzero(group == number) for number in range(int(group.max(initial=-1)) + 1)]


def extremes(look: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
    """Return smallest and largest radius of each orbit over a window, shape (n, 2) [1]."""
    return look[:, [RADIUS_MIN, RADIUS_MAX]].astype(np.float64)


def reach_of(left: Undecided, candidates: Numbers) -> npt.NDArray[np.float64]:
    """Return how far another orbit may be for both to be on the same attractor [1]."""
    earlier, later = extremes(left.earlier[candidates]), extremes(left.later[candidates])
    return np.asarray(
        SCATTERS * (np.abs(later - earlier).max(axis=1, initial=0.0) + ACCURACY * later[:, 1])
    )


def also_in(left: Undecided, limits: Limits, open_: Mask) -> Mask:
    """Return which orbits have both windows within the limits of a group.

    Of a chaotic motion some windows differ so much that they do not look lasting one by one.
    """
    low, high = limits
    looks = [look[:, [RADIUS_MIN, RADIUS_MAX]] for look in (left.earlier, left.later)]
    inside = [((look >= low) & (look <= high)).all(axis=1) for look in looks]
    return np.asarray(open_ & inside[0] & inside[1])


def limits_of(left: Undecided, members: Numbers) -> Limits:
    """Return the least and the largest extreme radii of a group's windows [1]."""
    looks = [look[members][:, [RADIUS_MIN, RADIUS_MAX]] for look in (left.earlier, left.later)]
    return (
        np.minimum(*(look.min(axis=0) for look in looks)),
        np.maximum(*(look.max(axis=0) for look in looks)),
    )
