"""The table of contacts against mechanics: impulse, energy, angles, heat and slip."""

import math

import numpy as np
import pytest
from scipy.integrate import simpson

from rotor_ida import (
    InputError,
    Rotor,
    contact_forces,
    contact_summary,
    simulate,
    synchronous_response,
)
from tests.rotors import MOTIONS, ROTORS, RUBBING, WAYS
from tests.witness import Disc, flown

REST = (0.0, 0.0, 0.0, 0.0)


ALL = ROTORS["everything"]


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


@pytest.mark.parametrize("vy", [-0.05, 0.05])
def test_a_bounce_straight_off_the_stator_is_no_whirl(vy):
    """It meets the stator at sin(a) = 0.5 |vy| / v, which is 3 degrees."""
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=1.0)
    run = simulate(rotor, start=(0.5, 0, 0.5, vy), duration=20.0)
    assert run.sizes["contact"] > 2
    assert np.abs(np.degrees(run.entry_angle)).max() < 3.0
    assert (run.whirl_direction == 0).all()
    # a contact that lasts for turns is a whirl, however straight it began
    whirl = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 2, 0.1), duration=200.0)
    assert whirl.whirl_direction[-1] == 1


def test_open_contacts_are_nan_where_an_end_is_missing():
    run = simulate(Rotor(omega=0.0, zeta=0.0, delta0=1.0), start=(2.0, 0, 0, 0), duration=6.2)
    assert run.starts_in_contact == 1
    assert np.isnan(run.entry_time.values[0])
    assert run.impulse.values[0] == pytest.approx(np.sqrt(0.8), rel=1e-10)  # m v at the exit
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


@pytest.mark.parametrize(("rotor", "start"), [
    (Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0), (6.9, 0, 0, -10)),
    (Rotor(omega=2.0, zeta=0.07, delta0=2.0), REST),
])  # fmt: skip
def test_the_impulse_of_a_run_has_that_of_contacts_without_an_end(rotor, start):
    run = simulate(rotor, start=start, duration=20.0, samples=40_001)
    assert np.isnan(run.exit_time.values[-1])
    summary, forces = contact_summary(run), contact_forces(run)
    force = forces["normal_force" if rotor.friction else "force"]
    whole = float(simpson(force, x=force.t))
    assert summary.total_impulse.item() == pytest.approx(whole, rel=1e-6)
    turns = 20.0 * rotor.omega / (2.0 * np.pi)
    assert summary.impulse_per_revolution.item() == pytest.approx(whole / turns, rel=1e-6)
    known = np.isfinite(run.exit_time + run.entry_time).any()
    assert np.isfinite(summary.energy_lost_per_revolution) == known


def test_without_clearance_the_impulse_is_not_known():
    summary = contact_summary(simulate(Rotor(omega=1.7, zeta=0.07, delta0=0.0), duration=20.0))
    assert np.isnan(summary.total_impulse)
    assert np.isnan(summary.energy_lost_per_revolution)


def test_a_summary_needs_a_run():
    with pytest.raises(InputError, match="must be a run of simulate"):
        contact_summary(synchronous_response(omega=1.0, zeta=0.1, delta0=1.0))


# ---- Contact damping: what it takes ----


def test_the_largest_force_is_that_of_the_motion():
    motion = MOTIONS["contact damping"]
    rotor, start = motion.rotor, motion.start
    found = simulate(rotor, start=start, duration=5.0, samples=500_001, method="taylor")
    x, y, vx, vy = (found[name].values for name in ("x", "y", "vx", "vy"))
    radius = np.hypot(x, y)
    depth, approach = np.maximum(radius - rotor.delta0, 0.0), (x * vx + y * vy) / radius
    force = np.maximum(depth**1.5 * (1.0 + rotor.contact_damping * approach), 0.0)
    first = found.t.values <= found.exit_time.fillna(5.0).values[0]
    assert found.peak_force.values[0] == pytest.approx(force[first].max(), rel=1e-8)
    assert found.peak_force.values[0] > 1.01 * found.peak_indentation.values[0] ** 1.5


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize(("method", "rtol"), [("taylor", 1e-12), ("adams", 1e-9), ("bdf", 1e-6)])
def test_deep_in_the_ring_it_creeps_back_and_energy_balances(exponent, method, rtol):
    """As fast as the contact damping lets it, 1/c, after a delay of 1/(c h**n): next to no energy.

    What it has at the end, 1/(2 c**2), is a hundred-thousandth of what the ring held.
    """
    depth, c = 50.0, 5.0
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=1.0, contact_exponent=exponent, contact_damping=c)
    found = simulate(rotor, start=(1.0 + depth, 0, 0, 0), duration=1.0, samples=2, method=method,
                     rtol=rtol, atol=1e-2 * rtol)  # fmt: skip
    expected = 1.0 + depth - 1.0 / c + 1.0 / (c * c * depth**exponent)
    assert found.x.values[-1] == pytest.approx(expected, abs=1e-8 + rtol)
    assert found.vx.values[-1] == pytest.approx(-1.0 / c, rel=1e-6)


# ---- Friction: heat, slip distance, the share of rolling ----


def test_samples_say_how_it_moves_how_fast_it_slides_and_how_hard_it_is_pressed():
    found = simulate(
        ALL, start=MOTIONS["everything"].start, duration=20.0, samples=2001, method="taylor"
    )
    t, mode = found.t.values, found.mode.values
    assert found.mode.attrs["flag_meanings"].split() == [
        "flight", "slipping_forward", "slipping_backward", "rolling", "loose",
    ]  # fmt: skip
    states = np.array([found[name].values for name in ("x", "y", "vx", "vy")]).T
    slip = np.array([Disc(ALL).slip([*state, 0.0, ALL.omega]) for state in states])
    np.testing.assert_allclose(found.slip_speed.values[1:], slip[1:], rtol=0, atol=1e-12)
    radius = np.hypot(*states.T[:2])
    in_contact = radius > ALL.delta0
    assert ((mode != 0) == in_contact)[np.abs(radius - ALL.delta0) > 1e-9].all()
    rise = (states[:, 0] * states[:, 2] + states[:, 1] * states[:, 3]) / np.maximum(radius, 1e-9)
    force = np.maximum((radius - ALL.delta0) * (1.0 + ALL.contact_damping * rise), 0.0)
    expected = np.where(in_contact, force, 0.0)
    np.testing.assert_allclose(found.normal_force.values, expected, rtol=0, atol=1e-9)
    sliding = np.abs(mode) == 1
    assert (mode * slip)[sliding].min() > -1e-9
    assert {1, -1, 3} <= set(mode.tolist())
    kinds, when = found.event_kind.values, found.event_time.values
    for kind, time in zip(kinds, when, strict=True):
        if kind == 3:
            before, after = (mode[np.searchsorted(t, time) + place] for place in (-1, 0))
            assert before == -after or np.abs(when - time).min() < 0.01


@pytest.mark.parametrize("way", WAYS)
def test_the_heat_is_the_work_of_sliding(way):
    """The integral of mu N |v_s|, summed over closely spaced samples."""
    motion = MOTIONS["small disc, that chatters"]
    rotor, start, duration = motion.rotor, motion.start, motion.duration
    found = simulate(rotor, start=start, duration=duration, samples=30_001, **WAYS[way])
    power = rotor.friction * found.normal_force.values * np.abs(found.slip_speed.values)
    total = np.trapezoid(power, found.t.values)
    assert float(found.heat.sum()) == pytest.approx(total, rel=1e-6)
    assert (found.heat.values > 0.0).all()


def test_a_synchronous_rub_slides_round_the_ring_by_rim_and_whirl():
    """v_s = (A + rho) omega and N are constant: so are heat and distance in a unit of time."""
    rotor = Rotor(omega=1.2, zeta=0.3, delta0=0.5, friction=0.1, disc_radius=10.0)
    exact = synchronous_response(omega=1.2, zeta=0.3, delta0=0.5, friction=0.1).squeeze()
    size, lag = float(exact.amplitude), float(exact.phase_lag)
    z = size * np.exp(-1j * lag)
    start = (z.real, z.imag, (1j * 1.2 * z).real, (1j * 1.2 * z).imag)
    told = contact_summary(simulate(rotor, start=start, duration=30.0, samples=301))
    distance = 30.0 * 1.2 * (size + 10.0)
    assert told.total_slip_distance.item() == pytest.approx(distance, rel=1e-8)
    heat = 0.1 * (size - 0.5) ** 1.5 * distance
    assert told.total_heat.item() == pytest.approx(heat, rel=1e-8)
    revolutions = 30.0 * 1.2 / (2.0 * math.pi)
    assert told.heat_per_revolution.item() == pytest.approx(heat / revolutions, rel=1e-8)
    assert told.rolling_fraction.item() == 0.0


@pytest.mark.parametrize("name", ["dry whip", "rough stator", "small disc, that chatters"])
def test_the_share_of_rolling_is_that_between_events_of_another_integrator(name):
    motion = MOTIONS[name]
    rotor, start, duration = motion.rotor, motion.start, motion.duration
    events = flown(rotor, start, duration).events
    times = np.array([time for time, _, _ in events] + [duration])
    kinds = np.array([kind for _, kind, _ in events])
    rolled = np.diff(times)[kinds == 2].sum()
    touched, since = 0.0, 0.0 if math.hypot(*start[:2]) > rotor.delta0 else None
    for time, kind, _ in events:
        if kind == 1:
            since = time
        elif kind == -1:
            touched, since = touched + time - since, None
    touched += 0.0 if since is None else duration - since
    told = contact_summary(simulate(rotor, start=start, duration=duration, method="taylor"))
    assert told.rolling_fraction.item() == pytest.approx(rolled / touched, rel=1e-7)


@pytest.mark.parametrize("name", RUBBING)
def test_the_slip_distance_is_that_of_other_integrators_and_needs_no_samples(name):
    motion = MOTIONS[name]
    given = {"start": motion.start, "duration": motion.duration, "samples": 3}
    exact = simulate(motion.rotor, **given, method="taylor").slip_distance.values
    for way in ("adams", "reference"):
        found = simulate(motion.rotor, **given, **WAYS[way]).slip_distance.values
        assert found == pytest.approx(exact, rel=1e-8, abs=1e-9), way


def test_a_run_without_touches_has_no_heat():
    rotor = Rotor(omega=0.3, zeta=0.1, delta0=5.0, friction=0.2, disc_radius=1.0)
    told = contact_summary(simulate(rotor, start=(0, 0, 0, 0), duration=10.0))
    assert told.total_heat.item() == told.total_slip_distance.item() == 0.0
    assert np.isnan(told.rolling_fraction.item())
