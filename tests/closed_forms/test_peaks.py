"""The curve at given amplitude: flanks beside the backbone, and the peak where they meet."""

import numpy as np
import pytest

from rotor_ida import InputError, synchronous_response
from rotor_ida.closed_forms import (
    backbone,
    peak_amplitude,
    peaks,
    response_curve,
    speeds_at_amplitude,
)
from rotor_ida.model.contact import contact_force


@pytest.mark.parametrize("delta0", [0.0, 0.5, 2.0])
def test_peak_lies_on_the_curve_and_nothing_is_higher(delta0):
    found = peaks(zeta=0.07, delta0=delta0)
    omega, A = found.peak_omega.item(), found.peak_amplitude.item()
    here = synchronous_response(omega=omega, zeta=0.07, delta0=delta0)
    # near the tip the amplitude goes like the root of the speed
    assert float(abs(here.amplitude / A - 1.0).min()) < 1e-6
    around = omega * (1.0 + np.linspace(-0.01, 0.01, 2001))
    beside = synchronous_response(omega=around, zeta=0.07, delta0=delta0)
    assert float(beside.amplitude.max()) <= A * (1.0 + 1e-12)


def test_clearance_lowers_peak_speed_and_force():
    found = peaks(zeta=0.07, delta0=np.linspace(0.0, 3.0, 31)).squeeze()
    for name in ("peak_amplitude", "peak_omega", "peak_contact_force"):
        assert (np.diff(found[name].values) < 0.0).all()


def test_force_is_that_of_the_contact_law():
    found = peaks(zeta=0.07, delta0=0.5)
    force = contact_force(found.peak_amplitude.values, 0.5)
    np.testing.assert_allclose(found.peak_contact_force.values, force)


def test_no_peak_with_strong_damping():
    assert np.isnan(peaks(zeta=1.0, delta0=0.0).peak_omega.item())
    with pytest.raises(InputError, match="zeta must be positive"):
        peaks(zeta=0.0, delta0=0.0)


def test_backbone_is_the_speed_of_the_undamped_free_whirl():
    amplitudes = np.array([0.2, 0.5, 1.5, 10.0])
    expected = [0.0, 0.0, np.sqrt(1.0 / 1.5), np.sqrt(9.5**1.5 / 10.0)]
    np.testing.assert_allclose(backbone(amplitudes, 0.5), expected, rtol=1e-15)


@pytest.mark.parametrize("delta0", [0.0, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("zeta", [0.0, 0.01, 0.07, 0.5, 2.0])
def test_curve_at_given_amplitude_finds_the_whirls_again(zeta, delta0):
    whirls = synchronous_response(omega=np.linspace(0.15, 3.0, 40), zeta=zeta, delta0=delta0)
    touching = whirls.in_contact.values.ravel() == 1
    amplitude = whirls.amplitude.values.ravel()[touching]
    omega = np.broadcast_to(whirls.omega.values[:, None, None, None], whirls.amplitude.shape)
    omega = omega.ravel()[touching]
    assert amplitude.size > 0 or zeta >= 0.5
    speeds = (
        speeds_at_amplitude(amplitude, zeta=zeta, delta0=delta0)
        if amplitude.size
        else np.empty((0, 2))
    )
    error = np.nanmin(np.abs(speeds / omega[:, None] - 1.0), axis=1, initial=np.inf)
    # omega is as uncertain as A near the touch and the tip, where A hardly changes with omega
    assert (error < 1e-6).all()
    assert np.median(error) < 1e-14 if error.size else True


def test_curve_ends_at_its_peak():
    for zeta, delta0 in [(0.07, 0.0), (0.01, 0.5), (0.07, 1.0), (0.1, 2.0), (1e-4, 0.3)]:
        tip = peak_amplitude(zeta=zeta, delta0=delta0)
        beyond, at_most = speeds_at_amplitude(
            [tip * (1 + 1e-12), tip * (1 - 1e-12)], zeta=zeta, delta0=delta0
        )
        assert np.isnan(beyond).all()
        assert np.isfinite(at_most).all()
        assert at_most[1] / at_most[0] - 1.0 < 1e-5


def test_peak_amplitude_is_the_largest_on_a_dense_curve():
    for zeta, delta0 in [
        (0.07, 0.0),
        (0.2, 0.0),
        (0.2, 0.5),
        (0.1, 0.9),
        (0.1, 1.5),
        (0.19, 0.95),
    ]:
        omega = np.linspace(0.05, 6.0, 20001)
        whirls = synchronous_response(omega=omega, zeta=zeta, delta0=delta0)
        contacting = whirls.amplitude.where(whirls.in_contact == 1)
        assert float(contacting.max()) == pytest.approx(
            peak_amplitude(zeta=zeta, delta0=delta0), rel=1e-5
        )


def test_flanks_of_the_curve_lie_on_either_side_of_the_backbone():
    amplitude = np.linspace(1.2, 9.0, 50)
    slower, faster = speeds_at_amplitude(amplitude, zeta=0.07, delta0=0.5).T
    assert (slower < backbone(amplitude, 0.5)).all()
    assert (faster > backbone(amplitude, 0.5)).all()


def test_strong_damping_leaves_no_peak():
    assert np.isnan(peak_amplitude(zeta=1.0, delta0=0.0))
    assert np.isnan(peak_amplitude(zeta=0.3, delta0=2.0))
    with pytest.raises(InputError, match=r"zeta must be positive, got 0\.0"):
        peak_amplitude(zeta=0.0, delta0=0.0)


LAWS = [(0.0, 1.0), (0.3, 1.0), (0.3, 1.5), (2.0, 1.5)]


@pytest.mark.parametrize(("kappa", "exponent"), LAWS)
@pytest.mark.parametrize("delta0", [0.0, 0.5, 1.0, 2.0])
def test_curve_of_a_machine_at_given_amplitude_finds_the_whirls_again(kappa, exponent, delta0):
    law = {"shaft_stiffness": kappa, "contact_exponent": exponent}
    whirls = synchronous_response(
        omega=np.linspace(0.15, 3.0, 40), zeta=0.07, delta0=delta0, **law
    ).squeeze(("zeta", "delta0"))
    touching = whirls.in_contact.values == 1
    amplitude = whirls.amplitude.values[touching]
    omega = np.broadcast_to(whirls.omega.values[:, None], touching.shape)[touching]
    assert amplitude.size > 10
    speeds = speeds_at_amplitude(amplitude, zeta=0.07, delta0=delta0, **law)
    error = np.nanmin(np.abs(speeds / omega[:, None] - 1.0), axis=1)
    # omega is as uncertain as A near the touch and the tip, where A hardly changes with omega
    assert error.max() < 1e-6
    assert np.median(error) < 1e-14


@pytest.mark.parametrize(("kappa", "exponent"), LAWS)
def test_peak_of_a_machine_is_the_largest_of_its_whirls(kappa, exponent):
    law = {"shaft_stiffness": kappa, "contact_exponent": exponent}
    found = peaks(zeta=0.1, delta0=[0.0, 0.5, 1.5], **law).squeeze()
    for delta0 in (0.0, 0.5, 1.5):
        omega, A, force = (
            found[name].sel(delta0=delta0).item()
            for name in ("peak_omega", "peak_amplitude", "peak_contact_force")
        )
        around = synchronous_response(
            omega=omega * (1.0 + np.linspace(-0.02, 0.02, 2001)), zeta=0.1, delta0=delta0, **law
        )
        # near the tip the amplitude goes like the root of the speed
        assert float(around.amplitude.max()) == pytest.approx(A, rel=1e-5)
        far = synchronous_response(
            omega=np.linspace(0.05, 6.0, 5001), zeta=0.1, delta0=delta0, **law
        )
        assert float(far.amplitude.where(far.in_contact == 1).max()) <= A * (1.0 + 1e-12)
        assert force == pytest.approx((A - delta0) ** exponent, rel=1e-15)
        tip = peak_amplitude(zeta=0.1, delta0=delta0, **law)
        assert tip == A
        pair = speeds_at_amplitude(tip * (1.0 - 1e-12), zeta=0.1, delta0=delta0, **law)
        np.testing.assert_allclose(pair[0], omega, rtol=1e-5)


def test_peak_of_a_linear_machine_without_clearance_is_that_of_an_oscillator():
    """``1/(2 zeta sqrt(1 - zeta**2))`` where damping ratio and speed are those of ``1 + kappa``."""
    for kappa in (0.0, 3.0):
        found = peaks(zeta=0.1, delta0=0.0, shaft_stiffness=kappa, contact_exponent=1.0)
        ratio = 0.1 / np.sqrt(1.0 + kappa)
        exact = 1.0 / (2.0 * ratio * np.sqrt(1.0 - ratio**2))
        assert found.peak_amplitude.item() == pytest.approx(exact, rel=1e-14)
        speed = np.sqrt((1.0 + kappa) / (1.0 - 2.0 * ratio**2))
        assert found.peak_omega.item() == pytest.approx(speed, rel=1e-13)


def test_axes_of_machines_are_dimensions_and_numbers_coordinates():
    found = peaks(zeta=0.1, delta0=[0.0, 0.5], shaft_stiffness=[0.0, 0.3], contact_exponent=1.0)
    assert found.peak_amplitude.dims == ("zeta", "delta0", "shaft_stiffness")
    assert found.contact_exponent.item() == 1.0
    both = peaks(zeta=0.1, delta0=[0.0, 0.5], contact_exponent=[1.5, 1.0])
    plain = peaks(zeta=0.1, delta0=[0.0, 0.5])
    for name in plain:
        np.testing.assert_array_equal(both[name].sel(contact_exponent=1.5), plain[name])
        np.testing.assert_array_equal(
            both[name].sel(contact_exponent=1.0), found[name].sel(shaft_stiffness=0.0)
        )


def test_backbone_of_a_machine_is_its_free_whirl():
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
