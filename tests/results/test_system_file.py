"""A system in a file is that of Python, and what is wrong in a file is named by table and key."""

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    Race,
    RotorSystem,
    Stator,
    Unbalance,
    load_course,
    load_system,
    run_up,
    simulate,
)
from rotor_ida.model.rotor_system import levitated_system
from rotor_ida.results.system_file import __doc__ as documented
from rotor_ida.results.system_file import read_system_file

RPM = np.pi / 30.0
CHAIN = np.array([[8e6, -4e6], [-4e6, 6e6]])
SMALL = (
    "system = { mass = [4, 4, 4, 4], stiffness = [1e5, 1e5, 1e5, 1e5], "
    "nodes = { disc = [0, 1], end = [2, 3] } }\n"
)
TOUCH = '[[contacts]]\nnode = "disc"\nclearance = "60 um"\nstiffness = "1e7 N/m"\n'


@pytest.fixture
def load(tmp_path):
    """Return a function that reads a text as a system file: its system and its course."""

    def of(text):
        place = tmp_path / "rotor.toml"
        place.write_text(text)
        return read_system_file(place)

    return of


def example():
    return "\n".join(line[4:] for line in documented.splitlines() if line.startswith("    "))


def test_the_documented_file_runs_as_in_python_to_the_bit(load, tmp_path):
    load(example())
    place = tmp_path / "rotor.toml"
    read, course = load_system(place), load_course(place)
    seal = Contact(
        node="seal", clearance=150e-6, stiffness=5e7, exponent=1.0, friction=0.1, radius=0.05,
        stator=Stator(mass=20.0, stiffness=1e7, damping=2000.0),
    )  # fmt: skip
    system = RotorSystem(
        mass=np.diag([12.0, 12.0, 8.0, 8.0]), stiffness=np.kron(CHAIN, np.eye(2)),
        damping=np.kron(2e-4 * CHAIN, np.eye(2)), nodes={"disc": (0, 1), "seal": (2, 3)},
        contacts=[seal], gravity=(0.0, -9.81),
        unbalance=[Unbalance(node="disc", moment=1.2e-3, phase=np.pi / 2)],
    )  # fmt: skip
    assert course.start is None
    one = simulate(read, start="rest", speed=course.speed, duration=0.1)
    other = simulate(system, start="rest", speed=4300 * RPM, duration=0.1)
    assert one.sizes["event"] > 4
    assert one.equals(other)
    assert course.run_up == {"speed": 600 * RPM, "to": 6000 * RPM, "ramp_time": 5.0}
    short = course.run_up | {"to": 700 * RPM, "ramp_time": 0.1}
    one = run_up(read, **course.motion, **short, samples=3)
    rate = (700 * RPM - 600 * RPM) / 0.1
    other = run_up(system, start="rest", speed=600 * RPM, to=700 * RPM, rate=rate, samples=3)
    assert one.equals(other)


def test_a_file_may_begin_with_the_mark_of_some_editors(load):
    assert load("\ufeffspeed = 3\n" + SMALL + TOUCH)[1].speed == 3.0


def test_matrices_are_read_from_the_folder_of_the_file(load, tmp_path):
    np.savez(tmp_path / "rotor.npz", M=np.eye(4), K=CHAIN[0, 0] * np.eye(4), node_disc=[0, 1])
    system, course = load(
        'modes = 2\n[system]\nfile = "rotor.npz"\nnodes = { end = [2, 3] }\n'
        'positions = { disc = "10 cm", end = 0.3 }'
    )
    assert dict(system.nodes) == {"disc": (0, 1), "end": (2, 3)}
    assert dict(system.positions) == {"disc": 0.1, "end": 0.3}
    assert course.motion == {"start": None, "modes": 2, "more_modes": None}
    np.testing.assert_array_equal(system.mass, np.eye(4))


def test_stators_and_races_are_shared_by_name_or_a_table_of_one_contact(load):
    system, _ = load(
        SMALL
        + """
        [stators.housing]
        mass = "9 kg"
        stiffness = ["1 N/um", "2 N/um"]
        weight = false
        """
        + TOUCH
        + 'stator = "housing"\n'
        + TOUCH.replace("disc", "end")
        + 'stator = "housing"\n'
        + TOUCH
        + 'stator = "end"\ncentre = ["10 um", "-5 um"]\n[contacts.race]\nradius = "30 mm"\n'
        'inertia = "2 kg m2"\nspeed = "60 rpm"\n'
    )
    first, second, third = system.contacts
    assert first.stator is second.stator
    assert (first.stator.stiffness, first.stator.weight) == ((1e6, 2e6), False)
    assert (third.stator, third.centre) == ("end", (1e-5, -5e-6))
    assert third.race == Race(radius=0.03, inertia=2.0, speed=60 * RPM)


def test_a_static_force_acts_on_nodes_or_on_coordinates(load):
    by_node, _ = load(SMALL + '[static_force]\nend = ["0 N", "-2 kN"]')
    by_coordinate, _ = load("static_force = [0, 0, 0, -2000]\n" + SMALL)
    np.testing.assert_array_equal(by_node.static_force, [0.0, 0.0, 0.0, -2000.0])
    np.testing.assert_array_equal(by_coordinate.static_force, by_node.static_force)


LEVITATED = 'supports = [ { node = "disc", stiffness = [5e5, 7e5], damping = 30 } ]\n'


def test_supports_are_part_of_the_system(load):
    """Springs, dampers, and the static load that keeps their node at the centre under gravity."""
    system, _ = load(LEVITATED + "gravity = [0, -9.81]\n" + SMALL)
    assert system.damping is None
    held, added = levitated_system(system), np.diag([5e5, 7e5, 0.0, 0.0])
    np.testing.assert_array_equal(held.stiffness, system.stiffness + added)
    np.testing.assert_array_equal(held.damping, np.diag([30.0, 30.0, 0.0, 0.0]))
    np.testing.assert_allclose(held.static_force, [0, 4 * 9.81, 0, 0], atol=1e-9)
    run = simulate(system, start="rest", speed=100.0, duration=0.01)
    np.testing.assert_allclose(run["y"][-1], [0.0, -4 * 9.81 / 1e5], atol=1e-12)
    assert levitated_system(load(LEVITATED + SMALL)[0]).static_force is None


def test_starts_and_changes_of_speed(load):
    assert load('start = "settled"\n' + SMALL)[1].start == "settled"
    q, velocity = load("start = { q = [1, 0, 0, 0], velocity = [0, 0, 0, 2] }\n" + SMALL)[1].start
    assert (q[0], velocity[3]) == (1.0, 2.0)
    change = load(SMALL + 'run_up = { speeds = [[0, "60 rpm"], ["2 s", 8]] }')[1].run_up
    assert change == {"speeds": [(0.0, 60 * RPM), (2.0, 8.0)]}
    drive = 'run_up = { torque = ["3 N m", 0.5], inertia = "2 kg m2", duration = "900 ms" }'
    assert load(SMALL + drive)[1].run_up == {
        "speed": 0.0, "torque": (3.0, 0.5), "inertia": 2.0, "duration": 0.9,
    }  # fmt: skip


def test_a_dimensionless_file_takes_no_units(load):
    assert load('units = "1"\nspeed = 1.5\n' + SMALL)[0].units == "1"
    with pytest.raises(InputError, match=r"rotor.toml: the unit of speed must be left out, got '6"):
        load('units = "1"\nspeed = "60 rpm"\n' + SMALL)


MISTAKES = [
    ("", "system must be given"),
    ("mass = 12\nclearance = 1e-4", "got the file of a machine: give it with --machine"),
    (SMALL + "sped = 3", "a system file must have entries named .*got 'sped'; did you mean 'sp"),
    (SMALL + 'units = "inch"', "units must be one of 'SI', '1', got 'inch'"),
    (SMALL + 'speed = "60 um"', "the unit of speed must be rad/s, rpm or Hz, got '60 um'"),
    (SMALL + 'gravity = "9.81 m/s2"', "gravity must be two numbers, got '9.81 m/s2'"),
    (SMALL + '[[unbalance]]\nnode = "end"\nmoment = "200 gm"',
     "moment must be kg m, g mm or oz in, got '200 gm'; did you mean 'g m' or 'g mm'"),
    (SMALL + "modes = 2.5", "modes must be a whole number, got 2.5"),
    (SMALL + 'start = "fall"',
     "start must be 'settled', 'rest' or a table of q and velocity, got 'fall'"),
    (SMALL + "start = { q = [0, 0, 0, 0] }", "start.velocity must be given"),
    (SMALL + "static_force = { dsc = [1, 2] }", "static_force: node must be one of .*'disc'\\?"),
    ("system = 3", "system must be a table, got 3"),
    ("system = { mass = [1, 1] }", "system.stiffness and system.nodes must be given"),
    ("system = { file = 'gone.npz' }", "system.file: cannot read the system .*gone.npz.*No such"),
    (
        "system = { file = 'gone.npz', mass = [1] }",
        "system must have entries named file, nodes or positions",
    ),
    ("system = { file = 3 }", "system.file must be the path of a file, got 3"),
    (SMALL.replace("[4, 4, 4, 4]", "[4, 4, 4, -4]"), "system: mass must be positive definite"),
    (SMALL + "contacts = 3", r"contacts must be tables \[\[contacts\]\], got 3"),
    (SMALL + TOUCH + "gap = 3", r"contacts\[0\] must have entries named node, .*got 'gap'"),
    (SMALL + TOUCH.replace("disc", "dics"), r"contacts\[0\]: node must be one of .*did you mean"),
    (SMALL + TOUCH.replace('"disc"', "[1]"), r"contacts\[0\]: node must be the name of a node"),
    (SMALL + TOUCH.replace("60 um", "60 kg"), r"the unit of contacts\[0\].clearance must be m, mm"),
    (SMALL + TOUCH + "exponent = 1.5", r"the unit of contacts\[0\].stiffness must be N/m\^1.5 "),
    (SMALL + TOUCH + "friction = 0.1", r"contacts\[0\]: radius of the contact at 'disc' must be"),
    (SMALL + TOUCH + 'stator = "ground"', r"contacts\[0\].stator must be a table or one of 'disc'"),
    (SMALL + TOUCH + "stator = { mass = 1 }", r"contacts\[0\].stator.stiffness must be given"),
    (SMALL + TOUCH + "race = { radius = 1, inertia = 0 }", r"contacts\[0\].race: inertia of a"),
    (SMALL + "stators.cup = { mass = 1, stiffness = 1 }", "stators.cup must be the stator of a"),
    (SMALL + "stators.end = { mass = 1, stiffness = 1 }\n" + TOUCH + 'stator = "end"',
     r"contacts\[0\].stator must name one thing, got 'end', a node and a stator"),
    (SMALL + '[[unbalance]]\nnode = "disc"\nmoment = "1 kg"', r"the unit of unbalance\[0\].moment"),
    (SMALL + "run_up = { speed = 3 }", "run_up must have entries named from, .*got 'speed'"),
    (SMALL + "run_up = { speeds = 3 }", "run_up.speeds must be pairs of time and speed, got 3"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "words"), MISTAKES)
def test_a_mistake_is_named_in_one_line(load, text, words):
    with pytest.raises(InputError, match=rf"rotor\.toml: .*{words}") as refusal:
        load(text)
    assert "\n" not in str(refusal.value)


def test_a_node_in_both_files_is_refused(load, tmp_path):
    np.savez(tmp_path / "rotor.npz", M=np.eye(2), K=np.eye(2), node_disc=[0, 1])
    with pytest.raises(InputError, match=r"system.nodes.disc must be left out: the file has this"):
        load('[system]\nfile = "rotor.npz"\nnodes = { disc = [0, 1] }')
