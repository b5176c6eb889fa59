"""Kinds of response, decided from the motion over a final window.

========================= ==========================================================
``contact_free``          whirls inside the clearance and will not touch the ring again
``synchronous``           whirls in contact with the unbalance, at constant radius
``bouncing``              enters and leaves contact for ever (intermittent rub)
``full_contact``          is always in contact, radius not constant (full annular rub)
``unresolved``            has not settled
========================= ==========================================================
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicHermiteSpline

from rotor_ida.equations.contact import secant_stiffness
from rotor_ida.equations.model import rotated
from rotor_ida.parameters import Rotor

Values = npt.NDArray[np.float64]

CONTACT_FREE = "contact_free"
SYNCHRONOUS = "synchronous"
BOUNCING = "bouncing"
FULL_CONTACT = "full_contact"
UNRESOLVED = "unresolved"

# A whirl is one that the equation of motion allows when what is left over of its terms is less
# than this part of the largest; close to a fold the rotor creeps at nearly constant radius where
# there is no whirl.
RESIDUAL = 1e-6
# A motion that is not steady counts as lasting when its swing stays within this factor from
# one window to the next, which lies a whole run later, after transients have had so many times
# 1/zeta to die away.
LASTING = 0.8
PATIENCE = 10.0
# A motion that indents by less than this, with a mean whirl this near to the contact-free one,
# leaves the ring through ever slighter touches.
SLIGHT = 0.01


@dataclass(frozen=True, slots=True)
class Features:
    """What the motion does over a window that holds whole revolutions.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    amplitude, phase_lag : float
        Amplitude [1] and phase lag [rad] of the part of the motion at the spin speed.
    radius_min, radius_max : float
        Smallest and largest distance from the bearing axis [1].
    turns : int
        Number of times at which the radius turns from growing to shrinking.
    wander : float
        Largest distance of the rotor, seen on the rotating axes, from its mean there [1].
    drift : float
        How far the centre of a contact-free whirl would still move [1].
    reach : float
        Largest distance that a contact-free whirl about its final centre goes out to [1].
    touches : int
        Number of contact events.
    ends_in_contact : bool
        Whether it ends in contact.
    steady : float
        Wander, as a part of the amplitude, below which a whirl counts as steady [1].
    """

    rotor: Rotor
    amplitude: float
    phase_lag: float
    radius_min: float
    radius_max: float
    turns: int
    wander: float
    drift: float
    reach: float
    touches: int
    ends_in_contact: bool
    steady: float

    @property
    def swing(self) -> float:
        """Measure of whether the motion still decays: indentation, or range of the radius."""
        if self.touches:
            return self.radius_max - self.rotor.delta0
        return self.radius_max - self.radius_min

    @property
    def is_steady(self) -> bool:
        """Whether it is a synchronous whirl in contact."""
        settled = self.wander <= self.steady * self.amplitude and self._obeys_the_equation()
        return self.touches == 0 and self.ends_in_contact and settled

    @property
    def is_at_rest(self) -> bool:
        """Whether it has come to rest at the centre, which takes a rotor that does not turn."""
        return self.rotor.omega == 0.0 and self.radius_max <= self.steady

    def _obeys_the_equation(self) -> bool:
        """Return whether the mean whirl makes ``(s - omega**2 + 2 i zeta omega) A = omega**2``."""
        omega, zeta = self.rotor.omega, self.rotor.zeta
        stiffness = float(secant_stiffness(self.amplitude, self.rotor.delta0))
        whirl = cmath.rect(self.amplitude, -self.phase_lag)
        terms = (stiffness * whirl, -(omega**2) * whirl, 2j * zeta * omega * whirl, -(omega**2))
        return abs(sum(terms)) <= max(RESIDUAL, self.steady) * max(map(abs, terms)) and omega > 0.0

    @property
    def leaves_the_ring(self) -> bool:
        """Whether it is the contact-free whirl but for the slightest touches.

        Each touch pushes the centre inwards, so the next one is slighter. That goes on for ever,
        too slowly for two windows to distinguish it from bouncing.
        """
        whirl = _free_whirl(self.rotor)
        if abs(whirl) >= self.rotor.delta0 or not self.touches:
            return False
        stray = abs(cmath.rect(self.amplitude, -self.phase_lag) - whirl)
        return stray <= SLIGHT and self.radius_max - self.rotor.delta0 <= SLIGHT

    @property
    def stays_free(self) -> bool:
        """Whether it has left the ring for good."""
        delta0 = self.rotor.delta0
        free = self.touches == 0 and not self.ends_in_contact
        return free and self.drift <= self.steady * delta0 and self.reach <= delta0


def features_of(
    rotor: Rotor,
    times: Values,
    states: Values,
    event_times: Values,
    *,
    ends_in_contact: bool,
    steady: float,
) -> Features:
    """Describe the motion over a window.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    times : ndarray, shape (n,)
        Equally spaced times [1] from the start of the window to its end, whole revolutions.
    states : ndarray, shape (n, 4)
        ``(x, y, vx, vy)`` at those times, fixed frame [1].
    event_times : ndarray, shape (m,)
        Times of the contact events in the window [1].
    ends_in_contact : bool
        Whether the window ends in contact.
    steady : float
        Wander, as a part of the amplitude, below which a whirl counts as steady [1].
    """
    rotating = rotated(states, -rotor.omega * times)
    position = rotating[:, 0] + 1j * rotating[:, 1]
    mean = complex(position[:-1].mean())
    radius_min, radius_max = _radius_range(times, states)
    rate = states[:, 0] * states[:, 2] + states[:, 1] * states[:, 3]
    x, y, vx, vy = rotating[-1]
    drift, reach = _future_if_free(rotor, complex(x, y), complex(vx, vy))
    return Features(
        rotor=rotor,
        amplitude=abs(mean),
        phase_lag=math.atan2(-mean.imag, mean.real) if mean != 0.0 else 0.0,
        radius_min=radius_min,
        radius_max=radius_max,
        turns=int(((rate[:-1] > 0.0) & (rate[1:] <= 0.0)).sum()),
        wander=float(np.abs(position - mean).max()),
        drift=drift,
        reach=reach,
        touches=event_times.size,
        ends_in_contact=ends_in_contact,
        steady=steady,
    )


def classify(earlier: Features | None, later: Features, *, time: float) -> str:
    """Return the kind of response seen in two windows, a whole run apart.

    Parameters
    ----------
    earlier : Features or None
        A window before `later`, or None if there is none yet: a motion that is neither steady
        nor free then stays unresolved.
    later : Features
        The final window.
    time : float
        Time since the start at which the final window begins [1].
    """
    if later.is_steady:
        return SYNCHRONOUS
    if later.stays_free or later.is_at_rest:
        return CONTACT_FREE
    had_time = later.rotor.zeta * time >= PATIENCE
    if earlier is None or not had_time or not _lasts(earlier, later):
        return UNRESOLVED
    if later.touches:
        return UNRESOLVED if later.leaves_the_ring else BOUNCING
    return FULL_CONTACT if later.ends_in_contact and later.turns else UNRESOLVED


def _lasts(earlier: Features, later: Features) -> bool:
    """Return whether the swing of a motion has neither died away nor grown."""
    if bool(earlier.touches) != bool(later.touches):
        return False
    if later.swing <= later.steady * later.radius_max or earlier.swing == 0.0:
        return False
    ratio = later.swing / earlier.swing
    return LASTING <= ratio <= 1.0 / LASTING


def _free_whirl(rotor: Rotor) -> complex:
    """Return the contact-free whirl on the rotating axes, also where the ring leaves no room."""
    return -rotor.omega / complex(rotor.omega, -2.0 * rotor.zeta) if rotor.omega > 0.0 else 0j


def _future_if_free(rotor: Rotor, position: complex, velocity: complex) -> tuple[float, float]:
    """Return how far a free whirl's centre would still drift, and how far out it would go."""
    omega, zeta = rotor.omega, rotor.zeta
    whirl = _free_whirl(rotor)
    surplus = velocity - 1j * omega * whirl
    if surplus != 0.0 and zeta == 0.0:
        return math.inf, math.inf
    drift = surplus / (2.0 * zeta) if surplus != 0.0 else 0j
    centre = position - whirl
    return abs(drift), max(abs(centre), abs(centre + drift)) + abs(whirl)


def _radius_range(times: Values, states: Values) -> tuple[float, float]:
    """Return the smallest and largest radius, refined between samples by a cubic of r**2."""
    x, y, vx, vy = states.T
    squares = x**2 + y**2
    low, high = squares.min(), squares.max()
    if high - low > 1e-9 * high:
        cubic = CubicHermiteSpline(times, squares, 2.0 * (x * vx + y * vy))
        turns = cubic.derivative().roots(extrapolate=False)
        at_turns = cubic(turns[np.isfinite(turns)])
        low, high = min(low, at_turns.min(initial=low)), max(high, at_turns.max(initial=high))
    return math.sqrt(max(low, 0.0)), math.sqrt(high)
