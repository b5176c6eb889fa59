"""The parameters of a rotor system: the numbers of it that a study varies, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypedDict

import numpy.typing as npt

from rotor_ida.errors import InputError
from rotor_ida.model.bearing import Bearing
from rotor_ida.model.parameters import Parameters
from rotor_ida.model.rotor_system import RotorSystem, levitated_system
from rotor_ida.model.system_parts import Contact, Support, Unbalance

SPEED = "speed"
CONTACTS, UNBALANCE = "contacts", "unbalance"


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemParameter:
    """One parameter of a rotor system.

    Parameters
    ----------
    meaning : str
        What it is.
    label : str
        Its label on an axis of a figure.
    parts : str
        The field of the system with the parts whose numbers it sets; empty for a matrix, of which
        it is a factor.
    number : str
        The number of each part; the matrix.
    unit : str
        Its unit in an SI system.
    """

    meaning: str
    label: str
    parts: str = ""
    number: str
    unit: str = "1"


PARAMETERS_OF_SYSTEM = {
    "damping": SystemParameter(
        number="damping", meaning="factor of the damping of rotor, supports and bearings",
        label="damping factor",
    ),
    "stiffness": SystemParameter(
        number="stiffness", meaning="factor of the stiffness of rotor, supports and bearings",
        label="stiffness factor",
    ),
    "clearance": SystemParameter(
        parts=CONTACTS, number="clearance", unit="m",
        meaning="largest radial clearance of the contacts", label="largest clearance",
    ),
    "friction": SystemParameter(
        parts=CONTACTS, number="friction",
        meaning="largest friction coefficient of the contacts", label="largest friction",
    ),
    "unbalance": SystemParameter(
        parts=UNBALANCE, number="moment", unit="kg m",
        meaning="largest unbalance: mass times eccentricity", label="largest unbalance",
    ),
}  # fmt: skip
# The same and those that fits determine, but over which no study varies a system.
FITTED_OF_SYSTEM = PARAMETERS_OF_SYSTEM | {
    "contact_stiffness": SystemParameter(
        parts=CONTACTS, number="stiffness", unit="N m-1.5",
        meaning="largest stiffness of the contacts", label="largest contact stiffness",
    ),
    "contact_damping": SystemParameter(
        parts=CONTACTS, number="damping", unit="s m-1",
        meaning="largest contact damping", label="largest contact damping",
    ),
}  # fmt: skip


class _OfSystem(TypedDict, total=False):
    """Keywords that change or vary a system, but for friction, which one disc has too."""

    contacts: Sequence[Contact]
    unbalance: Sequence[Unbalance] | npt.ArrayLike
    supports: Sequence[Support]
    bearings: Sequence[Bearing]
    gravity: tuple[float, float] | None
    static_force: npt.ArrayLike | None
    damping: npt.ArrayLike
    stiffness: npt.ArrayLike
    clearance: npt.ArrayLike


class SystemAxes(_OfSystem, total=False):
    """Keywords that change a system or vary it: its fields, and its parameters as axes."""

    friction: npt.ArrayLike


class AnyAxes(_OfSystem, Parameters, total=False):
    """Keywords that change or vary any rotor: parameters of one disc, and those of a system."""


def parameter_of(system: RotorSystem, name: str) -> float:
    """Return the value of a parameter at which a system is as it is.

    Raises
    ------
    InputError
        If the system has nothing that the parameter sets.

    Examples
    --------
    >>> from rotor_ida.model.rotor import Rotor
    >>> system = Rotor(omega=2.0, zeta=0.07, delta0=0.5).system()
    >>> parameter_of(system, "clearance"), parameter_of(system, "damping")
    (0.5, 1.0)
    """
    known = FITTED_OF_SYSTEM[name]
    if known.parts:
        values = [getattr(each, known.number) for each in getattr(system, known.parts)]
        if not values:
            raise InputError(f"{name} must be left out, as the system has no {known.parts}")
        return float(max(values))
    system = levitated_system(system)
    if getattr(system, known.number) is None and not system.bearings:
        raise InputError(f"{name} must be left out, as the system has no {known.number} matrix")
    return 1.0


def with_parameters(system: RotorSystem, values: Mapping[str, float]) -> RotorSystem:
    """Return a system with other values of some parameters.

    The contact or unbalance with the largest value of the system gets the new one, and all others
    keep their ratios to it; where all are 0, each gets it.

    Examples
    --------
    >>> import numpy as np
    >>> touches = [Contact(node=node, clearance=gap, stiffness=4.0)
    ...            for node, gap in (("disc", 0.5), ("end", 0.25))]
    >>> system = RotorSystem(mass=np.eye(4), stiffness=np.eye(4), contacts=touches, units="1",
    ...                      nodes={"disc": (0, 1), "end": (2, 3)})
    >>> [each.clearance for each in with_parameters(system, {"clearance": 0.8}).contacts]
    [0.8, 0.4]
    >>> with_parameters(system, {"stiffness": 2.0}).stiffness.max().item()
    2.0
    """
    for name, value in values.items():
        known, own = FITTED_OF_SYSTEM[name], parameter_of(system, name)
        if not known.parts:
            system = levitated_system(system)
            matrix = getattr(system, known.number)
            films = [replace(each, **{known.number: value * getattr(each, known.number)})
                     for each in system.bearings]  # fmt: skip
            scaled = None if matrix is None else value * matrix
            changed: dict[str, Any] = {known.number: scaled, "bearings": films}
        else:
            changed = {known.parts: [
                replace(part, **{known.number: value * _ratio(getattr(part, known.number), own)})
                for part in getattr(system, known.parts)
            ]}  # fmt: skip
        system = replace(system, **changed)
    return system


def _ratio(number: float, largest: float) -> float:
    """Return the ratio of a number to the largest; 1 where all are 0."""
    return number / largest if largest else 1.0
