"""Friction: a contact in which surfaces slide, reverse, and in which the disc rolls on the ring."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rotor_ida import Rotor, simulate
from rotor_ida.errors import InvariantError
from rotor_ida.model import modes
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import check_orbit
from rotor_ida.simulation.run import run
from tests.witness import rub_hold, rub_slip, rubbed

START = (0.3, 0.1, 0.2, 0.1)
WHIP = Rotor(omega=0.62962981, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
ALL = Rotor(
    omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.2, contact_exponent=1.0,
    contact_damping=2.0, load=1.5, friction=0.4, disc_radius=0.5,
)  # fmt: skip
# Rotor, start, duration, and the kinds of event that each shows.
MACHINES = {
    "rub that slides forwards": (
        Rotor(omega=2.0, zeta=0.07, delta0=2.0, friction=0.1, disc_radius=10.0),
        START, 30.0, {1, -1},
    ),
    "dry whip": (WHIP, (5.0, 0.0, 0.0, -6.3), 40.0, {2, -2}),
    "small disc, that chatters": (
        Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.3, disc_radius=0.6),
        START, 30.0, {1, -1, 2, -2, 3},
    ),
    "disc of no radius": (
        Rotor(omega=1.2, zeta=0.02, delta0=0.5, friction=0.2, disc_radius=0.0),
        (0.8, 0.1, 0.2, -0.5), 30.0, {1, -1, 2, -2, 3},
    ),
    "free vibration under a load": (
        Rotor(omega=0.0, zeta=0.05, delta0=1.0, load=0.5, friction=0.3, disc_radius=5.0),
        (-1.2, -0.4, 0.3, -0.8), 30.0, {1, -1, 2, -2},
    ),
    "slow, under a load": (
        Rotor(omega=0.2, zeta=0.02, delta0=1.0, load=0.5, friction=0.2, disc_radius=3.0),
        (-0.2, -0.4, 0.3, -0.8), 60.0, {1, -1, 2, -2},
    ),
    "shaft and linear contact": (
        Rotor(omega=0.9, zeta=0.05, delta0=1.0, shaft_stiffness=0.3, contact_exponent=1.0,
              friction=0.4, disc_radius=1.5),
        (0.3, 0.1, 1.2, -0.8), 30.0, {1, -1, 2, -2, 3},
    ),
    "contact damping": (
        Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_damping=3.0, friction=0.3,
              disc_radius=1.0),
        START, 20.0, {1, -1, -4},
    ),
    "all of it": (ALL, START, 20.0, {1, -1, 3, 4, -4}),
    "rough ring": (
        Rotor(omega=0.5, zeta=0.1, delta0=1.0, friction=2.0, disc_radius=4.0),
        START, 20.0, {1, 2},
    ),
    "start that rolls": (
        Rotor(omega=0.5, zeta=0.05, delta0=1.0, friction=0.5, disc_radius=4.0),
        (1.8, 0.0, 0.1, -2.0), 20.0, {2, -2},
    ),
    "start that is loose": (
        Rotor(omega=0.5, zeta=0.05, delta0=1.0, contact_damping=2.0, load=0.4, friction=0.5,
              disc_radius=2.0),
        (0.0, -1.4, 0.2, 0.8), 20.0, {1, -1, 2, -2, 4, -4},
    ),
}  # fmt: skip
WAYS = {
    "taylor": {"method": "taylor", "rtol": 1e-13, "atol": 1e-15},
    "adams": {"method": "adams", "rtol": 1e-13, "atol": 1e-15},
    "bdf, flight integrated": {"method": "bdf", "rtol": 1e-12, "flight": "cvode"},
    "reference": {"backend": "python", "rtol": 1e-12, "atol": 1e-14},
}


@pytest.fixture(scope="module", params=MACHINES)
def machine(request):
    rotor, start, duration, kinds = MACHINES[request.param]
    events, end = rubbed(rotor, start, duration)
    assert {kind for _, kind in events} == kinds
    return rotor, start, duration, events, end


@pytest.mark.parametrize("way", WAYS)
def test_events_are_those_of_another_integrator(machine, way):
    """SciPy's DOP853, restarted at each event; it rolls in polar coordinates."""
    rotor, start, duration, events, end = machine
    found = simulate(rotor, start=start, duration=duration, samples=2, **WAYS[way])
    assert found.event_kind.values.tolist() == [kind for _, kind in events]
    apart = np.abs(found.event_time.values - [time for time, _ in events])
    assert apart.max() < 1e-9
    # the witness's own error is below 1e-11
    assert (apart <= found.event_time_error.values + 1e-11).all()
    assert found.event_time_error.values.max() < 1e-8
    last = [found[name].values[-1] for name in ("x", "y", "vx", "vy")]
    np.testing.assert_allclose(last, end, rtol=0, atol=2e-9)


def test_the_whip_rolls_as_often_as_was_derived():
    """DESIGN section 3: 38 rolls in 120 time units."""
    found = simulate(WHIP, start=(5.0, 0.0, 0.0, -6.3), duration=120.0, method="taylor")
    assert (found.event_kind.values == 2).sum() == 38


def steady(rim, **more):
    """A machine of DESIGN section 3 without unbalance, as `equations` can be asked for it."""
    return SimpleNamespace(
        omega=0.0, zeta=0.1, delta0=1.0, shaft_stiffness=0.0, contact_damping=0.0, load=0.0,
        hertz=1.0, linear=0.0, pressed=1.0, friction=0.2, rim=rim, **more,
    )  # fmt: skip


def test_without_unbalance_whip_and_saddle_are_where_they_were_derived():
    """zeta 0.1, mu 0.2, delta0 1, rho 10: a slipping whirl at -1 with r 3.147899036, born as
    rolling whip at omega 0.314789904; at twice that the whip has r 4.984177749."""
    slipping, born, whip = 3.147899036, 0.314789904, 4.984177749
    saddle = steady(10.0 * born + 0.5, sigma=1.0)
    slip = slipping * (saddle.rim - slipping)
    state = [np.sqrt(slipping - 1.0), 0.0, slip, 1.0, 0.0, 0.0, 0.0]
    rates = modes.rub_rates(state, saddle)
    assert np.abs(rates[1:3]).max() < 1e-7
    for radius, rim in ((slipping, 10.0 * born), (whip, 20.0 * born)):
        state = [np.sqrt(radius - 1.0), 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
        assert abs(modes.rolling_rates(state, steady(rim, sigma=0.0))[1]) < 1e-7
        grip, hold = modes.grip_and_hold(state, steady(rim, sigma=0.0))
        assert abs(hold) <= grip + 1e-8
        assert (abs(abs(hold) - grip) < 1e-8) == (radius == slipping)


def smoothed(rotor, start, duration, width):
    """Friction in proportion to tanh(v_s/width)."""
    rim = rotor.disc_radius * rotor.omega

    def rates(time, state):
        z, v = complex(*state[:2]), complex(*state[2:])
        radius = abs(z)
        slip = (z.conjugate() * v).imag / radius + rim
        normal = max(radius - rotor.delta0, 0.0) ** 1.5
        push = normal * (1.0 + 1j * rotor.friction * np.tanh(slip / width)) * z / radius
        a = rotor.omega**2 * np.exp(1j * rotor.omega * time) - 2.0 * rotor.zeta * v - push
        return [v.real, v.imag, a.real, a.imag]

    found = solve_ivp(rates, (0.0, duration), start, method="LSODA", rtol=1e-10, atol=1e-11)
    return found.y[:, -1]


def test_smoothed_friction_comes_nearer_in_proportion_to_its_width():
    """The third witness: with tanh(v_s/eps) for sign(v_s), eps from 1e-2 to 1e-4, the difference
    falls with an order of 0.85 to 1.05, through five rolls and as many slips."""
    start, duration = (5.0, 0.0, 0.0, -6.3), 16.0
    exact = simulate(WHIP, start=start, duration=duration, samples=2, method="taylor")
    assert (exact.event_kind.values == 2).sum() >= 5
    end = np.array([exact[name].values[-1] for name in ("x", "y", "vx", "vy")])
    widths = np.array([1e-2, 1e-3, 1e-4])
    apart = [np.linalg.norm(smoothed(WHIP, start, duration, each) - end) for each in widths]
    orders = np.diff(np.log(apart)) / np.diff(np.log(widths))
    assert (orders > 0.85).all()
    assert (orders < 1.05).all()


# ---- Grazes ----


def kinds_of(rotor, start, duration, rtol, method="taylor"):
    how = Options(method=method, rtol=rtol, atol=1e-2 * rtol)
    return run(rotor, start, duration, np.array([0.0, duration]), how).event_kinds.tolist()


def border(family, low, high, start, duration):
    """Two parameters a rounding apart between which the events change, and those of each."""
    few = kinds_of(family(low), start, duration, 1e-14)
    more = kinds_of(family(high), start, duration, 1e-14)
    while more != few and high - low > 1e-13 * high:
        middle = 0.5 * (low + high)
        found = kinds_of(family(middle), start, duration, 1e-14)
        low, high, more = (middle, high, more) if found == few else (low, middle, found)
    return low, high, few, more


def start_that_rolls(rotor, draw):
    """A random start on which the disc rolls, if its grip is enough."""
    outwards = np.exp(1j * draw.uniform(0.0, 2.0 * np.pi))
    z = draw.uniform(1.2, 2.5) * outwards
    v = complex(draw.uniform(-1.0, 1.0), -rotor.disc_radius * rotor.omega) * outwards
    return z.real, z.imag, v.real, v.imag


def graze(draw, kind):
    """A family of random machines, by their friction, and the two ends of a border across which a
    pair of events comes: from sliding a roll and a slip, from rolling a slip and a roll."""
    while True:
        rotor = Rotor(
            omega=draw.uniform(0.3, 2.0), zeta=0.07, delta0=1.0, friction=0.1,
            disc_radius=draw.uniform(0.0, 4.0), load=draw.choice([0.0, draw.uniform(0.0, 1.0)]),
        )  # fmt: skip
        start, (sign, offset) = start_that_rolls(rotor, draw), (-1.0, 1.5)
        if kind == 2:
            start, (sign, offset) = tuple(draw.uniform(-1.5, 1.5, 4).tolist()), (1.0, 0.0)

        def family(value, rotor=rotor, sign=sign, offset=offset):
            return replace(rotor, friction=offset + sign * value)

        low, high = draw.uniform(0.05, 0.5), draw.uniform(0.5, 1.4)
        low, high, few, more = border(family, low, high, start, 5.0)
        if sorted(more) == sorted([*few, -2, 2]):
            place = next(i for i, (a, b) in enumerate(zip([*few, 0], more, strict=False)) if a != b)
            if more[place] == kind:
                return family, start, low, high


@pytest.mark.parametrize("kind", [2, -2])
@pytest.mark.parametrize(("method", "floor"), [("taylor", 10.0), ("adams", 100.0), ("bdf", 1e3)])
def test_grazes_of_slip_speed_and_grip_are_decided_above_the_floor_that_is_stated(
    method, floor, kind
):
    """Where friction is by so many rtol more or less than what has the slip speed just reach 0
    (2), or the force that rolling needs just reach mu N (-2)."""
    draw, rtol = np.random.default_rng(11), 1e-9
    for _ in range(6):
        family, start, low, high = graze(draw, kind)
        for value in (low * (1.0 - floor * rtol), high * (1.0 + floor * rtol)):
            exact = kinds_of(family(value), start, 5.0, 1e-14)
            assert kinds_of(family(value), start, 5.0, rtol, method) == exact, family(value)


@pytest.mark.parametrize("kind", [2, -2])
def test_a_pair_of_events_comes_with_the_root_of_the_distance_from_its_border(kind):
    """A guard that is touched is a parabola there: so its two zeros part. A million times nearer
    to the border they lie a thousand times closer together, and neither is missed."""
    draw = np.random.default_rng(3)
    distances = 10.0 ** np.arange(-11.0, -4.0)
    for _ in range(4):
        family, start, low, high = graze(draw, kind)
        few, apart = kinds_of(family(low * (1.0 - 1e-6)), start, 5.0, 1e-15), []
        for distance in distances:
            assert kinds_of(family(low * (1.0 - distance)), start, 5.0, 1e-15) == few
            how = Options(method="taylor", rtol=1e-15, atol=1e-17)
            found = run(family(high * (1.0 + distance)), start, 5.0, np.array([0.0, 5.0]), how)
            assert found.event_times.size == len(few) + 2
            apart.append(np.diff(found.event_times).min())
        slope = np.polyfit(np.log(distances[:5]), np.log(apart[:5]), 1)[0]
        assert slope == pytest.approx(0.5, abs=0.01)


# ---- Starts ----


@pytest.mark.parametrize("way", ["taylor", "adams", "reference"])
def test_a_start_without_slip_rolls_or_slides_as_its_grip_is_enough_or_not(way):
    """At (1.8, 0) F is V 2 zeta and mu N 0.5 0.8**1.5: so it rolls. With less grip it slides the
    way that F points."""
    rotor = Rotor(omega=0.5, zeta=0.05, delta0=1.0, friction=0.5, disc_radius=4.0)
    start = (1.8, 0.0, 0.1, -2.0)
    for friction, mode in ((0.5, 2), (0.1, 1)):
        machine = replace(rotor, friction=friction)
        found = simulate(machine, start=start, duration=1.0, samples=101, **WAYS[way])
        assert found.mode.values[0] == mode
        assert found.starts_in_contact == 1
    held = rub_hold(0.0, start, rotor)
    assert 0.1 * 0.8**1.5 < held < 0.5 * 0.8**1.5


@pytest.mark.parametrize("way", ["taylor", "adams", "reference"])
def test_a_disc_that_falls_without_slip_rolls_from_its_entry(way):
    """Nothing turns and nothing drives across: F is 0 but for rounding, so nothing ever slides."""
    for load in (0.0, 0.3):
        rotor = Rotor(omega=0.0, zeta=0.0, delta0=1.0, load=load, friction=0.2, disc_radius=3.0)
        found = simulate(rotor, start=(0.0, 0.2, 0.0, -0.7), duration=12.0, **WAYS[way])
        assert set(found.event_kind.values.tolist()) == {1, -1}
        assert set(found.mode.values.tolist()) == {0, 2}
        assert np.abs(found.x.values).max() < 1e-12
        assert found.heat.values.max() < 1e-15


@pytest.mark.parametrize("way", ["taylor", "reference"])
def test_a_block_on_the_ring_slides_to_rest_where_friction_holds_it(way):
    """omega = 0 under a load: it rests off the lowest point, tilted by less than atan(mu)."""
    rotor = Rotor(omega=0.0, zeta=0.3, delta0=1.0, load=0.5, friction=0.6, disc_radius=2.0)
    found = simulate(rotor, start=(0.35, -1.5, 0.4, 0.0), duration=200.0, **WAYS[way])
    assert found.mode.values[-1] == 2
    x, y, vx, vy = (found[name].values[-1] for name in ("x", "y", "vx", "vy"))
    assert abs(vx) + abs(vy) < 1e-9
    tilt = np.arctan2(x, -y)
    assert 0.01 < abs(tilt) < np.arctan(0.6)
    normal = 0.5 * np.cos(tilt)
    assert np.hypot(x, y) == pytest.approx(1.0 + normal ** (2.0 / 3.0), abs=1e-9)


# ---- What a run says of it ----


def test_samples_say_how_it_moves_how_fast_it_slides_and_how_hard_it_is_pressed():
    found = simulate(ALL, start=START, duration=20.0, samples=2001, method="taylor")
    t, mode = found.t.values, found.mode.values
    assert found.mode.attrs["flag_meanings"].split() == [
        "flight", "slipping_forward", "slipping_backward", "rolling", "loose",
    ]  # fmt: skip
    states = np.array([found[name].values for name in ("x", "y", "vx", "vy")]).T
    slip = np.array([rub_slip(state, ALL) for state in states])
    np.testing.assert_allclose(found.slip_speed.values[1:], slip[1:], rtol=0, atol=1e-12)
    radius = np.hypot(*states.T[:2])
    in_contact = radius > ALL.delta0
    assert ((mode != 0) == in_contact)[np.abs(radius - ALL.delta0) > 1e-9].all()
    rise = (states[:, 0] * states[:, 2] + states[:, 1] * states[:, 3]) / np.maximum(radius, 1e-9)
    force = np.maximum((radius - ALL.delta0) * (1.0 + ALL.contact_damping * rise), 0.0)
    expected = np.where(in_contact, force, 0.0)
    np.testing.assert_allclose(found.normal_force.values, expected, rtol=0, atol=1e-9)
    sliding = np.abs(mode) == 1
    assert (mode * slip)[sliding].min() > -1e-9
    assert {1, -1, 3} <= set(mode.tolist())
    kinds, when = found.event_kind.values, found.event_time.values
    for kind, time in zip(kinds, when, strict=True):
        if kind == 3:
            before, after = (mode[np.searchsorted(t, time) + place] for place in (-1, 0))
            assert before == -after or np.abs(when - time).min() < 0.01


@pytest.mark.parametrize("way", WAYS)
def test_the_heat_is_the_work_of_sliding(way):
    """The integral of mu N |v_s|, summed over closely spaced samples."""
    rotor, start, duration, _ = MACHINES["small disc, that chatters"]
    found = simulate(rotor, start=start, duration=duration, samples=30_001, **WAYS[way])
    power = rotor.friction * found.normal_force.values * np.abs(found.slip_speed.values)
    total = np.trapezoid(power, found.t.values)
    assert float(found.heat.sum()) == pytest.approx(total, rel=1e-6)
    assert (found.heat.values > 0.0).all()


def test_energy_balances_against_drive_damping_and_heat():
    """E = |z'|**2/2 + V changes by unbalance, damping and -T v_t: what is not heat the drive of
    the disc takes, ``T V`` of it, as T acts on a rim that moves at V."""
    rotor, start, duration, _ = MACHINES["small disc, that chatters"]
    found = simulate(rotor, start=start, duration=duration, samples=60_001, method="taylor")
    t, x, y, vx, vy = (found[name].values for name in ("t", "x", "y", "vx", "vy"))
    states = np.array([x, y, vx, vy]).T
    energy = 0.5 * (vx**2 + vy**2) + 0.4 * np.maximum(np.hypot(x, y) - rotor.delta0, 0.0) ** 2.5
    mode = found.mode.values
    hold = np.array([rub_hold(*each, rotor) for each in zip(t, states, strict=True)])
    across = np.where(mode == 2, hold, mode * rotor.friction * found.normal_force.values)
    power = rotor.omega**2 * (np.cos(rotor.omega * t) * vx + np.sin(rotor.omega * t) * vy)
    power += across * rotor.disc_radius * rotor.omega - 2.0 * rotor.zeta * (vx**2 + vy**2)
    work = np.trapezoid(power, t)
    heat = float(found.heat.sum())
    assert heat > 0.1
    # friction jumps as it reverses and as it begins to roll: by so much a sum over samples is out
    jumps = np.abs(np.diff(across)).max() * rotor.disc_radius * rotor.omega * t[1]
    assert energy[-1] - energy[0] == pytest.approx(work - heat, abs=found.event.size * jumps)
    assert found.event.size * jumps < 0.02


def tampered(change):
    """An orbit of a whip, changed."""
    times = np.linspace(0.0, 10.0, 201)
    orbit = run(WHIP, (5.0, 0.0, 0.0, -6.3), 10.0, times, Options(method="taylor"))
    check_orbit(orbit)
    change(orbit)
    return orbit


def test_a_run_that_contradicts_friction_raises():
    """Senses change at events only; while the disc rolls it does not slip, and is held."""

    def turned(orbit):
        orbit.ways[orbit.ways == 1] = -1

    def early(orbit):
        orbit.event_times[2] -= 0.1  # a roll

    def late(orbit):
        orbit.event_times[1] += 0.1  # a slip

    def twice(orbit):
        orbit.event_kinds[1] = 2

    for change, message in (
        (turned, "surfaces slide in another sense"),
        (early, "the disc slips, or cannot be held"),
        (late, "the disc slips, or cannot be held"),
        (twice, "do not alternate"),
    ):
        orbit = tampered(change)
        with pytest.raises(InvariantError, match=message):
            check_orbit(orbit)


def test_a_friction_that_vanishes_changes_nothing():
    """In the limit of little friction a run is that of a machine without, to first order."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    plain, *rubbing = (
        simulate(each, start=START, duration=20.0, samples=2, method="taylor", rtol=1e-13)
        for each in (
            rotor,
            replace(rotor, friction=1e-6, disc_radius=10.0),
            replace(rotor, friction=1e-8, disc_radius=10.0),
        )
    )
    apart = [np.abs(each.event_time.values - plain.event_time.values).max() for each in rubbing]
    assert apart[0] / apart[1] == pytest.approx(100.0, rel=1e-2)


def random_machine(draw):
    """Any of what a machine may have, and always friction; every other starts without slip."""
    rotor = Rotor(
        omega=draw.choice([0.0, draw.uniform(0.0, 0.5), draw.uniform(0.0, 3.0)]),
        zeta=draw.choice([0.0, 0.01, 0.07, 0.3]), delta0=draw.uniform(0.3, 3.0),
        shaft_stiffness=draw.choice([0.0, draw.uniform(0.0, 3.0)]),
        contact_exponent=draw.choice([1.0, 1.5]), load=draw.choice([0.0, draw.uniform(0.0, 2.0)]),
        contact_damping=draw.choice([0.0, draw.uniform(0.0, 0.5), draw.uniform(0.0, 5.0)]),
        friction=draw.uniform(0.0, draw.choice([0.3, 2.0])),
        disc_radius=draw.choice([0.0, draw.uniform(0.0, 5.0), 20.0]),
    )  # fmt: skip
    if draw.random() < 0.5:
        return rotor, draw.uniform(-1.5, 1.5, 4) * rotor.delta0
    outwards = np.exp(1j * draw.uniform(0.0, 2.0 * np.pi))
    z = rotor.delta0 * draw.choice([1.0, draw.uniform(1.0, 2.0)]) * outwards
    v = complex(draw.uniform(-1.0, 1.0), -rotor.disc_radius * rotor.omega) * outwards
    return rotor, (z.real, z.imag, v.real, v.imag)


@pytest.mark.parametrize(("way", "count"), [("adams", 150), ("reference", 5)])
def test_random_machines_have_the_same_events_by_either_way(way, count):
    draw, seen, duration = np.random.default_rng(7), set(), 15.0 if way == "adams" else 6.0
    loose = {"taylor": {"rtol": 1e-12}, "adams": {"rtol": 1e-12}, "reference": {"rtol": 1e-10}}
    for _ in range(count):
        rotor, start = random_machine(draw)
        one, other = (
            simulate(rotor, start=start, duration=duration, samples=51, **WAYS[each] | loose[each])
            for each in ("taylor", way)
        )
        errors = [each.event_time_error.values for each in (one, other)]
        decided = min(int(np.argmin(np.isfinite([*each, np.inf]))) for each in errors)
        kinds = [each.event_kind.values[:decided].tolist() for each in (one, other)]
        assert kinds[0] == kinds[1], (rotor, start)
        apart = np.abs(one.event_time.values[:decided] - other.event_time.values[:decided])
        assert (apart <= errors[0][:decided] + errors[1][:decided]).all(), (rotor, start)
        seen |= set(kinds[0])
    assert seen >= ({1, -1, 2, -2, 3, 4, -4} if way == "adams" else {1, -1, 2})
