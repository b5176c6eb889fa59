"""Response curves as curves: on the whirl equation, whole, in order, turning at folds alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotor_ida import folds, synchronous_response
from rotor_ida.closed_forms import clearance_curve, peak_amplitude, response_curve, touch_speeds
from rotor_ida.schema import STABILITY

dampings = st.one_of(st.just(0.0), st.floats(1e-4, 0.4), st.floats(0.4, 3.0))
clearances = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(1e-3, 1.3), st.floats(1.3, 10.0))
LIMITS = (0.05, 4.0)
# What the paper's rotor has beside speed, damping and clearance.
OTHERS = {"shaft_stiffness": 0.0, "contact_exponent": 1.5, "friction": 0.0}
# Over the speed.
ROTORS = [
    *({"zeta": zeta, "delta0": delta0} for zeta in (0.0, 0.07, 0.6) for delta0 in (0.5, 1.0, 2.0)),
    {"zeta": 0.07, "delta0": 0.5, "shaft_stiffness": 0.25},
    {"zeta": 0.07, "delta0": 2.0, "shaft_stiffness": 0.25},
    {"zeta": 0.07, "delta0": 2.0, "shaft_stiffness": 0.25, "contact_exponent": 1.0},
    {"zeta": 0.07, "delta0": 1.0, "shaft_stiffness": 0.25},
    {"zeta": 0.3, "delta0": 0.5, "shaft_stiffness": 2.0, "contact_damping": 0.5},
    {"zeta": 0.07, "delta0": 0.5, "shaft_stiffness": 0.1, "contact_exponent": 1.0,
     "contact_damping": 0.5},
    {"zeta": 0.0, "delta0": 0.5, "shaft_stiffness": 0.25},
    {"zeta": 0.0, "delta0": 2.0, "shaft_stiffness": 0.25},
    {"zeta": 0.07, "delta0": 4.0, "shaft_stiffness": 0.01},
    {"zeta": 0.07, "delta0": 0.5, "contact_exponent": 1.0},
    {"zeta": 0.07, "delta0": 2.0, "contact_exponent": 1.0},
    {"zeta": 1.0, "delta0": 0.5, "shaft_stiffness": 0.3},
    {"zeta": 0.07, "delta0": 0.5, "contact_damping": 0.7},
]  # fmt: skip
RUBBING = [
    {"zeta": 0.07, "friction": 0.1},
    {"zeta": 0.02, "friction": 0.03, "shaft_stiffness": 0.3},
    {"zeta": 0.1, "friction": 0.4, "shaft_stiffness": 2.0, "contact_exponent": 1.0},
    {"zeta": 0.01, "friction": 0.05, "contact_exponent": 1.0},
    {"zeta": 0.05, "friction": 0.02, "shaft_stiffness": 0.2, "contact_damping": 0.4},
    {"zeta": 0.0, "friction": 0.2},
    {"zeta": 0.0, "friction": 0.1, "shaft_stiffness": 0.5, "contact_exponent": 1.0},
]
ROTORS += [rotor | {"delta0": delta0} for rotor in RUBBING for delta0 in (0.5, 1.3)]
# Over the clearance.
AT_SPEEDS = [
    *({"zeta": zeta, "omega": omega} for zeta in (0.0, 0.07, 0.6) for omega in (0.4, 1.7, 3.0)),
    {"omega": 1.7, "zeta": 0.07, "shaft_stiffness": 0.25},
    {"omega": 0.4, "zeta": 0.07, "shaft_stiffness": 0.25},
    {"omega": 0.5, "zeta": 0.07, "shaft_stiffness": 0.25},
    {"omega": 1.0, "zeta": 0.07, "shaft_stiffness": 0.25, "contact_exponent": 1.0},
    {"omega": 0.4, "zeta": 0.07, "shaft_stiffness": 0.25, "contact_exponent": 1.0},
    {"omega": 1.4, "zeta": 0.1, "shaft_stiffness": 0.25, "contact_exponent": 1.0},
    {"omega": 1.7, "zeta": 0.07, "contact_damping": 0.7},
    {"omega": 1.3, "zeta": 0.02, "shaft_stiffness": 1.0},
    {"omega": 1.7, "zeta": 0.0, "shaft_stiffness": 0.25},
]
AT_SPEEDS += [rotor | {"omega": omega} for rotor in RUBBING for omega in (0.5, 1.7)]


def columns(curve):
    """The points of one curve, shape (n,), by name, with the parameters that are given."""
    chosen = np.flatnonzero(curve.piece.values.ravel() >= 0)
    wide = curve.broadcast_like(curve.amplitude)
    names = (*curve.data_vars, "zeta", "omega", "delta0", *(OTHERS.keys() & set(curve.coords)))
    found = {
        name: np.broadcast_to(wide[name].values, wide.amplitude.shape).ravel()[chosen]
        if wide[name].dims == wide.amplitude.dims
        else np.full(chosen.size, curve[name].item())
        for name in names
    }
    return {name: np.full(chosen.size, value) for name, value in OTHERS.items()} | found


def crossings(points, varied, value):
    """Amplitudes at which the lines between successive points pass a value, and their flags."""
    x, A, flag = points[varied], points["amplitude"], points["stability"]
    passes = ((x[:-1] - value) * (x[1:] - value) < 0.0) & (np.diff(points["piece"]) == 0)
    first = np.flatnonzero(passes)
    part = (value - x[first]) / (x[first + 1] - x[first])
    amplitude = A[first] + part * (A[first + 1] - A[first])
    order = np.argsort(amplitude)
    # of lines that pass a change of stability none
    flags = np.where(flag[first] == flag[first + 1], flag[first], -1)
    return amplitude[order], flags[order]


def assert_on_the_whirl_equation(points):
    """The residual is no larger than what rounding of A, delta0 and of each term makes of it."""
    A, omega, kappa, mu = (
        points[name] for name in ("amplitude", "omega", "shaft_stiffness", "friction")
    )
    q, exponent = omega**2, points["contact_exponent"]
    depth, touches = np.maximum(A - points["delta0"], 0.0), points["in_contact"] == 1
    force = np.where(touches, depth**exponent, 0.0)
    impedance = force + (kappa - q) * A + 1j * (2.0 * points["zeta"] * omega * A + mu * force)
    size = (1.0 + mu) * force + (kappa + q + 2.0 * points["zeta"] * omega) * A + q
    slope = np.where(touches, exponent * depth ** (exponent - 1.0), 0.0)
    slack = 1e-14 * (size + (1.0 + mu) * slope * (A + points["delta0"]))
    assert (np.abs(np.abs(impedance) - q) <= slack).all()
    off = np.abs(impedance * np.exp(-1j * points["phase_lag"]) - q)
    assert (off <= 10.0 * slack).all()


def assert_agrees_with_the_whirls(points, varied, values, parameters, **tolerance):
    """The curve passes once for each whirl, close to it, and both are as stable."""
    found_at = synchronous_response(**{varied: values}, **parameters)
    for number, value in enumerate(values):
        whirls = found_at.isel({varied: number})
        exact, stability = (
            whirls[name].values.ravel()[np.isfinite(whirls.amplitude.values.ravel())]
            for name in ("amplitude", "stability")
        )
        found, flags = crossings(points, varied, value)
        assert found.size == exact.size, (parameters, value)
        np.testing.assert_allclose(found, exact, **tolerance)
        assert (flags == stability)[flags >= 0].all(), (parameters, value)


@pytest.mark.parametrize("rotor", ROTORS)
def test_every_whirl_of_every_rotor_is_on_the_curve_over_the_speed(rotor):
    points = columns(response_curve(**rotor, limits=LIMITS))
    assert_on_the_whirl_equation(points)
    speeds = np.random.default_rng(3).uniform(*LIMITS, 30)
    assert_agrees_with_the_whirls(points, "omega", speeds, rotor, rtol=2e-2)
    marks = folds(**rotor)
    marks = list(
        zip(marks.fold_omega.values.ravel(), marks.fold_amplitude.values.ravel(), strict=True)
    )
    if rotor["delta0"] > 0.0:
        given = (rotor["zeta"], rotor["delta0"], rotor.get("shaft_stiffness", 0.0))
        names = ("zeta", "delta0", "shaft_stiffness")
        touches = touch_speeds(**dict(zip(names, given, strict=True)))
        marks += [(omega, rotor["delta0"]) for omega in touches]
    for omega, amplitude in marks:
        if LIMITS[0] < omega < LIMITS[1]:
            near = np.hypot(points["omega"] / omega - 1.0, points["amplitude"] / amplitude - 1.0)
            assert near.min() < 1e-12


@pytest.mark.parametrize(
    "law", [{}, {"shaft_stiffness": 0.25}, {"contact_exponent": 1.0}, {"contact_exponent": [1.0]}]
)
def test_the_curve_without_clearance_begins_at_rest(law):
    rotor = {"zeta": 0.07, "delta0": 0.0} | law
    points = columns(response_curve(**rotor, limits=(0.0, 4.0)))
    assert points["amplitude"][0] == 0.0
    assert_on_the_whirl_equation(points)
    slack = 1e-3 * points["amplitude"].max()
    speeds = np.random.default_rng(3).uniform(*LIMITS, 30)
    assert_agrees_with_the_whirls(points, "omega", speeds, rotor, atol=slack)


@pytest.mark.parametrize("rotor", AT_SPEEDS)
def test_every_whirl_of_every_rotor_is_on_the_curve_over_the_clearance(rotor):
    limits = (0.01, 4.0)
    points = columns(clearance_curve(**rotor, limits=limits))
    assert_on_the_whirl_equation(points)
    values = np.random.default_rng(2).uniform(*limits, 30)
    assert_agrees_with_the_whirls(points, "delta0", values, rotor, rtol=2e-2)


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


def test_a_contact_free_whirl_with_a_resonance_inside_the_clearance_is_one_piece():
    curve = response_curve(zeta=0.1, delta0=3.0, shaft_stiffness=0.25, limits=LIMITS)
    at = columns(curve)
    free = at["in_contact"] == 0
    assert set(at["piece"][free]) == {0}
    assert (at["stability"][free] == STABILITY["stable"]).all()
    top = at["amplitude"][free].argmax()
    assert at["omega"][free][top] == pytest.approx(0.25 / np.sqrt(0.25 - 0.02), rel=1e-14)
    expected = 0.25 / (0.2 * np.sqrt(0.25 - 0.01))
    assert at["amplitude"][free][top] == pytest.approx(expected, rel=1e-14)


def test_points_are_dense_where_the_curve_turns():
    points = columns(response_curve(zeta=0.07, delta0=0.5, limits=(0.05, 3.0)))
    here = points["in_contact"] == 1
    across = np.diff(points["omega"][here]) / 3.0
    up = np.diff(points["amplitude"][here]) / points["amplitude"].max()
    long = np.hypot(across, up) > 1e-6
    turn = np.diff(np.unwrap(np.arctan2(up, across)[long]))
    assert np.hypot(across, up).max() < 0.03
    assert abs(turn).max() < 0.2


def test_the_curve_of_a_linear_stator_that_the_free_whirl_just_touches_ends_at_speed_1():
    """There ``A**2 q**2 - 2 A f q + (1 + mu**2) f**2 = q**2``: q tends to 1 as f vanishes."""
    mu = 0.25
    curve = response_curve(
        zeta=0.0, delta0=1.0, friction=mu, contact_exponent=1.0, limits=(0.0, 2.0), points=40
    )
    rub = curve.squeeze().where(curve.squeeze().in_contact == 1, drop=True)
    force = rub.amplitude - 1.0
    turning = rub.omega**2
    balance = np.abs(force * (1.0 + 1j * mu) - turning * rub.amplitude) - turning
    assert np.abs(balance).max() < 1e-14
    assert (rub.omega[-1].item(), rub.amplitude[-1].item()) == (1.0, 1.0)
