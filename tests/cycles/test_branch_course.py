"""Branches between their special points, and computed again from what they say of themselves."""

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, bifurcation_curve, continue_cycle, limit_cycle
from rotor_ida.cycles.branch_course import course_of, runs_of, stable_ranges
from rotor_ida.verification.verify import differences, rerun

BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


@pytest.fixture(scope="module")
def cycle():
    return limit_cycle(BOUNCING, start=(2.6, 0.75, 0.66, -1.65), period=4.5)


@pytest.fixture(scope="module")
def branch(cycle):
    """It comes from omega 3 down to a fold near 0.4, and goes back up."""
    return continue_cycle(BOUNCING, start=cycle, limits=(0.3, 3.0))


def specials(branch, kind):
    return np.flatnonzero(branch.special_kind.values == kind)


def test_a_branch_is_stable_between_its_folds_and_doublings(branch):
    fold, (one, other) = specials(branch, 1).item(), specials(branch, 2)
    values = branch.special_value.values
    sliver, rest = stable_ranges(branch)
    assert sliver == (values[fold], values[one])
    assert rest == (values[other], 3.0)
    assert 0.0 < sliver[1] - sliver[0] < 0.003


def test_special_points_stand_behind_the_points_before_them(branch):
    course = course_of(branch)
    assert course.value.size == branch.sizes["point"] + branch.sizes["special"]
    assert len(course.stability) == len(course.response) == course.value.size - 1
    steps = np.hypot(np.diff(course.value), np.diff(course.high))
    points = np.hypot(np.diff(branch.omega.values), np.diff(branch.radius_max.values))
    assert steps.max() <= points.max()


def test_a_doubled_branch_is_stable_up_to_where_it_halves(branch):
    one, other = specials(branch, 2)
    doubled = continue_cycle(BOUNCING, start=branch.isel(special=one), limits=(0.3, 3.0))
    assert doubled.attrs["last_end"] == "halved"
    ends = {round(end, 9) for each in stable_ranges(doubled) for end in each}
    assert round(branch.special_value.values[other], 9) in ends
    assert all(low < high for low, high in stable_ranges(doubled))
    assert differences(rerun(doubled), doubled)["agrees"]


def test_what_does_not_say_what_was_varied_is_refused(branch):
    with pytest.raises(InputError, match="branch must name what was varied in its attribute 'para"):
        stable_ranges(branch.assign_attrs(parameter="mass"))


def test_runs_of_nothing_are_none():
    assert runs_of([]) == []


@pytest.mark.parametrize("direction", ["both", "forward", "backward"])
@pytest.mark.parametrize("point", [20, -20])
def test_a_branch_from_either_side_of_a_fold_is_made_again(branch, direction, point):
    """Forward is on along the branch, where the parameter may fall: the branch itself tells."""
    start = branch.isel(point=point)
    found = continue_cycle(BOUNCING, start=start, limits=(0.3, 3.0), direction=direction)
    told = differences(rerun(found), found)
    assert told["agrees"], told
    assert told["compared"] > 10


def test_a_curve_and_a_branch_over_the_clearance_are_made_again(cycle, branch):
    over = continue_cycle(BOUNCING, start=cycle, parameter="delta0", limits=(1.8, 2.2))
    assert differences(rerun(over), over)["agrees"]
    curve = bifurcation_curve(
        BOUNCING,
        start=branch.isel(special=specials(branch, 2)[1]),
        kind="period_doubling",
        parameters=("delta0", "omega"),
        limits={"omega": (1.7, 1.9), "delta0": (1.9, 2.1)},
    )
    assert differences(rerun(curve), curve)["agrees"]
    # where a multiplier is -1, another processor finds it within or outside the unit circle
    other = curve.assign(stability=1 - curve.stability, trace=-curve.trace)
    assert differences(other, curve)["agrees"]


def test_one_special_point_more_or_less_is_a_difference(branch):
    fewer = branch.isel(special=slice(0, -1))
    trouble = differences(branch, fewer)["trouble"]
    count = branch.sizes["special"]
    assert f"has {{'special': {count}}} computed again, {{'special': {count - 1}}}" in trouble


def test_other_steps_are_no_difference_but_another_end_is(branch):
    """Another processor may take other steps: then ends and stable ranges are compared."""
    fewer = branch.isel(point=np.delete(np.arange(branch.sizes["point"]), 5))
    behind = branch.special_point > 5
    fewer = fewer.assign(special_point=branch.special_point - behind)
    told = differences(fewer, branch)
    assert told["agrees"], told
    assert "point" in str(told["not_compared"])
    forged = branch.assign(radius_max=branch.radius_max * 1.000001)
    assert differences(fewer, forged)["trouble"].startswith("radius_max at the first_end differs")
    ends = branch.assign_attrs(last_end="hopf")
    assert "last_end differs" in differences(fewer, ends)["trouble"]
