"""Drops of a horizontal rotor: against basin fractions, and single runs by CVODE."""

import math
from functools import cache

import numpy as np
import pytest

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    basin_fractions,
    contact_forces,
    contact_summary,
    simulate,
    sweep,
    touchdown_report,
)
from rotor_ida.results.si_units import dimensional
from rotor_ida.schema import RESPONSE
from tests.basins.atlas.reports import WIDE, of_kind

# Bouncing after each revolution, and full contact; and a whirl clear of the stator.
DROPPED = Rotor(omega=2.0, zeta=0.05, delta0=1.0, shaft_stiffness=0.25, load=0.6)
HELD = Rotor(omega=0.25, zeta=0.1, delta0=2.0, shaft_stiffness=0.5, load=0.4)
# On a torus: a slight load on a cycle whose period is no whole number of revolutions.
RUBBING = Rotor(
    omega=2.0, zeta=0.07, delta0=2.0, contact_damping=0.2, load=0.02, friction=0.05,
    disc_radius=10.0,
)  # fmt: skip


@pytest.mark.parametrize("rotor", [DROPPED, HELD], ids=["dropped", "held"])
def test_fractions_and_motions_are_those_of_basin_fractions(rotor):
    report = touchdown_report(rotor, **WIDE, starts=12, seed=3)
    fractions = basin_fractions(rotor, **WIDE, starts=12, seed=3)
    for name in ("kind", "fraction", "fraction_error"):
        np.testing.assert_array_equal(report[name], fractions[name])
    for name in ("amplitude", "radius_min", "radius_max"):
        np.testing.assert_allclose(report[name], fractions[name], rtol=1e-9)
    assert report.attrs["labelling_rtol"] == fractions.attrs["labelling_rtol"] == 1e-6
    assert float(report.undecided_fraction) == 0.0
    assert "velocity_shock" not in report
    assert int(report.agreement_count) > 0
    assert float(report.agreement) == 1.0


def long_run(rotor, start, turns=200):
    """The last three quarters of a run, as a run of its own: by CVODE, whole revolutions."""
    revolution = 2.0 * math.pi / rotor.omega
    swept = sweep(**rotor.given, starts=[start]).squeeze()
    end = [float(swept[f"end_{name}"]) for name in ("x", "y", "vx", "vy")]
    return simulate(rotor, start=end, duration=turns * revolution, samples=200 * turns + 1)


@cache
def report_of(rotor):
    return touchdown_report(rotor, **WIDE, starts=8 if rotor is DROPPED else 2, seed=3)


def start_to(rotor, kind):
    """A start that leads to a kind of motion."""
    random = np.random.default_rng(0)
    while True:
        start = random.uniform(-6.0, 6.0, 4)
        settled = sweep(**rotor.given, starts=[start], method="taylor").response
        if settled.item() == RESPONSE[kind]:
            return start


@pytest.mark.parametrize(
    ("rotor", "kind", "near"),
    [
        (DROPPED, "bouncing", 1e-6),
        (DROPPED, "full_contact", 1e-6),
        (RUBBING, "quasi_periodic", 0.02),  # means over a torus, of 64 and of 200 revolutions
    ],
)
def test_forces_and_losses_are_those_of_a_long_run(rotor, kind, near):
    row = of_kind(report_of(rotor), kind)
    run = long_run(rotor, start_to(rotor, kind))
    told, forces, turns = contact_summary(run), contact_forces(run), 200
    normal = forces["normal_force" if rotor.friction > 0.0 else "force"]
    assert float(row.largest_force) == pytest.approx(float(normal.max()), rel=5e-3)
    assert float(row.contact_fraction) == pytest.approx(float(told.contact_fraction), rel=near)
    assert float(row.mean_force) == pytest.approx(float(normal[:-1].mean()), rel=2e-2)
    entries = float((run.event_kind == 1).sum()) / turns
    assert float(row.contacts_per_revolution) == pytest.approx(entries, abs=0.01)
    revolution = 2.0 * math.pi / rotor.omega
    loss = 2.0 * rotor.zeta * float((run.vx**2 + run.vy**2)[:-1].mean()) * revolution
    loss += sum(
        float(told[name]) / turns for name in ("total_heat", "total_contact_loss") if name in told
    )
    assert float(row.dissipation_per_revolution) == pytest.approx(loss, rel=max(near, 2e-4))
    assert ("heat_per_revolution" in row) == (rotor.friction > 0.0)


def test_the_sag_under_a_load_is_no_line_beside_1x():
    """It stands still, and is larger than any line of this torus but 1X."""
    row = of_kind(report_of(RUBBING), "quasi_periodic")
    assert abs(float(row.side_line_over_spin)) > 0.1


def test_about_the_sag_it_whirls_clear_of_the_stator():
    row = of_kind(touchdown_report(HELD, x=(-0.5, 0.5), starts=10), "contact_free")
    whirl = 0.25**2 / abs(complex(0.5 - 0.25**2, 2.0 * 0.1 * 0.25))
    assert float(row.fraction) == 1.0
    assert float(row.radius_max) == pytest.approx(0.8 + whirl, rel=1e-12)
    assert float(row.excursion) == pytest.approx((0.8 + whirl) / 2.0, rel=1e-12)
    assert float(row.largest_force) == float(row.contact_fraction) == 0.0
    loss = 4.0 * math.pi * 0.1 * 0.25 * whirl**2
    assert float(row.dissipation_per_revolution) == pytest.approx(loss, rel=1e-12)


def test_a_horizontal_machine_is_told_in_si_units():
    machine = DimensionalRotor(
        mass=8.0, contact_stiffness=5e7, damping=240.0, eccentricity=2e-5, clearance=1e-4,
        speed=700.0, shaft_stiffness=2e6, contact_exponent=1.0, contact_damping=7.5, load=78.5,
    )  # fmt: skip
    box = {"x": (-1e-4, 1e-4), "y": (-1e-4, 1e-4)}
    report = touchdown_report(machine, **box, starts=10)
    scaled = {name: tuple(end / machine.length_scale for end in ends) for name, ends in box.items()}
    plain = dimensional(touchdown_report(machine.rotor(), **scaled, starts=10), machine)
    assert report.largest_force.attrs["units"] == "N"
    assert float(report.mean_force.max()) > 0.5 * 78.5  # the shaft bears the rest
    for name in ("largest_force", "mean_force", "contact_loss_per_revolution", "fraction"):
        np.testing.assert_allclose(report[name], plain[name], rtol=1e-6)


def test_shocks_under_a_load_get_one_clear_line():
    with pytest.raises(InputError, match=r"shocks must be 0 under a load, got 64 with load 0\.6"):
        touchdown_report(DROPPED, **WIDE, starts=4, shocks=64)
    assert "velocity_shock" not in touchdown_report(DROPPED, **WIDE, starts=4, shocks=0)
