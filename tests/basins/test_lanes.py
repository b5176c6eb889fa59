"""The lanes' arithmetic: the model's own force and rate, and a method of order 8."""

import cmath
import math
import platform
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import DOP853, solve_ivp

import rotor_ida
from rotor_ida import Rotor
from rotor_ida.basins import kernel, known
from rotor_ida.basins.kernel import LANES, NOT_FORWARDS, SECTION, UNDECIDED
from rotor_ida.core.identity import library_path
from rotor_ida.model.equations import push_over_radius, rotating_field
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run
from tests.basins.lanes import MACHINES, RUBBING, field, followed, slip_of

CORE = Path(rotor_ida.__file__).parent / "core"
SOURCE = (CORE / "lanes.c").read_text()
ROTOR = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
FIRST_STEP = 0.02


def table(name):
    """Return a table of the source."""
    numbers = re.search(rf"double {name}\[\] = \{{([^}}]*)\}}", SOURCE)[1]
    return np.array([float(number) for number in numbers.split(",")])


def constant(name):
    """Return a constant of the source."""
    return float(re.search(rf"\b{name} = ([-+.\de]+)", SOURCE)[1])


def error_of(found, exact, time, rotor):
    """Return the error of a state, but for what the time is off by, told in single precision."""
    along = rotating_field(exact, rotor)
    apart = found - exact
    off = 0.5 * float(np.spacing(np.float32(time)))
    shift = np.clip(apart @ along / (along @ along), -off, off)
    return np.abs(apart - shift * along).max()


@pytest.mark.parametrize("stage", range(2, 13))
def test_stages_are_those_of_dop853(stage):
    row = DOP853.A[stage - 1]
    np.testing.assert_array_equal(table(f"STAGE_{stage}"), row[row != 0.0])


def test_step_and_error_are_those_of_dop853():
    np.testing.assert_array_equal(table("ADVANCE"), DOP853.B[DOP853.B != 0.0])
    np.testing.assert_array_equal(table("FIFTH"), DOP853.E5[DOP853.E5 != 0.0])
    less = DOP853.B - DOP853.E3[:-1]
    np.testing.assert_array_equal(table("THIRD"), less[less != 0.0])


def test_python_and_c_agree_on_what_both_state():
    assert constant("LANES") == LANES
    assert constant("REGION") == kernel.REGION.itemsize // 8
    assert constant("SECTION") == SECTION.itemsize // 8
    assert constant("NO_ATTRACTOR") == UNDECIDED
    assert constant("NOT_FORWARDS") == kernel.NOT_FORWARDS
    assert constant("MOST_DRIFT") == known.MOST_DRIFT
    assert constant("FIRST_STEP") == FIRST_STEP


@pytest.mark.parametrize(
    ("rotor", "farthest"),
    [
        *((Rotor(omega=1.7, zeta=0.07, delta0=delta0), 30.0) for delta0 in (0.0, 0.5, 3.0)),
        *((rotor, 1.5) for rotor in (*MACHINES, *RUBBING.values())),
    ],
    ids=str,
)
def test_one_step_is_that_of_the_models_own_field(rotor, farthest):
    """A first step is exact to rounding: its end is that of the field of `model.equations`.

    Steps over the ring, and to where the contact lets go, are left out: there it is not; and with
    friction depths at which the force has hardly begun. Any error is allowed, so that no step is
    taken again. A disc that may not slide forwards throughout is left alone.
    """
    states = np.random.default_rng(0).normal(0.0, 3.0, (4, LANES))
    states[:2] *= np.geomspace(0.3, farthest, LANES)
    ends, labels, times = followed(rotor, states, FIRST_STEP, 1e3)
    compared = 0
    assert (times[labels == UNDECIDED] == np.float32(FIRST_STEP)).all()
    for number, start in enumerate(states.T):
        exact = solve_ivp(
            lambda _, state: field(state, rotor), (0.0, FIRST_STEP), start,
            method="DOP853", rtol=1e-13, atol=1e-13,
        ).y[:, -1]  # fmt: skip
        both = np.stack([start, exact], axis=1)
        depths, slip = np.hypot(*both[:2]) - rotor.delta0, slip_of(both, rotor)
        touches = (depths > 0.0).any()
        if rotor.friction and touches and slip.min() <= 0.0:
            assert labels[number] == NOT_FORWARDS
        elif not rotor.friction or not touches or slip.min() > abs(slip[1] - slip[0]):
            assert labels[number] == UNDECIDED
        pushes = [push_over_radius(state, rotor) > 0.0 for state in both.T]
        least = 0.1 if rotor.friction else 0.0
        if (depths.max() <= 0.0 or depths.min() > least) and pushes[0] == pushes[1]:
            size = 1.0 + np.abs(start).max() ** 1.5
            np.testing.assert_allclose(ends[:, number], exact, rtol=0.0, atol=1e-12 * size)
            compared += 1
    assert compared > LANES // 2


@pytest.mark.parametrize("delta0", [0.0, 0.5])
def test_there_is_no_force_at_the_centre(delta0):
    """Without unbalance a rotor at rest at the centre stays there."""
    ends, _, times = followed(
        Rotor(omega=0.0, zeta=0.1, delta0=delta0), np.zeros((4, 1)), 9.0, 1e-6
    )
    assert times[0] >= 9.0
    assert (ends == 0.0).all()


def test_error_falls_with_the_tolerance():
    """The error against CVODE falls by more than twenty for each hundred of the tolerance."""
    states = np.random.default_rng(1).uniform(-5.0, 5.0, (4, 4))
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8):
        ends, _, times = followed(ROTOR, states, 20.0, tolerance)
        worst = 0.0
        for found, start, time in zip(ends.T, states.T, times.tolist(), strict=True):
            options = Options(rtol=1e-13, atol=1e-14)
            x, y, vx, vy = run(ROTOR, tuple(start.tolist()), time, np.empty(0), options).end
            turn = np.exp(-1j * ROTOR.omega * time)
            z, w = complex(x, y) * turn, complex(vx, vy) * turn
            exact = np.array([z.real, z.imag, w.real, w.imag])
            worst = max(worst, error_of(found, exact, time, ROTOR))
        errors.append(worst)
    assert errors[0] < 1e-2
    assert errors[1] < errors[0] / 20.0
    assert errors[2] < errors[1] / 20.0


def test_steps_over_the_ring_are_as_exact_as_others():
    """From far out they leave the ring within the time: the error is that of the tolerance."""
    states = np.zeros((4, LANES))
    states[:2] = np.random.default_rng(2).uniform(8.0, 14.0, (2, LANES))
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=2.0)
    assert (np.hypot(*states[:2]) > 2.0).all()
    for tolerance in (1e-10, 1e-12):
        ends, _, times = followed(rotor, states, 4.0, tolerance)
        for found, start, time in zip(ends.T, states.T, times.tolist(), strict=True):
            exact = DiscFlow(rotor).states(start, np.array([time]))[-1]
            assert error_of(found, exact, time, rotor) < 100.0 * tolerance


@pytest.mark.parametrize("rotor", MACHINES[:4], ids=repr)
@pytest.mark.parametrize("tolerance", [1e-10, 1e-12])
def test_steps_over_the_ring_and_the_release_are_as_exact_as_others(rotor, tolerance):
    """From just outside they fly in, fast enough to be let go on the way where there is c."""
    random, states = np.random.default_rng(2), np.empty((4, LANES))
    directions = np.exp(1j * random.uniform(0.0, 2.0 * math.pi, LANES))
    positions = random.uniform(1.0, 1.5, LANES) * directions
    speeds = -random.uniform(1.0, 6.0, LANES) * directions
    states[:] = positions.real, positions.imag, speeds.real, speeds.imag
    duration, left, released = 1.0, 0, 0
    ends = followed(rotor, states, duration, tolerance)[0]
    for number in range(LANES):
        x, y, u, v = states[:, number].tolist()
        done = run(rotor, (x, y, u, v), duration, np.empty(0), Options(method="taylor", rtol=1e-13))
        left += bool((done.event_kinds == -1).any())
        released += bool((done.event_kinds == -4).any())
        turn = cmath.exp(-1j * rotor.omega * duration)
        exact = np.array([complex(*done.end[:2]) * turn, complex(*done.end[2:]) * turn])
        found = np.array([complex(*ends[:2, number]), complex(*ends[2:, number])])
        assert np.abs(found - exact).max() < 300.0 * tolerance
    assert left > LANES // 2
    assert (released > 0) == (rotor.contact_damping > 0.0)


def test_a_step_that_is_too_long_is_taken_back():
    """Far out the force is so stiff that the first step is far too long."""
    states = np.array([[1e9], [0.0], [0.0], [0.0]])
    ends, _, times = followed(ROTOR, states, FIRST_STEP, 1e-9)
    assert times[0] == np.float32(FIRST_STEP)
    expected = solve_ivp(
        lambda _, state: rotating_field(state, ROTOR), (0.0, float(times[0])), states[:, 0],
        method="DOP853", rtol=1e-13, atol=1e-13,
    ).y[:, -1]  # fmt: skip
    np.testing.assert_allclose(ends[:, 0], expected, rtol=1e-5, atol=1e3)


@pytest.mark.parametrize(("delta0", "bad"), [(0.0, 1e200), (0.5, np.nan)])
def test_a_force_that_is_no_number_moves_nothing_and_leaves_the_neighbours_alone(delta0, bad):
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=delta0)
    states = np.array([[bad, 3.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    ends, _, times = followed(rotor, states, 1.0, 1e-6)
    alone, _, time = followed(rotor, states[:, 1:].copy(), 1.0, 1e-6)
    assert times[0] == 0.0
    np.testing.assert_array_equal(ends[:, 0], states[:, 0])
    np.testing.assert_array_equal(ends[:, 1], alone[:, 0])
    assert times[1] == time[0]


@pytest.mark.skipif(platform.machine() not in {"x86_64", "AMD64"}, reason="reads x86 assembly")
@pytest.mark.skipif(shutil.which("objdump") is None, reason="reads what objdump writes")
@pytest.mark.parametrize("model", ["paper", "whole"])
def test_the_loop_over_lanes_is_vector_code(model):
    """A branch, or a function too long to be inlined, would cost a factor of four in silence."""
    words = ["objdump", "-d", "--no-show-raw-insn", str(library_path(CORE, "v3", model))]
    written = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    functions = dict(re.findall(r"^\w+ <(\S+)>:\n((?:.+\n)+)", written, re.MULTILINE))
    # the loop is a function of its own, or in those that call it
    loops = ("step_lanes", "core_follow_lanes", "core_measure_returns")
    assembly = "".join(functions.get(each, "") for each in loops)
    packed = re.findall(r"\bv(?:fn?madd|mul|sqrt|add)\w*pd\b", assembly)
    scalar = re.findall(r"\bv(?:fn?madd|mul|sqrt|add)\w*sd\b", assembly)
    assert len(packed) > 4 * len(scalar)
