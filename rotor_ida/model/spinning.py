"""The modes of a rotor whose speed changes: the whole model with angle and speed as states.

The unbalance pulls with ``(theta'**2 - i theta'') exp(i theta)``. All vectors are given on axes
that rotate with it, at the current speed. So the rates are those of a constant speed, from
`rotor_ida.model.rates`, plus terms of the angular acceleration. This is prescribed, or follows from
a torque and the reaction of the motion. There are no derivatives by a start or a parameter here.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from rotor_ida.model.contact import drag_of, normal_force
from rotor_ida.model.drawn_rates import (
    drawn_contact_rates,
    drawn_rolling_rates,
    drawn_rub_rates,
)
from rotor_ida.model.forces import Number, Numbers, resistance, secant
from rotor_ida.model.modes import (
    OF_FORCES,
    ROLLING,
    RUB,
    WHOLE,
    WHOLE_CARTESIAN,
    WHOLE_CONTACT,
    Mode,
    Model,
)
from rotor_ida.model.rates import (
    cartesian_rates,
    contact_rates,
    grip_and_hold,
    rolling_rates,
    rub_rates,
)

# In a contact the speed precedes the time, which does not affect the choice of a step, and the
# angle since the contact began follows it.
TIME = WHOLE_CONTACT.state.index("t")


def spun(state: Numbers, rotor: Any) -> tuple[list[Number], Number, Any]:
    """Return the state of a contact without angle and speed, its speed, and the rotor there."""
    speed, rest = state[TIME], [*state[:TIME], state[TIME + 1], *state[TIME + 3 :]]
    return rest, speed, at_speed(speed, rotor)


def at_speed(speed: Number, rotor: Any) -> Any:
    """Return the rotor at a speed."""
    return SimpleNamespace(**vars(rotor), omega=speed, rim=rotor.disc_radius * speed)


def torque_left(pull: Number, velocity: Number, resisted: Number, rotor: Any) -> Number:
    """Return the net torque without friction, ``tau - Im(exp(-i theta) b)``.

    b is z'' without the part of the unbalance, and without the load, which acts at the centre of
    mass. `pull` is the force of shaft and stator, and `velocity` that of the centre, both along the
    direction a quarter turn ahead of the unbalance; `resisted` is the value of `resistance`.
    """
    return rotor.torque - rotor.slope * rotor.omega + resisted * velocity + pull


def torque_in_contact(state: Numbers, around: Number, rotor: Any) -> Number:
    """Return `torque_left` in a contact with a tangential velocity `around`."""
    q, p, _, c, s, *_ = state
    force = normal_force(q, p, rotor)
    pull = force * s + rotor.shaft_stiffness * ((rotor.delta0 + q * q) * s)
    return torque_left(pull, p * s + around * c, resistance((p, around), rotor), rotor)


def joined(rates: list[Number], q: Number, faster: Number, speed: Number) -> list[Number]:
    """Return rates of a contact with those of speed and angle inserted."""
    return [*rates[:TIME], q * faster, rates[TIME], q * speed, *rates[TIME + 1 :]]


def spent_turning(state: Numbers, around: Number, faster: Number, here: Any) -> Number:
    """Return the contribution of a changing speed to `rotor_ida.model.drawn_rates.spent_rate`.

    It is ``q theta'' (w + h + theta' x)``: w is the velocity of the centre ahead of the
    unbalance, h its angular momentum, and x its displacement along the unbalance.
    """
    q, p, _, c, s, *_ = state
    r = here.delta0 + q * q
    return q * faster * (p * s + around * c + r * around + here.omega * (r * c))


def spinning_contact(state: Numbers, rotor: Any, *, drawn: bool = False) -> list[Number]:
    """Return the rates of a contact without friction, by u."""
    rest, speed, here = spun(state, rotor)
    q, _, h, c, s, *_ = rest
    r = rotor.delta0 + q * q
    around = h / r
    left = torque_in_contact(rest, around, here)
    faster = rotor.rate + rotor.inverse_inertia * left
    more = (-(faster * s), -(faster * c))  # of -i theta'' exp(i theta)
    rates = (drawn_contact_rates if drawn else contact_rates)(rest, here, more)
    if drawn:
        rates[-1] = rates[-1] + spent_turning(rest, around, faster, here)
    return joined(rates, q, faster, speed)


def spinning_rub(state: Numbers, rotor: Any, *, drawn: bool = False) -> list[Number]:
    """Return the rates of a contact in which surfaces slide.

    The slip ``v_t + rho theta'`` grows with the speed of the rim as well.
    """
    rest, speed, here = spun(state, rotor)
    q, p, slip, c, s, *_ = rest
    r = rotor.delta0 + q * q
    around = slip / r - here.rim
    lever = rotor.disc_radius - c
    drag = drag_of(normal_force(q, p, rotor), rotor)
    left = torque_in_contact(rest, around, here) - drag * lever
    faster = rotor.rate + rotor.inverse_inertia * left
    more = (-(faster * s), faster * lever)
    rates = (drawn_rub_rates if drawn else rub_rates)(rest, here, more)
    if drawn:
        rates[-2] = rates[-2] + spent_turning(rest, around, faster, here)
    return joined(rates, q, faster, speed)


def held(rest: Numbers, here: Any, rotor: Any) -> tuple[Number, Number, Number]:
    """Return ``theta''`` of a disc that rolls, the rolling force F, and its grip ``mu N``.

    ``F = F0 + lambda theta''``, where F0 is the force at constant speed and
    ``lambda = rho - cos(theta - phi)``, so that ``(j + lambda**2) theta'' = tau - R - lambda F0``.
    """
    c = rest[3]
    grip, hold = grip_and_hold(rest, here)
    lever = rotor.disc_radius - c
    left = torque_in_contact(rest, -here.rim, here) - hold * lever
    moved = 1.0 + rotor.inverse_inertia * (lever * lever)
    faster = (rotor.rate + rotor.inverse_inertia * left) / moved
    return faster, hold + lever * faster, grip


def spinning_roll(state: Numbers, rotor: Any, *, drawn: bool = False) -> list[Number]:
    """Return the rates of a contact in which the disc rolls: its slip stays 0."""
    rest, speed, here = spun(state, rotor)
    q, r = rest[0], rotor.delta0 + rest[0] * rest[0]
    faster, hold, _ = held(rest, here, rotor)
    more = (-(faster * rest[4]), 0.0)
    rates = (drawn_rolling_rates if drawn else rolling_rates)(rest, here, more)
    if drawn:
        turning = spent_turning(rest, -here.rim, faster, here)
        added = hold - grip_and_hold(rest, here)[1]
        rates[-2] = rates[-2] + turning - q * added * (here.rim + speed * r)
    return joined(rates, q, faster, speed)


def spinning_grip(state: Numbers, rotor: Any) -> list[Number]:
    """Return ``mu N`` and F: the disc rolls as long as ``|F|`` is no larger than ``mu N``."""
    rest, _, here = spun(state, rotor)
    _, hold, grip = held(rest, here, rotor)
    return [grip, hold]


def spinning_cartesian(state: Numbers, rotor: Any) -> list[Number]:
    """Return the time rates of displacement and velocity, and of speed and angle."""
    *rest, speed, _ = state
    here = at_speed(speed, rotor)
    x, y, vx, vy, *_ = rest
    pull = secant(x * x + y * y, rotor) * y + rotor.shaft_stiffness * y
    left = torque_left(pull, vy, resistance((vx, vy), here), here)
    faster = rotor.rate + rotor.inverse_inertia * left
    rates = cartesian_rates(rest, here)
    rates[3] = rates[3] - faster
    return [*rates, faster, 1.0 * speed]


def _spinning(mode: Mode, rates: Any, watched: Any = None) -> Mode:
    """Return a mode of the whole model for a rotor whose speed changes."""
    before, behind = mode.state[:TIME], mode.state[TIME:]
    return replace(
        mode,
        state=(*before, "speed", *behind[:1], "angle", *behind[1:]),
        rates=rates,
        neighbour=None,
        drawn_rates=rates if mode is WHOLE_CARTESIAN else _drawn(rates),
        watched=watched,
    )


def _drawn(rates: Any) -> Any:
    return lambda state, rotor: rates(state, rotor, drawn=True)


# Parameters of the drive: the rate of a prescribed speed, or torque, slope and 1/j.
OF_DRIVE = ("rate", "torque", "slope", "inverse_inertia")
# Fixed parameters for a prescribed speed, and for the paper's rotor with or without friction, where
# the work on the stator is the elastic energy of the contact.
PRESCRIBED = dict.fromkeys(("torque", "slope", "inverse_inertia"), 0.0)
PLAIN = {
    **dict.fromkeys((*OF_FORCES, "linear", "loose"), 0.0),
    "hertz": 1.0,
    **dict.fromkeys(("down_r", "down_t", "down_x", "down_y", "work"), 0.0),
}
RUN_UP = Model(
    name="run_up",
    modes=(
        _spinning(WHOLE_CONTACT, spinning_contact),
        _spinning(WHOLE_CARTESIAN, spinning_cartesian),
        _spinning(RUB, spinning_rub),
        _spinning(ROLLING, spinning_roll, spinning_grip),
    ),
    parameters=(*(name for name in WHOLE.parameters if name not in {"omega", "rim"}), *OF_DRIVE),
    constants={},
    columns=(),
    lighter={"prescribed": PRESCRIBED, "plain": PRESCRIBED | PLAIN},
)
