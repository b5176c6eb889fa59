"""A machine from its data sheet: critical speed, damping ratio, balance grade."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from difflib import get_close_matches

from rotor_ida import units
from rotor_ida.checks import (
    check_between,
    check_nonnegative,
    check_point,
    check_positive,
    check_real,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import EXPONENTS, OF_MACHINE
from rotor_ida.model.rotor import DimensionalRotor

GRAVITY = 9.80665
# The word for a load that is the weight of the rotor.
WEIGHT = "weight"
# Quantities that a data sheet may give instead of a parameter of a machine, with their units.
IN_OTHER_WORDS = {
    "critical_speed": "rad s-1",
    "damping_ratio": "1",
    "unbalance": "kg m",
    "balance_grade": "m s-1",
    "balance_speed": "rad s-1",
}
KEYS = {name: each.unit for name, each in OF_MACHINE.items()} | IN_OTHER_WORDS
# Ways to give one quantity: each replaces the others.
ALTERNATIVES = (
    ("shaft_stiffness", "critical_speed"),
    ("damping", "damping_ratio"),
    ("eccentricity", "unbalance", "balance_grade"),
)
NEEDED = ("mass", "contact_stiffness", "clearance", "speed")
MILLIMETRE = 1e-3
# Unit of the stiffness of a linear contact.
OF_LINEAR = "N m-1"
# A number, and the text after it.
_WORD = re.compile(
    r"\s*(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(?P<unit>\S.*?)?\s*"
)

# Running speeds over the critical speed outside of these are likely a slip of the unit.
FASTEST, SLOWEST = 20.0, 0.01
# A radial clearance from this on [m] is likely a slip of the unit.
LARGEST_CLEARANCE = 10.0 * MILLIMETRE

# A number in the SI unit, or text with a unit; None if not given.
Quantity = float | str | None


def machine_from_data_sheet(
    *,
    mass: Quantity,
    contact_stiffness: Quantity,
    clearance: Quantity,
    speed: Quantity,
    shaft_stiffness: Quantity = None,
    critical_speed: Quantity = None,
    damping: Quantity = None,
    damping_ratio: Quantity = None,
    eccentricity: Quantity = None,
    unbalance: Quantity = None,
    balance_grade: Quantity = None,
    balance_speed: Quantity = None,
    contact_exponent: Quantity = None,
    contact_damping: Quantity = None,
    load: Quantity = None,
    friction: Quantity = None,
    disc_radius: Quantity = None,
) -> DimensionalRotor:
    """Return the machine that a data sheet describes.

    Each quantity is a number in its SI unit, or text with a unit such as ``"150um"``, ``"12 kg"``,
    ``"3600 rpm"`` or ``"3%"``.

    Parameters
    ----------
    mass : float or str
        Mass of the disc [kg], such as ``"12kg"``.
    contact_stiffness : float or str
        Stiffness of the contact, such as ``"1e8N/m"`` for a linear contact or ``"1e9N/m^1.5"`` for
        that of Hertz.
    clearance : float or str
        Radial clearance [m], such as ``"150um"``.
    speed : float or str
        Running speed [rad/s], such as ``"3600rpm"``.
    shaft_stiffness : float or str, optional
        Stiffness of the shaft at the disc [N/m], such as ``"4e6N/m"``.
    critical_speed : float or str, optional
        Or the critical speed [rad/s], ``sqrt(stiffness/mass)``.
    damping : float or str, optional
        Damping coefficient [N s/m], such as ``"416Ns/m"``.
    damping_ratio : float or str, optional
        Or the damping ratio at the critical speed [dimensionless], ``c/(2 sqrt(k m))``, such as
        ``"3%"``.
    eccentricity : float or str, optional
        Distance of the mass centre from the disc centre [m].
    unbalance : float or str, optional
        Or the unbalance [kg m], mass times eccentricity, such as ``"200g.mm"``.
    balance_grade : float or str, optional
        Or the balance quality grade of ISO 21940, such as ``"G6.3"`` or a number in mm/s, with its
        speed.
    balance_speed : float or str, optional
        Largest service speed [rad/s] for which the grade is specified.
    contact_exponent : {1.5, 1.0}, optional
        Exponent of the contact force. Default: 1 if the stiffness has a unit such as N/m, else 1.5.
    contact_damping : float or str, optional
        Contact damping coefficient of Hunt and Crossley [s/m].
    load : float or str, optional
        Static load [N], downwards, or the word ``weight``.
    friction : float or str, optional
        Friction coefficient of the contact [dimensionless].
    disc_radius : float or str, optional
        Radius of the disc [m], required with friction.

    Returns
    -------
    DimensionalRotor
        The machine in SI units.

    Raises
    ------
    InputError
        If a quantity is missing, given twice, in a wrong unit, or out of range.

    Notes
    -----
    ``k_s = m W_c**2``, ``n = 2 zeta_c sqrt(k_s m)``, ``D = U/m``, and ``D = G/W`` for a rigid rotor
    with balance grade G at the speed W.

    References
    ----------
    ISO 21940-11:2016, Mechanical vibration - Rotor balancing - Part 11.

    Examples
    --------
    >>> pump = machine_from_data_sheet(
    ...     mass="12kg", critical_speed="5513rpm", damping_ratio="3%", clearance="150um",
    ...     balance_grade="G6.3", balance_speed="3600rpm", speed="3600rpm",
    ...     contact_stiffness="1e8N/m", friction=0.12, disc_radius="60mm")
    >>> round(pump.shaft_stiffness), round(pump.eccentricity * 1e6, 2), pump.contact_exponent
    (3999581, 16.71, 1.0)
    """
    given = {name: value for name, value in locals().items() if value is not None}
    _check_once(given)
    numbers = {name: in_si(name, value, *units_of(name)) for name, value in given.items()
               if name not in {"balance_grade", "load", "contact_exponent"}}  # fmt: skip
    check_positive("mass", numbers["mass"])
    found = {name: numbers[name] for name in OF_MACHINE if name in numbers}
    exponent = exponent_of(given["contact_stiffness"], given.get("contact_exponent"))
    stiffness = _shaft_stiffness(numbers)
    return DimensionalRotor(**{
        **found,
        "shaft_stiffness": stiffness,
        "damping": _damping(numbers, stiffness),
        "eccentricity": _eccentricity(numbers, given.get("balance_grade")),
        "contact_exponent": exponent,
        "load": _load(given.get("load", 0.0), numbers["mass"]),
    })  # fmt: skip


def in_si(name: str, value: object, *allowed: str) -> float:
    """Return a quantity in its SI unit, from a number in that unit or text with an allowed unit.

    Examples
    --------
    >>> in_si("mass", "12 kg", "kg"), in_si("clearance", "150µm", "m"), in_si("ratio", "3%", "1")
    (12.0, 0.00015, 0.03)
    >>> in_si("mass", "12 um", "kg")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: the unit of mass must be kg, g or lb, got '12 um'
    """
    if not isinstance(value, str):
        return check_real(name, value)
    check_point(name, value)
    found = _WORD.fullmatch(value)
    if found is None:
        raise InputError(f"{name} must be a finite real number, got {shown(value)}")
    number, word = found["number"], found["unit"]
    if word is None:
        return check_real(name, float(number))
    if word == "%" and "1" in allowed:
        return check_real(name, units.Unit(1.0, -2, units.ONE.dimension).in_si(number))
    known = units.unit_of(word)
    if known is None or known.dimension not in map(units.dimension_of, allowed):
        wanted = "left out" if "1" in allowed else units.usual(*allowed)
        clear = units.AMBIGUOUS.get(word)
        hint = f"; did you mean {clear}?" if clear else ""
        raise InputError(f"the unit of {name} must be {wanted}, got {shown(value)}{hint}")
    return check_real(name, known.in_si(number))


def units_of(name: str) -> tuple[str, ...]:
    """Return the units that a quantity of a data sheet may have."""
    return (KEYS[name], OF_LINEAR) if name == "contact_stiffness" else (KEYS[name],)


def exponent_of(
    stiffness: object,
    exponent: object,
    names: tuple[str, str] = ("contact_stiffness", "contact_exponent"),
) -> float:
    """Return the exponent of the contact force that matches the unit of the stiffness.

    Examples
    --------
    >>> exponent_of("1e8 N/m", None), exponent_of("1e8 N/m^1.5", None), exponent_of(1e8, None)
    (1.0, 1.5, 1.5)
    """
    word = _WORD.fullmatch(stiffness) if isinstance(stiffness, str) else None
    told = None
    if word is not None and word["unit"]:
        linear = units.dimension_of(word["unit"]) == units.dimension_of(OF_LINEAR)
        told = 1.0 if linear else EXPONENTS[0]
    if exponent is None:
        return told or EXPONENTS[0]
    number = in_si(names[1], exponent, "1")
    if told is not None and number != told:
        raise InputError(
            f"the unit of {names[0]} must be {'N/m' if number == 1.0 else 'N/m^1.5'} with "
            f"{names[1]} {number:g}, got {shown(stiffness)}"
        )
    return number


def check_keys(given: Mapping[str, object], where: str) -> None:
    """Raise `InputError` for an unknown or a missing name.

    Examples
    --------
    >>> check_keys({"clearence": 1e-4}, "pump.toml")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: pump.toml must give quantities of a machine, got 'clearence': did
    you mean clearance?
    """
    for name in given:
        if name not in KEYS:
            close = get_close_matches(name, KEYS, 1)
            hint = f"did you mean {close[0]}?" if close else f"allowed are {', '.join(KEYS)}"
            raise InputError(
                f"{where} must give quantities of a machine, got {shown(name)}: {hint}"
            )
    missing = [name for name in NEEDED if name not in given]
    missing += [
        " or ".join(names) for names in ALTERNATIVES[1:] if not any(name in given for name in names)
    ]
    if missing:
        raise InputError(f"{where} must also give {', '.join(missing)}")


def overridden(sheet: Mapping[str, object], by: Mapping[str, object]) -> dict[str, object]:
    """Return a data sheet with some quantities replaced, however they were given before.

    Examples
    --------
    >>> overridden({"mass": 12.0, "damping_ratio": "3%"}, {"damping": 100.0})
    {'mass': 12.0, 'damping': 100.0}
    """
    replaced = {each for names in ALTERNATIVES for each in names if set(names) & by.keys()}
    return {name: value for name, value in sheet.items() if name not in replaced} | dict(by)


def implausible(machine: DimensionalRotor) -> list[str]:
    """Return a sentence for each implausible quantity of a machine.

    Examples
    --------
    >>> implausible(DimensionalRotor(
    ...     mass=12.0, contact_stiffness=1e8, damping=416.0, eccentricity=1.7e-5,
    ...     clearance=1.5e-5, speed=377.0, shaft_stiffness=4e6, contact_exponent=1.0))
    ['clearance 15 um is below the eccentricity 17 um: the rotor cannot turn without rubbing']
    """
    found = []
    clearance, eccentricity = machine.clearance, machine.eccentricity
    stiffness, radius = machine.shaft_stiffness, machine.disc_radius
    if stiffness == 0.0:
        found.append("shaft_stiffness is 0: only the contact supports the disc")
    elif machine.damping_ratio == 0.0 or machine.damping_ratio > 0.3:
        found.append(
            f"damping_ratio of the critical speed is {machine.damping_ratio:.3g}; rotors in "
            "bearings have 0.001 to 0.3"
        )
    ratio = machine.speed / machine.critical_speed if stiffness > 0.0 else 1.0
    if not FASTEST >= ratio >= SLOWEST:
        found.append(
            f"speed is {float(f'{ratio:.3g}'):,.6g} times the critical speed: is the unit of one "
            "of them wrong?"
        )
    if clearance < eccentricity:
        found.append(
            f"clearance {units.quantity(clearance, 'm', 3)} is below the eccentricity "
            f"{units.quantity(eccentricity, 'm', 3)}: the rotor cannot turn without rubbing"
        )
    if clearance >= LARGEST_CLEARANCE:
        found.append(
            f"clearance is {units.quantity(clearance, 'm', 3)}; those of rotors are below "
            f"{units.quantity(LARGEST_CLEARANCE, 'm')}"
        )
    sag = machine.load / stiffness if stiffness > 0.0 else 0.0
    if sag > clearance:
        found.append(
            f"load bends the shaft by {units.quantity(sag, 'm', 3)}, more than the clearance"
        )
    if machine.contact_stiffness * clearance ** (machine.contact_exponent - 1.0) < stiffness:
        found.append("contact_stiffness is below the stiffness of the shaft")
    if machine.eccentricity * machine.speed > 40.0 * MILLIMETRE:
        grade = machine.eccentricity * machine.speed / MILLIMETRE
        found.append(f"eccentricity is a balance grade of G{grade:.3g} at the running speed")
    if machine.friction > 1.0:
        found.append(f"friction is {machine.friction:.3g}; dry metals have 0.05 to 0.6")
    if radius is not None:
        if max(clearance, eccentricity) > 0.1 * radius:
            found.append("clearance or eccentricity is over a tenth of the radius of the disc")
        if radius * machine.speed > 500.0:
            found.append(f"the rim of the disc moves at {radius * machine.speed:.3g} m/s")
    return found


def _check_once(given: Mapping[str, object]) -> None:
    """Raise `InputError` for a quantity that is missing, or given in two ways."""
    for names in ALTERNATIVES:
        both = [name for name in names if name in given]
        if len(both) > 1:
            raise InputError(f"{both[0]} must be left out with {both[1]}: each gives the other")
    check_keys(given, "a machine")
    if ("balance_grade" in given) != ("balance_speed" in given):
        one, other = ("balance_speed", "balance_grade")[:: 1 if "balance_grade" in given else -1]
        raise InputError(f"{one} must be given with {other}, got None")


def _shaft_stiffness(numbers: Mapping[str, float]) -> float:
    if "critical_speed" in numbers:
        critical = check_positive("critical_speed", numbers["critical_speed"])
        return numbers["mass"] * critical * critical
    return numbers.get("shaft_stiffness", 0.0)


def _damping(numbers: Mapping[str, float], stiffness: float) -> float:
    if "damping" in numbers:
        return numbers["damping"]
    ratio = check_nonnegative("damping_ratio", numbers["damping_ratio"])
    if stiffness <= 0.0:
        raise InputError(
            "damping_ratio is of the critical speed, and needs shaft_stiffness or critical_speed; "
            "without a shaft give damping in N s/m"
        )
    return 2.0 * ratio * math.sqrt(check_positive("shaft_stiffness", stiffness) * numbers["mass"])


def _eccentricity(numbers: Mapping[str, float], grade: Quantity) -> float:
    if "eccentricity" in numbers:
        return numbers["eccentricity"]
    if "unbalance" in numbers:
        return numbers["unbalance"] / numbers["mass"]
    speed = check_positive("balance_speed", numbers["balance_speed"])
    word = grade.strip().removeprefix("G") if isinstance(grade, str) else grade
    if isinstance(word, str) and not word.rstrip().endswith("s"):
        word = f"{word} mm/s"
    value = (
        word * MILLIMETRE
        if isinstance(word, (int, float))
        else in_si("balance_grade", word, "m s-1")
    )
    return check_between("balance_grade in m/s", value, 1e-7, 10.0) / speed


def _load(load: Quantity, mass: float) -> float:
    if isinstance(load, str) and load == WEIGHT:
        return mass * GRAVITY
    return in_si("load", load, "N")
