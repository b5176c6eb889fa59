"""Probes in V with their gap: positions are counted from it, and it is no vibration."""

import re

import numpy as np
import pytest

from rotor_ida import (
    InputError,
    centre_line,
    correct_probes,
    full_spectrum,
    load,
    orders,
    read_signals,
    save,
    spectrogram,
)
from rotor_ida.plot import (
    plot_bode,
    plot_cascade,
    plot_centre_line,
    plot_full_spectrum,
    plot_orbit,
    plot_orders,
    plot_polar,
    plot_spectrogram,
    plot_trace,
)

# 40 um at 30 Hz for 12.4 revolutions, 1,270 um from the tip of each probe
TIMES = np.arange(827) / 2000.0
ANGLES = 2.0 * np.pi * 30.0 * TIMES
GAP = 1270.0
VOLTS = 7.87e-3  # a micrometre


def written(path, x, y, times=TIMES, angles=ANGLES):
    table = np.stack([times, VOLTS * x, VOLTS * y, angles], axis=1)
    np.savetxt(path, table, "%.9f", ",", header="t [s],x [V],y [V],angle [rad]", comments="")
    return path


@pytest.fixture
def file(tmp_path):
    x, y = (-(GAP - 40.0 * part(ANGLES)) for part in (np.cos, np.sin))
    return written(tmp_path / "gap.csv", x, y)


def seen(file, **options):
    return read_signals(file, sensitivity="7.87 V/mm", **options)


def test_the_gap_is_no_line_at_0_hz_and_the_orbit_lies_about_its_centre(file):
    signals = seen(file)
    np.testing.assert_allclose([signals.mean_x, signals.mean_y], -1e-3 * GAP, rtol=1e-6)
    np.testing.assert_allclose(np.hypot(signals.x, signals.y), 0.04, rtol=1e-4)
    assert "the mean position is subtracted: x -1.27 mm, y -1.27 mm" in signals.attrs["notes"]


@pytest.mark.parametrize("gap", [None, "0", "-9 V"])
def test_no_gap_is_drawn_as_vibration_whatever_positions_are_counted_from(file, gap):
    """1.27 mm beside 0.04 mm: the tallest line is the whirl in the whole record and its parts."""
    signals = seen(file, gap=gap)
    for lines in (full_spectrum(signals), spectrogram(signals, segment=400).isel(window=1)):
        tallest = int(lines.whirl_amplitude.values.argmax())
        assert float(lines.frequency[tallest]) == pytest.approx(2.0 * np.pi * 30.0, rel=0.1)
        assert float(lines.whirl_amplitude[tallest]) == pytest.approx(0.04, rel=0.02)
        assert float(lines.whirl_amplitude.sel(frequency=0.0)) < 1e-12


def test_a_centre_line_that_moves_while_the_speed_changes_is_no_vibration(tmp_path):
    """200 um in 4 s, while the shaft whirls with 20 um: the whirl is the tallest in each part."""
    times = np.arange(8000) / 2000.0
    angles = 2.0 * np.pi * (20.0 * times + 5.0 * times**2)
    z = -GAP + 50j * times + 20.0 * np.exp(1j * angles)
    signals = seen(written(tmp_path / "up.csv", z.real, z.imag, times, angles), length="um")
    parts = spectrogram(signals, segment=512)
    tallest = parts.frequency[parts.whirl_amplitude.argmax("frequency")]
    np.testing.assert_allclose(tallest, parts.speed, atol=float(parts.bandwidth))
    near_0 = parts.whirl_amplitude.where(abs(parts.frequency) < 2.0 * np.pi * 10.0)
    assert float(near_0.max()) < 2.0


def test_the_centre_line_is_the_position_that_was_measured(file, tmp_path):
    signals = load(save(seen(file), tmp_path / "gap.nc"))
    for means in (centre_line(signals), orders(signals), centre_line(seen(file, gap="0"))):
        np.testing.assert_allclose(means.offset_x, -1e-3 * GAP, rtol=1e-6)
        np.testing.assert_allclose(means.offset_y, -1e-3 * GAP, rtol=1e-6)


@pytest.mark.parametrize(
    ("gap", "expected"),
    [
        ("-10 V", (-GAP + 10.0 / VOLTS,) * 2),
        (("-10 V", "-9.5V"), (-GAP + 10.0 / VOLTS, -GAP + 9.5 / VOLTS)),
        ("-10000mV", (-GAP + 10.0 / VOLTS,) * 2),
        ("-1.2 mm", (-70.0,) * 2),
    ],
)
def test_the_centre_line_is_measured_from_the_gap(file, tmp_path, gap, expected):
    signals = load(save(seen(file, gap=gap, length="um"), tmp_path / "gap.nc"))
    means = centre_line(signals)
    assert means.offset_x.attrs["units"] == "um"
    np.testing.assert_allclose([means.offset_x[0], means.offset_y[-1]], expected, atol=1e-3)
    assert "mean_x" not in means.variables
    assert "displacements are counted from the gap: x -1" in signals.attrs["notes"]


def test_the_gap_of_a_stretch_is_its_mean(tmp_path):
    """At rest 100 um below the centre of the stator for 1 s, then whirling about that centre."""
    times = np.arange(4000) / 2000.0
    turned = np.clip(times - 1.0, 0.0, None)
    z = np.where(times < 1.0, -100j, 40.0 * np.exp(2j * np.pi * 30.0 * turned)) - GAP * (1.0 + 1j)
    path = written(tmp_path / "lift.csv", z.real, z.imag, times, 2.0 * np.pi * 30.0 * turned)
    signals = seen(path, gap=("0 s", "900 ms"), length="um")
    means = centre_line(signals).isel(window=slice(1, None))
    np.testing.assert_allclose(means.offset_x, 0.0, atol=1e-3)
    np.testing.assert_allclose(means.offset_y, 100.0, atol=1e-3)


def test_probes_off_the_axes_have_the_gap_along_their_own(file):
    """Two gaps of 10 V at 45 and 135 degrees are one of 10 V times the root of 2 along y."""
    signals = seen(file, gap="0", probe_angles=(45, 135), length="um")
    counted = seen(file, gap="-10 V", probe_angles=(45, 135), length="um")
    np.testing.assert_allclose(counted.x, signals.x, atol=1e-9)
    np.testing.assert_allclose(counted.y - signals.y, 10.0 * np.sqrt(2.0) / VOLTS, rtol=1e-9)


@pytest.mark.parametrize(
    ("gap", "message"),
    [
        ("x", "gap must be the reading of both probes or of each, such as '-10 V', two times"),
        ("-10", "gap must be the reading of both probes or of each"),
        (("1 V", "2 s"), "gap must be the reading of both probes or of each"),
        (("1 V", "2 V", "3 V"), "gap must be the reading of both probes or of each"),
        (("2 s", "3 s"), "gap must be a stretch within 0 to 0.413, got 2 to 3"),
    ],
)
def test_a_gap_that_is_none_is_refused(file, gap, message):
    with pytest.raises(InputError, match=re.escape(message)):
        seen(file, gap=gap)


def test_a_gap_in_volts_needs_the_sensitivity_of_displacements(tmp_path):
    path = tmp_path / "um.csv"
    table = np.stack([TIMES, np.cos(ANGLES), np.sin(ANGLES), ANGLES], axis=1)
    np.savetxt(path, table, "%.9f", ",", header="t [s],x [um],y [um],angle [rad]", comments="")
    with pytest.raises(InputError, match="gap must be in a unit of length to be shown in um, got"):
        read_signals(path, gap="-10 V")


@pytest.mark.parametrize(("length", "size"), [("um", 1.0), ("mm", 1e3), ("mil", 25.4)])
def test_the_unit_of_length_is_chosen_apart_from_that_of_the_sensitivity(file, length, size):
    signals = read_signals(file, sensitivity="199.898 mV/mil", length=length)
    assert signals.x.attrs["units"] == signals.mean_x.attrs["units"] == length
    np.testing.assert_allclose(np.hypot(signals.x, signals.y) * size, 40.0, rtol=1e-4)


def test_volts_without_a_sensitivity_have_no_length(file):
    with pytest.raises(InputError, match="x must be in a unit of length to be shown in mil, got V"):
        read_signals(file, length="mil")


def test_the_mean_turns_with_the_probes(file):
    """Probes at 45 and 135 degrees read x + y and y - x over the root of 2."""
    turned = correct_probes(seen(file), angles=(45, 135))
    assert float(turned.mean_x) == pytest.approx(0.0, abs=1e-6)
    assert float(turned.mean_y) == pytest.approx(-1e-3 * GAP * np.sqrt(2.0), rel=1e-6)
    at_once = seen(file, probe_angles=(45, 135))
    np.testing.assert_allclose(turned.y, at_once.y, atol=1e-9)
    assert float(turned.mean_y) == pytest.approx(float(at_once.mean_y), rel=1e-9)


def test_figures_say_what_was_subtracted_and_draw_the_clearance_about_the_mean(file):
    signals = seen(file)
    words = "mean position subtracted: $x = -1.27$, $y = -1.27$ mm"
    assert words in plot_orbit(signals, clearance=0.15).get_title()
    assert words in plot_trace(signals).get_title()
    ax = plot_centre_line(signals, clearance=0.15)
    (ring,) = (line for line in ax.lines if line.get_label() == "clearance")
    assert np.mean([ring.get_xdata().min(), ring.get_xdata().max()]) == pytest.approx(-1.27)
    assert "clearance about the mean of the record" in ax.get_title()


def test_figures_from_a_gap_say_so(file):
    signals = seen(file, gap=("-10V", "-9.5 V"))
    for ax in (plot_orbit(signals), plot_trace(signals), plot_centre_line(signals)):
        assert "from the gap of −10 V and −9.5 V" in ax.get_title()
    stretch = plot_orbit(seen(file, gap=("0s", "200ms"))).get_title()
    assert "from the gap of the mean from 0 s to 200 ms" in stretch


def test_figures_have_a_caption_of_file_record_and_speeds(file):
    signals = seen(file, caption="Pump 3, 1 March at $5")
    drawn = [
        plot_orbit(signals), plot_trace(signals), plot_centre_line(signals),
        plot_bode(signals).axes[0], plot_polar(signals), plot_orders(signals, orders=[1]),
        plot_full_spectrum(signals), plot_full_spectrum(full_spectrum(signals)),
        plot_cascade(signals), plot_spectrogram(signals),
    ]  # fmt: skip
    for ax in drawn:
        caption = r"gap.csv,  Pump 3, 1 March at \$5,  1,800 rpm"
        assert ax.get_title().partition("\n")[0] == caption, ax.get_title()
    long = plot_orbit(signals.assign_attrs(caption="Compressor K-101 of the second train, hot"))
    assert long.get_title().splitlines()[1] == "1,800 rpm"
