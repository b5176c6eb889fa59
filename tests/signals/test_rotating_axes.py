import numpy as np
import pytest

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    dimensional,
    rotating,
    simulate,
    synchronous_response,
)
from rotor_ida.model.equations import rotated

REST = (0.0, 0.0, 0.0, 0.0)


def test_a_synchronous_whirl_is_a_point_at_minus_its_phase_lag():
    run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=REST, duration=100.0)
    seen = rotating(run).sel(t=slice(80.0, None))
    whirl = synchronous_response(omega=1.2, zeta=0.5, delta0=0.5).isel(branch=0).squeeze()
    point = whirl.amplitude.item() * np.exp(-1j * whirl.phase_lag.item())
    np.testing.assert_allclose(seen.rotating_x + 1j * seen.rotating_y, point, atol=1e-8)
    # the velocity is the bystander's: i omega Z, though Z stands still
    velocity = seen.rotating_vx + 1j * seen.rotating_vy
    np.testing.assert_allclose(velocity, 1.2j * point, atol=1e-8)


def test_turning_back_gives_the_run_and_events_stay_on_the_ring():
    run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=REST, duration=30.0)
    seen = rotating(run)
    states = np.stack([seen[f"rotating_{name}"] for name in ("x", "y", "vx", "vy")], axis=-1)
    back = rotated(states, 2.0 * run.t.values)
    for number, name in enumerate(("x", "y", "vx", "vy")):
        np.testing.assert_allclose(back[:, number], run[name], atol=1e-13)
    radius = np.hypot(seen.event_rotating_x, seen.event_rotating_y)
    assert radius.size > 3
    np.testing.assert_allclose(radius, 2.0, rtol=1e-14)
    assert seen.x.identical(run.x)


def test_a_run_in_si_units_is_answered_in_si_units_and_others_are_refused():
    machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
                               eccentricity=1e-6, clearance=2e-6, speed=600.0)  # fmt: skip
    run = simulate(machine.rotor(), start=REST, duration=5.0, samples=21)
    seen = rotating(dimensional(run, machine))
    np.testing.assert_allclose(seen.rotating_x, 1e-6 * rotating(run).rotating_x, rtol=1e-12)
    assert seen.rotating_x.attrs["units"] == "m"
    with pytest.raises(InputError, match="it lacks x"):
        rotating(run.drop_vars("x"))
    with pytest.raises(InputError, match="run must be a Dataset, got 3"):
        rotating(3)
