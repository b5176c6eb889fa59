"""The attractors of a rotor, each confirmed by CVODE, and the labels of its undecided starts."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.batches import Undecided
from rotor_ida.basins.clustering import ACCURACY, Numbers, clusters, limits_of, touching, within
from rotor_ida.basins.features import MEAN_X, MEAN_Y, RADIUS_MAX, RADIUS_MIN
from rotor_ida.basins.following import FollowedStarts
from rotor_ida.basins.kernel import UNDECIDED
from rotor_ida.basins.matching import Labels, NearestFeatures, approaching
from rotor_ida.checks import State
from rotor_ida.parameters import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.sweeps.response import BOUNCING, CHAOTIC, CONTACT_FREE, FULL_CONTACT, SYNCHRONOUS
from rotor_ida.sweeps.steady_state import SettledResponse, follow_to_steady_state

Values = npt.NDArray[np.float64]

# CVODE follows so many orbits of an attractor before the attractor counts as unconfirmed.
WITNESSES = 3
# Features from CVODE and from the kernel agree to this relative difference.
AGREEMENT = 0.02
# What features call bouncing or in full contact may be chaotic.
OSCILLATING = (BOUNCING, FULL_CONTACT, CHAOTIC)


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
        Whether CVODE has followed an orbit to it; amplitudes and radii are then CVODE's.
    """

    kind: str
    amplitude: float
    phase_lag: float
    radius_min: float
    radius_max: float
    confirmed: bool = False


def attractors_of(
    results: FollowedStarts, starts: list[Values], options: Options
) -> list[Attractor]:
    """Find the attractors of the undecided starts, and confirm every attractor.

    Parameters
    ----------
    results : FollowedStarts
        Results of the starts; labels of undecided ones are changed to the numbers of the
        attractors in the list returned.
    starts : list of ndarray, shape (m, 4)
        For each known attractor some starts that certainly end there [1].
    options : Options
        How CVODE is to confirm.
    """
    known = _known_attractors(results)
    if not results.interrupted:
        known = [
            _confirm_known(results.known.rotor, attractor, trapped, options)
            for attractor, trapped in zip(known, starts, strict=True)
        ]
    orbits = results.sample()
    labels, found = _clustered(results, orbits, len(known), options)
    if orbits.numbers.size == results.undecided_count:
        results.labels[orbits.numbers] = labels
    else:
        nearest = NearestFeatures(results.known, orbits, labels)
        for batch in results.undecided():
            results.labels[batch.numbers] = nearest.labels_of(batch)
    return known + found


def _clustered(
    results: FollowedStarts, orbits: Undecided, known: int, options: Options
) -> tuple[Labels, list[Attractor]]:
    """Return the labels of undecided orbits, and the attractors that were not known before."""
    labels = approaching(results.known, orbits)
    unmatched = (labels == UNDECIDED) & ~touching(results.known, orbits)
    kinds, members_of = clusters(results.known.rotor, orbits, unmatched)
    found: list[Attractor] = []
    for kind, members in zip(kinds, members_of, strict=True):
        attractor: Attractor | None = _from_features(kind, orbits, members)
        if attractor is not None and not results.interrupted:
            attractor = _confirm(results.known.rotor, attractor, orbits, members, options)
        if attractor is None:
            continue
        number = _number_of_same(attractor, found)
        if number is None:
            number = len(found)
            found.append(attractor)
        labels[members] = known + number
        limits = limits_of(orbits, members)
        labels[within(orbits, limits, unmatched & (labels == UNDECIDED))] = known + number
    return labels, found


def _known_attractors(results: FollowedStarts) -> list[Attractor]:
    """Return the attractors that closed forms give."""
    rotor = results.known.rotor
    kind = CONTACT_FREE if rotor.omega == 0.0 else SYNCHRONOUS
    known = [
        Attractor(kind, each.amplitude, each.phase_lag, each.amplitude, each.amplitude)
        for each in results.known.regions
    ]
    if results.known.has_free:
        whirl = complex(results.known.free[0], results.known.free[1])
        lag = math.atan2(-whirl.imag, whirl.real) if whirl else 0.0
        known.append(Attractor(CONTACT_FREE, abs(whirl), lag, math.nan, math.nan))
    return known


def _confirm_known(
    rotor: Rotor, attractor: Attractor, starts: Values, options: Options
) -> Attractor:
    """Let CVODE follow starts that certainly end there, until one does."""
    for start in starts:
        settled = follow_to_steady_state(rotor, _state(start), options)
        if settled.response != attractor.kind:
            continue
        if settled.response == CONTACT_FREE:
            return replace(attractor, confirmed=True)
        if abs(settled.features.amplitude - attractor.amplitude) <= AGREEMENT * attractor.amplitude:
            return _confirmed(settled)
    return attractor


def _from_features(kind: str, orbits: Undecided, members: Numbers) -> Attractor:
    """Return an attractor with the median features of its orbits."""
    middle = np.median(orbits.later[members].astype(np.float64), axis=0)
    mean = complex(middle[MEAN_X], middle[MEAN_Y])
    lag = math.atan2(-mean.imag, mean.real)
    return Attractor(kind, abs(mean), lag, float(middle[RADIUS_MIN]), float(middle[RADIUS_MAX]))


def _confirm(
    rotor: Rotor, attractor: Attractor, orbits: Undecided, members: Numbers, options: Options
) -> Attractor | None:
    """Let CVODE follow the orbits nearest to the median; None if it finds no motion like them."""
    extremes = orbits.later[members][:, [RADIUS_MIN, RADIUS_MAX]].astype(np.float64)
    middle = np.array([attractor.radius_min, attractor.radius_max])
    spread = np.ptp(extremes, axis=0).max() + AGREEMENT * attractor.radius_max
    order = np.argsort(np.abs(extremes - middle).max(axis=1), kind="stable")
    for member in members[order[:WITNESSES]]:
        settled = follow_to_steady_state(rotor, _state(orbits.states[:, member]), options)
        if settled.response not in OSCILLATING:
            continue
        seen = np.array([settled.features.radius_min, settled.features.radius_max])
        if np.abs(seen - middle).max() <= spread:
            return _confirmed(settled)
    return None


def _number_of_same(attractor: Attractor, found: list[Attractor]) -> int | None:
    """Return the number of the same attractor, as CVODE found it, among those found before."""
    for number, other in enumerate(found):
        apart = max(
            abs(attractor.radius_min - other.radius_min),
            abs(attractor.radius_max - other.radius_max),
        )
        if other.kind == attractor.kind and apart <= ACCURACY * other.radius_max:
            return number
    return None


def _confirmed(settled: SettledResponse) -> Attractor:
    """Return an attractor as CVODE found it."""
    seen = settled.features
    return Attractor(
        settled.response, seen.amplitude, seen.phase_lag, seen.radius_min, seen.radius_max,
        confirmed=True,
    )  # fmt: skip


def _state(values: Values) -> State:
    x, y, vx, vy = values.tolist()
    return (x, y, vx, vy)
