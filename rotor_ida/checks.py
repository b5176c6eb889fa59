"""Checks of what a user passes in: each returns the clean value or raises one clear line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.errors import InputError

State = tuple[float, float, float, float]

# The components of a state, in their order everywhere.
COMPONENTS = ("x", "y", "vx", "vy")

LARGEST_SEED = 2**63 - 1


def check_real(name: str, value: object) -> float:
    """Return `value` as a finite float.

    Examples
    --------
    >>> check_real("omega", 2)
    2.0
    >>> check_real("omega", "2")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: omega must be a finite real number, got '2'
    """
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Real):
        raise InputError(f"{name} must be a finite real number, got {value!r}")
    try:
        number = float(value)
    except (OverflowError, ValueError):
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{name} must be a finite real number, got {value!r}")
    return number


def check_nonnegative(name: str, value: object) -> float:
    """Return `value` as a finite float that is zero or more."""
    number = check_real(name, value)
    if number < 0.0:
        raise InputError(f"{name} must be zero or positive, got {number!r}")
    return number + 0.0


def check_positive(name: str, value: object) -> float:
    """Return `value` as a finite float above zero."""
    number = check_real(name, value)
    if number <= 0.0:
        raise InputError(f"{name} must be positive, got {number!r}")
    return number


def check_count(name: str, value: object, minimum: int = 1) -> int:
    """Return `value` as an int of at least `minimum`."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Integral):
        raise InputError(f"{name} must be a whole number, got {value!r}")
    if value < minimum:
        raise InputError(f"{name} must be at least {minimum}, got {int(value)!r}")
    return int(value)


def check_seed(value: object) -> int:
    """Return the seed of random numbers, which must go into an archive too."""
    seed = check_count("seed", value, minimum=0)
    if seed > LARGEST_SEED:
        raise InputError(f"seed must be at most {LARGEST_SEED}, got {seed}")
    return seed


def check_choice(name: str, value: object, allowed: Sequence[str]) -> str:
    """Return `value` if it is one of the words in `allowed`."""
    if not isinstance(value, str) or value not in allowed:
        words = ", ".join(repr(word) for word in allowed)
        raise InputError(f"{name} must be one of {words}, got {value!r}")
    return value


def check_state(name: str, value: object) -> State:
    """Return `value` as the four finite floats ``(x, y, vx, vy)``."""
    given: Any = value
    try:
        numbers = list(given)
    except TypeError:
        numbers = []
    if len(numbers) != 4 or isinstance(value, (str, bytes, dict)):
        raise InputError(f"{name} must be four numbers (x, y, vx, vy), got {value!r}")
    x, y, vx, vy = (
        check_real(f"{name} {part}", number)
        for part, number in zip(COMPONENTS, numbers, strict=True)
    )
    return (x, y, vx, vy)


def check_axis(name: str, values: object) -> npt.NDArray[np.float64]:
    """Return `values`, a scalar or a sequence, as a 1-D array of finite numbers >= 0."""
    listed: Any = values.tolist() if isinstance(values, np.ndarray) else values
    if isinstance(listed, (str, bytes, dict)):
        raise InputError(f"{name} must be a number or a sequence of numbers, got {values!r}")
    try:
        numbers = list(listed)
    except TypeError:
        numbers = [listed]
    if not numbers:
        raise InputError(f"{name} must hold at least one number, got none")
    return np.array([check_nonnegative(name, number) for number in numbers])
