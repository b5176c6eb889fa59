"""Comparison: each response on the branch it is on, and on none where it is on none."""

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, compare, simulate, sweep, synchronous_response
from rotor_ida.analysis.comparison import summarise
from rotor_ida.parameters import Rotor
from rotor_ida.schema import RESPONSE

AXES = {"omega": 1.7, "zeta": 0.07, "delta0": [0.0, 1.0]}


def invented(kind, amplitude, phase_lag):
    """A sweep of one point with a response made by hand."""
    dims = ("omega", "zeta", "delta0", "start", "direction")
    columns = {"response": np.int8(RESPONSE[kind]), "amplitude": amplitude, "phase_lag": phase_lag}
    coords = {"omega": [1.7], "zeta": [0.07], "delta0": [0.0]}
    return xr.Dataset({k: (dims, np.full((1,) * 5, v)) for k, v in columns.items()}, coords)


@pytest.mark.parametrize("branch", [0, 1, 2])
def test_each_exact_whirl_matches_itself(branch):
    exact = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).isel(branch=branch)
    compared = compare(
        invented("synchronous", exact.amplitude.item() * (1 + 1e-9), exact.phase_lag.item())
    )
    assert compared.matched_branch.item() == branch
    assert compared.amplitude_error.item() == pytest.approx(1e-9, rel=1e-5)
    assert compared.digits.item() == pytest.approx(9.0, abs=1e-4)
    assert compared.branch_amplitude_error.isel(branch=branch).item() == pytest.approx(
        1e-9, rel=1e-5
    )


def test_a_whirl_between_branches_is_on_none():
    compared = compare(invented("synchronous", 3.0, 1.0))
    assert compared.matched_branch.item() == -1
    assert np.isnan(compared.digits.item())


def test_a_bouncing_response_is_on_no_branch_even_where_its_amplitude_fits():
    exact = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).isel(branch=0)
    compared = compare(invented("bouncing", exact.amplitude.item(), exact.phase_lag.item()))
    assert compared.matched_branch.item() == -1


def test_phase_error_is_wrapped():
    exact = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).isel(branch=0)
    lag = exact.phase_lag.item() - 2 * np.pi + 1e-9
    compared = compare(invented("synchronous", exact.amplitude.item(), lag))
    assert compared.phase_error.item() == pytest.approx(1e-9, rel=1e-5)


def test_simulated_responses_agree_to_eight_digits_or_are_something_else():
    """delta0 = 0: on the curve from rest. delta0 = 1: not synchronous (DESIGN, section 3)."""
    rows = summarise(compare(sweep(**AXES)))
    assert [row["delta0"] for row in rows] == [0.0, 1.0]
    assert rows[0]["on_branch"] == 1
    assert rows[0]["fewest_digits"] > 8.0
    assert rows[1]["on_branch"] == 0
    assert rows[1]["full_contact"] == 1
    assert np.isnan(rows[1]["fewest_digits"])


def test_a_run_is_not_a_sweep():
    run = simulate(Rotor(omega=1.0, zeta=0.1, delta0=1.0), start=(0, 0, 0, 0), duration=1.0)
    with pytest.raises(InputError, match="it lacks response, amplitude, phase_lag"):
        compare(run)
    with pytest.raises(InputError, match="dataset must be a Dataset, got"):
        compare("run.nc")
