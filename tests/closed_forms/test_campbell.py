"""Eigenvalues over the speed, against known frequencies and real matrices."""

import numpy as np
import pytest

from rotor_ida import Contact, InputError, RotorSystem, Stator, campbell
from tests.axisymmetric_systems import beam, random_axisymmetric


def overhung(**more):
    """Return a disc that tilts about x and y, with stiffness 8, inertia 0.5 and polar inertia 1."""
    gyroscopic = np.zeros((4, 4))
    gyroscopic[2, 3], gyroscopic[3, 2] = 1.0, -1.0
    return RotorSystem(
        mass=np.diag([1.0, 1.0, 0.5, 0.5]), units="1",
        nodes={"disc": [[1, 0, 0.2, 0], [0, 1, 0, 0.2]]},
        **{"stiffness": np.diag([4.0, 4.0, 8.0, 8.0]), "gyroscopic": gyroscopic} | more,
    )  # fmt: skip


def test_a_disc_that_tilts_is_stiffened_forwards_and_softened_backwards():
    """omega = Omega I_p/(2 I) +- sqrt((Omega I_p/(2 I))**2 + k/I), as by Friswell et al."""
    speeds = np.array([0.0, 0.5, 2.0])
    found = campbell(overhung(), speed=speeds).squeeze("contact_stiffness")
    for number, omega in enumerate(speeds):
        exact = [omega - np.hypot(omega, 4.0), -2.0, 2.0, omega + np.hypot(omega, 4.0)]
        np.testing.assert_allclose(np.sort(found.whirl_speed[number]), exact, atol=1e-12)
    np.testing.assert_array_equal(np.sign(found.whirl_speed), found.whirl_sense)
    np.testing.assert_allclose(found.damping_ratio, 0.0, atol=1e-12)


def test_critical_speeds_are_those_of_whirls_with_the_spin_speed():
    """At 2 of the translation, and at sqrt(k/(I + I_p)) of the backward tilt; none at 0."""
    found = campbell(overhung(), speed=[-3.0, 3.0, 0.0, 1.9])
    expected = [2.0, 2.0, np.sqrt(8.0 / 1.5)]
    np.testing.assert_allclose(found.critical_speed[3:], expected, rtol=1e-10)
    np.testing.assert_allclose(found.critical_speed[2::-1], np.negative(expected), rtol=1e-10)
    assert sorted(found.critical_sense.values[3:5]) == [-1, 1]
    assert found.critical_sense.values[[0, 5]].tolist() == [-1, -1]
    damped = RotorSystem(mass=np.eye(2), stiffness=np.diag([4.0, 9.0]), damping=0.4 * np.eye(2),
                         nodes={"d": (0, 1)}, units="1")  # fmt: skip
    found = campbell(damped, speed=[0.0, 5.0])
    np.testing.assert_allclose(found.critical_speed, [2 * np.sqrt(0.99), 3 * np.sqrt(1 - 1 / 225)])
    np.testing.assert_allclose(found.critical_damping_ratio, [0.1, 1 / 15])
    assert not campbell(damped, speed=1.0).sizes["critical"]


UNEQUAL = {
    "mass": np.diag([10.0, 10.0, 0.12, 0.12]),
    "stiffness": [[7e5, 0, 6e4, 0], [0, 1.5e6, 0, 1e5], [6e4, 0, 2.8e4, 0], [0, 1e5, 0, 6e4]],
    "gyroscopic": np.diag([0.0, 0, 0.2], 1) - np.diag([0.0, 0, 0.2], -1),
    "nodes": {"disc": [[1, 0, 0.1, 0], [0, 1, 0, 0.1]]},
}  # fmt: skip


@pytest.mark.parametrize("points", [2, 36, 400])
def test_critical_speeds_do_not_depend_on_the_speeds_given(points):
    """Bearings that differ along x and y: the positive roots of det(K - W**2 (M - i G))."""
    system = RotorSystem(**UNEQUAL)
    found = campbell(system, speed=np.linspace(0.0, 700.0, points))
    np.testing.assert_allclose(found.critical_speed, [226.816990, 333.199344, 409.316259])
    for each in found.critical_speed.values:
        dynamic = system.stiffness - each**2 * (system.mass - 1j * system.gyroscopic)
        others = np.linalg.eigvalsh(dynamic)
        assert np.abs(others).min() < 1e-9 * np.abs(others).max()


def scanned(system, last):
    """Return where the whirl speeds of a system pass the spin speed, by many eigenvalues."""
    speeds, size = np.linspace(1e-3, last, 2000), system.size
    matrix = np.zeros((speeds.size, 2 * size, 2 * size))
    matrix[:, :size, size:] = np.eye(size)
    matrix[:, size:, :size] = -np.linalg.solve(system.mass, system.stiffness)
    drag = system.damping + speeds[:, np.newaxis, np.newaxis] * system.gyroscopic
    matrix[:, size:, size:] = -np.linalg.solve(system.mass, drag)
    turning = np.sort(np.linalg.eigvals(matrix).imag, axis=1)[:, size:]
    place, _ = np.nonzero(np.diff(turning > speeds[:, np.newaxis], axis=0))
    return speeds[place]


def test_an_overdamped_tilt_hides_no_critical_speed():
    """Dampers of 0 to 500 N m s/rad on the tilt: whirls cease, the others stay."""
    for drag in (0.0, 20.0, 80.0, 500.0):
        system = RotorSystem(**UNEQUAL, damping=np.diag([20.0, 20.0, drag, drag]))
        found = campbell(system, speed=np.arange(0.0, 701.0, 20.0)).critical_speed.values
        np.testing.assert_allclose(found, scanned(system, 700.0), atol=0.36)
        assert found.size == 3
    # a tilt without unequal stiffness: W**2 = k/(1 - g) - c**2/(2 - g)**2 for k and c over I
    tilt, g = np.diag([0.0, 0, 0.25], 1) - np.diag([0.0, 0, 0.25], -1), 0.5
    for c in (1.0, 8.4, 8.5):
        system = overhung(gyroscopic=tilt, damping=np.diag([0.0, 0.0, 0.5 * c, 0.5 * c]))
        found = campbell(system, speed=[0.0, 20.0])
        exact = np.sqrt(max(16.0 / (1.0 - g) - (c / (2.0 - g)) ** 2, 0.0))
        forward = found.critical_speed[found.critical_sense == 1].values
        expected = sorted({2.0, exact} - {0.0})
        np.testing.assert_allclose(forward, expected, rtol=1e-9)


def test_overdamped_motions_do_not_take_the_places_of_whirls():
    """A tilt with c = 20 over 2 sqrt(k I) = 4 only decays; the shaft whirls at sqrt(k/m) = 2."""
    disc = RotorSystem(
        mass=np.diag([1.0, 1.0, 0.5, 0.5]), stiffness=np.diag([4.0, 4.0, 8.0, 8.0]),
        damping=np.diag([0.0, 0.0, 20.0, 20.0]),
        nodes={"disc": [[1, 0, 0.2, 0], [0, 1, 0, 0.2]]}, units="1",
    )  # fmt: skip
    found = campbell(disc, speed=[1.0], modes=2)
    np.testing.assert_allclose(found.whirl_speed.values.ravel(), [-2.0, 2.0], rtol=1e-12)
    every = campbell(disc, speed=[1.0])
    assert (np.abs(every.whirl_speed.values) < 1e-12).sum() == 2


@pytest.mark.parametrize("seed", range(6))
def test_critical_speeds_of_random_damped_systems_are_those_of_a_scan(seed):
    """Also where cross-coupled stiffness, gyroscopic moments and dampers are large."""
    random = np.random.default_rng(seed)
    inertia, ratio = random.uniform(0.3, 1.0, 2), random.uniform(0.0, 2.0, 2)
    gyroscopic = np.zeros((8, 8))
    for number in (0, 1):
        tilt = slice(4 * number + 2, 4 * number + 4)
        gyroscopic[tilt, tilt] = inertia[number] * ratio[number] * np.array([[0, 1], [-1, 0]])
    springs, dampers, across = random.normal(size=(3, 8, 8))
    system = RotorSystem(
        mass=np.diag([1, 1, *inertia[[0, 0]], 1, 1, *inertia[[1, 1]]]), gyroscopic=gyroscopic,
        stiffness=springs @ springs.T / 8 + 0.3 * (seed % 2) * (across - across.T),
        damping=dampers @ dampers.T * 10.0 ** random.uniform(-2, 0), units="1",
        nodes={"left": (0, 1), "right": (4, 5)},
    )  # fmt: skip
    found = campbell(system, speed=[0.0, 6.0]).critical_speed.values
    np.testing.assert_allclose(found, scanned(system, 6.0), atol=4e-3)
    mirrored = RotorSystem(**{name: getattr(system, name) for name in ("mass", "stiffness",
                           "damping", "nodes")}, gyroscopic=-gyroscopic, units="1")  # fmt: skip
    again = campbell(mirrored, speed=[-6.0, 0.0]).critical_speed.values
    np.testing.assert_allclose(-again[::-1], found, rtol=1e-9)


def test_forward_is_the_sense_of_the_spin():
    """A rotor that turns the other way is the mirror image; its whirls keep their names."""
    found = campbell(overhung(), speed=[-1.0, 1.0]).isel(contact_stiffness=0)
    np.testing.assert_allclose(found.whirl_speed[0], found.whirl_speed[1], rtol=1e-12)
    assert (found.whirl_sense[0] == found.whirl_sense[1]).all()
    uneven = overhung(stiffness=np.diag([4.0, 4.5, 8.0, 9.0]))
    found = campbell(uneven, speed=[-1.0, 1.0]).isel(contact_stiffness=0)
    np.testing.assert_allclose(found.whirl_speed[0], found.whirl_speed[1], rtol=1e-12)


def test_unequal_bearings_make_ellipses():
    """At rest lines along x and y; with rotation a forward and a backward whirl of each pair."""
    system = overhung(stiffness=np.diag([4.0, 4.5, 8.0, 9.0]))
    still, turning = campbell(system, speed=[0.0, 1.0]).whirl_speed.values[0]
    np.testing.assert_allclose(np.sort(still), [2.0, np.sqrt(4.5), 4.0, np.sqrt(18.0)])
    senses = campbell(system, speed=[0.0, 1.0]).whirl_sense.values[0]
    assert senses[0].tolist() == [0, 0, 0, 0]
    assert senses[1].tolist() == [0, 0, -1, 1]
    (matrix,) = [np.block([[np.zeros((4, 4)), np.eye(4)],
                           [-np.linalg.solve(system.mass, system.stiffness),
                            -np.linalg.solve(system.mass, system.gyroscopic)]])]  # fmt: skip
    exact = np.linalg.eigvals(matrix).imag
    np.testing.assert_allclose(np.sort(np.abs(turning)), np.sort(exact[exact > 0]), rtol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_circles_are_found_as_ellipses_too(seed):
    """Real matrices in coordinates of their own, with springs at a stator that moves."""
    system, contacts, _ = random_axisymmetric(seed)
    stator = Stator(mass=0.7, stiffness=3.0, damping=0.2)
    contacts = [Contact(node="n0", clearance=1.0, stiffness=1.0, stator=stator), *contacts[1:]]
    uneven = RotorSystem(
        mass=system.mass, damping=system.damping, gyroscopic=system.gyroscopic, units="1",
        stiffness=system.stiffness + np.diag([1e-5] + [0.0] * (system.size - 1)),
        nodes=dict(system.nodes),
    )  # fmt: skip
    around = {"contacts": contacts, "speed": [0.7, 1.9], "contact_stiffness": [0.5, 5.0]}
    circles, ellipses = (campbell(each, **around) for each in (system, uneven))
    for name in ("whirl_speed", "damping_ratio"):
        np.testing.assert_allclose(circles[name], ellipses[name], atol=1e-4)


def test_springs_at_contacts_are_stiffness_there():
    system = beam()
    contact = Contact(node="4", clearance=1e-4, stiffness=5e6)
    held = system.stiffness.copy()
    held[[16, 17], [16, 17]] += 3e6
    other = RotorSystem(
        mass=system.mass, stiffness=held, damping=system.damping, gyroscopic=system.gyroscopic,
        nodes=dict(system.nodes),
    )  # fmt: skip
    found = campbell(system, speed=300.0, contacts=[contact], contact_stiffness=[0.0, 3e6], modes=8)
    assert found.contact_stiffness.attrs["units"] == "N m-1"
    assert found.whirl_speed.attrs["units"] == "s-1"
    for number, each in enumerate((system, other)):
        exact = campbell(each, speed=300.0, modes=8)
        np.testing.assert_allclose(found.whirl_speed[number], exact.whirl_speed[0], rtol=1e-8)


def test_what_moves_no_node_is_left_out():
    """A torsion of its own stays out; bad arguments are refused in one line."""
    system = RotorSystem(mass=np.eye(3), stiffness=np.diag([1.0, 2.0, 9.0]), nodes={"d": (0, 1)},
                         units="1")  # fmt: skip
    found = campbell(system, speed=1.0)
    np.testing.assert_allclose(found.whirl_speed.squeeze(), [1.0, np.sqrt(2.0)])
    with pytest.raises(InputError, match="contact_stiffness must be 0 without contacts"):
        campbell(system, speed=1.0, contact_stiffness=2.0)
    with pytest.raises(InputError, match="modes must be at least 1"):
        campbell(system, speed=1.0, modes=0)


def free_rotor(damping=0.0, across=4e6):
    """Return two equal bodies on a shaft without supports, stiffer across if so asked."""
    spring = np.kron([[1.0, -1.0], [-1.0, 1.0]], np.diag([4e6, across]))
    return RotorSystem(mass=2.0 * np.eye(4), stiffness=spring, damping=damping * np.eye(4),
                       nodes={"left": [0, 1], "right": [2, 3]}, units="1")  # fmt: skip


@pytest.mark.parametrize("across", [4e6, 9e6])  # circles and ellipses
def test_a_free_rotor_has_zero_eigenvalues_that_do_not_grow(across):
    """Both bodies move together: K p = 0, so p may stand or drift; apart, sqrt(2 k/m)."""
    found = campbell(free_rotor(across=across), speed=[0.0, 50.0, 3000.0])
    assert (found.damping_ratio.fillna(0.0) == 0.0).all()
    for rates in np.abs(found.whirl_speed.isel(contact_stiffness=0).values):
        held = np.unique(rates[np.isfinite(rates)].round(6))
        expected = {0.0, np.sqrt(2.0 * 4e6 / 2.0), np.sqrt(2.0 * across / 2.0)}
        assert held == pytest.approx(sorted(expected))
        assert (rates[rates < 1.0] == 0.0).all()


def test_a_damper_brakes_a_free_rotor_but_does_not_hold_it():
    """Together the bodies stand, or stop with c/m; no other eigenvalue is 0."""
    found = campbell(free_rotor(damping=3.0), speed=[0.0])
    stands = np.abs(found.whirl_speed.values.ravel()) == 0.0
    ratio = found.damping_ratio.values.ravel()
    assert np.sort(ratio[stands]).tolist() == [0.0, 1.0]
    assert (ratio >= 0.0).all()


def test_gyroscopic_motion_of_a_free_rotor_keeps_its_frequency():
    """A free disc tilts with Ip/Id times the speed, and stays where it is tilted."""
    disc = RotorSystem(mass=np.eye(4), stiffness=np.zeros((4, 4)),
                       gyroscopic=np.diag([0.0, 0, 1.8], 1) - np.diag([0.0, 0, 1.8], -1),
                       nodes={"disc": [[1, 0, 0.2, 0], [0, 1, 0, 0.2]]}, units="1")  # fmt: skip
    found = campbell(disc, speed=[100.0])
    assert np.unique(found.whirl_speed.values.round(9)).tolist() == [0.0, 180.0]
    assert (found.damping_ratio == 0.0).all()
