"""Run-ups with bearings by a table: by DOP853, by the reference simulator, and by what is kept."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

from rotor_ida import (
    Bearing,
    Contact,
    InputError,
    RotorSystem,
    SimulationError,
    Support,
    Unbalance,
    run_up,
)
from rotor_ida.core.system_requests import LAW_CHANGE, ByParameter
from rotor_ida.core.systems import follow_system
from rotor_ida.model.assembly import assemble, canonical
from rotor_ida.simulation.course import SYSTEM_LIMITS, course_of
from rotor_ida.simulation.runs import _prepared

SPEEDS = np.array([0.1, 0.6, 1.0, 1.7, 2.3, 3.1])
RANDOM = np.random.default_rng(3)
TABLES = [
    {"stiffness": size * np.eye(2) + 0.3 * RANDOM.normal(size=(6, 2, 2)),
     "damping": 0.3 * size * np.eye(2) + 0.05 * RANDOM.normal(size=(6, 2, 2))}
    for size in (0.8, 0.6)
]  # fmt: skip
FILMS = [Bearing(node=n, speed=SPEEDS, **t) for n, t in zip("ab", TABLES, strict=True)]
TURNED = np.array([[0.0, 1.0], [-1.0, 0.0]])
MOMENT = 0.5
ROTOR = RotorSystem(
    mass=np.kron([[2.0, 0.1], [0.1, 1.0]], np.eye(2)),
    stiffness=np.kron([[1.5, -1.0], [-1.0, 1.2]], np.eye(2)), damping=0.05 * np.eye(4),
    gyroscopic=np.kron(np.diag([0.2, 0.1]), TURNED), nodes={"a": (0, 1), "b": (2, 3)}, units="1",
    unbalance=[Unbalance(node="a", moment=MOMENT)], bearings=FILMS,
    stiffness_rate=0.1 * np.diag([1.0, 1.0, 2.0, 2.0]),
)  # fmt: skip
RUB = Contact(node="a", clearance=0.3, stiffness=50.0, friction=0.1, radius=2.0, damping=0.2)
TOUCHES = [RUB, replace(RUB, node="b", clearance=0.4, exponent=1.0)]
RUBBING = replace(ROTOR, contacts=TOUCHES, gravity=(0.0, -0.3))
ON_AXIS = (np.zeros(4), np.zeros(4))


BY_SCIPY = [[PchipInterpolator(SPEEDS, table[name]) for name in ("stiffness", "damping")]
            for table in TABLES]  # fmt: skip


def coefficients(speed):
    """Return the matrices of both bearings at a speed, by SciPy."""
    found = [np.zeros((4, 4)), np.zeros((4, 4))]
    for place, tables in enumerate(BY_SCIPY):
        here = slice(2 * place, 2 * place + 2)
        for matrix, table in zip(found, tables, strict=True):
            matrix[here, here] = table(speed)
    return found


def integrated(rates, state, times, breaks=()):
    """Return states at times by DOP853, restarted at breaks, where derivatives jump."""
    found = {times[0]: state}
    for begin, end in pairwise(np.unique([*times, *breaks])):
        found[end] = state = solve_ivp(
            rates, (begin, end), state, method="DOP853", rtol=1e-12, atol=1e-14
        ).y[:, -1]
    return np.array([found[each] for each in times])


def accelerations(angle, speed, rate, q, v, matrices=coefficients):
    """Return the accelerations of the rotor, and the power that its bearings take."""
    stiffness, damping = matrices(speed)
    taken = stiffness @ q + damping @ v
    force = -(ROTOR.stiffness + rate * ROTOR.stiffness_rate) @ q - taken
    force -= (ROTOR.damping + speed * ROTOR.gyroscopic) @ v
    along, ahead = np.array([np.cos(angle), np.sin(angle)]), np.array([np.sin(angle),
                                                                      -np.cos(angle)])  # fmt: skip
    force[:2] += MOMENT * (speed**2 * along + rate * ahead)
    return np.linalg.solve(ROTOR.mass, force), taken @ v


def along_ramp(first, rate, matrices=coefficients):
    """Return the rates of displacements, velocities and the work of bearings on a ramp."""

    def rates(time, state):
        angle, speed = (first + 0.5 * rate * time) * time, first + rate * time
        a, power = accelerations(angle, speed, rate, state[:4], state[4:8], matrices)
        return [*state[4:8], *a, power]

    return rates


def motion_of(run):
    """Return displacements and velocities of both nodes at samples, shape (t, 8)."""
    names = [(name, node) for velocity in ("", "v") for node in "ab" for name in
             (f"{velocity}x", f"{velocity}y")]  # fmt: skip
    return np.column_stack([run[name].sel(node=node) for name, node in names])


def knots_of(first, rate):
    """Return the times at which a ramp passes knots."""
    return (SPEEDS - first) / rate


@pytest.mark.parametrize(("first", "to"), [(0.2, 3.0), (3.1, 0.1)])
def test_a_run_up_and_a_run_down_are_those_of_another_integrator(first, to):
    rate = np.sign(to - first) * 0.03
    run = run_up(ROTOR, speed=first, to=to, rate=rate, samples=9)
    times = run.t.values
    inside = [each for each in knots_of(first, rate) if 1e-9 < each < times[-1] - 1e-9]
    exact = integrated(along_ramp(first, rate), np.zeros(9), times, inside)
    np.testing.assert_allclose(motion_of(run), exact[:, :8], rtol=0.0, atol=1e-9)
    assert run.attrs["energy_bearings"] == pytest.approx(exact[-1, 8], rel=1e-9)


def test_speeds_turn_inside_an_interval_and_at_a_knot():
    points = [(0.0, 1.0), (20.0, 0.6), (40.0, 1.5), (45.0, 1.5), (60.0, 0.8)]
    run = run_up(ROTOR, speeds=points, samples=np.array([0.0, 10.0, 25.0, 42.0, 60.0]))
    state, angle, reached = np.zeros(9), 0.0, {}
    for (begin, first), (end, last) in pairwise(points):
        rate, span = (last - first) / (end - begin), end - begin
        times = np.unique([begin, *run.t.values[(run.t > begin) & (run.t < end)], end])
        ramp = along_ramp(first, rate)

        def rates(time, state, ramp=ramp, begin=begin, angle=angle, first=first, rate=rate):
            if angle == 0.0:
                return ramp(time - begin, state)
            since = time - begin
            turned, speed = angle + (first + 0.5 * rate * since) * since, first + rate * since
            a, power = accelerations(turned, speed, rate, state[:4], state[4:8])
            return [*state[4:8], *a, power]

        inside = [] if rate == 0.0 else begin + knots_of(first, rate)
        inside = [each for each in inside if begin + 1e-9 < each < end - 1e-9]
        found = integrated(rates, state, times, inside)
        reached |= dict(zip(times, found, strict=True))
        state, angle = found[-1], angle + 0.5 * (first + last) * span
    exact = np.array([reached[each] for each in run.t.values])
    np.testing.assert_allclose(motion_of(run), exact[:, :8], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("contacts", [[], [RUB]])
def test_equal_rows_are_constant_coefficients(contacts):
    rows = {name: np.broadcast_to(TABLES[0][name][4], (6, 2, 2)) for name in TABLES[0]}
    own = {name: each[4] for name, each in TABLES[0].items()}
    table, constant = (
        run_up(replace(ROTOR, bearings=[Bearing(node="a", **each)], contacts=contacts),
               speed=0.2, to=2.0, rate=0.04, samples=7, rtol=1e-12)
        for each in ({"speed": SPEEDS, **rows}, own)
    )  # fmt: skip
    assert table.sizes["event"] == constant.sizes["event"]
    np.testing.assert_allclose(table.event_time, constant.event_time, rtol=1e-12)
    np.testing.assert_allclose(motion_of(table), motion_of(constant), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("method", ["taylor", "adams"])
def test_events_are_those_of_the_reference_simulator(method):
    given: dict[str, Any] = {"start": ON_AXIS, "speed": 0.3, "to": 1.2, "rate": 0.04}
    run = run_up(RUBBING, method=method, rtol=1e-11, **given)
    slow = run_up(RUBBING, method="adams", backend="python", rtol=1e-12, samples=2, **given)
    assert run.sizes["event"] >= 8
    np.testing.assert_array_equal(run.event_kind, slow.event_kind)
    np.testing.assert_array_equal(run.event_contact, slow.event_contact)
    np.testing.assert_allclose(run.event_time, slow.event_time, rtol=0.0, atol=1e-8)


def test_the_energy_balances_with_the_work_of_the_bearings():
    """Between rubs and under a load."""
    run = run_up(RUBBING, start=ON_AXIS, speed=0.3, to=2.8, rate=0.04)
    q, v = run.final_state.values.reshape(2, 4)
    kept = 0.5 * v @ ROTOR.mass @ v + 0.5 * q @ ROTOR.stiffness @ q
    kept -= ROTOR.weight((0.0, -0.3)) @ q
    lost = [run.attrs[f"energy_{each}"] for each in
            ("damping", "stiffness_rate", "normal", "tangential", "bearings")]  # fmt: skip
    assert kept == pytest.approx(run.attrs["energy_unbalance"] - sum(lost), rel=1e-10)
    assert abs(lost[-1]) > 0.1 * run.attrs["energy_unbalance"]


def driven(torque, inertia):
    """Return the rates of displacements, velocities, angle and speed under a torque."""
    own = inertia + MOMENT**2 * np.linalg.inv(ROTOR.mass)[0, 0]

    def rates(_, state):
        q, v, angle, speed = state[:4], state[4:8], state[8], state[9]
        ahead = np.zeros(4)
        ahead[:2] = MOMENT * np.array([-np.sin(angle), np.cos(angle)])
        steady, _ = accelerations(angle, speed, 0.0, q, v)
        by_rate = np.linalg.solve(ROTOR.mass, ahead + ROTOR.stiffness_rate @ q)
        # M a = f - rate (ahead + K_dot q);  J rate = torque - ahead.a
        rate = (torque[0] - torque[1] * speed - ahead @ steady) / (own - ahead @ by_rate)
        return [*v, *(steady - rate * by_rate), speed, rate]

    return rates


def test_a_torque_passes_knots_up_and_down():
    case = {"torque": (0.9, 0.4), "inertia": 3.0}
    run = run_up(ROTOR, speed=0.2, duration=60.0, samples=13, **case)
    exact = integrated(driven(**case), np.array([*np.zeros(9), 0.2]), run.t.values)
    np.testing.assert_allclose(run.speed, exact[:, 9], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(motion_of(run), exact[:, :8], rtol=0.0, atol=1e-8)


@pytest.mark.parametrize(("torque", "end"), [((3.0, 0.2), 3.1), ((-1.0, 0.2), 0.1)])
def test_a_torque_that_leads_out_of_a_table_ends_the_run(torque, end):
    def leaves(_, state):
        return state[9] - end

    leaves.terminal = True
    begun = np.array([*np.zeros(9), 0.8])
    exact = solve_ivp(
        driven(torque, 2.0), (0.0, 20.0), begun, method="DOP853", rtol=1e-11, atol=1e-13,
        events=leaves,
    )  # fmt: skip
    words = rf"the torque drives the speed out of the table of a bearing, which ends at {end:g} "
    with pytest.raises(SimulationError, match=words) as ended:
        run_up(ROTOR, speed=0.8, torque=torque, inertia=2.0, duration=20.0)
    assert ended.value.time == pytest.approx(exact.t[-1], rel=1e-7)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"speed": 0.5, "to": 3.2, "rate": 0.1}, "3.2"),
        ({"speed": 0.05, "to": 3.0, "rate": 0.1}, "0.05"),
        ({"speed": 0.5, "rate": -0.1, "duration": 20.0}, "-1.5"),
        ({"speeds": [(0.0, 0.5), (1.0, 3.5), (2.0, 0.5)]}, "3.5"),
        ({"speed": 4.0, "torque": (1.0, 0.0), "inertia": 1.0, "duration": 1.0}, "4"),
    ],
)
def test_a_speed_outside_a_table_is_refused_before_the_run(given, told):
    words = rf"speed must lie within the table of the bearing at 'a', from 0.1 to 3.1, got {told}"
    with pytest.raises(InputError, match=words) as refused:
        run_up(ROTOR, **given)
    assert "\n" not in str(refused.value)


def request_of_ramp():
    """Return the request of a run-up to the core."""
    course = course_of(0.3, {"to": 1.2, "rate": 0.06}, None, SYSTEM_LIMITS)
    return _prepared(RUBBING, ON_AXIS, course, np.array([0.0, course.end]), 1e-12).request


def test_columns_are_derivatives_of_the_motion():
    """Of each number of the start and of the unbalance, with touches, by central differences."""
    asked = request_of_ramp()
    changes, step = np.zeros((9, 10)), 1e-6
    changes[:8, :8] = np.eye(8)
    by = ByParameter(unbalance=asked.unbalance, laws=np.zeros(2, LAW_CHANGE))
    found = follow_system(replace(asked, columns=changes, parameters=[by]))
    assert found.event_times.size >= 4
    for number, column in enumerate(found.columns):
        ends = []
        for side in (1.0, -1.0):
            moved = asked.start + side * step * changes[number, :8].reshape(2, 4)
            factor = 1.0 + side * step * (number == 8)
            ends.append(replace(asked, start=moved, unbalance=factor * asked.unbalance))
        one, other = (follow_system(each).state.ravel() for each in ends)
        np.testing.assert_allclose(column[:8], (one - other) / (2.0 * step), rtol=0.0, atol=2e-7)


def test_a_run_that_goes_on_with_more_room_is_the_same(monkeypatch):
    asked = request_of_ramp()
    once = follow_system(asked)
    monkeypatch.setattr("rotor_ida.core.systems.FIRST_ROOM", 1)
    again = follow_system(asked)
    assert once.event_times.size > 12  # more than the room for the first ones
    np.testing.assert_array_equal(again.state, once.state)
    np.testing.assert_array_equal(again.event_times, once.event_times)


def test_supports_carry_what_the_bearings_leave_at_the_first_speed():
    held = replace(ROTOR, gravity=(0.0, -0.1), supports=[Support(node="b", stiffness=1.0)])
    loaded, expected = assemble(held, speeds=np.array([0.9])), assemble(held.at(0.9))
    np.testing.assert_allclose(loaded.force, expected.force, rtol=1e-13)
    np.testing.assert_allclose(canonical(loaded).at(0.9).stiffness, canonical(expected).stiffness,
                               rtol=1e-13, atol=1e-15)  # fmt: skip
