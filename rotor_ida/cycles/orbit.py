"""An orbit followed for a time, with the derivatives of its end: perhaps a limit cycle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.core.runs import NO_STOP
from rotor_ida.model.contact import contact_force
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema.flags import ENTRY, EXIT, REVERSE, ROLL
from rotor_ida.simulation.flow import DiscFlow, Flow, Piece

# Samples on which the sense of a whirl is seen.
SAMPLES = 1024
# Samples of one period, for the mean whirl.
MEAN_SAMPLES = 512


@dataclass(frozen=True)
class Orbit:
    """An orbit of a flow.

    Parameters
    ----------
    flow : Flow
        How the rotor moves.
    piece : Piece
        The motion, with the derivatives of its end.
    """

    flow: Flow
    piece: Piece

    @property
    def start(self) -> Values:
        """State at the start, shape (n,)."""
        return self.piece.start

    @property
    def end(self) -> Values:
        """State at the end, shape (n,)."""
        return self.piece.end

    @property
    def duration(self) -> float:
        """Its duration: the period of a cycle."""
        return self.piece.duration

    @property
    def monodromy(self) -> Values:
        """Derivative of the end by the start, shape (n, n)."""
        return self.piece.tangents

    @property
    def start_rate(self) -> Values:
        """Rate of change of the state at the start, shape (n,)."""
        return self.piece.start_rate

    @property
    def end_rate(self) -> Values:
        """Rate of change of the state at the end, shape (n,)."""
        return self.piece.end_rate

    @property
    def is_autonomous(self) -> bool:
        """Whether a cycle may begin anywhere, so that one multiplier is 1."""
        return self.flow.period is None

    @cached_property
    def pair_product(self) -> float | None:
        """Product of each of two pairs of multipliers, one of them with 1; None without pairs."""
        return self.flow.pair_product(self.duration)

    @cached_property
    def residual(self) -> float:
        """Distance of its end from its start, relative to its size."""
        return math.hypot(*(self.end - self.start)) / (math.hypot(*self.start) or 1.0)

    @cached_property
    def mean_whirl(self) -> complex:
        """Mean place of one disc on the rotating axes over the period [dimensionless]."""
        times = self.duration / MEAN_SAMPLES * np.arange(MEAN_SAMPLES + 1.0)
        states = self._states(times)[:-1]
        return complex(states[:, 0].mean(), states[:, 1].mean())

    def _states(self, times: Values) -> Values:
        """Return states on the orbit at some times, even if who found it was stopped since."""
        return self.flow.but(stop=NO_STOP).states(self.start, times)

    # ---- Its contacts ----

    @cached_property
    def contact_counts(self) -> list[int]:
        """Number of times that each contact closes on a closed orbit.

        At an entry or an exit at the start, rounding may omit one of these.
        """
        kinds, numbers = self.piece.event_kinds.tolist(), self.piece.event_contacts.tolist()
        events = list(zip(numbers, kinds, strict=True))
        return [
            max(events.count((number, ENTRY)), events.count((number, EXIT)))
            for number in range(len(self.piece.rolls))
        ]

    @property
    def contacts(self) -> int:
        """Number of times that contacts close."""
        return sum(self.contact_counts)

    @property
    def sliding_changes(self) -> int:
        """Number of times that a contact begins to roll, or slides the other way."""
        kinds = self.piece.event_kinds.tolist()
        return int(kinds.count(ROLL) + kinds.count(REVERSE))

    @property
    def rolls(self) -> bool:
        """Whether a contact ever rolls; a difference along it is then lost."""
        return bool(self.piece.rolls.any())

    @cached_property
    def radii(self) -> list[Values]:
        """Extreme distances of each contact from the centre of its stator, in order of time."""
        return self.flow.radii(self.piece)

    @cached_property
    def sizes(self) -> Values:
        """Smallest, then largest distances of the contacts: the same at any phase."""
        return np.array([bound(each.tolist()) for bound in (min, max) for each in self.radii])

    @property
    def radius_min(self) -> float:
        """Smallest distance of a contact from its centre."""
        return float(self.sizes[: len(self.radii)].min())

    @property
    def radius_max(self) -> float:
        """Largest distance of a contact from its centre."""
        return float(self.sizes[len(self.radii) :].max())

    @cached_property
    def nearest(self) -> tuple[float, int]:
        """The extreme distance nearest to a stator, less the clearance, and its contact."""
        gaps = [
            (radius - clearance, number)
            for number, clearance in enumerate(self.flow.clearances.tolist())
            for radius in self.radii[number].tolist()
        ]
        return min(gaps, key=lambda each: abs(each[0]), default=(math.inf, 0))

    @property
    def touches(self) -> bool:
        """Whether a contact is ever closed."""
        largest = self.sizes[len(self.radii) :].tolist()
        pairs = zip(largest, self.flow.clearances.tolist(), strict=True)
        return any(radius > clearance or clearance == 0.0 for radius, clearance in pairs)

    def halves_agree(self, part: float) -> bool:
        """Return whether the extreme distances of both halves agree to a part of the largest."""
        return all(_repeat(radii.tolist(), part) for radii in self.radii)

    @property
    def response(self) -> str:
        """Kind of response: ``bouncing``, ``full_contact``, or ``rolling`` where it is dry whip."""
        if self.contacts:
            return "bouncing"
        return "rolling" if self.rolls and self._is_backward else "full_contact"

    @property
    def _is_backward(self) -> bool:
        """Whether a contact that rolls whirls backwards all the time."""
        times = np.linspace(0.0, self.duration, SAMPLES + 1)
        place, velocity = self.flow.places(self._states(times))
        forward = (place.conj() * velocity).imag * math.copysign(1.0, self.flow.speed)
        return bool((forward[:, self.piece.rolls].max(axis=0) < 0.0).any())

    # ---- Of one disc ----

    @property
    def rotor(self) -> Rotor:
        """The rotor of one disc."""
        return disc_of(self.flow)

    @property
    def largest_force(self) -> float:
        """Largest contact force of one disc [dimensionless]."""
        if self.rotor.contact_damping > 0.0:
            return float(np.nanmax(self.piece.contacts["largest_force"]))
        exponent = self.rotor.contact_exponent
        return float(contact_force(self.radius_max, self.rotor.delta0, exponent))

    @property
    def impulse(self) -> float:
        """Impulse of the contact force of one disc in a period [1]; NaN without clearance."""
        parts = self.piece.contacts["impulse"]
        return float(np.nansum(parts)) if self.rotor.delta0 > 0.0 else math.nan


def disc_of(flow: Flow) -> Rotor:
    """Return the rotor of the flow of one disc."""
    if not isinstance(flow, DiscFlow):
        raise TypeError("a rotor system is no Rotor")
    return flow.rotor


def followed(flow: Flow, start: Values, duration: float, by: Sequence[str] = ()) -> Orbit:
    """Return an orbit, differentiated by some parameters; SimulationError if it fails."""
    return Orbit(flow, flow.run(start, duration, by=by))


def _repeat(radii: list[float], part: float) -> bool:
    """Return whether both halves of a list agree to a part of its largest number."""
    half, odd = divmod(len(radii), 2)
    if odd or not half:
        return False
    pairs, allowed = zip(radii[:half], radii[half:], strict=True), part * max(radii)
    return all(abs(one - other) <= allowed for one, other in pairs)
