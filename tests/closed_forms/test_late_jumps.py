"""How slow run-ups and run-downs pass folds: coefficients, the law, and simulated ones."""

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, folds, run_up, synchronous_response
from rotor_ida.closed_forms import eigenvalues, late_jumps
from tests.witness import Disc

MACHINES = {
    "the paper's rotor": {"zeta": 0.07, "delta0": 1.0},
    "a shaft and a linear ring": {
        "zeta": 0.03, "delta0": 2.0, "shaft_stiffness": 0.05, "contact_exponent": 1.0,
    },
    "friction and contact damping": {
        "zeta": 0.07, "delta0": 1.0, "friction": 0.05, "contact_damping": 0.2,
    },
    "four folds": {"zeta": 0.07, "delta0": 0.5, "friction": 0.02},
}  # fmt: skip
AIRY = 2.338107410459767  # Abramowitz and Stegun, table 10.13


def whirl_at_fold(omega, amplitude, machine):
    """The displacement on the rotating axes, by the balance of forces."""
    force = (amplitude - machine["delta0"]) ** machine.get("contact_exponent", 1.5)
    restoring = (machine.get("shaft_stiffness", 0.0) - omega**2) * amplitude + force
    resisting = 2.0 * machine["zeta"] * omega * amplitude + machine.get("friction", 0.0) * force
    return amplitude * np.exp(-1j * np.arctan2(resisting, restoring))


def field(state, omega, machine):
    """The rates on the rotating axes of a disc that is a rigid body; the velocity on fixed ones."""
    radius = {"disc_radius": 10.0} if "friction" in machine else {}
    return Disc(Rotor(omega=omega, **machine, **radius)).turning([*state, omega])[:4]


def reduced(omega, amplitude, machine):
    """The field along the null vector at a fold, projected on the left one; x is the amplitude."""
    z = whirl_at_fold(omega, amplitude, machine)
    v = 1j * omega * z
    state = np.array([z.real, z.imag, v.real, v.imag])
    assert np.abs(field(state, omega, machine)).max() < 1e-9 * max(1.0, omega**2 * amplitude)
    step = 1e-4 * (amplitude - machine["delta0"])
    jacobian = np.array(
        [
            (
                field(state + step * each, omega, machine)
                - field(state - step * each, omega, machine)
            )
            / (2.0 * step)
            for each in np.eye(4)
        ]
    ).T
    right, left = (
        vectors[:, np.argmin(np.abs(values))].real
        for values, vectors in (np.linalg.eig(jacobian), np.linalg.eig(jacobian.T))
    )
    right = right / ((z.conjugate() * complex(*right[:2])).real / amplitude)
    left = left / (left @ right)
    size = 1e-3 * (amplitude - machine["delta0"])
    there, back = (field(state + sign * size * right, omega, machine) for sign in (1.0, -1.0))
    bent = (there + back - 2.0 * field(state, omega, machine)) / size**2
    later, sooner = (field(state, omega + sign * 1e-5, machine) for sign in (1.0, -1.0))
    return left @ (later - sooner) / 2e-5, 0.5 * left @ bent


@pytest.mark.parametrize("name", MACHINES)
def test_coefficients_are_those_of_the_motion_along_the_null_vector(name):
    machine = MACHINES[name]
    found = late_jumps(rate=1e-4, **machine).isel(zeta=0, delta0=0)
    for fold in range(found.sizes["fold"]):
        at = found.isel(fold=fold)
        drift, curvature = reduced(at.fold_omega.item(), at.fold_amplitude.item(), machine)
        assert at.fold_drift.item() == pytest.approx(drift, rel=1e-5)
        # the fourth derivative of the force: 1e-6 of the second, at most
        assert at.fold_curvature.item() == pytest.approx(curvature, rel=1e-4)


def test_law_is_a_power_of_the_rate_beyond_each_fold():
    rates = [1e-4, 1e-6]
    found = late_jumps(rate=rates, zeta=[0.07, 0.3], delta0=0.5)
    at = found.sel(zeta=0.07).squeeze()
    beyond = (at.jump_omega - at.fold_omega) * at.fold_passage
    product = np.abs(at.fold_drift * at.fold_curvature)
    expected = AIRY * np.outer(np.power(rates, 2.0 / 3.0), product.values ** (-1.0 / 3.0))
    np.testing.assert_allclose(beyond.transpose("rate", "fold"), expected, rtol=1e-9)
    beyond_cusp = found.sel(zeta=0.3)
    assert beyond_cusp.jump_omega.isnull().all()
    assert (beyond_cusp.fold_passage == 0).all()
    alone = late_jumps(rate=1e-3, zeta=0.3, delta0=0.5)
    assert alone.jump_omega.dims == folds(zeta=0.3, delta0=0.5).fold_omega.dims


def test_no_run_is_told_to_pass_a_fold_that_no_stable_whirl_leads_to():
    """With much friction the whirl begins to oscillate before the fold."""
    found = late_jumps(rate=1e-4, zeta=0.07, delta0=0.5, friction=0.2).squeeze()
    for fold in range(found.sizes["fold"]):
        at = found.isel(fold=fold)
        omega = at.fold_omega.item()
        beside = [
            synchronous_response(omega=omega + way * 1e-6, zeta=0.07, delta0=0.5, friction=0.2)
            for way in (1.0, -1.0)
        ]
        stable = [
            each.amplitude.where(each.stability == 1).fillna(np.inf) - at.fold_amplitude
            for each in beside
        ]
        leads = any(float(np.abs(each).min()) < 0.01 for each in stable)
        assert leads == (at.fold_passage.item() != 0)
        assert leads == bool(np.isfinite(at.jump_omega.item()))


def left_over(machine, fold, rate):
    """What a run-up from the exact whirl jumps later than the law says, over the rate."""
    at = late_jumps(rate=rate, **machine).isel(zeta=0, delta0=0).isel(fold=fold)
    width = rate ** (2.0 / 3.0) / abs(at.fold_drift * at.fold_curvature).item() ** (1.0 / 3.0)
    omega = at.fold_omega.item() - 8.0 * width
    whirls = synchronous_response(omega=omega, **machine).squeeze()
    stable = whirls.where((whirls.stability == 1) & (whirls.in_contact == 1))
    place = int(np.nanargmin(np.abs(stable.amplitude.values - at.fold_amplitude.item())))
    z = stable.amplitude.values[place] * np.exp(-1j * stable.phase_lag.values[place])
    v = 1j * omega * z
    found = run_up(
        Rotor(omega=omega, **machine), start=(z.real, z.imag, v.real, v.imag), rate=rate,
        to=at.fold_omega.item() + 3.0 * width + 50.0 * rate, samples=2, method="taylor",
    )  # fmt: skip
    assert found.event_kind.values[0] == -1  # it leaves the ring
    return (found.event_speed.values[0] - at.jump_omega.item()) / rate


def test_slow_run_ups_jump_as_late_as_the_law_says():
    """What is left is ``rate (C + K ln(1/rate))`` with K from the exact response."""
    machine, rates = {"zeta": 0.15, "delta0": 1.0}, np.array([1e-3, 1e-4, 1e-5, 1e-6, 1e-7])
    left = np.array([left_over(machine, 1, rate) for rate in rates])
    steps = np.diff(left) / np.log(10.0)
    known = late_jumps(rate=1e-3, **machine).fold_remainder.values.ravel()[1]
    off = np.abs(steps / known - 1.0)
    # by the cube root of the rate
    np.testing.assert_allclose(off[:-1] / off[1:], 10.0 ** (1.0 / 3.0), rtol=0.15)
    assert off[-1] < 0.03
    law = late_jumps(rate=rates, **machine).isel(fold=1).squeeze()
    shares = np.abs(left * rates / (law.jump_omega - law.fold_omega).values)
    assert (shares[[2, 4]] < shares[[0, 2]]).all()
    assert shares[-2:].max() < 0.01


@pytest.mark.parametrize("name", MACHINES)
def test_remainder_follows_from_the_curve_and_the_eigenvalue_along_it(name):
    """``c = (lambda_2 + alpha d_3)/2`` by polynomials through points of both near the fold."""
    machine = MACHINES[name]
    found = late_jumps(rate=1e-4, **machine).isel(zeta=0, delta0=0)
    for fold in range(found.sizes["fold"]):
        at = found.isel(fold=fold)
        bend = (at.fold_curvature / at.fold_drift).item()
        width = 1e-3 * (at.fold_amplitude.item() - machine["delta0"])
        around = width * np.cos(np.pi * np.arange(7) / 6.0)
        speeds = [speed_at(at, each, bend, machine) for each in around]
        rates = [
            min(eigenvalues(at.fold_amplitude.item() + each, omega=omega, **machine), key=abs).real
            for each, omega in zip(around, speeds, strict=True)
        ]
        d_3 = np.polynomial.Polynomial.fit(around, speeds, 5).convert().coef[3]
        lambda_2 = np.polynomial.Polynomial.fit(around, rates, 5).convert().coef[2]
        cubic = 0.5 * (lambda_2 + at.fold_drift.item() * d_3)
        known = at.fold_remainder.item()
        assert known == pytest.approx(-cubic / (3.0 * at.fold_curvature.item() ** 2), rel=5e-3)


def speed_at(fold, off, bend, machine):
    """The speed on the response curve at an amplitude near a fold."""
    A, zeta, mu = fold.fold_amplitude.item() + off, machine["zeta"], machine.get("friction", 0.0)
    force = (A - machine["delta0"]) ** machine.get("contact_exponent", 1.5)
    g = machine.get("shaft_stiffness", 0.0) * A + force
    rows = np.array([
        A**2 - 1.0, 0.0, 4.0 * zeta**2 * A**2 - 2.0 * g * A, 4.0 * zeta * mu * A * force,
        g**2 + mu**2 * force**2,
    ])  # fmt: skip
    near = np.roots(rows)
    near = near[np.argmin(np.abs(near - fold.fold_omega.item() + bend * off**2))].real
    for _ in range(3):
        near -= np.polyval(rows, near) / np.polyval(np.polyder(rows), near)
    return near


def test_where_there_is_no_jump_there_is_no_speed_of_it():
    """Without damping nothing decays; a fast run-down is at rest before it jumps."""
    undamped = late_jumps(rate=1e-3, zeta=0.0, delta0=0.5)
    assert undamped.fold_omega.notnull().any()
    assert (undamped.fold_passage == 0).all()
    assert undamped.jump_omega.isnull().all()
    slight = late_jumps(rate=1e-3, zeta=1e-6, delta0=1e-3)
    assert not (slight.jump_omega <= 0.0).any()
    slow, fast = (late_jumps(rate=rate, zeta=0.05, delta0=0.5).isel(fold=0) for rate in (1e-5, 0.1))
    assert slow.fold_passage.item() == fast.fold_passage.item() == -1
    assert 0.0 < slow.jump_omega.item() < slow.fold_omega.item()
    assert np.isnan(fast.jump_omega.item())


@pytest.mark.parametrize("zeta", [1e-4, 1e-6, 1e-9, 1e-12, 1e-18])
def test_coefficients_with_slight_damping_are_right_or_none(zeta):
    """On a linear ring the first fold has a drift of ``10.24 zeta**2`` (``4 delta0**2``).

    Its indentation falls as zeta**2 too, soon below the rounding of its amplitude.
    """
    found = late_jumps(rate=1e-3, zeta=zeta, delta0=1.6, contact_exponent=1.0).squeeze()
    first, last = found.isel(fold=0), found.isel(fold=-1)
    if zeta >= 1e-6:
        assert float(first.fold_drift) == pytest.approx(4.0 * 1.6**2 * zeta**2, rel=0.02)
        assert (float(first.fold_passage), float(last.fold_passage)) == (-1.0, 1.0)
    else:
        assert np.isnan(first.fold_drift)
        assert np.isnan(first.jump_omega)
        assert int(first.fold_passage) == 0
    assert float(last.fold_amplitude) > 0.39 / zeta  # above what `eigenvalues` accepts, at last


@pytest.mark.parametrize("rate", [0.0, -1e-3, np.nan, [1e-3, 0.0], "slow"])
def test_bad_rates_are_refused(rate):
    with pytest.raises(InputError, match="rate"):
        late_jumps(rate=rate, zeta=0.07, delta0=0.5)
