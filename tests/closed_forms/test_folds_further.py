"""Folds with a shaft, a linear contact and contact damping, against 50-digit references."""

from __future__ import annotations

import itertools
import warnings

import mpmath
import numpy as np
import pytest

from rotor_ida.closed_forms import (
    cusp,
    cusp_zeta,
    eigenvalues,
    folds,
    jumps,
    stability_determinant,
    synchronous_response,
    touch_speeds,
)
from rotor_ida.errors import InputError

mpmath.mp.dps = 50
ROUNDING = 1e-13
CASES = list(
    itertools.product([0.003, 0.07, 0.15], [0.1, 0.7, 1.0, 3.0], [0.0, 1e-3, 0.25, 2.0], [1.5, 1.0])
) + [(0.07, 0.0, kappa, 1.5) for kappa in (1e-3, 0.25, 2.0)]


def found_at(zeta, delta0, kappa, exponent) -> list[tuple[float, float]]:
    found = folds(zeta=zeta, delta0=delta0, shaft_stiffness=kappa, contact_exponent=exponent)
    pairs = zip(found.fold_omega.values.ravel(), found.fold_amplitude.values.ravel(), strict=True)
    return [pair for pair in pairs if np.isfinite(pair).all()]


def equations(zeta, delta0, kappa, exponent):
    """The curve and its slope by u, both zero at a fold, in u = sqrt(A - delta0) and omega."""
    z, d, k = (mpmath.mpf(each) for each in (zeta, delta0, kappa))
    power = 3 if exponent == 1.5 else 2

    def both(u, omega):
        q, A = omega**2, d + u**2
        F = u**power + (k - q) * A
        m = 4 * z**2 * q
        slope = F * (power * u ** (power - 2) + 2 * (k - q)) + 2 * m * A
        return [(F**2 + m * A**2) / q**2 - 1, slope / q]

    return both


@pytest.mark.parametrize("case", CASES)
def test_folds_hold_to_rounding(case):
    delta0 = case[1]
    for omega, amplitude in found_at(*case):
        guess = (mpmath.sqrt(mpmath.mpf(amplitude) - delta0), mpmath.mpf(omega))
        u, speed = mpmath.findroot(equations(*case), guess, tol=1e-60, maxsteps=40)
        assert abs(omega / speed - 1) < ROUNDING, case
        assert abs(amplitude / (mpmath.mpf(delta0) + u**2) - 1) < ROUNDING, case


def test_no_fold_is_missed_and_none_invented():
    """Between two speeds the number of contacting whirls changes by what lies between them."""
    total = 0
    for zeta, delta0, kappa, exponent in CASES:
        turns = [omega for omega, _ in found_at(zeta, delta0, kappa, exponent)]
        touches = touch_speeds(zeta=zeta, delta0=delta0, shaft_stiffness=kappa)
        ends = np.sort([*turns, *touches[touches > 0.0]])
        speeds = np.unique(
            np.concatenate([np.geomspace(1e-3, 30.0, 300), ends * (1 - 1e-7), ends * (1 + 1e-7)])
        )
        count = synchronous_response(
            omega=speeds, zeta=zeta, delta0=delta0,
            shaft_stiffness=kappa, contact_exponent=exponent,
        ).in_contact.sum("branch").values.ravel()  # fmt: skip
        for k in np.nonzero(np.diff(count))[0]:
            between = (speeds[k] < ends) & (ends < speeds[k + 1])
            assert between.any(), (zeta, delta0, kappa, exponent, speeds[k])
        for omega in turns:
            k = np.searchsorted(speeds, omega)
            if np.sum((speeds[k - 1] < ends) & (ends < speeds[k])) == 1:
                assert abs(count[k] - count[k - 1]) == 2, (zeta, delta0, kappa, exponent, omega)
                total += 1
    assert total > 100


def linear_cubic(zeta, delta0, kappa) -> list:
    """``q (1 + kappa - q)**2 = 4 zeta**2 (delta0**2 - q**2)`` where its whirl is in contact."""
    z, d, k = mpmath.mpf(zeta), mpmath.mpf(delta0), 1 + mpmath.mpf(kappa)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        roots = mpmath.polyroots(
            [1, 4 * z**2 - 2 * k, k**2, -4 * z**2 * d**2], maxsteps=500, extraprec=300
        )
    found = []
    for root in roots:
        q = mpmath.re(root)
        if abs(mpmath.im(root)) > 1e-30 or q <= 0:
            continue
        amplitude = (k - q) * d / ((k - q) ** 2 + 4 * z**2 * q)
        if amplitude > d:
            found.append((mpmath.sqrt(q), amplitude))
    return sorted(found)


@pytest.mark.parametrize("delta0", [0.05, 0.5, 0.9, 1.1, 1.5, 8.0])
@pytest.mark.parametrize("kappa", [0.0, 1e-4, 0.25, 2.0])
def test_folds_of_a_linear_contact_are_roots_of_a_cubic(delta0, kappa):
    for zeta in (1e-4, 0.01, 0.07, 0.3, 0.6):
        expected = linear_cubic(zeta, delta0, kappa)
        found = found_at(zeta, delta0, kappa, 1.0)
        assert len(found) == len(expected), (zeta, delta0, kappa)
        for (omega, amplitude), (speed, size) in zip(found, expected, strict=True):
            assert abs(omega / speed - 1) < ROUNDING
            assert abs(amplitude / size - 1) < ROUNDING


def test_a_linear_contact_without_clearance_has_no_fold():
    assert found_at(0.01, 0.0, 0.3, 1.0) == []
    assert np.isnan(cusp_zeta(0.0, contact_exponent=1.0))


@pytest.mark.parametrize("delta0", [0.0, 0.5, 2.0])
@pytest.mark.parametrize("kappa", [1e-3, 0.25, 2.0])
def test_without_damping_the_speed_is_stationary_at_a_fold(delta0, kappa):
    found = found_at(0.0, delta0, kappa, 1.5)
    assert found
    for omega, amplitude in found:
        d, k = mpmath.mpf(delta0), mpmath.mpf(kappa)

        def square(A, d=d, k=k):  # of the speed on the lagging flank
            return ((A - d) ** 1.5 + k * A) / (A - 1)

        A = mpmath.findroot(lambda A: mpmath.diff(square, A), mpmath.mpf(amplitude), tol=1e-40)
        assert abs(amplitude / A - 1) < ROUNDING
        assert abs(omega / mpmath.sqrt(square(A)) - 1) < ROUNDING


def test_a_vanishing_shaft_gives_the_folds_of_the_plain_rotor():
    plain = folds(zeta=[0.01, 0.07, 0.2], delta0=[0.0, 0.5, 0.7, 2.0])
    axis = folds(zeta=[0.01, 0.07, 0.2], delta0=[0.0, 0.5, 0.7, 2.0], shaft_stiffness=[0.0])
    axis = axis.isel(shaft_stiffness=0)
    np.testing.assert_allclose(axis.fold_omega, plain.fold_omega, rtol=1e-14)
    np.testing.assert_allclose(axis.fold_amplitude, plain.fold_amplitude, rtol=1e-14)


@pytest.mark.parametrize("delta0", [0.0, 0.3, 1.0, 4.0])
@pytest.mark.parametrize("kappa", [1e-3, 0.25, 2.0])
def test_no_fold_above_the_cusp_and_two_below(delta0, kappa):
    last = cusp_zeta(delta0, shaft_stiffness=kappa)
    assert len(found_at(last * (1.0 + 1e-12), delta0, kappa, 1.5)) == 0
    beside = found_at(last * (1.0 - 1e-8), delta0, kappa, 1.5)
    assert len(beside) == 2
    # 1e-8 below they are 1e-4 apart, which would magnify roundings ten thousandfold
    for omega, amplitude in beside:
        guess = (mpmath.sqrt(mpmath.mpf(amplitude) - delta0), mpmath.mpf(omega))
        function = equations(last * (1.0 - 1e-8), delta0, kappa, 1.5)
        _, speed = mpmath.findroot(function, guess, tol=1e-60, maxsteps=60)
        assert abs(omega / speed - 1) < 1e-12


def test_cusp_says_where_the_last_folds_merge():
    last = cusp(delta0=[0.5, 2.0], shaft_stiffness=[0.1, 1.0])
    assert last.cusp_zeta.dims == ("delta0", "shaft_stiffness")
    for delta0, kappa in itertools.product([0.5, 2.0], [0.1, 1.0]):
        at = last.sel(delta0=delta0, shaft_stiffness=kappa)
        assert at.cusp_zeta.item() == cusp_zeta(delta0, shaft_stiffness=kappa)
        place = {"omega": at.cusp_omega.item(), "zeta": at.cusp_zeta.item(), "delta0": delta0}
        determinant = stability_determinant(
            at.cusp_amplitude.item(), **place, shaft_stiffness=kappa
        )
        assert abs(determinant) < 1e-12
        beside = found_at(at.cusp_zeta.item() * (1 - 1e-8), delta0, kappa, 1.5)
        assert [omega for omega, _ in beside] == pytest.approx([place["omega"]] * 2, rel=1e-3)


def test_the_last_fold_of_a_linear_contact_vanishes_at_the_ring():
    # without a shaft 4 zeta**2 = 1 - delta0**2 at A = delta0
    last = cusp(delta0=0.6, contact_exponent=1.0)
    assert last.cusp_zeta.item() == pytest.approx(0.4, rel=1e-12)
    assert last.cusp_amplitude.item() == pytest.approx(0.6, rel=1e-12)
    assert len(found_at(0.4 * (1 - 1e-9), 0.6, 0.0, 1.0)) == 1
    assert len(found_at(0.4 * (1 + 1e-9), 0.6, 0.0, 1.0)) == 0


def test_contact_damping_moves_no_fold_but_an_eigenvalue_vanishes_there_too():
    found = folds(zeta=0.07, delta0=0.5, shaft_stiffness=0.1, contact_damping=[0.0, 0.8])
    assert found.fold_omega.dims == ("zeta", "delta0", "contact_damping", "fold")
    with_damping = found.isel(contact_damping=1)
    assert found.isel(contact_damping=0).fold_omega.values.tolist() == (
        with_damping.fold_omega.values.tolist()
    )
    for omega, amplitude in zip(
        with_damping.fold_omega.values.ravel(), with_damping.fold_amplitude.values.ravel(),
        strict=True,
    ):  # fmt: skip
        rates = eigenvalues(
            amplitude, omega=omega, zeta=0.07, delta0=0.5, shaft_stiffness=0.1,
            contact_damping=0.8,
        )  # fmt: skip
        assert np.abs(rates).min() < 1e-12


def test_a_jump_lands_on_a_whirl_that_is_not_unstable():
    found = jumps(zeta=0.07, delta0=[0.5, 2.0], shaft_stiffness=0.25, contact_damping=[0.0, 0.1])
    assert found.landing_amplitude.dims == found.fold_omega.dims
    landed = 0
    for place in np.ndindex(found.landing_amplitude.shape):
        at = found.isel(dict(zip(found.landing_amplitude.dims, place, strict=True)))
        if np.isnan(at.landing_amplitude.item()):
            continue
        whirls = synchronous_response(
            omega=at.fold_omega.item(), zeta=0.07, delta0=at.delta0.item(),
            shaft_stiffness=0.25, contact_damping=at.contact_damping.item(),
        )  # fmt: skip
        nearest = np.nanargmin(np.abs(whirls.amplitude.values - at.landing_amplitude.item()))
        assert whirls.amplitude.values.ravel()[nearest] == at.landing_amplitude.item()
        assert whirls.stability.values.ravel()[nearest] == 0
        landed += 1
    assert landed >= 4


def test_what_is_default_is_no_coordinate():
    plain = folds(zeta=0.07, delta0=[0.0, 0.5])
    same = folds(zeta=0.07, delta0=[0.0, 0.5], shaft_stiffness=0, contact_exponent=1.5)
    assert same.identical(plain)
    stiff = folds(zeta=0.07, delta0=[0.0, 0.5], shaft_stiffness=0.25)
    assert stiff.fold_omega.dims == ("zeta", "delta0", "fold")
    assert stiff.shaft_stiffness.item() == 0.25


@pytest.mark.parametrize(
    ("function", "given_values", "message"),
    [
        (folds, {"shaft_stiffness": -1.0}, "shaft_stiffness must be zero or positive, got -1.0"),
        (folds, {"shaft_stiffness": 1e7}, "shaft_stiffness must be 0 or between 1e-20 and 1e\\+06"),
        (jumps, {"contact_exponent": 1.2}, "contact_exponent must be 1.5 or 1, got 1.2"),
        (folds, {"contact_damping": 1.0, "delta0": 0.0}, "contact_damping must be 0 without"),
        (cusp, {"delta0": None, "shaft_stiffness": 1.0}, "delta0 must be given with shaft_stiff"),
        (cusp, {"contact_exponent": np.nan}, "contact_exponent must be a finite real number"),
    ],
)
def test_parameters_out_of_range_are_refused(function, given_values, message):
    given = {"delta0": 0.5, **given_values}
    if function is not cusp:
        given["zeta"] = 0.07
    with pytest.raises(InputError, match=message):
        function(**given)


@pytest.mark.parametrize("zeta", [1.3e-6, 1e-5, 1e-3, 0.05])
def test_folds_of_a_linear_ring_whose_clearance_is_one_are_roots_of_a_cubic(zeta):
    """There ``4 zeta**2 = (2 - A) (A - 1)/A``: two folds, however slight the damping."""
    least = 4.0 * zeta * zeta
    # A**2 - (3 - 4 zeta**2) A + 2 = 0, written so that the smaller root does not cancel
    large = 0.5 * ((3.0 - least) + np.sqrt((1.0 - least) * (1.0 - least) - 4.0 * least))
    found = folds(zeta=zeta, delta0=1.0, contact_exponent=1.0)
    amplitudes = np.sort(found.fold_amplitude.values.ravel())
    np.testing.assert_allclose(amplitudes, [2.0 / large, large], rtol=1e-14)
