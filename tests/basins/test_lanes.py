"""The lanes' arithmetic: the model's own force and rate, and a method of order 8."""

import platform
import re
import shutil
import subprocess
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest
from scipy.integrate import DOP853, solve_ivp

import rotor_ida
from rotor_ida import Rotor, simulate
from rotor_ida.basins import kernel, known
from rotor_ida.basins.kernel import LANES, NOT_COMPUTED, SECTION, UNDECIDED
from rotor_ida.cycles.limit_cycle import follow
from rotor_ida.model.equations import rotating_field
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

CORE = Path(rotor_ida.__file__).parent / "core"
SOURCE = (CORE / "lanes.c").read_text()
ROTOR = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
GO_ON = np.zeros(1, dtype=np.uint8)
FIRST_STEP = 0.02


def table(name):
    """Return a table of the source."""
    numbers = re.search(rf"double {name}\[\] = \{{([^}}]*)\}}", SOURCE)[1]
    return np.array([float(number) for number in numbers.split(",")])


def constant(name):
    """Return a constant of the source."""
    return float(re.search(rf"\b{name} = ([-+.\de]+)", SOURCE)[1])


def followed(rotor, states, duration, tolerance):
    """Return ends, labels and times of starts that nothing holds."""
    ends = states.copy()
    labels = np.full(states.shape[1], NOT_COMPUTED, dtype=np.int16)
    times = np.zeros(states.shape[1], dtype=np.float32)
    nothing = np.empty(0, kernel.REGION), kernel.NO_CONTACT_FREE, np.empty(0, SECTION)
    kernel.follow(ends, labels, times, rotor, *nothing, duration, tolerance, GO_ON)
    assert (labels == UNDECIDED).all()
    return ends, times


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


@pytest.mark.parametrize("delta0", [0.0, 0.5, 3.0])
def test_one_step_is_that_of_the_models_own_field(delta0):
    """A first step is exact to rounding: its end is that of the field of `equations.model`.

    Those over the ring are left out: there it is not. Any error is allowed, so that no step is
    taken again.
    """
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=delta0)
    states = np.random.default_rng(0).normal(0.0, 3.0, (4, LANES))
    states[:2] *= np.geomspace(0.3, 30.0, LANES)
    ends, times = followed(rotor, states, FIRST_STEP, 1e3)
    compared = 0
    assert (times == np.float32(FIRST_STEP)).all()
    for number in range(LANES):
        start = states[:, number]
        expected = solve_ivp(
            lambda _, state: rotating_field(state, rotor), (0.0, FIRST_STEP), start,
            method="DOP853", rtol=1e-13, atol=1e-13,
        ).y[:, -1]  # fmt: skip
        if (np.hypot(*start[:2]) > delta0) != (np.hypot(*expected[:2]) > delta0):
            continue
        size = 1.0 + np.abs(start).max()
        np.testing.assert_allclose(ends[:, number], expected, rtol=0.0, atol=1e-12 * size)
        compared += 1
    assert compared > LANES // 2


@pytest.mark.parametrize("delta0", [0.0, 0.5])
def test_there_is_no_force_at_the_centre(delta0):
    """Without unbalance a rotor at rest at the centre stays there."""
    ends, times = followed(Rotor(omega=0.0, zeta=0.1, delta0=delta0), np.zeros((4, 1)), 9.0, 1e-6)
    assert times[0] >= 9.0
    assert (ends == 0.0).all()


def test_error_falls_with_the_tolerance():
    """The error against CVODE falls by more than twenty for each hundred of the tolerance."""
    states = np.random.default_rng(1).uniform(-5.0, 5.0, (4, 4))
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8):
        ends, times = followed(ROTOR, states, 20.0, tolerance)
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
        ends, times = followed(rotor, states, 4.0, tolerance)
        for found, start, time in zip(ends.T, states.T, times.tolist(), strict=True):
            exact = follow(rotor, start, time / 8, 9, GO_ON)[-1]
            assert error_of(found, exact, time, rotor) < 100.0 * tolerance


def test_a_step_that_is_too_long_is_taken_back():
    """Far out the force is so stiff that the first step is far too long."""
    states = np.array([[1e9], [0.0], [0.0], [0.0]])
    ends, times = followed(ROTOR, states, FIRST_STEP, 1e-9)
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
    ends, times = followed(rotor, states, 1.0, 1e-6)
    alone, time = followed(rotor, states[:, 1:].copy(), 1.0, 1e-6)
    assert times[0] == 0.0
    np.testing.assert_array_equal(ends[:, 0], states[:, 0])
    np.testing.assert_array_equal(ends[:, 1], alone[:, 0])
    assert times[1] == time[0]


@pytest.mark.skipif(platform.machine() not in {"x86_64", "AMD64"}, reason="reads x86 assembly")
@pytest.mark.skipif(shutil.which("gcc") is None, reason="reads what gcc writes")
@pytest.mark.parametrize("model", ["-UWHOLE_MODEL", "-DWHOLE_MODEL"])
def test_the_loop_over_lanes_is_vector_code(model):
    """A branch, or a function too long to be inlined, would cost a factor of four in silence."""
    build = Path(rotor_ida.__file__).parents[1] / "hatch_build.py"
    if not build.is_file():
        pytest.skip("an installed package has no build")
    flags = [*run_path(str(build))["FLAGS"], "-march=x86-64-v3", model]
    words = ["gcc", *flags, "-S", "-o", "-", "lanes.c"]
    assembly = subprocess.run(words, cwd=CORE, capture_output=True, text=True, check=True).stdout
    packed = re.findall(r"\bv(?:fn?madd|mul|sqrt|add)\w*pd\b", assembly)
    scalar = re.findall(r"\bv(?:fn?madd|mul|sqrt|add)\w*sd\b", assembly)
    assert len(packed) > 4 * len(scalar)


def test_every_orbit_is_left_at_the_same_moment():
    """At the end of the time that was asked for: two of them can be held against each other."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    states = np.random.default_rng(1).uniform(-4.0, 4.0, (4, LANES))
    ends, times = followed(rotor, states, 7.25, 1e-10)
    assert (times == np.float32(7.25)).all()
    for number in range(0, LANES, 8):
        run = simulate(
            rotor, start=states[:, number], duration=7.25, samples=2, method="taylor", rtol=1e-13
        )
        turn = np.exp(-1j * 2.0 * 7.25)
        z = complex(run.x[-1], run.y[-1]) * turn
        assert complex(*ends[:2, number]) == pytest.approx(z, abs=1e-6)
