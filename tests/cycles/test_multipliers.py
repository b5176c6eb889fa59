"""Multipliers from the trace, and the structure that this rests on, measured on M."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, limit_cycle
from rotor_ida.cycles.multipliers import FORM
from rotor_ida.cycles.orbit import followed
from rotor_ida.simulation.flow import DiscFlow
from tests.cycles.known import once_round


def test_a_period_that_damps_all_velocities_to_nothing_leaves_no_defect():
    """exp(-2 zeta T) is 0 in doubles: 0 = 0, no quotient of them."""
    rotor = Rotor(omega=1e-3, zeta=5.0, delta0=1.0)
    cycle = limit_cycle(rotor, start=(1.0 + 1e-13, 0.0, 0.0, 0.0), period=2.0 * np.pi / rotor.omega)
    assert cycle.symplectic_defect.item() == 0.0
    assert cycle.trivial_defect.item() < 1e-10


@pytest.mark.parametrize("rotor", [
    Rotor(omega=2.0, zeta=0.07, delta0=2.0), Rotor(omega=3.0, zeta=0.01, delta0=0.5),
    Rotor(omega=1.1, zeta=0.3, delta0=1.0), Rotor(omega=1.7, zeta=0.1, delta0=0.0),
])  # fmt: skip
def test_every_stretch_of_every_orbit_is_conformally_symplectic(rotor):
    """M^T S M = q S holds for any start and time, through entries and exits; not for cycles alone.

    Measured on both integrators.
    """
    generator = np.random.default_rng(5)
    for _ in range(2):
        start, duration = generator.uniform(-3.0, 3.0, 4), float(generator.uniform(2.0, 15.0))
        q = math.exp(-2.0 * rotor.zeta * duration)
        for matrix, allowed in (
            (followed(DiscFlow(rotor), start, duration).monodromy, 1e-13),
            (once_round(rotor, start, duration).monodromy, 1e-9),
        ):
            size = (np.abs(matrix).T @ np.abs(FORM) @ np.abs(matrix)).max()
            assert np.abs(matrix.T @ FORM @ matrix - q * FORM).max() < allowed * size
