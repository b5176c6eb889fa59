"""Runs by Taylor series; their coefficients and steps are tested with the core."""

import numpy as np
import pytest

from rotor_ida import Rotor, simulate
from rotor_ida.closed_forms import planar_period
from rotor_ida.model.equations import energy


def test_planar_vibration_through_the_centre_keeps_its_period():
    """Without clearance the force is not smooth at the centre."""
    period = planar_period(3.0)
    run = simulate(
        Rotor(omega=0.0, zeta=0.0, delta0=0.0), start=(3.0, 0.0, 0.0, 0.0),
        duration=10.0 * period, samples=11, method="taylor", rtol=1e-15, atol=1e-17,
    )  # fmt: skip
    np.testing.assert_allclose(run.x, 3.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(run.vx, 0.0, rtol=0, atol=1e-11)


@pytest.mark.parametrize("miss", [1e-3, 1e-6, 1e-9, 1e-12, 0.0])
def test_passing_close_to_the_centre_conserves_energy_and_moment(miss):
    run = simulate(
        Rotor(omega=0.0, zeta=0.0, delta0=0.0), start=(2.0, 0.0, 0.0, miss), duration=50.0,
        samples=101, method="taylor", rtol=1e-14, atol=1e-17,
    )  # fmt: skip
    states = np.stack([run[name] for name in ("x", "y", "vx", "vy")], axis=-1)
    energies = energy(states, 0.0)
    np.testing.assert_allclose(energies, energies[0], rtol=2e-12)
    moments = run.x * run.vy - run.y * run.vx
    np.testing.assert_allclose(moments, 2.0 * miss, rtol=1e-10, atol=0.0)
