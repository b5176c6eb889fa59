"""Rotor systems with contacts without clearance, against one disc's own kernel and closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Stator,
    Unbalance,
    clearance_report,
    limit_cycle,
    run_up,
    simulate,
    special_speeds,
    sweep,
    synchronous_response,
)
from rotor_ida.closed_forms.free_vibration import free_periods
from rotor_ida.core.runs import NO_STOP
from rotor_ida.model.assembly import assemble
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow

REST = (0.0, 0.0, 0.0, 0.0)
LOADED = {"omega": 1.2, "zeta": 0.05, "load": 0.3, "shaft_stiffness": 0.5}
FREE = {"omega": 0.0, "zeta": 0.0}
SAMPLES = {"rtol": 1e-12, "samples": 401}


def apart(one, other):
    """Return how far the motions of a disc and of its system are apart."""
    return np.hypot(one.x - other.x.values[:, 0], one.y - other.y.values[:, 0]).max().item()


def pair(start):
    return start[:2], start[2:]


@pytest.mark.parametrize("exponent", [1.5, 1.0])
@pytest.mark.parametrize("start", [(0, 0, 0, 0), (3, 1, 0, 0.5), (2, 0, 0, 0)])
@pytest.mark.parametrize("parameters", [{"omega": 1.7, "zeta": 0.07}, LOADED, FREE])
def test_a_disc_as_a_system_moves_as_in_its_own_kernel(parameters, start, exponent):
    rotor = Rotor(delta0=0.0, contact_exponent=exponent, **parameters)
    own = simulate(rotor, start=start, duration=30.0, method="taylor", **SAMPLES)
    system = rotor.system()
    seen = simulate(system, speed=rotor.omega, start=pair(start), duration=30.0, **SAMPLES)
    assert apart(own, seen) < 1e-10
    assert seen.event_time.size == 0
    radius = np.hypot(seen.x, seen.y).values[:, 0]
    np.testing.assert_allclose(seen.normal_force.values[:, 0], radius**exponent, atol=1e-11)
    for name in ("peak_indentation", "peak_force", "entry_time", "exit_time", "impulse"):
        np.testing.assert_allclose(seen[name], own[name], rtol=1e-10, atol=1e-12, err_msg=name)
    assert np.isnan(seen.excursion).all()


def test_a_line_through_the_centre_takes_the_closed_period():
    system = Rotor(omega=0.0, zeta=0.0, delta0=0.0).system()
    (period,) = free_periods(amplitude=[2.0], delta0=0.0).planar_period.values.ravel()
    times = np.array([0.0, 0.25, 0.5, 1.0, 3.0]) * period
    run = simulate(system, speed=0.0, start=((2, 0), (0, 0)), duration=4 * period, samples=times)
    np.testing.assert_allclose(run.x.values[:, 0], [2.0, 0.0, -2.0, 2.0, 2.0], atol=1e-9)


@pytest.mark.parametrize("exponent", [1.5, 1.0])
def test_energy_is_conserved_without_damping(exponent):
    rotor = Rotor(delta0=0.0, load=0.3, contact_exponent=exponent, **FREE)
    run = simulate(
        rotor.system(), speed=0.0, start=((1, 0.5), (0, 0.1)), duration=500.0, rtol=1e-12
    )
    radius, height = np.hypot(run.x, run.y), run.y
    spring = radius ** (exponent + 1.0) / (exponent + 1.0)
    energy = 0.5 * (run.vx**2 + run.vy**2) + spring + 0.3 * height
    assert abs(energy / energy[0] - 1.0).max() < 1e-10
    kept = (spring[-1] - spring[0]).item()
    assert run.attrs["energy_normal"] == pytest.approx(kept, abs=1e-10)


@pytest.mark.parametrize("course", [
    {"to": 2.5, "rate": 0.02}, {"torque": (0.5, 0.0), "inertia": 20.0, "duration": 60.0},
])  # fmt: skip
def test_a_run_up_is_that_of_one_disc(course):
    rotor = Rotor(omega=0.5, zeta=0.07, delta0=0.0)
    own = run_up(rotor, start=REST, method="taylor", **course, **SAMPLES)
    seen = run_up(rotor.system(), speed=0.5, start=pair(REST), **course, **SAMPLES)
    assert apart(own, seen) < 1e-10


@pytest.fixture(scope="module")
def two_discs():
    """A disc without clearance, and one that hits a stator beside."""
    chain = np.array([[8.0, -4.0], [-4.0, 6.0]])
    return RotorSystem(
        mass=np.diag([2.0, 2.0, 1.0, 1.0]), stiffness=np.kron(chain, np.eye(2)),
        damping=np.kron(0.02 * chain, np.eye(2)), nodes={"disc": (0, 1), "end": (2, 3)},
        contacts=[
            Contact(node="disc", clearance=0, stiffness=3.0, centre=(0.1, 0.0)),
            Contact(node="end", clearance=1.0, stiffness=20.0, friction=0.1, radius=2.0,
                    damping=0.3),
        ],
        unbalance=[Unbalance(node="disc", moment=0.5)], gravity=(0.0, -0.2), units="1",
    )  # fmt: skip


def test_beside_other_contacts_the_witness_follows_the_same_motion(two_discs):
    def run(**how):
        return simulate(two_discs, speed=2.6, start="rest", duration=15.0, samples=101, **how)

    exact = run(rtol=1e-12)
    assert (exact.event_contact == 1).all()
    assert exact.event_time.size > 4
    other = run(rtol=1e-10, backend="python", method="adams")
    np.testing.assert_allclose(other.event_time, exact.event_time, atol=3e-7)
    for name in ("x", "y", "vx", "normal_force"):
        np.testing.assert_allclose(other[name], exact[name], atol=3e-6, err_msg=name)
    with pytest.raises(InputError, match="method must be 'taylor' with a contact without"):
        run(method="adams")


@pytest.mark.parametrize("stator", ["end", Stator(mass=0.5, stiffness=2.0, damping=0.3)])
def test_between_bodies_that_move_it_is_that_of_the_witness(two_discs, stator):
    """From rest at the centre, where the contact is closed already."""
    contact = Contact(node="disc", clearance=0, stiffness=3.0, stator=stator)
    system = replace(two_discs, contacts=[contact], gravity=None)

    def run(**how):
        return simulate(system, speed=1.5, start="rest", duration=15.0, samples=101, **how)

    exact, other = run(rtol=1e-12), run(rtol=1e-10, backend="python", method="adams")
    np.testing.assert_allclose(other.x, exact.x, atol=1e-7)
    np.testing.assert_allclose(other.normal_force, exact.normal_force, atol=1e-6)


def test_small_changes_grow_as_differences_do(two_discs):
    flow = SystemFlow.at(SettlingProblem.of(assemble(two_discs), 1e-13), 2.6, NO_STOP)
    state = flow.given_state(np.array([0.3, 0.1, 0.9, 0.0, 0.0, 0.2, 1.1, 0.0]))
    names = ("contact_stiffness", "unbalance", "damping")
    piece = flow.run(state, 3.0, by=names)
    step = 1e-5
    for number, column in enumerate(piece.tangents.T):
        moved = step * np.eye(state.size)[number]
        near, far = (flow.after(state + sign * moved, 3.0) for sign in (1.0, -1.0))
        np.testing.assert_allclose(column, (near - far) / (2.0 * step), atol=3e-8)
    for name, column in zip(names, piece.by, strict=True):
        value = flow.value_of(name)
        near, far = (flow.but(**{name: value + sign * step}).after(state, 3.0)
                     for sign in (1.0, -1.0))  # fmt: skip
        np.testing.assert_allclose(column, (near - far) / (2.0 * step), atol=3e-8)


def test_a_limit_cycle_has_the_multipliers_of_one_disc():
    rotor = Rotor(delta0=0.0, **LOADED)
    own = limit_cycle(rotor, start=REST)
    seen = limit_cycle(rotor.system(), speed=rotor.omega, start=pair(REST))
    assert seen.period.item() == pytest.approx(own.period.item(), rel=1e-10)
    for name in ("multiplier_real", "multiplier_imag"):
        np.testing.assert_allclose(np.sort(seen[name]), np.sort(own[name]), atol=1e-8)


def test_a_sweep_settles_as_one_disc_does():
    rotor, speeds = Rotor(omega=1.0, zeta=0.07, delta0=0.0), [0.8, 1.7, 2.4]
    own = sweep(rotor, omega=speeds, direction="both")
    seen = sweep(rotor.system(), speed=speeds, direction="both")
    for name in ("response", "amplitude", "phase_lag", "radius_max"):
        np.testing.assert_allclose(seen[name].values.ravel(), own[name].values.ravel(), rtol=1e-8)


@pytest.mark.parametrize(("given", "message"), [
    ({"friction": 0.1, "radius": 1.0}, "friction of the contact at 'disc' must be 0 without"),
    ({"damping": 0.1}, "damping of the contact at 'disc' must be 0 without"),
    ({"stator": Stator(mass=0.0, stiffness=1.0, damping=1.0)}, "must be positive with a stator"),
])  # fmt: skip
def test_what_needs_a_direction_at_the_centre_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        Contact(**{"node": "disc", "clearance": 0, "stiffness": 1.0, **given})


@pytest.mark.parametrize("verb", [
    lambda system: synchronous_response(system, speed=1.0),
    lambda system: special_speeds(system, limits=(0.5, 2.0)),
    lambda system: clearance_report(system, speed=(0.5, 1.7), vibration_limit=1.0),
])  # fmt: skip
def test_closed_forms_of_whirls_need_a_clearance(verb):
    system = Rotor(omega=1.0, zeta=0.07, delta0=0.0).system()
    with pytest.raises(InputError, match="clearance of the contact at 'disc' must be above 0"):
        verb(system)
