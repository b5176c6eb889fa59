"""Types of option: the help, how the words are read, and the group in the help of a command."""

from __future__ import annotations

from collections.abc import Sequence

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from rotor_ida.cli import parsing

# Groups of options in the help of a command; options without one are in the command's group.
ROTOR = Group("Rotor", sort_key=1)
SPEED = Group("Change of the speed", sort_key=2)
STUDY, OPTIONS = Group("Study", sort_key=3), Group("Options", sort_key=3)
READING = Group("Measured files", sort_key=4)
SOLVER = Group("Solver", sort_key=5)
OUTPUT = Group("Output", sort_key=6)
IN_ROTOR, IN_CHANGE, IN_READING, IN_SOLVER, IN_OUTPUT = (
    Parameter(group=each) for each in (ROTOR, SPEED, READING, SOLVER, OUTPUT)
)


def number_option(text: str) -> Parameter:
    """Return an option for a number without a unit."""
    return Parameter(help=text, converter=parsing.converter(parsing.number))


def quantity_option(text: str, *allowed: str, name: str | Sequence[str] | None = None) -> Parameter:
    """Return an option for a number, which may have one of the allowed units."""
    return Parameter(
        name=name,
        help=text,
        metavar="VALUE",
        converter=parsing.converter(parsing.quantity, *allowed),
    )


def numbers_option(text: str, *allowed: str, name: str | None = None) -> Parameter:
    """Return an option for numbers or a range, which may have one of the allowed units."""
    reading = parsing.converter(parsing.numbers, *allowed)
    return Parameter(name=name, help=text, converter=reading, consume_multiple=True, negative=())


def several_numbers_option(text: str, words: str, *allowed: str) -> Parameter:
    """Return an option for a fixed number of numbers, each of which may have its unit."""
    reading = parsing.converter(parsing.several_numbers, *allowed)
    return Parameter(help=text, metavar=words, converter=reading, negative=())


def count_option(text: str, lowest: int, highest: int) -> Parameter:
    """Return an option for a whole number between two limits."""
    reading = parsing.converter(parsing.whole_number)
    return Parameter(help=text, converter=reading, validator=Number(gte=lowest, lte=highest))


def path_option(text: str, *, name: str | Sequence[str] | None = None) -> Parameter:
    """Return an option for a path."""
    return Parameter(name=name, help=text, converter=parsing.converter(parsing.path))


def flag_option(text: str, *, name: str | None = None) -> Parameter:
    """Return an option that is given or not."""
    return Parameter(name=name, help=text, negative=(), show_default=False)


def words_option(text: str, words: str) -> Parameter:
    """Return an option for one or more words, such as `NAME=WORD`."""
    reading = parsing.converter(lambda _name, given: list(given))
    return Parameter(
        help=text, metavar=words, converter=reading, consume_multiple=True, negative=()
    )
