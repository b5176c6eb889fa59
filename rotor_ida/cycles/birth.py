"""Where a branch of cycles is born: the Hopf point of a synchronous whirl.

The whirl that begins to oscillate there is known in closed form, and so is the point.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np
from scipy.optimize import brentq

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.rotor_columns import RotorColumns
from rotor_ida.closed_forms.stability import eigenvalues_of
from rotor_ida.closed_forms.synchronous import synchronous_response
from rotor_ida.cycles.continuation import Point, Problem
from rotor_ida.cycles.special_points import O
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.neighbours import Shot

# Factor on the range, estimated from two nearby points, in which the bifurcation is sought.
FARTHER = 4.0
# Relative agreement of the whirl's frequency with that of a nearby cycle.
SAME_FREQUENCY = 0.1
# Relative oscillation of the radius of a cycle there: its square is below rounding.
SWING = 3e-7
# Digits to which the parameter is determined.
FINEST = 1e-15


class WhirlNear(Protocol):
    """The whirl nearest to a cycle with a small oscillation, over a parameter."""

    def growth(self, place: float) -> float:
        """Return the growth rate of the whirl's oscillation at the frequency of the cycle."""

    def at(self, place: float) -> tuple[Values, complex]:
        """Return state and eigenvalue of the whirl for a value of the parameter."""


def birth_between(
    last: Point[O], point: Point[O], whirl_near: Callable[[O], WhirlNear], problem: Problem[O]
) -> Point[O] | None:
    """Return the cycle at which a branch is born between two of its points, if there is one.

    Its parameter is that of the Hopf point, to rounding. The cycle oscillates too little about the
    whirl to change period or parameter.
    """
    nearer = min(last, point, key=_swing)
    whirl = whirl_near(nearer.stretch)
    place = _crossing(whirl.growth, last, point)
    if place is None:
        return None
    state, rate = whirl.at(place)
    period = 2.0 * math.pi / abs(rate.imag)
    if abs(period / nearer.stretch.duration - 1.0) > SAME_FREQUENCY:
        return None
    start = state + SWING * np.linalg.norm(state) * oscillation(problem, state, period, place)
    unknowns = np.array([*start, period, place])
    return replace(nearer, unknowns=unknowns, stretch=problem.shoot(unknowns))


def oscillation(problem: Problem[O], whirl: Values, period: float, place: float) -> Values:
    """Return the direction, of length 1, in which a whirl oscillates at its Hopf point."""
    quarter = problem.shoot(np.array([*whirl, 0.25 * period, place])).monodromy
    multipliers, vectors = np.linalg.eig(quarter)
    aside = np.real(vectors[:, np.argmin(np.abs(multipliers - 1j))])
    return np.asarray(aside / np.linalg.norm(aside))


def _swing(point: Point[O]) -> float:
    """Return the largest change of a radius along a cycle."""
    low, high = point.stretch.sizes.reshape(2, -1)
    return float((high - low).max())


def _crossing(growth: Callable[[float], float], last: Point[O], point: Point[O]) -> float | None:
    """Return where a pair of eigenvalues crosses the imaginary axis near two points of a branch.

    The parameter changes with the square of the oscillation.
    """
    (one, p), (two, q) = ((_swing(each) ** 2, float(each.unknowns[-1])) for each in (last, point))
    apart = FARTHER * abs(p - q) if one == two else 0.0
    guess = p if one == two else p - one * (q - p) / (two - one)
    apart = max(apart, FARTHER * abs(p - guess), FARTHER * abs(q - guess))
    ends = max(guess - apart, 0.0), guess + apart
    try:
        return float(brentq(growth, *ends, xtol=FINEST * guess, rtol=4.0 * FINEST))
    except (ValueError, RuntimeError):  # it does not cross there
        return None


class DiscWhirl:
    """The whirl of one disc nearest to a cycle: see `WhirlNear`."""

    def __init__(self, shot: Shot, name: str) -> None:
        self._rotor, self._name = shot.rotor, name
        self._amplitude = float(shot.sizes.mean())
        self._frequency = 2.0 * math.pi / shot.duration

    def rotor_at(self, place: float) -> Rotor:
        """Return the rotor for a value of the parameter."""
        return replace(self._rotor, **{self._name: place})

    def growth(self, place: float) -> float:
        """Return the growth rate of the whirl's oscillation at the frequency of the cycle."""
        return self.at(place)[1].real

    def at(self, place: float) -> tuple[Values, complex]:
        """Return state and eigenvalue of the whirl for a value of the parameter."""
        rotor = self.rotor_at(place)
        whirls = synchronous_response(rotor, load=0.0)
        touching = whirls["in_contact"].values.ravel() == 1
        amplitudes = whirls["amplitude"].values.ravel()[touching]
        if not amplitudes.size:
            raise ValueError("there is no whirl in contact")
        nearest = int(np.argmin(np.abs(amplitudes - self._amplitude)))
        amplitude = float(amplitudes[nearest])
        lag = float(whirls["phase_lag"].values.ravel()[touching][nearest])
        rates = eigenvalues_of(np.array(amplitude), RotorColumns.of(rotor.given))
        rate = complex(rates[np.argmin(np.abs(rates - 1j * self._frequency))])
        position = amplitude * complex(math.cos(lag), -math.sin(lag))
        velocity = 1j * rotor.omega * position
        state = np.array([position.real, position.imag, velocity.real, velocity.imag])
        return state, rate
