"""One typed name for numba's compiler, so that every kernel is built and cached alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numba

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
