"""Known answers of sums: Parseval's theorem, segments, and the statistics of white noise."""

import math

import numpy as np
import pytest
import xarray as xr
from scipy.signal import get_window

from rotor_ida import Rotor, filtered_orbit, full_spectrum, orders, run_up, simulate, spectrogram

TIMES = np.arange(20_000) / 1000
ANGLES = 2.0 * math.pi * 10.0 * TIMES
NOISE = 0.1


def made(z):
    return xr.Dataset(
        {"x": ("t", z.real), "y": ("t", z.imag), "angle": ("t", ANGLES)}, {"t": TIMES}
    )


def noise(seed):
    x, y = np.random.default_rng(seed).normal(size=(2, TIMES.size)) * NOISE
    return x + 1j * y


def test_squares_of_all_lines_add_up_to_the_mean_square_about_the_mean():
    """Parseval: with weights, the weighted mean square times the bandwidth over that of a line."""
    run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(2.6, 0.75, 0.66, -1.65),
                   duration=100.0, samples=2001)  # fmt: skip
    for window in ("boxcar", "hann", "flattop"):
        found = full_spectrum(run, window=window)
        weights = get_window(window, 2001)
        z = run.x.values + 1j * run.y.values
        z = z - np.average(z, weights=weights)
        mean_square = np.sum(weights**2 * np.abs(z) ** 2) / np.sum(weights**2)
        line = 2.0 * math.pi / (2001 * 0.05)
        assert float((found.whirl_amplitude**2).sum()) == pytest.approx(
            mean_square * found.bandwidth.item() / line, rel=1e-12
        )


def test_a_spectrogram_is_the_full_spectrum_of_each_stretch():
    run = run_up(Rotor(omega=0.3, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), to=2.0, rate=0.02,
                 samples=4001)  # fmt: skip
    for window, place in (("boxcar", 0), ("hann", 7), ("flattop", 17)):
        seen = spectrogram(run, window=window, segment=500, overlap=0.6)
        assert seen.sizes["window"] == (4001 - 500) // 200 + 1
        alone = seen.isel(window=place)
        stretch = run.isel(t=slice(200 * place, 200 * place + 500))
        lines = full_spectrum(stretch, window=window)
        np.testing.assert_allclose(alone.frequency, lines.frequency, rtol=1e-12)
        np.testing.assert_allclose(alone.whirl_amplitude, lines.whirl_amplitude, atol=1e-13)
        assert alone.bandwidth.item() == pytest.approx(lines.bandwidth.item(), rel=1e-12)
        assert alone.t.item() == pytest.approx(stretch.t.values.mean(), rel=1e-12)
        # a speed that rises evenly is in the middle what it is in the mean
        assert alone.speed.item() == pytest.approx(0.3 + 0.02 * alone.t.item(), rel=1e-10)


def test_the_noise_floor_is_not_moved_by_lines():
    """Ten lines, eight hundred times above it, each of which lifts at most twenty powers."""
    frequencies = np.random.default_rng(5).uniform(-3000.0, 3000.0, 10)
    z = noise(6) + np.exp(1j * np.outer(frequencies, TIMES)).sum(axis=0)
    found = full_spectrum(made(z), window="hann")
    exact = math.sqrt(2.0 * NOISE**2 * found.bandwidth.item() / (2.0 * math.pi * 1000.0))
    assert found.whirl_amplitude.max() > 800.0 * exact
    # the median of n exponential powers scatters by 1/(sqrt(n) ln 2) of itself; of 20,000 powers
    # Hann's weights leave half independent
    scatter = 4.0 / (math.sqrt(10_000) * math.log(2.0))
    lifted = 10 * 20 / 20_000 / math.log(2.0)
    assert -scatter < found.noise_floor.item() ** 2 / exact**2 - 1.0 < scatter + lifted


def test_stated_errors_of_orders_cover_what_noise_does_to_them():
    """Squares over those of the stated errors are exponential: mean 1 and variance 1, both parts.

    That of a lag is the error of the amplitude over the amplitude, for which half the variance is.
    """
    z = 0.7 * np.exp(1j * (ANGLES - 0.4)) + 0.5 * np.exp(-2j * (ANGLES - 0.3)) + noise(7)
    found = orders(made(z), [1, 2])
    windows = found.sizes["window"]
    assert windows == 200
    np.testing.assert_allclose(found.window_residual.mean(), math.sqrt(2.0) * NOISE, rtol=0.05)
    ahead = found.sel(order=1)
    exact = 0.7 * np.exp(-0.4j)
    whirl = ahead.forward_whirl_amplitude * np.exp(-1j * ahead.forward_phase_lag)
    squares = np.abs(whirl - exact) ** 2 / (2.0 * ahead.forward_amplitude_error**2)
    assert squares.mean().item() == pytest.approx(1.0, abs=4.0 / math.sqrt(windows))
    lags = (ahead.forward_phase_lag - 0.4) * 0.7 / ahead.forward_amplitude_error
    back = found.sel(order=2)
    sizes = (back.backward_whirl_amplitude - 0.5) / back.backward_amplitude_error
    for score in (lags, sizes):
        assert abs(score.mean().item()) < 4.0 / math.sqrt(windows)
        assert score.std().item() == pytest.approx(1.0, abs=4.0 / math.sqrt(2.0 * windows))
        within = float((abs(score) < 1.96).mean())
        assert within == pytest.approx(0.95, abs=4.0 * math.sqrt(0.05 * 0.95 / windows))


def whirl_beside(rng, size, revolutions, speeding=0.0):
    """Return a record of 1X of amplitude 2 with noise, and a whirl of `size` that is no order.

    The speed grows by the fraction `speeding` in a revolution of the first speed.
    """
    turns = np.arange(revolutions * 32) / 32.3
    angles = 2.0 * math.pi * (turns + speeding * turns**2 / 2.0)
    spread, ratio = 10.0 ** rng.uniform(-2.0, -0.5), rng.uniform(0.3, 0.98)
    x, y = spread * rng.normal(size=(2, angles.size))
    z = 2.0 * np.exp(1j * (angles - 0.5)) + x + 1j * y
    z += size * np.exp(1j * (ratio * angles + rng.uniform(0.0, 2.0 * math.pi)))
    return xr.Dataset(
        {"x": ("t", z.real), "y": ("t", z.imag), "angle": ("t", angles)}, {"t": turns * math.pi}
    )


@pytest.mark.parametrize(
    ("revolutions", "speeding", "whirl"),
    [(6, 0.0, True), (20, 0.0, True), (100, 0.0, True), (20, 1e-3, True), (100, 1e-3, True),
     (100, 0.0, False)],
)  # fmt: skip
def test_two_standard_errors_cover_a_whirl_that_is_no_order(revolutions, speeding, whirl):
    rng, covered = np.random.default_rng(7), []
    for _ in range(90):
        size = 10.0 ** rng.uniform(-2.0, 0.0) if whirl else 0.0
        found = orders(whirl_beside(rng, size, revolutions, speeding)).isel(order=0)
        apart = np.abs(found.forward_whirl_amplitude - 2.0) / found.forward_amplitude_error
        covered.append(float((apart < 2.0).mean()))
    # a whirl that stands far above the noise errs by at most 1.4 standard errors, always covered
    assert 0.90 < np.mean(covered) < (1.0 if whirl else 0.98)


@pytest.mark.parametrize(("duration", "most"), [(200.0, 1.02), (30.0, 1.1)])
def test_the_error_beside_oil_whirl_is_what_leaks_from_it(duration, most):
    times = np.arange(0.0, duration, 0.02)
    once = 2.0 * np.exp(1j * (2.0 * times - 0.5))
    z = once + 0.7 * np.exp(0.86j * times)
    signals = xr.Dataset(
        {"x": ("t", z.real), "y": ("t", z.imag), "angle": ("t", 2.0 * times)}, {"t": times}
    )
    found = orders(signals, [1]).isel(order=0)
    whirl = found.forward_whirl_amplitude * np.exp(-1j * found.forward_phase_lag)
    error = math.sqrt(float((np.abs(whirl - 2.0 * np.exp(-0.5j)) ** 2).mean()) / 2.0)
    assert error == pytest.approx(0.27, abs=0.005)
    assert error < float(found.forward_amplitude_error.mean()) < most * error
    kept = filtered_orbit(signals, order=1)
    off = (kept.x - once.real).std().item()
    assert off < float(kept.filter_error.mean()) < 2.0 * off
