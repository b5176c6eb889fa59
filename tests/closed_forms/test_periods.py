"""Periods over amplitude and clearance: hardening, and flight that takes ever longer."""

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, simulate
from rotor_ida.closed_forms import circular_period, free_periods, planar_period


@pytest.fixture(scope="module")
def periods():
    return free_periods(amplitude=np.linspace(0.1, 8.0, 80), delta0=[0.0, 0.5])


def test_the_higher_the_amplitude_the_shorter_the_period(periods):
    for name in ("circular_period", "planar_period"):
        for delta0 in (0.0, 0.5):
            values = periods[name].sel(delta0=delta0).dropna("amplitude").values
            assert (np.diff(values) < 0.0).all()


def test_line_takes_longer_than_circle_by_a_constant_factor_without_clearance(periods):
    ratio = (periods.planar_period / periods.circular_period).sel(delta0=0.0)
    np.testing.assert_allclose(ratio, 1.04746, atol=5e-6)


def test_there_is_no_period_where_the_ring_is_not_reached(periods):
    inside = periods.amplitude <= 0.5
    assert bool(periods.planar_period.sel(delta0=0.5)[inside].isnull().all())
    assert bool(periods.planar_period.sel(delta0=0.5)[~inside].notnull().all())


def test_table_holds_the_scalar_laws(periods):
    at = periods.sel(amplitude=8.0, delta0=0.5)
    assert at.circular_period.item() == circular_period(8.0, 0.5)
    assert at.planar_period.item() == planar_period(8.0, 0.5)


@pytest.mark.parametrize("delta0", [0.0, 0.5])
def test_simulated_rotor_is_back_after_one_period(delta0):
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=delta0)
    end = simulate(rotor, start=(2.0, 0, 0, 0), duration=planar_period(2.0, delta0), samples=2)
    np.testing.assert_allclose([end.x[-1], end.vx[-1]], [2.0, 0.0], atol=1e-7)


def test_bad_values_are_refused():
    with pytest.raises(InputError, match="amplitude must be zero or positive"):
        free_periods(amplitude=[-1.0], delta0=0.0)
