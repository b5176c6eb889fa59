"""What parameters add over a stretch, against differences of whole stretches."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.core.interface import DONE
from rotor_ida.core.runs import Asked, follow

START = (1.2, 0.3, -0.2, 0.9)
CONTACT = Rotor(omega=1.2, zeta=0.07, delta0=0.5)
FREE = Rotor(omega=1.2, zeta=0.07, delta0=0.0)
FLIGHT = Rotor(omega=1.2, zeta=0.07, delta0=9.0)


def followed(rotor, duration, bundle=None):
    asked = Asked(
        rotor=rotor, start=START, duration=duration, rtol=1e-15, atol=1e-17, bundle=bundle
    )
    seen = follow(asked)
    assert seen.status == DONE
    return np.array(seen.state)


@pytest.mark.parametrize("duration", [0.05, 0.4])
@pytest.mark.parametrize("rotor", [CONTACT, FREE, FLIGHT], ids=["contact", "free", "flight"])
def test_parameters_add_the_differences_of_neighbouring_rotors(rotor, duration):
    """Central differences of the state at one time, within one phase."""
    h, bundle = 1e-5, np.zeros((7, 4))
    end = followed(rotor, duration, bundle)
    np.testing.assert_array_equal(bundle[:4], 0.0)
    np.testing.assert_allclose(end, followed(rotor, duration), rtol=0.0, atol=1e-14)
    for name, added in zip(("omega", "zeta", "delta0"), bundle[4:], strict=True):
        if name == "delta0" and rotor is not CONTACT:
            assert not added.any()
            continue
        value = getattr(rotor, name)
        ahead, behind = (
            followed(replace(rotor, **{name: value + sign * h}), duration) for sign in (1, -1)
        )
        np.testing.assert_allclose(added, (ahead - behind) / (2.0 * h), rtol=0, atol=1e-9)


def test_what_is_added_comes_on_top_of_what_there_was():
    """Rows begin where they are and are carried by the flow like any difference."""
    rows = np.random.default_rng(0).normal(size=(7, 4))
    bundle, alone, matrix = rows.copy(), np.zeros((7, 4)), np.eye(4)
    for each in (bundle, alone, matrix):
        followed(CONTACT, 3.0, each)
    np.testing.assert_allclose(bundle, rows @ matrix + alone, rtol=0.0, atol=1e-12)
