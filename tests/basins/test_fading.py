"""Touches that fade: what is taken for such a motion is one, and what leaves the ring is not."""

import cmath
import math

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.basins.fading import MOST_DRIFT, fading_excess
from rotor_ida.basins.known import known_from_closed_forms
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.simulation.options import Options
from rotor_ida.steady_state.follow import follow_to_steady_state

GO_ON = np.zeros(1, np.uint8)
ROTORS = [
    Rotor(omega=2.0, zeta=0.07, delta0=2.0),
    Rotor(omega=0.5, zeta=0.07, delta0=2.0),
    Rotor(omega=1.0, zeta=1.0, delta0=3.0),
]


@pytest.mark.parametrize("rotor", ROTORS)
def test_motions_from_the_rim_touch_for_ever(rotor):
    """By CVODE, from other states than those by which the excess was found."""
    excess = fading_excess(rotor, GO_ON)
    assert excess > 0.0
    whirl = complex(complex_amplitude(rotor.omega, rotor.zeta))
    room = rotor.delta0 - abs(whirl)
    for angle in (0.3, 2.0, 4.4):
        end = cmath.rect(room + excess, angle)
        drift = cmath.rect(0.99 * MOST_DRIFT * excess, angle + 0.5 * math.pi)
        position = end - drift + whirl
        velocity = 1j * rotor.omega * whirl + 2.0 * rotor.zeta * drift
        start = (position.real, position.imag, velocity.real, velocity.imag)
        settled = follow_to_steady_state(rotor, start, Options(rtol=1e-10))
        assert settled.response == "touching"
        assert settled.features.radius_max == pytest.approx(rotor.delta0, abs=excess)


def test_there_is_none_where_nothing_turns_or_fits_or_a_drift_takes_too_long():
    assert math.isnan(fading_excess(Rotor(omega=0.0, zeta=0.1, delta0=2.0), GO_ON))
    assert math.isnan(fading_excess(Rotor(omega=1.7, zeta=0.07, delta0=0.5), GO_ON))
    known = known_from_closed_forms(Rotor(omega=0.0, zeta=0.1, delta0=2.0), GO_ON)
    assert known.free[2] > 0.0 > known.free[3]
    assert fading_excess(Rotor(omega=1.0, zeta=1e-8, delta0=2.0), GO_ON) == 0.0
