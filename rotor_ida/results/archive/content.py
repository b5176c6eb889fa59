"""What is in an archive: which names, types and attributes a dataset may have, and gets for CF.

`archived_form` checks a dataset and adds the attributes of the content; `writing` adds date,
history and checksum; docs/archive.md lists them all. Which variables a result has is in
`rotor_ida.results.dataset_kinds`. How the file is protected, by a checksum of the content and a
seal of all bytes, is in `checksum`; `writing` makes it whole or not at all, and `reading` refuses
what is damaged, altered or too large. `rotor_ida.formats.hdf5` looks for links and parts in other
files.

Readers of netCDF that know the CF conventions but not this package see the same variables;
`stored_names` and `coordinates_of` return their names and attributes.
"""

from __future__ import annotations

import importlib.metadata
import re
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr
from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK

from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.results.rows import own_rows
from rotor_ida.schema import CONVENTIONS

# netCDF4-python and HDF5 are not thread-safe, so every call into them is made under xarray's lock,
# which also guards files that the user opened with xarray.
LOCK = NETCDF4_PYTHON_LOCK

FORMAT = "rotor_ida_format"
FORMAT_NUMBER = 3
VERSION = "rotor_ida_version"
CHECKSUM = "content_sha256"
HISTORY = "history"
CREATED = "date_created"

# Attributes that are new in each saved file.
OF_THE_FILE = frozenset([CHECKSUM, HISTORY, CREATED])
# What the checksum leaves out: who saved the content, how and when. So equal results have equal
# checksums. The command is that of the computation, and stays when the content is saved again.
NOT_IN_CHECKSUM = OF_THE_FILE | {"command"}

# The attribute of a label with the name of its coordinate.
LABEL_OF = "label_of"

NUMERIC = frozenset(
    np.dtype(kind) for kind in ("i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f4", "f8")
)

# Names as CF wants them. The reserved attributes are those by which netCDF and HDF5 keep house,
# or by which a reader alters the data.
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


def archived_form(dataset: xr.Dataset) -> xr.Dataset:
    """Return `dataset` as it is read back from a file, with the attributes of the format.

    The result shares no encoding and no attributes with `dataset`, which is not changed. Numbers
    that are not in memory are not loaded.

    Raises
    ------
    InputError
        For a name, a dtype or an attribute that a netCDF file cannot store.

    Examples
    --------
    >>> stored = archived_form(xr.Dataset({"x": ("t", [1.0])}, attrs={"samples": 1}))
    >>> sorted(stored.attrs)
    ['Conventions', 'rotor_ida_format', 'rotor_ida_version', 'samples']
    """
    if not isinstance(dataset, xr.Dataset):
        raise InputError(f"dataset must be an xarray Dataset, got {type(dataset).__name__}")
    for name in (*dataset.sizes, *dataset.variables):
        _check_name("name", name, "the dataset")
    dataset = _labels_in_place(own_rows(dataset))
    stored = xr.Dataset(
        {name: _stored_variable(str(name), dataset.variables[name]) for name in dataset.data_vars},
        {name: _stored_variable(str(name), dataset.variables[name]) for name in dataset.coords},
        _stored_attributes("the dataset", dataset.attrs),
    )
    if not isinstance(stored.attrs.get(HISTORY, ""), str):
        raise InputError(f"attribute {HISTORY!r} of the dataset must be text")
    for name in OF_THE_FILE:
        stored.attrs.pop(name, None)
    stored.attrs["Conventions"] = CONVENTIONS
    stored.attrs[FORMAT] = np.int64(FORMAT_NUMBER)
    stored.attrs.setdefault(VERSION, importlib.metadata.version("rotor-ida"))
    return stored


def stored_names(dataset: xr.Dataset) -> dict[str, str]:
    """Return the name in the file of each variable.

    In CF the coordinate of a dimension is a number. A text coordinate is stored under another name,
    as a label of the dimension.

    Examples
    --------
    >>> stored_names(xr.Dataset({"x": ("bearing", [0.0, 1.0])}, {"bearing": ["left", "right"]}))
    {'x': 'x', 'bearing': 'bearing_label'}
    """
    names = {str(name): str(name) for name in dataset.variables}
    for name in names:
        if name in dataset.dims and dataset[name].dtype.kind not in "iuf":
            label = f"{name}_label"
            while label in names or label in dataset.dims:
                label += "_"
            names[name] = label
    return names


def coordinates_of(dataset: xr.Dataset) -> tuple[dict[str, str], str]:
    """Return the attribute ``coordinates`` of each variable, and that of the file for others.

    Examples
    --------
    >>> run = xr.Dataset({"x": ("t", [0.0])}, {"omega": 1.7, "far": ("start", ["a"])})
    >>> coordinates_of(run)
    ({'x': 'omega'}, 'far')
    """
    stored = stored_names(dataset)
    others = [str(name) for name in dataset.coords if stored[str(name)] not in dataset.dims]
    named: dict[str, str] = {}
    for name, variable in dataset.data_vars.items():
        its_own = [each for each in others if set(dataset[each].dims) <= set(variable.dims)]
        if its_own:
            named[str(name)] = " ".join(sorted(stored[each] for each in its_own))
    told = {name for names in named.values() for name in names.split()}
    return named, " ".join(sorted({stored[each] for each in others} - told))


def _labels_in_place(dataset: xr.Dataset) -> xr.Dataset:
    """Turn the stored label of a dimension back into its coordinate."""
    for name, variable in dataset.variables.items():
        dim = variable.attrs.get(LABEL_OF)
        if variable.dims == (dim,) and dim not in dataset.variables:
            attributes = {k: v for k, v in variable.attrs.items() if k != LABEL_OF}
            label = xr.Variable(variable.dims, variable.values, attributes)
            dataset = dataset.drop_vars(str(name)).assign_coords({str(dim): label})
    return dataset


def _stored_variable(name: str, variable: xr.Variable) -> xr.Variable:
    attributes = _stored_attributes(f"variable {name!r}", variable.attrs)
    native = variable.dtype.newbyteorder("=")
    if native in NUMERIC and not variable._in_memory:
        stored = variable.copy(deep=False)
        stored.attrs, stored.encoding = attributes, {}
        return stored if native == variable.dtype else stored.astype(native)
    values = _stored_values(name, np.asarray(variable.values))
    return xr.Variable(variable.dims, values, attributes)


def _stored_values(name: str, values: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    """Return the values of a variable as they are read back; raise InputError if they cannot be."""
    native = values.dtype.newbyteorder("=")
    if native in NUMERIC:
        return values.astype(native, copy=False)
    texts = values.ravel().tolist()
    if values.dtype.kind not in "UOT" or not all(isinstance(text, str) for text in texts):
        held = "objects that are not strings" if values.dtype.kind == "O" else values.dtype.name
        raise InputError(
            f"variable {name!r} must contain integers, float32, float64 or strings, got {held}"
            + _INSTEAD.get(values.dtype.kind, "")
        )
    for text in texts:
        _check_text(f"variable {name!r}", text)
    return values.astype(str)


def _stored_attributes(owner: str, attributes: Mapping[str, object]) -> dict[str, object]:
    """Return attributes as they are read back; raise InputError if they cannot be."""
    for name in attributes:
        _check_name("attribute", name, owner)
        if name in _RESERVED:
            raise InputError(f"attribute {name!r} of {owner} is reserved by netCDF; rename it")
    return {name: _stored_attribute(owner, name, value) for name, value in attributes.items()}


def _stored_attribute(owner: str, name: str, value: object) -> object:
    if isinstance(value, str):
        _check_text(f"attribute {name!r} of {owner}", value)
        return str(value)
    if isinstance(value, (int, float, np.number, np.ndarray)) and not isinstance(value, bool):
        array = np.asarray(value)
        native = array.dtype.newbyteorder("=")
        if native in NUMERIC and array.ndim <= 1:
            # netCDF does not distinguish an array of one number from the number.
            return array.reshape(-1).astype(native)[0] if array.size == 1 else array.astype(native)
    raise InputError(
        f"attribute {name!r} of {owner} must be a string, a number or a one-dimensional numeric "
        f"array, got {shown(value)}"
    )


def _check_name(what: str, name: object, owner: str) -> None:
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
        raise InputError(f"{owner} must not contain the character NUL, got {text!a}")
