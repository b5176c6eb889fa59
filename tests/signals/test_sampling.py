"""Samples that would show one whirl as another are refused, with the number that would do."""

import math
import re

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    backward_whirl,
    centre_line,
    dimensional,
    filtered_orbit,
    full_spectrum,
    orders,
    run_up,
    signals_of,
    simulate,
    spectrogram,
    whirl_ratio,
)
from rotor_ida.schema import labelled

ROTOR = Rotor(omega=0.1, zeta=0.05, delta0=5.0, shaft_stiffness=1.0)
REST = (0.0, 0.0, 0.0, 0.0)
READERS = [signals_of, orders, centre_line, whirl_ratio, full_spectrum, spectrogram,
           lambda signals: filtered_orbit(signals, order=1),
           lambda signals: filtered_orbit(signals, band=(0.1, 0.2))]  # fmt: skip


def ramp(samples):
    return run_up(ROTOR, start=REST, to=2.0, rate=0.002, samples=samples, method="taylor")


@pytest.fixture(scope="module")
def coarse():
    """A run-up of 159 revolutions in 160 samples: its forward whirl passes for a backward one."""
    return ramp(160)


@pytest.mark.parametrize("read", READERS)
def test_one_sample_a_revolution_is_refused(coarse, read):
    with pytest.raises(InputError, match=r"more than 4 samples in each revolution, got 0\.5"):
        read(coarse)


def test_the_number_in_the_message_would_do(coarse):
    with pytest.raises(InputError) as refused:
        orders(coarse)
    enough = int(re.search(r": (\d+) samples in all are enough", str(refused.value))[1])
    track = orders(ramp(enough)).isel(order=0)
    assert float(track.backward_whirl_amplitude.max()) < 0.02 * float(
        track.forward_whirl_amplitude.max()
    )


def test_dry_whip_that_turns_faster_than_the_rotor_is_refused_by_its_velocities():
    """At 18 samples a revolution, whip at 5 times the speed has fewer than 4 in a turn."""
    rotor = Rotor(omega=0.1, zeta=0.02, delta0=1.0, friction=0.4, disc_radius=8.0)
    whip = backward_whirl(rotor).isel(whirl=-1)
    assert whip.whirl_speed / rotor.omega < -5.0
    radius, speed = float(whip.amplitude), float(whip.whirl_speed)
    start = (radius, 0.0, 0.0, radius * speed)
    run = simulate(rotor, start=start, duration=400.0, samples=int(18 * 400.0 * 0.1 / 6.283))
    with pytest.raises(InputError, match=r"more than 4 samples in each turn of the whirl, got 3\."):
        whirl_ratio(run)
    run = simulate(rotor, start=start, duration=400.0)
    assert whirl_ratio(run).whirl_over_spin.mean() == pytest.approx(speed / rotor.omega, rel=0.01)


def test_units_change_nothing():
    machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6,
                               clearance=2e-6, speed=1000.0)  # fmt: skip
    rotor = machine.rotor()
    periods = 40.0 * 2.0 * math.pi / rotor.omega
    for each, refused in ((3, True), (5, False)):
        run = simulate(rotor, start=REST, duration=periods, samples=40 * each + 1)
        shown = dimensional(run, machine, units={"length": "µm", "time": "ms"})
        if refused:
            with pytest.raises(InputError, match="in each revolution, got 3"):
                orders(shown)
        else:
            orders(shown)


def measured(per_revolution, revolutions=100):
    """What a probe behind a filter sees of a synchronous whirl."""
    angle = 2.0 * math.pi * np.arange(int(per_revolution * revolutions)) / per_revolution
    z = np.exp(1j * (angle - 0.3))
    columns = {"x": z.real, "y": z.imag, "angle": angle}
    return xr.Dataset(
        {name: labelled(name, "t", column) for name, column in columns.items()},
        {"t": labelled("t", "t", angle / 3.0)},
    )


def test_measured_signals_need_more_than_two_samples_a_revolution():
    assert float(orders(measured(3.1), revolutions=10).forward_whirl_amplitude[0, 0]) == (
        pytest.approx(1.0, rel=1e-9)
    )
    with pytest.raises(InputError, match=r"more than 2 samples in each revolution, got 1\.9"):
        full_spectrum(measured(1.9))


def test_rest_and_a_free_motion_at_no_speed_are_taken():
    run = simulate(Rotor(omega=0.0, zeta=0.1, delta0=1.0), start=(3.0, 0, 0, 0.5), duration=60.0)
    full_spectrum(run)
    still = run.assign({name: run[name] * 0.0 for name in ("x", "y", "vx", "vy")})
    assert float(full_spectrum(still).whirl_amplitude.max()) == 0.0
