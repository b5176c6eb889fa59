"""Starts side by side: each is followed as if it were alone, and told as soon as it is certain."""

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.basins.kernel import (
    CONTACT_FREE,
    LANES,
    NO_CONTACT_FREE,
    NOT_COMPUTED,
    REGION,
    SECTION,
    UNDECIDED,
    follow,
    measure_returns,
)
from rotor_ida.basins.known import known_from_closed_forms
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

GO_ON = np.zeros(1, dtype=np.uint8)


def followed(
    rotor, states, *, regions=None, free=NO_CONTACT_FREE, duration, tolerance=1e-6, stop=GO_ON
):
    states = states.copy()
    labels = np.full(states.shape[1], NOT_COMPUTED, dtype=np.int16)
    times = np.zeros(states.shape[1], dtype=np.float32)
    regions = np.empty(0, REGION) if regions is None else regions
    none = np.empty(0, SECTION)
    follow(states, labels, times, rotor, regions, free, none, duration, tolerance, stop)
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


def test_contact_free_starts_are_told_at_once_and_no_others():
    """A start is caught at time 0 exactly if flight keeps it inside the clearance for ever."""
    rotor = Rotor(omega=1.0, zeta=0.5, delta0=3.0)
    states = random_states(LANES, half_width=1.5)
    free = known_from_closed_forms(rotor, GO_ON).tables()[1]
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


def test_nothing_is_followed_without_starts():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    _, labels, times = followed(rotor, np.empty((4, 0)), duration=10.0)
    assert labels.size == times.size == 0
    values = np.empty(0)
    measure_returns(np.empty((4, 0)), rotor, np.ones((), SECTION), (0.0, 1.0), 1e-6, values, GO_ON)


def test_starts_that_have_a_label_are_left_alone():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
    states = random_states(100)
    ends, labels, times = states.copy(), np.full(100, NOT_COMPUTED, np.int16), np.zeros(100, "f4")
    labels[::3] = 7
    none = np.empty(0, REGION), NO_CONTACT_FREE, np.empty(0, SECTION)
    follow(ends, labels, times, rotor, *none, 1.0, 1e-6, GO_ON)
    assert (labels[::3] == 7).all()
    assert (times[::3] == 0.0).all()
    np.testing.assert_array_equal(ends[:, ::3], states[:, ::3])
    assert (labels[1::3] == UNDECIDED).all()
    assert (times[1::3] >= 1.0).all()


WRONG = {
    "states": np.zeros((4, 9)),
    "labels": np.zeros((10, 1), np.int16),
    "times": np.zeros(9, np.float32),
    "regions": np.zeros((2, 1), REGION),
    "free": np.zeros(3, CONTACT_FREE),
    "sections": np.zeros((1, 2), SECTION),
    "stop": np.zeros(0, np.uint8),
}


@pytest.mark.parametrize("name", WRONG)
def test_arrays_of_another_shape_are_refused(name):
    right = {
        "states": np.zeros((4, 10)),
        "labels": np.zeros(10, np.int16),
        "times": np.zeros(10, np.float32),
        "rotor": Rotor(omega=1.7, zeta=0.07, delta0=0.5),
        "regions": np.zeros(0, REGION),
        "free": NO_CONTACT_FREE,
        "sections": np.zeros(0, SECTION),
        "duration": 1.0,
        "tolerance": 1e-6,
        "stop": GO_ON,
    }
    with pytest.raises(ValueError, match="must have the shape"):
        follow(**{**right, name: WRONG[name]})


@pytest.mark.parametrize(
    ("states", "section", "values"),
    [
        (np.zeros((4, 3)), np.zeros((), SECTION), np.zeros(4)),
        (np.zeros((3, 4)), np.zeros((), SECTION), np.zeros(4)),
        (np.zeros((4, 4)), np.zeros(1, SECTION), np.zeros(4)),
        (np.zeros((4, 4)), np.zeros((), SECTION), np.zeros((2, 2))),
    ],
)
def test_returns_of_arrays_of_another_shape_are_refused(states, section, values):
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    with pytest.raises(ValueError, match="must have the shape"):
        measure_returns(states, rotor, section, (0.0, 1.0), 1e-6, values, GO_ON)


def test_a_region_that_is_none_holds_nothing():
    """Nor does a section that is none measure anything."""
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    regions = np.full((1, 14), np.nan).view(REGION)[:, 0]
    _, labels, _ = followed(rotor, random_states(3), regions=regions, duration=1.0)
    assert (labels == UNDECIDED).all()
    values = np.empty(3)
    never = np.full(21, np.nan).view(SECTION).reshape(())
    measure_returns(random_states(3), rotor, never, (0.0, 1.0), 1e-6, values, GO_ON)
    assert np.isinf(values).all()
