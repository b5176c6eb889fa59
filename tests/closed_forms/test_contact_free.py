"""Contact-free motion against its textbook solution, evaluated with 80 digits."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest

from rotor_ida.closed_forms import (
    contact_free_whirl,
    flight,
    synchronous_response,
    touch_fading,
    touch_speeds,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import Rotor


def reference_flight(time, rotor, start, start_time=0.0) -> list:
    """``z = c + d exp(-2 zeta t) + a exp(i omega t)``, written naively with 700 digits."""
    with mpmath.workdps(700):
        omega, zeta = mpmath.mpf(rotor.omega), mpmath.mpf(rotor.zeta)
        t, t0 = mpmath.mpf(time), mpmath.mpf(start_time)
        z0, v0 = mpmath.mpc(*start[:2]), mpmath.mpc(*start[2:])
        a = -omega / (omega - 2j * zeta) if omega else mpmath.mpf(0)
        z0_free = z0 - a * mpmath.expj(omega * t0)
        v0_free = v0 - 1j * omega * a * mpmath.expj(omega * t0)
        turning = mpmath.expj(omega * t)
        if zeta:
            decay = mpmath.exp(-2 * zeta * (t - t0))
            z = z0_free + v0_free * (1 - decay) / (2 * zeta) + a * turning
            v = v0_free * decay + 1j * omega * a * turning
        else:
            z = z0_free + v0_free * (t - t0) + a * turning
            v = v0_free + 1j * omega * a * turning
        return [z.real, z.imag, v.real, v.imag]


@pytest.mark.parametrize("start_time", [0.0, 123.456])
def test_flight_without_a_shaft_holds_to_rounding(start_time):
    start, elapsed = (0.3, -0.4, 0.11, 0.07), np.array([0.0, 1e-9, 0.3, 7.0, 1000.0, 1e9])
    times = start_time + elapsed
    for omega, zeta in itertools.product(
        [0.0, 1e-300, 1e-8, 1.7, 50.0], [0.0, 5e-324, 1e-300, 1e-8, 0.07, 5.0]
    ):
        rotor = Rotor(omega=omega, zeta=zeta, delta0=2.0)
        found = flight(times, rotor=rotor, start=start, start_time=start_time)
        for k, time in enumerate(times):
            expected = reference_flight(time, rotor, start, start_time)
            # roundings of the distance travelled, and of the speeds that make it up
            scale = [1.0 + 0.2 * elapsed[k] + omega * elapsed[k]] * 2 + [0.2 + 2.0 * omega] * 2
            for value, exact, size in zip(found[:, k], expected, scale, strict=True):
                assert abs(value - exact) < 1e-15 * size


def test_contact_free_whirl_is_the_branch_of_the_response():
    for omega, zeta, delta0 in [
        (1.7, 0.07, 1.0),
        (3.0, 0.0, 1.0),
        (1.0, 2.0, 0.5),
        (0.0, 1.0, 0.0),
    ]:
        whirl = contact_free_whirl(Rotor(omega=omega, zeta=zeta, delta0=delta0))
        branch = synchronous_response(omega=omega, zeta=zeta, delta0=delta0).isel(branch=0)
        assert int(branch.in_contact.item()) == 0
        assert whirl.amplitude == pytest.approx(branch.amplitude.item(), rel=1e-15)
        assert whirl.phase_lag == branch.phase_lag.item()
    assert contact_free_whirl(Rotor(omega=1.7, zeta=0.07, delta0=1.0)).amplitude == pytest.approx(
        0.996626148, abs=5e-10
    )


def test_no_contact_free_whirl_without_room():
    whirl = contact_free_whirl(Rotor(omega=1.7, zeta=0.07, delta0=0.5))
    assert not whirl.exists
    assert math.isnan(whirl.largest_centre_offset)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"time": [1.0, 0.4]}, r"not before start_time = 0\.5, got 0\.4"),
        ({"time": [math.nan]}, "time must be a finite real number, got nan"),
        ({"time": "soon"}, "time must be a finite real number, got 'soon'"),
        ({"time": 1e300}, r"omega \* time must be at most 1e\+15"),
        ({"start": (0.0, 1.0)}, "start must be four numbers"),
        ({"start_time": math.inf}, "start_time must be a finite real number"),
    ],
)
def test_impossible_flights_are_refused(changed, message):
    rotor = Rotor(omega=1.0, zeta=0.1, delta0=1.0)
    given_values = {"time": 1.0, "start": (0.0, 0.0, 0.0, 0.0), "start_time": 0.5, **changed}
    with pytest.raises(InputError, match=message):
        flight(given_values.pop("time"), rotor=rotor, **given_values)


@pytest.mark.parametrize(("omega", "constant"), [(0.5, 33.68), (2.28, 7.382), (2.94, 5.724)])
def test_the_constant_by_which_touches_fade_is_the_known_one(omega, constant):
    """From DESIGN, section 4, where it was held against 20,000 units of time of simulation."""
    found = touch_fading(Rotor(omega=omega, zeta=0.07, delta0=2.0))
    assert found == pytest.approx(constant, rel=2e-4)


@pytest.mark.parametrize(
    ("omega", "zeta", "delta0"), [(0.0, 0.1, 1.0), (1.7, 0.0, 2.0), (1.7, 0.07, 0.9), (1.0, 0.1, 0)]
)
def test_touches_do_not_fade_without_damping_speed_or_room(omega, zeta, delta0):
    assert math.isnan(touch_fading(Rotor(omega=omega, zeta=zeta, delta0=delta0)))


def test_touches_fade_at_the_smallest_speeds_too():
    assert touch_fading(Rotor(omega=1e-200, zeta=0.1, delta0=1.0)) > 0.0


def amplitude_with_shaft(omega, zeta, kappa) -> mpmath.mpf:
    q = mpmath.mpf(omega) ** 2
    return q / abs(mpmath.mpc(mpmath.mpf(kappa) - q, 2 * mpmath.mpf(zeta) * mpmath.mpf(omega)))


def test_a_shaft_leaves_one_whirl_about_the_bearing_axis():
    for omega, zeta, kappa in itertools.product([0.3, 0.5, 2.0], [0.0, 0.07], [0.09, 0.25, 3.0]):
        if zeta == 0.0 and omega**2 == kappa:
            continue
        rotor = Rotor(omega=omega, zeta=zeta, delta0=1e3, shaft_stiffness=kappa)
        whirl = contact_free_whirl(rotor)
        with mpmath.workdps(40):
            q = mpmath.mpf(omega) ** 2
            lag = mpmath.atan2(2 * mpmath.mpf(zeta) * mpmath.mpf(omega), mpmath.mpf(kappa) - q)
            if abs(amplitude_with_shaft(omega, zeta, kappa)) > 1e3:
                assert not whirl.exists
            else:
                assert whirl.largest_centre_offset == 0.0
            assert abs(whirl.amplitude / amplitude_with_shaft(omega, zeta, kappa) - 1) < 1e-15
            assert whirl.phase_lag == pytest.approx(float(lag), rel=1e-15)


@pytest.mark.parametrize("delta0", [0.3, 1.0, np.nextafter(1.0, 2.0), 1.2, 4.0])
@pytest.mark.parametrize("kappa", [1e-3, 0.25, 2.0])
@pytest.mark.parametrize("zeta", [0.0, 1e-3, 0.07])
def test_at_the_touch_speeds_the_whirl_is_as_large_as_the_clearance(delta0, kappa, zeta):
    first, second = touch_speeds(zeta=zeta, delta0=delta0, shaft_stiffness=kappa)
    found = [omega for omega in (first, second) if np.isfinite(omega)]
    with mpmath.workdps(40):
        # the slope of the amplitude makes more or less of a rounded speed
        for omega in found:
            amplitude = amplitude_with_shaft(omega, zeta, kappa)
            slope = mpmath.diff(lambda w: amplitude_with_shaft(w, zeta, kappa), omega)
            assert abs(amplitude - delta0) < 4e-16 * abs(slope) * omega
        # too large for the clearance from the first to the second, and nowhere else
        for omega in np.geomspace(1e-3, 1e3, 200):
            too_large = amplitude_with_shaft(omega, zeta, kappa) > delta0
            assert too_large == (first < omega and not omega > second)


def test_touch_speeds_that_are_nearly_one_are_told_apart():
    # the largest whirl is kappa/(2 zeta sqrt(kappa - zeta**2))
    zeta, kappa = 0.125, 1.0
    largest = kappa / (2.0 * zeta * np.sqrt(kappa - zeta**2))
    below = touch_speeds(zeta=zeta, delta0=largest * (1.0 - 1e-13), shaft_stiffness=kappa)
    above = touch_speeds(zeta=zeta, delta0=largest * (1.0 + 1e-13), shaft_stiffness=kappa)
    assert np.isfinite(below).all()
    assert 0.0 < below[1] - below[0] < 1e-5
    assert np.isnan(above).all()


def test_without_a_shaft_there_is_one_touch_speed_as_in_the_paper():
    expected = 2.0 * 0.07 * 0.5 / np.sqrt(1.0 - 0.5**2)
    found = touch_speeds(zeta=0.07, delta0=0.5)
    assert found[0] == pytest.approx(expected, rel=1e-15)
    assert np.isnan(found[1])
    assert np.isnan(touch_speeds(zeta=0.07, delta0=1.0)).all()


def test_no_touches_fade_with_a_shaft_and_a_load_moves_the_whirl_about_the_sag():
    shaft = Rotor(omega=1.0, zeta=0.1, delta0=3.5, shaft_stiffness=0.25)
    assert np.isnan(touch_fading(shaft))  # which leaves one whirl: no touches fade towards it
    free, sagged = (contact_free_whirl(replace(shaft, load=each)) for each in (0.0, 0.5))
    assert sagged.amplitude == free.amplitude
    assert sagged.largest_centre_offset == 2.0
    assert not contact_free_whirl(replace(shaft, load=0.6)).exists  # 2.4 + 1.286 > 3.5
    assert not contact_free_whirl(replace(shaft, load=0.5, shaft_stiffness=0.0)).exists
