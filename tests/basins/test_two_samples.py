"""The fractions of random starts by response do not depend on the sample."""

import numpy as np
import pytest

from rotor_ida import Rotor, basin_fractions

BOX = dict.fromkeys(("x", "y", "vx", "vy"), (-10.0, 10.0))


@pytest.mark.parametrize(("omega", "delta0"), [(1.7, 0.5), (2.0, 2.0), (3.0, 0.5)])
def test_two_samples_agree_within_four_standard_errors(omega, delta0):
    rotor = Rotor(omega=omega, zeta=0.07, delta0=delta0)
    one, other = (basin_fractions(rotor, **BOX, starts=600, seed=seed) for seed in (1, 2))
    difference = np.abs(one.response_fraction.values - other.response_fraction.values)
    error = np.hypot(one.response_fraction_error.values, other.response_fraction_error.values)
    assert (difference <= 4.0 * error + 1.0 / 600.0).all()
    assert one.response_fraction.values.sum() == pytest.approx(1.0)
