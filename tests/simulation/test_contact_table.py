"""The table of contacts against mechanics: impulse, energy, angles and directions."""

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, contact_summary, simulate, synchronous_response
from rotor_ida.model.contact import contact_force

BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
REST = (0.0, 0.0, 0.0, 0.0)


def test_an_elastic_bounce_straight_on_loses_nothing_and_turns_the_momentum():
    """omega = zeta = 0: impulse 2 m v, no energy lost, force 1.5th power of the depth."""
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=1.0)
    run = simulate(rotor, start=(0, 0, 0.8, 0), duration=10.0, rtol=1e-12, atol=1e-14)
    first = run.isel(contact=0)
    assert first.entry_time.item() == pytest.approx(1.0 / 0.8, rel=1e-14)
    assert first.impulse.item() == pytest.approx(1.6, rel=1e-10)
    assert first.energy_lost.item() == pytest.approx(0.0, abs=1e-10)
    assert first.entry_speed.item() == pytest.approx(0.8, rel=1e-14)
    assert first.entry_angle.item() == 0.0
    assert first.whirl_direction.item() == 0
    assert first.peak_indentation.item() == pytest.approx((1.25 * 0.8**2) ** 0.4, rel=1e-11)
    assert first.peak_force.item() == pytest.approx(first.peak_indentation.item() ** 1.5)
    middle = 0.5 * (first.entry_time.item() + first.exit_time.item())
    assert first.peak_time.item() == pytest.approx(middle, abs=1e-9)
    assert first.contact_duration.item() == pytest.approx(
        first.exit_time.item() - first.entry_time.item()
    )


@pytest.mark.parametrize(("vy", "direction"), [(0.5, 1), (-0.5, -1)])
def test_whirl_direction_and_angle_follow_the_angular_momentum(vy, direction):
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=1.0)
    run = simulate(rotor, start=(0.5, 0, 0.5, vy), duration=5.0)
    assert (run.whirl_direction == direction).all()
    angle = run.entry_angle.values[0]
    assert np.sin(angle) * run.entry_speed.values[0] == pytest.approx(0.5 * vy, rel=1e-12)


def test_impulse_is_the_integral_of_the_force():
    run = simulate(BOUNCING, start=REST, duration=12.0, rtol=1e-12, atol=1e-14)
    entry, leaving = run.entry_time.values[0], run.exit_time.values[0]
    nodes, weights = np.polynomial.legendre.leggauss(60)
    half = 0.5 * (leaving - entry)
    # sin(pi x / 2) spreads the nodes so that the force is smooth in x at entry and exit.
    spread, slope = np.sin(0.5 * np.pi * nodes), 0.5 * np.pi * np.cos(0.5 * np.pi * nodes)
    inside = simulate(
        BOUNCING,
        start=REST,
        duration=12.0,
        samples=entry + half * (1 + spread),
        rtol=1e-12,
        atol=1e-14,
    )
    force = contact_force(np.hypot(inside.x.values, inside.y.values), 2.0)
    integral = half * float((weights * slope * force).sum())
    assert run.impulse.values[0] == pytest.approx(integral, rel=1e-9)


def test_open_contacts_hold_nan_where_an_end_is_missing():
    run = simulate(Rotor(omega=0.0, zeta=0.0, delta0=1.0), start=(2.0, 0, 0, 0), duration=6.2)
    assert run.starts_in_contact == 1
    assert np.isnan(run.entry_time.values[0])
    assert np.isnan(run.impulse.values[0])
    assert np.isnan(run.entry_speed.values[0])
    assert run.peak_indentation.values[0] == 1.0
    assert np.isfinite(run.exit_time.values[0])


def test_the_summary_of_a_synchronous_whirl_is_the_closed_form_s():
    rotor = Rotor(omega=1.2, zeta=0.5, delta0=0.5)
    run = simulate(rotor, start=REST, duration=400.0)
    summary = contact_summary(run)
    exact = synchronous_response(omega=1.2, zeta=0.5, delta0=0.5).amplitude.values.ravel()[-1]
    assert summary.contact_count == 1
    assert summary.contact_fraction.item() == pytest.approx(1.0 - run.entry_time.item() / 400.0)
    assert summary.forward_fraction == 1.0
    assert summary.largest_force.item() >= (exact - 0.5) ** 1.5 - 1e-9
    assert summary.contacts_per_revolution.item() == pytest.approx(2 * np.pi / (1.2 * 400.0))


def test_a_summary_needs_a_run():
    with pytest.raises(InputError, match="needs a run of simulate"):
        contact_summary(synchronous_response(omega=1.0, zeta=0.1, delta0=1.0))
