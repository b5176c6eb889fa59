"""The exceptions of the package, each with a one-line message that shows how to proceed."""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable, Mapping
from copy import copy
from functools import partial
from string import Formatter
from typing import Protocol, Self, cast, runtime_checkable

from rotor_ida.texts import printable
from rotor_ida.units import spelled

# Digits of numbers that were converted to their units: of given ones as many as show no rounding.
DIGITS, DIGITS_OF_BOUNDS = 12, 6
# Longer sequences are cut.
LONGEST_SEQUENCE = 6
PACKAGE = __name__.partition(".")[0]


class Amount(float):
    """A number of a message in an SI unit, or as `text` where the user wrote another one.

    Examples
    --------
    >>> Amount(-0.5, "s"), Amount(2.0, "rad s-2"), Amount(314.159, "rad s-1", "3000 rpm")
    (-0.5 s, 2 rad/s2, 3000 rpm)
    """

    __slots__ = ("text", "unit")
    unit: str
    text: str

    def __new__(cls, value: float, unit: str, text: str = "") -> Self:
        """Make a number with a unit."""
        made = super().__new__(cls, value)
        made.unit, made.text = unit, text
        return made

    def __getnewargs__(self) -> tuple[float, str, str]:  # type: ignore[override]
        """Keep the unit when an error crosses a process boundary."""
        return float(self), self.unit, self.text

    def __repr__(self) -> str:
        return self.shown(DIGITS)

    def shown(self, digits: int) -> str:
        """Return the number with its unit."""
        return self.text or f"{float(self):.{digits}g} {spelled(self.unit)}"


# What a number of a message becomes, from its field, the name of what is wrong, and its place among
# the numbers of the field.
Changed = Callable[[str, str, int, float], float]


@runtime_checkable
class Named(Protocol):
    """A field of a message with names of arguments, which another problem may call otherwise."""

    def in_words(self, words: Mapping[str, str]) -> Self:
        """Return the same with these words for names."""


class RotorError(Exception):
    """Base of every error that this package raises on purpose.

    The message may be a template, whose fields are kept: ``name``, of the argument that is wrong,
    its ``value``, and what is allowed. A field with the name of an argument is a number of that
    argument, any other is one of ``name``; ``{omega=}`` writes the name too. Names of files in a
    message may have characters that a terminal obeys: they are shown instead.
    """

    def __init__(self, *told: object, **fields: object) -> None:
        self.template, self.fields = str(told[0]) if fields else "", fields
        self.words: Mapping[str, str] = {}
        if fields:
            told = (_filled(self.template, fields, {}),)
        super().__init__(*(printable(each) if isinstance(each, str) else each for each in told))

    def with_numbers(self, changed: Changed, words: Mapping[str, str] = {}) -> Self:
        """Return the same error with other numbers, such as those in SI units, and names."""
        if not self.fields:
            return self
        made, name = copy(self), str(self.fields.get("name", ""))
        made.fields = {field: _changed(value, partial(changed, field, name))
                       for field, value in self.fields.items()}  # fmt: skip
        for field, value in made.fields.items():
            if isinstance(value, Named):
                made.fields[field] = value.in_words(words)
        if name:
            made.fields["name"] = " ".join(words.get(each, each) for each in name.split(" "))
        made.words = {**self.words, **words}
        made.args = (printable(_filled(self.template, made.fields, made.words)),)
        return made

    def within(self, beginning: str) -> Self:
        """Return the same error with the beginning of a longer message, such as its place."""
        made = copy(self)
        made.args = (printable(f"{beginning}{self}"),)
        if self.fields:
            made.template = beginning.replace("{", "{{").replace("}", "}}") + self.template
        return made


class InputError(RotorError, ValueError):
    """A value that cannot be used: the message gives its name, the value and what is allowed.

    Examples
    --------
    >>> error = InputError("{name} must be below {most} at {omega=}, got {value}",
    ...                    name="duration", most=9.0, omega=2.0, value=20.0)
    >>> print(error)
    duration must be below 9.0 at omega 2.0, got 20.0
    >>> error.name, error.value
    ('duration', 20.0)
    """

    @property
    def name(self) -> str:
        """The argument that is wrong; empty if the message names none."""
        return str(self.fields.get("name", ""))

    @property
    def value(self) -> object:
        """What was given for it."""
        return self.fields.get("value")


class MissingFileError(InputError, FileNotFoundError):
    """A file or study to read that does not exist."""


class SimulationError(RotorError, RuntimeError):
    """An integration that failed, with the time and, of one disc, the state of the failure.

    Parameters
    ----------
    message : str
        What happened, in the solver's or the invariant's own words.
    time : float
        Time of the last good state, in the units of the rotor; NaN where a worker process died
        with it.
    state : tuple of float
        The state ``(x, y, vx, vy)`` at that time; NaN for a rotor system.
    """

    def __init__(
        self,
        message: str,
        *,
        time: float = math.nan,
        state: tuple[float, float, float, float] = (math.nan,) * 4,
    ):
        self.reason = message
        if math.isnan(time):
            super().__init__(message)
            return
        plain = message.replace("{", "{{").replace("}", "}}")
        if math.isnan(state[0]):
            super().__init__(plain + " (at t = {time:.17g})", time=time)
            return
        place = " (at t = {time:.17g}, state (x, y, vx, vy) = {state:.17g})"
        super().__init__(plain + place, time=time, state=tuple(state))

    @property
    def time(self) -> float:
        """Time of the last good state, in the units of the rotor."""
        time = self.fields.get("time", math.nan)
        assert isinstance(time, float)
        return time

    @property
    def state(self) -> tuple[float, float, float, float]:
        """The state at that time."""
        state = self.fields.get("state", (math.nan,) * 4)
        return cast("tuple[float, float, float, float]", state)


class InvariantError(SimulationError):
    """A result that contradicts the mechanics, raised instead of returned."""


class BudgetError(SimulationError):
    """A simulation that takes more steps than its caller allows."""


class ArchiveError(RotorError, OSError):
    """A file that cannot be read or written as an archive of this package."""


class InstallationError(RotorError, ImportError):
    """A broken installation: the message gives the fault and the command that repairs it."""


def _filled(template: str, fields: Mapping[str, object], words: Mapping[str, str]) -> str:
    """Return a template with its fields, as by ``str.format`` but for ``{name=}`` and units."""
    parts = []
    for text, field, spec, conversion in Formatter().parse(template):
        parts.append(text)
        if field is not None:
            name = field.removesuffix("=")
            parts.append("" if name == field else f"{words.get(name, name)} ")
            bound = name not in {"value", "time", "state"}
            parts.append(_written(fields[name], f"{spec or ''}", conversion, bound=bound))
    return "".join(parts)


def _written(value: object, spec: str, conversion: str | None, *, bound: bool) -> str:
    """Return a value as a message shows it; a bound has fewer digits, and as 0 no unit."""
    if isinstance(value, Amount):
        return "0" if bound and value == 0.0 else value.shown(DIGITS_OF_BOUNDS if bound else DIGITS)
    if isinstance(value, (list, tuple)):
        listed = [
            _written(each, spec, conversion, bound=bound) for each in value[:LONGEST_SEQUENCE]
        ]
        within = ", ".join([*listed, "..."] if len(value) > LONGEST_SEQUENCE else listed)
        return f"[{within}]" if isinstance(value, list) else f"({within})"
    return format(repr(value) if conversion == "r" else value, spec)


def _changed(value: object, changed: Callable[[int, float], float], place: int = 0) -> object:
    """Return a number, or the numbers of sequences, changed by their places; all else as it is."""
    if isinstance(value, (list, tuple)):
        return type(value)(_changed(each, changed, at) for at, each in enumerate(value))
    return changed(place, value) if isinstance(value, float) else value


def warn(words: str) -> None:
    """Give a warning at the line outside this package that led to it."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and _is_own(frame.f_globals.get("__name__")):
        frame, level = frame.f_back, level + 1
    warnings.warn(words, stacklevel=level)


def _is_own(module: object) -> bool:
    return isinstance(module, str) and module.partition(".")[0] == PACKAGE
