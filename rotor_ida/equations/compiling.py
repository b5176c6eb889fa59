"""One typed name for each way in which numba takes a function, so that all are built alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import numba
from numba.core import types
from numba.core.ccallback import CFunc
from numba.experimental import structref
from numba.extending import intrinsic, register_jitable

P = ParamSpec("P")
R = TypeVar("R")

# What lets a loop over lanes use fused multiply-adds and vectors; NaN and infinity keep their
# meaning.
_LANE_MATHS = {"contract", "nsz", "arcp", "reassoc"}


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` on first call, keep the machine code on disk, and release the GIL."""
    kernel: Callable[P, R] = _kept(numba.njit(nogil=True, error_model="numpy")(function))
    return kernel


def compiled_for_lanes(function: Callable[P, R]) -> Callable[P, R]:
    """Compile like `compiled`, allowing sums to be regrouped so that loops over lanes vectorise."""
    made = numba.njit(nogil=True, error_model="numpy", fastmath=_LANE_MATHS)(function)
    kernel: Callable[P, R] = _kept(made)
    return kernel


def inlined_for_lanes(function: Callable[P, R]) -> Callable[P, R]:
    """Compile like `compiled_for_lanes`, and always into the caller.

    A function apart is optimised once alone and once more with its caller. Which of the two a
    process then calls depends on whether it compiled them or found them on disk, and with sums
    regrouped the last bits depend on that.
    """
    made = numba.njit(nogil=True, error_model="numpy", fastmath=_LANE_MATHS, forceinline=True)
    kernel: Callable[P, R] = _kept(made(function))
    return kernel


def callback(signature: Any, function: Callable[..., Any]) -> Any:
    """Compile `function` for C to call, and keep the machine code; it has an ``address``."""
    arguments = numba.core.sigutils.normalize_signature(signature)
    made = _kept(CFunc(function, arguments, {}, {"error_model": "numpy"}))
    made.compile()
    return made


def _kept(kernel: Any) -> Any:
    """Let numba keep the machine code on disk, as long as no source that it may hold changes.

    numba heeds the file of the kernel alone, not those of what it calls. Where no folder can be
    written, every process compiles anew.
    """
    try:
        kernel.enable_caching()
    except RuntimeError:
        return kernel
    file = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    if file is not None and hasattr(file, "_source_stamp"):
        file._source_stamp = (file._source_stamp, _newest_source())
    return kernel


@cache
def _newest_source() -> int:
    """Return when the newest of the sources that kernels are made of was changed."""
    package = Path(__file__).parents[1]
    folders = ("equations", "simulation", "basins", "analysis")
    sources = (path for folder in folders for path in (package / folder).rglob("*.py"))
    return max(path.stat().st_mtime_ns for path in sources)


def shared(function: Callable[P, R]) -> Callable[P, R]:
    """Leave `function` as it is, and let compiled code take it in as well.

    What is written once in this way runs in Python over one kind of object and in compiled code
    over its compiled counterpart: one algorithm, two ways to run it.
    """
    both: Callable[P, R] = register_jitable(error_model="numpy")(function)
    return both


def inlined(function: Callable[P, R]) -> Callable[P, R]:
    """Do as `shared` does, and let compiled code take the function into its caller.

    That saves the counting of references to what is passed, and pays in an inner loop only.
    """
    both: Callable[P, R] = register_jitable(inline="always", error_model="numpy")(function)
    return both


def structure(dataclass: type) -> Any:
    """Let the name of a dataclass stand, in compiled code, for a structure with its fields.

    Returns
    -------
    type
        The type of that structure, to which numba's `overload_method` can give methods.
    """

    class Structure(types.StructRef):
        def preprocess_fields(self, given: tuple[tuple[str, types.Type], ...]) -> object:
            return tuple((name, types.unliteral(kind)) for name, kind in given)

    Structure.__name__ = Structure.__qualname__ = f"{dataclass.__name__}Type"
    Structure.__module__ = dataclass.__module__
    structref.register(Structure)
    names = [field.name for field in fields(dataclass)]
    structref.define_constructor(dataclass, Structure, names)
    return Structure


def _ask_for_wide_vectors(_typing: Any) -> tuple[Any, Any]:
    """Give the function that is being compiled an attribute, and no code."""

    def add_attribute(context: Any, builder: Any, _signature: Any, _arguments: Any) -> Any:
        # llvmlite knows no text attributes; it writes what is in the set as it is.
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.void(), add_attribute


# Called inside a kernel, asks for the processor's widest vectors. Compilers keep away from 512 bits
# because short bursts of them slow some processors down; a kernel that does nothing else gains a
# third of its time.
widest_vectors: Callable[[], None] = cast("Callable[[], None]", intrinsic(_ask_for_wide_vectors))
