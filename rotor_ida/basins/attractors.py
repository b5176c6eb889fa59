"""Which attractors there are, and which start ends on which."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.batches import Undecided
from rotor_ida.basins.clustering import (
    ACCURACY,
    Numbers,
    also_in,
    groups,
    limits_of,
    slighter_and_slighter,
)
from rotor_ida.basins.features import MEAN_X, MEAN_Y, RADIUS_MAX, RADIUS_MIN
from rotor_ida.basins.following import FollowedStarts
from rotor_ida.basins.kernel import UNDECIDED
from rotor_ida.basins.matching import Examples, Labels, on_their_way
from rotor_ida.checks import State
from rotor_ida.parameters import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.sweeps.response import CONTACT_FREE, SYNCHRONOUS
from rotor_ida.sweeps.steady_state import SettledResponse, follow_to_steady_state

Values = npt.NDArray[np.float64]

# How many orbits of an attractor CVODE is asked about before the attractor is doubted.
WITNESSES = 3
# Numbers from CVODE and from the kernel agree within this part.
AGREEMENT = 0.02


@dataclass(frozen=True, slots=True)
class Attractor:
    """One attractor.

    Parameters
    ----------
    kind : str
        One of the kinds of `rotor_ida.sweeps.response`.
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


def attractors_of(
    survey: FollowedStarts, starts: list[Values], options: Options
) -> list[Attractor]:
    """Sort the undecided starts of a survey into attractors, and confirm every attractor.

    Parameters
    ----------
    survey : FollowedStarts
        What became of the starts; its labels are changed to the numbers of the attractors in the
        list returned.
    starts : list of ndarray, shape (m, 4)
        For each trapping region, and then for the contact-free whirl, some starts that it has
        captured [1].
    options : Options
        How CVODE is to confirm.
    """
    known = _known(survey)
    if not survey.interrupted:
        known = [
            _confirm_known(survey.ends.rotor, attractor, captured, options)
            for attractor, captured in zip(known, starts, strict=True)
        ]
    left = survey.examples()
    mine, found = _sorted(survey, left, len(known), options)
    if left.numbers.size == survey.undecided_count:
        survey.labels[left.numbers] = mine
    else:
        examples = Examples(survey.ends, left, mine)
        for part in survey.undecided():
            survey.labels[part.numbers] = examples.labels_of(part)
    return known + found


def _sorted(
    survey: FollowedStarts, left: Undecided, known: int, options: Options
) -> tuple[Labels, list[Attractor]]:
    """Return the labels of undecided orbits, and the attractors that were not known before."""
    mine = on_their_way(survey.ends, left)
    open_ = (mine == UNDECIDED) & ~slighter_and_slighter(survey.ends, left)
    kinds, members_of = groups(survey.ends.rotor, left, open_)
    found: list[Attractor] = []
    for kind, members in zip(kinds, members_of, strict=True):
        seen: Attractor | None = _described(kind, left, members)
        if seen is not None and not survey.interrupted:
            seen = _confirm(survey.ends.rotor, seen, left, members, options)
        if seen is None:
            continue
        number = _same(seen, found)
        if number is None:
            number = len(found)
            found.append(seen)
        mine[members] = known + number
        limits = limits_of(left, members)
        mine[also_in(left, limits, open_ & (mine == UNDECIDED))] = known + number
    return mine, found


def _known(survey: FollowedStarts) -> list[Attractor]:
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
    rotor: Rotor, attractor: Attractor, starts: Values, options: Options
) -> Attractor:
    """Let CVODE follow starts that a trapping region has caught, until one ends there."""
    for start in starts:
        settled = follow_to_steady_state(rotor, _state(start), options)
        window = settled.window
        if window is None or settled.response != attractor.kind:
            continue
        if settled.response == CONTACT_FREE:
            return replace(attractor, confirmed=True)
        if abs(window.amplitude - attractor.amplitude) <= AGREEMENT * attractor.amplitude:
            return _with_numbers_of(settled, attractor)
    return attractor


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
        settled = follow_to_steady_state(rotor, _state(left.states[:, member]), options)
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


def _with_numbers_of(settled: SettledResponse, attractor: Attractor) -> Attractor:
    window = settled.window
    assert window is not None
    return Attractor(
        attractor.kind, window.amplitude, window.phase_lag, window.radius_min, window.radius_max,
        confirmed=True,
    )  # fmt: skip


def _state(values: Values) -> State:
    x, y, vx, vy = values.tolist()
    return (x, y, vx, vy)
