import numpy as np
import pytest
from scipy.integrate import simpson

from rotor_ida import (
    InputError,
    Rotor,
    contact_forces,
    contact_summary,
    simulate,
)
from rotor_ida.plot import plot_forces
from rotor_ida.results.checked_run import rotor_of
from tests.rotors import MOTIONS

REST = (0.0, 0.0, 0.0, 0.0)
PLAIN = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
# All ways to move: rolling beside sliding both ways, loose, under a load, on a shaft.
RUBBING = ("dry whip", "small disc, that chatters", "slow, under a load", "everything")


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
    rubbing = simulate(MOTIONS["dry whip"].rotor, start=REST, duration=1.0)
    with pytest.raises(InputError, match="it lacks mode, normal_force"):
        contact_forces(rubbing.drop_vars(["mode", "normal_force"]))


MACHINE = Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.25, contact_exponent=1.0,
                contact_damping=2.0, load=0.3)  # fmt: skip


@pytest.fixture(scope="module")
def loose():
    return simulate(MACHINE, start=REST, duration=40.0, samples=40001, method="taylor")


def test_force_of_a_machine_is_what_its_equation_of_motion_leaves_over(loose):
    """N z/|z| = omega**2 exp(i omega t) - i gamma - 2 zeta z' - kappa z - z''."""
    forces = contact_forces(loose)
    t = loose.t.values
    z, v = loose.x.values + 1j * loose.y.values, loose.vx.values + 1j * loose.vy.values
    left = np.gradient(v, t) - 4.0 * np.exp(2j * t) + 0.3j + 0.14 * v + 0.25 * z
    found = forces.force_x.values + 1j * forces.force_y.values
    away = np.abs(t[:, None] - loose.event_time.values).min(axis=1) > 1.5e-3
    # differences over 0.002 err by its square times the third derivative, but not across a corner
    assert np.abs(found - left)[1:-1][away[1:-1]].max() < 1e-4
    np.testing.assert_allclose(np.abs(found), forces.force.values, rtol=1e-12, atol=1e-15)


def test_the_ring_never_pulls_and_lets_go_from_release_to_press(loose):
    forces, kinds, times = contact_forces(loose), loose.event_kind.values, loose.event_time.values
    assert {1, -1, -4} <= set(kinds.tolist())
    assert forces.force.values.min() == 0.0
    radius = np.hypot(loose.x, loose.y).values
    for first in np.flatnonzero(kinds == -4):
        inside = (loose.t.values > times[first]) & (loose.t.values < times[first + 1])
        assert (radius[inside] > 2.0).all()
        assert (forces.force.values[inside] == 0.0).all()


def test_impulse_and_loss_of_damped_contacts_are_integrals_of_the_force(loose):
    """The loss is that of N - d**n, the part that damping adds, with the loose part."""
    forces = contact_forces(loose)
    radius = np.hypot(loose.x, loose.y)
    rate = (loose.x * loose.vx + loose.y * loose.vy) / radius
    taken = (forces.force - np.maximum(radius - 2.0, 0.0)) * rate
    whole = np.flatnonzero(np.isfinite(loose.impulse.values))
    assert whole.size >= 5
    for row in whole:
        span = slice(loose.entry_time.values[row], loose.exit_time.values[row])
        for integrand, exact in ((forces.force, loose.impulse), (taken, loose.contact_loss)):
            part = integrand.sel(t=span)
            # the ends between samples hold a force of 0.001 at most
            assert simpson(part, x=part.t) == pytest.approx(exact.values[row], abs=1e-5)


def test_peaks_of_damped_contacts_are_the_largest_forces(loose):
    forces = contact_forces(loose)
    assert forces.peak_force.max() >= forces.force.max() * (1.0 - 1e-12)
    assert float(forces.peak_force.max()) == pytest.approx(float(forces.force.max()), rel=1e-5)


def test_a_summary_tells_the_loss_of_all_contacts_and_of_a_revolution(loose):
    summary = contact_summary(loose)
    total = float(loose.contact_loss.sum())
    assert summary.total_contact_loss.item() == pytest.approx(total, rel=1e-14)
    turns = 2.0 * 40.0 / (2.0 * np.pi)
    assert summary.contact_loss_per_revolution.item() == pytest.approx(total / turns, rel=1e-14)
    untouched = simulate(MACHINE, start=REST, duration=0.1)
    assert contact_summary(untouched).total_contact_loss == 0.0
    assert "total_contact_loss" not in contact_summary(simulate(PLAIN, start=REST, duration=1.0))


def test_forces_of_friction_are_drawn_apart():
    motion = MOTIONS["dry whip"]
    rotor, start, duration = motion.rotor, motion.start, motion.duration
    ax = plot_forces(contact_forces(simulate(rotor, start=start, duration=duration)))
    assert [line.get_label() for line in ax.lines][:2] == ["normal force", "force along the stator"]
    assert ax.get_ylim()[0] < 0.0  # it begins a little too fast, and slides backwards


@pytest.fixture(scope="module", params=RUBBING)
def rub(request):
    motion = MOTIONS[request.param]
    rotor, start, duration = motion.rotor, motion.start, motion.duration
    return simulate(rotor, start=start, duration=duration, samples=40_001, method="taylor")


def test_with_friction_the_balance_of_momentum_leaves_the_whole_force(rub):
    """z'' by differences of the velocity, where no event lies between the samples."""
    forces, rotor = contact_forces(rub), rotor_of(rub)
    t, step = rub.t.values, float(rub.t[1])
    z, velocity = rub.x.values + 1j * rub.y.values, rub.vx.values + 1j * rub.vy.values
    left = rotor.omega**2 * np.exp(1j * rotor.omega * t) - 1j * rotor.load
    left -= 2.0 * rotor.zeta * velocity + rotor.shaft_stiffness * z
    force = forces.force_x.values + 1j * forces.force_y.values
    off = (velocity[2:] - velocity[:-2]) / (2.0 * step) - (left + force)[1:-1]
    passed = np.searchsorted(rub.event_time.values, t)
    smooth = passed[2:] == passed[:-2]
    # differences over 0.001 err by its square times the third derivative, and by the kinks of
    # entries; the force along the ring is 0.4 to 3, and jumps by up to 1.3 at events
    assert np.abs(off[smooth]).max() < 1e-4
    assert smooth.sum() > 39_000


def test_what_slides_takes_the_heat_of_each_contact(rub):
    """The power of the force along the ring, ``T v_s``: 0 while the disc rolls."""
    forces = contact_forces(rub)
    power = forces.tangential_force.values * rub.slip_speed.values
    assert (power >= 0.0).all()
    assert np.trapezoid(power, rub.t) == pytest.approx(float(rub.heat.sum()), rel=2e-6)


def test_friction_holds_no_more_than_it_can(rub):
    forces, rotor = contact_forces(rub), rotor_of(rub)
    grip = rotor.friction * forces.normal_force.values
    along, mode = forces.tangential_force.values, rub["mode"].values
    rolls, slides = mode == 2, np.abs(mode) == 1
    assert (np.abs(along[rolls]) <= grip[rolls] * (1.0 + 1e-9) + 1e-12).all()
    np.testing.assert_array_equal(along[slides], (mode * grip)[slides])
    assert not along[~rolls & ~slides].any()
    size = np.hypot(forces.normal_force, along)
    np.testing.assert_allclose(forces.force, size, rtol=1e-13)
