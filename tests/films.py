"""A beam on two bearings whose coefficients depend on the speed."""

from dataclasses import replace

import numpy as np

from rotor_ida import Bearing, Contact, Unbalance
from tests.axisymmetric_systems import beam

SPEEDS = np.array([150.0, 450.0, 900.0, 1500.0, 2400.0])


def table(cross, unequal=0.0):
    """Return the rows of an oil film: softer and less damped with the speed, and cross-coupled."""
    direct = 3e6 + 1.2e9 / SPEEDS
    stiffness = np.zeros((SPEEDS.size, 2, 2))
    stiffness[:, 0, 0], stiffness[:, 1, 1] = direct, direct * (1.0 + unequal)
    stiffness[:, 0, 1] = cross * SPEEDS
    stiffness[:, 1, 0] = -cross * SPEEDS
    return {"speed": SPEEDS, "stiffness": stiffness, "damping": 4e4 / np.sqrt(SPEEDS)}


def on_films(*, unequal=0.0, cross=300.0, friction=0.1, gap=3e-5, count=4):
    """Return the beam on two films, with a contact and unbalance at its discs."""
    plain = beam(count, soft=0.0)
    films = [Bearing(node=node, **table(cross, unequal)) for node in ("0", str(count))]
    first, second = str(count // 3), str(2 * count // 3 + 1)
    contact = Contact(node=first, clearance=gap, stiffness=5e6, exponent=1.0, friction=friction,
                      radius=0.05)  # fmt: skip
    unbalance = [Unbalance(node=first, moment=2e-4), Unbalance(node=second, moment=1e-4, phase=1.0)]
    return replace(plain, bearings=films, contacts=[contact], unbalance=unbalance)
