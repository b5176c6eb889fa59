"""The model, stated once: how a rotor moves in contact, and where nothing has to be smoothed.

A mode is a state, its rate of change, and guards: components of the state that pass through 0 where
the mode ends, or where something else is to be told. All are plain Python, of sums, products,
quotients and constant powers alone. Run over numbers they are the model itself. Run once over
symbols they become what the compiled core needs (`rotor_ida.equations.writing`): fields and
Jacobians, Taylor series, the growth of small differences, and what the parameters add.

A force is stated by one component, along any direction that is given: the same lines serve on
the rotating axes and in the polar basis of a contact.

References
----------
.. [1] "Analytical Nonlinear Response for a Rotor with the Hertz Contact and Clearance",
   Mechanika 25(6), 2019, eq. (10).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from rotor_ida.equations.contact import force_of_root, secant_of_square, stiffness_of_root

# How fast a direction is drawn back to the unit circle, in parts of the spin: a pull as fast as the
# motion cost Adams a sixth more steps, and this one cost none.
PULL = 0.1
# A number, or whatever can be added, multiplied, divided and raised to a constant power like one.
Number = Any
Numbers = Sequence[Number]


class Along(NamedTuple):
    """Components along one direction.

    Parameters
    ----------
    position, velocity : number
        Of the disc's centre and its velocity [1].
    normal : number
        Of the direction from the bearing axis to the disc's centre [1].
    unbalance : number
        Of the direction of the unbalance [1].
    """

    position: Number
    velocity: Number
    normal: Number
    unbalance: Number


@dataclass(frozen=True, slots=True)
class Guard:
    """A component of the state that says when something happens: its series is the guard's.

    Parameters
    ----------
    event : str
        What happens where it passes through 0.
    of : str
        Which component it is.
    """

    event: str
    of: str


@dataclass(frozen=True, slots=True)
class Mode:
    """One way to move.

    Parameters
    ----------
    name : str
        What it is called in derived code.
    state : tuple of str
        Names of the components of its state.
    rates : callable
        ``rates(state, rotor)`` returns the rate of change of each component. A rotor is whatever
        has its parameters as attributes.
    neighbour : callable
        ``neighbour(state, apart, deeper, rotor)`` returns position, velocity and acceleration of a
        rotor that is a little `apart`, with an indentation `deeper` by so much, and the rate at
        which the basis of all these turns; to first order.
    pace : callable
        ``pace(state)``: time by the variable of integration.
    guards : tuple of Guard
        What may happen.
    drawn_rates : callable
        As `rates`, and what draws the state back to where it belongs: for an integrator that
        cannot put it there after a step.
    """

    name: str
    state: tuple[str, ...]
    rates: Callable[[Numbers, Any], list[Number]]
    neighbour: Callable[[Numbers, Numbers, Number, Any], Neighbour]
    pace: Callable[[Numbers], Number]
    guards: tuple[Guard, ...]
    drawn_rates: Callable[[Numbers, Any], list[Number]]


class Neighbour(NamedTuple):
    """Position, velocity and acceleration, by components in one basis, and how fast this turns."""

    position: tuple[Number, Number]
    velocity: tuple[Number, Number]
    acceleration: tuple[Number, Number]
    turning: Number


def acceleration(along: Along, push: Number, rotor: Any) -> Number:
    """Return one component of ``z'' = omega**2 e - 2 zeta z' - f z/|z|`` [1].

    `push` is the normal force f, and ``along.normal`` the component of ``z/|z|``; or f/|z| and that
    of z, where |z| may vanish.
    """
    return (
        rotor.omega * rotor.omega * along.unbalance
        - 2.0 * rotor.zeta * along.velocity
        - push * along.normal
    )


def turned_rates(
    position: Numbers, velocity: Numbers, force: Numbers, turning: Number
) -> list[Number]:
    """Return the rates of position and velocity, of which the components turn with their basis."""
    return [
        velocity[0] + turning * position[1],
        velocity[1] - turning * position[0],
        force[0] + turning * velocity[1],
        force[1] - turning * velocity[0],
    ]


def contact_rates(state: Numbers, rotor: Any) -> list[Number]:
    """Return the rates of a contact by a fictitious time u, with ``dt = q du``.

    The Hertz force has a kink of order 1.5 at |z| = delta0. In ``q = sqrt(|z| - delta0)`` and u the
    motion is analytic through entry and exit; p is the radial velocity, h the angular momentum, c
    and s the direction on the rotating axes, t the time and j the impulse of the force.
    """
    q, p, h, c, s, _t, _j = state
    square = q * q
    r = rotor.delta0 + square
    around = h / r
    spin = around / r
    force = force_of_root(q)
    centrifugal = around * spin
    outwards = acceleration(Along(r, p, 1.0, c), force, rotor) + centrifugal
    sideways = acceleration(Along(0.0, around, 0.0, -s), force, rotor)
    moment = r * sideways
    turned = q * spin
    turn = turned - rotor.omega * q
    return [0.5 * p, q * outwards, q * moment, -(s * turn), c * turn, q, q * force]


def drawn_contact_rates(state: Numbers, rotor: Any) -> list[Number]:
    """Return the rates of a contact, with c and s drawn back to the unit circle.

    Errors of single steps would carry them off it in a long contact, and with their length the
    unbalance would change. What is left of ``c**2 + s**2 - 1`` falls like ``exp(-0.2 omega t)``.
    """
    q, _p, _h, c, s, _t, _j = state
    pull = PULL * rotor.omega * q * (1.0 - (c * c + s * s))
    of_q, of_p, of_h, of_c, of_s, of_t, of_j = contact_rates(state, rotor)
    return [of_q, of_p, of_h, of_c + pull * c, of_s + pull * s, of_t, of_j]


def contact_neighbour(state: Numbers, apart: Numbers, deeper: Number, rotor: Any) -> Neighbour:
    """Return a rotor a little apart from one in contact, in the polar basis of the latter."""
    q, p, h, c, s, _t, _j = state
    r = rotor.delta0 + q * q
    around = h / r
    spin = around / r
    position = (r + apart[0], apart[1])
    velocity = (p + apart[2], around + apart[3])
    push = force_of_root(q) + stiffness_of_root(q) * deeper
    radial = Along(position[0], velocity[0], 1.0, c)
    tangential = Along(position[1], velocity[1], apart[1] / r, -s)
    forces = (acceleration(radial, push, rotor), acceleration(tangential, push, rotor))
    return Neighbour(position, velocity, forces, spin)


def cartesian_rates(state: Numbers, rotor: Any) -> list[Number]:
    """Return the rates by time of displacement and velocity, read on the rotating axes.

    The force is that without clearance where `rotor.felt` is 1. Where it is 0 there is none: in
    flight, or so close to the centre that it cannot be felt.
    """
    x, y, vx, vy = state
    square = x * x + y * y
    root = secant_of_square(square)
    secant = rotor.felt * root
    ax = acceleration(Along(x, vx, x, 1.0), secant, rotor)
    ay = acceleration(Along(y, vy, y, 0.0), secant, rotor)
    return turned_rates((x, y), (vx, vy), (ax, ay), rotor.omega)


def cartesian_neighbour(state: Numbers, apart: Numbers, _deeper: Number, rotor: Any) -> Neighbour:
    """Return a rotor a little apart, on the rotating axes; without clearance none is deeper."""
    x, y, vx, vy = (here + more for here, more in zip(state, apart, strict=True))
    secant = rotor.felt * secant_of_square(x * x + y * y)
    ax = acceleration(Along(x, vx, x, 1.0), secant, rotor)
    ay = acceleration(Along(y, vy, y, 0.0), secant, rotor)
    return Neighbour((x, y), (vx, vy), (ax, ay), rotor.omega)


CONTACT = Mode(
    name="contact",
    state=("q", "p", "h", "c", "s", "t", "j"),
    rates=contact_rates,
    neighbour=contact_neighbour,
    pace=lambda state: state[0],
    guards=(
        Guard(event="exit", of="q"),
        Guard(event="extremum", of="p"),
    ),
    drawn_rates=drawn_contact_rates,
)
CARTESIAN = Mode(
    name="cartesian",
    state=("x", "y", "vx", "vy"),
    rates=cartesian_rates,
    neighbour=cartesian_neighbour,
    pace=lambda _state: 1.0,
    guards=(),
    drawn_rates=cartesian_rates,
)
MODES = (CONTACT, CARTESIAN)
