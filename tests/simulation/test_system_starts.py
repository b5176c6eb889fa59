"""A rotor system at rest in its supports and contacts, against statics by hand."""

import numpy as np
import pytest

from rotor_ida import Contact, InputError, RotorSystem, Stator, Unbalance, simulate
from tests.random_systems import random_system

G = 9.81
STILL = {"speed": 0.0, "gravity": (0.0, -G), "start": "rest", "duration": 0.2, "samples": 41}


def moved(run):
    """Return how far a run moves from its start, relative to how far that is from 0."""
    z = run.x + 1j * run.y
    return (np.abs(z - z.isel(t=0)).max() / np.abs(z).max()).item()


def at_rest(system, contacts, **options):
    """Return where a system rests; it must stay there."""
    run = simulate(system, contacts=contacts, **STILL | options)
    first = run.isel(t=0)
    assert moved(run) < 1e-9
    return first


@pytest.mark.parametrize("speed", [300.0, -300.0])
def test_a_disc_that_spins_in_friction_climbs_its_bearing(speed):
    """By ``atan(mu)``, against its spin, where the normal force is ``m g/sqrt(1 + mu**2)``."""
    system = RotorSystem(
        mass=12.0 * np.eye(2), stiffness=np.zeros((2, 2)), damping=5e3 * np.eye(2),
        nodes={"disc": (0, 1)},
    )  # fmt: skip
    contact = Contact(node="disc", clearance=2e-4, stiffness=1e8, friction=0.4, radius=0.05)
    place = at_rest(system, [contact], speed=speed)
    angle = np.arctan2(place.y.item(), place.x.item()) + 0.5 * np.pi
    assert angle == pytest.approx(-np.sign(speed) * np.arctan(0.4), rel=1e-9)
    assert place.normal_force.item() == pytest.approx(12.0 * G / np.hypot(1.0, 0.4), rel=1e-9)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_a_free_disc_lies_in_its_bearing(exponent):
    system = RotorSystem(mass=12.0 * np.eye(2), stiffness=np.zeros((2, 2)), nodes={"disc": (0, 1)})
    contact = Contact(
        node="disc", clearance=2e-4, stiffness=1e8, exponent=exponent, centre=(0.0, 5e-5)
    )
    place = at_rest(system, [contact])
    pressed = (12.0 * G / 1e8) ** (1.0 / exponent)
    assert place.y.item() == pytest.approx(5e-5 - 2e-4 - pressed, rel=1e-10)
    assert abs(place.x.item()) < 1e-12
    assert place.normal_force.item() == pytest.approx(12.0 * G, rel=1e-9)


def test_a_rigid_rotor_lies_in_two_bearings_by_the_lever():
    """Coordinates are the displacements at its ends; its weight acts a quarter of the way along."""
    turn = np.array([[0.75, 0.25], [-1.0, 1.0]])  # of the centre, and the tilt, by both ends
    mass = turn.T @ np.diag([20.0, 0.8]) @ turn
    system = RotorSystem(
        mass=np.kron(mass, np.eye(2)), stiffness=np.zeros((4, 4)),
        nodes={"left": (0, 1), "right": (2, 3)},
    )  # fmt: skip
    stator = Stator(mass=1.5, stiffness=3e7, damping=2e3)
    contacts = [
        Contact(node="left", clearance=2e-4, stiffness=1e8, exponent=1.0),
        Contact(node="right", clearance=3e-4, stiffness=2e9, stator=stator),
    ]
    place = at_rest(system, contacts)
    loads = 20.0 * G * np.array([0.75, 0.25])
    np.testing.assert_allclose(place.normal_force, loads, rtol=1e-9)
    sag = (1.5 * G + loads[1]) / 3e7
    expected = [-2e-4 - loads[0] / 1e8, -3e-4 - (loads[1] / 2e9) ** (1 / 1.5) - sag]
    np.testing.assert_allclose(place.y, expected, rtol=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_forces_of_random_systems_balance(seed):
    system, options = random_system(seed)
    still = {name: options[name] for name in ("contacts", "gravity") if name in options}
    weight = {"gravity": (1.0, -3.0), **still}
    run = simulate(system, speed=0.0, start="rest", duration=0.1, samples=3, **weight)
    assert moved(run) < 1e-9


def test_what_nothing_holds_has_no_rest():
    system = RotorSystem(mass=np.eye(2), stiffness=np.zeros((2, 2)), nodes={"disc": (0, 1)})
    with pytest.raises(InputError, match="start cannot be at rest, as neither supports nor"):
        simulate(system, **STILL)


def test_a_rotor_that_turns_freely_about_its_axis_begins_on_its_whirl():
    """Torsion, as of six degrees of freedom a node: no spring holds it, and no force acts."""
    held, free = np.diag([4e6, 4e6]), 1e5 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    system = RotorSystem(
        mass=np.diag([12.0, 12.0, 0.1, 0.1]), nodes={"disc": (0, 1)},
        stiffness=np.block([[held, np.zeros((2, 2))], [np.zeros((2, 2)), free]]),
    )  # fmt: skip
    case = {"unbalance": [Unbalance(node="disc", moment=1e-3)], "start": "settled",
            "duration": 0.05, "samples": 101}  # fmt: skip
    run = simulate(system, speed=300.0, gravity=(0.0, -G), **case)
    whirl = 1e-3 * 300.0**2 / (4e6 - 12.0 * 300.0**2) * np.exp(300j * run.t.values)
    place = run.x.values[:, 0] + 1j * (run.y.values[:, 0] + 12.0 * G / 4e6)
    np.testing.assert_allclose(place, whirl, rtol=0, atol=1e-9 * np.abs(whirl).max())
    assert not simulate(system, speed=0.0, **case).x.any()
    with pytest.raises(InputError, match="does not hold the system against its constant forces"):
        simulate(system, speed=300.0, static_force=[0.0, 0.0, 1.0, 0.0], **case)
