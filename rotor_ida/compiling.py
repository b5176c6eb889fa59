"""One typed name for numba's compiler, so that every kernel is built and cached alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numba.extending

P = ParamSpec("P")
R = TypeVar("R")

# What lets a loop over lanes use fused multiply-adds and vectors; NaN and infinity keep their
# meaning.
_LANE_MATHS = {"contract", "nsz", "arcp", "reassoc"}


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` on first call, keep the machine code on disk, and release the GIL."""
    kernel: Callable[P, R] = numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    return kernel


def compiled_for_lanes(function: Callable[P, R]) -> Callable[P, R]:
    """Compile like `compiled`, allowing sums to be regrouped so that loops over lanes vectorise."""
    kernel: Callable[P, R] = numba.njit(
        cache=True, nogil=True, error_model="numpy", fastmath=_LANE_MATHS
    )(function)
    return kernel


def _ask_for_wide_vectors(_typing: Any) -> tuple[Any, Any]:
    """Give the function that is being compiled an attribute, and no code."""

    def add_attribute(context: Any, builder: Any, _signature: Any, _arguments: Any) -> Any:
        # llvmlite knows no text attributes; it writes what is in the set as it is.
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return numba.types.void(), add_attribute


# Called inside a kernel, asks for the processor's widest vectors. Compilers keep away from 512 bits
# because short bursts of them slow some processors down; a kernel that does nothing else gains a
# third of its time.
widest_vectors: Callable[[], None] = cast(
    "Callable[[], None]", numba.extending.intrinsic(_ask_for_wide_vectors)
)
