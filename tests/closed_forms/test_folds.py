"""Folds, jumps and cusps of every rotor, against 50-digit references, polynomials and scans."""

from __future__ import annotations

import itertools
import math
import warnings
from dataclasses import asdict
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from rotor_ida.closed_forms import (
    cusp,
    cusp_zeta,
    eigenvalues,
    folds,
    jumps,
    stability_determinant,
    synchronous_response,
    touch_speeds,
)
from rotor_ida.closed_forms.curve_polynomials import CurveEquations, exact_folds
from rotor_ida.closed_forms.restoring_law import RestoringLaw
from rotor_ida.errors import InputError
from rotor_ida.schema import STABILITY
from tests.closed_forms.scanning import scanned

mpmath.mp.dps = 50
# Folds are simple crossings except where two of them merge: a few rounding errors remain.
ROUNDING = 1e-13
# zeta, delta0, stiffness of the shaft, exponent of the contact
LAWS = [
    *itertools.product([0.003, 0.07, 0.2], [0.0, 0.05, 0.5, 0.7, 0.999, 1.0, 3.0], [0.0], [1.5]),
    *itertools.product([0.003, 0.15], [0.1, 1.0, 3.0], [1e-3, 0.25, 2.0], [1.5, 1.0]),
    *itertools.product([0.07], [0.1, 0.7, 3.0], [0.0], [1.0]),
    *itertools.product([0.0], [0.0, 0.5, 2.0], [1e-3, 2.0], [1.5]),
]
RUBBING = [
    {"zeta": 0.07, "delta0": 0.5, "friction": 0.02},
    {"zeta": 0.02, "delta0": 0.8, "friction": 0.1},
    {"zeta": 0.03, "delta0": 1.5, "friction": 0.05, "shaft_stiffness": 0.3},
    {"zeta": 0.02, "delta0": 2.0, "friction": 0.03, "shaft_stiffness": 0.25,
     "contact_exponent": 1.0},
    {"zeta": 0.0, "delta0": 0.5, "friction": 0.05},
    {"zeta": 0.0, "delta0": 1.2, "friction": 0.2, "shaft_stiffness": 0.1},
]  # fmt: skip


def found_at(zeta, delta0, kappa=0.0, exponent=1.5, friction=0.0) -> list[tuple[float, float]]:
    found = folds(
        zeta=zeta, delta0=delta0, shaft_stiffness=kappa, contact_exponent=exponent,
        friction=friction,
    )  # fmt: skip
    pairs = zip(found.fold_omega.values.ravel(), found.fold_amplitude.values.ravel(), strict=True)
    return [pair for pair in pairs if np.isfinite(pair).all()]


def fold_equations(zeta, delta0, kappa, exponent):
    """The curve and its slope by u, both zero at a fold, in u = sqrt(A - delta0) and omega."""
    z, d, k = (mpmath.mpf(each) for each in (zeta, delta0, kappa))
    power = 3 if exponent == 1.5 else 2

    def both(u, omega):
        q, A = omega**2, d + u**2
        F = u**power + (k - q) * A
        m = 4 * z**2 * q
        slope = F * (power * u ** (power - 2) + 2 * (k - q)) + 2 * m * A
        return [(F**2 + m * A**2) / q**2 - 1, slope / q]

    return both


def assert_folds_match(case, rounding=ROUNDING) -> None:
    for omega, amplitude in found_at(*case):
        guess = (mpmath.sqrt(mpmath.mpf(amplitude) - case[1]), mpmath.mpf(omega))
        u, speed = mpmath.findroot(fold_equations(*case), guess, tol=1e-60, maxsteps=60)
        assert abs(omega / speed - 1) < rounding, case
        assert abs(amplitude / (mpmath.mpf(case[1]) + u**2) - 1) < rounding, case


def test_folds_hold_to_rounding():
    for case in LAWS:
        assert_folds_match(case)


def test_no_fold_is_missed_and_none_invented():
    """Between two speeds the number of contacting whirls changes by what lies between them."""
    total = 0
    for zeta, delta0, kappa, exponent in LAWS:
        turns = [omega for omega, _ in found_at(zeta, delta0, kappa, exponent)]
        touches = touch_speeds(zeta=zeta, delta0=delta0, shaft_stiffness=kappa)
        ends = np.sort([*turns, *touches[touches > 0.0]])
        speeds = np.unique(
            np.concatenate([np.geomspace(1e-3, 30.0, 300), ends * (1 - 1e-7), ends * (1 + 1e-7)])
        )
        count = synchronous_response(
            omega=speeds, zeta=zeta, delta0=delta0,
            shaft_stiffness=kappa, contact_exponent=exponent,
        ).in_contact.sum("branch").values.ravel()  # fmt: skip
        for k in np.nonzero(np.diff(count))[0]:
            between = (speeds[k] < ends) & (ends < speeds[k + 1])
            assert between.any(), (zeta, delta0, kappa, exponent, speeds[k])
        for omega in turns:
            k = np.searchsorted(speeds, omega)
            if np.sum((speeds[k - 1] < ends) & (ends < speeds[k])) == 1:
                assert abs(count[k] - count[k - 1]) == 2, (zeta, delta0, kappa, exponent, omega)
                total += 1
    assert total > 60


def linear_cubic(zeta, delta0, kappa) -> list:
    """``q (1 + kappa - q)**2 = 4 zeta**2 (delta0**2 - q**2)`` where its whirl is in contact."""
    z, d, k = mpmath.mpf(zeta), mpmath.mpf(delta0), 1 + mpmath.mpf(kappa)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        roots = mpmath.polyroots(
            [1, 4 * z**2 - 2 * k, k**2, -4 * z**2 * d**2], maxsteps=500, extraprec=300
        )
    found = []
    for root in roots:
        q = mpmath.re(root)
        if abs(mpmath.im(root)) > 1e-30 or q <= 0:
            continue
        amplitude = (k - q) * d / ((k - q) ** 2 + 4 * z**2 * q)
        if amplitude > d * (1 + mpmath.mpf(10) ** -30):  # else the first touch
            found.append((mpmath.sqrt(q), amplitude))
    return sorted(found)


@pytest.mark.parametrize("friction", [0.0, 0.02])
def test_two_folds_of_the_same_amplitude_are_both_found(friction):
    """Folds of a linear contact at ``A = 1/delta0`` if ``4 zeta**2 = 1 - delta0**2``.

    Both speeds are then one double root of the polynomial in the amplitude.
    """
    zeta, delta0 = Fraction(5, 26), Fraction(12, 13)
    law = RestoringLaw(delta0, contact_exponent=1.0, friction=friction)
    found = exact_folds(CurveEquations(zeta, law))
    expected = linear_cubic(5 / mpmath.mpf(26), 12 / mpmath.mpf(13), 0.0)
    if friction == 0.0:
        assert [amplitude for _, amplitude in found] == [13 / 12, 13 / 12]
    else:  # a little friction neither adds nor removes folds, but moves them apart
        assert found[0].amplitude != found[1].amplitude
    assert len(found) == 2
    for fold, (omega, amplitude) in zip(found, expected, strict=True):
        assert abs(fold.omega / omega - 1) < (3 * friction or ROUNDING)
        assert abs(fold.amplitude / amplitude - 1) < (3 * friction or ROUNDING)


@pytest.mark.parametrize("kappa", [0.0, 1e-4, 0.25, 2.0])
def test_folds_of_a_linear_contact_are_roots_of_a_cubic(kappa):
    cases = [*itertools.product([1e-7, 1e-5, 0.07, 0.3], [0.05, 0.5, 0.9, 1.0, 1.1, 8.0])]
    if kappa == 0.0:  # with 4 zeta**2 = 1 - delta0**2 one is at the first touch, which is no fold
        cases += [(0.14, 0.96), (0.3, 0.8), (0.4, 0.6), (0.48, 0.28)]
    for zeta, delta0 in cases:
        at_touch = abs(4.0 * zeta**2 + delta0**2 - 1.0) < 1e-15
        expected = [pair for pair in linear_cubic(zeta, delta0, kappa)
                    if not at_touch or pair[1] > delta0 * (1 + 1e-12)]  # fmt: skip
        found = found_at(zeta, delta0, kappa, 1.0)
        assert len(found) == len(expected), (zeta, delta0, kappa)
        for (omega, amplitude), (speed, size) in zip(found, expected, strict=True):
            assert abs(omega / speed - 1) < ROUNDING
            assert abs(amplitude / size - 1) < ROUNDING


def test_a_linear_contact_without_clearance_has_no_fold():
    assert found_at(0.01, 0.0, 0.3, 1.0) == []
    assert np.isnan(cusp_zeta(0.0, contact_exponent=1.0))


def fold_condition(A, omega, rotor):
    inside = np.where(np.isfinite(omega), omega, 0.0)
    return np.where(np.isfinite(omega), stability_determinant(A, omega=inside, **rotor), np.nan)


@pytest.mark.parametrize("rotor", RUBBING)
def test_no_fold_with_friction_is_lost_and_none_invented(rotor):
    found = folds(**rotor).fold_amplitude.values.ravel()
    expected = scanned(rotor, fold_condition)
    inside = np.sort(found[found < 40.0])
    np.testing.assert_allclose(inside, expected, rtol=0.0, atol=2e-4)


def test_without_damping_one_fold_is_left_below_unit_clearance():
    # u**3 = q (u**2 - 1) has a double root at u**2 = 3, q**2 = 27/4
    assert found_at(0.0, 0.0) == [(pytest.approx(6.75**0.25, rel=1e-15), 3.0)]
    assert len(found_at(0.0, 0.9)) == 1
    assert found_at(0.0, 1.0) == []
    slight = found_at(1e-9, 0.25)
    assert len(slight) == 4
    np.testing.assert_allclose(slight[2], found_at(0.0, 0.25)[0], rtol=1e-12)


def test_contact_damping_moves_no_fold_but_an_eigenvalue_vanishes_there_too():
    found = folds(zeta=0.07, delta0=0.5, shaft_stiffness=0.1, contact_damping=[0.0, 0.8])
    assert found.fold_omega.dims == ("zeta", "delta0", "contact_damping", "fold")
    with_damping = found.isel(contact_damping=1)
    assert found.isel(contact_damping=0).fold_omega.values.tolist() == (
        with_damping.fold_omega.values.tolist()
    )
    for omega, amplitude in zip(
        with_damping.fold_omega.values.ravel(), with_damping.fold_amplitude.values.ravel(),
        strict=True,
    ):  # fmt: skip
        rates = eigenvalues(
            amplitude, omega=omega, zeta=0.07, delta0=0.5, shaft_stiffness=0.1,
            contact_damping=0.8,
        )  # fmt: skip
        assert np.abs(rates).min() < 1e-12


def test_number_of_folds_need_not_fall_with_the_damping():
    found = folds(zeta=[0.1, 0.246, 0.247, 0.2475, 0.25], delta0=0.7237)
    assert found.fold_omega.notnull().sum("fold").values.ravel().tolist() == [4, 2, 4, 2, 0]


# Without clearance the two folds merge at A = 12/sqrt(10), a = 2/sqrt(10), b = sqrt(10), where
# d/dA [(1 - a**2)/(sqrt(A) b)] = 0; so 4 zeta**2 = 0.6/(sqrt(A) sqrt(10)).
CUSP_ZETA = np.sqrt(0.15 / (np.sqrt(12.0) * 10.0**0.25))


def test_jumps_without_clearance_need_a_damping_below_0_15604517():
    assert cusp_zeta(0.0) == pytest.approx(CUSP_ZETA, rel=1e-15)
    assert pytest.approx(0.156045165, abs=5e-10) == CUSP_ZETA
    assert len(found_at(CUSP_ZETA * (1.0 - 1e-13), 0.0)) == 2
    assert len(found_at(CUSP_ZETA * (1.0 + 1e-13), 0.0)) == 0


def random_laws(count):
    """Laws of every kind, over many decades."""
    draw = np.random.default_rng(5)
    for _ in range(count):
        yield RestoringLaw(
            delta0=draw.choice([draw.uniform(0.0, 3.0), 10.0 ** draw.uniform(-6.0, 3.0)]),
            shaft_stiffness=draw.choice([0.0, 10.0 ** draw.uniform(-3.0, 1.0)]),
            contact_exponent=draw.choice([1.0, 1.5]),
            friction=draw.choice([0.0, 10.0 ** draw.uniform(-4.0, 0.3)]),
        )


def test_folds_cease_at_the_cusp():
    with_cusp = 0
    clearances = (0.0, 0.1, 0.39, 0.65, 0.70086, 0.7237, 1.0, 10.0)
    for law in [*map(RestoringLaw, clearances), *random_laws(30)]:
        given = {name: float(each) for name, each in asdict(law).items()}
        limit = cusp(**given)
        zeta, omega, amplitude = (limit[name].item() for name in limit.data_vars)
        np.testing.assert_equal(cusp_zeta(**given), zeta)
        if math.isnan(zeta):
            assert not any(exact_folds(CurveEquations(each, law)) for each in (1e-6, 1e-3, 0.07))
            continue
        with_cusp += 1
        for factor in (1.0 + 1e-10, 1.01, 1.3):
            assert exact_folds(CurveEquations(zeta * factor, law)) == ()
        beneath = exact_folds(CurveEquations(zeta * (1.0 - 1e-8), law))
        near = [fold for fold in beneath if abs(fold.omega / omega - 1.0) < 1e-2]
        at_touch = amplitude < law.delta0 * (1.0 + 1e-6)  # only a linear contact
        assert len(near) == (1 if at_touch else 2), law
        np.testing.assert_allclose(np.mean(near, axis=0), (omega, amplitude), rtol=1e-5)
    assert with_cusp > 20


def test_the_last_fold_of_a_linear_contact_vanishes_at_the_ring():
    # without a shaft 4 zeta**2 = 1 - delta0**2 at A = delta0
    last = cusp(delta0=0.6, contact_exponent=1.0)
    assert last.cusp_zeta.item() == pytest.approx(0.4, rel=1e-12)
    assert last.cusp_amplitude.item() == pytest.approx(0.6, rel=1e-12)
    assert len(found_at(0.4 * (1 - 1e-9), 0.6, 0.0, 1.0)) == 1
    assert len(found_at(0.4 * (1 + 1e-9), 0.6, 0.0, 1.0)) == 0


def test_cusp_of_largest_damping_bounds_every_clearance():
    highest = cusp()
    scan = np.concatenate([np.linspace(0.0, 3.0, 31), np.geomspace(3.0, 1e3, 8)[1:]])
    table = cusp(delta0=scan).cusp_zeta
    assert highest.cusp_zeta.item() >= float(table.max())
    assert highest.cusp_zeta.item() == pytest.approx(0.2510030, abs=5e-8)
    assert abs(highest.delta0.item() - scan[int(table.values.argmax())]) <= 0.05


def test_much_friction_leaves_no_fold_at_all():
    assert math.isnan(cusp_zeta(0.5, friction=2.0))
    assert math.isnan(cusp_zeta(0.1, friction=0.4, contact_exponent=1.0))
    assert np.isnan(folds(zeta=[0.0, 1e-3, 0.07], delta0=0.5, friction=2.0).fold_omega).all()
    axis = cusp(delta0=0.5, friction=[0.0, 0.1, 2.0])
    assert axis.cusp_zeta.dims == ("delta0", "friction")
    np.testing.assert_array_equal(axis.cusp_zeta.values[0, 0], cusp_zeta(0.5))


@pytest.mark.parametrize(
    ("rotor", "count"),
    [
        ({"zeta": 0.07, "delta0": 0.0}, 2),
        ({"zeta": 0.07, "delta0": 0.5}, 4),
        ({"zeta": 0.07, "delta0": 2.0}, 2),
        ({"zeta": 0.07, "delta0": 0.5, "shaft_stiffness": 0.25, "contact_damping": 0.1}, 1),
        ({"zeta": 0.07, "delta0": 2.0, "shaft_stiffness": 0.25}, 1),
        ({"zeta": 0.07, "delta0": 0.5, "friction": 0.02}, 1),
        ({"zeta": [1.0, 1.5, 2.0], "delta0": 0.0}, 0),
    ],
)
def test_a_jump_lands_on_a_whirl_that_is_not_unstable(rotor, count):
    found = jumps(**rotor)
    assert found.landing_amplitude.dims == found.fold_omega.dims
    speeds, landings = found.fold_omega.values.ravel(), found.landing_amplitude.values.ravel()
    leaving = found.fold_amplitude.values.ravel()
    for omega, landing, left in zip(speeds, landings, leaving, strict=True):
        if np.isfinite(landing):
            assert abs(landing / left - 1.0) > 1e-2
            here = synchronous_response(omega=omega, **rotor)
            lasting = here.amplitude.where(here.stability != STABILITY["unstable"]).values
            assert np.nanmin(abs(lasting - landing)) < 1e-12
    assert np.isfinite(landings).sum() >= count
    assert np.isfinite(speeds).any() == (count > 0)


@pytest.mark.parametrize(
    ("rotor", "fold"),
    [
        # A fold so close to first touch that its whirl is as large as the one to land on, ...
        ({"zeta": 4.7e-07, "delta0": 0.00111, "friction": 4.06e-4}, 0),
        ({"zeta": 1e-7, "delta0": 6.3e-6}, 0),
        # ... and a resonance so sharp that at the rounded speed the two that merge lie apart.
        ({"zeta": 5.213999653471557e-06, "delta0": 1.000000001, "contact_exponent": 1.0}, 1),
    ],
)
def test_a_jump_lands_on_the_free_whirl_however_near_and_however_sharp_the_fold(rotor, fold):
    found = jumps(**rotor).isel(fold=fold).squeeze()
    omega = found.fold_omega.item()
    free = omega / math.hypot(omega, 2.0 * rotor["zeta"])
    assert found.landing_amplitude.item() == pytest.approx(free, rel=1e-13)


@pytest.mark.parametrize(
    ("function", "values", "message"),
    [
        (folds, {"zeta": 1e-30}, "zeta must be 0 or between 1e-20 and"),
        (folds, {"delta0": -1.0}, r"delta0 must be zero or positive, got -1\.0"),
        (cusp, {"delta0": -0.1}, "delta0 must be zero or positive"),
        (cusp, {"delta0": None, "friction": 0.1}, "delta0 must be given with friction"),
        (folds, {"friction": -0.1}, "friction must be zero or positive, got -0.1"),
        (folds, {"friction": 1e9}, "friction must be 0 or between 1e-20 and 1e"),
        (jumps, {"friction": 0.1, "delta0": 0.0}, "friction must be 0 without clearance"),
        (folds, {"shaft_stiffness": -1.0}, "shaft_stiffness must be zero or positive, got -1.0"),
        (folds, {"shaft_stiffness": 1e7}, "shaft_stiffness must be 0 or between 1e-20 and 1e\\+06"),
        (jumps, {"contact_exponent": 1.2}, "contact_exponent must be 1.5 or 1, got 1.2"),
        (folds, {"contact_damping": 1.0, "delta0": 0.0}, "contact_damping must be 0 without"),
        (cusp, {"delta0": None, "shaft_stiffness": 1.0}, "delta0 must be given with shaft_stiff"),
        (cusp, {"contact_exponent": np.nan}, "contact_exponent must be a finite real number"),
    ],
)
def test_parameters_out_of_range_are_refused(function, values, message):
    given = {"delta0": 0.5, **values}
    if function is not cusp:
        given = {"zeta": 0.07, **given}
    with pytest.raises(InputError, match=message):
        function(**given)


def test_the_cusp_of_a_stiff_shaft_parts_two_folds_from_none():
    cusp = cusp_zeta(0.5, shaft_stiffness=1e6)
    assert len(found_at(cusp * (1 - 1e-9), 0.5, 1e6)) == 2
    assert found_at(cusp * (1 + 1e-9), 0.5, 1e6) == []
