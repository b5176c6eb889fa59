"""Eq. (17) is the period of the circle, and not that of the line."""

import pytest

from rotor_ida.closed_forms import circular_period, planar_period
from rotor_ida.paper.printed import natural_frequency, period


@pytest.mark.parametrize("amplitude", [0.5, 2.0, 8.0])
def test_printed_period_is_right_on_a_circle_only(amplitude):
    assert period(amplitude) == pytest.approx(circular_period(amplitude), rel=1e-14)
    assert planar_period(amplitude) / period(amplitude) == pytest.approx(1.04746, abs=5e-6)


def test_frequency_grows_and_period_falls_with_the_amplitude():
    assert natural_frequency(8.0) > natural_frequency(2.0)
    assert period(8.0) == pytest.approx(3.73600, abs=5e-6)
    assert period(2.0) == pytest.approx(5.28351, abs=5e-6)
