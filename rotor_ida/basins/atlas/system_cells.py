"""A rotor system at one point of an atlas: its attractors, what they do to it, and shocks.

There are no trapping regions: each start and each shock is followed until it has settled, and the
motions are matched. So there are no bounds below which no shock leaves an attractor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from math import nan
from typing import Any

import numpy as np

from rotor_ida.arrays import Arrays, Stop, Values
from rotor_ida.basins.atlas.cells import NEVER, Cell, Member, arrays_of, cell_from, cell_of
from rotor_ida.basins.atlas.resilience import LARGER, LARGEST, SMALLEST, Fill, Resilience
from rotor_ida.basins.atlas.rubbing import REVOLUTIONS, SAMPLES
from rotor_ida.basins.atlas.shocks import KINDS, ONE_BY_ONE, Blows, Source, try_shocks
from rotor_ida.basins.attractors import CONTACT_FREE_FAMILY
from rotor_ida.basins.following import tighter_than
from rotor_ida.basins.kernel import UNDECIDED, Labels
from rotor_ida.basins.system_labels import (
    Attractors,
    FollowedSystem,
    follow_system_here,
    settled_row,
)
from rotor_ida.basins.system_starts import KnockedSystem
from rotor_ida.core.runs import NO_STOP
from rotor_ida.core.systems import SystemResult
from rotor_ida.model.whirl import steps_of_turning, whirl_over_spin
from rotor_ida.results.studies.results import Form
from rotor_ida.schema import RESPONSE, by_number
from rotor_ida.schema.flags import ENTRY
from rotor_ida.simulation.systems.flow import SystemFlow
from rotor_ida.steady.grid import EXPECTED
from rotor_ida.steady.response import SYNCHRONOUS
from rotor_ida.steady.system_sweep import OF_CONTACT, OF_NODE

# States of an attractor to which shocks are given.
PLACES = 64
# Periods of neighbouring attractors that are one differ by less than this factor: where a period
# doubles, there is another one.
NEW_PERIOD = 1.5
# Kinds of motion that move at the speed of the unbalance alone.
AT_THE_SPIN = (*CONTACT_FREE_FAMILY, SYNCHRONOUS)
# Lines at less than this part of the speed stand still; and those below this part of the largest
# are rounding, or what has not quite settled.
STANDS_STILL, NO_LINE = 1e-6, 1e-6
_KIND = by_number(RESPONSE)


@dataclass(frozen=True, slots=True)
class SettledAttractor:
    """An attractor of a rotor system: the row of a settled response."""

    row: np.void

    @property
    def kind(self) -> str:
        """One of the kinds of `rotor_ida.steady.response`."""
        return _KIND[int(self.row["response"])]

    @property
    def numbers(self) -> dict[str, Any]:
        """What is reported of it, by name."""
        own = ("period", *OF_CONTACT, "touched", *OF_NODE, "final_state")
        return {name: self.row[name] for name in own} | {"kind": self.row["response"]}


SystemCell = Cell[KnockedSystem, SettledAttractor]


@dataclass(frozen=True, slots=True)
class SystemCellJob:
    """A rotor system with starts of its node, shape (4, n), and the number of shocks to try."""

    knocked: KnockedSystem
    states: Values
    shocks: int


def fill_system_cell(job: SystemCellJob, stop: Stop) -> SystemCell:
    """Follow all starts of a rotor system, count them by attractor, and try shocks."""
    cell = counted_system_cell(job, follow_system_here(job.knocked, job.states, stop))
    for fill in system_fills_of(cell, job.shocks):
        fill(stop)
    return cell


def counted_system_cell(job: SystemCellJob, followed: FollowedSystem) -> SystemCell:
    """Return the cell of followed starts."""
    attractors = [SettledAttractor(row) for row in followed.rows]
    return cell_of(job.knocked, attractors, job.states, followed)


def system_fills_of(cell: SystemCell, shocks: int) -> list[Fill]:
    """Return independent jobs that find the smallest shocks from each attractor."""
    if not shocks or not cell.members:
        return []
    count, size = len(cell.members), cell.members[0].attractor.row["final_state"].size
    cell.largest_shocks = _largest_shocks(cell)
    for each in cell.members:
        each.resilience = Resilience(
            np.full((2, count), np.nan), np.full((2, count, size), np.nan),
            np.full((2, count, size), np.nan), np.full((2, count), np.nan),
            np.empty((0, 2)), np.empty((0, 2), np.int8),
        )  # fmt: skip
    return [partial(_fill_shocks, cell, shocks, number) for number in range(count)]


def _largest_shocks(cell: SystemCell) -> tuple[float, float]:
    """Return the largest change of velocity and of displacement that is tried."""
    radii = [each.attractor.row[name] for each in cell.members
             for name in ("radius_max", "node_radius_max")]  # fmt: skip
    gaps = [each.clearance for each in cell.rotor.problem.assembly.contacts]
    size = LARGEST * float(np.nanmax(np.concatenate([gaps, *radii])))
    return size * abs(cell.rotor.speed), size


def _fill_shocks(cell: SystemCell, shocks: int, number: int, stop: Stop) -> None:
    """Fill in the smallest shocks from one attractor to each other."""
    flow = SystemFlow.at(cell.rotor.problem, cell.rotor.speed, stop)
    closely = flow.but(rtol=tighter_than(flow.problem.rtol))
    met, source = _met(cell, flow), _source_of(cell.members[number].attractor.row, flow)
    resilience = cell.members[number].resilience
    assert resilience is not None
    for row, (kind, largest) in enumerate(zip(KINDS, cell.largest_shocks, strict=True)):
        changes = cell.rotor.shapes[:, KINDS[kind] : KINDS[kind] + 2] / flow.scales[:, np.newaxis]
        blows = Blows(source, changes, lambda states: _ends_of(met, flow, states.T))
        own, sizes = met.find(cell.members[number].attractor.row), (SMALLEST * largest, largest)
        assert own is not None
        tried, scatter = try_shocks(blows, own, sizes, shocks, row, ONE_BY_ONE)
        for label in scatter:
            for place in tried.smallest(label, LARGER):
                if _ends_of(met, closely, tried.after[:, place : place + 1].T)[0] == label:
                    resilience.sizes[row, label] = tried.sizes[place]
                    resilience.scatter[row, label] = scatter[label]
                    for kept, states in ((resilience.before, tried.before),
                                         (resilience.after, tried.after)):  # fmt: skip
                        kept[row, label] = flow.in_q(states[:, place])
                    break


def _met(cell: SystemCell, flow: SystemFlow) -> Attractors:
    """Return the attractors of a cell, in their order."""
    met = Attractors(flow)
    met.rows.extend(each.attractor.row for each in cell.members)
    return met


def _ends_of(met: Attractors, flow: SystemFlow, states: Values) -> Labels:
    """Return the numbers of the attractors to which states, shape (n, m), lead; or UNDECIDED."""
    labels = np.full(len(states), UNDECIDED, np.int16)
    for number, state in enumerate(states):
        if flow.stop[0]:
            break
        try:
            found = met.find(settled_row(flow, state))
        except EXPECTED:
            continue
        labels[number] = UNDECIDED if found is None else found
    return labels


def _source_of(row: np.void, flow: SystemFlow) -> Source:
    """Return a source of states of an attractor.

    In a system that is not axisymmetric they are those after whole revolutions, where runs begin.
    """
    state, times = flow.given_state(row["final_state"]), np.zeros(1)
    if _KIND[int(row["response"])] not in AT_THE_SPIN:
        turns = REVOLUTIONS if math.isnan(row["period"]) else row["period"] / flow.revolution
        if flow.period is None:
            times = np.linspace(0.0, turns * flow.revolution, PLACES, endpoint=False)
        else:
            times = flow.revolution * np.arange(round(turns))
    states = [state]
    for step in np.diff(times).tolist():
        states.append(flow.after(states[-1], step))
    table = np.array(states).T
    count = len(states)
    return lambda places: table[:, np.floor(places[0] * count).astype(np.int64) % count]


# ---- From one point to the next ----


def successor_in_system(
    member: Member[SettledAttractor], here: KnockedSystem, there: SystemCell, stop: Stop
) -> Member[SettledAttractor] | None:
    """Return the attractor of a neighbouring point that continues one of a rotor system.

    They are one if each leads to the other where the system is followed from it. One that no start
    of the neighbour ends on is added to it.
    """
    row = member.attractor.row
    flows = [SystemFlow.at(each.problem, each.speed, stop) for each in (here, there.rotor)]
    found = _led_to(row, flows[1])
    if found is None or not _may_continue(row, found):
        return None
    if member.attractor.kind not in CONTACT_FREE_FAMILY:  # of which there is one
        back, begun = _led_to(found, flows[0]), Attractors(flows[0])
        begun.rows.append(row)
        if back is None or begun.find(back) is None:
            return None
    number = _met(there, flows[1]).find(found)
    if number is None:
        there.members.append(Member(SettledAttractor(found), 0, NEVER, np.full(4, np.nan)))
        return there.members[-1]
    return there.members[number]


def _led_to(row: np.void, flow: SystemFlow) -> np.void | None:
    """Return what a flow settles on from the end of a response; None if it fails."""
    try:
        return settled_row(flow, flow.given_state(row["final_state"]))
    except EXPECTED:
        return None


def _may_continue(row: np.void, other: np.void) -> bool:
    """Return whether two motions may be one attractor at neighbouring points."""
    periods = np.array([row["period"], other["period"]])
    if np.isnan(periods).any():
        return bool(np.isnan(periods).all() and row["response"] == other["response"])
    return bool(periods.max() < NEW_PERIOD * periods.min())


# ---- What an attractor does to the system ----


def numbers_of_system(row: np.void, knocked: KnockedSystem) -> dict[str, Any]:
    """Return the forces and losses of an attractor, from a period of it or many revolutions."""
    flow = SystemFlow.at(knocked.problem, knocked.speed, NO_STOP)
    turns = REVOLUTIONS if math.isnan(row["period"]) else float(row["period"]) / flow.revolution
    kind = _KIND[int(row["response"])]
    if kind in AT_THE_SPIN:
        turns = 1.0
    duration, contacts = turns * flow.revolution, flow.problem.assembly.contacts
    times = np.linspace(0.0, duration, math.ceil(SAMPLES * turns) + 1)
    run = flow.sampled(flow.given_state(row["final_state"]), times)
    table, count = run.episodes, len(contacts)

    def summed(values: Values) -> Values:
        own = np.bincount(table["contact"].astype(np.int64), values, minlength=count)
        return own.astype(np.float64)  # of no episodes it has whole numbers

    # touches that fade last for no time in the limit
    lasting = 0.0 if kind in CONTACT_FREE_FAMILY else 1.0
    closed = lasting * summed(
        np.nan_to_num(table["exit"], nan=duration) - np.nan_to_num(table["entry"])
    )
    entries = run.event_contacts[run.event_kinds == ENTRY]
    heat, damped = summed(table["heat"]) / turns, [each.damping > 0.0 for each in contacts]
    loss = np.where(damped, summed(table["work"]) / turns, 0.0)
    of_friction = {
        "heat_per_revolution": heat,
        "slip_distance_per_revolution": summed(table["slip_distance"]) / turns,
        "rolling_fraction": summed(table["rolling_time"]) / np.where(closed > 0.0, closed, 1.0),
    } if any(each.friction > 0.0 for each in contacts) else {}  # fmt: skip
    return {
        "excursion": row["radius_max"] / flow.clearances,
        "mean_force": lasting * summed(table["impulse"]) / duration,
        "contacts_per_revolution": np.bincount(entries, minlength=count) / turns,
        "contact_fraction": closed / duration,
        "dissipation_per_revolution": run.ledger["damping"] / turns + float((heat + loss).sum()),
        **({"contact_loss_per_revolution": loss} if any(damped) else {}), **of_friction,
        **_whirls(flow, run, times, at_the_spin=kind in AT_THE_SPIN),
    }  # fmt: skip


def _whirls(
    flow: SystemFlow, run: SystemResult, times: Values, *, at_the_spin: bool
) -> dict[str, Any]:
    """Return sense and speed of the whirl of each node, and its strongest line other than 1X."""
    size, way = 2 * flow.problem.assembly.size, math.copysign(1.0, flow.speed)
    states = run.samples.reshape(len(times), -1) / flow.scales[:size]
    places = flow.places(states, nodes=True)[0, :, flow.clearances.size :]
    places = places if way > 0.0 else places.conj()  # lines of forward whirls are positive
    if at_the_spin or flow.period is not None:  # a stationary line is no whirl
        places = places - places[:-1].mean(axis=0)
    angles = abs(flow.speed) * times
    sizes = np.abs(np.fft.fft((places * np.exp(-1j * angles)[:, np.newaxis])[:-1], axis=0))
    orders = 1.0 + np.fft.fftfreq(len(sizes), 1.0 / len(sizes)) * (2.0 * math.pi / angles[-1])
    sizes[np.abs(orders) < STANDS_STILL] = 0.0
    forward, backward = (np.linalg.norm(sizes[part], axis=0) for part in (orders > 0, orders < 0))
    turned = np.array([steps_of_turning(each).sum() for each in places.T])
    ratio, sense = whirl_over_spin(turned, angles[-1], forward, backward)
    largest = sizes.max(axis=0)
    sizes[0] = 0.0  # 1X, which is all of a motion that stands still on turning axes
    sizes *= not (at_the_spin and flow.period is None)
    strongest = np.where(sizes.max(axis=0) > NO_LINE * largest, orders[sizes.argmax(axis=0)], nan)
    return {"whirl_over_spin": ratio, "whirl_sense": sense, "side_line_over_spin": strongest}


# ---- In a study ----


def _as_arrays(cell: SystemCell) -> Arrays:
    return arrays_of(cell) | {"rows": np.array([each.attractor.row for each in cell.members])}


def system_form(knocked: KnockedSystem) -> Form[SystemCell]:
    """Return how cells are stored; the system is that of the first point until it is replaced."""
    return Form(
        "cell of an atlas of a rotor system", _as_arrays,
        lambda arrays: cell_from(
            knocked, [SettledAttractor(row) for row in arrays.pop("rows")], arrays
        ),
    )  # fmt: skip
