"""Rotor systems themselves: what they hold, files, reduction, and what is refused."""

import pickle
import re
from dataclasses import replace

import numpy as np
import pytest
import scipy.io
import scipy.linalg
import scipy.sparse

from rotor_ida import (
    Contact,
    InputError,
    Race,
    RotorSystem,
    SimulationError,
    Stator,
    Unbalance,
    campbell,
    decode_flags,
    run_up,
    simulate,
    sweep,
)
from rotor_ida.cli.describe import describe
from rotor_ida.core import systems as core_systems
from rotor_ida.model.assembly import assemble, canonical
from rotor_ida.model.growth import growth_between, growth_of
from rotor_ida.results.archived_system import system_of
from tests.axisymmetric_systems import random_axisymmetric
from tests.random_systems import random_system

PLAIN = {"mass": np.eye(4), "stiffness": 2.0 * np.eye(4), "nodes": {"disc": (0, 1), "end": (2, 3)}}
TOUCH = {"node": "disc", "clearance": 0.1, "stiffness": 10.0}


def beam(count=8):
    """Return a chain of masses on springs, a node at each."""
    chain = 2.0 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    return RotorSystem(
        mass=np.eye(2 * count), stiffness=np.kron(chain, np.eye(2)),
        damping=0.02 * np.kron(chain, np.eye(2)),
        nodes={str(i): (2 * i, 2 * i + 1) for i in range(count)}, units="1",
    )  # fmt: skip


def test_matrices_are_copies_that_nobody_writes_into():
    mass = np.eye(4)
    system = RotorSystem(**PLAIN | {"mass": mass})
    mass[0, 0] = 7.0
    assert system.mass[0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        system.mass[0, 0] = 2.0
    again = pickle.loads(pickle.dumps(system))
    np.testing.assert_array_equal(again.mass, system.mass)
    assert list(again.nodes) == ["disc", "end"]


def test_a_stator_without_mass_and_damping_is_refused():
    with pytest.raises(InputError, match="damping of a stator without mass must be positive"):
        Stator(mass=0.0, stiffness=1.0)
    light = Stator(mass=0.0, stiffness=1.0, damping=1.0)
    contacts = [Contact(**TOUCH | {"clearance": c, "stator": light}) for c in (1.0, 2.0)]
    system = RotorSystem(mass=np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)}, units="1")
    with pytest.raises(InputError, match="a stator without mass must have one contact, got 2"):
        simulate(system, contacts=contacts, speed=1.0, duration=1.0)
    with pytest.raises(InputError, match="mass of the stator of contact 0 at 'disc' must be"):
        campbell(system, contacts=contacts[:1], speed=1.0)
    with pytest.raises(InputError, match="inertia of a race must"):
        Race(radius=1.0, inertia=0.0)


@pytest.mark.parametrize("ramp", [{"rate": 0.1, "duration": 10.0}, {"to": 1.5, "ramp_time": 10.0}])
def test_a_ramp_may_have_a_duration_for_its_end_or_for_its_rate(ramp):
    system, around = random_system(2)
    ways = ({"to": 1.5, "rate": (1.5 - 0.5) / 10.0}, ramp)
    one, other = (run_up(system, speed=0.5, samples=11, **around, **way) for way in ways)
    assert one.sizes["event"] > 0
    np.testing.assert_array_equal(one.event_time, other.event_time)
    assert other.speed[-1] == pytest.approx(1.5)


@pytest.mark.parametrize("method", ["taylor", "bdf"])
def test_progress_rises_to_a_hundred(method):
    told = []
    simulate(
        beam(2), unbalance=[Unbalance(node="1", moment=1.0)], speed=0.7, duration=5.0, samples=2,
        method=method, progress=lambda done, whole: told.append((done, whole)),
    )  # fmt: skip
    assert told == sorted(told)
    assert told[-1] == (100, 100)


def test_gravity_acts_by_the_nodes_or_is_refused():
    """Rows that determine a translation will do; one node of a rotor that tilts will not."""
    rows = {"a": [[1, 0, 0.3, 0], [0, 1, 0, 0.3]], "b": [[1, 0, -0.3, 0], [0, 1, 0, -0.3]]}
    tilting = {"mass": np.diag([2.0, 2.0, 0.1, 0.1]), "stiffness": np.eye(4)}
    whole = RotorSystem(**tilting, nodes=rows)
    np.testing.assert_allclose(whole.unit_translations(), np.eye(4)[:, :2], atol=1e-15)
    part = RotorSystem(**tilting, nodes={"a": rows["a"]})
    with pytest.raises(InputError, match="translations must be given for gravity"):
        simulate(part, gravity=(0, -9.81), speed=0.0, duration=1.0)


def bending_beam():
    """Return a beam of twelve nodes, and what makes it touch."""
    chain = 2.0 * np.eye(12) - np.eye(12, k=1) - np.eye(12, k=-1)
    bending = np.kron(chain @ chain, np.eye(2))
    system = RotorSystem(
        mass=np.eye(24), stiffness=bending, damping=0.05 * bending, units="1",
        nodes={str(i): (2 * i, 2 * i + 1) for i in range(12)},
    )  # fmt: skip
    return system, {
        "contacts": [Contact(node="4", clearance=3.0, stiffness=0.5, exponent=1.0)], "speed": 0.1,
        "unbalance": [Unbalance(node="8", moment=20.0)], "duration": 150.0, "samples": 2,
    }  # fmt: skip


def test_a_run_states_how_far_its_events_move_with_more_modes():
    system, around = bending_beam()
    whole = simulate(system, **around)
    few = simulate(system, **around, modes=6, more_modes=24)
    count = int(np.isfinite(few.event_time_shift).sum())
    assert count >= 2
    apart = np.abs(few.event_time - whole.event_time.values[: few.sizes["event"]])[:count]
    np.testing.assert_allclose(few.event_time_shift[:count], apart, rtol=1e-6, atol=1e-11)
    less = simulate(system, **around, modes=12, more_modes=24)
    assert less.event_time_shift[1] < 0.1 * few.event_time_shift[1]
    assert few.attrs["more_modes"] == 24


def test_a_reduced_run_takes_starts_and_forces_of_all_coordinates():
    system, around = bending_beam()
    rng = np.random.default_rng(1)
    around |= {"start": (rng.normal(size=24), 0.1 * rng.normal(size=24))}
    around |= {"static_force": 0.01 * rng.normal(size=24)}
    whole, same = simulate(system, **around), simulate(system, **around, modes=24)
    np.testing.assert_allclose(same.event_time, whole.event_time, rtol=1e-9)
    np.testing.assert_allclose(same.x, whole.x, atol=1e-8)


def test_static_flexibility_makes_few_modes_enough():
    """The second event of a bending beam: a hundred times nearer with its flexibility."""
    system, around = bending_beam()

    def second(rotor, **how):
        return simulate(rotor, **around, **how).event_time.values[1]

    exact = second(system)
    for count in (8, 12):
        apart = abs(second(system.reduced(modes=count)) - exact)
        kept = abs(second(system, modes=count) - exact)
        assert kept < 0.01 * apart


def test_what_is_sampled_does_not_change_the_run():
    system, around = random_system(10)
    runs = [simulate(system, speed=1.1, duration=10.0, samples=n, **around) for n in (2, 1000)]
    for name in ("event_time", "impulse", "slip_distance", "heat", "final_state"):
        np.testing.assert_array_equal(runs[0][name], runs[1][name])


@pytest.mark.parametrize("change", [
    {"speed": 1.3}, {"speed": 0.5, "rate": 0.05}, {"speed": 0.5, "to": 1.3, "rate": 0.2},
    {"speeds": [(0.0, 0.5), (12.0, 1.2), (20.0, 0.8), (40.0, 1.3)]},
    {"speed": 1.0, "torque": (1.5, 0.4), "inertia": 4.0},
])  # fmt: skip
def test_room_for_few_events_at_a_time_changes_no_bit(change, monkeypatch):
    """Its tables full, the core ends, and goes on with larger ones."""
    system, contacts, unbalance = random_axisymmetric(4)
    around = {"contacts": contacts, "unbalance": unbalance, "duration": 40.0, "samples": 50}
    follow = simulate if set(change) == {"speed"} else run_up
    whole = follow(system, **change, **around)
    assert whole.sizes["event"] > 20
    monkeypatch.setattr(core_systems, "FIRST_ROOM", 1)
    parts = follow(system, **change, **around)
    for name in ("event_time", "event_state", "x", "y", "heat", "final_state"):
        np.testing.assert_array_equal(parts[name], whole[name])


@pytest.mark.parametrize("seed", [1, 5])
def test_a_negative_speed_gives_the_mirror_image(seed):
    """With gyroscopic terms, friction and moving stators; unbalance at the mirrored phases."""
    system, contacts, unbalance = random_axisymmetric(seed)
    mirrored = [replace(each, phase=-each.phase) for each in unbalance]
    run, image = (
        simulate(system, contacts=contacts, unbalance=each, speed=speed, duration=30.0, samples=50)
        for speed, each in ((1.3, unbalance), (-1.3, mirrored))
    )
    assert run.sizes["event"] > 5
    np.testing.assert_allclose(image.event_time, run.event_time, rtol=1e-7)
    np.testing.assert_allclose(image.x, run.x, atol=1e-7)
    np.testing.assert_allclose(image.y, -run.y, atol=1e-7)
    np.testing.assert_allclose(image.heat, run.heat, atol=1e-7)


@pytest.mark.parametrize("scale", [1.0, 1e-9])
def test_without_contacts_the_motion_is_exact_at_any_scale(scale):
    """Errors are measured by the motion: in metres that of a rotor is tiny."""
    chain = np.array([[8e6, -4e6], [-4e6, 6e6]])
    system = RotorSystem(
        mass=np.diag([12.0, 12.0, 8.0, 8.0]), stiffness=np.kron(chain, np.eye(2)),
        damping=np.kron(2e-3 * chain, np.eye(2)), nodes={"disc": (0, 1), "seal": (2, 3)},
    )  # fmt: skip
    run = simulate(
        system, unbalance=[Unbalance(node="disc", moment=scale)], speed=450.0, duration=0.5,
        samples=[0.01, 0.5],
    )  # fmt: skip
    # from rest: the whirl, and the free vibration that cancels it at first
    inverse = np.diag([1.0 / 12.0, 1.0 / 8.0])
    whirl = np.linalg.solve(chain * (1.0 + 0.9j) - 450.0**2 * np.diag([12.0, 8.0]),
                            [scale * 450.0**2, 0.0])  # fmt: skip
    free = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ chain, -2e-3 * inverse @ chain]])
    left = scipy.linalg.expm(0.01 * free) @ -np.append(whirl, 450j * whirl)
    now = run.sel(t=0.01)
    exact = whirl * np.exp(4.5j) + left[:2]
    np.testing.assert_allclose(now.x + 1j * now.y, exact, rtol=0, atol=1e-9 * np.abs(whirl).max())


@pytest.mark.parametrize(("clearance", "moment"), [(1.0, 1e-3), (1e-4, 1e-7), (1e-4, 1e-15)])
def test_a_motion_far_smaller_than_the_clearance_is_that_without_contact(clearance, moment):
    """The errors of its energy are measured by the clearance too."""
    system = RotorSystem(mass=12.0 * np.eye(2), stiffness=2e6 * np.eye(2),
                         damping=400.0 * np.eye(2), nodes={"disc": (0, 1)})  # fmt: skip
    case = {"unbalance": [Unbalance(node="disc", moment=moment)], "speed": 300.0, "duration": 0.2}
    far = Contact(node="disc", clearance=clearance, stiffness=5e7)
    run, alone = simulate(system, contacts=[far], **case), simulate(system, **case)
    assert run.sizes["event"] == 0
    size = float(np.abs(alone.x).max())
    np.testing.assert_allclose(run.x, alone.x, rtol=0, atol=1e-8 * size)


def test_a_run_computed_again_has_the_same_axial_positions():
    places = {"disc": 0.1, "end": 0.3}
    run = simulate(RotorSystem(**PLAIN, positions=places), speed=1.0, duration=1.0, samples=3)
    assert dict(zip(run.node.values, run.axial_position.values, strict=True)) == places
    again = system_of(run)
    assert again.positions == places
    assert again.reduced(modes=2).positions == places


def test_a_motion_grows_only_where_an_eigenvalue_says_so():
    """Also of matrices that give it no energy, at which no speed is tried; some are singular."""
    rng, grown = np.random.default_rng(3), 0
    for number in range(60):
        springs, dampers, turning, cross = rng.normal(size=(4, 4, 4))
        springs[:, 0] *= number % 2
        stiffness = springs @ springs.T + rng.choice([0.0, 1e-9, 0.3]) * (cross - cross.T)
        damping = rng.choice([0.0, 0.1]) * dampers @ dampers.T
        found = canonical(assemble(RotorSystem(
            mass=np.diag(rng.uniform(0.5, 2.0, 4)), stiffness=stiffness, units="1",
            damping=damping - rng.choice([0.0, 0.0, 1e-3]) * np.eye(4),
            gyroscopic=0.5 * (turning - turning.T), nodes={"a": (0, 1), "b": (2, 3)},
        )))  # fmt: skip
        grows = any(growth_of(found, speed) for speed in np.linspace(0.1, 3.0, 65).tolist())
        assert bool(growth_between(found, 0.1, 3.0)) == grows, number
        grown += grows
    assert 20 < grown < 50


def test_a_linear_system_that_grows_is_told():
    """Cross-coupled stiffness of 0.2 against a damping of 0.1, as of a journal bearing."""
    around = {"speed": 1.0, "duration": 5.0, "samples": 5}
    bearing = {"mass": np.eye(2), "nodes": {"disc": (0, 1)}, "units": "1"}
    crossed = np.array([[1.0, 0.2], [-0.2, 1.0]])
    growing = RotorSystem(**bearing, stiffness=crossed, damping=0.1 * np.eye(2))
    rates = np.linalg.eigvals(
        np.block([[np.zeros((2, 2)), np.eye(2)], [-crossed, -0.1 * np.eye(2)]])
    )
    exact = rates[np.argmax(rates.real)]
    words = (
        f"Without contact the motion grows at a rate of {exact.real:.4g}, as a whirl at "
        f"{abs(exact.imag):.4g}: the linear system is unstable."
    )
    start = ([0.05, 0.0], [0.0, 0.0])
    with pytest.warns(UserWarning, match=f"^{re.escape(words)}$"):
        run = simulate(growing, contacts=[Contact(**TOUCH)], start=start, **around)
    with pytest.warns(UserWarning, match=f"^{re.escape(words)}$") as told:
        run_up(growing, to=1.2, rate=0.1, samples=3, speed=1.0)
    assert told[0].filename == __file__
    assert run.attrs["growth_rate_without_contact"] == pytest.approx(exact.real, rel=1e-12)
    assert run.attrs["whirl_speed_of_growth"] == pytest.approx(abs(exact.imag), rel=1e-12)
    _, parts = describe(run)
    assert words in parts
    still = RotorSystem(**bearing, stiffness=np.eye(2))  # grows by rounding alone
    bend = 4e3 * np.kron(np.outer([-0.5, 1.0, -0.5], [-0.5, 1.0, -0.5]), np.eye(2))
    free = RotorSystem(
        mass=np.kron(np.diag([8.0, 30.0, 10.0]), np.eye(2)), stiffness=bend, damping=2e-5 * bend,
        nodes={"disc": (2, 3)}, units="1",
    )  # fmt: skip
    for system in (still, free):
        assert "growth_rate_without_contact" not in simulate(system, **around).attrs


@pytest.mark.parametrize(
    ("nodes", "gravity", "falls"),
    [
        ("", (0.0, -0.1), True),
        ("a", (0.0, -0.1), True),
        ("ab", (0.0, -0.1), False),
        ("", None, False),
    ],
)
def test_a_system_that_nothing_holds_is_told(nodes, gravity, falls, recwarn):
    """Two masses without supports: constant forces move each without a contact of its own."""
    free = RotorSystem(
        mass=np.eye(4), stiffness=np.zeros((4, 4)), damping=0.1 * np.eye(4),
        nodes={"a": (0, 1), "b": (2, 3)}, units="1",
    )  # fmt: skip
    contacts = [Contact(node=node, clearance=1.0, stiffness=4.0, exponent=1.0) for node in nodes]
    run = simulate(free, contacts=contacts, gravity=gravity, speed=1.0, duration=60.0, samples=3)
    assert bool(np.abs(run.y.values[-1]).max() > 5.0) is falls
    assert run.attrs.get("nothing_holds") == (1 if falls else None)
    assert len(recwarn) == falls
    if falls:
        assert "Neither supports nor contacts hold the system" in str(recwarn[0].message)


def test_a_motion_that_nothing_bounds_ends_with_a_reason():
    """Steps become ever shorter where a motion is huge: without a limit, a run would never end."""
    crossed = np.array([[1.0, 0.4], [-0.4, 1.0]])
    system = RotorSystem(
        mass=np.eye(4), stiffness=np.kron(np.eye(2), crossed), damping=0.1 * np.eye(4),
        nodes={"disc": (0, 1), "free": (2, 3)}, units="1",
    )  # fmt: skip
    around = {"contacts": [Contact(**TOUCH)], "unbalance": [Unbalance(node="free", moment=0.1)]}
    with pytest.raises(SimulationError, match=r"unstable: its motion passed 1e\+30 clearances"):
        simulate(system, **around, speed=1.0, duration=5000.0, samples=5)
    found = sweep(system, **around, speed=1.0).squeeze()
    assert decode_flags(found.response).item() == "failed"
    assert "unstable" in found.message.item()


@pytest.mark.parametrize(
    ("name", "value"),
    [("clearance", 1e-300), ("clearance", 1e300), ("stiffness", 1e300), ("radius", 1e-300)],
)
def test_a_size_that_doubles_cannot_follow_is_refused(name: str, value: float):
    given = {"node": "disc", "clearance": 1e-4, "stiffness": 1e8, "radius": 0.1} | {name: value}
    with pytest.raises(InputError, match=f"{name} of the contact at 'disc' must lie from"):
        Contact(**given)
