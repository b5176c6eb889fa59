"""A `Motion` led by Taylor series: one polynomial a step, read anywhere inside it.

Order and step follow from the tolerance. A step is cut where the contact root or the radial
velocity would vanish inside it more than once, so no exit and no peak is hidden.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numba.extending import overload_method

from rotor_ida.equations.compiling import inlined, lent, shared, structure
from rotor_ida.simulation import cartesian_phase, contact_phase
from rotor_ida.simulation.contact_phase import P, Q
from rotor_ida.simulation.motion import GOES_ON, NOT_FINITE, STUCK
from rotor_ida.simulation.tangents import TANGENTS
from rotor_ida.simulation.taylor.contact_series import expand_contact
from rotor_ida.simulation.taylor.differences import (
    Differences,
    expand_differences,
    longest_step_of,
    new_differences,
)
from rotor_ida.simulation.taylor.free_series import (
    VX,
    VY,
    X,
    Y,
    expand_free,
)
from rotor_ida.simulation.taylor.roots import bernstein_basis, with_one_root
from rotor_ida.simulation.taylor.rows import (
    LANES,
    WIDTH,
    evaluate,
    evaluate_row,
    evaluate_sizes,
)
from rotor_ida.simulation.taylor.series import Series, new_series
from rotor_ida.simulation.taylor.steps import longest_step, order_for

Values = npt.NDArray[np.float64]


@dataclass(slots=True)
class Taylor:
    """A motion led by Taylor series.

    Parameters
    ----------
    omega, zeta, delta0 : float
        The rotor [1].
    regularised : bool
        Whether it is a contact in its regularised variables, or the motion of a rotor without
        clearance in displacement and velocity.
    size : int
        Number of components of the motion itself.
    tangents : bool
        Whether the `rotor_ida.simulation.tangents` come behind them.
    rtol : float
        Relative tolerance of one step.
    order : int
        Order of the series.
    low, point : float
        Ends of the last step.
    before, values, reading : ndarray
        Values at those ends, and where the last step was last read.
    atol : ndarray
        Absolute tolerances of one step.
    series : Series
        The series about the beginning of the last step.
    terms : ndarray
        The coefficients of the state, which are part of it.
    differences : Differences
        The series of the tangents.
    factors : ndarray
        What these take from the motion, which is part of them; empty where there are none.
    inverse : ndarray
        One over the tolerances of the present step.
    sizes : ndarray
        Sums of the terms at the end of the last step, each without its sign.
    basis, powers, total : ndarray
        Bernstein's basis, and room for a polynomial by powers and by it.
    orders : int
        Orders expanded since the start.
    kept : tuple of ndarray
        Who keeps the arrays.
    """

    omega: float
    zeta: float
    delta0: float
    regularised: bool
    size: int
    tangents: bool
    rtol: float
    order: int
    low: float
    point: float
    before: Values
    values: Values
    reading: Values
    atol: Values
    series: Series
    terms: Values
    differences: Differences
    factors: Values
    inverse: Values
    sizes: Values
    basis: Values
    powers: Values
    total: Values
    orders: int
    kept: tuple[Series, Values, Values, Values]

    def restart(self, start: Values, atol: Values) -> int:
        """Begin anew from `start` at point 0, with absolute tolerances `atol`."""
        return restart(self, start, atol)

    def advance(self) -> int:
        """Take one step; return 0, or why it could not be taken."""
        return advance(self)

    def at(self, point: float) -> Values:
        """Return the values at a point of the last step, valid until the next reading."""
        return at(self, point)

    def glance_at(self, point: float) -> Values:
        """Do as `at` does."""
        return glance_at(self, point)

    def evaluations(self) -> int:
        """Return the number of orders expanded since the start."""
        return self.orders


TaylorType = structure(Taylor)


@shared
def open_taylor(
    omega: float, zeta: float, delta0: float, regularised: bool, rtol: float, tangents: bool
) -> Taylor:
    """Return a motion of a rotor that has not begun.

    Parameters
    ----------
    omega, zeta, delta0, regularised, rtol, tangents
        As of `Taylor`.
    """
    order = order_for(rtol)
    size = contact_phase.SIZE if regularised else cartesian_phase.SIZE
    whole = size + TANGENTS if tangents else size
    series, basis = new_series(order + 1), bernstein_basis(order)
    rows, powers = np.zeros((7, 2 * LANES)), np.zeros((1, order + 1))
    terms, differences = lent(series.terms), new_differences(order + 1 if tangents else 0)
    return Taylor(
        omega,
        zeta,
        delta0,
        regularised,
        size,
        tangents,
        rtol,
        order,
        0.0,
        0.0,
        lent(rows[0, :whole]),
        lent(rows[1, :whole]),
        lent(rows[2, :whole]),
        lent(rows[3, :whole]),
        Series(terms, lent(series.left), lent(series.right), lent(series.known)),
        terms,
        differences,
        differences.factors,
        lent(rows[4, :size]),
        lent(rows[5, :WIDTH]),
        lent(basis),
        lent(powers),
        lent(rows[6, :LANES]),
        0,
        (series, basis, rows, powers),
    )


@shared
def restart(motion: Taylor, start: Values, atol: Values) -> int:
    """Begin anew from `start` at point 0, with absolute tolerances `atol`."""
    motion.low = motion.point = 0.0
    motion.before[:] = start
    motion.values[:] = start
    motion.atol[:] = atol
    motion.orders = 0
    return GOES_ON


@shared
def advance(motion: Taylor) -> int:
    """Take one step; return 0, or why it could not be taken."""
    _begin_step(motion)
    series, factors, order = motion.series, motion.factors, motion.order
    omega, zeta, delta0 = motion.omega, motion.zeta, motion.delta0
    if motion.regularised:
        expand_contact(series, factors, order, omega, zeta, delta0)
        step = _contact_step(motion)
    else:
        inner = _unfelt(motion)
        expand_free(series, factors, order, omega, zeta, _pulled(motion, inner))
        step = _free_step(motion, inner)
    if motion.tangents:
        step = min(step, _step_of_tangents(motion))
    return _end_step(motion, step)


@shared
def _step_of_tangents(motion: Taylor) -> float:
    """Write the series of the tangents; return how far they may be followed."""
    differences, order = motion.differences, motion.order
    differences.terms[0] = motion.values[motion.size :]
    expand_differences(differences, order, motion.omega, motion.zeta)
    return longest_step_of(differences, order, motion.rtol)


@inlined
def _begin_step(motion: Taylor) -> None:
    motion.low = motion.point
    motion.orders += motion.order
    before, values, atol = motion.before, motion.values, motion.atol
    terms, inverse, rtol = motion.terms, motion.inverse, motion.rtol
    for i in range(values.size):
        before[i] = values[i]
    for i in range(inverse.size):
        value = terms[0, i] = values[i]
        inverse[i] = 1.0 / (rtol * abs(value) + atol[i])


@inlined
def _end_step(motion: Taylor, step: float) -> int:
    if math.isnan(step):
        return NOT_FINITE
    motion.point = motion.low + step
    if motion.point <= motion.low:
        return STUCK
    _read(motion, motion.point - motion.low, motion.values)
    return GOES_ON


@shared
def at(motion: Taylor, point: float) -> Values:
    """Return the values at a point of the last step, valid until the next reading."""
    if point >= motion.point:
        return motion.values
    if point <= motion.low:
        return motion.before
    _read(motion, point - motion.low, motion.reading)
    return motion.reading


@inlined
def glance_at(motion: Taylor, point: float) -> Values:
    """Do as `at` does."""
    _read(motion, point - motion.low, motion.reading)
    return motion.reading


@inlined
def _read(motion: Taylor, part: float, reading: Values) -> None:
    """Write the values at a part of the step into `reading`."""
    if motion.tangents:
        evaluate(motion.terms, motion.order, part, reading[: motion.size])
        evaluate_row(motion.differences.terms, motion.order, part, reading[motion.size :])
    else:
        evaluate(motion.terms, motion.order, part, reading)


@inlined
def _contact_step(motion: Taylor) -> float:
    """Return how far the series of a contact may be followed."""
    terms, order, sizes = motion.terms, motion.order, motion.sizes
    q = abs(terms[0, Q])
    rate = q * (motion.omega + 2.0 * motion.zeta + math.sqrt(1.5 * q))
    step = longest_step(terms, motion.inverse, sizes, order, 5, rate)
    evaluate_sizes(terms, order, step, sizes)
    # on a whirl of constant radius p is rounding, and what a step leaves open
    noise = max(contact_phase.NOISE, motion.rtol) * q / step
    basis, powers, total = motion.basis, motion.powers, motion.total
    step = with_one_root(terms, Q, sizes[Q], step, basis, powers, total)
    if sizes[P] > noise:
        step = with_one_root(terms, P, sizes[P], step, basis, powers, total)
    return step


@inlined
def _free_step(motion: Taylor, inner: float) -> float:
    """Return how far the series of a rotor without clearance may be followed."""
    x, y = motion.before[X], motion.before[Y]
    vx, vy = motion.before[VX], motion.before[VY]
    radius, speed = math.hypot(x, y), math.hypot(vx, vy)
    rate = motion.omega + 2.0 * motion.zeta + math.sqrt(1.5 * math.sqrt(radius))
    step = longest_step(motion.terms, motion.inverse, motion.sizes, motion.order, 4, rate)
    if radius <= inner and inner > 0.0:
        push = motion.omega**2 + 2.0 * motion.zeta * speed
        step = min(step, 2.0 * inner / (speed + math.sqrt(speed * speed + 2.0 * push * inner)))
    return step


@shared
def _unfelt(motion: Taylor) -> float:
    """Return a radius inside which the force changes the velocity by less than the tolerance.

    The time inside is at most ``r/speed`` or ``sqrt(2 r/push)``, and the force below ``r**1.5``.
    """
    part = 1e-2 * motion.rtol
    speed = math.hypot(motion.before[VX], motion.before[VY])
    return float(max((part * speed * speed) ** 0.4, (part * motion.omega**2) ** (2.0 / 3.0)))


@shared
def _pulled(motion: Taylor, inner: float) -> float:
    """Return 1 where the force acts, 0 where it is left out."""
    return 1.0 if math.hypot(motion.before[X], motion.before[Y]) > inner else 0.0


# The methods of a `Motion` in compiled code: numba calls a function with the types of the
# arguments, and compiles the function that it returns.
# ruff: noqa: ARG005, PLW0108
overload_method(TaylorType, "restart")(
    lambda motion, start, atol: lambda motion, start, atol: restart(motion, start, atol)
)
overload_method(TaylorType, "advance")(lambda motion: lambda motion: advance(motion))
overload_method(TaylorType, "at")(lambda motion, point: lambda motion, point: at(motion, point))
overload_method(TaylorType, "glance_at", inline="always")(
    lambda motion, point: lambda motion, point: glance_at(motion, point)
)
overload_method(TaylorType, "evaluations")(lambda motion: lambda motion: motion.orders)
