"""Closing an orbit: known cycles, convergence, phases, and orbits that are none."""

import numpy as np
import pytest

from rotor_ida import Rotor, SimulationError, synchronous_response
from rotor_ida.cycles.orbit import followed
from rotor_ida.cycles.shooting import checked_cycle, close_orbit, once_round
from rotor_ida.simulation.flow import DiscFlow
from tests.cycles.known import BOUNCING, FULL, signature

KNOWN = [BOUNCING, FULL]


def closed(known, period=None, state=None):
    start = np.array(known.state if state is None else state)
    return close_orbit(DiscFlow(known.rotor), start, period or known.period)


@pytest.mark.parametrize("known", KNOWN)
def test_any_phase_gives_the_same_cycle(known):
    """A shift along the cycle changes where it begins, and nothing else."""
    first = closed(known)
    for part in (0.11, 0.37, 0.5, 0.83):
        there = followed(DiscFlow(known.rotor), first.start, part * first.duration).end
        again = closed(known, state=there)
        np.testing.assert_allclose(signature(again), signature(first), rtol=1e-12)
        assert again.contacts == first.contacts
        if again.contacts:
            assert again.impulse == pytest.approx(first.impulse, rel=1e-11)


@pytest.mark.parametrize("known", KNOWN)
def test_convergence_is_quadratic(known):
    """What an iterate misses the cycle by is squared from step to step, until rounding."""
    orbits = []

    def watched(*arguments):
        orbits.append(followed(*arguments))
        return orbits[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rotor_ida.cycles.shooting.followed", watched)
        closed(known, 1.01 * known.period)
    missed = [np.linalg.norm(orbit.end - orbit.start) for orbit in orbits]
    middle = [place for place, miss in enumerate(missed) if 1e-7 < miss < 1e-2]
    assert middle
    for place in middle:
        assert missed[place + 1] < 30.0 * missed[place] ** 2


def test_one_contact_a_period_and_its_impulse_balances_the_other_forces():
    """Over a period of the fixed frame's motion forces and change of momentum balance.

    On the rotating axes, averaged over a period: the mean of W' = 0, so the mean of the contact
    force is omega^2 - (2 zeta + i omega) times that of W. The size of impulse is no less.
    """
    cycle = closed(BOUNCING)
    assert cycle.contact_counts == [1]
    rotor, count = BOUNCING.rotor, 4096
    states = np.array([
        followed(DiscFlow(rotor), cycle.start, cycle.duration * (k + 0.5) / count).end
        for k in range(0, count, 16)
    ])  # fmt: skip
    z, w = states[:, 0] + 1j * states[:, 1], states[:, 2] + 1j * states[:, 3]
    force = np.maximum(np.abs(z) - rotor.delta0, 0.0) ** 1.5
    assert force.mean() * cycle.duration == pytest.approx(cycle.impulse, rel=1e-5)
    mean = (force * z / np.abs(z)).mean()
    expected = rotor.omega**2 - (2.0 * rotor.zeta + 1j * rotor.omega) * w.mean()
    assert mean == pytest.approx(expected, abs=1e-4)
    assert force.max() == pytest.approx(cycle.largest_force, rel=1e-3)


def test_once_round_is_not_halved():
    """A doubled cycle, whose halves are alike but not equal, keeps its period."""
    cycle = closed(BOUNCING)
    assert once_round(cycle) is cycle


def test_a_synchronous_whirl_is_no_cycle():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
    whirl = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).isel(branch=0)
    z = whirl.amplitude.item() * np.exp(-1j * whirl.phase_lag.item())
    state = np.array([z.real, z.imag, (1.7j * z).real, (1.7j * z).imag])
    with pytest.raises(SimulationError, match="a whirl of constant radius: period"):
        close_orbit(DiscFlow(rotor), state + 1e-6 * np.eye(4)[0], 2.0)


def test_rest_on_a_whirl_has_no_direction_and_is_refused_without_a_warning():
    """Without damping the whirl of amplitude 1 inside the clearance is an exact equilibrium."""
    rotor = Rotor(omega=2.0, zeta=0.0, delta0=1.5)
    with pytest.raises(SimulationError, match="a whirl of constant radius"):
        close_orbit(DiscFlow(rotor), np.array([-1.0, 0.0, 0.0, -2.0]), 2.0)


def test_a_motion_inside_the_clearance_closes_but_is_no_cycle():
    """It turns about a centre that stays where it is left, once in a revolution."""
    rotor, omega = Rotor(omega=2.0, zeta=0.07, delta0=2.0), 2.0
    whirl = -omega / (omega - 2j * rotor.zeta)
    z, w = 0.3 + whirl, 1j * omega * whirl
    state = np.array([z.real, z.imag, w.real, w.imag])
    shot = followed(DiscFlow(rotor), state, 2.0 * np.pi / omega)
    with pytest.raises(SimulationError, match="a whirl inside the clearance"):
        checked_cycle(shot)


def test_what_does_not_close_is_refused_with_the_place():
    cycle = closed(BOUNCING)
    with pytest.raises(SimulationError, match="the orbit misses its start by") as refused:
        checked_cycle(followed(DiscFlow(BOUNCING.rotor), cycle.start, 0.7 * cycle.duration))
    assert refused.value.state == tuple(cycle.start)
    assert "omega 2, zeta 0.07, delta0 2" in str(refused.value)
