"""The curve at given amplitude: flanks beside the backbone, and the peak where they meet."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from rotor_ida import InputError, synchronous_response
from rotor_ida.closed_forms import (
    backbone,
    peak_amplitude,
    peaks,
    response_curve,
    speeds_at_amplitude,
)

LAWS = [(0.0, 1.5), (0.0, 1.0), (0.3, 1.0), (0.3, 1.5), (2.0, 1.5)]
# With friction.
RUBBING = [
    {"zeta": 0.07, "friction": 0.1},
    {"zeta": 0.02, "friction": 0.03, "shaft_stiffness": 0.3},
    {"zeta": 0.1, "friction": 0.4, "shaft_stiffness": 2.0, "contact_exponent": 1.0},
    {"zeta": 0.01, "friction": 0.05, "contact_exponent": 1.0},
    {"zeta": 0.05, "friction": 0.02, "shaft_stiffness": 0.2},
    {"zeta": 0.0, "friction": 0.2},
    {"zeta": 0.0, "friction": 0.1, "shaft_stiffness": 0.5, "contact_exponent": 1.0},
]

TIPS = [rotor | {"delta0": 0.5} for rotor in RUBBING] + [
    {"zeta": zeta, "delta0": delta0, "shaft_stiffness": kappa, "contact_exponent": exponent}
    for zeta, delta0 in ((0.07, 0.0), (0.1, 0.5), (0.07, 2.0), (0.2, 0.5), (0.19, 0.95))
    for kappa, exponent in LAWS
]


def test_strong_damping_leaves_no_peak():
    assert np.isnan(peak_amplitude(zeta=1.0, delta0=0.0))
    assert np.isnan(peak_amplitude(zeta=0.3, delta0=2.0))
    with pytest.raises(InputError, match=r"zeta must be positive, got 0\.0"):
        peak_amplitude(zeta=0.0, delta0=0.0)


@pytest.mark.parametrize(("kappa", "exponent"), LAWS)
@pytest.mark.parametrize("delta0", [0.0, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("zeta", [0.0, 0.01, 0.07, 0.5, 2.0])
def test_speeds_at_given_amplitude_are_those_of_the_whirls(zeta, delta0, kappa, exponent):
    rotor = {
        "zeta": zeta, "delta0": delta0, "shaft_stiffness": kappa, "contact_exponent": exponent,
    }  # fmt: skip
    whirls = synchronous_response(omega=np.linspace(0.15, 3.0, 40), **rotor)
    whirls = whirls.squeeze(("zeta", "delta0"))
    touching = (whirls.in_contact.values == 1) & (whirls.amplitude.values > delta0)
    amplitude = whirls.amplitude.values[touching]
    omega = np.broadcast_to(whirls.omega.values[:, None], touching.shape)[touching]
    assert amplitude.size > 10 or zeta >= 0.5
    if amplitude.size == 0:
        return
    error = np.abs(speeds_at_amplitude(amplitude, **rotor) / omega[:, None] - 1.0)
    error = np.nanmin(error, axis=1)
    # omega is as uncertain as A near the touch and the tip, where A hardly changes with omega
    assert error.max() < 1e-6
    assert np.median(error) < 1e-14


def test_peak_of_a_linear_contact_without_clearance_is_that_of_an_oscillator():
    """``1/(2 zeta sqrt(1 - zeta**2))`` where damping ratio and speed are those of ``1 + kappa``."""
    for kappa in (0.0, 3.0):
        found = peaks(zeta=0.1, delta0=0.0, shaft_stiffness=kappa, contact_exponent=1.0)
        ratio = 0.1 / np.sqrt(1.0 + kappa)
        exact = 1.0 / (2.0 * ratio * np.sqrt(1.0 - ratio**2))
        assert found.peak_amplitude.item() == pytest.approx(exact, rel=1e-14)
        speed = np.sqrt((1.0 + kappa) / (1.0 - 2.0 * ratio**2))
        assert found.peak_omega.item() == pytest.approx(speed, rel=1e-13)


@pytest.mark.parametrize("kappa", [0.0, 0.5, 600.0, 1e5])
def test_at_an_amplitude_of_1_with_friction_the_speed_is_the_root_of_a_quadratic(kappa):
    zeta, mu, force = 0.016, 0.036, 0.5
    found = speeds_at_amplitude(
        1.0, zeta=zeta, delta0=0.5, shaft_stiffness=kappa, contact_exponent=1.0, friction=mu
    )
    holding = kappa + force
    roots = np.roots(
        [2 * holding - 4 * zeta**2, -4 * mu * zeta * force, -(holding**2) - (mu * force) ** 2]
    )
    np.testing.assert_allclose(found, [[roots.max(), np.nan]], rtol=1e-14)


def test_backbone_with_a_shaft_is_its_free_whirl():
    law = {"shaft_stiffness": 0.4, "contact_exponent": 1.0}
    found = backbone([0.2, 0.5, 1.5, 10.0], 0.5, **law)
    np.testing.assert_allclose(found**2, [0.4, 0.4, 0.4 + 1.0 / 1.5, 0.4 + 0.95], rtol=1e-15)
    assert backbone([0.0], contact_exponent=1.0).item() == 1.0
    slower, faster = speeds_at_amplitude([1.2, 2.0], zeta=0.05, delta0=0.5, **law).T
    middle = backbone([1.2, 2.0], 0.5, **law)
    assert (slower < middle).all()
    assert (faster > middle).all()


def test_flanks_that_meet_at_no_speed_are_no_peak():
    """A linear ring with f(1) = 2 zeta**2: the curve only rises towards 1."""
    curve = response_curve(zeta=0.5, delta0=0.5, contact_exponent=1.0, limits=(0.5, 50.0))
    assert float(curve.amplitude.max()) < 1.0
    found = peaks(zeta=0.5, delta0=0.5, contact_exponent=1.0)
    assert not (found.peak_omega < np.inf).any()


@pytest.mark.parametrize("rotor", RUBBING)
def test_speeds_at_an_amplitude_give_it_back(rotor):
    amplitudes = np.array([0.4, 0.8, 1.05, 1.5, 3.0, 500.0])
    speeds = speeds_at_amplitude(amplitudes, delta0=0.5, **rotor)
    assert np.isnan(speeds[0]).all()  # inside the clearance
    assert np.isfinite(speeds[1]).tolist() == [True, False]  # one flank below 1
    assert np.isnan(speeds[-1]).all()  # beyond the peak
    count = 0
    for amplitude, pair in zip(amplitudes, speeds, strict=True):
        for omega in pair[np.isfinite(pair)]:
            here = synchronous_response(omega=omega, delta0=0.5, **rotor).amplitude
            assert np.abs(here / amplitude - 1.0).min() < 1e-11
            count += 1
    assert count >= 3


@pytest.mark.parametrize("rotor", TIPS)
def test_the_peak_is_the_largest_amplitude_over_the_speed(rotor):
    found = peaks(**rotor)
    amplitude, omega, force = (found[name].item() for name in found.data_vars)
    np.testing.assert_equal(peak_amplitude(**rotor), amplitude)
    over = synchronous_response(omega=np.linspace(0.05, 6.0, 400), **rotor)
    highest = float(over.amplitude.where(over.in_contact == 1).max())
    if np.isnan(amplitude):  # then the curve only rises towards 1, or there is no whirl in contact
        assert not highest > 1.0
        return
    assert highest <= amplitude

    def largest(speed):
        return -np.nanmax(synchronous_response(omega=speed, **rotor).amplitude)

    near = (omega * (1.0 - 1e-3), omega * (1.0 + 1e-3))
    best = minimize_scalar(largest, bounds=near, method="bounded", options={"xatol": 1e-10})
    assert -best.fun == pytest.approx(amplitude, rel=1e-12)
    assert best.x == pytest.approx(omega, rel=1e-6)
    law = rotor.get("contact_exponent", 1.5)
    assert force == pytest.approx((amplitude - rotor["delta0"]) ** law, rel=1e-15)
    beyond, at_most = speeds_at_amplitude(amplitude * (1.0 + np.array([1e-12, -1e-12])), **rotor)
    assert np.isnan(beyond).all()
    np.testing.assert_allclose(at_most, omega, rtol=1e-5)


def test_friction_alone_bounds_the_amplitude():
    """Without shaft and damping the flanks meet at A = sqrt(1 + 1/mu**2), whatever the contact."""
    for mu in (0.05, 0.3, 1.0):
        expected = math.sqrt(1.0 + 1.0 / mu**2)
        for exponent in (1.0, 1.5):
            given = {"delta0": 0.5, "friction": mu, "contact_exponent": exponent}
            assert peak_amplitude(zeta=0.0, **given) == pytest.approx(expected, rel=1e-14)
