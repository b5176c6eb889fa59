"""What the source of a function tells is what Python knows of it, and all of it is an option."""

from __future__ import annotations

import inspect
import typing
from typing import Any, get_args, get_origin

import pytest

import rotor_ida
from rotor_ida.cli.command import NO_OPTIONS, Command
from rotor_ida.cli.program import COMMANDS
from rotor_ida.cli.verbs import NEEDED, arguments_of, short_text

ASKING = [each for group in COMMANDS.values() for each in group if isinstance(each, Command)]
VERBS = [each for each in ASKING if each.asks is None]


def literals(kind: Any) -> list[str]:
    """Return the words of a type, in order."""
    if get_origin(kind) is typing.Literal:
        return [word for word in get_args(kind) if isinstance(word, str)]
    return [word for each in get_args(kind) for word in literals(each)]


@pytest.mark.parametrize("command", VERBS, ids=[each.verb for each in VERBS])
def test_names_defaults_and_choices_are_those_of_the_function(command: Command):
    function = getattr(rotor_ida, command.verb)
    known = inspect.signature(function).parameters.values()
    of_function = {each.name: each for each in known if each.kind is each.KEYWORD_ONLY}
    told = {name: each for name, each in arguments_of(command.verb).items() if "**" not in name}
    assert list(told) == list(of_function)
    kinds = typing.get_type_hints(inspect.unwrap(function), vars(inspect.getmodule(function)))
    for name, each in told.items():
        default = of_function[name].default
        if isinstance(default, str | float | int | None):
            assert each.default == default, name
        assert (each.default is NEEDED) == (default is inspect.Parameter.empty), name
        if name not in {"start", "starts"} and not each.kind.startswith("str"):
            assert list(each.choices) == literals(kinds[name]), name


@pytest.mark.parametrize("command", ASKING, ids=[each.verb for each in ASKING])
def test_each_keyword_is_an_option_with_a_text(command: Command):
    options = inspect.signature(command.function()).parameters
    of_verb = {*command.keywords} - NO_OPTIONS - {*command.without}
    for name in {*command.only} or of_verb:
        if name not in {"speed", "starts"}:
            assert name in options
            texts = [each.help for each in options[name].annotation.__metadata__ if each.help]
            assert texts
            assert not set("`*[") & set("".join(texts).split(" or START:STOP")[0]), texts


def test_commands_that_read_measured_files_have_all_keywords_of_the_function():
    reading = [each for each in ASKING if each.reads]
    assert [each.verb for each in reading] == ["explore", "plot", "fit"]
    for command in reading:
        options = inspect.signature(command.function()).parameters
        assert {*arguments_of("read_signals")} <= {*options}


def test_a_text_that_refers_to_another_function_is_that_one():
    assert arguments_of("sweep")["flight"].text == arguments_of("simulate")["flight"].text
    said = "Time [s] of a `RotorSystem`, as in `rotor_ida.sweep`. Long. Default: ``2``."
    assert short_text(said) == "Time of a rotor system, as in sweep. Default: 2."
