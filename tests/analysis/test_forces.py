import numpy as np
import pytest
from scipy.integrate import simpson

from rotor_ida import InputError, Rotor, contact_forces, simulate

REST = (0.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def run():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    return simulate(rotor, start=REST, duration=40.0, samples=40001)


def test_force_pushes_towards_the_centre_and_only_in_contact(run):
    forces = contact_forces(run)
    radius = np.hypot(run.x, run.y).values
    inwards = -(run.x * forces.force_x + run.y * forces.force_y).values
    np.testing.assert_allclose(inwards, radius * forces.force.values, atol=1e-12)
    assert (forces.force.values[radius <= 2.0] == 0.0).all()
    assert (forces.force.values[radius > 2.0] > 0.0).all()


def test_components_are_what_the_equation_of_motion_leaves_over(run):
    """f = omega**2 exp(i omega t) - 2 zeta z' - z'', with z'' by differences of the velocity."""
    forces = contact_forces(run)
    t = run.t.values
    for speed, part, unbalance in (("vx", "force_x", np.cos), ("vy", "force_y", np.sin)):
        v = run[speed].values
        left = np.gradient(v, t) - 4.0 * unbalance(2.0 * t) + 0.14 * v
        # differences over 0.002 err by its square times the third derivative
        np.testing.assert_allclose(forces[part].values[1:-1], left[1:-1], atol=2e-4)


def test_integral_of_the_force_is_the_impulse_of_each_contact(run):
    forces = contact_forces(run)
    whole = np.isfinite(run.impulse.values)
    assert whole.sum() >= 5
    for row in np.flatnonzero(whole):
        span = slice(run.entry_time.values[row], run.exit_time.values[row])
        part = forces.force.sel(t=span)
        # the ends between samples hold a force of (0.001 r')**1.5
        assert simpson(part, x=part.t) == pytest.approx(run.impulse.values[row], abs=1e-6)


def test_share_of_peaks_is_a_distribution_of_whole_contacts(run):
    forces = contact_forces(run)
    whole = np.isfinite(forces.peak_fraction.values)
    finished = np.isfinite(run.entry_time.values) & np.isfinite(run.exit_time.values)
    np.testing.assert_array_equal(whole, finished)
    share = np.sort(forces.peak_fraction.values[whole])
    np.testing.assert_allclose(share, np.arange(1, whole.sum() + 1) / whole.sum())
    largest = forces.peak_force.values[forces.peak_fraction.values == 1.0]
    assert largest == forces.peak_force.values[whole].max()
    assert forces.peak_force.max() >= forces.force.max() * (1.0 - 1e-12)


def test_another_dataset_is_refused(run):
    with pytest.raises(InputError, match="it lacks peak_force"):
        contact_forces(run.drop_vars("peak_force"))
