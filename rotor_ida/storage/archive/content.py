"""What an archive holds: the form in which a dataset is kept, and the checksum of its content."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida import schema
from rotor_ida.errors import InputError
from rotor_ida.storage.archive.conventions import COMMAND, CREATED, DOMAIN, HISTORY, LABEL_OF
from rotor_ida.storage.archive.holdable import NUMERIC, check_name, kept_attributes, kept_values
from rotor_ida.storage.archive.slabs import is_in_memory, slabs

FORMAT = "rotor_ida_format"
VERSION = "rotor_ida_version"
CHECKSUM = "content_sha256"

# Given anew to each file that is saved.
_OF_THE_FILE = frozenset([CHECKSUM, HISTORY, CREATED])

# What the checksum leaves out in each format: in the second, who asked for the content and when,
# so that what was computed alike has one checksum.
_NOT_CONTENT = {1: frozenset([CHECKSUM]), 2: _OF_THE_FILE | {COMMAND}}


def archived_form(dataset: xr.Dataset) -> xr.Dataset:
    """Return `dataset` as it comes back from a file, with the attributes of the format.

    The result shares no encoding and no attributes with `dataset`, which is left as it was.
    Numbers that are not in memory stay where they are.

    Raises
    ------
    InputError
        For a name, a dtype or an attribute that a netCDF file cannot hold.

    Examples
    --------
    >>> kept = archived_form(xr.Dataset({"x": ("t", [1.0])}, attrs={"samples": 1}))
    >>> sorted(kept.attrs)
    ['Conventions', 'rotor_ida_format', 'rotor_ida_version', 'samples']
    """
    if not isinstance(dataset, xr.Dataset):
        raise InputError(f"dataset must be an xarray Dataset, got {type(dataset).__name__}")
    for name in (*dataset.sizes, *dataset.variables):
        check_name("name", name, "the dataset")
    dataset = _as_load_gives_it(dataset)
    kept = xr.Dataset(
        {name: _kept_variable(str(name), dataset.variables[name]) for name in dataset.data_vars},
        {name: _kept_variable(str(name), dataset.variables[name]) for name in dataset.coords},
        kept_attributes("the dataset", dataset.attrs),
    )
    if not isinstance(kept.attrs.get(HISTORY, ""), str):
        raise InputError(f"attribute {HISTORY!r} of the dataset must be text")
    for name in _OF_THE_FILE:
        kept.attrs.pop(name, None)
    kept.attrs["Conventions"] = schema.CONVENTIONS
    kept.attrs[FORMAT] = np.int64(schema.FORMAT_VERSION)
    kept.attrs.setdefault(VERSION, importlib.metadata.version("rotor-ida"))
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
    ``content_sha256`` itself is left out, and from format 2 on ``history``, ``date_created`` and
    ``command``; compression and the order of variables play no part. Numbers that are not in
    memory are read slab by slab.

    Examples
    --------
    >>> near, far = (xr.Dataset({"x": ("t", [value])}) for value in (1.0, 1.0 + 2**-52))
    >>> content_sha256(near) == content_sha256(near.copy(deep=True))
    True
    >>> content_sha256(near) == content_sha256(far)
    False
    """
    digest = ContentDigest(dataset)
    for name in digest.names:
        digest.begin(name)
        variable = dataset.variables[name]
        if variable.dtype not in NUMERIC:
            digest.add_texts(variable.values)
        else:
            for _, values in slabs(variable):
                digest.add_numbers(values)
                del values  # before the next are read
        digest.end(name)
    return digest.hexdigest()


class ContentDigest:
    """The checksum of `content_sha256`, made while the content passes by.

    Parameters
    ----------
    dataset : xr.Dataset
        What is hashed.
    """

    def __init__(self, dataset: xr.Dataset) -> None:
        self.names = sorted(str(name) for name in dataset.variables)
        self._dataset = dataset
        self._digest = hashlib.sha256()
        version = 1 if dataset.attrs.get(FORMAT, 1) == 1 else 2
        told = {k: v for k, v in dataset.attrs.items() if k not in _NOT_CONTENT[version]}
        _add_attributes(self._digest, told)

    def begin(self, name: str) -> None:
        """Take in what a variable is; its values follow, then `end`."""
        variable = self._dataset.variables[name]
        numeric = variable.dtype in NUMERIC
        kind = _little_endian(variable.dtype).str if numeric else "str"
        is_coordinate = name in self._dataset.coords
        _add_line(
            self._digest, "variable", name, is_coordinate, variable.dims, variable.shape, kind
        )

    def add_numbers(self, values: npt.NDArray[np.generic]) -> None:
        """Take in numbers, in C order."""
        stored = np.ascontiguousarray(values, dtype=_little_endian(values.dtype))
        self._digest.update(stored.reshape(-1).view(np.uint8).data)

    def add_texts(self, values: npt.NDArray[np.generic]) -> None:
        """Take in all texts of the variable."""
        _add_line(self._digest, values.ravel().tolist())

    def end(self, name: str) -> None:
        """Take in the attributes of the variable."""
        _add_attributes(self._digest, self._dataset.variables[name].attrs)

    def hexdigest(self) -> str:
        """Return the checksum of what was taken in."""
        return self._digest.hexdigest()


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


def _as_load_gives_it(dataset: xr.Dataset) -> xr.Dataset:
    """Take back what other readers of an archive show: the domain variable, names of labels."""
    domain = dataset.variables.get(DOMAIN)
    if DOMAIN in dataset.sizes or (domain is not None and "dimensions" not in domain.attrs):
        raise InputError(f"the name {DOMAIN!r} is reserved for archives; rename it")
    dataset = dataset.drop_vars(DOMAIN, errors="ignore")
    for name, variable in dataset.variables.items():
        dim = variable.attrs.get(LABEL_OF)
        if variable.dims == (dim,) and dim not in dataset.variables:
            attributes = {k: v for k, v in variable.attrs.items() if k != LABEL_OF}
            label = xr.Variable(variable.dims, variable.values, attributes)
            dataset = dataset.drop_vars(str(name)).assign_coords({str(dim): label})
    return dataset


def _kept_variable(name: str, variable: xr.Variable) -> xr.Variable:
    attributes = kept_attributes(f"variable {name!r}", variable.attrs)
    native = variable.dtype.newbyteorder("=")
    if native in NUMERIC and not is_in_memory(variable):
        kept = variable.copy(deep=False)
        kept.attrs, kept.encoding = attributes, {}
        return kept if native == variable.dtype else kept.astype(native)
    values = kept_values(name, np.asarray(variable.values))
    return xr.Variable(variable.dims, values, attributes)
