"""The equations of motion of one disc, stated once: the rates of change in each mode.

The forces are those of `rotor_ida.model.forces`, and the law of contact that of
`rotor_ida.model.contact`. In the whole model a contact is loose while damping would make the force
tensile; `rotor.loose` is 1 then, else 0. The exponent of the force is 3/2 where `rotor.hertz` is 1,
or 1 where `rotor.linear` is.

Friction has separate modes, so that a contact without friction is unchanged: in one the surfaces
slide, forwards or backwards as `rotor.sigma` is 1 or -1 (`rub_rates`); in the other the disc rolls
on the stator (`rolling_rates`), as long as `grip_and_hold` allows.
"""

from __future__ import annotations

from typing import Any

from rotor_ida.model.contact import drag_of, normal_force
from rotor_ida.model.forces import (
    Moment,
    Number,
    Numbers,
    accelerations,
    hold_of_rolling,
    secant,
    turned_rates,
)

CONTACT_STATE = ("q", "p", "h", "c", "s", "t", "j")
CARTESIAN_STATE = ("x", "y", "vx", "vy")


def contact_rates(state: Numbers, rotor: Any, more: Numbers = (0.0, 0.0)) -> list[Number]:
    """Return the rates of a contact by a fictitious time u, with ``dt = q du``.

    The Hertz force has a kink of order 1.5 at |z| = delta0. In ``q = sqrt(|z| - delta0)`` and u the
    motion is analytic through entry and exit; p is the radial velocity, h the angular momentum, c
    and s the direction on the rotating axes, t the time and j the impulse of the force. The
    whole model adds the components of the load's direction along the radius and across it, the
    work of the rotor on the stator (elastic energy and loss of the contact), and the energy of
    `spent_rate`, which has no series. `more` is an additional acceleration, outwards and sideways.
    """
    q, p, h, c, s, *rest = state
    whole = len(state) > len(CONTACT_STATE)
    down_r, down_t = rest[:2] if whole else (0.0, 0.0)
    square = q * q
    r = rotor.delta0 + square
    around = h / r
    spin = around / r
    force = normal_force(q, p, rotor)
    centrifugal = around * spin
    at = Moment((r, 0.0), (p, around), (1.0, 0.0), (c, -s), (down_r, down_t))
    radial, tangential = accelerations(at, force, rotor)
    outwards, sideways = radial + centrifugal + more[0], tangential + more[1]
    moment = r * sideways
    turned = q * spin
    turn = turned - rotor.omega * q
    of_q, of_p, of_h = 0.5 * p, q * outwards, q * moment
    of_c, of_s, of_j = -(s * turn), c * turn, q * force
    if not whole:
        return [of_q, of_p, of_h, of_c, of_s, q, of_j]
    of_down_r, of_down_t, of_work = turned * down_t, -(turned * down_r), of_j * p
    return [of_q, of_p, of_h, of_c, of_s, of_down_r, of_down_t, q, of_j, of_work, 0.0 * q]


def rub_rates(state: Numbers, rotor: Any, more: Numbers = (0.0, 0.0)) -> list[Number]:
    """Return the rates, by u, of a contact in which surfaces slide, like `contact_rates`.

    The moment of the slip, ``r v_s = h + V r``, replaces the angular momentum h; it passes through
    0 where the surfaces stop sliding. The last component is the heat of sliding, which has no
    series, like the energies of `spent_sliding`.
    """
    q, p, slip, c, s, down_r, down_t, *_ = state
    square = q * q
    r = rotor.delta0 + square
    slip_speed = slip / r
    around = slip_speed - rotor.rim
    spin = around / r
    force = normal_force(q, p, rotor)
    drag = drag_of(force, rotor)
    centrifugal = around * spin
    at = Moment((r, 0.0), (p, around), (1.0, 0.0), (c, -s), (down_r, down_t))
    radial, tangential = accelerations(at, force, rotor, drag)
    outwards, sideways = radial + centrifugal + more[0], tangential + more[1]
    moment = r * sideways + rotor.rim * p
    turned = q * spin
    turn = turned - rotor.omega * q
    of_q, of_p, of_slip = 0.5 * p, q * outwards, q * moment
    of_c, of_s, of_j = -(s * turn), c * turn, q * force
    of_down_r, of_down_t = turned * down_t, -(turned * down_r)
    still = 0.0 * q
    return [
        of_q, of_p, of_slip, of_c, of_s, of_down_r, of_down_t, q, of_j, of_j * p, still, still,
    ]  # fmt: skip


def rolling_rates(state: Numbers, rotor: Any, more: Numbers = (0.0, 0.0)) -> list[Number]:
    """Return the rates of a contact in which the disc rolls: its slip is 0 and stays so."""
    q, p, _, c, s, down_r, down_t, *_ = state
    square = q * q
    r = rotor.delta0 + square
    spin = -(rotor.rim / r)
    force = normal_force(q, p, rotor)
    centrifugal = -(rotor.rim * spin)
    at = Moment((r, 0.0), (p, -rotor.rim), (1.0, 0.0), (c, -s), (down_r, down_t))
    outwards = accelerations(at, force, rotor)[0] + centrifugal + more[0]
    turned = q * spin
    turn = turned - rotor.omega * q
    of_q, of_p = 0.5 * p, q * outwards
    of_c, of_s, of_j = -(s * turn), c * turn, q * force
    of_down_r, of_down_t = turned * down_t, -(turned * down_r)
    still = 0.0 * q
    return [
        of_q, of_p, still, of_c, of_s, of_down_r, of_down_t, q, of_j, of_j * p, still, still,
    ]  # fmt: skip


def grip_and_hold(state: Numbers, rotor: Any) -> list[Number]:
    """Return ``mu N`` and F: the disc rolls as long as ``|F|`` is no larger than ``mu N``."""
    q, p, _, c, s, down_r, down_t, *_ = state
    r = rotor.delta0 + q * q
    grip = rotor.friction * normal_force(q, p, rotor)
    at = Moment((r, 0.0), (p, -rotor.rim), (1.0, 0.0), (c, -s), (down_r, down_t))
    return [grip, hold_of_rolling(at, r, rotor)]


def cartesian_rates(state: Numbers, rotor: Any) -> list[Number]:
    """Return the time rates of displacement and velocity on the rotating axes.

    Where `rotor.felt` is 1 the force is that without clearance. Where it is 0 there is none: in
    flight, or so close to the centre that it is negligible. The whole model adds the direction of
    the load, which rotates backwards on these axes.
    """
    x, y, vx, vy, *down = state
    down_x, down_y = down or (0.0, 0.0)
    push = secant(x * x + y * y, rotor)
    at = Moment((x, y), (vx, vy), (x, y), (1.0, 0.0), (down_x, down_y))
    rates = turned_rates((x, y), (vx, vy), accelerations(at, push, rotor), rotor.omega)
    return [*rates, rotor.omega * down_y, -(rotor.omega * down_x)] if down else rates
