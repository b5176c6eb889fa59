"""Peaks: on the dense curve, and falling with the clearance."""

import numpy as np
import pytest

from rotor_ida import InputError, synchronous_response
from rotor_ida.closed_forms import peaks
from rotor_ida.equations.contact import contact_force


@pytest.mark.parametrize("delta0", [0.0, 0.5, 2.0])
def test_peak_lies_on_the_curve_and_nothing_is_higher(delta0):
    found = peaks(zeta=0.07, delta0=delta0)
    omega, A = found.peak_omega.item(), found.peak_amplitude.item()
    here = synchronous_response(omega=omega, zeta=0.07, delta0=delta0)
    # near the tip the amplitude goes like the root of the speed
    assert float(abs(here.amplitude / A - 1.0).min()) < 1e-6
    around = omega * (1.0 + np.linspace(-0.01, 0.01, 2001))
    beside = synchronous_response(omega=around, zeta=0.07, delta0=delta0)
    assert float(beside.amplitude.max()) <= A * (1.0 + 1e-12)


def test_clearance_lowers_peak_speed_and_force():
    found = peaks(zeta=0.07, delta0=np.linspace(0.0, 3.0, 31)).squeeze()
    for name in ("peak_amplitude", "peak_omega", "peak_contact_force"):
        assert (np.diff(found[name].values) < 0.0).all()


def test_force_is_that_of_the_contact_law():
    found = peaks(zeta=0.07, delta0=0.5)
    force = contact_force(found.peak_amplitude.values, 0.5)
    np.testing.assert_allclose(found.peak_contact_force.values, force)


def test_no_peak_with_strong_damping():
    assert np.isnan(peaks(zeta=1.0, delta0=0.0).peak_omega.item())
    with pytest.raises(InputError, match="zeta must be positive"):
        peaks(zeta=0.0, delta0=0.0)
