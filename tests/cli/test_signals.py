"""What `show` tells of signals, orders, spectra and whirl: the numbers of their datasets."""

import io
import json
import math
import re

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    Rotor,
    centre_line,
    full_spectrum,
    orders,
    run_up,
    save,
    signals_of,
    simulate,
    spectral_lines,
    spectrogram,
    whirl_ratio,
)
from rotor_ida.cli.describe import describe, kind_of
from rotor_ida.cli.report import Report, console_on, text_of
from rotor_ida.plot.figures import figure_of

TIMES = np.arange(8000) / 1000.0
ANGLES = 2.0 * math.pi * 10.3 * TIMES


@pytest.fixture(autouse=True)
def _as_wide_as_it_needs(monkeypatch):
    """Print tables as they are, however wide the terminal is said to be."""
    monkeypatch.delenv("COLUMNS", raising=False)


@pytest.fixture(scope="module")
def measured():
    """Forward at 1X, then backward at half of it, about a mean position, in units."""
    z = 0.2 - 0.5j + 0.1 * np.exp(1j * (ANGLES - 0.4)) + 3.0 * np.exp(-0.5j * ANGLES)
    z = np.where(TIMES < 4.0, z, 0.2 - 0.5j + 2.0 * np.exp(1j * ANGLES))
    held = xr.Dataset(
        {"x": ("t", z.real), "y": ("t", z.imag), "angle": ("t", ANGLES)}, {"t": TIMES}
    )
    held["t"].attrs["units"] = "s"
    for name in ("x", "y"):
        held[name].attrs["units"] = "um"
    return held


@pytest.fixture(scope="module")
def up():
    rotor = Rotor(omega=0.2, zeta=0.1, delta0=1.5, shaft_stiffness=0.2)
    return run_up(rotor, start=(0, 0, 0, 0), to=1.0, rate=0.004, samples=6001)


def told(dataset, most=10):
    """Return the record of a dataset, and what is printed of it."""
    record, parts = describe(dataset, most=most)
    report = Report(record=record, parts=parts)
    console = console_on(io.StringIO())
    json.loads(text_of(Report(record=record, parts=(), as_json=True), console))
    return record, text_of(report, console)


def test_signals_are_told_by_length_speed_and_displacements(measured):
    record, text = told(measured)
    assert record["kind"] == kind_of(measured) == "signals"
    assert record["samples"] == 8000
    assert record["sampling_rate"] == pytest.approx(1000.0, rel=1e-12)
    assert record["revolutions"] == pytest.approx(10.3 * TIMES[-1], rel=1e-12)
    assert record["displacements"][0]["largest"] == measured.x.max()
    lines = [line.split() for line in text.splitlines()]
    assert ["sampling", "rate", "1000", "Hz"] in lines
    assert ["speed", "618", "rpm"] in lines


def test_pulses_are_counted(measured):
    pulses = np.arange(80) / 10.3
    record, text = told(measured.drop_vars("angle").assign(keyphasor=("pulse", pulses)))
    assert (record["pulses"], record["revolutions"]) == (80, pytest.approx(79.0))
    assert "618" in text


def test_orders_are_told_by_their_largest_amplitudes(measured):
    found = orders(measured, [0.5, 1])
    record, text = told(found)
    assert record["kind"] == "orders"
    assert len(record["orders"]) == found.forward_whirl_amplitude.size
    lines = [line.split() for line in text.splitlines() if "backward" in line]
    assert lines[0][:3] == ["0.5", "backward", "3"]
    (probe,) = (line for line in lines_of(text) if line[:2] == ["1", "0"])
    first, last = found.isel(probe_angle=0).sel(order=1), record["probes"][2]
    assert float(probe[2]) == pytest.approx(float(first.probe_peak_to_peak.max()), rel=1e-4)
    assert last["probe_peak_to_peak"] == pytest.approx(float(first.probe_peak_to_peak.max()))
    assert "vibration, peak to peak [um]" in text
    assert "direct, peak to peak [um]" in text
    assert "whirl amplitude, zero to peak [um]" in text


def lines_of(text):
    return [line.split() for line in text.splitlines()]


def test_critical_speeds_are_told_with_their_amplification():
    """AF is 1/(2 zeta) of a light damping, to a few per cent."""
    rotor = Rotor(omega=0.7, zeta=0.05, delta0=30.0, shaft_stiffness=1.0)
    up = run_up(rotor, start="settled", to=1.4, rate=0.0003, samples=20_001)
    record, text = told(orders(up))
    assert [row["sense"] for row in record["critical_speeds"]] == ["forward", "x", "y"]
    for row in record["critical_speeds"]:
        assert row["amplification_factor"] == pytest.approx(10.0, rel=0.05)
    assert "Critical speeds of 1X, by half power" in text


def test_mean_positions_and_senses_are_told_by_window(measured):
    found = centre_line(measured.isel(t=slice(4500, None)))
    record, text = told(found, most=None)
    assert record["kind"] == "centre_line"
    assert len(record["windows"]) == found.sizes["window"]
    assert record["windows"][-1]["offset_x"] == pytest.approx(0.2)
    assert [float(each) for each in lines_of(text)[-1][-2:]] == pytest.approx([0.2, -0.5])
    record, text = told(whirl_ratio(measured, revolutions=2), most=None)
    assert record["kind"] == "whirl_over_spin"
    senses = [row["whirl_sense"] for row in record["windows"]]
    # in the window in which it turns round it is either, or none
    assert (senses[0], senses[-1]) == ("backward", "forward")
    assert text.count("forward") + text.count("backward") >= len(senses) - 1


def test_spectra_are_told_by_peaks_bandwidth_and_floor(measured):
    rng = np.random.default_rng(9)
    noisy = measured.isel(t=slice(0, 4000)).copy()
    noisy["x"] = noisy.x + 0.001 * rng.normal(size=4000)
    found = full_spectrum(noisy)
    record, text = told(found)
    assert record["kind"] == "full_spectrum"
    orders_found = [row["frequency_over_omega"] for row in record["peaks"]]
    np.testing.assert_allclose(orders_found, [-0.5, 1.0], atol=0.02)
    assert record["peaks"][0]["whirl_amplitude"] == pytest.approx(3.0, rel=2e-3)
    assert record["noise_floor"] == found.noise_floor
    assert re.search(r"noise floor +\S+ +um", text)
    assert re.search(r"bandwidth +\S+ +Hz", text)


def test_lines_by_least_squares_are_told_by_height(measured):
    record, text = told(spectral_lines(measured.isel(t=slice(0, 4000)), count=3))
    assert record["kind"] == "spectral_lines"
    heights = [row["whirl_amplitude"] for row in record["lines"]]
    np.testing.assert_allclose(heights, [3.0, abs(0.2 - 0.5j), 0.1], rtol=1e-9)
    assert "-0.5" in text


def test_a_spectrogram_is_told_by_its_highest_lines(up):
    found = spectrogram(up, segment=500)
    record, text = told(found, most=5)
    assert record["kind"] == "spectrogram"
    late = record["highest"][-1]
    assert late["frequency"] == pytest.approx(late["speed"], abs=found.bandwidth.item())
    assert f"first 5 of {found.sizes['window']}" in text


def test_a_spectrum_without_peaks_says_so(measured):
    rng = np.random.default_rng(10)
    x, y = rng.normal(size=(2, TIMES.size))
    found = full_spectrum(measured.assign(x=("t", x), y=("t", y)), segment=500)
    record, text = told(found)
    assert record["peaks"] == []
    assert "Peaks above 4 times the noise floor: none" in text


def test_runs_stay_runs(up):
    assert kind_of(up) == "run"
    assert kind_of(signals_of(up)) == "signals"


@pytest.mark.parametrize("of", [signals_of, spectrogram], ids=lambda of: of.__name__)
def test_show_draws_signals(program, up, of):
    save(of(up), "signals.nc")
    answer = program("show", "signals.nc", "--figure", "drawn.svg")
    assert "wrote drawn.svg" in answer.out
    assert figure_of(of(up)).axes


def test_what_is_not_drawn_is_refused_in_one_line(program):
    run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0), duration=60.0)
    save(whirl_ratio(run), "whirl.nc")
    answer = program("show", "whirl.nc", "--figure", "drawn.svg")
    assert answer.status != 0
    assert "got 'whirl_over_spin'" in answer.err
