"""The right-hand sides and the Jacobian, compiled for C to call."""

from __future__ import annotations

from functools import cache
from typing import Any

from numba import carray, farray
from numba.core.typing import signature

from rotor_ida.compiling import callback
from rotor_ida.errors import InputError
from rotor_ida.model import rotating_field_into, rotating_jacobian_into
from rotor_ida.simulator import cartesian_phase, contact_phase, sundials
from rotor_ida.simulator.calls import FLAG, PLACE, REAL, REALS, matrix_data, vector_data
from rotor_ida.simulator.contact_phase import contact_field


def _contact_rhs(_time: float, state: Any, rate: Any, parameters: Any) -> int:
    rotor = carray(parameters, 3)
    contact_field(
        carray(vector_data(state), contact_phase.SIZE),
        carray(vector_data(rate), contact_phase.SIZE),
        rotor[0],
        rotor[1],
        rotor[2],
    )
    return 0


def _free_rhs(_time: float, state: Any, rate: Any, parameters: Any) -> int:
    rotor = carray(parameters, 3)
    rotating_field_into(
        carray(vector_data(state), cartesian_phase.SIZE),
        carray(vector_data(rate), cartesian_phase.SIZE),
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
        carray(vector_data(state), size),
        farray(matrix_data(matrix), (size, size)),
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
    rhs = signature(FLAG, REAL, PLACE, PLACE, REALS)
    derivative = signature(FLAG, REAL, PLACE, PLACE, PLACE, REALS, PLACE, PLACE, PLACE)
    return (
        callback(rhs, _contact_rhs),
        callback(rhs, _free_rhs),
        callback(derivative, _free_jacobian),
    )
