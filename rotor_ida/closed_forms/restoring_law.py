"""The contact law of `rotor_ida.model.contact` over arrays, and the restoring law of one rotor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from types import MappingProxyType

import numpy as np

from rotor_ida.arrays import Column, Values
from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_real
from rotor_ida.model.contact import (
    HERTZ_EXPONENT,
    contact_stiffness,
    secant_stiffness,
)
from rotor_ida.model.parameters import DEFAULTS, check_clearance_needed, check_exponent
from rotor_ida.model.varied import Range


def stiffnesses(
    radius: Values, delta0: Values | float, exponent: Values | float
) -> tuple[Values, Values]:
    """Return the slope ``f'(r)`` and the secant stiffness ``f(r)/r`` [dimensionless].

    Where a linear contact begins, the slope is 1; so is the secant without clearance.

    Examples
    --------
    >>> stiffnesses(np.array([4.5]), np.array([0.5]), np.array([1.0]))[0]
    array([1.])
    """
    linear = np.asarray(exponent) != HERTZ_EXPONENT
    slope = np.where(linear, np.where(radius < delta0, 0.0, 1.0), contact_stiffness(radius, delta0))
    whole = linear & (np.asarray(delta0) == 0.0)
    return slope, np.where(whole, 1.0, secant_stiffness(radius, delta0, exponent))


@dataclass(frozen=True, slots=True)
class RestoringLaw:
    """Stiffness of contact and shaft, and friction, of one rotor [dimensionless]."""

    delta0: float
    shaft_stiffness: float = 0.0
    contact_exponent: float = HERTZ_EXPONENT
    friction: float = 0.0

    @property
    def hertz(self) -> bool:
        """Whether the contact is that of Hertz."""
        return self.contact_exponent == HERTZ_EXPONENT

    @property
    def coordinates(self) -> dict[str, Column]:
        """Parameters other than the clearance that are not default, as coordinates of a result."""
        return {
            name: ((), value)
            for name, value in asdict(self).items()
            if name in DEFAULTS and value != DEFAULTS[name]
        }

    def forces(self, u: Values) -> tuple[Values, Values, Values]:
        """Return A, ``g = f(A) + kappa A`` and ``W = A f' - f`` at ``u = sqrt(A - delta0)``."""
        square = u * u
        A = self.delta0 + square
        if self.hertz:
            return A, square * u + self.shaft_stiffness * A, 0.5 * u * (A + 2.0 * self.delta0)
        return A, square + self.shaft_stiffness * A, self.delta0 + 0.0 * u

    def stiffness(self, A: Values) -> Values:
        """Return ``g/A`` at amplitudes."""
        return stiffnesses(A, self.delta0, self.contact_exponent)[1] + self.shaft_stiffness


def checked_law(
    delta0: float = 0.0,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
    friction: float = 0.0,
    ranges: Mapping[str, Range] = MappingProxyType({}),
) -> RestoringLaw:
    """Return the law of numbers that a user gave, some of them within a range.

    Examples
    --------
    >>> checked_law(shaft_stiffness=0.25).coordinates
    {'shaft_stiffness': ((), 0.25)}
    """
    given = asdict(RestoringLaw(delta0, shaft_stiffness, contact_exponent, friction))
    for name, value in given.items():
        given[name] = check_real(name, value)
        smallest, largest = ranges.get(name, (0.0, LARGEST_NUMBER))
        check_axis(name, given[name], smallest=smallest, largest=largest)
    law = RestoringLaw(**given)
    check_exponent(law.contact_exponent)
    if law.delta0 == 0.0:
        check_clearance_needed({"friction": law.friction, "contact_damping": 0.0})
    return law
