"""What variables of a dataset say: rows for programs, and tables and words for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from rich.console import RenderableType

from rotor_ida.cli.report import table
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.schema import NO_YES, RESULT_KIND, flags_of, words_of

Record = dict[str, object]
Description = tuple[Record, list[RenderableType]]
METHOD = ("method", "flight", "backend", "rtol", "atol")
VERSION = "_version"
# What an archive adds for its own use, and what is shown as the kind.
HOUSEKEEPING = ("Conventions", "content_sha256", "rotor_ida_format", RESULT_KIND)

SPEEDS = ("speed", "event_speed")


def rows_of(dataset: xr.Dataset, names: Sequence[str]) -> list[Record]:
    """Return one record for each element of the first variable named, the others spread on it.

    Flags become their words, or true and false where the words are yes and no.

    Examples
    --------
    >>> from rotor_ida import synchronous_response
    >>> whirls = synchronous_response(omega=[0.5, 1.0], zeta=0.5, delta0=2.0)
    >>> rows_of(whirls, ["stability", "omega"])
    [{'stability': 'neutral', 'omega': 0.5}, {'stability': 'neutral', 'omega': 1.0}]
    """
    if not names:
        return []
    first = dataset[names[0]]
    columns = [values_of(spread_on(dataset, name, first)) for name in names]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def value_of(dataset: xr.Dataset, name: str) -> object:
    """Return a scalar variable, in words if it is a flag."""
    (value,) = values_of(dataset[name])
    return value


def names_on(dataset: xr.Dataset, *dims: str) -> list[str]:
    """Return the variables that stand on just these dimensions."""
    return [str(name) for name, variable in dataset.data_vars.items() if variable.dims == dims]


def attributes_of(dataset: xr.Dataset) -> Record:
    """Return where a dataset came from: method, versions, and what else its attributes say."""
    plain = {
        str(name): value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
        for name, value in dataset.attrs.items()
        if name not in HOUSEKEEPING
    }
    record: Record = {}
    method = {name: plain.pop(name) for name in METHOD if name in plain}
    versions = {
        name.removesuffix(VERSION): plain.pop(name)
        for name in list(plain)
        if name.endswith(VERSION)
    }
    if method:
        record["method"] = method
    if versions:
        record["versions"] = versions
    return {**plain, **record}


def about(dataset: xr.Dataset) -> Record:
    """Return what the attributes of a dataset say beside its parameters."""
    attributes = attributes_of(dataset)
    return {name: entry for name, entry in attributes.items() if name not in ALL_PARAMETERS}


def parameters_in(dataset: xr.Dataset) -> Record:
    """Return the parameters that a result has, each as a number or, along an axis, as a list."""
    told = [name for name in ALL_PARAMETERS if name in dataset.variables]
    return {name: dataset[name].values.tolist() for name in told}


def with_unit(dataset: xr.Dataset, name: str) -> str:
    """Return a variable's name with its unit, if it has one; angles are in radians."""
    if name == "duration" and "time_scale" in dataset.attrs:
        unit = dataset["t"].attrs["units"]
    elif name not in dataset.variables:
        unit = "1"
    else:
        unit = dataset[name].attrs.get("units", "1")
    if name in SPEEDS and unit == "s-1":
        unit = "rad/s"
    return name.replace("_", " ") + (f" [{unit}]" if unit not in {"", "1", "radian"} else "")


def span(values: np.ndarray[Any, Any], digits: int) -> str:
    """Return the range of those values that are known, in words; nothing where none is."""
    known = values[np.isfinite(values)]
    return f"{known.min():.{digits}g} to {known.max():.{digits}g}" if known.size else ""


def rows_table(
    title: str,
    rows: Sequence[Record],
    columns: Sequence[str],
    most: int | None,
    *,
    prefix: str = "",
    digits: int = 8,
) -> list[RenderableType]:
    """Return rows as a table, of at most so many, headed by how many there are."""
    if not rows:
        return [f"{title}: none"]
    counted = f"{title}: {len(rows)}"
    if most is not None and len(rows) > most:
        counted = f"{title}: first {most} of {len(rows)} (all with --json)"
    return [table(counted, rows[:most], columns, prefix=prefix, digits=digits)]


def spread_on(dataset: xr.Dataset, name: str, other: xr.DataArray) -> xr.DataArray:
    """Return a variable on the dimensions of another."""
    return dataset[name].broadcast_like(other).transpose(*other.dims)


def values_of(variable: xr.DataArray) -> list[Any]:
    """Return the values of a variable one after the other, in words if it is a flag."""
    if "flag_meanings" not in variable.attrs:
        return list(variable.values.ravel().tolist())
    words = words_of(variable)
    return [word == "yes" for word in words] if flags_of(variable) == NO_YES else words
