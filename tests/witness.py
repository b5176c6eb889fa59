"""The witness of the tests: one disc as a rigid body, by SciPy's DOP853 restarted at every event.

It shares nothing with the program. The state on fixed axes is ``(x, y, vx, vy, theta, theta')``, in
any consistent units. Newton's law for the centre of mass, Euler's for the spin, and what is known
of friction are four linear equations for the accelerations and the tangential force T, the same in
every mode; a prescribed speed takes the place of Euler's. Small differences of the start
follow the derivatives of these equations, by complex steps; they run through entry, exit, release
and press unchanged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp

HOW = {"method": "DOP853", "rtol": 3e-14, "atol": 1e-15, "max_step": 0.1}
# For this part of the longest step nothing is looked for after an event: what it left must not be
# found again.
NUDGE = 1e-6
FLIES, FORWARDS, BACKWARDS, ROLLS, LOOSE = 0, 1, -1, 2, 3
ENTRY, EXIT, ROLL, SLIP, REVERSE, PRESS, RELEASE = 1, -1, 2, -2, 3, 4, -4
STEP = 1e-30  # of a complex derivative


def in_units(how, length, time):
    """Return settings of the integrator for states in other units."""
    scales = np.array([length, length, length / time, length / time, 1.0, 1.0 / time])
    return how | {"atol": how["atol"] * scales, "max_step": how["max_step"] * time}


@dataclass(frozen=True)
class Disc:
    """A rotor with either a rate of its speed, or a torque ``(tau0, slope)`` and an inertia.

    The rotor is dimensionless, or one in SI units.
    """

    rotor: object
    rate: float = 0.0
    torque: tuple | None = None
    inertia: float = 0.0
    unbalance: float = 1.0  # 0 takes the unbalance away

    def get(self, name, otherwise=1.0):
        """Return a parameter; mass, eccentricity and stiffness without dimensions are 1."""
        return getattr(self.rotor, name, otherwise) or 0.0

    @cached_property
    def clearance(self):
        return self.get("clearance", getattr(self.rotor, "delta0", 0.0))

    @cached_property
    def plain(self):
        """Mass, disc radius, offset of the centre of mass, damping: asked for at every step."""
        damping = getattr(self.rotor, "damping", None)
        return (
            self.get("mass"), self.get("disc_radius"), self.unbalance * self.get("eccentricity"),
            2.0 * self.rotor.zeta if damping is None else damping,
        )  # fmt: skip

    def polar(self, state):
        """Return radius, direction (x, y), radial and tangential velocity."""
        x, y, vx, vy = state[:4]
        radius = (x * x + y * y) ** 0.5
        out = (x / radius, y / radius) if radius else (1.0, 0.0)
        return radius, out, out[0] * vx + out[1] * vy, out[0] * vy - out[1] * vx

    def factor(self, state):
        """Return ``1 + c d'``."""
        return 1.0 + self.rotor.contact_damping * self.polar(state)[2]

    def normal(self, state):
        """Return the normal force, which may pull where a step looks beyond a release."""
        radius, _, rise, _ = self.polar(state)
        return self.pushed(radius, rise)

    def pushed(self, radius, rise):
        """Return the normal force at a radius and a radial velocity."""
        depth = radius - self.clearance
        sign = 1.0 if depth.real > 0.0 else -1.0
        power = sign * (sign * depth) ** self.rotor.contact_exponent
        return self.get("contact_stiffness") * power * (1.0 + self.rotor.contact_damping * rise)

    def slip(self, state):
        """Return the speed of the rim on the ring."""
        return self.polar(state)[3] + self.get("disc_radius") * state[5]

    def exactly(self, state, mode):
        """Return a state in which a disc that rolls does not slip."""
        if mode != ROLLS:
            return state
        _, (ox, oy), rise, _ = self.polar(state)
        around = -self.get("disc_radius") * state[5]
        return [*state[:2], rise * ox - around * oy, rise * oy + around * ox, *state[4:]]

    def solved(self, state, mode):
        """Return ``x'' y'' theta'' T``: both accelerations are linear in the last two."""
        rotor, (mass, rho, e, damping) = self.rotor, self.plain
        x, y, vx, vy, angle, speed = state[:6]
        radius, (ox, oy), rise, around = self.polar(state)
        c, s = math.cos(angle.real), math.sin(angle.real)
        normal = self.pushed(radius, rise) if mode in (FORWARDS, BACKWARDS, ROLLS) else 0.0
        fx = -damping * vx - rotor.shaft_stiffness * x - normal * ox
        fy = -damping * vy - rotor.shaft_stiffness * y - normal * oy
        ax, ay = fx / mass + e * speed**2 * c, (fy - rotor.load) / mass + e * speed**2 * s
        turns, drags, drive = 1.0, 0.0, self.rate  # turns theta'' + drags T = drive
        if self.torque is not None:  # about the centre of mass; T acts on the rim
            turns, drags = self.inertia, rho - e * (c * ox + s * oy)
            drive = self.torque[0] - self.torque[1] * speed - e * (c * fy - s * fx)
        by_spin, by_drag, known = 0.0, 1.0, 0.0
        if mode in (FORWARDS, BACKWARDS):
            known = rotor.friction * mode * normal
        if mode == ROLLS:  # the tangential velocity changes as rho theta' does, the other way
            by_spin, by_drag = rho - e * (c * ox + s * oy), -1.0 / mass
            known = around * rise / radius + oy * ax - ox * ay
        whole = turns * by_drag - drags * by_spin
        faster = (drive * by_drag - drags * known) / whole
        drag = (turns * known - by_spin * drive) / whole
        ax, ay = ax + e * s * faster + oy / mass * drag, ay - e * c * faster - ox / mass * drag
        return ax, ay, faster, drag

    def rates(self, state, mode):
        """Return the rate of change, and that of differences if the state has some behind it."""
        first = state[:6].tolist()
        here = self.derivative(first, mode)
        if len(state) == 6:
            return np.array(here)
        slopes = np.empty((4, 4))
        for place in range(4):
            beside = [each + STEP * 1j * (at == place) for at, each in enumerate(first)]
            slopes[:, place] = [each.imag / STEP for each in self.derivative(beside, mode)[:4]]
        return np.concatenate([here, (slopes @ state[6:].reshape(4, 4)).ravel()])

    def derivative(self, state, mode):
        """Return the rate of change of six numbers, which may be complex."""
        _, _, vx, vy, _, speed = first = self.exactly(state, mode)
        ax, ay, faster, _ = self.solved(first, mode)
        return [vx, vy, ax, ay, speed, faster]

    def turning(self, state, mode=FORWARDS):
        """Return the rates of ``(x, y, vx, vy, theta')`` on axes that turn with the unbalance."""
        x, y, vx, vy, speed = state
        *here, _, faster = self.rates(np.array([*state[:4], 0.0, speed]), mode)
        return np.array([*(here + speed * np.array([y, -x, vy, -vx])), faster])

    def guards(self, mode):
        """Return what ends a mode where it falls through 0, and which event that is."""

        def gap(state):
            return np.hypot(state[0], state[1]) - self.clearance

        def grip(sense):
            return lambda state: (
                self.rotor.friction * self.normal(state) - sense * self.solved(state, ROLLS)[3]
            )

        if mode == FLIES:
            return [(lambda state: -gap(state), ENTRY)]
        guards = [(gap, EXIT)]
        if mode == LOOSE:
            return [*guards, (lambda state: -self.factor(state), PRESS)]
        if self.rotor.contact_damping > 0.0:
            guards.append((self.factor, RELEASE))
        if mode == ROLLS:
            return [*guards, (grip(1), SLIP), (grip(-1), SLIP)]
        if self.rotor.friction > 0.0:
            guards.append((lambda state: mode * self.slip(state), ROLL))
        return guards

    def mode_of(self, state, stopped=False):
        """Return how a contact whose force pushes goes on."""
        slip = 0.0 if stopped else self.slip(state)
        if self.rotor.friction == 0.0:
            return FORWARDS
        if abs(slip) > 1e-13:
            return int(np.sign(slip))
        hold = self.solved(state, ROLLS)[3]
        holds = abs(hold) <= self.rotor.friction * self.normal(state) + 1e-15
        return ROLLS if holds else int(np.sign(hold))

    def stretch(self, now, end, state, mode, guards=(), how=HOW, dense=False):
        """Follow one mode to an end or to the first guard: time, state, number of the guard, and
        the states between."""

        def wrapped(guard):
            def event(_, seen):
                return guard(self.exactly(seen, mode))

            event.terminal, event.direction = True, -1.0
            return event

        found = solve_ivp(
            lambda _, seen: self.rates(seen, mode), (now, end), state, dense_output=dense,
            events=[wrapped(each) for each in guards], **how,
        )  # fmt: skip
        assert found.success, found.message
        place = next((i for i, times in enumerate(found.t_events) if times.size), None)
        return float(found.t[-1]), np.array(self.exactly(found.y[:, -1], mode)), place, found.sol


@dataclass
class Followed:
    """Events as rows of time, kind and speed, the state at the end, and states at some times."""

    events: list = field(default_factory=list)
    end: np.ndarray | None = None
    states: np.ndarray | None = None

    @property
    def tangents(self):
        """The derivatives of the end by the start."""
        return self.end[6:].reshape(4, 4)

    @property
    def crossings(self):
        """The times of entries and exits."""
        return np.array([time for time, kind, _ in self.events if kind in (ENTRY, EXIT)])


def followed(pieces, start, speed, *, angle=0.0, at=(), tangents=False, how=HOW):
    """Follow pieces, each an end and a `Disc`, from a start off the ring; return `Followed`."""
    behind = np.eye(4).ravel() if tangents else []
    state = np.array([*start, angle, speed, *behind], dtype=float)
    told, now, times, states = Followed(), 0.0, np.asarray(at, dtype=float), []

    def go(disc, end, guards=()):
        nonlocal now, state
        before = now
        now, state, place, path = disc.stretch(
            now, end, state, mode, guards, how, dense=bool(times.size)
        )
        while len(states) < len(times) and before <= times[len(states)] <= now:
            states.append(path(times[len(states)]))
        return place

    disc, mode = pieces[0][1], FLIES
    if np.hypot(*state[:2]) > disc.clearance:
        mode = disc.mode_of(state) if disc.factor(state) > 0.0 else LOOSE
    for end, disc in pieces:
        while now < end:
            guards = disc.guards(mode)
            if mode == ROLLS:
                lost = [guard(state) <= 0.0 for guard, kind in guards if kind == SLIP]
                if any(lost):  # as the angular acceleration jumped
                    mode = FORWARDS if lost[0] else BACKWARDS
                    told.events.append((now, SLIP, state[5]))
                    continue
            place = go(disc, end, [guard for guard, _ in guards])
            if place is None:
                break
            kind = guards[place][1]
            if kind == ROLL:
                before, mode = mode, disc.mode_of(state, stopped=True)
                assert mode != before, "only touched"
                kind = ROLL if mode == ROLLS else REVERSE
            elif kind == SLIP:
                mode = FORWARDS if place == len(guards) - 2 else BACKWARDS
            else:
                mode = {EXIT: FLIES, RELEASE: LOOSE}.get(kind)
                mode = disc.mode_of(state) if mode is None else mode
            told.events.append((now, kind, state[5]))
            go(disc, min(now + NUDGE * how["max_step"], end))
    told.end, told.states = state, np.array(states)
    return told


def flown(rotor, start, duration, **more):
    """Follow a rotor at its speed."""
    speed = rotor.omega if hasattr(rotor, "omega") else rotor.speed
    return followed([(duration, Disc(rotor))], start, speed, **more)
