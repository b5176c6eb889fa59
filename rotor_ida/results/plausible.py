"""Questions on numbers that are likely slips of a unit, in machines and rotor systems."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from rotor_ida.model.data_sheet import FASTEST, LARGEST_CLEARANCE, MILLIMETRE
from rotor_ida.model.rotor_system import RotorSystem, with_supports
from rotor_ida.units import quantity

# How far beyond a known speed one without a unit is questioned, and from where on [rad/s].
BEYOND, LEAST = 10.0, 500.0
MOST_CONDITION = 1e14
# A contact should be stiffer than the rotor where it is pressed in by this or its clearance [m].
LEAST_DEPTH = 1e-4
# Larger systems are not searched for their frequencies; a mean eccentricity is at most this [m].
MOST_SIZE, LARGEST_ECCENTRICITY = 400, 5.0 * MILLIMETRE
WITHOUT_UNIT = "; without a unit it is in {}: write {} if you meant that"


def speed_in_doubt(name: str, value: float, known: float) -> str:
    """Return a question on a speed without a unit that is far beyond a known one, else "".

    Examples
    --------
    >>> speed_in_doubt("to", 5500.0, 377.0)
    'to is 52,521 rpm, 15 times the critical or running speed: write 5500rpm if you meant that'
    >>> speed_in_doubt("to", 600.0, 377.0)
    ''
    """
    ratio = abs(value) / known if known > 0.0 else 0.0
    if ratio <= BEYOND or abs(value) < LEAST:
        return ""
    return (
        f"{name} is {quantity(value, 'rad/s')}, {ratio:.2g} times the critical or running speed: "
        f"write {value:g}rpm if you meant that"
    )


def first_critical(system: RotorSystem) -> float:
    """Return the lowest natural frequency above 0 of a system at standstill [rad/s], or NaN."""
    if system.size > MOST_SIZE:
        return float("nan")
    held = _held(system)
    squares = np.linalg.eigvals(np.linalg.solve(held.mass, held.stiffness)).real
    above = squares[squares > 1e-9 * max(float(np.abs(squares).max()), 1e-300)]
    return float(np.sqrt(above.min())) if above.size else float("nan")


def questions_on_system(
    system: RotorSystem, speed: float | None, entries: Mapping[str, object]
) -> list[str]:
    """Return a question for each implausible number of a system in SI units.

    Parameters
    ----------
    system : RotorSystem
        The system.
    speed : float, optional
        Its running speed.
    entries : mapping
        What its file says: numbers without a unit are likely slips.

    Examples
    --------
    >>> from rotor_ida import Contact, Unbalance
    >>> system = RotorSystem(
    ...     mass=12.0 * np.eye(2), stiffness=4e6 * np.eye(2), nodes={"disc": (0, 1)},
    ...     contacts=[Contact(node="disc", clearance=0.06, stiffness=1e9, exponent=1.0)],
    ...     unbalance=[Unbalance(node="disc", moment=2e-4)])
    >>> questions_on_system(system, 1e4, {"speed": 1e4})
    ['speed is 95,493 rpm, 17 times the critical or running speed: write 10000rpm if you meant
    that',
    'contacts[0].clearance is 60 mm; those of rotors are below 10 mm']
    """
    return [*_of_speed(system, speed, entries.get("speed")), *_of_contacts(system, entries),
            *_of_unbalance(system, entries)]  # fmt: skip


def _of_speed(system: RotorSystem, speed: float | None, given: object) -> Iterator[str]:
    if speed is None or abs(speed) < LEAST:
        return
    known = first_critical(system)
    if not isinstance(given, str):
        yield from filter(None, [speed_in_doubt("speed", speed, known)])
    elif abs(speed) > FASTEST * known:
        yield (f"speed is {abs(speed) / known:.3g} times the critical speed: is the unit of one of "
               "them wrong?")  # fmt: skip


def _of_contacts(system: RotorSystem, entries: Mapping[str, object]) -> Iterator[str]:
    """Yield questions on clearances, and on contacts that are softer than the rotor."""
    tables = entries.get("contacts")
    for number, contact in enumerate(system.contacts):
        raw = tables[number] if isinstance(tables, list) and number < len(tables) else {}
        place, given = f"contacts[{number}]", raw.get("clearance")
        if contact.clearance >= LARGEST_CLEARANCE:
            largest = quantity(LARGEST_CLEARANCE, "m")
            said = f"{place}.clearance is {quantity(contact.clearance, 'm')}; those of rotors are "
            yield f"{said}below {largest}{_meant(given, 'm', 'mm')}"
        depth = max(contact.clearance, LEAST_DEPTH)
        if contact.stiffness * depth ** (contact.exponent - 1.0) < _stiffness_at(
            system, contact.node
        ):
            said = f"{place}.stiffness is below that of the rotor at {contact.node!r}"
            yield said + _meant(raw.get("stiffness"), "N/m^1.5, of a Hertz contact", "N/m")


def _stiffness_at(system: RotorSystem, node: str) -> float:
    """Return the smaller static stiffness of a rotor at a node; 0 where it is free."""
    rows, held = system.rows(node), _held(system)
    if system.size > MOST_SIZE or np.linalg.cond(held.stiffness) > MOST_CONDITION:
        return 0.0
    return 1.0 / float(np.linalg.eigvals(rows @ np.linalg.solve(held.stiffness, rows.T)).real.max())


def _held(system: RotorSystem) -> RotorSystem:
    """Return a system with supports in its matrices, and bearings as where their tables begin."""
    begins = max((float(each.knots[0]) for each in system.bearings if each.varies), default=0.0)
    return with_supports(system.at(begins), system.supports)


def _of_unbalance(system: RotorSystem, entries: Mapping[str, object]) -> Iterator[str]:
    """Yield questions on moments that are large for the mass of the rotor."""
    mass = float(np.trace(system.mass)) / 2.0
    tables = entries.get("unbalance")
    for number, each in enumerate(system.unbalance):
        raw = tables[number] if isinstance(tables, list) and number < len(tables) else {}
        eccentricity = each.moment / mass
        if eccentricity > LARGEST_ECCENTRICITY:
            yield (
                f"unbalance[{number}].moment is an eccentricity of {quantity(eccentricity, 'm')} "
                f"of the whole mass{_meant(raw.get('moment'), 'kg m', 'g mm')}"
            )


def _meant(given: object, si: str, usual: str) -> str:
    """Return what to write if a number was meant in a usual unit; nothing if it has one."""
    if isinstance(given, str | None):
        return ""
    return WITHOUT_UNIT.format(si, f'"{given:g} {usual}"')
