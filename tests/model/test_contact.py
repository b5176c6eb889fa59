"""The contact law: zero out of contact, continuous at it, and one law in all its forms."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from rotor_ida.model import contact
from rotor_ida.model.contact import slope_of_root, spring_of_root

lengths = st.floats(0.0, 50.0)


@given(lengths, lengths)
def test_no_force_inside_the_clearance(radius, delta0):
    inside = min(radius, delta0)
    assert contact.contact_force(inside, delta0) == 0.0
    assert contact.contact_potential(inside, delta0) == 0.0
    assert contact.force_over_radius(inside, delta0) == 0.0


@given(st.floats(0.01, 50.0), st.floats(1e-12, 1e-3))
def test_the_force_is_continuous_at_the_ring(delta0, depth):
    force = contact.contact_force(delta0 + depth, delta0)
    assert force == pytest.approx(depth**1.5, rel=1e-14 * delta0 / depth * 100 + 1e-12)


@given(st.floats(0.0, 20.0), st.floats(0.05, 20.0))
def test_stiffness_and_force_are_the_derivatives_of_force_and_potential(delta0, depth):
    radius, step = delta0 + depth, 1e-4 * depth
    up, down = radius + step, radius - step
    slope = (contact.contact_force(up, delta0) - contact.contact_force(down, delta0)) / (2 * step)
    push = (contact.contact_potential(up, delta0) - contact.contact_potential(down, delta0)) / (
        2 * step
    )
    assert contact.contact_stiffness(radius, delta0) == pytest.approx(slope, rel=1e-6)
    assert contact.contact_force(radius, delta0) == pytest.approx(push, rel=1e-6)


@given(st.floats(0.0, 20.0), st.floats(0.0, 20.0))
def test_the_scalar_kernels_say_what_the_arrays_say(delta0, depth):
    radius = delta0 + depth
    assert contact.force_over_radius(radius, delta0) == pytest.approx(
        float(contact.secant_stiffness(radius, delta0)), rel=1e-14, abs=1e-300
    )
    assert contact.stiffness(radius, delta0) == pytest.approx(
        float(contact.contact_stiffness(radius, delta0)), rel=1e-14
    )


@given(st.floats(0.0, 20.0), st.floats(0.0, 20.0), st.sampled_from([1.0, 1.5]))
def test_a_contact_may_be_linear(delta0, depth, exponent):
    """And the modes push by the same law, in terms of the root of the indentation."""
    radius, root = delta0 + depth, np.sqrt(depth)
    force = float(contact.contact_force(radius, delta0, exponent))
    indentation = float(contact.indentation(radius, delta0))
    assert force == pytest.approx(indentation**exponent, rel=1e-15)
    secant = contact.force_over_radius(radius, delta0, exponent)
    assert secant * radius == pytest.approx(force, rel=1e-14)
    law = SimpleNamespace(hertz=float(exponent == 1.5), linear=float(exponent == 1.0))
    assert spring_of_root(root, law) == pytest.approx(depth**exponent, rel=1e-14)
    root, step = 1.0 + root, 1e-4
    up, down = (spring_of_root(root + sign * step, law) for sign in (1.0, -1.0))
    # by the indentation q**2, of which 2 q is the slope by q
    slope = (up - down) / (4.0 * root * step)
    assert slope_of_root(root, law) == pytest.approx(slope, rel=1e-6)
    up, down = (contact.energy_of_root(root + sign * step, law) for sign in (1.0, -1.0))
    by_depth = (up - down) / (4.0 * root * step)
    assert spring_of_root(root, law) == pytest.approx(by_depth, rel=1e-6)


def test_labels_of_a_radius_are_those_of_its_force():
    radius = xr.DataArray([0.5, 1.5], coords={"omega": [1.0, 2.0]}, dims="omega")
    for function in (contact.contact_force, contact.contact_stiffness):
        assert function(radius, 0.5).sel(omega=1.0).item() == 0.0
