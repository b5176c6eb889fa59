"""The model, stated once: the modes of motion of a rotor, in contact and without clearance.

A mode is a state, its rate of change, and guards: components of the state that pass through 0 where
the mode ends, or at another event. All are plain Python with only sums, products, quotients and
constant powers. Run over numbers they are the model itself. Run once over symbols they give what
the compiled core needs (`rotor_ida.model.writing`): fields and Jacobians, Taylor series, the growth
of small differences, and the derivatives by the parameters.

The forces are those of `rotor_ida.model.forces`.

The core is derived for three models. In the paper's rotor shaft, contact damping and load are the
number 0 and vanish. In the whole model (`whole`) the states include the direction of the load and
the work of a contact. The third is the whole model at a changing speed
(`rotor_ida.model.spinning`). In the whole model a contact is loose
while damping would make the force tensile; `rotor.loose` is 1 then, else 0. The exponent of the
force is 3/2 where `rotor.hertz` is 1, or 1 where `rotor.linear` is.

Friction has separate modes, so that a contact without friction is unchanged: in one the surfaces
slide, forwards or backwards as `rotor.sigma` is 1 or -1; in the other the disc rolls on the stator.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from rotor_ida.model.contact import damped, drag_of, normal_force, slope_of_root, spring_of_root
from rotor_ida.model.forces import (
    Moment,
    Number,
    Numbers,
    accelerations,
    hold_of_rolling,
    resistance,
    secant,
    turned_rates,
)
from rotor_ida.model.parameters import ALL_PARAMETERS, FRICTIONLESS, PARAMETERS

# Rate at which a direction is returned to the unit circle, relative to the spin. A rate as fast as
# the motion cost Adams a sixth more steps; this one cost none.
PULL = 0.1


@dataclass(frozen=True, slots=True)
class Guard:
    """A component of the state that passes through 0 at an event.

    Parameters
    ----------
    event : str
        The event where it passes through 0.
    of : str
        Name of the component.
    """

    event: str
    of: str


@dataclass(frozen=True, slots=True)
class Mode:
    """A mode of motion.

    Parameters
    ----------
    name : str
        Its name in derived code.
    state : tuple of str
        Names of the components of its state.
    rates : callable
        ``rates(state, rotor)`` returns the rate of change of each component. A rotor is any object
        with the parameters as attributes.
    neighbour : callable
        ``neighbour(state, apart, deeper, rotor)`` returns to first order the position, velocity and
        acceleration of a rotor at the distance `apart`, with an indentation `deeper` by that
        amount, and the rate of rotation of their basis. None where nothing is differentiated.
    pace : callable
        ``pace(state)``: derivative of time by the variable of integration.
    guards : tuple of Guard
        Its guards.
    drawn_rates : callable
        As `rates`, with terms that return the state to its constraints, for an integrator that
        cannot project it after a step; and the rates of components without a series.
    watched : callable, optional
        ``watched(state, rotor)`` returns quantities that are not components of the state but decide
        the end of the mode; the core computes their series, values and rates of change.
    """

    name: str
    state: tuple[str, ...]
    rates: Callable[[Numbers, Any], list[Number]]
    neighbour: Callable[[Numbers, Numbers, Number, Any], Neighbour] | None
    pace: Callable[[Numbers], Number]
    guards: tuple[Guard, ...]
    drawn_rates: Callable[[Numbers, Any], list[Number]]
    watched: Callable[[Numbers, Any], list[Number]] | None = None


class Neighbour(NamedTuple):
    """Position, velocity and acceleration in one basis, and its rate of rotation."""

    position: tuple[Number, Number]
    velocity: tuple[Number, Number]
    acceleration: tuple[Number, Number]
    turning: Number


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


def to_unit_circle(rates: list[Number], state: Numbers, rotor: Any) -> list[Number]:
    """Add to rates of a contact what returns its directions to the unit circle."""
    for first in (3, 5) if len(state) > len(CONTACT_STATE) else (3,):
        c, s = state[first : first + 2]
        pull = PULL * rotor.omega * state[0] * (1.0 - (c * c + s * s))
        rates[first] = rates[first] + pull * c
        rates[first + 1] = rates[first + 1] + pull * s
    return rates


def contact_neighbour(state: Numbers, apart: Numbers, deeper: Number, rotor: Any) -> Neighbour:
    """Return a neighbour of a rotor in contact, in the polar basis of the latter."""
    q, _, h, *_ = state
    r = rotor.delta0 + q * q
    around = h / r
    near, push = _apart(state, around, apart, deeper, rotor)
    spin = around / r
    return Neighbour(near.position, near.velocity, accelerations(near, push, rotor), spin)


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


def drawn_back(
    rates: list[Number], state: Numbers, spent: tuple[Number, Number], rotor: Any
) -> list[Number]:
    """Return rates of a contact with friction, corrected as in `drawn_contact_rates`."""
    rates = to_unit_circle(rates, state, rotor)
    rates[-2:] = spent
    return rates


def drawn_rub_rates(state: Numbers, rotor: Any, more: Numbers = (0.0, 0.0)) -> list[Number]:
    """Return the rates of a sliding contact, with its state returned to the constraints."""
    return drawn_back(rub_rates(state, rotor, more), state, spent_sliding(state, rotor), rotor)


def drawn_rolling_rates(state: Numbers, rotor: Any, more: Numbers = (0.0, 0.0)) -> list[Number]:
    """Return the rates of a rolling contact, with its state returned to the constraints."""
    return drawn_back(rolling_rates(state, rotor, more), state, spent_rolling(state, rotor), rotor)


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
    outwards, sideways = accelerations(near, 0.0, rotor)
    rim = rotor.disc_radius * rotor.omega  # differentiated; the motion's own rim speed is fixed
    rises = near.velocity[0] + around * aside
    hold = sideways - aside * outwards + rim * rises / near.position[0]
    forces = (outwards - push + hold * aside, sideways - push * aside - hold)
    return Neighbour(near.position, near.velocity, forces, around / r)


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


def cartesian_neighbour(state: Numbers, apart: Numbers, _deeper: Number, rotor: Any) -> Neighbour:
    """Return a neighbour on the rotating axes; without clearance none is deeper."""
    x, y, vx, vy = (here + more for here, more in zip(state[:4], apart, strict=True))
    down_x, down_y = state[4:] or (0.0, 0.0)
    push = secant(x * x + y * y, rotor)
    at = Moment((x, y), (vx, vy), (x, y), (1.0, 0.0), (down_x, down_y))
    return Neighbour((x, y), (vx, vy), accelerations(at, push, rotor), rotor.omega)


CONTACT_STATE = ("q", "p", "h", "c", "s", "t", "j")
CARTESIAN_STATE = ("x", "y", "vx", "vy")
CONTACT = Mode(
    name="contact",
    state=CONTACT_STATE,
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
    state=CARTESIAN_STATE,
    rates=cartesian_rates,
    neighbour=cartesian_neighbour,
    pace=lambda _state: 1.0,
    guards=(),
    drawn_rates=cartesian_rates,
)
WHOLE_CONTACT = replace(
    CONTACT, state=(*CONTACT_STATE[:5], "down_r", "down_t", "t", "j", "work", "spent")
)
# Arranged like a contact without friction, except for the moment of the slip, and the heat.
RUB_STATE = (*WHOLE_CONTACT.state[:2], "slip", *WHOLE_CONTACT.state[3:], "heat")
RUB = Mode(
    name="rub",
    state=RUB_STATE,
    rates=rub_rates,
    neighbour=rub_neighbour,
    pace=lambda state: state[0],
    guards=(*CONTACT.guards, Guard(event="roll", of="slip")),
    drawn_rates=drawn_rub_rates,
)
ROLLING = Mode(
    name="rolling",
    state=RUB_STATE,
    rates=rolling_rates,
    neighbour=rolling_neighbour,
    pace=lambda state: state[0],
    guards=CONTACT.guards,
    drawn_rates=drawn_rolling_rates,
    watched=grip_and_hold,
)
WHOLE_CARTESIAN = replace(CARTESIAN, state=(*CARTESIAN_STATE, "down_x", "down_y"))


@dataclass(frozen=True, slots=True)
class Model:
    """A model for which a core is derived.

    Parameters
    ----------
    name : str
        Its name in file names.
    modes : tuple of Mode
        The modes of motion.
    parameters : tuple of str
        Parameters of a rotor, and of a mode, that are not constant.
    constants : dict
        Parameters that are fixed numbers.
    columns : tuple of str
        The parameters by which the core differentiates.
    lighter : dict
        Additional series of each mode that need fewer products, by name, with the parameters that
        are fixed numbers in them. Named components of a state are 0.
    """

    name: str
    modes: tuple[Mode, ...]
    parameters: tuple[str, ...]
    constants: dict[str, float]
    columns: tuple[str, ...]
    lighter: dict[str, dict[str, float]] = field(default_factory=dict)


# Parameters of forces that the paper's rotor lacks, except friction.
OF_FORCES = tuple(name for name in FRICTIONLESS if name != "contact_exponent")
PAPER = Model(
    name="paper",
    modes=(CONTACT, CARTESIAN),
    parameters=(*PARAMETERS, "felt"),
    constants={
        **dict.fromkeys((*OF_FORCES, "linear", "loose"), 0.0),
        "hertz": 1.0,
    },
    columns=PARAMETERS,
)
WHOLE = Model(
    name="whole",
    modes=(WHOLE_CONTACT, WHOLE_CARTESIAN, RUB, ROLLING),
    # friction has the speed of the rim, rho omega, and the sense in which surfaces slide
    parameters=(
        *PARAMETERS, *OF_FORCES, "hertz", "linear", "felt", "loose",
        "friction", "disc_radius", "rim", "sigma",
    ),
    constants={},
    columns=tuple(name for name in ALL_PARAMETERS if name != "contact_exponent"),
)  # fmt: skip
