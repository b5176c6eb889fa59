"""Turning points: those of a motion known in closed form, of a simulated one, and of none."""

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run
from rotor_ida.sweeps.periods import turning_points

DURATION = 30.0
METHODS = [Options(), Options(method="taylor"), Options(flight="cvode")]


def found_in(rotor, start, options, step=0.05):
    orbit = run(rotor, start, DURATION, np.arange(0.0, DURATION, step), options, extrema=True)
    return turning_points(orbit.states, orbit.extrema)


@pytest.mark.parametrize("options", METHODS)
def test_of_a_free_whirl_they_are_known(options):
    """Round a centre off the axis |z| is largest and smallest once a revolution."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=3.0)
    whirl = -2.0 / (2.0 - 0.14j)
    z, v = whirl + 0.5j, 2.0j * whirl
    found = found_in(rotor, (z.real, z.imag, v.real, v.imag), options)
    expected = (np.angle(0.5j) - np.angle(whirl) + np.pi * np.arange(-9, 99)) / 2.0
    expected = expected[(expected > 0.0) & (expected < DURATION)]
    # where flight is integrated, to what its tolerance of 1e-10 leaves over 30 time units
    exact = options.flight == "exact"
    allowed = 1e-13 if exact else 3e-9
    np.testing.assert_allclose(found.times, expected, rtol=0.0, atol=1e-11 if exact else 3e-9)
    np.testing.assert_allclose(found.radii[found.are_maxima], abs(whirl) + 0.5, rtol=allowed)
    np.testing.assert_allclose(found.radii[~found.are_maxima], abs(whirl) - 0.5, rtol=allowed)


@pytest.mark.parametrize("options", METHODS)
@pytest.mark.parametrize(("omega", "delta0"), [(2.0, 2.0), (3.0, 0.5), (1.7, 0.0)])
def test_of_a_simulated_motion_maxima_and_minima_take_turns(omega, delta0, options):
    rotor = Rotor(omega=omega, zeta=0.07, delta0=delta0)
    found = found_in(rotor, (0.3, 0.2, 0.1, -0.4), options)
    assert (np.diff(found.times) > 0.0).all()
    assert (found.are_maxima[1:] != found.are_maxima[:-1]).all()
    again = run(rotor, (0.3, 0.2, 0.1, -0.4), DURATION, found.times, options)
    x, y, vx, vy = again.states.T
    assert np.abs(x * vx + y * vy).max() < 1e-10


def test_the_contacts_peak_there():
    """Peaks come from the contact phase itself, by another search."""
    rotor, start = Rotor(omega=2.0, zeta=0.07, delta0=2.0), (0.3, 0.2, 0.1, -0.4)
    peaks = run(rotor, start, DURATION, np.empty(0), Options()).contacts[:, 2:4]
    found = found_in(rotor, start, Options())
    for time, depth in peaks[:-1]:
        place = np.abs(found.times - time).argmin()
        assert found.times[place] == pytest.approx(time, abs=1e-9)
        assert found.radii[place] == pytest.approx(2.0 + depth, rel=1e-11)


@pytest.mark.parametrize("options", METHODS)
def test_through_the_centre_the_radius_is_smallest_where_it_vanishes(options):
    """Planar free vibration without clearance passes the centre, where |z| has a corner."""
    found = found_in(Rotor(omega=0.0, zeta=0.0, delta0=0.0), (1.0, 0.0, 0.0, 0.0), options)
    assert found.radii[~found.are_maxima].max() < 1e-9
    inner = found.radii[found.are_maxima][1:]
    np.testing.assert_allclose(inner, 1.0, rtol=1e-8)


def test_a_constant_radius_has_none():
    whirl = np.tile([1.2, 0.3, 0.0, 0.0], (50, 1))
    noise = np.tile([1.0, 1.2, 1.0, 1.2, 0.3, 0.0, 0.0], (3, 1))
    found = turning_points(whirl, noise)
    assert found.times.size == 0
