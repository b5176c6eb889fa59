"""Many run-ups of a rotor system: those of one disc, those of `run_up`, and their endings."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    concat,
    run_up,
    run_ups,
    simulate,
    sweep,
)
from rotor_ida.plot.figures import figure_of
from rotor_ida.results.contact_facts import columns_of_contact, contact_facts
from rotor_ida.verification.verify import differences, rerun

REST = (0.0, 0.0, 0.0, 0.0)
SHAFT = Rotor(omega=0.3, zeta=0.1, delta0=2.0, shaft_stiffness=1.0)
WHIP = Rotor(omega=0.6, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
LOADED = Rotor(
    omega=2.0, zeta=0.07, delta0=1.0, shaft_stiffness=0.3, contact_exponent=1.0,
    contact_damping=0.5, load=0.2, friction=0.3, disc_radius=0.6,
)  # fmt: skip
SAME = (
    "largest_radius", "largest_radius_speed", "largest_force", "first_touch_speed",
    "last_exit_speed", "first_roll_speed", "contact_count", "contact_time", "total_heat",
    "total_contact_loss", "end_angle", "radius_min", "radius_max", "period",
)  # fmt: skip
TOUCH = {"stiffness": 4.0, "exponent": 1.0, "friction": 0.1, "radius": 3.0}
TWO = RotorSystem(
    mass=np.diag([1.0, 1.0, 0.5, 0.5]), damping=0.2 * np.eye(4),
    stiffness=np.kron([[2.0, -1.0], [-1.0, 1.5]], np.eye(2)), nodes={"disc": (0, 1), "end": (2, 3)},
    contacts=[Contact(node="disc", clearance=1.5, **TOUCH),
              Contact(node="end", clearance=1.6, **TOUCH)],
    unbalance=[Unbalance(node="disc", moment=1.0, phase=0.2)], units="1",
)  # fmt: skip
RAMP = {"speed": 0.3, "to": 1.4, "rate": [0.02, 0.2]}


@pytest.mark.parametrize(
    ("rotor", "to", "rate", "start"),
    [(SHAFT, 1.6, [0.01, 0.3], REST), (WHIP, 0.7, [0.01], (5.0, 0.0, 0.0, -6.0)),
     (LOADED, 0.5, [-0.1], (0.3, -0.1, 0.2, 0.1))],
    ids=["shaft", "whip", "down, all of it"],
)  # fmt: skip
def test_one_disc_as_a_system_runs_up_as_the_disc(rotor, to, rate, start):
    """Two kernels, two ways to settle, and the same facts."""
    given = {"to": to, "rate": rate, "phase": [0.0, 2.0], "executor": "serial"}
    disc = run_ups(rotor, starts=[start], **given).squeeze()
    begun = [(start[:2], start[2:])]
    system = run_ups(rotor.system(), speed=rotor.omega, starts=begun, **given).squeeze()
    for name in ("ending", "response", "whip_fraction", "rub_fraction_error", "failed_count"):
        np.testing.assert_array_equal(disc[name], system[name])
    for name in SAME:
        if name in disc:
            np.testing.assert_allclose(system[name], disc[name], rtol=1e-7, atol=1e-8, err_msg=name)
    if rotor is SHAFT:  # synchronous at the end
        np.testing.assert_allclose(system.amplitude, disc.amplitude, rtol=1e-9)
        turn = np.exp(1j * (system.phase_lag - disc.phase_lag))
        np.testing.assert_allclose(turn, 1.0, atol=1e-8)


def test_each_is_the_run_of_run_up_and_settles_as_a_sweep_does():
    found = run_ups(TWO, **RAMP, phase=[0.0, 1.0], executor="serial")
    assert dict(found.ending.sizes) == {"speed": 1, "rate": 2, "phase": 2, "start": 1}
    for place in np.ndindex(2, 2):
        one = found.isel(speed=0, rate=place[0], phase=place[1], start=0)
        ahead = [replace(each, phase=each.phase + float(one.phase)) for each in TWO.unbalance]
        alone = run_up(TWO, unbalance=ahead, speed=0.3, to=1.4, rate=float(one.rate), samples=None)
        np.testing.assert_array_equal(one.final_state, alone.final_state)
        for number in range(2):
            mine = alone.episode_contact.values == number
            forces = alone.peak_force.values[mine]
            # a sample at the peak may be rounded otherwise than the peak
            largest = pytest.approx(forces.max(initial=0.0), rel=1e-15)
            assert float(one.largest_force[number]) == largest
            assert int(one.contact_count[number]) == mine.sum()
        ended = sweep(TWO, speed=[1.4], starts=[one]).squeeze()
        assert int(ended.response) == int(one.response)
        for name in ("radius_min", "radius_max", "amplitude", "node_amplitude", "phase_lag"):
            np.testing.assert_allclose(one[name], ended[name], rtol=1e-6, err_msg=name)


def test_a_grid_is_computed_again_joined_and_drawn():
    given = {"speed": 0.3, "to": 1.4, "rate": 0.2, "clearance": [0.8, 1.6], "modes": 2}
    found = run_ups(TWO, **given, friction=[0.0, 0.1])
    assert differences(rerun(found, workers=1), found)["agrees"]
    parts = [run_ups(TWO, **given, friction=each) for each in (0.0, 0.1)]
    joined = concat(parts, "friction").largest_force.transpose(*found.largest_force.dims)
    xr.testing.assert_equal(joined, found.largest_force)
    titles = [ax.get_title() for ax in figure_of(found).axes]
    assert "largest clearance 0.8,  largest friction 0.1" in titles


def test_a_run_goes_on_from_the_end_of_one():
    one = run_ups(TWO, **RAMP, executor="serial").isel(speed=0, rate=0, phase=0, start=0)
    longer = run_up(TWO, speed=0.3, to=1.4, rate=0.02, duration=55.0 + 3.0)
    on = simulate(TWO, speed=1.4, start=one, duration=3.0)
    radius = np.hypot(*longer.final_state.values[:2])
    assert np.hypot(*on.final_state.values[:2]) == pytest.approx(radius, rel=1e-7)


def test_facts_of_a_contact_that_begins_and_ends_with_the_run():
    """The whole run is one contact; what its damping takes is that of the same disc."""
    rotor = replace(SHAFT, delta0=0.5, omega=2.0, contact_damping=0.5)
    run = simulate(rotor.system(), speed=2.0, start=((3.0, 0.0), (0.0, 6.0)), duration=0.2)
    facts = contact_facts(columns_of_contact(run, 0), 0.5)
    alone = simulate(rotor, start=(3.0, 0.0, 0.0, 6.0), duration=0.2)
    assert facts["total_contact_loss"] == pytest.approx(alone.contact_loss.item(), rel=1e-9)
    assert facts["total_contact_loss"] > 0.1
    assert np.isnan(run.energy_lost.item())
    assert facts["contact_count"] == 1
    assert facts["contact_time"] == 0.2
    assert facts["first_touch_time"] == 0.0
    assert np.isnan([facts["last_exit_time"], facts["first_roll_time"]]).all()
    assert facts["largest_radius"] == 0.5 - facts["smallest_gap"] >= 3.0


@pytest.mark.parametrize(
    ("given", "words"),
    [({"to": 0.0}, "to must not be 0 in run-ups of a rotor system, got 0.0"),
     ({"rate": [-0.1]}, r"rate must be positive to change the speed from 0.3 to 1.4, got -0.1"),
     ({"rate": [0.1, 0.1]}, "rate"),
     ({"starts": []}, "starts must be a list of"),
     ({"friction": -0.1}, "friction must be zero or positive, got -0.1"),
     ({"clearance": [1.0, -1.0]}, "clearance must be zero or positive, got -1.0"),
     ({"modes": 2, "starts": [xr.Dataset()]}, "starts must be .q, velocity. with modes"),
     ({"atol": 1e-9}, "atol must be left out with a rotor system, got 1e-09"),
     ({"frictn": 0.1}, "unexpected keyword argument 'frictn'; did you mean 'friction'")],
)  # fmt: skip
def test_what_cannot_be_run_up_is_refused(given, words):
    with pytest.raises((InputError, TypeError), match=words):
        run_ups(TWO, **RAMP | given, executor="serial")
