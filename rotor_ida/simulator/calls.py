"""The functions of SUNDIALS that compiled code calls: their names and types.

They are found by name when the machine code is loaded, so that it can be kept on disk;
`sundials.why_not` must have loaded the libraries before. An index is passed in 64 bits, which the
processors' calling conventions let stand for one of 32.
"""

from __future__ import annotations

from typing import Any

from numba.core import types
from numba.core.typing import signature

PLACE, FLAG, SIZE, REAL, NOTHING = (
    types.intp,
    types.intc,
    types.int64,
    types.float64,
    types.void,
)
REALS = types.CPointer(types.float64)


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
