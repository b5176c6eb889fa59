"""Starts side by side: each is followed as if it were alone, and told as soon as it is certain."""

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.basins.crossings import SECTION
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED, follow
from rotor_ida.basins.known import known_from_closed_forms
from rotor_ida.basins.lanes import LANES
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

NOTHING = np.array([0.0, 0.0, -1.0, -1.0])
GO_ON = np.zeros(1, dtype=np.uint8)


def followed(rotor, states, *, regions=None, free=NOTHING, duration, tolerance=1e-6, stop=GO_ON):
    states = states.copy()
    labels = np.full(states.shape[1], NOT_COMPUTED, dtype=np.int16)
    times = np.zeros(states.shape[1], dtype=np.float32)
    regions = np.empty((0, 14)) if regions is None else regions
    parameters = (rotor.omega, rotor.zeta, rotor.delta0 or None)
    none = np.empty((0, SECTION))
    follow(states, labels, times, parameters, regions, free, none, duration, tolerance, stop)
    return states, labels, times


def random_states(count, half_width=10.0, seed=0):
    return np.random.default_rng(seed).uniform(-half_width, half_width, (4, count))


@pytest.mark.parametrize("count", [1, LANES - 1, 5 * LANES + 3])
def test_a_start_does_not_depend_on_its_neighbours(count):
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
    whirls = known_from_closed_forms(rotor, GO_ON).tables()[0]
    states = random_states(count)
    _, labels, times = followed(rotor, states, regions=whirls, duration=500.0)
    assert (labels >= 0).all()
    for number in (0, count // 2, count - 1):
        alone = followed(rotor, states[:, [number]], regions=whirls, duration=500.0)
        assert alone[1][0] == labels[number]
        assert alone[2][0] == times[number]


@pytest.mark.parametrize("delta0", [0.0, 0.5, 2.0])
def test_it_ends_where_cvode_ends(delta0):
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=delta0)
    states = random_states(8, half_width=5.0)
    ends, labels, times = followed(rotor, states, duration=5.0, tolerance=1e-9)
    assert (labels == UNDECIDED).all()
    for number in range(8):
        time = float(times[number])
        assert time >= 5.0
        end = run(rotor, tuple(states[:, number]), time, np.empty(0), Options()).end
        turn = np.exp(-1j * rotor.omega * time)
        found = complex(ends[0, number], ends[1, number])
        # the time itself is told in single precision
        assert abs(found - complex(end[0], end[1]) * turn) < 1e-5


def test_contact_free_starts_are_told_at_once_and_no_others():
    """A start is caught at time 0 exactly if flight keeps it inside the clearance for ever."""
    rotor = Rotor(omega=1.0, zeta=0.5, delta0=3.0)
    states = random_states(LANES, half_width=1.5)
    free = known_from_closed_forms(rotor, GO_ON).free
    _, labels, times = followed(rotor, states, free=free, duration=0.5)
    at_once = (labels == 0) & (times == 0.0)
    assert 10 < at_once.sum() < LANES - 10
    for number in range(0, LANES, 4):
        orbit = run(rotor, tuple(states[:, number]), 100.0, np.empty(0), Options())
        if at_once[number]:
            assert orbit.event_times.size == 0
            assert not orbit.starts_in_contact
    whirl = -rotor.omega / complex(rotor.omega, -2.0 * rotor.zeta)
    position, velocity = states[0] + 1j * states[1], states[2] + 1j * states[3]
    drift = (velocity - 1j * rotor.omega * whirl) / (2.0 * rotor.zeta)
    centre = position - whirl
    farthest = np.maximum(np.abs(centre), np.abs(centre + drift)) + abs(whirl)
    np.testing.assert_array_equal(at_once, farthest <= rotor.delta0)


def test_it_stops_when_told():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
    stop = np.ones(1, dtype=np.uint8)
    _, labels, _ = followed(rotor, random_states(200), duration=1e6, stop=stop)
    assert (labels == NOT_COMPUTED).all()
