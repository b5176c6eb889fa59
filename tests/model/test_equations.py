"""The first-order system on rotating axes, and its Jacobian."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rotor_ida import Rotor
from rotor_ida.model.equations import energy, rotated, rotating_field, rotating_jacobian

numbers = st.floats(-5.0, 5.0)
states = st.tuples(numbers, numbers, numbers, numbers)
rotors = st.builds(
    Rotor, omega=st.floats(0.0, 5.0), zeta=st.floats(0.0, 2.0), delta0=st.floats(0.0, 3.0)
)


def numerical_jacobian(function, state, step=1e-6):
    columns = []
    for number in range(4):
        offset = np.zeros(4)
        offset[number] = step
        columns.append((function(state + offset) - function(state - offset)) / (2 * step))
    return np.array(columns).T


@given(rotors, states)
def test_the_field_is_the_equation_on_axes_that_turn(rotor, state):
    """``Z' = W - i omega Z`` and ``W' = omega**2 - (2 zeta + i omega) W - N Z/|Z|``."""
    z, w = complex(*state[:2]), complex(*state[2:])
    push = max(abs(z) - rotor.delta0, 0.0) ** 1.5 * (z / abs(z) if z else 0.0)
    of_z = w - 1j * rotor.omega * z
    of_w = rotor.omega**2 - (2.0 * rotor.zeta + 1j * rotor.omega) * w - push
    expected = [of_z.real, of_z.imag, of_w.real, of_w.imag]
    assert rotating_field(state, rotor) == pytest.approx(expected, abs=1e-11)


@given(rotors, states)
def test_the_jacobian_is_the_derivative_of_the_field(rotor, state):
    state = np.array(state)
    radius = np.hypot(state[0], state[1])
    if abs(radius - rotor.delta0) < 1e-2 or radius < 1e-2:
        return
    rotating = numerical_jacobian(lambda s: rotating_field(s, rotor), state)
    assert rotating_jacobian(state, rotor) == pytest.approx(rotating, abs=1e-5)


@given(rotors)
def test_all_is_defined_at_the_centre_and_on_the_ring(rotor):
    for state in ((0.0, 0.0, 1.0, 0.0), (rotor.delta0, 0.0, 0.0, 0.0)):
        assert np.isfinite(rotating_field(state, rotor)).all()
        assert np.isfinite(rotating_jacobian(state, rotor)).all()
        assert np.isfinite(energy(state, rotor.delta0))


@given(states, st.floats(-10.0, 10.0))
def test_turning_keeps_energy_and_turns_back(state, angle):
    there = rotated(state, angle)
    assert energy(there, 0.7) == pytest.approx(float(energy(state, 0.7)), rel=1e-12, abs=1e-12)
    assert rotated(there, -angle) == pytest.approx(np.array(state), abs=1e-13)
