"""The attractors on which starts of a rotor ended, each as a row of numbers."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rotor_ida.arrays import Stop, Values
from rotor_ida.basins.fates import APERIODIC
from rotor_ida.basins.following import FollowedStarts
from rotor_ida.basins.kernel import CHAOTIC, LOWEST, Labels
from rotor_ida.basins.known import ContactFree, followed_alone, may_roll
from rotor_ida.basins.starts import Starts, stretches
from rotor_ida.checks import State
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import RESPONSE, TRAPPING
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.options import Options
from rotor_ida.steady import response
from rotor_ida.steady.follow import SettledResponse, follow_to_steady_state
from rotor_ida.steady.response import phase_lag_of

# Number of starts that CVODE follows before an attractor counts as unconfirmed.
WITNESSES = 3
# Relative agreement with CVODE: of radii to the largest radius, of periods to the period.
AGREEMENT = 1e-5
# The numbers of an attractor, as reported and stored.
NUMBERS = (
    *("amplitude", "phase_lag", "radius_min", "radius_max", "period", "lifetime", "lifetime_low"),
)
# Evidence for the region of an attractor: see `rotor_ida.schema.TRAPPING`.
PROVEN, ESTIMATED, NOTHING = "proven", "estimated", "none"
# Whirls that stay inside the clearance; fading touches converge to the outermost one.
CONTACT_FREE_FAMILY = (response.CONTACT_FREE, response.TOUCHING)
# Kinds for which reaching any motion of the kind confirms a start.
ONLY_BY_KIND = (*CONTACT_FREE_FAMILY, response.QUASI_PERIODIC, response.CHAOTIC)
# Samples of one period, for the mean whirl.
SAMPLES = 512
# Confidence level of the lower bound on the lifetime of chaos.
CERTAINTY = 0.95


@dataclass(frozen=True, slots=True)
class Attractor:
    """One attractor.

    Parameters
    ----------
    kind : str
        One of the kinds of `rotor_ida.steady.response`.
    amplitude, phase_lag : float
        Of the motion at the spin speed [1], [rad].
    radius_min, radius_max : float
        Smallest and largest distance from the bearing axis [1]; NaN where it depends on the start.
    period : float
        On the rotating axes, of a limit cycle [1]; else NaN.
    trapping : {"proven", "estimated", "none"}
        Evidence for its trapping region: a proof that no orbit leaves it, or sample orbits followed
        from it; "none" if it has no region and starts were followed one by one.
    lifetime, lifetime_low : float
        Mean time after which orbits leave a chaotic motion, infinite if none did, and its lower
        95 % confidence bound [1]; infinite for all other attractors.
    confirmed : bool
        Whether CVODE has followed one of its starts to it; to one of its kind for contact-free
        whirls, touches and chaos. False if this was not tried.
    """

    kind: str
    amplitude: float
    phase_lag: float
    radius_min: float
    radius_max: float
    period: float = math.nan
    trapping: str = PROVEN
    lifetime: float = math.inf
    lifetime_low: float = math.inf
    confirmed: bool = False

    @property
    def numbers(self) -> dict[str, float]:
        """What is reported of it, by name."""
        own = {name: getattr(self, name) for name in NUMBERS}
        return own | {"kind": RESPONSE[self.kind], "trapping": TRAPPING[self.trapping]}


def attractors_of(followed: FollowedStarts) -> list[Attractor]:
    """Return the attractors of starts, and renumber the labels to match.

    Whirls in contact come first, by amplitude, then the contact-free ones: both with or without
    starts. Then come, only if starts end on them: fading touches, limit cycles by largest radius,
    and motions without a period.
    """
    known = followed.known
    rows: list[tuple[int, Attractor]] = []
    loaded, alone = known.rotor.load > 0.0, followed_alone(known.rotor)
    still = known.rotor.omega == 0.0 and not loaded  # and comes to rest at the centre
    kind = response.CONTACT_FREE if still else response.SYNCHRONOUS
    for number, each in enumerate(known.whirls):
        size = each.amplitude
        trapping = PROVEN if each.exists else NOTHING
        row = Attractor(kind, size, each.phase_lag, size, size, trapping=trapping)
        rows.append((number, row))
    present = _present(followed.labels)
    if known.free is not None:
        free, fading = _contact_free(known.free), _fading(known.free, known.rotor)
        if alone:
            free, fading = (replace(each, trapping=NOTHING) for each in (free, fading))
        if known.free.room > 0.0:
            rows.append((known.free_label, free))
        if known.fading_label in present:
            rows.append((known.fading_label, fading))
    stop = np.zeros(1, np.uint8)
    for place in np.argsort([each.radius_max for each in followed.cycles], kind="stable").tolist():
        if (number := known.first_cycle + place) in present:
            cycle, has_section = followed.cycles[place], followed.has_section[place]
            rows.append((number, attractor_of_cycle(cycle, has_section, stop)))
    for kind, label in APERIODIC.items():
        if label in present:
            row = _together(kind, followed.aperiodic[label])
            rows.append((label, _with_lifetime(row, followed) if label == CHAOTIC else row))
    _renumber(followed.labels, [label for label, _ in rows])
    return [row for _, row in rows]


def confirmed(
    followed: FollowedStarts, attractors: list[Attractor], starts: Starts, options: Options
) -> list[Attractor]:
    """Return the attractors, each confirmed if CVODE reaches it from one of its starts."""
    rotor, rows = followed.known.rotor, []
    for each, numbers in zip(attractors, _first_decided(followed, len(attractors)), strict=True):
        states = (starts(number, number + 1)[:, 0] for number in numbers)
        reached = any(leads_to(rotor, each, state, options) for state in states)
        rows.append(replace(each, confirmed=reached))
    return rows


def _first_decided(followed: FollowedStarts, count: int) -> list[list[int]]:
    """Return, for each of `count` attractors, the numbers of the starts that were decided first.

    They are the least likely to lie so near a basin boundary that another integrator disagrees.
    """
    first = [np.empty(0, dtype=np.int64) for _ in range(count)]
    for stretch in stretches(followed.labels.size):
        for number in range(count):
            members = stretch.start + np.flatnonzero(followed.labels[stretch] == number)
            members = np.concatenate([first[number], members])
            order = np.argsort(followed.times[members], kind="stable")
            first[number] = members[order[:WITNESSES]]
    return [each.tolist() for each in first]


def leads_to(
    rotor: Rotor, attractor: Attractor, start: Values, options: Options, *, family: bool = False,
    stop: Stop | None = None,
) -> bool:  # fmt: skip
    """Return whether CVODE follows a start to an attractor, or with `family` to one of its family.

    Fading touches belong to the contact-free family.
    """
    settled = follow_to_steady_state(rotor, _state(start), options, stop=stop)
    if family and attractor.kind in CONTACT_FREE_FAMILY:
        return settled.response in CONTACT_FREE_FAMILY
    if settled.response != attractor.kind:
        return False
    if attractor.kind in ONLY_BY_KIND:
        return True
    if attractor.kind == response.ROLLING and math.isnan(attractor.period):
        return math.isnan(settled.features.period)
    return _agrees(settled, attractor)


def _agrees(settled: SettledResponse, attractor: Attractor) -> bool:
    features, size = settled.features, attractor.radius_max
    pairs = (
        (features.radius_min, attractor.radius_min, size),
        (features.radius_max, attractor.radius_max, size),
        (features.period, attractor.period, attractor.period),
    )
    known = [pair for pair in pairs if not math.isnan(pair[1])]
    return all(abs(one - other) <= AGREEMENT * scale for one, other, scale in known)


def _contact_free(free: ContactFree) -> Attractor:
    size, lag = abs(free.whirl), phase_lag_of(free.whirl)
    if not free.alone:
        return Attractor(response.CONTACT_FREE, size, lag, math.nan, math.nan)
    low, high = abs(size - free.sag), size + free.sag
    return Attractor(response.CONTACT_FREE, size, lag, low, high)


def _fading(free: ContactFree, rotor: Rotor) -> Attractor:
    """Return the limit of fading touches: the contact-free whirl that just reaches the stator.

    With friction, starts outside the rim are followed to it one by one.
    """
    whirl, delta0 = free.whirl, rotor.delta0
    return Attractor(
        response.TOUCHING, abs(whirl), phase_lag_of(whirl), abs(delta0 - 2.0 * abs(whirl)), delta0,
        trapping=NOTHING if may_roll(rotor) and free.excess == 0.0 else ESTIMATED,
    )  # fmt: skip


def family_of(kinds: Sequence[str]) -> tuple[int, ...]:
    """Return the numbers of the attractors in the contact-free family, by the kind of each."""
    return tuple(number for number, kind in enumerate(kinds) if kind in CONTACT_FREE_FAMILY)


def attractor_of_cycle(cycle: Orbit, has_section: bool, stop: Stop) -> Attractor:
    """Return a limit cycle as an attractor; `has_section` sets its trapping evidence."""
    times = cycle.duration / SAMPLES * np.arange(SAMPLES + 1.0)
    states = DiscFlow(cycle.rotor, stop).states(cycle.start, times)[:-1]
    whirl = complex(states[:, 0].mean(), states[:, 1].mean())
    return Attractor(
        cycle.response, abs(whirl), phase_lag_of(whirl), cycle.radius_min, cycle.radius_max,
        cycle.duration, ESTIMATED if has_section else NOTHING,
    )  # fmt: skip


def _with_lifetime(chaos: Attractor, followed: FollowedStarts) -> Attractor:
    """Return the chaotic motions with their lifetime.

    The rate of leaving is taken as constant: n orbits left during a total observed time t.
    """
    from scipy.special import gammaincinv  # noqa: PLC0415 - takes long to import

    most = float(gammaincinv(followed.left + 1.0, CERTAINTY))
    return replace(
        chaos,
        lifetime=followed.watched / followed.left if followed.left else math.inf,
        lifetime_low=followed.watched / most,
    )


def _together(kind: str, motions: Values) -> Attractor:
    """Return motions without a period as one attractor, from the rows that are known of them."""
    amplitudes, lags, low, high = motions.T
    whirl = complex(np.mean(amplitudes * np.exp(-1j * lags)))
    return Attractor(
        kind, abs(whirl), -cmath.phase(whirl), float(low.min()), float(high.max()),
        trapping=NOTHING,
    )  # fmt: skip


def _present(labels: Labels) -> set[int]:
    """Return the labels that occur."""
    present: set[int] = set()
    for stretch in stretches(labels.size):
        present.update(np.unique(labels[stretch]).tolist())
    return present


def _renumber(labels: Labels, kept: list[int]) -> None:
    """Replace labels by their places in a list; labels of fates are unchanged."""
    table = np.arange(max([*kept, 0]) + 1 - LOWEST, dtype=np.int16)
    table[LOWEST:] = np.arange(LOWEST, 0)
    table[kept] = np.arange(len(kept))
    for stretch in stretches(labels.size):
        labels[stretch] = table[labels[stretch]]


def _state(values: Values) -> State:
    x, y, vx, vy = values.tolist()
    return (x, y, vx, vy)
