"""Hopf points of synchronous whirls against eigenvalues, dense curves and simulated cycles."""

import math
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import mpmath
import numpy as np
import pytest

from rotor_ida import hopf_points, synchronous_response
from rotor_ida.closed_forms import cusp_zeta, eigenvalues, jumps, peaks
from rotor_ida.closed_forms.exact_polynomials import Polynomial, isolated_roots
from tests.closed_forms.scanning import scanned

OSCILLATING = [
    {"zeta": 0.07, "delta0": 0.5, "contact_damping": 0.5},
    {"zeta": 0.05, "delta0": 0.75, "contact_damping": 0.5, "shaft_stiffness": 1.0},
    {"zeta": 0.05, "delta0": 0.75, "contact_damping": 0.1, "shaft_stiffness": 0.1,
     "contact_exponent": 1.0},
    {"zeta": 0.02, "delta0": 1.0, "contact_damping": 2.0, "contact_exponent": 1.0},
    {"zeta": 0.003, "delta0": 3.0, "contact_damping": 0.2, "shaft_stiffness": 0.25},
    {"zeta": 0.07, "delta0": 0.5, "friction": 0.1},
    {"zeta": 0.02, "delta0": 1.0, "friction": 0.05, "shaft_stiffness": 0.2},
    {"zeta": 0.05, "delta0": 1.2, "friction": 0.2, "contact_exponent": 1.0,
     "shaft_stiffness": 0.25},
    {"zeta": 0.07, "delta0": 0.5, "friction": 0.02, "contact_damping": 0.3},
    {"zeta": 0.0, "delta0": 0.7, "friction": 0.1, "contact_damping": 0.5},
]  # fmt: skip


def points_of(machine):
    found = hopf_points(**machine)
    names = ("hopf_omega", "hopf_amplitude", "hopf_frequency")
    rows = np.stack([found[name].values.ravel() for name in names], axis=1)
    return rows[np.isfinite(rows).all(axis=1)]


def test_without_damping_of_one_kind_or_the_other_there_is_none():
    for given in ({"zeta": 0.07}, {"zeta": 0.0, "contact_damping": 1.0}):
        assert np.isnan(hopf_points(delta0=0.5, **given).hopf_omega).all()


@pytest.mark.parametrize(
    ("exponent", "delta0"), [(1.5, 0.99), (1.5, 1.0 - 1e-7), (1.0, 1.0 - 1e-9)]
)
def test_a_far_one_of_a_clearance_hardly_below_one_is_as_exact(exponent, delta0):
    """By 60 digits the Hurwitz determinant of the whirl changes its sign at that very speed."""
    machine = {"zeta": 0.07, "delta0": delta0, "contact_damping": 0.2, "contact_exponent": exponent}
    speed = points_of(machine)[-1, 0]
    assert speed > 300.0
    with mpmath.workdps(60):
        zeta, d, c = (mpmath.mpf(machine[name]) for name in ("zeta", "delta0", "contact_damping"))

        def hurwitz(omega):
            q, A = omega**2, mpmath.mpf(1)
            for _ in range(60):  # so fast a whirl has nearly amplitude 1, whatever the ring does
                depth = A - d
                f, K = depth**exponent, exponent * depth ** (exponent - 1.0)
                A = q / mpmath.sqrt((f / A - q) ** 2 + 4 * zeta**2 * q)
            S, m = f / A, 2 * zeta + c * f
            a3, a2 = m + 2 * zeta, K + S + 2 * zeta * m + 2 * q
            a1 = m * S + 2 * zeta * K + (6 * zeta - m) * q
            return a3 * a2 * a1 - a1**2 - a3**2 * ((K - q) * (S - q) + 4 * zeta**2 * q)

        slightly = mpmath.mpf("1e-14")
        assert hurwitz(speed * (1 - slightly)) * hurwitz(speed * (1 + slightly)) < 0


@pytest.mark.parametrize(
    ("delta0", "kappa", "mu", "zeta", "c"),
    [(1e-3, 0.2, 1e-5, 0.0, 1.8), (8000.0, 0.0, 6e-6, 4e-6, 0.6), (1.4, 257.0, 0.4, 0.0, 1.7)],
)
def test_a_small_frequency_has_all_its_digits(delta0, kappa, mu, zeta, c):
    """Compare with Newton's method in 60 digits, on a linear contact with friction."""
    d, kappa_, mu_, z, c_ = map(mpmath.mpf, (delta0, kappa, mu, zeta, c))

    def remainders(A, w, frequency):
        f, L = A - d, 1j * frequency
        held = A * (kappa_ - w**2 + 2j * z * w) + f * (1 + 1j * mu_)
        along = L**2 + 2 * z * L + kappa_ - w**2 + 1 + c_ * f * L
        across = L**2 + 2 * z * L + kappa_ - w**2 + f / A
        turned = 2 * w * L + 2 * z * w
        determinant = along * across + (turned + mu_ * f / A) * (turned + mu_ + mu_ * c_ * f * L)
        return abs(held) ** 2 / w**4 - 1, determinant.real, determinant.imag

    machine = {"delta0": delta0, "zeta": zeta, "friction": mu, "contact_damping": c}
    points = points_of(machine | {"shaft_stiffness": kappa, "contact_exponent": 1.0})
    assert len(points) > 0
    with mpmath.workdps(60):
        for omega, amplitude, frequency in points:
            start = (amplitude, omega, frequency)
            exact = mpmath.findroot(remainders, start, tol=1e-45, maxsteps=60)
            for value, expected in zip(start, exact, strict=True):
                assert abs(value / expected - 1) < 3e-16


def test_roots_are_isolated_in_exact_arithmetic():
    """Two roots 1e-12 apart, one that is far away, and a pair that misses the axis by 1e-12."""
    near, tiny = Fraction(1, 3), Fraction(1, 10**12)
    roots = (near, near + tiny, Fraction(10**6), Fraction(-2))
    much = 10**24
    product = Polynomial((1 + much, -2 * much, much))  # (x - 1)^2 + 1e-24
    for root in roots:
        product = product * Polynomial((-root.numerator, root.denominator))
    found = [root.narrowed(70)[0] for root in isolated_roots(product.whole)]
    assert [abs(one - two) < tiny / 10**6 for one, two in zip(found, roots[:3], strict=True)]
    assert all(abs(one - two) <= two / 2**60 for one, two in zip(found, roots[:3], strict=True))


def test_a_multiple_root_is_found_once():
    """Orders 3, 2 and 2, the last at a place where an interval is halved, beside simple roots."""
    roots = (Fraction(1, 3),) * 3 + (Fraction(2, 7),) * 2 + (Fraction(1, 2),) * 2 + (Fraction(5),)
    product = Polynomial((1, 0, 1))  # no real root
    for root in (*roots, Fraction(-3), Fraction(0)):
        product = product * Polynomial((-root.numerator, root.denominator))
    found = [root.narrowed(70)[0] for root in isolated_roots(product.whole)]
    assert len(found) == 4
    pairs = zip(found, sorted(set(roots)), strict=True)
    assert all(abs(one - two) <= two / 2**60 for one, two in pairs)


def hurwitz(A, omega, machine):
    """a3 a2 a1 - a1**2 - a3**2 a0, from the sums of products of the eigenvalues."""
    inside = np.where(np.isfinite(omega), omega, 0.0)
    x = eigenvalues(A, omega=inside, **machine)
    pairs = [x[:, i] + x[:, j] for i in range(4) for j in range(i)]
    # the product of all sums of two eigenvalues is, up to a positive factor, minus that
    return np.where(np.isfinite(omega), np.prod(pairs, axis=0).real, np.nan)


@pytest.mark.parametrize("machine", OSCILLATING)
def test_a_pair_of_eigenvalues_is_imaginary(machine):
    there = points_of(machine)
    assert len(there) > 0 or machine["delta0"] == 3.0
    for omega, amplitude, frequency in there:
        found = eigenvalues(amplitude, omega=omega, **machine)
        assert np.abs(found - 1j * frequency).min() < 1e-12 * max(1.0, frequency)
        here = synchronous_response(omega=omega, **machine).amplitude
        assert np.abs(here / amplitude - 1.0).min() < 1e-13


@pytest.mark.parametrize("machine", OSCILLATING)
def test_none_is_lost_and_none_invented(machine):
    found = points_of(machine)[:, 1]

    def oscillates(A, omega, machine):
        """That determinant, but for neutral saddles: two real eigenvalues that add up to 0."""
        value = hurwitz(A, omega, machine)
        x = eigenvalues(A, omega=np.where(np.isfinite(omega), omega, 0.0), **machine)
        spread = np.abs(x[:, :, None] + x[:, None, :])
        spread[:, range(4), range(4)] = np.inf
        pair = spread.reshape(-1, 16).argmin(axis=1) // 4
        real = np.abs(x[range(len(x)), pair].imag) < 1e-9 * np.abs(x).max(axis=1)
        return np.where(real, np.nan, value)

    expected = scanned(machine, oscillates)
    inside = np.sort(found[found < 40.0])
    np.testing.assert_allclose(inside, expected, rtol=0.0, atol=2e-4)


def test_the_table_of_the_documentation():
    """docs/whirls.md: how friction moves the boundaries of the paper's Figs 6 and 10."""
    page = (Path(__file__).parents[2] / "docs" / "whirls.md").read_text()
    lines = [line.split("|")[1:-1] for line in page.splitlines() if line.startswith("| 0")]
    assert len(lines) == 5
    for friction, fold, landing, peak, hopf, limit in lines:
        given = {"zeta": 0.07, "delta0": 0.5, "friction": float(friction)}
        found = jumps(**given)
        large = found.fold_omega.values.ravel() > 1.0
        speeds, landings = (
            found[name].values.ravel()[large] for name in ("fold_omega", "landing_amplitude")
        )
        assert fold.strip() == (", ".join(f"{each:.5f}" for each in speeds) or "none")
        words = ["none" if np.isnan(each) else f"{each:.3f}" for each in landings]
        assert landing.strip() == ", ".join(words)
        top = peaks(**given)
        assert peak.strip() == f"{top.peak_amplitude.item():.3f} at {top.peak_omega.item():.4f}"
        first = np.nanmin(np.append(hopf_points(**given).hopf_omega, np.inf))
        assert hopf.strip() == (f"{first:.5f}" if np.isfinite(first) else "none")
        assert limit.strip() == f"{cusp_zeta(0.5, friction=float(friction)):.5f}"


def test_rub_loses_its_stability_to_a_backward_whirl_of_the_natural_frequency():
    """On fixed axes the mode that grows at a Hopf point turns backwards.

    Its speed is that of the rotor on shaft and ring, which gives way with the mean s of its
    stiffnesses along and across the radius, and there mu s is 2 zeta times that speed. Both hold
    the better, the less friction exceeds what would drive the rotor in a ring without clearance.
    """
    zeta, kappa, delta0 = 0.005, 0.04, 1.5
    bound = 2.0 * zeta * math.sqrt(kappa + 1.0)
    off = []
    for excess in (0.2, 0.1, 0.05):
        mu = (1.0 + excess) * bound
        found = hopf_points(
            zeta=zeta, delta0=delta0, shaft_stiffness=kappa, contact_exponent=1.0, friction=mu
        )
        omega, amplitude, frequency = (
            found[f"hopf_{name}"].values.ravel() for name in ("omega", "amplitude", "frequency")
        )
        assert np.isfinite(omega).sum() == 2
        whirl = omega - frequency
        mean = 1.0 - 0.5 * delta0 / amplitude
        assert (whirl < 0.0).all()
        np.testing.assert_allclose(2.0 * zeta * -whirl / (mu * mean), 1.0, atol=0.5 * excess**2)
        off.append(float(np.abs(-whirl / np.sqrt(kappa + mean) - 1.0).max()))
    assert off[0] < 0.012
    for coarse, fine in pairwise(off):
        assert 0.2 < fine / coarse < 0.3
