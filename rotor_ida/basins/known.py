"""What is known of the attractors of a rotor while starts are followed, and what holds the starts.

Whirls in contact have trapping regions and contact-free whirls room, which are proven to hold an
orbit; limit cycles have sections, and fading touches a rim of that room, which are estimated.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.basins.contact_free_whirls import (
    ContactFree,
    contact_free_whirl_under_load,
    contact_free_whirls,
)
from rotor_ida.basins.cycle_sections import CycleSection, cycle_section
from rotor_ida.basins.kernel import NOT_COMPUTED, REGION, SECTION, Labels, Times, follow
from rotor_ida.basins.trapping_regions import TrappingRegion, trapping_regions
from rotor_ida.closed_forms.rest import rest
from rotor_ida.cycles.shooting import Cycle
from rotor_ida.model.parameters import Rotor
from rotor_ida.parallel import Stop
from rotor_ida.steady.follow import durations

# Two cycles of one rotor are the same when period and largest radius differ by less than this part.
SAME = 1e-6
# What the kernel is told where there is no contact-free whirl.
NO_FREE = np.array([0.0, 0.0, -1.0, -1.0])


def followed_alone(rotor: Rotor) -> bool:
    """Return whether each start is followed by itself, as a load leaves no region."""
    return rotor.load > 0.0


def may_roll(rotor: Rotor) -> bool:
    """Return whether the disc of a rotor may roll, or slide backwards: with friction.

    Lanes follow it for as long as it slides forwards. What they cannot follow, or no region holds,
    is followed by itself.
    """
    return rotor.friction > 0.0


@dataclass(slots=True)
class Known:
    """A rotor with what is known of its attractors."""

    rotor: Rotor
    whirls: list[TrappingRegion]  # of each stable whirl in contact, in order of amplitude
    free: ContactFree | None  # the contact-free whirls, if they fit into the clearance
    # of each stable limit cycle, in the order in which they were found
    cycles: list[CycleSection] = field(default_factory=list)

    @property
    def free_label(self) -> int:
        """Label of the starts that never touch the ring again."""
        return len(self.whirls)

    @property
    def fading_label(self) -> int:
        """Label of the starts that touch it ever more slightly."""
        return len(self.whirls) + 1

    @property
    def first_cycle(self) -> int:
        """Label of the first limit cycle."""
        return len(self.whirls) + 2

    @property
    def first_wait(self) -> float:
        """Time in which damping settles most starts [1]: what is left over then is looked at."""
        return durations(self.rotor)[0]

    def label_of_cycle(self, cycle: Cycle) -> int | None:
        """Return the label of a limit cycle, or None if it is not known."""
        for number, section in enumerate(self.cycles):
            if same_cycle(section.cycle, cycle):
                return self.first_cycle + number
        return None

    def tables(self) -> tuple[Values, Values, Values]:
        """Return whirls, contact-free whirl and cycles as the kernel wants them."""
        whirls = np.array([each.numbers for each in self.whirls]).reshape(-1, REGION)
        sections = np.array([each.numbers for each in self.cycles]).reshape(-1, SECTION)
        return whirls, NO_FREE if self.free is None else self.free.numbers, sections

    def follow(
        self, states: Values, duration: float, tolerance: float, stop: Stop
    ) -> tuple[Labels, Times]:
        """Follow states, shape (4, n), in place, until a region holds them, or for a time.

        Return their labels, UNDECIDED where none does, and the times that it took [1].
        """
        labels = np.full(states.shape[1], NOT_COMPUTED, dtype=np.int16)
        times = np.zeros(labels.size, dtype=np.float32)
        follow(states, labels, times, self.rotor, *self.tables(), duration, tolerance, stop)
        return labels, times


def same_cycle(one: Cycle, other: Cycle) -> bool:
    """Return whether two limit cycles of a rotor are one, whatever their phases."""
    return same_numbers(one.period, one.radius_max, other)


def same_numbers(period: float, radius_max: float, cycle: Cycle) -> bool:
    """Return whether a limit cycle has this period and largest radius."""
    apart = abs(period / cycle.period - 1.0), abs(radius_max / cycle.radius_max - 1.0)
    return max(apart) <= SAME


def known_from_closed_forms(rotor: Rotor, stop: Stop, *, fading: bool = True) -> Known:
    """Return the attractors of a damped rotor that closed forms give.

    Without `fading` it is not sought which touches fade; that takes longest.
    """
    if rotor.load > 0.0:
        return _under_load(rotor)
    if rotor.omega == 0.0 and rotor.delta0 == 0.0:
        # All comes to rest, for energy only falls, but as slowly as 1/t**2: close by is enough.
        near = TrappingRegion(0.0, 0.0, np.zeros(4), 1e4 * np.eye(4))
        return Known(rotor, [near], None)
    whirls = trapping_regions(rotor) if rotor.omega > 0.0 else []
    return Known(rotor, whirls, contact_free_whirls(rotor, stop, fading=fading))


def _under_load(rotor: Rotor) -> Known:
    """Return the attractors under a load that closed forms give, without what holds starts there.

    That is the whirl about where the shaft holds the load, if it stays inside the clearance, or of
    a rotor that does not turn the place where it comes to rest.
    """
    free = contact_free_whirl_under_load(rotor)
    if free is not None or rotor.omega > 0.0:
        return Known(rotor, [], free)
    size = abs(rest(rotor)["y"].item())
    centre = np.array([0.0, -size, 0.0, 0.0])
    return Known(rotor, [TrappingRegion(size, 0.5 * np.pi, centre, np.full((4, 4), np.inf))], None)


def with_cycle(known: Known, cycle: Cycle, stop: Stop) -> Known:
    """Return what is known with one limit cycle more."""
    section = cycle_section(cycle, stop)
    return Known(known.rotor, known.whirls, known.free, [*known.cycles, section])
