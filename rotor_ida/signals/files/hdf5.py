"""Read HDF5 files in a separate process: the library may crash on a damaged one, even later."""

from __future__ import annotations

import math
import os
import pickle
import subprocess
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np

from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.formats.hdf5 import what_is_not_own
from rotor_ida.signals.files.columns import MOST_NUMBERS, Column, check_size, one_line, possible_in

# Attributes for numbers that were packed, with what they are if left out, and for missing ones.
SCALING = {"scale_factor": 1.0, "add_offset": 0.0}
MISSING = ("_FillValue", "missing_value")
PACKING = (*SCALING, *MISSING)
# Memory of the process [bytes]: the libraries, and the numbers twice.
MEMORY = 3 * 2**30 + 2 * 8 * MOST_NUMBERS


def content_of(path: Path, kind: str) -> dict[str, object]:
    """Return the content of an HDF5 file by groups."""
    lines = (
        f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import answer; "
        "answer(*sys.argv[1:])"
    )
    done = subprocess.run(
        [sys.executable, "-c", lines, os.fspath(path), kind], capture_output=True, check=False
    )
    if done.returncode:
        raise InputError(
            f"{shown(path)} must be {kind}: the HDF5 library ends with status {done.returncode}"
        )
    found = pickle.loads(done.stdout)
    if isinstance(found, str):
        raise InputError(found)
    return cast("dict[str, object]", found)


def answer(path: str, kind: str) -> None:
    """Write the content of a file to the standard output, or what is wrong with it, and exit."""
    if sys.platform != "win32":  # where memory has no such limit
        import resource  # noqa: PLC0415

        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        if hard == resource.RLIM_INFINITY or hard > MEMORY:
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, hard))
    try:
        found: object = _content(Path(path))
    except InputError as error:
        found = str(error)
    except Exception as error:
        found = f"{shown(path)} must be {kind}: {one_line(error)}"
    with os.fdopen(1, "wb") as output:
        pickle.dump(found, output, protocol=5)
    os._exit(0)  # a file that could not be opened may crash the library where it is forgotten


def _content(path: Path) -> dict[str, object]:
    """Return the content of a file, after a check of what it declares."""
    from netCDF4 import Dataset  # noqa: PLC0415 - takes long to import

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about unknown types, which are left out
        if other := what_is_not_own(path):
            raise InputError(f"{shown(path)} must contain its own data, got {other}")
        with Dataset(path) as file:
            file.set_auto_maskandscale(False)
            declared = sum(math.prod(map(float, each.shape)) for each in _all_in(file))
            check_size(path, declared, possible=possible_in(path))
            return _group(file)


def _all_in(group: Any) -> Iterator[Any]:
    """Yield the variables of a group and of its subgroups."""
    yield from group.variables.values()
    for within in group.groups.values():
        yield from _all_in(within)


def _group(group: Any) -> dict[str, object]:
    """Return the variables of a group, with those of nested structures."""
    held: dict[str, object] = {}
    for name, variable in group.variables.items():
        matlab = getattr(variable, "MATLAB_class", "")
        if matlab in ("char", "cell", "struct", "function_handle"):
            held[name] = matlab
            continue
        values = np.asarray(variable[...])
        unit = next(
            (
                text
                for each in ("units", "unit", "Units", "Unit")
                if isinstance(text := getattr(variable, each, None), str)
            ),
            "",
        )
        if values.dtype.names:
            held[name] = {field: values[field] for field in values.dtype.names}
        else:  # MATLAB counts dimensions from the other end
            found = _unpacked(variable, values.T if matlab else values)
            held[name] = found if isinstance(found, str) else Column(found, unit)
    for name, within in group.groups.items():
        if not name.startswith("#"):
            held[name] = _group(within)
    return held


def _unpacked(variable: Any, values: Any) -> Any:
    """Return numbers with scale and offset, NaN where one is missing; or why they have no meaning.

    The attributes are those of netCDF, which HDF5 files have too.
    """
    held = {name: getattr(variable, name) for name in PACKING if hasattr(variable, name)}
    if not held or values.dtype.kind not in "biuf":
        return values
    for name, value in held.items():
        if np.asarray(value).dtype.kind not in "biuf" or (name in SCALING and np.size(value) != 1):
            return f"numbers of which {name} is {shown(str(value))}"
    scale, offset = (float(np.ravel(held.get(name, plain))[0]) for name, plain in SCALING.items())
    found = values.astype(np.float64) * scale + offset
    with np.errstate(invalid="ignore"):  # what does not fit into the type of the numbers
        unknown = [np.ravel(held[name]).astype(values.dtype) for name in MISSING if name in held]
    for each in unknown:
        found[np.isin(values, each)] = np.nan
    return found
