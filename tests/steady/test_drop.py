"""Drops of rigid rotors against closed forms, and what the core does in long symmetric ones."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import rotor_ida
from rotor_ida import (
    Contact,
    DimensionalRotor,
    InputError,
    Race,
    RotorSystem,
    Stator,
    Support,
    Unbalance,
    drop,
    run_up,
)
from rotor_ida.core import systems as core_systems
from rotor_ida.paper.whip import is_whip
from rotor_ida.schema import MODE

GRAVITY = 9.80665
MASS, TILT, POLAR = 20.0, 0.6, 0.08
LEFT, RIGHT, DISC = -0.25, 0.3, 0.05
SUPPORTS = [Support(node=node, stiffness=2e6, damping=2e3) for node in "ab"]


def rigid(left=LEFT, right=RIGHT, disc=DISC, polar=POLAR):
    """Return a rigid rotor: q = (x, y, tilts), the displacement of a node at z is x + z tilt."""
    gyroscopic = np.zeros((4, 4))
    gyroscopic[2, 3], gyroscopic[3, 2] = polar, -polar
    places = {"a": left, "b": right, "disc": disc}
    nodes = {name: np.array([[1.0, 0.0, z, 0.0], [0.0, 1.0, 0.0, z]]) for name, z in places.items()}
    return RotorSystem(mass=np.diag([MASS, MASS, TILT, TILT]), stiffness=np.zeros((4, 4)),
                       gyroscopic=gyroscopic, nodes=nodes)  # fmt: skip


def bearing(node, *, friction=0.0, damping=1.0, stator=None, race=None, radius=0.03):
    return Contact(node=node, clearance=2e-4, stiffness=2e9, damping=damping, friction=friction,
                   radius=radius, stator=stator, race=race)  # fmt: skip


def soft(node, friction=0.1):
    race = Race(radius=0.03, inertia=2e-4, drag=1e-4)
    stator = Stator(mass=1.5, stiffness=3e7, damping=3e3, race=race)
    return bearing(node, friction=friction, stator=stator)


def test_a_balanced_rotor_falls_freely_on_both_bearings():
    run = drop(rigid(), contacts=[bearing("a"), bearing("b")], speed=1500.0, duration=0.007,
               supports=SUPPORTS)  # fmt: skip
    first = run.isel(event=slice(2))
    np.testing.assert_allclose(first.event_time, math.sqrt(2.0 * 2e-4 / GRAVITY), rtol=1e-10)
    assert sorted(first.event_contact.values) == [0, 1]
    speeds = first.event_state.values[:, 4:8]
    np.testing.assert_allclose(speeds[:, 1], -math.sqrt(2.0 * 2e-4 * GRAVITY), rtol=1e-10)
    np.testing.assert_allclose(run.support_load.sum("support"), [0.0, MASS * GRAVITY], atol=1e-9)
    at_a = MASS * GRAVITY * RIGHT / (RIGHT - LEFT)
    np.testing.assert_allclose(run.support_load[0, 1], at_a, rtol=1e-12)


def test_what_lasts_to_the_end_does_so_whatever_is_sampled():
    given = {"contacts": [bearing("a"), bearing("b")], "speed": 1500.0, "duration": 0.0066}
    told, early = (drop(rigid(), **given, supports=SUPPORTS, samples=each)
                   for each in (2, [0.0, 0.0065]))  # fmt: skip
    assert np.isnan(told.exit_time.values[-1])
    for name in ("total_contact_time", "longest_contact_time", "mean_contact_force"):
        np.testing.assert_array_equal(early[name], told[name], err_msg=name)


@pytest.mark.parametrize("phase", [0.3, 2.5, 5.0])
def test_an_unbalanced_rotor_first_touches_where_the_free_motion_says(phase):
    """Without gyroscopic moments translation and tilt are forced free bodies."""
    moment, speed = 4e-4, 300.0
    run = drop(rigid(polar=0.0), contacts=[bearing("a"), bearing("b")], speed=speed, phase=phase,
               unbalance=[Unbalance(node="disc", moment=moment)], supports=SUPPORTS,
               duration=0.009)  # fmt: skip
    places, inertia = np.array([LEFT, RIGHT]), np.diag([MASS, TILT])
    shape = np.array([[1.0, LEFT], [1.0, RIGHT]])
    held = (2e6 + 2e3j * speed) * shape.T @ shape
    force = moment * speed**2 * np.array([1.0, DISC]) * np.exp(1j * phase)
    whirl = np.linalg.solve(held - speed**2 * inertia, force)
    free = -force / np.diag(inertia) / speed**2  # of a free body

    def displacement(time, z):
        body = free * np.exp(1j * speed * time)
        body = body + (whirl - free) * (1.0 + 1j * speed * time)
        return body[0] + z * body[1] - 0.5j * GRAVITY * time**2

    times = [brentq(lambda t, z=z: abs(displacement(t, z)) - 2e-4, 1e-3, 8e-3, xtol=1e-15)
             for z in places]  # fmt: skip
    np.testing.assert_allclose(run.event_time[0], min(times), rtol=1e-10)
    assert run.event_contact[0] == np.argmin(times)


@pytest.mark.parametrize("node", ["a", "b"])
def test_the_restitution_at_each_bearing_does_not_depend_on_the_mass_behind_it(node):
    """With N = k d^n (1 + lambda d'), v - ln(1 + lambda v)/lambda is the same at entry and exit."""
    damping, entry = 5.0, 0.06
    start = ([0.0] * 4, [0.0, -entry, 0.0, 0.0])
    run = drop(rigid(), contacts=[bearing(node, damping=damping)], speed=0.0, gravity=(0.0, 0.0),
               start=start, duration=0.02)  # fmt: skip
    z = {"a": LEFT, "b": RIGHT}[node]
    velocities = run.event_state.values[:, 4:8] @ np.array([0.0, -1.0, 0.0, -z])
    np.testing.assert_allclose(velocities[0], entry, rtol=1e-10)

    def kept(speed):
        return damping * speed - math.log1p(damping * speed)

    leaving = brentq(lambda v: kept(v) - kept(entry), -0.99 * entry, -1e-3, xtol=1e-15)
    np.testing.assert_allclose(velocities[1], leaving, rtol=1e-9)


def test_a_race_spins_up_and_the_rotor_slows_down_under_constant_sliding():
    """A disc that slides at the bottom of its bearing: N = m g/sqrt(1 + mu^2)."""
    friction, radius, inertia, race = 0.2, 0.03, 0.02, Race(radius=0.025, inertia=1e-3)
    system = RotorSystem(mass=MASS * np.eye(2), stiffness=np.zeros((2, 2)), nodes={"disc": (0, 1)})
    touch = bearing("disc", friction=friction, race=race)
    normal = MASS * GRAVITY / math.hypot(1.0, friction)
    away = -1j * MASS * GRAVITY / (normal * (1.0 + 1j * friction))
    place = away * (2e-4 + (normal / 2e9) ** (2.0 / 3.0))
    run = drop(system, contacts=[touch], speed=1500.0, inertia=inertia, duration=0.5,
               start=([place.real, place.imag], [0.0, 0.0]))  # fmt: skip
    torque = friction * normal
    expected = race.radius * torque * 0.5 / race.inertia
    np.testing.assert_allclose(run.largest_race_speed, expected, rtol=1e-9)
    np.testing.assert_allclose(run.race_speed_time, 0.5)
    np.testing.assert_allclose(run.speed[-1], 1500.0 - radius * torque * 0.5 / inertia, rtol=1e-9)
    slid = (radius * (1500.0 + float(run.speed[-1])) - race.radius * expected) / 2.0 * 0.5
    np.testing.assert_allclose(run.total_heat, torque * slid, rtol=1e-9)
    assert run.rest_time.isnull().all()  # it never entered: the run began in contact
    assert np.isnan(run.standstill_time)


def test_races_are_fastest_and_slowest_where_friction_and_drag_balance():
    """Discs held along x hop on springs, in contact: J w' = R_b mu (m g + k A cos) - c w."""
    stiff, friction, weight, duration = np.array([1e7, 3e7]), 0.2, MASS * GRAVITY, 0.3
    amplitude, phase = 0.9 * weight / stiff, np.array([0.3, 2.0])
    rate, sag = np.sqrt(stiff / MASS), weight / stiff + amplitude * np.cos(phase)
    system = RotorSystem(
        mass=MASS * np.eye(2), stiffness=np.zeros((2, 2)),
        nodes={"a": np.array([[0.0, 0.0], [1.0, 0.0]]), "b": np.array([[0.0, 0.0], [0.0, 1.0]])},
    )  # fmt: skip
    races = [Race(radius=0.025, inertia=2e-4, drag=1e-3, speed=speed) for speed in (900.0, 985.0)]
    touches = [
        Contact(node=node, clearance=2e-4, stiffness=each, exponent=1.0, friction=friction,
                radius=0.03, race=race)
        for node, each, race in zip("ab", stiff, races, strict=True)
    ]  # fmt: skip
    run = rotor_ida.simulate(
        system, contacts=touches, speed=1500.0, static_force=[-weight, -weight], samples=2,
        start=(-2e-4 - sag, amplitude * rate * np.sin(phase)), duration=duration,
    )  # fmt: skip
    for i, race in enumerate(races):
        turning = race.drag + 1j * rate[i] * race.inertia

        def speed(time, i=i, race=race, turning=turning):
            decay = np.exp(-race.drag * time / race.inertia)
            hop = np.exp(1j * phase[i]) * (np.exp(1j * rate[i] * time) - decay) / turning
            driven = weight * (1.0 - decay) / race.drag + stiff[i] * amplitude[i] * hop.real
            return race.speed * decay + race.radius * friction * driven

        def excess(time, i=i, race=race, speed=speed):
            force = weight + stiff[i] * amplitude[i] * np.cos(rate[i] * time + phase[i])
            return race.radius * friction * force - race.drag * speed(time)

        times = np.linspace(0.0, duration, 4001)
        signs = np.sign(excess(times))
        turns = [brentq(excess, times[n], times[n + 1], xtol=1e-15, rtol=1e-14)
                 for n in np.flatnonzero(signs[1:] != signs[:-1])]  # fmt: skip
        assert len(turns) > 50
        places = np.array([0.0, *turns, duration])
        speeds = speed(places)
        for name, best in (("max", speeds.argmax()), ("min", speeds.argmin())):
            assert 0 < best < len(turns) + 1
            np.testing.assert_allclose(run[f"race_speed_{name}"][i], speeds[best], rtol=1e-10)
            np.testing.assert_allclose(run[f"race_speed_{name}_time"][i], places[best], rtol=1e-8)


def test_the_largest_speed_of_a_race_in_an_impact_lies_between_its_events():
    """CVODE passes it at the same time."""
    races = [Race(radius=0.03, inertia=2e-5, drag=drag) for drag in (0.1, 0.05)]
    touches = [bearing(node, friction=0.2, race=race)
               for node, race in zip("ab", races, strict=True)]  # fmt: skip
    given = {"contacts": touches, "speed": 600.0, "duration": 0.009, "supports": SUPPORTS,
             "inertia": POLAR, "unbalance": [Unbalance(node="disc", moment=8e-5)]}  # fmt: skip
    run = drop(rigid(), **given, samples=2)
    assert (run.largest_race_speed > 1.1 * run.event_race_speed.max("event")).all()
    witness = drop(rigid(), **given, samples=2, method="adams")
    np.testing.assert_allclose(witness.largest_race_speed, run.largest_race_speed, rtol=1e-8)
    np.testing.assert_allclose(witness.race_speed_time, run.race_speed_time, rtol=1e-9)


def test_dry_whip_has_the_frequency_of_the_rotor_with_its_contact_closed():
    """Two discs in steady rolling: the contact is a spring (N + i T)/A, the eigenvalue i omega."""
    chain, masses, damping = np.array([[8e6, -4e6], [-4e6, 6e6]]), np.diag([12.0, 8.0]), 2e-5
    system = RotorSystem(
        mass=np.kron(masses, np.eye(2)), stiffness=np.kron(chain, np.eye(2)),
        damping=damping * np.kron(chain, np.eye(2)), nodes={"disc": (0, 1), "seal": (2, 3)},
    )  # fmt: skip
    speed, radius = 16.0, 0.012
    touch = Contact(node="seal", clearance=2e-4, stiffness=5e7, exponent=1.0, friction=0.5,
                    radius=radius)  # fmt: skip
    start = ([1e-4, 0.0, 2.4e-4, 0.0], [0.0, -0.09, 0.0, -radius * speed])
    late = drop(system, contacts=[touch], speed=speed, start=start, gravity=(0.0, 0.0),
                duration=5.0, samples=np.linspace(4.9, 5.0, 1001))  # fmt: skip
    assert (late["mode"] == 2).all()
    assert late.whirl_sense[0] == -1
    amplitude = np.hypot(late.contact_x, late.contact_y).mean().item()
    whirl = late.whirl_speed[0].item()
    np.testing.assert_allclose(whirl, -radius * speed / amplitude, rtol=1e-6)
    force = complex(late.normal_force.mean(), late.tangential_force.mean()) / amplitude
    closed = chain + np.diag([0.0, force])
    inverse = np.linalg.inv(masses)
    matrix = np.block([[np.zeros((2, 2)), np.eye(2)],
                       [-inverse @ closed, -damping * inverse @ chain]])  # fmt: skip
    eigenvalues = np.linalg.eigvals(matrix)
    nearest = eigenvalues[np.abs(eigenvalues - 1j * whirl).argmin()]
    np.testing.assert_allclose(nearest, 1j * whirl, rtol=1e-5)  # the transient


def test_the_mirror_image_of_dry_whip_whirls_backward_too():
    """At a speed of the other sign, mirrored in the x axis."""
    system = RotorSystem(mass=20.0 * np.eye(2), stiffness=2e6 * np.eye(2),
                         damping=800.0 * np.eye(2), nodes={"disc": (0, 1)})  # fmt: skip
    touch = Contact(node="disc", clearance=3e-4, stiffness=5e7, exponent=1.0, friction=0.3,
                    radius=0.006)  # fmt: skip
    for change in ({}, {"inertia": 1.0}):
        run, image = (
            drop(system, contacts=[touch], speed=side * 30.0, gravity=(0.0, 0.0), duration=0.5,
                 start=([3.2e-4, 0.0], [0.0, -side * 0.15]), **change)
            for side in (1.0, -1.0)
        )  # fmt: skip
        for each in (run, image):
            assert each.whirl_sense[0] == -1
            assert each.whirl_turns[0] < -3.0
            assert each.whirl_speed[0] < 0.0
        np.testing.assert_allclose(image.whirl_turns, run.whirl_turns, rtol=1e-6)
        np.testing.assert_allclose(image.whirl_speed, run.whirl_speed, rtol=1e-6)


def test_a_support_that_stays_holds_its_end():
    given = {"contacts": [bearing("a"), bearing("b")], "speed": 1500.0, "duration": 0.3}
    run = drop(rigid(), **given, supports=SUPPORTS, failing=["a"])
    assert run.contact_count[0] > 0
    assert run.contact_count[1] == 0
    assert run.support_fails.values.tolist() == [1, 0]
    held = drop(rigid(), **given | {"duration": 0.01}, supports=SUPPORTS, failing=["a"], samples=11)
    other = drop(rigid(LEFT, RIGHT), **given | {"duration": 0.01}, supports=SUPPORTS, samples=11)
    assert abs(float(held.y.sel(node="b")[-1])) < 0.2 * abs(float(other.y.sel(node="b")[-1]))


def test_a_balanced_flexible_rotor_hangs_between_its_supports():
    """It sags between nodes that are held at the centre; at rest nothing moves before the drop."""
    chain = np.array([[2e6, -2e6, 0.0], [-2e6, 4e6, -2e6], [0.0, -2e6, 2e6]])
    nodes = {"a": (0, 3), "disc": (1, 4), "b": (2, 5)}
    system = RotorSystem(mass=np.kron(np.eye(2), np.diag([2.0, 10.0, 2.0])),
                         stiffness=np.kron(np.eye(2), chain), nodes=nodes)  # fmt: skip
    run = drop(system, contacts=[bearing("a"), bearing("b")], speed=100.0, duration=1e-3,
               supports=SUPPORTS, clearances={"disc": 3e-4})  # fmt: skip
    first = run.isel(t=0)
    np.testing.assert_allclose(first.y, [0.0, -10.0 * GRAVITY / 4e6, 0.0], atol=1e-18)
    np.testing.assert_allclose(run.support_load[:, 1], 7.0 * GRAVITY)
    radius = float(run.largest_radius.sel(node="disc"))
    np.testing.assert_allclose(run.node_excursion.sel(node="disc"), radius / 3e-4)


def test_a_run_does_not_depend_on_when_its_tables_grow(monkeypatch):
    """A contact that had just ended entered again where the table of events was full."""
    given = {"contacts": [bearing("a"), bearing("b")], "speed": 1500.0, "duration": 0.2,
             "unbalance": [Unbalance(node="disc", moment=8e-5)], "inertia": POLAR,
             "samples": 11}  # fmt: skip
    runs = []
    for room in (256, 1, 7):
        monkeypatch.setattr(core_systems, "FIRST_ROOM", room)
        runs.append(drop(rigid(), **given, supports=SUPPORTS))
    assert runs[0].sizes["event"] > 24
    for other in runs[1:]:
        assert other.drop_attrs().equals(runs[0].drop_attrs())


def test_a_symmetric_rotor_touches_leaves_and_slips_at_both_ends_at_once_and_comes_to_rest():
    run = drop(rigid(-0.3, 0.3, 0.0), contacts=[soft("a"), soft("b")], speed=1500.0, duration=3.0,
               unbalance=[Unbalance(node="disc", moment=8e-5)], inertia=POLAR, drag=1e-2,
               supports=[], start=([0.0] * 4, [0.0] * 4), samples=2001)  # fmt: skip
    assert (run.contact_count > 10).all()
    assert (np.abs(run.event_kind) == 2).any()


def test_a_drop_ends_at_a_standstill():
    hard = [bearing(node, friction=0.15, damping=10.0) for node in "ab"]
    run = drop(rigid(), contacts=hard, speed=20.0, duration=6.0, inertia=POLAR, drag=0.05,
               supports=SUPPORTS, samples=2001)  # fmt: skip
    assert run.rest_time.notnull().all()
    assert 0.0 < float(run.standstill_time) < 6.0
    np.testing.assert_allclose(run.longest_contact_time, 6.0 - run.rest_time)
    # the weight is carried, in part by friction, by a rotor that swings a little
    weight = run.support_load.values[:, 1] * 6.0 / run.total_contact_time.values
    np.testing.assert_allclose(run.mean_contact_force, weight, rtol=0.02)
    assert float(run.horizon) == 6.0


@pytest.mark.parametrize(
    ("samples", "method", "within"),
    [(11, "taylor", 1e-13), (1001, "taylor", 1e-13), (11, "adams", 1e-8)],
)
def test_a_standstill_is_an_event_whatever_the_samples(samples, method, within):
    """Under drag alone the speed is 500 exp(-t): it stands from ln 100 on."""
    disc = RotorSystem(mass=np.eye(2), stiffness=np.zeros((2, 2)), nodes={"a": (0, 1)})
    run = drop(disc, contacts=[soft("a")], speed=500.0, duration=6.0, inertia=0.08, drag=0.08,
               gravity=(0.0, 0.0), samples=samples, method=method)  # fmt: skip
    apart = abs(float(run.standstill_time) - np.log(100.0))
    assert apart <= float(run.standstill_time_error) < 100.0 * within
    assert apart < within


def rocking(drag, duration):
    """Return a run-up of a pendulum: an unbalance about a nearly rigid axis."""
    system = RotorSystem(mass=np.eye(2), stiffness=1e4 * np.eye(2), damping=50.0 * np.eye(2),
                         nodes={"disc": (0, 1)}, units="1")  # fmt: skip
    return run_up(system, unbalance=[Unbalance(node="disc", moment=0.5)], speed=0.8,
                  torque=(0.0, drag), inertia=1.0, duration=duration, gravity=(0.0, -1.0),
                  samples=3001)  # fmt: skip


def test_a_rotor_that_rocks_does_not_stand_until_its_swings_are_slight():
    swings = rocking(0.0, 30.0)
    turns = np.flatnonzero(np.diff(np.sign(swings.speed.values)))
    assert turns.size > 3
    for place in turns:  # at a reversal the speed is below a hundredth for an instant
        assert np.isnan(rocking(0.0, float(swings.t[place + 1])).standstill_time)
    fading = rocking(1.0, 30.0)
    fast = np.abs(fading.speed.values) > 0.008
    last = np.flatnonzero(fast)[-1]
    assert float(fading.t[last]) <= float(fading.standstill_time) <= float(fading.t[last + 1])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"contacts": []}, "contacts must be at least one for a drop, got none"),
        ({"supports": SUPPORTS[:1] * 2}, "supports must be at different nodes, got 'a' twice"),
        ({"failing": ["disc"]}, "support in failing must be one of 'a', 'b', got 'disc'"),
        ({"failing": ["a"], "supports": []}, "failing must be left out, as there are no supports"),
        ({"drag": 0.1}, "inertia must be given with drag"),
        ({"clearances": {"disc": -1.0}}, "clearance at 'disc' must be positive"),
        ({"clearances": {"end": 1.0}}, "end"),
        ({"capacities": {"disc": 1.0}}, "node in capacities must be one of 'a', got 'disc'"),
        ({"capacities": {"a": 0.0}}, "capacity at 'a' must be positive"),
        ({"capacities": 3.0}, "capacities must be numbers by nodes, got 3.0"),
        ({"unbalance": [Unbalance(node="disc", moment=1.0)]}, "clear of the levitated rotor"),
        ({"supports": [Support(node="disc", stiffness=1e6)]}, "got too few"),
    ],
)
def test_what_cannot_be_dropped_is_refused_in_one_line(change, words):
    given = {"contacts": [bearing("a")], "speed": 100.0, "duration": 0.01, "supports": SUPPORTS}
    with pytest.raises(InputError, match=words) as caught:
        drop(rigid(), **given | change)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("friction", "damping", "whips"), [(0.0, 10.0, False), (0.2, 10.0, False),
                                                            (0.4, 10.0, True)])  # fmt: skip
def test_a_disc_as_a_system_drops_as_the_disc_itself(friction, damping, whips):
    """The rotor of the scenario "drop": the same events up to the horizon, the same end."""
    machine = DimensionalRotor(
        mass=MASS, contact_stiffness=2e9, damping=50.0, eccentricity=4e-6, clearance=2e-4,
        speed=500.0 * math.pi, contact_damping=damping, load=MASS * GRAVITY, friction=friction,
        disc_radius=0.02 if friction else None,
    )  # fmt: skip
    rotor = machine.rotor()
    one = rotor_ida.simulate(rotor, start=(-1.0, 0.0, 0.0, -rotor.omega), samples=1001,
                             duration=0.15 / machine.time_scale)  # fmt: skip
    system = machine.system()
    shift = machine.eccentricity
    run = drop(system, speed=machine.speed, duration=0.15,
               start=([-shift, 0.0], [0.0, -shift * machine.speed]))  # fmt: skip
    times = one.event_time.values * machine.time_scale
    both = min(float(one.horizon) * machine.time_scale, float(run.horizon))
    count = int((times < 0.99 * both).sum())
    assert count == times.size >= 4
    np.testing.assert_allclose(run.event_time.values[:count], times[:count], rtol=1e-9)
    assert (run.event_kind.values[:count] == one.event_kind.values[:count]).all()
    assert is_whip(one) == whips
    assert (run.whirl_sense[0] < 0) == whips
    assert (run["mode"][-1, 0] == MODE["rolling"]) == whips
    assert run.rest_time.notnull().all()
    elastic = [replace(system.contacts[0], damping=0.0)]
    bounce = drop(system, contacts=elastic, speed=machine.speed, duration=0.03,
                  start=([-shift, 0.0], [0.0, -shift * machine.speed]))  # fmt: skip
    assert bounce.contact_count.item() > 0
    assert bounce.total_contact_loss.item() == 0.0 < run.total_contact_loss.item()


def test_samples_by_default_resolve_a_whirl_that_is_much_faster_than_the_spin():
    """Friction drives the disc backwards: where it rolls, by the speed of its surface."""
    system = RotorSystem(mass=MASS * np.eye(2), stiffness=np.zeros((2, 2)), nodes={"disc": (0, 1)})
    touch = Contact(node="disc", clearance=2e-4, stiffness=2e8, exponent=1.0, damping=1.0,
                    friction=0.3, radius=0.03)  # fmt: skip
    run = drop(system, contacts=[touch], speed=20.0, gravity=(0.0, 0.0), duration=2.0,
               start=([1.9e-4, 0.0], [0.05, -1.0]))  # fmt: skip
    late = run.isel(t=slice(-400, None), contact=0)
    assert (late["mode"] == MODE["rolling"]).all()
    rates = -touch.radius * 20.0 / np.hypot(late.contact_x, late.contact_y)
    angle = np.unwrap(np.arctan2(late.contact_y, late.contact_x))
    np.testing.assert_allclose(angle[-1] - angle[0], np.trapezoid(rates, late.t), rtol=1e-3)
    assert run.whirl_sense == -1


@pytest.mark.parametrize(("duration", "speed"), [(3.0, 2000.0), (15.0, 2000.0), (0.05, 20.0)])
def test_samples_by_default_are_32_a_revolution_or_a_thousand(duration, speed):
    """However much finer there was room to sample at first."""
    system = RotorSystem(mass=MASS * np.eye(2), stiffness=np.zeros((2, 2)), nodes={"disc": (0, 1)})
    touch = Contact(node="disc", clearance=2e-4, stiffness=2e8)
    run = drop(system, contacts=[touch], speed=speed, gravity=(0.0, 0.0), duration=duration,
               start=([0.0, 0.0], [1e-6, 0.0]))  # fmt: skip
    assert run.t.size >= max(math.floor(32.0 * speed * duration / math.tau), 1001)
