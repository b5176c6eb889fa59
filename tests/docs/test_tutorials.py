"""Two tutorials: their sentences are true of what they compute."""

import runpy
from pathlib import Path

import matplotlib
import numpy as np
import pytest

from rotor_ida.schema import RESPONSE

SCRIPTS = Path(__file__).parents[2] / "docs" / "tutorial_scripts"


def names_of(script):
    with matplotlib.rc_context():
        return runpy.run_path(str(SCRIPTS / f"{script}.py"))


@pytest.fixture(scope="module")
def measured():
    return names_of("measured_csv")


@pytest.fixture(scope="module")
def study():
    return names_of("own_study")


def test_the_measured_rotor_rubs_up_to_the_last_speed(measured):
    """The largest amplitude is that of the last window; 25 um is the clearance."""
    amplitude = measured["once"].values
    assert np.argmax(amplitude) == amplitude.size - 1
    assert amplitude[-1] > 25.0


def test_the_amplitude_measured_is_that_of_the_exact_whirl(measured):
    """On the run-up the amplitude lags by the rate; the large whirl at the last speed is stable."""
    exact = measured["exact"]
    scale = 1e6 * measured["machine"].length_scale
    of_speed = exact.omega.values.ravel() / measured["to_omega"]
    radius = exact.amplitude.values.ravel() * scale
    last = measured["rpm"][-1]
    near = radius[np.abs(of_speed - last) < 5.0]
    assert np.min(np.abs(near / measured["once"].values[-1] - 1.0)) < 0.02


def test_the_whirl_ratio_in_the_rub_is_one(measured):
    assert np.allclose(measured["ratio"], 1.0, rtol=0.0, atol=0.02)


def test_friction_ends_the_rub_earlier_and_leads_to_dry_whip(study):
    found = study["found"].squeeze()
    radius = found.radius_max.values
    ends = [study["speeds"][np.flatnonzero(column > 2.0)[-1]] for column in radius.T[:4]]
    assert np.all(np.diff(ends) <= 0.0)
    assert ends[3] < ends[0]
    kinds = found.response.values.T
    assert np.all(kinds[:3] == RESPONSE["synchronous"])
    assert {RESPONSE["full_contact"], RESPONSE["bouncing"], RESPONSE["rolling"]} <= set(kinds[3])
    assert np.all(kinds[4] == RESPONSE["rolling"])


def test_every_point_of_the_study_lies_on_an_exact_response(study):
    assert np.nanmin(study["digits"]) > 9
    assert np.isfinite(study["digits"]).all()
