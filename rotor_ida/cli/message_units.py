"""Messages in the units of the user: rpm where rpm was given.

Errors carry their numbers, those of a machine in SI units. The user gave a word such as
``3000rpm``: here the numbers of a message return to the units of the command line and its file.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from rotor_ida import units
from rotor_ida.cli.parsing import WITH_UNIT, Quantity
from rotor_ida.errors import Amount, RotorError

# Units of a machine's speeds where none was given; others are in SI units.
USUAL = {"rad s-1": "rpm", "rad s-2": "rpm/s"}
# The name in messages of a keyword that is a word of Python there.
OPTION = {"begin": "from"}
# Conversions there and back, or to six digits.
ROUNDING = 1e-12

Failure = TypeVar("Failure", bound=RotorError)


class Given(NamedTuple):
    """A number as given: the name of its option or entry, its value in SI units, its unit."""

    name: str
    value: float
    unit: str = ""
    in_file: bool = False

    def in_unit_of(self, si: str) -> bool:
        """Return whether its unit is one of the same dimension."""
        return bool(self.unit) and units.dimension_of(self.unit) == units.dimension_of(si)


def in_given_units(arguments: Mapping[str, Any], error: Failure) -> Failure:
    """Return an error about the arguments of a command in the units in which they were given.

    Parameters
    ----------
    arguments : mapping of str to object
        The arguments of the function of the command.
    error : InputError or SimulationError
        What is wrong.
    """
    given = list(_on_the_line(arguments))
    with suppress(RotorError):  # the message says what is wrong with the file
        given += _in_files(arguments)
    return rewritten(error, given)


def rewritten(error: Failure, given: Sequence[Given]) -> Failure:
    """Return an error with its numbers in given units.

    Parameters
    ----------
    error : InputError or SimulationError
        The error.
    given : sequence of Given
        The numbers of the command line, then those of its file.

    Examples
    --------
    >>> from rotor_ida.errors import Amount, InputError
    >>> given = [Given("rate", -10.471975511965976, "rpm/s"), Given("to", 628.3185307179587, "rpm")]
    >>> error = InputError(
    ...     "{name} must be positive to change the speed from 0 to {to}, got {value}",
    ...     name="rate", to=Amount(628.3185307179587, "rad s-1"),
    ...     value=Amount(-10.471975511965976, "rad s-2"),
    ... )
    >>> print(rewritten(error, given))
    rate must be positive to change the speed from 0 to 6000 rpm, got -100 rpm/s
    """

    def typed(_field: str, name: str, _place: int, value: float) -> float:
        if not isinstance(value, Amount):
            return value
        return Amount(value, value.unit, _text(name, value, value.unit, given))

    return error.with_numbers(typed)


def _text(name: str, value: float, si: str, given: Sequence[Given]) -> str:
    """Return a number in the unit in which it was given, or which suits it; or nothing."""
    unit = _unit(name.rsplit(" ", maxsplit=1)[-1], si, given)
    for each in given:
        if math.isclose(value, each.value, rel_tol=ROUNDING) and each.in_unit_of(si):
            value, unit = each.value, each.unit
            break
    known = units.unit_of(unit)
    return f"{value / known.in_si('1'):.6g} {unit}" if known is not None else ""


def _unit(name: str, si: str, given: Sequence[Given]) -> str:
    """Return the unit for numbers of a quantity: its own, or one of the same dimension."""
    names = (name, f"{name}s")  # a speed of speeds
    own = [each for each in given if each.name in names and not each.in_file]
    if own and not own[0].unit:
        return units.spelled(si)
    alike = [each.unit for each in (*own, *given) if each.in_unit_of(si)]
    return alike[0] if alike else USUAL.get(si, units.spelled(si))


def _on_the_line(arguments: Mapping[str, Any]) -> Iterator[Given]:
    """Yield the numbers of the command line."""
    for name, value in arguments.items():
        if is_dataclass(value) and not isinstance(value, type):
            yield from _on_the_line(asdict(value))
        else:
            yield from _in_entry(OPTION.get(name, name), value)


def _in_files(arguments: Mapping[str, Any]) -> Iterator[Given]:
    """Yield the numbers in the files of a machine and of a system."""
    from rotor_ida.results.toml_files import read_toml  # noqa: PLC0415 - only after an error

    files = [getattr(group, "machine", None) for group in arguments.values()]
    for file in [*files, arguments.get("system")]:
        if isinstance(file, Path):
            yield from (each._replace(in_file=True) for each in _in_entry("", read_toml("", file)))


def _in_entry(name: str, entry: object) -> Iterator[Given]:
    """Yield the numbers of an option, or of an entry of a file and its parts."""
    if isinstance(entry, Mapping):
        for key, each in entry.items():
            yield from _in_entry(key, each)
    elif isinstance(entry, (list, tuple)):
        for each in entry:
            yield from _in_entry(name, each)
    elif isinstance(entry, Quantity) and entry.word:
        yield Given(name, entry, entry.unit)
    elif isinstance(entry, float):
        yield Given(name, entry)
    elif isinstance(entry, str) and (word := WITH_UNIT.fullmatch(entry.strip())):
        unit = units.unit_of(word["unit"])
        if unit is not None:
            yield Given(name, unit.in_si(word["number"]), word["unit"])
