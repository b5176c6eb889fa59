"""Long runs stay where they are: the direction of a contact is kept on the unit circle."""

import numpy as np
import pytest

from rotor_ida import Rotor, simulate
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

# Full contact: one contact for ever, on a limit cycle whose radius is known to ten digits.
ROTOR, START = Rotor(omega=3.0, zeta=0.07, delta0=0.5), (3.0, 1.0, 0.0, 0.0)
LARGEST = 3.0002221257862


# Before it was, these errors were 9.4e-7, 2.1e-5 and 1.2e-4 after 6,000 time units.
@pytest.mark.parametrize(("method", "most"), [("taylor", 2e-8), ("adams", 5e-6), ("bdf", 1e-5)])
def test_a_cycle_keeps_its_radius_however_long_it_is_followed(method, most):
    options = Options(method=method, rtol=1e-6, atol=1e-8)
    orbit = run(ROTOR, START, 6050.0, np.empty(0), options, extrema=True)
    times, radii = orbit.extrema["time"], orbit.extrema["radius"]
    errors = [
        np.abs(radii[(times > begin) & (times < begin + 50.0)].max() - LARGEST)
        for begin in (1000.0, 6000.0)
    ]
    assert max(errors) < most


@pytest.mark.parametrize("method", ["taylor", "adams"])
def test_what_is_determined_is_said_to_be(method):
    """Its events have errors, and the horizon is its end: nothing parts the two runs."""
    found = simulate(ROTOR, start=START, duration=3000.0, samples=301, rtol=1e-8, method=method)
    assert found.horizon == 3000.0
    late = np.hypot(found.x, found.y).values[100:]
    assert late.max() <= LARGEST + 1e-6
