"""Extrema of the distances of places of a rotor system, as its kernel observes them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import Rotor, RotorSystem
from rotor_ida.model.assembly import assemble
from rotor_ida.simulation.crossings import distance_extrema
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow
from tests.random_systems import random_system

GO_ON = np.zeros(1, np.uint8)


def flow_of(system, speed, rtol=1e-12):
    return SystemFlow.at(SettlingProblem.of(assemble(system), rtol), speed, GO_ON)


def test_an_ellipse_is_extreme_at_its_axes():
    """Of x = 3 cos(t), y = 2 sin(t) at every quarter of a turn, far more often than a table's room.

    The axes are those of a vibration without unbalance, which the spin leaves alone.
    """
    system = RotorSystem(
        mass=4.0 * np.eye(2), stiffness=4.0 * np.eye(2), nodes={"disc": (0, 1)}
    )  # fmt: skip
    flow, turns = flow_of(system, 0.7), 1000
    start = flow.given_state(np.array([3.0, 0.0, 0.0, 2.0]))
    table = flow.extrema(start, (turns + 0.1) * math.tau, flow.observable(nodes=True))
    between = table[table["kind"] != 0]
    quarters = np.arange(1, 4 * turns + 1)
    drift = 1e-13 * quarters  # rounding over thousands of steps
    assert np.all(np.abs(between["time"] - 0.5 * math.pi * quarters) <= 1e-11 + 10.0 * drift)
    np.testing.assert_array_equal(between["kind"], np.where(quarters % 2, -1, 1))
    expected = np.where(quarters % 2, 2.0, 3.0)
    np.testing.assert_allclose(between["distance"], expected, rtol=1e-11)
    assert table["distance"][0] == 3.0
    assert table["distance"][-1] == pytest.approx(math.hypot(
        3.0 * math.cos(0.1 * math.tau), 2.0 * math.sin(0.1 * math.tau)), rel=1e-9)  # fmt: skip


def test_a_beat_is_extreme_where_its_rate_is_zero():
    """Of stiffness that differs in both directions, by the closed form of the motion."""
    system = RotorSystem(
        mass=np.eye(2), stiffness=np.diag([1.0, 2.0]), nodes={"disc": (0, 1)}
    )  # fmt: skip
    flow, rate = flow_of(system, 0.7), math.sqrt(2.0)
    start = flow.given_state(np.array([1.0, 0.0, 0.0, rate]))  # cos(t), sin(rate t)
    table = flow.extrema(start, 200.0, flow.observable(nodes=True))
    between = table[table["kind"] != 0]
    t = between["time"]
    change = -np.sin(2.0 * t) + rate * np.sin(2.0 * rate * t)  # of the square
    np.testing.assert_allclose(change, 0.0, atol=1e-12)
    bend = -2.0 * np.cos(2.0 * t) + 4.0 * np.cos(2.0 * rate * t)
    np.testing.assert_array_equal(between["kind"], -np.sign(bend))
    exact = np.hypot(np.cos(t), np.sin(rate * t))
    np.testing.assert_allclose(between["distance"], exact, rtol=0.0, atol=1e-12)
    seen = np.linspace(0.0, 200.0, 200_001)
    changes = -np.sin(2.0 * seen) + rate * np.sin(2.0 * rate * seen)
    assert len(between) == np.count_nonzero(changes[1:-1] * changes[2:] < 0.0)


@pytest.mark.parametrize("seed", range(12))
def test_extrema_take_turns_and_bound_all_samples(seed):
    """Of random systems through all kinds of events, also with stators without mass.

    The radius at every sample lies between the extrema on its two sides.
    """
    system, around = random_system(seed)
    begun = around.pop("start")
    flow = flow_of(replace(system, **around), 0.7)
    size, duration = flow.problem.assembly.size, 40.0
    start = np.zeros((2, size))
    start[:, : system.size] = begun
    state = flow.given_state(np.append(start, flow.problem.race_speeds))
    places, times = flow.observable(nodes=True), np.linspace(0.0, duration, 8001)
    whole = flow.extrema(state, duration, places)
    motion = flow.sampled(state, times).samples[:, 0]
    for number, (rows, centre) in enumerate(zip(*places, strict=True)):
        table = whole[whole["place"] == number]
        assert (np.diff(table["time"]) >= 0.0).all()
        np.testing.assert_array_equal(np.abs(np.diff(table["kind"][1:-1])), 2)
        radii = np.hypot(*(motion @ rows.T - centre).T)
        after = np.clip(np.searchsorted(table["time"], times), 1, len(table) - 1)
        ends = np.array([table["distance"][after - 1], table["distance"][after]])
        assert (radii <= ends.max(axis=0) + 1e-9 * radii.max()).all()
        assert (radii >= ends.min(axis=0) - 1e-9 * radii.max()).all()


def test_a_circle_is_constant():
    rotor = Rotor(omega=0.5, zeta=0.1, delta0=3.0, shaft_stiffness=1.0)
    flow = flow_of(rotor.system(), rotor.omega)
    settled = flow.after(np.zeros(4), 100 * flow.revolution)
    places = flow.observable()
    table = distance_extrema(flow, settled, 20 * flow.revolution, places)
    assert table["kind"].tolist() == [0]
    at = abs(0.25 / (1.0 - 0.25 + 2j * 0.1 * 0.5))
    assert table["distance"][0] == pytest.approx(at, rel=1e-9)
    assert [each.size >= 2 for each in flow.radii(flow.run(settled, flow.revolution))] == [True]
