"""Closed-form eigenvalues against those of the linearised motion, found numerically."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotor_ida import DimensionalRotor, dimensional
from rotor_ida.closed_forms import eigenvalues, stability_determinant, synchronous_response


def stiffnesses(amplitude: float, delta0: float) -> tuple[float, float]:
    """Tangent and secant stiffness of the Hertz force, written out here."""
    depth = max(amplitude - delta0, 0.0)
    return 1.5 * depth**0.5, depth**1.5 / amplitude


def matrix(amplitude: float, omega: float, zeta: float, delta0: float) -> np.ndarray:
    """[[0, I], [-K, -C]] of the motion in the rotating frame."""
    tangent, secant = stiffnesses(amplitude, delta0)
    q = omega**2
    K = np.array([[tangent - q, -2 * zeta * omega], [2 * zeta * omega, secant - q]])
    C = np.array([[2 * zeta, -2 * omega], [2 * omega, 2 * zeta]])
    return np.block([[np.zeros((2, 2)), np.eye(2)], [-K, -C]])


rotors = {
    "amplitude": st.floats(0.05, 30.0),
    "omega": st.floats(0.05, 10.0),
    "zeta": st.one_of(st.just(0.0), st.floats(1e-3, 5.0)),
    "delta0": st.one_of(st.just(0.0), st.floats(0.01, 5.0)),
}


@settings(max_examples=200, deadline=None)
@given(**rotors)
def test_eigenvalues_are_those_of_the_matrix(amplitude, omega, zeta, delta0):
    found = eigenvalues(amplitude, omega=omega, zeta=zeta, delta0=delta0)
    A = matrix(amplitude, omega, zeta, delta0)
    expected = np.linalg.eigvals(A)
    # a double eigenvalue of a rounded matrix moves by the square root of the rounding
    spread = 1e-6 * np.linalg.norm(A)
    for value in expected:
        assert np.abs(found - value).min() < spread
    # the characteristic polynomial has no such trouble
    np.testing.assert_allclose(
        np.poly(found).real, np.poly(A).real, rtol=0.0, atol=1e-11 * np.linalg.norm(A) ** 4
    )


@settings(max_examples=100, deadline=None)
@given(**rotors)
def test_determinant_is_that_of_the_stiffness(amplitude, omega, zeta, delta0):
    K = -matrix(amplitude, omega, zeta, delta0)[2:, :2]
    found = float(stability_determinant(amplitude, omega=omega, zeta=zeta, delta0=delta0))
    assert found == pytest.approx(np.linalg.det(K), abs=1e-13 * np.linalg.norm(K) ** 2)


def test_growth_rates_on_a_grid_are_the_largest_real_parts():
    omegas, zetas, clearances = np.linspace(0.2, 3.0, 15), [0.02, 0.07, 0.4, 2.0], [0.0, 0.5, 1.5]
    whirls = synchronous_response(omega=omegas, zeta=zetas, delta0=clearances)
    checked = 0
    for omega in omegas:
        for zeta in zetas:
            for delta0 in clearances:
                point = whirls.sel(omega=omega, zeta=zeta, delta0=delta0)
                for k in np.nonzero(point.in_contact.values)[0]:
                    A = matrix(float(point.amplitude[k]), omega, zeta, delta0)
                    expected = np.linalg.eigvals(A).real.max()
                    assert float(point.growth_rate[k]) == pytest.approx(expected, abs=1e-10)
                    checked += 1
    assert checked > 150


def test_no_whirl_flutters_with_a_positive_determinant():
    rng = np.random.default_rng(1)
    whirls = synchronous_response(
        omega=rng.uniform(0.01, 8.0, 40),
        zeta=10.0 ** rng.uniform(-3, 1, 20),
        delta0=[0.0, 0.4, 2.0],
    )
    contacting = whirls.where(whirls.in_contact == 1)
    assert float(contacting.growth_rate.where(whirls.stability == 0).max()) < 0.0
    assert float(contacting.growth_rate.where(whirls.stability == 1).min()) > 0.0


def test_contact_free_whirl_has_a_zero_eigenvalue():
    # the centre stays where it is: a zero eigenvalue in the fixed frame is +-i omega here
    found = eigenvalues(0.5, omega=1.7, zeta=0.3, delta0=1.0)
    np.testing.assert_allclose(
        np.sort_complex(found), np.sort_complex([1.7j, -1.7j, -0.6 + 1.7j, -0.6 - 1.7j]), atol=1e-15
    )


def test_arrays_give_what_single_numbers_give():
    amplitudes = np.array([[0.4, 1.5], [6.19, 9.48]])
    found = eigenvalues(amplitudes, omega=1.7, zeta=0.07, delta0=0.5)
    assert found.shape == (2, 2, 4)
    for place, amplitude in np.ndenumerate(amplitudes):
        alone = eigenvalues(amplitude, omega=1.7, zeta=0.07, delta0=0.5)
        np.testing.assert_allclose(found[place], alone, rtol=1e-15)


def test_growth_rate_of_a_machine_is_in_seconds():
    machine = DimensionalRotor(
        mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6,
        speed=600.0,
    )  # fmt: skip
    whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0)
    found = dimensional(whirls, machine)
    assert found.growth_rate.attrs["units"] == "s-1"
    expected = whirls.growth_rate * machine.reference_frequency
    np.testing.assert_allclose(found.growth_rate.values, expected.values, rtol=1e-15)
