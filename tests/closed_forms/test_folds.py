"""Folds, jumps and the cusp, against 50-digit references."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotor_ida.closed_forms import (
    cusp,
    cusp_zeta,
    folds,
    jumps,
    peak_amplitude,
    stability_determinant,
    synchronous_response,
)
from rotor_ida.errors import InputError

mpmath.mp.dps = 50
# Folds are simple crossings except where two of them merge: a few rounding errors remain.
ROUNDING = 1e-13


def fold_equations(zeta: float, delta0: float):
    """The curve and its slope, both zero at a fold, in u = sqrt(A - delta0) and omega."""
    m, d = 4 * mpmath.mpf(zeta) ** 2, mpmath.mpf(delta0)

    def equations(u, omega):
        q, A = omega**2, d + u**2
        s, tangent = u**3 / A, 3 * u / 2
        on_curve = A**2 * ((s - q) ** 2 + m * q) / q**2 - 1
        return [on_curve, ((tangent - q) * (s - q) + m * q) / q]

    return equations


def reference_count(zeta: float, delta0: float) -> int:
    """Count the folds from the resultant of curve and determinant, by all its roots in u."""
    m, d = 4 * mpmath.mpf(zeta) ** 2, mpmath.mpf(delta0)

    def resultant(u):
        A = d + u**2
        B = A**2 - 1
        first = u**2 * (1.5 * u * B - A * u**3) ** 2
        second = (1.5 * d + 0.5 * u**2) * (m * A - u**3)
        return first - second * ((A**2 + 1) * u**3 - 1.5 * u * A * B - m * A)

    degree = 11
    nodes = [mpmath.mpf(k) / 4 - mpmath.mpf(3) / 2 for k in range(degree + 1)]
    vandermonde = mpmath.matrix(degree + 1, degree + 1)
    for row, node in enumerate(nodes):
        for column in range(degree + 1):
            vandermonde[row, column] = node**column
    coefficients = mpmath.lu_solve(vandermonde, mpmath.matrix([resultant(u) for u in nodes]))
    companion = mpmath.matrix(degree, degree)
    for k in range(degree - 1):
        companion[k + 1, k] = 1
    for k in range(degree):
        companion[k, degree - 1] = -coefficients[k] / coefficients[degree]
    count = 0
    for root in mpmath.eig(companion, left=False, right=False):
        u = mpmath.re(root)
        if abs(mpmath.im(root)) > 1e-20 or u < 1e-12:
            continue
        A = d + u**2
        s, tangent = u**3 / A, 3 * u / 2
        bottom = (A**2 + 1) * s - (A**2 - 1) * tangent - m
        common = -s * ((A**2 - 1) * tangent - A**2 * s) / bottom
        count += common > 0
    return count


def found_at(zeta: float, delta0: float) -> list[tuple[float, float]]:
    found = folds(zeta=zeta, delta0=delta0)
    pairs = zip(found.fold_omega.values.ravel(), found.fold_amplitude.values.ravel(), strict=True)
    return [pair for pair in pairs if np.isfinite(pair).all()]


def test_folds_of_the_design_without_clearance():
    found = found_at(0.07, 0.0)
    assert [round(omega, 6) for omega, _ in found] == [1.597821, 1.932754]


# Without clearance the two folds merge at A = 12/sqrt(10), a = 2/sqrt(10), b = sqrt(10), where
# d/dA [(1 - a**2)/(sqrt(A) b)] = 0; so 4 zeta**2 = 0.6/(sqrt(A) sqrt(10)).
CUSP_ZETA = np.sqrt(0.15 / (np.sqrt(12.0) * 10.0**0.25))


def test_jumps_without_clearance_need_a_damping_below_0_15604517():
    assert cusp_zeta(0.0) == pytest.approx(CUSP_ZETA, rel=1e-15)
    assert pytest.approx(0.156045165, abs=5e-10) == CUSP_ZETA
    assert len(found_at(CUSP_ZETA * (1.0 - 1e-13), 0.0)) == 2
    assert len(found_at(CUSP_ZETA * (1.0 + 1e-13), 0.0)) == 0


@pytest.mark.parametrize("delta0", [0.0, 0.1, 0.5, 0.65, 0.9, 1.0, 3.0, 50.0])
def test_no_fold_above_the_cusp(delta0):
    critical = cusp_zeta(delta0)
    assert len(found_at(critical * (1.0 + 1e-12), delta0)) == 0
    assert len(found_at(critical * (1.0 - 1e-12), delta0)) == 2


@pytest.mark.parametrize("delta0", [0.0, 0.1, 0.7, 2.0])
def test_folds_about_to_merge_hold_to_rounding(delta0):
    # 1e-8 below the merger they are 1e-4 apart, which magnifies roundings ten thousandfold
    # in plain doubles; the 32-digit residuals keep them out
    assert_folds_match(cusp_zeta(delta0) * (1.0 - 1e-8), delta0)


def assert_folds_match(zeta: float, delta0: float) -> None:
    equations = fold_equations(zeta, delta0)
    for omega, amplitude in found_at(zeta, delta0):
        guess = (mpmath.sqrt(mpmath.mpf(amplitude) - delta0), mpmath.mpf(omega))
        u, speed = mpmath.findroot(equations, guess, tol=1e-60, maxsteps=40)
        assert abs(omega / speed - 1) < ROUNDING, (zeta, delta0)
        assert abs(amplitude / (mpmath.mpf(delta0) + u**2) - 1) < ROUNDING, (zeta, delta0)


@pytest.mark.parametrize("zeta", [0.003, 0.01, 0.07, 0.15, 0.2, 0.22])
@pytest.mark.parametrize("delta0", [0.0, 0.05, 0.3, 0.5, 0.6, 0.7, 0.9, 0.999, 1.0, 1.5, 3.0])
def test_folds_hold_to_rounding(zeta, delta0):
    assert_folds_match(zeta, delta0)


@pytest.mark.parametrize("zeta", [0.01, 0.07, 0.18, 0.23, 0.4])
@pytest.mark.parametrize("delta0", [0.0, 0.1, 0.5, 0.64, 0.8, 1.0, 2.0])
def test_resultant_has_as_many_folds(zeta, delta0):
    assert len(found_at(zeta, delta0)) == reference_count(zeta, delta0)


def test_two_tiny_folds_near_first_touch_with_some_clearance():
    omegas = [omega for omega, _ in found_at(0.07, 0.5)]
    amplitudes = [amplitude for _, amplitude in found_at(0.07, 0.5)]
    assert len(omegas) == 4
    assert max(omegas[:2]) < 0.1
    assert max(amplitudes[:2]) < 0.52
    touch = 2.0 * 0.07 * 0.5 / np.sqrt(1.0 - 0.5**2)  # A_f = delta0
    assert touch > omegas[0]


def test_contacting_branch_is_an_isola_between_two_folds_for_large_clearance():
    (low, _), (high, _) = found_at(0.07, 2.0)
    count = synchronous_response(
        omega=[low * (1 - 1e-9), low * (1 + 1e-9), high * (1 - 1e-9), high * (1 + 1e-9)],
        zeta=0.07,
        delta0=2.0,
    ).in_contact.sum("branch")
    assert count.values.ravel().tolist() == [0, 2, 2, 0]


def test_strong_damping_leaves_no_fold():
    assert np.isnan(folds(zeta=[1.0, 5.0], delta0=[0.0, 0.5, 1.0, 50.0]).fold_omega).all()


def test_without_damping_one_fold_is_left_below_unit_clearance():
    # u**3 = q (u**2 - 1) has a double root at u**2 = 3, q**2 = 27/4
    assert found_at(0.0, 0.0) == [(pytest.approx(6.75**0.25, rel=1e-15), 3.0)]
    assert len(found_at(0.0, 0.9)) == 1
    assert found_at(0.0, 1.0) == []
    slight = found_at(1e-9, 0.25)
    assert len(slight) == 4
    np.testing.assert_allclose(slight[2], found_at(0.0, 0.25)[0], rtol=1e-12)


@settings(max_examples=60, deadline=None)
@given(
    zeta=st.floats(1e-3, 0.3),
    delta0=st.one_of(st.just(0.0), st.floats(1e-3, 5.0)),
)
def test_two_whirls_appear_or_vanish_across_every_fold(zeta, delta0):
    found = found_at(zeta, delta0)
    omegas = [omega for omega, _ in found]
    assert omegas == sorted(omegas)
    for k, (omega, amplitude) in enumerate(found):
        # step by far less than the distance to the next fold, and to where a branch touches
        others = [abs(omega - other) for j, other in enumerate(omegas) if j != k]
        if delta0 < 1.0:
            others.append(abs(omega - 2.0 * zeta * delta0 / np.sqrt(1.0 - delta0**2)))
        step = min([1e-3 * omega, *(1e-2 * distance for distance in others)])
        if step < 1e-9 * omega:
            continue
        beside = synchronous_response(omega=[omega - step, omega + step], zeta=zeta, delta0=delta0)
        before, after = beside.in_contact.sum("branch").values.ravel()
        assert abs(int(after) - int(before)) == 2
        determinant = stability_determinant(amplitude, omega=omega, zeta=zeta, delta0=delta0)
        assert abs(determinant) < 1e-10 * max(1.0, omega**4)


def test_a_grid_of_folds_holds_what_single_calls_hold():
    zetas, clearances = [0.0, 0.01, 0.07, 0.5], [0.0, 0.5, 2.0]
    grid = folds(zeta=zetas, delta0=clearances)
    assert grid.fold_omega.dims == ("zeta", "delta0", "fold")
    for zeta in zetas:
        for delta0 in clearances:
            point = grid.sel(zeta=zeta, delta0=delta0)
            alone = found_at(zeta, delta0)
            values = np.stack([point.fold_omega.values, point.fold_amplitude.values], axis=1)
            assert np.isnan(values[len(alone) :]).all()
            # the locus is cut elsewhere on a grid, which moves the last digit
            np.testing.assert_allclose(values[: len(alone)], np.reshape(alone, (-1, 2)), rtol=1e-14)


def test_parameters_out_of_range_of_the_locus_are_refused():
    with pytest.raises(InputError, match="zeta must be 0 or between 1e-20 and"):
        folds(zeta=1e-30, delta0=0.0)
    with pytest.raises(InputError, match=r"delta0 must be zero or positive, got -1\.0"):
        folds(zeta=0.1, delta0=-1.0)


@pytest.mark.parametrize("delta0", [1.0, 1.5, 3.0, 50.0])
def test_peak_of_an_isola_vanishes_with_its_folds(delta0):
    critical = cusp_zeta(delta0)
    just_below = peak_amplitude(zeta=critical * (1.0 - 1e-10), delta0=delta0)
    (_, low), (_, high) = found_at(critical * (1.0 - 1e-10), delta0)
    # the isola has shrunk to 1e-5, the root of 1e-10
    assert just_below == pytest.approx(low, rel=1e-4)
    assert just_below == pytest.approx(high, rel=1e-4)
    assert np.isnan(peak_amplitude(zeta=critical * (1.0 + 1e-10), delta0=delta0))


def fold_count(zeta, delta0):
    return int(folds(zeta=zeta, delta0=delta0).fold_omega.count())


def test_rotor_lands_on_a_stable_whirl_of_the_curve():
    found = jumps(zeta=0.07, delta0=0.0)
    omega = found.fold_omega.values.ravel()
    for speed, landing in zip(omega, found.landing_amplitude.values.ravel(), strict=True):
        beside = synchronous_response(omega=speed * (1.0 + 1e-9), zeta=0.07, delta0=0.0)
        stable = beside.amplitude.where(beside.stability == 0).values.ravel()
        assert np.nanmin(abs(stable / landing - 1.0)) < 1e-7
    up, down = found.landing_amplitude.values.ravel()
    first, last = found.fold_amplitude.values.ravel()
    assert up > first
    assert down < last


def test_strong_damping_has_no_jump():
    assert int(jumps(zeta=[1.0, 1.5, 2.0], delta0=0.0).fold_omega.count()) == 0


@pytest.mark.parametrize("delta0", [0.0, 0.1, 0.39, 0.5, 0.70086, 0.7237, 0.9, 1.0, 2.0, 10.0])
def test_cusp_is_where_the_last_fold_goes(delta0):
    last = cusp(delta0=delta0).cusp_zeta.item()
    assert fold_count(last * (1.0 - 1e-9), delta0) >= 2
    assert all(fold_count(last * factor, delta0) == 0 for factor in (1.0 + 1e-9, 1.01, 1.3, 5.0))


def test_number_of_folds_need_not_fall_with_the_damping():
    found = folds(zeta=np.linspace(0.05, 0.26, 1500), delta0=0.7237)
    counts = found.fold_omega.notnull().sum("fold").values.ravel()
    assert [4, *counts[1:][np.diff(counts) != 0]] == [4, 2, 4, 2, 0]


def test_cusp_without_clearance():
    assert cusp(delta0=0.0).cusp_zeta.item() == pytest.approx(0.156045165, abs=5e-10)


def test_cusp_of_largest_damping_bounds_every_clearance():
    highest = cusp()
    scan = np.concatenate([np.linspace(0.0, 3.0, 121), np.geomspace(3.0, 1e3, 15)])
    table = cusp(delta0=scan).cusp_zeta
    assert highest.cusp_zeta.item() >= float(table.max())
    assert highest.cusp_zeta.item() == pytest.approx(0.2510030, abs=5e-8)
    assert abs(highest.delta0.item() - scan[int(table.values.argmax())]) <= 0.0125


@pytest.mark.parametrize("delta0", [0.0, 0.5, 0.70086, 1.5])
def test_last_folds_merge_where_it_says(delta0):
    last = cusp(delta0=delta0)
    zeta = last.cusp_zeta.item() * (1.0 - 1e-12)
    found = folds(zeta=zeta, delta0=delta0)
    # the two folds are apart by the root of what is missing to the cusp
    omega = last.cusp_omega.item()
    assert float(abs(found.fold_omega / omega - 1.0).min()) < 1e-4
    place = {"omega": omega, "zeta": last.cusp_zeta.item(), "delta0": delta0}
    determinant = stability_determinant(last.cusp_amplitude.item(), **place)
    assert abs(float(determinant)) < 1e-9


def test_scalar_and_table_agree():
    assert cusp(delta0=0.3).cusp_zeta.item() == cusp_zeta(0.3)


def test_cusp_of_a_negative_clearance_is_refused():
    with pytest.raises(InputError, match="delta0 must be zero or positive"):
        cusp(delta0=-0.1)


def test_landings_with_clearance_are_whirls_that_last():
    found = jumps(zeta=0.07, delta0=[0.5, 2.0])
    columns = [
        found[name].transpose("delta0", ...).values.reshape(2, -1)
        for name in ("fold_omega", "landing_amplitude")
    ]
    table = zip(*columns, found.delta0.values, strict=True)
    for omega, landing, delta0 in table:
        for speed, amplitude in zip(omega, landing, strict=True):
            if np.isfinite(speed):
                here = synchronous_response(omega=speed, zeta=0.07, delta0=delta0)
                lasting = here.amplitude.where(here.stability != 1).values
                assert np.nanmin(abs(lasting - amplitude)) < 1e-12
    assert found.landing_amplitude.notnull().sum("fold").values.tolist() == [[4, 2]]
