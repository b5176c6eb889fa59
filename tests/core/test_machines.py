"""Runs of machines: the whole model where the paper's rotor has no case like it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from rotor_ida import Rotor
from rotor_ida.core.interface import DONE
from rotor_ida.core.runs import Asked, follow

HOW = {"rtol": 1e-12, "atol": 1e-14}


def linear_state(rotor, start, time):
    """Where a linear contact without clearance leads, on the rotating axes: by an exponential.

    The state is ``(z, z', g, e)`` on axes that stand still, g the load's and e the unbalance's.
    """
    stiffness = rotor.shaft_stiffness + 1.0
    matrix = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-stiffness, -2.0 * rotor.zeta, rotor.load, rotor.omega**2],
            [0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1j * rotor.omega],
        ]
    )
    x, y, vx, vy = start
    z, v, *_ = expm(matrix * time) @ [complex(x, y), complex(vx, vy), -1j, 1.0]
    z, v = np.array([z, v]) * np.exp(-1j * rotor.omega * time)
    return np.array([z.real, z.imag, v.real, v.imag])


@pytest.mark.parametrize("rtol", [1e-8, 1e-13])
@pytest.mark.parametrize(
    "start", [(1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0), (0.7, 1e-9, -0.4, 0)]
)
def test_a_linear_contact_without_clearance_is_felt_through_the_centre(start, rtol):
    """It is linear: what is left out near the axis, where a Hertz contact is not felt, shows."""
    for omega, kappa, load in ((0.0, 0.0, 0.0), (0.0, 0.8, 0.3), (1.7, 0.0, 0.5), (0.0, 0.0, 2.0)):
        rotor = Rotor(omega=omega, zeta=0.0, delta0=0.0, contact_exponent=1.0,
                      shaft_stiffness=kappa, load=load)  # fmt: skip
        seen = follow(Asked(rotor=rotor, start=start, duration=20.0, rtol=rtol, atol=1e-3 * rtol))
        assert seen.status == DONE
        expected = linear_state(rotor, start, 20.0)
        np.testing.assert_allclose(seen.state, expected, rtol=0, atol=40.0 * rtol + 1e-13)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_a_load_alone_leads_from_rest_at_the_axis(exponent):
    """It swings between there and the depth h at which load times h is the energy of the contact:
    h**(n + 1)/(n + 1) = gamma h."""
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=0.0, load=0.6, contact_exponent=exponent)
    seen = follow(Asked(rotor=rotor, start=(0.0,) * 4, duration=30.0, extrema=True, **HOW))
    assert seen.status == DONE
    depth = (0.6 * (exponent + 1.0)) ** (1.0 / exponent)
    highest = seen.extrema[seen.extrema[:, 2] > 0, 1]
    assert highest.size > 2
    np.testing.assert_allclose(highest, depth, rtol=1e-10)


def test_columns_of_parameters_are_those_of_the_paper_s_rotor_alone():
    """They rest on a flow that is conformally symplectic, and on flight without a shaft."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_damping=0.1)
    asked = Asked(rotor=rotor, start=(0.0,) * 4, duration=1.0, bundle=np.zeros((7, 4)), **HOW)
    with pytest.raises(ValueError, match="must be that of the paper's rotor, got Rotor"):
        follow(asked)
