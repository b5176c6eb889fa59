"""Known answers: whirls made by hand, exact responses, probes and files with known faults."""

import math

import numpy as np
import pytest
import xarray as xr
from scipy.io import savemat, wavfile

from rotor_ida import (
    InputError,
    Rotor,
    correct_probes,
    filtered_orbit,
    full_spectrum,
    load,
    orders,
    read_signals,
    save,
    simulate,
    spectrum,
    subtract_runout,
    whirl_ratio,
)

TIMES = np.arange(4000) / 1000
ANGLES = 2.0 * math.pi * 10.3 * TIMES


def made(z, angles=ANGLES):
    return xr.Dataset(
        {"x": ("t", z.real), "y": ("t", z.imag), "angle": ("t", angles)}, {"t": TIMES}
    )


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


def test_full_spectrum_of_a_run_is_its_spectrum():
    rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
    run = simulate(rotor, start=(3.0, 1.0, 0.0, 0.0), duration=100.0, samples=2001)
    np.testing.assert_allclose(
        full_spectrum(run).whirl_amplitude, spectrum(run).whirl_amplitude, atol=1e-12
    )


def test_the_noise_floor_is_that_of_the_noise():
    noise = np.random.default_rng(1).normal(size=(2, 4000)) * 0.1
    found = full_spectrum(made(WHIRL + noise[0] + 1j * noise[1]), window="hann", segment=250)
    density = 2.0 * 0.1**2 / (2.0 * math.pi * 1000.0)
    assert found.noise_floor**2 / found.bandwidth == pytest.approx(density, rel=0.1)


def test_filtered_orbit_keeps_one_order():
    found = filtered_orbit(made(WHIRL + 0.3 * np.exp(3j * ANGLES)), order=1)
    np.testing.assert_allclose(found.x + 1j * found.y, WHIRL, atol=1e-10)


def test_probes_at_45_degrees_gains_and_runout_are_corrected():
    bent = WHIRL + 0.2 * np.exp(1j * (ANGLES + 1.0))
    turned = bent * np.exp(-0.25j * math.pi)
    read = made(2.0 * turned.real + 3.0j * turned.imag)
    seen = correct_probes(read, angles=(45, 135), gains=(2, 3))
    slow = made(0.2 * np.exp(1j * (ANGLES + 1.0)))
    clean = subtract_runout(seen, slow)
    np.testing.assert_allclose(clean.x + 1j * clean.y, WHIRL, atol=1e-10)


def written(path, z=WHIRL, head="t [s],x [um],y [um],angle [rad]", last=ANGLES, times=TIMES):
    table = np.column_stack([times, z.real, z.imag, last])
    np.savetxt(path, table, "%.17g", ",", header=head, comments="")
    return path


def test_csv_wav_mat_and_archive_give_back_what_was_written(tmp_path):
    read = read_signals(written(tmp_path / "a.csv"))
    np.testing.assert_array_equal(read.x, WHIRL.real)
    xr.testing.assert_identical(load(save(read, tmp_path / "a.nc")).drop_attrs(), read.drop_attrs())
    wavfile.write(tmp_path / "a.wav", 1000, np.stack([WHIRL.real, WHIRL.imag], axis=1))
    heard = read_signals(tmp_path / "a.wav", columns={"x": "1", "y": "2"})
    np.testing.assert_array_equal(heard.y, WHIRL.imag)
    pulses = np.arange(42) / 10.3
    held = {"t": TIMES, "x": WHIRL.real, "y": WHIRL.imag, "keyphasor": pulses}
    savemat(tmp_path / "a.mat", held)
    found = orders(read_signals(tmp_path / "a.mat"))
    np.testing.assert_allclose(found.forward_phase_lag, 0.4, rtol=1e-10)


def test_odd_files_get_one_line(tmp_path):
    path = tmp_path / "odd.csv"
    with pytest.raises(InputError, match="must have a column for y"):
        read_signals(written(path, head="t,x,b,angle"))
    with pytest.raises(InputError, match=r"t must have no gaps, got one of 1.* after 1\.999"):
        read_signals(written(path, times=TIMES + (TIMES > 1.9995)))
    with pytest.raises(InputError, match=r"x must not be clipped, but stays at 0\.5"):
        read_signals(written(path, z=np.minimum(WHIRL.real, 0.5) + 1j * WHIRL.imag))
    pulse = (np.mod(ANGLES, 2 * math.pi) < 0.5) & ~((TIMES > 1.9) & (TIMES < 2.0))
    with pytest.raises(InputError, match=r"must not lose pulses, but does after t 1\.8"):
        read_signals(written(path, head="t,x,y,keyphasor", last=pulse))
    with pytest.raises(InputError, match="samples a revolution for order 60"):
        orders(made(WHIRL), 60)
