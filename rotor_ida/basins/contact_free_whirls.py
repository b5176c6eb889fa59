"""The contact-free whirls that hold an orbit, and those beside them whose touches fade for ever.

Out of contact the whirl's centre moves straight from c to c + drift. Where both ends leave room for
the whirl, it never touches the ring again: exact. Where it comes to rest a little farther out, the
whirl touches the ring once a revolution, and each touch pushes it inwards a little less than the
one before: the limit is the contact-free whirl that just reaches the ring
(`rotor_ida.closed_forms.touch_fading`). A push that is too strong puts it inside for good. How far
out a whirl with little drift may be for its touches to fade is found by following such states: it
is halved until the touches of each of them fade by the law. So that is an estimate, not a proof.

With a shaft there is one contact-free whirl, about the bearing axis. What is off it by xi loses
energy, ``|xi'|**2 + kappa |xi|**2``: where that keeps xi within the room that the whirl leaves, or
the two motions do into which xi falls without turning, it never touches the ring again: exact. No
touches fade there.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.closed_forms import touch_fading
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.errors import SimulationError
from rotor_ida.model.parameters import Rotor
from rotor_ida.parallel import Stop
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

# Slight touches are followed nearly to rounding: the law is held against differences of 1/h.
HOW = Options(method="taylor", rtol=1e-12)
# The kernel takes touches to fade only where the drift that is left is at most this part of how
# much too far out it ends: the same number as in core/lanes.c.
MOST_DRIFT = 0.3
# So many states with such a drift are followed,
STATES = 24
# from so many that are drawn, of which those in contact are left out.
MOST_DRAWN = 240
# The law is to leading order in C h, with a linear contact in C sqrt(h): the first excess tried is
# where that is this small.
LARGEST_EXCESS = 0.1
# Nor is it more than this part of the room, where C is small.
LARGEST_PART_OF_ROOM = 0.2
# It is halved so often, before no touches are taken to fade.
HALVINGS = 8
# A drift falls like exp(-2 zeta t): in so many 1/zeta to a part of 1e-7.
DRIFT_ENDS = 8.0
# With so little damping that this takes longer, no fading touches are sought.
LONGEST_DRIFT = 4000.0
# Touches are watched for so many revolutions after that.
REVOLUTIONS = 24
# So many of the last ones are held against the law.
LAST_TOUCHES = 4
# They come a revolution after one another, to this part of it,
ONCE_A_REVOLUTION = 0.02
# and 1/h grows as the law says, to this part: touches are less slight yet than where a sweep asks.
LIKE_THE_LAW = 0.25


@dataclass(frozen=True, slots=True)
class ContactFree:
    """The whirls that stay inside the clearance, and those beside them whose touches fade."""

    whirl: complex  # displacement from its centre, on the rotating axes [1]
    room: float  # how far the centre may lie from the bearing axis, or xi reach [1]
    excess: float  # how much farther out touches still fade [1]; 0 where none are known to
    alone: bool = False  # whether a shaft leaves this one whirl of the family
    sag: float = 0.0  # how far below the bearing axis a load moves its centre [1]

    @property
    def numbers(self) -> Values:
        """Whirl, and the squared radii that its centre may have, shape (4,), for the kernel."""
        edge = (self.room + self.excess) ** 2 if self.excess > 0.0 else -1.0
        return np.array([self.whirl.real, self.whirl.imag, self.room**2, edge])


def contact_free_whirls(rotor: Rotor, stop: Stop, *, fading: bool) -> ContactFree | None:
    """Return the contact-free whirls of a rotor, if they fit; with `fading`, what touches fade."""
    kappa = rotor.shaft_stiffness
    whirl = complex(complex_amplitude(rotor.omega, rotor.zeta, kappa))
    room = rotor.delta0 - abs(whirl)
    if not room > 0.0:
        return None
    if kappa > 0.0:
        return ContactFree(whirl, room, 0.0, alone=True)
    return ContactFree(whirl, room, _fading_excess(rotor, whirl, stop) if fading else 0.0)


def contact_free_whirl_under_load(rotor: Rotor) -> ContactFree | None:
    """Return the whirl about where a shaft holds the load, if it does not reach the ring.

    A rotor that does not turn comes to rest there.
    """
    kappa = rotor.shaft_stiffness
    if kappa == 0.0:
        return None
    whirl, sag = complex(complex_amplitude(rotor.omega, rotor.zeta, kappa)), rotor.load / kappa
    room = rotor.delta0 - abs(whirl) - sag
    if not room > 0.0:
        return None
    if rotor.omega == 0.0:
        return ContactFree(-1j * sag, room, 0.0, alone=True)
    return ContactFree(whirl, room, 0.0, alone=True, sag=sag)


def _fading_excess(rotor: Rotor, whirl: complex, stop: Stop) -> float:
    """Return how much too far out a contact-free whirl may lie for touches to fade; 0 for none."""
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
    """Return states out of contact whose whirl comes to rest too far out, by up to `excess`."""
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
    times, depths = orbit.contacts[:, 2:4].T
    if depths.size < LAST_TOUCHES or times[-1] < duration - 2.0 * revolution:
        return False
    revolutions = np.diff(times[-LAST_TOUCHES:]) / revolution
    grown = np.diff(1.0 / depths[-LAST_TOUCHES:] ** _order(rotor)) / growth
    once = np.abs(revolutions - 1.0) <= ONCE_A_REVOLUTION
    return bool((once & (np.abs(grown - 1.0) <= LIKE_THE_LAW)).all())
