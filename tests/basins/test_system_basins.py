"""Basins of rotor systems: labels of one disc, exact whirls, and starts that lie where asked."""

import math

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    SimulationError,
    Unbalance,
    basin,
    basin_fractions,
    decode_flags,
    simulate,
    synchronous_response,
)
from rotor_ida.basins import subjects
from rotor_ida.basins.attractors import Attractors
from rotor_ida.basins.starts import Box
from rotor_ida.basins.subjects import KnockedSystem, pulled_shapes, settled_row
from rotor_ida.core.runs import NO_STOP
from rotor_ida.model.assembly import assemble
from rotor_ida.schema import FATE
from rotor_ida.simulation.starts import start_of_system
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow
from rotor_ida.verification.verify import rerun
from tests.basins.lanes import WHIP
from tests.random_systems import random_system

AXIS = np.linspace(-6.0, 6.0, 5)
# Rotors of one disc, planes of starts, and the kinds of response on which these end.
ONE_DISC = {
    "rub or no rub": (
        Rotor(omega=0.7, zeta=0.1, delta0=1.5, shaft_stiffness=0.1),
        {"x": np.linspace(-1.25, 0.25, 4), "y": np.linspace(-1.75, -1.0, 4)},
        {"contact_free", "synchronous"},
    ),
    "dry whip": (
        WHIP, {"x": AXIS, "y": 0.0, "vx": 0.5, "vy": AXIS}, {"synchronous", "rolling"}
    ),
    "touches that fade": (
        Rotor(omega=2.0, zeta=0.07, delta0=2.0), {"x": 0.6 * AXIS, "y": 0.6 * AXIS},
        {"contact_free", "bouncing"},
    ),
}  # fmt: skip
CHAIN = np.kron([[2.0, -1.0], [-1.0, 1.4]], np.eye(2))
SYSTEM = RotorSystem(
    mass=np.eye(4), stiffness=CHAIN, damping=0.1 * np.eye(4), nodes={"a": (0, 1), "b": (2, 3)},
    contacts=[Contact(node="b", clearance=0.3, stiffness=5.0)],
    unbalance=[Unbalance(node="a", moment=0.2)], units="1",
)  # fmt: skip
SPEED = 1.15
# Where both attractors of it have a share.
NEAR = {"speed": SPEED, "node": "b", "start": "settled"}
PLANE = {**NEAR, "x": np.linspace(-0.4, 0.1, 4), "y": np.linspace(-0.3, 0.3, 3)}
LOADED = Rotor(omega=1.7, zeta=0.1, delta0=1.0, shaft_stiffness=0.4, load=0.3)


@pytest.fixture(scope="module")
def found():
    return basin(SYSTEM, **PLANE)


def ends(result):
    """Return kind, smallest and largest radius of the end of each start, row by row."""
    table = result[["kind", "radius_min", "radius_max"]].isel(contact=0, missing_dims="ignore")
    return table.isel(attractor=result.label.values.ravel()).drop_vars("attractor", errors="ignore")


@pytest.mark.parametrize("name", ONE_DISC)
def test_one_disc_as_a_system_has_the_basins_of_one_disc(name):
    """Cell by cell: the side-by-side labels by regions that trap, and each start by itself."""
    rotor, plane, kinds = ONE_DISC[name]
    one = basin(rotor, **plane)
    many = basin(rotor.system(), speed=rotor.omega, node="disc", **plane)
    assert many.label.dims == one.label.dims
    assert set(decode_flags(many.kind).values.tolist()) == kinds
    np.testing.assert_array_equal(many.response, one.response)
    for edge in ("radius_min", "radius_max"):
        np.testing.assert_allclose(ends(many)[edge], ends(one)[edge], rtol=1e-8)
    for entropy in ("basin_entropy", "boundary_entropy"):
        np.testing.assert_allclose(many[entropy], one[entropy], rtol=1e-12)
    reached = one["count"].values > 0
    assert sorted(many["count"].values.tolist()) == sorted(one["count"].values[reached].tolist())
    assert int(many.undecided_count) == int(many.not_computed_count) == 0


def test_attractors_are_the_stable_exact_whirls(found):
    """One of them touches, the other does not; their features are those of closed forms."""
    exact = synchronous_response(SYSTEM, speed=SPEED).isel(speed=0)
    stable = decode_flags(exact.stability).values == "stable"
    exact = exact.isel(branch=stable).sortby("branch", ascending=False)
    assert decode_flags(found.kind).values.tolist() == ["synchronous", "contact_free"]
    assert (found["count"].values > 0).all()
    for name in ("amplitude", "phase_lag", "node_amplitude", "node_phase_lag"):
        np.testing.assert_allclose(found[name], exact[name], rtol=1e-8)
    np.testing.assert_allclose(found.largest_force, exact.normal_force, atol=1e-9)
    np.testing.assert_array_equal(found.touched, exact.in_contact)
    assert float(found.agreement) == 1.0
    assert int(found.agreement_count) > 0


def test_a_start_of_the_plane_ends_as_a_run_from_the_state_that_it_says(found):
    """The state is written here by solving for the force that holds the node aside."""
    q, velocity = start_of_system(assemble(SYSTEM), "settled", SPEED)
    flexibility = np.linalg.inv(CHAIN)[:, 2:]
    x, y = PLANE["x"][1], PLANE["y"][2]
    pulled = flexibility @ np.linalg.solve(flexibility[2:], np.array([x, y]) - q[2:])
    struck = np.array([0.0, 0.0, *-velocity[2:]])  # the masses are not coupled
    run = simulate(SYSTEM, speed=SPEED, start=(q + pulled, velocity + struck), duration=400.0)
    far = np.hypot(run.x, run.y).isel(node=1, t=slice(-200, None)).max()
    number = int(found.label.isel(x=1, y=2))
    assert float(far) == pytest.approx(float(found.radius_max[number, 0]), rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("start", [None, "settled", "given"])
def test_the_node_starts_where_it_is_asked_and_nothing_else_costs_less(seed, start):
    system, around = random_system(seed)
    given = around.pop("start") if start == "given" else start
    around.pop("start", None)
    problem = SettlingProblem.of(assemble(RotorSystem(**fields_of(system), **around)), 1e-10)
    knocked = KnockedSystem.at(problem, 0.8, "n1", given)
    flow = SystemFlow.at(problem, 0.8, NO_STOP)
    asked = np.array([[0.3, -0.2], [0.1, 0.4], [-0.5, 0.0], [0.7, 0.2]])
    begun = start_of_system(problem.assembly, given, 0.8)
    rows = problem.assembly.node_rows()[1]
    for state, own in zip(knocked.states(flow, asked), asked.T, strict=True):
        moved = problem.found.to_q(flow.motion_of(state))
        np.testing.assert_allclose(rows @ moved[0], own[:2], atol=1e-12)
        np.testing.assert_allclose(rows @ moved[1], own[2:], atol=1e-12)
        # forces and impulses act at the node alone
        for matrix, change in ((problem.assembly.stiffness, moved[0] - begun[0]),
                               (problem.assembly.mass, moved[1] - begun[1])):  # fmt: skip
            force = matrix @ change
            along = rows.T @ np.linalg.lstsq(rows.T, force)[0]
            np.testing.assert_allclose(force, along, atol=1e-10 * np.abs(force).max())


def fields_of(system):
    names = ("mass", "stiffness", "damping", "gyroscopic", "nodes", "units")
    return {name: getattr(system, name) for name in names}


def test_a_rotor_without_supports_turns_about_its_centre_of_percussion():
    """Nothing resists that motion; a rod of two masses turns about the one that is not struck."""
    found = pulled_shapes(np.zeros((4, 4)), np.eye(4)[:2])
    np.testing.assert_array_equal(found, np.eye(4)[:, :2])
    rigid = np.array([[1.0, -2.0, 1.0]])  # three equal masses on a rod that bends
    shape = pulled_shapes(rigid.T @ rigid, np.array([[1.0, 0.0, 0.0]]))[:, 0]
    np.testing.assert_allclose(shape, [1.0, 0.4, -0.2], atol=1e-12)  # linear, and of least squares


def test_copies_of_a_cycle_of_two_revolutions_are_one_attractor():
    """Starts reach it in either of its two revolutions, at whose ends the states differ."""
    system = LOADED.system()
    found = basin_fractions(system, speed=1.7, node="disc", x=(-2, 2), y=(-2, 2), starts=12, seed=2)
    assert decode_flags(found.kind).values.tolist() == ["bouncing"]
    assert found["count"].values.tolist() == [12]
    assert float(found.period[0]) == pytest.approx(4.0 * math.pi / 1.7, rel=1e-12)
    one = basin_fractions(LOADED, x=(-2, 2), y=(-2, 2), starts=12, seed=2)
    assert float(found.radius_max[0, 0]) == pytest.approx(float(one.radius_max[0]), rel=1e-7)
    flow = SystemFlow.at(SettlingProblem.of(assemble(system), 1e-10), 1.7, NO_STOP)
    starts = Box.of(12, 2, x=(-2, 2), y=(-2, 2), vx=0.0, vy=0.0).starts(0, 12)
    knocked = KnockedSystem.at(flow.problem, 1.7, "disc", None)
    rows = [settled_row(flow, state) for state in knocked.states(flow, starts)]
    apart = [np.abs(row["final_state"] - rows[0]["final_state"]).max() for row in rows]
    assert max(apart) > 0.1
    met = Attractors(flow)
    assert {met.number_of(row) for row in rows} == {0}


def test_motions_that_differ_are_not_taken_for_one():
    """Of a pair that only its sense of offset tells apart radii are equal, and states are not."""
    flow = SystemFlow.at(SettlingProblem.of(assemble(LOADED.system()), 1e-10), 1.7, NO_STOP)
    row = settled_row(flow, np.array([0.3, 0.0, 0.0, 0.0]))
    mirrored, longer, wider = row.copy(), row.copy(), row.copy()
    mirrored["final_state"] *= -1.0
    longer["period"] *= 1.01
    wider["radius_max"] *= 1.001
    met = Attractors(flow)
    assert [met.number_of(each) for each in (row, mirrored, longer, wider, row)] == [0, 1, 2, 3, 0]
    multiple = row.copy()
    multiple["period"] *= 3.0
    assert met.number_of(multiple) == 0
    assert met.rows[0]["period"] == row["period"]


def test_fractions_lie_within_their_errors_of_those_of_the_disc():
    """Other random starts, by the other kernel."""
    rotor, box = ONE_DISC["touches that fade"][0], {"x": (-4, 4), "y": (-4, 4)}
    one = basin_fractions(rotor, **box, starts=2000, seed=1)
    many = basin_fractions(rotor.system(), speed=2.0, node="disc", **box, starts=40, seed=2)
    bounces = one.response.values == 3
    share, error = (float(one[name].values[bounces].item())
                    for name in ("response_fraction", "response_fraction_error"))  # fmt: skip
    seen = many.sel(response=3)
    apart = abs(float(seen.response_fraction) - share)
    assert apart < 3.0 * math.hypot(float(seen.response_fraction_error), error)
    n, p = 40, many.fraction.values
    np.testing.assert_allclose(many.fraction_error, np.sqrt(p * (1.0 - p) / n), rtol=1e-12)
    assert many["count"].sum() == n - int(many.undecided_count)
    assert many.attrs["range_x"].tolist() == [-4.0, 4.0]


def test_a_start_that_fails_is_not_computed_and_says_why(found, monkeypatch):
    true, failing = subjects.settle_system, []

    def fails_once(flow, state):
        if not failing:
            failing.append(state)
            raise SimulationError("it cannot be followed")
        return true(flow, state)

    monkeypatch.setattr(subjects, "settle_system", fails_once)
    partly = basin(SYSTEM, **PLANE, workers=1, executor="serial")
    assert partly.attrs["not_computed_reason"] == "it cannot be followed"
    assert int(partly.not_computed_count) == 1
    rest = partly.label != FATE["not_computed"]
    assert partly.label.where(rest, found.label).astype(int).equals(found.label.astype(int))


def test_an_attractor_is_a_start(found):
    with pytest.raises(InputError, match="cannot be verified: it lacks its question"):
        rerun(found.assign_attrs(question=0))
    run = simulate(SYSTEM, speed=SPEED, start=found.isel(attractor=0), duration=20.0)
    far = np.hypot(run.x, run.y).isel(node=1)
    np.testing.assert_allclose(far, float(found.radius_max[0, 0]), rtol=1e-7)


def test_a_machine_in_si_units_has_units():
    scale = 1e-4
    system = RotorSystem(
        mass=10.0 * np.eye(4), stiffness=1e7 * CHAIN, damping=1e3 * np.eye(4),
        nodes={"a": (0, 1), "b": (2, 3)}, positions={"a": 0.1, "b": 0.3},
        contacts=[Contact(node="b", clearance=0.3 * scale, stiffness=5e7 / math.sqrt(scale))],
        unbalance=[Unbalance(node="a", moment=2.0 * scale)],
    )  # fmt: skip
    axes = {name: scale * PLANE[name] for name in ("x", "y")}
    small = basin(system, **PLANE | axes | {"speed": 1e3 * SPEED})
    large = basin(SYSTEM, **PLANE)
    np.testing.assert_array_equal(small.label, large.label)
    np.testing.assert_allclose(small.amplitude, scale * large.amplitude, rtol=1e-8)
    np.testing.assert_allclose(small.largest_force, 1e7 * scale * large.largest_force, rtol=1e-8)
    units = {"x": "m", "vx": "m s-1", "settling_time": "s", "amplitude": "m", "clearance": "m",
             "largest_force": "N", "speed": "s-1", "period": "s"}  # fmt: skip
    assert {name: small[name].attrs["units"] for name in units} == units
    with pytest.raises(InputError, match=r"rtol must lie from"):
        basin(system, **PLANE | axes, rtol=1.0)


def test_with_few_modes_the_basin_is_that_of_the_reduced_system(found):
    few = basin(SYSTEM, **PLANE, modes=4)
    np.testing.assert_array_equal(few.label, found.label)
    np.testing.assert_allclose(few.amplitude, found.amplitude, rtol=1e-8)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"node": "c"}, "node must be one of 'a', 'b', got 'c'"),
        ({"speed": 0.0}, "speed must not be 0 for a basin"),
        ({"contacts": []}, "contacts must be at least one for a basin"),
        ({"x": 0.0}, "exactly two of x, y, vx, vy must be arrays"),
        ({"start": "there"}, "start must be one of"),
        ({"start": (np.zeros(3), np.zeros(4))}, "displacement of the start must have the shape"),
        ({"speed": 1e-9}, "speed must be at least"),
    ],
)
def test_what_cannot_be_asked_is_refused_in_one_line(changes, words):
    with pytest.raises(InputError, match=words) as refused:
        basin(SYSTEM, **PLANE | changes)
    assert "\n" not in str(refused.value)


def test_a_system_without_damping_or_with_a_node_that_cannot_move_is_refused():
    undamped = RotorSystem(
        mass=np.eye(4), stiffness=CHAIN, nodes={"a": (0, 1), "b": np.eye(4)[[2, 2]]},
        contacts=[Contact(node="a", clearance=0.3, stiffness=5.0)], units="1",
    )  # fmt: skip
    with pytest.raises(InputError, match="damping must be above 0 for a basin"):
        basin(undamped, **PLANE)
    damped = RotorSystem(**fields_of(undamped) | {"damping": 0.1 * np.eye(4)},
                         contacts=undamped.contacts)  # fmt: skip
    with pytest.raises(InputError, match="node must move along x and along y, but 'b' does not"):
        basin(damped, **PLANE)
    with pytest.raises(TypeError, match=r"basin\(\) of a RotorSystem needs speed and node"):
        basin(SYSTEM, x=[0.0, 1.0], y=[0.0, 1.0])
    with pytest.raises(InputError, match="node must be left out with one disc, got 'disc'"):
        basin(WHIP, x=[0.0, 1.0], y=[0.0, 1.0], node="disc")
