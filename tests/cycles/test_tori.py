"""Torus points: where a pair of multipliers crosses the unit circle."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from rotor_ida import Rotor, bifurcation_curve, continue_cycle, limit_cycle
from rotor_ida.cycles.branch_course import stable_ranges
from rotor_ida.cycles.multipliers import NEAR_ZERO, doubling_test, fold_test, torus_test
from rotor_ida.cycles.orbit import followed
from rotor_ida.errors import InputError
from rotor_ida.schema import RESPONSE, SPECIAL
from rotor_ida.simulation.flow import DiscFlow
from tests.cycles.known import multipliers, once_round, specials, state_of

# A loaded shaft against a linear ring, in contact all the time: a torus is born over its damping.
LOADED = Rotor(
    omega=1.6, zeta=0.05, delta0=0.75, load=1.6, shaft_stiffness=1.0, contact_exponent=1.0
)
LIMITS = (0.3, 0.8)


@pytest.fixture(scope="module")
def branch():
    rotor = replace(LOADED, contact_damping=0.4)
    return continue_cycle(rotor, start=(0, -1, 0, 0), parameter="contact_damping", limits=LIMITS)


@pytest.fixture(scope="module")
def torus(branch):
    return specials(branch, "torus").squeeze("special")


def test_at_a_torus_point_a_pair_is_on_the_unit_circle(torus):
    """The multipliers are those of the variational equation along DOP853."""
    rotor = replace(LOADED, contact_damping=float(torus.special_value))
    flown = once_round(rotor, state_of(torus, "special_"), float(torus.special_period))
    np.testing.assert_allclose(flown.end, state_of(torus, "special_"), rtol=0.0, atol=1e-9)
    found = np.linalg.eigvals(flown.monodromy)
    pair = found[np.abs(found) > 0.5]
    assert pair.size == 2
    np.testing.assert_allclose(np.abs(pair), 1.0, rtol=0.0, atol=1e-8)
    assert np.abs(pair.imag).min() > 0.5


def test_before_it_motions_decay_and_behind_it_they_settle_on_a_torus(branch, torus):
    """Seen once a revolution: a point, or a closed curve round it that both sides come to."""
    for side, settles in ((-0.05, True), (0.05, False)):
        rotor = replace(LOADED, contact_damping=float(torus.special_value) + side)
        nearest = int(np.abs(branch.contact_damping.values - rotor.contact_damping).argmin())
        cycle = limit_cycle(rotor, start=branch.isel(point=nearest))
        centre = state_of(cycle)
        rings = []
        for kick in (1e-2, 1.5):
            start = centre + np.array([kick, 0.0, 0.0, 0.0])
            flow = DiscFlow(rotor)
            seen = flow.states(start, flow.revolution * np.arange(2500.0))
            rings.append(seen[-1000:] - centre)
        if settles:
            assert max(np.abs(ring).max() for ring in rings) < 1e-8
            continue
        # from inside and from outside the same closed curve: never near the cycle, one radius
        # to each direction about it
        radii = [np.linalg.norm(ring, axis=1) for ring in rings]
        assert [radius.min() for radius in radii] == pytest.approx([radii[0].min()] * 2, rel=1e-3)
        assert [radius.max() for radius in radii] == pytest.approx([radii[0].max()] * 2, rel=1e-3)
        assert radii[0].min() > 1.0
        order = np.argsort(np.arctan2(rings[0][:, 1], rings[0][:, 0]))
        assert np.abs(np.diff(radii[0][order])).max() < 0.05


def test_a_branch_is_stable_up_to_its_torus_point(branch, torus):
    assert stable_ranges(branch) == [(LIMITS[0], pytest.approx(float(torus.special_value)))]


def sizes(factors):
    """Return the product of the sizes of factors, where these are not small."""
    return np.prod(np.hypot(np.abs(factors), NEAR_ZERO))


def test_the_three_tests_are_products_over_the_multipliers():
    """With symmetric functions of three, and of four under a load (DESIGN section 9)."""
    for load in (0.0, 0.4):
        rotor = Rotor(omega=1.6, zeta=0.07, delta0=1.0, load=load, contact_damping=0.4)
        cycle = limit_cycle(rotor, start=(0, -1, 0, 0))
        shot = followed(DiscFlow(rotor), state_of(cycle), cycle.period.item())
        found = multipliers(cycle)
        if not load:
            found = np.delete(found, int(np.abs(found - 1.0).argmin()))
        e = [1.0, *(np.poly(found)[1:].real * (-1.0) ** np.arange(1, found.size + 1))]
        signs = (-1.0) ** np.arange(len(e))
        pairs = np.array([a * b for a, b in combinations(found, 2)])
        assert fold_test(shot) == pytest.approx(signs @ e / sizes(1.0 - found), rel=1e-9)
        assert doubling_test(shot) == pytest.approx(sum(e) / sizes(1.0 + found), rel=1e-9)
        if load:
            expected = (1 - e[2] + e[4]) * (1 - e[4]) ** 2 + (e[3] - e[1]) * (e[1] * e[4] - e[3])
        else:
            expected = 1.0 - e[2] + e[3] * (e[1] - e[3])
        assert torus_test(shot) == pytest.approx(expected / sizes(1.0 - pairs), rel=1e-8)


def test_torus_points_are_followed_over_damping_and_speed(torus):
    rotor = replace(LOADED, contact_damping=float(torus.special_value))
    curve = bifurcation_curve(
        rotor, start=torus, kind="torus",
        parameters=("contact_damping", "omega"), limits=((0.4, 0.8), (1.4, 1.7)),
    )  # fmt: skip
    found = multipliers(curve)
    pair = np.where(found.imag != 0.0, np.abs(np.abs(found) - 1.0), np.inf).min(axis=1)
    assert pair.max() < 1e-9
    assert curve.contact_damping.values.min() < 0.5
    place = curve.sizes["point"] // 3
    point = curve.isel(point=place)
    there = replace(LOADED, omega=float(point.omega), contact_damping=float(point.contact_damping))
    flown = once_round(there, state_of(point), float(point.period))
    assert np.abs(np.abs(np.linalg.eigvals(flown.monodromy)) - 1.0).min() < 1e-8


def test_two_real_multipliers_of_product_one_make_no_torus():
    """On a closed branch the test function passes 0 at a torus point and at a neutral saddle."""
    rotor = Rotor(omega=1.5, zeta=0.08, delta0=1.0, load=0.1, contact_damping=0.8)
    branch = continue_cycle(
        rotor, start=(0, -1, 0, 0), parameter="contact_damping", limits=(0.0, 3.0)
    )
    found = multipliers(branch)
    rows = [[1.0 - a * b for a, b in combinations(row, 2)] for row in found]
    products = np.prod(rows, axis=1).real
    changes = np.flatnonzero(products[1:] * products[:-1] < 0.0)
    kinds = branch.special_kind.values
    (place,) = branch.special_point.values[kinds == SPECIAL["torus"]].tolist()
    (other,) = set(changes.tolist()) - {place}
    assert np.isreal(found[other][:2]).all()
    assert found[other][:2].prod().real == pytest.approx(1.0, abs=0.1)


def test_none_is_born_without_contact_damping_friction_and_load():
    rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
    with pytest.raises(InputError, match="contact_damping, friction or load must be above 0"):
        bifurcation_curve(rotor, start=(3, 1, 0, 0), kind="torus", limits=((2.5, 3.2), (0.4, 0.6)))


@pytest.mark.parametrize(("side", "response"), [(-0.05, "full_contact"), (0.05, "quasi_periodic")])
def test_what_a_start_leads_to_is_a_cycle_before_it_and_a_torus_behind_it(torus, side, response):
    rotor = replace(LOADED, contact_damping=float(torus.special_value) + side)
    found = limit_cycle(rotor, start=(0.0, -1.0, 0.0, 0.0))
    assert found.response.item() == RESPONSE[response]
    assert np.isnan(found.period) == (response == "quasi_periodic")
