"""What an integrator needs beside the equations of motion of `rotor_ida.model.rates`.

The rates of the energy that damping, load and friction take from a contact, by which its balance is
checked; and the rates of a contact with terms that return its state to its constraints, for an
integrator that cannot project it after a step.
"""

from __future__ import annotations

from typing import Any

from rotor_ida.model.contact import drag_of, normal_force
from rotor_ida.model.forces import Number, Numbers, resistance
from rotor_ida.model.rates import (
    CONTACT_STATE,
    contact_rates,
    grip_and_hold,
    rolling_rates,
    rub_rates,
)

# Rate at which a direction is returned to the unit circle, relative to the spin. A rate as fast as
# the motion cost Adams a sixth more steps; this one cost none.
PULL = 0.1


def spent_rate(state: Numbers, rotor: Any) -> Number:
    """Return the rate, by u, at which damping and load take energy on the rotating axes.

    It is ``q (2 zeta (|z'|**2 - omega h) - gamma omega x)``, x the displacement across the load.
    On these axes the unbalance is a constant force, and the work on the stator is the only other
    loss of ``|z'|**2/2 + kappa |z|**2/2 + gamma y - omega h - omega**2 |z| c``. So the
    energy of a contact balances without an integral over the work of the unbalance.
    """
    q, p, h, _, _, _, down_t, *_ = state
    r = rotor.delta0 + q * q
    around = h / r
    damped = resistance((p, around), rotor) * (p * p + around * around - rotor.omega * h)
    return q * (damped + rotor.load * rotor.omega * r * down_t)


def spent_sliding(state: Numbers, rotor: Any) -> tuple[Number, Number]:
    """Return `spent_rate` of a contact with friction, and the rate of its heat ``mu N |v_s|``.

    The power of friction, ``-T v_t``, consists of the heat ``T v_s`` and the power of the drive,
    ``T (V + omega r)`` on the rotating axes.
    """
    q, p, slip, c, s, down_r, down_t, *_ = state
    r = rotor.delta0 + q * q
    spent = spent_rate((q, p, slip - rotor.rim * r, c, s, down_r, down_t), rotor)
    drag = drag_of(normal_force(q, p, rotor), rotor)
    return spent - q * drag * (rotor.rim + rotor.omega * r), q * drag * (slip / r)


def spent_rolling(state: Numbers, rotor: Any) -> tuple[Number, Number]:
    """Return the rates of `spent_sliding` for a rolling disc: there is no heat."""
    q, p, _, c, s, down_r, down_t, *_ = state
    r = rotor.delta0 + q * q
    spent = spent_rate((q, p, -(rotor.rim * r), c, s, down_r, down_t), rotor)
    _, hold = grip_and_hold(state, rotor)
    return spent - q * hold * (rotor.rim + rotor.omega * r), 0.0 * q


def drawn_contact_rates(state: Numbers, rotor: Any, more: Numbers = (0.0, 0.0)) -> list[Number]:
    """Return the rates of a contact, with its directions returned to the unit circle.

    Otherwise errors of single steps would add up in a long contact, and the length of a direction
    scales the unbalance. The remaining ``c**2 + s**2 - 1`` falls like ``exp(-0.2 omega t)``.
    The whole model includes `spent_rate`.
    """
    rates = to_unit_circle(contact_rates(state, rotor, more), state, rotor)
    if len(state) > len(CONTACT_STATE):
        rates[-1] = spent_rate(state, rotor)
    return rates


def drawn_rub_rates(state: Numbers, rotor: Any, more: Numbers = (0.0, 0.0)) -> list[Number]:
    """Return the rates of a sliding contact, with its state returned to the constraints."""
    return drawn_back(rub_rates(state, rotor, more), state, spent_sliding(state, rotor), rotor)


def drawn_rolling_rates(state: Numbers, rotor: Any, more: Numbers = (0.0, 0.0)) -> list[Number]:
    """Return the rates of a rolling contact, with its state returned to the constraints."""
    return drawn_back(rolling_rates(state, rotor, more), state, spent_rolling(state, rotor), rotor)


def to_unit_circle(rates: list[Number], state: Numbers, rotor: Any) -> list[Number]:
    """Add to rates of a contact what returns its directions to the unit circle."""
    for first in (3, 5) if len(state) > len(CONTACT_STATE) else (3,):
        c, s = state[first : first + 2]
        pull = PULL * rotor.omega * state[0] * (1.0 - (c * c + s * s))
        rates[first] = rates[first] + pull * c
        rates[first + 1] = rates[first + 1] + pull * s
    return rates


def drawn_back(
    rates: list[Number], state: Numbers, spent: tuple[Number, Number], rotor: Any
) -> list[Number]:
    """Return rates of a contact with friction, corrected as in `drawn_contact_rates`."""
    rates = to_unit_circle(rates, state, rotor)
    rates[-2:] = spent
    return rates
