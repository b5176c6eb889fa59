"""The wrapper round scikit-sundae: one internal step at a time, and any point inside the last.

The quirks stop here. Above this module an integration advances, can be read anywhere inside
its last step to the solver's own order, and fails with `SolverFailure`; nothing else.

scikit-sundae's `step` takes one internal step with ``"onestep"``, and reads the solver's own
interpolant with ``"normal"`` at a point that lies inside that step. After such a reading the
next ``"onestep"`` returns the end of the step once more, which `advance` passes over.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq
from sksundae.cvode import CVODE
from sksundae.ida import IDA

from rotor_ida.simulator.options import Options

Values = npt.NDArray[np.float64]
Field = Callable[[Values, Values], None]
Jacobian = Callable[[Values, Values], None]

# The solver looks at the goal only to choose its first step.
FAR_GOAL = 1e9
ROUNDING = 2.0**-52


class SolverFailure(Exception):  # noqa: N818 - always caught and turned into SimulationError
    """The solver gave up: its message, and the last good point and the values there."""

    def __init__(self, message: str, point: float, values: Values):
        super().__init__(message)
        self.message = message
        self.point = point
        self.values = values


class Integration:
    """An autonomous system on its way from a start, led one internal step at a time.

    Parameters
    ----------
    solver : CVODE or IDA
        A scikit-sundae solver that has been initialised at point 0.
    start : ndarray
        The values there.

    Attributes
    ----------
    low, point : float
        Ends of the last step.
    before, values : ndarray
        Values at those ends.
    evaluations : int
        Evaluations of the right-hand side so far.
    """

    def __init__(self, solver: Any, start: Values):
        self._solver = solver
        self.low = self.point = 0.0
        self.before = self.values = start
        self.evaluations = 0

    def advance(self) -> None:
        """Take one internal step."""
        self.low, self.before = self.point, self.values
        while self.point <= self.low:
            self.point, self.values = self._read(FAR_GOAL, "onestep")

    def at(self, point: float) -> Values:
        """Return the values at a point of the last step."""
        if point >= self.point:
            return self.values
        return self.before if point <= self.low else self._read(point, "normal")[1]

    def root(self, function: Callable[[Values], float], low: float, high: float) -> float:
        """Return a root of `function` of the values between two points of the last step.

        The function must differ in sign at the two points, or vanish at one.
        """
        tolerance = 2.0 * ROUNDING * high
        try:
            return float(brentq(lambda point: function(self.at(point)), low, high, xtol=tolerance))
        except ValueError as error:
            raise SolverFailure("a step holds no root", self.low, self.before) from error

    def _read(self, goal: float, mode: str) -> tuple[float, Values]:
        result = self._solver.step(goal, mode)
        if not result.success:
            raise SolverFailure(str(result.message).strip(), self.point, self.values)
        if not np.isfinite(result.y).all():
            raise SolverFailure("the state is no longer finite", self.point, self.values)
        self.evaluations = int(result.nfev)
        return float(result.t), result.y


def integrate(
    field: Field,
    start: Values,
    options: Options,
    *,
    atol: npt.ArrayLike | None = None,
    jacobian: Jacobian | None = None,
) -> Integration:
    """Set an integration on its way from `start`, at point 0.

    Parameters
    ----------
    field : callable
        ``field(values, rate)`` writes the rate of change.
    start : ndarray, shape (n,)
        Values at the start.
    options : Options
        Method and tolerances.
    atol : array_like, shape (n,), optional
        Absolute tolerances of one step in place of ``options.step_atol``.
    jacobian : callable, optional
        ``jacobian(values, matrix)`` writes the derivative of the rate. IDA makes its own.
    """
    tolerances = {
        "rtol": options.step_rtol,
        "atol": options.step_atol if atol is None else atol,
    }
    if options.method == "ida":
        solver = _ida(field, start, tolerances)
    else:
        method = {"adams": "Adams", "bdf": "BDF"}[options.method]
        solver = _cvode(field, jacobian, start, {"method": method, **tolerances})
    return Integration(solver, start)


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
