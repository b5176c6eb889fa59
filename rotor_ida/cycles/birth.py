"""Where a branch of limit cycles is born from a synchronous whirl: a Hopf point, exactly.

Followed through it, a branch comes back along itself, half a period later: the field at the start,
which vanishes with the swing of the radius, turns round. The whirl that begins to oscillate there
is known in closed form, and so is where.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.stability import eigenvalues
from rotor_ida.closed_forms.synchronous import synchronous_response
from rotor_ida.cycles.continuation import Point, Problem
from rotor_ida.cycles.shooting import Cycle
from rotor_ida.model.parameters import Rotor
from rotor_ida.simulation.neighbours import Shot

# The bifurcation is sought so many times farther than two points by it tell.
FARTHER = 4.0
# The whirl's frequency is that of a cycle close by, to this part.
SAME_FREQUENCY = 0.1
# By how much a cycle there swings, in parts of its size: its square is below rounding.
SWING = 3e-7
# Digits to which the parameter is sought.
FINEST = 1e-15


def turns_round(last: Point[Shot], point: Point[Shot]) -> bool:
    """Return whether a step of a branch has passed a whirl, where the swing of a cycle vanishes."""
    return float(last.stretch.start_rate @ point.stretch.start_rate) < 0.0


def birth_between(
    last: Point[Shot], point: Point[Shot], name: str, problem: Problem[Shot]
) -> Point[Shot] | None:
    """Return the cycle at which a branch is born between two of its points, if there is one.

    The parameter `name` is that of the Hopf point, to rounding; the cycle swings by so little about
    the whirl there that it changes neither period nor parameter.
    """
    nearer = min(last, point, key=_swing)
    whirl = _WhirlNear(nearer.stretch, name)
    place = _crossing(whirl.growth, last, point)
    if place is None:
        return None
    state, rate = whirl.at(place)
    period = 2.0 * math.pi / abs(rate.imag)
    if abs(period / nearer.stretch.duration - 1.0) > SAME_FREQUENCY:
        return None
    quarter = problem.shoot(np.array([*state, 0.25 * period, place])).monodromy
    multipliers, vectors = np.linalg.eig(quarter)
    aside = np.real(vectors[:, np.argmin(np.abs(multipliers - 1j))])
    start = state + SWING * np.linalg.norm(state) / np.linalg.norm(aside) * aside
    unknowns = np.array([*start, period, place])
    return replace(nearer, unknowns=unknowns, stretch=problem.shoot(unknowns))


def _swing(point: Point[Shot]) -> float:
    cycle = Cycle(point.stretch, 0.0)
    return cycle.radius_max - cycle.radius_min


def _crossing(
    growth: Callable[[float], float], last: Point[Shot], point: Point[Shot]
) -> float | None:
    """Return where a pair of eigenvalues crosses the imaginary axis near two points of a branch.

    The parameter changes with the square of the swing.
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


class _WhirlNear:
    """The whirl nearest to a cycle whose swing is small, over a parameter."""

    def __init__(self, shot: Shot, name: str) -> None:
        cycle = Cycle(shot, 0.0)
        self._rotor, self._name = shot.rotor, name
        self._amplitude = 0.5 * (cycle.radius_min + cycle.radius_max)
        self._frequency = 2.0 * math.pi / shot.duration

    def rotor_at(self, place: float) -> Rotor:
        """Return the rotor with the parameter at a place."""
        return replace(self._rotor, **{self._name: place})

    def growth(self, place: float) -> float:
        """Return how fast the oscillation of the whirl grows that is as fast as the cycle's."""
        return self.at(place)[1].real

    def at(self, place: float) -> tuple[Values, complex]:
        """Return state and eigenvalue of the whirl with the parameter at a place."""
        given = self.rotor_at(place).given
        given.pop("load", None)
        given.pop("disc_radius", None)
        whirls = synchronous_response(**given)
        touching = whirls["in_contact"].values.ravel() == 1
        amplitudes = whirls["amplitude"].values.ravel()[touching]
        if not amplitudes.size:
            raise ValueError("no whirl is in contact")
        nearest = int(np.argmin(np.abs(amplitudes - self._amplitude)))
        amplitude = float(amplitudes[nearest])
        lag = float(whirls["phase_lag"].values.ravel()[touching][nearest])
        rates = eigenvalues(amplitude, **given)
        rate = complex(rates[np.argmin(np.abs(rates - 1j * self._frequency))])
        position = amplitude * complex(math.cos(lag), -math.sin(lag))
        velocity = 1j * given["omega"] * position
        state = np.array([position.real, position.imag, velocity.real, velocity.imag])
        return state, rate
