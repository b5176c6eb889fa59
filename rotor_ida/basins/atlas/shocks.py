"""Smallest shocks: the least knock that throws a rotor from one attractor to another.

A shock changes the velocity at once, or the place, and nothing else: on the rotating axes it is a
step in two of the four coordinates, from any state of the attractor and in any direction. Shocks
are drawn over states, directions and sizes and followed all together, as starts of a basin are;
then smaller and smaller ones, half of them close to the smallest found, half anywhere. From the
best of these the search goes down along the edge of the basin until no neighbour is smaller. What
is found is a witness: a shock that throws the rotor there, the smallest of those beside it that
were tried. None below the bound does. Of a stable whirl that is proven: the bound is the largest
circle of shocks within its trapping region. Of a limit cycle it is estimated, by following shocks
into the set on its section.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import qmc

from rotor_ida.arrays import Stop, Values
from rotor_ida.basins.cycle_sections import LAST_RETURN, CycleSection
from rotor_ida.basins.fates import Batch, decide
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED, Labels, measure_returns
from rotor_ida.basins.known import Known, may_roll
from rotor_ida.basins.trapping_regions import TrappingRegion
from rotor_ida.model.rotor import Rotor

# Kinds of shock, with the first of the two coordinates that it changes.
KINDS = {"velocity": 2, "displacement": 0}
# Shocks are divided among so many rounds.
ROUNDS = 16
# The first takes the share of so many: its shocks lie evenly over all states, directions and sizes.
EXPLORING = 4
# The search goes on from so many of the smallest shocks to an attractor, which lie apart.
LEADING = 8
# Others are sought round these in this part of all states and directions,
AROUND = 0.1
# less by this factor in each round: in the last in a thousandth.
CLOSER = 0.7
# They are smaller by such parts, spread evenly on a logarithmic scale.
LESS_BY = (1e-4, 0.5)

# Downhill so many neighbours of each are tried at a time, with sizes less by parts as above,
NEIGHBOURS = 32
# first within this part of all states and directions;
BESIDE = 0.1
# where none is smaller, within this part of that,
NEARER = 0.6
# down to this part of all, where the edge, which is smooth, has fallen by less than a part of 1e-5.
NEAREST = 1e-3
# No search goes down for longer than so many turns.
MOST_TURNS = 60

# A limit cycle is shocked for its bound at so many states,
PHASES = 32
# in so many directions,
DIRECTIONS = 24
# by these parts of a size: all up to it should come back.
SHELLS = (1.0, 0.7, 0.4)
# What they do is followed with this error of a step.
TOLERANCE = 1e-8
# The bound is sought among sizes each of which is this part of the one before:
LESS = 0.93
# so many, down to 1e-4 of the largest, as small as shocks are tried.
SIZES = 127
# It is this much less than where all shocks come back, for those that were not tried.
CAUTION = 0.8

# States of an attractor, shape (4, n), at places in the unit square, shape (2, n).
Source = Callable[[Values], Values]


@dataclass(frozen=True, slots=True)
class Shocks:
    """Shocks that were followed, n of them."""

    sizes: Values
    before: Values  # states on the rotating axes just before them, shape (4, n) [1]
    after: Values  # and just after
    labels: Labels  # of what they throw the rotor to

    def smallest(self, label: int, larger: Sequence[float]) -> list[int]:
        """Return the numbers of shocks with a label, in order of size from the smallest on.

        Each is larger than the smallest by a part of it, or by a little more.
        """
        numbers = np.flatnonzero(self.labels == label)
        if not numbers.size:
            return []
        numbers = numbers[np.argsort(self.sizes[numbers], kind="stable")]
        sizes = self.sizes[numbers]
        places = np.searchsorted(sizes, sizes[0] * (1.0 + np.array(larger)))
        chosen: list[int] = numbers[np.unique(places[places < sizes.size])].tolist()
        return chosen


@dataclass(frozen=True, slots=True)
class _Leading:
    """The smallest shocks to an attractor so far, apart from each other: sizes and places."""

    sizes: Values
    places: Values


@dataclass(slots=True)
class _Descents:
    """Shocks from which the search goes down, with how far their neighbours are sought."""

    labels: Labels
    sizes: Values
    places: Values
    reach: Values


def ends_of(known: Known, states: Values, tolerance: float, stop: Stop) -> Labels:
    """Return the labels of states, shape (4, n); fading touches count as contact-free.

    What no region holds in time is undecided; with friction it is followed to its end by itself.
    """
    if may_roll(known.rotor):
        labels = decide(Batch(known, states, tolerance, stop)).labels
    else:
        labels, _ = known.follow(np.array(states, order="C"), known.first_wait, tolerance, stop)
    labels[labels == known.fading_label] = known.free_label
    return labels


def try_shocks(
    source: Source, own: int, kind: str, sizes: tuple[float, float], count: int,
    ends: Callable[[Values], Labels], seed: int,
) -> tuple[Shocks, dict[int, float]]:  # fmt: skip
    """Return shocks of one kind that were followed, ever smaller ones to each other attractor.

    They strike states of the attractor with the label `own`, and begin with sizes between two.
    Beside them, by label, how much larger than the smallest shock the best is that another draw
    led to, as a part of it: its scatter; NaN where there was but one draw.
    """
    random = np.random.default_rng(seed)
    each = max(count // ROUNDS, 8)
    spread = qmc.Sobol(4, seed=random).random_base2(max(2, round(math.log2(EXPLORING * each)))).T
    places, drawn = spread[:3], _between(*sizes, spread[3])
    rounds: list[Shocks] = []
    tried_at: list[Values] = []
    leading: dict[int, _Leading] = {}
    for turn in range(ROUNDS - EXPLORING + 1):
        reach = AROUND * CLOSER**turn
        rounds.append(_followed(source, places, drawn, kind, ends))
        tried_at.append(places)
        leading = _led(leading, own, rounds[-1], places, reach)
        places, drawn = _smaller(random, leading, each, sizes, reach)
    # those that lie well apart, as the smallest may all lie in one hollow of the edge
    leading = _led({}, own, _joined(rounds), np.concatenate(tried_at, axis=1), BESIDE)
    descents = _descents_from(leading)
    rounds += _downhill(
        descents, lambda places, sizes: _followed(source, places, sizes, kind, ends), random
    )
    scatter = {label: _scatter(descents.sizes[descents.labels == label]) for label in leading}
    return _joined(rounds), scatter


def _joined(rounds: Sequence[Shocks]) -> Shocks:
    return Shocks(
        np.concatenate([shots.sizes for shots in rounds]),
        np.concatenate([shots.before for shots in rounds], axis=1),
        np.concatenate([shots.after for shots in rounds], axis=1),
        np.concatenate([shots.labels for shots in rounds]),
    )


def _descents_from(leading: dict[int, _Leading]) -> _Descents:
    counts = [each.sizes.size for each in leading.values()]
    return _Descents(
        np.repeat(list(leading), counts).astype(np.int16),
        np.concatenate([np.empty(0), *(each.sizes for each in leading.values())]),
        np.concatenate([np.empty((3, 0)), *(each.places for each in leading.values())], axis=1),
        np.full(sum(counts), BESIDE),
    )


def _downhill(
    descents: _Descents, followed: Callable[[Values, Values], Shocks], random: np.random.Generator
) -> list[Shocks]:
    """Go down along the edges of the basins until no neighbour is smaller; return all tries."""
    rounds: list[Shocks] = []
    for _ in range(MOST_TURNS):
        going = np.flatnonzero(descents.reach > NEAREST)
        if not going.size:
            break
        chosen = np.repeat(going, NEIGHBOURS)
        aside = random.standard_normal((3, chosen.size)) * descents.reach[chosen]
        places = (descents.places[:, chosen] + aside) % 1.0
        sizes = descents.sizes[chosen] * (1.0 - _between(*LESS_BY, random.random(chosen.size)))
        shots = followed(places, sizes)
        rounds.append(shots)
        there = shots.labels == descents.labels[chosen]
        reached = np.where(there, sizes, np.inf).reshape(-1, NEIGHBOURS)
        best = reached.argmin(axis=1) + NEIGHBOURS * np.arange(going.size)
        smaller = np.isfinite(reached.min(axis=1))
        descents.sizes[going[smaller]] = sizes[best[smaller]]
        descents.places[:, going[smaller]] = places[:, best[smaller]]
        descents.reach[going[~smaller]] *= NEARER
    return rounds


def _scatter(sizes: Values) -> float:
    """Return by how much the second smallest of some sizes is larger than the smallest."""
    smallest = np.sort(sizes)
    return float(smallest[1] / smallest[0] - 1.0) if sizes.size > 1 else math.nan


def _led(
    leading: dict[int, _Leading], own: int, shots: Shocks, places: Values, apart: float
) -> dict[int, _Leading]:
    """Return the smallest shocks to each attractor, those before with those of a round."""
    led = {}
    met = set(np.unique(shots.labels).tolist()) - {own, UNDECIDED, NOT_COMPUTED}
    for label in sorted(met | leading.keys()):
        found = shots.labels == label
        sizes, where = shots.sizes[found], places[:, found]
        if label in leading:
            sizes = np.concatenate([leading[label].sizes, sizes])
            where = np.concatenate([leading[label].places, where], axis=1)
        chosen: list[int] = []
        for number in np.argsort(sizes, kind="stable").tolist():
            away = np.abs(where[:, chosen] - where[:, number, None])
            if (np.minimum(away, 1.0 - away).max(axis=0) > apart).all():
                chosen.append(number)
            if len(chosen) == LEADING:
                break
        led[label] = _Leading(sizes[chosen], where[:, chosen])
    return led


def _smaller(
    random: np.random.Generator, leading: dict[int, _Leading], count: int,
    sizes: tuple[float, float], reach: float,
) -> tuple[Values, Values]:  # fmt: skip
    """Return places in the unit cube, shape (3, n), and sizes of the shocks to try next.

    A quarter of them are for attractors that none has come to; of the others, a third is anywhere,
    and the rest near to the smallest to each.
    """
    free = count // 4 if leading else count
    places, drawn = [random.random((3, free))], [_between(*sizes, random.random(free))]
    for each in leading.values():
        share = max((count - free) // (3 * len(leading)), 1)
        chosen = random.integers(each.sizes.size, size=2 * share)
        near = each.places[:, chosen] + reach * random.standard_normal((3, 2 * share))
        places += [random.random((3, share)), near]
        less = 1.0 - _between(*LESS_BY, random.random(3 * share))
        drawn.append(np.append(np.full(share, each.sizes[0]), each.sizes[chosen]) * less)
    return np.concatenate(places, axis=1) % 1.0, np.concatenate(drawn)


def _between(low: float, high: float, part: Values) -> Values:
    """Return sizes at parts of the way between two on a logarithmic scale."""
    return low * (high / low) ** part


def _followed(
    source: Source, places: Values, sizes: Values, kind: str, ends: Callable[[Values], Labels]
) -> Shocks:
    """Return shocks at places of the unit cube, of which the last coordinate is the direction."""
    before = source(places[:2])
    after, first = before.copy(), KINDS[kind]
    angle = 2.0 * math.pi * places[2]
    after[first] += sizes * np.cos(angle)
    after[first + 1] += sizes * np.sin(angle)
    return Shocks(sizes, before, after, ends(after))


def bound_of_whirl(region: TrappingRegion, kind: str) -> float:
    """Return the size up to which all shocks stay in the trapping region of a whirl: proven."""
    if not region.exists:
        return 0.0
    first = KINDS[kind]
    factor = np.linalg.cholesky(region.form).T[:, first : first + 2]
    return float(1.0 / np.linalg.svd(factor, compute_uv=False)[0])


def bound_of_held_whirl(rotor: Rotor, room: float, kind: str) -> float:
    """Return the size up to which no shock drives the whirl that a shaft holds to the ring: proven.

    By its energy, or with much damping by the slow one of the two motions that it falls into: see
    `rotor_ida.basins.known`.
    """
    if kind == "displacement":
        return room
    kappa, zeta = rotor.shaft_stiffness, rotor.zeta
    return room * max(math.sqrt(kappa), 2.0 * math.sqrt(max(zeta * zeta - kappa, 0.0)))


def bound_of_cycle(
    section: CycleSection, source: Source, kind: str, most: float, stop: Stop
) -> float:  # fmt: skip
    """Return the size up to which shocks of a limit cycle come back to its section: estimated.

    It is not sought above `most`.
    """
    if not section.exists:
        return 0.0
    phase, angle = np.meshgrid((np.arange(PHASES) + 0.5) / PHASES, np.arange(DIRECTIONS))
    places = np.stack([phase, np.zeros_like(phase), angle / DIRECTIONS]).reshape(3, -1)

    def returns(states: Values) -> Labels:
        values = np.empty(states.shape[1])
        measure_returns(
            np.ascontiguousarray(states), section.cycle.rotor, section.row,
            (0.0, LAST_RETURN * section.cycle.period), TOLERANCE, values, stop,
        )  # fmt: skip
        return (values <= 1.0).astype(np.int16)

    def all_return(size: float) -> bool:
        sizes = np.full(phase.size, size)
        return all(
            not stop[0]
            and bool(_followed(source, places, part * sizes, kind, returns).labels.all())
            for part in SHELLS
        )

    sizes = most * LESS ** np.arange(SIZES)
    first = bisect_left(sizes.tolist(), True, key=all_return)
    return CAUTION * float(sizes[first]) if first < SIZES else 0.0
