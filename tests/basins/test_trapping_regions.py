"""Trapping regions: V falls on all of them, nothing leaves, everything converges."""

import numpy as np
import pytest

from rotor_ida import Rotor, folds
from rotor_ida.basins.trapping_regions import trapping_regions
from rotor_ida.closed_forms import eigenvalues
from rotor_ida.model.equations import rotated
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run
from tests.basins.lanes import MACHINES, PAPERS, RUBBING, field, slip_of

ROTORS = [*PAPERS, *MACHINES, *RUBBING.values()]


def states_of(each, scale, count, seed=0):
    """Return random states at ``V = scale**2``."""
    directions = np.random.default_rng(seed).normal(size=(count, 4))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return each.centre + scale * np.linalg.solve(np.linalg.cholesky(each.form).T, directions.T).T


@pytest.mark.parametrize("rotor", ROTORS, ids=str)
def test_v_falls_on_the_boundary_and_inside(rotor):
    """Along the field of the model itself; a disc slides forwards there: no other force acts."""
    regions = trapping_regions(rotor)
    assert regions or rotor == RUBBING["that bounces"]
    for each in regions:
        assert each.exists
        for scale in (1.0, 0.7, 0.3, 1e-3):
            states = states_of(each, scale, 150)
            if rotor.friction:
                assert (np.hypot(*states.T[:2]) > rotor.delta0).all()
                assert (slip_of(states.T, rotor) > 0.0).all()
            for state in states:
                assert (state - each.centre) @ each.form @ field(state, rotor) < 0.0


NAMES = ("beside dry whip", "shaft, linear contact, contact damping")


@pytest.mark.parametrize("rotor", [*PAPERS[:4], *(RUBBING[name] for name in NAMES)], ids=str)
def test_no_orbit_leaves_and_all_converge(rotor):
    """CVODE from the boundary: inside at every output, no event, and V dies away.

    Friction feeds the whirl that damping slows, so that V falls more slowly.
    """
    duration, part = (600.0, 1e-3) if rotor.friction else (20.0 / rotor.zeta, 1e-6)
    times = np.linspace(0.0, duration, 2001)
    for each in trapping_regions(rotor):
        for state in states_of(each, 0.999, 3, seed=1):
            orbit = run(rotor, tuple(state.tolist()), times[-1], times, Options())
            states = rotated(orbit.states, -rotor.omega * times)
            assert not orbit.event_times.size
            assert each.holds(states).all()
            assert np.linalg.norm(states[-1] - each.centre) < part * np.linalg.norm(
                state - each.centre
            )


def test_the_set_lies_in_contact_and_is_no_dwarf():
    """At zeta 0.07 it reaches a tenth of the amplitude: 2 zeta, the scale on which it can."""
    (each,) = trapping_regions(Rotor(omega=3.0, zeta=0.3, delta0=0.5))
    widths = np.sqrt(np.diag(np.linalg.inv(each.form)))
    assert each.amplitude - widths[:2].max() > 0.5 * 0.9
    small, large = trapping_regions(PAPERS[0])
    for whirl in (small, large):
        reach = np.sqrt(np.diag(np.linalg.inv(whirl.form)))[:2].min()
        assert reach > 0.05 * whirl.amplitude


def test_regions_shrink_towards_a_fold():
    fold = float(folds(zeta=0.07, delta0=0.0)["fold_omega"].min())
    sizes = []
    for beyond in (0.1, 0.01, 0.001):
        each = trapping_regions(Rotor(omega=fold + beyond, zeta=0.07, delta0=0.0))[0]
        sizes.append(np.linalg.det(each.form) ** -0.125 if each.exists else 0.0)
    assert sizes[0] > sizes[1] > sizes[2]


def test_a_rotor_without_stable_whirl_has_no_set():
    assert trapping_regions(Rotor(omega=2.0, zeta=0.07, delta0=2.0)) == []


@pytest.mark.parametrize("beyond", [1e-12, 1e-6])
@pytest.mark.parametrize("zeta", [1e-4, 0.07])
def test_next_to_a_fold_there_is_a_small_set_or_none(zeta, beyond):
    """Where decay is lost in rounding no region is claimed; warnings are errors here."""
    for fold in folds(zeta=zeta, delta0=0.3)["fold_omega"].values.ravel():
        for side in (-1.0, 1.0):
            rotor = Rotor(omega=float(fold) * (1.0 + side * beyond), zeta=zeta, delta0=0.3)
            for each in trapping_regions(rotor):
                assert np.isfinite(each.row["factor"]).all()
                assert each.exists or not each.holds(each.centre)


def test_a_whirl_that_contact_damping_drives_has_no_trapping_region():
    """The small whirl at omega 1.7 is stable at c = 0.5, and past a Hopf point at c = 1."""
    for drag, growth in ((0.5, -1.0), (1.0, 1.0)):
        given = {"omega": 1.7, "zeta": 0.07, "delta0": 0.5, "contact_damping": drag}
        amplitudes = [each.amplitude for each in trapping_regions(Rotor(**given))]
        assert np.sign(eigenvalues(1.1960944557, **given).real.max()) == growth
        assert any(abs(each - 1.1960944557) < 1e-9 for each in amplitudes) == (growth < 0.0)


def test_a_region_ends_where_the_disc_might_roll():
    """A slow disc of no radius would hold more if it could not: the region takes up the slip."""
    small = RUBBING["slow, with a disc of no radius"]
    large = Rotor(**small.given | {"disc_radius": 100.0})
    (bound,), (free,) = trapping_regions(small), trapping_regions(large)
    assert bound.amplitude == free.amplitude
    volumes = [np.linalg.det(each.form) ** -0.5 for each in (bound, free)]
    assert volumes[0] < 0.5 * volumes[1]
    # some state of what holds the large disc would slide backwards with the small one
    random = np.random.default_rng(3).normal(size=(4, 4000))
    random /= np.linalg.norm(random, axis=0)
    states = free.centre[:, None] + np.linalg.solve(np.linalg.cholesky(free.form).T, random)
    assert (slip_of(states, small) < 0.0).any()
