"""Machines: a shaft, a linear contact, contact damping with release and press, and a load."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from rotor_ida import InputError, Rotor, simulate
from rotor_ida.core import runs
from rotor_ida.errors import InvariantError
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import check_orbit
from rotor_ida.simulation.run import run

START, DURATION = (0.3, 0.1, 0.2, 0.1), 30.0
# The kinds of event that each shows.
MACHINES = {
    "shaft": (Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.3), {1, -1}),
    "linear contact": (Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_exponent=1.0), {1, -1}),
    "contact damping": (
        Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_damping=3.0),
        {1, 4, -4},
    ),
    "load": (Rotor(omega=2.0, zeta=0.07, delta0=2.0, load=0.5), {1, -1}),
    "all of it": (
        Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.2, contact_exponent=1.0,
              contact_damping=2.0, load=1.5),
        {1, -1, 4, -4},
    ),
    "resonance without damping": (
        Rotor(omega=0.8, zeta=0.0, delta0=3.0, load=0.1, shaft_stiffness=0.64),
        {1, -1},
    ),
}  # fmt: skip
WAYS = {
    "taylor": {"method": "taylor", "rtol": 1e-12},
    "adams": {"method": "adams", "rtol": 1e-12},
    "bdf, flight integrated": {"method": "bdf", "rtol": 1e-11, "flight": "cvode"},
    "reference": {"backend": "python", "rtol": 1e-10},
}


def mode_rates(machine, mode):
    """z'' = omega**2 exp(i omega t) - i gamma - 2 zeta z' - kappa z - N z/|z|, of one mode."""

    def rates(time, state):
        z, v = complex(*state[:2]), complex(*state[2:])
        force = 0.0
        if mode == "pressed":
            depth, approach = abs(z) - machine.delta0, (z.conjugate() * v).real / abs(z)
            force = np.sign(depth) * abs(depth) ** machine.contact_exponent
            force *= 1.0 + machine.contact_damping * approach
        push = machine.omega**2 * np.exp(1j * machine.omega * time) - 1j * machine.load
        a = push - 2.0 * machine.zeta * v - machine.shaft_stiffness * z
        a -= force * z / abs(z) if force else 0.0
        return [v.real, v.imag, a.real, a.imag]

    return rates


def guards_of(machine, mode):
    """What may end a mode: where it passes through 0, in which direction, and which event it is."""

    def gap(_time, state):
        return np.hypot(state[0], state[1]) - machine.delta0

    def hold(_time, state):
        radial = (state[0] * state[2] + state[1] * state[3]) / np.hypot(state[0], state[1])
        return 1.0 + machine.contact_damping * radial

    found = {
        "flight": [(gap, 1.0, 1)],
        "pressed": [(gap, -1.0, -1), (hold, -1.0, -4)],
        "loose": [(gap, -1.0, -1), (hold, 1.0, 4)],
    }[mode]
    for guard, direction, _ in found:
        guard.direction, guard.terminal = direction, True
    return [guard for guard, _, _ in found], [kind for _, _, kind in found]


def witnessed(machine, start, duration):
    """Events by DOP853, begun anew at each."""
    after = {1: "pressed", -1: "flight", -4: "loose", 4: "pressed"}
    time, state, mode, events = 0.0, np.array(start), "flight", []
    while True:
        guards, kinds = guards_of(machine, mode)
        found = solve_ivp(
            mode_rates(machine, mode), (time, duration), state, method="DOP853",
            rtol=1e-13, atol=1e-14, events=guards, max_step=0.05,
        )  # fmt: skip
        if found.status == 0:
            return events
        place = next(i for i, times in enumerate(found.t_events) if times.size)
        time, state = float(found.t_events[place][0]), found.y_events[place][0]
        mode = after[kinds[place]]
        events.append((time, kinds[place]))
        # what it left must not be found again
        nudged = solve_ivp(mode_rates(machine, mode), (time, time + 1e-6), state, method="DOP853",
                           rtol=1e-13, atol=1e-14)  # fmt: skip
        time, state = time + 1e-6, nudged.y[:, -1]


@pytest.fixture(scope="module", params=MACHINES)
def machine(request):
    rotor, kinds = MACHINES[request.param]
    events = witnessed(rotor, START, DURATION)
    assert {kind for _, kind in events} == kinds
    return rotor, events


@pytest.mark.parametrize("way", WAYS)
def test_events_are_those_of_another_integrator(machine, way):
    rotor, events = machine
    found = simulate(rotor, start=START, duration=DURATION, **WAYS[way])
    assert found.event_kind.values.tolist() == [kind for _, kind in events]
    apart = np.abs(found.event_time.values - [time for time, _ in events])
    assert (apart <= found.event_time_error.values + 2e-10).all()
    assert apart.max() < 2e-8


def random_machine(draw):
    """Any of what a machine may have is there, or not."""
    return Rotor(
        omega=draw.uniform(0.0, 3.0), zeta=draw.choice([0.0, 0.01, 0.07, 0.3]),
        delta0=draw.uniform(0.3, 3.0), shaft_stiffness=draw.choice([0.0, draw.uniform(0.0, 3.0)]),
        contact_exponent=draw.choice([1.0, 1.5]), load=draw.choice([0.0, draw.uniform(0.0, 1.0)]),
        contact_damping=draw.choice([0.0, draw.uniform(0.0, 0.5), draw.uniform(0.0, 5.0)]),
    )  # fmt: skip


@pytest.mark.parametrize(("way", "count"), [("adams", 150), ("reference", 20)])
def test_random_machines_have_the_same_events_by_either_way(way, count):
    draw, seen = np.random.default_rng(7), 0
    for _ in range(count):
        rotor = random_machine(draw)
        start = draw.uniform(-1.5, 1.5, 4) * rotor.delta0
        one, other = (
            simulate(rotor, start=start, duration=15.0, samples=2, **WAYS[each])
            for each in ("taylor", way)
        )
        assert one.event_kind.values.tolist() == other.event_kind.values.tolist(), rotor
        allowed = one.event_time_error.values + other.event_time_error.values
        assert (np.abs(one.event_time.values - other.event_time.values) <= allowed).all(), rotor
        seen += one.event.size
    assert seen > 3 * count


def restitution(x):
    """e of ``x (1 + e) = ln((1 + x)/(1 - e x))``, DESIGN section 3."""

    def equation(e):
        return x * (1.0 + e) - np.log1p(x) + np.log1p(-e * x)

    return brentq(equation, 1e-9, min(1.0, 1.0 / x) * (1.0 - 1e-15), xtol=1e-16, rtol=1e-15)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize("x", [0.1, 1.0, 3.0, 10.0])
def test_a_radial_impact_has_the_restitution_and_the_depth_of_the_law(x, exponent):
    speed = 0.7
    damping = x / speed
    rotor = Rotor(
        omega=0.0, zeta=0.0, delta0=1.0, contact_exponent=exponent, contact_damping=damping
    )
    found = simulate(rotor, start=(1.0, 0.0, speed, 0.0), duration=40.0, **WAYS["taylor"])
    leaves = found.event_kind.values.tolist().index(-1)
    e = -found.event_vx.values[leaves] / speed
    assert e == pytest.approx(restitution(x), abs=1e-11)
    deepest = ((exponent + 1.0) * (x - np.log1p(x)) / damping**2) ** (1.0 / (exponent + 1.0))
    assert found.peak_indentation.values[0] == pytest.approx(deepest, rel=1e-12)
    lost = 0.5 * speed**2 * (1.0 - e**2)
    assert found.contact_loss.values[0] == pytest.approx(lost, rel=1e-11)


def test_the_largest_force_is_that_of_the_motion():
    rotor, _ = MACHINES["contact damping"]
    found = simulate(rotor, start=START, duration=5.0, samples=500_001, method="taylor")
    x, y, vx, vy = (found[name].values for name in ("x", "y", "vx", "vy"))
    radius = np.hypot(x, y)
    depth, approach = np.maximum(radius - rotor.delta0, 0.0), (x * vx + y * vy) / radius
    force = np.maximum(depth**1.5 * (1.0 + rotor.contact_damping * approach), 0.0)
    first = found.t.values <= found.exit_time.fillna(5.0).values[0]
    assert found.peak_force.values[0] == pytest.approx(force[first].max(), rel=1e-8)
    assert found.peak_force.values[0] > 1.01 * found.peak_indentation.values[0] ** 1.5


def test_energy_balances_against_unbalance_damping_and_loss():
    """Between the ends of a run: E = |z'|**2/2 + kappa |z|**2/2 + V + gamma y."""
    rotor, _ = MACHINES["all of it"]
    found = simulate(rotor, start=START, duration=DURATION, samples=60_001, method="taylor")
    t, x, y, vx, vy = (found[name].values for name in ("t", "x", "y", "vx", "vy"))
    depth = np.maximum(np.hypot(x, y) - rotor.delta0, 0.0)
    n = rotor.contact_exponent
    energy = 0.5 * (vx**2 + vy**2) + 0.5 * rotor.shaft_stiffness * (x**2 + y**2)
    energy += depth ** (n + 1.0) / (n + 1.0) + rotor.load * y
    power = rotor.omega**2 * (np.cos(rotor.omega * t) * vx + np.sin(rotor.omega * t) * vy)
    power -= 2.0 * rotor.zeta * (vx**2 + vy**2)
    slope = np.gradient(power, t, edge_order=2)
    work = float(CubicHermiteSpline(t, power, slope).integrate(0.0, DURATION))
    lost = float(found.contact_loss.sum())
    assert lost > 1.0
    assert energy[-1] - energy[0] == pytest.approx(work - lost, abs=1e-6)


@pytest.mark.parametrize("way", ["taylor", "adams", "reference"])
def test_a_start_in_which_the_ring_would_pull_is_loose(way):
    """Outwards of -1/c the contact is pressed, below it loose; and at it, what it will become."""
    rotor = Rotor(omega=0.0, zeta=0.1, delta0=1.0, load=0.3, contact_damping=2.0)
    for vy, first in ((0.4, -1), (0.6, 4), (2.0, -1)):
        found = simulate(rotor, start=(0.0, -1.2, 0.0, vy), duration=5.0, **WAYS[way])
        assert found.starts_in_contact == 1
        loose = vy > 0.5
        events = found.event_kind.values.tolist()
        assert events[0] == first
        assert (4 in events[:1]) == (loose and first == 4)
        check = run(
            rotor, (0.0, -1.2, 0.0, vy), 5.0, np.linspace(0.0, 5.0, 11), Options(method="taylor")
        )
        assert check.event_kinds.tolist() == events


def test_at_rest_under_a_load_it_stays():
    rotor = Rotor(omega=0.0, zeta=0.1, delta0=1.0, load=0.3, contact_damping=1.0)
    found = simulate(
        rotor, start=(0.0, -1.0 - 0.3 ** (2.0 / 3.0), 0.0, 0.0), duration=50.0, **WAYS["taylor"]
    )
    assert found.event.size == 0
    assert np.abs(found.y.values - found.y.values[0]).max() < 1e-14
    hanging = Rotor(omega=0.0, zeta=0.1, delta0=1.0, load=0.3, shaft_stiffness=0.6)
    found = simulate(hanging, start=(0.0, -0.5, 0.0, 0.0), duration=50.0, **WAYS["taylor"])
    assert found.starts_in_contact == 0
    assert np.abs(found.y.values + 0.5).max() < 1e-14


@pytest.mark.parametrize(("vy", "contact"), [(0.0, 1), (-0.1, 1), (0.1, 0)])
def test_on_the_ring_a_load_decides_what_speed_does_not(vy, contact):
    rotor = Rotor(omega=0.0, zeta=0.1, delta0=1.0, load=0.3)
    for way in ("taylor", "reference"):
        found = simulate(rotor, start=(0.0, -1.0, 0.0, vy), duration=1.0, **WAYS[way])
        assert found.starts_in_contact == contact


# Of the speed at which a contact comes loose, this much above and below.
@pytest.mark.parametrize("way", ["taylor", "adams"])
def test_a_release_that_is_only_just_reached_is_neither_missed_nor_invented(way):
    """The fastest departure is an extremum of the radial velocity over a contact: with a damping
    just above or below what it is released at, there are two events or none."""
    base = Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_damping=0.4)
    quick = {"duration": 8.0, **WAYS[way]}

    def released(damping):
        machine = Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_damping=damping)
        return int((simulate(machine, start=START, **quick).event_kind.values == -4).sum())

    low, high = base.contact_damping, 3.0
    assert released(low) < released(high)
    few = released(low)
    while high - low > 1e-12 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if released(middle) == few else (low, middle)
    # on either side, however near, it is the same: the border is sharp
    depths = (1e-3, 1e-5, 1e-7, 1e-9) if way == "taylor" else (1e-3, 1e-5, 1e-7)
    for part in depths:
        assert released(low * (1.0 - part)) == few
        assert released(high * (1.0 + part)) > few


def kinds_of(rotor, start, rtol, method="taylor"):
    how = Options(method=method, rtol=rtol, atol=1e-2 * rtol)
    return run(rotor, start, 6.0, np.array([0.0, 6.0]), how).event_kinds.tolist()


def graze_of_release(draw):
    """A random machine whose contact is only just released: two dampings a rounding apart, with the
    events of each, of which the larger has one more release and press."""
    while True:
        rotor = Rotor(
            omega=draw.uniform(0.5, 3.0), zeta=draw.choice([0.0, 0.07]),
            delta0=draw.uniform(0.5, 2.0), shaft_stiffness=draw.choice([0.0, draw.uniform(0, 2)]),
            load=draw.choice([0.0, draw.uniform(0.0, 1.0)]), contact_damping=0.3,
            contact_exponent=draw.choice([1.0, 1.5]),
        )  # fmt: skip
        start = tuple((draw.uniform(-1.5, 1.5, 4) * rotor.delta0).tolist())
        low, high = 0.3, 4.0
        few, more = (
            kinds_of(replace(rotor, contact_damping=each), start, 1e-14) for each in (low, high)
        )
        while more != few and high - low > 1e-13 * high:
            middle = 0.5 * (low + high)
            found = kinds_of(replace(rotor, contact_damping=middle), start, 1e-14)
            low, high, more = (middle, high, more) if found == few else (low, middle, found)
        if sorted(more) == sorted([*few, -4, 4]):
            return rotor, start, low, high


@pytest.mark.parametrize(("method", "floor"), [("taylor", 100.0), ("adams", 100.0), ("bdf", 1e3)])
def test_grazes_of_a_release_are_decided_above_the_floor_that_is_stated(method, floor):
    """docs/events.md: where damping is by so many rtol more than releases it only just, or less."""
    draw, rtol = np.random.default_rng(11), 1e-9
    for _ in range(12):
        rotor, start, low, high = graze_of_release(draw)
        for damping in (low * (1.0 - floor * rtol), high * (1.0 + floor * rtol)):
            machine = replace(rotor, contact_damping=damping)
            exact = kinds_of(machine, start, 1e-14)
            assert kinds_of(machine, start, rtol, method) == exact, machine


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize(("method", "rtol"), [("taylor", 1e-12), ("adams", 1e-9), ("bdf", 1e-6)])
def test_deep_in_the_ring_it_creeps_back_and_energy_balances(exponent, method, rtol):
    """As fast as the contact damping lets it, 1/c, after a delay of 1/(c h**n): next to no energy.

    What it has at the end, 1/(2 c**2), is a hundred-thousandth of what the ring held.
    """
    depth, c = 50.0, 5.0
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=1.0, contact_exponent=exponent, contact_damping=c)
    found = simulate(rotor, start=(1.0 + depth, 0, 0, 0), duration=1.0, samples=2, method=method,
                     rtol=rtol, atol=1e-2 * rtol)  # fmt: skip
    expected = 1.0 + depth - 1.0 / c + 1.0 / (c * c * depth**exponent)
    assert found.x.values[-1] == pytest.approx(expected, abs=1e-8 + rtol)
    assert found.vx.values[-1] == pytest.approx(-1.0 / c, rel=1e-6)


def test_a_run_that_contradicts_itself_raises():
    rotor, _ = MACHINES["all of it"]
    times = np.linspace(0.0, DURATION, 11)
    orbit = run(rotor, START, DURATION, times, Options(method="taylor"))
    check_orbit(orbit)
    kinds = orbit.event_kinds
    place = next(
        i for i, (a, b) in enumerate(itertools.pairwise(kinds.tolist())) if (a, b) == (-4, 4)
    )
    kinds[place + 1] = -4
    with pytest.raises(InvariantError, match="press and release, do not alternate"):
        check_orbit(orbit)


def test_many_releases_in_one_contact_find_room():
    """More of them than a first table holds, after one entry."""
    rotor, _ = MACHINES["contact damping"]
    found = simulate(rotor, start=START, duration=150.0, samples=2, **WAYS["taylor"])
    kinds = found.event_kind.values
    assert (kinds == 1).sum() == 1
    assert (np.abs(kinds) == 4).sum() > runs.FIRST_ROOM
    once = simulate(rotor, start=START, duration=DURATION, samples=2, **WAYS["taylor"])
    assert (found.event_time.values[: once.event.size] == once.event_time.values).all()


def test_what_cannot_be_a_machine_is_refused_in_one_line():
    with pytest.raises(InputError, match=r"contact_exponent must be 1.5 or 1, got 2.0"):
        Rotor(omega=1.0, zeta=0.1, delta0=1.0, contact_exponent=2.0)
    with pytest.raises(InputError, match="contact_damping must be 0 without clearance"):
        Rotor(omega=1.0, zeta=0.1, delta0=0.0, contact_damping=0.1)


@pytest.mark.parametrize("name", ["shaft_stiffness", "contact_damping", "load"])
@pytest.mark.parametrize("value", [1e-310, 1e-13, 1e7, 1e300])
def test_what_is_beyond_all_scales_is_refused_in_one_line(name, value):
    """A shaft of 1e-310 would be followed for ever."""
    machine = Rotor(omega=1.2, zeta=0.07, delta0=0.5, **{name: value})
    with pytest.raises(InputError, match=rf"^{name} must be 0, or from 1e-12 to 1e\+06, to be"):
        simulate(machine, start=START, duration=20.0)
