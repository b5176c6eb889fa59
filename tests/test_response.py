"""The kinds of response, each told from a motion made by hand or simulated at a known place."""

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.response import classify, window_of
from rotor_ida.settling import settle
from rotor_ida.simulator.options import Options

REST = (0.0, 0.0, 0.0, 0.0)
OMEGA = 2.0
TIMES = np.linspace(0.0, 8.0 * np.pi, 1601)


def states_from(position):
    velocity = np.gradient(position, TIMES, edge_order=2)
    return np.stack([position.real, position.imag, velocity.real, velocity.imag], axis=-1)


def window(position, rotor, touches=0, *, in_contact):
    return window_of(
        rotor,
        TIMES,
        states_from(position),
        np.zeros(touches),
        ends_in_contact=in_contact,
        steady=1e-9,
    )


ROTOR = Rotor(omega=OMEGA, zeta=0.07, delta0=1.0)


def test_amplitude_and_phase_lag_are_those_of_the_whirl_whatever_its_centre():
    whirl = 0.7 * np.exp(1j * (OMEGA * TIMES - 0.4)) + (0.1 + 0.05j)
    seen = window(whirl, ROTOR, in_contact=False)
    assert seen.amplitude == pytest.approx(0.7, rel=1e-13)
    assert seen.phase_lag == pytest.approx(0.4, abs=1e-13)
    assert seen.radius_max == pytest.approx(0.7 + abs(0.1 + 0.05j), abs=1e-5)
    assert seen.radius_min == pytest.approx(0.7 - abs(0.1 + 0.05j), abs=1e-5)


def test_a_whirl_of_constant_radius_in_contact_is_synchronous():
    assert classify(None, window(1.5 * np.exp(1j * OMEGA * TIMES), ROTOR, in_contact=True)) == (
        "synchronous"
    )


def test_a_radius_that_keeps_its_swing_needs_two_looks():
    radius = 1.5 + 0.1 * np.sin(1.3 * TIMES)
    steady_swing = window(radius * np.exp(1j * OMEGA * TIMES), ROTOR, in_contact=True)
    assert classify(None, steady_swing) == "unresolved"
    assert classify(steady_swing, steady_swing) == "full_contact"
    dying = window(
        (1.5 + 0.05 * np.sin(1.3 * TIMES)) * np.exp(1j * OMEGA * TIMES), ROTOR, in_contact=True
    )
    assert classify(steady_swing, dying) == "unresolved"


def test_bounces_that_fade_are_not_called_bouncing():
    strong = window(1.5 * np.exp(1j * OMEGA * TIMES), ROTOR, touches=20, in_contact=False)
    weak = window(1.2 * np.exp(1j * OMEGA * TIMES), ROTOR, touches=20, in_contact=False)
    assert classify(strong, strong) == "bouncing"
    assert classify(strong, weak) == "unresolved"


@pytest.mark.parametrize(
    ("omega", "delta0", "kind"),
    [
        (1.7, 0.0, "synchronous"),
        (1.2, 0.5, "synchronous"),
        (0.9, 2.0, "contact_free"),
        (2.0, 2.0, "bouncing"),
        (3.0, 0.5, "full_contact"),
    ],
)
def test_known_responses_from_rest(omega, delta0, kind):
    settled = settle(Rotor(omega=omega, zeta=0.07, delta0=delta0), REST, Options())
    assert settled.response == kind


def test_the_bouncing_response_of_design_keeps_between_its_radii():
    """omega 2, delta0 2: |z| between about 1.9 and 4.1."""
    settled = settle(Rotor(omega=2.0, zeta=0.07, delta0=2.0), REST, Options())
    assert settled.window.radius_min == pytest.approx(1.9, abs=0.05)
    assert settled.window.radius_max == pytest.approx(4.1, abs=0.05)


def test_without_damping_or_forcing_nothing_settles():
    free = settle(Rotor(omega=0.0, zeta=0.0, delta0=0.0), (1.0, 0, 0, 0.3), Options(), doublings=0)
    assert free.response == "unresolved"
