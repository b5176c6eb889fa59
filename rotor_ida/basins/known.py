"""The known attractors of a rotor while starts are followed, and their trapping regions.

The regions of whirls in contact, and the room of contact-free whirls, are proven to trap orbits.
The sections of limit cycles, and the rim of that room for fading touches, are estimated.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from rotor_ida.arrays import Stop, Values
from rotor_ida.basins.cycle_sections import CycleSection, cycle_section
from rotor_ida.basins.kernel import (
    CONTACT_FREE,
    NO_CONTACT_FREE,
    NOT_COMPUTED,
    REGION,
    SECTION,
    Labels,
    Rows,
    Times,
    follow,
)
from rotor_ida.basins.trapping_regions import TrappingRegion, trapping_regions
from rotor_ida.closed_forms import touch_fading
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.errors import SimulationError
from rotor_ida.model.disc_starts import radius_at_rest
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run
from rotor_ida.steady.follow import durations
from rotor_ida.steady.response import GRAZES, grazing_distance

# Two cycles of one rotor are the same if period and largest radius agree to this fraction.
SAME = 1e-6


def followed_alone(rotor: Rotor) -> bool:
    """Return whether starts are followed one by one, as there are no regions.

    There are none under a load at rest, nor where the contact-free whirl just reaches the stator.
    """
    return (rotor.load > 0.0 and rotor.omega == 0.0) or abs(grazing_distance(rotor)) <= GRAZES


def may_roll(rotor: Rotor) -> bool:
    """Return whether the disc of a rotor may roll or slide backwards, that is, has friction."""
    return rotor.friction > 0.0


def may_remain(rotor: Rotor) -> bool:
    """Return whether starts that enter no region are followed one by one, from their beginning.

    With friction the kernel follows the disc while it slides forwards; under a load no whirl has a
    region, and limit cycles have one once they are found.
    """
    return may_roll(rotor) or rotor.load > 0.0


@dataclass
class Known:
    """A rotor with its known attractors."""

    rotor: Rotor
    whirls: list[TrappingRegion]  # of each stable whirl in contact, in order of amplitude
    free: ContactFree | None  # the contact-free whirls, if they fit into the clearance
    # of each stable limit cycle, in the order in which they were found
    cycles: list[CycleSection] = field(default_factory=list)

    @cached_property
    def is_followed_alone(self) -> bool:
        """Whether starts are followed one by one."""
        return followed_alone(self.rotor)

    @property
    def free_label(self) -> int:
        """Label of the starts that never touch the stator again."""
        return len(self.whirls)

    @property
    def fading_label(self) -> int:
        """Label of the starts whose touches fade for ever."""
        return len(self.whirls) + 1

    @property
    def first_cycle(self) -> int:
        """Label of the first limit cycle."""
        return len(self.whirls) + 2

    @property
    def first_wait(self) -> float:
        """Time in which damping settles most starts [1]: the remaining ones are then examined."""
        return durations(self.rotor)[0]

    def label_of_cycle(self, cycle: Orbit) -> int | None:
        """Return the label of a limit cycle, or None if it is not known."""
        for number, section in enumerate(self.cycles):
            if same_numbers(section.cycle.duration, section.cycle.radius_max, cycle):
                return self.first_cycle + number
        return None

    def tables(self) -> tuple[Rows, Rows, Rows]:
        """Return whirls, contact-free whirl and cycles in the kernel's format.

        Under a load the cycles take the place of the whirls.
        """
        loaded = self.rotor.load > 0.0
        regions, sections = (self.cycles, []) if loaded else (self.whirls, self.cycles)
        return (
            np.array([each.row for each in regions], dtype=REGION),
            NO_CONTACT_FREE if self.free is None else self.free.row,
            np.array([each.row for each in sections], dtype=SECTION),
        )

    def follow(
        self, states: Values, duration: float, tolerance: float, stop: Stop
    ) -> tuple[Labels, Times]:
        """Follow states, shape (4, n), in place, until they enter a region, or for a time.

        Return their labels, UNDECIDED if they enter none, and the times that they took
        [dimensionless]. Under a load the states are those at a whole revolution, and the time is
        lengthened to such.
        """
        if self.rotor.load > 0.0:
            revolution = 2.0 * math.pi / self.rotor.omega
            duration = math.ceil(duration / revolution) * revolution
        labels = np.full(states.shape[1], NOT_COMPUTED, dtype=np.int16)
        times = np.zeros(labels.size, dtype=np.float32)
        follow(states, labels, times, self.rotor, *self.tables(), duration, tolerance, stop)
        if self.rotor.load > 0.0:  # regions of cycles come first
            cycles, held = len(self.cycles), labels >= 0
            places = [*range(self.first_cycle, self.first_cycle + cycles), self.free_label]
            labels[held] = np.array(places, np.int16)[labels[held]]
        return labels, times


def same_numbers(period: float, radius_max: float, cycle: Orbit) -> bool:
    """Return whether a limit cycle has this period and largest radius."""
    apart = abs(period / cycle.duration - 1.0), abs(radius_max / cycle.radius_max - 1.0)
    return max(apart) <= SAME


def known_from_closed_forms(rotor: Rotor, stop: Stop, *, fading: bool = True) -> Known:
    """Return the attractors of a damped rotor that closed forms give.

    Without `fading` the rim of fading touches, which takes longest, is not computed.
    """
    if rotor.load > 0.0:  # then no whirl is synchronous
        free = contact_free_whirls(rotor, stop, fading=False)
        whirls = [_rest_on_the_ring(rotor)] if free is None and rotor.omega == 0.0 else []
        return Known(rotor, whirls, free)
    if rotor.omega == 0.0 and rotor.delta0 == 0.0:
        # Energy only falls, so all comes to rest, but as slowly as 1/t**2: near rest is enough.
        near = TrappingRegion(0.0, 0.0, np.zeros(4), 1e4 * np.eye(4))
        return Known(rotor, [near], None)
    whirls = trapping_regions(rotor) if rotor.omega > 0.0 else []
    return Known(rotor, whirls, contact_free_whirls(rotor, stop, fading=fading))


def _rest_on_the_ring(rotor: Rotor) -> TrappingRegion:
    """Return the position of rest under a load at zero speed, as a region without states."""
    radius = radius_at_rest(rotor)
    centre = np.array([0.0, -radius, 0.0, 0.0])
    return TrappingRegion(radius, 0.5 * np.pi, centre, np.full((4, 4), np.inf))


def with_cycle(known: Known, cycle: Orbit, stop: Stop) -> Known:
    """Return the known attractors with one more limit cycle."""
    section = cycle_section(cycle, stop)
    return Known(known.rotor, known.whirls, known.free, [*known.cycles, section])


# Slight touches are followed nearly to rounding: the law is compared with differences of 1/h.
HOW = Options(method="taylor", rtol=1e-12)
# The kernel assumes fading touches only if the remaining drift is at most this fraction of the
# final excess of the centre: the same number as in core/lanes.c.
MOST_DRIFT = 0.3
# Number of states with such a drift that are followed,
STATES = 24
# and of those drawn for it, of which states in contact are left out.
MOST_DRAWN = 240
# The law is to leading order in C h, with a linear contact in C sqrt(h): the first excess tried is
# where that is this small.
LARGEST_EXCESS = 0.1
# Nor is it more than this fraction of the room, where C is small.
LARGEST_PART_OF_ROOM = 0.2
# Number of halvings before touches are assumed not to fade.
HALVINGS = 8
# A drift falls like exp(-2 zeta t): after this multiple of 1/zeta to a part of 1e-7.
DRIFT_ENDS = 8.0
# If this takes longer, as with little damping, no fading touches are sought.
LONGEST_DRIFT = 4000.0
# Revolutions for which touches are observed after that.
REVOLUTIONS = 24
# Number of the last ones that are compared with the law.
LAST_TOUCHES = 4
# They are a revolution apart, to this fraction of it,
ONCE_A_REVOLUTION = 0.02
# and 1/h grows by the law to this fraction: touches are deeper here than in a sweep.
LIKE_THE_LAW = 0.25


@dataclass(frozen=True, slots=True)
class ContactFree:
    """The whirls that stay inside the clearance, and the neighbouring ones with fading touches."""

    whirl: complex  # displacement from its centre, on the rotating axes [1]
    room: float  # how far the centre may lie from the bearing axis, or xi reach [1]
    excess: float  # how much farther out touches still fade [1]; 0 if none are known to
    alone: bool = False  # whether a shaft makes this the only whirl of the family
    sag: float = 0.0  # how far below the bearing axis a load moves its centre [1]

    @property
    def row(self) -> Rows:
        """The whirl in the kernel's format."""
        fading = (self.room + self.excess) ** 2 if self.excess > 0.0 else -1.0
        whirl = self.whirl.real, self.whirl.imag
        return np.array((whirl, self.room**2, fading), dtype=CONTACT_FREE)


def contact_free_whirls(rotor: Rotor, stop: Stop, *, fading: bool) -> ContactFree | None:
    """Return the contact-free whirls of a rotor, if they fit; with `fading`, also the rim.

    Under a load there is one only with a shaft: about its sagging position, or at rest there.
    """
    kappa, load = rotor.shaft_stiffness, rotor.load
    if load > 0.0 and kappa == 0.0:
        return None
    whirl = complex(complex_amplitude(rotor.omega, rotor.zeta, kappa))
    sag = load / kappa if load > 0.0 else 0.0
    room = rotor.delta0 - abs(whirl) - sag
    if abs(grazing_distance(rotor)) <= GRAZES:
        return ContactFree(whirl, 0.0, 0.0, alone=kappa > 0.0, sag=sag)
    if not room > 0.0:
        return None
    if sag > 0.0 and rotor.omega == 0.0:
        return ContactFree(-1j * sag, room, 0.0, alone=True)
    if kappa > 0.0:
        return ContactFree(whirl, room, 0.0, alone=True, sag=sag)
    return ContactFree(whirl, room, _fading_excess(rotor, whirl, stop) if fading else 0.0)


def _fading_excess(rotor: Rotor, whirl: complex, stop: Stop) -> float:
    """Return the largest excess of a contact-free whirl at which touches fade; 0 for none."""
    growth = touch_fading(rotor)
    if math.isnan(growth) or DRIFT_ENDS / rotor.zeta > LONGEST_DRIFT:  # NaN where nothing turns
        return 0.0
    room = rotor.delta0 - abs(whirl)
    small = (LARGEST_EXCESS / growth) ** (1.0 / _order(rotor))
    excess = float(min(small, LARGEST_PART_OF_ROOM * room))
    for _ in range(HALVINGS):
        states = _states_too_far_out(rotor, whirl, excess)
        if stop[0] or (states and all(_fades(rotor, state, growth, stop) for state in states)):
            return excess
        excess *= 0.5
    return 0.0


def _order(rotor: Rotor) -> float:
    """Return the power of 1/h that grows evenly from touch to touch: 1, or 1/2 for a linear one."""
    return float(rotor.contact_exponent - 0.5)


def _states_too_far_out(rotor: Rotor, whirl: complex, excess: float) -> list[Values]:
    """Return states out of contact whose whirl ends too far out, by up to `excess`."""
    room, random = rotor.delta0 - abs(whirl), np.random.default_rng(0)
    states: list[Values] = []
    for _ in range(MOST_DRAWN):
        outside = excess * random.choice([1.0, 0.5, 0.1])
        end = cmath.rect(room + outside, 2.0 * math.pi * random.random())
        drift = cmath.rect(MOST_DRIFT * outside, 2.0 * math.pi * random.random())
        position = end - drift + whirl
        velocity = 1j * rotor.omega * whirl + 2.0 * rotor.zeta * drift
        if abs(position) < rotor.delta0 and len(states) < STATES:
            states.append(np.array([position.real, position.imag, velocity.real, velocity.imag]))
    return states


def _fades(rotor: Rotor, state: Values, growth: float, stop: Stop) -> bool:
    """Return whether the touches of a motion fade by the law."""
    revolution = 2.0 * math.pi / rotor.omega
    duration = DRIFT_ENDS / rotor.zeta + REVOLUTIONS * revolution
    x, y, vx, vy = state.tolist()
    try:
        orbit = run(rotor, (x, y, vx, vy), duration, np.empty(0), HOW, stop=stop)
    except SimulationError:
        return False
    times, depths = orbit.contacts["peak_time"], orbit.contacts["peak_root"] ** 2
    if depths.size < LAST_TOUCHES or times[-1] < duration - 2.0 * revolution:
        return False
    revolutions = np.diff(times[-LAST_TOUCHES:]) / revolution
    grown = np.diff(1.0 / depths[-LAST_TOUCHES:] ** _order(rotor)) / growth
    once = np.abs(revolutions - 1.0) <= ONCE_A_REVOLUTION
    return bool((once & (np.abs(grown - 1.0) <= LIKE_THE_LAW)).all())
