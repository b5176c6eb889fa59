"""The rotor's parameters, dimensionless and in SI units, and the scales between the two."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from rotor_ida.checks import with_hints
from rotor_ida.errors import Amount, InputError
from rotor_ida.model.parameters import (
    DEFAULTS,
    MACHINE_PARAMETERS,
    OF_MACHINE,
    OF_ROTOR,
    PARAMETERS,
    Parameter,
    check_parameter,
    check_together,
)

if TYPE_CHECKING:
    from rotor_ida.model.rotor_system import RotorSystem

# Quotients and products of smaller or larger scales leave the range of doubles.
SMALLEST_SCALE = 1e-100


@with_hints
@dataclass(frozen=True, kw_only=True, repr=False)
class Rotor:
    """A rotor with contact and clearance, in dimensionless form.

    Parameters
    ----------
    omega : float
        Spin speed over the reference frequency [dimensionless]; 0 is free vibration.
    zeta : float
        Damping ratio of the reference frequency, ``damping/(2 m omega_0)`` [dimensionless]. That of
        the critical speed is ``zeta/sqrt(kappa)``.
    delta0 : float
        Radial clearance over eccentricity [dimensionless]; 0 means always in contact.
    shaft_stiffness : float
        Shaft stiffness kappa [dimensionless].
    contact_exponent : {1.5, 1.0}
        Exponent n of the contact force: 3/2 by Hertz, or 1, a linear spring.
    contact_damping : float
        Contact damping c: relative increase of the contact force per unit approach speed
        [dimensionless].
    load : float
        Static load gamma, downwards [dimensionless].
    friction : float
        Coefficient mu of Coulomb friction in the contact [dimensionless].
    disc_radius : float, optional
        Radius rho of the disc over eccentricity [dimensionless], required with friction. Without
        friction it has no effect.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive; if the exponent is not 1.5
        or 1; if there is contact damping or friction without clearance, or friction without a
        disc radius.

    Notes
    -----
    ``z'' + 2 zeta z' + kappa z + (N + i T) z/|z| = omega**2 exp(i omega t) - i gamma``, with
    ``N = max(0, d**n (1 + c d'))`` where ``d = |z| - delta0`` is positive, and 0 elsewhere: the
    force is never tensile [2]_. While the surfaces slide, ``T = mu N sign(v_s)`` with
    ``v_s = v_t + rho omega``, where v_t is the tangential velocity of the disc's centre. Where v_s
    is 0 the disc rolls on the stator as long as ``|T| <= mu N``. The defaults give the paper's
    rotor,
    ``z'' + 2 zeta z' + max(|z| - delta0, 0)**1.5 z/|z| = omega**2 exp(i omega t)``.

    References
    ----------
    .. [1] Eq. (10) of the paper, Mechanika 25(6), 2019.
    .. [2] K. H. Hunt and F. R. E. Crossley, "Coefficient of restitution interpreted as damping in
       vibroimpact", Journal of Applied Mechanics 42, 1975.

    Examples
    --------
    >>> Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> Rotor(omega=1.7, zeta=0.07, delta0=0.5, shaft_stiffness=0.25)
    Rotor(omega=1.7, zeta=0.07, delta0=0.5, shaft_stiffness=0.25)
    >>> Rotor(omega=1.7, zeta=-0.07, delta0=0.5)
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: zeta must be zero or positive, got -0.07
    """

    omega: float
    zeta: float
    delta0: float
    shaft_stiffness: float = 0.0
    contact_exponent: float = 1.5
    contact_damping: float = 0.0
    load: float = 0.0
    friction: float = 0.0
    disc_radius: float | None = None

    def __post_init__(self) -> None:
        _set_checked(self, OF_ROTOR)
        check_together(_optional(self), self.delta0)

    def __repr__(self) -> str:
        return f"Rotor({', '.join(f'{name}={value!r}' for name, value in self.given.items())})"

    @property
    def beyond(self) -> dict[str, float]:
        """The parameters that differ from the paper's rotor and affect the motion."""
        return dict(self._beyond)

    @cached_property
    def _beyond(self) -> dict[str, float]:
        beyond = _not_default(self)
        if self.friction == 0.0:
            beyond.pop("disc_radius", None)
        return beyond

    @property
    def damps_uniformly(self) -> bool:
        """Whether all energy is lost to viscous damping, so that areas shrink as exp(-2 zeta t)."""
        return self.beyond.keys() <= {"shaft_stiffness", "contact_exponent", "load"}

    def system(self) -> RotorSystem:
        """Return the same rotor as a rotor system of one node, ``"disc"``.

        Returns
        -------
        RotorSystem
            With its contact, unbalance and load. The speed ``omega`` is given to each function.

        Examples
        --------
        >>> system = Rotor(omega=2.0, zeta=0.07, delta0=0.5).system()
        >>> system, system.contacts[0].clearance, system.unbalance[0].moment
        (RotorSystem(2 degrees of freedom, node disc), 0.5, 1.0)
        """
        return _disc(
            self, mass=1.0, damping=2.0 * self.zeta, clearance=self.delta0, contact_stiffness=1.0,
            moment=1.0, units="1",
        )  # fmt: skip

    @property
    def given(self) -> dict[str, float]:
        """The arguments of an equal rotor: the paper's parameters, and those not the default."""
        return {name: getattr(self, name) for name in PARAMETERS} | _not_default(self)


def _disc(
    rotor: Rotor | DimensionalRotor, *, mass: float, damping: float, clearance: float,
    contact_stiffness: float, moment: float, units: Literal["SI", "1"],
) -> RotorSystem:  # fmt: skip
    """Return one disc as a rotor system, with its contact and its unbalance."""
    from rotor_ida.model.rotor_system import RotorSystem  # noqa: PLC0415 - loads scipy
    from rotor_ida.model.system_parts import Contact, Unbalance  # noqa: PLC0415

    contact = Contact(
        node="disc", clearance=clearance, stiffness=contact_stiffness,
        exponent=rotor.contact_exponent, damping=rotor.contact_damping, friction=rotor.friction,
        radius=rotor.disc_radius,
    )  # fmt: skip
    both = np.eye(2)
    return RotorSystem(
        mass=mass * both, stiffness=rotor.shaft_stiffness * both, damping=damping * both,
        nodes={"disc": (0, 1)}, contacts=[contact],
        unbalance=[Unbalance(node="disc", moment=moment)],
        gravity=(0.0, -rotor.load / mass) if rotor.load else None, units=units,
    )  # fmt: skip


def _set_checked(rotor: Rotor | DimensionalRotor, table: Mapping[str, Parameter]) -> None:
    """Replace each given parameter by its checked value."""
    for name, parameter in table.items():
        object.__setattr__(rotor, name, check_parameter(parameter, getattr(rotor, name)))


def _optional(rotor: Rotor | DimensionalRotor) -> dict[str, float | None]:
    """Return the optional parameters by name."""
    return {name: getattr(rotor, name) for name in DEFAULTS}


def _not_default(rotor: Rotor | DimensionalRotor) -> dict[str, float]:
    """Return the optional parameters that are not the default."""
    return {
        name: value
        for name, value in _optional(rotor).items()
        if value is not None and value != DEFAULTS[name]
    }


def check_no_friction(rotor: Rotor, what: str) -> None:
    """Raise `InputError` for a rotor with friction, where it is not supported."""
    if rotor.friction > 0.0:
        raise InputError(
            f"friction must be 0 for {what}, which does not support it, got {rotor.friction!r}"
        )


def check_no_load(
    load: float, what: str, why: str = "as there is no synchronous whirl under a load"
) -> None:
    """Raise `InputError` for a load above 0, where it is not supported; name the way out."""
    if load > 0.0:
        raise InputError(
            "{name} must be 0 for {what}, {why}, got {value}; {name} 0 leaves the weight out",
            name="load", what=what, why=why, value=load,
        )  # fmt: skip


@with_hints
@dataclass(frozen=True, kw_only=True, slots=True)
class DimensionalRotor:
    """A rotor with contact and clearance, in SI units.

    Parameters
    ----------
    mass : float
        Mass of the disc, m [kg].
    contact_stiffness : float
        Stiffness of the contact, k [N/m^n]: N/m^1.5 by Hertz, N/m for a linear spring.
    damping : float
        Viscous damping coefficient, 2 m zeta omega_0 [N s/m]. (The paper writes n for it.)
    eccentricity : float
        Distance of the mass centre from the disc centre, D [m].
    clearance : float
        Radial clearance, Delta [m].
    speed : float
        Spin speed, Omega [rad/s].
    shaft_stiffness : float
        Stiffness of the shaft at the disc, k_s [N/m].
    contact_exponent : {1.5, 1.0}
        Exponent n of the contact force: 3/2 by Hertz, or 1, a linear spring.
    contact_damping : float
        Coefficient lambda of Hunt and Crossley: relative increase of the contact force per approach
        speed [s/m].
    load : float
        Static load, downwards, L [N]; the weight is mass times 9.80665 m/s^2.
    friction : float
        Coefficient of Coulomb friction in the contact [dimensionless].
    disc_radius : float, optional
        Radius of the disc, R [m], required with friction.

    Raises
    ------
    InputError
        If mass, contact_stiffness or eccentricity is not a positive finite number,
        or one of the others is not a finite number that is zero or positive; or if
        the scales leave the range of doubles.

    Notes
    -----
    Lengths scale with D, times with 1/omega_0, where ``omega_0**2 = k D**(n - 1)/m``. (The paper
    prints ``k/m``, which has the wrong dimension for a Hertz contact.) Then
    ``kappa = k_s/(m omega_0**2)``, ``c = lambda D omega_0``, ``gamma = L/(m D omega_0**2)`` and
    ``rho = R/D``.

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
    shaft_stiffness: float = 0.0
    contact_exponent: float = 1.5
    contact_damping: float = 0.0
    load: float = 0.0
    friction: float = 0.0
    disc_radius: float | None = None

    def __post_init__(self) -> None:
        try:
            _set_checked(self, OF_MACHINE)
            check_together(_optional(self), math.inf)
        except InputError as error:
            raise error.with_numbers(self._in_si) from error
        scales = (self.reference_frequency, self.velocity_scale, self.force_scale)
        if not all(SMALLEST_SCALE < scale < 1.0 / SMALLEST_SCALE for scale in scales):
            raise InputError(
                "mass, contact_stiffness and eccentricity must give scales of frequency, velocity "
                f"and force between {SMALLEST_SCALE:g} and {1.0 / SMALLEST_SCALE:g}, got "
                f"{', '.join(f'{scale:.3g}' for scale in scales)}"
            )

    def _in_si(self, field: str, name: str, _place: int, value: float) -> float:
        """Return a number of a message about a quantity with its unit."""
        parameter = OF_MACHINE.get(field) or OF_MACHINE.get(name)
        if parameter is None or parameter.unit == "1":
            return value
        linear = self.contact_exponent == 1.0
        return Amount(value, parameter.unit.replace("m-1.5", "m-1" if linear else "m-1.5"))

    @property
    def reference_frequency(self) -> float:
        """``omega_0 = sqrt(k D**(n - 1) / m)`` [rad/s]."""
        stiffness = self.contact_stiffness
        if self.contact_exponent > 1.0:
            stiffness *= math.sqrt(self.eccentricity)
        return math.sqrt(stiffness / self.mass)

    @property
    def critical_speed(self) -> float:
        """Natural frequency of disc and shaft, ``sqrt(k_s/m)`` [rad/s]; 0 without a shaft."""
        return math.sqrt(self.shaft_stiffness / self.mass)

    @property
    def damping_ratio(self) -> float:
        """Damping ratio of the critical speed, ``damping/(2 sqrt(k_s m))`` [dimensionless], or NaN.

        The ``zeta`` of `Rotor` is the damping ratio of the reference frequency,
        ``damping/(2 m omega_0)``. Without a shaft it is NaN.
        """
        if self.shaft_stiffness == 0.0:
            return math.nan
        return self.damping / (2.0 * math.sqrt(self.shaft_stiffness * self.mass))

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
        """Newtons in one dimensionless unit of force: ``k D**n`` [N]."""
        linear = self.contact_stiffness * self.eccentricity
        return linear * math.sqrt(self.eccentricity) if self.contact_exponent > 1.0 else linear

    @property
    def torque_scale(self) -> float:
        """Newton metres in one dimensionless unit of torque: ``m D**2 omega_0**2`` [N m]."""
        return self.force_scale * self.length_scale

    @property
    def inertia_scale(self) -> float:
        """Moment of inertia in one dimensionless unit of it: ``m D**2`` [kg m^2]."""
        return self.mass * self.eccentricity**2

    @property
    def given(self) -> dict[str, float]:
        """The arguments of an equal machine: the paper's parameters, and those not the default."""
        return {name: getattr(self, name) for name in MACHINE_PARAMETERS} | _not_default(self)

    def system(self) -> RotorSystem:
        """Return the same machine as a rotor system of one node, as `Rotor.system` does, in SI.

        Examples
        --------
        >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
        ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
        >>> machine.system().unbalance
        (Unbalance(node='disc', moment=4e-06, phase=0.0),)
        """
        return _disc(
            self, mass=self.mass, damping=self.damping, clearance=self.clearance,
            contact_stiffness=self.contact_stiffness, moment=self.mass * self.eccentricity,
            units="SI",
        )  # fmt: skip

    def rotor(self) -> Rotor:
        """Return the equivalent dimensionless rotor."""
        frequency = self.reference_frequency
        return Rotor(
            omega=self.speed / frequency,
            zeta=self.damping / (2.0 * self.mass * frequency),
            delta0=self.clearance / self.eccentricity,
            shaft_stiffness=self.shaft_stiffness / (self.mass * frequency**2),
            contact_exponent=self.contact_exponent,
            contact_damping=self.contact_damping * self.velocity_scale,
            load=self.load / self.force_scale,
            friction=self.friction,
            disc_radius=None if self.disc_radius is None else self.disc_radius / self.eccentricity,
        )
