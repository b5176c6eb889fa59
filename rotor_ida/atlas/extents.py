"""Extents: between which speeds, dampings and clearances an attractor exists, the others held.

A whirl in contact ends at a fold or where it first touches the ring, a limit cycle at a fold or
where its period doubles, the contact-free whirl where it fills the clearance. Whirls and cycles are
followed along their curves, from the rotor at hand until they do.

The whirls are the zeros of ``H = log(((f - q A)**2 + 4 zeta**2 q A**2)/q**2)``, with
``q = omega**2`` and ``f = (A - delta0)**1.5`` (eqs (21)-(23) of the paper with the force
corrected). Along a parameter p the curve has the tangent ``(-dH/dp, dH/da)`` in the plane of
``a = log A`` and p, and a fold where ``dH/da = 0``; p is the logarithm of omega or zeta, or the
inverse hyperbolic sine of delta0, which may be 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

from rotor_ida.arrays import Values
from rotor_ida.cycles.branch import (
    CONTACT_FREE,
    DOUBLING,
    FOLD,
    HALVED,
    LIMITS,
    PLACE,
    Side,
    advance,
    course_from,
)
from rotor_ida.cycles.guess import Guess
from rotor_ida.errors import SimulationError
from rotor_ida.parallel import Stop
from rotor_ida.parameters import PARAMETERS, Rotor

# A limit cycle is followed to zero of a parameter and to so many times its value, or 1 if that is
# larger; a whirl, whose curve is cheap, to where speed or damping is so much larger.
FARTHEST, FARTHEST_OF_WHIRL = 50.0, 1e6
# A curve of whirls is followed with this error. It is at zero when a parameter has come to this
# part of where it began.
RTOL, AT_ZERO = 1e-12, 1e-4
LONGEST_CURVE, TINY = 1e9, 1e-12
# Polishing leaves no more than this of the equations of a fold, and moves it by no more than that.
POLISHED, MOVED = 1e-9, 1e-2
# A branch of limit cycles is followed for so many points each way.
MOST_POINTS = 300


@dataclass(frozen=True, slots=True)
class End:
    """Where an attractor ends, one way.

    Parameters
    ----------
    value : float
        Of the parameter [1]; 0 or infinite where it goes on, NaN where that is not known.
    kind : str
        One of `rotor_ida.schema.END`.
    """

    value: float
    kind: str


UNKNOWN = End(math.nan, "not_found")


def extent_of_contact_free(rotor: Rotor, parameter: str) -> tuple[End, End]:
    """Return between which values the contact-free whirl has room: |w| is at most delta0."""
    below, above = End(0.0, "none"), End(math.inf, "none")
    if parameter != "delta0" and rotor.delta0 >= 1.0:
        return below, above
    end = End(_first_touch(rotor, parameter), "touch")
    return (below, end) if parameter == "omega" else (end, above)


def _first_touch(rotor: Rotor, parameter: str) -> float:
    """Return the value of a parameter at which |w| is delta0."""
    omega, zeta, delta0 = rotor.omega, rotor.zeta, rotor.delta0
    if parameter == "delta0":
        return omega / math.hypot(omega, 2.0 * zeta)
    ratio = 2.0 * delta0 / math.sqrt((1.0 - delta0) * (1.0 + delta0))  # of omega to zeta
    return zeta * ratio if parameter == "omega" else omega / ratio


def extent_of_whirl(rotor: Rotor, amplitude: float, parameter: str) -> tuple[End, End]:
    """Return between which values a stable whirl in contact exists."""
    return _end_of_whirl(rotor, amplitude, parameter, -1), _end_of_whirl(
        rotor, amplitude, parameter, 1
    )


def extent_of_cycle(
    rotor: Rotor, state: Values, period: float, parameter: str, stop: Stop
) -> tuple[End, End]:
    """Return between which values a stable limit cycle exists.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    state : ndarray, shape (4,)
        A state of the cycle on the rotating axes [1].
    period : float
        Its period [1].
    parameter : {"omega", "zeta", "delta0"}
        The parameter.
    stop : ndarray, shape (1,)
        Anything but 0 asks to stop.
    """
    value = getattr(rotor, parameter)
    farthest = FARTHEST * max(1.0, value)
    try:
        course = course_from(
            Guess(rotor, state, period), parameter, (0.0, farthest), MOST_POINTS, stop
        )
    except SimulationError:
        return UNKNOWN, UNKNOWN
    ends = []
    for way in (-1, 1):
        first = course.first
        ahead = first if way * first.tangent[PLACE] > 0.0 else first.reversed()
        side = Side([ahead])
        while not side.end and not _met(side):
            advance(course, side)
        ends.append(_end_of_side(side, way, value))
    return ends[0], ends[1]


def _met(side: Side) -> list[End]:
    """Return the folds and doublings on what has been followed, in order."""
    return [
        End(float(special.point.unknowns[PLACE]), special.name)
        for _, special in side.specials
        if special.name in (FOLD, DOUBLING)
    ]


def _end_of_side(side: Side, way: int, begin: float) -> End:
    """Return where a branch of limit cycles ends, one way."""
    if met := _met(side):
        return met[0]
    last = float(side.points[-1].unknowns[PLACE])
    if way < 0 and (side.end == LIMITS or last < AT_ZERO * (begin or 1.0)):
        return End(0.0, "none")
    if side.end == HALVED:
        return End(last, DOUBLING)
    return End(last, "touch") if side.end == CONTACT_FREE else UNKNOWN


def _end_of_whirl(rotor: Rotor, amplitude: float, parameter: str, way: int) -> End:
    """Return where a whirl in contact ends as a parameter changes one way."""
    column = PARAMETERS.index(parameter)
    here = np.array([math.log(rotor.omega), math.log(rotor.zeta), math.asinh(rotor.delta0)])
    begin = float(here[column])
    if parameter == "delta0":  # which is less than A, and that at most omega/(2 zeta)
        limits = 0.0, math.inf
        if begin == 0.0 and way < 0:
            return End(0.0, "none")
    else:
        limits = begin + math.log(AT_ZERO), begin + math.log(FARTHEST_OF_WHIRL)

    def slopes(place: Values) -> tuple[float, float]:
        values = here.copy()
        values[column] = place[1]
        by_amplitude, *by_parameters = _slopes(place[0], *values.tolist())
        return by_amplitude, by_parameters[column]

    first = np.array([math.log(amplitude), begin])
    sense = math.copysign(1.0, slopes(first)[0]) * way

    def tangent(_length: float, place: Values) -> list[float]:
        by_amplitude, by_parameter = slopes(place)
        size = math.hypot(by_amplitude, by_parameter) or 1.0
        return [-sense * by_parameter / size, sense * by_amplitude / size]

    def folds(_length: float, place: Values) -> float:
        return slopes(place)[0]

    def leaves(_length: float, place: Values) -> float:
        return float(min(place[1] - limits[0], limits[1] - place[1])) + TINY

    def touches(_length: float, place: Values) -> float:
        clearance = math.sinh(place[1]) if parameter == "delta0" else rotor.delta0
        return math.exp(place[0]) - clearance

    for event in (folds, leaves, touches):
        event.terminal = True  # type: ignore[attr-defined]
    touches.direction = -1.0  # type: ignore[attr-defined]
    found = solve_ivp(tangent, (0.0, LONGEST_CURVE), first, "DOP853", rtol=RTOL, atol=RTOL,
                      events=(folds, leaves, touches))  # fmt: skip
    folded, left, touched = (times.size > 0 for times in found.t_events)
    if folded:
        return _polished_fold(found.y[:, -1], here, column)
    if touched:
        if parameter != "delta0" and rotor.delta0 >= 1.0:
            return UNKNOWN  # |w| never fills it: a fold was missed that is too near to the ring
        return End(_first_touch(rotor, parameter), "touch")
    return End(math.inf if way > 0 else 0.0, "none") if left else UNKNOWN


def _polished_fold(place: Values, here: Values, column: int) -> End:
    """Return the fold near a place, in the plane of log A and the parameter of this column.

    With ``u = sqrt(A - delta0)``, the phase lag theta and ``a = -cos(theta)`` it obeys
    ``u**3 = q (A - a)``, ``(A + 2 delta0) a (A - a) = 2 u**2`` and
    ``4 zeta**2 A**2 = q (1 - a**2)`` (see `rotor_ida.closed_forms.fold_locus`).
    """

    def residuals(unknowns: Values) -> list[float]:
        values = here.copy()
        values[column] = unknowns[2]
        q, damping, delta0 = _at(*values.tolist())
        u, a = math.exp(unknowns[0]), float(unknowns[1])
        amplitude = delta0 + u * u
        b = amplitude - a
        return [
            q * b / u**3 - 1.0,
            (amplitude + 2.0 * delta0) * a * b / (2.0 * u * u) - 1.0,
            damping * amplitude**2 / q - (1.0 - a) * (1.0 + a),
        ]

    values = here.copy()
    values[column] = place[1]
    q, _, delta0 = _at(*values.tolist())
    amplitude = math.exp(place[0])
    depth = amplitude - delta0
    if depth <= 0.0:
        return UNKNOWN
    roots = np.roots([1.0, -amplitude, 2.0 * depth / (amplitude + 2.0 * delta0)]).real
    a = roots[np.argmin(np.abs(roots - (amplitude - depth**1.5 / q)))]
    fold = root(residuals, [0.5 * math.log(depth), a, place[1]], tol=1e-13)
    if np.abs(fold.fun).max() > POLISHED or abs(fold.x[2] - place[1]) > MOVED:
        return UNKNOWN
    value = float(fold.x[2])
    return End(math.sinh(value) if PARAMETERS[column] == "delta0" else math.exp(value), "fold")


def _at(log_omega: float, log_zeta: float, arsinh_delta0: float) -> tuple[float, float, float]:
    """Return ``omega**2``, ``4 zeta**2`` and delta0."""
    return math.exp(2.0 * log_omega), 4.0 * math.exp(2.0 * log_zeta), math.sinh(arsinh_delta0)


def _slopes(
    log_amplitude: float, log_omega: float, log_zeta: float, arsinh_delta0: float
) -> tuple[float, float, float, float]:
    """Return the derivatives of H by these four."""
    amplitude = math.exp(log_amplitude)
    q, damping, delta0 = _at(log_omega, log_zeta, arsinh_delta0)
    depth = max(amplitude - delta0, 0.0)
    beyond, stiffness = depth**1.5 - q * amplitude, 1.5 * math.sqrt(depth)
    damped = damping * amplitude**2 * q
    total = beyond**2 + damped
    return (
        (2.0 * amplitude * beyond * (stiffness - q) + 2.0 * damped) / total,
        (-4.0 * q * amplitude * beyond + 2.0 * damped) / total - 4.0,
        2.0 * damped / total,
        -2.0 * beyond * stiffness / total * math.cosh(arsinh_delta0),
    )
