"""Touches that fade: what is taken for such a motion is one, and what leaves the ring is not."""

import cmath
import math

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.basins.known import MOST_DRIFT, contact_free_whirls
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import follow_to_steady_state

GO_ON = np.zeros(1, np.uint8)
ROTORS = [
    Rotor(omega=2.0, zeta=0.07, delta0=2.0),
    Rotor(omega=0.5, zeta=0.07, delta0=2.0),
    Rotor(omega=1.0, zeta=1.0, delta0=3.0),
]


@pytest.mark.parametrize("rotor", ROTORS)
def test_motions_from_the_rim_touch_for_ever(rotor):
    """By CVODE, from other states than those by which the excess was found."""
    found = contact_free_whirls(rotor, GO_ON, fading=True)
    whirl, room, excess = found.whirl, found.room, found.excess
    assert excess > 0.0
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
    assert contact_free_whirls(Rotor(omega=1.7, zeta=0.07, delta0=0.5), GO_ON, fading=True) is None
    for omega, zeta in ((0.0, 0.1), (1.0, 1e-8)):
        rotor = Rotor(omega=omega, zeta=zeta, delta0=2.0)
        found = contact_free_whirls(rotor, GO_ON, fading=True)
        assert found.excess == 0.0
        assert found.row["room"] > 0.0 > found.row["fading"]
