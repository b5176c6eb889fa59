"""Comparison: each response on the branch it is on, and on none where it is on none."""

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, compare, decode_flags, save, simulate, sweep, synchronous_response
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import EXACT, RESPONSE, STABILITY
from rotor_ida.verification.compare import summarise

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


@pytest.mark.parametrize(("kind", "factor"), [("synchronous", 1.6), ("bouncing", 1.0)])
def test_a_whirl_between_branches_and_what_is_no_whirl_are_on_none(kind, factor):
    exact = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).isel(branch=0)
    compared = compare(invented(kind, factor * exact.amplitude.item(), exact.phase_lag.item()))
    assert compared.matched_branch.item() == -1
    assert np.isnan(compared.digits.item())


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
    assert min(row["fewest_digits"] for row in rows) > 8.0
    assert rows[1]["full_contact"] == 0  # nothing is left that lies on nothing


def test_a_periodic_response_lies_beside_its_exact_cycle():
    """The two cycles of DESIGN section 9: CVODE's numbers against Newton's, and against those."""
    for omega, delta0, period, radius in (
        (2.0, 2.0, 4.563916675380, 4.104416607),
        (3.0, 0.5, 3.115214254929, 3.000222126),
    ):
        starts = [(3.0, 1.0, 0.0, 0.0)]
        compared = compare(sweep(omega=omega, zeta=0.07, delta0=delta0, starts=starts)).squeeze()
        assert compared.lies_on.item() == EXACT["cycle"]
        assert compared.exact_period.item() == pytest.approx(period, abs=1e-11)
        assert compared.exact_radius_max.item() == pytest.approx(radius, abs=1e-9)
        assert compared.cycle_stability.item() == STABILITY["stable"]
        off = abs(compared.period.item() - compared.exact_period.item())
        assert 0.0 < off < 1e-9  # the simulated number is not Newton's
        assert compared.digits.item() > 9.0
        assert compared.matched_branch.item() == -1


def test_a_sweep_without_periods_is_held_against_whirls_alone():
    swept = sweep(omega=3.0, zeta=0.07, delta0=0.5, starts=[(3.0, 1.0, 0.0, 0.0)])
    compared = compare(swept.drop_vars("period"))
    assert compared.lies_on.item() == EXACT["nothing"]
    assert np.isnan(compared.exact_period.item())
    assert np.isnan(compared.digits.item())


def test_a_false_period_lies_on_nothing():
    swept = sweep(omega=3.0, zeta=0.07, delta0=0.5, starts=[(3.0, 1.0, 0.0, 0.0)])
    compared = compare(swept.assign(period=swept.period * (1.0 + 1e-4)))
    assert compared.lies_on.item() == EXACT["nothing"]
    assert compared.exact_period.item() == pytest.approx(3.115214254929, abs=1e-11)


def test_it_needs_no_solver(tmp_path):
    """A sweep on another machine may have no SUNDIALS: closed forms and Taylor series suffice."""
    save(sweep(omega=3.0, zeta=0.07, delta0=0.5, starts=[(3.0, 1.0, 0.0, 0.0)]), tmp_path / "s.nc")
    code = (
        "import sys; sys.modules['sksundae'] = None\n"
        "from rotor_ida import compare, load\n"
        "print(compare(load('s.nc')).lies_on.item())"
    )
    shown = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert shown.stdout.split() == ["2"]


def test_a_run_is_not_a_sweep():
    run = simulate(Rotor(omega=1.0, zeta=0.1, delta0=1.0), start=(0, 0, 0, 0), duration=1.0)
    with pytest.raises(InputError, match="it lacks response, amplitude, phase_lag"):
        compare(run)
    one = sweep(omega=[1.2, 1.4], zeta=0.5, delta0=0.5)
    with pytest.raises(InputError, match="got zeta as a single value: select with a list"):
        compare(one.squeeze())
    with pytest.raises(InputError, match="got words in response: give the result from before"):
        compare(decode_flags(one))
    with pytest.raises(InputError, match="dataset must be a Dataset, got"):
        compare("run.nc")


MACHINES = {
    "omega": [0.4, 1.7, 2.2, 3.0],
    "zeta": 0.1,
    "delta0": [0.5, 2.0],
    "shaft_stiffness": [0.0, 0.3],
    "contact_exponent": [1.5, 1.0],
    "contact_damping": 0.2,
}


@pytest.fixture(scope="module")
def of_machines():
    return compare(sweep(**MACHINES))


def test_responses_of_machines_lie_on_their_exact_whirls_and_cycles(of_machines):
    assert of_machines.exact_amplitude.dims == (
        *("omega", "zeta", "delta0", "shaft_stiffness", "contact_exponent", "branch"),
    )
    decided = of_machines.response.isin(
        [RESPONSE[kind] for kind in ("synchronous", "contact_free", "bouncing", "full_contact")]
    )
    assert decided.sum() > 25
    assert (of_machines.lies_on.values[decided.values] != EXACT["nothing"]).all()
    assert (of_machines.lies_on == EXACT["cycle"]).any()
    assert float(of_machines.digits.min()) > 7.5


def test_an_exact_whirl_of_a_machine_solves_its_equation(of_machines):
    """``A**2 ((kappa + f/A - q)**2 + 4 zeta**2 q) = q**2``, whatever the contact damping."""
    A, q = of_machines.exact_amplitude, of_machines.omega**2
    touching = of_machines.in_contact == 1
    force = np.maximum(A - of_machines.delta0, 0.0) ** of_machines.contact_exponent
    held = of_machines.shaft_stiffness + force / A - q
    left = A**2 * (held**2 + 0.04 * q) - q**2
    assert np.abs(left / q**2).where(touching).max() < 1e-10
    assert touching.sum() > 10


def under_load(omega, load, **beyond):
    """A sweep of one machine, whose response is that of a run, with the mean position."""
    rotor = Rotor(omega=omega, zeta=0.2, delta0=2.0, load=load, **beyond)
    turns, each = 4, 400
    period = 2.0 * np.pi / omega
    times = 40 * period + np.arange(turns * each) * period / each
    run = simulate(rotor, start=(0, 0, 0, 0), duration=44 * period, samples=times,
                   method="taylor")  # fmt: skip
    z = run.x.values + 1j * run.y.values
    whirl = np.mean(z * np.exp(-1j * omega * times))
    made = sweep(omega=[omega], zeta=[0.2], delta0=[2.0], **beyond).assign_coords(load=load)
    made["amplitude"][:] = abs(whirl)
    made["phase_lag"][:] = -np.angle(whirl)
    return made, np.mean(z)


def test_under_a_load_the_contact_free_whirl_of_a_shaft_is_moved_and_no_more():
    made, mean = under_load(0.5, 0.4, shaft_stiffness=0.8, contact_exponent=1.0)
    made["response"][:] = RESPONSE["contact_free"]
    compared = compare(made)
    assert compared.lies_on.item() == EXACT["whirl"]
    assert compared.digits.item() > 8.0
    assert compared.exact_offset.item() == pytest.approx(0.5)
    assert mean == pytest.approx(-1j * compared.exact_offset.item(), abs=1e-8)
    assert compared.attrs["comment"].startswith("under a load no whirl in contact is synchronous")


@pytest.mark.parametrize(
    "beyond", [{}, {"shaft_stiffness": 0.1}, {"shaft_stiffness": 0.3}], ids=str
)
def test_under_a_load_that_brings_it_to_the_ring_nothing_is_known_exactly(beyond):
    """Without a shaft, or where gamma/kappa + A_f is more than the clearance."""
    free = synchronous_response(omega=0.5, zeta=0.2, delta0=2.0, **beyond)
    made = sweep(omega=0.5, zeta=0.2, delta0=2.0, **beyond).assign_coords(load=0.5)
    compared = compare(made)
    assert free.in_contact.item() == 0
    assert (compared.lies_on == EXACT["nothing"]).all()
    assert np.isnan(compared.exact_amplitude.values).all()
    assert (compared.stability == STABILITY["absent"]).all()


def test_a_load_of_zero_beside_others_changes_nothing():
    plain = sweep(omega=0.5, zeta=0.2, delta0=2.0, shaft_stiffness=[0.3, 0.8])
    both = xr.concat([plain, plain], xr.Variable("load", [0.0, 0.2])).transpose(
        *("omega", "zeta", "delta0", "shaft_stiffness", "load"), ...
    )
    compared, alone = compare(both), compare(plain)
    np.testing.assert_array_equal(
        compared.exact_amplitude.sel(load=0.0).values, alone.exact_amplitude.values
    )
    np.testing.assert_array_equal(compared.digits.sel(load=0.0).values, alone.digits.values)


def test_a_rotor_that_does_not_turn_is_held_against_its_rest():
    rotor = Rotor(omega=0.0, zeta=0.3, delta0=1.0, load=0.5, shaft_stiffness=0.2)
    run = simulate(rotor, start=(0, 0, 0, 0), duration=400.0, method="taylor")
    made = sweep(omega=0.0, zeta=0.3, delta0=1.0, shaft_stiffness=0.2).assign_coords(load=0.5)
    made["response"][:] = RESPONSE["synchronous"]
    made["radius_max"][:] = -run.y.values[-1]
    compared = compare(made)
    assert compared.lies_on.item() == EXACT["whirl"]
    assert compared.digits.item() > 8.0
    assert (compared.in_contact.item(), compared.exact_offset.item()) == (
        1,
        pytest.approx(-run.y.values[-1], abs=1e-9),
    )


def test_a_sweep_under_a_load_lies_on_what_is_exact_there():
    """At rest on the ring or on the shaft, and whirling about where the shaft holds it."""
    swept = sweep(
        omega=[0.0, 0.5, 2.0], zeta=0.2, delta0=2.0, shaft_stiffness=[0.0, 0.8], load=[0.0, 0.4],
        method="taylor",
    )  # fmt: skip
    loaded = compare(swept).sel(load=0.4)
    held = loaded.sel(shaft_stiffness=0.8)
    assert (held.lies_on == EXACT["whirl"]).all()
    assert (held.exact_offset.dropna("branch").values == 0.5).all()
    on_the_ring = loaded.sel(omega=0.0, shaft_stiffness=0.0)
    assert on_the_ring.lies_on.item() == EXACT["whirl"]
    assert on_the_ring.exact_offset.max().item() == pytest.approx(2.0 + 0.4 ** (2.0 / 3.0))
    turning = loaded.sel(omega=[0.5, 2.0], shaft_stiffness=0.0)
    assert (turning.lies_on == EXACT["cycle"]).all()
    revolutions = turning.exact_period * turning.omega / (2.0 * np.pi)
    np.testing.assert_allclose(revolutions, np.round(revolutions), rtol=1e-14)
    assert np.isnan(turning.exact_amplitude.values).all()
    assert float(loaded.digits.min()) > 9.0
