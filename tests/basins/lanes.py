"""Rotors for the lanes, the field that they follow, and lanes that nothing holds."""

import numpy as np

from rotor_ida import Rotor
from rotor_ida.basins import kernel
from rotor_ida.model.equations import push_over_radius, rotating_field

GO_ON = np.zeros(1, np.uint8)
NO_REGIONS, NO_SECTIONS = np.empty(0, kernel.REGION), np.empty(0, kernel.SECTION)
WHIP = Rotor(omega=0.62962981, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
PAPERS = [
    Rotor(omega=1.7, zeta=0.07, delta0=0.0),
    Rotor(omega=1.7, zeta=0.07, delta0=0.5),
    Rotor(omega=1.7, zeta=0.07, delta0=1.0),
    Rotor(omega=3.0, zeta=0.07, delta0=0.5),
    Rotor(omega=1.0, zeta=0.6, delta0=0.3),
    Rotor(omega=0.3, zeta=1.5, delta0=0.0),
]
MACHINES = [
    Rotor(omega=1.7, zeta=0.07, delta0=0.5, shaft_stiffness=0.25),
    Rotor(omega=1.7, zeta=0.07, delta0=0.5, contact_exponent=1.0),
    Rotor(omega=1.7, zeta=0.07, delta0=0.5, contact_damping=0.3),
    Rotor(
        omega=1.2, zeta=0.1, delta0=0.8, shaft_stiffness=0.4, contact_exponent=1.0,
        contact_damping=0.7,
    ),
    Rotor(omega=1.7, zeta=0.07, delta0=0.0, contact_exponent=1.0, shaft_stiffness=0.25),
    Rotor(omega=1.7, zeta=0.07, delta0=0.0, shaft_stiffness=0.25),
]  # fmt: skip
RUBBING = {
    "beside dry whip": WHIP,
    "that bounces": Rotor(omega=2.0, zeta=0.07, delta0=2.0, friction=0.1, disc_radius=10.0),
    "above resonance": Rotor(omega=1.7, zeta=0.07, delta0=0.5, friction=0.05, disc_radius=20.0),
    "shaft, linear contact, contact damping": Rotor(
        omega=1.2, zeta=0.1, delta0=0.5, shaft_stiffness=0.3, contact_exponent=1.0,
        contact_damping=0.5, friction=0.1, disc_radius=5.0,
    ),
    "slow, with a disc of no radius": Rotor(
        omega=0.3, zeta=1.5, delta0=0.05, friction=0.3, disc_radius=0.0
    ),
}  # fmt: skip


def slip_of(states, rotor):
    """Return the slip speed ``v_t + rho omega`` of states, shape (4, ...)."""
    x, y, u, v = states
    return (x * v - y * u) / np.hypot(x, y) + (rotor.disc_radius or 0.0) * rotor.omega


def field(state, rotor):
    """Return the rate of a state on the rotating axes while the disc slides forwards."""
    drag = rotor.friction * push_over_radius(state, rotor)
    return rotating_field(state, rotor) + drag * np.array([0.0, 0.0, state[1], -state[0]])


def unlabelled(count):
    """Return labels and times of starts that have yet to be followed."""
    return np.full(count, kernel.NOT_COMPUTED, np.int16), np.zeros(count, np.float32)


def followed(rotor, states, duration, tolerance, free=kernel.NO_CONTACT_FREE):
    """Return ends, labels and times of starts that nothing holds but a contact-free whirl."""
    ends, (labels, times) = np.array(states, order="C"), unlabelled(states.shape[1])
    kernel.follow(
        ends, labels, times, rotor, NO_REGIONS, free, NO_SECTIONS, duration, tolerance, GO_ON
    )
    return ends, labels, times
