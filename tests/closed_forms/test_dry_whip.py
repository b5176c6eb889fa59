"""Dry whip of rotor systems: that of one disc, and runs that roll as computed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from rotor_ida import Contact, Rotor, RotorSystem, backward_whirl, simulate
from rotor_ida.closed_forms.whirls.dry_whip import _edges, dry_whips
from rotor_ida.model.assembly import assemble
from rotor_ida.model.axisymmetric import forward_motions
from tests.axisymmetric_systems import QUARTER, random_axisymmetric


def whips_of(system, contact, speed):
    motions = forward_motions(assemble(replace(system, contacts=[contact])))
    return dry_whips(motions, 0, contact, speed)


def test_one_disc_as_a_system_has_the_same_dry_whip():
    """Amplitudes, whirl speeds, forces and growth rates, and where friction cannot hold."""
    rng = np.random.default_rng(0)
    absent = 0
    for _ in range(40):
        rotor = Rotor(
            omega=rng.uniform(0.05, 2.0), zeta=rng.uniform(0.01, 0.4),
            delta0=rng.uniform(0.2, 2.0), friction=rng.uniform(0.05, 0.5),
            shaft_stiffness=float(rng.choice([0.0, 0.25, 1.0])),
            contact_exponent=float(rng.choice([1.0, 1.5])), disc_radius=rng.uniform(1.0, 20.0),
            contact_damping=float(rng.choice([0.0, 0.5])),
        )  # fmt: skip
        exact = backward_whirl(rotor).isel(whirl=1)
        system = rotor.system()
        found = whips_of(system, system.contacts[0], rotor.omega)
        if exact.amplitude.isnull():
            assert not found
            absent += 1
            continue
        (whip,) = found
        assert whip.amplitude == pytest.approx(exact.amplitude.item(), rel=1e-10)
        assert whip.whirl_speed == pytest.approx(exact.whirl_speed.item(), rel=1e-10)
        assert whip.normal_force == pytest.approx(exact.normal_force.item(), rel=1e-9)
        assert whip.tangential_force == pytest.approx(exact.tangential_force.item(), rel=1e-9)
        assert whip.growth_rate == pytest.approx(exact.growth_rate.item(), abs=1e-9)
    assert 5 < absent < 35


def test_no_edge_of_holding_friction_is_lost():
    """Sign changes of ``Im((1 + i m) H)`` over 20,000 whirl speeds, by real matrices."""
    seen = 0
    for seed in range(8):
        system, contacts, _ = random_axisymmetric(seed, contacts=1)
        motions = forward_motions(assemble(replace(system, contacts=contacts)))
        speed, row = 0.8, motions.rows[0]
        turned = speed * motions.gyroscopic
        edges = _edges(motions, row, turned, 0.3, -30.0)

        def flexible(speeds, motions=motions, row=row, turned=turned):
            w = np.asarray(speeds)[..., None, None]
            dynamic = motions.stiffness - w * w * np.eye(motions.size)
            dynamic = dynamic + 1j * w * (motions.damping + turned)
            return np.linalg.solve(dynamic, row.conj()[:, None])[..., 0] @ row

        grid = -np.geomspace(0.01, 29.0, 20_000)
        along = flexible(grid)
        for m in (0.3, -0.3):
            values = ((1 + 1j * m) * along).imag
            for i in np.flatnonzero(values[1:] * values[:-1] < 0.0):
                root = brentq(lambda w, m=m: ((1 + 1j * m) * flexible(w)).imag,
                              grid[i], grid[i + 1], xtol=1e-14)  # fmt: skip
                assert np.abs(edges / root - 1.0).min() < 1e-8
                seen += 1
    assert seen > 20


def two_discs():
    """Return two discs on a shaft, and the contact of the outer one."""
    chain = np.array([[2.0, -1.0], [-1.0, 1.5]])
    gyroscopic = np.kron(np.diag([0.1, 0.3]), -QUARTER)
    system = RotorSystem(
        mass=np.eye(4), stiffness=np.kron(chain, np.eye(2)), gyroscopic=gyroscopic,
        damping=0.2 * np.eye(4), nodes={"inner": (0, 1), "outer": (2, 3)}, units="1",
    )  # fmt: skip
    contact = Contact(node="outer", clearance=0.5, stiffness=20.0, exponent=1.0, friction=0.4,
                      radius=6.0, damping=0.1)  # fmt: skip
    return system, contact


def state_of(system, whip, speed):
    """Return the complex displacements of the two discs in a whirl, by matrices of its own."""
    w, forces = whip.whirl_speed, complex(whip.normal_force, whip.tangential_force)
    stiffness, gyroscopic = system.stiffness[::2, ::2], np.diag([0.1, 0.3])
    # forwards z = x + i y: the skew part of the matrix is -i times the moment
    dynamic = stiffness - w * w * np.eye(2) + 1j * w * (0.2 * np.eye(2) - 1j * speed * gyroscopic)
    return np.linalg.solve(dynamic, [0.0, -forces])


def coordinates(z):
    return np.column_stack([z.real, z.imag]).ravel()


def test_a_run_that_starts_in_dry_whip_stays_there():
    """It rolls backwards with the computed amplitude, forces and whirl speed, to 1e-9."""
    system, contact = two_discs()
    (whip, *_) = whips_of(system, contact, 0.7)
    assert whip.growth_rate < 0.0
    w, z = whip.whirl_speed, state_of(system, whip, 0.7)
    assert z[1] == pytest.approx(whip.amplitude, rel=1e-10)
    run = simulate(system, contacts=[contact], speed=0.7, duration=30.0, samples=31, rtol=1e-12,
                   start=(coordinates(z), coordinates(1j * w * z)))  # fmt: skip
    exact = z * np.exp(1j * w * run.t.values)[:, np.newaxis]
    np.testing.assert_allclose((run.x + 1j * run.y).values, exact, atol=1e-9)
    np.testing.assert_allclose(run.normal_force[1:, 0], whip.normal_force, rtol=1e-8)
    np.testing.assert_allclose(np.abs(run.tangential_force[1:, 0]), abs(whip.tangential_force),
                               rtol=1e-8)  # fmt: skip
    assert (run["mode"].values[1:, 0] == 2).all()


def test_without_friction_or_a_radius_there_is_none():
    system, contact = two_discs()
    for missing in ({"friction": 0.0}, {"friction": 0.0, "radius": None}):
        given = {"node": "outer", "clearance": 0.5, "stiffness": 20.0, "radius": 6.0} | missing
        assert whips_of(system, Contact(**given), 0.7) == []
    assert whips_of(system, contact, 0.0) == []
