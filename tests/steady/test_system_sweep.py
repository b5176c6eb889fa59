"""Settled responses of rotor systems: exact whirls, one disc, other integrations, jumps."""

import math

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    Race,
    Rotor,
    RotorSystem,
    Stator,
    Unbalance,
    decode_flags,
    simulate,
    special_speeds,
    sweep,
    synchronous_response,
)
from rotor_ida.schema import STABILITY
from rotor_ida.steady import sweep as sweep_module
from tests.axisymmetric_systems import random_axisymmetric

# ---- Against what is known ----


@pytest.mark.parametrize(
    ("seed", "speeds"), [(0, [0.4, 0.8]), (3, [0.4, 0.8, 1.3]), (7, [0.4, 0.8, 1.3])]
)
def test_synchronous_responses_are_stable_exact_whirls(seed, speeds):
    """Two contacts, stators, friction and contact damping: all numbers, to 1e-9 of their size."""
    system, contacts, unbalance = random_axisymmetric(seed)
    given = {"contacts": contacts, "unbalance": unbalance, "speed": speeds}
    found = sweep(system, **given).squeeze(["start", "direction"])
    exact = synchronous_response(system, **given)
    words = decode_flags(found.response).values.tolist()
    assert {"contact_free", "synchronous"} >= set(words)
    for row, word in enumerate(words):
        point, branches = found.isel(speed=row), exact.isel(speed=row)
        whirl = point.amplitude * np.exp(-1j * point.phase_lag)
        exactly = branches.amplitude * np.exp(-1j * branches.phase_lag)
        apart = np.abs(exactly - whirl).max("contact") / np.abs(whirl).max("contact")
        branch = branches.isel(branch=np.nanargmin(apart.values))
        assert float(apart.min()) < 1e-9
        assert int(branch.stability) == STABILITY["stable"]
        moved = point.node_amplitude * np.exp(-1j * point.node_phase_lag)
        exactly = branch.node_amplitude * np.exp(-1j * branch.node_phase_lag)
        assert float(np.abs(moved - exactly).max()) < 1e-9 * float(np.abs(moved).max())
        force = float(branch.normal_force.max())
        np.testing.assert_allclose(point.largest_force, branch.normal_force, atol=1e-8 * force)
        np.testing.assert_array_equal(point.touched, branch.in_contact)
        assert (word == "synchronous") == bool(branch.in_contact.any())
        for name in ("radius_min", "radius_max"):
            np.testing.assert_allclose(point[name], point.amplitude, rtol=1e-9)
        assert float(point.cycle_distance) < 1e-9
        assert math.isnan(point.period)


def test_a_rub_on_a_stator_without_mass_is_that_on_a_light_one():
    chain = np.kron([[2.0, -1.0], [-1.0, 2.0]], np.eye(2))
    system = RotorSystem(
        mass=np.eye(4), stiffness=chain, damping=0.15 * np.eye(4),
        nodes={"a": (0, 1), "b": (2, 3)}, units="1",
    )  # fmt: skip

    def given(mass):
        stator = Stator(mass=mass, stiffness=3.0, damping=0.5)
        rub = Contact(
            node="b", clearance=0.4, stiffness=10.0, friction=0.1, radius=3.0, stator=stator
        )
        unbalance = [Unbalance(node="a", moment=0.5)]
        return {"contacts": [rub], "unbalance": unbalance, "speed": [0.9]}

    found = sweep(system, **given(0.0))
    assert decode_flags(found.response).values.ravel().tolist() == ["synchronous"]
    (exact,) = synchronous_response(system, **given(1e-9)).amplitude.values.ravel()
    assert found.amplitude.item() == pytest.approx(exact, rel=1e-8)


ONE_DISC = {
    "synchronous": ({"omega": 1.7, "delta0": 0.5}, (0.0, 0.0, 0.0, 0.0)),
    "contact_free": ({"omega": 2.3, "delta0": 2.0}, (0.0, 0.0, 0.0, 0.0)),
    "bouncing": ({"omega": 2.0, "delta0": 2.0}, (0.0, 0.0, 0.0, 0.0)),
    "full_contact": ({"omega": 3.0, "delta0": 0.5}, (0.0, 0.0, 0.0, 0.0)),
    "full_contact by a Hopf point": (
        {"omega": 1.2, "delta0": 0.5, "friction": 0.1, "disc_radius": 10.0}, (0.0, 0.0, 0.0, 0.0),
    ),
    "rolling": (
        {"omega": 0.63, "zeta": 0.1, "delta0": 1.0, "friction": 0.2, "disc_radius": 10.0},
        (5.0, 0.0, 0.0, -5.0),
    ),
    "full_contact under a load": (
        {"omega": 1.5, "zeta": 0.1, "delta0": 1.0, "shaft_stiffness": 0.5, "load": 0.4},
        (0.0, 0.0, 0.0, 0.0),
    ),
    "bouncing under a load": (
        {"omega": 2.2, "zeta": 0.1, "delta0": 1.0, "shaft_stiffness": 0.4, "load": 0.3},
        (0.0, 0.0, 0.0, 0.0),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ONE_DISC)
def test_one_disc_as_a_system_has_the_labels_of_one_disc(name):
    changes, start = ONE_DISC[name]
    given = {"zeta": 0.07} | changes
    one = sweep(**given, starts=[start], method="taylor").squeeze()
    system = Rotor(**given).system()
    found = sweep(
        system, speed=given["omega"],
        starts=[(start[:2], start[2:])],
    ).squeeze()  # fmt: skip
    assert decode_flags(found.response).item() == name.split()[0]
    assert int(found.response) == int(one.response)
    np.testing.assert_allclose(found.period, one.period, rtol=1e-9)
    for edge in ("radius_min", "radius_max"):
        assert float(found[f"node_{edge}"]) == pytest.approx(float(one[edge]), rel=1e-7)
    assert float(found.revolutions) < 400.0


def test_chaos_is_chaos_in_both():
    """It lasts for 200,000 time units at least (exponent 0.0362)."""
    rotor = Rotor(omega=1.38, zeta=0.07, delta0=1.0)
    system = rotor.system()
    found = sweep(
        system, speed=1.38,
        starts=[((1.5, -0.25), (0.0, 0.0))],
    ).squeeze()  # fmt: skip
    assert decode_flags(found.response).item() == "chaotic"
    # a mean over 9,000 time units is off by some 0.001
    assert 0.025 < float(found.lyapunov_exponent) < 0.05


def test_a_torus_is_quasi_periodic():
    """A cycle on turning axes whose period is no whole number of revolutions, under a load."""
    rotor = Rotor(omega=2.9, zeta=0.1, delta0=1.0, shaft_stiffness=0.4, load=0.3)
    system = rotor.system()
    found = sweep(system, speed=2.9).squeeze()
    assert decode_flags(found.response).item() == "quasi_periodic"
    assert abs(float(found.lyapunov_exponent)) < 1e-6


# ---- Systems that are not axisymmetric ----


def two_discs(*, stiffer=1.0, damped=0.05, hard=3.0):
    """Return two discs on a shaft, stiffer along y, with a contact and an unbalance."""
    chain = np.array([[2.0, -1.0], [-1.0, 2.0]])
    stiffness = np.kron(chain, np.diag([1.0, stiffer]))
    system = RotorSystem(
        mass=np.eye(4), stiffness=stiffness, damping=damped * stiffness,
        nodes={"one": (0, 1), "two": (2, 3)}, units="1",
    )  # fmt: skip
    contacts = [Contact(node="two", clearance=0.8, stiffness=hard, exponent=1.0)]
    return system, contacts, [Unbalance(node="one", moment=0.4)]


def test_without_axial_symmetry_the_settled_motion_comes_back_after_whole_revolutions():
    """Radii and forces are those of a run over the period from its final state."""
    system, contacts, unbalance = two_discs(stiffer=1.3)
    around = {"contacts": contacts, "unbalance": unbalance}
    found = sweep(system, **around, speed=[0.7, 1.05, 1.2]).squeeze(["start", "direction"])
    words = decode_flags(found.response).values.tolist()
    assert words == ["contact_free", "bouncing", "full_contact"]
    for speed in found.speed.values.tolist():
        point = found.sel(speed=speed)
        period = float(point.period.fillna(2.0 * math.pi / speed))
        turns = period * speed / (2.0 * math.pi)
        assert turns == pytest.approx(round(turns), abs=1e-9)
        state = tuple(point.final_state.values.reshape(2, -1))
        run = simulate(system, **around, speed=speed, start=state, duration=period, samples=20_001)
        np.testing.assert_allclose(run.final_state, point.final_state, atol=1e-9)
        radii = np.hypot(run.x, run.y)
        np.testing.assert_allclose(point.node_radius_max, radii.max("t"), rtol=1e-7)
        np.testing.assert_allclose(point.node_radius_min, radii.min("t"), rtol=1e-6)
        assert point.largest_force.item() == pytest.approx(float(run.normal_force.max()), rel=1e-6)


def test_a_long_period_of_revolutions_is_found():
    system, contacts, unbalance = two_discs(stiffer=1.3, hard=10.0)
    found = sweep(system, contacts=contacts, unbalance=unbalance, speed=1.9).squeeze()
    assert decode_flags(found.response).item() == "bouncing"
    assert float(found.period) == pytest.approx(57.0 * 2.0 * math.pi / 1.9, rel=1e-12)


# ---- Along a ramp ----


def test_up_and_down_jump_at_the_exact_folds():
    """Down from above, the contact-free whirl lasts until it touches."""
    system, contacts, unbalance = two_discs(damped=0.1)
    around = {"contacts": contacts, "unbalance": unbalance}
    special = special_speeds(system, **around, limits=(1.15, 1.32))
    lower, upper = special.special_speed.values
    assert decode_flags(special.special_kind).values.tolist() == ["graze", "fold"]
    speeds = np.arange(1.15, 1.32, 0.01)
    found = sweep(system, **around, speed=speeds, direction="both").isel(start=0)
    touched = found.touched.isel(contact=0).values.astype(bool)
    down, up = (speeds[touched[:, number]].max() for number in (1, 0))
    assert down < lower < down + 0.01
    assert up < upper < up + 0.01


def test_a_race_that_friction_spins_is_part_of_what_settles():
    system, _, unbalance = two_discs()
    touch = {"node": "two", "clearance": 0.8, "stiffness": 3.0, "friction": 0.2, "radius": 0.5}
    contacts = [Contact(**touch, race=Race(radius=0.5, inertia=0.2, drag=0.05))]
    around = {"contacts": contacts, "unbalance": unbalance}
    found = sweep(system, **around, speed=1.0).squeeze()
    assert decode_flags(found.response).item() == "synchronous"
    *state, spin = found.final_state.values.tolist()
    again = [Contact(**touch, race=Race(radius=0.5, inertia=0.2, drag=0.05, speed=spin))]
    assert spin > 0.1
    run = simulate(
        system, contacts=again, unbalance=unbalance, speed=1.0,
        start=tuple(np.reshape(state, (2, -1))), duration=8.0 * math.pi, samples=2,
    )  # fmt: skip
    np.testing.assert_allclose(run.final_state, found.final_state, atol=1e-9)


# ---- What does not settle, and what fails ----


# A seal whose cross-coupled stiffness of 134,400 N/m outweighs the damping at 336 rad/s.
CROSSED = 134_400.0
SEAL = RotorSystem(
    mass=10.0 * np.eye(2), damping=400.0 * np.eye(2), nodes={"disc": (0, 1)},
    stiffness=np.array([[1e6, CROSSED], [-CROSSED, 1e6]]),
)  # fmt: skip
STOP = Contact(node="disc", clearance=2e-4, stiffness=4e6, exponent=1.0)


@pytest.mark.parametrize("start", [None, "settled", "rest", ([1e-6, 0.0], [0.0, 0.0])])
def test_an_unstable_equilibrium_is_left_for_the_whirl_that_contacts_bound(start):
    """It once was chaos between 0 and 0; the whirl has w = k/D, and s = M w**2 - K beside K."""
    found = sweep(SEAL, contacts=[STOP], speed=[700.0], starts=[start]).squeeze()
    assert decode_flags(found.response).item() == "full_contact"
    whirl = CROSSED / 400.0
    secant = 10.0 * whirl**2 - 1e6
    amplitude = STOP.clearance / (1.0 - secant / STOP.stiffness)
    for name in ("radius_min", "radius_max"):
        assert float(found[name]) == pytest.approx(amplitude, rel=1e-8)
    assert float(found.period) == pytest.approx(2.0 * math.pi / (700.0 - whirl), rel=1e-8)
    assert float(found.largest_force) == pytest.approx(secant * amplitude, rel=1e-6)


def test_an_unstable_whirl_of_unbalance_is_left_too():
    given = {
        "contacts": [STOP],
        "speed": [700.0],
        "unbalance": [Unbalance(node="disc", moment=1e-5)],
    }
    found = sweep(SEAL, **given, starts=["settled", ([1e-5, 0.0], [0.0, 0.0])]).squeeze()
    assert decode_flags(found.response).values.tolist() == ["full_contact"] * 2
    np.testing.assert_allclose(found.radius_max[0], found.radius_max[1], rtol=1e-8)
    assert float(found.revolutions[0]) < 1000.0


def test_what_grows_without_contact_is_no_chaos():
    found = sweep(SEAL, speed=[700.0])
    assert decode_flags(found.response).item() == "unresolved"
    assert "it sat on an unstable whirl or cycle and was disturbed" in found.message.item()


def test_a_sweep_that_takes_minutes_says_so_before_it_starts(monkeypatch):
    """Its cost is that of 40 degrees of freedom; 16 modes are faster, and say nothing."""
    chain = np.kron(2.0 * np.eye(20) - np.eye(20, k=1) - np.eye(20, k=-1), np.eye(2))
    system = RotorSystem(
        mass=np.eye(40), stiffness=1e6 * chain, damping=2.0 * np.eye(40), nodes={"end": (0, 1)}
    )
    stop = Contact(node="end", clearance=1e-3, stiffness=1e6)
    monkeypatch.setattr(sweep_module, "run_study", lambda *_, **__: pytest.fail("it started"))
    given = {"contacts": [stop], "speed": np.linspace(10.0, 20.0, 20)}
    with pytest.raises(
        UserWarning, match=r"takes some \d+ minutes .* as 40 .*: modes=16 takes less"
    ):
        sweep(system, **given)
    with pytest.raises(pytest.fail.Exception, match="it started"):
        sweep(system, **given, modes=16)


def test_without_damping_nothing_settles():
    system = Rotor(omega=1.7, zeta=0.0, delta0=0.5).system()
    found = sweep(system, speed=1.7).squeeze()
    assert decode_flags(found.response).item() == "unresolved"
    assert found.message.item().endswith("revolutions: without damping nothing settles")


def test_a_resonance_without_damping_has_no_settled_start():
    system = RotorSystem(mass=np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)}, units="1")
    found = sweep(
        system, unbalance=[Unbalance(node="disc", moment=1.0)], speed=[0.5, 1.0],
        starts=["settled"],
    ).squeeze()  # fmt: skip
    assert found.status.values.tolist() == [0, 1]
    assert "start cannot be settled" in found.message.values[1]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"speed": [0.0, 1.0]}, "speed must not be 0 in a sweep of a rotor system, got 0.0"),
        ({"speed": [2.0, 1.0], "direction": "up"}, "speed must increase in a sweep up or down"),
        ({"direction": "sideways"}, "direction must be one of"),
        ({"starts": []}, "starts must be a list"),
        ({"starts": "rest"}, "starts must be a list"),
        ({"starts": ["tilted"]}, "start must be one of"),
        ({"rtol": 1.0}, "rtol must lie from"),
        ({"executor": "gpu"}, "executor must be"),
    ],
)
def test_bad_input_is_refused_in_one_line(changes, message):
    system, contacts, unbalance = two_discs()
    given = {"contacts": contacts, "unbalance": unbalance, "speed": [0.5, 0.7]} | changes
    with pytest.raises(InputError, match=message) as caught:
        sweep(system, **given)
    assert "\n" not in str(caught.value)


# ---- As a study ----
