import numpy as np
import pytest

from rotor_ida import synchronous_response
from rotor_ida.plot.branches import trace_branches
from rotor_ida.schema import STABILITY

NO_FOLDS = (np.empty(0), np.empty(0))


def traced(*, zeta, delta0, omega, fold=NO_FOLDS):
    whirls = synchronous_response(omega=omega, zeta=zeta, delta0=delta0).squeeze(["zeta", "delta0"])
    amplitude = whirls["amplitude"].values
    return trace_branches(
        whirls["omega"].values,
        amplitude,
        amplitude,
        whirls["stability"].values,
        unstable=STABILITY["unstable"],
        fold_omega=fold[0],
        fold_value=fold[1],
    )


@pytest.mark.parametrize("delta0", [0.0, 0.5, 1.0, 2.0])
def test_every_whirl_is_on_exactly_one_branch(delta0):
    omega = np.linspace(0.3, 3.0, 271)
    whirls = synchronous_response(omega=omega, zeta=0.07, delta0=delta0)
    branches = traced(zeta=0.07, delta0=delta0, omega=omega)
    shown = {point for b in branches for point in zip(b.omega, b.value, strict=True)}
    for i, speed in enumerate(omega):
        for amplitude in whirls["amplitude"].values[i, 0, 0]:
            assert np.isnan(amplitude) or (speed, amplitude) in shown


def test_without_clearance_there_are_two_stable_branches_and_an_unstable_one_between():
    branches = traced(zeta=0.07, delta0=0.0, omega=np.linspace(0.3, 3.0, 271))
    flags = sorted(branch.stability for branch in branches)
    assert flags == [STABILITY["stable"], STABILITY["stable"], STABILITY["unstable"]]
    (unstable,) = (b for b in branches if b.stability == STABILITY["unstable"])
    large, small = (b for b in branches if b.stability == STABILITY["stable"])
    # both ends of the unstable branch are ends of a stable one
    assert (unstable.omega[0], unstable.value[0]) == (small.omega[0], small.value[0])
    assert (unstable.omega[-1], unstable.value[-1]) == (large.omega[-1], large.value[-1])


def test_branches_run_into_the_fold_between_two_speeds():
    fold = (np.array([1.59782129, 1.93275359]), np.array([3.03880188, 13.65315777]))
    branches = traced(zeta=0.07, delta0=0.0, omega=np.linspace(0.3, 3.0, 271), fold=fold)
    (unstable,) = (b for b in branches if b.stability == STABILITY["unstable"])
    assert (unstable.omega[0], unstable.value[0]) == (fold[0][0], fold[1][0])
    assert (unstable.omega[-1], unstable.value[-1]) == (fold[0][1], fold[1][1])


def test_a_steep_branch_is_not_joined_to_its_neighbour():
    """On no branch does the amplitude jump: folds turn round, they do not leap."""
    for branch in traced(zeta=0.07, delta0=0.5, omega=np.linspace(0.3, 3.0, 2701)):
        assert np.abs(np.diff(branch.value)).max() < 0.3


def test_the_isola_is_apart_from_the_contact_free_whirl():
    branches = traced(zeta=0.07, delta0=2.0, omega=np.linspace(0.05, 3.0, 296))
    free = [b for b in branches if b.stability == STABILITY["neutral"]]
    assert len(free) == 1
    assert max(free[0].value) < 1.0
    assert len(branches) == 3
