"""What an archive can hold: names, values and attributes, in the form in which they come back."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from rotor_ida.errors import InputError
from rotor_ida.storage.archive.conventions import LABEL_OF

NUMERIC = frozenset(
    np.dtype(kind) for kind in ("i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f4", "f8")
)

# Names as CF wants them. The reserved attributes are those by which netCDF and HDF5 keep house,
# or which tell a reader to alter the data.
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,199}")
_RESERVED = frozenset(
    [
        "CLASS",
        "NAME",
        "DIMENSION_LIST",
        "DIMENSION_LABELS",
        "REFERENCE_LIST",
        "coordinates",
        "missing_value",
        "scale_factor",
        "add_offset",
        "dtype",
        LABEL_OF,
    ]
)
_INSTEAD = {
    "b": "; keep it as int8 with flag_values",
    "c": "; keep its real and imaginary parts as two variables",
}


def kept_values(name: str, values: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    """Return the values of a variable as they come back; raise InputError if they cannot."""
    native = values.dtype.newbyteorder("=")
    if native in NUMERIC:
        return values.astype(native, copy=False)
    texts = values.ravel().tolist()
    if values.dtype.kind not in "UOT" or not all(isinstance(text, str) for text in texts):
        held = "objects that are not strings" if values.dtype.kind == "O" else values.dtype.name
        raise InputError(
            f"variable {name!r} must hold integers, float32, float64 or strings, got {held}"
            + _INSTEAD.get(values.dtype.kind, "")
        )
    for text in texts:
        _check_text(f"variable {name!r}", text)
    return values.astype(str)


def kept_attributes(owner: str, attributes: Mapping[str, object]) -> dict[str, object]:
    """Return attributes as they come back; raise InputError if they cannot."""
    for name in attributes:
        check_name("attribute", name, owner)
        if name in _RESERVED:
            raise InputError(f"attribute {name!r} of {owner} is reserved by netCDF; rename it")
    return {name: _kept_attribute(owner, name, value) for name, value in attributes.items()}


def _kept_attribute(owner: str, name: str, value: object) -> object:
    if isinstance(value, str):
        _check_text(f"attribute {name!r} of {owner}", value)
        return str(value)
    if isinstance(value, (int, float, np.number, np.ndarray)) and not isinstance(value, bool):
        array = np.asarray(value)
        native = array.dtype.newbyteorder("=")
        if native in NUMERIC and array.ndim <= 1:
            # netCDF does not tell an array of one number from the number.
            return array.reshape(-1).astype(native)[0] if array.size == 1 else array.astype(native)
    raise InputError(
        f"attribute {name!r} of {owner} must be a string, a number or a one-dimensional numeric "
        f"array, got {' '.join(reprlib.repr(value).split())}"
    )


def check_name(what: str, name: object, owner: str) -> None:
    """Raise InputError for a name that CF or netCDF does not allow."""
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise InputError(
            f"{what} {name!r} of {owner} must be a letter followed by letters, digits or "
            "underscores, 200 at most"
        )


def _check_text(owner: str, text: str) -> None:
    try:
        text.encode()
    except UnicodeEncodeError:
        raise InputError(f"{owner} must be valid Unicode text, got {text!a}") from None
    if "\0" in text:
        raise InputError(f"{owner} must not hold the character NUL, got {text!a}")
