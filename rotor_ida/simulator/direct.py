"""A `Motion` that calls CVODE from compiled code, without Python on the way.

It makes the same calls with the same settings as scikit-sundae does: Adams or BDF, Newton's
method, a dense linear solver. Only samples may differ, by rounding: where a step holds many, the
solver's interpolant is fetched once as a polynomial and evaluated here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import carray
from numba.extending import overload_method

from rotor_ida.compiling import compiled, structure
from rotor_ida.simulator.calls import (
    context_create,
    context_free,
    cvode_count,
    cvode_create,
    cvode_derivative,
    cvode_free,
    cvode_init,
    cvode_jacobian,
    cvode_linear,
    cvode_order,
    cvode_reinit,
    cvode_solve,
    cvode_tolerances,
    cvode_user_data,
    handlers_clear,
    linear_free,
    linear_new,
    matrix_free,
    matrix_new,
    vector_data,
    vector_free,
    vector_fuse,
    vector_new,
    vector_over,
)
from rotor_ida.simulator.motion import FAR_GOAL, GOES_ON, NOT_FINITE, Motion

Values = npt.NDArray[np.float64]
Handles = npt.NDArray[np.intp]

METHODS = {"adams": 1, "bdf": 2}
ONE_STEP = 2
HIGHEST_ORDER = 12
# To fetch the interpolant takes as long as so many single readings.
FEW_LOOKS = 6


@dataclass(slots=True)
class Direct:
    """An integration by CVODE that compiled code leads.

    The name stands for a structure with these fields in compiled code, where it has the methods
    of `rotor_ida.simulator.motion.Motion` besides. The arrays of reals lie in memory that
    SUNDIALS owns: no reference to them is counted, which would cost a sixth of the time.

    Parameters
    ----------
    low, point : float
        Ends of the last step.
    before, values : ndarray, shape (n,)
        Values at those ends; CVODE writes the latter in place.
    tolerances, reading, derivative : ndarray, shape (n,)
        Absolute tolerances; the last values read inside a step; a derivative fetched from CVODE.
    polynomial : ndarray, shape (13, n)
        The interpolant of the last step, in the part of the step counted back from its end.
    reached : ndarray, shape (1,)
        Where CVODE answers with a real.
    degree, looks : int
        Degree of the interpolant, or -1 before it is fetched; number of readings before that.
    rtol : float
        Relative tolerance of one step.
    memory, state : int
        Addresses of CVODE's memory and of the vector over `values`.
    handles : ndarray, shape (8,)
        Addresses of all of the solver's objects.
    answer : ndarray, shape (1,)
        Where CVODE answers with an integer.
    parameters : ndarray, shape (3,)
        omega, zeta and delta0, where the right-hand side finds them.
    """

    low: float
    point: float
    before: Values
    values: Values
    tolerances: Values
    reading: Values
    derivative: Values
    polynomial: Values
    reached: Values
    degree: int
    looks: int
    rtol: float
    memory: int
    state: int
    handles: Handles
    answer: npt.NDArray[np.int64]
    parameters: Values


DirectType = structure(Direct)

_MEMORY, _CONTEXT, _MATRIX, _LINEAR, _ARENA, _STATE, _TOLERANCE, _DERIVATIVE = range(8)


@compiled
def open_direct(
    size: int, method: int, rtol: float, parameters: Values, field: int, jacobian: int
) -> Motion:
    """Make an integration of `size` equations, its right-hand side at the address `field`.

    The address `jacobian` may be 0. Whoever opens it must close it.
    """
    handles = np.zeros(8, np.intp)
    context_create(0, handles[_CONTEXT:].ctypes.data)
    context = handles[_CONTEXT]
    handlers_clear(context)
    rows = 6 + HIGHEST_ORDER
    handles[_ARENA] = vector_new(size * rows + 1, context)
    arena = carray(vector_data(handles[_ARENA]), size * rows + 1)
    arena[:] = 1.0
    table = arena[: size * rows].reshape(rows, size)
    values, tolerances, derivative = table[0], table[1], table[2]
    handles[_STATE] = vector_over(size, values.ctypes.data, context)
    handles[_TOLERANCE] = vector_over(size, tolerances.ctypes.data, context)
    handles[_DERIVATIVE] = vector_over(size, derivative.ctypes.data, context)
    vector_fuse(handles[_STATE], 1)
    memory = cvode_create(method, context)
    handles[_MEMORY] = memory
    cvode_init(memory, field, 0.0, handles[_STATE])
    cvode_user_data(memory, parameters.ctypes.data)
    cvode_tolerances(memory, rtol, handles[_TOLERANCE])
    handles[_MATRIX] = matrix_new(size, size, context)
    handles[_LINEAR] = linear_new(handles[_STATE], handles[_MATRIX], context)
    cvode_linear(memory, handles[_LINEAR], handles[_MATRIX])
    if jacobian != 0:
        cvode_jacobian(memory, jacobian)
    return Direct(  # type: ignore[return-value] # the structure has the methods
        0.0,
        0.0,
        table[3],
        values,
        tolerances,
        table[4],
        derivative,
        table[5:],
        arena[size * rows :],
        -1,
        0,
        rtol,
        memory,
        handles[_STATE],
        handles,
        np.zeros(1, np.int64),
        parameters,
    )


@compiled
def close_direct(motion: Any) -> None:
    """Free all that SUNDIALS holds; the arrays of reals go with it."""
    handles = motion.handles
    cvode_free(handles[_MEMORY:].ctypes.data)
    linear_free(handles[_LINEAR])
    matrix_free(handles[_MATRIX])
    for vector in (_STATE, _TOLERANCE, _DERIVATIVE, _ARENA):
        vector_free(handles[vector])
    context_free(handles[_CONTEXT:].ctypes.data)


@compiled
def _restart(motion: Direct, start: Values, atol: Values) -> int:
    motion.values[:] = start
    motion.before[:] = start
    motion.tolerances[:] = atol
    motion.low = motion.point = 0.0
    motion.degree, motion.looks = -1, 0
    status = cvode_reinit(motion.memory, 0.0, motion.state)
    if status == GOES_ON:
        status = cvode_tolerances(motion.memory, motion.rtol, motion.handles[_TOLERANCE])
    return int(status)


@compiled
def _advance(motion: Direct) -> int:
    values, before, reached = motion.values, motion.before, motion.reached
    motion.low = motion.point
    motion.degree, motion.looks = -1, 0
    for number in range(values.size):
        before[number] = values[number]
    while motion.point <= motion.low:
        status = cvode_solve(motion.memory, FAR_GOAL, motion.state, reached.ctypes.data, ONE_STEP)
        total = 0.0
        for number in range(values.size):
            total += 0.0 * values[number]
        if status < 0 or total != 0.0:
            values[:] = before
            return int(status) if status < 0 else NOT_FINITE
        motion.point = reached[0]
    return GOES_ON


@compiled
def _fetch(motion: Direct) -> None:
    """Fetch the interpolant: its Taylor series about the end of the step, scaled by the step."""
    step, polynomial, derivative = motion.point - motion.low, motion.polynomial, motion.derivative
    motion.answer[0] = 0
    cvode_order(motion.memory, motion.answer.ctypes.data)
    motion.degree = motion.answer[0]
    vector = motion.handles[_DERIVATIVE]
    scale = 1.0
    for power in range(motion.degree + 1):
        cvode_derivative(motion.memory, motion.point, power, vector)
        for number in range(derivative.size):
            polynomial[power, number] = scale * derivative[number]
        scale *= step / (power + 1.0)


@compiled
def _at(motion: Direct, point: float) -> Values:
    if point >= motion.point:
        return motion.values
    if point <= motion.low:
        return motion.before
    cvode_derivative(motion.memory, point, 0, motion.handles[_DERIVATIVE])
    return motion.derivative


@compiled
def _glance_at(motion: Direct, point: float) -> Values:
    if motion.degree < 0:
        if motion.looks < FEW_LOOKS or point >= motion.point or point <= motion.low:
            motion.looks += 1
            return _at(motion, point)
        _fetch(motion)
    back = (point - motion.point) / (motion.point - motion.low)
    reading, polynomial = motion.reading, motion.polynomial
    for number in range(reading.size):
        value = polynomial[motion.degree, number]
        for power in range(motion.degree - 1, -1, -1):
            value = value * back + polynomial[power, number]
        reading[number] = value
    return reading


@compiled
def _evaluations(motion: Direct) -> int:
    motion.answer[0] = 0
    cvode_count(motion.memory, motion.answer.ctypes.data)
    return int(motion.answer[0])


@overload_method(DirectType, "restart")
def _method_restart(motion: Any, start: Any, atol: Any) -> Any:  # noqa: ARG001 - types
    def call(motion: Any, start: Any, atol: Any) -> Any:
        return _restart(motion, start, atol)

    return call


@overload_method(DirectType, "advance", inline="always")
def _method_advance(motion: Any) -> Any:  # noqa: ARG001 - types
    def call(motion: Any) -> Any:
        return _advance(motion)

    return call


@overload_method(DirectType, "at")
def _method_at(motion: Any, point: Any) -> Any:  # noqa: ARG001 - types
    def call(motion: Any, point: Any) -> Any:
        return _at(motion, point)

    return call


@overload_method(DirectType, "glance_at")
def _method_glance_at(motion: Any, point: Any) -> Any:  # noqa: ARG001 - types
    def call(motion: Any, point: Any) -> Any:
        return _glance_at(motion, point)

    return call


@overload_method(DirectType, "evaluations")
def _method_evaluations(motion: Any) -> Any:  # noqa: ARG001 - types
    def call(motion: Any) -> Any:
        return _evaluations(motion)

    return call
