"""Special points that lie close together: none is lost, wherever a branch begins."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, bifurcation_curve, continue_cycle, limit_cycle
from rotor_ida.cycles.special_points import Count, Way, specials_on
from rotor_ida.schema import SPECIAL

# The largest delta0 of the closed curve of doublings at zeta 0.07, and the cycle there, to some
# digits: state on the rotating axes and period. By `bifurcation_curve`, and checked by others.
TOP, OMEGA_AT_TOP = 4.598783730, 1.24993


def line(test, length=1.0, before=(-0.5,)):
    """A step on which every point is its own place, and a test function of it."""
    points = {place: place for place in (0.0, length, *before)}
    way = Way(points, length, lambda part, near: part, lambda part: None)
    found = specials_on(way, {"zero": test}, {})
    return [special.point for special in found], way


@pytest.mark.parametrize("depth", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("middle", [0.05, 0.3, 0.5, 0.98])
def test_two_zeros_within_a_step_are_found_however_close(depth, middle):
    """A parabola with a quartic part that dips below 0 by `depth`."""

    def test(place):
        return (place - middle) ** 2 + 2.0 * (place - middle) ** 4 - depth

    found, way = line(test)
    # w**2 + 2 w**4 = depth
    half = math.sqrt((math.sqrt(1.0 + 8.0 * depth) - 1.0) / 4.0)
    inside = [place for place in (middle - half, middle + half) if 0.0 <= place <= 1.0]
    assert found == pytest.approx(inside, abs=1e-9)
    assert len(way.points) < 60


@pytest.mark.parametrize("gap", [0.3, 1e-2, 1e-3])
def test_three_zeros_within_a_step_are_found(gap):
    zeros = [0.4 - gap, 0.4, 0.4 + 0.5 * gap]
    found, _ = line(lambda place: np.prod([place - zero for zero in zeros]) * 1e3)
    assert found == pytest.approx(zeros, abs=1e-9)


def test_what_turns_clear_of_zero_costs_no_look():
    _, way = line(lambda place: 3.0 + (place - 0.5) ** 2)
    assert sorted(way.points) == [-0.5, 0.0, 1.0]


def test_what_only_touches_zero_is_no_special_point():
    found, _ = line(lambda place: (place - 0.4) ** 2 - 1e-12)
    assert found == []


def test_beside_a_corner_zeros_are_found_as_well():
    """A count that changes at 0.3, where the test function bends like a root, as at a graze."""

    def test(place):
        hump = 6e-5 - 0.2 * (place - 0.6) ** 2
        return hump - 1e-3 * math.sqrt(max(0.3 - place, 0.0))

    count = Count(lambda place: int(place > 0.3), lambda place: place - 0.3)

    class Place(float):
        @property
        def orbit(self):
            return self

        @property
        def start(self):
            return np.array([1e9])

    way = Way(
        {each: Place(each) for each in (0.0, 1.0, -0.5)}, 1.0, lambda part, near: Place(part), Place
    )
    found = specials_on(way, {"zero": test}, {"graze": count})
    half = math.sqrt(6e-5 / 0.2)
    assert [each.name for each in found] == ["graze", "zero", "zero"]
    assert [float(each.point) for each in found[1:]] == pytest.approx(
        [0.6 - half, 0.6 + half], abs=1e-9
    )


@pytest.fixture(scope="module")
def top():
    """The doubling with the largest delta0 of the closed curve through that at delta0 2."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    branch = continue_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), limits=(1.7, 2.1))
    doubling = branch.special_kind.values.tolist().index(SPECIAL["period_doubling"])
    curve = bifurcation_curve(
        rotor, start=branch.isel(special=doubling), kind="period_doubling",
        limits=[(1.0, 2.2), (1.5, 6.0)],
    )  # fmt: skip
    return curve.isel(point=int(curve.delta0.values.argmax()))


@pytest.mark.parametrize("inside", [1e-3, 1e-4, 1e-5])
def test_both_doublings_near_the_top_of_their_curve_from_every_start(top, inside):
    state = [float(top[name]) for name in ("x", "y", "vx", "vy")]
    rotor = Rotor(omega=float(top.omega), zeta=0.07, delta0=TOP - inside)
    cycle = limit_cycle(rotor, start=state, period=float(top.period))
    whole = continue_cycle(rotor, start=cycle, limits=(1.0, 2.3))
    expected = np.sort(whole.special_value.values)
    assert whole.special_kind.values.tolist() == [SPECIAL["period_doubling"]] * 2
    # they lie on either side of the top, by the root of the distance from it
    assert expected.mean() == pytest.approx(OMEGA_AT_TOP, abs=1e-3)
    assert np.diff(expected)[0] == pytest.approx(0.931 * math.sqrt(inside), rel=0.01)
    for omega in (1.4, 1.7, 2.05):
        point = whole.isel(point=int(np.abs(whole.omega.values - omega).argmin()))
        again = continue_cycle(rotor, start=point, limits=(1.0, 2.3))
        np.testing.assert_allclose(np.sort(again.special_value.values), expected, rtol=1e-9)
