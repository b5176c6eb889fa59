"""What a cycle is sought from: states, cycles, points of branches; and what cannot be one."""

import numpy as np
import pytest

from rotor_ida import (
    InputError,
    Rotor,
    bifurcation_curve,
    continue_cycle,
    limit_cycle,
    synchronous_response,
)
from rotor_ida.cycles.guess import guess_of
from tests.cycles.known import BOUNCING

REST = (0.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def cycle():
    return limit_cycle(BOUNCING.rotor, start=REST)


@pytest.fixture(scope="module")
def branch():
    return continue_cycle(BOUNCING.rotor, start=REST, limits=(1.75, 2.1))


def test_a_point_of_a_branch_brings_its_parameter(branch):
    """The rotor may be any of the branch: the continued parameter is taken from the point."""
    point = branch.isel(point=3)
    guess = guess_of(BOUNCING.rotor, point)
    assert guess.rotor.omega == point["omega"].item() != BOUNCING.rotor.omega
    again = limit_cycle(guess.rotor, start=point)
    assert again["period"].item() == pytest.approx(point["period"].item(), rel=1e-12)
    assert np.sign(guess.slope) == np.sign(branch["omega"][4] - branch["omega"][3])


def test_a_special_point_says_what_it_is(branch):
    place = int(np.flatnonzero(branch["special_kind"] == 2)[0])
    guess = guess_of(BOUNCING.rotor, branch.isel(special=place))
    assert guess.special == "period_doubling"
    assert guess.rotor.omega == pytest.approx(1.803392470017, abs=1e-9)
    assert guess.period == pytest.approx(5.054250530560, abs=1e-8)


def refused(start, says, rotor=BOUNCING.rotor, period=None):
    with pytest.raises(InputError, match=says):
        limit_cycle(rotor, start=start, period=period)
    if period is None:
        with pytest.raises(InputError, match=says):
            continue_cycle(rotor, start=start, limits=(0.5, 3.0))


@pytest.mark.parametrize("start", [(0, 0, 0), (0, 0, 0, np.nan), "resting", [[0, 0, 0, 0]]])
def test_what_is_no_state_is_refused(start):
    refused(start, "start")


def test_whole_branches_are_refused(branch):
    refused(branch, r"choose it with isel\(point=\.\.\.\)")


def test_a_dataset_of_something_else_is_refused():
    whirls = synchronous_response(omega=2.0, zeta=0.07, delta0=2.0)
    refused(whirls, "as a dataset it lacks period")


def test_another_rotor_is_refused(cycle, branch):
    other = Rotor(omega=2.0, zeta=0.08, delta0=2.0)
    says = "start must be of the same rotor: its zeta is 0.07, that of the rotor 0.08"
    refused(cycle, says, other)
    refused(branch.isel(point=0), says, other)


def test_a_result_without_a_cycle_is_refused():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=9.0)
    nothing = limit_cycle(rotor, start=REST)
    refused(nothing, "start must be a limit cycle, got a result without one", rotor)


def test_a_cycle_has_its_period_already(cycle):
    refused(cycle, "period must be left out with a start that has one", period=4.5)


@pytest.fixture(scope="module")
def curve():
    branch = continue_cycle(BOUNCING.rotor, start=REST, limits=(1.9, 4.2))
    fold = int(np.flatnonzero(branch["special_kind"] == 1)[0])
    return bifurcation_curve(
        BOUNCING.rotor, start=branch.isel(special=fold), kind="fold",
        limits={"omega": (3.8, 4.1), "delta0": (1.7, 2.1)},
    )  # fmt: skip


def test_a_point_of_a_bifurcation_curve_brings_both_parameters(curve):
    point = curve.isel(point=2)
    guess = guess_of(BOUNCING.rotor, point)
    assert (guess.rotor.omega, guess.rotor.delta0) == (
        point["omega"].item(),
        point["delta0"].item(),
    )
    limits = (guess.rotor.omega - 0.02, guess.rotor.omega + 0.02)
    branch = continue_cycle(BOUNCING.rotor, start=point, limits=limits)
    folds = branch["special_value"].values[branch["special_kind"].values == 1]
    assert folds == pytest.approx([guess.rotor.omega], abs=1e-9)


def test_a_special_point_of_a_bifurcation_curve_brings_both_parameters(curve):
    """Where the fold's cycle grazes: there the number of its contacts changes on the branch too."""
    assert curve["special_kind"].values.tolist() == [3]
    graze = curve.isel(special=0)
    guess = guess_of(BOUNCING.rotor, graze)
    assert guess.rotor.omega == graze["special_value"].item()
    assert guess.rotor.delta0 == graze["special_second_value"].item()
    assert guess.special == "graze"
