"""Turning points, their recurrence, and the multiplier that says what a recurrence is worth."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.core.runs import EXTREMUM
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.options import Options
from rotor_ida.steady.motion import turning_points
from rotor_ida.steady.periods import recurrence, recurrence_by_revolutions

DURATION = 30.0
METHODS = [Options(), Options(method="taylor"), Options(flight="cvode")]


def observed(rotor, start, options, step=0.05):
    """Return the motion from a start."""
    flow = DiscFlow(rotor, options=options)
    return flow.observed(np.array(start), np.arange(0.0, DURATION + step, step))


def found_in(rotor, start, options):
    """Return the turning points of the radius."""
    return turning_points(observed(rotor, start, options))


@pytest.mark.parametrize("options", METHODS)
def test_turning_points_of_a_free_whirl_are_known(options):
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
    np.testing.assert_allclose(found["time"], expected, rtol=0.0, atol=1e-11 if exact else 3e-9)
    np.testing.assert_allclose(found["radius"][found["kind"] > 0.0], abs(whirl) + 0.5, rtol=allowed)
    np.testing.assert_allclose(found["radius"][found["kind"] < 0.0], abs(whirl) - 0.5, rtol=allowed)


@pytest.mark.parametrize("options", METHODS)
@pytest.mark.parametrize(("omega", "delta0"), [(2.0, 2.0), (1.7, 0.0)])
def test_maxima_and_minima_of_a_simulated_motion_take_turns(omega, delta0, options):
    rotor = Rotor(omega=omega, zeta=0.07, delta0=delta0)
    found = found_in(rotor, (0.3, 0.2, 0.1, -0.4), options)
    assert (np.diff(found["time"]) > 0.0).all()
    assert (found["kind"][1:] == -found["kind"][:-1]).all()
    flow, times = DiscFlow(rotor, options=options), np.append(found["time"], DURATION)
    place, velocity = flow.observed(np.array([0.3, 0.2, 0.1, -0.4]), times).places[:, :-1]
    assert np.abs((place.conj() * velocity).real).max() < 1e-10


def test_a_constant_radius_has_no_turning_points():
    flow, state = DiscFlow(Rotor(omega=0.0, zeta=0.0, delta0=2.0)), np.array([1.2, 0.3, 0.0, 0.0])
    noise = np.array(3 * [(1.0, 1.2, 1.0, (1.2, 0.3, 0.0, 0.0))], EXTREMUM)
    still = replace(flow.observed(state, np.linspace(0.0, 5.0, 50)), extrema=noise)
    assert turning_points(still).size == 0


def turns(highs, spacing=1.0, low=0.5):
    """Return maxima of the radius at these heights, each followed by the same minimum."""
    radii = np.stack([highs, np.full(len(highs), low)], axis=-1).ravel()
    found = np.zeros(radii.size, EXTREMUM)
    found["time"], found["radius"] = 0.5 * spacing * np.arange(radii.size), radii
    found["state"][:, 0], found["kind"] = radii, 1.0 - 2.0 * (np.arange(radii.size) % 2)
    return found


@pytest.mark.parametrize(("pattern", "count"), [([2.0], 1), ([2.0, 1.5], 2), ([2, 2, 1.5], 3)])
def test_the_period_is_the_time_to_the_first_recurrence(pattern, count):
    found = recurrence(turns(np.tile(pattern, 6), spacing=0.7), 1e-8)
    assert found is not None
    assert found.period == pytest.approx(0.7 * count, rel=1e-14)
    assert found.missed_by == 0.0


def test_a_window_must_hold_three_periods():
    pattern = np.array([2.0, 1.5, 1.7, 1.2])
    assert recurrence(turns(np.tile(pattern, 2)), 1e-8) is None
    assert recurrence(turns(np.tile(pattern, 3)), 1e-8) is not None


def test_nothing_recurs_that_does_so_only_at_the_end():
    late = np.full(12, 2.0)
    late[0] = 2.0 + 1e-6
    assert recurrence(turns(late), 1e-8) is None
    assert recurrence(turns(late[1:]), 1e-8) is not None


def test_a_swing_near_the_tolerance_is_no_cycle():
    """The last of a spiral inwards differs little from turn to turn, but its swing is no more."""
    spiral = 2.0 + 1e-9 * 0.9 ** np.arange(12)
    assert recurrence(turns(spiral, low=2.0 - 1e-9), 1e-8) is None


def strobes(multiplier, size, count=40):
    """States once a revolution of a motion that comes to a fixed point by one multiplier."""
    states = np.zeros((count, 4))
    states[:, 0] = 1.0 + size * multiplier ** np.arange(count)
    return states


def test_what_comes_to_a_fixed_point_by_turns_is_not_told_as_one_of_two_revolutions():
    """It comes nearer to itself after two than after one, until it is too near for either."""
    for size in (1e-3, 1e-6, 1e-8):
        assert recurrence_by_revolutions(strobes(-0.999, size), 1.0, 1.0, 1e-8) is None
    found = recurrence_by_revolutions(strobes(-0.999, 1e-9), 1.0, 1.0, 1e-8)
    assert found is not None
    assert found.period == 1.0


def test_a_cycle_of_revolutions_needs_three_of_its_periods():
    for count in (1, 2, 3, 5):
        states = np.zeros((3 * count + 1, 4))
        states[:, 1] = np.arange(3 * count + 1) % count
        found = recurrence_by_revolutions(states, 0.5, 5.0, 1e-8)
        assert found is not None
        assert (found.period, found.missed_by) == (0.5 * count, 0.0)
        if count > 1:
            assert recurrence_by_revolutions(states[:-1], 0.5, 5.0, 1e-8) is None
