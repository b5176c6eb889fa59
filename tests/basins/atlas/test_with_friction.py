"""What a rub does to a machine: heat, slip and rolling; knocks that lead into dry whip."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    DimensionalRotor,
    Rotor,
    basin_fractions,
    contact_summary,
    continue_attractors,
    continue_cycle,
    limit_cycle,
    simulate,
    synchronous_response,
    touchdown_report,
)
from rotor_ida.basins.atlas import shocks
from rotor_ida.basins.atlas.extents import extent_of_cycle
from rotor_ida.basins.atlas.rubbing import states_of_rub
from rotor_ida.results.si_units import dimensional
from rotor_ida.schema import END, RESPONSE, TRAPPING
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import follow_to_steady_state

WHIP = Rotor(omega=0.62962981, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
BOUNCER = Rotor(
    omega=2.0, zeta=0.07, delta0=2.0, contact_damping=0.2, friction=0.1, disc_radius=10.0
)
BOX = dict.fromkeys(("x", "y", "vx", "vy"), (-6.0, 6.0))


def of_kind(report, kind):
    return report.isel(attractor=int(np.flatnonzero(report.kind == RESPONSE[kind])[0]))


def work_of_drive(run, rotor):
    """Return the work of unbalance and torque on a machine over all of a run."""
    angle = rotor.omega * run.t.values
    power = rotor.omega**2 * (run.vx * np.cos(angle) + run.vy * np.sin(angle)).values
    along = rotor.friction * run.normal_force.values * np.sign(run.slip_speed.values)
    return np.trapezoid(power + rotor.disc_radius * rotor.omega * along, run.t)


def test_a_rub_takes_the_heat_that_the_closed_form_says():
    row = of_kind(touchdown_report(WHIP, **BOX, starts=20, shocks=0), "synchronous")
    exact = synchronous_response(omega=WHIP.omega, zeta=0.1, delta0=1.0, friction=0.2).squeeze()
    stable = (exact.in_contact == 1) & (exact.stability == 0)
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
    row = of_kind(touchdown_report(WHIP, **BOX, starts=20, shocks=0), "rolling")
    cycle = limit_cycle(WHIP, start=(5.0, 0.0, 0.0, -6.3))
    for name in ("period", "radius_min", "radius_max", "largest_force", "whirl_ratio"):
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
    assert float(row.whirl_ratio) == pytest.approx(-10.0 / 4.98, rel=1e-2)
    assert float(row.contact_fraction) == 1.0
    assert float(row.contacts_per_revolution) == 0.0


def test_damping_and_friction_take_what_unbalance_and_torque_give():
    """While it bounces, always sliding forwards, over 400 revolutions by CVODE."""
    row = of_kind(touchdown_report(BOUNCER, **BOX, starts=40, shocks=0), "bouncing")
    revolution = 2.0 * math.pi / BOUNCER.omega
    run = simulate(BOUNCER, start=(3.0, 1.0, 0.0, 0.0), duration=500 * revolution, samples=200_001)
    late = run.isel(t=slice(40_000, None))
    work = work_of_drive(late, BOUNCER) / 400.0
    assert float(row.heat_per_revolution) > 0.3 * work
    assert float(row.contact_loss_per_revolution) > 0.0
    assert float(row.dissipation_per_revolution) == pytest.approx(work, rel=3e-3)


def test_a_report_in_si_units_is_that_of_the_rotor_in_its_scales():
    machine = DimensionalRotor(
        mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6,
        speed=1000.0, friction=0.1, disc_radius=1e-5,
    )  # fmt: skip
    box = {"x": (-4.0, 4.0), "y": (-4.0, 4.0)}
    scaled = {name: tuple(1e-6 * end for end in ends) for name, ends in box.items()}
    report = touchdown_report(machine, **scaled, starts=20, shocks=0)
    plain = dimensional(touchdown_report(machine.rotor(), **box, starts=20, shocks=0), machine)
    units = {"heat_per_revolution": "J", "slip_distance_per_revolution": "m",
             "rolling_fraction": "1"}  # fmt: skip
    for name, unit in units.items():
        assert report[name].attrs["units"] == unit
        np.testing.assert_allclose(report[name], plain[name], rtol=1e-6)


def test_a_knock_into_whip_is_followed_there_and_the_bound_is_below_it(monkeypatch):
    """And friction at which the rub loses its stability, at a Hopf point, ends its extent."""
    rotor = replace(WHIP, delta0=0.9)
    for name, few in {"MOST_TURNS": 2, "LEADING": 2, "NEIGHBOURS": 4}.items():
        monkeypatch.setattr(shocks, name, few)
    report = touchdown_report(rotor, **BOX, starts=20, shocks=64)
    rub, whip = of_kind(report, "synchronous"), of_kind(report, "rolling")
    target = int(whip.attractor)
    for kind in ("velocity", "displacement"):
        size = float(rub[f"{kind}_shock"].sel(target=target))
        assert 0.0 < float(rub[f"{kind}_shock_bound"]) < size
        told = [
            [float(rub[f"{kind}_shock_{when}_{name}"].sel(target=target)) for name in BOX]
            for when in ("before", "after")
        ]
        assert np.linalg.norm(np.subtract(*told)) == pytest.approx(size, rel=1e-9)
        run = simulate(rotor, start=told[1], duration=400.0, samples=401)
        assert (run["mode"][-100:] == 2).any()
        assert float(run.slip_speed[-100:].max()) < 0.1
    assert float(rub.friction_low) == 0.0
    end = float(rub.friction_high)
    around = synchronous_response(
        omega=rotor.omega, zeta=0.1, delta0=0.9, friction=np.array([end * 0.999, end * 1.001])
    ).squeeze()
    assert int(rub.friction_high_end) == END["hopf"]
    stable = (around.stability == 0) & (around.in_contact == 1)
    assert stable.values.tolist() == [True, False]


def test_states_of_whip_roll_or_slip_a_little():
    """They are all over the motion that the start ends on."""
    x, y, vx, vy = states_of_rub(WHIP, np.array([5.0, 0.0, 0.0, -6.3]), 400)
    radius = np.hypot(x, y)
    slip = (x * vy - y * vx) / radius + 6.2962981
    assert (radius > 4.6).all()
    assert (radius < 5.4).all()
    assert np.ptp(radius) > 0.5
    assert 0.5 < (np.abs(slip) < 1e-9).mean() < 0.8


def test_an_atlas_over_friction_has_the_whirl_of_the_closed_form_and_whip_once():
    """Fractions are those of `basin_fractions`; from no friction on the whirl is one attractor."""
    machine = {"omega": WHIP.omega, "zeta": 0.1, "delta0": 1.0}
    friction = [0.0, 0.1, 0.2, 0.22]
    asked = {**machine, "friction": friction, "disc_radius": 10.0, **BOX, "starts": 30}
    found = continue_attractors(**asked).squeeze()
    whirl, whip = (
        of_kind(found.isel(friction=2), "synchronous"),
        of_kind(found.isel(friction=2), "rolling"),
    )
    exact = synchronous_response(**machine, friction=friction).squeeze()
    stable = (exact.in_contact == 1) & (exact.stability == 0)
    along = found.amplitude.sel(attractor=int(whirl.attractor))
    np.testing.assert_allclose(along, exact.amplitude.where(stable).min("branch"), rtol=1e-9)
    rolls = found.fraction.sel(attractor=int(whip.attractor))
    assert np.isnan(rolls.values).tolist() == [True, True, False, False]
    alone = basin_fractions(WHIP, **BOX, starts=30)
    assert float(rolls[2]) == float(of_kind(alone, "rolling").fraction)
    assert found.kind.sel(attractor=int(whip.attractor)).values[2:].tolist() == [9, 9]


def test_an_atlas_over_the_disc_radius_goes_on_from_a_study(tmp_path):
    """A disc that slides forwards all the time does not know how large it is."""
    asked = {
        "omega": 1.2, "zeta": 0.3, "delta0": 0.5, "disc_radius": [5.0, 10.0], **BOX, "starts": 10,
    }  # fmt: skip
    for friction in (0.0, 0.1):
        study = tmp_path / str(friction)
        first = continue_attractors(**asked, friction=friction, study=study)
        again = continue_attractors(**asked, friction=friction, study=study)
        np.testing.assert_array_equal(first.fraction, again.fraction)
        assert again.fraction.squeeze("attractor").values.ravel().tolist() == [1.0, 1.0]
        assert np.ptp(again.amplitude.values) == 0.0


def test_limit_cycles_keep_their_numbers_over_friction_from_none_on():
    """They are points of the branches that `continue_cycle` follows; one is born in between."""
    machine = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0, "disc_radius": 10.0}
    friction = [0.0, 0.05, 0.1, 0.15]
    found = continue_attractors(**machine, friction=friction, **BOX, starts=12).squeeze()
    bounces = of_kind(found.isel(friction=0), "bouncing").attractor.item()
    over = found.sel(attractor=bounces)
    assert (over.kind == RESPONSE["bouncing"]).all()
    for each in friction:
        rotor = Rotor(**machine, friction=each)
        cycle = limit_cycle(rotor, start=(3.0, 1.0, 0.0, 0.0))
        for name in ("period", "radius_min", "radius_max"):
            there = over[name].sel(friction=each).item()
            assert there == pytest.approx(cycle[name].item(), rel=1e-9)
    branch = continue_cycle(
        Rotor(**machine), start=(3.0, 1.0, 0.0, 0.0), parameter="friction", limits=(0.0, 0.15)
    )
    assert float(branch.period[-1]) == pytest.approx(float(over.period[-1]), rel=1e-9)
    other = of_kind(found.isel(friction=3), "full_contact").attractor.item()
    periods = found.period.sel(attractor=other).values
    assert np.isnan(periods).tolist() == [True, True, False, False]


def test_whip_ends_at_the_corner_where_it_no_longer_rolls():
    """There it meets a cycle that does not. Led down in small steps it lasts up to there."""
    cycle = limit_cycle(WHIP, start=(5.0, 0.0, 0.0, -6.3))
    state = np.array([float(cycle[name][0]) for name in BOX])
    low, high = extent_of_cycle(WHIP, state, float(cycle.period), "friction", np.zeros(1, np.uint8))
    assert low.kind == "fold"
    assert high.kind == "not_found"  # it lasts for as far as the branch was followed
    place = tuple(state.tolist())
    for friction in np.geomspace(0.2, 1.001 * low.value, 8).tolist():
        settled = follow_to_steady_state(replace(WHIP, friction=friction), place, Options())
        assert settled.response == "rolling"
        place = settled.end
    below = follow_to_steady_state(replace(WHIP, friction=0.999 * low.value), place, Options())
    assert below.response == "synchronous"
