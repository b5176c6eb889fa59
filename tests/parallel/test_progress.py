"""Progress: a function that is called, or a bar on standard error."""

import inspect

import pytest

import rotor_ida
from rotor_ida import InputError, sweep

POINTS = {"omega": [1.0, 1.2], "zeta": 0.5, "delta0": 2.0, "executor": "serial"}
VERBS = [
    name
    for name in rotor_ida.__all__
    if inspect.isfunction(verb := getattr(rotor_ida, name))
    and "progress" in inspect.signature(verb).parameters
]


def test_true_shows_a_bar_that_ends_full(capfd):
    found = sweep(**POINTS, progress=True)
    said = capfd.readouterr()
    assert not said.out
    assert said.err.startswith("sweep ")
    assert "2/2" in said.err
    assert found.identical(sweep(**POINTS, progress=False))
    assert not capfd.readouterr().err


@pytest.mark.parametrize("name", VERBS)
def test_every_function_with_progress_takes_true(name):
    verb = getattr(rotor_ida, name)
    given = inspect.signature(verb).parameters["progress"]
    assert given.annotation == "Progress | bool | None"
    while "shows_progress" not in verb.__code__.co_qualname and hasattr(verb, "__wrapped__"):
        verb = verb.__wrapped__
    assert verb.__code__.co_qualname == "shows_progress.<locals>.shown"


def test_anything_else_is_refused():
    with pytest.raises(InputError, match="progress must be a function, True or None, got 3"):
        sweep(**POINTS, progress=3)
