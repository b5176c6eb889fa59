"""Derivatives of a system's motion by its parameters, against one disc's own and against runs."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.core.runs import NO_STOP
from rotor_ida.model.assembly import assemble
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow

# Of one disc, and what they are of it as a system; the last is a factor of the damping.
SAME = {
    "omega": "speed", "delta0": "clearance", "friction": "friction",
    "contact_damping": "contact_damping", "zeta": "damping",
}  # fmt: skip


def flow_of(system, speed):
    return SystemFlow.at(SettlingProblem.of(assemble(system), 1e-13), speed, NO_STOP)


@pytest.mark.parametrize("friction", [0.1, 0.4])
@pytest.mark.parametrize("contact_damping", [0.1, 0.5])
def test_derivatives_are_those_of_one_disc(friction, contact_damping):
    """Both kernels derive them from the same law in different coordinates and scales."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.1, friction=friction,
                  disc_radius=3.0, contact_damping=contact_damping)  # fmt: skip
    flow, state = flow_of(rotor.system(), rotor.omega), np.array([3.0, 1.0, 0.0, 0.0])
    piece = flow.run(flow.given_state(state), 15.0, by=tuple(SAME.values()))
    own = DiscFlow(rotor).run(state, 15.0, by=tuple(SAME))
    np.testing.assert_array_equal(piece.event_kinds, own.event_kinds)
    assert {-1, 1} <= set(piece.event_kinds.tolist())
    for name, found, known in zip(SAME, piece.by, own.by, strict=True):
        factor = rotor.zeta if name == "zeta" else 1.0
        np.testing.assert_allclose(
            flow.in_q(found), factor * known, rtol=0.0, atol=1e-10 * np.abs(known).max(),
            err_msg=name,
        )  # fmt: skip


def test_the_derivative_by_a_friction_of_0_is_one_to_its_right():
    """No sense of sliding is known there; sliding contacts decide it with the least friction."""
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.0, disc_radius=3.0)
    flow, state = flow_of(rotor.system(), 1.2), np.array([1.0, 0.3, -0.2, 0.5])
    found = flow.run(flow.given_state(state), 15.0, by=("friction",)).by[0]
    own = DiscFlow(replace(rotor, friction=1e-9)).run(state, 15.0, by=("friction",)).by[0]
    np.testing.assert_allclose(flow.in_q(found), own, rtol=0.0, atol=1e-6 * np.abs(own).max())
