"""The rotor's equations of motion and its guards in plain Python, for the reference simulator.

They are those of the theory page, on fixed axes, for a speed that may change:

    z'' + 2 zeta z' + kappa z + (N + i T) z/|z| = (theta'**2 - i theta'') exp(i theta) - i gamma

While the surfaces slide ``T = mu N sign(v_s)``, ``v_s = v_t + rho theta'``; while the disc rolls
``T = F``, which keeps v_s at 0. A torque tau acts on the inertia j about the centre of mass:
``j theta'' = tau - R - T (rho - cos(theta - phi))``, where R is the moment of damping,
shaft and normal force, ``R = -Im(exp(-i theta) (2 zeta z' + kappa z + N z/|z|))``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import ROUNDING, Values
from rotor_ida.checks import State
from rotor_ida.model.contact import contact_potential, force_over_radius
from rotor_ida.model.forces import Moment, accelerations, with_values
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.orbit import (
    FLIES,
    IS_LOOSE,
    ROLLS,
    SLIDES_BACKWARDS,
    SLIDES_FORWARDS,
)
from rotor_ida.simulation.spin import ANGLE, GAINED, SPEED, Driven, Spin, Steady

Rates = Callable[[float, Values, Values], None]
Function = Callable[[float, Values], float]

# The first derivative of the radius above rounding decides whether a start on the stator is in
# contact.
HIDDEN = 16.0 * ROUNDING
# Displacement, velocity, impulse of the force since the contact began; with contact damping the
# energy lost; with friction heat and distance of sliding. If the speed changes, all of these and
# those that `spin` names.
X, Y, VX, VY, IMPULSE, LOST, HEAT, SLID = range(8)
FLIGHT, FORWARDS, BACKWARDS, ROLLING, LOOSE = (
    FLIES, SLIDES_FORWARDS, SLIDES_BACKWARDS, ROLLS, IS_LOOSE,
)  # fmt: skip
PRESSED = 4  # without friction
SLIDING = (FORWARDS, BACKWARDS)


@dataclass(frozen=True, slots=True)
class SpinningRotor:
    """A rotor and how it spins.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    spin : Spin
        How it spins.
    """

    rotor: Rotor
    spin: Spin

    @property
    def inertia(self) -> float:
        """The moment of inertia; 0 where the speed is prescribed."""
        return self.spin.inertia if isinstance(self.spin, Driven) else 0.0

    def spin_at(self, time: float, state: Values) -> tuple[float, float]:
        """Return angle and speed."""
        angle, speed = self.spin.at(time, state)
        return angle, speed

    def rim_speed(self, time: float, state: Values) -> float:
        """Return ``V = rho theta'``."""
        return (self.rotor.disc_radius or 0.0) * self.spin_at(time, state)[1]


def rates_of(spinning: SpinningRotor, mode: int) -> Rates:
    """Return the right-hand side of the first-order system in one mode.

    Each mode continues smoothly past its end, as a step may overshoot it: flight has no force
    outside the clearance, a pressed contact may pull after its release, and friction keeps its
    sense after a reversal. Rolling fixes the tangential velocity; its integrated value is unused.
    """
    rotor = spinning.rotor
    delta0, exponent, damping = rotor.delta0, rotor.contact_exponent, rotor.contact_damping
    friction = mode * rotor.friction if mode in SLIDING else 0.0
    turning = with_values(rotor, omega=0.0)

    def rates(time: float, state: Values, rate: Values) -> None:
        seen = rolled(spinning, time, state) if mode == ROLLING else state
        x, y, vx, vy = seen[:IMPULSE].tolist()
        radius = math.hypot(x, y)
        spring = force_over_radius(radius, delta0, exponent) if mode != FLIGHT else 0.0
        approach = radial_rate_of(seen) / radius if spring else 0.0
        secant = spring * (1.0 + damping * approach) if mode != LOOSE else 0.0
        angle, turning.omega = spinning.spin_at(time, state)
        rate[X], rate[Y] = vx, vy
        at = Moment((x, y), (vx, vy), (x, y), (math.cos(angle), math.sin(angle)), (0.0, -1.0))
        rate[VX], rate[VY] = accelerations(at, secant, turning)
        rate[IMPULSE] = secant * radius
        if state.size > LOST:
            rate[LOST] = (secant - spring) * radius * approach
        held = 0.0
        if state.size > HEAT:
            held = hold_of_rolling(spinning, time, seen) if mode == ROLLING else 0.0
            across = friction * secant + held / radius if radius > 0.0 else 0.0
            rate[VX] += across * y
            rate[VY] -= across * x
            drag = friction * secant * radius
            slip = slip_of(spinning, time, seen) if mode in SLIDING else 0.0
            rate[HEAT], rate[SLID] = drag * slip, mode * slip
        if state.size > GAINED:
            _turn_faster(spinning, time, seen, rate, (secant, friction * secant * radius + held))

    return rates


def _turn_faster(
    spinning: SpinningRotor, time: float, state: Values, rate: Values, force: tuple[float, float]
) -> None:
    """Add the contribution of a changing speed, given N/|z| and T."""
    spin, (secant, across) = spinning.spin, force
    angle, speed = spinning.spin_at(time, state)
    resisted = reaction_of(spinning, time, state, secant)
    if across:
        resisted += across * lever_of(spinning, time, state)
    faster = spin.acceleration(speed, resisted)
    rate[VX] += faster * math.sin(angle)
    rate[VY] -= faster * math.cos(angle)
    vx, vy = float(state[VX]), float(state[VY])
    given = (spinning.inertia * faster + resisted) * speed
    spent = 2.0 * spinning.rotor.zeta * (vx * vx + vy * vy) + rate[LOST] + rate[HEAT]
    rate[GAINED] = given - spent
    if state.size > SPEED:
        rate[ANGLE], rate[SPEED] = speed, faster


def reaction_of(spinning: SpinningRotor, time: float, state: Values, secant: float) -> float:
    """Return ``R``, the moment of damping, shaft and normal force against the spin."""
    rotor, (x, y, vx, vy) = spinning.rotor, state[:IMPULSE].tolist()
    angle, _ = spinning.spin_at(time, state)
    cos, sin = math.cos(angle), math.sin(angle)
    stiffness = rotor.shaft_stiffness + secant
    return float(-2.0 * rotor.zeta * (cos * vy - sin * vx) - stiffness * (cos * y - sin * x))


def lever_of(spinning: SpinningRotor, time: float, state: Values) -> float:
    """Return ``rho - cos(theta - phi)``, the lever of T about the centre of mass."""
    angle, _ = spinning.spin_at(time, state)
    ahead = (math.cos(angle) * float(state[X]) + math.sin(angle) * float(state[Y])) / radius_of(
        state
    )
    return (spinning.rotor.disc_radius or 0.0) - ahead


def energy_of(spinning: SpinningRotor, time: float, state: Values) -> float:
    """Return the energy of the motion of the centre of mass, the spin, the springs and the load."""
    rotor, (x, y, vx, vy) = spinning.rotor, state[:IMPULSE].tolist()
    angle, speed = spinning.spin_at(time, state)
    cos, sin = math.cos(angle), math.sin(angle)
    motion = (vx - speed * sin) ** 2 + (vy + speed * cos) ** 2 + spinning.inertia * speed**2
    springs = 0.5 * rotor.shaft_stiffness * (x * x + y * y)
    springs += float(contact_potential(math.hypot(x, y), rotor.delta0, rotor.contact_exponent))
    return float(0.5 * motion + springs + rotor.load * (y + sin))


def slip_of(spinning: SpinningRotor, time: float, state: Values) -> float:
    """Return the slip speed ``v_s = v_t + rho theta'``."""
    around = float(state[X] * state[VY] - state[Y] * state[VX])
    return around / radius_of(state) + spinning.rim_speed(time, state)


def rolled(spinning: SpinningRotor, time: float, state: Values) -> Values:
    """Return a state with the tangential velocity of rolling, ``-rho theta'``."""
    rise, radius, exact = radial_rate_of(state), radius_of(state), state.copy()
    rim = spinning.rim_speed(time, state)
    exact[VX] = (rise * state[X] / radius + rim * state[Y]) / radius
    exact[VY] = (rise * state[Y] / radius - rim * state[X]) / radius
    return exact


def hold_of_rolling(spinning: SpinningRotor, time: float, state: Values) -> float:
    """Return the force F that rolling needs.

    ``F = theta'**2 sin(theta - phi) - gamma cos phi + V (2 zeta + r'/r)
    + theta'' (rho - cos(theta - phi))``.
    """
    rotor, spin = spinning.rotor, spinning.spin
    x, y, radius = float(state[X]), float(state[Y]), radius_of(state)
    angle, speed = spinning.spin_at(time, state)
    rim = (rotor.disc_radius or 0.0) * speed
    drive = speed**2 * (math.sin(angle) * x - math.cos(angle) * y) - rotor.load * x
    hold = drive / radius + rim * (2.0 * rotor.zeta + radial_rate_of(state) / radius**2)
    if isinstance(spin, Steady):
        return hold
    lever = lever_of(spinning, time, state)
    push = force_over_radius(radius, rotor.delta0, rotor.contact_exponent)
    resisted = reaction_of(spinning, time, state, push * hold_of(rotor, state))
    return hold + lever * float(spin.acceleration(speed, resisted + hold * lever, lever**2))


def hidden_slip(spinning: SpinningRotor, time: float, state: Values) -> float:
    """Return the slip speed below which it is rounding."""
    speed = math.hypot(state[VX], state[VY])
    return HIDDEN * (float(speed) + spinning.rim_speed(time, state))


def hidden_hold(spinning: SpinningRotor, time: float, state: Values) -> float:
    """Return the size of `hold_of_rolling` below which it is rounding."""
    rotor, spin = spinning.rotor, spinning.spin
    speed, rim = spinning.spin_at(time, state)[1], spinning.rim_speed(time, state)
    turning = 2.0 * rotor.zeta + abs(radial_rate_of(state)) / radius_of(state) ** 2
    size = speed**2 + rotor.load + rim * turning
    if not isinstance(spin, Steady):
        push = force_over_radius(radius_of(state), rotor.delta0, rotor.contact_exponent)
        resisted = reaction_of(spinning, time, state, push * hold_of(rotor, state))
        size += abs(spin.acceleration(speed, resisted)) * ((rotor.disc_radius or 0.0) + 1.0)
    return HIDDEN * size


def pressed_mode(
    spinning: SpinningRotor, time: float, state: Values, slip: float | None = None
) -> int:
    """Decide the mode of a pressed contact: sliding if it slips or the grip is not enough.

    `slip` is exactly 0 where the disc is known not to slip.
    """
    if spinning.rotor.friction == 0.0:
        return PRESSED
    sliding = slip_of(spinning, time, state) if slip is None else slip
    if abs(sliding) > hidden_slip(spinning, time, state):
        return FORWARDS if sliding > 0.0 else BACKWARDS
    rolling = rolled(spinning, time, state)
    hold = hold_of_rolling(spinning, time, rolling)
    grip = spinning.rotor.friction * force_of(spinning.rotor, state)
    if abs(hold) <= grip + hidden_hold(spinning, time, rolling):
        return ROLLING
    return FORWARDS if hold > 0.0 else BACKWARDS


def mode_of_start(spinning: SpinningRotor, start: State) -> int:
    """Decide the mode at time 0; a contact in which the force would pull is loose."""
    if not starts_in_contact(spinning, start):
        return FLIGHT
    rotor, state = spinning.rotor, first_state(spinning, start)
    held = hold_of(rotor, state)
    if held == 0.0 and radius_of(state) > rotor.delta0:  # what it is about to become
        rate = np.empty_like(state)
        rates_of(spinning, LOOSE)(0.0, state, rate)
        held = hold_of(rotor, state + math.sqrt(HIDDEN) * rate)
    return pressed_mode(spinning, 0.0, state) if held > 0.0 else LOOSE


def first_state(spinning: SpinningRotor, start: State) -> Values:
    """Return the state with which a run begins."""
    rotor, spin = spinning.rotor, spinning.spin
    if isinstance(spin, Driven):
        return np.array([*start, *6 * (0.0,), rotor.omega])
    if not isinstance(spin, Steady):
        return np.array([*start, *5 * (0.0,)])
    more = 4 if rotor.friction > 0.0 else 2 if rotor.contact_damping > 0.0 else 1
    return np.array([*start, *more * (0.0,)])


def starts_in_contact(spinning: SpinningRotor, start: State) -> bool:
    """Decide whether a start at time 0 is in contact.

    On the stator the first nonzero one of radial velocity, acceleration and jerk decides, without
    the force: outwards means contact. Where all vanish the rotor whirls along the stator, which
    counts as flight.
    """
    rotor = spinning.rotor
    z, v = complex(start[0], start[1]), complex(start[2], start[3])
    if rotor.delta0 == 0.0 or abs(abs(z) - rotor.delta0) > 4.0 * ROUNDING * abs(z):
        return abs(z) >= rotor.delta0
    zeta, kappa, speed = rotor.zeta, rotor.shaft_stiffness, rotor.omega
    spin, jolt = spinning.spin, 0.0
    faster = float(spin.acceleration(speed, -2.0 * zeta * v.imag - kappa * z.imag))
    a = complex(speed**2, -faster) - 2.0 * zeta * v - kappa * z - 1j * rotor.load
    if isinstance(spin, Driven):
        of_reaction = -2.0 * zeta * (a - 1j * speed * v) - kappa * (v - 1j * speed * z)
        jolt = -(spin.slope * faster + of_reaction.imag) / spin.inertia
    drive = complex(3.0 * speed * faster, speed**3 - jolt)
    b = drive - 2.0 * zeta * a - kappa * v
    derivatives = [  # of |z|**2/2, each a sum of products
        [(z, v)],
        [(v, v), (z, a)],
        [(v, a), (v, a), (v, a), (z, b)],
    ]
    for products in derivatives:
        total = sum((one.conjugate() * other).real for one, other in products)
        if abs(total) > HIDDEN * sum(abs(one * other) for one, other in products):
            return total > 0.0
    return False


def radius_of(state: Values) -> float:
    """Return |z|."""
    return math.hypot(state[X], state[Y])


def radial_rate_of(state: Values) -> float:
    """Return ``r r' = x vx + y vy``, which changes sign at an extremum of the radius."""
    return float(state[X] * state[VX] + state[Y] * state[VY])


def hold_of(rotor: Rotor, state: Values) -> float:
    """Return ``1 + c d'``, which is 0 where the contact comes loose."""
    if rotor.contact_damping == 0.0:
        return 1.0
    return 1.0 + rotor.contact_damping * radial_rate_of(state) / radius_of(state)


def force_of(rotor: Rotor, state: Values) -> float:
    """Return the normal force of a pressed contact."""
    depth = max(radius_of(state) - rotor.delta0, 0.0)
    return float(depth**rotor.contact_exponent * max(hold_of(rotor, state), 0.0))
