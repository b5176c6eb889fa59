"""Find, check and load the SUNDIALS libraries that scikit-sundae is built on.

The core calls them directly. Their version, the size of their index and the precision of their
reals are checked first. Taylor series need none of this.
"""

from __future__ import annotations

import ctypes
import importlib.util
import sys
from ctypes import Structure, c_void_p
from functools import cache
from pathlib import Path

# In loading order: each needs the ones before it.
LIBRARIES = ("core", "sunmatrixdense", "nvecserial", "sunlinsoldense", "cvode")
# The interface used here is that of this major version.
KNOWN_MAJOR = 7
PROBE = 1.2345678901234567
PROBE_SIZE = 3
# The fields of ``struct sundials`` in core.h, with the library and the function of each.
FUNCTIONS = {
    "context_new": ("core", "SUNContext_Create"),
    "context_free": ("core", "SUNContext_Free"),
    "handlers_clear": ("core", "SUNContext_ClearErrHandlers"),
    "vector_over": ("nvecserial", "N_VMake_Serial"),
    "vector_fuse": ("nvecserial", "N_VEnableFusedOps_Serial"),
    "vector_free": ("core", "N_VDestroy"),
    "vector_data": ("core", "N_VGetArrayPointer"),
    "matrix_new": ("sunmatrixdense", "SUNDenseMatrix"),
    "matrix_free": ("core", "SUNMatDestroy"),
    "matrix_data": ("sunmatrixdense", "SUNDenseMatrix_Data"),
    "linear_new": ("sunlinsoldense", "SUNLinSol_Dense"),
    "linear_free": ("core", "SUNLinSolFree"),
    "create": ("cvode", "CVodeCreate"),
    "free": ("cvode", "CVodeFree"),
    "init": ("cvode", "CVodeInit"),
    "reinit": ("cvode", "CVodeReInit"),
    "tolerances": ("cvode", "CVodeSVtolerances"),
    "weigh_by": ("cvode", "CVodeWFtolerances"),
    "user_data": ("cvode", "CVodeSetUserData"),
    "linear_use": ("cvode", "CVodeSetLinearSolver"),
    "jacobian": ("cvode", "CVodeSetJacFn"),
    "solve": ("cvode", "CVode"),
    "derivative": ("cvode", "CVodeGetDky"),
    "last_order": ("cvode", "CVodeGetLastOrder"),
    "evaluations": ("cvode", "CVodeGetNumRhsEvals"),
}


class SundialsStruct(Structure):
    """``struct sundials``."""

    _fields_ = [(name, c_void_p) for name in FUNCTIONS]


class Unfit(Exception):  # noqa: N818 - a reason, always caught
    """Why the libraries cannot be called."""


@cache
def why_not() -> str:
    """Return why the core cannot call SUNDIALS; empty if it can.

    The libraries are loaded on the first call.
    """
    try:
        functions()
    except (Unfit, OSError, AttributeError) as error:
        return " ".join(str(error).split())
    return ""


@cache
def functions() -> SundialsStruct:
    """Return the functions of SUNDIALS that the core calls.

    Raises
    ------
    Unfit, OSError, AttributeError
        If the libraries are missing, do not fit, or lack a function.
    """
    loaded = _loaded()
    _check(loaded)
    addresses = {}
    for field, (name, function) in FUNCTIONS.items():
        if not hasattr(loaded[name], function):
            raise Unfit(f"the library sundials_{name} of scikit-sundae lacks {function}")
        addresses[field] = ctypes.cast(getattr(loaded[name], function), c_void_p)
    return SundialsStruct(**addresses)


@cache
def version() -> str:
    """Return the version of the SUNDIALS libraries; empty where there are none.

    scikit-sundae itself is not imported: that takes longer than a run.
    """
    try:
        return ".".join(map(str, _version(_loaded()["core"])))
    except (Unfit, OSError, AttributeError):
        return ""


@cache
def _loaded() -> dict[str, ctypes.CDLL]:
    found = importlib.util.find_spec("sksundae")
    if found is None or found.origin is None:
        raise Unfit("scikit-sundae is not installed")
    folder = _folder(Path(found.origin).parent)
    return {
        name: ctypes.CDLL(str(_library(folder, name)), mode=ctypes.RTLD_GLOBAL)
        for name in LIBRARIES
    }


def _folder(package: Path) -> Path:
    """Return the folder of the libraries: that of the wheel, or of the environment."""
    candidates = (
        package.parent / "scikit_sundae.libs",  # wheels for Linux and Windows
        package / ".dylibs",  # wheels for macOS
        Path(sys.prefix) / "Library" / "bin",  # conda on Windows
        Path(sys.prefix) / "lib",  # conda elsewhere
    )
    for folder in candidates:
        if any(folder.glob("*sundials_core*")):
            return folder
    raise Unfit(f"the SUNDIALS libraries of scikit-sundae were not found beside {package}")


def _library(folder: Path, name: str) -> Path:
    """Return the file of one library, with or without a prefix, a hash and a version."""
    for pattern in (f"libsundials_{name}*", f"sundials_{name}*"):
        found = sorted(
            path
            for path in folder.glob(pattern)
            if any(end in path.name for end in (".so", ".dylib", ".dll"))
        )
        if found:
            return found[0]
    raise Unfit(f"library sundials_{name} is missing from {folder}")


def _check(loaded: dict[str, ctypes.CDLL]) -> None:
    """Raise `Unfit` unless version, size of the index and precision are as required."""
    core, vectors = loaded["core"], loaded["nvecserial"]
    found = _version(core)
    if found[0] != KNOWN_MAJOR:
        raise Unfit(f"SUNDIALS must be version {KNOWN_MAJOR}, found {'.'.join(map(str, found))}")
    length, stored = _probe(core, vectors)
    if length not in {PROBE_SIZE, PROBE_SIZE + (1 << 32)}:
        raise Unfit("the index of SUNDIALS must have 32 or 64 bits")
    if stored != PROBE:
        raise Unfit("the reals of SUNDIALS must have double precision")


def _version(core: ctypes.CDLL) -> tuple[int, int, int]:
    numbers = [ctypes.c_int() for _ in range(3)]
    label = ctypes.create_string_buffer(64)
    core.SUNDIALSGetVersionNumber(*(ctypes.byref(number) for number in numbers), label, 64)
    return (numbers[0].value, numbers[1].value, numbers[2].value)


def _probe(core: ctypes.CDLL, vectors: ctypes.CDLL) -> tuple[int, float]:
    """Return the first eight bytes of a vector's content, and a real that was stored in it.

    The content begins with the length, an index, and a flag that is 1: with an index of 32 bits
    the eight bytes contain both.
    """
    pointer, integer = ctypes.c_void_p, ctypes.c_int64
    context = pointer()
    core.SUNContext_Create.argtypes = [ctypes.c_int, ctypes.POINTER(pointer)]
    core.SUNContext_Free.argtypes = [ctypes.POINTER(pointer)]
    vectors.N_VNew_Serial.restype = pointer
    vectors.N_VNew_Serial.argtypes = [integer, pointer]
    core.N_VConst.argtypes = [ctypes.c_double, pointer]
    core.N_VConst.restype = None
    core.N_VGetArrayPointer.restype = pointer
    core.N_VGetArrayPointer.argtypes = [pointer]
    core.N_VDestroy.argtypes = [pointer]
    core.N_VDestroy.restype = None
    if core.SUNContext_Create(0, ctypes.byref(context)):
        raise Unfit("SUNDIALS could not make a context")
    try:
        vector = vectors.N_VNew_Serial(PROBE_SIZE, context)
        core.N_VConst(PROBE, vector)
        data = core.N_VGetArrayPointer(vector)
        stored = ctypes.c_double.from_address(data + 8 * (PROBE_SIZE - 1)).value
        content = pointer.from_address(vector).value
        length = integer.from_address(content or 0).value
        core.N_VDestroy(vector)
    finally:
        core.SUNContext_Free(ctypes.byref(context))
    return length, stored
