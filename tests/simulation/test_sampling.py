"""How many samples a run has by default: enough for each revolution, the shaft and the contact."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, run_up, simulate
from rotor_ida.simulation.runs import FEWEST, MOST_CHOSEN, sample_times

REST = (0.0, 0.0, 0.0, 0.0)


def steps_in(run, period):
    """The fewest samples in a period; the samples are equally spaced."""
    steps = np.diff(run.t.values)
    np.testing.assert_allclose(steps, steps[0], rtol=1e-9)
    return period / steps[0]


@pytest.mark.parametrize("omega", [0.8, 3.0, 20.0])
def test_each_revolution_has_32_samples(omega):
    run = simulate(Rotor(omega=omega, zeta=0.1, delta0=1.0), start=REST, duration=700.0)
    assert steps_in(run, 2.0 * math.pi / omega) >= 32.0 - 1e-9
    assert run.t[-1] == 700.0


@pytest.mark.parametrize("omega", [0.0, 0.05])
def test_where_the_rotor_turns_slowly_each_period_of_shaft_and_contact_is_resolved(omega):
    given = {"omega": omega, "zeta": 0.1, "delta0": 1.0}
    run = simulate(Rotor(**given, shaft_stiffness=4.0), start=(0.1, 0, 0, 0), duration=300.0)
    assert steps_in(run, 2.0 * math.pi / 2.0) >= 32.0 - 1e-9
    run = simulate(Rotor(**given, shaft_stiffness=0.01), start=(0.1, 0, 0, 0), duration=3000.0)
    assert steps_in(run, 2.0 * math.pi / math.sqrt(1.01)) >= 8.0 - 1e-9


def test_a_short_run_is_smooth():
    run = simulate(Rotor(omega=1.0, zeta=0.1, delta0=1.0), start=REST, duration=5.0)
    assert run.sizes["t"] == FEWEST


@pytest.mark.parametrize("change", [
    {"to": 6.0, "rate": 0.02}, {"speeds": [(0, 2), (150, 6), (300, 1)]},
    {"torque": (20.0, 1.0), "inertia": 1000.0, "duration": 300.0},
])  # fmt: skip
def test_the_largest_speed_of_a_run_up_counts(change):
    run = run_up(Rotor(omega=0.5, zeta=0.1, delta0=50.0), start=REST, method="taylor", **change)
    fastest = float(run.speed.max())
    assert fastest > 2.0
    assert 32.0 - 1e-6 <= steps_in(run, 2.0 * math.pi / fastest) < 33.0


def test_numbers_and_times_that_are_given_are_kept():
    rotor, times = Rotor(omega=9.0, zeta=0.1, delta0=1.0), [1.0, 2.0, 90.0]
    assert simulate(rotor, start=REST, duration=100.0, samples=5).sizes["t"] == 5
    run = simulate(rotor, start=REST, duration=100.0, samples=times)
    np.testing.assert_array_equal(run.t, times)


def test_no_more_are_chosen_than_memory_allows():
    rotor = Rotor(omega=1000.0, zeta=0.1, delta0=1e6)
    revolution = 2.0 * math.pi / 1000.0
    for revolutions in (MOST_CHOSEN / 32 - 1, MOST_CHOSEN / 32 + 1, 1e300):
        count = sample_times(None, revolutions * revolution, rotor, rotor.omega).size
        assert count == pytest.approx(min(32 * revolutions, MOST_CHOSEN), abs=2)
