"""Which of the orbits that no set has captured are on the same attractor."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from rotor_ida.basins.survey import Survey, Undecided
from rotor_ida.basins.windows import MEAN_X, MEAN_Y, RADIUS_MAX, RADIUS_MIN
from rotor_ida.parameters import Rotor
from rotor_ida.response import BOUNCING, FULL_CONTACT, LASTING, PATIENCE
from rotor_ida.settling import durations

Numbers = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

# Two orbits are on the same attractor when their extreme radii differ by no more than this many
# times what they differ from one window to the next, or than the accuracy of a window.
SCATTERS = 3.0
ACCURACY = 1e-3
# Orbits compared each with each; the others join the nearest of these.
COMPARED = 1500
ROUNDS = 5
# Groups that are looked for.
MOST_GROUPS = 16
# Indentations so slight, and mean whirls so near to the contact-free one, are of an orbit that
# leaves the ring through ever slighter touches.
SLIGHT = 0.01


def slighter_and_slighter(survey: Survey, left: Undecided) -> Mask:
    """Return which orbits are contact-free whirls but for the slightest touches.

    Each touch pushes the centre inwards, so the next one is slighter. It goes on for ever, too
    slowly for any window to tell it from bouncing.
    """
    if not survey.ends.has_free:
        return np.zeros(left.numbers.size, dtype=np.bool_)
    wx, wy, _ = survey.ends.free
    strays = np.hypot(left.later[:, MEAN_X] - wx, left.later[:, MEAN_Y] - wy)
    depth = left.later[:, RADIUS_MAX] - survey.ends.rotor.delta0
    return np.asarray((depth <= SLIGHT) & (strays <= SLIGHT))


def groups(rotor: Rotor, left: Undecided, open_: Mask) -> tuple[list[str], list[Numbers]]:
    """Return kinds and members of the groups of lasting motions, largest first."""
    touches, swings = zip(
        *(_swing(rotor, look) for look in (left.earlier, left.later)), strict=True
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = swings[1] / swings[0]
    lasts = (ratio >= LASTING) & (ratio <= 1.0 / LASTING) & (touches[0] == touches[1])
    lasts &= swings[1] > ACCURACY * left.later[:, RADIUS_MAX]
    lasts &= open_ & (rotor.zeta * durations(rotor)[0] >= PATIENCE)
    found: list[tuple[str, Numbers]] = []
    for kind, touching in ((BOUNCING, True), (FULL_CONTACT, False)):
        in_contact = left.later[:, RADIUS_MAX] > rotor.delta0
        candidates = np.flatnonzero(lasts & in_contact & (touches[1] == touching))
        found += [(kind, candidates[members]) for members in _cluster(left, candidates)]
    found.sort(key=lambda group: -group[1].size)
    return [kind for kind, _ in found[:MOST_GROUPS]], [each for _, each in found[:MOST_GROUPS]]


def _swing(rotor: Rotor, look: npt.NDArray[np.float32]) -> tuple[Mask, npt.NDArray[np.float32]]:
    """Return which orbits touch the ring, and what tells whether their motion dies away."""
    low, high = look[:, RADIUS_MIN], look[:, RADIUS_MAX]
    touches = (low < rotor.delta0) & (high > rotor.delta0)
    return touches, np.where(touches, high - np.float32(rotor.delta0), high - low)


def _cluster(left: Undecided, candidates: Numbers) -> list[Numbers]:
    """Return groups of candidates whose extreme radii hang together."""
    earlier = left.earlier[candidates][:, [RADIUS_MIN, RADIUS_MAX]].astype(np.float64)
    later = left.later[candidates][:, [RADIUS_MIN, RADIUS_MAX]].astype(np.float64)
    reach = SCATTERS * (np.abs(later - earlier).max(axis=1, initial=0.0) + ACCURACY * later[:, 1])
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


def also_in(left: Undecided, members: Numbers, open_: Mask) -> Mask:
    """Return which orbits have both windows in the range of a group's windows.

    Of a chaotic motion some windows differ so much that they do not look lasting one by one.
    """
    looks = [look[:, [RADIUS_MIN, RADIUS_MAX]] for look in (left.earlier, left.later)]
    low = np.minimum(*(look[members].min(axis=0) for look in looks))
    high = np.maximum(*(look[members].max(axis=0) for look in looks))
    inside = [((look >= low) & (look <= high)).all(axis=1) for look in looks]
    return np.asarray(open_ & inside[0] & inside[1])
