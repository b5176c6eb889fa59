"""The printed formulas give the printed numbers, and are wrong where it is said."""

import cmath
import math

import numpy as np
import pytest

from rotor_ida import InputError, synchronous_response
from rotor_ida.paper.printed import amplitudes_18, amplitudes_29, phase_23, phase_31, transfer_21


def residual(A, stiffness, omega, zeta):
    q = omega**2
    return A * A * ((stiffness - q) ** 2 + 4.0 * zeta**2 * q) - q * q


@pytest.mark.parametrize("omega", [0.5, 1.2, 1.7, 3.0])
def test_printed_amplitudes_solve_the_printed_equations(omega):
    for A in amplitudes_18(omega=omega, zeta=0.07):
        assert abs(residual(A, A**1.5, omega, 0.07)) < 1e-11 * omega**4
    for A in amplitudes_29(omega=omega, zeta=0.07, delta0=0.5):
        assert abs(residual(A, (A - 0.5) ** 1.5, omega, 0.07)) < 1e-11 * omega**4


def test_printed_18_has_one_response_where_there_are_three():
    np.testing.assert_allclose(amplitudes_18(omega=1.7, zeta=0.07), [2.52403], atol=5e-6)
    assert synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).sizes["branch"] == 3


def test_printed_29_misses_the_amplitude():
    np.testing.assert_allclose(
        amplitudes_29(omega=1.2, zeta=0.07, delta0=0.5), [2.13615], atol=5e-6
    )


def test_argument_of_h_is_minus_the_phase_lag():
    whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0)
    for A, lag in zip(whirls.amplitude.values.flat, whirls.phase_lag.values.flat, strict=True):
        H = transfer_21(A, omega=1.7, zeta=0.07)
        assert cmath.phase(H) == pytest.approx(-lag)
        assert abs(H) == pytest.approx(A)


def test_arctangent_is_right_below_resonance_only():
    whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0)
    small, _, large = zip(whirls.amplitude.values.flat, whirls.phase_lag.values.flat, strict=True)
    assert phase_23(large[0], omega=1.7, zeta=0.07) == pytest.approx(large[1])
    assert phase_23(small[0], omega=1.7, zeta=0.07) == pytest.approx(small[1] - math.pi)


def test_printed_31_misses_the_phase():
    whirl = synchronous_response(omega=1.2, zeta=0.07, delta0=0.5)
    A, lag = whirl.amplitude.item(), whirl.phase_lag.item()
    assert lag == pytest.approx(0.52809, abs=5e-6)
    assert phase_31(A, omega=1.2, zeta=0.07, delta0=0.5) == pytest.approx(2.98142, abs=5e-6)
    # where A = 1 the factor does not matter
    right = cmath.phase(complex(0.5**1.5 - 1.44, 0.168))
    assert phase_31(1.0, omega=1.2, zeta=0.07, delta0=0.5) == pytest.approx(right)


def test_bad_values_are_refused():
    with pytest.raises(InputError, match="omega must be positive"):
        amplitudes_18(omega=0.0, zeta=0.07)
    with pytest.raises(InputError, match="amplitude must be positive"):
        phase_31(0.0, omega=1.0, zeta=0.1, delta0=0.0)
