"""A witness of orbits that shares nothing with the program: SciPy's DOP853, restarted at crossings.

The equations and their variational equation, which runs through entries and exits unchanged, are
written again here, on fixed axes. Orbits with friction are those of `tests.spin_witness`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from tests.spin_witness import Spinner, ran

TOLERANCES = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}


@dataclass(frozen=True)
class Flown:
    """Where an orbit ends, the derivative of that by its start, and when it crossed the ring."""

    end: np.ndarray
    monodromy: np.ndarray
    crossings: np.ndarray


def machine_rates(time, whole, rotor, in_contact, pressed):
    """Rate of change on fixed axes of a machine's state, and of four differences from it."""
    z, v = whole[:2], whole[2:4]
    radius = np.hypot(*z)
    outward = z / (radius or 1.0)
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


# ---- Friction ----


def rub_polar(state):
    """Radius, direction, radial and tangential velocity."""
    x, y, vx, vy = state
    radius = np.hypot(x, y)
    return radius, np.arctan2(y, x), (x * vx + y * vy) / radius, (x * vy - y * vx) / radius


def rub_hold(time, state, rotor):
    """F = omega**2 sin(omega t - phi) - gamma cos phi + V (2 zeta + r'/r)."""
    radius, phi, rise, _ = rub_polar(state)
    rim = rotor.disc_radius * rotor.omega
    push = rotor.omega**2 * np.sin(rotor.omega * time - phi) - rotor.load * np.cos(phi)
    return push + rim * (2.0 * rotor.zeta + rise / radius)


def rub_slip(state, rotor):
    """v_s = v_t + rho omega."""
    return rub_polar(state)[3] + (rotor.disc_radius or 0.0) * rotor.omega


def rubbed(rotor, start, duration):
    """Follow a rotor, off the ring at the start; return its events and its end."""
    told = ran([(duration, Spinner(rotor))], start, rotor.omega)
    return [(time, kind) for time, kind, _ in told.events], told.end[:4]
