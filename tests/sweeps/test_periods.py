"""Recurrence of section points, and the multiplier that says what a recurrence is worth."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.sweeps.periods import TurningPoints, extreme_radii, recurrence, slowest_multiplier
from rotor_ida.sweeps.steady_state import follow_to_steady_state

GO_ON = np.zeros(1, np.uint8)


def turns(highs, spacing=1.0, low=0.5):
    """Return maxima of the radius at these heights, each followed by the same minimum."""
    radii = np.stack([highs, np.full(len(highs), low)], axis=-1).ravel()
    states = np.zeros((radii.size, 4))
    states[:, 0] = radii
    times = 0.5 * spacing * np.arange(radii.size)
    return TurningPoints(times, states, np.arange(radii.size) % 2 == 0)


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


def test_no_maxima_no_period():
    nothing = TurningPoints(np.empty(0), np.empty((0, 4)), np.empty(0, dtype=bool))
    assert recurrence(nothing, 1e-8) is None


def test_extreme_radii_are_those_of_the_last_period():
    settling = turns(np.tile([2.0, 1.5], 4))
    settling.states[:6] *= 1.1
    assert extreme_radii(settling, 2.0) == (0.5, 2.0)


@pytest.mark.parametrize(
    ("omega", "delta0", "period", "expected"),
    [
        (2.0, 2.0, 4.563916675380, complex(-0.51147221, 0.51598781)),
        (3.0, 0.5, 3.115214254929, complex(0.53147652, 0.60337913)),
    ],
)
def test_multipliers_are_the_known_ones(omega, delta0, period, expected):
    """From DESIGN, section 9, where two programs that share nothing agree on them."""
    rotor = Rotor(omega=omega, zeta=0.07, delta0=delta0)
    settled = follow_to_steady_state(rotor, (0.0, 0.0, 0.0, 0.0), Options())
    found = slowest_multiplier(rotor, settled.end, period, GO_ON)
    assert complex(found.real, abs(found.imag)) == pytest.approx(expected, abs=1e-7)
    assert abs(found) == pytest.approx(math.exp(-0.07 * period), rel=1e-9)
