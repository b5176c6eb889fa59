"""One disc whose starts are labelled: how many at a time, with which error, and the attractors.

A few starts are followed first. They show the limit cycles, which then trap others, and whether a
larger error per step gives the same labels.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from rotor_ida.arrays import Stop, Values
from rotor_ida.basins.attractors import (
    ESTIMATED,
    NOTHING,
    OF_DISC,
    PROVEN,
    Followed,
    Found,
    Indices,
    disc_row,
    row_of,
)
from rotor_ida.basins.fates import ALONE, APERIODIC, Batch, decide
from rotor_ida.basins.following import Labeller, tighter_than
from rotor_ida.basins.kernel import LANES, NOT_COMPUTED, UNDECIDED, Labels
from rotor_ida.basins.known import Known, followed_alone, known_from_closed_forms, may_remain
from rotor_ida.basins.starts import Starts
from rotor_ida.basins.subjects import KnockedSystem
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.steady import response
from rotor_ida.steady.response import phase_lag_of

# A smaller batch would leave many lanes of the kernel idle at its end.
SMALLEST_BATCH = 512
# Smaller batches for starts that are followed one by one,
SMALLEST_ALONE = 4
# and with friction or under a load, where some of them are.
SMALLEST_RUBBING = LANES
# Number of starts followed first, to find limit cycles; under a load, where tori are common, each
# of which is followed by itself.
SCOUTS, SCOUTS_UNDER_LOAD = 128, 8
# The error of a step [1],
RTOL = 1e-6
# but this one if it changes the attractor of any of this number of starts.
SMALL_RTOL = 1e-11
CHECKED = 512
# Up to this number of starts, making all takes less time than making so few one by one.
ALL_AT_ONCE = 100_000
# A first look shows only what is soon trapped by whirls.
RTOL_OF_FIRST_LOOK = 1e-4
# Longest time for which a start is followed again [1].
LONGEST_AGAIN = 4000.0


@dataclass(frozen=True, slots=True)
class Disc:
    """One disc whose starts are labelled.

    Parameters
    ----------
    known : Known
        The rotor, and the attractors that are known.
    rtol : float or None
        Error allowed in a step [dimensionless]; None if it is to be chosen from a few starts.
    """

    known: Known
    rtol: float | None
    columns: ClassVar[np.dtype[np.void]] = OF_DISC

    @classmethod
    def of(cls, rotor: Rotor, rtol: float | None, stop: Stop) -> Self:
        """Return a rotor with the attractors that closed forms give."""
        if rtol is None and followed_alone(rotor):
            rtol = ALONE.rtol
        return cls(known_from_closed_forms(rotor, stop), rtol)

    @property
    def smallest(self) -> int:
        """Fewest starts that are worth a batch."""
        if self.known.is_followed_alone:
            return SMALLEST_ALONE
        return SMALLEST_RUBBING if may_remain(self.known.rotor) else SMALLEST_BATCH

    def flow(self, stop: Stop) -> DiscFlow:
        """Return how the disc moves."""
        return DiscFlow(self.known.rotor, stop)

    def listed(self) -> list[np.void]:
        """Return the whirls in contact, and the contact-free one."""
        return list(whirls_of(self.known).values())

    def scouted(self, starts: Starts, count: int, *, drawn: bool, stop: Stop) -> Self:
        """Return the same with the limit cycles that a few starts show, and a tolerance."""
        is_one_batch = count <= self.smallest and self.rtol is not None
        if is_one_batch or self.known.is_followed_alone:
            return self
        scouts = SCOUTS_UNDER_LOAD if self.known.rotor.load > 0.0 else SCOUTS
        disc = self.with_cycles(_few(starts, count, scouts, drawn), stop)
        if self.rtol is not None:
            return disc
        known, sample = disc.known, _few(starts, count, CHECKED, drawn)
        roughly, closely = (
            known.follow(sample.copy(), known.first_wait, rtol, stop)[0]
            for rtol in (RTOL, SMALL_RTOL)
        )
        decided = (roughly >= 0) & (closely >= 0)
        alike = bool((roughly == closely)[decided].all())
        return replace(disc, rtol=RTOL if alike else SMALL_RTOL)

    def with_cycles(self, scouts: Values, stop: Stop) -> Self:
        """Return the same with the limit cycles that some starts, shape (4, n), show."""
        batch = Batch(self.known, scouts, self.rtol or RTOL, stop)
        return replace(self, known=decide(batch).known)

    def label(self, states: Values, stop: Stop) -> Found:
        """Follow starts, shape (4, n), each until its attractor is decided."""
        batch = Batch(self.known, states, self.rtol or RTOL, stop)
        decide(batch)
        rows = _rows_of(batch)

        def again(chosen: Indices) -> Labels:
            if self.known.is_followed_alone:
                return np.full(chosen.size, UNDECIDED, np.int16)
            # none for longer than the longest of them was before
            duration = max(float(batch.times[chosen].max()), self.known.first_wait)
            labels, _ = batch.known.follow(
                np.ascontiguousarray(states[:, chosen]), min(duration, LONGEST_AGAIN),
                tighter_than(batch.tolerance), stop,
            )  # fmt: skip
            return _places_in(list(rows), labels)

        labels = _places_in(list(rows), batch.labels)
        watched = batch.left, batch.watched
        return Found(labels, batch.times, list(rows.values()), again, watched)


def labeller_of(rotor: Rotor | KnockedSystem, rtol: float | None, stop: Stop) -> Labeller:
    """Return who labels the starts of a rotor."""
    return Disc.of(rotor, rtol, stop) if isinstance(rotor, Rotor) else rotor


def _few(starts: Starts, count: int, most: int, drawn: bool) -> Values:
    """Return a few starts, shape (4, n): spread over all, or the first ones if they are drawn.

    What is chosen from these then does not depend on the number drawn, even if that is smaller.
    """
    if drawn:
        return starts(0, most)
    numbers = np.unique(np.linspace(0, count - 1, min(most, count)).astype(np.int64))
    if count <= ALL_AT_ONCE:
        return starts(0, count)[:, numbers]
    return np.concatenate([starts(number, number + 1) for number in numbers.tolist()], axis=1)


def first_look(rotor: Rotor, states: Values, duration: float, stop: Stop) -> Followed:
    """Follow starts of shape (4, n) briefly: those not yet trapped by a whirl stay undecided.

    This takes a small part of the time needed to decide all of them. No limit cycle is sought.
    """
    known = known_from_closed_forms(rotor, stop, fading=False)
    batch = Batch(known, states, RTOL_OF_FIRST_LOOK, stop)
    batch.follow(np.arange(states.shape[1]), min(duration, known.first_wait))
    rows = _rows_of(batch)
    labels = _places_in(list(rows), batch.labels)
    return Followed(labels, batch.times, np.array([*rows.values()], OF_DISC), RTOL_OF_FIRST_LOOK)


def whirls_of(known: Known, present: Collection[int] = ()) -> dict[int, np.void]:
    """Return the attractors that closed forms give as rows, by their labels.

    Whirls in contact and contact-free ones are listed with or without starts, touches that fade
    only if their label is `present`.
    """
    rotor, free = known.rotor, known.free
    still = rotor.omega == 0.0 and rotor.load == 0.0  # and comes to rest at the centre
    kind = response.CONTACT_FREE if still else response.SYNCHRONOUS
    rows = {
        number: disc_row(
            kind, each.amplitude, each.phase_lag, each.amplitude, each.amplitude,
            trapping=PROVEN if each.exists else NOTHING, state=each.centre,
        )
        for number, each in enumerate(known.whirls)
    }  # fmt: skip
    if free is None:
        return rows
    size, lag, alone = abs(free.whirl), phase_lag_of(free.whirl), known.is_followed_alone
    if free.room > 0.0 or known.free_label in present:
        radii = (abs(size - free.sag), size + free.sag) if free.alone else (math.nan, math.nan)
        rows[known.free_label] = disc_row(
            response.CONTACT_FREE, size, lag, *radii, trapping=NOTHING if alone else PROVEN
        )
    if known.fading_label in present:  # in the limit they just reach the stator
        one_by_one = alone or (may_remain(rotor) and free.excess == 0.0)
        rows[known.fading_label] = disc_row(
            response.TOUCHING, size, lag, abs(rotor.delta0 - 2.0 * size), rotor.delta0,
            trapping=NOTHING if one_by_one else ESTIMATED,
        )  # fmt: skip
    return rows


def cycle_row(cycle: Orbit, has_section: bool) -> np.void:
    """Return a limit cycle as a row; `has_section` sets its trapping evidence."""
    whirl = cycle.mean_whirl
    return disc_row(
        cycle.response, abs(whirl), phase_lag_of(whirl), cycle.radius_min, cycle.radius_max,
        period=cycle.duration, trapping=ESTIMATED if has_section else NOTHING, state=cycle.start,
    )  # fmt: skip


def _rows_of(batch: Batch) -> dict[int, np.void]:
    """Return the attractors of a batch as rows, by their labels in the batch."""
    known, present = batch.known, set(np.unique(batch.labels).tolist())
    rows = whirls_of(known, present)
    for number, each in enumerate(known.cycles, start=known.first_cycle):
        if number in present:
            rows[number] = cycle_row(each.cycle, each.exists)
    rows |= {label: row_of(batch.aperiodic[label]) for label in APERIODIC.values()
             if label in present}  # fmt: skip
    return rows


def _places_in(known: Sequence[int], labels: Labels) -> Labels:
    """Return the places of labels of a batch among the known ones.

    Labels of other attractors become the number behind the last, other fates UNDECIDED.
    """
    open_ = np.where(labels == NOT_COMPUTED, NOT_COMPUTED, UNDECIDED)
    places = np.where(labels >= 0, len(known), open_).astype(np.int16)
    for place, label in enumerate(known):
        places[labels == label] = place
    return places
