"""Extents: the ranges of speed, damping and clearance in which an attractor exists, one at a time.

A whirl in contact ends at a fold or where it first touches the stator. A limit cycle ends at a
fold, a period doubling or a torus point. The contact-free whirl ends where it fills the clearance.
A whirl is followed along its exact amplitudes in small steps, which are refined where it ends.
Contact damping and friction may end it at a Hopf point. A limit cycle is followed along its branch,
from the given rotor. With friction a branch may turn back at a corner, where multipliers jump: that
counts as a fold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rotor_ida.arrays import Stop, Values
from rotor_ida.closed_forms import (
    synchronous_response,
    touch_speeds,
)
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.closed_forms.rotor_columns import RotorColumns
from rotor_ida.closed_forms.stability import eigenvalues_of
from rotor_ida.cycles.branch import BORN, CONTACT_FREE, HALVED, LIMITS, Side, advance
from rotor_ida.cycles.guess import DOUBLING, Guess
from rotor_ida.cycles.problems import FOLD, SLIDING, TORUS, branch_through
from rotor_ida.cycles.special_points import DISCONTINUOUS
from rotor_ida.errors import SimulationError
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import STABILITY, WITH_EXTENTS
from rotor_ida.simulation.flow import DiscFlow

# Special points at which a branch may turn back at a corner.
CORNERS = (SLIDING, DISCONTINUOUS)
# Attractors that survive to this fraction of a parameter are assumed to reach zero.
AT_ZERO = 1e-4
# Whirls that survive to this multiple of a parameter, or to this value if it is 0, are assumed to
# exist for any.
FARTHEST_OF_WHIRL = 1e6
# They are followed in this number of steps, with this largest relative change of amplitude in each.
# The step in which one ends is divided into this number again, this number of times.
STEPS, MOST_CHANGE, PARTS, DIVISIONS = 1024, 0.1, 64, 8
# A limit cycle, which costs more, is followed to this multiple of the value, or to 1 if larger.
FARTHEST_OF_CYCLE = 50.0
# Largest number of points of a branch of limit cycles each way, which bounds its cost.
MOST_POINTS = 300
# A whirl ends at the stator if its indentation is at most this fraction of the clearance.
AT_RING = 1e-9


@dataclass(frozen=True, slots=True)
class End:
    """Where an attractor ends in one direction."""

    value: float  # of the parameter [1]; 0 or infinite if it does not end, NaN if not known
    kind: str  # one of `rotor_ida.schema.END`


UNKNOWN = End(math.nan, "not_found")


def varied(rotor: Rotor) -> tuple[str, ...]:
    """Return the parameters of a rotor whose extents are reported."""
    return tuple(name for name in WITH_EXTENTS if name in PARAMETERS or name in rotor.beyond)


def extent_of_contact_free(rotor: Rotor, parameter: str) -> tuple[End, End]:
    """Return the range in which the contact-free whirl fits: |w| is at most delta0."""
    below, above = End(0.0, "none"), End(math.inf, "none")
    if parameter in ("contact_damping", "friction"):
        return below, above
    if rotor.shaft_stiffness > 0.0:
        low, high = _room_with_shaft(rotor, parameter)
        return (
            End(low, "touch") if low > 0.0 else below,
            End(high, "touch") if high < math.inf else above,
        )
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


def _room_with_shaft(rotor: Rotor, parameter: str) -> tuple[float, float]:
    """Return the range in which ``omega**4 <= delta0**2 ((kappa - q)**2 + 4 zeta**2 q)``."""
    omega, zeta, kappa, delta0 = rotor.omega, rotor.zeta, rotor.shaft_stiffness, rotor.delta0
    q = omega * omega
    if parameter == "omega":
        first, second = touch_speeds(zeta=zeta, delta0=delta0, shaft_stiffness=kappa).tolist()
        if math.isnan(first):
            return 0.0, math.inf
        return (0.0, first) if omega <= first else (second, math.inf)
    if parameter == "delta0":
        return abs(complex(complex_amplitude(omega, zeta, kappa))), math.inf
    off, drag = (kappa - q) ** 2, 4.0 * zeta * zeta * q
    lacking = (q / delta0) ** 2 - (off if parameter == "zeta" else drag)
    if lacking <= 0.0:
        return 0.0, math.inf
    if parameter == "zeta":
        return 0.5 * math.sqrt(lacking) / omega, math.inf
    root = math.sqrt(lacking)
    return (q + root, math.inf) if kappa > q else (0.0, q - root)


def extent_of_whirl(rotor: Rotor, amplitude: float, parameter: str) -> tuple[End, End]:
    """Return the range in which a stable whirl in contact exists."""
    value = getattr(rotor, parameter)
    farthest = FARTHEST_OF_WHIRL * (value or 1.0)
    upwards = np.geomspace(value or AT_ZERO, farthest, STEPS)
    if value == 0.0:
        upwards[0] = 0.0
    high = _end_of_steps(rotor, amplitude, parameter, upwards)
    if value == 0.0:
        return End(0.0, "none"), high
    downwards = np.geomspace(value, AT_ZERO * value, STEPS)
    return _end_of_steps(rotor, amplitude, parameter, downwards), high


def amplitudes_along(rotor: Rotor, amplitude: float, parameter: str, values: Values) -> Values:
    """Return the amplitudes of a stable whirl at these values; NaN from where it ends."""
    return _followed(amplitude, _stable_amplitudes(rotor, parameter, values))


def _stable_amplitudes(rotor: Rotor, parameter: str, values: Values) -> Values:
    """Return the amplitudes of all stable whirls in contact, a row for each value."""
    distinct, back = np.unique(values, return_inverse=True)
    asked: dict[str, Any] = {"load": 0.0, parameter: distinct}
    whirls = synchronous_response(rotor, **asked)
    stands = (whirls["stability"] == STABILITY["stable"]) & (whirls["in_contact"] == 1)
    sizes = whirls["amplitude"].where(stands).transpose(parameter, ..., "branch").values[back]
    return np.asarray(sizes.reshape(values.size, -1))


def _followed(amplitude: float, rows: Values) -> Values:
    """Return the amplitude of one whirl in rows with those of all; NaN from where it ends.

    A branch has ended at a fold if the nearest other whirl is farther off than it can have moved.
    """
    found = np.full(len(rows), math.nan)
    for place, row in enumerate(rows.tolist()):
        near = [each for each in row if abs(each - amplitude) <= MOST_CHANGE * amplitude]
        if not near:
            break
        found[place] = amplitude = min(near, key=lambda each: abs(each - amplitude))
    return found


def _end_of_steps(rotor: Rotor, amplitude: float, parameter: str, values: Values) -> End:
    """Return where a stable whirl ends along values that begin at the rotor's."""
    value, size = _last_of_steps(rotor, amplitude, parameter, values, DIVISIONS)
    if value == values[-1]:
        return End(math.inf if values[-1] > values[0] else 0.0, "none")
    if math.isnan(value):
        return UNKNOWN
    return End(value, _how_whirl_ends(replace(rotor, **{parameter: value}), size))


def _last_of_steps(
    rotor: Rotor, amplitude: float, parameter: str, values: Values, divisions: int
) -> tuple[float, float]:
    """Return the last value that a stable whirl reaches, possibly between steps, and its amplitude.

    A step in which it ends, or its amplitude changes by much, is divided into finer ones.
    """
    rows = _stable_amplitudes(rotor, parameter, values)
    while True:
        sizes = _followed(amplitude, rows)
        lasting = int(np.isfinite(sizes).sum())
        if lasting == 0:
            return math.nan, math.nan
        last, amplitude = float(values[lasting - 1]), float(sizes[lasting - 1])
        if lasting == values.size:
            return last, amplitude
        goal = float(values[lasting])
        finer = np.linspace(last, goal, PARTS + 1)
        if not divisions or finer[1] == finer[0]:
            return last, amplitude
        reached, amplitude = _last_of_steps(rotor, amplitude, parameter, finer, divisions - 1)
        if reached != goal:
            return reached, amplitude
        values, rows = values[lasting:], rows[lasting:]


def _how_whirl_ends(rotor: Rotor, amplitude: float) -> str:
    """Return how a stable whirl ends that does so near a rotor."""
    if amplitude - rotor.delta0 <= AT_RING * rotor.delta0:
        return "touch"
    if not (rotor.contact_damping or rotor.friction):
        return "fold"
    rates = eigenvalues_of(np.array(amplitude), RotorColumns.of(rotor.given))
    slowest = rates[np.argmax(rates.real)]
    return "fold" if slowest.imag == 0.0 else "hopf"


def extent_of_cycle(
    rotor: Rotor, state: Values, period: float, parameter: str, stop: Stop
) -> tuple[End, End]:
    """Return the range in which the stable limit cycle through a state exists."""
    value = getattr(rotor, parameter)
    farthest = FARTHEST_OF_CYCLE * max(1.0, value)
    try:
        guess = Guess(DiscFlow(rotor, stop), state, period)
        course = branch_through(guess, parameter, (0.0, farthest), MOST_POINTS)
    except SimulationError:
        return UNKNOWN, UNKNOWN
    ends = []
    for way in (-1, 1):
        first = course.first
        ahead = first if way * first.tangent[-1] > 0.0 else first.reversed()
        side = Side([ahead])
        while not side.end and not _met(side):
            advance(course, side)
        ends.append(_end_of_side(side, way, value))
    return ends[0], ends[1]


def _met(side: Side) -> list[End]:
    """Return where stability was lost on the points followed so far, in order."""
    ends = (FOLD, DOUBLING, TORUS, DISCONTINUOUS)
    names = [
        FOLD if special.name in CORNERS and _turns_after(side, place) else special.name
        for place, special in side.specials
    ]
    return [
        End(float(special.point.unknowns[-1]), name)
        for name, (_, special) in zip(names, side.specials, strict=True)
        if name in ends
    ]


def _turns_after(side: Side, place: int) -> bool:
    """Return whether the parameter turns back between a point of a branch and the next."""
    here, there = side.points[place : place + 2]
    return bool(here.tangent[-1] * there.tangent[-1] < 0.0)


def _end_of_side(side: Side, way: int, begin: float) -> End:
    """Return where a branch of limit cycles ends in one direction."""
    if met := _met(side):
        return met[0]
    last = float(side.points[-1].unknowns[-1])
    if way < 0 and (side.end == LIMITS or last < AT_ZERO * (begin or 1.0)):
        return End(0.0, "none")
    if side.end == HALVED:
        return End(last, DOUBLING)
    if side.end == BORN:
        return End(last, "hopf")
    return End(last, "touch") if side.end == CONTACT_FREE else UNKNOWN
