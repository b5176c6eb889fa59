"""Synchronous whirls of rotor systems, against one disc, balances of force, scans and runs."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

from rotor_ida import (
    Bearing,
    Contact,
    InputError,
    Race,
    Rotor,
    RotorSystem,
    Stator,
    Unbalance,
    decode_flags,
    simulate,
    sweep,
    synchronous_response,
)
from rotor_ida.closed_forms.whirls.double_rubs import Pairs, double_rubs
from rotor_ida.model.assembly import assemble
from rotor_ida.model.axisymmetric import forward_motions
from tests.axisymmetric_systems import beam, random_axisymmetric

# The decisive eigenvalue of the beam turns at 4e5 rad/s and decays at 0.03 1/s: rounding of the one
# limits what is known of the other.
ROUNDED = 4e5 * 1e-14


def complex_matrices(system, contacts):
    """Return mass, damping, gyroscopic and stiffness of z = x + i y, and the rows of contacts.

    Nodes are pairs of neighbours here, and stators come last: nothing is shared with the package.
    """
    stators = list(dict.fromkeys(c.stator for c in contacts if isinstance(c.stator, Stator)))
    size, names = system.size // 2, list(system.nodes)
    total = size + len(stators)

    def of(name):
        own = getattr(system, name)
        found = np.zeros((total, total), complex)
        if own is not None:
            found[:size, :size] = own[::2, ::2] + 1j * own[1::2, ::2]
        for i, each in enumerate(stators):
            if name != "gyroscopic":
                value = getattr(each, name)
                found[size + i, size + i] = value if np.isscalar(value) else value[0]
        return found

    rows = np.zeros((len(contacts), total))
    for row, each in zip(rows, contacts, strict=True):
        row[names.index(each.node)] = 1.0
        if isinstance(each.stator, str):
            row[names.index(each.stator)] -= 1.0
        elif each.stator is not None:
            row[size + stators.index(each.stator)] -= 1.0
    return [of(name) for name in ("mass", "damping", "gyroscopic", "stiffness")], rows


def responses(system, contacts, unbalance, omega):
    """Return displacements of the contacts by the unbalance and by unit forces there."""
    (mass, damping, gyroscopic, stiffness), rows = complex_matrices(system, contacts)
    dynamic = stiffness - omega**2 * mass + 1j * omega * (damping + omega * gyroscopic)
    force = np.zeros(len(mass), complex)
    for each in unbalance:
        force[list(system.nodes).index(each.node)] += (
            each.moment * omega**2 * np.exp(1j * each.phase)
        )
    return rows @ np.linalg.solve(dynamic, force), rows @ np.linalg.solve(dynamic, rows.T)


def turned_forces(contacts, depths, omega):
    return np.array([
        c.stiffness * max(d, 0.0) ** c.exponent * (1 + 1j * c.friction * np.sign(omega))
        for c, d in zip(contacts, depths, strict=True)
    ])  # fmt: skip


def whirls_at(found, number):
    """Return amplitudes and phases of the whirls at a speed, shape (whirl, contact)."""
    here = found.isel(speed=number)
    here = here.isel(branch=(here.stability >= 0).values)
    lag = np.sign(here.speed.item()) * here.phase_lag.values
    return here.amplitude.values * np.exp(-1j * lag), here


def test_one_disc_as_a_system_has_the_same_whirls():
    """Amplitudes and phases to 1e-13, growth rates to 1e-12, the same words for stability."""
    rng = np.random.default_rng(0)
    for _ in range(25):
        given = {
            "omega": rng.uniform(0.2, 4.0), "zeta": rng.uniform(0.005, 0.3),
            "delta0": rng.uniform(0.2, 2.0), "shaft_stiffness": float(rng.choice([0.0, 0.25, 1.0])),
            "contact_exponent": float(rng.choice([1.0, 1.5])),
            "contact_damping": float(rng.choice([0.0, 0.5])),
            "friction": float(rng.choice([0.0, 0.1, 0.3])),
        }  # fmt: skip
        exact = synchronous_response(**given).squeeze(
            [name for name in given if name in ("omega", "zeta", "delta0")]
        )
        system = Rotor(**given, disc_radius=5.0).system()
        found = synchronous_response(system, speed=given["omega"]).isel(speed=0, contact=0)
        np.testing.assert_allclose(found.amplitude, exact.amplitude, rtol=1e-13)
        np.testing.assert_allclose(found.phase_lag, exact.phase_lag, atol=1e-13)
        np.testing.assert_allclose(found.growth_rate, exact.growth_rate, atol=1e-12)
        np.testing.assert_array_equal(found.stability, exact.stability)
        np.testing.assert_array_equal(found.in_contact, exact.in_contact)


def test_a_system_in_other_coordinates_has_the_same_whirls():
    """Rows for nodes, no coordinate a displacement: amplitudes, phases, growth rates, forces."""
    speeds = [0.5, 1.1, 1.9]
    for seed in range(6):
        plain, turned = (
            synchronous_response(system, contacts=contacts, unbalance=unbalance, speed=speeds)
            for system, contacts, unbalance in (
                random_axisymmetric(seed), random_axisymmetric(seed, turned=True))
        )  # fmt: skip
        np.testing.assert_array_equal(plain.stability, turned.stability)
        for name in ("amplitude", "node_amplitude", "growth_rate", "normal_force"):
            np.testing.assert_allclose(plain[name], turned[name], rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_forces_balance_in_every_whirl(seed):
    """By complex matrices of their own: displacements are those of unbalance and contact forces."""
    system, contacts, unbalance = random_axisymmetric(seed)
    speeds = np.array([-1.3, 0.4, 0.9, 1.6, 2.5])
    found = synchronous_response(system, contacts=contacts, unbalance=unbalance, speed=speeds)
    clearances = np.array([each.clearance for each in contacts])
    for number, omega in enumerate(speeds):
        places, here = whirls_at(found, number)
        free, flexibility = responses(system, contacts, unbalance, omega)
        for place, forces in zip(places, here.normal_force.values, strict=True):
            pushed = turned_forces(contacts, np.abs(place) - clearances, omega)
            np.testing.assert_allclose(forces, np.abs(pushed) / np.abs(
                [1 + 1j * c.friction for c in contacts]), atol=1e-11)  # fmt: skip
            left = free - flexibility @ (pushed * place / np.abs(place)) - place
            assert np.abs(left).max() < 1e-10 * (1.0 + np.abs(place).max())


def test_no_rub_at_one_contact_is_lost():
    """Sign changes of the balance over 4,000 indentations of each contact alone."""
    counts = []
    for seed in range(15):
        system, contacts, unbalance = random_axisymmetric(seed, contacts=1)
        speeds = np.random.default_rng(seed).uniform(0.3, 2.5, size=6)
        found = synchronous_response(system, contacts=contacts, unbalance=unbalance, speed=speeds)
        (contact,) = contacts
        for number, omega in enumerate(speeds):
            free, flexibility = responses(system, contacts, unbalance, omega)
            grid = contact.clearance * np.geomspace(1e-7, 1e5, 4000)

            def apart(d, at=omega, h=flexibility[0, 0], u=free[0], contact=contact):
                force = contact.stiffness * d**contact.exponent
                force = force * (1 + 1j * contact.friction * np.sign(at))
                return np.abs(contact.clearance + d + h * force) - np.abs(u)

            signs = np.sign(apart(grid))
            roots = [brentq(apart, grid[i], grid[i + 1], xtol=1e-14)
                     for i in np.nonzero(np.diff(signs))[0]]  # fmt: skip
            here = found.isel(speed=number, contact=0)
            rubs = here.amplitude.values[here.in_contact.values == 1] - contact.clearance
            np.testing.assert_allclose(np.sort(rubs), roots, rtol=1e-8)
            counts.append(len(roots))
    assert {0, 1, 2} <= set(counts)


def test_no_rub_at_two_contacts_is_lost():
    """Newton's method from 30 starts for each of 30 random pairs finds none but the known."""
    rng = np.random.default_rng(5)
    known = 0
    for seed in range(30):
        system, contacts, unbalance = random_axisymmetric(seed)
        omega = rng.uniform(0.3, 2.2)
        free, flexibility = responses(system, contacts, unbalance, omega)
        clearances = np.array([each.clearance for each in contacts])
        hertz = tuple(each.exponent == 1.5 for each in contacts)
        scale = turned_forces(contacts, clearances, omega) / clearances[:, np.newaxis]
        pairs = Pairs((free / clearances)[None], (flexibility * scale)[None], hertz)
        _, depths, boxes = double_rubs(pairs)
        assert boxes < 2000
        known += len(depths)

        def apart(depth, pairs=pairs):
            depth = np.abs(depth)
            force = depth ** np.where(pairs.hertz, 1.5, 1.0)
            matrix = np.diag(1.0 + depth) + pairs.effect[0] * force
            return np.abs(np.linalg.solve(matrix, pairs.free[0])) - 1.0

        for each in depths:
            assert np.abs(apart(each)).max() < 1e-11
        for start in rng.exponential(2.0, size=(30, 2)):
            root, _, flag, _ = fsolve(apart, start, full_output=True, xtol=1e-13)
            if flag == 1 and np.abs(apart(root)).max() < 1e-10 and np.abs(root).min() > 1e-9:
                assert (np.abs(depths / np.abs(root) - 1.0).max(axis=1, initial=0.0) < 1e-5).any()
    assert known > 15


def test_two_contacts_around_one_node_rub_together():
    """A soft seal inside a bearing: the radius of both is that of the forces together."""
    system = RotorSystem(
        mass=np.eye(2), stiffness=np.eye(2), damping=0.1 * np.eye(2), nodes={"d": (0, 1)}, units="1"
    )
    seal, bearing = (Contact(node="d", clearance=c, stiffness=k)
                     for c, k in ((0.3, 2.0), (0.6, 20.0)))  # fmt: skip
    found = synchronous_response(
        system, contacts=[seal, bearing], unbalance=[Unbalance(node="d", moment=2.0)], speed=1.0
    )
    (place,), here = whirls_at(found, 0)

    def apart(radius):
        force = 2.0 * (radius - 0.3) ** 1.5 + 20.0 * (radius - 0.6) ** 1.5
        return abs(0.1j * radius + force) - 2.0

    np.testing.assert_allclose(np.abs(place), brentq(apart, 0.6, 3.0, xtol=1e-15), rtol=1e-13)
    assert (here.in_contact == 1).all()


def test_growth_rates_are_those_of_differences():
    """Eigenvalues of the equations of motion on turning axes, differentiated by central steps."""
    checked = 0
    for seed in range(10):
        system, contacts, unbalance = random_axisymmetric(seed)
        omega = 0.7 + 0.1 * seed
        found = synchronous_response(system, contacts=contacts, unbalance=unbalance, speed=omega)
        places, here = whirls_at(found, 0)
        (mass, damping, gyroscopic, stiffness), rows = complex_matrices(system, contacts)
        size = len(mass)
        drag = damping + omega * gyroscopic
        dynamic = stiffness - omega**2 * mass + 1j * omega * drag
        clearances = np.array([each.clearance for each in contacts])

        def rate(state, size=size, rows=rows, mass=mass, drag=drag, dynamic=dynamic, omega=omega,
                 contacts=contacts, clearances=clearances):  # fmt: skip
            p, v = state[:size] + 1j * state[size : 2 * size], state[2 * size : 3 * size] + 0j
            v = v + 1j * state[3 * size :]
            u, moved = rows @ p, rows @ v
            direction = u / np.abs(u)
            force = turned_forces(contacts, np.abs(u) - clearances, omega) * direction
            force = force * [1 + c.damping * each for c, each in zip(
                contacts, (direction.conj() * moved).real, strict=True)]  # fmt: skip
            bent = np.linalg.solve(
                mass, -rows.T @ force - (drag + 2j * omega * mass) @ v - dynamic @ p
            )
            return np.concatenate([v.real, v.imag, bent.real, bent.imag])

        for place, growth in zip(places, here.growth_rate.values, strict=True):
            pushed = turned_forces(contacts, np.abs(place) - clearances, omega)
            force = -rows.T @ (pushed * place / np.abs(place))
            for each in unbalance:
                force[list(system.nodes).index(each.node)] += (
                    each.moment * omega**2 * np.exp(1j * each.phase)
                )
            p = np.linalg.solve(dynamic, force)
            at = np.concatenate([p.real, p.imag, np.zeros(2 * size)])
            steps = 1e-6 * np.eye(4 * size)
            jacobian = np.array([(rate(at + s) - rate(at - s)) / 2e-6 for s in steps]).T
            assert np.linalg.eigvals(jacobian).real.max() == pytest.approx(growth, abs=2e-7)
            checked += 1
    assert checked > 12


def test_a_settled_run_whirls_as_computed():
    """On a stable rub of two contacts, one of them on a stator that moves: to 1e-9."""
    system, _, unbalance = random_axisymmetric(5)
    contacts = [
        Contact(node="n0", clearance=0.3, stiffness=20.0, friction=0.1, radius=4.0),
        Contact(node="n1", clearance=0.2, stiffness=9.0, exponent=1.0, damping=0.3,
                stator=Stator(mass=0.7, stiffness=3.0, damping=0.6)),
    ]  # fmt: skip
    around = {"contacts": contacts, "unbalance": unbalance, "speed": 0.6}
    found = synchronous_response(system, **around)
    places, here = whirls_at(found, 0)
    assert decode_flags(here).stability.values.tolist() == ["stable"]
    assert (here.in_contact == 1).all()
    run = simulate(system, **around, duration=900.0, samples=[899.0, 899.5, 900.0], rtol=1e-12)
    nodes = here.node_amplitude.values[0] * np.exp(-1j * here.node_phase_lag.values[0])
    exact = nodes * np.exp(0.6j * run.t.values)[:, np.newaxis]
    np.testing.assert_allclose((run.x + 1j * run.y).values, exact, atol=1e-9)
    np.testing.assert_allclose(run.normal_force[-1], here.normal_force[0], rtol=1e-8)
    assert places.shape == (1, 2)


def test_a_finite_element_rotor_and_its_modes_rub_alike():
    system = beam()
    contacts = [Contact(node="3", clearance=1e-4, stiffness=5e6, exponent=1.0)]
    unbalance = [Unbalance(node="3", moment=2e-4), Unbalance(node="7", moment=2e-4)]
    speeds = [300.0, 426.33795, 600.0]
    around = {"contacts": contacts, "unbalance": unbalance, "speed": speeds}
    whole = synchronous_response(system, **around)
    modes = synchronous_response(system.reduced(modes=44), **around)
    assert whole.amplitude.attrs["units"] == "m"
    assert whole.normal_force.attrs["units"] == "N"
    np.testing.assert_allclose(whole.amplitude, modes.amplitude, rtol=1e-8)
    np.testing.assert_allclose(whole.growth_rate, modes.growth_rate, atol=ROUNDED)
    (mass, damping, gyroscopic, stiffness) = (
        getattr(system, name) for name in ("mass", "damping", "gyroscopic", "stiffness")
    )
    # the rub's force balances on real matrices
    for omega, place, forces in zip(speeds, whole.node_amplitude.values[:, 0] * np.exp(
            -1j * whole.node_phase_lag.values[:, 0]), whole.normal_force.values[:, 0, 0],
            strict=True):  # fmt: skip
        force = np.zeros(44, complex)
        for node in (12, 28):
            force[node : node + 2] += 2e-4 * omega**2 * np.array([1.0, -1j])
        force[12:14] -= forces * place[3] / abs(place[3]) * np.array([1.0, -1j])
        dynamic = stiffness - omega**2 * mass + 1j * omega * (damping + omega * gyroscopic)
        np.testing.assert_allclose(np.linalg.solve(dynamic, force)[::4], place, rtol=1e-9)


def test_motions_along_and_about_the_axis_change_no_growth_rate():
    small = beam()
    free = np.setdiff1d(np.arange(66), own := np.arange(66).reshape(11, 6)[:, [0, 1, 3, 4]].ravel())
    chain = np.diag([1.0, *[2.0] * 9, 1.0]) - np.eye(11, k=1) - np.eye(11, k=-1)
    others = {"mass": np.kron(np.eye(11), np.diag([0.12, 6e-6])),
              "stiffness": np.kron(chain, np.diag([1e9, 2e4]))}  # fmt: skip
    wide = {}
    for name in ("mass", "stiffness", "damping", "gyroscopic"):
        wide[name] = np.zeros((66, 66))
        wide[name][np.ix_(own, own)] = getattr(small, name)
        wide[name][np.ix_(free, free)] = others.get(name, 0.0)
    system = RotorSystem(**wide, nodes={str(i): (6 * i, 6 * i + 1) for i in range(11)})
    around = {
        "contacts": [Contact(node="3", clearance=1e-4, stiffness=5e6, exponent=1.0, friction=0.1,
                             radius=0.01)],
        "unbalance": [Unbalance(node="3", moment=2e-4)], "speed": [300.0, 430.0, 600.0],
    }  # fmt: skip
    one, other = (synchronous_response(each, **around) for each in (small, system))
    assert (one.in_contact == 1).any()
    np.testing.assert_allclose(one.amplitude, other.amplitude, rtol=1e-11)
    np.testing.assert_allclose(one.growth_rate, other.growth_rate, rtol=1e-9, atol=ROUNDED)


def test_without_contacts_it_is_the_unbalance_response():
    system, _, unbalance = random_axisymmetric(3)
    found = synchronous_response(system, unbalance=unbalance, speed=[0.0, 1.2])
    run = simulate(system, unbalance=unbalance, speed=1.2, start="settled", duration=5.0, samples=3)
    np.testing.assert_allclose(found.node_amplitude[1, 0], np.hypot(run.x, run.y)[-1], rtol=1e-12)
    assert (found.node_amplitude[0, 0] == 0.0).all()
    assert found.attrs["most_touching"] == 2


SQUARE = {"mass": np.eye(2), "stiffness": np.eye(2), "damping": 0.1 * np.eye(2),
          "nodes": {"d": (0, 1)}, "units": "1"}  # fmt: skip
RACE = Race(radius=1.0, inertia=1.0)
TOUCH = {"node": "d", "clearance": 0.5, "stiffness": 4.0}


@pytest.mark.parametrize(
    ("system", "contact", "words"),
    [
        ({"stiffness": np.diag([1.0, 1.001])}, {}, "the stiffness is not the same along x and y"),
        ({"damping": np.diag([0.1, 0.2])}, {}, "the damping is not"),
        ({"mass": np.diag([1.0, 1.1])}, {}, "the mass at node 'd' is not"),
        ({"nodes": {"d": [[1, 0], [0, 2]]}}, {}, "the mass at node 'd' is not"),
        ({"static_force": [0.0, -1.0]}, {}, "gravity or a static force acts on the rotor"),
        ({}, {"centre": (0.1, 0.0)}, "centre of contact 0 at 'd' is off the axis"),
        ({}, {"stator": Stator(mass=1.0, stiffness=(1.0, 2.0))}, "stiffness of the stator of"),
        ({}, {"friction": 0.1, "radius": 1.0, "race": RACE}, "contact 0 at 'd' spins a race"),
    ],
)
def test_what_is_not_axisymmetric_has_no_exact_whirls_in_contact(system, contact, words):
    found = synchronous_response(
        RotorSystem(**SQUARE | system), contacts=[Contact(**TOUCH | contact)], speed=1.2,
        unbalance=[Unbalance(node="d", moment=1.0)],
    )  # fmt: skip
    assert "branch" not in found.dims
    told = found.attrs["not_exact"]
    assert re.search(words, told)
    assert "\n" not in told
    assert told.endswith(
        "so that rubs are not circular; a run at constant speed, a run-up or a sweep computes them"
    )
    assert "--" not in told


def test_unequal_bearings_behind_a_shaft_are_found():
    """Their stiffness differs by a thousandth, at nodes that neither contact nor unbalance are."""
    system = beam()
    uneven = system.stiffness.copy()
    uneven[41, 41] += 5e3
    other = RotorSystem(
        mass=system.mass, stiffness=uneven, damping=system.damping, gyroscopic=system.gyroscopic,
        nodes={"3": (12, 13)},
    )  # fmt: skip
    found = synchronous_response(other, speed=100.0)
    assert "the stiffness is not the same" in found.attrs["not_exact"]


def test_a_resonance_without_damping_is_refused():
    system = RotorSystem(**SQUARE | {"damping": None})
    with pytest.raises(InputError, match=r"speed must not be a resonance .* got 1\.0"):
        synchronous_response(system, speed=[0.5, 1.0])


@pytest.mark.parametrize("verb", [synchronous_response, sweep])
def test_lags_at_negative_speeds_are_those_of_the_mirror_image(verb):
    """A motion lags against the sense of its spin; unbalance is at the mirrored phases."""
    system, contacts, unbalance = random_axisymmetric(3)
    mirrored = [replace(each, phase=-each.phase) for each in unbalance]
    there, back = (
        verb(system, contacts=contacts, unbalance=each, speed=[speed])
        for speed, each in ((0.4, unbalance), (-0.4, mirrored))
    )
    for name in ("amplitude", "node_amplitude"):
        np.testing.assert_allclose(back[name].values, there[name].values, rtol=1e-6)
    for name in ("phase_lag", "node_phase_lag"):
        assert (np.abs(there[name]) > 1e-3).any()
        np.testing.assert_allclose(back[name].values, there[name].values, atol=1e-6)


@pytest.mark.parametrize("unequal", [0.0, 1e-5])
def test_a_shaft_that_oil_films_alone_hold_is_axisymmetric_as_far_as_it_is(unequal):
    """Its stiffness has ten digits: what is left of that of the rigid motions is rounding."""
    rows = np.array([
        [62472079.84, -128499481.3, 83804009.54, -22347735.88, 4571127.793],
        [-128499481.3, 303867130.9, -262275511.3, 109255597.6, -22347735.88],
        [83804009.54, -262275511.3, 356943003.6, -262275511.3, 83804009.54],
        [-22347735.88, 109255597.6, -262275511.3, 303867130.9, -128499481.3],
        [4571127.793, -22347735.88, 83804009.54, -128499481.3, 62472079.84],
    ])  # fmt: skip
    stiffness = np.kron(rows, np.eye(2))
    stiffness[4, 4] *= 1.0 + unequal
    films = [Bearing(node=node, speed=[50.0, 1500.0], damping=[6e4, 5e4],
                     stiffness=[[[5e7, cross], [-cross, 5e7]] for cross in (5e6, 9e7)])
             for node in ("0", "4")]  # fmt: skip
    system = RotorSystem(
        mass=np.kron(np.diag([12.0, 30, 90, 30, 12]), np.eye(2)), stiffness=stiffness,
        damping=1e-5 * np.kron(rows, np.eye(2)),
        nodes={f"{i}": (2 * i, 2 * i + 1) for i in range(5)}, bearings=films,
    )  # fmt: skip
    if unequal:
        with pytest.raises(InputError, match="whose stiffness is not the same"):
            forward_motions(assemble(system))
        return
    forward = forward_motions(assemble(system))
    held, damped = forward.stiffness_at(200.0), forward.damping_at(200.0)
    zero, one = np.zeros((5, 5)), np.eye(5)
    found = np.linalg.eigvals(np.block([[zero, one], [-held, -damped]]))
    plain = system.at(200.0)
    inverse = np.linalg.inv(plain.mass)
    zero, one = np.zeros((10, 10)), np.eye(10)
    known = np.linalg.eigvals(
        np.block([[zero, one], [-inverse @ plain.stiffness, -inverse @ plain.damping]])
    )
    every = np.concatenate([found, found.conj()])
    apart = np.abs(every[:, np.newaxis] - known)
    assert (apart.min(axis=0) < 1e-8 * np.abs(known).max()).all()
    assert (apart.min(axis=1) < 1e-8 * np.abs(known).max()).all()
