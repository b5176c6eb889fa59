"""Folds, Hopf points and grazes of rotor systems over the speed."""

from itertools import pairwise

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    decode_flags,
    folds,
    hopf_points,
    special_speeds,
    synchronous_response,
)
from tests.axisymmetric_systems import beam, random_axisymmetric

DISCS = (
    {"zeta": 0.07, "delta0": 0.5, "friction": 0.1},
    {"zeta": 0.02, "delta0": 1.0, "contact_damping": 0.5, "shaft_stiffness": 0.3},
    {"zeta": 0.05, "delta0": 1.5, "shaft_stiffness": 0.25, "contact_exponent": 1.0,
     "friction": 0.2},
)  # fmt: skip


def of_kind(found, kind):
    return found.isel(special=(decode_flags(found.special_kind) == kind).values)


@pytest.mark.parametrize("disc", DISCS, ids=str)
def test_one_disc_as_a_system_has_the_same_folds_and_hopf_points(disc):
    """Against polynomials in exact arithmetic, two folds near first touch among them."""
    system = Rotor(omega=1.0, **disc, disc_radius=5.0).system()
    found = special_speeds(system, limits=(0.05, 4.0))
    exact = folds(**disc)
    turns, hopf = of_kind(found, "fold"), of_kind(found, "hopf")
    np.testing.assert_allclose(turns.special_speed, exact.fold_omega.values.ravel(), rtol=1e-10)
    np.testing.assert_allclose(
        turns.amplitude.squeeze("contact"), exact.fold_amplitude.values.ravel(), rtol=1e-7
    )
    exact = hopf_points(**disc)
    np.testing.assert_allclose(hopf.special_speed, exact.hopf_omega.values.ravel(), rtol=1e-10)
    np.testing.assert_allclose(hopf.hopf_frequency, exact.hopf_frequency.values.ravel(), rtol=1e-7)
    grazes = of_kind(found, "graze")
    np.testing.assert_allclose(grazes.amplitude, disc["delta0"], rtol=1e-12)


@pytest.mark.parametrize("disc", [
    {"zeta": 0.05, "delta0": 0.5, "friction": 0.5, "shaft_stiffness": 0.1},
    {"zeta": 0.014396, "delta0": 1.0, "friction": 0.556, "shaft_stiffness": 0.3},
    {"zeta": 0.029059, "delta0": 2.0, "friction": 0.518, "shaft_stiffness": 0.05},
], ids=str)  # fmt: skip
def test_a_hopf_point_beside_a_graze_or_a_fold_is_found(disc):
    """One lies 1.6e-7 from its fold; the grid has steps of 0.015 or, with 20 points, 0.15."""
    system = Rotor(omega=1.0, **disc, disc_radius=5.0).system()
    exact = hopf_points(**disc).hopf_omega.values.ravel()
    exact = exact[exact < 3.0]
    for points in (20, 200):
        found = special_speeds(system, limits=(0.05, 3.0),
                               points=points)  # fmt: skip
        np.testing.assert_allclose(of_kind(found, "hopf").special_speed, exact, rtol=1e-8)


def test_the_number_and_stability_of_whirls_change_at_special_speeds_only():
    """Two contacts at once: between special speeds all whirls last, with their stability."""
    kinds = set()
    for seed in (1,):
        system, contacts, unbalance = random_axisymmetric(seed, stiffest=10.0)
        around = {"contacts": contacts, "unbalance": unbalance}
        found = special_speeds(system, **around, limits=(0.3, 2.2), points=200)
        edges = [0.3, *found.special_speed.values, 2.2]
        kinds |= set(decode_flags(found.special_kind).values.tolist())
        for low, high in pairwise(edges):
            if high - low < 1e-3:
                continue
            here = synchronous_response(system, **around, speed=np.linspace(low, high, 7)[1:-1])
            words = [sorted(zip(row.tolist(), touch.sum(axis=1).tolist(), strict=True))
                     for row, touch in zip(here.stability.values, here.in_contact.values,
                                           strict=True)]  # fmt: skip
            assert all(each == words[0] for each in words), (seed, low, high)
    assert kinds == {"fold", "hopf", "graze"}


def test_a_finite_element_rotor_touches_where_its_unbalance_response_reaches_the_clearance():
    system = beam()
    found = special_speeds(
        system, contacts=[Contact(node="3", clearance=1e-4, stiffness=5e6, exponent=1.0)],
        unbalance=[Unbalance(node="3", moment=2e-4)], limits=(200.0, 420.0), points=40,
    )  # fmt: skip
    assert decode_flags(found.special_kind).values.tolist() == ["graze"]
    assert found.special_speed.attrs["units"] == "s-1"
    at = synchronous_response(
        system, unbalance=[Unbalance(node="3", moment=2e-4)], speed=found.special_speed.values
    )
    assert at.node_amplitude.sel(node="3").item() == pytest.approx(1e-4, rel=1e-9)


def test_bad_limits_are_refused():
    system = RotorSystem(mass=np.eye(2), stiffness=np.eye(2), nodes={"d": (0, 1)}, units="1")
    for limits, words in (
        ((2.0, 1.0), "limits must be two numbers, the lower first, got"),
        ((1.0, 2.0, 3.0), "limits must be two numbers, the lower first, got"),
        ((-1.0, 2.0), "limits must be zero or positive, got -1.0"),
    ):
        with pytest.raises(InputError, match=words):
            special_speeds(system, contacts=[], unbalance=[], limits=limits)
