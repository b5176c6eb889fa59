"""A witness of orbits that shares nothing with the program: SciPy's DOP853, restarted at crossings.

The equations are written again here, on the rotating axes, from DESIGN section 2; the variational
equation runs through entries and exits unchanged.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

TOLERANCES = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}


@dataclass(frozen=True)
class Flown:
    """Where an orbit ends, the derivative of that by its start, and when it crossed the ring."""

    end: np.ndarray
    monodromy: np.ndarray
    crossings: np.ndarray


def acceleration(z, w, omega, zeta, delta0, in_contact):
    """Rate of change of ``(Z, W)`` with the force law of one mode."""
    radius = abs(z)
    force = max(radius - delta0, 0.0) ** 1.5 if in_contact else 0.0
    push = force * z / radius if radius else 0.0
    return w - 1j * omega * z, omega**2 - (2.0 * zeta + 1j * omega) * w - push


def stiffness_of(z, delta0):
    """Derivative of the contact force by displacement, shape (2, 2)."""
    radius, depth = abs(z), max(abs(z) - delta0, 0.0)
    outward = np.array([z.real, z.imag]) / radius
    radial = np.outer(outward, outward)
    return 1.5 * depth**0.5 * radial + depth**1.5 / radius * (np.eye(2) - radial)


def rates(_, whole, omega, zeta, delta0, in_contact):
    """Rate of change of a state and of four differences from it."""
    z, w = complex(*whole[:2]), complex(*whole[2:4])
    rate = acceleration(z, w, omega, zeta, delta0, in_contact)
    turn = omega * np.array([[0.0, 1.0], [-1.0, 0.0]])
    jacobian = np.zeros((4, 4))
    jacobian[:2, :2], jacobian[:2, 2:] = turn, np.eye(2)
    jacobian[2:, 2:] = turn - 2.0 * zeta * np.eye(2)
    if in_contact:
        jacobian[2:, :2] = -stiffness_of(z, delta0)
    columns = jacobian @ whole[4:].reshape(4, 4)
    return np.concatenate([[rate[0].real, rate[0].imag, rate[1].real, rate[1].imag],
                           columns.ravel()])  # fmt: skip


def gap(_, whole, omega, zeta, delta0, in_contact):
    """Distance from the ring."""
    return np.hypot(whole[0], whole[1]) - delta0


def flown(rotor, start, duration):
    """Follow a state and four differences from it, off the ring at the start, for a time."""
    parameters = (rotor.omega, rotor.zeta, rotor.delta0)
    whole = np.concatenate([start, np.eye(4).ravel()])
    in_contact, now, crossings = bool(np.hypot(start[0], start[1]) > rotor.delta0), 0.0, []
    while now < duration:
        gap.terminal, gap.direction = True, -1.0 if in_contact else 1.0
        solved = solve_ivp(
            rates, (now, duration), whole, args=(*parameters, in_contact),
            events=gap if rotor.delta0 > 0.0 else None, **TOLERANCES,
        )  # fmt: skip
        assert solved.success, solved.message
        now, whole = float(solved.t[-1]), solved.y[:, -1]
        if solved.status == 1:
            crossings.append(now)
            in_contact = not in_contact
    return Flown(whole[:4], whole[4:].reshape(4, 4), np.array(crossings))


def machine_rates(time, whole, rotor, in_contact, pressed):
    """Rate of change on fixed axes of a machine's state, and of four differences from it."""
    z, v = whole[:2], whole[2:4]
    radius = np.hypot(*z)
    outward = z / radius
    radial, depth, n = np.outer(outward, outward), radius - rotor.delta0, rotor.contact_exponent
    rise, held = v @ outward, 1.0 + rotor.contact_damping * (v @ outward)
    force = depth**n * held if in_contact and pressed and depth > 0.0 else 0.0
    angle = rotor.omega * time
    push = rotor.omega**2 * np.array([np.cos(angle), np.sin(angle)]) - [0.0, rotor.load]
    rate = push - 2.0 * rotor.zeta * v - rotor.shaft_stiffness * z - force * outward
    jacobian = np.zeros((4, 4))
    jacobian[:2, 2:] = np.eye(2)
    jacobian[2:, :2] = -rotor.shaft_stiffness * np.eye(2)
    jacobian[2:, 2:] = -2.0 * rotor.zeta * np.eye(2)
    if force:
        across = (np.eye(2) - radial) / radius
        jacobian[2:, :2] -= n * depth ** (n - 1.0) * held * radial + force * across
        dragged = rotor.contact_damping * depth**n
        jacobian[2:, :2] -= dragged * np.outer(outward, across @ (v - rise * outward))
        jacobian[2:, 2:] -= dragged * radial
    return np.concatenate([v, rate, (jacobian @ whole[4:].reshape(4, 4)).ravel()])


def machine_gap(_, whole, rotor, in_contact, pressed):
    """Distance of a machine from the ring."""
    return np.hypot(whole[0], whole[1]) - rotor.delta0


def machine_hold(_, whole, rotor, in_contact, pressed):
    """The factor ``1 + c d'`` of the contact force; a positive constant in flight."""
    z, v = whole[:2], whole[2:4]
    return 1.0 + rotor.contact_damping * (v @ z) / np.hypot(*z) if in_contact else 1.0


def machine_flown(rotor, start, duration):
    """Follow a machine on fixed axes, off the ring at the start, restarted at every event."""
    whole = np.concatenate([start, np.eye(4).ravel()])
    in_contact, now, crossings = bool(np.hypot(*start[:2]) > rotor.delta0), 0.0, []
    pressed = machine_hold(0.0, whole, rotor, in_contact, True) > 0.0
    while now < duration:
        machine_gap.terminal, machine_gap.direction = True, -1.0 if in_contact else 1.0
        machine_hold.terminal, machine_hold.direction = True, -1.0 if pressed else 1.0
        solved = solve_ivp(
            machine_rates, (now, duration), whole, args=(rotor, in_contact, pressed),
            events=[machine_gap, machine_hold], **TOLERANCES,
        )  # fmt: skip
        assert solved.success, solved.message
        now, whole = float(solved.t[-1]), solved.y[:, -1]
        if solved.status == 1:
            if solved.t_events[0].size:
                crossings.append(now)
                in_contact, pressed = not in_contact, True
            else:
                pressed = not pressed
    return Flown(whole[:4], whole[4:].reshape(4, 4), np.array(crossings))
