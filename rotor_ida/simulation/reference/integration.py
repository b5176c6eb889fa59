"""The wrapper round scikit-sundae: one internal step at a time, and any point inside the last.

The quirks stop here. scikit-sundae's `step` takes one internal step with ``"onestep"``, and reads
the solver's own interpolant with ``"normal"`` at a point that lies inside that step. After such a
reading the next ``"onestep"`` returns the end of the step once more, which `advance` passes over.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from sksundae.cvode import CVODE
from sksundae.ida import IDA

from rotor_ida.core.interface import DONE, MESSAGES, NOT_FINITE, STUCK
from rotor_ida.simulation.reference.motion import FAR_GOAL, MOST_IDLE_STEPS

Values = npt.NDArray[np.float64]
Field = Callable[[Values, Values], None]
Jacobian = Callable[[Values, Values], None]


class Integration:
    """A `Motion` led through the public interface of scikit-sundae.

    Parameters
    ----------
    method : {"adams", "bdf", "ida"}
        CVODE with Adams or BDF, or IDA.
    rtol : float
        Relative tolerance of one step.
    field : callable
        ``field(values, rate)`` writes the rate of change.
    jacobian : callable, optional
        ``jacobian(values, matrix)`` writes the derivative of the rate. IDA makes its own.

    Attributes
    ----------
    message : str
        What the solver said when it gave up.
    """

    def __init__(
        self, method: str, rtol: float, field: Field, jacobian: Jacobian | None = None
    ) -> None:
        # SUNDIALS would write its warnings to standard output.
        os.environ.setdefault("SUNLOGGER_WARNING_FILENAME", os.devnull)
        self._method, self._rtol = method, rtol
        self._field, self._jacobian = field, jacobian
        self._solver: Any = None
        self._count = 0
        self.low = self.point = 0.0
        self.before = self.values = np.empty(0)
        self.message = ""

    def restart(self, start: Values, atol: Values) -> int:
        """Begin anew from `start` at point 0, with absolute tolerances `atol`."""
        settings: dict[str, Any] = {"rtol": self._rtol, "atol": atol}
        if self._method == "ida":
            self._solver = _ida(self._field, start, settings)
        else:
            settings["method"] = {"adams": "Adams", "bdf": "BDF"}[self._method]
            self._solver = _cvode(self._field, self._jacobian, start, settings)
        self.low = self.point = 0.0
        self.before = self.values = start
        self._count = 0
        return DONE

    def advance(self) -> int:
        """Take one internal step; return 0, or why it could not be taken."""
        self.low, self.before = self.point, self.values
        for _ in range(MOST_IDLE_STEPS):
            result = self._solver.step(FAR_GOAL, "onestep")
            if not result.success:
                self.message = str(result.message).strip()
                return int(result.status)
            if not np.isfinite(result.y).all():
                self.message = MESSAGES[NOT_FINITE]
                return NOT_FINITE
            self.point, self.values, self._count = float(result.t), result.y, int(result.nfev)
            if self.point > self.low:
                return DONE
        self.message = MESSAGES[STUCK]
        return STUCK

    def at(self, point: float) -> Values:
        """Return the values at a point of the last step; NaN where they cannot be read."""
        if point >= self.point:
            return self.values
        if point <= self.low:
            return self.before
        result = self._solver.step(point, "normal")
        values: Values = result.y if result.success else np.full_like(self.values, np.nan)
        return values

    def glance_at(self, point: float) -> Values:
        """Do as `at` does."""
        return self.at(point)

    def evaluations(self) -> int:
        """Return the number of evaluations of the right-hand side since the start."""
        return self._count


def _cvode(
    field: Field, jacobian: Jacobian | None, start: Values, settings: dict[str, Any]
) -> CVODE:
    def rhs(_time: float, values: Values, rate: Values) -> None:
        field(values, rate)

    if jacobian is not None:
        derivative = jacobian

        def jacfn(_time: float, values: Values, _rate: Values, matrix: Values) -> None:
            derivative(values, matrix)

        settings["jacfn"] = jacfn
    solver = CVODE(rhs, **settings)
    solver.init_step(0.0, start)
    return solver


def _ida(field: Field, start: Values, settings: dict[str, Any]) -> IDA:
    wanted = np.empty_like(start)

    def residual(_time: float, values: Values, rate: Values, out: Values) -> None:
        field(values, wanted)
        np.subtract(rate, wanted, out=out)

    field(start, wanted)
    solver = IDA(residual, **settings)
    solver.init_step(0.0, start, wanted.copy())
    return solver
