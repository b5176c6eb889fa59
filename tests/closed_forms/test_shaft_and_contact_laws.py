"""Synchronous whirls with a shaft, either contact law and contact damping, held by 50 digits.

Amplitudes are held against roots found with mpmath, eigenvalues against those of a Jacobian that
is differentiated numerically from the equation of motion, growth against an integration of it.
"""

from __future__ import annotations

import functools
import itertools
import warnings

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rotor_ida.closed_forms import eigenvalues, stability_determinant, synchronous_response
from rotor_ida.errors import InputError
from rotor_ida.schema import STABILITY

mpmath.mp.dps = 50
ROUNDING = 1e-14


def reference_whirls(omega, zeta, delta0, kappa, exponent) -> list[tuple]:
    """All whirls as (amplitude, phase lag, in contact), from the polynomial in u or in A."""
    w, z, d, k = (mpmath.mpf(each) for each in (omega, zeta, delta0, kappa))
    q, p = w**2, w**2 - k
    m = 4 * z**2 * q
    whirls = []
    free = q / mpmath.sqrt(p**2 + m) if p or m else mpmath.inf
    if free <= d:
        whirls.append((free, mpmath.atan2(2 * z * w, -p), 0))
    if exponent == 1.5:
        stiff = p**2 + m
        coefficients = [1, -2 * p, stiff, -2 * p * d, 2 * d * stiff, 0, d**2 * stiff - q**2]
    else:  # in u as well, with A = d + u**2
        G = (1 - p) ** 2 + m
        linear = 2 * (G * d - (1 - p) * d)
        coefficients = [G, 0, linear, 0, d**2 * (p**2 + m) - q**2]
    with warnings.catch_warnings():  # newer versions would have the coefficients reversed
        warnings.simplefilter("ignore", DeprecationWarning)
        roots = mpmath.polyroots(coefficients, maxsteps=500, extraprec=400)
    for root in roots:
        if abs(mpmath.im(root)) < mpmath.mpf(10) ** -22 and mpmath.re(root) > mpmath.mpf(10) ** -22:
            u = mpmath.re(root)
            force = u**3 if exponent == 1.5 else u**2
            amplitude = d + u**2
            lag = mpmath.atan2(2 * z * w, force / amplitude - p)
            whirls.append((amplitude, lag, 1))
    return sorted(whirls)


def one_point(omega, zeta, delta0, kappa, exponent, damping=0.0) -> dict[str, np.ndarray]:
    whirls = synchronous_response(
        omega=omega,
        zeta=zeta,
        delta0=delta0,
        shaft_stiffness=kappa,
        contact_exponent=exponent,
        contact_damping=damping,
    )
    present = np.isfinite(whirls.amplitude.values.ravel())
    return {name: whirls[name].values.ravel()[present] for name in whirls.data_vars}


def assert_matches_reference(*place, rounding=ROUNDING) -> int:
    whirls, expected = one_point(*place), reference_whirls(*place)
    assert whirls["in_contact"].tolist() == [touching for _, _, touching in expected], place
    for k, (amplitude, lag, _) in enumerate(expected):
        assert abs(whirls["amplitude"][k] / amplitude - 1) < rounding, place
        assert abs(whirls["phase_lag"][k] - lag) <= rounding * lag, place
    return len(expected)


def field(t, state, omega, zeta, delta0, kappa, exponent, damping):
    """The equation of motion on the fixed axes, written out here."""
    x, y, vx, vy = state
    r = np.hypot(x, y)
    depth = max(r - delta0, 0.0)
    normal = max(0.0, depth**exponent * (1.0 + damping * (x * vx + y * vy) / r))
    ax = omega**2 * np.cos(omega * t) - 2.0 * zeta * vx - kappa * x - normal * x / r
    ay = omega**2 * np.sin(omega * t) - 2.0 * zeta * vy - kappa * y - normal * y / r
    return np.array([vx, vy, ax, ay])


def jacobian(amplitude, lag, *place) -> np.ndarray:
    """The linearised motion on the rotating axes, by central differences of `field` at t = 0."""
    omega = place[0]
    v = amplitude * np.exp(-1j * lag)
    rest = np.array([v.real, v.imag, 0.0, 0.0])

    def rotating(state):
        X, Y, U, V = state
        fixed = np.array([X, Y, U - omega * Y, V + omega * X])
        _, _, ax, ay = field(0.0, fixed, *place)
        # z'' = v'' + 2 i omega v' - omega**2 v
        return np.array(
            [U, V, ax + 2 * omega * V + omega**2 * X, ay - 2 * omega * U + omega**2 * Y]
        )

    assert np.abs(rotating(rest)).max() < 1e-11 * (1.0 + omega**2 * amplitude)
    step = 1e-6 * np.eye(4)
    return np.stack([(rotating(rest + h) - rotating(rest - h)) / 2e-6 for h in step], axis=1)


LAWS = (1.5, 1.0)


@pytest.mark.parametrize("exponent", LAWS)
def test_amplitudes_and_phases_hold_to_rounding_at_scattered_points(exponent):
    rng = np.random.default_rng(7)
    counts = set()
    for _ in range(60):
        omega = 10.0 ** rng.uniform(-1.0, 1.0)
        zeta = rng.choice([0.0, 1.0, 1.0]) * 10.0 ** rng.uniform(-4.0, 0.0)
        delta0 = rng.choice([0.0, 1.0, rng.uniform(0.1, 3.0), rng.uniform(0.1, 3.0)])
        kappa = rng.choice([omega**2, 10.0 ** rng.uniform(-6.0, 3.0), rng.uniform(0.0, 4.0)])
        counts.add(assert_matches_reference(omega, zeta, delta0, kappa, exponent))
    assert {1, 3} <= counts


@pytest.mark.parametrize(("exponent", "omega"), [(1.5, 1.3), (1.0, 1.05)])
def test_two_whirls_in_contact_stand_beside_the_contact_free_one(exponent, omega):
    # above the resonance of the shaft and below that of shaft and ring together
    assert assert_matches_reference(omega, 0.02, 1.6, 0.25, exponent) == 3
    whirls = one_point(omega, 0.02, 1.6, 0.25, exponent)
    assert whirls["in_contact"].tolist() == [0, 1, 1]
    assert whirls["stability"].tolist() == [STABILITY[w] for w in ("stable", "unstable", "stable")]


def linear_folds(zeta, delta0, kappa) -> list:
    """Speeds at which the quadratic in A has a double root: q (1 + kappa - q)**2 = ..."""
    z, d, k = mpmath.mpf(zeta), mpmath.mpf(delta0), mpmath.mpf(kappa)
    cubic = [1, 4 * z**2 - 2 * (1 + k), (1 + k) ** 2, -4 * z**2 * d**2]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        roots = mpmath.polyroots(cubic, maxsteps=500, extraprec=200)
    return [mpmath.sqrt(mpmath.re(r)) for r in roots if abs(mpmath.im(r)) < 1e-30]


@pytest.mark.parametrize("away", [1e-6, 1e-9, 1e-13])
def test_nearly_double_whirls_of_a_linear_ring_are_neither_lost_nor_invented(away):
    sizes = set()
    for zeta, delta0, kappa in itertools.product([0.01, 0.07], [0.5, 1.2], [0.0, 0.3, 2.0]):
        for fold in linear_folds(zeta, delta0, kappa):
            for omega in (float(fold * (1 - away)), float(fold * (1 + away))):
                # near a double root an amplitude moves by the square root of what q moves by
                sizes.add(assert_matches_reference(omega, zeta, delta0, kappa, 1.0, rounding=1e-13))
    assert sizes >= {1, 3}


@functools.cache
def changes_of(rotor) -> list:
    """Neighbouring speeds between which the number of whirls on a Hertz ring changes."""
    zeta, delta0, kappa = rotor
    speeds = np.linspace(0.3, 4.0, 400)
    whirls = synchronous_response(omega=speeds, zeta=zeta, delta0=delta0, shaft_stiffness=kappa)
    counts = np.isfinite(whirls["amplitude"].squeeze()).sum("branch").values
    found = []
    for k in np.flatnonzero(np.diff(counts)).tolist():
        low, high = speeds[k], speeds[k + 1]
        for _ in range(40):
            middle = 0.5 * (low + high)
            same = one_point(middle, *rotor, 1.5)["amplitude"].size == counts[k]
            low, high = (middle, high) if same else (low, middle)
        assert high - low < 1e-10
        found.append((low, high))
    return found


@pytest.mark.parametrize("away", [1e-6, 1e-9, 1e-13])
@pytest.mark.parametrize("kappa", [0.04, 0.25, 1.0])
def test_nearly_double_whirls_of_a_hertz_ring_are_neither_lost_nor_invented(kappa, away):
    rotor = (0.07, 0.5, kappa)
    assert changes_of(rotor)
    for low, high in changes_of(rotor):
        for omega in (low * (1.0 - away), high * (1.0 + away)):
            assert_matches_reference(omega, *rotor, 1.5, rounding=1e-13)


def test_whirl_at_the_free_resonance_of_the_shaft():
    for exponent in LAWS:
        assert_matches_reference(0.5, 0.07, 1.0, 0.25, exponent)
        assert_matches_reference(0.5, 0.0, 1.0, 0.25, exponent)
        # without damping the whirl that would be free grows without bound: it is in contact
        assert one_point(0.5, 0.0, 1.0, 0.25, exponent)["in_contact"].all()


def test_a_linear_ring_in_resonance_without_damping_has_no_whirl():
    # one double root of P at infinity: 1 + kappa = omega**2
    whirls = synchronous_response(
        omega=1.5, zeta=0.0, delta0=0.5, shaft_stiffness=1.25, contact_exponent=1.0
    )
    assert whirls.sizes["branch"] == 1
    assert (whirls.in_contact == 0).all()


@pytest.mark.parametrize("kappa", [0.0, 0.25, 3.0])
@pytest.mark.parametrize("exponent", LAWS)
@pytest.mark.parametrize("damping", [0.0, 0.3, 4.0])
def test_eigenvalues_are_those_of_the_numerically_differentiated_motion(kappa, exponent, damping):
    compared = 0
    for omega, zeta, delta0 in itertools.product([0.6, 1.3, 2.2], [0.07, 0.4], [0.5, 1.5]):
        place = (omega, zeta, delta0, kappa, exponent, damping)
        whirls = one_point(*place)
        for k in np.nonzero(whirls["in_contact"])[0]:
            amplitude, lag = whirls["amplitude"][k], whirls["phase_lag"][k]
            if amplitude - delta0 < 1e-3:
                continue  # too near the ring for differences
            matrix = jacobian(amplitude, lag, *place)
            found = eigenvalues(
                amplitude,
                omega=omega,
                zeta=zeta,
                delta0=delta0,
                shaft_stiffness=kappa,
                contact_exponent=exponent,
                contact_damping=damping,
            )
            size = np.linalg.norm(matrix)
            # differences are right to 1e-9, and the polynomial does not mind double roots
            np.testing.assert_allclose(
                np.poly(found).real, np.poly(matrix).real, rtol=0.0, atol=1e-7 * size**4
            )
            expected = np.linalg.eigvals(matrix).real.max()
            assert whirls["growth_rate"][k] == pytest.approx(expected, abs=3e-7 * size), place
            assert whirls["growth_rate"][k] == pytest.approx(found.real.max(), abs=1e-13 * size)
            assert whirls["stability"][k] == STABILITY["unstable" if expected > 0 else "stable"]
            determinant = stability_determinant(
                amplitude, omega=omega, zeta=zeta, delta0=delta0,
                shaft_stiffness=kappa, contact_exponent=exponent,
            )  # fmt: skip
            assert determinant == pytest.approx(np.linalg.det(matrix), abs=1e-7 * size**4)
            compared += 1
    assert compared >= 6


def test_contact_damping_leaves_the_whirls_where_they_are():
    for exponent in LAWS:
        plain = one_point(1.7, 0.07, 0.5, 0.1, exponent)
        damped = one_point(1.7, 0.07, 0.5, 0.1, exponent, 0.5)
        assert damped["amplitude"].tolist() == plain["amplitude"].tolist()
        assert damped["phase_lag"].tolist() == plain["phase_lag"].tolist()


@pytest.mark.parametrize(("damping", "word"), [(0.2, "stable"), (1.0, "unstable")])
def test_contact_damping_takes_the_small_whirl_its_stability(damping, word):
    """The lagging whirl against an integration: it decays or grows at the rate that is given."""
    place = (1.7, 0.07, 0.5, 0.0, 1.5, damping)
    whirls = one_point(*place)
    assert whirls["stability"][0] == STABILITY[word]
    amplitude, lag, rate = (whirls[name][0] for name in ("amplitude", "phase_lag", "growth_rate"))
    z = (amplitude + 1e-7) * np.exp(-1j * lag)
    v = 1j * place[0] * amplitude * np.exp(-1j * lag)
    times = np.linspace(60.0, 160.0, 10001)
    run = solve_ivp(
        field, (0.0, 160.0), [z.real, z.imag, v.real, v.imag],
        method="DOP853", t_eval=times, args=place, rtol=1e-12, atol=1e-14,
    )  # fmt: skip
    whirl = amplitude * np.exp(1j * (place[0] * times - lag))
    away = np.abs(run.y[0] + 1j * run.y[1] - whirl)
    # the largest distance over ten units of time, some turns of the mode
    early, late = (away[part].max() for part in (slice(0, 1000), slice(-1000, None)))
    assert np.log(late / early) / 90.0 == pytest.approx(rate, rel=0.02)
    assert late < 1e-2


@pytest.mark.parametrize("zeta", [0.02, 0.07, 0.9])
@pytest.mark.parametrize("kappa", [1e-4, 0.25, 2.0])
def test_a_shaft_holds_the_contact_free_whirl(zeta, kappa):
    whirls = one_point(5.0, zeta, 3.0, kappa, 1.5)
    assert whirls["in_contact"].tolist()[0] == 0
    assert whirls["stability"][0] == STABILITY["stable"]
    # z'' + 2 zeta z' + kappa z = 0 about the whirl, in the fixed frame
    expected = np.roots([1.0, 2.0 * zeta, kappa]).real.max()
    assert whirls["growth_rate"][0] == pytest.approx(expected, rel=1e-8)


def test_a_contact_free_whirl_is_neutral_without_damping_or_without_a_shaft():
    whirls = synchronous_response(
        omega=5.0, zeta=[0.0, 0.1], delta0=3.0, shaft_stiffness=[0.0, 0.5]
    ).isel(branch=0)
    expected = [[STABILITY["neutral"]] * 2, [STABILITY["neutral"], STABILITY["stable"]]]
    assert whirls.stability.values.squeeze().tolist() == expected


def test_a_rotor_at_rest_is_held_by_its_shaft_or_by_a_linear_ring_without_clearance():
    for kappa, exponent, delta0, word in [
        (0.0, 1.5, 0.0, "neutral"), (0.0, 1.0, 0.0, "stable"), (0.0, 1.0, 1.0, "neutral"),
        (0.3, 1.5, 0.0, "stable"), (0.3, 1.0, 1.0, "stable"),
    ]:  # fmt: skip
        whirls = one_point(0.0, 0.1, delta0, kappa, exponent)
        assert whirls["amplitude"].tolist() == [0.0]
        assert whirls["phase_lag"].tolist() == [0.0]
        assert whirls["stability"].tolist() == [STABILITY[word]]


def test_what_is_default_is_no_coordinate():
    plain = synchronous_response(omega=1.7, zeta=0.07, delta0=[0.5, 1.0])
    same = synchronous_response(
        omega=1.7, zeta=0.07, delta0=[0.5, 1.0],
        shaft_stiffness=0, contact_exponent=np.array(1.5), contact_damping=0.0,
    )  # fmt: skip
    assert same.identical(plain)
    stiff = synchronous_response(omega=1.7, zeta=0.07, delta0=[0.5, 1.0], shaft_stiffness=0.25)
    assert stiff.amplitude.dims == plain.amplitude.dims
    assert stiff.shaft_stiffness.item() == 0.25
    assert "contact_damping" not in stiff.coords


def test_axes_hold_what_single_numbers_give():
    axes = {
        "shaft_stiffness": [0.0, 0.3],
        "contact_exponent": [1.0, 1.5],
        "contact_damping": [0, 2],
    }
    grid = synchronous_response(omega=[0.9, 1.7], zeta=0.07, delta0=[0.5, 1.0], **axes)
    dims = ("omega", "zeta", "delta0", *axes, "branch")
    assert grid.amplitude.dims == dims
    for omega, delta0, kappa, exponent, damping in itertools.product(
        [0.9, 1.7], [0.5, 1.0], *axes.values()
    ):
        point = grid.sel(
            omega=omega, zeta=0.07, delta0=delta0, shaft_stiffness=kappa,
            contact_exponent=exponent, contact_damping=damping,
        )  # fmt: skip
        alone = one_point(omega, 0.07, delta0, kappa, exponent, damping)
        for name, values in alone.items():
            found = point[name].values
            np.testing.assert_allclose(found[: values.size], values, rtol=1e-13)
        assert np.isnan(point.amplitude.values[alone["amplitude"].size :]).all()


def test_axes_at_the_defaults_give_the_whirls_of_the_plain_rotor():
    place = {"omega": np.linspace(0.2, 3.0, 29), "zeta": [0.0, 0.07], "delta0": [0.0, 0.5, 2.0]}
    plain = synchronous_response(**place)
    axis = synchronous_response(**place, shaft_stiffness=[0.0]).isel(shaft_stiffness=0)
    np.testing.assert_allclose(axis.amplitude, plain.amplitude, rtol=1e-15)
    np.testing.assert_array_equal(axis.stability, plain.stability)
    np.testing.assert_allclose(axis.growth_rate, plain.growth_rate, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("exponent", LAWS)
def test_extreme_parameters_give_whirls_without_a_warning(exponent):
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


@pytest.mark.parametrize(
    ("given_values", "message"),
    [
        ({"shaft_stiffness": -1.0}, "shaft_stiffness must be zero or positive, got -1.0"),
        ({"shaft_stiffness": [0.1, np.nan]}, "shaft_stiffness must be a finite real number"),
        ({"contact_exponent": 2.0}, "contact_exponent must be 1.5 or 1, got 2.0"),
        ({"contact_damping": 1e16}, "contact_damping must .* 1e\\+15.*, got 1e\\+16"),
        (
            {"contact_damping": 0.1, "delta0": [0.0, 1.0]},
            "contact_damping must be 0 without clearance, .* got 0.1 with delta0 0.0",
        ),
    ],
)
def test_parameters_out_of_range_are_refused(given_values, message):
    place = {"omega": 1.0, "zeta": 0.1, "delta0": 0.5}
    with pytest.raises(InputError, match=message):
        synchronous_response(**{**place, **given_values})
    with pytest.raises(InputError, match=message):
        eigenvalues(2.0, **{**place, **given_values})
