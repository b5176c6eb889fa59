"""From the words of a command line to numbers, ranges and starts."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rotor_ida.checks import State, check_count, check_real, check_state
from rotor_ida.errors import InputError

LARGEST_RANGE = 1_000_000
MOST_POINTS = 5_000_000
# What a study has not in hand is on the disk.
MOST_POINTS_OF_STUDY = 10_000_000_000
MOST_SAMPLES = 10_000_000
MOST_WORKERS = 512


def number(name: str, word: str) -> float:
    """Return a word as a finite number.

    Examples
    --------
    >>> number("omega", "1.7")
    1.7
    >>> number("omega", "1,7")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: omega must be a finite real number, got '1,7'
    """
    return check_real(name, _float(word))


def whole_number(name: str, word: str, minimum: int, maximum: int) -> int:
    """Return a word as a whole number between two limits.

    Examples
    --------
    >>> whole_number("workers", "2", 1, 512)
    2
    >>> whole_number("workers", "2.5", 1, 512)
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: workers must be a whole number, got '2.5'
    """
    return check_count(name, _int(word), minimum, maximum)


def samples(word: str) -> int:
    """Return a number of samples that fits into the memory of most machines."""
    return whole_number("samples", word, 2, MOST_SAMPLES)


def workers(word: str | None) -> int | None:
    """Return a number of processes; None if none was given."""
    return None if word is None else whole_number("workers", word, 1, MOST_WORKERS)


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
    if not words:
        raise InputError(f"{name} must hold at least one number, got none")
    listed: list[float] = []
    for word in words:
        listed += _range(name, word) if ":" in word else [number(name, word)]
    return listed


def number_or_range(name: str, word: str) -> float | list[float]:
    """Return a word as a number, or as the numbers of a range ``START:STOP:COUNT``.

    Examples
    --------
    >>> number_or_range("x", "-1:1:3"), number_or_range("y", "0.5")
    ([-1.0, 0.0, 1.0], 0.5)
    """
    return _range(name, word) if ":" in word else number(name, word)


def number_or_ends(name: str, word: str) -> float | tuple[float, float]:
    """Return a word as a number, or as the two ends of a range ``LOW:HIGH``.

    Examples
    --------
    >>> number_or_ends("x", "-15:15"), number_or_ends("vx", "0")
    ((-15.0, 15.0), 0.0)
    """
    parts = word.split(":")
    if len(parts) == 1:
        return number(name, word)
    if len(parts) != 2:
        raise InputError(f"{name} must be a number or LOW:HIGH, got {word!r}")
    return number(name, parts[0]), number(name, parts[1])


def state(name: str, words: Sequence[str]) -> State:
    """Return the words of one start as ``(x, y, vx, vy)``.

    Examples
    --------
    >>> state("start", ["10", "0", "0", "-1e-3"])
    (10.0, 0.0, 0.0, -0.001)
    """
    return check_state(name, [_float(word) for word in words])


def _range(name: str, word: str) -> list[float]:
    parts = word.split(":")
    if len(parts) != 3:
        raise InputError(f"{name} must be numbers or START:STOP:COUNT, got {word!r}")
    start, stop = number(name, parts[0]), number(name, parts[1])
    count = whole_number(f"COUNT of {name}", parts[2], 2, LARGEST_RANGE)
    step = (stop - start) / (count - 1)
    return [*(start + place * step for place in range(count - 1)), stop]


def _float(word: str) -> object:
    """Return a word as a float, or as it is; "1_7" is more likely a slip than seventeen."""
    try:
        return word if "_" in word else float(word)
    except ValueError:
        return word


def _int(word: str) -> object:
    try:
        return word if "_" in word else int(word)
    except ValueError:
        return word


def check_points(*axes: Sequence[object], in_study: bool = False) -> int:
    """Return the number of points of a grid, if it is not absurdly large."""
    points = math.prod(len(axis) for axis in axes)
    most = MOST_POINTS_OF_STUDY if in_study else MOST_POINTS
    if points > most:
        more = "" if in_study else f" (in a study, with --study, {MOST_POINTS_OF_STUDY})"
        raise InputError(f"the grid must have at most {most} points{more}, got {points}")
    return points
