"""Which attractors there are, and which start ends on which."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from rotor_ida.basins.kernel import UNDECIDED
from rotor_ida.basins.survey import Survey, Undecided
from rotor_ida.basins.windows import MEAN_X, MEAN_Y, RADIUS_MAX, RADIUS_MIN, WANDER
from rotor_ida.checks import State
from rotor_ida.parameters import Rotor
from rotor_ida.response import BOUNCING, CONTACT_FREE, FULL_CONTACT, LASTING, PATIENCE, SYNCHRONOUS
from rotor_ida.settling import Settled, durations, settle
from rotor_ida.simulator.options import Options

Values = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

# Two orbits are on the same attractor when their extreme radii differ by no more than this many
# times what they differ from one window to the next, or than the accuracy of a window.
SCATTERS = 3.0
ACCURACY = 1e-3
# Orbits compared each with each; the others join the nearest of these.
COMPARED = 1500
ROUNDS = 5
# Attractors that are looked for beside the synchronous ones; and how many orbits of each CVODE is
# asked about before the attractor is doubted.
MOST_GROUPS = 16
WITNESSES = 3
# An orbit this close to a whirl, as a part of its amplitude, and closer than before, is on its way
# there even if no capture set holds it yet.
NEAR = 0.02
# Indentations so slight, and mean whirls so near to the contact-free one, are of an orbit that
# leaves the ring through ever slighter touches.
SLIGHT = 0.01
# Numbers from CVODE and from the kernel agree within this part.
AGREEMENT = 0.02


@dataclass(frozen=True, slots=True)
class Attractor:
    """One attractor.

    Parameters
    ----------
    kind : str
        One of the kinds of `rotor_ida.response`.
    amplitude, phase_lag : float
        Of the motion at the spin speed [1], [rad]; NaN where it depends on the start.
    radius_min, radius_max : float
        Smallest and largest distance from the bearing axis [1]; NaN where it depends on the start.
    confirmed : bool
        Whether CVODE has followed an orbit to it; the numbers are then CVODE's.
    """

    kind: str
    amplitude: float
    phase_lag: float
    radius_min: float
    radius_max: float
    confirmed: bool = False


def attractors_of(survey: Survey, starts: Values, options: Options) -> list[Attractor]:
    """Sort the undecided starts of a survey into attractors, and confirm every attractor.

    Parameters
    ----------
    survey : Survey
        What became of the starts; its labels are changed to the numbers of the attractors in the
        list returned.
    starts : ndarray, shape (m, 4)
        For each capture set and for the contact-free whirl a start that it has captured, NaN where
        there is none [1].
    options : Options
        How CVODE is to confirm.
    """
    known = _known(survey)
    if not survey.interrupted:
        known = [
            _confirm_known(survey.ends.rotor, attractor, start, options)
            for attractor, start in zip(known, starts, strict=True)
        ]
    left = survey.undecided
    mine = survey.labels[left.numbers]
    mine[:] = _on_their_way(survey, left)
    open_ = (mine == UNDECIDED) & ~_slighter_and_slighter(survey, left)
    kinds, groups = _groups(survey.ends.rotor, left, open_)
    found: list[Attractor] = []
    for kind, members in zip(kinds, groups, strict=True):
        seen: Attractor | None = _described(kind, left, members)
        if seen is not None and not survey.interrupted:
            seen = _confirm(survey.ends.rotor, seen, left, members, options)
        if seen is None:
            continue
        number = _same(seen, found)
        if number is None:
            number = len(found)
            found.append(seen)
        mine[members] = len(known) + number
        mine[_also_in(left, members, open_ & (mine == UNDECIDED))] = len(known) + number
    survey.labels[left.numbers] = mine
    return known + found


def _known(survey: Survey) -> list[Attractor]:
    """Return the attractors that the closed forms tell."""
    rotor = survey.ends.rotor
    kind = CONTACT_FREE if rotor.omega == 0.0 else SYNCHRONOUS
    known = [
        Attractor(kind, each.amplitude, each.phase_lag, each.amplitude, each.amplitude)
        for each in survey.ends.sets
    ]
    if survey.ends.has_free:
        whirl = complex(survey.ends.free[0], survey.ends.free[1])
        lag = math.atan2(-whirl.imag, whirl.real) if whirl else 0.0
        known.append(Attractor(CONTACT_FREE, abs(whirl), lag, math.nan, math.nan))
    return known


def _confirm_known(
    rotor: Rotor, attractor: Attractor, start: Values, options: Options
) -> Attractor:
    """Let CVODE follow one start that a capture set has caught."""
    if not np.isfinite(start).all():
        return attractor
    settled = settle(rotor, _state(start), options)
    window = settled.window
    if window is None or settled.response != attractor.kind:
        return attractor
    if settled.response == CONTACT_FREE:
        return replace(attractor, confirmed=True)
    if abs(window.amplitude - attractor.amplitude) > AGREEMENT * attractor.amplitude:
        return attractor
    return _with_numbers_of(settled, attractor)


def _on_their_way(survey: Survey, left: Undecided) -> npt.NDArray[np.int16]:
    """Return the labels of orbits that creep towards a stable whirl, UNDECIDED for the others."""
    if survey.ends.rotor.omega == 0.0:  # energy only falls: everything comes to rest
        return np.zeros(left.numbers.size, dtype=np.int16)
    labels = np.full(left.numbers.size, UNDECIDED, dtype=np.int16)
    for number, each in enumerate(survey.ends.sets):
        distance = [
            np.hypot(look[:, MEAN_X] - each.centre[0], look[:, MEAN_Y] - each.centre[1])
            + look[:, WANDER]
            for look in (left.earlier, left.later)
        ]
        near = (distance[1] <= NEAR * each.amplitude) & (distance[1] <= LASTING * distance[0])
        still = distance[1] <= 1e-5 * each.amplitude
        labels[near | still] = number
    return labels


def _slighter_and_slighter(survey: Survey, left: Undecided) -> Mask:
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


def _groups(rotor: Rotor, left: Undecided, open_: Mask) -> tuple[list[str], list[Numbers]]:
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


def _also_in(left: Undecided, members: Numbers, open_: Mask) -> Mask:
    """Return which orbits have both windows in the range of a group's windows.

    Of a chaotic motion some windows differ so much that they do not look lasting one by one.
    """
    looks = [look[:, [RADIUS_MIN, RADIUS_MAX]] for look in (left.earlier, left.later)]
    low = np.minimum(*(look[members].min(axis=0) for look in looks))
    high = np.maximum(*(look[members].max(axis=0) for look in looks))
    inside = [((look >= low) & (look <= high)).all(axis=1) for look in looks]
    return np.asarray(open_ & inside[0] & inside[1])


def _described(kind: str, left: Undecided, members: Numbers) -> Attractor:
    """Return an attractor as the kernel saw it, in the middle of its orbits."""
    middle = np.median(left.later[members].astype(np.float64), axis=0)
    mean = complex(middle[MEAN_X], middle[MEAN_Y])
    lag = math.atan2(-mean.imag, mean.real)
    return Attractor(kind, abs(mean), lag, float(middle[RADIUS_MIN]), float(middle[RADIUS_MAX]))


def _confirm(
    rotor: Rotor, attractor: Attractor, left: Undecided, members: Numbers, options: Options
) -> Attractor | None:
    """Let CVODE follow the orbits nearest to the middle; None if it sees something else."""
    extremes = left.later[members][:, [RADIUS_MIN, RADIUS_MAX]].astype(np.float64)
    middle = np.array([attractor.radius_min, attractor.radius_max])
    spread = np.ptp(extremes, axis=0).max() + AGREEMENT * attractor.radius_max
    order = np.argsort(np.abs(extremes - middle).max(axis=1), kind="stable")
    for member in members[order[:WITNESSES]]:
        settled = settle(rotor, _state(left.states[:, member]), options)
        window = settled.window
        if window is None or settled.response != attractor.kind:
            continue
        seen = np.array([window.radius_min, window.radius_max])
        if np.abs(seen - middle).max() <= spread:
            return _with_numbers_of(settled, attractor)
    return None


def _same(attractor: Attractor, found: list[Attractor]) -> int | None:
    """Return the number of an attractor found before that is the same, as CVODE sees it."""
    for number, other in enumerate(found):
        apart = max(
            abs(attractor.radius_min - other.radius_min),
            abs(attractor.radius_max - other.radius_max),
        )
        if other.kind == attractor.kind and apart <= ACCURACY * other.radius_max:
            return number
    return None


def _with_numbers_of(settled: Settled, attractor: Attractor) -> Attractor:
    window = settled.window
    assert window is not None
    return Attractor(
        attractor.kind, window.amplitude, window.phase_lag, window.radius_min, window.radius_max,
        confirmed=True,
    )  # fmt: skip


def _state(values: Values) -> State:
    x, y, vx, vy = values.tolist()
    return (x, y, vx, vy)
