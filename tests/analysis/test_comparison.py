"""Comparison: each response on the branch it is on, and on none where it is on none."""

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, compare, save, simulate, sweep, synchronous_response
from rotor_ida.analysis.comparison import summarise
from rotor_ida.parameters import Rotor
from rotor_ida.schema import EXACT, RESPONSE, STABILITY

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


def test_simulated_responses_agree_to_eight_digits_with_a_whirl_or_a_cycle():
    """delta0 = 0: on the curve from rest. delta0 = 1: on a cycle (DESIGN, section 3)."""
    rows = summarise(compare(sweep(**AXES)))
    assert [row["delta0"] for row in rows] == [0.0, 1.0]
    assert (rows[0]["on_whirl"], rows[0]["on_cycle"]) == (1, 0)
    assert (rows[1]["on_whirl"], rows[1]["on_cycle"]) == (0, 1)
    assert rows[1]["full_contact"] == 0  # those that lie on nothing
    for row in rows:
        assert row["median_digits"] >= row["fewest_digits"] > 8.0


@pytest.fixture(scope="module")
def periodic():
    """From rest to the two known cycles of DESIGN 9, by CVODE; and a whirl beside them."""
    return sweep(omega=[2.0, 3.0], zeta=0.07, delta0=[0.5, 2.0], starts=[(3.0, 1.0, 0.0, 0.0)])


def at(compared, omega, delta0):
    return compared.sel(omega=omega, delta0=delta0).squeeze()


@pytest.mark.parametrize(("omega", "delta0", "period"), [(2.0, 2.0, 4.563916675380),
                                                         (3.0, 0.5, 3.115214254929)])  # fmt: skip
def test_a_periodic_response_stands_beside_its_exact_cycle(periodic, omega, delta0, period):
    point = at(compare(periodic), omega, delta0)
    assert point["lies_on"].item() == EXACT["cycle"]
    assert point["matched_branch"].item() == -1
    assert point["exact_period"].item() == pytest.approx(period, abs=1e-11)
    assert point["cycle_stability"].item() == STABILITY["stable"]
    assert point["period"].item() == at(periodic, omega, delta0)["period"].item()
    off = max(
        abs(point["period"].item() / period - 1.0),
        abs(point["radius_max"].item() / point["exact_radius_max"].item() - 1.0),
        abs(point["radius_min"].item() - point["exact_radius_min"].item())
        / point["exact_radius_max"].item(),
    )
    assert point["digits"].item() > 8.0
    assert point["digits"].item() == pytest.approx(-np.log10(off), abs=0.3)


@pytest.mark.parametrize("name", ["period", "radius_min", "radius_max"])
def test_the_simulated_numbers_decide_not_newtons_method(periodic, name):
    """A simulated number that is off by 1e-7 costs digits; one by 1e-3 is on nothing."""
    for part, on, digits in ((1e-7, EXACT["cycle"], 7.0), (1e-3, EXACT["nothing"], np.nan)):
        changed = periodic.assign({name: periodic[name] * (1.0 + part)})
        point = at(compare(changed), 2.0, 2.0)
        assert point["lies_on"].item() == on
        # the smallest radius counts as a part of the largest
        assert point["digits"].item() == pytest.approx(digits, abs=0.4, nan_ok=True)


@pytest.mark.parametrize("lacking", [["period"], ["radius_min"], ["end_x"]])
def test_sweeps_of_older_versions_without_what_cycles_need_lie_on_whirls_alone(periodic, lacking):
    compared = compare(periodic.drop_vars(lacking))
    assert (compared["lies_on"] != EXACT["cycle"]).all()
    assert np.isnan(compared["exact_period"]).all()
    whirls = compare(periodic)["lies_on"] == EXACT["whirl"]
    assert ((compared["lies_on"] == EXACT["whirl"]) == whirls).all()


def test_a_state_that_leads_nowhere_lies_on_nothing(periodic):
    """Newton's method fails from it: no error, and no other point is the worse for it."""
    ends = periodic["end_x"].copy()
    ends.loc[{"omega": 2.0, "delta0": 2.0}] = 80.0
    compared = compare(periodic.assign(end_x=ends))
    assert at(compared, 2.0, 2.0)["lies_on"].item() == EXACT["nothing"]
    assert np.isnan(at(compared, 2.0, 2.0)["exact_period"])
    assert at(compared, 3.0, 0.5)["lies_on"].item() == EXACT["cycle"]


def test_a_sweep_is_compared_with_no_solver_installed(periodic, tmp_path):
    """STYLE 13: comparison computes closed forms, and cycles by Taylor series."""
    path = save(periodic, tmp_path / "sweep.nc")
    program = (
        "import sys; sys.modules['sksundae'] = None\n"
        "from rotor_ida import compare, load\n"
        "compared = compare(load(sys.argv[1]))\n"
        "print(int((compared.lies_on == 2).sum()), float(compared.digits.min()) > 8.0)\n"
    )
    ran = subprocess.run(
        [sys.executable, "-c", program, path], capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stderr
    expected = int((compare(periodic)["lies_on"] == EXACT["cycle"]).sum())
    assert ran.stdout.split() == [str(expected), "True"]


def test_a_run_is_not_a_sweep():
    run = simulate(Rotor(omega=1.0, zeta=0.1, delta0=1.0), start=(0, 0, 0, 0), duration=1.0)
    with pytest.raises(InputError, match="it lacks response, amplitude, phase_lag"):
        compare(run)
    with pytest.raises(InputError, match="dataset must be a Dataset, got"):
        compare("run.nc")
