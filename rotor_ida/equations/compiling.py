"""One typed name for each way in which numba takes a function, so that all are built alike."""

from __future__ import annotations

import hashlib
import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numpy.typing as npt
from numba.core import cgutils, types
from numba.core.datamodel import default_manager, models
from numba.experimental import structref
from numba.extending import intrinsic, overload, register_jitable

from rotor_ida.parallel.jobs import Stop

P = ParamSpec("P")
R = TypeVar("R")

# What lets a loop over lanes use fused multiply-adds and vectors; NaN and infinity keep their
# meaning.
_LANE_MATHS = {"contract", "nsz", "arcp", "reassoc"}

_CONFIG: Any = numba.config
# Folders of this package that hold what is compiled.
KERNEL_FOLDERS = ("basins", "equations", "simulation", "stability")
# Seconds after which a cache that no process has looked at is removed.
LONG_UNUSED = 7 * 24 * 3600.0


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` on first call, cache the machine code on disk, and release the GIL."""
    return _kernel(function, {})


def compiled_for_lanes(function: Callable[P, R]) -> Callable[P, R]:
    """Compile like `compiled`, allowing sums to be regrouped so that loops over lanes vectorise."""
    return _kernel(function, {"fastmath": _LANE_MATHS})


def inlined_for_lanes(function: Callable[P, R]) -> Callable[P, R]:
    """Compile like `compiled_for_lanes`, and always into the caller.

    A function apart is optimised once alone and once more with its caller. Which of the two a
    process then calls depends on whether it compiled them or found them on disk, and with sums
    regrouped the last bits depend on that.
    """
    return _kernel(function, {"fastmath": _LANE_MATHS, "forceinline": True})


def _kernel(function: Callable[P, R], settings: dict[str, Any]) -> Callable[P, R]:
    with _cache() as cached:
        decorate: Any = numba.njit(nogil=True, error_model="numpy", cache=cached, **settings)
        kernel: Callable[P, R] = decorate(function)
    return kernel


def callback(signature: Any, function: Callable[..., Any]) -> Any:
    """Compile `function` for C to call, and cache the machine code; it has an ``address``."""
    with _cache() as cached:
        return numba.cfunc(signature, error_model="numpy", cache=cached)(function)


@contextmanager
def _cache() -> Iterator[bool]:
    """Let numba cache what is decorated meanwhile in `cache_folder`; yield whether there is one."""
    folder, before = cache_folder(), _CONFIG.CACHE_DIR
    _CONFIG.CACHE_DIR = str(folder or "")
    try:
        yield folder is not None
    finally:
        _CONFIG.CACHE_DIR = before


@cache
def cache_folder() -> Path | None:
    """Return where the machine code of kernels is cached; None where no folder can be written.

    numba compiles a kernel anew when its own file changes, but not when a file does that it
    calls. So the folder is named for the contents of all sources that kernels are made of.
    """
    package = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for folder in KERNEL_FOLDERS:
        for path in sorted((package / folder).rglob("*.py")):
            name = path.relative_to(package).as_posix()
            digest.update(f"{name}\0".encode() + path.read_bytes() + b"\0")
    parents = [package / "__pycache__", Path.home() / ".cache" / "rotor_ida"]
    if _CONFIG.CACHE_DIR:
        parents = [Path(_CONFIG.CACHE_DIR)]
    for parent in parents:
        place = parent / f"kernels-{digest.hexdigest()[:16]}"
        try:
            place.mkdir(parents=True, exist_ok=True)
            os.utime(place)  # in use, for `_remove_old`; fails where nothing can be written
        except OSError:
            continue
        _remove_old(parent)
        return place
    return None


def _remove_old(parent: Path) -> None:
    """Remove the caches of other sources, unless a process may be at work with them."""
    for place in parent.glob("kernels-*"):
        with suppress(OSError):  # another process may have removed it
            if time.time() - place.stat().st_mtime > LONG_UNUSED:
                shutil.rmtree(place, ignore_errors=True)


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


def shared_for_lanes(function: Callable[P, R]) -> Callable[P, R]:
    """Do as `shared` does, with fused multiply-adds, and always into the caller.

    Arrays are best passed one by one: to take one out of a tuple counts its references.
    """
    settings = {"error_model": "numpy", "fastmath": {"contract", "nsz"}, "forceinline": True}
    both: Callable[P, R] = register_jitable(**settings)(function)
    return both


def structure(dataclass: type) -> Any:
    """Let the name of a dataclass stand, in compiled code, for a structure with its fields.

    References to it are not counted, which takes a fifth of the time of a loop that does little
    else: whoever makes one must `release` it.

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
    default_manager.register(Structure, _Uncounted)
    names = [field.name for field in fields(dataclass)]
    structref.define_constructor(dataclass, Structure, names)
    return Structure


class _Uncounted(models.StructModel):
    """What a structure is known by: where it lies, and no more."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, [("meminfo", types.voidptr)])


def release(thing: object) -> None:
    """Free an object of a `structure`, and what it alone keeps; in Python there is no need."""


def _free(_typing: Any, thing: Any) -> tuple[Any, Any]:
    """Do as `release` does."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        held = cgutils.create_struct_proxy(signature.args[0])(context, builder, arguments[0])
        context.nrt.decref(builder, types.MemInfoPointer(types.voidptr), held.meminfo)
        return context.get_dummy_value()

    return types.void(thing), code


_free_in_code: Any = intrinsic(_free)


@overload(release)
def _release(thing: Any) -> Any:  # noqa: ARG001 - types
    def free(thing: Any) -> None:
        _free_in_code(thing)

    return free


def _ask_for_wide_vectors(_typing: Any) -> tuple[Any, Any]:
    """Give the function that is being compiled an attribute, and no code."""

    def add_attribute(context: Any, builder: Any, _signature: Any, _arguments: Any) -> Any:
        # llvmlite knows no text attributes; it writes what is in the set as it is.
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.void(), add_attribute


def lent(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return an array that somebody else keeps.

    In compiled code no references to it are counted, which takes a fifth of the time of a loop
    that does little else. It must not outlive its keeper.
    """
    return array


def _without_owner(_typing: Any, array: Any) -> tuple[Any, Any]:
    """Do as `lent` does."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = context.make_array(signature.args[0])(context, builder, arguments[0])
        view.meminfo = cgutils.get_null_value(view.meminfo.type)
        view.parent = cgutils.get_null_value(view.parent.type)
        return view._getvalue()

    return array(array), code


_lend: Any = intrinsic(_without_owner)


@overload(lent)
def _lent(array: Any) -> Any:  # noqa: ARG001 - types
    def without_owner(array: Any) -> Any:
        return _lend(array)

    return without_owner


def asked_to_stop(stop: Stop) -> bool:
    """Return whether `stop` holds anything but 0.

    In compiled code it is read from memory each time: a loop that changes nothing else would
    otherwise read it once, before it begins.
    """
    return bool(stop[0])


def _read_anew(_typing: Any, stop: Any) -> tuple[Any, Any]:
    """Return whether the first byte of an array is not 0, read as an atomic variable."""

    def load(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        byte = builder.load_atomic(array.data, "monotonic", 1)
        return builder.icmp_unsigned("!=", byte, byte.type(0))

    return types.boolean(stop), load


read_anew: Callable[[Stop], bool] = cast("Callable[[Stop], bool]", intrinsic(_read_anew))


@overload(asked_to_stop)
def _asked_to_stop(stop: Any) -> Any:  # noqa: ARG001 - types
    def read(stop: Any) -> Any:
        return read_anew(stop)

    return read


# Called inside a kernel, asks for the processor's widest vectors. Compilers keep away from 512 bits
# because short bursts of them slow some processors down; a kernel that does nothing else gains a
# third of its time.
widest_vectors: Callable[[], None] = cast("Callable[[], None]", intrinsic(_ask_for_wide_vectors))
