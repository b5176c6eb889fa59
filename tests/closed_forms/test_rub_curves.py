"""Response curves with friction: every whirl on them, and their tips, by other ways."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from rotor_ida.closed_forms import (
    clearance_curve,
    peak_amplitude,
    peaks,
    response_curve,
    speeds_at_amplitude,
    synchronous_response,
)
from rotor_ida.errors import InputError
from rotor_ida.schema import STABILITY

MACHINES = [
    {"zeta": 0.07, "friction": 0.1},
    {"zeta": 0.02, "friction": 0.03, "shaft_stiffness": 0.3},
    {"zeta": 0.1, "friction": 0.4, "shaft_stiffness": 2.0, "contact_exponent": 1.0},
    {"zeta": 0.01, "friction": 0.05, "contact_exponent": 1.0},
    {"zeta": 0.05, "friction": 0.02, "shaft_stiffness": 0.2, "contact_damping": 0.4},
    {"zeta": 0.0, "friction": 0.2},
    {"zeta": 0.0, "friction": 0.1, "shaft_stiffness": 0.5, "contact_exponent": 1.0},
]  # fmt: skip


def amplitude_error(found, machine, omega, delta0):
    """By how much the points in contact miss the stated equation, in parts of its terms."""
    A = found.amplitude.values.ravel()
    f = np.maximum(A - delta0, 0.0) ** machine.get("contact_exponent", 1.5)
    along = (machine.get("shaft_stiffness", 0.0) - omega**2) * A + f
    across = 2.0 * machine["zeta"] * omega * A + machine["friction"] * f
    error = (np.hypot(along, across) - omega**2) / (omega**2 * np.maximum(A, 1.0) + f)
    lag = np.arctan2(across, along) - found.phase_lag.values.ravel()
    touching = found.in_contact.values.ravel() == 1
    return np.abs(error[touching]).max(), np.abs(lag[touching]).max()


def crossings(found, varied, value):
    """Amplitude and stability where the curve, point to point, passes a value."""
    columns = [found[name].values.ravel() for name in (varied, "amplitude", "stability", "piece")]
    touching = found.in_contact.values.ravel() == 1
    passed = []
    for piece in np.unique(columns[3][touching]):
        x, A, flag = (each[touching & (columns[3] == piece)] for each in columns[:3])
        for k in np.nonzero((x[:-1] - value) * (x[1:] - value) < 0.0)[0]:
            part = (value - x[k]) / (x[k + 1] - x[k])
            same = flag[k] if flag[k] == flag[k + 1] else None
            passed.append((A[k] + part * (A[k + 1] - A[k]), same))
    return sorted(passed, key=lambda each: each[0])


def assert_crossed(found, varied, value, rotor):
    here = synchronous_response(**rotor)
    touching = here.in_contact.values.ravel() == 1
    expected = here.amplitude.values.ravel()[touching]
    flags = here.stability.values.ravel()[touching]
    passed = crossings(found, varied, value)
    assert len(passed) == expected.size, rotor
    for (amplitude, flag), exact, exact_flag in zip(passed, expected, flags, strict=True):
        assert amplitude == pytest.approx(exact, rel=0.02)
        assert flag is None or flag == exact_flag, rotor


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("delta0", [0.5, 1.3])
def test_every_whirl_is_on_the_curve_over_the_speed(machine, delta0):
    found = response_curve(**machine, delta0=delta0, limits=(0.05, 5.0), points=100)
    omega = found.omega.values.ravel()
    if (found.in_contact == 1).any():
        assert max(amplitude_error(found, machine, omega, delta0)) < 1e-12
    for value in np.random.default_rng(1).uniform(0.06, 4.9, 25):
        rotor = machine | {"delta0": delta0, "omega": value}
        assert_crossed(found, "omega", value, rotor)


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("omega", [0.5, 1.7])
def test_every_whirl_is_on_the_curve_over_the_clearance(machine, omega):
    found = clearance_curve(**machine, omega=omega, limits=(0.01, 4.0), points=100)
    delta0 = found.delta0.values.ravel()
    assert max(amplitude_error(found, machine, omega, delta0)) < 1e-12
    for value in np.random.default_rng(2).uniform(0.02, 3.9, 25):
        rotor = machine | {"omega": omega, "delta0": value}
        assert_crossed(found, "delta0", value, rotor)


@pytest.mark.parametrize("machine", MACHINES)
def test_speeds_at_an_amplitude_give_it_back(machine):
    machine = {name: each for name, each in machine.items() if name != "contact_damping"}
    amplitudes = np.array([0.4, 0.8, 1.05, 1.5, 3.0, 500.0])
    speeds = speeds_at_amplitude(amplitudes, delta0=0.5, **machine)
    assert np.isnan(speeds[0]).all()  # inside the clearance
    assert np.isfinite(speeds[1]).tolist() == [True, False]  # one flank below 1
    assert np.isnan(speeds[-1]).all()  # beyond the peak
    count = 0
    for amplitude, pair in zip(amplitudes, speeds, strict=True):
        for omega in pair[np.isfinite(pair)]:
            here = synchronous_response(omega=omega, delta0=0.5, **machine).amplitude
            assert np.abs(here / amplitude - 1.0).min() < 1e-11
            count += 1
    assert count >= 3


@pytest.mark.parametrize("machine", MACHINES)
def test_the_peak_is_the_largest_amplitude_over_the_speed(machine):
    machine = {name: each for name, each in machine.items() if name != "contact_damping"}
    found = peaks(delta0=0.5, **machine)
    amplitude, omega, force = (found[name].item() for name in found.data_vars)
    assert peak_amplitude(delta0=0.5, **machine) == amplitude

    def largest(speed):
        return -np.nanmax(synchronous_response(omega=speed, delta0=0.5, **machine).amplitude)

    near = (omega * (1.0 - 1e-3), omega * (1.0 + 1e-3))
    best = minimize_scalar(largest, bounds=near, method="bounded", options={"xatol": 1e-10})
    assert -best.fun == pytest.approx(amplitude, rel=1e-12)
    assert best.x == pytest.approx(omega, rel=1e-6)
    assert force == pytest.approx((amplitude - 0.5) ** machine.get("contact_exponent", 1.5))
    beyond = np.linspace(0.05, 6.0, 200)
    assert (
        np.nanmax(synchronous_response(omega=beyond, delta0=0.5, **machine).amplitude) <= amplitude
    )


def test_friction_alone_bounds_the_amplitude():
    """Without shaft and damping the flanks meet at A = sqrt(1 + 1/mu**2), whatever the contact."""
    for mu in (0.05, 0.3, 1.0):
        expected = math.sqrt(1.0 + 1.0 / mu**2)
        for exponent in (1.0, 1.5):
            given = {"delta0": 0.5, "friction": mu, "contact_exponent": exponent}
            assert peak_amplitude(zeta=0.0, **given) == pytest.approx(expected, rel=1e-14)


def test_a_curve_loses_its_stability_at_a_hopf_point():
    """At zeta 0.07, delta0 0.5, mu 0.1 the large rub is unstable from 1.12297 on, its fold far."""
    found = response_curve(zeta=0.07, delta0=0.5, friction=0.1, limits=(1.0, 1.3), points=400)
    touching = found.in_contact.values.ravel() == 1
    speeds, flags = (found[name].values.ravel()[touching] for name in ("omega", "stability"))
    unstable, stable = (flags == STABILITY[word] for word in ("unstable", "stable"))
    assert speeds[unstable].min() == pytest.approx(1.1229705385, abs=2e-3)
    assert speeds[stable].max() == pytest.approx(1.1229705385, abs=2e-3)
    assert (unstable | stable).all()


def test_without_friction_curves_are_the_same_to_the_last_bit():
    given = {"zeta": 0.07, "delta0": [0.5, 1.5], "shaft_stiffness": 0.2, "limits": (0.05, 4.0)}
    plain = response_curve(**given)
    assert response_curve(**given, friction=0.0).identical(plain)
    axis = response_curve(**given, friction=[0.0, 0.1])
    assert axis.omega.dims == ("zeta", "delta0", "friction", "point")
    smooth = axis.sel(friction=0.0)
    for name in plain.data_vars:
        bits = smooth[name].values[..., : plain.sizes["point"]]
        np.testing.assert_array_equal(bits, plain[name].values)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: peaks(zeta=0.0, delta0=0.5), "zeta must be positive"),
        (lambda: peaks(zeta=0.1, delta0=0.0, friction=0.1), "friction must be 0 without clearance"),
        (lambda: peaks(zeta=0.1, delta0=0.5, friction=1e-30), "friction must be 0 or between"),
        (lambda: clearance_curve(omega=1.0, zeta=0.1, friction=0.1, limits=(0.0, 1.0)),
         "friction must be 0 without clearance"),
        (lambda: response_curve(zeta=0.0, delta0=0.5, contact_exponent=1.0, friction=[0.0, 0.1],
                                limits=(0.1, 1.0)), "zeta must be positive for the curve"),
    ],
)  # fmt: skip
def test_odd_values_are_refused(call, says):
    with pytest.raises(InputError, match=says):
        call()
