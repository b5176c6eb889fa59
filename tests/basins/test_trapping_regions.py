"""Trapping regions: V falls on all of them, nothing leaves, everything converges."""

import numpy as np
import pytest

from rotor_ida import Rotor, folds
from rotor_ida.basins.trapping_regions import trapping_regions
from rotor_ida.model.equations import rotated, rotating_field
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

ROTORS = [
    Rotor(omega=1.7, zeta=0.07, delta0=0.0),
    Rotor(omega=1.7, zeta=0.07, delta0=0.5),
    Rotor(omega=1.7, zeta=0.07, delta0=1.0),
    Rotor(omega=3.0, zeta=0.07, delta0=0.5),
    Rotor(omega=1.0, zeta=0.6, delta0=0.3),
    Rotor(omega=0.3, zeta=1.5, delta0=0.0),
]


def states_of(each, scale, count, seed=0):
    """Return random states at ``V = scale**2``."""
    directions = np.random.default_rng(seed).normal(size=(count, 4))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return each.centre + scale * np.linalg.solve(np.linalg.cholesky(each.form).T, directions.T).T


@pytest.mark.parametrize("rotor", ROTORS)
def test_v_falls_on_the_boundary_and_inside(rotor):
    regions = trapping_regions(rotor)
    assert regions
    for each in regions:
        for scale in (1.0, 0.7, 0.3, 1e-3):
            for state in states_of(each, scale, 400):
                rate = rotating_field(state, rotor)
                assert (state - each.centre) @ each.form @ rate < 0.0


@pytest.mark.parametrize("rotor", ROTORS[:4])
def test_no_orbit_leaves_and_all_converge(rotor):
    """CVODE from the boundary: inside at every output, and V dies away like exp(-2 zeta t)."""
    times = np.linspace(0.0, 20.0 / rotor.zeta, 2001)
    for each in trapping_regions(rotor):
        for state in states_of(each, 0.999, 3, seed=1):
            orbit = run(rotor, tuple(state.tolist()), times[-1], times, Options())
            states = rotated(orbit.states, -rotor.omega * times)
            assert each.holds(states).all()
            assert np.linalg.norm(states[-1] - each.centre) < 1e-6 * each.amplitude


def test_the_set_lies_in_contact_and_is_no_dwarf():
    """At zeta 0.07 it reaches a tenth of the amplitude: 2 zeta, the scale on which it can."""
    (each,) = trapping_regions(Rotor(omega=3.0, zeta=0.3, delta0=0.5))
    widths = np.sqrt(np.diag(np.linalg.inv(each.form)))
    assert each.amplitude - widths[:2].max() > 0.5 * 0.9
    small, large = trapping_regions(ROTORS[0])
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


@pytest.mark.parametrize("beyond", [1e-12, 1e-9, 1e-6, 1e-4])
@pytest.mark.parametrize("zeta", [1e-4, 0.07])
def test_next_to_a_fold_there_is_a_small_set_or_none(zeta, beyond):
    """Where decay is lost in rounding no region is claimed; warnings are errors here."""
    for fold in folds(zeta=zeta, delta0=0.3)["fold_omega"].values.ravel():
        for side in (-1.0, 1.0):
            rotor = Rotor(omega=float(fold) * (1.0 + side * beyond), zeta=zeta, delta0=0.3)
            for each in trapping_regions(rotor):
                assert np.isfinite(each.row["factor"]).all()
                assert each.exists or not each.holds(each.centre)
