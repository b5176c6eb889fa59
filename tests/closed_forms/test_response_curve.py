"""The response curve as a curve: on the whirl equation, whole, in order, turning at folds alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rotor_ida import InputError, folds, synchronous_response
from rotor_ida.closed_forms import (
    clearance_curve,
    cusp_zeta,
    peak_amplitude,
    response_curve,
    stability_determinant,
)
from rotor_ida.schema import STABILITY

dampings = st.one_of(st.just(0.0), st.floats(1e-4, 0.4), st.floats(0.4, 3.0))
clearances = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(1e-3, 1.3), st.floats(1.3, 10.0))
# Ranges in which undamped amplitudes, which go like omega**4, stay below some hundreds.
speed_limits = st.tuples(st.sampled_from([0.0, 0.05, 0.4]), st.floats(0.5, 4.0))
clearance_limits = st.tuples(st.sampled_from([0.0, 0.3, 1.0]), st.floats(1.1, 5.0))


def columns(curve):
    """The points of one curve, shape (n,), by name, with the parameters that are given."""
    chosen = np.flatnonzero(curve.piece.values.ravel() >= 0)
    names = ("omega", "zeta", "delta0", "amplitude", "phase_lag", "stability", "in_contact")
    wide = curve.broadcast_like(curve.amplitude)
    found = {name: wide[name].values.ravel() for name in (*names[3:], "piece")}
    for name in names[:3]:
        values = curve[name].values.ravel()
        found[name] = values if values.size > 1 else np.full(curve.sizes["point"], values[0])
    return {name: values[chosen] for name, values in found.items()}


def crossings(points, varied, value):
    """Amplitudes at which the lines between successive points pass a value."""
    x, A = points[varied], points["amplitude"]
    passes = ((x[:-1] - value) * (x[1:] - value) < 0.0) & (np.diff(points["piece"]) == 0)
    first = np.flatnonzero(passes)
    part = (value - x[first]) / (x[first + 1] - x[first])
    return np.sort(A[first] + part * (A[first + 1] - A[first]))


def assert_on_the_whirl_equation(points):
    """The residual is no larger than what rounding of A and of each term makes of it."""
    A, q = points["amplitude"], points["omega"] ** 2
    u = np.sqrt(np.maximum(A - points["delta0"], 0.0))
    damping = 4.0 * points["zeta"] ** 2 * q * A**2
    excess = np.where(points["in_contact"] == 1, u**3, 0.0) - q * A
    residual = excess**2 + damping - q**2
    size = excess**2 + damping + q**2 + 2.0 * abs(excess) * (u**3 + q * A + 1.5 * u * A)
    assert (abs(residual) <= 1e-14 * size).all()


def assert_agrees_with_the_whirls(points, varied, low, high, **parameters):
    """At a value between the limits the curve passes once for each whirl, and close to it."""
    for part in (0.123, 0.456, 0.789):
        value = low + part * (high - low)
        whirls = synchronous_response(**{varied: value}, **parameters)
        exact = whirls.amplitude.values.ravel()
        exact = exact[np.isfinite(exact)]
        found = crossings(points, varied, value)
        assert found.size == exact.size
        # lines between 200 points on a monotone arc leave it by 1e-3 of its height at most
        np.testing.assert_allclose(found, exact, atol=1e-3 * points["amplitude"].max())


@settings(max_examples=60, deadline=None)
@given(zeta=dampings, delta0=clearances, limits=speed_limits)
def test_curve_over_the_speed_is_on_the_whirls_and_whole(zeta, delta0, limits):
    points = columns(response_curve(zeta=zeta, delta0=delta0, limits=limits))
    assume(points["omega"].size > 0)
    assert_on_the_whirl_equation(points)
    assert_agrees_with_the_whirls(points, "omega", *limits, zeta=zeta, delta0=delta0)


@settings(max_examples=60, deadline=None)
@given(zeta=dampings, omega=st.floats(0.2, 4.0), limits=clearance_limits)
def test_curve_over_the_clearance_is_on_the_whirls_and_whole(zeta, omega, limits):
    points = columns(clearance_curve(omega=omega, zeta=zeta, limits=limits))
    assume(points["delta0"].size > 0)
    assert_on_the_whirl_equation(points)
    assert_agrees_with_the_whirls(points, "delta0", *limits, omega=omega, zeta=zeta)


@settings(max_examples=40, deadline=None)
@given(zeta=dampings, delta0=clearances)
def test_stability_changes_at_the_folds_and_nowhere_else(zeta, delta0):
    points = columns(response_curve(zeta=zeta, delta0=delta0, limits=(0.0, 50.0), points=20))
    exact = folds(zeta=zeta, delta0=delta0)
    inside = (exact.fold_omega <= 50.0).values.ravel()
    same = np.diff(points["piece"]) == 0
    change = np.flatnonzero(same & (np.diff(points["stability"]) != 0))
    found = sorted(zip(points["omega"][change], points["amplitude"][change], strict=True))
    expected = np.stack([exact.fold_omega.values.ravel(), exact.fold_amplitude.values.ravel()])
    np.testing.assert_array_equal(np.array(found).reshape(-1, 2), expected.T[inside])


@pytest.mark.parametrize("delta0", [0.0, 0.5, 1.0, 2.0])
def test_stability_is_that_of_the_determinant(delta0):
    points = columns(response_curve(zeta=0.07, delta0=delta0, limits=(0.05, 3.0)))
    place = {name: points[name] for name in ("omega", "zeta", "delta0")}
    determinant = stability_determinant(points["amplitude"], **place)
    # at folds and near the first touch the sign of a rounded determinant is not certain
    certain = (points["in_contact"] == 1) & (abs(determinant) > 1e-9)
    assert certain.sum() > 500
    unstable = points["stability"] == STABILITY["unstable"]
    np.testing.assert_array_equal(determinant[certain] < 0.0, unstable[certain])


@pytest.mark.parametrize(("omega", "count"), [(1.2, 2), (1.7, 1), (2.5, 0)])
def test_folds_over_the_clearance_are_folds_over_the_speed(omega, count):
    points = columns(clearance_curve(omega=omega, zeta=0.07, limits=(0.0, 8.0)))
    change = np.flatnonzero((np.diff(points["stability"]) != 0) & (np.diff(points["piece"]) == 0))
    assert change.size == count
    for delta0, amplitude in zip(
        points["delta0"][change], points["amplitude"][change], strict=True
    ):
        exact = folds(zeta=0.07, delta0=delta0)
        nearest = float(abs(exact.fold_omega / omega - 1.0).min())
        assert nearest < 1e-12
        assert float(abs(exact.fold_amplitude / amplitude - 1.0).min()) < 1e-11


def test_flanks_meet_at_the_peak_and_never_without_damping():
    for delta0 in (0.0, 0.5, 2.0):
        damped = columns(response_curve(zeta=0.07, delta0=delta0, limits=(0.05, 3.0)))
        assert damped["amplitude"].max() == peak_amplitude(zeta=0.07, delta0=delta0)
    undamped = columns(response_curve(zeta=0.0, delta0=0.5, limits=(0.05, 3.0)))
    assert set(undamped["piece"]) == {0, 1}
    assert set(undamped["phase_lag"][undamped["piece"] == 0]) == {0.0}
    assert set(undamped["phase_lag"][undamped["piece"] == 1]) == {np.pi}
    assert undamped["omega"][undamped["piece"] == 0].max() == 3.0
    assert set(undamped["stability"]) == {STABILITY["neutral"], STABILITY["unstable"]}


@pytest.mark.parametrize("delta0", [1.0, 2.0])
def test_isola_is_closed_and_stays_one_piece_where_a_limit_cuts_it(delta0):
    whole = columns(response_curve(zeta=0.07, delta0=delta0, limits=(0.05, 3.0)))
    assert set(whole["piece"]) == {0, 1}
    isola = {name: values[whole["piece"] == 1] for name, values in whole.items()}
    assert isola["omega"][0] == isola["omega"][-1]
    assert isola["amplitude"][0] == isola["amplitude"][-1]
    cut = columns(response_curve(zeta=0.07, delta0=delta0, limits=(0.05, 1.2)))
    assert set(cut["piece"]) == {0, 1}
    ends = cut["omega"][cut["piece"] == 1][[0, -1]]
    np.testing.assert_array_equal(ends, [1.2, 1.2])


def test_isola_is_there_up_to_the_cusp():
    cusp = cusp_zeta(2.0)
    for factor, pieces in ((1.0 - 1e-6, {0, 1}), (1.0 + 1e-6, {0})):
        found = response_curve(zeta=cusp * factor, delta0=2.0, limits=(0.05, 3.0))
        assert set(columns(found)["piece"]) == pieces


def test_contact_begins_where_the_contact_free_whirl_ends():
    for points, varied in (
        (columns(response_curve(zeta=0.07, delta0=0.5, limits=(0.05, 3.0))), "omega"),
        (columns(clearance_curve(omega=1.7, zeta=0.07, limits=(0.0, 3.0))), "delta0"),
    ):
        free, touching = (points["piece"] == number for number in (0, 1))
        assert set(points["in_contact"][free]) == {0}
        assert set(points["stability"][free]) == {STABILITY["neutral"]}
        assert set(points["in_contact"][touching]) == {1}
        end = points[varied][free][-1] if varied == "omega" else points[varied][free][0]
        assert points[varied][touching][0] == pytest.approx(end, rel=1e-15)
        assert points["amplitude"][touching][0] == points["delta0"][touching][0]


def test_points_are_dense_where_the_curve_turns():
    points = columns(response_curve(zeta=0.07, delta0=0.5, limits=(0.05, 3.0)))
    here = points["in_contact"] == 1
    across = np.diff(points["omega"][here]) / 3.0
    up = np.diff(points["amplitude"][here]) / points["amplitude"].max()
    long = np.hypot(across, up) > 1e-6
    turn = np.diff(np.unwrap(np.arctan2(up, across)[long]))
    assert np.hypot(across, up).max() < 0.03
    assert abs(turn).max() < 0.2


def test_grid_holds_what_single_curves_hold():
    grid = response_curve(zeta=[0.07, 0.3], delta0=[0.0, 1.0], limits=(0.1, 3.0), points=30)
    for zeta in (0.07, 0.3):
        for delta0 in (0.0, 1.0):
            single = columns(response_curve(zeta=zeta, delta0=delta0, limits=(0.1, 3.0), points=30))
            part = columns(grid.sel(zeta=[zeta], delta0=[delta0]))
            for name, values in single.items():
                np.testing.assert_array_equal(part[name], values)


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ((1.0, 1.0), "limits must be two numbers, the lower first"),
        ((1.0,), "limits must be two numbers, the lower first"),
        ((-1.0, 1.0), "limits must be zero or positive"),
        ((0.0, 1e16), "limits must be .* 1e\\+15"),
    ],
)
def test_bad_limits_are_refused(limits, message):
    with pytest.raises(InputError, match=message):
        response_curve(zeta=0.07, delta0=0.0, limits=limits)
    with pytest.raises(InputError, match=message):
        clearance_curve(omega=1.0, zeta=0.07, limits=limits)


def test_rest_has_no_curve_over_the_clearance():
    with pytest.raises(InputError, match=r"omega must be positive, got 0\.0"):
        clearance_curve(omega=0.0, zeta=0.07, limits=(0.0, 1.0))
