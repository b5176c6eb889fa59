"""The kinds of response, each told from a motion made by hand or simulated at a known place."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, folds, synchronous_response
from rotor_ida.simulation.options import Options
from rotor_ida.sweeps.response import UNRESOLVED, classify, features_of
from rotor_ida.sweeps.steady_state import follow_to_steady_state

REST = (0.0, 0.0, 0.0, 0.0)
OMEGA = 2.0
LONG = 1000.0
TIMES = np.linspace(0.0, 8.0 * np.pi, 1601)


def states_from(position):
    velocity = np.gradient(position, TIMES, edge_order=2)
    return np.stack([position.real, position.imag, velocity.real, velocity.imag], axis=-1)


def window(position, rotor, touches=0, *, in_contact):
    return features_of(
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


def test_a_whirl_of_constant_radius_in_contact_is_synchronous_if_it_is_a_solution():
    exact = synchronous_response(omega=OMEGA, zeta=0.07, delta0=0.5).squeeze()
    amplitude, lag = exact.amplitude.item(), exact.phase_lag.item()
    rotor = Rotor(omega=OMEGA, zeta=0.07, delta0=0.5)
    whirl = amplitude * np.exp(1j * (OMEGA * TIMES - lag))
    assert classify(None, window(whirl, rotor, in_contact=True), time=LONG) == "synchronous"
    ghost = window(1.001 * whirl, rotor, in_contact=True)
    assert classify(ghost, ghost, time=LONG) == "unresolved"


def test_nothing_that_may_still_be_a_transient_is_called_lasting():
    radius = 1.5 + 0.1 * np.sin(1.3 * TIMES)
    swing = window(radius * np.exp(1j * OMEGA * TIMES), ROTOR, in_contact=True)
    assert classify(swing, swing, time=9.0 / 0.07) == "unresolved"
    creeping = (1.5 + 1e-3 * TIMES) * np.exp(1j * OMEGA * TIMES)
    creep = window(creeping, ROTOR, in_contact=True)
    assert classify(creep, creep, time=LONG) == "unresolved"


def test_a_rotor_that_does_not_turn_comes_to_rest_within_its_clearance():
    at_rest = follow_to_steady_state(
        Rotor(omega=0.0, zeta=0.3, delta0=1.0), (1.5, 0, 0, 0.3), Options()
    )
    assert at_rest.response == "contact_free"
    creeping = follow_to_steady_state(
        Rotor(omega=0.0, zeta=1.0, delta0=1.0), (1.0 + 1e-8, 0, 0, 0), Options()
    )
    assert creeping.response == "unresolved"


def test_the_ghost_of_a_fold_is_no_response():
    """Just above the upper fold only the small whirl exists; the rotor creeps where it was."""
    fold = folds(zeta=0.07, delta0=0.0).isel(zeta=0, delta0=0, fold=1)
    omega, amplitude = fold.fold_omega.item() + 1e-7, fold.fold_amplitude.item()
    lag = math.asin(2.0 * 0.07 * amplitude / omega)
    z = amplitude * np.exp(-1j * (math.pi - lag))
    v = 1j * omega * z
    start = (z.real, z.imag, v.real, v.imag)
    settled = follow_to_steady_state(
        Rotor(omega=omega, zeta=0.07, delta0=0.0), start, Options(), doublings=1
    )
    assert settled.response == "unresolved"


def test_a_radius_that_keeps_its_swing_needs_two_looks():
    radius = 1.5 + 0.1 * np.sin(1.3 * TIMES)
    steady_swing = window(radius * np.exp(1j * OMEGA * TIMES), ROTOR, in_contact=True)
    assert classify(None, steady_swing, time=LONG) == "unresolved"
    assert classify(steady_swing, steady_swing, time=LONG) == "full_contact"
    dying = window(
        (1.5 + 0.05 * np.sin(1.3 * TIMES)) * np.exp(1j * OMEGA * TIMES), ROTOR, in_contact=True
    )
    assert classify(steady_swing, dying, time=LONG) == "unresolved"


def test_bounces_that_fade_are_not_called_bouncing():
    strong = window(1.5 * np.exp(1j * OMEGA * TIMES), ROTOR, touches=20, in_contact=False)
    weak = window(1.2 * np.exp(1j * OMEGA * TIMES), ROTOR, touches=20, in_contact=False)
    assert classify(strong, strong, time=LONG) == "bouncing"
    assert classify(strong, weak, time=LONG) == "unresolved"


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
    settled = follow_to_steady_state(Rotor(omega=omega, zeta=0.07, delta0=delta0), REST, Options())
    assert settled.response == kind


def test_the_bouncing_response_of_design_keeps_between_its_radii():
    """omega 2, delta0 2: |z| between about 1.9 and 4.1."""
    settled = follow_to_steady_state(Rotor(omega=2.0, zeta=0.07, delta0=2.0), REST, Options())
    assert settled.window.radius_min == pytest.approx(1.9, abs=0.05)
    assert settled.window.radius_max == pytest.approx(4.1, abs=0.05)


def test_without_damping_or_forcing_nothing_settles():
    free = follow_to_steady_state(
        Rotor(omega=0.0, zeta=0.0, delta0=0.0), (1.0, 0, 0, 0.3), Options(), doublings=0
    )
    assert free.response == "unresolved"


def test_touches_that_get_slighter_for_ever_are_not_called_bouncing():
    """The indentation falls from 1.8e-4 at t = 300 only to 1.3e-4 at 1000."""
    start = (1.369616873214543, -2.302132862361297, -4.590264760638053, -4.834723644714709)
    settled = follow_to_steady_state(Rotor(omega=1.25, zeta=0.07, delta0=2.0), start, Options())
    assert settled.window.touches > 0
    assert 0.0 < settled.window.radius_max - 2.0 < 2e-4
    assert settled.response == UNRESOLVED
