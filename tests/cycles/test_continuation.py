"""The continuation core on other flows, whose folds and doublings are published.

Here a cycle is followed by SciPy's DOP853 with its variational equations: nothing of the rotor
takes part.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from rotor_ida.cycles.continuation import Curve, Problem, shooting_equations
from rotor_ida.cycles.special_points import Way, _zero
from rotor_ida.errors import SimulationError

TOLERANCE = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}


@dataclass(frozen=True)
class Flown:
    """A stretch of a flow, with the derivative of its end by the parameter."""

    start: np.ndarray
    end: np.ndarray
    monodromy: np.ndarray
    column: np.ndarray
    start_rate: np.ndarray
    end_rate: np.ndarray


def lorenz(state, rho):
    x, y, z = state
    rate = np.array([10.0 * (y - x), x * (rho - z) - y, x * y - 8.0 / 3.0 * z])
    jacobian = np.array([[-10.0, 10.0, 0.0], [rho - z, -1.0, -x], [y, x, -8.0 / 3.0]])
    return rate, jacobian, np.array([0.0, x, 0.0])


def tor_bpc(state, nu):
    """MatCont's example: an electronic circuit."""
    beta, gamma, r, a3, b3, epsilon = 0.5, -0.6, 0.6, 0.32858, 0.93358, 0.001
    x, y, z = state
    rate = np.array([
        (-(beta + nu) * x + beta * y - a3 * x**3 + b3 * (y - x) ** 3) / r,
        beta * x - (beta + gamma) * y - z - b3 * (y - x) ** 3,
        y + epsilon,
    ])  # fmt: skip
    bend = 3.0 * b3 * (y - x) ** 2
    jacobian = np.array([
        [(-(beta + nu) - 3.0 * a3 * x**2 - bend) / r, (beta + bend) / r, 0.0],
        [beta + bend, -(beta + gamma) - bend, -1.0],
        [0.0, 1.0, 0.0],
    ])  # fmt: skip
    return rate, jacobian, np.array([-x / r, 0.0, 0.0])


def flown(model, unknowns):
    """Follow a state for a period, with its derivatives by state and parameter."""
    start, period, parameter = unknowns[:3], float(unknowns[3]), float(unknowns[4])

    def rates(_, whole):
        rate, jacobian, by_parameter = model(whole[:3], parameter)
        columns = jacobian @ whole[3:].reshape(3, 4)
        columns[:, 3] += by_parameter
        return np.concatenate([rate, columns.ravel()])

    first = np.concatenate([start, np.eye(3, 4).ravel()])
    solved = solve_ivp(rates, (0.0, period), first, **TOLERANCE)
    if not solved.success:
        raise SimulationError(solved.message)
    end, columns = solved.y[:3, -1], solved.y[3:, -1].reshape(3, 4)
    rate, end_rate = model(start, parameter)[0], model(end, parameter)[0]
    return Flown(start, end, columns[:, :3], columns[:, 3], rate, end_rate)


def cycles_of(model):
    return Problem(
        partial(flown, model),
        lambda _, stretch, direction: shooting_equations(stretch, direction, stretch.column),
        lambda stretch: None,
        {
            "fold": lambda point, _: point.tangent[-1],
            "doubling": lambda point, _: np.linalg.det(point.orbit.monodromy + np.eye(3)),
        },
    )


def followed(line, point, steps, wanted):
    """The special points on the way, until one of a kind is met."""
    met, length = [], 1e-2
    for _ in range(steps):
        step = line.step(point, length)
        met, point, length = met + step.specials, step.point, step.length
        if any(each.name == wanted for each in met):
            break
    return {each.name: each.point for each in met}


def test_a_special_point_that_cannot_be_located_is_an_error_of_ours():
    """Rounding may take back a change of sign: the step is cut then, and no user meets SciPy's."""
    way = Way({0.0: 0.0, 1.0: 1.0}, 1.0, lambda part, near: part, lambda part: None)
    with pytest.raises(SimulationError, match="a fold could not be located"):
        _zero(way, (0.0, 1.0), "fold", lambda point: 1.0)


def test_lorenz_doubles_where_it_is_published():
    """Sigma 10, b 8/3: downwards a cycle of period 0.480867 doubles at rho 229.4067 (DESIGN 9)."""
    state = np.array([38.1192, 96.3381, 232.4727])  # settled at rho 235
    line = Curve(cycles_of(lorenz), np.array([100.0, 100.0, 100.0, 0.5, 235.0]))
    first = line.first(np.append(state, (0.4749189, 235.0)))
    found = followed(line, first.reversed(), 20, "doubling")["doubling"]
    assert found.unknowns[4] == pytest.approx(229.4067, abs=5e-5)
    assert found.unknowns[3] == pytest.approx(0.480867, abs=5e-7)


def test_tor_bpc_folds_and_doubles_where_matcont_says():
    """From the Hopf bifurcation at nu -0.589286 the branch folds, then doubles (DESIGN 9)."""
    nu = -0.589286
    rest = fsolve(lambda state: tor_bpc(state, nu)[0], np.array([0.0, -0.001, 0.0]))
    values, vectors = np.linalg.eig(tor_bpc(rest, nu)[1])
    turning = np.argmax(values.imag)
    aside = vectors[:, turning].real / np.linalg.norm(vectors[:, turning].real)
    line = Curve(cycles_of(tor_bpc), np.array([1.0, 1.0, 1.0, 10.0, 1.0]))
    guess = np.append(rest + 0.02 * aside, (2.0 * np.pi / values[turning].imag, nu))
    first = line.near(guess, np.append(aside, (0.0, 0.0)))
    found = followed(line, first, 200, "doubling")
    fold, doubling = found["fold"].unknowns, found["doubling"].unknowns
    assert fold[4] == pytest.approx(-0.5844928, abs=1e-7)
    assert fold[3] == pytest.approx(8.411855, abs=1e-6)
    assert doubling[4] == pytest.approx(-0.6146817, abs=1e-7)
    assert doubling[3] == pytest.approx(9.256846, abs=1e-6)
