"""Smallest shocks that move a rotor from one attractor to another.

A shock changes either the velocity or the position suddenly, and nothing else. On the rotating axes
it is a step in two of the four coordinates, from any state of the attractor and in any direction.
Shocks are drawn over states, directions and sizes and followed side by side, like the starts of a
basin. Then smaller and smaller ones are drawn, half of them close to the smallest found, half
anywhere. From the best of these the search descends along the edge of the basin until no neighbour
is smaller. The result is a shock that leads to the other attractor, the smallest one tried nearby.
No shock below the bound does. For a stable whirl this is proven: the bound is the largest circle of
shocks within its trapping region. For a limit cycle it is estimated, by following shocks into the
set on its section.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from rotor_ida.arrays import Stop, Values
from rotor_ida.basins.cycle_sections import LAST_RETURN, CycleSection
from rotor_ida.basins.fates import Batch, decide
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED, Labels, measure_returns
from rotor_ida.basins.known import Known, may_roll
from rotor_ida.basins.trapping_regions import TrappingRegion
from rotor_ida.model.rotor import Rotor

# Kinds of shock, each with the first of the two coordinates that it changes.
KINDS = {"velocity": 2, "displacement": 0}
# How each number of a disc's state changes by a shock of either kind.
CHANGES = {kind: np.eye(4)[:, first : first + 2] for kind, first in KINDS.items()}
# The first round takes the share of this number, to cover all states, directions and sizes.
EXPLORING = 4
# Others are sought around these within this fraction of all states and directions,
AROUND = 0.1
# reduced by this factor in each round: to a thousandth in the last.
CLOSER = 0.7
# They are smaller by these fractions, spread evenly on a logarithmic scale.
LESS_BY = (1e-4, 0.5)

# Neighbours are tried in the descent, with sizes reduced as above, first within this fraction of
# all states and directions;
BESIDE = 0.1
# if none is smaller, within this fraction of that,
NEARER = 0.6
# down to this fraction of all, where the smooth edge has fallen by less than 1e-5 of the size.
NEAREST = 1e-3

# For its bound, a limit cycle is shocked at this number of states,
PHASES = 32
# in this number of directions,
DIRECTIONS = 24
# by these fractions of a size: all up to it should return.
SHELLS = (1.0, 0.7, 0.4)
# They are followed with this error per step.
TOLERANCE = 1e-8
# Ratio of successive sizes among which the bound is sought,
LESS = 0.93
# and their number: down to 1e-4 of the largest, as for the shocks tried.
SIZES = 127
# Safety factor on the size at which all shocks return, for those that were not tried.
CAUTION = 0.8

# States of an attractor, shape (m, n), at places in the unit square, shape (2, n).
Source = Callable[[Values], Values]


class Effort(NamedTuple):
    """How much a search for the smallest shocks tries."""

    rounds: int = 16  # among which shocks are divided
    least: int = 8  # shocks of a round
    leading: int = 8  # smallest shocks to an attractor, apart from each other, that go on
    neighbours: int = 32  # tried at a time in the descent
    turns: int = 60  # of the descent at most


SIDE_BY_SIDE = Effort()
# Where each shock is followed by itself.
ONE_BY_ONE = Effort(rounds=8, least=4, leading=2, neighbours=4, turns=16)


@dataclass(frozen=True, slots=True)
class Shocks:
    """Shocks that were followed, n of them."""

    sizes: Values
    before: Values  # states on the rotating axes just before them, shape (m, n) [1]
    after: Values  # and just after
    labels: Labels  # of the attractors to which they lead

    def smallest(self, label: int, larger: Sequence[float]) -> list[int]:
        """Return the numbers of shocks with a label, in order of size from the smallest on.

        Each is larger than the smallest by the fractions in `larger` or slightly more.
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
class Blows:
    """What gives shocks of one kind to an attractor.

    Parameters
    ----------
    source : callable
        Returns states of the attractor.
    changes : ndarray, shape (m, 2)
        How a state changes by shocks of size 1 along x and along y.
    ends : callable
        Returns the label of the attractor to which each of several states leads.
    """

    source: Source
    changes: Values
    ends: Callable[[Values], Labels]

    def followed(self, places: Values, sizes: Values) -> Shocks:
        """Follow shocks at places of the unit cube, whose last coordinate is the direction."""
        before, angle = self.source(places[:2]), 2.0 * math.pi * places[2]
        after = before + self.changes @ (sizes * np.stack([np.cos(angle), np.sin(angle)]))
        return Shocks(sizes, before, after, self.ends(after))


@dataclass(frozen=True, slots=True)
class _Leading:
    """The smallest shocks to an attractor so far, apart from each other: sizes and places."""

    sizes: Values
    places: Values


@dataclass(slots=True)
class _Descents:
    """Shocks from which the search descends, with the ranges in which neighbours are sought."""

    labels: Labels
    sizes: Values
    places: Values
    reach: Values


def ends_of_disc(known: Known, states: Values, tolerance: float, stop: Stop) -> Labels:
    """Return the labels of states, shape (4, n); fading touches count as contact-free.

    States that enter no region in time are undecided; with friction they are followed separately.
    """
    if may_roll(known.rotor):
        labels = decide(Batch(known, states, tolerance, stop)).labels
    else:
        labels, _ = known.follow(np.array(states, order="C"), known.first_wait, tolerance, stop)
    labels[labels == known.fading_label] = known.free_label
    return labels


def try_shocks(
    blows: Blows, own: int, sizes: tuple[float, float], count: int, seed: int,
    effort: Effort = SIDE_BY_SIDE,
) -> tuple[Shocks, dict[int, float]]:  # fmt: skip
    """Return followed shocks of one kind, ever smaller ones to each other attractor.

    They are applied to states of the attractor with the label `own`, first with sizes between two
    limits. Also return, by label, the scatter: the relative excess of the best shock from another
    draw over the smallest one; NaN if there was only one draw.
    """
    from scipy.stats import qmc  # noqa: PLC0415 - takes long to import

    random = np.random.default_rng(seed)
    each = max(count // effort.rounds, effort.least)
    spread = qmc.Sobol(4, seed=random).random_base2(max(2, round(math.log2(EXPLORING * each)))).T
    places, drawn = spread[:3], _between(*sizes, spread[3])
    rounds: list[Shocks] = []
    tried_at: list[Values] = []
    leading: dict[int, _Leading] = {}
    for turn in range(effort.rounds - EXPLORING + 1):
        reach = AROUND * CLOSER**turn
        rounds.append(blows.followed(places, drawn))
        tried_at.append(places)
        leading = _led(leading, own, rounds[-1], places, reach, effort.leading)
        places, drawn = _smaller(random, leading, each, sizes, reach)
    # those that lie well apart, as the smallest may all lie in one hollow of the edge
    tried = np.concatenate(tried_at, axis=1)
    leading = _led({}, own, _joined(rounds), tried, BESIDE, effort.leading)
    descents = _descents_from(leading)
    rounds += _downhill(descents, blows, random, effort)
    scatter = {label: _scatter(descents.sizes[descents.labels == label]) for label in leading}
    return _joined(rounds), scatter


def _joined(rounds: Sequence[Shocks]) -> Shocks:
    columns = [[getattr(shots, each.name) for shots in rounds] for each in fields(Shocks)]
    return Shocks(*(np.concatenate(column, axis=-1) for column in columns))


def _descents_from(leading: dict[int, _Leading]) -> _Descents:
    counts = [each.sizes.size for each in leading.values()]
    return _Descents(
        np.repeat(list(leading), counts).astype(np.int16),
        np.concatenate([np.empty(0), *(each.sizes for each in leading.values())]),
        np.concatenate([np.empty((3, 0)), *(each.places for each in leading.values())], axis=1),
        np.full(sum(counts), BESIDE),
    )


def _downhill(
    descents: _Descents, blows: Blows, random: np.random.Generator, effort: Effort
) -> list[Shocks]:
    """Descend along the edges of the basins until no neighbour is smaller; return all tries."""
    rounds: list[Shocks] = []
    for _ in range(effort.turns):
        going = np.flatnonzero(descents.reach > NEAREST)
        if not going.size:
            break
        chosen = np.repeat(going, effort.neighbours)
        aside = random.standard_normal((3, chosen.size)) * descents.reach[chosen]
        places = (descents.places[:, chosen] + aside) % 1.0
        sizes = descents.sizes[chosen] * (1.0 - _between(*LESS_BY, random.random(chosen.size)))
        shots = blows.followed(places, sizes)
        rounds.append(shots)
        there = shots.labels == descents.labels[chosen]
        reached = np.where(there, sizes, np.inf).reshape(-1, effort.neighbours)
        best = reached.argmin(axis=1) + effort.neighbours * np.arange(going.size)
        smaller = np.isfinite(reached.min(axis=1))
        descents.sizes[going[smaller]] = sizes[best[smaller]]
        descents.places[:, going[smaller]] = places[:, best[smaller]]
        descents.reach[going[~smaller]] *= NEARER
    return rounds


def _scatter(sizes: Values) -> float:
    """Return the relative excess of the second smallest size over the smallest."""
    smallest = np.sort(sizes)
    return float(smallest[1] / smallest[0] - 1.0) if sizes.size > 1 else math.nan


def _led(
    leading: dict[int, _Leading], own: int, shots: Shocks, places: Values, apart: float, most: int
) -> dict[int, _Leading]:
    """Return the smallest shocks to each attractor, from those before and those of a round."""
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
            if len(chosen) == most:
                break
        led[label] = _Leading(sizes[chosen], where[:, chosen])
    return led


def _smaller(
    random: np.random.Generator, leading: dict[int, _Leading], count: int,
    sizes: tuple[float, float], reach: float,
) -> tuple[Values, Values]:  # fmt: skip
    """Return places in the unit cube, shape (3, n), and sizes of the shocks to try next.

    A quarter of them are for attractors that none has reached. Of the others, a third are anywhere,
    and the rest near the smallest shock to each attractor.
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
    """Return sizes at fractions of the way between two on a logarithmic scale."""
    return low * (high / low) ** part


def bound_of_whirl(region: TrappingRegion, kind: str) -> float:
    """Return the size up to which all shocks stay in the trapping region of a whirl: proven."""
    if not region.exists:
        return 0.0
    first = KINDS[kind]
    factor = np.linalg.cholesky(region.form).T[:, first : first + 2]
    return float(1.0 / np.linalg.svd(factor, compute_uv=False)[0])


def bound_of_held_whirl(rotor: Rotor, room: float, kind: str) -> float:
    """Return the proven size up to which no shock drives the whirl of a shaft to the stator.

    It follows from the energy, or at strong damping from the slower of the two decaying motions:
    see `rotor_ida.basins.known`.
    """
    if kind == "displacement":
        return room
    kappa, zeta = rotor.shaft_stiffness, rotor.zeta
    return room * max(math.sqrt(kappa), 2.0 * math.sqrt(max(zeta * zeta - kappa, 0.0)))


def bound_of_cycle(
    section: CycleSection, source: Source, kind: str, most: float, stop: Stop
) -> float:  # fmt: skip
    """Return the estimated size up to which shocks of a limit cycle return to its section.

    Sizes above `most` are not tried.
    """
    if not section.exists:
        return 0.0
    phase, angle = np.meshgrid((np.arange(PHASES) + 0.5) / PHASES, np.arange(DIRECTIONS))
    places = np.stack([phase, np.zeros_like(phase), angle / DIRECTIONS]).reshape(3, -1)

    def returns(states: Values) -> Labels:
        values = np.empty(states.shape[1])
        measure_returns(
            np.ascontiguousarray(states), section.cycle.rotor, section.row,
            (0.0, LAST_RETURN * section.cycle.duration), TOLERANCE, values, stop,
        )  # fmt: skip
        return (values <= 1.0).astype(np.int16)

    blows = Blows(source, CHANGES[kind], returns)

    def all_return(size: float) -> bool:
        sizes = np.full(phase.size, size)
        return all(
            not stop[0] and bool(blows.followed(places, part * sizes).labels.all())
            for part in SHELLS
        )

    sizes = most * LESS ** np.arange(SIZES)
    first = bisect_left(sizes.tolist(), True, key=all_return)
    return CAUTION * float(sizes[first]) if first < SIZES else 0.0
