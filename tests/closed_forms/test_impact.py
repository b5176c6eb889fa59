"""Radial impacts against Lambert's function with 60 digits, and against an integration."""

from __future__ import annotations

import mpmath
import numpy as np

from rotor_ida import impact


def reference(x: float) -> mpmath.mpf:
    """``1 - e x = -W(-exp(-1 - phi))`` with ``phi = x - ln(1 + x)``."""
    with mpmath.workdps(80):
        product = mpmath.mpf(x)
        phi = product - mpmath.log(1 + product)
        rest = -mpmath.lambertw(-mpmath.exp(-1 - phi)) if phi < 150 else mpmath.mpf(0)
        return (1 - mpmath.re(rest)) / product


def test_restitution_holds_to_rounding_from_1e_12_to_1e_6():
    products = np.concatenate([np.geomspace(1e-12, 1e6, 200), [0.999, 1.0, 1.001, 29.9, 30.1]])
    found = impact(entry_speed=products, contact_damping=1.0).restitution.values.ravel()
    for x, e in zip(products, found, strict=True):
        assert abs(e / reference(float(x)) - 1) < 1e-15, x


def test_peak_indentation_holds_to_rounding_for_every_product():
    speeds, dampings = [1e-6, 0.3, 7.0], [0.0, 1e-12, 1e-7, 1e-3, 1.0, 50.0]
    found = impact(entry_speed=speeds, contact_damping=dampings, contact_exponent=[1.5, 1.0])
    for place in np.ndindex(found.peak_indentation.shape):
        here = found.isel(dict(zip(found.peak_indentation.dims, place, strict=True)))
        with mpmath.workdps(80):
            v, c, n = (mpmath.mpf(here[name].item()) for name in found.peak_indentation.dims)
            half = (c * v - mpmath.log(1 + c * v)) / c**2 if c else v**2 / 2
            expected = ((n + 1) * half) ** (1 / (n + 1))
            assert abs(here.peak_indentation.item() / expected - 1) < 2e-15, place


def test_extreme_impacts_raise_no_warning():
    found = impact(entry_speed=[0.0, 1e-100, 1e15], contact_damping=[0.0, 1e-100, 1e15])
    assert ((found.restitution > 0.0) & (found.restitution <= 1.0)).all()
    assert (np.isfinite(found.peak_indentation)).all()
