"""The SUNDIALS libraries that scikit-sundae is built on: where they lie, and whether they fit.

Compiled code calls them directly. Before it does, they are found, loaded and asked for their
version, the size of their index and the precision of their reals; nothing is taken for granted.
"""

from __future__ import annotations

import ctypes
import sys
from functools import cache
from pathlib import Path

import llvmlite.binding as llvm
import sksundae

# In the order in which they are loaded: each needs the ones before it.
LIBRARIES = ("core", "sunmatrixdense", "nvecserial", "sunlinsoldense", "cvode", "ida")
# The interface called here is that of this major version.
KNOWN_MAJOR = 7
PROBE = 1.2345678901234567
PROBE_SIZE = 3
VECTOR_CONTENT_BYTES = 16


class Unfit(Exception):  # noqa: N818 - a reason, always caught
    """Why the libraries cannot be called from compiled code."""


@cache
def why_not() -> str:
    """Return why compiled code cannot call SUNDIALS; empty if it can.

    The libraries are loaded on the first call.
    """
    try:
        folder = _folder()
        paths = [_library(folder, name) for name in LIBRARIES]
        for path in paths:
            llvm.load_library_permanently(str(path))
        _check(ctypes.CDLL(str(paths[0])), ctypes.CDLL(str(paths[2])))
    except (Unfit, OSError, RuntimeError, AttributeError) as error:
        return " ".join(str(error).split())
    return ""


def _folder() -> Path:
    """Return the folder that holds the libraries: the wheel's own, or the environment's."""
    package = Path(sksundae.__file__).parent
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


def _check(core: ctypes.CDLL, vectors: ctypes.CDLL) -> None:
    """Raise `Unfit` unless version, size of the index and precision are as they must be."""
    version = _version(core)
    if version[0] != KNOWN_MAJOR:
        raise Unfit(f"SUNDIALS must be version {KNOWN_MAJOR}, found {'.'.join(map(str, version))}")
    if ".".join(map(str, version)) != str(sksundae.SUNDIALS_VERSION).split("-", maxsplit=1)[0]:
        raise Unfit(
            f"scikit-sundae was built with SUNDIALS {sksundae.SUNDIALS_VERSION}, "
            f"found {'.'.join(map(str, version))}"
        )
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
    the eight bytes hold both.
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
