"""A `Motion` that calls CVODE from compiled code, without Python on the way.

It makes the same calls with the same settings as scikit-sundae does: Adams or BDF, Newton's
method, a dense linear solver. Only samples may differ, by rounding: where a step holds many, the
solver's interpolant is fetched once as a polynomial and evaluated here.

Compiled code knows an integration by the address of one block of memory, which SUNDIALS owns. An
object of numba's own would have its references counted at every call, which took a tenth of the
time.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba import carray, extending
from numba.core import types
from numba.extending import overload_attribute, overload_method

from rotor_ida.equations.compiling import compiled
from rotor_ida.simulation.cvode.interface import (
    REALS,
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
from rotor_ida.simulation.motion import (
    FAR_GOAL,
    GOES_ON,
    MOST_IDLE_STEPS,
    NOT_FINITE,
    STUCK,
    Motion,
)

Values = npt.NDArray[np.float64]

_intrinsic: Any = extending.intrinsic

# The block begins with 16 numbers, the first four real and the others whole.
LOW, POINT, REACHED, RTOL = range(4)
SIZE, DEGREE, READINGS, ANSWER = range(4, 8)
MEMORY, CONTEXT, MATRIX, LINEAR, BLOCK, STATE, TOLERANCE, DERIVATIVE = range(8, 16)
HEAD = 16
HIGHEST_ORDER = 12
# Rows as long as the state follow: what CVODE writes and reads; the step before, a reading, and
# the Taylor series of the last step about its end, scaled by the step.
VALUES, TOLERANCES, DERIVATIVES, BEFORE, READING, SERIES = range(6)
ROWS = SERIES + HIGHEST_ORDER + 1

METHODS = {"adams": 1, "bdf": 2}
ONE_STEP = 2
# To fetch the interpolant takes as long as so many single readings.
FEW_READINGS = 6


class DirectType(types.Type):
    """The type of an integration that compiled code leads: the address of its block."""

    def __init__(self) -> None:
        super().__init__(name="Direct")


DIRECT = DirectType()


@extending.register_model(DirectType)
class _DirectModel(extending.models.PrimitiveModel):
    """An address."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, ir.IntType(64))


@_intrinsic
def integration_at(_typing: Any, _address: Any) -> Any:
    """Return the integration whose block begins at an address."""
    return DIRECT(types.intp), lambda _context, _builder, _signature, arguments: arguments[0]


@_intrinsic
def reals_of(_typing: Any, _motion: Any) -> Any:
    """Return the block of an integration as real numbers."""

    def code(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())

    return REALS(DIRECT), code


@_intrinsic
def integers_of(_typing: Any, _motion: Any) -> Any:
    """Return the block of an integration as whole numbers."""

    def code(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], ir.IntType(64).as_pointer())

    return types.CPointer(types.int64)(DIRECT), code


@_intrinsic
def address_of(_typing: Any, _motion: Any) -> Any:
    """Return where the block of an integration begins."""
    return types.intp(DIRECT), lambda _context, _builder, _signature, arguments: arguments[0]


@compiled
def row_of(motion: Any, number: int) -> Values:
    """Return one row of the block of an integration."""
    size = integers_of(motion)[SIZE]
    start = HEAD + size * number
    row: Values = carray(reals_of(motion), HEAD + size * ROWS)[start : start + size]
    return row


@compiled
def open_direct(
    size: int, method: int, rtol: float, parameters: Values, field: int, jacobian: int
) -> Motion:
    """Make an integration of `size` equations, its right-hand side at the address `field`.

    The address `jacobian` may be 0; `parameters`, where the right-hand side finds them, must
    outlive the integration. Whoever opens it must close it.
    """
    handle = np.zeros(1, np.intp)
    context_create(0, handle.ctypes.data)
    context = handle[0]
    handlers_clear(context)
    block = vector_new(HEAD + size * ROWS, context)
    memory = carray(vector_data(block), HEAD + size * ROWS)
    memory[:] = 1.0
    motion: Any = integration_at(memory.ctypes.data)
    integers = integers_of(motion)
    integers[SIZE], integers[BLOCK], integers[CONTEXT] = size, block, context
    reals_of(motion)[RTOL] = rtol
    integers[STATE] = vector_over(size, row_of(motion, VALUES).ctypes.data, context)
    integers[TOLERANCE] = vector_over(size, row_of(motion, TOLERANCES).ctypes.data, context)
    integers[DERIVATIVE] = vector_over(size, row_of(motion, DERIVATIVES).ctypes.data, context)
    vector_fuse(integers[STATE], 1)
    solver = cvode_create(method, context)
    integers[MEMORY] = solver
    cvode_init(solver, field, 0.0, integers[STATE])
    cvode_user_data(solver, parameters.ctypes.data)
    cvode_tolerances(solver, rtol, integers[TOLERANCE])
    integers[MATRIX] = matrix_new(size, size, context)
    integers[LINEAR] = linear_new(integers[STATE], integers[MATRIX], context)
    cvode_linear(solver, integers[LINEAR], integers[MATRIX])
    if jacobian != 0:
        cvode_jacobian(solver, jacobian)
    opened: Motion = motion
    return opened


@compiled
def close_direct(motion: Any) -> None:
    """Free all that SUNDIALS holds, the integration's own memory last."""
    integers, handle = integers_of(motion), np.zeros(1, np.intp)
    handle[0] = integers[MEMORY]
    cvode_free(handle.ctypes.data)
    linear_free(integers[LINEAR])
    matrix_free(integers[MATRIX])
    vector_free(integers[STATE])
    vector_free(integers[TOLERANCE])
    vector_free(integers[DERIVATIVE])
    handle[0] = integers[CONTEXT]
    vector_free(integers[BLOCK])
    context_free(handle.ctypes.data)


@compiled
def _restart(motion: Any, start: Values, atol: Values) -> int:
    reals, integers = reals_of(motion), integers_of(motion)
    row_of(motion, VALUES)[:] = start
    row_of(motion, BEFORE)[:] = start
    row_of(motion, TOLERANCES)[:] = atol
    reals[LOW] = reals[POINT] = 0.0
    integers[DEGREE], integers[READINGS] = -1, 0
    status = cvode_reinit(integers[MEMORY], 0.0, integers[STATE])
    if status == GOES_ON:
        status = cvode_tolerances(integers[MEMORY], reals[RTOL], integers[TOLERANCE])
    return int(status)


@compiled
def _advance(motion: Any) -> int:
    reals, integers = reals_of(motion), integers_of(motion)
    values, before = row_of(motion, VALUES), row_of(motion, BEFORE)
    reals[LOW] = reals[POINT]
    integers[DEGREE], integers[READINGS] = -1, 0
    for number in range(values.size):
        before[number] = values[number]
    for _ in range(MOST_IDLE_STEPS):
        answer = address_of(motion) + 8 * REACHED
        status = cvode_solve(integers[MEMORY], FAR_GOAL, integers[STATE], answer, ONE_STEP)
        total = 0.0
        for number in range(values.size):
            total += 0.0 * values[number]
        if status < 0 or total != 0.0:
            values[:] = before
            return int(status) if status < 0 else NOT_FINITE
        reals[POINT] = reals[REACHED]
        if reals[POINT] > reals[LOW]:
            return GOES_ON
    return STUCK


@compiled
def _fetch(motion: Any) -> None:
    """Fetch the interpolant of the last step."""
    reals, integers = reals_of(motion), integers_of(motion)
    integers[ANSWER] = 0
    cvode_order(integers[MEMORY], address_of(motion) + 8 * ANSWER)
    integers[DEGREE] = integers[ANSWER]
    derivative = row_of(motion, DERIVATIVES)
    scale, step = 1.0, reals[POINT] - reals[LOW]
    for power in range(integers[DEGREE] + 1):
        cvode_derivative(integers[MEMORY], reals[POINT], power, integers[DERIVATIVE])
        series = row_of(motion, SERIES + power)
        for number in range(derivative.size):
            series[number] = scale * derivative[number]
        scale *= step / (power + 1.0)


@compiled
def _at(motion: Any, point: float) -> Values:
    reals, integers = reals_of(motion), integers_of(motion)
    if point >= reals[POINT]:
        return row_of(motion, VALUES)
    if point <= reals[LOW]:
        return row_of(motion, BEFORE)
    cvode_derivative(integers[MEMORY], point, 0, integers[DERIVATIVE])
    return row_of(motion, DERIVATIVES)


@compiled
def _glance_at(motion: Any, point: float) -> Values:
    reals, integers = reals_of(motion), integers_of(motion)
    low, high = reals[LOW], reals[POINT]
    if integers[DEGREE] < 0:
        if integers[READINGS] < FEW_READINGS or point >= high or point <= low:
            integers[READINGS] += 1
            return _at(motion, point)
        _fetch(motion)
    back = (point - high) / (high - low)
    reading = row_of(motion, READING)
    reading[:] = row_of(motion, SERIES + integers[DEGREE])
    for power in range(integers[DEGREE] - 1, -1, -1):
        series = row_of(motion, SERIES + power)
        for number in range(reading.size):
            reading[number] = reading[number] * back + series[number]
    return reading


@compiled
def _evaluations(motion: Any) -> int:
    integers = integers_of(motion)
    integers[ANSWER] = 0
    cvode_count(integers[MEMORY], address_of(motion) + 8 * ANSWER)
    return int(integers[ANSWER])


@overload_attribute(DirectType, "low")
def _low(motion: Any) -> Any:  # noqa: ARG001 - types
    def get(motion: Any) -> Any:
        return reals_of(motion)[LOW]

    return get


@overload_attribute(DirectType, "point")
def _point(motion: Any) -> Any:  # noqa: ARG001 - types
    def get(motion: Any) -> Any:
        return reals_of(motion)[POINT]

    return get


@overload_attribute(DirectType, "before")
def _before(motion: Any) -> Any:  # noqa: ARG001 - types
    def get(motion: Any) -> Any:
        return row_of(motion, BEFORE)

    return get


@overload_attribute(DirectType, "values")
def _values(motion: Any) -> Any:  # noqa: ARG001 - types
    def get(motion: Any) -> Any:
        return row_of(motion, VALUES)

    return get


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
