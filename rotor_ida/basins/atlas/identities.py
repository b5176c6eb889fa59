"""Identify attractors of neighbouring rotors by following each from rotor to rotor.

A limit cycle of one disc is followed along its branch by pseudo-arclength, a whirl along its exact
response curve. If it reaches the neighbour stable, it is an attractor there, even if no start ended
on it: this finds basins that no start has hit. The contact-free family, its touching edge, chaos
and motions with friction that have no period continue if both neighbours have them.

Two attractors of a rotor system are one if each leads to the other where the system is followed
from it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from rotor_ida.arrays import Stop
from rotor_ida.basins.atlas.cells import Cell, Member
from rotor_ida.basins.atlas.extents import amplitudes_along
from rotor_ida.basins.attractors import (
    APERIODIC,
    CONTACT_FREE_FAMILY,
    Attractors,
    has_period,
    kind_of,
    state_on,
)
from rotor_ida.basins.cycle_sections import cycle_section
from rotor_ida.basins.disc import cycle_row
from rotor_ida.basins.known import may_roll, same_numbers
from rotor_ida.basins.subjects import KnockedSystem, settled_row
from rotor_ida.cycles.branch import LIMITS, Side, advance
from rotor_ida.cycles.guess import Guess
from rotor_ida.cycles.multipliers import is_stable
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.cycles.problems import branch_through
from rotor_ida.cycles.shooting import close_orbit
from rotor_ida.errors import SimulationError
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import RESPONSE
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.system_flow import SystemFlow
from rotor_ida.steady import response
from rotor_ida.steady.grid import EXPECTED

# Largest number of points of a branch of limit cycles from one rotor to the next.
MOST_POINTS = 400
# Number of steps in which a whirl is followed from one rotor to the next: its amplitude may change
# twentyfold in all.
STEPS = 64
# Relative agreement of amplitudes for two whirls to be the same: both are exact to rounding.
SAME_WHIRL = 1e-9
# A rotor has at most one attractor of each of these kinds, the same as its neighbour's.
SHARED = (response.CONTACT_FREE, response.TOUCHING, response.CHAOTIC)
# Periods of neighbouring attractors of a system that are one differ by less than this factor: where
# a period doubles, there is another one.
NEW_PERIOD = 1.5


def identify(cells: Sequence[Cell], lines: Sequence[Sequence[int]], stop: Stop) -> int:
    """Assign numbers to the attractors of all cells; return how many there are.

    `lines` contains the numbers of the cells along each line of the grid, one parameter rising. One
    that continues an attractor of a neighbour, but that no start ends on, is added to its cell.
    """
    links: list[tuple[Member, Member]] = []
    joined: set[tuple[int, int]] = set()  # an attractor, and the neighbour in which it was found
    for line in lines:
        for way in (list(line), list(reversed(line))):
            for here, there in pairwise(way):
                if stop[0]:
                    return 0
                for member in list(cells[here].members):
                    if (id(member), there) in joined:
                        continue
                    other = _successor(member, cells[here], cells[there], stop)
                    if other is not None:
                        links.append((member, other))
                        joined |= {(id(member), there), (id(other), here)}
    for kind in CONTACT_FREE_FAMILY:  # wherever they are, they are whirls of one family
        alike = [each for cell in cells for each in cell.members if each.kind == kind]
        links += pairwise(alike)
    return _numbered(cells, links)


def _successor(member: Member, here: Cell, there: Cell, stop: Stop) -> Member | None:
    """Return the attractor of a neighbour that continues one, if there is one."""
    if isinstance(here.rotor, KnockedSystem):
        return _successor_in_system(member, here.rotor, there, stop)
    return _successor_of_disc(member, here.rotor, there, stop)


def _successor_of_disc(member: Member, rotor: Rotor, there: Cell, stop: Stop) -> Member | None:
    kind, period = member.kind, has_period(member.row)
    assert isinstance(there.rotor, Rotor)
    if kind in SHARED or (may_roll(rotor) and kind in APERIODIC and not period):
        alike = [each for each in there.members if each.kind == kind]
        return next((each for each in alike if not has_period(each.row)), None)
    if kind == response.SYNCHRONOUS:
        amplitude = followed_whirl(float(member.row["amplitude"]), rotor, there.rotor)
        for each in there.members:
            apart = abs(each.row["amplitude"] - amplitude)
            if each.kind == kind and apart <= SAME_WHIRL * amplitude:
                return each
        return None
    known = [each for each in there.members if has_period(each.row)]
    cycle = followed_cycle(member.row, rotor, there.rotor, stop)
    if cycle is None:
        return None
    for each in known:
        if same_numbers(float(each.row["period"]), float(each.row["radius_max"]), cycle):
            return each
    there.members.append(Member(cycle_row(cycle, cycle_section(cycle, stop).exists)))
    return there.members[-1]


def _successor_in_system(
    member: Member, here: KnockedSystem, there: Cell, stop: Stop
) -> Member | None:
    row = member.row
    assert isinstance(there.rotor, KnockedSystem)
    flows = [each.flow(stop) for each in (here, there.rotor)]
    found = _led_to(row, flows[1])
    if found is None or not _may_continue(row, found):
        return None
    if member.kind not in CONTACT_FREE_FAMILY:  # of which there is one
        back = _led_to(found, flows[0])
        if back is None or Attractors(flows[0], [row]).find(back) is None:
            return None
    number = Attractors(flows[1], [each.row for each in there.members]).find(found)
    if number is None:
        there.members.append(Member(found))
        return there.members[-1]
    return there.members[number]


def _led_to(row: np.void, flow: SystemFlow) -> np.void | None:
    """Return what a flow settles on from the end of a response; None if it fails."""
    try:
        return settled_row(flow, state_on(flow, row))
    except EXPECTED:
        return None


def _may_continue(row: np.void, other: np.void) -> bool:
    """Return whether two motions may be one attractor at neighbouring points."""
    if not (has_period(row) and has_period(other)):
        return has_period(row) == has_period(other) and kind_of(row) == kind_of(other)
    periods = sorted((row["period"], other["period"]))
    return bool(periods[1] < NEW_PERIOD * periods[0])


def followed_cycle(row: np.void, here: Rotor, there: Rotor, stop: Stop) -> Orbit | None:
    """Return the stable limit cycle that one becomes as a parameter changes; None if it ends."""
    name = _changed(here, there)
    begin, end = getattr(here, name), getattr(there, name)
    state, period = row["final_state"], float(row["period"])
    limits = (min(begin, end), max(begin, end))
    try:
        if name == "disc_radius" and here.friction == 0.0:  # no cycle depends on it
            return close_orbit(DiscFlow(there, stop), state, period)
        guess = Guess(DiscFlow(here, stop), state, period)
        course = branch_through(guess, name, limits, MOST_POINTS)
        rising = course.first.tangent[-1] > 0.0
        side = Side([course.first if rising == (end > begin) else course.first.reversed()])
        while not side.end:
            advance(course, side)
        last = side.points[-1]
        if side.end != LIMITS or last.unknowns[-1] != end or not is_stable(last.orbit):
            return None
        return close_orbit(DiscFlow(there, stop), last.unknowns[:4], float(last.unknowns[4]))
    except SimulationError:
        return None


def followed_whirl(amplitude: float, here: Rotor, there: Rotor) -> float:
    """Return the amplitude of a whirl after parameters have changed; NaN if it ends."""
    name = _changed(here, there)
    if name == "disc_radius":  # whirls do not depend on it
        return amplitude
    begin, end = getattr(here, name), getattr(there, name)
    # amplitudes are powers of a small speed
    spread = np.geomspace if begin > 0.0 and end > 0.0 else np.linspace
    values = spread(begin, end, STEPS + 1)
    return float(amplitudes_along(there, amplitude, name, values[1:])[-1])


def _changed(here: Rotor, there: Rotor) -> str:
    """Return the parameter in which two neighbours differ."""
    return next(each for each in ALL_PARAMETERS if getattr(here, each) != getattr(there, each))


def _numbered(cells: Sequence[Cell], links: Sequence[tuple[Member, Member]]) -> int:
    """Give linked attractors one number, and no two of one cell the same."""
    members = [each for cell in cells for each in cell.members]
    place = {id(each): number for number, each in enumerate(members)}
    within = [{number} for number, cell in enumerate(cells) for _ in cell.members]  # its cells
    above = list(range(len(members)))  # each group is a tree below its first member

    def first_of(member: Member) -> int:
        number = place[id(member)]
        while above[number] != number:
            above[number] = above[above[number]]
            number = above[number]
        return number

    for one, other in links:
        first, second = sorted((first_of(one), first_of(other)))
        # around a cusp the two whirls of one rotor are joined: they stay separate
        if first != second and not within[first] & within[second]:
            above[second] = first
            within[first] |= within[second]
    groups = [first_of(each) for each in members]
    order = _ordered(list(zip(groups, members, strict=True)))
    for group, each in zip(groups, members, strict=True):
        each.identity = order[group]
    return len(order)


def _ordered(members: Sequence[tuple[int, Member]]) -> dict[int, int]:
    """Return the number of each group: by kind of response, then in order of occurrence."""
    kinds: dict[int, list[int]] = {}
    for group, each in members:
        kinds.setdefault(group, []).append(RESPONSE[each.kind])
    usual = {group: max(set(found), key=found.count) for group, found in kinds.items()}
    ordered = sorted(usual, key=lambda group: (usual[group], group))
    return {group: number for number, group in enumerate(ordered)}
