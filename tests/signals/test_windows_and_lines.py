"""Known answers: orders and lines of whirls made by hand, on and off the grid, and windows."""

import math

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    InputError,
    Rotor,
    centre_line,
    filtered_orbit,
    full_spectrum,
    limit_cycle,
    orders,
    simulate,
    spectral_lines,
    whirl_ratio,
)

TIMES = np.arange(4000) / 1000
ANGLES = 2.0 * math.pi * 10.3 * TIMES


def made(z, angles=ANGLES):
    return xr.Dataset(
        {"x": ("t", z.real), "y": ("t", z.imag), "angle": ("t", angles)}, {"t": TIMES}
    )


def noise(seed, deviation):
    x, y = np.random.default_rng(seed).normal(size=(2, TIMES.size)) * deviation
    return x + 1j * y


WHIRL = 0.7 * np.exp(1j * (ANGLES - 0.4))


def test_a_synchronous_whirl_is_one_forward_line_of_its_amplitude_and_phase():
    found = orders(made(WHIRL + 0.2j), [1, 2]).isel(order=0)
    np.testing.assert_allclose(found.forward_whirl_amplitude, 0.7, rtol=1e-10)
    np.testing.assert_allclose(found.forward_phase_lag, 0.4, rtol=1e-10)
    assert found.backward_whirl_amplitude.max() < 1e-10
    np.testing.assert_allclose(found.offset_y, 0.2, rtol=1e-10)
    np.testing.assert_allclose(found.speed, 2.0 * math.pi * 10.3, rtol=1e-10)


def test_a_backward_whirl_has_its_lag_and_ratio():
    signals = made(0.3 * np.exp(-2j * (ANGLES - 0.1)))
    found = orders(signals, 2)
    np.testing.assert_allclose(found.backward_whirl_amplitude, 0.3, rtol=1e-10)
    np.testing.assert_allclose(found.backward_phase_lag, 0.2, rtol=1e-9)
    np.testing.assert_allclose(whirl_ratio(signals).whirl_over_spin, -2.0, rtol=1e-9)
    np.testing.assert_allclose(whirl_ratio(signals).whirl_sense, -1)


def test_filtered_orbit_keeps_one_order():
    found = filtered_orbit(made(WHIRL + 0.3 * np.exp(3j * ANGLES)), order=1)
    np.testing.assert_allclose(found.x + 1j * found.y, WHIRL, atol=1e-10)


def test_lines_of_a_run_are_those_of_its_exact_cycle():
    """Shooting and a Fourier series over one period know nothing of the record."""
    rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
    cycle = limit_cycle(rotor, start=(3.0, 1.0, 0.0, 0.0))
    start = [float(cycle[name][0]) for name in ("x", "y", "vx", "vy")]
    length = 60.0 * float(cycle.period)
    run = simulate(
        rotor, start=start, duration=length, samples=12001, method="taylor", rtol=1e-12, atol=1e-14
    )
    found = spectral_lines(run, count=6)
    highest = np.sort(np.argsort(-cycle.whirl_amplitude.values)[:6])
    exact = cycle.isel(line=highest)
    np.testing.assert_allclose(found.frequency, exact.frequency, atol=1e-11)
    np.testing.assert_allclose(found.whirl_amplitude, exact.whirl_amplitude, atol=1e-11)


def test_lines_have_their_phase_at_the_time_0_and_their_order():
    z = 0.5 * np.exp(1j * (2.5 * ANGLES + 0.3)) + 0.2 * np.exp(-1j * (ANGLES - 0.7))
    found = spectral_lines(made(z).isel(t=slice(500, None)), count=5)
    np.testing.assert_allclose(found.frequency_over_omega, [-1.0, 2.5], rtol=1e-10)
    np.testing.assert_allclose(found.whirl_amplitude, [0.2, 0.5], rtol=1e-10)
    np.testing.assert_allclose(found.whirl_phase, [0.7, 0.3], atol=1e-9)
    assert found.window_residual < 1e-11


@pytest.mark.parametrize("window", ["hann", "flattop", "boxcar"])
def test_the_noise_floor_counts_segments_that_overlap_as_fewer(window):
    """White noise has the same density everywhere: 2 s**2 over the sampling rate."""
    density = 2.0 / (2.0 * math.pi * 1000.0)
    found = []
    for seed in range(20):
        lines = full_spectrum(made(noise(seed, 1.0)), window=window, segment=500)
        found.append(float(lines.noise_floor**2 / lines.bandwidth) / density)
    error = np.std(found) / math.sqrt(len(found))
    assert error < 0.01
    assert np.mean(found) == pytest.approx(1.0, abs=4.0 * error)


def test_windows_that_overlap_hold_those_that_do_not():
    z = (0.7 + 0.1j * TIMES) * np.exp(1j * ANGLES) + noise(3, 0.01)
    plain, closer = (orders(made(z), [0.5, 1], overlap=part) for part in (0.0, 0.75))
    # of 41.2 revolutions: windows of two, every half revolution
    assert (plain.sizes["window"], closer.sizes["window"]) == (20, math.floor(39.2 / 0.5) + 1)
    for name in ("t", "speed", "forward_whirl_amplitude", "offset_x", "window_residual"):
        np.testing.assert_allclose(closer[name][::4], plain[name], rtol=1e-12, atol=1e-14)


def test_mean_position_and_ratio_take_windows_that_overlap():
    signals = made(0.2j + 0.3 * np.exp(-0.5j * ANGLES))
    ratio = whirl_ratio(signals, revolutions=2, overlap=0.5).whirl_over_spin
    np.testing.assert_allclose(ratio, -0.5, rtol=0.05)
    assert centre_line(signals, overlap=0.5).sizes["window"] == 81


def test_lines_that_cannot_be_found_are_refused():
    with pytest.raises(InputError, match="must move"):
        spectral_lines(made(0.0 * ANGLES + 0.0j))
    with pytest.raises(InputError, match="at least 208 samples, got 100"):
        spectral_lines(made(np.exp(1j * ANGLES)).isel(t=slice(100)), count=50)
