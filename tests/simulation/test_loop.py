"""The event loop: known event times, starts of every kind, conservation and convergence."""

import math

import numpy as np
import pytest
from scipy.special import beta

from rotor_ida import InputError, Rotor, simulate
from rotor_ida.core.runs import RunRequest, follow_run
from rotor_ida.model.equations import energy
from rotor_ida.model.parameters import OF_ROTOR

LEAVING = beta(0.4, 0.5) / math.sqrt(5.0)  # time from rest at A to the ring, times (A-delta0)^1/4
REST = (0.0, 0.0, 0.0, 0.0)


def planar_events(amplitude, delta0, duration):
    """Exact events of free planar vibration with clearance, from rest at `amplitude`."""
    leaving = LEAVING * (amplitude - delta0) ** -0.25
    crossing = 2.0 * delta0 / (math.sqrt(0.8) * (amplitude - delta0) ** 1.25)
    times, time = [], leaving
    while time < duration:
        times += [time, time + crossing]
        time += crossing + 2.0 * leaving
    return np.array([time for time in times if time < duration])


@pytest.mark.parametrize("duration", [1.0, 60.0])
def test_the_smallest_clearance_is_crossed_event_by_event(duration):
    """The rotor flies across it in 2e-12 over its speed, still far above the spacing of doubles."""
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=OF_ROTOR["delta0"].smallest)
    run = simulate(rotor, start=(1.0, 0, 0, 0), duration=duration)
    exact = planar_events(1.0, OF_ROTOR["delta0"].smallest, duration)
    assert run.event_kind.values.tolist() == ([-1, 1] * exact.size)[: exact.size]
    assert np.abs(run.event_time.values - exact).max(initial=0.0) < 100 * 1e-10 * duration
    with pytest.raises(InputError, match="delta0 must be 0 or at least 1e-12 to be simulated"):
        simulate(Rotor(omega=2.0, zeta=0.07, delta0=1e-100), start=REST, duration=5.0)


@pytest.mark.parametrize("start", [(0.3, 0.0, 1.0, 0.4), (2.0, 0.0, 0.0, 0.0)])
def test_energy_and_angular_momentum_are_conserved_over_a_thousand_contacts(start):
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=1.0)
    run = simulate(rotor, start=start, duration=5600.0, samples=5001, rtol=1e-12, atol=1e-14)
    states = np.stack([run[name].values for name in ("x", "y", "vx", "vy")], axis=-1)
    assert run.sizes["contact"] > 1000
    assert np.ptp(energy(states, 1.0)) < 1e-8
    assert np.ptp(states[:, 0] * states[:, 3] - states[:, 1] * states[:, 2]) < 1e-8


def test_an_event_at_the_end_time_belongs_to_the_run():
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=1.0)
    leaving = LEAVING * 1.0
    run = simulate(rotor, start=(2.0, 0, 0, 0), duration=leaving)
    assert run.event_kind.values.tolist() == [-1]
    assert run.event_time.item() == pytest.approx(leaving, abs=1e-9)
    touching = simulate(rotor, start=(0.0, 0, 0.5, 0), duration=2.0)
    assert touching.event_kind.values.tolist() == [1]
    assert touching.event_time.item() == pytest.approx(2.0, rel=1e-15)


def test_without_clearance_there_are_no_events():
    run = simulate(Rotor(omega=1.7, zeta=0.07, delta0=0.0), start=REST, duration=50.0)
    assert run.starts_in_contact == 1
    assert run.sizes["event"] == 0
    assert run.sizes["contact"] == 1
    radius = np.hypot(run.x, run.y)
    assert run.peak_indentation.item() == pytest.approx(radius.max().item(), rel=1e-3)
    assert run.peak_indentation.item() >= radius.max().item() - 1e-12


@pytest.mark.parametrize("flight", ["exact", "cvode"])
def test_event_states_lie_on_the_ring_to_rounding(flight):
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    run = simulate(rotor, start=REST, duration=100.0, flight=flight)
    radius = np.hypot(run.event_x.values, run.event_y.values)
    assert run.sizes["event"] > 30
    assert radius == pytest.approx(2.0, rel=4e-16)
    radial = run.event_x * run.event_vx + run.event_y * run.event_vy
    assert (np.sign(radial) == run.event_kind).all()


def test_samples_do_not_depend_on_how_many_there_are():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    few = simulate(rotor, start=REST, duration=20.0, samples=[5.0, 20.0])
    many = simulate(rotor, start=REST, duration=20.0, samples=2001)
    picked = many.sel(t=[5.0, 20.0])
    assert np.abs(few.x - picked.x).max() < 1e-12
    assert (few.event_time.values == many.event_time.values).all()


def short_by_rounding(times, durations):
    """Return where time + (duration - time) falls short of the duration by an ulp."""
    short = np.flatnonzero((times < durations) & (times + (durations - times) < durations))
    assert short.size > 10
    return short


@pytest.mark.parametrize("exact_flight", [True, False])
def test_the_core_loses_no_sample_to_rounding_at_the_end(exact_flight):
    """On a flight that begins at an exit and lasts to the end of the run."""
    rotor = Rotor(omega=0.0, zeta=0.2, delta0=3.0)

    def followed(duration):
        asked = RunRequest(
            rotor=rotor, start=(4.0, 0.0, 0.0, 0.0), duration=duration, rtol=1e-9, atol=1e-11,
            sample_times=np.array([duration]), events=True, method="adams",
            exact_flight=exact_flight,
        )  # fmt: skip
        return follow_run(asked)

    exits = followed(60.0).event_times
    durations = np.random.default_rng(0).uniform(2.0 * exits[-1], 60.0, 100_000)
    short = short_by_rounding(np.full_like(durations, exits[-1]), durations)
    for duration in durations[short[:10]].tolist():
        seen = followed(duration)
        assert seen.event_times[-1] == pytest.approx(exits[-1], rel=1e-12)
        np.testing.assert_allclose(seen.samples[0], seen.state, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("inside", [1e-3, 1e-7, 1e-9, 1e-11])
@pytest.mark.parametrize("flight", ["exact", "cvode"])
def test_a_steady_whirl_near_the_ring_has_no_events(inside, flight):
    """The contact-free whirl, with the ring on it, just outside it and just inside it."""
    omega, zeta = 1.7, 0.07
    whirl = -omega / complex(omega, -2.0 * zeta)
    spin = 1j * omega * whirl
    start = (whirl.real, whirl.imag, spin.real, spin.imag)
    for delta0, contact in (
        (abs(whirl), 0),
        (abs(whirl) * (1.0 + inside), 0),
        (abs(whirl) * (1.0 - inside), 1),
    ):
        rotor = Rotor(omega=omega, zeta=zeta, delta0=delta0)
        run = simulate(rotor, start=start, duration=60.0, samples=2, flight=flight)
        assert run.sizes["event"] == 0
        assert run.starts_in_contact == contact


def test_an_event_behind_the_end_keeps_its_own_time_and_moves_nothing():
    """Within 1e-8 of the duration it belongs to the run; the motion up to the end is untouched."""
    free = Rotor(omega=0.0, zeta=0.0, delta0=1000.0)
    run = simulate(free, start=(0, 0, 1, 0), duration=1000.0 - 9e-6, samples=[0.0, 1000.0 - 9e-6])
    assert run.event_time.values == pytest.approx([1000.0], rel=1e-15)
    assert run.event_time_error.values[0] < 1e-11
    assert run.x.values[-1] == pytest.approx(1000.0 - 9e-6, rel=1e-15)
    early = simulate(free, start=(0, 0, 1, 0), duration=999.0)
    assert early.sizes["event"] == 0
    bouncing, end = Rotor(omega=2.0, zeta=0.07, delta0=2.0), 80.8513707
    times = np.linspace(0.0, end, 11)
    run, longer = (
        simulate(bouncing, start=REST, duration=duration, samples=times) for duration in (end, 82.0)
    )
    assert 0.0 < run.event_time.values[-1] - end < 1e-8 * end
    same = longer.isel(event=slice(run.sizes["event"]))
    for name in ("event_time", "x", "y", "vx", "vy"):
        assert run[name].values == pytest.approx(same[name].values, rel=0.0, abs=1e-9), name


@pytest.mark.parametrize("flight", ["exact", "cvode"])
@pytest.mark.parametrize("inwards", [1e-9, 1e-12])
def test_a_start_on_the_ring_that_dips_inwards_comes_out_again(flight, inwards):
    """Inwards at 1e-9 against a centrifugal pull of one: back on the ring after 2e-9."""
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=1.0)
    run = simulate(rotor, start=(1.0, 0, -inwards, 1.0), duration=2.0, samples=9, flight=flight)
    assert run.event_kind.values.tolist()[:1] == [1]
    assert run.event_time.values[0] < 1e-4
    assert run.peak_indentation.values[0] > 0.1


@pytest.mark.parametrize("method", ["adams", "bdf", "ida"])
@pytest.mark.parametrize("depth", [1e-14, 1e-11, 1e-8])
def test_a_start_in_contact_that_is_over_at_once(method, depth):
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=1.0)
    run = simulate(rotor, start=(1.0 + depth, 0, -1.0, 0), duration=0.05, method=method)
    true_depth = (1.0 + depth) - 1.0
    assert run.starts_in_contact == 1
    assert run.event_time.values == pytest.approx([true_depth], rel=1e-4)


@pytest.mark.parametrize("delta0", [0.77, 1.3, 2.7])
def test_what_falls_inwards_from_the_ring_is_not_held_for_outside_it(delta0):
    """At first by less than rounding, as t**3: integrated coarsely it still meets the ring once."""
    rotor, start = Rotor(omega=3.0, zeta=0.0, delta0=delta0), (0.0, -delta0, 0.0, 0.0)
    exact, coarse = (
        simulate(rotor, start=start, duration=1.5, method="bdf", samples=2, **how)
        for how in ({"rtol": 1e-12}, {"rtol": 1e-4, "atol": 1e-14, "flight": "cvode"})
    )
    assert coarse.event_kind.values.tolist() == exact.event_kind.values.tolist() == [1]
    assert coarse.event_time.item() == pytest.approx(exact.event_time.item(), abs=1e-2)
