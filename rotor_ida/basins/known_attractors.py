"""The attractors that closed forms give, each with a set of states that certainly end there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.trapping_regions import TrappingRegion, trapping_regions
from rotor_ida.parameters import Rotor
from rotor_ida.simulation.flight import unbalance_whirl

Values = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class KnownAttractors:
    """The attractors of a rotor that closed forms give, before any start is followed.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    regions : list of TrappingRegion
        Of each stable whirl in contact; their numbers are labels.
    free : ndarray, shape (3,)
        Contact-free whirl on the rotating axes [1] and the squared radius within which its centre
        stays; negative if there is none. Its label is ``len(regions)``.
    """

    rotor: Rotor
    regions: list[TrappingRegion]
    free: Values

    @property
    def has_free(self) -> bool:
        """Whether there is a contact-free whirl."""
        return bool(self.free[2] >= 0.0)

    @property
    def clearance(self) -> float | None:
        """Clearance as the kernel wants it: None for 0, where it needs less arithmetic."""
        return self.rotor.delta0 if self.rotor.delta0 > 0.0 else None


def known_attractors(rotor: Rotor) -> KnownAttractors:
    """Return the known attractors of a damped rotor."""
    if rotor.omega == 0.0 and rotor.delta0 == 0.0:
        # All comes to rest, for energy only falls, but as slowly as 1/t**2: close by is enough.
        near = TrappingRegion(0.0, 0.0, np.zeros(4), 1e4 * np.eye(4))
        return KnownAttractors(rotor, [near], np.array([0.0, 0.0, -1.0]))
    nothing = np.array([0.0, 0.0, -1.0])
    regions = trapping_regions(rotor) if rotor.omega > 0.0 else []
    whirl = unbalance_whirl(rotor.omega, rotor.zeta)
    room = rotor.delta0 - abs(whirl)
    return KnownAttractors(
        rotor, regions, np.array([whirl.real, whirl.imag, room**2]) if room > 0.0 else nothing
    )
