"""Small differences from a motion, beside it: the variational equations at equal times.

Read on the rotating axes, a difference (x, y, vx, vy) from a motion obeys

    x' = vx + omega y,   vx' = omega vy - 2 zeta vx - a x - b c g
    y' = vy - omega x,   vy' = - omega vx - 2 zeta vy - a y - b s g,   g = c x + s y,

with a = f/r, b = f' - f/r, f the force, and c and s the direction of the rotor. In contact, by the
fictitious time of `rotor_ida.simulation.contact_phase`, each rate is multiplied by q: so they are
analytic through entry and exit, and pass them with no jump. Without clearance ``a = sqrt(r)`` and
``b = a/2``.

A motion with tangents carries four differences behind its own components: first their four x,
then their y, vx and vy.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.compiling import compiled, shared
from rotor_ida.equations.contact import force_of_root
from rotor_ida.equations.model import rotating_field_into
from rotor_ida.simulation import cartesian_phase, contact_phase
from rotor_ida.simulation.contact_phase import C, Q, S, contact_field

Values = npt.NDArray[np.float64]

COUNT = 4
TANGENTS = 4 * COUNT
X, Y, VX, VY = range(0, TANGENTS, COUNT)


@compiled
def contact_field_with_tangents(
    state: Values, rate: Values, omega: float, zeta: float, delta0: float
) -> None:
    """Write the rate of change by u of the regularised state and its differences."""
    size = contact_phase.SIZE
    contact_field(state[:size], rate[:size], omega, zeta, delta0)
    q, c, s = state[Q], state[C], state[S]
    length, force = math.sqrt(c * c + s * s), force_of_root(q)
    pull = force / (delta0 + q * q)
    _write_rates(
        state[size:], rate[size:], omega, zeta, q, pull, 1.5 * q - pull, c / length, s / length
    )


@compiled
def free_field_with_tangents(
    state: Values, rate: Values, omega: float, zeta: float, _delta0: float
) -> None:
    """Write the rate of change of a rotor without clearance, and of its differences."""
    size = cartesian_phase.SIZE
    rotating_field_into(state[:size], rate[:size], omega, zeta, 0.0)
    radius = math.hypot(state[0], state[1])
    c, s = (state[0] / radius, state[1] / radius) if radius > 0.0 else (1.0, 0.0)
    pull = math.sqrt(radius)
    _write_rates(state[size:], rate[size:], omega, zeta, 1.0, pull, 0.5 * pull, c, s)


@compiled
def _write_rates(
    d: Values, rate: Values, omega: float, zeta: float, pace: float, pull: float, bend: float,
    c: float, s: float,
) -> None:  # fmt: skip
    """Write the rates of four differences."""
    for i in range(COUNT):
        x, y, vx, vy = d[X + i], d[Y + i], d[VX + i], d[VY + i]
        along = bend * (c * x + s * y)
        rate[X + i] = pace * (vx + omega * y)
        rate[Y + i] = pace * (vy - omega * x)
        rate[VX + i] = pace * (omega * vy - 2.0 * zeta * vx - pull * x - along * c)
        rate[VY + i] = pace * (-omega * vx - 2.0 * zeta * vy - pull * y - along * s)


@shared
def joined(values: Values, vectors: Values) -> Values:
    """Return the values of a motion with tangents.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Those of the motion.
    vectors : ndarray, shape (4, 4), or (0, 4) for none
        A difference in each row.
    """
    whole = np.empty(values.size + vectors.size)
    whole[: values.size] = values
    whole[values.size :] = vectors.T.ravel()
    return whole
