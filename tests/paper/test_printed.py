"""The printed formulas give the printed numbers, and are wrong where it is said."""

import cmath
import math

import numpy as np
import pytest

from rotor_ida import DimensionalRotor, InputError, synchronous_response
from rotor_ida.closed_forms import circular_period, planar_period
from rotor_ida.paper.printed import (
    amplitudes_18,
    amplitudes_29,
    general_solution,
    period,
    phase_23,
    phase_31,
    reference_frequency,
    transfer_21,
)

START = (10.0, 1.0, 0.5, -0.3)
LARGE = 9.487206945659
GIVEN = {"omega": 1.7, "zeta": 0.07, "amplitude": LARGE}
CHOICES = [
    {}, {"mended": True}, {"rates": "24"}, {"mended": True, "rates": "stiffness"},
]  # fmt: skip


def test_printed_frequency_changes_with_the_unit_of_length():
    """k in N/mm^1.5 is smaller by 1000**1.5: a frequency would not notice."""
    metres = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=0.0, eccentricity=1e-6,
                              clearance=0.0, speed=1.0)  # fmt: skip
    # mass times length over time squared: in kg mm/s^2 a force is 1000 times as many
    millimetres = DimensionalRotor(mass=4.0, contact_stiffness=1e9 * 1000 / 1000**1.5,
                                   damping=0.0, eccentricity=1e-3, clearance=0.0,
                                   speed=1.0)  # fmt: skip
    assert millimetres.reference_frequency == pytest.approx(metres.reference_frequency)
    ratio = reference_frequency(millimetres) / reference_frequency(metres)
    assert ratio == pytest.approx(1000**-0.25)


@pytest.mark.parametrize("amplitude", [0.5, 8.0])
def test_printed_period_is_right_on_a_circle_only(amplitude):
    assert period(amplitude) == pytest.approx(circular_period(amplitude), rel=1e-14)
    assert planar_period(amplitude) / period(amplitude) == pytest.approx(1.04746, abs=5e-6)


def residual(A, stiffness, omega, zeta):
    q = omega**2
    return A * A * ((stiffness - q) ** 2 + 4.0 * zeta**2 * q) - q * q


@pytest.mark.parametrize("omega", [0.5, 1.2, 1.7, 3.0])
def test_printed_amplitudes_solve_the_printed_equations(omega):
    for A in amplitudes_18(omega=omega, zeta=0.07):
        assert abs(residual(A, A**1.5, omega, 0.07)) < 1e-11 * omega**4
    for A in amplitudes_29(omega=omega, zeta=0.07, delta0=0.5):
        assert abs(residual(A, (A - 0.5) ** 1.5, omega, 0.07)) < 1e-11 * omega**4


def test_argument_of_h_is_minus_the_phase_lag():
    whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0)
    for A, lag in zip(whirls.amplitude.values.flat, whirls.phase_lag.values.flat, strict=True):
        H = transfer_21(A, omega=1.7, zeta=0.07)
        assert (abs(H), cmath.phase(H)) == pytest.approx((A, -lag))


def test_arctangent_is_right_below_resonance_only():
    whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0)
    small, _, large = zip(whirls.amplitude.values.flat, whirls.phase_lag.values.flat, strict=True)
    assert phase_23(large[0], omega=1.7, zeta=0.07) == pytest.approx(large[1])
    assert phase_23(small[0], omega=1.7, zeta=0.07) == pytest.approx(small[1] - math.pi)


def test_the_factor_of_31_does_not_matter_at_amplitude_1():
    right = cmath.phase(complex(0.5**1.5 - 1.44, 0.168))
    assert phase_31(1.0, omega=1.2, zeta=0.07, delta0=0.5) == pytest.approx(right)


def test_bad_values_are_refused():
    with pytest.raises(InputError, match="omega must be positive"):
        amplitudes_18(omega=0.0, zeta=0.07)
    with pytest.raises(InputError, match="amplitude must be positive"):
        phase_31(0.0, omega=1.0, zeta=0.1, delta0=0.0)


@pytest.mark.parametrize("choice", CHOICES)
def test_it_has_the_place_and_speed_of_the_start(choice):
    step = 1e-6
    before, at, after = general_solution([-step, 0.0, step], start=START, **GIVEN, **choice)
    assert at == pytest.approx(complex(10.0, 1.0))
    assert (after - before) / (2.0 * step) == pytest.approx(complex(0.5, -0.3), abs=1e-6)


def test_mended_signs_bring_it_to_the_whirl_and_printed_ones_do_not():
    whirl = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).isel(branch=2)
    time = 200.0
    lag = whirl.phase_lag.item()
    right = whirl.amplitude.item() * np.exp(1j * (1.7 * time - lag))
    mended, printed = (
        general_solution(time, start=START, mended=mended, **GIVEN) for mended in (True, False)
    )
    assert abs(mended - right) < 1e-4
    assert abs(printed - right) > 10.0


def test_exponents_under_eq_24_blow_up():
    late = general_solution(30.0, start=START, rates="24", **GIVEN)
    assert abs(late) > 1e10


def test_two_equal_exponents_are_refused():
    with pytest.raises(InputError, match="zeta must not make the two exponents one"):
        general_solution(0.0, start=START, omega=1.7, zeta=1.0, amplitude=2.0)
    with pytest.raises(InputError, match="rates must be one of '28', '24', 'stiffness'"):
        general_solution(0.0, start=START, rates="23", **GIVEN)
