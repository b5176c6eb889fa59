"""Multipliers from the trace, and the structure that this rests on, measured on M."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, limit_cycle
from rotor_ida.cycles.multipliers import (
    FORM,
    doubling_test,
    fold_test,
    is_stable,
    multipliers_of,
    symplectic_defect,
    trivial_defect,
)
from rotor_ida.cycles.orbit import followed
from rotor_ida.cycles.shooting import close_orbit
from rotor_ida.simulation.flow import DiscFlow
from tests.cycles.known import BOUNCING, FULL, SLIVER, SPECIAL_POINTS, once_round

KNOWN = [BOUNCING, FULL]


def closed(known):
    return close_orbit(DiscFlow(known.rotor), np.array(known.state), known.period)


@pytest.mark.parametrize(("known", "pair"), SLIVER.items())
def test_multipliers_of_the_sliver_are_real_and_negative(known, pair):
    shot = closed(known)
    found = multipliers_of(shot)
    for expected in (1.0, *pair):
        assert np.abs(found - expected).min() < 1e-7
    assert is_stable(shot)


@pytest.mark.parametrize("known", [*KNOWN, *SLIVER])
def test_structure_measured_on_the_matrix_before_it_is_used(known):
    """The trivial multiplier to 1e-10; det M / q^2 and the partner / q to 1e-8, by eigenvalues."""
    cycle = closed(known)
    matrix, q = cycle.monodromy, cycle.pair_product
    values, size = np.linalg.eigvals(matrix), np.linalg.norm(matrix)
    # where M is large, det M and q are small differences of its elements
    condition = max(size / q, 1.0)
    assert np.abs(values - 1.0).min() < 1e-10
    assert np.abs(values / q - 1.0).min() < max(1e-8, 1e-15 * condition)
    assert np.linalg.det(matrix) / q**2 == pytest.approx(1.0, abs=max(1e-8, 1e-15 * condition**2))
    assert trivial_defect(cycle) < 1e-10
    assert symplectic_defect(cycle) < 1e-13


def test_a_period_that_damps_all_velocities_to_nothing_leaves_no_defect():
    """exp(-2 zeta T) is 0 in doubles: 0 = 0, no quotient of them."""
    rotor = Rotor(omega=1e-3, zeta=5.0, delta0=1.0)
    cycle = limit_cycle(rotor, start=(1.0 + 1e-13, 0.0, 0.0, 0.0), period=2.0 * np.pi / rotor.omega)
    assert cycle.symplectic_defect.item() == 0.0
    assert cycle.trivial_defect.item() < 1e-10


@pytest.mark.parametrize("rotor", [
    Rotor(omega=2.0, zeta=0.07, delta0=2.0), Rotor(omega=3.0, zeta=0.01, delta0=0.5),
    Rotor(omega=1.1, zeta=0.3, delta0=1.0), Rotor(omega=1.7, zeta=0.1, delta0=0.0),
])  # fmt: skip
def test_every_stretch_of_every_orbit_is_conformally_symplectic(rotor):
    """M^T S M = q S holds for any start and time, through entries and exits; not for cycles alone.

    Measured on both integrators.
    """
    generator = np.random.default_rng(5)
    for _ in range(4):
        start, duration = generator.uniform(-3.0, 3.0, 4), float(generator.uniform(2.0, 15.0))
        q = math.exp(-2.0 * rotor.zeta * duration)
        for matrix, allowed in (
            (followed(DiscFlow(rotor), start, duration).monodromy, 1e-13),
            (once_round(rotor, start, duration).monodromy, 1e-9),
        ):
            size = (np.abs(matrix).T @ np.abs(FORM) @ np.abs(matrix)).max()
            assert np.abs(matrix.T @ FORM @ matrix - q * FORM).max() < allowed * size


def test_the_form_is_that_of_fixed_axes_velocity():
    """With the velocity seen on the turning axes as momentum the flow would not have it."""
    matrix = closed(BOUNCING).monodromy
    q = math.exp(-2.0 * 0.07 * BOUNCING.period)
    seen = np.eye(4)  # from (Z, W) to (Z, Z') = (Z, W - i omega Z)
    seen[2:, :2] = 2.0 * np.array([[0.0, 1.0], [-1.0, 0.0]])
    other = np.linalg.inv(seen).T @ FORM @ np.linalg.inv(seen)
    assert np.abs(matrix.T @ FORM @ matrix - q * FORM).max() < 1e-13
    assert np.abs(matrix.T @ other @ matrix - q * other).max() > 1e-2


@pytest.mark.parametrize("known", SPECIAL_POINTS)
def test_a_test_function_vanishes_where_auto_and_dop853_find_the_bifurcation(known):
    """Once round from the state found there; to close it again fails where it is beyond a fold.

    The witness is good to about 2e-10, and the elements of M change by some 100 in a unit.
    """
    shot = followed(DiscFlow(known.rotor), np.array(known.state), known.period)
    test, place = {"fold": (fold_test, 1.0), "period_doubling": (doubling_test, -1.0)}[known.kind]
    assert abs(test(shot)) < 1e-6
    values = np.linalg.eigvals(shot.monodromy)
    others = np.delete(values, np.argmin(np.abs(values - 1.0)))
    # at a fold 1 is a double root, of which rounding makes a pair 1e-4 off
    assert np.abs(others - place).min() < (1e-3 if known.kind == "fold" else 1e-6)


@pytest.mark.parametrize(("omega", "stable"), [(0.3995, True), (0.401, False), (1.79, False),
                                               (1.82, True)])  # fmt: skip
def test_stability_is_what_eigenvalues_say_on_both_sides_of_a_doubling(omega, stable):
    known = SPECIAL_POINTS[3 if omega < 1.0 else 4]
    rotor = Rotor(omega=omega, zeta=0.07, delta0=2.0)
    shot = close_orbit(DiscFlow(rotor), np.array(known.state), known.period)
    values = np.linalg.eigvals(shot.monodromy)
    others = np.delete(values, np.argmin(np.abs(values - 1.0)))
    assert is_stable(shot) == bool((np.abs(others) < 1.0).all()) == stable
