"""Basins with friction: lanes that slide forwards to rubs, and starts that end in dry whip."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

from rotor_ida import InputError, Rotor, basin, basin_fractions, limit_cycle, simulate, sweep
from rotor_ida.basins import kernel
from rotor_ida.basins.attractors import Attractor, leads_to
from rotor_ida.basins.basin import drawn_from
from rotor_ida.basins.cycle_sections import cycle_section
from rotor_ida.basins.fates import Batch, decide
from rotor_ida.basins.known import known_from_closed_forms
from rotor_ida.basins.trapping_regions import trapping_regions
from rotor_ida.cycles.limit_cycle import cycle_from
from rotor_ida.model.equations import push_over_radius, rotated, rotating_field
from rotor_ida.schema import RESPONSE, TRAPPING
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import follow_to_steady_state
from rotor_ida.verification.verify import rerun

WHIP = Rotor(omega=0.62962981, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
BOX = {"x": (-6, 6), "y": (-6, 6), "vx": (-6, 6), "vy": (-6, 6)}
GO_ON = np.zeros(1, np.uint8)
MACHINES = {
    "beside dry whip": WHIP,
    "that bounces": Rotor(omega=2.0, zeta=0.07, delta0=2.0, friction=0.1, disc_radius=10.0),
    "above resonance": Rotor(omega=1.7, zeta=0.07, delta0=0.5, friction=0.05, disc_radius=20.0),
    "shaft, linear contact, contact damping": Rotor(
        omega=1.2, zeta=0.1, delta0=0.5, shaft_stiffness=0.3, contact_exponent=1.0,
        contact_damping=0.5, friction=0.1, disc_radius=5.0,
    ),
    "slow, with a disc of no radius": Rotor(
        omega=0.3, zeta=1.5, delta0=0.05, friction=0.3, disc_radius=0.0
    ),
}  # fmt: skip
machines = pytest.mark.parametrize("rotor", MACHINES.values(), ids=MACHINES)


def slip_of(states, rotor):
    """Return the slip speed ``v_t + rho omega`` of states, shape (4, ...)."""
    x, y, u, v = states
    return (x * v - y * u) / np.hypot(x, y) + rotor.disc_radius * rotor.omega


def forwards(state, rotor):
    """Return the rate of a state on the rotating axes while the disc slides forwards."""
    drag = rotor.friction * push_over_radius(state, rotor)
    return rotating_field(state, rotor) + drag * np.array([0.0, 0.0, state[1], -state[0]])


def test_starts_end_in_dry_whip_or_on_the_rub_as_a_sweep_from_each_does():
    """By CVODE; rub and contact-free whirl come from closed forms, and whip is a limit cycle."""
    found = basin_fractions(WHIP, **BOX, starts=24, seed=1)
    starts = drawn_from(np.array(list(BOX.values()), float), 1, 0, 24).T
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
    found = basin_fractions(rotor, **BOX, starts=16)
    bounces = found.isel(attractor=found.kind.values == RESPONSE["bouncing"])
    assert bounces.sizes["attractor"] == 2
    assert bounces.confirmed.values.tolist() == [1, 1]
    starts = drawn_from(np.array(list(BOX.values()), float), 0, 0, 16).T
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


def test_of_two_kinds_of_whip_cvode_confirms_none_by_the_other():
    """What rolls with a period is no witness of what rolls without one."""
    start, options = np.array([5.0, 0.0, 0.0, -6.3]), Options()
    cycle = limit_cycle(WHIP, start=start)
    radii = (cycle.radius_min.item(), cycle.radius_max.item())
    periodic = Attractor("rolling", 0.278, 0.0, *radii, cycle.period.item())
    assert leads_to(WHIP, periodic, start, options)
    assert not leads_to(WHIP, replace(periodic, period=math.nan), start, options)
    assert not leads_to(WHIP, replace(periodic, period=1.001 * periodic.period), start, options)


def test_they_are_followed_again_and_a_study_goes_on(tmp_path):
    asked = {**BOX, "starts": 9, "study": tmp_path / "study"}
    found, again = basin_fractions(WHIP, **asked), basin_fractions(WHIP, **asked)
    assert found.attrs["labelling_method"] == "dop853"
    assert found.attrs["left_over_method"] == "taylor"
    assert found.attrs["friction"] == found.friction.item() == 0.2
    for name in ("count", "radius_max"):
        np.testing.assert_array_equal(found[name], again[name])
    xr.testing.assert_identical(rerun(found).drop_attrs(), found.drop_attrs())


def test_without_friction_no_kind_is_told_that_cannot_be():
    found = basin_fractions(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=(-9, 9), y=0.0, starts=5)
    assert RESPONSE["rolling"] not in found.response.values


@machines
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
        settled = follow_to_steady_state(rotor, tuple(start), alone)
        assert kinds[label] == settled.response
        if label >= known.first_cycle:
            cycle = cycles[label - known.first_cycle]
            assert settled.features.period == pytest.approx(cycle.period, rel=1e-6)
            assert settled.features.radius_max == pytest.approx(cycle.radius_max, rel=1e-6)
        if kinds[label] == "synchronous":
            assert settled.features.amplitude == pytest.approx(known.whirls[0].amplitude, rel=1e-6)


def test_a_grid_of_starts_is_labelled_as_they_are_one_by_one():
    axis = np.linspace(-6.0, 6.0, 9)
    found = basin(WHIP, x=axis, y=0.0, vx=0.0, vy=axis)
    starts = [(x, 0.0, 0.0, vy) for x in axis for vy in axis]
    alone = sweep(**WHIP.given, starts=starts, method="taylor").squeeze()
    np.testing.assert_array_equal(found.response.values.ravel(), alone.response)
    assert {RESPONSE["rolling"], RESPONSE["synchronous"]} <= set(alone.response.values.tolist())
    whirls = np.isin(found.kind.values, [RESPONSE["synchronous"], RESPONSE["contact_free"]])
    assert ((found.trapping.values == TRAPPING["proven"]) == whirls).all()
    assert found.agreement == 1.0


@machines
def test_a_step_of_the_lanes_is_one_of_the_model_that_slides_forwards(rotor):
    """To rounding, but for depths where the force has hardly begun, or contact damping ends it."""
    states = np.random.default_rng(0).normal(0.0, 3.0, (4, kernel.LANES))
    states[:2] *= np.geomspace(0.3, 1.5, kernel.LANES)
    ends = states.copy()
    labels, times = np.full(kernel.LANES, kernel.NOT_COMPUTED, np.int16), np.zeros(64, np.float32)
    nothing = np.empty(0, kernel.REGION), kernel.NO_CONTACT_FREE
    step, compared = 0.02, 0
    kernel.follow(
        ends, labels, times, rotor, *nothing, np.empty(0, kernel.SECTION), step, 1e3, GO_ON
    )
    for number, start in enumerate(states.T):
        exact = solve_ivp(
            lambda _, state: forwards(state, rotor), (0.0, step), start,
            method="DOP853", rtol=1e-13, atol=1e-13,
        ).y[:, -1]  # fmt: skip
        both = np.stack([start, exact], axis=1)
        depths = np.hypot(*both[:2]) - rotor.delta0
        touches = depths > 0.0
        slip = slip_of(both, rotor)
        if touches.any() and slip.min() <= 0.0:
            assert labels[number] == kernel.NOT_FORWARDS
        elif not touches.any() or slip.min() > abs(slip[1] - slip[0]):
            assert labels[number] == kernel.UNDECIDED
        pushes = [push_over_radius(state, rotor) > 0.0 for state in both.T]
        if (depths.max() < 0.0 or depths.min() > 0.1) and pushes[0] == pushes[1]:
            size = 1.0 + np.abs(start).max() ** 1.5
            np.testing.assert_allclose(ends[:, number], exact, rtol=0.0, atol=1e-12 * size)
            compared += 1
    assert compared > kernel.LANES // 2


@machines
def test_in_a_region_the_disc_slides_forwards_and_v_falls(rotor):
    """Of states all over it: nothing leaves it, as V falls, and no other force acts in it."""
    random = np.random.default_rng(3)
    for each in trapping_regions(rotor):
        assert each.exists
        directions = random.normal(size=(4, 500))
        directions /= np.linalg.norm(directions, axis=0)
        for scale in (1.0, 0.7, 0.3, 1e-3):
            inside = np.linalg.solve(np.linalg.cholesky(each.form).T, directions)
            states = each.centre[:, None] + scale * inside
            assert (np.hypot(*states[:2]) > rotor.delta0).all()
            assert (slip_of(states, rotor) > 0.0).all()
            for state in states.T:
                assert (state - each.centre) @ each.form @ forwards(state, rotor) < 0.0


def test_a_region_ends_where_the_disc_might_roll():
    """A slow disc of no radius would hold more if it could not: the region takes up the slip."""
    small = MACHINES["slow, with a disc of no radius"]
    large = Rotor(**small.given | {"disc_radius": 100.0})
    (bound,), (free,) = trapping_regions(small), trapping_regions(large)
    assert bound.amplitude == free.amplitude
    volumes = [np.linalg.det(each.form) ** -0.5 for each in (bound, free)]
    assert volumes[0] < 0.5 * volumes[1]
    # some state of what holds the large disc would slide backwards with the small one
    random = np.random.default_rng(3).normal(size=(4, 4000))
    random /= np.linalg.norm(random, axis=0)
    states = free.centre[:, None] + np.linalg.solve(np.linalg.cholesky(free.form).T, random)
    assert (slip_of(states, small) < 0.0).any()


@pytest.mark.parametrize("name", ["beside dry whip", "shaft, linear contact, contact damping"])
def test_no_orbit_leaves_a_region_and_all_converge(name):
    """CVODE from its boundary: inside at every sample, and no event."""
    rotor = MACHINES[name]
    (each,) = trapping_regions(rotor)
    random = np.random.default_rng(1).normal(size=(4, 4))
    random /= np.linalg.norm(random, axis=0)
    states = each.centre[:, None] + 0.999 * np.linalg.solve(np.linalg.cholesky(each.form).T, random)
    for state in states.T:
        run = simulate(rotor, start=state, duration=600.0, samples=2001)
        fixed = np.stack([run[component] for component in ("x", "y", "vx", "vy")], axis=-1)
        turning = rotated(fixed, -rotor.omega * run.t.values)
        assert run.sizes["event"] == 0
        assert each.holds(turning).all()
        assert np.linalg.norm(turning[-1] - each.centre) < 1e-3 * np.linalg.norm(
            state - each.centre
        )


@pytest.mark.parametrize(
    ("rotor", "words"),
    [
        (
            Rotor(omega=0.0, zeta=0.1, delta0=1.0, load=0.3, friction=0.2, disc_radius=1.0),
            "omega must be above 0",
        ),
    ],
)
def test_what_is_not_known_with_friction_is_refused_in_one_line(rotor, words):
    with pytest.raises(InputError, match=words) as refused:
        basin_fractions(rotor, **BOX)
    assert "\n" not in str(refused.value)


def test_a_cycle_that_slides_forwards_holds_what_comes_back_and_never_rolls():
    """By CVODE from all over the set: no `roll`, no `reverse`, and the radius of the cycle."""
    rotor = MACHINES["that bounces"]
    cycle = cycle_from(rotor, np.array([3.0, 1.0, 0.0, 0.0]))
    section = cycle_section(cycle, GO_ON)
    assert section.exists
    random = np.random.default_rng(2).normal(size=(3, 6))
    random *= 0.98 / np.linalg.norm(random, axis=0)
    for state in (section.centre[:, None] + np.linalg.pinv(section.form) @ random).T:
        run = simulate(rotor, start=state, duration=200.0, samples=40_001)
        assert set(run.event_kind.values.tolist()) <= {1, -1}
        largest = np.hypot(run.x, run.y)[-4000:].max()
        assert float(largest) == pytest.approx(cycle.radius_max, rel=1e-4)


def test_what_rolls_on_its_way_is_not_said_to_come_back():
    """States that come to roll are told by CVODE; without friction they would come back."""
    rotor = MACHINES["that bounces"]
    cycle = cycle_from(rotor, np.array([3.0, 1.0, 0.0, 0.0]))
    numbers = cycle_section(cycle, GO_ON).row
    speeds = np.append(np.linspace(-30.0, -21.0, 12), np.linspace(-3.0, 3.0, 12))
    states = np.stack([np.full(24, 3.0), np.zeros(24), np.zeros(24), speeds])
    values = np.empty(24)
    kernel.measure_returns(states, rotor, numbers, (0.0, 30.0 * cycle.period), 1e-10, values, GO_ON)
    first = []
    for state in states.T:
        run = simulate(rotor, start=state, duration=0.5 * cycle.period, samples=2)
        first.append(bool((np.abs(run.event_kind) > 1).any()))
    assert first == 12 * [True] + 12 * [False]
    assert np.isinf(values[np.array(first)]).all()
    assert np.isfinite(values[~np.array(first)]).any()


def test_dry_whip_has_no_section():
    assert not cycle_section(cycle_from(WHIP, np.array([5.0, 0.0, 0.0, -6.3])), GO_ON).exists


def test_touches_that_fade_are_held_on_the_rim_with_friction_too():
    """Elsewhere errors of many steps would carry them inside, to whirls that never touch."""
    rotor = Rotor(
        omega=2.972, zeta=0.28, delta0=1.0, contact_exponent=1.0, friction=0.026, disc_radius=20.0
    )
    starts = np.random.default_rng(0).uniform(-6.0, 6.0, (4, 40))
    known = known_from_closed_forms(rotor, GO_ON)
    labels = decide(Batch(known, starts, 1e-6, GO_ON)).labels
    alone = [
        follow_to_steady_state(rotor, tuple(each), Options(method="taylor", rtol=1e-11)).response
        for each in starts.T.tolist()
    ]
    fades = np.array([each == "touching" for each in alone])
    assert fades.sum() > 4
    assert (labels[fades] == known.fading_label).all()
    assert (labels[~fades] == known.free_label).all()
