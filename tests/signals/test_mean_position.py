"""Probes in V with their gap: the mean position is subtracted, and kept as the centre line."""

import numpy as np
import pytest

from rotor_ida import (
    centre_line,
    correct_probes,
    full_spectrum,
    load,
    orders,
    read_signals,
    save,
)
from rotor_ida.plot import plot_centre_line, plot_orbit, plot_trace

# 40 um at 30 Hz for 12.4 revolutions, 1,270 um from the tip of each probe
TIMES = np.arange(827) / 2000.0
ANGLES = 2.0 * np.pi * 30.0 * TIMES
GAP = 1270.0
VOLTS = 7.87e-3  # a micrometre


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "gap.csv"
    x, y = (-VOLTS * (GAP - 40.0 * part(ANGLES)) for part in (np.cos, np.sin))
    table = np.stack([TIMES, x, y, ANGLES], axis=1)
    np.savetxt(path, table, "%.9f", ",", header="t [s],x [V],y [V],angle [rad]", comments="")
    return path


def seen(file, **options):
    return read_signals(file, sensitivity="7.87 V/mm", **options)


def test_the_gap_is_no_line_at_0_hz_and_the_orbit_lies_about_its_centre(file):
    signals = seen(file)
    np.testing.assert_allclose([signals.mean_x, signals.mean_y], -1e-3 * GAP, rtol=1e-6)
    np.testing.assert_allclose(np.hypot(signals.x, signals.y), 0.04, rtol=1e-4)
    assert "the mean position is subtracted: x -1.27 mm, y -1.27 mm" in signals.attrs["notes"]
    lines = full_spectrum(signals)
    tallest = float(lines.frequency[lines.whirl_amplitude.values.argmax()])
    assert tallest == pytest.approx(2.0 * np.pi * 30.0, rel=0.1)


def test_the_centre_line_is_the_position_that_was_measured(file, tmp_path):
    signals = load(save(seen(file), tmp_path / "gap.nc"))
    for means in (centre_line(signals), orders(signals), centre_line(seen(file, keep_offset=True))):
        np.testing.assert_allclose(means.offset_x, -1e-3 * GAP, rtol=1e-6)
        np.testing.assert_allclose(means.offset_y, -1e-3 * GAP, rtol=1e-6)


def test_the_mean_turns_with_the_probes(file):
    """Probes at 45 and 135 degrees read x + y and y - x over the root of 2."""
    turned = correct_probes(seen(file), angles=(45, 135))
    assert float(turned.mean_x) == pytest.approx(0.0, abs=1e-6)
    assert float(turned.mean_y) == pytest.approx(-1e-3 * GAP * np.sqrt(2.0), rel=1e-6)
    at_once = seen(file, probe_angles=(45, 135))
    np.testing.assert_allclose(turned.y, at_once.y, atol=1e-9)
    assert float(turned.mean_y) == pytest.approx(float(at_once.mean_y), rel=1e-9)


def test_the_offset_is_kept_if_asked(file):
    kept = seen(file, keep_offset=True)
    assert "mean_x" not in kept.variables
    assert "mean position" not in kept.attrs["notes"]
    assert float(kept.x[0]) == pytest.approx(-1e-3 * (GAP - 40.0), rel=1e-6)


def test_figures_say_what_was_subtracted_and_draw_the_clearance_about_the_mean(file):
    signals = seen(file)
    words = "mean position subtracted: $x$ $-1.27$ mm, $y$ $-1.27$ mm"
    assert plot_orbit(signals, clearance=0.15).get_title() == words
    assert plot_trace(signals).get_title() == words
    ax = plot_centre_line(signals, clearance=0.15)
    (ring,) = (line for line in ax.lines if line.get_label() == "clearance")
    assert np.mean([ring.get_xdata().min(), ring.get_xdata().max()]) == pytest.approx(-1.27)
    assert ax.get_title() == "clearance about the mean of the record"
