"""What passes between compiled code and SUNDIALS: functions called, and functions handed over.

The functions of SUNDIALS are found by name when the machine code is loaded, so that it can be kept
on disk; `libraries.why_not` must have loaded the libraries before. An index is passed in 64 bits,
which the processors' calling conventions let stand for one of 32.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from numba import carray, farray
from numba.core import types
from numba.core.typing import signature

from rotor_ida.equations.compiling import callback
from rotor_ida.equations.model import rotating_field_into, rotating_jacobian_into
from rotor_ida.errors import InputError
from rotor_ida.simulation import cartesian_phase, contact_phase
from rotor_ida.simulation.contact_phase import contact_field
from rotor_ida.simulation.cvode import libraries
from rotor_ida.simulation.tangents import (
    TANGENTS,
    contact_field_with_tangents,
    free_field_with_tangents,
)

PLACE, FLAG, SIZE, REAL, NOTHING = (types.intp, types.intc, types.int64, types.float64, types.void)
REALS = types.CPointer(types.float64)
_RHS = signature(FLAG, REAL, PLACE, PLACE, REALS)


def _external(name: str, result: types.Type, *arguments: types.Type) -> Any:
    return types.ExternalFunction(name, signature(result, *arguments))


context_create = _external("SUNContext_Create", FLAG, types.intc, PLACE)
context_free = _external("SUNContext_Free", FLAG, PLACE)
handlers_clear = _external("SUNContext_ClearErrHandlers", FLAG, PLACE)
vector_new = _external("N_VNew_Serial", PLACE, SIZE, PLACE)
vector_over = _external("N_VMake_Serial", PLACE, SIZE, PLACE, PLACE)
vector_fuse = _external("N_VEnableFusedOps_Serial", FLAG, PLACE, types.intc)
vector_free = _external("N_VDestroy", NOTHING, PLACE)
vector_data = _external("N_VGetArrayPointer", REALS, PLACE)
matrix_new = _external("SUNDenseMatrix", PLACE, SIZE, SIZE, PLACE)
matrix_free = _external("SUNMatDestroy", NOTHING, PLACE)
matrix_data = _external("SUNDenseMatrix_Data", REALS, PLACE)
linear_new = _external("SUNLinSol_Dense", PLACE, PLACE, PLACE, PLACE)
linear_free = _external("SUNLinSolFree", FLAG, PLACE)
cvode_create = _external("CVodeCreate", PLACE, types.intc, PLACE)
cvode_free = _external("CVodeFree", NOTHING, PLACE)
cvode_init = _external("CVodeInit", FLAG, PLACE, PLACE, REAL, PLACE)
cvode_reinit = _external("CVodeReInit", FLAG, PLACE, REAL, PLACE)
cvode_tolerances = _external("CVodeSVtolerances", FLAG, PLACE, REAL, PLACE)
cvode_user_data = _external("CVodeSetUserData", FLAG, PLACE, PLACE)
cvode_linear = _external("CVodeSetLinearSolver", FLAG, PLACE, PLACE, PLACE)
cvode_jacobian = _external("CVodeSetJacFn", FLAG, PLACE, PLACE)
cvode_solve = _external("CVode", FLAG, PLACE, REAL, PLACE, PLACE, types.intc)
cvode_derivative = _external("CVodeGetDky", FLAG, PLACE, REAL, types.intc, PLACE)
cvode_order = _external("CVodeGetLastOrder", FLAG, PLACE, PLACE)
cvode_count = _external("CVodeGetNumRhsEvals", FLAG, PLACE, PLACE)


def _contact_rhs(_time: float, state: Any, rate: Any, parameters: Any) -> int:
    rotor, size = carray(parameters, 3), contact_phase.SIZE
    here, slope = carray(vector_data(state), size), carray(vector_data(rate), size)
    contact_field(here, slope, rotor[0], rotor[1], rotor[2])
    return 0


def _free_rhs(_time: float, state: Any, rate: Any, parameters: Any) -> int:
    rotor, size = carray(parameters, 3), cartesian_phase.SIZE
    here, slope = carray(vector_data(state), size), carray(vector_data(rate), size)
    rotating_field_into(here, slope, rotor[0], rotor[1], rotor[2])
    return 0


def _free_jacobian(
    _time: float, state: Any, _rate: Any, matrix: Any, parameters: Any, _a: Any, _b: Any, _c: Any
) -> int:
    rotor, size = carray(parameters, 3), cartesian_phase.SIZE
    here, slopes = carray(vector_data(state), size), farray(matrix_data(matrix), (size, size))
    rotating_jacobian_into(here, slopes, rotor[0], rotor[1], rotor[2])
    return 0


def _contact_rhs_with_tangents(_time: float, state: Any, rate: Any, parameters: Any) -> int:
    rotor, size = carray(parameters, 3), contact_phase.SIZE + TANGENTS
    here, slope = carray(vector_data(state), size), carray(vector_data(rate), size)
    contact_field_with_tangents(here, slope, rotor[0], rotor[1], rotor[2])
    return 0


def _free_rhs_with_tangents(_time: float, state: Any, rate: Any, parameters: Any) -> int:
    rotor, size = carray(parameters, 3), cartesian_phase.SIZE + TANGENTS
    here, slope = carray(vector_data(state), size), carray(vector_data(rate), size)
    free_field_with_tangents(here, slope, rotor[0], rotor[1], rotor[2])
    return 0


@cache
def callbacks() -> tuple[Any, Any, Any]:
    """Return both right-hand sides and the Jacobian, compiled; each has an ``address``.

    Raises
    ------
    InputError
        If SUNDIALS cannot be called from compiled code.
    """
    _check_libraries("backend 'compiled'")
    derivative = signature(FLAG, REAL, PLACE, PLACE, PLACE, REALS, PLACE, PLACE, PLACE)
    fields = callback(_RHS, _contact_rhs), callback(_RHS, _free_rhs)
    return *fields, callback(derivative, _free_jacobian)


@cache
def callbacks_with_tangents() -> tuple[Any, Any]:
    """Return the right-hand sides of motions with tangents, as `callbacks` does."""
    _check_libraries("CVODE with tangents")
    return (
        callback(_RHS, _contact_rhs_with_tangents),
        callback(_RHS, _free_rhs_with_tangents),
    )


def _check_libraries(what: str) -> None:
    if reason := libraries.why_not():
        raise InputError(f"{what} cannot be used: {reason}")
