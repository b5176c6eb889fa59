"""What knows the paper's rotor alone refuses any other in one line, and leaves nothing out."""

from __future__ import annotations

import pytest
import xarray as xr

import rotor_ida
from rotor_ida import DimensionalRotor, InputError, Rotor
from rotor_ida.paper.errata.scaling import check_scaling

REST = (0.0, 0.0, 0.0, 0.0)
PLAIN = {"omega": 1.2, "zeta": 0.5, "delta0": 0.5}
BEYOND = {
    "shaft_stiffness": 0.25, "contact_exponent": 1.0, "contact_damping": 0.5, "load": 0.125,
}  # fmt: skip
MACHINE = {
    "mass": 4.0, "contact_stiffness": 1e9, "damping": 280.0, "eccentricity": 1e-6,
    "clearance": 2e-6, "speed": 600.0,
}  # fmt: skip


def test_a_machine_with_more_is_refused():
    machine = DimensionalRotor(**MACHINE, load=39.2)
    with pytest.raises(InputError, match=r"^the rotor of check_scaling must be the paper's"):
        check_scaling(machine, duration=10.0)


def with_load(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result as one of a rotor with a load would be."""
    return dataset.assign_coords(load=0.125)


def test_a_cycle_of_a_rotor_with_more_is_no_start():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    cycle = rotor_ida.limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5)
    message = r"^start must be of the same rotor: its load is 0.125, that of the rotor 0.0$"
    with pytest.raises(InputError, match=message):
        rotor_ida.limit_cycle(rotor, start=with_load(cycle))
    with pytest.raises(InputError, match=message):
        rotor_ida.continue_cycle(rotor, start=with_load(cycle), limits=(1.5, 2.5))
