"""Events of every kind of rotor: by another integrator, by other methods, and at borders."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, simulate
from rotor_ida.core import runs
from rotor_ida.errors import InvariantError
from rotor_ida.simulation.invariants import check_orbit
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run
from tests.rotors import KNOCKED, MOTIONS, WAYS, WHIP
from tests.witness import ROLLS, Disc, flown

LOOSER = {"taylor": {"rtol": 1e-12}, "adams": {"rtol": 1e-12}, "reference": {"rtol": 1e-10}}


@pytest.fixture(scope="module", params=MOTIONS)
def witnessed(request):
    motion = MOTIONS[request.param]
    found = flown(motion.rotor, motion.start, motion.duration)
    assert {kind for _, kind, _ in found.events} == motion.kinds
    return motion, found.events, found.end[:4]


@pytest.mark.parametrize("way", WAYS)
def test_events_are_those_of_another_integrator(witnessed, way):
    """SciPy's DOP853, restarted at each event."""
    motion, events, end = witnessed
    found = simulate(
        motion.rotor, start=motion.start, duration=motion.duration, samples=2, **WAYS[way]
    )
    assert found.event_kind.values.tolist() == [kind for _, kind, _ in events]
    apart = np.abs(found.event_time.values - [time for time, _, _ in events])
    assert apart.max() < 1e-9
    # the witness's own error, which without friction has been left to grow for longer
    of_time, of_end = (1e-11, 2e-9) if motion.rotor.friction else (2e-10, 2e-8)
    assert (apart <= found.event_time_error.values + of_time).all()
    assert found.event_time_error.values.max() < 1e-8
    last = [found[name].values[-1] for name in ("x", "y", "vx", "vy")]
    np.testing.assert_allclose(last, end, rtol=0, atol=of_end)


def test_the_whip_rolls_as_often_as_was_derived():
    """DESIGN section 3: 38 rolls in 120 time units."""
    found = simulate(WHIP, start=KNOCKED, duration=120.0, method="taylor")
    assert (found.event_kind.values == 2).sum() == 38


def random_rotor(draw, *, friction):
    """Any of the parameters; with friction every other starts without slip."""
    rotor = Rotor(
        omega=draw.choice([0.0, draw.uniform(0.0, 0.5), draw.uniform(0.0, 3.0)]),
        zeta=draw.choice([0.0, 0.01, 0.07, 0.3]), delta0=draw.uniform(0.3, 3.0),
        shaft_stiffness=draw.choice([0.0, draw.uniform(0.0, 3.0)]),
        contact_exponent=draw.choice([1.0, 1.5]), load=draw.choice([0.0, draw.uniform(0.0, 2.0)]),
        contact_damping=draw.choice([0.0, draw.uniform(0.0, 0.5), draw.uniform(0.0, 5.0)]),
    )  # fmt: skip
    if friction:
        friction = draw.uniform(0.0, draw.choice([0.3, 2.0]))
        radius = draw.choice([0.0, draw.uniform(0.0, 5.0), 20.0])
        rotor = replace(rotor, friction=friction, disc_radius=radius)
    if not friction or draw.random() < 0.5:
        return rotor, draw.uniform(-1.5, 1.5, 4) * rotor.delta0
    outwards = np.exp(1j * draw.uniform(0.0, 2.0 * np.pi))
    z = rotor.delta0 * draw.choice([1.0, draw.uniform(1.0, 2.0)]) * outwards
    v = complex(draw.uniform(-1.0, 1.0), -rotor.disc_radius * rotor.omega) * outwards
    return rotor, (z.real, z.imag, v.real, v.imag)


@pytest.mark.parametrize("friction", [False, True])
@pytest.mark.parametrize(("way", "count"), [("adams", 40), ("reference", 8)])
def test_random_rotors_have_the_same_events_by_either_way(way, count, friction):
    draw, shown = np.random.default_rng(7), set()
    duration = 6.0 if friction and way == "reference" else 15.0
    for _ in range(count // 4 if friction and way == "reference" else count):
        rotor, start = random_rotor(draw, friction=friction)
        one, other = (
            simulate(rotor, start=start, duration=duration, samples=51, **WAYS[each] | LOOSER[each])
            for each in ("taylor", way)
        )
        errors = [each.event_time_error.values for each in (one, other)]
        decided = min(int(np.argmin(np.isfinite([*each, np.inf]))) for each in errors)
        assert friction or decided == one.event.size == other.event.size, (rotor, start)
        kinds = [each.event_kind.values[:decided].tolist() for each in (one, other)]
        assert kinds[0] == kinds[1], (rotor, start)
        apart = np.abs(one.event_time.values[:decided] - other.event_time.values[:decided])
        assert (apart <= errors[0][:decided] + errors[1][:decided]).all(), (rotor, start)
        shown |= set(kinds[0])
    of_friction = {2} if way == "reference" else {2, -2, 3}
    assert shown >= {1, -1} | (of_friction if friction else set())
    assert way == "reference" or shown >= {4, -4}


# ---- Starts ----


@pytest.mark.parametrize("way", ["taylor", "adams", "reference"])
def test_a_start_in_which_the_ring_would_pull_is_loose(way):
    """Below -1/c the contact is loose, above it not; and at it, what it will become."""
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


@pytest.mark.parametrize(("vy", "contact"), [(0.0, 1), (-0.1, 1), (0.1, 0)])
def test_on_the_ring_a_load_decides_what_speed_does_not(vy, contact):
    rotor = Rotor(omega=0.0, zeta=0.1, delta0=1.0, load=0.3)
    for way in ("taylor", "reference"):
        found = simulate(rotor, start=(0.0, -1.0, 0.0, vy), duration=1.0, **WAYS[way])
        assert found.starts_in_contact == contact


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
    held = Disc(rotor).solved([*start, 0.0, rotor.omega], ROLLS)[3]
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


# ---- Where two events meet, where rounding decides, and on discs of any size ----


def end_and_kinds(rotor, start, rtol=1e-15, method="taylor"):
    how = Options(method=method, rtol=rtol, atol=1e-2 * rtol)
    found = run(rotor, start, 5.0, np.array([0.0, 5.0]), how)
    return found.states[-1], found.event_kinds.tolist()


# Families of machines across a border of two events, and where about it is: a part of the start at
# which the disc only just reverses before it rolls; a damping at which it starts without slip and
# only just rolls; a clearance at which a contact is only just pressed again before its exit. And
# other values that rounding does not tell from the border.
BORDERS = {
    "reverse or roll": (
        lambda part: (
            Rotor(omega=0.2957112503146906, zeta=0.07, delta0=2.1940159615298582, load=0.825354974,
                  shaft_stiffness=0.9048056920846299, contact_exponent=1.0,
                  friction=4.211957042629932, disc_radius=0.0),
            tuple(part * np.array([-2.47490070887, -2.00472906825, 2.36577633762, 3.14895799593])),
        ),
        1.03, 1.05, (),
    ),
    "start that slips or rolls": (
        lambda zeta: (
            Rotor(omega=1.190265091761566, zeta=zeta, delta0=2.362741581081208,
                  shaft_stiffness=0.10058207563494703, contact_damping=1.3218190378527565,
                  friction=0.5965854046461473, disc_radius=2.6002234965453614),
            (3.4514071887420066, 0.486370175554444, 0.12002036421905898, -3.108621229803047),
        ),
        0.0101, 0.0102, (),
    ),
    "pressed before the exit or not": (
        lambda delta0: (
            Rotor(omega=2.0602868608662064, zeta=0.07, delta0=delta0, contact_exponent=1.0,
                  contact_damping=1.0845155992301603, friction=0.5090684402874239,
                  disc_radius=0.0),
            (2.2457944856791667, -1.8844906034284274, -0.6617516627823992, 0.5552889181395576),
        ),
        2.02, 2.03, (2.025507825367227,),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BORDERS)
def test_a_border_of_two_events_is_crossed_without_a_jump(name):
    """Every machine on the way to the border is followed, to the last bit of its parameter; and
    those on either side of it end at the same place, whatever their events are called."""
    family, low, high, others = BORDERS[name]
    few, many = end_and_kinds(*family(low)), end_and_kinds(*family(high))
    assert few[1] != many[1]
    while high - low > np.spacing(high):
        middle = 0.5 * (low + high)
        here = end_and_kinds(*family(middle))
        if here[1] == few[1]:
            low, few = middle, here
        else:
            high, many = middle, here
    np.testing.assert_allclose(few[0], many[0], rtol=0, atol=1e-11)
    for value in others:
        np.testing.assert_allclose(end_and_kinds(*family(value))[0], few[0], rtol=0, atol=1e-11)
    for value in (low, high):
        for method in ("adams", "bdf"):
            for rtol in (1e-7, 1e-9, 1e-11):
                end, _ = end_and_kinds(*family(value), rtol, method)
                np.testing.assert_allclose(end, few[0], rtol=0, atol=1e4 * rtol)


BORDER_WAYS = {
    "taylor": {"method": "taylor", "rtol": 1e-12},
    "adams": {"method": "adams", "rtol": 1e-12},
    "bdf": {"method": "bdf", "rtol": 1e-10, "flight": "cvode"},
    "reference": {"backend": "python", "rtol": 1e-9},
}


@pytest.mark.parametrize(
    ("rotor", "start"),
    [
        (
            Rotor(omega=0.0, zeta=0.01, delta0=2.996766716607485, load=0.714439425559054,
                  shaft_stiffness=0.4320460728901121, contact_exponent=1.0,
                  friction=0.6971417162686429, disc_radius=0.0),
            (4.249863784133986, 2.2903363592801256, -0.472435113507312, -0.25460470566280075),
        ),
        (
            Rotor(omega=0.598572317655957, zeta=0.0, delta0=1.8478159109306003,
                  shaft_stiffness=2.682653654578926, contact_exponent=1.0,
                  friction=0.2758768731509731, disc_radius=0.5),
            (-2.8885052632007686, 1.380360304981205, -0.022298783016615836, 0.34236052149621543),
        ),
    ],
)  # fmt: skip
@pytest.mark.parametrize("way", [("adams", 1e-9), ("bdf", 1e-9), ("python", 1e-10)])
def test_a_slip_speed_smaller_than_the_error_of_a_step_does_not_stop_a_run(rotor, start, way):
    """After a slip it grows like the square of time: its sign may be wrong at first."""
    name, rtol = way
    how = {"backend": name} if name == "python" else {"method": name}
    found = simulate(
        rotor, start=start, duration=4.0, samples=2, rtol=rtol, atol=1e-2 * rtol, **how
    )
    exact = simulate(rotor, start=start, duration=4.0, samples=2, method="taylor", rtol=1e-13)
    assert found.event_kind.values[0] == -2
    assert abs(found.event_time.values[0] - exact.event_time.values[0]) < 1e-8
    assert np.hypot(*(found[each].values[-1] - exact[each].values[-1] for each in "xy")) < 1e-6


@pytest.mark.parametrize("way", BORDER_WAYS)
@pytest.mark.parametrize("friction", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_disc_rests_where_friction_can_just_hold_it(way, friction, side):
    """DESIGN section 3: at omega = 0 tilted by tan beta = mu, with N = gamma/sqrt(1 + mu**2)."""
    tilt = side * np.arctan(friction)
    radius = 1.0 + (0.5 / np.hypot(1.0, friction)) ** (2.0 / 3.0)
    rotor = Rotor(omega=0.0, zeta=0.05, delta0=1.0, load=0.5, friction=friction, disc_radius=1.0)
    start = (radius * np.sin(tilt), -radius * np.cos(tilt), 0.0, 0.0)
    found = simulate(rotor, start=start, duration=20.0, samples=21, **BORDER_WAYS[way])
    assert found.sizes["event"] == 0
    assert (found.mode.values == 2).all()
    assert np.abs(found.x - start[0]).max() < 1e-9
    assert np.abs(found.y - start[1]).max() < 1e-9


@pytest.mark.parametrize(
    ("way", "radius", "error"),
    [("taylor", 1e3, 2e-10), ("taylor", 1e5, 2e-9), ("adams", 1e3, 4e-9), ("adams", 1e5, 2e-7)],
)
def test_a_disc_that_slides_forwards_moves_the_same_whatever_its_radius(way, radius, error):
    """Its radius is in no equation then. Nor may it be in the error: as moment of the slip, of
    which the angular momentum is the small rest."""
    rotor = Rotor(omega=1.3, zeta=0.05, delta0=1.0, friction=0.2, disc_radius=10.0, load=0.2)
    start = (0.3, -0.9, 0.4, 0.3)
    exact = simulate(rotor, start=start, duration=20.0, samples=2, method="taylor", rtol=1e-14)
    assert exact.sizes["event"] == 9
    large = replace(rotor, disc_radius=radius)
    found = simulate(large, start=start, duration=20.0, samples=101, method=way, rtol=1e-10)
    assert (found.slip_speed.where(found.mode != 0, 1.0) > 0.0).all()
    assert np.abs(found.event_time.values - exact.event_time.values).max() < error


def test_a_friction_that_vanishes_changes_nothing():
    """In the limit of little friction a run is that of a machine without, to first order."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    plain, *rubbing = (
        simulate(
            each, start=(0.3, 0.1, 0.2, 0.1), duration=20.0, samples=2, method="taylor", rtol=1e-13
        )
        for each in (
            rotor,
            replace(rotor, friction=1e-6, disc_radius=10.0),
            replace(rotor, friction=1e-8, disc_radius=10.0),
        )
    )
    apart = [np.abs(each.event_time.values - plain.event_time.values).max() for each in rubbing]
    assert apart[0] / apart[1] == pytest.approx(100.0, rel=1e-2)


def test_many_releases_in_one_contact_find_room():
    """More of them than a first table holds, after one entry."""
    motion = MOTIONS["contact damping"]
    rotor, start = motion.rotor, motion.start
    found = simulate(rotor, start=start, duration=150.0, samples=2, **WAYS["taylor"])
    kinds = found.event_kind.values
    assert (kinds == 1).sum() == 1
    assert (np.abs(kinds) == 4).sum() > runs.FIRST_ROOM
    once = simulate(rotor, start=start, duration=motion.duration, samples=2, **WAYS["taylor"])
    assert (found.event_time.values[: once.event.size] == once.event_time.values).all()


# ---- Runs that contradict themselves, and rotors that cannot be followed ----


def tampered(motion, change):
    """An orbit, changed."""
    times = np.linspace(0.0, 10.0, 201)
    orbit = run(motion.rotor, motion.start, 10.0, times, Options(method="taylor"))
    check_orbit(orbit)
    change(orbit)
    return orbit


def test_a_run_that_contradicts_itself_raises():
    """Senses change at events only; while the disc rolls it does not slip, and is held."""

    def backwards(orbit):
        orbit.modes[orbit.modes == 1] = -1

    def early(orbit):
        orbit.event_times[2] -= 0.1  # a roll

    def late(orbit):
        orbit.event_times[1] += 0.1  # a slip

    def rolls_twice(orbit):
        orbit.event_kinds[1] = 2

    def releases_twice(orbit):
        orbit.event_kinds[np.argmax(orbit.event_kinds == 4)] = -4

    for name, change, message in (
        ("dry whip", backwards, "surfaces slide in a sense that contradicts"),
        ("dry whip", early, "the disc slips, or lacks grip"),
        ("dry whip", late, "the disc slips, or lacks grip"),
        ("dry whip", rolls_twice, "do not alternate"),
        ("everything but friction", releases_twice, "press and release, do not alternate"),
    ):
        orbit = tampered(MOTIONS[name], change)
        with pytest.raises(InvariantError, match=message):
            check_orbit(orbit)


@pytest.mark.parametrize("name", ["shaft_stiffness", "contact_damping", "load"])
@pytest.mark.parametrize("value", [1e-310, 1e-13, 1e7, 1e300])
def test_what_is_beyond_all_scales_is_refused_in_one_line(name, value):
    """A shaft of 1e-310 would be followed for ever."""
    machine = Rotor(omega=1.2, zeta=0.07, delta0=0.5, **{name: value})
    with pytest.raises(InputError, match=rf"^{name} must be 0, or from 1e-12 to 1e\+06, to be"):
        simulate(machine, start=(0.3, 0.1, 0.2, 0.1), duration=20.0)
