"""TOML files, read entry by entry: quantities with units, and errors that name their place."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

from rotor_ida.checks import did_you_mean, listed, shown
from rotor_ida.errors import InputError, MissingFileError
from rotor_ida.model.data_sheet import in_si
from rotor_ida.results.files import check_path
from rotor_ida.texts import brief

# Files by hand have some twenty lines; matrices in them may be larger.
MOST_BYTES = 1_000_000
# The parser takes a time with the square of the parts of a key.
_KEY = r"(?:[\w-]+|\"[^\"\n]*\"|'[^'\n]*')"
_LONG_KEY = re.compile(rf"(?<![\w-]){_KEY}(?:[ \t]*+\.[ \t]*+{_KEY}){{20}}")


def read_toml(name: str, path: str | os.PathLike[str]) -> dict[str, object]:
    """Return what a small TOML file, given as the argument `name`, contains."""
    place = check_path(name, path)
    if place.exists() and not place.is_file() and not place.is_dir():
        raise InputError(f"{name} must be a TOML file, got the device or pipe {shown(place)}")
    try:
        with place.open("rb") as file:
            text = file.read(MOST_BYTES + 1)
        if len(text) > MOST_BYTES:
            raise InputError(f"{name} must be a small TOML file, got {shown(place)}")
        decoded = text.decode("utf-8-sig")  # some editors begin with a mark
        if long := _LONG_KEY.search(decoded):
            raise InputError(
                f"{name} must have keys of at most 20 parts, got {shown(long[0])} in {shown(place)}"
            )
        return tomllib.loads(decoded)
    except InputError:
        raise
    except OSError as error:
        kind = MissingFileError if isinstance(error, FileNotFoundError) else InputError
        raise kind(f"cannot read {shown(place)}: {error.strerror or error}") from error
    except RecursionError as error:
        raise InputError(f"{name} must be nested less deep, got {shown(place)}") from error
    except ValueError as error:  # also of a whole number of thousands of digits
        first, *_ = str(error).splitlines()
        raise InputError(f"{name} must be a TOML file, got {shown(place)}: {first}") from error


@dataclass(frozen=True, slots=True)
class Table:
    """A table of a file: its place there, its entries, and whether they are in SI units."""

    place: str
    entries: Mapping[str, object]
    si: bool

    def name(self, key: str) -> str:
        """Return the name of an entry in the whole file."""
        return f"{self.place}.{brief(key)}" if self.place else brief(key)

    def check(self, allowed: tuple[str, ...], needed: tuple[str, ...] = ()) -> None:
        """Refuse an unknown key, or a missing one."""
        for key in self.entries:
            if key not in allowed:
                where = self.place or "a system file"
                hint = did_you_mean(key, allowed)
                raise InputError(
                    f"{where} must have entries named {listed(allowed, 'or')}, got {shown(key)}"
                    f"{hint}"
                )
        missing = [self.name(key) for key in needed if key not in self.entries]
        if missing:
            raise InputError(f"{listed(missing)} must be given")

    def number(self, key: str, *units: str) -> float:
        """Return an entry in SI units."""
        return self.one(self.name(key), self.entries[key], *units)

    def one(self, name: str, value: object, *units: str) -> float:
        """Return a value in SI units."""
        return in_si(name, value, *(units if self.si else ("1",)))

    def numbers(self, units: Mapping[str, str]) -> dict[str, float]:
        """Return the entries that are there, in SI units."""
        return {key: self.number(key, unit) for key, unit in units.items() if key in self.entries}

    def pair(self, key: str, *units: str) -> tuple[float, float]:
        """Return an entry of two numbers in SI units."""
        return self.two(self.name(key), self.entries[key], *units)

    def two(self, name: str, value: object, unit: str, other: str = "") -> tuple[float, float]:
        """Return two numbers in SI units, the second by another unit if one is named."""
        if not isinstance(value, list) or len(value) != 2:
            raise InputError(f"{name} must be two numbers, got {shown(value)}")
        return self.one(name, value[0], unit), self.one(name, value[1], other or unit)

    def one_or_pair(self, key: str, unit: str) -> float | tuple[float, float]:
        """Return an entry of one number, or of two along x and y, in SI units."""
        both = isinstance(self.entries[key], list)
        return self.pair(key, unit) if both else self.number(key, unit)

    def table(self, key: str) -> Table:
        """Return a table within it; an empty one if it is not there."""
        value = self.entries.get(key, {})
        if not isinstance(value, Mapping):
            raise InputError(f"{self.name(key)} must be a table, got {shown(value)}")
        return Table(self.name(key), value, self.si)

    def tables(self, key: str) -> list[Table]:
        """Return the tables of a list."""
        value = self.entries.get(key, [])
        if not isinstance(value, list) or not all(isinstance(each, Mapping) for each in value):
            raise InputError(f"{self.name(key)} must be tables [[{key}]], got {shown(value)}")
        return [Table(f"{key}[{place}]", each, self.si) for place, each in enumerate(value)]


@contextmanager
def naming(place: str) -> Iterator[None]:
    """Name the table in the message of an error."""
    try:
        yield
    except InputError as error:
        raise error.within(f"{place}: ") from error
