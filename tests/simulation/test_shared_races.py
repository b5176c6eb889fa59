"""Contacts that are given one stator share its race, which the friction of all of them turns."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    Race,
    RotorSystem,
    Stator,
    Unbalance,
    lyapunov_exponent,
    run_up,
    simulate,
)
from rotor_ida.core.systems import follow_system
from rotor_ida.model.assembly import assemble, canonical
from rotor_ida.results.archived_system import system_of
from rotor_ida.simulation.spin import steady
from rotor_ida.simulation.system_run import request_of

SYSTEM = RotorSystem(
    mass=np.kron([[2.0, 0.1], [0.1, 1.0]], np.eye(2)), damping=0.1 * np.eye(4),
    stiffness=np.kron([[2.0, -1.0], [-1.0, 1.5]], np.eye(2)),
    gyroscopic=np.kron(np.eye(2), [[0.0, 0.2], [-0.2, 0.0]]), nodes={"a": (0, 1), "b": (2, 3)},
    units="1",
)  # fmt: skip
STILL = np.zeros(4)
UNBALANCE = [Unbalance(node="a", moment=0.3), Unbalance(node="b", moment=0.2, phase=1.0)]


def contacts(friction, inertia, drag=0.0, clearance=0.5):
    """Return two contacts of one stator, whose race both turn."""
    race = Race(radius=2.0, inertia=inertia, drag=drag)
    stator = Stator(mass=0.5, stiffness=8.0, damping=0.2, race=race)
    return [Contact(node=node, clearance=clearance, stiffness=20.0, damping=0.3, radius=2.0,
                    friction=friction, stator=stator) for node in "ab"]  # fmt: skip


def test_a_shared_race_turns_by_the_impulses_of_all_its_contacts():
    """While all slide, the torques are friction times radius times the normal forces."""
    run = simulate(SYSTEM, contacts=contacts(0.2, 5.0), unbalance=UNBALANCE, speed=1.3,
                   duration=30.0, samples=2)  # fmt: skip
    assert (run.contact_duration.groupby(run.episode_contact).count() > 0).all()
    assert set(run.event_kind.values) == {1, -1}
    speeds = run.event_race_speed
    np.testing.assert_array_equal(speeds[:, 0], speeds[:, 1])
    exact = 2.0 * 0.2 * float(run.impulse.sum()) / 5.0
    np.testing.assert_allclose(run.final_state[-2:], exact, rtol=1e-12)
    assert simulate(system_of(run), speed=1.3, duration=30.0, samples=2).equals(run)


def test_contacts_that_roll_on_one_race_under_a_torque_have_the_events_of_cvode():
    case = {"contacts": contacts(0.3, 0.5, 0.02), "unbalance": UNBALANCE, "speed": 1.3,
            "torque": (0.3, 0.1), "inertia": 2.0, "gravity": (0.02, -0.2), "duration": 7.0,
            "samples": 3, "rtol": 1e-8, "start": (STILL, STILL)}  # fmt: skip
    run, other = (run_up(SYSTEM, **case, method=method) for method in ("taylor", "adams"))
    assert set(run.event_contact[run.event_kind == 2].values) == {0, 1}
    np.testing.assert_array_equal(run.event_kind, other.event_kind)
    np.testing.assert_allclose(run.event_time, other.event_time, rtol=1e-6)
    np.testing.assert_allclose(run.event_race_speed, other.event_race_speed, atol=1e-6)


@pytest.mark.parametrize("weight", [0.6, 1.5])
def test_small_changes_with_a_shared_race_are_differences_of_runs(weight):
    shared = [replace(each, radius=1.0) for each in contacts(0.3, 0.2, 0.05, clearance=0.3)]
    whole = assemble(
        replace(SYSTEM, contacts=shared, unbalance=UNBALANCE,
                static_force=[0.0, -weight, 0.1, -weight])
    )  # fmt: skip
    request = request_of(
        whole, canonical(whole), steady(0.6, 12.0), np.zeros((2, 6)), np.array([12.0]), 12.0,
        rtol=1e-12, speed=0.6, fastest_speed=0.6, inertia=0.0,
    )  # fmt: skip
    changes = np.random.default_rng(0).normal(size=(3, 14))
    changes[:, 13] = changes[:, 12]
    run = follow_system(replace(request, columns=changes))
    assert {2, -2} <= set(run.event_kinds.tolist())
    for change, moved in zip(changes, run.columns, strict=True):
        ends = []
        for step in (1e-6, -1e-6):
            start = request.start + step * change[:12].reshape(2, 6)
            end = follow_system(replace(request, start=start,
                                        races=request.races + step * change[12:]))  # fmt: skip
            ends.append(np.concatenate([end.state.ravel(), end.touches["race"]]))
        apart = (ends[0] - ends[1]) / 2e-6
        np.testing.assert_allclose(moved, apart, rtol=0.0, atol=2e-7 * np.abs(moved).max())


def test_the_state_of_a_motion_has_a_shared_race_once():
    found = lyapunov_exponent(SYSTEM, contacts=contacts(0.3, 0.2), unbalance=UNBALANCE, speed=0.8,
                              transient=2, revolutions=80, batches=4)  # fmt: skip
    assert found.sizes["exponent"] == 2 * 6 + 1
