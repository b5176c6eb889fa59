"""The first-order system: one equation in two frames, and its Jacobians."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rotor_ida import Rotor
from rotor_ida.model.equations import (
    angular_momentum,
    energy,
    field,
    jacobian,
    power,
    rotated,
    rotating_field,
    rotating_jacobian,
)

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


@given(rotors, states, st.floats(0.0, 10.0))
def test_the_two_frames_hold_one_equation(rotor, state, time):
    """d/dt of the turned state is the turned rate less omega x the turned state."""
    angle = rotor.omega * time
    seen = rotated(state, -angle)
    x, y, vx, vy = seen
    carried = rotor.omega * np.array([y, -x, vy, -vx])
    expected = rotated(field(time, state, rotor), -angle) + carried
    assert rotating_field(seen, rotor) == pytest.approx(expected, abs=1e-11)


@given(rotors, states)
def test_jacobians_are_the_derivatives_of_the_fields(rotor, state):
    state = np.array(state)
    radius = np.hypot(state[0], state[1])
    if abs(radius - rotor.delta0) < 1e-2 or radius < 1e-2:
        return
    fixed = numerical_jacobian(lambda s: field(0.3, s, rotor), state)
    rotating = numerical_jacobian(lambda s: rotating_field(s, rotor), state)
    assert jacobian(state, rotor) == pytest.approx(fixed, abs=1e-5)
    assert rotating_jacobian(state, rotor) == pytest.approx(rotating, abs=1e-5)


@given(rotors)
def test_all_is_defined_at_the_centre_and_on_the_ring(rotor):
    for state in ((0.0, 0.0, 1.0, 0.0), (rotor.delta0, 0.0, 0.0, 0.0)):
        assert np.isfinite(field(0.0, state, rotor)).all()
        assert np.isfinite(rotating_jacobian(state, rotor)).all()
        assert np.isfinite(energy(state, rotor.delta0))


@given(states, st.floats(-10.0, 10.0))
def test_turning_keeps_energy_and_angular_momentum(state, angle):
    there = rotated(state, angle)
    assert energy(there, 0.7) == pytest.approx(float(energy(state, 0.7)), rel=1e-12, abs=1e-12)
    assert angular_momentum(there) == pytest.approx(float(angular_momentum(state)), abs=1e-12)
    assert rotated(there, -angle) == pytest.approx(np.array(state), abs=1e-13)


MACHINE = Rotor(omega=1.3, zeta=0.2, delta0=0.5, shaft_stiffness=0.4, contact_exponent=1.0,
                contact_damping=0.7, load=0.3)  # fmt: skip


@given(states, st.floats(0.0, 10.0), st.sampled_from([1.0, 1.5]), st.booleans())
def test_power_is_the_rate_of_change_of_energy_of_a_machine(state, time, exponent, damped):
    """Also while the contact is loose: the spring's energy is lost there."""
    machine = replace(MACHINE, contact_exponent=exponent, contact_damping=0.7 if damped else 0.0)
    held = {"shaft_stiffness": 0.4, "contact_exponent": exponent, "load": 0.3}
    rate, step = field(time, state, machine), 1e-6
    ahead, behind = (
        energy(np.array(state) + way * rate, machine.delta0, **held) for way in (step, -step)
    )
    assert power(time, state, machine) == pytest.approx((ahead - behind) / (2 * step), abs=2e-4)


def test_the_power_of_a_damped_contact_takes_what_the_force_adds():
    """dE/dt = -c d**n d'**2 while not loose, and d**n d' while loose, of a free radial motion."""
    machine = Rotor(omega=0.0, zeta=0.0, delta0=1.0, contact_damping=0.5)
    for speed, expected in ((1.0, -0.5), (-1.0, -0.5), (-2.0, -2.0), (-4.0, -4.0)):
        assert power(0.0, (2.0, 0.0, speed, 3.0), machine) == pytest.approx(expected, rel=1e-15)
