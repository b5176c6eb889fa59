"""The force field is the gradient of a convex potential."""

import numpy as np
import pytest

from rotor_ida import InputError
from rotor_ida.closed_forms import restoring_field

LINE = np.linspace(-3.0, 3.0, 121)


@pytest.fixture(scope="module")
def field():
    return restoring_field(x=LINE, y=LINE, delta0=[0.0, 0.5])


def test_potential_is_convex_and_flat_inside_the_clearance(field):
    for direction in ("x", "y"):
        assert float(field.potential.diff(direction).diff(direction).min()) > -1e-12
    inside = np.hypot(field.x, field.y) < 0.5
    assert float(field.potential.sel(delta0=0.5).where(inside).max()) == 0.0


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_force_of_a_machine_is_the_gradient_of_its_potential(exponent):
    law, step = {"shaft_stiffness": 0.4, "contact_exponent": exponent}, 1e-5
    places = LINE + 0.003  # off the ring, where the force of a linear contact has a corner
    ahead, behind = (
        restoring_field(x=places + s, y=LINE, delta0=[0.0, 0.5], **law).potential
        for s in (step, -step)
    )
    field = restoring_field(x=places, y=LINE, delta0=[0.0, 0.5], **law)
    slope = (ahead.values - behind.values) / (2.0 * step)
    np.testing.assert_allclose(slope, field.restoring_x, atol=2e-6)
    assert field.shaft_stiffness.item() == 0.4
    assert ("contact_exponent" in field.coords) == (exponent == 1.0)


def test_inside_the_clearance_the_shaft_alone_springs_back():
    field = restoring_field(x=0.25, y=[0.0, 0.125], delta0=0.5, shaft_stiffness=2.0)
    np.testing.assert_array_equal(field.restoring_x.values.ravel(), [0.5, 0.5])
    np.testing.assert_array_equal(field.restoring_y.values.ravel(), [0.0, 0.25])
    np.testing.assert_allclose(field.potential.values.ravel(), [0.0625, 0.078125], rtol=1e-15)
    with pytest.raises(InputError, match=r"contact_exponent must be 1\.5 or 1, got 2\.0"):
        restoring_field(x=0.0, y=0.0, delta0=0.0, contact_exponent=2.0)
