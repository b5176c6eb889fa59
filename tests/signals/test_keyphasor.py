"""Pulses of motions that are known in closed form, whole, lost and too many."""

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, orders
from rotor_ida.signals.keyphasor import (
    angles_by_pulses,
    check_pulses,
    counts_between,
    with_lost_pulses,
)
from rotor_ida.signals.teeth import teeth_in


def pulses_in(times, signal):
    """Return the pulses of one mark on the shaft."""
    return teeth_in(times, signal, 1, fill=False).times


# The mark passes the keyphasor after 0.3 of a revolution first.
TURNS = 0.3 + np.arange(30)


def start_from_rest(turns):
    """Constant torque: theta = t**2/2."""
    return np.sqrt(2.0 * turns)


def coast_to_rest(turns):
    """Constant friction."""
    return -np.sqrt(2.0 * (turns[-1] + 0.4 - turns))


def stop_and_restart(turns, pause=10.0):
    """Friction to rest after 15.5 turns, a pause, and a start at the same torque."""
    left = 15.5 - turns
    return np.where(
        left > 0.0, -np.sqrt(np.maximum(left, 0.0)), pause + np.sqrt(np.maximum(-left, 0.0))
    )


def viscous_coast(turns):
    """Speed that falls exponentially."""
    return -np.log(1.0 - turns / (turns[-1] + 0.7))


def lathe(turns):
    """Constant speed, of which the readings scatter by a hundredth."""
    return turns + 0.01 * np.random.default_rng(2).normal(size=turns.size)


MOTIONS = (start_from_rest, coast_to_rest, stop_and_restart, viscous_coast, lathe)
LOST = [(), (1,), (2,), (3,), (9,), (9, 10), (9, 11), (12, 13), (20, 24), (26,)]


@pytest.mark.parametrize(
    ("motion", "lost"),
    [
        *((motion, lost) for motion in MOTIONS for lost in LOST),
        *(
            (motion, lost)
            for motion in (start_from_rest, coast_to_rest)
            for lost in ((1, 2), (28,))
        ),
    ],
)
def test_lost_pulses_are_counted_where_they_are(motion, lost):
    kept = np.setdiff1d(np.arange(TURNS.size), lost)
    np.testing.assert_array_equal(counts_between(motion(TURNS)[kept]), np.diff(kept))


@pytest.mark.parametrize("pause", [0.0, 0.1, 1.0, 1000.0])
def test_a_rest_of_any_length_is_no_lost_pulse(pause):
    check_pulses(stop_and_restart(TURNS, pause))


def test_the_message_says_where_and_how_many():
    with pytest.raises(
        InputError, match=r"must not lose pulses, but does after t 9, 19, 29 and 1 more place: 2 in"
    ):
        check_pulses(np.delete(np.arange(50.0), [10, 11, 20, 30, 40]))
    for extra in (5.1, 5.5, 5.9):
        with pytest.raises(InputError, match=r"not have extra pulses, .* after t 5"):
            check_pulses(np.sort(np.append(np.arange(20.0), extra)))
    with pytest.raises(InputError, match="at least 3 pulses, got 2"):
        check_pulses(np.arange(2.0))
    with pytest.raises(InputError, match="increase, but not after 1"):
        check_pulses(np.array([0.0, 1.0, 1.0, 2.0]))


@pytest.mark.parametrize("motion", [start_from_rest, coast_to_rest])
@pytest.mark.parametrize("lost", [(2,), (9, 10), (12, 14, 17)], ids=str)
def test_pulses_filled_in_are_those_of_the_motion(motion, lost):
    """A spline through the pulses is exact where the torque is constant."""
    pulses = motion(TURNS)
    np.testing.assert_allclose(with_lost_pulses(np.delete(pulses, lost)), pulses, atol=1e-4)


def test_the_angle_never_falls_while_the_machine_stands_still():
    pulses = stop_and_restart(TURNS)
    times = np.linspace(pulses[0], pulses[-1], 4001)
    within, angles = angles_by_pulses(pulses, times, 1)
    assert within.all()
    assert (np.diff(angles) >= 0.0).all()
    exact = np.interp(times, pulses, 2.0 * np.pi * np.arange(30))
    assert np.abs(angles - exact).max() < 2.0 * np.pi


@pytest.mark.parametrize("marks", [1, 60])
def test_marks_on_a_wheel_give_the_speed_of_the_shaft(marks):
    """A whirl once a revolution has the order 1 however many marks pass."""
    times = np.arange(8000) / 2000.0
    whirl = 0.7 * np.exp(1j * (20.0 * np.pi * times - 0.4))
    signals = xr.Dataset(
        {
            "x": ("t", whirl.real),
            "y": ("t", whirl.imag),
            "keyphasor": ("pulse", np.arange(40 * marks) / (10.0 * marks)),
        },
        {"t": times},
        {"pulses_per_revolution": marks},
    )
    found = orders(signals)
    np.testing.assert_allclose(found.speed, 20.0 * np.pi, rtol=1e-9)
    np.testing.assert_allclose(found.forward_phase_lag, 0.4, rtol=1e-9)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("part", [0.02, 0.2])
def test_a_sampled_pulse_is_found_to_a_fraction_of_a_sample(sense, part):
    times = np.arange(20000) / 20000.0
    phase = (50.3 * times + 0.5) % 1.0
    # a rise as long as four samples, as behind a filter
    rise = 4 * 50.3 / 20000.0
    height = np.interp(phase, [0.0, part, part + rise, 1.0 - rise, 1.0], [1, 1, 0, 0, 1])
    found = pulses_in(times, -18.0 + sense * 5.0 * height)
    exact = (np.arange(1, 51) - 0.5 - rise / 2.0) / 50.3
    np.testing.assert_allclose(found, exact, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_pulses_between_two_samples_are_put_on_a_smooth_course(seed):
    """A run-up to 100 revolutions a second at 2000 samples: 20 of them in a revolution, at last."""
    times = np.arange(40_001) / 2000.0
    turns = 2.5 * (times + 0.4) ** 2 + 0.1 * seed
    found = pulses_in(times, 5.0 * (turns % 1.0 < 0.1))
    whole = np.arange(np.ceil(turns[0]), np.floor(turns[-1]) + 1)
    exact = np.sqrt((whole - 0.1 * seed) / 2.5) - 0.4
    seen = (np.searchsorted(times, exact) - 0.5) / 2000.0
    fast = exact > 4.0
    before, after = (2000.0 * np.std((each - exact)[fast]) for each in (seen, found))
    assert before > 0.28  # of a step: an even scatter has 0.289
    assert after < 0.08
    # and from pulse to pulse it is smooth
    rough = [np.std(np.diff(each - exact, 2)[fast[2:]]) for each in (seen, found)]
    assert rough[1] < 0.05 * rough[0]


def test_a_course_that_is_no_polynomial_is_kept():
    """The speed swings by 10 % within 8 revolutions, which a cubic through 17 pulses would miss."""
    times = np.arange(40_001) / 2000.0
    turns = 20.0 * times + 0.127 * np.sin(2.0 * np.pi * 2.5 * times)
    found = pulses_in(times, 5.0 * (turns % 1.0 < 0.1))
    exact = np.interp(np.arange(1.0, found.size + 1.0), turns, times)
    assert 2000.0 * np.abs(found - exact).max() < 0.9
