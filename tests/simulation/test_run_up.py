"""Speeds that change: prescribed ramps, up, down and piece by piece, and limited power."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.optimize import brentq

import rotor_ida
from rotor_ida import (
    InputError,
    InvariantError,
    Rotor,
    contact_forces,
    contact_summary,
    rotating,
    run_up,
    simulate,
    synchronous_response,
)
from rotor_ida.closed_forms import ramp_flight
from rotor_ida.simulation import run as run_module
from rotor_ida.simulation.invariants import check_orbit
from rotor_ida.verification.verify import differences, rerun
from tests.witness import Disc, followed

START = (0.3, 0.1, 0.2, 0.1)
REST = (0.0, 0.0, 0.0, 0.0)
WHIPS = (5.0, 0.0, 0.0, -6.3)
PAPER = Rotor(omega=0.5, zeta=0.07, delta0=1.0)
SHAFT = Rotor(omega=0.5, zeta=0.05, delta0=1.0, shaft_stiffness=0.3, contact_exponent=1.0)
WHIP = Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
CHATTERS = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.3, disc_radius=0.6)
ALL = Rotor(
    omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.2, contact_exponent=1.0,
    contact_damping=2.0, load=1.5, friction=0.4, disc_radius=0.5,
)  # fmt: skip


def ramp(rotor, to, rate):
    return {"to": to, "rate": rate}, [((to - rotor.omega) / rate, Disc(rotor, rate))]


def piecewise(rotor, *points):
    slopes = [(b[0], (b[1] - a[1]) / (b[0] - a[0])) for a, b in pairwise(points)]
    return {"speeds": list(points)}, [(end, Disc(rotor, slope)) for end, slope in slopes]


def powered(rotor, torque, inertia, duration):
    given = {"torque": torque, "inertia": inertia, "duration": duration}
    return given, [(duration, Disc(rotor, torque=torque, inertia=inertia))]


# Rotor, start, how its speed changes, and the kinds of event that each shows.
RUNS = {
    "the paper's rotor, up": (PAPER, START, ramp(PAPER, 2.5, 0.1), {1, -1}),
    "down to rest, a linear ring, contact damping and a load": (
        replace(SHAFT, omega=2.5, contact_damping=2.0, load=0.3), START,
        ramp(replace(SHAFT, omega=2.5, contact_damping=2.0, load=0.3), 0.0, -0.1), {1, 4, -4},
    ),
    "friction, piece by piece": (
        CHATTERS, START, piecewise(CHATTERS, (0.0, 1.2), (6.0, 1.8), (9.0, 1.8), (20.0, 0.4)),
        {1, -1, 2, -2, 3},
    ),
    "whip, up": (WHIP, WHIPS, ramp(WHIP, 1.0, 0.025), {2, -2}),
    "whip that loses its grip where the rate jumps": (
        WHIP, WHIPS, piecewise(WHIP, (0.0, 0.63), (2.1, 0.667), (2.6, 0.9), (8.0, 0.8)), {2, -2},
    ),
    "all of it, up": (
        replace(ALL, contact_exponent=1.5), START,
        ramp(replace(ALL, contact_exponent=1.5), 2.6, 0.05), {1, -1, 3, 4, -4},
    ),
    "limited power": (SHAFT, START, powered(SHAFT, (3.0, 0.5), 10.0, 25.0), {1, -1}),
    "limited power, whip": (WHIP, WHIPS, powered(WHIP, (100.0, 20.0), 2000.0, 20.0), {2, -2}),
    "limited power, a small disc": (
        CHATTERS, START, powered(CHATTERS, (8.0, 1.0), 30.0, 20.0), {1, -1, 3},
    ),
    "limited power, all of it": (
        ALL, START, powered(ALL, (4.0, 1.0), 5.0, 12.0), {1, -1, 3, 4, -4},
    ),
}  # fmt: skip


def end_of(run):
    return [run[name].values[-1] for name in ("x", "y", "vx", "vy", "angle", "speed")]


BY = {"taylor": {"method": "taylor"}, "adams": {}, "reference": {"backend": "python"}}


@pytest.fixture(scope="module", params=RUNS)
def witnessed(request):
    """A run, and what Newton's and Euler's equations of the disc as a rigid body make of it."""
    rotor, start, (_, pieces), _ = RUNS[request.param]
    return RUNS[request.param], followed(pieces, start, rotor.omega)


@pytest.mark.parametrize("by", BY)
def test_events_are_those_of_another_integrator(witnessed, by):
    """SciPy's DOP853, restarted at every event."""
    (rotor, start, (given, _), kinds), witness = witnessed
    found = run_up(rotor, start=start, samples=2, rtol=1e-11, atol=1e-13, **BY[by], **given)
    times, told, speeds = map(np.array, zip(*witness.events, strict=True))
    assert set(told.tolist()) == kinds
    assert found.event_kind.values.tolist() == told.tolist()
    apart = np.abs(found.event_time.values - times)
    assert apart.max() < 1e-9
    # the witness's own error is below 1e-11
    assert (apart <= found.event_time_error.values + 1e-11).all()
    assert found.event_time_error.values.max() < 1e-8
    np.testing.assert_allclose(found.event_speed, speeds, rtol=0, atol=1e-9)
    np.testing.assert_allclose(end_of(found), witness.end, rtol=0, atol=1e-8)


def test_the_grip_is_lost_at_the_very_moment_at_which_the_rate_jumps():
    """F jumps by the jump of the rate times rho - cos(theta - phi)."""
    _, _, (given, _), _ = RUNS["whip that loses its grip where the rate jumps"]
    found = run_up(WHIP, start=WHIPS, samples=2, **given)
    slips = found.event_time.values[found.event_kind.values == -2]
    assert np.abs(slips - 2.1).min() < 1e-14


@pytest.mark.parametrize("method", ["bdf", "ida"])
def test_other_solvers_agree_within_their_errors(method):
    given = {"start": START, "torque": (3.0, 0.5), "inertia": 10.0, "duration": 15.0, "samples": 2}
    one, other = (run_up(SHAFT, method=each, rtol=1e-8, **given) for each in ("adams", method))
    rotor_ida.testing.assert_events_close(other, one)
    assert one.event_kind.values.tolist() == [1, -1, 1]


def passed(rate):
    """Largest |z| times the root of the rate, and the excess of the speed there over that root."""
    root = np.sqrt(rate)
    begin = 1.0 - 12.0 * root if root < 0.05 else 0.4
    rotor = Rotor(omega=begin, zeta=0.0, delta0=1e3, shaft_stiffness=1.0)
    whirl = begin**2 / (1.0 - begin**2)
    found = run_up(
        rotor, start=(whirl, 0.0, 0.0, begin * whirl), to=1.0 + 4.0 * root, rate=rate,
        samples=4001, rtol=1e-7,
    )  # fmt: skip
    radius = np.hypot(found.x.values, found.y.values)
    # the envelope: ripples at twice the speed are of the order of 1
    top = int(np.argmax(radius))
    near = slice(max(top - 60, 0), top + 61)
    curve = np.polynomial.Polynomial.fit(found.speed.values[near], radius[near], 4)
    peaks = [each.real for each in curve.deriv().roots() if abs(each.imag) < 1e-12]
    place = min(peaks, key=lambda each: abs(each - found.speed.values[top]))
    return radius[top] * root, (place - 1.0) / root


def test_without_damping_a_slow_run_up_passes_resonance_as_lewis_says():
    """Largest |z| 1.46720/sqrt(a) at a speed of 1 + 2.15742 sqrt(a), as the rate a falls."""
    rates = np.array([4e-3, 1e-3, 2.5e-4])
    heights, excesses = np.array([passed(rate) for rate in rates]).T
    # what is left falls as the root of the rate
    left = (heights - 1.46720) / np.sqrt(rates)
    assert np.ptp(left) < 0.02 * left.mean()
    assert 2.0 * heights[2] - heights[1] == pytest.approx(1.46720, abs=1e-4)
    assert np.abs(excesses - 2.15742).max() < 5e-4


@pytest.mark.parametrize("mu", [0.0, 0.1])
def test_a_settled_speed_lies_on_sommerfelds_curve(mu):
    """tau0 - slope omega = 2 zeta omega A**2 + mu f(A) (A + rho), A that of the exact whirl."""
    rotor = Rotor(
        omega=1.0, zeta=0.3, delta0=0.5, shaft_stiffness=0.2, friction=mu, disc_radius=2.0
    )
    found = run_up(
        rotor, start=(1.0, 0.0, 0.0, 1.0), torque=(4.0, 2.0), inertia=3.0, duration=200.0,
        samples=2, rtol=1e-11, atol=1e-13,
    )  # fmt: skip
    omega, radius = found.speed.values[-1], np.hypot(found.x.values[-1], found.y.values[-1])
    whirls = synchronous_response(
        omega=omega, zeta=0.3, delta0=0.5, shaft_stiffness=0.2, friction=mu
    )
    amplitude = whirls.amplitude.values.ravel()
    amplitude = amplitude[np.nanargmin(np.abs(amplitude - radius))]
    assert radius == pytest.approx(amplitude, abs=1e-9)
    asked = 2.0 * 0.3 * omega * amplitude**2 + mu * (amplitude - 0.5) ** 1.5 * (amplitude + 2.0)
    assert 4.0 - 2.0 * omega == pytest.approx(asked, abs=1e-8)
    assert asked > 0.1


def test_a_rate_that_falls_to_zero_leads_to_the_run_at_one_speed():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    steady = simulate(rotor, start=REST, duration=12.0, samples=2, method="taylor", rtol=1e-13)
    off = []
    for rate in (1e-4, 1e-5, 1e-6):
        found = run_up(rotor, start=REST, to=2.0 + 12.0 * rate, rate=rate, samples=2, rtol=1e-12)
        assert found.event_kind.equals(steady.event_kind)
        off.append(np.abs(found.event_time.values - steady.event_time.values).max())
    assert off[0] / off[1] == pytest.approx(10.0, rel=0.01)
    assert off[1] / off[2] == pytest.approx(10.0, rel=0.01)


def energy(rotor, run, inertia):
    """Of the centre of mass and the spin, of shaft and ring, and of the load."""
    centre = run.x.values + 1j * run.y.values
    moving = run.vx.values + 1j * run.vy.values
    angle, speed = run.angle.values, run.speed.values
    moving = moving + 1j * speed * np.exp(1j * angle)
    depth, n = np.maximum(np.abs(centre) - rotor.delta0, 0.0), rotor.contact_exponent
    return (
        0.5 * np.abs(moving) ** 2 + 0.5 * inertia * speed**2
        + 0.5 * rotor.shaft_stiffness * np.abs(centre) ** 2 + depth ** (n + 1) / (n + 1)
        + rotor.load * (centre + np.exp(1j * angle)).imag
    )  # fmt: skip


@pytest.mark.parametrize("name", [name for name in RUNS if "limited" in name])
def test_the_work_of_the_torque_goes_into_energy_damping_and_heat(name):
    rotor, start, (given, _), _ = RUNS[name]
    found = run_up(rotor, start=start, samples=8001, **given)
    (tau0, slope), times, speed = given["torque"], found.t.values, found.speed.values
    work = tau0 * found.angle.values[-1] - slope * simpson(speed**2, x=times)
    damped = 2.0 * rotor.zeta * simpson(found.vx.values**2 + found.vy.values**2, x=times)
    lost = sum(found[each].values.sum() for each in ("contact_loss", "heat") if each in found)
    energies = energy(rotor, found, given["inertia"])
    assert energies[-1] - energies[0] == pytest.approx(work - damped - lost, abs=1e-6)
    assert damped + lost > 1.0


def test_a_run_whose_energy_does_not_balance_is_refused(monkeypatch):
    caught = []
    monkeypatch.setattr(run_module, "check_orbit", caught.append)
    run_up(WHIP, start=WHIPS, to=0.7, rate=0.01, samples=20, backend="python")
    orbit = caught[0]
    check_orbit(orbit)
    begun, ended, gained = orbit.speed_record.energies
    off = replace(orbit.speed_record, energies=(begun, ended + 1e-4, gained))
    with pytest.raises(InvariantError, match="the energy does not balance"):
        check_orbit(replace(orbit, speed_record=off))
    faster = orbit.speed_record.samples.copy()
    faster["speed"] *= 1.1
    with pytest.raises(InvariantError, match="disc slips, or lacks grip, where it should roll"):
        check_orbit(replace(orbit, speed_record=replace(orbit.speed_record, samples=faster)))


def test_a_start_on_the_ring_knows_of_the_angular_acceleration():
    """From rest the unbalance is drawn by -i theta'': downwards."""
    rotor = Rotor(omega=0.0, zeta=0.1, delta0=1.0)
    how = {"torque": (0.5, 0.0), "inertia": 2.0, "duration": 0.1, "samples": 2}
    for given in (how, {"to": 0.01, "rate": 0.1, "samples": 2}):
        for y, in_contact in ((1.0, 0), (-1.0, 1)):
            found = run_up(rotor, start=(0.0, y, 0.0, 0.0), **given)
            assert found.starts_in_contact == in_contact


def on_the_ring_at_radial_rest(rotor, rate, turn, sense):
    """A start at this angle, so fast along the ring that nothing draws it off at first."""
    radius, direction = rotor.delta0, np.exp(1j * turn)
    outwards = (complex(rotor.omega**2, -rate) / direction).real - rotor.shaft_stiffness * radius
    z, v = radius * direction, sense * 1j * np.sqrt(-outwards * radius) * direction
    return z.real, z.imag, v.real, v.imag


@pytest.mark.parametrize("turn", [2.0, 2.8, -2.8])
@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("rate", [0.3, -0.2])
@pytest.mark.parametrize("kappa", [0.0, 0.3])
def test_where_velocity_and_acceleration_vanish_the_jerk_decides(turn, sense, rate, kappa):
    """Which error functions tell; and where the ring is met again after a fall by t**3."""
    rotor = Rotor(omega=1.1, zeta=0.07, delta0=0.5, shaft_stiffness=kappa)
    start = on_the_ring_at_radial_rest(rotor, rate, turn, sense)

    def above(time):
        x, y, _, _ = ramp_flight(time, rotor=rotor, start=start, rate=rate)
        return float(np.hypot(x, y)) - rotor.delta0

    for how in ({"method": "taylor"}, {"method": "adams"}, {"backend": "python"}):
        run = run_up(rotor, start=start, to=1.1 + 0.2 * rate, rate=rate, samples=2, **how)
        assert run.starts_in_contact == (above(1e-3) > 0.0)
        if above(1e-3) < 0.0 < above(0.2):
            touch = brentq(above, 1e-3, 0.2, xtol=1e-14)
            stated = run.event_time_error.item()
            assert stated < 1e-7  # a slow crossing: the reference states the most, 4e-8
            assert run.event_time.values == pytest.approx([touch], abs=stated)


def test_beyond_a_ramp_the_last_speed_is_held():
    found = run_up(PAPER, start=REST, to=1.0, rate=0.25, duration=4.0, samples=5)
    assert found.speed.values.tolist() == [0.5, 0.75, 1.0, 1.0, 1.0]
    assert found.angle.values == pytest.approx([0.0, 0.625, 1.5, 2.5, 3.5])
    assert found.revolutions.item() == pytest.approx(3.5 / (2.0 * np.pi))


def test_the_first_speed_of_several_counts_and_not_the_rotors():
    found = run_up(PAPER, start=REST, speeds=[(0.0, 1.0), (2.0, 1.5)], samples=3)
    assert found.omega == 1.0
    assert found.speed.values.tolist() == [1.0, 1.25, 1.5]
    same = run_up(replace(PAPER, omega=1.0), start=REST, to=1.5, rate=0.25, samples=3)
    assert np.array_equal(found.x, same.x)


@pytest.mark.parametrize(
    "name", ["friction, piece by piece", "whip, up", "limited power, all of it"]
)
def test_a_run_up_is_kept_and_verified(name, tmp_path):
    rotor, start, (given, _), _ = RUNS[name]
    run = run_up(rotor, start=start, samples=11, rtol=1e-8, **given)
    kept = rotor_ida.load(rotor_ida.save(run, tmp_path / "run.nc"))
    for each in run.variables:
        assert kept[each].equals(run[each]), each
    assert differences(rerun(kept), kept)["agrees"]
    assert differences(rerun(kept, method="bdf"), kept)["agrees"]


def test_what_follows_from_a_run_up():
    run = run_up(CHATTERS, start=START, to=2.0, rate=0.1, samples=801)
    turned = rotating(run)
    z = (run.x.values + 1j * run.y.values) * np.exp(-1j * run.angle.values)
    assert turned.rotating_x.values == pytest.approx(z.real)
    events = (run.event_x.values + 1j * run.event_y.values) * np.exp(-1j * run.event_angle.values)
    assert turned.event_rotating_y.values == pytest.approx(events.imag)
    summary = contact_summary(run)
    assert summary.heat_per_revolution * run.revolutions == pytest.approx(run.heat.values.sum())
    slid = np.abs(run.slip_speed.values) * (run.normal_force.values > 0.0)
    assert summary.total_slip_distance == pytest.approx(simpson(slid, x=run.t.values), rel=1e-2)
    with pytest.raises(InputError, match="run must be at one speed for contact forces with fric"):
        contact_forces(run)


RAMP = {"to": 2.0, "rate": 0.1}
POWER = {"torque": (1.0, 0.1), "inertia": 2.0, "duration": 10.0}
MISTAKES = {
    "got to, rate, torque, inertia": RAMP | POWER,
    "the speed must change in one way, .*, got rate, torque": {"rate": 0.1, "torque": (1.0, 0.1)},
    "got to, rate, speeds": RAMP | {"speeds": [(0, 1), (1, 2)]},
    "rate or ramp_time must be given with to, got None": {"to": 2.0},
    "to must be given with rate, got None": {"rate": 2.0},
    "torque must be given with inertia": {"inertia": 1.0, "duration": 1.0},
    "rate must be positive to change the speed from 0.5 to 2.0, got 0.0": RAMP | {"rate": 0.0},
    "to must differ from the rotor's omega 0.5": RAMP | {"to": 0.5},
    "to must be at most 1e\\+06": {"to": 2e6, "rate": 1.0},
    "the size of rate must lie from 1e-12 to": {"to": 2.0, "rate": 1e-30},
    "the time of the ramp must be below": {"to": 2.0, "rate": 1e-12},
    "the duration of a run must be at most 5e\\+06 with backend 'python'": {
        "to": 2.0, "rate": 1e-7, "backend": "python",
    },
    "the duration of a run must be at most 1e\\+07 with backend 'python'": POWER
    | {"duration": 2e7, "backend": "python"},
    "the duration of a run must be at most 1e\\+08 with backend 'compiled'": POWER
    | {"duration": 2e8},
    "inertia must be positive, got -1.0": POWER | {"inertia": -1.0},
    "torque 0 must be|torque must be a finite": POWER | {"torque": (1.0, np.nan)},
    "times of speeds must increase, got 1.0 after 1.0": {"speeds": [(0, 1), (1, 2), (1, 3)]},
    "speeds must be two or more pairs of time and speed": {"speeds": [(0, 1)]},
    "backend must be 'auto' or 'compiled' with taylor, got 'python'": RAMP
    | {"method": "taylor", "backend": "python"},
    "rtol must lie from 1e-15 to 0.0001": RAMP | {"method": "taylor", "rtol": 1e-3},
    "method must be one of": RAMP | {"method": "euler"},
    "samples must lie from 0 to the duration 15.0, got 20.0": RAMP | {"samples": [0.0, 20.0]},
}  # fmt: skip


@pytest.mark.parametrize("message", MISTAKES)
def test_mistakes_are_refused_in_one_line(message):
    with pytest.raises(InputError, match=message):
        run_up(PAPER, start=REST, **MISTAKES[message])


def test_a_run_at_one_speed_that_would_not_end_is_refused():
    with pytest.raises(InputError, match="the duration of a run must be at most 5e\\+07 with"):
        simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), duration=1e9)


def test_a_torque_that_never_turns_the_rotor_is_refused():
    resting = replace(PAPER, omega=0.0)
    for tau0 in (0.0, -1.0):
        with pytest.raises(InputError, match="tau0 of torque must be positive to turn a rotor"):
            run_up(resting, start=REST, **POWER | {"torque": (tau0, 0.1)})


@pytest.mark.parametrize(("delta0", "load"), [(1.0, 0.3), (0.1, 7.0), (8.0, 0.02)])
def test_a_disc_that_falls_freely_touches_when_it_has_fallen_by_the_clearance(delta0, load):
    """Its flight is a polynomial, whose step nothing limits."""
    touch = np.sqrt(2.0 * delta0 / load)
    run = run_up(Rotor(omega=0.0, zeta=0.0, delta0=delta0, load=load), start=(0, 0, 0, 0),
                 speeds=[(0.0, 0.0), (2.0 * touch, 0.0)])  # fmt: skip
    assert run.entry_time.values[0] == pytest.approx(touch, rel=1e-13)
    assert run.entry_speed.values[0] == pytest.approx(load * touch, rel=1e-13)
