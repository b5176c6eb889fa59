"""A witness of orbits that shares nothing with the program: SciPy's DOP853, restarted at crossings.

The equations and their variational equation, which runs through entries and exits unchanged, are
written again here, on fixed axes.
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


# ---- Friction: sliding on fixed axes, rolling in polar coordinates, restarted at every event ----

# So long after an event nothing is looked for: what it left must not be found again.
NUDGE = 1e-7


def rub_normal(rotor, radius, rise):
    """The normal force, which may pull where a step looks beyond a release."""
    depth = radius - rotor.delta0
    return np.sign(depth) * abs(depth) ** rotor.contact_exponent * (
        1.0 + rotor.contact_damping * rise
    )  # fmt: skip


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


def sliding_rates(time, state, rotor, mode):
    """z'' of flight, of a loose contact, and of one that slides in a sense."""
    z, v = complex(*state[:2]), complex(*state[2:])
    push = rotor.omega**2 * np.exp(1j * rotor.omega * time) - 1j * rotor.load
    a = push - 2.0 * rotor.zeta * v - rotor.shaft_stiffness * z
    if mode in (1, -1):
        radius, _, rise, _ = rub_polar(state)
        a -= rub_normal(rotor, radius, rise) * (1.0 + 1j * rotor.friction * mode) * z / radius
    return [v.real, v.imag, a.real, a.imag]


def rolling_rates(time, state, rotor):
    """r'' = V**2/r - 2 zeta r' - kappa r - N + omega**2 cos(omega t - phi) - gamma sin phi, and
    r phi' = -V."""
    radius, rise, phi = state
    rim = rotor.disc_radius * rotor.omega
    drive = rotor.omega**2 * np.cos(rotor.omega * time - phi) - rotor.load * np.sin(phi)
    bend = drive + rim**2 / radius - 2.0 * rotor.zeta * rise - rotor.shaft_stiffness * radius
    return [rise, bend - rub_normal(rotor, radius, rise), -rim / radius]


def rolled_state(polar, rotor):
    """Displacement and velocity of a disc that rolls."""
    radius, rise, phi = polar
    turn = np.exp(1j * phi)
    z, v = radius * turn, (rise - 1j * rotor.disc_radius * rotor.omega) * turn
    return np.array([z.real, z.imag, v.real, v.imag])


def rub_guards(rotor, mode):
    """What ends a mode where it falls through 0, and which event that is."""

    def gap(_time, state):
        return np.hypot(state[0], state[1]) - rotor.delta0

    def held(_time, state):
        return 1.0 + rotor.contact_damping * rub_polar(state)[2]

    def grip(sense):
        def left(time, state):
            radius, _, rise, _ = rub_polar(state)
            normal = rub_normal(rotor, radius, rise)
            return rotor.friction * normal - sense * rub_hold(time, state, rotor)

        return left

    def negative(function):
        return lambda time, state: -function(time, state)

    if mode == 0:
        return [(negative(gap), 1)]
    guards = [(gap, -1)]
    if mode == 3:
        return [*guards, (negative(held), 4)]
    if rotor.contact_damping > 0.0:
        guards.append((held, -4))
    if mode == 2:
        return [*guards, (grip(1), -2), (grip(-1), -2)]
    if rotor.friction > 0.0:
        guards.append((lambda _, state: mode * rub_slip(state, rotor), 2))
    return guards


def rub_mode_of(time, state, rotor, stopped=False):
    """How a pressed contact goes on: 1 or -1 where it slides, 2 where it rolls."""
    if rotor.friction == 0.0:
        return 1
    slip = 0.0 if stopped else rub_slip(state, rotor)
    if abs(slip) > 1e-13:
        return int(np.sign(slip))
    radius, _, rise, _ = rub_polar(state)
    hold = rub_hold(time, state, rotor)
    grip = rotor.friction * rub_normal(rotor, radius, rise) if radius > rotor.delta0 else 0.0
    return 2 if abs(hold) <= grip + 1e-15 else int(np.sign(hold))


def rub_stretch(now, end, state, rotor, mode, guards=()):
    """Follow one mode to an end or to the first guard; return time, state and number of guard."""
    how = {**TOLERANCES, "rtol": 1e-13, "atol": 1e-14, "max_step": 0.05}
    read = (lambda polar: rolled_state(polar, rotor)) if mode == 2 else (lambda seen: seen)

    def wrapped(guard):
        def event(time, seen):
            return guard(time, read(seen))

        event.terminal, event.direction = True, -1.0
        return event

    if mode == 2:
        radius, phi, rise, _ = rub_polar(state)
        begun, rates = [radius, rise, phi], lambda time, seen: rolling_rates(time, seen, rotor)
    else:
        begun, rates = state, lambda time, seen: sliding_rates(time, seen, rotor, mode)
    found = solve_ivp(rates, (now, end), begun, events=[wrapped(each) for each in guards], **how)
    assert found.success, found.message
    if found.status == 0:
        return end, read(found.y[:, -1]), None
    place = next(i for i, times in enumerate(found.t_events) if times.size)
    return float(found.t_events[place][0]), read(found.y_events[place][0]), place


def rubbed(rotor, start, duration):
    """Follow a rotor, off the ring at the start; return its events and its end."""
    now, state, events = 0.0, np.array(start, dtype=float), []
    mode = 0
    if np.hypot(*state[:2]) > rotor.delta0:
        loose = 1.0 + rotor.contact_damping * rub_polar(state)[2] <= 0.0
        mode = 3 if loose else rub_mode_of(now, state, rotor)
    while now < duration:
        guards = rub_guards(rotor, mode)
        now, state, place = rub_stretch(now, duration, state, rotor, mode, [g for g, _ in guards])
        if place is None:
            break
        kind = guards[place][1]
        if kind == 2:
            before, mode = mode, rub_mode_of(now, state, rotor, stopped=True)
            kind = 2 if mode == 2 else 3
            assert mode != before, "only touched"
        elif kind == -2:
            mode = 1 if place == len(guards) - 2 else -1
        else:
            mode = {-1: 0, -4: 3}.get(kind) if kind < 0 else rub_mode_of(now, state, rotor)
        events.append((now, kind))
        end = min(now + NUDGE, duration)
        now, state, _ = rub_stretch(now, end, state, rotor, mode)
    return events, state
