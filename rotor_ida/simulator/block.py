"""Where an integration in compiled code keeps what belongs to it: one block of memory.

Compiled code knows an integration by the address of its block, which SUNDIALS owns. An object of
numba's own would have its references counted at every call, which took a tenth of the time.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba import carray, extending
from numba.core import types

from rotor_ida.compiling import compiled
from rotor_ida.simulator.calls import REALS

Values = npt.NDArray[np.float64]

_intrinsic: Any = extending.intrinsic

# The block begins with 16 numbers, the first four real and the others whole.
LOW, POINT, REACHED, RTOL = range(4)
SIZE, DEGREE, LOOKS, ANSWER = range(4, 8)
MEMORY, CONTEXT, MATRIX, LINEAR, BLOCK, STATE, TOLERANCE, DERIVATIVE = range(8, 16)
HEAD = 16
HIGHEST_ORDER = 12
# Rows as long as the state follow: what CVODE writes and reads; the step before, a reading, and
# the Taylor series of the last step about its end, scaled by the step.
VALUES, TOLERANCES, DERIVATIVES, BEFORE, READING, SERIES = range(6)
ROWS = SERIES + HIGHEST_ORDER + 1


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
