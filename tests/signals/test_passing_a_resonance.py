"""A resonance passed at a changing speed: standard errors, the mean position, the Bode plot."""

import numpy as np
import pytest
import xarray as xr

from rotor_ida import bode_peaks, centre_line, orders
from rotor_ida.plot import plot_bode

CRITICAL = 2.0 * np.pi * 40.0


def passing(zeta, noise=0.0, seed=0, mean=0.0, seconds=30.0):
    """Return steady whirls ``10 r^2/(1 - r^2 + 2 i zeta r)`` [um] as the speed falls."""
    times = np.arange(round(2000.0 * seconds)) / 2000.0
    r = 2.0 - 1.7 * times / seconds
    angles = CRITICAL * (2.0 * times - 0.85 * times**2 / seconds)
    z = 10.0 * r**2 / (1.0 - r**2 + 2j * zeta * r) * np.exp(1j * angles) + mean
    x, y = noise * np.random.default_rng(seed).normal(size=(2, times.size))
    variables = {
        "x": ("t", z.real + x, {"units": "um"}), "y": ("t", z.imag + y, {"units": "um"}),
        "angle": ("t", angles),
    }  # fmt: skip
    return xr.Dataset(variables, {"t": ("t", times, {"units": "s"})})


@pytest.mark.parametrize(("noise", "revolutions"), [(0.2, 8), (1.0, 2), (5.0, 1)])
def test_standard_errors_are_the_scatter_over_seeds_on_and_off_resonance(noise, revolutions):
    """The vector changes by up to 22 of 100 um within 8 revolutions: that is no noise."""
    found = [orders(passing(0.05, noise, seed), revolutions=revolutions) for seed in range(10)]
    ratio = found[0].speed.values / CRITICAL
    vectors = np.array([
        (each.forward_whirl_amplitude * np.exp(-1j * each.forward_phase_lag)).values[:, 0]
        for each in found
    ])  # fmt: skip
    errors = np.mean([each.forward_amplitude_error.values[:, 0] ** 2 for each in found], axis=0)
    squares = (np.abs(vectors - vectors.mean(axis=0)) ** 2).sum(axis=0) / 9.0 / 2.0
    for low, high in ((0.3, 0.6), (0.8, 0.95), (0.95, 1.05), (1.05, 1.2), (1.4, 1.9)):
        part = (ratio > low) & (ratio < high)
        assert np.sqrt(errors[part].mean() / squares[part].mean()) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("revolutions", [1, 2])
def test_the_amplitude_in_a_window_is_the_mean_of_that_of_the_motion(revolutions):
    """Told by the amplitude that the record was made with, on each side of the peak and on it."""
    signals = passing(0.02)
    found = orders(signals, revolutions=revolutions)
    angles = signals["angle"].values
    still = (signals.x + 1j * signals.y).values * np.exp(-1j * angles)
    turns = ((angles - angles[0]) / (2.0 * np.pi * revolutions) + 1e-9).astype(int)
    size = found.sizes["window"]
    counts = np.bincount(turns)[:size]
    parts = [np.bincount(turns, each)[:size] / counts for each in (still.real, still.imag)]
    made = np.hypot(*parts)
    apart = np.abs(found.forward_whirl_amplitude.values[:, 0] - made)
    assert (apart / made.max()).max() < 2e-4


@pytest.mark.parametrize("overlap", [0.5, 0.9])
def test_windows_that_overlap_keep_their_errors_and_show_the_peak(overlap):
    signals = passing(0.05, 0.2, seconds=3.0)
    apart, over = (orders(signals, overlap=each) for each in (0.0, overlap))
    near = [abs(each.speed.values / CRITICAL - 1.0) < 0.05 for each in (apart, over)]
    sizes = [np.sqrt(np.mean(each.forward_amplitude_error.values[part, 0] ** 2))
             for each, part in zip((apart, over), near, strict=True)]  # fmt: skip
    assert sizes[1] < 10.0 * sizes[0]  # 130 and 300 times, by a curve over too few revolutions
    assert float(bode_peaks(over).critical_speed[0]) == pytest.approx(CRITICAL, rel=1e-2)


@pytest.mark.parametrize("revolutions", [1, 2, 8])
def test_the_mean_position_has_no_bend_at_a_resonance(revolutions):
    found = centre_line(passing(0.05, mean=30.0 - 40.0j), revolutions=revolutions)
    apart = np.hypot(found.offset_x - 30.0, found.offset_y + 40.0)
    # a 45th of what it is where amplitudes are constant in each window
    assert float(apart.max()) < 0.01


@pytest.mark.parametrize("zeta", [0.0125, 0.05])
def test_a_sharp_resonance_is_drawn_and_named(zeta):
    signals = passing(zeta, 0.4)
    (line,) = (each for each in plot_bode(signals).axes[0].lines if each.get_label() != "_")
    assert np.isfinite(line.get_ydata()).all()
    found = bode_peaks(orders(signals, revolutions=4))
    assert float(found.critical_speed[0]) == pytest.approx(CRITICAL, rel=5e-3)
    assert float(found.amplification_factor[0]) == pytest.approx(0.5 / zeta, rel=0.05)
