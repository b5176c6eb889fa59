"""The SI units of arguments, and the value of a dimensionless 1 of a machine in each of them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.errors import Amount, InputError, SimulationError
from rotor_ida.model.parameters import OF_MACHINE

if TYPE_CHECKING:
    from rotor_ida.model.rotor import DimensionalRotor

# The parameter of a machine that becomes each dimensionless one; others keep their name.
IS_OF_MACHINE = {"omega": "speed", "zeta": "damping", "delta0": "clearance"}
BECOMES = {of_machine: plain for plain, of_machine in IS_OF_MACHINE.items()}
_STATE = ("m", "m", "m s-1", "m s-1")
# The units of arguments, and of attributes of results, that are given in SI units for a machine:
# one for all numbers, or one for each column.
UNITS_OF_ARGUMENTS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("start", "starts", "state"), _STATE),
    **dict(zip(("x", "y", "vx", "vy"), map(tuple, zip(_STATE, strict=True)), strict=True)),
    **dict.fromkeys(("duration", "ramp_time", "transient", "extrema_time", "period"), ("s",)),
    **dict.fromkeys(("samples", "start_period", "record_length"), ("s",)),
    **{f"range_{name}": (unit,) for name, unit in zip(("x", "y", "vx", "vy"), _STATE, strict=True)},
    "to": ("rad s-1",), "rate": ("rad s-2",), "speeds": ("s", "rad s-1"),
    "torque": ("N m", "N m s"), "inertia": ("kg m2",), "slope": ("N m s",),
}  # fmt: skip
# The same with what messages name beside arguments; those of a parameter that sets the scales, and
# numbers without a unit, are left out.
_UNITS_IN_MESSAGES: dict[str, tuple[str, ...]] = UNITS_OF_ARGUMENTS | {
    **{name: (each.unit,) for name, each in OF_MACHINE.items()
       if each.unit != "1" and "m-1.5" not in each.unit},
    **{plain: (OF_MACHINE[name].unit,) for plain, name in IS_OF_MACHINE.items()},
    **dict.fromkeys(("time", "end_time"), ("s",)), "a speed of speeds": ("rad s-1",),
}  # fmt: skip
# Those of rotor systems alone, by a word or by the first words with which messages name them.
_UNITS_OF_SYSTEMS = {
    **dict.fromkeys(("radius", "centre", "position", "reach", "vibration_limit"), "m"),
    **dict.fromkeys(("limits", "fastest"), "rad s-1"),
    **dict.fromkeys(("stiffness of a stator", "stiffness of the support"), "N m-1"),
    **dict.fromkeys(("stiffness of the stator", "contact_stiffness"), "N m-1"),
    "stiffness of the bearing": "N m-1", "damping of the bearing": "N s m-1",
    "damping of the contact": "s m-1", "mass": "kg", "moment": "kg m", "drag": "N m s",
    "gravity": "m s-2", "the rate of speeds": "rad s-2", "times of speeds": "s",
}  # fmt: skip


def unit_of_parameter(name: str) -> str:
    """Return the SI unit of a parameter, by its name for a machine or a dimensionless rotor.

    Examples
    --------
    >>> unit_of_parameter("delta0"), unit_of_parameter("damping"), unit_of_parameter("friction")
    ('m', 'N s m-1', '1')
    """
    return OF_MACHINE[IS_OF_MACHINE.get(name, name)].unit


def unit_scale(machine: DimensionalRotor, unit: str) -> float:
    """Return the value of a dimensionless 1 of a machine in an SI unit; 1 where it has no unit."""
    rate, velocity = machine.reference_frequency, machine.velocity_scale
    return {
        "1": 1.0, "m": machine.length_scale, "s": machine.time_scale, "m s-1": velocity,
        "rad s-1": rate, "rad s-2": rate**2, "N": machine.force_scale,
        "N m-1": machine.mass * rate**2, "N s m-1": 2.0 * machine.mass * rate,
        "s m-1": 1.0 / velocity, "N m": machine.torque_scale,
        "N m s": machine.torque_scale / rate, "kg m2": machine.inertia_scale,
    }[unit]  # fmt: skip


def without_units(machine: DimensionalRotor, unit: str, values: Values) -> Values:
    """Return dimensionless values, with the same bits as those of `DimensionalRotor.rotor`."""
    with np.errstate(over="ignore"):  # what is infinite then is refused
        if unit == "s m-1":
            return values * machine.velocity_scale
        return values / unit_scale(machine, unit)


def unit_of(name: str, place: int = 0) -> str | None:
    """Return the SI unit of a number of an argument or parameter; None if it has none.

    The name may be within words, as messages have it.

    Examples
    --------
    >>> unit_of("duration"), unit_of("start vx"), unit_of("limits of delta0"), unit_of("rtol")
    ('s', 'm s-1', 'm', None)
    >>> [unit_of("speeds", place) for place in (0, 1)], unit_of("a speed of speeds")
    (['s', 'rad s-1'], 'rad s-1')
    """
    for word in (name, *reversed(name.split())):
        if units := _UNITS_IN_MESSAGES.get(word):
            return units[place % len(units)]
    return None


def unit_in_system(name: str, place: int = 0) -> str | None:
    """Return the SI unit of a number that a message about a rotor system names; None if none.

    Examples
    --------
    >>> unit_in_system("clearance of the contact at 'disc'"), unit_in_system("moment")
    ('m', 'kg m')
    >>> unit_in_system("damping of the contact at 'disc'"), unit_in_system("damping of a stator")
    ('s m-1', 'N s m-1')
    """
    words = name.split()
    beginnings = [" ".join(words[:count]) for count in range(len(words), 0, -1)]
    found = next(filter(None, map(_UNITS_OF_SYSTEMS.get, (*beginnings, *words))), None)
    is_state = {"start", "starts", "state"} & {*words}  # in the coordinates of the system
    return found or (None if is_state else unit_of(name, place))


@contextmanager
def errors_in_units(units: str) -> Iterator[None]:
    """Give the numbers in errors about a rotor system the units of the system, "SI" or "1".

    Examples
    --------
    >>> with errors_in_units("SI"):
    ...     raise InputError("{name} must be positive, got {value}", name="duration", value=-0.5)
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: duration must be positive, got -0.5 s
    """

    def amount(field: str, name: str, place: int, value: float) -> float:
        unit = unit_in_system(field, place) or unit_in_system(name, place)
        return Amount(value, unit) if unit and not isinstance(value, Amount) else value

    try:
        yield
    except (InputError, SimulationError) as error:
        if units != "SI" or not error.fields:
            raise
        raise error.with_numbers(amount) from error
