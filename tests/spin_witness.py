"""A witness of run-ups that shares nothing with the program: SciPy's DOP853, restarted at events.

The disc is a rigid body on fixed axes, state ``(x, y, vx, vy, theta, theta')``. Newton's law for
its centre of mass, Euler's for its spin, and what is known of friction are four linear equations
for the accelerations and the tangential force T, solved as such in every mode; a prescribed speed
takes the place of Euler's.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

HOW = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14, "max_step": 0.1}
# So long after an event nothing is looked for: what it left must not be found again.
NUDGE = 1e-7
FLIES, FORWARDS, BACKWARDS, ROLLS, LOOSE = 0, 1, -1, 2, 3
ENTRY, EXIT, ROLL, SLIP, REVERSE, PRESS, RELEASE = 1, -1, 2, -2, 3, 4, -4


@dataclass(frozen=True)
class Spinner:
    """A rotor with either a rate of its speed, or a torque ``(tau0, slope)`` and an inertia."""

    rotor: object
    rate: float = 0.0
    torque: tuple | None = None
    inertia: float = 0.0

    def normal(self, state):
        """Return the normal force, which may pull where a step looks beyond a release."""
        z, v = complex(*state[:2]), complex(*state[2:4])
        depth, rise = abs(z) - self.rotor.delta0, (z.conjugate() * v).real / abs(z)
        power = np.sign(depth) * abs(depth) ** self.rotor.contact_exponent
        return power * (1.0 + self.rotor.contact_damping * rise)

    def slip(self, state):
        """Return the speed of the rim on the ring."""
        z, v = complex(*state[:2]), complex(*state[2:4])
        return (z.conjugate() * v).imag / abs(z) + (self.rotor.disc_radius or 0.0) * state[5]

    def solved(self, state, mode):
        """Return ``x'' y'' theta'' T``."""
        rotor, rho = self.rotor, self.rotor.disc_radius or 0.0
        z, v, speed = complex(*state[:2]), complex(*state[2:4]), state[5]
        unbalance = np.exp(1j * state[4])
        out = z / abs(z) if z else 1.0
        pushed = mode in (FORWARDS, BACKWARDS, ROLLS)
        normal = self.normal(state) if pushed else 0.0
        at_centre = -2.0 * rotor.zeta * v - rotor.shaft_stiffness * z - normal * out
        moving = at_centre - 1j * rotor.load + speed**2 * unbalance
        drag, lever = -1j * out, rho * out - unbalance  # of T, about the centre of mass
        turned = 1j * unbalance
        rows = [
            [1.0, 0.0, turned.real, -drag.real],
            [0.0, 1.0, turned.imag, -drag.imag],
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
        right = [moving.real, moving.imag, self.rate, 0.0]
        if self.torque is not None:
            rows[2][2:] = [self.inertia, -(lever.conjugate() * drag).imag]
            drive = self.torque[0] - self.torque[1] * speed
            right[2] = drive + (-unbalance.conjugate() * at_centre).imag
        if mode in (FORWARDS, BACKWARDS):
            right[3] = rotor.friction * mode * normal
        if mode == ROLLS:  # v_t = Im(conj(out) v) changes as rho theta' does, the other way
            turning = (out.conjugate() * v).imag / abs(z)
            rows[3] = [-out.imag, out.real, rho, 0.0]
            right[3] = turning * (out.conjugate() * v).real
        return np.linalg.solve(np.array(rows), right)

    def rates(self, state, mode):
        """Return the rate of change."""
        ax, ay, faster, _ = self.solved(state, mode)
        return [*state[2:4], ax, ay, state[5], faster]

    def held(self, state):
        """Return ``1 + c d'``."""
        z, v = complex(*state[:2]), complex(*state[2:4])
        return 1.0 + self.rotor.contact_damping * (z.conjugate() * v).real / abs(z)

    def guards(self, mode):
        """Return what ends a mode where it falls through 0, and which event that is."""
        rotor = self.rotor

        def gap(state):
            return np.hypot(state[0], state[1]) - rotor.delta0

        def grip(sense):
            return lambda state: (
                rotor.friction * self.normal(state) - sense * self.solved(state, ROLLS)[3]
            )

        if mode == FLIES:
            return [(lambda state: -gap(state), ENTRY)]
        guards = [(gap, EXIT)]
        if mode == LOOSE:
            return [*guards, (lambda state: -self.held(state), PRESS)]
        if rotor.contact_damping > 0.0:
            guards.append((self.held, RELEASE))
        if mode == ROLLS:
            return [*guards, (grip(1), SLIP), (grip(-1), SLIP)]
        if rotor.friction > 0.0:
            guards.append((lambda state: mode * self.slip(state), ROLL))
        return guards

    def pressed(self, state, stopped=False):
        """Return how a pressed contact goes on."""
        slip = 0.0 if stopped else self.slip(state)
        if self.rotor.friction == 0.0:
            return FORWARDS
        if abs(slip) > 1e-13:
            return int(np.sign(slip))
        hold = self.solved(state, ROLLS)[3]
        return (
            ROLLS if abs(hold) <= self.rotor.friction * self.normal(state) else int(np.sign(hold))
        )

    def stretch(self, now, end, state, mode, guards=()):
        """Follow one mode to an end or to the first guard."""

        def wrapped(guard):
            def event(_, seen):
                return guard(seen)

            event.terminal, event.direction = True, -1.0
            return event

        found = solve_ivp(
            lambda _, seen: self.rates(seen, mode), (now, end), state,
            events=[wrapped(each) for each in guards], **HOW,
        )  # fmt: skip
        assert found.success, found.message
        if found.status == 0:
            return end, found.y[:, -1], None
        place = next(i for i, times in enumerate(found.t_events) if times.size)
        return float(found.t_events[place][0]), found.y_events[place][0], place


@dataclass
class Ran:
    """Events as rows of time, kind and speed, and the state at the end."""

    events: list = field(default_factory=list)
    end: np.ndarray | None = None


def ran(pieces, start, omega):
    """Follow pieces, each an end and a `Spinner`, from a start off the ring."""
    state, now, told = np.array([*start, 0.0, omega], dtype=float), 0.0, Ran()
    spinner = pieces[0][1]
    mode = FLIES
    if np.hypot(*state[:2]) > spinner.rotor.delta0:
        mode = spinner.pressed(state) if spinner.held(state) > 0.0 else LOOSE
    for end, spinner in pieces:
        while now < end:
            guards = spinner.guards(mode)
            if mode == ROLLS:
                lost = [g(state) <= 0.0 for g, kind in guards if kind == SLIP]
                if any(lost):  # as the angular acceleration jumped
                    mode = FORWARDS if lost[0] else BACKWARDS
                    told.events.append((now, SLIP, state[5]))
                    continue
            now, state, place = spinner.stretch(now, end, state, mode, [g for g, _ in guards])
            if place is None:
                break
            kind = guards[place][1]
            if kind == ROLL:
                before, mode = mode, spinner.pressed(state, stopped=True)
                assert mode != before, "only touched"
                kind = ROLL if mode == ROLLS else REVERSE
            elif kind == SLIP:
                mode = FORWARDS if place == len(guards) - 2 else BACKWARDS
            else:
                mode = {EXIT: FLIES, RELEASE: LOOSE}.get(kind) if kind < 0 else None
                if mode is None:
                    mode = spinner.pressed(state)
            told.events.append((now, kind, state[5]))
            until = min(now + NUDGE, end)
            now, state, _ = spinner.stretch(now, until, state, mode)
    told.end = state
    return told
