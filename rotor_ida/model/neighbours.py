"""What small differences from a motion do: a neighbour of one disc in each mode, to first order."""

from __future__ import annotations

from typing import Any, NamedTuple

from rotor_ida.model.contact import damped, drag_of, slope_of_root, spring_of_root
from rotor_ida.model.forces import Moment, Number, Numbers, accelerations, secant
from rotor_ida.model.rates import CONTACT_STATE


class Neighbour(NamedTuple):
    """Position, velocity and acceleration in one basis, and its rate of rotation."""

    position: tuple[Number, Number]
    velocity: tuple[Number, Number]
    acceleration: tuple[Number, Number]
    turning: Number


def contact_neighbour(state: Numbers, apart: Numbers, deeper: Number, rotor: Any) -> Neighbour:
    """Return a neighbour of a rotor in contact, in the polar basis of the latter."""
    q, _, h, *_ = state
    r = rotor.delta0 + q * q
    around = h / r
    near, push = _apart(state, around, apart, deeper, rotor)
    spin = around / r
    return Neighbour(near.position, near.velocity, accelerations(near, push, rotor), spin)


def rub_neighbour(state: Numbers, apart: Numbers, deeper: Number, rotor: Any) -> Neighbour:
    """Return a neighbour of a rotor whose surfaces slide."""
    q, _, slip, *_ = state
    r = rotor.delta0 + q * q
    around = slip / r - rotor.rim
    near, push = _apart(state, around, apart, deeper, rotor)
    drag = drag_of(push, rotor)
    forces = accelerations(near, push, rotor, drag)
    return Neighbour(near.position, near.velocity, forces, around / r)


def rolling_neighbour(state: Numbers, apart: Numbers, deeper: Number, rotor: Any) -> Neighbour:
    """Return a neighbour of a rolling rotor; its slip is constant too."""
    r = rotor.delta0 + state[0] * state[0]
    around = -rotor.rim
    near, push = _apart(state, around, apart, deeper, rotor)
    aside = near.normal[1]
    outwards, sideways = accelerations(near, 0.0, rotor)  # without the contact
    rim = rotor.disc_radius * rotor.omega  # differentiated; the motion's own rim speed is fixed
    rises = near.velocity[0] + around * aside
    hold = sideways - aside * outwards + rim * rises / near.position[0]
    forces = accelerations(near, push, rotor, hold)
    return Neighbour(near.position, near.velocity, forces, around / r)


def cartesian_neighbour(state: Numbers, apart: Numbers, _deeper: Number, rotor: Any) -> Neighbour:
    """Return a neighbour on the rotating axes; without clearance none is deeper."""
    x, y, vx, vy = (here + more for here, more in zip(state[:4], apart, strict=True))
    down_x, down_y = state[4:] or (0.0, 0.0)
    push = secant(x * x + y * y, rotor)
    at = Moment((x, y), (vx, vy), (x, y), (1.0, 0.0), (down_x, down_y))
    return Neighbour((x, y), (vx, vy), accelerations(at, push, rotor), rotor.omega)


def _apart(
    state: Numbers, around: Number, apart: Numbers, deeper: Number, rotor: Any
) -> tuple[Moment, Number]:
    """Return a neighbour of a contact, and its normal force."""
    q, p, _, c, s, *rest = state
    down_r, down_t = rest[:2] if len(state) > len(CONTACT_STATE) else (0.0, 0.0)
    r = rotor.delta0 + q * q
    position, velocity = (r + apart[0], apart[1]), (p + apart[2], around + apart[3])
    aside = apart[1] / r
    push = spring_of_root(q, rotor) + slope_of_root(q, rotor) * deeper
    push = damped(push, velocity[0] + around * aside, rotor)
    return Moment(position, velocity, (1.0, aside), (c, -s), (down_r, down_t)), push
