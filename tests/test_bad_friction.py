"""What is wrong with friction gets one line from every function that takes its parameters."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

import rotor_ida
from rotor_ida import InputError
from rotor_ida.closed_forms import clearance_curve, cusp, jumps, peaks, response_curve

FUNCTIONS: dict[str, Callable[..., object]] = {
    "sweep": lambda **given: rotor_ida.sweep(omega=1.2, zeta=0.07, **given),
    "synchronous_response": lambda **given: rotor_ida.synchronous_response(
        omega=1.2, zeta=0.07, **given
    ),
    "folds": lambda **given: rotor_ida.folds(zeta=0.07, **given),
    "jumps": lambda **given: jumps(zeta=0.07, **given),
    "hopf_points": lambda **given: rotor_ida.hopf_points(zeta=0.07, **given),
    "cusp": cusp,
    "peaks": lambda **given: peaks(zeta=0.07, **given),
    "response_curve": lambda **given: response_curve(zeta=0.07, limits=(0.1, 2.0), **given),
}
MISTAKES = [
    ({"friction": -0.1}, "friction must be zero or positive, got -0.1"),
    ({"friction": math.nan}, "friction must be a finite real number, got nan"),
    ({"friction": math.inf}, "friction must be a finite real number, got inf"),
    ({"friction": "much"}, "friction must be a finite real number, got 'much'"),
    ({"friction": True}, "friction must be a finite real number, got True"),
    ({"delta0": 0.0}, "friction must be 0 without clearance"),
]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_each_mistake_gets_one_line(name: str):
    right: dict[str, Any] = {"delta0": 0.5, "friction": 0.1}
    if name == "sweep":
        right["disc_radius"] = 10.0
    for given, message in MISTAKES:
        with pytest.raises(InputError) as caught:
            FUNCTIONS[name](**right | given)
        assert message in str(caught.value), given
        assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "disc_radius must be given with friction, got None with friction 0.1"),
        ({"disc_radius": -1.0}, "disc_radius must be zero or positive, got -1.0"),
        ({"disc_radius": math.nan}, "disc_radius must be a finite real number, got nan"),
        ({"disc_radius": [10.0, -1.0]}, "disc_radius must be zero or positive, got -1.0"),
    ],
)
def test_a_sweep_needs_a_disc_for_its_friction(given: dict[str, object], message: str):
    with pytest.raises(InputError) as caught:
        rotor_ida.sweep(omega=1.2, zeta=0.07, delta0=0.5, friction=[0.0, 0.1], **given)
    assert str(caught.value).startswith(message)


def test_a_clearance_curve_with_friction_leaves_no_clearance_out():
    with pytest.raises(InputError) as caught:
        clearance_curve(omega=1.2, zeta=0.07, limits=(0.0, 1.0), friction=0.1)
    assert len(str(caught.value).splitlines()) == 1
