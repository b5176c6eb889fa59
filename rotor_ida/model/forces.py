"""The forces on a rotor, over numbers or symbols.

The equations of motion have them once, in `accelerations`, by components along any two directions:
the same lines serve on fixed axes, on the rotating ones and in the polar basis of a contact. What
is not an equation of motion has them again: flight in closed form, the energy check, the energy
that a contact loses (`spent_rate` in `rotor_ida.model.drawn_rates`) and the closed forms.
CONTRIBUTING.md lists these places ("A force"). Besides its parameters `rotor` has switches, 1 or 0:
`hertz` or `linear` for the law of contact, `loose` where contact damping leaves no force, and
`felt` where there is contact at all.

References
----------
.. [1] "Analytical Nonlinear Response for a Rotor with the Hertz Contact and Clearance",
   Mechanika 25(6), 2019, eq. (10).
"""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

from rotor_ida.model.contact import secant_of_square
from rotor_ida.model.parameters import ALL_PARAMETERS

# A number, or any object with sums, products, quotients and constant powers.
Number = Any
Numbers = Sequence[Number]
Pair = tuple[Number, Number]


class Moment(NamedTuple):
    """A rotor at one time, by components along two directions; the second is to the left.

    Parameters
    ----------
    position, velocity : tuple of number
        Displacement and velocity of the disc's centre [dimensionless].
    normal : tuple of number
        Direction from the bearing axis to the disc's centre [dimensionless].
    unbalance : tuple of number
        Direction of the unbalance [dimensionless].
    down : tuple of number
        Direction of the load [dimensionless].
    """

    position: Pair
    velocity: Pair
    normal: Pair
    unbalance: Pair = (0.0, 0.0)
    down: Pair = (0.0, 0.0)


def with_values(rotor: Any, **values: Number) -> SimpleNamespace:
    """Return the parameters of a `Rotor`, for the functions below, some with other values."""
    given = {name: getattr(rotor, name) for name in ALL_PARAMETERS}
    return SimpleNamespace(**given | values)


def accelerations(at: Moment, push: Number, rotor: Any, drag: Number = 0.0) -> Pair:
    """Return both components of z'' [dimensionless]: the one statement of all forces.

    ``z'' = omega**2 e - 2 zeta z' - kappa z - (N + i T) z/|z| + gamma g``, with the directions e
    and g of unbalance and load. `push` is the normal force N, `drag` the tangential force T, and
    ``at.normal`` is ``z/|z|``. Where |z| may vanish they are N/|z|, T/|z| and z.
    """
    return (
        _along(0, at, push, rotor) + drag * at.normal[1],
        _along(1, at, push, rotor) - drag * at.normal[0],
    )


def resistance(velocity: Pair, rotor: Any) -> Number:
    """Return the resistance of the surroundings, as force over velocity [dimensionless].

    It enters the accelerations, the energy that a contact dissipates, and the net torque of a
    drive. `velocity` has components along any two directions.
    """
    del velocity  # linear damping does not depend on it; a nonlinear one would
    return 2.0 * rotor.zeta


def _along(i: int, at: Moment, push: Number, rotor: Any) -> Number:
    """Return a component of the acceleration without friction."""
    return (
        rotor.omega * rotor.omega * at.unbalance[i]
        - resistance(at.velocity, rotor) * at.velocity[i]
        - push * at.normal[i]
        - rotor.shaft_stiffness * at.position[i]
        + rotor.load * at.down[i]
    )


def secant(square: Number, rotor: Any) -> Number:
    """Return force over distance without clearance, as a function of ``|z|**2`` [dimensionless]."""
    return rotor.felt * (rotor.hertz * secant_of_square(square) + rotor.linear)


def turned_rates(
    position: Numbers, velocity: Numbers, force: Numbers, turning: Number
) -> list[Number]:
    """Return the rates of position and velocity whose components rotate with their basis."""
    return [
        velocity[0] + turning * position[1],
        velocity[1] - turning * position[0],
        force[0] + turning * velocity[1],
        force[1] - turning * velocity[0],
    ]


def hold_of_rolling(at: Moment, r: Number, rotor: Any) -> Number:
    """Return the tangential force F that rolling needs, from components with the radius first [1].

    While the disc rolls, ``r phi' = -V`` with ``V = rho omega``, so that the angular momentum
    ``h = -V r`` changes at the rate ``-V r'``; F is the force for this rate.
    """
    return accelerations(at, 0.0, rotor)[1] + rotor.rim * at.velocity[0] / r
