"""The table of parameters: the meaning, symbols, units, default and range of each.

Checks, coordinates, options of the command line, labels and the tables of the documentation are
made from it. A new parameter also needs a field of each rotor and of `Parameters`, its place in the
forces, and a place in some lists that say what it can do: CONTRIBUTING.md ("A parameter") has all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

import numpy.typing as npt

from rotor_ida.checks import check_nonnegative, check_positive
from rotor_ida.errors import InputError
from rotor_ida.units import spelled

# The exponents of the contact force: Hertz's, and that of a linear spring.
EXPONENTS = (1.5, 1.0)


@dataclass(frozen=True, kw_only=True, slots=True)
class Parameter:
    """One parameter of a rotor, dimensionless, in SI units, or both.

    Parameters
    ----------
    name : str
        Its name as an argument, a coordinate and an option.
    meaning : str
        Meaning of the dimensionless number; empty if the parameter exists only in SI units.
    symbol : str
        The symbol of the dimensionless number, as TeX.
    label : str
        Its label on an axis of a figure.
    plural : str
        Its name in the plural.
    note : str
        Addition to its meaning in the help of an option.
    si_meaning : str
        Meaning of the quantity in SI units; empty if the parameter is only dimensionless.
    si_symbol : str
        The symbol of the quantity in SI units, as TeX.
    unit : str
        The SI unit, as netCDF writes it.
    needed : bool
        Whether it is required; the others have a default.
    default : float or None
        The value of the paper's rotor.
    positive : bool
        Whether the quantity in SI units must be above zero.
    sets_scales : bool
        Whether the scales of a machine depend on it, so that it cannot be an axis of machines.
    smallest, largest : float
        Smallest nonzero value and largest value of a rotor that can be simulated [dimensionless],
        as `check_can_be_followed` of `rotor_ida.simulation.options` asks. Closed forms take more.
    """

    name: str
    meaning: str = ""
    symbol: str = ""
    label: str = ""
    plural: str = ""
    note: str = ""
    si_meaning: str = ""
    si_symbol: str = ""
    unit: str = "1"
    needed: bool = False
    default: float | None = 0.0
    positive: bool = False
    sets_scales: bool = False
    # Smaller values are lost in rounding, and a smaller clearance is crossed in no time. With
    # larger ones the tolerances lose their meaning.
    smallest: float = 1e-12
    largest: float = 1e6

    @property
    def help(self) -> str:
        """Help of an option that takes one number."""
        return f"{_capital(self.meaning)}{self.note}."

    @property
    def axis_help(self) -> str:
        """Help of an option that takes several numbers."""
        return f"{_capital(self.plural)}: numbers, or START:STOP:COUNT."

    @property
    def shown_unit(self) -> str:
        """The SI unit as a reader writes it.

        Examples
        --------
        >>> OF_MACHINE["damping"].shown_unit, OF_MACHINE["shaft_stiffness"].shown_unit
        ('N s/m', 'N/m')
        """
        return spelled(self.unit) or self.unit

    @property
    def si_help(self) -> str:
        """Help of an option that takes the quantity in SI units."""
        unit = "" if self.unit == "1" else f", in {self.shown_unit}"
        return f"{_capital(self.si_meaning)}{unit}{self.note}."

    @property
    def either_help(self) -> str:
        """Help of an option that takes either number."""
        if not self.si_meaning:
            return self.help
        if not self.meaning or self.unit == "1":
            return self.si_help
        return f"{_capital(self.si_meaning)}{self.note} (SI: {self.shown_unit})."

    @property
    def either_axis_help(self) -> str:
        """Help of an option that takes several numbers of either kind."""
        several = "numbers, or START:STOP:COUNT"
        if not self.si_meaning:
            return self.axis_help
        if self.meaning:
            unit = "" if self.unit == "1" else f" (SI: {self.shown_unit})"
            return f"{_capital(self.plural)}{unit}: {several}."
        return self.si_help if self.sets_scales else f"{self.si_help[:-1]}: {several}."


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]


TABLE = (
    Parameter(
        name="omega", symbol=r"\omega", needed=True, default=None, smallest=0.0,
        meaning="spin speed divided by the reference frequency",
        label="spin speed", plural="spin speeds",
    ),
    Parameter(
        name="zeta", symbol=r"\zeta", needed=True, default=None, smallest=0.0,
        meaning="damping ratio of the reference frequency", label="damping ratio",
        plural="damping ratios of the reference frequency",
    ),
    Parameter(
        name="delta0", symbol=r"\delta_0", needed=True, default=None,
        meaning="radial clearance divided by the eccentricity",
        label="clearance", plural="clearances",
    ),
    Parameter(
        name="mass", si_symbol="m", unit="kg", needed=True, default=None,
        positive=True, sets_scales=True, si_meaning="mass of the disc",
    ),
    Parameter(
        name="contact_stiffness", si_symbol="k", unit="N m-1.5", needed=True, default=None,
        positive=True, sets_scales=True, si_meaning="stiffness of the contact",
        note=", or in N/m if linear",
    ),
    Parameter(
        name="damping", si_symbol=r"2 m \zeta \omega_0", unit="N s m-1", needed=True, default=None,
        si_meaning="viscous damping",
    ),
    Parameter(
        name="eccentricity", si_symbol="D", unit="m", needed=True, default=None,
        positive=True, sets_scales=True,
        si_meaning="distance of the mass centre from the disc centre",
    ),
    Parameter(
        name="clearance", si_symbol=r"\Delta", unit="m", needed=True, default=None,
        si_meaning="radial clearance",
    ),
    Parameter(
        name="speed", si_symbol=r"\Omega", unit="rad s-1", needed=True, default=None,
        si_meaning="spin speed",
    ),
    Parameter(
        name="shaft_stiffness", symbol=r"\kappa",
        meaning="shaft stiffness divided by mass times reference frequency squared",
        label="stiffness of the shaft", plural="shaft stiffnesses",
        si_meaning="shaft stiffness", si_symbol="k_s", unit="N m-1",
    ),
    Parameter(
        name="contact_exponent", symbol="n", default=EXPONENTS[0],
        meaning="exponent of the contact force", note=": 1.5 for Hertz, 1 for linear",
        label="exponent of the contact",
        plural="exponents of the contact force, 1.5 for Hertz or 1 for linear",
        si_meaning="exponent of the contact force", sets_scales=True, si_symbol="n",
    ),
    Parameter(
        name="contact_damping", symbol="c",
        meaning="contact damping: relative increase of the contact force per unit approach speed",
        label="contact damping", plural="contact dampings",
        si_meaning="contact damping: relative increase of the contact force per approach speed",
        si_symbol=r"\lambda", unit="s m-1",
    ),
    Parameter(
        name="load", symbol=r"\gamma",
        meaning="static load, downwards, divided by the contact force at unit indentation",
        label="load", plural="static loads, downwards",
        si_meaning="static load, downwards", si_symbol="L", unit="N",
    ),
    Parameter(
        name="friction", symbol=r"\mu",
        meaning="friction coefficient of the contact",
        label="friction", plural="friction coefficients",
        si_meaning="friction coefficient of the contact", si_symbol=r"\mu",
    ),
    Parameter(
        name="disc_radius", symbol=r"\rho", default=None,
        meaning="disc radius divided by the eccentricity", note=", required with friction",
        label="radius of the disc", plural="disc radii, required with friction",
        si_meaning="disc radius", si_symbol="R", unit="m",
    ),
)  # fmt: skip

# The parameters of `rotor_ida.Rotor` and of `rotor_ida.DimensionalRotor`, in order.
OF_ROTOR = {each.name: each for each in TABLE if each.meaning}
OF_MACHINE = {each.name: each for each in TABLE if each.si_meaning}
ALL_PARAMETERS = tuple(OF_ROTOR)
# The parameters of the paper's rotor, dimensionless and in SI units.
PARAMETERS = tuple(name for name, each in OF_ROTOR.items() if each.needed)
MACHINE_PARAMETERS = tuple(name for name, each in OF_MACHINE.items() if each.needed)
# The optional parameters, each with its value for the paper's rotor.
DEFAULTS: dict[str, float | None] = {
    each.name: each.default for each in OF_ROTOR.values() if not each.needed
}
OPTIONAL = tuple(DEFAULTS)


class Parameters(TypedDict, total=False):
    """The parameters of a rotor as keywords of a study, each a number or an axis [1]."""

    omega: npt.ArrayLike
    zeta: npt.ArrayLike
    delta0: npt.ArrayLike
    shaft_stiffness: npt.ArrayLike
    contact_exponent: npt.ArrayLike
    contact_damping: npt.ArrayLike
    load: npt.ArrayLike
    friction: npt.ArrayLike
    disc_radius: npt.ArrayLike | None


# Those that must be 0 where the clearance is.
NEED_CLEARANCE = ("friction", "contact_damping")
# Those that have a meaning without friction too, of which `rotor_ida.model.modes` makes a model.
FRICTIONLESS = {
    name: value
    for name, value in DEFAULTS.items()
    if value is not None and name not in {"friction", "disc_radius"}
}


def check_parameter(parameter: Parameter, value: object) -> float | None:
    """Return the value of a parameter as a float, or raise `InputError`."""
    if value is None and parameter.default is None and not parameter.needed:
        return None
    checked = check_positive if parameter.positive else check_nonnegative
    number = checked(parameter.name, value)
    if parameter.name == "contact_exponent":
        check_exponent(number)
    return number


def check_exponent(exponent: float) -> None:
    """Raise `InputError` for an exponent of the contact force that is not supported."""
    if exponent not in EXPONENTS:
        allowed = " or ".join(f"{each:g}" for each in EXPONENTS)
        raise InputError(f"contact_exponent must be {allowed}, got {exponent!r}")


def check_together(values: dict[str, float | None], clearance: float) -> None:
    """Raise `InputError` for values that exclude each other, given the dimensionless clearance."""
    friction = values["friction"]
    if friction and values["disc_radius"] is None:
        raise InputError(
            f"disc_radius must be given with friction, got None with friction {friction!r}"
        )
    if clearance == 0.0:
        check_clearance_needed(values)


def check_clearance_needed(largest: dict[str, float | None]) -> None:
    """Raise `InputError` for contact damping or friction where there is no clearance."""
    for name in NEED_CLEARANCE:
        value = largest[name]
        if value:
            raise InputError(
                "{name} must be 0 without clearance, where the radius may vanish in contact, got "
                "{value} with {delta0=}",
                name=name, value=value, delta0=0.0,
            )  # fmt: skip
