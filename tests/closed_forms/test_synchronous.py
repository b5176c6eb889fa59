"""Synchronous whirls of every rotor against references that are worked out here, with 50 digits."""

from __future__ import annotations

import itertools
import warnings
from functools import reduce

import mpmath
import numpy as np
import pytest

from rotor_ida.closed_forms import folds, synchronous_response
from rotor_ida.closed_forms.contacting_whirls import bracketed_newton
from rotor_ida.schema import STABILITY

# A few rounding errors of a double: what is left when the roots themselves are exact.
ROUNDING = 1e-14
LAWS = (1.5, 1.0)
mpmath.mp.dps = 50


def roots_of(powers: list) -> list:
    """All roots, with 50 digits, of a polynomial whose coefficients ascend.

    By the method of Durand and Kerner from the roots that doubles have; where these lead nowhere,
    as beside a root that is truly double, from afar and with more digits.
    """
    with mpmath.workdps(70):
        monic = [power / powers[-1] for power in powers]
        roots = [mpmath.mpc(root) for root in np.roots([float(power) for power in monic[::-1]])]
        for _ in range(20):
            largest = mpmath.mpf(0)
            for i, root in enumerate(roots):
                others = [root - other for other in roots[:i] + roots[i + 1 :]]
                if not all(others):
                    largest = mpmath.inf
                    break
                value = reduce(lambda sum_, power, u=root: sum_ * u + power, monic[::-1])
                step = value / mpmath.fprod(others)
                roots[i] -= step
                largest = max(largest, abs(step) / abs(roots[i]) if roots[i] else abs(step))
            if largest < mpmath.mpf(10) ** -50:
                return roots
    with warnings.catch_warnings():  # newer versions would have the coefficients reversed
        warnings.simplefilter("ignore", DeprecationWarning)
        return mpmath.polyroots(powers[::-1], maxsteps=800, extraprec=600)


def reference_whirls(
    omega, zeta, delta0, shaft_stiffness=0.0, contact_exponent=1.5, friction=0.0
) -> list[tuple]:
    """All whirls as (amplitude, phase lag, in contact) with 50 digits, from the polynomial in u."""
    w, z, d, k, mu = map(mpmath.mpf, (omega, zeta, delta0, shaft_stiffness, friction))
    p, h = w**2 - k, 2 * z * w
    whirls = []
    free = w**2 / mpmath.sqrt(p**2 + h**2) if p or h else mpmath.inf
    if free <= d:
        whirls.append((free, mpmath.atan2(h, -p), 0))
    # (f - p A)**2 + (h A + mu f)**2 = w**4 with A = d + u**2
    ff, fa, aa = 1 + mu**2, 2 * (mu * h - p), p**2 + h**2
    if contact_exponent == 1.5:
        powers = [aa * d**2 - w**4, 0, 2 * d * aa, fa * d, aa, fa, ff]
    else:
        powers = [aa * d**2 - w**4, 0, fa * d + 2 * d * aa, 0, ff + fa + aa]
    for root in roots_of(powers):
        u = mpmath.re(root)
        if abs(mpmath.im(root)) < mpmath.mpf(10) ** -22 and u > mpmath.mpf(10) ** -22:
            f, A = u ** (2 * mpmath.mpf(contact_exponent)), d + u**2
            whirls.append((A, mpmath.atan2(h * A + mu * f, f - p * A), 1))
    return sorted(whirls)


def one_point(omega, zeta, delta0, **others) -> dict[str, np.ndarray]:
    whirls = synchronous_response(omega=omega, zeta=zeta, delta0=delta0, **others)
    present = np.isfinite(whirls.amplitude.values.ravel())
    return {name: whirls[name].values.ravel()[present] for name in whirls.data_vars}


def assert_matches_reference(omega, zeta, delta0, rounding=ROUNDING, **others) -> int:
    whirls = one_point(omega, zeta, delta0, **others)
    expected = reference_whirls(omega, zeta, delta0, **others)
    place = (omega, zeta, delta0, others)
    assert whirls["in_contact"].tolist() == [touching for _, _, touching in expected], place
    for k, (amplitude, lag, _) in enumerate(expected):
        assert abs(whirls["amplitude"][k] / amplitude - 1) < rounding, place
        assert abs(whirls["phase_lag"][k] - lag) <= rounding * lag, place
    return len(expected)


def of_the_paper(draw):
    """Rotors over the whole range of use, with zeta = 0 and delta0 = 0 and 1 among them."""
    return {
        "omega": 10.0 ** draw.uniform(-2.0, 1.0),
        "zeta": draw.choice([0.0, 1.0, 1.0, 1.0, 1.0]) * 10.0 ** draw.uniform(-4.0, 0.3),
        "delta0": draw.choice([0.0, 1.0, *10.0 ** draw.uniform(-3.0, 1.0, 3)]),
    }


def with_shaft(draw, exponent):
    """Rotors on a shaft, some of them at its resonance."""
    omega = 10.0 ** draw.uniform(-1.0, 1.0)
    stiffnesses = [omega**2, 10.0 ** draw.uniform(-6.0, 3.0), draw.uniform(0.0, 4.0)]
    return {
        "omega": omega,
        "zeta": draw.choice([0.0, 1.0, 1.0]) * 10.0 ** draw.uniform(-4.0, 0.0),
        "delta0": draw.choice([0.0, 1.0, *draw.uniform(0.1, 3.0, 2)]),
        "shaft_stiffness": draw.choice(stiffnesses),
        "contact_exponent": exponent,
    }


def with_friction(draw):
    """Rotors that rub; a tenth without damping, half with a shaft."""
    return {
        "omega": 10 ** draw.uniform(-1.0, 1.0),
        "zeta": 10 ** draw.uniform(-3.0, 0.0) * (draw.random() > 0.1),
        "delta0": 10 ** draw.uniform(-2.0, 1.0),
        "shaft_stiffness": float(draw.choice([0.0, 10 ** draw.uniform(-2.0, 1.0)])),
        "contact_exponent": float(draw.choice(LAWS)),
        "friction": 10 ** draw.uniform(-3.0, 0.5),
    }


FAMILIES = {
    "paper": of_the_paper,
    "shaft": lambda draw: with_shaft(draw, 1.5),
    "linear": lambda draw: with_shaft(draw, 1.0),
    "friction": with_friction,
}


def scattered(family: str, number: int, *, seed: int) -> list[dict[str, float]]:
    draw = np.random.default_rng(seed)
    return [FAMILIES[family](draw) for _ in range(number)]


@pytest.mark.parametrize(
    ("delta0", "amplitudes", "stability"),
    [
        (0.0, [1.8796312367, 6.1932109611, 9.4872069457], [1, 0, 1]),
        (0.5, [1.1960944557, 8.3859403267, 10.5762914488], [1, 0, 1]),
        (1.0, [0.996626148, 10.2038278365, 11.5515778712], [2, 0, 1]),
        (2.0, [0.996626148], [2]),
    ],
)
def test_amplitudes_of_the_design_at_omega_1_7(delta0, amplitudes, stability):
    whirls = one_point(1.7, 0.07, delta0)
    # the table of DESIGN section 3 prints ten digits, nine for the contact-free whirl
    np.testing.assert_allclose(whirls["amplitude"], amplitudes, rtol=0.0, atol=2e-10)
    assert whirls["stability"].tolist() == stability
    assert whirls["in_contact"].tolist() == [int(kind != 2) for kind in stability]


@pytest.mark.parametrize(
    ("family", "number", "rounding"),
    [("paper", 50, ROUNDING), ("shaft", 50, ROUNDING), ("linear", 60, ROUNDING),
     ("friction", 80, 3e-15)],
)  # fmt: skip
def test_amplitudes_and_phases_hold_to_rounding_at_scattered_points(family, number, rounding):
    """None is lost and none invented."""
    counts = [
        assert_matches_reference(**rotor, rounding=rounding)
        for rotor in scattered(family, number, seed=1)
    ]
    assert {1, 3} <= set(counts)


@pytest.mark.parametrize("away", [1e-6, 1e-14])
@pytest.mark.parametrize("delta0", [0.0, 0.7, 1.0, 3.0])
@pytest.mark.parametrize(
    ("kappa", "exponent"),
    [(0.0, 1.5), (0.04, 1.5), (0.25, 1.5), (1.0, 1.5), (0.0, 1.0), (0.3, 1.0), (2.0, 1.0)],
)
def test_nearly_double_roots_beside_a_fold_are_neither_lost_nor_invented(
    kappa, exponent, delta0, away
):
    given = {"shaft_stiffness": kappa, "contact_exponent": exponent}
    # near a double root an amplitude moves by the square root of what the terms move by
    rounding = ROUNDING if kappa == 0.0 and exponent == 1.5 else 1e-13
    for zeta in (0.01, 0.07):
        turns = folds(zeta=zeta, delta0=delta0, **given).fold_omega.values.ravel()
        for fold in turns[np.isfinite(turns)]:
            counts = [
                assert_matches_reference(omega, zeta, delta0, rounding=rounding, **given)
                for omega in (fold * (1.0 - away), fold * (1.0 + away))
            ]
            assert abs(counts[1] - counts[0]) == 2


def test_whirl_at_the_free_resonance_of_the_shaft():
    for exponent in LAWS:
        given = {"shaft_stiffness": 0.25, "contact_exponent": exponent}
        assert_matches_reference(0.5, 0.07, 1.0, **given)
        assert_matches_reference(0.5, 0.0, 1.0, **given)
        # without damping the whirl that would be free grows without bound: it is in contact
        assert one_point(0.5, 0.0, 1.0, **given)["in_contact"].all()


def test_a_linear_contact_in_resonance_without_damping_has_no_whirl():
    # one double root of P at infinity: 1 + kappa = omega**2
    whirls = synchronous_response(
        omega=1.5, zeta=0.0, delta0=0.5, shaft_stiffness=1.25, contact_exponent=1.0
    )
    assert whirls.sizes["branch"] == 1
    assert (whirls.in_contact == 0).all()


def test_contact_damping_leaves_the_whirls_where_they_are():
    for exponent in LAWS:
        given = {"shaft_stiffness": 0.1, "contact_exponent": exponent}
        plain = one_point(1.7, 0.07, 0.5, **given)
        damped = one_point(1.7, 0.07, 0.5, **given, contact_damping=0.5)
        assert damped["amplitude"].tolist() == plain["amplitude"].tolist()
        assert damped["phase_lag"].tolist() == plain["phase_lag"].tolist()


def test_branch_dimension_is_no_longer_than_the_largest_count():
    assert synchronous_response(omega=1.7, zeta=0.07, delta0=2.0).sizes["branch"] == 1
    assert synchronous_response(omega=1.7, zeta=0.07, delta0=[0.0, 2.0]).sizes["branch"] == 3


@pytest.mark.parametrize(
    ("kappa", "exponent", "delta0", "word"),
    [(0.0, 1.5, 0.0, "neutral"), (0.0, 1.5, 2.0, "neutral"), (0.0, 1.0, 0.0, "stable"),
     (0.0, 1.0, 1.0, "neutral"), (0.3, 1.5, 0.0, "stable"), (0.3, 1.0, 1.0, "stable")],
)  # fmt: skip
def test_a_rotor_at_rest_is_held_by_its_shaft_or_by_a_linear_contact_without_clearance(
    kappa, exponent, delta0, word
):
    for zeta, expected in ((0.1, word), (0.0, "neutral")):
        whirls = one_point(0.0, zeta, delta0, shaft_stiffness=kappa, contact_exponent=exponent)
        assert whirls["amplitude"].tolist() == [0.0]
        assert whirls["phase_lag"].tolist() == [0.0]
        assert whirls["stability"].tolist() == [STABILITY[expected]]
        assert (whirls["growth_rate"] < 0.0) == (expected == "stable")


@pytest.mark.parametrize("zeta", [0.0, 2.0])
def test_whirl_that_just_touches_is_counted_once(zeta):
    # A_f = 3/sqrt(3**2 + (2*2)**2) = 3/5, or 3/3 = 1; the double 0.6 is just below 3/5
    free = 0.6 if zeta else 1.0
    for delta0 in (np.nextafter(free, 0.0), free, np.nextafter(free, 2.0)):
        whirls = one_point(3.0, zeta, delta0)
        near = np.abs(whirls["amplitude"] - free) < 1e-9
        assert near.sum() == 1
        touches = delta0 <= free if zeta else delta0 < free
        assert whirls["in_contact"][near].tolist() == [int(touches)]


@pytest.mark.parametrize("exponent", LAWS)
def test_extreme_laws_give_whirls_without_a_warning(exponent):
    whirls = synchronous_response(
        omega=[0.0, 1e-50, 1e-3, 1.0, 1e15],
        zeta=[0.0, 1e-300, 1e-9, 5.0, 1e15],
        delta0=[1e-300, 1e-9, 1.0, 1e15],
        shaft_stiffness=[0.0, 1e-300, 1e-9, 1.0, 1e15],
        contact_exponent=exponent,
        contact_damping=[0.0, 1e-9, 1e15],
    )
    assert int(np.isfinite(whirls.amplitude).sum("branch").min()) >= (exponent == 1.5)
    assert (whirls.amplitude.diff("branch").fillna(1.0) >= 0.0).all()
    assert np.isfinite(whirls.growth_rate.values[np.isfinite(whirls.amplitude.values)]).all()


def test_extreme_parameters_hold_to_rounding():
    for given in itertools.product(
        [1e-6, 1e-3, 0.5, 50.0], [0.0, 1e-6, 0.01, 5.0], [0.0, 1e-7, 0.999, 50.0]
    ):
        assert_matches_reference(*given)


def test_newton_s_method_is_not_kept_going_by_rounding():
    """Of cubics, multiplied out, whose values near their root are nothing but rounding."""
    root, b, c = np.random.default_rng(4).uniform(0.5, 4.0, (3, 2000))
    calls = []

    def evaluate(u, rows):
        calls.append(rows.size)
        second, first, none = (each[rows] for each in (b - root, c - root * b, -root * c))
        return ((u + second) * u + first) * u + none, (3.0 * u + 2.0 * second) * u + first

    found = bracketed_newton(evaluate, 0.0 * root, 10.0 + root, np.ones(root.size, bool))
    np.testing.assert_allclose(found, root, rtol=1e-13)
    assert len(calls) < 30
