"""What an archive holds: the form in which a dataset is kept, and the checksum of its content."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import re
import reprlib
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida import schema
from rotor_ida.errors import InputError

FORMAT = "rotor_ida_format"
VERSION = "rotor_ida_version"
CHECKSUM = "content_sha256"

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
    ]
)
_INSTEAD = {
    "b": "; keep it as int8 with flag_values",
    "c": "; keep its real and imaginary parts as two variables",
}


def archived_form(dataset: xr.Dataset) -> xr.Dataset:
    """Return `dataset` as it comes back from a file, with the attributes of an archive added.

    The result shares no encoding and no attributes with `dataset`, which is left as it was.

    Raises
    ------
    InputError
        For a name, a dtype or an attribute that a netCDF file cannot hold.

    Examples
    --------
    >>> kept = archived_form(xr.Dataset({"x": ("time", [1.0])}, attrs={"samples": 1}))
    >>> sorted(kept.attrs)
    ['Conventions', 'content_sha256', 'rotor_ida_format', 'rotor_ida_version', 'samples']
    """
    if not isinstance(dataset, xr.Dataset):
        raise InputError(f"dataset must be an xarray Dataset, got {type(dataset).__name__}")
    for name in (*dataset.sizes, *dataset.variables):
        _check_name("name", name, "the dataset")
    kept = xr.Dataset(
        {name: _kept_variable(str(name), dataset.variables[name]) for name in dataset.data_vars},
        {name: _kept_variable(str(name), dataset.variables[name]) for name in dataset.coords},
        _kept_attributes("the dataset", dataset.attrs),
    )
    kept.attrs.pop(CHECKSUM, None)
    kept.attrs["Conventions"] = schema.CONVENTIONS
    kept.attrs[FORMAT] = np.int64(schema.FORMAT_VERSION)
    kept.attrs.setdefault(VERSION, importlib.metadata.version("rotor-ida"))
    kept.attrs[CHECKSUM] = content_sha256(kept)
    return kept


def content_sha256(dataset: xr.Dataset) -> str:
    r"""Return the SHA-256 of all that `dataset` says, however it is stored.

    Notes
    -----
    Hashed are lines of JSON, each ended by ``\n``: first the attributes of the dataset, then each
    variable in the order of the names. An attribute, also in the order of the names, is
    ``["attribute", name, dtype, value]``, where dtype is ``"str"`` or as in ``"<f8"``, and a
    number's value is the hexadecimal of its little-endian bytes. A variable is ``["variable",
    name, whether it is a coordinate, dims, shape, dtype]``, its data, then its attributes: the data
    are the little-endian bytes in C order, or for strings one line of JSON, a list. The attribute
    ``content_sha256`` itself is left out; compression and the order of variables play no part.

    Examples
    --------
    >>> near, far = (xr.Dataset({"x": ("time", [value])}) for value in (1.0, 1.0 + 2**-52))
    >>> content_sha256(near) == content_sha256(near.copy(deep=True))
    True
    >>> content_sha256(near) == content_sha256(far)
    False
    """
    digest = hashlib.sha256()
    _add_attributes(digest, {k: v for k, v in dataset.attrs.items() if k != CHECKSUM})
    for name in sorted(str(name) for name in dataset.variables):
        variable = dataset.variables[name]
        values = np.asarray(variable.values)
        numeric = values.dtype in NUMERIC
        kind = _little_endian(values.dtype).str if numeric else "str"
        is_coordinate = name in dataset.coords
        _add_line(digest, "variable", name, is_coordinate, variable.dims, variable.shape, kind)
        if not numeric:
            _add_line(digest, values.ravel().tolist())
        elif values.size:
            stored = np.ascontiguousarray(values, dtype=kind)
            digest.update(stored.reshape(-1).view(np.uint8).data)
        _add_attributes(digest, variable.attrs)
    return digest.hexdigest()


def _add_attributes(digest: hashlib._Hash, attributes: Mapping[str, object]) -> None:
    for name in sorted(attributes):
        value = attributes[name]
        if isinstance(value, str):
            _add_line(digest, "attribute", name, "str", value)
        else:
            array = np.asarray(value)
            kind = _little_endian(array.dtype).str
            _add_line(digest, "attribute", name, kind, array.astype(kind).tobytes().hex())


def _add_line(digest: hashlib._Hash, *parts: object) -> None:
    digest.update(json.dumps(parts).encode() + b"\n")


def _little_endian(dtype: np.dtype[np.generic]) -> np.dtype[np.generic]:
    return dtype.newbyteorder("<")


def _kept_variable(name: str, variable: xr.Variable) -> xr.Variable:
    values = _kept_values(name, np.asarray(variable.values))
    attributes = _kept_attributes(f"variable {name!r}", variable.attrs)
    return xr.Variable(variable.dims, values, attributes)


def _kept_values(name: str, values: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
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


def _kept_attributes(owner: str, attributes: Mapping[str, object]) -> dict[str, object]:
    for name in attributes:
        _check_name("attribute", name, owner)
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


def _check_name(what: str, name: object, owner: str) -> None:
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
