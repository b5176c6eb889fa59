"""Jumps land on whirls that last; above the critical damping there is nothing to jump from."""

import numpy as np
import pytest

from rotor_ida import InputError, folds, synchronous_response
from rotor_ida.closed_forms import cusp, cusp_zeta, jumps, stability_determinant


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
def test_limit_is_where_the_last_fold_goes(delta0):
    limit = cusp(delta0=delta0).cusp_zeta.item()
    assert fold_count(limit * (1.0 - 1e-9), delta0) >= 2
    assert all(fold_count(limit * factor, delta0) == 0 for factor in (1.0 + 1e-9, 1.01, 1.3, 5.0))


def test_number_of_folds_need_not_fall_with_the_damping():
    found = folds(zeta=np.linspace(0.05, 0.26, 1500), delta0=0.7237)
    counts = found.fold_omega.notnull().sum("fold").values.ravel()
    assert [4, *counts[1:][np.diff(counts) != 0]] == [4, 2, 4, 2, 0]


def test_limit_without_clearance():
    assert cusp(delta0=0.0).cusp_zeta.item() == pytest.approx(0.156045165, abs=5e-10)


def test_highest_limit_bounds_every_clearance():
    highest = cusp()
    scan = np.concatenate([np.linspace(0.0, 3.0, 121), np.geomspace(3.0, 1e3, 15)])
    table = cusp(delta0=scan).cusp_zeta
    assert highest.cusp_zeta.item() >= float(table.max())
    assert highest.cusp_zeta.item() == pytest.approx(0.2510030, abs=5e-8)
    assert abs(highest.delta0.item() - scan[int(table.values.argmax())]) <= 0.0125


@pytest.mark.parametrize("delta0", [0.0, 0.5, 0.70086, 1.5])
def test_last_folds_merge_where_it_says(delta0):
    limit = cusp(delta0=delta0)
    zeta = limit.cusp_zeta.item() * (1.0 - 1e-12)
    found = folds(zeta=zeta, delta0=delta0)
    # the two folds are apart by the root of what is missing to the limit
    omega = limit.cusp_omega.item()
    assert float(abs(found.fold_omega / omega - 1.0).min()) < 1e-4
    place = {"omega": omega, "zeta": limit.cusp_zeta.item(), "delta0": delta0}
    determinant = stability_determinant(limit.cusp_amplitude.item(), **place)
    assert abs(float(determinant)) < 1e-9


def test_scalar_and_table_agree():
    assert cusp(delta0=0.3).cusp_zeta.item() == cusp_zeta(0.3)


def test_bad_values_are_refused():
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
