"""Sections through motions of rotor systems: those of one disc, of runs, and of closed forms."""

import math

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    lyapunov_exponent,
    poincare_section,
    simulate,
)
from rotor_ida.verification.verify import differences, rerun
from tests.rotors import WHIP

NAMES = ("rotating_x", "rotating_y", "rotating_vx", "rotating_vy")
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
LOADED = Rotor(omega=2.0, zeta=0.05, delta0=1.0, shaft_stiffness=0.25, load=0.6)
KNOCKED = (5.0, 0.0, 0.0, -6.3)
AT_KNOCK = (np.array([5.0, 0.0]), np.array([0.0, -6.3]))


def states(section):
    return np.stack([section[name].values for name in NAMES], axis=-1)


def chain(stiffer=1.0, **around):
    """Return two discs in a chain; other stiffnesses along y make it unsymmetric."""
    stiffness = np.kron([[2.0, -1.0], [-1.0, 2.0]], np.diag([1.0, stiffer]))
    return RotorSystem(
        mass=np.diag([1.0, 1.0, 2.0, 2.0]), stiffness=stiffness, damping=0.1 * stiffness,
        nodes={"one": (0, 1), "two": (2, 3)}, units="1",
        **{"unbalance": [Unbalance(node="one", moment=0.4, phase=0.3)], **around},
    )  # fmt: skip


TOUCHING, RUBBING = (
    chain(contacts=[
        Contact(node="one", clearance=3.0, stiffness=3.0, exponent=1.0),
        Contact(node="two", clearance=0.4, stiffness=stiffness, friction=friction, radius=1.0),
    ])
    for stiffness, friction in ((3.0, 0.1), (30.0, 0.3))
)  # fmt: skip


def response(system, speed):
    """Return the whirls ``a exp(i w t) + conj(b exp(i w t))`` of the nodes, by complex forces."""
    (unbalance,) = system.unbalance
    force = np.zeros(4, complex)
    x, y = 2 * [*system.nodes].index(unbalance.node) + np.arange(2)
    force[[x, y]] = unbalance.moment * speed**2 * np.exp(1j * unbalance.phase) * np.array([1, -1j])
    dynamic = system.stiffness - speed**2 * system.mass + 1j * speed * system.damping
    q = np.linalg.solve(dynamic, force).reshape(2, 2)
    return 0.5 * (q[:, 0] + 1j * q[:, 1]), 0.5 * (q[:, 0] - 1j * q[:, 1])


@pytest.mark.parametrize("at", ["revolution", "entry", "exit", "peak"])
def test_one_disc_as_a_system_has_the_section_of_the_disc(at):
    """To the errors of both motions, which neither grow nor die here."""
    disc = poincare_section(BOUNCING, revolutions=25, skip=5, at=at, method="taylor")
    system = poincare_section(BOUNCING.system(), speed=2.0, revolutions=25, skip=5, at=at)
    assert system.rotating_x.dims == ("crossing", "node")
    assert system.sizes["crossing"] == disc.sizes["crossing"] > 10
    np.testing.assert_allclose(system.crossing_time, disc.crossing_time, atol=1e-8)
    np.testing.assert_allclose(states(system)[:, 0], states(disc), atol=1e-8)


@pytest.mark.parametrize("at", ["roll", "slip", "peak"])
def test_so_has_one_that_rolls(at):
    disc = poincare_section(WHIP, start=KNOCKED, revolutions=4, at=at, method="taylor")
    system = poincare_section(WHIP.system(), speed=WHIP.omega, start=AT_KNOCK, revolutions=4, at=at)
    assert system.sizes["crossing"] == disc.sizes["crossing"] > 5
    np.testing.assert_allclose(system.crossing_time, disc.crossing_time, atol=1e-8)
    np.testing.assert_allclose(states(system)[:, 0], states(disc), atol=1e-7)


@pytest.mark.parametrize(("at", "kind"), [("entry", 1), ("exit", -1), ("slip", -2), ("reverse", 3)])
def test_events_are_those_of_the_simulation_at_the_contact_that_is_named(at, kind):
    section = poincare_section(RUBBING, speed=1.5, revolutions=30, at=at, contact="two")
    run = simulate(RUBBING, speed=1.5, duration=30 * 2.0 * math.pi / 1.5, samples=2)
    chosen = (run.event_kind.values == kind) & (run.event_contact.values == 1)
    assert chosen.sum() > 3
    np.testing.assert_array_equal(section.crossing_time, run.event_time[chosen])
    np.testing.assert_array_equal(section.crossing_state, run.event_state[chosen])
    turned = section.rotating_x.values + 1j * section.rotating_y.values
    fixed = turned * np.exp(1.5j * section.crossing_time.values[:, None])
    q = section.crossing_state.values[:, :4]
    np.testing.assert_allclose(fixed, q[:, [0, 2]] + 1j * q[:, [1, 3]], atol=1e-12)
    assert section.attrs["contact"] == 1
    np.testing.assert_allclose(section.final_state, run.final_state, atol=1e-12)


@pytest.mark.parametrize("speed", [1.3, -1.3])
def test_a_linear_response_is_one_point_at_each_node(speed):
    """That of the complex equations, also where the rotor spins backwards."""
    system = chain()
    whirl, _ = response(system, 1.3)
    section = poincare_section(system, speed=speed, start="settled", revolutions=5)
    point = section.rotating_x.values + 1j * section.rotating_y.values
    np.testing.assert_allclose(point - point[0], 0.0, atol=1e-12)
    if speed > 0.0:
        np.testing.assert_allclose(point[0], whirl, atol=1e-12)
        assert section.rotating_vx.values[0] + 1j * section.rotating_vy.values[0] == pytest.approx(
            1.3j * whirl
        )
    period = 2.0 * math.pi / 1.3
    np.testing.assert_allclose(section.crossing_time, period * np.arange(6), rtol=1e-14)


@pytest.mark.parametrize("speed", [1.3, -1.3])
@pytest.mark.parametrize("phase", [0.5, 4.0])
def test_a_section_is_where_the_unbalance_points_at_the_angle_that_is_named(speed, phase):
    """In an unsymmetric system it depends on that; states are samples of a run."""
    system = chain(stiffer=1.5)
    section = poincare_section(system, speed=speed, revolutions=6, phase=phase)
    times = section.crossing_time.values
    assert times.size == 6
    np.testing.assert_allclose(np.exp(1j * speed * times), np.exp(1j * phase), atol=1e-12)
    assert ((times > 0.0) & (times < 6 * 2.0 * math.pi / 1.3)).all()
    run = simulate(system, speed=speed, duration=30.0, samples=np.append(times, 30.0))
    turned = (run.x + 1j * run.y).values[:-1] * np.exp(-1j * phase)
    np.testing.assert_allclose(section.rotating_x + 1j * section.rotating_y, turned, atol=1e-10)
    turned = (run.vx + 1j * run.vy).values[:-1] * np.exp(-1j * phase)
    np.testing.assert_allclose(section.rotating_vx + 1j * section.rotating_vy, turned, atol=1e-10)


def test_peaks_of_an_ellipse_are_its_major_axis_twice_a_revolution():
    """``|a| + |b|``, when ``a exp(i w t)`` and ``conj(b exp(i w t))`` have one direction."""
    far = Contact(node="two", clearance=50.0, stiffness=3.0)
    system = chain(stiffer=1.5, contacts=[far])
    forward, backward = (each[1] for each in response(system, 1.3))
    section = poincare_section(system, speed=1.3, start="settled", revolutions=5, at="peak")
    radius = np.hypot(section.rotating_x, section.rotating_y).sel(node="two")
    np.testing.assert_allclose(radius, abs(forward) + abs(backward), rtol=1e-12)
    angle = -0.5 * np.angle(forward * backward)  # of the unbalance there, or half a turn on
    expected = np.sort((angle + math.pi * np.arange(-2, 20)) / 1.3)
    expected = expected[(expected > 0.0) & (expected < 10.0 * math.pi / 1.3)]
    np.testing.assert_allclose(section.crossing_time, expected, atol=1e-11)


def test_a_constant_radius_has_no_peaks_and_one_without_contacts_no_events():
    system = chain(contacts=[Contact(node="two", clearance=50.0, stiffness=3.0)])
    given = {"speed": 1.3, "start": "settled", "revolutions": 5}
    assert poincare_section(system, **given, at="peak").sizes["crossing"] == 0
    assert poincare_section(system, **given, at="entry").sizes["crossing"] == 0


def test_a_section_goes_on_from_where_another_ends():
    whole = poincare_section(TOUCHING, speed=1.1, revolutions=12)
    first = poincare_section(TOUCHING, speed=1.1, revolutions=5)
    rest = poincare_section(TOUCHING, speed=1.1, start=first, revolutions=7)
    np.testing.assert_allclose(states(rest), states(whole)[5:], atol=1e-8)
    skipped = poincare_section(TOUCHING, speed=1.1, revolutions=7, skip=5)
    np.testing.assert_allclose(states(skipped), states(whole)[5:], atol=1e-8)
    np.testing.assert_allclose(skipped.crossing_time, whole.crossing_time[5:], rtol=1e-14)


def test_peaks_of_contacts_that_are_shorter_than_samples_are_found():
    """A hard stator: contacts last about a hundredth of a revolution."""
    system = chain(contacts=[Contact(node="two", clearance=0.4, stiffness=1e6)])
    run = simulate(system, speed=1.1, duration=20 * 2.0 * math.pi / 1.1, samples=2)
    assert run.contact_duration.median() < 0.02 * 2.0 * math.pi / 1.1
    section = poincare_section(system, speed=1.1, revolutions=20, at="peak")
    for time in run.peak_time.values:
        assert np.abs(section.crossing_time.values - time).min() < 1e-9


def test_modes_are_those_of_the_reduced_system():
    section = poincare_section(TOUCHING, speed=1.1, revolutions=4, modes=1)
    reduced = TOUCHING.reduced(modes=1)
    exponents, expected = (
        lyapunov_exponent(
            each, speed=1.1, transient=1, revolutions=80, batches=4, exponents=2, **few
        )
        for each, few in ((TOUCHING, {"modes": 1}), (reduced, {}))
    )
    np.testing.assert_allclose(exponents.lyapunov_exponent, expected.lyapunov_exponent, rtol=1e-8)
    np.testing.assert_allclose(
        states(section), states(poincare_section(reduced, speed=1.1, revolutions=4)), atol=1e-12
    )
    assert differences(rerun(section), section)["agrees"]
    start = (np.array([0.1, 0.0, -0.2, 0.1]), np.zeros(4))
    moved = poincare_section(TOUCHING, speed=1.1, revolutions=4, modes=1, start=start)
    assert differences(rerun(moved), moved)["agrees"]
    assert np.abs(states(moved) - states(section)).max() > 0.01
    with pytest.raises(InputError, match=r"start must be .* with modes, got a result and 1"):
        poincare_section(TOUCHING, speed=1.1, revolutions=4, modes=1, start=section)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"speed": None}, "speed must be given for a section of a rotor system, got None"),
        ({"speed": 0.0}, "speed must not be 0 for a section, got 0.0"),
        ({"at": "apex"}, "at must be one of 'revolution', 'entry', 'exit', 'peak'"),
        ({"at": "entry"}, "contact must be given for a section at each entry: 0 at 'one' or 1 at"),
        ({"at": "entry", "contact": "three"}, "contact must be 'one' or 'two', got 'three'"),
        ({"at": "entry", "contact": 2}, "contact must be at most 1, got 2"),
        ({"at": "roll", "contact": "one"}, "friction must be positive for a section at each roll"),
        ({"contact": "one"}, "contact must be left out for a section once a revolution, got 'one'"),
        ({"phase": 1.0, "at": "peak", "contact": 0}, "phase must be 0 for a section at each peak"),
        ({"phase": 7.0}, "phase must be below 2 pi, got 7.0"),
        ({"revolutions": 0}, "revolutions must be at least 1, got 0"),
        (
            {"speed": 1e-3, "skip": 10**6},
            "skip and revolutions must last at most .* fewer modes lower",
        ),
        ({"method": "adams"}, "method must be taylor for a section of a rotor system, got 'adams'"),
        ({"atol": 1e-9}, "atol must be left out with a rotor system, got 1e-09"),
        ({"rtol": 1.0}, "rtol must lie from 1e-14 to 0.0001, got 1.0"),
        ({"contacts": [], "at": "exit"}, "at must be revolution for a system without contacts"),
    ],
)
def test_bad_input_is_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        poincare_section(TOUCHING, **{"speed": 1.1, "revolutions": 2, **wrong})


def test_two_contacts_at_a_node_are_told_apart_by_number():
    both = [Contact(node="two", clearance=gap, stiffness=3.0) for gap in (0.4, 0.5)]
    given = {"speed": 1.1, "revolutions": 5, "contacts": both, "at": "entry"}
    with pytest.raises(InputError, match="contact must be a number, as 'two' has 2 contacts"):
        poincare_section(chain(), **given, contact="two")
    first, second = (poincare_section(chain(), **given, contact=number) for number in (0, 1))
    for section, gap in ((first, 0.4), (second, 0.5)):
        radius = np.hypot(section.rotating_x, section.rotating_y).sel(node="two")
        np.testing.assert_allclose(radius, gap, rtol=1e-12)
        assert radius.size


@pytest.mark.parametrize("name", ["speed", "contact", "modes", "contacts"])
def test_what_is_of_systems_is_refused_with_one_disc(name):
    with pytest.raises(InputError, match=f"{name} must be left out with one disc, got 1"):
        poincare_section(BOUNCING, revolutions=2, **{name: 1})
    with pytest.raises(TypeError, match="unexpected keyword argument 'contcts'"):
        poincare_section(BOUNCING, revolutions=2, contcts=1)
    with pytest.raises(InputError, match="takes a Rotor, DimensionalRotor or RotorSystem first"):
        poincare_section("pump", revolutions=2)
