"""Smallest shocks: exact ones are found, witnesses hold under CVODE, none is below the bound."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    DimensionalRotor,
    Rotor,
    continue_attractors,
    limit_cycle,
    simulate,
    synchronous_response,
    touchdown_report,
)
from rotor_ida.basins.atlas import resilience
from rotor_ida.basins.atlas.shocks import CHANGES, KINDS, Blows, Effort, bound_of_whirl, try_shocks
from rotor_ida.basins.trapping_regions import trapping_regions
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.schema import END, RESPONSE
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import settle_disc
from tests.basins.atlas.reports import BOX, WIDE, of_kind
from tests.basins.lanes import WHIP

BOUNCER = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
TWO_WHIRLS = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
STATE = ("x", "y", "vx", "vy")
FEW = Effort(rounds=6, leading=2, neighbours=4, turns=2)


@pytest.fixture(scope="module")
def bouncing():
    return touchdown_report(BOUNCER, **BOX, starts=300, shocks=2048)


@pytest.fixture(scope="module")
def whirling():
    return touchdown_report(TWO_WHIRLS, **BOX, starts=300, shocks=2048)


def states_of(report, kind, when):
    names = [f"{kind}_shock_{when}_{name}" for name in STATE]
    return np.stack([report[name].values for name in names], axis=-1)


def found_in(report, kind):
    return np.argwhere(np.isfinite(report[f"{kind}_shock"].values)).tolist()


@pytest.mark.parametrize("kind", KINDS)
def test_a_straight_border_is_met_where_it_is_nearest(kind):
    """From states on a circle of radius 1 to beyond a line at the distance 3: by 2, no less."""
    first = KINDS[kind]

    def source(places):
        angle = 2.0 * np.pi * places[0]
        states = np.zeros((4, angle.size))
        states[first], states[first + 1] = np.cos(angle), np.sin(angle)
        return states

    def ends(states):
        along = states[first] * math.cos(1.0) + states[first + 1] * math.sin(1.0)
        return (along > 3.0).astype(np.int16)

    tried, scatter = try_shocks(Blows(source, CHANGES[kind], ends), 0, (1e-3, 50.0), 512, seed=0)
    (best,) = tried.smallest(1, (0.0,))
    assert 2.0 <= tried.sizes[best] < 2.0 * 1.0005
    assert 0.0 <= scatter[1] < 1e-3
    change = tried.after[:, best] - tried.before[:, best]
    assert np.linalg.norm(change) == pytest.approx(tried.sizes[best])
    np.testing.assert_array_equal(change[[2 - first, 3 - first]], 0.0)


def test_of_two_borders_the_nearer_is_found_though_it_is_narrow():
    """A strip a hundredth of all directions wide comes within 1, all else within 2."""

    def ends(states):
        size, angle = np.hypot(states[2], states[3]), np.arctan2(states[3], states[2])
        narrow = np.abs(angle - 0.7) < 0.01 * np.pi
        return (size > np.where(narrow, 1.0, 2.0)).astype(np.int16)

    blows = Blows(lambda places: np.zeros((4, places.shape[1])), CHANGES["velocity"], ends)
    tried, _ = try_shocks(blows, 0, (1e-3, 50.0), 4096, seed=0)
    assert 1.0 <= tried.sizes[tried.smallest(1, (0.0,))[0]] < 1.01


def test_from_whatever_draw_the_search_comes_to_the_same_shocks(monkeypatch):
    """At omega 2, zeta 0.07, delta0 2, few drawn: 1.0762 ends the bouncing, however they fall."""
    found = []
    true_search = resilience.try_shocks
    for seed in range(2):
        monkeypatch.setattr(
            resilience,
            "try_shocks",
            lambda *given, seed, more=seed, **how: true_search(
                *given, seed=seed + 1000 * more, **how
            ),
        )
        report = touchdown_report(BOUNCER, x=(-8, 8), y=(-8, 8), starts=64, shocks=512)
        found.append([report[f"{kind}_shock"].values for kind in KINDS])
        scatter = report.velocity_shock_scatter.values
        assert (scatter[np.isfinite(scatter)] < 0.2).all()
        np.testing.assert_array_equal(np.isnan(scatter), np.isnan(report.velocity_shock.values))
    known = np.array(found)[:, np.isfinite(found[0])]
    assert (known.max(axis=0) < 1.002 * known.min(axis=0)).all()
    assert found[0][0][1, 0] == pytest.approx(1.0762, rel=2e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_the_bound_of_a_whirl_is_the_largest_circle_in_its_region(kind):
    for region in trapping_regions(TWO_WHIRLS):
        bound, angle = bound_of_whirl(region, kind), np.linspace(0.0, 2.0 * np.pi, 721)
        shocks = np.zeros((angle.size, 4))
        shocks[:, KINDS[kind]], shocks[:, KINDS[kind] + 1] = np.cos(angle), np.sin(angle)
        assert region.holds(region.centre + (1.0 - 1e-9) * bound * shocks).all()
        assert not region.holds(region.centre + 1.001 * bound * shocks).all()


@pytest.mark.parametrize("name", ["bouncing", "whirling"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_witness_is_a_shock_and_is_not_below_the_bound(name, kind, request):
    report = request.getfixturevalue(name)
    before, after = (states_of(report, kind, when) for when in ("before", "after"))
    first = KINDS[kind]
    pairs = found_in(report, kind)
    assert pairs
    for one, to in pairs:
        change = after[one, to] - before[one, to]
        size = float(report[f"{kind}_shock"][one, to])
        assert np.linalg.norm(change) == pytest.approx(size)
        np.testing.assert_array_equal(change[[2 - first, 3 - first]], 0.0)
        assert size >= float(report[f"{kind}_shock_bound"][one])
        assert size <= float(report[f"{kind}_shock_largest"])
        assert one != to


@pytest.mark.parametrize("kind", KINDS)
def test_a_witness_leads_there_by_cvode(bouncing, kind):
    """A run from the state after the shock ends on the target, far from where it began.

    Touches on the way to a contact-free whirl fade so slowly that no bound on the radius tells them
    from a bounce after any time one would wait; the law by which they fade does.
    """
    after = states_of(bouncing, kind, "after")
    for one, to in found_in(bouncing, kind):
        settled = settle_disc(BOUNCER, tuple(after[one, to].tolist()), Options())
        if int(bouncing["kind"][to]) == RESPONSE["bouncing"]:
            assert settled.kind == "bouncing"
            assert settled.features.radius_max == pytest.approx(float(bouncing.radius_max[to]))
        else:
            assert settled.kind in {"contact_free", "touching"}


def test_before_the_shock_it_is_on_the_attractor(bouncing):
    cycle = limit_cycle(BOUNCER, start=(0, 0, 0, 0))
    along = np.stack([cycle[name].values for name in STATE], axis=-1)
    number = int(np.flatnonzero(bouncing.kind == RESPONSE["bouncing"])[0])
    before = states_of(bouncing, "velocity", "before")[number]
    for state in before[np.isfinite(before).all(axis=1)]:
        assert np.linalg.norm(along - state, axis=1).min() < 0.02


@pytest.mark.parametrize("kind", KINDS)
def test_below_the_bound_cvode_comes_back(bouncing, kind):
    """Of a cycle the bound is an estimate: other phases and directions than it was made of."""
    number = int(np.flatnonzero(bouncing.kind == RESPONSE["bouncing"])[0])
    bound = float(bouncing[f"{kind}_shock_bound"][number])
    assert bound > 0.0
    random, cycle = np.random.default_rng(11), limit_cycle(BOUNCER, start=(0, 0, 0, 0))
    along = np.stack([cycle[name].values for name in STATE], axis=-1)
    for place in random.integers(len(along), size=10).tolist():
        angle, shocked = random.uniform(0.0, 2.0 * np.pi), along[place].copy()
        shocked[KINDS[kind]] += bound * math.cos(angle)
        shocked[KINDS[kind] + 1] += bound * math.sin(angle)
        settled = settle_disc(BOUNCER, tuple(shocked.tolist()), Options())
        assert settled.kind == "bouncing"
        assert settled.features.radius_max == pytest.approx(float(cycle.radius_max), rel=1e-5)


def test_what_fades_is_of_the_contact_free_family(bouncing):
    """Moves within it do not count: none of its members is thrown to another."""
    family = np.isin(bouncing.kind, [RESPONSE["contact_free"], RESPONSE["touching"]])
    for kind in KINDS:
        sizes = bouncing[f"{kind}_shock"].values
        assert np.isnan(sizes[np.ix_(family, family)]).all()
        assert np.ptp(sizes[np.ix_(family, ~family)], axis=0) == pytest.approx(0.0)


def test_an_atlas_has_them_by_number(whirling):
    asked = {"omega": [1.7, 1.75], "zeta": 0.07, "delta0": 0.0, **BOX, "starts": 300}
    found = continue_attractors(**asked, shocks=2048)
    here = found.sel(omega=1.7).squeeze()
    for name in ("velocity_shock", "displacement_shock"):
        np.testing.assert_array_equal(here[name].values, whirling[name].values)
    np.testing.assert_array_equal(here.omega_high, whirling.omega_high)
    assert here.omega_low_end.values.tolist() == whirling.omega_low_end.values.tolist()
    without = continue_attractors(**asked)
    assert "velocity_shock" not in without
    np.testing.assert_array_equal(without.basin_entropy, found.basin_entropy)


def test_a_machine_has_them_in_si_units(monkeypatch):
    """Lengths of a power of two divide without rounding: the two searches have the same starts."""
    monkeypatch.setattr(resilience.DiscSearch, "effort", FEW)
    length = 2.0**-20
    machine = DimensionalRotor(
        mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=length,
        clearance=2.0 * length, speed=1000.0,
    )  # fmt: skip
    ranges = {name: tuple(end * length for end in BOX[name]) for name in ("x", "y")}
    told = touchdown_report(machine, **ranges, starts=32, shocks=32)
    plain = touchdown_report(machine.rotor(), **BOX, starts=32, shocks=32)
    assert told.velocity_shock.attrs["units"] == "m s-1"
    assert told.displacement_shock.attrs["units"] == "m"
    np.testing.assert_allclose(
        told.velocity_shock, plain.velocity_shock * machine.velocity_scale, rtol=1e-12
    )
    np.testing.assert_allclose(told.displacement_shock, plain.displacement_shock * length)
    np.testing.assert_allclose(told.omega_low, plain.omega_low)


@pytest.mark.parametrize(("zeta", "kappa"), [(0.07, 0.25), (0.9, 0.25)])
def test_no_shock_below_the_bound_drives_a_held_whirl_to_the_ring(zeta, kappa, monkeypatch):
    """With little damping and with much; by CVODE, in twelve directions, just below it."""
    monkeypatch.setattr(resilience.DiscSearch, "effort", FEW)
    rotor = Rotor(omega=2.0, zeta=zeta, delta0=2.0, shaft_stiffness=kappa)
    report = touchdown_report(rotor, x=(-1, 1), y=(-1, 1), starts=16, shocks=64)
    row = of_kind(report, "contact_free")
    whirl = complex(complex_amplitude(2.0, zeta, kappa))
    for angle in np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False):
        aside = np.exp(1j * angle)
        for kind, place in (("displacement", 0), ("velocity", 1)):
            size = 0.999 * float(row[f"{kind}_shock_bound"])
            assert size > 0.0
            z, v = np.array([whirl, 2j * whirl]) + size * aside * np.eye(2)[place]
            run = simulate(rotor, start=(z.real, z.imag, v.real, v.imag), duration=60.0, samples=2)
            assert run.sizes["event"] == 0


def test_a_knock_into_whip_is_followed_there_and_the_bound_is_below_it(monkeypatch):
    """And friction at which the rub loses its stability, at a Hopf point, ends its extent."""
    rotor = replace(WHIP, delta0=0.9)
    monkeypatch.setattr(resilience.DiscSearch, "effort", FEW)
    report = touchdown_report(rotor, **WIDE, starts=10, shocks=32)
    rub, whip = of_kind(report, "synchronous"), of_kind(report, "rolling")
    target = int(whip.attractor)
    for kind in ("velocity", "displacement"):
        size = float(rub[f"{kind}_shock"].sel(target=target))
        assert 0.0 < float(rub[f"{kind}_shock_bound"]) < size
        told = [
            [float(rub[f"{kind}_shock_{when}_{name}"].sel(target=target)) for name in WIDE]
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
    stable = (around.stability == 1) & (around.in_contact == 1)
    assert stable.values.tolist() == [True, False]
