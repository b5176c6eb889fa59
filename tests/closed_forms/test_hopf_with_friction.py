"""Hopf points with friction, each found by a second way."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from rotor_ida.closed_forms import (
    cusp_zeta,
    eigenvalues,
    folds,
    hopf_points,
    jumps,
    peaks,
    synchronous_response,
)
from rotor_ida.errors import InputError

OSCILLATING = [
    {"zeta": 0.07, "delta0": 0.5, "friction": 0.1},
    {"zeta": 0.02, "delta0": 1.0, "friction": 0.05, "shaft_stiffness": 0.2},
    {"zeta": 0.05, "delta0": 1.2, "friction": 0.2, "contact_exponent": 1.0,
     "shaft_stiffness": 0.25},
    {"zeta": 0.07, "delta0": 0.5, "friction": 0.02, "contact_damping": 0.3},
    {"zeta": 0.0, "delta0": 0.7, "friction": 0.1, "contact_damping": 0.5},
]  # fmt: skip


def points(found, *names):
    rows = np.stack([found[name].values.ravel() for name in names], axis=1)
    return rows[np.isfinite(rows).all(axis=1)]


def scanned(machine, condition, nodes=60_000):
    """Amplitudes at which a condition changes sign along either flank, by roots of the quartic.

    The speeds at each amplitude are eigenvalues of a companion matrix: no part of the package.
    """
    zeta, d, mu = (machine[name] for name in ("zeta", "delta0", "friction"))
    kappa, n = machine.get("shaft_stiffness", 0.0), machine.get("contact_exponent", 1.5)
    depth = np.concatenate([np.geomspace(1e-9, 1e-2, nodes // 4), np.linspace(1e-2, 40.0, nodes)])
    A, f = d + depth, depth**n
    g = f + kappa * A
    scale = np.sqrt(g / A)
    quartic = np.stack([
        (g * g + (mu * f) ** 2) / scale**4,
        4.0 * mu * zeta * A * f / scale**3,
        A * (4.0 * zeta**2 * A - 2.0 * g) / scale**2,
        0.0 * A,
    ])  # fmt: skip
    companion = np.zeros((A.size, 4, 4))
    companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
    companion[:, :, 3] = -(quartic / (A * A - 1.0)).T
    roots = np.linalg.eigvals(companion) * scale[:, None]
    real = (np.abs(roots.imag) < 1e-9 * np.abs(roots)) & (roots.real > 0.0)
    speeds = np.sort(np.where(real, roots.real, np.nan), axis=1)[:, :2]
    changes = []
    for w in speeds.T:
        value = condition(A, w, machine)
        near = np.isfinite(value[1:] * value[:-1]) & (np.abs(np.diff(w)) < 0.1 * w[1:])
        changes += A[1:][near & (value[1:] * value[:-1] < 0.0)].tolist()
    return np.sort(changes)


def hurwitz(A, omega, machine):
    """a3 a2 a1 - a1**2 - a3**2 a0, from the sums of products of the eigenvalues."""
    inside = np.where(np.isfinite(omega), omega, 0.0)
    x = eigenvalues(A, omega=inside, **machine)
    pairs = [x[:, i] + x[:, j] for i in range(4) for j in range(i)]
    # the product of all sums of two eigenvalues is, up to a positive factor, minus that
    return np.where(np.isfinite(omega), np.prod(pairs, axis=0).real, np.nan)


@pytest.mark.parametrize("machine", OSCILLATING)
def test_a_pair_of_eigenvalues_is_imaginary_at_a_hopf_point(machine):
    names = ("hopf_omega", "hopf_amplitude", "hopf_frequency")
    there = points(hopf_points(**machine), *names)
    assert len(there) > 0
    for omega, amplitude, frequency in there:
        found = eigenvalues(amplitude, omega=omega, **machine)
        assert np.abs(found - 1j * frequency).min() < 1e-12 * max(1.0, frequency)
        here = synchronous_response(omega=omega, **machine).amplitude
        assert np.abs(here / amplitude - 1.0).min() < 1e-13


@pytest.mark.parametrize("machine", OSCILLATING)
def test_no_hopf_point_is_lost_and_none_invented(machine):
    found = points(hopf_points(**machine), "hopf_amplitude")[:, 0]

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
    np.testing.assert_allclose(inside, expected, rtol=0.0, atol=1.5e-3)


def test_the_stated_condition_of_a_hopf_point():
    """Without contact damping: 4 zeta a2 a1 = a1**2 + 16 zeta**2 D, solved along the curve."""
    zeta, d, mu = 0.07, 0.5, 0.1

    def condition(omega):
        here = synchronous_response(omega=omega, zeta=zeta, delta0=d, friction=mu)
        A = here.amplitude.values.ravel()[0]
        f = (A - d) ** 1.5
        a, b = 1.5 * math.sqrt(A - d) - omega**2, f / A - omega**2
        c_u, c_v = 2 * zeta * omega + 1.5 * mu * math.sqrt(A - d), 2 * zeta * omega + mu * f / A
        a2 = 4 * zeta**2 + a + b + 4 * omega**2
        a1 = 2 * zeta * (a + b) + 2 * omega * (c_u + c_v)
        return a1**2 + 16 * zeta**2 * (a * b + c_u * c_v) - 4 * zeta * a2 * a1

    begin = brentq(condition, 1.0, 1.2, xtol=1e-15, rtol=1e-15)
    first = hopf_points(zeta=zeta, delta0=d, friction=mu).hopf_omega.values.ravel()[0]
    assert first == pytest.approx(begin, rel=1e-12)


def test_axes_of_friction_are_dimensions_in_their_order():
    given = {
        "zeta": 0.07,
        "delta0": [0.5, 1.0],
        "contact_damping": [0.0, 0.1],
        "friction": [0.0, 0.1],
    }
    for found, last in ((folds(**given), "fold"), (hopf_points(**given), "hopf")):
        name = f"{last}_omega"
        assert found[name].dims == ("zeta", "delta0", "contact_damping", "friction", last)
    alone = folds(zeta=0.07, delta0=1.0, friction=0.1).fold_omega.values.ravel()
    beside = folds(**given).fold_omega.sel(delta0=1.0, contact_damping=0.1, friction=0.1)
    np.testing.assert_array_equal(beside.values.ravel()[: alone.size], alone)
    without = folds(zeta=0.07, delta0=0.5).fold_omega.values.ravel()
    smooth = folds(**given).fold_omega.sel(delta0=0.5, contact_damping=0.0, friction=0.0)
    np.testing.assert_array_equal(smooth.values.ravel()[: without.size], without)


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


@pytest.mark.parametrize("function", [hopf_points])
@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"friction": -0.1}, "friction must be zero or positive, got -0.1"),
        ({"friction": 1e9}, "friction must be 0 or between 1e-20 and 1e"),
        ({"delta0": 0.0}, "friction must be 0 without clearance"),
    ],
)
def test_odd_values_are_refused(function, given, says):
    with pytest.raises(InputError, match=says):
        function(**({"zeta": 0.07, "delta0": 0.5, "friction": 0.1} | given))


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
