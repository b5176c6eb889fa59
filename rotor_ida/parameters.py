"""The rotor's parameters, dimensionless and in SI units, and the scales between the two."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rotor_ida.checks import check_nonnegative, check_positive
from rotor_ida.errors import InputError

PARAMETERS = ("omega", "zeta", "delta0")
# Quotients and products of smaller or larger scales leave the range of doubles.
SMALLEST_SCALE = 1e-100


@dataclass(frozen=True, kw_only=True, slots=True)
class Rotor:
    """A rotor with Hertz contact and clearance, in dimensionless form.

    Parameters
    ----------
    omega : float
        Spin speed over the reference frequency [1]; 0 is free vibration.
    zeta : float
        Damping ratio [1].
    delta0 : float
        Radial clearance over eccentricity [1]; 0 means always in contact.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive.

    Notes
    -----
    ``z'' + 2 zeta z' + max(|z| - delta0, 0)**1.5 z/|z| = omega**2 exp(i omega t)``.

    References
    ----------
    Eq. (10) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> Rotor(omega=1.7, zeta=-0.07, delta0=0.5)
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: zeta must be zero or positive, got -0.07
    """

    omega: float
    zeta: float
    delta0: float

    def __post_init__(self) -> None:
        for name in PARAMETERS:
            object.__setattr__(self, name, check_nonnegative(name, getattr(self, name)))


@dataclass(frozen=True, kw_only=True, slots=True)
class DimensionalRotor:
    """The same rotor as an engineer measures it, in SI units.

    Parameters
    ----------
    mass : float
        Mass of the disc, m [kg].
    contact_stiffness : float
        Hertz stiffness of the ring, k [N/m^1.5].
    damping : float
        Viscous damping coefficient, n [N s/m].
    eccentricity : float
        Distance of the mass centre from the disc centre, D [m].
    clearance : float
        Radial clearance, d [m].
    speed : float
        Spin speed, W [rad/s].

    Raises
    ------
    InputError
        If mass, contact_stiffness or eccentricity is not a positive finite number,
        or one of the others is not a finite number that is zero or positive; or if
        the scales leave the range of doubles.

    Notes
    -----
    Lengths scale with D, times with 1/omega_0, where ``omega_0**2 = k sqrt(D)/m``; the paper
    prints ``k/m``, which has the wrong dimension for a Hertz contact.

    References
    ----------
    Eqs (7)-(9) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> machine.rotor()
    Rotor(omega=1.2, zeta=0.07, delta0=2.0)
    """

    mass: float
    contact_stiffness: float
    damping: float
    eccentricity: float
    clearance: float
    speed: float

    def __post_init__(self) -> None:
        for name in ("mass", "contact_stiffness", "eccentricity"):
            object.__setattr__(self, name, check_positive(name, getattr(self, name)))
        for name in ("damping", "clearance", "speed"):
            object.__setattr__(self, name, check_nonnegative(name, getattr(self, name)))
        scales = (self.reference_frequency, self.velocity_scale, self.force_scale)
        if not all(SMALLEST_SCALE < scale < 1.0 / SMALLEST_SCALE for scale in scales):
            raise InputError(
                "mass, contact_stiffness and eccentricity must give scales of frequency, velocity "
                f"and force between {SMALLEST_SCALE:g} and {1.0 / SMALLEST_SCALE:g}, got "
                f"{', '.join(f'{scale:.3g}' for scale in scales)}"
            )

    @property
    def reference_frequency(self) -> float:
        """``omega_0 = sqrt(k sqrt(D) / m)`` [rad/s]."""
        return math.sqrt(self.contact_stiffness * math.sqrt(self.eccentricity) / self.mass)

    @property
    def length_scale(self) -> float:
        """Metres in one dimensionless unit of length: the eccentricity [m]."""
        return self.eccentricity

    @property
    def time_scale(self) -> float:
        """Seconds in one dimensionless unit of time: ``1/omega_0`` [s]."""
        return 1.0 / self.reference_frequency

    @property
    def velocity_scale(self) -> float:
        """Metres per second in one dimensionless unit of velocity: ``D omega_0`` [m/s]."""
        return self.eccentricity * self.reference_frequency

    @property
    def force_scale(self) -> float:
        """Newtons in one dimensionless unit of force: ``k D**1.5`` [N]."""
        return self.contact_stiffness * self.eccentricity * math.sqrt(self.eccentricity)

    def rotor(self) -> Rotor:
        """Return the dimensionless rotor that moves like this machine."""
        frequency = self.reference_frequency
        return Rotor(
            omega=self.speed / frequency,
            zeta=self.damping / (2.0 * self.mass * frequency),
            delta0=self.clearance / self.eccentricity,
        )
