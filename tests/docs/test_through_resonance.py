"""The tutorial that brings a machine through resonance: what it says is so."""

import runpy
from pathlib import Path

import matplotlib
import numpy as np
import pytest

SCRIPT = Path(__file__).parents[2] / "docs" / "tutorial_scripts" / "through_resonance.py"


@pytest.fixture(scope="module")
def told():
    with matplotlib.rc_context():
        return runpy.run_path(str(SCRIPT))


def test_it_touches_below_the_critical_speed_and_comes_off_beyond_the_fold(told):
    first, last = told["up_to_speed"](3000).event_speed.values[[0, -1]]
    assert first < told["critical"] < told["fold"] < last


def test_a_faster_run_up_comes_off_later_and_is_in_contact_for_less_time(told):
    runs = [told["up_to_speed"](rate) for rate in (2000, 4000, 8000, 16_000)]
    assert np.all(np.diff([run.event_speed.values[-1] for run in runs]) > 0.0)
    touching = [float((run.exit_time - run.entry_time).sum()) for run in runs]
    assert np.all(np.diff(touching) < 0.0)


def test_the_weaker_motor_stays_where_its_torque_meets_that_of_the_exact_whirl(told):
    """The curves cross between two points of the curve; there both torques are linear."""
    weak, strong = (told["driven"][stall] for stall in (3.0, 6.0))
    omega, needed = told["omega"], told["needed"]
    left = 3.0 * (1.0 - omega / told["no_load"]) - needed
    place = np.flatnonzero(told["stable"] & (told["force"] > 0.0) & (left < 0.0))[0]
    ends = slice(place - 1, place + 1)
    crossing = np.interp(0.0, -left[ends], omega[ends]) / told["rpm"]
    assert float(weak.speed[-1]) == pytest.approx(crossing, rel=1e-3)
    assert int(weak.event_kind[-1]) == 1  # it entered, and is in contact
    assert float(strong.speed[-1]) > 11_000.0
    assert int(strong.event_kind[-1]) == -1
