"""Features: extremes and mean of the motion as the simulator finds them."""

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.basins.features import MEAN_X, MEAN_Y, RADIUS_MAX, RADIUS_MIN, measure
from rotor_ida.simulation.options import Options
from rotor_ida.sweeps.steady_state import durations, follow_to_steady_state


@pytest.mark.parametrize(
    ("omega", "delta0", "start"),
    [(1.7, 0.0, (0, 0, 0, 0)), (2.0, 2.0, (0, 0, 0, 0)), (3.0, 0.5, (5, 0, 0, 0))],
)
def test_a_window_agrees_with_the_simulator(omega, delta0, start):
    rotor = Rotor(omega=omega, zeta=0.07, delta0=delta0)
    settled = follow_to_steady_state(rotor, start, Options())
    _, length, samples = durations(rotor)
    states = np.tile(np.array(settled.end)[:, None], 3)
    found = np.zeros((3, 5))
    parameters = (omega, 0.07, delta0 or None)
    measure(states, parameters, length / (samples - 1), samples - 1, found, np.zeros(1, np.uint8))
    window = settled.features
    # the classic method errs by about 1e-4 at sixty-four steps a revolution
    assert found[0, RADIUS_MIN] == pytest.approx(window.radius_min, rel=1e-3)
    assert found[0, RADIUS_MAX] == pytest.approx(window.radius_max, rel=1e-3)
    mean = np.hypot(found[0, MEAN_X], found[0, MEAN_Y])
    assert mean == pytest.approx(window.amplitude, rel=0.1)
    np.testing.assert_array_equal(found[0], found[2])
