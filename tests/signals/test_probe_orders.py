"""What each probe reads of an order, its whole reading, and the peaks of a Bode plot."""

import math

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, bode_peaks, correct_probes, load, orders, save
from rotor_ida.plot import plot_bode, plot_polar
from rotor_ida.signals.peaks import peaks_of

# An ellipse at 20 revolutions a second, and half of it beside: what probes at 30 and 110 read
TIMES = np.arange(4000) / 4000.0
ANGLES = 2.0 * np.pi * 20.0 * TIMES
PROBES = (30.0, 110.0)
FORWARD, BACKWARD = 40.0 * np.exp(-0.7j), 15.0 * np.exp(0.3j)


def made(z, angles=ANGLES, **attributes):
    variables = {
        "x": ("t", z.real, {"units": "um"}), "y": ("t", z.imag, {"units": "um"}),
        "angle": ("t", angles),
    }  # fmt: skip
    coordinates = {"t": ("t", TIMES if z.size == TIMES.size else np.arange(z.size) / 4000.0)}
    found = xr.Dataset(variables, coordinates, attributes)
    found["t"].attrs["units"] = "s"
    return found


def test_a_probe_reads_its_part_of_the_ellipse_and_lags_by_the_angle_to_its_peak():
    z = FORWARD * np.exp(1j * ANGLES) + BACKWARD * np.exp(-1j * ANGLES)
    found = orders(made(z, probe_angles=np.array(PROBES))).isel(order=0, window=3)
    for place, probe in enumerate(PROBES):
        turn = np.linspace(0.0, 2.0 * np.pi, 100_001)
        motion = FORWARD * np.exp(1j * turn) + BACKWARD * np.exp(-1j * turn)
        reading = (motion * np.exp(-1j * np.radians(probe))).real
        one = found.isel(probe_angle=place)
        assert float(one.probe_angle) == probe
        assert float(one.probe_peak_to_peak) == pytest.approx(np.ptp(reading), rel=1e-8)
        lag = float(one.probe_phase_lag)
        assert lag == pytest.approx(turn[reading.argmax()], abs=1e-4)


def test_the_direct_amplitude_holds_all_orders():
    z = 50.0 * np.exp(1j * ANGLES) + 10.0 * np.exp(2j * ANGLES) - 400.0
    found = orders(made(z), revolutions=2)
    x = 50.0 * np.cos(ANGLES) + 10.0 * np.cos(2.0 * ANGLES)
    np.testing.assert_allclose(found.direct_peak_to_peak.isel(probe_angle=0), np.ptp(x), rtol=1e-3)
    np.testing.assert_allclose(found.probe_peak_to_peak, 100.0, rtol=1e-9)
    assert found.probe_angle.values.tolist() == [0.0, 90.0]


def test_the_error_of_a_peak_to_peak_is_its_scatter():
    noise = np.random.default_rng(4).normal(size=(2, 40_000))
    angles = 2.0 * np.pi * 20.0 * np.arange(40_000) / 4000.0
    z = 30.0 * np.exp(1j * angles) + noise[0] + 1j * noise[1]
    found = orders(made(z, angles)).isel(order=0)
    scatter = found.probe_peak_to_peak.std("window")
    np.testing.assert_allclose(found.probe_error.mean(), scatter, rtol=0.15)


def test_corrected_probes_are_read_at_their_angles(tmp_path):
    z = 25.0 * np.exp(1j * ANGLES)
    turned = orders(correct_probes(made(z), angles=(45, 135)))
    assert load(save(turned, tmp_path / "a.nc")).probe_angle.values.tolist() == [45.0, 135.0]
    # a reading along 45 degrees is x of what the probes gave
    np.testing.assert_allclose(turned.probe_peak_to_peak, 50.0, rtol=1e-9)
    np.testing.assert_allclose(np.cos(turned.probe_phase_lag.isel(probe_angle=0)), 1.0, rtol=1e-12)


def linear(zeta, *, low=5.0, high=80.0, critical=40.0, seconds=40.0):
    """A whirl e r^2/(1 - r^2 + 2 i zeta r) as the speed rises slowly, of steady states."""
    times = np.arange(round(seconds * 2000)) / 2000.0
    angles = 2.0 * np.pi * (low * times + 0.5 * (high - low) / seconds * times**2)
    r = (low + (high - low) * times / seconds) / critical
    z = 10.0 * r**2 / (1.0 - r**2 + 2j * zeta * r) * np.exp(1j * angles)
    found = made(z, angles)
    return found.assign_coords(t=("t", times, {"units": "s"}))


def half_power(zeta):
    """Peak and half-power speeds over the natural one, in closed form, by r^4/|.|^2 = h^2/2."""
    peak = 1.0 / math.sqrt(1.0 - 2.0 * zeta**2)
    square = 1.0 / (4.0 * zeta**2 * (1.0 - zeta**2)) / 2.0
    roots = np.roots([1.0 - 1.0 / square, -2.0 + 4.0 * zeta**2, 1.0])
    return peak, *np.sqrt(np.sort(roots))


@pytest.mark.parametrize("zeta", [0.03, 0.15])
def test_critical_speed_and_amplification_of_a_linear_rotor(zeta):
    peak, low, high = half_power(zeta)
    tracks, unit = orders(linear(zeta)), 2.0 * np.pi * 40.0
    for sense, size in (("forward", 1.0), ("x", 2.0), ("y", 2.0)):
        found = bode_peaks(tracks, sense=sense).isel(critical=0)
        assert float(found.critical_speed) == pytest.approx(peak * unit, rel=2e-3)
        assert float(found.half_power_low) == pytest.approx(low * unit, rel=2e-3)
        assert float(found.half_power_high) == pytest.approx(high * unit, rel=2e-3)
        assert float(found.amplification_factor) == pytest.approx(peak / (high - low), rel=0.02)
        height = size * 10.0 / (2.0 * zeta * math.sqrt(1.0 - zeta**2))
        assert float(found.bode_amplitude) == pytest.approx(height, rel=5e-3)


def test_a_peak_without_one_side_is_as_wide_as_the_other():
    found = bode_peaks(linear(0.05, high=41.0))
    assert np.isnan(found.half_power_high[0])
    assert float(found.amplification_factor[0]) == pytest.approx(10.0, rel=0.1)


def test_a_peak_stands_out_of_its_errors_and_has_two_feet():
    """A vertex far above all samples, as noise of the speed makes it, has no foot."""
    speeds, amplitude = np.array([0.0, 1.0, 1.2, 2.0, 3.0]), np.array([0.1, 2.0, 3.0, 0.2, 0.1])
    (peak,) = peaks_of(speeds, amplitude, np.full(5, 0.1))
    assert peak.low < 1.2 < peak.high
    assert not peaks_of(speeds, amplitude, np.full(5, 0.5))
    steep = np.array([0.0, 1.0, 1.06, 2.0, 3.0]), np.array([0.1, 0.0, 3.0, 2.9, 0.1])
    assert not peaks_of(*steep, np.zeros(5))


def test_noise_has_no_peaks_and_two_modes_have_two():
    z = 5.0 * np.exp(1j * ANGLES)
    noise = np.random.default_rng(1).normal(size=(2, z.size))
    assert bode_peaks(made(z + noise[0] + 1j * noise[1])).sizes["critical"] == 0
    both = linear(0.04, critical=25.0)
    both = both.assign({name: both[name] + linear(0.04, critical=60.0)[name] for name in "xy"})
    found = bode_peaks(both)
    np.testing.assert_allclose(found.critical_speed / (2.0 * np.pi), [25.0, 60.0], rtol=0.02)


def test_an_order_or_a_sense_that_is_unknown_is_refused():
    tracks = orders(made(np.exp(1j * ANGLES)))
    with pytest.raises(InputError, match="signals must have the order 2"):
        bode_peaks(tracks, order=2.0)
    with pytest.raises(InputError, match="sense must be one of"):
        bode_peaks(tracks, sense="up")
    with pytest.raises(InputError, match="forward or backward for orders without probes"):
        bode_peaks(tracks.drop_dims("probe_angle"), sense="x")


def test_bode_and_polar_of_a_probe_are_peak_to_peak_from_the_probe():
    signals = linear(0.1, seconds=10.0).assign_attrs(probe_angles=np.array([45.0, 135.0]))
    figure = plot_bode(signals, sense="x")
    upper, lower = figure.axes
    assert upper.get_ylabel() == "vibration, peak to peak [µm]"
    assert [text.get_text() for text in upper.get_legend().get_texts()] == [
        "1X of the probe at 45°", "direct (all orders)",
    ]  # fmt: skip
    (line,) = (each for each in upper.lines if each.get_label() == "1X of the probe at 45°")
    assert np.nanmax(line.get_ydata()) == pytest.approx(100.0, rel=0.02)
    lags = lower.lines[0].get_ydata()
    # a forward whirl is at 45 degrees an eighth of a revolution after the x axis
    np.testing.assert_allclose(np.nanmin(lags), 45.0 + np.degrees(np.arctan(0.2 * 0.127)), atol=2.0)
    (named,) = (text for text in upper.texts if "AF" in text.get_text())
    figure.canvas.draw()
    (left, low), (right, high) = upper.transData.inverted().transform(named.get_window_extent())
    for each in upper.lines:  # the words lie above all lines and within the axes
        across, up = each.get_data()
        assert not (up[(across >= left) & (across <= right)] > low).any()
    assert high < upper.get_ylim()[1]
    assert plot_bode(signals).axes[0].get_ylabel() == "whirl amplitude, zero to peak $|c|$ [µm]"
    polar = plot_polar(signals, sense="x")
    assert polar.get_theta_offset() == pytest.approx(np.radians(45.0))
    assert "lag clockwise, from the probe" in polar.get_xlabel()
