"""How a rotor spins: at constant speed, along ramps of the speed, or driven by a torque.

The unbalance pulls with ``(theta'**2 - i theta'') exp(i theta)``. If the speed is prescribed,
the angle theta is a piecewise quadratic function of time; with a torque, angle and speed are
integrated with the motion.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.core.runs import PIECE, SPIN, Rows

# Positions in the state of a driven rotor.
ANGLE, SPEED = -2, -1


@dataclass(frozen=True, slots=True)
class Steady:
    """A constant speed.

    Parameters
    ----------
    speed : float
        The speed [dimensionless].
    """

    speed: float

    def at(self, time: Any, _state: Values) -> tuple[Any, Any]:
        """Return angle and speed at a time, or at many."""
        return self.speed * time, self.speed

    def acceleration(self, _speed: Any, _reaction: Any, _yielding: Any = 0.0) -> Any:
        """Return the angular acceleration."""
        return 0.0

    def piece(self) -> tuple[float, ...]:
        """Return rate, torque, slope, 1/j, and the speed at the beginning."""
        return 0.0, 0.0, 0.0, 0.0, self.speed


@dataclass(frozen=True, slots=True)
class Ramp:
    """A speed that changes at a constant rate, whatever torque is required.

    Parameters
    ----------
    begin, angle, speed : float
        Time at which it begins, and angle and speed there [dimensionless].
    rate : float
        The angular acceleration [dimensionless].
    """

    begin: float
    angle: float
    speed: float
    rate: float

    def at(self, time: Any, _state: Values) -> tuple[Any, Any]:
        """Return angle and speed at a time, or at many."""
        since = time - self.begin
        return (
            self.angle + (self.speed + 0.5 * self.rate * since) * since,
            self.speed + self.rate * since,
        )

    def acceleration(self, _speed: Any, _reaction: Any, _yielding: Any = 0.0) -> Any:
        """Return the angular acceleration."""
        return self.rate

    def piece(self) -> tuple[float, ...]:
        """Return rate, torque, slope, 1/j, and the speed at the beginning."""
        return self.rate, 0.0, 0.0, 0.0, self.speed


@dataclass(frozen=True, slots=True)
class Driven:
    """A speed that changes under a torque of limited power and the reaction of the motion.

    Parameters
    ----------
    torque, slope : float
        The torque of the drive at rest, and its decrease per unit speed [dimensionless].
    inertia : float
        Moment of inertia about the centre of mass, over mass times eccentricity squared
        [dimensionless].
    """

    torque: float
    slope: float
    inertia: float

    def at(self, _time: Any, state: Values) -> tuple[Any, Any]:
        """Return angle and speed in a state, or in rows of states."""
        if state.ndim == 1:
            return float(state[ANGLE]), float(state[SPEED])
        return state[:, ANGLE], state[:, SPEED]

    def acceleration(self, speed: Any, reaction: Any, yielding: Any = 0.0) -> Any:
        """Return the angular acceleration against a reaction.

        In rolling the reaction grows with the acceleration itself, by the factor `yielding`.
        """
        return (self.torque - self.slope * speed - reaction) / (self.inertia + yielding)

    def piece(self) -> tuple[float, ...]:
        """Return rate, torque, slope, 1/j, and 0 for the speed, which is not prescribed."""
        return 0.0, self.torque, self.slope, 1.0 / self.inertia, 0.0


Spin = Steady | Ramp | Driven


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """How the speed changes during a run: a sequence of spins.

    Parameters
    ----------
    ends : tuple of float
        Time at which each spin ends [dimensionless]; the last is the end of the run.
    spins : tuple
        The spins: `Steady`, `Ramp` or `Driven`.
    """

    ends: tuple[float, ...]
    spins: tuple[Spin, ...]

    @property
    def angle(self) -> float:
        """Angle of the unbalance at time 0 [dimensionless]."""
        first = self.spins[0]
        return first.angle if isinstance(first, Ramp) else 0.0

    @property
    def is_driven(self) -> bool:
        """Whether a torque drives it."""
        return isinstance(self.spins[0], Driven)

    @property
    def is_held(self) -> bool:
        """Whether the speed stays the same."""
        return isinstance(self.spins[0], Steady)

    @property
    def speeds(self) -> Values:
        """The speeds at both ends of all spins; none of a speed that a torque drives."""
        if self.is_driven:
            return np.zeros(0)
        spins = zip(self.ends, self.spins, strict=True)
        ends = [spin.at(end, np.empty(0))[1] for end, spin in spins]
        return np.append(self.pieces()["speed"], ends)

    def pieces(self) -> Rows:
        """Return a row for each spin, for the compiled core."""
        ends = zip(self.ends, self.spins, strict=True)
        return np.array([(end, *spin.piece()) for end, spin in ends], PIECE)

    def piece_from(self, time: float) -> int:
        """Return the number of the spin that applies from a time on."""
        return bisect_right(self.ends, time, hi=len(self.ends) - 1)

    def spins_at(self, times: Values, states: Values) -> Rows:
        """Return angle and speed at given times and states, as rows of `SPIN`."""
        rows = np.empty(times.size, SPIN)
        for number, here in self._spans_of(times):
            rows["angle"][here], rows["speed"][here] = self.spins[number].at(
                times[here], states[here]
            )
        return rows

    def accelerations(
        self, times: Values, speeds: Values, reactions: Values, yielding: Any = 0.0
    ) -> Values:
        """Return the angular accelerations at times; see `Driven.acceleration`."""
        faster = np.zeros(times.size)
        held = np.broadcast_to(yielding, times.shape)
        for number, here in self._spans_of(times):
            faster[here] = self.spins[number].acceleration(
                speeds[here], reactions[here], held[here]
            )
        return faster

    def _spans_of(self, times: Values) -> Iterator[tuple[int, npt.NDArray[np.intp]]]:
        """Yield each spin that applies at some of the times, and their places."""
        # an end belongs to the spin that it ends
        numbers = np.searchsorted(self.ends[:-1], times, side="left")
        order = np.argsort(numbers, kind="stable")
        begins = np.flatnonzero(np.diff(numbers[order], prepend=-1))
        for begin, end in pairwise([*begins.tolist(), times.size]):
            yield int(numbers[order[begin]]), order[begin:end]


def steady(speed: float, duration: float) -> SpeedProfile:
    """Return the profile of a constant speed."""
    return SpeedProfile((duration,), (Steady(speed),))


def through(points: list[tuple[float, float]], duration: float) -> SpeedProfile:
    """Return a profile through points of time and speed that keeps the last speed."""
    spins: list[Spin] = []
    angle = 0.0
    for (begin, speed), (end, there) in pairwise(points):
        rate = (there - speed) / (end - begin)
        spins.append(Ramp(begin, angle, speed, rate))
        angle += 0.5 * (speed + there) * (end - begin)
    ends = [end for end, _ in points[1:]]
    if duration > ends[-1]:
        spins.append(Ramp(ends[-1], angle, points[-1][1], 0.0))
        ends.append(duration)
    return SpeedProfile(tuple(ends), tuple(spins))


def driven(torque: tuple[float, float], inertia: float, duration: float) -> SpeedProfile:
    """Return the profile of a speed driven by a torque."""
    return SpeedProfile((duration,), (Driven(*torque, inertia),))
