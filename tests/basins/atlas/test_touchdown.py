"""What an attractor does to a machine: held against long runs, and the balance of energy."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    Rotor,
    contact_summary,
    continue_attractors,
    limit_cycle,
    simulate,
    synchronous_response,
    touchdown_report,
)
from rotor_ida.basins import attractors
from rotor_ida.basins.atlas import resilience
from rotor_ida.basins.atlas.resilience import resilience_of, search_of
from rotor_ida.basins.atlas.shocks import Effort
from rotor_ida.basins.attractors import OF_DISC, disc_row
from rotor_ida.basins.disc import Disc
from rotor_ida.core.runs import NO_STOP
from rotor_ida.schema import TRAPPING
from tests.basins.atlas.reports import BOX, WIDE, of_kind
from tests.basins.lanes import WHIP

PLAIN = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0}
RUBBING_BOUNCER = Rotor(
    omega=2.0, zeta=0.07, delta0=2.0, contact_damping=0.2, friction=0.1, disc_radius=10.0
)


BOUNCER = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


@pytest.fixture(scope="module")
def bouncing():
    return touchdown_report(BOUNCER, **BOX, starts=50, shocks=0)


def test_bouncing_is_that_of_a_long_run(bouncing):
    """By CVODE, over 300 revolutions from rest, the first 100 left out."""
    row = of_kind(bouncing, "bouncing")
    revolution = 2.0 * math.pi / BOUNCER.omega
    run = simulate(BOUNCER, start=(0, 0, 0, 0), duration=300 * revolution, samples=60001)
    late = run.entry_time.values > 100 * revolution
    whole = late & np.isfinite(run.exit_time.values)
    first, last = run.entry_time.values[whole][[0, -1]]
    count = whole.sum() - 1
    turns = (last - first) / revolution
    inside = whole & (run.entry_time.values < last)
    assert float(row.contacts_per_revolution) == pytest.approx(count / turns, rel=1e-6)
    spent = (run.exit_time - run.entry_time).values[inside].sum() / (last - first)
    assert float(row.contact_fraction) == pytest.approx(spent, rel=1e-6)
    assert float(row.largest_force) == pytest.approx(run.peak_force.values[inside].max(), rel=1e-6)
    impulse = run.impulse.values[inside].sum() / (last - first)
    assert float(row.mean_force) == pytest.approx(impulse, rel=1e-6)
    assert float(contact_summary(run).contacts_per_revolution) > 0.0
    within = (run.t >= first) & (run.t <= last)
    power = 2.0 * BOUNCER.zeta * (run.vx**2 + run.vy**2).values[within.values].mean()
    assert float(row.dissipation_per_revolution) == pytest.approx(power * revolution, rel=1e-3)


def test_a_whirl_is_as_the_closed_form_says():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
    report = touchdown_report(rotor, **BOX, starts=50, shocks=0)
    exact = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).squeeze()
    amplitude = exact.amplitude.values[exact.stability.values == 1]
    np.testing.assert_allclose(report.largest_force, amplitude**1.5, rtol=1e-12)
    np.testing.assert_allclose(report.mean_force, report.largest_force)
    np.testing.assert_array_equal(report.contact_fraction, 1.0)
    # torque times angle: the drive's work in a revolution
    work = 2.0 * math.pi * rotor.omega**2 * amplitude * np.sin(exact.phase_lag.values[[0, -1]])
    np.testing.assert_allclose(report.dissipation_per_revolution, work, rtol=1e-9)


def test_only_what_followed_its_starts_and_shocks_is_told(monkeypatch):
    """No attractor is confirmed; CVODE follows shocks, and is told where there were any."""
    seen, follow = [], attractors.settle_disc

    def watched(rotor, start, options, **how):
        seen.append(options.attributes())
        return follow(rotor, start, options, **how)

    monkeypatch.setattr(attractors, "settle_disc", watched)
    monkeypatch.setattr(resilience.DiscSearch, "effort", Effort(leading=2, neighbours=4, turns=2))
    plain = touchdown_report(BOUNCER, **BOX, starts=64, shocks=0, rtol=1e-7)
    atlas = continue_attractors(
        omega=[2.0, 2.1], zeta=0.07, delta0=2.0, **BOX, starts=40, rtol=1e-7, workers=1
    )
    for found in (plain, atlas):
        told = set(found.attrs)
        assert not {"method", "flight", "backend", "rtol", "atol", "witness_method"} & told
        assert not {name for name in told if name.startswith("confirm")}
        assert found.attrs["labelling_rtol"] == 1e-7
        assert found.attrs["agreement_rtol"] == pytest.approx(1e-11)
        assert (found.agreement == 1.0).all()
    assert int(plain.agreement_count) == 6  # one of 12 of a batch
    assert atlas.agreement_count.values.ravel().tolist() == [2, 2]
    assert not seen
    shaken = touchdown_report(BOUNCER, **BOX, starts=40, shocks=8)
    told = {
        name.removeprefix("witness_"): value
        for name, value in shaken.attrs.items()
        if name.startswith("witness_")
    }
    assert seen
    assert all(each == told for each in seen)


def test_what_the_drive_gives_is_what_both_dampings_take():
    """Over a period of a cycle; the drive's work from the mean velocity along the unbalance."""
    rotor = Rotor(**PLAIN, contact_damping=0.02)
    row = of_kind(touchdown_report(rotor, **BOX, starts=64, shocks=0), "bouncing")
    run = simulate(rotor, start=(3.0, 0.0, 0.0, 0.0), duration=400.0, samples=2)
    turn = np.exp(-1j * rotor.omega * 400.0)
    z, v = complex(run.x[-1], run.y[-1]) * turn, complex(run.vx[-1], run.vy[-1]) * turn
    cycle = limit_cycle(rotor, start=(z.real, z.imag, v.real, v.imag))
    assert float(cycle.period) == pytest.approx(float(row.period), rel=1e-6)
    along = float(cycle.vx[:-1].mean())  # on the rotating axes; periodic, and so exact
    given = rotor.omega**2 * along * 2.0 * math.pi / rotor.omega
    assert float(row.dissipation_per_revolution) == pytest.approx(given, rel=1e-4)
    assert 0.01 < float(row.contact_loss_per_revolution / row.dissipation_per_revolution) < 0.5


def test_forces_of_a_linear_contact_are_the_indentation():
    rotor = Rotor(**PLAIN, contact_exponent=1.0)
    row = of_kind(touchdown_report(rotor, **BOX, starts=64, shocks=0), "bouncing")
    assert float(row.largest_force) == pytest.approx(float(row.radius_max) - 2.0, rel=1e-12)
    assert "contact_loss_per_revolution" not in row


def work_of_drive(run, rotor):
    """Return the work of unbalance and torque on a machine over all of a run."""
    angle = rotor.omega * run.t.values
    power = rotor.omega**2 * (run.vx * np.cos(angle) + run.vy * np.sin(angle)).values
    along = rotor.friction * run.normal_force.values * np.sign(run.slip_speed.values)
    return np.trapezoid(power + rotor.disc_radius * rotor.omega * along, run.t)


def test_a_rub_takes_the_heat_that_the_closed_form_says():
    row = of_kind(touchdown_report(WHIP, **WIDE, starts=20, shocks=0), "synchronous")
    exact = synchronous_response(omega=WHIP.omega, zeta=0.1, delta0=1.0, friction=0.2).squeeze()
    stable = (exact.in_contact == 1) & (exact.stability == 1)
    size = float(exact.amplitude[stable].item())
    distance, force = 2.0 * math.pi * (size + 10.0), (size - 1.0) ** 1.5
    assert float(row.slip_distance_per_revolution) == pytest.approx(distance, rel=1e-12)
    assert float(row.heat_per_revolution) == pytest.approx(0.2 * force * distance, rel=1e-12)
    assert float(row.rolling_fraction) == 0.0
    assert int(row.trapping) == TRAPPING["proven"]
    # the drive: unbalance, and the torque against friction
    lag = float(exact.phase_lag[stable].item())
    work = 2.0 * math.pi * (WHIP.omega**2 * size * math.sin(lag) + 10.0 * 0.2 * force)
    assert float(row.dissipation_per_revolution) == pytest.approx(work, rel=1e-9)


def test_whip_rolls_and_heats_as_in_a_long_run():
    """One period of its limit cycle, beside CVODE over 400 revolutions after the first 100."""
    row = of_kind(touchdown_report(WHIP, **WIDE, starts=20, shocks=0), "rolling")
    cycle = limit_cycle(WHIP, start=(5.0, 0.0, 0.0, -6.3))
    for name in ("period", "radius_min", "radius_max", "largest_force", "whirl_over_spin"):
        assert float(row[name]) == pytest.approx(float(cycle[name]), rel=1e-9)
    revolution = 2.0 * math.pi / WHIP.omega
    run = {"start": (5.0, 0.0, 0.0, -6.3), "samples": 100_001}
    short, long = (
        contact_summary(simulate(WHIP, duration=turns * revolution, **run)) for turns in (100, 500)
    )
    heat = (long.total_heat - short.total_heat) / 400.0
    assert float(row.heat_per_revolution) == pytest.approx(float(heat), rel=2e-3)
    distance = (long.total_slip_distance - short.total_slip_distance) / 400.0
    assert float(row.slip_distance_per_revolution) == pytest.approx(float(distance), rel=2e-3)
    rolled = (500.0 * long.rolling_fraction - 100.0 * short.rolling_fraction) / 400.0
    assert float(row.rolling_fraction) == pytest.approx(float(rolled), rel=2e-3)
    # r phi' = -rho omega: backwards, at more than twice the speed of the spin
    assert float(row.whirl_over_spin) == pytest.approx(-10.0 / 4.98, rel=1e-2)
    assert float(row.contact_fraction) == 1.0
    assert float(row.contacts_per_revolution) == 0.0


def test_damping_and_friction_take_what_unbalance_and_torque_give():
    """While it bounces, always sliding forwards, over 400 revolutions by CVODE."""
    row = of_kind(touchdown_report(RUBBING_BOUNCER, **WIDE, starts=40, shocks=0), "bouncing")
    revolution = 2.0 * math.pi / RUBBING_BOUNCER.omega
    run = simulate(
        RUBBING_BOUNCER, start=(3.0, 1.0, 0.0, 0.0), duration=500 * revolution, samples=200_001
    )
    late = run.isel(t=slice(40_000, None))
    work = work_of_drive(late, RUBBING_BOUNCER) / 400.0
    assert float(row.heat_per_revolution) > 0.3 * work
    assert float(row.contact_loss_per_revolution) > 0.0
    assert float(row.dissipation_per_revolution) == pytest.approx(work, rel=3e-3)


def test_states_of_whip_roll_or_slip_a_little():
    """They are all over the motion, which is shocked at each."""
    cycle = limit_cycle(WHIP, start=(5.0, 0.0, 0.0, -6.3))
    state = [float(cycle[name][0]) for name in ("x", "y", "vx", "vy")]
    row = disc_row("rolling", 0.3, 0.0, 4.6, 5.4, period=math.nan, state=state)
    disc = Disc.of(WHIP, 1e-6, NO_STOP)
    source = search_of(disc, np.array([row], OF_DISC), 16, NO_STOP).source(0)
    x, y, vx, vy = source(np.linspace(0.0, 1.0, 400, endpoint=False)[np.newaxis])
    radius = np.hypot(x, y)
    slip = (x * vy - y * vx) / radius + 6.2962981
    assert (radius > 4.6).all()
    assert (radius < 5.4).all()
    assert np.ptp(radius) > 0.5
    assert 0.5 < (np.abs(slip) < 1e-9).mean() < 0.8


def test_a_search_tells_the_shocks_that_it_has_followed(monkeypatch):
    """Round by round, with friction some at a time: it may take minutes."""
    monkeypatch.setattr(resilience.DiscSearch, "effort", Effort(leading=2, neighbours=4, turns=2))
    row = disc_row("contact_free", 1.0, 0.0, 1.0, 1.0, period=math.nan, state=[1.0, 0.0, 0.0, 0.0])
    rubbing = replace(BOUNCER, friction=0.1, disc_radius=10.0)
    told = []
    for rotor, most in ((BOUNCER, 128), (rubbing, 64)):
        disc = Disc.of(rotor, 1e-6, NO_STOP)
        (_, fills) = resilience_of(search_of(disc, np.array([row], OF_DISC), 128, NO_STOP))
        for each in fills:
            each.work(np.zeros(1, np.uint8))
            assert max(each.followed, default=0) <= most
            told.append((sum(each.followed), each.shocks))
    assert told[:3] == [(0, 0), (256, 256), (0, 0)]
    assert told[3][0] >= told[3][1] == 256  # a search for smaller ones follows more
