"""Events of rotor systems, against witnesses that share nothing with the core's series."""

from dataclasses import replace
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InvariantError,
    Race,
    Rotor,
    RotorSystem,
    SimulationError,
    Stator,
    Unbalance,
    run_up,
    simulate,
)
from rotor_ida.simulation import runs
from rotor_ida.simulation.system_run import run_to_end
from tests.random_systems import followed, random_system

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
ENTRY, EXIT, ROLL, SLIP, REVERSE, PRESS, RELEASE = 1, -1, 2, -2, 3, 4, -4


def test_one_disc_as_a_system_has_the_same_events(monkeypatch):
    """Random rotors, against the core of one disc; 2,000 with `benchmarks/systems.py`."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    assert run_path(str(BENCHMARKS / "systems.py"))["compare"](50) == 0


BY_CVODE = {
    "adams": {"method": "adams"},
    "bdf": {"method": "bdf"},
    "witness": {"method": "adams", "backend": "python"},
}


@pytest.mark.parametrize("by", BY_CVODE)
# In the last two, two contacts roll together under a torque: three forces and rates are implicit.
@pytest.mark.parametrize("seed", [2, 5, 19, 34, 235, 415])
def test_systems_have_the_events_of_cvode(seed, by):
    """Ramps, torques, stators, races, rolling: each event, where each contact is."""
    exact, witness = followed(seed, 10.0), followed(seed, 10.0, rtol=1e-11, **BY_CVODE[by])
    assert exact.sizes["event"] > 3
    np.testing.assert_array_equal(exact.event_kind, witness.event_kind)
    np.testing.assert_array_equal(exact.event_contact, witness.event_contact)
    np.testing.assert_allclose(exact.event_time, witness.event_time, rtol=2e-7)
    for name in ("x", "vy", "normal_force", "tangential_force"):
        scale = np.abs(exact[name]).max().item()
        assert np.abs(exact[name] - witness[name]).max() <= 1e-6 * scale, name
    np.testing.assert_array_equal(exact["mode"], witness["mode"])


def test_many_systems_have_the_events_of_cvode():
    """As far as the events of both runs are sure; the plain-Python witness shares no code."""
    count, slow = 0, BY_CVODE["witness"]
    for seed in range(100, 108):
        exact, other = followed(seed, 10.0), followed(seed, 10.0, rtol=1e-11, **slow)
        horizon = min(exact.horizon.item(), other.horizon.item())
        one, two = (run.isel(event=(run.event_time < horizon).values) for run in (exact, other))
        np.testing.assert_array_equal(one.event_kind, two.event_kind)
        np.testing.assert_array_equal(one.event_contact, two.event_contact)
        np.testing.assert_allclose(one.event_time, two.event_time, rtol=2e-7)
        count += one.sizes["event"]
    assert count > 80


@pytest.mark.parametrize("seed", [78, 410, 434, 454, 578, 628])
def test_the_energy_of_cvode_balances(seed):
    """To the sum of the tolerances of its steps; the events are those of Taylor series."""
    exact = followed(seed, 10.0)
    for method, rtol in (("adams", 1e-8), ("bdf", 1e-8), ("bdf", 1e-10)):
        run = followed(seed, 10.0, method=method, rtol=rtol)
        np.testing.assert_array_equal(run.event_kind, exact.event_kind)
        np.testing.assert_allclose(run.event_time, exact.event_time, rtol=2e-6)


@pytest.mark.parametrize(("method", "missing"), [("taylor", 1e-8), ("adams", 3e-6), ("bdf", 3e-6)])
@pytest.mark.parametrize("seed", [28, 434])
def test_energy_that_is_missing_is_refused(monkeypatch, seed, method, missing):
    """A part of what damping has taken, at a tolerance of 1e-8: 434 touches nothing."""

    def robbed(*args):
        result = run_to_end(*args)
        taken = (1.0 + missing) * result.ledger["damping"]
        return replace(result, ledger={**result.ledger, "damping": taken})

    followed(seed, 10.0, method=method, rtol=1e-8)
    monkeypatch.setattr(runs, "run_to_end", robbed)
    with pytest.raises(InvariantError, match="the energy does not balance"):
        followed(seed, 10.0, method=method, rtol=1e-8)


@pytest.mark.parametrize("method", ["adams", "bdf"])
def test_errors_of_cvode_fall_with_the_tolerance(method):
    """Tenfold and more from a hundredth of the tolerance to the next."""
    exact = followed(5, 10.0, rtol=1e-13).event_time
    apart = [
        np.abs(followed(5, 10.0, method=method, rtol=rtol).event_time - exact).max().item()
        for rtol in (1e-6, 1e-8, 1e-10)
    ]
    assert apart[0] > 10.0 * apart[1] > 100.0 * apart[2]
    assert apart[2] < 1e-7


def rigid_rotor():
    """Return a rigid rotor that nothing holds, on two equal bearings."""
    half = 0.3
    system = RotorSystem(
        mass=np.diag([10.0, 10.0, 0.5, 0.5]), stiffness=np.zeros((4, 4)),
        nodes={"a": [[1, 0, half, 0], [0, 1, 0, half]], "b": [[1, 0, -half, 0], [0, 1, 0, -half]]},
        translations=np.eye(4)[:, :2],
    )  # fmt: skip
    bearing = {"clearance": 2e-4, "stiffness": 1e8, "exponent": 1.0, "damping": 0.5}
    rubbing = {"friction": 0.15, "radius": 0.03}
    return system, [Contact(node=name, **bearing, **rubbing) for name in "ab"]


@pytest.mark.parametrize("speed", [0.0, 1000.0])
def test_contacts_that_begin_and_end_together(speed):
    """A symmetric drop on two bearings: the edges of both are those of one with half the mass."""
    system, contacts = rigid_rotor()
    run = simulate(system, contacts=contacts, speed=speed, gravity=(0, -9.81), duration=0.05)
    kinds, times = run.event_kind.values, run.event_time.values
    assert abs(times[0] / np.sqrt(2 * 2e-4 / 9.81) - 1.0) < 1e-10
    for number in (0, 1):
        own = run.event_contact.values == number
        np.testing.assert_array_equal(kinds[own][:4], [ENTRY, EXIT, ENTRY, EXIT])
    half = RotorSystem(mass=5.0 * np.eye(2), stiffness=np.zeros((2, 2)), nodes={"a": (0, 1)})
    alone = simulate(half, contacts=contacts[:1], speed=speed, gravity=(0, -9.81), duration=0.05)
    own = run.event_contact.values == 0
    np.testing.assert_allclose(times[own], alone.event_time, rtol=1e-9)


def test_a_drop_without_spin_rubs_nothing():
    """Whatever its direction: the tangential force is rounding, and no slip is told of it."""
    system, contacts = rigid_rotor()
    for angle in np.linspace(0.1, 3.0, 7):
        pull = (9.81 * np.cos(angle), 9.81 * np.sin(angle))
        with pytest.warns(UserWarning, match="Neither supports nor contacts hold the system"):
            run = simulate(system, contacts=contacts[:1], speed=0.0, gravity=pull, duration=0.05)
        assert set(run.event_kind.values.tolist()) <= {ENTRY, EXIT, RELEASE, PRESS}


def test_a_start_on_the_stator():
    """It is in contact where gravity presses it, and is not where it is drawn inwards."""
    system, contacts = rigid_rotor()
    at = np.array([0.0, -2e-4, 0.0, 0.0])
    around = {"contacts": contacts, "speed": 100.0, "duration": 1e-3, "start": (at, np.zeros(4))}
    pressed = simulate(system, gravity=(0, -9.81), **around)
    assert pressed.sizes["event"] == 0
    assert (pressed.normal_force[-1] > 0.0).all()
    assert (simulate(system, gravity=(0, 9.81), **around).normal_force == 0.0).all()


def test_more_contacts_that_roll_than_modes_are_refused():
    """Two rings around one node hold it together: no force of each is determined."""
    system = RotorSystem(
        mass=np.eye(2), stiffness=np.zeros((2, 2)), damping=np.eye(2), nodes={"d": (0, 1)},
        static_force=[0.0, -1.0], units="1",
    )  # fmt: skip
    rings = [
        Contact(node="d", clearance=c, stiffness=10.0, friction=2.0, radius=1.0) for c in (1.0, 1.1)
    ]
    with pytest.raises(SimulationError, match="more contacts roll than the system has modes"):
        simulate(system, contacts=rings, speed=0.0, start=([0.0, -1.3], [0, 0]), duration=5.0)


def test_a_ramp_in_pieces_is_the_ramp():
    """A piece that ends inside a contact changes no event but by rounding."""
    system, around = random_system(2)
    whole = run_up(system, speed=0.5, to=1.5, rate=0.1, **around)
    pieces = [(t, 0.5 + 0.1 * t) for t in np.linspace(0.0, 10.0, 8)]
    parts = run_up(system, speeds=pieces, **around)
    np.testing.assert_array_equal(whole.event_kind, parts.event_kind)
    np.testing.assert_allclose(whole.event_time, parts.event_time, rtol=1e-9)


def test_a_settled_start_stays_settled():
    """Without contact the whirl is exact: constant radii, for the length of the run."""
    system, around = random_system(7)
    run = simulate(
        system, unbalance=around["unbalance"], static_force=around["static_force"], speed=1.3,
        start="settled", duration=50.0, samples=401,
    )  # fmt: skip
    assert run.sizes["event"] == 0
    z = (run.x + 1j * run.y).values
    # forwards, backwards and still: three numbers for each node fit all samples
    turn = np.exp(1j * 1.3 * run.t.values)
    parts = np.column_stack([turn, turn.conj(), np.ones_like(turn)])
    left = z - parts @ np.linalg.lstsq(parts, z, rcond=None)[0]
    assert np.abs(left).max() < 1e-11 * np.abs(z).max()


def on_a_stator(mass, friction, *, race=None, damping=0.4, **how):
    """Return a run of two discs, one in a stator of a mass and one on the ground."""
    rng = np.random.default_rng(3)
    bent = rng.normal(size=(4, 4))
    system = RotorSystem(
        mass=np.eye(4), stiffness=np.eye(4) + 0.1 * bent @ bent.T, damping=0.05 * np.eye(4),
        nodes={"a": (0, 1), "b": (2, 3)}, units="1",
    )  # fmt: skip
    stator = Stator(mass=mass, stiffness=(3.0, 5.0), damping=0.8)
    contacts = [
        Contact(
            node="a", clearance=0.5, stiffness=20.0, damping=damping, friction=friction, radius=2.0,
            stator=stator, race=race,
        ),
        Contact(node="b", clearance=0.6, stiffness=15.0, friction=friction, radius=1.0),
    ]  # fmt: skip
    unbalance = [Unbalance(node="a", moment=0.5), Unbalance(node="b", moment=0.3, phase=1.0)]
    start = 0.2 * rng.normal(size=4), 0.5 * rng.normal(size=4)
    return simulate(
        system, contacts=contacts, unbalance=unbalance, speed=1.1, duration=10.0, samples=31,
        start=start, **how,
    )  # fmt: skip


@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0])
def test_a_stator_without_mass_is_the_limit_of_light_ones(friction):
    """The events move by the mass: a tenth of it moves them a tenth as far."""
    race = Race(radius=1.5, inertia=0.3, drag=0.05)
    runs = [on_a_stator(mass, friction, race=race) for mass in (0.0, 1e-3, 1e-4)]
    for other in runs[1:]:
        np.testing.assert_array_equal(other.event_kind, runs[0].event_kind)
    assert runs[0].sizes["event"] >= 9
    apart = [np.abs(other.event_time - runs[0].event_time).max().item() for other in runs[1:]]
    assert apart[1] < 5e-4
    assert apart[0] / apart[1] == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize(("friction", "damping"), [(0.0, 0.0), (0.3, 1.5), (1.0, 0.4)])
def test_events_on_a_stator_without_mass_are_those_of_cvode(friction, damping):
    runs = [
        on_a_stator(0.0, friction, damping=damping, **how)
        for how in ({}, {"method": "adams", "rtol": 1e-11})
    ]
    np.testing.assert_array_equal(runs[0].event_kind, runs[1].event_kind)
    for name in ("event_time", "event_state", "normal_force", "tangential_force", "final_state"):
        scale = np.abs(runs[0][name]).max().item()
        assert np.abs(runs[0][name] - runs[1][name]).max() <= 1e-6 * scale, name


def test_energy_of_a_free_rotor_on_a_moving_stator_is_kept():
    """Without damping, friction and unbalance, over hundreds of bounces."""
    stator = Stator(mass=0.7, stiffness=3.0)
    system = RotorSystem(mass=np.eye(2), stiffness=0.3 * np.eye(2), nodes={"d": (0, 1)}, units="1")
    contact = Contact(node="d", clearance=0.5, stiffness=20.0, stator=stator)
    run = simulate(
        system, contacts=[contact], speed=0.0, start=([0.1, 0.0], [1.0, 0.7]), duration=300.0,
        rtol=1e-12,
    )  # fmt: skip
    assert run.sizes["event"] > 200
    x, y, px, py = run.final_state.values[[0, 1, 4, 5]]
    sx, sy, qx, qy = run.final_state.values[[2, 3, 6, 7]]
    depth = max(np.hypot(x - sx, y - sy) - 0.5, 0.0)
    energy = 0.5 * (px**2 + py**2) + 0.15 * (x**2 + y**2) + 0.35 * (qx**2 + qy**2)
    energy += 1.5 * (sx**2 + sy**2) + 8.0 * depth**2.5
    assert energy == pytest.approx(0.5 * 1.49 + 0.15 * 0.01, rel=1e-11)


@pytest.mark.parametrize("early", [1e-2, 1e-3, 3e-4])
def test_a_run_that_ends_just_before_an_exit_ends_there(early):
    """Behind an exit the time of the contact's series falls again: its end is not taken there."""
    system = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
    given = {"speed": 2.0}
    whole = simulate(system, **given, duration=40.0)
    exits = whole.event_time.values[whole.event_kind.values == EXIT][:8]
    ends = exits - early
    long = simulate(system, **given, duration=40.0, samples=np.append(ends, 40.0))
    for number, end in enumerate(ends):
        short = simulate(system, **given, duration=end)
        assert (short.event_time <= end).all()
        assert int(short.event_kind[-1]) == ENTRY
        here = long.isel(t=number, node=0)
        assert float(short.x[-1, 0]) == pytest.approx(float(here.x), abs=1e-10)
        assert float(short.vx[-1, 0]) == pytest.approx(float(here.vx), abs=1e-10)


HELD = {"speed": 1.3, "duration": 60.0}
DRIVEN = HELD | {"torque": (0.01, 0.0), "inertia": 3.0}


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize(
    ("count", "friction", "is_damped", "verb", "course"),
    [
        (26, 0.0, True, simulate, HELD),
        (26, 0.0, False, simulate, HELD),
        (26, 0.2, True, run_up, {"speed": 1.2, "to": 1.5, "rate": 0.005}),
        (7, 0.2, False, run_up, DRIVEN),
        (14, 0.2, True, run_up, DRIVEN),
        (26, 0.2, True, run_up, DRIVEN),
    ],
)
def test_any_coordinates_give_the_same_events(exponent, count, friction, is_damped, verb, course):
    """By modes the stiffness is a diagonal, for which the core has a way of its own."""
    rng = np.random.default_rng(4)
    turn = np.linalg.qr(rng.normal(size=(count, count)))[0]
    shapes = rng.normal(size=(2, count)) / np.arange(1, count + 1)
    stiffness = np.diag(np.linspace(1.0, 7.0, count) ** 2)
    damping = 0.05 * stiffness + 0.1 * shapes.T @ shapes if is_damped else None
    across = 0.1 * rng.normal(size=(count, count))
    found = [
        verb(
            RotorSystem(
                mass=np.eye(count), stiffness=basis.T @ stiffness @ basis, units="1",
                damping=None if damping is None else basis.T @ damping @ basis,
                gyroscopic=basis.T @ (across - across.T) @ basis if friction else None,
                nodes={"disc": shapes @ basis},
                contacts=[Contact(node="disc", clearance=0.3, stiffness=20.0, exponent=exponent,
                                  friction=friction, radius=1.0)],
                unbalance=[Unbalance(node="disc", moment=0.15)],
            ),
            **course, samples=2,
        )
        for basis in (np.eye(count), turn)
    ]  # fmt: skip
    modal, turned = found
    assert modal.event_time.size > 10
    sure = modal.event_time_error.values < 1e-9
    assert sure[:6].all()
    np.testing.assert_array_equal(modal.event_kind[sure], turned.event_kind[sure])
    np.testing.assert_allclose(modal.event_time[sure], turned.event_time[sure], atol=1e-9)
