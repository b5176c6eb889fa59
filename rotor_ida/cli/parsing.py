"""From the words of an option to what cyclopts has no type for: ranges, starts, finite numbers.

Python would take NaN for a number, "1_7" for seventeen, "10.5" for ten and the digits of every
script for its own: here they are slips.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeVar

from cyclopts import Token

from rotor_ida.checks import MOST_POINTS_OF_STUDY, State, check_real, check_state, shown
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import SPEED_UNITS, SpeedUnit

LARGEST_RANGE = 1_000_000
MOST_POINTS = 5_000_000

# What cyclopts takes for an option where it is not ``-15:15`` of whole numbers.
NEGATIVE_RANGE = re.compile(r"-[\d.](?:[^:]*:|.*(?:rad/s|rpm|Hz))")
# A number with a unit: of a speed, or of a rate, by which a speed changes in a second.
WITH_UNIT = re.compile(r"(?P<number>[-+.\dEe]*[.\d])\s*(?P<unit>[^-+.\d].*)")
RATE_UNITS = {"rad/s": ("rad/s2", "rad/s^2", "rad/s²")}

Value = TypeVar("Value")


def with_ranges_joined(words: Sequence[str]) -> list[str]:
    """Return words in which a range that begins below zero is tied to its option by ``=``.

    So is a number below zero that has a unit.

    Examples
    --------
    >>> with_ranges_joined(["basin", "--x", "-1.5:1.5:64", "--y", "-2"])
    ['basin', '--x=-1.5:1.5:64', '--y', '-2']
    """
    found: list[str] = []
    for word in words:
        option = found[-1] if found else ""
        opens = len(option) > 2 and option.startswith("--") and "=" not in option
        if opens and NEGATIVE_RANGE.match(word):
            found[-1] = f"{option}={word}"
        else:
            found.append(word)
    return found


def converter(
    parse: Callable[[str, Sequence[str]], Value],
) -> Callable[[Any, Sequence[Token]], Value]:
    """Return a function of the name and the words of an option as a converter of cyclopts."""

    def convert(_kind: Any, tokens: Sequence[Token]) -> Value:
        return parse((tokens[0].keyword or "path").lstrip("-"), [token.value for token in tokens])

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
    rotor_ida.errors.InputError: omega must be a finite real number, got '1,7'
    """
    return check_real(name, _float(words[0]))


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


def numbers(name: str, words: Sequence[str]) -> list[float]:
    """Return numbers and ranges ``START:STOP:COUNT``, both ends included, as numbers.

    Examples
    --------
    >>> numbers("omega", ["0.5", "1:2:3"])
    [0.5, 1.0, 1.5, 2.0]
    >>> numbers("omega", ["1:2"])
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: omega must be numbers or START:STOP:COUNT, got '1:2'
    """
    listed: list[float] = []
    for word in words:
        listed += _range(name, word) if ":" in word else [number(name, [word])]
    return listed


def several_numbers(name: str, words: Sequence[str]) -> tuple[float, ...]:
    """Return words as finite numbers, one each.

    Examples
    --------
    >>> several_numbers("limits", ["0.5", "3"])
    (0.5, 3.0)
    """
    return tuple(number(name, [word]) for word in words)


class Measured(NamedTuple):
    """A number, and the unit of speed that it was given with; empty where it was given alone."""

    value: float
    unit: SpeedUnit | Literal[""]


def speed(name: str, words: Sequence[str]) -> Measured:
    """Return a word as a speed, alone or with its unit.

    Examples
    --------
    >>> speed("to", ["3000rpm"])
    Measured(value=3000.0, unit='rpm')
    >>> speed("to", ["2.2"]), speed("to", ["1e-3"])
    (Measured(value=2.2, unit=''), Measured(value=0.001, unit=''))
    >>> speed("to", ["3 km/h"])
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: the unit of to must be rad/s, rpm or Hz, got '3 km/h'
    """
    found = None if isinstance(_float(words[0]), float) else WITH_UNIT.fullmatch(words[0])
    if found is None:
        return Measured(number(name, words), "")
    for unit in SPEED_UNITS:
        if found["unit"] == unit:
            return Measured(number(name, [found["number"]]), unit)
    raise InputError(f"the unit of {name} must be rad/s, rpm or Hz, got {shown(words[0])}")


def rate(name: str, words: Sequence[str]) -> Measured:
    """Return a word as the rate at which a speed changes, alone or with its unit.

    Examples
    --------
    >>> rate("rate", ["-100rpm/s"]), rate("rate", ["3rad/s2"])
    (Measured(value=-100.0, unit='rpm'), Measured(value=3.0, unit='rad/s'))
    """
    found = None if isinstance(_float(words[0]), float) else WITH_UNIT.fullmatch(words[0])
    if found is None:
        return Measured(number(name, words), "")
    for unit in SPEED_UNITS:
        if found["unit"] in {f"{unit}/s", *RATE_UNITS.get(unit, ())}:
            return Measured(number(name, [found["number"]]), unit)
    raise InputError(f"the unit of {name} must be rad/s2, rpm/s or Hz/s, got {shown(words[0])}")


def radians(name: str, words: Sequence[str]) -> float:
    """Return a word as a speed in rad/s, which is its unit if none is given.

    Examples
    --------
    >>> radians("speed", ["600"]), round(radians("speed", ["600rpm"]), 6)
    (600.0, 62.831853)
    """
    return in_radians(speed(name, words))


def in_radians(measured: Measured) -> float:
    """Return a speed in rad/s, or a rate in rad/s^2."""
    return measured.value * (SPEED_UNITS[measured.unit] if measured.unit else 1.0)


def speeds(name: str, words: Sequence[str]) -> list[tuple[float, Measured]]:
    """Return words ``TIME:SPEED`` as pairs of a time and a speed.

    Examples
    --------
    >>> speeds("speeds", ["0:0.5", "20:2"])[1]
    (20.0, Measured(value=2.0, unit=''))
    >>> speeds("speeds", ["0.5"])
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: speeds must be pairs TIME:SPEED, got '0.5'
    """
    found: list[tuple[float, Measured]] = []
    for word in words:
        first, *rest = word.split(":")
        if len(rest) != 1:
            raise InputError(f"{name} must be pairs TIME:SPEED, got {shown(word)}")
        found.append((number(name, [first]), speed(name, rest)))
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
            raise InputError(f"{name} must tell {first} once, got it twice")
        found.append((first, rest))
    return found


def number_or_range(name: str, words: Sequence[str]) -> float | list[float]:
    """Return a word as a number, or as the numbers of a range ``START:STOP:COUNT``.

    Examples
    --------
    >>> number_or_range("x", ["-1:1:3"]), number_or_range("y", ["0.5"])
    ([-1.0, 0.0, 1.0], 0.5)
    """
    return _range(name, words[0]) if ":" in words[0] else number(name, words)


def number_or_ends(name: str, words: Sequence[str]) -> float | tuple[float, float]:
    """Return a word as a number, or as the two ends of a range ``LOW:HIGH``.

    Examples
    --------
    >>> number_or_ends("x", ["-15:15"]), number_or_ends("vx", ["0"])
    ((-15.0, 15.0), 0.0)
    """
    low, *high = words[0].split(":")
    if len(high) > 1:
        raise InputError(f"{name} must be a number or LOW:HIGH, got {shown(words[0])}")
    return (number(name, [low]), number(name, high)) if high else number(name, [low])


def start(name: str, words: Sequence[str]) -> State:
    """Return the words of one start as ``(x, y, vx, vy)``.

    Examples
    --------
    >>> start("start", ["10", "0", "0", "-1e-3"])
    (10.0, 0.0, 0.0, -0.001)
    """
    return check_state(name, [_float(word) for word in words])


def starts(name: str, words: Sequence[str]) -> list[State]:
    """Return the words of several starts, four for each.

    Examples
    --------
    >>> starts("start", ["1", "0", "0", "0", "0", "0", "0", "-2"])
    [(1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, -2.0)]
    """
    return [start(name, words[first : first + 4]) for first in range(0, len(words), 4)]


def path(name: str, words: Sequence[str]) -> Path:
    """Return a word as a path."""
    if not words[0]:  # which pathlib takes for the folder it is in
        raise InputError(f"{name} must be a path, got ''")
    return Path(words[0])


def check_points(*axes: Sequence[object], in_study: bool = False) -> None:
    """Refuse a grid that is absurdly large."""
    points = math.prod(len(axis) for axis in axes)
    most = MOST_POINTS_OF_STUDY if in_study else MOST_POINTS
    if points > most:
        more = "" if in_study else f" (in a study, with --study, {MOST_POINTS_OF_STUDY})"
        raise InputError(f"the grid must have at most {most} points{more}, got {points}")


def _range(name: str, word: str) -> list[float]:
    parts = word.split(":")
    if len(parts) != 3:
        raise InputError(f"{name} must be numbers or START:STOP:COUNT, got {shown(word)}")
    first, last = number(name, parts[:1]), number(name, parts[1:2])
    count = whole_number(f"COUNT of {name}", parts[2:])
    if not 2 <= count <= LARGEST_RANGE:
        raise InputError(f"COUNT of {name} must lie from 2 to {LARGEST_RANGE}, got {count}")
    step = (last - first) / (count - 1)
    return [*(first + place * step for place in range(count - 1)), last]


def _float(word: str) -> object:
    """Return a word as a float, or as it is."""
    try:
        return float(word) if _may_be_number(word) else word
    except ValueError:
        return word


def _may_be_number(word: str) -> bool:
    """Return whether a word has neither underscores nor the digits of other scripts."""
    return word.isascii() and "_" not in word
