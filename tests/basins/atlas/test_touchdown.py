"""What an attractor does to a machine: held against long runs, and the balance of energy."""

import math

import numpy as np
import pytest

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    contact_summary,
    continue_attractors,
    simulate,
    synchronous_response,
    touchdown_report,
)
from rotor_ida.basins import attractors, known
from rotor_ida.basins.atlas.cells import FORM, Cell
from rotor_ida.schema import RESPONSE, WHIRL_DIRECTION

MACHINE = DimensionalRotor(
    mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6, speed=1000.0
)
BOUNCER = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
BOX = {"x": (-15, 15), "y": (-15, 15)}


def of_kind(report, kind):
    return report.isel(attractor=int(np.flatnonzero(report.kind == RESPONSE[kind])[0]))


def test_bouncing_is_that_of_a_long_run():
    """By CVODE, over 300 revolutions from rest, the first 100 left out."""
    row = of_kind(touchdown_report(BOUNCER, **BOX, starts=100), "bouncing")
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


def test_damping_takes_what_the_unbalance_gives():
    """Over a period of a cycle the drive ``omega**2 e^(i omega t)`` does as much work."""
    row = of_kind(touchdown_report(BOUNCER, **BOX, starts=100), "bouncing")
    revolution = 2.0 * math.pi / BOUNCER.omega
    periods = round(200.0 / float(row.period))
    run = simulate(BOUNCER, start=(0, 0, 0, 0), duration=400.0 + periods * float(row.period),
                   samples=200001)  # fmt: skip
    late = (run.t >= run.t[-1] - periods * float(row.period)).values
    angle = BOUNCER.omega * run.t.values
    work = BOUNCER.omega**2 * (run.vx * np.cos(angle) + run.vy * np.sin(angle)).values[late].mean()
    assert float(row.dissipation_per_revolution) == pytest.approx(work * revolution, rel=1e-3)


def test_a_whirl_is_as_the_closed_form_says():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
    report = touchdown_report(rotor, **BOX, starts=50)
    exact = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).squeeze()
    amplitude = exact.amplitude.values[exact.stability.values == 0]
    np.testing.assert_allclose(report.largest_force, amplitude**1.5, rtol=1e-12)
    np.testing.assert_allclose(report.mean_force, report.largest_force)
    np.testing.assert_array_equal(report.contact_fraction, 1.0)
    # torque times angle: the drive's work in a revolution
    work = 2.0 * math.pi * rotor.omega**2 * amplitude * np.sin(exact.phase_lag.values[[0, -1]])
    np.testing.assert_allclose(report.dissipation_per_revolution, work, rtol=1e-9)


def test_a_machine_is_told_in_si_units():
    ranges = {"x": (-1.5e-5, 1.5e-5), "y": (-1.5e-5, 1.5e-5)}
    in_si = touchdown_report(MACHINE, **ranges, starts=60)
    plain = touchdown_report(
        MACHINE.rotor(), **{name: np.array(ends) / 1e-6 for name, ends in ranges.items()}, starts=60
    )
    np.testing.assert_allclose(in_si.largest_force, plain.largest_force * MACHINE.force_scale)
    np.testing.assert_allclose(in_si.fraction, plain.fraction)
    energy = MACHINE.force_scale * MACHINE.length_scale
    np.testing.assert_allclose(
        in_si.dissipation_per_revolution, plain.dissipation_per_revolution * energy
    )
    assert in_si.settling_95.attrs["units"] == "s"


def test_backward_whirl_has_a_negative_ratio():
    report = touchdown_report(BOUNCER, **BOX, starts=50)
    for row in (report.isel(attractor=number) for number in range(report.sizes["attractor"])):
        ratio, word = float(row.whirl_ratio), int(row.whirl_direction)
        if math.isnan(ratio):
            assert word == WHIRL_DIRECTION["none"]
        else:
            assert word == WHIRL_DIRECTION["forward" if ratio > 0.0 else "backward"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"machine": "mine"}, "machine must be a DimensionalRotor or a Rotor, got 'mine'"),
        ({"machine": Rotor(omega=0.0, zeta=0.1, delta0=1.0)}, "speed must be above 0 .* got 0.0"),
        ({"machine": Rotor(omega=1.0, zeta=0.0, delta0=1.0)}, "zeta must be above 0"),
        ({"starts": -1}, "starts must be at least 1, got -1"),
        ({"x": (2, 1)}, "x must be a range"),
        (
            {"machine": MACHINE, "x": (-1e3, 1e3)},
            "in eccentricities, must lie within 1e.06 of zero",
        ),
    ],
)
def test_bad_input_gets_one_clear_line(changes, message):
    with pytest.raises(InputError, match=message) as caught:
        touchdown_report(**{"machine": BOUNCER, **BOX, **changes})
    assert "\n" not in str(caught.value)


def test_only_what_followed_its_starts_and_shocks_is_told(monkeypatch):
    """No attractor is confirmed; CVODE follows shocks, and is told where there were any."""
    seen, follow = [], attractors.follow_to_steady_state

    def watched(rotor, start, options, **how):
        seen.append(options.attributes())
        return follow(rotor, start, options, **how)

    monkeypatch.setattr(attractors, "follow_to_steady_state", watched)
    plain = touchdown_report(BOUNCER, **BOX, starts=100, shocks=0, rtol=1e-7)
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
    assert int(plain.agreement_count) == 4  # one of 32
    assert atlas.agreement_count.values.ravel().tolist() == [2, 2]
    assert not seen
    shaken = touchdown_report(BOUNCER, **BOX, starts=40, shocks=64)
    told = {
        name.removeprefix("witness_"): value
        for name, value in shaken.attrs.items()
        if name.startswith("witness_")
    }
    assert seen
    assert all(each == told for each in seen)


def test_the_tolerances_told_are_those_of_the_kernel(monkeypatch):
    seen, follow = set(), known.follow

    def watched(*given):
        seen.add(given[-2])
        follow(*given)

    monkeypatch.setattr(known, "follow", watched)
    report = touchdown_report(BOUNCER, **BOX, starts=64, shocks=64, rtol=1e-7)
    assert seen == {report.attrs["labelling_rtol"], report.attrs["agreement_rtol"]}


def test_a_rotor_kept_before_is_read():
    """It was not told how many labels were found again."""
    here = Cell(BOUNCER)
    arrays = FORM.as_arrays(here)
    del arrays["rechecked"]
    assert FORM.from_arrays(arrays).rechecked.tolist() == [0, 0]
