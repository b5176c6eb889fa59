"""Synchronous whirls against references that are worked out here, with 50 digits."""

from __future__ import annotations

import warnings
from fractions import Fraction
from itertools import pairwise

import mpmath
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from rotor_ida.closed_forms import folds, stability_determinant, synchronous_response
from rotor_ida.errors import InputError
from rotor_ida.model import contact
from rotor_ida.schema import STABILITY

# A few rounding errors of a double: what is left when the roots themselves are exact.
ROUNDING = 1e-14
mpmath.mp.dps = 50


def reference_whirls(omega: float, zeta: float, delta0: float) -> list[tuple]:
    """All whirls as (amplitude, phase lag, in contact) with 50 digits, from the polynomial."""
    w, z, d = mpmath.mpf(omega), mpmath.mpf(zeta), mpmath.mpf(delta0)
    q = w**2
    stiff = q**2 + 4 * z**2 * q
    coefficients = [1, -2 * q, stiff, -2 * q * d, 2 * d * stiff, 0, d**2 * stiff - q**2]
    whirls = []
    free = w / mpmath.sqrt(q + 4 * z**2)
    if free <= d:
        whirls.append((free, mpmath.atan2(2 * z, -w), 0))
    with warnings.catch_warnings():  # newer versions would have the coefficients reversed
        warnings.simplefilter("ignore", DeprecationWarning)
        roots = mpmath.polyroots(coefficients, maxsteps=500, extraprec=400)
    for root in roots:
        if abs(mpmath.im(root)) < mpmath.mpf(10) ** -22 and mpmath.re(root) > mpmath.mpf(10) ** -22:
            u = mpmath.re(root)
            amplitude = d + u**2
            lag = mpmath.atan2(2 * z * w, u**3 / amplitude - q)
            whirls.append((amplitude, lag, 1))
    return sorted(whirls)


def one_point(omega: float, zeta: float, delta0: float) -> dict[str, np.ndarray]:
    whirls = synchronous_response(omega=omega, zeta=zeta, delta0=delta0)
    present = np.isfinite(whirls.amplitude.values.ravel())
    return {name: whirls[name].values.ravel()[present] for name in whirls.data_vars}


def assert_matches_reference(omega: float, zeta: float, delta0: float) -> None:
    whirls, expected = one_point(omega, zeta, delta0), reference_whirls(omega, zeta, delta0)
    assert whirls["amplitude"].size == len(expected), (omega, zeta, delta0)
    assert whirls["in_contact"].tolist() == [touching for _, _, touching in expected]
    for k, (amplitude, lag, _) in enumerate(expected):
        assert abs(whirls["amplitude"][k] / amplitude - 1) < ROUNDING, (omega, zeta, delta0)
        assert abs(whirls["phase_lag"][k] - lag) <= ROUNDING * lag, (omega, zeta, delta0)


def scattered(number: int, *, seed: int) -> np.ndarray:
    """Rotors over the whole range of use, with zeta = 0 and delta0 = 0 and 1 among them."""
    rng = np.random.default_rng(seed)
    omega = 10.0 ** rng.uniform(-2.0, 1.0, number)
    zeta = rng.choice([0.0, 1.0, 1.0, 1.0, 1.0], number) * 10.0 ** rng.uniform(-4.0, 0.3, number)
    delta0 = rng.choice([0.0, 1.0, -1.0, -1.0, -1.0], number)
    delta0 = np.where(delta0 < 0.0, 10.0 ** rng.uniform(-3.0, 1.0, number), delta0)
    return np.stack([omega, zeta, delta0], axis=1)


@pytest.mark.parametrize(
    ("delta0", "amplitudes", "stability"),
    [
        (0.0, [1.8796312367, 6.1932109611, 9.4872069457], [0, 1, 0]),
        (0.5, [1.1960944557, 8.3859403267, 10.5762914488], [0, 1, 0]),
        (1.0, [0.996626148, 10.2038278365, 11.5515778712], [2, 1, 0]),
        (2.0, [0.996626148], [2]),
    ],
)
def test_amplitudes_of_the_design_at_omega_1_7(delta0, amplitudes, stability):
    whirls = one_point(1.7, 0.07, delta0)
    # the table of DESIGN section 3 prints ten digits, nine for the contact-free whirl
    np.testing.assert_allclose(whirls["amplitude"], amplitudes, rtol=0.0, atol=2e-10)
    assert whirls["stability"].tolist() == stability
    assert whirls["in_contact"].tolist() == [int(kind != 2) for kind in stability]


def test_growth_rate_and_phase_lag_of_the_unstable_and_small_whirl():
    whirls = one_point(1.7, 0.07, 0.0)
    assert whirls["growth_rate"][1] == pytest.approx(0.09830, abs=5e-6)
    assert whirls["phase_lag"][0] == pytest.approx(2.98617, abs=5e-6)
    assert (whirls["growth_rate"][[0, 2]] < 0.0).all()


def test_clearance_raises_the_amplitude_below_resonance():
    amplitudes = [one_point(1.2, 0.07, delta0)["amplitude"].max() for delta0 in (0, 0.5, 1, 2)]
    assert np.round(amplitudes, 3).tolist() == [3.363, 4.319, 5.214, 6.873]
    assert one_point(1.2, 0.07, 0.5)["phase_lag"][0] == pytest.approx(0.52809, abs=5e-6)


def test_amplitudes_and_phases_hold_to_rounding_at_scattered_points():
    for omega, zeta, delta0 in scattered(60, seed=1):
        assert_matches_reference(omega, zeta, delta0)


@pytest.mark.parametrize("delta0", [0.0, 1.0, 3.0])
@pytest.mark.parametrize("omega", [2.9, 3.1, 3.3, 3.6])
def test_large_whirls_at_light_damping_hold_to_rounding(omega, delta0):
    assert_matches_reference(omega, 0.01, delta0)


def test_light_damping_reaches_amplitudes_near_a_hundred():
    assert 60.0 < one_point(3.1, 0.01, 1.0)["amplitude"].max() < 140.0


@pytest.mark.parametrize("away", [1e-6, 1e-9, 1e-12, 1e-14])
@pytest.mark.parametrize("delta0", [0.0, 0.1, 0.7, 1.0, 3.0])
@pytest.mark.parametrize("zeta", [0.01, 0.07])
def test_nearly_double_roots_beside_a_fold_are_neither_lost_nor_invented(zeta, delta0, away):
    for fold in folds(zeta=zeta, delta0=delta0).fold_omega.values.ravel():
        if np.isnan(fold):
            continue
        for omega in (fold * (1.0 - away), fold * (1.0 + away)):
            assert_matches_reference(omega, zeta, delta0)


def test_two_whirls_more_on_one_side_of_a_fold():
    fold = float(folds(zeta=0.07, delta0=0.0).fold_omega.values.ravel()[0])
    below = one_point(fold * (1.0 - 1e-14), 0.07, 0.0)
    above = one_point(fold * (1.0 + 1e-14), 0.07, 0.0)
    assert (below["amplitude"].size, above["amplitude"].size) == (1, 3)
    assert above["stability"].tolist() == [0, 1, 0]


def sign_changes(omega: float, zeta: float, delta0: float) -> int:
    """Count contacting whirls with Sturm's theorem, in exact rational arithmetic."""
    w, z, d = Fraction(omega), Fraction(zeta), Fraction(delta0)
    q = w**2
    stiff = q**2 + 4 * z**2 * q
    polynomial = [
        Fraction(1),
        -2 * q,
        stiff,
        -2 * q * d,
        2 * d * stiff,
        Fraction(0),
        d**2 * stiff - q**2,
    ]
    while polynomial[-1] == 0:  # roots at u = 0 are no contacting whirls
        polynomial = polynomial[:-1]
    degree = len(polynomial) - 1
    slope = [c * (degree - k) for k, c in enumerate(polynomial[:-1])]
    ramp = [polynomial, slope]
    while len(ramp[-1]) > 1:
        remainder = list(ramp[-2])
        divisor = ramp[-1]
        while len(remainder) >= len(divisor):
            factor = remainder[0] / divisor[0]
            padded = divisor + [Fraction(0)] * (len(remainder) - len(divisor))
            remainder = [r - factor * c for r, c in zip(remainder, padded, strict=True)][1:]
        while remainder and remainder[0] == 0:
            remainder = remainder[1:]
        if not remainder:
            break
        scale = abs(remainder[0])
        ramp.append([-r / scale for r in remainder])

    def variations(values: list) -> int:
        signs = [value > 0 for value in values if value != 0]
        return sum(a != b for a, b in pairwise(signs))

    return variations([p[-1] for p in ramp]) - variations([p[0] for p in ramp])


def scattered_grid(*, seed: int) -> xr.Dataset:
    """The whirls of 4,032 rotors on scattered axes, half of them where up to four exist."""
    rng = np.random.default_rng(seed)
    omega = np.concatenate([10.0 ** rng.uniform(-2.0, 1.0, 12), rng.uniform(0.1, 3.0, 12)])
    zeta = np.concatenate([[0.0], 10.0 ** rng.uniform(-4.0, 0.3, 5), rng.uniform(0.0, 0.2, 6)])
    delta0 = np.concatenate([[0.0, 1.0], 10.0 ** rng.uniform(-3, 1, 5), rng.uniform(0, 1.2, 7)])
    return synchronous_response(omega=omega, zeta=zeta, delta0=delta0)


def test_sturm_counts_as_many_whirls_at_thousands_of_points():
    whirls = scattered_grid(seed=2)
    counted = whirls.in_contact.sum("branch").stack(point=("omega", "zeta", "delta0"))
    expected = [sign_changes(*parameters) for parameters in counted.point.values]
    assert set(expected) == {0, 1, 2, 3}
    np.testing.assert_array_equal(counted.values, expected)


def test_equation_of_motion_is_satisfied_at_every_branch():
    whirls = scattered_grid(seed=4)
    A, q, delta0 = whirls.amplitude, whirls.omega**2, whirls.delta0.values[:, None]
    force = A.copy(data=contact.contact_force(A.values, delta0))
    # relative to the largest of the four terms of the equation
    largest = np.maximum(
        np.maximum(force, q * A), np.maximum(q, 2 * whirls.zeta * whirls.omega * A)
    )
    impedance = force - q * A + 2j * whirls.zeta * whirls.omega * A
    residual = np.abs(impedance * np.exp(-1j * whirls.phase_lag) - q)
    assert float((residual / largest).max()) < 1e-12


def test_residual_is_below_1e_12_of_the_forcing_where_amplitudes_are_moderate():
    whirls = synchronous_response(
        omega=np.linspace(0.2, 3.0, 57), zeta=[0.05, 0.1, 0.3], delta0=[0.0, 0.5, 1.0]
    )
    A, q = whirls.amplitude, whirls.omega**2
    force = contact.contact_force(A.values, whirls.delta0.values[:, None])
    impedance = force - q * A + 2j * whirls.zeta * whirls.omega * A
    residual = np.abs(impedance * np.exp(-1j * whirls.phase_lag) - q) / q
    assert float(residual.max()) < 1e-12


def test_a_grid_holds_what_single_points_hold():
    axes = {"omega": [0.0, 0.6, 1.7, 3.0], "zeta": [0.0, 0.07], "delta0": [0.0, 0.5, 1.0, 2.0]}
    grid = synchronous_response(**axes)
    assert grid.amplitude.dims == ("omega", "zeta", "delta0", "branch")
    assert grid.amplitude.shape[:3] == (4, 2, 4)
    for omega in axes["omega"]:
        for zeta in axes["zeta"]:
            for delta0 in axes["delta0"]:
                point = grid.sel(omega=omega, zeta=zeta, delta0=delta0)
                alone = one_point(omega, zeta, delta0)
                count = alone["amplitude"].size
                for name, values in alone.items():
                    assert point[name].values[:count].tolist() == values.tolist()
                assert np.isnan(point.amplitude.values[count:]).all()
                assert np.isnan(point.growth_rate.values[count:]).all()
                assert (point.stability.values[count:] == STABILITY["absent"]).all()
                assert (point.in_contact.values[count:] == 0).all()


def test_branch_dimension_is_no_longer_than_the_largest_count():
    assert synchronous_response(omega=1.7, zeta=0.07, delta0=2.0).sizes["branch"] == 1
    assert synchronous_response(omega=1.7, zeta=0.07, delta0=[0.0, 2.0]).sizes["branch"] == 3


def test_a_rotor_that_does_not_turn_rests():
    for zeta in (0.0, 0.3):
        for delta0 in (0.0, 2.0):
            whirls = one_point(0.0, zeta, delta0)
            assert whirls["amplitude"].tolist() == [0.0]
            assert whirls["phase_lag"].tolist() == [0.0]
            assert whirls["stability"].tolist() == [STABILITY["neutral"]]
            assert whirls["growth_rate"].tolist() == [0.0]


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


def test_without_damping_the_whirls_that_do_not_run_away_are_neutral():
    whirls = one_point(2.0, 0.0, 0.0)
    assert whirls["stability"].tolist() == [2, 1, 2]
    assert whirls["growth_rate"][[0, 2]].tolist() == [0.0, 0.0]
    assert whirls["phase_lag"].tolist() == [np.pi, np.pi, 0.0]


def test_extreme_parameters_give_whirls_without_a_warning():
    whirls = synchronous_response(
        omega=[0.0, 1e-50, 1e-6, 1e-3, 50.0, 1e15],
        zeta=[0.0, 1e-300, 1e-9, 5.0, 1e15],
        delta0=[0.0, 1e-300, 1e-9, 1.0, np.nextafter(1.0, 2.0), 50.0, 1e15],
    )
    count = np.isfinite(whirls.amplitude).sum("branch")
    assert int(count.min()) == 1
    assert (whirls.amplitude.diff("branch").fillna(1.0) >= 0.0).all()


@pytest.mark.parametrize("zeta", [0.0, 1e-6, 0.01, 5.0])
@pytest.mark.parametrize("omega", [1e-6, 1e-3, 0.5, 50.0])
@pytest.mark.parametrize("delta0", [0.0, 1e-7, 0.999, 50.0])
def test_extreme_parameters_hold_to_rounding(omega, zeta, delta0):
    assert_matches_reference(omega, zeta, delta0)


@settings(max_examples=150, deadline=None)
@given(
    omega=st.floats(1e-3, 20.0),
    zeta=st.one_of(st.just(0.0), st.floats(1e-6, 3.0)),
    delta0=st.one_of(st.just(0.0), st.floats(1e-6, 10.0)),
)
def test_stability_alternates_along_the_contacting_branches(omega, zeta, delta0):
    whirls = one_point(omega, zeta, delta0)
    touching = whirls["in_contact"] == 1
    unstable = whirls["stability"][touching] == STABILITY["unstable"]
    assert (np.diff(unstable.astype(int)) != 0).all()
    if unstable.size:
        assert not unstable[-1]
        assert unstable[0] == (touching.size > touching.sum())
    assert ((whirls["growth_rate"] > 0.0)[touching] == unstable).all()
    assert (np.diff(whirls["amplitude"]) > 0.0).all()
    assert ((whirls["phase_lag"] >= 0.0) & (whirls["phase_lag"] <= np.pi)).all()


def test_stability_is_the_sign_of_the_determinant():
    for omega, zeta, delta0 in scattered(300, seed=5):
        whirls = one_point(omega, zeta, delta0)
        touching = whirls["in_contact"] == 1
        determinant = stability_determinant(
            whirls["amplitude"][touching], omega=omega, zeta=zeta, delta0=delta0
        )
        unstable = whirls["stability"][touching] == STABILITY["unstable"]
        clear = np.abs(determinant) > 1e-9 * omega**2
        assert ((determinant < 0.0) == unstable)[clear].all()


def test_amplitudes_agree_with_a_root_finder_in_the_amplitude():
    def excess(A):
        s = contact.secant_stiffness(A, 0.5)
        return A**2 * ((s - 1.7**2) ** 2 + 4 * 0.07**2 * 1.7**2) - 1.7**4

    expected = [brentq(excess, *pair, xtol=1e-14) for pair in ((0.6, 2), (5, 9), (9, 14))]
    np.testing.assert_allclose(one_point(1.7, 0.07, 0.5)["amplitude"], expected, rtol=1e-13)


def test_attributes_say_what_the_dataset_is():
    whirls = synchronous_response(omega=1.0, zeta=0.1, delta0=0.0)
    assert whirls.attrs["Conventions"] == "CF-1.11"
    assert all(whirls[name].attrs["long_name"] for name in whirls.variables)
    assert whirls.stability.dtype == np.int8
    assert whirls.in_contact.dtype == np.int8


@pytest.mark.parametrize(
    ("given_values", "message"),
    [
        ({"omega": -1.0}, "omega must be zero or positive, got -1.0"),
        ({"zeta": [0.1, np.nan]}, "zeta must be a finite real number, got nan"),
        ({"delta0": []}, "delta0 must hold at least one number"),
        ({"omega": 1e-60}, "omega must be 0 or between 1e-50 and 1e\\+15, got 1e-60"),
        ({"delta0": 1e16}, "delta0 must be at most 1e\\+15, got 1e\\+16"),
    ],
)
def test_parameters_out_of_range_are_refused(given_values, message):
    with pytest.raises(InputError, match=message):
        synchronous_response(**{"omega": 1.0, "zeta": 0.1, "delta0": 0.0, **given_values})
