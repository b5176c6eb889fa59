"""The solvers of scikit-sundae, one internal step at a time."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq
from sksundae.cvode import CVODE
from sksundae.ida import IDA

from rotor_ida.arrays import ROUNDING, Values
from rotor_ida.errors import SimulationError

Rates = Callable[[float, Values, Values], None]
Function = Callable[[float], float]

# SUNDIALS may need a few calls for a step: after a reading the first one only returns to its end.
MOST_IDLE_STEPS = 100


class Integration:
    """A solver of scikit-sundae: one internal step at a time, and any time inside the last.

    Its `step` takes one internal step with ``"onestep"``, and reads the solver's own interpolant
    with ``"normal"`` at a time inside that step. After such a reading the next ``"onestep"``
    returns the end of the step once more, which `advance` passes over.

    Parameters
    ----------
    method : {"adams", "bdf", "ida"}
        CVODE with Adams or BDF, or IDA.
    rates : callable
        ``rates(time, state, rate)`` writes the rate of change.
    tolerances : tuple
        Relative and absolute tolerance of one step; the second may be an array.
    time, state : float and ndarray
        Where it begins.
    goal : float
        A time to step towards, which limits only the first step.

    Attributes
    ----------
    low, high : float
        The times at both ends of the last step.
    before, after : ndarray
        The states there.
    """

    def __init__(
        self,
        method: str,
        rates: Rates,
        tolerances: tuple[float, float | Values],
        time: float,
        state: Values,
        *,
        goal: float,
    ) -> None:
        # SUNDIALS would write its warnings to standard output.
        os.environ.setdefault("SUNLOGGER_WARNING_FILENAME", os.devnull)
        settings = {"rtol": tolerances[0], "atol": tolerances[1]}
        rate = np.empty_like(state)
        self._solver: Any
        if method == "ida":

            def residual(time: float, state: Values, slope: Values, out: Values) -> None:
                rates(time, state, rate)
                np.subtract(slope, rate, out=out)

            self._solver = IDA(residual, **settings)
            rates(time, state, rate)
            self._solver.init_step(time, state, rate.copy())
        else:
            name = {"adams": "Adams", "bdf": "BDF"}[method]
            self._solver = CVODE(rates, method=name, **settings)
            self._solver.init_step(time, state)
        self._goal = goal
        self._read: dict[float, Values] = {}
        self._found: dict[tuple[Any, int, float], Any] = {}
        self.low = self.high = time
        self.before = self.after = state
        self.evaluations = 0

    def advance(self) -> None:
        """Take one internal step, or raise `SimulationError`."""
        self.low, self.before = self.high, self.after
        self._read.clear()
        self._found = {key: found for key, found in self._found.items() if key[-1] == self.low}
        for _ in range(MOST_IDLE_STEPS):
            found = self._solver.step(self._goal, "onestep")
            if not found.success:
                raise self.failure(str(found.message).strip())
            if not math.isfinite(found.y.dot(found.y)):
                raise self.failure("the state is no longer finite")
            self.high, self.after, self.evaluations = float(found.t), found.y, int(found.nfev)
            if self.high > self.low:
                return
        raise self.failure("time no longer advances")

    def looks(self, count: int, end: float | None = None) -> list[float]:
        """Return times that divide the last step, up to an `end`, into `count` equal parts."""
        high = self.high if end is None else end
        low, apart = self.low, (high - self.low) / count
        return [low, *[low + apart * k for k in range(1, count)], high]

    def at(self, time: float) -> Values:
        """Return the state at a time of the last step."""
        if time <= self.low or time >= self.high:
            return self.before if time <= self.low else self.after
        if time not in self._read:
            found = self._solver.step(time, "normal")
            if not found.success:
                raise self.failure(str(found.message).strip())
            self._read[time] = found.y
        return self._read[time]

    def once(self, function: Callable[[int, float, Values], Any], number: int, time: float) -> Any:
        """Return what a function of a contact is at a time of the last step, called once there."""
        key = function, number, time
        if key not in self._found:
            self._found[key] = function(number, time, self.at(time))
        return self._found[key]

    def root(self, function: Function, low: float, high: float) -> float:
        """Return the zero, in the last step, of a function of time that changes sign."""
        spacing = 4.0 * ROUNDING
        return float(brentq(function, low, high, xtol=spacing, rtol=spacing))

    def failure(self, message: str, time: float | None = None) -> SimulationError:
        """Return the error that ends the run, at a time of the last step or at its beginning."""
        ended = self.low if time is None else time
        x, y, vx, vy = self.at(ended)[:4].tolist()
        return SimulationError(message, time=ended, state=(x, y, vx, vy))
