"""How a run begins: in contact or in flight, also where the rotor lies exactly on the ring.

Displacement and velocity are read on the rotating axes of the moment.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.simulation.reference import flight
from rotor_ida.simulation.reference.contact_phase import P, T, regularised

Values = npt.NDArray[np.float64]

ROUNDING = 2.0**-52
# A start that is drawn off the ring is followed in closed form to this depth, in clearances.
FIRST_DEPTH = 1e-16


def starts_in_contact(
    position: complex, velocity: complex, omega: float, zeta: float, delta0: float
) -> bool:
    """Decide the mode at a start.

    On the ring the first of radial velocity, acceleration and jerk that is not zero decides:
    outwards means contact, inwards flight. Where all vanish the rotor whirls along the ring,
    which is flight.
    """
    if delta0 == 0.0:
        return True
    radius = abs(position)
    if abs(radius - delta0) > 4.0 * ROUNDING * radius:
        return radius > delta0
    rate = _radial_velocity(position, velocity)
    if rate == 0.0:
        rate = _radial_acceleration(position, velocity, omega)
    if rate == 0.0:
        rate = _radial_jerk(position, velocity, omega, zeta)
    return rate > 0.0


def contact_start(
    position: complex, velocity: complex, left: float, omega: float, zeta: float, delta0: float
) -> Values:
    """Return the regularised state at the start of a contact that may last for `left`."""
    depth = abs(position) - delta0
    contact_root = math.sqrt(depth) if depth > 4.0 * ROUNDING * delta0 else 0.0
    if contact_root == 0.0 and _radial_velocity(position, velocity) <= 0.0:
        return _pushed_off(position, velocity, left, omega, zeta, delta0)
    return regularised(position, velocity, contact_root)


def _pushed_off(
    position: complex, velocity: complex, left: float, omega: float, zeta: float, delta0: float
) -> Values:
    """Return the state a moment after a start at radial rest that is drawn outwards.

    q = p = 0 is an equilibrium of the regularised equations. The motion leaves it with an
    indentation that grows like t**2, or t**3 where the radial acceleration vanishes too,
    unhindered so far by a force of higher order.
    """
    acceleration = max(_radial_acceleration(position, velocity, omega), 0.0)
    jerk = 0.0
    if acceleration == 0.0:
        jerk = max(_radial_jerk(position, velocity, omega, zeta), 0.0)
    depth = FIRST_DEPTH * delta0
    moment = 0.0
    if acceleration > 0.0:
        moment = min(math.sqrt(2.0 * depth / acceleration), 1e-3 * left)
    elif jerk > 0.0:
        moment = min((6.0 * depth / jerk) ** (1.0 / 3.0), 1e-3 * left)
    there, moving = flight.fly(position, velocity, moment, omega, zeta)
    indentation = (acceleration / 2.0 + jerk * moment / 6.0) * moment**2
    state = regularised(there, moving, math.sqrt(indentation))
    state[P] = (acceleration + jerk * moment / 2.0) * moment
    state[T] = moment
    return state


def _radial_velocity(position: complex, velocity: complex) -> float:
    """Return the radial velocity; 0 where rounding hides its sign."""
    along = (position.conjugate() * velocity).real / abs(position)
    return along if abs(along) > 4.0 * ROUNDING * abs(velocity) else 0.0


def _radial_acceleration(position: complex, velocity: complex, omega: float) -> float:
    """Return the radial acceleration at radial rest, without contact; 0 where rounding hides it."""
    direction = position / abs(position)
    centrifugal = (direction.conjugate() * velocity).imag ** 2 / abs(position)
    unbalance = omega**2
    total = centrifugal + unbalance * direction.real
    return total if abs(total) > 16.0 * ROUNDING * (centrifugal + unbalance) else 0.0


def _radial_jerk(position: complex, velocity: complex, omega: float, zeta: float) -> float:
    """Return the radial jerk where velocity and acceleration vanish; 0 where rounding hides it."""
    damping = 2.0 * zeta
    acceleration = omega**2 - damping * velocity
    jerk = 1j * omega**3 - damping * acceleration
    by_velocity = 3.0 * velocity.conjugate() * acceleration
    by_position = position.conjugate() * jerk
    total = (by_velocity + by_position).real / abs(position)
    size = (abs(by_velocity) + abs(by_position)) / abs(position)
    return total if abs(total) > 64.0 * ROUNDING * size else 0.0
