"""Runs of the core: what is written at their ends, and what of the radius must not be missed."""

import numpy as np
import pytest

from rotor_ida import Rotor, simulate, sweep
from rotor_ida.core.runs import RunRequest, fly, follow_run

BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
HOW = {"rtol": 1e-12, "atol": 1e-14}


@pytest.mark.parametrize("method", ["taylor", "adams"])
def test_a_run_that_ends_at_an_event_reports_its_end(method):
    """The time of a phase, added to that at which it began, may round to the end of the run."""
    rest = (0.0, 0.0, 0.0, 0.0)
    times = simulate(BOUNCING, start=rest, duration=60.0, method=method).event_time.values
    for time in np.concatenate([np.nextafter(times, 0.0), times, np.nextafter(times, 99.0)]):
        seen = follow_run(
            RunRequest(
                rotor=BOUNCING, start=rest, duration=float(time), method=method, events=True,
                sample_times=np.array([0.0, time]), **HOW,
            )
        )  # fmt: skip
        assert seen.samples.shape == (2, 4)
        np.testing.assert_allclose(seen.samples[1], seen.state, rtol=0.0, atol=1e-12)


def test_samples_are_as_many_as_the_run_came_to():
    stop = np.ones(1, np.uint8)
    times = np.linspace(0.0, 10.0, 11)
    asked = RunRequest(rotor=BOUNCING, start=(0, 0, 0, 0), duration=10.0, sample_times=times, **HOW)
    assert len(follow_run(asked).samples) == 11
    stopped = RunRequest(
        rotor=BOUNCING, start=(0, 0, 0, 0), duration=10.0, sample_times=times, stop=stop, **HOW
    )
    assert len(follow_run(stopped).samples) == 1


def test_two_extrema_of_a_flight_close_together_are_found():
    """Between two looks the radial rate comes to 0, passes it, and comes back."""
    rotor = Rotor(omega=3.325646323894685, zeta=0.0, delta0=50.0)
    # a whirl of radius 1 about a centre that drifts past the axis: r r' touches 0 now and then
    found = 0
    for speed in np.linspace(0.05, 1.5, 60):
        start = (-1.0 + 0.3, 0.4, 0.2 * speed, -rotor.omega + speed)
        seen = follow_run(RunRequest(rotor=rotor, start=start, duration=15.0, extrema=True, **HOW))
        times = np.linspace(0.0, 15.0, 60_001)
        x, y, vx, vy = fly(rotor, start, times).T
        rate = x * vx + y * vy
        turns = np.flatnonzero(rate[1:] * rate[:-1] < 0.0)
        assert len(seen.extrema) == turns.size
        assert (np.abs(seen.extrema["time"] - times[turns]) <= times[1]).all()
        found += turns.size
    assert found > 900


def test_the_pair_that_a_review_found_is_there():
    rotor = Rotor(omega=3.325646323894685, zeta=0.0, delta0=1.0173030142969024)
    seen = follow_run(
        RunRequest(rotor=rotor, start=(0, 0, 0, 0), duration=30.0, extrema=True, events=True, **HOW)
    )
    kinds = seen.extrema["kind"]
    assert (kinds[1:] != kinds[:-1]).all()


def test_columns_of_parameters_are_carried_by_taylor_series_alone():
    bundle = np.zeros((7, 4))
    asked = RunRequest(
        rotor=BOUNCING, start=(0, 0, 0, 0), duration=1.0, method="adams", bundle=bundle, **HOW
    )
    with pytest.raises(ValueError, match="must be carried by taylor, got 'adams'"):
        follow_run(asked)


def test_a_start_may_be_given_once_for_many_flights():
    start, spans = (0.3, 0.2, 0.1, -0.4), [0.5, 1.0, 2.0]
    together = fly(BOUNCING, start, spans)
    apart = [fly(BOUNCING, start, span)[0] for span in spans]
    np.testing.assert_array_equal(together, apart)


@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_a_sweep_by_ida_finds_its_turning_points_itself(rtol):
    """The reference takes tolerances that Taylor series do not."""
    swept = sweep(omega=[2.0], zeta=0.3, delta0=1.0, starts=[(6, 0, 0, 3)], method="ida", rtol=rtol)
    assert int(swept["status"].squeeze()) == 0
