"""Points of a response curve with friction by a scan along its flanks."""

from __future__ import annotations

import numpy as np


def scanned(rotor, condition, nodes=10_000):
    """Amplitudes at which a condition changes sign along either flank, by roots of the quartic.

    The speeds at each amplitude are eigenvalues of a companion matrix: no part of the package.
    """
    zeta, d, mu = rotor["zeta"], rotor["delta0"], rotor.get("friction", 0.0)
    kappa, n = rotor.get("shaft_stiffness", 0.0), rotor.get("contact_exponent", 1.5)
    depth = np.concatenate([np.geomspace(1e-9, 1e-2, nodes // 4), np.linspace(1e-2, 40.0, nodes)])
    beside = np.geomspace(1e-7, 0.1, nodes // 8)  # of amplitude 1, where one flank is the fastest
    depth = np.unique(np.concatenate([depth, 1.0 - d - beside, 1.0 - d + beside]))
    depth = depth[depth > 0.0]
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
        value = condition(A, w, rotor)
        near = np.isfinite(value[1:] * value[:-1]) & (np.abs(np.diff(w)) < 0.1 * w[1:])
        here = np.flatnonzero(near & (value[1:] * value[:-1] < 0.0))
        part = value[here] / (value[here] - value[here + 1])
        changes += (A[here] + part * (A[here + 1] - A[here])).tolist()
    return np.sort(changes)
