"""Starts end where a sweep from each of them ends: machines, under a load, with friction."""

import math

import numpy as np
import pytest

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    basin,
    basin_fractions,
    continue_attractors,
    limit_cycle,
    sweep,
)
from rotor_ida.basins.fates import Batch, decide
from rotor_ida.basins.known import known_from_closed_forms
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.closed_forms.rest import rest
from rotor_ida.schema import RESPONSE, TRAPPING
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.starts import drawn_from
from rotor_ida.steady.follow import settle_disc
from tests.basins.lanes import GO_ON, RUBBING, WHIP

BOX = {"x": (-6, 6), "y": (-6, 6), "vx": (-6, 6), "vy": (-6, 6)}
PLANE = {"x": (-4, 4), "y": (-4, 4)}


@pytest.mark.parametrize(
    "beyond",
    [
        {"shaft_stiffness": 0.25},
        {"contact_exponent": 1.0},
        {"contact_damping": 0.1},
        {"shaft_stiffness": 1.0, "contact_exponent": 1.0, "contact_damping": 0.2},
    ],
    ids=str,
)
def test_labels_are_what_a_sweep_finds_from_the_same_starts(beyond):
    """Starts of a plane, each followed by CVODE as well."""
    axis = np.linspace(-4.0, 4.0, 5)
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, **beyond)
    found = basin(rotor, x=axis, y=axis)
    assert int(found.undecided_count) == 0
    assert found.coords["zeta"] == 0.07
    for name, value in beyond.items():
        assert found.coords[name] == found.attrs[name] == value
    starts = [(x, y, 0.0, 0.0) for x in axis for y in axis]
    alone = sweep(omega=2.0, zeta=0.07, delta0=2.0, **beyond, starts=starts[::3])
    labels = found.label.transpose("x", "y").values.ravel()[::3]
    kinds = found.kind.values[labels]
    # touches that are still fading may already be inside by another solver's rounding
    family = {RESPONSE["touching"]: RESPONSE["contact_free"]}
    told = [family.get(kind, kind) for kind in np.ravel(alone.response).tolist()]
    assert [family.get(kind, kind) for kind in kinds.tolist()] == told
    steady = ~np.isin(kinds, [RESPONSE["contact_free"], RESPONSE["touching"]])
    for name in ("radius_min", "radius_max"):
        apart = found[name].values[labels] - np.ravel(alone[name])
        assert np.abs(apart[steady]).max(initial=0.0) < 1e-6


def test_starts_end_in_dry_whip_or_on_the_rub_as_a_sweep_from_each_does():
    """By CVODE; rub and contact-free whirl come from closed forms, and whip is a limit cycle."""
    found = basin_fractions(WHIP, **BOX, starts=12, seed=1)
    starts = drawn_from(np.array(list(BOX.values()), float), 1, 0, 12).T
    alone = sweep(**WHIP.given, starts=starts).squeeze()
    assert {RESPONSE["synchronous"], RESPONSE["rolling"]} == set(alone.response.values.tolist())
    for kind in ("synchronous", "rolling", "contact_free"):
        here = found["count"].values[found.kind.values == RESPONSE[kind]].sum()
        assert here == (alone.response == RESPONSE[kind]).sum()
        told = found.response_count.sel(response=RESPONSE[kind])
        assert int(told) == here
    assert int(found.undecided_count) == 0
    proven = found.trapping.values == TRAPPING["proven"]
    assert (proven == (found.kind.values != RESPONSE["rolling"])).all()
    assert (found.confirmed.values == (found["count"].values > 0)).all()
    rolls = found.isel(attractor=int(np.argmax(found.kind.values == RESPONSE["rolling"])))
    whips = alone.where(alone.response == RESPONSE["rolling"])
    for name in ("radius_min", "radius_max", "period"):
        np.testing.assert_allclose(whips[name].dropna("start"), rolls[name].item(), atol=1e-6)
    cycle = limit_cycle(WHIP, start=(5.0, 0.0, 0.0, -6.3))
    for name in ("radius_min", "radius_max", "period"):
        assert rolls[name].item() == pytest.approx(cycle[name].item(), rel=1e-10)


def test_two_motions_that_bounce_are_told_apart():
    """And each is the limit cycle to which a sweep by CVODE and `limit_cycle` come as well."""
    rotor = Rotor(omega=1.573, zeta=0.045, delta0=3.0, friction=0.124, disc_radius=3.0)
    found = basin_fractions(rotor, **BOX, starts=8)
    bounces = found.isel(attractor=found.kind.values == RESPONSE["bouncing"])
    assert bounces.sizes["attractor"] == 2
    assert bounces.confirmed.values.tolist() == [1, 1]
    starts = drawn_from(np.array(list(BOX.values()), float), 0, 0, 8).T
    alone = sweep(**rotor.given, starts=starts).squeeze()
    for number in range(2):
        here = bounces.isel(attractor=number)
        same = np.abs(alone.period.values / here.period.item() - 1.0) < 1e-6
        assert same.sum() == here["count"].item() > 0
        cycle = limit_cycle(rotor, start=starts[np.argmax(same)])
        for name in ("radius_min", "radius_max", "period"):
            assert here[name].item() == pytest.approx(cycle[name].item(), rel=1e-10)


def test_under_a_load_whip_has_no_period_and_is_told_by_its_kind():
    """Its own period and that of the spin are not of one measure: it rolls, and never comes again.

    CVODE confirms it, as it does the rub, which under a load comes again once a revolution.
    """
    rotor = Rotor(**WHIP.given | {"load": 0.02})
    found = basin_fractions(rotor, **BOX, starts=6)
    assert found.kind.values.tolist() == [RESPONSE["full_contact"], RESPONSE["rolling"]]
    rub, whip = (found.isel(attractor=number) for number in range(2))
    assert rub.period.item() == pytest.approx(2.0 * math.pi / WHIP.omega, rel=1e-12)
    assert math.isnan(whip.period)
    assert found.confirmed.values.tolist() == [1, 1]
    still = limit_cycle(WHIP, start=(5.0, 0.0, 0.0, -6.3))
    assert whip.radius_min.item() == pytest.approx(still.radius_min.item(), rel=0.02)
    assert whip.radius_max.item() == pytest.approx(still.radius_max.item(), rel=0.02)


@pytest.mark.parametrize("rotor", RUBBING.values(), ids=RUBBING)
def test_no_label_differs_from_that_of_a_start_followed_by_itself(rotor):
    """Taylor series from each start on, roll by roll: no lane knows what becomes of a disc then."""
    starts = np.random.default_rng(5).uniform(-6.0, 6.0, (4, 60))
    known = known_from_closed_forms(rotor, GO_ON)
    batch = decide(Batch(known, starts, 1e-6, GO_ON))
    labels, cycles = batch.labels, [each.cycle for each in batch.known.cycles]
    kinds = {0: "synchronous"} if known.whirls else {}
    kinds |= {known.free_label: "contact_free", known.fading_label: "touching"}
    kinds |= {known.first_cycle + place: each.response for place, each in enumerate(cycles)}
    alone = Options(method="taylor", rtol=1e-11)
    for label, start in zip(labels.tolist(), starts.T.tolist(), strict=True):
        settled = settle_disc(rotor, tuple(start), alone)
        assert kinds[label] == settled.kind
        if label >= known.first_cycle:
            cycle = cycles[label - known.first_cycle]
            assert settled.features.period == pytest.approx(cycle.duration, rel=1e-6)
            assert settled.features.radius_max == pytest.approx(cycle.radius_max, rel=1e-6)
        if kinds[label] == "synchronous":
            assert settled.features.amplitude == pytest.approx(known.whirls[0].amplitude, rel=1e-6)


def test_where_the_shaft_holds_the_load_the_whirl_is_moved_by_it():
    rotor = Rotor(omega=1.0, zeta=0.1, delta0=3.0, shaft_stiffness=4.0, load=0.3)
    found = basin_fractions(rotor, **PLANE, starts=8)
    size = abs(complex_amplitude(1.0, 0.1, 4.0))
    assert found.kind.values.tolist() == [RESPONSE["contact_free"]]
    assert found["count"].values.tolist() == [8]
    assert float(found.amplitude[0]) == pytest.approx(size, rel=1e-14)
    assert float(found.radius_min[0]) == pytest.approx(size - 0.075, rel=1e-13)
    assert float(found.radius_max[0]) == pytest.approx(size + 0.075, rel=1e-13)


@pytest.mark.parametrize(("kappa", "kind"), [(0.0, "synchronous"), (1.0, "contact_free")])
def test_a_rotor_that_does_not_turn_comes_to_rest(kappa, kind):
    rotor = Rotor(omega=0.0, zeta=0.2, delta0=1.0, shaft_stiffness=kappa, load=0.3)
    found = basin_fractions(rotor, **PLANE, starts=8)
    assert found.kind.values.tolist() == [RESPONSE[kind]]
    assert found["count"].values.tolist() == [8]
    low = abs(rest(rotor)["y"].item())
    for name in ("amplitude", "radius_min", "radius_max"):
        assert float(found[name][0]) == pytest.approx(low, rel=1e-12)


def test_tori_are_one_kind_together():
    """A slight load makes one of the cycle at (2, 0.07, 2), whose period is no whole revolution."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, load=0.05)
    found = basin_fractions(rotor, x=3.0, y=0.0, vx=(-0.1, 0.1), starts=2, rtol=1e-6)
    assert found.kind.values.tolist() == [RESPONSE["quasi_periodic"]]
    assert 1.5 < float(found.radius_min[0]) < 2.0 < float(found.radius_max[0]) < 4.5
    told = found.response_fraction.sel(response=RESPONSE["quasi_periodic"])
    assert float(told) == 1.0


def test_without_friction_no_kind_is_told_that_cannot_be():
    found = basin_fractions(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=(-9, 9), y=0.0, starts=5)
    assert RESPONSE["rolling"] not in found.response.values


def test_a_load_of_a_machine_is_refused_in_newtons():
    machine = DimensionalRotor(
        mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6,
        speed=1000.0, load=5.0,
    )  # fmt: skip
    with pytest.raises(
        InputError,
        match=r"^load must be 0 for .* where basin_fractions .*, got 5 N; load 0 .* out$",
    ):
        continue_attractors(machine, speed=[900.0], x=(-1e-6, 1e-6), y=(-1e-6, 1e-6))


@pytest.mark.parametrize(
    ("compute", "given", "words"),
    [
        (
            basin,
            {"contact_damping": 60.0},
            "contact_damping must be at most 50 for a basin, got 60.0",
        ),
        (
            basin_fractions,
            {"omega": 0.0, "load": 0.3, "friction": 0.2, "disc_radius": 1.0},
            "omega must be above 0",
        ),
    ],
)
def test_a_rotor_that_cannot_be_labelled_is_refused_in_one_line(compute, given, words):
    rotor = Rotor(**{"omega": 1.7, "zeta": 0.07, "delta0": 2.0} | given)
    with pytest.raises(InputError, match=rf"^{words}") as refused:
        compute(rotor, x=[0.0, 1.0], y=[0.0, 1.0])
    assert "\n" not in str(refused.value)
