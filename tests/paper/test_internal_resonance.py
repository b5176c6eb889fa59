"""Bouncing cycles of an overhung rotor begin where two of its whirls turn by whole numbers."""

import numpy as np
import pytest
from scipy.linalg import eigh

from rotor_ida import continue_cycle, decode_flags
from tests.scenarios import scenario


@pytest.fixture(scope="module")
def resonance():
    return scenario("internal_resonance")


def test_the_shaft_is_as_flexible_as_a_cantilever(resonance):
    """A force at distance L bends a cantilever by L**3/3 there, with bending stiffness 1."""
    stiffness = resonance.overhung().stiffness[:4, :4]
    bent = np.linalg.inv(stiffness)
    np.testing.assert_allclose(bent[[0, 2], [0, 2]], [1.0 / 3.0, 8.0 / 3.0], rtol=1e-12)


def test_whirls_of_the_rotor_at_rest_are_its_natural_frequencies(resonance):
    system = resonance.overhung()
    (slowest, *_) = np.sqrt(eigh(system.stiffness, system.mass, eigvals_only=True))
    backward, forward = resonance.first_whirls(system, 1e-9)
    np.testing.assert_allclose([-backward, forward], slowest, rtol=1e-4)


@pytest.mark.parametrize(("turns", "speed"), [((2, 1), 1.7919), ((3, 2), 3.0040)])
def test_whole_turns_are_met_at_the_speeds_on_the_page(resonance, turns, speed):
    system = resonance.overhung()
    found, period = resonance.condition(system, turns)
    assert found == pytest.approx(speed, abs=5e-5)
    assert resonance.turns_of(system, found, period) == pytest.approx(turns, abs=1e-9)


def test_an_exact_cycle_obeys_the_condition_near_its_onset_and_less_and_less_beyond(resonance):
    """Whirls turn by nearly whole numbers where contacts are slight; the branch leaves them."""
    system, turns = resonance.overhung(), (3, 2)
    cycle = resonance.cycle_at(system, resonance.FAMILIES[turns])
    assert decode_flags(cycle.response).item() == "bouncing"
    assert cycle.residual.item() < 1e-11
    branch = continue_cycle(
        system, start=cycle, limits=(3.0, 3.12), direction="forward",
        points=8,
    )  # fmt: skip
    off = np.abs([
        np.subtract(resonance.turns_of(system, speed, period), turns)
        for speed, period in zip(branch.speed.values, branch.period.values, strict=True)
    ])  # fmt: skip
    assert off[0].max() < 0.02
    assert (np.diff(off.max(axis=1)) > 0.0).all()
    assert (np.diff(branch.largest_force.values[:, 0]) > 0.0).all()
