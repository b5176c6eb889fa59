"""Branches and bifurcations of machines, over all parameters that have a derivative."""

import numpy as np
import pytest

from rotor_ida import Rotor, bifurcation_curve, continue_cycle, limit_cycle
from rotor_ida.schema import SPECIAL

BOUNCER = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
# Of the paper's rotor at zeta 0.07 and delta0 2, known to ten digits elsewhere.
DOUBLING = 1.8033924


@pytest.mark.parametrize(
    ("parameter", "largest"), [("shaft_stiffness", 0.5), ("contact_damping", 0.5)]
)
def test_a_branch_over_a_parameter_of_machines_begins_at_the_paper_s_rotor(parameter, largest):
    branch = continue_cycle(BOUNCER, start=(0, 0, 0, 0), parameter=parameter, limits=(0.0, largest))
    assert branch.attrs["first_end"] == branch.attrs["last_end"] == "limits"
    assert branch.residual.values.max() < 1e-12
    values = branch[parameter].values
    assert values.min() == 0.0
    at_zero = branch.isel(point=int(np.argmin(values)))
    own = limit_cycle(BOUNCER, start=(0, 0, 0, 0))
    beside = [float(at_zero.period), float(branch.isel(point=-1).period)]
    assert min(abs(period - own.period.item()) for period in beside) < 1e-11
    # a point inside it is the cycle of that machine
    point = branch.isel(point=branch.sizes["point"] // 2)
    machine = Rotor(omega=2.0, zeta=0.07, delta0=2.0, **{parameter: float(point[parameter])})
    cycle = limit_cycle(machine, start=point)
    assert cycle.period.item() == pytest.approx(float(point.period), rel=1e-12)
    assert cycle[parameter].item() == float(point[parameter])


def test_a_fold_over_the_shaft_is_where_a_multiplier_is_one():
    branch = continue_cycle(
        BOUNCER, start=(0, 0, 0, 0), parameter="shaft_stiffness", limits=(0.0, 0.5)
    )
    place = int(np.flatnonzero(branch.special_kind.values == SPECIAL["fold"])[0])
    special = branch.isel(special=place)
    machine = Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=float(special.special_value))
    state = [float(special[f"special_{name}"]) for name in ("x", "y", "vx", "vy")]
    cycle = limit_cycle(machine, start=state, period=float(special.special_period))
    multipliers = cycle.multiplier_real.values + 1j * cycle.multiplier_imag.values
    # at a fold they are two, and only the root of rounding of the parameter tells them apart
    assert np.sort(np.abs(multipliers - 1.0))[1] < 1e-5


@pytest.mark.parametrize("parameter", ["shaft_stiffness", "contact_damping"])
def test_a_curve_of_doublings_comes_to_that_of_the_paper_s_rotor(parameter):
    machine = Rotor(omega=1.85, zeta=0.07, delta0=2.0, **{parameter: 0.05})
    curve = bifurcation_curve(
        machine, start=(0, 0, 0, 0), kind="period_doubling",
        parameters=("omega", parameter), limits=((1.2, 3.0), (0.0, 0.2)),
    )  # fmt: skip
    end = int(np.argmin(curve[parameter].values))
    assert curve[parameter].values[end] == 0.0
    assert curve.omega.values[end] == pytest.approx(DOUBLING, abs=2e-7)
    # on the way one multiplier is -1
    middle = curve.isel(point=curve.sizes["point"] // 2)
    assert np.abs(middle.multiplier_real.values + 1.0).min() < 1e-9


def test_with_contact_damping_the_product_of_multipliers_is_that_of_all_damping():
    """det M = exp of the integral of the divergence: -4 zeta - c N/(1 + c d') while pressed."""
    machine = Rotor(omega=1.6, zeta=0.07, delta0=2.0, contact_damping=2.0, contact_exponent=1.0)
    cycle = limit_cycle(machine, start=(0, 0, 0, 0))
    multipliers = cycle.multiplier_real.values + 1j * cycle.multiplier_imag.values
    x, y, vx, vy = (cycle[name].values for name in ("x", "y", "vx", "vy"))
    radius = np.hypot(x, y)
    approach = (x * vx + y * vy) / radius
    spring = np.maximum(radius - 2.0, 0.0) * (1.0 + 2.0 * approach > 0.0)
    mean = np.mean(2.0 * spring[:-1])
    expected = np.exp(-(4.0 * 0.07 + mean) * cycle.period.item())
    assert np.prod(multipliers).real == pytest.approx(expected, rel=2e-3)
