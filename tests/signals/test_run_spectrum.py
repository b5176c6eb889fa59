"""Lines of known height, forward and backward, on and off the grid."""

import math

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, full_spectrum
from rotor_ida.schema import labelled


def signal(z, times, omega=1.5):
    """A motion made by hand, labelled as a run is."""
    variables = {"x": labelled("x", "t", z.real), "y": labelled("y", "t", z.imag)}
    parameters = {"omega": omega, "zeta": 0.1, "delta0": 1.0}
    coordinates = {name: labelled(name, (), value) for name, value in parameters.items()}
    return xr.Dataset(variables, {**coordinates, "t": labelled("t", "t", times)})


def at(lines, order):
    return lines.whirl_amplitude.values[np.abs(lines.frequency_over_omega.values - order).argmin()]


TIMES = 2.0 * math.pi / 1.5 * np.arange(2048) / 64  # 32 whole revolutions


@pytest.mark.parametrize("window", ["flattop", "hann", "boxcar"])
def test_a_forward_whirl_is_one_line_of_its_amplitude(window):
    lines = full_spectrum(signal(0.7 * np.exp(1j * (1.5 * TIMES - 0.4)), TIMES), window=window)
    assert at(lines, 1.0) == pytest.approx(0.7, rel=1e-13)
    # flat-top's line is 9 steps wide: a 32th of the spin speed each
    away = np.abs(lines.frequency_over_omega.values - 1.0) > 4.5 / 32
    assert lines.whirl_amplitude.values[away].max() < 1e-13
    np.testing.assert_allclose(lines.frequency, 1.5 * lines.frequency_over_omega, rtol=1e-15)


@pytest.mark.parametrize("window", ["flattop", "hann", "boxcar"])
def test_a_planar_vibration_is_forward_and_backward_whirl_in_equal_parts(window):
    lines = full_spectrum(signal(0.7 * np.cos(3.0 * TIMES + 0.3) + 0j, TIMES), window=window)
    assert at(lines, 2.0) == pytest.approx(0.35, rel=1e-13)
    assert at(lines, -2.0) == pytest.approx(0.35, rel=1e-13)


def test_backward_whirl_and_offset_are_told_apart():
    lines = full_spectrum(signal(0.2j + 0.7 * np.exp(-1.5j * TIMES), TIMES))
    assert at(lines, -1.0) == pytest.approx(0.7, rel=1e-12)
    assert at(lines, 0.0) < 1e-12  # a position is no vibration
    assert at(lines, 1.0) < 1e-12


@pytest.mark.parametrize(("window", "lost"), [("flattop", 1.5e-3), ("hann", 0.16)])
def test_height_of_a_line_half_way_between_two_steps(window, lost):
    """The worst place: flat-top loses 0.1 %, Hann 15 %."""
    half = 1.5 * (1.0 + 0.5 / 32)
    lines = full_spectrum(signal(np.exp(1j * half * TIMES), TIMES), window=window)
    assert 1.0 - lost < lines.whirl_amplitude.max() < 1.0 + 1.5e-3
    assert window != "hann" or lines.whirl_amplitude.max() < 0.86


def test_bad_input_is_refused():
    z = np.exp(1j * TIMES)
    repeated = np.where(np.arange(TIMES.size) == 7, TIMES[8], TIMES)
    for times, message in (
        (TIMES**1.01, "equally spaced samples, got steps from"), (repeated, "t must increase"),
        (np.full(TIMES.size, TIMES[8]), "t must increase"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=message):
            full_spectrum(signal(z, times))
    with pytest.raises(InputError, match="at least 16 samples, got 8"):
        full_spectrum(signal(z[:8], TIMES[:8]))
    pulsed = signal(z[:8], TIMES[:8]).assign(keyphasor=("pulse", np.arange(4.0)))
    with pytest.raises(InputError, match="at least 16 samples, got 8"):
        full_spectrum(pulsed)
    with pytest.raises(InputError, match=r"more than 2 samples in each revolution, got 1\.6"):
        full_spectrum(signal(z[::40], TIMES[::40]))
    with pytest.raises(InputError, match="window must be one of 'flattop', 'hann', 'boxcar'"):
        full_spectrum(signal(z, TIMES), window="kaiser")
