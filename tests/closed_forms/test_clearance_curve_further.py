"""The curve over the clearance with a shaft, either contact law and contact damping."""

from __future__ import annotations

import numpy as np
import pytest

from rotor_ida import InputError, synchronous_response
from rotor_ida.closed_forms import clearance_curve

LIMITS = (0.1, 4.0)
NAMES = ("omega", "zeta", "shaft_stiffness", "contact_exponent", "contact_damping")
ROTORS = [
    (1.7, 0.07, 0.25, 1.5, 0.0),
    (0.4, 0.07, 0.25, 1.5, 0.0),
    (0.5, 0.07, 0.25, 1.5, 0.0),
    (1.0, 0.07, 0.25, 1.0, 0.0),
    (0.4, 0.07, 0.25, 1.0, 0.0),
    (1.4, 0.1, 0.25, 1.0, 0.0),
    (1.7, 0.07, 0.0, 1.5, 0.7),
    (1.3, 0.02, 1.0, 1.5, 0.0),
    (1.7, 0.0, 0.25, 1.5, 0.0),
]


@pytest.mark.parametrize("rotor", ROTORS)
def test_points_are_whirls_and_each_whirl_is_passed_once(rotor):
    parameters = dict(zip(NAMES, rotor, strict=True))
    omega, zeta, kappa, exponent, _ = rotor
    curve = clearance_curve(**parameters, limits=LIMITS)
    chosen = np.flatnonzero(curve.piece.values.ravel() >= 0)
    d, A, lag, flags, touches, piece = (
        curve[name].values.ravel()[chosen]
        for name in ("delta0", "amplitude", "phase_lag", "stability", "in_contact", "piece")
    )
    q = omega**2
    force = np.where(touches == 1, np.maximum(A - d, 0.0) ** exponent, 0.0)
    impedance = force + (kappa - q) * A + 2j * zeta * omega * A
    size = force + (kappa + q) * A + q
    # what rounding of A and d makes of the force
    slack = 1e-14 * (size + 1.5 * np.maximum(A - d, 0.0) ** (exponent - 1.0) * (A + d))
    assert (np.abs(np.abs(impedance) - q) <= slack).all()
    assert (np.abs(impedance * np.exp(-1j * lag) - q) <= 10.0 * slack).all()

    for delta0 in np.random.default_rng(2).uniform(*LIMITS, 30):
        whirls = synchronous_response(delta0=delta0, **parameters)
        present = np.isfinite(whirls.amplitude.values.ravel())
        passes = ((d[:-1] - delta0) * (d[1:] - delta0) < 0.0) & (np.diff(piece) == 0)
        k = np.flatnonzero(passes)
        part = (delta0 - d[k]) / (d[k + 1] - d[k])
        order = np.argsort(A[k] + part * np.diff(A)[k])
        expected = whirls.amplitude.values.ravel()[present]
        assert k.size == expected.size, (rotor, delta0)
        np.testing.assert_allclose((A[k] + part * np.diff(A)[k])[order], expected, rtol=2e-2)
        same = (flags[k] == flags[k + 1])[order]
        found = whirls.stability.values.ravel()[present]
        assert (flags[k][order] == found)[same].all(), (rotor, delta0)


def test_a_linear_contact_without_damping_is_refused():
    with pytest.raises(InputError, match="zeta must be positive for the curve of a linear contact"):
        clearance_curve(omega=1.0, zeta=0.0, limits=LIMITS, contact_exponent=1.0)
    with pytest.raises(InputError, match="contact_damping must be 0 without clearance"):
        clearance_curve(omega=1.0, zeta=0.1, limits=(0.0, 1.0), contact_damping=1.0)
