"""Free periods against quadrature of the energy, with 30 digits."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from rotor_ida import Rotor, simulate
from rotor_ida.closed_forms import (
    amplitude_from_speed,
    backbone,
    centre_speed,
    circular_period,
    free_periods,
    planar_period,
)
from rotor_ida.errors import InputError


def test_planar_period_without_clearance_has_the_constant_of_the_design():
    assert planar_period(1.0) == pytest.approx(6.581363388638263, rel=2e-16)
    assert planar_period(16.0) == pytest.approx(6.581363388638263 / 2.0, rel=2e-16)


def test_circular_period_is_that_of_the_backbone():
    for amplitude, delta0 in [(1.5, 0.0), (1.5, 0.5), (10.0, 2.0)]:
        speed = float(backbone(amplitude, delta0)[0])
        assert circular_period(amplitude, delta0) == pytest.approx(2 * math.pi / speed, rel=1e-15)


@pytest.mark.parametrize("period", [circular_period, planar_period, centre_speed])
@pytest.mark.parametrize(
    ("amplitude", "delta0", "message"),
    [
        (0.5, 0.5, r"amplitude must be above delta0 = 0\.5 for the rotor to touch, got 0\.5"),
        (math.nan, 0.0, "amplitude must be a finite real number, got nan"),
        (1.0, -0.5, r"delta0 must be zero or positive, got -0\.5"),
    ],
)
def test_no_period_without_contact(period, amplitude, delta0, message):
    with pytest.raises(InputError, match=message):
        period(amplitude, delta0)


def test_a_rotor_at_rest_reaches_nothing():
    with pytest.raises(InputError, match="speed must not be zero"):
        amplitude_from_speed(0.0)


def quadrature_of_machine(amplitude, delta0, kappa, exponent):
    """Four times the integral of dr/speed(r) from the axis to the turning point."""
    with mpmath.workdps(25):
        A, n, k = mpmath.mpf(amplitude), mpmath.mpf(exponent), mpmath.mpf(kappa)
        depth = A - mpmath.mpf(delta0)

        def slowness(p):
            # r = A - A p**2 removes the singularity at the turning point
            lost = A * p**2 / depth
            left = -mpmath.expm1((n + 1) * mpmath.log1p(-lost)) if lost < 1 else 1
            potentials = k * A**2 * p**2 * (2 - p**2) / 2 + depth ** (n + 1) * left / (n + 1)
            return 2 * A * p / mpmath.sqrt(2 * potentials)

        ring = mpmath.sqrt(depth / A)
        return 4 * mpmath.quad(slowness, [0, ring / 2, ring, (1 + ring) / 2, 1])


LAWS = [(kappa, exponent) for kappa in (0.0, 1e-9, 0.3, 40.0) for exponent in (1.0, 1.5)]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("depth", "delta0"), [(1e-3, 0.25), (2.0, 1.0), (64.0, 40.0)])
def test_planar_period_of_a_machine_is_the_integral_over_the_energy(law, depth, delta0):
    kappa, exponent = law
    found = planar_period(delta0 + depth, delta0, shaft_stiffness=kappa, contact_exponent=exponent)
    expected = quadrature_of_machine(delta0 + depth, delta0, kappa, exponent)
    assert abs(found / expected - 1) < 1e-13


def test_periods_of_harmonic_oscillators():
    """A linear contact without clearance is one, whatever the amplitude; the shaft adds to it."""
    for kappa in (0.0, 0.44, 3.0):
        for law in (planar_period, circular_period):
            found = law(2.7, shaft_stiffness=kappa, contact_exponent=1.0)
            assert found == pytest.approx(2.0 * math.pi / math.sqrt(1.0 + kappa), rel=1e-15)


@pytest.mark.parametrize("law", LAWS)
def test_speed_and_amplitude_of_a_machine_are_inverse_to_each_other(law):
    kappa, exponent = law
    given = {"shaft_stiffness": kappa, "contact_exponent": exponent}
    for amplitude, delta0 in [(0.3, 0.0), (1.5, 0.5), (100.0, 2.0), (2.001, 2.0)]:
        speed = centre_speed(amplitude, delta0, **given)
        assert amplitude_from_speed(speed, delta0, **given) == pytest.approx(amplitude, rel=2e-15)


def test_a_shaft_may_hold_the_rotor_off_the_ring():
    assert amplitude_from_speed(0.5, 2.0, shaft_stiffness=0.25) == 1.0
    assert amplitude_from_speed(-1.0, 2.0, shaft_stiffness=0.25) == 2.0
    assert amplitude_from_speed(1.01, 2.0, shaft_stiffness=0.25) > 2.0


@pytest.mark.parametrize(("kappa", "exponent"), [(0.0, 1.5), (0.4, 1.0), (0.4, 1.5)])
def test_a_simulated_machine_is_back_after_one_period(kappa, exponent):
    law = {"shaft_stiffness": kappa, "contact_exponent": exponent}
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=0.5, **law)
    period = planar_period(2.0, 0.5, **law)
    end = simulate(rotor, start=(2.0, 0, 0, 0), duration=period, samples=2, method="taylor")
    np.testing.assert_allclose([end.x[-1], end.vx[-1]], [2.0, 0.0], atol=1e-9)
    speed = 2.0 * math.pi / circular_period(2.0, 0.5, **law) * 2.0
    round_ = simulate(rotor, start=(2.0, 0, 0, speed), duration=7.0, samples=8, method="taylor")
    np.testing.assert_allclose(np.hypot(round_.x, round_.y), 2.0, atol=1e-9)
    crossing = simulate(
        rotor, start=(0, 0, centre_speed(2.0, 0.5, **law), 0), duration=period, method="taylor"
    )
    assert crossing.peak_indentation.values[0] == pytest.approx(1.5, abs=1e-9)


def test_a_table_holds_the_scalar_laws_and_nothing_where_the_ring_is_not_reached():
    law = {"shaft_stiffness": 0.4, "contact_exponent": 1.0}
    table = free_periods(amplitude=[0.25, 0.5, 2.0], delta0=[0.0, 0.5], **law)
    for name, period in (("planar_period", planar_period), ("circular_period", circular_period)):
        assert table[name].isnull().values.tolist() == [[False] * 3, [True, True, False]]
        assert table[name].values[1, 2] == period(2.0, 0.5, **law)
    assert (table.shaft_stiffness.item(), table.contact_exponent.item()) == (0.4, 1.0)
    with pytest.raises(InputError, match="amplitude must be zero or positive"):
        free_periods(amplitude=[-1.0], delta0=0.0)
