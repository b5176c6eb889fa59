"""All branches of limit cycles that a sweep has met: each once, each met response on one."""

import numpy as np
import pytest

from rotor_ida import InputError, branches_through, compare, sweep
from rotor_ida.schema import EXACT

LIMITS = (0.3, 5.0)


@pytest.fixture(scope="module")
def compared():
    """At omega 1.6 and 2 the rotor bounces at both clearances; at delta0 1 on two branches."""
    starts = [(0.0, 0.0, 0.0, 0.0), (3.0, 1.0, 0.0, 0.0), (-2.0, 1.0, 1.0, -1.0)]
    return compare(sweep(omega=[1.6, 1.9, 2.0], zeta=0.07, delta0=[1.0, 2.0], starts=starts))


def test_every_cycle_lies_on_one_of_the_branches_and_no_branch_comes_twice(compared):
    branches = branches_through(compared, limits=LIMITS)
    cycles = compared.where(compared.lies_on == EXACT["cycle"])
    wanted = np.unique(cycles.exact_period.values[np.isfinite(cycles.exact_period.values)].round(6))
    assert wanted.size > len(branches) >= 2
    ends = {(float(each.delta0), round(float(each.omega.min()), 4)) for each in branches}
    assert len(ends) == len(branches)
    assert {clearance for clearance, _ in ends} == {1.0, 2.0}
    for period in wanted.tolist():
        assert any(
            float(each.period.min()) - 1e-6 <= period <= float(each.period.max()) + 1e-6
            for each in branches
        )


def test_those_of_a_grid_of_rotors_differ_in_all_parameters():
    swept = sweep(
        omega=[2.0], zeta=0.07, delta0=2.0, shaft_stiffness=[0.0, 0.05],
        contact_damping=[0.0, 0.02],
    )  # fmt: skip
    others = compare(swept)
    assert (others.lies_on == EXACT["cycle"]).all()
    branches = branches_through(others, limits=(1.95, 2.05))
    told = [(float(each.get("shaft_stiffness", 0.0)), float(each.get("contact_damping", 0.0)))
            for each in branches]  # fmt: skip
    assert told == [(0.0, 0.0), (0.0, 0.02), (0.05, 0.0), (0.05, 0.02)]
    periods = [np.interp(2.0, each.omega, each.period) for each in branches]
    np.testing.assert_allclose(periods, others.exact_period.values.ravel(), rtol=1e-4)


def test_progress_comes_to_all_that_lie_on_cycles(compared):
    told = []
    branches_through(
        compared.sel(delta0=[2.0]), limits=LIMITS, progress=lambda *each: told.append(each)
    )
    count = int((compared.sel(delta0=[2.0]).lies_on == EXACT["cycle"]).sum())
    assert told == [(number, count) for number in range(1, count + 1)]


def test_what_is_no_comparison_is_refused(compared):
    with pytest.raises(InputError, match="must be a comparison of a sweep; it lacks end_x"):
        branches_through(compared.drop_vars("end_x"), limits=LIMITS)
    with pytest.raises(InputError, match="compared must be a Dataset"):
        branches_through("fig11.nc", limits=LIMITS)
    with pytest.raises(InputError, match="limits of omega must contain"):
        branches_through(compared, limits=(0.3, 1.0))
