"""The lanes' arithmetic: the model's own force and rate, and a method of order 8."""

import platform
import re

import numba
import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.basins.lanes import (
    ADVANCE,
    BUFFER,
    LANES,
    STAGE_5,
    STAGE_12,
    STEP,
    TIME,
    U,
    V,
    X,
    Y,
    rate,
    secant,
    step_lanes,
)
from rotor_ida.cycles.limit_cycle import follow
from rotor_ida.equations.contact import force_over_radius
from rotor_ida.equations.model import rotating_field
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

RADII = [0.5, *np.geomspace(1e-6, 1e6, 200)]


@pytest.mark.parametrize("delta0", [None, 0.5, 3.0])
def test_stiffness_is_that_of_the_contact_law(delta0):
    """To 1e-12 of itself, but next to the ring, where r - delta0 is a difference of roundings."""
    for radius in RADII:
        expected = force_over_radius(float(radius), delta0 or 0.0)
        found = secant(float(radius**2), delta0)
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("delta0", [None, 0.5])
def test_there_is_no_force_at_the_centre(delta0):
    """Where the stiffness is not told from 0 the displacement is none either."""
    assert 0.0 <= secant(0.0, delta0) * 1e-15 < 1e-20


@pytest.mark.parametrize("delta0", [0.0, 0.7])
def test_rate_is_that_of_the_model(delta0):
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=delta0)
    for state in np.random.default_rng(0).normal(0.0, 3.0, (20, 4)):
        found = rate(tuple(state), rotor.omega, rotor.zeta, delta0 or None)
        np.testing.assert_allclose(found, rotating_field(state, rotor), rtol=1e-12, atol=1e-12)


def test_coefficients_are_those_of_dop853():
    """Consistency: the weights of a stage sum to its node, those of the step to 1."""
    assert sum(ADVANCE) == pytest.approx(1.0, abs=1e-14)
    assert sum(STAGE_12) == pytest.approx(1.0, abs=1e-12)
    assert sum(STAGE_5) == pytest.approx(0.2816496580927726, abs=1e-14)


def final_states(tolerance, duration, states, delta0=None):
    """Return the states at `duration`, by steps that end there."""
    lanes = np.zeros(BUFFER)
    lanes[X : X + LANES], lanes[Y : Y + LANES], lanes[U : U + LANES], lanes[V : V + LANES] = states
    lanes[STEP : STEP + LANES] = 0.01
    while (lanes[TIME : TIME + LANES] < duration).any():
        left = duration - lanes[TIME : TIME + LANES]
        lanes[STEP : STEP + LANES] = np.minimum(lanes[STEP : STEP + LANES], left)
        step_lanes(lanes, 1.7, 0.07, delta0, tolerance)
    return lanes[: 4 * LANES].reshape(4, LANES)


def test_error_falls_with_the_tolerance():
    """The error against CVODE falls by more than fifty for each hundred of the tolerance."""
    states = np.random.default_rng(1).uniform(-5.0, 5.0, (4, LANES))
    rotor, duration = Rotor(omega=1.7, zeta=0.07, delta0=0.0), 20.0
    turn = np.exp(-1j * rotor.omega * duration)
    errors = []
    ends = [
        run(rotor, tuple(state), duration, np.empty(0), Options(rtol=1e-13, atol=1e-14)).end
        for state in states.T.tolist()[:4]
    ]
    exact = np.array([(complex(end[0], end[1]) * turn) for end in ends])
    for tolerance in (1e-4, 1e-6, 1e-8):
        found = final_states(tolerance, duration, states)
        errors.append(np.abs(found[0, :4] + 1j * found[1, :4] - exact).max())
    assert errors[0] < 1e-2
    assert errors[1] < errors[0] / 20.0
    assert errors[2] < errors[1] / 20.0


def test_steps_over_the_ring_are_as_exact_as_others():
    """From far out they leave the ring within the time: the error is that of the tolerance."""
    states = np.zeros((4, LANES))
    states[:2] = np.random.default_rng(2).uniform(8.0, 14.0, (2, LANES))
    rotor, duration = Rotor(omega=1.7, zeta=0.07, delta0=2.0), 4.0
    exact = np.array([
        follow(rotor, state, duration / 8, 9, np.zeros(1, np.uint8))[-1] for state in states.T
    ])  # fmt: skip
    assert (np.hypot(*states[:2]) > 2.0).all()
    for tolerance in (1e-10, 1e-12):
        found = final_states(tolerance, duration, states, 2.0)
        assert np.abs(found.T - exact).max() < 100.0 * tolerance


def test_a_step_that_is_too_long_is_taken_back():
    lanes = np.zeros(BUFFER)
    lanes[X : X + LANES], lanes[STEP : STEP + LANES] = 10.0, 50.0
    before = lanes.copy()
    step_lanes(lanes, 1.7, 0.07, None, 1e-6)
    assert (lanes[TIME : TIME + LANES] == 0.0).all()
    assert (lanes[X : X + LANES] == before[X : X + LANES]).all()
    assert (lanes[STEP : STEP + LANES] < 50.0).all()


@pytest.mark.skipif(platform.machine() not in {"x86_64", "AMD64"}, reason="reads x86 assembly")
def test_the_loop_over_lanes_is_vector_code():
    """A branch, or a function too long to be inlined, would cost a factor of four in silence."""
    settings = {"fastmath": {"contract", "nsz", "arcp", "reassoc"}, "error_model": "numpy"}
    fresh = numba.njit(**settings)(step_lanes.py_func)  # nothing is told of code from the cache
    fresh(np.zeros(BUFFER), 1.7, 0.07, 0.5, 1e-6)
    (assembly,) = fresh.inspect_asm().values()
    # in double precision: where a vector holds two doubles, two single-precision roots stay scalar
    packed = re.findall(r"\bv?(?:fmadd|mul|sqrt|add)\w*pd\b", assembly)
    scalar = re.findall(r"\bv?(?:fmadd|mul|sqrt|add)\w*sd\b", assembly)
    assert len(packed) > 10 * len(scalar)
