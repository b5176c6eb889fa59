"""Flight on a ramp by error functions, against integrators, its limits and simulated run-ups."""

import numpy as np
import pytest

from rotor_ida import Rotor, run_up
from rotor_ida.closed_forms import flight, ramp_flight
from tests.witness import Disc, followed

START = (0.3, 0.1, 0.2, -0.1)
# Shaft, damping, first speed and rate: none, soft, stiff and overdamped, up and down.
RAMPS = [
    (0.0, 0.07, 0.2, 0.05), (0.0, 0.0, 0.2, 0.05), (1.0, 0.0, 0.4, 0.02), (1.0, 0.05, 0.2, 0.03),
    (1.0, 0.05, 2.0, -0.02), (0.04, 0.5, 0.1, 0.1), (2.0, 0.02, 3.0, -0.04),
]  # fmt: skip


@pytest.mark.parametrize(("kappa", "zeta", "omega", "rate"), RAMPS)
def test_it_is_the_motion_that_dop853_finds(kappa, zeta, omega, rate):
    times = np.linspace(0.0, 60.0, 41)
    rotor = Rotor(omega=omega, zeta=zeta, delta0=1e3, shaft_stiffness=kappa)
    exact = ramp_flight(times, rotor=rotor, start=START, rate=rate)
    found = followed([(60.0, Disc(rotor, rate))], START, omega, at=times).states[:, :4].T
    np.testing.assert_allclose(exact, found, rtol=0, atol=1e-9 * np.abs(found).max())


@pytest.mark.parametrize("method", ["taylor", "adams"])
@pytest.mark.parametrize(
    ("kappa", "omega", "to", "rate"),
    [(1.0, 0.4, 1.8, 0.02), (0.0, 0.2, 3.0, 0.05), (0.0, 3.0, 0.5, -0.02)],
)
def test_a_simulated_run_up_lies_on_it(kappa, omega, to, rate, method):
    rotor = Rotor(omega=omega, zeta=0.02, delta0=1e3, shaft_stiffness=kappa)
    found = run_up(rotor, start=START, to=to, rate=rate, samples=101, rtol=1e-12, method=method)
    assert found.sizes["event"] == 0
    exact = ramp_flight(found.t.values, rotor=rotor, start=START, rate=rate)
    motion = [found[name].values for name in ("x", "y", "vx", "vy")]
    np.testing.assert_allclose(motion, exact, rtol=0, atol=1e-10 if method == "taylor" else 1e-9)


@pytest.mark.parametrize("kappa", [0.0, 1.0])
def test_a_rate_that_falls_to_zero_leads_to_the_flight_at_one_speed(kappa):
    rotor = Rotor(omega=1.3, zeta=0.05, delta0=5.0, shaft_stiffness=kappa)
    times = np.linspace(0.0, 10.0, 11)
    steady = flight(times, rotor=rotor, start=START)
    off = [
        np.abs(ramp_flight(times, rotor=rotor, start=START, rate=rate) - steady).max()
        for rate in (1e-5, 1e-6)
    ]
    assert off[0] / off[1] == pytest.approx(10.0, rel=1e-2)
