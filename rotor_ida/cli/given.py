"""Sheets of what a result was computed from: the rotor, its contacts, unbalance and supports."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from rotor_ida.errors import InputError
from rotor_ida.model.parameters import OF_MACHINE
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.system_parts import Contact, Stator
from rotor_ida.results.sheets import Line, Sheet, facts
from rotor_ida.units import SPEED_UNITS, number, quantity

if TYPE_CHECKING:
    from rotor_ida.model.rotor_system import RotorSystem

DIGITS = 6
# Beginnings of the names of what an answer repeats.
IN_WORDS = ("mass", "unbalance", "balance grade", "shaft stiffness", "contact stiffness",
            "stiffness of", "clearance", "load", "largest static force")  # fmt: skip
LINEAR, HERTZ = 1.0, 1.5
# The numbers of contacts, their stators and races: words, SI unit, and the value of one contact.
Read = Callable[[Contact], Any]
OF_CONTACT: dict[str, tuple[str, Read]] = {
    "clearance": ("m", lambda each: each.clearance),
    "stiffness of the linear contact": (
        "N/m", lambda each: each.stiffness if each.exponent == LINEAR else math.nan,
    ),
    "stiffness of the Hertz contact": (
        "N/m^1.5", lambda each: each.stiffness if each.exponent == HERTZ else math.nan,
    ),
    "contact damping": ("s/m", lambda each: each.damping),
    "friction": ("1", lambda each: each.friction),
    "radius of the rotor": ("m", lambda each: _or_none(each.radius)),
    "offset of the centre x": ("m", lambda each: each.centre[0]),
    "offset of the centre y": ("m", lambda each: each.centre[1]),
    "mass of the mount": ("kg", lambda each: _of_stator(each, "mass")),
    "stiffness of the mount": ("N/m", lambda each: _of_stator(each, "stiffness")),
    "damping of the mount": ("N s/m", lambda each: _of_stator(each, "damping")),
    "radius of the race": ("m", lambda each: _of_race(each, "radius")),
    "inertia of the race": ("kg m2", lambda each: _of_race(each, "inertia")),
    "drag torque of the race over speed": ("N m s", lambda each: _of_race(each, "drag")),
}  # fmt: skip


def sheets_of_rotor(
    rotor: Rotor | DimensionalRotor | RotorSystem, speed: float | tuple[float, float] | None = None
) -> list[Sheet]:
    """Return what is known of a rotor, at a speed of a system, before anything is computed.

    Two speeds are the slowest and the fastest one of a record, in place of a running speed.

    Examples
    --------
    >>> [each.title for each in sheets_of_rotor(Rotor(omega=2.0, zeta=0.07, delta0=0.5))]
    ['Rotor without dimensions']
    """
    if isinstance(rotor, DimensionalRotor):
        known = facts_of_machine(rotor)
        if isinstance(speed, tuple):
            of_record = Line("speed of the record", [_between(*speed, "rad/s")])
            known = [of_record, *(each for each in known if "running speed" not in each.name)]
        names = {"speed", *(each.name for each in known)}
        given = [each for each in _numbers(rotor) if each.name not in names]
        return [facts("Machine", [*given, *known])]
    if isinstance(rotor, Rotor):
        numbers: dict[str, object] = {
            name: each for name, each in rotor.given.items() if each is not None
        }
        if isinstance(speed, tuple):
            numbers["omega"] = _between(*speed, "1")
        return [facts("Rotor without dimensions", numbers)]
    return _sheets_of_system(rotor, None if isinstance(speed, tuple) else speed)


def _between(low: float, high: float, unit: str) -> str:
    """Return a range of speeds in words."""
    return f"{quantity(low, unit)} to {quantity(high, unit)}"


def given_in_words(
    rotor: Rotor | DimensionalRotor | RotorSystem | None, speed: float | None
) -> str:
    """Return mass, unbalance, balance grade, stiffness, clearance and load in a line.

    It is empty without units.

    Examples
    --------
    >>> machine = DimensionalRotor(
    ...     mass=12.0, contact_stiffness=1e8, damping=416.0, eccentricity=17e-6, clearance=1.5e-4,
    ...     speed=377.0, shaft_stiffness=4e6, contact_exponent=1.0)
    >>> given_in_words(machine, 377.0)
    'Given: mass 12 kg, contact stiffness 100 MN/m, shaft stiffness 4 MN/m, unbalance 204 g mm,
    balance grade at the running speed G6.41, clearance 150 um.'
    """
    if rotor is None or isinstance(rotor, Rotor) or getattr(rotor, "units", "SI") != "SI":
        return ""
    told = [
        f"{line.name}{f' at {head!r}' if head else ''} {_in_words(line, value)}"
        for sheet in sheets_of_rotor(rotor, speed)[:2]  # of the whole, and the contacts
        for line in sheet.lines
        if line.name.startswith(IN_WORDS)
        for head, value in zip(sheet.heads or (), line.values, strict=True)
        if isinstance(value, float) and value > 0.0
    ]
    return f"Given: {', '.join(told)}."


def _in_words(line: Line, value: float) -> str:
    """Return a value with its unit, of a balance grade as ISO 21940 writes it."""
    is_grade = line.name.startswith("balance grade")
    return f"G{number(value, 3)}" if is_grade else quantity(value, line.unit)


def _numbers(machine: DimensionalRotor) -> list[Line]:
    """Return the given numbers of a machine."""
    is_linear = machine.contact_exponent == LINEAR
    lines = []
    for name, value in machine.given.items():
        unit = OF_MACHINE[name].shown_unit
        unit = unit.replace("m^1.5", "m") if is_linear else unit
        lines.append(Line(name.replace("_", " "), [value], unit, DIGITS))
    return lines


def facts_of_machine(machine: DimensionalRotor) -> list[Line]:
    """Return what follows from the numbers of a machine."""
    eccentricity, speed, ratio = machine.eccentricity, machine.speed, machine.damping_ratio
    resonance = eccentricity / (2.0 * ratio) if ratio > 0.0 else math.nan
    return [
        Line("running speed", [speed], "rad/s"),
        Line("critical speed", [machine.critical_speed or math.nan], "rad/s"),
        Line("damping ratio at the critical speed", [ratio], digits=6),
        Line("eccentricity", [eccentricity], "m"),
        Line("unbalance", [machine.mass * eccentricity], "kg m"),
        # by its definition in mm/s, also beside inches
        Line("balance grade at the running speed", [1e3 * eccentricity * speed], "mm/s"),
        Line("clearance", [machine.clearance], "m"),
        Line("amplitude at the critical speed without contact", [resonance], "m"),
        Line("reference frequency", [machine.reference_frequency / SPEED_UNITS["Hz"]], "Hz"),
    ]


def _sheets_of_system(system: RotorSystem, speed: float | None) -> list[Sheet]:
    found = [facts("Rotor system", _of_whole(system, speed))]
    if system.contacts:
        found.append(_contacts(system))
    if system.unbalance:
        lines = [
            Line("unbalance", [each.moment for each in system.unbalance], _si(system, "kg m")),
            Line("angle from x", [each.phase for each in system.unbalance], "radian"),
        ]
        found.append(Sheet("Unbalance", lines, [each.node for each in system.unbalance]))
    if system.supports:
        found.append(_supports(system))
    return found


def _supports(system: RotorSystem) -> Sheet:
    """Return the supports of a system, a column for each."""
    lines = [
        Line(f"{name} {axis}", [getattr(each, name)[place] for each in system.supports],
             _si(system, unit), DIGITS)
        for name, unit in (("stiffness", "N/m"), ("damping", "N s/m"))
        for place, axis in enumerate("xy")
    ]  # fmt: skip
    return Sheet("Supports", lines, [each.node for each in system.supports])


def _contacts(system: RotorSystem) -> Sheet:
    """Return the contacts of a system, a column for each."""
    lines = []
    for name, (unit, read) in OF_CONTACT.items():
        values = [read(each) for each in system.contacts]
        if any(np.nan_to_num(value).any() for value in values):
            lines.append(Line(name, values, _si(system, unit), DIGITS))
    nodes = [each.stator if isinstance(each.stator, str) else "" for each in system.contacts]
    if any(nodes):
        lines.append(Line("node of the stator", nodes))
    return Sheet("Given contacts", lines, [each.node for each in system.contacts])


def _of_whole(system: RotorSystem, speed: float | None) -> list[Line]:
    """Return size, mass, unbalance and constant forces of a system."""
    lines = [Line("degrees of freedom", [system.size]), Line("nodes", [", ".join(system.nodes)])]
    moment = sum(each.moment for each in system.unbalance)
    mass = _mass(system)
    if mass is not None:
        lines.append(Line("mass", [mass], _si(system, "kg"), DIGITS))
    lines.append(Line("unbalance of all nodes", [moment], _si(system, "kg m"), DIGITS))
    if speed is not None:
        lines.append(Line("speed", [abs(speed)], _si(system, "rad/s")))
        if mass:
            grade, unit = moment / mass * abs(speed), _si(system, "mm/s")
            grade *= 1e3 if unit == "mm/s" else 1.0
            lines.append(Line("balance grade at this speed", [grade], unit, DIGITS))
    if system.gravity is not None:
        lines.append(Line("gravity", [list(system.gravity)], _si(system, "m/s2"), DIGITS))
    if system.static_force is not None:
        largest = float(abs(system.static_force).max())
        lines.append(Line("largest static force", [largest], _si(system, "N"), DIGITS))
    return lines


def _mass(system: RotorSystem) -> float | None:
    """Return the mass that moves where all nodes do, if the nodes tell it."""
    try:
        return float(system.unit_translations()[:, 0] @ system.weight((1.0, 0.0)))
    except InputError:
        return None


def _si(system: RotorSystem, unit: str) -> str:
    return unit if system.units == "SI" or unit == "1" else "1"


def _or_none(value: float | None) -> float:
    return math.nan if value is None else value


def _of_stator(contact: Contact, name: str) -> float | tuple[float, ...]:
    """Return a number of a stator that moves; those along x and y where they differ."""
    if not isinstance(contact.stator, Stator):
        return math.nan
    value = getattr(contact.stator, name)
    both = value if isinstance(value, tuple) else (value,)
    return both if len({*both}) > 1 else float(both[0])


def _of_race(contact: Contact, name: str) -> float:
    race = contact.race or (contact.stator.race if isinstance(contact.stator, Stator) else None)
    return math.nan if race is None else float(getattr(race, name))
