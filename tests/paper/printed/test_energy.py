"""Eqs (9) and (13) as printed, beside what is conserved and what has a dimension."""

import numpy as np
import pytest

from rotor_ida import DimensionalRotor, Rotor, simulate
from rotor_ida.equations.model import energy
from rotor_ida.paper.printed import hamiltonian, reference_frequency


def test_printed_energy_is_not_conserved_and_the_right_one_is():
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=0.5)
    run = simulate(rotor, start=(2.0, 0.0, 0.3, 0.25), duration=40.0)
    states = np.stack([run[name] for name in ("x", "y", "vx", "vy")], axis=-1)
    right, printed = energy(states, 0.5), hamiltonian(states, 0.5)
    assert run.sizes["event"] > 4
    assert abs(right / right[0] - 1.0).max() < 1e-8
    assert printed.max() / printed.min() > 10.0


def test_printed_frequency_changes_with_the_unit_of_length():
    """k in N/mm^1.5 is smaller by 1000**1.5: a frequency would not notice."""
    metres = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=0.0, eccentricity=1e-6,
                              clearance=0.0, speed=1.0)  # fmt: skip
    # mass times length over time squared: in kg mm/s^2 a force is 1000 times as many
    millimetres = DimensionalRotor(mass=4.0, contact_stiffness=1e9 * 1000 / 1000**1.5,
                                   damping=0.0, eccentricity=1e-3, clearance=0.0,
                                   speed=1.0)  # fmt: skip
    assert millimetres.reference_frequency == pytest.approx(metres.reference_frequency)
    ratio = reference_frequency(millimetres) / reference_frequency(metres)
    assert ratio == pytest.approx(1000**-0.25)
