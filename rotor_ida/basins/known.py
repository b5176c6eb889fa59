"""The attractors that are known while starts are followed, with what holds the starts on them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.basins.cycle_sections import CycleSection, cycle_section
from rotor_ida.basins.fading import fading_excess
from rotor_ida.basins.kernel import REGION, SECTION
from rotor_ida.basins.trapping_regions import TrappingRegion, trapping_regions
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.cycles.shooting import Cycle
from rotor_ida.parallel import Stop
from rotor_ida.parameters import Rotor
from rotor_ida.steady_state.response import phase_lag_of

lag_of = phase_lag_of
# Two cycles of one rotor are the same when period and largest radius differ by less than this part.
SAME = 1e-6
_NO_FREE = np.array([0.0, 0.0, -1.0, -1.0])


@dataclass(slots=True)
class Known:
    """What is known of the attractors of a rotor.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    whirls : list of TrappingRegion
        Of each stable whirl in contact, in order of amplitude.
    free : ndarray, shape (4,)
        Contact-free whirl on the rotating axes [1], and the squared radii within which its centre
        stays, and from within which touches fade; negative if there is no such whirl.
    cycles : list of CycleSection
        Of each stable limit cycle, in the order in which they were found.
    """

    rotor: Rotor
    whirls: list[TrappingRegion]
    free: Values
    cycles: list[CycleSection] = field(default_factory=list)

    @property
    def has_free(self) -> bool:
        """Whether there is a contact-free whirl."""
        return bool(self.free[2] >= 0.0)

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
        return whirls, self.free, sections


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
    if rotor.omega == 0.0 and rotor.delta0 == 0.0:
        # All comes to rest, for energy only falls, but as slowly as 1/t**2: close by is enough.
        near = TrappingRegion(0.0, 0.0, np.zeros(4), 1e4 * np.eye(4))
        return Known(rotor, [near], _NO_FREE)
    whirls = trapping_regions(rotor) if rotor.omega > 0.0 else []
    whirl = complex(complex_amplitude(rotor.omega, rotor.zeta))
    room = rotor.delta0 - abs(whirl)
    if not room > 0.0:
        return Known(rotor, whirls, _NO_FREE)
    excess = fading_excess(rotor, stop) if fading else 0.0
    edge = (room + excess) ** 2 if excess > 0.0 else -1.0  # NaN where nothing turns
    return Known(rotor, whirls, np.array([whirl.real, whirl.imag, room**2, edge]))


def with_cycle(known: Known, cycle: Cycle, stop: Stop) -> Known:
    """Return what is known with one limit cycle more."""
    section = cycle_section(cycle, stop)
    return Known(known.rotor, known.whirls, known.free, [*known.cycles, section])
