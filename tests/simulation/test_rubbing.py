"""What friction leaves in the table of contacts: heat, slip distance and the share of rolling."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, contact_summary, simulate, synchronous_response
from tests.simulation.test_friction import MACHINES
from tests.witness import rubbed


def test_a_synchronous_rub_slides_round_the_ring_by_rim_and_whirl():
    """v_s = (A + rho) omega and N are constant: so are heat and distance in a unit of time."""
    rotor = Rotor(omega=1.2, zeta=0.3, delta0=0.5, friction=0.1, disc_radius=10.0)
    exact = synchronous_response(omega=1.2, zeta=0.3, delta0=0.5, friction=0.1).squeeze()
    size, lag = float(exact.amplitude), float(exact.phase_lag)
    z = size * np.exp(-1j * lag)
    start = (z.real, z.imag, (1j * 1.2 * z).real, (1j * 1.2 * z).imag)
    told = contact_summary(simulate(rotor, start=start, duration=30.0, samples=301))
    distance = 30.0 * 1.2 * (size + 10.0)
    assert told.total_slip_distance.item() == pytest.approx(distance, rel=1e-8)
    heat = 0.1 * (size - 0.5) ** 1.5 * distance
    assert told.total_heat.item() == pytest.approx(heat, rel=1e-8)
    revolutions = 30.0 * 1.2 / (2.0 * math.pi)
    assert told.heat_per_revolution.item() == pytest.approx(heat / revolutions, rel=1e-8)
    assert told.rolling_fraction.item() == 0.0


@pytest.mark.parametrize("name", ["dry whip", "rough ring", "small disc, that chatters"])
def test_the_share_of_rolling_is_that_between_events_of_another_integrator(name):
    rotor, start, duration, _ = MACHINES[name]
    events, _ = rubbed(rotor, start, duration)
    times = np.array([time for time, _ in events] + [duration])
    kinds = np.array([kind for _, kind in events])
    rolled = np.diff(times)[kinds == 2].sum()
    touched, since = 0.0, 0.0 if math.hypot(*start[:2]) > rotor.delta0 else None
    for time, kind in events:
        if kind == 1:
            since = time
        elif kind == -1:
            touched, since = touched + time - since, None
    touched += 0.0 if since is None else duration - since
    told = contact_summary(simulate(rotor, start=start, duration=duration, method="taylor"))
    assert told.rolling_fraction.item() == pytest.approx(rolled / touched, rel=1e-7)


@pytest.mark.parametrize("name", MACHINES)
def test_the_slip_distance_is_the_integral_of_the_slip_speed(name):
    """Trapezoids over 30 times as many samples, which jump at no event, come near it."""
    rotor, start, duration, _ = MACHINES[name]
    run = {"start": start, "duration": duration, "method": "taylor"}
    told = contact_summary(simulate(rotor, samples=2001, **run)).total_slip_distance.item()
    fine = simulate(rotor, samples=60_001, **run)
    speed = np.where(np.isin(fine.mode, (1, -1)), np.abs(fine.slip_speed), 0.0)
    # at entries and exits, and while a mode changes, a trapezoid is out by half a spacing
    most = fine.sizes["event"] * speed.max() * float(fine.t[1])
    assert told == pytest.approx(np.trapezoid(speed, fine.t), abs=most)
    assert most < 0.02 * told


def test_samples_that_are_too_far_apart_tell_no_distance():
    rotor, start, duration, _ = MACHINES["dry whip"]
    few = contact_summary(simulate(rotor, start=start, duration=duration, samples=3))
    assert np.isnan(few.total_slip_distance.item())
    assert few.total_heat.item() > 0.0
    assert 0.0 < few.rolling_fraction.item() < 1.0


def test_a_run_without_touches_has_no_heat():
    rotor = Rotor(omega=0.3, zeta=0.1, delta0=5.0, friction=0.2, disc_radius=1.0)
    told = contact_summary(simulate(rotor, start=(0, 0, 0, 0), duration=10.0))
    assert told.total_heat.item() == told.total_slip_distance.item() == 0.0
    assert np.isnan(told.rolling_fraction.item())


def test_without_friction_nothing_is_told_of_it():
    told = contact_summary(simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0),
                                    start=(0, 0, 0, 0), duration=20.0))  # fmt: skip
    assert not {"total_heat", "total_slip_distance", "rolling_fraction"} & set(told)
