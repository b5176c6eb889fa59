"""Parse option values without a type in cyclopts: ranges, starts, finite numbers.

Python would accept NaN as a number, "1_7" as seventeen, "10.5" as ten and digits of any script.
Here they are errors.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from cyclopts import Token

from rotor_ida import units
from rotor_ida.checks import (
    COMPONENTS,
    STARTS,
    State,
    check_point,
    check_real,
    did_you_mean,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.data_sheet import WEIGHT

SYSTEM_ENDING = ".toml"
LARGEST_RANGE = 1_000_000

# A number with a unit, and a word that looks like an option but begins with a number below zero.
WITH_UNIT = re.compile(
    r"(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(?P<unit>(?:[^\W\d_]|°).*)"
)
BELOW_ZERO = re.compile(r"-(?=[\d.])(?!-)")
# Stands for the minus of such a word while cyclopts reads the line.
MINUS = "\N{MINUS SIGN}"
# Units of x, y, vx and vy.
UNITS_OF_STATE = dict(zip(COMPONENTS, ("m", "m", "m s-1", "m s-1"), strict=True))

Value = TypeVar("Value")


def readable(words: Sequence[str]) -> list[str]:
    """Protect negative numbers from being read by cyclopts as options.

    A unit that the shell has separated from its number is joined to it again. A word for a start is
    followed by three empty words, as cyclopts reads four for each start.

    Examples
    --------
    >>> readable(["basin", "--mass", "12", "kg", "--damping", "415", "N", "s/m"])
    ['basin', '--mass', '12 kg', '--damping', '415 N s/m']
    >>> [as_given(word) for word in readable(["--x", "-1.5:1.5:64", "--start", "-60", "um"])]
    ['--x', '-1.5:1.5:64', '--start', '-60 um']
    >>> readable(["--start", "rest", "pump.toml"])
    ['--start', 'rest', '', '', '', 'pump.toml']
    """
    found: list[str] = []
    for word in words:
        number = WITH_UNIT.fullmatch(f"{found[-1]} {word}") if found else None
        if number is not None and units.unit_of(number["unit"]) is not None:
            found[-1] += f" {word}"
        else:
            found.append(word)
    return [BELOW_ZERO.sub(MINUS, word, count=1) if BELOW_ZERO.match(word) else word
            for word in _four_for_each_start(found)]  # fmt: skip


def _four_for_each_start(words: Sequence[str]) -> Iterator[str]:
    """Follow each word for a start by three empty ones."""
    count: int | None = None  # of the words of starts so far; None elsewhere
    for word, following in zip(words, [*words[1:], ""], strict=False):
        yield word
        is_option = word.startswith("--")
        option, equals, value = word.partition("=") if is_option else ("", "=", word)
        if is_option:
            count = 0 if option == "--start" else None
        if count is None or not equals:
            continue
        # a misspelt word too, but not one among numbers or after a complete start
        misspelt = count == 0 and value[:1].isalpha() and isinstance(_float(following), str)
        if count % len(COMPONENTS) == 0 and (value in STARTS or misspelt):
            empty = len(COMPONENTS) - 1
            yield from [""] * empty
            count += empty
        count += 1


def as_given(word: str) -> str:
    """Return a word as the user wrote it."""
    return word.replace(MINUS, "-")


def converter(
    parse: Callable[..., Value], *allowed: str
) -> Callable[[Any, Sequence[Token]], Value]:
    """Return a converter of cyclopts from a function of the name and the words of an option.

    The function also gets the allowed units.
    """

    def convert(_kind: Any, tokens: Sequence[Token]) -> Value:
        name = (tokens[0].keyword or "path").lstrip("-")
        return parse(name, [as_given(token.value) for token in tokens], *allowed)

    return convert


def number(name: str, words: Sequence[str]) -> float:
    """Return a word as a finite number.

    Examples
    --------
    >>> number("omega", ["1.7"])
    1.7
    >>> number("omega", ["1,7"])
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: omega must have no comma, got '1,7': write '1.7' with a point
    """
    word = words[0]
    check_point(name, word)
    found = WITH_UNIT.fullmatch(word)
    if found is not None and units.unit_of(found["unit"]) is not None:
        raise InputError(f"{name} must be a number without a unit, got {shown(word)}")
    return check_real(name, _float(word))


def whole_number(name: str, words: Sequence[str]) -> int:
    """Return a word as a whole number.

    Examples
    --------
    >>> whole_number("workers", ["2"])
    2
    >>> whole_number("workers", ["2.5"])
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: workers must be a whole number, got '2.5'
    """
    try:
        if _may_be_number(words[0]):
            return int(words[0])
    except ValueError:
        pass
    raise InputError(f"{name} must be a whole number, got {shown(words[0])}")


def numbers(name: str, words: Sequence[str], *allowed: str) -> list[float]:
    """Return numbers and ranges ``START:STOP:COUNT``, both ends included, as numbers.

    They may have one of the allowed units.

    Examples
    --------
    >>> numbers("omega", ["0.5", "1:2:3"])
    [0.5, 1.0, 1.5, 2.0]
    >>> numbers("clearance", ["100um:150um:2"], "m")
    [0.0001, 0.00015]
    >>> numbers("omega", ["1:2"])
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: omega must be numbers or START:STOP:COUNT, got '1:2'
    """
    parts = [_range(name, word, *allowed) if ":" in word else [_one(name, word, *allowed)]
             for word in words]  # fmt: skip
    check_alike(name, words, *parts)
    return [each for part in parts for each in part]


def several_numbers(name: str, words: Sequence[str], *allowed: str) -> tuple[float, ...]:
    """Return words as finite numbers, one each; allowed units are given by position.

    Examples
    --------
    >>> several_numbers("limits", ["0.5", "3"])
    (0.5, 3.0)
    >>> several_numbers("torque", ["3 Nm", "0.5"], "N m", "N m s")
    (3.0, 0.5)
    """
    if not allowed:
        return tuple(number(name, [word]) for word in words)
    found = tuple(quantity(name, [word], unit) for word, unit in zip(words, allowed, strict=True))
    if len({*allowed}) == 1:
        check_alike(name, words, found)
    return found


def limits(name: str, words: Sequence[str], *allowed: str) -> tuple[float, ...]:
    """Return the smallest and the largest value of each parameter, in any of the allowed units.

    Examples
    --------
    >>> limits("limits", ["3000rpm", "4000rpm", "0.5", "0.6"], "rad s-1", "m")[2:]
    (0.5, 0.6)
    """
    found = tuple(quantity(name, [word], *allowed) for word in words)
    for first in range(0, len(found), 2):
        check_alike(name, words[first : first + 2], found[first : first + 2])
    return found


def check_alike(name: str, words: Sequence[str], *parts: Sequence[float]) -> None:
    """Refuse numbers of which some have a unit and others none; 0 is the same in all units.

    Examples
    --------
    >>> check_alike("speed", ["0:9000rpm:2"], [0.0, Quantity(942.5, "9000rpm")])
    >>> check_alike("limits", ["120um", "200"], [Quantity(1.2e-4, "120um"), 200.0])
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: limits must have a unit at each number or at none, got '120um 200'
    """
    every = [each for part in parts for each in part]
    if len({bool(getattr(each, "word", "")) for each in every if each != 0.0}) > 1:
        raise InputError(
            f"{name} must have a unit at each number or at none, got {shown(' '.join(words))}"
        )


class Quantity(float):
    """A number in SI units with the word from which it was read.

    Parameters
    ----------
    value : float
        The number in SI units, or as given without a unit.
    word : str
        The number with its unit; empty if it had none.
    """

    __slots__ = ("word",)
    word: str

    def __new__(cls, value: float, word: str = "") -> Quantity:
        """Make a number of this kind."""
        made = super().__new__(cls, value)
        made.word = word
        return made

    @property
    def unit(self) -> str:
        """The given unit, or that of a range; empty if there was none."""
        parts = map(WITH_UNIT.fullmatch, self.word.split(":"))
        return next((part["unit"] for part in parts if part), "")


def quantity(name: str, words: Sequence[str], *allowed: str) -> Quantity:
    """Return a word as a number in SI units, with or without one of the allowed units.

    Examples
    --------
    >>> quantity("clearance", ["150um"], "m"), quantity("damping", ["415 Ns/m"], "N s m-1")
    (0.00015, 415.0)
    >>> quantity("rate", ["-100rpm/s"], "rad s-2").word
    '-100rpm/s'
    >>> quantity("mass", ["12 mm"], "kg")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: the unit of mass must be kg, g or lb, got '12 mm'
    """
    word = words[0]
    if (name, word) == ("load", WEIGHT):  # a number once the mass is known
        return Quantity(math.nan, word)
    found = None if isinstance(_float(word), float) else WITH_UNIT.fullmatch(word)
    if found is None or not _may_be_number(found["number"]):
        return Quantity(number(name, words))
    unit = units.unit_of(found["unit"])
    if unit is None or unit.dimension not in map(units.dimension_of, allowed):
        raise InputError(f"the unit of {name} must be {units.usual(*allowed)}, got {shown(word)}")
    number(name, [found["number"]])  # raises if the number is wrong
    return Quantity(check_real(name, unit.in_si(found["number"])), word)


def refuse_units(given: Mapping[str, object]) -> None:
    """Raise `InputError` for a value with a unit if the rotor is dimensionless.

    Examples
    --------
    >>> refuse_units({"to": Quantity(2.0), "speeds": [(0.0, Quantity(314.2, "3000rpm"))]})
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: speeds must have no unit for a dimensionless rotor, got '3000rpm'
    """
    for name, value in given.items():
        for each in _numbers_in(value):
            if isinstance(each, Quantity) and each.word and not _is_angle(each):
                raise InputError(
                    f"{name} must have no unit for a dimensionless rotor, got {shown(each.word)}"
                )


def _is_angle(value: Quantity) -> bool:
    """Return whether a value is an angle, whose units a dimensionless rotor has too."""
    return units.dimension_of(value.unit) == units.dimension_of("rad")


def in_unit(name: str, value: float, unit: str) -> float:
    """Return a value in the unit of its data; a value without a unit is in that unit.

    Examples
    --------
    >>> in_unit("clearance", Quantity(150e-6, "150um"), "um"), in_unit("clearance", 0.15, "mm")
    (150.0, 0.15)
    """
    if not isinstance(value, Quantity) or not value.word:
        return value
    own, given = units.unit_of(unit), units.unit_of(value.unit)
    if own is None or given is None or own.dimension != given.dimension:
        got = f"got {shown(value.word)}"
        if unit == "1":
            raise InputError(
                f"{name} must have no unit, {got}: the data have none; a measured file is given "
                "its units by --units t=s x=um y=um"
            )
        raise InputError(f"{name} must have the unit of the data, {unit}, {got}")
    moved = given._replace(factor=given.factor / own.factor, power=given.power - own.power)
    return moved.in_si(value.word.removesuffix(value.unit).strip())


def _numbers_in(value: object) -> Iterator[object]:
    if isinstance(value, (list, tuple)):
        for each in value:
            yield from _numbers_in(each)
    else:
        yield value


def speeds(name: str, words: Sequence[str]) -> list[tuple[Quantity, Quantity]]:
    """Return words ``TIME:SPEED`` as pairs of a time and a speed.

    Examples
    --------
    >>> speeds("speeds", ["0:0.5rad/s", "20s:3rad/s"])
    [(0.0, 0.5), (20.0, 3.0)]
    >>> speeds("speeds", ["0.5"])
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: speeds must be pairs TIME:SPEED, got '0.5'
    """
    found: list[tuple[Quantity, Quantity]] = []
    for word in words:
        first, *rest = word.split(":")
        if len(rest) != 1:
            raise InputError(f"{name} must be pairs TIME:SPEED, got {shown(word)}")
        time = quantity(f"the times of {name}", [first], "s")
        found.append((time, quantity(name, rest, "rad s-1")))
    for column in zip(*found, strict=True):
        check_alike(name, words, column)
    return found


def named(name: str, words: Sequence[str]) -> list[tuple[str, str]]:
    """Return words ``NAME=WORD`` as pairs.

    Examples
    --------
    >>> named("columns", ["x=Probe A", "y=Probe B"])
    [('x', 'Probe A'), ('y', 'Probe B')]
    >>> named("columns", ["x"])
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: columns must be pairs such as x=..., got 'x'
    """
    found: list[tuple[str, str]] = []
    for word in words:
        first, separator, rest = word.partition("=")
        if not (first and separator and rest):
            raise InputError(f"{name} must be pairs such as x=..., got {shown(word)}")
        if first in dict(found):
            raise InputError(f"{name} must give {first} once, got it twice")
        found.append((first, rest))
    return found


def component_or_range(name: str, words: Sequence[str]) -> float | list[float]:
    """Return a component of the start, or the numbers of a range ``START:STOP:COUNT`` of it.

    Examples
    --------
    >>> component_or_range("x", ["-1:1:3"]), component_or_range("y", ["50um"])
    ([-1.0, 0.0, 1.0], 5e-05)
    """
    unit, word = UNITS_OF_STATE[name], words[0]
    return _range(name, word, unit) if ":" in word else quantity(name, words, unit)


def component_or_ends(name: str, words: Sequence[str]) -> float | tuple[float, float]:
    """Return a component of the start, or the two ends of a range ``LOW:HIGH`` of it.

    Examples
    --------
    >>> component_or_ends("x", ["-15:15"]), component_or_ends("vx", ["1 mm/s"])
    ((-15.0, 15.0), 0.001)
    """
    unit = UNITS_OF_STATE[name]
    low, *high = words[0].split(":")
    if len(high) > 1:
        raise InputError(f"{name} must be a number or LOW:HIGH, got {shown(words[0])}")
    least = quantity(name, [low], unit)
    if not high:
        return least
    ends = least, quantity(name, high, unit)
    check_alike(name, words, ends)
    return ends


def state(name: str, words: Sequence[str]) -> State:
    """Return the words of one state as ``(x, y, vx, vy)``.

    Examples
    --------
    >>> state("start", ["10", "0", "0", "-1e-3"]), state("start", ["60um", "0", "0", "0"])
    ((10.0, 0.0, 0.0, -0.001), (6e-05, 0.0, 0.0, 0.0))
    """
    x, y, vx, vy = (
        quantity(f"{name} {part}", [word], unit)
        for (part, unit), word in zip(UNITS_OF_STATE.items(), words, strict=True)
    )
    check_alike(name, words, (x, y, vx, vy))
    return (x, y, vx, vy)


def start(name: str, words: Sequence[str]) -> State | str:
    """Return the words of one start as a state, or as the word "settled" or "rest".

    Examples
    --------
    >>> start("start", ["10", "0", "0", "-1e-3"]), start("start", ["rest", "", "", ""])
    ((10.0, 0.0, 0.0, -0.001), 'rest')
    >>> start("start", ["rset", "", "", ""])
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: start must be four numbers X Y VX VY, settled or rest, got 'rset';
    did you mean 'rest'?
    """
    word, *others = words
    if any(others):
        return state(name, words)
    if word not in STARTS:
        raise InputError(
            f"{name} must be four numbers X Y VX VY, settled or rest, got {shown(word)}"
            f"{did_you_mean(word, STARTS)}"
        )
    return word


def starts(name: str, words: Sequence[str]) -> list[State | str]:
    """Return the words of several starts, four for each.

    Examples
    --------
    >>> starts("start", ["1", "0", "0", "0", "settled", "", "", ""])
    [(1.0, 0.0, 0.0, 0.0), 'settled']
    """
    return [start(name, words[first : first + 4]) for first in range(0, len(words), 4)]


def number_or_name(_name: str, words: Sequence[str]) -> int | str:
    """Return a word that counts contacts as a number, any other word unchanged.

    Examples
    --------
    >>> number_or_name("contact", ["1"]), number_or_name("contact", ["seal"])
    (1, 'seal')
    """
    return int(words[0]) if words[0].isdecimal() else words[0]


def word(_name: str, words: Sequence[str]) -> str:
    """Return a word unchanged, for what is parsed elsewhere."""
    return words[0]


def path(name: str, words: Sequence[str]) -> Path:
    """Return a word as a path."""
    if not words[0]:  # which pathlib reads as the current folder
        raise InputError(f"{name} must be a path, got ''")
    return Path(words[0])


def system_file(_name: str, words: Sequence[str]) -> Path:
    """Return a word as the path of a system file.

    Examples
    --------
    >>> system_file("path", ["2"])
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: unexpected argument '2'; a rotor system must be a .toml file
    """
    if not words[0].endswith(SYSTEM_ENDING):
        raise InputError(
            f"unexpected argument {shown(words[0])}; a rotor system must be a {SYSTEM_ENDING} file"
        )
    return Path(words[0])


def _one(name: str, word: str, *allowed: str) -> float:
    return quantity(name, [word], *allowed) if allowed else number(name, [word])


def _range(name: str, word: str, *allowed: str) -> list[float]:
    parts = word.split(":")
    if len(parts) != 3:
        raise InputError(f"{name} must be numbers or START:STOP:COUNT, got {shown(word)}")
    if WEIGHT in parts:
        raise InputError(f"{name} must be {WEIGHT} alone or beside numbers, got {shown(word)}")
    first, last = (_one(name, part, *allowed) for part in parts[:2])
    count = whole_number(f"COUNT of {name}", parts[2:])
    if not 2 <= count <= LARGEST_RANGE:
        raise InputError(f"COUNT of {name} must lie from 2 to {LARGEST_RANGE}, got {count}")
    check_alike(name, [word], (first, last))
    step = (last - first) / (count - 1)
    listed = [*(first + place * step for place in range(count - 1)), last]
    has_unit = any(isinstance(end, Quantity) and end.word for end in (first, last))
    return [Quantity(each, word) for each in listed] if has_unit else listed


def _float(word: str) -> object:
    """Return a word as a float if possible, else unchanged."""
    try:
        return float(word) if _may_be_number(word) else word
    except ValueError:
        return word


def _may_be_number(word: str) -> bool:
    """Return whether a word has neither underscores nor the digits of other scripts."""
    return word.isascii() and "_" not in word
