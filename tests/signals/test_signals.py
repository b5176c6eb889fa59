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
    limit_cycle,
    load,
    orders,
    read_signals,
    run_up,
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
    read = read_signals(written(tmp_path / "a.csv"), keep_offset=True)
    np.testing.assert_array_equal(read.x, WHIRL.real)
    xr.testing.assert_identical(load(save(read, tmp_path / "a.nc")).drop_attrs(), read.drop_attrs())
    wavfile.write(tmp_path / "a.wav", 1000, np.stack([WHIRL.real, WHIRL.imag], axis=1))
    heard = read_signals(tmp_path / "a.wav", columns={"x": "1", "y": "2"}, keep_offset=True)
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
    with pytest.raises(InputError, match=r"t must have no gaps, got one of 1.* line 2001"):
        read_signals(written(path, times=TIMES + (TIMES > 1.9995)))
    with pytest.raises(InputError, match=r"x must not be clipped, but stays at 0\.5"):
        read_signals(written(path, z=np.minimum(WHIRL.real, 0.5) + 1j * WHIRL.imag))
    pulse = (np.mod(ANGLES, 2 * math.pi) < 0.5) & ~((TIMES > 1.9) & (TIMES < 2.0))
    with pytest.raises(InputError, match=r"must not lose pulses, but does after t 1\.8"):
        read_signals(written(path, head="t,x,y,keyphasor", last=pulse))
    with pytest.raises(InputError, match="samples a revolution for order 60"):
        orders(made(WHIRL), 60)


def test_a_slow_run_up_gives_the_steady_curve_and_its_error_falls_with_the_rate():
    """Linear whirl on a shaft: c = s**2/(1 - s**2 + 2 i zeta s)."""
    rotor, errors = Rotor(omega=1.0, zeta=0.2, delta0=10.0, shaft_stiffness=1.0), []
    for rate in (0.004, 0.002):
        run = run_up(rotor, start=(0, 0, 0, 0), to=2.0, rate=rate, samples=int(20 / rate) + 1)
        found = orders(run).isel(order=0)
        speed = found.speed.values
        exact = speed**2 / (1.0 - speed**2 + 0.4j * speed)
        whirl = found.forward_whirl_amplitude * np.exp(-1j * found.forward_phase_lag)
        errors.append(np.abs(whirl.values - exact)[speed > 1.3].max())
    assert errors[0] < 0.05
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.3)


def test_an_exact_cycle_has_its_own_lines_forward_and_backward():
    """Flat-top shows a line to 0.1 % wherever it lies between the steps of the grid."""
    rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
    cycle = limit_cycle(rotor, start=(3.0, 1.0, 0.0, 0.0))
    start = [float(cycle[name][0]) for name in ("x", "y", "vx", "vy")]
    length = 60.0 * float(cycle.period)
    found = full_spectrum(simulate(rotor, start=start, duration=length, samples=12001))
    highest = np.argsort(-cycle.whirl_amplitude.values)[:3]
    for place in highest:
        near = np.abs(found.frequency - cycle.frequency.values[place]) < 6.0 * np.pi / length
        line = found.whirl_amplitude.values[near.values].max()
        assert line == pytest.approx(cycle.whirl_amplitude.values[place], rel=1.5e-3)
    assert (cycle.frequency.values[highest] < 0.0).any()
