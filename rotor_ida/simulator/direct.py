"""A `Motion` that calls CVODE from compiled code, without Python on the way.

It makes the same calls with the same settings as scikit-sundae does: Adams or BDF, Newton's
method, a dense linear solver. Only samples may differ, by rounding: where a step holds many, the
solver's interpolant is fetched once as a polynomial and evaluated here.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import carray, farray
from numba.core import types
from numba.core.typing import signature
from numba.extending import overload_method

from rotor_ida.compiling import callback, compiled, structure
from rotor_ida.errors import InputError
from rotor_ida.model import rotating_field_into, rotating_jacobian_into
from rotor_ida.simulator import cartesian_phase, contact_phase, sundials
from rotor_ida.simulator.contact_phase import contact_field
from rotor_ida.simulator.motion import FAR_GOAL, GOES_ON, NOT_FINITE, Motion

Values = npt.NDArray[np.float64]
Handles = npt.NDArray[np.intp]

METHODS = {"adams": 1, "bdf": 2}
ONE_STEP = 2
HIGHEST_ORDER = 12
# To fetch the interpolant takes as long as so many single readings.
FEW_LOOKS = 6

_PLACE, _FLAG, _SIZE, _REAL, _NOTHING = (
    types.intp,
    types.intc,
    types.int64,
    types.float64,
    types.void,
)
_REALS = types.CPointer(types.float64)


def _external(name: str, result: types.Type, *arguments: types.Type) -> Any:
    return types.ExternalFunction(name, signature(result, *arguments))


_context_create = _external("SUNContext_Create", _FLAG, types.intc, _PLACE)
_context_free = _external("SUNContext_Free", _FLAG, _PLACE)
_clear_handlers = _external("SUNContext_ClearErrHandlers", _FLAG, _PLACE)
_vector_new = _external("N_VNew_Serial", _PLACE, _SIZE, _PLACE)
_vector_over = _external("N_VMake_Serial", _PLACE, _SIZE, _PLACE, _PLACE)
_fuse = _external("N_VEnableFusedOps_Serial", _FLAG, _PLACE, types.intc)
_vector_free = _external("N_VDestroy", _NOTHING, _PLACE)
_vector_data = _external("N_VGetArrayPointer", _REALS, _PLACE)
_matrix_new = _external("SUNDenseMatrix", _PLACE, _SIZE, _SIZE, _PLACE)
_matrix_free = _external("SUNMatDestroy", _NOTHING, _PLACE)
_matrix_data = _external("SUNDenseMatrix_Data", _REALS, _PLACE)
_linear_new = _external("SUNLinSol_Dense", _PLACE, _PLACE, _PLACE, _PLACE)
_linear_free = _external("SUNLinSolFree", _FLAG, _PLACE)
_create = _external("CVodeCreate", _PLACE, types.intc, _PLACE)
_free = _external("CVodeFree", _NOTHING, _PLACE)
_init = _external("CVodeInit", _FLAG, _PLACE, _PLACE, _REAL, _PLACE)
_reinit = _external("CVodeReInit", _FLAG, _PLACE, _REAL, _PLACE)
_tolerances = _external("CVodeSVtolerances", _FLAG, _PLACE, _REAL, _PLACE)
_user_data = _external("CVodeSetUserData", _FLAG, _PLACE, _PLACE)
_linear_set = _external("CVodeSetLinearSolver", _FLAG, _PLACE, _PLACE, _PLACE)
_jacobian_set = _external("CVodeSetJacFn", _FLAG, _PLACE, _PLACE)
_solve = _external("CVode", _FLAG, _PLACE, _REAL, _PLACE, _PLACE, types.intc)
_derivative = _external("CVodeGetDky", _FLAG, _PLACE, _REAL, types.intc, _PLACE)
_order = _external("CVodeGetLastOrder", _FLAG, _PLACE, _PLACE)
_count = _external("CVodeGetNumRhsEvals", _FLAG, _PLACE, _PLACE)


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
    _context_create(0, handles[_CONTEXT:].ctypes.data)
    context = handles[_CONTEXT]
    _clear_handlers(context)
    rows = 6 + HIGHEST_ORDER
    handles[_ARENA] = _vector_new(size * rows + 1, context)
    arena = carray(_vector_data(handles[_ARENA]), size * rows + 1)
    arena[:] = 1.0
    table = arena[: size * rows].reshape(rows, size)
    values, tolerances, derivative = table[0], table[1], table[2]
    handles[_STATE] = _vector_over(size, values.ctypes.data, context)
    handles[_TOLERANCE] = _vector_over(size, tolerances.ctypes.data, context)
    handles[_DERIVATIVE] = _vector_over(size, derivative.ctypes.data, context)
    _fuse(handles[_STATE], 1)
    memory = _create(method, context)
    handles[_MEMORY] = memory
    _init(memory, field, 0.0, handles[_STATE])
    _user_data(memory, parameters.ctypes.data)
    _tolerances(memory, rtol, handles[_TOLERANCE])
    handles[_MATRIX] = _matrix_new(size, size, context)
    handles[_LINEAR] = _linear_new(handles[_STATE], handles[_MATRIX], context)
    _linear_set(memory, handles[_LINEAR], handles[_MATRIX])
    if jacobian != 0:
        _jacobian_set(memory, jacobian)
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
    _free(handles[_MEMORY:].ctypes.data)
    _linear_free(handles[_LINEAR])
    _matrix_free(handles[_MATRIX])
    for vector in (_STATE, _TOLERANCE, _DERIVATIVE, _ARENA):
        _vector_free(handles[vector])
    _context_free(handles[_CONTEXT:].ctypes.data)


@compiled
def _restart(motion: Direct, start: Values, atol: Values) -> int:
    motion.values[:] = start
    motion.before[:] = start
    motion.tolerances[:] = atol
    motion.low = motion.point = 0.0
    motion.degree, motion.looks = -1, 0
    status = _reinit(motion.memory, 0.0, motion.state)
    if status == GOES_ON:
        status = _tolerances(motion.memory, motion.rtol, motion.handles[_TOLERANCE])
    return int(status)


@compiled
def _advance(motion: Direct) -> int:
    values, before, reached = motion.values, motion.before, motion.reached
    motion.low = motion.point
    motion.degree, motion.looks = -1, 0
    for number in range(values.size):
        before[number] = values[number]
    while motion.point <= motion.low:
        status = _solve(motion.memory, FAR_GOAL, motion.state, reached.ctypes.data, ONE_STEP)
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
    _order(motion.memory, motion.answer.ctypes.data)
    motion.degree = motion.answer[0]
    vector = motion.handles[_DERIVATIVE]
    scale = 1.0
    for power in range(motion.degree + 1):
        _derivative(motion.memory, motion.point, power, vector)
        for number in range(derivative.size):
            polynomial[power, number] = scale * derivative[number]
        scale *= step / (power + 1.0)


@compiled
def _at(motion: Direct, point: float) -> Values:
    if point >= motion.point:
        return motion.values
    if point <= motion.low:
        return motion.before
    _derivative(motion.memory, point, 0, motion.handles[_DERIVATIVE])
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
    _count(motion.memory, motion.answer.ctypes.data)
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


def _contact_rhs(_time: float, state: Any, rate: Any, parameters: Any) -> int:
    rotor = carray(parameters, 3)
    contact_field(
        carray(_vector_data(state), contact_phase.SIZE),
        carray(_vector_data(rate), contact_phase.SIZE),
        rotor[0],
        rotor[1],
        rotor[2],
    )
    return 0


def _free_rhs(_time: float, state: Any, rate: Any, parameters: Any) -> int:
    rotor = carray(parameters, 3)
    rotating_field_into(
        carray(_vector_data(state), cartesian_phase.SIZE),
        carray(_vector_data(rate), cartesian_phase.SIZE),
        rotor[0],
        rotor[1],
        rotor[2],
    )
    return 0


def _free_jacobian(
    _time: float, state: Any, _rate: Any, matrix: Any, parameters: Any, _a: Any, _b: Any, _c: Any
) -> int:
    rotor, size = carray(parameters, 3), cartesian_phase.SIZE
    rotating_jacobian_into(
        carray(_vector_data(state), size),
        farray(_matrix_data(matrix), (size, size)),
        rotor[0],
        rotor[1],
        rotor[2],
    )
    return 0


@cache
def callbacks() -> tuple[Any, Any, Any]:
    """Return both right-hand sides and the Jacobian, compiled; each has an ``address``.

    Raises
    ------
    InputError
        If SUNDIALS cannot be called from compiled code.
    """
    if reason := sundials.why_not():
        raise InputError(f"backend 'compiled' cannot be used: {reason}")
    rhs = signature(_FLAG, _REAL, _PLACE, _PLACE, _REALS)
    derivative = signature(_FLAG, _REAL, _PLACE, _PLACE, _PLACE, _REALS, _PLACE, _PLACE, _PLACE)
    return (
        callback(rhs, _contact_rhs),
        callback(rhs, _free_rhs),
        callback(derivative, _free_jacobian),
    )
