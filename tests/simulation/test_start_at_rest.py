"""Where no start is given, the rotor starts at rest: without a load on the axis."""

import inspect

import numpy as np
import pytest

from rotor_ida import (
    Rotor,
    bifurcation_curve,
    continue_cycle,
    limit_cycle,
    lyapunov_exponent,
    poincare_section,
    run_up,
    simulate,
)
from rotor_ida.closed_forms import flight, ramp_flight

BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
AT_REST = (0.0, 0.0, 0.0, 0.0)
FUNCTIONS = {
    "simulate": lambda **given: simulate(BOUNCING, duration=5.0, **given),
    "run_up": lambda **given: run_up(BOUNCING, to=2.5, rate=0.1, **given),
    "poincare_section": lambda **given: poincare_section(BOUNCING, revolutions=5, **given),
    "lyapunov_exponent": lambda **given: lyapunov_exponent(
        BOUNCING, transient=20.0, duration=1000.0, **given
    ),
    "limit_cycle": lambda **given: limit_cycle(BOUNCING, **given),
    "continue_cycle": lambda **given: continue_cycle(
        BOUNCING, limits=(1.98, 2.02), points=3, **given
    ),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_motion_starts_at_rest_by_default(name):
    compute = FUNCTIONS[name]
    by_default, told = compute(), compute(start=AT_REST)
    assert by_default.drop_attrs().identical(told.drop_attrs())
    np.testing.assert_array_equal(by_default.attrs["start"], told.attrs["start"])


def test_a_bifurcation_is_sought_from_rest_by_default():
    assert inspect.signature(bifurcation_curve).parameters["start"].default is None


def test_closed_forms_start_at_rest_by_default():
    times = np.linspace(0.0, 3.0, 7)
    np.testing.assert_array_equal(
        flight(times, rotor=BOUNCING), flight(times, rotor=BOUNCING, start=AT_REST)
    )
    np.testing.assert_array_equal(
        ramp_flight(times, rotor=BOUNCING, rate=0.1),
        ramp_flight(times, rotor=BOUNCING, start=AT_REST, rate=0.1),
    )
