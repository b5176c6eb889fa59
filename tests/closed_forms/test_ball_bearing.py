"""The stiffness of ball bearings: against Harris' form of Hertz, approximations, and by scaling."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from rotor_ida import InputError, ball_bearing_stiffness
from rotor_ida.closed_forms.ball_bearing import point_contact_stiffness

GIVEN = {"ball_diameter": 12.7e-3, "pitch_diameter": 65e-3, "balls": 9}


@pytest.mark.parametrize("ratio", [1.5, 5.0, 80.0])
def test_point_contacts_agree_with_harris(ratio):
    """d = d* (3 Q/(2 s E'))^(2/3) s/2, with the integrals by quadrature and kappa from F(rho)."""

    def integrals(axes):
        def inside(angle):
            return 1.0 - (1.0 - axes**-2) * math.sin(angle) ** 2

        return [quad(lambda a, p=power: inside(a) ** p, 0.0, math.pi / 2.0, epsabs=1e-13)[0]
                for power in (-0.5, 0.5)]  # fmt: skip

    def excess(axes):
        first, second = integrals(axes)
        found = ((axes**2 + 1.0) * second - 2.0 * first) / ((axes**2 - 1.0) * second)
        return found - (ratio - 1.0) / (ratio + 1.0)

    axes, total = brentq(excess, 1.01, 100.0, xtol=1e-12), ratio + 1.0
    first, second = integrals(axes)
    star = 2.0 * first / math.pi * (math.pi / (2.0 * axes**2 * second)) ** (1.0 / 3.0)
    expected = (star * total / 2.0) ** -1.5 * 2.0 * total / 3.0
    np.testing.assert_allclose(point_contact_stiffness(ratio, 1.0, 1.0), expected, rtol=1e-9)


def test_the_stiffness_has_its_dimension():
    """K grows with the modulus, and with the root of the size."""
    stiffness = ball_bearing_stiffness(**GIVEN)
    larger = {name: 4.0 * each for name, each in GIVEN.items() if name != "balls"}
    np.testing.assert_allclose(ball_bearing_stiffness(**larger, balls=9), 2.0 * stiffness)
    softer = ball_bearing_stiffness(**GIVEN, youngs_modulus=1.04e11)
    np.testing.assert_allclose(softer, 0.5 * stiffness)
    np.testing.assert_allclose(
        ball_bearing_stiffness(**GIVEN | {"balls": 18}), 2.0 * stiffness, rtol=1e-14
    )


def test_the_share_of_the_balls_is_the_mean_of_a_sum_over_many():
    angles = 2.0 * math.pi * (np.arange(10_000) + 0.5) / 10_000
    share = (np.maximum(np.cos(angles), 0.0) ** 2.5).mean()
    alone = ball_bearing_stiffness(**GIVEN | {"balls": 1})
    inner, outer = (
        point_contact_stiffness((2.0 + 2.0 * sign * g / (1.0 - sign * g)) / 12.7e-3,
                                (2.0 - 1.0 / osculation) / 12.7e-3, 2.08e11 / 2.0 / 0.91)
        for g in [12.7 / 65.0] for sign, osculation in ((1.0, 0.52), (-1.0, 0.53))
    )  # fmt: skip
    one_ball = (inner ** (-2.0 / 3.0) + outer ** (-2.0 / 3.0)) ** -1.5
    np.testing.assert_allclose(alone, share * one_ball, rtol=1e-6)


@pytest.mark.parametrize(
    "change",
    [{"inner_osculation": 0.5}, {"contact_angle": 1.6}, {"pitch_diameter": 12e-3}, {"balls": 0}],
)
def test_bearings_that_cannot_be_are_refused(change):
    with pytest.raises(InputError):
        ball_bearing_stiffness(**GIVEN | change)
