"""Label starts of a rotor system: follow each until it has settled, and match the attractors.

*Follow* a start as a sweep does. *Match* the motion on which it settles with those met before:
by its kind, its period and radii, and its state. A batch numbers its own attractors; those of all
batches are then matched in the same way, so that the labels do not depend on who followed what.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from operator import itemgetter

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Flags, Stop, Values
from rotor_ida.basins.attractors import CONTACT_FREE_FAMILY
from rotor_ida.basins.following import (
    Ended,
    follow_in_batches,
    rechecked_of_batch,
    rechecked_of_rotor,
    size_of_batch,
    spread_evenly,
    tighter_than,
    unlabelled,
)
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED, Labels, Times
from rotor_ida.basins.starts import Starts, stretches
from rotor_ida.basins.system_starts import KnockedSystem
from rotor_ida.core.runs import NO_STOP
from rotor_ida.parallel import Progress
from rotor_ida.results.studies.results import Form, Results
from rotor_ida.schema import RESPONSE
from rotor_ida.simulation.systems.flow import SystemFlow
from rotor_ida.steady.follow import settle
from rotor_ida.steady.grid import EXPECTED, Table, reason_of
from rotor_ida.steady.response import (
    ROLLING,
    SYNCHRONOUS,
    TOUCHING,
    UNRESOLVED,
)
from rotor_ida.steady.system_sweep import figures_of, point_of

# Two motions are on one attractor if their radii and periods, or their states, agree to this part.
SAME = 1e-5
RADII = (("radius_min", "node_radius_min"), ("radius_max", "node_radius_max"))
# The smallest batch: every start is followed by itself.
SMALLEST = 4
LABELLING = (
    "every start followed separately by Taylor series, as in a sweep with labelling_rtol; motions "
    "matched by kind, period, radii and state; some starts labelled again with agreement_rtol"
)


def how_labelled(rtol: float) -> dict[str, object]:
    """Return, as attributes, the method that labelled starts with a tolerance of runs."""
    return {
        "labelling": LABELLING, "labelling_method": "taylor", "labelling_rtol": rtol,
        "agreement_rtol": tighter_than(rtol),
    }  # fmt: skip


class Attractors:
    """The attractors on which motions of a flow have settled, in the order in which they were met.

    Each is the row of a settled response, as a sweep has it.
    """

    def __init__(self, flow: SystemFlow) -> None:
        self.flow = flow
        self.rows: list[np.void] = []
        self._strobed: dict[int, Values] = {}

    def label_of(self, row: np.void) -> int:
        """Return the number of the attractor of a settled response, which may be a new one."""
        number = self.find(row)
        if number is None:
            self.rows.append(row.copy())
            return len(self.rows) - 1
        self.rows[number] = _joined(self.rows[number], row)
        return number

    def find(self, row: np.void) -> int | None:
        """Return the number of the attractor of a settled response; None if it was not met."""
        return next((each for each in range(len(self.rows)) if self._is_on(each, row)), None)

    def _is_on(self, number: int, row: np.void) -> bool:
        """Return whether a settled response is on a known attractor.

        All contact-free motions are on one, all touches that fade on one, and so are all motions
        without a period of one kind, but for those that roll in different contacts.
        """
        known = self.rows[number]
        if known["response"] != row["response"]:
            return False
        if _is(row, *CONTACT_FREE_FAMILY):
            return True
        if _is(row, SYNCHRONOUS):
            return self._has_state(number, row)
        periods = np.array([known["period"], row["period"]])
        if np.isnan(periods).any():
            rolls_elsewhere = _is(row, ROLLING) and (known["touched"] != row["touched"]).any()
            return bool(np.isnan(periods).all() and not rolls_elsewhere)
        times = periods.max() / periods.min()  # round the cycle, which may be found as a multiple
        if abs(times / round(times) - 1.0) > SAME or _differing(known, row).any():
            return False
        # on turning axes a motion meets a cycle anywhere
        return self.flow.period is None or self._has_state(number, row)

    def _has_state(self, number: int, row: np.void) -> bool:
        """Return whether an attractor has the state at the end of a response."""
        if number not in self._strobed:
            self._strobed[number] = self._strobed_states(self.rows[number])
        strobed = self._strobed[number]
        apart = np.abs(strobed - self.flow.given_state(row["final_state"])).max(axis=1).min()
        return bool(apart <= SAME * np.abs(strobed).max())

    def _strobed_states(self, row: np.void) -> Values:
        """Return the states of an attractor after each revolution of its period."""
        states = [self.flow.given_state(row["final_state"])]
        period = 0.0 if math.isnan(row["period"]) else float(row["period"])
        for _ in range(round(period / self.flow.revolution) - 1):
            states.append(self.flow.after(states[-1], self.flow.revolution))
        return np.array(states)


def _is(row: np.void, *kinds: str) -> bool:
    return any(row["response"] == RESPONSE[kind] for kind in kinds)


def _radii(row: np.void) -> Values:
    """Return the smallest and largest radii of contacts and nodes, shape (2, place)."""
    return np.array([np.concatenate([row[name] for name in names]) for names in RADII])


def _differing(known: np.void, row: np.void) -> Flags:
    """Return which radii differ, relative to the largest, shape (2, place)."""
    one, other = _radii(known), _radii(row)
    return np.asarray(~(np.abs(one - other) <= SAME * np.nan_to_num(other).max()))


def _joined(known: np.void, row: np.void) -> np.void:
    """Return an attractor with one more of its motions.

    It has the shortest period that was found, and the range of radii that depend on the start.
    """
    if _is(row, SYNCHRONOUS):
        return known
    if not math.isnan(known["period"]):
        return min(known, row, key=itemgetter("period"))
    if _is(row, *CONTACT_FREE_FAMILY):
        radii = np.where(_differing(known, row), math.nan, _radii(known))
    else:
        (low, high), (lower, higher) = _radii(known), _radii(row)
        radii = np.array([np.minimum(low, lower), np.maximum(high, higher)])
    found, contacts = known.copy(), len(known["touched"])
    for names, each in zip(RADII, radii, strict=True):
        found[names[0]], found[names[1]] = each[:contacts], each[contacts:]
    for name in ("largest_force", "touched"):
        found[name] = np.maximum(known[name], row[name])
    return found


@dataclass(frozen=True, slots=True)
class _Job:
    """A batch of starts of a node, shape (4, n), from number `first` on.

    Some of them are labelled again, with a smaller tolerance.
    """

    knocked: KnockedSystem
    first: int
    states: Values
    rechecked: int


@dataclass(slots=True)
class SystemBatch:
    """Results of a batch of starts.

    Parameters
    ----------
    first : int
        Number of its first start.
    labels : ndarray of int16, shape (n,)
        Number of the row of the attractor, UNDECIDED or NOT_COMPUTED.
    times : ndarray of float32, shape (n,)
        For how long each start was followed; NaN where not computed.
    rows : structured array, shape (m,)
        The attractors, as settled responses.
    rechecked : ndarray of int64, shape (2,)
        Number of starts labelled again with a smaller tolerance, and of those with the same label.
    reason : str
        Why starts were not computed; else empty.
    """

    first: int
    labels: Labels
    times: Times
    rows: Table
    rechecked: npt.NDArray[np.int64]
    reason: str


FORM: Form[SystemBatch] = Form(
    "batch of starts of a rotor system",
    lambda batch: {each.name: np.asarray(getattr(batch, each.name)) for each in fields(batch)},
    lambda arrays: SystemBatch(
        int(arrays.pop("first")), reason=str(arrays.pop("reason")), **arrays
    ),
)


@dataclass(frozen=True, slots=True)
class FollowedSystem:
    """Followed starts of a rotor system.

    Parameters
    ----------
    labels, times : ndarray, shape (n,)
        Number of the attractor of each start, or its fate; and for how long it was followed.
    rows : structured array, shape (m,)
        The attractors, as settled responses: whirls, the contact-free motion, cycles, and motions
        without a period, each by the largest part of a clearance that they take.
    rechecked : ndarray of int64, shape (2,)
        As of a batch.
    ended : Ended
        How the computation ended.
    """

    labels: Labels
    times: Times
    rows: Table
    rechecked: npt.NDArray[np.int64]
    ended: Ended


def follow_starts_of_system(
    knocked: KnockedSystem,
    starts: Starts,
    count: int,
    kept: Results[SystemBatch],
    *,
    workers: int | None,
    executor: str,
    progress: Progress | None,
) -> FollowedSystem:
    """Follow each start until it has settled; batches that are stored already are not repeated."""
    size = size_of_batch(count, SMALLEST)

    def job(number: int, first: int, last: int) -> _Job:
        return _Job(knocked, first, starts(first, last), rechecked_of_batch(number, last - first))

    ended = follow_in_batches(
        _follow, lambda _due: job, count, size, kept,
        workers=workers, executor=executor, progress=progress,
    )  # fmt: skip
    return _gathered(knocked, count, kept, ended)


def follow_system_here(knocked: KnockedSystem, states: Values, stop: Stop) -> FollowedSystem:
    """Follow starts of a node, shape (4, n), in this process."""
    kept: Results[SystemBatch] = Results()
    count = states.shape[1]
    batch = _follow(_Job(knocked, 0, states, rechecked_of_rotor(count)), stop)
    kept.keep(0, batch, count)
    return _gathered(knocked, count, kept, Ended(reason=batch.reason))


def _gathered(
    knocked: KnockedSystem, count: int, kept: Results[SystemBatch], ended: Ended
) -> FollowedSystem:
    """Return the results of all starts, gathered from the batches."""
    labels, times = unlabelled(count, kept.folder)
    met = Attractors(SystemFlow.at(knocked.problem, knocked.speed, NO_STOP))
    rechecked = np.zeros(2, dtype=np.int64)
    for _, batch in kept.results():
        part = slice(batch.first, batch.first + batch.labels.size)
        labels[part] = _renumbered(batch.labels, [met.label_of(row) for row in batch.rows])
        times[part] = batch.times
        rechecked = rechecked + batch.rechecked
        ended = ended if ended.reason else ended._replace(reason=batch.reason)
    order = sorted(range(len(met.rows)), key=lambda each: _place(met, met.rows[each]))
    ranks = np.argsort(order).tolist()
    for part in stretches(labels.size):
        labels[part] = _renumbered(labels[part], ranks)
    rows = np.array([met.rows[each] for each in order], point_of(knocked.problem))
    return FollowedSystem(labels, times, rows, rechecked, ended)


def _follow(job: _Job, stop: Stop) -> SystemBatch:
    """Follow a batch of starts, each until it has settled."""
    knocked, count = job.knocked, job.states.shape[1]
    flow = SystemFlow.at(knocked.problem, knocked.speed, stop)
    met, states, reason = Attractors(flow), knocked.states(flow, job.states), ""
    labels, times = np.full(count, NOT_COMPUTED, np.int16), np.full(count, math.nan, np.float32)
    for number, state in enumerate(states):
        try:
            row = settled_row(flow, state)
            labels[number] = UNDECIDED if _is(row, UNRESOLVED) else met.label_of(row)
        except EXPECTED as error:
            if stop[0]:
                break
            reason = reason or reason_of(error)
        else:
            times[number] = row["revolutions"] * flow.revolution
    rechecked = _count_agreeing(met, states, labels, job.rechecked)
    rows = np.array(met.rows, point_of(knocked.problem))
    return SystemBatch(job.first, labels, times, rows, rechecked, reason)


def settled_row(flow: SystemFlow, state: Values) -> np.void:
    """Return the response on which a flow settles, as a row."""
    settled = settle(flow, state)
    row: np.void = np.zeros(1, point_of(flow.problem))[0]
    figures = figures_of(settled, flow, settled.state * flow.scales)
    for name, figure in figures.items():
        row[name] = figure
    if _is(row, TOUCHING):  # in the limit it just touches
        touched, gaps = row["touched"] == 1, flow.clearances
        row["largest_force"][touched], row["radius_max"][touched] = 0.0, gaps[touched]
        row["radius_min"][touched] = np.abs(gaps - 2.0 * row["amplitude"])[touched]
    return row


def _count_agreeing(
    met: Attractors, states: Values, labels: Labels, rechecked: int
) -> npt.NDArray[np.int64]:
    """Return how many starts were labelled again, and how many of them got the same label."""
    closely = met.flow.but(rtol=tighter_than(met.flow.problem.rtol))
    again = same = 0
    for number in spread_evenly(labels.size, rechecked).tolist():
        if labels[number] < 0 or met.flow.stop[0]:
            continue
        try:
            found = met.find(settled_row(closely, states[number]))
        except EXPECTED:
            continue
        again += 1
        same += found == labels[number]
    return np.array([again, same])


def _renumbered(labels: Labels, numbers: Sequence[int]) -> Labels:
    """Return labels with other numbers of attractors; the two fates stay."""
    # negative indices find them at the end
    table = np.array([*numbers, NOT_COMPUTED, UNDECIDED], np.int16)
    return table[labels]


def _place(met: Attractors, row: np.void) -> tuple[int, float]:
    """Return the place of an attractor among all."""
    has_period = not math.isnan(row["period"])
    kinds = [_is(row, SYNCHRONOUS), _is(row, *CONTACT_FREE_FAMILY), has_period, True]
    share = row["radius_max"] / met.flow.clearances
    return kinds.index(True), float(np.nanmax(share, initial=0.0))
