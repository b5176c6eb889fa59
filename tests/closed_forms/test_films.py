"""Answers over the speed on bearings with tables: each is that of the plain system at its speed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq, linear_sum_assignment

from rotor_ida import (
    Bearing,
    Contact,
    InputError,
    RotorSystem,
    Unbalance,
    campbell,
    clearance_report,
    special_speeds,
    synchronous_response,
)
from rotor_ida.cli.describe import describe
from rotor_ida.closed_forms.clearances.critical_speeds import _driven_modes, critical_modes
from rotor_ida.closed_forms.crossings import film_pencil, film_speeds
from rotor_ida.model.assembly import assemble
from rotor_ida.results.archived_system import system_of
from rotor_ida.schema import SPECIAL
from tests.films import SPEEDS, on_films

HELD = (333.0, 1250.0, 1700.0)


@pytest.fixture(scope="module", params=[0.0, 0.3], ids=["equal", "unequal"])
def system(request):
    return on_films(unequal=request.param)


def dynamic(system, speed):
    """Return the plain system at a speed, and its matrices for a motion at the speed."""
    plain = system.at(speed)
    resisted = plain.damping + speed * plain.gyroscopic
    return plain, plain.stiffness - speed**2 * plain.mass + 1j * speed * resisted


def test_whirls_are_those_at_each_speed():
    system = on_films()
    found = synchronous_response(system, speed=HELD)
    assert (found.in_contact == 1).any()
    for number, speed in enumerate(HELD):
        one = synchronous_response(system.at(speed), speed=speed)
        here = found.isel(speed=number, branch=slice(one.sizes["branch"]))
        for name in ("amplitude", "normal_force", "node_amplitude", "node_major_axis"):
            np.testing.assert_allclose(here[name], one[name].isel(speed=0), rtol=1e-11)
        np.testing.assert_allclose(here.growth_rate, one.growth_rate.isel(speed=0), rtol=1e-9)


def test_eigenvalues_and_critical_speeds_are_those_at_each_speed(system):
    speeds = (160.0, *HELD, 2390.0)
    found = campbell(system, speed=speeds, modes=6)
    for number, speed in enumerate(speeds):
        one = campbell(system.at(speed), speed=speed, modes=6).isel(speed=0)
        for name in ("whirl_speed", "damping_ratio"):
            here = found[name].isel(speed=number)
            np.testing.assert_allclose(here, one[name], rtol=1e-9, atol=1e-11)
    assert found.sizes["critical"] > 0
    for speed in found.critical_speed.values:
        one = campbell(system.at(speed), speed=[0.99 * speed, 1.01 * speed]).critical_speed
        assert np.abs(one - speed).min() < 1e-9 * speed


def test_a_growth_that_cross_coupling_drives_begins_at_the_threshold():
    """The eigenvalues of the whole matrices cross the imaginary axis there."""
    system = on_films(unequal=0.3, cross=6000.0)
    found = special_speeds(system, limits=(160.0, 2390.0), points=20)
    assert "not the same along x and y" in found.attrs["not_exact"]
    assert found.special_kind.values.tolist() == [SPECIAL["threshold"]]
    (threshold,) = found.special_speed.values.tolist()

    def fastest(speed):
        plain = system.at(speed)
        n, inverse = plain.size, np.linalg.inv(plain.mass)
        resisted = plain.damping + speed * plain.gyroscopic
        values = np.linalg.eigvals(
            np.block(
                [[np.zeros((n, n)), np.eye(n)], [-inverse @ plain.stiffness, -inverse @ resisted]]
            )
        )
        return values[values.real.argmax()]  # fmt: skip

    beyond = synchronous_response(system, speed=[200.0, 1.2 * threshold]).attrs
    assert beyond["growth_begins_at"] == pytest.approx(threshold, rel=1e-9)
    assert beyond["growth_rate_without_contact"] == pytest.approx(fastest(1.2 * threshold).real)
    below = synchronous_response(system, speed=[200.0, 0.9 * threshold]).attrs
    assert "growth_begins_at" not in below
    assert fastest(threshold * (1.0 - 1e-6)).real < 0.0 < fastest(threshold * (1.0 + 1e-6)).real
    assert found.whirl_speed.item() == pytest.approx(abs(fastest(threshold).imag), rel=1e-6)


@pytest.mark.parametrize("damper", [2e2, 2e5, 2e6])
def test_a_threshold_stands_beside_motions_that_decay_far_faster(damper):
    """A disc on a film of cross-coupling 10 omega with m = 1, k = 1e4, c = 20 grows where
    10 omega > c sqrt(k / m), beyond 200; a light node on a damper decays faster than all of it."""
    speeds = np.array([10.0, 1000.0])
    film = Bearing(
        node="disc", speed=speeds, damping=np.zeros((2, 2, 2)),
        stiffness=10.0 * speeds[:, np.newaxis, np.newaxis] * np.array([[0.0, 1.0], [-1.0, 0.0]]),
    )  # fmt: skip
    system = RotorSystem(
        mass=np.diag([1.0, 1.0, 1e-3, 1e-3]), stiffness=np.diag([1e4, 1e4, 1e3, 1e3]),
        damping=np.diag([20.0, 20.0, damper, damper]), nodes={"disc": (0, 1), "seal": (2, 3)},
        bearings=[film], unbalance=[Unbalance(node="disc", moment=1e-6)],
    )  # fmt: skip
    found = special_speeds(system, limits=(50.0, 900.0), points=20)
    assert found.special_speed.values == pytest.approx([200.0], rel=1e-7)
    assert found.whirl_speed.values == pytest.approx([100.0], rel=1e-7)
    told = synchronous_response(system, speed=[50.0, 900.0]).attrs
    assert told["growth_begins_at"] == pytest.approx(200.0, rel=1e-11)
    assert told["unstable_speeds"] == pytest.approx([200.0, 900.0], rel=1e-11)


def test_a_threshold_of_an_axisymmetric_system_stands_beside_its_rubs():
    found = special_speeds(on_films(cross=6000.0), limits=(160.0, 2390.0), points=30)
    kinds = found.special_kind.values
    assert (kinds == SPECIAL["threshold"]).sum() == 1
    assert (kinds != SPECIAL["threshold"]).any()
    assert np.isnan(found.amplitude.values[kinds == SPECIAL["threshold"]]).all()


def test_orbits_are_those_of_a_direct_solution(system):
    found = synchronous_response(system, speed=HELD)
    for number, speed in enumerate(HELD):
        plain, matrix = dynamic(system, speed)
        force = np.zeros(plain.size, complex)
        for each in plain.unbalance:
            x, y = plain.rows(each.node)
            force += each.moment * speed**2 * np.exp(1j * each.phase) * (x - 1j * y)
        motion = np.linalg.solve(matrix, force)
        angles = np.linspace(0.0, 2.0 * np.pi, 100_001)
        for node in plain.nodes:
            here = found.isel(speed=number).sel(node=node)
            x, y = ((row @ motion * np.exp(1j * angles)).real for row in plain.rows(node))
            radius = np.hypot(x, y)
            assert here.node_major_axis == pytest.approx(2.0 * radius.max(), rel=1e-8)
            assert abs(here.node_minor_axis) == pytest.approx(2.0 * radius.min(), rel=1e-6)
            ahead, back = (
                here[f"node_{sense}_amplitude"].item()
                * np.exp(sign * (angles - here[f"node_{sense}_phase_lag"].item()))
                for sense, sign in (("forward", 1j), ("backward", -1j))
            )
            np.testing.assert_allclose((ahead + back), x + 1j * y, atol=1e-12 * radius.max())


def test_the_radius_at_a_contact_counts_load_and_offset():
    system = on_films(unequal=0.3)
    contact = replace(system.contacts[0], centre=(2e-5, -1e-5))
    system = replace(system, contacts=[contact], gravity=(0.0, -9.81),
                     translations=system.unit_translations())  # fmt: skip
    found = synchronous_response(system, speed=[333.0])
    plain, matrix = dynamic(system, 333.0)
    still = np.linalg.solve(plain.stiffness, plain.weight((0.0, -9.81)))
    force = sum(
        each.moment * 333.0**2 * np.exp(1j * each.phase)
        * (plain.rows(each.node)[0] - 1j * plain.rows(each.node)[1]) for each in plain.unbalance
    )  # fmt: skip
    angles = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 100_001))[:, np.newaxis]
    moved = (np.linalg.solve(matrix, force) * angles).real + still
    places = moved @ plain.rows(contact.node).T - np.array(contact.centre)
    assert found.unbalance_radius.item() == pytest.approx(
        np.hypot(*places.T).max(), rel=1e-8
    )  # fmt: skip


def test_peaks_are_where_the_response_is_largest(system):
    """A dense scan finds the same top, and the width at 0.707 of it."""
    found = synchronous_response(system, speed=[160.0, 2390.0])
    peaks = found.isel(critical=np.flatnonzero(found.amplification_factor.notnull()))
    assert peaks.sizes["critical"] > 0
    one = peaks.isel(critical=int(peaks.peak_major_axis.values.argmax()))
    top, factor = one.peak_speed.item(), one.amplification_factor.item()
    near = np.linspace(top * (1.0 - 2.0 / factor), top * (1.0 + 2.0 / factor), 2001)
    axis = synchronous_response(system, speed=near).node_major_axis.sel(node=one.peak_node.item())
    assert axis.max().item() == pytest.approx(one.peak_major_axis.item(), rel=1e-6)
    assert near[int(axis.values.argmax())] == pytest.approx(top, rel=2e-3 / factor)
    above = near[axis.values >= axis.values.max() / np.sqrt(2.0)]
    assert top / (above[-1] - above[0]) == pytest.approx(factor, rel=5e-3)
    assert one.critical_speed.item() == pytest.approx(top, rel=0.1)


def test_close_clearances_are_reported_within_the_tables(system):
    around = {"speed": (1500.0, 1560.0), "points": 60, "probes": ["2"]}
    found = clearance_report(replace(system, unbalance=()), **around)
    assert found.speed.values.min() >= SPEEDS[0]
    assert found.speed.values.max() <= SPEEDS[-1]
    assert (found.attrs.get("not_exact") is None) == system.bearings[0].is_isotropic
    with pytest.raises(InputError, match="speed must lie within the table of the bearing"):
        clearance_report(system, **around | {"speed": (40.0, 1560.0)})


@pytest.mark.parametrize("verb", [synchronous_response, campbell])
def test_a_result_keeps_its_tables(system, verb):
    found = verb(system, speed=[333.0, 1250.0])
    again = system_of(found)
    assert verb(again, speed=[333.0, 1250.0]).equals(found)


@pytest.mark.parametrize(
    "ask",
    [
        lambda system: synchronous_response(system, speed=[200.0, 2500.0]),
        lambda system: campbell(system, speed=[200.0, 2500.0]),
        lambda system: special_speeds(system, limits=(200.0, 2500.0)),
    ],
)
def test_a_speed_outside_the_tables_is_refused(system, ask):
    with pytest.raises(InputError, match=r"from 150 rad/s to 2400 rad/s, got 2500 rad/s"):
        ask(system)


def tabled_system(seed):
    """Return a random system of one to three nodes, some of its motions overdamped by films."""
    random = np.random.default_rng(seed)
    count = int(random.integers(1, 4))
    stiff, damped, turning = random.normal(size=(3, 2 * count, 2 * count))
    turning = random.choice([0.0, 0.2]) * (turning - turning.T)
    films = []
    for _ in range(int(random.integers(1, 3))):
        rows = int(random.integers(2, 9))
        sides = random.normal(size=(2, rows, 2, 2))
        squares = sides @ np.swapaxes(sides, -1, -2)
        films.append(Bearing(
            node=f"{random.integers(count)}", speed=np.linspace(0.2, 4.5, rows),
            stiffness=random.uniform(0.5, 4.0) * squares[0]
            + 0.5 * random.normal(size=(rows, 2, 2)) * [[0, 1], [1, 0]],
            damping=random.choice([0.1, 1.0, 3.0]) * squares[1],
        ))  # fmt: skip
    return RotorSystem(
        mass=np.eye(2 * count), stiffness=stiff @ stiff.T, damping=0.02 * damped @ damped.T,
        gyroscopic=turning, nodes={f"{i}": (2 * i, 2 * i + 1) for i in range(count)},
        bearings=films, units="1",
    )  # fmt: skip


def on_grid(assembly, speeds):
    """Return where eigenvalues on a dense grid, each matched to the nearest, pass the speed."""
    stiffness = assembly.stiffness_at(speeds)
    resisted = assembly.damping_at(speeds) + speeds[:, None, None] * assembly.gyroscopic
    one = np.broadcast_to(np.eye(assembly.size), stiffness.shape)
    values = np.linalg.eigvals(np.block([[0.0 * one, one], [-stiffness, -resisted]]))
    found = []
    for before, behind, low, high in zip(values, values[1:], speeds, speeds[1:], strict=False):
        if np.abs(before.imag - low).min() > 0.2:
            continue
        _, partners = linear_sum_assignment(np.abs(before[:, None] - behind))
        gaps = before.imag - low, behind[partners].imag - high
        found += [0.5 * (low + high)] * int(((gaps[0] > 0.0) != (gaps[1] > 0.0)).sum())
    return found


@pytest.mark.parametrize("seed", range(12))
def test_no_critical_speed_of_a_dense_grid_is_missed(seed):
    assembly = assemble(tabled_system(seed))
    speeds = np.linspace(0.2, 4.5, 4001)
    found = film_speeds(assembly, 0.2, 4.5)
    left = list(found)
    for speed in on_grid(assembly, speeds):
        nearest = min(left, key=lambda each: abs(each - speed), default=np.inf)
        assert abs(nearest - speed) < 2.0 * (speeds[1] - speeds[0])
        left.remove(nearest)
    for speed in found:
        values = np.linalg.eigvals(film_pencil(assembly, speed)[0])  # with a unit mass
        assert np.abs(values.imag - speed).min() < 1e-9


def test_a_critical_speed_that_an_overdamped_motion_passes_nearby_is_found():
    """Two circles: at 1 with light damping, and one whose whirl speed passes that near 1 too.

    Their imaginary parts are the roots of ``K - C**2/4``: each film is a single disc.
    """
    light = Bearing(node="a", speed=[0.2, 2.0], stiffness=[1.01, 1.01], damping=[0.2, 0.2])
    knots = np.linspace(0.2, 2.0, 10)
    heavy = Bearing(
        node="b", speed=knots, damping=np.full(10, 4.0), stiffness=4.0 + (knots * 0.99) ** 8
    )
    system = RotorSystem(mass=np.eye(4), stiffness=np.zeros((4, 4)), bearings=[light, heavy],
                         nodes={"a": (0, 1), "b": (2, 3)}, units="1")  # fmt: skip
    passing = brentq(lambda speed: heavy.at(speed)[0][0, 0] - 4.0 - speed**2, 0.9, 1.2)
    found = film_speeds(assemble(system), 0.2, 2.0)
    np.testing.assert_allclose(found, sorted([1.0, 1.0, passing, passing]), rtol=1e-9)
    (mode,) = critical_modes(assemble(system), 2.0)
    assert mode.speed == pytest.approx(1.0, rel=1e-9)


def test_a_critical_speed_that_is_only_touched_is_found():
    """The whirl speed ``sqrt(2 W - 1)`` touches W at 1, and is below it elsewhere."""
    film = Bearing(node="a", speed=[0.6, 2.0], stiffness=[0.2, 3.0])
    system = RotorSystem(mass=np.eye(2), stiffness=np.zeros((2, 2)), bearings=[film],
                         nodes={"a": (0, 1)}, units="1")  # fmt: skip
    (mode,) = critical_modes(assemble(system), 2.0)
    assert mode.speed == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("unequal", [0.0, 0.3])
def test_critical_speeds_in_constant_matrices_are_where_an_eigenvalue_turns_with_them(unequal):
    """With damping and gyroscopic moments they differ from the poles of the response."""
    assembly = assemble(on_films(unequal=unequal, cross=0.0).at(900.0))
    modes = critical_modes(assembly, 6000.0)
    poles = _driven_modes(assembly, 0.0, 6000.0)
    turning = np.array(film_speeds(assembly, 100.0, 6000.0))
    assert len(modes) >= 2
    for mode in modes:
        if mode.speed < 6000.0:
            assert np.abs(turning - mode.speed).min() < 1e-8 * mode.speed
    apart = max(min(abs(pole.speed / each.speed - 1.0) for each in modes) for pole in poles)
    assert apart > 1e-4


def test_critical_speeds_are_in_order_and_none_is_lost():
    """With heavy damping their order differs from that of the poles of the response."""
    rng, turned = np.random.default_rng(5), 0
    for _ in range(150):
        count, sense = int(rng.integers(2, 5)), np.array([[0.0, 1.0], [-1.0, 0.0]])
        springs, dampers = rng.normal(size=(2, count, count))
        mass = np.diag(rng.uniform(0.5, 2.0, count))
        assembly = assemble(RotorSystem(
            mass=np.kron(mass, np.eye(2)), damping=np.kron(0.4 * dampers @ dampers.T, np.eye(2)),
            stiffness=np.kron(springs @ springs.T + 0.3 * np.eye(count), np.eye(2)),
            gyroscopic=np.kron(rng.uniform(0.0, 0.9) * mass, sense), units="1",
            nodes={str(place): (2 * place, 2 * place + 1) for place in range(count)},
        ))  # fmt: skip
        largest = rng.uniform(1.0, 6.0)
        every, found = ([each.speed for each in critical_modes(assembly, most)]
                        for most in (1e3, largest))  # fmt: skip
        assert every == sorted(every)
        within = [each for each in every if each <= largest]
        np.testing.assert_allclose(found, within or every[:1], rtol=1e-9)
        turned += len(found) > 1
    assert turned > 20


def test_critical_speeds_of_a_disc_on_the_diagonal_are_double_and_told_once():
    """Its motions along the axes do not turn it, so that both senses are equally fast."""
    turning = np.zeros((4, 4))
    turning[2, 3], turning[3, 2] = 1.2, -1.2
    system = RotorSystem(
        mass=np.eye(4), stiffness=np.diag([4.0, 4.0, 9.0, 9.0]), damping=0.2 * np.eye(4),
        gyroscopic=turning, nodes={"a": (0, 1), "b": (2, 3)}, units="1",
    )  # fmt: skip
    (mode,) = critical_modes(assemble(system), 2.5)
    assert mode.speed == pytest.approx(np.sqrt(4.0 - 0.1**2), rel=1e-12)
    assert mode.decay == pytest.approx(0.1, rel=1e-12)


def test_a_range_of_instability_that_ends_is_told():
    """Two springs k, damping c and cross-coupling q grow where ``q**2 > c**2 k``: see whirls."""
    knots, coupling = np.array([0.1, 2.0, 4.0, 8.0]), np.array([0.0, 0.5, 0.0, 0.4])
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    film = Bearing(node="0", speed=knots, stiffness=coupling[:, np.newaxis, np.newaxis] * turn,
                   damping=np.stack([0.2 * np.eye(2)] * 4))  # fmt: skip
    gap = Contact(node="0", clearance=0.5, stiffness=1.0, exponent=1.0)
    system = RotorSystem(mass=np.eye(2), stiffness=np.eye(2), bearings=[film], nodes={"0": (0, 1)},
                         contacts=[gap], unbalance=[Unbalance(node="0", moment=0.01)],
                         units="1")  # fmt: skip
    q = PchipInterpolator(knots, coupling)
    ends = [brentq(lambda speed: q(speed) - 0.2, *pair) for pair in ((0.1, 2.0), (2.0, 4.0))]
    for found in (synchronous_response(system, speed=[0.2, 1.5, 4.5]),
                  campbell(system, speed=[0.2, 4.5])):  # fmt: skip
        np.testing.assert_allclose(found.attrs["unstable_speeds"], ends, rtol=1e-9)
        (said,) = [each for each in describe(found)[1] if isinstance(each, str) and "grows" in each]
        low, high = found.attrs["unstable_speeds"]
        assert f"at speeds from {low:.4g} to {high:.4g}: the linear system is unstable" in said
    beyond = brentq(lambda speed: q(speed) - 0.2, 4.0, 8.0)
    both = campbell(system, speed=[0.2, 7.5]).attrs
    np.testing.assert_allclose(both["unstable_speeds"], [*ends, beyond, 7.5], rtol=1e-9)
    assert both["growth_begins_at"] == pytest.approx(beyond, rel=1e-11)
    rising = np.array([0.0, 0.0, 0.0, 0.4])
    film = replace(film, stiffness=rising[:, np.newaxis, np.newaxis] * turn)
    q = PchipInterpolator(knots, rising)
    beyond = brentq(lambda speed: q(speed) - 0.2, 4.0, 8.0)
    report = clearance_report(system, bearings=[film], speed=(4.2, 4.6, 4.8), vibration_limit=0.05)
    first = report.attrs["sentence"].splitlines()[0]
    assert report.attrs["growth_begins_at"] == pytest.approx(beyond, rel=1e-9)
    assert f"unstable from a speed of {report.attrs['growth_begins_at']:.4g} on" in first
    assert f"{100.0 * (beyond / 4.8 - 1.0):.2g} % above the trip speed" in first
