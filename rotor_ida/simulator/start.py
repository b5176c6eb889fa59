"""How a run begins: in contact or in flight, also where the rotor lies exactly on the ring.

Displacement and velocity are read on the rotating axes of the moment.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.parameters import Rotor
from rotor_ida.simulator import contact_phase, flight

Values = npt.NDArray[np.float64]

ROUNDING = 2.0**-52
# A start that is drawn off the ring is followed in closed form to this depth, in clearances.
FIRST_DEPTH = 1e-16


def starts_in_contact(rotor: Rotor, position: complex, velocity: complex) -> bool:
    """Decide the mode at a start.

    On the ring the first of radial velocity, acceleration and jerk that is not zero decides:
    outwards means contact, inwards flight. Where all vanish the rotor whirls along the ring,
    which is flight.
    """
    if rotor.delta0 == 0.0:
        return True
    radius = abs(position)
    if abs(radius - rotor.delta0) > 4.0 * ROUNDING * radius:
        return radius > rotor.delta0
    rates = (
        _radial_velocity(position, velocity),
        _radial_acceleration(rotor, position, velocity),
        _radial_jerk(rotor, position, velocity),
    )
    return next((rate > 0.0 for rate in rates if rate != 0.0), False)


def contact_start(rotor: Rotor, position: complex, velocity: complex, left: float) -> Values:
    """Return the regularised state at the start of a contact that may last for `left`."""
    depth = abs(position) - rotor.delta0
    root = math.sqrt(depth) if depth > 4.0 * ROUNDING * rotor.delta0 else 0.0
    if root == 0.0 and _radial_velocity(position, velocity) <= 0.0:
        return _pushed_off(rotor, position, velocity, left)
    return contact_phase.regularised(position, velocity, root)


def _pushed_off(rotor: Rotor, position: complex, velocity: complex, left: float) -> Values:
    """Return the state a moment after a start at radial rest that is drawn outwards.

    q = p = 0 is an equilibrium of the regularised equations. The motion leaves it with an
    indentation that grows like t**2, or t**3 where the radial acceleration vanishes too,
    unhindered so far by a force of higher order.
    """
    acceleration = max(_radial_acceleration(rotor, position, velocity), 0.0)
    jerk = max(_radial_jerk(rotor, position, velocity), 0.0) if acceleration == 0.0 else 0.0
    depth = FIRST_DEPTH * rotor.delta0
    moment = 0.0
    if acceleration > 0.0:
        moment = min(math.sqrt(2.0 * depth / acceleration), 1e-3 * left)
    elif jerk > 0.0:
        moment = min(math.cbrt(6.0 * depth / jerk), 1e-3 * left)
    there = flight.fly(position, velocity, moment, rotor.omega, rotor.zeta)
    indentation = (acceleration / 2.0 + jerk * moment / 6.0) * moment**2
    state = contact_phase.regularised(*there, math.sqrt(indentation))
    state[contact_phase.P] = (acceleration + jerk * moment / 2.0) * moment
    state[contact_phase.T] = moment
    return state


def _radial_velocity(position: complex, velocity: complex) -> float:
    """Return the radial velocity; 0 where rounding hides its sign."""
    along = (position.conjugate() * velocity).real / abs(position)
    return along if abs(along) > 4.0 * ROUNDING * abs(velocity) else 0.0


def _radial_acceleration(rotor: Rotor, position: complex, velocity: complex) -> float:
    """Return the radial acceleration at radial rest, without contact; 0 where rounding hides it."""
    direction = position / abs(position)
    centrifugal = (direction.conjugate() * velocity).imag ** 2 / abs(position)
    unbalance = rotor.omega**2
    total = centrifugal + unbalance * direction.real
    return total if abs(total) > 16.0 * ROUNDING * (centrifugal + unbalance) else 0.0


def _radial_jerk(rotor: Rotor, position: complex, velocity: complex) -> float:
    """Return the radial jerk where velocity and acceleration vanish; 0 where rounding hides it."""
    omega, damping = rotor.omega, 2.0 * rotor.zeta
    acceleration = omega**2 - damping * velocity
    jerk = 1j * omega**3 - damping * acceleration
    parts = (3.0 * velocity.conjugate() * acceleration, position.conjugate() * jerk)
    total = (parts[0] + parts[1]).real / abs(position)
    size = (abs(parts[0]) + abs(parts[1])) / abs(position)
    return total if abs(total) > 64.0 * ROUNDING * size else 0.0
