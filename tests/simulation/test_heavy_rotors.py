"""A rotor under a load starts at rest where it hangs, or where it lies on the stator."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from rotor_ida import (
    Contact,
    DimensionalRotor,
    Rotor,
    RotorSystem,
    Unbalance,
    run_up,
    simulate,
    summary,
    sweep,
)

HANGING = Rotor(omega=0.3, zeta=0.1, delta0=4.0, shaft_stiffness=1.0, load=0.5)
LYING = Rotor(omega=0.3, zeta=0.1, delta0=0.2, shaft_stiffness=1.0, load=0.5)


def heavy(clearance, *, moment=0.0, exponent=1.5):
    """Return two discs on a shaft, both heavy, the first in a stator."""
    stiffness = np.kron([[3.0, -1.0], [-1.0, 2.0]], np.eye(2))
    return RotorSystem(
        mass=np.eye(4), damping=0.2 * np.eye(4), stiffness=stiffness, gravity=(0.0, -0.5),
        nodes={"a": (0, 1), "b": (2, 3)}, units="1",
        contacts=[Contact(node="a", clearance=clearance, stiffness=7.0, exponent=exponent)],
        unbalance=[Unbalance(node="a", moment=moment)] if moment else [],
    )  # fmt: skip


def test_hertz_and_shaft_carry_the_weight():
    """``k (s - delta)**1.5 + k_s s = weight``, in SI units too."""
    sag = brentq(lambda s: (s - 0.2) ** 1.5 + s - 0.5, 0.2, 0.5, xtol=1e-15)
    start = simulate(LYING, duration=1.0).attrs["start"]
    np.testing.assert_allclose(start, (0.0, -sag, 0.0, 0.0), atol=1e-14)
    pump = DimensionalRotor(
        mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=2e-6, clearance=1e-5,
        speed=30.0, shaft_stiffness=2e6, load=4.0 * 9.81,
    )  # fmt: skip
    run = simulate(pump, duration=0.01)
    sag = brentq(lambda s: 1e9 * (s - 1e-5) ** 1.5 + 2e6 * s - 39.24, 1e-5, 1e-4, xtol=1e-18)
    assert run.y[0].item() == pytest.approx(-sag, rel=1e-12)


@pytest.mark.parametrize("clearance", [1.0, 0.1])
def test_two_discs_hang_where_shaft_and_contact_hold_them(clearance):
    """By one equation for the indentation, with the shaft's forces solved for."""
    shaft, weight = np.array([[3.0, -1.0], [-1.0, 2.0]]), np.full(2, 0.5)

    def down(force):
        return np.linalg.solve(shaft, weight - np.array([force, 0.0]))

    push = 0.0
    if down(0.0)[0] > clearance:
        push = brentq(lambda f: 7.0 * max(down(f)[0] - clearance, 0.0) ** 1.5 - f, 0.0, 1.0)
    run = simulate(heavy(clearance), speed=0.4, duration=1.0)
    np.testing.assert_allclose(run.y.isel(t=0), -down(push), rtol=1e-9)
    assert (push > 0.0) == (clearance < 0.3)


@pytest.mark.parametrize("clearance", [1.0, 0.1])
def test_without_unbalance_it_stays_there(clearance):
    run = simulate(heavy(clearance), speed=0.4, duration=50.0)
    still = run.isel(t=0)
    for name in ("x", "y", "vx", "vy"):
        assert np.abs(run[name] - still[name]).max() < 1e-12, name
    assert run.sizes["event"] == 0


def test_an_explicit_start_means_what_it_says():
    for rotor in (HANGING, LYING):
        run = simulate(rotor, start=(0, 0, 0, 0), duration=1.0)
        assert (run.x[0].item(), run.y[0].item()) == (0.0, 0.0)
    run = simulate(heavy(1.0), speed=0.4, start=(np.zeros(4), np.zeros(4)), duration=1.0)
    assert (run.y.isel(t=0) == 0.0).all()


def test_without_a_load_or_a_hold_it_starts_on_the_axis():
    light = Rotor(omega=0.3, zeta=0.1, delta0=4.0, shaft_stiffness=1.0)
    assert (simulate(light, duration=1.0).attrs["start"] == 0.0).all()
    falls = RotorSystem(
        mass=np.eye(2), stiffness=np.zeros((2, 2)), nodes={"d": (0, 1)}, gravity=(0.0, -2.0),
        units="1",
    )  # fmt: skip
    with pytest.warns(UserWarning, match="hold"):
        run = simulate(falls, speed=0.4, duration=3.0)
    assert run.y[-1].item() == pytest.approx(-9.0, rel=1e-12)


def test_a_slow_run_up_of_a_system_touches_first_where_the_linear_response_does():
    matrix = np.array([[3.0, -1.0], [-1.0, 2.0]])
    sag = np.linalg.solve(matrix, np.full(2, 0.5))[0]

    def of_system(speed):
        dynamic = matrix - speed**2 * np.eye(2) + 0.2j * speed * np.eye(2)
        return sag + abs(np.linalg.solve(dynamic, [speed**2, 0.0])[0]) - 2.0

    touch, late = brentq(of_system, 0.9, 1.17), []
    for rate in (4e-4, 1e-4):
        run = run_up(heavy(2.0, moment=1.0), speed=0.9, to=1.2, rate=rate)
        late.append(run.event_speed[0].item() - touch)
    assert abs(late[0]) < 1e-2
    assert abs(late[1]) < 0.5 * abs(late[0])


def test_one_that_lies_on_its_stator_does_not_touch_it_first():
    sag = brentq(lambda s: (s - 0.2) ** 1.5 + s - 0.5, 0.2, 0.5)
    told = summary(run_up(LYING, to=0.5, rate=0.01)).attrs["sentence"]
    assert told.startswith(f"Rub: it starts at rest on the stator, {sag:.3g} below the axis, and")
    told = summary(run_up(HANGING, to=0.4, rate=0.01)).attrs["sentence"]
    assert "It starts hanging 0.5 below the axis." in told


def test_each_point_of_a_sweep_begins_where_its_rotor_hangs():
    loads = [0.2, 0.4]
    plain = sweep(omega=0.3, zeta=0.1, delta0=4.0, shaft_stiffness=1.0, load=loads)
    word = sweep(omega=0.3, zeta=0.1, delta0=4.0, shaft_stiffness=1.0, load=loads, starts="rest")
    assert plain.equals(word)
    both = [sweep(heavy(1.0, moment=0.1), speed=[0.4], starts=[each]) for each in (None, "rest")]
    np.testing.assert_array_equal(both[0].final_state, both[1].final_state)
    y = both[0].initial_state.values.ravel()[[1, 3]]
    np.testing.assert_allclose(y, -np.linalg.solve([[3, -1], [-1, 2]], [0.5, 0.5]), rtol=1e-9)
    assert math.isfinite(both[0].radius_max.max())
