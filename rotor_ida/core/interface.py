"""The Python interface of the core: the structures of ``core.h``, its functions and its errors.

Arrays are checked here and belong to NumPy; the core only fills them. ctypes releases the global
interpreter lock during a call.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, Structure, c_double, c_int, c_int32, c_int64, c_void_p
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.core import library as found
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.spinning import OF_DRIVE

# How a call ended, as `enum status` of core.h explains; the flags of SUNDIALS are negative.
DONE = 0
NOT_FINITE, NO_ROOT, STUCK, STOPPED, FULL, NO_SOLVER, FULL_INSIDE, UNBALANCED = range(1001, 1009)
STALLED, RUNAWAY, SINGULAR, OUT_OF_STEPS, UNBOUNDED, OUT_OF_TABLE = range(1009, 1015)
# LARGEST_SPEED of speed_limits.c and MOST_CLEARANCES of system_run.c stand here in words; a test
# compares them, and the numbers with `enum status`.
MESSAGES = {
    NOT_FINITE: "the state is no longer finite",
    NO_ROOT: "an event was seen, but its root could not be found",
    STUCK: "time no longer advances",
    STOPPED: "interrupted",
    NO_SOLVER: "SUNDIALS could not make a solver",
    UNBALANCED: "the energy of a contact does not balance",
    STALLED: "the speed fell through 0: the torque no longer turns the rotor",
    SINGULAR: "more contacts roll than the system has modes: their forces are not determined",
    RUNAWAY: "the speed passed 1e+06: the torque lets it run away",
    OUT_OF_STEPS: "the run needs more steps than it may take",
    UNBOUNDED: "the system is unstable: its motion passed 1e+30 clearances, and nothing bounds it",
    OUT_OF_TABLE: "the torque drives the speed out of the table of a bearing",
    -1: "Could not reach endpoint after 'max_num_steps'.",
    -2: "Could not satisfy demanded accuracy for an internal step.",
    -3: "Error tests failed too many times, or reached min step size.",
    -4: "Convergence tests failed too many times, or reached min step size.",
}

METHODS = {"taylor": 0, "adams": 1, "bdf": 2}
UNDECIDED, IN_FLIGHT, IN_CONTACT = -1, 0, 1
# Columns of what `stretch` returns.
STRETCH_COLUMNS = 5


class RotorStruct(Structure):
    """``struct rotor``; the pieces of a run give the change of its speed."""

    _fields_ = [(name, c_double) for name in (*ALL_PARAMETERS, *OF_DRIVE)]

    @classmethod
    def of(cls, rotor: Rotor) -> RotorStruct:
        """Return a rotor in the form that the core expects."""
        return cls(*(getattr(rotor, name) or 0.0 for name in ALL_PARAMETERS))


class RunStruct(Structure):
    """``struct run``."""

    _fields_ = [
        ("rotor", RotorStruct),
        *((name, c_double) for name in ("rtol", "atol", "duration", "slack")),
        *((name, c_int32) for name in ("fixed_axes", "method", "exact_flight", "began")),
        ("stop", c_void_p),
        ("sundials", c_void_p),
        ("time", c_double),
        ("state", 4 * c_double),
        ("shift", c_double),
        ("where", c_int32),
        ("differences", c_int32),
        *((name, c_void_p) for name in ("bundle", "sample_times", "samples")),
        ("sample_count", c_int64),
        ("sampled", c_int64),
        *((name, c_void_p) for name in ("event_times", "event_states")),
        *((name, c_void_p) for name in ("event_kinds", "event_modes")),
        ("event_room", c_int64),
        ("events", c_int64),
        ("contacts", c_void_p),
        ("contact_room", c_int64),
        ("contact_count", c_int64),
        ("extrema", c_void_p),
        ("extremum_room", c_int64),
        ("extremum_count", c_int64),
        *((name, c_int64) for name in ("evaluations", "steps", "most_steps")),
        ("mode_began", c_int32),
        ("flattened", c_int32),
        ("volume_lost", c_double),
        ("pieces", c_void_p),
        *((name, c_int64) for name in ("piece_count", "piece")),
        ("angle", c_double),
        *((name, c_void_p) for name in ("sample_turns", "event_turns")),
    ]


_ROTOR, _RUN = POINTER(RotorStruct), POINTER(RunStruct)
_SIGNATURES: dict[str, tuple[Any, list[Any]]] = {
    "core_run": (c_int, [_RUN]),
    "core_stretch": (c_int, [_RUN, c_int64, c_void_p, POINTER(c_int64)]),
    "core_starts_in_contact": (c_int, [_ROTOR, c_void_p]),
    "core_fly": (None, [_ROTOR, c_void_p, c_void_p, c_void_p, c_int64]),
    "core_first_touch": (c_double, [_ROTOR, c_void_p, c_double, c_void_p]),
    "core_rotate": (None, [c_void_p, c_void_p, c_double, c_int64]),
    "core_fault": (c_int, [_RUN, c_double, POINTER(c_int64)]),
    "core_follow_lanes": (
        c_int,
        [
            *(_ROTOR, c_void_p, c_void_p, c_void_p, c_int64, c_void_p, c_int64, c_void_p),
            *(c_void_p, c_int64, c_double, c_double, c_void_p),
        ],
    ),
    "core_measure_returns": (
        c_int,
        [
            *(_ROTOR, c_void_p, c_int64, c_void_p, c_double, c_double, c_double),
            *(c_void_p, c_void_p),
        ],
    ),
}


# Functions of the core for a rotor whose speed changes.
_OF_RUNS = ("core_run", "core_fault")


@cache
def library(model: str = "paper") -> ctypes.CDLL:
    """Return the core of a model, with the argument types of its functions declared."""
    core = found.library(model)
    for name, (result, arguments) in _SIGNATURES.items():
        if model == "run_up" and name not in _OF_RUNS:
            continue
        function = getattr(core, name)
        function.restype, function.argtypes = result, arguments
    return core


def library_of(rotor: Rotor, *, whole: bool = False) -> ctypes.CDLL:
    """Return the core of the simplest model for a rotor, or of the whole model if `whole`."""
    return library("whole" if whole or rotor.beyond else "paper")


def pointer(array: npt.NDArray[Any], dtype: npt.DTypeLike, *, writeable: bool = False) -> c_void_p:
    """Return the address of an array's numbers, if the core can use them as they are.

    Raises
    ------
    TypeError, ValueError
        If they have another type, are not contiguous, or are read-only.
    """
    if array.dtype != dtype:
        raise TypeError(f"the core takes an array of {np.dtype(dtype)}, got {array.dtype}")
    if not array.flags.c_contiguous:
        raise ValueError("the core takes a contiguous array")
    if writeable and not array.flags.writeable:
        raise ValueError("the core must be able to write into this array")
    return c_void_p(address(array))


_NOTHING = ctypes.c_char * 0


def address(array: npt.NDArray[Any]) -> int:
    """Return the address of an array's numbers, three times as fast as NumPy's own way."""
    if array.flags.writeable:
        held: Any = array  # an array is a buffer, though NumPy's types do not say so
        return ctypes.addressof(_NOTHING.from_buffer(held))
    return int(array.ctypes.data)


def message_of(status: int) -> str:
    """Return the message for a call that ended early."""
    return MESSAGES.get(status, f"the solver gave up with flag {status}")
